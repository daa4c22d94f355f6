//! How exact each way of solving the Wong-Reece wheel is, over 21 soils x 5 slips x 3 loads: largest and median
//! e = max(|Δθ1|/θ1, |ΔT|/|T|, |ΔD|/(|D| + |T|/R)).
//!
//! The reference is a second quadrature that shares nothing with the library: Gauss-Jacobi nodes for the weight u^n and
//! Gauss-Legendre nodes for the rest, on each branch alone, cut where the shear of a braked wheel changes its sign, and a
//! bisected root.

// The errors found are worth reading beside the bounds.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::num::NonZeroUsize;

use gauss_quad::{FiniteAboveNegOneF64, GaussJacobi, GaussLegendre};
use terra_model::models::{Accuracy, WongReece};
use terra_model::{
    Batch, BatchForces, Contact, Dual8, ForceLaw, ForceMap, Lanes, Law, MapRange, ModelError,
    Precision, Registry, TerrainModel, Vector, catalogue, jacobian,
};

const R: f64 = 0.254;
const B: f64 = 0.15;
const SLIPS: [f64; 5] = [0.05, 0.2, 0.4, 0.7, 0.95];
const LOADS: [f64; 3] = [100.0, 245.25, 600.0];

/// θ1, D, T.
type Three = [f64; 3];

/// Nodes and weights on [0, 1].
fn unit(pairs: impl Iterator<Item = (f64, f64)>, scale: f64) -> Vec<(f64, f64)> {
    pairs.map(|(x, w)| (0.5 * (1.0 + x), w * scale)).collect()
}

struct Quadrature {
    power: Vec<(f64, f64)>,
    plain: Vec<(f64, f64)>,
}

impl Quadrature {
    fn new(n: f64) -> Self {
        let degree = NonZeroUsize::new(40).unwrap();
        let exponent = |x: f64| FiniteAboveNegOneF64::new(x).unwrap();
        let jacobi = GaussJacobi::new(degree, exponent(0.0), exponent(n));
        let legendre = GaussLegendre::new(degree);
        Quadrature {
            power: unit(
                jacobi.as_node_weight_pairs().iter().copied(),
                0.5_f64.powf(n + 1.0),
            ),
            plain: unit(legendre.as_node_weight_pairs().iter().copied(), 0.5),
        }
    }

    /// W, D, T at an entry angle by equations 13-20 as they are written.
    fn forces(&self, p: &[f64], i: f64, entry: f64) -> Three {
        let &[k_c, k_phi, n, c, phi, modulus, c1, c2] = p else {
            panic!("eight parameters")
        };
        let k = k_c / B + k_phi;
        // Braking would take the apex behind the bottom, where it is held at 2 % of the contact.
        let apex = (c1 + c2 * i).max(0.02) * entry;
        let strain = |angle: f64| {
            // (θ1 - θ) - (1 - i)(sin θ1 - sin θ), the sines by their product.
            let sines = 2.0 * (0.5 * (entry + angle)).cos() * (0.5 * (entry - angle)).sin();
            let j = R * ((entry - angle) - (1.0 - i) * sines);
            -j.signum() * (-j.abs() / modulus).exp_m1()
        };
        let mut total = [0.0; 3];
        let mut add = |normal: f64, shear: f64, angle: f64| {
            let (sin, cos) = angle.sin_cos();
            total[0] += R * B * (normal * cos + shear * sin);
            total[1] += R * B * (shear * cos - normal * sin);
            total[2] += R * R * B * shear;
        };
        // (θ1 - θ) = (1 - i)(sin θ1 - sin θ) has a place beside the entry where a braked rim turns from sliding back to
        // sliding forward.
        let turn = (i < 0.0).then(|| {
            let ahead = |t: f64| (entry - t) - (1.0 - i) * (entry.sin() - t.sin());
            bisect(0.0, entry * (1.0 - 1e-9), ahead)
        });
        for (length, start, towards) in [(entry - apex, entry, -1.0), (apex, 0.0, 1.0)] {
            let angle = |u: f64| start + towards * u * length;
            // σ at u over u^n, which is smooth.
            let smooth = |u: f64| {
                let front = entry - u * (entry - apex);
                let drop = 2.0 * (0.5 * (entry + front)).sin() * (0.5 * (entry - front)).sin() / u;
                k * (R * drop).powf(n)
            };
            // A braked wheel shears in a thin layer beside the entry.
            let mut cuts = if i < 0.0 {
                vec![0.02, 0.2, 1.0]
            } else {
                vec![1.0]
            };
            let turned = turn.flatten().map(|t| (t - start) * towards / length);
            cuts.extend(turned.filter(|u| (0.0..1.0).contains(u)));
            cuts.sort_by(f64::total_cmp);
            let first = cuts[0];
            for &(x, w) in &self.power {
                let (u, w) = (x * first, w * first.powf(n + 1.0) * length);
                let sigma = smooth(u) * w;
                add(sigma, sigma * phi.tan() * strain(angle(u)), angle(u));
            }
            for &(x, w) in &self.plain {
                let u = x * first;
                add(0.0, c * w * first * length * strain(angle(u)), angle(u));
                for ends in cuts.windows(2) {
                    let panel = ends[1] - ends[0];
                    let (u, w) = (ends[0] + x * panel, w * panel * length);
                    let sigma = smooth(u) * u.powf(n) * w;
                    add(
                        sigma,
                        (c * w + sigma * phi.tan()) * strain(angle(u)),
                        angle(u),
                    );
                }
            }
        }
        total
    }

