//! The ground's roughness: fast force fluctuation that no sensor's noise covers.
//!
//! A wrong model varies slowly with slip and load, so roughness shows in how three successive windows depart from a line. Most of
//! that is noise of the speed, which all wheels' slips share: its covariance tells it from ground that is rough under each wheel.
//! Where the rover file states the roughness, an instant's is stated: how much of it a window's mean keeps is the log's to say,
//! between a ground that fluctuates evenly up to 10 Hz and one that forgets within 50 ms.
//!
//! A push at a rim turns its wheel, and what moves the body is seen inside windows too: neither is rougher than the other allows,
//! so that another fast cause in one of them does not pass for ground.
//!
//! # Equation
//! d_k = r_{k-1} - 2 r_k + r_{k+1}, of covariance V_k = C_{k-1} + 4 C_k + C_{k+1} + 6 Σ_i θ_i B_i, C known, B_i = 1 on the values
//! of one kind: forward acceleration, turning, torques. Two values of the forward acceleration, a window's mean and the slope of its
//! speed, have the same push in common. θ by Fisher's scoring of Σ_k ln N(d_k; 0, V_k), the k weighed by
//! (ν + m)/(ν + d' V^-1 d) against outliers, of which normal ones keep 1 - 2 ν/(ν + m)². A window's variance is θ/.88.
//! Of a wheel's force F: 4 F²/m² on the body, (track F/I)² on its turning, at most (R F)² on a torque.
//!
//! # Reference
//! H. D. Patterson, R. Thompson, Biometrika 58 (1971) 545-554 (components of variance); K. L. Lange et al., J. Am. Stat. Assoc. 84
//! (1989) 881-896 (weights of Student's t).

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use terra_data::Rover;
use terra_model::Vehicle;

use crate::dataset::DataSet;
use crate::noise::NoiseModel;

/// Windows three in a row from which roughness is known.
const ENOUGH: usize = 8;
/// Share of a window's variance that three in a row show: .97 of ground that is even up to 10 Hz, .79 of one that forgets in 50 ms.
const SHOWN: f64 = 0.88;
/// How much more of an instant's variance the second ground leaves in a window's mean than the first.
const LASTING: f64 = 1.6;
/// Correlation of a window's mean acceleration with the slope of its speed under the same push: .91 of a ground that forgets at
/// once (a line's weights on a constant, 1/√1.2), .96 of one that is even up to 10 Hz.
const TOGETHER: f64 = 0.95;
/// Time for which an instant's force stays alike on the first ground \[s\].
const ALIKE: f64 = 0.05;
/// Degrees of freedom of the weights: three windows of which one is far off count no more than twice as much as any.
const TAILS: f64 = 3.0;
/// Steps of the scoring at most.
const STEPS: usize = 8;
/// Change that ends it, in standard deviations of the parts.
const SETTLED: f64 = 0.02;

/// Kinds of channels that one roughness shakes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Forward = 0,
    Turning = 1,
    Torque = 2,
}

impl Kind {
    fn of(channel: &str) -> Self {
        if channel.starts_with("wheel_torque") {
            Kind::Torque
        } else if channel == "yaw_acceleration_rad_s2" {
            Kind::Turning
        } else {
            Kind::Forward
        }
    }

    /// Variance of a channel of the body by that of a wheel's force, window by window.
    fn per_force(self, vehicle: &Vehicle<f64>) -> f64 {
        let arm = match self {
            Kind::Turning => vehicle.track / vehicle.yaw_inertia,
            _ => 2.0 / vehicle.mass,
        };
        arm * arm
    }
}

