//! N hypotheses under the fused pass on the forces of a side or of one wheel, against Bayes' rule by one hypothesis after the other.

use std::sync::Arc;

use terra_mme::{
    ForceObservation, FusedModel, HeldCovariance, HypothesisSet, MultipleModel, ParameterEstimator,
    TableBox, Weighed,
};
use terra_model::{Contact, ForceLaw, Registry, catalogue};

use crate::error::{BenchError, check};

/// Samples of a block.
pub const BLOCK: usize = 16;
/// Samples of the log.
const SAMPLES: usize = 4 * BLOCK;
/// Coarse, so that a large set is built quickly; the pass costs the same on any grid.
const GRID: TableBox = TableBox {
    slip: (0.1, 0.9),
    load: (180.0, 320.0),
    nodes: (10, 4),
};

/// What is observed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wheels {
    /// Drawbar pull and torque of one wheel.
    One,
    /// The same, under a load that is another at every sample.
    Moving,
    /// The summed pull of two wheels and the torque of each.
    Side,
}

impl Wheels {
    /// Normal loads at sample k \[N\].
    fn loads(self, k: usize) -> Vec<f64> {
        match self {
            Wheels::One => vec![245.0],
            Wheels::Moving => vec![225.0 + 0.5 * k as f64],
            Wheels::Side => vec![210.0, 280.0],
        }
    }
}

/// A set, and a log that goes round.
pub struct Fused {
    model: FusedModel,
    log: Vec<ForceObservation>,
    /// Slip and load of each wheel, sample by sample.
    at: Vec<Vec<(f64, f64)>>,
    /// Of the parameters.
    mean: Vec<f64>,
    next: usize,
}

impl Fused {
    /// N copies of a clay, 2 % off, and a side of a robot on that clay with errors that cancel over the log; a side of one
    /// wheel is that wheel's drawbar pull and torque.
    ///
    /// # Errors
    /// [`BenchError::Estimator`], [`BenchError::Model`].
    pub fn new(n: usize, wheels: Wheels) -> Result<Self, BenchError> {
        let law = Arc::new(Registry::builtin().law("wong-reece")?);
        let clay = catalogue::find("lean_clay_22")?.parameters(law.model())?;
        let set = HypothesisSet::from_vectors(&law, "clay", [clay.clone()])?;
        let set = set.perturbed(n, 0.02, 1)?;
        let template = Contact::new(0.3, 245.25, 0.254, 0.15);
        let mut log = Vec::new();
        for k in 0..SAMPLES {
            let slip = 0.8 - 0.6 * k as f64 / SAMPLES as f64;
            let loads = wheels.loads(k);
            let (w, m) = (loads.len(), 1 + loads.len());
            let mut forces = nalgebra::DVector::zeros(3 * w);
            let mut contacts = Vec::new();
            for (wheel, load) in loads.into_iter().enumerate() {
                let at = Contact::new(slip, load, template.radius, template.width);
                let f = law.forces(&clay, &at)?;
                forces[3 * wheel] = f.drawbar_pull;
                forces[3 * wheel + 1] = f.resistive_torque;
                contacts.push(at);
            }
            let map = ForceObservation::side_map(w);
            let off = if k % 2 == 0 { 1.0 } else { -1.0 };
            let errors = [off, 0.3 * off, -0.3 * off];
            // Slips and loads are known.
            let sd = [20.0, 8.0, 8.0];
            let variances = (0..m + 2 * w).map(|k| if k < m { sd[k] * sd[k] } else { 0.0 });
            log.push(ForceObservation {
                time: k as f64,
                group: k,
                forces: &map * forces + nalgebra::DVector::from_column_slice(&errors[..m]),
                map,
                contacts,
                covariance: nalgebra::DMatrix::from_diagonal(&nalgebra::DVector::from_iterator(
                    m + 2 * w,
                    variances,
                )),
            });
        }
        Ok(Fused {
            model: FusedModel::new(set, GRID, &template)?,
            at: log
                .iter()
                .map(|o| o.contacts.iter().map(|c| (c.slip, c.normal_load)).collect())
                .collect(),
            log,
            mean: vec![0.0; clay.len()],
            next: 0,
        })
    }

