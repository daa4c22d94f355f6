//! Scalars that hold eight contacts, whatever else they carry.

use super::{LaneDual, Lanes, Vector};
use crate::scalar::Scalar;

/// A scalar whose primal is [`Lanes`].
pub trait Abreast: Scalar<Primal = Lanes> {
    /// The sum over its lanes, in each of them.
    #[must_use]
    fn total_of_lanes(self) -> Self;
    /// Σ a b, lane by lane.
    fn dot<'a>(pairs: impl Iterator<Item = (&'a Self, Lanes)>) -> Self
    where
        Self: 'a;
}

impl Abreast for Lanes {
    fn total_of_lanes(self) -> Self {
        Lanes::from(self.0.reduce_add())
    }
    #[inline]
    fn dot<'a>(pairs: impl Iterator<Item = (&'a Self, Lanes)>) -> Self {
        pairs.fold(Lanes::from(0.0), |sum, (a, b)| Vector::mul_add(*a, b, sum))
    }
}

impl Abreast for LaneDual {
    fn total_of_lanes(self) -> Self {
        self.totalled()
    }
    #[inline]
    fn dot<'a>(pairs: impl Iterator<Item = (&'a Self, Lanes)>) -> Self {
        LaneDual::dotted(pairs)
    }
}
