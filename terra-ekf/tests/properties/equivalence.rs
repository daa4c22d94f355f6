//! F1: on a linear time-invariant state space all filters are one filter, and `block` is exact.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_ekf::spaces::longitudinal_robot::{
    LongitudinalRobot, PriorSpread, ProcessNoise, SensorNoise,
};
use terra_ekf::{
    AnyStateSpace, BlockFilter, Blocks, Coupling, Dims, FILTERS, Filter, FilterConfig, FilterError,
    Gaussian, Measurement, Robust, StateSpace, Unscented, UpdateForm,
};
use terra_model::Scalar;

use crate::common::{Truth, compare, filter, input, rng, robot};

fn with_gaps(k: usize, z: &[f64]) -> Measurement {
    let keep = |i: usize| !(k * 7 + i * 3).is_multiple_of(5);
    Measurement::new(
        &z.iter()
            .enumerate()
            .map(|(i, v)| Some(*v).filter(|_| keep(i)))
            .collect::<Vec<_>>(),
    )
}

/// Every filter of the registry, joint and sequential, against the joint Kalman filter, with missing rows.
#[test]
fn f1_all_filters_agree_on_both_state_spaces() {
    for entry in terra_ekf::STATE_SPACES {
        let space = (entry.build)().unwrap();
        if !space.is_linear() {
            continue;
        }
        let run = Truth::new(&space, 0.01).run(120, &mut rng(1, 0));
        for f in FILTERS {
            for form in [UpdateForm::Joseph, UpdateForm::Sequential] {
                let mut oracle = filter("kf", &space, FilterConfig::default());
                let mut other = filter(
                    f.name,
                    &space,
                    FilterConfig {
                        form,
                        ..FilterConfig::default()
                    },
                );
                let worst = compare(&mut *oracle, &mut *other, &run, with_gaps);
                assert!(
                    worst < 1e-9,
                    "{} on {} ({form:?}): {worst:e}",
                    f.name,
                    entry.name
                );
            }
        }
    }
}

/// Small alpha makes the unscented weights huge and of both signs: rounding grows, the answer stays.
#[test]
fn f1_unscented_with_small_alpha_agrees_loosely() {
    let space = robot();
    let run = Truth::new(&space, 0.01).run(50, &mut rng(2, 0));
    let unscented = Unscented {
        alpha: 1e-2,
        beta: 2.0,
        kappa: 0.0,
    };
    let mut oracle = filter("kf", &space, FilterConfig::default());
    let mut other = filter(
        "ukf",
        &space,
        FilterConfig {
            unscented,
            ..FilterConfig::default()
        },
    );
    assert!(compare(&mut *oracle, &mut *other, &run, |_, z| Measurement::full(z)) < 1e-5);
}

/// The weights and resets of the robust update do not depend on the filter either.
#[test]
fn f1_robust_updates_agree_too() {
    let space = robot();
    let mut run = Truth::new(&space, 0.01).run(200, &mut rng(3, 0));
    for k in 60..150 {
        run.z[k][5] += 3.0;
    }
    run.z[20][0] += 40.0;
    let robust = FilterConfig {
        robust: Some(Robust::default()),
        ..FilterConfig::default()
    };
    for f in FILTERS {
        let mut oracle = filter("kf", &space, robust);
        let mut other = filter(f.name, &space, robust);
        let worst = compare(&mut *oracle, &mut *other, &run, |_, z| Measurement::full(z));
        assert!(worst < 1e-8, "{}: {worst:e}", f.name);
        assert_eq!(oracle.resets(), other.resets());
        assert!(
            oracle.resets()[5] >= 1,
            "a speed stuck off by 3 m/s for .9 s must end in a reset"
        );
    }
}

