//! How a vehicle stands on its wheels at one moment of a window: what its sensors say, turned into slips and loads.

use terra_model::{
    Channel, Contact, LaneDual, Lanes, Late, Law, ModelError, Real, Root, Scalar, Touch, Vehicle,
    library_slip,
};

use super::ahead::{self, Behind};
use super::{GRAVITY, Given, SPEED, SPEED_RATE, WHEEL, WHEEL_RATE, YAW_ACCELERATION, YAW_RATE};
use crate::error::GapError;
use crate::sensor;

/// Motion, slips and loads at one moment.
pub(super) struct Stance<T> {
    /// As effects make it, with its payload.
    pub(super) vehicle: Vehicle<T>,
    pub(super) speed: T,
    pub(super) acceleration: T,
    /// Of the sensor of ground speed.
    pub(super) speed_gain: T,
    /// What the logged rate of speed gains by that sensor's delay.
    pub(super) quicker: T,
    pub(super) yaw_rate: T,
    /// Of the gyroscope.
    pub(super) yaw_gain: T,
    pub(super) wheel: [T; 4],
    pub(super) wheel_rate: [T; 4],
    /// Gravity along the way.
    pub(super) climbing: T,
    travel: [T; 4],
    /// Library slip.
    pub(super) slip: [T; 4],
    pub(super) load: [T; 4],
    /// 1 forwards, -1 in reverse, where a wheel meets the same soil mirrored: magnitudes in, signs out.
    pub(super) direction: [T; 4],
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
    /// As it is logged.
    fn logged(raw: &[T], offset: T) -> Self {
        let rate = raw[SPEED_RATE];
        GroundSpeed {
            speed: raw[SPEED] + rate * offset,
            acceleration: rate,
            gain: T::one(),
            quicker: T::zero(),
        }
    }

