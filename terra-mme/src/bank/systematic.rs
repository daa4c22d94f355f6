//! Which systematic error of vehicle or sensor would explain a log that no soil explains?
//!
//! A wrong soil absorbs a wrong torque constant with full confidence, so an alarm that only says "no" leaves its reader
//! alone. Each candidate effect is therefore weighed together with every soil on the same samples.
//!
//! # Equation
//! Over soils j and the magnitude e ~ N(0, s²) of one effect: ln p(z | effect) = ln ∫ Σ_j p(z | j, e)/N N(e; 0, s²) de,
//! by Laplace's rule at the best e of the best soils; gain = that less ln Σ_j p(z | j, 0)/N.
//!
//! # Reference
//! D. J. C. MacKay, Neural Computation 4(3):415-447, 1992 (Occam factor of Laplace's rule).

use std::sync::Arc;

use terra_model::AnyEffect;
use terra_model::order::{ascending, descending};

use super::core::SoilMaps;
use super::motion::{MotionSample, Plant};
use super::weigher::InnovationBank;
use crate::consistency::AlarmRule;
use crate::error::EstimatorError;
use crate::estimator::{ParameterEstimator, Weighed};

/// Effects tried when the alarm rings, by name.
pub const SYSTEMATIC: [&str; 5] = [
    "slope",
    "accel-bias",
    "ground-speed-scale",
    "torque-scale",
    "mass-error",
];

/// Nats a candidate must gain over the plain vehicle to be offered.
pub const OFFERED_GAIN: f64 = 5.0;

/// Magnitudes of the first look, in units of the prior's 1-sigma.
const FIRST_LOOK: [f64; 9] = [-2.0, -1.2, -0.6, -0.25, 0.0, 0.25, 0.6, 1.2, 2.0];
/// Largest number of further looks, each a third of the bracket away from the best.
const FURTHER_LOOKS: usize = 14;

/// One effect weighed together with every soil.
#[derive(Clone, Debug, PartialEq)]
pub struct SystematicCandidate {
    /// Name of the effect.
    pub effect: &'static str,
    /// Best magnitude.
    pub magnitude: f64,
    /// Its posterior 1-sigma.
    pub sd: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// Most probable soil under it.
    pub map: String,
    /// Probability of that soil under it.
    pub probability: f64,
    /// ln evidence over that of the plain vehicle.
    pub log_evidence_gain: f64,
    /// NIS/d of the winner under it over the worst window of the log.
    pub nis_per_dof: Option<f64>,
    /// The alarm is silent under it.
    pub explains: bool,
}

/// One run of a bank over all samples.
struct Look {
    log_evidence: f64,
    map: String,
    probability: f64,
    nis_per_dof: Option<f64>,
    alarm: bool,
}

fn look(
    maps: &SoilMaps,
    plant: Plant,
    samples: &[MotionSample],
    rule: AlarmRule,
) -> Result<Look, EstimatorError> {
    let mut bank = InnovationBank::new(maps.clone(), plant)?.with_alarm(rule)?;
    let mut told = 0;
    for s in samples {
        match bank.update(s) {
            Ok(()) => told += 1,
            // A magnitude under which nothing moves is a bad one, not the end of the search.
            Err(EstimatorError::AllInfeasible { .. }) => {}
            Err(e) => return Err(e),
        }
    }
    let refused = (samples.len() - told) as f64;
    let seen = bank.consistency();
    Ok(Look {
        log_evidence: bank.log_evidence() + refused * crate::estimator::INFEASIBLE_LOG_LIKELIHOOD,
        map: bank.map().id.clone(),
        probability: bank
            .probabilities()
            .get(bank.map_index())
            .copied()
            .unwrap_or(0.0),
        nis_per_dof: seen.nis_per_dof,
        alarm: seen.alarm,
    })
}