/// The nonlinear path (Runge-Kutta, Jacobian at each substep) on a linear state space that hides that it is linear.
#[test]
fn nonlinear_path_on_a_linear_state_space() {
    struct Hidden(LongitudinalRobot);
    impl StateSpace for Hidden {
        fn name(&self) -> &'static str {
            "hidden"
        }
        fn summary(&self) -> &'static str {
            "a linear state space that does not say so"
        }
        fn reference(&self) -> &'static str {
            "none"
        }
        fn dims(&self) -> Dims {
            StateSpace::dims(&self.0)
        }
        fn state_names(&self) -> &'static [&'static str] {
            StateSpace::state_names(&self.0)
        }
        fn input_names(&self) -> &'static [&'static str] {
            StateSpace::input_names(&self.0)
        }
        fn measurement_names(&self) -> &'static [&'static str] {
            StateSpace::measurement_names(&self.0)
        }
        fn rate<T: Scalar>(&self, x: &[T], u: &[f64], rate: &mut [T]) -> Result<(), FilterError> {
            self.0.rate(x, u, rate)
        }
        fn measure<T: Scalar>(&self, x: &[T], z: &mut [T]) -> Result<(), FilterError> {
            self.0.measure(x, z)
        }
        fn process_noise(&self) -> DMatrix<f64> {
            StateSpace::process_noise(&self.0)
        }
        fn measurement_noise(&self) -> DMatrix<f64> {
            StateSpace::measurement_noise(&self.0)
        }
        fn prior(&self) -> Gaussian {
            StateSpace::prior(&self.0)
        }
    }
    let space = robot();
    let hidden: Arc<dyn AnyStateSpace> = Arc::new(Hidden(LongitudinalRobot::light().unwrap()));
    let run = Truth::new(&space, 0.01).run(60, &mut rng(4, 0));
    for name in ["ekf", "iekf", "ukf", "ckf"] {
        let mut oracle = filter("kf", &space, FilterConfig::default());
        let mut other = filter(name, &hidden, FilterConfig::default());
        let worst = compare(&mut *oracle, &mut *other, &run, |_, z| Measurement::full(z));
        // Runge-Kutta leaves A^5 x h^5/120: for w with torque rates of 2000 N m/s, (b/I)^3 T'/I h^5/120 = 4e-10 rad/s a
        // step, 1.4e-8 of its standard deviation of .03.
        assert!(worst < 5e-8, "{name}: {worst:e}");
    }
    for name in ["kf", "block"] {
        let refused =
            terra_ekf::Registry::builtin().filter(name, hidden.clone(), FilterConfig::default());
        assert!(matches!(refused.err(), Some(FilterError::NotLinear { .. })));
    }
}

/// Six groups of three, equal to the dense Joseph filter to 1e-12 over 400 steps.
#[test]
fn f1_block_equals_dense_joseph() {
    let space = robot();
    let run = Truth::new(&space, 0.01).run(400, &mut rng(5, 0));
    let mut dense = filter("kf", &space, FilterConfig::default());
    let mut block = BlockFilter::new(space.clone(), FilterConfig::default()).unwrap();
    assert_eq!(block.group_count(), 6);
    assert!(block.couplings().is_empty());
    let worst = compare(&mut *dense, &mut block, &run, |_, z| Measurement::full(z));
    assert!(worst <= 1e-12, "{worst:e}");
}

/// Different q_F on the two sides couple sum and difference: five groups, a typed reason, still exact.
#[test]
fn block_joins_what_is_coupled_and_says_why() {
    let vehicle = *LongitudinalRobot::light().unwrap().vehicle();
    let process = ProcessNoise {
        force_walk: [1e4, 2e4],
        ..ProcessNoise::default()
    };
    let space = LongitudinalRobot::new(
        vehicle,
        SensorNoise::default(),
        process,
        PriorSpread::default(),
    )
    .unwrap();
    let space: Arc<dyn AnyStateSpace> = Arc::new(space);
    let run = Truth::new(&space, 0.01).run(100, &mut rng(6, 0));
    let mut dense = filter("kf", &space, FilterConfig::default());
    let mut block = BlockFilter::new(space.clone(), FilterConfig::default()).unwrap();
    assert_eq!(block.group_count(), 5);
    assert!(matches!(block.couplings(), [Coupling::ProcessNoise(..)]));
    assert!(compare(&mut *dense, &mut block, &run, |_, z| Measurement::full(z)) <= 1e-12);

    // A belief that correlates the sides does the same to the state space that had none.
    let space = robot();
    let mut p = space.prior();
    p.covariance[(14, 2)] = 10.0;
    p.covariance[(2, 14)] = 10.0;
    let mut block = BlockFilter::new(space, FilterConfig::default()).unwrap();
    block.restart(p).unwrap();
    assert!(
        block.group_count() < 6
            && block
                .couplings()
                .iter()
                .all(|c| matches!(c, Coupling::Prior(..)))
    );
}

