//! The fused update as an estimator.
//!
//! # Equation
//! ln w_j <- ln w_j - q_j/2 + q_b/2, q = r~ᵀ S~⁻¹ r~, b the winner so far: log-weights stay near 0 where it matters, so that
//! single precision is enough (a posterior within 1e-4 of double precision). S is shared: its slopes in slip and load are
//! the winner's. Sums of weights are taken in double precision.
//!
//! Exact for the choice `none`, and with it any number of samples may share a pass ([`FusedModel::update_block`]).

use std::collections::VecDeque;

use nalgebra::DMatrix;
use terra_model::Contact;
use wide::f32x8;

use super::grid::{GridTable, LANES, OUTPUTS, Stencil};
use super::kernel::{FORCES, ROWS, Sample, forces, quadratic};
use crate::choice::Choice;
use crate::consistency::{AlarmRule, Consistency};
use crate::error::EstimatorError;
use crate::estimator::{History, INFEASIBLE_LOG_LIKELIHOOD, ParameterEstimator, Weighed};
use crate::force_table::TableBox;
use crate::hypothesis::HypothesisSet;
use crate::multiple_model::MultipleModel;
use crate::observation::ForceObservation;
use crate::residual::{covariance, score};
use crate::whiten::{Clock, Prewhitening};

/// Vectors of hypotheses in a tile: its forces, log-weights and residuals stay in the first cache while samples pass over it.
const TILE: usize = 64;
/// Log-weight above which all are shifted back.
const HIGH: f32 = 20.0;
/// Log-weight of the padding.
const NEVER: f32 = -1e30;

/// A hypothesis set weighed in fused passes.
#[derive(Clone, Debug)]
pub struct FusedModel {
    set: HypothesisSet,
    table: GridTable,
    whitening: Option<Prewhitening>,
    rule: AlarmRule,
    /// ln w (padded), the winner's near 0.
    log_weights: Vec<[f32; LANES]>,
    /// Residuals of the last sample, tile by tile, in a tile row by row.
    previous: Vec<[f32; LANES]>,
    /// Forces of one tile.
    scratch: Vec<[f32; LANES]>,
    /// Σ of what was taken out of every log-weight.
    base: f64,
    /// Σ w.
    total: f64,
    best: usize,
    samples: usize,
    clock: Clock,
    recent: VecDeque<ForceObservation>,
    history: Option<History>,
}

impl FusedModel {
    /// Equal prior, choice `none`, no prewhitening; forces are tabulated over a box on contacts like the template.
    ///
    /// # Errors
    /// As [`GridTable::new`]; [`EstimatorError::Impossible`] when no hypothesis is feasible in the whole box.
    pub fn new(
        set: HypothesisSet,
        range: TableBox,
        template: &Contact<f64>,
    ) -> Result<Self, EstimatorError> {
        let table = GridTable::new(&set, range, template)?;
        let vectors = table.padded / LANES;
        let mut log_weights = vec![[NEVER; LANES]; vectors];
        for (lw, feasible) in log_weights
            .as_flattened_mut()
            .iter_mut()
            .zip(&table.feasible)
        {
            if *feasible {
                *lw = 0.0;
            }
        }
        let best = table.feasible.iter().position(|f| *f);
        Ok(FusedModel {
            best: best.ok_or(EstimatorError::Impossible)?,
            total: table.feasible.iter().filter(|f| **f).count() as f64,
            previous: vec![[0.0; LANES]; ROWS * vectors],
            scratch: vec![[0.0; LANES]; FORCES * vectors.min(TILE)],
            log_weights,
            set,
            table,
            whitening: None,
            rule: AlarmRule::default(),
            base: 0.0,
            samples: 0,
            clock: Clock::default(),
            recent: VecDeque::new(),
            history: None,
        })
    }

    /// Takes the correlation from sample to sample out of the residuals.
    #[must_use]
    pub fn with_prewhitening(mut self, whitening: Option<Prewhitening>) -> Self {
        self.whitening = whitening;
        self
    }

