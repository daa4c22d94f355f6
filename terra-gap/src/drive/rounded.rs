//! Readings that are rounded more coarsely than their noise: while such a channel runs evenly its mean is off by the same part of a
//! digit in window after window, which no number of samples takes away.
//!
//! # Equation
//! A true value c with white noise of sd s, rounded to a multiple of q, is off in the mean by a sum over k of
//! (q/πk) exp(-2π² k² s²/q²) sin(2π k c/q): over all c a variance of Σ (q²/2π²k²) exp(-4π² k² s²/q²), at most q²/12. Inside windows
//! it scatters, over all c, by q s/√π where s is small against q, by s² + q²/12 where it is not. N windows in which c stays within
//! half a digit have one such error in common: so that together they say no more than one of them, each is given N times its
//! variance.
//!
//! # Source
//! B. Widrow, I. Kollár, Quantization Noise, 2008, chapters 4 and 5 (recalled; both limits are checked by a test).

use std::f64::consts::PI;

use super::window::{SCATTER_ACCEL, SCATTER_SPEED, SCATTER_WHEEL, SCATTER_YAW, SERIES, Taken};
use super::{ACCEL, SPEED, TORQUE, WHEEL, YAW_RATE};

/// Most values that are told apart: a channel with more of them has digits that do not matter.
const MOST: usize = 512;
/// Fewest of them that show a digit.
const FEWEST: usize = 6;
/// Share of a digit by which the distance of two values may miss a multiple of it.
const MISSES: f64 = 0.05;
/// Share of a window's own noise from which the error of its digit counts.
const COUNTS: f64 = 0.3;
/// Terms of the sum.
const WAVES: u32 = 50;
/// Scatter over q² where the two limits of it meet.
const MEETS: f64 = 0.17;

/// The values that a channel has been seen to have, in their order; none where they are too many.
#[derive(Clone, Debug)]
pub(super) struct Values(Option<Vec<f64>>);

impl Default for Values {
    fn default() -> Self {
        Values(Some(vec![]))
    }
}

impl Values {
    pub(super) fn see(&mut self, value: f64) {
        let Some(seen) = &mut self.0 else {
            return;
        };
        if let Err(place) = seen.binary_search_by(|known| known.total_cmp(&value)) {
            seen.insert(place, value);
            if seen.len() > MOST {
                self.0 = None;
            }
        }
    }

    /// What all of them are multiples of, but for one number: none where they are few, or lie anyhow.
    fn digit(&self) -> Option<f64> {
        let seen = self.0.as_ref().filter(|seen| seen.len() >= FEWEST)?;
        let steps: Vec<f64> = seen.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
        let multiples: Vec<f64> = steps.iter().map(|step| (step / least).round()).collect();
        let digit = steps.iter().sum::<f64>() / multiples.iter().sum::<f64>();
        let fits = |(step, times): (&f64, &f64)| (step / digit - times).abs() < MISSES;
        let all = steps.iter().zip(&multiples).all(fits);
        (all && digit.is_finite()).then_some(digit)
    }
}

/// 1-sigma by which a rounded value that scatters by so much inside windows is off in the mean.
fn off(digit: f64, scatter: f64) -> f64 {
    let share = scatter / (digit * digit);
    let noise = if share < MEETS {
        PI.sqrt() * share
    } else {
        (share - 1.0 / 12.0).sqrt()
    };
    let wave = |k: f64| (-(2.0 * PI * k * noise).powi(2)).exp() / (2.0 * (PI * k).powi(2));
    let variance: f64 = (1..=WAVES).map(|k| wave(f64::from(k))).sum();
    digit * variance.sqrt()
}

/// Name of a channel, and where its mean is in a window's readings.
fn channel(series: usize) -> (&'static str, usize) {
    match series {
        SCATTER_ACCEL => ("accel_x_m_s2", ACCEL),
        SCATTER_SPEED => ("ground_speed_m_s", SPEED),
        SCATTER_YAW => ("yaw_rate_rad_s", YAW_RATE),
        k if k >= SCATTER_WHEEL => ("wheel_speed_rad_s", WHEEL + k - SCATTER_WHEEL),
        k => ("wheel_torque_N_m", TORQUE + k),
    }
}

