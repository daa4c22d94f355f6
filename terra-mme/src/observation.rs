//! What may be compared with a hypothesis: forces estimated from a log, as a linear map of wheel forces.

use nalgebra::{DMatrix, DVector};
use terra_model::Contact;

use crate::error::EstimatorError;

/// Forces of one instant, with everything their comparison with a terrain model needs.
///
/// A hypothesis predicts `map * [D, T, z of wheel 1; D, T, z of wheel 2; ...]` at the given contacts. One wheel on a rig
/// is `map = I` (or the rows measured); a side of a vehicle is the sum of two pulls and each torque, because the division
/// of a side's force between its wheels is not observable.
#[derive(Clone, Debug)]
pub struct ForceObservation {
    /// t \[s\], or the row's number on a rig without time.
    pub time: f64,
    /// Group of samples that belong together (segment, trial): whitening restarts at each.
    pub group: usize,
    /// Estimated forces y (m): N, N m, m.
    pub forces: DVector<f64>,
    /// A (m x 3w): rows of `forces`, columns drawbar pull, torque, sinkage of each of w wheels.
    pub map: DMatrix<f64>,
    /// Slip, load and geometry of each wheel (w).
    pub contacts: Vec<Contact<f64>>,
    /// Joint covariance ((m + 2w) x (m + 2w)) of `forces`, then slip and load of each wheel.
    pub covariance: DMatrix<f64>,
}

impl ForceObservation {
    /// Forces of one wheel on a rig: the first of drawbar pull, torque, sinkage that are given, A = I on their rows.
    ///
    /// `sd` holds the 1-sigma of each given force in that order, then of slip and of normal load.
    ///
    /// # Errors
    /// [`EstimatorError::Observation`] when no force is given, [`EstimatorError::Size`] when `sd` does not fit.
    pub fn wheel(
        time: f64,
        group: usize,
        forces: [Option<f64>; 3],
        contact: Contact<f64>,
        sd: &[f64],
    ) -> Result<Self, EstimatorError> {
        let rows: Vec<(usize, f64)> = forces
            .iter()
            .enumerate()
            .filter_map(|(k, f)| f.map(|f| (k, f)))
            .collect();
        let m = rows.len();
        if m == 0 {
            return Err(EstimatorError::Observation {
                time,
                reason: "no force is given".to_owned(),
            });
        }
        if sd.len() != m + 2 {
            return Err(EstimatorError::Size {
                what: "standard deviations",
                found: sd.len(),
                expected: m + 2,
            });
        }
        let mut map = DMatrix::zeros(m, 3);
        for (row, (column, _)) in rows.iter().enumerate() {
            map[(row, *column)] = 1.0;
        }
        let observation = ForceObservation {
            time,
            group,
            forces: DVector::from_iterator(m, rows.iter().map(|(_, f)| *f)),
            map,
            contacts: vec![contact],
            covariance: DMatrix::from_diagonal(&DVector::from_iterator(
                m + 2,
                sd.iter().map(|s| s * s),
            )),
        };
        observation.check()?;
        Ok(observation)
    }

    /// The map of a side: the sum of its wheels' drawbar pulls, then each wheel's torque ((1 + w) x 3w).
    pub fn side_map(wheels: usize) -> DMatrix<f64> {
        let mut map = DMatrix::zeros(1 + wheels, 3 * wheels);
        for wheel in 0..wheels {
            map[(0, 3 * wheel)] = 1.0;
            map[(1 + wheel, 3 * wheel + 1)] = 1.0;
        }
        map
    }

    /// Sizes agree and every number is finite.
    ///
    /// # Errors
    /// [`EstimatorError::Size`], [`EstimatorError::Observation`].
    pub fn check(&self) -> Result<(), EstimatorError> {
        let (m, w) = (self.forces.len(), self.contacts.len());
        let sizes = [
            ("rows of the map", self.map.nrows(), m),
            ("columns of the map", self.map.ncols(), 3 * w),
            ("rows of the covariance", self.covariance.nrows(), m + 2 * w),
            (
                "columns of the covariance",
                self.covariance.ncols(),
                m + 2 * w,
            ),
        ];
        for (what, found, expected) in sizes {
            if found != expected {
                return Err(EstimatorError::Size {
                    what,
                    found,
                    expected,
                });
            }
        }
        let fail = |reason: &str| {
            Err(EstimatorError::Observation {
                time: self.time,
                reason: reason.to_owned(),
            })
        };
        if m == 0 || w == 0 {
            return fail("it holds no force or no wheel");
        }
        let mut sums = [0.0; 8];
        for x in [
            self.forces.as_slice(),
            self.map.as_slice(),
            self.covariance.as_slice(),
        ] {
            add_nothing(x, &mut sums);
        }
        for c in &self.contacts {
            add_nothing(&[c.slip, c.normal_load, c.radius, c.width], &mut sums);
        }
        if !self.time.is_finite() || sums.iter().sum::<f64>() != 0.0 {
            return fail("a number in it is not finite");
        }
        let mut diagonal = self.covariance.as_slice().iter().step_by(m + 2 * w + 1);
        if diagonal.any(|v| *v < 0.0) {
            return fail("a variance is negative");
        }
        Ok(())
    }
}

/// Zero times anything finite is zero; times anything else it is not a number. Without branches and eight side by side, as it
/// is asked of every number of every sample.
fn add_nothing(x: &[f64], sums: &mut [f64; 8]) {
    let (whole, rest) = x.as_chunks::<8>();
    for some in whole {
        for (sum, v) in sums.iter_mut().zip(some) {
            *sum += v * 0.0;
        }
    }
    for (sum, v) in sums.iter_mut().zip(rest) {
        *sum += v * 0.0;
    }
}
