//! The filter on its way over the rows of a log: starts, steps, repeated instants, late rows.

use std::collections::VecDeque;
use std::sync::Arc;

use terra_model::Vehicle;

use super::clock::{Arrival, Clock};
use super::driver::{required, settings};
use super::facts::SegmentFacts;
use super::inputs::{Input, InputState, Inputs, torque_name};
use super::row::RobotRow;
use super::start::{AHEAD, first_belief, plausible, sample};
use super::stuck::StuckWatch;
use super::{Dropped, Flag, ForceConfig, Step};
use crate::error::FilterError;
use crate::filter::Filter;
use crate::measurement::{Innovation, Measurement};
use crate::smoother::{Passage, smooth};
use crate::spaces::LongitudinalRobot;
use crate::spaces::longitudinal_robot::{CHANNEL_NAMES, CHANNELS, STATES, T, T_RATE, V, W};
use crate::state_space::StateSpace;

/// An unknown torque is white noise of so many times the prior's spread: the wheel speed then says nothing about the
/// resistance, in numbers that squares still bear.
const UNKNOWN_TORQUE: f64 = 100.0;

/// What happened at one instant, and the filter after it, to go back to.
struct Instant {
    step: usize,
    time: f64,
    input: Input,
    z: Measurement,
    after: Option<Box<dyn Filter>>,
}

/// A passage and the steps it belongs to.
struct Passed {
    time: f64,
    steps: Vec<usize>,
    passage: Passage,
}

/// The segment that is run.
struct Segment {
    number: usize,
    facts: SegmentFacts,
    inputs: Inputs,
    blind: Vec<&'static str>,
    swapped: bool,
    clock: Clock,
    /// Rows run.
    rows: usize,
    /// Row at which the filter last started.
    started: usize,
    /// Readings and torques of the row before.
    before: Option<([Option<f64>; CHANNELS], [f64; 4])>,
}

/// The first of two passes over a log that is longer than memory: it gathers what the filter must know of a segment before
/// the segment's first row. Memory: the segments, and a million steps of the clock.
///
/// Rows go in as they stand in the log, [`FirstPass::segment`] before those of each segment. Then the same rows go through
/// the [`ForceRun`] that comes of it.
pub struct FirstPass<'c> {
    run: ForceRun<'c>,
    there: [bool; CHANNELS],
    rows: usize,
}

impl<'c> FirstPass<'c> {
    /// A pass for a configuration.
    ///
    /// # Errors
    /// As [`estimate_forces`](super::estimate_forces) for a configuration that does not do, whatever the log.
    pub fn new(config: &'c ForceConfig) -> Result<Self, FilterError> {
        settings(config)?;
        Ok(FirstPass {
            run: ForceRun::new(config)?,
            there: [false; CHANNELS],
            rows: 0,
        })
    }

    /// Begins the next segment.
    pub fn segment(&mut self) {
        self.close();
        let facts = SegmentFacts::new(self.run.config.space.vehicle());
        self.run.facts.push_back(facts);
    }

    /// Takes the next row in; one before any segment is in none, and is not estimated.
    pub fn row(&mut self, row: &RobotRow) {
        let config = self.run.config;
        for (there, reading) in self.there.iter_mut().zip(row.channels) {
            *there |= reading.is_some_and(f64::is_finite);
        }
        self.rows += 1;
        if let Some(facts) = self.run.facts.back_mut() {
            facts.see(row, config.no_ground_speed, config.late);
        }
    }

    /// The run, once all rows were seen.
    ///
    /// # Errors
    /// [`FilterError::MissingChannel`] for a log without wheel speeds or, unless declared, ground speed.
    pub fn run(self) -> Result<ForceRun<'c>, FilterError> {
        if self.rows > 0 {
            required(self.run.config, |i| self.there[i])?;
        }
        Ok(self.begin())
    }

    pub(super) fn begin(mut self) -> ForceRun<'c> {
        self.close();
        self.run
    }

    fn close(&mut self) {
        if let Some(facts) = self.run.facts.back_mut() {
            facts.pace.close();
        }
    }
}

