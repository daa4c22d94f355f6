//! Eight contacts side by side with ten derivatives each: Jacobians of many contacts at once.

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use wide::{f32x8, f64x8};

use super::Lanes;
use crate::real::Real;

/// Lanes with derivatives in up to [`SLOPES`](LaneDual::SLOPES) variables: a model's soil and two effects in one pass.
///
/// Most of what a contact tells are constants: these have no slopes, which are long to write. Slopes are in single precision,
/// all that the steps of a fit need, because such numbers are long to copy.
#[derive(Clone, Copy, Debug)]
pub struct LaneDual {
    value: Lanes,
    slopes: Option<Slopes>,
}

type Slopes = [f32x8; LaneDual::SLOPES];

impl LaneDual {
    /// How many derivatives it carries.
    pub const SLOPES: usize = 10;

    /// The variable of this number, with derivative one in itself; a constant where it is [`SLOPES`](Self::SLOPES) or more.
    pub fn variable(value: Lanes, number: usize) -> Self {
        let one = |k| if k == number { f32x8::ONE } else { f32x8::ZERO };
        let slopes = (number < LaneDual::SLOPES).then(|| std::array::from_fn(one));
        LaneDual { value, slopes }
    }

    /// The derivative in a variable, in one lane; zero in a variable or lane that it has not.
    pub fn slope(&self, number: usize, lane: usize) -> f64 {
        let slope = self.slopes.as_ref().and_then(|s| s.get(number));
        let slope = slope.and_then(|s| s.as_array().get(lane));
        slope.copied().map_or(0.0, f64::from)
    }

    /// The sum over its lanes, in each of them.
    pub(super) fn totalled(self) -> Self {
        let total = |slope: f32x8| f32x8::splat(slope.reduce_add());
        LaneDual {
            value: Lanes::from(self.value.0.reduce_add()),
            slopes: self.slopes.map(|slopes| slopes.map(total)),
        }
    }

    /// Σ a b, with all that varies held in registers.
    #[inline]
    pub(super) fn dotted<'a>(pairs: impl Iterator<Item = (&'a Self, Lanes)>) -> Self {
        let (mut value, mut slopes) = (Lanes::zero(), Slopes::default());
        let mut varies = false;
        for (a, by) in pairs {
            value = Lanes(a.value.0.mul_add(by.0, value.0));
            if let Some(a) = &a.slopes {
                varies = true;
                slopes = plus(&slopes, a, by);
            }
        }
        LaneDual {
            value,
            slopes: varies.then_some(slopes),
        }
    }

    /// f(x) by its value and derivative.
    #[inline(never)]
    fn chain(&self, value: Lanes, derivative: Lanes) -> Self {
        let slopes = self.slopes.as_ref().map(|s| times(s, derivative));
        LaneDual { value, slopes }
    }

    /// value + a da + b db, with what varies of a and b.
    #[inline(never)]
    fn blend(value: Lanes, a: &Self, da: Lanes, b: &Self, db: Lanes) -> Self {
        let slopes = match (&a.slopes, &b.slopes) {
            (Some(a), Some(b)) => {
                let (da, db) = (shorter(da), shorter(db));
                Some(std::array::from_fn(|k| a[k].mul_add(da, b[k] * db)))
            }
            (Some(a), None) => Some(times(a, da)),
            (None, Some(b)) => Some(times(b, db)),
            (None, None) => None,
        };
        LaneDual { value, slopes }
    }

    /// The sum, or with a -1 the difference.
    #[inline(never)]
    fn sum(&self, b: &Self, sign: f64) -> Self {
        let sign = Lanes::from(sign);
        let value = Lanes(b.value.0.mul_add(sign.0, self.value.0));
        let slopes = match (&self.slopes, &b.slopes) {
            (Some(a), Some(b)) => Some(plus(a, b, sign)),
            (Some(a), None) => Some(*a),
            (None, Some(b)) => Some(times(b, sign)),
            (None, None) => None,
        };
        LaneDual { value, slopes }
    }

    /// The sum with a constant.
    #[inline(never)]
    fn shifted(&self, by: f64) -> Self {
        LaneDual {
            value: self.value + by,
            slopes: self.slopes,
        }
    }

    /// Adds a multiple of another.
    #[inline(never)]
    fn gain(&mut self, b: &Self, by: Lanes) {
        self.value = Lanes(b.value.0.mul_add(by.0, self.value.0));
        if let Some(b) = &b.slopes {
            match &mut self.slopes {
                Some(a) => {
                    let by = shorter(by);
                    for (a, b) in a.iter_mut().zip(b) {
                        *a = b.mul_add(by, *a);
                    }
                }
                none => *none = Some(times(b, by)),
            }
        }
    }
}

