//! The six-state filter [v r ω_fl ω_fr ω_rl ω_rr] of one hypothesis: forces are no states, they follow from the soil.
//!
//! # Equation
//! - a = Σ D_q(i_q, W_q(a))/m, solved by Newton; v' = a - g sin(pitch)
//! - r' = ((t_w/2)(Σ_right D - Σ_left D) - M_res r)/I_zz, ω_q' = (T_q - Tr_q - b_w ω_q)/I_w
//! - W_f = m (g cos(pitch) l_r - h a)/(2L), W_r = m (g cos(pitch) l_f + h a)/(2L)
//! - measured: a, ω, v, r. Over a step h: x <- x + h φ1(hA) f(x), P <- Φ P Φᵀ + Q, Φ = e^(hA), with the exact A;
//!   sensors one after the other at one linearisation, which for a diagonal R is the joint update.
//!
//! # Reference
//! M. Hochbruck, A. Ostermann, *Exponential integrators*, Acta Numerica 19 (2010), section 2.4 (the step);
//! D. T. Magill (1965) for the use of the innovations.

use terra_model::{Contact, STANDSTILL_SPEED};

use super::motion::{AT_ACCEL, AT_SPEED, AT_WHEELS, AT_YAW, MOTION_CHANNELS, MotionSample, Plant};
use super::soil_map::SoilMap;

/// v, r, four ω.
pub(crate) const STATES: usize = 6;
/// g \[m/s²\].
const GRAVITY: f64 = 9.81;
/// Longest step of the prediction \[s\]: at low slip a wheel settles within 10 ms.
const LONGEST_STEP: f64 = 0.005;
/// Largest change of a wheel's slip in one step: a vehicle that leaves standstill crosses the whole force curve within
/// one row of the log, and a straight line does not follow it.
const SLIP_STEP: f64 = 0.1;
/// 1-sigma of slip above which sigma points take the place of the Jacobian.
const BENT: f64 = 0.1;
/// Steps of one prediction, however long it is.
const MOST_STEPS: usize = 400;
/// Agreement of acceleration and loads \[m/s²\].
const TOLERANCE: f64 = 1e-9;

pub(crate) type Vector = [f64; STATES];
pub(crate) type Matrix = [[f64; STATES]; STATES];

/// State of one filter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) x: Vector,
    pub(crate) p: Matrix,
    /// Last specific force: where the next solution starts.
    pub(crate) accel: f64,
}

/// What one sample says to one hypothesis.
#[derive(Clone, Debug, Default)]
pub(crate) struct Innovation {
    pub(crate) log_density: f64,
    /// Standardised innovations in the order they were taken.
    pub(crate) whitened: Vec<f64>,
}

/// Why a hypothesis has no prediction here.
#[derive(Clone, Debug)]
pub(crate) struct Infeasible;

