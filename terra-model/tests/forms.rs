//! Several forms under one name: each by its own equation, and told apart by what it does.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::sync::Arc;

use terra_model::{
    BodyLoads, Channel, Contact, ForceLaw, Law, ModelError, Motion, Registry, Touch, Vehicle,
    WheelForces, catalogue,
};

const NAMES: [&str; 17] = [
    "slip-sinkage",
    "multipass",
    "bulldozing",
    "grousers",
    "rear-contact",
    "rate-stiffening",
    "wheel-compliance",
    "torque-droop",
    "terrain-drift",
    "lateral-contrast",
    "interface-friction",
    "lateral-bulldozing",
    "drivetrain-coulomb-friction",
    "drivetrain-viscous-friction",
    "layered-soil",
    "shear-hump",
    "skid-steer-lateral-slip",
];

fn soil() -> Vec<f64> {
    let law = Registry::builtin().with_forms().law("wong-reece").unwrap();
    catalogue::find("upland_sandy_loam")
        .unwrap()
        .parameters(law.model())
        .unwrap()
}

fn contact(slip: f64) -> Contact<f64> {
    Contact {
        speed: 0.3,
        wheel_speed: 0.3 / (0.254 * (1.0 - slip)),
        path: 3.0,
        earlier_passes: 1.0,
        side: 1.0,
        wheelbase: 0.6,
        ..Contact::new(slip, 245.25, 0.254, 0.15)
    }
}

fn vehicle() -> Vehicle<f64> {
    Vehicle {
        mass: 100.0,
        yaw_inertia: 10.0,
        track: 0.6,
        wheelbase: 0.6,
        cg_to_front_axle: 0.3,
        cg_height: 0.22,
        yaw_damping: 8.0,
        wheel_radius: 0.254,
        wheel_width: 0.15,
        wheel_inertia: 0.25,
        wheel_damping: 0.1,
        pitch: 0.0,
    }
}

/// Forces without and with a form.
fn change(name: &str, form: &str, e: f64, at: &Contact<f64>) -> [WheelForces<f64>; 2] {
    let registry = Registry::builtin().with_forms();
    let law = Law::new(
        registry.model("wong-reece").unwrap(),
        vec![registry.effect_form(name, form).unwrap()],
    )
    .unwrap();
    [0.0, e].map(|e| law.forces(&[soil(), vec![e]].concat(), at).unwrap())
}

/// Contact after a form acted on it.
fn touched(name: &str, form: &str, e: f64, at: &Contact<f64>) -> Contact<f64> {
    let registry = Registry::builtin().with_forms();
    let law = registry.law("wong-reece").unwrap();
    let of = law.model().soil_at(&soil(), at);
    let effect = registry.effect_form(name, form).unwrap();
    effect.before_at(&[e], &of, *at)
}

fn near(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() <= 1e-9 * expected.abs().max(1.0),
        "{found} is not {expected}"
    );
}

/// The default comes first, so that a bare name means it; forms of one name have names of their own, agree about the log they
/// show on, and those whose physics the literature has more than once have two or three.
#[test]
fn one_name_several_forms() {
    let registry = Registry::builtin().with_forms();
    let mut forms: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for effect in registry.effects() {
        forms.entry(effect.name()).or_default().push(effect.form());
        let default = registry.effect(effect.name()).unwrap();
        assert_eq!(default.form(), "default");
        assert_eq!(default.scope(), effect.scope(), "{}", effect.name());
    }
    for (name, found) in &forms {
        let mut once = found.clone();
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), found.len(), "{name}: {found:?}");
        assert!(found.len() <= 3, "{name}: {found:?}");
    }
    for name in NAMES {
        assert!(forms[name].len() >= 2, "{name}");
    }
    let unknown = registry.effect_form("grousers", "side-wall").err().unwrap();
    assert!(unknown.to_string().contains("did you mean 'side-walls'"));
}

