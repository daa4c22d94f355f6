//! Tyres against closed forms and a second quadrature.

use super::*;
use crate::ForceLaw;

fn sand(pressure: f64) -> Vec<f64> {
    let mut p = CompliantTyre::typical().remove(0);
    p[6] = pressure;
    p
}

/// On ground that hardly gives, all is flat: p_t b l = W, z = 0, and at high slip the tyre slides with
/// A c + W tan φ.
#[test]
fn on_firm_ground_the_tyre_carries_its_load_by_its_pressure() {
    let mut p = sand(5e4);
    (p[0], p[1], p[5]) = (0.0, 1e13, 1e-5);
    let at = Contact::new(0.5, 500.0, 0.3, 0.2);
    let f = CompliantTyre.forces(&p, &at).unwrap();
    let length = 500.0 / (5e4 * 0.2);
    let from = (0.5 * length / 0.3f64).asin();
    let exit = f.angles.unwrap().exit;
    assert!((exit + from).abs() < 1e-3, "{exit} {from}");
    let slides = 0.2 * length * p[3] + 500.0 * p[4].tan();
    assert!(
        (f.drawbar_pull / slides - 1.0).abs() < 2e-3,
        "{}",
        f.drawbar_pull
    );
    assert!((f.resistive_torque / (slides * 0.3 * from.cos()) - 1.0).abs() < 2e-3);
    assert!(f.sinkage.unwrap() < 1e-5);
}

/// The front carries up to the tyre's pressure, and the flat just that; without shear displacement there is no shear.
#[test]
fn stresses_join_where_the_flat_begins() {
    let at = Contact::new(0.2, 245.25, 0.254, 0.15);
    let field = CompliantTyre.stresses(&sand(1e4), &at).unwrap();
    let profile = field.unwrap().profile(101);
    let flat = profile.flat.unwrap();
    for point in &profile.points {
        if point.angle.abs() < flat {
            assert_eq!(point.normal_stress, 1e4);
        } else {
            assert!(point.normal_stress <= 1e4 * (1.0 + 1e-9));
        }
    }
    assert_eq!(profile.max_normal.normal_stress, 1e4);
    let last = profile.points[100];
    assert!(last.normal_stress < 1e-3 && last.shear_stress.abs() < 1e-3);
    let round = CompliantTyre.stresses(&sand(5e6), &at).unwrap();
    assert_eq!(round.unwrap().flat, None);
}

/// A tyre harder than the soil ever pushes is round: its pressure does not matter, its lowest point bears k z^n.
#[test]
fn a_hard_tyre_is_a_rigid_wheel() {
    let at = Contact::new(0.2, 245.25, 0.254, 0.15);
    let (a, b) = (
        CompliantTyre.forces(&sand(5e6), &at).unwrap(),
        CompliantTyre.forces(&sand(9e6), &at).unwrap(),
    );
    assert_eq!(a.drawbar_pull.to_bits(), b.drawbar_pull.to_bits());
    assert_eq!(a.angles.unwrap().exit, 0.0);
    // A softer tyre sinks less and pulls more on sand.
    let soft = CompliantTyre.forces(&sand(1e4), &at).unwrap();
    assert!(soft.sinkage.unwrap() < a.sinkage.unwrap());
    assert!(soft.drawbar_pull > a.drawbar_pull);
}

/// Simpson's rule over front and flat, a second method.
#[test]
fn a_second_quadrature_agrees() {
    let simpson = |a: f64, b: f64, f: &dyn Fn(f64) -> f64| {
        let n = 200_000;
        let h = (b - a) / f64::from(n);
        (0..n)
            .map(|k| {
                let x = a + h * f64::from(k);
                (f(x) + 4.0 * f(x + 0.5 * h) + f(x + h)) * h / 6.0
            })
            .sum::<f64>()
    };
    for p in CompliantTyre::typical() {
        for slip in [-0.5, -0.01, 0.0, 0.05, 0.6] {
            let at = Contact::new(slip, 245.25, 0.254, 0.15);
            let w = Wheel::read(&p, &at).unwrap();
            let entry = w.entry(&at).unwrap();
            let (from, _) = w.flat_from(entry);
            let normal = |t: f64| {
                w.stiffness * (w.radius * (t.cos() - entry.cos()).max(0.0)).powf(w.exponent)
            };
            let i = w.slip;
            let e = |j: f64| j.signum() * (1.0 - (-j.abs() / w.modulus).exp());
            let j = |t: f64| 0.254 * ((entry - t) - (1.0 - i) * (entry.sin() - t.sin()));
            let shear = |t: f64| (w.cohesion + normal(t) * w.tan_friction) * e(j(t));
            let length = 2.0 * 0.254 * from.sin();
            let strength = w.cohesion + w.pressure * w.tan_friction;
            let flat = simpson(0.0, length, &|x| strength * e(j(from) + i * x));
            let area = 0.254 * 0.15;
            let load = simpson(from, entry, &|t| normal(t) * t.cos() + shear(t) * t.sin()) * area
                + w.pressure * length * 0.15;
            let pull = simpson(from, entry, &|t| shear(t) * t.cos() - normal(t) * t.sin()) * area
                + flat * 0.15;
            let torque = (simpson(from, entry, &shear) * area + flat * from.cos() * 0.15) * 0.254;
            let f = CompliantTyre.forces(&p, &at).unwrap();
            for (found, by_simpson) in [
                (245.25, load),
                (f.drawbar_pull, pull),
                (f.resistive_torque, torque),
            ] {
                assert!(
                    (found - by_simpson).abs() < 1e-3,
                    "slip {slip}: {found} {by_simpson}"
                );
            }
        }
    }
}

/// The tyre that comes out carries the load that went in, flat or round, driven or braked.
#[test]
fn the_load_is_balanced() {
    let mut compared = 0;
    for p in CompliantTyre::typical() {
        for slip in [-1.0, -0.3, 0.0, 0.05, 0.6, 1.0] {
            for load in [40.0, 245.25, 1000.0] {
                let at = Contact::new(slip, load, 0.254, 0.15);
                let wheel = Wheel::read(&p, &at).unwrap();
                let Ok(entry) = wheel.entry(&at) else {
                    continue;
                };
                let carried = wheel.sums(entry).load;
                assert!((carried / load - 1.0).abs() < 1e-10, "{carried} {load}");
                compared += 1;
            }
        }
    }
    assert!(compared > 40, "{compared}");
}