    /// When the alarm is raised.
    ///
    /// # Errors
    /// [`EstimatorError::Value`].
    pub fn with_alarm(mut self, rule: AlarmRule) -> Result<Self, EstimatorError> {
        self.rule = rule.checked()?;
        Ok(self)
    }

    /// Keeps the posterior after each sample (of a block: after its last).
    #[must_use]
    pub fn with_history(mut self) -> Self {
        self.history = Some(History {
            ids: self.set.ids(),
            ..History::default()
        });
        self
    }

    /// ln p(all observations so far).
    pub fn log_evidence(&self) -> f64 {
        let n = self.set.len() as f64;
        self.base + (self.total / n).ln()
    }

    /// S at an observation, its slopes in slip and load those of the winner.
    ///
    /// # Errors
    /// [`EstimatorError::OutsideTable`].
    pub fn shared_covariance(
        &self,
        obs: &ForceObservation,
    ) -> Result<DMatrix<f64>, EstimatorError> {
        let stencils = self.stencils(obs)?;
        let m = obs.forces.len();
        let mut slopes = DMatrix::zeros(m, 2 * obs.contacts.len());
        for (k, (at, stencil)) in obs.contacts.iter().zip(&stencils).enumerate() {
            let (w, r) = (at.normal_load, at.radius);
            for (output, (scale, growth)) in
                [(w, 1.0), (r * w, r), (r, 0.0)].into_iter().enumerate()
            {
                let (mut value, mut slip, mut log_load) = (0.0, 0.0, 0.0);
                for n in 0..stencil.at.len() {
                    let place = stencil.at[n] + output * self.table.padded + self.best;
                    let node = self.table.values.get(place).map_or(0.0, |v| f64::from(*v));
                    value += f64::from(stencil.weight[n]) * node;
                    slip += stencil.in_slip[n] * node;
                    log_load += stencil.in_log_load[n] * node;
                }
                for row in 0..m {
                    let a = obs.map[(row, OUTPUTS * k + output)];
                    slopes[(row, 2 * k)] += a * scale * slip;
                    slopes[(row, 2 * k + 1)] += a * (growth * value + scale * log_load / w);
                }
            }
        }
        Ok(covariance(obs, &slopes))
    }

    fn stencils(&self, obs: &ForceObservation) -> Result<Vec<Stencil>, EstimatorError> {
        obs.contacts.iter().map(|c| self.table.stencil(c)).collect()
    }

    /// What all hypotheses share at an observation, and the constant of its density.
    fn sample(&self, obs: &ForceObservation, rho: f64) -> Result<(Sample, f64), EstimatorError> {
        obs.check()?;
        let (m, w) = (obs.forces.len(), obs.contacts.len());
        for (what, found, expected) in [("rows", m, ROWS), ("forces", OUTPUTS * w, FORCES)] {
            if found > expected {
                return Err(EstimatorError::Size {
                    what,
                    found,
                    expected,
                });
            }
        }
        let fail = || EstimatorError::NotPositiveDefinite {
            hypothesis: "all".to_owned(),
            time: obs.time,
        };
        let s = self.shared_covariance(obs)? * (1.0 - rho * rho);
        // The score of no residual is the constant.
        let constant = score(&nalgebra::DVector::zeros(m), &s).ok_or_else(fail)?;
        let factor = s.cholesky().ok_or_else(fail)?;
        let inverse = factor
            .l()
            .solve_lower_triangular(&DMatrix::identity(m, m))
            .ok_or_else(fail)?;
        let mut out = Sample {
            at: [[0; 16]; FORCES],
            weight: [[0.0; 16]; FORCES],
            forces: 0,
            map: [[0.0; FORCES]; ROWS],
            observed: [0.0; ROWS],
            rows: m,
            whiten: [[0.0; ROWS]; ROWS],
            rho: rho as f32,
        };
        for row in 0..m {
            out.observed[row] = obs.forces[row] as f32;
            for column in 0..=row {
                out.whiten[row][column] = inverse[(row, column)] as f32;
            }
        }
        for (k, (at, stencil)) in obs.contacts.iter().zip(self.stencils(obs)?).enumerate() {
            let (load, r) = (at.normal_load, at.radius);
            for (output, scale) in [load, r * load, r].into_iter().enumerate() {
                let column = obs.map.column(OUTPUTS * k + output);
                // A force that no row looks at is not looked up.
                if column.iter().all(|a| *a == 0.0) {
                    continue;
                }
                let f = out.forces;
                for (place, at) in out.at[f].iter_mut().zip(&stencil.at) {
                    *place = at + output * self.table.padded;
                }
                out.weight[f] = stencil.weight;
                for (row, a) in column.iter().enumerate() {
                    out.map[row][f] = (a * scale) as f32;
                }
                out.forces += 1;
            }
        }
        Ok((out, constant.log_density))
    }

