//! `terra bevameter`: known soils come back, measured plates and shear tests are read as they are, errors have a place.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::{Csv, example, folder, json, list, number, run, terra, text};

/// A measured file, or a clear word that it is absent.
fn measured(file: &str) -> Option<PathBuf> {
    let root = std::env::var_os("TERRA_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"),
        PathBuf::from,
    );
    let path = root.join(file);
    if path.exists() {
        return Some(path);
    }
    println!(
        "SKIPPED: {} is not there; set TERRA_DATA to the folder that holds it",
        path.display()
    );
    None
}

fn law<'a>(soil: &'a Value, name: &str) -> &'a Value {
    list(&soil["laws"])
        .iter()
        .find(|l| l["law"] == name)
        .unwrap()
}

fn value(soil: &Value, of: &str, name: &str) -> f64 {
    number(&law(soil, of)["parameters"][name]["value"])
}

/// Fits a measured file with its example of columns.
fn fitted(name: &str, file: &str, kind: &str, columns: &str) -> Option<Value> {
    let file = measured(file)?;
    let to = folder(name);
    fs::copy(example(columns), to.join("columns.toml")).unwrap();
    let arguments = [
        "bevameter",
        file.to_str().unwrap(),
        "--kind",
        kind,
        "--columns",
        "columns.toml",
        "--json",
        "out.json",
        "--html",
        "out.html",
    ];
    run(&to, arguments).ok();
    let page = fs::read_to_string(to.join("out.html")).unwrap();
    assert!(page.contains("<svg") && !page.contains("NaN"));
    Some(json(&to.join("out.json")))
}

/// Two plates of a known soil in kilopascals and millimetres: k_c, k_φ and n come back.
#[test]
fn a_known_soil_comes_back_from_two_plates() {
    let to = folder("bevameter_known");
    let (k_c, k_phi, n) = (30e3, 1.2e6, 0.9f64);
    let mut log = "name,d_cm,z_mm,p_kPa\n".to_owned();
    for diameter in [6.0, 10.0] {
        for mm in 1..=40 {
            let z = f64::from(mm) * 1e-3;
            let k = k_c / (0.005 * diameter) + k_phi;
            log.push_str(&format!(
                "d{diameter},{diameter},{mm},{}\n",
                1e-3 * k * z.powf(n)
            ));
        }
    }
    fs::write(to.join("log.csv"), log).unwrap();
    let columns = "[columns]\ntest = { from = \"name\" }\nplate_diameter_m = { from = \"d_cm\", unit = \"cm\" }\n\
        sinkage_m = { from = \"z_mm\", unit = \"mm\" }\npressure_Pa = { from = \"p_kPa\", unit = \"kPa\" }\n";
    fs::write(to.join("columns.toml"), columns).unwrap();
    terra(
        &to,
        "bevameter log.csv --kind plate --columns columns.toml --json out.json",
    )
    .ok();
    let out = json(&to.join("out.json"));
    assert_eq!(text(&out["schema"]), "terra-bevameter/1");
    let soil = &list(&out["soils"])[0];
    for (name, expected) in [("k_c", k_c), ("k_phi", k_phi), ("sinkage_exponent", n)] {
        let found = value(soil, "bekker", name);
        assert!((found / expected - 1.0).abs() < 1e-6, "{name}: {found}");
    }
    assert_eq!(text(&soil["best"]), "bekker");
    assert!(soil["null_direction"].is_null());
}

/// Three plates on the dry sand of a soil bin. Its authors give n = 1.46; the wheel's rows are no plate.
#[test]
fn measured_plates_on_dry_sand() {
    let Some(out) = fitted(
        "bevameter_cmu",
        "cmu_single_wheel/pressure_sinkage.csv",
        "plate",
        "bevameter/cmu_plates.toml",
    ) else {
        return;
    };
    assert_eq!(number(&out["rows"]["left_out"]), 496.0);
    let soil = &list(&out["soils"])[0];
    assert_eq!(list(&soil["tests"]).len(), 9);
    let n = &law(soil, "bekker")["parameters"]["sinkage_exponent"];
    assert!(
        number(&n["lo"]) < 1.46 && 1.46 < number(&n["hi"]),
        "the published exponent lies outside {n}"
    );
    assert_eq!(text(&law(soil, "bekker")["interval"]), "between-tests");
}

/// One plate on one sand at five compactions: the sum alone is told, with its null direction, and the exponent of loose sand
/// is none.
#[test]
fn one_measured_plate_leaves_an_exact_null() {
    let Some(out) = fitted(
        "bevameter_cullinan",
        "cullinan_bevameter/plate_sinkage.csv",
        "plate",
        "bevameter/cullinan_plates.toml",
    ) else {
        return;
    };
    let soils = list(&out["soils"]);
    assert_eq!(soils.len(), 5);
    for soil in soils {
        let said = text(&list(&soil["undetermined"])[0]);
        assert!(
            said.starts_with("k_c, k_phi only through k_c/b + k_phi"),
            "{said}"
        );
        assert!((number(&soil["null_direction"]["k_c"]) - 0.0757).abs() < 1e-9);
        assert_eq!(number(&soil["null_direction"]["k_phi"]), -1.0);
    }
    let of = |method: &str| soils.iter().find(|s| s["soil"] == method).unwrap();
    // Published of these tests: n = .33 in the densest state, .51 one step below.
    for (method, expected) in [("5", 0.33), ("Method 4", 0.51)] {
        let n = value(of(method), "bekker", "sinkage_exponent");
        assert!((n - expected).abs() < 0.05, "{method}: {n}");
    }
    let loose = list(&of("Method 1")["undetermined"]);
    assert!(
        loose
            .iter()
            .any(|u| text(u).starts_with("sinkage_exponent"))
    );
}

