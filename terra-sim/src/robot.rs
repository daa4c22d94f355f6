//! The truth of a four-wheeled, skid-steered vehicle in the plane of the ground.
//!
//! # Equation
//! - m a_x = Σ Fx_q + F_other, dv/dt = a_x - g sin(pitch) + r v_y; a is the specific force an accelerometer reads
//! - free: m a_y = Σ Fy_q, dv_y/dt = a_y - g cos(pitch) sin(roll) - r v; the wheel law shears along (slip, tan β)
//! - held: v_y = 0, the ground holds the vehicle at its centre of mass: a_y = r v + g cos(pitch) sin(roll)
//! - I_zz dr/dt = Σ (x_q Fy_q - y_q Fx_q) - M_res r + M_other
//! - I_w dω_q/dt = T_q - T_r,q - b_w ω_q - T_loss,q
//! - loads: [`crate::loads`]; wheel centres at (x_q, y_q) travel at (v - r y_q, v_y + r x_q); path = ∫ v dt
//! - pose in the ground's plane: x' = v cos ψ - v_y sin ψ, y' = v sin ψ + v_y cos ψ, ψ' = r
//!
//! Held is the nominal vehicle, whose turning is resisted by M_res alone; free is the vehicle as soil mechanics has it,
//! and M_res comes on top. Straight on level ground they are the same to the last bit.
//!
//! Loads depend on a, a on the wheel forces, those on the loads. The unknown a_x is solved by secant steps on
//! "acceleration of the forces at the loads of a, less a", started from the last instant's a and slope, until they
//! agree within 1e-10 m/s² (1e-6 m/s² where the forces themselves jump); a_y, on which the forces hardly depend, is
//! substituted along the way. Without load transfer and load effects one evaluation is exact. Straight on, two evaluations mostly
//! are enough: all forces are taken along the chord through both to where it has no residual, when the distances to both
//! are so short that what bends is below 1e-9.
//!
//! # Reference
//! L. E. Ray, Proc. SPIE 2008, eqs 1-6; load transfer by the balance of moments about the ground.

use terra_model::{Motion, STANDSTILL_SPEED};

use crate::control::Control;
use crate::effects::{ActiveEffects, MEMORIES};
use crate::error::SimError;
use crate::ground::{Ground, Ruts};
use crate::instant::{Instant, Warm};
use crate::loads::LoadedVehicle;
use crate::noise::RoughGround;
use crate::off_library::WheelView;
use crate::wheel::{WheelMotion, WheelState, smooth_sign};

/// g \[m/s²\], the value of the reference vehicle's loads (245.25 N a wheel of 100 kg).
pub const GRAVITY: f64 = 9.81;

/// v, r, ω of the four wheels, path, torque of each speed controller's integral, v_y, motor torques, what effects
/// remember, wheel angles, heading, x, y.
pub(crate) const STATES: usize = 23 + 4 * MEMORIES;
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
/// Index of v_y.
pub(crate) const LATERAL_SPEED: usize = 11;
/// Index of the first motor torque.
pub(crate) const MOTORS_AT: usize = 12;
/// Index of the first memory.
const MEMORY_AT: usize = 16;
/// Index of the first wheel angle.
const ANGLES_AT: usize = MEMORY_AT + 4 * MEMORIES;
/// Index of ψ.
pub(crate) const HEADING: usize = ANGLES_AT + 4;
/// Index of x, before y.
pub(crate) const POSITION: usize = HEADING + 1;

/// Four values of the state from an index.
pub(crate) fn four(y: &[f64; STATES], from: usize) -> [f64; 4] {
    [y[from], y[from + 1], y[from + 2], y[from + 3]]
}

/// What a segment declares about the ground and the load.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surroundings {
    /// The vehicle with its payload on its ground.
    pub(crate) vehicle: LoadedVehicle,
    /// \[N\].
    pub(crate) tow_load: f64,
    /// From 1.
    pub(crate) pass: u32,
}

