//! Exact derivatives against finite differences.

use super::Record;
use super::model::{forces, four, place, scales};
use super::numeric::difference;
use super::sample::contact;
use crate::contact::Contact;
use crate::dual::{Dual8, jacobian};
use crate::law::{lift_with, rows};
use crate::model::AnyModel;
use crate::param::{Param, Scale};
use crate::scalar::Scalar;

/// Step for differences in a parameter, none where the stencil would leave its range.
pub(super) fn step(p: &Param, value: f64) -> Option<f64> {
    let h = match p.scale {
        Scale::Log => 2e-3 * value,
        Scale::Linear => (2e-3 * value.abs()).max(0.02 * p.prior_sd),
    };
    (h > 0.0 && value - 3.0 * h >= p.min && value + 3.0 * h <= p.max).then_some(h)
}

/// One derivative against its difference: relative to itself and to what the whole output moves over the variable's
/// own size. A difference that disagrees with itself at half the step says nothing; returns whether it spoke.
pub(super) fn compare(
    record: &mut Record,
    exact: f64,
    (found, error): (f64, f64),
    scale: f64,
    what: impl FnOnce() -> String,
) -> bool {
    let tolerance = 1e-6 * (exact.abs() + scale);
    if error > tolerance {
        return false;
    }
    record.derivatives += usize::from(exact != 0.0 || found != 0.0);
    record.expect(
        (exact - found).abs() <= 2.0 * tolerance,
        "derivative",
        || format!("{exact:e}, by differences {found:e}: {}", what()),
    );
    true
}

/// Every output of a model by every parameter, by slip and by load.
pub(super) fn derivatives(record: &mut Record, model: &dyn AnyModel, typical: &[&Vec<f64>]) {
    let n = model.params().len();
    let (mut asked, mut spoke) = (0, 0);
    for p in typical {
        for at in [-0.4, -0.1, 0.05, 0.3, 0.8]
            .into_iter()
            .flat_map(|s| [contact(s, 90.0), contact(s, 245.25)])
        {
            let Ok(value) = forces(model, p, &at) else {
                continue;
            };
            let mut x = p.to_vec();
            x.extend([at.slip, at.normal_load]);
            let exact = jacobian(&x, |x| {
                let lifted = lift_with(&at, x[n], x[n + 1]);
                Dual8::of_model(model)
                    .wheel_forces_at(&x[..n], &lifted)
                    .map(|f| rows(&f))
            });
            let Ok((_, exact)) = exact else {
                record.expect(false, "derivative", || {
                    format!("no dual numbers at {}", place(p, &at))
                });
                continue;
            };
            for k in 0..n + 2 {
                let h = match k {
                    k if k < n => step(&model.params()[k], x[k]),
                    k if k == n => Some(2e-3),
                    _ => Some(2e-3 * at.normal_load),
                };
                let Some(h) = h else { continue };
                let along = |v: f64| {
                    let mut y = x.clone();
                    y[k] = v;
                    let moved = Contact {
                        slip: y[n],
                        normal_load: y[n + 1],
                        ..at
                    };
                    forces(model, &y[..n], &moved).ok().map(|f| four(&f))
                };
                let Some(found) = difference(&along, x[k], h) else {
                    continue;
                };
                for (row, (found, scale)) in found.into_iter().zip(scales(&value, &at)).enumerate()
                {
                    asked += 1;
                    let name = if k < n {
                        model.params()[k].name
                    } else {
                        ["slip", "normal_load"][k - n]
                    };
                    let output = ["pull", "torque", "sinkage", "side force"][row];
                    let per = scale / (x[k].abs() + 50.0 * h);
                    if compare(record, exact[(row, k)], found, per, || {
                        format!("{output} by {name} at {}", place(p, &at))
                    }) {
                        spoke += 1;
                    }
                }
            }
        }
    }
    record.expect(10 * spoke >= 8 * asked, "derivative", || {
        format!("only {spoke} of {asked} differences settle")
    });
}
