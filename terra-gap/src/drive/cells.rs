//! What one channel says in a window: the line through its cells, their mean, or what they declare.

use std::ops::Range;

use terra_data::Series;

/// Share of a window's time that a channel's samples must stand for.
const PRESENT: f64 = 0.6;

/// Mean, slope and their 1-sigma of one channel over a window.
pub(crate) struct Line {
    pub(crate) mean: f64,
    pub(crate) slope: f64,
    pub(crate) mean_sd: f64,
    pub(crate) slope_sd: f64,
    /// Mean square around the line, in units of the sensor's variance; NaN where two samples make the line.
    pub(crate) scatter: f64,
    /// Product of one residual with the next over their square, in the mean; NaN where there is none.
    pub(crate) lag: f64,
    pub(crate) samples: usize,
}

/// The line at the middle of a window. A channel of a slower rate has its samples in some rows only.
pub(crate) fn line(time: &[f64], series: &Series, rows: Range<usize>, sd: f64) -> Option<Line> {
    let (total, times) = (rows.len(), time.get(rows.clone())?);
    let points: Vec<(f64, f64)> = rows
        .filter_map(|i| Some((*time.get(i)?, series.get(i)?)))
        .collect();
    let n = points.len() as f64;
    let stands_for = |first: f64, last: f64, n: f64| (last - first) * n / (n - 1.0);
    let all = stands_for(*times.first()?, *times.last()?, total as f64);
    let own = stands_for(points.first()?.0, points.last()?.0, n);
    // Two samples of three or more rows are a slow channel's, two of two rows the end of a manoeuvre.
    if total < 3 || points.len() < 2 || own < PRESENT * all {
        return None;
    }
    let middle = times.iter().sum::<f64>() / total as f64;
    let (t, y) = (
        points.iter().map(|p| p.0).sum::<f64>() / n,
        points.iter().map(|p| p.1).sum::<f64>() / n,
    );
    let stt: f64 = points.iter().map(|p| (p.0 - t).powi(2)).sum();
    let sty: f64 = points.iter().map(|p| (p.0 - t) * (p.1 - y)).sum();
    let slope = sty / stt;
    let residuals: Vec<f64> = points.iter().map(|p| p.1 - y - slope * (p.0 - t)).collect();
    let squares: f64 = residuals.iter().map(|e| e * e).sum();
    let pairs = residuals.iter().zip(residuals.iter().skip(1));
    let next: f64 = pairs.map(|(a, b)| a * b).sum();
    let (mean_sd, slope_sd) = (sd / n.sqrt(), sd / stt.sqrt());
    let off = middle - t;
    Some(Line {
        mean: y + slope * off,
        slope,
        mean_sd: if off == 0.0 {
            mean_sd
        } else {
            mean_sd.hypot(slope_sd * off)
        },
        slope_sd,
        scatter: match points.len() {
            2 => f64::NAN,
            _ if sd > 0.0 => squares / (n - 2.0) / (sd * sd),
            _ => 0.0,
        },
        lag: if points.len() > 2 {
            next / squares
        } else {
            f64::NAN
        },
        samples: points.len(),
    })
}

/// Mean of the cells that a channel has in a window: a missing cell is a missing sample. `Ok(None)` where the log lacks the
/// channel, an error where it has no cell here.
pub(crate) fn cells(
    series: Option<&Series>,
    rows: Range<usize>,
    missing: &'static str,
) -> Result<Option<f64>, &'static str> {
    let Some(series) = series else {
        return Ok(None);
    };
    let mut present = rows.filter_map(|row| series.get(row));
    let first = present.next().ok_or(missing)?;
    let (more, n) = present.fold((0.0, 1.0), |(sum, n), v| (sum + (v - first), n + 1.0));
    Ok(Some(first + more / n))
}

/// What is declared for a window by the cell nearest to its middle, likewise.
pub(crate) fn declared(
    series: Option<&Series>,
    rows: Range<usize>,
    missing: &'static str,
) -> Result<Option<f64>, &'static str> {
    let Some(series) = series else {
        return Ok(None);
    };
    let middle = rows.start + rows.len() / 2;
    let nearest = rows
        .filter_map(|row| Some((row.abs_diff(middle), series.get(row)?)))
        .min_by_key(|(apart, _)| *apart);
    Ok(Some(nearest.ok_or(missing)?.1))
}
