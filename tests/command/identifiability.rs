//! `terra identifiability`: the directions of the literature's soils, the exact null of one width, mistakes by name.

use std::fs;

use terra::model::{AnyModel, Registry, catalogue};

use crate::support::{folder, json, list, number, terra, text};

const WHEEL: &str = "identifiability --radius_m 0.254 --slip 0.05:0.8:0.15";

#[test]
fn one_load_leaves_what_two_loads_and_widths_tell() {
    let to = folder("identifiability");
    terra(
        &to,
        &format!("{WHEEL} --terrain dry_sand --width_m 0.15 --load_N 245.25 --add 2 --json one.json --html one.html"),
    )
    .ok();
    let one = json(&to.join("one.json"));
    assert_eq!(text(&one["schema"]), "terra-identifiability/1");
    assert_eq!(number(&one["rank"]), 5.0);
    assert_eq!(number(&one["parameters"]), 7.0);
    let said: Vec<&str> = list(&one["undetermined"]).iter().map(text).collect();
    assert!(
        said.contains(&"k_c, k_phi only through k_c/b + k_phi"),
        "{said:?}"
    );
    assert_eq!(list(&one["directions"]).len(), 5);
    let further = list(&one["more_rows"]["sharpen"]);
    assert_eq!(further.len(), 2);
    // The lever is another load.
    assert!(number(&further[0]["normal_load_N"]) != 245.25);
    let page = std::fs::read_to_string(to.join("one.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("trade off"));

    terra(
        &to,
        &format!("{WHEEL} --terrain dry_sand --width_m 0.1,0.2 --load_N 150,450 --noise drawbar_pull_N=0.5,torque_N_m=0.1,sinkage_m=0.003 --json two.json"),
    )
    .ok();
    let two = json(&to.join("two.json"));
    assert!(
        list(&two["undetermined"]).is_empty(),
        "{}",
        two["undetermined"]
    );
    assert!(
        list(&two["profiles"])
            .iter()
            .any(|p| p["parameter"] == "k_c")
    );
}

/// With coarse instruments soils stay alike, and the proposed rows lift the worst pair.
#[test]
fn soils_that_stay_alike_are_listed_with_what_would_part_them() {
    let to = folder("identifiability_alike");
    let done = terra(
        &to,
        "identifiability --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.06 --terrain lean_clay_22 \
         --noise drawbar_pull_N=5,torque_N_m=1,slip=0.01 --json out.json",
    )
    .ok();
    let out = json(&to.join("out.json"));
    let alike = list(&out["alike"]);
    assert!(!alike.is_empty(), "{}", done.out);
    let nats: Vec<f64> = alike.iter().map(|p| number(&p["nats"])).collect();
    assert!(nats.windows(2).all(|w| w[0] <= w[1]) && nats[0] < 3.0);
    let lifted: Vec<f64> = list(&out["more_rows"]["separate"])
        .iter()
        .map(|r| number(&r["nats"]))
        .collect();
    assert_eq!(lifted.len(), 3);
    assert!(lifted[0] > nats[0] && lifted.windows(2).all(|w| w[0] <= w[1]));
}

#[test]
fn mistakes_are_named() {
    let to = folder("identifiability_bad");
    let wheel = format!("{WHEEL} --width_m 0.15 --load_N 245.25");
    for (line, message) in [
        (
            format!("{wheel} --terrain dry_snd"),
            "did you mean 'dry_sand'",
        ),
        (
            format!("{wheel} --terrain dry_sand --noise pull=1"),
            "unknown channel 'pull'",
        ),
        (
            format!("{wheel} --terrain dry_sand --noise drawbar_pull_N=x"),
            "'x' is no sd",
        ),
        (
            format!("{wheel} --terrain dry_sand --noise slip=0.01"),
            "measured channels",
        ),
        (
            format!("{wheel} --terrain dry_sand --set wong"),
            "terrain set",
        ),
        (
            format!("{wheel} --terrain dry_sand --set planetary"),
            "--set planetary: terrain 'mer_b_sandy_loam' gives no shear_modulus",
        ),
        (
            format!("{wheel} --terrain mer_b_sandy_loam"),
            "its source gives none",
        ),
        (
            format!("{wheel} --terrain dry_sand --model compliant-tyre"),
            "--value tyre_pressure=VALUE (Pa)",
        ),
        (
            format!("{wheel} --terrain dry_sand --value friction_angle=3"),
            "friction_angle = 3",
        ),
        (
            format!("{wheel} --terrain dry_sand --model wong-reece+torque-bias"),
            "effect torque-bias acts on what a sensor reports",
        ),
        (
            format!("{wheel} --terrain dry_sand --model wong-reece+slip-sinkage+slip-sinkage"),
            "slip-sinkage twice",
        ),
        (
            format!("{WHEEL} --width_m 0.15 --load_N 1e7 --terrain dry_sand"),
            "carries none of these loads",
        ),
    ] {
        let done = terra(&to, &line);
        assert_eq!(done.code, 2, "{line}: {}", done.err);
        assert!(done.err.contains(message), "{message}: {}", done.err);
    }
}

/// Three soils of one's own, in a set of the file.
const OWN: &str = "id,set,name,n,kc_kN_m_n1,kphi_kN_m_n2,c_kPa,phi_deg,K_m,c1,c2\n\
                   loose,bench,loose,1.0,1.5,900,0.4,31,0.015,NA,NA\n\
                   dense,bench,dense,1.0,1.5,1800,0.4,36,0.01,NA,NA\n\
                   short,bench,dry sand that shears sooner,1.1,0.99,1528.43,1.04,28,0.02,0.38,0.41\n";

/// The options that give a model what `dry_sand` does not.
fn values(model: &dyn AnyModel) -> String {
    let soil = catalogue::find("dry_sand").unwrap();
    let typical = model.typical_parameters();
    let typical = typical.first().cloned().unwrap_or_default();
    let missing = model.params().iter().zip(typical);
    missing
        .filter(|(p, _)| soil.value(p.name).is_none())
        .map(|(p, value)| format!(" --value {}={value}", p.name))
        .collect()
}

/// Every model that has a name can be asked about, and pressure laws by slots, with what no soil gives said by `--value`.
#[test]
fn every_model_can_be_asked_about() {
    let at = folder("identifiability_models");
    fs::write(at.join("own.csv"), OWN).unwrap();
    let registry = Registry::builtin();
    let named = registry.models().iter().chain(registry.named_models());
    let mut models: Vec<_> = named.cloned().collect();
    for slots in [
        "wong-reece:peat",
        "wong-reece:exponential-snow",
        "wong-reece:layered:wong-hump",
    ] {
        models.push(registry.model(slots).unwrap());
    }
    let mut with_values = 0;
    for model in models {
        let given = values(&*model);
        with_values += usize::from(!given.is_empty());
        let line = format!(
            "identifiability --terrain dry_sand --radius_m 0.3 --width_m 0.15 --load_N 245.25 --slip 0.2:0.6:0.4 --add 0 \
             --set own.csv --json out.json --model {}{given}",
            model.name()
        );
        terra(&at, &line).ok();
        let out = json(&at.join("out.json"));
        assert!(number(&out["rank"]) >= 1.0, "{}", model.name());
        assert!(
            number(&out["parameters"]) >= number(&out["rank"]),
            "{}",
            model.name()
        );
        assert_eq!(
            number(&out["rows"]["no_equilibrium"]),
            0.0,
            "{}",
            model.name()
        );
        for p in out["values"].as_object().unwrap().keys() {
            assert!(given.contains(&format!(" {p}=")), "{p}");
        }
    }
    assert!(with_values >= 10, "{with_values}");
}

/// Soils beyond a model's range are left out by name: the snows of the classic set sink with more than n = 1.3.
#[test]
fn soils_beyond_a_models_range_are_named() {
    let at = folder("identifiability_range");
    let done = terra(
        &at,
        &format!("{WHEEL} --width_m 0.15 --load_N 245.25 --terrain dry_sand --model bekker-compaction --add 0 --json out.json"),
    )
    .ok();
    let out = json(&at.join("out.json"));
    let left: Vec<&str> = list(&out["left_out"])
        .iter()
        .map(|l| text(&l["soil"]))
        .collect();
    let beyond: Vec<String> = catalogue::set("wong21")
        .unwrap()
        .iter()
        .filter(|t| t.sinkage_exponent >= 1.3)
        .map(|t| t.id.to_string())
        .collect();
    assert_eq!(left, beyond);
    assert_eq!(left.len(), 3);
    assert!(
        done.out.contains("snow_sweden of wong21 is left out: "),
        "{}",
        done.out
    );
    assert!(done.out.contains("of 18 soils in wong21"), "{}", done.out);
}

/// A value in place of the soil's asks around the soil that has that value.
#[test]
fn a_value_in_place_of_the_soils_is_the_soil_that_has_it() {
    let at = folder("identifiability_value");
    fs::write(at.join("own.csv"), OWN).unwrap();
    let wheel = format!("{WHEEL} --width_m 0.15 --load_N 245.25 --add 1 --catalogue own.csv");
    terra(
        &at,
        &format!("{wheel} --terrain dry_sand --value shear_modulus=0.02 --json value.json"),
    )
    .ok();
    terra(&at, &format!("{wheel} --terrain short --json soil.json")).ok();
    let (value, soil) = (json(&at.join("value.json")), json(&at.join("soil.json")));
    let ends = |of: &serde_json::Value| -> Vec<(String, Option<f64>, Option<f64>)> {
        let profiles = list(&of["profiles"]).iter();
        profiles
            .map(|p| {
                (
                    text(&p["parameter"]).to_owned(),
                    p["lo"].as_f64(),
                    p["hi"].as_f64(),
                )
            })
            .collect()
    };
    for (a, b) in ends(&value).iter().zip(&ends(&soil)) {
        assert_eq!(a.0, b.0);
        for (x, y) in [(a.1, b.1), (a.2, b.2)] {
            match (x, y) {
                (Some(x), Some(y)) => assert!((x / y - 1.0).abs() < 1e-6, "{}: {x} {y}", a.0),
                (x, y) => assert_eq!(x, y, "{}", a.0),
            }
        }
    }
    assert_eq!(number(&value["rank"]), number(&soil["rank"]));
    assert_eq!(number(&value["values"]["shear_modulus"]), 0.02);
}

/// A value holds for every soil of the set: where all that they differ in is given, they are one.
#[test]
fn values_hold_for_the_soils_to_be_told_apart() {
    let at = folder("identifiability_one");
    fs::write(at.join("own.csv"), OWN).unwrap();
    let wheel = format!(
        "{WHEEL} --width_m 0.15 --load_N 245.25 --add 1 --catalogue own.csv --terrain loose --set bench"
    );
    let differ = terra(&at, &wheel).ok().out;
    assert!(differ.contains("of 3 soils in bench"), "{differ}");
    let all = "--value k_c=1500 --value k_phi=9e5 --value sinkage_exponent=1 --value cohesion=400 --value friction_angle=0.54 \
               --value shear_modulus=0.015 --value c1=0.5 --value c2=0";
    let one = terra(&at, &format!("{wheel} {all}")).ok().out;
    assert!(
        one.contains("the 3 soils in bench differ in no parameter of wong-reece"),
        "{one}"
    );
    // Grains have one number, which no soil of a catalogue gives.
    let grains =
        format!("{wheel} --model granular-rft --value intrusion_stiffness=3e6 --json out.json");
    let grains = terra(&at, &grains).ok().out;
    assert!(
        grains.contains("differ in no parameter of granular-rft"),
        "{grains}"
    );
    assert_eq!(list(&json(&at.join("out.json"))["alike"]).len(), 3);
}
