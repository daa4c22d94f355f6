//! Where a drive's fits start anew: wheel laws are far from linear, and a fit goes on from one that may be in a corner.

use rayon::prelude::*;
use terra_model::order::descending;
use terra_model::{AnyEffect, Touch};

use crate::dataset::DataSet;
use crate::fit::{Effort, Fit};
use crate::predictor::Predictor;
use crate::renewal::{hopeless, out};
use crate::settings::LogKind;
use crate::thin::Thin;
use crate::weigh::{Amplitudes, Weighed, weigh};

/// Prior sd that a soil parameter moves at most before a fit starts anew from the prior centre.
const FAR_SOIL: f64 = 3.0;
/// Misfit per value above which it does.
const FAR_FIT: f64 = 1.3;
/// How many of the best singles, and of the best pairs.
const ANEW: usize = 3;

/// Squared distance in posterior sd between ends on few windows that are one.
const SAME: f64 = 0.1;
/// Cost on few windows by which one may be the higher and still be the lower on all.
const BEHIND: f64 = 20.0;

/// Another start for a fit of a drive: physics at the contact is far from linear, and a one-sided effect can end at its bound
/// although it is there, the soil having moved the other way. Instruments are nearly linear and need one start.
pub(crate) fn far_start(
    effect: &dyn AnyEffect,
    found: &Weighed,
    kind: LogKind,
) -> Option<Vec<f64>> {
    let physical = [Touch::Contact, Touch::Forces]
        .iter()
        .any(|t| effect.touches().contains(t));
    let mut far = found.plain.x.as_slice().to_vec();
    let last = far.last_mut()?;
    if kind != LogKind::Drive || !physical || *last > 0.1 {
        return None;
    }
    *last = 1.0;
    Some(far)
}

/// The prior centre of the soil as another start, where a drive's fit ended at a soil that is hard to believe or far from the
/// data: fits go on from the nominal law's own, which a missing effect may have driven into a corner.
fn fresh_start(found: &Weighed, soil: usize) -> Option<Vec<f64>> {
    let x = &found.plain.x;
    let moved = x.iter().take(soil).any(|q| q.abs() > FAR_SOIL);
    if !(moved || found.chi2_per_value() > FAR_FIT) {
        return None;
    }
    let size = |s: f64| {
        if s.abs() < 0.1 {
            0.5
        } else {
            s.clamp(-2.0, 2.0)
        }
    };
    let fresh = x.iter().enumerate();
    Some(
        fresh
            .map(|(k, v)| if k < soil { 0.0 } else { size(*v) })
            .collect(),
    )
}

/// Fits the best explanations anew from there, unless that was done under another noise already or the best, one of these or
/// another that is `known`, leaves nothing that they could win.
pub(crate) fn start_anew(
    data: &DataSet,
    predictor: &dyn Predictor,
    levels: &Amplitudes,
    soil: usize,
    all: &mut [&mut Weighed],
    known: Option<&Weighed>,
    done: &mut Vec<String>,
) {
    descending(all, |w| w.log_evidence);
    let mut best: Vec<&mut Weighed> = all.iter_mut().take(ANEW).map(|w| &mut **w).collect();
    let own = best.first().map(|w| (**w).clone());
    for first in own.iter().chain(known) {
        best.retain(|w| !hopeless(&w.plain, &first.plain));
        if first.chi2_per_value() < FAR_FIT {
            best.retain(|w| !out(w, std::iter::once(first)));
        }
    }
    best.retain(|w| !done.contains(&w.hypothesis.effect_name()));
    done.extend(best.iter().map(|w| w.hypothesis.effect_name()));
    best.par_iter_mut().for_each(|w| {
        let h = w.hypothesis.clone();
        let found = better_of(w.clone(), fresh_start(w, soil), |start, found| {
            weigh_elsewhere(data, predictor, levels, found, |windows, misfit| {
                let near = windows.held_back(predictor, &h, start, None).ok()?;
                let beyond = windows.is_beyond(&near, misfit);
                let let_go = || windows.let_go(predictor, &h, &near, misfit).ok();
                if beyond { None } else { let_go() }
            })
        });
        **w = found;
    });
}