/// Adds the roughness the rover file states, or else the one the log shows, kind by kind.
pub(crate) fn add(
    noise: &mut NoiseModel,
    data: &mut DataSet,
    rover: &Rover,
    residual: &DVector<f64>,
) {
    data.notes.retain(|n| !n.starts_with("roughness"));
    let Some(vehicle) = rover.nominal_vehicle() else {
        return;
    };
    let kinds: Vec<Kind> = data.channels.iter().map(|c| Kind::of(&c.name)).collect();
    let of_force = rover.noise.get("roughness_N");
    if let Some(uneven) = &data.uneven {
        noise.add_uneven(data, uneven);
    }
    let shown = shown(noise, data, &kinds, residual, of_force.is_some());
    let of_window = (rover.gap.window / ALIKE).max(1.0);
    let stated = |key: &str| rover.noise.get(key).map(|sd| sd * sd / of_window);
    let (force, torque) = (stated("roughness_N"), stated("roughness_N_m"));
    // Of what is stated, the log says how much a window keeps.
    let kept = |stated: f64, kind: Kind| {
        shown.map_or(stated, |v| v[kind as usize].clamp(stated, LASTING * stated))
    };
    let seen = |kind: Kind| shown.map_or(0.0, |v| v[kind as usize]);
    // What moves the body scatters its acceleration inside windows.
    let mut inside = data.short_scatter.iter().flatten();
    let most = inside.next().copied().unwrap_or(f64::INFINITY);
    let of_body = |kind: Kind| {
        let per_force = kind.per_force(&vehicle);
        match (force, kind) {
            (Some(stated), _) => kept(stated * per_force, kind),
            (None, Kind::Forward) => seen(kind).min(most),
            (None, _) => seen(kind),
        }
    };
    let waves = data
        .uneven
        .as_ref()
        .map_or([0.0; 2], |u| [u.forward, u.turning]);
    let (forward, turning) = (
        of_body(Kind::Forward).max(waves[0]),
        of_body(Kind::Turning).max(waves[1]),
    );
    let push = (forward / Kind::Forward.per_force(&vehicle))
        .max(turning / Kind::Turning.per_force(&vehicle));
    let radius = vehicle.wheel_radius;
    let of_a_wheel = match torque {
        Some(stated) => kept(stated, Kind::Torque),
        None => seen(Kind::Torque).min(radius * radius * push),
    };
    for (c, kind) in kinds.iter().enumerate() {
        let (variance, stated) = match kind {
            Kind::Forward => (forward, force),
            Kind::Turning => (turning, force),
            Kind::Torque => (of_a_wheel, torque),
        };
        if variance <= 0.0 {
            continue;
        }
        let channel = &data.channels[c];
        data.notes.push(format!(
            "roughness of {}: {:.3} {} per window, {}",
            channel.name,
            variance.sqrt(),
            channel.unit,
            if stated.is_some() {
                "as stated"
            } else {
                "from the log's short-time scatter"
            }
        ));
        noise.add_channel_variance(data, c, variance);
    }
    noise.stated = force.is_some();
    if noise.stated {
        let all = 0..kinds.len();
        let alike = all.filter(|c| kinds[*c] == Kind::Forward).collect();
        noise.add_together(data, alike, TOGETHER * forward);
    }
}

/// Three windows in a row.
struct Three {
    /// d and the known part of its covariance.
    bend: DVector<f64>,
    known: DMatrix<f64>,
    /// What roughness adds to that.
    shaken: Vec<Shaken>,
}

/// An entry of the covariance that is `size` times the variance of a kind.
struct Shaken {
    row: usize,
    column: usize,
    kind: Kind,
    size: f64,
}

/// 6 B_i of values of these kinds. Only a push that is `stated` is one for both readings of the acceleration: what else the log leaves
/// over may be something of one of them.
fn shaken(kinds: &[Kind], stated: bool) -> Vec<Shaken> {
    let mut out = vec![];
    for (row, kind) in kinds.iter().enumerate() {
        for (column, other) in kinds.iter().enumerate() {
            let together = stated && *kind == Kind::Forward && kind == other;
            let share = match (row == column, together) {
                (true, _) => 1.0,
                (false, true) => TOGETHER,
                (false, false) => continue,
            };
            out.push(Shaken {
                row,
                column,
                kind: *kind,
                size: 6.0 * share,
            });
        }
    }
    out
}

/// Variance of each kind beyond the known noise, by windows three in a row; none where there are too few.
fn shown(
    noise: &NoiseModel,
    data: &DataSet,
    kinds: &[Kind],
    residual: &DVector<f64>,
    stated: bool,
) -> Option<[f64; 3]> {
    let mut first = 0;
    let mut starts = vec![];
    for o in &data.observations {
        starts.push(first);
        first += o.channels.len();
    }
    let threes: Vec<Three> = (1..data.observations.len().saturating_sub(1))
        .filter_map(|k| {
            let at = [k - 1, k, k + 1];
            let [a, b, c] = at.map(|k| &data.observations[k]);
            let in_a_row = a.group == b.group && b.group == c.group;
            if !in_a_row || a.channels != b.channels || b.channels != c.channels {
                return None;
            }
            let [ra, rb, rc] = at.map(|k| residual.rows(starts[k], b.channels.len()));
            let [ca, cb, cc] = at.map(|k| &noise.blocks[k]);
            Some(Three {
                bend: ra - 2.0 * rb + rc,
                known: ca + 4.0 * cb + cc,
                shaken: shaken(
                    &b.channels.iter().map(|&c| kinds[c]).collect::<Vec<_>>(),
                    stated,
                ),
            })
        })
        .collect();
    (threes.len() >= ENOUGH).then(|| scored(&threes).map(|v| v / SHOWN))
}

