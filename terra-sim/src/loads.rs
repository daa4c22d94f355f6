//! Which wheel carries what.
//!
//! # Equation
//! - N_f = m (g' l_r - h a_x)/(2 L), N_r = m (g' l_f + h a_x)/(2 L) a wheel, g' = g cos(pitch) cos(roll)
//! - right wheels x (1 + λ), left wheels x (1 - λ), λ = 2 (h a_y/g' - y_c)/t_w: the moment about the track's middle of
//!   the specific force a_y at height h and of a centre of mass y_c to the left. Both axles are equally stiff in roll,
//!   so each carries its share.
//! - a payload m_p at (x, y, z) from the centre of mass moves it by m_p/(m + m_p) of that and adds
//!   m m_p/(m + m_p) (x² + y²) to I_zz.
//!
//! # Reference
//! Balance of moments of a rigid body about the ground; J. Y. Wong, Theory of Ground Vehicles, 4th ed., 2008, ch. 3.

use terra_model::Vehicle;

use crate::robot::GRAVITY;

/// The vehicle of one segment: loaded, and on its ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadedVehicle {
    /// With payload, its pitch that of the ground.
    pub(crate) car: Vehicle<f64>,
    /// y_c: centre of mass left of the middle \[m\].
    pub(crate) cg_left: f64,
    /// Left side up positive \[rad\].
    pub(crate) roll: f64,
    /// True: a_y moves no load.
    pub(crate) upright: bool,
}

impl LoadedVehicle {
    /// A payload \[kg\] at (forward, left, up) of the centre of mass \[m\].
    pub(crate) fn with_payload(mut car: Vehicle<f64>, payload: f64, at: [f64; 3]) -> Self {
        let own = car.mass;
        car.mass += payload;
        let share = payload / car.mass;
        let [forward, left, up] = at;
        if at != [0.0; 3] {
            car.cg_to_front_axle -= share * forward;
            car.cg_height += share * up;
            car.yaw_inertia += share * own * (forward * forward + left * left);
        }
        LoadedVehicle {
            car,
            cg_left: share * left,
            roll: 0.0,
            upright: false,
        }
    }

    /// Centre of mass before the rear axle \[m\].
    pub(crate) fn rear_arm(&self) -> f64 {
        self.car.wheelbase - self.car.cg_to_front_axle
    }

    /// Where a wheel stands from the centre of mass: forward, left \[m\].
    pub(crate) fn wheel(&self, q: usize) -> (f64, f64) {
        let forward = if q < 2 {
            self.car.cg_to_front_axle
        } else {
            -self.rear_arm()
        };
        let side = if q % 2 == 1 { -0.5 } else { 0.5 };
        (forward, side * self.car.track - self.cg_left)
    }

    /// Component of gravity that presses on the ground \[m/s²\].
    fn pressing(&self) -> f64 {
        GRAVITY * self.car.pitch.cos() * self.roll.cos()
    }

    /// Component of gravity along body y, left positive, with its sign turned: what an accelerometer at rest reads \[m/s²\].
    pub(crate) fn side_gravity(&self) -> f64 {
        GRAVITY * self.car.pitch.cos() * self.roll.sin()
    }

    /// W of the four wheels at the specific forces (a_x, a_y) \[N\].
    pub(crate) fn normal(&self, ahead: f64, aside: f64) -> [f64; 4] {
        let car = &self.car;
        let (weight, transfer) = (self.pressing(), car.cg_height * ahead);
        let front = car.mass * (weight * self.rear_arm() - transfer) / (2.0 * car.wheelbase);
        let rear = car.mass * (weight * car.cg_to_front_axle + transfer) / (2.0 * car.wheelbase);
        let aside = if self.upright { 0.0 } else { aside };
        let lean = 2.0 * (car.cg_height * aside / weight - self.cg_left) / car.track;
        [
            front * (1.0 - lean),
            front * (1.0 + lean),
            rear * (1.0 - lean),
            rear * (1.0 + lean),
        ]
    }
}
