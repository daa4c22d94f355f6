//! What a truth may hold: effects that a diagnosis knows, other formulas of them, and effects that it does not know.

use std::collections::BTreeSet;
use std::sync::Arc;

use terra_model::{AnyEffect, Effect, Registry};

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
}

/// The registry that simulates, and which of its effects are withheld from a diagnosis.
#[derive(Clone)]
pub struct Library {
    registry: Registry,
    off_library: Vec<Known>,
    form_variants: Vec<Known>,
}

impl Library {
    /// Everything terra ships; what the truth simulation has beside the library joins here.
    ///
    /// A form that the library registers beside the default one is a variant too.
    pub fn builtin() -> Self {
        Library::new(Registry::builtin())
    }

    /// The effects of a registry; its second and later forms of a name are variants.
    pub fn new(registry: Registry) -> Self {
        let mut seen = BTreeSet::new();
        let form_variants = registry
            .effects()
            .iter()
            .filter(|e| !seen.insert(e.name()))
            .map(|e| Known::of(&**e))
            .collect();
        Library {
            registry,
            off_library: vec![],
            form_variants,
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

    /// The effect itself.
    pub(crate) fn effect(&self, of: &Known) -> Option<&Arc<dyn AnyEffect>> {
        self.registry
            .effects()
            .iter()
            .find(|e| e.name() == of.name && e.form() == of.form)
    }
}
