//! Combinations by name.

use super::*;

/// Whatever the listing of slots offers is a model, and nothing else is.
#[test]
fn every_filling_of_a_slot_makes_a_model() {
    let registry = Registry::builtin();
    let mut offered = vec![];
    for wheel in WheelKind::ALL {
        let slots = Slots::of(wheel.name()).unwrap();
        let default = |of: &[Filling]| of.iter().filter(|f| f.default).count();
        assert_eq!((default(&slots.pressure), default(&slots.shear)), (1, 1));
        for pressure in &slots.pressure {
            for shear in &slots.shear {
                let name = format!("{}:{}:{}", wheel.name(), pressure.name, shear.name);
                let model = registry.model(&name).unwrap();
                for param in pressure.params.iter().chain(&shear.params) {
                    let known = model.params().iter().any(|p| p.name == param.name);
                    assert!(known || param.name == "cohesion", "{name} {}", param.name);
                }
                offered.push(model.name());
            }
        }
    }
    let mut all: Vec<_> = Slots::combinations().collect();
    all.sort_unstable();
    offered.sort_unstable();
    assert_eq!(offered, all);
    assert!(Slots::of("wes-brixius").is_none() && Slots::of("hard-ground").is_none());
}

#[test]
fn names_by_slot() {
    let registry = Registry::builtin();
    let name = |n: &str| registry.model(n).map(|m| m.name());
    assert_eq!(
        name("wong-reece:bekker:janosi-hanamoto").unwrap(),
        "wong-reece"
    );
    assert_eq!(name("scm-column:bekker").unwrap(), "scm-column");
    assert_eq!(name("ding-closed:slip-exponent").unwrap(), "ding-closed");
    assert_eq!(
        name("wong-reece:reece:janosi-hanamoto").unwrap(),
        "wong-reece:reece"
    );
    assert_eq!(
        name("wong-reece:reece:wong-hump").unwrap(),
        "wong-reece:reece:wong-hump"
    );
    for (given, known) in [
        ("compliant-tyre:bekker:janosi-hanamoto", "compliant-tyre"),
        ("braked-two-zone:bekker", "braked-two-zone"),
        (
            "compliant-tyre:exponential-snow",
            "compliant-tyre:exponential-snow",
        ),
        (
            "braked-two-zone:reece:wong-hump",
            "braked-two-zone:reece:wong-hump",
        ),
    ] {
        assert_eq!(name(given).unwrap(), known);
    }
    for (wrong, kind, meant) in [
        ("wong-rece:reece", "wheel", Some("wong-reece")),
        ("wong-reece:rece", "pressure law", Some("reece")),
        ("wong-reece:reece:wong-humb", "shear law", Some("wong-hump")),
        ("wong-reece:qqq", "pressure law", None),
    ] {
        let Err(ModelError::UnknownName {
            kind: k, nearest, ..
        }) = name(wrong)
        else {
            panic!("{wrong}")
        };
        assert_eq!((k, nearest.as_deref()), (kind, meant));
    }
    for wrong in [
        "wong-reece:bekker:janosi-hanamoto:more",
        "wes-brixius:bekker",
        "hard-ground:bekker:muskeg",
        "linear-stress:bekker:muskeg",
        "ding-closed:bekker:wong-hump",
        "braked-two-zone:bekker:interface",
    ] {
        assert!(
            matches!(name(wrong), Err(ModelError::Combination { .. })),
            "{wrong}"
        );
    }
    // A law in the other's place says which name was meant.
    for (wrong, meant) in [
        ("wong-reece:wong-hump", "wong-reece:bekker:wong-hump"),
        ("wong-reece:muskeg:peat", "wong-reece:peat:muskeg"),
        (
            "ding-closed:interface",
            "ding-closed:slip-exponent:interface",
        ),
    ] {
        let Err(ModelError::Combination { reason, .. }) = name(wrong) else {
            panic!("{wrong}")
        };
        assert!(reason.ends_with(meant), "{reason}");
        assert!(registry.model(meant).is_ok());
    }
    // Where even that is refused, the answer is why.
    let Err(ModelError::Combination { reason, .. }) = name("linear-stress:muskeg") else {
        panic!("linear-stress:muskeg")
    };
    assert!(reason.contains("closed form"), "{reason}");
    assert!(Registry::empty().model("wong-reece:reece").is_err());
    // Presets alone are listed.
    assert!(registry.models().iter().all(|m| !m.name().contains(':')));
}
