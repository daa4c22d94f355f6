//! The stress integrals by a second method: adaptive Gauss-Kronrod quadrature of equations 13-20 as they are written,
//! in the angle, with nothing shared with the library but the parameters.

use terra::model::{Contact, ForceLaw, Registry, WheelForces, catalogue};

/// Seven-point Gauss inside a fifteen-point Kronrod rule: node, Kronrod weight, Gauss weight.
const KRONROD: [(f64, f64, f64); 8] = [
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0),
    (
        0.949_107_912_342_758_5,
        0.063_092_092_629_978_55,
        0.129_484_966_168_869_7,
    ),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_19, 0.0),
    (
        0.741_531_185_599_394_4,
        0.140_653_259_715_525_92,
        0.279_705_391_489_276_64,
    ),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (
        0.405_845_151_377_397_2,
        0.190_350_578_064_785_4,
        0.381_830_050_505_118_9,
    ),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_89, 0.0),
    (0.0, 0.209_482_141_084_727_82, 0.417_959_183_673_469_4),
];

/// Load, pull, torque and side force.
type Four = [f64; 4];

fn adaptive(f: &dyn Fn(f64) -> Four, a: f64, b: f64, tolerance: f64, depth: u32) -> Four {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let (mut fine, mut coarse) = ([0.0; 4], [0.0; 4]);
    for (x, wk, wg) in KRONROD {
        for sign in if x == 0.0 {
            &[1.0][..]
        } else {
            &[-1.0, 1.0][..]
        } {
            let value = f(middle + sign * half * x);
            for k in 0..4 {
                fine[k] += wk * half * value[k];
                coarse[k] += wg * half * value[k];
            }
        }
    }
    let error = (0..4)
        .map(|k| (fine[k] - coarse[k]).abs())
        .fold(0.0, f64::max);
    if error <= tolerance || depth == 0 {
        return fine;
    }
    let left = adaptive(f, a, middle, tolerance, depth - 1);
    let right = adaptive(f, middle, b, tolerance, depth - 1);
    std::array::from_fn(|k| left[k] + right[k])
}

/// W, D, ∫τ and F_y by the book, for the entry angle that the library found.
fn by_the_book(p: &[f64], at: &Contact<f64>, entry: f64) -> Four {
    let &[k_c, k_phi, n, c, phi, shear_modulus, c1, c2] = p else {
        panic!("eight parameters")
    };
    let h = &at.hooks;
    let k = (k_c / at.width + k_phi) * h.stiffness;
    let n = n + h.sinkage_exponent;
    let (radius, tips) = (
        at.radius * h.contact_radius,
        at.radius * h.contact_radius + h.lug_height,
    );
    let locked = at.slip == -1.0;
    let i = if at.slip < 0.0 {
        at.slip / (1.0 + at.slip)
    } else {
        at.slip
    };
    let ratio = if locked {
        0.02
    } else if at.slip < 0.0 {
        (c1 + c2 * i).clamp(0.02, 0.98)
    } else {
        c1 + c2 * i
    };
    let (apex, exit) = (ratio * entry, -h.exit_ratio * entry);
    let sigma = |angle: f64| {
        let front = if angle >= apex {
            angle
        } else {
            entry - (angle - exit) * (entry - apex) / (apex - exit)
        };
        let z = radius * (front.cos() - entry.cos()).max(0.0);
        k * z.powf(n)
            + if h.layer_depth > 0.0 {
                h.layer_stiffness * (z - h.layer_depth).max(0.0)
            } else {
                0.0
            }
    };
    let jx = |angle: f64| tips * ((entry - angle) - (1.0 - i) * (entry.sin() - angle.sin()));
    let shear = |angle: f64| -> (f64, f64) {
        if locked {
            return (-1.0, 0.0);
        }
        let x = jx(angle);
        let y = h
            .lateral_slip
            .map_or(0.0, |tan| tips * (1.0 - i) * (entry - angle) * tan);
        let j = x.hypot(y);
        let r = j / (shear_modulus * h.shear_modulus);
        let e = (1.0 - (-r).exp()) * (1.0 + h.shear_hump * r * (1.0 - r).exp());
        if j == 0.0 {
            (0.0, 0.0)
        } else {
            (e * x / j, e * y / j)
        }
    };
    let point = |angle: f64| -> Four {
        let s = sigma(angle);
        let strength = c * h.cohesion + s * phi.tan() * h.friction;
        let (ex, ey) = shear(angle);
        let (sin, cos) = angle.sin_cos();
        let tau = strength * ex;
        [
            s * cos + tau * sin,
            tau * cos - s * sin,
            tau,
            -strength * ey,
        ]
    };
    // Break where the integrand has a corner: the apex, each zero of j, the top of the layer.
    let mut breaks = vec![exit, apex, entry];
    let mut corner = |g: &dyn Fn(f64) -> f64| {
        let steps = 4000;
        let x = |q: usize| exit + (entry - exit) * q as f64 / steps as f64;
        for q in 0..steps - 1 {
            let (mut low, mut high) = (x(q), x(q + 1));
            if g(low) * g(high) < 0.0 {
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if g(low) * g(middle) <= 0.0 {
                        high = middle
                    } else {
                        low = middle
                    }
                }
                breaks.push(low);
            }
        }
    };
    corner(&jx);
    if h.layer_depth > 0.0 {
        let z = |angle: f64| {
            let front = if angle >= apex {
                angle
            } else {
                entry - (angle - exit) * (entry - apex) / (apex - exit)
            };
            radius * (front.cos() - entry.cos()) - h.layer_depth
        };
        corner(&z);
    }
    breaks.sort_by(f64::total_cmp);
    let mut total = [0.0; 4];
    for pair in breaks.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        if b <= a {
            continue;
        }
        // θ = a + (b - a) t³ (6 t² - 15 t + 10): flat at both ends, so that neither z^n nor a layer of E is singular.
        let smooth = |t: f64| {
            let angle = a + (b - a) * t * t * t * (10.0 - t * (15.0 - 6.0 * t));
            let jacobian = (b - a) * 30.0 * (t * (1.0 - t)).powi(2);
            point(angle).map(|v| v * jacobian)
        };
        let part = adaptive(
            &smooth,
            0.0,
            1.0,
            1e-12 * at.normal_load / (at.radius * at.width),
            40,
        );
        for k in 0..4 {
            total[k] += part[k];
        }
    }
    let area = radius * at.width;
    let arm = at.radius + h.lug_height;
    [
        total[0] * area,
        total[1] * area,
        total[2] * area * arm,
        total[3] * area,
    ]
}

