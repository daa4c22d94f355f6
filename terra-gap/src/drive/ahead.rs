//! The logged speed a little later than a window: between the means of the windows around.
//!
//! # Equation
//! u(t) is the cubic through the mean speeds of four windows, the one before, its own and the two that follow, and goes on
//! straight behind the last; what is gained is u(o + e) + c u'(o + e) - u(o), and u'(e) + c u''(e) - u'(0) in slope, for an offset
//! o, a delay e and a filter's time constant c. A window's own slope is no part of it: that is what the body's equation is held
//! against, and its noise would pass for a delay.

use terra_model::Scalar;

use super::{AROUND, SPEED};

/// How late a sensor is \[s\].
#[derive(Clone, Copy, Debug)]
pub(super) struct Behind<T> {
    /// It says what was so long ago.
    pub(super) delay: T,
    /// It follows with this time constant.
    pub(super) constant: T,
}

/// What the logged speed and its rate lack of the truth, `offset` seconds from the middle of a window. `around`: when the two
/// windows after it, and the one before, have their middles, as seen from its own.
pub(super) fn gained<T: Scalar>(
    raw: &[T],
    around: &[T; 3],
    offset: T,
    behind: Behind<T>,
) -> (T, T) {
    let Behind { delay, constant } = behind;
    let [near, far, before] = *around;
    let own = raw[SPEED];
    // Newton's divided differences over own, near, before, far.
    let first = |k: usize, t: T| (raw[AROUND + k] - own) / t;
    let (to_near, to_far, to_before) = (first(0, near), first(1, far), first(2, before));
    let bend = (to_before - to_near) / (before - near);
    let twist = ((to_far - to_near) / (far - near) - bend) / (far - before);
    let speed = |t: T| t * (to_near + (t - near) * (bend + twist * (t - before)));
    let rate = |t: T| {
        let square = t * 2.0 - near;
        let cube = t * t * 3.0 - t * (near + before) * 2.0 + near * before;
        to_near + bend * square + twist * cube
    };
    let curve = |t: T| bend * 2.0 + twist * (t * 6.0 - (near + before) * 2.0);
    let speed_at = |t: T| {
        let straight = speed(far) + rate(far) * (t - far);
        t.select_lt(far, speed(t), straight)
    };
    let rate_at = |t: T| t.select_lt(far, rate(t), rate(far));
    let curve_at = |t: T| t.select_lt(far, curve(t), T::zero());
    let then = offset + delay;
    (
        speed_at(then) - speed_at(offset) + constant * rate_at(then),
        rate_at(delay) - rate(T::zero()) + constant * curve_at(delay),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::RAW;

    /// A cubic is its own interpolant, up to the middle of the last window, and goes on straight.
    #[test]
    fn a_cubic_is_found_again() {
        let u = |t: f64| 1.0 + 0.5 * t - 2.0 * t * t + 3.0 * t * t * t;
        let slope = |t: f64| 0.5 - 4.0 * t + 9.0 * t * t;
        let curve = |t: f64| -4.0 + 18.0 * t;
        let late = |delay, constant| Behind { delay, constant };
        let around = [0.2, 0.45, -0.15];
        let mut raw = [0.0; RAW];
        raw[SPEED] = u(0.0);
        for (k, t) in around.into_iter().enumerate() {
            raw[AROUND + k] = u(t);
        }
        for (offset, delay) in [
            (0.0, 0.1),
            (-0.05, 0.15),
            (0.05, 0.15),
            (0.0, 0.3),
            (0.05, 0.4),
        ] {
            let (speed, rate) = gained(&raw, &around, offset, late(delay, 0.0));
            assert!((speed - (u(offset + delay) - u(offset))).abs() < 1e-13);
            assert!((rate - (slope(delay) - slope(0.0))).abs() < 1e-12);
            // A filter in front of the delay; behind the last window it goes on straight.
            let (speed, rate) = gained(&raw, &around, offset, late(delay, 0.2));
            let then = offset + delay;
            assert!((speed - (u(then) + 0.2 * slope(then) - u(offset))).abs() < 1e-13);
            assert!((rate - (slope(delay) + 0.2 * curve(delay) - slope(0.0))).abs() < 1e-12);
        }
        assert_eq!(gained(&raw, &around, -0.05, late(0.0, 0.0)), (0.0, 0.0));
        let (speed, rate) = gained(&raw, &around, 0.0, late(0.65, 0.0));
        assert!((speed - (u(0.45) + 0.2 * slope(0.45) - u(0.0))).abs() < 1e-13);
        assert!((rate - (slope(0.45) - slope(0.0))).abs() < 1e-12);
    }
}
