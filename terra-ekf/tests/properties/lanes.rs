//! Groups side by side: the same belief as the dense Joseph filter's, whatever the groups look like.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use terra_ekf::spaces::LongitudinalRobot;
use terra_ekf::spaces::longitudinal_robot::{PriorSpread, ProcessNoise, SensorNoise};
use terra_ekf::{
    AnyStateSpace, BlockFilter, Blocks, Dims, Filter, FilterConfig, FilterError, Gaussian,
    LaneFilter, Measurement, StateSpace,
};
use terra_model::Scalar;

use crate::common::{Truth, distance_of, filter, input, rng, robot};

/// Predicts and takes in with both; largest distance of the beliefs, and of NIS and likelihood.
fn compare(
    space: &Arc<dyn AnyStateSpace>,
    dense: &mut dyn Filter,
    samples: &[Measurement],
    dt: impl Fn(usize) -> f64,
) -> (f64, f64) {
    let mut lanes = LaneFilter::new(space.clone()).unwrap();
    let mut belief = lanes.belief();
    let (mut worst, mut worst_score) = (0.0f64, 0.0f64);
    for (k, z) in samples.iter().enumerate() {
        let u = input(&**space, k);
        dense.predict(&u, dt(k)).unwrap();
        lanes.predict(&u, dt(k)).unwrap();
        worst = worst.max(distance_of(dense.belief(), &lanes.belief()));
        let told = dense.update(z).unwrap();
        if k % 2 == 0 {
            let score = lanes.update_scored(z).unwrap();
            assert_eq!(score.dof, told.dof);
            let off = (score.nis - told.nis).abs() / told.nis.max(1.0);
            let likelihood = (score.log_likelihood - told.log_likelihood).abs();
            worst_score = worst_score.max(off.max(likelihood / told.nis.max(1.0)));
        } else {
            lanes.update(z).unwrap();
        }
        lanes.belief_into(&mut belief).unwrap();
        worst = worst.max(distance_of(dense.belief(), &belief));
    }
    (worst, worst_score)
}

fn with_gaps(run: &[Vec<f64>]) -> Vec<Measurement> {
    let keep = |k: usize, i: usize| !(k * 7 + i * 3).is_multiple_of(5) && !k.is_multiple_of(11);
    let row = |(k, z): (usize, &Vec<f64>)| {
        let values = z
            .iter()
            .enumerate()
            .map(|(i, v)| Some(*v).filter(|_| keep(k, i)));
        Measurement::new(&values.collect::<Vec<_>>())
    };
    run.iter().enumerate().map(row).collect()
}

/// The robot over 400 steps: 1e-12. The drawn torques spin its wheels at thousands of rad/s, whose rounding the gain after a
/// gap or a longer step carries into the rates of the torques: 1e-11 there.
#[test]
fn f1_lanes_equal_dense_joseph() {
    let space = robot();
    let run = Truth::new(&space, 0.01).run(400, &mut rng(31, 0));
    let full: Vec<Measurement> = run.z.iter().map(|z| Measurement::full(z)).collect();
    for (name, samples) in [("full", full), ("gaps", with_gaps(&run.z))] {
        for steps in [1, 3, 12] {
            let mut dense = filter("kf", &space, FilterConfig::default());
            let dt = |k: usize| 0.01 + 0.001 * (k % steps) as f64;
            let (worst, score) = compare(&space, &mut *dense, &samples, dt);
            let plain = (name, steps) == ("full", 1);
            let allowed = if plain { 1e-12 } else { 1e-11 };
            assert!(worst <= allowed, "{name}, {steps} step lengths: {worst:e}");
            assert!(score <= 1e-9, "{name}, {steps} step lengths: {score:e}");
        }
    }
}

