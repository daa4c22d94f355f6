//! A ground speed that a slower sensor's value is held in: only the rows in which it is read anew say something.
//!
//! Held values have the noise of one reading many times over, and are late by half of the time they are held. A log's beginning
//! shows how long that is; from there on a value that is repeated is a missing sample.

use std::borrow::Cow;

use terra_data::{DriveLog, Series};
use terra_model::order::ascending;

use super::stream::joined;

/// Rows of the beginning in which the holding is looked for.
const BEGINNING: usize = 4096;
/// Values that must be held as long there, and their share of all. Rounded values stand for as long as they happen to, most for one
/// row where noise is larger than a digit; those that stand still for a while do not change often enough.
const HELD: (usize, f64) = (20, 0.8);

/// Takes repeated values out of a log that comes in pieces.
#[derive(Clone, Debug)]
pub(crate) enum Held {
    /// What has come while the beginning is not over.
    Beginning(Box<DriveLog>),
    /// Nothing is held.
    Not,
    /// How many rows a value is held, and the one that is, for how many rows now.
    For {
        rows: usize,
        value: Option<f64>,
        since: usize,
    },
}

impl Default for Held {
    fn default() -> Self {
        Held::Beginning(Box::default())
    }
}

impl Held {
    /// How many rows a value is held.
    fn rows(&self) -> Option<usize> {
        match self {
            Held::For { rows, .. } => Some(*rows),
            Held::Beginning(_) | Held::Not => None,
        }
    }

    /// What to heed where something is held.
    pub(crate) fn note(&self, prefix: &str) -> Option<String> {
        let rows = self.rows()?;
        Some(format!(
            "{prefix}ground_speed_m_s changes every {rows} rows only: a value that is held in between counts as no reading"
        ))
    }

    /// Whether that is not known yet.
    pub(crate) fn is_open(&self) -> bool {
        matches!(self, Held::Beginning(_))
    }

    /// What can be read of the log by now, without repeated values; with `last` all of it.
    pub(crate) fn pass<'a>(&mut self, piece: &'a DriveLog, last: bool) -> Cow<'a, DriveLog> {
        let mut log = Cow::Borrowed(piece);
        if let Held::Beginning(before) = self {
            if !before.is_empty() {
                log = Cow::Owned(joined(before, piece));
            }
            if log.len() < BEGINNING && !last {
                **before = log.into_owned();
                return Cow::Owned(DriveLog::default());
            }
            let speed = log.ground_speed.as_ref();
            *self = match speed.and_then(|v| held_for(v.iter().take(BEGINNING))) {
                Some(rows) => Held::For {
                    rows,
                    value: None,
                    since: 0,
                },
                None => Held::Not,
            };
        }
        let Held::For { rows, value, since } = self else {
            return log;
        };
        let mut anew = |v: Option<f64>| {
            v?;
            // Read again and the same is possible; not read again for twice as long is a value that stands still.
            if v == *value && *since < 2 * *rows {
                *since += 1;
                return None;
            }
            (*value, *since) = (v, 1);
            v
        };
        if let Some(speed) = &log.ground_speed {
            let speed: Series = speed.iter().map(&mut anew).collect();
            log.to_mut().ground_speed = Some(speed);
        }
        log
    }
}

