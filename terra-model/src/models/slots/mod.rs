//! Wheels put together from slots: `wheel:pressure:shear`, e.g. `wong-reece:reece:wong-hump`.
//!
//! A wheel says where stresses act, a pressure law how the normal stress grows with sinkage, a shear law how the shear
//! stress grows with displacement. Parameters are those of the pressure law, of the shear law, of the wheel, in that
//! order. A load gives the entry angle; its derivatives follow from one implicit step.
//!
//! `wong-reece`, `linear-stress`, `compliant-tyre` and `braked-two-zone` with their default laws are models of their own, fast
//! ones; here are the same wheels for every other law.
//!
//! To add a law is to add a variant to [`pressure`] or [`shear`], a wheel one to [`wheel`].

pub(super) mod checks;
mod column;
mod contact_state;
mod fillings;
mod linear;
mod params;
mod pieces;
mod pressure;
mod pushed;
mod rim;
mod shear;
mod two_zones;
mod typical;
mod tyre;
mod wheel;

use std::sync::{Arc, OnceLock};

use nalgebra::DMatrix;

use crate::batch::{Batch, BatchForces, Precision};
use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::forces::{Angles, Contributions, Flags, WheelForces};
use crate::guard::guard;
use crate::lugs::LugPhase;
use crate::model::{AnyModel, ModelAt, Soil};
use crate::names::nearest;
use crate::param::Param;
use crate::real::{Real, Root, is_plain};
use crate::root::{entry_angle, rises_to};
use crate::stress::StressField;
use checks::Values;
use contact_state::Sums;
pub use fillings::{Filling, Slots};
use pressure::{Layer, PressureKind};
use shear::ShearKind;
use wheel::{Wheel, WheelKind};

/// Nodes a piece: as many as the plain wheel has, 1e-11 for the power law.
const NODES: usize = 16;
/// The same for fits: 1e-4 of the forces, 2e-3 where a shear law peaks within a piece.
const QUICK_NODES: usize = 5;

/// One combination of slots. All of them are listed once, so that names and parameters live as long as the program.
struct Combination {
    wheel: WheelKind,
    pressure: PressureKind,
    shear: ShearKind,
    name: String,
    summary: String,
    equation: String,
    reference: String,
    params: Vec<Param>,
    hooks: Vec<Hook>,
}

impl Combination {
    fn new(wheel: WheelKind, pressure: PressureKind, shear: ShearKind) -> Self {
        let mut name = wheel.name().to_owned();
        let plain_shear = shear == ShearKind::JanosiHanamoto;
        if pressure != wheel.default_pressure() || !plain_shear {
            name.push(':');
            name.push_str(pressure.name());
        }
        if !plain_shear {
            name.push(':');
            name.push_str(shear.name());
        }
        let mut params = pressure.params(shear.is_of_the_soil());
        params.extend(shear.params());
        for more in wheel.params() {
            // The weight of the soil is one number, whoever asks for it.
            if params.iter().all(|p| p.name != more.name) {
                params.push(*more);
            }
        }
        let mut hooks = [pressure.hooks(), shear.hooks(), wheel.hooks()].concat();
        if wheel.knows_only_the_apex() {
            hooks.retain(|h| !matches!(h, Hook::Layer | Hook::ShearHump));
        }
        Combination {
            wheel,
            pressure,
            shear,
            summary: format!(
                "{}; {}, {}",
                wheel.summary(),
                pressure.summary(),
                shear.summary()
            ),
            equation: wheel.equations().join("\n\n"),
            reference: format!(
                "{}; {}; {}",
                wheel.reference(),
                pressure.reference(),
                shear.reference()
            ),
            name,
            params,
            hooks,
        }
    }
}

fn combinations() -> &'static [Combination] {
    static ALL: OnceLock<Vec<Combination>> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut all = vec![];
        for wheel in WheelKind::ALL {
            for pressure in PressureKind::ALL {
                for shear in ShearKind::ALL {
                    if senseless(wheel, shear).is_none() {
                        all.push(Combination::new(wheel, pressure, shear));
                    }
                }
            }
        }
        all
    })
}

