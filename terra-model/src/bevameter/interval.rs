//! How sure fitted parameters are: from how tests differ, or from the correlation of residuals within them.

use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::curve::Prepared;
use super::fit::{Form, Solution, different, from, solve};
use super::report::Interval;

/// Share of the points that count: (1 - ρ)/(1 + ρ), ρ the lag-1 correlation of the residuals within the tests.
pub(super) fn effective_share(tests: &[Prepared], residual: &DVector<f64>) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    let mut at = 0;
    for t in tests {
        let own = residual.rows(at, t.points.len());
        at += t.points.len();
        for pair in own.as_slice().windows(2) {
            if let &[a, b] = pair {
                product += a * b;
            }
        }
        square += own.norm_squared();
    }
    let rho = (product / square.max(1e-300)).clamp(0.0, 0.999);
    (1.0 - rho) / (1.0 + rho)
}

fn quantile(dof: f64) -> f64 {
    StudentsT::new(0.0, 1.0, dof.max(1.0)).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

/// Half width of the 95 % interval in q.
pub(super) fn half_widths<F: Form>(
    form: &F,
    tests: &[Prepared],
    found: &Solution,
) -> (Interval, Vec<f64>) {
    let n = form.free().len();
    if let Some(halves) = jackknife(form, tests, found) {
        return (Interval::BetweenTests, halves);
    }
    let points = found.residual.len() as f64;
    let effective = points * effective_share(tests, &found.residual);
    let dof = effective - n as f64;
    if dof < 1.0 {
        // What is left over is one misfit of the law, and says nothing of chance.
        return (Interval::NotKnown, vec![f64::NAN; n]);
    }
    let variance = found.residual.norm_squared() / points;
    let normal = found.jacobian.transpose() * &found.jacobian;
    let covariance = normal
        .try_inverse()
        .map(|inverse| inverse * (variance * points / dof));
    let halves = (0..n)
        .map(|k| {
            covariance
                .as_ref()
                .map_or(f64::INFINITY, |c| quantile(dof) * c[(k, k)].max(0.0).sqrt())
        })
        .collect();
    (Interval::WithinTests, halves)
}

/// Half widths from fits that leave one test out; none where that leaves too few.
fn jackknife<F: Form>(form: &F, tests: &[Prepared], found: &Solution) -> Option<Vec<f64>> {
    let count = tests.len();
    if count < 2 {
        return None;
    }
    let mut left: Vec<Vec<f64>> = vec![];
    for out in 0..count {
        let rest: Vec<Prepared> = tests
            .iter()
            .enumerate()
            .filter(|(k, _)| *k != out)
            .map(|(_, t)| t.clone())
            .collect();
        if different(&rest) < form.givens() {
            return None;
        }
        let fit = from(form, &rest, &found.p).or_else(|| solve(form, &rest))?;
        left.push(
            fit.p
                .iter()
                .zip(&found.p)
                .zip(form.free().iter().zip(&found.scale))
                .map(|((p, whole), (free, scale))| free.steps(*whole, *p, *scale))
                .collect(),
        );
    }
    let g = count as f64;
    let halves = (0..form.free().len()).map(|k| {
        let values = || left.iter().filter_map(|l| l.get(k));
        let mean = values().sum::<f64>() / g;
        let variance = values().map(|v| (v - mean).powi(2)).sum::<f64>() * (g - 1.0) / g;
        quantile(g - 1.0) * variance.sqrt()
    });
    Some(halves.collect())
}