/// Weighs each effect with every soil of the maps on the samples of a log; best first. All are returned, also those
/// that gain nothing.
///
/// # Errors
/// What a bank refuses; [`EstimatorError::NotSupported`] for an effect that acts on neither vehicle nor sensor.
pub fn systematic(
    maps: &SoilMaps,
    plant: &Plant,
    effects: &[Arc<dyn AnyEffect>],
    samples: &[MotionSample],
    rule: AlarmRule,
) -> Result<Vec<SystematicCandidate>, EstimatorError> {
    let plain = look(maps, *plant, samples, rule)?;
    let mut out = Vec::with_capacity(effects.len());
    for effect in effects {
        let Some(param) = effect.params().first() else {
            continue;
        };
        let prior_sd = param.prior_sd;
        let run = |e: f64| look(maps, plant.with_effect(&**effect, &[e])?, samples, rule);
        // ln p(z | e) + ln N(e; 0, s²) up to its constant.
        let score = |e: f64, l: &Look| l.log_evidence - 0.5 * (e / prior_sd).powi(2);
        let mut seen: Vec<(f64, Look)> = Vec::new();
        for x in FIRST_LOOK {
            let e = x * prior_sd;
            if e > param.min && e < param.max {
                seen.push((e, run(e)?));
            }
        }
        ascending(&mut seen, |s| s.0);
        let best_of = |seen: &[(f64, Look)]| {
            (0..seen.len()).fold(0, |best, k| {
                if score(seen[k].0, &seen[k].1) > score(seen[best].0, &seen[best].1) {
                    k
                } else {
                    best
                }
            })
        };
        for turn in 0..FURTHER_LOOKS {
            let k = best_of(&seen);
            let (below, above) = (k.checked_sub(1), (k + 1 < seen.len()).then_some(k + 1));
            let at = seen[k].0;
            let gap = |j: Option<usize>| j.map_or(0.0, |j| (seen[j].0 - at).abs());
            // Three points around the best make a parabola; where it leads nowhere new the wider side is cut.
            let cut = match (below, above) {
                (Some(i), Some(j)) => {
                    let points = [i, k, j].map(|m| (seen[m].0, score(seen[m].0, &seen[m].1)));
                    let (top, width) = parabola(points);
                    let inside = top > seen[i].0 && top < seen[j].0;
                    let fresh = (top - at).abs() > 0.02 * width;
                    if inside && fresh && turn % 3 != 2 {
                        top
                    } else if width > 0.0 && gap(below).max(gap(above)) < 1.5 * width {
                        break;
                    } else if gap(below) > gap(above) {
                        at - gap(below) / 3.0
                    } else {
                        at + gap(above) / 3.0
                    }
                }
                (Some(_), None) => at + prior_sd,
                (None, Some(_)) => at - prior_sd,
                (None, None) => break,
            };
            if !(cut > param.min && cut < param.max) {
                break;
            }
            seen.push((cut, run(cut)?));
            ascending(&mut seen, |s| s.0);
        }
        let k = best_of(&seen);
        let (at, best) = &seen[k];
        let width = match (k.checked_sub(1), (k + 1 < seen.len()).then_some(k + 1)) {
            (Some(i), Some(j)) => {
                parabola([i, k, j].map(|m| (seen[m].0, score(seen[m].0, &seen[m].1)))).1
            }
            _ => 0.0,
        };
        let sd = if width > 0.0 && width < prior_sd {
            width
        } else {
            prior_sd
        };
        out.push(SystematicCandidate {
            effect: effect.name(),
            magnitude: *at,
            sd,
            unit: param.unit,
            map: best.map.clone(),
            probability: best.probability,
            log_evidence_gain: score(*at, best) + (sd / prior_sd).ln() - plain.log_evidence,
            nis_per_dof: best.nis_per_dof,
            explains: !best.alarm,
        });
    }
    descending(&mut out, |c| c.log_evidence_gain);
    Ok(out)
}

/// Top of the parabola through three points, and the 1-sigma of the Gaussian it is the logarithm of; no top, width 0.
fn parabola([(x0, y0), (x1, y1), (x2, y2)]: [(f64, f64); 3]) -> (f64, f64) {
    let (s0, s1) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let curvature = 2.0 * (s1 - s0) / (x2 - x0);
    if !(curvature.is_finite() && curvature < 0.0) {
        return (x1, 0.0);
    }
    let top = 0.5 * (x0 + x1) - s0 / curvature;
    (top, (-1.0 / curvature).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_of_a_gaussian_is_a_parabola() {
        let y = |x: f64| 3.0 - 0.5 * ((x - 0.7) / 0.2_f64).powi(2);
        let (top, width) = parabola([-0.3, 0.6, 1.9].map(|x| (x, y(x))));
        assert!((top - 0.7).abs() < 1e-12 && (width - 0.2).abs() < 1e-12);
        assert_eq!(parabola([(0.0, 1.0), (1.0, 0.0), (2.0, 1.0)]).1, 0.0);
    }
}
