//! The plan of a sweep: what is run, over which grid.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value as Json};
use terra_data::{Rover, Start, read_rover};
use terra_model::{Registry, catalogue, nearest};
use terra_sim::Scenario;
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use crate::challenge::random::Draws;
use crate::error::CliError;

/// What each run does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Task {
    Identify,
    Gap,
    Simulate,
}

const TASKS: [(&str, Task); 3] = [
    ("identify", Task::Identify),
    ("gap", Task::Gap),
    ("simulate", Task::Simulate),
];

/// A scenario key and its values.
#[derive(Clone, Debug)]
struct Axis {
    key: String,
    values: Vec<Value>,
    place: usize,
}

/// A plan, checked: every point of its grid is a scenario.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) task: Task,
    pub(crate) rover: Rover,
    pub(crate) rover_file: PathBuf,
    pub(crate) scenario_file: PathBuf,
    seed: u64,
    runs: u64,
    axes: Vec<Axis>,
    scenario: Table,
}

/// Runs i, i + n, i + 2n, ... of n shards, i from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    index: u64,
    of: u64,
}

impl Shard {
    pub(crate) const ALL: Shard = Shard { index: 1, of: 1 };

    /// Reads `i/n`.
    pub(crate) fn parse(text: &str) -> Result<Self, CliError> {
        text.split_once('/')
            .and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)))
            .filter(|(index, of): &(u64, u64)| (1..=*of).contains(index))
            .map(|(index, of)| Shard { index, of })
            .ok_or_else(|| {
                CliError::usage(
                    format!("--shard {text}: expected i/n with i from 1 to n"),
                    "--shard 1/4",
                )
            })
    }

    /// Its runs of `total`.
    pub(crate) fn runs(self, total: u64) -> impl Iterator<Item = u64> {
        (self.index - 1..total).step_by(usize::try_from(self.of).unwrap_or(usize::MAX))
    }
}

/// One run of a plan.
pub(crate) struct Run {
    pub(crate) seed: u64,
    pub(crate) vary: Json,
    pub(crate) scenario: Scenario,
}

/// The text of a plan and its name, for messages.
struct Source<'a> {
    text: &'a str,
    file: String,
}

impl Source<'_> {
    fn error(&self, at: usize, message: impl std::fmt::Display) -> CliError {
        let before = self.text.get(..at).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let line = before.matches('\n').count() + 1;
        let column = before.get(line_start..).unwrap_or("").chars().count() + 1;
        CliError::Usage {
            message: format!("{}:{line}:{column}: {message}", self.file),
            help: None,
        }
    }
}

const KEYS: [&str; 5] = ["command", "scenario", "runs", "seed", "vary"];
/// Runs before a plan is refused: a slip of the pen in a grid.
const MAX_RUNS: u64 = 100_000_000;

