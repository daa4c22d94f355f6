//! From what a sensor reports back to the truth, under the effects of a law.

use terra_model::{Channel, Late, Law, Scalar, Touch};

/// What the sensor reports when the truth is `truth` and changes at `rate` per second.
pub(crate) fn report<T: Scalar>(law: &Law, p: &[T], channel: Channel, truth: T, rate: T) -> T {
    reported(law, p, channel, truth, |_| rate)
}

/// The same, where sensors that are late in different ways see different rates.
fn reported<T: Scalar>(
    law: &Law,
    p: &[T],
    channel: Channel,
    truth: T,
    rate: impl Fn(Late) -> T,
) -> T {
    let sensors = law.acting(p, Touch::Sensor);
    sensors.fold(truth, |value, (effect, e)| {
        T::of_effect(&**effect).report_at(e, channel, value, rate(effect.late()))
    })
}

/// How late the sensor is \[s\] near a truth, in one of the ways: the share of its rate that it takes off, in units of its gain.
pub(crate) fn behind<T: Scalar>(law: &Law, p: &[T], channel: Channel, near: T, late: Late) -> T {
    let moving = |l| if l == late { T::one() } else { T::zero() };
    let still = report(law, p, channel, near, T::zero());
    (still - reported(law, p, channel, near, moving)) / gain(law, p, channel, near)
}

/// The truth behind a report: two secant steps, exact for gains and offsets, and to far below noise for droop.
pub(crate) fn truth<T: Scalar>(law: &Law, p: &[T], channel: Channel, reported: T) -> T {
    const STEP: f64 = 1e-3;
    let rate = T::zero();
    let mut x = reported;
    for _ in 0..2 {
        let here = report(law, p, channel, x, rate);
        let slope = (report(law, p, channel, x + STEP, rate) - here) / STEP;
        x -= (here - reported) / slope;
    }
    x
}

/// d report / d truth at a point.
pub(crate) fn gain<T: Scalar>(law: &Law, p: &[T], channel: Channel, at: T) -> T {
    let rate = T::zero();
    report(law, p, channel, at + 1.0, rate) - report(law, p, channel, at, rate)
}
