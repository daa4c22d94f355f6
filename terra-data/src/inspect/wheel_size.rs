//! The rover file's wheel: sizes that no wheel has.

use super::Suspicion;
use crate::rover::Rover;

/// Radius beyond which no wheel is known: the largest tyres of mining trucks have 2 m \[m\].
const LARGEST: f64 = 3.0;
/// Width over radius beyond which it is no wheel: a compaction drum has about 3.
const WIDEST: f64 = 6.0;

/// A radius or a width in another unit.
pub(super) fn wheel_size(rover: &Rover) -> Option<Suspicion> {
    let wheel = &rover.wheel;
    if wheel.radius > LARGEST {
        return Some(Suspicion {
            code: "radius-unit",
            message: format!(
                "[wheel] radius_m = {}: a wheel {} m high? Millimetres or centimetres are not converted",
                wheel.radius,
                2.0 * wheel.radius
            ),
        });
    }
    (wheel.width > WIDEST * wheel.radius).then(|| Suspicion {
        code: "width-unit",
        message: format!(
            "[wheel] width_m = {} is {:.0} times its radius: millimetres or centimetres are not converted",
            wheel.width,
            wheel.width / wheel.radius
        ),
    })
}
