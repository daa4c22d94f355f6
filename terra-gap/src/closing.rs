//! How far effects truly close a gap: held out as in a diagnosis, on the same observations without noise.
//!
//! # Equation
//! closed = 1 - Σ SSE_k/Σ SSE_0 over held-out groups of noise-free values, both whitened by the noise of the noisy log: what
//! a diagnosis estimates by (SSE_0 - SSE_k)/(SSE_0 - n).

use std::collections::BTreeMap;

use terra_data::{DriveLog, RigLog, Rover};
use terra_model::Registry;

use crate::candidates::gate;
use crate::dataset::DataSet;
use crate::error::GapError;
use crate::holdout::{HoldOut, hold_out};
use crate::predictor::Predictor;
use crate::rivals::weigh_rivals;
use crate::run::setup;
use crate::settings::{LogKind, Settings};
use crate::setup::Setup;
use crate::{drive, rig};

/// The share of a drive's gap that effects close, by a log and the same log without noise; none where the effects cannot be
/// fitted to it or nothing is left to be closed.
///
/// # Errors
/// As [`diagnose_drive`](crate::diagnose_drive).
pub fn closing_drive(
    log: &DriveLog,
    clean: &DriveLog,
    rover: &Rover,
    registry: &Registry,
    effects: &[String],
    by: HoldOut,
) -> Result<Option<f64>, GapError> {
    let setup = setup(registry, rover, LogKind::Drive, &[])?;
    let noisy = drive::from_log(log, rover, Settings::WINDOWS)?;
    let clean = drive::all_windows(clean, rover)?;
    let (noisy, clean) = ((noisy.0, &noisy.1 as _), (clean.0, &clean.1 as _));
    closing(noisy, clean, &setup, effects, by)
}

/// The same for a rig.
///
/// # Errors
/// As [`diagnose_rig`](crate::diagnose_rig).
pub fn closing_rig(
    log: &RigLog,
    clean: &RigLog,
    rover: &Rover,
    registry: &Registry,
    effects: &[String],
    by: HoldOut,
) -> Result<Option<f64>, GapError> {
    let setup = setup(registry, rover, LogKind::Rig, &[])?;
    let noisy = rig::from_log(log, rover)?;
    let clean = rig::from_log(clean, rover)?;
    let (noisy, clean) = ((noisy.0, &noisy.1 as _), (clean.0, &clean.1 as _));
    closing(noisy, clean, &setup, effects, by)
}

fn closing(
    (mut noisy, predictor): (DataSet, &dyn Predictor),
    (clean, clean_predictor): (DataSet, &dyn Predictor),
    setup: &Setup<'_>,
    effects: &[String],
    by: HoldOut,
) -> Result<Option<f64>, GapError> {
    let mut settings = Settings::of(setup.rover);
    settings.effects = Some(effects.to_vec());
    settings.combine = effects.len().clamp(1, 2);
    let (law, rover) = (&setup.law, setup.rover);
    let candidates = gate(
        setup.registry,
        law,
        &noisy,
        rover,
        setup.kind,
        &settings,
        None,
    )?;
    let found = weigh_rivals(&mut noisy, predictor, setup, &settings, &candidates)?;
    let Ok((rivals, _)) = found else {
        return Ok(None);
    };
    let mut wanted = effects.to_vec();
    wanted.sort_unstable();
    let wanted = wanted.join("+");
    let all = rivals.singles.iter().flat_map(|(_, w)| w);
    let best = all
        .chain(&rivals.pairs)
        .filter(|w| w.hypothesis.effect_name() == wanted)
        .max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence));
    let Some(best) = best else {
        return Ok(None);
    };
    // The same observations: gates look at noisy values.
    let at: BTreeMap<&str, usize> = clean
        .observations
        .iter()
        .enumerate()
        .map(|(k, o)| (o.place.as_str(), k))
        .collect();
    let (kept, same): (Vec<usize>, Vec<usize>) = noisy
        .observations
        .iter()
        .enumerate()
        .filter_map(|(i, o)| Some((i, *at.get(o.place.as_str())?)))
        .filter(|&(i, k)| noisy.observations[i].channels == clean.observations[k].channels)
        .unzip();
    let held = hold_out(
        &clean.subset(&same),
        clean_predictor,
        &rivals.noise.subset(&kept),
        (&rivals.null, &rivals.fitted),
        (&best.hypothesis, &best.plain),
        (setup.kind, by),
        // Nothing of it is noise.
        0.0,
    )?;
    Ok((held.chi2_before > 0.0).then(|| 1.0 - held.chi2_after / held.chi2_before))
}
