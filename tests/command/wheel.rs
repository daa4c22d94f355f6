//! `terra wheel` against the drawbar pulls that must hold, and its table.

use std::fs;

use terra::model::{Contact, ForceLaw, Registry, catalogue};

use crate::support::{Csv, folder, terra};

const SLIPS: [f64; 7] = [0.02, 0.1, 0.2, 0.4, 0.6, 0.8, 0.95];

fn wheel(soil: &str, load: f64, slip: &str) -> Csv {
    let line = format!(
        "wheel --terrain {soil} --radius_m 0.254 --width_m 0.15 --load_N {load} --slip {slip}"
    );
    Csv::parse(
        &terra(&folder(&format!("wheel_{soil}_{load}")), &line)
            .ok()
            .out,
    )
}

/// Drawbar pull in N of the wheel of Ray 2008 (R = .254 m, b = .15 m) on its three soils at both loads, printed to .1 N
/// and 1 N.
#[test]
fn drawbar_pull_against_slip() {
    let table = [
        (
            "dry_sand",
            245.25,
            [-28.0, -8.9, 8.3, 28.2, 36.3, 36.9, 33.3],
        ),
        (
            "upland_sandy_loam",
            245.25,
            [11.1, 55.2, 86.3, 112.9, 121.4, 123.2, 122.3],
        ),
        (
            "lean_clay_22",
            245.25,
            [-1.4, 5.7, 14.1, 29.6, 43.4, 56.1, 65.1],
        ),
        (
            "dry_sand",
            2452.5,
            [-180.0, -140.0, -131.0, -198.0, -344.0, -584.0, -889.0],
        ),
        (
            "upland_sandy_loam",
            2452.5,
            [383.0, 433.0, 440.0, 389.0, 300.0, 180.0, 65.0],
        ),
        (
            "lean_clay_22",
            2452.5,
            [-81.0, 155.0, 364.0, 617.0, 753.0, 833.0, 874.0],
        ),
    ];
    for (soil, load, expected) in table {
        let half_a_digit = if load < 1000.0 { 0.05 } else { 0.5 } + 1e-9;
        let csv = wheel(soil, load, "0.01:0.95:0.01");
        assert_eq!(csv.rows.len(), 95);
        let (slip, pull) = (csv.full("slip"), csv.full("drawbar_pull_N"));
        for (at, expected) in SLIPS.iter().zip(expected) {
            let k = slip.iter().position(|s| s == at).unwrap();
            assert!(
                (pull[k] - expected).abs() <= half_a_digit,
                "{soil}, {load} N, slip {at}: {} not {expected}",
                pull[k]
            );
        }
    }
}

/// Torque at slip .95 of the light vehicle, in N m to three decimals.
#[test]
fn torque_at_high_slip() {
    for (soil, expected) in [
        ("dry_sand", 30.392),
        ("upland_sandy_loam", 47.435),
        ("lean_clay_22", 17.508),
    ] {
        let torque = wheel(soil, 245.25, "0.95").full("torque_N_m")[0];
        assert!(
            (torque - expected).abs() <= 5.1e-4,
            "{soil}: {torque} not {expected}"
        );
    }
}

#[test]
fn the_table_is_the_contract_and_pull_is_thrust_less_resistance() {
    let csv = wheel("dry_sand", 245.0, "-0.5:0.9:0.1");
    let columns = "slip,normal_load_N,drawbar_pull_N,torque_N_m,thrust_N,motion_resistance_N,sinkage_m,entry_angle_rad,\
                   max_stress_angle_rad,max_normal_stress_Pa,max_shear_stress_Pa,status";
    assert_eq!(csv.header.join(","), columns);
    assert_eq!(csv.rows.len(), 15);
    let (d, h, r) = (
        csv.full("drawbar_pull_N"),
        csv.full("thrust_N"),
        csv.full("motion_resistance_N"),
    );
    for k in 0..15 {
        assert!(
            (d[k] - (h[k] - r[k])).abs() < 1e-9 * h[k].abs().max(r[k]),
            "row {k}"
        );
    }
    assert!(csv.text("status").iter().all(|s| *s == "ok"));
}

