//! The classic Runge-Kutta method of order 4.
//!
//! # Equation
//! k1 = f(t, y), k2 = f(t + h/2, y + h k1/2), k3 = f(t + h/2, y + h k2/2), k4 = f(t + h, y + h k3),
//! y(t + h) = y + h (k1 + 2 k2 + 2 k3 + k4)/6
//!
//! The method is stable for h |λ| < 2.78. A slowly rolling wheel on stiff soil has |λ| of thousands per second, so a
//! step whose own stages show h |λ| > 1, |λ| from |k3 - k2| / |h (k2 - k1)/2|, is halved. Where no step is halved the
//! order is 4.
//!
//! # Reference
//! E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., II.1; stiffness from the
//! stages: Solving Ordinary Differential Equations II, IV.2.

use super::{combine, finite};
use crate::error::SimError;

/// Fixed-step RK4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rk4 {
    /// Largest step \[s\]; an interval is cut into equal steps of at most this length.
    pub step: f64,
}

impl Default for Rk4 {
    fn default() -> Self {
        Rk4 { step: 1e-3 }
    }
}

/// Halvings of one step before it is an error.
const MAX_HALVINGS: u32 = 14;
/// A difference of stages below this is rounding and says nothing about stiffness.
const STAGE_NOISE: f64 = 1e-6;

impl Rk4 {
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
        self.through(N, rate, t, end, y, step)
    }

    /// Stiffness is looked for in the first `watched` states only; the others are carried along.
    pub(crate) fn through<const N: usize>(
        &self,
        watched: usize,
        rate: &mut impl FnMut(f64, &[f64; N]) -> Result<[f64; N], SimError>,
        t: f64,
        end: f64,
        y: &mut [f64; N],
        step: &mut impl FnMut(f64, &[f64; N]),
    ) -> Result<(), SimError> {
        let steps = ((end - t) / self.step - 1e-9).ceil().max(1.0);
        let h = (end - t) / steps;
        let mut done = 0.0;
        while done < steps {
            let from = t + done * h;
            done += 1.0;
            *y = one(watched, rate, from, h, y, 0)?;
            finite(from, y)?;
            step(from + h, y);
        }
        Ok(())
    }
}

fn one<const N: usize>(
    watched: usize,
    rate: &mut impl FnMut(f64, &[f64; N]) -> Result<[f64; N], SimError>,
    t: f64,
    h: f64,
    y: &[f64; N],
    halvings: u32,
) -> Result<[f64; N], SimError> {
    let k1 = rate(t, y)?;
    let stages = stages(watched, rate, t, h, y, &k1);
    match stages {
        Ok((next, stiffness)) if stiffness <= 1.0 => Ok(next),
        // A stage that overshoots out of the model's domain is a step too long until a short one fails as well.
        Err(error) if halvings >= MAX_HALVINGS => Err(error),
        Ok(_) if halvings >= MAX_HALVINGS => Err(SimError::StepTooSmall { time: t, step: h }),
        _ => {
            let middle = one(watched, rate, t, 0.5 * h, y, halvings + 1)?;
            one(watched, rate, t + 0.5 * h, 0.5 * h, &middle, halvings + 1)
        }
    }
}

fn stages<const N: usize>(
    watched: usize,
    rate: &mut impl FnMut(f64, &[f64; N]) -> Result<[f64; N], SimError>,
    t: f64,
    h: f64,
    y: &[f64; N],
    k1: &[f64; N],
) -> Result<([f64; N], f64), SimError> {
    let k2 = rate(t + 0.5 * h, &combine(y, &[(0.5 * h, k1)]))?;
    let k3 = rate(t + 0.5 * h, &combine(y, &[(0.5 * h, &k2)]))?;
    let k4 = rate(t + h, &combine(y, &[(h, &k3)]))?;
    let next = combine(
        y,
        &[
            (h / 6.0, k1),
            (h / 3.0, &k2),
            (h / 3.0, &k3),
            (h / 6.0, &k4),
        ],
    );
    let distance = |a: &[f64; N], b: &[f64; N]| {
        a.iter()
            .zip(b)
            .take(watched)
            .map(|(a, b)| (a - b) * (a - b))
            .sum::<f64>()
            .sqrt()
    };
    let (rise, input) = (distance(&k3, &k2), distance(&k2, k1));
    // rise = |λ| h/2 input, so h |λ| = 2 rise/input.
    let stiffness = if input < STAGE_NOISE {
        0.0
    } else {
        2.0 * rise / input
    };
    Ok((next, stiffness))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y'' = -y from (1, 0): the solution is cos t. Halving the step divides the error by 2^4.
    #[test]
    fn order_is_four_on_the_harmonic_oscillator() {
        let error = |step: f64| {
            let mut y = [1.0, 0.0];
            Rk4 { step }
                .advance(
                    &mut |_, y: &[f64; 2]| Ok([y[1], -y[0]]),
                    0.0,
                    2.0,
                    &mut y,
                    &mut |_, _| {},
                )
                .unwrap();
            (y[0] - 2f64.cos()).abs()
        };
        let order = (error(0.1) / error(0.05)).log2();
        assert!((order - 4.0).abs() < 0.15, "order {order}");
    }

    /// y' = -1e4 (y - cos t) - sin t has the solution cos t; plain RK4 with h = 1 ms diverges (h λ = 10).
    #[test]
    fn stiff_steps_are_halved() {
        let mut y = [1.5];
        Rk4 { step: 1e-3 }
            .advance(
                &mut |t: f64, y: &[f64; 1]| Ok([-1e4 * (y[0] - t.cos()) - t.sin()]),
                0.0,
                0.2,
                &mut y,
                &mut |_, _| {},
            )
            .unwrap();
        assert!((y[0] - 0.2f64.cos()).abs() < 1e-3, "{}", y[0]);
    }
}