/// The vehicle on its soil.
pub(crate) struct Robot {
    pub(crate) ground: Ground,
    pub(crate) effects: ActiveEffects,
    pub(crate) rough: RoughGround,
    /// The soil alone holds the vehicle sideways.
    pub(crate) slides: bool,
    /// Ruts, where they are remembered.
    pub(crate) ruts: Option<Ruts>,
    pub(crate) warm: Warm,
    /// The instant solved last, with its time and state: the end of a step is the beginning of the next.
    pub(crate) known: Option<(f64, [f64; STATES], Instant)>,
}

/// Agreement of acceleration and loads \[m/s²\], relative above 1 m/s².
const TOLERANCE: f64 = 1e-10;
/// What is accepted after [`PATIENCE`] iterations: where tabulated forces pass from one polynomial to the next they may
/// jump by 1e-8 of their size, and no closer agreement exists across the jump.
const LOOSE_TOLERANCE: f64 = 1e-6;
const PATIENCE: usize = 20;
/// Product of the distances \[m²/s⁴\] from two evaluations below which the chord is the curve: a force that changes by its
/// own size over 10 m/s² leaves it by 1e-9 of its size.
const CHORD: f64 = 1e-7;
const MAX_ITERATIONS: usize = 60;
/// \[s\]; at 1 m/s a centimetre.
const SHORT_STEP: f64 = 0.01;

impl Robot {
    /// States that decide on the integrator's step: all that feed back in this run. The others are integrals of these.
    pub(crate) fn watched(&self, lag: bool) -> usize {
        if self.effects.remember() {
            ANGLES_AT
        } else if lag {
            MEMORY_AT
        } else if self.slides {
            LATERAL_SPEED + 1
        } else {
            LATERAL_SPEED
        }
    }

    /// Largest step \[s\] that passes over nothing the ground or an effect does on a short stretch of path or time: stones,
    /// gusts, changes of soil, ruts as wide as a wheel.
    pub(crate) fn longest_step(&self) -> f64 {
        let smooth = self.ruts.is_none()
            && !self.ground.changes()
            && self.effects.unlisted().next().is_none();
        if smooth { f64::INFINITY } else { SHORT_STEP }
    }

    /// The wheel as an off-library effect sees it.
    pub(crate) fn view(
        &self,
        wheel: usize,
        time: f64,
        y: &[f64; STATES],
        radius: f64,
        torque: f64,
    ) -> WheelView {
        WheelView {
            wheel,
            angle: y[ANGLES_AT + wheel],
            wheel_speed: y[WHEELS_AT + wheel],
            mate_speed: y[WHEELS_AT + (wheel ^ 1)],
            speed: y[SPEED],
            torque,
            radius,
            time,
            memory: 0.0,
        }
    }

    /// The view with what this effect remembers there.
    pub(crate) fn recall(view: &WheelView, memory: Option<usize>, y: &[f64; STATES]) -> WheelView {
        WheelView {
            memory: memory.map_or(0.0, |m| y[MEMORY_AT + 4 * m + view.wheel]),
            ..*view
        }
    }

    /// Places of the wheels in the plane \[m\].
    pub(crate) fn places(&self, y: &[f64; STATES], vehicle: &LoadedVehicle) -> [(f64, f64); 4] {
        let (sin, cos) = y[HEADING].sin_cos();
        std::array::from_fn(|q| {
            let (ahead, left) = vehicle.wheel(q);
            (
                y[POSITION] + cos * ahead - sin * left,
                y[POSITION + 1] + sin * ahead + cos * left,
            )
        })
    }

    /// The wheels stand there now; true when one left a rut, which changes what the others feel.
    pub(crate) fn leave_ruts(&mut self, y: &[f64; STATES], vehicle: &LoadedVehicle) -> bool {
        if self.ruts.is_none() {
            return false;
        }
        let places = self.places(y, vehicle);
        let left = self.ruts.as_mut().is_some_and(|ruts| ruts.step(places));
        if left {
            self.known = None;
        }
        left
    }

