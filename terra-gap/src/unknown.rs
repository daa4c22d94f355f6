//! "None of the known effects": a smooth discrepancy that no hypothesis has.
//!
//! # Equation
//! y0 ~ N(0, I + J J' + a² Φ Φ'), Φ smooth functions of slip (by motion alone of how sharply the wheels turn) and of load, speed, path
//! and pass, and steps between a rig's conditions, in every channel, whitened; by Woodbury in the few columns of B = \[J, a Φ\]: ln det(I + B'B) and y'y - y'B (I + B'B)^-1 B'y.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};

use crate::dataset::{DataSet, Observation};
use crate::evidence::log_sum_exp;
use crate::fit::Fit;
use crate::noise::{DISCREPANCY_LENGTH, Whitener};

/// Factors, beside slip, along which a discrepancy may vary linearly.
const LINEAR: [&str; 4] = ["load", "speed", "path", "pass"];

/// Along what a discrepancy is smooth: slip, or where that is no input, as in a log without forces, how sharply the wheels turn.
const SMOOTH: [&str; 2] = ["slip", "turning"];

/// Where an observation lies along that, as it was read.
pub(crate) fn along(o: &Observation) -> Option<f64> {
    SMOOTH.iter().find_map(|name| o.factors.get(name).copied())
}

/// Smooth discrepancy features of every channel, in units of its scale, not whitened.
pub(crate) fn features(data: &DataSet) -> DMatrix<f64> {
    let along = |o: &Observation| o.shift.slip.or_else(|| along(o));
    let smooth: Vec<f64> = data.observations.iter().filter_map(along).collect();
    let (low, high) = range(&smooth);
    let centres: Vec<f64> = if high - low < 1e-6 {
        vec![low]
    } else {
        let n = ((high - low) / DISCREPANCY_LENGTH).ceil() as usize + 1;
        (0..=n)
            .map(|i| low + (high - low) * i as f64 / n as f64)
            .collect()
    };
    let factors: Vec<(&str, f64, f64)> = LINEAR
        .iter()
        .filter_map(|&name| {
            let v: Vec<f64> = data
                .observations
                .iter()
                .filter_map(|o| o.factors.get(name).copied())
                .collect();
            let (low, high) = range(&v);
            (high - low > 1e-3 * high.abs().max(low.abs())).then_some((
                name,
                0.5 * (low + high),
                0.5 * (high - low),
            ))
        })
        .collect();
    let conditions: BTreeSet<&str> = data.observations.iter().map(|o| &*o.condition).collect();
    let several = conditions.len() > 1;
    let conditions: Vec<&str> = conditions.into_iter().filter(|_| several).collect();
    let each = centres.len() + factors.len() + conditions.len();
    let places: Vec<(usize, usize)> = data.stacked().collect();
    DMatrix::from_fn(places.len(), each * data.channels.len(), |row, column| {
        let (i, channel) = places[row];
        if column / each != channel {
            return 0.0;
        }
        let observation = &data.observations[i];
        let f = &observation.factors;
        let scale = data.channels[channel].scale;
        let k = column % each;
        match centres.get(k) {
            Some(c) => {
                let d = (along(observation).unwrap_or(*c) - c) / DISCREPANCY_LENGTH;
                // Half the centres overlap any point: sqrt(1/2) keeps the prior variance near scale².
                scale * (-d * d).exp() * std::f64::consts::FRAC_1_SQRT_2
            }
            None => match factors.get(k - centres.len()) {
                Some((name, middle, half)) => {
                    scale * f.get(name).map_or(0.0, |v| (v - middle) / half)
                }
                None => {
                    let one = conditions[k - centres.len() - factors.len()];
                    scale * f64::from(observation.condition == one)
                }
            },
        }
    })
}

fn range(v: &[f64]) -> (f64, f64) {
    v.iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
            (a.min(*x), b.max(*x))
        })
}

/// The smooth discrepancy of a data set under one noise, made once for all fits to it.
pub(crate) struct Discrepancy {
    /// Φ, whitened.
    phi: DMatrix<f64>,
    /// Φ'Φ.
    square: DMatrix<f64>,
}

impl Discrepancy {
    /// Of every channel.
    pub(crate) fn new(data: &DataSet, whitener: &Whitener) -> Self {
        let phi = whitener.apply(&features(data));
        let square = phi.tr_mul(&phi);
        Discrepancy { phi, square }
    }

    /// ln of the evidence gained by giving a fit this discrepancy, amplitudes marginalised with equal weights.
    pub(crate) fn gain(&self, fit: &Fit, amplitudes: &[f64]) -> f64 {
        let y = &fit.residual + &*fit.jacobian * &fit.x;
        let known = fit.jacobian.ncols();
        let columns = Columns::new(&y, &fit.jacobian, self);
        let base = columns.log_density(known, 0.0);
        log_sum_exp(
            amplitudes
                .iter()
                .map(|&a| columns.log_density(known, a) - base),
        ) - (amplitudes.len() as f64).ln()
    }
}

/// What data and the columns B = \[J, Φ\] come to in Woodbury's formula: y'y, B'y, B'B, made once for all amplitudes.
struct Columns {
    squares: f64,
    by: DVector<f64>,
    bb: DMatrix<f64>,
}

