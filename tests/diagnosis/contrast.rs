//! Against an outside simulator whose wheel law the nominal simulator does not have.

use terra::data::RigLog;
use terra::gap::{
    CauseKind, Diagnosis, Settings, diagnose_drive, diagnose_drive_against, diagnose_rig,
    diagnose_rig_against, is_instrument,
};
use terra::model::Registry;
use terra::sim::integrate::DormandPrince;
use terra::sim::{Command, Integrator, Profile, Scenario, simulate_drive_with, simulate_rig};

use crate::rig;
use crate::vehicle::{effect as set, example};

/// Trials of another wheel law on dry sand, with an effect; the diagnosis knows Wong and Reece's only.
fn log(effect: &str, seed: u64) -> RigLog {
    log_on("dry_sand", effect, seed)
}

/// The same on any soil.
fn log_on(terrain: &str, effect: &str, seed: u64) -> RigLog {
    simulated(
        ("linear-stress", terrain, "condition = \"smooth\""),
        effect,
        seed,
    )
}

/// A load in its own rut, after trials at three loads.
const SECOND_PASS: &str = "[[trial]]\nslip = [0.05, 0.1, 0.2, 0.35, 0.55, 0.8]\nnormal_load_N = [245.0]\npass = 2\n\
    travel_speed_m_s = 0.05";

/// Trials of a wheel law on a soil, what follows them, and an effect.
fn simulated((law, terrain, then): (&str, &str, &str), effect: &str, seed: u64) -> RigLog {
    let text = format!(
        r#"
        seed = {seed}
        rover = "rig.toml"
        terrain = "{terrain}"
        model = "{law}"
        [[trial]]
        slip = [0.05, 0.1, 0.2, 0.35, 0.55, 0.8]
        normal_load_N = [150.0, 245.0, 400.0]
        repeats = 2
        travel_speed_m_s = 0.05
        {then}
        {effect}
        "#
    );
    let scenario = Scenario::parse(&text, "scenario.toml").unwrap();
    simulate_rig(&scenario, &rig(), &Registry::builtin())
        .unwrap()
        .log
}

fn against(effect: &str, seed: u64) -> Diagnosis {
    let (rover, registry) = (rig(), Registry::builtin());
    let settings = Settings::of(&rover);
    let (sim, real) = (log("", 100 + seed), log(effect, seed));
    let found = diagnose_rig_against(&sim, &real, &rover, &registry, &settings, false);
    found.unwrap().0
}

/// The wheel law's own error is no cause: it is in the simulator as well. Alone, the same log asks for another structure.
#[test]
fn what_the_simulator_shares_is_not_missing() {
    let (rover, registry) = (rig(), Registry::builtin());
    let settings = Settings::of(&rover);
    let (alone, _) = diagnose_rig(&log("", 1), &rover, &registry, &settings).unwrap();
    assert_ne!(alone.verdict, "none", "{:?}", alone.set);

    let d = against("", 1);
    let baseline = d.baseline.as_ref().unwrap();
    assert!(baseline.chi2_per_dof < 4.0, "{baseline:?}");
    assert_eq!(d.verdict, "none", "{:?} {:?}", d.set, d.reason);
}

