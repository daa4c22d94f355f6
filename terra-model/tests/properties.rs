//! Propositions about the wheel: what always holds is tried on random soils, what does not hold keeps a stored
//! counterexample that must go on failing.

#![allow(clippy::unwrap_used, clippy::panic)]

use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use terra_model::models::{Accuracy, WongReece};
use terra_model::split::split;
use terra_model::{
    Batch, BatchForces, Contact, ForceLaw, Law, ModelError, Precision, Registry, WheelForces,
    catalogue,
};

const QUARTER: f64 = std::f64::consts::FRAC_PI_2;

fn law() -> Law {
    Registry::builtin().law("wong-reece").unwrap()
}

fn contact(slip: f64, load: f64) -> Contact<f64> {
    Contact::new(slip, load, 0.254, 0.15)
}

fn catalogue_soil(id: &str) -> Vec<f64> {
    catalogue::find(id)
        .unwrap()
        .parameters(law().model())
        .unwrap()
}

fn solve(p: &[f64], slip: f64, load: f64) -> Result<WheelForces<f64>, ModelError> {
    law().forces(p, &contact(slip, load))
}

fn carried(p: &[f64], slip: f64, entry: f64) -> f64 {
    WongReece
        .supported_load(p, &contact(slip, 1.0), entry)
        .unwrap()
}

