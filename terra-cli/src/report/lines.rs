//! Many long lines in one figure: thinned without losing what shows, their labels kept apart.

/// Buckets of a long history; each keeps its smallest and largest value.
const BUCKETS: usize = 300;
/// Distance of labels at the line ends \[px\].
pub(super) const LABEL_PITCH: i32 = 17;

/// A long line with the extremes of each of its buckets kept.
pub(super) fn thin(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    if points.len() <= 2 * BUCKETS {
        return points;
    }
    let size = points.len().div_ceil(BUCKETS);
    let mut out = vec![];
    for bucket in points.chunks(size) {
        let by = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let mut keep: Vec<(f64, f64)> = bucket
            .iter()
            .min_by(by)
            .into_iter()
            .chain(bucket.iter().max_by(by))
            .copied()
            .collect();
        keep.sort_by(|a, b| a.0.total_cmp(&b.0));
        keep.dedup();
        out.extend(keep);
    }
    // The end is what the labels quote.
    if let Some(last) = points.last().filter(|p| out.last() != Some(p)) {
        out.push(*last);
    }
    out
}

/// Heights at least a pitch apart, in the same order from top to bottom, as near to `wanted` as that allows,
/// between `low` and `high`.
pub(super) fn apart(wanted: &[i32], low: i32, high: i32) -> Vec<i32> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by_key(|&k| (wanted[k], k));
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
        let at = apart(&[100, 101, 101, 10, 250], 10, 260);
        let mut sorted = at.clone();
        sorted.sort_unstable();
        assert!(sorted.windows(2).all(|w| w[1] - w[0] >= LABEL_PITCH));
        assert!(sorted[0] >= 10 && sorted[4] <= 260);
        assert!(at[3] < at[0] && at[0] < at[1] && at[1] < at[2] && at[2] < at[4]);
    }

    /// A spike of one sample among thousands must not be thinned away, nor the last value.
    #[test]
    fn thinning_keeps_spikes_and_the_end() {
        let mut points: Vec<(f64, f64)> = (0..5000).map(|k| (f64::from(k), 0.1)).collect();
        points[2345].1 = 0.9;
        points[4999].1 = 0.3;
        let thinned = thin(points);
        assert!(thinned.len() <= 2 * BUCKETS + 1);
        assert!(thinned.contains(&(2345.0, 0.9)));
        assert_eq!(thinned.last(), Some(&(4999.0, 0.3)));
        assert!(thinned.windows(2).all(|w| w[0].0 < w[1].0));
    }
}
