//! `terra cite`: the references owed for what a scenario or a rover file uses.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Value, json};
use terra_data::{Start, hypothesis_terrains, names_a_file, read_rover};
use terra_model::catalogue::Terrain;
use terra_model::{Registry, catalogue};
use terra_sim::Scenario;

use crate::error::CliError;
use crate::output::{self, table};

/// One thing in use and where it comes from.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Owed {
    kind: &'static str,
    name: String,
    reference: String,
}

pub(crate) fn run(path: &Path, json: bool) -> Result<(), CliError> {
    if json {
        return output::json(None, &as_json(path)?);
    }
    let rows: Vec<Vec<String>> = owed(path)?
        .into_iter()
        .map(|o| vec![o.kind.to_owned(), o.name, o.reference])
        .collect();
    output::stdout(&table(&["for the", "named", "cite"], &rows))
}

/// `terra cite --json`.
pub(crate) fn as_json(path: &Path) -> Result<Value, CliError> {
    let all: Vec<_> = owed(path)?
        .iter()
        .map(|o| json!({ "kind": o.kind, "name": o.name, "reference": o.reference }))
        .collect();
    Ok(json!({ "schema": "terra.cite/1", "references": all }))
}

/// All that a file uses.
fn owed(path: &Path) -> Result<BTreeSet<Owed>, CliError> {
    let mut owed = BTreeSet::new();
    match scenario(path)? {
        Some(scenario) => {
            of_law(&scenario.model, &mut owed)?;
            for effect in &scenario.effects {
                of_effect(&effect.name, effect.form.as_deref(), &mut owed);
            }
            of_soil(&scenario.left, &mut owed)?;
            of_soil(&scenario.right, &mut owed)?;
            of_rover(&scenario.rover_path(path), &mut owed)?;
        }
        None => of_rover(path, &mut owed)?,
    }
    Ok(owed)
}

/// The scenario, when the file is one: only a scenario names a rover file.
fn scenario(path: &Path) -> Result<Option<Scenario>, CliError> {
    let names_a_rover = std::fs::read_to_string(path)
        .ok()
        .and_then(|text| text.parse::<toml::Table>().ok())
        .is_some_and(|table| table.contains_key("rover"));
    // What cannot be read or parsed is left to the rover's reader, which says where.
    Ok(if names_a_rover {
        Some(Scenario::read(path)?)
    } else {
        None
    })
}

fn of_rover(path: &Path, owed: &mut BTreeSet<Owed>) -> Result<(), CliError> {
    let rover = read_rover(path)?;
    of_law(&rover.terrain.model, owed)?;
    let settings = &rover.terrain;
    let folder = path.parent().unwrap_or(Path::new(""));
    let own = names_a_file(&settings.hypotheses);
    let file = folder.join(&settings.hypotheses).display().to_string();
    for soil in hypothesis_terrains(settings, folder)? {
        owed.insert(Owed {
            kind: "soils",
            name: settings.hypotheses.clone(),
            reference: match own {
                true => own_source(&soil, &file),
                // What follows the semicolon is about one soil.
                false => in_full(soil.source.split(';').next().unwrap_or_default()),
            },
        });
    }
    match &settings.start {
        Some(Start::Own(soil)) => {
            owed.insert(Owed {
                kind: "soil",
                name: soil.id.to_string(),
                reference: own_source(soil, &file),
            });
            Ok(())
        }
        Some(start) => of_soil(start, owed),
        None => Ok(()),
    }
}

/// What a row of the user's own catalogue says of its source; one that says nothing stands under its file's name.
fn own_source(soil: &Terrain, file: &str) -> String {
    if soil.source == file {
        return "your own catalogue: cite what its soils were taken from (a column source_note keeps it)".to_owned();
    }
    in_full(&soil.source)
}

/// The catalogue's short name of its main source, written out.
fn in_full(source: &str) -> String {
    source.replace(
        "Wong T2.3",
        "J. Y. Wong, Theory of Ground Vehicles, Wiley, Table 2.3",
    )
}

fn of_law(name: &str, owed: &mut BTreeSet<Owed>) -> Result<(), CliError> {
    let law = Registry::builtin().law(name)?;
    owed.insert(Owed {
        kind: "model",
        name: law.model().name().to_owned(),
        reference: law.model().reference().to_owned(),
    });
    for effect in law.effects() {
        of_effect(effect.name(), None, owed);
    }
    Ok(())
}

fn of_effect(name: &str, form: Option<&str>, owed: &mut BTreeSet<Owed>) {
    let registry = Registry::builtin().with_forms();
    let found = match form {
        Some(form) => registry.effect_form(name, form),
        None => registry.effect(name),
    };
    let reference = match found {
        Ok(effect) => effect.reference().to_owned(),
        Err(_) => "the simulator's own: see the scenario reference of terra-sim".to_owned(),
    };
    owed.insert(Owed {
        kind: "effect",
        name: name.to_owned(),
        reference,
    });
}

fn of_soil(start: &Start, owed: &mut BTreeSet<Owed>) -> Result<(), CliError> {
    let (name, reference) = match start {
        Start::Id(id) => (id.clone(), in_full(&catalogue::find(id)?.source)),
        Start::Own(soil) => (soil.id.to_string(), in_full(&soil.source)),
        Start::Values(_) => (
            "given by value".to_owned(),
            "your own parameters: cite where they were measured".to_owned(),
        ),
    };
    owed.insert(Owed {
        kind: "soil",
        name,
        reference,
    });
    Ok(())
}
