//! One rival explanation: a terrain model, the effects added to it, and the fit vector that both are free in.
//!
//! The fit vector is x = \[q, s\]: prior-standardised soil parameters, then prior-standardised magnitudes.

use std::sync::Arc;

use terra_model::{AnyEffect, Law, ModelError, Real};

use crate::soil_space::SoilSpace;

/// A terrain model with candidate effects, and which of its soil parameters are free.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Terrain model and effects.
    pub law: Law,
    /// Soil parameters that are re-fitted.
    pub soil: Arc<SoilSpace>,
    /// How many of the law's effects, counted from the end, are candidates (the others belong to the nominal model).
    pub candidates: usize,
}

impl Hypothesis {
    /// The nominal law alone; effects it already has are fixed at the magnitudes the soil's fit space gives them.
    pub fn null(law: Law, soil: Arc<SoilSpace>) -> Self {
        Hypothesis {
            law,
            soil,
            candidates: 0,
        }
    }

    /// The same with one more candidate effect.
    ///
    /// # Errors
    /// When the model cannot carry the effect.
    pub fn with(&self, effect: Arc<dyn AnyEffect>) -> Result<Self, ModelError> {
        Ok(Hypothesis {
            law: self.law.with_effects([effect])?,
            soil: Arc::clone(&self.soil),
            candidates: self.candidates + 1,
        })
    }

    /// The candidate effects.
    pub fn effects(&self) -> &[Arc<dyn AnyEffect>] {
        let all = self.law.effects();
        &all[all.len() - self.candidates..]
    }

    /// Number of free soil parameters.
    pub fn soil_len(&self) -> usize {
        self.soil.dim()
    }

    /// Length of the fit vector.
    pub fn len(&self) -> usize {
        self.soil.dim()
            + self
                .effects()
                .iter()
                .map(|e| e.params().len())
                .sum::<usize>()
    }

    /// True when nothing is free.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Names of the candidate effects in alphabetical order joined by `+`; empty for the nominal law alone.
    pub fn effect_name(&self) -> String {
        let mut names: Vec<&str> = self.effects().iter().map(|e| e.name()).collect();
        names.sort_unstable();
        names.join("+")
    }

    /// Names of the candidate effects and their forms, in alphabetical order.
    pub(crate) fn effect_forms(&self) -> Vec<(&'static str, &'static str)> {
        let effects = self.effects().iter();
        let mut forms: Vec<_> = effects.map(|e| (e.name(), e.form())).collect();
        forms.sort_unstable();
        forms
    }

    /// The law's parameter vector from the fit vector.
    pub fn parameters<T: Real>(&self, x: &[T]) -> Vec<T> {
        let (q, s) = x.split_at(self.soil_len().min(x.len()));
        let mut p = self.soil.parameters_t(q);
        let scales = self
            .effects()
            .iter()
            .flat_map(|e| e.params())
            .map(|p| p.prior_sd);
        p.extend(s.iter().zip(scales).map(|(s, sd)| *s * sd));
        p
    }

    /// Legal range of each component of the fit vector.
    pub fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let mut low = self.soil.lower_bounds();
        let mut high = vec![f64::INFINITY; low.len()];
        for p in self.effects().iter().flat_map(|e| e.params()) {
            low.push(p.min / p.prior_sd);
            high.push(p.max / p.prior_sd);
        }
        (low, high)
    }

    /// Which components have half of their prior cut away (lower bound exactly 0).
    pub fn one_sided(&self) -> Vec<bool> {
        self.bounds().0.iter().map(|low| *low == 0.0).collect()
    }
}
