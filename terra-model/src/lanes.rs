//! Eight numbers side by side, and the same with one derivative: the SIMD scalars.

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use wide::f64x8;

use crate::real::{Real, Root};

/// Eight contacts side by side: the SIMD scalar.
#[derive(Clone, Copy, Debug)]
pub struct Lanes(pub f64x8);

/// Eight contacts with one derivative each.
#[derive(Clone, Copy, Debug)]
pub struct LaneTangent {
    value: Lanes,
    slope: Lanes,
}

/// Writes the mixed operators of a scalar from its two-sided ones.
macro_rules! mixed_operators {
    ($t:ty) => {
        impl Add<f64> for $t {
            type Output = Self;
            #[inline]
            fn add(self, b: f64) -> Self {
                self + Self::from(b)
            }
        }
        impl Sub<f64> for $t {
            type Output = Self;
            #[inline]
            fn sub(self, b: f64) -> Self {
                self - Self::from(b)
            }
        }
        impl Mul<f64> for $t {
            type Output = Self;
            #[inline]
            fn mul(self, b: f64) -> Self {
                self * Self::from(b)
            }
        }
        impl Div<f64> for $t {
            type Output = Self;
            #[inline]
            fn div(self, b: f64) -> Self {
                self / Self::from(b)
            }
        }
        impl AddAssign for $t {
            #[inline]
            fn add_assign(&mut self, b: Self) {
                *self = *self + b;
            }
        }
        impl SubAssign for $t {
            #[inline]
            fn sub_assign(&mut self, b: Self) {
                *self = *self - b;
            }
        }
        impl MulAssign for $t {
            #[inline]
            fn mul_assign(&mut self, b: Self) {
                *self = *self * b;
            }
        }
    };
}
mixed_operators!(Lanes);
mixed_operators!(LaneTangent);

impl From<f64> for Lanes {
    #[inline]
    fn from(x: f64) -> Self {
        Lanes(f64x8::splat(x))
    }
}
impl Add for Lanes {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        Lanes(self.0 + b.0)
    }
}
impl Sub for Lanes {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        Lanes(self.0 - b.0)
    }
}
impl Mul for Lanes {
    type Output = Self;
    #[inline]
    fn mul(self, b: Self) -> Self {
        Lanes(self.0 * b.0)
    }
}
impl Div for Lanes {
    type Output = Self;
    #[inline]
    fn div(self, b: Self) -> Self {
        Lanes(self.0 / b.0)
    }
}
impl Neg for Lanes {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Lanes(-self.0)
    }
}

impl Real for Lanes {
    type Primal = Lanes;

    #[inline]
    fn primal(self) -> Lanes {
        self
    }
    #[inline]
    fn from_primal(value: Lanes) -> Self {
        value
    }
    #[inline]
    fn select_lt(self, b: Self, yes: Self, no: Self) -> Self {
        Lanes(self.0.simd_lt(b.0).bitselect(yes.0, no.0))
    }
    #[inline]
    fn exp(self) -> Self {
        Lanes(self.0.exp())
    }
    #[inline]
    fn exp_m1(self) -> Self {
        Lanes(self.0.exp_m1())
    }
    #[inline]
    fn ln(self) -> Self {
        Lanes(self.0.ln())
    }
    #[inline]
    fn sqrt(self) -> Self {
        Lanes(self.0.sqrt())
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.0.sin_cos();
        (Lanes(s), Lanes(c))
    }
    #[inline]
    fn tanh(self) -> Self {
        Lanes(self.0.tanh())
    }
    #[inline]
    fn atan(self) -> Self {
        Lanes(self.0.atan())
    }
}

impl Root for Lanes {
    type Tangent = LaneTangent;

    #[inline]
    fn seed(self) -> LaneTangent {
        LaneTangent {
            value: self,
            slope: Lanes::from(1.0),
        }
    }
    #[inline]
    fn parts(x: LaneTangent) -> (Lanes, Lanes) {
        (x.value, x.slope)
    }
    #[inline]
    fn any_lt(self, b: Lanes) -> bool {
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
            .fold(f64::INFINITY, f64::min)
    }
    fn max_lane(self) -> f64 {
        self.0
            .to_array()
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

impl From<f64> for LaneTangent {
    #[inline]
    fn from(x: f64) -> Self {
        LaneTangent {
            value: Lanes::from(x),
            slope: Lanes::from(0.0),
        }
    }
}
impl Add for LaneTangent {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        LaneTangent {
            value: self.value + b.value,
            slope: self.slope + b.slope,
        }
    }
}
impl Sub for LaneTangent {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        LaneTangent {
            value: self.value - b.value,
            slope: self.slope - b.slope,
        }
    }
}
impl Mul for LaneTangent {
    type Output = Self;
    #[inline]
    fn mul(self, b: Self) -> Self {
        LaneTangent {
            value: self.value * b.value,
            slope: self.slope * b.value + self.value * b.slope,
        }
    }
}
impl Div for LaneTangent {
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
impl Neg for LaneTangent {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        LaneTangent {
            value: -self.value,
            slope: -self.slope,
        }
    }
}

impl LaneTangent {
    #[inline]
    fn chain(self, value: Lanes, derivative: Lanes) -> Self {
        LaneTangent {
            value,
            slope: self.slope * derivative,
        }
    }
}

impl Real for LaneTangent {
    type Primal = Lanes;

    #[inline]
    fn primal(self) -> Lanes {
        self.value
    }
    #[inline]
    fn from_primal(value: Lanes) -> Self {
        LaneTangent {
            value,
            slope: Lanes::from(0.0),
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
        self.chain(self.value.ln(), Lanes::from(1.0) / self.value)
    }
    #[inline]
    fn sqrt(self) -> Self {
        let r = self.value.sqrt();
        self.chain(r, Lanes::from(0.5) / r)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }
    #[inline]
    fn tanh(self) -> Self {
        let t = self.value.tanh();
        self.chain(t, Lanes::from(1.0) - t * t)
    }
    #[inline]
    fn atan(self) -> Self {
        self.chain(
            self.value.atan(),
            Lanes::from(1.0) / (self.value * self.value + 1.0),
        )
    }
}
