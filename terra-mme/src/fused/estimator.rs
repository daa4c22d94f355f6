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
use super::kernel::{FORCES, ROWS, Sample, TILE, WHEELS, one, weigh_tile};
use super::shared::{Shared, factor};
use crate::choice::Choice;
use crate::consistency::{AlarmRule, Consistency};
use crate::error::EstimatorError;
use crate::estimator::{History, INFEASIBLE_LOG_LIKELIHOOD, ParameterEstimator, Weighed};
use crate::force_table::TableBox;
use crate::hypothesis::HypothesisSet;
use crate::multiple_model::MultipleModel;
use crate::observation::ForceObservation;
use crate::whiten::{Clock, Prewhitening};

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
    /// Of the block in hand: what its hypotheses share, and q of the winner.
    block: Vec<Sample>,
    centres: Vec<f32>,
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
            block: Vec::new(),
            centres: Vec::new(),
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
        let s = self.shared(obs, &self.stencils(obs)?)?;
        let m = obs.forces.len();
        Ok(DMatrix::from_fn(m, m, |i, j| s[i.max(j)][i.min(j)]))
    }

    fn stencils(&self, obs: &ForceObservation) -> Result<[Stencil; WHEELS], EstimatorError> {
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
        let mut out = [Stencil::default(); WHEELS];
        for (stencil, contact) in out.iter_mut().zip(&obs.contacts) {
            *stencil = self.table.stencil(contact)?;
        }
        Ok(out)
    }

    /// S, lower triangle.
    fn shared(
        &self,
        obs: &ForceObservation,
        stencils: &[Stencil; WHEELS],
    ) -> Result<[[f64; ROWS]; ROWS], EstimatorError> {
        let mut shared = Shared::new(obs);
        for (k, (at, stencil)) in obs.contacts.iter().zip(stencils).enumerate() {
            let (w, r) = (at.normal_load, at.radius);
            for (output, (scale, growth)) in
                [(w, 1.0), (r * w, r), (r, 0.0)].into_iter().enumerate()
            {
                let column = OUTPUTS * k + output;
                if obs.map.column(column).iter().all(|a| *a == 0.0) {
                    continue;
                }
                let place = output * self.table.padded + self.best;
                let [value, slip, log_load] = stencil.value(&self.table.values, place);
                let in_load = growth * value + scale * log_load / w;
                shared.slope(k, column, scale * slip, in_load);
            }
        }
        Ok(shared.covariance())
    }

    /// What all hypotheses share at an observation; returns the constant of its density.
    fn sample(
        &self,
        obs: &ForceObservation,
        rho: f64,
        out: &mut Sample,
    ) -> Result<f64, EstimatorError> {
        let stencils = self.stencils(obs)?;
        let m = obs.forces.len();
        let s = self.shared(obs, &stencils)?;
        let factored = factor(s, m, 1.0 - rho * rho).filter(|(_, c)| c.is_finite());
        let (inverse, constant) = factored.ok_or_else(|| EstimatorError::NotPositiveDefinite {
            hypothesis: "all".to_owned(),
            time: obs.time,
        })?;
        (out.rows, out.forces, out.rho) = (m, 0, rho as f32);
        for (to, from) in out.observed.iter_mut().zip(obs.forces.iter()) {
            *to = *from as f32;
        }
        let entries = inverse.as_flattened().iter();
        for (to, from) in out.whiten.as_flattened_mut().iter_mut().zip(entries) {
            *to = *from as f32;
        }
        let wheels = obs.contacts.iter().zip(&stencils).zip(&mut out.nodes);
        for (k, ((at, stencil), nodes)) in wheels.enumerate() {
            stencil.nodes(nodes);
            let (load, r) = (at.normal_load, at.radius);
            for (output, scale) in [load, r * load, r].into_iter().enumerate() {
                let column = obs.map.column(OUTPUTS * k + output);
                // A force that no row looks at is not looked up.
                if column.iter().all(|a| *a == 0.0) {
                    continue;
                }
                let looked = &mut out.looked[out.forces];
                (looked.wheel, looked.offset) = (k, output * self.table.padded);
                for (share, a) in looked.share.iter_mut().zip(column.iter()) {
                    *share = (a * scale) as f32;
                }
                out.forces += 1;
            }
        }
        Ok(constant)
    }

    /// Weighs several samples in one pass over the set: the same posterior as one after the other but for S, which the
    /// winner before the block sets. Nothing is changed when it fails.
    ///
    /// # Errors
    /// As [`update`](ParameterEstimator::update).
    pub fn update_block(&mut self, block: &[ForceObservation]) -> Result<(), EstimatorError> {
        let mut samples = std::mem::take(&mut self.block);
        let passed = self.fill(block, &mut samples).map(|constant| {
            let taken_out = self.pass(samples.get(..block.len()).unwrap_or_default());
            self.base += constant + taken_out;
        });
        self.block = samples;
        passed?;
        let Some(last) = block.last() else {
            return Ok(());
        };
        self.samples += block.len();
        self.clock.advance(last);
        for obs in block {
            self.remember(obs);
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

    /// What the samples of a block share; returns the constants of their densities.
    fn fill(
        &self,
        block: &[ForceObservation],
        samples: &mut Vec<Sample>,
    ) -> Result<f64, EstimatorError> {
        if samples.len() < block.len() {
            samples.resize(block.len(), Sample::default());
        }
        let mut constant = 0.0;
        for (k, (obs, sample)) in block.iter().zip(samples).enumerate() {
            let rho = match k.checked_sub(1).and_then(|k| block.get(k)) {
                None => self.clock.correlation(obs, self.whitening)?,
                Some(before) => Clock::between(before, obs, self.whitening)?,
            };
            constant += self.sample(obs, rho, sample)?;
        }
        Ok(constant)
    }

    /// Keeps an observation for the alarm, in the room of the oldest.
    fn remember(&mut self, obs: &ForceObservation) {
        let full = self.recent.len() >= self.rule.window;
        let oldest = if full { self.recent.pop_front() } else { None };
        match oldest {
            Some(mut old)
                if old.forces.len() == obs.forces.len()
                    && old.covariance.shape() == obs.covariance.shape()
                    && old.map.shape() == obs.map.shape() =>
            {
                (old.time, old.group) = (obs.time, obs.group);
                old.forces.copy_from(&obs.forces);
                old.map.copy_from(&obs.map);
                old.covariance.copy_from(&obs.covariance);
                old.contacts.clone_from(&obs.contacts);
                self.recent.push_back(old);
            }
            _ => self.recent.push_back(obs.clone()),
        }
    }

    /// The pass itself. Returns what was taken out of every log-weight.
    fn pass(&mut self, samples: &[Sample]) -> f64 {
        let values = &self.table.values;
        // Of one sample over one tile the winner's q is among those of the tile.
        let alone = samples.len() == 1 && self.log_weights.len() <= TILE;
        let mut centres = std::mem::take(&mut self.centres);
        centres.clear();
        if !alone {
            let vector = self.best / LANES;
            let (lane, previous) = (self.best % LANES, self.residuals(vector));
            one(
                samples,
                values,
                vector * LANES,
                lane,
                previous,
                &mut centres,
            );
        }
        self.total = 0.0;
        let mut highest = f32::MIN;
        let mut centre = 0.0;
        let best = self.best;
        let tiles = self
            .log_weights
            .chunks_mut(TILE)
            .zip(self.previous.chunks_mut(ROWS * TILE));
        for (tile, (weights, previous)) in tiles.enumerate() {
            let from = tile * TILE * LANES;
            centre = weigh_tile(samples, &centres, best, values, from, previous, weights);
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
        let mut taken_out = if alone {
            -0.5 * f64::from(centre)
        } else {
            centres.iter().map(|c| -0.5 * f64::from(*c)).sum()
        };
        self.centres = centres;
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

    /// Residuals of the last sample, of one vector of hypotheses.
    fn residuals(&self, vector: usize) -> [[f32; LANES]; ROWS] {
        let (tile, k) = (vector / TILE, vector % TILE);
        // The last tile may be short.
        let kept = TILE.min(self.log_weights.len() - tile * TILE);
        let own = |row: usize| tile * TILE * ROWS + row * kept + k;
        std::array::from_fn(|row| self.previous.get(own(row)).copied().unwrap_or_default())
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
