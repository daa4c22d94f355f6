//! The trait an effect's author writes, and its erased form.

use crate::contact::{Contact, Hook};
use crate::dual::Dual8;
use crate::forces::WheelForces;
use crate::lanes::{LaneDual, Lanes};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;
use crate::vehicle::{BodyLoads, Motion, Vehicle};

/// What a log reports. An effect on an instrument changes one of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Channel {
    /// Torque the motor delivers at the wheel, as logged \[N m\].
    WheelTorque,
    /// Wheel speed \[rad/s\].
    WheelSpeed,
    /// Ground speed \[m/s\].
    GroundSpeed,
    /// Yaw rate \[rad/s\].
    YawRate,
    /// Specific force along x \[m/s²\].
    AccelX,
    /// Drawbar pull of a rig's load cell \[N\].
    DrawbarPull,
    /// Normal load of a rig \[N\].
    NormalLoad,
    /// Sinkage \[m\].
    Sinkage,
}

impl Channel {
    /// All of them.
    pub const ALL: &'static [Channel] = &[
        Channel::WheelTorque,
        Channel::WheelSpeed,
        Channel::GroundSpeed,
        Channel::YawRate,
        Channel::AccelX,
        Channel::DrawbarPull,
        Channel::NormalLoad,
        Channel::Sinkage,
    ];
}

/// Which of its five methods an effect overrides: where in the chain it acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touch {
    /// The contact before the model.
    Contact,
    /// The forces after the model.
    Forces,
    /// The vehicle's geometry and mass.
    Vehicle,
    /// Loads on body or drivetrain.
    Loads,
    /// What a sensor reports.
    Sensor,
}

/// On which kind of log an effect can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Vehicle and rig.
    Any,
    /// Vehicle only.
    Drive,
    /// Rig only.
    Rig,
}

/// How a sensor is late whose report depends on the rate of its truth: what the coefficient of the rate means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Late {
    /// It says what was so long ago: v_reported(t) = v(t - e).
    Shifted,
    /// It follows with that time constant: e dv_reported/dt = v - v_reported.
    Following,
}

/// What a contact tells beside slip, load and wheel. A wheel on its own has none of it: all are 0 in
/// [`Contact::new`](crate::Contact::new).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Circumstance {
    /// Sideways motion of the wheel.
    SlipAngle,
    /// Path travelled since the log began.
    Path,
    /// Earlier passes over the same track.
    EarlierPasses,
    /// Side of the vehicle.
    Side,
    /// Speed of the wheel's centre, and that of its rim, which follows from it by slip.
    Speed,
}

impl Circumstance {
    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Circumstance::SlipAngle => "slip angle",
            Circumstance::Path => "path travelled",
            Circumstance::EarlierPasses => "earlier passes over the track",
            Circumstance::Side => "side of the vehicle",
            Circumstance::Speed => "speed",
        }
    }
}

impl Circumstance {
    /// All of them.
    pub const ALL: [Circumstance; 5] = [
        Circumstance::SlipAngle,
        Circumstance::Path,
        Circumstance::EarlierPasses,
        Circumstance::Side,
        Circumstance::Speed,
    ];

    /// How much of it a contact tells; of speed, that of its centre.
    pub fn told_by<T: Real>(self, at: &Contact<T>) -> T {
        match self {
            Circumstance::SlipAngle => at.slip_angle,
            Circumstance::Path => at.path,
            Circumstance::EarlierPasses => at.earlier_passes,
            Circumstance::Side => at.side,
            Circumstance::Speed => at.speed,
        }
    }

    /// Tells a contact so much of it. A speed is told of centre and rim, as they go together at the contact's slip.
    pub fn tell<T: Real>(self, at: &mut Contact<T>, value: T) {
        match self {
            Circumstance::SlipAngle => at.slip_angle = value,
            Circumstance::Path => at.path = value,
            Circumstance::EarlierPasses => at.earlier_passes = value,
            Circumstance::Side => at.side = value,
            Circumstance::Speed => {
                let one = T::one();
                // Driven i = 1 - v/(R ω), braked i = R ω/v - 1.
                let rim =
                    at.slip
                        .select_lt(T::zero(), value * (one + at.slip), value / (one - at.slip));
                (at.speed, at.wheel_speed) = (value, rim / at.radius);
            }
        }
    }
}