    /// θ1, D, T; none without an equilibrium.
    fn solve(&self, p: &[f64], i: f64, load: f64) -> Option<Three> {
        let (mut low, mut high) = (1e-6_f64.ln(), std::f64::consts::FRAC_PI_2.ln());
        if self.forces(p, i, high.exp())[0] < load {
            return None;
        }
        for _ in 0..56 {
            let middle = 0.5 * (low + high);
            if self.forces(p, i, middle.exp())[0] < load {
                low = middle;
            } else {
                high = middle;
            }
        }
        let entry = (0.5 * (low + high)).exp();
        let [_, pull, torque] = self.forces(p, i, entry);
        Some([entry, pull, torque])
    }
}

/// Where `f` changes its sign between two places.
fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    let at_low = f(low) < 0.0;
    if (f(high) < 0.0) == at_low {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (f(middle) < 0.0) == at_low {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

struct Case {
    p: Vec<f64>,
    slip: f64,
    load: f64,
    expected: Option<Three>,
}

fn law() -> Law {
    Registry::builtin().law("wong-reece").unwrap()
}

fn the_box() -> Vec<Case> {
    let (law, mut cases) = (law(), vec![]);
    for soil in catalogue::set("wong21").unwrap() {
        let p = soil.parameters(law.model()).unwrap();
        let quadrature = Quadrature::new(p[2]);
        for slip in SLIPS {
            for load in LOADS {
                let expected = quadrature.solve(&p, slip, load);
                cases.push(Case {
                    p: p.clone(),
                    slip,
                    load,
                    expected,
                });
            }
        }
    }
    assert_eq!(cases.len(), 315);
    cases
}

fn error([entry, pull, torque]: Three, [e, d, t]: Three) -> f64 {
    let pull_scale = d.abs() + t.abs() / R;
    ((entry - e) / e)
        .abs()
        .max(((torque - t) / t).abs())
        .max((pull - d).abs() / pull_scale)
}

/// Largest and median error of `solve` where there is an equilibrium; elsewhere it must say so.
fn errors(
    name: &str,
    cases: &[Case],
    mut solve: impl FnMut(usize, &Case) -> Result<Three, ModelError>,
) -> (f64, f64) {
    let mut errors = vec![];
    for (item, case) in cases.iter().enumerate() {
        match (solve(item, case), case.expected) {
            (Ok(found), Some(expected)) => errors.push(error(found, expected)),
            (Err(ModelError::NoEquilibrium { load, max_load }), None) => {
                assert!(load == case.load && max_load < load);
            }
            (found, expected) => panic!("{name}: {found:?}, expected {expected:?}"),
        }
    }
    assert!(errors.len() > 290, "{}", errors.len());
    errors.sort_by(f64::total_cmp);
    let (max, median) = (errors[errors.len() - 1], errors[errors.len() / 2]);
    println!(
        "{name}: {} of 315, max {max:.1e}, median {median:.1e}",
        errors.len()
    );
    (max, median)
}

#[test]
fn each_tier_keeps_its_bound() {
    let cases = the_box();
    for (accuracy, most, half) in [
        (Accuracy::Reference, 1e-12, 1e-13),
        (Accuracy::Fine, 1e-11, 1e-13),
        (Accuracy::Default, 1e-7, 1e-10),
    ] {
        let (max, median) = errors(&format!("{accuracy:?}"), &cases, |_, case| {
            let at = Contact::new(case.slip, case.load, R, B);
            let f = WongReece.forces_within(&case.p, &at, accuracy)?;
            Ok([f.angles.unwrap().entry, f.drawbar_pull, f.resistive_torque])
        });
        assert!(
            max <= most && median <= half,
            "{accuracy:?}: {max} {median}"
        );
    }
}

/// Braking, where the shear changes its sign on the way, each tier keeps its bound too. The load of a braked wheel need
/// not rise, so the second root is sought within a millionth of the first.
#[test]
fn each_tier_keeps_its_bound_when_braked() {
    let law = law();
    for (accuracy, most) in [
        (Accuracy::Reference, 1e-12),
        (Accuracy::Fine, 1e-11),
        (Accuracy::Default, 1e-7),
    ] {
        let (mut worst, mut compared) = (0.0_f64, 0);
        for soil in catalogue::set("wong21").unwrap() {
            let p = soil.parameters(law.model()).unwrap();
            let quadrature = Quadrature::new(p[2]);
            for slip in [-0.02, -0.05, -0.2, -0.4, -0.7, -0.95] {
                for load in LOADS {
                    let at = Contact::new(slip, load, R, B);
                    let Ok(f) = WongReece.forces_within(&p, &at, accuracy) else {
                        continue;
                    };
                    let entry = f.angles.unwrap().entry;
                    let i = 1.0 - 1.0 / (1.0 + slip);
                    let off = |t: f64| quadrature.forces(&p, i, t)[0] - load;
                    let near = bisect(entry * (1.0 - 1e-6), entry * (1.0 + 1e-6), off);
                    let own = near.unwrap_or_else(|| panic!("{} {slip} {load}", soil.id));
                    let [_, pull, torque] = quadrature.forces(&p, i, own);
                    // As `error`, but here it is the torque that passes through zero, at the towed slip.
                    let scale = pull.abs() + torque.abs() / R;
                    worst = worst
                        .max(((entry - own) / own).abs())
                        .max((f.drawbar_pull - pull).abs() / scale)
                        .max((f.resistive_torque - torque).abs() / (R * scale));
                    compared += 1;
                }
            }
        }
        println!("{accuracy:?}, braked: {compared} contacts, worst {worst:.1e}");
        assert!(
            compared > 300 && worst <= most,
            "{accuracy:?}: {compared} {worst}"
        );
    }
}

#[test]
fn the_law_is_of_the_fine_tier() {
    let law = law();
    let (max, _) = errors("wong-reece", &the_box(), |_, case| {
        let f = law.forces(&case.p, &Contact::new(case.slip, case.load, R, B))?;
        Ok([f.angles.unwrap().entry, f.drawbar_pull, f.resistive_torque])
    });
    assert!(max <= 1e-11, "{max}");
}

/// What fits are made with, contacts side by side: driven to a part in a hundred thousand, braked in ten thousand. Data know
/// forces to one in a hundred.
#[test]
fn the_quick_law_is_as_exact_as_fits_need() {
    let (law, quick) = (law(), law().quick());
    let found = |case: &Case, slip: f64| -> Result<Three, ModelError> {
        let p: Vec<Lanes> = case.p.iter().map(|&v| Lanes::from(v)).collect();
        let at = Contact::new(slip, case.load, R, B).lift();
        let f = quick.forces_at(&p, &at)?;
        let three = [f.angles.unwrap().entry, f.drawbar_pull, f.resistive_torque];
        Ok(three.map(|x| x.lane(7)))
    };
    let (max, _) = errors("quick", &the_box(), |_, case| found(case, case.slip));
    assert!(1e-11 < max && max <= 1e-5, "{max}");
    let mut compared = 0;
    for case in the_box() {
        let at = Contact::new(-case.slip, case.load, R, B);
        if let (Ok(found), Ok(f)) = (found(&case, at.slip), law.forces(&case.p, &at)) {
            // Here it is the torque that passes through zero, at the towed slip.
            let scale = f.drawbar_pull.abs() + f.resistive_torque.abs() / R;
            let entry = f.angles.unwrap().entry;
            let e = ((found[0] - entry) / entry).abs();
            let e = e.max((found[1] - f.drawbar_pull).abs() / scale);
            let e = e.max((found[2] - f.resistive_torque).abs() / (R * scale));
            assert!(e <= 1e-4, "{e} at slip {}, load {}", at.slip, case.load);
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared}");
}

/// The same contact, started from the entry angle of another.
#[test]
fn a_warm_start_changes_nothing() {
    let law = law();
    for case in the_box() {
        let at = Contact::new(case.slip, case.load, R, B);
        let Ok(cold) = law.forces(&case.p, &at) else {
            continue;
        };
        let entry = cold.angles.unwrap().entry;
        for factor in [0.3, 0.97, 1.0, 1.02, 2.0] {
            let start = (entry * factor).min(1.5);
            let warm = WongReece.forces_from(&case.p, &at, start).unwrap();
            let three = |f: &terra_model::WheelForces<f64>| {
                [f.angles.unwrap().entry, f.drawbar_pull, f.resistive_torque]
            };
            let e = error(three(&warm), three(&cold));
            assert!(e < 1e-11, "{e} from {factor} at slip {}", case.slip);
        }
    }
}

#[test]
fn a_batch_keeps_its_bound_and_tells_each_item_its_own_fault() {
    let cases = the_box();
    let columns: Vec<Vec<f64>> = (0..8)
        .map(|k| cases.iter().map(|c| c.p[k]).collect())
        .collect();
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let slip: Vec<f64> = cases.iter().map(|c| c.slip).collect();
    let normal_load: Vec<f64> = cases.iter().map(|c| c.load).collect();
    let batch = Batch {
        parameters: &columns,
        slip: &slip,
        normal_load: &normal_load,
        radius: R,
        width: B,
    };
    for (precision, most, half) in [
        (Precision::Double, 1e-7, 1e-10),
        (Precision::Single, 1e-5, 1e-6),
    ] {
        let mut out = BatchForces::default();
        law().solve_batch(&batch, precision, &mut out).unwrap();
        let (max, median) = errors(&format!("batch {precision:?}"), &cases, |item, _| {
            out.status[item].clone().map(|_| {
                [
                    out.entry_angle[item],
                    out.drawbar_pull[item],
                    out.resistive_torque[item],
                ]
            })
        });
        assert!(
            max <= most && median <= half,
            "{precision:?}: {max} {median}"
        );
    }
}

/// Outside the box: heavy loads, and shear moduli down to a fiftieth, at which the shear stress is all in a thin layer at
/// the entry. No rule in one piece resolves that, and a batch must notice.
#[test]
fn a_batch_keeps_its_bound_however_steep_the_shear() {
    let law = law();
    let mut columns = vec![vec![]; 8];
    let (mut slip, mut normal_load, mut expected) = (vec![], vec![], vec![]);
    for soil in catalogue::set("wong21").unwrap() {
        for s in [0.02, 0.3, 0.7, 1.0] {
            for w in [60.0, 600.0, 2452.5] {
                for (share, exponent) in [1.0, 0.6, 0.35, 0.2, 0.1, 0.02]
                    .map(|share| [(share, None), (share, Some(1.0))])
                    .concat()
                {
                    let mut p = soil.parameters(law.model()).unwrap();
                    p[5] *= share;
                    p[2] = exponent.unwrap_or(p[2]);
                    let at = Contact::new(s, w, R, B);
                    let Ok(f) = WongReece.forces_within(&p, &at, Accuracy::Reference) else {
                        continue;
                    };
                    for (column, value) in columns.iter_mut().zip(p) {
                        column.push(value);
                    }
                    slip.push(s);
                    normal_load.push(w);
                    expected.push([f.angles.unwrap().entry, f.drawbar_pull, f.resistive_torque]);
                }
            }
        }
    }
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let batch = Batch {
        parameters: &columns,
        slip: &slip,
        normal_load: &normal_load,
        radius: R,
        width: B,
    };
    for (precision, most) in [(Precision::Double, 1e-7), (Precision::Single, 1e-5)] {
        let mut out = BatchForces::default();
        law.solve_batch(&batch, precision, &mut out).unwrap();
        let mut worst = 0.0_f64;
        for (item, &expected) in expected.iter().enumerate() {
            assert!(out.status[item].is_ok(), "item {item}");
            let found = [
                out.entry_angle[item],
                out.drawbar_pull[item],
                out.resistive_torque[item],
            ];
            worst = worst.max(error(found, expected));
        }
        println!("batch {precision:?}, {} contacts: {worst:.1e}", slip.len());
        assert!(worst <= most, "{precision:?}: {worst}");
    }
}

/// Illegal, braking and infeasible items among good ones, and batches that do not fill a lane.
#[test]
fn an_item_answers_as_it_would_alone() {
    let law = law();
    let soil = |id: &str| {
        catalogue::find(id)
            .unwrap()
            .parameters(law.model())
            .unwrap()
    };
    let sand = soil("dry_sand");
    let mut bad = sand.clone();
    bad[2] = -1.0;
    let mut broken = sand.clone();
    broken[5] = f64::NAN;
    let snow = soil("snow_sweden");
    let items: Vec<(&[f64], f64, f64)> = vec![
        (&sand, 0.2, 245.25),
        (&snow, 0.4, 1e5),
        (&bad, 0.2, 245.25),
        (&sand, -0.3, 245.25),
        (&broken, 0.2, 245.25),
        (&sand, f64::NAN, 245.25),
        (&sand, 1.5, 245.25),
        (&snow, 0.1, 100.0),
        (&sand, 0.0, 245.25),
        (&sand, 1.0, 245.25),
        (&sand, 0.3, -5.0),
        (&sand, 0.3, f64::INFINITY),
        (&sand, 0.9, 2452.5),
        (&sand, -1.0, 245.25),
        (&sand, 0.25, 300.0),
        (&sand, 0.25, 1e-3),
        (&sand, 0.26, 301.0),
    ];
    for count in [1, 7, 8, 9, 16, items.len()] {
        let items = &items[..count];
        let columns: Vec<Vec<f64>> = (0..8)
            .map(|k| items.iter().map(|(p, ..)| p[k]).collect())
            .collect();
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let slip: Vec<f64> = items.iter().map(|i| i.1).collect();
        let normal_load: Vec<f64> = items.iter().map(|i| i.2).collect();
        let batch = Batch {
            parameters: &columns,
            slip: &slip,
            normal_load: &normal_load,
            radius: R,
            width: B,
        };
        for (precision, tolerance) in [(Precision::Double, 1e-7), (Precision::Single, 1e-4)] {
            let mut out = BatchForces::default();
            law.solve_batch(&batch, precision, &mut out).unwrap();
            assert_eq!(out.status.len(), count);
            for (item, &(p, slip, load)) in items.iter().enumerate() {
                match law.forces(p, &Contact::new(slip, load, R, B)) {
                    Ok(f) => {
                        assert_eq!(out.status[item], Ok(f.flags), "item {item}");
                        let scale = f.drawbar_pull.abs() + f.resistive_torque.abs() / R;
                        let pull = (out.drawbar_pull[item] - f.drawbar_pull).abs() / scale;
                        let sinkage = out.sinkage[item] / f.sinkage.unwrap() - 1.0;
                        assert!(pull < tolerance && sinkage.abs() < tolerance, "item {item}");
                    }
                    Err(e) => {
                        // NaN is not equal to itself, so by what it says.
                        let said = out.status[item].clone().unwrap_err();
                        assert_eq!(said.to_string(), e.to_string(), "item {item}");
                        assert!(out.drawbar_pull[item].is_nan());
                    }
                }
            }
        }
    }
    let shared: &[f64] = &[1.0];
    let batch = Batch {
        parameters: &[shared; 8],
        slip: &[0.1, 0.2],
        normal_load: &[1.0],
        radius: R,
        width: B,
    };
    let wrong = law.solve_batch(&batch, Precision::Double, &mut BatchForces::default());
    assert_eq!(
        wrong,
        Err(ModelError::BatchLength {
            expected: 2,
            found: 1
        })
    );
}

/// Over slips .02 to 1 and loads 60 to 600 N every soil's map is right to 1e-4, and says where it ends.
#[test]
fn maps_are_right_to_their_bound_and_end_at_the_bearing_limit() {
    let law = law();
    let range = MapRange {
        slip: (0.02, 1.0),
        normal_load: (60.0, 600.0),
    };
    let mut limited = 0;
    for soil in catalogue::set("wong21").unwrap() {
        let p = soil.parameters(law.model()).unwrap();
        let map = ForceMap::within(&law, &p, range, R, B, 1e-4).unwrap();
        println!("{}: {:?}", soil.id, map.error());
        let mut worst = 0.0_f64;
        for a in 0..23 {
            let slip = 0.02 + 0.98 * f64::from(a) / 22.0;
            for b in 0..17 {
                let load = 60.0 * 10_f64.powf(f64::from(b) / 16.0).min(10.0);
                let at = Contact::new(slip, load, R, B);
                match (map.forces(slip, load), law.forces(&p, &at)) {
                    (Ok([pull, torque]), Ok(f)) => {
                        let entry = f.angles.unwrap().entry;
                        let expected = [entry, f.drawbar_pull, f.resistive_torque];
                        worst = worst.max(error([entry, pull, torque], expected));
                    }
                    // Refused by the map only within half a percent of the limit.
                    (Err(ModelError::OutsideMap { high, .. }), Ok(_)) => {
                        assert!(load > high && high < 600.0, "{slip} {load} {high}");
                        let beyond = Contact::new(slip, high / 0.99, R, B);
                        assert!(law.forces(&p, &beyond).is_err(), "{slip} {load} {high}");
                    }
                    (Err(_), Err(ModelError::NoEquilibrium { .. })) => limited += 1,
                    (found, expected) => panic!("{}: {found:?} {expected:?}", soil.id),
                }
            }
        }
        // The bound was measured at other points than these.
        println!("{}: {worst:.1e} at points of this test", soil.id);
        assert!(worst <= 1e-4, "{}: {worst:.1e}", soil.id);
        for (slip, load) in [(0.01, 100.0), (0.5, 59.0), (1.1, 100.0), (f64::NAN, 100.0)] {
            let said = map.forces(slip, load);
            assert!(
                matches!(said, Err(ModelError::OutsideMap { .. })),
                "{said:?}"
            );
        }
    }
    assert!(limited > 10, "{limited}");
}

/// Slopes of a map against differences of its own values, with and without a bearing limit in it.
#[test]
fn slopes_of_a_map_are_those_of_its_values() {
    let law = law();
    let range = MapRange {
        slip: (0.02, 1.0),
        normal_load: (60.0, 600.0),
    };
    for id in ["dry_sand", "snow_us_harrison_1", "lean_clay_22"] {
        let soil = catalogue::find(id).unwrap();
        let p = soil.parameters(law.model()).unwrap();
        let map = ForceMap::within(&law, &p, range, R, B, 1e-4).unwrap();
        for (slip, load) in [(0.1, 100.0), (0.3, 180.0), (0.55, 90.0)] {
            let found = map.slopes(slip, load).unwrap();
            let (hs, hw) = (1e-5, 1e-5 * load);
            let value = |s, w| map.forces(s, w).unwrap();
            for k in 0..2 {
                let by_slip = (value(slip + hs, load)[k] - value(slip - hs, load)[k]) / (2.0 * hs);
                let by_load = (value(slip, load + hw)[k] - value(slip, load - hw)[k]) / (2.0 * hw);
                let scale = load * if k == 0 { 1.0 } else { R };
                assert!((found.forces[k] - value(slip, load)[k]).abs() < 1e-13 * scale);
                assert!((found.by_slip[k] - by_slip).abs() < 1e-6 * scale, "{id}");
                assert!(
                    (found.by_load[k] - by_load).abs() < 1e-6 * scale / load,
                    "{id}"
                );
            }
        }
    }
}

/// The Jacobian by formula against dual numbers carried through the same solve, driving and braking, hooks included.
#[test]
fn the_jacobian_by_formula_is_that_of_dual_numbers() {
    let law = law();
    let mut worst = 0.0_f64;
    for (id, slip, load) in [
        ("dry_sand", 0.3, 245.25),
        ("dry_sand", -0.3, 245.25),
        ("lean_clay_22", 0.05, 2452.5),
        ("lean_clay_22", -0.9, 600.0),
        ("upland_sandy_loam", 1.0, 600.0),
        ("snow_sweden", 0.6, 100.0),
    ] {
        let p = catalogue::find(id)
            .unwrap()
            .parameters(law.model())
            .unwrap();
        for hooked in [false, true] {
            let mut at = Contact::new(slip, load, R, B);
            if hooked {
                (at.hooks.exit_ratio, at.hooks.lug_height) = (0.2, 0.01);
                (at.hooks.shear_hump, at.hooks.contact_radius) = (0.3, 1.1);
                (at.hooks.layer_depth, at.hooks.layer_stiffness) = (0.003, 1e5);
                (at.hooks.friction, at.hooks.shear_modulus) = (0.8, 1.3);
            }
            let (_, found) = law.jacobian(&p, &at).unwrap();
            let mut x = p.clone();
            x.extend([slip, load]);
            let (_, expected) = jacobian(&x, |x: &[Dual8]| {
                let mut there = at.lift::<Dual8>();
                (there.slip, there.normal_load) = (x[8], x[9]);
                WongReece
                    .wheel_forces(&x[..8], &there)
                    .map(|f| vec![f.drawbar_pull, f.resistive_torque, f.sinkage.unwrap()])
            })
            .unwrap();
            for row in 0..3 {
                for (column, x) in x.iter().enumerate() {
                    let scale = load * if row == 0 { 1.0 } else { R } / x.abs();
                    let e = (found[(row, column)] - expected[(row, column)]).abs() / scale;
                    assert!(e < 1e-11, "{id} {slip} {row} {column}: {e:.1e}");
                    worst = worst.max(e);
                }
            }
        }
    }
    println!("formula against duals: {worst:.1e}");
}

/// Every model, with and without effects: a batch gives what single calls give, each item its own answer, whatever stands
/// beside it (a wheel that brakes, one that sinks deep, one without a load, one too heavy).
#[test]
fn a_batch_of_any_law_is_its_single_calls() {
    let registry = Registry::builtin();
    let soil = [
        ("k_c", 990.0),
        ("k_phi", 1.528e6),
        ("sinkage_exponent", 1.1),
        ("cohesion", 1040.0),
        ("friction_angle", 0.49),
        ("shear_modulus", 0.025),
        ("c1", 0.18),
        ("c2", 0.32),
    ];
    let slips: Vec<f64> = (0..61).map(|k| f64::from(k) * 0.02 - 0.3).collect();
    let mut loads: Vec<f64> = (0..61).map(|k| 150.0 + 5.0 * f64::from(k)).collect();
    (loads[7], loads[30], loads[44]) = (-1.0, 40_000.0, 3e6);
    for (name, effects) in [
        ("linear-stress", &[][..]),
        ("scm-column", &[]),
        ("bekker-compaction", &[]),
        ("wong-reece:slip-exponent", &[]),
        ("wong-reece", &["slip-sinkage", "bulldozing"]),
        ("wong-reece", &["wheel-radius-error"]),
    ] {
        let law = registry.law(name).unwrap();
        let plain = law.params().len();
        let effects = effects.iter().map(|e| registry.effect(e).unwrap());
        let law = law.with_effects(effects).unwrap();
        let p: Vec<f64> = law
            .params()
            .iter()
            .enumerate()
            .map(|(k, p)| {
                let known = soil.iter().find(|(n, _)| *n == p.name);
                known.map_or(if k < plain { 0.2 } else { 0.05 }, |(_, v)| *v)
            })
            .collect();
        let columns: Vec<&[f64]> = p.iter().map(std::slice::from_ref).collect();
        let batch = Batch {
            parameters: &columns,
            slip: &slips,
            normal_load: &loads,
            radius: 0.25,
            width: 0.15,
        };
        let mut out = BatchForces::default();
        law.solve_batch(&batch, Precision::Double, &mut out)
            .unwrap();
        let mut answers = 0;
        for (k, status) in out.status.iter().enumerate() {
            let at = Contact::new(slips[k], loads[k], 0.25, 0.15);
            match (law.forces(&p, &at), status) {
                (Ok(f), Ok(flags)) => {
                    assert_eq!(f.flags, *flags, "{name} {k}");
                    for (a, b) in [
                        (f.drawbar_pull, out.drawbar_pull[k]),
                        (f.resistive_torque, out.resistive_torque[k]),
                        (
                            f.sinkage.unwrap_or(0.0),
                            if f.sinkage.is_some() {
                                out.sinkage[k]
                            } else {
                                0.0
                            },
                        ),
                    ] {
                        assert!(
                            (a - b).abs() < 1e-7 * (loads[k].abs() + a.abs()),
                            "{name} {k}: {a} {b}"
                        );
                    }
                    answers += 1;
                }
                (Err(a), Err(b)) => assert_eq!(a.to_string(), b.to_string(), "{name} {k}"),
                (a, b) => panic!("{name} {k}: {a:?} {b:?}"),
            }
        }
        assert!(answers > 50, "{name}: {answers}");
    }
}
