//! What to measure next: the experiment whose outcomes the remaining rivals disagree about most.
//!
//! # Equation
//! score = Σ_ab P_a P_b min(KL_ab, 20), KL of the Gaussians each rival predicts: its mean, and the sensors' noise plus the
//! uncertainty of its own parameters.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;

use crate::cause::Ranking;
use crate::dataset::{DataSet, Design, Predictor};
use crate::fit::evaluate;
use crate::noise::NoiseModel;
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

struct Forecast {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// Ranks the designs that the predictor can imagine for this log.
pub(crate) fn suggest<P: Predictor>(
    data: &DataSet,
    predictor: &P,
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
            let forecasts: Vec<Forecast> = rivals
                .iter()
                .map(|(_, _, w)| forecast(&design, w))
                .collect::<Option<_>>()?;
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

fn forecast<P: Predictor>(design: &Design<P>, rival: &Weighed) -> Option<Forecast> {
    let x = rival.fit.x.as_slice();
    let stacked = evaluate(&design.data, &design.predictor, &rival.hypothesis, x).ok()?;
    let noise =
        NoiseModel::propagate(&design.data, &design.predictor, &rival.hypothesis, x).ok()?;
    let mut covariance =
        &stacked.jacobian * &rival.posterior.covariance * stacked.jacobian.transpose();
    let mut at = 0;
    for block in &noise.blocks {
        let mut view = covariance.view_mut((at, at), block.shape());
        view += block;
        at += block.nrows();
    }
    // The measured values are common to all rivals, so the residual's sign and offset do not matter.
    Some(Forecast {
        mean: -stacked.residual,
        covariance,
    })
}

/// KL(a || b) of two Gaussians.
fn divergence(a: &Forecast, b: &Forecast) -> Option<f64> {
    let n = a.mean.len() as f64;
    let (ca, cb) = (
        a.covariance.clone().cholesky()?,
        b.covariance.clone().cholesky()?,
    );
    let d = &a.mean - &b.mean;
    let ln_det = |c: &nalgebra::Cholesky<f64, nalgebra::Dyn>| {
        2.0 * c.l_dirty().diagonal().iter().map(|v| v.ln()).sum::<f64>()
    };
    let kl = 0.5
        * ((cb.solve(&a.covariance)).trace() - n + d.dot(&cb.solve(&d)) + ln_det(&cb)
            - ln_det(&ca));
    kl.is_finite().then_some(kl.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// KL(N(0,1) || N(1,4)) = ln 2 + (1 + 1)/8 - 1/2, by the textbook formula.
    #[test]
    fn divergence_of_two_normals() {
        let a = Forecast {
            mean: DVector::zeros(1),
            covariance: DMatrix::identity(1, 1),
        };
        let b = Forecast {
            mean: DVector::from_element(1, 1.0),
            covariance: DMatrix::from_element(1, 1, 4.0),
        };
        assert!((divergence(&a, &b).unwrap() - (2f64.ln() + 0.25 - 0.5)).abs() < 1e-12);
        assert_eq!(divergence(&a, &a).unwrap(), 0.0);
    }
}
