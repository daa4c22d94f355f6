//! What the fits say.

use super::curve::Prepared;

/// Where an interval comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interval {
    /// From test to test, one left out at a time.
    BetweenTests,
    /// From the correlated residuals within the tests: how well the curve is drawn, not how much the ground varies.
    WithinTests,
    /// One test whose residuals are all one misfit of the law: no interval, and NaN for its ends.
    NotKnown,
}

/// One parameter with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Least squares.
    pub value: f64,
    /// Lower end; NaN where there is none.
    pub low: f64,
    /// Upper end; NaN where there is none.
    pub high: f64,
}

/// One law on all tests.
#[derive(Clone, Debug, PartialEq)]
pub struct LawFit {
    /// Its name, as in the slots of a wheel.
    pub law: &'static str,
    /// Its parameters.
    pub parameters: Vec<Estimate>,
    /// Where their intervals come from.
    pub interval: Interval,
    /// Root mean square of measured less fitted stress \[Pa\].
    pub rms: f64,
    /// The same over the root mean square of the stress.
    pub rms_share: f64,
    /// Bayesian information criterion less that of the best law, by the effective number of points.
    pub delta_bic: f64,
    /// Fitted stress of each test at each of its points \[Pa\].
    pub fitted: Vec<Vec<f64>>,
}

impl LawFit {
    /// A parameter by name.
    pub fn get(&self, name: &str) -> Option<&Estimate> {
        self.parameters.iter().find(|p| p.name == name)
    }
}

/// All laws on all tests.
#[derive(Clone, Debug, PartialEq)]
pub struct Fits {
    /// The tests as fitted.
    pub tests: Vec<Prepared>,
    /// The laws; the one whose parameters the catalogue has first.
    pub laws: Vec<LawFit>,
    /// Directions of the parameters that no such tests can tell, exactly: coefficients of changes that leave every curve
    /// as it is.
    pub null: Vec<(&'static str, f64)>,
    /// What these tests do not tell, in words, names first.
    pub undetermined: Vec<String>,
}

impl Fits {
    /// The law that explains the tests best for its number of parameters.
    pub fn best(&self) -> Option<&LawFit> {
        self.laws
            .iter()
            .min_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic))
    }
}