/// Parts by name add up to the pull, a lug that pushes is one of them, and a load that is not carried has none.
#[test]
fn contributions_add_up_and_name_the_push_of_a_lug() {
    let ask = |model: &str, load: &str| {
        let line = format!(
            "wheel --terrain upland_sandy_loam --radius_m 0.254 --width_m 0.15 --load_N {load} --slip 0.2:0.6:0.2 \
             --contributions --model {model}"
        );
        Csv::parse(
            &terra(&folder(&format!("wheel_parts_{load}")), &line)
                .ok()
                .out,
        )
    };
    let model = "wong-reece+bulldozing=1+grousers/passive-lug=0.01+slip-sinkage/excavation=0.01";
    let csv = ask(model, "245");
    let plain = ask("wong-reece", "245");
    let column = |name| csv.full(name);
    for k in 0..3 {
        let parts = [
            column("rim_thrust_N")[k],
            column("lug_thrust_N")[k],
            -column("compaction_resistance_N")[k],
            -column("bulldozing_resistance_N")[k],
            column("other_force_N")[k],
        ];
        let pull = column("drawbar_pull_N")[k];
        assert!(
            (parts.iter().sum::<f64>() - pull).abs() < 1e-9,
            "{parts:?} {pull}"
        );
        assert!(
            parts[1] > 1.0 && parts[3] < -1.0 && parts[4] < -1.0,
            "{parts:?}"
        );
        assert!((parts[0] + parts[1] - column("thrust_N")[k]).abs() < 1e-9);
        assert!((parts[2] + parts[3] + column("motion_resistance_N")[k]).abs() < 1e-9);
        assert_eq!(plain.full("lug_thrust_N")[k], 0.0);
        assert_eq!(plain.full("other_force_N")[k], 0.0);
        // Neither the lug nor the front changes what the rim itself does.
        assert_eq!(plain.full("rim_thrust_N")[k], parts[0]);
    }
    let none = ask("wong-reece", "1e9");
    assert_eq!(none.text("lug_thrust_N"), ["", "", ""]);
}

/// Twelve lugs: what they push rises and falls about the mean that the curve holds. A wheel without such lugs says so.
#[test]
fn the_passage_of_a_lug_is_a_table_of_its_own() {
    let to = folder("wheel_lugs");
    let line = "wheel --terrain upland_sandy_loam --radius_m 0.254 --width_m 0.15 --load_N 245 --slip 0.3 --contributions \
                --lugs --csv w.csv --model grouser-passive --value unit_weight=15000 --value lug_height=0.012 --value lug_count=12";
    terra(&to, line).ok();
    let read = |file: &str| Csv::parse(&std::fs::read_to_string(to.join(file)).unwrap());
    let (curve, cycle) = (read("w.csv"), read("w.lugs.csv"));
    let pull = cycle.full("lug_pull_N");
    assert_eq!(pull.len(), 100);
    let mean = pull.iter().sum::<f64>() / 100.0;
    let expected = curve.full("lug_thrust_N")[0];
    assert!((mean / expected - 1.0).abs() < 0.05, "{mean} {expected}");
    let apart = std::f64::consts::TAU / 12.0;
    assert!(
        cycle
            .full("phase_rad")
            .iter()
            .all(|x| (0.0..apart).contains(x))
    );
    let none = line
        .replace("grouser-passive", "wong-reece")
        .replace(" --value unit_weight=15000", "");
    let none = none.replace(" --value lug_height=0.012 --value lug_count=12", "");
    let done = terra(&to, &none);
    assert_eq!(done.code, 2);
    assert!(done.err.contains("no lugs that push"), "{}", done.err);
}

/// A soil that cannot carry the wheel is a row without forces, never a number and never a failure of the curve.
#[test]
fn too_heavy_a_wheel_has_no_equilibrium() {
    let csv = wheel("dry_sand", 1e9, "0.1:0.3:0.1");
    assert!(csv.text("status").iter().all(|s| *s == "no-equilibrium"));
    assert!(
        csv.rows
            .iter()
            .all(|r| r[2..11].iter().all(String::is_empty))
    );
}