/// What a wheel digs: e s/(1 - s) deep, at half slip e itself; nothing at zero slip.
#[test]
fn excavation_by_its_equation() {
    for (slip, dug) in [(0.0, 0.0), (0.5, 0.01), (0.2, 0.0025), (0.95, 0.09)] {
        let [a, b] = change("slip-sinkage", "excavation", 0.01, &contact(slip));
        near(b.sinkage.unwrap() - a.sinkage.unwrap(), dug);
        assert_eq!(a.resistive_torque.to_bits(), b.resistive_torque.to_bits());
        if dug > 0.0 {
            assert!(b.drawbar_pull < a.drawbar_pull);
        }
    }
    // The resistance is Bekker's work between the two depths.
    let [a, b] = change("slip-sinkage", "excavation", 0.01, &contact(0.5));
    let p = soil();
    let (k, n, z) = (p[0] / 0.15 + p[1], p[2], a.sinkage.unwrap());
    let work = 0.15 * k * ((z + 0.01).powf(n + 1.0) - z.powf(n + 1.0)) / (n + 1.0);
    near(a.drawbar_pull - b.drawbar_pull, work);
}

/// (1 + s)/(1 - s/2) at e = 1: twice the sinkage at half slip, four times at full slip.
#[test]
fn proportional_sinkage_by_its_equation() {
    for (slip, factor) in [(0.0, 1.0), (0.5, 2.0), (0.95, 1.95 / 0.525)] {
        let [a, b] = change("slip-sinkage", "proportional", 1.0, &contact(slip));
        near(b.sinkage.unwrap() / a.sinkage.unwrap(), factor);
        let (p, z) = (soil(), a.sinkage.unwrap());
        let (k, power) = (p[0] / 0.15 + p[1], p[2] + 1.0);
        let work = 0.15 * k * ((factor * z).powf(power) - z.powf(power)) / power;
        near(a.drawbar_pull - b.drawbar_pull, work);
    }
}

/// Wheels dragged sideways give the default's pull and torque and no side force; a flank that ploughs keeps its own, and so does
/// a wheel that slides sideways by itself.
#[test]
fn sideways_slip_may_take_from_the_pull_alone() {
    let at = Contact {
        slip_angle: 0.4,
        ..contact(0.2)
    };
    let name = "skid-steer-lateral-slip";
    let [_, whole] = change(name, "default", 0.8, &at);
    let [plain, pull] = change(name, "pull-only", 0.8, &at);
    near(pull.drawbar_pull, whole.drawbar_pull);
    near(pull.resistive_torque, whole.resistive_torque);
    assert!(pull.drawbar_pull < plain.drawbar_pull && whole.lateral_force < -1.0);
    assert_eq!(pull.lateral_force.to_bits(), 0.0_f64.to_bits());

    let registry = Registry::builtin().with_forms();
    let effects = [
        registry
            .effect_form("lateral-bulldozing", "default")
            .unwrap(),
        registry.effect_form(name, "pull-only").unwrap(),
    ];
    let both = Law::new(registry.model("wong-reece").unwrap(), effects.to_vec()).unwrap();
    let ploughs = both
        .forces(&[soil(), vec![1.0, 0.8]].concat(), &at)
        .unwrap();
    assert!(ploughs.lateral_force < -1e-3);

    let mut sliding = at;
    sliding.hooks.lateral_slip = Some(0.3);
    let [own, more] = change(name, "pull-only", 0.8, &sliding);
    assert!(own.lateral_force < -1.0 && more.lateral_force < own.lateral_force);
}

/// Potyondy's two factors: one takes cohesion, the other the angle, and on soil that lacks the one the form does nothing.
#[test]
fn the_rim_loses_adhesion_or_friction() {
    let at = contact(0.3);
    let adhesion = touched("interface-friction", "adhesion", 0.4, &at).hooks;
    near(adhesion.cohesion, 0.6);
    assert_eq!(adhesion.friction.to_bits(), 1.0_f64.to_bits());
    let angle = touched("interface-friction", "skin-angle", 0.25, &at).hooks;
    assert_eq!(angle.cohesion.to_bits(), 1.0_f64.to_bits());
    near(angle.friction * soil()[4].tan(), (0.75 * soil()[4]).tan());
}

