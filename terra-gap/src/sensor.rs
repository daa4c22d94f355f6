//! From what a sensor reports back to the truth, under the effects of a law.

use terra_model::{Channel, Law, Scalar, Touch};

/// What the sensor reports when the truth is `truth` and changes at `rate` per second.
pub(crate) fn report<T: Scalar>(law: &Law, p: &[T], channel: Channel, truth: T, rate: T) -> T {
    let sensors = law.acting(p, Touch::Sensor);
    sensors.fold(truth, |value, (effect, e)| {
        T::of_effect(&**effect).report_at(e, channel, value, rate)
    })
}

/// How late the sensor is \[s\] near a truth: the share of its rate that it takes off, in units of its gain.
pub(crate) fn delay<T: Scalar>(law: &Law, p: &[T], channel: Channel, near: T) -> T {
    let (still, moving) = (T::zero(), T::one());
    let behind = report(law, p, channel, near, still) - report(law, p, channel, near, moving);
    behind / gain(law, p, channel, near)
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
