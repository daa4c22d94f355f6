//! Effects that a simulator's log shows itself: what both logs show is no gap.
//!
//! The error of the wheel law's form follows slip and load. What a simulator does along a path, in a rut, in turns or with speed it
//! does not follow, and without more a log would differ from itself: its own rut would be missing in the nominal law.
//!
//! # Equation
//! Effects k join the fit to the simulator's log one by one, best first, while ln Z gains enough: magnitudes s_b beside soil and
//! form. On the real log every residual then gains f(u; θ_b, 0) - f(u; θ_b, s_b), frozen, so that an effect asked there is a change.
//! How well s_b is known is part of that log's noise, as for soil and form.

use std::sync::Arc;

use terra_model::{AnyEffect, Touch};

use crate::candidates::is_instrument;
use crate::dataset::{DataSet, Shift};
use crate::error::GapError;
use crate::evidence::posterior;
use crate::fit::{Effort, Fit, fit_near, residual};
use crate::hypothesis::Hypothesis;
use crate::noise::Whitener;
use crate::predictor::Predictor;
use crate::settings::LogKind;
use crate::signatures::{by_the_law, screen_all};

/// Nats that an effect must gain: about what one must on the real log to be heard. One that gains less in the simulator's log is not
/// there, and stands in for what the form's error does not follow.
fn joins(kind: LogKind) -> f64 {
    match kind {
        LogKind::Rig => 5.0,
        LogKind::Drive | LogKind::Kinematic => 10.0,
    }
}

/// Prior sd beyond which, or at its bound, an effect of that size is not what the simulator shows, but stands in for what it does: where
/// wheels pushed aside turn the vehicle against its yaw damping, a mass of half its own did.
const LIKELY: f64 = 3.0;
/// Effects at most.
const MOST: usize = 5;
/// How many are fitted, best first, before none of a turn joins.
const TRIED: usize = 3;

/// Whether the error of the form follows what an effect does: by motion alone that of every turn, to both sides alike.
fn is_followed(effect: &dyn AnyEffect, kind: LogKind) -> bool {
    kind == LogKind::Kinematic
        && ["skid-steer-lateral-slip", "track-width-error"].contains(&effect.name())
}

/// Whether an effect is of the vehicle's mass and measures, or of ground that follows from more than the slip and load which the form's
/// error is smooth in. Others would only stand in for that error, and no simulator's sensors are wrong.
fn may_be_shown(effect: &dyn AnyEffect) -> bool {
    if effect.touches().contains(&Touch::Vehicle) {
        return true;
    }
    let beside = effect.beside_slip_and_load();
    let more = !effect.reads().is_empty() || beside.is_some_and(|beside| !beside.is_empty());
    more && !is_instrument(effect)
}

