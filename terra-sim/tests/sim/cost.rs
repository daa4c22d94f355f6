//! What a run costs, in answers of the terrain model: its root finding is what a run pays for, and counting it gives the
//! same figure on every machine. Instructions are counted by `valgrind --tool=callgrind
//! --toggle-collect='*simulate_drive_with*'` on these tests in release.
//!
//! A prototype of four wheels, without load transfer, motors, ruts or a log, took 23 steps of seven stages for 2 s at a
//! tolerance of 1e-6: 644 answers. `cargo xtask bench` counts the instructions of both.

use std::cell::Cell;

use terra_model::models::WongReece;
use terra_model::{Contact, ModelError, Param, Real, Registry, Soil, TerrainModel, WheelForces};
use terra_sim::integrate::DormandPrince;
use terra_sim::{
    Command, DriveSegment, EffectSetting, Integrator, Profile, Scenario, SideSlip, StartMotion,
    paper, simulate_drive_with,
};

use crate::support::quiet_ramp;

thread_local! {
    static ASKED: Cell<u64> = const { Cell::new(0) };
}

/// The Wong-Reece wheel, which counts how often it is asked.
#[derive(Default)]
struct Counted(WongReece);

impl TerrainModel for Counted {
    const NAME: &'static str = "counted";
    const SUMMARY: &'static str = "wong-reece, counted";
    const PARAMS: &'static [Param] = WongReece::PARAMS;
    const REFERENCE: &'static str = WongReece::REFERENCE;
    const HOOKS: &'static [terra_model::Hook] = WongReece::HOOKS;

    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        ASKED.set(ASKED.get() + 1);
        self.0.wheel_forces(p, at)
    }

    fn soil<T: Real>(&self, p: &[T], at: &Contact<T>) -> Soil<T> {
        self.0.soil(p, at)
    }
}

const TOLERANCE: f64 = 1e-6;

/// The final speed and how often the model was asked.
fn cost(scenario: &Scenario) -> (f64, u64) {
    let counted = Scenario {
        model: "counted".to_owned(),
        ..scenario.clone()
    };
    let adaptive = Integrator::DormandPrince(DormandPrince {
        relative: TOLERANCE,
        absolute: TOLERANCE,
        ..DormandPrince::default()
    });
    ASKED.set(0);
    let registry = Registry::builtin().with_model::<Counted>();
    let run = simulate_drive_with(&counted, &paper::light_rover(), &registry, adaptive).unwrap();
    (*run.truth.ground_speed.last().unwrap(), ASKED.get())
}

/// The same by fixed steps of 1 ms and the model itself.
fn speed(scenario: &Scenario) -> f64 {
    let registry = Registry::builtin();
    let run = simulate_drive_with(
        scenario,
        &paper::light_rover(),
        &registry,
        Integrator::default(),
    )
    .unwrap();
    *run.truth.ground_speed.last().unwrap()
}

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

/// Wheels times rows.
fn looks(scenario: &Scenario) -> u64 {
    let seconds: f64 = scenario.segments.iter().map(|s| s.duration).sum();
    4 * (seconds * scenario.rate).round() as u64
}

/// 2 s at 1e-6 from a table that begins empty, load transfer and 200 rows included: fewer answers than the prototype's,
/// and the final speed of fixed steps.
#[test]
fn two_seconds_of_four_wheels() {
    let scenario = quiet_ramp("dry_sand");
    let (end, asked) = cost(&scenario);
    assert!((end - speed(&scenario)).abs() < 10.0 * TOLERANCE);
    assert!(asked < 644, "{asked} answers");
}

/// In a sliding turn each look at the ground is an answer: six new stages a step, a quarter of the steps repeated, at most
/// eight looks until both accelerations agree with the loads.
#[test]
fn half_a_second_of_sliding_turn() {
    let mut scenario = rich(SideSlip::Free);
    scenario.segments = vec![speeds("turn", 0.5, [4.0; 4], [3.2, 4.8, 3.2, 4.8])];
    let (end, asked) = cost(&scenario);
    assert!((end - speed(&scenario)).abs() < 10.0 * TOLERANCE);
    assert!(asked < looks(&scenario) * 60, "{asked} answers");
}

/// Nine manoeuvres go over the same nodes: less than one answer a wheel and row, and no more when the soil has an effect
/// that looks at slip, which is tabulated with it.
#[test]
fn nine_manoeuvres() {
    let mut scenario = rich(SideSlip::Held);
    let (_, nominal) = cost(&scenario);
    scenario.effects = vec![EffectSetting::new("slip-sinkage", 0.3)];
    let (_, digging) = cost(&scenario);
    let rows = looks(&scenario);
    assert!(
        nominal < rows && digging < rows,
        "{nominal}, {digging} of {rows}"
    );
}
