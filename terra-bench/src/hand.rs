//! A yardstick: the step of a multiple model of one wheel, written by hand for that job and no other.
//!
//! Drawbar pull and torque of N hypotheses by four nodes each, whose weights all hypotheses share; the quadratic form of a
//! shared S; log-weight, exponential, evidence and largest log-weight in one pass; where it is asked for, the weighted mean of
//! eight parameters. Nothing is checked, S and load never change, and no alarm is fed: what an estimator costs beyond this is
//! what its generality costs.
//!
//! # Equation
//! log2 w <- log2 w + b - |e|², e = L⁻¹ (F - y) sqrt(log2(e)/2), S = L Lᵀ, b what the winner fell at the sample before.
//! Powers of two need no product before they are rounded, and what is left of the exponent is exact.

use std::sync::Arc;

use terra_mme::HypothesisSet;
use terra_model::{Contact, ForceLaw, Registry, catalogue};
use wide::bytemuck::cast;
use wide::{f32x4, f32x8, i32x8};

use crate::error::{BenchError, check};

/// Hypotheses of a vector.
const LANES: usize = 8;
/// Nodes of a force along the slip.
const NODES: usize = 10;
/// Nodes of a look-up.
const ALONG: usize = 4;
/// Least and largest slip of the table.
const SLIP: (f64, f64) = (0.1, 0.9);
/// Vectors whose weights are summed in single precision: 4 096 hypotheses.
const CHUNK: usize = 512;
/// Parameters of a mean.
const PARAMETERS: usize = 8;
/// Samples of the log.
const SAMPLES: usize = 64;
/// Variance of the pull, covariance, variance of the torque.
const S: [f64; 3] = [400.0, 48.0, 64.0];
/// Log-weight of the padding: it stays there whatever is added.
const NEVER: f32 = -1e30;

/// Forces of a vector of hypotheses.
type Nodes = [[f32x8; NODES]; 2];

/// Slip, drawbar pull and torque of one sample.
#[derive(Clone, Copy, Debug)]
struct Row {
    slip: f64,
    forces: [f64; 2],
}

/// N hypotheses, and a log that goes round.
#[derive(Clone, Debug)]
pub struct Hand {
    n: usize,
    /// `[vector][output][node]`: one pointer runs through all.
    table: Vec<Nodes>,
    /// By vector.
    parameters: Vec<[f32x8; PARAMETERS]>,
    /// log2 w.
    log_weights: Vec<f32x8>,
    /// Weights of the chunk in hand, for the mean.
    weights: Vec<f32x8>,
    /// L⁻¹ sqrt(log2(e)/2): first diagonal, second, and what the second residual takes of the first once whitened.
    whiten: [f64; 3],
    /// The largest log-weight, not yet taken out of all.
    top: f32,
    /// log2 of what was taken out of every weight.
    base: f64,
    total: f64,
    mean: [f64; PARAMETERS],
    /// The same forces in double precision `[hypothesis][output][node]`, and the parameters: for the check alone.
    exact: Vec<([[f64; NODES]; 2], Vec<f64>)>,
    log: Vec<Row>,
    next: usize,
}