/// Every model either has stresses or says that it has none.
#[test]
fn stresses_of_every_model_or_a_refusal() {
    let folder = folder("wheel_stress_models");
    let line = "wheel --terrain dry_sand --radius_m 0.3 --width_m 0.15 --load_N 245.25 --slip 0.3 --stress --model";
    for model in [
        "linear-stress",
        "ding-closed --set slip_exponent=0.3 --set c3=-0.2 --set lug_reach=0.01",
        "grouser-passive --set unit_weight=15000 --set lug_height=0.01 --set lug_count=24",
        "braked-two-zone",
        "scm-column",
    ] {
        let out = terra(&folder, &format!("{line} {model}")).ok().out;
        let rows = out.lines().filter(|l| l.starts_with("0.3,")).count();
        assert_eq!(rows, 1 + 101, "{model}");
    }
    for model in [
        "bekker-compaction",
        "wes-brixius --set cone_index=300000 --set deflection_ratio=0.1",
    ] {
        let refused = terra(&folder, &format!("{line} {model}"));
        assert_eq!(refused.code, 2, "{model}: {}", refused.err);
        assert!(refused.err.contains("no stresses"), "{}", refused.err);
    }
}

/// The second table holds both stresses along the rim; its largest pressure is that of the first table.
#[test]
fn stresses_go_beside_the_curve() {
    let folder = folder("wheel_stress");
    let line = "wheel --terrain dry_sand --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.1:0.3:0.1 --stress";
    terra(&folder, &format!("{line} --csv curve.csv")).ok();
    let curve = Csv::read(&folder.join("curve.csv"));
    let stress = Csv::read(&folder.join("curve.stress.csv"));
    assert_eq!(
        stress.header.join(","),
        "slip,angle_rad,normal_stress_Pa,shear_stress_Pa"
    );
    let largest = stress
        .full("normal_stress_Pa")
        .into_iter()
        .fold(0.0, f64::max);
    let expected = curve
        .full("max_normal_stress_Pa")
        .into_iter()
        .fold(0.0, f64::max);
    assert!(
        (largest / expected - 1.0).abs() < 1e-2,
        "{largest} along the rim, {expected} in the curve"
    );
    // Without a file both go to standard output, an empty line between.
    let both = terra(&folder, line).ok().out;
    let (first, second) = both.split_once("\n\n").unwrap();
    assert_eq!(
        format!("{first}\n"),
        std::fs::read_to_string(folder.join("curve.csv")).unwrap()
    );
    assert_eq!(
        second,
        std::fs::read_to_string(folder.join("curve.stress.csv")).unwrap()
    );
}

/// Magnitude 0 is the nominal model, bit for bit; another is not.
#[test]
fn effects_by_name() {
    let folder = folder("wheel_effects");
    let line = "wheel --terrain dry_sand --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.4 --model";
    let plain = terra(&folder, &format!("{line} wong-reece")).ok().out;
    let nothing = terra(
        &folder,
        &format!("{line} wong-reece:bekker:janosi-hanamoto+slip-sinkage=0"),
    )
    .ok()
    .out;
    let sunk = terra(&folder, &format!("{line} wong-reece+slip-sinkage=0.3"))
        .ok()
        .out;
    assert_eq!(plain, nothing);
    let (plain, sunk) = (Csv::parse(&plain), Csv::parse(&sunk));
    assert!(sunk.full("sinkage_m")[0] > plain.full("sinkage_m")[0]);
}

