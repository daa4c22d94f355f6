//! A belief too wide for one Gaussian, as a sum of five narrower ones through one step.
//!
//! A vehicle that leaves standstill may slip at anything between nothing and all. On a stiff soil one row of the log decides
//! which, and what it decides is no Gaussian of the state before: one filter then is too sure of its prediction.
//!
//! # Equation
//! N(x; m, P) = ∫ N(z; 0, 1) N(x; m + √(1-s²) z u, P - (1-s²) u uᵀ) dz, u = P g/√(gᵀP g), g the slope of the wheels' slip
//! speed, the integral by the Gauss-Hermite rule of five nodes. Evidence is the sum over parts; after the update they are one
//! Gaussian of the same mean and covariance.
//!
//! # Reference
//! D. L. Alspach, H. W. Sorenson, IEEE Trans. Automatic Control 17(4):439-448, 1972 (Gaussian sums); M. Abramowitz, I. A.
//! Stegun, *Handbook of Mathematical Functions* (1964), table 25.10 (nodes and weights).

use super::matrix::apply;
use super::motion::{MOTION_CHANNELS, MotionSample, Plant};
use super::soil_map::SoilMap;
use super::vehicle_filter::{Estimate, Infeasible, Innovation, STATES, Vector};
use crate::log_prob::log_sum_exp;

/// Nodes and weights for the standard normal distribution.
const RULE: [(f64, f64); 5] = [
    (-2.856_970_013_872_806, 0.011_257_411_327_720_69),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (0.0, 0.533_333_333_333_333_3),
    (1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (2.856_970_013_872_806, 0.011_257_411_327_720_69),
];

/// s: 1-sigma of a part, of the belief's, along u.
const NARROW: f64 = 0.5;

impl Estimate {
    /// Moves the belief to `next`, takes that in, and says how likely it was.
    pub(crate) fn follow(
        &mut self,
        soils: [&SoilMap; 2],
        plant: &Plant,
        last: &MotionSample,
        next: &MotionSample,
    ) -> Result<Innovation, Infeasible> {
        let whole = |mut belief: Estimate| {
            belief.predict(soils, plant, last, next)?;
            let told = belief.update(soils, plant, next, &[true; MOTION_CHANNELS])?;
            Ok((belief, told))
        };
        let one = whole(self.clone());
        let parts = self.bends(plant).then(|| self.parts(plant)).flatten();
        let several = parts.and_then(|parts| {
            let moved = parts.into_iter().filter_map(|(weight, part)| {
                let (part, told) = whole(part).ok()?;
                Some((weight.ln() + told.log_density, part, told))
            });
            merged(moved.collect())
        });
        let (belief, told) = match several {
            None => one?,
            Some((belief, log_density, likeliest)) => {
                // Innovations of a sum are not Gaussian: what is held against χ² is that of one filter.
                let whitened = one.map_or(likeliest.whitened, |(_, told)| told.whitened);
                let told = Innovation {
                    log_density,
                    whitened,
                };
                (belief, told)
            }
        };
        *self = belief;
        Ok(told)
    }

    /// The parts with their weights; none where slip is known.
    fn parts(&self, plant: &Plant) -> Option<[(f64, Estimate); RULE.len()]> {
        let share = 0.25 * plant.vehicle.wheel_radius;
        let g = [-1.0, 0.0, share, share, share, share];
        let pg = apply(&self.p, &g);
        let variance: f64 = g.iter().zip(&pg).map(|(a, b)| a * b).sum();
        if variance.is_nan() || variance <= 0.0 {
            return None;
        }
        let u = pg.map(|v| v / variance.sqrt());
        let spread = 1.0 - NARROW * NARROW;
        Some(RULE.map(|(node, weight)| {
            let mut part = self.clone();
            for i in 0..STATES {
                part.x[i] += spread.sqrt() * node * u[i];
                for j in 0..STATES {
                    part.p[i][j] -= spread * u[i] * u[j];
                }
            }
            (weight, part)
        }))
    }
}

/// One Gaussian in place of weighted ones, ln of the sum of weights, and what the likeliest was told; none of none.
fn merged(parts: Vec<(f64, Estimate, Innovation)>) -> Option<(Estimate, f64, Innovation)> {
    let weights: Vec<f64> = parts.iter().map(|(w, ..)| *w).collect();
    let total = log_sum_exp(&weights);
    if !total.is_finite() {
        return None;
    }
    let shares = weights.iter().map(|w| (w - total).exp());
    let mut out = Estimate {
        x: [0.0; STATES],
        p: [[0.0; STATES]; STATES],
        accel: 0.0,
    };
    for (share, (_, part, _)) in shares.clone().zip(&parts) {
        out.accel += share * part.accel;
        for (x, v) in out.x.iter_mut().zip(&part.x) {
            *x += share * v;
        }
    }
    for (share, (_, part, _)) in shares.zip(&parts) {
        let off: Vector = std::array::from_fn(|i| part.x[i] - out.x[i]);
        for i in 0..STATES {
            for j in 0..STATES {
                out.p[i][j] += share * (part.p[i][j] + off[i] * off[j]);
            }
        }
    }
    let likeliest = parts.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((out, total, likeliest.2))
}

#[cfg(test)]
mod tests {
    use super::super::rates::tests::light;
    use super::*;

    /// The parts together are the belief.
    #[test]
    fn parts_have_mean_and_covariance_of_the_whole() {
        let plant = light();
        let number = |i: usize, j: usize| ((7 * i + 3 * j + 1) as f64 * 0.618_034).fract() - 0.5;
        let whole = Estimate {
            x: std::array::from_fn(|i| number(i, 3)),
            p: std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let dot: f64 = (0..STATES).map(|k| number(i, k) * number(j, k)).sum();
                    dot + f64::from(u8::from(i == j))
                })
            }),
            accel: 0.0,
        };
        let parts = whole.parts(&plant).unwrap();
        let parts = parts.map(|(w, part)| (w.ln(), part, Innovation::default()));
        let (again, total, _) = merged(parts.into()).unwrap();
        assert!(total.abs() < 1e-12, "{total}");
        for i in 0..STATES {
            assert!((again.x[i] - whole.x[i]).abs() < 1e-12);
            for j in 0..STATES {
                assert!((again.p[i][j] - whole.p[i][j]).abs() < 1e-12);
            }
        }
    }
}
