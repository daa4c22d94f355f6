//! What each effect does, against the table of effects: equation and direction of every row.

#![allow(clippy::unwrap_used, clippy::panic)]

use terra_model::{
    BodyLoads, Channel, Contact, ForceLaw, Motion, Registry, Soil, Vehicle, WheelForces, catalogue,
};

fn soil_of(id: &str) -> Vec<f64> {
    let law = Registry::builtin().law("wong-reece").unwrap();
    catalogue::find(id)
        .unwrap()
        .parameters(law.model())
        .unwrap()
}

/// A wheel in the rut of another, on the right, some way along, in a left turn.
fn contact(slip: f64, load: f64) -> Contact<f64> {
    Contact {
        speed: 0.3,
        slip_angle: 0.1,
        path: 4.0,
        earlier_passes: 1.0,
        side: 1.0,
        wheelbase: 0.6,
        ..Contact::new(slip, load, 0.254, 0.15)
    }
}

fn with(effect: &str, e: f64, id: &str, at: &Contact<f64>) -> WheelForces<f64> {
    let law = Registry::builtin()
        .law(&format!("wong-reece+{effect}"))
        .unwrap();
    let mut p = soil_of(id);
    p.push(e);
    law.forces(&p, at).unwrap()
}

/// Signs of the changes of pull, torque and sinkage; 0 for none at all.
fn signs(effect: &str, e: f64, id: &str, at: &Contact<f64>) -> [i32; 3] {
    let (f, g) = (with(effect, 0.0, id, at), with(effect, e, id, at));
    let sign = |a: f64, b: f64| {
        if a == b {
            0
        } else if b > a {
            1
        } else {
            -1
        }
    };
    [
        sign(f.drawbar_pull, g.drawbar_pull),
        sign(f.resistive_torque, g.resistive_torque),
        sign(f.sinkage.unwrap(), g.sinkage.unwrap()),
    ]
}

#[test]
fn directions_of_the_table() {
    let at = contact(0.4, 245.25);
    // What the table does not say is left open.
    for (effect, e, soil, [pull, torque, sinkage]) in [
        (
            "slip-sinkage",
            0.4,
            "dry_sand",
            [Some(-1), Some(1), Some(1)],
        ),
        (
            "grousers",
            0.015,
            "upland_sandy_loam",
            [Some(1), Some(1), None],
        ),
        ("bulldozing", 1.0, "dry_sand", [Some(-1), Some(0), Some(0)]),
        (
            "rear-contact",
            0.35,
            "lean_clay_22",
            [Some(1), None, Some(-1)],
        ),
        (
            "interface-friction",
            0.3,
            "upland_sandy_loam",
            [Some(-1), Some(-1), None],
        ),
        ("wheel-compliance", 0.3, "dry_sand", [None, None, Some(-1)]),
        (
            "skid-steer-lateral-slip",
            0.5,
            "dry_sand",
            [Some(-1), None, None],
        ),
        (
            "lateral-bulldozing",
            1.5,
            "dry_sand",
            [Some(0), Some(0), Some(0)],
        ),
    ] {
        let found = signs(effect, e, soil, &at);
        let agrees = [pull, torque, sinkage]
            .iter()
            .zip(found)
            .all(|(e, f)| e.is_none_or(|e| e == f));
        assert!(agrees, "{effect}: {found:?}");
    }
    // A rut is firmer: the wheel sinks less, and at low slip needs less torque. At high slip on sand the smaller K and the
    // larger c win, and the torque rises.
    let [_, torque, sinkage] = signs("multipass", 0.8, "dry_sand", &contact(0.05, 245.25));
    assert_eq!((torque, sinkage), (-1, -1));
    assert_eq!(signs("multipass", 0.8, "dry_sand", &at)[1..], [1, -1]);
    assert_eq!(
        signs(
            "multipass",
            0.8,
            "dry_sand",
            &Contact {
                earlier_passes: 0.0,
                ..at
            }
        ),
        [0, 0, 0]
    );
}

/// A layer at 30 mm is felt only by a wheel that reaches it.
#[test]
fn a_layer_is_felt_where_the_load_reaches_it() {
    let light = contact(0.1, 150.0);
    assert!(
        with("layered-soil", 0.0, "dry_sand", &light)
            .sinkage
            .unwrap()
            < 0.03
    );
    assert_eq!(signs("layered-soil", 2.0, "dry_sand", &light), [0, 0, 0]);
    let heavy = contact(0.1, 600.0);
    assert!(
        with("layered-soil", 0.0, "dry_sand", &heavy)
            .sinkage
            .unwrap()
            > 0.04
    );
    assert_eq!(signs("layered-soil", 2.0, "dry_sand", &heavy)[2], -1);
}

