//! The scalar of all model code: a number, a dual number, or eight numbers side by side.

use std::any::TypeId;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use num_dual::{Dual64, DualNum, DualStruct};
use wide::f64x8;

use crate::lanes::{Lanes, Vector};

/// A scalar that models and effects compute with: `f64`, a dual number (exact derivatives) or [`Lanes`](crate::Lanes) (SIMD).
///
/// Not a subtrait of `DualNum`: lanes have no single real part and no order. The only branch allowed in model code
/// is [`select_lt`](Real::select_lt), because eight lanes cannot take two branches at once.
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// The type roots are iterated in: `f64` for `f64` and duals, [`Lanes`](crate::Lanes) for lanes.
    type Primal: Root;
    /// Whether it is made for fits, to which a law right to 1e-7 is as good as an exact one.
    const FOR_FITS: bool = false;

    /// Whether it may have a derivative other than zero: what is known not to vary need not be carried through.
    #[inline]
    fn varies(&self) -> bool {
        true
    }
    /// The value without derivatives.
    fn primal(self) -> Self::Primal;
    /// A constant (zero derivatives) with the given value.
    fn from_primal(value: Self::Primal) -> Self;
    /// `yes` where `self < b`, else `no`; derivatives follow the chosen side.
    fn select_lt(self, b: Self, yes: Self, no: Self) -> Self;
    /// e^x.
    fn exp(self) -> Self;
    /// e^x - 1, accurate near zero.
    fn exp_m1(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Arc tangent.
    fn atan(self) -> Self;

    /// Zero.
    fn zero() -> Self {
        Self::from(0.0)
    }
    /// One.
    fn one() -> Self {
        Self::from(1.0)
    }
    /// x^y for x > 0.
    fn pow_pos(self, y: Self) -> Self {
        (self.ln() * y).exp()
    }
    /// Tangent.
    fn tan(self) -> Self {
        let (s, c) = self.sin_cos();
        s / c
    }
    /// Magnitude; the derivative at 0 is that of the positive side.
    fn abs(self) -> Self {
        self.select_lt(Self::zero(), -self, self)
    }
    /// The smaller of two.
    fn min_of(self, b: Self) -> Self {
        self.select_lt(b, self, b)
    }
    /// The larger of two.
    fn max_of(self, b: Self) -> Self {
        self.select_lt(b, b, self)
    }
    /// The product with a constant.
    fn scaled(self, by: Self::Primal) -> Self {
        self * Self::from_primal(by)
    }
    /// Adds a multiple of another.
    fn add_scaled(&mut self, x: &Self, by: Self::Primal) {
        *self += x.scaled(by);
    }
    /// The square.
    fn squared(self) -> Self {
        self * self
    }
}

/// True for scalars without derivatives. Decided at compile time.
#[inline]
pub(crate) fn is_plain<T: Real>() -> bool {
    TypeId::of::<T>() == TypeId::of::<T::Primal>()
}

/// A [`Real`] in which roots are iterated: it can be compared as a whole and can carry one derivative.
pub trait Root: Real<Primal = Self> {
    /// The same number with one derivative.
    type Tangent: Real<Primal = Self>;
    /// The type in which the nodes of an integral are summed: a number puts nodes side by side, lanes are side by side
    /// already.
    type Nodes: Vector;
    /// How many nodes that type holds.
    const NODES_AT_ONCE: usize;

    /// A variable: derivative 1.
    fn seed(self) -> Self::Tangent;
    /// Value and derivative.
    fn parts(x: Self::Tangent) -> (Self, Self);
    /// True when `self < b` in at least one lane.
    fn any_lt(self, b: Self) -> bool;
    /// True when every lane is finite.
    fn is_finite(self) -> bool;
    /// Smallest lane.
    fn min_lane(self) -> f64;
    /// Largest lane.
    fn max_lane(self) -> f64;
    /// The same for every node.
    fn spread(self) -> Self::Nodes;
    /// The sum over nodes.
    fn total(sum: Self::Nodes) -> Self;
    /// The first `NODES_AT_ONCE` values of a table over nodes.
    fn table(values: &[f64]) -> Self::Nodes;
}

impl<T> Real for T
where
    T: DualNum<Primitive = f64> + DualStruct<Real = f64> + Copy + Send + Sync,
{
    type Primal = f64;

    #[inline]
    fn primal(self) -> f64 {
        self.re()
    }
    #[inline]
    fn from_primal(value: f64) -> Self {
        T::from(value)
    }
    #[inline]
    fn select_lt(self, b: Self, yes: Self, no: Self) -> Self {
        if self.re() < b.re() { yes } else { no }
    }
    #[inline]
    fn exp(self) -> Self {
        DualNum::exp(&self)
    }
    #[inline]
    fn exp_m1(self) -> Self {
        DualNum::exp_m1(&self)
    }
    #[inline]
    fn ln(self) -> Self {
        DualNum::ln(&self)
    }
    #[inline]
    fn sqrt(self) -> Self {
        DualNum::sqrt(&self)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        DualNum::sin_cos(&self)
    }
    #[inline]
    fn tanh(self) -> Self {
        // As value and slope: sinh/cosh² overflows where the slope has long been 0.
        let value = self.re().tanh();
        if is_plain::<T>() {
            return T::from(value);
        }
        T::from(value) + (self - T::from(self.re())) * (1.0 - value * value)
    }
    #[inline]
    fn atan(self) -> Self {
        DualNum::atan(&self)
    }
}

impl Root for f64 {
    type Tangent = Dual64;

    #[inline]
    fn seed(self) -> Dual64 {
        Dual64::from_re(self).derivative()
    }
    #[inline]
    fn parts(x: Dual64) -> (f64, f64) {
        (x.re, x.eps)
    }
    #[inline]
    fn any_lt(self, b: f64) -> bool {
        self < b
    }
    #[inline]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
    #[inline]
    fn min_lane(self) -> f64 {
        self
    }
    #[inline]
    fn max_lane(self) -> f64 {
        self
    }

    type Nodes = Lanes;
    const NODES_AT_ONCE: usize = 8;
    #[inline]
    fn spread(self) -> Lanes {
        Lanes::from(self)
    }
    #[inline]
    fn total(sum: Lanes) -> f64 {
        sum.0.reduce_add()
    }
    #[inline]
    fn table(values: &[f64]) -> Lanes {
        match values.first_chunk::<8>() {
            Some(&eight) => Lanes(f64x8::new(eight)),
            None => Lanes::gather(values.iter().copied()),
        }
    }
}
