//! The scalars at which erased models and effects can be called.

use crate::dual::Dual8;
use crate::effect::{AnyEffect, EffectAt};
use crate::lanes::{LaneDual, Lanes};
use crate::model::{AnyModel, ModelAt};
use crate::real::Real;

/// A scalar at which erased models and effects can be called, so that generic code can use them too.
pub trait Scalar: Real {
    /// The model at this scalar.
    fn of_model(model: &dyn AnyModel) -> &dyn ModelAt<Self>;
    /// The effect at this scalar.
    fn of_effect(effect: &dyn AnyEffect) -> &dyn EffectAt<Self>;
}

impl Scalar for f64 {
    fn of_model(model: &dyn AnyModel) -> &dyn ModelAt<Self> {
        model
    }
    fn of_effect(effect: &dyn AnyEffect) -> &dyn EffectAt<Self> {
        effect
    }
}
impl Scalar for Dual8 {
    fn of_model(model: &dyn AnyModel) -> &dyn ModelAt<Self> {
        model
    }
    fn of_effect(effect: &dyn AnyEffect) -> &dyn EffectAt<Self> {
        effect
    }
}
impl Scalar for Lanes {
    fn of_model(model: &dyn AnyModel) -> &dyn ModelAt<Self> {
        model
    }
    fn of_effect(effect: &dyn AnyEffect) -> &dyn EffectAt<Self> {
        effect
    }
}
impl Scalar for LaneDual {
    fn of_model(model: &dyn AnyModel) -> &dyn ModelAt<Self> {
        model
    }
    fn of_effect(effect: &dyn AnyEffect) -> &dyn EffectAt<Self> {
        effect
    }
}
