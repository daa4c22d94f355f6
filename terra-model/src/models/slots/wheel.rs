//! The wheel slot: where the stresses of the soil act on the wheel.

use super::checks::{Must, Values, kinematic, quantity, rim_excess};
use super::column::{self, Column};
use super::contact_state::{Soil, Sums};
use super::linear::{self, Linear};
use super::params as par;
use super::pressure::PressureKind;
use super::pushed::{self, Broken, Lugs, Side};
use super::rim::{self, Rim};
use super::two_zones::TwoZones;
use super::tyre::Tyre;
use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::lugs::LugPhase;
use crate::model::TerrainModel;
use crate::models::bekker::apex_ratio;
use crate::models::braked_two_zone::zones::Zones;
use crate::models::{BrakedTwoZone, CompliantTyre};
use crate::param::Param;
use crate::real::{Real, Root, is_plain};
use crate::root::{
    FINE_TOLERANCE, LINEAR_RISES_TO, LINEAR_WITH_EXIT_RISES_TO, MAX_ENTRY_ANGLE, RISING_EXIT,
    TOLERANCE,
};
use crate::stress::StressPoint;

/// The wheels by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WheelKind {
    WongReece,
    LinearStress,
    LinearStressSymmetric,
    DingClosed,
    ScmColumn,
    GrouserPassive,
    Lateral,
    CompliantTyre,
    BrakedTwoZone,
}

