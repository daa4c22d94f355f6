//! What a map covers, how wrong it is, and what it answers.

use crate::error::ModelError;

/// Slips and loads of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapRange {
    /// Least and largest slip, within \[0, 1\].
    pub slip: (f64, f64),
    /// Least and largest normal load \[N\].
    pub normal_load: (f64, f64),
}

/// What a map was found to be wrong by, e = max(|ΔT|/|T|, |ΔD|/(|D| + |T|/R)), at points between its nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapError {
    /// Largest.
    pub max: f64,
    /// Median.
    pub median: f64,
}

/// Pull and torque with their slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapSlopes {
    /// D \[N\], T \[N m\].
    pub forces: [f64; 2],
    /// The same by slip.
    pub by_slip: [f64; 2],
    /// The same by normal load.
    pub by_load: [f64; 2],
}

impl MapError {
    /// Of a map against pull and torque at some slips and loads.
    pub(super) fn between(
        at: &[(f64, f64)],
        truth: &[[f64; 2]],
        radius: f64,
        map: impl Fn(f64, f64) -> Result<[f64; 2], ModelError>,
    ) -> Result<Self, ModelError> {
        let mut errors = Vec::with_capacity(at.len());
        for (&(slip, load), [pull, torque]) in at.iter().zip(truth) {
            let [d, t] = map(slip, load)?;
            let scale = pull.abs() + torque.abs() / radius;
            let error = ((d - pull) / scale)
                .abs()
                .max(((t - torque) / torque).abs());
            errors.push(if error.is_finite() {
                error
            } else {
                f64::INFINITY
            });
        }
        errors.sort_by(f64::total_cmp);
        Ok(MapError {
            max: errors.last().copied().unwrap_or(f64::INFINITY),
            median: errors
                .get(errors.len() / 2)
                .copied()
                .unwrap_or(f64::INFINITY),
        })
    }
}

impl MapRange {
    pub(super) fn check(&self) -> Result<(), ModelError> {
        let (low, high) = self.slip;
        if !(low >= 0.0 && low < high && high <= 1.0) {
            return Err(outside("slip", low, 0.0, 1.0));
        }
        let (low, high) = self.normal_load;
        if !(low > 0.0 && low < high && high.is_finite()) {
            return Err(outside("normal_load", low, 0.0, f64::MAX));
        }
        Ok(())
    }
    pub(super) fn slip_at(&self, scaled: f64) -> f64 {
        let (low, high) = self.slip;
        (low + 0.5 * (scaled + 1.0) * (high - low)).clamp(low, high)
    }
    pub(super) fn scaled_slip(&self, slip: f64) -> f64 {
        let (low, high) = self.slip;
        2.0 * (slip - low) / (high - low) - 1.0
    }
}

pub(super) fn outside(quantity: &'static str, value: f64, low: f64, high: f64) -> ModelError {
    ModelError::OutsideMap {
        quantity,
        value,
        low,
        high,
    }
}
