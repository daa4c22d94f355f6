//! A drive's windows thinned out: fits that come from far go most of their way on these, and only end on all.

use std::sync::Arc;

use terra_model::AnyEffect;

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::fit::{Effort, Fit, Known, evaluate, fit_from};
use crate::hypothesis::Hypothesis;
use crate::noise::{NoiseModel, Whitener};
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::signatures::columns;

/// How many times the noise is taken larger where the prior is to hold the soil back: first, and on the way down.
const LOOSE: [f64; 2] = [10.0, 3.0];

/// |x|² of a soil and effects as far as they are believed: eight at two and a half prior sd.
const FARTHEST_SOIL: f64 = 50.0;

/// Some windows of a log with their noise.
pub(crate) struct Thin {
    data: DataSet,
    whitener: Whitener,
    loose: [Whitener; 2],
    all: bool,
    /// Which of all stacked values they hold; none where the noise ties windows together.
    rows: Option<Vec<usize>>,
}

impl Thin {
    /// Windows for the way of a fit.
    pub(crate) const WAY: usize = 64;
    /// Windows to look around on.
    pub(crate) const SCOUT: usize = 32;

    /// Every second, third ... window, of which at least so many are kept; all of them where the log is short already.
    ///
    /// # Errors
    /// A covariance that is not positive definite.
    pub(crate) fn new(data: &DataSet, noise: &NoiseModel, least: usize) -> Result<Self, GapError> {
        let every = (data.observations.len() / least).max(1);
        let kept = |i: usize| i % every == every / 2;
        let keep: Vec<usize> = (0..data.observations.len()).filter(|i| kept(*i)).collect();
        let rows = data.stacked().enumerate();
        let rows = rows.filter(|(_, (i, _))| kept(*i)).map(|(row, _)| row);
        let rows = noise.is_separate().then(|| rows.collect());
        let data = data.subset(&keep);
        let noise = noise.subset(&keep);
        Ok(Thin {
            whitener: noise.whitener(&data)?,
            loose: [
                noise.times(LOOSE[0]).whitener(&data)?,
                noise.times(LOOSE[1]).whitener(&data)?,
            ],
            all: every == 1,
            data,
            rows,
        })
    }

    /// The windows, and their noise.
    pub(crate) fn windows(&self) -> (&DataSet, &Whitener) {
        (&self.data, &self.whitener)
    }

    /// Whether no window was left out.
    pub(crate) fn is_all(&self) -> bool {
        self.all
    }

    /// Cost that a fit to all windows leaves on these; on all where the noise ties windows together.
    pub(crate) fn cost_of(&self, fit: &Fit) -> f64 {
        let Some(rows) = &self.rows else {
            return fit.cost;
        };
        let misfit: f64 = rows.iter().map(|&row| fit.residual[row].powi(2)).sum();
        misfit + fit.x.norm_squared()
    }

    /// What is known of these windows' values, out of all; none where the noise ties windows together.
    pub(crate) fn part_of(&self, known: &Known) -> Option<Known> {
        self.rows.as_ref().map(|rows| known.of_rows(rows))
    }

    /// Where a fit to these windows ends. What is `known` of them is so at the first start, whitened.
    ///
    /// # Errors
    /// When the model has no answer at any start.
    pub(crate) fn end(
        &self,
        predictor: &dyn Predictor,
        hypothesis: &Hypothesis,
        starts: &[Vec<f64>],
        known: Option<Known>,
    ) -> Result<Fit, GapError> {
        self.end_below(f64::INFINITY, predictor, hypothesis, starts, known)
    }

    /// The same, given up where a misfit per value is out of reach.
    ///
    /// # Errors
    /// As [`end`](Self::end).
    pub(crate) fn end_below(
        &self,
        misfit: f64,
        predictor: &dyn Predictor,
        hypothesis: &Hypothesis,
        starts: &[Vec<f64>],
        known: Option<Known>,
    ) -> Result<Fit, GapError> {
        let effort = if misfit.is_finite() {
            Effort::Below(misfit * self.data.len() as f64)
        } else {
            Effort::Contest
        };
        fit_from(
            &self.data,
            predictor,
            hypothesis,
            &self.whitener,
            starts,
            known,
            effort,
        )
    }

    /// The same with the noise taken much larger: the prior holds the soil back until the rest is about right.
    ///
    /// # Errors
    /// When the model has no answer at the start.
    pub(crate) fn held_back(
        &self,
        predictor: &dyn Predictor,
        hypothesis: &Hypothesis,
        start: Vec<f64>,
    ) -> Result<Fit, GapError> {
        self.loosely(&self.loose[0], predictor, hypothesis, start, None)
    }