/// The filter on its way over a log, after a [`FirstPass`] over it. Steps come out as soon as they are known: 256 rows
/// behind the row that goes in, and at the latest with the next segment or with [`ForceRun::finish`].
/// Smoothed steps come with their whole segment.
pub struct ForceRun<'c> {
    config: &'c ForceConfig,
    /// Of the segments to come.
    facts: VecDeque<SegmentFacts>,
    segment: Option<Segment>,
    /// Segments begun.
    segments: usize,
    /// Rows of the segment that are not run yet: a start may need readings of later rows.
    ahead: VecDeque<RobotRow>,
    /// Steps made, those given out included.
    made: usize,
    /// Steps that may yet be smoothed.
    held: Vec<Step>,
    space: LongitudinalRobot,
    filter: Box<dyn Filter>,
    stuck: StuckWatch,
    passed: Vec<Passed>,
    /// The last instant, and those before it that late rows may reach.
    past: VecDeque<Instant>,
}

fn build(config: &ForceConfig, space: LongitudinalRobot) -> Result<Box<dyn Filter>, FilterError> {
    let registry = &config.registry;
    registry.filter(&config.filter, Arc::new(space), config.settings)
}

impl<'c> ForceRun<'c> {
    fn new(config: &'c ForceConfig) -> Result<Self, FilterError> {
        let noise = StateSpace::measurement_noise(&config.space);
        Ok(ForceRun {
            config,
            facts: VecDeque::new(),
            segment: None,
            segments: 0,
            ahead: VecDeque::new(),
            made: 0,
            held: Vec::new(),
            space: config.space,
            filter: build(config, config.space)?,
            stuck: StuckWatch::new(noise.diagonal().iter().map(|v| v.sqrt())),
            passed: Vec::new(),
            past: VecDeque::new(),
        })
    }

    /// Begins the next segment; the steps of the one before go to `out`.
    ///
    /// # Errors
    /// As [`ForceRun::row`].
    pub fn segment(&mut self, out: &mut Vec<Step>) -> Result<(), FilterError> {
        self.close(out)?;
        let number = self.segments;
        self.segments += 1;
        let facts = self.facts.pop_front();
        let facts = facts.ok_or(FilterError::FirstPass { segment: number })?;
        let config = self.config;
        if facts.inputs.with_pitch() != self.space.has_pitch_input() {
            self.space = if facts.inputs.with_pitch() {
                self.space.with_pitch_input()
            } else {
                config.space.with_mass(self.space.vehicle().mass)?
            };
            self.filter = build(config, self.space)?;
        }
        let mut blind = self.not_observable(&facts.present)?;
        blind.extend(facts.inputs.absent());
        self.segment = Some(Segment {
            number,
            inputs: Inputs::new(&facts.inputs),
            blind,
            swapped: facts.turning.swapped(),
            clock: Clock::new(&facts.pace, config.restart_gap, config.late),
            rows: 0,
            started: 0,
            before: None,
            facts,
        });
        Ok(())
    }

    /// Takes the next row of the segment in; the steps that are known with it go to `out`.
    ///
    /// # Errors
    /// [`FilterError::AtRow`] around what goes wrong at this row or one before it: a time that is none, a payload that
    /// leaves no mass, or what the filter raises. [`FilterError::FirstPass`] for a row that the first pass did not meet.
    pub fn row(&mut self, row: &RobotRow, out: &mut Vec<Step>) -> Result<(), FilterError> {
        self.ahead.push_back(*row);
        match self.ahead.len() > AHEAD {
            true => self.run_next(out),
            false => Ok(()),
        }
    }

    /// Ends the log; all steps that are left go to `out`.
    ///
    /// # Errors
    /// As [`ForceRun::row`].
    pub fn finish(mut self, out: &mut Vec<Step>) -> Result<(), FilterError> {
        self.close(out)
    }

