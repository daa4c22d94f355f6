//! What the slots of a wheel can hold, for whoever looks for a name.

use super::pressure::PressureKind;
use super::shear::ShearKind;
use super::wheel::WheelKind;
use super::{combinations, senseless};
use crate::param::Param;

/// A pressure law or a shear law that a slot can hold.
#[derive(Clone, Debug)]
pub struct Filling {
    /// Kebab-case name, as in `wheel:pressure:shear`.
    pub name: &'static str,
    /// One line: what it is.
    pub summary: &'static str,
    /// The equation.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub reference: &'static str,
    /// Its parameters, in the order a combination has them.
    pub params: Vec<Param>,
    /// True for the one that goes without saying.
    pub default: bool,
}

/// The slots of one wheel and all that they can hold.
#[derive(Clone, Debug)]
pub struct Slots {
    /// Normal stress against sinkage.
    pub pressure: Vec<Filling>,
    /// Shear stress against shear displacement: those that make sense with this wheel.
    pub shear: Vec<Filling>,
}

impl Slots {
    /// The slots of a wheel by name; none for whole models.
    pub fn of(wheel: &str) -> Option<Slots> {
        let wheel = WheelKind::ALL.into_iter().find(|k| k.name() == wheel)?;
        let pressure = PressureKind::ALL.into_iter().map(|law| Filling {
            name: law.name(),
            summary: law.summary(),
            equation: law.equation(),
            reference: law.reference(),
            params: law.params(true),
            default: law == wheel.default_pressure(),
        });
        let shear = ShearKind::ALL.into_iter();
        let shear = shear.filter(|law| senseless(wheel, *law).is_none());
        let shear = shear.map(|law| Filling {
            name: law.name(),
            summary: law.summary(),
            equation: law.equation(),
            reference: law.reference(),
            params: law.params(),
            default: law == ShearKind::JanosiHanamoto,
        });
        Some(Slots {
            pressure: pressure.collect(),
            shear: shear.collect(),
        })
    }

    /// The names of all combinations of slots, each as short as it is known by.
    pub fn combinations() -> impl Iterator<Item = &'static str> {
        combinations().iter().map(|c| c.name.as_str())
    }
}
