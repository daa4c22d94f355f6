//! The filter on its way over the rows of a log: starts, steps, repeated instants, late rows.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use terra_model::Vehicle;

use super::clock::{Arrival, Clock};
use super::driver::not_observable;
use super::inputs::{Input, InputState, Inputs, torque_name};
use super::sides::swapped;
use super::start::{first_belief, plausible, sample};
use super::stuck::StuckWatch;
use super::{Dropped, Flag, ForceConfig, RobotLog, Step};
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

/// What is the same for all rows of a segment.
struct Segment {
    number: usize,
    rows: Range<usize>,
    inputs: Inputs,
    blind: Vec<&'static str>,
    swapped: bool,
    clock: Clock,
    started: usize,
}

pub(super) struct Run<'a> {
    log: &'a RobotLog<'a>,
    config: &'a ForceConfig,
    pub(super) steps: Vec<Step>,
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

impl<'a> Run<'a> {
    pub(super) fn new(log: &'a RobotLog<'a>, config: &'a ForceConfig) -> Result<Self, FilterError> {
        let noise = StateSpace::measurement_noise(&config.space);
        Ok(Run {
            log,
            config,
            steps: Vec::with_capacity(log.time.len()),
            space: config.space,
            filter: build(config, config.space)?,
            stuck: StuckWatch::new(noise.diagonal().iter().map(|v| v.sqrt())),
            passed: Vec::new(),
            past: VecDeque::new(),
        })
    }

    pub(super) fn segment(&mut self, number: usize, rows: Range<usize>) -> Result<(), FilterError> {
        let (log, config) = (self.log, self.config);
        let inputs = Inputs::new(log, rows.clone());
        let with_pitch = rows
            .clone()
            .next()
            .is_some_and(|k| inputs.at(k).pitch.is_some());
        if with_pitch != self.space.has_pitch_input() {
            self.space = if with_pitch {
                self.space.with_pitch_input()
            } else {
                config.space.with_mass(self.space.vehicle().mass)?
            };
            self.filter = build(config, self.space)?;
        }
        let mut blind = not_observable(log, config, &*self.filter, &rows)?;
        blind.extend(inputs.absent());
        let mut segment = Segment {
            number,
            inputs,
            blind,
            swapped: swapped(log, rows.clone(), config.space.vehicle()),
            clock: Clock::new(log.time, rows.clone(), config.restart_gap, config.late),
            started: rows.start,
            rows: rows.clone(),
        };
        for row in rows {
            self.row(&mut segment, row)
                .map_err(|e| FilterError::AtRow {
                    row,
                    time: log.time[row],
                    source: Box::new(e),
                })?;
        }
        self.finish()
    }

    fn row(&mut self, segment: &mut Segment, row: usize) -> Result<(), FilterError> {
        let time = self.log.time[row];
        let arrival = segment.clock.place(time)?;
        let input = segment.inputs.at(row);
        let (mut z, mut dropped) = self.readings(segment, row, arrival);
        let mut taken = Vec::new();
        let step = self.steps.len();
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
                self.finish()?;
                self.carry(input.payload)?;
                let ahead = row..segment.rows.end;
                let none = self.config.no_ground_speed;
                let belief;
                (belief, taken) =
                    first_belief(&self.space, self.log, ahead, &input, none, &dropped);
                for &i in &taken {
                    z[i] = None;
                }
                self.filter.restart(belief)?;
                segment.started = row;
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
            row,
            &innovation,
            &taken,
            &dropped,
            &input,
            jumped,
            odd_time,
        );
        self.steps.push(Step {
            row,
            segment: segment.number,
            time,
            flag,
            since_start: row - segment.started,
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
        });
        Ok(())
    }

    /// The readings to show the filter, and those to keep from it.
    fn readings(
        &mut self,
        segment: &Segment,
        row: usize,
        arrival: Arrival,
    ) -> ([Option<f64>; CHANNELS], Vec<(usize, Dropped)>) {
        let none = self.config.no_ground_speed;
        let mut z = sample(self.log, row, none);
        let mut dropped = Vec::new();
        let repeated = arrival == Arrival::Again && row > segment.rows.start && {
            let torque = |row: usize| segment.inputs.at(row).torque;
            z == sample(self.log, row - 1, none) && torque(row) == torque(row - 1)
        };
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
        self.finish()?;
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
    fn finish(&mut self) -> Result<(), FilterError> {
        let passages: Vec<Passage> = self.passed.iter().map(|p| p.passage.clone()).collect();
        for (passed, belief) in self.passed.drain(..).zip(smooth(&passages)?) {
            for step in passed.steps {
                if let Some(step) = self.steps.get_mut(step) {
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
