//! The noise of a drive's sensors as the log itself shows it inside its windows, where that is more than the rover file states.
//!
//! Inside a window a drive goes straight: what scatters around a line is the sensor's noise, whatever soil and model. A sensor
//! that is noisier than stated, or whose samples follow each other (a filter, a held value), leaves a window's mean and slope less
//! certain than white noise of the stated size would, and every small part of that would be read as something unknown.
//!
//! # Equation
//! Noise of variance s² whose samples are correlated by ρ^|i - j| = R leaves, with M = I - uu' - vv' (u and v the unit vectors of
//! mean and slope), the square s² tr(MR) around the line and the product s² Σ (MRM)_(i,i+1) of neighbours. Their ratio gives ρ,
//! the square then s²; mean and slope have s² u'Ru/n and s² v'Rv/|τ|².
//!
//! # Source
//! Least squares with autocorrelated errors, e.g. G. S. Watson, Biometrika 42(3/4), 1955 (recalled); windows with a step or a bend
//! inside are left out.

use std::ops::Range;

use super::window::{SCATTER_ACCEL, SCATTER_SPEED, SCATTER_WHEEL, SCATTER_YAW, SERIES, Taken};
use super::{
    ACCEL, AROUND, RAW, SPEED, SPEED_RATE, TORQUE, WHEEL, WHEEL_RATE, YAW_ACCELERATION, YAW_RATE,
};
use crate::rig::median;

/// Standard errors beyond the stated noise from which a log's own noise is taken.
const BEYOND: f64 = 3.0;
/// Variance over the stated one up to which it is left: wheels do not run quite straight inside a window either.
const LITTLE: f64 = 1.3;
/// Largest correlation of one sample with the next that is looked for.
const LARGEST: f64 = 0.98;
/// Square around the line over the usual one up to which a window is steady.
const STEADY: f64 = 2.0;
/// Fewest windows that tell.
const FEWEST: usize = 8;

/// What noise of this correlation leaves of windows of n samples: tr(MR), the sum of neighbours over it, u'Ru and v'Rv.
struct Left {
    square: f64,
    lag: f64,
    mean: f64,
    slope: f64,
}

fn left(n: usize, rho: f64) -> Left {
    let count = n as f64;
    let middle = 0.5 * (count - 1.0);
    let length = (count * (count * count - 1.0) / 12.0).sqrt();
    let u = 1.0 / count.sqrt();
    let v: Vec<f64> = (0..n).map(|i| (i as f64 - middle) / length).collect();
    let powers: Vec<f64> = (0..n).map(|k| rho.powi(k as i32)).collect();
    let r = |i: usize, j: usize| powers[i.abs_diff(j)];
    let times = |w: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let row = |i: usize| (0..n).map(|j| r(i, j) * w(j)).sum();
        (0..n).map(row).collect()
    };
    let (ru, rv) = (times(&|_| u), times(&|j| v[j]));
    let mean: f64 = ru.iter().map(|x| x * u).sum();
    let slope: f64 = rv.iter().zip(&v).map(|(x, v)| x * v).sum();
    let square = count - mean - slope;
    let neighbours: f64 = (0..n.saturating_sub(1))
        .map(|i| {
            let j = i + 1;
            r(i, j) - u * (ru[j] + ru[i]) - v[i] * rv[j] - rv[i] * v[j]
                + u * u * mean
                + v[i] * v[j] * slope
        })
        .sum();
    Left {
        square,
        lag: neighbours / square,
        mean,
        slope,
    }
}

/// The correlation of one sample with the next, and the variances of a window's mean and slope over those of white noise of the
/// stated size; by the mean square around the line over what is stated, and the lag.
fn beyond_stated(n: usize, square: f64, lag: f64) -> (f64, [f64; 2]) {
    let (mut low, mut high) = (0.0, LARGEST);
    if lag <= left(n, 0.0).lag {
        high = 0.0;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if left(n, middle).lag < lag {
            low = middle;
        } else {
            high = middle;
        }
    }
    let rho = 0.5 * (low + high);
    let there = left(n, rho);
    let variance = square * (n as f64 - 2.0) / there.square;
    (rho, [variance * there.mean, variance * there.slope])
}

