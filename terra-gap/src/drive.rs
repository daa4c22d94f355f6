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
mod bend;
mod cells;
mod choice;
mod frame;
mod held;
mod own_noise;
mod read;
mod rounded;
mod spacing;
mod stance;
mod stream;
mod surface;
mod way;
mod window;

pub(crate) use bend::{BENT, bends, usual};
pub(crate) use cells::{Line, cells, declared, line};
pub(crate) use held::Held;
pub(crate) use own_noise::OwnNoise;
pub use read::DriveWindows;
pub(crate) use read::{all_windows, from_log, from_logs};
pub(crate) use spacing::wider;
pub(crate) use stream::{Slot, Stream, rows};
pub(crate) use window::{AGAINST_THE_MOTION, Reader, SERIES, Taken, channels, short_scatter};

use std::borrow::Borrow;
use std::ops::Range;
use std::sync::Arc;

use terra_model::{BodyLoads, Channel, Contact, LaneDual, Law, Motion, Scalar, Touch, Vehicle};

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::logs::of_log;
use crate::memory::Memory;
use crate::predictor::{Counts, Design, OtherWay, Predict, Sloped, Yielding};
use crate::sensor;
use frame::Frames;
pub(crate) use stance::lift;
use stance::{Factor, Stance};

/// g \[m/s²\].
pub(crate) const GRAVITY: f64 = 9.81;
/// Speed below which a window says nothing about slip \[m/s\], where the ground speed's noise is the usual .03 m/s.
pub(crate) const SPEED_GATE: f64 = 0.12;
/// The same by that noise: a slow rover's ground speed is measured better.
pub(crate) const NOISES: f64 = 4.0;

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

/// Entry angles of wheels \[rad\], where they are known.
#[derive(Clone, Copy)]
struct Entries<P, const WHEELS: usize = 4> {
    of: [Option<P>; WHEELS],
    /// Whether they were found for these very parameters.
    here: bool,
}

impl<P, const WHEELS: usize> Entries<P, WHEELS> {
    const fn unknown() -> Self {
        Entries {
            of: [const { None }; WHEELS],
            here: false,
        }
    }

    /// What the law gives a wheel, found from its entry angle a little elsewhere, which is then the one here.
    fn forces<T: Scalar<Primal = P>>(
        &mut self,
        law: &Law,
        p: &[T],
        wheel: usize,
        mut at: Contact<T>,
    ) -> Result<OnWheel<T>, GapError>
    where
        P: Copy,
    {
        at.near = self.of[wheel].map(T::from_primal);
        at.near_is_here = self.here;
        let forces = law.forces_under(p, &mut at)?;
        self.of[wheel] = forces.angles.map(|a| a.entry.primal());
        Ok(OnWheel {
            pull: forces.drawbar_pull,
            torque: forces.resistive_torque,
            aside: Some(forces.lateral_force),
        })
    }
}

/// Share of a wheel's load that goes to the other side in some window where it matters whether any does.
const LEANS: f64 = 0.002;
/// What is said of a diagnosis in which none does.
const UPRIGHT: &str = "explained best if no load goes to the outer wheels in turns, as in a simulator whose vehicle stays upright: a real one leans by its cg_height_m";

/// What the ground gives a wheel.
struct OnWheel<T> {
    pull: T,
    torque: T,
    /// Left positive; none: nothing acts sideways.
    aside: Option<T>,
}

/// What it gives a vehicle: torque at each wheel, force along the vehicle and moment about its centre.
struct Ground<T> {
    torque: [T; 4],
    force: T,
    moment: T,
}

impl<T: Scalar> Ground<T> {
    fn none() -> Self {
        Ground {
            torque: [T::zero(); 4],
            force: T::zero(),
            moment: T::zero(),
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
    /// What else it may be, where the log does not say.
    other_paths: [f64; way::OTHERS],
    time: f64,
    /// Times from its middle to those of the two windows that follow and of the one before \[s\].
    around: [f64; 3],
    /// How many of these there are, the first ones.
    known: usize,
    /// Number of its log.
    log: usize,
    /// Share of the load that goes to the outer wheels in turns and on a slope aside which does: 1, or 0 of a vehicle that stays
    /// upright.
    leaning: f64,
    /// Share of its load by which uneven ground loads the front left wheel and the one across more, and the other two less.
    swing: f64,
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
    leaning: T,
    swing: T,
    /// 1 where a yaw rate was read, 0 elsewhere.
    yaw_read: T,
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
            leaning: T::from(window.leaning),
            swing: T::from(window.swing),
            yaw_read: T::from(window.yaw_read()),
            forwards: window.forwards(),
        }
    }
}

