//! The bank itself: one vehicle filter a member, weighed by its innovations; with or without mixing of states.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_model::Vehicle;

use super::motion::{AT_ACCEL, MOTION_CHANNELS, MotionSample, Plant};
use super::soil_map::SoilMap;
use super::vehicle_filter::{Estimate, Innovation, STATES};
use crate::choice::Choice;
use crate::consistency::{AlarmRule, Window};
use crate::error::EstimatorError;
use crate::estimator::INFEASIBLE_LOG_LIKELIHOOD;
use crate::hypothesis::HypothesisSet;
use crate::log_prob::log_sum_exp;
use crate::posterior::Posterior;

/// Gap after which the filters start anew \[s\]: the torque in between is not known.
const RESTART_GAP: f64 = 1.0;
/// Largest number of members, a guard against N² of a large set.
pub(crate) const MOST_MEMBERS: usize = 20_000;

/// The soil maps of a set, shared by every bank over it.
#[derive(Clone, Debug)]
pub struct SoilMaps {
    pub(crate) set: HypothesisSet,
    pub(crate) maps: Vec<Arc<SoilMap>>,
    radius: f64,
    width: f64,
}

impl SoilMaps {
    /// Maps of every hypothesis on wheels of this vehicle. Cheap: nodes are computed when a drive first goes there, and
    /// are kept for the next drive.
    ///
    /// # Errors
    /// [`EstimatorError::Value`] for a vehicle without mass or wheels.
    pub fn new(set: HypothesisSet, vehicle: &Vehicle<f64>) -> Result<Self, EstimatorError> {
        let load = 0.25 * vehicle.mass * 9.81;
        for (what, value) in [
            ("mass", load),
            ("wheel radius", vehicle.wheel_radius),
            ("wheel width", vehicle.wheel_width),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(EstimatorError::Value {
                    what: what.to_owned(),
                    value,
                    expected: "a finite value above 0",
                });
            }
        }
        let (radius, width) = (vehicle.wheel_radius, vehicle.wheel_width);
        let maps = set
            .hypotheses()
            .iter()
            .map(|h| Arc::new(SoilMap::new(&h.law, &h.parameters, radius, width, load)))
            .collect();
        Ok(SoilMaps {
            set,
            maps,
            radius,
            width,
        })
    }

    /// The hypotheses.
    pub fn hypotheses(&self) -> &HypothesisSet {
        &self.set
    }
}

/// Members, their filters and their posterior.
#[derive(Clone, Debug)]
pub(crate) struct Core {
    pub(crate) maps: SoilMaps,
    pub(crate) plant: Plant,
    /// Soil under the left and the right wheels.
    pub(crate) members: Vec<[usize; 2]>,
    pub(crate) choice: Choice,
    pub(crate) mixing: bool,
    pub(crate) posterior: Posterior,
    pub(crate) log_evidence: f64,
    pub(crate) log_likelihood: Vec<f64>,
    pub(crate) infeasible: Vec<usize>,
    pub(crate) windows: Vec<Window>,
    pub(crate) rule: AlarmRule,
    estimates: Vec<Estimate>,
    last: Option<MotionSample>,
}

impl Core {
    pub(crate) fn new(
        maps: SoilMaps,
        plant: Plant,
        members: Vec<[usize; 2]>,
    ) -> Result<Self, EstimatorError> {
        let n = members.len();
        if n > MOST_MEMBERS {
            return Err(EstimatorError::Size {
                what: "members of the bank (the square of the set for two soils)",
                found: n,
                expected: MOST_MEMBERS,
            });
        }
        let car = plant.vehicle;
        if car.wheel_radius != maps.radius || car.wheel_width != maps.width {
            return Err(EstimatorError::Value {
                what: "wheel radius of the plant".to_owned(),
                value: car.wheel_radius,
                expected: "the wheel its soil maps were made for",
            });
        }
        Ok(Core {
            posterior: Posterior::uniform(n)?,
            choice: Choice::None,
            mixing: false,
            log_evidence: 0.0,
            log_likelihood: vec![0.0; n],
            infeasible: vec![0; n],
            windows: vec![Window::default(); n],
            rule: AlarmRule::innovations(),
            estimates: Vec::new(),
            last: None,
            maps,
            plant,
            members,
        })
    }

    fn check(&self, sample: &MotionSample) -> Result<(), EstimatorError> {
        let numbers = sample
            .torque
            .iter()
            .chain(sample.channels.iter().flatten())
            .chain(std::iter::once(&sample.time));
        if !numbers.copied().all(f64::is_finite) {
            return Err(EstimatorError::Observation {
                time: sample.time,
                reason: "a number in it is not finite".to_owned(),
            });
        }
        let here = self.plant.at(sample).vehicle;
        for (what, good) in [
            (
                "its payload leaves no mass",
                here.mass.is_finite() && here.mass > 0.0,
            ),
            (
                "its pitch is no angle in (-π/2, π/2)",
                here.pitch.abs() < std::f64::consts::FRAC_PI_2,
            ),
        ] {
            if !good {
                return Err(EstimatorError::Observation {
                    time: sample.time,
                    reason: what.to_owned(),
                });
            }
        }
        match &self.last {
            Some(last) if last.group == sample.group && sample.time <= last.time => {
                Err(EstimatorError::TimeOrder {
                    time: sample.time,
                    previous: last.time,
                })
            }
            _ => Ok(()),
        }
    }

    fn soils(&self, member: usize) -> [&SoilMap; 2] {
        self.members[member].map(|j| &*self.maps.maps[j])
    }

