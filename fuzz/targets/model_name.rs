//! Names that people type: models with slots and effects, slip conventions.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use terra_fuzz::run;
use terra_model::{Contact, ForceLaw, Registry, SlipConvention};

static REGISTRY: LazyLock<Registry> = LazyLock::new(Registry::builtin);

fuzz_target!(|data: &[u8]| run(|| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let _ = SlipConvention::from_name(text);
    if let Some((name, form)) = text.split_once('=') {
        let _ = REGISTRY.effect_form(name, form);
    }
    let Ok(law) = REGISTRY.law(text) else { return };
    // Its own name means the same law.
    let again = REGISTRY.law(&law.name());
    let again = again.unwrap_or_else(|e| panic!("{} is refused: {e}", law.name()));
    assert_eq!(again.name(), law.name());
    assert_eq!(again.params().len(), law.params().len());
    // Forces or a typed error in the middle of its parameters.
    let middle: Vec<f64> = law
        .params()
        .iter()
        .map(|p| 0.5 * (p.min.max(-1e6) + p.max.min(1e6)))
        .collect();
    if let Ok(forces) = law.forces(&middle, &Contact::new(0.2, 100.0, 0.25, 0.15)) {
        assert!(
            forces.drawbar_pull.is_finite() && forces.resistive_torque.is_finite(),
            "{}",
            law.name()
        );
    }
}));