/// Largest relative difference of load, pull, torque and side force.
fn difference(p: &[f64], at: &Contact<f64>, f: &WheelForces<f64>) -> f64 {
    let [load, pull, torque, side] = by_the_book(p, at, f.angles.unwrap().entry);
    let scale = f.drawbar_pull.abs() + f.resistive_torque.abs() / at.radius;
    ((load - at.normal_load).abs() / at.normal_load)
        .max((pull - f.drawbar_pull).abs() / scale)
        .max((torque - f.resistive_torque).abs() / (scale * at.radius))
        .max((side - f.lateral_force).abs() / scale)
}

const SLIPS: [f64; 14] = [
    -1.0, -0.99, -0.9, -0.6, -0.3, -0.1, -0.02, 0.0, 0.02, 0.1, 0.3, 0.6, 0.95, 1.0,
];

fn check(name: &str, tolerance: f64, change: impl Fn(&mut Vec<f64>, &mut Contact<f64>)) {
    let law = Registry::builtin().law("wong-reece").unwrap();
    let (mut worst, mut at_worst, mut count) = (0.0, String::new(), 0);
    for id in [
        "dry_sand",
        "upland_sandy_loam",
        "lean_clay_22",
        "clayey_38",
        "snow_sweden",
        "grenville",
    ] {
        for load in [60.0, 245.25, 1000.0] {
            for slip in SLIPS {
                let mut p = catalogue::find(id)
                    .unwrap()
                    .parameters(law.model())
                    .unwrap();
                let mut at = Contact::new(slip, load, 0.254, 0.15);
                change(&mut p, &mut at);
                let Ok(f) = law.forces(&p, &at) else { continue };
                let error = difference(&p, &at, &f);
                count += 1;
                assert!(error.is_finite(), "{name}: {id}, {load} N, slip {slip}");
                if error > worst {
                    (worst, at_worst) = (error, format!("{id}, {load} N, slip {slip}"));
                }
            }
        }
    }
    println!("{name}: {count} contacts, max {worst:.1e} ({at_worst})");
    assert!(
        count > 150,
        "{name}: only {count} contacts have an equilibrium"
    );
    assert!(worst < tolerance, "{name}: {worst:.1e} at {at_worst}");
}

#[test]
fn nominal_contacts() {
    check("nominal", 1e-9, |_, _| {});
}

#[test]
fn contacts_behind_the_axle() {
    check("exit ratio .35", 1e-9, |_, at| at.hooks.exit_ratio = 0.35);
    check("exit ratio .9", 1e-8, |_, at| at.hooks.exit_ratio = 0.9);
}

#[test]
fn lugs_humps_and_a_flat_tyre() {
    check("lugs", 1e-9, |_, at| at.hooks.lug_height = 0.015);
    check("hump", 1e-8, |_, at| at.hooks.shear_hump = 0.6);
    check("larger contact radius", 1e-9, |_, at| {
        at.hooks.contact_radius = 1.3
    });
}

#[test]
fn layers_and_sideways_slip() {
    check("layer", 1e-9, |p, at| {
        at.hooks.layer_depth = 0.01;
        at.hooks.layer_stiffness = 2.0 * (p[0] / at.width + p[1]) * 0.01_f64.powf(p[2] - 1.0);
    });
    check("sideways slip", 1e-9, |_, at| {
        at.hooks.lateral_slip = (at.slip > -1.0).then_some(0.3)
    });
}

#[test]
fn shear_that_saturates_at_once() {
    check("K = .2 mm", 1e-7, |p, _| p[5] = 2e-4);
}
