//! Rates, resampled intervals, calibration error and the area under a curve.

use serde_json::{Map, Value, json};

use super::random::Draws;
use crate::campaign::Rate;

/// A figure with its 95 % interval and the number of cases behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// None when it cannot be given.
    pub value: Option<f64>,
    /// Lower end.
    pub lo: Option<f64>,
    /// Upper end.
    pub hi: Option<f64>,
    /// Cases.
    pub n: usize,
    /// Why there is no value.
    pub reason: Option<String>,
}

impl Metric {
    pub(crate) fn missing(reason: impl Into<String>) -> Self {
        Metric {
            value: None,
            lo: None,
            hi: None,
            n: 0,
            reason: Some(reason.into()),
        }
    }

    /// The share of true ones, with Wilson's interval.
    pub(crate) fn rate(hits: &[bool], of: &str) -> Self {
        if hits.is_empty() {
            return Metric::missing(format!("no {of}"));
        }
        let r = Rate::new(hits.iter().filter(|h| **h).count(), hits.len());
        Metric {
            value: Some(r.value),
            lo: Some(r.lo),
            hi: Some(r.hi),
            n: r.n,
            reason: None,
        }
    }

    /// A statistic with its percentile bootstrap interval over items.
    pub(crate) fn resampled<T: Copy>(
        items: &[T],
        of: &str,
        statistic: impl Fn(&[T]) -> Option<f64>,
    ) -> Self {
        let Some(value) = statistic(items) else {
            return Metric::missing(format!("no {of}"));
        };
        let mut draws = Draws::new(RESAMPLING_SEED, items.len() as u64);
        let mut sample = Vec::with_capacity(items.len());
        let mut seen: Vec<f64> = (0..RESAMPLES)
            .filter_map(|_| {
                sample.clear();
                sample.extend(
                    (0..items.len()).filter_map(|_| items.get(draws.below(items.len())).copied()),
                );
                statistic(&sample)
            })
            .collect();
        seen.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let k = (share * (seen.len() as f64 - 1.0)).round().max(0.0) as usize;
            seen.get(k).copied()
        };
        Metric {
            value: Some(value),
            // The resamples of few items may all lie on one side of the figure itself.
            lo: at(0.025).map(|x| x.min(value)),
            hi: at(0.975).map(|x| x.max(value)),
            n: items.len(),
            reason: None,
        }
    }

    pub(crate) fn to_json(&self) -> Value {
        let mut out = Map::new();
        out.insert("value".to_owned(), json!(self.value));
        out.insert("lo".to_owned(), json!(self.lo));
        out.insert("hi".to_owned(), json!(self.hi));
        out.insert("n".to_owned(), json!(self.n));
        if let Some(reason) = &self.reason {
            out.insert("reason".to_owned(), json!(reason));
        }
        Value::Object(out)
    }
}

const RESAMPLES: usize = 1000;
const RESAMPLING_SEED: u64 = 20_080_401;
/// Equal bins of confidence.
const BINS: usize = 10;

/// Expected calibration error of (confidence, right): Σ n_b/N |share right - mean confidence| over ten equal bins.
///
/// # Reference
/// M. P. Naeini, G. Cooper, M. Hauskrecht, Proc. AAAI 2015.
pub(crate) fn calibration_error(answers: &[(f64, bool)]) -> Option<f64> {
    if answers.is_empty() {
        return None;
    }
    let mut bins = [(0.0, 0.0); BINS];
    for (confidence, right) in answers {
        let k = ((confidence * BINS as f64) as usize).min(BINS - 1);
        bins[k].0 += confidence;
        bins[k].1 += f64::from(u8::from(*right));
    }
    let gap: f64 = bins.iter().map(|(c, r)| (r - c).abs()).sum();
    Some(gap / answers.len() as f64)
}

/// Area under the curve of (score, positive): the chance that a positive scores above a negative, ties by half.
pub(crate) fn area(scored: &[(f64, bool)]) -> Option<f64> {
    let mut order: Vec<(f64, bool)> = scored.to_vec();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let positives = order.iter().filter(|s| s.1).count() as f64;
    let negatives = order.len() as f64 - positives;
    if positives == 0.0 || negatives == 0.0 {
        return None;
    }
    let (mut wins, mut below, mut k) = (0.0, 0.0, 0);
    while k < order.len() {
        let tied = order[k..].iter().take_while(|s| s.0 == order[k].0);
        let (p, n) = tied.fold(
            (0.0, 0.0),
            |(p, n), s| if s.1 { (p + 1.0, n) } else { (p, n + 1.0) },
        );
        wins += p * (below + 0.5 * n);
        below += n;
        k += (p + n) as usize;
    }
    Some(wins / (positives * negatives))
}

/// The middle value.
pub(crate) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    match (n.checked_sub(1)?, n % 2) {
        (last, 1) => sorted.get(last / 2).copied(),
        (last, _) => Some(0.5 * (sorted.get(last / 2)? + sorted.get(last / 2 + 1)?)),
    }
}

/// The arithmetic mean.
pub(crate) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By counting pairs: 3 positives, 2 negatives; .9 > .3, .5; .5 > .3 and ties .5; .1 below both: 3.5 of 6.
    #[test]
    fn area_by_counting_pairs() {
        let scored = [
            (0.9, true),
            (0.5, true),
            (0.1, true),
            (0.3, false),
            (0.5, false),
        ];
        assert!((area(&scored).unwrap() - 3.5 / 6.0).abs() < 1e-12);
        assert_eq!(area(&[(0.1, true)]), None);
    }

    /// Two bins by hand: .95 and .85 are in [.9, 1) and [.8, .9): |1 - .95|/3 + |0 + 1 - 1.7|/3 for (.85, two of them).
    #[test]
    fn calibration_error_by_hand() {
        let answers = [(0.95, true), (0.85, true), (0.85, false)];
        let expected = ((1.0f64 - 0.95).abs() + (1.0f64 - 1.7).abs()) / 3.0;
        assert!((calibration_error(&answers).unwrap() - expected).abs() < 1e-12);
        // Sure and right is calibrated; sure and wrong is the worst there is.
        assert_eq!(calibration_error(&[(1.0, true)]), Some(0.0));
        assert_eq!(calibration_error(&[(1.0, false)]), Some(1.0));
    }

    #[test]
    fn medians() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&[]), None);
    }

    /// The mean of 400 values of variance 1 has a 95 % interval of ± 1.96/20.
    #[test]
    fn resampled_interval_of_a_mean_is_the_textbook_one() {
        let mut draws = Draws::new(2, 0);
        let values: Vec<f64> = (0..400).map(|_| draws.normal_within(8.0)).collect();
        let m = Metric::resampled(&values, "values", mean);
        let half = 0.5 * (m.hi.unwrap() - m.lo.unwrap());
        assert!((half - 1.96 / 20.0).abs() < 0.02, "{half}");
        assert_eq!(m.n, 400);
    }
}
