//! The nominal fit with its inputs where they most probably were: sought by the fit, which goes on from there, until both stand still.
//!
//! Misfit and prior decide whether a round leads on. What the sensors' noise comes to through other slopes does not: its density
//! alone would stop every way at a soil that answers slip too weakly.

use crate::dataset::{DataSet, Shift};
use crate::error::GapError;
use crate::fit::{Fit, fit_from, residual};
use crate::hypothesis::Hypothesis;
use crate::latent::{recentre, scanned};
use crate::noise::NoiseModel;
use crate::null::{FAR, WORSE};
use crate::predictor::{AnyPredictor, Predictor, RawSlopes};
use crate::roughness;
use crate::round::EXPLAINED;
use crate::settings::LogKind;
use crate::setup::Setup;
use crate::weigh::again;

/// Rounds at most, and the prior sd by which a fit then still stands.
const ROUNDS: usize = 20;
const STILL: f64 = 0.02;
/// Fall of the cost per value by which a round still leads on where the soil is held.
const LEADS_ON: f64 = 0.005;
/// Prior sd of a soil parameter from which a fit may have been led astray by slips that were taken as they were read.
const ASTRAY: f64 = 3.0;

/// The nominal law, and by what it is predicted where the inputs were read.
pub(crate) struct Nominal<'a, 'b> {
    pub(crate) predictor: &'a dyn Predictor,
    pub(crate) setup: &'a Setup<'b>,
    pub(crate) null: &'a Hypothesis,
}

/// Its fit with the inputs where they most probably were.
pub(crate) struct Centred {
    pub(crate) fitted: Fit,
    pub(crate) noise: NoiseModel,
    pub(crate) predictor: AnyPredictor,
}

impl Nominal<'_, '_> {
    /// A fit against a noise.
    ///
    /// # Errors
    /// Where the model has no answer at any start.
    pub(crate) fn fit(
        &self,
        data: &DataSet,
        predictor: &dyn Predictor,
        noise: &NoiseModel,
        starts: &[Vec<f64>],
    ) -> Result<Fit, GapError> {
        let (whitener, effort) = (noise.whitener(data)?, again(self.setup.kind));
        fit_from(data, predictor, self.null, &whitener, starts, None, effort)
    }

    /// Sensors' noise as it was propagated, with the ground's roughness as a fit leaves it over.
    ///
    /// # Errors
    /// Where the model has no answer.
    pub(crate) fn with_roughness(
        &self,
        data: &mut DataSet,
        predictor: &dyn Predictor,
        noise: NoiseModel,
        x: &[f64],
    ) -> Result<NoiseModel, GapError> {
        let mut noise = noise.with(data, predictor, self.setup.inherited.as_ref())?;
        if self.setup.kind == LogKind::Drive {
            let r = residual(data, predictor, self.null, x)?;
            roughness::add(&mut noise, data, self.setup.rover, &r);
        }
        Ok(noise)
    }

    /// From the end of a fit to inputs as they were read; from the prior centre too where that end may be astray, as what slips
    /// taken as they were read have led the soil to no way may lead back from.
    ///
    /// # Errors
    /// Where the model has no answer.
    pub(crate) fn centred(
        &self,
        data: &mut DataSet,
        fitted: Fit,
        noise: NoiseModel,
    ) -> Result<Centred, GapError> {
        let (measured, x) = (data.clone(), fitted.x.as_slice().to_vec());
        let as_read = || self.predictor.with_raw(&[]);
        let (found, settled) = self.rounds(data, as_read(), noise, &x, Some(fitted), false)?;
        let found = found.ok_or(GapError::Soil("a re-fit without an end".to_owned()))?;
        let far = self.is_far(&measured, &found.fitted);
        // A simulator's log was followed from inputs where they were: the prior centre is meant for those.
        let known = self.setup.inherited.is_some();
        let asked = self.is_astray(&found.fitted) || (!settled && !far) || known;
        if self.setup.kind != LogKind::Drive || !asked {
            return Ok(found);
        }
        let centre = vec![0.0; self.null.len()];
        match self.anew(measured, &centre, known)? {
            Some((again, other)) if other.betters(&found, data)? => {
                *data = again;
                Ok(other)
            }
            _ => Ok(found),
        }
    }

    /// From inputs as they were read and a place that no fit was led to; none where the law has no answer on the way, or stays far
    /// from the data: there inputs stay as they were read, as it is the law that is wrong.
    fn anew(
        &self,
        mut data: DataSet,
        at: &[f64],
        known: bool,
    ) -> Result<Option<(DataSet, Centred)>, GapError> {
        data.observations
            .iter_mut()
            .for_each(|o| o.shift = Shift::default());
        let noise = NoiseModel::propagate(&data, self.predictor, self.null, at)?;
        let noise = self.with_roughness(&mut data, self.predictor, noise, at)?;
        let as_read = self.predictor.with_raw(&[]);
        let found = self.rounds(&mut data, as_read, noise, at, None, known);
        let near = |found: &Centred| !self.is_far(&data, &found.fitted);
        let found = found.ok().and_then(|(found, _)| found).filter(near);
        Ok(found.map(|found| (data, found)))
    }

    /// Whether a fit may have been led astray by slips that were taken as they were read.
    fn is_astray(&self, fit: &Fit) -> bool {
        let soil = fit.x.iter().take(self.null.soil_len());
        soil.into_iter().any(|x| x.abs() > ASTRAY)
    }

