//! What a truth may hold: effects that a diagnosis knows, other formulas of them, and effects that it does not know.

use std::collections::BTreeSet;
use std::sync::Arc;

use terra_model::{AnyEffect, Effect, Param, Registry};
use terra_sim::TruthOnly;

/// Name and form of an effect.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Known {
    /// Kebab-case name.
    pub name: String,
    /// Which formula of that name.
    pub form: String,
}

impl Known {
    pub(crate) fn of(effect: &dyn AnyEffect) -> Self {
        Known {
            name: effect.name().to_owned(),
            form: effect.form().to_owned(),
        }
    }

    fn of_truth(row: &TruthOnly) -> Self {
        Known {
            name: row.name.to_owned(),
            form: row.form.to_owned(),
        }
    }
}

/// Where the magnitudes of one number of an effect lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Size {
    /// By the prior of a diagnosis, of either sign where the effect has two.
    Prior(Param),
    /// Between two ends, as the truth simulation lists them.
    Between(f64, f64),
}

/// The registry that simulates, and which of its effects are withheld from a diagnosis.
#[derive(Clone)]
pub struct Library {
    registry: Registry,
    off_library: Vec<Known>,
    form_variants: Vec<Known>,
    /// Effects and forms that the truth simulation knows by itself.
    truth_only: Vec<&'static TruthOnly>,
}

impl Library {
    /// Everything terra ships, and what the truth simulation has beside the library.
    pub fn builtin() -> Self {
        let mut library = Library::new(Registry::builtin());
        for row in terra_sim::off_library() {
            library.off_library.push(Known::of_truth(row));
            library.truth_only.push(row);
        }
        for row in terra_sim::form_variants() {
            library.form_variants.push(Known::of_truth(row));
            library.truth_only.push(row);
        }
        library
    }

    /// The effects of a registry. A diagnosis knows all their forms, so that none of them is a variant.
    pub fn new(registry: Registry) -> Self {
        Library {
            registry,
            off_library: vec![],
            form_variants: vec![],
            truth_only: vec![],
        }
    }

    /// Adds an effect that no diagnosis knows.
    #[must_use]
    pub fn with_off_library<E: Effect>(mut self) -> Self {
        self.registry = self.registry.with_effect::<E>();
        self.off_library.push(Known::of(&E::default()));
        self
    }

    /// Adds another formula of a known effect.
    #[must_use]
    pub fn with_form_variant<E: Effect>(mut self) -> Self {
        self.registry = self.registry.with_effect::<E>();
        self.form_variants.push(Known::of(&E::default()));
        self
    }

    /// The registry of the truth.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// Effects that no diagnosis knows.
    pub fn off_library(&self) -> &[Known] {
        &self.off_library
    }

    /// Other formulas of known effects.
    pub fn form_variants(&self) -> &[Known] {
        &self.form_variants
    }

    /// The default form of each known effect.
    pub fn known(&self) -> Vec<Known> {
        let mut seen = BTreeSet::new();
        let withheld = |k: &Known| self.off_library.contains(k) || self.form_variants.contains(k);
        self.registry
            .effects()
            .iter()
            .map(|e| Known::of(&**e))
            .filter(|k| !withheld(k) && seen.insert(k.name.clone()))
            .collect()
    }

    /// Where the magnitudes of an effect lie, a number each; none for an effect that is not there.
    pub(crate) fn sizes(&self, of: &Known) -> Vec<Size> {
        let listed = |row: &&&'static TruthOnly| row.name == of.name && row.form == of.form;
        if let Some(row) = self.truth_only.iter().find(listed) {
            return vec![Size::Between(row.magnitude.0, row.magnitude.1)];
        }
        self.effect(of).map_or(vec![], |e| {
            e.params().iter().copied().map(Size::Prior).collect()
        })
    }

    /// The effect itself; none for one that the truth simulation alone knows.
    fn effect(&self, of: &Known) -> Option<&Arc<dyn AnyEffect>> {
        self.registry
            .effects()
            .iter()
            .find(|e| e.name() == of.name && e.form() == of.form)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is withheld is not known, and each has a range that is not empty; a variant's name is one a diagnosis gives.
    #[test]
    fn what_the_truth_alone_has_is_withheld() {
        let library = Library::builtin();
        let known = library.known();
        assert_eq!(known, Library::new(Registry::builtin()).known());
        assert_eq!(library.off_library().len(), terra_sim::off_library().len());
        assert_eq!(
            library.form_variants().len(),
            terra_sim::form_variants().len()
        );
        for k in library.off_library() {
            assert!(known.iter().all(|known| known.name != k.name), "{}", k.name);
        }
        for k in library.form_variants() {
            assert!(known.iter().any(|known| known.name == k.name), "{}", k.name);
            assert!(!known.contains(k), "{} {}", k.name, k.form);
        }
        for k in library.off_library().iter().chain(library.form_variants()) {
            let sizes = library.sizes(k);
            assert!(!sizes.is_empty(), "{} {}", k.name, k.form);
            for size in sizes {
                match size {
                    Size::Between(low, high) => assert!(0.0 < low && low < high),
                    Size::Prior(param) => assert!(param.prior_sd > 0.0),
                }
            }
        }
    }
}
