//! The Runge-Kutta pair of Dormand and Prince, orders 5 and 4, with its step chosen by the difference of the two.
//!
//! # Equation
//! Seven stages, the last of which is the first of the next step. Error e = y5 - y4, accepted when
//! err = sqrt(mean((e / (atol + rtol max(|y|, |y_new|)))²)) <= 1; next step h · clamp(0.9 err^(-.17) err_last^(.04), 0.2, 5),
//! which answers to the trend of the error as well as to its size. The first step is the one whose Euler step changes
//! little, by the slope and its change.
//!
//! # Reference
//! J. R. Dormand, P. J. Prince, J. Comp. Appl. Math. 6 (1980) 19-26; Hairer, Nørsett, Wanner, Solving ODE I, II.4-6 (first
//! step, solution inside a step); control of steps: II, IV.2.

use super::step::Step;
use super::{combine, finite};
use crate::error::SimError;

/// Adaptive Dormand-Prince 5(4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DormandPrince {
    /// Relative tolerance of a step \[1\].
    pub relative: f64,
    /// Absolute tolerance of a step, in the units of the state.
    pub absolute: f64,
    /// Largest step \[s\].
    pub max_step: f64,
}

impl Default for DormandPrince {
    fn default() -> Self {
        DormandPrince {
            relative: 1e-8,
            absolute: 1e-9,
            max_step: 0.1,
        }
    }
}

const MIN_STEP: f64 = 1e-10;
/// Exponents of the error of this step and of the one before.
const PRESENT: f64 = 0.2 - 0.75 * PAST;
const PAST: f64 = 0.04;

/// What an interval hands to the next: where the same motion goes on, so does its step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pace {
    /// The step to begin with \[s\].
    step: Option<f64>,
    /// Error of the step before, as a share of what is allowed.
    error: f64,
}

#[cfg(test)]
impl Pace {
    /// A motion that goes on with this step.
    pub(super) fn starting_with(step: f64) -> Self {
        Pace {
            step: Some(step),
            error: 1.0,
        }
    }
}

/// A step that was tried, and its error as a share of what is allowed.
type Tried<const N: usize> = (Step<N>, f64);

impl DormandPrince {
    /// As [`Integrator::advance`](super::Integrator::advance).
    ///
    /// # Errors
    /// As there.
    pub fn advance<const N: usize>(
        &self,
        rate: &mut impl FnMut(f64, &[f64; N]) -> Result<[f64; N], SimError>,
        t: f64,
        end: f64,
        y: &mut [f64; N],
        step: &mut impl FnMut(f64, &[f64; N]),
    ) -> Result<(), SimError> {
        let pace = &mut Pace::default();
        self.through(N, pace, rate, t, end, y, &mut |taken| {
            step(taken.end(), taken.last());
            Ok(false)
        })
    }

    /// The error is judged by the first `watched` states only; the others are carried along. `taken` is given each step,
    /// with the solution inside it, and says whether it changed what the rate is.
    pub(crate) fn through<const N: usize>(
        &self,
        watched: usize,
        pace: &mut Pace,
        rate: &mut impl FnMut(f64, &[f64; N]) -> Result<[f64; N], SimError>,
        t: f64,
        end: f64,
        y: &mut [f64; N],
        taken: &mut impl FnMut(&Step<N>) -> Result<bool, SimError>,
    ) -> Result<(), SimError> {
        let mut now = t;
        let mut k1 = rate(now, y)?;
        let mut h = match pace.step {
            Some(step) => step,
            None => self.first_step(watched, rate, (now, end), y, &k1)?,
        };
        while end - now > MIN_STEP {
            let free = h.min(self.max_step);
            h = free.min(end - now);
            // A rest too short for its own step is taken along.
            if end - now - h < MIN_STEP {
                h = end - now;
            }
            let (error, attempt) = match self.attempt(watched, rate, now, h, y, &k1) {
                Ok((step, error)) if error.is_finite() => (error, Ok(step)),
                Ok(_) => (f64::INFINITY, Err(SimError::NotFinite { time: now })),
                // A stage that overshoots out of the model's domain is a step too long.
                Err(e) => (f64::INFINITY, Err(e)),
            };
            let cut = h < free;
            let mut factor = if error.is_finite() {
                0.9 * error.max(1e-10).powf(-PRESENT)
            } else {
                0.2
            };
            if error <= 1.0 {
                if let Ok(step) = attempt {
                    // To the last bit where the interval ends.
                    now = if h == end - now { end } else { now + h };
                    *y = *step.last();
                    k1 = *step.last_rate();
                    finite(now, y)?;
                    if taken(&step)? {
                        k1 = rate(now, y)?;
                    }
                }
                factor *= pace.error.max(1e-4).powf(PAST);
                pace.error = error;
            } else {
                if h <= 2.0 * MIN_STEP {
                    return Err(attempt
                        .err()
                        .unwrap_or(SimError::StepTooSmall { time: now, step: h }));
                }
                factor = factor.min(1.0);
            }
            h = (h * factor.clamp(0.2, 5.0)).max(MIN_STEP);
            // A step that the end cut short says nothing against the one before it.
            if cut && error <= 1.0 {
                h = h.max(free);
            }
            pace.step = Some(h);
        }
        Ok(())
    }

    /// Root mean square of a change of state in units of what a step may be wrong by.
    fn size<const N: usize>(
        &self,
        watched: usize,
        change: &[f64; N],
        old: &[f64; N],
        new: &[f64; N],
    ) -> f64 {
        let mut sum = 0.0;
        for ((e, old), new) in change.iter().zip(old).zip(new).take(watched) {
            let scaled = e / (self.absolute + self.relative * old.abs().max(new.abs()));
            sum += scaled * scaled;
        }
        (sum / watched.clamp(1, N) as f64).sqrt()
    }

