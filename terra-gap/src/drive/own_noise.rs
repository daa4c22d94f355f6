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

use std::collections::BTreeMap;
use std::ops::Range;

use super::bend::middle;
use super::window::{SCATTER_ACCEL, SCATTER_SPEED, SCATTER_WHEEL, SCATTER_YAW, SERIES, Taken};
use super::{
    ACCEL, AROUND, RAW, SPEED, SPEED_RATE, TORQUE, WHEEL, WHEEL_RATE, YAW_ACCELERATION, YAW_RATE,
};
use crate::rig::median;

/// Standard errors beyond the stated noise from which a log's own noise is taken, and up to which a window is steady.
const BEYOND: f64 = 3.0;
/// Variance over the stated one up to which it is left: wheels do not run quite straight inside a window either.
const LITTLE: f64 = 1.3;
/// Correlation below its negative at which wheel speeds are differences of counts.
const COUNTED: f64 = 0.3;
/// Largest correlation of one sample with the next that is looked for.
const LARGEST: f64 = 0.98;
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
    let powers: Vec<f64> = (0..n).map(|k| rho.powi(k as i32)).collect();
    left_by(n, &powers)
}

/// The same of differences of a position that is read with white noise, as of an encoder's counts: each takes back half of the one
/// before.
fn left_by_differences(n: usize) -> Left {
    let mut alike = vec![0.0; n];
    alike
        .iter_mut()
        .zip([1.0, -0.5])
        .for_each(|(r, by)| *r = by);
    left_by(n, &alike)
}

