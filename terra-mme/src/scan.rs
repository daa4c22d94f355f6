//! How large the NIS of a moving window gets by chance, over a whole log.
//!
//! # Equation
//! - z(x, d) = ((x^(1/3)) - 1 + c)/√c with c = 2/(9 d): x = χ²_d/d as a standard normal (Wilson and Hilferty).
//! - Over m places of a window of K white samples z is a Gaussian process of correlation 1 - |lag|/K, and
//!   P(max z > b) = 1 - exp(-[Φ(-b) + (m - 1) b φ(b) ν(b √(2/K))/K]), ν(y) = e^(-.583 y): the rate of its clumps,
//!   ν for steps in place of a continuous time.
//!
//! # Reference
//! E. B. Wilson, M. M. Hilferty, PNAS 17:684-688 (1931); D. Siegmund, *Sequential Analysis*, Springer (1985) (ν);
//! J. Pickands, Trans. AMS 145:51-73 (1969) (rate of clumps).

use std::f64::consts::{PI, SQRT_2};

/// NIS/d of `dof` degrees of freedom as a standard normal.
pub(crate) fn z_of(ratio: f64, dof: usize) -> f64 {
    let c = 2.0 / (9.0 * dof.max(1) as f64);
    (ratio.cbrt() - 1.0 + c) / c.sqrt()
}

/// The NIS/d that stands at z.
pub(crate) fn ratio_of(z: f64, dof: usize) -> f64 {
    let c = 2.0 / (9.0 * dof.max(1) as f64);
    (1.0 - c + z * c.sqrt()).powi(3)
}

/// Φ(-b) for b >= 0: the continued fraction of Mills' ratio from 2 on, the series of the error function below.
fn upper_tail(b: f64) -> f64 {
    let density = (-0.5 * b * b).exp() / (2.0 * PI).sqrt();
    if b < 2.0 {
        let y = b / SQRT_2;
        let (mut term, mut sum) = (y, y);
        for k in 1..60 {
            term *= -y * y / f64::from(k);
            sum += term / f64::from(2 * k + 1);
        }
        return 0.5 - sum / PI.sqrt();
    }
    let fraction = (1..=60).rev().fold(b, |tail, k| b + f64::from(k) / tail);
    density / fraction
}

/// Expected number of clumps of a z above b in `places` places of a window of `window` samples.
fn clumps(b: f64, places: usize, window: usize) -> f64 {
    let k = window.max(1) as f64;
    let density = (-0.5 * b * b).exp() / (2.0 * PI).sqrt();
    let steps = (-0.583 * b * (2.0 / k).sqrt()).exp();
    upper_tail(b) + places.saturating_sub(1) as f64 * b * density * steps / k
}

/// z that the largest of all `places` exceeds with probability `rate`.
pub(crate) fn limit(rate: f64, places: usize, window: usize) -> f64 {
    let wanted = -(-rate).ln_1p();
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if clumps(middle, places.max(1), window) > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tail_of_the_normal_by_tables() {
        for (b, p) in [
            (0.0, 0.5),
            (1.0, 0.158_655_254),
            (1.99, 0.023_295_47),
            (2.01, 0.022_215_59),
            (3.090_232_306, 1e-3),
            (4.753_424_309, 1e-6),
        ] {
            assert!(
                (upper_tail(b) / p - 1.0).abs() < 1e-6,
                "{b} {}",
                upper_tail(b)
            );
        }
        // One place: the quantile itself.
        assert!((limit(1e-3, 1, 50) - 3.090_232_306).abs() < 2e-3);
    }

    #[test]
    fn ratio_is_the_tabulated_quantile_and_back() {
        // chi² at .999 in standard tables; Wilson-Hilferty is good to 2 % this far out at 3 degrees of freedom.
        for (dof, chi2) in [(3, 16.266), (10, 29.588), (30, 59.703), (100, 149.449)] {
            let ratio = ratio_of(3.090_232, dof);
            assert!(
                (ratio * dof as f64 / chi2 - 1.0).abs() < 0.02,
                "{dof} {ratio}"
            );
            assert!((z_of(ratio, dof) - 3.090_232).abs() < 1e-12);
        }
    }

    #[test]
    fn a_longer_log_needs_a_higher_limit() {
        let limits = [1, 100, 10_000, 1_000_000].map(|places| limit(0.01, places, 50));
        assert!(limits.windows(2).all(|l| l[0] < l[1]), "{limits:?}");
    }
}