    fn close(&mut self, out: &mut Vec<Step>) -> Result<(), FilterError> {
        while !self.ahead.is_empty() {
            self.run_next(out)?;
        }
        self.settle()?;
        out.append(&mut self.held);
        self.segment = None;
        Ok(())
    }

    fn run_next(&mut self, out: &mut Vec<Step>) -> Result<(), FilterError> {
        let Some(row) = self.ahead.pop_front() else {
            return Ok(());
        };
        let met = self.segment.take().filter(|s| s.rows < s.facts.rows);
        let mut segment = met.ok_or(FilterError::FirstPass {
            segment: self.segments.saturating_sub(1),
        })?;
        let step = self
            .step(&mut segment, &row)
            .map_err(|e| FilterError::AtRow {
                row: row.row,
                time: row.time,
                source: Box::new(e),
            })?;
        segment.rows += 1;
        self.segment = Some(segment);
        self.made += 1;
        match self.config.smooth {
            true => self.held.push(step),
            false => out.push(step),
        }
        Ok(())
    }

    /// Channels absent from the whole segment, when some states cannot be known without them.
    fn not_observable(&self, present: &[bool; CHANNELS]) -> Result<Vec<&'static str>, FilterError> {
        let there: Vec<usize> = (0..CHANNELS).filter(|&i| present[i]).collect();
        if there.len() == CHANNELS || self.filter.space().observability_rank(&there)? == STATES {
            return Ok(Vec::new());
        }
        Ok((0..CHANNELS)
            .filter(|&i| !present[i])
            .map(|i| CHANNEL_NAMES[i])
            .collect())
    }

    /// The first reading of a channel that a robot can have, after the row that is run.
    fn next_reading(&self, segment: &Segment, channel: usize) -> Option<f64> {
        let near = self
            .ahead
            .iter()
            .take(AHEAD)
            .find_map(|row| row.channels[channel].filter(|v| plausible(channel, *v)));
        near.or_else(|| segment.facts.beyond(channel, segment.rows))
    }

    fn step(&mut self, segment: &mut Segment, row: &RobotRow) -> Result<Step, FilterError> {
        let time = row.time;
        let arrival = segment.clock.place(time)?;
        let input = segment.inputs.next(row);
        let (mut z, mut dropped) = self.readings(segment, row, &input, arrival);
        let mut taken = Vec::new();
        let step = self.made;
        let at = |z: &[Option<f64>]| Instant {
            step,
            time,
            input,
            z: Measurement::new(z),
            after: None,
        };
        let mut too_late = false;
        let (innovation, belief) = match arrival {
            Arrival::Start { .. } => {
                self.settle()?;
                self.carry(input.payload)?;
                let next = |channel| self.next_reading(segment, channel);
                let none = self.config.no_ground_speed;
                let belief;
                (belief, taken) = first_belief(&self.space, row, next, &input, none, &dropped);
                for &i in &taken {
                    z[i] = None;
                }
                self.filter.restart(belief)?;
                segment.started = row.row;
                self.past.clear();
                let innovation = self.pass(at(&z), segment.clock.disordered)?;
                (innovation, self.filter.belief().clone())
            }
            Arrival::Next(_) | Arrival::Again => {
                let innovation = self.pass(at(&z), segment.clock.disordered)?;
                (innovation, self.filter.belief().clone())
            }
            Arrival::Late => match self.past.iter().rposition(|p| p.time <= time) {
                Some(before) => self.replay(at(&z), before)?,
                None => {
                    too_late = true;
                    dropped.extend(
                        (0..CHANNELS)
                            .filter(|&i| z[i].is_some())
                            .map(|i| (i, Dropped::TooLate)),
                    );
                    let belief = self.filter.belief().clone();
                    (Innovation::empty(CHANNELS), belief)
                }
            },
        };
        let odd_time = too_late
            || matches!(arrival, Arrival::Late | Arrival::Again)
            || matches!(arrival, Arrival::Next(dt) if segment.clock.rows_missing(dt));
        let jumped = arrival == Arrival::Start { jumped: true };
        let flag = flag(
            segment,
            self.config,
            row.row,
            &innovation,
            &taken,
            &dropped,
            &input,
            jumped,
            odd_time,
        );
        Ok(Step {
            row: row.row,
            segment: segment.number,
            time,
            flag,
            since_start: row.row - segment.started,
            nis: innovation.nis,
            dof: innovation.dof,
            belief,
            innovation,
            taken,
            dropped,
            torque: input.torque,
            torque_state: input.state,
            vehicle: Vehicle {
                pitch: input.pitch.map_or(self.space.vehicle().pitch, |p| p.0),
                ..*self.space.vehicle()
            },
        })
    }

    /// The readings to show the filter, and those to keep from it.
    fn readings(
        &mut self,
        segment: &mut Segment,
        row: &RobotRow,
        input: &Input,
        arrival: Arrival,
    ) -> ([Option<f64>; CHANNELS], Vec<(usize, Dropped)>) {
        let mut z = sample(row, self.config.no_ground_speed);
        let mut dropped = Vec::new();
        let before = segment.before.replace((z, input.torque));
        let repeated = arrival == Arrival::Again && before == Some((z, input.torque));
        let belief = self.filter.belief();
        let sd = belief.sd(V).unwrap_or(f64::INFINITY);
        let moving = belief.mean[V].abs() > 0.05 + 3.0 * sd;
        for (i, reading) in z.iter_mut().enumerate() {
            let Some(value) = *reading else { continue };
            let why = if repeated {
                Dropped::Duplicate
            } else if !plausible(i, value) {
                Dropped::Implausible
            } else if arrival != Arrival::Late && self.stuck.observe(i, value, moving) {
                Dropped::Stuck
            } else {
                continue;
            };
            *reading = None;
            dropped.push((i, why));
        }
        (z, dropped)
    }

    /// Takes a payload on: the mass changes, the belief stays. What was estimated with the other mass is closed.
    fn carry(&mut self, payload: f64) -> Result<(), FilterError> {
        let mass = self.config.space.vehicle().mass + payload;
        if mass == self.space.vehicle().mass {
            return Ok(());
        }
        self.settle()?;
        self.space = self.space.with_mass(mass)?;
        let belief = self.filter.belief().clone();
        self.filter = build(self.config, self.space)?;
        self.filter.restart(belief)
    }

    /// Moves the filter from the last instant to the next and takes its sample in.
    fn pass(&mut self, mut now: Instant, keep: bool) -> Result<Innovation, FilterError> {
        self.carry(now.input.payload)?;
        let mut still = true;
        if let Some(before) = self.past.back() {
            let dt = now.time - before.time;
            if dt > 0.0 {
                still = false;
                self.filter.predict(&now.input.vector(&before.input), dt)?;
                let doubt = doubt(&self.space, &before.input, &now.input, dt);
                if doubt.iter().any(|v| *v > 0.0) {
                    self.filter.widen(&doubt)?;
                }
            }
        }
        let innovation = self.filter.update(&now.z)?;
        if self.config.smooth {
            let passage = Passage::of(&*self.filter);
            match self.passed.last_mut().filter(|_| still) {
                // A second sample of the same instant: one passage with all that is known after it.
                Some(last) => {
                    last.passage.filtered = passage.filtered;
                    last.steps.push(now.step);
                }
                None => self.passed.push(Passed {
                    time: now.time,
                    steps: vec![now.step],
                    passage,
                }),
            }
        }
        if keep {
            now.after = Some(self.filter.boxed_clone());
            let oldest = now.time - self.config.late;
            while self.past.get(1).is_some_and(|p| p.time <= oldest) {
                self.past.pop_front();
            }
        } else {
            self.past.clear();
        }
        self.past.push_back(now);
        Ok(innovation)
    }

    /// Goes back to the instant `before` a late one, and forward again over all that came since. The belief given is the
    /// one at the late instant.
    fn replay(
        &mut self,
        late: Instant,
        before: usize,
    ) -> Result<(Innovation, crate::gaussian::Gaussian), FilterError> {
        let since: Vec<Instant> = self.past.drain(before + 1..).collect();
        let then = self.past.back().and_then(|p| p.after.as_ref());
        if let Some(then) = then {
            self.filter = then.boxed_clone();
        }
        while self.passed.last().is_some_and(|p| p.time > late.time) {
            self.passed.pop();
        }
        let innovation = self.pass(late, true)?;
        let belief = self.filter.belief().clone();
        for instant in since {
            self.pass(instant, true)?;
        }
        Ok((innovation, belief))
    }

    /// Replaces the beliefs of one unbroken run of the filter by smoothed ones.
    fn settle(&mut self) -> Result<(), FilterError> {
        let passages: Vec<Passage> = self.passed.iter().map(|p| p.passage.clone()).collect();
        let given = self.made - self.held.len();
        for (passed, belief) in self.passed.drain(..).zip(smooth(&passages)?) {
            for step in passed.steps {
                if let Some(step) = self.held.get_mut(step - given) {
                    step.belief = belief.clone();
                }
            }
        }
        Ok(())
    }
}

