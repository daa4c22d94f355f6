#![allow(clippy::unwrap_used)]

use super::gradient::SIDEWAYS;
use super::kernel::Integrator;
use super::solve::{self, Start};
use super::wheel::Integrals;
use super::{COARSE, FINE, WongReece};
use crate::catalogue;
use crate::contact::Contact;
use crate::dual::{Dual8, jacobian};
use crate::error::ModelError;
use crate::real::{Real, Root};
use num_dual::Dual64;

/// Nodes side by side carry the load of nodes one by one, and its slope in ln θ1, where the wheel slides sideways: smooth, with
/// a hump of shear, braked, with a rear contact, over a layer.
#[test]
fn a_wheel_that_slides_sideways_carries_the_same_by_both_integrals() {
    let mut compared = 0;
    for id in ["dry_sand", "upland_sandy_loam", "lean_clay_22"] {
        let p = catalogue::find(id).unwrap().parameters(&WongReece).unwrap();
        for (slip, tan, hump, exit, layer) in [
            (0.2, 0.3, 0.0, 0.0, 0.0),
            (0.05, -1.2, 0.0, 0.0, 0.0),
            (0.6, 0.1, 0.4, 0.0, 0.0),
            (-0.2, 0.4, 0.0, 0.0, 0.0),
            (-0.05, 1e-6, 0.3, 0.3, 0.0),
            (0.3, 0.5, 0.0, 0.4, 0.01),
            (0.1, 0.0, 0.0, 0.0, 0.0),
        ] {
            let mut at = Contact::new(slip, 245.25, 0.254, 0.15);
            at.hooks.lateral_slip = Some(tan);
            at.hooks.shear_hump = hump;
            at.hooks.exit_ratio = exit;
            (at.hooks.layer_depth, at.hooks.layer_stiffness) = (layer, 1e5);
            let mut wheel = WongReece::wheel(&p, &at).unwrap();
            // Without a sideways slip it would be left out.
            wheel.lateral = Some(tan);
            for entry in [0.05, 0.3, 0.8] {
                let fine = Integrator::<f64, FINE>::new(&wheel, wheel.stress());
                let (load, slope) = fine.at(entry).load(entry);
                let seeded = Dual64::from(entry) * (0.0.seed() + 1.0);
                let found = wheel.map(Dual64::from).integrals(seeded).load;
                let place = format!("{id} {at:?} at {entry}: {load} {slope}, {found:?}");
                let size = found.re.abs();
                assert!((load - found.re).abs() <= 1e-6 * size, "{place}");
                let size = found.eps.abs() + size;
                assert!((slope - found.eps).abs() <= 1e-5 * size, "{place}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 63);
}

/// All that a wheel that slides sideways depends on: soil, slip, load, radius and width, tan β, hump, exit, lugs, layer.
fn slid<T: Real>(x: &[T]) -> (Vec<T>, Contact<T>) {
    let mut at = Contact::new(x[8], x[9], x[10], x[11]);
    at.hooks.lateral_slip = Some(x[12]);
    at.hooks.shear_hump = x[13];
    at.hooks.exit_ratio = x[14];
    at.hooks.lug_height = x[15];
    (at.hooks.layer_depth, at.hooks.layer_stiffness) = (x[16], x[17]);
    (x[..8].to_vec(), at)
}

/// Forces and all their derivatives where a wheel slides sideways, by formula in the primal and node by node in the scalar itself:
/// driven and braked, to either side and next to straight, with a hump of shear, a rear contact, lugs, and over a layer.
#[test]
fn a_wheel_that_slides_sideways_has_the_same_slopes_by_both_ways() {
    let mut compared = 0;
    for id in ["dry_sand", "upland_sandy_loam", "lean_clay_22"] {
        let p = catalogue::find(id).unwrap().parameters(&WongReece).unwrap();
        for [slip, tan, hump, exit, lugs, depth] in [
            [0.2, 0.3, 0.0, 0.0, 0.0, 0.0],
            [0.05, -1.2, 0.0, 0.0, 0.01, 0.0],
            [0.6, 0.1, 0.4, 0.0, 0.0, 0.0],
            [-0.2, 0.4, 0.0, 0.0, 0.0, 0.0],
            [-0.1, 0.05, 0.3, 0.3, 0.0, 0.0],
            [0.3, 0.5, 0.0, 0.4, 0.0, 0.01],
            [0.1, 1e-3, 0.0, 0.0, 0.0, 0.0],
        ] {
            let mut x = p.clone();
            x.extend([slip, 245.25, 0.254, 0.15, tan, hump, exit, lugs, depth, 1e5]);
            let by = |sideways: bool| {
                let of = |x: &[Dual8]| {
                    let (p, at) = slid(x);
                    let wheel = WongReece::wheel(&p, &at)?;
                    let (entry, found) = if sideways {
                        solve::balance::<_, COARSE, FINE, SIDEWAYS>(&wheel, &at, Start::Guess)?
                    } else {
                        solve::rare::<_, COARSE, FINE>(&wheel, &at)?
                    };
                    let Integrals {
                        thrust,
                        compaction,
                        shear,
                        lateral,
                        ..
                    } = found;
                    Ok::<_, ModelError>(vec![entry, thrust, compaction, shear, lateral])
                };
                jacobian(&x, of).unwrap()
            };
            let ((values, slopes), (there, expected)) = (by(true), by(false));
            for (q, (found, value)) in values.iter().zip(&there).enumerate() {
                let size = value.abs().max(1e-3 * there[1].abs());
                let off = (found - value).abs();
                assert!(off <= 1e-6 * size, "{id} {x:?} {q}: {found} {value}");
                for (k, x_k) in x.iter().enumerate() {
                    let (found, slope) = (slopes[(q, k)], expected[(q, k)]);
                    let scale = x_k.abs().max(1e-2);
                    let off = (found - slope).abs() * scale;
                    let most = 1e-5 * (size + (slope * scale).abs());
                    assert!(off <= most, "{id} {x:?} {q} by {k}: {found} {slope}");
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, 3 * 7 * 5 * 18);
}