impl Hand {
    /// N copies of a clay, 2 % off, under one wheel on that clay.
    ///
    /// # Errors
    /// [`BenchError::Estimator`], [`BenchError::Model`].
    pub fn new(n: usize) -> Result<Self, BenchError> {
        let law = Arc::new(Registry::builtin().law("wong-reece")?);
        let clay = catalogue::find("lean_clay_22")?.parameters(law.model())?;
        let set =
            HypothesisSet::from_vectors(&law, "clay", [clay.clone()])?.perturbed(n, 0.02, 1)?;
        let at = |slip: f64| Contact::new(slip, 245.0, 0.254, 0.15);
        let vectors = n.div_ceil(LANES);
        let mut table = vec![[[f32x8::ZERO; NODES]; 2]; vectors];
        let mut parameters = vec![[f32x8::ZERO; PARAMETERS]; vectors];
        let mut log_weights = vec![f32x8::splat(NEVER); vectors];
        let mut exact = vec![];
        for (j, h) in set.hypotheses().iter().enumerate() {
            let mut own = [[0.0; NODES]; 2];
            for node in 0..NODES {
                let slip = SLIP.0 + (SLIP.1 - SLIP.0) * node as f64 / (NODES - 1) as f64;
                let f = h.law.forces(&h.parameters, &at(slip))?;
                for (output, force) in [f.drawbar_pull, f.resistive_torque].into_iter().enumerate()
                {
                    own[output][node] = force;
                    table[j / LANES][output][node].as_mut_array()[j % LANES] = force as f32;
                }
            }
            for (to, p) in parameters[j / LANES].iter_mut().zip(&h.parameters) {
                to.as_mut_array()[j % LANES] = *p as f32;
            }
            log_weights[j / LANES].as_mut_array()[j % LANES] = 0.0;
            exact.push((own, h.parameters.clone()));
        }
        let mut log = vec![];
        for k in 0..SAMPLES {
            let slip = 0.8 - 0.6 * k as f64 / SAMPLES as f64;
            let f = law.forces(&clay, &at(slip))?;
            // Errors cancel over the log.
            let off = if k % 2 == 0 { 1.0 } else { -1.0 };
            log.push(Row {
                slip,
                forces: [f.drawbar_pull + off, f.resistive_torque + 0.3 * off],
            });
        }
        let unit = (0.5 * std::f64::consts::LOG2_E).sqrt();
        let [a, b, c] = S;
        let second = (c - b * b / a).sqrt();
        Ok(Hand {
            n,
            table,
            parameters,
            log_weights,
            weights: vec![f32x8::ZERO; CHUNK.min(vectors)],
            whiten: [unit / a.sqrt(), unit / second, -b / (a.sqrt() * second)],
            top: 0.0,
            base: 0.0,
            total: n as f64,
            mean: [0.0; PARAMETERS],
            exact,
            log,
            next: 0,
        })
    }

    /// One sample: weights and evidence.
    pub fn step(&mut self) {
        let row = self.log[self.next % SAMPLES];
        self.next += 1;
        self.take::<false>(row);
    }

    /// The same, and the mean of the parameters.
    pub fn step_with_mean(&mut self) {
        let row = self.log[self.next % SAMPLES];
        self.next += 1;
        self.take::<true>(row);
    }

    /// ln p of all samples so far but for the constant of their densities.
    pub fn log_evidence(&self) -> f64 {
        (self.base + (self.total / self.n as f64).log2()) * std::f64::consts::LN_2
    }

    /// The mean after the last step that was asked for it.
    pub fn mean(&self) -> &[f64; PARAMETERS] {
        &self.mean
    }

    #[inline]
    fn take<const MEAN: bool>(&mut self, row: Row) {
        let (first, weight) = cubic((row.slip - SLIP.0) * ((NODES - 1) as f64 / (SLIP.1 - SLIP.0)));
        let [own_0, own_1, cross] = self.whiten;
        let splat = |x: f64| f32x8::splat(x as f32);
        let look_up = LookUp {
            first,
            pull: weight.map(|w| splat(w * own_0)),
            torque: weight.map(|w| splat(w * own_1)),
            observed: [splat(-own_0 * row.forces[0]), splat(-own_1 * row.forces[1])],
            cross: splat(cross),
            lift: f32x8::splat(-self.top),
        };
        self.base += f64::from(self.top);
        let mut top = f32x8::splat(f32::MIN);
        let (mut total, mut mean) = (0.0, [0.0; PARAMETERS]);
        let (mut table, mut parameters) = (self.table.as_slice(), self.parameters.as_slice());
        let mut log_weights = self.log_weights.as_mut_slice();
        while !log_weights.is_empty() {
            let length = CHUNK.min(log_weights.len());
            let (some, rest) = log_weights.split_at_mut(length);
            let (nodes, others) = table.split_at(length);
            look_up.fall(nodes, some);
            let sum = sum::<MEAN>(some, &mut self.weights, &mut top);
            total += f64::from(sum);
            if MEAN {
                let (own, others) = parameters.split_at(length);
                let sums = means(&self.weights, own).to_array();
                for (mean, sum) in mean.iter_mut().zip(sums) {
                    *mean += f64::from(sum);
                }
                parameters = others;
            }
            (log_weights, table) = (rest, others);
        }
        self.total = total;
        self.top = largest(top);
        if MEAN {
            self.mean = mean.map(|m| m / total);
        }
    }