    /// Rates and forces at one instant.
    pub(crate) fn instant(
        &mut self,
        time: f64,
        y: &[f64; STATES],
        around: &Surroundings,
        control: &Control,
    ) -> Result<Instant, SimError> {
        if let Some((t, state, instant)) = &self.known
            && *t == time
            && state == y
        {
            return Ok(*instant);
        }
        self.ground.settle();
        let motor = control.torque(time, y);
        let coupled = around.vehicle.car.cg_height != 0.0 || self.effects.any_loads();
        let Warm {
            mut slope,
            mut aside,
            ..
        } = self.warm;
        let mut a = self.warm.expected(time);
        if !self.slides {
            aside = y[YAW_RATE] * y[SPEED] + around.vehicle.side_gravity();
        }
        let mut last: Option<((f64, f64), f64, Instant)> = None;
        for iteration in 0..MAX_ITERATIONS {
            let tolerance = if iteration < PATIENCE {
                TOLERANCE
            } else {
                LOOSE_TOLERANCE
            };
            let instant = self.at_acceleration(time, y, around, &motor, (a, aside))?;
            let residual = instant.specific_force - a;
            let side = instant.side_force - aside;
            if !(residual.is_finite() && side.is_finite()) {
                return Err(SimError::NotFinite { time });
            }
            let settled = residual.abs() <= tolerance * (1.0 + a.abs())
                && side.abs() <= tolerance * (1.0 + aside.abs());
            if !coupled || settled {
                return self.found(instant, slope, (time, y), control);
            }
            let mut step = -residual / slope;
            if let Some(((a_last, aside_last), residual_last, before)) = &last
                && a != *a_last
            {
                let secant = (residual - residual_last) / (a - a_last);
                // d(found)/da is well below 1 in size for any stable vehicle; outside that, plain substitution.
                let stable = (-2.0..=-0.3).contains(&secant);
                slope = if stable { secant } else { -1.0 };
                step = -residual / slope;
                let distances = step * (a + step - a_last);
                // Sideways, both ends of the chord must be at rest already.
                let level = side.abs().max((aside - aside_last).abs()) <= TOLERANCE;
                if stable && level && distances.abs() <= CHORD {
                    let share = step / (a - a_last);
                    let instant = instant.beyond(before, share);
                    return self.found(instant, slope, (time, y), control);
                }
            }
            last = Some(((a, aside), residual, instant));
            aside = instant.side_force;
            a += step;
        }
        let residual = last.map_or(f64::NAN, |(_, r, _)| r);
        self.warm = Warm::COLD;
        Err(SimError::LoadTransfer { time, residual })
    }

    /// Keeps an instant whose loads and accelerations agree.
    fn found(
        &mut self,
        mut instant: Instant,
        slope: f64,
        (time, y): (f64, &[f64; STATES]),
        control: &Control,
    ) -> Result<Instant, SimError> {
        let lifted = |wheel: &WheelState| wheel.normal_load <= 0.0;
        if let Some(wheel) = instant.wheels.iter().position(lifted) {
            return Err(SimError::WheelLift {
                time,
                wheel,
                load: instant.wheels[wheel].normal_load,
            });
        }
        let accelerations = (instant.specific_force, instant.side_force);
        self.warm.learn(time, slope, accelerations);
        control.rates(time, y, &mut instant.rate);
        self.known = Some((time, *y, instant));
        Ok(instant)
    }

