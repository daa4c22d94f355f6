//! Rows in, windows out: what is kept of a log in between is less than two windows of rows, and two windows.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::ops::Range;

use terra_data::{DriveLog, Rover, Segment, Series};

use super::spacing::{Wider, roomier, wider};
use super::window::{Going, Reader, Taken, is_full};
use crate::error::GapError;

/// One window of the stream, used or left out.
#[derive(Clone, Debug)]
pub(crate) struct Slot {
    /// Its number, from 0, counting those left out.
    pub(crate) number: usize,
    pub(crate) segment: String,
    /// None where it was left out.
    pub(crate) taken: Option<Taken>,
}

/// Windows that a window waits for.
const FOLLOW: usize = 2;

/// Cuts pieces of a log into windows. Where the pieces end does not matter, but that the first shows how often the log is read.
#[derive(Clone, Debug)]
pub(crate) struct Stream {
    rover: Rover,
    pub(crate) reader: Reader,
    /// Rows not yet in a window, with the one before them.
    rest: DriveLog,
    /// The first of `rest` that is in no window.
    next: usize,
    /// True once a segment has begun.
    begun: bool,
    windows: usize,
    /// The last windows with their speeds, until it is known which follow them.
    waiting: VecDeque<(Slot, Option<Going>)>,
    /// The speed of the window before these.
    before: Option<Going>,
    /// Whether it is yet to be seen how often the log is read; not where the rover file says how long windows are.
    open: bool,
    /// Longer windows than usual.
    wider: Option<Wider>,
    /// How long they would be with three readings of every channel, where they hold two \[s\].
    roomier: Option<f64>,
}

impl Stream {
    /// # Errors
    /// A rover file without vehicle.
    pub(crate) fn new(rover: &Rover) -> Result<Self, GapError> {
        Ok(Stream {
            rover: rover.clone(),
            reader: Reader::new(rover)?,
            rest: DriveLog::default(),
            next: 0,
            begun: false,
            windows: 0,
            waiting: VecDeque::new(),
            before: None,
            open: !rover.gap.window_given,
            wider: None,
            roomier: None,
        })
    }

    /// What to heed where windows are longer than usual.
    pub(crate) fn widened(&self, prefix: &str) -> Option<String> {
        self.wider.as_ref().map(|wider| wider.note(prefix))
    }

    /// How long they would be with three readings of every channel, where they hold two \[s\].
    pub(crate) fn roomier(&self) -> Option<f64> {
        self.roomier
    }

    /// How long they are.
    pub(crate) fn window(&self) -> f64 {
        self.rover.gap.window
    }

    /// The windows that a piece completes, each once two more have shown how the speed goes on; with `last` also the one that it
    /// leaves unfinished.
    ///
    /// # Errors
    /// A used channel without noise.
    pub(crate) fn push(&mut self, piece: &DriveLog, last: bool) -> Result<Vec<Slot>, GapError> {
        if !piece.is_empty() {
            self.reader.needs_noise_of(piece)?;
            if std::mem::take(&mut self.open) {
                let usual = self.window();
                if let Some(wider) = wider(piece, usual) {
                    self.rover.gap.window = wider.window;
                    self.reader.widen(wider.window);
                    self.wider = Some(wider);
                } else {
                    self.roomier = roomier(piece, usual).map(|wider| wider.window);
                }
            }
        }
        let log = if self.rest.is_empty() {
            Cow::Borrowed(piece)
        } else {
            Cow::Owned(joined(&self.rest, piece))
        };
        let mut out = vec![];
        let mut row = self.next;
        for (k, segment) in log.segments.iter().enumerate() {
            let end_of_log = k + 1 == log.segments.len();
            if row >= segment.rows.end {
                continue;
            }
            if row == segment.rows.start || !self.begun {
                out.extend(self.settled(0));
                self.before = None;
                self.reader.begin_segment(&log, &segment.name, row);
                self.begun = true;
            }
            while row < segment.rows.end {
                let Some(&t0) = log.time.get(row) else {
                    break;
                };
                let full = |r: &usize| {
                    log.time
                        .get(*r)
                        .is_some_and(|t| is_full(t0, *t, &self.rover))
                };
                let end = (row..segment.rows.end).find(full);
                if end.is_none() && end_of_log && !last {
                    break;
                }
                let end = end.unwrap_or(segment.rows.end);
                let slot = Slot {
                    number: self.windows,
                    taken: self.reader.one(&log, row..end),
                    segment: self.reader.segment().to_owned(),
                };
                self.waiting.push_back((slot, self.reader.going));
                out.extend(self.settled(FOLLOW));
                self.windows += 1;
                row = end;
            }
        }
        if last {
            out.extend(self.settled(0));
        }
        let from = row.saturating_sub(1);
        self.next = row - from;
        let rest = rows(&log, from..log.len());
        self.rest = rest;
        Ok(out)
    }

