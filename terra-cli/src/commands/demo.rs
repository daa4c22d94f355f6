//! `terra demo`: the main job end to end on embedded input.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;
use terra_data::{
    Condition, FilterSettings, GapSettings, Measured, Noise, RigLog, RigRow, Rover, SoilSharing,
    Start, TerrainSettings, WheelData, write_drive_log_to, write_rig_log_to,
};
use terra_gap::{HoldOut, Provenance, Settings, diagnose_rig, to_json};
use terra_mme::HypothesisSet;
use terra_model::{Registry, catalogue};
use terra_sim::{paper, simulate_drive};

use crate::args::ReportArgs;
use crate::commands::{gap, identify, identify_view};
use crate::error::CliError;
use crate::identify::{IdentifyOptions, identify_drive_among, to_json as identify_json};
use crate::input::sha256;
use crate::output;
use crate::progress::Spinner;
use crate::report::{self, GapCurves};

/// Ding et al. 2011: smooth rigid wheel, 80 N. Slip, drawbar pull \[N\], sinkage \[mm\], torque \[N m\], read off figures 8
/// and 9.
///
/// L. Ding, H. Gao, Z. Deng, K. Nagatani, K. Yoshida, "Experimental study and analysis on driving wheels' performance for
/// planetary exploration rovers moving in deformable soil", J. Terramechanics 48(1):27-45, 2011.
const DING_2011: [[f64; 4]; 6] = [
    [0.0, -6.5, 5.0, 0.0],
    [0.1, 11.0, 5.5, 3.0],
    [0.2, 14.5, 7.5, 4.2],
    [0.3, 15.0, 10.0, 4.8],
    [0.4, 15.0, 12.5, 5.0],
    [0.6, 15.0, 17.5, 5.3],
];
const CITATION: &str =
    "L. Ding et al., J. Terramechanics 48(1):27-45, 2011, figures 8 and 9 (smooth wheel, 80 N)";
const SOIL: &str = "lean_clay_22";

pub(crate) fn run(out: &Path, figures: Option<PathBuf>, quiet: bool) -> Result<(), CliError> {
    output::stdout(&make(out, figures, quiet)?.said)
}

/// What the demonstration gave.
pub(crate) struct Demo {
    pub(crate) identify: Value,
    pub(crate) verdict: Value,
    /// For a person.
    said: String,
}

