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

use wide::f64x8;

use crate::error::EstimatorError;
use crate::log_prob::LogProb;

const LANES: usize = 8;

/// e^x counts as 0 below this: the last whole power of two above the subnormal numbers.
const UNDERFLOW: f64 = -708.0;

/// Loads up to eight numbers; missing lanes hold `fill`, so that every hypothesis meets the same arithmetic.
#[inline]
fn load(x: &[f64], fill: f64) -> f64x8 {
    match <[f64; LANES]>::try_from(x) {
        Ok(full) => f64x8::from(full),
        Err(_) => {
            let mut part = [fill; LANES];
            for (p, x) in part.iter_mut().zip(x) {
                *p = *x;
            }
            f64x8::from(part)
        }
    }
}

#[inline]
fn store(x: f64x8, out: &mut [f64]) {
    let all = x.to_array();
    let n = out.len().min(LANES);
    out.copy_from_slice(&all[..n]);
}

/// e^x for x <= 0 (also -∞), to 2 units in the last place, 0 below [`UNDERFLOW`].
///
/// Without branches and calls, so that the compiler turns the loop into vector instructions on any target; the
/// library's exponential would take most of the time of a step.
///
/// # Equation
/// e^x = 2^k e^r, k = round(x / ln 2), |r| <= ln 2/2, e^r by its series to r^13.
#[inline]
fn exp_of_negative(x: [f64; LANES]) -> [f64; LANES] {
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
    x.map(|x| {
        let held = if x < UNDERFLOW { UNDERFLOW } else { x };
        let shifted = held * std::f64::consts::LOG2_E + ROUND;
        let k = shifted - ROUND;
        let r = (held - k * LN2_HIGH) - k * LN2_LOW;
        let series = SERIES.iter().rev().fold(0.0, |sum, c| sum * r + c);
        let power = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1023 << 52));
        if x < UNDERFLOW { 0.0 } else { series * power }
    })
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
    let mut max = f64x8::splat(never);
    let mut bad = false;
    for (lw, ll) in log_weights.chunks(LANES).zip(log_likelihood.chunks(LANES)) {
        let x = load(lw, never) + load(ll, 0.0);
        bad |= x.is_nan().any();
        max = max.max(x);
    }
    let max = max.to_array().into_iter().fold(never, f64::max);
    if bad || max == f64::INFINITY {
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
    let mut sum = f64x8::splat(0.0);
    let chunks = log_weights
        .chunks_mut(LANES)
        .zip(log_likelihood.chunks(LANES))
        .zip(weights.chunks_mut(LANES));
    for ((lw, ll), w) in chunks {
        let x = load(lw, never) + load(ll, 0.0) - f64x8::splat(max);
        let e = f64x8::from(exp_of_negative(x.to_array()));
        sum += e;
        store(x, lw);
        store(e, w);
    }
    let sum: f64 = sum.to_array().into_iter().sum();
    let (scale, log_sum) = (1.0 / sum, sum.ln());
    for (lw, w) in log_weights.iter_mut().zip(weights.iter_mut()) {
        *lw -= log_sum;
        *w *= scale;
    }
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
        let mut sum = f64x8::splat(0.0);
        for (w, x) in weights.chunks(LANES).zip(column.chunks(LANES)) {
            sum += load(w, 0.0) * load(x, 0.0);
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
            let [e, ..] = exp_of_negative([x; LANES]);
            worst = worst.max((e / x.exp() - 1.0).abs());
        }
        assert!(worst < 5e-16, "{worst:e}");
        for x in [-708.1, -1e4, f64::NEG_INFINITY] {
            assert_eq!(exp_of_negative([x; LANES]), [0.0; LANES]);
        }
        assert_eq!(exp_of_negative([0.0; LANES]), [1.0; LANES]);
        assert!(exp_of_negative([UNDERFLOW; LANES])[0] > 0.0);
    }
}
