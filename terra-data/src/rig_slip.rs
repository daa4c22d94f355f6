//! Slip of a testbed's row: from its speeds, or as logged in another convention.
//!
//! Testbeds creep at 10 mm/s by design, so the standstill rule of vehicles (slip against .05 m/s) is not applied here:
//! only a wheel that does not move at all has no slip.

use terra_model::{SlipConvention, library_slip};

use crate::rig::Measured;

/// Library slip from rim speed R w and travel speed v, both \[m/s\], or why there is none.
pub(crate) fn rig_slip(rim: f64, travel: f64) -> Result<f64, String> {
    if rim == 0.0 && travel == 0.0 {
        return Err("the wheel stands still: no slip".to_owned());
    }
    if rim * travel < 0.0 {
        return Err(format!(
            "the wheel turns against its motion (rim speed {rim} m/s, travel speed {travel} m/s)"
        ));
    }
    Ok(library_slip(rim, travel))
}

/// Slip as logged, and its 1-sigma, in the library's convention.
///
/// # Equation
/// sd(i) = |di/dx| sd(x), with x the logged slip: di/dx is .01 for percent; (1 - i)^2 for x = (R w - v)/v > 0; and
/// (1 + i)^2 for x = 1 - v/(R w) < 0.
pub(crate) fn in_library_convention(
    logged: Measured,
    convention: SlipConvention,
    sd_convention: SlipConvention,
) -> Result<Measured, String> {
    let value = convention.to_library(logged.value).map_err(|_| {
        let x = logged.value;
        format!(
            "slip {x}: the wheel turns against its motion, or the slip is in another convention"
        )
    })?;
    let slope = match sd_convention {
        SlipConvention::Library => 1.0,
        SlipConvention::Percent => 0.01,
        SlipConvention::Unbounded | SlipConvention::Braking if value > 0.0 => (1.0 - value).powi(2),
        SlipConvention::Driving if value < 0.0 => (1.0 + value).powi(2),
        SlipConvention::Unbounded | SlipConvention::Braking | SlipConvention::Driving => 1.0,
    };
    let sd = logged.sd.map(|sd| sd * slope);
    Ok(Measured { value, sd })
}
