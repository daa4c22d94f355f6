//! The examination of a terrain model.

use wide::f64x8;

use super::derivatives::derivatives;
use super::numeric::jump;
use super::sample::{self, contact, contacts};
use super::{Checked, Failures, Record, described};
use crate::contact::Contact;
use crate::effect::Circumstance;
use crate::error::ModelError;
use crate::forces::WheelForces;
use crate::guard::guard;
use crate::lanes::Lanes;
use crate::model::{AnyModel, TerrainModel};
use crate::scalar::Scalar;
use crate::stress::{StressPoint, StressProfile};

/// Examines a model written as a type.
///
/// # Errors
/// [`Failures`] with every promise that is not kept.
pub fn check_model<M: TerrainModel>() -> Result<Checked, Failures> {
    check_model_dyn(&M::default())
}

/// Examines a model known by name. Typical soils are those of the catalogue, where the model has their parameters, else
/// those it names itself, else points of its declared domain.
///
/// # Errors
/// As [`check_model`].
pub fn check_model_dyn(model: &dyn AnyModel) -> Result<Checked, Failures> {
    let mut typical = sample::literature(model);
    if typical.is_empty() {
        typical = model.typical_parameters();
    }
    if typical.is_empty() {
        let usable = |p: &Vec<f64>| forces(model, p, &contact(0.2, 245.25)).is_ok();
        typical = sample::domain(model.params(), 400)
            .into_iter()
            .filter(usable)
            .take(40)
            .collect();
    }
    check_model_with(model, &typical)
}

/// Examines a model around given parameter vectors: what its author holds for typical.
///
/// # Errors
/// As [`check_model`].
pub fn check_model_with(model: &dyn AnyModel, typical: &[Vec<f64>]) -> Result<Checked, Failures> {
    let mut record = Record::new(model.name());
    let texts = [
        ("name", model.name()),
        ("summary", model.summary()),
        ("reference", model.reference()),
    ];
    described(&mut record, texts, model.params());
    let enough = typical
        .iter()
        .filter(|p| forces(model, p, &contact(0.2, 245.25)).is_ok())
        .count()
        >= 3;
    record.expect(enough, "domain", || {
        "fewer than three parameter vectors give forces at slip .2 and 245 N; pass typical ones to check_model_with".into()
    });
    finite_or_typed(&mut record, model, typical);
    let few: Vec<&Vec<f64>> = typical
        .iter()
        .step_by(typical.len().div_ceil(12).max(1))
        .collect();
    derivatives(&mut record, model, &few);
    no_jumps(&mut record, model, &few);
    scaling(&mut record, model, typical);
    balance(&mut record, model, &few);
    bearing_limit(&mut record, model, &few);
    lanes(&mut record, model, typical);
    if model.is_by_slip_and_load() {
        for p in &few {
            by_slip_and_load(&mut record, p, &[], |at| forces(model, p, at));
        }
    }
    record.finish()
}

/// Where nothing but wheel, slip, load and what is beside them is told, pull and torque are the same, and nothing acts sideways.
pub(super) fn by_slip_and_load(
    record: &mut Record,
    p: &[f64],
    beside: &[Circumstance],
    forces: impl Fn(&Contact<f64>) -> Result<WheelForces<f64>, ModelError>,
) {
    for at in contacts() {
        let (Ok(f), Ok(bare)) = (forces(&at), forces(&sample::bare(&at, beside))) else {
            continue;
        };
        let same =
            f.drawbar_pull == bare.drawbar_pull && f.resistive_torque == bare.resistive_torque;
        record.expect(same && f.lateral_force == 0.0, "slip and load", || {
            format!(
                "{f:?}, where nothing else is told {bare:?}, at {}",
                place(p, &at)
            )
        });
    }
}

/// What a solver gets: the guard of every law, then the model.
pub(super) fn forces(
    model: &dyn AnyModel,
    p: &[f64],
    at: &Contact<f64>,
) -> Result<WheelForces<f64>, ModelError> {
    guard(model.name(), model.params(), p, at)?;
    f64::of_model(model).wheel_forces_at(p, at)
}

