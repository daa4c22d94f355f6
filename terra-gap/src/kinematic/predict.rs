//! What the motion should be, from the wheel speeds.

use std::sync::Arc;

use terra_model::{Channel, Contact, Effect, Law, Scalar, Soil, Vehicle};

use super::effects::{DRAG, SKID};
use super::form::{MotionError, factors};
use crate::dataset::DataSet;
use crate::drive::{GRAVITY, lift};
use crate::error::GapError;
use crate::logs::of_log;
use crate::predictor::{Design, Predict};
use crate::sensor;

/// Values of a window: v, r, v_y.
pub(crate) const SPEED: usize = 0;
pub(crate) const YAW_RATE: usize = 1;
pub(crate) const LATERAL: usize = 2;
pub(crate) const VALUES: usize = 3;
/// Inputs behind the values: four ω, four ω'.
pub(crate) const WHEEL: usize = 3;
pub(crate) const WHEEL_RATE: usize = 7;
pub(crate) const RAW: usize = 11;

/// Motion resistance over sliding friction of a tyre.
const RESISTANCE: f64 = 0.1;
/// Speed over which the resistance to sideways sliding changes its direction \[m/s\].
const REVERSAL: f64 = 0.05;

#[derive(Clone, Debug)]
pub(crate) struct Window {
    pub(crate) raw: [f64; RAW],
    /// Which of the three values were measured.
    pub(crate) measured: Vec<usize>,
    /// Nose up \[rad\].
    pub(crate) pitch: f64,
    pub(crate) path: f64,
    pub(crate) time: f64,
    /// Number of its log.
    pub(crate) log: usize,
}

/// Predicts ground speed, yaw rate and lateral speed of windows from their wheel speeds.
#[derive(Clone, Debug)]
pub struct KinematicPredictor {
    pub(crate) vehicle: Vehicle<f64>,
    pub(crate) windows: Vec<Window>,
    /// How many logs have a ground of their own.
    pub(crate) soils: usize,
}

/// Speed of each side and the yaw rate they make.
pub(crate) struct Sides<T> {
    pub(crate) left: T,
    pub(crate) right: T,
}

impl KinematicPredictor {
    fn sides<T: Scalar>(
        &self,
        law: &Law,
        p: &[T],
        vehicle: &Vehicle<T>,
        window: &Window,
        slips: &[T; 4],
        wheel: &[T],
    ) -> Sides<T> {
        let load = vehicle.mass * (GRAVITY / 4.0);
        let mut side = [T::zero(); 2];
        for (q, (w, &slip)) in wheel.iter().zip(slips).enumerate() {
            let mut at = Contact::new(slip, load, vehicle.wheel_radius, vehicle.wheel_width);
            at.wheel_speed = *w;
            at.speed = *w * vehicle.wheel_radius;
            let front = vehicle.cg_to_front_axle;
            at.ahead = if q < 2 {
                front
            } else {
                front - vehicle.wheelbase
            };
            at.wheelbase = vehicle.wheelbase;
            at.path = T::from(window.path);
            at.time = T::from(window.time);
            at.side = T::from(if q % 2 == 0 { -1.0 } else { 1.0 });
            for (effect, e) in law.parts(p).1 {
                at = T::of_effect(&**effect).before_at(e, &Soil::unknown(), at);
            }
            side[q % 2] += *w * at.radius * (T::one() - slip / at.hooks.stiffness) * 0.5;
        }
        let [left, right] = side;
        Sides { left, right }
    }

    /// The ground's parameters.
    fn ground<T: Scalar>(&self, law: &Law, p: &[T]) -> [T; 4] {
        let (ground, _) = law.parts(p);
        std::array::from_fn(|k| ground.get(k).copied().unwrap_or_else(T::zero))
    }

    /// Slip of every wheel under nominal ground: more where it pushes the vehicle the way it turns, less where it holds it back.
    fn slips<T: Scalar>(&self, law: &Law, p: &[T], window: &Window, raw: &[T]) -> [T; 4] {
        let [slip, compliance, bend, _] = self.ground(law, p);
        let rates = &raw[WHEEL_RATE..RAW];
        let sum = rates.iter().fold(T::zero(), |sum, rate| sum + *rate);
        let pushed = sum * (0.25 * self.vehicle.wheel_radius / GRAVITY) + window.pitch.sin();
        let hard = pushed.select_lt(T::zero(), -pushed, pushed);
        let more = compliance * pushed * (bend * hard + 1.0);
        std::array::from_fn(|q| slip + raw[WHEEL + q].select_lt(T::zero(), -more, more))
    }