/// Two loads at eight slips, once each: fewer values than soil and the form's error have numbers, which have priors.
#[test]
fn steady_trials_of_a_day_are_enough_of_a_baseline() {
    let (rover, registry) = (rig(), Registry::builtin());
    let trials = |effect: &str, seed: u64| {
        let text = format!(
            r#"
            seed = {seed}
            rover = "rig.toml"
            terrain = "dry_sand"
            model = "linear-stress"
            [[trial]]
            slip = [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6]
            normal_load_N = [180.0, 260.0]
            travel_speed_m_s = 0.05
            {effect}
            "#
        );
        let scenario = Scenario::parse(&text, "scenario.toml").unwrap();
        simulate_rig(&scenario, &rover, &registry).unwrap().log
    };
    let settings = Settings::of(&rover);
    let sim = trials("", 100);
    for effect in [
        None,
        Some(("drawbar-bias", 13.0)),
        Some(("load-error", 0.12)),
    ] {
        let text = effect.map_or(String::new(), |(name, magnitude)| {
            format!("[[effect]]\nname = \"{name}\"\nmagnitude = {magnitude}\n")
        });
        let real = trials(&text, 1);
        let (d, _) =
            diagnose_rig_against(&sim, &real, &rover, &registry, &settings, false).unwrap();
        let expected = effect.map_or("none", |(name, _)| name);
        assert_eq!(
            d.set.first().map(String::as_str),
            Some(expected),
            "{} {:?}",
            d.verdict,
            d.set
        );
    }
}

/// Instruments keep their exact form under any wheel law, so against the simulator they are found in spite of it.
#[test]
fn an_instrument_is_named_against_a_foreign_wheel_law() {
    for (name, magnitude) in [("torque-scale", 0.15), ("drawbar-bias", 12.0)] {
        let effect = format!("[[effect]]\nname = \"{name}\"\nmagnitude = {magnitude}\n");
        let d = against(&effect, 2);
        assert!(
            d.set.iter().any(|s| s == name) && d.set.len() <= 3,
            "{name}: {} {:?} {:?}",
            d.verdict,
            d.set,
            d.reason
        );
        assert!(!d.set.iter().any(|s| s == "none"), "{name}: {:?}", d.set);
    }
}

/// A second formula of the ground would only mend the foreign wheel law: what does not share it is one cause, and no two.
#[test]
fn an_effect_of_the_ground_needs_no_second_one_against_a_foreign_wheel_law() {
    let d = against("[[effect]]\nname = \"slip-sinkage\"\nmagnitude = 0.8\n", 3);
    assert_eq!(d.causes[0].name, "slip-sinkage", "{:?}", d.set);
    let registry = Registry::builtin();
    let of_the_ground = |name: &str| !is_instrument(&*registry.effect(name).unwrap());
    for cause in d.causes.iter().filter(|c| c.kind == CauseKind::Combination) {
        assert!(!cause.name.split('+').any(of_the_ground), "{}", cause.name);
    }
}

/// A weaker rim and weaker soil look alike through a foreign wheel law. An effect that explains more than other soil with all its
/// freedom is named.
#[test]
fn an_effect_of_the_ground_that_leads_over_other_soil_is_named() {
    let d = against(
        "[[effect]]\nname = \"interface-friction\"\nmagnitude = 0.15\n",
        4,
    );
    assert!(d.causes.iter().any(|c| c.name == "soil-change"));
    assert_eq!(
        (d.verdict, d.set),
        ("named", vec!["interface-friction".to_owned()])
    );
}

/// Two wheel laws do not differ alike on all soils. Other soil needs another error of the law's form here, and where it does, an
/// effect on it and one of the ground instead of it stand beside it, behind it; where it does not, and no effect comes near, it
/// stands alone.
#[test]
fn other_soil_is_followed_where_the_wheel_laws_differ_otherwise() {
    let (rover, registry) = (rig(), Registry::builtin());
    let settings = Settings::of(&rover);
    let between = |simulated: &str, real: &str, same_bed| {
        let (sim, real) = (log_on(simulated, "", 105), log_on(real, "", 5));
        let d = diagnose_rig_against(&sim, &real, &rover, &registry, &settings, same_bed);
        d.unwrap().0
    };
    let d = between("dry_sand", "lean_clay_22", false);
    assert_eq!(d.verdict, "ambiguous", "{:?}", d.reason);
    assert_eq!(d.causes[0].name, "soil-change", "{:?}", d.set);
    assert!((2..=3).contains(&d.set.len()), "{:?}", d.set);
    assert_eq!(d.set[0], "soil-change", "{:?}", d.set);
    let of_the_ground = |name: &String| !is_instrument(&*registry.effect(name).unwrap());
    assert!(d.set[1..].iter().any(of_the_ground), "{:?}", d.set);
    // A log of the same ground would tell.
    assert!(d.reason.unwrap().contains("--same-bed"));
    let told = between("dry_sand", "lean_clay_22", true);
    assert!(told.causes.iter().all(|c| c.name != "soil-change"));

    let d = between("sandy_loam_15", "dry_sand", false);
    assert_eq!(
        (d.verdict, d.set),
        ("named", vec!["soil-change".to_owned()])
    );
}

