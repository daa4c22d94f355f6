//! Monitoring: when and where a gap opens in a long drive.
//!
//! The soil is fitted to the log's beginning and carried along with its posterior. Every further window then adds to one score
//! for each channel (a shift of its readings) and one for each effect (its signature), summed over the last 5, 20 and 80
//! windows, with what the soil's posterior leaves open projected out. A score beyond its threshold opens an event. Thresholds
//! grow with the length of the log, so that a log of any length without a gap raises an event with at most the stated
//! probability. What is kept in memory does not grow with the log.
//!
//! An event says where to look; names beside it are a hint, never a verdict: that is what [`diagnose_drive`](crate::diagnose_drive)
//! on the flagged stretch is for.

mod baseline;
mod event;
mod json;
mod monitor;
mod threshold;
mod window;

use terra_data::{DriveLog, Rover};
use terra_model::Registry;

pub use baseline::{ExpectedDelay, SoilValue, WatchBaseline};
pub use event::{Hint, Instant, WatchEvent};
pub use json::watch_json;
pub use monitor::{Look, WatchStep};

use crate::drive::{BENT, Held, Slot, Stream, bends, rows};
use crate::error::GapError;
use crate::parallel::for_each;
use baseline::{Learned, learn};
use monitor::Monitor;

/// Windows that scores are summed over.
pub(crate) const SPANS: [usize; 3] = [5, 20, 80];

/// Which part of the log is the baseline.
#[derive(Clone, Debug, PartialEq)]
pub enum BaselineSpan {
    /// So many seconds of driving from the log's beginning.
    Seconds(f64),
    /// The manoeuvre of this name. What comes before it is not looked at.
    Segment(String),
}

/// What is asked of a watch.
#[derive(Clone, Debug)]
pub struct WatchSettings {
    /// What the soil is learned from.
    pub baseline: BaselineSpan,
    /// Probability of an event in a log without a gap, whatever its length.
    pub false_alarms: f64,
    /// Effects that are scored, by name; `None` for all.
    pub effects: Option<Vec<String>>,
}

impl Default for WatchSettings {
    fn default() -> Self {
        WatchSettings {
            baseline: BaselineSpan::Seconds(20.0),
            false_alarms: 0.05,
            effects: None,
        }
    }
}

enum State {
    Learning(Vec<Slot>),
    Watching(Box<(Learned, Monitor)>),
    /// Nothing can be watched, and why.
    Refused(String),
}

/// Watches a drive as it comes in.
pub struct Watch {
    rover: Rover,
    registry: Registry,
    settings: WatchSettings,
    held: Held,
    /// When the log began \[s\].
    began: Option<f64>,
    /// Segments seen while the baseline's was looked for.
    segments: Vec<String>,
    stream: Stream,
    state: State,
    outside: usize,
    bent: usize,
    seen: usize,
}

impl Watch {
    /// A watch that has seen nothing yet.
    ///
    /// # Errors
    /// A rover file without vehicle; an option outside its range; an unknown effect.
    pub fn new(
        rover: &Rover,
        registry: &Registry,
        settings: &WatchSettings,
    ) -> Result<Self, GapError> {
        let option = |option, value: f64, expected| GapError::Option {
            option,
            value: value.to_string(),
            expected,
        };
        let alpha = settings.false_alarms;
        if !(alpha > 0.0 && alpha < 1.0) {
            return Err(option(
                "false alarms",
                alpha,
                "a probability between 0 and 1",
            ));
        }
        if let BaselineSpan::Seconds(s) = settings.baseline
            && !(s.is_finite() && s > 0.0)
        {
            return Err(option("baseline", s, "seconds above 0"));
        }
        for name in settings.effects.iter().flatten() {
            registry.effect(name)?;
        }
        Ok(Watch {
            rover: rover.clone(),
            registry: registry.clone(),
            settings: settings.clone(),
            held: Held::default(),
            began: None,
            segments: vec![],
            stream: Stream::new(rover)?,
            state: State::Learning(vec![]),
            outside: 0,
            bent: 0,
            seen: 0,
        })
    }

    /// Takes in the next piece of the log, however long, and says what its windows show. Where pieces end changes nothing. A
    /// piece whose first segment has the name of the last one's goes on with it while time increases.
    ///
    /// # Errors
    /// A configuration that makes no sense, or a used channel without noise level.
    pub fn push(&mut self, piece: &DriveLog) -> Result<Vec<WatchStep>, GapError> {
        self.began = self.began.or_else(|| piece.time.first().copied());
        // Whether a ground speed is held shows before the baseline is over, wherever pieces end.
        let ends = match &self.settings.baseline {
            BaselineSpan::Seconds(s) => self.began.map(|began| began + s),
            BaselineSpan::Segment(_) => None,
        };
        let over = ends.and_then(|ends| piece.time.iter().position(|&t| t >= ends));
        let mut steps = vec![];
        match over {
            Some(row) if self.held.is_open() => {
                steps.extend(self.read(&rows(piece, 0..row), true)?);
                steps.extend(self.read(&rows(piece, row..piece.len()), false)?);
            }
            _ => steps.extend(self.read(piece, false)?),
        }
        Ok(steps)
    }

    /// The windows that a piece completes; `last` where it is the end of what is looked at for a held ground speed.
    fn read(&mut self, piece: &DriveLog, last: bool) -> Result<Vec<WatchStep>, GapError> {
        let piece = self.held.pass(piece, last);
        let slots = self.stream.push(&piece, false)?;
        self.take(slots)
    }

