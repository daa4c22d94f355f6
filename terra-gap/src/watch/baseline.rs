//! What the beginning of a log teaches: soil with its posterior, roughness, and how far each score scatters.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::DMatrix;
use serde::Serialize;
use terra_data::Rover;
use terra_model::{AnyEffect, Registry};

use super::threshold::Spending;
use super::window::{Contribution, Nominal, Span};
use super::{SPANS, WatchSettings};
use crate::candidates::gate;
use crate::dataset::DataSet;
use crate::drive::{
    DrivePredictor, OwnNoise, Reader, SERIES, Slot, Taken, bends, channels, short_scatter, usual,
};
use crate::error::GapError;
use crate::hypothesis::Hypothesis;
use crate::mock::roughness_of;
use crate::null::{Refit, drop_unanswered, has_ended, refit_to_the_end};
use crate::parallel::for_each;
use crate::run::setup;
use crate::settings::{LogKind, Settings};

/// Fewest usable windows of a baseline.
const FEWEST: usize = 30;

/// What the baseline taught.
#[derive(Clone, Debug, Serialize)]
pub struct WatchBaseline {
    /// Usable windows.
    pub windows: usize,
    /// Misfit per value after the soil was fitted to them.
    pub chi2_per_dof: f64,
    /// Name of the nominal law.
    pub model: String,
    /// Soil: mean, sd and unit by name.
    pub soil: BTreeMap<String, SoilValue>,
    /// Standard deviation of every score over the baseline's windows, at least 1; scores are divided by it.
    pub scale: BTreeMap<String, f64>,
    /// Effects that are scored.
    pub effects: Vec<String>,
    /// How soon each effect of one prior sd would be flagged, driving as in the baseline.
    pub expected_delay: Vec<ExpectedDelay>,
    /// What the reader should know.
    pub notes: Vec<String>,
}

/// A soil parameter with its 1-sigma.
#[derive(Clone, Debug, Serialize)]
pub struct SoilValue {
    /// Posterior mean.
    pub mean: f64,
    /// Posterior sd.
    pub sd: f64,
    /// Unit.
    pub unit: &'static str,
}

/// When an effect of one prior sd would be flagged with an even chance.
#[derive(Clone, Debug, Serialize)]
pub struct ExpectedDelay {
    /// Effect.
    pub effect: String,
    /// Its form.
    pub form: String,
    /// One prior sd.
    pub magnitude: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Time from onset \[s\]; none when the longest span does not suffice.
    pub delay_s: Option<f64>,
}

/// A baseline ready to be compared with.
pub(crate) struct Learned {
    pub(crate) said: WatchBaseline,
    pub(crate) nominal: Nominal,
    pub(crate) usual: [f64; SERIES],
    pub(crate) own_noise: OwnNoise,
    /// Of every score.
    pub(crate) scales: Vec<f64>,
    pub(crate) spending: Spending,
    /// Name of every score: channels, then effects.
    pub(crate) names: Vec<String>,
    /// Scores that count in one direction only.
    pub(crate) one_sided: Vec<bool>,
}

