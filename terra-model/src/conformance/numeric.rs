//! Derivatives by finite differences and a search for jumps.

/// Central difference of order six, with an error from halving the step: f' from f(x ± h), f(x ± 2h), f(x ± 3h).
///
/// None where the function has no value at one of the points.
pub(super) fn difference<const N: usize>(
    f: &impl Fn(f64) -> Option<[f64; N]>,
    x: f64,
    h: f64,
) -> Option<[(f64, f64); N]> {
    let stencil = |h: f64| -> Option<[f64; N]> {
        let mut sum = [0.0; N];
        for (k, weight) in [(1.0, 45.0), (2.0, -9.0), (3.0, 1.0)] {
            let (ahead, behind) = (f(x + k * h)?, f(x - k * h)?);
            for (s, (a, b)) in sum.iter_mut().zip(ahead.into_iter().zip(behind)) {
                *s += weight * (a - b);
            }
        }
        Some(sum.map(|s| s / (60.0 * h)))
    };
    let (coarse, fine) = (stencil(h)?, stencil(0.5 * h)?);
    let mut out = [(0.0, 0.0); N];
    for (o, (c, f)) in out.iter_mut().zip(coarse.into_iter().zip(fine)) {
        *o = (f, (c - f).abs());
    }
    Some(out)
}

/// Largest change of `f` that stays when the interval around it is halved thirty times: a jump, and where.
///
/// `f` is scaled by the caller so that 1 is large. Points without a value are passed over.
pub(super) fn jump<const N: usize>(
    f: &impl Fn(f64) -> Option<[f64; N]>,
    from: f64,
    to: f64,
) -> (f64, f64) {
    let change = |a: &Option<[f64; N]>, b: &Option<[f64; N]>| match (a, b) {
        (Some(a), Some(b)) => a
            .iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max),
        _ => 0.0,
    };
    const GRID: usize = 24;
    let at = |q: usize| from + (to - from) * q as f64 / GRID as f64;
    let values: Vec<_> = (0..=GRID).map(|q| f(at(q))).collect();
    let steepest = values
        .windows(2)
        .map(|w| change(&w[0], &w[1]))
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((q, _)) = steepest else {
        return (0.0, from);
    };
    let (mut low, mut high) = (at(q), at(q + 1));
    let (mut f_low, mut f_high) = (f(low), f(high));
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        let f_middle = f(middle);
        if f_middle.is_none() {
            return (0.0, middle);
        }
        if change(&f_low, &f_middle) > change(&f_middle, &f_high) {
            (high, f_high) = (middle, f_middle);
        } else {
            (low, f_low) = (middle, f_middle);
        }
    }
    (change(&f_low, &f_high), low)
}
