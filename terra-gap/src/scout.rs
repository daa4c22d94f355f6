//! Which single effects can explain a drive that the nominal law is far from.
//!
//! A soil that was fitted without the missing effect lies in a corner, where neither the tangent nor a way down says much of
//! what an effect can do. So every effect is looked at from near the prior centre, on few windows: first with the noise taken much
//! larger, which keeps the soil there and lets the effect do its part, then with the noise less large, then as it is. Noise that
//! is taken so large may hide what tells the effects apart, so none is dropped that is about as near as those that stay.

use std::sync::Arc;

use terra_model::order::ascending;

use crate::fit::Fit;
use crate::hypothesis::Hypothesis;
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::renewal::{hopeless, hopeless_from};
use crate::signatures::Asked;
use crate::thin::Thin;

/// Effects that are looked at with the noise as it is.
const CLOSER: usize = 6;
/// Units of cost, with the noise taken much larger, within which another is about as near as the last of these.
const TIED: f64 = 1.0;
/// Prior sd at which a one-sided effect begins: at its bound it may never leave.
const ONE_SIDED: f64 = 0.5;

/// The effects that come nearest to the data, best first, each with where it was found: as many as asked for, but none that is far
/// behind the first.
pub(crate) fn scout(
    predictor: &dyn Predictor,
    null: &Hypothesis,
    windows: &Thin,
    asked: &Asked,
    best: usize,
) -> Vec<(usize, Vec<f64>)> {
    let Ok(begun) = windows.begin(predictor, null, asked) else {
        return vec![];
    };
    let one_sided = |k: usize| asked[k].params().first().is_some_and(|p| p.one_sided());
    let from_null = |k: usize| {
        let h = null.with(Arc::clone(&asked[k])).ok()?;
        let (mut start, known) = begun.start_of(k, one_sided(k).then_some(ONE_SIDED));
        start.resize(h.len(), 0.0);
        Some((k, windows.held_back(predictor, &h, start, known).ok()?))
    };
    let mut found: Vec<(usize, Fit)> = for_each(asked.len(), from_null)
        .into_iter()
        .flatten()
        .collect();
    tied(&mut found);
    // Who does next to nothing there goes on from where the nominal law does.
    let idle = |far: &Fit| far.cost > begun.end.cost - TIED;
    let (rows, of_idle): (Vec<usize>, Asked) = found
        .iter()
        .filter(|(_, far)| idle(far))
        .map(|(k, _)| (*k, Arc::clone(&asked[*k])))
        .unzip();
    let further = windows.begin_half_way(predictor, null, &begun, &of_idle);
    let half_way = |(k, far): &(usize, Fit)| {
        let h = null.with(Arc::clone(&asked[*k])).ok()?;
        let (mut start, known) = match (rows.iter().position(|row| row == k), &further) {
            (Some(place), Ok(further)) => {
                further.start_of(place, one_sided(*k).then_some(ONE_SIDED))
            }
            _ => (far.x.as_slice().to_vec(), None),
        };
        start.resize(h.len(), 0.0);
        Some((*k, windows.half_way(predictor, &h, start, known).ok()?))
    };
    let mut found: Vec<(usize, Fit)> = for_each(found.len(), |rank| half_way(&found[rank]))
        .into_iter()
        .flatten()
        .collect();
    nearest(&mut found, CLOSER);
    let closer = |(k, half_way): &(usize, Fit), bar: f64| {
        let h = null.with(Arc::clone(&asked[*k])).ok()?;
        let start = [half_way.x.as_slice().to_vec()];
        let end = windows.end_below(bar, predictor, &h, &start, None);
        Some((*k, end.ok()?))
    };
    // The first tells from where the others are hopeless.
    let mut ends: Vec<(usize, Fit)> = vec![];
    let others = found.split_off(found.len().min(1));
    ends.extend(found.first().and_then(|first| closer(first, f64::INFINITY)));
    let bar = ends
        .first()
        .map_or(f64::INFINITY, |(_, first)| hopeless_from(first));
    let others: Vec<&(usize, Fit)> = others
        .iter()
        .filter(|o| !windows.is_beyond_half_way(&o.1, bar))
        .collect();
    let of_others = for_each(others.len(), |rank| closer(others[rank], bar));
    ends.extend(of_others.into_iter().flatten());
    let mut found = ends;
    nearest(&mut found, best);
    if let Some((_, first)) = found.first().cloned() {
        found.retain(|(_, fit)| !hopeless(fit, &first));
    }
    found
        .into_iter()
        .map(|(k, fit)| (k, fit.x.as_slice().to_vec()))
        .collect()
}

/// Leaves the nearest, and those that are about as near as the last of them.
fn tied(found: &mut Vec<(usize, Fit)>) {
    ascending(found, |f| f.1.cost);
    let last = found.get(CLOSER - 1).map_or(f64::INFINITY, |f| f.1.cost);
    found.retain(|f| f.1.cost <= last + TIED);
}

fn nearest(found: &mut Vec<(usize, Fit)>, most: usize) {
    ascending(found, |f| f.1.cost);
    found.truncate(most);
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// Of effects .11 apart fifteen stay: the sixth has .55, the fifteenth 1.54. Of effects two apart six stay.
    #[test]
    fn what_is_about_as_near_stays() {
        let at = |cost: f64| Fit {
            x: DVector::zeros(1),
            residual: DVector::zeros(1),
            jacobian: DMatrix::zeros(1, 1).into(),
            exact: true,
            tangent: false,
            cost,
            converged: false,
            given_up: false,
            log_det: 0.0,
            at_bound: vec![false],
            near: crate::memory::Remembered::default(),
        };
        let left = |apart: f64| {
            let mut all: Vec<(usize, Fit)> =
                (0..30).rev().map(|k| (k, at(apart * k as f64))).collect();
            tied(&mut all);
            all.into_iter().map(|(k, _)| k).collect::<Vec<_>>()
        };
        assert_eq!(left(0.11), (0..15).collect::<Vec<_>>());
        assert_eq!(left(2.0), (0..6).collect::<Vec<_>>());
    }
}
