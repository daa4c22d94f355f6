//! Filters of a nonlinear state space against what can be worked out by hand.

use std::sync::Arc;

use nalgebra::DMatrix;
use terra_ekf::{
    AnyStateSpace, Dims, FilterConfig, FilterError, Gaussian, Measurement, StateSpace,
};
use terra_model::Scalar;

use crate::common::filter;

/// x' = -x², z = x²: both have closed forms.
struct Square {
    mean: f64,
    sd: f64,
    noise: f64,
}

impl StateSpace for Square {
    fn name(&self) -> &'static str {
        "square"
    }
    fn summary(&self) -> &'static str {
        "a state that is seen and decays through its square"
    }
    fn reference(&self) -> &'static str {
        "none"
    }
    fn dims(&self) -> Dims {
        Dims {
            state: 1,
            input: 0,
            measurement: 1,
        }
    }
    fn state_names(&self) -> &'static [&'static str] {
        &["x"]
    }
    fn input_names(&self) -> &'static [&'static str] {
        &[]
    }
    fn measurement_names(&self) -> &'static [&'static str] {
        &["x squared"]
    }
    fn rate<T: Scalar>(&self, x: &[T], _: &[f64], rate: &mut [T]) -> Result<(), FilterError> {
        rate[0] = -x[0] * x[0];
        Ok(())
    }
    fn measure<T: Scalar>(&self, x: &[T], z: &mut [T]) -> Result<(), FilterError> {
        z[0] = x[0] * x[0];
        Ok(())
    }
    fn process_noise(&self) -> DMatrix<f64> {
        DMatrix::zeros(1, 1)
    }
    fn measurement_noise(&self) -> DMatrix<f64> {
        DMatrix::from_element(1, 1, self.noise * self.noise)
    }
    fn prior(&self) -> Gaussian {
        Gaussian::independent(&[self.mean], &[self.sd])
    }
}

fn square() -> Arc<dyn AnyStateSpace> {
    Arc::new(Square {
        mean: 2.0,
        sd: 0.5,
        noise: 0.1,
    })
}

/// Mean and variance of x² for x ~ N(2, .25): 4.25 and 4 m² P + 2 P² = 4.125. Linearisation says 4 and 4; cubature in one
/// dimension gets the mean and 4; the unscented transform with n + κ = 3 gets both.
#[test]
fn moments_of_a_square() {
    let unscented = terra_ekf::Unscented {
        alpha: 1.0,
        beta: 0.0,
        kappa: 2.0,
    };
    let config = FilterConfig {
        unscented,
        ..FilterConfig::default()
    };
    for (name, mean, variance) in [("ekf", 4.0, 4.0), ("ckf", 4.25, 4.0), ("ukf", 4.25, 4.125)] {
        let mut f = filter(name, &square(), config);
        let i = f.update(&Measurement::full(&[5.0])).unwrap();
        assert!(
            (i.residual.get(0).unwrap() - (5.0 - mean)).abs() < 1e-12,
            "{name}"
        );
        assert!(
            (i.sd.get(0).unwrap().powi(2) - (variance + 0.01)).abs() < 1e-12,
            "{name}"
        );
    }
}

/// The iterated update ends at the mode of the posterior: (x - m)/P = 2 x (z - x²)/R. The plain one does not.
#[test]
fn iterated_update_finds_the_mode() {
    let gradient = |x: f64| (x - 2.0) / 0.25 - 2.0 * x * (7.0 - x * x) / 0.01;
    let end = |name| {
        let mut f = filter(name, &square(), FilterConfig::default());
        f.update(&Measurement::full(&[7.0])).unwrap();
        f.belief().mean[0]
    };
    // Curvature at the mode is about 4 x²/R = 2 800 per unit of x.
    assert!(
        gradient(end("iekf")).abs() < 1e-4,
        "{}",
        gradient(end("iekf"))
    );
    assert!(gradient(end("ekf")).abs() > 10.0);
    let few = FilterConfig {
        max_iterations: 2,
        ..FilterConfig::default()
    };
    let stopped = filter("iekf", &square(), few).update(&Measurement::full(&[7.0]));
    assert!(matches!(
        stopped,
        Err(FilterError::NotConverged { iterations: 2, .. })
    ));
}

/// x(t) = x0/(1 + x0 t), ∂x/∂x0 = 1/(1 + x0 t)²: mean and covariance of the extended filter after 1 s in one call.
#[test]
fn prediction_follows_the_closed_form() {
    for name in ["ekf", "iekf"] {
        let mut f = filter(name, &square(), FilterConfig::default());
        f.predict(&[], 1.0).unwrap();
        let (mean, sd) = (
            f.belief().mean[0] - 2.0 / 3.0,
            f.belief().sd(0).unwrap() - 0.5 / 9.0,
        );
        // Runge-Kutta is exact to (2 h)^4 over the whole step, the Jacobian at the middle of each substep to h².
        assert!(
            mean.abs() < 1e-7 && sd.abs() < 5e-5,
            "{name}: {mean:e} {sd:e}"
        );
        assert!(
            (f.cross_covariance()[(0, 0)] - 0.25 / 9.0).abs() < 5e-5,
            "{name}"
        );
    }
    // Points carry the curvature too: the mean moves by P/2 ∂²x/∂x0² = -P t/(1 + x0 t)³ = -.0093, to second order.
    for name in ["ukf", "ckf"] {
        let mut f = filter(name, &square(), FilterConfig::default());
        f.predict(&[], 1.0).unwrap();
        let moved = f.belief().mean[0] - 2.0 / 3.0;
        assert!((moved + 0.25 / 27.0).abs() < 2e-3, "{name}: {moved}");
    }
}

/// A step that overflows is an error, and the belief stays.
#[test]
fn a_diverging_model_is_an_error() {
    let space: Arc<dyn AnyStateSpace> = Arc::new(Square {
        mean: -2.0,
        sd: 0.5,
        noise: 0.1,
    });
    for name in ["ekf", "iekf", "ukf", "ckf"] {
        let mut f = filter(name, &space, FilterConfig::default());
        let before = f.belief().clone();
        assert!(
            f.predict(&[], 2.0).is_err(),
            "x = 1/(t - .5) has no value after .5 s"
        );
        assert_eq!(f.belief(), &before);
    }
}
