//! The fused update as an estimator.
//!
//! # Equation
//! log2 w_j <- log2 w_j - (q_j - m) log2(e)/2 - log2 w_b, q = r~ᵀ S~⁻¹ r~ of m rows, b the winner so far: its q is m on average,
//! so log-weights stay near 0 where it matters, and single precision is enough (a posterior within 1e-4 of double precision). S is
//! shared: its slopes in slip and load are the winner's. Sums of weights are taken in double precision. To base 2 because the
//! power then needs no product.
//!
//! Exact for the choice `none`, and with it any number of samples may share a pass ([`FusedModel::update_block`]).

use std::collections::VecDeque;
use std::f64::consts::LN_2;
use std::sync::OnceLock;

use nalgebra::DMatrix;
use terra_model::Contact;

use super::grid::{GridTable, LANES, OUTPUTS, Stencil};
use super::held::{HeldCovariance, Whiten, bounded};
use super::kernel::{FORCES, Group, ROWS, Sample, TILE, WHEELS};
use super::mean::Parameters;
use super::shared::{Columns, Shared, factor};
use super::slice::Slices;
use crate::choice::Choice;
use crate::consistency::{AlarmRule, Consistency};
use crate::error::EstimatorError;
use crate::estimator::{History, INFEASIBLE_LOG_LIKELIHOOD, ParameterEstimator, Weighed};
use crate::force_table::TableBox;
use crate::hypothesis::HypothesisSet;
use crate::multiple_model::MultipleModel;
use crate::observation::ForceObservation;
use crate::whiten::{Clock, Prewhitening};

mod pass;

/// Samples of a pass at most: before they are lifted again, log-weights fall by some nats a sample and lose digits.
const PASS: usize = 64;
/// Log-weight of the padding.
const NEVER: f32 = -1e30;