    /// One row of the log. Nothing is changed when it fails.
    pub(crate) fn update(&mut self, sample: &MotionSample) -> Result<(), EstimatorError> {
        self.check(sample)?;
        let last = self
            .last
            .filter(|l| l.group == sample.group && sample.time - l.time <= RESTART_GAP);
        let plant = self.plant.at(sample);
        let mut next: Vec<Option<(Estimate, Innovation)>> = Vec::with_capacity(self.members.len());
        match last {
            Some(last) => {
                let mixed = if self.mixing {
                    self.mixed()?
                } else {
                    self.estimates.clone()
                };
                for (k, mut estimate) in mixed.into_iter().enumerate() {
                    let soils = self.soils(k);
                    let told = estimate.follow(soils, &plant, &last, sample);
                    next.push(told.ok().map(|i| (estimate, i)));
                }
            }
            None => {
                // What a start takes for its state is no evidence; only the specific force is left to judge by.
                let mut accel = [false; MOTION_CHANNELS];
                accel[AT_ACCEL] = true;
                for k in 0..self.members.len() {
                    let mut estimate = Estimate::start(&plant, sample);
                    let told = estimate.update(self.soils(k), &plant, sample, &accel);
                    next.push(told.ok().map(|i| (estimate, i)));
                }
            }
        }
        let log_likelihood: Vec<f64> = next
            .iter()
            .map(|n| {
                n.as_ref()
                    .map_or(INFEASIBLE_LOG_LIKELIHOOD, |(_, i)| i.log_density)
            })
            .collect();
        let best = (0..next.len())
            .filter(|&k| next[k].is_some())
            .max_by(|&a, &b| {
                let weigh = |k: usize| self.posterior.log_probabilities()[k] + log_likelihood[k];
                weigh(a).total_cmp(&weigh(b)).then(b.cmp(&a))
            });
        let Some(donor) = best
            .and_then(|k| next[k].as_ref())
            .map(|(estimate, _)| estimate.clone())
        else {
            return Err(EstimatorError::AllInfeasible {
                time: sample.time,
                hypotheses: next.len(),
            });
        };
        self.log_evidence += self.posterior.step(&self.choice, &log_likelihood)?.ln();
        // Nothing below can fail.
        let follows = last.is_some();
        let mut estimates = Vec::with_capacity(next.len());
        for (k, told) in next.into_iter().enumerate() {
            self.log_likelihood[k] += log_likelihood[k];
            match told {
                Some((estimate, i)) => {
                    if !i.whitened.is_empty() {
                        let e = DVector::from_vec(i.whitened);
                        self.windows[k].push(Some(e), follows, self.rule);
                    }
                    estimates.push(estimate);
                }
                None => {
                    // The vehicle is where it is, whatever this soil says: it goes on from the best rival's state.
                    self.infeasible[k] += 1;
                    self.windows[k].push(None, follows, self.rule);
                    estimates.push(donor.clone());
                }
            }
        }
        self.estimates = estimates;
        self.last = Some(*sample);
        Ok(())
    }

    /// The state each member starts from when the soil may have changed since the last sample.
    ///
    /// # Equation
    /// c_j = Σ_i M_ij p_i, μ_ij = M_ij p_i / c_j, x0_j = Σ_i μ_ij x_i, P0_j = Σ_i μ_ij (P_i + (x_i - x0_j)(x_i - x0_j)ᵀ).
    ///
    /// # Reference
    /// H. A. P. Blom, Y. Bar-Shalom, IEEE Trans. Automatic Control 33(8):780-783, 1988.
    fn mixed(&self) -> Result<Vec<Estimate>, EstimatorError> {
        let n = self.members.len();
        let matrix = match &self.choice {
            Choice::None => return Ok(self.estimates.clone()),
            Choice::Floor(f) => DMatrix::from_fn(n, n, |i, j| {
                f / n as f64 + if i == j { 1.0 - f } else { 0.0 }
            }),
            Choice::Transition(m) => m.clone(),
            Choice::Forgetting(_) => {
                return Err(EstimatorError::NotSupported {
                    estimator: "imm",
                    choice: self.choice.to_string(),
                    reason: "mixing needs to know where each hypothesis goes: transition or floor",
                });
            }
        };
        let log_p = self.posterior.log_probabilities();
        let mut out = Vec::with_capacity(n);
        for j in 0..n {
            let terms: Vec<f64> = (0..n).map(|i| log_p[i] + matrix[(i, j)].ln()).collect();
            let total = log_sum_exp(&terms);
            // A member that nothing leads to keeps its own state.
            if total == f64::NEG_INFINITY {
                out.push(self.estimates[j].clone());
                continue;
            }
            let share: Vec<f64> = terms.iter().map(|t| (t - total).exp()).collect();
            let mut x = [0.0; STATES];
            let mut accel = 0.0;
            for (e, w) in self.estimates.iter().zip(&share) {
                for (x, v) in x.iter_mut().zip(&e.x) {
                    *x += w * v;
                }
                accel += w * e.accel;
            }
            let mut p = [[0.0; STATES]; STATES];
            for (e, w) in self.estimates.iter().zip(&share).filter(|(_, w)| **w > 0.0) {
                let d: [f64; STATES] = std::array::from_fn(|k| e.x[k] - x[k]);
                for a in 0..STATES {
                    for b in 0..STATES {
                        p[a][b] += w * (e.p[a][b] + d[a] * d[b]);
                    }
                }
            }
            out.push(Estimate { x, p, accel });
        }
        Ok(out)
    }

    /// Mean of the state of a member: v, r, four ω; none before the first sample.
    pub(crate) fn state(&self, member: usize) -> Option<[f64; STATES]> {
        self.estimates.get(member).map(|e| e.x)
    }
}
