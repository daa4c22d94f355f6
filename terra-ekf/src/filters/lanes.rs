//! Groups of at most three states and two channels side by side: one place of a vector a group, so that the same few dozen
//! operations serve as many groups as a vector holds. No heap, no inverse, one discretisation for each distinct step.
//!
//! A step writes beside the belief it starts from and takes its place when it is sound: what fails has changed nothing.

use nalgebra::{DMatrix, DVector};

use super::Model;
use super::group::Group;
use super::lane::{Lane, WIDTH, at, put};
use super::moments::{M, Moments, Motion, N, Pivots, Seen, Sensors, packed, square};
use crate::error::FilterError;
use crate::state_space::{AnyStateSpace, StateSpaceAt};
use crate::structure::Structure;

/// Steps whose discretisation is kept.
const STEPS: usize = 8;

/// One step length.
#[derive(Clone)]
struct Step {
    dt: f64,
    motion: Vec<Motion>,
    /// Whether every a is an upper triangle.
    upper: bool,
}

/// The groups of one vector. Three beliefs take turns: the one that holds, the one before the last update, and the one that
/// is being worked out.
#[derive(Clone, Copy, Default)]
struct Vector {
    sensors: Sensors,
    moments: [Moments; 3],
    /// a P of the last prediction.
    cross: [[Lane; N]; N],
    /// M f(0, u) of the step in hand, where f must be asked.
    drive: [Lane; N],
}

/// Whose turn it is.
#[derive(Clone, Copy)]
struct Turns {
    now: usize,
    before: usize,
    next: usize,
}

/// All groups of a filter.
#[derive(Clone)]
pub(super) struct Lanes {
    vectors: Vec<Vector>,
    turns: Turns,
    /// There has been an update since the last prediction.
    updated: bool,
    steps: Vec<Step>,
    /// Place of each channel in `readings`.
    place: Vec<usize>,
    /// Readings, channel by channel of each vector, NaN where there is none.
    readings: Vec<f64>,
    input_count: usize,
    /// Whether f need not be asked: each group is pushed by one input at most, and in proportion.
    wired: bool,
    /// Which input has which place in `inputs`.
    wires: Vec<(usize, usize)>,
    /// Input of each group, 0 where there is none.
    inputs: Vec<f64>,
    /// The change of basis of the drive: group and state it goes to, state it comes from, coefficient.
    basis: Vec<((usize, usize), usize, f64)>,
    origin: Vec<f64>,
    rate: Vec<f64>,
}

impl Lanes {
    /// The groups side by side; `None` when one is too large, or its channels too many or correlated.
    pub(super) fn of(
        groups: &[Group],
        structure: &Structure,
        offset: &DVector<f64>,
        space: &dyn AnyStateSpace,
    ) -> Result<Option<Self>, FilterError> {
        let fits = |g: &Group| g.states.len() <= N && g.channels.len() <= M && g.independent;
        if !groups.iter().all(fits) {
            return Ok(None);
        }
        let (n, vectors) = (structure.basis.nrows(), groups.len().div_ceil(WIDTH));
        let mut lanes = Lanes {
            vectors: vec![Vector::default(); vectors],
            turns: Turns {
                now: 0,
                before: 1,
                next: 2,
            },
            updated: true,
            steps: Vec::new(),
            place: vec![0; offset.len()],
            readings: vec![f64::NAN; vectors * M * WIDTH],
            input_count: space.dims().input,
            wired: false,
            wires: Vec::new(),
            inputs: vec![0.0; vectors * WIDTH],
            basis: Vec::new(),
            origin: vec![0.0; n],
            rate: vec![0.0; n],
        };
        for (k, g) in groups.iter().enumerate() {
            let (vector, place) = (k / WIDTH, k % WIDTH);
            let sensors = &mut lanes.vectors[vector].sensors;
            for (j, &channel) in g.channels.iter().enumerate() {
                for i in 0..g.states.len() {
                    put(&mut sensors.c[j][i], place, g.c[(j, i)]);
                }
                put(&mut sensors.r[j], place, g.r[(j, j)]);
                put(&mut sensors.offset[j], place, offset[channel]);
                sensors.second |= j > 0;
                lanes.place[channel] = (vector * M + j) * WIDTH + place;
            }
            for (i, &state) in g.states.iter().enumerate() {
                for from in 0..n {
                    let weight = structure.basis[(state, from)];
                    if weight != 0.0 {
                        lanes.basis.push(((k, i), from, weight));
                    }
                }
            }
        }
        lanes.load(groups);
        if space.affine_input() {
            lanes.wire(space, groups.len())?;
        }
        Ok(Some(lanes))
    }

    /// Takes the beliefs of the groups over.
    pub(super) fn load(&mut self, groups: &[Group]) {
        for (k, g) in groups.iter().enumerate() {
            let (vector, place) = (&mut self.vectors[k / WIDTH], k % WIDTH);
            vector.moments[self.turns.now].load(place, &g.now.mean, &g.now.p);
            let (mean, p) = &g.now.predicted;
            vector.moments[self.turns.before].load(place, mean, p);
            square(&mut vector.cross, place, &g.now.cross.transpose());
        }
        self.updated = true;
    }