/// A hypothesis set weighed in fused passes.
#[derive(Clone, Debug)]
pub struct FusedModel {
    set: HypothesisSet,
    table: GridTable,
    whitening: Option<Prewhitening>,
    rule: AlarmRule,
    /// log2 w (padded), the winner's near 0.
    log_weights: Vec<[f32; LANES]>,
    /// Residuals of the last sample, tile by tile, in a tile row by row; empty where nothing is whitened in time.
    previous: Vec<[f32; LANES]>,
    /// Room for the residuals of the tile in hand.
    residuals: Vec<[f32; LANES]>,
    /// Forces at the loads that stay.
    slices: Slices,
    /// What hypotheses share at the samples of the block in hand.
    block: Vec<Sample>,
    /// Σ of what was taken out of every log-weight.
    base: f64,
    /// Σ w.
    total: f64,
    /// First vector of the run that holds the winner: its place there is sought when it is asked for.
    run: usize,
    /// log2 w of the winner: taken out of all with the next pass.
    top: f32,
    samples: usize,
    clock: Clock,
    recent: VecDeque<ForceObservation>,
    history: Option<History>,
    /// Made when a mean is first asked for; `None` in it for several laws, whose parameters have none.
    parameters: OnceLock<Option<Parameters>>,
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
        let mut log_weights = vec![[NEVER; LANES]; table.vectors];
        for (lw, feasible) in log_weights
            .as_flattened_mut()
            .iter_mut()
            .zip(&table.feasible)
        {
            if *feasible {
                *lw = 0.0;
            }
        }
        if !table.feasible.contains(&true) {
            return Err(EstimatorError::Impossible);
        }
        Ok(FusedModel {
            run: 0,
            total: table.feasible.iter().filter(|f| **f).count() as f64,
            previous: Vec::new(),
            residuals: vec![[0.0; LANES]; ROWS * TILE],
            slices: Slices::default(),
            block: Vec::new(),
            log_weights,
            set,
            table,
            whitening: None,
            rule: AlarmRule::default(),
            base: 0.0,
            top: 0.0,
            samples: 0,
            clock: Clock::default(),
            recent: VecDeque::new(),
            history: None,
            parameters: OnceLock::new(),
        })
    }

    /// Takes the correlation from sample to sample out of the residuals.
    #[must_use]
    pub fn with_prewhitening(mut self, whitening: Option<Prewhitening>) -> Self {
        self.whitening = whitening;
        // Without whitening nobody keeps residuals, so a sample already taken is no base for the next.
        self.clock = Clock::default();
        let rows = whitening.map_or(0, |_| ROWS * self.table.vectors);
        self.previous = vec![[0.0; LANES]; rows];
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

    /// The means of the parameters (p, in the order of the law) under the posterior, to 1e-6 of their spread: those of
    /// [`belief`](Weighed::belief) without its covariance, at a cost that every sample can bear.
    ///
    /// # Errors
    /// [`EstimatorError::NotSupported`] for hypotheses of several laws, [`EstimatorError::Size`] for another number than p.
    pub fn mean_into(&self, mean: &mut [f64]) -> Result<(), EstimatorError> {
        let made = self
            .parameters
            .get_or_init(|| Parameters::of(&self.set, self.table.vectors));
        let Some(parameters) = made else {
            return Err(EstimatorError::NotSupported {
                estimator: "fused",
                choice: "mean of the parameters".to_owned(),
                reason: "the hypotheses have several laws",
            });
        };
        if mean.len() != parameters.count() {
            return Err(EstimatorError::Size {
                what: "means",
                found: mean.len(),
                expected: parameters.count(),
            });
        }
        parameters.mean(&self.log_weights, self.total, mean);
        Ok(())
    }

    /// S at an observation, its slopes in slip and load those of the winner.
    ///
    /// # Errors
    /// [`EstimatorError::OutsideTable`].
    pub fn shared_covariance(
        &self,
        obs: &ForceObservation,
    ) -> Result<DMatrix<f64>, EstimatorError> {
        let mut stencils = [Stencil::default(); WHEELS];
        self.stencils(obs, &mut stencils)?;
        let s = self.shared(obs, &stencils);
        let m = obs.forces.len();
        Ok(DMatrix::from_fn(m, m, |i, j| s[i.min(j)][i.max(j)]))
    }

    /// The look-ups of an observation's wheels.
    fn stencils(
        &self,
        obs: &ForceObservation,
        out: &mut [Stencil; WHEELS],
    ) -> Result<(), EstimatorError> {
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
        for (stencil, contact) in out.iter_mut().zip(&obs.contacts) {
            *stencil = self.table.stencil(contact)?;
        }
        Ok(())
    }

    /// S, by columns.
    fn shared(&self, obs: &ForceObservation, stencils: &[Stencil; WHEELS]) -> Columns {
        let mut shared = Shared::new(obs);
        let place = self.table.place(self.best());
        let wheels = obs.contacts.iter().zip(stencils).zip(columns(obs));
        for (k, ((at, stencil), columns)) in wheels.enumerate() {
            let (w, r) = (at.normal_load, at.radius);
            let scales = [(w, 1.0), (r * w, r), (r, 0.0)];
            for (output, (column, (scale, growth))) in columns.zip(scales).enumerate() {
                if column.iter().all(|a| *a == 0.0) {
                    continue;
                }
                let [value, slip, log_load] = stencil.value(&self.table.values, place, output);
                let in_load = growth * value + scale * log_load / w;
                shared.slope(k, column, scale * slip, in_load);
            }
        }
        shared.covariance()
    }

    /// Makes L⁻¹, S (1 - ρ²) = L Lᵀ; returns the constant of its density.
    #[inline]
    fn factored(
        &self,
        obs: &ForceObservation,
        stencils: &[Stencil; WHEELS],
        rho: f64,
        inverse: &mut Columns,
    ) -> Result<f64, EstimatorError> {
        let s = self.shared(obs, stencils);
        let constant = factor(s, obs.forces.len(), 1.0 - rho * rho, inverse);
        constant
            .filter(|c| c.is_finite())
            .ok_or_else(|| EstimatorError::NotPositiveDefinite {
                hypothesis: "all".to_owned(),
                time: obs.time,
            })
    }

    /// What all hypotheses share at an observation; returns the constant of its density.
    fn sample(
        &self,
        obs: &ForceObservation,
        rho: f64,
        slices: &mut Slices,
        out: &mut Sample,
    ) -> Result<f64, EstimatorError> {
        let mut stencils = [Stencil::default(); WHEELS];
        self.stencils(obs, &mut stencils)?;
        let m = obs.forces.len();
        let mut inverse = Columns::default();
        let constant = self.factored(obs, &stencils, rho, &mut inverse)?;
        (out.rows, out.rho) = (m, rho as f32);
        let whiten = Whiten::new(&inverse, m);
        let rows = out.row.iter_mut().zip(obs.forces.iter());
        for (k, (row, observed)) in rows.enumerate() {
            row.groups.clear();
            let own = whiten.own[k];
            bounded(*observed, own)?;
            // Whitened in time, residuals are wanted as they are.
            let own_now = if self.whitening.is_some() { 1.0 } else { own };
            row.observed = (observed * own_now) as f32;
            row.scale = own as f32;
            row.whiten = whiten.above[k];
            let wheels = obs.contacts.iter().zip(&stencils).zip(columns(obs));
            for ((at, stencil), columns) in wheels {
                let slice = slices.find(at.normal_load);
                let (load, r) = (at.normal_load, at.radius);
                let scales = [load, r * load, r];
                for (output, (column, scale)) in columns.zip(scales).enumerate() {
                    // A force that the row does not look at is not looked up.
                    let share = column.get(k).map_or(0.0, |a| a * scale * own_now);
                    if share == 0.0 {
                        continue;
                    }
                    if let Some(k) = slice {
                        let first = stencil.first_slip();
                        let block = slices.ready(k, &self.table, first, output);
                        let along = stencil.slip_weights();
                        row.groups.push(Group::sliced(k, block, along, share));
                    } else {
                        stencil.groups(output, share, &mut row.groups);
                    }
                }
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
        let mut slices = std::mem::take(&mut self.slices);
        slices.begin(&self.table, block);
        let filled = self.fill(block, &mut slices, &mut samples);
        self.slices = slices;
        let passed = filled.map(|constant| {
            let samples = samples.get(..block.len()).unwrap_or_default();
            let taken_out: f64 = samples.chunks(PASS).map(|some| self.pass(some)).sum();
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

    /// S of an observation, as the winner now makes it, and its map, for [`update_held`](Self::update_held).
    ///
    /// # Errors
    /// As [`update`](ParameterEstimator::update); [`EstimatorError::NotSupported`] with prewhitening or a history, which want a
    /// time with every sample.
    pub fn hold(&self, obs: &ForceObservation) -> Result<HeldCovariance, EstimatorError> {
        self.holds()?;
        let mut stencils = [Stencil::default(); WHEELS];
        self.stencils(obs, &mut stencils)?;
        let (m, w) = (obs.forces.len(), obs.contacts.len());
        let mut inverse = Columns::default();
        let constant = self.factored(obs, &stencils, 0.0, &mut inverse)?;
        Ok(HeldCovariance::new(
            &inverse,
            (m, w),
            constant,
            self.table.radius,
            obs.map.as_slice().chunks_exact(m),
        ))
    }

    fn holds(&self) -> Result<(), EstimatorError> {
        let (with, reason) = match (&self.whitening, &self.history) {
            (Some(_), _) => ("prewhitening", "a held sample has no time"),
            (_, Some(_)) => ("history", "a held sample has no time"),
            _ => return Ok(()),
        };
        Err(EstimatorError::NotSupported {
            estimator: "fused",
            choice: with.to_owned(),
            reason,
        })
    }

    /// Weighs one sample with a covariance and a map that were [held](Self::hold): slip and normal load \[N\] of each wheel,
    /// and the forces \[N, N m, m\] in the order of the map's rows. The posterior is that of
    /// [`update`](ParameterEstimator::update) with the same S; a set of 21 on one wheel costs an eighth.
    ///
    /// S is not renewed as slip, load or the winner change, the alarm is not fed ([`consistency`](Weighed::consistency) knows
    /// nothing of these samples), and as no time is given none is checked. Nothing is changed when it fails.
    ///
    /// # Errors
    /// [`EstimatorError::Size`] for other numbers of wheels or forces than were held, [`EstimatorError::Value`] for a force that
    /// is not finite or a million standard deviations away, [`EstimatorError::OutsideTable`], [`EstimatorError::NotSupported`] as [`hold`](Self::hold).
    pub fn update_held(
        &mut self,
        held: &HeldCovariance,
        slips_and_loads: &[(f64, f64)],
        forces: &[f64],
    ) -> Result<(), EstimatorError> {
        let (table, slices) = (&self.table, &self.slices);
        let pair = held.pair.as_ref();
        let pair = pair.and_then(|pair| pair.at(slips_and_loads, forces, table, slices));
        match pair {
            Some(pair) if self.whitening.is_none() && self.history.is_none() => {
                self.base += held.constant + self.pass_pair(&pair);
                self.samples += 1;
                Ok(())
            }
            _ => self.update_held_any(held, slips_and_loads, forces),
        }
    }

    /// The same for whatever sample.
    #[inline(never)]
    fn update_held_any(
        &mut self,
        held: &HeldCovariance,
        slips_and_loads: &[(f64, f64)],
        forces: &[f64],
    ) -> Result<(), EstimatorError> {
        self.holds()?;
        held.check(slips_and_loads, forces)?;
        let loads = || slips_and_loads.iter().map(|(_, load)| *load);
        let mut samples = std::mem::take(&mut self.block);
        if samples.is_empty() {
            samples.push(Sample::default());
        }
        self.slices.keep(&self.table, loads(), |_| false);
        let filled = samples.first_mut().map_or(Ok(()), |sample| {
            let (table, slices) = (&self.table, &mut self.slices);
            held.fill(slips_and_loads, forces, table, slices, sample)
        });
        if filled.is_ok() {
            self.slices.end(loads());
            self.base += held.constant + self.pass(samples.get(..1).unwrap_or_default());
            self.samples += 1;
        }
        self.block = samples;
        filled
    }

    /// What the samples of a block share; returns the constants of their densities.
    fn fill(
        &self,
        block: &[ForceObservation],
        slices: &mut Slices,
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
            constant += self.sample(obs, rho, slices, sample)?;
        }
        Ok(constant)
    }

    /// Keeps an observation for the alarm, in the room of the oldest.
    fn remember(&mut self, obs: &ForceObservation) {
        if self.recent.len() < self.rule.window {
            return self.recent.push_back(obs.clone());
        }
        self.recent.rotate_left(1);
        let Some(old) = self.recent.back_mut() else {
            return;
        };
        if old.forces.len() == obs.forces.len()
            && old.covariance.shape() == obs.covariance.shape()
            && old.map.shape() == obs.map.shape()
        {
            (old.time, old.group) = (obs.time, obs.group);
            let copy = |to: &mut [f64], from: &[f64]| to.copy_from_slice(from);
            copy(old.forces.as_mut_slice(), obs.forces.as_slice());
            copy(old.map.as_mut_slice(), obs.map.as_slice());
            copy(old.covariance.as_mut_slice(), obs.covariance.as_slice());
            old.contacts.clone_from(&obs.contacts);
        } else {
            *old = obs.clone();
        }
    }
}

/// The columns of the map, wheel by wheel: what its rows take of D, T and z.
fn columns(obs: &ForceObservation) -> impl Iterator<Item = std::slice::ChunksExact<'_, f64>> {
    let m = obs.forces.len();
    let wheels = obs.map.as_slice().chunks_exact(OUTPUTS * m);
    wheels.map(move |wheel| wheel.chunks_exact(m))
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
        let weights: Vec<f64> = weights.map(|lw| f64::from(*lw).exp2()).collect();
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
                    self.base + f64::from(*lw) * LN_2
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
        self.best()
    }

    fn consistency(&self) -> Consistency {
        let winner = self.set.hypotheses().get(self.best()).cloned();
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
