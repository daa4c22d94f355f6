//! How far the gap truly closed: the same effects, held out the same way, on the case's observations without noise.

use terra_data::hypothesis_terrains;
use terra_gap::{HoldOut, closing_drive, closing_rig};
use terra_model::Registry;

use super::answer::Verdict;
use super::design::{AnyLog, Design, simulate};
use super::key::CaseKey;
use super::library::Library;
use super::make::scenario_of;
use super::metrics::Closing;
use crate::error::CliError;
use crate::start::{Log, complete};

/// The closing of one verdict; none when it claims none or the noise-free log does not share it.
pub(crate) fn closing(
    key: &CaseKey,
    verdict: &Verdict,
    design: &Design,
    library: &Library,
) -> Result<Option<Closing>, CliError> {
    let Some(after) = &verdict.after else {
        return Ok(None);
    };
    let Some(held) = &after.held_out else {
        return Ok(None);
    };
    let Some(closed) = held.closed else {
        return Ok(None);
    };
    let Some(by) = [
        HoldOut::Trial,
        HoldOut::Segment,
        HoldOut::Condition,
        HoldOut::Slip,
    ]
    .into_iter()
    .find(|by| by.name() == held.by) else {
        return Ok(None);
    };
    // Structures and a user's own effects are not in the registry.
    let registry = Registry::builtin();
    if after.effects.iter().any(|e| registry.effect(e).is_err()) {
        return Ok(None);
    }
    let mut scenario = scenario_of(key, design)?;
    let log = simulate(&scenario, &design.rover, library.registry())?;
    scenario.noise_scale = 0.0;
    let clean = simulate(&scenario, &design.rover, library.registry())?;
    let mut rover = design.rover.clone();
    let terrains = hypothesis_terrains(&rover.terrain, std::path::Path::new(""))?;
    let effects = &after.effects;
    let truth = match (&log, &clean) {
        (AnyLog::Drive(log), AnyLog::Drive(clean)) => {
            complete(&mut rover, &[Log::Drive(log)], &registry, &terrains)?;
            closing_drive(log, clean, &rover, &registry, effects, by)?
        }
        (AnyLog::Rig(log), AnyLog::Rig(clean)) => {
            complete(&mut rover, &[Log::Rig(log)], &registry, &terrains)?;
            closing_rig(log, clean, &rover, &registry, effects, by)?
        }
        _ => None,
    };
    Ok(truth.map(|truth| Closing {
        claimed: closed.mean,
        lo: closed.lo,
        hi: closed.hi,
        truth,
    }))
}
