//! Between motor and wheel.

use terra_model::Scope;

use super::{TruthOnly, Unlisted, WheelView};

pub(super) const STICK_SLIP: TruthOnly = TruthOnly {
    name: "stick-slip",
    form: "default",
    magnitude: (2.0, 10.0),
    unit: "N m",
    scope: Scope::Any,
    summary: "friction that falls with speed: loss e exp(-(w/1 rad/s)^2) tanh(w/.05 rad/s), so a slow wheel creeps and jumps",
    reference: "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083-1138; size chosen",
};

/// Friction between motor and wheel that falls with speed (Stribeck).
pub(super) struct StickSlip;

impl Unlisted for StickSlip {
    fn entry(&self) -> &TruthOnly {
        &STICK_SLIP
    }
    fn loss(&self, e: f64, at: &WheelView) -> f64 {
        let w = at.wheel_speed;
        e * (-w * w).exp() * (w / 0.05).tanh()
    }
}

pub(super) const GEARBOX_BACKLASH: TruthOnly = TruthOnly {
    name: "gearbox-backlash",
    form: "default",
    magnitude: (0.1, 0.6),
    unit: "rad",
    scope: Scope::Drive,
    summary: "after a reversal of torque the wheel gets none until the gap e is crossed: gap position m' = (tanh(T/1 N m) - m) 2 rad/s / e, T_wheel = T (x + sqrt(x^2 + .1^2))/(1 + sqrt(1 + .1^2)) with x = m tanh(T/1 N m): teeth that give a little, and oil between them",
    reference: "M. Nordin, P.-O. Gutman, Automatica 38 (2002) 1633-1649; smooth form and size chosen",
};

/// Share of the gap over which the teeth take up the torque: without it the torque has a corner in time and no
/// integrator keeps its order.
const TEETH: f64 = 0.1;

/// Lost motion at a reversal of torque.
pub(super) struct GearboxBacklash;

impl Unlisted for GearboxBacklash {
    fn entry(&self) -> &TruthOnly {
        &GEARBOX_BACKLASH
    }
    fn loss(&self, _e: f64, at: &WheelView) -> f64 {
        let x = at.memory * at.torque.tanh();
        at.torque * (1.0 - (x + x.hypot(TEETH)) / (1.0 + 1.0_f64.hypot(TEETH)))
    }
    fn remembers(&self) -> bool {
        true
    }
    fn memory_rate(&self, e: f64, at: &WheelView, _pull: f64) -> f64 {
        (at.torque.tanh() - at.memory) * 2.0 / e
    }
}

pub(super) const THERMAL_TORQUE_FADE: TruthOnly = TruthOnly {
    name: "thermal-torque-fade",
    form: "default",
    magnitude: (0.1, 0.5),
    unit: "1",
    scope: Scope::Drive,
    summary: "a warm motor gives less torque a current: heat h' = ((T/20 N m)^2 - h)/5 s, T_true = T_rep/(1 + e h)",
    reference: "chosen form: a winding that heats with the square of its torque, a magnet that weakens with heat",
};

/// The torque constant falls as the motor warms up.
pub(super) struct ThermalTorqueFade;

impl Unlisted for ThermalTorqueFade {
    fn entry(&self) -> &TruthOnly {
        &THERMAL_TORQUE_FADE
    }
    fn torque_reading(&self, e: f64, at: &WheelView, torque: f64) -> f64 {
        torque * (1.0 + e * at.memory)
    }
    fn remembers(&self) -> bool {
        true
    }
    fn memory_rate(&self, _e: f64, at: &WheelView, _pull: f64) -> f64 {
        ((at.torque / 20.0).powi(2) - at.memory) / 5.0
    }
}

pub(super) const DIFFERENTIAL_CROSS_COUPLING: TruthOnly = TruthOnly {
    name: "differential-cross-coupling",
    form: "default",
    magnitude: (1.0, 8.0),
    unit: "N m s",
    scope: Scope::Drive,
    summary: "the two wheels of an axle drag each other: loss e (w - w of the other)",
    reference: "chosen form: a viscous coupling between the two wheels of an axle",
};

/// The two wheels of an axle drag each other.
pub(super) struct DifferentialCrossCoupling;

impl Unlisted for DifferentialCrossCoupling {
    fn entry(&self) -> &TruthOnly {
        &DIFFERENTIAL_CROSS_COUPLING
    }
    fn loss(&self, e: f64, at: &WheelView) -> f64 {
        e * (at.wheel_speed - at.mate_speed)
    }
}