/// θ by Fisher's scoring from nothing.
fn scored(threes: &[Three]) -> [f64; 3] {
    let mut theta = Vector3::<f64>::zeros();
    for _ in 0..STEPS {
        let (mut score, mut information) = (Vector3::zeros(), Matrix3::zeros());
        for three in threes {
            let m = three.bend.len();
            let mut v = three.known.clone();
            for b in &three.shaken {
                v[(b.row, b.column)] += b.size * theta[b.kind as usize];
            }
            let Some(root) = v.cholesky() else { continue };
            let inverse = root.inverse();
            let pull = &inverse * &three.bend;
            let all = TAILS + m as f64;
            // What weights take from normal numbers, to the second order of their spread.
            let left = 1.0 - 2.0 * TAILS / (all * all);
            let weight = all / (TAILS + three.bend.dot(&pull)) / left;
            for b in &three.shaken {
                let pulled = weight * pull[b.row] * pull[b.column];
                score[b.kind as usize] += b.size * (pulled - inverse[(b.row, b.column)]);
                for other in &three.shaken {
                    let both = inverse[(b.column, other.row)] * inverse[(other.column, b.row)];
                    information[(b.kind as usize, other.kind as usize)] +=
                        b.size * other.size * both;
                }
            }
        }
        // A kind that no channel has keeps its nothing.
        for k in 0..3 {
            if information[(k, k)] <= 0.0 {
                information[(k, k)] = 1.0;
            }
        }
        let Some(step) = information.cholesky().map(|root| root.solve(&score)) else {
            break;
        };
        let next = (theta + step).map(|t| t.max(0.0));
        let sd = information.diagonal().map(|i| (2.0 / i).sqrt());
        let moved = (next - theta).component_div(&sd).amax();
        theta = next;
        if moved < SETTLED {
            break;
        }
    }
    [theta[0], theta[1], theta[2]]
}

#[cfg(test)]
mod tests {
    use chacha20::ChaCha8Rng;
    use chacha20::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Windows of two torques, one acceleration and one turn, whose known noise the torques share to nine tenths of its variance;
    /// the ground adds a fifth of that to each torque by itself, none to the acceleration, four times its noise to the turn. The
    /// parts are found to within a fifth, and to within a half where one window in forty is ten sd off.
    #[test]
    fn components_of_variance_are_found() {
        let kinds = [Kind::Torque, Kind::Torque, Kind::Forward, Kind::Turning];
        let truth = [0.0, 0.02, 0.02];
        let mut known = DMatrix::from_diagonal(&DVector::from_vec(vec![0.1, 0.1, 0.004, 0.005]));
        (known[(0, 1)], known[(1, 0)]) = (0.09, 0.09);
        let mut total = known.clone();
        for (j, kind) in kinds.iter().enumerate() {
            total[(j, j)] += truth[*kind as usize];
        }
        let root = total.cholesky().unwrap().unpack();
        let found = |outlier: f64| {
            let mut rng = ChaCha8Rng::seed_from_u64(7);
            let window = |k: usize| {
                let z = DVector::from_fn(4, |_, _| StandardNormal.sample(&mut rng));
                let sd: f64 = if k % 40 == 7 { outlier } else { 1.0 };
                &root * z * sd
            };
            let windows: Vec<DVector<f64>> = (0..1600).map(window).collect();
            let threes: Vec<Three> = windows
                .windows(3)
                .map(|w| Three {
                    bend: &w[0] - 2.0 * &w[1] + &w[2],
                    known: &known * 6.0,
                    shaken: shaken(&kinds, true),
                })
                .collect();
            scored(&threes)
        };
        for (outlier, within) in [(1.0, 0.2), (10.0, 0.5)] {
            let found = found(outlier);
            assert!(found[0] < 5e-4, "{found:?}");
            for k in [1, 2] {
                assert!((found[k] / truth[k] - 1.0).abs() < within, "{found:?}");
            }
        }
    }

    /// Four torques, a turn, and a window's mean acceleration with the slope of its speed, which the ground shakes both at once: its part
    /// is found to within a tenth, however little the sensors are beside it.
    #[test]
    fn a_push_is_one_for_both_readings_of_the_acceleration() {
        use Kind::{Forward, Torque, Turning};
        let kinds = [Torque, Torque, Torque, Torque, Forward, Forward, Turning];
        let sizes = vec![0.01, 0.01, 0.01, 0.01, 4e-4, 1e-3, 0.01];
        let known = DMatrix::from_diagonal(&DVector::from_vec(sizes));
        let truth = 0.02;
        let mut total = known.clone();
        for b in shaken(&kinds, true).iter().filter(|b| b.kind == Forward) {
            total[(b.row, b.column)] += truth * b.size / 6.0;
        }
        let root = total.cholesky().unwrap().unpack();
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let windows: Vec<DVector<f64>> = (0..1600)
            .map(|_| &root * DVector::from_fn(7, |_, _| StandardNormal.sample(&mut rng)))
            .collect();
        let three = |w: &[DVector<f64>]| Three {
            bend: &w[0] - 2.0 * &w[1] + &w[2],
            known: &known * 6.0,
            shaken: shaken(&kinds, true),
        };
        let found = scored(&windows.windows(3).map(three).collect::<Vec<_>>());
        assert!((found[0] / truth - 1.0).abs() < 0.1, "{found:?}");
    }
}
