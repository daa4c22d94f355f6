//! Single-wheel test benches.

use super::frame::Frame;
use super::{Cell, ImportedLog};
use crate::error::DataError;

const MILLI: f64 = 1e-3;

/// Soil-bin trials of C. Pavlov and A. Johnson, Carnegie Mellon University (github.com/robomechanics/3d-terramechanics).
///
/// A trial is what was repeated: the rows of one commanded rim speed. The scatter inside a row's 5 s average is no error
/// of the mean, so it is not carried over as the row's sd; repeatability belongs in `[noise]`.
pub(crate) fn cmu(frame: &Frame) -> Result<ImportedLog, DataError> {
    let (condition, commanded) = (frame.texts("wheel")?, frame.texts("rim_speed_cmd_mm_s")?);
    let numbers = [
        ("slip", frame.numbers("slip_longitudinal", 1.0)?),
        ("normal_load_N", frame.numbers("Fz_load_N", 1.0)?),
        ("drawbar_pull_N", frame.numbers("Fx_tractive_N", 1.0)?),
        ("sinkage_m", frame.numbers("sinkage_mm", MILLI)?),
        ("side_force_N", frame.numbers("Fy_side_N", 1.0)?),
        (
            "slip_angle_rad",
            frame.numbers("slip_angle_deg", std::f64::consts::PI / 180.0)?,
        ),
        (
            "travel_speed_m_s",
            frame.numbers("travel_speed_mm_s", MILLI)?,
        ),
        ("rim_speed_m_s", frame.numbers("rim_speed_mm_s", MILLI)?),
    ];
    let mut log = rig(frame, &commanded, &condition, &numbers);
    log.notes.push(
        "trial = commanded rim speed in mm/s; the scatter inside a row (Fx_sd_N ...) is left out: give the repeatability in [noise] (0.40 N, 0.00062 m, 0.78 N)"
            .to_owned(),
    );
    Ok(log)
}

/// Points read off the figures of L. Ding et al., J. Terramechanics 48(1):27-45, 2011.
pub(crate) fn published(frame: &Frame) -> Result<ImportedLog, DataError> {
    let trial = frame.texts("case_id")?;
    let lugs = frame.numbers("grouser_height_m", 1.0)?;
    let condition: Vec<String> = lugs
        .iter()
        .map(|h| {
            if h.unwrap_or(0.0) > 0.0 {
                "grousered"
            } else {
                "smooth"
            }
            .to_owned()
        })
        .collect();
    let numbers = [
        ("slip", frame.numbers("slip", 1.0)?),
        ("normal_load_N", frame.numbers("vertical_load_n", 1.0)?),
        ("drawbar_pull_N", frame.numbers("meas_drawbar_pull_n", 1.0)?),
        ("torque_N_m", frame.numbers("meas_torque_nm", 1.0)?),
        ("sinkage_m", frame.numbers("meas_sinkage_m", 1.0)?),
    ];
    let mut log = rig(frame, &trial, &condition, &numbers);
    log.notes.push(
        "read off figures: expect 1 N, 0.2 N m and 0.0005 m in [noise]; wheel radius and width are in the source, per row"
            .to_owned(),
    );
    Ok(log)
}

fn rig(
    frame: &Frame,
    trial: &[String],
    condition: &[String],
    numbers: &[(&'static str, Vec<Option<f64>>)],
) -> ImportedLog {
    let mut header = vec!["trial".to_owned(), "condition".to_owned()];
    header.extend(numbers.iter().map(|(name, _)| (*name).to_owned()));
    let rows = (0..frame.rows)
        .map(|row| {
            let text = |column: &[String]| Cell::Text(column.get(row).cloned().unwrap_or_default());
            let mut cells = vec![text(trial), text(condition)];
            cells.extend(
                numbers
                    .iter()
                    .map(|(_, v)| Cell::Number(v.get(row).copied().flatten())),
            );
            cells
        })
        .collect();
    ImportedLog {
        header,
        rows,
        notes: vec![],
    }
}
