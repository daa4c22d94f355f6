//! What to measure next: the experiment whose outcomes the remaining rivals disagree about most.
//!
//! # Equation
//! score = Σ_ab P_a P_b min(KL_ab, 20), KL of the Gaussians each rival predicts for a short run of the experiment: its mean,
//! and the sensors' noise plus the uncertainty of its own parameters.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;

use crate::cause::Ranking;
use crate::dataset::DataSet;
use crate::fit::evaluate;
use crate::noise::NoiseModel;
use crate::predictor::{Design, Predictor};
use crate::weigh::Weighed;

/// One suggestion.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Experiment {
    /// What to do, in words.
    pub manoeuvre: String,
    /// Which rivals its outcome tells apart.
    pub separates: Vec<String>,
    /// Expected information about which of them is right \[nats\].
    pub expected_nats: f64,
}

const RIVALS: usize = 6;
const MOST_NATS: f64 = 20.0;
/// Divergence from which two rivals count as told apart \[nats\].
const SEPARATED: f64 = 2.0;

/// Windows of a design that are forecast: a short run says which experiment is better, at a bounded cost.
const WINDOWS: usize = 40;

/// What a rival predicts in units of the noise: covariance I + A A'.
struct Forecast {
    mean: DVector<f64>,
    /// A (n x parameters).
    spread: DMatrix<f64>,
}

/// Ranks the designs that the predictor can imagine for this log.
pub(crate) fn suggest(
    data: &DataSet,
    predictor: &dyn Predictor,
    null: &Weighed,
    ranking: &Ranking,
) -> Vec<Experiment> {
    let mut rivals: Vec<(String, f64, &Weighed)> = ranking
        .causes
        .iter()
        .filter(|c| c.probability > 0.01)
        .take(RIVALS)
        .map(|c| (c.name.clone(), c.probability, &c.weighed))
        .collect();
    if ranking.probability_none > 0.01 {
        rivals.push(("none".to_owned(), ranking.probability_none, null));
    }
    if rivals.len() < 2 {
        return vec![];
    }
    let total: f64 = rivals.iter().map(|r| r.1).sum();
    let mut out: Vec<Experiment> = predictor
        .designs(data)
        .into_par_iter()
        .filter_map(|design| {
            let forecasts = forecasts(&design, &rivals)?;
            let mut score = 0.0;
            let mut separates: Vec<String> = vec![];
            for a in 0..rivals.len() {
                for b in 0..rivals.len() {
                    if a == b {
                        continue;
                    }
                    let kl = divergence(&forecasts[a], &forecasts[b])?;
                    score += rivals[a].1 * rivals[b].1 / (total * total) * kl.min(MOST_NATS);
                    if kl > SEPARATED {
                        for name in [&rivals[a].0, &rivals[b].0] {
                            if !separates.contains(name) {
                                separates.push(name.clone());
                            }
                        }
                    }
                }
            }
            separates.sort_unstable();
            Some(Experiment {
                manoeuvre: design.manoeuvre,
                separates,
                expected_nats: score,
            })
        })
        .collect();
    out.sort_by(|a, b| {
        b.expected_nats
            .total_cmp(&a.expected_nats)
            .then_with(|| a.manoeuvre.cmp(&b.manoeuvre))
    });
    out.truncate(5);
    out
}