/// The first displacement in m at which the measured shear stress of a compaction reaches a stress in Pa.
fn reaches(method: &str, stress: f64) -> f64 {
    let path = measured("cullinan_bevameter/shear.csv").unwrap();
    let csv = Csv::parse(&fs::read_to_string(path).unwrap());
    let (of, j, tau) = (
        csv.text("Method"),
        csv.full("Displacement"),
        csv.full("shear_stress"),
    );
    let at = (0..j.len()).find(|&k| of[k] == method && tau[k] * 1e3 >= stress);
    j[at.unwrap()] / 1e3
}

/// Shear at one normal stress: the strength lies where the data set's own summary has it, c and φ stay together.
#[test]
fn measured_shear_tests() {
    let Some(out) = fitted(
        "bevameter_shear",
        "cullinan_bevameter/shear.csv",
        "shear",
        "bevameter/cullinan_shear.toml",
    ) else {
        return;
    };
    for soil in list(&out["soils"]) {
        let test = &list(&soil["tests"])[0];
        let peak = number(&test["peak_stress_Pa"]);
        assert!((52e3..=66e3).contains(&peak), "{peak}");
        // The law's strength is near the peak, and K is where the measured stress first reaches 1 - 1/e of it: read off the
        // curve, and within half as much again where the curve is no exponential.
        let strength = value(soil, "janosi-hanamoto", "shear_strength");
        assert!(
            (0.8..1.02).contains(&(strength / peak)),
            "{strength} {peak}"
        );
        let modulus = value(soil, "janosi-hanamoto", "shear_modulus");
        let read_off = reaches(text(&soil["soil"]), (1.0 - (-1.0_f64).exp()) * strength);
        let ratio = modulus / read_off;
        assert!((1.0 / 1.5..1.5).contains(&ratio), "{modulus} {read_off}");
        let said = text(&list(&soil["undetermined"])[0]);
        assert!(
            said.starts_with("cohesion, friction_angle only through"),
            "{said}"
        );
    }
    let dense = list(&out["soils"])
        .iter()
        .find(|s| s["soil"] == "Method 5")
        .unwrap();
    let at = number(&list(&dense["tests"])[0]["peak_at_m"]);
    assert!(
        (0.008..=0.012).contains(&at),
        "the dense sand peaks at {at} m"
    );
}

#[test]
fn mistakes_have_a_place() {
    let to = folder("bevameter_bad");
    let good = "test,plate_diameter_m,sinkage_m,pressure_Pa\na,0.1,0.01,1000\na,0.1,0.02,2000\n";
    let cases = [
        (
            good.replace("2000", "soft"),
            3,
            "log.csv:3:4: column 'pressure_Pa': found 'soft'",
        ),
        (
            good.replace("pressure_Pa", "pressure_kPa"),
            3,
            "log.csv:1: no column 'pressure_Pa', nearest is 'pressure_kPa'",
        ),
        (
            good.replace("a,0.1,0.02", "a,0.2,0.02"),
            3,
            "log.csv:3: test 'a' has 0.1 here and 0.05 before",
        ),
        (
            good.to_owned(),
            3,
            "points on the loading branch = 2, expected at least 5",
        ),
        (
            "test,plate_diameter_m,sinkage_m,pressure_Pa\n".to_owned(),
            3,
            "no row that can be used of 0",
        ),
    ];
    for (log, code, message) in cases {
        fs::write(to.join("log.csv"), &log).unwrap();
        let done = terra(&to, "bevameter log.csv --kind plate --json out.json");
        assert_eq!(done.code, code, "{}", done.err);
        assert!(done.err.contains(message), "{message}: {}", done.err);
        assert!(!to.join("out.json").exists());
    }
    let columns = [
        (
            "[columns]\nsinkage = { from = \"z\" }\n",
            "columns.toml:2:11: unknown column 'sinkage', expected 'sinkage_m'",
        ),
        (
            "[columns]\nsinkage_m = { from = \"z\", unit = \"kPa\" }\n",
            "sinkage_m: unknown unit 'kPa'",
        ),
        (
            "[columns]\nsinkage_m = { unit = \"mm\" }\n",
            "expected either from or value",
        ),
        (
            "[fit]\nfrom_m = 0.1\nto_m = 0.01\n",
            "columns.toml:1:1: from_m = 0.1, to_m = 0.01",
        ),
        ("[fits]\n", "unknown field `fits`"),
    ];
    fs::write(to.join("log.csv"), good).unwrap();
    for (file, message) in columns {
        fs::write(to.join("columns.toml"), file).unwrap();
        let done = terra(&to, "bevameter log.csv --kind plate --columns columns.toml");
        assert_eq!(done.code, 2, "{}", done.err);
        assert!(done.err.contains(message), "{message}: {}", done.err);
    }
}
