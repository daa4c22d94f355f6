//! Ordinary differential equations y' = f(t, y): a fixed-step and an adaptive Runge-Kutta method of one file each.

mod dormand_prince;
mod rk4;
mod step;

pub use dormand_prince::DormandPrince;
pub(crate) use dormand_prince::Pace;
pub use rk4::Rk4;
pub(crate) use step::Step;

use crate::error::SimError;

/// How the truth is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// Classic Runge-Kutta of order 4, fixed steps.
    Rk4(Rk4),
    /// Dormand-Prince 5(4), steps chosen by its error estimate.
    DormandPrince(DormandPrince),
}

impl Default for Integrator {
    fn default() -> Self {
        Integrator::Rk4(Rk4::default())
    }
}

impl Integrator {
    /// Refuses a step or a tolerance that is not a positive number.
    ///
    /// # Errors
    /// [`SimError::Value`].
    pub fn check(&self) -> Result<(), SimError> {
        let numbers = match self {
            Integrator::Rk4(method) => vec![("step", method.step)],
            Integrator::DormandPrince(method) => {
                vec![
                    ("relative", method.relative),
                    ("absolute", method.absolute),
                    ("max_step", method.max_step),
                ]
            }
        };
        match numbers
            .into_iter()
            .find(|(_, x)| !(x.is_finite() && *x > 0.0))
        {
            None => Ok(()),
            Some((name, value)) => Err(SimError::Value {
                quantity: format!("integrator {name}"),
                value,
                expected: "a positive number",
            }),
        }
    }

    /// Carries `y` from `t` to `end`; `step` is called with time and state after each step.
    ///
    /// # Errors
    /// What `rate` returns, [`SimError::StepTooSmall`], [`SimError::NotFinite`].
    pub fn advance<const N: usize>(
        &self,
        rate: &mut impl FnMut(f64, &[f64; N]) -> Result<[f64; N], SimError>,
        t: f64,
        end: f64,
        y: &mut [f64; N],
        step: &mut impl FnMut(f64, &[f64; N]),
    ) -> Result<(), SimError> {
        match self {
            Integrator::Rk4(method) => method.advance(rate, t, end, y, step),
            Integrator::DormandPrince(method) => method.advance(rate, t, end, y, step),
        }
    }
}

/// y + Σ c_i k_i.
fn combine<const N: usize>(y: &[f64; N], terms: &[(f64, &[f64; N])]) -> [f64; N] {
    let mut out = *y;
    for (c, k) in terms {
        for (o, k) in out.iter_mut().zip(k.iter()) {
            *o += c * k;
        }
    }
    out
}

fn finite<const N: usize>(t: f64, y: &[f64; N]) -> Result<(), SimError> {
    if y.iter().all(|v| v.is_finite()) {
        Ok(())
    } else {
        Err(SimError::NotFinite { time: t })
    }
}
