//! The motion between the rows of a log, for sensors that are late.

use crate::integrate::Step;
use crate::robot::{LATERAL_SPEED, PATH, SPEED, STATES, WHEELS_AT, YAW_RATE};

/// Numbers kept a step: v, r, four ω, v_y, path.
const KEPT: usize = 8;

/// A channel whose value is known at each step of the integrator.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Known {
    Speed,
    YawRate,
    Wheel(usize),
    LateralSpeed,
    Path,
}

impl Known {
    fn index(self) -> usize {
        match self {
            Known::Speed => 0,
            Known::YawRate => 1,
            Known::Wheel(q) => 2 + q,
            Known::LateralSpeed => 6,
            Known::Path => 7,
        }
    }
}

/// Motion at each step of the integrator, and inside long ones.
#[derive(Clone, Debug)]
pub(crate) struct History {
    /// Some sensor looks back.
    wanted: bool,
    /// (t, kept), in order; a reset starts a new piece.
    pieces: Vec<Vec<(f64, [f64; KEPT])>>,
}

/// What is kept lies no farther apart \[s\], because values are read straight between.
const SPACING: f64 = 1e-3;

fn kept(y: &[f64; STATES]) -> [f64; KEPT] {
    [
        y[SPEED],
        y[YAW_RATE],
        y[WHEELS_AT],
        y[WHEELS_AT + 1],
        y[WHEELS_AT + 2],
        y[WHEELS_AT + 3],
        y[LATERAL_SPEED],
        y[PATH],
    ]
}

impl History {
    /// Of a run; nothing is kept when no sensor looks back.
    pub(crate) fn new(wanted: bool) -> Self {
        History {
            wanted,
            pieces: Vec::new(),
        }
    }

    /// A run or a reset begins.
    pub(crate) fn begin(&mut self, time: f64, y: &[f64; STATES]) {
        self.pieces.push(vec![(time, kept(y))]);
    }

    /// A step of free length.
    pub(crate) fn follow(&mut self, step: &Step<STATES>) {
        if !self.wanted {
            return;
        }
        let length = step.end() - step.begin();
        let parts = (length / SPACING).ceil();
        let mut part = 1.0;
        while part < parts {
            let time = step.begin() + length * part / parts;
            self.push(time, &step.at(time));
            part += 1.0;
        }
        self.push(step.end(), step.last());
    }

    /// One step more.
    pub(crate) fn push(&mut self, time: f64, y: &[f64; STATES]) {
        if let Some(piece) = self.pieces.last_mut().filter(|_| self.wanted) {
            piece.push((time, kept(y)));
        }
    }

    /// When the piece that `time` lies in began.
    pub(crate) fn began(&self, time: f64) -> Option<f64> {
        self.piece(time)?.first().map(|(t, _)| *t)
    }

    fn piece(&self, time: f64) -> Option<&Vec<(f64, [f64; KEPT])>> {
        self.pieces
            .iter()
            .rev()
            .find(|p| p.first().is_some_and(|(t, _)| *t <= time + 1e-12))
    }

    /// The value a while before `time`, straight between steps; before the piece began, as at its beginning.
    pub(crate) fn at(&self, what: Known, time: f64, delay: f64) -> Option<f64> {
        let piece = self.piece(time)?;
        let wanted = time - delay;
        let k = what.index();
        let after = piece.partition_point(|(t, _)| *t <= wanted);
        let (before, next) = (piece.get(after.wrapping_sub(1)), piece.get(after));
        match (before, next) {
            (Some((t0, a)), Some((t1, b))) => {
                Some(a[k] + (b[k] - a[k]) * (wanted - t0) / (t1 - t0))
            }
            (Some((_, a)), None) | (None, Some((_, a))) => Some(a[k]),
            (None, None) => None,
        }
    }
}
