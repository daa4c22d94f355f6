//! What goes into an update and what comes out of it.

use crate::channels::Channels;

/// One sample of all channels. A missing channel is `None`: its row is dropped from the update.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    values: Channels,
}

impl Measurement {
    /// A sample with missing channels; a number that is not finite counts as missing.
    pub fn new(values: &[Option<f64>]) -> Self {
        let finite = |v: &Option<f64>| v.filter(|x| x.is_finite());
        Measurement {
            values: values.iter().map(finite).collect(),
        }
    }

    /// A sample of all channels; NaN and infinity count as missing.
    pub fn full(values: &[f64]) -> Self {
        let finite = |v: &f64| Some(*v).filter(|x| x.is_finite());
        Measurement {
            values: values.iter().map(finite).collect(),
        }
    }

    /// Number of channels, missing ones included.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// True without channels.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// One channel.
    pub fn get(&self, channel: usize) -> Option<f64> {
        self.values.get(channel)
    }

    /// The channels that are there, ascending.
    pub fn present(&self) -> Vec<usize> {
        self.values.present().collect()
    }

    /// Channel after channel, NaN where one is missing.
    pub(crate) fn as_slice(&self) -> &[f64] {
        self.values.as_slice()
    }
}

/// What one update says about the filter.
///
/// # Law
/// When model and noise match the data, the `whitened` values are independent and standard normal, across channels and
/// across time, and `nis` is chi-square with `dof` degrees of freedom. All of these are computed with the nominal
/// noise: a robust update changes what the state learns, never what the alarm sees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Innovation {
    /// ν = z - predicted z, unit of z; `None` where the channel is missing.
    pub residual: Channels,
    /// sqrt(S_ii), unit of z.
    pub sd: Channels,
    /// L⁻¹ ν with S = L Lᵀ over the channels present, in their order: standard normal.
    pub whitened: Channels,
    /// |ν_i| / (gate sqrt(S_ii)): above 1 the channel is outside its gate.
    pub ratio: Channels,
    /// S_ii used in the robust update over the nominal S_ii; 1 without robust update.
    pub inflation: Channels,
    /// νᵀ S⁻¹ ν.
    pub nis: f64,
    /// Channels used.
    pub dof: usize,
    /// ln N(ν; 0, S).
    pub log_likelihood: f64,
    /// Channels whose states were reset to the prior covariance in this update, after a timeout of rejections.
    pub resets: Vec<usize>,
    /// Channels left out because their reading is absurd: so far off that a robust update would give it no weight a
    /// number could hold. They have a `ratio` and are not in `nis` and `dof`.
    pub dropped: Vec<usize>,
}

impl Innovation {
    /// No channel present.
    pub(crate) fn empty(channels: usize) -> Self {
        Innovation {
            residual: Channels::none(channels),
            sd: Channels::none(channels),
            whitened: Channels::none(channels),
            ratio: Channels::none(channels),
            inflation: Channels::none(channels),
            ..Innovation::default()
        }
    }

    /// Channels outside their gate.
    pub fn outside_gate(&self) -> Vec<usize> {
        let outside = |i: &usize| self.ratio.get(*i).is_some_and(|r| r > 1.0);
        (0..self.ratio.len()).filter(outside).collect()
    }
}