    /// One sample.
    ///
    /// # Errors
    /// [`BenchError::Estimator`].
    pub fn step(&mut self) -> Result<(), BenchError> {
        let k = self.next % SAMPLES;
        self.next += 1;
        Ok(self.model.update_block(&self.log[k..=k])?)
    }

    /// The covariance of the log's first sample, for [`step_held`](Self::step_held): it is the same at all.
    ///
    /// # Errors
    /// [`BenchError::Estimator`].
    pub fn hold(&self) -> Result<HeldCovariance, BenchError> {
        Ok(self.model.hold(&self.log[0])?)
    }

    /// One sample with a covariance that was held.
    ///
    /// # Errors
    /// [`BenchError::Estimator`].
    pub fn step_held(&mut self, held: &HeldCovariance) -> Result<(), BenchError> {
        let k = self.next % SAMPLES;
        self.next += 1;
        let forces = self.log[k].forces.as_slice();
        Ok(self.model.update_held(held, &self.at[k], forces)?)
    }

    /// The same, and the means of the parameters.
    ///
    /// # Errors
    /// [`BenchError::Estimator`].
    pub fn step_held_with_mean(&mut self, held: &HeldCovariance) -> Result<(), BenchError> {
        self.step_held(held)?;
        Ok(self.model.mean_into(&mut self.mean)?)
    }

    /// [`BLOCK`] samples in one pass.
    ///
    /// # Errors
    /// [`BenchError::Estimator`].
    pub fn block(&mut self) -> Result<(), BenchError> {
        let k = self.next % SAMPLES / BLOCK * BLOCK;
        self.next = k + BLOCK;
        Ok(self.model.update_block(&self.log[k..k + BLOCK])?)
    }

    /// A new set of the same kind after the whole log, sample by sample, in blocks and with S held, against one hypothesis after the
    /// other in double precision with the law itself.
    ///
    /// # Errors
    /// [`BenchError::Wrong`], [`BenchError::Estimator`].
    pub fn check(n: usize, wheels: Wheels) -> Result<(), BenchError> {
        let (mut one, mut blocks) = (Fused::new(n, wheels)?, Fused::new(n, wheels)?);
        let mut oracle = MultipleModel::new(one.model.hypotheses().clone())?;
        for o in &one.log.clone() {
            oracle.update(o)?;
            one.step()?;
        }
        for _ in 0..one.log.len() / BLOCK {
            blocks.block()?;
        }
        let mut held = Fused::new(n, wheels)?;
        let covariance = held.hold()?;
        for _ in 0..held.log.len() {
            held.step_held_with_mean(&covariance)?;
        }
        if let Some(belief) = oracle.belief().most_probable() {
            for (k, (mean, sd)) in
                (0..).zip(held.mean.iter().zip(0..).map(|(m, k)| (m, belief.sd(k))))
            {
                let what = format!("mean of parameter {k} of {n}, with S held");
                let spread = sd.unwrap_or(0.0).max(1e-9 * mean.abs()).max(1e-12);
                check(&what, *mean, belief.mean[k], spread, 1e-2)?;
            }
        }
        let expected = oracle.probabilities();
        for (j, p) in expected.iter().enumerate() {
            for (name, found) in [
                ("by sample", &one),
                ("in blocks", &blocks),
                ("with S held", &held),
            ] {
                let q = found.model.probabilities();
                let what = format!("posterior of hypothesis {j} of {n}, {name}");
                check(&what, q[j], *p, 1.0, 5e-3)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pass_is_bayes() {
        for n in [3, 21] {
            for wheels in [Wheels::One, Wheels::Moving, Wheels::Side] {
                Fused::check(n, wheels).unwrap();
            }
        }
    }
}
