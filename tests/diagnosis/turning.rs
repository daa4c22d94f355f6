//! What shows in turns.

use terra::gap::{Diagnosis, Settings, diagnose_drive};
use terra::sim::{Command, EffectSetting, Profile, Scenario, StartMotion, simulate_drive};

use crate::vehicle::{effect, example};

/// The example's drive with a turn to either side, by these wheel speeds left and right.
pub(crate) fn diagnosed(
    turns: [(f64, f64); 2],
    effects: Vec<EffectSetting>,
    change: impl FnOnce(&mut Scenario),
) -> Diagnosis {
    let (rover, registry, mut scenario) = example();
    for (name, (left, right)) in ["left", "right"].into_iter().zip(turns) {
        let mut turn = scenario.segments[1].clone();
        turn.name = name.to_owned();
        let sides = [left, right, left, right];
        turn.command = Command::WheelSpeed(sides.map(Profile::constant));
        turn.start = Some(StartMotion {
            ground_speed: 1.0,
            wheel_speed: [4.2; 4],
        });
        scenario.segments.push(turn);
    }
    scenario.effects = effects;
    change(&mut scenario);
    let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    diagnose_drive(&log, &rover, &registry, &Settings::of(&rover)).unwrap()
}

/// Wheels dragged sideways give less pull: the cause is named and has its size whether they give a side force too or not, although
/// without one its slope at zero is zero.
#[test]
fn wheels_dragged_sideways_are_named_with_a_side_force_and_without() {
    for (form, magnitude) in [("default", 0.4), ("pull-only", 1.2)] {
        let dragged = EffectSetting {
            form: (form != "default").then(|| form.to_owned()),
            ..effect(("skid-steer-lateral-slip", magnitude))
        };
        let d = diagnosed([(2.4, 6.0), (6.4, 2.8)], vec![dragged], |_| {});
        let first = &d.causes[0];
        assert_eq!(
            (d.verdict, first.name.as_str(), first.form.as_str()),
            ("named", "skid-steer-lateral-slip", form),
            "{:?}",
            d.set
        );
        let fit = &first.weighed.fit.x;
        let found = 0.5 * fit[first.weighed.hypothesis.soil_len()];
        assert!((found - magnitude).abs() < 0.2 * magnitude, "{found}");
    }
}