    /// Weighs several samples in one pass over the set: the same posterior as one after the other but for S, which the
    /// winner before the block sets. Nothing is changed when it fails.
    ///
    /// # Errors
    /// As [`update`](ParameterEstimator::update).
    pub fn update_block(&mut self, block: &[ForceObservation]) -> Result<(), EstimatorError> {
        let mut clock = self.clock.clone();
        let mut samples = Vec::with_capacity(block.len());
        let mut constant = 0.0;
        for obs in block {
            let rho = clock.correlation(obs, self.whitening)?;
            let (sample, c) = self.sample(obs, rho)?;
            clock.advance(obs);
            constant += c;
            samples.push(sample);
        }
        let Some(last) = block.last() else {
            return Ok(());
        };
        let taken_out = self.pass(&samples);
        self.base += constant + taken_out;
        self.samples += block.len();
        self.clock = clock;
        for obs in block {
            if self.recent.len() >= self.rule.window {
                self.recent.pop_front();
            }
            self.recent.push_back(obs.clone());
        }
        if self.history.is_some() {
            let row = self.probabilities();
            if let Some(history) = &mut self.history {
                history.step.push(self.samples);
                history.time.push(last.time);
                history.probability.push(row);
            }
        }
        Ok(())
    }

    /// The pass itself. Returns what was taken out of every log-weight.
    fn pass(&mut self, samples: &[Sample]) -> f64 {
        let values = &self.table.values;
        let centres = self.centres(samples);
        self.total = 0.0;
        let mut highest = f32::MIN;
        let half = f32x8::splat(-0.5);
        let tiles = self
            .log_weights
            .chunks_mut(TILE)
            .zip(self.previous.chunks_mut(ROWS * TILE));
        for (tile, (weights, previous)) in tiles.enumerate() {
            let from = tile * TILE * LANES;
            let room = FORCES * weights.len();
            let seen = self.scratch.get_mut(..room).unwrap_or_default();
            for (sample, centre) in samples.iter().zip(&centres) {
                let centre = f32x8::splat(*centre);
                forces(sample, values, from, seen);
                for (k, lw) in weights.iter_mut().enumerate() {
                    let q = quadratic(sample, seen, previous, k);
                    *lw = (f32x8::from(*lw) + (q - centre) * half).to_array();
                }
            }
            let (mut sum, mut top) = (f32x8::ZERO, f32x8::splat(f32::MIN));
            let cut = f32x8::splat(-87.0);
            for lw in weights.iter() {
                let lw = f32x8::from(*lw);
                // Beyond single precision a weight is nothing; below the cut the exponential is not asked.
                sum += lw.max(cut).exp() & lw.simd_gt(cut);
                top = top.max(lw);
            }
            self.total += sum.to_array().iter().map(|s| f64::from(*s)).sum::<f64>();
            let top = top.to_array().into_iter().fold(f32::MIN, f32::max);
            if top > highest {
                highest = top;
                let place = weights.as_flattened().iter().position(|lw| *lw == top);
                self.best = from + place.unwrap_or(0);
            }
        }
        let mut taken_out: f64 = centres.iter().map(|c| -0.5 * f64::from(*c)).sum();
        // A new winner far above the old one, or an old one that fell far: all are shifted.
        if highest.abs() > HIGH {
            taken_out += f64::from(highest);
            self.total = 0.0;
            for lw in self.log_weights.as_flattened_mut() {
                *lw = (*lw - highest).max(NEVER);
                self.total += f64::from(*lw).exp();
            }
        }
        taken_out
    }

