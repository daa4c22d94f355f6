//! Which sensors the robot needs: the published ranks.

use nalgebra::DMatrix;
use terra_ekf::spaces::longitudinal_robot::{T, T_RATE};
use terra_ekf::{AnyStateSpace, Dims, FilterError, Gaussian, StateSpace};
use terra_model::Scalar;

use crate::common::robot;

#[test]
fn ranks_of_the_18_state_robot() {
    let space = robot();
    let without = |lost: usize| (0..7).filter(|&i| i != lost).collect::<Vec<_>>();
    assert_eq!(
        space.observability_rank(&[0, 1, 2, 3, 4, 5, 6]).unwrap(),
        18
    );
    assert_eq!(space.observability_rank(&without(0)).unwrap(), 18, "no a_x");
    assert_eq!(
        space.observability_rank(&without(5)).unwrap(),
        17,
        "no ground speed"
    );
    assert_eq!(
        space.observability_rank(&without(6)).unwrap(),
        15,
        "no yaw rate"
    );
    assert_eq!(
        space.observability_rank(&without(2)).unwrap(),
        15,
        "one wheel speed lost"
    );
}

/// The same robot with a force of its own at every wheel: 22 states.
struct FourForces;

impl StateSpace for FourForces {
    fn name(&self) -> &'static str {
        "four-forces"
    }
    fn summary(&self) -> &'static str {
        "four independent wheel forces"
    }
    fn reference(&self) -> &'static str {
        "none"
    }
    fn dims(&self) -> Dims {
        Dims {
            state: 22,
            input: 4,
            measurement: 7,
        }
    }
    fn state_names(&self) -> &'static [&'static str] {
        &["x"; 22]
    }
    fn input_names(&self) -> &'static [&'static str] {
        &["T"; 4]
    }
    fn measurement_names(&self) -> &'static [&'static str] {
        &["z"; 7]
    }
    fn rate<S: Scalar>(&self, x: &[S], u: &[f64], rate: &mut [S]) -> Result<(), FilterError> {
        let (fl, fr, rl, rr) = (x[14], x[16], x[18], x[20]);
        rate[0] = (fl + fr + rl + rr) / 100.0;
        rate[1] = ((fr + rr - fl - rl) * 0.3 - x[1] * 8.0) / 10.0;
        for q in 0..4 {
            rate[2 + q] = (-x[T[q]] - x[2 + q] * 0.1 + u[q]) / 0.25;
            rate[T[q]] = x[T_RATE[q]];
            rate[T_RATE[q]] = S::zero();
            rate[14 + 2 * q] = x[15 + 2 * q];
            rate[15 + 2 * q] = S::zero();
        }
        Ok(())
    }
    fn measure<S: Scalar>(&self, x: &[S], z: &mut [S]) -> Result<(), FilterError> {
        z[0] = (x[14] + x[16] + x[18] + x[20]) / 100.0;
        z[1..5].copy_from_slice(&x[2..6]);
        z[5] = x[0];
        z[6] = x[1];
        Ok(())
    }
    fn process_noise(&self) -> DMatrix<f64> {
        DMatrix::identity(22, 22)
    }
    fn measurement_noise(&self) -> DMatrix<f64> {
        DMatrix::identity(7, 7)
    }
    fn prior(&self) -> Gaussian {
        Gaussian::independent(&[0.0; 22], &[1.0; 22])
    }
    fn linear(&self) -> bool {
        true
    }
}

#[test]
fn the_division_between_front_and_rear_is_not_observable() {
    let space: &dyn AnyStateSpace = &FourForces;
    assert_eq!(
        space.observability_rank(&[0, 1, 2, 3, 4, 5, 6]).unwrap(),
        18
    );
}
