//! Many long lines in one figure: thinned without losing what shows, their labels kept apart.

use super::data::Datum;

/// Buckets of a long history; each keeps its smallest and largest value.
const BUCKETS: usize = 200;
/// Distance of labels at the line ends \[px\].
pub(super) const LABEL_PITCH: f64 = 17.0;

/// A long line with the extremes of each of its buckets kept.
pub(super) fn thin(points: Vec<Datum>) -> Vec<Datum> {
    thin_to(points, BUCKETS)
}

/// As [`thin`], for figures of several panels.
pub(super) fn thin_to(points: Vec<Datum>, buckets: usize) -> Vec<Datum> {
    if points.len() <= 2 * buckets {
        return points;
    }
    let size = points.len().div_ceil(buckets);
    let end = points.len() - 1;
    let mut out = vec![];
    for (k, bucket) in points.chunks(size).enumerate() {
        let by = |a: &(usize, &Datum), b: &(usize, &Datum)| a.1.y.total_cmp(&b.1.y);
        let finite = || bucket.iter().enumerate().filter(|(_, d)| d.is_finite());
        let mut keep: Vec<usize> = finite().min_by(by).into_iter().map(|e| e.0).collect();
        keep.extend(finite().max_by(by).map(|e| e.0));
        // A break stays a break.
        keep.extend(bucket.iter().position(|d| !d.is_finite()));
        // The end is what the labels quote.
        keep.extend((k * size + bucket.len() > end).then(|| bucket.len() - 1));
        keep.sort_unstable();
        keep.dedup();
        out.extend(keep.into_iter().filter_map(|i| bucket.get(i)).cloned());
    }
    out
}

/// Heights at least a pitch apart, in the same order from top to bottom, as near to `wanted` as that allows,
/// between `low` and `high`.
pub(super) fn apart(wanted: &[f64], low: f64, high: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]).then(a.cmp(&b)));
    let mut at = wanted.to_vec();
    let mut least = low;
    for &k in &order {
        at[k] = at[k].max(least);
        least = at[k] + LABEL_PITCH;
    }
    let mut most = high;
    for &k in order.iter().rev() {
        at[k] = at[k].min(most);
        most = at[k] - LABEL_PITCH;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_never_meet_and_keep_their_order() {
        let at = apart(&[100.0, 101.0, 101.0, 10.0, 250.0], 10.0, 260.0);
        let mut sorted = at.clone();
        sorted.sort_by(f64::total_cmp);
        assert!(sorted.windows(2).all(|w| w[1] - w[0] >= LABEL_PITCH));
        assert!(sorted[0] >= 10.0 && sorted[4] <= 260.0);
        assert!(at[3] < at[0] && at[0] < at[1] && at[1] < at[2] && at[2] < at[4]);
    }

    /// A spike of one sample among thousands must not be thinned away, nor a gap, nor the last value.
    #[test]
    fn thinning_keeps_spikes_gaps_and_the_end() {
        let mut points: Vec<Datum> = (0..5000).map(|k| Datum::at(f64::from(k), 0.1)).collect();
        points[2345].y = 0.9;
        points[3001].y = f64::NAN;
        points[4999].y = 0.3;
        let thinned = thin(points);
        assert!(thinned.len() <= 2 * BUCKETS + 2);
        assert!(thinned.iter().any(|d| d.x == 2345.0 && d.y == 0.9));
        assert!(thinned.iter().any(|d| d.x == 3001.0 && d.y.is_nan()));
        assert!(thinned.last().is_some_and(|d| d.x == 4999.0 && d.y == 0.3));
        assert!(thinned.windows(2).all(|w| w[0].x < w[1].x));
    }
}
