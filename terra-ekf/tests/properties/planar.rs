//! The robot in the plane, and extra states around any state space.

use std::sync::Arc;

use nalgebra::DVector;
use terra_ekf::spaces::augmented::Role;
use terra_ekf::spaces::planar_robot::{F, R, T, V_X, V_Y, W, Y, slip_angles};
use terra_ekf::spaces::{Augmented, Extra, LongitudinalRobot, PlanarRobot, longitudinal_robot};
use terra_ekf::{AnyStateSpace, FilterConfig, FilterError, Gaussian, Measurement};

use crate::common::{Truth, compare, filter, rng, robot};

fn planar() -> Arc<dyn AnyStateSpace> {
    Arc::new(PlanarRobot::light().unwrap())
}

fn all_extras() -> Vec<Extra> {
    vec![
        Extra::pitch(),
        Extra::accel_bias(),
        Extra::torque_scale(),
        Extra::speed_scale(),
    ]
}

/// Exact Jacobians against central differences of f and h at scattered states, for the planar robot and around it.
#[test]
fn jacobians_are_the_derivatives() {
    let around = vec![
        Extra {
            role: Role::Slope(V_X),
            ..Extra::pitch()
        },
        Extra::torque_scale(),
        Extra {
            role: Role::ChannelScale(5),
            ..Extra::speed_scale()
        },
    ];
    let spaces: Vec<Arc<dyn AnyStateSpace>> = vec![
        planar(),
        Arc::new(Augmented::new(planar(), around).unwrap()),
        Arc::new(Augmented::new(robot(), all_extras()).unwrap()),
    ];
    for space in spaces {
        let n = space.dims().state;
        let x: Vec<f64> = (0..n).map(|i| 0.7 * (1.3 * i as f64 + 0.4).sin()).collect();
        let u = vec![20.0; space.dims().input];
        let (_, a) = space.rate_jacobian(&x, &u).unwrap();
        let (_, c) = space.measure_jacobian(&x).unwrap();
        for j in 0..n {
            let h = 1e-5;
            let (mut up, mut down) = (x.clone(), x.clone());
            up[j] += h;
            down[j] -= h;
            let rate = |x: &[f64]| DVector::from_vec(space.rate_value(x, &u).unwrap());
            let see = |x: &[f64]| DVector::from_vec(space.measure_value(x).unwrap());
            let da = (rate(&up) - rate(&down)) / (2.0 * h);
            let dc = (see(&up) - see(&down)) / (2.0 * h);
            // Second-order differences: error of h² and of rounding over h.
            assert!(
                (da - a.column(j)).amax() < 1e-7 * (1.0 + a.column(j).amax()),
                "{j}"
            );
            assert!(
                (dc - c.column(j)).amax() < 1e-7 * (1.0 + c.column(j).amax()),
                "{j}"
            );
        }
    }
}

/// A steady circle, 1 m/s and .5 rad/s to the left without side-slip: the ground pushes m v r = 50 N to the left, no net
/// force ahead; the wheels' resistances balance their torques. Slip angles: atan(x_q r/(v ∓ r t_w/2)).
#[test]
fn a_steady_circle_needs_its_centripetal_force() {
    let space = planar();
    for name in ["ekf", "iekf", "srkf", "ud", "ukf", "ckf"] {
        let mut f = filter(name, &space, FilterConfig::default());
        let mut start = space.prior();
        (start.mean[V_X], start.mean[R]) = (1.0, 0.5);
        for w in W {
            start.mean[w] = 4.0;
        }
        f.restart(start).unwrap();
        for _ in 0..300 {
            f.predict(&[20.4; 4], 0.01).unwrap();
            let z = [0.0, 4.0, 4.0, 4.0, 4.0, 1.0, 0.5, 0.5, 0.0];
            f.update(&Measurement::full(&z)).unwrap();
        }
        let x = &f.belief().mean;
        assert!((x[Y[0]] + x[Y[1]] - 50.0).abs() < 0.1, "{name}");
        assert!((x[F[0]] + x[F[1]]).abs() < 0.1 && x[V_Y].abs() < 1e-3);
        for t in T {
            assert!((x[t] - 20.0).abs() < 0.05, "{name}: {}", x[t]);
        }
        // No yaw acceleration: the couples of the two divisions cancel.
        let moment = 0.3 * (x[F[1]] - x[F[0]]) + 0.3 * (x[Y[0]] - x[Y[1]]);
        assert!(moment.abs() < 0.1, "{name}: {moment}");
        let angles = slip_angles(f.belief(), PlanarRobot::light().unwrap().vehicle()).unwrap();
        for (q, along, speed) in [
            (0, 0.3, 0.85),
            (1, 0.3, 1.15),
            (2, -0.3, 0.85),
            (3, -0.3, 1.15),
        ] {
            let angle = angles[q].unwrap();
            assert!((angle.value - (along * 0.5f64 / speed).atan()).abs() < 2e-3);
            assert!(angle.sd > 0.0 && angle.sd < 0.05);
        }
    }
}