/// Learns from the windows of the baseline; the inner error is why they do not suffice.
///
/// # Errors
/// A configuration that makes no sense.
pub(crate) fn learn(
    slots: Vec<Slot>,
    reader: &Reader,
    rover: &Rover,
    registry: &Registry,
    settings: &WatchSettings,
) -> Result<Result<Learned, String>, GapError> {
    let taken: Vec<(usize, Taken)> = slots
        .into_iter()
        .filter_map(|s| Some((s.number, s.taken?)))
        .collect();
    let usual = usual(taken.iter().map(|(_, t)| t));
    let mut straight: Vec<(usize, Taken)> = taken
        .into_iter()
        .filter(|(_, t)| !bends(t, &usual))
        .collect();
    let seen: Vec<Taken> = straight.iter().map(|(_, t)| t.clone()).collect();
    let own_noise = OwnNoise::of(&seen, rover.noise.get("roughness_N").is_some());
    straight
        .iter_mut()
        .for_each(|(_, taken)| own_noise.raise(taken));
    let mut observations = vec![];
    for (k, (_, t)) in straight.iter().enumerate() {
        let mut o = t.observation.clone();
        o.index = k;
        observations.push(o);
    }
    let mut data = DataSet {
        channels: channels(&reader.vehicle),
        observations,
        dropped: BTreeMap::new(),
        notes: own_noise.notes.clone(),
        short_scatter: short_scatter(&usual, &reader.sensors(), 0.0),
        uneven: None,
    };
    let windows = straight.iter().map(|(_, t)| t.window.clone()).collect();
    let predictor = DrivePredictor::new(reader.vehicle, windows, 1);
    let setup = setup(registry, rover, LogKind::Drive, &[])?;
    let null = Hypothesis::null(setup.law.clone(), Arc::clone(&setup.soil));
    drop_unanswered(&mut data, &predictor, &null, &vec![0.0; null.len()]);
    if data.observations.len() < FEWEST {
        let dropped: Vec<String> = reader
            .dropped
            .iter()
            .chain(&data.dropped)
            .map(|(why, n)| format!("{n} {why}"))
            .collect();
        return Ok(Err(format!(
            "{} usable windows in the baseline, fewer than {FEWEST}: a longer one is needed, with driving at several slips{}{}",
            data.observations.len(),
            if dropped.is_empty() {
                ""
            } else {
                "; left out: "
            },
            dropped.join(", ")
        )));
    }
    let found = refit_to_the_end(&mut data, &predictor, &setup, &null)?;
    let Some(found) = found.filter(|f| has_ended(&f.fitted)) else {
        let why = "the soil's fit to the baseline did not converge: the nominal simulator does not follow it (terra gap on the baseline says what is missing there), or its windows say too little of the soil";
        return Ok(Err(why.to_owned()));
    };
    let Refit {
        fitted: fit,
        noise,
        predictor,
        ..
    } = found;
    let free = null.len();
    let x = fit.x.as_slice().to_vec();
    let roughness = roughness_of(&data, &*predictor, &null, &x, &noise)?;
    let mut asked = Settings::of(rover);
    asked.effects.clone_from(&settings.effects);
    let candidates = gate(
        registry,
        &setup.law,
        &data,
        rover,
        LogKind::Drive,
        &asked,
        None,
    )?;
    let posterior = crate::evidence::posterior(&null, &fit);
    let nominal = Nominal {
        information: fit.jacobian.tr_mul(&fit.jacobian) + DMatrix::identity(free, free),
        x,
        roughness,
        channels: data.channels.clone(),
        effects: candidates.effects,
        vehicle: reader.vehicle,
        null,
    };
    let kept: Vec<&(usize, Taken)> = data
        .observations
        .iter()
        .filter_map(|o| straight.get(o.index))
        .collect();
    let contributions: Vec<Contribution> = for_each(kept.len(), |k| {
        nominal.contribution(&kept[k].1, kept[k].0, "")
    })
    .into_iter()
    .collect::<Result<_, GapError>>()?;
    let n = contributions.len();
    let names = score_names(&nominal);
    let scales = scales(&contributions, &nominal, names.len());
    let spending = Spending {
        alpha: settings.false_alarms,
        spans: SPANS.len(),
        scores: names.len(),
        freedom: (n - free) as f64,
    };
    let chi2 = fit.chi2() / data.len() as f64;
    let mut notes = std::mem::take(&mut data.notes);
    if chi2 > 1.5 {
        notes.push(format!(
            "the nominal simulator does not follow the baseline itself (chi2/n {chi2:.2}): only what comes on top of that gap is flagged; `terra gap` on the baseline names it"
        ));
    }
    let q: Vec<f64> = nominal.x.clone();
    let soil = &nominal.null.soil;
    let values = soil
        .physical(&q)
        .into_iter()
        .zip(soil.physical_sd(&q, &posterior.covariance));
    let said = WatchBaseline {
        windows: n,
        chi2_per_dof: chi2,
        model: terra_model::ForceLaw::name(&setup.law),
        soil: soil
            .names()
            .into_iter()
            .zip(soil.units().into_iter().zip(values))
            .map(|(name, (unit, (mean, sd)))| (name, SoilValue { mean, sd, unit }))
            .collect(),
        scale: names.iter().cloned().zip(scales.iter().copied()).collect(),
        effects: nominal
            .effects
            .iter()
            .map(|e| e.name().to_owned())
            .collect(),
        expected_delay: delays(&contributions, &nominal, &scales, &spending, rover),
        notes,
    };
    Ok(Ok(Learned {
        said,
        one_sided: one_sided(&nominal),
        nominal,
        usual,
        own_noise,
        scales,
        spending,
        names,
    }))
}