/// At 8 rad/s two-thirds power gives 4 times the torque at 1 rad/s; Stribeck's friction is 1.5 times Coulomb's near
/// standstill and Coulomb's at speed. Both oppose either direction alike.
#[test]
fn drivetrain_friction_by_speed() {
    let torque = |name: &str, form: &str, w: f64| {
        let registry = Registry::builtin().with_forms();
        let effect = registry.effect_form(name, form).unwrap();
        let zero = BodyLoads {
            force_x: 0.0,
            yaw_moment: 0.0,
            wheel_torque: [0.0; 4],
        };
        let motion = Motion {
            speed: 0.0,
            acceleration: 0.0,
            yaw_rate: 0.0,
            wheel_speed: [w; 4],
            wheel_torque: [0.0; 4],
            path: 0.0,
            time: 0.0,
        };
        effect
            .loads_at(&[2.0], &vehicle(), &motion, zero)
            .wheel_torque[0]
    };
    let viscous = |w| torque("drivetrain-viscous-friction", "lubricant", w);
    assert!((viscous(8.0) / viscous(1.0) - 4.0).abs() < 0.01);
    assert_eq!(viscous(0.0).to_bits(), 0.0_f64.to_bits());
    near(viscous(-8.0), -viscous(8.0));
    let dry = |w| torque("drivetrain-coulomb-friction", "stribeck", w);
    let coulomb = |w| torque("drivetrain-coulomb-friction", "default", w);
    near(dry(5.0), 2.0);
    assert!((dry(0.01) / coulomb(0.01) - 1.5).abs() < 1e-3);
    near(dry(-0.3), -dry(0.3));
}

/// The force of a cutting flank by quadrature over the sunken segment of the wheel, whose depth is R (cos θ - cos θ1).
#[test]
fn a_cutting_flank_by_quadrature() {
    for angle in [0.2, -0.2] {
        let at = Contact {
            slip_angle: angle,
            ..contact(0.3)
        };
        let [a, b] = change("lateral-bulldozing", "cutting-flank", 1.0, &at);
        let (p, z) = (soil(), a.sinkage.unwrap());
        let (c, phi, radius) = (p[3], p[4], at.radius);
        let x = std::f64::consts::FRAC_PI_4 - 0.5 * phi;
        let d1 = 1.0 / x.tan() + (x + phi).tan();
        let d2 = 1.0 / x.tan() + phi.tan() / x.tan().powi(2);
        let entry = (1.0 - z / radius).acos();
        let mut force = 0.0;
        for q in 0..2000 {
            let theta = entry * (f64::from(q) + 0.5) / 1000.0 - entry;
            let depth = radius * (theta.cos() - entry.cos());
            let stress = d1 * (c * depth + 0.5 * d2 * 15_000.0 * depth * depth);
            force += stress * radius * theta.cos() * entry / 1000.0;
        }
        let found = b.lateral_force - a.lateral_force;
        let expected = -force * (10.0 * angle.tan()).tanh();
        // The segment is a parabola to a few hundredths of its depth over the radius.
        assert!(
            (found / expected - 1.0).abs() < 0.3 * z / radius,
            "{found} {expected}"
        );
    }
}

/// N_q = 22.46 and N_c = 37.16 are Terzaghi's for 30°, in every table.
#[test]
fn bearing_capacity_has_the_factors_of_the_tables() {
    let registry = Registry::builtin().with_forms();
    let effect = registry
        .effect_form("bulldozing", "bearing-capacity")
        .unwrap();
    let law = registry.law("wong-reece").unwrap();
    let at = contact(0.3);
    let mut p = soil();
    p[4] = 30f64.to_radians();
    let push = |c: f64| {
        let mut p = p.clone();
        p[3] = c;
        let mut forces = law.forces(&soil(), &at).unwrap();
        forces.sinkage = Some(0.02);
        let before = forces.drawbar_pull;
        before
            - effect
                .after_at(&[1.0], &law.model().soil_at(&p, &at), &at, forces)
                .drawbar_pull
    };
    let per_cohesion = (push(2000.0) - push(1000.0)) / (1000.0 * 0.15 * 0.02 * 0.67);
    let (tan, cos) = (30f64.to_radians().tan(), 30f64.to_radians().cos());
    let n_c = per_cohesion / (cos * cos) + tan;
    assert!((n_c - 37.16).abs() < 0.01, "{n_c}");
    // Without cohesion: .5 γ z² b (2 N_γ/tan φ + 1) cos² φ with N_γ = 2 · 23.46 tan φ/(1 + .4 sin 120°).
    let n_weight = 2.0 * 23.456 * tan / (1.0 + 0.4 * 120f64.to_radians().sin());
    let k = (2.0 * n_weight / tan + 1.0) * cos * cos;
    let expected = 0.5 * 15e3 * 4e-4 * 0.15 * k;
    assert!((push(0.0) / expected - 1.0).abs() < 1e-4);
}

