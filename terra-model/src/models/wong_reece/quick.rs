//! The same law of contacts side by side at less than half the cost, driven to 1e-5 and braked to 1e-4: for fits, whose data know
//! forces to a hundredth. Where the soil is about to give way under a braked wheel a load hardly holds its entry angle: there that
//! is right to 1e-3.

use super::gradient::{SIDEWAYS, STRAIGHT};
use super::solve::Start;
use super::wheel::Integrals;
use super::{WongReece, solve};
use crate::contact::{Contact, Hook};
use crate::error::ModelError;
use crate::forces::WheelForces;
use crate::model::{ForceSlopes, Soil, TerrainModel};
use crate::models::bekker;
use crate::param::Param;
use crate::real::{Real, Root};
use crate::stress::StressField;

/// Nodes a piece in the first steps of driven wheels, of braked ones, whose first rule must see a fold that its load may have, and
/// in the last of any.
const SHORT: usize = 3;
const BRAKED: usize = 5;
const LAST: usize = 5;

/// The law by a short rule in lanes; one contact is as exact as ever.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quick;

impl TerrainModel for Quick {
    const NAME: &'static str = WongReece::NAME;
    const SUMMARY: &'static str = WongReece::SUMMARY;
    const PARAMS: &'static [Param] = WongReece::PARAMS;
    const EQUATION: &'static str = WongReece::EQUATION;
    const REFERENCE: &'static str = WongReece::REFERENCE;
    const HOOKS: &'static [Hook] = WongReece::HOOKS;
    const BY_SLIP_AND_LOAD: bool = WongReece::BY_SLIP_AND_LOAD;

    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        if const { T::Primal::NODES_AT_ONCE > 1 } {
            return WongReece.wheel_forces(p, at);
        }
        let wheel = WongReece::wheel(p, at)?;
        let from = Start::of(at);
        let (entry, integrals): (T, Integrals<T>) = match (wheel.lateral.is_some(), wheel.braking) {
            (true, true) => solve::balance::<T, BRAKED, LAST, SIDEWAYS>(&wheel, at, from)?,
            (true, false) => solve::balance::<T, SHORT, LAST, SIDEWAYS>(&wheel, at, from)?,
            (false, true) => solve::balance::<T, BRAKED, LAST, STRAIGHT>(&wheel, at, from)?,
            (false, false) => solve::balance::<T, SHORT, LAST, STRAIGHT>(&wheel, at, from)?,
        };
        Ok(WongReece::named(&wheel, at, entry, integrals))
    }

    fn slopes(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<ForceSlopes>, ModelError> {
        WongReece.slopes(p, at)
    }

    fn soil<T: Real>(&self, p: &[T], at: &Contact<T>) -> Soil<T> {
        bekker::soil(p, at)
    }

    fn stresses(&self, p: &[f64], at: &Contact<f64>) -> Result<Option<StressField>, ModelError> {
        WongReece.stresses(p, at)
    }
}
