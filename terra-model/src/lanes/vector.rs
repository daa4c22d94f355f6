//! Elementary functions that a stress integral needs, for lanes only: branch free, on the narrow ranges that occur, at a third
//! of the cost of the general ones.
//!
//! Polynomials are Taylor series on the reduced range, cut where the first term left out is below rounding.

use wide::bytemuck::cast;
use wide::{f32x16, f64x8, u32x16, u64x8};

use super::{Lanes, Lanes32};
use crate::real::Root;

/// Lanes with the functions that a stress integral needs.
pub trait Vector: Root<Primal = Self> {
    /// Whether one lane is double precision: series keep all their terms.
    const DOUBLE: bool;
    /// How many numbers lie side by side.
    const WIDTH: usize;

    /// self * b + c, fused where the processor can.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// The nearest integer k, and 2^k; |self| below a thousand (double) or a hundred (single).
    fn power_of_two(self) -> (Self, Self);
    /// m in \[1, 2) and e with self = m 2^e, for a positive normal number.
    fn mantissa_exponent(self) -> (Self, Self);
    /// The larger of two where neither is NaN.
    fn larger(self, b: Self) -> Self;
    /// Values from a slice of `WIDTH`; missing ones are zero.
    fn gather(values: impl Iterator<Item = f64>) -> Self;
    /// Value of one lane.
    fn lane(self, lane: usize) -> f64;
    /// Values of all lanes, zero beyond the last.
    fn lanes<const MOST: usize>(self) -> [f64; MOST];

    /// e^r - 1 on the reduced range and 2^k, x = r + k ln 2.
    #[inline]
    fn reduced_exp(self) -> (Self, Self) {
        let least = if Self::DOUBLE { -690.0 } else { -80.0 };
        let x = self.larger(Self::from(least));
        let (k, scale) = (x * std::f64::consts::LOG2_E).power_of_two();
        let (high, low) = if Self::DOUBLE {
            (0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10)
        } else {
            (0.693_359_375, -2.121_944_4e-4)
        };
        let r = k.mul_add(Self::from(-high), x);
        let r = k.mul_add(Self::from(-low), r);
        let skip = if Self::DOUBLE { 0 } else { 6 };
        let tail = series(r, &EXP[skip..]);
        (tail.mul_add(r * r, r), scale)
    }
    /// e^x for x below 700 (double) or 80 (single); below -690 (-80) as there.
    #[inline]
    fn exp_fast(self) -> Self {
        let (p, scale) = self.reduced_exp();
        p.mul_add(scale, scale)
    }
    /// e^x - 1, accurate near zero, on the same range.
    #[inline]
    fn exp_m1_fast(self) -> Self {
        let (p, scale) = self.reduced_exp();
        p.mul_add(scale, scale - 1.0)
    }
    /// Natural logarithm of a positive normal number.
    #[inline]
    fn ln_fast(self) -> Self {
        let (m, e) = self.mantissa_exponent();
        // m in [√½, √2): s = (m - 1)/(m + 1) is small, ln m = 2 (s + s³/3 + ...).
        let root = Self::from(std::f64::consts::SQRT_2);
        let (m, e) = (root.select_lt(m, m * 0.5, m), root.select_lt(m, e + 1.0, e));
        let s = (m - 1.0) / (m + 1.0);
        let y = s * s;
        let skip = if Self::DOUBLE { 0 } else { 6 };
        let tail = series(y, &ATANH[skip..]) * y;
        let ln_m = tail.mul_add(s, s) * 2.0;
        e.mul_add(Self::from(std::f64::consts::LN_2), ln_m)
    }
    /// t - sin t and 1 - cos t without cancellation, |t| <= π/2.
    #[inline]
    fn sine_defects(self) -> (Self, Self) {
        let y = self * self;
        let (sine_skip, cosine_skip) = if Self::DOUBLE { (0, 0) } else { (5, 5) };
        let sine = series(y, &T_MINUS_SIN[sine_skip..]) * (y * self);
        let cosine = series(y, &ONE_MINUS_COS[cosine_skip..]) * y;
        (sine, cosine)
    }
}

/// A polynomial, highest coefficient first.
#[inline]
fn series<V: Vector>(x: V, coefficients: &[f64]) -> V {
    let mut sum = V::from(coefficients[0]);
    for &c in &coefficients[1..] {
        sum = sum.mul_add(x, V::from(c));
    }
    sum
}

/// 1/k!, alternating in sign when `sign` is -1, for k = first + step (count - 1), ..., first.
const fn factorials<const N: usize>(first: usize, step: usize, sign: f64) -> [f64; N] {
    let mut out = [0.0; N];
    let mut q = 0;
    while q < N {
        let mut value = 1.0;
        let mut k = 1;
        while k <= first + step * q {
            value /= k as f64;
            k += 1;
        }
        let negative = sign < 0.0 && q % 2 == 1;
        out[N - 1 - q] = if negative { -value } else { value };
        q += 1;
    }
    out
}

/// (e^r - 1 - r)/r², |r| <= ln 2/2.
const EXP: [f64; 12] = factorials(2, 1, 1.0);
/// (t - sin t)/t³ in t² <= π²/4.
const T_MINUS_SIN: [f64; 10] = factorials(3, 2, -1.0);
/// (1 - cos t)/t² in t².
const ONE_MINUS_COS: [f64; 11] = factorials(2, 2, -1.0);
/// (artanh s - s)/s³ in s² <= .0295.
const ATANH: [f64; 10] = {
    let mut out = [0.0; 10];
    let mut q = 0;
    while q < 10 {
        out[9 - q] = 1.0 / (2 * q + 3) as f64;
        q += 1;
    }
    out
};

