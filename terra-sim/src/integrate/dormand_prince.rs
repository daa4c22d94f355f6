//! The Runge-Kutta pair of Dormand and Prince, orders 5 and 4, with its step chosen by the difference of the two.
//!
//! # Equation
//! Seven stages, the last of which is the first of the next step. Error e = y5 - y4, accepted when
//! sqrt(mean((e / (atol + rtol max(|y|, |y_new|)))²)) <= 1; next step h · clamp(0.9 err^(-1/5), 0.2, 5).
//!
//! # Reference
//! J. R. Dormand, P. J. Prince, J. Comp. Appl. Math. 6 (1980) 19-26; Hairer, Nørsett, Wanner, Solving ODE I, II.4-5.

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
            max_step: 0.01,
        }
    }
}

const MIN_STEP: f64 = 1e-10;

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
        self.advance_watching(N, &mut None, rate, t, end, y, step)
    }

    /// The error is judged by the first `watched` states only; the others are carried along. Steps begin with `first`.
    pub(crate) fn advance_watching<const N: usize>(
        &self,
        watched: usize,
        first: &mut Option<f64>,
        rate: &mut impl FnMut(f64, &[f64; N]) -> Result<[f64; N], SimError>,
        t: f64,
        end: f64,
        y: &mut [f64; N],
        step: &mut impl FnMut(f64, &[f64; N]),
    ) -> Result<(), SimError> {
        let mut now = t;
        let mut h = first.unwrap_or(self.max_step);
        let mut k1 = rate(now, y)?;
        while end - now > MIN_STEP {
            let free = h.min(self.max_step);
            h = free.min(end - now);
            // A rest too short for its own step is taken along.
            if end - now - h < MIN_STEP {
                h = end - now;
            }
            let (error, attempt) = match self.attempt(watched, rate, now, h, y, &k1) {
                Ok((next, k7, error)) if error.is_finite() => (error, Ok((next, k7))),
                Ok(_) => (f64::INFINITY, Err(SimError::NotFinite { time: now })),
                // A stage that overshoots out of the model's domain is a step too long.
                Err(e) => (f64::INFINITY, Err(e)),
            };
            if error <= 1.0 {
                if let Ok((next, k7)) = attempt {
                    now += h;
                    *y = next;
                    k1 = k7;
                    finite(now, y)?;
                    step(now, y);
                }
            } else if h <= 2.0 * MIN_STEP {
                return Err(attempt
                    .err()
                    .unwrap_or(SimError::StepTooSmall { time: now, step: h }));
            }
            let factor = if error.is_finite() {
                0.9 * error.max(1e-10).powf(-0.2)
            } else {
                0.2
            };
            let cut = h < free;
            h = (h * factor.clamp(0.2, 5.0)).max(MIN_STEP);
            // A step that the end cut short says nothing against the one before it.
            if cut && error <= 1.0 {
                h = h.max(free);
            }
            *first = Some(h);
        }
        Ok(())
    }

    #[allow(clippy::type_complexity)]
    fn attempt<const N: usize>(
        &self,
        watched: usize,
        rate: &mut impl FnMut(f64, &[f64; N]) -> Result<[f64; N], SimError>,
        t: f64,
        h: f64,
        y: &[f64; N],
        k1: &[f64; N],
    ) -> Result<([f64; N], [f64; N], f64), SimError> {
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
        let mut sum = 0.0;
        for ((e, old), new) in difference.iter().zip(y).zip(&next).take(watched) {
            let scaled = e / (self.absolute + self.relative * old.abs().max(new.abs()));
            sum += scaled * scaled;
        }
        Ok((next, k7, (sum / watched.clamp(1, N) as f64).sqrt()))
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
                .advance(
                    &mut |_, y: &[f64; 1]| Ok([y[0]]),
                    0.0,
                    h,
                    &mut y,
                    &mut |_, _| {},
                )
                .unwrap();
            (y[0] - h.exp()).abs()
        };
        let order = (error(0.4) / error(0.2)).log2();
        assert!((order - 6.0).abs() < 0.3, "order {order}");
    }
}
