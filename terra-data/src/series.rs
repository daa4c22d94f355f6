//! One channel of a log, with missing samples as what they are.

/// Samples of one channel; a missing sample is `None`, never a zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    // A missing sample is stored as NaN: one word a sample, and it cannot leave except as `None`.
    values: Vec<f64>,
}

/// Present and missing samples of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MissingCount {
    /// Samples with a value.
    pub present: usize,
    /// Samples without.
    pub missing: usize,
}

impl Series {
    /// An empty series with room for `n` samples.
    pub fn with_capacity(n: usize) -> Self {
        Series {
            values: Vec::with_capacity(n),
        }
    }

    /// Appends a sample; a number that is not finite is a missing one.
    pub fn push(&mut self, value: Option<f64>) {
        self.values
            .push(value.filter(|v| v.is_finite()).unwrap_or(f64::NAN));
    }

    /// Number of samples, missing ones included.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The sample at a row; `None` when missing or beyond the end.
    pub fn get(&self, row: usize) -> Option<f64> {
        self.values.get(row).copied().filter(|v| !v.is_nan())
    }

    /// All samples in order.
    pub fn iter(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        self.values.iter().map(|v| Some(*v).filter(|v| !v.is_nan()))
    }

    /// How many samples are there and how many are not.
    pub fn count(&self) -> MissingCount {
        let missing = self.values.iter().filter(|v| v.is_nan()).count();
        MissingCount {
            present: self.values.len() - missing,
            missing,
        }
    }
}

impl FromIterator<Option<f64>> for Series {
    fn from_iter<I: IntoIterator<Item = Option<f64>>>(iter: I) -> Self {
        let mut series = Series::default();
        for value in iter {
            series.push(value);
        }
        series
    }
}
