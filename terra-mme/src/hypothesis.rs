//! What may be under the wheels: a list of soils, each with the law it obeys.

use std::collections::BTreeSet;
use std::sync::Arc;

use terra_model::catalogue::{self, Terrain};
use terra_model::order::ascending;
use terra_model::{Contact, ForceLaw, Law};

use crate::error::EstimatorError;

/// One candidate: a law and its parameters. Candidates of one set may obey different laws.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Name in results.
    pub id: String,
    /// The law it obeys.
    pub law: Arc<Law>,
    /// Parameters, in the law's order and units.
    pub parameters: Vec<f64>,
}

/// A non-empty list of hypotheses with distinct names.
#[derive(Clone, Debug)]
pub struct HypothesisSet {
    hypotheses: Vec<Hypothesis>,
}

/// Two hypotheses whose forces are the same: together they hold twice the prior of one.
#[derive(Clone, Debug, PartialEq)]
pub struct NearDuplicate {
    /// Ids, in the order of the set.
    pub pair: [String; 2],
    /// Largest relative difference of torque, and of pull by |D| + |T|/R, over the probed contacts.
    pub distance: f64,
}

impl HypothesisSet {
    /// Checks and takes a list.
    ///
    /// # Errors
    /// [`EstimatorError::EmptySet`], [`EstimatorError::DuplicateId`], [`EstimatorError::Model`] for a wrong number of
    /// parameters, [`EstimatorError::Value`] for one that is not finite.
    pub fn new(hypotheses: Vec<Hypothesis>) -> Result<Self, EstimatorError> {
        if hypotheses.is_empty() {
            return Err(EstimatorError::EmptySet);
        }
        let mut seen = BTreeSet::new();
        for h in &hypotheses {
            if !seen.insert(h.id.as_str()) {
                return Err(EstimatorError::DuplicateId { id: h.id.clone() });
            }
            let params = h.law.params();
            if params.len() != h.parameters.len() {
                let source = terra_model::ModelError::ParameterCount {
                    model: h.law.name(),
                    expected: params.len(),
                    found: h.parameters.len(),
                };
                return Err(EstimatorError::Model {
                    hypothesis: h.id.clone(),
                    source,
                });
            }
            if let Some((p, &value)) = params
                .iter()
                .zip(&h.parameters)
                .find(|(_, v)| !v.is_finite())
            {
                let what = format!("{} of '{}'", p.name, h.id);
                return Err(EstimatorError::Value {
                    what,
                    value,
                    expected: "a finite number",
                });
            }
        }
        Ok(HypothesisSet { hypotheses })
    }

    /// Soils under one law; effects of the law start at magnitude 0.
    ///
    /// # Errors
    /// As [`HypothesisSet::new`]; [`EstimatorError::Model`] for a soil that lacks a value the model needs.
    pub fn from_terrains(law: &Arc<Law>, terrains: &[Terrain]) -> Result<Self, EstimatorError> {
        let hypotheses = terrains.iter().map(|t| {
            let mut parameters =
                t.parameters(law.model())
                    .map_err(|source| EstimatorError::Model {
                        hypothesis: t.id.to_string(),
                        source,
                    })?;
            parameters.resize(law.params().len(), 0.0);
            Ok(Hypothesis {
                id: t.id.to_string(),
                law: Arc::clone(law),
                parameters,
            })
        });
        Self::new(hypotheses.collect::<Result<_, EstimatorError>>()?)
    }

    /// A catalogue set (`wong21`) under one law.
    ///
    /// # Errors
    /// [`EstimatorError::Name`] for an unknown set, then as [`HypothesisSet::from_terrains`].
    pub fn from_catalogue(law: &Arc<Law>, set: &str) -> Result<Self, EstimatorError> {
        Self::from_terrains(law, &catalogue::set(set)?)
    }

    /// Given parameter vectors under one law, named `prefix-1`, `prefix-2`, ...: perturbed copies, posterior draws.
    /// The caller draws them; nothing here is random.
    ///
    /// # Errors
    /// As [`HypothesisSet::new`].
    pub fn from_vectors(
        law: &Arc<Law>,
        prefix: &str,
        vectors: impl IntoIterator<Item = Vec<f64>>,
    ) -> Result<Self, EstimatorError> {
        let hypotheses = vectors
            .into_iter()
            .enumerate()
            .map(|(k, parameters)| Hypothesis {
                id: format!("{prefix}-{}", k + 1),
                law: Arc::clone(law),
                parameters,
            });
        Self::new(hypotheses.collect())
    }

