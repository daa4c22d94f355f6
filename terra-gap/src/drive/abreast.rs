//! Windows side by side: those whose wheels turn and slip the same way, so that no lane waits for another's braked wheel.

use terra_model::{Lanes, Law, Vector};

use super::{DrivePredictor, Given, RAW, SPEED, VALUES, WHEEL, Window, YAW_RATE};
use crate::abreast::{in_groups, side_by_side};
use crate::dataset::Predictor;
use crate::error::GapError;
use crate::logs::of_log;

/// What windows of one group have in common.
#[derive(Clone, Copy, PartialEq)]
struct Kind {
    log: usize,
    nodes: usize,
    forwards: bool,
    braked: [bool; 4],
}

impl Kind {
    fn of(predictor: &DrivePredictor, window: &Window) -> Self {
        let (track, radius) = (predictor.vehicle.track, predictor.vehicle.wheel_radius);
        let braked = |q: usize| {
            let arm = track * if q.is_multiple_of(2) { -0.5 } else { 0.5 };
            let travel = window.raw[SPEED] + window.raw[YAW_RATE] * arm;
            (window.raw[WHEEL + q] * radius).abs() < travel.abs()
        };
        Kind {
            log: window.log,
            nodes: window.nodes.len(),
            forwards: window.forwards(),
            braked: std::array::from_fn(braked),
        }
    }
}

/// Residuals of windows, in their order.
///
/// # Errors
/// Where the model has no answer for one of them.
pub(super) fn residuals(
    predictor: &DrivePredictor,
    law: &Law,
    p: &[f64],
    indices: &[usize],
) -> Result<Vec<Vec<f64>>, GapError> {
    let in_lanes: Vec<Lanes> = p.iter().map(|&v| Lanes::from(v)).collect();
    in_groups(
        indices,
        |i| Kind::of(predictor, &predictor.windows[i]),
        |windows| together(predictor, law, &in_lanes, windows),
        |i| predictor.residual(law, p, i, &predictor.raw(i)),
    )
}

/// Up to eight windows of one kind at once.
fn together(
    predictor: &DrivePredictor,
    law: &Law,
    p: &[Lanes],
    windows: &[usize],
) -> Result<Vec<Vec<f64>>, GapError> {
    let windows: Vec<&Window> = windows.iter().map(|&i| &predictor.windows[i]).collect();
    let first = windows[0];
    let gather = |of: &dyn Fn(&Window) -> f64| side_by_side(&windows, |w| of(w));
    let given = Given {
        pitch: gather(&|w| w.pitch),
        sin_roll: gather(&|w| w.roll.sin()),
        cos_roll: gather(&|w| w.roll.cos()),
        payload: gather(&|w| w.payload),
        earlier_passes: gather(&|w| w.earlier_passes),
        path: gather(&|w| w.path),
        time: gather(&|w| w.time),
        forwards: first.forwards(),
    };
    let raw: [Lanes; RAW] = std::array::from_fn(|k| gather(&|w| w.raw[k]));
    let p = &*of_log(law, p, predictor.soils, first.log);
    let offsets = (0..first.nodes.len()).map(|k| gather(&|w| w.nodes[k]));
    let predicted = predictor.mean_readings(law, p, &given, &raw, offsets)?;
    let predicted: [[f64; Lanes::WIDTH]; VALUES] = predicted.map(Vector::lanes);
    let residual = |(lane, window): (usize, &&Window)| {
        let each = window.measured.iter();
        each.map(|&k| window.raw[k] - predicted[k][lane]).collect()
    };
    Ok(windows.iter().enumerate().map(residual).collect())
}
