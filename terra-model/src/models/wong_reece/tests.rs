#![allow(clippy::unwrap_used)]

use super::kernel::Integrator;
use super::{FINE, WongReece};
use crate::catalogue;
use crate::contact::Contact;
use crate::real::Root;
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
