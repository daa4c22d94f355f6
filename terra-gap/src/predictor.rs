//! What predicts a log: from the law and the raw measurements to residuals, with derivatives.

use std::sync::Arc;

use terra_model::{Dual8, Dual16, Law, Scalar};

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::parallel::for_each;

/// The residual of one observation as a function of the raw measurements, so that input noise can be propagated: what a kind of
/// log implements, once for every number.
pub(crate) trait Predict: Clone + Sync + Send + 'static {
    /// Raw quantities (values and inputs) of an observation.
    fn raw(&self, index: usize) -> Vec<f64>;

    /// How many of these were read, the first ones; what stands behind them is assumed.
    fn read(&self, _index: usize) -> usize {
        usize::MAX
    }

    /// Residual `values - prediction` at raw measurements `raw` and parameters `p` of the law.
    ///
    /// # Errors
    /// A typed error where the model has no answer.
    fn residual<T: Scalar>(
        &self,
        law: &Law,
        p: &[T],
        index: usize,
        raw: &[T],
    ) -> Result<Vec<T>, GapError>;

    /// Residuals of many observations at what was measured.
    ///
    /// # Errors
    /// As [`residual`](Self::residual).
    fn residuals(
        &self,
        law: &Law,
        p: &[f64],
        indices: &[usize],
    ) -> Result<Vec<Vec<f64>>, GapError> {
        for_each(indices.len(), |k| {
            Predict::residual(self, law, p, indices[k], &Predict::raw(self, indices[k]))
        })
        .into_iter()
        .collect()
    }

    /// Where the values of an observation stand in `raw`, in their order.
    fn value_positions(&self, index: usize) -> Vec<usize>;

    /// The same with other raw quantities for some observations.
    #[must_use]
    fn with_raw(&self, replaced: &[(usize, Vec<f64>)]) -> Self;

    /// Experiments that could be made with this vehicle or rig, as variations of the data at hand.
    fn designs(&self, data: &DataSet) -> Vec<Design>;
}

/// A predictor of any kind of log, by which the whole of the diagnosis is compiled once.
pub(crate) trait Predictor: Sync + Send {
    /// As [`Predict::raw`].
    fn raw(&self, index: usize) -> Vec<f64>;

    /// As [`Predict::read`].
    fn read(&self, index: usize) -> usize;

    /// As [`Predict::residual`].
    ///
    /// # Errors
    /// As there.
    fn residual(
        &self,
        law: &Law,
        p: &[f64],
        index: usize,
        raw: &[f64],
    ) -> Result<Vec<f64>, GapError>;

    /// The same with eight derivatives.
    ///
    /// # Errors
    /// As there.
    fn residual8(
        &self,
        law: &Law,
        p: &[Dual8],
        index: usize,
        raw: &[Dual8],
    ) -> Result<Vec<Dual8>, GapError>;

    /// The same with sixteen.
    ///
    /// # Errors
    /// As there.
    fn residual16(
        &self,
        law: &Law,
        p: &[Dual16],
        index: usize,
        raw: &[Dual16],
    ) -> Result<Vec<Dual16>, GapError>;

    /// As [`Predict::residuals`].
    ///
    /// # Errors
    /// As there.
    fn residuals(&self, law: &Law, p: &[f64], indices: &[usize])
    -> Result<Vec<Vec<f64>>, GapError>;

    /// As [`Predict::value_positions`].
    fn value_positions(&self, index: usize) -> Vec<usize>;

    /// As [`Predict::with_raw`].
    #[must_use]
    fn with_raw(&self, replaced: &[(usize, Vec<f64>)]) -> AnyPredictor;

    /// As [`Predict::designs`].
    fn designs(&self, data: &DataSet) -> Vec<Design>;
}

/// A predictor that is shared.
pub(crate) type AnyPredictor = Arc<dyn Predictor>;

impl<K: Predict> Predictor for K {
    fn raw(&self, index: usize) -> Vec<f64> {
        Predict::raw(self, index)
    }

    fn read(&self, index: usize) -> usize {
        Predict::read(self, index)
    }

    fn residual(
        &self,
        law: &Law,
        p: &[f64],
        index: usize,
        raw: &[f64],
    ) -> Result<Vec<f64>, GapError> {
        Predict::residual(self, law, p, index, raw)
    }

    fn residual8(
        &self,
        law: &Law,
        p: &[Dual8],
        index: usize,
        raw: &[Dual8],
    ) -> Result<Vec<Dual8>, GapError> {
        Predict::residual(self, law, p, index, raw)
    }

    fn residual16(
        &self,
        law: &Law,
        p: &[Dual16],
        index: usize,
        raw: &[Dual16],
    ) -> Result<Vec<Dual16>, GapError> {
        Predict::residual(self, law, p, index, raw)
    }

    fn residuals(
        &self,
        law: &Law,
        p: &[f64],
        indices: &[usize],
    ) -> Result<Vec<Vec<f64>>, GapError> {
        Predict::residuals(self, law, p, indices)
    }

    fn value_positions(&self, index: usize) -> Vec<usize> {
        Predict::value_positions(self, index)
    }

    fn with_raw(&self, replaced: &[(usize, Vec<f64>)]) -> AnyPredictor {
        Arc::new(Predict::with_raw(self, replaced))
    }

    fn designs(&self, data: &DataSet) -> Vec<Design> {
        Predict::designs(self, data)
    }
}

/// One design: what to do, and the data set it would give with the predictor of its rows.
pub(crate) struct Design {
    /// In words.
    pub manoeuvre: String,
    /// Its observations; measured values are not used.
    pub data: DataSet,
    /// Their predictor.
    pub predictor: AnyPredictor,
}
