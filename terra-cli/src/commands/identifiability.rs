//! `terra identifiability`: what a set of slips and loads could tell, and which rows would tell more.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::DMatrix;
use rayon::prelude::*;
use serde_json::{Value, json};
use terra_data::names_a_file;
use terra_mme::{
    Centre, Design, DesignNoise, EstimatorError, FitSpace, FurtherRow, Hypothesis, HypothesisSet,
    Identifiability, Priors, Profile, identifiability, profiles, separating_rows, separation,
};
use terra_model::catalogue::Terrain;
use terra_model::{Contact, ForceLaw, Law, ModelError, Registry, nearest};

use crate::args::{IdentifiabilityArgs, ReportArgs};
use crate::commands::wheel::{on_a_wheel, slips, with};
use crate::error::CliError;
use crate::output::{self, short, table};
use crate::report;
use crate::soils::{Soils, parameters, values};

/// Nats below which two soils are not told apart: odds of twenty to one.
const APART: f64 = 3.0;
/// Pairs listed on standard output.
const LISTED: usize = 10;
const CHANNELS: [&str; 5] = [
    "drawbar_pull_N",
    "torque_N_m",
    "sinkage_m",
    "slip",
    "normal_load_N",
];

/// Two soils and the nats between them.
struct Pair {
    a: String,
    b: String,
    nats: f64,
}

pub(crate) struct Answer {
    law: Arc<Law>,
    rows: usize,
    infeasible: usize,
    found: Identifiability,
    profiles: Vec<Profile>,
    /// Units of the profiled parameters.
    units: Vec<&'static str>,
    pairs: Vec<Pair>,
    soils: usize,
    /// True where the model takes nothing from the soils by which they differ.
    one: bool,
    /// Soils of the set that the model cannot be asked about, and why.
    left_out: Vec<(String, String)>,
    /// Values in place of the soils'.
    values: Vec<(String, f64)>,
    candidates: Vec<Contact<f64>>,
    sharper: Vec<FurtherRow>,
    separating: Vec<FurtherRow>,
}

/// What is asked.
pub(crate) struct Question {
    pub(crate) model: String,
    pub(crate) terrain: String,
    /// Soils of one's own.
    pub(crate) catalogue: Option<PathBuf>,
    /// Values in place of the soils'.
    pub(crate) values: Vec<(String, f64)>,
    pub(crate) radius: f64,
    pub(crate) widths: Vec<f64>,
    pub(crate) loads: Vec<f64>,
    pub(crate) slips: Vec<f64>,
    pub(crate) noise: DesignNoise,
    /// Soils that should be told apart.
    pub(crate) set: String,
    /// Further rows to propose.
    pub(crate) add: usize,
}

impl Question {
    fn of(args: &IdentifiabilityArgs) -> Result<Self, CliError> {
        let values = values(&args.value)?;
        Ok(Question {
            model: args.model.clone(),
            terrain: args.soil.terrain.clone(),
            catalogue: args.soil.catalogue.clone(),
            values: values.iter().map(|(n, v)| ((*n).to_owned(), *v)).collect(),
            radius: args.radius,
            widths: args.widths.clone(),
            loads: args.loads.clone(),
            slips: slips(&args.slip)?,
            noise: noise(&args.noise)?,
            set: args.set.clone(),
            add: usize::from(args.add),
        })
    }
}

pub(crate) fn run(args: &IdentifiabilityArgs) -> Result<(), CliError> {
    let set_file = names_a_file(&args.set).then(|| Path::new(&args.set));
    let inputs: Vec<&Path> = args
        .soil
        .catalogue
        .as_deref()
        .into_iter()
        .chain(set_file)
        .collect();
    output::claim_with(&args.report, &[args.json.as_deref()], &inputs)?;
    let asked = Question::of(args)?;
    let answer = ask_with(&asked, &args.report)?;
    if let Some(path) = &args.json {
        output::json(Some(path), &as_json(&asked, &answer))?;
    }
    output::stdout(&summary(args, &answer))
}

