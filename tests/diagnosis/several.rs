//! Several logs of one rover, diagnosed as one.

use std::path::Path;

use terra::data::{
    DriveLog, Measured, RigLog, RigRow, Rover, SoilSharing, parse_rover, read_rover,
};
use terra::gap::{
    Diagnosis, HoldOut, Named, Settings, diagnose_drive, diagnose_drives, diagnose_rig,
    diagnose_rigs,
};
use terra::model::{Contact, ForceLaw, Registry, catalogue};
use terra::sim::{EffectSetting, Scenario, simulate_drive};

use crate::calibrate::with_a_stop;
use crate::{part, probability, total};

/// The effects that the rig's diagnoses weigh: enough for rivals, few enough to be quick.
const ASKED: [&str; 4] = [
    "drawbar-bias",
    "drawbar-gain",
    "torque-bias",
    "sinkage-bias",
];

/// A rig whose inputs are as good as exact, so that the noise is the same whatever the soil.
fn exact_inputs() -> Rover {
    parse_rover(
        r#"
        [wheel]
        radius_m = 0.254
        width_m = 0.15
        [terrain]
        model = "wong-reece"
        start = "dry_sand"
        [noise]
        drawbar_pull_N = 0.5
        torque_N_m = 0.1
        sinkage_m = 0.001
        slip = 1e-7
        normal_load_N = 1e-6
        "#,
        "rig.toml",
    )
    .unwrap()
}

/// Rows of a soil whose friction angle is `friction` times dry sand's, the pull read `bias` newtons too high.
fn rows(loads: &[f64], friction: f64, bias: f64) -> RigLog {
    let law = Registry::builtin().law("wong-reece").unwrap();
    let mut p = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    let angle = law.params().iter().position(|p| p.name == "friction_angle");
    p[angle.unwrap()] *= friction;
    let measured = |value| Measured { value, sd: None };
    let mut log = RigLog::default();
    for &load in loads {
        for slip in [0.05, 0.1, 0.2, 0.35, 0.5, 0.7] {
            let f = law
                .forces(&p, &Contact::new(slip, load, 0.254, 0.15))
                .unwrap();
            log.rows.push(RigRow {
                line: log.rows.len() as u64 + 2,
                trial: format!("{load}"),
                condition: String::new(),
                pass: 1,
                time: None,
                slip: measured(slip),
                normal_load: measured(load),
                drawbar_pull: Some(measured(f.drawbar_pull + bias)),
                torque: Some(measured(f.resistive_torque)),
                sinkage: f.sinkage.map(measured),
                side_force: None,
                slip_angle: None,
                travel_speed: None,
                wheel_speed: None,
            });
        }
    }
    log
}

fn settings(rover: &Rover, soil: SoilSharing) -> Settings {
    Settings {
        effects: Some(ASKED.map(str::to_owned).to_vec()),
        combine: 1,
        soil,
        ..Settings::of(rover)
    }
}

/// One terrain model with the effects asked: other structures would cost most of the time and settle nothing here.
fn registry() -> Registry {
    let all = Registry::builtin();
    let mut few = Registry::empty().with_shared(all.model("wong-reece").unwrap());
    for name in ASKED {
        few = few.with_shared_effect(all.effect(name).unwrap());
    }
    few
}

fn together(logs: &[(&str, &RigLog)], soil: SoilSharing) -> Diagnosis {
    let rover = exact_inputs();
    let named: Vec<Named<'_, RigLog>> = logs
        .iter()
        .map(|&(name, log)| Named { name, log })
        .collect();
    diagnose_rigs(&named, &rover, &registry(), &settings(&rover, soil))
        .unwrap()
        .0
}

fn alone(log: &RigLog, effects: &[&str]) -> Diagnosis {
    let rover = exact_inputs();
    let asked = Settings {
        effects: Some(effects.iter().map(|e| (*e).to_owned()).collect()),
        ..settings(&rover, SoilSharing::Shared)
    };
    diagnose_rig(log, &rover, &registry(), &asked).unwrap().0
}

