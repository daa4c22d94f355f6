#![allow(
    missing_docs,
    clippy::all,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout
)]
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use rayon::prelude::*;
use std::io::Write;
use std::path::Path;
use std::sync::Mutex;
use terra_data::{Start, read_rover};
use terra_gap::{Settings, diagnose_drive};
use terra_mme::{Centre, FitSpace, Priors};
use terra_model::{Law, Registry, Scope, catalogue};
use terra_sim::{EffectSetting, Scenario, simulate_drive};

fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n: u64 = a[1].parse().unwrap();
    let seed: u64 = a[2].parse().unwrap();
    let scenario_path = Path::new(&a[3]);
    let only: Option<u64> = a.get(5).map(|s| s.parse().unwrap());
    let base = Scenario::read(scenario_path).unwrap();
    let rover0 = read_rover(&base.rover_path(scenario_path)).unwrap();
    let registry = Registry::builtin();
    let soils = [
        "dry_sand",
        "upland_sandy_loam",
        "lean_clay_22",
        "sandy_loam_mich_11",
        "rubicon",
        "north_gower",
        "sandy_loam_22",
        "clayey_55",
    ];
    let soils: Vec<&str> = soils
        .into_iter()
        .filter(|s| catalogue::find(s).is_ok())
        .collect();
    let names: Vec<(String, f64, bool, f64)> = registry
        .effects()
        .iter()
        .filter(|e| !matches!(e.scope(), Scope::Rig))
        .map(|e| {
            let p = e.params()[0];
            (e.name().to_string(), p.prior_sd, p.one_sided(), p.max)
        })
        .collect();
    let out = Mutex::new(std::fs::File::create(&a[4]).unwrap());
    let cases: Vec<u64> = match only {
        Some(k) => vec![k],
        None => (0..n).collect(),
    };
    cases.into_par_iter().for_each(|run| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(run);
        let unit: Normal<f64> = Normal::new(0.0, 1.0).unwrap();
        for attempt in 0..20 {
            let mut s = base.clone();
            s.effects.clear();
            s.seed = seed; s.run = run;
            let soil = soils[rng.random_range(0..soils.len())];
            let mut rover = rover0.clone();
            rover.terrain.start = Some(Start::Id(soil.to_string()));
            let law: Law = registry.law("wong-reece").unwrap();
            let space = FitSpace::new(&law, Centre::Terrain(catalogue::find(soil).unwrap()), &[rover.wheel.width], &Priors::default()).unwrap();
            let q: Vec<f64> = space.prior_sd().iter().map(|sd| sd * unit.sample(&mut rng)).collect();
            let p = space.physical(&q);
            let map = space.names().iter().zip(&p).map(|(n, v)| (n.to_string(), *v)).collect();
            s.left = Start::Values(map); s.right = s.left.clone();
            let u: f64 = rng.random();
            let count = if u < 0.2 { 0 } else if u < 0.8 { 1 } else { 2 };
            let mut picked: Vec<usize> = vec![];
            while picked.len() < count { let k = rng.random_range(0..names.len()); if !picked.contains(&k) { picked.push(k); } }
            let mut truth = vec![];
            for k in picked {
                let (name, sd, one, max) = &names[k];
                let m: f64 = rng.random_range(0.3..2.0) * sd;
                let m = if *one { m.min(max * 0.95) } else if rng.random::<bool>() { m } else { -m };
                truth.push((name.clone(), m));
                s.effects.push(EffectSetting::new(name.as_str(), m));
            }
            let Ok(run_) = simulate_drive(&s, &rover, &registry) else { continue };
            let settings = Settings::of(&rover);
            let t = std::time::Instant::now();
            if std::env::var("TRUTH").is_ok() { for r in run_.truth.columns() { eprintln!("{}", r.name); } }
            let line = match diagnose_drive(&run_.log, &rover, &registry, &settings) {
                Ok(d) => {
                    if only.is_some() { if let Some((_, f)) = &d.null {
                        let mut at = 0; let nc = d.data.channels.len();
                        let mut by = vec![(0.0, 0usize); nc];
                        let mut wins = vec![];
                        for o in &d.data.observations { let mut w = 0.0; for &c in &o.channels { let r = f.residual[at]; by[c].0 += r*r; by[c].1 += 1; w += r*r; at += 1; } wins.push((w, o.group.clone(), o.place.clone())); }
                        for (c, b) in d.data.channels.iter().zip(&by) { println!("{} {:.3} {}", c.name, b.0 / b.1 as f64, b.1); }
                        let mut g: std::collections::BTreeMap<String, (f64, usize)> = Default::default();
                        for w in &wins { let e = g.entry(w.1.clone()).or_default(); e.0 += w.0; e.1 += 7; }
                        for (k, e) in g { println!("  {k} {:.3} {}", e.0 / e.1 as f64, e.1); }
                        wins.sort_by(|a, b| b.0.total_cmp(&a.0));
                        for w in wins.iter().take(12) { println!("    {:?}", w); }
                        println!("{:?}", d.data.notes);
                        println!("x {:?}", f.x.as_slice());
                    } }
                    let causes: Vec<_> = d.causes.iter().map(|c| serde_json::json!({"n": c.name, "p": c.probability, "g": c.log_evidence_gain, "pg": c.weighed.plain_log_evidence, "lam": c.power, "chi2": c.weighed.chi2_per_value(), "alike": c.indistinguishable_from, "f": c.form})).collect();
                    serde_json::json!({"run": run, "attempt": attempt, "soil": soil, "truth": truth, "verdict": d.verdict, "reason": d.reason, "set": d.set, "none": d.probability_none, "unknown": d.probability_unknown, "causes": causes,
                    "screen": d.screen.iter().map(|x| serde_json::json!({"n": x.name, "b": x.score.log_bayes_factor, "h": x.score.information, "m": x.score.magnitude})).collect::<Vec<_>>(),
                    "wf": [d.waterfall.as_given, d.waterfall.refitted, d.waterfall.after], "held": d.held_out.as_ref().map(|h| h.closed.as_ref().map(|c| [c.mean, c.lo, c.hi])), "n": d.data.observations.len(), "dropped": d.data.dropped, "t": t.elapsed().as_secs_f64()})
                }
                Err(e) => serde_json::json!({"run": run, "soil": soil, "truth": truth, "verdict": "error", "reason": e.to_string()}),
            };
            let mut f = out.lock().unwrap();
            writeln!(f, "{line}").unwrap();
            return;
        }
        eprintln!("run {run}: no case");
    });
}