/// f(x), its Jacobian, the specific force and its gradient.
struct Rates {
    rate: Vector,
    slope: Matrix,
    accel: f64,
    accel_slope: Vector,
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
fn lever(plant: &Plant, q: usize) -> f64 {
    let half = 0.5 * plant.vehicle.track;
    if q.is_multiple_of(2) { -half } else { half }
}

/// Time and torque of a step.
struct Row {
    time: f64,
    torque: [f64; 4],
}

fn rates(
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
    let at = |accel: f64| -> Result<[Wheel; 4], Infeasible> {
        let one = |q: usize| {
            let load = if q < 2 {
                statics[0] - lift * accel
            } else {
                statics[1] + lift * accel
            };
            wheel(soils[q % 2], plant, row, x, q, load)
        };
        Ok([one(0)?, one(1)?, one(2)?, one(3)?])
    };
    let load_slope = |q: usize| if q < 2 { -lift } else { lift };
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

    let mut accel_slope = [0.0; STATES];
    for (q, w) in wheels.iter().enumerate() {
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
        let by_load = |force: &[f64; 4], k: usize| force[3] * load_slope(q) * accel_slope[k];
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

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut c = [[0.0; STATES]; STATES];
    for i in 0..STATES {
        for k in 0..STATES {
            let x = a[i][k];
            for j in 0..STATES {
                c[i][j] += x * b[k][j];
            }
        }
    }
    c
}

fn apply(a: &Matrix, x: &Vector) -> Vector {
    std::array::from_fn(|i| (0..STATES).map(|k| a[i][k] * x[k]).sum())
}

/// e^(hA) and φ1(hA) = Σ (hA)^k/(k+1)!, by series after halving, then doubling: φ1(2z) = φ1(z)(e^z + 1)/2.
fn exponentials(a: &Matrix, h: f64) -> (Matrix, Matrix) {
    let size = a
        .iter()
        .map(|r| r.iter().map(|v| v.abs()).sum::<f64>())
        .fold(0.0, f64::max)
        * h;
    let halvings = if size > 0.25 {
        ((size / 0.25).log2().ceil() as u32).min(40)
    } else {
        0
    };
    let small = h / 2.0_f64.powi(halvings as i32);
    let z: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] * small));
    let identity: Matrix =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    // φ1 by Horner to z^7, then e^z = 1 + z φ1.
    let mut phi = identity;
    for k in (2..=8).rev() {
        let step = product(&z, &phi);
        for i in 0..STATES {
            for j in 0..STATES {
                phi[i][j] = identity[i][j] + step[i][j] / f64::from(k);
            }
        }
    }
    let mut exp = product(&z, &phi);
    for (i, row) in exp.iter_mut().enumerate() {
        row[i] += 1.0;
    }
    for _ in 0..halvings {
        let mut plus = exp;
        for (i, row) in plus.iter_mut().enumerate() {
            row[i] += 1.0;
        }
        let doubled = product(&phi, &plus);
        phi = doubled.map(|r| r.map(|v| 0.5 * v));
        exp = product(&exp, &exp);
    }
    (exp, phi)
}

/// A P Aᵀ, symmetric to the last bit.
fn sandwich(a: &Matrix, p: &Matrix) -> Matrix {
    let left = product(a, p);
    let mut out = [[0.0; STATES]; STATES];
    for i in 0..STATES {
        for j in 0..=i {
            let v: f64 = (0..STATES).map(|k| left[i][k] * a[j][k]).sum();
            out[i][j] = v;
            out[j][i] = v;
        }
    }
    out
}

/// The longest step over which no slip changes by more than [`SLIP_STEP`], at least a fiftieth of `longest`.
fn step(plant: &Plant, x: &Vector, rate: &Vector, longest: f64) -> f64 {
    let radius = plant.vehicle.wheel_radius;
    let fastest = (0..4)
        .map(|q| {
            let arm = lever(plant, q);
            let (rim, travel) = (radius * x[2 + q], x[0] + arm * x[1]);
            let scale = rim.abs().max(travel.abs()).max(STANDSTILL_SPEED);
            (radius * rate[2 + q])
                .abs()
                .max((rate[0] + arm * rate[1]).abs())
                / scale
        })
        .fold(0.0, f64::max);
    (SLIP_STEP / fastest).clamp(longest / 50.0, longest)
}

impl Estimate {
    /// The belief of a vehicle just seen: what is measured as measured, the rest wide. A speed nobody measures lies
    /// between standing and rolling without slip.
    pub(crate) fn start(plant: &Plant, sample: &MotionSample) -> Self {
        let n = &plant.noise;
        let truth = |k: usize| {
            let r = plant.belief.readings[k];
            sample.channels[k].map(|z| (z - r.offset) / r.gain)
        };
        let mut x = [0.0; STATES];
        let mut sd = [0.1, 0.1, 0.5, 0.5, 0.5, 0.5];
        for q in 0..4 {
            if let Some(w) = truth(AT_WHEELS + q) {
                (x[2 + q], sd[2 + q]) = (w, n.wheel_speed / plant.belief.readings[1 + q].gain);
            }
        }
        let rim = plant.vehicle.wheel_radius * (x[2] + x[3] + x[4] + x[5]) / 4.0;
        (x[0], sd[0]) = (0.5 * rim, 0.3 * rim.abs() + 0.02);
        for (state, channel, noise) in [(0, AT_SPEED, n.ground_speed), (1, AT_YAW, n.yaw_rate)] {
            if let Some(value) = truth(channel) {
                (x[state], sd[state]) = (value, noise / plant.belief.readings[channel].gain);
            }
        }
        let mut p = [[0.0; STATES]; STATES];
        for (k, row) in p.iter_mut().enumerate() {
            row[k] = sd[k] * sd[k];
        }
        Estimate { x, p, accel: 0.0 }
    }

