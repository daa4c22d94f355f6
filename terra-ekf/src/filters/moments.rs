//! The arithmetic of as many groups of three states and two channels as one vector holds.
//!
//! # Equation
//! Packed 3 x 3 covariances: P⁻ = a P aᵀ + q; channel after channel s = c P cᵀ + r, k = P cᵀ/s, x ← x + k ν,
//! P ← P - k (P cᵀ)ᵀ.

use nalgebra::{DMatrix, DVector};

use super::lane::{Lane, WIDTH, add_dot, at, dot, put};

/// States of a group.
pub(super) const N: usize = 3;
/// Channels of a group.
pub(super) const M: usize = 2;
/// Rows and columns of the packed upper triangle.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
/// Place of (i, j) in it.
const PLACE: [[usize; N]; N] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
/// Least share of s that an earlier channel may leave of it.
const SINGULAR: f64 = 1e-14;

/// Mean and packed covariance of each group.
#[derive(Clone, Copy, Default)]
pub(super) struct Moments {
    mean: [Lane; N],
    p: [Lane; 6],
}

/// What the channels of each group see.
#[derive(Clone, Copy)]
pub(super) struct Sensors {
    pub(super) c: [[Lane; N]; M],
    pub(super) r: [Lane; M],
    pub(super) offset: [Lane; M],
    /// Whether any group has a second channel.
    pub(super) second: bool,
}

impl Default for Sensors {
    fn default() -> Self {
        Sensors {
            c: Default::default(),
            r: [Lane::ONE; M],
            offset: Default::default(),
            second: false,
        }
    }
}

/// How each group moves over a step, and what of its inputs it gains: of none, and of a unit of its own one.
#[derive(Clone, Copy, Default)]
pub(super) struct Motion {
    pub(super) a: [[Lane; N]; N],
    pub(super) q: [Lane; 6],
    pub(super) gamma: [[Lane; N]; N],
    pub(super) still: [Lane; N],
    pub(super) gain: [Lane; N],
}

/// What the channels say of the belief: innovation, which readings are there (all bits or none), P cᵀ, s = c P cᵀ + r, and
/// the covariance of the two innovations.
#[derive(Clone, Copy, Default)]
pub(super) struct Seen {
    pub(super) nu: [Lane; M],
    pub(super) there: [Lane; M],
    pub(super) s: [Lane; M],
    joint: Lane,
    pc: [[Lane; N]; M],
}

/// How the second channel stands after the first, and 1/s of both (0 where there is no reading).
#[derive(Clone, Copy, Default)]
pub(super) struct Pivots {
    /// Share of the first innovation in the second.
    slope: Lane,
    /// s of the second given the first.
    pub(super) left: Lane,
    pub(super) inverse: [Lane; M],
}

pub(super) fn square(m: &mut [[Lane; N]; N], place: usize, from: &DMatrix<f64>) {
    for (i, row) in m.iter_mut().enumerate().take(from.nrows()) {
        for (j, lane) in row.iter_mut().enumerate().take(from.ncols()) {
            put(lane, place, from[(i, j)]);
        }
    }
}

pub(super) fn packed(m: &mut [Lane; 6], place: usize, from: &DMatrix<f64>) {
    for (lane, &(i, j)) in m.iter_mut().zip(&PAIRS) {
        if j < from.ncols() {
            put(lane, place, from[(i, j)]);
        }
    }
}

impl Motion {
    /// Γ times a drive.
    #[inline(always)]
    pub(super) fn pushed(&self, drive: &[Lane; N]) -> [Lane; N] {
        let [g0, g1, g2] = &self.gamma;
        [dot(g0, drive), dot(g1, drive), dot(g2, drive)]
    }

    /// Whether a is an upper triangle, as of a chain of integrals that is listed from its end.
    pub(super) fn upper(&self) -> bool {
        let [_, a1, a2] = &self.a;
        [a1[0], a2[0], a2[1]].iter().all(|a| *a == Lane::ZERO)
    }
}

impl Moments {
    pub(super) fn load(&mut self, place: usize, mean: &DVector<f64>, p: &DMatrix<f64>) {
        for (lane, x) in self.mean.iter_mut().zip(mean.iter()) {
            put(lane, place, *x);
        }
        packed(&mut self.p, place, p);
    }