/// A pitch comes in by its sine, so that f must be asked at every step (one of 20 rad throws the robot about: as above); the
/// rig has groups of one to three states.
#[test]
fn f1_lanes_on_other_state_spaces() {
    let pitched: Arc<dyn AnyStateSpace> =
        Arc::new(LongitudinalRobot::light().unwrap().with_pitch_input());
    let rig: Arc<dyn AnyStateSpace> = Arc::new(terra_ekf::spaces::SingleWheelRig::default());
    assert!(!pitched.affine_input() && rig.affine_input());
    for space in [pitched, rig] {
        let run = Truth::new(&space, 0.01).run(200, &mut rng(32, 0));
        let mut dense = filter("kf", &space, FilterConfig::default());
        let (worst, score) = compare(&space, &mut *dense, &with_gaps(&run.z), |_| 0.01);
        assert!(worst <= 1e-11 && score <= 1e-9, "{worst:e} {score:e}");
    }
}

/// Another start, and one that couples what the prior did not.
#[test]
fn lanes_start_from_any_belief_that_leaves_groups_apart() {
    let space = robot();
    let mut belief = space.prior();
    belief.mean[0] = 1.5;
    belief.covariance[(0, 0)] = 4.0;
    let lanes = LaneFilter::from_belief(space.clone(), belief.clone()).unwrap();
    assert_eq!(lanes.belief(), belief);
    for (i, j) in [(14, 2), (2, 14)] {
        belief.covariance[(i, j)] = 10.0;
    }
    let refused = LaneFilter::from_belief(space, belief).err();
    let Some(FilterError::NoLanes { states, .. }) = refused else {
        panic!("{refused:?}");
    };
    // The sides' difference, a wheel and the sides' sum have become one group.
    assert_eq!(states, 9);
    // Different walks of the two sides couple sum and difference.
    let process = ProcessNoise {
        force_walk: [1e4, 2e4],
        ..ProcessNoise::default()
    };
    let vehicle = *LongitudinalRobot::light().unwrap().vehicle();
    let (sensors, prior) = (SensorNoise::default(), PriorSpread::default());
    let uneven = LongitudinalRobot::new(vehicle, sensors, process, prior).unwrap();
    let refused = LaneFilter::new(Arc::new(uneven)).err();
    assert!(
        matches!(
            refused,
            Some(FilterError::NoLanes {
                states: 6,
                channels: 3,
                ..
            })
        ),
        "{refused:?}"
    );
}

/// What cannot be used is refused by its own error, and the belief stays as it was.
#[test]
fn a_refused_call_leaves_the_belief() {
    let space = robot();
    let mut lanes = LaneFilter::new(space).unwrap();
    lanes.predict(&[20.0; 4], 0.01).unwrap();
    lanes.update(&Measurement::full(&[0.0; 7])).unwrap();
    let before = lanes.belief();
    for dt in [0.0, -0.01, f64::NAN, f64::INFINITY] {
        let refused = lanes.predict(&[0.0; 4], dt);
        assert!(
            matches!(refused, Err(FilterError::TimeStep { .. })),
            "{refused:?}"
        );
    }
    let refused = lanes.predict(&[0.0; 3], 0.01);
    assert!(
        matches!(refused, Err(FilterError::Size { .. })),
        "{refused:?}"
    );
    for bad in [f64::NAN, f64::INFINITY] {
        let refused = lanes.predict(&[0.0, 0.0, bad, 0.0], 0.01);
        let at_input = FilterError::NotFinite {
            what: "input",
            index: 2,
        };
        assert_eq!(refused, Err(at_input));
    }
    let refused = lanes.update(&Measurement::full(&[0.0; 6]));
    assert!(
        matches!(refused, Err(FilterError::Size { .. })),
        "{refused:?}"
    );
    assert_eq!(lanes.belief(), before);
    // Every reading missing: nothing is learned.
    let none = lanes
        .update_scored(&Measurement::full(&[f64::NAN; 7]))
        .unwrap();
    assert_eq!((none.nis, none.dof, none.log_likelihood), (0.0, 0, 0.0));
    assert_eq!(lanes.belief(), before);
}

/// A space of independent groups, in coordinates where pairs of states of different groups are mixed.
#[derive(Clone, Debug)]
struct Drawn {
    groups: Vec<Vec<usize>>,
    basis: DMatrix<f64>,
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    q: DMatrix<f64>,
    r: Vec<f64>,
    prior: Gaussian,
    affine: bool,
}

