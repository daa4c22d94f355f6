//! A second look at a drive by longer windows, where two readings of a channel in each left it to something unknown.
//!
//! Mean and slope of two readings have all of their noise in both: where a large cause moves inputs far from where they were read,
//! a fit then ends elsewhere. Three readings have room; shorter windows show more of everything else, so they are asked first.

use terra_data::Rover;

use crate::diagnose::Diagnosis;
use crate::drive::DriveWindows;

/// What `again` says of windows with three readings, where `found` by those of `logs`, which hold two, leaves it to something unknown
/// and the other names a cause.
///
/// # Errors
/// What `again` ends with.
pub fn by_roomier_windows<'w, E>(
    found: Diagnosis,
    logs: impl IntoIterator<Item = &'w DriveWindows>,
    rover: &Rover,
    again: impl FnOnce(&Rover) -> Result<Diagnosis, E>,
) -> Result<Diagnosis, E> {
    let needed = logs.into_iter().filter_map(DriveWindows::roomier);
    let Some(window) = needed.reduce(f64::max).filter(|_| unknown_leads(&found)) else {
        return Ok(found);
    };
    let mut wide = rover.clone();
    (wide.gap.window, wide.gap.window_given) = (window, true);
    let mut second = again(&wide)?;
    let names = matches!(second.verdict, "named" | "ambiguous") && !unknown_leads(&second);
    if !names || second.set.iter().any(|answer| answer == "none") {
        return Ok(found);
    }
    second.notice(format!(
        "windows of {window:.1} s: those of {:.1} s hold two readings of a channel each, and no cause explains them ({}); [gap] window_s \
         sets them",
        rover.gap.window, found.verdict
    ));
    Ok(second)
}

/// Something unknown is likelier than any cause.
pub(crate) fn unknown_leads(d: &Diagnosis) -> bool {
    let most = d.causes.iter().map(|c| c.probability).fold(0.0, f64::max);
    d.verdict == "unknown" || d.probability_unknown > most.max(d.probability_none)
}