/// A grouser as tall as half the width doubles cohesion; tan φ gains .64 (h/b) acot(h/b).
#[test]
fn side_walls_by_the_published_factors() {
    let at = contact(0.3);
    let hooks = touched("grousers", "side-walls", 0.075, &at).hooks;
    near(hooks.cohesion, 2.0);
    near(hooks.friction, 1.0 + 0.64 * 0.5 * 2f64.atan());
}

/// Passive pressure by hand: φ = 0 has N_p = 1, φ = 30° has 3; the surcharge is the load over the contact's length.
#[test]
fn a_passive_lug_by_hand() {
    let at = contact(0.9);
    let registry = Registry::builtin().with_forms();
    let effect = registry.effect_form("grousers", "passive-lug").unwrap();
    let law = registry.law("wong-reece").unwrap();
    let mut forces = law.forces(&soil(), &at).unwrap();
    forces.sinkage = Some(0.02);
    let p = 245.25 / (0.15 * (2.0 * 0.254 * 0.02 + 1e-4f64).sqrt());
    for (phi, n) in [(0f64, 1.0), (30.0, 3.0)] {
        let mut q = soil();
        (q[3], q[4]) = (2000.0, phi.to_radians());
        let after = effect.after_at(&[0.01], &law.model().soil_at(&q, &at), &at, forces);
        let force = 0.15 * 0.01 * (n * (15e3 * 0.01 / 2.0 + p) + 2.0 * 2000.0 * n.sqrt());
        let found = after.drawbar_pull - forces.drawbar_pull;
        near(found / 9f64.tanh(), force);
        let torque = after.resistive_torque - forces.resistive_torque;
        near(torque / found, 0.254 + 0.005);
    }
}

/// Right over left is e^e in cohesion and e^(e/3) in tan φ, and stiffness is the same.
#[test]
fn sides_of_another_strength() {
    let by = |side: f64| {
        let at = Contact {
            side,
            ..contact(0.2)
        };
        touched("lateral-contrast", "strength", 0.6, &at).hooks
    };
    let (right, left) = (by(1.0), by(-1.0));
    near(right.cohesion / left.cohesion, 0.6f64.exp());
    near(right.friction / left.friction, 0.2f64.exp());
    assert!(right.stiffness == 1.0 && left.stiffness == 1.0);
}

/// Both count travel at zero slip; at slip the rim is faster, and so stiffer ground is what it meets.
#[test]
fn rates_follow_the_rim_and_the_slide() {
    let at = contact(0.0);
    let by = |form, slip| touched("rate-stiffening", form, 0.2, &contact(slip)).hooks;
    near(
        by("rim-speed", 0.0).stiffness,
        touched("rate-stiffening", "default", 0.2, &at)
            .hooks
            .stiffness,
    );
    near(by("rim-speed", 0.5).stiffness, 0.6f64.powf(0.2));
    near(by("shear-rate", 0.5).cohesion, 0.35f64.powf(0.2));
    near(by("shear-rate", 0.0).friction, 0.05f64.powf(0.2));
}

