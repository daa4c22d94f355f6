//! The wheel digs itself in as it slips: the sinkage exponent grows with slip.
//!
//! # Equation
//! n -> n + e |s|
//!
//! # Reference
//! L. Ding et al., J. Field Robotics 28(6), 2011: n = n0 + n1 s (formula recalled).

use crate::contact::{Contact, Hook};
use crate::effect::{Circumstance, Effect, Touch};
use crate::model::Soil;
use crate::param::Param;
use crate::real::Real;

/// The wheel digs itself in as it slips: the sinkage exponent grows with slip.
#[derive(Clone, Copy, Debug, Default)]
pub struct SlipSinkage;

impl Effect for SlipSinkage {
    const NAME: &'static str = "slip-sinkage";
    const SUMMARY: &'static str =
        "the wheel digs itself in as it slips: the sinkage exponent grows with slip";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "1",
        [0.0, 5.0],
        0.4,
        "growth of the sinkage exponent with slip",
    )];
    const EQUATION: &'static str = "n -> n + e |s|";
    const REFERENCE: &'static str =
        "L. Ding et al., J. Field Robotics 28(6), 2011: n = n0 + n1 s (formula recalled)";
    const NEEDS: &'static [Hook] = &[Hook::SinkageExponent];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const BESIDE_SLIP_AND_LOAD: Option<&'static [Circumstance]> = Some(&[]);
    const REGIME: &'static str = "pull down, torque and sinkage up, slip above .3";
    const ISOLATED_BY: &'static str = "sinkage sensor, or the same slip at two loads";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.sinkage_exponent += e[0] * at.slip.abs();
    }
}
