//! What predicts a log: from the law and the raw measurements to residuals, with derivatives.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::DMatrix;
use terra_model::{LaneDual, Lanes, Law, Real, Scalar, Vector};

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::memory::Memory;
use crate::parallel::try_for_each;

/// A residual and its slopes in up to [`LaneDual::SLOPES`] variables.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sloped {
    pub(crate) value: f64,
    pub(crate) slopes: [f64; LaneDual::SLOPES],
}

impl Sloped {
    /// What one lane has.
    pub(crate) fn of_lane(residual: &LaneDual, lane: usize) -> Self {
        Sloped {
            value: residual.primal().lane(lane),
            slopes: std::array::from_fn(|k| residual.slope(k, lane)),
        }
    }
}

/// A raw quantity, which varies where its place is one of these.
pub(crate) fn varying(place: usize, value: Lanes, varied: &Range<usize>) -> LaneDual {
    if varied.contains(&place) {
        LaneDual::variable(value, place - varied.start)
    } else {
        LaneDual::from_primal(value)
    }
}

/// Residuals of an observation, and their derivatives in all of its raw quantities (values x raw).
pub(crate) type RawSlopes = (Vec<f64>, DMatrix<f64>);

/// Those of observations at what their raw quantities are now.
///
/// # Errors
/// Where the model has no answer.
pub(crate) fn raw_slopes(
    predictor: &dyn Predictor,
    law: &Law,
    p: &[f64],
    indices: &[usize],
) -> Result<Vec<RawSlopes>, GapError> {
    let p: Vec<LaneDual> = p.iter().map(|&v| LaneDual::from(v)).collect();
    let lengths: Vec<usize> = indices.iter().map(|&i| predictor.raw(i).len()).collect();
    let most = lengths.iter().copied().max().unwrap_or(0);
    let mut out: Vec<RawSlopes> = vec![];
    let memory = Memory::of(predictor.contacts());
    for start in (0..most).step_by(LaneDual::SLOPES) {
        let varied = start..most.min(start + LaneDual::SLOPES);
        let found = predictor.slopes(law, &p, &varied, indices, &memory)?;
        if start == 0 {
            let empty = |(values, &length): (&Vec<Sloped>, &usize)| {
                let residual = values.iter().map(|s| s.value).collect();
                (residual, DMatrix::zeros(values.len(), length))
            };
            out = found.iter().zip(&lengths).map(empty).collect();
        }
        for ((_, d), values) in out.iter_mut().zip(found) {
            for (row, sloped) in values.iter().enumerate() {
                let ends = varied.end.min(d.ncols());
                for (column, slope) in (start..ends).zip(sloped.slopes) {
                    d[(row, column)] = slope;
                }
            }
        }
    }
    Ok(out)
}

/// A raw quantity that gives way to a push of the ground: a wheel is braked until the ground drives it as before.
pub(crate) struct Yielding {
    /// The quantity, by its place.
    pub(crate) raw: usize,
    /// The value whose balance the push enters, by its place.
    pub(crate) value: usize,
    /// How much of that value it takes to change the quantity by one within the observation.
    pub(crate) inertia: f64,
}

/// The residual of one observation as a function of the raw measurements, so that input noise can be propagated: what a kind of
/// log implements, once for every number.
pub(crate) trait Predict: Clone + Sync + Send + 'static {
    /// Raw quantities (values and inputs) of an observation.
    fn raw(&self, index: usize) -> Vec<f64>;

    /// How many of these were read, the first ones; what stands behind them is assumed.
    fn read(&self, _index: usize) -> usize {
        usize::MAX
    }

    /// What gives way where the ground pushes within an observation.
    fn yielding(&self, _index: usize) -> Vec<Yielding> {
        vec![]
    }

    /// The slip that raw quantities say, where it is one of them.
    fn slip(&self, _index: usize, _raw: &[f64]) -> Option<f64> {
        None
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

    /// How many contacts a solver is asked for, each at a place of its own in a [`Memory`].
    fn contacts(&self) -> usize {
        0
    }

    /// Residuals of many observations at what was measured.
    ///
    /// # Errors
    /// As [`residual`](Self::residual).
    fn residuals(
        &self,
        law: &Law,
        p: &[f64],
        indices: &[usize],
        _memory: &Memory,
    ) -> Result<Vec<Vec<f64>>, GapError> {
        try_for_each(indices.len(), |k| {
            Predict::residual(self, law, p, indices[k], &Predict::raw(self, indices[k]))
        })
    }

    /// The same with their slopes in what varies: the parameters as they say, and these raw quantities in their order.
    ///
    /// # Errors
    /// As [`residual`](Self::residual).
    fn slopes(
        &self,
        law: &Law,
        p: &[LaneDual],
        varied: &Range<usize>,
        indices: &[usize],
        _memory: &Memory,
    ) -> Result<Vec<Vec<Sloped>>, GapError> {
        try_for_each(indices.len(), |k| {
            let raw = Predict::raw(self, indices[k]).into_iter().enumerate();
            let raw: Vec<LaneDual> = raw.map(|(k, x)| varying(k, x.into(), varied)).collect();
            let found = Predict::residual(self, law, p, indices[k], &raw)?;
            Ok(found.iter().map(|r| Sloped::of_lane(r, 0)).collect())
        })
    }

    /// Where the values of an observation stand in `raw`, in their order.
    fn value_positions(&self, index: usize) -> Vec<usize>;

    /// The same with other raw quantities for some observations.
    #[must_use]
    fn with_raw(&self, replaced: &[(usize, Vec<f64>)]) -> Self;

    /// The same of a vehicle whose load goes to the outer wheels in turns where it does not here, or the other way round; none where
    /// that makes no difference.
    fn otherwise_loaded(&self) -> Option<Self> {
        None
    }

    /// The same on ground that shifts these shares of the wheels' loads between the two diagonals, one an observation by its number;
    /// none where there are no four wheels.
    fn swung(&self, _swings: &[f64]) -> Option<Self> {
        None
    }

    /// What it takes for granted that is not so of every vehicle.
    fn assumes(&self) -> Option<&'static str> {
        None
    }

    /// The same where the path that a log does not tell, or the passes that it does, are counted another way.
    fn other_ways(&self) -> Vec<OtherWay> {
        vec![]
    }

    /// Experiments that could be made with this vehicle or rig, as variations of the data at hand.
    fn designs(&self, data: &DataSet) -> Vec<Design>;
}