/// Raises the noise of windows of one log, in their order, by what their digits hide, and says of which channels. `sd`: 1-sigma of a
/// sample of each.
pub(super) fn raise(
    taken: &mut [Taken],
    seen: &[Values; SERIES],
    sd: &[f64; SERIES],
) -> Vec<String> {
    let mut coarse: Vec<(&str, f64)> = vec![];
    for (k, seen) in seen.iter().enumerate() {
        let Some(digit) = seen.digit() else {
            continue;
        };
        let squares = taken.iter().map(|t| t.scatter[k]).filter(|s| s.is_finite());
        let (sum, count) = squares.fold((0.0, 0.0), |(sum, n), s| (sum + s, n + 1.0));
        let off = off(digit, sum / f64::max(count, 1.0) * sd[k] * sd[k]);
        let (name, place) = channel(k);
        let own = |t: &Taken| t.observation.raw_sd[place];
        if count == 0.0 || taken.iter().all(|t| off < COUNTS * own(t)) {
            continue;
        }
        let together = |a: &Taken, b: &Taken| {
            let apart = b.window.raw[place] - a.window.raw[place];
            a.observation.group == b.observation.group && apart.abs() < 0.5 * digit
        };
        for even in taken.chunk_by_mut(together) {
            let variance = off * off * even.len() as f64;
            for t in even {
                let sd = &mut t.observation.raw_sd[place];
                *sd = sd.hypot(variance.sqrt());
            }
        }
        match coarse.iter_mut().find(|(known, _)| *known == name) {
            Some((_, most)) => *most = most.max(digit),
            None => coarse.push((name, digit)),
        }
    }
    let note = |(name, digit): (&str, f64)| {
        format!(
            "{name} is rounded to {digit:.3}, more coarsely than it scatters: where it runs evenly all of it is off by the same part of that, and counts for less"
        )
    };
    coarse.into_iter().map(note).collect()
}

#[cfg(test)]
mod tests {
    use chacha20::ChaCha8Rng;
    use chacha20::rand_core::SeedableRng;
    use rand_distr::{Distribution, Normal, Uniform};

    use super::*;

    /// Values on a lattice that begins anywhere show it, to the decimals they are written with; noise does not, nor do a few values.
    #[test]
    fn a_digit_is_seen() {
        let digit = |values: &[f64]| {
            let mut seen = Values::default();
            values.iter().for_each(|v| seen.see(*v));
            seen.digit()
        };
        let rpm = |k: f64| (k * PI / 30.0 * 1e6).round() / 1e6;
        let coarse: Vec<f64> = (0..200).map(|k| rpm(f64::from(17 + k * k % 31))).collect();
        assert!((digit(&coarse).unwrap() - PI / 30.0).abs() < 1e-6);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let noise = Normal::new(2.0, 0.1).unwrap();
        let fine: Vec<f64> = (0..300).map(|_| noise.sample(&mut rng)).collect();
        assert!(digit(&fine).is_none_or(|d| d < 1e-3));
        assert_eq!(digit(&coarse[..3]), None);
        let many: Vec<f64> = (0..600).map(f64::from).collect();
        assert_eq!(digit(&many), None);
    }

    /// Means of many rounded samples, over true values anywhere in a digit: off by as much as is said of how they scatter, to a
    /// tenth, from no noise to noise of a third of a digit.
    #[test]
    fn rounded_means_are_off_as_said() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let anywhere = Uniform::new(0.0f64, 1.0).unwrap();
        for sd in [1e-9f64, 0.05, 0.15, 0.25, 0.35] {
            let noise = Normal::new(0.0, sd).unwrap();
            let (mut errors, mut scatters) = (0.0, 0.0);
            for _ in 0..4000 {
                let c: f64 = anywhere.sample(&mut rng);
                let read: Vec<f64> = (0..400)
                    .map(|_| (c + noise.sample(&mut rng)).round())
                    .collect();
                let mean = read.iter().sum::<f64>() / 400.0;
                errors += (mean - c).powi(2) / 4000.0;
                let squares = read.iter().map(|r| (r - mean).powi(2));
                scatters += squares.sum::<f64>() / 399.0 / 4000.0;
            }
            // Without what is left of white noise in a mean.
            let there = f64::sqrt(errors - scatters / 400.0);
            let said = off(1.0, scatters);
            assert!((said / there - 1.0).abs() < 0.1, "{sd}: {said} {there}");
        }
    }
}