/// A drive's wheels pass through every slip, and where they turn from driving to braking wheel laws differ most: there too the
/// nominal law follows the simulator to the noise, what both share is not missing by as much evidence as the
/// calibration asks of a cause, and an instrument is found by more.
#[test]
fn a_drive_is_compared_with_a_foreign_wheel_law() {
    let (rover, registry, mut scenario) = example();
    scenario.model = "scm-column".to_owned();
    let settings = Settings::of(&rover);
    let mut drive = |seed: u64, effects: &[(&str, f64)]| {
        scenario.seed = seed;
        scenario.effects = effects.iter().copied().map(set).collect();
        let steps = Integrator::DormandPrince(DormandPrince {
            relative: 1e-7,
            absolute: 1e-8,
            max_step: 0.1,
        });
        let run = simulate_drive_with(&scenario, &rover, &registry, steps);
        run.unwrap().log
    };
    let sim = drive(101, &[]);
    let mut against = |effects: &[(&str, f64)]| {
        let real = drive(1, effects);
        diagnose_drive_against(&sim, &real, &rover, &registry, &settings, false).unwrap()
    };
    let d = against(&[]);
    let baseline = d.baseline.as_ref().unwrap();
    assert!(baseline.chi2_per_dof < 1.2, "{baseline:?}");
    let calibration = d.calibration.as_ref().unwrap();
    assert_eq!(calibration.design, "rich-contrast");
    let asked = calibration.null_gain;
    assert!(d.set.iter().any(|s| s == "none"), "{:?}", d.set);
    let first = d.causes.iter().map(|c| c.log_evidence_gain);
    let most = first.fold(f64::NEG_INFINITY, f64::max);
    assert!(most < asked, "{most}");
    let d = against(&[("torque-scale", 0.12)]);
    assert_eq!(d.causes[0].name, "torque-scale", "{:?}", d.set);
    let gain = d.causes[0].log_evidence_gain;
    assert!(gain > asked, "{gain}");
}

/// A simulator that knows ruts and soil piled up aside has them in its own log. That they are in the real one too is no gap, nor is a
/// log a gap to itself; the nominal law alone names them. On a drive of the same vehicle that shows no more of them nothing is said.
#[test]
fn an_effect_that_both_drives_show_is_no_gap() {
    let (rover, registry, mut scenario) = example();
    let settings = Settings::of(&rover);
    let mut drive = |seed: u64, effects: &[(&str, f64)]| {
        scenario.seed = seed;
        scenario.effects = effects.iter().copied().map(set).collect();
        let run = simulate_drive_with(&scenario, &rover, &registry, Integrator::default());
        run.unwrap().log
    };
    let both = [("lateral-bulldozing", 1.5), ("multipass", 0.6)];
    let (sim, real) = (drive(101, &both), drive(1, &both));
    let alone = diagnose_drive(&real, &rover, &registry, &settings).unwrap();
    assert!(alone.set.iter().all(|s| s != "none"), "{:?}", alone.set);
    for real in [&real, &sim] {
        let d = diagnose_drive_against(&sim, real, &rover, &registry, &settings, false).unwrap();
        assert_eq!(d.verdict, "none", "{:?} {:?}", d.set, d.reason);
        assert!(!d.baseline.unwrap().shows.is_empty());
    }
    let more = [both[0], both[1], ("torque-scale", 0.12)];
    let real = drive(1, &more);
    let d = diagnose_drive_against(&sim, &real, &rover, &registry, &settings, false).unwrap();
    assert_eq!(d.causes[0].name, "torque-scale", "{:?}", d.set);
}