/// Slopes times a number.
#[inline]
fn times(slopes: &Slopes, by: Lanes) -> Slopes {
    let by = shorter(by);
    std::array::from_fn(|k| slopes[k] * by)
}

/// Slopes and so many times others.
#[inline]
fn plus(a: &Slopes, b: &Slopes, by: Lanes) -> Slopes {
    let by = shorter(by);
    std::array::from_fn(|k| b[k].mul_add(by, a[k]))
}

/// Single precision.
#[inline]
fn shorter(x: Lanes) -> f32x8 {
    f32x8::new(x.0.to_array().map(|x| x as f32))
}

impl From<f64> for LaneDual {
    #[inline]
    fn from(x: f64) -> Self {
        LaneDual::from_primal(Lanes::from(x))
    }
}
impl Add for LaneDual {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        self.sum(&b, 1.0)
    }
}
impl Sub for LaneDual {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        self.sum(&b, -1.0)
    }
}
impl Mul for LaneDual {
    type Output = Self;
    #[inline]
    fn mul(self, b: Self) -> Self {
        LaneDual::blend(self.value * b.value, &self, b.value, &b, self.value)
    }
}
impl Div for LaneDual {
    type Output = Self;
    #[inline]
    fn div(self, b: Self) -> Self {
        let inverse = Lanes::one() / b.value;
        let value = self.value / b.value;
        LaneDual::blend(value, &self, inverse, &b, -(value * inverse))
    }
}
impl Neg for LaneDual {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.chain(-self.value, Lanes::from(-1.0))
    }
}
impl Add<f64> for LaneDual {
    type Output = Self;
    #[inline]
    fn add(self, b: f64) -> Self {
        self.shifted(b)
    }
}
impl Sub<f64> for LaneDual {
    type Output = Self;
    #[inline]
    fn sub(self, b: f64) -> Self {
        self.shifted(-b)
    }
}
impl Mul<f64> for LaneDual {
    type Output = Self;
    #[inline]
    fn mul(self, b: f64) -> Self {
        self.chain(self.value * b, Lanes::from(b))
    }
}
impl Div<f64> for LaneDual {
    type Output = Self;
    #[inline]
    fn div(self, b: f64) -> Self {
        self.chain(self.value / b, Lanes::from(1.0 / b))
    }
}
impl AddAssign for LaneDual {
    #[inline]
    fn add_assign(&mut self, b: Self) {
        self.gain(&b, Lanes::one());
    }
}
impl SubAssign for LaneDual {
    #[inline]
    fn sub_assign(&mut self, b: Self) {
        self.gain(&b, Lanes::from(-1.0));
    }
}
impl MulAssign for LaneDual {
    #[inline]
    fn mul_assign(&mut self, b: Self) {
        *self = *self * b;
    }
}

impl Real for LaneDual {
    type Primal = Lanes;
    const FOR_FITS: bool = true;