/// A slip angle's sd by hand: straight ahead at 1 m/s, sd of v_y .02 and of r .01: hypot(.02, .3 x .01).
#[test]
fn slip_angles_by_hand() {
    let (mut x, mut sd) = ([0.0; 23], [0.0; 23]);
    (x[V_X], sd[V_Y], sd[R]) = (1.0, 0.02, 0.01);
    let vehicle = *PlanarRobot::light().unwrap().vehicle();
    let a = slip_angles(&Gaussian::independent(&x, &sd), &vehicle).unwrap();
    assert!((a[0].unwrap().sd - 0.02f64.hypot(0.003)).abs() < 1e-12);
    // In reverse a drift to the left is still one to the left; at rest there is no direction.
    (x[V_X], x[V_Y]) = (-1.0, 0.1);
    let a = slip_angles(&Gaussian::independent(&x, &sd), &vehicle).unwrap();
    assert!((a[3].unwrap().value - 0.1f64.atan()).abs() < 1e-12);
    x = [0.0; 23];
    let a = slip_angles(&Gaussian::independent(&x, &sd), &vehicle).unwrap();
    assert!(a.iter().all(Option::is_none));
}

/// Three equations cannot tell four forces apart: rank 21 of 23, moving or not; without yaw rate and sideways speed the
/// robot is lost sideways.
#[test]
fn ranks_of_the_planar_robot() {
    use terra_ekf::spaces::longitudinal_robot::{PriorSpread, ProcessNoise, SensorNoise};
    use terra_ekf::spaces::planar_robot::Division;
    let all: Vec<usize> = (0..9).collect();
    let mut x = vec![0.0; 23];
    (x[V_X], x[R]) = (1.0, 0.3);
    for division in [Division::BySide, Division::ByAxle] {
        let space: Arc<dyn AnyStateSpace> = Arc::new(
            PlanarRobot::new(
                *PlanarRobot::light().unwrap().vehicle(),
                SensorNoise::default(),
                [0.05, 0.02],
                ProcessNoise::default(),
                PriorSpread::default(),
                division,
            )
            .unwrap(),
        );
        assert_eq!(space.observability_rank(&all).unwrap(), 21);
        assert_eq!(
            space.observability_rank_at(&x, &[20.0; 4], &all).unwrap(),
            21
        );
        let blind: Vec<usize> = (0..6).collect();
        assert!(space.observability_rank_at(&x, &[20.0; 4], &blind).unwrap() < 21);
    }
}

