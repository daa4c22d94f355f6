//! Every row of the high-precision reference wheel, in the metric
//! e = max(|Δθ1|/θ1, |ΔT|/|T|, |ΔD|/(|D| + |T|/R)).

use serde_json::Value;
use terra::model::{Contact, ForceLaw, ModelError, Registry, catalogue};

use crate::common::data;

/// What a table of rows gave: how many were compared, how many had no equilibrium, and the errors of the former.
struct Outcome {
    no_equilibrium: usize,
    errors: Vec<f64>,
    worst: (f64, String),
}

/// i = 1 - v/(R ω) of the file to the library's slip.
fn library_slip(kinematic: f64) -> f64 {
    if kinematic >= 0.0 {
        kinematic
    } else {
        kinematic / (1.0 - kinematic)
    }
}

fn close(label: &str, what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs(),
        "{label}: {what} is {found}, reference {expected}"
    );
}

/// Compares `model` with the object `field` of every row that has one; none when the file is not there.
fn compare(model: &str, field: &str, symmetric: bool, stresses: bool) -> Option<Outcome> {
    let text = std::fs::read_to_string(data("reference_wheel.json")?).unwrap();
    let reference: Value = serde_json::from_str(&text).unwrap();
    let size = |key: &str| reference["wheel"][key].as_f64().unwrap();
    let (radius, width) = (size("R_m"), size("b_m"));
    let law = Registry::builtin().law(model).unwrap();
    let mut outcome = Outcome {
        no_equilibrium: 0,
        errors: vec![],
        worst: (0.0, String::new()),
    };
    for row in reference["rows"].as_array().unwrap() {
        let id = row["terrain"].as_str().unwrap();
        let (slip, load) = (row["slip"].as_f64().unwrap(), row["W_N"].as_f64().unwrap());
        let label = format!("{id} at {load} N, kinematic slip {slip}");
        let expected = &row[field];
        let mut p = catalogue::find(id)
            .unwrap()
            .parameters(law.model())
            .unwrap();
        if symmetric {
            (p[6], p[7]) = (0.5, 0.0);
        }
        let at = Contact::new(library_slip(slip), load, radius, width);
        if !expected["equilibrium"].as_bool().unwrap() {
            let Err(ModelError::NoEquilibrium {
                load: asked,
                max_load,
            }) = law.forces(&p, &at)
            else {
                panic!("{label}: expected no equilibrium");
            };
            assert_eq!(asked, load, "{label}");
            assert!(max_load < load, "{label}: carries {max_load}");
            // The linear tables do not give the largest load.
            if let Some(most) = expected["W_at_t1max"].as_f64() {
                close(&label, "the largest load", max_load, most, 1e-9);
            }
            outcome.no_equilibrium += 1;
            continue;
        }
        let f = law
            .forces(&p, &at)
            .unwrap_or_else(|e| panic!("{label}: {e}"));
        let get = |k: &str| expected[k].as_f64().unwrap();
        let entry = f.angles.unwrap().entry;
        let error = ((entry - get("theta1")).abs() / get("theta1"))
            .max((f.resistive_torque - get("T")).abs() / get("T").abs())
            .max((f.drawbar_pull - get("D")).abs() / (get("D").abs() + get("T").abs() / radius));
        outcome.errors.push(error);
        if error > outcome.worst.0 {
            outcome.worst = (error, label.clone());
        }
        close(&label, "sinkage", f.sinkage.unwrap(), get("sinkage"), 1e-9);
        close(
            &label,
            "apex",
            f.angles.unwrap().max_stress,
            get("thetam"),
            1e-9,
        );
        if stresses {
            close(&label, "thrust", f.parts.thrust, get("thrust"), 1e-9);
            close(
                &label,
                "compaction",
                f.parts.compaction_resistance,
                get("resistance"),
                1e-9,
            );
            let profile = law.stresses(&p, &at, 50).unwrap().unwrap();
            close(
                &label,
                "peak σ",
                profile.max_normal.normal_stress,
                get("sigma_max"),
                1e-9,
            );
            // Largest signed value: on most braking rows that is the zero at the entry.
            close(
                &label,
                "peak τ",
                profile.max_shear.shear_stress,
                get("tau_max"),
                1e-9,
            );
        }
    }
    outcome.errors.sort_by(f64::total_cmp);
    let (n, worst) = (outcome.errors.len(), &outcome.worst);
    println!(
        "{model} against {field}: {n} rows, max {:.1e} ({}), median {:.1e}; {} rows without equilibrium",
        worst.0,
        worst.1,
        outcome.errors[n / 2],
        outcome.no_equilibrium
    );
    Some(outcome)
}

#[test]
fn wong_reece_agrees_with_every_row() {
    if let Some(outcome) = compare("wong-reece", "full", false, true) {
        assert_eq!((outcome.errors.len(), outcome.no_equilibrium), (141, 13));
        assert!(outcome.worst.0 < 1e-9, "{:?}", outcome.worst);
    }
}

#[test]
fn linear_stress_agrees_with_every_row() {
    if let Some(outcome) = compare("linear-stress", "linear_symmetric", true, false) {
        assert_eq!((outcome.errors.len(), outcome.no_equilibrium), (144, 10));
        assert!(outcome.worst.0 < 1e-9, "{:?}", outcome.worst);
    }
}
