//! The nominal model's own best: its soil re-fitted, with the noise that belongs to that fit.

use crate::centring::{Centred, Nominal};
use crate::dataset::{DataSet, Shift};
use crate::error::GapError;
use crate::fit::{Effort, Fit, fit_near, residual};
use crate::hypothesis::Hypothesis;
use crate::memory::Memory;
use crate::noise::NoiseModel;
use crate::parallel::for_each;
use crate::predictor::{AnyPredictor, Predictor};
use crate::settings::LogKind;
use crate::setup::Setup;
use crate::thin::Thin;
use crate::weigh::NEAR;

/// Slip below which a row counts as braking for the second try: rows at zero slip scatter to both sides.
const BRAKING: f64 = -0.05;

/// Misfit per value from which a re-fit is far from the data.
pub(crate) const FAR: f64 = 2.0;
/// Nats by which the data may be less likely where noise and inputs are taken anew: beyond, these were taken at a wrong place.
pub(crate) const WORSE: f64 = 20.0;

/// The nominal model re-fitted.
pub(crate) struct Refit {
    /// Its fit against the noise alone.
    pub(crate) fitted: Fit,
    /// That noise.
    pub(crate) noise: NoiseModel,
    /// Whitened misfit of the model as given.
    pub(crate) given: f64,
    /// Predicts where the inputs most probably were.
    pub(crate) predictor: AnyPredictor,
}

/// What is noted of a re-fit whose end is not certified.
const NO_END: &str = "the re-fit of the nominal model did not converge";

/// Re-fits the nominal model; `None` when motion alone cannot be fitted.
///
/// Braking is an extension of the wheel laws. Where a rig's braking rows keep a fit from converging they are left out, and
/// counted with that reason.
///
/// # Errors
/// Where the model has no answer at the prior centre.
pub(crate) fn refit(
    data: &mut DataSet,
    predictor: &dyn Predictor,
    setup: &Setup<'_>,
    null: &Hypothesis,
) -> Result<Option<Refit>, GapError> {
    let found = settle(data, predictor, setup, null)?;
    if found.fitted.converged {
        return Ok(Some(found));
    }
    if setup.kind == LogKind::Kinematic {
        return Ok(None);
    }
    let braking =
        |o: &crate::dataset::Observation| o.factors.get("slip").is_some_and(|s| *s < BRAKING);
    let rows = data.observations.iter().filter(|o| braking(o)).count();
    if setup.kind == LogKind::Rig && rows > 0 && data.len() >= 2 * null.len() {
        let mut driven = data.clone();
        driven.observations.retain(|o| !braking(o));
        let found = settle(&mut driven, predictor, setup, null)?;
        if found.fitted.converged {
            *data = driven;
            let reason = "braking: with these rows the nominal model's re-fit does not converge";
            *data.dropped.entry(reason.to_owned()).or_default() += rows;
            return Ok(Some(found));
        }
    }
    // A large gap can push the soil into a corner of the model's domain. That the nominal model has no best soil says nothing
    // against the rivals, whose own fits are certified.
    data.notes.push(NO_END.to_owned());
    Ok(Some(found))
}

/// Promise, in units of the misfit per value and free number, below which a fit has ended: one such unit is the square of a number's own
/// sd, so that they are a third of their sd from their best in the mean at most. At a kink of the law, where a far fit often ends,
/// no step keeps what the slopes promise.
const ENDED: f64 = 0.1;

/// Whether a fit is certified, or its slopes promise too little to go on.
pub(crate) fn has_ended(fit: &Fit) -> bool {
    let misfit = (fit.chi2() / fit.residual.len() as f64).max(1.0);
    fit.converged || fit.promise() < ENDED * misfit * fit.x.len() as f64
}

/// The same, gone on with until no step leads down any more: a diagnosis goes on from an end that is not certified, but where there
/// are no rivals it is all there is.
///
/// # Errors
/// As [`refit`].
pub(crate) fn refit_to_the_end(
    data: &mut DataSet,
    predictor: &dyn Predictor,
    setup: &Setup<'_>,
    null: &Hypothesis,
) -> Result<Option<Refit>, GapError> {
    let mut found = refit(data, predictor, setup, null)?;
    if let Some(found) = found.as_mut().filter(|f| !f.fitted.converged) {
        let whitener = found.noise.whitener(data)?;
        let end = found.fitted.x.as_slice().to_vec();
        let (predictor, effort) = (&*found.predictor, Effort::Certified);
        found.fitted = fit_near(data, predictor, null, &whitener, &end, None, effort)?;
        data.notes.retain(|n| n != NO_END);
    }
    Ok(found)
}

