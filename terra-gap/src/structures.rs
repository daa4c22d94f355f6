//! Other terrain models as rivals, `structure:<model>`, and other soil, `soil-change`: which of them are worth a fit to all of the data.
//!
//! A drive has many windows, and some wheel laws cost a hundred times what the nominal one does. A model that cannot follow
//! a few windows spread over the whole log, although it may choose its soil for them alone, cannot follow all of them.

use std::sync::Arc;

use terra_model::order::ascending;

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::fit::{Effort, Fit, fit_from, fit_near, residual};
use crate::hypothesis::Hypothesis;
use crate::noise::{NoiseModel, Whitener};
use crate::null::starts_of;
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::settings::LogKind;
use crate::setup::Setup;
use crate::weigh::{Amplitudes, Weighed, contest, weigh};

/// Windows of a drive that a model is tried on first.
const TRIED_ON: usize = 16;
/// Ends on those rows of a rig that start the fits to all of them.
const BEST_STARTS: usize = 2;
/// Prior sd within which two ends are one.
const SAME: f64 = 0.1;
/// Nats behind the best explanation on those windows from which a model is out.
const OUT: f64 = 15.0;

/// Terrain models beside the nominal one.
#[derive(Default)]
pub(crate) struct Structures {
    /// Those that were fitted to all of the data.
    pub weighed: Vec<(String, Weighed)>,
    /// Those that were not, with the reason.
    pub out: Vec<(String, String)>,
}

/// Fits and weighs every other terrain model that is not far behind the best of `rivals`; without rivals, all of them.
///
/// # Errors
/// A covariance that is not positive definite.
pub(crate) fn weigh_structures(
    data: &DataSet,
    predictor: &dyn Predictor,
    setup: &Setup<'_>,
    noise: &NoiseModel,
    levels: &Amplitudes,
    rivals: &[&Weighed],
) -> Result<Structures, GapError> {
    let total = data.observations.len();
    let keep: Vec<usize> = (0..TRIED_ON.min(total))
        .map(|i| (2 * i + 1) * total / (2 * TRIED_ON.min(total)))
        .collect();
    let few = data.subset(&keep);
    let whitener = noise.subset(&keep).whitener(&few)?;
    // Half of |r|² + |x|², the part of -ln Z that can be large.
    let best = rivals
        .iter()
        .filter_map(|w| {
            let x = &w.plain.x;
            let r = residual(&few, predictor, &w.hypothesis, x.as_slice()).ok()?;
            Some(0.5 * (whitener.apply_vector(&r).norm_squared() + x.norm_squared()))
        })
        .fold(f64::INFINITY, f64::min);
    let tried: Vec<Result<(String, Weighed), (String, String)>> = for_each(setup.structures.len(), |k| {
            let rival = &setup.structures[k];
            let h = Hypothesis::null(rival.law.clone(), Arc::clone(&rival.soil));
            let mut starts = starts_of(&h, setup.kind);
            if setup.kind == LogKind::Rig {
                starts = best_starts(&few, predictor, &h, &whitener, &starts);
            } else if best.is_finite() {
                let within = Effort::Below(2.0 * (best + OUT));
                let fitted = match fit_from(&few, predictor, &h, &whitener, &starts, None, within) {
                    Ok(fitted) => fitted,
                    Err(e) => return Some(Err((rival.name.clone(), e.to_string()))),
                };
                let behind = 0.5 * fitted.cost - best;
                if behind > OUT {
                    let reason = format!(
                        "{behind:.0} nats behind the best explanation on {} windows, where its fit was ended",
                        keep.len()
                    );
                    return Some(Err((rival.name.clone(), reason)));
                }
                // A soil that carries the wheels in these windows may not carry them in all.
                if residual(data, predictor, &h, fitted.x.as_slice()).is_ok() {
                    starts = vec![fitted.x.as_slice().to_vec()];
                }
            }
            let weighed = weigh(data, predictor, &h, levels, &starts, None, contest(setup.kind));
            Some(match weighed {
                Ok(weighed) => Ok((rival.name.clone(), weighed)),
                Err(e) => Err((rival.name.clone(), e.to_string())),
            })
        })
        .into_iter()
        .flatten()
        .collect();
    let mut out = Structures::default();
    for one in tried {
        match one {
            Ok(weighed) => out.weighed.push(weighed),
            Err(reason) => out.out.push(reason),
        }
    }
    Ok(out)
}

/// Where the fits to a few rows end that end best: wheel laws are far from linear, and all rows from every start cost too much.
fn best_starts(
    few: &DataSet,
    predictor: &dyn Predictor,
    h: &Hypothesis,
    whitener: &Whitener,
    starts: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let mut ends: Vec<Fit> = starts
        .iter()
        .filter_map(|s| fit_near(few, predictor, h, whitener, s, None, Effort::Carried).ok())
        .collect();
    ascending(&mut ends, |e| e.cost);
    ends.dedup_by(|a, b| (&a.x - &b.x).amax() < SAME);
    ends.truncate(BEST_STARTS);
    let mut out: Vec<Vec<f64>> = ends.iter().map(|f| f.x.as_slice().to_vec()).collect();
    if out.is_empty() {
        out.extend(starts.first().cloned());
    }
    out
}