/// Weighs a rival of a drive once more where a way on few windows ends, unless that is where it was found or higher. `way` goes
/// it, as long as a misfit per value is in reach.
fn weigh_elsewhere(
    data: &DataSet,
    predictor: &dyn Predictor,
    amplitudes: &Amplitudes,
    found: &Weighed,
    way: impl FnOnce(&Thin, f64) -> Option<Fit>,
) -> Option<Weighed> {
    let h = &found.hypothesis;
    let windows = amplitudes.thin.as_ref()?;
    let known = windows.end_of(predictor, h, &found.plain).ok();
    let other = way(windows, known.as_ref().map_or(f64::INFINITY, in_question))?;
    if known.is_some_and(|known| is_no_better(&other, &known)) {
        return None;
    }
    let start = [other.x.as_slice().to_vec()];
    weigh(data, predictor, h, amplitudes, &start, None, Effort::Again).ok()
}

/// The same from a start far away.
pub(crate) fn weigh_from(
    data: &DataSet,
    predictor: &dyn Predictor,
    amplitudes: &Amplitudes,
    found: &Weighed,
    start: Vec<f64>,
) -> Option<Weighed> {
    let h = &found.hypothesis;
    weigh_elsewhere(data, predictor, amplitudes, found, |windows, misfit| {
        windows.end_below(misfit, predictor, h, &[start], None).ok()
    })
}

/// Misfit per value on few windows up to which another end may be the lower one on all of them.
fn in_question(known: &Fit) -> f64 {
    let values = known.residual.len().max(1) as f64;
    // Far from the data few windows speak for all the less.
    (known.cost + BEHIND * (known.cost / values).max(1.0)) / values
}

/// Whether a fit to few windows ended where another did, or at a cost too much higher to be the lower one on all of them.
fn is_no_better(other: &Fit, known: &Fit) -> bool {
    let apart = &other.x - &known.x;
    let distance = (&*known.jacobian * &apart).norm_squared() + apart.norm_squared();
    distance < SAME || other.cost > in_question(known) * known.residual.len() as f64
}

/// The best of a fit and those from other starts.
pub(crate) fn better_of(
    found: Weighed,
    starts: impl IntoIterator<Item = Vec<f64>>,
    weigh: impl Fn(Vec<f64>, &Weighed) -> Option<Weighed>,
) -> Weighed {
    starts
        .into_iter()
        .fold(found, |best, start| match weigh(start, &best) {
            Some(other) if other.log_evidence > best.log_evidence => other,
            _ => best,
        })
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// A fit of a straight line, its data three times as certain as its prior: a posterior sd of 1/sqrt(10).
    fn end(x: f64, cost: f64) -> Fit {
        Fit {
            x: DVector::from_element(1, x),
            residual: DVector::zeros(100),
            jacobian: DMatrix::from_fn(100, 1, |row, _| if row == 0 { 3.0 } else { 0.0 }).into(),
            exact: true,
            tangent: false,
            cost,
            converged: true,
            given_up: false,
            log_det: 0.0,
            at_bound: vec![false],
            near: crate::memory::Remembered::default(),
        }
    }

    /// Ends .05 apart are .16 posterior sd apart, and one; ends .5 apart are not, unless one is out of the question.
    #[test]
    fn only_another_valley_that_may_be_lower_is_worth_a_fit() {
        let known = end(0.0, 100.0);
        assert!(is_no_better(&end(0.05, 100.0), &known));
        assert!(!is_no_better(&end(0.5, 99.0), &known));
        assert!(!is_no_better(&end(0.5, 119.0), &known));
        assert!(is_no_better(&end(0.5, 121.0), &known));
        // At four times the noise's misfit, up to eighty units higher.
        assert!(!is_no_better(&end(0.5, 479.0), &end(0.0, 400.0)));
    }
}
