//! The evidence of one rival: fitted at every amplitude of a small discrepancy of the model's form, then averaged.
//!
//! On a rig every wheel law is wrong by some percent of the load, so a discrepancy of bounded amplitude stands inside
//! every hypothesis, none included: amplitudes .003 .01 .03 .1 of the channel's scale with weights .4 .3 .2 .1.

use std::sync::Arc;

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::evidence::{Posterior, log_sum_exp, posterior};
use crate::fit::{Effort, Fit, Known, evaluate, fit_from, residual};
use crate::hypothesis::Hypothesis;
use crate::noise::{NoiseModel, Whitener};
use crate::predictor::Predictor;
use crate::renewal::hopeless_from;
use crate::settings::LogKind;
use crate::thin::Thin;

/// Misfit per value up to which a start is near the data.
pub(crate) const NEAR: f64 = 1.3;
/// Misfit per value, and share of the nominal law's, from which a way that was given up is not gone on with.
const FAR_AWAY: (f64, f64) = (3.0, 0.5);
/// Amplitudes of the discrepancy with their prior weights.
pub(crate) fn amplitudes(kind: LogKind) -> &'static [(f64, f64)] {
    match kind {
        LogKind::Rig => &[(0.003, 0.4), (0.01, 0.3), (0.03, 0.2), (0.1, 0.1)],
        LogKind::Drive | LogKind::Kinematic => &[(0.0, 1.0)],
    }
}

/// Amplitude up to which a discrepancy is a wheel law's usual error beside noise; beyond it, something is missing.
const USUAL: f64 = 0.01;

/// Amplitudes that only the answer "unknown" may use.
pub(crate) fn unknown_amplitudes(kind: LogKind) -> &'static [f64] {
    match kind {
        LogKind::Rig => &[0.2, 0.5, 1.0],
        LogKind::Drive | LogKind::Kinematic => &[0.01, 0.03, 0.1, 0.3],
    }
}

/// Whiteners of one noise model at every amplitude.
#[derive(Clone)]
pub(crate) struct Amplitudes {
    /// Amplitude, ln weight, whitener.
    levels: Arc<Vec<(f64, f64, Whitener)>>,
    /// Noise without any discrepancy.
    plain: Arc<Whitener>,
    /// Where a drive is looked around on, and its fits from far begin.
    pub(crate) thin: Option<Arc<Thin>>,
    /// Misfit per value from which a drive's rival is hopeless.
    hopeless_from: f64,
    /// The same of a way that was given up.
    far_away: f64,
}

impl Amplitudes {
    /// Builds them.
    ///
    /// # Errors
    /// A covariance that is not positive definite.
    pub(crate) fn new(noise: &NoiseModel, data: &DataSet, kind: LogKind) -> Result<Self, GapError> {
        let levels = amplitudes(kind)
            .iter()
            .map(|&(a, w)| Ok((a, f64::ln(w), noise.whitener_with_discrepancy(data, a)?)))
            .collect::<Result<_, GapError>>()?;
        let thin = match kind {
            LogKind::Drive => Some(Arc::new(Thin::new(data, noise)?)),
            LogKind::Rig | LogKind::Kinematic => None,
        };
        Ok(Amplitudes {
            levels: Arc::new(levels),
            plain: Arc::new(noise.whitener(data)?),
            thin,
            hopeless_from: f64::INFINITY,
            far_away: f64::INFINITY,
        })
    }

    /// The same beside the nominal law, as it was weighed.
    pub(crate) fn beside(&self, null: &Weighed) -> Self {
        let (least, share) = FAR_AWAY;
        Amplitudes {
            far_away: least.max(share * null.chi2_per_value()),
            ..self.clone()
        }
    }

