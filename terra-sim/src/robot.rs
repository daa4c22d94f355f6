//! The truth of a four-wheeled, torque-driven vehicle.
//!
//! # Equation
//! - m a = Σ F_q + F_other, dv/dt = a - g sin(pitch); a is the specific force an accelerometer reads
//! - I_zz dr/dt = (t_w/2)\[(F_fr + F_rr) - (F_fl + F_rl)\] - M_res r + l_f (Fy_fl + Fy_fr) - l_r (Fy_rl + Fy_rr) + M_other
//! - I_w dω_q/dt = T_q - T_r,q - b_w ω_q - T_loss,q
//! - N_f = m (g cos(pitch) l_r - h a)/(2 L), N_r = m (g cos(pitch) l_f + h a)/(2 L) a wheel
//! - wheel centres travel at v - r t_w/2 (left) and v + r t_w/2 (right); path = ∫ v dt
//!
//! Loads depend on a, a on the wheel forces, those on the loads. The one unknown a is solved by secant steps on
//! "acceleration of the forces at the loads of a, less a", started from the last instant's a and slope, until they
//! agree within 1e-10 m/s² (1e-6 m/s² where the forces themselves jump); without load transfer and load effects one evaluation is exact.
//!
//! # Reference
//! L. E. Ray, Proc. SPIE 2008, eqs 1-6; load transfer by the balance of moments about the ground.

use terra_model::{Motion, STANDSTILL_SPEED, Vehicle};

use crate::control::Control;
use crate::effects::ActiveEffects;
use crate::error::SimError;
use crate::force_table::ForceTable;
use crate::noise::Roughness;
use crate::wheel::{WheelMotion, WheelState, smooth_sign};

/// g \[m/s²\], the value of the reference vehicle's loads (245.25 N a wheel of 100 kg).
pub const GRAVITY: f64 = 9.81;

/// v, r, ω of the four wheels, path, torque of each speed controller's integral.
pub(crate) const STATES: usize = 11;
/// Index of v.
pub(crate) const SPEED: usize = 0;
/// Index of r.
pub(crate) const YAW_RATE: usize = 1;
/// Index of the first ω.
pub(crate) const WHEELS_AT: usize = 2;
/// Index of the path.
pub(crate) const PATH: usize = 6;
/// Index of the first controller integral.
pub(crate) const INTEGRALS_AT: usize = 7;

/// Four values of the state from an index.
pub(crate) fn four(y: &[f64; STATES], from: usize) -> [f64; 4] {
    [y[from], y[from + 1], y[from + 2], y[from + 3]]
}

/// What a segment declares about the ground and the load.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surroundings {
    /// Inclination with the slope effect \[rad\].
    pub(crate) vehicle: Vehicle<f64>,
    /// \[N\].
    pub(crate) tow_load: f64,
    /// From 1.
    pub(crate) pass: u32,
}

/// Everything at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instant {
    /// dy/dt.
    pub(crate) rate: [f64; STATES],
    /// Specific force along x \[m/s²\].
    pub(crate) specific_force: f64,
    /// Torque the motors deliver \[N m\].
    pub(crate) motor_torque: [f64; 4],
    /// Wheels.
    pub(crate) wheels: [WheelState; 4],
}

/// The vehicle on its soil.
pub(crate) struct Robot {
    /// What the left and the right wheels stand on.
    pub(crate) ground: [ForceTable; 2],
    pub(crate) effects: ActiveEffects,
    pub(crate) force_roughness: [Roughness; 4],
    pub(crate) torque_roughness: [Roughness; 4],
    /// Last acceleration and last slope of the residual: a start for the next solution.
    pub(crate) warm: (f64, f64),
}

/// Agreement of acceleration and loads \[m/s²\], relative above 1 m/s².
const TOLERANCE: f64 = 1e-10;
/// What is accepted after [`PATIENCE`] iterations: where tabulated forces pass from one polynomial to the next they may
/// jump by 1e-8 of their size, and no closer agreement exists across the jump.
const LOOSE_TOLERANCE: f64 = 1e-6;
const PATIENCE: usize = 20;
const MAX_ITERATIONS: usize = 60;