impl Plan {
    /// Reads a plan, its scenario and its rover file, and tries every value of every key.
    ///
    /// # Errors
    /// Configuration errors with file, line and column.
    pub(crate) fn read(path: &Path) -> Result<Self, CliError> {
        let text = std::fs::read_to_string(path).map_err(|e| {
            CliError::usage(
                format!("{}: cannot be read: {e}", path.display()),
                "terra sweep PLAN.toml --out FILE",
            )
        })?;
        let source = Source {
            text: &text,
            file: path.display().to_string(),
        };
        let placed = DeTable::parse(&text)
            .map_err(|e| source.error(e.span().map_or(0, |s| s.start), e.message()))?;
        let values: Table = toml::from_str(&text).map_err(|e| source.error(0, e.message()))?;
        let placed = placed.get_ref();
        for (key, _) in placed.iter() {
            let name = key.get_ref().as_ref();
            if !KEYS.contains(&name) {
                let hint = match nearest(name, KEYS) {
                    Some(near) => format!("did you mean '{near}'?"),
                    None => format!("expected one of {}", KEYS.join(", ")),
                };
                return Err(source.error(key.span().start, format!("unknown key '{name}', {hint}")));
            }
        }
        let at = |key: &str| placed.get(key).map_or(0, |v| v.span().start);
        let required = |key: &str| {
            values
                .get(key)
                .ok_or_else(|| source.error(0, format!("missing key '{key}'")))
        };
        let text_of = |key: &str| {
            required(key)?
                .as_str()
                .ok_or_else(|| source.error(at(key), format!("{key}: expected text")))
        };
        let whole = |key: &str, from: u64| -> Result<u64, CliError> {
            required(key)?
                .as_integer()
                .and_then(|i| u64::try_from(i).ok())
                .filter(|i| *i >= from)
                .ok_or_else(|| {
                    source.error(
                        at(key),
                        format!("{key}: expected a whole number from {from}"),
                    )
                })
        };
        let command = text_of("command")?;
        let task = TASKS
            .iter()
            .find(|(name, _)| *name == command)
            .map(|(_, task)| *task)
            .ok_or_else(|| {
                source.error(
                    at("command"),
                    format!("command '{command}', expected one of identify, gap, simulate"),
                )
            })?;
        let (runs, seed) = (whole("runs", 1)?, whole("seed", 0)?);
        let mut axes = vec![];
        if let Some(vary) = values.get("vary") {
            let table = vary
                .as_table()
                .ok_or_else(|| source.error(at("vary"), "vary: expected a table"))?;
            let spans = placed.get("vary").and_then(|v| v.get_ref().as_table());
            collect(&source, table, spans, "", at("vary"), &mut axes)?;
        }
        let scenario_file = path
            .parent()
            .unwrap_or(Path::new(""))
            .join(text_of("scenario")?);
        let base = Scenario::read(&scenario_file)?;
        let rover_file = base.rover_path(&scenario_file);
        let rover = read_rover(&rover_file)?;
        let scenario_text =
            std::fs::read_to_string(&scenario_file).map_err(|e| CliError::BadData {
                message: format!("{}: cannot be read: {e}", scenario_file.display()),
                help: None,
            })?;
        let scenario: Table = toml::from_str(&scenario_text)
            .map_err(|e| source.error(at("scenario"), e.message()))?;
        let plan = Plan {
            task,
            rover,
            rover_file,
            scenario_file,
            seed,
            runs,
            axes,
            scenario,
        };
        let points = plan
            .axes
            .iter()
            .try_fold(runs, |n, a| n.checked_mul(a.values.len() as u64))
            .filter(|n| *n <= MAX_RUNS);
        if points.is_none() {
            return Err(source.error(at("vary"), format!("more than {MAX_RUNS} runs")));
        }
        let registry = Registry::builtin();
        known(&base, &registry).map_err(|e| e.within(&plan.scenario_file))?;
        for axis in &plan.axes {
            for value in &axis.values {
                let mut table = plan.scenario.clone();
                set(&mut table, &axis.key, value)
                    .and_then(|()| plan.parse(&table).map_err(|e| e.to_string()))
                    .and_then(|scenario| known(&scenario, &registry).map_err(|e| e.to_string()))
                    .map_err(|why| {
                        source.error(axis.place, format!("{} = {value}: {why}", axis.key))
                    })?;
            }
        }
        Ok(plan)
    }

    /// Number of runs.
    pub(crate) fn total(&self) -> u64 {
        self.axes
            .iter()
            .fold(self.runs, |n, a| n.saturating_mul(a.values.len() as u64))
    }

    /// What identifies a run in a file: its seed and its point of the grid.
    pub(crate) fn label(&self, run: u64) -> (u64, Json) {
        let mut vary = Map::new();
        for (axis, value) in self.point(run) {
            let value = serde_json::to_value(value).unwrap_or(Json::Null);
            vary.insert(axis.key.clone(), value);
        }
        (Draws::new(self.seed, run).seed(), Json::Object(vary))
    }

    /// The values of each key at a run: the last key changes first.
    fn point(&self, run: u64) -> Vec<(&Axis, &Value)> {
        let mut rest = run / self.runs;
        let mut out: Vec<(&Axis, &Value)> = self
            .axes
            .iter()
            .rev()
            .filter_map(|axis| {
                let n = axis.values.len() as u64;
                let value = axis.values.get(usize::try_from(rest % n).ok()?)?;
                rest /= n;
                Some((axis, value))
            })
            .collect();
        out.reverse();
        out
    }

    /// One run.
    ///
    /// # Errors
    /// Values that make no scenario together.
    pub(crate) fn run(&self, run: u64) -> Result<Run, CliError> {
        let mut table = self.scenario.clone();
        for (axis, value) in self.point(run) {
            set(&mut table, &axis.key, value).map_err(|why| CliError::Usage {
                message: why,
                help: None,
            })?;
        }
        let mut scenario = self.parse(&table)?;
        let (seed, vary) = self.label(run);
        scenario.seed = seed;
        Ok(Run {
            seed,
            vary,
            scenario,
        })
    }

    fn parse(&self, table: &Table) -> Result<Scenario, CliError> {
        let name = self.scenario_file.display().to_string();
        let text = toml::to_string(table).map_err(|e| CliError::Usage {
            message: e.to_string(),
            help: None,
        })?;
        Ok(Scenario::parse(&text, &name)?)
    }
}