/// Where a form puts its change is what tells it from the default: sinkage that stays, torque that moves.
#[test]
fn forms_differ_in_what_they_move() {
    let at = contact(0.3);
    let moved = |name, form, e| {
        let [a, b] = change(name, form, e, &at);
        [
            (b.drawbar_pull - a.drawbar_pull) / 245.25,
            (b.resistive_torque - a.resistive_torque) / (245.25 * 0.254),
            (b.sinkage.unwrap() - a.sinkage.unwrap()) / a.sinkage.unwrap(),
        ]
        .map(|d| if d.abs() < 1e-12 { 0.0 } else { d.signum() })
    };
    // Earlier passes: stiffer soil sinks less; a rut only saves work; packed soil pulls more.
    assert_eq!(moved("multipass", "default", 0.5)[2], -1.0);
    assert_eq!(moved("multipass", "rut", 0.5), [1.0, 0.0, 0.0]);
    assert_eq!(moved("multipass", "packed-strength", 0.5)[..2], [1.0, 1.0]);
    // Rebound: stresses behind the bottom, or only energy.
    assert_eq!(
        moved("rear-contact", "energy-return", 0.3),
        [1.0, 0.0, -1.0]
    );
    assert_eq!(moved("rear-contact", "elastic-unloading", 0.3)[2], -1.0);
    // A pile that rubs brakes the wheel too.
    assert_eq!(moved("bulldozing", "default", 1.0), [-1.0, 0.0, 0.0]);
    assert_eq!(moved("bulldozing", "rubbing-pile", 1.0), [-1.0, 1.0, 0.0]);
    // Strength drifts without the stiffness.
    assert!(
        touched("terrain-drift", "strength", 0.4, &at)
            .hooks
            .stiffness
            == 1.0
    );
}

/// The larger circle: at a Bekker sinkage of 20 mm its radius is R (sqrt(1 + e²) + e)².
#[test]
fn the_substitute_circle_at_its_reference_depth() {
    let at = Contact {
        normal_load: load_at(0.02),
        ..contact(0.2)
    };
    let factor = touched("wheel-compliance", "substitute-circle", 0.3, &at)
        .hooks
        .contact_radius;
    near(factor, (1.09f64.sqrt() + 0.3).powi(2));
    let ratio = touched("rear-contact", "elastic-unloading", 0.3, &at)
        .hooks
        .exit_ratio;
    near(ratio, 0.3);
}

/// A load that sinks a wheel at rest by so much, by Bekker.
fn load_at(sinkage: f64) -> f64 {
    let p = soil();
    let (k, n) = (p[0] / 0.15 + p[1], p[2]);
    sinkage.powf(n + 0.5) * 0.15 * (3.0 - n) * k * 0.508f64.sqrt() / 3.0
}

/// A spring: the deflection f of the larger circle, (sqrt(1 + f/z) + sqrt(f/z))² = exp(2 arsinh sqrt(f/z)), is in proportion to
/// the load, e² times 20 mm at 250 N.
#[test]
fn a_springy_wheel_deflects_with_its_load() {
    for sinkage in [0.01, 0.02, 0.04] {
        let at = Contact {
            normal_load: load_at(sinkage),
            ..contact(0.2)
        };
        let hooks = touched("wheel-compliance", "linear-spring", 0.3, &at).hooks;
        let deflection = (hooks.contact_radius.ln() / 2.0).sinh().powi(2) * sinkage;
        near(deflection, 0.09 * 0.02 * at.normal_load / 250.0);
    }
}

/// A strip of half the contact's length on a stratum of depth H: 1 + 3.5 B/H, B = sqrt(2 R z_0)/2; at 20 mm and H = 1 m.
#[test]
fn hard_ground_below_is_felt_with_the_length_of_the_contact() {
    let at = Contact {
        normal_load: load_at(0.02),
        ..contact(0.2)
    };
    let hooks = touched("layered-soil", "pressure-bulb", 1.0, &at).hooks;
    near(
        hooks.stiffness,
        1.0 + 3.5 * (2.0f64 * 0.254 * 0.02).sqrt() / 2.0,
    );
    let heavier = Contact {
        normal_load: load_at(0.08),
        ..at
    };
    let more = touched("layered-soil", "pressure-bulb", 1.0, &heavier).hooks;
    near((more.stiffness - 1.0) / (hooks.stiffness - 1.0), 2.0);
}

