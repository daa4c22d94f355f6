//! A calibration for the log at hand: the same pipeline on mock data of the same design, with known causes.

use std::sync::Arc;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use nalgebra::DVector;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use crate::calibration::{Calibration, Case, HIGHEST_TEMPERATURE};
use crate::candidates::Candidates;
use crate::cause::Answers;
use crate::dataset::{DataSet, Observation};
use crate::error::GapError;
use crate::evidence::posterior;
use crate::fit::residual;
use crate::hypothesis::Hypothesis;
use crate::mock::{mock, roughness_of};
use crate::noise::NoiseModel;
use crate::null::drop_unanswered;
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::rivals::{Rivals, weigh_rivals};
use crate::settings::{LogKind, Settings};
use crate::setup::Setup;
use crate::weigh::Weighed;

/// Share of mock cases without any effect.
const NULLS: f64 = 0.4;
/// Magnitudes of mock effects in prior sd.
const MAGNITUDES: std::ops::Range<f64> = 0.3..2.0;
/// Share of the cases asked for that must come about for anything to be learned from them.
const ENOUGH: f64 = 0.5;
/// Standard errors by which the misfit of an observation of a mock at its own truth may lie above the noise: beyond, noise does not go
/// through the law's slopes as a fit has it (near a standstill slips are anything).
const ALIKE: f64 = 6.0;
/// Share of a mock's observations that must be left for it to be like the log.
const LEFT: f64 = 0.8;

/// The frozen calibration of this kind of log, or with `settings.calibrate` one made from that many mock cases, the more
/// cautious of the two in each respect; with what to heed where too few of them came about. By the predictor at where the inputs
/// most probably were: what was read is noise already.
///
/// # Errors
/// Where the nominal model has no answer at its own fit.
pub(crate) fn calibrate(
    data: &DataSet,
    predictor: &dyn Predictor,
    setup: &Setup<'_>,
    settings: &Settings,
    candidates: &Candidates,
    rivals: &Rivals,
) -> Result<(Calibration, Option<String>), GapError> {
    let (kind, groups) = (setup.kind, data.groups().len());
    let frozen = match setup.inherited {
        Some(_) => Calibration::frozen_contrast(kind, groups)?,
        None => Calibration::frozen(kind, groups)?,
    };
    if settings.calibrate == 0 {
        return Ok((frozen, None));
    }
    let x = rivals.fitted.x.as_slice();
    let roughness: Vec<f64> = match setup.kind {
        // The noise may have been taken at another explanation, whose slopes are not those at this soil.
        LogKind::Drive => {
            let channels = 0..data.channels.len();
            channels.map(|c| rivals.noise.of_ground(c)).collect()
        }
        LogKind::Rig | LogKind::Kinematic => {
            roughness_of(data, predictor, &rivals.null, x, &rivals.noise)?
        }
    };
    let cases: Vec<Case> = for_each(settings.calibrate, |run| {
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        rng.set_stream(run as u64);
        let (truth, h, x) = draw(rivals, candidates, run, settings.calibrate, &mut rng)?;
        let x = x.as_slice();
        let (mut data, predictor) = mock(data, predictor, &h, x, &roughness, &mut rng);
        if !is_alike(&mut data, &*predictor, &h, x, &roughness) {
            return None;
        }
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
    if (cases.len() as f64) < ENOUGH * settings.calibrate as f64 {
        let heed = format!(
            "not calibrated on this log's own design: only {} of {} mock cases came about, as parts of it (near a standstill, or soil about to give way) have no answer or none that noise leaves in place; the calibration is the one that ships",
            cases.len(),
            settings.calibrate
        );
        return Ok((frozen, Some(heed)));
    }
    let own = Calibration::learn(&cases, &frozen, source);
    if own.temperature >= HIGHEST_TEMPERATURE {
        let heed = "not calibrated on this log's own design: in its mock cases other answers say far more than the truth does; the calibration is the one that ships";
        return Ok((frozen, Some(heed.to_owned())));
    }
    let own = Calibration {
        temperature: own.temperature.max(frozen.temperature),
        floor: own.floor.max(frozen.floor),
        set_ratio: own.set_ratio.min(frozen.set_ratio),
        none_gain: own.none_gain.min(frozen.none_gain),
        null_gain: own.null_gain.max(frozen.null_gain),
        second_gain: own.second_gain.max(frozen.second_gain),
        ..own
    };
    Ok((own, None))
}

/// Leaves out what of a mock has no answer at its own truth, or lies elsewhere than its noise says; false where little is left.
fn is_alike(
    data: &mut DataSet,
    predictor: &dyn Predictor,
    truth: &Hypothesis,
    x: &[f64],
    roughness: &[f64],
) -> bool {
    let before = data.observations.len();
    drop_unanswered(data, predictor, truth, x);
    let lies = |data: &DataSet| {
        let mut noise = NoiseModel::propagate(data, predictor, truth, x)?;
        noise.add_channel_variances(data, roughness);
        let raw = residual(data, predictor, truth, x)?;
        let whitened = noise.whitener(data)?.apply_vector(&raw);
        let mut next = whitened.iter();
        let mut one = |o: &Observation| {
            let n = o.values.len() as f64;
            let chi2: f64 = next.by_ref().take(o.values.len()).map(|r| r * r).sum();
            chi2 <= n + ALIKE * (2.0 * n).sqrt()
        };
        Ok::<_, GapError>(data.observations.iter().map(&mut one).collect::<Vec<_>>())
    };
    let Ok(keep) = lies(data) else {
        return false;
    };
    let mut keep = keep.into_iter();
    data.observations.retain(|_| keep.next().unwrap_or(true));
    data.dropped.clear();
    data.observations.len() as f64 >= LEFT * before as f64
}

/// A cause and a soil: nulls first, then every candidate in turn; soil from the posterior of the best explanation, as that of the
/// nominal law stands for what is missing.
fn draw(
    rivals: &Rivals,
    candidates: &Candidates,
    run: usize,
    runs: usize,
    rng: &mut impl Rng,
) -> Option<(String, Hypothesis, DVector<f64>)> {
    let soil = rivals.null.len();
    // Other soil, and other models, have parameters of their own.
    let nominal = |w: &&Weighed| w.fitted && Arc::ptr_eq(&w.hypothesis.soil, &rivals.null.soil);
    let best = rivals.all().filter(nominal);
    let best = best.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence));
    let best = best.unwrap_or(&rivals.null_weighed);
    let post = posterior(&best.hypothesis, &best.plain);
    let of_soil = post.covariance.view((0, 0), (soil, soil)).into_owned();
    let root = of_soil.cholesky()?;
    let z = DVector::from_fn(soil, |_, _| StandardNormal.sample(rng));
    let mut x = best.plain.x.rows(0, soil) + root.l_dirty().lower_triangle() * z;
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
