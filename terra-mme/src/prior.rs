//! Where a fit starts and how far it may stray: the centre and the spreads of the prior.

use std::collections::BTreeMap;

use terra_model::catalogue::{Missing, Terrain};
use terra_model::{ForceLaw, Law, ModelError, nearest};

use crate::error::EstimatorError;
use crate::fit_space::value_error;

/// Prior spreads by parameter name; what is not named falls back to the parameter's own.
#[derive(Clone, Debug, PartialEq)]
pub struct Priors {
    /// sd of ln(parameter) \[1\]. A spread of 0 holds the parameter at its start.
    pub sd: BTreeMap<String, f64>,
    /// sd of the parameter itself, in its unit: for linear parameters and for those that start at 0.
    pub abs_sd: BTreeMap<String, f64>,
}

impl Default for Priors {
    /// The spreads of soil parameters that a rover file starts from.
    fn default() -> Self {
        let sd = [
            ("cohesion", 0.5),
            ("friction_angle", 0.15),
            ("k_eq", 0.5),
            ("sinkage_exponent", 0.12),
            ("c1", 0.2),
            ("c2", 0.3),
            ("shear_modulus", 0.4),
        ];
        // c2 is 0 for soils whose apex is not known to move; .1 is .3 of a typical .35.
        let abs_sd = [("cohesion", 500.0), ("c2", 0.1)];
        let map = |rows: &[(&str, f64)]| rows.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect();
        Priors {
            sd: map(&sd),
            abs_sd: map(&abs_sd),
        }
    }
}

impl Priors {
    /// These spreads with some replaced.
    #[must_use]
    pub fn with(mut self, sd: &BTreeMap<String, f64>, abs_sd: &BTreeMap<String, f64>) -> Self {
        self.sd.extend(sd.iter().map(|(k, v)| (k.clone(), *v)));
        self.abs_sd
            .extend(abs_sd.iter().map(|(k, v)| (k.clone(), *v)));
        self
    }
}

/// Where the prior is centred.
#[derive(Clone, Copy, Debug)]
pub enum Centre<'a> {
    /// A catalogue soil; effects start at 0.
    Terrain(&'a Terrain),
    /// Name to value in SI units; `k_eq` may stand for `k_c` and `k_phi`; effects not named start at 0.
    Values(&'a BTreeMap<String, f64>),
    /// The law's own parameter vector: a hypothesis.
    Parameters(&'a [f64]),
}

/// The law's parameter vector at the centre.
pub(crate) fn start(law: &Law, centre: Centre<'_>, width: f64) -> Result<Vec<f64>, EstimatorError> {
    let params = law.params();
    let model = law.model();
    match centre {
        Centre::Terrain(terrain) => {
            let mut p = terrain.parameters(model)?;
            p.resize(params.len(), 0.0);
            Ok(p)
        }
        Centre::Parameters(p) if p.len() == params.len() => Ok(p.to_vec()),
        Centre::Parameters(p) => Err(EstimatorError::Size {
            what: "parameters",
            found: p.len(),
            expected: params.len(),
        }),
        Centre::Values(values) => named(law, values, width),
    }
}

fn named(
    law: &Law,
    values: &BTreeMap<String, f64>,
    width: f64,
) -> Result<Vec<f64>, EstimatorError> {
    let (params, model) = (law.params(), law.model());
    let known = |name: &str| params.iter().any(|p| p.name == name);
    let has_stiffness = known("k_c") && known("k_phi");
    for name in values.keys() {
        if !(known(name) || has_stiffness && name == "k_eq") {
            let names = params
                .iter()
                .map(|p| p.name)
                .chain(has_stiffness.then_some("k_eq"));
            let nearest = nearest(name, names).map(str::to_owned);
            return Err(ModelError::UnknownName {
                kind: "parameter",
                name: name.clone(),
                nearest,
            }
            .into());
        }
    }
    let k_eq = values.get("k_eq").copied();
    if let (Some(k_eq), true) = (
        k_eq,
        values.contains_key("k_c") || values.contains_key("k_phi"),
    ) {
        let given = |name: &str| values.get(name).copied().unwrap_or(0.0);
        let sum = given("k_c") / width + given("k_phi");
        if (sum - k_eq).abs() > 1e-6 * k_eq.abs() {
            return Err(value_error(
                "k_eq",
                k_eq,
                "k_c/b + k_phi where these are given too",
            ));
        }
    }
    let from = model.params().len();
    params
        .iter()
        .enumerate()
        .map(|(k, p)| {
            let equal = match p.name {
                "k_c" => k_eq.map(|_| 0.0),
                "k_phi" => k_eq.map(|k| k - values.get("k_c").map_or(0.0, |c| c / width)),
                _ => None,
            };
            let effect = (k >= from).then_some(0.0);
            values
                .get(p.name)
                .copied()
                .or(equal)
                .or(effect)
                .ok_or_else(|| {
                    let terrain = "start".to_owned();
                    ModelError::MissingValue {
                        terrain,
                        parameter: p.name,
                        model: model.name(),
                        reason: Missing::NotNamed,
                    }
                    .into()
                })
        })
        .collect()
}