macro_rules! vector {
    ($t:ident, $packed:ident, $bits:ident, $one:ty, $word:ty, $width:expr, $double:expr, $round:expr, $fraction:expr, $bias:expr) => {
        impl Vector for $t {
            const DOUBLE: bool = $double;
            const WIDTH: usize = $width;

            #[inline]
            fn mul_add(self, b: Self, c: Self) -> Self {
                $t(self.0.mul_add(b.0, c.0))
            }
            #[inline]
            fn power_of_two(self) -> (Self, Self) {
                // Adding 1.5 2^52 leaves the integer in the last bits of the sum.
                let round = $packed::splat($round);
                let sum = self.0 + round;
                let k: $bits = cast(sum);
                let bias = $bits::splat($bias << $fraction);
                let bits = (k << $fraction as u32) + bias;
                ($t(sum - round), $t(cast(bits)))
            }
            #[inline]
            fn mantissa_exponent(self) -> (Self, Self) {
                let bits: $bits = cast(self.0);
                let one: $word = $bias << $fraction;
                let mask: $word = (1 << $fraction) - 1;
                let m = (bits & $bits::splat(mask)) | $bits::splat(one);
                // The exponent's bits below those of 2^52 read as 2^52 + e.
                let shift: $one = (1_u64 << $fraction) as $one;
                let e = (bits >> $fraction as u32) | $bits::splat(shift.to_bits());
                let offset = $packed::splat(shift + $bias as $one);
                ($t(cast(m)), $t(cast::<_, $packed>(e) - offset))
            }
            #[inline]
            fn larger(self, b: Self) -> Self {
                $t(b.0.fast_max(self.0))
            }
            #[inline]
            fn gather(values: impl Iterator<Item = f64>) -> Self {
                let mut lanes = [0.0 as $one; $width];
                for (lane, value) in lanes.iter_mut().zip(values) {
                    *lane = value as $one;
                }
                $t($packed::new(lanes))
            }
            #[inline]
            fn lane(self, lane: usize) -> f64 {
                self.0.to_array().get(lane).map_or(f64::NAN, |&x| x.into())
            }
            #[inline]
            fn lanes<const MOST: usize>(self) -> [f64; MOST] {
                let mut out = [0.0; MOST];
                for (out, &lane) in out.iter_mut().zip(self.0.as_array()) {
                    *out = lane.into();
                }
                out
            }
        }
    };
}
vector!(
    Lanes,
    f64x8,
    u64x8,
    f64,
    u64,
    8,
    true,
    6_755_399_441_055_744.0,
    52,
    1023
);
vector!(
    Lanes32,
    f32x16,
    u32x16,
    f32,
    u32,
    16,
    false,
    12_582_912.0,
    23,
    127
);

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest relative error of a function of lanes against the standard library's.
    fn worst<V: Vector>(
        points: impl Fn(f64) -> f64,
        fast: impl Fn(V) -> V,
        exact: impl Fn(f64) -> f64,
    ) -> f64 {
        let mut worst = 0.0_f64;
        for q in 0..=4000 {
            let x = V::from(points(f64::from(q) / 4000.0)).lane(0);
            let (found, expected) = (fast(V::from(x)).lane(0), exact(x));
            worst = worst.max(((found - expected) / expected).abs());
        }
        worst
    }

    fn all<V: Vector>(unit: f64) {
        let range = |low: f64, high: f64| move |q: f64| low + (high - low) * q;
        let decades = |low: f64, high: f64| move |q: f64| 10_f64.powf(low + (high - low) * q);
        assert!(worst(range(-60.0, 60.0), V::exp_fast, f64::exp) < 2.0 * unit);
        assert!(worst(decades(-6.0, 1.7), V::exp_m1_fast, f64::exp_m1) < 2.0 * unit);
        let negative = worst(
            decades(-6.0, 1.7),
            |x: V| (-x).exp_m1_fast(),
            |x| (-x).exp_m1(),
        );
        assert!(negative < 2.0 * unit);
        assert!(worst(decades(-30.0, -0.1), V::ln_fast, f64::ln) < 2.0 * unit);
        assert!(worst(range(1.2, 900.0), V::ln_fast, f64::ln) < 2.0 * unit);
        let quarter = std::f64::consts::FRAC_PI_2;
        // x - sin x and 1 - cos x cancel below .5 in the standard library too.
        let sine = worst(
            range(0.5, quarter),
            |x: V| x.sine_defects().0,
            |x| x - x.sin(),
        );
        // Half a unit each from x², x³, the coefficient 1/6, the sum and the product.
        assert!(
            sine < 30.0 * f64::EPSILON + 2.5 * unit,
            "{} units",
            sine / unit
        );
        let cosine = worst(
            decades(-4.0, quarter.log10()),
            |x: V| x.sine_defects().1,
            |x| 2.0 * (0.5 * x).sin().powi(2),
        );
        assert!(cosine < 3.0 * unit);
    }

    #[test]
    fn double_precision_is_right_to_rounding() {
        all::<Lanes>(f64::EPSILON);
    }

    #[test]
    fn single_precision_is_right_to_rounding() {
        all::<Lanes32>(f64::from(f32::EPSILON));
    }
}