/// The hump lifts the shear stress most where j is near K, and is gone where j is many K.
#[test]
fn a_hump_shows_at_low_slip() {
    let gain = |slip| {
        let at = contact(slip, 245.25);
        let torque = |e| with("shear-hump", e, "upland_sandy_loam", &at).resistive_torque;
        torque(0.35) / torque(0.0) - 1.0
    };
    assert!(
        gain(0.2) > 0.05 && gain(0.2) > 3.0 * gain(1.0),
        "{} {}",
        gain(0.2),
        gain(1.0)
    );
}

/// Sideways slip pushes back, as much as the effect and the angle say, and turns the strength without adding any.
#[test]
fn sideways_forces_push_back() {
    for effect in ["skid-steer-lateral-slip", "lateral-bulldozing"] {
        let at = contact(0.3, 245.25);
        let left = with(effect, 0.6, "dry_sand", &at).lateral_force;
        let right = with(
            effect,
            0.6,
            "dry_sand",
            &Contact {
                slip_angle: -0.1,
                ..at
            },
        )
        .lateral_force;
        assert!(
            left < 0.0 && (left + right).abs() < 1e-12 * right,
            "{effect}: {left} {right}"
        );
        assert_eq!(
            with(
                effect,
                0.6,
                "dry_sand",
                &Contact {
                    slip_angle: 0.0,
                    ..at
                }
            )
            .lateral_force,
            0.0
        );
    }
    // .12 e L (γ z² Np/2 + 2 c z sqrt(Np)), saturated since tan .2 > .1.
    let at = Contact {
        slip_angle: 0.2,
        ..contact(0.3, 245.25)
    };
    let f = with("lateral-bulldozing", 1.5, "dry_sand", &at);
    let (z, np) = (f.sinkage.unwrap(), (59.0_f64.to_radians()).tan().powi(2));
    let push = 15_000.0 * z * z * np / 2.0 + 2.0 * 1040.0 * z * np.sqrt();
    assert!((f.lateral_force + 0.12 * 1.5 * 0.6 * push).abs() < 1e-12 * push);
}

/// Fb = b (γ z² Np/2 + 2 c z sqrt(Np)) off the pull, and named.
#[test]
fn bulldozing_by_hand() {
    let at = contact(0.3, 245.25);
    let (f, g) = (
        with("bulldozing", 0.0, "dry_sand", &at),
        with("bulldozing", 0.7, "dry_sand", &at),
    );
    let (z, np) = (f.sinkage.unwrap(), (59.0_f64.to_radians()).tan().powi(2));
    let push = 0.15 * (15_000.0 * z * z * np / 2.0 + 2.0 * 1040.0 * z * np.sqrt());
    assert!((f.drawbar_pull - g.drawbar_pull - 0.7 * push).abs() < 1e-12 * push);
    assert!((g.parts.bulldozing_resistance - 0.7 * push).abs() < 1e-12 * push);
}

/// Effects that are a change of soil: the same forces as that soil has.
#[test]
fn soil_effects_are_changed_soils() {
    let nominal = Registry::builtin().law("wong-reece").unwrap();
    let at = contact(0.4, 245.25);
    let passed = 1.0 - (-1.0_f64).exp();
    let index = |k: &[usize], factor: &[f64]| {
        let mut p = soil_of("dry_sand");
        k.iter().zip(factor).for_each(|(&k, f)| p[k] *= f);
        p
    };
    let (k, c, shear) = ([0, 1], 3, 5);
    let stiffer = |f: f64| index(&k, &[f, f]);
    let (drift, m) = ((0.4_f64 * 4.0 / 8.0).exp(), 0.8 * passed);
    let mut exponent = soil_of("dry_sand");
    exponent[2] += 0.3 * 0.4;
    for (effect, e, p) in [
        ("slip-sinkage", 0.3, exponent),
        ("lateral-contrast", 0.5, stiffer(0.25_f64.exp())),
        ("rate-stiffening", 0.2, stiffer(0.3_f64.powf(0.2))),
        (
            "terrain-drift",
            0.4,
            index(&[0, 1, c], &[drift, drift, drift.sqrt()]),
        ),
        (
            "multipass",
            0.8,
            index(
                &[0, 1, shear, c],
                &[1.0 + m, 1.0 + m, 1.0 / (1.0 + 0.5 * m), 1.0 + 0.3 * m],
            ),
        ),
    ] {
        let (f, g) = (
            with(effect, e, "dry_sand", &at),
            nominal.forces(&p, &at).unwrap(),
        );
        assert!(
            (f.drawbar_pull - g.drawbar_pull).abs() < 1e-10,
            "{effect}: {} {}",
            f.drawbar_pull,
            g.drawbar_pull
        );
        assert!(
            (f.resistive_torque - g.resistive_torque).abs() < 1e-10,
            "{effect}"
        );
    }
}