pub(super) fn place(p: &[f64], at: &Contact<f64>) -> String {
    format!(
        "slip {}, load {} N, parameters {p:?}",
        at.slip, at.normal_load
    )
}

/// Drawbar pull, torque, sinkage and side force.
pub(super) fn four(f: &WheelForces<f64>) -> [f64; 4] {
    [
        f.drawbar_pull,
        f.resistive_torque,
        f.sinkage.unwrap_or(0.0),
        f.lateral_force,
    ]
}

/// What counts as large in each of the four.
pub(super) fn scales(f: &WheelForces<f64>, at: &Contact<f64>) -> [f64; 4] {
    let force = f.drawbar_pull.abs() + f.resistive_torque.abs() / at.radius + f.lateral_force.abs();
    [
        force,
        force * at.radius,
        f.sinkage.unwrap_or(1.0).abs(),
        force,
    ]
}

fn finite_or_typed(record: &mut Record, model: &dyn AnyModel, typical: &[Vec<f64>]) {
    for p in typical.iter().chain(&sample::domain(model.params(), 150)) {
        for at in contacts() {
            match forces(model, p, &at) {
                Ok(f) => {
                    let finite = sample::force_values(&f).iter().all(|x| x.is_finite());
                    record.expect(finite, "finite", || format!("{f:?} at {}", place(p, &at)));
                    let parts = &f.parts;
                    let sum = parts.sum();
                    let size = parts.thrust.abs()
                        + parts.lug_thrust.abs()
                        + parts.compaction_resistance.abs()
                        + f.drawbar_pull.abs();
                    record.expect(
                        (sum - f.drawbar_pull).abs() <= 1e-12 * size,
                        "named parts",
                        || {
                            format!(
                                "add up to {sum}, pull {} at {}",
                                f.drawbar_pull,
                                place(p, &at)
                            )
                        },
                    );
                }
                Err(ModelError::NoEquilibrium { load, max_load }) => {
                    let ok = load == at.normal_load && max_load.is_finite() && max_load < load;
                    record.expect(ok, "no equilibrium", || {
                        format!("{max_load} of {load} N at {}", place(p, &at))
                    });
                }
                Err(e) => {
                    let text = e.to_string();
                    record.expect(!text.contains("NaN"), "error", || {
                        format!("'{text}' at {}", place(p, &at))
                    });
                }
            }
        }
    }
}

fn no_jumps(record: &mut Record, model: &dyn AnyModel, typical: &[&Vec<f64>]) {
    let n = model.params().len();
    for p in typical {
        let base = contact(0.2, 245.25);
        let Ok(value) = forces(model, p, &base) else {
            continue;
        };
        let size = scales(&value, &base);
        let scaled = |f: WheelForces<f64>| {
            let mut out = four(&f);
            out.iter_mut().zip(size).for_each(|(x, s)| *x /= s);
            out
        };
        let mut probe =
            |what: &str, from: f64, to: f64, make: &dyn Fn(f64) -> (Vec<f64>, Contact<f64>)| {
                let along = |v: f64| {
                    let (p, at) = make(v);
                    forces(model, &p, &at).ok().map(scaled)
                };
                let (size, place) = jump(&along, from, to);
                record.expect(size < 1e-4, "jump", || {
                    format!("of {size:.1e} at {what} = {place}, parameters {p:?}")
                });
            };
        // Zero slip lies on an end of both, so a jump there is not missed between two grid points.
        for (from, to) in [
            (-1.0, 0.0),
            (0.0, 1.0),
            (-0.01, 0.01),
            (-1.0, -0.99),
            (0.99, 1.0),
        ] {
            probe("slip", from, to, &|s| (p.to_vec(), contact(s, 245.25)));
        }
        probe("normal_load", 80.0, 600.0, &|w| {
            (p.to_vec(), contact(0.2, w))
        });
        for k in 0..n {
            let (low, high) = (0.8 * p[k], 1.25 * p[k] + 1e-3 * model.params()[k].prior_sd);
            for slip in [-0.2, 0.3] {
                probe(model.params()[k].name, low, high, &|v| {
                    let mut q = p.to_vec();
                    q[k] = v;
                    (q, contact(slip, 245.25))
                });
            }
        }
    }
}