    /// Both sets in one, whatever their laws.
    ///
    /// # Errors
    /// [`EstimatorError::DuplicateId`].
    pub fn joined(self, other: HypothesisSet) -> Result<Self, EstimatorError> {
        Self::new(
            self.hypotheses
                .into_iter()
                .chain(other.hypotheses)
                .collect(),
        )
    }

    /// The hypotheses, in order.
    pub fn hypotheses(&self) -> &[Hypothesis] {
        &self.hypotheses
    }

    /// N, at least 1.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.hypotheses.len()
    }

    /// Ids, in order.
    pub fn ids(&self) -> Vec<String> {
        self.hypotheses.iter().map(|h| h.id.clone()).collect()
    }

    /// Names of the laws in use with the indices of their hypotheses, in order of first appearance.
    pub fn structures(&self) -> Vec<(String, Vec<usize>)> {
        let mut found: Vec<(String, Vec<usize>)> = Vec::new();
        for (j, h) in self.hypotheses.iter().enumerate() {
            let name = h.law.name();
            match found.iter_mut().find(|(n, _)| *n == name) {
                Some((_, members)) => members.push(j),
                None => found.push((name, vec![j])),
            }
        }
        found
    }

    /// Pairs whose forces differ by at most `tolerance` (relative) at every probed contact, and which are feasible at
    /// the same ones. A pair of hypotheses feasible nowhere is reported when their parameters are equal.
    ///
    /// A warning for the caller to show: such a pair shares one prior twice.
    pub fn near_duplicates(&self, probes: &[Contact<f64>], tolerance: f64) -> Vec<NearDuplicate> {
        let forces = |h: &Hypothesis| -> Vec<Option<(f64, f64)>> {
            let at = |c| {
                h.law
                    .forces(&h.parameters, c)
                    .ok()
                    .map(|f| (f.drawbar_pull, f.resistive_torque / c.radius))
            };
            probes.iter().map(at).collect()
        };
        let all: Vec<_> = self.hypotheses.iter().map(forces).collect();
        // Sorted by the first feasible torque, twins are neighbours: far from N² comparisons for a large set.
        let key = |j: usize| {
            all[j]
                .iter()
                .flatten()
                .map(|f| f.1)
                .next()
                .unwrap_or(f64::INFINITY)
        };
        let mut order: Vec<usize> = (0..all.len()).collect();
        ascending(&mut order, |&j| key(j));
        let mut found = Vec::new();
        for (rank, &a) in order.iter().enumerate() {
            for &b in &order[rank + 1..] {
                if key(b) - key(a) > 2.0 * tolerance * key(b).abs().max(key(a).abs()) {
                    break;
                }
                let distance = match distance(&all[a], &all[b]) {
                    Some(d) => d,
                    None if self.hypotheses[a].parameters == self.hypotheses[b].parameters => 0.0,
                    None => continue,
                };
                if distance <= tolerance {
                    found.push(([a.min(b), a.max(b)], distance));
                }
            }
        }
        found.sort_by_key(|(pair, _)| *pair);
        let id = |j: usize| self.hypotheses[j].id.clone();
        found
            .into_iter()
            .map(|([a, b], distance)| NearDuplicate {
                pair: [id(a), id(b)],
                distance,
            })
            .collect()
    }
}

/// Largest relative difference; infinite when one is feasible where the other is not, `None` when neither ever is.
fn distance(a: &[Option<(f64, f64)>], b: &[Option<(f64, f64)>]) -> Option<f64> {
    let mut worst: Option<f64> = None;
    for pair in a.iter().zip(b) {
        match pair {
            (Some((d1, t1)), Some((d2, t2))) => {
                let torque = (t1 - t2).abs() / t1.abs().max(t2.abs());
                let pull = (d1 - d2).abs() / (d1.abs() + t1.abs()).max(d2.abs() + t2.abs());
                worst = Some(worst.unwrap_or(0.0).max(torque).max(pull));
            }
            (None, None) => {}
            _ => return Some(f64::INFINITY),
        }
    }
    worst
}