/// The figures of a page are files too, and their numbers are those of the table, in its columns.
#[test]
fn a_page_and_its_figures_hold_the_numbers_of_the_table() {
    let to = folder("wheel_page");
    terra(
        &to,
        "wheel --terrain dry_sand --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.1:0.9:0.1 --csv table.csv \
         --html page.html --figures figures",
    )
    .ok();
    let page = std::fs::read_to_string(to.join("page.html")).unwrap();
    let table = Csv::read(&to.join("table.csv"));
    for (file, column) in [
        ("drawbar-pull", "drawbar_pull_N"),
        ("torque", "torque_N_m"),
        ("sinkage", "sinkage_m"),
    ] {
        let name = format!("{file}-against-slip");
        let figure = Csv::read(&to.join(format!("figures/{name}.csv")));
        assert_eq!(figure.full("slip"), table.full("slip"));
        assert_eq!(figure.full(column), table.full(column));
        assert!(to.join(format!("figures/{name}.svg")).is_file());
        assert!(page.contains(&format!("data-file=\"{name}\"")));
    }
    // D/W, and D r (1 - s) / T where the wheel pulls.
    let pull = table.full("drawbar_pull_N");
    let coefficient = Csv::read(&to.join("figures/traction-coefficient-against-slip.csv"));
    for (c, pull) in coefficient.full("traction_coefficient").iter().zip(&pull) {
        assert!((c - pull / 245.25).abs() < 1e-12);
    }
    let efficiency = Csv::read(&to.join("figures/tractive-efficiency-against-slip.csv"));
    let pulling = pull.iter().filter(|p| **p > 0.0).count();
    assert!(pulling > 0 && pulling < pull.len());
    assert_eq!(efficiency.rows.len(), pulling);
    let last = *efficiency.full("tractive_efficiency").last().unwrap();
    let torque = *table.full("torque_N_m").last().unwrap();
    assert!((last - pull.last().unwrap() * 0.254 * 0.1 / torque).abs() < 1e-9);
    // A folder that cannot be is refused like any other output.
    let done = terra(
        &to,
        "wheel --terrain dry_sand --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.1 --figures table.csv",
    );
    assert_eq!((done.code, done.out.as_str()), (4, ""), "{}", done.err);
}

/// A file's soils stand beside those of the literature; an id that is in both is the file's.
#[test]
fn a_catalogue_of_ones_own() {
    let at = folder("wheel_catalogue");
    fs::write(
        at.join("mine.csv"),
        "id,set,name,n,kc_kN_m_n1,kphi_kN_m_n2,c_kPa,phi_deg,K_m,c1,c2,conf,source_note\n\
         bench,mine,our bench,1.0,1.5,900,0.4,31,0.015,NA,NA,user,our plate tests\n\
         dry_sand,mine,our dry sand,1.1,0.99,1528.43,1.04,28,0.02,0.38,0.41,user,our shear tests\n",
    )
    .unwrap();
    let line = "wheel --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.3";
    let pull = |rest: &str| {
        Csv::parse(&terra(&at, &format!("{line} {rest}")).ok().out).full("drawbar_pull_N")[0]
    };
    let law = Registry::builtin().law("wong-reece").unwrap();
    let expected = |p: &[f64]| {
        let wheel = Contact::new(0.3, 245.25, 0.254, 0.15);
        law.forces(p, &wheel).unwrap().drawbar_pull
    };
    let close = |found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    };
    // In the order k_c, k_phi, n, c, phi, K, c1, c2.
    let bench = [1500.0, 9e5, 1.0, 400.0, 31f64.to_radians(), 0.015, 0.5, 0.0];
    close(
        pull("--terrain bench --catalogue mine.csv"),
        expected(&bench),
    );
    let mut sand = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    close(pull("--terrain dry_sand"), expected(&sand));
    sand[5] = 0.02;
    close(
        pull("--terrain dry_sand --catalogue mine.csv"),
        expected(&sand),
    );
    let clay = catalogue::find("lean_clay_22")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    close(
        pull("--terrain lean_clay_22 --catalogue mine.csv"),
        expected(&clay),
    );
    // Both names of the option, over the file's value as over the built-in one.
    for name in ["--value", "--set"] {
        close(
            pull(&format!("--terrain dry_sand {name} shear_modulus=0.02")),
            expected(&sand),
        );
    }

    for (rest, code, says) in [
        (
            "--terrain bemch --catalogue mine.csv",
            2,
            "did you mean 'bench'",
        ),
        (
            "--terrain dry_sand --catalogue nowhere.csv",
            2,
            "nowhere.csv",
        ),
        (
            "--terrain dry_sand --catalogue mine.csv --csv mine.csv",
            2,
            "mine.csv",
        ),
        (
            "--terrain dry_sand --value shear_modulus=0.02 --value shear_modulus=0.03",
            2,
            "already",
        ),
        (
            "--terrain dry_sand --value shear_modulu=0.02",
            2,
            "did you mean 'shear_modulus'",
        ),
    ] {
        let done = terra(&at, &format!("{line} {rest}"));
        assert_eq!(done.code, code, "{rest}: {}", done.err);
        assert!(done.err.contains(says), "{rest}: {}", done.err);
    }
    let mine = fs::read_to_string(at.join("mine.csv")).unwrap();
    fs::write(
        at.join("bad.csv"),
        mine.replace(",user,our shear", ",sure,our shear"),
    )
    .unwrap();
    let done = terra(&at, &format!("{line} --terrain bench --catalogue bad.csv"));
    assert_eq!(done.code, 2);
    for part in ["bad.csv:3:12", "conf", "'sure'", "A, B, C or user"] {
        assert!(done.err.contains(part), "{part}: {}", done.err);
    }
}