    fn of(law: &Law, p: &[T], given: &Given<T>, raw: &[T], offset: T) -> Self {
        let GroundSpeed {
            speed: logged,
            acceleration: rate,
            ..
        } = GroundSpeed::logged(raw, offset);
        if !law.acts_on(Channel::GroundSpeed) {
            return GroundSpeed::logged(raw, offset);
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

/// The yaw rate behind what the gyroscope says, and its gain.
struct YawRate<T> {
    rate: T,
    gain: T,
}

impl<T: Scalar> YawRate<T> {
    /// As it is logged.
    fn logged(raw: &[T], offset: T) -> Self {
        YawRate {
            rate: raw[YAW_RATE] + raw[YAW_ACCELERATION] * offset,
            gain: T::one(),
        }
    }

    fn of(law: &Law, p: &[T], given: &Given<T>, raw: &[T], offset: T) -> Self {
        let logged = YawRate::logged(raw, offset);
        let channel = Channel::YawRate;
        if !law.acts_on(channel) {
            return logged;
        }
        // Where none was read the vehicle drives as its wheels do.
        let behind = sensor::truth(law, p, channel, logged.rate) - logged.rate;
        YawRate {
            rate: logged.rate + behind * given.yaw_read,
            gain: sensor::gain(law, p, channel, logged.rate),
        }
    }
}

/// The vehicle as effects make it, on ground of this pitch.
pub(super) fn altered<T: Scalar>(
    vehicle: &Vehicle<f64>,
    law: &Law,
    p: &[T],
    pitch: T,
) -> Vehicle<T> {
    let mut vehicle = lift(vehicle, T::from);
    vehicle.pitch = pitch;
    for (effect, e) in law.acting(p, Touch::Vehicle) {
        vehicle = T::of_effect(&**effect).vehicle_at(e, vehicle);
    }
    vehicle
}

/// Whether a law leaves the stance as vehicle and log give it.
pub(super) fn is_left(law: &Law) -> bool {
    let moved = [Channel::GroundSpeed, Channel::YawRate];
    !law.acts(Touch::Vehicle) && !moved.into_iter().any(|channel| law.acts_on(channel))
}

impl<T: Scalar> Stance<T> {
    /// `offset` seconds from a window's middle, on its straight line of motion.
    ///
    /// Whether its wheels [turn with its motion](Self::turns_with_its_motion) is asked where it lies: it is long to move.
    pub(super) fn of(
        vehicle: &Vehicle<f64>,
        law: &Law,
        p: &[T],
        given: &Given<T>,
        raw: &[T],
        offset: T,
    ) -> Self {
        let vehicle = altered(vehicle, law, p, given.pitch);
        let speed = GroundSpeed::of(law, p, given, raw, offset);
        let yaw = YawRate::of(law, p, given, raw, offset);
        Stance::at(vehicle, speed, yaw, given, raw, offset)
    }

    /// The same under a law that [leaves it as it is](is_left).
    pub(super) fn left(vehicle: &Vehicle<f64>, given: &Given<T>, raw: &[T], offset: T) -> Self {
        let mut vehicle = lift(vehicle, T::from);
        vehicle.pitch = given.pitch;
        let speed = GroundSpeed::logged(raw, offset);
        let yaw = YawRate::logged(raw, offset);
        Stance::at(vehicle, speed, yaw, given, raw, offset)
    }

    fn at(
        mut vehicle: Vehicle<T>,
        speed: GroundSpeed<T>,
        yaw: YawRate<T>,
        given: &Given<T>,
        raw: &[T],
        offset: T,
    ) -> Self {
        // The operator weighed the payload; an error of the file's mass does not scale it.
        vehicle.mass += given.payload;
        let GroundSpeed {
            speed,
            acceleration,
            gain: speed_gain,
            quicker,
        } = speed;
        let yaw_rate = yaw.rate;
        let wheel: [T; 4] = std::array::from_fn(|q| raw[WHEEL + q] + raw[WHEEL_RATE + q] * offset);

        let (sin, cos) = vehicle.pitch.sin_cos();
        let climbing = sin * GRAVITY;
        let pressing = cos * given.cos_roll * GRAVITY;
        let to_rear = vehicle.wheelbase - vehicle.cg_to_front_axle;
        let transfer = vehicle.cg_height * (acceleration + climbing);
        let share = vehicle.mass / (vehicle.wheelbase * 2.0);
        let quarter = vehicle.mass * pressing * 0.25;
        let front = share * (to_rear * pressing - transfer);
        let rear = share * (vehicle.cg_to_front_axle * pressing + transfer);
        let aside = speed * yaw_rate + cos * given.sin_roll * GRAVITY;
        let lean = given.leaning * vehicle.cg_height * aside * 2.0 / (pressing * vehicle.track);

        let mut stance = Stance {
            vehicle,
            speed,
            acceleration,
            speed_gain,
            quicker,
            yaw_rate,
            yaw_gain: yaw.gain,
            wheel,
            wheel_rate: std::array::from_fn(|q| raw[WHEEL_RATE + q]),
            climbing,
            travel: [T::zero(); 4],
            slip: [T::zero(); 4],
            load: [T::zero(); 4],
            direction: [T::one(); 4],
        };
        for (q, turning) in wheel.into_iter().enumerate() {
            let left = q % 2 == 0;
            let arm = vehicle.track * if left { -0.5 } else { 0.5 };
            let travel = speed + yaw_rate * arm;
            let rim = turning * vehicle.wheel_radius;
            let leaning = if left { T::one() - lean } else { lean + 1.0 };
            stance.travel[q] = travel;
            stance.slip[q] = library_slip(rim, travel);
            // The two diagonals share what neither weight nor moments decide: one force, wherever the centre of mass is.
            let swing = if q == 0 || q == 3 {
                given.swing
            } else {
                -given.swing
            };
            stance.load[q] = if q < 2 { front } else { rear } * leaning + quarter * swing;
            let one = T::one();
            stance.direction[q] = rim.select_lt(T::zero(), -one, one);
        }
        stance
    }
}

impl<S: Real> Stance<S> {
    /// # Errors
    /// A wheel that turns against its motion.
    pub(super) fn turns_with_its_motion(&self) -> Result<(), GapError> {
        let radius = self.vehicle.wheel_radius.primal();
        for (wheel, travel) in self.wheel.iter().zip(&self.travel) {
            let with = wheel.primal() * radius * travel.primal();
            if with.any_lt(S::zero().primal()) {
                return Err(GapError::Model(ModelError::Contact {
                    quantity: "rim speed times travel speed",
                    value: with.min_lane(),
                    expected: "a wheel that turns with its motion",
                }));
            }
        }
        Ok(())
    }

    /// How far a wheel is ahead of the centre \[m\].
    pub(super) fn ahead(&self, wheel: usize) -> S {
        let vehicle = &self.vehicle;
        if wheel < 2 {
            vehicle.cg_to_front_axle
        } else {
            vehicle.cg_to_front_axle - vehicle.wheelbase
        }
    }

    /// The contact of a wheel.
    pub(super) fn contact<T: Scalar>(&self, wheel: usize, given: &Given<S>) -> Contact<T>
    where
        S: Factor<T>,
    {
        let vehicle = &self.vehicle;
        let mut at = Contact::new(
            self.slip[wheel].lifted(),
            self.load[wheel].lifted(),
            vehicle.wheel_radius.lifted(),
            vehicle.wheel_width.lifted(),
        );
        let travel = self.travel[wheel];
        at.speed = travel.lifted();
        at.wheel_speed = self.wheel[wheel].lifted();
        at.yaw_rate = self.yaw_rate.lifted();
        let ahead = self.ahead(wheel);
        (at.ahead, at.wheelbase) = (ahead.lifted(), vehicle.wheelbase.lifted());
        let aside = ahead * self.yaw_rate;
        at.slip_angle = (aside / travel.abs()).atan().lifted();
        at.path = given.path.lifted();
        at.time = given.time.lifted();
        at.side = T::from(if wheel.is_multiple_of(2) { -1.0 } else { 1.0 });
        // In reverse the rear axle leads, and the front axle runs in its rut.
        let leads = (wheel < 2) == given.forwards;
        let earlier = given.earlier_passes + if leads { 0.0 } else { 1.0 };
        at.earlier_passes = earlier.lifted();
        at
    }
}

/// A number beside those of a scalar: one of them, or a constant, which is quicker to move about.
pub(super) trait Factor<T: Real>: Real {
    /// The product.
    fn times(self, x: &T) -> T;
    /// The number itself.
    fn lifted(self) -> T;
}

impl<T: Real> Factor<T> for T {
    fn times(self, x: &T) -> T {
        self * *x
    }
    fn lifted(self) -> T {
        self
    }
}

impl Factor<LaneDual> for Lanes {
    fn times(self, x: &LaneDual) -> LaneDual {
        x.scaled(self)
    }
    fn lifted(self) -> LaneDual {
        LaneDual::from_primal(self)
    }
}

/// Of another scalar.
pub(crate) fn lift<S: Copy, T>(v: &Vehicle<S>, of: impl Fn(S) -> T) -> Vehicle<T> {
    Vehicle {
        mass: of(v.mass),
        yaw_inertia: of(v.yaw_inertia),
        track: of(v.track),
        wheelbase: of(v.wheelbase),
        cg_to_front_axle: of(v.cg_to_front_axle),
        cg_height: of(v.cg_height),
        yaw_damping: of(v.yaw_damping),
        wheel_radius: of(v.wheel_radius),
        wheel_width: of(v.wheel_width),
        wheel_inertia: of(v.wheel_inertia),
        wheel_damping: of(v.wheel_damping),
        pitch: of(v.pitch),
    }
}

#[cfg(test)]
mod tests {
    use terra_data::parse_rover;

    use super::*;
    use crate::drive::RAW;

    /// A swing of the loads leaves the weight and both moments as they are, wherever the centre of mass is, on a slope and in a
    /// turn: each axle and each side carries what it did.
    #[test]
    fn a_swing_moves_neither_weight_nor_moments() {
        let rover = "[vehicle]\nmass_kg = 40.0\nyaw_inertia_kg_m2 = 2.0\ntrack_m = 0.5\nwheelbase_m = 0.6\n\
             cg_to_front_axle_m = 0.2\ncg_height_m = 0.2\nyaw_damping_N_m_s = 0.0\n[wheel]\nradius_m = 0.2\nwidth_m = 0.1\n\
             inertia_kg_m2 = 0.1\ndamping_N_m_s = 0.0\n[terrain]\nmodel = \"wong-reece\"\n";
        let rover = parse_rover(rover, "rover.toml").unwrap();
        let vehicle = rover.nominal_vehicle().unwrap();
        let mut raw = vec![0.0; RAW];
        (raw[SPEED], raw[YAW_RATE]) = (0.8, 0.4);
        let loads = |swing: f64| {
            let given = Given {
                pitch: 0.1,
                sin_roll: 0.05_f64.sin(),
                cos_roll: 0.05_f64.cos(),
                payload: 3.0,
                earlier_passes: 0.0,
                path: 0.0,
                time: 0.0,
                around: [0.8; 3],
                leaning: 1.0,
                swing,
                yaw_read: 1.0,
                forwards: true,
            };
            Stance::<f64>::left(&vehicle, &given, &raw, 0.0).load
        };
        let (level, swung) = (loads(0.0), loads(0.3));
        assert!(swung[0] > level[0] + 1.0, "{swung:?}");
        for (a, b) in [(0, 1), (2, 3), (0, 2), (1, 3)] {
            let moved = swung[a] + swung[b] - level[a] - level[b];
            assert!(moved.abs() < 1e-9, "wheels {a} and {b}: {moved}");
        }
    }
}