    /// The same for one effect more, each from where the nominal law was held back: at zero where the tangent there draws it away
    /// from a bound that it has there, else from a place of its own. None where there is no answer.
    pub(crate) fn held_back_with(
        &self,
        predictor: &dyn Predictor,
        null: &Hypothesis,
        effects: &[Arc<dyn AnyEffect>],
        one_sided_from: f64,
    ) -> Vec<Option<Fit>> {
        let noise = &self.loose[0];
        let begun = self.held_back(predictor, null, vec![0.0; null.len()]);
        let there = begun.and_then(|end| {
            let raw = evaluate(&self.data, predictor, null, end.x.as_slice())?;
            Ok((end.x, noise.apply_vector(&raw.residual), noise.apply(&raw.jacobian)))
        });
        let Ok((soil, residual, jacobian)) = there else {
            return vec![None; effects.len()];
        };
        let soil = soil.as_slice();
        let columns = columns(&self.data, predictor, null, soil, effects, noise);
        for_each(effects.len(), |k| {
            let h = null.with(Arc::clone(&effects[k])).ok()?;
            let column = columns[k].as_ref().ok();
            let column = column.filter(|c| c.iter().all(|v| v.is_finite()));
            let one_sided = effects[k].params().first().is_some_and(|p| p.one_sided());
            let mut start = soil.to_vec();
            start.resize(h.len(), 0.0);
            let drawn = column.filter(|c| !one_sided || c.dot(&residual) > 0.0);
            let known = drawn.filter(|_| h.len() == soil.len() + 1).map(|column| Known {
                residual: Some(residual.clone()),
                jacobian: {
                    let mut beside = jacobian.clone().insert_column(soil.len(), 0.0);
                    beside.set_column(soil.len(), column);
                    beside
                },
                exact: true,
            });
            if known.is_none() && one_sided {
                start[soil.len()] = one_sided_from;
            }
            self.loosely(noise, predictor, &h, start, known).ok()
        })
    }

    /// From where a fit that was held back ended down to the noise as it is, given up where a misfit per value is out of reach.
    ///
    /// # Errors
    /// As [`held_back`](Self::held_back).
    pub(crate) fn let_go(
        &self,
        predictor: &dyn Predictor,
        hypothesis: &Hypothesis,
        held_back: &Fit,
        misfit: f64,
    ) -> Result<Fit, GapError> {
        let half_way = self.half_way(predictor, hypothesis, held_back)?;
        let start = half_way.x.as_slice().to_vec();
        self.end_below(misfit, predictor, hypothesis, &[start], None)
    }

    /// From where a fit that was held back ended down to noise that is taken less large.
    ///
    /// # Errors
    /// As [`held_back`](Self::held_back).
    pub(crate) fn half_way(
        &self,
        predictor: &dyn Predictor,
        hypothesis: &Hypothesis,
        held_back: &Fit,
    ) -> Result<Fit, GapError> {
        let start = held_back.x.as_slice().to_vec();
        self.loosely(&self.loose[1], predictor, hypothesis, start, None)
    }

    /// Whether a fit that was held back ended so high that letting it go leads to no such misfit per value.
    ///
    /// With the noise L times larger the least of |r|²/L² + |x|² is c: with the noise as it is no x of a smaller norm than
    /// the prior's leaves less than L² (c - |x|²).
    pub(crate) fn is_beyond(&self, held_back: &Fit, misfit: f64) -> bool {
        self.beyond(LOOSE[0], held_back, misfit)
    }

    /// The same of one half way.
    pub(crate) fn is_beyond_half_way(&self, half_way: &Fit, misfit: f64) -> bool {
        self.beyond(LOOSE[1], half_way, misfit)
    }

    fn beyond(&self, times: f64, fit: &Fit, misfit: f64) -> bool {
        times * times * (fit.cost - FARTHEST_SOIL) > misfit * self.data.len() as f64
    }

    fn loosely(
        &self,
        noise: &Whitener,
        predictor: &dyn Predictor,
        hypothesis: &Hypothesis,
        start: Vec<f64>,
        known: Option<Known>,
    ) -> Result<Fit, GapError> {
        let (data, effort) = (&self.data, Effort::Roughly);
        fit_from(data, predictor, hypothesis, noise, &[start], known, effort)
    }
}
