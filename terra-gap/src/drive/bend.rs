//! Windows in which something steps or bends: they have a mean motion, but not the mean forces of it.
//!
//! # Equation
//! The square around the line of n samples, over the sensor's variance, is chi²_d/d with d = n - 2. With a = 2/(9 d) its quantile at z
//! standard deviations is (1 - a + z √a)³, the median (1 - a)³.
//!
//! # Source
//! E. B. Wilson, M. M. Hilferty, PNAS 17:684-688 (1931).

use super::window::{SERIES, Taken};
use crate::rig::median;

/// Why such a window is left out.
pub(crate) const BENT: &str = "a step or an outlier inside the window";
/// How many times more than in the median window a channel may scatter around its line at most, where it has many samples.
const BENDS: f64 = 4.0;
/// Standard deviations up to which white noise alone may make it, where it has few: of twenty samples [`BENDS`] times the median.
const CHANCE: f64 = 5.22;

/// Share of the variance by which so many samples of white noise scatter around their line at these standard deviations.
fn quantile(samples: usize, z: f64) -> f64 {
    let a = 2.0 / (9.0 * (samples as f64 - 2.0));
    (1.0 - a + z * a.sqrt()).powi(3)
}

/// The same in the median.
pub(super) fn middle(samples: usize) -> f64 {
    quantile(samples, 0.0)
}

/// The usual scatter of every channel: 1 where its noise is as stated and white.
pub(crate) fn usual<'a>(taken: impl Iterator<Item = &'a Taken> + Clone) -> [f64; SERIES] {
    std::array::from_fn(|k| {
        let of = |t: &Taken| t.scatter[k] / middle(t.lag[k].1);
        let measured = taken.clone().filter(|t| !t.scatter[k].is_nan()).map(of);
        median(measured).max(f64::MIN_POSITIVE)
    })
}

/// True where a channel scatters far more than it usually does, and than chance lets so few samples.
pub(crate) fn bends(taken: &Taken, usual: &[f64; SERIES]) -> bool {
    let each = taken.scatter.iter().zip(&taken.lag).zip(usual);
    each.into_iter().any(|((scatter, (_, samples)), usual)| {
        let most = f64::max(BENDS * middle(*samples), quantile(*samples, CHANCE));
        *scatter > most * usual
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of chi² over its freedoms from tables: the medians of 1, 2, 8 and 18 (.455, .693, .918, .963), and what one of a
    /// million exceeds (z = 4.753) of 1, 8 and 18 freedoms (23.93, 5.341, 3.380).
    #[test]
    fn the_quantiles_are_those_of_tables() {
        for (samples, z, table) in [
            (3, 0.0, 0.4549),
            (4, 0.0, std::f64::consts::LN_2),
            (10, 0.0, 0.9180),
            (20, 0.0, 0.9632),
        ] {
            let off = quantile(samples, z) / table - 1.0;
            assert!(off.abs() < 0.035, "{samples} {off}");
        }
        for (samples, table) in [(3, 23.93), (10, 5.341), (20, 3.380)] {
            let off = quantile(samples, 4.753) / table - 1.0;
            assert!(off.abs() < 0.16, "{samples} {off}");
        }
        let of_twenty = quantile(20, CHANCE) / middle(20);
        assert!((of_twenty - BENDS).abs() < 0.01, "{of_twenty}");
    }
}
