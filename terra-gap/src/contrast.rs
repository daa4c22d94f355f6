//! Against an outside simulator: its own log is fitted first, and what the fit leaves over is carried to the real log.
//!
//! Every wheel law differs from another simulator's by some percent of the load, and that difference would be read as an
//! effect. So the nominal law gets a smooth error of its form, free while it is fitted to the simulator's log and frozen
//! afterwards: what is then missing on the real log is missing in the simulator too.
//!
//! What the error looks like is in [`form_error`](crate::form_error); what of the library's effects the simulator's log shows beside it
//! is [shared](crate::shared). Soil on the real log: centre of the
//! baseline's fit, a tenth of the prior spread; `soil-change` alone has the whole spread, and on other soil the form's error may
//! be another by half of its own spread. How well the simulator's log
//! determines soil and form, the covariance P of that fit, is part of the real log's noise: G P G', G the values' slopes.
//! So is what no such error follows: where the misfit to the simulator's log is more than noise, the noise is that much larger.

use std::collections::BTreeMap;
use std::sync::Arc;

use terra_data::Rover;
use terra_mme::{Centre, FitSpace, Priors};
use terra_model::{AnyEffect, ForceLaw, Law, Registry, Scale};

use crate::candidates::gate;
use crate::dataset::DataSet;
use crate::error::GapError;
use crate::evidence::posterior;
use crate::fit::Fit;
use crate::form_error::{Form, is_form_error};
use crate::hypothesis::Hypothesis;
use crate::kinematic;
use crate::noise::Inherited;
use crate::null::{drop_unanswered, has_ended, refit_to_the_end};
use crate::predictor::Predictor;
use crate::settings::{LogKind, Settings};
use crate::setup::{OTHER_SOIL, Rival, Setup};
use crate::shared;
use crate::soil::{free_soil, widths};
use crate::soil_space::SoilSpace;
use crate::weigh::Weighed;

/// Share of its own spread by which the form's error may be another on other soil: two wheel laws do not differ alike on all
/// soils. Held as it was, other soil was read as two instruments that mended it (four of twelve mock contrasts, seed 14014).
const OTHER_FORM: f64 = 0.5;
/// The same on the same soil, by motion alone: 2.5 % of yaw rate and ground speed in turns. Effects of the vehicle are no factors of
/// its motion on soil, as a wider one also slips otherwise, and no two turns on real ground are alike.
const SAME_MOTION: f64 = 0.05;
/// Spreads by which a coefficient is clearly another.
const MOVED: f64 = 1.0;
/// Misfit per value up to which a simulator's log is followed as well as noise lets tell.
const FOLLOWED: f64 = 1.05;
/// Share of the prior spread that the same soil may differ by between the two logs.
const SAME_SOIL: f64 = 0.1;

/// How well the nominal law follows the simulator.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Baseline {
    /// Misfit per value with soil and form fitted to the simulator's log.
    pub chi2_per_dof: f64,
    /// Values of that log that were used.
    pub values: usize,
    /// Root mean square of the form's error over the anchored slips: pull in loads, torque in loads times radius, ln sinkage. By
    /// motion alone over the anchored turnings: ln yaw rate, ln ground speed.
    pub form_error: Vec<f64>,
    /// Of what each of these is.
    pub form_error_of: Vec<&'static str>,
    /// Effects that the simulator's log shows itself: on the real log a cause of these is a change.
    pub shows: Vec<Shown>,
    /// False: the soil may have changed between the logs, and `soil-change` competes.
    pub same_soil: bool,
    /// Whether its vehicle carries its load otherwise in turns than a real one.
    #[serde(skip)]
    pub(crate) otherwise_loaded: bool,
    /// Rows of that log that were not used, by reason.
    pub dropped: BTreeMap<String, usize>,
    /// What was noted of it and of the fit to it.
    pub notes: Vec<String>,
}

/// The nominal law as it follows a simulator's log.
struct Followed {
    data: DataSet,
    /// With the effects that this shows.
    joined: Hypothesis,
    fit: Fit,
    /// Whether it did so without any.
    well: bool,
    /// ln Z.
    says: f64,
}

/// An effect that a simulator's log shows.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Shown {
    /// Its name.
    pub effect: String,
    /// Its form.
    pub form: String,
    /// How much of it.
    pub magnitude: f64,
    /// In this unit.
    pub unit: String,
}

