//! One axis of a design: a parameter and the range it covers.

use std::sync::Arc;

use terra_model::{ForceLaw, Law, ModelError, Scale, nearest};

use super::MOST_HYPOTHESES;
use crate::error::EstimatorError;

/// A parameter of the law and the range it covers.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name of the law's parameter.
    pub parameter: String,
    /// Smallest value, in the parameter's unit.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

impl Axis {
    /// An axis from `low` to `high`.
    pub fn new(parameter: &str, low: f64, high: f64) -> Self {
        Axis {
            parameter: parameter.to_owned(),
            low,
            high,
        }
    }
}

/// An axis found in a law: even in the logarithm where the parameter is fitted so and the range lies above 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) index: usize,
    low: f64,
    high: f64,
    log: bool,
}

impl Placed {
    /// The value a share `u` of [0, 1] up the axis.
    ///
    /// # Equation
    /// p = p_low (p_high/p_low)^u on a logarithmic axis, p_low + u (p_high - p_low) on a linear one.
    pub(super) fn at(&self, u: f64) -> f64 {
        // The ends as given, to the last bit.
        if u <= 0.0 {
            self.low
        } else if u >= 1.0 {
            self.high
        } else if self.log {
            self.low * (u * (self.high / self.low).ln()).exp()
        } else {
            self.low + u * (self.high - self.low)
        }
    }
}

/// Finds the axes in a law and checks them against its legal ranges and the centre against its size.
pub(super) fn placed<'a>(
    law: &Arc<Law>,
    centre: &[f64],
    axes: impl IntoIterator<Item = &'a Axis>,
) -> Result<Vec<Placed>, EstimatorError> {
    let params = law.params();
    if centre.len() != params.len() {
        return Err(EstimatorError::Size {
            what: "centre",
            found: centre.len(),
            expected: params.len(),
        });
    }
    let mut out: Vec<Placed> = Vec::new();
    for axis in axes {
        let name = &axis.parameter;
        let Some((index, param)) = params.iter().enumerate().find(|(_, p)| p.name == name) else {
            let nearest = nearest(name, params.iter().map(|p| p.name)).map(str::to_owned);
            return Err(ModelError::UnknownName {
                kind: "parameter",
                name: name.clone(),
                nearest,
            }
            .into());
        };
        let fail = |what: &str, value, expected| {
            Err(EstimatorError::Value {
                what: format!("{what} of the axis {name}"),
                value,
                expected,
            })
        };
        if out.iter().any(|p| p.index == index) {
            return fail("second range", axis.low, "each parameter on one axis only");
        }
        for (what, value) in [("low end", axis.low), ("high end", axis.high)] {
            if !(value.is_finite() && (param.min..=param.max).contains(&value)) {
                return fail(what, value, "a value the law allows (see `terra models`)");
            }
        }
        if axis.low >= axis.high {
            return fail("high end", axis.high, "a value above the low end");
        }
        out.push(Placed {
            index,
            low: axis.low,
            high: axis.high,
            log: param.scale == Scale::Log && axis.low > 0.0,
        });
    }
    if out.is_empty() {
        return Err(EstimatorError::Size {
            what: "axes",
            found: 0,
            expected: 1,
        });
    }
    Ok(out)
}

/// Refuses a set of no or of too many members.
pub(super) fn countable(n: Option<usize>) -> Result<usize, EstimatorError> {
    match n {
        Some(0) => Err(EstimatorError::EmptySet),
        Some(n) if n <= MOST_HYPOTHESES => Ok(n),
        _ => Err(EstimatorError::Size {
            what: "hypotheses of the set",
            found: n.unwrap_or(usize::MAX),
            expected: MOST_HYPOTHESES,
        }),
    }
}
