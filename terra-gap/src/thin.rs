//! A drive's windows thinned out: fits that come from far go most of their way on these, and only end on all.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_model::AnyEffect;

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::fit::{Effort, Fit, Known, evaluate, fit_from};
use crate::hypothesis::Hypothesis;
use crate::noise::{NoiseModel, Whitener};
use crate::predictor::Predictor;
use crate::signatures::{Place, columns};

/// How many times the noise is taken larger where the prior is to hold the soil back: first, and on the way down.
const LOOSE: [f64; 2] = [10.0, 3.0];

/// |x|² of a soil and effects as far as they are believed: eight at two and a half prior sd.
const FARTHEST_SOIL: f64 = 50.0;

/// The nominal law's end on few windows, with the signatures of effects there.
pub(crate) struct Begun {
    /// Its end, by the law's own slopes.
    pub(crate) end: Fit,
    /// Signatures, where an effect can stand in the law.
    columns: Vec<Option<DVector<f64>>>,
}

impl Begun {
    /// A start of one effect more, and what is known there: at zero, or for one that has its bound there and is not drawn away from
    /// it at a size of its own.
    pub(crate) fn start_of(
        &self,
        effect: usize,
        one_sided: Option<f64>,
    ) -> (Vec<f64>, Option<Known>) {
        let soil = self.end.x.len();
        let mut start = self.end.x.as_slice().to_vec();
        let column = self.columns.get(effect).and_then(|c| c.as_ref());
        let drawn = column.filter(|c| one_sided.is_none() || c.dot(&self.end.residual) > 0.0);
        let Some(column) = drawn else {
            start.push(one_sided.unwrap_or(0.0));
            return (start, None);
        };
        start.push(0.0);
        let mut beside = DMatrix::clone(&self.end.jacobian).insert_column(soil, 0.0);
        beside.set_column(soil, column);
        (start, Some(self.end.known(beside)))
    }
}

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
    /// Windows to look around on, and for the way of a fit.
    pub(crate) const WINDOWS: usize = 32;

    /// Every second, third ... window, of which at least [`WINDOWS`](Self::WINDOWS) are kept; all of them where the log is short
    /// already.
    ///
    /// # Errors
    /// A covariance that is not positive definite.
    pub(crate) fn new(data: &DataSet, noise: &NoiseModel) -> Result<Self, GapError> {
        let every = (data.observations.len() / Self::WINDOWS).max(1);
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

    /// Where a fit to all windows goes on to on these alone: not far.
    ///
    /// # Errors
    /// As [`end`](Self::end).
    pub(crate) fn end_of(
        &self,
        predictor: &dyn Predictor,
        hypothesis: &Hypothesis,
        fit: &Fit,
    ) -> Result<Fit, GapError> {
        let known = self.part_of(&fit.known(fit.jacobian.clone()));
        self.end(predictor, hypothesis, &[fit.x.as_slice().to_vec()], known)
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
        known: Option<Known>,
    ) -> Result<Fit, GapError> {
        self.loosely(&self.loose[0], predictor, hypothesis, start, known)
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
        let end = held_back.x.as_slice().to_vec();
        let half_way = self.half_way(predictor, hypothesis, end, None)?;
        let start = half_way.x.as_slice().to_vec();
        self.end_below(misfit, predictor, hypothesis, &[start], None)
    }

    /// With the noise taken less large, from where a fit that was held back ended.
    ///
    /// # Errors
    /// As [`held_back`](Self::held_back).
    pub(crate) fn half_way(
        &self,
        predictor: &dyn Predictor,
        hypothesis: &Hypothesis,
        start: Vec<f64>,
        known: Option<Known>,
    ) -> Result<Fit, GapError> {
        self.loosely(&self.loose[1], predictor, hypothesis, start, known)
    }

    /// Where the nominal law ends with the noise taken much larger, and the signatures of effects there.
    ///
    /// # Errors
    /// When it has no answer there.
    pub(crate) fn begin(
        &self,
        predictor: &dyn Predictor,
        null: &Hypothesis,
        effects: &[Arc<dyn AnyEffect>],
    ) -> Result<Begun, GapError> {
        let end = self.held_back(predictor, null, vec![0.0; null.len()], None)?;
        self.begun(&self.loose[0], predictor, null, &end, effects)
    }

    /// The same with the noise taken less large.
    ///
    /// # Errors
    /// As [`begin`](Self::begin).
    pub(crate) fn begin_half_way(
        &self,
        predictor: &dyn Predictor,
        null: &Hypothesis,
        begun: &Begun,
        effects: &[Arc<dyn AnyEffect>],
    ) -> Result<Begun, GapError> {
        let start = begun.end.x.as_slice().to_vec();
        let end = self.half_way(predictor, null, start, None)?;
        self.begun(&self.loose[1], predictor, null, &end, effects)
    }

    fn begun(
        &self,
        noise: &Whitener,
        predictor: &dyn Predictor,
        null: &Hypothesis,
        end: &Fit,
        effects: &[Arc<dyn AnyEffect>],
    ) -> Result<Begun, GapError> {
        let x = end.x.as_slice();
        let here = evaluate(&self.data, predictor, null, x, &end.near)?;
        let end = Fit {
            residual: noise.apply_vector(&here.residual),
            jacobian: noise.apply(&here.jacobian).into(),
            exact: true,
            ..end.clone()
        };
        let at = Place::of(&end);
        let columns = columns(&self.data, predictor, null, &at, effects, noise);
        let finite = |c: &DVector<f64>| c.iter().all(|v| v.is_finite());
        // What a flat effect does at a size of its own is no slope at zero.
        let own = |(c, effect): (Result<DVector<f64>, String>, &Arc<dyn AnyEffect>)| {
            c.ok().filter(|c| finite(c) && !effect.is_flat())
        };
        Ok(Begun {
            end,
            columns: columns.into_iter().zip(effects).map(own).collect(),
        })
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

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::memory::Remembered;

    /// Data that lie above the law draw an effect that raises it away from zero, and one that lowers it against its bound: that one
    /// begins at a size of its own, unless it has no bound. One that cannot stand in the law is asked by itself.
    #[test]
    fn an_effect_begins_where_the_nominal_law_ended() {
        let column = |slope: f64| Some(DVector::from_vec(vec![slope, 0.0]));
        let begun = Begun {
            end: Fit {
                x: DVector::from_element(1, 0.3),
                residual: DVector::from_vec(vec![2.0, 0.0]),
                jacobian: DMatrix::from_element(2, 1, 1.0).into(),
                exact: true,
                tangent: false,
                cost: 4.09,
                converged: true,
                given_up: false,
                log_det: 0.0,
                at_bound: vec![false],
                near: Remembered::default(),
            },
            columns: vec![column(1.0), column(-1.0), None],
        };
        let (start, known) = begun.start_of(0, Some(0.5));
        let known = known.unwrap();
        assert_eq!((start, known.exact), (vec![0.3, 0.0], true));
        assert_eq!(known.residual, Some(begun.end.residual.clone()));
        assert_eq!(known.jacobian.column(1), DVector::from_vec(vec![1.0, 0.0]));
        let (start, known) = begun.start_of(1, Some(0.5));
        assert!(start == [0.3, 0.5] && known.is_none());
        let (start, known) = begun.start_of(1, None);
        assert!(start == [0.3, 0.0] && known.is_some());
        let (start, known) = begun.start_of(2, None);
        assert!(start == [0.3, 0.0] && known.is_none());
    }
}