/// The fit to a simulator's log with the effects that it shows.
pub(crate) fn joined(
    data: &DataSet,
    predictor: &dyn Predictor,
    null: &Hypothesis,
    fit: Fit,
    whitener: &Whitener,
    effects: &[Arc<dyn AnyEffect>],
    kind: LogKind,
) -> (Hypothesis, Fit) {
    let joins = joins(kind);
    let (mut hypothesis, mut fit) = (null.clone(), fit);
    let mut left = effects.to_vec();
    left.retain(|e| may_be_shown(&**e) && !is_followed(&**e, kind));
    while hypothesis.effects().len() < MOST {
        // At the edge of what the soil carries the law has no slopes to screen by.
        let Ok(here) = by_the_law(data, predictor, &hypothesis, &fit, whitener) else {
            break;
        };
        let says = posterior(&hypothesis, &here).log_evidence;
        let none = &mut vec![];
        let (screen, asked) =
            screen_all(data, predictor, &hypothesis, &here, &left, whitener, none);
        let mut order: Vec<usize> = (0..screen.len())
            .filter(|&k| screen[k].score.log_bayes_factor > joins)
            .collect();
        let gain = |k: usize| screen[k].score.log_bayes_factor;
        order.sort_by(|&a, &b| gain(b).total_cmp(&gain(a)));
        let with = |k: usize| -> Option<(Hypothesis, Fit)> {
            let with = hypothesis.with(Arc::clone(&asked[k])).ok()?;
            let mut start = here.x.as_slice().to_vec();
            start.resize(with.len(), 0.0);
            start[here.x.len()] = screen[k].score.magnitude;
            let (low, high) = with.bounds();
            for (x, (low, high)) in start.iter_mut().zip(low.iter().zip(&high)) {
                *x = x.clamp(*low, *high);
            }
            let effort = Effort::Certified;
            let found = fit_near(data, predictor, &with, whitener, &start, None, effort).ok()?;
            let own = found.x.iter().skip(here.x.len());
            let size = own.fold(0.0, |most: f64, x| most.max(x.abs()));
            let likely =
                size < LIKELY && !found.at_bound.iter().skip(with.soil_len()).any(|at| *at);
            let says_more = posterior(&with, &found).log_evidence > says + joins;
            (likely && says_more).then_some((with, found))
        };
        let Some((with, found)) = order.into_iter().take(TRIED).find_map(with) else {
            break;
        };
        if let Some(joined) = with.effects().last() {
            left.retain(|e| e.name() != joined.name());
        }
        (hypothesis, fit) = (with, found);
    }
    (hypothesis, fit)
}

/// Gives a real log's residuals what the simulator's effects come to there. An observation in which they have no answer is left out,
/// and counted with that reason.
pub(crate) fn carry(data: &mut DataSet, predictor: &dyn Predictor, joined: &Hypothesis, x: &[f64]) {
    if joined.effects().is_empty() {
        return;
    }
    let mut without = x.to_vec();
    without[joined.soil_len()..].fill(0.0);
    data.observations.iter_mut().for_each(|o| {
        o.shift = Shift::default();
        o.carried.clear();
    });
    let more = |data: &DataSet| {
        let with = residual(data, predictor, joined, x)?;
        Ok::<_, GapError>(with - residual(data, predictor, joined, &without)?)
    };
    let mut all = more(data).ok();
    if all.is_none() {
        let answered = |k: usize| more(&data.subset(&[k])).is_ok();
        let keep: Vec<usize> = (0..data.observations.len())
            .filter(|&k| answered(k))
            .collect();
        let lost = data.observations.len() - keep.len();
        let reason = "outside the model: an effect that the simulator's log shows";
        *data = data.subset(&keep);
        *data.dropped.entry(reason.to_owned()).or_default() += lost;
        all = more(data).ok();
    }
    let Some(all) = all else { return };
    let mut values = all.iter().copied();
    for o in &mut data.observations {
        o.carried = values.by_ref().take(o.channels.len()).collect();
    }
}

#[cfg(test)]
mod tests {
    use terra_model::Registry;

    use super::*;

    /// What the vehicle weighs and measures, and ground that changes with path, passes, side, speed or turning; not what acts by slip and
    /// load alone, no sensor, and no load on the body.
    #[test]
    fn a_simulator_shows_what_slip_and_load_do_not_tell() {
        let registry = Registry::builtin();
        let shown = |name: &str| may_be_shown(&*registry.effect(name).unwrap());
        for name in [
            "cg-offset",
            "mass-error",
            "track-width-error",
            "multipass",
            "terrain-drift",
            "rate-stiffening",
            "lateral-contrast",
            "lateral-bulldozing",
            "skid-steer-lateral-slip",
        ] {
            assert!(shown(name), "{name}");
        }
        for name in [
            "slip-sinkage",
            "grousers",
            "rear-contact",
            "load-error",
            "torque-scale",
            "ground-speed-scale",
            "accel-bias",
            "drivetrain-coulomb-friction",
            "tow-load",
        ] {
            assert!(!shown(name), "{name}");
        }
    }
}
