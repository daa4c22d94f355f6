//! How far the gap truly closed: the same effects, held out the same way, on the case's log without noise.
//!
//! # Equation
//! closed = 1 - SSE_after/SSE_before over held-out groups of the noise-free log, both whitened by the noise floor: what
//! the verdict's figure (SSE_before - SSE_after)/(SSE_before - n) estimates from noisy data.

use terra_data::hypothesis_terrains;
use terra_gap::{HoldOut, Settings, diagnose_drive, diagnose_rig};
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
    scenario.noise_scale = 0.0;
    let log = simulate(&scenario, &design.rover, library.registry())?;
    let mut rover = design.rover.clone();
    let mut settings = Settings::of(&rover);
    settings.effects = Some(after.effects.clone());
    settings.combine = after.effects.len().clamp(1, 2);
    settings.hold_out = Some(by);
    let terrains = hypothesis_terrains(&rover.terrain, std::path::Path::new(""))?;
    let diagnosis = match &log {
        AnyLog::Drive(log) => {
            complete(&mut rover, &Log::Drive(log), &registry, &terrains)?;
            diagnose_drive(log, &rover, &registry, &settings)?
        }
        AnyLog::Rig(log) => {
            complete(&mut rover, &Log::Rig(log), &registry, &terrains)?;
            diagnose_rig(log, &rover, &registry, &settings)?.0
        }
    };
    let mut asked = after.effects.clone();
    let mut accepted = diagnosis.accepted_names.clone();
    asked.sort();
    accepted.sort();
    Ok(diagnosis
        .held_out
        .filter(|h| accepted == asked && h.chi2_before > 0.0)
        .map(|h| Closing {
            claimed: closed.mean,
            lo: closed.lo,
            hi: closed.hi,
            truth: 1.0 - h.chi2_after / h.chi2_before,
        }))
}