    /// The same for rivals of an explanation of a drive: ways that end hopelessly far behind it are only gone on few windows.
    pub(crate) fn against(&self, known: Option<&Weighed>) -> Self {
        let mut out = self.clone();
        if let Some(known) = known.filter(|_| self.thin.is_some()) {
            out.hopeless_from = out.hopeless_from.min(hopeless_from(&known.plain));
        }
        out
    }
}

/// A rival with its evidence.
#[derive(Clone, Debug)]
pub struct Weighed {
    /// The rival.
    pub hypothesis: Hypothesis,
    /// Its fit at the most probable amplitude.
    pub fit: Fit,
    /// Its posterior there.
    pub posterior: Posterior,
    /// That amplitude.
    pub amplitude: f64,
    /// Share of the evidence at amplitudes of a wheel law's usual error.
    pub usual: f64,
    /// ln Z over all amplitudes, up to a constant shared by all rivals.
    pub log_evidence: f64,
    /// Its fit against the noise alone: what its parameters and its adequacy are read from.
    pub plain: Fit,
    /// ln Z of that fit.
    pub plain_log_evidence: f64,
    /// False where the law was not fitted, but its tangent at the fit of one effect less taken for it.
    pub fitted: bool,
}

impl Weighed {
    /// Whitened misfit per value against the noise alone.
    pub fn chi2_per_value(&self) -> f64 {
        self.plain.chi2() / self.plain.residual.len().max(1) as f64
    }
}

/// How long the fits of a contest go on: on a rig they are cheap.
pub(crate) fn contest(kind: LogKind) -> Effort {
    match kind {
        LogKind::Rig | LogKind::Kinematic => Effort::Certified,
        LogKind::Drive => Effort::Contest,
    }
}

/// The same for fits that go on where they ended under another noise.
pub(crate) fn again(kind: LogKind) -> Effort {
    match kind {
        LogKind::Rig | LogKind::Kinematic => Effort::Certified,
        LogKind::Drive => Effort::Again,
    }
}

/// Weighs a rival of a drive where it stands, without a fit.
///
/// # Errors
/// When it has no answer there.
pub(crate) fn weigh_at(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    amplitudes: &Amplitudes,
    before: &Fit,
) -> Result<Weighed, GapError> {
    let whitener = &amplitudes.plain;
    let here = evaluate(
        data,
        predictor,
        hypothesis,
        before.x.as_slice(),
        &before.near,
    )?;
    let residual = whitener.apply_vector(&here.residual);
    let fit = Fit {
        cost: residual.norm_squared() + before.x.norm_squared(),
        residual,
        jacobian: whitener.apply(&here.jacobian).into(),
        exact: true,
        tangent: false,
        converged: false,
        given_up: true,
        log_det: whitener.log_det,
        x: before.x.clone(),
        at_bound: before.at_bound.clone(),
        near: before.near.clone(),
    };
    let posterior = posterior(hypothesis, &fit);
    Ok(Weighed {
        hypothesis: hypothesis.clone(),
        amplitude: 0.0,
        usual: 1.0,
        log_evidence: posterior.log_evidence,
        plain_log_evidence: posterior.log_evidence,
        posterior,
        plain: fit.clone(),
        fit,
        fitted: true,
    })
}

/// Weighs a rival of a drive where the way on few windows ends, enough to know where it leads: the cost there, and the rival
/// unless some other window has no answer at that place. None where there is no way.
pub(crate) fn weigh_roughly(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    amplitudes: &Amplitudes,
    start: &[f64],
    known: Option<&Known>,
) -> Option<(f64, Option<Weighed>)> {
    let few = amplitudes.thin.as_ref()?;
    let known = known.and_then(|known| few.part_of(known));
    let end = few.end(predictor, hypothesis, &[start.to_vec()], known);
    let end = end.ok()?;
    let there = weigh_at(data, predictor, hypothesis, amplitudes, &end);
    Some((end.cost, there.ok()))
}

