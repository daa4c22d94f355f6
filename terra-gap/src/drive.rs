//! Drive logs: inverse dynamics over windows.
//!
//! Measured motion in (speed, yaw rate, wheel speeds and their derivatives), predicted readings out: the four wheel
//! torques, specific force, and the derivatives of speed and yaw rate. The truth simulator integrates forward and
//! shares none of this.
//!
//! # Equation
//! T_q = I_w ω_q' + T_r,q + b_w ω_q + drivetrain losses;  a_x = (Σ D + F_x)/m;  v' = a_x - g sin(pitch);
//! r' = ((t_w/2)(D_right - D_left) + Σ x F_y - M_res r + M_z)/I_zz.
//!
//! Loads: N_f = m (g' l_r - h a_x)/(2 L) a front wheel, N_r likewise, g' = g cos(pitch) cos(roll); a turn and a side slope
//! move load to the right wheels, N (1 + 2 h a_y/(g' t_w)), with a_y = v r + g cos(pitch) sin(roll): the vehicle does not
//! drift. A wheel x ahead of the centre then has the slip angle atan(x r/|v|).
//!
//! A ground speed that is e late: v(t) = u(t + e) with u as logged, between the windows around ([`ahead`]); one that follows with a
//! time constant e: v = u + e u'.

mod abreast;
mod ahead;
mod cells;
mod choice;
mod held;
mod own_noise;
mod read;
mod stream;
mod window;

pub(crate) use cells::{Line, declared, line};
pub use read::DriveWindows;
pub(crate) use read::{all_windows, from_log, from_logs};
pub(crate) use stream::{Slot, Stream};
pub(crate) use window::{BENT, Reader, SERIES, Taken, bends, channels, short_scatter, usual};

use std::ops::Range;
use std::sync::Arc;

use terra_model::{
    BodyLoads, Channel, Contact, LaneDual, Late, Law, ModelError, Motion, Root, Scalar, Touch,
    Vehicle, library_slip,
};

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::logs::of_log;
use crate::memory::Memory;
use crate::predictor::{Design, Predict, Sloped};
use crate::sensor;
use ahead::Behind;

/// g \[m/s²\].
pub(crate) const GRAVITY: f64 = 9.81;
/// Speeds below which a window says nothing about slip \[m/s\].
pub(crate) const SPEED_GATE: f64 = 0.12;

/// Values of a window, in order: torques, specific force, v', r'.
const TORQUE: usize = 0;
const ACCEL: usize = 4;
const SPEED_RATE: usize = 5;
const YAW_ACCELERATION: usize = 6;
const VALUES: usize = 7;
/// Inputs behind the values: v, r, four ω, four ω', and v of the two windows that follow and of the one
/// before.
const SPEED: usize = 7;
const YAW_RATE: usize = 8;
const WHEEL: usize = 9;
const WHEEL_RATE: usize = 13;
const AROUND: usize = 17;
const RAW: usize = 20;
/// Most times in a window at which forces are evaluated.
const NODES: usize = 2;

/// Entry angles of four wheels \[rad\], where they are known.
#[derive(Clone, Copy)]
struct Entries<P> {
    of: [Option<P>; 4],
    /// Whether they were found for these very parameters.
    here: bool,
}