/// The nominal simulator made like the outside one, with its rivals on the real log.
/// `labels`: the logs that have a soil of their own.
///
/// # Errors
/// A soil that the law cannot use; a fit to the simulator's log that does not converge.
pub(crate) fn against<'a>(
    mut data: DataSet,
    predictor: &dyn Predictor,
    registry: &'a Registry,
    rover: &'a Rover,
    kind: LogKind,
    settings: &Settings,
    same_soil: bool,
    labels: &[String],
) -> Result<(Setup<'a>, Baseline), GapError> {
    let form = Form::of(&data, kind);
    let by_motion = kind == LogKind::Kinematic;
    let law = match by_motion {
        true => kinematic::ideal_drive()?,
        false => registry.law(&rover.terrain.model)?.quick(),
    };
    let law = law.with_effects([form.effect()])?;
    let free = match by_motion {
        true => kinematic::free_ground(&law, rover)?,
        false => free_soil(&law, rover)?,
    };
    let soil = Arc::new(SoilSpace::new(free, &[]));
    let setup = Setup {
        registry,
        rover,
        law: law.clone(),
        soil: Arc::clone(&soil),
        structures: vec![],
        without: vec![],
        kind,
        inherited: None,
    };
    let null = Hypothesis::null(law.clone(), soil);
    drop_unanswered(&mut data, predictor, &null, &vec![0.0; null.len()]);
    // The form's error has a prior, and how little a log says of it is part of the real log's noise; the soil must follow from it.
    let asked = null.len() - form.effect().params().len();
    if data.len() < asked {
        return Err(GapError::Simulator(format!(
            "{} usable values for {asked} soil parameters: it needs more rows (steady trials at more slips or a ramp) or more channels (torque, sinkage)",
            data.len(),
        )));
    }
    let every = Settings {
        effects: None,
        ..settings.clone()
    };
    let candidates = gate(registry, &law, &data, rover, kind, &every, None)?;
    let followed = |mut data: DataSet, by: &dyn Predictor| -> Result<Followed, GapError> {
        let found = refit_to_the_end(&mut data, by, &setup, &null)?;
        let found = found.filter(|f| has_ended(&f.fitted)).ok_or_else(|| {
            let why = "the fit of the nominal simulator to it did not converge";
            GapError::Simulator(why.to_owned())
        })?;
        let well = found.fitted.chi2() < FOLLOWED * data.len() as f64;
        let (by, whitener) = (&*found.predictor, found.noise.whitener(&data)?);
        let (null, fit, effects) = (&null, found.fitted, &candidates.effects);
        let (joined, fit) = shared::joined(&data, by, null, fit, &whitener, effects, kind);
        let says = posterior(&joined, &fit).log_evidence;
        Ok(Followed {
            data,
            joined,
            fit,
            well,
            says,
        })
    };
    // A simulator's vehicle may be loaded otherwise in turns than ours.
    let as_ours = followed(data.clone(), predictor).map_err(of_the_simulator);
    let other = predictor.otherwise_loaded();
    let other = other.filter(|_| !as_ours.as_ref().is_ok_and(|f| f.well));
    let other = other.and_then(|other| followed(data, &*other).ok());
    let least = as_ours.as_ref().map_or(f64::NEG_INFINITY, |f| f.says);
    let other = other.filter(|f| f.says > least);
    let otherwise_loaded = other.is_some();
    let found = other.map_or(as_ours, Ok)?;
    let (mut data, joined, fit) = (found.data, found.joined, found.fit);
    if !fit.converged {
        data.notes.push(format!(
            "the fit to the simulator's log is not certified: no step leads down, but its slopes promise {:.1} of a misfit of {:.0}",
            fit.promise(),
            fit.chi2()
        ));
    }
    let ranges = data.ranges();
    let all = joined.parameters(fit.x.as_slice());
    let (p, magnitudes) = all.split_at(law.params().len());
    let own = p.get(law.model().params().len()..).unwrap_or(&[]);
    let (form_error_of, form_error) = form.sizes(own);
    let baseline = Baseline {
        chi2_per_dof: fit.chi2() / data.len() as f64,
        values: data.len(),
        form_error,
        form_error_of,
        shows: shown(&joined, magnitudes),
        same_soil,
        otherwise_loaded,
        dropped: data.dropped,
        notes: data.notes,
    };
    let whole = around(&law, p, rover, 1.0, OTHER_FORM)?;
    let same_form = if by_motion { SAME_MOTION } else { 0.0 };
    let narrow = around(&law, p, rover, SAME_SOIL, same_form)?;
    let structures = if same_soil {
        vec![]
    } else {
        vec![Rival {
            name: OTHER_SOIL.to_owned(),
            law: law.clone(),
            soil: Arc::new(SoilSpace::new(whole, labels)),
        }]
    };
    let covariance = posterior(&joined, &fit).covariance;
    // Each number that the data determine takes one value's misfit away.
    let determined = fit.x.len() as f64 - covariance.trace();
    let excess = (fit.chi2() / (baseline.values as f64 - determined)).max(1.0);
    let root =
        covariance
            .cholesky()
            .map(|c| c.unpack())
            .ok_or_else(|| GapError::NotPositiveDefinite {
                what: "the fit to the simulator's log".to_owned(),
            })?;
    let setup = Setup {
        law,
        soil: Arc::new(SoilSpace::new(narrow, labels)),
        structures,
        inherited: Some(Inherited {
            hypothesis: joined,
            x: fit.x.as_slice().to_vec(),
            root,
            excess,
            ranges,
        }),
        ..setup
    };
    Ok((setup, baseline))
}

