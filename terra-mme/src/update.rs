//! One Bayes step over N hypotheses: log-likelihoods in, normalised weights and evidence out, in O(N).
//!
//! Structure of arrays, eight hypotheses at a time, no allocation, fixed order of summation: the same bytes on any
//! machine with the same instructions, however the caller is threaded.
//!
//! # Equation
//! p_j <- p_j e^(l_j) / Z,  Z = Σ p_j e^(l_j);  mean = Σ p_j x_j.
//!
//! # Reference
//! L. E. Ray, Proc. SPIE (2008), eqs 22 and 24, in the log domain.

use wide::bytemuck::cast;
use wide::{f64x8, u64x8};

use crate::error::EstimatorError;
use crate::log_prob::LogProb;

const LANES: usize = 8;

/// e^x counts as 0 below this: the last whole power of two above the subnormal numbers.
const UNDERFLOW: f64 = -708.0;

/// What is left of a column beyond whole vectors; missing lanes hold `fill`, so that every hypothesis meets the same
/// arithmetic.
#[inline]
fn rest(x: &[f64], fill: f64) -> [f64; LANES] {
    let mut part = [fill; LANES];
    for (p, x) in part.iter_mut().zip(x) {
        *p = *x;
    }
    part
}

/// e^x for x <= 0 (also -∞), to 2 units in the last place, 0 below [`UNDERFLOW`].
///
/// Without branches and special cases, of which the library's exponential has many: they would take most of a step.
///
/// # Equation
/// e^x = 2^k e^r, k = round(x / ln 2), |r| <= ln 2/2, e^r by its series to r^13.
#[inline]
fn exp_of_negative(x: f64x8) -> f64x8 {
    /// 1.5 2^52: adding it rounds to a whole number, which then sits in the low bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const LN2_HIGH: f64 = 0.693_145_751_953_125;
    const LN2_LOW: f64 = 1.428_606_820_309_417_2e-6;
    const SERIES: [f64; 14] = {
        let mut c = [1.0; 14];
        let mut n = 1;
        while n < 14 {
            c[n] = c[n - 1] / n as f64;
            n += 1;
        }
        c
    };
    let all = f64x8::splat;
    let held = x.fast_max(all(UNDERFLOW));
    let shifted = held.mul_add(all(std::f64::consts::LOG2_E), all(ROUND));
    let k = shifted - all(ROUND);
    let r = k.mul_add(all(-LN2_LOW), k.mul_add(all(-LN2_HIGH), held));
    let mut series = all(SERIES[13]);
    for c in SERIES.iter().rev().skip(1) {
        series = series.mul_add(r, all(*c));
    }
    // The series is near 1 and 2^k no smaller than 2^-1021, so its exponent can be added to.
    let (series, shifted): (u64x8, u64x8) = (cast(series), cast(shifted));
    let power: f64x8 = cast(series + (shifted << 52_u64));
    power & x.simd_ge(all(UNDERFLOW))
}

