//! Where the gap is: channel x regime, after the soil was re-fitted.

use serde::Serialize;
use terra_model::order::{ascending, descending};

use crate::dataset::DataSet;
use crate::fit::Fit;

/// One place where the re-fitted model still differs from the data.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Place {
    /// Channel.
    pub channel: String,
    /// Factor along which it was found (slip, load, ...).
    pub factor: String,
    /// Start of the range.
    pub from: f64,
    /// End of the range.
    pub to: f64,
    /// Share of the whole whitened misfit that lies here.
    pub share: f64,
    /// Mean of measured less predicted, in the channel's unit.
    pub bias: f64,
    /// How many standard deviations the mean is from zero, after correction for the number of places looked at.
    pub sigma: f64,
    /// Unit of the bias.
    pub unit: String,
}

const BINS: usize = 5;
/// Corrected significance below which a place is not worth a word.
const THRESHOLD: f64 = 2.5;

/// The places of a fit, largest share first.
pub(crate) fn places(data: &DataSet, fit: &Fit, raw_residual: &[f64]) -> Vec<Place> {
    let stacked: Vec<(usize, usize)> = data.stacked().collect();
    let total = fit.chi2().max(f64::MIN_POSITIVE);
    let mut found = vec![];
    let mut looked = 0usize;
    for (c, channel) in data.channels.iter().enumerate() {
        for factor in [
            "slip", "load", "speed", "pass", "path", "yaw_rate", "turning",
        ] {
            let mut points: Vec<(f64, usize)> = stacked
                .iter()
                .enumerate()
                .filter(|(_, (_, channel))| *channel == c)
                .filter_map(|(row, (i, _))| {
                    Some((*data.observations[*i].factors.get(factor)?, row))
                })
                .collect();
            ascending(&mut points, |p| p.0);
            let (Some(first), Some(last)) = (points.first(), points.last()) else {
                continue;
            };
            if last.0 - first.0 <= 1e-3 * last.0.abs().max(first.0.abs()) {
                continue;
            }
            for bin in split(&points) {
                looked += 1;
                let n = bin.len() as f64;
                let sse: f64 = bin.iter().map(|(_, row)| fit.residual[*row].powi(2)).sum();
                let mean = bin.iter().map(|(_, row)| fit.residual[*row]).sum::<f64>() / n.sqrt();
                found.push(Place {
                    channel: channel.name.clone(),
                    factor: factor.to_owned(),
                    from: bin.first().map_or(0.0, |p| p.0),
                    to: bin.last().map_or(0.0, |p| p.0),
                    share: sse / total,
                    bias: bin.iter().map(|(_, row)| raw_residual[*row]).sum::<f64>() / n,
                    sigma: mean.abs(),
                    unit: channel.unit.to_owned(),
                });
            }
        }
    }
    // Bonferroni on the Gaussian scale: |z| loses sqrt(2 ln m), the typical largest of m null values.
    let correction = (2.0 * (looked.max(2) as f64).ln()).sqrt();
    for place in &mut found {
        place.sigma = (place.sigma.powi(2) - correction.powi(2)).max(0.0).sqrt();
    }
    found.retain(|p| p.sigma > THRESHOLD);
    descending(&mut found, |f| f.share);
    found.truncate(8);
    found
}

/// Bins of about equal count, never splitting equal values.
fn split(points: &[(f64, usize)]) -> Vec<&[(f64, usize)]> {
    let size = points.len().div_ceil(BINS).max(1);
    let mut bins = vec![];
    let mut start = 0;
    while start < points.len() {
        let mut end = (start + size).min(points.len());
        while end < points.len() && (points[end].0 - points[end - 1].0).abs() < 1e-6 {
            end += 1;
        }
        bins.push(&points[start..end]);
        start = end;
    }
    bins
}
