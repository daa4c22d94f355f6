//! Where a law is fitted: a vector q of prior-standardised numbers, and its map to the law's parameters.
//!
//! # Equation
//! Logarithmic: p = p0 e^(s q). Linear: p = p0 + s q. The prior of every component of q is N(0, 1); a one-sided
//! component has q >= its lower bound.
//!
//! One wheel width shows k_c and k_phi only through k_eq = k_c/b + k_phi (exactly: proposition P6 of the wheel
//! model). With one width the space therefore has one component `k_eq`, which is written as k_c = 0, k_phi = k_eq.

use nalgebra::{DMatrix, DVector};
use terra_model::{ForceLaw, Law, Param, Real, Scale};

use crate::error::EstimatorError;
use crate::prior::{Centre, Priors, start};

/// What one component of q sets.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    Parameter(usize),
    /// k_c <- 0, k_phi <- value.
    Stiffness {
        k_c: usize,
        k_phi: usize,
    },
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Component {
    name: &'static str,
    unit: &'static str,
    start: f64,
    sd: f64,
    log: bool,
    one_sided: bool,
    target: Target,
}

/// The map from q to the parameters of one law.
#[derive(Clone, Debug, PartialEq)]
pub struct FitSpace {
    /// The law's parameters at q = 0; those that no component sets stay here.
    base: Vec<f64>,
    components: Vec<Component>,
    width: f64,
}

pub(crate) fn value_error(what: &str, value: f64, expected: &'static str) -> EstimatorError {
    EstimatorError::Value {
        what: what.to_owned(),
        value,
        expected,
    }
}

/// Largest relative difference at which two widths are one.
const SAME_WIDTH: f64 = 1e-9;

impl FitSpace {
    /// The space of a law around a centre, for data from wheels of the given widths \[m\].
    ///
    /// # Errors
    /// [`EstimatorError::Value`] for a width or a start that is out of range, [`EstimatorError::NoPrior`] for a
    /// parameter that starts at 0 without absolute spread, [`EstimatorError::Name`] for unknown or missing names.
    pub fn new(
        law: &Law,
        centre: Centre<'_>,
        widths: &[f64],
        priors: &Priors,
    ) -> Result<Self, EstimatorError> {
        let Some(&width) = widths.first() else {
            return Err(EstimatorError::Size {
                what: "wheel widths",
                found: 0,
                expected: 1,
            });
        };
        if let Some(&bad) = widths.iter().find(|w| !(w.is_finite() && **w > 0.0)) {
            return Err(value_error("wheel width", bad, "a finite width above 0 m"));
        }
        let one_width = widths
            .iter()
            .all(|w| (w - width).abs() <= SAME_WIDTH * width);
        let params = law.params();
        let base = start(law, centre, width)?;
        let index = |name: &str| params.iter().position(|p| p.name == name);
        let merged = index("k_c").zip(index("k_phi")).filter(|_| one_width);
        let mut components = Vec::new();
        for (k, param) in params.iter().enumerate() {
            let component = match merged {
                Some((k_c, _)) if k == k_c => None,
                Some((k_c, k_phi)) if k == k_phi => {
                    let k_eq = base[k_c] / width + base[k_phi];
                    let equal = Param {
                        name: "k_eq",
                        ..*param
                    };
                    component(&equal, k_eq, Target::Stiffness { k_c, k_phi }, priors)?
                }
                _ => component(param, base[k], Target::Parameter(k), priors)?,
            };
            components.extend(component);
        }
        Ok(FitSpace {
            base,
            components,
            width,
        })
    }

    /// The law's parameters at the centre, `k_eq` split into k_c and k_phi as given.
    pub fn start(&self) -> &[f64] {
        &self.base
    }

    /// Number of components of q.
    pub fn dim(&self) -> usize {
        self.components.len()
    }