/// A wheel that is larger than the file says: the same rim and travel speed, slip by its definition.
#[test]
fn a_wrong_radius_changes_slip_by_its_definition() {
    let (effect, soil) = (
        Registry::builtin().effect("wheel-radius-error").unwrap(),
        Soil::unknown(),
    );
    for (rim, travel) in [
        (0.3, 0.2),
        (0.2, 0.3),
        (0.3, 0.295),
        (0.295, 0.3),
        (0.3, 0.0),
        (0.0, 0.3),
    ] {
        for e in [-0.04, 0.0, 0.04] {
            let before = contact(terra_model::library_slip(rim, travel), 245.25);
            let after = effect.before_at(&[e], &soil, before);
            let expected = terra_model::library_slip(rim * (1.0 + e), travel);
            assert!(
                (after.slip - expected).abs() < 1e-15,
                "{rim} {travel} {e}: {} {expected}",
                after.slip
            );
            assert!((after.radius - 0.254 * (1.0 + e)).abs() < 1e-15);
        }
    }
}

#[test]
fn readings_by_hand() {
    for (name, e, channel, truth, rate, expected) in [
        ("torque-scale", 0.25, Channel::WheelTorque, 10.0, 0.0, 8.0),
        ("torque-bias", 1.5, Channel::WheelTorque, 10.0, 0.0, 11.5),
        ("torque-droop", 0.2, Channel::WheelTorque, 30.0, 0.0, 31.5),
        (
            "ground-speed-scale",
            0.05,
            Channel::GroundSpeed,
            0.4,
            0.0,
            0.42,
        ),
        (
            "ground-speed-bias",
            0.05,
            Channel::GroundSpeed,
            0.4,
            0.0,
            0.45,
        ),
        (
            "ground-speed-delay",
            0.1,
            Channel::GroundSpeed,
            0.4,
            0.5,
            0.35,
        ),
        ("accel-bias", 0.15, Channel::AccelX, 0.2, 0.0, 0.35),
        ("yaw-rate-bias", 0.01, Channel::YawRate, 0.2, 0.0, 0.21),
        ("drawbar-gain", 0.05, Channel::DrawbarPull, 20.0, 0.0, 21.0),
        ("drawbar-bias", 2.0, Channel::DrawbarPull, 20.0, 0.0, 22.0),
        ("sinkage-bias", 0.002, Channel::Sinkage, 0.02, 0.0, 0.022),
    ] {
        let effect = Registry::builtin().effect(name).unwrap();
        let found: f64 = effect.report_at(&[e], channel, truth, rate);
        assert!((found - expected).abs() < 1e-12, "{name}: {found}");
        let other = if channel == Channel::YawRate {
            Channel::AccelX
        } else {
            Channel::YawRate
        };
        assert_eq!(effect.report_at(&[e], other, truth, rate), truth, "{name}");
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

#[test]
fn vehicles_and_loads_by_hand() {
    let registry = Registry::builtin();
    let changed = |name: &str, e: f64| registry.effect(name).unwrap().vehicle_at(&[e], vehicle());
    assert!((changed("mass-error", 0.12).mass - 112.0).abs() < 1e-12);
    assert!((changed("track-width-error", 0.05).track - 0.63).abs() < 1e-12);
    assert!((changed("slope", 0.03).pitch - 0.03).abs() < 1e-15);
    // Load of the front axle m g (1/2 + e) = m g (distance of the rear axle)/L.
    let v = changed("cg-offset", 0.08);
    assert!(((v.wheelbase - v.cg_to_front_axle) / v.wheelbase - 0.58).abs() < 1e-12);

    let motion = Motion {
        speed: -2.0,
        acceleration: 0.0,
        yaw_rate: 0.0,
        wheel_speed: [5.0, -5.0, 0.0, 5.0],
        wheel_torque: [10.0; 4],
        path: 0.0,
        time: 0.0,
    };
    let loads = |name: &str, e: f64| -> BodyLoads<f64> {
        registry
            .effect(name)
            .unwrap()
            .loads_at(&[e], &vehicle(), &motion, BodyLoads::none())
    };
    assert!((loads("tow-load", 40.0).force_x - 40.0).abs() < 1e-12);
    assert!((loads("aero-drag", 8.0).force_x - 32.0).abs() < 1e-12);
    let [fl, fr, rl, _] = loads("drivetrain-coulomb-friction", 2.0).wheel_torque;
    assert!((fl - 2.0).abs() < 1e-12 && (fr + 2.0).abs() < 1e-12 && rl == 0.0);
    assert_eq!(
        loads("drivetrain-viscous-friction", 0.8).wheel_torque,
        [4.0, -4.0, 0.0, 4.0]
    );
}
