//! What `terra identify` weighs: a catalogue set, a file of soils, or a plan that makes sets and joins them.
//!
//! A plan is a TOML file of `[[set]]` tables. Each names a catalogue set or a file of soils (`hypotheses`) or a soil to
//! start from (`start`), and may perturb, grid or sample it:
//!
//! ```toml
//! [[set]]
//! hypotheses = "wong21"                       # a catalogue set or a .csv file
//! perturb = { copies = 5, sd = 0.1 }          # joined to the soils themselves
//! [[set]]
//! name = "clay"
//! model = "wong-reece+slip-sinkage"           # default: the rover file's
//! start = "lean_clay_22"                      # a soil, or a table of parameters
//! grid = [ { parameter = "cohesion", from = 1e4, to = 8e4, points = 8 } ]
//! [[set]]
//! name = "sand"
//! start = "dry_sand"
//! seed = 3
//! latin_hypercube = { count = 200, axes = [ { parameter = "friction_angle", from = 0.4, to = 0.7 } ] }
//! ```

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;
use terra_data::{Rover, TerrainSettings, hypothesis_terrains};
use terra_mme::{
    Axis, Centre, FitSpace, Hypothesis, HypothesisSet, MOST_HYPOTHESES, NearDuplicate, Priors,
};
use terra_model::{Contact, ForceLaw, Law, Registry, catalogue};

use crate::error::CliError;