fn assert_same(a: &Diagnosis, b: &Diagnosis, within: f64) {
    assert_eq!(a.verdict, b.verdict);
    assert!((total(a) - 1.0).abs() < 1e-9);
    for c in &a.causes {
        let other = probability(b, &c.name);
        assert!(
            (c.probability - other).abs() < within,
            "{}: {} and {other}",
            c.name,
            c.probability
        );
    }
}

/// The order in which logs are given cannot matter, and neither can the order in which they are worked off, which their names
/// decide.
#[test]
fn the_order_of_logs_does_not_matter() {
    let (one, two) = (rows(&[150.0, 400.0], 1.0, 2.0), rows(&[245.0], 1.05, 2.0));
    for soil in [SoilSharing::Shared, SoilSharing::Own] {
        let there = together(&[("a", &one), ("b", &two)], soil);
        let back = together(&[("b", &two), ("a", &one)], soil);
        assert_same(&there, &back, 1e-15);
        let renamed = together(&[("b", &one), ("a", &two)], soil);
        assert_same(&there, &renamed, 1e-4);
    }
}

/// A log cut in two between trials is the same data on the same soil.
#[test]
fn a_log_cut_in_two_has_the_verdict_of_the_whole() {
    let whole = rows(&[150.0, 245.0, 400.0], 1.0, 3.0);
    let (mut first, mut second) = (whole.clone(), whole.clone());
    first.rows.truncate(6);
    second.rows.drain(..6);
    let joined = together(&[("a", &first), ("b", &second)], SoilSharing::Shared);
    let single = alone(&whole, &ASKED);
    assert_same(&single, &joined, 1e-6);
    let (a, b) = (single.held_out.unwrap(), joined.held_out.unwrap());
    assert_eq!((a.by, a.groups), (HoldOut::Trial, 3));
    assert_eq!(b.groups, 3);
    assert!((a.chi2_before - b.chi2_before).abs() < 1e-6);
    let groups = joined.data.groups();
    assert_eq!(groups, ["a/150", "b/245", "b/400"]);
    assert_eq!(joined.logs.unwrap().names, ["a", "b"]);
    assert!(single.logs.is_none());
}

/// The same of a drive, with all effects of a torque sensor that is off.
#[test]
fn a_drive_cut_between_manoeuvres_has_the_verdict_of_the_whole() {
    let (rover, registry, whole) = drive();
    let asked = Settings {
        effects: Some(
            ["torque-scale", "torque-bias", "mass-error"]
                .map(str::to_owned)
                .to_vec(),
        ),
        combine: 1,
        ..Settings::of(&rover)
    };
    let (first, second) = cut(&whole, 2);
    let single = diagnose_drive(&whole, &rover, &registry, &asked).unwrap();
    let both = [
        Named {
            name: "one.csv",
            log: &first,
        },
        Named {
            name: "two.csv",
            log: &second,
        },
    ];
    let joined = diagnose_drives(&both, &rover, &registry, &asked).unwrap();
    assert_eq!(single.data.len(), joined.data.len());
    assert_same(&single, &joined, 1e-6);
    assert_eq!(single.causes[0].name, "torque-scale");
    let paths = |d: &Diagnosis| -> Vec<f64> {
        let of = d.data.observations.iter().map(|o| o.factors["path"]);
        of.collect()
    };
    assert_eq!(
        paths(&single),
        paths(&joined),
        "every manoeuvre starts anew here"
    );
}

