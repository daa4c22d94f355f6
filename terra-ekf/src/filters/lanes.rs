//! Up to eight groups of at most three states side by side: one array element a group, so that the same few dozen
//! operations serve all of them at once. No heap, no inverse, one discretisation for each distinct step.
//!
//! # Equation
//! As in [`group`](super::group), written out for packed 3 x 3 covariances: P⁻ = a P aᵀ + q; channel after channel
//! s = c P cᵀ + r, k = P cᵀ/s, x ← x + k ν, P ← P - k (P cᵀ)ᵀ.
//!
//! What is rare (a reset, a dropped reading, an error) is left to the groups.

// One index over all lanes is what the compiler turns into vector operations.
#![allow(clippy::needless_range_loop)]

use nalgebra::{DMatrix, DVector};

use super::group::Group;
use crate::config::FilterConfig;
use crate::error::FilterError;
use crate::measurement::{Innovation, Measurement};
use crate::robust::Watch;
use crate::state_space::{AnyStateSpace, StateSpaceAt};
use crate::structure::Structure;

/// Groups side by side.
const LANES: usize = 8;
/// One number of each group.
type Lane = [f64; LANES];
const ZERO: Lane = [0.0; LANES];
/// States of a group.
const N: usize = 3;
/// Channels of a group.
const M: usize = 2;
/// Rows and columns of the packed upper triangle.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
/// Place of (i, j) in it.
const PLACE: [[usize; N]; N] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
/// No channel in this place.
const NONE: usize = usize::MAX;

/// Mean and packed covariance of every group.
#[derive(Clone)]
pub(super) struct Moments {
    mean: [Lane; N],
    p: [Lane; 6],
}

#[derive(Clone)]
struct Step {
    dt: f64,
    a: [[Lane; N]; N],
    gamma: [[Lane; N]; N],
    q: [Lane; 6],
}

/// All groups of a filter.
#[derive(Clone)]
pub(super) struct Lanes {
    c: [[Lane; N]; M],
    r: [Lane; M],
    offset: [Lane; M],
    channel: [[usize; LANES]; M],
    /// The change of basis of the drive: state and lane it goes to, state it comes from, coefficient.
    basis: Vec<(usize, usize, usize, f64)>,
    steps: Vec<Step>,
    origin: Vec<f64>,
    rate: Vec<f64>,
    pub(super) now: Moments,
    pub(super) predicted: Moments,
    cross: [[Lane; N]; N],
}

fn square(m: &mut [[Lane; N]; N], lane: usize, from: &DMatrix<f64>) {
    for i in 0..from.nrows() {
        for j in 0..from.ncols() {
            m[i][j][lane] = from[(i, j)];
        }
    }
}

fn packed(m: &mut [Lane; 6], lane: usize, from: &DMatrix<f64>) {
    for (k, &(i, j)) in PAIRS.iter().enumerate() {
        if j < from.ncols() {
            m[k][lane] = from[(i, j)];
        }
    }
}

impl Moments {
    fn new() -> Self {
        Moments {
            mean: [ZERO; N],
            p: [ZERO; 6],
        }
    }

    fn load(&mut self, lane: usize, mean: &DVector<f64>, p: &DMatrix<f64>) {
        for i in 0..mean.len() {
            self.mean[i][lane] = mean[i];
        }
        packed(&mut self.p, lane, p);
    }

    /// Mean and covariance of one group of `n` states.
    pub(super) fn of(&self, lane: usize, n: usize) -> (DVector<f64>, DMatrix<f64>) {
        (
            DVector::from_fn(n, |i, _| self.mean[i][lane]),
            DMatrix::from_fn(n, n, |i, j| self.p[PLACE[i][j]][lane]),
        )
    }

    fn finite(&self) -> bool {
        let mut zero = ZERO;
        for row in self.mean.iter().chain(&self.p) {
            for l in 0..LANES {
                // Zero times anything finite is zero; times anything else it is not a number.
                zero[l] += row[l] * 0.0;
            }
        }
        zero.iter().sum::<f64>() == 0.0
    }
}

/// a·b over three lanes.
fn dot(a: &[Lane; N], b: &[Lane; N]) -> Lane {
    let mut out = ZERO;
    for l in 0..LANES {
        out[l] = a[0][l] * b[0][l] + a[1][l] * b[1][l] + a[2][l] * b[2][l];
    }
    out
}