    /// Mean and covariance of one group of `n` states.
    pub(super) fn of(&self, place: usize, n: usize) -> (DVector<f64>, DMatrix<f64>) {
        (
            DVector::from_fn(n, |i, _| at(&self.mean[i], place)),
            DMatrix::from_fn(n, n, |i, j| at(&self.p[PLACE[i][j]], place)),
        )
    }

    /// All numbers, row by row.
    pub(super) fn rows(&self) -> [[f64; WIDTH]; N + 6] {
        let mut rows = [[0.0; WIDTH]; N + 6];
        for (row, lane) in rows.iter_mut().zip(self.mean.iter().chain(&self.p)) {
            *row = lane.to_array();
        }
        rows
    }

    /// The row of state i's mean.
    pub(super) fn mean_place(i: usize) -> usize {
        i
    }

    /// The row of the covariance of states i and j.
    pub(super) fn covariance_place(i: usize, j: usize) -> usize {
        N + PLACE[i][j]
    }

    /// 0 where the mean is finite, NaN elsewhere: zero times anything finite is zero.
    #[inline(always)]
    fn astray(&self) -> Lane {
        let ([x0, x1, x2], zero) = (self.mean, Lane::ZERO);
        x0.mul_add(zero, x1.mul_add(zero, x2 * zero))
    }

    /// The same of mean and covariance.
    #[inline(always)]
    fn blemish(&self) -> Lane {
        let ([p0, p1, p2, p3, p4, p5], zero) = (self.p, Lane::ZERO);
        let even = p0.mul_add(zero, p2.mul_add(zero, p4 * zero));
        let odd = p1.mul_add(zero, p3.mul_add(zero, p5.mul_add(zero, self.astray())));
        even + odd
    }

    /// P cᵀ.
    #[inline(always)]
    fn times(&self, c: &[Lane; N]) -> [Lane; N] {
        let [p0, p1, p2, p3, p4, p5] = self.p;
        [
            dot(&[p0, p1, p2], c),
            dot(&[p1, p3, p4], c),
            dot(&[p2, p4, p5], c),
        ]
    }

    /// A step ahead, for an a whose lower triangle is zero where `UPPER` says so; a P; and 0 where all of it is finite.
    #[inline(always)]
    pub(super) fn ahead<const UPPER: bool>(
        &self,
        by: &Motion,
        push: &[Lane; N],
    ) -> (Moments, [[Lane; N]; N], Lane) {
        let ([a0, a1, a2], q, x) = (&by.a, &by.q, &self.mean);
        let [p0, p1, p2, p3, p4, p5] = self.p;
        let (r0, r1, r2) = ([p0, p1, p2], [p1, p3, p4], [p2, p4, p5]);
        let next;
        let cross;
        if UPPER {
            let c0 = [dot(a0, &r0), dot(a0, &r1), dot(a0, &r2)];
            let short = |r: &[Lane; N]| a1[1].mul_add(r[1], a1[2] * r[2]);
            let c1 = [short(&r0), short(&r1), short(&r2)];
            let c2 = [a2[2] * p2, a2[2] * p4, a2[2] * p5];
            next = Moments {
                mean: [
                    add_dot::<0>(a0, x, push[0]),
                    add_dot::<1>(a1, x, push[1]),
                    add_dot::<2>(a2, x, push[2]),
                ],
                p: [
                    add_dot::<0>(a0, &c0, q[0]),
                    add_dot::<0>(a0, &c1, q[1]),
                    add_dot::<0>(a0, &c2, q[2]),
                    add_dot::<1>(a1, &c1, q[3]),
                    add_dot::<1>(a1, &c2, q[4]),
                    add_dot::<2>(a2, &c2, q[5]),
                ],
            };
            cross = [c0, c1, c2];
        } else {
            let (c0, c1, c2) = (self.times(a0), self.times(a1), self.times(a2));
            next = Moments {
                mean: [
                    add_dot::<0>(a0, x, push[0]),
                    add_dot::<0>(a1, x, push[1]),
                    add_dot::<0>(a2, x, push[2]),
                ],
                p: [
                    add_dot::<0>(a0, &c0, q[0]),
                    add_dot::<0>(a0, &c1, q[1]),
                    add_dot::<0>(a0, &c2, q[2]),
                    add_dot::<0>(a1, &c1, q[3]),
                    add_dot::<0>(a1, &c2, q[4]),
                    add_dot::<0>(a2, &c2, q[5]),
                ],
            };
            cross = [c0, c1, c2];
        }
        let blemish = next.blemish();
        (next, cross, blemish)
    }

