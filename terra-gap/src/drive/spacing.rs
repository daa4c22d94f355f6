//! A ground speed that is read too rarely for the usual window, as by satellites.
//!
//! A window needs the mean and the slope of the speed, two readings at least. Where there are fewer and the rover file does not say
//! how long windows are, they are long enough for three.

use terra_data::DriveLog;
use terra_model::order::ascending;

/// Readings that a window needs.
const NEEDED: f64 = 2.0;
/// Those that a wider one has.
const READINGS: f64 = 3.0;
/// Windows longer than this \[s\] are no instant of a drive any more.
const LONGEST: f64 = 1.0;
/// Intervals between readings from which the usual one is known.
const ENOUGH: usize = 10;

/// The usual time between readings of the ground speed \[s\], within manoeuvres.
fn interval(log: &DriveLog) -> Option<f64> {
    let speed = log.ground_speed.as_ref()?;
    let mut intervals = vec![];
    for segment in &log.segments {
        let rows = segment.rows.clone();
        let read = speed.iter().zip(&log.time).take(rows.end).skip(rows.start);
        let times: Vec<f64> = read.filter_map(|(v, t)| v.map(|_| *t)).collect();
        intervals.extend(times.windows(2).map(|pair| pair[1] - pair[0]));
    }
    ascending(&mut intervals, |dt| *dt);
    let usual = intervals.get(intervals.len() / 2).copied();
    usual.filter(|_| intervals.len() >= ENOUGH)
}

/// How long windows \[s\] must be where a log's beginning shows that the `usual` ones hold too few readings, in tenths of a second.
pub(super) fn wider(log: &DriveLog, usual: f64) -> Option<f64> {
    let interval = interval(log)?;
    // Clocks since 1970 are read to a tenth of a microsecond.
    let rarely = NEEDED * interval > usual * (1.0 + 1e-3);
    let wide = (10.0 * READINGS * interval - 0.01).ceil() / 10.0;
    (rarely && wide <= LONGEST).then_some(wide)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terra_data::Segment;

    /// 100 rows a second with a reading of the speed in every so many: up to every tenth two in .2 s, three in .4 s at every twelfth, in
    /// .6 s at every twentieth; a reading a second is too rare for any window.
    #[test]
    fn a_wider_window_holds_three_readings() {
        let every = |rows: usize| {
            let log = DriveLog {
                time: (0..2000).map(|k| 1e9 + 0.01 * k as f64).collect(),
                ground_speed: Some((0..2000).map(|k| (k % rows == 0).then_some(0.5)).collect()),
                segments: vec![Segment {
                    name: String::new(),
                    rows: 0..2000,
                }],
                ..DriveLog::default()
            };
            wider(&log, 0.2)
        };
        let found: Vec<_> = [1, 10, 12, 20, 100].map(every).into_iter().collect();
        assert_eq!(found, [None, None, Some(0.4), Some(0.6), None]);
    }
}