const NAMES: [&str; 40] = ["x"; 40];

impl StateSpace for Drawn {
    fn name(&self) -> &'static str {
        "drawn"
    }
    fn summary(&self) -> &'static str {
        "independent groups drawn at random"
    }
    fn reference(&self) -> &'static str {
        "none"
    }
    fn dims(&self) -> Dims {
        Dims {
            state: self.a.nrows(),
            input: self.b.ncols(),
            measurement: self.r.len(),
        }
    }
    fn state_names(&self) -> &'static [&'static str] {
        &NAMES[..self.a.nrows()]
    }
    fn input_names(&self) -> &'static [&'static str] {
        &NAMES[..self.b.ncols()]
    }
    fn measurement_names(&self) -> &'static [&'static str] {
        &NAMES[..self.r.len()]
    }
    fn rate<T: Scalar>(&self, x: &[T], u: &[f64], rate: &mut [T]) -> Result<(), FilterError> {
        for (i, r) in rate.iter_mut().enumerate() {
            // Some push even at zero, or bent where the space does not say that inputs are in proportion.
            let push =
                |(j, u): (usize, &f64)| self.b[(i, j)] * if self.affine { *u } else { u.sin() };
            let pushed: f64 = u.iter().enumerate().map(push).sum::<f64>() + 0.1 * i as f64;
            let moved = x.iter().enumerate();
            *r = moved.fold(T::from(pushed), |sum, (j, x)| sum + *x * self.a[(i, j)]);
        }
        Ok(())
    }
    fn measure<T: Scalar>(&self, x: &[T], z: &mut [T]) -> Result<(), FilterError> {
        for (i, z) in z.iter_mut().enumerate() {
            let seen = x.iter().enumerate();
            *z = seen.fold(T::from(0.3), |sum, (j, x)| sum + *x * self.c[(i, j)]);
        }
        Ok(())
    }
    fn process_noise(&self) -> DMatrix<f64> {
        self.q.clone()
    }
    fn measurement_noise(&self) -> DMatrix<f64> {
        DMatrix::from_diagonal(&DVector::from_column_slice(&self.r))
    }
    fn prior(&self) -> Gaussian {
        self.prior.clone()
    }
    fn linear(&self) -> bool {
        true
    }
    fn affine_input(&self) -> bool {
        self.affine
    }
    fn blocks(&self) -> Blocks {
        Blocks::Groups {
            basis: self.basis.clone(),
            groups: self.groups.clone(),
        }
    }
}

