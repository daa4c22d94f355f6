//! One wheel on its soil, in any direction of travel and through standstill.
//!
//! A terrain model knows a wheel that turns with its motion. Around it, within [`STANDSTILL_SPEED`] (.05 m/s) only:
//!
//! - slip is (R ω - v)/max(|R ω|, |v|, .05 m/s), held at spinning in place (1) or locked (-1);
//! - forward and reverse contact are blended by a smooth step of (R ω + v)/.05 m/s, so that a wheel at rest feels no
//!   force and no torque; the direction that counts less never brakes, so that a stalling wheel stays a driven one;
//! - a net pull against the drive cannot set a standing wheel in motion backwards, so a negative pull is scaled by a
//!   smooth step of v/.05 m/s: a resistance, not a thrust.
//!
//! Farther from standstill all three are the model itself, exactly. A wheel that turns against a motion of more than
//! .05 m/s with a rim of more than .05 m/s is an error on a vehicle that is held from sliding. On one that slides freely
//! it is what happens to the inner wheels of a tight turn: the faster of rim and travel names the direction, slip is 1 or
//! -1, and the row is flagged.
//!
//! Slip angle: tan β = v_y/max(|v_x|, .05 m/s) of the wheel's centre, left positive.

use terra_model::{Contact, ModelError, STANDSTILL_SPEED};

use crate::error::SimError;
use crate::force_table::Forces;

/// What the ground does to one wheel.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WheelState {
    /// F_x on the vehicle, forward positive \[N\].
    pub(crate) drawbar_pull: f64,
    /// T_r, positive when it resists forward drive \[N m\].
    pub(crate) resistive_torque: f64,
    /// F_y, left positive \[N\].
    pub(crate) lateral_force: f64,
    /// z \[m\].
    pub(crate) sinkage: Option<f64>,
    /// Library slip, before effects.
    pub(crate) slip: f64,
    /// W \[N\].
    pub(crate) normal_load: f64,
    /// Some of the standstill rules took part.
    pub(crate) standstill: bool,
    /// The contact of the direction that counts most, before effects.
    pub(crate) contact: Option<Contact<f64>>,
}

/// How a wheel moves and stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelMotion {
    /// Wheel, 0 to 3.
    pub(crate) wheel: usize,
    /// v_x of the wheel's centre \[m/s\].
    pub(crate) travel_speed: f64,
    /// v_y of the wheel's centre \[m/s\].
    pub(crate) lateral_speed: f64,
    /// The soil's own shear holds the wheel sideways.
    pub(crate) slides: bool,
    /// ω \[rad/s\].
    pub(crate) wheel_speed: f64,
    /// r \[rad/s\].
    pub(crate) yaw_rate: f64,
    /// Signed path \[m\].
    pub(crate) path: f64,
    /// t \[s\].
    pub(crate) time: f64,
    /// W \[N\].
    pub(crate) normal_load: f64,
    /// R \[m\].
    pub(crate) radius: f64,
    /// b \[m\].
    pub(crate) width: f64,
    /// How far it is ahead of the centre of mass \[m\].
    pub(crate) ahead: f64,
    /// Distance between the axles \[m\].
    pub(crate) wheelbase: f64,
    /// Pass of the vehicle over this track, from 1.
    pub(crate) pass: u32,
    /// Passes this run left in the wheel's track, where it is remembered.
    pub(crate) rut: Option<u32>,
}

/// Odd, smooth, ±1 at and beyond ±1.
pub(crate) fn smooth_sign(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    0.5 * x * (3.0 - x * x)
}

impl WheelMotion {
    /// Slip counted along forward: +s when driving forward, -s when driving in reverse.
    fn signed_slip(&self) -> f64 {
        let (rim, travel) = (self.radius * self.wheel_speed, self.travel_speed);
        // Where the wheel moves, written as in the definition: 1 - v/(R ω), R ω/v - 1.
        let (a, b) = (rim.abs(), travel.abs());
        let scale = a.max(b).max(STANDSTILL_SPEED);
        ((rim - travel) / scale).clamp(-1.0, 1.0)
    }