    /// Moves the belief from `last` to `next` under the mean of both torques.
    pub(crate) fn predict(
        &mut self,
        soils: [&SoilMap; 2],
        plant: &Plant,
        last: &MotionSample,
        next: &MotionSample,
    ) -> Result<(), Infeasible> {
        let dt = next.time - last.time;
        let steps = ((dt / LONGEST_STEP).ceil().max(1.0) as usize).min(MOST_STEPS);
        let h = dt / steps as f64;
        let noise = &plant.noise;
        let torque = std::array::from_fn(|q| {
            0.5 * (plant.true_torque(last.torque[q]) + plant.true_torque(next.torque[q]))
        });
        let [qv, qr, qw] = noise.process;
        let density = [qv, qr, qw, qw, qw, qw].map(|q| q * q);
        if self.bends(plant) {
            let flow = |x: &Vector, accel: f64| -> Result<(Vector, f64), Infeasible> {
                let (mut x, mut accel) = (*x, accel);
                let mut done = 0.0;
                while done < dt {
                    let time = last.time + done;
                    let now = rates(soils, plant, &Row { time, torque }, &x, accel)?;
                    let h = step(plant, &x, &now.rate, h).min(dt - done);
                    let moved = apply(&exponentials(&now.slope, h).1, &now.rate);
                    x.iter_mut().zip(moved).for_each(|(x, d)| *x += h * d);
                    accel = now.accel;
                    done = if dt - done - h < 1e-9 * dt {
                        dt
                    } else {
                        done + h
                    };
                }
                Ok((x, accel))
            };
            if let Some(next) = self.spread(&flow) {
                *self = next;
                let shaken = dt * noise.wheel_torque
                    / (plant.belief.torque.gain * plant.vehicle.wheel_inertia);
                for (i, q) in density.iter().enumerate() {
                    self.p[i][i] += dt * q + if i < 2 { 0.0 } else { shaken * shaken };
                }
                return Ok(());
            }
        }
        // Response of the state to a unit error of each torque, held over the whole step.
        let mut response = [[0.0; STATES]; 4];
        let longest = h;
        let mut done = 0.0;
        while done < dt {
            let row = Row {
                time: last.time + done,
                torque,
            };
            let now = rates(soils, plant, &row, &self.x, self.accel)?;
            let h = step(plant, &self.x, &now.rate, longest).min(dt - done);
            done = if dt - done - h < 1e-9 * dt {
                dt
            } else {
                done + h
            };
            let (phi, psi) = exponentials(&now.slope, h);
            let moved = apply(&psi, &now.rate);
            for (x, d) in self.x.iter_mut().zip(moved) {
                *x += h * d;
            }
            self.accel = now.accel;
            self.shake(&density, 0.5 * h);
            self.p = sandwich(&phi, &self.p);
            self.shake(&density, 0.5 * h);
            for (q, r) in response.iter_mut().enumerate() {
                *r = apply(&phi, r);
                for i in 0..STATES {
                    r[i] += h * psi[i][2 + q] / plant.vehicle.wheel_inertia;
                }
            }
        }
        let variance = (noise.wheel_torque / plant.belief.torque.gain).powi(2);
        for r in &response {
            for i in 0..STATES {
                for j in 0..STATES {
                    self.p[i][j] += variance * r[i] * r[j];
                }
            }
        }
        if self.x.iter().all(|v| v.is_finite()) {
            Ok(())
        } else {
            Err(Infeasible)
        }
    }