/// The default's layer nearer the surface: the secant stiffness k z_h^(n - 1) of the soil above it, at its own depth.
#[test]
fn a_shallow_layer_is_the_default_nearer_the_surface() {
    let p = soil();
    let (k, n) = (p[0] / 0.15 + p[1], p[2]);
    for (form, depth) in [("default", 0.03), ("shallow", 0.01f64)] {
        let hooks = touched("layered-soil", form, 2.0, &contact(0.2)).hooks;
        near(hooks.layer_depth, depth);
        near(hooks.layer_stiffness / (2.0 * k * depth.powf(n - 1.0)), 1.0);
    }
}

/// A law has room for one layer, and says so: the second would move the first.
#[test]
fn two_layers_do_not_stand_in_one_law() {
    let registry = Registry::builtin().with_forms();
    let layer = |form| registry.effect_form("layered-soil", form).unwrap();
    let model = || registry.model("wong-reece").unwrap();
    let error = Law::new(model(), vec![layer("default"), layer("shallow")]).unwrap_err();
    assert!(matches!(error, ModelError::HookTwice { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("layered-soil/default"), "{text}");
    assert!(text.contains("layered-soil/shallow"), "{text}");
    assert!(text.contains("layer"), "{text}");
    // The third form acts on the stiffness and needs no room.
    Law::new(model(), vec![layer("default"), layer("pressure-bulb")]).unwrap();
}

/// The hump x e^(1 - x) is 1 at x = 1 and nowhere more: a mean displacement |s| l/2 of K.
#[test]
fn strength_peaks_where_the_contact_is_sheared_by_the_modulus() {
    let law = Registry::builtin().law("wong-reece").unwrap();
    let p = soil();
    let place = law.params().iter().position(|p| p.symbol == "K").unwrap();
    let length = (2.0f64 * 0.254 * 0.02).sqrt();
    let gain = |slip: f64| {
        let at = Contact {
            normal_load: load_at(0.02),
            ..contact(slip)
        };
        let hooks = touched("shear-hump", "peak-strength", 0.4, &at).hooks;
        near(hooks.cohesion, hooks.friction);
        hooks.friction
    };
    let peak = 2.0 * p[place] / length;
    near(gain(0.0), 1.0);
    near(gain(peak), 1.4);
    assert!(gain(0.8 * peak) < 1.4 && gain((1.2 * peak).min(1.0)) < 1.4);
}

/// Soil that is swept: the default's pressure, all of it only for a flank that moves straight sideways.
#[test]
fn a_flank_meets_what_it_sweeps() {
    let at = |angle: f64| Contact {
        slip_angle: angle,
        ..contact(0.2)
    };
    let side = |form, angle: f64| {
        let [a, b] = change("lateral-bulldozing", form, 1.0, &at(angle));
        b.lateral_force - a.lateral_force
    };
    // From a tangent of .1 on the default has all of it.
    let whole = side("default", 0.5);
    assert!(whole < 0.0);
    for angle in [0.05, 0.2, 0.5f64] {
        near(side("swept-pressure", angle) / whole, angle.sin());
        near(side("swept-pressure", -angle) / whole, -angle.sin());
    }
}

/// A hyperbola is the default's square at small torque and a scale at large; a knee says nothing below it.
#[test]
fn droops_of_a_motor() {
    let registry = Registry::builtin().with_forms();
    let report = |form, torque: f64| {
        let effect = registry.effect_form("torque-droop", form).unwrap();
        effect.report_at(&[0.2], Channel::WheelTorque, torque, 0.0)
    };
    let share = |form, torque: f64| (report(form, torque) / torque - 1.0) / 0.2;
    assert!((share("hyperbola", 3.0) / (0.5 * share("default", 3.0)) - 1.0).abs() < 1e-3);
    assert!((share("hyperbola", 6000.0) - 99.0).abs() < 0.01);
    near(report("knee", 9.0), 9.0);
    near(share("knee", 60.0), 0.5);
    near(report("knee", -60.0), -66.0);
}

/// Forms of one name stand side by side in one law, each leaving the others alone at zero.
#[test]
fn forms_of_one_name_share_a_law() {
    let registry = Registry::builtin().with_forms();
    let all: Vec<_> = registry
        .effects()
        .iter()
        .filter(|e| e.name() == "slip-sinkage")
        .map(Arc::clone)
        .collect();
    assert_eq!(all.len(), 3);
    let law = Law::new(registry.model("wong-reece").unwrap(), all).unwrap();
    let at = contact(0.3);
    let plain = registry
        .law("wong-reece")
        .unwrap()
        .forces(&soil(), &at)
        .unwrap();
    let (f, jac) = law.jacobian(&[soil(), vec![0.0; 3]].concat(), &at).unwrap();
    assert_eq!(f.drawbar_pull.to_bits(), plain.drawbar_pull.to_bits());
    for k in 8..11 {
        assert!(
            jac[(2, k)] > 0.0,
            "every form sinks deeper: {}",
            jac[(2, k)]
        );
    }
}

/// An effect that acts by the path, the side, earlier passes or the slip angle leaves a wheel on its own as it is, and no other
/// effect on contact or forces does: what it declares is what it reads.
#[test]
fn what_acts_on_a_wheel_alone_is_what_reads_nothing_else() {
    let registry = Registry::builtin().with_forms();
    let model = registry.model("wong-reece").unwrap();
    let (mut alone, mut by_circumstance) = (0, 0);
    for effect in registry.effects() {
        let on_the_wheel = |t: &Touch| matches!(t, Touch::Contact | Touch::Forces);
        if !effect.touches().iter().any(on_the_wheel) {
            assert!(effect.reads().is_empty(), "{}", effect.name());
            continue;
        }
        let law = Law::new(model.clone(), vec![Arc::clone(effect)]).unwrap();
        let changes = |at: &Contact<f64>| {
            let numbers = |share: f64| {
                let e = effect
                    .params()
                    .iter()
                    .map(|p| (share * p.prior_sd).clamp(p.min, p.max));
                let f = law.forces(&soil().into_iter().chain(e).collect::<Vec<_>>(), at);
                f.map(|f| {
                    [
                        f.drawbar_pull,
                        f.resistive_torque,
                        f.lateral_force,
                        f.sinkage.unwrap_or(0.0),
                    ]
                })
            };
            let plain = numbers(0.0).unwrap();
            [1.0, 3.0].into_iter().any(|share| {
                numbers(share).is_ok_and(|f| {
                    let pairs = f.iter().zip(&plain);
                    let mut apart = pairs.map(|(a, b)| (a - b).abs() / (b.abs() + 1.0));
                    apart.any(|d| d > 1e-9)
                })
            })
        };
        // Deep enough for a layer to be reached.
        let slips = [-0.2, 0.1, 0.4, 0.9];
        let wheels: Vec<_> = slips
            .into_iter()
            .flat_map(|s| [245.25, 600.0].map(|w| Contact::new(s, w, 0.254, 0.15)))
            .collect();
        let label = format!("{} {}", effect.name(), effect.form());
        let acts = wheels.iter().any(&changes);
        assert_eq!(acts, effect.reads().is_empty(), "{label}");
        let moving = slips.map(|s| Contact {
            slip_angle: 0.1,
            ..contact(s)
        });
        assert!(acts || moving.iter().any(changes), "{label}");
        if acts {
            alone += 1;
        } else {
            by_circumstance += 1;
        }
    }
    assert!(
        alone > 10 && by_circumstance >= 9,
        "{alone} {by_circumstance}"
    );
}

/// Two magnitudes of one form would be two names for their sum.
#[test]
fn one_form_of_an_effect_stands_in_a_law_once() {
    let registry = Registry::builtin().with_forms();
    let twice = |e: &ModelError| matches!(e, ModelError::EffectTwice { effect } if effect == "slip-sinkage");
    for name in [
        "wong-reece+slip-sinkage+slip-sinkage",
        "wong-reece+slip-sinkage+multipass+slip-sinkage",
    ] {
        let error = registry.law(name).unwrap_err();
        assert!(twice(&error), "{name}: {error}");
    }
    let law = registry.law("wong-reece+slip-sinkage").unwrap();
    let again = registry.effect("slip-sinkage").unwrap();
    assert!(twice(&law.with_effects([again]).unwrap_err()));
    let other = registry.effect_form("slip-sinkage", "excavation").unwrap();
    assert!(law.with_effects([other]).is_ok());
}
