//! The prior centre of the soil when the rover file names none: the winner of its hypotheses on the logs.

use std::collections::BTreeMap;

use terra_data::{DriveLog, RigLog, Rover, Start};
use terra_model::Registry;
use terra_model::catalogue::Terrain;

use crate::error::CliError;
use crate::identify::{Group, IdentifyOptions, identify_drive, identify_rig};

/// A log of either kind.
pub(crate) enum Log<'a> {
    Drive(&'a DriveLog),
    Rig(&'a RigLog),
}

/// Where the prior centre comes from.
pub(crate) enum Prior {
    /// The rover file names it.
    Given,
    /// The winner of the hypotheses, by its id.
    Identified(String),
    /// The log tells no soil; the first hypothesis stands in, so that a diagnosis can say what else the log lacks.
    Unknown {
        /// Why the log tells none.
        why: String,
    },
}

/// Completes `[terrain] start`.
pub(crate) fn complete(
    rover: &mut Rover,
    logs: &[Log<'_>],
    registry: &Registry,
    terrains: &[Terrain],
) -> Result<Prior, CliError> {
    if rover.terrain.start.is_some() {
        return Ok(Prior::Given);
    }
    let options = IdentifyOptions {
        join: true,
        refine: false,
        // What is wrong with vehicle or sensors is what the diagnosis itself is to find.
        check: false,
        explain: false,
        ..IdentifyOptions::default()
    };
    let mut why = "no hypothesis explains the log".to_owned();
    let mut found = vec![];
    for log in logs {
        let identified = match log {
            Log::Drive(log) => identify_drive(log, rover, registry, terrains, &options),
            Log::Rig(log) => identify_rig(log, rover, registry, terrains, &options),
        };
        match identified {
            Ok(id) => found.extend(id.groups.into_iter().next()),
            // What a log cannot tell is a verdict, not an error.
            Err(CliError::BadData { message, .. }) => why = message,
            Err(other) => return Err(other),
        }
    }
    let winner = match found.as_slice() {
        [one] => one.map.clone(),
        several => likeliest(several),
    };
    let winning = terrains
        .iter()
        .find(|t| Some(t.id.as_ref()) == winner.as_deref());
    let Some(terrain) = winning.or(terrains.first()) else {
        return Err(CliError::rover(
            "no hypotheses to start from",
            "see hypotheses and start in [terrain]",
        ));
    };
    let model = registry.law(&rover.terrain.model)?;
    let values = terrain.parameters(model.model())?;
    let names = model.model().params().iter().map(|p| p.name.to_owned());
    rover.terrain.start = Some(Start::Values(names.zip(values).collect()));
    Ok(match winning {
        Some(t) => Prior::Identified(t.id.to_string()),
        None => Prior::Unknown { why },
    })
}

/// The hypothesis that all logs together make the likeliest: their likelihoods multiply.
fn likeliest(groups: &[Group]) -> Option<String> {
    let mut sums: BTreeMap<&str, f64> = BTreeMap::new();
    for h in groups.iter().flat_map(|g| &g.posterior) {
        *sums.entry(h.id.as_str()).or_default() += h.log_likelihood;
    }
    sums.into_iter()
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(id, _)| id.to_owned())
}
