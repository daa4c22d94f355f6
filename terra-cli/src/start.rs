//! The prior centre of the soil when the rover file names none: the winner of its hypotheses on this log.

use terra_data::{DriveLog, RigLog, Rover, Start};
use terra_model::Registry;
use terra_model::catalogue::Terrain;

use crate::error::CliError;
use crate::identify::{IdentifyOptions, identify_drive, identify_rig};

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
    log: &Log<'_>,
    registry: &Registry,
    terrains: &[Terrain],
) -> Result<Prior, CliError> {
    if rover.terrain.start.is_some() {
        return Ok(Prior::Given);
    }
    let options = IdentifyOptions {
        join: true,
        refine: false,
        ..IdentifyOptions::default()
    };
    let identified = match log {
        Log::Drive(log) => identify_drive(log, rover, registry, terrains, &options),
        Log::Rig(log) => identify_rig(log, rover, registry, terrains, &options),
    };
    let (winner, why) = match identified {
        Ok(id) => (
            id.groups.first().and_then(|g| g.map.clone()),
            "no hypothesis explains the log".to_owned(),
        ),
        // What a log cannot tell is a verdict, not an error.
        Err(CliError::BadData { message, .. }) => (None, message),
        Err(other) => return Err(other),
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