    /// Forces at the loads of assumed specific forces; the specific forces they give are in the answer.
    fn at_acceleration(
        &mut self,
        time: f64,
        y: &[f64; STATES],
        around: &Surroundings,
        motor: &[f64; 4],
        (ahead, aside): (f64, f64),
    ) -> Result<Instant, SimError> {
        let vehicle = &around.vehicle;
        let car = &vehicle.car;
        let (v, r, vy) = (y[SPEED], y[YAW_RATE], y[LATERAL_SPEED]);
        let speeds = four(y, WHEELS_AT);
        let normal = vehicle.normal(ahead, aside);
        let places = self.ruts.is_some().then(|| self.places(y, vehicle));
        let mut rate = [0.0; STATES];
        let mut lost = [0.0; 4];
        let (shake, twist) = self.rough.at(time);
        let plain = self.effects.unlisted().next().is_none();

        let mut wheels = [WheelState::default(); 4];
        for (q, state) in wheels.iter_mut().enumerate() {
            let view = self.view(q, time, y, car.wheel_radius, motor[q]);
            let mut radius = car.wheel_radius;
            for (effect, e, memory) in self.effects.unlisted() {
                let at = Self::recall(&view, memory, y);
                radius *= effect.radius(e, &at);
                lost[q] += effect.loss(e, &at);
            }
            let right = q % 2 == 1;
            let x = vehicle.wheel(q).0;
            let motion = WheelMotion {
                wheel: q,
                travel_speed: v
                    + if right { 0.5 } else { -0.5 } * r * car.track
                    + vehicle.cg_left * r,
                lateral_speed: vy + r * x,
                slides: self.slides,
                wheel_speed: speeds[q],
                yaw_rate: r,
                path: y[PATH],
                time,
                normal_load: normal[q],
                radius,
                width: car.wheel_width,
                ahead: x,
                wheelbase: car.wheelbase,
                pass: around.pass,
                rut: places
                    .zip(self.ruts.as_ref())
                    .map(|(places, ruts)| ruts.passes(places[q])),
            };
            let (ground, effects) = (&mut self.ground, &self.effects);
            *state = motion.forces(&mut |contact| {
                if plain {
                    return ground.forces(q, y[PATH] + x, contact);
                }
                let changed = effects.unlisted().fold(*contact, |c, (effect, e, memory)| {
                    effect.contact(e, &Self::recall(&view, memory, y), c)
                });
                ground.forces(q, y[PATH] + x, &changed)
            })?;
            let model_pull = state.drawbar_pull;
            for (effect, e, memory) in self.effects.unlisted() {
                let at = Self::recall(&view, memory, y);
                state.drawbar_pull = effect.pull(e, &at, state.drawbar_pull);
                if let Some(m) = memory {
                    rate[MEMORY_AT + 4 * m + q] = effect.memory_rate(e, &at, model_pull);
                }
            }
            // Rough ground shakes a wheel that moves, not one that stands.
            let moving = (car.wheel_radius * speeds[q]).abs().max(v.abs()) / STANDSTILL_SPEED;
            let share = smooth_sign(moving);
            state.drawbar_pull += share * shake[q];
            state.resistive_torque += share * twist[q];
        }

        let dv = ahead - GRAVITY * car.pitch.sin();
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
        for (effect, e, _) in self.effects.unlisted() {
            let (force, moment) = effect.body(e, v, time);
            body.force_x += force;
            body.yaw_moment += moment;
        }
        let tow = around.tow_load * (v / STANDSTILL_SPEED).tanh();

        let [fl, fr, rl, rr] = wheels.map(|w| w.drawbar_pull);
        // Summed by axle so that a mirrored run is the mirror image to the last bit.
        let pull = (fl + fr) + (rl + rr);
        let specific_force = (pull + body.force_x - tow) / car.mass;
        let [yfl, yfr, yrl, yrr] = wheels.map(|w| w.lateral_force);
        let moment = 0.5 * car.track * ((fr + rr) - (fl + rl)) - car.yaw_damping * r
            + body.yaw_moment
            + (car.cg_to_front_axle * (yfl + yfr) - vehicle.rear_arm() * (yrl + yrr))
            + vehicle.cg_left * pull;

        rate[SPEED] = specific_force - GRAVITY * car.pitch.sin();
        let side_force = if self.slides {
            let found = ((yfl + yfr) + (yrl + yrr)) / car.mass;
            rate[SPEED] += r * vy;
            rate[LATERAL_SPEED] = found - vehicle.side_gravity() - r * v;
            found
        } else {
            aside
        };
        rate[YAW_RATE] = moment / car.yaw_inertia;
        for q in 0..4 {
            rate[WHEELS_AT + q] = (motor[q]
                - wheels[q].resistive_torque
                - car.wheel_damping * speeds[q]
                - body.wheel_torque[q]
                - lost[q])
                / car.wheel_inertia;
            rate[ANGLES_AT + q] = speeds[q];
        }
        rate[PATH] = v;
        let (sin, cos) = y[HEADING].sin_cos();
        rate[HEADING] = r;
        rate[POSITION] = v * cos - vy * sin;
        rate[POSITION + 1] = v * sin + vy * cos;
        Ok(Instant {
            rate,
            specific_force,
            side_force,
            motor_torque: *motor,
            wheels,
        })
    }
}
