//! One test: from rows as logged to points that can be fitted.

use crate::error::ModelError;

/// Points of a test after averaging: enough for five parameters, few enough for a fit in no time.
const BINS: usize = 60;
/// Fewest points of a test.
const FEWEST: usize = 5;

/// One test as logged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Its name.
    pub test: String,
    /// Plate: radius b \[m\]. Shear: normal stress \[Pa\].
    pub given: f64,
    /// Sinkage or shear displacement \[m\], pressure or shear stress \[Pa\], in the order they were logged.
    pub points: Vec<(f64, f64)>,
}

/// A test ready for fitting: loading only, averaged over equal steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// Its name.
    pub test: String,
    /// As in [`Curve`].
    pub given: f64,
    /// Averaged points in rising order, x and stress.
    pub points: Vec<(f64, f64)>,
    /// Rows as logged.
    pub rows: usize,
    /// Rows on the loading branch: each deeper than all before it, with a positive stress.
    pub loading: usize,
    /// Largest stress of the averaged points, and where.
    pub peak: (f64, f64),
    /// Mean stress over the last tenth of the way.
    pub residual: f64,
}

impl Curve {
    /// The loading branch between two values of x, averaged.
    ///
    /// # Errors
    /// [`ModelError::Curve`]: too few points there; a radius, normal stress or point that is none.
    pub fn prepare(&self, from: f64, to: f64) -> Result<Prepared, ModelError> {
        let refused = |what: &'static str, found: f64, expected: &'static str| ModelError::Curve {
            test: self.test.clone(),
            what,
            found,
            expected,
        };
        if !(self.given.is_finite() && self.given > 0.0) {
            return Err(refused(
                "plate radius or normal stress",
                self.given,
                "a finite value above 0",
            ));
        }
        if let Some(bad) = self
            .points
            .iter()
            .find(|p| !(p.0.is_finite() && p.1.is_finite()))
        {
            return Err(refused("a point", bad.0, "finite numbers"));
        }
        let mut deepest = 0.0;
        let mut loading = vec![];
        for &(x, stress) in &self.points {
            if x > deepest && stress > 0.0 && (from..=to).contains(&x) {
                loading.push((x, stress));
            }
            deepest = x.max(deepest);
        }
        let points = averaged(&loading);
        if points.len() < FEWEST {
            return Err(refused(
                "points on the loading branch",
                points.len() as f64,
                "at least 5 at different depths or displacements",
            ));
        }
        let peak =
            points.iter().copied().fold(
                (0.0, f64::NEG_INFINITY),
                |a, b| if b.1 > a.1 { b } else { a },
            );
        let end = points.last().map_or(0.0, |p| p.0);
        let tail: Vec<f64> = points
            .iter()
            .filter(|p| p.0 >= 0.9 * end)
            .map(|p| p.1)
            .collect();
        Ok(Prepared {
            test: self.test.clone(),
            given: self.given,
            rows: self.points.len(),
            loading: loading.len(),
            residual: tail.iter().sum::<f64>() / tail.len().max(1) as f64,
            points,
            peak,
        })
    }
}

impl Prepared {
    /// The first half of the way.
    pub(super) fn first_half(&self) -> Prepared {
        let end = self.points.last().map_or(0.0, |p| p.0);
        Prepared {
            points: self
                .points
                .iter()
                .copied()
                .filter(|p| p.0 <= 0.5 * end)
                .collect(),
            ..self.clone()
        }
    }
}

/// Means over equal steps of x; the rows themselves where there are no more than steps.
fn averaged(rows: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
        return vec![];
    };
    if rows.len() <= BINS {
        return rows.to_vec();
    }
    let step = (last.0 - first.0) / BINS as f64;
    let mut sums = [(0.0, 0.0, 0.0); BINS];
    for (x, stress) in rows {
        let bin = (((x - first.0) / step) as usize).min(BINS - 1);
        if let Some(sum) = sums.get_mut(bin) {
            *sum = (sum.0 + x, sum.1 + stress, sum.2 + 1.0);
        }
    }
    sums.iter()
        .filter(|s| s.2 > 0.0)
        .map(|s| (s.0 / s.2, s.1 / s.2))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unloading, reloading below the deepest point and tension are no loading.
    #[test]
    fn only_the_loading_branch_is_kept() {
        let points = [
            (0.001, 1.0),
            (0.002, 2.0),
            (0.003, -0.5),
            (0.004, 4.0),
            (0.005, 5.0),
            (0.003, 1.0),
            (0.0045, 3.0),
            (0.006, 6.0),
            (0.007, 7.0),
            (0.02, 9.0),
        ];
        let curve = Curve {
            test: "a".to_owned(),
            given: 0.05,
            points: points.to_vec(),
        };
        let p = curve.prepare(0.0, 0.01).unwrap();
        let x: Vec<f64> = p.points.iter().map(|p| p.0).collect();
        assert_eq!(x, [0.001, 0.002, 0.004, 0.005, 0.006, 0.007]);
        assert_eq!((p.rows, p.loading, p.peak), (10, 6, (0.007, 7.0)));
        assert!(curve.prepare(0.004, 0.006).is_err());
    }

    /// The mean over a step of a straight line lies on it.
    #[test]
    fn averaging_keeps_a_line() {
        let rows: Vec<(f64, f64)> = (1..=600)
            .map(|k| (f64::from(k), 3.0 * f64::from(k)))
            .collect();
        let means = averaged(&rows);
        assert_eq!(means.len(), 60);
        assert!(means.iter().all(|(x, y)| (y - 3.0 * x).abs() < 1e-9));
    }
}