/// Why a wheel and a shear law do not go together.
fn senseless(wheel: WheelKind, shear: ShearKind) -> Option<&'static str> {
    if wheel.knows_only_the_apex() && shear.falls() {
        return Some(
            "this closed form knows the shear stress at its apex alone, and the law peaks elsewhere along the contact",
        );
    }
    wheel.asks_the_soil().filter(|_| !shear.is_of_the_soil())
}

/// A wheel put together from slots.
#[derive(Clone, Copy)]
pub(crate) struct Composed {
    of: &'static Combination,
    /// By a short rule in lanes; one contact is as exact as ever.
    quick: bool,
}

/// The wheels of the slots that are presets of their own, with their default laws.
pub(crate) fn presets() -> impl Iterator<Item = Composed> {
    [
        WheelKind::LinearStressSymmetric,
        WheelKind::ScmColumn,
        WheelKind::DingClosed,
        WheelKind::GrouserPassive,
        WheelKind::Lateral,
    ]
    .into_iter()
    .filter_map(|wheel| find(wheel, wheel.default_pressure(), ShearKind::JanosiHanamoto))
}

fn find(wheel: WheelKind, pressure: PressureKind, shear: ShearKind) -> Option<Composed> {
    combinations()
        .iter()
        .find(|c| (c.wheel, c.pressure, c.shear) == (wheel, pressure, shear))
        .map(Composed::exact)
}

/// The item of that name.
fn slot<K: Copy>(
    kind: &'static str,
    all: &[K],
    name_of: impl Fn(K) -> &'static str,
    name: &str,
) -> Result<K, ModelError> {
    all.iter()
        .copied()
        .find(|k| name_of(*k) == name)
        .ok_or_else(|| ModelError::UnknownName {
            kind,
            name: name.to_owned(),
            nearest: nearest(name, all.iter().map(|k| name_of(*k))).map(str::to_owned),
        })
}

