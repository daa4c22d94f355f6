//! Numbers side by side, and the same with one derivative: the SIMD scalars.

mod abreast;
mod dual;
mod vector;

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use wide::{f32x16, f64x8};

use crate::real::{Real, Root};
pub use abreast::Abreast;
pub use dual::LaneDual;
pub use vector::Vector;

/// Eight contacts side by side: the SIMD scalar.
#[derive(Clone, Copy, Debug)]
pub struct Lanes(pub f64x8);

/// Sixteen contacts side by side in single precision.
#[derive(Clone, Copy, Debug)]
pub struct Lanes32(pub f32x16);

/// Numbers side by side with one derivative each.
#[derive(Clone, Copy, Debug)]
pub struct LaneTangent<V> {
    value: V,
    slope: V,
}

/// Writes the mixed operators of a scalar from its two-sided ones.
macro_rules! mixed_operators {
    ($t:ty $(, $v:ident)?) => {
        impl $(<$v: Root>)? Add<f64> for $t {
            type Output = Self;
            #[inline]
            fn add(self, b: f64) -> Self {
                self + Self::from(b)
            }
        }
        impl $(<$v: Root>)? Sub<f64> for $t {
            type Output = Self;
            #[inline]
            fn sub(self, b: f64) -> Self {
                self - Self::from(b)
            }
        }
        impl $(<$v: Root>)? Mul<f64> for $t {
            type Output = Self;
            #[inline]
            fn mul(self, b: f64) -> Self {
                self * Self::from(b)
            }
        }
        impl $(<$v: Root>)? Div<f64> for $t {
            type Output = Self;
            #[inline]
            fn div(self, b: f64) -> Self {
                self / Self::from(b)
            }
        }
        impl $(<$v: Root>)? AddAssign for $t {
            #[inline]
            fn add_assign(&mut self, b: Self) {
                *self = *self + b;
            }
        }
        impl $(<$v: Root>)? SubAssign for $t {
            #[inline]
            fn sub_assign(&mut self, b: Self) {
                *self = *self - b;
            }
        }
        impl $(<$v: Root>)? MulAssign for $t {
            #[inline]
            fn mul_assign(&mut self, b: Self) {
                *self = *self * b;
            }
        }
    };
}
mixed_operators!(Lanes);
mixed_operators!(Lanes32);
mixed_operators!(LaneTangent<V>, V);

/// Writes a scalar of lanes from its packed type and the type of one lane.
macro_rules! lanes {
    ($t:ident, $packed:ty, $one:ty) => {
        impl From<f64> for $t {
            #[inline]
            fn from(x: f64) -> Self {
                $t(<$packed>::splat(x as $one))
            }
        }
        impl Add for $t {
            type Output = Self;
            #[inline]
            fn add(self, b: Self) -> Self {
                $t(self.0 + b.0)
            }
        }
        impl Sub for $t {
            type Output = Self;
            #[inline]
            fn sub(self, b: Self) -> Self {
                $t(self.0 - b.0)
            }
        }
        impl Mul for $t {
            type Output = Self;
            #[inline]
            fn mul(self, b: Self) -> Self {
                $t(self.0 * b.0)
            }
        }
        impl Div for $t {
            type Output = Self;
            #[inline]
            fn div(self, b: Self) -> Self {
                $t(self.0 / b.0)
            }
        }
        impl Neg for $t {
            type Output = Self;
            #[inline]
            fn neg(self) -> Self {
                $t(-self.0)
            }
        }

        impl Real for $t {
            type Primal = $t;

            #[inline]
            fn primal(self) -> $t {
                self
            }
            #[inline]
            fn from_primal(value: $t) -> Self {
                value
            }
            #[inline]
            fn select_lt(self, b: Self, yes: Self, no: Self) -> Self {
                $t(self.0.simd_lt(b.0).bitselect(yes.0, no.0))
            }
            #[inline]
            fn exp(self) -> Self {
                $t(self.0.exp())
            }
            #[inline]
            fn exp_m1(self) -> Self {
                $t(self.0.exp_m1())
            }
            #[inline]
            fn ln(self) -> Self {
                $t(self.0.ln())
            }
            #[inline]
            fn sqrt(self) -> Self {
                $t(self.0.sqrt())
            }
            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                let (s, c) = self.0.sin_cos();
                ($t(s), $t(c))
            }
            #[inline]
            fn tanh(self) -> Self {
                $t(self.0.tanh())
            }
            #[inline]
            fn atan(self) -> Self {
                $t(self.0.atan())
            }
            #[inline]
            fn abs(self) -> Self {
                $t(self.0.abs())
            }
        }

        impl Root for $t {
            type Tangent = LaneTangent<$t>;
            type Nodes = $t;

            #[inline]
            fn seed(self) -> LaneTangent<$t> {
                LaneTangent {
                    value: self,
                    slope: $t::from(1.0),
                }
            }
            #[inline]
            fn parts(x: LaneTangent<$t>) -> ($t, $t) {
                (x.value, x.slope)
            }
            #[inline]
            fn any_lt(self, b: $t) -> bool {
                self.0.simd_lt(b.0).any()
            }
            #[inline]
            fn is_finite(self) -> bool {
                self.0.to_array().iter().all(|x| x.is_finite())
            }
            fn min_lane(self) -> f64 {
                self.0
                    .to_array()
                    .iter()
                    .copied()
                    .fold(<$one>::INFINITY, <$one>::min)
                    .into()
            }
            fn max_lane(self) -> f64 {
                self.0
                    .to_array()
                    .iter()
                    .copied()
                    .fold(<$one>::NEG_INFINITY, <$one>::max)
                    .into()
            }

            const NODES_AT_ONCE: usize = 1;
            #[inline]
            fn spread(self) -> $t {
                self
            }
            #[inline]
            fn total(sum: $t) -> $t {
                sum
            }
            #[inline]
            fn table(values: &[f64]) -> $t {
                $t::from(values.first().copied().unwrap_or(0.0))
            }
        }
    };
}
lanes!(Lanes, f64x8, f64);
lanes!(Lanes32, f32x16, f32);