/// A candidate unmodelled effect, of magnitude `e` (one or more numbers; 0 is the nominal world, bit for bit).
///
/// An effect may act in five places, each one method with the identity as default: on the contact before the model
/// (the hooks included), on the forces after it, on the vehicle, on the loads beside the wheels, on a sensor. Contact and forces are
/// changed in place: numbers with many derivatives are long to copy.
pub trait Effect: Default + Send + Sync + 'static {
    /// Kebab-case name. Several forms of one effect share it.
    const NAME: &'static str;
    /// Which formula of that name this is.
    const FORM: &'static str = "default";
    /// One line: what happens.
    const SUMMARY: &'static str;
    /// The magnitudes; the first is *the* magnitude.
    const PARAMS: &'static [Param];
    /// What is put in place of what, in the field's symbols; empty where it is left unsaid.
    const EQUATION: &'static str = "";
    /// Where the equation comes from.
    const REFERENCE: &'static str;
    /// Hooks the model must honour.
    const NEEDS: &'static [Hook] = &[];
    /// Soil values the model must know (`cohesion`, `friction_angle`).
    const NEEDS_SOIL: &'static [&'static str] = &[];
    /// Which methods it overrides: the others are not called. The conformance kit finds one that is overridden and not named here.
    const TOUCHES: &'static [Touch];
    /// What of the contact it acts by: where that is 0, it changes nothing.
    const READS: &'static [Circumstance] = &[];
    /// What beside slip, load and wheel it is that contact and forces follow from under it, with no force sideways: what they are
    /// between contacts may then be interpolated. None: from anything.
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = None;
    /// Channels whose reports it changes, where it acts on a sensor: the others it leaves as they are.
    const CHANNELS: &'static [Channel] = Channel::ALL;
    /// How a report that depends on the rate is late.
    const LATE: Late = Late::Shifted;
    /// Whether a small magnitude does next to nothing: no slope at zero, as where only the square of it acts. A screen then asks
    /// what a whole prior sd does.
    const FLAT: bool = false;
    /// Where the prior sd of a magnitude with a unit follows the wheel: its share of that unit's [natural size](crate::natural_size)
    /// on a large wheel; 0 where it is the same on all. The library's are what the sd is on the wheel that it was chosen for, of
    /// 245 N and .254 m.
    const SHARE: f64 = 0.0;
    /// Kinds of log it can show on.
    const SCOPE: Scope = Scope::Any;
    /// Where in a log it shows.
    const REGIME: &'static str;
    /// The experiment that isolates it.
    const ISOLATED_BY: &'static str;

    /// Makes of a contact what the model should see.
    fn before<T: Real>(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        let _ = (e, soil, at);
    }
    /// Makes of the model's forces what the wheel gets.
    fn after<T: Real>(
        &self,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        forces: &mut WheelForces<T>,
    ) {
        let _ = (e, soil, at, forces);
    }
    /// The vehicle as it really is.
    fn vehicle<T: Real>(&self, e: &[T], vehicle: Vehicle<T>) -> Vehicle<T> {
        let _ = e;
        vehicle
    }
    /// Loads beside the wheel forces.
    fn loads<T: Real>(
        &self,
        e: &[T],
        vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        loads: BodyLoads<T>,
    ) -> BodyLoads<T> {
        let _ = (e, vehicle, motion);
        loads
    }
    /// What the sensor reports when the truth is `truth` and changes at `rate` per second.
    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, rate: T) -> T {
        let _ = (e, channel, rate);
        truth
    }
}

/// An effect at one scalar.
pub trait EffectAt<T: Real>: Send + Sync {
    /// See [`Effect::before`].
    fn alter_contact(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>);
    /// See [`Effect::after`].
    fn alter_forces(&self, e: &[T], soil: &Soil<T>, at: &Contact<T>, forces: &mut WheelForces<T>);
    /// Another contact, as the model should see it.
    fn before_at(&self, e: &[T], soil: &Soil<T>, mut at: Contact<T>) -> Contact<T> {
        self.alter_contact(e, soil, &mut at);
        at
    }
    /// Other forces, as the wheel gets them.
    fn after_at(
        &self,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        mut forces: WheelForces<T>,
    ) -> WheelForces<T> {
        self.alter_forces(e, soil, at, &mut forces);
        forces
    }
    /// See [`Effect::vehicle`].
    fn vehicle_at(&self, e: &[T], vehicle: Vehicle<T>) -> Vehicle<T>;
    /// See [`Effect::loads`].
    fn loads_at(
        &self,
        e: &[T],
        vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        loads: BodyLoads<T>,
    ) -> BodyLoads<T>;
    /// See [`Effect::report`].
    fn report_at(&self, e: &[T], channel: Channel, truth: T, rate: T) -> T;
}

