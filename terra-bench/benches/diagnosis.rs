//! A whole diagnosis: the published table of a smooth wheel against Wong-Reece with that paper's own soil.
//!
//! # Reference
//! L. Ding, H. Gao, Z. Deng, K. Nagatani, K. Yoshida, "Experimental study and analysis on driving wheels' performance
//! for planetary exploration rovers moving in deformable soil", J. Terramechanics 48(1):27-45, 2011, figures 8 and 9. Its
//! finding: sinkage grows with slip far beyond what the classical model gives.
#![allow(missing_docs)] // the macros of criterion make items of their own
#![allow(clippy::unwrap_used)] // a wrong answer ends the bench

use std::collections::BTreeMap;
use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use terra_data::{
    Condition, FilterSettings, GapSettings, Measured, Noise, RigLog, RigRow, Rover, SoilSharing,
    Start, TerrainSettings, WheelData,
};
use terra_gap::{Diagnosis, HoldOut, Settings, diagnose_rig};
use terra_model::Registry;

/// Slip, drawbar pull \[N\], sinkage \[mm\], torque \[N m\] at 80 N.
const MEASURED: [[f64; 4]; 6] = [
    [0.0, -6.5, 5.0, 0.0],
    [0.1, 11.0, 5.5, 3.0],
    [0.2, 14.5, 7.5, 4.2],
    [0.3, 15.0, 10.0, 4.8],
    [0.4, 15.0, 12.5, 5.0],
    [0.6, 15.0, 17.5, 5.3],
];

fn log() -> RigLog {
    let measured = |value| Measured { value, sd: None };
    let rows = MEASURED
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
    RigLog {
        rows,
        ..RigLog::default()
    }
}

fn rig() -> Rover {
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
    let soil = SoilSharing::Shared;
    Rover {
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
        conditions: BTreeMap::from([("smooth".to_owned(), Condition { wheel, soil })]),
        filter: FilterSettings::default(),
        gap: GapSettings::default(),
        noise: Noise(noise.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect()),
        columns: BTreeMap::new(),
    }
}

/// The paper's finding must be among the answers, probabilities must be probabilities, and the gap must shrink.
fn check(d: &Diagnosis) {
    let single: f64 = d.causes.iter().map(|c| c.probability).sum();
    let total = single + d.probability_none + d.probability_unknown;
    assert!((total - 1.0).abs() < 1e-9, "probabilities sum to {total}");
    let names = |set: &[String]| {
        set.iter()
            .any(|s| s.split('+').any(|e| e == "slip-sinkage"))
    };
    assert!(
        names(&d.set) || names(&d.nearest),
        "slip-sinkage is not among the answers: {} {:?}, nearest {:?}",
        d.verdict,
        d.set,
        d.nearest
    );
    let (given, refitted) = (d.waterfall.as_given.unwrap(), d.waterfall.refitted.unwrap());
    assert!(refitted < given, "re-fitting made {refitted} of {given}");
}

fn diagnosis(c: &mut Criterion) {
    let (log, rig, registry) = (log(), rig(), Registry::builtin());
    let settings = Settings {
        hold_out: Some(HoldOut::Slip),
        ..Settings::of(&rig)
    };
    let mut group = c.benchmark_group("diagnosis");
    group.sampling_mode(SamplingMode::Flat);
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(30));
    group.bench_function("ding_2011_smooth_wheel", |b| {
        let mut last = None;
        b.iter(|| last = Some(diagnose_rig(black_box(&log), &rig, &registry, &settings).unwrap()));
        check(&last.unwrap().0);
    });
    group.finish();
}

criterion_group!(benches, diagnosis);
criterion_main!(benches);
