//! The examination of an effect, alone and on a model.

use std::sync::Arc;

use nalgebra::{Const, U1};
use wide::f64x8;

use super::derivatives::{compare, step};
use super::model::by_slip_and_load;
use super::numeric::difference;
use super::promises;
use super::sample::{
    self, contact, contact_values, contacts, force_values, hooks, load_values, vehicle_values,
};
use super::{Checked, Failures, Record, described};
use crate::contact::Contact;
use crate::dual::{Dual8, jacobian};
use crate::effect::{AnyEffect, Channel, Effect, Touch};
use crate::error::ModelError;
use crate::forces::{Angles, WheelForces};
use crate::lanes::Lanes;
use crate::law::{ForceLaw, Law, lift_with};
use crate::model::AnyModel;
use crate::param::Param;
use crate::real::Real;
use crate::registry::Registry;
use crate::scalar::Scalar;
use crate::vehicle::BodyLoads;

const TOUCHES: [Touch; 5] = [
    Touch::Contact,
    Touch::Forces,
    Touch::Vehicle,
    Touch::Loads,
    Touch::Sensor,
];
const SOIL_NAMES: [&str; 5] = [
    "cohesion",
    "friction_angle",
    "stiffness",
    "sinkage_exponent",
    "shear_modulus",
];

/// Examines an effect written as a type, alone and on every shipped model.
///
/// # Errors
/// [`Failures`] with every promise that is not kept.
pub fn check_effect<E: Effect>() -> Result<Checked, Failures> {
    let effect: Arc<dyn AnyEffect> = Arc::new(E::default());
    let mut total = check_effect_dyn(&*effect)?;
    for model in Registry::builtin().models() {
        let pair = check_pair(model, &effect)?;
        total.comparisons += pair.comparisons;
        total.derivatives += pair.derivatives;
    }
    Ok(total)
}

/// Examines an effect alone: what each of its five methods does to sample contacts, forces, vehicles, loads, readings.
///
/// # Errors
/// As [`check_effect`].
pub fn check_effect_dyn(effect: &dyn AnyEffect) -> Result<Checked, Failures> {
    let mut record = Record::new(effect.name());
    let texts = [
        ("name", effect.name()),
        ("summary", effect.summary()),
        ("reference", effect.reference()),
    ];
    described(&mut record, texts, effect.params());
    for (what, text) in [
        ("form", effect.form()),
        ("regime", effect.regime()),
        ("experiment", effect.isolated_by()),
    ] {
        record.expect(!text.is_empty(), "description", || format!("no {what}"));
    }
    let known = effect
        .needs_soil()
        .iter()
        .find(|name| !SOIL_NAMES.contains(name));
    record.expect(known.is_none(), "needs", || {
        format!("the soil has no '{}'", known.unwrap_or(&""))
    });
    let has_magnitude = effect
        .params()
        .first()
        .is_some_and(|p| p.min <= 0.0 && p.max > 0.0);
    record.expect(has_magnitude, "parameters", || {
        "the first must be a magnitude whose range holds 0".into()
    });

    nothing_at_zero(&mut record, effect);
    acts_where_it_says(&mut record, effect);
    promises::circumstances(&mut record, effect);
    promises::share(&mut record, effect);
    promises::slope_beside_forces(&mut record, effect);
    promises::ends(&mut record, effect);
    values(&mut record, effect);
    record.finish()
}

