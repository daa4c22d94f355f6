//! Mock data: what this log would have read if a hypothesis were true.
//!
//! The log's own inputs (slip, load, speeds) are taken as the truth, the values are what the hypothesis predicts for them,
//! and every reading gets its noise. Design, channels and noise are then exactly those of the log that is to be diagnosed, but
//! for observations that have no answer under that hypothesis: these are left out.

use nalgebra::DMatrix;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::dataset::{DataSet, Shift};
use crate::error::GapError;
use crate::hypothesis::Hypothesis;
use crate::noise::NoiseModel;
use crate::predictor::{AnyPredictor, Predictor};

/// Rounds in which values settle that are inputs too (the rate of speed shifts load between the axles).
const ROUNDS: usize = 6;

/// A data set and its predictor under a hypothesis at fit vector `x`. `roughness` is the variance beyond the sensors', by
/// channel.
pub(crate) fn mock(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    x: &[f64],
    roughness: &[f64],
    rng: &mut impl Rng,
) -> (DataSet, AnyPredictor) {
    let p = hypothesis.parameters(x);
    let mut data = data.clone();
    let mut replaced = vec![];
    let mut unanswered = vec![];
    for o in &mut data.observations {
        let positions = predictor.value_positions(o.index);
        let mut raw = predictor.raw(o.index);
        let mut settles = || -> Result<(), GapError> {
            for _ in 0..ROUNDS {
                let left = predictor.residual(&hypothesis.law, &p, o.index, &raw)?;
                for (at, (&k, left)) in positions.iter().zip(&left).enumerate() {
                    raw[k] -= left + o.carried.get(at).copied().unwrap_or(0.0);
                }
            }
            Ok(())
        };
        if settles().is_err() {
            unanswered.push(o.index);
            continue;
        }
        for (value, sd) in raw.iter_mut().zip(&o.raw_sd) {
            let z: f64 = StandardNormal.sample(rng);
            *value += sd * z;
        }
        for (&k, &c) in positions.iter().zip(&o.channels) {
            let z: f64 = StandardNormal.sample(rng);
            raw[k] += roughness.get(c).copied().unwrap_or(0.0).sqrt() * z;
        }
        o.shift = Shift::default();
        o.values = positions.iter().map(|&k| raw[k]).collect();
        replaced.push((o.index, raw));
    }
    data.observations.retain(|o| !unanswered.contains(&o.index));
    (data, predictor.with_raw(&replaced))
}

/// Variance of every channel beyond what the sensors give: the median over observations of what was added to their noise.
///
/// # Errors
/// Where the model has no answer.
pub(crate) fn roughness_of(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    x: &[f64],
    noise: &NoiseModel,
) -> Result<Vec<f64>, GapError> {
    let sensors = NoiseModel::propagate(data, predictor, hypothesis, x)?;
    let diagonal = |blocks: &[DMatrix<f64>]| -> Vec<f64> {
        blocks
            .iter()
            .flat_map(|b| b.diagonal().iter().copied().collect::<Vec<_>>())
            .collect()
    };
    let (all, bare) = (diagonal(&noise.blocks), diagonal(&sensors.blocks));
    let places: Vec<usize> = data.stacked().map(|(_, c)| c).collect();
    Ok((0..data.channels.len())
        .map(|c| {
            let extra = places
                .iter()
                .zip(all.iter().zip(&bare))
                .filter(|(place, _)| **place == c)
                .map(|(_, (all, bare))| (all - bare).max(0.0));
            crate::rig::median(extra)
        })
        .map(|v| if v.is_finite() { v } else { 0.0 })
        .collect())
}
