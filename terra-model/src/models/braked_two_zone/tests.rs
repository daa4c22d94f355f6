use super::zones::JOIN;
use super::*;
use crate::{ForceLaw, catalogue};

fn sand() -> Vec<f64> {
    catalogue::find("dry_sand")
        .unwrap()
        .parameters(&BrakedTwoZone)
        .unwrap()
}

fn wheel(slip: f64) -> (Wheel<f64>, Contact<f64>) {
    let at = Contact::new(slip, 245.25, 0.254, 0.15);
    (Wheel::read(&sand(), &at).unwrap(), at)
}

/// θ0 solves the published equation; a locked wheel has 45° + φ/2, and none slips at 0.
#[test]
fn the_zones_meet_where_the_paper_says() {
    let phi = sand()[4];
    let chi = std::f64::consts::FRAC_PI_4 - 0.5 * phi;
    for slip in [-0.1, -0.3, -0.7, -1.0] {
        let t = wheel(slip).0.zones.meeting;
        let off = t.cos() - (1.0 + slip) - chi.tan() * t.sin();
        assert!(off.abs() < 1e-12, "{off}");
    }
    let locked = wheel(-1.0).0.zones.meeting;
    assert!((locked - (std::f64::consts::FRAC_PI_4 + 0.5 * phi)).abs() < 1e-12);
    assert!(wheel(0.0).0.zones.meeting.abs() < 1e-12);
}

/// Ahead the shear opposes the rotation, behind it drives it, and between them it is zero.
#[test]
fn shear_changes_its_sign_where_the_zones_meet() {
    let (w, at) = wheel(-0.1);
    let entry = w.entry(&at).unwrap();
    let places = w.zones.places(entry);
    assert!(places.meeting < 0.9 * entry, "{} {entry}", places.meeting);
    let shear = |t: f64| w.stresses(&places, t).1;
    assert!(shear(places.meeting).abs() < 1e-9);
    assert!(shear(0.5 * (entry + places.meeting)) > 0.0);
    assert!(shear(0.3 * places.meeting) < 0.0);
}

/// A driven wheel is that of part I; a braked one joins it without a jump.
#[test]
fn driven_it_is_wong_and_reece() {
    for slip in [0.0, 0.02, 0.3, 0.9] {
        // Its own stresses, which the forces of a driven wheel do not use.
        let (w, at) = wheel(slip);
        let entry = w.entry(&at).unwrap();
        let sums = w.sums(entry);
        let area = 0.254 * 0.15;
        let b = WongReece.forces(&sand(), &at).unwrap();
        let pull = (sums.thrust - sums.compaction) * area;
        assert!((pull - b.drawbar_pull).abs() < 1e-4, "{slip}: {pull}");
        assert!((sums.turning * area * 0.254 - b.resistive_torque).abs() < 1e-4);
        assert!((entry - b.angles.unwrap().entry).abs() < 1e-6);
        let a = BrakedTwoZone.forces(&sand(), &at).unwrap();
        assert_eq!(a.drawbar_pull.to_bits(), b.drawbar_pull.to_bits());
    }
    let pull = |slip| {
        let at = Contact::new(slip, 245.25, 0.254, 0.15);
        BrakedTwoZone.forces(&sand(), &at).unwrap().drawbar_pull
    };
    assert!((pull(-1e-7) - pull(0.0)).abs() < 1e-3);
    assert!((pull(-JOIN + 1e-7) - pull(-JOIN - 1e-7)).abs() < 1e-3);
}

/// The midpoint rule on the same stresses carries the load: a second method.
#[test]
fn a_second_quadrature_agrees() {
    for slip in [-1.0, -0.5, -0.1, -0.03, 0.4] {
        let (w, at) = wheel(slip);
        let entry = w.entry(&at).unwrap();
        let places = w.zones.places(entry);
        let n = 400_000;
        let (mut load, mut torque) = (0.0, 0.0);
        for k in 0..n {
            let angle = entry * (f64::from(k) + 0.5) / f64::from(n);
            let (normal, shear) = w.stresses(&places, angle);
            let area = 0.254 * 0.15 * entry / f64::from(n);
            load += (normal * angle.cos() + shear * angle.sin()) * area;
            torque += shear * area * 0.254;
        }
        let f = BrakedTwoZone.forces(&sand(), &at).unwrap();
        // The shear of a locked wheel jumps where its zones meet, where the midpoint rule is off by half a cell.
        let allowed = if slip == -1.0 { 1e-3 } else { 1e-4 };
        assert!((load - 245.25).abs() < allowed, "slip {slip}: {load}");
        assert!((torque - f.resistive_torque).abs() < allowed, "slip {slip}");
    }
}

/// The wheel that comes out carries the load that went in.
#[test]
fn the_load_is_balanced() {
    for slip in [-1.0, -0.9, -0.3, -0.05, 0.0, 0.05, 0.6, 1.0] {
        for load in [40.0, 245.25, 600.0] {
            let at = Contact::new(slip, load, 0.254, 0.15);
            let wheel = Wheel::read(&sand(), &at).unwrap();
            let carried = wheel.load(wheel.entry(&at).unwrap());
            assert!((carried / load - 1.0).abs() < 1e-10, "{carried} {load}");
        }
    }
}