    /// A new set after the whole log, against a plain loop in double precision over the same look-up: posterior to 1e-4,
    /// evidence, and the mean.
    ///
    /// # Errors
    /// [`BenchError::Wrong`], [`BenchError::Estimator`].
    pub fn check(n: usize) -> Result<(), BenchError> {
        let (mut own, mut with) = (Hand::new(n)?, Hand::new(n)?);
        let mut logs = vec![0.0; n];
        let [a, b, c] = S;
        let determinant = a * c - b * b;
        for row in own.log.clone() {
            own.step();
            with.step_with_mean();
            let (first, weight) =
                cubic((row.slip - SLIP.0) * ((NODES - 1) as f64 / (SLIP.1 - SLIP.0)));
            for (log, (forces, _)) in logs.iter_mut().zip(&own.exact) {
                let mut r = [-row.forces[0], -row.forces[1]];
                for (r, nodes) in r.iter_mut().zip(forces) {
                    *r += (0..ALONG)
                        .map(|k| weight[k] * nodes[first + k])
                        .sum::<f64>();
                }
                let form = c * r[0] * r[0] - 2.0 * b * r[0] * r[1] + a * r[1] * r[1];
                *log -= 0.5 * form / determinant;
            }
        }
        let highest = logs.iter().copied().fold(f64::MIN, f64::max);
        let weights: Vec<f64> = logs.iter().map(|l| (l - highest).exp()).collect();
        let sum: f64 = weights.iter().sum();
        let evidence = highest + (sum / n as f64).ln();
        for (name, found) in [("alone", &own), ("with mean", &with)] {
            for (j, w) in weights.iter().enumerate() {
                let lw = found.log_weights[j / LANES].to_array()[j % LANES];
                let p = f64::from(lw).exp2() / found.total;
                let what = format!("posterior of hypothesis {j} of {n}, by hand {name}");
                check(&what, p, w / sum, 1.0, 1e-4)?;
            }
            let what = format!("evidence of {n}, by hand {name}");
            check(&what, found.log_evidence(), evidence, 1.0, 1e-3)?;
        }
        for (k, mean) in with.mean.iter().enumerate() {
            let of = own
                .exact
                .iter()
                .map(|(_, p)| p.get(k).copied().unwrap_or(0.0));
            let expected = of.zip(&weights).map(|(p, w)| p * w / sum).sum::<f64>();
            let what = format!("mean of parameter {k} of {n}, by hand");
            check(&what, *mean, expected, expected.abs().max(1e-9), 1e-5)?;
        }
        Ok(())
    }
}

/// What all hypotheses share at a sample.
struct LookUp {
    first: usize,
    pull: [f32x8; ALONG],
    torque: [f32x8; ALONG],
    observed: [f32x8; 2],
    cross: f32x8,
    lift: f32x8,
}

impl LookUp {
    /// What is needed here takes all registers, so weights are made of log-weights in a second loop.
    #[inline]
    fn fall(&self, nodes: &[Nodes], log_weights: &mut [f32x8]) {
        let one = |[pull, torque]: &Nodes, log_weight: &mut f32x8| {
            let [mut e, mut d] = self.observed;
            for k in 0..ALONG {
                e = pull[self.first + k].mul_add(self.pull[k], e);
                d = torque[self.first + k].mul_add(self.torque[k], d);
            }
            d = e.mul_add(self.cross, d);
            *log_weight = d.mul_neg_add(d, e.mul_neg_add(e, *log_weight)) + self.lift;
        };
        in_pairs(log_weights, nodes, |lw, nodes| one(nodes, lw));
    }
}

/// Two by two: the loop itself then costs half.
#[inline(always)]
fn in_pairs<A, B>(a: &mut [A], b: &[B], mut each: impl FnMut(&mut A, &B)) {
    let (pairs, last) = a.as_chunks_mut::<2>();
    let (others, last_other) = b.as_chunks::<2>();
    for ([a, c], [b, d]) in pairs.iter_mut().zip(others) {
        each(a, b);
        each(c, d);
    }
    if let ([a], [b]) = (last, last_other) {
        each(a, b);
    }
}