/// A quantity in newtons: all of them times one factor is a change of unit, so forces follow and lengths stay.
fn scaling(record: &mut Record, model: &dyn AnyModel, typical: &[Vec<f64>]) {
    const FACTOR: f64 = 4.0;
    for p in typical {
        let scaled: Vec<f64> = model
            .params()
            .iter()
            .zip(p)
            .map(|(param, &x)| {
                if param.unit.starts_with('N') || param.unit.starts_with("Pa") {
                    FACTOR * x
                } else {
                    x
                }
            })
            .collect();
        for at in contacts() {
            let (Ok(f), Ok(g)) = (
                forces(model, p, &at),
                forces(
                    model,
                    &scaled,
                    &Contact {
                        normal_load: FACTOR * at.normal_load,
                        ..at
                    },
                ),
            ) else {
                continue;
            };
            let by = [FACTOR, FACTOR, 1.0, FACTOR];
            let ok = four(&f)
                .into_iter()
                .zip(four(&g))
                .zip(by)
                .zip(scales(&f, &at));
            let ok = ok
                .into_iter()
                .all(|(((a, b), by), scale)| (a * by - b).abs() <= 1e-9 * by * scale);
            record.expect(ok, "scaling", || {
                format!("{:?} and {:?} at {}", four(&f), four(&g), place(p, &at))
            });
        }
    }
}

/// The stresses carry the load and give pull and torque.
fn balance(record: &mut Record, model: &dyn AnyModel, typical: &[&Vec<f64>]) {
    const POINTS: usize = 8001;
    for p in typical {
        for at in [
            contact(0.05, 245.25),
            contact(0.6, 245.25),
            contact(-0.2, 90.0),
        ] {
            let Ok(f) = forces(model, p, &at) else {
                continue;
            };
            let Ok(Some(field)) = model.stress_field(p, &at) else {
                continue;
            };
            let profile = field.profile(POINTS);
            joined_at_the_apex(record, &profile, || place(p, &at));
            let mut sums = [0.0; 3];
            let flat = profile.flat.unwrap_or(-1.0);
            for pair in profile.points.windows(2) {
                let step = pair[1].angle - pair[0].angle;
                let on_the_flat = 0.5 * (pair[0].angle + pair[1].angle).abs() < flat;
                for point in pair {
                    let (sin, cos) = point.angle.sin_cos();
                    let (normal, tau) = (point.normal_stress, point.shear_stress);
                    let terms = if on_the_flat {
                        // dx = h dθ/cos² θ on a chord h = R cos θf below the axle.
                        let share = flat.cos() / cos.powi(2);
                        [normal, tau, tau * point.shear_arm].map(|x| x * share)
                    } else {
                        [
                            normal * cos + tau * sin,
                            tau * cos - normal * sin,
                            tau * point.shear_arm,
                        ]
                    };
                    sums.iter_mut()
                        .zip(terms)
                        .for_each(|(s, t)| *s += 0.5 * step * t * at.radius * at.width);
                }
            }
            let expected = [at.normal_load, f.drawbar_pull, f.resistive_torque];
            let [force, torque, ..] = scales(&f, &at);
            let ok = sums
                .iter()
                .zip(expected)
                .zip([at.normal_load, force, torque]);
            let ok = ok
                .into_iter()
                .all(|((s, e), scale)| (s - e).abs() <= 2e-3 * scale);
            record.expect(ok, "balance", || {
                format!(
                    "stresses give {sums:?}, expected {expected:?} at {}",
                    place(p, &at)
                )
            });
        }
    }
}