    /// Takes the channels in `use_channels` of a sample in, and says how likely they were.
    pub(crate) fn update(
        &mut self,
        soils: [&SoilMap; 2],
        plant: &Plant,
        sample: &MotionSample,
        use_channels: &[bool; MOTION_CHANNELS],
    ) -> Result<Innovation, Infeasible> {
        let mut out = Innovation::default();
        // Speeds first: the specific force is then judged at a state that knows them.
        let channels = sample.channels.iter().zip(use_channels).enumerate();
        for (k, (z, _)) in channels.skip(AT_WHEELS).filter(|(_, (_, used))| **used) {
            let Some(z) = *z else { continue };
            let state = match k {
                AT_SPEED => 0,
                AT_YAW => 1,
                _ => 1 + k,
            };
            let mut h = [0.0; STATES];
            h[state] = 1.0;
            let ph = apply(&self.p, &h);
            let (value, variance) = (self.x[state], self.p[state][state]);
            self.take(plant, k, z, value, variance, &ph, &mut out)?;
        }
        if let Some(z) = sample.channels[AT_ACCEL].filter(|_| use_channels[AT_ACCEL]) {
            let row = Row {
                time: sample.time,
                torque: sample.torque,
            };
            let now = rates(soils, plant, &row, &self.x, self.accel)?;
            self.accel = now.accel;
            let h = now.accel_slope;
            let ph = apply(&self.p, &h);
            let linear: f64 = (0..STATES).map(|i| h[i] * ph[i]).sum();
            let seen = |x: &Vector| rates(soils, plant, &row, x, self.accel).map(|r| r.accel);
            let (value, variance, ph) = self
                .bends(plant)
                .then(|| self.seen_from_points(&seen))
                .flatten()
                .unwrap_or((now.accel, linear, ph));
            self.take(plant, AT_ACCEL, z, value, variance, &ph, &mut out)?;
        }
        self.keep_with_the_wheels();
        Ok(out)
    }

    /// A vehicle that rolls against all its wheels is outside every terrain model, and a filter that strays there near
    /// standstill meets forces that keep it there. The mean goes back to v = 0, the nearest state that a model covers.
    ///
    /// # Equation
    /// x <- x - P e_v v / P_vv when v Σω < 0.
    ///
    /// # Reference
    /// D. Simon, IET Control Theory & Applications 4(8):1303-1318, 2010, estimate projection.
    fn keep_with_the_wheels(&mut self) {
        let v = self.x[0];
        let turning: f64 = self.x[2..].iter().sum();
        if v * turning < 0.0 && self.p[0][0] > 0.0 {
            let share = v / self.p[0][0];
            for i in 0..STATES {
                self.x[i] -= self.p[i][0] * share;
            }
        }
    }

    /// One channel: `value` predicted with `variance`, `ph` its covariance with the state.
    fn take(
        &mut self,
        plant: &Plant,
        k: usize,
        z: f64,
        value: f64,
        variance: f64,
        ph: &Vector,
        out: &mut Innovation,
    ) -> Result<(), Infeasible> {
        let r = plant.belief.readings[k];
        let ph = ph.map(|v| v * r.gain);
        let s = plant.variances()[k] + variance * r.gain * r.gain;
        let innovation = z - (r.gain * value + r.offset);
        if !(s.is_finite() && s > 0.0 && innovation.is_finite()) {
            return Err(Infeasible);
        }
        let e = innovation / s.sqrt();
        for i in 0..STATES {
            self.x[i] += ph[i] * innovation / s;
            for j in 0..=i {
                let v = self.p[i][j] - ph[i] * ph[j] / s;
                self.p[i][j] = v;
                self.p[j][i] = v;
            }
        }
        out.log_density -= 0.5 * (e * e + (2.0 * std::f64::consts::PI * s).ln());
        out.whitened.push(e);
        Ok(())
    }

    /// Adds process noise of the given density over a time.
    fn shake(&mut self, density: &Vector, time: f64) {
        for (i, q) in density.iter().enumerate() {
            self.p[i][i] += time * q;
        }
    }

    /// True while slip is so uncertain that forces are no straight line across it.
    fn bends(&self, plant: &Plant) -> bool {
        let radius = plant.vehicle.wheel_radius;
        (0..4).any(|q| {
            let (w, arm) = (2 + q, lever(plant, q));
            let travel = self.x[0] + arm * self.x[1];
            let rim = radius * self.x[w];
            let scale = rim.abs().max(travel.abs()).max(STANDSTILL_SPEED);
            let variance = radius * radius * self.p[w][w] + self.p[0][0] + arm * arm * self.p[1][1]
                - 2.0 * radius * (self.p[0][w] + arm * self.p[1][w])
                + 2.0 * arm * self.p[0][1];
            variance > (BENT * scale).powi(2)
        })
    }