/// Relative difference of forces below which two hypotheses are one.
const TWINS: f64 = 1e-3;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Plan {
    set: Vec<Entry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: Option<String>,
    model: Option<String>,
    hypotheses: Option<String>,
    start: Option<Soil>,
    perturb: Option<Perturb>,
    grid: Option<Vec<GridAxis>>,
    latin_hypercube: Option<Hypercube>,
    #[serde(default)]
    seed: u64,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Soil {
    Id(String),
    Values(BTreeMap<String, f64>),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Perturb {
    copies: usize,
    #[serde(default = "tenth")]
    sd: f64,
}

fn tenth() -> f64 {
    0.1
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GridAxis {
    parameter: String,
    from: f64,
    to: f64,
    points: usize,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RangeAxis {
    parameter: String,
    from: f64,
    to: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Hypercube {
    count: usize,
    axes: Vec<RangeAxis>,
}

/// The set that `[terrain] hypotheses` of a rover file names, relative to `folder`; `named` takes its place when given
/// and is relative to where the command runs.
pub(crate) fn hypotheses(
    rover: &Rover,
    registry: &Registry,
    folder: &Path,
    named: Option<&str>,
) -> Result<HypothesisSet, CliError> {
    let (source, folder) = match named {
        Some(named) => (named, Path::new("")),
        None => (rover.terrain.hypotheses.as_str(), folder),
    };
    let is_plan = Path::new(source)
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    if !is_plan {
        let law = Arc::new(registry.law(&rover.terrain.model)?);
        return soils(&rover.terrain, &law, source, folder);
    }
    let path = folder.join(source);
    let text = std::fs::read_to_string(&path).map_err(|e| {
        CliError::usage(
            format!("{}: cannot be read: {e}", path.display()),
            "a catalogue set, a .csv file of soils, or a .toml plan of sets",
        )
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    plan(&text, rover, registry, folder).map_err(|e| e.within(&path))
}

fn soils(
    settings: &TerrainSettings,
    law: &Arc<Law>,
    source: &str,
    folder: &Path,
) -> Result<HypothesisSet, CliError> {
    let settings = TerrainSettings {
        hypotheses: source.to_owned(),
        ..settings.clone()
    };
    let terrains = hypothesis_terrains(&settings, folder)?;
    Ok(HypothesisSet::from_terrains(law, &terrains)?)
}

fn plan(
    text: &str,
    rover: &Rover,
    registry: &Registry,
    folder: &Path,
) -> Result<HypothesisSet, CliError> {
    let refuse = |message: String| CliError::usage(message, "see `terra identify --help`");
    let plan: Plan = toml::from_str(text).map_err(|e| refuse(e.to_string()))?;
    let mut all: Vec<Hypothesis> = vec![];
    let mut first_model = None;
    for (k, entry) in plan.set.iter().enumerate() {
        let model = entry.model.as_ref().unwrap_or(&rover.terrain.model);
        let law = Arc::new(registry.law(model)?);
        let named = |e: CliError| match e {
            CliError::Usage { message, help } => CliError::Usage {
                message: format!("[[set]] {}: {message}", k + 1),
                help,
            },
            other => other,
        };
        let set = entry_set(entry, rover, &law, folder, k).map_err(named)?;
        // A soil may stand in the set once under each law.
        let set = if first_model.get_or_insert(law.name()) == &law.name() {
            set
        } else {
            let named = set.hypotheses().iter().map(|h| Hypothesis {
                id: format!("{}@{model}", h.id),
                ..h.clone()
            });
            HypothesisSet::new(named.collect())?
        };
        // Each set is bounded by itself; together they are bounded here.
        let together = all.len() + set.len();
        if together > MOST_HYPOTHESES {
            return Err(refuse(format!(
                "[[set]] {}: {together} hypotheses with those before it, expected at most {MOST_HYPOTHESES}",
                k + 1
            )));
        }
        all.extend_from_slice(set.hypotheses());
    }
    if all.is_empty() {
        return Err(refuse("no [[set]]".to_owned()));
    }
    Ok(HypothesisSet::new(all)?)
}

fn entry_set(
    entry: &Entry,
    rover: &Rover,
    law: &Arc<Law>,
    folder: &Path,
    k: usize,
) -> Result<HypothesisSet, CliError> {
    let refuse = |message: &str| CliError::usage(message, "see `terra identify --help`");
    let prefix = match (&entry.name, &entry.start) {
        (Some(name), _) => name.clone(),
        (None, Some(Soil::Id(id))) => id.clone(),
        _ => format!("set-{}", k + 1),
    };
    let base = match (&entry.hypotheses, &entry.start) {
        (Some(source), None) => soils(&rover.terrain, law, source, folder)?,
        (None, Some(soil)) => {
            let p = match soil {
                Soil::Id(id) => centre(law, Centre::Terrain(catalogue::find(id)?), rover)?,
                Soil::Values(values) => centre(law, Centre::Values(values), rover)?,
            };
            HypothesisSet::new(vec![Hypothesis {
                id: prefix.clone(),
                law: Arc::clone(law),
                parameters: p,
            }])?
        }
        _ => return Err(refuse("exactly one of hypotheses and start")),
    };
    let only = || match base.hypotheses() {
        [one] => Ok(one.parameters.as_slice()),
        _ => Err(refuse("a grid and a latin_hypercube begin at one start")),
    };
    let made = match (&entry.grid, &entry.latin_hypercube) {
        (None, None) => base,
        (Some(axes), None) => {
            let axes: Vec<(Axis, usize)> = axes
                .iter()
                .map(|a| (Axis::new(&a.parameter, a.from, a.to), a.points))
                .collect();
            HypothesisSet::grid(law, &prefix, only()?, &axes)?
        }
        (None, Some(cube)) => {
            let axes: Vec<Axis> = cube
                .axes
                .iter()
                .map(|a| Axis::new(&a.parameter, a.from, a.to))
                .collect();
            HypothesisSet::latin_hypercube(law, &prefix, only()?, &axes, cube.count, entry.seed)?
        }
        _ => return Err(refuse("one of grid and latin_hypercube, not both")),
    };
    Ok(match &entry.perturb {
        Some(p) => {
            let copies = made.perturbed(p.copies, p.sd, entry.seed)?;
            made.joined(copies)?
        }
        None => made,
    })
}

/// The law's parameters at a soil or at named values, `k_eq` for the rover's wheel.
fn centre(law: &Law, at: Centre<'_>, rover: &Rover) -> Result<Vec<f64>, CliError> {
    let space = FitSpace::new(law, at, &[rover.wheel.width], &Priors::default())?;
    Ok(space.start().to_vec())
}

/// Pairs of the set that no force tells apart on wheels of this rover: together they hold the prior of two.
pub(crate) fn twins(set: &HypothesisSet, rover: &Rover) -> Vec<NearDuplicate> {
    let load = rover
        .vehicle
        .map_or(100.0, |v| 0.25 * v.mass * terra_sim::GRAVITY);
    let probes: Vec<Contact<f64>> = [(0.1, 1.0), (0.4, 0.7), (0.4, 1.3), (0.9, 1.0)]
        .map(|(slip, share)| {
            Contact::new(slip, share * load, rover.wheel.radius, rover.wheel.width)
        })
        .to_vec();
    set.near_duplicates(&probes, TWINS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terra_sim::paper;

    fn read(text: &str) -> Result<HypothesisSet, CliError> {
        plan(
            text,
            &paper::light_rover(),
            &Registry::builtin(),
            Path::new(""),
        )
    }

    /// 21 soils, 2 copies of each, a grid of 3 x 2, a cube of 5 under another law.
    #[test]
    fn a_plan_joins_what_its_tables_make() {
        let set = read(
            r#"
            [[set]]
            hypotheses = "wong21"
            perturb = { copies = 2 }
            [[set]]
            name = "clay"
            start = "lean_clay_22"
            grid = [
              { parameter = "cohesion", from = 1e4, to = 8e4, points = 3 },
              { parameter = "friction_angle", from = 0.1, to = 0.3, points = 2 },
            ]
            [[set]]
            model = "wong-reece+slip-sinkage"
            start = "dry_sand"
            latin_hypercube = { count = 5, axes = [{ parameter = "friction_angle", from = 0.4, to = 0.7 }] }
            "#,
        )
        .unwrap();
        assert_eq!(set.len(), 21 + 42 + 6 + 5);
        assert_eq!(set.structures().len(), 2);
        let ids = set.ids();
        for id in [
            "dry_sand",
            "dry_sand~2",
            "clay-6",
            "dry_sand-5@wong-reece+slip-sinkage",
        ] {
            assert!(ids.iter().any(|i| i == id), "{id} of {ids:?}");
        }
    }

    /// Errors say which table, what is wrong, and the nearest name.
    #[test]
    fn a_plan_is_refused_with_its_place() {
        for (text, says) in [
            ("[[set]]\nhypothses = \"wong21\"", "hypothses"),
            (
                "[[set]]\nname = \"x\"",
                "exactly one of hypotheses and start",
            ),
            ("[[set]]\nhypotheses = \"wong22\"", "wong22"),
            ("set = []", "no [[set]]"),
            (
                "[[set]]\nstart = \"dry_sand\"\ngrid = [{ parameter = \"cohesoin\", from = 1, to = 2, points = 2 }]",
                "did you mean 'cohesion'",
            ),
            (
                "[[set]]\nhypotheses = \"wong21\"\ngrid = [{ parameter = \"cohesion\", from = 1, to = 2, points = 2 }]",
                "one start",
            ),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(says), "{text}: {error}");
        }
    }

    /// The bound of one set holds for all of them together: sets side by side cannot fill the memory either.
    #[test]
    fn sets_side_by_side_are_bounded_together() {
        let cube = |name: &str| {
            format!(
                "[[set]]\nname = \"{name}\"\nstart = \"dry_sand\"\nlatin_hypercube = {{ count = {}, axes = [{{ parameter = \"cohesion\", from = 1, to = 2 }}] }}\n",
                MOST_HYPOTHESES / 2 + 1
            )
        };
        let error = read(&(cube("a") + &cube("b"))).unwrap_err().to_string();
        assert!(error.contains("[[set]] 2: 1000002 hypotheses"), "{error}");
    }

    /// A soil twice under two names is a pair; the classic set has none.
    #[test]
    fn twins_are_named() {
        let rover = paper::light_rover();
        let set = read(
            "[[set]]\nhypotheses = \"wong21\"\n[[set]]\nname = \"again\"\nstart = \"dry_sand\"",
        )
        .unwrap();
        let found = twins(&set, &rover);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].pair, ["dry_sand".to_owned(), "again".to_owned()]);
    }
}
