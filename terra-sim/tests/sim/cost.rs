//! What a run costs. Ignored by default: they are to be counted, not passed (`valgrind --tool=callgrind`, or `time`).

use terra_sim::{
    Command, DriveSegment, EffectSetting, Integrator, Profile, Scenario, SideSlip, StartMotion,
    paper,
};

use crate::support::{drive, quiet_ramp};

fn start(v: f64) -> Option<StartMotion> {
    Some(StartMotion {
        ground_speed: v,
        wheel_speed: [4.0 * v; 4],
    })
}

fn speeds(name: &str, seconds: f64, from: [f64; 4], to: [f64; 4]) -> DriveSegment {
    let profiles = std::array::from_fn(|q| Profile {
        from: from[q],
        to: to[q],
    });
    let mut segment = DriveSegment::new(name, seconds, Command::WheelSpeed(profiles));
    segment.start = start(0.25 * (from[0] + from[1]) / 2.0);
    segment.reset = true;
    segment
}

/// Nine manoeuvres, 24 s in all.
fn rich(side_slip: SideSlip) -> Scenario {
    let all = |w: f64| [w; 4];
    let mut scenario = quiet_ramp("dry_sand");
    let mut up = speeds("up", 3.0, all(4.0), all(4.0));
    up.pitch = Some(0.0873);
    let mut down = speeds("down", 3.0, all(4.0), all(4.0));
    down.pitch = Some(-0.0873);
    let mut payload = speeds("payload", 3.0, all(3.0), all(5.0));
    payload.payload = Some(20.0);
    let mut rut = speeds("own rut", 2.0, all(3.0), all(5.0));
    rut.pass = Some(3);
    scenario.segments.extend([
        speeds("steps", 3.0, all(3.0), all(6.0)),
        speeds("fight", 2.0, all(3.0), [4.0, 4.0, 2.6, 2.6]),
        speeds("turn", 3.0, all(4.0), [3.2, 4.8, 3.2, 4.8]),
        up,
        down,
        payload,
        rut,
        speeds("reverse", 3.0, all(-3.0), all(-5.0)),
    ]);
    scenario.world.side_slip = side_slip;
    scenario
}

#[test]
#[ignore = "counted under callgrind"]
fn two_seconds_of_four_wheels() {
    let run = drive(
        &quiet_ramp("dry_sand"),
        &paper::light_rover(),
        Integrator::default(),
    );
    assert_eq!(run.truth.len(), 200);
}

#[test]
#[ignore = "counted under callgrind"]
fn two_seconds_of_sliding_turn() {
    let mut scenario = rich(SideSlip::Free);
    scenario.segments = vec![speeds("turn", 2.0, [4.0; 4], [3.2, 4.8, 3.2, 4.8])];
    let run = drive(&scenario, &paper::light_rover(), Integrator::default());
    assert_eq!(run.truth.len(), 200);
}

#[test]
#[ignore = "a share of a campaign, to be timed"]
fn nine_manoeuvres_held() {
    let run = drive(
        &rich(SideSlip::Held),
        &paper::light_rover(),
        Integrator::default(),
    );
    assert_eq!(run.truth.segments.len(), 9);
}

#[test]
#[ignore = "a share of a campaign, to be timed"]
fn nine_manoeuvres_free_and_digging() {
    let mut scenario = rich(SideSlip::Free);
    scenario.effects = vec![EffectSetting::new("slip-sinkage", 0.3)];
    let run = drive(&scenario, &paper::light_rover(), Integrator::default());
    assert_eq!(run.truth.segments.len(), 9);
}