/// The noise depends on the slopes of the model, the model on the noise: two rounds settle it. Where a drive's re-fit stays far
/// from the data its slopes are not the truth's either, and those of the prior centre stand until there is an explanation.
fn settle(
    data: &mut DataSet,
    predictor: &dyn Predictor,
    setup: &Setup<'_>,
    null: &Hypothesis,
) -> Result<Refit, GapError> {
    // A fit before may have moved the inputs; this one begins at what was measured.
    data.observations
        .iter_mut()
        .for_each(|o| o.shift = Shift::default());
    let centre = vec![0.0; null.len()];
    let inherited = setup.inherited.as_ref();
    let mut noise = NoiseModel::propagate(data, predictor, null, &centre)?;
    noise = noise.with(data, predictor, inherited)?;
    let given = noise
        .whitener(data)?
        .apply_vector(&residual(data, predictor, null, &centre)?)
        .norm_squared();
    let mut starts = starts_of(null, setup.kind);
    if setup.kind == LogKind::Drive {
        let thin = Thin::new(data, &noise)?;
        let held_back = thin.held_back(predictor, null, centre.clone(), None)?;
        let mut end = thin.let_go(predictor, null, &held_back, f64::INFINITY)?;
        let values = end.residual.len() as f64;
        if end.chi2() > NEAR * values {
            // The straight way, as long as it may lead lower.
            let straight = thin.end_below(end.cost / values, predictor, null, &starts, None)?;
            if straight.cost < end.cost {
                end = straight;
            }
        }
        // A soil that carries the wheel in these windows may not carry it in all.
        if residual(data, predictor, null, end.x.as_slice()).is_ok() {
            starts = vec![end.x.as_slice().to_vec()];
        }
    }
    let nominal = Nominal {
        predictor,
        setup,
        null,
    };
    // Of the data, its noise's own density included.
    let says = |f: &Fit| -0.5 * (f.cost + f.log_det);
    let mut fitted = nominal.fit(data, predictor, &noise, &starts)?;
    let n = data.len() as f64;
    for _ in 0..2 {
        let x = fitted.x.as_slice().to_vec();
        let own = NoiseModel::propagate(data, predictor, null, &x)
            .and_then(|own| nominal.with_roughness(data, predictor, own, &x))
            .and_then(|own| {
                let starts = std::slice::from_ref(&x);
                Ok((nominal.fit(data, predictor, &own, starts)?, own))
            });
        let (with_own, own) = match own {
            Ok(own) => own,
            // Soil that only just carries the wheel has no slopes there: the noise stands as it is.
            Err(GapError::Model(_)) => break,
            Err(e) => return Err(e),
        };
        let far = setup.kind == LogKind::Drive && fitted.chi2() > FAR * n;
        // Unless it is its own noise that brings it near, and explains the data the better.
        if !far || (with_own.chi2() < NEAR * n && says(&with_own) > says(&fitted)) {
            (noise, fitted) = (own, with_own);
        } else {
            let at_centre = NoiseModel::propagate(data, predictor, null, &centre)?;
            noise = nominal.with_roughness(data, predictor, at_centre, &x)?;
            fitted = nominal.fit(data, predictor, &noise, &[x])?;
        }
    }
    let Centred {
        fitted,
        noise,
        predictor,
    } = nominal.centred(data, fitted, noise)?;
    Ok(Refit {
        fitted,
        noise,
        given,
        predictor,
    })
}

/// Leaves out, and counts, observations that the model has no answer for at the prior centre.
pub(crate) fn drop_unanswered(
    data: &mut DataSet,
    predictor: &dyn Predictor,
    null: &Hypothesis,
    centre: &[f64],
) {
    let p = null.parameters(centre);
    let indices: Vec<usize> = data.observations.iter().map(|o| o.index).collect();
    let memory = Memory::none();
    if predictor
        .residuals(&null.law, &p, &indices, &memory)
        .is_ok()
    {
        return;
    }
    let reasons: Vec<Option<String>> = for_each(data.observations.len(), |k| {
        let o = &data.observations[k];
        predictor
            .residual(&null.law, &p, o.index, &predictor.raw(o.index))
            .err()
            .map(|e| kind_of(&e))
    });
    let mut reasons = reasons.into_iter();
    data.observations.retain(|_| {
        let reason = reasons.next().flatten();
        if let Some(reason) = &reason {
            *data.dropped.entry(reason.clone()).or_default() += 1;
        }
        reason.is_none()
    });
}

/// Why a row has no answer on ground that gives way.
pub(crate) const NOT_CARRIED: &str = "outside the model: the nominal soil does not carry the wheel";

/// A reason without the row's own numbers, so that rows can be counted.
fn kind_of(error: &GapError) -> String {
    match error {
        GapError::Model(terra_model::ModelError::NoEquilibrium { .. }) => NOT_CARRIED.to_owned(),
        GapError::Model(terra_model::ModelError::Contact { quantity, .. }) => {
            format!("outside the model: {quantity}")
        }
        GapError::Model(terra_model::ModelError::Parameter {
            model,
            parameter,
            expected,
            ..
        }) => format!("outside the model: {model}: {parameter} is not {expected}"),
        other => format!("outside the model: {other}"),
    }
}

/// The prior centre; on a rig, where a fit is cheap and wheel laws are far from linear, also the centre moved by one
/// prior sd along each soil parameter in turn, both ways. A drive's windows pull every start to the same soil.
pub(crate) fn starts_of(h: &Hypothesis, kind: LogKind) -> Vec<Vec<f64>> {
    let d = h.len();
    let mut out = vec![vec![0.0; d]];
    if kind == LogKind::Rig {
        for k in 0..h.soil_len() {
            for side in [-1.0, 1.0] {
                let mut x = vec![0.0; d];
                x[k] = side;
                out.push(x);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use terra_model::ModelError;

    use super::*;

    /// Two rows that a law has no answer for by the same rule are counted together, whatever their numbers; those by another
    /// are not.
    #[test]
    fn a_reason_has_no_numbers_of_a_row() {
        let apex = |value| {
            GapError::Model(ModelError::Parameter {
                model: "wong-reece",
                parameter: "c1 + c2 slip",
                value,
                expected: "a value between 0 and 1: the angle of maximum stress lies inside the contact",
            })
        };
        let load = |load| {
            GapError::Model(ModelError::NoEquilibrium {
                load,
                max_load: 90.0,
            })
        };
        assert_eq!(kind_of(&apex(1.0121)), kind_of(&apex(1.0136)));
        assert!(kind_of(&apex(1.0121)).contains("c1 + c2 slip"));
        assert_eq!(kind_of(&load(100.0)), kind_of(&load(120.0)));
        assert_ne!(kind_of(&load(100.0)), kind_of(&apex(1.0121)));
    }
}