impl WheelKind {
    pub(super) const ALL: [WheelKind; 9] = [
        WheelKind::WongReece,
        WheelKind::LinearStress,
        WheelKind::LinearStressSymmetric,
        WheelKind::DingClosed,
        WheelKind::ScmColumn,
        WheelKind::GrouserPassive,
        WheelKind::Lateral,
        WheelKind::CompliantTyre,
        WheelKind::BrakedTwoZone,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            WheelKind::WongReece => "wong-reece",
            WheelKind::LinearStress => "linear-stress",
            WheelKind::LinearStressSymmetric => "linear-stress-symmetric",
            WheelKind::DingClosed => "ding-closed",
            WheelKind::ScmColumn => "scm-column",
            WheelKind::GrouserPassive => "grouser-passive",
            WheelKind::Lateral => "lateral",
            WheelKind::CompliantTyre => "compliant-tyre",
            WheelKind::BrakedTwoZone => "braked-two-zone",
        }
    }

    /// The pressure law that goes without saying.
    pub(super) fn default_pressure(self) -> PressureKind {
        match self {
            WheelKind::DingClosed => PressureKind::SlipExponent,
            _ => PressureKind::Bekker,
        }
    }

    pub(super) fn summary(self) -> &'static str {
        match self {
            WheelKind::WongReece => "rigid wheel with an apex that moves with slip",
            WheelKind::GrouserPassive => {
                "rigid wheel with an apex that moves with slip, whose lugs push soil with its passive pressure"
            }
            WheelKind::Lateral => {
                "rigid wheel with an apex that moves with slip and a side force under a slip angle"
            }
            WheelKind::CompliantTyre => {
                "tyre that lies flat where the soil would push harder than inflation and carcass"
            }
            WheelKind::BrakedTwoZone => {
                "rigid wheel that, braked or towed, has two zones of shear whose soil flows apart"
            }
            WheelKind::LinearStress => {
                "rigid wheel whose stresses are linear between entry, apex and bottom: a closed form"
            }
            WheelKind::LinearStressSymmetric => {
                "rigid wheel whose stresses are linear between entry, half the entry angle and bottom: a closed form"
            }
            WheelKind::DingClosed => {
                "rigid wheel with lugs whose stresses are linear between entry, apex and exit: a closed form"
            }
            WheelKind::ScmColumn => {
                "columns of soil pressed straight down and sheared along the ground: the closed form of a grid simulator"
            }
        }
    }

    pub(super) fn reference(self) -> &'static str {
        match self {
            WheelKind::WongReece => {
                "J. Y. Wong, A. R. Reece, J. Terramechanics 4(1):81-98 and 4(2):7-25, 1967"
            }
            WheelKind::LinearStress | WheelKind::LinearStressSymmetric => {
                "K. Iagnemma et al., IEEE Trans. Robotics 20(5):921-927, 2004; H. Shibly et al., J. Terramechanics 42(1):1-13, 2005"
            }
            WheelKind::DingClosed => {
                "L. Ding et al., J. Field Robotics 32(6):827-852, 2015 (closed form recalled)"
            }
            WheelKind::GrouserPassive => {
                "Rankine passive pressure on lugs, as M. G. Bekker, 1969 (recalled); its mobilisation with slip is chosen"
            }
            WheelKind::Lateral => {
                "G. Ishigami, A. Miwa, K. Nagatani, K. Yoshida, J. Field Robotics 24(3):233-250, 2007 (formulas as an open code after that paper has them)"
            }
            WheelKind::CompliantTyre => {
                "M. G. Bekker, 1969; J. Y. Wong, Theory of Ground Vehicles (forms recalled)"
            }
            WheelKind::BrakedTwoZone => {
                "J. Y. Wong, A. R. Reece, J. Terramechanics 4(2):7-25, 1967 (part II; formulas as an open code after that paper has them)"
            }
            WheelKind::ScmColumn => {
                "A. Tasora et al., Int. J. Vehicle Performance 5(1):60-76, 2019; the closed form is ours"
            }
        }
    }

    /// What each wheel does with the stresses, in paragraphs.
    pub(super) fn equations(self) -> &'static [&'static str] {
        match self {
            WheelKind::WongReece => &[rim::EQUATION],
            WheelKind::GrouserPassive => &[rim::EQUATION, pushed::LUGS],
            WheelKind::Lateral => &[rim::EQUATION, pushed::SIDE],
            WheelKind::LinearStress | WheelKind::LinearStressSymmetric | WheelKind::DingClosed => {
                &[linear::EQUATION]
            }
            WheelKind::ScmColumn => &[column::EQUATION],
            WheelKind::CompliantTyre => &[CompliantTyre::EQUATION],
            WheelKind::BrakedTwoZone => &[BrakedTwoZone::EQUATION],
        }
    }

    pub(super) fn params(self) -> &'static [Param] {
        match self {
            WheelKind::WongReece | WheelKind::LinearStress | WheelKind::BrakedTwoZone => {
                &[par::C1, par::C2]
            }
            WheelKind::CompliantTyre => &[par::TYRE_PRESSURE],
            WheelKind::LinearStressSymmetric | WheelKind::ScmColumn => &[],
            WheelKind::DingClosed => &[par::C1, par::C2, par::C3, par::LUG_REACH],
            WheelKind::GrouserPassive => &[
                par::C1,
                par::C2,
                par::UNIT_WEIGHT,
                par::LUG_HEIGHT,
                par::LUG_COUNT,
            ],
            WheelKind::Lateral => &[par::C1, par::C2, par::UNIT_WEIGHT, par::LATERAL_MODULUS],
        }
    }

    /// Hooks of the wheel itself.
    pub(super) fn hooks(self) -> &'static [Hook] {
        match self {
            // A side force of its own, so none by a hook.
            WheelKind::Lateral => &[Hook::ContactRadius, Hook::ExitRatio, Hook::LugHeight],
            WheelKind::WongReece | WheelKind::GrouserPassive => &[
                Hook::ContactRadius,
                Hook::ExitRatio,
                Hook::LugHeight,
                Hook::LateralSlip,
            ],
            WheelKind::LinearStress
            | WheelKind::LinearStressSymmetric
            | WheelKind::CompliantTyre
            | WheelKind::BrakedTwoZone => &[Hook::ContactRadius],
            WheelKind::DingClosed => &[Hook::ContactRadius, Hook::ExitRatio, Hook::LugHeight],
            WheelKind::ScmColumn => &[Hook::ContactRadius, Hook::LugHeight],
        }
    }

    /// True where only the stresses at the apex are asked for, so that what happens along the contact cannot show.
    pub(super) fn knows_only_the_apex(self) -> bool {
        matches!(
            self,
            WheelKind::LinearStress | WheelKind::LinearStressSymmetric | WheelKind::DingClosed
        )
    }

    /// What the wheel asks of the soil itself, which a law of the interface between soil and rim does not tell.
    pub(super) fn asks_the_soil(self) -> Option<&'static str> {
        match self {
            WheelKind::GrouserPassive | WheelKind::Lateral => Some(
                "what lugs and flanks push aside resists with the soil's own cohesion and friction angle, which an interface does not tell",
            ),
            WheelKind::BrakedTwoZone => Some(
                "the zones of a braked wheel meet where the soil's own friction angle has its slip line, which an interface does not tell",
            ),
            _ => None,
        }
    }

    /// The wheel with its numbers on a soil.
    pub(super) fn read<T: Real>(
        self,
        values: &Values<'_, T>,
        at: &Contact<T>,
        soil: Soil<T>,
    ) -> Result<Wheel<T>, ModelError> {
        let radius = at.radius * at.hooks.contact_radius;
        let lug = at.hooks.lug_height;
        let slip = kinematic(at.slip);
        let apex = || -> Result<(T, bool), ModelError> {
            match self {
                WheelKind::LinearStressSymmetric => Ok((T::from(0.5), false)),
                _ => {
                    let c1 = values.get("c1", Must::BeFinite)?;
                    let c2 = values.get("c2", Must::BeFinite)?;
                    apex_ratio(values.model, [c1, c2], at.slip, slip)
                }
            }
        };
        let linear = |exit_ratio, reach: T, bottom_shear| -> Result<Wheel<T>, ModelError> {
            let (apex_ratio, apex_limited) = apex()?;
            Ok(Wheel {
                apex_limited,
                shape: Shape::Linear(Linear {
                    soil,
                    slip,
                    apex_ratio,
                    exit_ratio,
                    radius,
                    shear_radius: radius + reach,
                    torque_arm: at.radius + reach,
                    width: at.width,
                    bottom_shear,
                }),
            })
        };
        match self {
            WheelKind::LinearStress | WheelKind::LinearStressSymmetric => {
                linear(T::zero(), lug, true)
            }
            WheelKind::DingClosed => {
                let exit = values.get("c3", Must::BeFinite)? - at.hooks.exit_ratio;
                let (apex, _) = apex()?;
                quantity(
                    values.model,
                    "c1 + c2 slip - c3",
                    apex - exit,
                    Must::BePositive,
                )?;
                quantity(values.model, "1 + c3", exit + 1.0, Must::BePositive)?;
                let reach = values.get("lug_reach", Must::NotBeNegative)? + lug;
                linear(exit, reach, false)
            }
            WheelKind::ScmColumn => Ok(Wheel {
                apex_limited: false,
                shape: Shape::Column(Column {
                    soil,
                    excess: rim_excess(at.slip),
                    radius,
                    shear_radius: radius + lug,
                    torque_arm: at.radius + lug,
                    width: at.width,
                }),
            }),
            WheelKind::CompliantTyre => {
                let pressure = values.get("tyre_pressure", Must::BePositive)?;
                let lengths = [radius, at.radius, at.width];
                Ok(Wheel {
                    apex_limited: false,
                    shape: Shape::Tyre(Tyre::new(soil, slip, pressure, lengths)),
                })
            }
            // Lanes that are driven beside braked ones have one zone of it, which is the same rim.
            WheelKind::BrakedTwoZone if at.slip.primal().any_lt(T::Primal::zero()) => {
                let (apex_ratio, _) = apex()?;
                Ok(Wheel {
                    apex_limited: false,
                    shape: Shape::TwoZones(TwoZones {
                        zones: Zones::new(soil.strength.tan_friction, at.slip, slip, apex_ratio),
                        soil,
                        radius,
                        torque_arm: at.radius,
                        width: at.width,
                    }),
                })
            }
            WheelKind::WongReece
            | WheelKind::GrouserPassive
            | WheelKind::Lateral
            | WheelKind::BrakedTwoZone => {
                let (apex_ratio, apex_limited) = apex()?;
                let broken = || -> Result<Broken<T>, ModelError> {
                    Ok(Broken {
                        cohesion: values.get("cohesion", Must::NotBeNegative)?,
                        angle: values.get("friction_angle", Must::BeAcute)?,
                        weight: values.get("unit_weight", Must::NotBeNegative)?,
                    })
                };
                let (mut lugs, mut side) = (None, None);
                if self == WheelKind::GrouserPassive {
                    let count = values.get("lug_count", Must::NotBeNegative)?;
                    let height = values.get("lug_height", Must::NotBeNegative)?;
                    lugs = Some(Lugs::new(broken()?, count, height));
                }
                if self == WheelKind::Lateral {
                    let modulus = values.get("lateral_shear_modulus", Must::BePositive)?
                        * at.hooks.shear_modulus;
                    side = Some(Side::new(broken()?, modulus, at.slip_angle)?);
                }
                Ok(Wheel {
                    apex_limited,
                    shape: Shape::Rim(Rim {
                        soil,
                        slip,
                        apex_ratio,
                        exit_ratio: at.hooks.exit_ratio,
                        radius,
                        shear_radius: radius + lug,
                        torque_arm: at.radius + lug,
                        width: at.width,
                        lugs,
                        side,
                        turned: at.hooks.lateral_slip.filter(|tan| {
                            !is_plain::<T>() || T::Primal::zero().any_lt(tan.abs().primal())
                        }),
                    }),
                })
            }
        }
    }
}