    #[inline]
    fn varies(&self) -> bool {
        self.slopes.is_some()
    }
    #[inline]
    fn primal(self) -> Lanes {
        self.value
    }
    #[inline]
    fn from_primal(value: Lanes) -> Self {
        LaneDual {
            value,
            slopes: None,
        }
    }
    #[inline(never)]
    fn select_lt(self, b: Self, yes: Self, no: Self) -> Self {
        let below = self.value.0.simd_lt(b.value.0);
        if below.all() {
            return yes;
        }
        if below.none() {
            return no;
        }
        let value = Lanes(below.bitselect(yes.value.0, no.value.0));
        if !yes.varies() && !no.varies() {
            return LaneDual::from_primal(value);
        }
        let below = shorter(Lanes(below.bitselect(f64x8::ONE, f64x8::ZERO))).simd_gt(f32x8::ZERO);
        let (yes, no) = (
            yes.slopes.unwrap_or_default(),
            no.slopes.unwrap_or_default(),
        );
        LaneDual {
            value,
            slopes: Some(std::array::from_fn(|k| below.bitselect(yes[k], no[k]))),
        }
    }
    #[inline]
    fn scaled(self, by: Lanes) -> Self {
        self.chain(self.value * by, by)
    }
    #[inline]
    fn add_scaled(&mut self, x: &Self, by: Lanes) {
        self.gain(x, by);
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
        self.chain(self.value.ln(), Lanes::one() / self.value)
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
        self.chain(t, Lanes::one() - t * t)
    }
    #[inline]
    fn atan(self) -> Self {
        let slope = Lanes::one() / (self.value * self.value + 1.0);
        self.chain(self.value.atan(), slope)
    }
    #[inline]
    fn pow_pos(self, y: Self) -> Self {
        let ln = self.value.ln();
        let value = (ln * y.value).exp();
        LaneDual::blend(value, &self, value * y.value / self.value, &y, value * ln)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Dual8, jacobian};
    use crate::lanes::Vector;

    /// Every operation, of two variables and a constant.
    fn all<T: Real>([x, y, c]: [T; 3]) -> Vec<T> {
        let (sin, cos) = x.sin_cos();
        let (mut more, mut less, mut times, mut scaled) = (x, x, x, c);
        more += y;
        less -= c;
        times *= y;
        scaled.add_scaled(&x, y.primal());
        vec![
            x + y,
            x - c,
            x * y,
            c / x,
            x / y,
            -x,
            x + 2.0,
            x - 2.0,
            x * 3.0,
            x / 3.0,
            x.exp(),
            x.exp_m1(),
            x.ln(),
            x.sqrt(),
            sin,
            cos,
            x.tan(),
            x.tanh(),
            x.atan(),
            x.pow_pos(y),
            c.pow_pos(y),
            (x - y).abs(),
            x.min_of(y),
            x.max_of(c),
            x.select_lt(y, x * x, y * c),
            x.scaled(y.primal()),
            x.squared(),
            c * c,
            more,
            less,
            times,
            scaled,
        ]
    }

    /// Values as dual numbers give them, slopes to single precision, in every lane.
    #[test]
    fn every_operation_has_its_slopes() {
        let x = Lanes::gather((0..8).map(|k| 0.3 + 0.11 * f64::from(k)));
        let y = Lanes::gather((0..8).map(|k| 0.9 - 0.07 * f64::from(k)));
        let c = Lanes::from(0.7);
        let numbers = [
            LaneDual::variable(x, 0),
            LaneDual::variable(y, 9),
            LaneDual::from_primal(c),
        ];
        let found = all(numbers);
        for lane in 0..8 {
            let at = [x.lane(lane), y.lane(lane)];
            let of = |v: &[Dual8]| Ok::<_, ()>(all([v[0], v[1], Dual8::from(0.7)]));
            let (values, slopes) = jacobian(&at, of).unwrap();
            for (k, f) in found.iter().enumerate() {
                let value = f.primal().lane(lane);
                assert!(
                    (value - values[k]).abs() < 1e-14 * (1.0 + values[k].abs()),
                    "{k}"
                );
                for (column, variable) in [(0, 0), (1, 9)] {
                    let (slope, exact) = (f.slope(variable, lane), slopes[(k, column)]);
                    assert!(
                        (slope - exact).abs() < 1e-6 * (1.0 + exact.abs()),
                        "{k} {slope} {exact}"
                    );
                }
                assert_eq!(f.slope(4, lane), 0.0);
            }
        }
        assert!(!found[27].varies() && found[0].varies());
    }
}