/// What the robot's data tell of extra constants. A bias of the accelerometer and a slope show alike on level driving:
/// v' = a_x - bias - g e, so one of the two is seen and not both. A torque's scale hides in the resistance whatever the
/// torque, and a speed's scale, at one moment, in the speed: it takes a drive over several speeds to tell them apart.
#[test]
fn what_the_data_tell_of_extra_states() {
    let all: Vec<usize> = (0..7).collect();
    let mut x = vec![0.0; 18];
    (x[longitudinal_robot::V], x[longitudinal_robot::F[0]]) = (1.0, 30.0);
    let rank = |extras: Vec<Extra>| {
        let mut x = x.clone();
        x.extend(vec![0.0; extras.len()]);
        let space: Arc<dyn AnyStateSpace> = Arc::new(Augmented::new(robot(), extras).unwrap());
        space.observability_rank_at(&x, &[20.0; 4], &all).unwrap()
    };
    assert_eq!(rank(vec![]), 18);
    assert_eq!(rank(vec![Extra::accel_bias()]), 19);
    assert_eq!(rank(vec![Extra::pitch()]), 19);
    assert_eq!(rank(vec![Extra::pitch(), Extra::accel_bias()]), 19);
    assert_eq!(rank(vec![Extra::torque_scale()]), 18);
    assert_eq!(rank(vec![Extra::speed_scale()]), 18);
    assert!(matches!(
        Augmented::new(
            robot(),
            vec![Extra {
                role: Role::ChannelBias(7),
                ..Extra::accel_bias()
            }]
        ),
        Err(FilterError::Size { found: 7, .. })
    ));
}

/// Without extra states the wrapper is the state space itself. With a bias it stays linear, all filters agree, and a bias
/// of .1 m/s² in the data is found within its sd.
#[test]
fn a_bias_is_found() {
    let plain = robot();
    let wrapped: Arc<dyn AnyStateSpace> = Arc::new(Augmented::new(robot(), vec![]).unwrap());
    let run = Truth::new(&plain, 0.01).run(60, &mut rng(60, 0));
    let (mut a, mut b) = (
        filter("kf", &plain, FilterConfig::default()),
        filter("kf", &wrapped, FilterConfig::default()),
    );
    assert!(compare(&mut *a, &mut *b, &run, |_, z| Measurement::full(z)) < 1e-12);

    let space = Augmented::new(robot(), vec![Extra::accel_bias()]).unwrap();
    let at = space.first_extra();
    let space: Arc<dyn AnyStateSpace> = Arc::new(space);
    assert!(space.is_linear() && at == 18);
    let mut run = Truth::new(&plain, 0.01).run(300, &mut rng(61, 0));
    for z in &mut run.z {
        z[0] += 0.1;
    }
    let mut kf = filter("kf", &space, FilterConfig::default());
    let mut ukf = filter("ukf", &space, FilterConfig::default());
    let worst = compare(&mut *kf, &mut *ukf, &run, |_, z| Measurement::full(z));
    assert!(worst < 1e-8, "{worst:e}");
    let (bias, sd) = (kf.belief().mean[at], kf.belief().sd(at).unwrap());
    assert!(sd < 0.05 && (bias - 0.1).abs() < 3.0 * sd, "{bias} ± {sd}");
}

/// A robot at rest on a slope of .1 rad: the slope is in the accelerometer, given that nothing moves.
#[test]
fn a_slope_is_found() {
    let space = Augmented::new(
        Arc::new(LongitudinalRobot::light().unwrap()),
        vec![Extra::pitch()],
    )
    .unwrap();
    let at = space.first_extra();
    let space: Arc<dyn AnyStateSpace> = Arc::new(space);
    assert!(!space.is_linear());
    let mut f = filter("ekf", &space, FilterConfig::default());
    for k in 0..300 {
        if k > 0 {
            f.predict(&[0.0; 4], 0.01).unwrap();
        }
        let z = [9.81 * 0.1f64.sin(), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        f.update(&Measurement::full(&z)).unwrap();
    }
    let (slope, sd) = (f.belief().mean[at], f.belief().sd(at).unwrap());
    // Drawn to its prior of 0 ± .1 by as much as its own precision leaves open: (sd/.1)² of .1.
    assert!(
        (slope - 0.1).abs() < 0.1 * (sd / 0.1).powi(2) + 0.2 * sd,
        "{slope} ± {sd}"
    );
    assert!(sd < 0.01);
}