/// Everything that is missing is named at once, each with its reason and with what to add.
#[test]
fn what_a_soil_does_not_give_has_a_reason() {
    let at = folder("wheel_missing");
    let line = "wheel --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.3 --terrain";
    for (rest, parts) in [
        (
            "mer_b_sandy_loam",
            &[
                "mer_b_sandy_loam",
                "its source gives none",
                "--value shear_modulus=VALUE (m)",
                "terra terrains",
            ][..],
        ),
        (
            "dry_sand --model compliant-tyre",
            &[
                "belongs to the wheel, not to the soil",
                "--value tyre_pressure=VALUE (Pa)",
            ],
        ),
        (
            "mer_b_sandy_loam --model grouser-passive",
            &[
                "shear_modulus",
                "its source gives none",
                "unit_weight",
                "no more",
                "lug_height",
                "lug_count",
                "belongs to the wheel",
            ],
        ),
    ] {
        let done = terra(&at, &format!("{line} {rest}"));
        assert_eq!(
            (done.code, done.out.as_str()),
            (2, ""),
            "{rest}: {}",
            done.err
        );
        for part in parts {
            assert!(done.err.contains(part), "{part}: {}", done.err);
        }
    }
    terra(
        &at,
        &format!("{line} mer_b_sandy_loam --value shear_modulus=0.01"),
    )
    .ok();
}

/// Every effect either changes what the wheel gives or is refused by name: sensors, the vehicle and its drivetrain, and what
/// acts by a path, a side, a turn or an earlier pass have no place on one wheel.
#[test]
fn effects_that_change_no_force_of_one_wheel_are_refused() {
    let at = folder("wheel_refused");
    // Heavy enough to sink to a lower layer.
    let line = "wheel --terrain dry_sand --radius_m 0.254 --width_m 0.15 --load_N 900 --slip 0.4 --model wong-reece";
    let elsewhere = "multipass terrain-drift lateral-contrast lateral-bulldozing skid-steer-lateral-slip \
        drivetrain-coulomb-friction drivetrain-viscous-friction torque-scale torque-bias torque-droop track-width-error \
        cg-offset mass-error ground-speed-scale ground-speed-bias ground-speed-delay accel-bias slope tow-load aero-drag \
        drawbar-gain drawbar-bias sinkage-bias yaw-rate-bias";
    let elsewhere: Vec<&str> = elsewhere.split_whitespace().collect();
    let plain = terra(&at, line).ok().out;
    for effect in Registry::builtin().effects() {
        let name = effect.name();
        let magnitude = 2.0 * effect.params()[0].prior_sd;
        let done = terra(&at, &format!("{line}+{name}={magnitude}"));
        if elsewhere.contains(&name) {
            assert_eq!((done.code, done.out.as_str()), (2, ""), "{name}");
            assert!(
                done.err.contains(name) && done.err.contains("terra simulate"),
                "{}",
                done.err
            );
        } else {
            assert_ne!(done.ok().out, plain, "{name}");
        }
    }
    let all = Registry::builtin();
    let known = |name: &&str| all.effect(name).is_ok();
    assert!(elsewhere.iter().all(known));
    let twice = terra(&at, &format!("{line}+slip-sinkage=0.1+slip-sinkage=0.2"));
    assert_eq!(twice.code, 2);
    assert!(twice.err.contains("slip-sinkage twice"), "{}", twice.err);
}