/// Runs it and writes its files.
pub(crate) fn make(out: &Path, figures: Option<PathBuf>, quiet: bool) -> Result<Demo, CliError> {
    std::fs::create_dir_all(out).map_err(|reason| CliError::Write {
        target: out.display().to_string(),
        reason,
    })?;
    let files = ["identify.json", "verdict.json", "report.html"].map(|name| out.join(name));
    let report = ReportArgs {
        html: Some(files[2].clone()),
        figures,
    };
    output::claim_with(&report, &[Some(&files[0]), Some(&files[1])], &[])?;
    let registry = Registry::builtin();

    let spinner = Spinner::start(
        quiet,
        "simulating a drive on lean clay and identifying the soil",
    );
    let rover = paper::light_rover();
    let run = simulate_drive(&paper::torque_ramp(SOIL, 1)?, &rover, &registry)?;
    let options = IdentifyOptions {
        history: true,
        ..IdentifyOptions::default()
    };
    let law = Arc::new(registry.law(&rover.terrain.model)?);
    let soils = HypothesisSet::from_terrains(&law, &catalogue::set("wong21")?)?;
    let id = identify_drive_among(&run.log, &rover, &registry, &soils, &options)?;
    drop(spinner);
    let mut log_bytes = vec![];
    // Writing to memory cannot fail.
    let _ = write_drive_log_to(&mut log_bytes, &run.log);
    let rover_text = format!("{rover:?}");

    let mut text = format!(
        "1. What soil is it? A simulated drive of the robot of Ray 2008 on {SOIL}: 2 s, torque ramped down.\n\n"
    );
    for g in &id.groups {
        text.push_str(&over_time(g));
    }
    text.push('\n');
    text.push_str(&identify::summary(&id));

    let spinner = Spinner::start(quiet, "diagnosing a measured gap");
    let (log, rig) = ding();
    let settings = Settings {
        hold_out: Some(HoldOut::Slip),
        ..Settings::of(&rig)
    };
    let (diagnosis, predictor) = diagnose_rig(&log, &rig, &registry, &settings)?;
    let curves = GapCurves::of_rig(&diagnosis, &predictor);
    drop(spinner);
    let mut rig_bytes = vec![];
    let _ = write_rig_log_to(&mut rig_bytes, &log);
    let provenance = Provenance {
        log_sha256: sha256(&rig_bytes),
        rover_sha256: sha256(format!("{rig:?}").as_bytes()),
        seed: 0,
    };

    text.push_str(&format!(
        "\n2. Where does the simulator differ from reality? Measured: {CITATION}.\n   Nominal simulator: Wong-Reece with that paper's own soil.\n\n"
    ));
    text.push_str(&gap::summary(&diagnosis));

    let log_sha = sha256(&log_bytes);
    let page = report::Page {
        title: "terra demo".to_owned(),
        subtitle: "A soil identified from a simulated drive, and a measured gap diagnosed"
            .to_owned(),
        sections: vec![
            report::identify_section(&identify_view::view(
                &id,
                &identify_view::Context {
                    title: "What soil is it? The robot of Ray 2008 on lean clay, simulated",
                    truth: Some(SOIL),
                    set: &soils,
                    rover: &rover,
                    measured: None,
                },
            )),
            report::gap_section(&diagnosis, Some(&curves)),
        ],
        provenance: vec![
            ("terra".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("measured data".to_owned(), CITATION.to_owned()),
            ("simulated log SHA-256".to_owned(), log_sha.clone()),
            (
                "measured table SHA-256".to_owned(),
                provenance.log_sha256.clone(),
            ),
        ],
    };
    let identify = identify_json(&id, &log_sha, &sha256(rover_text.as_bytes()));
    let verdict = to_json(&diagnosis, &provenance);
    output::json(Some(&files[0]), &identify)?;
    output::json(Some(&files[1]), &verdict)?;
    output::report(&report, || page)?;
    text.push_str("\nwritten:\n");
    for file in &files {
        text.push_str(&format!("  {}\n", file.display()));
    }
    if let Some(folder) = &report.figures {
        text.push_str(&format!("  {} (figures)\n", folder.display()));
    }
    Ok(Demo {
        identify,
        verdict,
        said: text,
    })
}

/// The posterior at a few moments, a line each.
fn over_time(g: &crate::identify::Group) -> String {
    let Some(h) = &g.history else {
        return String::new();
    };
    let mut out = format!("{}: posterior over time\n", g.name);
    for &k in &[0usize, 1, 2, 4, 9, 19, 49, usize::MAX] {
        let k = k.min(h.step.len().saturating_sub(1));
        let Some(p) = h.probability.get(k) else {
            continue;
        };
        let mut order: Vec<usize> = (0..p.len()).collect();
        order.sort_by(|&a, &b| p[b].total_cmp(&p[a]));
        let best: Vec<String> = order
            .iter()
            .take(3)
            .map(|&j| format!("{} {:.3}", h.ids[j], p[j]))
            .collect();
        out.push_str(&format!(
            "  sample {:>3} ({:.2} s): {}\n",
            h.step[k],
            h.time[k],
            best.join(", ")
        ));
    }
    out
}

/// The published table as a rig log, and the paper's own soil as the nominal simulator.
fn ding() -> (RigLog, Rover) {
    let measured = |value| Measured { value, sd: None };
    let rows = DING_2011
        .iter()
        .zip(1u64..)
        .map(|([slip, pull, sinkage, torque], line)| RigRow {
            line,
            trial: format!("slip {slip}"),
            condition: "smooth".to_owned(),
            pass: 1,
            time: None,
            slip: measured(*slip),
            normal_load: measured(80.0),
            drawbar_pull: Some(measured(*pull)),
            torque: Some(measured(*torque)),
            sinkage: Some(measured(sinkage * 1e-3)),
            side_force: None,
            slip_angle: None,
            travel_speed: None,
            wheel_speed: None,
        })
        .collect();
    let wheel = WheelData {
        radius: 0.157_35,
        width: 0.165,
        inertia: 0.0,
        damping: 0.0,
        grouser_height: 0.0,
        grouser_count: 0,
    };
    // Reading a printed curve is good to about 1 N, .2 N m and .5 mm; the rig holds slip to .005 and load to 1 %.
    let noise = [
        ("drawbar_pull_N", 1.0),
        ("torque_N_m", 0.2),
        ("sinkage_m", 0.0005),
        ("slip", 0.005),
        ("normal_load_N", 0.8),
    ];
    let rover = Rover {
        vehicle: None,
        wheel,
        drivetrain: None,
        terrain: TerrainSettings {
            model: "wong-reece".to_owned(),
            hypotheses: "wong21".to_owned(),
            start: Some(Start::Id("hit_lss1".to_owned())),
            prior_sd: BTreeMap::new(),
            prior_abs_sd: BTreeMap::new(),
        },
        conditions: BTreeMap::from([(
            "smooth".to_owned(),
            Condition {
                wheel,
                soil: SoilSharing::Shared,
            },
        )]),
        filter: FilterSettings::default(),
        gap: GapSettings::default(),
        noise: Noise(noise.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect()),
        columns: BTreeMap::new(),
    };
    (
        RigLog {
            rows,
            ..RigLog::default()
        },
        rover,
    )
}