/// Whether the first start is near the data already.
fn is_near(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    amplitudes: &Amplitudes,
    starts: &[Vec<f64>],
    known: Option<&Known>,
) -> bool {
    let chi2 = match known.and_then(|k| k.residual.as_ref()) {
        Some(known) => Some(known.norm_squared()),
        None => {
            let first = starts.first();
            let r = first.and_then(|x| residual(data, predictor, hypothesis, x).ok());
            r.map(|r| amplitudes.plain.apply_vector(&r).norm_squared())
        }
    };
    chi2.is_some_and(|chi2| chi2 < NEAR * data.len() as f64)
}

/// Fits and weighs a rival from the given starts; what is `known` is so at the first, whitened by the noise alone.
///
/// # Errors
/// When the rival has no answer at any start.
pub(crate) fn weigh(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    amplitudes: &Amplitudes,
    starts: &[Vec<f64>],
    known: Option<Known>,
    effort: Effort,
) -> Result<Weighed, GapError> {
    let mut best: Option<(f64, f64, Fit, Posterior)> = None;
    let (mut terms, mut usual) = (vec![], vec![]);
    let mut known = known;
    let (mut from, mut effort) = (starts.to_vec(), effort);
    if let (Effort::Contest, Some(thin)) = (effort, &amplitudes.thin)
        && !thin.is_all()
        && !is_near(
            data,
            predictor,
            hypothesis,
            amplitudes,
            starts,
            known.as_ref(),
        )
    {
        let bar = amplitudes.hopeless_from;
        let part = known.take().and_then(|known| thin.part_of(&known));
        let end = thin.end_below(bar, predictor, hypothesis, &from, part)?;
        let values = end.residual.len() as f64;
        // A way that was given up far from the data, about where the nominal law is, is out on all windows too.
        let out = end.given_up && end.cost > amplitudes.far_away * values;
        if (out || end.cost > bar * values)
            && let Ok(there) = weigh_at(data, predictor, hypothesis, amplitudes, &end)
        {
            return Ok(there);
        }
        // A soil that carries the wheel in these windows may not carry it in all.
        if residual(data, predictor, hypothesis, end.x.as_slice()).is_ok() {
            from = vec![end.x.as_slice().to_vec()];
            effort = Effort::Again;
        }
    }
    // A large discrepancy leaves one smooth way down, so all starts are tried there; the ends of that way start the others.
    let smallest = amplitudes.levels.first().map(|l| l.0);
    let mut fit = |whitener: &Whitener, starts: &[Vec<f64>]| {
        let known = known.take();
        fit_from(data, predictor, hypothesis, whitener, starts, known, effort)
    };
    for (a, ln_weight, whitener) in amplitudes.levels.iter().rev() {
        if !terms.is_empty() && Some(*a) == smallest {
            from.extend(starts.first().cloned());
        }
        let fitted = fit(whitener, &from)?;
        let post = posterior(hypothesis, &fitted);
        let term = ln_weight + post.log_evidence;
        terms.push(term);
        if *a <= USUAL {
            usual.push(term);
        }
        from = vec![fitted.x.as_slice().to_vec()];
        if best.as_ref().is_none_or(|b| term > b.0) {
            best = Some((term, *a, fitted, post));
        }
    }
    let (_, amplitude, found, posterior) =
        best.ok_or_else(|| GapError::Soil("a rival without amplitudes".to_owned()))?;
    let plain = if amplitude == 0.0 {
        found.clone()
    } else {
        from.push(found.x.as_slice().to_vec());
        fit(&amplitudes.plain, &from)?
    };
    let fit = found;
    let plain_log_evidence = crate::evidence::posterior(hypothesis, &plain).log_evidence;
    let log_evidence = log_sum_exp(terms);
    Ok(Weighed {
        hypothesis: hypothesis.clone(),
        fit,
        posterior,
        amplitude,
        usual: (log_sum_exp(usual) - log_evidence).exp(),
        log_evidence,
        plain,
        plain_log_evidence,
        fitted: true,
    })
}