/// `alike`: how far samples so far apart are.
fn left_by(n: usize, alike: &[f64]) -> Left {
    let count = n as f64;
    let middle = 0.5 * (count - 1.0);
    let length = (count * (count * count - 1.0) / 12.0).sqrt();
    let u = 1.0 / count.sqrt();
    let v: Vec<f64> = (0..n).map(|i| (i as f64 - middle) / length).collect();
    let r = |i: usize, j: usize| alike[i.abs_diff(j)];
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

/// Windows of one sensor: how many samples each has, the square around its line over what is stated, and the product of neighbours
/// over that square.
struct Seen(Vec<(usize, f64, f64)>);

impl Seen {
    /// Leaves out windows with a step or a bend inside, which is no noise: few samples scatter their square the more.
    fn steady(mut self) -> Self {
        let freedoms = |n: usize| n as f64 - 2.0;
        let usual = median(self.0.iter().map(|&(n, square, _)| square / middle(n)));
        let most = |n: usize| usual * (1.0 + BEYOND * (2.0 / freedoms(n)).sqrt());
        self.0.retain(|&(n, square, _)| square <= most(n));
        self
    }

    /// The square of all of them, the product of neighbours over it, and the standard error of that.
    fn lag(&self) -> (f64, f64, f64) {
        let squares = |&(n, square, lag): &(usize, f64, f64)| (square * (n as f64 - 2.0), lag);
        let all = self.0.iter().map(squares);
        let square: f64 = all.clone().map(|(square, _)| square).sum();
        let lag = all.clone().map(|(square, lag)| square * lag).sum::<f64>() / square;
        let off = all.map(|(square, own)| (square * (own - lag)).powi(2));
        (square, lag, off.sum::<f64>().sqrt() / square)
    }

    /// The correlation of one sample with the next, where it is beyond chance, and the variance over the stated one; both once as they
    /// are likeliest and once as small as chance leaves them.
    fn noise(&self) -> [(f64, f64); 2] {
        let mut lengths: BTreeMap<usize, f64> = BTreeMap::new();
        for (n, ..) in &self.0 {
            *lengths.entry(*n).or_default() += 1.0;
        }
        // Over all windows, the square and the product of neighbours that a correlation leaves.
        let leaves = |rho: f64| {
            let each = lengths.iter().map(|(&n, windows)| {
                let left = left(n, rho);
                (windows * left.square, windows * left.square * left.lag)
            });
            each.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
        };
        let at = |lag: f64| {
            let (mut low, mut high) = (0.0, LARGEST);
            let below = |rho: f64| {
                let (square, neighbours) = leaves(rho);
                neighbours / square < lag
            };
            // What follows itself more than any noise is a bend of the motion.
            if !below(0.0) || below(LARGEST) {
                return 0.0;
            }
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if below(middle) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            0.5 * (low + high)
        };
        let (square, lag, error) = self.lag();
        let freedoms: f64 = self.0.iter().map(|w| w.0 as f64 - 2.0).sum();
        let surely = at(lag - BEYOND * error);
        let likeliest = if surely > 0.0 { at(lag) } else { 0.0 };
        let variance = |rho: f64| square / leaves(rho).0;
        let less = 1.0 - BEYOND * (2.0 / freedoms).sqrt();
        [
            (likeliest, variance(likeliest)),
            (surely, less * variance(surely)),
        ]
    }
}

impl Seen {
    /// The share of the square that is of differences, where it is beyond chance.
    fn by_differences(&self, n: usize) -> Option<f64> {
        let (_, lag, error) = self.lag();
        let [white, differences] = [left(n, 0.0), left_by_differences(n)].map(|left| left.lag);
        let share = |lag: f64| ((white - lag) / (white - differences)).clamp(0.0, 1.0);
        (share(lag + BEYOND * error) > 0.0).then(|| share(lag))
    }
}

/// The variances of a window's mean and slope over those of white noise of the stated size.
fn factors(n: usize, (rho, variance): (f64, f64)) -> [f64; 2] {
    let there = left(n, rho);
    [variance * there.mean, variance * there.slope]
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
/// and the factors on the variance of mean and slope. `counts`: they may be differences of counts.
fn own(taken: &[Taken], sensor: &Sensor, counts: bool) -> Option<(f64, f64, [f64; 2])> {
    let of = |t: &Taken| {
        let all = sensor.series.clone().map(|k| (t.scatter[k], t.lag[k]));
        all.collect::<Vec<_>>()
    };
    let known = taken
        .iter()
        .flat_map(of)
        .filter(|(square, (lag, n))| square.is_finite() && lag.is_finite() && *n > 3)
        .map(|(square, (lag, n))| (n, square, lag));
    Seen(known.collect()).steady().beyond(counts)
}

impl Seen {
    /// What of them is beyond the stated noise: as [`own`].
    fn beyond(&self, counts: bool) -> Option<(f64, f64, [f64; 2])> {
        if self.0.len() < FEWEST {
            return None;
        }
        let n = median(self.0.iter().map(|w| w.0 as f64)) as usize;
        if counts && let Some(share) = self.by_differences(n) {
            let square = median(self.0.iter().map(|w| w.1));
            let (white, there) = (left(n, 0.0), left_by_differences(n));
            let variance =
                square * (n as f64 - 2.0) / (share * there.square + (1.0 - share) * white.square);
            let factor =
                |white: f64, there: f64| variance * (share * there + (1.0 - share) * white);
            let factors = [
                factor(white.mean, there.mean),
                factor(white.slope, there.slope),
            ];
            let beyond = factors.iter().any(|f| *f > LITTLE);
            return beyond.then(|| (square.sqrt(), -0.5 * share, factors));
        }
        let [likeliest, surely] = self.noise();
        let most = factors(n, surely).into_iter().fold(0.0, f64::max);
        // The square as it was seen: around a line noise that follows itself scatters less than it is large.
        let square = likeliest.1 * left(n, likeliest.0).square / (n as f64 - 2.0);
        (most > LITTLE).then(|| (square.sqrt(), likeliest.0, factors(n, likeliest)))
    }
}

/// Variance of a window's mean acceleration that the log's samples show beyond the stated noise \[m²/s⁴\].
pub(super) fn beyond_of_acceleration(taken: &[Taken]) -> f64 {
    let mut all = SENSORS.iter();
    let found = all
        .find(|s| s.means == ACCEL)
        .and_then(|s| own(taken, s, false));
    let stated = taken
        .iter()
        .filter(|t| t.scatter[SCATTER_ACCEL].is_finite())
        .map(|t| t.observation.raw_sd[ACCEL].powi(2));
    found.map_or(0.0, |(_, _, [of_mean, _])| {
        (of_mean - 1.0).max(0.0) * median(stated)
    })
}

/// What a log's own noise is beyond the stated one.
#[derive(Clone, Debug, Default)]
pub(crate) struct OwnNoise {
    /// Of these sensors how much more uncertain a window's mean and slope are.
    beyond: Vec<(usize, [f64; 2])>,
    /// What is said of it.
    pub(crate) notes: Vec<String>,
}

impl OwnNoise {
    /// Of the windows' sensors where it is beyond chance. Where the rover file does not state how rough the ground is, only that of
    /// the ground speed, which inertia keeps smooth, and of wheel speeds that take back what they said before, as no ground makes
    /// them: the ground scatters all else, and is told from the bends of three windows.
    pub(crate) fn of(taken: &[Taken], rough: bool) -> Self {
        let mut out = OwnNoise::default();
        for (number, sensor) in SENSORS.iter().enumerate() {
            // On stated roughness they are left to be as uncertain as white noise of their size, which hides small errors of other
            // sensors too.
            let counts = !rough && sensor.means == WHEEL;
            let counted = |rho: f64| counts && rho < -COUNTED;
            let found = own(taken, sensor, counts)
                .filter(|(_, rho, _)| rough || sensor.means == SPEED || counted(*rho));
            let Some((size, rho, factors)) = found else {
                continue;
            };
            let [of_mean, of_slope] = factors.map(|f| f.max(1.0).sqrt());
            let slope = sensor.slopes.map_or(String::new(), |_| {
                format!(", its slope {of_slope:.2} times")
            });
            out.notes.push(format!(
                "{}: inside the windows its samples scatter {size:.2} times as much as [noise] states and follow each other with a correlation of {rho:.2}: a window's mean is taken {of_mean:.2} times as uncertain as stated{slope}",
                sensor.name
            ));
            out.beyond.push((number, [of_mean, of_slope]));
        }
        out
    }

    /// Makes a window as uncertain as that.
    pub(crate) fn raise(&self, t: &mut Taken) {
        let sd = &mut t.observation.raw_sd;
        for (number, [of_mean, of_slope]) in &self.beyond {
            let sensor = &SENSORS[*number];
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
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::{Line, line};
    use chacha20::ChaCha8Rng;
    use chacha20::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// Windows of twenty samples, each made of what is kept of the last one and normal numbers.
    fn windows(seed: u64, sample: impl Fn(&mut f64, &mut dyn FnMut() -> f64) -> f64) -> Vec<Line> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let time: Vec<f64> = (0..20).map(|i| 0.01 * f64::from(i)).collect();
        let window = |_| {
            let mut last = normal();
            let series = time.iter().map(|_| Some(sample(&mut last, &mut normal)));
            line(&time, &series.collect(), 0..20, 1.0).unwrap()
        };
        (0..4000).map(window).collect()
    }

    /// By how much means and slopes of windows are off, over the variance that white noise of the stated size leaves them.
    fn scatter(windows: &[Line]) -> [f64; 2] {
        let of = |of: &dyn Fn(&Line) -> f64| {
            windows.iter().map(|w| of(w).powi(2)).sum::<f64>() / windows.len() as f64
        };
        [of(&|w| w.mean / w.mean_sd), of(&|w| w.slope / w.slope_sd)]
    }

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
        let seen = Seen(vec![(20, 1.0, many.lag); 10]);
        let [likeliest, _] = seen.noise();
        assert_eq!(likeliest.0, 0.0);
        let [mean, slope] = factors(20, likeliest);
        assert!((mean - 1.0).abs() < 1e-9 && (slope - 1.0).abs() < 1e-9);
    }

    /// Windows of simulated noise 1.5 times as large as stated and correlated by .5 from sample to sample: what is found is what
    /// means and slopes of those windows scatter by.
    #[test]
    fn what_is_found_is_what_means_and_slopes_scatter_by() {
        let (n, rho, size) = (20, 0.5, 1.5);
        let windows = windows(7, |last, normal| {
            let next = rho * *last + (1.0f64 - rho * rho).sqrt() * normal();
            size * std::mem::replace(last, next)
        });
        let seen = windows.iter().map(|w| (w.samples, w.scatter, w.lag));
        let [likeliest, surely] = Seen(seen.collect()).noise();
        let (found, [mean, slope]) = (likeliest.0, factors(n, likeliest));
        assert!((found - rho).abs() < 0.02, "{found}");
        assert!(surely.0 < found && surely.0 > found - 0.05, "{surely:?}");
        let [of_mean, of_slope] = scatter(&windows);
        assert!((mean / of_mean - 1.0).abs() < 0.1, "{mean} {of_mean}");
        assert!((slope / of_slope - 1.0).abs() < 0.1, "{slope} {of_slope}");
        // White noise of the stated size would have them at 1: three to six times less.
        assert!(of_mean > 5.0 && of_slope > 3.0);
    }

    /// Differences of a position that is read with white noise, eight times as large as stated, beside white noise as stated: means
    /// are off by as much as is found and far less than white noise of that size would leave them, slopes likewise.
    #[test]
    fn differences_of_counts_take_back_what_they_say() {
        let windows = windows(5, |last, normal| {
            let next = normal();
            8.0 * (next - std::mem::replace(last, next)) / 2f64.sqrt() + normal()
        });
        let seen = windows.iter().map(|w| (w.samples, w.scatter, w.lag));
        let (size, rho, [mean, slope]) = Seen(seen.collect()).steady().beyond(true).unwrap();
        assert!(
            (size - 8.0).abs() < 0.5 && (rho + 0.49).abs() < 0.02,
            "{size} {rho}"
        );
        let [of_mean, of_slope] = scatter(&windows);
        assert!((mean / of_mean - 1.0).abs() < 0.3, "{mean} {of_mean}");
        assert!((slope / of_slope - 1.0).abs() < 0.3, "{slope} {of_slope}");
        assert!(of_mean < 8.0 && of_slope < 16.0, "{of_mean} {of_slope}");
    }

    /// White noise of the stated size in windows of four, five and six samples, as a slow sensor leaves them: nothing beyond what is
    /// stated, whatever lengths stand side by side. Of twenty logs none is told otherwise.
    #[test]
    fn few_samples_of_white_noise_do_not_follow_each_other() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        for log in 0..20 {
            let windows = (0..300).map(|k| {
                let n = 4 + (k + log) % 3;
                let time: Vec<f64> = (0..n).map(|i| 0.05 * i as f64).collect();
                let series = (0..n).map(|_| Some(normal())).collect();
                let w = line(&time, &series, 0..n, 1.0).unwrap();
                (w.samples, w.scatter, w.lag)
            });
            let seen = Seen(windows.collect()).steady();
            assert_eq!(seen.beyond(true), None);
            let [(rho, variance), _] = seen.noise();
            assert_eq!(rho, 0.0);
            assert!((0.85..1.15).contains(&variance), "{variance}");
        }
    }
}