    /// The contact as a wheel that runs forward (direction 1) or in reverse (-1) would have it.
    fn contact(&self, direction: f64, slip: f64) -> Contact<f64> {
        let left = self.wheel.is_multiple_of(2);
        let front = self.wheel < 2;
        let leads = front == (direction > 0.0);
        let mut contact = Contact::new(slip, self.normal_load, self.radius, self.width);
        contact.speed = self.travel_speed;
        contact.wheel_speed = self.wheel_speed;
        contact.yaw_rate = self.yaw_rate;
        contact.path = self.path;
        contact.earlier_passes = match self.rut {
            None => f64::from(self.pass) - if leads { 1.0 } else { 0.0 },
            Some(passes) => f64::from(self.pass - 1) + f64::from(passes),
        };
        (contact.ahead, contact.wheelbase) = (self.ahead, self.wheelbase);
        if self.lateral_speed != 0.0 {
            let along = self.travel_speed.abs().max(STANDSTILL_SPEED);
            contact.slip_angle = self.lateral_speed.atan2(along);
            if self.slides {
                contact.hooks.lateral_slip = Some(contact.slip_angle.tan());
            }
        }
        contact.side = if left { -1.0 } else { 1.0 };
        contact.time = self.time;
        contact
    }

    fn standstill(&self) -> bool {
        let (rim, travel) = (self.radius * self.wheel_speed, self.travel_speed);
        rim.abs().max(travel.abs()) < STANDSTILL_SPEED
            || rim * travel < 0.0
            || (rim + travel).abs() < STANDSTILL_SPEED
    }

    /// Forces on this wheel, `ground` giving those of a contact.
    pub(crate) fn forces(
        &self,
        ground: &mut impl FnMut(&Contact<f64>) -> Result<Forces, ModelError>,
    ) -> Result<WheelState, SimError> {
        let rim = self.radius * self.wheel_speed;
        if !self.slides
            && rim * self.travel_speed < 0.0
            && rim.abs().min(self.travel_speed.abs()) > STANDSTILL_SPEED
        {
            return Err(SimError::AgainstMotion {
                time: self.time,
                wheel: self.wheel,
                rim_speed: rim,
                travel_speed: self.travel_speed,
            });
        }
        let mut state = WheelState {
            slip: self.signed_slip(),
            normal_load: self.normal_load,
            standstill: self.standstill(),
            ..WheelState::default()
        };
        // A wheel in the air feels nothing; whether that is the answer is for the balance of loads to say.
        if self.normal_load <= 0.0 {
            return Ok(state);
        }
        let heading = smooth_sign((rim + self.travel_speed) / STANDSTILL_SPEED);
        for direction in [1.0, -1.0] {
            let weight = 0.5 * (1.0 + direction * heading);
            if weight == 0.0 {
                continue;
            }
            // The direction that counts less must not ask for a braked wheel: a wheel that stalls drives, it does not brake.
            let along = direction * self.signed_slip();
            let slip = if along < 0.0 {
                along * (direction * heading).max(0.0)
            } else {
                along
            };
            let contact = self.contact(direction, slip);
            let f = ground(&contact).map_err(|e| self.located(e))?;
            let mut pull = f.drawbar_pull;
            let along = direction * self.travel_speed;
            if pull < 0.0 && along < STANDSTILL_SPEED {
                pull *= smooth_sign(along / STANDSTILL_SPEED);
                state.standstill = true;
            }
            state.drawbar_pull += weight * direction * pull;
            state.resistive_torque += weight * direction * f.resistive_torque;
            state.lateral_force += weight * f.lateral_force;
            if let Some(z) = f.sinkage {
                state.sinkage = Some(state.sinkage.unwrap_or(0.0) + weight * z);
            }
            if weight >= 0.5 {
                state.slip = contact.slip;
                state.contact = Some(contact);
            }
        }
        Ok(state)
    }