impl<E: Effect, T: Real> EffectAt<T> for E {
    fn alter_contact(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        self.before(e, soil, at);
    }
    fn alter_forces(&self, e: &[T], soil: &Soil<T>, at: &Contact<T>, forces: &mut WheelForces<T>) {
        self.after(e, soil, at, forces);
    }
    fn vehicle_at(&self, e: &[T], vehicle: Vehicle<T>) -> Vehicle<T> {
        self.vehicle(e, vehicle)
    }
    fn loads_at(
        &self,
        e: &[T],
        vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        loads: BodyLoads<T>,
    ) -> BodyLoads<T> {
        self.loads(e, vehicle, motion, loads)
    }
    fn report_at(&self, e: &[T], channel: Channel, truth: T, rate: T) -> T {
        self.report(e, channel, truth, rate)
    }
}

/// Any effect, known only by name.
pub trait AnyEffect:
    EffectAt<f64> + EffectAt<Dual8> + EffectAt<Lanes> + EffectAt<LaneDual>
{
    /// Kebab-case name.
    fn name(&self) -> &'static str;
    /// Which formula of that name.
    fn form(&self) -> &'static str;
    /// One line of meaning.
    fn summary(&self) -> &'static str;
    /// Magnitudes.
    fn params(&self) -> &[Param];
    /// The equation; may be empty.
    fn equation(&self) -> &'static str;
    /// Source.
    fn reference(&self) -> &'static str;
    /// Hooks the model must honour.
    fn needs(&self) -> &'static [Hook];
    /// Soil values the model must know.
    fn needs_soil(&self) -> &'static [&'static str];
    /// Where in the chain it acts.
    fn touches(&self) -> &'static [Touch];
    /// What of the contact it acts by; nothing for most.
    fn reads(&self) -> &'static [Circumstance] {
        &[]
    }
    /// See [`Effect::BESIDE_SLIP_AND_LOAD`].
    fn beside_slip_and_load(&self) -> Option<Vec<Circumstance>> {
        None
    }
    /// See [`Effect::CHANNELS`].
    fn channels(&self) -> &'static [Channel] {
        Channel::ALL
    }
    /// How a report that depends on the rate is late; a shift for most.
    fn late(&self) -> Late {
        Late::Shifted
    }
    /// See [`Effect::FLAT`].
    fn is_flat(&self) -> bool {
        false
    }
    /// See [`Effect::SHARE`].
    fn share(&self) -> f64 {
        0.0
    }
    /// Kinds of log.
    fn scope(&self) -> Scope;
    /// Where in a log it shows.
    fn regime(&self) -> &'static str;
    /// The experiment that isolates it.
    fn isolated_by(&self) -> &'static str;
}

impl<E: Effect> AnyEffect for E {
    fn name(&self) -> &'static str {
        E::NAME
    }
    fn form(&self) -> &'static str {
        E::FORM
    }
    fn summary(&self) -> &'static str {
        E::SUMMARY
    }
    fn params(&self) -> &[Param] {
        E::PARAMS
    }
    fn equation(&self) -> &'static str {
        E::EQUATION
    }
    fn reference(&self) -> &'static str {
        E::REFERENCE
    }
    fn needs(&self) -> &'static [Hook] {
        E::NEEDS
    }
    fn needs_soil(&self) -> &'static [&'static str] {
        E::NEEDS_SOIL
    }
    fn touches(&self) -> &'static [Touch] {
        E::TOUCHES
    }
    fn reads(&self) -> &'static [Circumstance] {
        E::READS
    }
    fn beside_slip_and_load(&self) -> Option<Vec<Circumstance>> {
        E::BESIDE_SLIP_AND_LOAD.map(<[_]>::to_vec)
    }
    fn channels(&self) -> &'static [Channel] {
        E::CHANNELS
    }
    fn late(&self) -> Late {
        E::LATE
    }
    fn is_flat(&self) -> bool {
        E::FLAT
    }
    fn share(&self) -> f64 {
        E::SHARE
    }
    fn scope(&self) -> Scope {
        E::SCOPE
    }
    fn regime(&self) -> &'static str {
        E::REGIME
    }
    fn isolated_by(&self) -> &'static str {
        E::ISOLATED_BY
    }
}