impl Columns {
    fn new(y: &DVector<f64>, j: &DMatrix<f64>, smooth: &Discrepancy) -> Self {
        let (known, more) = (j.ncols(), smooth.phi.ncols());
        let mut by = DVector::zeros(known + more);
        by.rows_mut(0, known).copy_from(&j.tr_mul(y));
        by.rows_mut(known, more).copy_from(&smooth.phi.tr_mul(y));
        let mut bb = DMatrix::zeros(known + more, known + more);
        let across = smooth.phi.tr_mul(j);
        bb.view_mut((0, 0), (known, known)).copy_from(&j.tr_mul(j));
        bb.view_mut((known, 0), (more, known)).copy_from(&across);
        let mut above = bb.view_mut((0, known), (known, more));
        above.copy_from(&across.transpose());
        let mut corner = bb.view_mut((known, known), (more, more));
        corner.copy_from(&smooth.square);
        Columns {
            squares: y.norm_squared(),
            by,
            bb,
        }
    }

    /// ln N(y; 0, I + B B') without the constant, the columns after the first `known` times an amplitude.
    fn log_density(&self, known: usize, amplitude: f64) -> f64 {
        let n = if amplitude == 0.0 {
            known
        } else {
            self.by.len()
        };
        let times = |k: usize| if k < known { 1.0 } else { amplitude };
        let h = DMatrix::from_fn(n, n, |r, c| {
            self.bb[(r, c)] * times(r) * times(c) + f64::from(u8::from(r == c))
        });
        let by = DVector::from_fn(n, |r, _| self.by[r] * times(r));
        match h.cholesky() {
            Some(c) => {
                let log_det = 2.0 * c.l_dirty().diagonal().iter().map(|v| v.ln()).sum::<f64>();
                -0.5 * (self.squares - by.dot(&c.solve(&by))) - 0.5 * log_det
            }
            None => f64::NEG_INFINITY,
        }
    }
}

/// How many times the stated variance something unknown may scatter, with equal weights; that a channel does not is as
/// probable as all of them. What a window's averages leave of a right explanation stays below the smallest.
const SCATTER: [f64; 6] = [2.0, 3.0, 5.0, 10.0, 30.0, 100.0];

/// ln of the evidence gained by letting every channel scatter more than its noise says: what no smooth discrepancy follows
/// (jitter, play, stones under a wheel) shows so.
pub(crate) fn scatter_gain(data: &DataSet, fit: &Fit) -> f64 {
    let mut sums = vec![(0.0, 0.0); data.channels.len()];
    for ((_, c), r) in data.stacked().zip(fit.residual.iter()) {
        sums[c].0 += 1.0;
        sums[c].1 += r * r;
    }
    sums.into_iter()
        .map(|(n, chi2): (f64, f64)| {
            let at = |s: f64| -0.5 * n * s.ln() - 0.5 * chi2 * (1.0 / s - 1.0);
            let more = log_sum_exp(SCATTER.map(at)) - (SCATTER.len() as f64).ln();
            log_sum_exp([0.0, more]) - std::f64::consts::LN_2
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the dense formula: ln N(y; 0, I + B B') = -y'S^-1 y/2 - ln det S/2.
    #[test]
    fn woodbury_equals_dense() {
        let b = DMatrix::from_fn(6, 2, |r, c| ((r * 7 + c * 3) as f64).sin());
        let y = DVector::from_fn(6, |r, _| (r as f64).cos());
        let s = &b * b.transpose() + DMatrix::identity(6, 6);
        let c = s.cholesky().unwrap();
        let dense =
            -0.5 * y.dot(&c.solve(&y)) - c.l().diagonal().iter().map(|v| v.ln()).sum::<f64>();
        let of = |b: &DMatrix<f64>, known: usize| {
            let phi = b.columns(known, 2 - known).into_owned();
            let square = phi.tr_mul(&phi);
            let j = b.columns(0, known).into_owned();
            Columns::new(&y, &j, &Discrepancy { phi, square })
        };
        assert!((of(&b, 2).log_density(2, 0.0) - dense).abs() < 1e-12);
        assert!((of(&b, 1).log_density(1, 1.0) - dense).abs() < 1e-12);
        // The second column by its amplitude.
        let mut half = b.clone();
        half.column_mut(1).scale_mut(2.0);
        assert!((of(&half, 1).log_density(1, 0.5) - dense).abs() < 1e-12);
    }

    /// n values of variance v: the best single s is v, its gain n/2 (v - 1 - ln v), less the price of the choice; none for
    /// values that scatter as stated.
    #[test]
    fn scatter_is_paid_for_and_found() {
        let n = 300;
        let data = DataSet {
            channels: vec![crate::dataset::ChannelInfo {
                name: "c".to_owned(),
                unit: "N",
                scale: 1.0,
            }],
            observations: (0..n)
                .map(|index| crate::dataset::Observation {
                    index,
                    group: String::new(),
                    condition: String::new(),
                    place: String::new(),
                    channels: vec![0],
                    values: vec![0.0],
                    raw_sd: vec![],
                    shift: Default::default(),
                    carried: vec![],
                    factors: crate::dataset::Factors::new(),
                })
                .collect(),
            dropped: std::collections::BTreeMap::new(),
            notes: vec![],
            short_scatter: vec![],
            uneven: None,
        };
        let gain = |variance: f64| {
            let fit = Fit::of_residual(DVector::from_element(n, variance.sqrt()));
            scatter_gain(&data, &fit)
        };
        assert!((-0.7..0.0).contains(&gain(1.0)), "{}", gain(1.0));
        let best = 150.0 * (3.0 - 1.0 - 3f64.ln());
        let price = std::f64::consts::LN_2 + (SCATTER.len() as f64).ln();
        assert!(
            (gain(3.0) - (best - price)).abs() < 0.1,
            "{} {best}",
            gain(3.0)
        );
    }
}