    fn located(&self, error: ModelError) -> SimError {
        match error {
            ModelError::NoEquilibrium { load, max_load } => SimError::NoEquilibrium {
                time: self.time,
                wheel: self.wheel,
                load,
                max_load,
            },
            source => SimError::Wheel {
                time: self.time,
                wheel: self.wheel,
                source,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{ActiveEffects, LogKind};
    use crate::force_table::ForceTable;
    use terra_model::{Registry, catalogue, slip_from_speeds};

    fn motion(rim: f64, travel: f64) -> WheelMotion {
        WheelMotion {
            wheel: 0,
            travel_speed: travel,
            lateral_speed: 0.0,
            slides: false,
            wheel_speed: rim / 0.254,
            yaw_rate: 0.0,
            path: 0.0,
            time: 0.0,
            normal_load: 245.25,
            radius: 0.254,
            width: 0.15,
            ahead: 0.3,
            wheelbase: 0.6,
            pass: 1,
            rut: None,
        }
    }

    fn sand() -> impl FnMut(&Contact<f64>) -> Result<Forces, ModelError> {
        let registry = Registry::builtin();
        let model = registry.model("wong-reece").unwrap();
        let none = ActiveEffects::new(&[], &model, &registry, LogKind::Drive).unwrap();
        let p = catalogue::find("dry_sand")
            .unwrap()
            .parameters(&*model)
            .unwrap();
        let mut table = ForceTable::new(&model, &none, p).unwrap();
        move |contact| table.forces(contact)
    }

    #[test]
    fn slip_is_the_library_slip_away_from_standstill() {
        for (rim, travel) in [
            (0.3, 0.2),
            (0.2, 0.25),
            (-0.3, -0.2),
            (-0.2, -0.3),
            (0.4, 0.0),
            (0.0, 0.4),
        ] {
            let state = motion(rim, travel).forces(&mut sand()).unwrap();
            let (slip, moving) = slip_from_speeds(rim, travel).unwrap();
            assert!(
                moving && (state.slip - slip).abs() < 1e-14,
                "{rim} {travel}: {} {slip}",
                state.slip
            );
        }
    }

    /// Reverse is forward seen in a mirror.
    #[test]
    fn reverse_mirrors_forward() {
        let mut ground = sand();
        let forward = motion(0.3, 0.2).forces(&mut ground).unwrap();
        let reverse = motion(-0.3, -0.2).forces(&mut ground).unwrap();
        assert_eq!(forward.drawbar_pull, -reverse.drawbar_pull);
        assert_eq!(forward.resistive_torque, -reverse.resistive_torque);
    }

    #[test]
    fn at_rest_nothing_pulls_or_turns() {
        let mut ground = sand();
        let f = motion(0.0, 0.0).forces(&mut ground).unwrap();
        assert_eq!((f.drawbar_pull, f.resistive_torque), (0.0, 0.0));
        assert!(f.standstill);
    }

    /// Walking through the whole standstill region in small steps never jumps.
    #[test]
    fn continuous_through_standstill() {
        let mut ground = sand();
        let mut at = |x: f64, slope: f64| motion(x, slope * x).forces(&mut ground).unwrap();
        for slope in [0.0, 0.5, 1.0] {
            let mut last = at(-0.12, slope);
            for i in 1..=2400 {
                let x = -0.12 + 1e-4 * f64::from(i);
                let now = at(x, slope);
                assert!(
                    (now.drawbar_pull - last.drawbar_pull).abs() < 1.5,
                    "{slope} {x}"
                );
                assert!(
                    (now.resistive_torque - last.resistive_torque).abs() < 0.5,
                    "{slope} {x}"
                );
                last = now;
            }
        }
    }

    #[test]
    fn against_its_motion_is_an_error_with_its_numbers() {
        let mut ground = sand();
        let error = motion(0.3, -0.2).forces(&mut ground).unwrap_err();
        let SimError::AgainstMotion {
            wheel: 0,
            rim_speed,
            travel_speed,
            ..
        } = error
        else {
            panic!("{error}")
        };
        assert!((rim_speed - 0.3).abs() < 1e-12 && travel_speed == -0.2);
    }
}