    /// The points x ± √n L_k of the cubature rule, P = L Lᵀ; none when P has no root.
    fn points(&self) -> Option<[Vector; 2 * STATES]> {
        let mut l = [[0.0; STATES]; STATES];
        for j in 0..STATES {
            let rest = self.p[j][j] - (0..j).map(|k| l[j][k] * l[j][k]).sum::<f64>();
            if rest.is_nan() || rest <= 0.0 {
                return None;
            }
            l[j][j] = rest.sqrt();
            for i in j + 1..STATES {
                let sum = self.p[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
                l[i][j] = sum / l[j][j];
            }
        }
        let root = (STATES as f64).sqrt();
        Some(std::array::from_fn(|k| {
            let sign = if k < STATES { root } else { -root };
            std::array::from_fn(|i| self.x[i] + sign * l[i][k % STATES])
        }))
    }

    /// Mean and covariance after a flow by the cubature rule (I. Arasaratnam, S. Haykin, IEEE Trans. Automatic Control
    /// 54(6):1254-1269, 2009); none when a point leaves what the soil carries.
    fn spread(
        &self,
        flow: &impl Fn(&Vector, f64) -> Result<(Vector, f64), Infeasible>,
    ) -> Option<Self> {
        let share = 1.0 / (2 * STATES) as f64;
        let mut moved = Vec::with_capacity(2 * STATES);
        for x in self.points()? {
            moved.push(flow(&x, self.accel).ok()?);
        }
        let mut next = Estimate {
            x: [0.0; STATES],
            p: [[0.0; STATES]; STATES],
            accel: 0.0,
        };
        for (x, accel) in &moved {
            for (sum, x) in next.x.iter_mut().zip(x) {
                *sum += share * x;
            }
            next.accel += share * accel;
        }
        for (x, _) in &moved {
            for i in 0..STATES {
                for j in 0..STATES {
                    next.p[i][j] += share * (x[i] - next.x[i]) * (x[j] - next.x[j]);
                }
            }
        }
        next.x.iter().all(|v| v.is_finite()).then_some(next)
    }

    /// Mean and variance of a quantity by the cubature rule, and its covariance with the state.
    fn seen_from_points(
        &self,
        seen: &impl Fn(&Vector) -> Result<f64, Infeasible>,
    ) -> Option<(f64, f64, Vector)> {
        let share = 1.0 / (2 * STATES) as f64;
        let points = self.points()?;
        let mut values = [0.0; 2 * STATES];
        for (value, x) in values.iter_mut().zip(&points) {
            *value = seen(x).ok()?;
        }
        let mean: f64 = values.iter().map(|v| share * v).sum();
        let variance = values.iter().map(|v| share * (v - mean).powi(2)).sum();
        let mut with = [0.0; STATES];
        for (value, x) in values.iter().zip(&points) {
            for i in 0..STATES {
                with[i] += share * (value - mean) * (x[i] - self.x[i]);
            }
        }
        Some((mean, variance, with))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bank::motion::MotionNoise;
    use std::sync::Arc;
    use terra_model::{Registry, Vehicle, catalogue};

    pub(crate) fn light() -> Plant {
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

    /// e^A of a rotation and a decay in closed form, and φ1 A = e^A - 1.
    #[test]
    fn exponentials_in_closed_form() {
        let mut a = [[0.0; STATES]; STATES];
        (a[0][1], a[1][0]) = (-7.0, 7.0);
        a[2][2] = -300.0;
        let (exp, phi) = exponentials(&a, 0.1);
        assert!((exp[0][0] - 0.7_f64.cos()).abs() < 1e-10);
        assert!((exp[1][0] - 0.7_f64.sin()).abs() < 1e-10);
        assert!((exp[2][2] - (-30.0_f64).exp()).abs() < 1e-12);
        let back = product(&phi, &a.map(|r| r.map(|v| 0.1 * v)));
        for i in 0..STATES {
            for j in 0..STATES {
                let one = if i == j { 1.0 } else { 0.0 };
                assert!((back[i][j] - (exp[i][j] - one)).abs() < 1e-10);
            }
        }
    }
}