/// A wheel with its numbers.
#[derive(Clone, Copy)]
pub(super) struct Wheel<T> {
    apex_limited: bool,
    shape: Shape<T>,
}

#[derive(Clone, Copy)]
enum Shape<T> {
    Rim(Rim<T>),
    Linear(Linear<T>),
    Column(Column<T>),
    Tyre(Tyre<T>),
    TwoZones(TwoZones<T>),
}

impl<T: Real> Wheel<T> {
    pub(super) fn map<S: Real>(&self, f: impl Fn(T) -> S + Copy) -> Wheel<S> {
        Wheel {
            apex_limited: self.apex_limited,
            shape: match &self.shape {
                Shape::Rim(w) => Shape::Rim(w.map(f)),
                Shape::Linear(w) => Shape::Linear(w.map(f)),
                Shape::Column(w) => Shape::Column(w.map(f)),
                Shape::Tyre(w) => Shape::Tyre(w.map(f)),
                Shape::TwoZones(w) => Shape::TwoZones(w.map(f)),
            },
        }
    }

    /// Forces at an entry angle.
    pub(super) fn sums(&self, entry: T) -> Sums<T> {
        match &self.shape {
            Shape::Rim(w) => w.sums(entry),
            Shape::Linear(w) => w.sums(entry),
            Shape::Column(w) => w.sums(entry),
            Shape::Tyre(w) => w.sums(entry),
            Shape::TwoZones(w) => w.sums(entry),
        }
    }