/// A predictor of any kind of log, by which the whole of the diagnosis is compiled once.
pub(crate) trait Predictor: Sync + Send {
    /// As [`Predict::raw`].
    fn raw(&self, index: usize) -> Vec<f64>;

    /// As [`Predict::read`].
    fn read(&self, index: usize) -> usize;

    /// As [`Predict::yielding`].
    fn yielding(&self, index: usize) -> Vec<Yielding>;

    /// As [`Predict::slip`].
    fn slip(&self, index: usize, raw: &[f64]) -> Option<f64>;

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

    /// As [`Predict::contacts`].
    fn contacts(&self) -> usize;

    /// As [`Predict::residuals`].
    ///
    /// # Errors
    /// As there.
    fn residuals(
        &self,
        law: &Law,
        p: &[f64],
        indices: &[usize],
        memory: &Memory,
    ) -> Result<Vec<Vec<f64>>, GapError>;

    /// As [`Predict::slopes`].
    ///
    /// # Errors
    /// As there.
    fn slopes(
        &self,
        law: &Law,
        p: &[LaneDual],
        varied: &Range<usize>,
        indices: &[usize],
        memory: &Memory,
    ) -> Result<Vec<Vec<Sloped>>, GapError>;

    /// As [`Predict::value_positions`].
    fn value_positions(&self, index: usize) -> Vec<usize>;

    /// As [`Predict::with_raw`].
    #[must_use]
    fn with_raw(&self, replaced: &[(usize, Vec<f64>)]) -> AnyPredictor;

    /// As [`Predict::otherwise_loaded`].
    fn otherwise_loaded(&self) -> Option<AnyPredictor>;

    /// As [`Predict::swung`].
    fn swung(&self, swings: &[f64]) -> Option<AnyPredictor>;

    /// As [`Predict::assumes`].
    fn assumes(&self) -> Option<&'static str>;

    /// As [`Predict::other_ways`].
    fn other_ways(&self) -> Vec<OtherWay>;

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

    fn yielding(&self, index: usize) -> Vec<Yielding> {
        Predict::yielding(self, index)
    }

    fn slip(&self, index: usize, raw: &[f64]) -> Option<f64> {
        Predict::slip(self, index, raw)
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

    fn contacts(&self) -> usize {
        Predict::contacts(self)
    }

    fn residuals(
        &self,
        law: &Law,
        p: &[f64],
        indices: &[usize],
        memory: &Memory,
    ) -> Result<Vec<Vec<f64>>, GapError> {
        Predict::residuals(self, law, p, indices, memory)
    }

    fn slopes(
        &self,
        law: &Law,
        p: &[LaneDual],
        varied: &Range<usize>,
        indices: &[usize],
        memory: &Memory,
    ) -> Result<Vec<Vec<Sloped>>, GapError> {
        Predict::slopes(self, law, p, varied, indices, memory)
    }

    fn value_positions(&self, index: usize) -> Vec<usize> {
        Predict::value_positions(self, index)
    }

    fn with_raw(&self, replaced: &[(usize, Vec<f64>)]) -> AnyPredictor {
        Arc::new(Predict::with_raw(self, replaced))
    }

    fn otherwise_loaded(&self) -> Option<AnyPredictor> {
        let other = Predict::otherwise_loaded(self)?;
        Some(Arc::new(other))
    }

    fn swung(&self, swings: &[f64]) -> Option<AnyPredictor> {
        let swung = Predict::swung(self, swings)?;
        Some(Arc::new(swung))
    }

    fn assumes(&self) -> Option<&'static str> {
        Predict::assumes(self)
    }

    fn other_ways(&self) -> Vec<OtherWay> {
        Predict::other_ways(self)
    }

    fn designs(&self, data: &DataSet) -> Vec<Design> {
        Predict::designs(self, data)
    }
}

/// Another way in which path or passes may be counted.
pub(crate) struct OtherWay {
    /// How.
    pub told: &'static str,
    /// What of.
    pub counts: Counts,
    /// Predicts by it.
    pub predictor: AnyPredictor,
}

/// What may be counted otherwise.
pub(crate) enum Counts {
    /// The path, forwards and back alike: that of each observation \[m\].
    Odometer(Vec<f64>),
    /// The path of a position.
    Position(Vec<f64>),
    /// Earlier passes over a track.
    Passes,
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
