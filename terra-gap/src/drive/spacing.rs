//! A log that is read too rarely for the usual window: all of it, as by telemetry, or one channel, as a ground speed by satellites.
//!
//! A window needs the mean and the slope of each wheel's speed and of the ground's, two readings at least, and three rows. Where
//! there are fewer and the rover file does not say how long windows are, they are long enough for three readings.

use terra_data::{DriveLog, Segment, Series};
use terra_model::order::ascending;

/// The channels that windows are made of, as their names begin.
const NEEDED_OF: [&str; 3] = ["ground_speed", "wheel_speed", "wheel_torque"];
/// Readings of a channel that a window needs.
const NEEDED: f64 = 2.0;
/// Rows that it needs, and readings that a wider one has.
const READINGS: f64 = 3.0;
/// Share of their usual interval by which rows may come early or late.
const JITTER: f64 = 0.1;
/// Windows longer than this \[s\] are no instant of a drive any more.
const LONGEST: f64 = 1.0;
/// Intervals between readings from which the usual one is known.
const ENOUGH: usize = 10;

/// Longer windows than usual.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wider {
    /// How long they are \[s\].
    pub(crate) window: f64,
    /// What comes too rarely for shorter ones.
    pub(crate) rare: String,
}

impl Wider {
    /// What to heed.
    pub(crate) fn note(&self, prefix: &str) -> String {
        format!(
            "{prefix}windows of {:.1} s, as {} too rarely for shorter ones; [gap] window_s sets them",
            self.window, self.rare
        )
    }
}

/// The usual time between those rows of a log's manoeuvres in which something is read \[s\].
fn interval(log: &DriveLog, is_read: impl Fn(usize) -> bool) -> Option<f64> {
    let mut intervals = vec![];
    for Segment { rows, .. } in &log.segments {
        let times = log.time.iter().enumerate().take(rows.end).skip(rows.start);
        let read: Vec<f64> = times
            .filter(|(i, _)| is_read(*i))
            .map(|(_, t)| *t)
            .collect();
        intervals.extend(read.windows(2).map(|pair| pair[1] - pair[0]));
    }
    ascending(&mut intervals, |dt| *dt);
    let usual = intervals.get(intervals.len() / 2).copied();
    usual.filter(|_| intervals.len() >= ENOUGH)
}

/// The longer windows that a log's beginning asks for where the `usual` ones hold too few readings, in tenths of a second.
pub(crate) fn wider(log: &DriveLog, usual: f64) -> Option<Wider> {
    holding(NEEDED, log, usual)
}

/// Those that hold three readings, where the `usual` ones hold two: mean and slope of two have no room for doubt.
pub(crate) fn roomier(log: &DriveLog, usual: f64) -> Option<Wider> {
    holding(READINGS, log, usual)
}

fn holding(needed_readings: f64, log: &DriveLog, usual: f64) -> Option<Wider> {
    let rows = interval(log, |_| true).filter(|dt| (READINGS - 1.0) * dt > usual * (1.0 - JITTER));
    let rows = rows.map(|dt| ("rows come".to_owned(), dt));
    let needed =
        |(name, _): &(String, &Series)| NEEDED_OF.iter().any(|what| name.starts_with(what));
    let channel = |(name, series): (String, &Series)| {
        let interval = interval(log, |i| series.get(i).is_some())?;
        // Clocks since 1970 are read to a tenth of a microsecond.
        let rarely = needed_readings * interval > usual * (1.0 + 1e-3);
        rarely.then(|| (format!("{name} is read"), interval))
    };
    let channels = log.channels().into_iter().filter(needed);
    let all = rows.into_iter().chain(channels.filter_map(channel));
    let long = |(rare, interval): (String, f64)| Wider {
        window: (10.0 * READINGS * interval - 0.01).ceil() / 10.0,
        rare,
    };
    let enough = all.map(long).filter(|wider| wider.window <= LONGEST);
    // The first of those as long, which is the rows where all channels come with them.
    enough.reduce(|a, b| if b.window > a.window { b } else { a })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many rows a second, with a reading of the ground's speed in every so many.
    fn log(rate: f64, every: usize) -> DriveLog {
        let speed = (0..2000).map(|k| (k % every == 0).then_some(0.5));
        DriveLog {
            time: (0..2000).map(|k| 1e9 + k as f64 / rate).collect(),
            wheel_speed: std::array::from_fn(|_| vec![Some(1.0); 2000].into_iter().collect()),
            ground_speed: Some(speed.collect()),
            segments: vec![Segment {
                name: String::new(),
                rows: 0..2000,
            }],
            ..DriveLog::default()
        }
    }

    /// 100 rows a second with a reading of the speed in every so many: up to every tenth two in .2 s, three in .4 s at every twelfth, in
    /// .6 s at every twentieth; a reading a second is too rare for any window.
    #[test]
    fn a_wider_window_holds_three_readings() {
        let every = |rows: usize| wider(&log(100.0, rows), 0.2).map(|wider| wider.window);
        let found = [1, 10, 12, 20, 100].map(every);
        assert_eq!(found, [None, None, Some(0.4), Some(0.6), None]);
        // Two readings in .2 s of every tenth row are enough for a window, and three would be more.
        let every = |rows: usize| roomier(&log(100.0, rows), 0.2).map(|wider| wider.window);
        assert_eq!([1, 6, 8, 10].map(every), [None, None, Some(0.3), Some(0.3)]);
    }

    /// A window of .2 s holds three rows of a log of fifteen rows a second, but two of one of ten or five, whatever is in them.
    #[test]
    fn a_wider_window_holds_three_rows() {
        let at = |rate: f64| wider(&log(rate, 1), 0.2);
        let found = [15.0, 10.0, 5.0, 2.0].map(|rate| at(rate).map(|wider| wider.window));
        assert_eq!(found, [None, Some(0.3), Some(0.6), None]);
        let note = at(10.0).unwrap().note("");
        assert!(
            note.starts_with("windows of 0.3 s, as rows come too rarely"),
            "{note}"
        );
    }

    /// The rarest channel says how long, unless it is too rare for any window.
    #[test]
    fn the_rarest_channel_that_can_be_waited_for_counts() {
        let with_torques_every = |rows: usize| {
            let torque = |_| (0..2000).map(|k| (k % rows == 0).then_some(3.0)).collect();
            let mut log = log(100.0, 20);
            log.wheel_torque = Some(std::array::from_fn(torque));
            wider(&log, 0.2).unwrap()
        };
        let (slow, slowest) = (with_torques_every(25), with_torques_every(100));
        assert_eq!((slow.window, slowest.window), (0.8, 0.6));
        assert_eq!(slow.rare, "wheel_torque_fl_N_m is read");
        assert_eq!(slowest.rare, "ground_speed_m_s is read");
    }
}
