//! What soil and motors do to the vehicle in one state: its rates, its specific force, and their exact slopes.
//!
//! # Equation
//! - a = Σ D_q(i_q, W_q(a))/m, solved by Newton; v' = a - g sin(pitch)
//! - r' = ((t_w/2)(Σ_right D - Σ_left D) - M_res r)/I_zz, ω_q' = (T_q - Tr_q - b_w ω_q)/I_w
//! - W_f = m (g cos(pitch) l_r - h a)/(2L), W_r = m (g cos(pitch) l_f + h a)/(2L); right wheels x (1 + λ), left wheels
//!   x (1 - λ), λ = 2 h v r/(g cos(pitch) t_w): in a turn the outer wheels carry more. Both axles are equally stiff in
//!   roll, and the lateral acceleration is v r: side slip that builds up or ends is left out.

use terra_model::{Contact, STANDSTILL_SPEED};

use super::motion::Plant;
use super::soil_map::SoilMap;
use super::vehicle_filter::{GRAVITY, Infeasible, Matrix, STATES, Vector};

/// Agreement of acceleration and loads \[m/s²\].
const TOLERANCE: f64 = 1e-9;

/// f(x), its Jacobian, the specific force and its gradient.
pub(super) struct Rates {
    pub(super) rate: Vector,
    pub(super) slope: Matrix,
    pub(super) accel: f64,
    pub(super) accel_slope: Vector,
}

/// Odd, smooth, ±1 at and beyond ±1; with its derivative.
fn smooth_sign(x: f64) -> (f64, f64) {
    if x.abs() >= 1.0 {
        return (x.signum(), 0.0);
    }
    (0.5 * x * (3.0 - x * x), 1.5 * (1.0 - x * x))
}

/// Forward force and torque of one wheel, with derivatives in ω, speed of the wheel's centre, and load.
struct Wheel {
    pull: [f64; 4],
    torque: [f64; 4],
}

fn wheel(
    soil: &SoilMap,
    plant: &Plant,
    sample: &Row,
    x: &Vector,
    q: usize,
    load: f64,
) -> Result<Wheel, Infeasible> {
    if load.is_nan() || load <= 0.0 {
        return Err(Infeasible);
    }
    let car = &plant.vehicle;
    let (radius, arm) = (car.wheel_radius, lever(plant, q));
    let (w, travel) = (x[2 + q], x[0] + arm * x[1]);
    let rim = radius * w;
    let forward = rim + travel >= 0.0;
    let along = if forward { 1.0 } else { -1.0 };
    let (heading, heading_slope) = smooth_sign((rim + travel) / STANDSTILL_SPEED);
    // Slip along the heading, and its slopes in rim and travel speed.
    let scale = rim.abs().max(travel.abs()).max(STANDSTILL_SPEED);
    let raw = along * (rim - travel) / scale;
    let mut in_rim = along / scale;
    let mut in_travel = -in_rim;
    if scale > STANDSTILL_SPEED {
        if rim.abs() >= travel.abs() {
            in_rim -= raw / scale * rim.signum();
        } else {
            in_travel -= raw / scale * travel.signum();
        }
    }
    if raw.abs() >= 1.0 {
        (in_rim, in_travel) = (0.0, 0.0);
    }
    let mut at = Contact::new(raw.clamp(-1.0, 1.0), load, radius, car.wheel_width);
    at.speed = travel;
    at.wheel_speed = w;
    at.yaw_rate = x[1];
    at.time = sample.time;
    at.side = if q.is_multiple_of(2) { -1.0 } else { 1.0 };
    at.ahead = car.cg_to_front_axle - if q < 2 { 0.0 } else { car.wheelbase };
    at.wheelbase = car.wheelbase;
    at.earlier_passes = if (q < 2) == forward { 0.0 } else { 1.0 };
    let f = soil.forces(&at).ok_or(Infeasible)?;
    // A wheel that hardly moves is held back no more than it moves.
    let (hold, hold_slope) = if f.pull < 0.0 && along * travel < STANDSTILL_SPEED {
        let (s, d) = smooth_sign(along * travel / STANDSTILL_SPEED);
        (s, d * along / STANDSTILL_SPEED)
    } else {
        (1.0, 0.0)
    };
    let heading_slope = heading_slope / STANDSTILL_SPEED;
    let combine = |value: f64, in_slip: f64, in_load: f64, hold: f64, hold_slope: f64| {
        let (by_rim, by_travel) = (in_slip * in_rim, in_slip * in_travel);
        [
            heading * hold * value,
            radius * hold * (heading * by_rim + heading_slope * value),
            hold * (heading * by_travel + heading_slope * value) + heading * hold_slope * value,
            heading * hold * in_load,
        ]
    };
    Ok(Wheel {
        pull: combine(f.pull, f.pull_slip, f.pull_load, hold, hold_slope),
        torque: combine(f.torque, f.torque_slip, f.torque_load, 1.0, 0.0),
    })
}

