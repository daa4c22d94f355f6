//! The measured data as the diagnosis core sees it: observations, each a few values that belong together.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::uneven::Uneven;

/// One channel of the data.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelInfo {
    /// Contract name with unit suffix (`drawbar_pull_N`).
    pub name: String,
    /// Unit.
    pub unit: &'static str,
    /// Typical size of the channel, for the amplitude of a discrepancy: W, W R, 2 median z, m g.
    pub scale: f64,
}

/// Where in the regime an observation lies: slip, load, speed, pass, ... by name.
pub type Factors = BTreeMap<&'static str, f64>;

/// From where to where each factor goes.
pub(crate) type Ranges = BTreeMap<&'static str, (f64, f64)>;

/// One observation: a rig row or a window of a drive.
#[derive(Clone, Debug, Default)]
pub struct Observation {
    /// Its number in the predictor.
    pub index: usize,
    /// Group for holding out (trial, segment, condition).
    pub group: String,
    /// Wheel or soil variant.
    pub condition: String,
    /// Line of the file or time \[s\], for messages.
    pub place: String,
    /// Which channel each value belongs to (index into the data set's channels).
    pub channels: Vec<usize>,
    /// Measured values, one a channel.
    pub values: Vec<f64>,
    /// 1-sigma of each raw quantity the residual depends on: values first, then inputs.
    pub raw_sd: Vec<f64>,
    /// For inputs that are taken where they most probably were.
    pub(crate) shift: Shift,
    /// What a residual gains for effects that a simulator's log shows too, or for loads that are taken where they most probably were, one
    /// a value; empty where it gains nothing.
    pub(crate) carried: Vec<f64>,
    /// Regime.
    pub factors: Factors,
}

/// What an observation has beside its predictor where its inputs are taken where they most probably were; nothing where they are
/// taken as they were read.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shift {
    /// What a residual gains, one a value.
    pub(crate) values: Vec<f64>,
    /// Slip there, where slip is such an input: along it a wheel law's error is smooth.
    pub(crate) slip: Option<f64>,
}

impl Observation {
    /// What each value's residual gains beside the model's own.
    pub(crate) fn added(&self) -> impl Iterator<Item = f64> + '_ {
        let of = |v: &[f64], k: usize| v.get(k).copied().unwrap_or(0.0);
        (0..self.channels.len()).map(move |k| of(&self.shift.values, k) + of(&self.carried, k))
    }
}

/// Everything measured, with its channels.
#[derive(Clone, Debug, Default)]
pub struct DataSet {
    /// Channels in use.
    pub channels: Vec<ChannelInfo>,
    /// Observations.
    pub observations: Vec<Observation>,
    /// What was left out, by reason.
    pub dropped: BTreeMap<String, usize>,
    /// What the reader of a result should know.
    pub notes: Vec<String>,
    /// Variance of a value by what scatters inside an observation beyond the sensor's noise, where a channel shows it.
    pub short_scatter: Vec<Option<f64>>,
    /// How uneven the ground is under single wheels, where that is known.
    pub(crate) uneven: Option<Arc<Uneven>>,
}

impl DataSet {
    /// Number of measured values.
    pub fn len(&self) -> usize {
        self.observations.iter().map(|o| o.values.len()).sum()
    }

    /// True without values.
    pub fn is_empty(&self) -> bool {
        self.observations.is_empty()
    }

    /// The same data with only some observations.
    #[must_use]
    pub fn subset(&self, keep: &[usize]) -> Self {
        DataSet {
            channels: self.channels.clone(),
            observations: keep.iter().map(|&i| self.observations[i].clone()).collect(),
            dropped: self.dropped.clone(),
            notes: self.notes.clone(),
            short_scatter: self.short_scatter.clone(),
            uneven: self.uneven.clone(),
        }
    }

    /// Names of the groups in order of appearance.
    pub fn groups(&self) -> Vec<String> {
        let mut groups: Vec<String> = Vec::new();
        for o in &self.observations {
            if !groups.contains(&o.group) {
                groups.push(o.group.clone());
            }
        }
        groups
    }

    /// From where to where a factor goes, where some observation has it.
    pub(crate) fn range_of(&self, factor: &str) -> Option<(f64, f64)> {
        let each = self
            .observations
            .iter()
            .filter_map(|o| o.factors.get(factor));
        let from = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = each.fold(from, |(a, b), v| (a.min(*v), b.max(*v)));
        (low <= high).then_some((low, high))
    }

    /// The same of all factors.
    pub(crate) fn ranges(&self) -> Ranges {
        let names = self
            .observations
            .iter()
            .flat_map(|o| o.factors.keys().copied());
        let names: std::collections::BTreeSet<&str> = names.collect();
        let of = |name| Some((name, self.range_of(name)?));
        names.into_iter().filter_map(of).collect()
    }

    /// Observation and channel of each stacked value.
    pub fn stacked(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.observations
            .iter()
            .enumerate()
            .flat_map(|(i, o)| o.channels.iter().map(move |&c| (i, c)))
    }
}

/// Residual and Jacobian of stacked values.
#[derive(Clone, Debug)]
pub(crate) struct Stacked {
    /// values - prediction (n).
    pub residual: DVector<f64>,
    /// d prediction / d fit vector (n x d).
    pub jacobian: DMatrix<f64>,
}