/// How many rows a value is held, where it changes so rarely and then nearly always, by this much and by that.
fn held_for(values: impl Iterator<Item = Option<f64>>) -> Option<usize> {
    let (mut lengths, mut steps) = (vec![], vec![]);
    let mut now: Option<(f64, usize)> = None;
    for v in values {
        now = match (now, v) {
            (Some((value, n)), Some(v)) if v == value => Some((value, n + 1)),
            (before, v) => {
                lengths.extend(before.map(|(_, n)| n));
                steps.extend(before.zip(v).map(|((value, _), v)| (v - value).abs()));
                v.map(|v| (v, 1))
            }
        };
    }
    // The first and the last are cut.
    let whole = lengths.get(1..).unwrap_or_default();
    let mut sorted = whole.to_vec();
    sorted.sort_unstable();
    let usual = *sorted.get(sorted.len() / 2)?;
    // The clocks of a sensor and of a log are not the same.
    let alike = |n: &&usize| n.abs_diff(usual) <= usual / 4;
    let as_long = whole.iter().filter(alike).count();
    let (often, share) = HELD;
    let held = usual > 1 && as_long >= often && as_long as f64 >= share * whole.len() as f64;
    // A speed that grows evenly and is rounded goes up by a digit every so many rows, and is read in each.
    ascending(&mut steps, |step| *step);
    let digit = *steps.get(steps.len() / 2)?;
    let by_a_digit = |step: &&f64| (**step - digit).abs() < 1e-6 * digit;
    let rounded = steps.iter().filter(by_a_digit).count() as f64 >= share * steps.len() as f64;
    (held && !rounded).then_some(usual)
}

#[cfg(test)]
mod tests {
    use super::super::stream::rows;
    use super::*;

    fn log(speed: impl Fn(usize) -> f64, n: usize) -> DriveLog {
        DriveLog {
            time: (0..n).map(|k| 0.01 * k as f64).collect(),
            ground_speed: Some((0..n).map(|k| Some(speed(k))).collect()),
            ..DriveLog::default()
        }
    }

    /// No two of these are the same.
    fn reading(k: usize) -> f64 {
        1.0 + 0.03 * (1.7 * k as f64).sin()
    }

    fn kept(log: &DriveLog) -> Vec<usize> {
        let mut held = Held::default();
        let passed = held.pass(log, true);
        let speed = passed.ground_speed.as_ref().unwrap();
        (0..log.len()).filter(|k| speed.get(*k).is_some()).collect()
    }

    /// Every tenth row is read; with the clocks apart the lengths differ by one. Where every row is read all stay, and so do
    /// values that a display rounds, steadily growing ones among them, and one that stands still.
    #[test]
    fn only_what_is_read_anew_stays() {
        let every = |k: usize| k / 10;
        let tenth: Vec<usize> = (0..3000).step_by(10).collect();
        assert_eq!(kept(&log(|k| reading(every(k)), 3000)), tenth);
        let uneven = |k: usize| (k as f64 / 9.6) as usize;
        let changes = |k: &usize| *k == 0 || uneven(*k) != uneven(k - 1);
        let expected: Vec<usize> = (0..3000).filter(changes).collect();
        assert_eq!(kept(&log(|k| reading(uneven(k)), 3000)), expected);
        let rounded = |k: usize| (reading(k) * 50.0).round() / 50.0;
        // .1 m/s² in whole cm/s: a digit more every tenth row.
        let growing = |k: usize| (0.1 * k as f64).round() / 100.0;
        let all: [&dyn Fn(usize) -> f64; 4] = [&reading, &rounded, &growing, &|_| 1.0];
        for speed in all {
            assert_eq!(kept(&log(speed, 3000)).len(), 3000);
        }
    }

    /// Pieces of seven rows and of a thousand, and the whole, leave the same rows, none before the beginning is over.
    #[test]
    fn pieces_leave_the_same_rows() {
        let whole = log(|k| reading(k / 4), 6000);
        let expected: Vec<Option<f64>> = (0..6000)
            .map(|k| (k % 4 == 0).then(|| reading(k / 4)))
            .collect();
        for size in [7, 1000, 6000] {
            let mut held = Held::default();
            let mut found: Vec<Option<f64>> = vec![];
            for start in (0..6000).step_by(size) {
                let end = (start + size).min(6000);
                let piece = rows(&whole, start..end);
                let passed = held.pass(&piece, end == 6000);
                found.extend(passed.ground_speed.iter().flat_map(Series::iter));
                assert_eq!(found.is_empty(), end < BEGINNING);
            }
            assert_eq!(held.rows(), Some(4));
            assert_eq!(found, expected);
        }
    }
}