/// Examines one effect on one model: refused by a typed error, or at magnitude zero bit for bit the model alone, and
/// with right derivatives at other magnitudes.
///
/// # Errors
/// As [`check_effect`].
pub fn check_pair(
    model: &Arc<dyn AnyModel>,
    effect: &Arc<dyn AnyEffect>,
) -> Result<Checked, Failures> {
    let mut record = Record::new(format!("{}+{}", model.name(), effect.name()));
    let plain = Law::new(Arc::clone(model), vec![]);
    let law = match Law::new(Arc::clone(model), vec![Arc::clone(effect)]) {
        Ok(law) => law,
        Err(ModelError::EffectNotApplicable { .. } | ModelError::SoilUnknown { .. }) => {
            record.expect(true, "refused", String::new);
            return record.finish();
        }
        Err(e) => {
            record.expect(false, "composition", || e.to_string());
            return record.finish();
        }
    };
    let Ok(plain) = plain else {
        record.expect(false, "composition", || "the model alone is no law".into());
        return record.finish();
    };
    let mut soils = sample::literature(&**model);
    if soils.is_empty() {
        soils = model.typical_parameters();
    }
    if soils.is_empty() {
        let usable = |p: &Vec<f64>| plain.forces(p, &contact(0.2, 245.25)).is_ok();
        soils = sample::domain(model.params(), 200)
            .into_iter()
            .filter(usable)
            .collect();
    }
    for p in soils.iter().step_by(soils.len().div_ceil(4).max(1)) {
        let with = |e: &[f64]| [p.as_slice(), e].concat();
        for at in contacts() {
            let zero = with(&vec![0.0; effect.params().len()]);
            match (plain.forces(p, &at), law.forces(&zero, &at)) {
                (Ok(f), Ok(g)) => record.expect(
                    bits(&force_values(&f)) == bits(&force_values(&g)),
                    "zero",
                    || format!("magnitude 0 gives {g:?} for {f:?}"),
                ),
                (f, g) => record.expect(f.is_err() && g.is_err(), "zero", || {
                    format!("{g:?} for {f:?}")
                }),
            }
        }
        slope_at_zero(&mut record, &law, p, &**effect);
        let magnitude = typical(effect.params(), 0.5);
        if let Some(beside) = law.beside_slip_and_load() {
            by_slip_and_load(&mut record, p, &beside, |at| {
                law.forces(&with(&magnitude), at)
            });
        }
        for at in [contact(0.3, 245.25), contact(-0.2, 90.0)] {
            let x = with(&magnitude);
            by_contact(&mut record, &law, &x, &at);
            let Ok((value, exact)) = law.jacobian(&x, &at) else {
                continue;
            };
            let force = value.drawbar_pull.abs() + value.resistive_torque.abs() / at.radius;
            let size = [
                force,
                force * at.radius,
                value.sinkage.unwrap_or(1.0),
                force,
            ];
            for (k, param) in effect.params().iter().enumerate() {
                let column = p.len() + k;
                let Some(h) = step(param, x[column]) else {
                    continue;
                };
                let along = |v: f64| {
                    let mut y = x.clone();
                    y[column] = v;
                    let f = law.forces(&y, &at).ok()?;
                    Some([
                        f.drawbar_pull,
                        f.resistive_torque,
                        f.sinkage.unwrap_or(0.0),
                        f.lateral_force,
                    ])
                };
                let Some(found) = difference(&along, x[column], h) else {
                    continue;
                };
                for (row, (found, size)) in found.into_iter().zip(size).enumerate() {
                    let per = size / (x[column].abs() + 50.0 * h);
                    compare(&mut record, exact[(row, column)], found, per, || {
                        format!("row {row} by {}", param.name)
                    });
                }
            }
        }
    }
    record.finish()
}

/// Pull and torque under the effect by slip and load: what noise of these two is carried by.
fn by_contact(record: &mut Record, law: &Law, x: &[f64], at: &Contact<f64>) {
    let parameters: Vec<Dual8> = x.iter().map(|v| Dual8::from(*v)).collect();
    let exact = jacobian(&[at.slip, at.normal_load], |v| {
        let f = law.forces_at(&parameters, &lift_with(at, v[0], v[1]))?;
        Ok::<_, ModelError>(vec![f.drawbar_pull, f.resistive_torque])
    });
    let Ok((value, exact)) = exact else {
        return;
    };
    let [pull, torque] = [value[0], value[1]];
    let force = pull.abs() + torque.abs() / at.radius;
    for (column, (name, from, h)) in [
        ("slip", at.slip, 2e-3),
        ("normal_load", at.normal_load, 2e-3 * at.normal_load),
    ]
    .into_iter()
    .enumerate()
    {
        let along = |v: f64| {
            let mut moved = *at;
            *(if column == 0 {
                &mut moved.slip
            } else {
                &mut moved.normal_load
            }) = v;
            let f = law.forces(x, &moved).ok()?;
            Some([f.drawbar_pull, f.resistive_torque])
        };
        let Some(found) = difference(&along, from, h) else {
            continue;
        };
        for (row, found) in found.into_iter().enumerate() {
            let size = if row == 0 { force } else { force * at.radius };
            let per = size / (from.abs() + 50.0 * h);
            compare(record, exact[(row, column)], found, per, || {
                let output = ["pull", "torque"][row];
                format!(
                    "{output} by {name} at slip {}, load {} N",
                    at.slip, at.normal_load
                )
            });
        }
    }
}

