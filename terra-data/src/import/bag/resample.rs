//! The value of a channel at a row's time.

/// How it is found between samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// On the line between the neighbours.
    Linear,
    /// That of the nearest; of two as near, the earlier.
    Nearest,
    /// That of the last one before or at the time.
    Previous,
}

/// The value at `t` \[ns\]; none where the samples it needs are further than `max_gap` away: a gap stays a gap. Times
/// increase.
///
/// # Equation
/// Linear: x0 + (x1 - x0) (t - t0)/(t1 - t0); at a sample exactly its value.
pub(crate) fn sample(
    times: &[i64],
    values: &[f64],
    t: i64,
    method: Method,
    max_gap: i64,
) -> Option<f64> {
    let after = times.partition_point(|s| *s <= t);
    let at = |k: usize| Some((*times.get(k)?, *values.get(k)?));
    let near = |s: &(i64, f64)| t.abs_diff(s.0) <= max_gap.unsigned_abs();
    let before = after.checked_sub(1).and_then(at).filter(near);
    if let Some((s, value)) = before
        && s == t
    {
        return Some(value);
    }
    let next = at(after).filter(near);
    match method {
        Method::Previous => before.map(|s| s.1),
        Method::Nearest => match (before, next) {
            (Some(a), Some(b)) if t - a.0 <= b.0 - t => Some(a.1),
            (a, b) => b.or(a).map(|s| s.1),
        },
        Method::Linear => {
            let ((t0, x0), (t1, x1)) = (before?, next?);
            Some(x0 + (x1 - x0) * ((t - t0) as f64 / (t1 - t0) as f64))
        }
    }
}

/// The last text before or at `t`: a name holds until the next one.
pub(crate) fn text_at<'a>(times: &[i64], texts: &'a [String], t: i64) -> Option<&'a str> {
    let after = times.partition_point(|s| *s <= t);
    texts.get(after.checked_sub(1)?).map(String::as_str)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_method_by_hand() {
        let (times, values) = ([0, 10, 30], [1.0, 2.0, 6.0]);
        let at = |t, method, gap| sample(&times, &values, t, method, gap);
        use Method::*;
        for method in [Linear, Nearest, Previous] {
            assert_eq!(at(10, method, 0), Some(2.0), "a sample is itself");
            assert_eq!(at(-50, method, 40), None);
            assert_eq!(at(90, method, 40), None);
        }
        assert_eq!(at(15, Linear, 20), Some(3.0));
        assert_eq!(at(15, Linear, 10), None, "the next sample is 15 away");
        assert_eq!(
            at(20, Nearest, 20),
            Some(2.0),
            "of two as near, the earlier"
        );
        assert_eq!(at(21, Nearest, 20), Some(6.0));
        assert_eq!(at(21, Nearest, 10), Some(6.0));
        assert_eq!(at(29, Previous, 20), Some(2.0));
        assert_eq!(at(29, Previous, 10), None);
        assert_eq!(at(35, Linear, 20), None, "no line beyond the last sample");
    }

    #[test]
    fn a_name_holds() {
        let names = ["a".to_owned(), "b".to_owned()];
        assert_eq!(text_at(&[5, 9], &names, 4), None);
        assert_eq!(text_at(&[5, 9], &names, 8), Some("a"));
        assert_eq!(text_at(&[5, 9], &names, 100), Some("b"));
    }
}
