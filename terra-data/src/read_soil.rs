//! Reads `[terrain]`: the model, the soil it starts from, and what `identify` weighs.

use std::collections::BTreeMap;

use terra_model::catalogue::{self, Terrain};
use terra_model::{AnyModel, Law, Registry};
use toml::de::{DeTable, DeValue};

use crate::error::{DataError, Origin};
use crate::names::nearest;
use crate::problem::Problem;
use crate::read_terrains::names_a_file;
use crate::rover::{Start, TerrainSettings};
use crate::section::{Document, Entry, Legal, Section};

/// Set that `identify` weighs by default.
const DEFAULT_SET: &str = "wong21";

pub(crate) fn read_terrain(
    s: &Section<'_>,
    registry: &Registry,
) -> Result<TerrainSettings, DataError> {
    s.only(&["model", "hypotheses", "start", "prior_sd", "prior_abs_sd"])?;
    let Some((model, at)) = s.optional_text("model")? else {
        return Err(s.missing("model", "a terrain model, or model+effect+effect"));
    };
    let law = registry.law(model).map_err(|e| {
        let expected = "a registered model or effect";
        s.document.fail(&at, Problem::from_model(e, expected))
    })?;
    let hypotheses = read_hypotheses(s)?;
    Ok(TerrainSettings {
        model: model.to_owned(),
        start: read_start(s, &law, names_a_file(&hypotheses))?,
        hypotheses,
        prior_sd: read_sds(s, "prior_sd", &law)?,
        prior_abs_sd: read_sds(s, "prior_abs_sd", &law)?,
    })
}

fn read_hypotheses(s: &Section<'_>) -> Result<String, DataError> {
    let Some((name, at)) = s.optional_text("hypotheses")? else {
        return Ok(DEFAULT_SET.to_owned());
    };
    if !names_a_file(name) {
        let expected = "a set of the catalogue or a .csv file";
        catalogue::set(name).map_err(|e| s.document.fail(&at, Problem::from_model(e, expected)))?;
    }
    Ok(name.to_owned())
}

fn read_start(s: &Section<'_>, law: &Law, own_catalogue: bool) -> Result<Option<Start>, DataError> {
    let Some(entry) = s.get("start") else {
        return Ok(None);
    };
    match entry.value {
        DeValue::String(id) => {
            // With a catalogue of the user's own, `read_rover` looks the id up: it knows the folder.
            if !own_catalogue {
                let expected = "a terrain id, or a table of parameters";
                let known = catalogue::find(id).map_err(|e| Problem::from_model(e, expected));
                known
                    .and_then(|soil| complete(soil, law))
                    .map_err(|problem| s.document.fail(&entry.at, problem))?;
            }
            Ok(Some(Start::Id(id.to_string())))
        }
        DeValue::Table(_) => read_values(s, &entry, law.model()).map(|v| Some(Start::Values(v))),
        _ => Err(s.wrong_type(&entry, "a terrain id or a table of parameters")),
    }
}

/// All parameters of the model, where `k_eq` may stand for `k_c` and `k_phi`.
fn read_values(
    s: &Section<'_>,
    entry: &Entry<'_>,
    model: &dyn AnyModel,
) -> Result<BTreeMap<String, f64>, DataError> {
    let start = s.table_of(entry)?;
    let has_k = model.params().iter().any(|p| p.name == "k_phi");
    let mut known: Vec<&str> = model.params().iter().map(|p| p.name).collect();
    if has_k {
        known.push("k_eq");
    }
    start.only(&known)?;
    let k_eq = start.get("k_eq");
    if let Some(k_eq) = &k_eq
        && let Some(other) = start.get("k_phi").or(start.get("k_c"))
    {
        let problem = Problem::Conflict {
            key: k_eq.shown.clone(),
            other: other.key.to_owned(),
        };
        return Err(s.document.fail(&k_eq.key_at, problem));
    }
    let mut values = BTreeMap::new();
    if k_eq.is_some() {
        values.insert("k_eq".to_owned(), start.number("k_eq", Legal::Positive)?);
    }
    for p in model.params() {
        if k_eq.is_some() && matches!(p.name, "k_c" | "k_phi") {
            continue;
        }
        match start.optional_number(p.name, Legal::Within(p.min, p.max))? {
            Some(v) => values.insert(p.name.to_owned(), v),
            None if p.name == "k_phi" => {
                return Err(start.missing("k_eq", "k_eq, or k_c and k_phi (N/m^(n+2), N/m^(n+1))"));
            }
            None => {
                let expected = format!("{} in {}", p.doc, p.unit);
                return Err(start.missing(p.name, &expected));
            }
        };
    }
    Ok(values)
}

fn read_sds(s: &Section<'_>, key: &str, law: &Law) -> Result<BTreeMap<String, f64>, DataError> {
    let mut sds = BTreeMap::new();
    let Some(table) = s.table(key)? else {
        return Ok(sds);
    };
    let mut known: Vec<&str> = law.model().params().iter().map(|p| p.name).collect();
    if known.contains(&"k_phi") {
        known.push("k_eq");
    }
    table.only(&known)?;
    for entry in table.entries() {
        let sd = table.number_of(&entry, Legal::Positive)?;
        sds.insert(entry.key.to_owned(), sd);
    }
    Ok(sds)
}

/// A soil gives all that the model needs.
fn complete(soil: &Terrain, law: &Law) -> Result<(), Problem> {
    let found = soil.parameters(law.model());
    found.map(drop).map_err(Problem::IncompleteTerrain)
}

/// The soil of a start id where the user has a catalogue of their own: its row, or else that of the built-in one.
pub(crate) fn own_start(
    text: &str,
    origin: &Origin,
    id: &str,
    own: &[Terrain],
    law: &Law,
) -> Result<Start, DataError> {
    let found = match own.iter().find(|t| t.id == id) {
        Some(soil) => complete(soil, law).map(|()| Start::Own(Box::new(soil.clone()))),
        None => match catalogue::find(id) {
            Ok(soil) => complete(soil, law).map(|()| Start::Id(id.to_owned())),
            Err(_) => Err(Problem::UnknownName {
                kind: "terrain",
                name: id.to_owned(),
                expected: "an id of the built-in catalogue or of the hypotheses file".to_owned(),
                nearest: nearest(id, own.iter().map(|t| t.id.as_ref())),
            }),
        },
    };
    found.map_err(|problem| {
        // The text was parsed before; it is parsed again only to find the place.
        let document = Document {
            origin: origin.clone(),
            text,
        };
        let at = DeTable::parse(text).ok().and_then(|table| {
            let terrain = table.get_ref().get("terrain")?.get_ref().as_table()?;
            Some(terrain.get("start")?.span())
        });
        document.fail(&at.unwrap_or(0..0), problem)
    })
}