/// Closed form: with soils of their own and no common effect, the fit of two logs is the two fits, each by itself.
#[test]
fn logs_with_soils_of_their_own_are_fitted_as_if_alone() {
    let (soft, firm) = (
        rows(&[150.0, 245.0, 400.0], 0.85, 0.0),
        rows(&[150.0, 300.0], 1.1, 0.0),
    );
    let both = together(&[("soft", &soft), ("firm", &firm)], SoilSharing::Own);
    let (h, fit) = both.null.as_ref().unwrap();
    let names = h.soil.names();
    assert_eq!(names.len(), h.soil_len());
    let mut cost = 0.0;
    for (name, log) in [("firm", &firm), ("soft", &soft)] {
        let one = alone(log, &[]);
        let (g, single) = one.null.as_ref().unwrap();
        cost += single.cost;
        let own: Vec<f64> = names
            .iter()
            .zip(fit.x.iter())
            .filter(|(n, _)| n.starts_with(&format!("{name}/")))
            .map(|(_, x)| *x)
            .collect();
        assert_eq!(own.len(), g.soil_len());
        for (a, b) in own.iter().zip(single.x.iter()) {
            assert!((a - b).abs() < 0.05, "{name}: {own:?} and {:?}", single.x);
        }
    }
    assert!((fit.cost - cost).abs() < 1e-3, "{} and {cost}", fit.cost);
}

/// Two soils, one load cell that reads 3 N too high on both: with soils of their own the bias is all that is left to find. One
/// soil for both cannot follow the data.
#[test]
fn an_effect_is_shared_by_logs_with_soils_of_their_own() {
    let (soft, firm) = (
        rows(&[150.0, 400.0], 0.7, 3.0),
        rows(&[150.0, 400.0], 1.15, 3.0),
    );
    let logs = [("soft", &soft), ("firm", &firm)];
    let own = together(&logs, SoilSharing::Own);
    assert_eq!(
        (own.verdict, own.causes[0].name.as_str()),
        ("named", "drawbar-bias")
    );
    let cause = &own.causes[0].weighed;
    let k = cause.plain.x.len() - 1;
    let unit = cause.hypothesis.effects()[0].params()[0].prior_sd;
    let (bias, sd) = (
        cause.plain.x[k] * unit,
        cause.posterior.covariance[(k, k)].sqrt() * unit,
    );
    // Without noise only the prior, 1 sd of which is 2 N, pulls it away from the truth.
    assert!((bias - 3.0).abs() < sd, "{bias} with sd {sd}");
    let shared = together(&logs, SoilSharing::Shared);
    let misfit = |d: &Diagnosis| d.waterfall.refitted.unwrap();
    assert!(
        misfit(&shared) > 10.0 * misfit(&own),
        "{} and {}",
        misfit(&shared),
        misfit(&own)
    );
}

/// Second method: with inputs as good as exact, what is held out is the plain sum of squares of one log under the fit of the
/// other alone. So a poisoned log changes what is predicted from it, and not at all how it is predicted.
#[test]
fn a_held_out_log_is_predicted_from_the_others_alone() {
    let clean = rows(&[245.0], 1.0, 4.0);
    let mut poisoned = clean.clone();
    for row in &mut poisoned.rows {
        row.torque = row.torque.map(|m| Measured {
            value: m.value + 5.0,
            ..m
        });
    }
    let mut other = rows(&[400.0], 1.0, 4.0);
    other
        .rows
        .iter_mut()
        .for_each(|row| row.trial = "400".to_owned());
    let rover = exact_inputs();
    // Of `log` under the fit of `from`.
    let squares = |log: &RigLog, from: &RigLog| -> f64 {
        let d = alone(from, &[]);
        let (h, fit) = d.null.as_ref().unwrap();
        let p = h.parameters(fit.x.as_slice());
        let square = |row: &RigRow| {
            let at = Contact::new(row.slip.value, row.normal_load.value, 0.254, 0.15);
            let f = h.law.forces(&p, &at).unwrap();
            let off = |m: Option<Measured>, f: f64, noise: &str| {
                ((m.unwrap().value - f) / rover.noise.get(noise).unwrap()).powi(2)
            };
            off(row.drawbar_pull, f.drawbar_pull, "drawbar_pull_N")
                + off(row.torque, f.resistive_torque, "torque_N_m")
                + off(row.sinkage, f.sinkage.unwrap(), "sinkage_m")
        };
        log.rows.iter().map(square).sum()
    };
    for held in [&clean, &poisoned] {
        let d = together(&[("a", held), ("b", &other)], SoilSharing::Shared);
        let found = d.held_out.expect("something is accepted");
        assert_eq!(found.groups, 2);
        let by_hand = (squares(held, &other) + squares(&other, held)) / d.data.len() as f64;
        assert!(
            (found.chi2_before / by_hand - 1.0).abs() < 1e-3,
            "{} and {by_hand}",
            found.chi2_before
        );
    }
}

