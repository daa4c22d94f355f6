//! `terra identifiability`: the directions of the literature's soils, the exact null of one width, mistakes by name.

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
            format!("{WHEEL} --width_m 0.15 --load_N 1e7 --terrain dry_sand"),
            "carries none of these loads",
        ),
    ] {
        let done = terra(&to, &line);
        assert_eq!(done.code, 2, "{line}: {}", done.err);
        assert!(done.err.contains(message), "{message}: {}", done.err);
    }
}