    /// Gives them back.
    pub(super) fn store(&self, groups: &mut [Group]) {
        for (k, g) in groups.iter_mut().enumerate() {
            let n = g.states.len();
            (g.now.mean, g.now.p) = self.belief(k, n);
            g.now.predicted = self.predicted(k, n);
            g.now.cross = self.cross(k, n);
        }
    }

    /// Mean and covariance of group `k`, of `n` states.
    pub(super) fn belief(&self, k: usize, n: usize) -> (DVector<f64>, DMatrix<f64>) {
        self.moments(k / WIDTH).of(k % WIDTH, n)
    }

    /// The same before the last update.
    pub(super) fn predicted(&self, k: usize, n: usize) -> (DVector<f64>, DMatrix<f64>) {
        let Turns { now, before, .. } = self.turns;
        let then = if self.updated { before } else { now };
        self.vectors[k / WIDTH].moments[then].of(k % WIDTH, n)
    }

    /// Its cross covariance.
    pub(super) fn cross(&self, k: usize, n: usize) -> DMatrix<f64> {
        let cross = &self.vectors[k / WIDTH].cross;
        DMatrix::from_fn(n, n, |i, j| at(&cross[j][i], k % WIDTH))
    }

    /// Moments of the groups of vector `k`.
    pub(super) fn moments(&self, k: usize) -> &Moments {
        &self.vectors[k].moments[self.turns.now]
    }

    /// M f(0, u), in the places of the groups.
    fn ask(&mut self, space: &dyn AnyStateSpace, u: &[f64]) -> Result<(), FilterError> {
        StateSpaceAt::<f64>::rate_at(space, &self.origin, u, &mut self.rate)?;
        for vector in &mut self.vectors {
            vector.drive = [Lane::ZERO; N];
        }
        for &((k, i), from, weight) in &self.basis {
            let lane = &mut self.vectors[k / WIDTH].drive[i];
            let sum = at(lane, k % WIDTH) + weight * self.rate[from];
            put(lane, k % WIDTH, sum);
        }
        Ok(())
    }

    /// M f(0, 0), and M (f(0, u) - f(0, 0)) for a unit of each input, vector by vector.
    fn pushes(&mut self, space: &dyn AnyStateSpace) -> Result<Vec<Vec<[Lane; N]>>, FilterError> {
        let drive =
            |lanes: &Lanes| -> Vec<[Lane; N]> { lanes.vectors.iter().map(|v| v.drive).collect() };
        let mut u = vec![0.0; self.input_count];
        self.ask(space, &u)?;
        let still = drive(self);
        let mut all = vec![still.clone()];
        for input in 0..u.len() {
            u[input] = 1.0;
            self.ask(space, &u)?;
            let mut alone = drive(self);
            for (alone, still) in alone.iter_mut().flatten().zip(still.iter().flatten()) {
                *alone -= *still;
            }
            all.push(alone);
            u[input] = 0.0;
        }
        Ok(all)
    }

    /// Finds out once which input pushes which group.
    fn wire(&mut self, space: &dyn AnyStateSpace, groups: usize) -> Result<(), FilterError> {
        let pushes = self.pushes(space)?;
        for k in 0..groups {
            let acts =
                |push: &&Vec<[Lane; N]>| push[k / WIDTH].iter().any(|x| at(x, k % WIDTH) != 0.0);
            let with_input = pushes.iter().skip(1).enumerate();
            let own: Vec<usize> = with_input
                .filter(|(_, p)| acts(p))
                .map(|(u, _)| u)
                .collect();
            if own.len() > 1 {
                self.wires.clear();
                return Ok(());
            }
            self.wires.extend(own.into_iter().map(|u| (u, k)));
        }
        self.wired = true;
        Ok(())
    }

    /// Place of the step `dt` among those kept.
    #[inline(always)]
    fn known(&self, dt: f64) -> Option<usize> {
        // As in `Steps`: clocks differ by rounding from row to row.
        let same = |s: &Step| (s.dt - dt).abs() <= 1e-9 * s.dt;
        self.steps.iter().position(same)
    }

    /// The same of a step that may not be there yet.
    #[cold]
    fn prepare(
        &mut self,
        space: &dyn AnyStateSpace,
        groups: &mut [Group],
        dt: f64,
    ) -> Result<usize, FilterError> {
        let mut motion = vec![Motion::default(); self.vectors.len()];
        for (k, g) in groups.iter_mut().enumerate() {
            let d = g.steps.get(dt)?;
            let (to, place) = (&mut motion[k / WIDTH], k % WIDTH);
            square(&mut to.a, place, &d.a);
            square(&mut to.gamma, place, &d.gamma);
            packed(&mut to.q, place, &d.q);
        }
        if self.wired {
            let all = self.pushes(space)?;
            for (by, still) in motion.iter_mut().zip(&all[0]) {
                by.still = by.pushed(still);
            }
            for &(input, k) in &self.wires {
                let (by, place) = (&mut motion[k / WIDTH], k % WIDTH);
                let pushed = by.pushed(&all[input + 1][k / WIDTH]);
                for (to, from) in by.gain.iter_mut().zip(&pushed) {
                    put(to, place, at(from, place));
                }
            }
        }
        if self.steps.len() >= STEPS {
            self.steps.remove(0);
        }
        let upper = motion.iter().all(Motion::upper);
        self.steps.push(Step { dt, motion, upper });
        Ok(self.steps.len() - 1)
    }