/// Every name of a scenario is known: a slip of the pen should not be found after hours of runs.
fn known(scenario: &Scenario, registry: &Registry) -> Result<(), CliError> {
    registry.model(&scenario.model)?;
    for soil in [&scenario.left, &scenario.right] {
        if let Start::Id(id) = soil {
            catalogue::find(id)?;
        }
    }
    for effect in &scenario.effects {
        match &effect.form {
            Some(form) => registry.effect_form(&effect.name, form)?,
            None => registry.effect(&effect.name)?,
        };
    }
    Ok(())
}

/// Dotted keys with lists of values, nested tables or not, in the order of the alphabet.
fn collect(
    source: &Source<'_>,
    table: &Table,
    spans: Option<&DeTable<'_>>,
    prefix: &str,
    outer: usize,
    axes: &mut Vec<Axis>,
) -> Result<(), CliError> {
    for (name, value) in table {
        let span: Option<&Spanned<DeValue<'_>>> = spans.and_then(|s| s.get(name.as_str()));
        let place = span.map_or(outer, |s| s.span().start);
        let key = if prefix.is_empty() {
            name.clone()
        } else {
            format!("{prefix}.{name}")
        };
        match value {
            Value::Table(inner) => {
                let spans = span.and_then(|s| s.get_ref().as_table());
                collect(source, inner, spans, &key, place, axes)?;
            }
            Value::Array(values) if values.is_empty() => {
                return Err(source.error(place, format!("{key}: expected at least one value")));
            }
            Value::Array(values) => axes.push(Axis {
                key,
                values: values.clone(),
                place,
            }),
            other => {
                return Err(source.error(
                    place,
                    format!(
                        "{key}: expected a list of values, found {}",
                        other.type_str()
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// Puts a value at a dotted key; a number steps into a list.
fn set(table: &mut Table, key: &str, value: &Value) -> Result<(), String> {
    let (path, last) = match key.rsplit_once('.') {
        Some((path, last)) => (path, last),
        None => ("", key),
    };
    let mut root = Value::Table(std::mem::take(table));
    let outcome = (|| {
        let mut at = &mut root;
        let mut walked = String::new();
        for part in path.split('.').filter(|p| !p.is_empty()) {
            at = step(at, part, &walked)?;
            walked = if walked.is_empty() {
                part.to_owned()
            } else {
                format!("{walked}.{part}")
            };
        }
        match at {
            Value::Table(inner) => {
                inner.insert(last.to_owned(), value.clone());
                Ok(())
            }
            Value::Array(_) => {
                *step(at, last, &walked)? = value.clone();
                Ok(())
            }
            _ => Err(format!("{walked} holds no keys")),
        }
    })();
    if let Value::Table(inner) = root {
        *table = inner;
    }
    outcome
}

fn step<'v>(at: &'v mut Value, part: &str, walked: &str) -> Result<&'v mut Value, String> {
    match at {
        Value::Table(inner) => inner
            .get_mut(part)
            .ok_or_else(|| format!("the scenario has no {part} in '{walked}'")),
        Value::Array(items) => {
            let n = items.len();
            part.parse::<usize>()
                .ok()
                .and_then(|k| items.get_mut(k))
                .ok_or_else(|| {
                    format!(
                        "{walked} has {n} entries, 0 to {}; there is no {part}",
                        n.saturating_sub(1)
                    )
                })
        }
        _ => Err(format!("{walked} holds no keys")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dotted_key_steps_into_tables_and_lists() {
        let mut table: Table =
            toml::from_str("a = 1\n[[effect]]\nmagnitude = 0.1\n[b]\nc = [1, 2]\n").unwrap();
        set(&mut table, "effect.0.magnitude", &Value::Float(0.5)).unwrap();
        set(&mut table, "b.c.1", &Value::Integer(7)).unwrap();
        set(&mut table, "a", &Value::Integer(2)).unwrap();
        let expected: Table =
            toml::from_str("a = 2\n[[effect]]\nmagnitude = 0.5\n[b]\nc = [1, 7]\n").unwrap();
        assert_eq!(table, expected);
        for key in ["effect.1.magnitude", "nothing.x", "a.b"] {
            assert!(set(&mut table, key, &Value::Integer(1)).is_err(), "{key}");
        }
        assert_eq!(table, expected);
    }

    #[test]
    fn shards_part_the_runs() {
        let mut all: Vec<u64> = (1..=3)
            .flat_map(|i| Shard::parse(&format!("{i}/3")).unwrap().runs(10))
            .collect();
        all.sort_unstable();
        assert_eq!(all, (0..10).collect::<Vec<u64>>());
        for bad in ["0/3", "4/3", "1", "a/b", "1/0", "-1/2"] {
            assert_eq!(Shard::parse(bad).unwrap_err().exit_code(), 2, "{bad}");
        }
    }
}