/// What `wheel:pressure[:shear]` means: the combination, whose own name leaves out what goes without saying.
///
/// `registered` are the names of whole models, which have no slots unless they are wheels of this list.
///
/// # Errors
/// [`ModelError::UnknownName`] for the slot that nobody knows; [`ModelError::Combination`] for slots on a model that
/// has none, too many slots, or slots that do not go together.
pub(crate) fn by_name(name: &str, registered: &[&'static str]) -> Result<Composed, ModelError> {
    let combination = |reason: String| ModelError::Combination {
        name: name.to_owned(),
        reason,
    };
    let parts: Vec<&str> = name.split(':').collect();
    let (wheel, pressure, shear) = match parts.as_slice() {
        [wheel] => (*wheel, None, None),
        [wheel, pressure] => (*wheel, Some(*pressure), None),
        [wheel, pressure, shear] => (*wheel, Some(*pressure), Some(*shear)),
        _ => {
            return Err(combination(
                "a wheel has two slots, wheel:pressure:shear".to_owned(),
            ));
        }
    };
    let is_wheel = WheelKind::ALL.iter().any(|k| k.name() == wheel);
    if registered.contains(&wheel) && !is_wheel {
        return Err(combination(format!(
            "{wheel} is a whole model without slots"
        )));
    }
    if !registered.contains(&wheel) {
        return Err(ModelError::UnknownName {
            kind: "wheel",
            name: wheel.to_owned(),
            nearest: nearest(wheel, registered.iter().copied()).map(str::to_owned),
        });
    }
    let wheel = slot("wheel", &WheelKind::ALL, WheelKind::name, wheel)?;
    // A law in the other's place is no typing error.
    let is_shear = |name: &str| ShearKind::ALL.iter().any(|k| k.name() == name);
    let is_pressure = |name: &str| PressureKind::ALL.iter().any(|k| k.name() == name);
    if pressure.is_some_and(is_shear) || shear.is_some_and(is_pressure) {
        let laws = [pressure, shear].into_iter().flatten();
        let of = |is: &dyn Fn(&str) -> bool| laws.clone().find(|name| is(name));
        let pressure = of(&is_pressure).unwrap_or(wheel.default_pressure().name());
        let shear = of(&is_shear).unwrap_or(ShearKind::JanosiHanamoto.name());
        let meant = format!("{}:{pressure}:{shear}", wheel.name());
        // What was meant may be refused in turn; then the reason is the answer.
        by_name(&meant, registered)?;
        return Err(combination(format!(
            "the pressure law comes before the shear law: {meant}"
        )));
    }
    let pressure = match pressure {
        Some(p) => slot("pressure law", &PressureKind::ALL, PressureKind::name, p)?,
        None => wheel.default_pressure(),
    };
    let shear = match shear {
        Some(s) => slot("shear law", &ShearKind::ALL, ShearKind::name, s)?,
        None => ShearKind::JanosiHanamoto,
    };
    find(wheel, pressure, shear).ok_or_else(|| {
        let reason = senseless(wheel, shear).unwrap_or("these slots do not go together");
        combination(reason.to_owned())
    })
}

impl Composed {
    fn exact(of: &'static Combination) -> Self {
        Composed { of, quick: false }
    }

    /// This model, shared.
    pub(crate) fn shared(self) -> Arc<dyn AnyModel> {
        Arc::new(self)
    }

    fn values<'a, T>(&self, p: &'a [T]) -> Result<Values<'a, T>, ModelError> {
        let c = self.of;
        if p.len() != c.params.len() {
            return Err(ModelError::ParameterCount {
                model: c.name.clone(),
                expected: c.params.len(),
                found: p.len(),
            });
        }
        Ok(Values {
            model: &c.name,
            params: &c.params,
            p,
        })
    }

    fn wheel<T: Real>(&self, p: &[T], at: &Contact<T>) -> Result<Wheel<T>, ModelError> {
        checks::contact(at)?;
        let c = self.of;
        let values = self.values(p)?;
        let strength = c.shear.read(&values, at)?;
        let (law, own_layer) = c.pressure.read(&values, at)?;
        // A layer at depth zero is no layer; one of no extra stiffness only where it carries a derivative.
        let above_zero = |x: T| T::Primal::zero().any_lt(x.primal());
        let hooks = &at.hooks;
        let felt = above_zero(hooks.layer_depth)
            && (!is_plain::<T>() || above_zero(hooks.layer_stiffness));
        let hooked = felt.then_some(Layer {
            depth: hooks.layer_depth,
            stiffness: hooks.layer_stiffness,
        });
        let in_lanes = const { T::Primal::NODES_AT_ONCE == 1 };
        let quick = const { T::FOR_FITS } || (self.quick && in_lanes);
        let soil = contact_state::Soil::new(law, [own_layer, hooked], strength, quick);
        c.wheel.read(&values, at, soil)
    }

    /// The entry angle that carries the load: iterated in the primal, its derivatives by one implicit step.
    fn entry<T: Real>(wheel: &Wheel<T>, at: &Contact<T>) -> Result<T, ModelError> {
        type Tangent<T> = <<T as Real>::Primal as Root>::Tangent;
        let primal = wheel.map(T::primal);
        let load = at.normal_load.primal();
        let guess = primal
            .soil()
            .pressure
            .entry_guess(load, primal.radius(), at.width.primal());
        let tangent: Wheel<Tangent<T>> = primal.map(Tangent::<T>::from_primal);
        // A normal stress that carries alone is the same whichever way the rim moves.
        let slip = if wheel.shear_carries() {
            at.slip.primal()
        } else {
            T::Primal::zero()
        };
        let rises_to = rises_to(slip, wheel.rises_to());
        let tolerance = wheel.tolerance();
        let found = entry_angle(load, guess, slip, rises_to, tolerance, |angle| {
            tangent.load(angle)
        })?;
        Ok(found.with_derivatives(at.normal_load, |root| wheel.load(root)))
    }
}

impl<T: Real> ModelAt<T> for Composed {
    fn wheel_forces_at(&self, p: &[T], at: &Contact<T>) -> Result<WheelForces<T>, ModelError> {
        let wheel = self.wheel(p, at)?;
        let entry = Self::entry(&wheel, at)?;
        let Sums {
            thrust,
            lug_thrust,
            compaction,
            bulldozing,
            torque,
            lateral,
            ..
        } = wheel.sums(entry);
        let sinkage = wheel.sinkage(entry) + wheel.soil().pressure.floor();
        let (exit, max_stress) = wheel.angles(entry);
        Ok(WheelForces {
            drawbar_pull: thrust + lug_thrust - compaction - bulldozing,
            resistive_torque: torque,
            lateral_force: lateral,
            sinkage: Some(sinkage),
            angles: Some(Angles {
                entry,
                exit,
                max_stress,
            }),
            parts: Contributions {
                thrust,
                lug_thrust,
                compaction_resistance: compaction,
                bulldozing_resistance: bulldozing,
                other: T::zero(),
            },
            flags: Flags {
                braking: at.slip.primal().any_lt(T::Primal::zero()),
                apex_limited: wheel.apex_limited(entry),
                deep_sinkage: (at.radius * 0.5).primal().any_lt(sinkage.primal()),
            },
        })
    }