/// Weighted sums of the parameters.
#[inline]
fn means(weights: &[f32x8], parameters: &[[f32x8; PARAMETERS]]) -> f32x8 {
    let mut sums = [f32x8::ZERO; PARAMETERS];
    for (w, p) in weights.iter().zip(parameters) {
        for (sum, p) in sums.iter_mut().zip(p) {
            *sum = p.mul_add(*w, *sum);
        }
    }
    let [a, b, c, d, e, f, g, h] = f32x8::transpose(sums);
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// 2^x to 4e-7 of it, 1e-38 at -126 and below.
///
/// # Equation
/// 2^x = 2^k 2^f, k = round(x), |f| <= 1/2, 2^f by the polynomial of degree 5 that is nowhere off by more than 1.5e-7 of
/// it.
#[inline]
fn power_of_two(x: f32x8) -> f32x8 {
    const SERIES: [f32; 6] = [
        0.001_327_655_4,
        0.009_675_627,
        0.055_507_433,
        0.240_221_28,
        0.693_146_9,
        1.0,
    ];
    let held = x.fast_max(f32x8::splat(-126.0));
    let f = held - held.round_ties_even();
    let [first, rest @ ..] = SERIES;
    let mut series = f32x8::splat(first);
    for c in rest {
        series = series.mul_add(f, f32x8::splat(c));
    }
    let series: i32x8 = cast(series);
    cast(series + (held.fast_round_int() << 23_i32))
}

/// The sum of weights and the largest log-weights, lane by lane; weights are kept for a mean.
#[inline]
fn sum<const MEAN: bool>(log_weights: &[f32x8], weights: &mut [f32x8], top: &mut f32x8) -> f32 {
    let (mut sum, mut highest) = (f32x8::ZERO, *top);
    let mut one = |lw: f32x8| {
        highest = lw.fast_max(highest);
        let w = power_of_two(lw);
        sum += w;
        w
    };
    if MEAN {
        in_pairs(&mut weights[..log_weights.len()], log_weights, |w, lw| {
            *w = one(*lw)
        });
    } else {
        let (pairs, last) = log_weights.as_chunks::<2>();
        for [a, b] in pairs {
            one(*a);
            one(*b);
        }
        for a in last {
            one(*a);
        }
    }
    *top = highest;
    sum.reduce_add()
}

/// The largest of eight.
#[inline]
fn largest(x: f32x8) -> f32 {
    let [a, b]: [f32x4; 2] = cast(x);
    let [a, b, c, d] = a.fast_max(b).to_array();
    let more = |a: f32, b: f32| if a > b { a } else { b };
    more(more(a, b), more(c, d))
}

/// First node and weights of the cubic through four nodes at 0, 1, .. 9.
#[inline]
fn cubic(x: f64) -> (usize, [f64; ALONG]) {
    let first = (x as u32 as usize).saturating_sub(1).min(NODES - ALONG);
    let a = x - first as f64;
    let (b, c, d) = (a - 1.0, a - 2.0, a - 3.0);
    let (ab, cd) = (a * b, c * d);
    let weight = [
        b * cd * (-1.0 / 6.0),
        a * cd * 0.5,
        ab * d * -0.5,
        ab * c * (1.0 / 6.0),
    ];
    (first, weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_yardstick_is_bayes() {
        for n in [1, 21, 1000, 4100] {
            Hand::check(n).unwrap();
        }
    }

    /// A cubic is its own interpolant.
    #[test]
    fn a_cubic_is_reproduced() {
        let f = |x: f64| 1.0 - 2.0 * x + 0.3 * x * x - 0.05 * x.powi(3);
        for x in [0.0, 0.4, 1.0, 2.7, 5.5, 9.0] {
            let (first, weight) = cubic(x);
            let sum: f64 = (0..ALONG).map(|k| weight[k] * f((first + k) as f64)).sum();
            assert!((sum - f(x)).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn powers_agree_with_the_library() {
        let mut worst = 0.0_f64;
        for k in 0..155_000 {
            let x = 29.0 - 1e-3 * k as f32;
            let [p, ..] = power_of_two(f32x8::splat(x)).to_array();
            worst = worst.max((f64::from(p) / f64::from(x).exp2() - 1.0).abs());
        }
        assert!(worst < 4e-7, "{worst:e}");
        assert_eq!(power_of_two(f32x8::ZERO).to_array(), [1.0; LANES]);
    }
}