    /// The end of the log: what its unfinished last window shows.
    ///
    /// # Errors
    /// As [`push`](Self::push); [`GapError::Segment`] where there is no baseline of that name.
    pub fn finish(&mut self) -> Result<Vec<WatchStep>, GapError> {
        let mut steps = self.read(&DriveLog::default(), true)?;
        let slots = self.stream.push(&DriveLog::default(), true)?;
        steps.extend(self.take(slots)?);
        if matches!(self.state, State::Learning(_)) {
            self.learn()?;
        }
        let nothing = match &mut self.state {
            State::Watching(watching) => {
                steps.extend(watching.1.finish());
                watching.1.watched() == 0
            }
            State::Learning(_) | State::Refused(_) => false,
        };
        if nothing {
            let (_, dropped) = self.windows();
            let mut reason =
                "no usable window comes after the baseline: nothing was watched".to_owned();
            for (k, (why, n)) in dropped.iter().enumerate() {
                reason += if k == 0 { "; left out: " } else { ", " };
                reason += &format!("{n} {why}");
            }
            self.state = State::Refused(reason);
        }
        Ok(steps)
    }

    /// What the baseline taught; none while it is not over, or where it taught nothing.
    pub fn baseline(&self) -> Option<&WatchBaseline> {
        match &self.state {
            State::Watching(watching) => Some(&watching.0.said),
            State::Learning(_) | State::Refused(_) => None,
        }
    }

    /// Why nothing can be watched.
    pub fn refused(&self) -> Option<&str> {
        match &self.state {
            State::Refused(reason) => Some(reason),
            State::Learning(_) | State::Watching(_) => None,
        }
    }

    /// Spans that scores are summed over \[s\].
    pub fn spans_s(&self) -> [f64; 3] {
        SPANS.map(|n| n as f64 * self.stream.window())
    }

    /// The settings.
    pub fn settings(&self) -> &WatchSettings {
        &self.settings
    }

    /// Windows that were looked at after the baseline.
    pub fn watched(&self) -> usize {
        match &self.state {
            State::Watching(watching) => watching.1.watched(),
            State::Learning(_) | State::Refused(_) => 0,
        }
    }

    /// Windows seen, and those left out by reason.
    pub fn windows(&self) -> (usize, std::collections::BTreeMap<String, usize>) {
        let mut dropped = self.stream.reader.dropped.clone();
        for (reason, n) in [(BENT, self.bent), ("outside the model", self.outside)] {
            if n > 0 {
                dropped.insert(reason.to_owned(), n);
            }
        }
        (self.seen, dropped)
    }

    fn take(&mut self, slots: Vec<Slot>) -> Result<Vec<WatchStep>, GapError> {
        self.seen += slots.len();
        let mut slots = slots.into_iter();
        while let State::Learning(learning) = &mut self.state {
            let Some(slot) = slots.next() else {
                return Ok(vec![]);
            };
            if learning.is_empty() && self.segments.last() != Some(&slot.segment) {
                self.segments.push(slot.segment.clone());
            }
            let over = match &self.settings.baseline {
                BaselineSpan::Seconds(s) => slot.number as f64 * self.stream.window() >= *s - 1e-9,
                BaselineSpan::Segment(name) => !learning.is_empty() && slot.segment != *name,
            };
            let inside = match &self.settings.baseline {
                BaselineSpan::Seconds(_) => !over,
                BaselineSpan::Segment(name) => slot.segment == *name,
            };
            if inside {
                learning.push(slot);
            } else if over {
                self.learn()?;
                slots = std::iter::once(slot)
                    .chain(slots)
                    .collect::<Vec<_>>()
                    .into_iter();
            }
        }
        match &mut self.state {
            State::Watching(watching) => {
                let (learned, monitor) = &mut **watching;
                let slots: Vec<Slot> = slots.collect();
                let read: Vec<_> = for_each(slots.len(), |k| {
                    let slot = &slots[k];
                    let mut taken = slot.taken.clone()?;
                    if bends(&taken, &learned.usual) {
                        return Some(Err(true));
                    }
                    let (number, segment) = (slot.number, slot.segment.as_str());
                    learned.own_noise.raise(&mut taken);
                    let found = learned.nominal.contribution(&taken, number, segment);
                    Some(found.map_err(|_| false))
                });
                let mut steps = vec![];
                for window in read.into_iter().flatten() {
                    match window {
                        Ok(contribution) => steps.push(monitor.step(contribution, learned)),
                        Err(true) => self.bent += 1,
                        Err(false) => self.outside += 1,
                    }
                }
                Ok(steps)
            }
            State::Learning(_) | State::Refused(_) => Ok(vec![]),
        }
    }

    fn learn(&mut self) -> Result<(), GapError> {
        let State::Learning(slots) = &mut self.state else {
            return Ok(());
        };
        if slots.is_empty() {
            if let BaselineSpan::Segment(name) = &self.settings.baseline
                && !self.segments.is_empty()
            {
                return Err(GapError::Segment {
                    name: name.clone(),
                    there: self.segments.join(", "),
                });
            }
            self.state = State::Refused("the log has no windows".to_owned());
            return Ok(());
        }
        let slots = std::mem::take(slots);
        self.rover.gap.window = self.stream.window();
        let reader = &self.stream.reader;
        let learned = learn(slots, reader, &self.rover, &self.registry, &self.settings)?;
        self.state = match learned {
            Ok(mut learned) => {
                learned.said.notes.extend(self.held.note(""));
                learned.said.notes.extend(self.stream.widened(""));
                let monitor = Monitor::new(self.stream.window());
                State::Watching(Box::new((learned, monitor)))
            }
            Err(reason) => State::Refused(reason),
        };
        Ok(())
    }
}