/// Channels, then effects with their forms.
pub(crate) fn score_names(nominal: &Nominal) -> Vec<String> {
    let channels = nominal.channels.iter().map(|c| c.name.clone());
    let effects = nominal.effects.iter().map(|e| match e.form() {
        "default" => e.name().to_owned(),
        form => format!("{}:{form}", e.name()),
    });
    channels.chain(effects).collect()
}

fn one_sided(nominal: &Nominal) -> Vec<bool> {
    let channels = nominal.channels.iter().map(|_| false);
    let first = |e: &Arc<dyn AnyEffect>| e.params().first().is_some_and(|p| p.one_sided());
    channels.chain(nominal.effects.iter().map(first)).collect()
}

/// Standard deviation of each score of single windows, the fitted soil's freedoms taken into account; at least 1.
fn scales(each: &[Contribution], nominal: &Nominal, scores: usize) -> Vec<f64> {
    let free = nominal.null.len();
    let mut squares = vec![0.0; scores];
    let mut counts = vec![0usize; scores];
    for c in each {
        let mut one = Span::empty(free, scores);
        one.add(c);
        // The soil was fitted to these windows too, so nothing is left open.
        for (k, part) in one.raw().enumerate() {
            if let Some(z) = part {
                squares[k] += z * z;
                counts[k] += 1;
            }
        }
    }
    let scale = |(sum, n): (&f64, &usize)| {
        let freedom = n.saturating_sub(free).max(1) as f64;
        (sum / freedom).sqrt().max(1.0)
    };
    squares.iter().zip(&counts).map(scale).collect()
}

/// When each effect of one prior sd would pass the threshold of the first look, driving as in the baseline.
fn delays(
    each: &[Contribution],
    nominal: &Nominal,
    scales: &[f64],
    spending: &Spending,
    rover: &Rover,
) -> Vec<ExpectedDelay> {
    let first = nominal.channels.len();
    let mut all = Span::empty(nominal.null.len(), scales.len());
    each.iter().for_each(|c| all.add(c));
    let threshold = spending.threshold(0);
    let reached = |score: usize, windows: usize| {
        let span = all.stretched(windows as f64 / each.len().max(1) as f64);
        let standing = span.standings(&nominal.information, first);
        let found = standing.get(score).copied().flatten();
        let scale = scales.get(score).copied().unwrap_or(1.0);
        found.is_some_and(|s| s.information.sqrt() / scale >= threshold)
    };
    nominal
        .effects
        .iter()
        .enumerate()
        .filter_map(|(k, effect)| {
            let param = effect.params().first()?;
            let windows = SPANS.into_iter().find(|&n| reached(first + k, n));
            let fewest = windows.and_then(|w| (SPANS[0]..=w).find(|&n| reached(first + k, n)));
            Some(ExpectedDelay {
                effect: effect.name().to_owned(),
                form: effect.form().to_owned(),
                magnitude: param.prior_sd,
                unit: param.unit,
                delay_s: fewest.map(|n| n as f64 * rover.gap.window),
            })
        })
        .collect()
}