impl<T: Scalar> Given<T> {
    /// In another scalar.
    fn map<S>(&self, of: impl Fn(T) -> S) -> Given<S> {
        Given {
            pitch: of(self.pitch),
            sin_roll: of(self.sin_roll),
            cos_roll: of(self.cos_roll),
            payload: of(self.payload),
            earlier_passes: of(self.earlier_passes),
            path: of(self.path),
            time: of(self.time),
            around: self.around.map(&of),
            leaning: of(self.leaning),
            swing: of(self.swing),
            yaw_read: of(self.yaw_read),
            forwards: self.forwards,
        }
    }
}

impl Window {
    fn forwards(&self) -> bool {
        self.raw[SPEED] >= 0.0
    }

    /// 1 where a yaw rate was read, 0 elsewhere.
    fn yaw_read(&self) -> f64 {
        f64::from(u8::from(self.measured.contains(&YAW_ACCELERATION)))
    }
}

/// Predicts windows of a drive log.
#[derive(Clone, Debug)]
pub(crate) struct DrivePredictor {
    vehicle: Vehicle<f64>,
    windows: Vec<Window>,
    /// How many logs have a soil of their own.
    soils: usize,
    /// Whether each axle that rolled over a track is a pass of its own.
    by_axles: bool,
    frames: Frames,
}

impl DrivePredictor {
    /// `soils`: how many logs have a soil of their own.
    pub(crate) fn new(vehicle: Vehicle<f64>, windows: Vec<Window>, soils: usize) -> Self {
        DrivePredictor {
            vehicle,
            windows,
            soils,
            by_axles: false,
            frames: Frames::default(),
        }
    }

    /// What the ground gives a vehicle, whose numbers may be constants. `on_wheel`: what it gives a wheel, by its number.
    fn ground<T: Scalar, S: Factor<T>>(
        stance: &Stance<S>,
        mut on_wheel: impl FnMut(usize) -> Result<OnWheel<T>, GapError>,
    ) -> Result<Ground<T>, GapError> {
        let mut ground = Ground::none();
        let half_track = stance.vehicle.track * 0.5;
        let mut pull = [T::zero(); 4];
        for (q, pull) in pull.iter_mut().enumerate() {
            let forces = on_wheel(q)?;
            *pull = stance.direction[q].times(&forces.pull);
            if let Some(aside) = forces.aside {
                ground.moment += stance.ahead(q).times(&aside);
            }
            ground.torque[q] = stance.direction[q].times(&forces.torque);
        }
        ground.force = pull[0] + pull[1] + pull[2] + pull[3];
        ground.moment += half_track.times(&(pull[1] + pull[3] - pull[0] - pull[2]));
        Ok(ground)
    }

    /// Adds a share of what the sensors tell of a stance on ground that gives so much: in place, as numbers with slopes are long to
    /// copy.
    fn add_told<T: Scalar, S: Factor<T>>(
        told: &mut [T; VALUES],
        share: T::Primal,
        (law, p): (&Law, &[T]),
        given: &Given<S>,
        stance: &Stance<S>,
        ground: Ground<T>,
    ) {
        let vehicle = &stance.vehicle;
        let Ground {
            mut torque,
            mut force,
            mut moment,
        } = ground;
        for (q, torque) in torque.iter_mut().enumerate() {
            let own = vehicle.wheel_inertia * stance.wheel_rate[q]
                + vehicle.wheel_damping * stance.wheel[q];
            *torque += own.lifted();
        }
        moment -= (vehicle.yaw_damping * stance.yaw_rate).lifted();
        let mut delivered = torque;
        if law.acts(Touch::Loads) {
            let motion = Motion {
                speed: stance.speed.lifted(),
                acceleration: stance.acceleration.lifted(),
                yaw_rate: stance.yaw_rate.lifted(),
                wheel_speed: stance.wheel.map(S::lifted),
                wheel_torque: torque,
                path: given.path.lifted(),
                time: given.time.lifted(),
            };
            let vehicle = lift(vehicle, S::lifted);
            let loads = law
                .acting(p, Touch::Loads)
                .fold(BodyLoads::none(), |loads, (effect, e)| {
                    T::of_effect(&**effect).loads_at(e, &vehicle, &motion, loads)
                });
            force += loads.force_x;
            moment += loads.yaw_moment;
            for (delivered, load) in delivered.iter_mut().zip(loads.wheel_torque) {
                *delivered += load;
            }
        }
        let felt = (S::one() / vehicle.mass).times(&force);
        let zero = T::zero();
        let mut tell = |k: usize, value: &T| told[k].add_scaled(value, share);
        for (q, delivered) in delivered.into_iter().enumerate() {
            let reported = sensor::report(law, p, Channel::WheelTorque, delivered, zero);
            tell(TORQUE + q, &reported);
        }
        tell(ACCEL, &sensor::report(law, p, Channel::AccelX, felt, zero));
        let quicker = stance.speed_gain.times(&(felt - stance.climbing.lifted()));
        tell(SPEED_RATE, &(quicker - stance.quicker.lifted()));
        let turning = (stance.yaw_gain / vehicle.yaw_inertia).times(&moment);
        tell(YAW_ACCELERATION, &turning);
    }

