//! Whitened residuals of many observations and their exact Jacobian in the fit vector.
//!
//! # Equation
//! Row block k: L_k⁻¹ (r_k - ρ_k r_(k-1)), L_k L_kᵀ = S_k (1 - ρ_k²); columns L_k⁻¹ (A dF_k/dq - ρ_k A dF_(k-1)/dq).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use terra_model::{Contact, ForceLaw, Law};

use crate::error::EstimatorError;
use crate::fit_space::FitSpace;
use crate::observation::ForceObservation;
use crate::prediction::model_error;
use crate::residual::{covariance, observes_sinkage};
use crate::whiten::{Clock, Prewhitening};

/// What a fit is about.
pub(crate) struct Problem<'a> {
    law: &'a Law,
    space: &'a FitSpace,
    observations: &'a [ForceObservation],
    /// Where slip and load of each observation most probably were.
    inputs: Vec<Inputs>,
    /// ρ between each observation and the one before.
    correlations: Vec<f64>,
    rows: usize,
}

/// Contacts of an observation, and what forces change from there to where they were measured, A dF/dx (x_measured - x) (m).
struct Inputs {
    contacts: Vec<Contact<f64>>,
    back: DVector<f64>,
}

impl Inputs {
    fn measured(obs: &ForceObservation) -> Self {
        Inputs {
            contacts: obs.contacts.clone(),
            back: DVector::zeros(obs.forces.len()),
        }
    }
}

/// Everything at one q.
pub(crate) struct Linearised {
    /// Whitened residual (rows).
    pub(crate) residual: DVector<f64>,
    /// Its Jacobian (rows x dim).
    pub(crate) jacobian: DMatrix<f64>,
    /// The whitening of each observation.
    pub(crate) factors: Vec<Cholesky<f64, Dyn>>,
}

impl Linearised {
    /// ln p(observations) at this point.
    pub(crate) fn log_density(&self) -> f64 {
        let log_det: f64 = self
            .factors
            .iter()
            .flat_map(|f| {
                f.l_dirty()
                    .diagonal()
                    .iter()
                    .map(|d| d.ln())
                    .collect::<Vec<_>>()
            })
            .sum();
        let rows = self.residual.len() as f64;
        -0.5 * (self.residual.norm_squared() + rows * (2.0 * std::f64::consts::PI).ln()) - log_det
    }
}

/// One observation before whitening: r (m), A dF/dq (m x dim), S (m x m).
struct One {
    residual: DVector<f64>,
    slopes: DMatrix<f64>,
    covariance: DMatrix<f64>,
    /// A dF/d(slip, load) (m x 2w).
    in_inputs: DMatrix<f64>,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(
        law: &'a Law,
        space: &'a FitSpace,
        observations: &'a [ForceObservation],
        whitening: Option<Prewhitening>,
    ) -> Result<Self, EstimatorError> {
        if observations.is_empty() {
            return Err(EstimatorError::NoObservations);
        }
        let mut clock = Clock::default();
        let mut correlations = Vec::with_capacity(observations.len());
        for obs in observations {
            obs.check()?;
            correlations.push(clock.correlation(obs, whitening)?);
            clock.advance(obs);
        }
        let rows = observations.iter().map(|o| o.forces.len()).sum();
        Ok(Problem {
            law,
            space,
            observations,
            inputs: observations.iter().map(Inputs::measured).collect(),
            correlations,
            rows,
        })
    }

    /// Moves slip and load of every observation to where they most probably were if q is right.
    ///
    /// Noise of a measured slip moves a prediction and its slopes alike, which biases a fit at the measured ones: there the two go
    /// together, at the most probable ones they do not.
    ///
    /// # Equation
    /// x = x_measured - [C Hᵀ S⁻¹ r]_x, with r, S and H as linearised where x was before.
    ///
    /// # Reference
    /// W. A. Fuller, *Measurement Error Models*, Wiley 1987, section 3.2 (nonlinear models).
    pub(crate) fn seek_inputs(&mut self, q: &[f64]) -> Result<(), EstimatorError> {
        let p = self.space.parameters(q);
        let dp_dq = self.space.jacobian(q);
        let mut moved = Vec::with_capacity(self.observations.len());
        for (obs, inputs) in self.observations.iter().zip(&self.inputs) {
            let one = self.one(obs, inputs, &p, &dp_dq)?;
            moved.push(
                self.most_probable(obs, &one, &p)
                    .unwrap_or_else(|| Inputs::measured(obs)),
            );
        }
        self.inputs = moved;
        Ok(())
    }