/// The second pass of a rig against the first: every row of the log is of one pass, and it is another than the simulator's.
#[test]
fn a_rig_s_second_pass_is_asked_against_its_first() {
    let (rover, registry) = (rig(), Registry::builtin());
    let settings = Settings::of(&rover);
    let (sim, mut real) = (log("", 101), log("", 1));
    let asked = |real: &RigLog| {
        let d = diagnose_rig_against(&sim, real, &rover, &registry, &settings, false);
        let d = d.unwrap().0;
        d.not_asked.iter().all(|(name, _)| name != "multipass")
    };
    assert!(!asked(&real));
    real.rows.iter_mut().for_each(|r| r.pass = 2);
    assert!(asked(&real));
}

/// A simulator of one wheel law, ground of another, and a nominal law that is neither: the law's difference is not missing by itself,
/// and what else is missing is among the answers in spite of it.
#[test]
fn three_wheel_laws_hide_no_effect() {
    let (rover, registry) = (rig(), Registry::builtin());
    let settings = Settings::of(&rover);
    let trials = |law, effect: &str, seed| simulated((law, "dry_sand", SECOND_PASS), effect, seed);
    let sim = trials("scm-column", "", 7);
    for (name, magnitude) in [("none", 0.0), ("multipass", 1.0), ("slip-sinkage", 0.6)] {
        let effect = match name {
            "none" => String::new(),
            _ => format!("[[effect]]\nname = \"{name}\"\nmagnitude = {magnitude}\n"),
        };
        let real = trials("linear-stress", &effect, 8);
        let found = diagnose_rig_against(&sim, &real, &rover, &registry, &settings, false);
        let d = found.unwrap().0;
        let told = format!("{name}: {} {:?} {:?}", d.verdict, d.set, d.reason);
        if name == "none" {
            assert!(d.verdict != "named" || d.set == ["soil-change"], "{told}");
            assert!(
                d.set.iter().any(|s| s == "none" || s == "soil-change"),
                "{told}"
            );
        } else {
            assert!(
                d.set.iter().any(|s| s == name) && d.set.len() <= 4,
                "{told}"
            );
        }
    }
}

/// A simulator whose vehicle is held back in turns by sixty times what the rover file knows: what its log shows is of sizes that vehicles
/// have. (Without a limit it was a track of half its width, and skidding at its bound.)
#[test]
fn a_simulator_shows_nothing_of_a_size_that_no_vehicle_has() {
    let (rover, registry, mut scenario) = example();
    let mut held = rover.clone();
    held.vehicle.as_mut().unwrap().yaw_damping *= 60.0;
    for (left, right) in [(2.4, 6.0), (6.4, 2.8), (3.5, 4.5)] {
        let mut turn = scenario.segments[1].clone();
        turn.name = format!("turn {left}");
        let sides = [left, right, left, right];
        turn.command = Command::WheelSpeed(sides.map(Profile::constant));
        scenario.segments.push(turn);
    }
    scenario.effects.clear();
    let run = simulate_drive_with(&scenario, &held, &registry, Integrator::default());
    let sim = run.unwrap().log;
    let settings = Settings::of(&rover);
    let d = diagnose_drive_against(&sim, &sim, &rover, &registry, &settings, false).unwrap();
    let shows = &d.baseline.as_ref().unwrap().shows;
    assert!(!shows.is_empty());
    for shown in shows {
        let param = registry.effect(&shown.effect).unwrap().params()[0];
        let size = shown.magnitude.abs() / param.prior_sd;
        assert!(size < 3.0 && shown.magnitude < param.max, "{shown:?}");
    }
}