/// As [`ask`]; writes the report, where one was asked for.
pub(crate) fn ask_with(asked: &Question, report: &ReportArgs) -> Result<Answer, CliError> {
    let answer = ask(asked)?;
    output::report(report, || report::Page {
        title: "What could these rows tell?".to_owned(),
        subtitle: format!(
            "{} on {}{}",
            asked.model,
            asked.terrain,
            with(&asked.values)
        ),
        sections: vec![report::profiles_section(&report::ProfilesView {
            title: "Identifiability".to_owned(),
            lead: lead(&answer),
            undetermined: answer.found.undetermined.clone(),
            profiles: answer
                .profiles
                .iter()
                .zip(&answer.units)
                .map(|(p, unit)| (p.clone(), (*unit).to_owned()))
                .collect(),
        })],
        provenance: vec![("terra".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
    })?;
    Ok(answer)
}

/// `channel=sd,...`
pub(crate) fn noise(text: &str) -> Result<DesignNoise, CliError> {
    let mut noise = DesignNoise::default();
    for part in text.split(',').filter(|p| !p.trim().is_empty()) {
        let refused = |why: String| {
            CliError::usage(
                format!("--noise {}: {why}", part.trim()),
                "write for example drawbar_pull_N=0.5,torque_N_m=0.1,sinkage_m=0.001,slip=0.005",
            )
        };
        let (name, value) = part
            .trim()
            .split_once('=')
            .ok_or_else(|| refused("expected CHANNEL=SD".to_owned()))?;
        let sd = value
            .parse::<f64>()
            .ok()
            .filter(|v| v.is_finite() && *v >= 0.0)
            .ok_or_else(|| refused(format!("'{value}' is no sd")))?;
        match name {
            "drawbar_pull_N" => noise.drawbar_pull = Some(sd),
            "torque_N_m" => noise.torque = Some(sd),
            "sinkage_m" => noise.sinkage = Some(sd),
            "slip" => noise.slip = sd,
            "normal_load_N" => noise.normal_load = sd,
            _ => {
                let near = nearest(name, CHANNELS)
                    .map_or(format!("one of {}", CHANNELS.join(", ")), |n| {
                        format!("'{n}'")
                    });
                return Err(refused(format!(
                    "unknown channel '{name}', expected {near}"
                )));
            }
        }
    }
    Ok(noise)
}

fn contacts(asked: &Question, slips: &[f64], loads: &[f64]) -> Vec<Contact<f64>> {
    let mut all = vec![];
    for &width in &asked.widths {
        for &load in loads {
            all.extend(
                slips
                    .iter()
                    .map(|&slip| Contact::new(slip, load, asked.radius, width)),
            );
        }
    }
    all
}

fn ask(asked: &Question) -> Result<Answer, CliError> {
    let law = Arc::new(Registry::builtin().law(&asked.model)?);
    on_a_wheel(&law)?;
    let noise = asked.noise;
    let given: Vec<(&str, f64)> = asked.values.iter().map(|(n, v)| (n.as_str(), *v)).collect();
    let soils = Soils::open(asked.catalogue.as_deref())?;
    // Effects start at magnitude 0.
    let of = |soil: &Terrain| {
        let mut p = parameters(soil, law.model(), &given)?;
        p.resize(law.params().len(), 0.0);
        Ok::<_, CliError>(p)
    };
    let start = of(soils.find(&asked.terrain)?)?;
    let space = FitSpace::new(
        &law,
        Centre::Parameters(&start),
        &asked.widths,
        &Priors::default(),
    )
    .map_err(|e| match e {
        EstimatorError::NoPrior { parameter } => CliError::usage(
            format!("{parameter} is 0, around which there is no spread to ask with"),
            format!("give it a value above 0: --value {parameter}=VALUE in SI units"),
        ),
        other => other.into(),
    })?;
    let q = vec![0.0; space.dim()];
    let design = Design::new(&law, &space, noise)?;
    let rows = contacts(asked, &asked.slips, &asked.loads);
    let (jac, infeasible) = design.jacobian(&q, &rows)?;
    if infeasible == rows.len() {
        return Err(CliError::usage(
            format!("{} carries none of these loads", asked.terrain),
            "a lighter wheel, or another soil",
        ));
    }
    let found = identifiability(&space, &q, &jac)?;
    let profiles = profiles(&design, &q, &rows)?;

    // Rows that could be added: the whole range of slip, from half to twice the loads at hand.
    let grid: Vec<f64> = (0..=9).map(|k| 0.02 + 0.1 * f64::from(k)).collect();
    let least = asked.loads.iter().copied().fold(f64::INFINITY, f64::min);
    let most = asked.loads.iter().copied().fold(0.0, f64::max);
    let candidates = contacts(asked, &grid, &[0.5 * least, least, most, 2.0 * most]);
    let count = asked.add;
    let sharper = design.more_rows(&q, &rows, &candidates, count)?;

    let mut known = vec![];
    let mut left_out = vec![];
    for soil in soils.set(&asked.set)? {
        let parameters = of(&soil).map_err(|e| of_set(e, &asked.set))?;
        // A soil beyond the model's range is none under it: no exponent above 1.3 under bekker-compaction.
        let refused = rows
            .first()
            .and_then(|at| law.forces(&parameters, at).err());
        if let Some(why @ ModelError::Parameter { .. }) = refused {
            left_out.push((soil.id.to_string(), why.to_string()));
            continue;
        }
        known.push(Hypothesis {
            parameters,
            id: soil.id.to_string(),
            law: Arc::clone(&law),
        });
    }
    if let ([], [(_, why), ..]) = (known.as_slice(), left_out.as_slice()) {
        return Err(CliError::usage(
            format!(
                "--set {}: the model takes none of its soils: {why}",
                asked.set
            ),
            "another --set, another --model, or a --value within its range",
        ));
    }
    let alone = known
        .windows(2)
        .all(|pair| matches!(pair, [a, b] if a.parameters == b.parameters));
    let set = HypothesisSet::new(known)?;
    let all: Vec<(&Hypothesis, &Hypothesis)> = pairs_of(set.hypotheses());
    let nats = |pair: &(&Hypothesis, &Hypothesis), at: &Contact<f64>| {
        separation(&law, &noise, [&pair.0.parameters, &pair.1.parameters], at)
    };
    let stands = all
        .par_iter()
        .map(|pair| rows.iter().map(|at| nats(pair, at)).sum::<Result<f64, _>>())
        .collect::<Result<Vec<f64>, _>>()?;
    let alike: Vec<usize> = (0..all.len()).filter(|&k| stands[k] < APART).collect();
    let table = alike
        .par_iter()
        .map(|&k| {
            candidates
                .iter()
                .map(|at| nats(&all[k], at))
                .collect::<Result<Vec<f64>, _>>()
        })
        .collect::<Result<Vec<_>, _>>()?;
    let table = DMatrix::from_fn(alike.len(), candidates.len(), |r, c| table[r][c]);
    let stand: Vec<f64> = alike.iter().map(|&k| stands[k]).collect();
    let separating = if alike.is_empty() || alone {
        vec![]
    } else {
        separating_rows(&stand, &table, count)
    };
    let mut pairs: Vec<Pair> = alike
        .iter()
        .map(|&k| Pair {
            a: all[k].0.id.clone(),
            b: all[k].1.id.clone(),
            nats: stands[k],
        })
        .collect();
    pairs.sort_by(|x, y| x.nats.total_cmp(&y.nats));
    Ok(Answer {
        rows: rows.len(),
        soils: set.len(),
        one: alone && set.len() > 1,
        left_out,
        values: given.iter().map(|(n, v)| ((*n).to_owned(), *v)).collect(),
        law,
        infeasible,
        found,
        units: space.units(),
        profiles,
        pairs,
        candidates,
        sharper,
        separating,
    })
}

/// An error about a soil of the set, not about the one around which is asked.
fn of_set(error: CliError, set: &str) -> CliError {
    match error {
        CliError::Usage { message, help } => CliError::Usage {
            message: format!("--set {set}: {message}"),
            help: help.map(|h| format!("{h}; a --value holds for every soil of the set")),
        },
        other => other,
    }
}

fn pairs_of(all: &[Hypothesis]) -> Vec<(&Hypothesis, &Hypothesis)> {
    all.iter()
        .enumerate()
        .flat_map(|(k, a)| all.iter().skip(k + 1).map(move |b| (a, b)))
        .collect()
}

fn lead(answer: &Answer) -> String {
    format!(
        "{} rows determine {} of {} directions of the parameters of {}.",
        answer.rows - answer.infeasible,
        answer.found.rank,
        answer.profiles.len(),
        answer.law.model().name()
    )
}

fn end(value: Option<f64>) -> String {
    value.map_or("no end".to_owned(), short)
}

fn row(answer: &Answer, r: &FurtherRow, several: bool) -> Vec<String> {
    let Some(at) = answer.candidates.get(r.candidate) else {
        return vec![];
    };
    let mut cells = vec![short(at.slip), short(at.normal_load)];
    if several {
        cells.push(short(at.width));
    }
    cells.push(short(r.nats));
    cells
}

fn summary(args: &IdentifiabilityArgs, answer: &Answer) -> String {
    let mut out = format!("{}\n", lead(answer));
    if answer.infeasible > 0 {
        out.push_str(&format!(
            "{} rows lie beyond what {} carries\n",
            answer.infeasible, args.soil.terrain
        ));
    }
    for u in &answer.found.undetermined {
        out.push_str(&format!("  cannot be known: {u}\n"));
    }
    out.push('\n');
    let directions: Vec<Vec<String>> = answer
        .found
        .directions
        .iter()
        .map(|d| {
            let parts: Vec<String> = d
                .combination
                .iter()
                .map(|(name, w)| format!("{w:+.2} {name}"))
                .collect();
            vec![short(d.sd_ln), parts.join(" ")]
        })
        .collect();
    out.push_str(&table(&["sd of ln", "direction"], &directions));
    out.push('\n');
    let rows: Vec<Vec<String>> = answer
        .profiles
        .iter()
        .map(|p| vec![p.name.to_owned(), end(p.low), end(p.high)])
        .collect();
    out.push_str(&table(
        &["parameter", "95 % from", "to, without prior"],
        &rows,
    ));
    out.push('\n');
    for (soil, why) in &answer.left_out {
        out.push_str(&format!("{soil} of {} is left out: {why}\n", args.set));
    }
    if answer.one {
        out.push_str(&format!(
            "the {} soils in {} differ in no parameter of {}: no row tells them apart\n",
            answer.soils,
            args.set,
            answer.law.model().name()
        ));
    } else {
        out.push_str(&format!(
            "{} pairs of {} soils in {} stay within {APART} nats\n",
            answer.pairs.len(),
            answer.soils,
            args.set
        ));
    }
    let listed = if answer.one { 0 } else { LISTED };
    for p in answer.pairs.iter().take(listed) {
        out.push_str(&format!("  {} ~ {} ({} nats)\n", p.a, p.b, short(p.nats)));
    }
    let several = args.widths.len() > 1;
    let head = |last| {
        let mut head = vec!["slip", "load N"];
        if several {
            head.push("width m");
        }
        head.push(last);
        head
    };
    for (title, rows, last) in [
        (
            "rows that would sharpen the parameters most",
            &answer.sharper,
            "nats gained",
        ),
        (
            "rows that would tell those soils apart",
            &answer.separating,
            "nats of the worst pair",
        ),
    ] {
        if rows.is_empty() {
            continue;
        }
        out.push_str(&format!("\n{title}\n"));
        let cells: Vec<Vec<String>> = rows.iter().map(|r| row(answer, r, several)).collect();
        out.push_str(&table(&head(last), &cells));
    }
    out
}

pub(crate) fn as_json(asked: &Question, answer: &Answer) -> Value {
    let further = |rows: &[FurtherRow]| -> Vec<Value> {
        rows.iter()
            .filter_map(|r| {
                let at = answer.candidates.get(r.candidate)?;
                Some(json!({ "slip": at.slip, "normal_load_N": at.normal_load, "width_m": at.width, "nats": r.nats }))
            })
            .collect()
    };
    json!({
        "schema": "terra-identifiability/1",
        "model": asked.model, "terrain": asked.terrain,
        "values": answer.values.iter().map(|(n, v)| (n.clone(), json!(v))).collect::<serde_json::Map<_, _>>(),
        "rows": { "asked": answer.rows, "no_equilibrium": answer.infeasible },
        "rank": answer.found.rank,
        "parameters": answer.profiles.len(),
        "undetermined": answer.found.undetermined,
        "directions": answer.found.directions.iter().map(|d| json!({
            "combination": d.combination.iter().map(|(n, w)| ((*n).to_owned(), json!(w))).collect::<serde_json::Map<_, _>>(),
            "sd_ln": d.sd_ln, "sd_over_prior": d.sd_ratio,
        })).collect::<Vec<_>>(),
        "profiles": answer.profiles.iter().map(|p| json!({
            "parameter": p.name, "lo": p.low, "hi": p.high,
            "points": p.points.iter().map(|(x, d)| json!([x, d])).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "alike": answer.pairs.iter().map(|p| json!({ "soils": [p.a, p.b], "nats": p.nats })).collect::<Vec<_>>(),
        "left_out": answer.left_out.iter().map(|(soil, why)| json!({ "soil": soil, "reason": why })).collect::<Vec<_>>(),
        "more_rows": { "sharpen": further(&answer.sharper), "separate": further(&answer.separating) },
        "provenance": { "terra": env!("CARGO_PKG_VERSION") },
    })
}
