//! Parameters under the posterior: means inside one structure, never across structures.

use nalgebra::{DMatrix, DVector};
use terra_model::ForceLaw;

use crate::hypothesis::HypothesisSet;

/// Mean and covariance of the parameters of one law, given that the law is right.
///
/// The mean (Ray 2008, eq. 24) lies in the hull of the hypotheses' parameters; its *forces* need not lie in the hull
/// of theirs. It is a description, not something to predict with.
#[derive(Clone, Debug, PartialEq)]
pub struct StructureBelief {
    /// Name of the law.
    pub model: String,
    /// Probability of the law: the sum over its hypotheses.
    pub probability: f64,
    /// Names of the parameters (p).
    pub names: Vec<&'static str>,
    /// Their units (p).
    pub units: Vec<&'static str>,
    /// Mean (p).
    pub mean: DVector<f64>,
    /// Covariance (p x p) between hypotheses.
    pub covariance: DMatrix<f64>,
}

impl StructureBelief {
    /// Standard deviation of parameter `k`.
    pub fn sd(&self, k: usize) -> Option<f64> {
        self.covariance.get((k, k)).map(|v| v.max(0.0).sqrt())
    }
}

/// What is believed about the parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterBelief {
    /// All hypotheses obey one law.
    Shared(StructureBelief),
    /// Several laws, each with its own parameters, in order of first appearance; laws of probability 0 are left out.
    PerModel(Vec<StructureBelief>),
}

impl ParameterBelief {
    /// The belief under given weights.
    pub fn of(set: &HypothesisSet, weights: &[f64]) -> Self {
        let structures = set.structures();
        let shared = structures.len() == 1;
        let mut beliefs: Vec<StructureBelief> = structures
            .iter()
            .filter_map(|(name, members)| structure(set, weights, name, members))
            .collect();
        match (shared, beliefs.pop()) {
            (true, Some(only)) => ParameterBelief::Shared(only),
            (_, last) => {
                beliefs.extend(last);
                ParameterBelief::PerModel(beliefs)
            }
        }
    }

    /// The belief within each structure.
    pub fn structures(&self) -> &[StructureBelief] {
        match self {
            ParameterBelief::Shared(one) => std::slice::from_ref(one),
            ParameterBelief::PerModel(all) => all,
        }
    }

    /// The belief within the most probable structure.
    pub fn most_probable(&self) -> Option<&StructureBelief> {
        self.structures()
            .iter()
            .max_by(|a, b| a.probability.total_cmp(&b.probability))
    }
}

fn structure(
    set: &HypothesisSet,
    weights: &[f64],
    name: &str,
    members: &[usize],
) -> Option<StructureBelief> {
    let held: Vec<_> = members
        .iter()
        .filter_map(|&j| Some((set.hypotheses().get(j)?, *weights.get(j)?)))
        .collect();
    let probability: f64 = held.iter().map(|(_, w)| w).sum();
    let (first, _) = held.first()?;
    if probability <= 0.0 {
        return None;
    }
    let params = first.law.params();
    let n = params.len();
    let mut mean = DVector::zeros(n);
    for (h, w) in &held {
        mean += DVector::from_column_slice(&h.parameters) * (w / probability);
    }
    let mut covariance = DMatrix::zeros(n, n);
    for (h, w) in &held {
        let d = DVector::from_column_slice(&h.parameters) - &mean;
        covariance += &d * d.transpose() * (w / probability);
    }
    Some(StructureBelief {
        model: name.to_owned(),
        probability,
        names: params.iter().map(|p| p.name).collect(),
        units: params.iter().map(|p| p.unit).collect(),
        mean,
        covariance,
    })
}
