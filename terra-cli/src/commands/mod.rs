//! One file a command.

pub(crate) mod bevameter;
pub(crate) mod campaign;
pub(crate) mod campaign_cross;
pub(crate) mod campaign_gap;
pub(crate) mod challenge;
pub(crate) mod challenge_run;
pub(crate) mod cite;
pub(crate) mod demo;
pub(crate) mod estimate;
mod estimate_view;
pub(crate) mod export;
pub(crate) mod gap;
pub(crate) mod gap_case;
pub(crate) mod gap_watch;
pub(crate) mod identifiability;
pub(crate) mod identify;
mod identify_view;
pub(crate) mod import;
pub(crate) mod init;
pub(crate) mod inspect;
pub(crate) mod lists;
mod pages;
pub(crate) mod simulate;
pub(crate) mod sweep;
pub(crate) mod wheel;

use clap::CommandFactory;

use crate::args::{Args, Campaign, Challenge, Command};
use crate::error::CliError;
use crate::output;

/// Runs one command.
pub(crate) fn dispatch(args: Args) -> Result<(), CliError> {
    if let Some(n) = args.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(n.into())
            .build_global()
            .map_err(|e| CliError::usage(e.to_string(), "leave --threads out"))?;
    }
    let quiet = args.quiet;
    match args.command {
        Command::Demo { out, figures } => demo::run(&out, figures, quiet),
        Command::Models { json } => lists::models(json),
        Command::Effects { json } => lists::effects(json),
        Command::Terrains { json } => lists::terrains(json),
        Command::Filters { json } => lists::filters(json),
        Command::Estimators { json } => lists::estimators(json),
        Command::Wheel(args) => wheel::run(&args),
        Command::Bevameter(args) => bevameter::run(&args),
        Command::Inspect { log, rover, json } => {
            inspect::run(&log, rover.as_deref(), json.as_deref())
        }
        Command::Init { class, out, force } => init::run(class, &out, force),
        Command::Cite { file, json } => cite::run(&file, json),
        Command::Simulate {
            scenario,
            out,
            list,
            truth,
            seed,
        } => match (scenario, out) {
            (Some(scenario), Some(out)) if !list => {
                simulate::run(&scenario, &out, truth.as_deref(), seed, quiet)
            }
            _ => simulate::list(),
        },
        Command::Estimate {
            log,
            rover,
            filter,
            smooth,
            out,
            report,
        } => {
            let asked = estimate::Asked {
                log: &log,
                rover: &rover,
                filter: &filter,
                smooth,
                out: out.as_deref(),
                report: &report,
            };
            estimate::run(&asked, quiet)
        }
        Command::Identify(args) => identify::run(&args, quiet),
        Command::Identifiability(args) => identifiability::run(&args),
        Command::Gap(args) => gap::run(&args, quiet),
        Command::Export(what) => export::run(&what),
        Command::Import {
            kind,
            source,
            out,
            map,
        } => import::run(kind, &source, &out, map.as_deref()),
        Command::Campaign(Campaign::Ramps {
            runs,
            seed,
            terrains,
            json,
        }) => campaign::run_ramps(&terrains, runs as usize, seed, json.as_deref(), quiet),
        Command::Campaign(Campaign::Faults {
            runs,
            seed,
            filter,
            json,
        }) => campaign::run_faults(runs as usize, seed, &filter, json.as_deref(), quiet),
        Command::Campaign(Campaign::Gap {
            cases,
            left_out,
            json,
        }) => campaign_gap::run(&cases, left_out, json.as_deref(), quiet),
        Command::Campaign(Campaign::CrossStructure {
            design,
            cases,
            seed,
            out,
            json,
        }) => campaign_cross::run(&design, cases as usize, seed, &out, json.as_deref(), quiet),
        Command::Campaign(Campaign::GapCalibration { cases, nulls }) => {
            campaign_gap::run_calibration(&cases, nulls, quiet)
        }
        Command::Challenge(Challenge::Make(args)) => challenge::run_make(&args, quiet),
        Command::Challenge(Challenge::Run { folder, out }) => {
            challenge_run::run(&folder, &out, quiet)
        }
        Command::Challenge(Challenge::Score(args)) => challenge::run_score(&args, quiet),
        Command::Challenge(Challenge::Reveal { key, folder }) => {
            challenge::run_reveal(&key, &folder)
        }
        Command::Sweep { plan, shard, out } => sweep::run(&plan, shard.as_deref(), &out, quiet),
        Command::Merge { files, out } => sweep::merge(&files, out.as_deref()),
        Command::Campaign(Campaign::Reproduction {
            runs,
            seed,
            tables,
            json,
        }) => campaign::run_reproduction(runs as usize, seed, &tables, json.as_deref(), quiet),
        Command::Pages { out } => pages::run(&out),
        Command::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Args::command(), "terra", &mut text);
            output::stdout(&String::from_utf8_lossy(&text))
        }
        Command::Man { command } => man(command.as_deref()),
    }
}

/// The manual page of the command, or of one of its commands.
fn man(of: Option<&str>) -> Result<(), CliError> {
    let mut all = Args::command();
    all.build();
    let page = match of {
        None => all,
        Some(name) => all.find_subcommand(name).cloned().ok_or_else(|| {
            CliError::usage(format!("no command '{name}'"), "`terra --help` lists them")
        })?,
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page)
        .render(&mut text)
        .map_err(|reason| CliError::Write {
            target: "the manual page".to_owned(),
            reason,
        })?;
    output::stdout(&String::from_utf8_lossy(&text))
}