    /// A step whose Euler step is a hundredth of the state, or less where the slope itself changes fast.
    fn first_step<const N: usize>(
        &self,
        watched: usize,
        rate: &mut impl FnMut(f64, &[f64; N]) -> Result<[f64; N], SimError>,
        (t, end): (f64, f64),
        y: &[f64; N],
        k1: &[f64; N],
    ) -> Result<f64, SimError> {
        let most = self.max_step.min(end - t);
        let (state, slope) = (self.size(watched, y, y, y), self.size(watched, k1, y, y));
        let probe = if state > 1e-5 && slope > 1e-5 {
            (0.01 * state / slope).min(most)
        } else {
            most.min(1e-6)
        };
        // Where the Euler step leaves the model's domain, the probe itself is the step.
        let Ok(k2) = rate(t + probe, &combine(y, &[(probe, k1)])) else {
            return Ok(probe);
        };
        let change = combine(&k2, &[(-1.0, k1)]);
        let bend = self.size(watched, &change, y, y) / probe;
        let steepest = slope.max(bend);
        let step = if steepest > 1e-15 {
            (0.01 / steepest).powf(0.2)
        } else {
            (1e-3 * probe).max(1e-6)
        };
        Ok(step.min(100.0 * probe).min(most).max(MIN_STEP))
    }

    fn attempt<const N: usize>(
        &self,
        watched: usize,
        rate: &mut impl FnMut(f64, &[f64; N]) -> Result<[f64; N], SimError>,
        t: f64,
        h: f64,
        y: &[f64; N],
        k1: &[f64; N],
    ) -> Result<Tried<N>, SimError> {
        let k2 = rate(t + h / 5.0, &combine(y, &[(h / 5.0, k1)]))?;
        let k3 = rate(
            t + 0.3 * h,
            &combine(y, &[(h * 3.0 / 40.0, k1), (h * 9.0 / 40.0, &k2)]),
        )?;
        let k4 = rate(
            t + 0.8 * h,
            &combine(
                y,
                &[
                    (h * 44.0 / 45.0, k1),
                    (-h * 56.0 / 15.0, &k2),
                    (h * 32.0 / 9.0, &k3),
                ],
            ),
        )?;
        let k5 = rate(
            t + h * 8.0 / 9.0,
            &combine(
                y,
                &[
                    (h * 19372.0 / 6561.0, k1),
                    (-h * 25360.0 / 2187.0, &k2),
                    (h * 64448.0 / 6561.0, &k3),
                    (-h * 212.0 / 729.0, &k4),
                ],
            ),
        )?;
        let k6 = rate(
            t + h,
            &combine(
                y,
                &[
                    (h * 9017.0 / 3168.0, k1),
                    (-h * 355.0 / 33.0, &k2),
                    (h * 46732.0 / 5247.0, &k3),
                    (h * 49.0 / 176.0, &k4),
                    (-h * 5103.0 / 18656.0, &k5),
                ],
            ),
        )?;
        let next = combine(
            y,
            &[
                (h * 35.0 / 384.0, k1),
                (h * 500.0 / 1113.0, &k3),
                (h * 125.0 / 192.0, &k4),
                (-h * 2187.0 / 6784.0, &k5),
                (h * 11.0 / 84.0, &k6),
            ],
        );
        let k7 = rate(t + h, &next)?;
        // b5 - b4.
        let difference = combine(
            &[0.0; N],
            &[
                (h * 71.0 / 57600.0, k1),
                (-h * 71.0 / 16695.0, &k3),
                (h * 71.0 / 1920.0, &k4),
                (-h * 17253.0 / 339200.0, &k5),
                (h * 22.0 / 525.0, &k6),
                (-h / 40.0, &k7),
            ],
        );
        let error = self.size(watched, &difference, y, &next);
        let step = Step::new(t, h, [y, &next], [k1, &k3, &k4, &k5, &k6, &k7]);
        Ok((step, error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y'' = -y from (1, 0): cos t, within ten times the tolerance.
    #[test]
    fn meets_its_tolerance_on_the_harmonic_oscillator() {
        for relative in [1e-6, 1e-9] {
            let method = DormandPrince {
                relative,
                absolute: relative,
                max_step: 1.0,
            };
            let mut y = [1.0, 0.0];
            method
                .advance(
                    &mut |_, y: &[f64; 2]| Ok([y[1], -y[0]]),
                    0.0,
                    2.0,
                    &mut y,
                    &mut |_, _| {},
                )
                .unwrap();
            assert!((y[0] - 2f64.cos()).abs() < 10.0 * relative);
        }
    }

    /// One step of the fifth-order formula has a local error of order h^6.
    #[test]
    fn local_order_is_six() {
        let error = |h: f64| {
            let method = DormandPrince {
                relative: 1.0,
                absolute: 1.0,
                max_step: h,
            };
            let mut y = [1.0];
            method
                .through(
                    1,
                    &mut Pace::starting_with(h),
                    &mut |_, y: &[f64; 1]| Ok([y[0]]),
                    0.0,
                    h,
                    &mut y,
                    &mut |_| Ok(false),
                )
                .unwrap();
            (y[0] - h.exp()).abs()
        };
        let order = (error(0.4) / error(0.2)).log2();
        assert!((order - 6.0).abs() < 0.3, "order {order}");
    }
}
