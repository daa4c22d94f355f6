//! Refinement: the best parameters of one law around a winner, with how sure they are.
//!
//! Fit to claim forces, not parameters: the error of predicted forces falls from tens of percent to a few, that of
//! single parameters hardly moves.
//!
//! # Equation
//! q* = argmin Σ_k r~_kᵀ S~_k⁻¹ r~_k + qᵀq over the [`FitSpace`], by Levenberg-Marquardt with exact Jacobians;
//! S~_k is that of the current q at every step. Slips and loads, which are measured too, are sought in turn with q: r~ and S~ are
//! linearised where they most probably were. Laplace: cov(q) = (I + JᵀJ)⁻¹, J the whitened Jacobian.
//! Certificate: half the Newton decrement gᵀ(I + JᵀJ)⁻¹g/2, the nats still to be gained, is below a tolerance.
//!
//! # Reference
//! D. W. Marquardt, SIAM J. 11(2):431-441, 1963; K. Madsen, H. B. Nielsen, O. Tingleff, *Methods for non-linear
//! least squares problems*, DTU 2004 (the damping rule); W. A. Fuller, *Measurement Error Models*, Wiley 1987 (inputs with noise).

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_model::{Contact, ForceLaw, Law};

use crate::error::EstimatorError;
use crate::fit_space::FitSpace;
use crate::identifiability::{Identifiability, identifiability};
use crate::linearise::{Linearised, Problem};
use crate::observation::ForceObservation;
use crate::prediction::{ForcePrediction, PredictionStatus, Spread, contact_grid, model_error};
use crate::residual::is_infeasible;
use crate::whiten::Prewhitening;

/// How a refinement runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineOptions {
    /// As in the weighing; without it the posterior of filter forces is too narrow.
    pub whitening: Option<Prewhitening>,
    /// Largest number of accepted or rejected steps.
    pub max_steps: usize,
    /// Nats still to be gained below which the fit has converged.
    pub tolerance: f64,
}

impl Default for RefineOptions {
    fn default() -> Self {
        RefineOptions {
            whitening: None,
            max_steps: 100,
            tolerance: 1e-6,
        }
    }
}

/// One fitted parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedParameter {
    /// Name: of the law's parameter, or `k_eq`.
    pub name: &'static str,
    /// Most probable value (for a logarithmic parameter also its median).
    pub value: f64,
    /// Posterior sd to first order.
    pub sd: f64,
    /// Unit of both.
    pub unit: &'static str,
}

/// The result of a refinement.
#[derive(Clone, Debug)]
pub struct Refinement {
    law: Arc<Law>,
    space: FitSpace,
    /// q* (dim).
    pub q: DVector<f64>,
    /// Posterior covariance of q (dim x dim); the prior is the identity.
    pub covariance: DMatrix<f64>,
    /// True when the certificate holds, and slips and loads have settled.
    pub converged: bool,
    /// Nats still to be gained by a Newton step.
    pub decrement: f64,
    /// Steps tried.
    pub steps: usize,
    /// Σ r~ᵀS~⁻¹r~ over rows less effective parameters; near 1 for a right law and a right covariance, none when
    /// there are no more rows than parameters.
    pub chi2_per_dof: Option<f64>,
    /// Number of whitened rows.
    pub rows: usize,
    /// What the data determine and what not.
    pub identifiability: Identifiability,
}

/// Fits the parameters of a law to observations, starting from the prior's centre.
///
/// # Errors
/// [`EstimatorError::NoObservations`]; [`EstimatorError::Model`] when the centre itself is infeasible at an
/// observation; [`EstimatorError::NotPositiveDefinite`]; [`EstimatorError::NoSinkage`].
pub fn refine(
    law: &Arc<Law>,
    space: FitSpace,
    observations: &[ForceObservation],
    options: &RefineOptions,
) -> Result<Refinement, EstimatorError> {
    let mut problem = Problem::new(law, &space, observations, options.whitening)?;
    let n = space.dim();
    let lower = DVector::from_vec(space.lower_bounds());
    let mut fit = descend(&problem, DVector::zeros(n), &lower, options)?;
    let mut settled = false;
    for _ in 0..ROUNDS {
        problem.seek_inputs(fit.q.as_slice())?;
        let before = fit.q.clone();
        let steps = fit.steps;
        fit = descend(&problem, fit.q, &lower, options)?;
        fit.steps += steps;
        settled = (&fit.q - before).amax() < SETTLED;
        if settled {
            break;
        }
    }
    let Fit { q, at, step, steps } = fit;
    let hessian = DMatrix::identity(n, n) + at.jacobian.tr_mul(&at.jacobian);
    let covariance = inverse(hessian)?;
    let effective = n as f64 - covariance.trace();
    let rows = at.residual.len();
    let dof = rows as f64 - effective;
    let identifiability = identifiability(&space, q.as_slice(), &at.jacobian)?;
    Ok(Refinement {
        law: Arc::clone(law),
        space,
        q,
        covariance,
        converged: settled && step.decrement <= options.tolerance,
        decrement: step.decrement,
        steps,
        chi2_per_dof: (dof > 0.0).then(|| at.residual.norm_squared() / dof),
        rows,
        identifiability,
    })
}

/// Rounds of fitting the soil and seeking slips and loads, and the change of the soil \[prior sd\] at which they have settled.
const ROUNDS: usize = 12;
const SETTLED: f64 = 1e-3;

/// Where a descent ended.
struct Fit {
    q: DVector<f64>,
    at: Linearised,
    step: Step,
    steps: usize,
}