/// The noise is that of the first rival: rivals differ in their means, hardly in how inputs reach them.
fn forecasts(design: &Design, rivals: &[(String, f64, &Weighed)]) -> Option<Vec<Forecast>> {
    let total = design.data.observations.len();
    let kept = total.min(WINDOWS);
    let keep: Vec<usize> = (0..kept).map(|k| k * total / kept).collect();
    let data = design.data.subset(&keep);
    let (_, _, first) = rivals.first()?;
    let x = first.fit.x.as_slice();
    let noise = NoiseModel::propagate(&data, &*design.predictor, &first.hypothesis, x).ok()?;
    let whitener = noise.whitener(&data).ok()?;
    rivals
        .iter()
        .map(|(_, _, rival)| {
            let x = rival.fit.x.as_slice();
            let s = evaluate(
                &data,
                &*design.predictor,
                &rival.hypothesis,
                x,
                &rival.fit.near,
            )
            .ok()?;
            let root = rival.posterior.covariance.clone().cholesky()?.unpack();
            // The measured values are common to all rivals, so the residual's sign and offset do not matter.
            Some(Forecast {
                mean: -whitener.apply_vector(&s.residual),
                spread: whitener.apply(&s.jacobian) * root,
            })
        })
        .collect()
}

/// KL(a || b) of two Gaussians with covariances I + A A', in the space of their parameters.
///
/// # Equation
/// 2 KL = tr(Cb^-1 Ca) - n + d'Cb^-1 d + ln det Cb - ln det Ca, Cb^-1 = I - B M^-1 B', M = I + B'B.
fn divergence(a: &Forecast, b: &Forecast) -> Option<f64> {
    let gram = |s: &DMatrix<f64>| s.tr_mul(s);
    let (aa, bb, ba) = (gram(&a.spread), gram(&b.spread), b.spread.tr_mul(&a.spread));
    let with_identity = |g: &DMatrix<f64>| (g + DMatrix::identity(g.nrows(), g.ncols())).cholesky();
    let (ca, cb) = (with_identity(&aa)?, with_identity(&bb)?);
    let d = &a.mean - &b.mean;
    let bd = b.spread.tr_mul(&d);
    let ln_det = |c: &nalgebra::Cholesky<f64, nalgebra::Dyn>| {
        2.0 * c.l_dirty().diagonal().iter().map(|v| v.ln()).sum::<f64>()
    };
    let trace = aa.trace() - cb.solve(&bb).trace() - (cb.solve(&ba) * ba.transpose()).trace();
    let square = d.norm_squared() - bd.dot(&cb.solve(&bd));
    let kl = 0.5 * (trace + square + ln_det(&cb) - ln_det(&ca));
    kl.is_finite().then_some(kl.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// KL(N(0,2) || N(1,4)) = ln(4/2)/2 + (2 + 1)/8 - 1/2, by the textbook formula.
    #[test]
    fn divergence_of_two_normals() {
        let normal = |mean: f64, variance: f64| Forecast {
            mean: DVector::from_element(1, mean),
            spread: DMatrix::from_element(1, 1, (variance - 1.0).sqrt()),
        };
        let (a, b) = (normal(0.0, 2.0), normal(1.0, 4.0));
        let expected = 0.5 * 2f64.ln() + 3.0 / 8.0 - 0.5;
        assert!((divergence(&a, &b).unwrap() - expected).abs() < 1e-12);
        assert!(divergence(&a, &a).unwrap() < 1e-15);
    }

    /// Against the dense formula, three values and two parameters.
    #[test]
    fn divergence_equals_the_dense_one() {
        let forecast = |seed: f64| Forecast {
            mean: DVector::from_fn(3, |r, _| (seed + r as f64).sin()),
            spread: DMatrix::from_fn(3, 2, |r, c| (seed * 3.0 + (2 * r + c) as f64).cos()),
        };
        let (a, b) = (forecast(0.3), forecast(1.1));
        let dense = |f: &Forecast| DMatrix::identity(3, 3) + &f.spread * f.spread.transpose();
        let (ca, cb) = (dense(&a), dense(&b));
        let inverse = cb.clone().try_inverse().unwrap();
        let d = &a.mean - &b.mean;
        let expected = 0.5
            * ((&inverse * &ca).trace() - 3.0
                + d.dot(&(&inverse * &d))
                + (cb.determinant() / ca.determinant()).ln());
        assert!((divergence(&a, &b).unwrap() - expected).abs() < 1e-12);
    }
}