impl<P> Entries<P> {
    const fn unknown() -> Self {
        Entries {
            of: [const { None }; 4],
            here: false,
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Window {
    raw: [f64; RAW],
    /// Which of the seven values were measured.
    measured: Vec<usize>,
    /// Times from its middle at which forces are evaluated \[s\]: their mean is not the force of the mean motion where slip
    /// changes within the window.
    nodes: Vec<f64>,
    pitch: f64,
    roll: f64,
    payload: f64,
    earlier_passes: f64,
    path: f64,
    time: f64,
    /// Times from its middle to those of the two windows that follow and of the one before \[s\].
    around: [f64; 3],
    /// How many of these there are, the first ones.
    known: usize,
    /// Number of its log.
    log: usize,
}

/// What a window is given beside its raw quantities, in the scalar of its readings.
struct Given<T> {
    pitch: T,
    sin_roll: T,
    cos_roll: T,
    payload: T,
    earlier_passes: T,
    path: T,
    time: T,
    around: [T; 3],
    forwards: bool,
}

impl<T: Scalar> From<&Window> for Given<T> {
    fn from(window: &Window) -> Self {
        let (sin, cos) = window.roll.sin_cos();
        Given {
            pitch: T::from(window.pitch),
            sin_roll: T::from(sin),
            cos_roll: T::from(cos),
            payload: T::from(window.payload),
            earlier_passes: T::from(window.earlier_passes),
            path: T::from(window.path),
            time: T::from(window.time),
            around: window.around.map(T::from),
            forwards: window.forwards(),
        }
    }
}

impl Window {
    fn forwards(&self) -> bool {
        self.raw[SPEED] >= 0.0
    }
}

/// The speed over ground, and how it changes, behind what its sensor says.
struct GroundSpeed<T> {
    speed: T,
    acceleration: T,
    /// Of the sensor.
    gain: T,
    /// What the logged rate gains by the sensor's delay.
    quicker: T,
}

impl<T: Scalar> GroundSpeed<T> {
    fn of(law: &Law, p: &[T], given: &Given<T>, raw: &[T], offset: T) -> Self {
        let rate = raw[SPEED_RATE];
        let logged = raw[SPEED] + rate * offset;
        if !law.acts(Touch::Sensor) {
            return GroundSpeed {
                speed: logged,
                acceleration: rate,
                gain: T::one(),
                quicker: T::zero(),
            };
        }
        let channel = Channel::GroundSpeed;
        let behind = |late| sensor::behind(law, p, channel, raw[SPEED], late);
        let late = Behind {
            delay: behind(Late::Shifted),
            constant: behind(Late::Following),
        };
        let (gained, quicker) = ahead::gained(raw, &given.around, offset, late);
        let reported = logged + gained;
        let gain = sensor::gain(law, p, channel, reported);
        GroundSpeed {
            speed: sensor::truth(law, p, channel, reported),
            acceleration: (rate + quicker) / gain,
            gain,
            quicker,
        }
    }
}

/// Predicts windows of a drive log.
#[derive(Clone, Debug)]
pub(crate) struct DrivePredictor {
    vehicle: Vehicle<f64>,
    windows: Vec<Window>,
    /// How many logs have a soil of their own.
    soils: usize,
}

impl DrivePredictor {
    /// `soils`: how many logs have a soil of their own.
    pub(crate) fn new(vehicle: Vehicle<f64>, windows: Vec<Window>, soils: usize) -> Self {
        DrivePredictor {
            vehicle,
            windows,
            soils,
        }
    }

    /// Predicted readings `offset` seconds from the window's middle, on its straight line of motion. `near`: the wheels' entry
    /// angles a little elsewhere, then here.
    fn readings<T: Scalar>(
        &self,
        law: &Law,
        p: &[T],
        given: &Given<T>,
        raw: &[T],
        offset: T,
        near: &mut Entries<T::Primal>,
    ) -> Result<[T; VALUES], GapError> {
        let mut vehicle = lift(&self.vehicle);
        vehicle.pitch = given.pitch;
        for (effect, e) in law.acting(p, Touch::Vehicle) {
            vehicle = T::of_effect(&**effect).vehicle_at(e, vehicle);
        }
        // The operator weighed the payload; an error of the file's mass does not scale it.
        vehicle.mass += given.payload;
        let GroundSpeed {
            speed,
            acceleration,
            gain: speed_gain,
            quicker,
        } = GroundSpeed::of(law, p, given, raw, offset);
        let yaw_rate = raw[YAW_RATE] + raw[YAW_ACCELERATION] * offset;
        let wheel: [T; 4] = std::array::from_fn(|q| raw[WHEEL + q] + raw[WHEEL_RATE + q] * offset);

        let (sin, cos) = vehicle.pitch.sin_cos();
        let specific = acceleration + sin * GRAVITY;
        let pressing = cos * given.cos_roll * GRAVITY;
        let to_rear = vehicle.wheelbase - vehicle.cg_to_front_axle;
        let transfer = vehicle.cg_height * specific;
        let share = vehicle.mass / (vehicle.wheelbase * 2.0);
        let front = share * (to_rear * pressing - transfer);
        let rear = share * (vehicle.cg_to_front_axle * pressing + transfer);
        let aside = speed * yaw_rate + cos * given.sin_roll * GRAVITY;
        let lean = vehicle.cg_height * aside * 2.0 / (pressing * vehicle.track);

        let mut pull = [T::zero(); 4];
        let mut torque = [T::zero(); 4];
        let mut side_moment = T::zero();
        for q in 0..4 {
            let left = q % 2 == 0;
            let arm = vehicle.track * if left { -0.5 } else { 0.5 };
            let ahead = if q < 2 {
                vehicle.cg_to_front_axle
            } else {
                -to_rear
            };
            let travel = speed + yaw_rate * arm;
            let rim = wheel[q] * vehicle.wheel_radius;
            if (rim * travel).primal().any_lt(T::zero().primal()) {
                return Err(GapError::Model(ModelError::Contact {
                    quantity: "rim speed times travel speed",
                    value: (rim * travel).primal().min_lane(),
                    expected: "a wheel that turns with its motion",
                }));
            }
            // In reverse the wheel meets the same soil mirrored: magnitudes in, signs out.
            let direction = rim.select_lt(T::zero(), -T::one(), T::one());
            let leaning = if left { T::one() - lean } else { lean + 1.0 };
            let load = if q < 2 { front } else { rear } * leaning;
            let mut at = Contact::new(
                library_slip(rim, travel),
                load,
                vehicle.wheel_radius,
                vehicle.wheel_width,
            );
            at.speed = travel;
            at.wheel_speed = wheel[q];
            at.yaw_rate = yaw_rate;
            at.wheelbase = vehicle.wheelbase;
            at.slip_angle = (ahead * yaw_rate / travel.abs()).atan();
            at.path = given.path;
            at.time = given.time;
            at.side = T::from(if left { -1.0 } else { 1.0 });
            // In reverse the rear axle leads, and the front axle runs in its rut.
            let leads = (q < 2) == given.forwards;
            at.earlier_passes = given.earlier_passes + if leads { 0.0 } else { 1.0 };
            at.near = near.of[q].map(T::from_primal);
            at.near_is_here = near.here;
            let forces = law.forces_under(p, &mut at)?;
            near.of[q] = forces.angles.map(|a| a.entry.primal());
            pull[q] = forces.drawbar_pull * direction;
            side_moment += ahead * forces.lateral_force;
            torque[q] = vehicle.wheel_inertia * raw[WHEEL_RATE + q]
                + forces.resistive_torque * direction
                + vehicle.wheel_damping * wheel[q];
        }
        let motion = Motion {
            speed,
            acceleration,
            yaw_rate,
            wheel_speed: wheel,
            wheel_torque: torque,
            path: given.path,
            time: given.time,
        };
        let loads = law
            .acting(p, Touch::Loads)
            .fold(BodyLoads::none(), |loads, (effect, e)| {
                T::of_effect(&**effect).loads_at(e, &vehicle, &motion, loads)
            });
        let force = pull[0] + pull[1] + pull[2] + pull[3] + loads.force_x;
        let felt = force / vehicle.mass;
        let turning = ((pull[1] + pull[3] - pull[0] - pull[2]) * vehicle.track * 0.5 + side_moment
            - vehicle.yaw_damping * yaw_rate
            + loads.yaw_moment)
            / vehicle.yaw_inertia;

        let zero = T::zero();
        let mut predicted = [zero; VALUES];
        for q in 0..4 {
            let delivered = torque[q] + loads.wheel_torque[q];
            predicted[TORQUE + q] = sensor::report(law, p, Channel::WheelTorque, delivered, zero);
        }
        predicted[ACCEL] = sensor::report(law, p, Channel::AccelX, felt, zero);
        predicted[SPEED_RATE] = (felt - sin * GRAVITY) * speed_gain - quicker;
        predicted[YAW_ACCELERATION] = turning;
        Ok(predicted)
    }
}

impl DrivePredictor {
    /// Their mean over times from the window's middle, each with the entry angles of [`readings`](Self::readings).
    fn mean_readings<T: Scalar>(
        &self,
        law: &Law,
        p: &[T],
        given: &Given<T>,
        raw: &[T],
        offsets: impl ExactSizeIterator<Item = T>,
        near: &mut [Entries<T::Primal>; NODES],
    ) -> Result<[T; VALUES], GapError> {
        let mut mean = [T::zero(); VALUES];
        let share = 1.0 / offsets.len() as f64;
        for (offset, near) in offsets.zip(near) {
            let there = self.readings(law, p, given, raw, offset, near)?;
            for (sum, value) in mean.iter_mut().zip(there) {
                *sum += value * share;
            }
        }
        Ok(mean)
    }
}

impl Predict for DrivePredictor {
    fn raw(&self, index: usize) -> Vec<f64> {
        self.windows[index].raw.to_vec()
    }

    fn read(&self, index: usize) -> usize {
        AROUND + self.windows[index].known
    }

    fn residual<T: Scalar>(
        &self,
        law: &Law,
        p: &[T],
        index: usize,
        raw: &[T],
    ) -> Result<Vec<T>, GapError> {
        let window = &self.windows[index];
        let p = &*of_log(law, p, self.soils, window.log);
        let offsets = window.nodes.iter().map(|&offset| T::from(offset));
        let near = &mut [const { Entries::unknown() }; NODES];
        let predicted = self.mean_readings(law, p, &Given::from(window), raw, offsets, near)?;
        Ok(window
            .measured
            .iter()
            .map(|&k| raw[k] - predicted[k])
            .collect())
    }

    fn contacts(&self) -> usize {
        self.windows.len() * NODES * 4
    }

    fn residuals(
        &self,
        law: &Law,
        p: &[f64],
        indices: &[usize],
        memory: &Memory,
    ) -> Result<Vec<Vec<f64>>, GapError> {
        abreast::residuals(self, law, p, indices, memory)
    }

    fn slopes(
        &self,
        law: &Law,
        p: &[LaneDual],
        varied: &Range<usize>,
        indices: &[usize],
        memory: &Memory,
    ) -> Result<Vec<Vec<Sloped>>, GapError> {
        abreast::slopes(self, law, p, varied, indices, memory)
    }

    fn value_positions(&self, index: usize) -> Vec<usize> {
        self.windows[index].measured.clone()
    }

    fn with_raw(&self, replaced: &[(usize, Vec<f64>)]) -> Self {
        let mut out = self.clone();
        for (index, raw) in replaced {
            out.windows[*index].raw.copy_from_slice(raw);
        }
        out
    }

    fn designs(&self, data: &DataSet) -> Vec<Design> {
        let vehicle = self.vehicle;
        let mut designs = vec![];
        let mut vary = |manoeuvre: &str, change: &dyn Fn(usize, &mut Window)| {
            let mut predictor = self.clone();
            predictor
                .windows
                .iter_mut()
                .enumerate()
                .for_each(|(i, w)| change(i, w));
            designs.push(Design {
                manoeuvre: manoeuvre.to_owned(),
                data: data.clone(),
                predictor: Arc::new(predictor),
            });
        };
        let motion = [SPEED, YAW_RATE, WHEEL, WHEEL + 1, WHEEL + 2, WHEEL + 3];
        vary("the same manoeuvres in reverse", &|_, w| {
            motion.iter().for_each(|&k| w.raw[k] = -w.raw[k])
        });
        vary(
            "the same manoeuvres with 20 % payload at the centre of mass",
            &|_, w| {
                w.payload += 0.2 * vehicle.mass;
            },
        );
        vary("the same manoeuvres up and down a slope of 5°", &|i, w| {
            w.pitch += if i % 2 == 0 {
                5f64.to_radians()
            } else {
                -5f64.to_radians()
            };
        });
        vary("the same manoeuvres at twice the speed", &|_, w| {
            motion.iter().for_each(|&k| w.raw[k] *= 2.0)
        });
        vary("the same manoeuvres once more in their own rut", &|_, w| {
            w.earlier_passes += 1.0
        });
        vary(
            "front and rear axles at different speeds (slip .4 against -.2)",
            &|_, w| {
                let rim = w.raw[SPEED] / vehicle.wheel_radius;
                for q in 0..4 {
                    w.raw[WHEEL + q] = if q < 2 { rim / 0.6 } else { rim * 0.8 };
                }
            },
        );
        vary("turning at 0.5 rad/s", &|_, w| {
            w.raw[YAW_RATE] = 0.5;
            for q in 0..4 {
                let arm = if q % 2 == 0 { -0.5 } else { 0.5 } * vehicle.track;
                w.raw[WHEEL + q] *= ((w.raw[SPEED] + 0.5 * arm) / w.raw[SPEED]).max(0.1);
            }
        });
        vary("every manoeuvre once more, as it was", &|_, _| {});
        designs
    }
}

pub(crate) fn lift<T: Scalar>(v: &Vehicle<f64>) -> Vehicle<T> {
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

/// A robot for the tests of windows.
#[cfg(test)]
pub(crate) const ROVER: &str = r#"
[vehicle]
mass_kg = 100.0
yaw_inertia_kg_m2 = 10.0
track_m = 0.6
wheelbase_m = 0.6
cg_to_front_axle_m = 0.3
cg_height_m = 0.2
yaw_damping_N_m_s = 8.0

[wheel]
radius_m = 0.25
width_m = 0.15
inertia_kg_m2 = 0.25
damping_N_m_s = 0.1

[terrain]
model = "wong-reece"
start = "dry_sand"

[noise]
wheel_speed_rad_s = 0.02
wheel_torque_N_m = 0.5
ground_speed_m_s = 0.03
yaw_rate_rad_s = 0.01
"#;