/// One sensor: its name, its places in a window's scatter, and those of the mean and the slope of each in a window's readings.
struct Sensor {
    name: &'static str,
    series: Range<usize>,
    means: usize,
    slopes: Option<usize>,
}

const SENSORS: [Sensor; 5] = [
    Sensor {
        name: "ground_speed_m_s",
        series: SCATTER_SPEED..SCATTER_SPEED + 1,
        means: SPEED,
        slopes: Some(SPEED_RATE),
    },
    Sensor {
        name: "yaw_rate_rad_s",
        series: SCATTER_YAW..SCATTER_YAW + 1,
        means: YAW_RATE,
        slopes: Some(YAW_ACCELERATION),
    },
    Sensor {
        name: "accel_x_m_s2",
        series: SCATTER_ACCEL..SCATTER_ACCEL + 1,
        means: ACCEL,
        slopes: None,
    },
    Sensor {
        name: "wheel_torque_N_m",
        series: 0..SCATTER_ACCEL,
        means: TORQUE,
        slopes: None,
    },
    Sensor {
        name: "wheel_speed_rad_s",
        series: SCATTER_WHEEL..SERIES,
        means: WHEEL,
        slopes: Some(WHEEL_RATE),
    },
];

/// The log's own noise of a sensor, where it is beyond the stated: how much more its samples scatter, how they follow each other,
/// and the factors on the variance of mean and slope.
fn own(taken: &[Taken], sensor: &Sensor) -> Option<(f64, f64, [f64; 2])> {
    let of = |t: &Taken| {
        let all = sensor.series.clone().map(|k| (t.scatter[k], t.lag[k]));
        all.collect::<Vec<_>>()
    };
    let mut known: Vec<(f64, f64, usize)> = taken
        .iter()
        .flat_map(of)
        .filter(|(square, (lag, n))| square.is_finite() && lag.is_finite() && *n > 3)
        .map(|(square, (lag, n))| (square, lag, n))
        .collect();
    // A step or a bend inside a window is no noise.
    let usual = median(known.iter().map(|w| w.0));
    known.retain(|w| w.0 <= STEADY * usual);
    let windows = known.len() as f64;
    if known.len() < FEWEST {
        return None;
    }
    let n = median(known.iter().map(|w| w.2 as f64)) as usize;
    let square = known.iter().map(|w| w.0).sum::<f64>() / windows;
    let lag = known.iter().map(|w| w.0 * w.1).sum::<f64>() / (square * windows);
    let (rho, factors) = beyond_stated(n, square, lag);
    // Of means over windows of chi2/(n - 2) and of the lag, which counts twice.
    let error = ((2.0 / (n as f64 - 2.0) + 4.0 / n as f64) / windows).sqrt();
    let most = factors[0].max(factors[1]);
    (most > LITTLE.max(1.0 + BEYOND * error)).then_some((square.sqrt(), rho, factors))
}

/// Variance of a window's mean acceleration that the log's samples show beyond the stated noise \[m²/s⁴\].
pub(super) fn beyond_of_acceleration(taken: &[Taken]) -> f64 {
    let mut all = SENSORS.iter();
    let found = all.find(|s| s.means == ACCEL).and_then(|s| own(taken, s));
    let stated = taken
        .iter()
        .filter(|t| t.scatter[SCATTER_ACCEL].is_finite())
        .map(|t| t.observation.raw_sd[ACCEL].powi(2));
    found.map_or(0.0, |(_, _, [of_mean, _])| {
        (of_mean - 1.0).max(0.0) * median(stated)
    })
}

