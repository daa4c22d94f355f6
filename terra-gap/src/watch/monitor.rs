//! The sliding spans, and the events that open and close over them.

use std::collections::VecDeque;

use serde::Serialize;

use super::SPANS;
use super::baseline::Learned;
use super::event::{Instant, WatchEvent, describe};
use super::window::{Contribution, Span, Standing};

/// Looks of the shortest span without a score beyond its threshold after which an event is over.
const QUIET: usize = 20;

/// One span as it stands.
#[derive(Clone, Debug, Serialize)]
pub struct Look {
    /// Its length in windows.
    pub windows: usize,
    /// The channel or effect with the largest score.
    pub score: String,
    /// That score, in standard deviations.
    pub sigma: f64,
    /// What it would have to be.
    pub threshold: f64,
}

/// What one window showed.
#[derive(Clone, Debug)]
pub struct WatchStep {
    /// Where it lies.
    pub at: Instant,
    /// The spans that were looked at: each at a fifth of its length.
    pub looks: Vec<Look>,
    /// True while an event is open.
    pub open: bool,
    /// An event that this window opened.
    pub opened: Option<WatchEvent>,
    /// An event that it closed, with all that was learned meanwhile.
    pub closed: Option<WatchEvent>,
}

/// A score that passed its threshold.
struct Passed {
    score: usize,
    excess: f64,
    threshold: f64,
    standing: Standing,
    windows: usize,
}

/// Slides over the windows after the baseline.
pub(crate) struct Monitor {
    window_s: f64,
    ring: VecDeque<Contribution>,
    /// Used windows since the baseline.
    steps: usize,
    /// Looks made so far, by span.
    looks: [usize; SPANS.len()],
    open: Option<(WatchEvent, f64)>,
    quiet: usize,
}

impl Monitor {
    pub(crate) fn new(window_s: f64) -> Self {
        Monitor {
            window_s,
            ring: VecDeque::new(),
            steps: 0,
            looks: [0; SPANS.len()],
            open: None,
            quiet: 0,
        }
    }

    pub(crate) fn step(&mut self, contribution: Contribution, learned: &Learned) -> WatchStep {
        let at = Instant::of(&contribution.spot);
        if self.ring.len() == SPANS.iter().copied().max().unwrap_or(1) {
            self.ring.pop_front();
        }
        self.ring.push_back(contribution);
        self.steps += 1;
        let (looks, passed) = self.look(learned);
        let (mut opened, mut closed) = (None, None);
        let looked_short = looks.iter().any(|l| l.windows == SPANS[0]);
        match passed {
            Some(passed) => {
                self.quiet = 0;
                let more = self.open.as_ref().is_none_or(|o| passed.excess > o.1);
                if more && let Some(event) = self.event(&passed, learned, &at) {
                    match &mut self.open {
                        None => {
                            opened = Some(event.clone());
                            self.open = Some((event, passed.excess));
                        }
                        // The clearest look describes an event best; when and by what it was flagged stays.
                        Some((open, excess)) => {
                            *open = WatchEvent {
                                flagged: open.flagged.clone(),
                                onset: open.onset.clone(),
                                delay_s: open.delay_s,
                                score: open.score.clone(),
                                sigma: open.sigma,
                                threshold: open.threshold,
                                span_s: open.span_s,
                                ..event
                            };
                            *excess = passed.excess;
                        }
                    }
                }
            }
            None if looked_short => self.quiet += 1,
            None => {}
        }
        if self.quiet >= QUIET
            && let Some((mut event, _)) = self.open.take()
        {
            event.closed = Some(at.clone());
            closed = Some(event);
            // What is over is no part of what may come.
            self.ring.clear();
        }
        WatchStep {
            at,
            looks,
            open: self.open.is_some(),
            opened,
            closed,
        }
    }

    /// Windows that were looked at.
    pub(crate) fn watched(&self) -> usize {
        self.steps
    }

