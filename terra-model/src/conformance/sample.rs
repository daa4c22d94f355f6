//! Where models and effects are tried: soils of the literature where a model knows them, points of the declared
//! domain, contacts, vehicles. No randomness: sequences of irrational steps fill a box evenly.

use crate::catalogue;
use crate::contact::{Contact, Hook, Hooks};
use crate::effect::Circumstance;
use crate::forces::WheelForces;
use crate::model::{AnyModel, Soil};
use crate::param::{Param, Scale};
use crate::real::Real;
use crate::vehicle::{BodyLoads, Motion, Vehicle};

/// `count` points of the declared domain. An unbounded side ends at ten prior deviations, a logarithmic one that begins
/// at zero nine decades below its end.
pub(super) fn domain(params: &[Param], count: usize) -> Vec<Vec<f64>> {
    const IRRATIONAL: [f64; 8] = [
        0.414_213_562_373_095_1,
        0.732_050_807_568_877_2,
        0.236_067_977_499_789_8,
        0.645_751_311_064_590_6,
        0.316_624_790_355_399_8,
        0.605_551_275_463_989_3,
        0.123_105_625_617_660_55,
        0.358_898_943_540_673_55,
    ];
    let point = |k: usize| {
        params
            .iter()
            .zip(IRRATIONAL.iter().cycle())
            .enumerate()
            .map(move |(place, (p, step))| {
                let share = (0.5 + (k + place) as f64 * step).fract();
                let end = |x: f64, sign: f64| {
                    if x.is_finite() {
                        x
                    } else {
                        sign * 10.0 * p.prior_sd
                    }
                };
                let (low, high) = (end(p.min, -1.0), end(p.max, 1.0));
                match p.scale {
                    Scale::Linear => low + (high - low) * share,
                    Scale::Log => {
                        let low = low.max(high * 1e-9).ln();
                        (low + (high.ln() - low) * share).exp()
                    }
                }
            })
    };
    (1..=count).map(|k| point(k).collect()).collect()
}

/// The soils of the literature in this model's parameters, where it has them all.
pub(super) fn literature(model: &dyn AnyModel) -> Vec<Vec<f64>> {
    catalogue::terrains()
        .iter()
        .filter_map(|t| t.parameters(model).ok())
        .collect()
}

/// A contact with nothing at rest.
pub(super) fn contact(slip: f64, normal_load: f64) -> Contact<f64> {
    Contact {
        speed: 0.4,
        wheel_speed: 1.7,
        slip_angle: 0.08,
        yaw_rate: 0.2,
        path: 3.0,
        earlier_passes: 1.0,
        side: 1.0,
        ahead: 0.3,
        wheelbase: 0.6,
        time: 2.0,
        ..Contact::new(slip, normal_load, 0.254, 0.15)
    }
}

/// The same wheel, slip and load where nothing else is told but what is beside them.
pub(super) fn bare(at: &Contact<f64>, beside: &[Circumstance]) -> Contact<f64> {
    let mut bare = Contact::new(at.slip, at.normal_load, at.radius, at.width);
    for circumstance in beside {
        match circumstance {
            Circumstance::SlipAngle => bare.slip_angle = at.slip_angle,
            Circumstance::Path => bare.path = at.path,
            Circumstance::EarlierPasses => bare.earlier_passes = at.earlier_passes,
            Circumstance::Side => bare.side = at.side,
            Circumstance::Speed => (bare.speed, bare.wheel_speed) = (at.speed, at.wheel_speed),
        }
    }
    bare
}

pub(super) const SLIPS: [f64; 13] = [
    -1.0, -0.7, -0.3, -0.1, -0.02, 0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.95, 1.0,
];

/// Slips from braking to spinning in place, at loads of a rig and of a light and a heavy vehicle.
pub(super) fn contacts() -> Vec<Contact<f64>> {
    [40.0, 245.25, 2452.5]
        .into_iter()
        .flat_map(|load| SLIPS.into_iter().map(move |slip| contact(slip, load)))
        .collect()
}

pub(super) fn soil() -> Soil<f64> {
    Soil {
        cohesion: Some(1040.0),
        friction_angle: Some(0.49),
        stiffness: Some(1.5e6),
        sinkage_exponent: Some(1.1),
        shear_modulus: Some(0.025),
    }
}

pub(super) fn vehicle() -> Vehicle<f64> {
    Vehicle {
        mass: 100.0,
        yaw_inertia: 10.0,
        track: 0.6,
        wheelbase: 0.6,
        cg_to_front_axle: 0.28,
        cg_height: 0.22,
        yaw_damping: 8.0,
        wheel_radius: 0.254,
        wheel_width: 0.15,
        wheel_inertia: 0.25,
        wheel_damping: 0.1,
        pitch: 0.03,
    }
}

