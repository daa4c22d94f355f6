//! What must not matter does not matter.

use terra::data::{Measured, RigLog, RigRow};
use terra::gap::{Diagnosis, Settings, diagnose_rig};
use terra::model::{
    Channel, Contact, Effect, ForceLaw, Param, Real, Registry, Scale, Scope, Touch, catalogue,
};

use crate::{probability, rig};

/// Noise-free rows of dry sand, the pull read 4 N too high.
fn rows() -> Vec<RigRow> {
    let law = Registry::builtin().law("wong-reece").unwrap();
    let p = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    let measured = |value| Measured { value, sd: None };
    let mut rows = vec![];
    for load in [150.0, 245.0, 400.0] {
        for slip in [0.05, 0.1, 0.2, 0.35, 0.5, 0.7] {
            let f = law
                .forces(&p, &Contact::new(slip, load, 0.254, 0.15))
                .unwrap();
            rows.push(RigRow {
                line: rows.len() as u64 + 2,
                trial: format!("{load}"),
                condition: String::new(),
                pass: 1,
                time: None,
                slip: measured(slip),
                normal_load: measured(load),
                drawbar_pull: Some(measured(f.drawbar_pull + 4.0)),
                torque: Some(measured(f.resistive_torque)),
                sinkage: f.sinkage.map(measured),
                side_force: None,
                slip_angle: None,
                travel_speed: None,
                wheel_speed: None,
            });
        }
    }
    rows
}

fn diagnose(rows: Vec<RigRow>, registry: &Registry) -> Diagnosis {
    let rover = rig();
    let log = RigLog {
        rows,
        ..RigLog::default()
    };
    diagnose_rig(&log, &rover, registry, &Settings::of(&rover))
        .unwrap()
        .0
}

#[test]
fn the_order_of_rows_does_not_matter() {
    let registry = Registry::builtin();
    let there = diagnose(rows(), &registry);
    let mut back = rows();
    back.reverse();
    let back = diagnose(back, &registry);
    assert_eq!(there.verdict, back.verdict);
    for c in &there.causes {
        assert!(
            (c.probability - probability(&back, &c.name)).abs() < 1e-4,
            "{}",
            c.name
        );
    }
}

/// Closed form: without noise in the data the true effect leaves nothing, and held-out data close entirely.
#[test]
fn the_true_effect_closes_a_noise_free_gap() {
    let d = diagnose(rows(), &Registry::builtin());
    assert_eq!(d.causes[0].name, "drawbar-bias");
    // The prior pulls the magnitude (2 sd away) a little towards 0; that is all that is left.
    assert!(d.waterfall.after.unwrap() < 0.05, "{:?}", d.waterfall);
    let held = d.held_out.unwrap();
    assert!(
        held.chi2_after < 0.05 * held.chi2_before,
        "{} of {}",
        held.chi2_after,
        held.chi2_before
    );
}

/// The load cell's offset under another name.
#[derive(Default)]
struct Twin;

impl Effect for Twin {
    const NAME: &'static str = "drawbar-twin";
    const SUMMARY: &'static str = "an offset of the load cell, under another name";
    const PARAMS: &'static [Param] = &[Param {
        name: "magnitude",
        symbol: "e",
        unit: "N",
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        scale: Scale::Linear,
        prior_sd: 2.0,
        doc: "offset",
    }];
    const SHARE: f64 = 0.02;
    const REFERENCE: &'static str = "test";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const SCOPE: Scope = Scope::Rig;
    const REGIME: &'static str = "pull only";
    const ISOLATED_BY: &'static str = "nothing: it is the same";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::DrawbarPull {
            truth + e[0]
        } else {
            truth
        }
    }
}

/// A user's own effect takes part with one line, and one that is the same as another is said to be so.
#[test]
fn an_effect_under_another_name_is_indistinguishable() {
    let d = diagnose(rows(), &Registry::builtin().with_effect::<Twin>());
    let (a, b) = (
        probability(&d, "drawbar-bias"),
        probability(&d, "drawbar-twin"),
    );
    assert!((a - b).abs() < 1e-6 && a > 0.4, "{a} {b}");
    let twin = d.causes.iter().find(|c| c.name == "drawbar-twin").unwrap();
    assert!(
        twin.indistinguishable_from
            .contains(&"drawbar-bias".to_owned())
    );
    assert_eq!(d.verdict, "ambiguous");
}

#[test]
fn too_few_rows_are_unidentifiable_with_the_reason() {
    let mut few = rows();
    few.truncate(2);
    let d = diagnose(few, &Registry::builtin());
    assert_eq!(d.verdict, "unidentifiable");
    assert!(
        d.reason
            .unwrap()
            .contains("6 usable values for 7 soil parameters")
    );
}