/// The fit from a start, at the inputs of the problem.
fn descend(
    problem: &Problem<'_>,
    mut q: DVector<f64>,
    lower: &DVector<f64>,
    options: &RefineOptions,
) -> Result<Fit, EstimatorError> {
    let mut at = problem.linearise(q.as_slice())?;
    let (mut damping, mut growth) = (1e-3, 2.0);
    let mut steps = 0;
    let mut step = newton(&at.jacobian, &at.residual, &q, lower, 0.0)?;
    while step.decrement > options.tolerance && steps < options.max_steps {
        steps += 1;
        let trial = newton(&at.jacobian, &at.residual, &q, lower, damping)?;
        let next = (&q + &trial.step).zip_map(lower, f64::max);
        let moved = &next - &q;
        let cost = at.residual.norm_squared() + q.norm_squared();
        // Model error at a trial point only says that the step was too long.
        let gain = problem
            .residual(next.as_slice(), &at.factors)
            .map(|r| cost - r.norm_squared() - next.norm_squared())
            .filter(|gain| gain.is_finite() && *gain >= 0.0);
        let linearised =
            gain.and_then(|gain| Some((gain, problem.linearise(next.as_slice()).ok()?)));
        match linearised {
            Some((gain, there)) => {
                let model = &at.residual + &at.jacobian * &moved;
                let predicted = cost - model.norm_squared() - next.norm_squared();
                let ratio = if predicted > 0.0 {
                    gain / predicted
                } else {
                    1.0
                };
                damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                growth = 2.0;
                q = next;
                at = there;
                step = newton(&at.jacobian, &at.residual, &q, lower, 0.0)?;
            }
            None => {
                damping *= growth;
                growth *= 2.0;
                if damping > 1e12 {
                    break;
                }
            }
        }
    }
    Ok(Fit { q, at, step, steps })
}

struct Step {
    step: DVector<f64>,
    decrement: f64,
}

/// The damped Gauss-Newton step; components held by their bound do not move.
fn newton(
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
    q: &DVector<f64>,
    lower: &DVector<f64>,
    damping: f64,
) -> Result<Step, EstimatorError> {
    let n = q.len();
    let mut gradient = jacobian.tr_mul(residual) + q;
    let mut hessian = jacobian.tr_mul(jacobian) + DMatrix::identity(n, n) * (1.0 + damping);
    for k in 0..n {
        if q[k] <= lower[k] && gradient[k] > 0.0 {
            gradient[k] = 0.0;
            hessian.row_mut(k).fill(0.0);
            hessian.column_mut(k).fill(0.0);
            hessian[(k, k)] = 1.0;
        }
    }
    let factor = hessian.cholesky().ok_or(EstimatorError::Decomposition {
        what: "Cholesky of the Hessian",
    })?;
    let step = -factor.solve(&gradient);
    let decrement = -0.5 * gradient.dot(&step);
    Ok(Step { step, decrement })
}

fn inverse(hessian: DMatrix<f64>) -> Result<DMatrix<f64>, EstimatorError> {
    Ok(hessian
        .cholesky()
        .ok_or(EstimatorError::Decomposition {
            what: "Cholesky of the Hessian",
        })?
        .inverse())
}

impl Refinement {
    /// The law fitted.
    pub fn law(&self) -> &Arc<Law> {
        &self.law
    }

    /// The space it was fitted in.
    pub fn space(&self) -> &FitSpace {
        &self.space
    }

    /// The law's parameters at q*.
    pub fn parameters(&self) -> Vec<f64> {
        self.space.parameters(self.q.as_slice())
    }

    /// Each fitted parameter with its spread.
    pub fn fitted(&self) -> Vec<FittedParameter> {
        let q = self.q.as_slice();
        let sds = self.space.physical_sd(q, &self.covariance);
        let rows = self
            .space
            .names()
            .into_iter()
            .zip(self.space.units())
            .zip(self.space.physical(q))
            .zip(sds);
        rows.map(|(((name, unit), value), sd)| FittedParameter {
            name,
            value,
            sd,
            unit,
        })
        .collect()
    }

    /// Forces at every slip and load (loads outermost) on a contact like the template; sd to first order from the
    /// posterior covariance.
    ///
    /// # Errors
    /// [`EstimatorError::Model`] for a contact that the law does not accept.
    pub fn force_prediction(
        &self,
        slips: &[f64],
        loads: &[f64],
        template: &Contact<f64>,
    ) -> Result<Vec<ForcePrediction>, EstimatorError> {
        contact_grid(slips, loads, template)
            .iter()
            .map(|at| self.predict(at))
            .collect()
    }

    fn predict(&self, at: &Contact<f64>) -> Result<ForcePrediction, EstimatorError> {
        let (forces, jacobian) = match self.law.jacobian(&self.parameters(), at) {
            Ok(found) => found,
            Err(e) if is_infeasible(&e) => return Ok(ForcePrediction::none(at, 1.0)),
            Err(source) => return Err(model_error("refined", source)),
        };
        let p = self.law.params().len();
        let slopes = jacobian.view((0, 0), (3, p)) * self.space.jacobian(self.q.as_slice());
        let variance = (&slopes * &self.covariance * slopes.transpose()).diagonal();
        let spread = |k: usize, mean: f64| Spread {
            mean,
            sd: variance[k].sqrt(),
        };
        Ok(ForcePrediction {
            slip: at.slip,
            normal_load: at.normal_load,
            drawbar_pull: Some(spread(0, forces.drawbar_pull)),
            torque: Some(spread(1, forces.resistive_torque)),
            sinkage: forces.sinkage.map(|z| spread(2, z)),
            infeasible: 0.0,
            status: PredictionStatus::Ok,
        })
    }
}