pub(super) fn motion() -> Motion<f64> {
    Motion {
        speed: 0.4,
        acceleration: 0.3,
        yaw_rate: 0.2,
        wheel_speed: [1.7, 1.9, 1.6, 2.0],
        wheel_torque: [12.0, 14.0, 11.0, 15.0],
        path: 3.0,
        time: 2.0,
    }
}

pub(super) fn lift_soil<T: Real>(s: &Soil<f64>) -> Soil<T> {
    Soil {
        cohesion: s.cohesion.map(T::from),
        friction_angle: s.friction_angle.map(T::from),
        stiffness: s.stiffness.map(T::from),
        sinkage_exponent: s.sinkage_exponent.map(T::from),
        shear_modulus: s.shear_modulus.map(T::from),
    }
}

pub(super) fn lift_vehicle<T: Real>(v: &Vehicle<f64>) -> Vehicle<T> {
    Vehicle {
        mass: T::from(v.mass),
        yaw_inertia: T::from(v.yaw_inertia),
        track: T::from(v.track),
        wheelbase: T::from(v.wheelbase),
        cg_to_front_axle: T::from(v.cg_to_front_axle),
        cg_height: T::from(v.cg_height),
        yaw_damping: T::from(v.yaw_damping),
        wheel_radius: T::from(v.wheel_radius),
        wheel_width: T::from(v.wheel_width),
        wheel_inertia: T::from(v.wheel_inertia),
        wheel_damping: T::from(v.wheel_damping),
        pitch: T::from(v.pitch),
    }
}

pub(super) fn lift_motion<T: Real>(m: &Motion<f64>) -> Motion<T> {
    Motion {
        speed: T::from(m.speed),
        acceleration: T::from(m.acceleration),
        yaw_rate: T::from(m.yaw_rate),
        wheel_speed: m.wheel_speed.map(T::from),
        wheel_torque: m.wheel_torque.map(T::from),
        path: T::from(m.path),
        time: T::from(m.time),
    }
}

/// Each hook with its value; a layer without stiffness and a sideways slip of zero count as none.
pub(super) fn hooks<T: Real>(h: &Hooks<T>) -> [(Hook, T); 11] {
    [
        (Hook::Stiffness, h.stiffness),
        (Hook::Cohesion, h.cohesion),
        (Hook::Friction, h.friction),
        (Hook::ShearModulus, h.shear_modulus),
        (Hook::SinkageExponent, h.sinkage_exponent),
        (Hook::ContactRadius, h.contact_radius),
        (Hook::ExitRatio, h.exit_ratio),
        (Hook::ShearHump, h.shear_hump),
        (Hook::LugHeight, h.lug_height),
        (Hook::Layer, h.layer_depth * h.layer_stiffness),
        (Hook::LateralSlip, h.lateral_slip.unwrap_or_else(T::zero)),
    ]
}

/// All numbers of a contact.
pub(super) fn contact_values<T: Real>(c: &Contact<T>) -> Vec<T> {
    let mut out = vec![
        c.slip,
        c.normal_load,
        c.radius,
        c.width,
        c.speed,
        c.wheel_speed,
        c.slip_angle,
        c.yaw_rate,
        c.path,
        c.earlier_passes,
        c.side,
        c.ahead,
        c.wheelbase,
        c.time,
    ];
    out.extend(hooks(&c.hooks).map(|(_, value)| value));
    out
}

/// All numbers of the forces on a wheel.
pub(super) fn force_values<T: Real>(f: &WheelForces<T>) -> Vec<T> {
    let p = &f.parts;
    let mut out = vec![
        f.drawbar_pull,
        f.resistive_torque,
        f.lateral_force,
        p.thrust,
        p.lug_thrust,
        p.compaction_resistance,
        p.bulldozing_resistance,
        p.other,
    ];
    out.extend(f.sinkage);
    out.extend(
        f.angles
            .iter()
            .flat_map(|a| [a.entry, a.exit, a.max_stress]),
    );
    out
}

/// All numbers of a vehicle.
pub(super) fn vehicle_values<T: Real>(v: &Vehicle<T>) -> Vec<T> {
    vec![
        v.mass,
        v.yaw_inertia,
        v.track,
        v.wheelbase,
        v.cg_to_front_axle,
        v.cg_height,
        v.yaw_damping,
        v.wheel_radius,
        v.wheel_width,
        v.wheel_inertia,
        v.wheel_damping,
        v.pitch,
    ]
}

/// All numbers of the loads beside the wheels.
pub(super) fn load_values<T: Real>(l: &BodyLoads<T>) -> Vec<T> {
    let mut out = vec![l.force_x, l.yaw_moment];
    out.extend(l.wheel_torque);
    out
}