/// A magnitude of `share` prior deviations inside the declared range.
fn typical(params: &[Param], share: f64) -> Vec<f64> {
    params
        .iter()
        .map(|p| (share * p.prior_sd).clamp(p.min, p.max))
        .collect()
}

/// Sample magnitudes, none of them zero.
pub(super) fn magnitudes(params: &[Param]) -> Vec<Vec<f64>> {
    let nonzero = |e: &Vec<f64>| e.iter().all(|x| *x != 0.0);
    [-1.5, -0.4, 0.05, 0.4, 1.5]
        .into_iter()
        .map(|share| typical(params, share))
        .filter(nonzero)
        .collect()
}

/// An effect on forces is flat at zero if and only if it says so: a screen by slopes would never see it.
fn slope_at_zero(record: &mut Record, law: &Law, p: &[f64], effect: &dyn AnyEffect) {
    let with = |e: Vec<f64>| [p, e.as_slice()].concat();
    let (zero, some) = (
        with(vec![0.0; effect.params().len()]),
        with(typical(effect.params(), 0.5)),
    );
    let (mut acts, mut slopes) = (false, false);
    for at in contacts() {
        let (Ok((value, jacobian)), Ok(there)) = (law.jacobian(&zero, &at), law.forces(&some, &at))
        else {
            continue;
        };
        acts |= bits(&force_values(&value)) != bits(&force_values(&there));
        slopes |= jacobian.column(p.len()).iter().any(|v| *v != 0.0);
    }
    record.expect(
        !acts || effect.is_flat() != slopes,
        "flat",
        || match slopes {
            true => "FLAT is true, and it has a slope at zero: leave it false".to_owned(),
            false => {
                "it has no slope at zero, so that a screen would not see it: FLAT = true".to_owned()
            }
        },
    );
}

pub(super) fn bits(values: &[f64]) -> Vec<u64> {
    // -0 and +0 are the same number.
    values
        .iter()
        .map(|x| if *x == 0.0 { 0 } else { x.to_bits() })
        .collect()
}

/// Forces of a wheel deep in soil, as an effect may find them.
fn forces<T: Real>() -> WheelForces<T> {
    let mut f = WheelForces::from_thrust(T::from(80.0), T::from(50.0), T::from(24.0));
    f.lateral_force = T::from(3.0);
    f.sinkage = Some(T::from(0.03));
    f.angles = Some(Angles {
        entry: T::from(0.5),
        exit: T::from(-0.05),
        max_stress: T::from(0.2),
    });
    f
}

/// What the effect makes of one of its five subjects: all numbers of it, before (`e` none) or after.
pub(super) fn act<T: Scalar>(
    effect: &dyn AnyEffect,
    touch: Touch,
    at: &Contact<f64>,
    e: Option<&[T]>,
) -> Vec<T> {
    let soil = sample::lift_soil::<T>(&sample::soil());
    let acting = T::of_effect(effect);
    match touch {
        Touch::Contact => {
            let at: Contact<T> = at.lift();
            contact_values(&e.map_or(at, |e| acting.before_at(e, &soil, at)))
        }
        Touch::Forces => force_values(&e.map_or(forces(), |e| {
            acting.after_at(e, &soil, &at.lift(), forces())
        })),
        Touch::Vehicle => {
            let vehicle = sample::lift_vehicle(&sample::vehicle());
            vehicle_values(&e.map_or(vehicle, |e| acting.vehicle_at(e, vehicle)))
        }
        Touch::Loads => {
            let (vehicle, motion) = (
                sample::lift_vehicle(&sample::vehicle()),
                sample::lift_motion(&sample::motion()),
            );
            let none = BodyLoads::none();
            load_values(&e.map_or(none, |e| acting.loads_at(e, &vehicle, &motion, none)))
        }
        Touch::Sensor => {
            let (truth, rate) = (T::from(13.0 * at.slip + 7.0), T::from(0.6));
            Channel::ALL
                .iter()
                .map(|&c| e.map_or(truth, |e| acting.report_at(e, c, truth, rate)))
                .collect()
        }
    }
}

