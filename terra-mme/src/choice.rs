//! What happens to old evidence before new evidence comes: the choice that decides whether a collapsed rival can return.

use std::fmt;

use nalgebra::DMatrix;

use crate::error::EstimatorError;

/// How the posterior of the last sample becomes the prior of the next.
///
/// Log probabilities alone do not save a rival: it returns only after new evidence outweighs all the old.
///
/// # Equation
/// `none` p <- p · `floor` p <- (1-f) p + f/N · `forgetting` p <- p^λ, normalised · `transition` p <- Mᵀ p.
/// A floor equals a Markov transition whose rows are all (1-f) e_j + f/N.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum Choice {
    /// Old evidence counts in full: one terrain, batch.
    #[default]
    None,
    /// Share f in (0, 1) of the probability is spread evenly before each sample.
    Floor(f64),
    /// Exponent λ in (0, 1] on the old posterior.
    Forgetting(f64),
    /// M (N x N), row j: where hypothesis j goes; rows sum to 1.
    Transition(DMatrix<f64>),
}

impl Choice {
    /// Default for on-line use: a floor of 1e-3.
    pub fn online() -> Self {
        Choice::Floor(1e-3)
    }

    /// A floor f in (0, 1).
    ///
    /// # Errors
    /// [`EstimatorError::Value`].
    pub fn floor(f: f64) -> Result<Self, EstimatorError> {
        Choice::Floor(f).checked(None)
    }

    /// Forgetting with λ in (0, 1].
    ///
    /// # Errors
    /// [`EstimatorError::Value`].
    pub fn forgetting(lambda: f64) -> Result<Self, EstimatorError> {
        Choice::Forgetting(lambda).checked(None)
    }

    /// A transition matrix (N x N), rows summing to 1.
    ///
    /// # Errors
    /// [`EstimatorError::Value`], [`EstimatorError::Size`] when it is not square.
    pub fn transition(matrix: DMatrix<f64>) -> Result<Self, EstimatorError> {
        Choice::Transition(matrix).checked(None)
    }

    /// `none`, `floor:F` or `forgetting:L`; a transition matrix has no text form.
    ///
    /// # Errors
    /// [`EstimatorError::NotSupported`] for other text, [`EstimatorError::Value`] for a number out of range.
    pub fn parse(text: &str) -> Result<Self, EstimatorError> {
        let unknown = || EstimatorError::NotSupported {
            estimator: "any",
            choice: text.to_owned(),
            reason: "expected none, floor:F with 0 < F < 1, or forgetting:L with 0 < L <= 1",
        };
        let number = |t: &str| t.parse::<f64>().map_err(|_| unknown());
        match text.split_once(':') {
            None if text == "none" => Ok(Choice::None),
            Some(("floor", f)) => Choice::floor(number(f)?),
            Some(("forgetting", l)) => Choice::forgetting(number(l)?),
            _ => Err(unknown()),
        }
    }

    /// Kind as printed in results: `none`, `floor`, `forgetting`, `transition`.
    pub fn kind(&self) -> &'static str {
        match self {
            Choice::None => "none",
            Choice::Floor(_) => "floor",
            Choice::Forgetting(_) => "forgetting",
            Choice::Transition(_) => "transition",
        }
    }

    /// The number behind it: f or λ.
    pub fn value(&self) -> Option<f64> {
        match self {
            Choice::Floor(x) | Choice::Forgetting(x) => Some(*x),
            Choice::None | Choice::Transition(_) => None,
        }
    }

    /// This choice when it is legal for `n` hypotheses (any number when `None`).
    ///
    /// # Errors
    /// [`EstimatorError::Value`], [`EstimatorError::Size`].
    pub fn checked(self, n: Option<usize>) -> Result<Self, EstimatorError> {
        let value = |ok: bool, what: &str, value: f64, expected| {
            if ok {
                Ok(())
            } else {
                Err(EstimatorError::Value {
                    what: what.to_owned(),
                    value,
                    expected,
                })
            }
        };
        match &self {
            Choice::None => {}
            Choice::Floor(f) => value(*f > 0.0 && *f < 1.0, "floor", *f, "a share in (0, 1)")?,
            Choice::Forgetting(l) => {
                value(
                    *l > 0.0 && *l <= 1.0,
                    "forgetting",
                    *l,
                    "an exponent in (0, 1]",
                )?;
            }
            Choice::Transition(m) => {
                let expected = n.unwrap_or(m.nrows());
                for found in [m.nrows(), m.ncols()] {
                    if found != expected {
                        return Err(EstimatorError::Size {
                            what: "transition matrix",
                            found,
                            expected,
                        });
                    }
                }
                for (i, row) in m.row_iter().enumerate() {
                    for &x in row.iter() {
                        value(
                            x.is_finite() && x >= 0.0,
                            "transition entry",
                            x,
                            "a probability",
                        )?;
                    }
                    let sum = row.sum();
                    let ok = (sum - 1.0).abs() <= 1e-9;
                    value(ok, &format!("sum of transition row {i}"), sum, "1")?;
                }
            }
        }
        Ok(self)
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.value() {
            Some(x) => write!(f, "{}:{x}", self.kind()),
            None => f.write_str(self.kind()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_and_parses_as_in_results() {
        for text in ["none", "floor:0.001", "forgetting:0.9"] {
            assert_eq!(Choice::parse(text).unwrap().to_string(), text);
        }
        assert_eq!(
            Choice::transition(DMatrix::identity(2, 2))
                .unwrap()
                .to_string(),
            "transition"
        );
    }

    #[test]
    fn refuses_what_is_no_probability() {
        for text in [
            "floor:0",
            "floor:1",
            "floor:nan",
            "forgetting:0",
            "forgetting:1.1",
            "flor:0.1",
            "floor:x",
        ] {
            assert!(Choice::parse(text).is_err(), "{text}");
        }
        assert!(Choice::transition(DMatrix::from_element(2, 2, 0.6)).is_err());
        assert!(Choice::transition(DMatrix::zeros(2, 3)).is_err());
        assert!(
            Choice::Transition(DMatrix::identity(2, 2))
                .checked(Some(3))
                .is_err()
        );
    }
}
