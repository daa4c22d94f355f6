//! A long drive watched for the opening of a gap.

use serde_json::Value;
use terra_model::Registry;

use super::Source;
use crate::commands::gap_watch as watching;
use crate::error::CliError;

/// What is asked of [`watch`]; the defaults are the command's.
#[derive(Clone, Debug)]
pub struct WatchOptions {
    /// What the soil is learned from: so many seconds from the log's beginning, or a manoeuvre by its name.
    pub baseline: String,
    /// Share of logs without a gap in which an event may be raised.
    pub false_alarms: f64,
    /// Hints by name; `None` for all.
    pub effects: Option<Vec<String>>,
}

/// What a watch gave.
#[derive(Clone, Debug)]
pub struct Watched {
    /// `terra gap --watch --json`.
    pub verdict: Value,
    /// `--track`: what every window shows, as CSV.
    pub track: String,
}

/// `terra gap --watch`: when and where a gap opens in a drive.
///
/// # Errors
/// As the command.
pub fn watch(
    log: &Source,
    rover: &Source,
    registry: &Registry,
    options: &WatchOptions,
) -> Result<Watched, CliError> {
    let case = watching::Case {
        log: &log.log()?,
        log_name: log.name(),
        rover: rover.rover(registry)?,
        rover_name: rover.name(),
        registry,
    };
    let effects = options.effects.clone();
    let settings = watching::settings(&options.baseline, options.false_alarms, effects);
    let mut watched = watching::Watched::new(&case, &settings)?;
    let mut track = String::new();
    watched.follow(&case, &mut |rows| {
        track.push_str(rows);
        Ok(())
    })?;
    Ok(Watched {
        verdict: watched.as_json(),
        track,
    })
}