    /// The windows that wait, but for the last so many, which others may follow in their segment.
    fn settled(&mut self, but: usize) -> Vec<Slot> {
        let mut out = vec![];
        while self.waiting.len() > but {
            let Some((mut slot, own)) = self.waiting.pop_front() else {
                break;
            };
            if let Some((taken, own)) = slot.taken.as_mut().zip(own) {
                let next = |k: usize| self.waiting.get(k).and_then(|(_, going)| *going);
                taken.lies_between(self.before, own, [next(0), next(1)], self.rover.gap.window);
            }
            self.before = own;
            out.push(slot);
        }
        out
    }
}

fn series_of(log: &DriveLog) -> [&Option<Series>; 8] {
    [
        &log.ground_speed,
        &log.yaw_rate,
        &log.accel_x,
        &log.pitch,
        &log.roll,
        &log.distance,
        &log.payload,
        &log.pass,
    ]
}

/// A log of what a window reads; `singles` in the order of [`series_of`].
fn assemble(
    time: Vec<f64>,
    segments: Vec<Segment>,
    singles: [Option<Series>; 8],
    wheel_speed: [Series; 4],
    wheel_torque: Option<[Series; 4]>,
) -> DriveLog {
    let [
        ground_speed,
        yaw_rate,
        accel_x,
        pitch,
        roll,
        distance,
        payload,
        pass,
    ] = singles;
    DriveLog {
        time,
        segments,
        wheel_speed,
        wheel_torque,
        ground_speed,
        yaw_rate,
        accel_x,
        pitch,
        roll,
        distance,
        payload,
        pass,
        ..DriveLog::default()
    }
}

/// Some rows of a log.
pub(crate) fn rows(log: &DriveLog, range: Range<usize>) -> DriveLog {
    let one = |s: &Series| -> Series { s.iter().take(range.end).skip(range.start).collect() };
    let within = |row: usize| row.clamp(range.start, range.end) - range.start;
    let segments = log
        .segments
        .iter()
        .filter(|s| s.rows.end > range.start && s.rows.start < range.end)
        .map(|s| Segment {
            name: s.name.clone(),
            rows: within(s.rows.start)..within(s.rows.end),
        })
        .collect();
    assemble(
        log.time.get(range.clone()).unwrap_or_default().to_vec(),
        segments,
        series_of(log).map(|s| s.as_ref().map(one)),
        log.wheel_speed.each_ref().map(one),
        log.wheel_torque.as_ref().map(|t| t.each_ref().map(one)),
    )
}

/// One log after the other; a segment that goes on in the second is one.
pub(super) fn joined(a: &DriveLog, b: &DriveLog) -> DriveLog {
    let (n, m) = (a.len(), b.len());
    let whole = |a: Option<&Series>, b: Option<&Series>| -> Series {
        let get = |s: Option<&Series>, row| s.and_then(|s| s.get(row));
        let first = (0..n).map(|row| get(a, row));
        first.chain((0..m).map(|row| get(b, row))).collect()
    };
    let single = |(a, b): (&Option<Series>, &Option<Series>)| {
        (a.is_some() || b.is_some()).then(|| whole(a.as_ref(), b.as_ref()))
    };
    let mut pairs = series_of(a).into_iter().zip(series_of(b)).map(single);
    let singles = std::array::from_fn(|_| pairs.next().flatten());
    let torque = |log: &'_ DriveLog, q: usize| log.wheel_torque.as_ref().map(|t| t[q].clone());
    let wheel_torque = (a.wheel_torque.is_some() || b.wheel_torque.is_some())
        .then(|| std::array::from_fn(|q| whole(torque(a, q).as_ref(), torque(b, q).as_ref())));
    let mut segments = a.segments.clone();
    for s in &b.segments {
        let rows = s.rows.start + n..s.rows.end + n;
        match segments.last_mut() {
            Some(open) if open.name == s.name && goes_on(a, b, s) => open.rows.end = rows.end,
            _ => segments.push(Segment {
                name: s.name.clone(),
                rows,
            }),
        }
    }
    assemble(
        a.time.iter().chain(&b.time).copied().collect(),
        segments,
        singles,
        std::array::from_fn(|q| whole(a.wheel_speed.get(q), b.wheel_speed.get(q))),
        wheel_torque,
    )
}

/// True where a piece begins inside the segment that the last one ended in: time strictly increases inside a segment.
fn goes_on(a: &DriveLog, b: &DriveLog, segment: &Segment) -> bool {
    let ends = a.time.last().zip(b.time.first());
    segment.rows.start == 0 && ends.is_some_and(|(before, after)| before < after)
}
