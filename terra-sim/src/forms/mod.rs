//! Other formulas of library effects: the same physics, written as nature might and the diagnosis library does not.

mod body;
mod soil;
mod wheel;

use terra_model::{AnyEffect, Effect, Registry};

use crate::off_library::TruthOnly;

/// One row from an effect's own constants.
const fn row<E: Effect>(low: f64, high: f64) -> TruthOnly {
    TruthOnly {
        name: E::NAME,
        form: E::FORM,
        magnitude: (low, high),
        unit: E::PARAMS[0].unit,
        scope: E::SCOPE,
        summary: E::SUMMARY,
        reference: E::REFERENCE,
    }
}

static LIST: &[TruthOnly] = &[
    row::<soil::SinkageFactor>(0.3, 1.2),
    row::<soil::RationalSoftening>(0.2, 1.0),
    row::<soil::LinearPasses>(0.3, 1.5),
    row::<soil::ReleasedBySlip>(0.1, 0.5),
    row::<soil::LogarithmicRate>(0.1, 0.8),
    row::<soil::SofteningStrength>(0.1, 0.6),
    row::<soil::LoadHardening>(0.5, 3.0),
    row::<soil::PartialRim>(0.1, 0.5),
    row::<soil::LogisticFront>(0.2, 0.8),
    row::<soil::StrengthContrast>(0.3, 1.0),
    row::<wheel::LoadFlattening>(0.1, 0.5),
    row::<wheel::PassiveLug>(0.005, 0.03),
    row::<wheel::WedgeAhead>(0.3, 2.0),
    row::<wheel::WedgeAside>(0.5, 3.0),
    row::<wheel::FrictionEllipse>(0.2, 1.0),
    row::<body::LoadedCoulomb>(1.0, 4.0),
    row::<body::RootViscous>(0.5, 2.0),
    row::<body::LinearDroop>(0.1, 0.5),
    row::<body::FallingTow>(20.0, 80.0),
    row::<body::Headwind>(4.0, 16.0),
];

/// The formulas that only the truth has, of effects the diagnosis library knows by another formula.
pub fn form_variants() -> &'static [TruthOnly] {
    LIST
}

/// The form of a library effect, if it is one of these.
pub(crate) fn find(name: &str, form: &str) -> Option<std::sync::Arc<dyn AnyEffect>> {
    let all = soil::register(wheel::register(body::register(Registry::empty())));
    all.effects()
        .iter()
        .find(|e| e.name() == name && e.form() == form)
        .cloned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use terra_model::conformance::check_effect_dyn;

    #[test]
    fn every_row_is_found_and_belongs_to_a_library_effect() {
        let library = Registry::builtin();
        for row in LIST {
            let form = find(row.name, row.form).unwrap();
            let effect = library.effect(row.name).unwrap();
            assert_eq!(form.scope(), effect.scope(), "{}", row.name);
            assert!(
                library.effect_form(row.name, row.form).is_err(),
                "{}",
                row.name
            );
            let range = form.params()[0];
            check_effect_dyn(&*form).unwrap();
            assert!(
                range.min <= 0.0 && row.magnitude.1 <= range.max,
                "{}",
                row.name
            );
        }
        assert_eq!(
            LIST.len(),
            soil::register(wheel::register(body::register(Registry::empty())))
                .effects()
                .len()
        );
    }
}