impl Lanes {
    /// The groups side by side; `None` when they are too many or too large, or their channels too many or correlated.
    pub(super) fn of(
        groups: &[Group],
        structure: &Structure,
        offset: &DVector<f64>,
    ) -> Option<Self> {
        let fits = |g: &Group| g.states.len() <= N && g.channels.len() <= M && g.independent;
        if groups.len() > LANES || !groups.iter().all(fits) {
            return None;
        }
        let n = structure.basis.nrows();
        let mut lanes = Lanes {
            c: [[ZERO; N]; M],
            r: [[1.0; LANES]; M],
            offset: [ZERO; M],
            channel: [[NONE; LANES]; M],
            basis: Vec::new(),
            steps: Vec::new(),
            origin: vec![0.0; n],
            rate: vec![0.0; n],
            now: Moments::new(),
            predicted: Moments::new(),
            cross: [[ZERO; N]; N],
        };
        for (lane, g) in groups.iter().enumerate() {
            for (j, &channel) in g.channels.iter().enumerate() {
                for i in 0..g.states.len() {
                    lanes.c[j][i][lane] = g.c[(j, i)];
                }
                lanes.r[j][lane] = g.r[(j, j)];
                lanes.offset[j][lane] = offset[channel];
                lanes.channel[j][lane] = channel;
            }
            for (i, &state) in g.states.iter().enumerate() {
                for from in 0..n {
                    let weight = structure.basis[(state, from)];
                    if weight != 0.0 {
                        lanes.basis.push((i, lane, from, weight));
                    }
                }
            }
        }
        lanes.load(groups);
        Some(lanes)
    }

    /// Takes the beliefs of the groups over.
    pub(super) fn load(&mut self, groups: &[Group]) {
        for (lane, g) in groups.iter().enumerate() {
            self.now.load(lane, &g.now.mean, &g.now.p);
            self.predicted
                .load(lane, &g.now.predicted.0, &g.now.predicted.1);
            square(&mut self.cross, lane, &g.now.cross);
        }
    }

    /// Gives them back.
    pub(super) fn store(&self, groups: &mut [Group]) {
        for (lane, g) in groups.iter_mut().enumerate() {
            let n = g.states.len();
            (g.now.mean, g.now.p) = self.now.of(lane, n);
            g.now.predicted = self.predicted.of(lane, n);
            g.now.cross = self.cross_of(lane, n);
        }
    }