    /// What is carried at an entry angle.
    pub(super) fn load(&self, entry: T) -> T {
        match &self.shape {
            Shape::Rim(w) => w.sums(entry).load,
            Shape::Linear(w) => w.sums(entry).load,
            Shape::Column(w) => w.load(entry),
            Shape::Tyre(w) => w.load(entry),
            Shape::TwoZones(w) => w.sums(entry).load,
        }
    }

    /// True where the shear stress has a part in it.
    pub(super) fn shear_carries(&self) -> bool {
        !matches!(self.shape, Shape::Column(_))
    }

    pub(super) fn soil(&self) -> &Soil<T> {
        match &self.shape {
            Shape::Rim(w) => &w.soil,
            Shape::Linear(w) => &w.soil,
            Shape::Column(w) => &w.soil,
            Shape::Tyre(w) => w.soil(),
            Shape::TwoZones(w) => &w.soil,
        }
    }

    pub(super) fn radius(&self) -> T {
        match &self.shape {
            Shape::Rim(w) => w.radius,
            Shape::Linear(w) => w.radius,
            Shape::Column(w) => w.radius,
            Shape::Tyre(w) => w.radius(),
            Shape::TwoZones(w) => w.radius,
        }
    }

    /// Exit angle and angle of largest stress.
    pub(super) fn angles(&self, entry: T) -> (T, T) {
        match &self.shape {
            Shape::Rim(w) => (w.exit(entry), w.apex(entry)),
            Shape::Linear(w) => (w.exit(entry), w.apex(entry)),
            Shape::Column(_) => (T::zero(), T::zero()),
            Shape::Tyre(w) => {
                let from = w.flat_from(entry);
                (-from, from)
            }
            Shape::TwoZones(w) => (T::zero(), w.apex(entry)),
        }
    }

