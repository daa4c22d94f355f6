//! Where a drive's fits start anew: wheel laws are far from linear, and a fit goes on from one that may be in a corner.

use rayon::prelude::*;
use terra_model::{AnyEffect, Touch};

use crate::dataset::{DataSet, Predictor};
use crate::fit::{Effort, fit_near};
use crate::renewal::out;
use crate::settings::LogKind;
use crate::weigh::{Amplitudes, Weighed, weigh};

/// Prior sd that a soil parameter moves at most before a fit starts anew from the prior centre.
const FAR_SOIL: f64 = 3.0;
/// Misfit per value above which it does.
const FAR_FIT: f64 = 1.3;
/// How many of the best singles, and of the best pairs.
const ANEW: usize = 3;

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

/// Fits the best explanations anew from there, unless that was done under another noise already or the best leaves nothing
/// that they could win.
pub(crate) fn start_anew<P: Predictor>(
    data: &DataSet,
    predictor: &P,
    levels: &Amplitudes,
    soil: usize,
    all: &mut [&mut Weighed],
    done: &mut Vec<String>,
) {
    all.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    let mut best: Vec<&mut Weighed> = all.iter_mut().take(ANEW).map(|w| &mut **w).collect();
    if let Some(first) = best.first().map(|w| (**w).clone())
        && first.chi2_per_value() < FAR_FIT
    {
        best.retain(|w| !out(w, std::iter::once(&first)));
    }
    best.retain(|w| !done.contains(&w.hypothesis.effect_name()));
    done.extend(best.iter().map(|w| w.hypothesis.effect_name()));
    best.par_iter_mut().for_each(|w| {
        let h = w.hypothesis.clone();
        let found = better_of(w.clone(), fresh_start(w, soil), |start| {
            // With the noise taken ten times larger the prior holds the soil back until the rest is about right.
            let loose = levels.loose.as_ref()?;
            let near = fit_near(data, predictor, &h, loose, &start, None, Effort::Carried).ok()?;
            weigh(
                data,
                predictor,
                &h,
                levels,
                &[near.x.as_slice().to_vec()],
                None,
                Effort::Contest,
            )
            .ok()
        });
        **w = found;
    });
}

/// The best of a fit and those from other starts.
pub(crate) fn better_of(
    found: Weighed,
    starts: impl IntoIterator<Item = Vec<f64>>,
    weigh: impl Fn(Vec<f64>) -> Option<Weighed>,
) -> Weighed {
    starts
        .into_iter()
        .filter_map(weigh)
        .fold(found, |best, other| {
            if other.log_evidence > best.log_evidence {
                other
            } else {
                best
            }
        })
}