    /// Moves all groups ahead from `time`; with `SMOOTH` the cross covariance is kept.
    #[inline(always)]
    pub(super) fn predict<const SMOOTH: bool>(
        &mut self,
        model: &Model,
        groups: &mut [Group],
        u: &[f64],
        dt: f64,
        time: f64,
    ) -> Result<(), FilterError> {
        let at = match self.known(dt) {
            Some(at) if u.len() == self.input_count => at,
            _ => {
                model.check_step(u, dt, time)?;
                self.prepare(&*model.space, groups, dt)?
            }
        };
        if self.wired {
            for &(input, to) in &self.wires {
                if let (Some(to), Some(u)) = (self.inputs.get_mut(to), u.get(input)) {
                    *to = *u;
                }
            }
        } else {
            self.ask(&*model.space, u)?;
        }
        let finite = match self.steps.get(at) {
            Some(step) if step.upper => sweep::<SMOOTH, true>(
                &mut self.vectors,
                step,
                self.turns,
                &self.inputs,
                self.wired,
            ),
            Some(step) => sweep::<SMOOTH, false>(
                &mut self.vectors,
                step,
                self.turns,
                &self.inputs,
                self.wired,
            ),
            None => false,
        };
        if !finite {
            // An input that is not finite is the better reason.
            model.check_step(u, dt, time)?;
            return Err(FilterError::NotFinite {
                what: "predicted mean or covariance",
                index: 0,
            });
        }
        let Turns { now, before, next } = self.turns;
        self.turns = Turns {
            now: next,
            before,
            next: now,
        };
        self.updated = false;
        Ok(())
    }

    /// Puts the readings in their places.
    #[inline(always)]
    pub(super) fn read(&mut self, z: &[f64]) {
        for (value, &to) in z.iter().zip(&self.place) {
            if let Some(to) = self.readings.get_mut(to) {
                *to = *value;
            }
        }
    }

    /// Place of each channel among the places of all channels, vector by vector.
    pub(super) fn place(&self) -> &[usize] {
        &self.place
    }

    /// Number of vectors.
    pub(super) fn vectors(&self) -> usize {
        self.vectors.len()
    }

    /// Whether any group of a vector has a second channel.
    #[inline(always)]
    pub(super) fn second(&self, k: usize) -> bool {
        self.vectors[k].sensors.second
    }

    /// What vector `k` sees in the readings put in place.
    #[inline(always)]
    pub(super) fn see(&self, k: usize) -> Seen {
        let rows = self.readings.as_chunks::<WIDTH>().0;
        let lane = |j: usize| {
            rows.get(M * k + j)
                .map_or(Lane::ZERO, |row| Lane::new(*row))
        };
        let vector = &self.vectors[k];
        vector.moments[self.turns.now].see(&vector.sensors, &[lane(0), lane(1)])
    }

    /// What vector `k` learns of it, beside the belief; 0 where that is finite.
    #[inline(always)]
    pub(super) fn learn(&mut self, k: usize, seen: &Seen, pivots: &Pivots) -> Lane {
        let vector = &mut self.vectors[k];
        let (next, astray) = vector.moments[self.turns.now].learn(&vector.sensors, seen, pivots);
        vector.moments[self.turns.next] = next;
        astray
    }

    /// What all vectors learned takes the belief's place.
    #[inline(always)]
    pub(super) fn accept(&mut self) {
        let Turns { now, before, next } = self.turns;
        self.turns = Turns {
            now: next,
            before: now,
            next: before,
        };
        self.updated = true;
    }
}

/// One step of all vectors, beside the belief; `false` where that is not finite.
#[inline(always)]
fn sweep<const SMOOTH: bool, const UPPER: bool>(
    vectors: &mut [Vector],
    step: &Step,
    turns: Turns,
    inputs: &[f64],
    wired: bool,
) -> bool {
    let mut blemish = Lane::ZERO;
    let inputs = inputs.as_chunks::<WIDTH>().0;
    for ((vector, by), u) in vectors.iter_mut().zip(&step.motion).zip(inputs) {
        let push = if wired {
            let (u, [g0, g1, g2], [s0, s1, s2]) = (Lane::new(*u), by.gain, by.still);
            [u.mul_add(g0, s0), u.mul_add(g1, s1), u.mul_add(g2, s2)]
        } else {
            by.pushed(&vector.drive)
        };
        let (next, cross, bad) = vector.moments[turns.now].ahead::<UPPER>(by, &push);
        blemish += bad;
        vector.moments[turns.next] = next;
        if SMOOTH {
            vector.cross = cross;
        }
    }
    blemish.simd_eq(Lane::ZERO).all()
}