/// exp of a number between the logarithms of two.
fn between(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

prop_compose! {
    /// Any soil of the domain of P1: k > 0 whole in k_φ, the apex anywhere inside the contact.
    fn soil()(
        k in between(1e3, 1e9),
        n in 0.1..1.6_f64,
        c in prop_oneof![Just(0.0), between(1.0, 1e5)],
        phi in 0.0..1.4_f64,
        shear in between(1e-3, 0.2),
        apex in 0.02..0.98_f64,
        growth in 0.0..1.0_f64,
    ) -> Vec<f64> {
        vec![0.0, k, n, c, phi, shear, apex, growth * (0.99 - apex)]
    }
}

/// 300 in the suite, more on request: `PROPTEST_CASES=10000`.
fn config() -> ProptestConfig {
    let asked = std::env::var("PROPTEST_CASES").ok();
    ProptestConfig {
        cases: asked.and_then(|n| n.parse().ok()).unwrap_or(300),
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    }
}

/// Found by `braking_balances_too`: the load hardly rises between 0.6 and 0.9 rad, and Newton's steps alone crept there for
/// more than 200 iterations.
#[test]
fn a_bend_in_the_load_curve_does_not_stall_the_root() {
    let p = [
        0.0,
        1_349_857.049_267_506_2,
        0.700_281_324_935_698_8,
        0.0,
        1.170_429_561_962_577_3,
        0.018_282_116_677_317_16,
        0.776_266_288_357_826_4,
        0.0,
    ];
    let (slip, load) = (-0.409_582_901_628_448_07, 3_624.683_005_223_610_5);
    let entry = solve(&p, slip, load).unwrap().angles.unwrap().entry;
    assert!((carried(&p, slip, entry) - load).abs() < 1e-9 * load);
}

/// Found by `braking_balances_too` at 1e4 cases: the load comes from -755 N through zero near 88 degrees, where it grows by a
/// power of ten thousand.
#[test]
fn a_load_on_its_way_through_zero_is_balanced_too() {
    let p = [
        0.0,
        103_256.948_474_569_52,
        0.721_633_224_884_858_6,
        49_090.686_714_785_814,
        0.694_754_734_400_361,
        0.012_892_736_339_961_824,
        0.02,
        0.0,
    ];
    let (slip, load) = (-0.798_546_789_097_085_9, 1.180_880_006_228_562_7);
    let entry = solve(&p, slip, load).unwrap().angles.unwrap().entry;
    assert!((carried(&p, slip, entry) - load).abs() < 1e-9 * load);
}

/// Cohesive and nearly without stiffness: a braked wheel is pulled in at every depth, and the most it is carried by is
/// nothing.
#[test]
fn a_soil_that_carries_nothing_says_so() {
    let p = [0.0, 1e3, 1.548_608, 4194.273, 0.0, 0.2, 0.02, 0.0];
    assert!((1..=90).all(|d| carried(&p, -0.912, f64::from(d).to_radians()) < 0.0));
    let Err(ModelError::NoEquilibrium { load, max_load }) = solve(&p, -0.912, 1.0) else {
        panic!("carried")
    };
    assert_eq!((load, max_load), (1.0, 0.0));
}

/// ∫ f dθ from one angle to another by Simpson's rule on panels that narrow towards both, where stresses begin as broken
/// powers.
fn graded(from: f64, to: f64, f: &dyn Fn(f64) -> f64) -> f64 {
    let half: Vec<f64> = (0..=60)
        .map(|q| 0.5 * (to - from) * 0.7_f64.powi(60 - q))
        .collect();
    let mut ends = vec![from];
    ends.extend(half.iter().map(|x| from + x));
    ends.extend(half.iter().rev().skip(1).map(|x| to - x));
    ends.push(to);
    let panel = |a: f64, b: f64| {
        let h = (b - a) / 16.0;
        let weight = |q: i32| {
            if q == 0 || q == 16 {
                1.0
            } else if q % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        (0..=16)
            .map(|q| weight(q) * f(a + h * f64::from(q)))
            .sum::<f64>()
            * h
            / 3.0
    };
    ends.windows(2).map(|w| panel(w[0], w[1])).sum()
}

proptest! {
    #![proptest_config(config())]

    /// P1: for slip in [0, 1] the carried load rises strictly with the entry angle.
    #[test]
    fn p1_load_rises_with_the_entry_angle(p in soil(), slip in 0.0..=1.0_f64, a in 1e-3..1.0_f64, b in 1e-3..1.0_f64) {
        prop_assume!((a - b).abs() > 1e-3 * a.max(b));
        let (low, high) = (a.min(b) * QUARTER, a.max(b) * QUARTER);
        prop_assert!(carried(&p, slip, low) < carried(&p, slip, high));
    }

    /// P2: an equilibrium exists exactly when the soil carries the load at 90°, and it balances the load.
    #[test]
    fn p2_the_root_exists_and_balances(p in soil(), slip in 0.0..=1.0_f64, load in between(1.0, 1e5)) {
        let most = carried(&p, slip, QUARTER);
        match solve(&p, slip, load) {
            Ok(f) => {
                prop_assert!(load <= most * (1.0 + 1e-12));
                let balance = carried(&p, slip, f.angles.unwrap().entry);
                prop_assert!((balance - load).abs() < 1e-11 * load, "{balance} for {load}");
            }
            Err(ModelError::NoEquilibrium { load: asked, max_load }) => {
                prop_assert_eq!(asked, load);
                prop_assert!(max_load < load && (max_load - most).abs() < 1e-12 * most);
            }
            Err(e) => prop_assert!(false, "{}", e),
        }
    }

    /// Braking has no theorem, but what is returned balances the load and is what a wheel reaches first as it sinks; a load
    /// is refused only where no angle carries it before the carried load falls again.
    #[test]
    fn braking_balances_too(p in soil(), slip in -1.0..0.0_f64, load in between(1.0, 1e5)) {
        match solve(&p, slip, load) {
            Ok(f) => {
                let balance = carried(&p, slip, f.angles.unwrap().entry);
                prop_assert!((balance - load).abs() < 1e-9 * load, "{balance} for {load}");
                let entry = f.angles.unwrap().entry;
                for q in 1..60 {
                    let w = carried(&p, slip, entry * f64::from(q) / 60.0);
                    prop_assert!(w <= load * (1.0 + 1e-9), "{w} at step {q} for {load}");
                }
            }
            Err(ModelError::NoEquilibrium { max_load, .. }) => {
                // More may be carried only past a place that carries at least a hundredth of the most and then less.
                let even = (1..=200).map(|q| QUARTER * f64::from(q) / 200.0);
                let small = (1..400).map(|q| QUARTER * 0.965_f64.powi(q));
                let mut angles: Vec<f64> = even.chain(small).collect();
                angles.sort_by(f64::total_cmp);
                let loads: Vec<f64> = angles.iter().map(|a| carried(&p, slip, *a)).collect();
                let foothold = 0.01 * loads.iter().fold(0.0, |a: f64, b| a.max(*b));
                let fold = loads.windows(2).position(|w| w[0] > foothold && w[1] < w[0]);
                for w in &loads[..=fold.unwrap_or(loads.len() - 1)] {
                    prop_assert!(*w <= max_load + 1e-9 * max_load.max(w.abs()), "{w}, most {max_load}, fold {fold:?}");
                }
            }
            Err(e) => prop_assert!(false, "{}", e),
        }
    }

    /// P6: one width shows only k_c/b + k_φ.
    #[test]
    fn p6_one_width_shows_only_the_sum(p in soil(), share in -2.0..2.0_f64, slip in -0.9..=1.0_f64, load in between(1.0, 1e4)) {
        let mut q = p.clone();
        q[0] = share * p[1] * 0.15;
        q[1] = p[1] - q[0] / 0.15;
        match (solve(&p, slip, load), solve(&q, slip, load)) {
            (Ok(f), Ok(g)) => {
                let scale = f.drawbar_pull.abs() + f.resistive_torque.abs() / 0.254;
                prop_assert!((f.drawbar_pull - g.drawbar_pull).abs() < 1e-11 * scale);
                prop_assert!((f.resistive_torque - g.resistive_torque).abs() < 1e-11 * scale * 0.254);
                prop_assert!((f.sinkage.unwrap() - g.sinkage.unwrap()).abs() < 1e-11 * f.sinkage.unwrap());
            }
            (f, g) => prop_assert!(f.is_err() && g.is_err()),
        }
    }

    /// P7: c, k and W times one factor: the same entry angle, forces times the factor.
    #[test]
    fn p7_stress_has_no_scale(p in soil(), slip in -0.9..=1.0_f64, load in between(1.0, 1e4), factor in between(1e-3, 1e3)) {
        let mut q = p.clone();
        q[1] *= factor;
        q[3] *= factor;
        match (solve(&p, slip, load), solve(&q, slip, load * factor)) {
            (Ok(f), Ok(g)) => {
                let scale = f.drawbar_pull.abs() + f.resistive_torque.abs() / 0.254;
                let (a, b) = (f.angles.unwrap().entry, g.angles.unwrap().entry);
                prop_assert!((a - b).abs() < 1e-12 * a);
                prop_assert!((f.drawbar_pull - g.drawbar_pull / factor).abs() < 1e-11 * scale);
                prop_assert!((f.resistive_torque - g.resistive_torque / factor).abs() < 1e-11 * scale * 0.254);
            }
            (f, g) => prop_assert!(f.is_err() && g.is_err()),
        }
    }

    /// P7: half as many nodes again change forces by less than is promised for any soil; 1e-11 on tabulated ones is another
    /// test's.
    #[test]
    fn p7_more_nodes_change_nothing(p in soil(), slip in -0.9..=1.0_f64, load in between(1.0, 1e4)) {
        let at = contact(slip, load);
        let within = |accuracy| WongReece.forces_within(&p, &at, accuracy);
        match (within(Accuracy::Fine), within(Accuracy::Reference)) {
            (Ok(f), Ok(g)) => {
                let most = 1e-9;
                let scale = g.drawbar_pull.abs() + g.resistive_torque.abs() / 0.254;
                let (a, b) = (f.angles.unwrap().entry, g.angles.unwrap().entry);
                prop_assert!((a - b).abs() < most * b, "{a} {b}");
                prop_assert!((f.drawbar_pull - g.drawbar_pull).abs() < most * scale);
                prop_assert!((f.resistive_torque - g.resistive_torque).abs() < most * scale * 0.254);
            }
            (f, g) => prop_assert!(f.is_err() && g.is_err()),
        }
    }

    /// A batch keeps its tier on any soil.
    #[test]
    fn a_batch_keeps_its_tier(p in soil(), slip in -0.9..=1.0_f64, load in between(1.0, 1e4)) {
        let columns: Vec<&[f64]> = p.iter().map(std::slice::from_ref).collect();
        let batch = Batch {
            parameters: &columns,
            slip: &[slip],
            normal_load: &[load],
            radius: 0.254,
            width: 0.15,
        };
        let mut out = BatchForces::default();
        law().solve_batch(&batch, Precision::Double, &mut out).unwrap();
        match solve(&p, slip, load) {
            Ok(f) => {
                prop_assert!(out.status[0].is_ok(), "{:?}", out.status[0]);
                let scale = f.drawbar_pull.abs() + f.resistive_torque.abs() / 0.254;
                let entry = f.angles.unwrap().entry;
                prop_assert!((out.entry_angle[0] - entry).abs() < 1e-7 * entry, "{} {entry}", out.entry_angle[0]);
                prop_assert!((out.drawbar_pull[0] - f.drawbar_pull).abs() < 1e-7 * scale);
                prop_assert!((out.resistive_torque[0] - f.resistive_torque).abs() < 1e-7 * scale * 0.254);
            }
            Err(_) => prop_assert!(out.status[0].is_err()),
        }
    }

    /// P5: the mirror image of τ about θ1/2 has the same torque, by a quadrature of the test's own, and can be a shape of the
    /// model only without cohesion: τ vanishes at the entry, and at the bottom only where c = 0.
    #[test]
    fn p5_a_mirrored_shear_stress_has_the_same_torque(p in soil(), slip in 0.02..=1.0_f64, load in between(1.0, 1e4)) {
        let Ok(f) = solve(&p, slip, load) else { return Ok(()) };
        let (entry, apex) = f.angles.map(|a| (a.entry, a.max_stress)).unwrap();
        let field = law().stress_field(&p, &contact(slip, load)).unwrap().unwrap();
        let tau = |angle: f64| field.at(angle).shear_stress;
        let sum = |bend: f64, stress: &dyn Fn(f64) -> f64| {
            (graded(0.0, bend, stress) + graded(bend, entry, stress)) * 0.254 * 0.254 * 0.15
        };
        let (torque, mirrored) = (sum(apex, &tau), sum(entry - apex, &|angle| tau(entry - angle)));
        prop_assert!((torque - f.resistive_torque).abs() <= 1e-6 * f.resistive_torque.abs(), "{torque} {}", f.resistive_torque);
        prop_assert!((mirrored - torque).abs() <= 1e-6 * torque.abs(), "{mirrored} {torque}");
        let most = p[3] + f64::max(1.0, load);
        prop_assert!(tau(entry).abs() < 1e-9 * most, "{}", tau(entry));
        if p[3] > 0.0 {
            prop_assert!(tau(0.0) > 0.0);
        } else {
            prop_assert!(tau(0.0).abs() < 1e-9 * most, "{}", tau(0.0));
        }
    }

    /// P8: the split into one resultant gives the forces back, or says that there is none.
    #[test]
    fn p8_the_split_round_trips(d in -1e3..1e3_f64, t in -2e2..2e2_f64, w in 1.0..1e3_f64, r in 0.05..1.0_f64) {
        let limit = r * d.hypot(w);
        match split(d, t, w, r) {
            Ok(s) => {
                prop_assert!(t.abs() <= limit * (1.0 + 1e-15) && s.radial_force >= 0.0);
                let (sin, cos) = s.resultant_angle.sin_cos();
                let scale = d.hypot(w);
                prop_assert!((s.tangential_force * cos - s.radial_force * sin - d).abs() < 1e-12 * scale);
                prop_assert!((s.tangential_force * sin + s.radial_force * cos - w).abs() < 1e-12 * scale);
                prop_assert!((s.thrust - s.resistance - d).abs() < 1e-12 * scale);
                prop_assert!((s.tangential_force.hypot(s.radial_force) - scale).abs() < 1e-12 * scale);
            }
            Err(ModelError::NotAResultant { torque, limit: said }) => {
                prop_assert!(t.abs() >= limit * (1.0 - 1e-15));
                prop_assert_eq!(torque, t);
                prop_assert!((said - limit).abs() < 1e-12 * limit);
            }
            Err(e) => prop_assert!(false, "{}", e),
        }
    }
}

/// P1' fails: braked on snow the carried load is negative for small angles, so it falls before it rises.
#[test]
fn p1_prime_fails_on_a_braked_wheel_in_snow() {
    let p = catalogue_soil("snow_sweden");
    assert!(carried(&p, -0.3, 0.1) < 0.0 && carried(&p, -0.3, 0.2) < carried(&p, -0.3, 0.1));
    assert!(carried(&p, -0.3, 1.0) > 0.0);
}

/// Of the 21 tabulated soils only the snows do so at moderate braking.
#[test]
fn p1_prime_holds_on_the_other_tabulated_soils() {
    for soil in catalogue::set("wong21").unwrap() {
        let p = soil.parameters(law().model()).unwrap();
        let dips = [-0.05, -0.1, -0.2].into_iter().any(|slip| {
            let loads: Vec<f64> = (1..=400)
                .map(|q| carried(&p, slip, QUARTER * f64::from(q) / 400.0))
                .collect();
            loads.windows(2).any(|w| w[1] <= w[0])
        });
        assert_eq!(dips, soil.class == "snow", "{}", soil.id);
    }
}

/// A locked wheel is carried best before it is buried: the load at 90° is not the largest.
#[test]
fn a_locked_wheel_is_carried_best_above_ninety_degrees() {
    let p = catalogue_soil("sandy_loam_22");
    let buried = carried(&p, -1.0, QUARTER);
    let load = 1.3 * buried;
    let f = solve(&p, -1.0, load).unwrap();
    assert!(f.angles.unwrap().entry < 1.1);
    let Err(ModelError::NoEquilibrium { max_load, .. }) = solve(&p, -1.0, 2.0 * buried) else {
        panic!("carried")
    };
    assert!(max_load > load);
}

/// What `pick` takes from the forces at the slips of [0, 1] where the load is carried.
fn curve(p: &[f64], load: f64, pick: impl Fn(&WheelForces<f64>) -> f64) -> Vec<f64> {
    (0..=50)
        .filter_map(|q| solve(p, f64::from(q) / 50.0, load).ok().map(|f| pick(&f)))
        .collect()
}

fn falls(values: &[f64]) -> bool {
    values.windows(2).any(|w| w[1] < w[0] - 1e-9 * w[0].abs())
}

/// P3: the torque rises with slip on every tabulated soil but the snows, at both loads ...
#[test]
fn p3_torque_rises_on_tabulated_soils() {
    for soil in catalogue::set("wong21")
        .unwrap()
        .iter()
        .filter(|s| s.class != "snow")
    {
        let p = soil.parameters(law().model()).unwrap();
        for load in [245.25, 2452.5] {
            assert!(
                !falls(&curve(&p, load, |f| f.resistive_torque)),
                "{} at {load} N",
                soil.id
            );
        }
    }
}

/// ... but it is no theorem: here it falls by .3 % before slip 1.
#[test]
fn p3_fails_on_a_stored_soil() {
    let p = [
        0.0,
        1_528_400.0,
        1.4054,
        88.42,
        0.7993,
        0.002_174,
        0.524,
        0.3689,
    ];
    let torque = |slip| solve(&p, slip, 60.0).unwrap().resistive_torque;
    assert!(
        torque(1.0) < 0.998 * torque(0.98),
        "{} {}",
        torque(1.0),
        torque(0.98)
    );
}

/// P4 fails: the pull falls with slip on 3 of 18 tabulated soils at 245 N and on 15 at 2452 N; stored: dry sand.
#[test]
fn p4_pull_does_not_always_rise() {
    let sand = catalogue_soil("dry_sand");
    let pull = |slip| solve(&sand, slip, 245.25).unwrap().drawbar_pull;
    assert!(pull(0.95) < pull(0.8) - 3.0);
    for (load, expected) in [(245.25, 3), (2452.5, 15)] {
        let table = catalogue::set("wong21").unwrap();
        let falling = table
            .iter()
            .filter(|soil| soil.class != "snow")
            .filter(|soil| {
                let p = soil.parameters(law().model()).unwrap();
                falls(&curve(&p, load, |f| f.drawbar_pull))
            });
        assert_eq!(falling.count(), expected, "at {load} N");
    }
}

/// ∫ f(τ, τ reflected about the middle of the contact, θ) dθ by the midpoint of samples.
fn integrate(p: &[f64], slip: f64, load: f64, f: impl Fn(f64, f64, f64) -> f64) -> f64 {
    let profile = law()
        .stresses(p, &contact(slip, load), 40_001)
        .unwrap()
        .unwrap();
    let entry = profile.points[40_000].angle;
    let pairs = profile.points.iter().rev().zip(&profile.points);
    pairs
        .map(|(mirrored, point)| {
            entry / 40_000.0 * f(point.shear_stress, mirrored.shear_stress, point.angle)
        })
        .sum()
}

/// P5: reflecting τ about θ1/2 keeps the torque and changes the vertical force; only without cohesion can the mirror
/// image be a shape of the model, because τ vanishes at the entry.
#[test]
fn p5_a_reflected_shear_stress_keeps_the_torque_only() {
    for id in ["dry_sand", "lean_clay_22"] {
        let p = catalogue_soil(id);
        let torque = integrate(&p, 0.4, 245.25, |tau, _, _| tau);
        let mirrored = integrate(&p, 0.4, 245.25, |_, tau, _| tau);
        assert!((torque - mirrored).abs() < 1e-12 * torque);
        let vertical = integrate(&p, 0.4, 245.25, |tau, _, angle| tau * angle.sin());
        let changed = integrate(&p, 0.4, 245.25, |_, tau, angle| tau * angle.sin());
        assert!(
            (vertical - changed).abs() > 0.03 * vertical,
            "{id}: {vertical} {changed}"
        );
    }
    let ends = |c: f64| {
        let mut p = catalogue_soil("dry_sand");
        p[3] = c;
        let profile = law()
            .stresses(&p, &contact(0.4, 245.25), 101)
            .unwrap()
            .unwrap();
        (
            profile.points[0].shear_stress,
            profile.points[100].shear_stress,
            profile.max_shear.shear_stress,
        )
    };
    let (bottom, entry, peak) = ends(0.0);
    assert!(bottom.abs() < 1e-9 * peak && entry.abs() < 1e-9 * peak);
    let (bottom, entry, peak) = ends(1040.0);
    assert!(bottom > 0.05 * peak && entry.abs() < 1e-9 * peak);
}

/// P6 fails for two widths: the same sum at .15 m is another soil at .1 m.
#[test]
fn p6_two_widths_tell_the_moduli_apart() {
    let p = catalogue_soil("upland_sandy_loam");
    let mut q = p.clone();
    (q[0], q[1]) = (0.0, p[1] + p[0] / 0.15);
    let pull = |p: &[f64], width| {
        law()
            .forces(p, &Contact::new(0.3, 245.25, 0.254, width))
            .unwrap()
            .drawbar_pull
    };
    assert!((pull(&p, 0.15) - pull(&q, 0.15)).abs() < 1e-10);
    assert!(
        (pull(&p, 0.1) - pull(&q, 0.1)).abs() > 0.5,
        "{} {}",
        pull(&p, 0.1),
        pull(&q, 0.1)
    );
}