    /// None where the law has no answer there.
    fn most_probable(&self, obs: &ForceObservation, one: &One, p: &[f64]) -> Option<Inputs> {
        let (m, w) = (obs.forces.len(), obs.contacts.len());
        let told = one.covariance.clone().cholesky()?.solve(&one.residual);
        let noise = &obs.covariance;
        let of_inputs = noise.view((m, m), (2 * w, 2 * w)) * one.in_inputs.tr_mul(&told)
            - noise.view((m, 0), (2 * w, m)) * &told;
        let mut contacts = obs.contacts.clone();
        let mut in_inputs = DMatrix::zeros(3 * w, 2 * w);
        for (k, at) in contacts.iter_mut().enumerate() {
            at.slip -= of_inputs[2 * k];
            at.normal_load -= of_inputs[2 * k + 1];
            let (_, jac) = self.law.jacobian(p, at).ok()?;
            in_inputs
                .view_mut((3 * k, 2 * k), (3, 2))
                .copy_from(&jac.view((0, p.len()), (3, 2)));
        }
        let back = &obs.map * in_inputs * of_inputs;
        Some(Inputs { contacts, back })
    }

    /// Residuals and Jacobians at q, whitened by the covariance at q.
    pub(crate) fn linearise(&self, q: &[f64]) -> Result<Linearised, EstimatorError> {
        let p = self.space.parameters(q);
        let dp_dq = self.space.jacobian(q);
        let n = self.space.dim();
        let mut residual = DVector::zeros(self.rows);
        let mut jacobian = DMatrix::zeros(self.rows, n);
        let mut factors = Vec::with_capacity(self.observations.len());
        let mut previous: Option<(DVector<f64>, DMatrix<f64>)> = None;
        let mut row = 0;
        for ((obs, inputs), &rho) in self
            .observations
            .iter()
            .zip(&self.inputs)
            .zip(&self.correlations)
        {
            let One {
                residual: r,
                slopes,
                covariance: s,
                ..
            } = self.one(obs, inputs, &p, &dp_dq)?;
            let m = r.len();
            let (white, columns) = match &previous {
                Some((last, last_slopes)) if rho > 0.0 => {
                    (&r - last * rho, &slopes - last_slopes * rho)
                }
                _ => (r.clone(), slopes.clone()),
            };
            let factor = (s * (1.0 - rho * rho)).cholesky().ok_or_else(|| {
                EstimatorError::NotPositiveDefinite {
                    hypothesis: "fit".to_owned(),
                    time: obs.time,
                }
            })?;
            let solved = factor.l_dirty().solve_lower_triangular(&white);
            let solved_columns = factor.l_dirty().solve_lower_triangular(&columns);
            let (white, columns) =
                solved
                    .zip(solved_columns)
                    .ok_or(EstimatorError::Decomposition {
                        what: "whitening of a residual",
                    })?;
            residual.rows_mut(row, m).copy_from(&white);
            jacobian.rows_mut(row, m).copy_from(&columns);
            factors.push(factor);
            previous = Some((r, slopes));
            row += m;
        }
        Ok(Linearised {
            residual,
            jacobian,
            factors,
        })
    }