impl Robot {
    /// Rates and forces at one instant.
    pub(crate) fn instant(
        &mut self,
        time: f64,
        y: &[f64; STATES],
        around: &Surroundings,
        control: &Control,
    ) -> Result<Instant, SimError> {
        let car = &around.vehicle;
        let motor = control.torque(time, four(y, WHEELS_AT), four(y, INTEGRALS_AT));
        let coupled = car.cg_height != 0.0 || self.effects.any_loads();
        let (mut a, mut slope) = self.warm;
        let mut last: Option<(f64, f64)> = None;
        for iteration in 0..MAX_ITERATIONS {
            let tolerance = if iteration < PATIENCE {
                TOLERANCE
            } else {
                LOOSE_TOLERANCE
            };
            let (found, instant) = self.at_acceleration(time, y, around, &motor, a)?;
            let residual = found - a;
            if !residual.is_finite() {
                return Err(SimError::NotFinite { time });
            }
            if !coupled || residual.abs() <= tolerance * (1.0 + a.abs()) {
                if let Some((wheel, state)) = instant
                    .wheels
                    .iter()
                    .enumerate()
                    .find(|(_, s)| s.normal_load <= 0.0)
                {
                    return Err(SimError::WheelLift {
                        time,
                        wheel,
                        load: state.normal_load,
                    });
                }
                self.warm = (found, slope);
                let mut instant = instant;
                control.integral_rate(time, y, &mut instant.rate);
                return Ok(instant);
            }
            if let Some((a_last, residual_last)) = last {
                let secant = (residual - residual_last) / (a - a_last);
                // d(found)/da is well below 1 in size for any stable vehicle; outside that, plain substitution.
                slope = if (-2.0..=-0.3).contains(&secant) {
                    secant
                } else {
                    -1.0
                };
            }
            last = Some((a, residual));
            a -= residual / slope;
        }
        let residual = last.map_or(f64::NAN, |(_, r)| r);
        self.warm = (0.0, -1.0);
        Err(SimError::LoadTransfer { time, residual })
    }

    /// Forces at the loads of an assumed specific force; returns the specific force they give.
    fn at_acceleration(
        &mut self,
        time: f64,
        y: &[f64; STATES],
        around: &Surroundings,
        motor: &[f64; 4],
        a: f64,
    ) -> Result<(f64, Instant), SimError> {
        let car = &around.vehicle;
        let (v, r) = (y[SPEED], y[YAW_RATE]);
        let speeds = four(y, WHEELS_AT);
        let to_rear = car.wheelbase - car.cg_to_front_axle;
        let (weight, transfer) = (GRAVITY * car.pitch.cos(), car.cg_height * a);
        let front = car.mass * (weight * to_rear - transfer) / (2.0 * car.wheelbase);
        let rear = car.mass * (weight * car.cg_to_front_axle + transfer) / (2.0 * car.wheelbase);

        let mut wheels = [WheelState::default(); 4];
        for (q, state) in wheels.iter_mut().enumerate() {
            let right = q % 2 == 1;
            let motion = WheelMotion {
                wheel: q,
                travel_speed: v + if right { 0.5 } else { -0.5 } * r * car.track,
                wheel_speed: speeds[q],
                yaw_rate: r,
                path: y[PATH],
                time,
                normal_load: if q < 2 { front } else { rear },
                radius: car.wheel_radius,
                width: car.wheel_width,
                pass: around.pass,
            };
            *state = motion.forces(&mut self.ground[usize::from(right)])?;
            // Rough ground shakes a wheel that moves, not one that stands.
            let moving = (car.wheel_radius * speeds[q]).abs().max(v.abs()) / STANDSTILL_SPEED;
            let share = smooth_sign(moving);
            state.drawbar_pull += share * self.force_roughness[q].at(time);
            state.resistive_torque += share * self.torque_roughness[q].at(time);
        }

        let dv = a - GRAVITY * car.pitch.sin();
        let mut motion = Motion {
            speed: v,
            acceleration: dv,
            yaw_rate: r,
            wheel_speed: speeds,
            wheel_torque: *motor,
            path: y[PATH],
            time,
        };
        let mut body = self.effects.loads(car, &motion);
        // Losses may depend on the torque that passes: what the motor gives less the loss itself.
        for _ in 0..MAX_ITERATIONS {
            let passed: [f64; 4] = std::array::from_fn(|q| motor[q] - body.wheel_torque[q]);
            if passed == motion.wheel_torque {
                break;
            }
            motion.wheel_torque = passed;
            body = self.effects.loads(car, &motion);
        }
        let tow = around.tow_load * (v / STANDSTILL_SPEED).tanh();

        let [fl, fr, rl, rr] = wheels.map(|w| w.drawbar_pull);
        // Summed by axle so that a mirrored run is the mirror image to the last bit.
        let force = (fl + fr) + (rl + rr) + body.force_x - tow;
        let specific_force = force / car.mass;
        let [yfl, yfr, yrl, yrr] = wheels.map(|w| w.lateral_force);
        let moment = 0.5 * car.track * ((fr + rr) - (fl + rl)) - car.yaw_damping * r
            + body.yaw_moment
            + (car.cg_to_front_axle * (yfl + yfr) - to_rear * (yrl + yrr));

        let mut rate = [0.0; STATES];
        rate[SPEED] = specific_force - GRAVITY * car.pitch.sin();
        rate[YAW_RATE] = moment / car.yaw_inertia;
        for q in 0..4 {
            rate[WHEELS_AT + q] = (motor[q]
                - wheels[q].resistive_torque
                - car.wheel_damping * speeds[q]
                - body.wheel_torque[q])
                / car.wheel_inertia;
        }
        rate[PATH] = v;
        Ok((
            specific_force,
            Instant {
                rate,
                specific_force,
                motor_torque: *motor,
                wheels,
            },
        ))
    }
}