    /// How deep the lowest point of the wheel lies below the surface that it meets.
    pub(super) fn sinkage(&self, entry: T) -> T {
        if let Shape::Tyre(w) = &self.shape {
            return w.sinkage(entry);
        }
        let (sin_half, _) = (entry * 0.5).sin_cos();
        self.radius() * sin_half.squared() * 2.0
    }

    /// True where the angle of largest stress was held inside the contact.
    pub(super) fn apex_limited(&self, entry: T) -> bool {
        match &self.shape {
            Shape::TwoZones(w) => w.zones.held(entry),
            _ => self.apex_limited,
        }
    }

    /// How exactly the iteration finds the entry angle before its last step.
    pub(super) fn tolerance(&self) -> f64 {
        match &self.shape {
            Shape::Tyre(_) => FINE_TOLERANCE,
            _ => TOLERANCE,
        }
    }

    /// The angle up to which the load of a driven wheel rises with its sinkage.
    pub(super) fn rises_to(&self) -> f64 {
        match &self.shape {
            Shape::Column(_) => MAX_ENTRY_ANGLE,
            Shape::Rim(_) | Shape::Linear(_) | Shape::Tyre(_) | Shape::TwoZones(_)
                if self.soil().strength.falls() =>
            {
                0.0
            }
            Shape::Tyre(_) | Shape::TwoZones(_) => MAX_ENTRY_ANGLE,
            Shape::Rim(w) if w.exit_ratio.primal().max_lane() > RISING_EXIT => 0.0,
            Shape::Rim(_) => MAX_ENTRY_ANGLE,
            Shape::Linear(w) if w.exit_ratio.primal().abs().max_lane() > 0.0 => {
                LINEAR_WITH_EXIT_RISES_TO
            }
            Shape::Linear(_) => LINEAR_RISES_TO,
        }
    }
}

impl Wheel<f64> {
    pub(super) fn stress_at(&self, entry: f64, angle: f64) -> StressPoint {
        match &self.shape {
            Shape::Rim(w) => w.stress_at(entry, angle),
            Shape::Linear(w) => w.stress_at(entry, angle),
            Shape::Column(w) => w.stress_at(entry, angle),
            Shape::Tyre(w) => w.stress_at(entry, angle),
            Shape::TwoZones(w) => w.stress_at(entry, angle),
        }
    }

    /// The passage of one lug, where lugs push.
    pub(super) fn lug_cycle(&self, entry: f64, moments: usize) -> Option<Vec<LugPhase>> {
        match &self.shape {
            Shape::Rim(w) => w.lug_cycle(entry, moments),
            _ => None,
        }
    }

    /// Half the angle under which a tyre lies flat, where it does.
    pub(super) fn flat(&self, entry: f64) -> Option<f64> {
        match &self.shape {
            Shape::Tyre(w) => Some(w.flat_from(entry)).filter(|from| *from > 0.0),
            _ => None,
        }
    }
}