/// One Bayes step on bare arrays of equal length N: `log_weights` and `weights` are replaced, ln Z is returned.
///
/// Nothing is changed when it fails.
///
/// # Errors
/// [`EstimatorError::Size`]; [`EstimatorError::Value`] for a likelihood that is NaN or +∞;
/// [`EstimatorError::Impossible`] when all are -∞.
pub fn bayes_step(
    log_weights: &mut [f64],
    log_likelihood: &[f64],
    weights: &mut [f64],
) -> Result<LogProb, EstimatorError> {
    let expected = log_weights.len();
    for found in [log_likelihood.len(), weights.len()] {
        if found != expected {
            return Err(EstimatorError::Size {
                what: "log-likelihoods",
                found,
                expected,
            });
        }
    }
    let never = f64::NEG_INFINITY;
    let (likely, likely_rest) = log_likelihood.as_chunks::<LANES>();
    let likely_rest = rest(likely_rest, 0.0);
    let mut max = f64x8::splat(never);
    let mut bad = f64x8::ZERO;
    {
        let (lw, lw_rest) = log_weights.as_chunks::<LANES>();
        let mut look = |lw: &[f64; LANES], ll: &[f64; LANES]| {
            let x = f64x8::from(*lw) + f64x8::from(*ll);
            bad |= x.is_nan();
            max = x.fast_max(max);
        };
        for (lw, ll) in lw.iter().zip(likely) {
            look(lw, ll);
        }
        look(&rest(lw_rest, never), &likely_rest);
    }
    let max = max.to_array().into_iter().fold(never, f64::max);
    if bad.any() || max == f64::INFINITY {
        let value = log_likelihood
            .iter()
            .copied()
            .find(|l| l.is_nan() || *l == f64::INFINITY)
            .unwrap_or(f64::NAN);
        let expected = "a number below +infinity";
        return Err(EstimatorError::Value {
            what: "log-likelihood".to_owned(),
            value,
            expected,
        });
    }
    if max == never {
        return Err(EstimatorError::Impossible);
    }
    let mut sum = f64x8::ZERO;
    let (lw, lw_rest) = log_weights.as_chunks_mut::<LANES>();
    let (w, w_rest) = weights.as_chunks_mut::<LANES>();
    let most = f64x8::splat(max);
    let mut weigh = |lw: &mut [f64; LANES], ll: &[f64; LANES], w: &mut [f64; LANES]| {
        let x = f64x8::from(*lw) + f64x8::from(*ll) - most;
        let e = exp_of_negative(x);
        sum += e;
        *lw = x.to_array();
        *w = e.to_array();
    };
    for ((lw, ll), w) in lw.iter_mut().zip(likely).zip(w.iter_mut()) {
        weigh(lw, ll, w);
    }
    let mut last = (rest(lw_rest, never), [0.0; LANES]);
    weigh(&mut last.0, &likely_rest, &mut last.1);
    let sum: f64 = sum.to_array().into_iter().sum();
    let (scale, log_sum) = (f64x8::splat(1.0 / sum), sum.ln());
    let normalise = |lw: &mut [f64; LANES], w: &mut [f64; LANES]| {
        *lw = (f64x8::from(*lw) - f64x8::splat(log_sum)).to_array();
        *w = (f64x8::from(*w) * scale).to_array();
    };
    for (lw, w) in lw.iter_mut().zip(w) {
        normalise(lw, w);
    }
    normalise(&mut last.0, &mut last.1);
    let n = lw_rest.len();
    lw_rest.copy_from_slice(&last.0[..n]);
    w_rest.copy_from_slice(&last.1[..n]);
    Ok(LogProb::from_ln(max + log_sum))
}

/// Σ w_j x_j over N hypotheses, one column (N) of values per output. A weight of 0 hides any value but NaN.
///
/// # Errors
/// [`EstimatorError::Size`].
pub fn weighted_means(
    weights: &[f64],
    columns: &[&[f64]],
    means: &mut [f64],
) -> Result<(), EstimatorError> {
    if columns.len() != means.len() {
        return Err(EstimatorError::Size {
            what: "means",
            found: means.len(),
            expected: columns.len(),
        });
    }
    for (column, mean) in columns.iter().zip(means) {
        if column.len() != weights.len() {
            return Err(EstimatorError::Size {
                what: "column",
                found: column.len(),
                expected: weights.len(),
            });
        }
        let (whole, weights_rest) = weights.as_chunks::<LANES>();
        let (values, values_rest) = column.as_chunks::<LANES>();
        let mut sum = f64x8::from(rest(weights_rest, 0.0)) * f64x8::from(rest(values_rest, 0.0));
        for (w, x) in whole.iter().zip(values) {
            sum = f64x8::from(*w).mul_add(f64x8::from(*x), sum);
        }
        *mean = sum.to_array().into_iter().sum();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_agrees_with_the_library() {
        let mut worst: f64 = 0.0;
        for k in 0..70_000 {
            let x = -0.01 * f64::from(k) - 1e-3 * f64::from(k % 7);
            let [e, ..] = exp_of_negative(f64x8::splat(x)).to_array();
            worst = worst.max((e / x.exp() - 1.0).abs());
        }
        assert!(worst < 5e-16, "{worst:e}");
        for x in [-708.1, -1e4, f64::NEG_INFINITY] {
            assert_eq!(exp_of_negative(f64x8::splat(x)).to_array(), [0.0; LANES]);
        }
        assert_eq!(exp_of_negative(f64x8::ZERO).to_array(), [1.0; LANES]);
        assert!(exp_of_negative(f64x8::splat(UNDERFLOW)).to_array()[0] > 0.0);
    }
}