/// Variance to add to each state for torques that were unknown over a step.
fn doubt(space: &LongitudinalRobot, before: &Input, now: &Input, dt: f64) -> [f64; STATES] {
    let mut variance = [0.0; STATES];
    let prior = space.prior_spread();
    for q in 0..4 {
        let unknown = InputState::Unknown;
        if before.state[q] == unknown || now.state[q] == unknown {
            let push = UNKNOWN_TORQUE * prior.torque * dt / space.vehicle().wheel_inertia;
            variance[W[q]] = push * push;
        }
        if now.state[q] == InputState::Returned {
            variance[T[q]] = prior.torque * prior.torque;
            variance[T_RATE[q]] = prior.rate * prior.rate;
        }
    }
    variance
}

fn flag(
    segment: &Segment,
    config: &ForceConfig,
    row: usize,
    innovation: &Innovation,
    taken: &[usize],
    dropped: &[(usize, Dropped)],
    input: &Input,
    jumped: bool,
    odd_time: bool,
) -> Flag {
    let torques = |wanted: &[InputState]| {
        (0..4)
            .filter(|&q| wanted.contains(&input.state[q]))
            .map(torque_name)
            .collect::<Vec<_>>()
    };
    let mut resets: Vec<&'static str> = innovation
        .resets
        .iter()
        .map(|&i| CHANNEL_NAMES[i])
        .collect();
    resets.extend(torques(&[InputState::Returned]));
    if jumped {
        return Flag::Reset(Vec::new());
    }
    if !resets.is_empty() {
        return Flag::Reset(resets);
    }
    if row - segment.started < config.start_wait {
        return Flag::Starting;
    }
    if !segment.blind.is_empty() {
        return Flag::NotObservable(segment.blind.clone());
    }
    let repeated = |i: usize| dropped.contains(&(i, Dropped::Duplicate));
    let mut degraded: Vec<&'static str> = (0..CHANNELS)
        .filter(|&i| match innovation.ratio.get(i) {
            Some(ratio) => ratio > 1.0,
            None => !taken.contains(&i) && !repeated(i),
        })
        .map(|i| CHANNEL_NAMES[i])
        .collect();
    degraded.extend(torques(&[InputState::Held, InputState::Unknown]));
    if input.pitch.is_some_and(|p| p.1) {
        degraded.push("pitch");
    }
    if odd_time {
        degraded.push("time");
    }
    if segment.swapped {
        degraded.push("sides");
    }
    if degraded.is_empty() {
        Flag::Ok
    } else {
        Flag::Degraded(degraded)
    }
}