    /// The same along an explanation of a drive, whose law was known to follow the inputs where they were; none that stays far from
    /// the data.
    pub(crate) fn along(
        &self,
        data: &DataSet,
        noise: &NoiseModel,
        x: &[f64],
    ) -> Option<(DataSet, Centred)> {
        let mut data = data.clone();
        data.observations
            .iter_mut()
            .for_each(|o| o.shift = Shift::default());
        let as_read = self.predictor.with_raw(&[]);
        let found = self.rounds(&mut data, as_read, noise.clone(), x, None, true);
        let (found, _) = found.ok()?;
        let found = found.filter(|f| !self.is_far(&data, &f.fitted))?;
        Some((data, found))
    }

    /// The same along one that is near the data, from where the inputs are `now`, or from the prior centre of its soil where that may
    /// be astray. What it cost under another law's noise is no measure of what it costs under its own.
    pub(crate) fn on(
        &self,
        data: &DataSet,
        now: AnyPredictor,
        noise: &NoiseModel,
        x: &[f64],
    ) -> Option<(DataSet, Centred)> {
        let mut there = data.clone();
        let found = self.rounds(&mut there, now, noise.clone(), x, None, false);
        let (found, settled) = found.ok()?;
        let found = found?;
        if settled && !self.is_astray(&found.fitted) {
            return Some((there, found));
        }
        let mut centre = found.fitted.x.as_slice().to_vec();
        centre[..self.null.soil_len()].fill(0.0);
        let other = self.anew(data.clone(), &centre, false).ok().flatten();
        // Soil far from where it is likely follows the data by steeper slopes, under which the noise is larger: it is no better than one
        // that explains the data from where it is likely.
        let explains = |o: &Centred| {
            !self.is_astray(&o.fitted) && o.fitted.chi2() < EXPLAINED * data.len() as f64
        };
        let betters = |o: &Centred| {
            let likelier = self.is_astray(&found.fitted) && explains(o);
            likelier || o.betters(&found, &there).unwrap_or(false)
        };
        let other = other.filter(|(_, o)| betters(o));
        other.or(Some((there, found)))
    }

    fn is_far(&self, data: &DataSet, fit: &Fit) -> bool {
        fit.chi2() > FAR * data.len() as f64
    }

    /// A fit from a place, with the inputs where they were moved to, and the noise by the slopes there.
    ///
    /// # Errors
    /// Where the model has no answer.
    fn there(
        &self,
        data: &mut DataSet,
        moved: AnyPredictor,
        slopes: Option<&[RawSlopes]>,
        at: &[f64],
    ) -> Result<Centred, GapError> {
        let own = match slopes {
            Some(slopes) => NoiseModel::through(data, slopes),
            None => NoiseModel::propagate(data, &*moved, self.null, at)?,
        };
        let noise = self.with_roughness(data, &*moved, own, at)?;
        let start = [at.to_vec()];
        Ok(Centred {
            fitted: self.fit(data, &*moved, &noise, &start)?,
            noise,
            predictor: moved,
        })
    }

    /// Rounds from an end, or from where no fit was led to, with the inputs where they are `now`; whether they came to stand still.
    fn rounds(
        &self,
        data: &mut DataSet,
        mut now: AnyPredictor,
        mut noise: NoiseModel,
        at: &[f64],
        end: Option<Fit>,
        known: bool,
    ) -> Result<(Option<Centred>, bool), GapError> {
        let Nominal {
            predictor, null, ..
        } = *self;
        let mut fitted = end;
        if known && let Some(scanned) = scanned(data, predictor, null, at, &noise)? {
            now = scanned;
        }
        let (mut at, mut nearby, mut settled) = (at.to_vec(), None, false);
        let held = self.setup.inherited.is_some();
        for _ in 0..ROUNDS {
            let far = |f: &Fit| !known && self.is_far(data, f);
            if settled || fitted.as_ref().is_some_and(far) {
                break;
            }
            let where_they_were = data.clone();
            let moved = recentre(data, (predictor, &*now), null, &at, &noise, nearby.take());
            let (moved, slopes) = match moved {
                Ok(moved) => moved.take(data),
                Err(GapError::Model(_)) => break,
                Err(e) => return Err(e),
            };
            let next = match self.there(data, moved, slopes.as_deref(), &at) {
                Ok(next) => next,
                Err(GapError::Model(_)) => {
                    // What was moved before and now is not may have no answer where it was read.
                    *data = where_they_were;
                    break;
                }
                Err(e) => return Err(e),
            };
            if let Some(before) = &fitted
                && next.loses_to(before, &noise, data)? > WORSE
            {
                // Too far for the tangents, which do not come back.
                *data = where_they_were;
                break;
            }
            let still = |(to, from): (&f64, &f64)| (to - from).abs() < STILL;
            // Where the soil is held the inputs may still move.
            let leads_on = held
                && fitted
                    .as_ref()
                    .is_none_or(|f| f.cost - next.fitted.cost > LEADS_ON * data.len() as f64);
            settled = !leads_on && next.fitted.x.iter().zip(&at).all(still);
            at = next.fitted.x.as_slice().to_vec();
            (now, nearby, noise) = (next.predictor, slopes, next.noise);
            fitted = Some(next.fitted);
        }
        let found = fitted.map(|fitted| Centred {
            fitted,
            noise,
            predictor: now,
        });
        Ok((found, settled))
    }
}

impl Centred {
    /// Whether it explains more than another.
    fn betters(&self, other: &Centred, data: &DataSet) -> Result<bool, GapError> {
        Ok(self.loses_to(&other.fitted, &other.noise, data)? < 0.0)
    }

    /// How much worse \[nats\] it is than a fit under another noise.
    ///
    /// # Errors
    /// [`GapError::NotPositiveDefinite`].
    fn loses_to(&self, fit: &Fit, noise: &NoiseModel, data: &DataSet) -> Result<f64, GapError> {
        Ok(0.5 * (self.fitted.cost - fit.cost) + self.noise.price_over(noise, data)?)
    }
}