    /// Names of the components: parameters of the law, or `k_eq`.
    pub fn names(&self) -> Vec<&'static str> {
        self.components.iter().map(|c| c.name).collect()
    }

    /// Units of the physical values.
    pub fn units(&self) -> Vec<&'static str> {
        self.components.iter().map(|c| c.unit).collect()
    }

    /// True for components fitted by their logarithm.
    pub fn logarithmic(&self) -> Vec<bool> {
        self.components.iter().map(|c| c.log).collect()
    }

    /// Prior sd of each component: of the logarithm, or of the value.
    pub fn prior_sd(&self) -> Vec<f64> {
        self.components.iter().map(|c| c.sd).collect()
    }

    /// Smallest legal q of each component, -∞ for most: a linear one-sided value may not fall below 0.
    pub fn lower_bounds(&self) -> Vec<f64> {
        let bound = |c: &Component| {
            if c.one_sided {
                -c.start / c.sd
            } else {
                f64::NEG_INFINITY
            }
        };
        self.components.iter().map(bound).collect()
    }

    /// q of component `k` at a physical value; -∞ for a logarithm of 0 or less.
    pub(crate) fn coordinate(&self, k: usize, value: f64) -> f64 {
        self.components.get(k).map_or(f64::NAN, |c| {
            if !c.log {
                (value - c.start) / c.sd
            } else if value > 0.0 {
                (value / c.start).ln() / c.sd
            } else {
                f64::NEG_INFINITY
            }
        })
    }

    /// True when k_c and k_phi are one component.
    pub fn merges_stiffness(&self) -> bool {
        self.components
            .iter()
            .any(|c| matches!(c.target, Target::Stiffness { .. }))
    }

    /// The law's parameters at q. Components beyond the length of q stay at their start.
    pub fn parameters(&self, q: &[f64]) -> Vec<f64> {
        self.parameters_t(q)
    }

    /// The same at any scalar.
    pub fn parameters_t<T: Real>(&self, q: &[T]) -> Vec<T> {
        let mut p: Vec<T> = self.base.iter().map(|&v| T::from(v)).collect();
        for (c, &q) in self.components.iter().zip(q) {
            let value = c.value(q);
            match c.target {
                Target::Parameter(k) => p[k] = value,
                Target::Stiffness { k_c, k_phi } => {
                    p[k_c] = T::zero();
                    p[k_phi] = value;
                }
            }
        }
        p
    }

    /// dp/dq (parameters x dim).
    pub fn jacobian(&self, q: &[f64]) -> DMatrix<f64> {
        let mut jac = DMatrix::zeros(self.base.len(), self.dim());
        for (column, (c, &q)) in self.components.iter().zip(q).enumerate() {
            let (Target::Parameter(row) | Target::Stiffness { k_phi: row, .. }) = c.target;
            jac[(row, column)] = c.slope(q);
        }
        jac
    }

    /// The value of each component in its unit.
    pub fn physical(&self, q: &[f64]) -> Vec<f64> {
        self.components
            .iter()
            .zip(q)
            .map(|(c, &q)| c.value(q))
            .collect()
    }

    /// sd of each physical value, to first order, for a covariance (dim x dim) of q.
    pub fn physical_sd(&self, q: &[f64], covariance: &DMatrix<f64>) -> Vec<f64> {
        let sd = |(k, (c, q)): (usize, (&Component, &f64))| {
            c.slope(*q).abs() * covariance.get((k, k)).map_or(f64::NAN, |v| v.sqrt())
        };
        self.components.iter().zip(q).enumerate().map(sd).collect()
    }

    /// d ln(value)/dq of each component; for a linear one, change in units of the larger of value and prior sd.
    pub fn log_slope(&self, q: &[f64]) -> Vec<f64> {
        let slope = |(c, &q): (&Component, &f64)| {
            if c.log {
                c.sd
            } else {
                c.sd / c.value(q).abs().max(c.sd)
            }
        };
        self.components.iter().zip(q).map(slope).collect()
    }

    /// The q of a parameter vector: the inverse of [`parameters`](Self::parameters), k_c and k_phi taken together.
    ///
    /// # Errors
    /// [`EstimatorError::Size`]; [`EstimatorError::Value`] where a logarithmic value is not positive.
    pub fn coordinates(&self, parameters: &[f64]) -> Result<DVector<f64>, EstimatorError> {
        let (found, expected) = (parameters.len(), self.base.len());
        if found != expected {
            return Err(EstimatorError::Size {
                what: "parameters",
                found,
                expected,
            });
        }
        let q = self.components.iter().map(|c| {
            let value = match c.target {
                Target::Parameter(k) => parameters[k],
                Target::Stiffness { k_c, k_phi } => {
                    parameters[k_c] / self.width + parameters[k_phi]
                }
            };
            if !c.log {
                return Ok((value - c.start) / c.sd);
            }
            if !(value.is_finite() && value > 0.0) {
                return Err(value_error(c.name, value, "a finite value above 0"));
            }
            Ok((value / c.start).ln() / c.sd)
        });
        Ok(DVector::from_vec(q.collect::<Result<Vec<f64>, _>>()?))
    }
}

impl Component {
    fn value<T: Real>(&self, q: T) -> T {
        if self.log {
            (q * self.sd).exp() * self.start
        } else {
            q * self.sd + self.start
        }
    }
    fn slope(&self, q: f64) -> f64 {
        if self.log {
            self.value(q) * self.sd
        } else {
            self.sd
        }
    }
}

/// One component; `None` when its spread is 0, which holds it at its start.
fn component(
    param: &Param,
    start: f64,
    target: Target,
    priors: &Priors,
) -> Result<Option<Component>, EstimatorError> {
    if !start.is_finite() {
        return Err(value_error(param.name, start, "a finite start"));
    }
    let absolute = priors.abs_sd.get(param.name).copied();
    let (log, sd) = match param.scale {
        Scale::Linear => (false, absolute.unwrap_or(param.prior_sd)),
        Scale::Log if start > 0.0 => (
            true,
            priors.sd.get(param.name).copied().unwrap_or(param.prior_sd),
        ),
        Scale::Log if start == 0.0 => {
            let sd = absolute.ok_or_else(|| EstimatorError::NoPrior {
                parameter: param.name.to_owned(),
            })?;
            (false, sd)
        }
        Scale::Log => return Err(value_error(param.name, start, "a start of at least 0")),
    };
    if !(sd.is_finite() && sd >= 0.0) {
        return Err(value_error(
            &format!("prior sd of {}", param.name),
            sd,
            "a finite spread of at least 0",
        ));
    }
    let (name, unit) = (param.name, param.unit);
    let one_sided = !log && param.one_sided();
    Ok((sd > 0.0).then_some(Component {
        name,
        unit,
        start,
        sd,
        log,
        one_sided,
        target,
    }))
}