/// Sideways place of wheel q: its centre travels at v + lever r.
pub(super) fn lever(plant: &Plant, q: usize) -> f64 {
    let half = 0.5 * plant.vehicle.track;
    if q.is_multiple_of(2) { -half } else { half }
}

/// Time and torque of a step.
pub(super) struct Row {
    pub(super) time: f64,
    pub(super) torque: [f64; 4],
}

pub(super) fn rates(
    soils: [&SoilMap; 2],
    plant: &Plant,
    row: &Row,
    x: &Vector,
    mut accel: f64,
) -> Result<Rates, Infeasible> {
    let car = &plant.vehicle;
    let share = car.mass / (2.0 * car.wheelbase);
    let weight = GRAVITY * car.pitch.cos();
    let lift = share * car.cg_height;
    let statics = [
        share * weight * (car.wheelbase - car.cg_to_front_axle),
        share * weight * car.cg_to_front_axle,
    ];
    // Load of a wheel over half the load of its axle, and its slopes in v and r.
    let per_turn = 2.0 * car.cg_height / (weight * car.track);
    let aside = |q: usize| {
        if q.is_multiple_of(2) {
            -per_turn
        } else {
            per_turn
        }
    };
    let lean = |q: usize| 1.0 + aside(q) * x[0] * x[1];
    let half_axle = |q: usize, accel: f64| {
        if q < 2 {
            statics[0] - lift * accel
        } else {
            statics[1] + lift * accel
        }
    };
    let at = |accel: f64| -> Result<[Wheel; 4], Infeasible> {
        let one = |q: usize| {
            let load = half_axle(q, accel) * lean(q);
            wheel(soils[q % 2], plant, row, x, q, load)
        };
        Ok([one(0)?, one(1)?, one(2)?, one(3)?])
    };
    let load_slope = |q: usize| lean(q) * if q < 2 { -lift } else { lift };
    let mut wheels = at(accel)?;
    let mut stiffness;
    let mut round = 0;
    loop {
        let pull: f64 = wheels.iter().map(|w| w.pull[0]).sum();
        stiffness = car.mass
            - (0..4)
                .map(|q| wheels[q].pull[3] * load_slope(q))
                .sum::<f64>();
        let step = (pull - car.mass * accel) / stiffness;
        if !step.is_finite() {
            return Err(Infeasible);
        }
        accel += step;
        round += 1;
        // One Newton step is nearly exact; the forces that go with the last one follow to first order.
        if step.abs() < 1e-3 || round >= 8 {
            for (q, w) in wheels.iter_mut().enumerate() {
                w.pull[0] += w.pull[3] * load_slope(q) * step;
                w.torque[0] += w.torque[3] * load_slope(q) * step;
            }
            if step.abs() > 1e-3 * (1.0 + accel.abs()) + TOLERANCE {
                return Err(Infeasible);
            }
            break;
        }
        wheels = at(accel)?;
    }

    // Load by v and r at a fixed acceleration.
    let load_turn: [[f64; 2]; 4] = std::array::from_fn(|q| {
        let share = half_axle(q, accel) * aside(q);
        [share * x[1], share * x[0]]
    });
    let mut accel_slope = [0.0; STATES];
    for (q, w) in wheels.iter().enumerate() {
        for (k, turn) in load_turn[q].iter().enumerate() {
            accel_slope[k] += w.pull[3] * turn / stiffness;
        }
        accel_slope[0] += w.pull[2] / stiffness;
        accel_slope[1] += w.pull[2] * lever(plant, q) / stiffness;
        accel_slope[2 + q] += w.pull[1] / stiffness;
    }
    let mut rate = [0.0; STATES];
    let mut slope = [[0.0; STATES]; STATES];
    rate[0] = accel - GRAVITY * car.pitch.sin();
    slope[0] = accel_slope;
    let mut moment = -car.yaw_damping * x[1];
    slope[1][1] = -car.yaw_damping / car.yaw_inertia;
    for (q, w) in wheels.iter().enumerate() {
        let arm = lever(plant, q);
        moment += arm * w.pull[0];
        let damping = car.wheel_damping;
        rate[2 + q] = (row.torque[q] - w.torque[0] - damping * x[2 + q]) / car.wheel_inertia;
        let by_load = |force: &[f64; 4], k: usize| {
            let turn = load_turn[q].get(k).copied().unwrap_or(0.0);
            force[3] * (load_slope(q) * accel_slope[k] + turn)
        };
        for (k, s) in slope[1].iter_mut().enumerate() {
            *s += arm * by_load(&w.pull, k) / car.yaw_inertia;
        }
        for (k, s) in slope[2 + q].iter_mut().enumerate() {
            *s -= by_load(&w.torque, k) / car.wheel_inertia;
        }
        slope[1][0] += arm * w.pull[2] / car.yaw_inertia;
        slope[1][1] += arm * arm * w.pull[2] / car.yaw_inertia;
        slope[1][2 + q] += arm * w.pull[1] / car.yaw_inertia;
        slope[2 + q][0] -= w.torque[2] / car.wheel_inertia;
        slope[2 + q][1] -= w.torque[2] * arm / car.wheel_inertia;
        slope[2 + q][2 + q] -= (w.torque[1] + damping) / car.wheel_inertia;
    }
    rate[1] = moment / car.yaw_inertia;
    let finite = rate
        .iter()
        .chain(slope.iter().flatten())
        .all(|v| v.is_finite());
    if !finite {
        return Err(Infeasible);
    }
    Ok(Rates {
        rate,
        slope,
        accel,
        accel_slope,
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::bank::motion::MotionNoise;
    use std::sync::Arc;
    use terra_model::{Registry, Vehicle, catalogue};

    /// The light robot of Ray (2008).
    pub(in crate::bank) fn light() -> Plant {
        let vehicle = Vehicle {
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
        };
        Plant::new(vehicle, MotionNoise::default()).unwrap()
    }

    fn soil(id: &str) -> SoilMap {
        let law = Arc::new(Registry::builtin().law("wong-reece").unwrap());
        let p = catalogue::find(id)
            .unwrap()
            .parameters(law.model())
            .unwrap();
        SoilMap::new(&law, &p, 0.254, 0.15, 245.25)
    }

    /// The hand-written Jacobian against central differences, driving, turning, braking and in reverse.
    #[test]
    fn jacobian_is_the_derivative() {
        let (plant, left, right) = (light(), soil("dry_sand"), soil("lean_clay_22"));
        let states: [Vector; 4] = [
            [0.6, 0.2, 3.1, 4.0, 3.5, 4.4],
            [0.02, 0.0, 0.9, 0.8, 0.85, 0.7],
            [1.2, -0.1, 4.0, 4.1, 4.2, 4.3],
            [-0.5, 0.1, -3.0, -2.9, -3.3, -3.1],
        ];
        for x in states {
            let row = Row {
                time: 0.0,
                torque: [12.0, 13.0, 14.0, 15.0],
            };
            let at = |x: &Vector| rates([&left, &right], &plant, &row, x, 0.3).unwrap();
            let now = at(&x);
            for k in 0..STATES {
                let h = 1e-6;
                let (mut up, mut down) = (x, x);
                up[k] += h;
                down[k] -= h;
                let (up, down) = (at(&up), at(&down));
                for i in 0..STATES {
                    let slope = (up.rate[i] - down.rate[i]) / (2.0 * h);
                    assert!(
                        (slope - now.slope[i][k]).abs() < 2e-3 * (1.0 + slope.abs()),
                        "{x:?} {i} {k}: {slope} {}",
                        now.slope[i][k]
                    );
                }
                let slope = (up.accel - down.accel) / (2.0 * h);
                assert!((slope - now.accel_slope[k]).abs() < 2e-3 * (1.0 + slope.abs()));
            }
        }
    }

    /// In a left turn the right wheels carry more: with both soils alike the loads that make the forces differ by
    /// λ = 2 h v r/(g t_w), which a vehicle whose centre of mass lies on the ground does not know.
    #[test]
    fn a_turn_loads_the_outer_wheels() {
        let soil = soil("dry_sand");
        let row = Row {
            time: 0.0,
            torque: [12.0; 4],
        };
        let yaw_accel = |height: f64, r: f64| {
            let mut plant = light();
            plant.vehicle.cg_height = height;
            // All wheels slip alike: what is left of the moment is that of the loads.
            let rim = |q: usize| (1.0 + lever(&plant, q) * r) / (0.254 * 0.6);
            let x = [1.0, r, rim(0), rim(1), rim(2), rim(3)];
            let moment = rates([&soil, &soil], &plant, &row, &x, 0.0).unwrap();
            moment.rate[1] * plant.vehicle.yaw_inertia + plant.vehicle.yaw_damping * r
        };
        assert!(yaw_accel(0.0, 0.5).abs() < 0.05);
        // Dry sand at slip .4 pulls dD/dW of its own load more on each right wheel and less on each left one.
        let at = |load: f64| {
            soil.forces(&Contact::new(0.4, load, 0.254, 0.15))
                .unwrap()
                .pull
        };
        let lean = 2.0 * 0.22 * 0.5 / (9.81 * 0.6);
        let wanted = 0.6 * (at(245.25 * (1.0 + lean)) - at(245.25 * (1.0 - lean)));
        let found = yaw_accel(0.22, 0.5);
        assert!(wanted.abs() > 0.05, "{wanted}");
        assert!((found / wanted - 1.0).abs() < 0.1, "{found} {wanted}");
        assert!((yaw_accel(0.22, -0.5) + found).abs() < 1e-6 * found.abs());
    }
}