fn nothing_at_zero(record: &mut Record, effect: &dyn AnyEffect) {
    let zero = vec![0.0; effect.params().len()];
    for touch in TOUCHES {
        for at in contacts() {
            let (before, after) = (
                act::<f64>(effect, touch, &at, None),
                act(effect, touch, &at, Some(&zero)),
            );
            record.expect(bits(&before) == bits(&after), "zero", || {
                format!("magnitude 0 changes {touch:?} from {before:?} to {after:?}")
            });
        }
    }
}

/// The methods it overrides and the hooks it moves are those it declares.
fn acts_where_it_says(record: &mut Record, effect: &dyn AnyEffect) {
    let mut moved = vec![];
    for touch in TOUCHES {
        let acts = magnitudes(effect.params()).iter().any(|e| {
            contacts().iter().any(|at| {
                bits(&act::<f64>(effect, touch, at, None)) != bits(&act(effect, touch, at, Some(e)))
            })
        });
        let says = effect.touches().contains(&touch);
        record.expect(acts == says, "touches", || {
            format!("{touch:?}: declared {says}, acts {acts}")
        });
    }
    for e in magnitudes(effect.params()) {
        for at in contacts() {
            let after = f64::of_effect(effect).before_at(&e, &sample::soil(), at);
            for ((hook, a), (_, b)) in hooks(&at.hooks).into_iter().zip(hooks(&after.hooks)) {
                if a.to_bits() != b.to_bits() && !moved.contains(&hook) {
                    moved.push(hook);
                }
            }
        }
    }
    for (k, channel) in Channel::ALL.iter().enumerate() {
        let alone =
            effect.channels().contains(channel) || !effect.touches().contains(&Touch::Sensor);
        let acts = !alone
            && magnitudes(effect.params()).iter().any(|e| {
                contacts().iter().any(|at| {
                    let before = act::<f64>(effect, Touch::Sensor, at, None);
                    bits(&before[k..=k]) != bits(&act(effect, Touch::Sensor, at, Some(e))[k..=k])
                })
            });
        record.expect(!acts, "channels", || {
            format!("{channel:?} is not declared, and changed")
        });
    }
    let same = moved.len() == effect.needs().len()
        && moved.iter().all(|hook| effect.needs().contains(hook));
    record.expect(same, "needs", || {
        format!("declares {:?}, moves {moved:?}", effect.needs())
    });
}

/// Finite values, derivatives by the magnitudes, and lanes.
fn values(record: &mut Record, effect: &dyn AnyEffect) {
    let n = effect.params().len().min(8);
    for touch in TOUCHES {
        for e in magnitudes(effect.params()) {
            for at in contacts() {
                let value = act::<f64>(effect, touch, &at, Some(&e));
                let finite = value.iter().all(|x| x.is_finite());
                record.expect(finite, "finite", || {
                    format!("{touch:?} with {e:?} gives {value:?}")
                });

                let packed: Vec<Lanes> = e.iter().map(|&x| Lanes(f64x8::splat(x))).collect();
                let lanes = act::<Lanes>(effect, touch, &at, Some(&packed));
                let ok = lanes.iter().zip(&value).all(|(lane, x)| {
                    lane.0
                        .to_array()
                        .iter()
                        .all(|y| (y - x).abs() <= 1e-10 * (x.abs() + 1e-300))
                });
                record.expect(ok, "lanes", || {
                    format!("{touch:?} with {e:?} differs from one at a time")
                });

                let seeds: Vec<Dual8> = e
                    .iter()
                    .enumerate()
                    .map(|(k, &x)| {
                        if k < 8 {
                            Dual8::from_re(x).derivative(k)
                        } else {
                            Dual8::from_re(x)
                        }
                    })
                    .collect();
                let dual = act::<Dual8>(effect, touch, &at, Some(&seeds));
                for k in 0..n {
                    let Some(h) = step(&effect.params()[k], e[k]) else {
                        continue;
                    };
                    for (row, d) in dual.iter().enumerate() {
                        let along = |v: f64| {
                            let mut y = e.clone();
                            y[k] = v;
                            act::<f64>(effect, touch, &at, Some(&y))
                                .get(row)
                                .map(|x| [*x])
                        };
                        let exact = d.eps.unwrap_generic(Const::<8>, U1)[k];
                        let Some([found]) = difference(&along, e[k], h) else {
                            continue;
                        };
                        let per = d.re.abs() / (e[k].abs() + 50.0 * h);
                        compare(record, exact, found, per, || {
                            format!("{touch:?}, number {row}, at {e:?}")
                        });
                    }
                }
            }
        }
    }
}