/// The effects that joined, each with its first magnitude.
fn shown(joined: &Hypothesis, magnitudes: &[f64]) -> Vec<Shown> {
    let mut left = magnitudes;
    let of = |effect: &Arc<dyn AnyEffect>| {
        let (own, rest) = left.split_at(effect.params().len());
        left = rest;
        let (param, magnitude) = effect.params().iter().zip(own).next()?;
        Some(Shown {
            effect: effect.name().to_owned(),
            form: effect.form().to_owned(),
            magnitude: *magnitude,
            unit: param.unit.to_owned(),
        })
    };
    joined.effects().iter().filter_map(of).collect()
}

/// What the simulator's log itself brings about is no fault of the log to be diagnosed.
fn of_the_simulator(error: GapError) -> GapError {
    match error {
        GapError::Model(_) | GapError::NotPositiveDefinite { .. } => {
            GapError::Simulator(error.to_string())
        }
        other => other,
    }
}

/// Whether other soil was fitted with an error of the wheel law's form that is clearly another than on the simulator's soil.
pub(crate) fn needs_another_form(other_soil: &Weighed) -> bool {
    let names = other_soil.hypothesis.soil.names();
    let mut each = names.iter().zip(other_soil.fit.x.iter());
    each.any(|(name, x)| is_form_error(name) && x.abs() > MOVED)
}

/// The soil around the baseline's within a share of its prior spread, and the form's error within a share of its own.
fn around(
    law: &Law,
    p: &[f64],
    rover: &Rover,
    share: f64,
    form: f64,
) -> Result<FitSpace, GapError> {
    let given = Priors::default().with(&rover.terrain.prior_sd, &rover.terrain.prior_abs_sd);
    let mut priors = Priors::default();
    let soil_params = law.model().params();
    for param in soil_params {
        let sd = given.sd.get(param.name).copied().unwrap_or(param.prior_sd);
        priors.sd.insert(param.name.to_owned(), share * sd);
        // A linear parameter takes its spread from here, one that starts at 0 too.
        let absolute = given.abs_sd.get(param.name).copied();
        let linear = (param.scale == Scale::Linear).then_some(param.prior_sd);
        if let Some(sd) = absolute.or(linear) {
            priors.abs_sd.insert(param.name.to_owned(), share * sd);
        }
    }
    let k_eq = given.sd.get("k_eq").copied();
    if let Some(sd) = k_eq {
        priors.sd.insert("k_eq".to_owned(), share * sd);
    }
    for param in &law.params()[soil_params.len()..] {
        let spread = form * param.prior_sd;
        priors.abs_sd.insert(param.name.to_owned(), spread);
    }
    FitSpace::new(law, Centre::Parameters(p), &widths(rover), &priors)
        .map_err(|e| GapError::Soil(e.to_string()))
}
