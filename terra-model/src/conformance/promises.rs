//! What an effect says of itself, against what it does.

use super::Record;
use super::effect::{act, bits, magnitudes};
use super::sample::contacts;
use crate::contact::Contact;
use crate::dual::Dual8;
use crate::effect::{AnyEffect, Circumstance, Touch};
use crate::param::{Param, natural_size};

/// Symbols of units; prefixes are no part of SI base values, which all of terra's are.
const UNITS: [&str; 12] = [
    "1", "m", "s", "kg", "rad", "N", "Pa", "J", "W", "A", "V", "n",
];

/// Whether a unit is put together of SI symbols, with powers that may hold the sinkage exponent n.
pub(super) fn is_si(unit: &str) -> bool {
    let symbols = unit.split(|c: char| !c.is_ascii_alphabetic());
    let mut named = symbols.filter(|s| !s.is_empty());
    let all = named.all(|symbol| UNITS.contains(&symbol));
    all && (unit == "1" || unit.chars().any(|c| c.is_ascii_alphabetic()))
}

/// Whether it changes a contact or the forces there.
fn acts(effect: &dyn AnyEffect, e: &[f64], at: &Contact<f64>) -> bool {
    [Touch::Contact, Touch::Forces].into_iter().any(|touch| {
        let before = act::<f64>(effect, touch, at, None);
        bits(&before) != bits(&act(effect, touch, at, Some(e)))
    })
}

/// Nothing happens where a circumstance that it reads is zero, and it reads those without which nothing happens.
pub(super) fn circumstances(record: &mut Record, effect: &dyn AnyEffect) {
    let anywhere = |change: &dyn Fn(&mut Contact<f64>)| {
        magnitudes(effect.params()).iter().any(|e| {
            contacts().into_iter().any(|mut at| {
                change(&mut at);
                acts(effect, e, &at)
            })
        })
    };
    if !anywhere(&|_| {}) {
        return;
    }
    for circumstance in Circumstance::ALL {
        let without = anywhere(&|at| match circumstance {
            Circumstance::SlipAngle => at.slip_angle = 0.0,
            Circumstance::Path => at.path = 0.0,
            Circumstance::EarlierPasses => at.earlier_passes = 0.0,
            Circumstance::Side => at.side = 0.0,
            Circumstance::Speed => (at.speed, at.wheel_speed) = (0.0, 0.0),
        });
        let says = effect.reads().contains(&circumstance);
        let name = circumstance.name();
        record.expect(!(says && without), "reads", || {
            format!("READS has the {name}, and without it something changes all the same")
        });
        // A wheel that stands still is no log.
        let speed = circumstance == Circumstance::Speed;
        record.expect(says || without || speed, "reads", || {
            format!("nothing changes without the {name}: READS must have it")
        });
    }
}

/// A share of what a wheel carries needs a magnitude in a unit of what it carries.
pub(super) fn share(record: &mut Record, effect: &dyn AnyEffect) {
    let unit = effect.params().first().map_or("", |p| p.unit);
    let natural = natural_size(unit, 245.25, 0.254).is_some();
    record.expect(effect.share() == 0.0 || natural, "share", || {
        format!("SHARE of a magnitude in '{unit}', which is the same on all wheels: leave it 0")
    });
}

/// Finite numbers at both ends of the range of each magnitude, as a fit goes there.
pub(super) fn ends(record: &mut Record, effect: &dyn AnyEffect) {
    let params = effect.params();
    let inside = |p: &Param| p.prior_sd.clamp(p.min, p.max);
    for (k, param) in params.iter().enumerate() {
        for end in [param.min, param.max].into_iter().filter(|v| v.is_finite()) {
            let mut e: Vec<f64> = params.iter().map(inside).collect();
            e[k] = end;
            for touch in [
                Touch::Contact,
                Touch::Forces,
                Touch::Vehicle,
                Touch::Loads,
                Touch::Sensor,
            ] {
                for at in contacts() {
                    let value = act::<f64>(effect, touch, &at, Some(&e));
                    record.expect(value.iter().all(|x| x.is_finite()), "finite", || {
                        format!(
                            "{touch:?} at {} = {end}, an end of its range: {value:?}",
                            param.name
                        )
                    });
                }
            }
        }
    }
}

/// What acts on vehicle, loads or a sensor is flat at zero if and only if it says so.
pub(super) fn slope_beside_forces(record: &mut Record, effect: &dyn AnyEffect) {
    let n = effect.params().len();
    let on_wheels = [Touch::Contact, Touch::Forces];
    if effect.touches().iter().any(|t| on_wheels.contains(t)) {
        // Asked on models.
        return;
    }
    let zero: Vec<Dual8> = (0..n)
        .map(|k| {
            let zero = Dual8::from(0.0);
            if k == 0 { zero.derivative(0) } else { zero }
        })
        .collect();
    let slopes = effect.touches().iter().any(|touch| {
        contacts().iter().any(|at| {
            let out = act::<Dual8>(effect, *touch, at, Some(&zero));
            out.iter().any(|d| d.eps.0.is_some_and(|eps| eps[0] != 0.0))
        })
    });
    record.expect(effect.is_flat() != slopes, "flat", || match slopes {
        true => "FLAT is true, and it has a slope at zero: leave it false".to_owned(),
        false => {
            "it has no slope at zero, so that a screen would not see it: FLAT = true".to_owned()
        }
    });
}