/// Raises the noise of the windows to the log's own where that is beyond chance, and says so. Where the rover file does not state
/// how rough the ground is, only that of the ground speed, which inertia keeps smooth: the ground scatters all else, and is told
/// from the bends of three windows.
pub(super) fn raise(taken: &mut [Taken], rough: bool) -> Vec<String> {
    let mut notes = vec![];
    for sensor in SENSORS.iter().filter(|s| rough || s.means == SPEED) {
        let Some((size, rho, factors)) = own(taken, sensor) else {
            continue;
        };
        let [of_mean, of_slope] = factors.map(|f| f.max(1.0).sqrt());
        for t in taken.iter_mut() {
            let sd = &mut t.observation.raw_sd;
            for k in 0..sensor.series.len() {
                // Where a channel is not measured its sd is no sensor's.
                if !t.scatter[sensor.series.start + k].is_finite() {
                    continue;
                }
                sd[sensor.means + k] *= of_mean;
                if let Some(slopes) = sensor.slopes {
                    sd[slopes + k] *= of_slope;
                }
                if sensor.means == SPEED {
                    sd[AROUND..RAW].iter_mut().for_each(|sd| *sd *= of_mean);
                }
            }
        }
        let slope = sensor.slopes.map_or(String::new(), |_| {
            format!(", its slope {of_slope:.2} times")
        });
        notes.push(format!(
            "{}: inside the windows its samples scatter {size:.2} times as much as [noise] states and follow each other with a correlation of {rho:.2}: a window's mean is taken {of_mean:.2} times as uncertain as stated{slope}",
            sensor.name
        ));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::line;
    use chacha20::ChaCha8Rng;
    use chacha20::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// White noise around a line: n - 2 freedoms, whose neighbours have tr(MS) of the square, by hand for three samples: the
    /// residuals are (1, -2, 1)/6 of one number, so their lag is -4/6.
    #[test]
    fn white_noise_by_hand() {
        let three = left(3, 0.0);
        assert!((three.square - 1.0).abs() < 1e-12);
        assert!((three.lag + 4.0 / 6.0).abs() < 1e-12);
        let many = left(20, 0.0);
        assert!((many.square - 18.0).abs() < 1e-12);
        assert!((many.mean - 1.0).abs() < 1e-12 && (many.slope - 1.0).abs() < 1e-12);
        let (rho, [mean, slope]) = beyond_stated(20, 1.0, many.lag);
        assert_eq!(rho, 0.0);
        assert!((mean - 1.0).abs() < 1e-9 && (slope - 1.0).abs() < 1e-9);
    }

    /// Windows of simulated noise 1.5 times as large as stated and correlated by .5 from sample to sample: what is found is what
    /// means and slopes of those windows scatter by.
    #[test]
    fn what_is_found_is_what_means_and_slopes_scatter_by() {
        let (n, rho, size) = (20, 0.5, 1.5);
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let time: Vec<f64> = (0..n).map(|i| 0.01 * f64::from(i)).collect();
        let windows: Vec<_> = (0..4000)
            .map(|_| {
                let mut last = normal();
                let series = (0..n)
                    .map(|_| {
                        let next = rho * last + (1.0f64 - rho * rho).sqrt() * normal();
                        Some(size * std::mem::replace(&mut last, next))
                    })
                    .collect();
                line(&time, &series, 0..n as usize, 1.0).unwrap()
            })
            .collect();
        let square = windows.iter().map(|w| w.scatter).sum::<f64>() / windows.len() as f64;
        let lag = windows.iter().map(|w| w.scatter * w.lag).sum::<f64>();
        let lag = lag / (square * windows.len() as f64);
        let (found, [mean, slope]) = beyond_stated(n as usize, square, lag);
        assert!((found - rho).abs() < 0.02, "{found}");
        let scatter = |of: &dyn Fn(&crate::drive::Line) -> f64| {
            windows.iter().map(|w| of(w).powi(2)).sum::<f64>() / windows.len() as f64
        };
        let of_mean = scatter(&|w| w.mean / w.mean_sd);
        let of_slope = scatter(&|w| w.slope / w.slope_sd);
        assert!((mean / of_mean - 1.0).abs() < 0.1, "{mean} {of_mean}");
        assert!((slope / of_slope - 1.0).abs() < 0.1, "{slope} {of_slope}");
        // White noise of the stated size would have them at 1: three to six times less.
        assert!(of_mean > 5.0 && of_slope > 3.0);
    }
}
