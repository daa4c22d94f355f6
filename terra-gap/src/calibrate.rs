//! A calibration for the log at hand: the same pipeline on mock data of the same design, with known causes.

use std::sync::Arc;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use nalgebra::DVector;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use crate::calibration::{Calibration, Case};
use crate::candidates::Candidates;
use crate::cause::Answers;
use crate::dataset::DataSet;
use crate::error::GapError;
use crate::evidence::posterior;
use crate::hypothesis::Hypothesis;
use crate::mock::{mock, roughness_of};
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::rivals::{Rivals, weigh_rivals};
use crate::settings::Settings;
use crate::setup::Setup;

/// Share of mock cases without any effect.
const NULLS: f64 = 0.4;
/// Magnitudes of mock effects in prior sd.
const MAGNITUDES: std::ops::Range<f64> = 0.3..2.0;

/// The frozen calibration of this kind of log, or with `settings.calibrate` one made from that many mock cases, the more
/// cautious of the two in each respect. Predictors at what was measured and at where the inputs most probably were.
///
/// # Errors
/// Where the nominal model has no answer at its own fit.
pub(crate) fn calibrate(
    data: &DataSet,
    (measured, predictor): (&dyn Predictor, &dyn Predictor),
    setup: &Setup<'_>,
    settings: &Settings,
    candidates: &Candidates,
    rivals: &Rivals,
) -> Result<Calibration, GapError> {
    let (kind, groups) = (setup.kind, data.groups().len());
    let frozen = match setup.inherited {
        Some(_) => Calibration::frozen_contrast(kind, groups)?,
        None => Calibration::frozen(kind, groups)?,
    };
    if settings.calibrate == 0 {
        return Ok(frozen);
    }
    let x = rivals.fitted.x.as_slice();
    let roughness = roughness_of(data, predictor, &rivals.null, x, &rivals.noise)?;
    let cases: Vec<Case> = for_each(settings.calibrate, |run| {
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        rng.set_stream(run as u64);
        let (truth, h, x) = draw(rivals, candidates, run, settings.calibrate, &mut rng)?;
        let (mut data, predictor) =
            mock(data, measured, &h, x.as_slice(), &roughness, &mut rng).ok()?;
        let found = weigh_rivals(&mut data, &*predictor, setup, settings, candidates);
        let answers = Answers::new(&found.ok()?.ok()?.0, settings, setup);
        Some(answers.evidence().case(&truth))
    })
    .into_iter()
    .flatten()
    .collect();
    let source = format!(
        "{} of {} mock cases of this log's own design, seed {}",
        cases.len(),
        settings.calibrate,
        settings.seed
    );
    let own = Calibration::learn(&cases, &frozen, source);
    Ok(Calibration {
        temperature: own.temperature.max(frozen.temperature),
        floor: own.floor.max(frozen.floor),
        set_ratio: own.set_ratio.min(frozen.set_ratio),
        none_gain: own.none_gain.min(frozen.none_gain),
        null_gain: own.null_gain.max(frozen.null_gain),
        second_gain: own.second_gain.max(frozen.second_gain),
        ..own
    })
}

/// A cause and a soil: nulls first, then every candidate in turn; soil from the posterior of the nominal fit.
fn draw(
    rivals: &Rivals,
    candidates: &Candidates,
    run: usize,
    runs: usize,
    rng: &mut impl Rng,
) -> Option<(String, Hypothesis, DVector<f64>)> {
    let post = posterior(&rivals.null, &rivals.fitted);
    let root = post.covariance.cholesky()?;
    let z = DVector::from_fn(rivals.null.len(), |_, _| StandardNormal.sample(rng));
    let mut x = &rivals.fitted.x + root.l_dirty().lower_triangle() * z;
    let nulls = (runs as f64 * NULLS).ceil() as usize;
    if run < nulls || candidates.effects.is_empty() {
        return Some(("none".to_owned(), rivals.null.clone(), x));
    }
    let effect = &candidates.effects[(run - nulls) % candidates.effects.len()];
    let h = rivals.null.with(Arc::clone(effect)).ok()?;
    let param = effect.params().first()?;
    let mut s: f64 = rng.random_range(MAGNITUDES);
    if !param.one_sided() && rng.random::<bool>() {
        s = -s;
    }
    let end = x.len();
    x = x.insert_row(end, s.min(param.max / param.prior_sd));
    Some((effect.name().to_owned(), h, x))
}