impl<V: Root> From<f64> for LaneTangent<V> {
    #[inline]
    fn from(x: f64) -> Self {
        LaneTangent {
            value: V::from(x),
            slope: V::from(0.0),
        }
    }
}
impl<V: Root> Add for LaneTangent<V> {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        LaneTangent {
            value: self.value + b.value,
            slope: self.slope + b.slope,
        }
    }
}
impl<V: Root> Sub for LaneTangent<V> {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        LaneTangent {
            value: self.value - b.value,
            slope: self.slope - b.slope,
        }
    }
}
impl<V: Root> Mul for LaneTangent<V> {
    type Output = Self;
    #[inline]
    fn mul(self, b: Self) -> Self {
        LaneTangent {
            value: self.value * b.value,
            slope: self.slope * b.value + self.value * b.slope,
        }
    }
}
impl<V: Root> Div for LaneTangent<V> {
    type Output = Self;
    #[inline]
    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        LaneTangent {
            value,
            slope: (self.slope - value * b.slope) / b.value,
        }
    }
}
impl<V: Root> Neg for LaneTangent<V> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        LaneTangent {
            value: -self.value,
            slope: -self.slope,
        }
    }
}

impl<V: Root> LaneTangent<V> {
    #[inline]
    fn chain(self, value: V, derivative: V) -> Self {
        LaneTangent {
            value,
            slope: self.slope * derivative,
        }
    }
}

impl<V: Root> Real for LaneTangent<V> {
    type Primal = V;

    #[inline]
    fn primal(self) -> V {
        self.value
    }
    #[inline]
    fn from_primal(value: V) -> Self {
        LaneTangent {
            value,
            slope: V::from(0.0),
        }
    }
    #[inline]
    fn select_lt(self, b: Self, yes: Self, no: Self) -> Self {
        LaneTangent {
            value: self.value.select_lt(b.value, yes.value, no.value),
            slope: self.value.select_lt(b.value, yes.slope, no.slope),
        }
    }
    #[inline]
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }
    #[inline]
    fn exp_m1(self) -> Self {
        let e = self.value.exp_m1();
        self.chain(e, e + 1.0)
    }
    #[inline]
    fn ln(self) -> Self {
        self.chain(self.value.ln(), V::from(1.0) / self.value)
    }
    #[inline]
    fn sqrt(self) -> Self {
        let r = self.value.sqrt();
        self.chain(r, V::from(0.5) / r)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }
    #[inline]
    fn tanh(self) -> Self {
        let t = self.value.tanh();
        self.chain(t, V::from(1.0) - t * t)
    }
    #[inline]
    fn atan(self) -> Self {
        self.chain(
            self.value.atan(),
            V::from(1.0) / (self.value * self.value + 1.0),
        )
    }
}