/// Groups of one to three states with none to two channels, triangular dynamics or full ones, zero to three inputs on one
/// group or on many.
fn drawn() -> impl Strategy<Value = (Drawn, Vec<Vec<Option<f64>>>)> {
    let group = (1usize..=3, 0usize..=2);
    let sizes = prop::collection::vec(group, 1..=11);
    (sizes, 0usize..=3, any::<[bool; 3]>(), any::<u64>()).prop_map(
        |(sizes, inputs, [triangular, spread, affine], seed)| {
            let mut rng = rng(seed, 0);
            let mut number = move || crate::common::normal(&mut rng, 1)[0];
            let n: usize = sizes.iter().map(|s| s.0).sum();
            let m: usize = sizes.iter().map(|s| s.1).sum();
            let mut a = DMatrix::zeros(n, n);
            let (mut q, mut p) = (a.clone(), a.clone());
            let mut c = DMatrix::zeros(m, n);
            let (mut groups, mut state, mut channel) = (Vec::new(), 0, 0);
            for (size, sees) in &sizes {
                let own: Vec<usize> = (state..state + size).collect();
                let square = |number: &mut dyn FnMut() -> f64| {
                    let root = DMatrix::from_fn(*size, *size, |_, _| number());
                    &root * root.transpose() + DMatrix::identity(*size, *size) * 0.1
                };
                let (noise, start) = (square(&mut number), square(&mut number));
                for (i, &row) in own.iter().enumerate() {
                    for (j, &column) in own.iter().enumerate() {
                        if j >= i || !triangular {
                            a[(row, column)] = number();
                        }
                        (q[(row, column)], p[(row, column)]) = (noise[(i, j)], start[(i, j)]);
                    }
                }
                for k in channel..channel + sees {
                    own.iter().for_each(|&i| c[(k, i)] = number());
                }
                groups.push(own);
                (state, channel) = (state + size, channel + sees);
            }
            let mut b = DMatrix::zeros(n, inputs);
            for j in 0..inputs {
                for (g, own) in groups.iter().enumerate() {
                    if spread || g == j {
                        own.iter().for_each(|&i| b[(i, j)] = number());
                    }
                }
            }
            // Sum and difference of the first states of neighbours, as of the robot's sides.
            let (mut basis, mut back) = (DMatrix::identity(n, n), DMatrix::identity(n, n));
            for pair in groups.chunks_exact(2) {
                let (i, j) = (pair[0][0], pair[1][0]);
                (basis[(i, j)], basis[(j, i)]) = (1.0, -1.0);
                (back[(i, i)], back[(j, j)], back[(i, j)], back[(j, i)]) = (0.5, 0.5, -0.5, 0.5);
            }
            let space = Drawn {
                a: &back * a * &basis,
                b: &back * b,
                c: c * &basis,
                q: &back * q * back.transpose(),
                r: (0..m).map(|_| 0.1 + number().abs()).collect(),
                prior: Gaussian {
                    mean: DVector::from_fn(n, |_, _| number()),
                    covariance: &back * p * back.transpose(),
                },
                groups,
                basis,
                affine,
            };
            let row = |_| {
                (0..m)
                    .map(|_| Some(number()).filter(|x| x.abs() < 1.3))
                    .collect()
            };
            let rows = (0..8).map(row).collect();
            (space, rows)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// F1: lanes, and the filter that keeps accounts on top of them, are the dense Joseph filter.
    #[test]
    fn f1_lanes_equal_dense_joseph_on_any_groups((space, rows) in drawn()) {
        let space: Arc<dyn AnyStateSpace> = Arc::new(space);
        let samples: Vec<Measurement> = rows.iter().map(|z| Measurement::new(z)).collect();
        let dt = |k: usize| 0.05 + 0.03 * (k % 3) as f64;
        let mut dense = filter("kf", &space, FilterConfig::default());
        let (worst, score) = compare(&space, &mut *dense, &samples, dt);
        prop_assert!(worst <= 1e-12, "{worst:e}");
        prop_assert!(score <= 1e-11, "{score:e}");

        let mut dense = filter("kf", &space, FilterConfig::default());
        let mut block = BlockFilter::new(space.clone(), FilterConfig::default()).unwrap();
        for (k, z) in samples.iter().enumerate() {
            let u = input(&*space, k);
            dense.predict(&u, dt(k)).unwrap();
            block.predict(&u, dt(k)).unwrap();
            let (told, of_block) = (dense.update(z).unwrap(), block.update(z).unwrap());
            prop_assert!(distance_of(dense.belief(), block.belief()) <= 1e-12);
            prop_assert!(distance_of(dense.predicted(), block.predicted()) <= 1e-12);
            let cross = (dense.cross_covariance() - block.cross_covariance()).amax();
            prop_assert!(cross <= 1e-12 * dense.cross_covariance().amax().max(1e-3));
            let columns = [
                (&told.residual, &of_block.residual),
                (&told.sd, &of_block.sd),
                (&told.ratio, &of_block.ratio),
                (&told.whitened, &of_block.whitened),
                (&told.inflation, &of_block.inflation),
            ];
            for (dense, block) in columns {
                prop_assert_eq!(dense.len(), block.len());
                for (a, b) in dense.iter().zip(block.iter()) {
                    prop_assert_eq!(a.is_some(), b.is_some());
                    let (a, b) = (a.unwrap_or(0.0), b.unwrap_or(0.0));
                    prop_assert!((a - b).abs() <= 1e-10 * a.abs().max(1.0), "{} {}", a, b);
                }
            }
            prop_assert!((told.log_likelihood - of_block.log_likelihood).abs() <= 1e-9 * told.nis.max(1.0));
        }
    }
}
