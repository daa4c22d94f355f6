//! Scalars that hold eight contacts, whatever else they carry.

use super::{LaneDual, Lanes};
use crate::scalar::Scalar;

/// A scalar whose primal is [`Lanes`].
pub trait Abreast: Scalar<Primal = Lanes> {
    /// The sum over its lanes, in each of them.
    #[must_use]
    fn total_of_lanes(self) -> Self;
}

impl Abreast for Lanes {
    fn total_of_lanes(self) -> Self {
        Lanes::from(self.0.reduce_add())
    }
}

impl Abreast for LaneDual {
    fn total_of_lanes(self) -> Self {
        self.totalled()
    }
}