    fn soil_at(&self, p: &[T], at: &Contact<T>) -> Soil<T> {
        let mut soil = Soil::unknown();
        let named = |name: &str| {
            let place = self.of.params.iter().position(|q| q.name == name)?;
            p.get(place).copied()
        };
        soil.cohesion = named("cohesion");
        soil.friction_angle = named("friction_angle");
        soil.shear_modulus = named("shear_modulus");
        let width = at.width;
        let n = named("sinkage_exponent");
        if let (Some(k_c), Some(k_phi)) = (named("k_c"), named("k_phi")) {
            soil.stiffness = Some(k_c / width + k_phi);
        }
        if let (Some(c), Some(k_c), Some(weight), Some(k_phi), Some(n)) = (
            soil.cohesion,
            named("k_c_prime"),
            named("unit_weight"),
            named("k_phi_prime"),
            n,
        ) {
            soil.stiffness = Some((c * k_c + weight * width * k_phi) * width.pow_pos(-n));
        }
        let growth = named("slip_exponent").map(|n1| n1 * at.slip.abs());
        soil.sinkage_exponent = n.map(|n| growth.map_or(n, |more| n + more));
        soil
    }
}

impl AnyModel for Composed {
    fn name(&self) -> &'static str {
        &self.of.name
    }
    fn summary(&self) -> &'static str {
        &self.of.summary
    }
    fn params(&self) -> &'static [Param] {
        &self.of.params
    }
    fn equation(&self) -> &'static str {
        &self.of.equation
    }
    fn reference(&self) -> &'static str {
        &self.of.reference
    }
    fn hooks(&self) -> &'static [Hook] {
        &self.of.hooks
    }
    fn force_slopes(
        &self,
        _: &[f64],
        _: &Contact<f64>,
    ) -> Result<Option<(WheelForces<f64>, DMatrix<f64>)>, ModelError> {
        Ok(None)
    }
    fn batch(
        &self,
        batch: &Batch<'_>,
        _: Precision,
        out: &mut BatchForces,
    ) -> Result<(), ModelError> {
        batch.check(self.name(), self.params().len())?;
        batch.side_by_side(
            out,
            true,
            |p, at| guard(self.name(), self.params(), p, at),
            |p, at| self.wheel_forces_at(p, at),
            |p, at| self.wheel_forces_at(p, at),
        );
        Ok(())
    }
    fn quick_model(&self) -> Option<Arc<dyn AnyModel>> {
        Some(
            Composed {
                quick: true,
                ..*self
            }
            .shared(),
        )
    }
    fn lug_cycle(
        &self,
        p: &[f64],
        at: &Contact<f64>,
        moments: usize,
    ) -> Result<Option<Vec<LugPhase>>, ModelError> {
        let wheel = self.wheel(p, at)?;
        Ok(wheel.lug_cycle(Self::entry(&wheel, at)?, moments))
    }
    fn typical_parameters(&self) -> Vec<Vec<f64>> {
        typical::parameters(self.params())
    }
    fn is_rival(&self) -> bool {
        // What a combination has beyond the catalogue's parameters is of no soil in particular.
        false
    }
    fn stress_field(
        &self,
        p: &[f64],
        at: &Contact<f64>,
    ) -> Result<Option<StressField>, ModelError> {
        let wheel = self.wheel(p, at)?;
        let entry = Self::entry(&wheel, at)?;
        let (exit, apex) = wheel.angles(entry);
        let flat = wheel.flat(entry);
        let mut field = StressField::new(exit, apex, entry, move |angle| {
            wheel.stress_at(entry, angle)
        });
        field.flat = flat;
        Ok(Some(field))
    }
}

#[cfg(test)]
mod tests;
