//! What a rig is asked to do, point by point.

use terra_data::WheelData;
use terra_model::{Contact, ModelError};

use crate::error::SimError;
use crate::scenario::Trial;

/// One slip of a programme.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    /// Library slip \[1\].
    pub(crate) slip: f64,
    /// W \[N\].
    pub(crate) load: f64,
    /// Since the ramp began \[s\]; none in a steady trial.
    pub(crate) time: Option<f64>,
    /// Rows.
    pub(crate) repeats: u32,
    /// A trial begins here.
    pub(crate) begins: bool,
}

/// Steady trials: slip x load, repeated where they stand. Ramps: all slips one after the other, for each load and repeat.
pub(crate) fn points(trial: &Trial) -> Vec<Point> {
    let (slips, loads) = (&trial.slip, &trial.normal_load);
    let Some(duration) = trial.ramp else {
        let each = |slip: f64| {
            loads.iter().map(move |&load| Point {
                slip,
                load,
                time: None,
                repeats: trial.repeats,
                begins: true,
            })
        };
        return slips.iter().flat_map(|&slip| each(slip)).collect();
    };
    let between = duration / (slips.len().saturating_sub(1).max(1)) as f64;
    let runs = loads
        .iter()
        .flat_map(|&load| std::iter::repeat_n(load, trial.repeats as usize));
    runs.flat_map(|load| {
        slips.iter().enumerate().map(move |(k, &slip)| Point {
            slip,
            load,
            time: Some(k as f64 * between),
            repeats: 1,
            begins: k == 0,
        })
    })
    .collect()
}

/// The contact of a trial. Driving R ω = v/(1 - s), braking R ω = v (1 + s).
pub(crate) fn contact(
    trial: &Trial,
    wheel: &WheelData,
    slip: f64,
    load: f64,
) -> Result<Contact<f64>, SimError> {
    if !(-1.0..=1.0).contains(&slip) {
        return Err(SimError::Model(ModelError::Contact {
            quantity: "slip",
            value: slip,
            expected: "a library slip in [-1, 1]",
        }));
    }
    let mut at = Contact::new(slip, load, wheel.radius, wheel.width);
    if slip < 1.0 {
        let v = trial.travel_speed;
        at.speed = v;
        at.wheel_speed = if slip < 0.0 {
            v * (1.0 + slip)
        } else {
            v / (1.0 - slip)
        } / wheel.radius;
    }
    at.earlier_passes = f64::from(trial.pass.max(1) - 1);
    Ok(at)
}