    /// Their mean over stances at so many times. `on_wheel`: what the ground gives a wheel, by the number of the time and its own.
    fn mean_readings<T: Scalar, S: Factor<T>, B: Borrow<Stance<S>>>(
        law: &Law,
        p: &[T],
        given: &Given<S>,
        times: usize,
        stance: impl Fn(usize) -> B,
        mut on_wheel: impl FnMut(usize, usize, &Stance<S>) -> Result<OnWheel<T>, GapError>,
    ) -> Result<[T; VALUES], GapError> {
        let mut mean = [T::zero(); VALUES];
        let share = T::from(1.0 / times as f64).primal();
        for time in 0..times {
            // Where it is built it stays: it is long to move.
            let stance = stance(time);
            let stance = stance.borrow();
            stance.turns_with_its_motion()?;
            let ground = Self::ground(stance, |q| on_wheel(time, q, stance))?;
            Self::add_told(&mut mean, share, (law, p), given, stance, ground);
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

    fn yielding(&self, index: usize) -> Vec<Yielding> {
        // Wheels are held at their speed by a motor.
        let inertia = self.windows[index].around[0].recip();
        let body = [
            (SPEED, ACCEL),
            (SPEED, SPEED_RATE),
            (YAW_RATE, YAW_ACCELERATION),
        ];
        let of = |(raw, value)| Yielding {
            raw,
            value,
            inertia,
        };
        body.map(of).into()
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
        let given = Given::from(window);
        let stance = |time: usize| {
            let offset = T::from(window.nodes[time]);
            Stance::of(&self.vehicle, law, p, &given, raw, offset)
        };
        let near = &mut [const { Entries::<T::Primal>::unknown() }; NODES];
        let on_wheel = |time: usize, q, stance: &Stance<T>| {
            near[time].forces(law, p, q, stance.contact(q, &given))
        };
        let times = window.nodes.len();
        let predicted = Self::mean_readings(law, p, &given, times, stance, on_wheel)?;
        Ok(window
            .measured
            .iter()
            .map(|&k| raw[k] - predicted[k])
            .collect())
    }

    fn contacts(&self) -> usize {
        surface::places(self.windows.len()).end
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

    fn otherwise_loaded(&self) -> Option<Self> {
        let (h, track) = (self.vehicle.cg_height, self.vehicle.track);
        let leans = |w: &Window| {
            let aside = w.raw[SPEED] * w.raw[YAW_RATE] + w.roll.sin() * GRAVITY;
            (2.0 * h * aside / (GRAVITY * track)).abs() > LEANS
        };
        let mut out = self.clone();
        for window in &mut out.windows {
            window.leaning = 1.0 - window.leaning;
        }
        self.windows.iter().any(leans).then_some(out)
    }

    fn swung(&self, swings: &[f64]) -> Option<Self> {
        let mut out = self.clone();
        for (window, swing) in out.windows.iter_mut().zip(swings) {
            window.swing = *swing;
        }
        Some(out)
    }

    fn assumes(&self) -> Option<&'static str> {
        let upright = |w: &Window| w.leaning == 0.0;
        self.windows.first().is_some_and(upright).then_some(UPRIGHT)
    }

    fn other_ways(&self) -> Vec<OtherWay> {
        let mut ways: Vec<Vec<f64>> = vec![self.windows.iter().map(|w| w.path).collect()];
        let mut out = vec![];
        for (k, told) in way::TOLD.into_iter().enumerate() {
            let path: Vec<f64> = self.windows.iter().map(|w| w.other_paths[k]).collect();
            if ways.iter().any(|known| way::are_one(known, &path)) {
                continue;
            }
            let mut predictor = self.clone();
            for (window, &path) in predictor.windows.iter_mut().zip(&path) {
                (window.path, window.other_paths) = (path, [path; way::OTHERS]);
            }
            let counts = if k < way::ODOMETERS {
                Counts::Odometer(path.clone())
            } else {
                Counts::Position(path.clone())
            };
            out.push(OtherWay {
                told,
                counts,
                predictor: Arc::new(predictor),
            });
            ways.push(path);
        }
        if self.windows.iter().any(|w| w.earlier_passes > 0.0) && !self.by_axles {
            let mut predictor = self.clone();
            predictor.by_axles = true;
            for window in &mut predictor.windows {
                window.earlier_passes *= way::AXLES;
            }
            out.push(OtherWay {
                told: way::BY_AXLES,
                counts: Counts::Passes,
                predictor: Arc::new(predictor),
            });
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
