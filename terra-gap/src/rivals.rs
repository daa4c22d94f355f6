//! All rival explanations of one data set, each fitted and weighed: the nominal model, single effects, other structures,
//! pairs, and something unknown.

use std::sync::Arc;

use crate::candidates::Candidates;
use crate::confirm::{confirm_pairs, confirm_singles, screen_all};
use crate::dataset::{DataSet, Predictor};
use crate::error::GapError;
use crate::fit::Fit;
use crate::hypothesis::Hypothesis;
use crate::noise::NoiseModel;
use crate::null::{drop_unanswered, refit};
use crate::settings::{LogKind, Settings};
use crate::setup::{ADEQUATE, Screened, Setup};
use crate::structures::{Structures, weigh_structures};
use crate::unknown;
use crate::weigh::{Amplitudes, Weighed, unknown_amplitudes, weigh};

/// What was weighed.
pub(crate) struct Rivals {
    /// The nominal law, its soil free.
    pub null: Hypothesis,
    /// Its fit against the noise alone.
    pub fitted: Fit,
    /// Whitened misfit of the nominal law as given.
    pub given: f64,
    /// The noise, shared by all.
    pub noise: NoiseModel,
    /// The nominal law weighed.
    pub null_weighed: Weighed,
    /// Signatures.
    pub screen: Vec<Screened>,
    /// Effects alone, by their row of the screen, under every structure tried.
    pub singles: Vec<(usize, Vec<Weighed>)>,
    /// Other terrain models.
    pub structures: Vec<(String, Weighed)>,
    /// Effects by two.
    pub pairs: Vec<Weighed>,
    /// ln Z of something unknown.
    pub log_unknown: f64,
    /// Effects that were not asked, with the reason.
    pub not_asked: Vec<(String, String)>,
}

/// Fits and weighs all rivals; the inner error is the reason why the data cannot tell.
///
/// # Errors
/// A configuration that makes no sense.
pub(crate) fn weigh_rivals<P: Predictor>(
    data: &mut DataSet,
    predictor: &P,
    setup: &Setup<'_>,
    settings: &Settings,
    candidates: &Candidates,
) -> Result<Result<Rivals, String>, GapError> {
    let null = Hypothesis::null(setup.law.clone(), Arc::clone(&setup.soil));
    drop_unanswered(data, predictor, &null, &vec![0.0; null.len()]);
    let free = null.len();
    if data.len() < free + 3 {
        let dropped: Vec<String> = data
            .dropped
            .iter()
            .map(|(why, n)| format!("{n} {why}"))
            .collect();
        return Ok(Err(format!(
            "{} usable values for {free} soil parameters{}{}",
            data.len(),
            if dropped.is_empty() {
                ""
            } else {
                "; left out: "
            },
            dropped.join(", ")
        )));
    }
    let Some((fitted, noise, given)) = refit(data, predictor, setup, &null)? else {
        return Ok(Err(
            "the re-fit of the nominal model did not converge".to_owned()
        ));
    };
    let data = &*data;
    let centre = vec![0.0; null.len()];
    let plain = noise.whitener(data)?;
    let levels = Amplitudes::new(&noise, data, setup.kind)?;
    let null_weighed = weigh(
        data,
        predictor,
        &null,
        &levels,
        &match setup.kind {
            LogKind::Rig => vec![fitted.x.as_slice().to_vec(), centre.clone()],
            LogKind::Drive | LogKind::Kinematic => vec![fitted.x.as_slice().to_vec()],
        },
        None,
    )?;

    let mut not_asked = candidates.not_asked.clone();
    let (screen, asked) = screen_all(
        data,
        predictor,
        &null,
        &null_weighed.fit,
        &candidates.effects,
        &plain,
        &mut not_asked,
    );

    let structures =
        |rivals: &[&Weighed]| weigh_structures(data, predictor, setup, &noise, &levels, rivals);
    // On a rig effects are weighed under other structures too; a drive's structures must measure up to its effects first.
    let mut found = match setup.kind {
        LogKind::Rig => structures(&[])?,
        LogKind::Drive | LogKind::Kinematic => Structures::default(),
    };
    let singles = confirm_singles(
        data,
        predictor,
        setup,
        &null,
        &null_weighed,
        &found.weighed,
        &levels,
        &screen,
        &asked,
    );
    let pairs = if settings.combine >= 2 {
        confirm_pairs(
            data, predictor, &null, &levels, &singles, &asked, &plain, setup.kind,
        )
    } else {
        vec![]
    };

    if setup.kind != LogKind::Rig {
        let rivals: Vec<&Weighed> = singles
            .iter()
            .flat_map(|(_, w)| w)
            .chain(&pairs)
            .chain([&null_weighed])
            .collect();
        found = structures(&rivals)?;
    }
    not_asked.extend(found.out);

    // Unknown: a discrepancy larger than any hypothesis may use, on top of explanations that are not adequate by
    // themselves. An adequate one with a larger discrepancy is still that explanation.
    let mut bases: Vec<&Weighed> = singles.iter().flat_map(|(_, w)| w.iter()).collect();
    bases.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    bases.truncate(3);
    bases.retain(|w| setup.kind == LogKind::Drive || w.chi2_per_value() > ADEQUATE);
    bases.push(&null_weighed);
    let log_unknown = bases
        .iter()
        .map(|w| {
            w.plain_log_evidence
                + unknown::gain(data, &w.plain, &plain, unknown_amplitudes(setup.kind))
        })
        .fold(f64::NEG_INFINITY, f64::max);

    Ok(Ok(Rivals {
        null,
        fitted,
        given,
        noise,
        null_weighed,
        screen,
        singles,
        structures: found.weighed,
        pairs,
        log_unknown,
        not_asked,
    }))
}
