//! Where the inputs truly were, as well as a fit can tell: errors in variables.
//!
//! Slip is measured with noise, and forces bend with slip. A fit that takes slips as they were read finds a ground that answers
//! slip too weakly, the more so the less slip there is beside its noise, and then effects that make up for it. Here every
//! observation is predicted where its raw quantities most probably were, and what lies between there and what was read
//! enters by its tangent, whose noise is the covariance already.
//!
//! # Equation
//! u = y - S D' C^-1 (g(u) + D (y - u)), r(x) = g(u, x) + D (y - u), with y what was read, S its variances, g the
//! residual, D its derivative at u, C = D S D' and the ground's roughness. Iterated with the fit this is the orthogonal distance
//! regression of the data.
//!
//! # Reference
//! P. T. Boggs, J. E. Rogers, Orthogonal distance regression, Contemporary Mathematics 112, 1990; W. A. Fuller, Measurement
//! Error Models, 1987.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;
use terra_model::{Dual8, jacobian};

use crate::dataset::{DataSet, Predictor};
use crate::error::GapError;
use crate::hypothesis::Hypothesis;
use crate::noise::NoiseModel;

/// How far \[sd\] a raw quantity may be from what was read: beyond, it is the law that is wrong.
const FARTHEST: f64 = 3.0;

/// Moves the inputs of all observations to where they most probably were under a fit, from what was `measured` and where they
/// are `now`, and gives the predictor there; the data take what the tangent adds.
///
/// An observation that has no answer there stays as it was measured.
///
/// # Errors
/// Where the model has no answer at what was measured.
pub(crate) fn recentre<P: Predictor>(
    data: &mut DataSet,
    (measured, now): (&P, &P),
    hypothesis: &Hypothesis,
    x: &[f64],
    noise: &NoiseModel,
) -> Result<P, GapError> {
    let p = hypothesis.parameters(x);
    let p: Vec<Dual8> = p.into_iter().map(Dual8::from).collect();
    let at = |index: usize, raw: &[f64]| {
        let (g, d) = jacobian(raw, |raw| now.residual(&hypothesis.law, &p, index, raw))?;
        Ok::<_, GapError>((DVector::from_vec(g), d))
    };
    let moved: Vec<(Vec<f64>, Vec<f64>)> = data
        .observations
        .par_iter()
        .zip(&noise.blocks)
        .map(|(o, block)| {
            let read = DVector::from_vec(measured.raw(o.index));
            let raw = DVector::from_vec(now.raw(o.index));
            let (g, d) = at(o.index, raw.as_slice())?;
            let left = g + &d * (&read - &raw);
            let sd = DVector::from_column_slice(&o.raw_sd);
            let step = step(&d, &sd, block, &left);
            let there = step.map(|step| &read - step).and_then(|raw| {
                let (_, d) = at(o.index, raw.as_slice()).ok()?;
                let shift = d * (&read - &raw);
                shift.iter().all(|s| s.is_finite()).then_some((raw, shift))
            });
            Ok(match there {
                Some((raw, shift)) => (raw.as_slice().to_vec(), shift.as_slice().to_vec()),
                None => (read.as_slice().to_vec(), vec![]),
            })
        })
        .collect::<Result<_, GapError>>()?;
    let mut replaced = vec![];
    for (o, (raw, shift)) in data.observations.iter_mut().zip(moved) {
        o.shift = shift;
        replaced.push((o.index, raw));
    }
    Ok(now.with_raw(&replaced))
}

/// S D' C^-1 r, no component beyond [`FARTHEST`].
fn step(
    d: &DMatrix<f64>,
    sd: &DVector<f64>,
    block: &DMatrix<f64>,
    left: &DVector<f64>,
) -> Option<DVector<f64>> {
    let pull = Cholesky::new(block.clone())?.solve(left);
    let step = d.tr_mul(&pull).component_mul(&sd.map(|sd| sd * sd));
    let farthest = step
        .iter()
        .zip(sd)
        .filter(|(_, sd)| **sd > 0.0)
        .map(|(step, sd)| (step / sd).abs())
        .fold(0.0, f64::max);
    Some(step * (FARTHEST / farthest.max(FARTHEST)))
}