    /// q of the winner at each sample, from the eight hypotheses around it and a copy of their residuals.
    fn centres(&self, samples: &[Sample]) -> Vec<f32> {
        let (vector, lane) = (self.best / LANES, self.best % LANES);
        let (tile, k) = (vector / TILE, vector % TILE);
        // The last tile may be short.
        let kept = TILE.min(self.log_weights.len() - tile * TILE);
        let own = |row: usize| tile * TILE * ROWS + row * kept + k;
        let mut previous: [[f32; LANES]; ROWS] =
            std::array::from_fn(|row| self.previous.get(own(row)).copied().unwrap_or_default());
        let mut seen = [[0.0; LANES]; FORCES];
        let mut out = Vec::with_capacity(samples.len());
        for sample in samples {
            forces(sample, &self.table.values, vector * LANES, &mut seen);
            let q = quadratic(sample, &seen, &mut previous, 0).to_array();
            out.push(q.get(lane).copied().unwrap_or(0.0));
        }
        out
    }
}

impl ParameterEstimator for FusedModel {
    fn update(&mut self, obs: &ForceObservation) -> Result<(), EstimatorError> {
        self.update_block(std::slice::from_ref(obs))
    }
}

impl Weighed for FusedModel {
    fn name(&self) -> &'static str {
        "fused"
    }

    fn hypotheses(&self) -> &HypothesisSet {
        &self.set
    }

    fn choice(&self) -> &Choice {
        &Choice::None
    }

    fn samples(&self) -> usize {
        self.samples
    }

    fn probabilities(&self) -> Vec<f64> {
        let weights = self.log_weights.as_flattened().iter().take(self.set.len());
        let weights: Vec<f64> = weights.map(|lw| f64::from(*lw).exp()).collect();
        let sum: f64 = weights.iter().sum();
        weights.into_iter().map(|w| w / sum).collect()
    }

    fn log_likelihoods(&self) -> Vec<f64> {
        let penalty = INFEASIBLE_LOG_LIKELIHOOD * self.samples as f64;
        self.log_weights
            .as_flattened()
            .iter()
            .zip(&self.table.feasible)
            .map(|(lw, feasible)| {
                if *feasible {
                    self.base + f64::from(*lw)
                } else {
                    penalty
                }
            })
            .collect()
    }

    fn infeasible_samples(&self) -> Vec<usize> {
        let count = |f: &bool| if *f { 0 } else { self.samples };
        self.table.feasible.iter().map(count).collect()
    }

    fn map_index(&self) -> usize {
        self.best
    }

    fn consistency(&self) -> Consistency {
        let winner = self.set.hypotheses().get(self.best).cloned();
        let told = winner
            .ok_or(EstimatorError::EmptySet)
            .and_then(|h| HypothesisSet::new(vec![h]))
            .and_then(MultipleModel::new)
            .and_then(|m| m.with_prewhitening(self.whitening).with_alarm(self.rule));
        let Ok(mut one) = told else {
            return crate::consistency::Window::default().verdict(self.rule);
        };
        for obs in &self.recent {
            // A winner that cannot carry one sample is counted by its window.
            let _ = one.replay(obs);
        }
        one.consistency()
    }

    fn history(&self) -> Option<&History> {
        self.history.as_ref()
    }
}