    /// The log is over: an open event stays open, with all that was learned.
    pub(crate) fn finish(&mut self) -> Option<WatchStep> {
        let at = Instant::of(&self.ring.back()?.spot);
        let (event, _) = self.open.take()?;
        Some(WatchStep {
            at,
            looks: vec![],
            open: true,
            opened: None,
            closed: Some(event),
        })
    }

    /// Looks at the spans that are due.
    fn look(&mut self, learned: &Learned) -> (Vec<Look>, Option<Passed>) {
        let mut looks = vec![];
        let mut passed: Option<Passed> = None;
        for (s, &windows) in SPANS.iter().enumerate() {
            if self.ring.len() < windows || !self.steps.is_multiple_of(windows / 5) {
                continue;
            }
            let threshold = learned.spending.threshold(self.looks[s]);
            self.looks[s] += 1;
            let scores = standings(&self.span(windows, learned), learned);
            let mut best: Option<(usize, f64)> = None;
            for (k, standing) in scores.iter().enumerate() {
                let Some(standing) = standing else { continue };
                let z = counted(k, standing.z, learned);
                if best.is_none_or(|b| z > b.1) {
                    best = Some((k, z));
                }
                let excess = z / threshold;
                if excess > 1.0 && passed.as_ref().is_none_or(|p| excess > p.excess) {
                    passed = Some(Passed {
                        score: k,
                        excess,
                        threshold,
                        standing: *standing,
                        windows,
                    });
                }
            }
            if let Some((k, sigma)) = best {
                looks.push(Look {
                    windows,
                    score: learned.names.get(k).cloned().unwrap_or_default(),
                    sigma,
                    threshold,
                });
            }
        }
        (looks, passed)
    }

    fn span(&self, windows: usize, learned: &Learned) -> Span {
        let mut span = Span::empty(learned.nominal.null.len(), learned.scales.len());
        for c in self.ring.iter().rev().take(windows) {
            span.add(c);
        }
        span
    }

    fn event(&self, passed: &Passed, learned: &Learned, at: &Instant) -> Option<WatchEvent> {
        // Where the score that passed would be clearest, had the span begun there.
        let mut span = Span::empty(learned.nominal.null.len(), learned.scales.len());
        let mut clearest = (0.0, 1);
        for c in self.ring.iter().rev() {
            span.add(c);
            let found = standings(&span, learned);
            if let Some(standing) = found.get(passed.score).copied().flatten()
                && standing.z.abs() > clearest.0
                && standing.z * passed.standing.z > 0.0
            {
                clearest = (standing.z.abs(), span.windows);
            }
        }
        let since: Vec<&Contribution> = self.ring.iter().rev().take(clearest.1).collect();
        let onset = Instant::of(&since.last()?.spot);
        let span = self.span(clearest.1, learned);
        let scores = standings(&span, learned);
        let delay_s = (at.window + 1 - onset.window) as f64 * self.window_s;
        let mut event = describe(&since, &span, &scores, learned)?;
        event.flagged = at.clone();
        event.onset = onset;
        event.delay_s = delay_s;
        event.sigma = passed.excess * passed.threshold;
        event.threshold = passed.threshold;
        event.score = learned.names.get(passed.score).cloned()?;
        event.span_s = passed.windows as f64 * self.window_s;
        Some(event)
    }
}

/// All scores in the units of their own scatter.
fn standings(span: &Span, learned: &Learned) -> Vec<Option<Standing>> {
    let channels = learned.nominal.channels.len();
    let mut all = span.standings(&learned.nominal.information, channels);
    for (standing, scale) in all.iter_mut().zip(&learned.scales) {
        if let Some(s) = standing {
            s.z /= scale;
        }
    }
    all
}

/// A score as it counts: magnitudes of one-sided effects have one direction.
fn counted(k: usize, z: f64, learned: &Learned) -> f64 {
    if learned.one_sided.get(k).copied().unwrap_or(false) {
        z.max(0.0)
    } else {
        z.abs()
    }
}