    /// Rim speeds of a window, left and right.
    fn sides_of(&self, window: &Window) -> [f64; 2] {
        let rim = |q: usize| window.raw[WHEEL + q] * self.vehicle.wheel_radius;
        [0.5 * (rim(0) + rim(2)), 0.5 * (rim(1) + rim(3))]
    }

    /// v, r, v_y, of the vehicle itself.
    fn motion<T: Scalar>(
        &self,
        law: &Law,
        p: &[T],
        window: &Window,
        slips: &[T; 4],
        wheel: &[T],
    ) -> [T; VALUES] {
        let mut vehicle: Vehicle<T> = lift(&self.vehicle, T::from);
        let mut drag = T::zero();
        let (mut of_speed, mut of_yaw) = (T::one(), T::one());
        for (effect, e) in law.parts(p).1 {
            vehicle = T::of_effect(&**effect).vehicle_at(e, vehicle);
            if effect.name() == MotionError::NAME {
                (of_speed, of_yaw) = factors(e, self.sides_of(window));
            }
            if effect.name() == SKID && effect.form() == DRAG {
                drag = e.first().copied().unwrap_or_else(T::zero) * RESISTANCE;
            }
        }
        let Sides { left, right } = self.sides(law, p, &vehicle, window, slips, wheel);
        let (mean, difference) = ((left + right) * 0.5, right - left);
        let yaw = difference / vehicle.track * of_yaw;
        let ahead = vehicle.wheelbase * 0.5 - vehicle.cg_to_front_axle;
        let along = (mean * (1.0 / REVERSAL)).tanh();
        let speed = (mean - drag * difference.abs() * along) * of_speed;
        [speed, yaw, ahead * yaw]
    }
}

impl Predict for KinematicPredictor {
    fn raw(&self, index: usize) -> Vec<f64> {
        self.windows[index].raw.to_vec()
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
        let slips = &self.slips(law, p, window, raw);
        let [speed, yaw, lateral] = self.motion(law, p, window, slips, &raw[WHEEL..WHEEL_RATE]);
        let [rate, ..] = self.motion(law, p, window, slips, &raw[WHEEL_RATE..RAW]);
        let speed = speed - self.ground(law, p)[3] * rate;
        let predicted = [
            sensor::report(law, p, Channel::GroundSpeed, speed, rate),
            sensor::report(law, p, Channel::YawRate, yaw, T::zero()),
            lateral,
        ];
        Ok(window
            .measured
            .iter()
            .map(|&k| raw[k] - predicted[k])
            .collect())
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
        let mut designs = vec![];
        let mut vary = |manoeuvre: &str, change: &dyn Fn(&mut [f64; RAW])| {
            let mut predictor = self.clone();
            predictor
                .windows
                .iter_mut()
                .for_each(|w| change(&mut w.raw));
            designs.push(Design {
                manoeuvre: manoeuvre.to_owned(),
                data: data.clone(),
                predictor: Arc::new(predictor),
            });
        };
        vary("every manoeuvre once more, as it was", &|_| {});
        vary("the same manoeuvres at twice the speed", &|raw| {
            raw[WHEEL..].iter_mut().for_each(|w| *w *= 2.0);
        });
        vary("the same manoeuvres in reverse", &|raw| {
            raw[WHEEL..].iter_mut().for_each(|w| *w = -*w);
        });
        vary("turning in place both ways", &|raw| {
            for q in 0..4 {
                let w = raw[WHEEL + q].abs().max(raw[WHEEL + (q ^ 1)].abs());
                raw[WHEEL + q] = if q % 2 == 0 { -w } else { w };
            }
        });
        vary("straight runs, forward and back", &|raw| {
            for axle in [0, 2] {
                let mean = 0.5 * (raw[WHEEL + axle] + raw[WHEEL + axle + 1]);
                raw[WHEEL + axle] = mean;
                raw[WHEEL + axle + 1] = mean;
            }
        });
        designs
    }
}
