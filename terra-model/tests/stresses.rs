//! Stresses of every model that has them: where they are largest, and that no sample says otherwise.

#![allow(clippy::unwrap_used, clippy::panic)]

use terra_model::{Contact, Law, Registry, StressPoint, catalogue};

/// Forces of these come from no stresses along a rim.
const WITHOUT: [&str; 3] = ["bekker-compaction", "wes-brixius", "hard-ground"];

/// Soils that a model knows: of the catalogue, or its own.
fn soils(law: &Law) -> Vec<Vec<f64>> {
    let ids = [
        "dry_sand",
        "upland_sandy_loam",
        "lean_clay_22",
        "snow_sweden",
    ];
    let known = ids.iter().filter_map(|id| {
        let terrain = catalogue::find(id).ok()?;
        terrain.parameters(law.model()).ok()
    });
    let known: Vec<Vec<f64>> = known.collect();
    if known.is_empty() {
        law.model().typical_parameters()
    } else {
        known
    }
}

#[test]
fn every_model_with_stresses_gives_them_with_their_peaks() {
    let registry = Registry::builtin();
    let mut without = vec![];
    for model in registry.models().iter().chain(registry.named_models()) {
        let law = Law::new(model.clone(), vec![]).unwrap();
        let (mut profiles, mut refused) = (0, 0);
        for p in soils(&law) {
            for slip in [-1.0, -0.5, -0.1, 0.0, 0.05, 0.3, 0.9, 1.0] {
                for load in [90.0, 245.25] {
                    let at = Contact::new(slip, load, 0.254, 0.15);
                    let place = format!("{} slip {slip} load {load} {p:?}", model.name());
                    let profile = match law.stresses(&p, &at, 4001) {
                        Ok(Some(profile)) => profile,
                        Ok(None) => {
                            refused += 1;
                            continue;
                        }
                        // No equilibrium is an answer of its own.
                        Err(_) => continue,
                    };
                    profiles += 1;
                    let (first, last) = (profile.points[0].angle, profile.points[4000].angle);
                    let largest = |of: &dyn Fn(&StressPoint) -> f64| {
                        profile
                            .points
                            .iter()
                            .map(of)
                            .fold(f64::NEG_INFINITY, f64::max)
                    };
                    let sizes = |of: &dyn Fn(&StressPoint) -> f64| largest(&|q| of(q).abs());
                    for (what, peak, of) in [
                        (
                            "normal",
                            profile.max_normal,
                            (&|q: &StressPoint| q.normal_stress) as &dyn Fn(&StressPoint) -> f64,
                        ),
                        ("shear", profile.max_shear, &|q: &StressPoint| {
                            q.shear_stress
                        }),
                    ] {
                        assert!(of(&peak).is_finite() && peak.angle.is_finite(), "{place}");
                        // Up to rounding.
                        let within = first - 1e-12 <= peak.angle && peak.angle <= last + 1e-12;
                        assert!(within, "{what} {first} {} {last} {place}", peak.angle);
                        let over = (largest(of) - of(&peak)) / sizes(of);
                        assert!(over <= 1e-9, "{what} {over:e} over the peak: {place}");
                        // Nor is it above all samples by more than lies between two of them.
                        assert!(over >= -2e-2, "{what} {over:e}: {place}");
                    }
                }
            }
        }
        if profiles == 0 {
            assert!(refused > 0, "{}", model.name());
            without.push(model.name());
        } else {
            assert!(
                refused == 0 && profiles >= 15,
                "{} {profiles}",
                model.name()
            );
        }
    }
    without.sort_unstable();
    let mut expected = WITHOUT.to_vec();
    expected.sort_unstable();
    assert_eq!(without, expected);
}
