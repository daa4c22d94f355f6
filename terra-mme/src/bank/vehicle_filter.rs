//! The six-state filter [v r ω_fl ω_fr ω_rl ω_rr] of one hypothesis: forces are no states, they follow from the soil.
//!
//! # Equation
//! x' = f(x) as in `rates`; measured: a, ω, v, r. Over a step h: x <- x + h φ1(hA) f(x), P <- Φ P Φᵀ + Q, Φ = e^(hA),
//! with the exact A; sensors one after the other at one linearisation, which for a diagonal R is the joint update.
//!
//! # Reference
//! M. Hochbruck, A. Ostermann, *Exponential integrators*, Acta Numerica 19 (2010), section 2.4 (the step);
//! D. T. Magill (1965) for the use of the innovations.

use terra_model::STANDSTILL_SPEED;

use super::matrix::{apply, exponentials, sandwich};
use super::motion::{AT_ACCEL, AT_SPEED, AT_WHEELS, AT_YAW, MOTION_CHANNELS, MotionSample, Plant};
use super::rates::{Row, lever, rates};
use super::soil_map::SoilMap;

/// v, r, four ω.
pub(crate) const STATES: usize = 6;
/// g \[m/s²\].
pub(super) const GRAVITY: f64 = 9.81;
/// Longest step of the prediction \[s\]: at low slip a wheel settles within 10 ms.
const LONGEST_STEP: f64 = 0.005;
/// Largest change of a wheel's slip in one step: a vehicle that leaves standstill crosses the whole force curve within
/// one row of the log, and a straight line does not follow it.
const SLIP_STEP: f64 = 0.1;
/// Steps of one prediction, however long it is.
const MOST_STEPS: usize = 400;

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
}