/// Both stresses are the same on both sides of the largest normal stress, where the branches of a contact meet.
fn joined_at_the_apex(
    record: &mut Record,
    profile: &StressProfile,
    place: impl FnOnce() -> String,
) {
    let apex = profile.max_normal;
    let largest = |of: &dyn Fn(&StressPoint) -> f64| {
        let along = profile.points.iter().map(|q| of(q).abs());
        along.fold(f64::MIN_POSITIVE, f64::max)
    };
    let beside = profile.points.windows(2);
    let beside = beside.filter(|w| w[0].angle <= apex.angle && apex.angle <= w[1].angle);
    let off = beside
        .flatten()
        .map(|q| {
            let normal = (q.normal_stress - apex.normal_stress) / largest(&|q| q.normal_stress);
            let shear = (q.shear_stress - apex.shear_stress) / largest(&|q| q.shear_stress);
            normal.abs().max(shear.abs())
        })
        .fold(0.0, f64::max);
    record.expect(off < 2e-2, "apex", || {
        format!("stresses jump by {off:.1e} of their largest at {}", place())
    });
}

/// A wheel that sinks has a largest load, and the error that names it is right on both its sides.
fn bearing_limit(record: &mut Record, model: &dyn AnyModel, typical: &[&Vec<f64>]) {
    for p in typical {
        for slip in [-0.3, 0.2, 0.9] {
            let sinks = forces(model, p, &contact(slip, 40.0)).is_ok_and(|f| f.sinkage.is_some());
            if !sinks {
                continue;
            }
            match forces(model, p, &contact(slip, 1e12)) {
                Err(ModelError::NoEquilibrium { max_load, .. }) => {
                    let below = forces(model, p, &contact(slip, 0.999 * max_load));
                    let above = forces(model, p, &contact(slip, 1.001 * max_load));
                    let ok =
                        below.is_ok() && matches!(above, Err(ModelError::NoEquilibrium { .. }));
                    record.expect(ok, "no equilibrium", || {
                        format!("largest load {max_load} N, but {below:?} below and {above:?} above, parameters {p:?}")
                    });
                }
                other => record.expect(false, "no equilibrium", || {
                    format!("{other:?} for 1e12 N, parameters {p:?}")
                }),
            }
        }
    }
}

/// Eight soils and contacts side by side give what each gives alone.
fn lanes(record: &mut Record, model: &dyn AnyModel, typical: &[Vec<f64>]) {
    let mut cases = vec![];
    for (k, at) in contacts().iter().enumerate() {
        for p in typical.iter().skip(k % 3).step_by(3) {
            if let Ok(f) = forces(model, p, at) {
                cases.push((p, *at, f));
            }
        }
    }
    for group in cases.chunks_exact(8) {
        let pack = |value: &dyn Fn(usize) -> f64| Lanes(f64x8::new(std::array::from_fn(value)));
        let p: Vec<Lanes> = (0..model.params().len())
            .map(|k| pack(&|lane| group[lane].0[k]))
            .collect();
        let mut at: Contact<Lanes> = group[0].1.lift();
        at.slip = pack(&|lane| group[lane].1.slip);
        at.normal_load = pack(&|lane| group[lane].1.normal_load);
        match Lanes::of_model(model).wheel_forces_at(&p, &at) {
            Ok(f) => {
                let rows = [
                    f.drawbar_pull,
                    f.resistive_torque,
                    f.sinkage.unwrap_or(Lanes::from(0.0)),
                    f.lateral_force,
                ];
                for (lane, (p, at, alone)) in group.iter().enumerate() {
                    let found = rows.map(|row| row.0.to_array()[lane]);
                    let ok = found.iter().zip(four(alone)).zip(scales(alone, at));
                    let ok = ok
                        .into_iter()
                        .all(|((a, b), scale)| (a - b).abs() <= 1e-10 * scale);
                    record.expect(ok, "lanes", || {
                        format!("{found:?}, alone {:?} at {}", four(alone), place(p, at))
                    });
                }
            }
            Err(e) => record.expect(false, "lanes", || {
                format!("{e}, where each lane alone gives forces")
            }),
        }
    }
}