/// A channel that one log lacks is missing there only, torques included.
#[test]
fn a_channel_that_one_log_lacks_is_missing_there_only() {
    let (rover, registry, whole) = drive();
    let (first, mut second) = cut(&whole, 2);
    second.wheel_torque = None;
    second.accel_x = None;
    let both = [
        Named {
            name: "one.csv",
            log: &first,
        },
        Named {
            name: "two.csv",
            log: &second,
        },
    ];
    let asked = Settings {
        effects: Some(vec!["torque-scale".to_owned()]),
        combine: 1,
        ..Settings::of(&rover)
    };
    let d = diagnose_drives(&both, &rover, &registry, &asked).unwrap();
    let per_window = |name: &str| -> Vec<usize> {
        let of = d
            .data
            .observations
            .iter()
            .filter(|o| o.group.starts_with(name));
        of.map(|o| o.values.len()).collect()
    };
    let (one, two) = (per_window("one.csv/"), per_window("two.csv/"));
    assert!(one.len() > 10 && one.iter().all(|n| *n == 7), "{one:?}");
    assert!(two.len() > 10 && two.iter().all(|n| *n == 2), "{two:?}");
    assert_eq!(d.causes[0].name, "torque-scale");
}

#[test]
fn two_logs_of_one_name_are_refused() {
    let (rover, log) = (exact_inputs(), rows(&[245.0], 1.0, 0.0));
    let same = [
        Named {
            name: "a",
            log: &log,
        },
        Named {
            name: "a",
            log: &log,
        },
    ];
    let asked = settings(&rover, SoilSharing::Shared);
    let error = diagnose_rigs(&same, &rover, &Registry::builtin(), &asked)
        .err()
        .unwrap();
    assert!(error.to_string().contains("'a'"), "{error}");
}

/// Four manoeuvres of the book's drive, with its torque sensor that is off.
fn drive() -> (Rover, Registry, DriveLog) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/drive");
    let rover = read_rover(folder.join("rover.toml")).unwrap();
    let registry = Registry::builtin();
    let mut scenario = Scenario::read(&folder.join("rich.toml")).unwrap();
    scenario.segments.truncate(4);
    scenario.effects = vec![EffectSetting::new("torque-scale", 0.2)];
    let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
    (rover, registry, log)
}

/// Two logs: the segments before number `at`, and the others.
fn cut(log: &DriveLog, at: usize) -> (DriveLog, DriveLog) {
    let row = log.segments[at].rows.start;
    (part(log, 0, row), part(log, row, log.time.len()))
}

/// Said to be on one soil, and not: what then looks like an effect, or like something unknown, comes with the way out.
#[test]
fn logs_of_two_soils_that_are_said_to_share_one_are_told() {
    let told = |soils: [&str; 2]| {
        let (one, rover) = with_a_stop(soils[0], 8, None);
        let (two, _) = with_a_stop(soils[1], 9, None);
        let logs = [("one", &one), ("two", &two)].map(|(name, log)| Named { name, log });
        let asked = Settings::of(&rover);
        let d = diagnose_drives(&logs, &rover, &Registry::builtin(), &asked).unwrap();
        d.heed.iter().any(|line| line.contains("--soil own"))
    };
    assert!(told(["dry_sand", "upland_sandy_loam"]));
    assert!(!told(["dry_sand", "dry_sand"]));
}
