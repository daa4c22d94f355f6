//! A drive's windows thinned out: fits that come from far go most of their way on these, and only end on all.

use nalgebra::DMatrix;

use crate::dataset::{DataSet, Predictor};
use crate::error::GapError;
use crate::fit::{Effort, fit_from};
use crate::hypothesis::Hypothesis;
use crate::noise::{NoiseModel, Whitener};

/// Windows that are kept at least, spread over the whole log.
const KEPT: usize = 64;

/// Some windows of a log with their noise.
pub(crate) struct Thin {
    data: DataSet,
    whitener: Whitener,
    /// Which of all stacked values they hold; none where the noise ties windows together.
    rows: Option<Vec<usize>>,
}

impl Thin {
    /// Every second, third ... window; none where the log is short already.
    ///
    /// # Errors
    /// A covariance that is not positive definite.
    pub(crate) fn new(data: &DataSet, noise: &NoiseModel) -> Result<Option<Self>, GapError> {
        let every = data.observations.len() / KEPT;
        if every < 2 {
            return Ok(None);
        }
        let kept = |i: usize| i % every == every / 2;
        let keep: Vec<usize> = (0..data.observations.len()).filter(|i| kept(*i)).collect();
        let rows = data.stacked().enumerate();
        let rows = rows.filter(|(_, (i, _))| kept(*i)).map(|(row, _)| row);
        let rows = noise.is_separate().then(|| rows.collect());
        let data = data.subset(&keep);
        let whitener = noise.subset(&keep).whitener(&data)?;
        Ok(Some(Thin {
            data,
            whitener,
            rows,
        }))
    }

    /// Where a fit to these windows ends. `guess` is a whitened Jacobian of all values at the first start.
    ///
    /// # Errors
    /// When the model has no answer at any start.
    pub(crate) fn end<P: Predictor>(
        &self,
        predictor: &P,
        hypothesis: &Hypothesis,
        starts: &[Vec<f64>],
        guess: Option<&DMatrix<f64>>,
    ) -> Result<Vec<f64>, GapError> {
        let slopes = guess.zip(self.rows.as_ref());
        let slopes = slopes.map(|(guess, rows)| guess.select_rows(rows));
        let fit = fit_from(
            &self.data,
            predictor,
            hypothesis,
            &self.whitener,
            starts,
            slopes,
            Effort::Contest,
        )?;
        Ok(fit.x.as_slice().to_vec())
    }
}