    #[inline(always)]
    pub(super) fn see(&self, by: &Sensors, readings: &[Lane; M]) -> Seen {
        let mut seen = Seen::default();
        let [c0, c1] = &by.c;
        // What is not a number or infinite is not there.
        let left = readings[0] - by.offset[0];
        seen.there[0] = (left * Lane::ZERO).simd_eq(Lane::ZERO);
        seen.nu[0] = (left - dot(c0, &self.mean)) & seen.there[0];
        seen.pc[0] = self.times(c0);
        seen.s[0] = add_dot::<0>(c0, &seen.pc[0], by.r[0]);
        if by.second {
            let left = readings[1] - by.offset[1];
            seen.there[1] = (left * Lane::ZERO).simd_eq(Lane::ZERO);
            seen.nu[1] = (left - dot(c1, &self.mean)) & seen.there[1];
            seen.pc[1] = self.times(c1);
            seen.s[1] = add_dot::<0>(c1, &seen.pc[1], by.r[1]);
            seen.joint = dot(c0, &seen.pc[1]);
        }
        seen
    }

    /// What follows from what was seen, both channels with the variances that `pivots` were made of; and 0 where it is
    /// finite: where `pivots` are sound, a covariance that is finite stays so.
    #[inline(always)]
    pub(super) fn learn(&self, by: &Sensors, seen: &Seen, pivots: &Pivots) -> (Moments, Lane) {
        let mut next = self.gain(&seen.pc[0], seen.nu[0], pivots.inverse[0]);
        if by.second {
            let rest = pivots.rest(seen);
            next = next.gain(&pivots.own(seen), rest, pivots.inverse[1]);
        }
        let astray = next.astray();
        (next, astray)
    }

    /// x + P c ν/s, P - P c (P c)ᵀ/s.
    #[inline(always)]
    fn gain(&self, pc: &[Lane; N], nu: Lane, inverse: Lane) -> Moments {
        let (&[c0, c1, c2], [x0, x1, x2]) = (pc, self.mean);
        let [p0, p1, p2, p3, p4, p5] = self.p;
        let (k0, k1, k2) = (c0 * inverse, c1 * inverse, c2 * inverse);
        Moments {
            mean: [k0.mul_add(nu, x0), k1.mul_add(nu, x1), k2.mul_add(nu, x2)],
            p: [
                k0.mul_neg_add(c0, p0),
                k0.mul_neg_add(c1, p1),
                k0.mul_neg_add(c2, p2),
                k1.mul_neg_add(c1, p3),
                k1.mul_neg_add(c2, p4),
                k2.mul_neg_add(c2, p5),
            ],
        }
    }
}

impl Seen {
    /// For channels of variance `s`.
    #[inline(always)]
    pub(super) fn pivots(&self, s: &[Lane; M], second: bool) -> Pivots {
        let one = Lane::ONE;
        let mut pivots = Pivots::default();
        pivots.inverse[0] = (one / s[0]) & self.there[0];
        if second {
            pivots.slope = self.joint * pivots.inverse[0];
            pivots.left = self.joint.mul_neg_add(pivots.slope, s[1]);
            pivots.inverse[1] = (one / pivots.left) & self.there[1];
        }
        pivots
    }

    /// All bits where 1/s of every reading that is there can be trusted: s is finite, and not nothing but rounding.
    #[inline(always)]
    pub(super) fn sound(&self, pivots: &Pivots, second: bool) -> Lane {
        let first = pivots.inverse[0].simd_gt(Lane::ZERO) | !self.there[0];
        if !second {
            return first;
        }
        let least = self.s[1] * Lane::splat(SINGULAR);
        let own = pivots.inverse[1].simd_gt(Lane::ZERO) & pivots.left.simd_gt(least);
        first & (own | !self.there[1])
    }
}

impl Pivots {
    /// Innovation of the second channel given the first.
    #[inline(always)]
    pub(super) fn rest(&self, seen: &Seen) -> Lane {
        seen.nu[0].mul_neg_add(self.slope, seen.nu[1])
    }

    /// P cᵀ of the second channel given the first.
    #[inline(always)]
    fn own(&self, seen: &Seen) -> [Lane; N] {
        let ([f0, f1, f2], [s0, s1, s2]) = (seen.pc[0], seen.pc[1]);
        [
            f0.mul_neg_add(self.slope, s0),
            f1.mul_neg_add(self.slope, s1),
            f2.mul_neg_add(self.slope, s2),
        ]
    }
}