    /// One observation before whitening.
    fn one(
        &self,
        obs: &ForceObservation,
        inputs: &Inputs,
        p: &[f64],
        dp_dq: &DMatrix<f64>,
    ) -> Result<One, EstimatorError> {
        let (w, n) = (obs.contacts.len(), p.len());
        let mut forces = DVector::zeros(3 * w);
        let mut in_parameters = DMatrix::zeros(3 * w, n);
        let mut in_inputs = DMatrix::zeros(3 * w, 2 * w);
        for (k, at) in inputs.contacts.iter().enumerate() {
            let (f, jac) = self
                .law
                .jacobian(p, at)
                .map_err(|e| model_error("fit", e))?;
            if f.sinkage.is_none() && observes_sinkage(obs) {
                return Err(EstimatorError::NoSinkage {
                    hypothesis: "fit".to_owned(),
                    model: self.law.name(),
                });
            }
            let row = [f.drawbar_pull, f.resistive_torque, f.sinkage.unwrap_or(0.0)];
            forces.rows_mut(3 * k, 3).copy_from_slice(&row);
            in_parameters
                .rows_mut(3 * k, 3)
                .copy_from(&jac.view((0, 0), (3, n)));
            in_inputs
                .view_mut((3 * k, 2 * k), (3, 2))
                .copy_from(&jac.view((0, n), (3, 2)));
        }
        let in_inputs = &obs.map * in_inputs;
        Ok(One {
            residual: &obs.map * forces + &inputs.back - &obs.forces,
            slopes: &obs.map * (in_parameters * dp_dq),
            covariance: covariance(obs, &in_inputs),
            in_inputs,
        })
    }

    /// Residuals at q under the whitening of another point; `None` where the law refuses.
    pub(crate) fn residual(
        &self,
        q: &[f64],
        factors: &[Cholesky<f64, Dyn>],
    ) -> Option<DVector<f64>> {
        let p = self.space.parameters(q);
        let mut residual = DVector::zeros(self.rows);
        let mut previous: Option<DVector<f64>> = None;
        let mut row = 0;
        for (((obs, inputs), &rho), factor) in self
            .observations
            .iter()
            .zip(&self.inputs)
            .zip(&self.correlations)
            .zip(factors)
        {
            let mut forces = DVector::zeros(3 * obs.contacts.len());
            for (k, at) in inputs.contacts.iter().enumerate() {
                let f = self.law.forces(&p, at).ok()?;
                let row = [f.drawbar_pull, f.resistive_torque, f.sinkage.unwrap_or(0.0)];
                forces.rows_mut(3 * k, 3).copy_from_slice(&row);
            }
            let r = &obs.map * forces + &inputs.back - &obs.forces;
            let m = r.len();
            let white = match &previous {
                Some(last) if rho > 0.0 => &r - last * rho,
                _ => r.clone(),
            };
            residual
                .rows_mut(row, m)
                .copy_from(&factor.l_dirty().solve_lower_triangular(&white)?);
            previous = Some(r);
            row += m;
        }
        Some(residual)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prior::{Centre, Priors};
    use terra_model::{Registry, catalogue};

    #[test]
    fn jacobian_is_the_slope_of_the_whitened_residual() {
        let law = Registry::builtin().law("wong-reece").unwrap();
        let terrain = catalogue::find("dry_sand").unwrap();
        let space =
            FitSpace::new(&law, Centre::Terrain(terrain), &[0.15], &Priors::default()).unwrap();
        let row = |k: usize| {
            let at = Contact::new(0.1 + 0.2 * k as f64, 200.0 + 30.0 * k as f64, 0.254, 0.15);
            let y = [Some(10.0), Some(15.0), Some(0.03)];
            ForceObservation::wheel(0.01 * k as f64, 0, y, at, &[0.5, 0.1, 0.003, 0.005, 0.5])
                .unwrap()
        };
        let rows: Vec<_> = (0..4).map(row).collect();
        let whitening = Some(Prewhitening::new(0.8, 0.01).unwrap());
        let problem = Problem::new(&law, &space, &rows, whitening).unwrap();
        let q = [0.3, -0.2, 0.1, 0.4, -0.5, 0.2, -0.1];
        let at = problem.linearise(&q).unwrap();
        assert!((problem.residual(&q, &at.factors).unwrap() - &at.residual).amax() < 1e-9);
        for k in 0..q.len() {
            let moved = |h: f64| {
                let mut q = q;
                q[k] += h;
                problem.residual(&q, &at.factors).unwrap()
            };
            let slope = (moved(1e-4) - moved(-1e-4)) / 2e-4;
            assert!(
                (&slope - at.jacobian.column(k)).amax() < 1e-5 * (1.0 + slope.amax()),
                "column {k}"
            );
        }
    }
}