/// A correlated R: sequential updates refuse it, block joins the groups, and treating it as diagonal is wrong.
#[test]
fn f1_correlated_noise_and_sequential_updates() {
    struct Pair {
        rho: f64,
    }
    impl StateSpace for Pair {
        fn name(&self) -> &'static str {
            "pair"
        }
        fn summary(&self) -> &'static str {
            "two walks, two sensors with common noise"
        }
        fn reference(&self) -> &'static str {
            "none"
        }
        fn dims(&self) -> Dims {
            Dims {
                state: 2,
                input: 0,
                measurement: 2,
            }
        }
        fn state_names(&self) -> &'static [&'static str] {
            &["a", "b"]
        }
        fn input_names(&self) -> &'static [&'static str] {
            &[]
        }
        fn measurement_names(&self) -> &'static [&'static str] {
            &["a", "b"]
        }
        fn rate<T: Scalar>(&self, _: &[T], _: &[f64], rate: &mut [T]) -> Result<(), FilterError> {
            rate.fill(T::zero());
            Ok(())
        }
        fn measure<T: Scalar>(&self, x: &[T], z: &mut [T]) -> Result<(), FilterError> {
            z.copy_from_slice(x);
            Ok(())
        }
        fn process_noise(&self) -> DMatrix<f64> {
            DMatrix::identity(2, 2)
        }
        fn measurement_noise(&self) -> DMatrix<f64> {
            DMatrix::from_row_slice(2, 2, &[1.0, self.rho, self.rho, 1.0])
        }
        fn prior(&self) -> Gaussian {
            Gaussian::independent(&[0.0; 2], &[1.0; 2])
        }
        fn linear(&self) -> bool {
            true
        }
        fn blocks(&self) -> Blocks {
            Blocks::Groups {
                basis: DMatrix::identity(2, 2),
                groups: vec![vec![0], vec![1]],
            }
        }
    }
    let space: Arc<dyn AnyStateSpace> = Arc::new(Pair { rho: 0.8 });
    let sequential = FilterConfig {
        form: UpdateForm::Sequential,
        ..FilterConfig::default()
    };
    let refused = terra_ekf::Registry::builtin().filter("kf", space.clone(), sequential);
    assert!(matches!(
        refused.err(),
        Some(FilterError::CorrelatedNoise { .. })
    ));

    let z = Measurement::full(&[1.0, -1.0]);
    let mut dense = filter("kf", &space, FilterConfig::default());
    let mut block = BlockFilter::new(space.clone(), FilterConfig::default()).unwrap();
    assert_eq!(block.couplings(), [Coupling::MeasurementNoise(0, 1)]);
    dense.update(&z).unwrap();
    block.update(&z).unwrap();
    // S = [2 .8; .8 2], gain on the antisymmetric part 1/(1 + 1 - .8) = 1/1.2.
    let by_hand = DVector::from_row_slice(&[1.0 / 1.2, -1.0 / 1.2]);
    assert!((&dense.belief().mean - &by_hand).amax() < 1e-14);
    assert!((&block.belief().mean - &by_hand).amax() < 1e-14);
    // Expected failure: the diagonal of R alone gives 1/2.
    let diagonal: Arc<dyn AnyStateSpace> = Arc::new(Pair { rho: 0.0 });
    let mut naive = filter("kf", &diagonal, sequential);
    naive.update(&z).unwrap();
    assert!((&naive.belief().mean - &by_hand).amax() > 0.3);
}

/// Steps that differ in length and long gaps: the exact discretisation composes, for every filter.
#[test]
fn predictions_compose_over_any_partition_of_time() {
    let space = robot();
    for f in FILTERS {
        let mut one = filter(f.name, &space, FilterConfig::default());
        let mut many = filter(f.name, &space, FilterConfig::default());
        let u = input(&*space, 3);
        one.predict(&u, 0.37).unwrap();
        for dt in [0.01, 0.3, 0.002, 0.058] {
            many.predict(&u, dt).unwrap();
        }
        let worst = crate::common::distance(&*one, &*many);
        assert!(worst < 1e-9, "{}: {worst:e}", f.name);
        for dt in [0.0, -0.01, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                one.predict(&u, dt),
                Err(FilterError::TimeStep { .. })
            ));
        }
        assert!(matches!(
            one.predict(&[1.0], 0.01),
            Err(FilterError::Size { .. })
        ));
        assert!(matches!(
            one.predict(&[f64::NAN; 4], 0.01),
            Err(FilterError::NotFinite { .. })
        ));
    }
}
