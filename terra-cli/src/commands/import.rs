//! `terra import`: known data sets and formats to a log.

use std::path::Path;

use terra_data::{ImportKind, ImportedLog, import, read_scm_json, write_terrains};
use terra_model::catalogue::{self, Terrain};

use crate::args::ImportArg;
use crate::commands::export::chrono;
use crate::error::CliError;
use crate::output;

pub(crate) fn run(
    kind: ImportArg,
    source: &Path,
    out: &Path,
    map: Option<&Path>,
) -> Result<(), CliError> {
    let inputs: Vec<&Path> = [Some(source), map].into_iter().flatten().collect();
    output::claim(&[Some(out)], &inputs)?;
    match log(kind, source, map)? {
        Some(log) => tell(&log, out),
        None => terrain(source, out),
    }
}

/// What an import gives; none for a terrain, which is no log.
pub(crate) fn log(
    kind: ImportArg,
    source: &Path,
    map: Option<&Path>,
) -> Result<Option<ImportedLog>, CliError> {
    if map.is_some() && !matches!(kind, ImportArg::Mcap) {
        return Err(CliError::usage(
            "--map is for a bag",
            "terra import mcap BAG --map FILE --out LOG",
        ));
    }
    let kind = match kind {
        ImportArg::CmuSingleWheel => ImportKind::CmuSingleWheel,
        ImportArg::PublishedSingleWheel => ImportKind::PublishedSingleWheel,
        ImportArg::NorlabDrive => ImportKind::NorlabDrive,
        ImportArg::Borealtc => ImportKind::BorealTc,
        ImportArg::Parquet => ImportKind::Parquet,
        ImportArg::Mat => ImportKind::Mat,
        ImportArg::Mcap => return Ok(Some(bag(source, map)?)),
        ImportArg::ScmJson => return Ok(None),
    };
    Ok(Some(import(kind, source)?))
}

#[cfg(feature = "mcap")]
fn bag(source: &Path, map: Option<&Path>) -> Result<ImportedLog, CliError> {
    let map = map.ok_or_else(|| {
        CliError::usage(
            "a bag needs --map",
            "a TOML file that says which field of which topic each column is; see \"A ROS 2 bag\" in the book",
        )
    })?;
    Ok(terra_data::import_mcap(source, map)?)
}

#[cfg(not(feature = "mcap"))]
fn bag(_: &Path, _: Option<&Path>) -> Result<ImportedLog, CliError> {
    Err(CliError::usage(
        "this build cannot read MCAP",
        "build it with `--features mcap` (cargo install --path . --features mcap)",
    ))
}

/// Writes the log and says what it is.
fn tell(log: &ImportedLog, out: &Path) -> Result<(), CliError> {
    log.write(out)?;
    let mut said = format!(
        "{}: {} rows, {}\n",
        out.display(),
        log.len(),
        log.header().join(" ")
    );
    for note in &log.notes {
        said.push_str(&format!("note: {note}\n"));
    }
    output::stdout(&said)
}

/// The soil of Chrono's JSON; writes a catalogue with it, where one is asked for.
pub(crate) fn soil(source: &Path, catalogue: Option<&Path>) -> Result<Terrain, CliError> {
    let soil = read_scm_json(source)?;
    if let Some(out) = catalogue {
        write_terrains(out, std::slice::from_ref(&soil))?;
    }
    Ok(soil)
}

/// Chrono's JSON to a catalogue; or a soil that terra knows to Chrono's JSON, when that is what is to be written.
fn terrain(source: &Path, out: &Path) -> Result<(), CliError> {
    let json = |path: &Path| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("json"))
    };
    if json(out) && !json(source) {
        let soil = catalogue::find(&source.to_string_lossy())?;
        return output::json(Some(out), &chrono(soil)?);
    }
    let soil = soil(source, Some(out))?;
    output::stdout(&format!(
        "{}: terrain '{}'; use it with hypotheses = \"{}\" in [terrain]\n",
        out.display(),
        soil.id,
        out.display()
    ))
}
