//! How far a hypothesis is from the forces observed, and how uncertain that distance is.
//!
//! # Equation
//! r = A F(slip, load) - y,  S = H C Hᵀ,  H = [-I, A dF/d(slip, load)], F = [D, T, z] of each wheel.
//! C is the joint covariance of forces, slips and loads: slip and load are measured too, and a steep force curve
//! turns their noise into force.

use nalgebra::{DMatrix, DVector};
use terra_model::{Contact, Law, ModelError, jacobian};

use crate::error::EstimatorError;
use crate::observation::ForceObservation;

/// Residual and its covariance.
#[derive(Clone, Debug)]
pub struct Residual {
    /// r (m): predicted less observed.
    pub value: DVector<f64>,
    /// S (m x m).
    pub covariance: DMatrix<f64>,
}

/// What a hypothesis says about one observation.
#[derive(Clone, Debug)]
pub enum Comparison {
    /// It predicts forces.
    Feasible(Residual),
    /// It cannot carry the wheel there, or its parameters are illegal at this slip.
    Infeasible(ModelError),
}

/// True for refusals that count against the soil; a bad contact or a wrong number of parameters is an error instead.
pub(crate) fn is_infeasible(error: &ModelError) -> bool {
    matches!(
        error,
        ModelError::NoEquilibrium { .. }
            | ModelError::Parameter { .. }
            | ModelError::NotConverged { .. }
    )
}

/// Forces [D, T, z] (3w) of all wheels; their slopes (3w x 2w) in slip and load of each wheel.
pub(crate) struct Stacked {
    pub(crate) forces: DVector<f64>,
    pub(crate) slopes: DMatrix<f64>,
    pub(crate) has_sinkage: bool,
}

pub(crate) fn stacked(
    law: &Law,
    p: &[f64],
    contacts: &[Contact<f64>],
) -> Result<Stacked, ModelError> {
    let w = contacts.len();
    let mut forces = DVector::zeros(3 * w);
    let mut slopes = DMatrix::zeros(3 * w, 2 * w);
    let mut has_sinkage = true;
    for (k, at) in contacts.iter().enumerate() {
        // Only slip and load vary here, so one pass of dual numbers gives both value and slope.
        let (value, slope) = jacobian(&[at.slip, at.normal_load], |x| {
            let mut contact: Contact<terra_model::Dual8> = at.lift();
            contact.slip = x[0];
            contact.normal_load = x[1];
            let p: Vec<terra_model::Dual8> =
                p.iter().map(|v| terra_model::Dual8::from(*v)).collect();
            let f = law.forces_at(&p, &contact)?;
            has_sinkage &= f.sinkage.is_some();
            let sinkage = f.sinkage.unwrap_or_else(|| terra_model::Dual8::from(0.0));
            Ok::<_, ModelError>(vec![f.drawbar_pull, f.resistive_torque, sinkage])
        })?;
        forces.rows_mut(3 * k, 3).copy_from_slice(&value);
        slopes.view_mut((3 * k, 2 * k), (3, 2)).copy_from(&slope);
    }
    Ok(Stacked {
        forces,
        slopes,
        has_sinkage,
    })
}

/// H C Hᵀ of one observation, given A dF/d(slip, load) (m x 2w).
pub(crate) fn covariance(obs: &ForceObservation, slopes: &DMatrix<f64>) -> DMatrix<f64> {
    let m = obs.forces.len();
    let mut h = DMatrix::zeros(m, m + slopes.ncols());
    h.view_mut((0, 0), (m, m)).fill_diagonal(-1.0);
    h.view_mut((0, m), slopes.shape()).copy_from(slopes);
    &h * &obs.covariance * h.transpose()
}

/// True when a row of the map looks at sinkage.
pub(crate) fn observes_sinkage(obs: &ForceObservation) -> bool {
    (0..obs.contacts.len()).any(|k| obs.map.column(3 * k + 2).iter().any(|a| *a != 0.0))
}

/// Compares a law at the given parameters with an observation.
///
/// `table_error` is an optional relative error of every predicted wheel force, added to the diagonal of S.
/// `id` names the hypothesis in errors.
///
/// # Errors
/// [`EstimatorError::Model`] for refusals that do not speak about the soil; [`EstimatorError::NoSinkage`].
pub fn compare(
    id: &str,
    law: &Law,
    p: &[f64],
    obs: &ForceObservation,
    table_error: f64,
) -> Result<Comparison, EstimatorError> {
    let predicted = match stacked(law, p, &obs.contacts) {
        Ok(predicted) => predicted,
        Err(e) if is_infeasible(&e) => return Ok(Comparison::Infeasible(e)),
        Err(source) => {
            return Err(EstimatorError::Model {
                hypothesis: id.to_owned(),
                source,
            });
        }
    };
    if !predicted.has_sinkage && observes_sinkage(obs) {
        let model = terra_model::ForceLaw::name(law);
        return Err(EstimatorError::NoSinkage {
            hypothesis: id.to_owned(),
            model,
        });
    }
    let value = &obs.map * &predicted.forces - &obs.forces;
    let mut s = covariance(obs, &(&obs.map * &predicted.slopes));
    if table_error > 0.0 {
        for i in 0..value.len() {
            let row = obs.map.row(i);
            let squares: f64 = row
                .iter()
                .zip(predicted.forces.iter())
                .map(|(a, f)| (a * f).powi(2))
                .sum();
            s[(i, i)] += table_error.powi(2) * squares;
        }
    }
    Ok(Comparison::Feasible(Residual {
        value,
        covariance: s,
    }))
}

/// A residual under its Gaussian law.
#[derive(Clone, Debug)]
pub struct Scored {
    /// ln density.
    pub log_density: f64,
    /// rᵀ S⁻¹ r.
    pub nis: f64,
    /// L⁻¹ r with S = L Lᵀ.
    pub standardised: DVector<f64>,
}

/// ln N(r; 0, S), Ray 2008 eq. 23; `None` when S is not positive definite.
pub fn score(r: &DVector<f64>, s: &DMatrix<f64>) -> Option<Scored> {
    let factor = s.clone().cholesky()?;
    let standardised = factor.l_dirty().solve_lower_triangular(r)?;
    let nis = standardised.norm_squared();
    let log_det: f64 = factor
        .l_dirty()
        .diagonal()
        .iter()
        .map(|d| 2.0 * d.ln())
        .sum();
    let log_density = -0.5 * (nis + log_det + r.len() as f64 * (2.0 * std::f64::consts::PI).ln());
    log_density.is_finite().then_some(Scored {
        log_density,
        nis,
        standardised,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn density_of_a_correlated_pair_by_hand() {
        // S = [[4, 1], [1, 2]], r = (1, -1): det 7, rᵀS⁻¹r = (2 + 1 + 1 + 4)/7 = 8/7.
        let s = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 2.0]);
        let scored = score(&DVector::from_vec(vec![1.0, -1.0]), &s).unwrap();
        assert!((scored.nis - 8.0 / 7.0).abs() < 1e-14);
        let expected = -4.0 / 7.0 - 0.5 * 7.0_f64.ln() - (2.0 * std::f64::consts::PI).ln();
        assert!((scored.log_density - expected).abs() < 1e-14);
        assert!(score(&DVector::zeros(2), &DMatrix::zeros(2, 2)).is_none());
    }
}