    /// Cross covariance of one group of `n` states.
    pub(super) fn cross_of(&self, lane: usize, n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |i, j| self.cross[i][j][lane])
    }

    fn step(&mut self, groups: &mut [Group], dt: f64) -> Result<usize, FilterError> {
        // As in `Steps`: clocks differ by rounding from row to row.
        let same = |s: &Step| (s.dt - dt).abs() <= 1e-9 * dt;
        if let Some(at) = self.steps.iter().position(same) {
            return Ok(at);
        }
        let mut step = Step {
            dt,
            a: [[ZERO; N]; N],
            gamma: [[ZERO; N]; N],
            q: [ZERO; 6],
        };
        for (lane, g) in groups.iter_mut().enumerate() {
            let d = g.steps.get(dt)?;
            square(&mut step.a, lane, &d.a);
            square(&mut step.gamma, lane, &d.gamma);
            packed(&mut step.q, lane, &d.q);
        }
        if self.steps.len() >= 8 {
            self.steps.remove(0);
        }
        self.steps.push(step);
        Ok(self.steps.len() - 1)
    }

    /// Moves all groups ahead.
    pub(super) fn predict(
        &mut self,
        space: &dyn AnyStateSpace,
        groups: &mut [Group],
        u: &[f64],
        dt: f64,
    ) -> Result<(), FilterError> {
        StateSpaceAt::<f64>::rate_at(space, &self.origin, u, &mut self.rate)?;
        let mut drive = [ZERO; N];
        for &(i, lane, from, weight) in &self.basis {
            drive[i][lane] += weight * self.rate[from];
        }
        let at = self.step(groups, dt)?;
        let step = &self.steps[at];
        let now = &self.now;
        let mut next = Moments::new();
        let mut cross = [[ZERO; N]; N];
        let full: [[&Lane; N]; N] =
            std::array::from_fn(|i| std::array::from_fn(|j| &now.p[PLACE[i][j]]));
        for i in 0..N {
            let (free, pushed) = (dot(&step.a[i], &now.mean), dot(&step.gamma[i], &drive));
            for l in 0..LANES {
                next.mean[i][l] = free[l] + pushed[l];
            }
            for j in 0..N {
                let (p, a) = (&full[i], &step.a[j]);
                for l in 0..LANES {
                    cross[i][j][l] = p[0][l] * a[0][l] + p[1][l] * a[1][l] + p[2][l] * a[2][l];
                }
            }
        }
        for (k, &(i, j)) in PAIRS.iter().enumerate() {
            let a = &step.a[i];
            for l in 0..LANES {
                next.p[k][l] = a[0][l] * cross[0][j][l]
                    + a[1][l] * cross[1][j][l]
                    + a[2][l] * cross[2][j][l]
                    + step.q[k][l];
            }
        }
        if !next.finite() {
            return Err(FilterError::NotFinite {
                what: "predicted mean or covariance",
                index: 0,
            });
        }
        self.predicted.clone_from(&next);
        self.now = next;
        self.cross = cross;
        Ok(())
    }

    /// Takes a sample in. `false`: something rare is up, nothing was changed, and the groups must see to it.
    pub(super) fn update(
        &mut self,
        z: &Measurement,
        config: &FilterConfig,
        watch: &mut Watch,
        innovation: &mut Innovation,
    ) -> bool {
        let now = &self.now;
        let (mut seen, mut nu) = ([ZERO; M], [ZERO; M]);
        let mut pc = [[ZERO; N]; M];
        let mut s = [ZERO; M];
        for j in 0..M {
            let expected = dot(&self.c[j], &now.mean);
            for l in 0..LANES {
                if let Some(value) = z.get(self.channel[j][l]) {
                    seen[j][l] = 1.0;
                    nu[j][l] = value - self.offset[j][l] - expected[l];
                }
            }
            pc[j] = times(&now.p, &self.c[j]);
            s[j] = dot(&self.c[j], &pc[j]);
            for l in 0..LANES {
                s[j][l] += self.r[j][l];
            }
        }
        let joint = dot(&self.c[0], &pc[1]);
        // Whitening with the nominal noise: L of S = [s0 j; j s1].
        let (mut e, mut w, mut pivot) = ([ZERO; M], [ZERO; M], s);
        for l in 0..LANES {
            e[0][l] = nu[0][l] / s[0][l].sqrt();
            e[1][l] = nu[1][l] / s[1][l].sqrt();
            let low = joint[l] / s[0][l].sqrt() * seen[0][l];
            pivot[1][l] = s[1][l] - low * low;
            w[0][l] = e[0][l];
            w[1][l] = (nu[1][l] - low * e[0][l]) / pivot[1][l].sqrt();
        }
        let limit = if config.robust.is_some() {
            config.gate
        } else {
            1e100
        };
        for j in 0..M {
            for l in 0..LANES {
                let usual =
                    pivot[j][l] > 1e-14 * s[j][l] && s[j][l].is_finite() && e[j][l].abs() <= limit;
                let rejected = config.robust.is_some()
                    && seen[j][l] > 0.0
                    && watch.rejects(self.channel[j][l]);
                if rejected || (seen[j][l] > 0.0 && !usual) {
                    return false;
                }
            }
        }

        let mut used = s;
        let ln_two_pi = std::f64::consts::TAU.ln();
        for j in 0..M {
            for l in 0..LANES {
                if seen[j][l] == 0.0 {
                    continue;
                }
                let row = self.channel[j][l];
                let factor = config.robust.map_or(1.0, |robust| {
                    watch.accept(row, e[j][l]);
                    robust.inflation(e[j][l])
                });
                used[j][l] = s[j][l] * factor;
                innovation.residual[row] = Some(nu[j][l]);
                innovation.sd[row] = Some(s[j][l].sqrt());
                innovation.ratio[row] = Some(e[j][l].abs() / config.gate);
                innovation.whitened[row] = Some(w[j][l]);
                innovation.inflation[row] = Some(factor);
                innovation.nis += w[j][l] * w[j][l];
                innovation.dof += 1;
                innovation.log_likelihood -=
                    0.5 * (pivot[j][l].ln() + w[j][l] * w[j][l] + ln_two_pi);
            }
        }

        let mut next = now.clone();
        // First channel of every group, then what is left of the second.
        gain(&mut next, &pc[0], &nu[0], &used[0], &seen[0]);
        let moved: [Lane; N] =
            std::array::from_fn(|i| std::array::from_fn(|l| next.mean[i][l] - now.mean[i][l]));
        let already = dot(&self.c[1], &moved);
        let pc1 = times(&next.p, &self.c[1]);
        let left = dot(&self.c[1], &pc1);
        let (mut rest, mut s1) = (ZERO, ZERO);
        for l in 0..LANES {
            rest[l] = nu[1][l] - already[l];
            // R of the second channel as inflated: used - c P c of the prior.
            s1[l] = left[l] + self.r[1][l] + (used[1][l] - s[1][l]);
        }
        gain(&mut next, &pc1, &rest, &s1, &seen[1]);
        if !next.finite() {
            return false;
        }
        self.predicted.clone_from(&self.now);
        self.now = next;
        true
    }
}

/// P c.
fn times(p: &[Lane; 6], c: &[Lane; N]) -> [Lane; N] {
    let mut out = [ZERO; N];
    for (i, row) in out.iter_mut().enumerate() {
        let (x, y, z) = (&p[PLACE[i][0]], &p[PLACE[i][1]], &p[PLACE[i][2]]);
        for l in 0..LANES {
            row[l] = x[l] * c[0][l] + y[l] * c[1][l] + z[l] * c[2][l];
        }
    }
    out
}

/// x += P c ν/s, P -= P c (P c)ᵀ/s where a channel is seen.
fn gain(m: &mut Moments, pc: &[Lane; N], nu: &Lane, s: &Lane, seen: &Lane) {
    let mut inverse = ZERO;
    for l in 0..LANES {
        inverse[l] = seen[l] / s[l];
    }
    for i in 0..N {
        for l in 0..LANES {
            m.mean[i][l] += pc[i][l] * inverse[l] * nu[l];
        }
    }
    for (k, &(i, j)) in PAIRS.iter().enumerate() {
        for l in 0..LANES {
            m.p[k][l] -= pc[i][l] * inverse[l] * pc[j][l];
        }
    }
}
