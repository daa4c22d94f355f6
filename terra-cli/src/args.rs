//! The command line.

use std::path::PathBuf;

use clap::{ArgAction, Parser, Subcommand, ValueEnum};

/// What forces does the ground give each wheel, what soil is it, and which unmodelled effect makes the simulator differ
/// from reality?
#[derive(Debug, Parser)]
#[command(
    name = "terra",
    version,
    arg_required_else_help = true,
    max_term_width = 100
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// No progress display.
    #[arg(long, global = true, action = ArgAction::SetTrue)]
    pub(crate) quiet: bool,
    /// Threads to use (default: all cores). The result does not depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// The main job end to end: identify a soil from a simulated drive, then diagnose a measured gap.
    ///
    /// Needs no input. Writes report.html, verdict.json and identify.json.
    Demo {
        /// Folder for the results.
        #[arg(long, default_value = "terra-demo")]
        out: PathBuf,
        /// Folder for each figure of the report as SVG, and its numbers as CSV.
        #[arg(long, value_name = "DIR")]
        figures: Option<PathBuf>,
    },
    /// Terrain models: what they are, their parameters and sources.
    Models {
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// Unmodelled effects a diagnosis can name: where each shows, what isolates it.
    Effects {
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// Soils of the literature, with source and how far to trust each.
    Terrains {
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// Filters that estimate wheel forces.
    Filters {
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// Estimators that weigh soils.
    Estimators {
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// Force-slip curve of one wheel on a known soil.
    ///
    /// Example: terra wheel --terrain dry_sand --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.05:0.95:0.05
    Wheel(WheelArgs),
    /// Soil from plates pressed into it or from shear tests.
    ///
    /// Every pressure-sinkage or shear law is compared, and what the tests cannot tell is said by name.
    Bevameter(BevameterArgs),
    /// What is in a log, and what in it looks wrong: units, signs, sides, clock.
    ///
    /// Works without a rover file on a log in terra's own column names; with one it knows radius, track and units. A drive
    /// log may be longer than memory.
    Inspect {
        /// Drive or rig log (CSV).
        log: PathBuf,
        /// The vehicle or rig (TOML).
        #[arg(long)]
        rover: Option<PathBuf>,
        /// JSON to write.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// A commented rover file to start from: published figures, guesses marked.
    Init {
        /// Which robot or rig.
        class: ClassArg,
        /// File to write (TOML).
        #[arg(long, default_value = "rover.toml")]
        out: PathBuf,
        /// Overwrite it.
        #[arg(long)]
        force: bool,
    },
    /// The references owed for what a scenario or a rover file uses.
    Cite {
        /// Scenario or rover file (TOML).
        file: PathBuf,
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// Makes a log with known truth from a scenario file.
    Simulate {
        /// Scenario (TOML).
        #[arg(required_unless_present = "list")]
        scenario: Option<PathBuf>,
        /// Log to write (CSV).
        #[arg(long, required_unless_present = "list")]
        out: Option<PathBuf>,
        /// List the effects and forms that only the simulator has, beside those of `terra effects`.
        #[arg(long, exclusive = true)]
        list: bool,
        /// Also write the noise-free truth (CSV).
        #[arg(long)]
        truth: Option<PathBuf>,
        /// Replaces the scenario's seed.
        #[arg(long, allow_negative_numbers = true)]
        seed: Option<u64>,
    },
    /// What forces does the ground give each wheel? No soil model needed.
    ///
    /// The log is read twice and the table written on the way, in memory that does not grow with the log. --smooth, --html
    /// and --figures hold the log and its states in memory; a log that comes through a pipe is held as it is.
    Estimate {
        /// Drive log (CSV).
        log: PathBuf,
        /// The vehicle (TOML).
        #[arg(long)]
        rover: PathBuf,
        /// Filter: see `terra filters`.
        #[arg(long, default_value = "block")]
        filter: String,
        /// Use the whole log for every instant (Rauch-Tung-Striebel).
        #[arg(long)]
        smooth: bool,
        /// File to write (CSV; standard output when absent).
        #[arg(long)]
        out: Option<PathBuf>,
        #[command(flatten)]
        report: ReportArgs,
    },
    /// What soil is it? Posterior over hypotheses, refined parameters, and what this log cannot tell.
    Identify(IdentifyArgs),
    /// What could a set of slips and loads tell about a soil?
    ///
    /// Directions known and unknown, profile likelihoods, soils that stay alike, and the rows that would help most.
    /// Example: terra identifiability --terrain dry_sand --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.05:0.8:0.15
    /// --noise drawbar_pull_N=0.5,torque_N_m=0.1
    Identifiability(IdentifiabilityArgs),
    /// Where does my simulator differ from reality, what causes it, how far does the gap shrink?
    Gap(GapArgs),
    /// Known data sets and formats to a log.
    ///
    /// Example: terra import norlab-drive husky_windows.parquet --out husky.csv
    ///
    /// A bag needs to be told which field of which topic each column is: terra import mcap run.mcap --map topics.toml --out
    /// drive.csv
    Import {
        /// Which data set or format.
        kind: ImportArg,
        /// Its file, or the folder that holds it; for scm-json with a JSON output, a soil of `terra terrains`.
        source: PathBuf,
        /// Log to write (CSV); for scm-json a catalogue (CSV) or, from a known soil, Chrono's JSON.
        #[arg(long)]
        out: PathBuf,
        /// Topic map of a bag (TOML).
        #[arg(long, value_name = "FILE")]
        map: Option<PathBuf>,
    },
    /// A soil, known or identified, for another simulator.
    #[command(subcommand)]
    Export(Export),
    /// How often the answer is right, on many runs with known truth.
    #[command(subcommand)]
    Campaign(Campaign),
    /// Sealed blind cases: logs whose cause is withheld, and their marking.
    #[command(subcommand)]
    Challenge(Challenge),
    /// A grid of runs: deterministic, resumable, in shards.
    Sweep {
        /// Plan (TOML).
        plan: PathBuf,
        /// Only shard i of n, from 1.
        #[arg(long, value_name = "i/n")]
        shard: Option<String>,
        /// JSON lines to write; a file that stopped halfway is gone on with.
        #[arg(long)]
        out: PathBuf,
    },
    /// Joins the shards of a sweep into the bytes of an unsharded run.
    Merge {
        /// Shards, in any order.
        #[arg(required = true)]
        files: Vec<PathBuf>,
        /// File to write (standard output when absent).
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// A page of Markdown for every model and effect, made from what is registered.
    // For those who write a book, not a robot's engineer: the list of commands stays short.
    #[command(hide = true)]
    Pages {
        /// Folder for the pages; those of the same name are replaced.
        #[arg(long)]
        out: PathBuf,
    },
    /// Shell completions.
    Completions {
        /// Shell.
        shell: clap_complete::Shell,
    },
    /// The manual page, as roff: terra man > terra.1
    Man {
        /// The page of one command, as in `terra man gap`.
        command: Option<String>,
    },
}

#[derive(Debug, Subcommand)]
pub(crate) enum Campaign {
    /// Torque ramps of the light robot of Ray 2008, identified among the 21 classic soils.
    Ramps {
        /// Noise draws of each soil.
        #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
        runs: u32,
        /// Seed of the noise.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Soils.
        #[arg(
            long,
            value_delimiter = ',',
            default_value = "dry_sand,upland_sandy_loam,lean_clay_22"
        )]
        terrains: Vec<String>,
        /// JSON to write.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Faults of sensors, torques and clocks: does the filter flag them, stay finite and come back?
    Faults {
        /// Runs, rounded up to whole draws of every kind, channel and soil.
        #[arg(long, default_value_t = 5000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
        runs: u32,
        /// Seed of the noise.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Filter: see `terra filters`.
        #[arg(long, default_value = "block")]
        filter: String,
        /// JSON to write.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// The published figures of the light robot on all 18 soils that carry it: exact set, calibration, change of soil,
    /// perturbed copies, systematic errors and their alarm, beside what this build finds.
    Reproduction {
        /// Noise draws of each case.
        #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
        runs: u32,
        /// Seed of the noise.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Tables to make.
        #[arg(
            long,
            value_delimiter = ',',
            default_value = "exact,switch,perturbed,mismatch",
            value_parser = ["exact", "switch", "perturbed", "mismatch"]
        )]
        tables: Vec<String>,
        /// JSON to write.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Sealed cases made, diagnosed and marked, beside what must be reached and what naive answers reach.
    Gap {
        #[command(flatten)]
        cases: CampaignCases,
        /// Diagnose the single cases once more with the true effect taken out of the library.
        #[arg(long)]
        left_out: bool,
        /// JSON to write.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Ground that follows another wheel law than the simulator that is diagnosed, with and without a baseline log.
    CrossStructure {
        /// Design: rig, rich, flat, steps, ramp.
        #[arg(long, default_value = "rig")]
        design: String,
        /// Cases.
        #[arg(long, default_value_t = 96, value_parser = clap::value_parser!(u32).range(1..=100_000))]
        cases: u32,
        /// Seed of everything that is drawn.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Folder for the answers; what is there already is kept.
        #[arg(long)]
        out: PathBuf,
        /// JSON to write.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Cases with known truth, and the calibration that they teach, as `calibration.toml`.
    GapCalibration {
        #[command(flatten)]
        cases: CampaignCases,
        /// Cases of each design without any effect beside these: what a cause must gain to be heard is a quantile of them.
        /// They are drawn from the seed after --seed.
        #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=100_000))]
        nulls: u32,
    },
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct CampaignCases {
    /// Designs: ramp, steps, flat, rich, rig.
    #[arg(long, value_delimiter = ',', default_value = "ramp,rich", value_parser = crate::challenge::DESIGNS)]
    pub(crate) designs: Vec<String>,
    /// Cases of each design.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) cases: u32,
    /// Seed of everything that is drawn.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Folder for logs, keys and verdicts; what is there already is kept.
    #[arg(long)]
    pub(crate) out: PathBuf,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ExportSoil {
    /// A soil of `terra terrains` or of --catalogue, or what `terra identify --json` wrote: then its refined soil.
    pub(crate) soil: String,
    /// Your own soils (CSV), beside those of `terra terrains`; an id that is in both is that of FILE.
    #[arg(long, value_name = "FILE")]
    pub(crate) catalogue: Option<PathBuf>,
    /// Group of the identification (left, right, all ...), where it has several.
    #[arg(long)]
    pub(crate) group: Option<String>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Export {
    /// Chrono's soil contact model (JSON).
    ScmJson {
        #[command(flatten)]
        soil: ExportSoil,
        /// File to write (standard output when absent).
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// The slip compliance that rigid-body simulators (Gazebo, ODE) take, by load, with the slips up to which it holds.
    ///
    /// Example: terra export slip-compliance dry_sand --radius_m 0.254 --width_m 0.15 --load_N 150,250,350
    SlipCompliance {
        #[command(flatten)]
        soil: ExportSoil,
        /// Wheel radius in m.
        #[arg(long = "radius_m", alias = "radius-m", value_name = "R")]
        radius: f64,
        /// Wheel width in m.
        #[arg(long = "width_m", alias = "width-m", value_name = "B")]
        width: f64,
        /// Normal loads in N.
        #[arg(
            long = "load_N",
            alias = "load-N",
            alias = "load_n",
            value_name = "W,...",
            value_delimiter = ',',
            required = true
        )]
        load: Vec<f64>,
        /// Terrain model.
        #[arg(long, default_value = "wong-reece")]
        model: String,
        /// A parameter of the model in SI units, in place of the soil's or where the soil gives none; may be repeated.
        #[arg(long, value_name = "NAME=VALUE")]
        value: Vec<String>,
        /// How far the line may be from the law, as a share of the largest traction on its range.
        #[arg(long, default_value_t = 0.1)]
        tolerance: f64,
        /// File to write (CSV; standard output when absent).
        #[arg(long)]
        out: Option<PathBuf>,
    },
}

#[derive(Debug, clap::Args)]
pub(crate) struct SoilArgs {
    /// Soil: an id of `terra terrains`, or of --catalogue.
    #[arg(long)]
    pub(crate) terrain: String,
    /// Your own soils (CSV), beside those of `terra terrains`; an id or a set that is in both is that of FILE.
    #[arg(long, value_name = "FILE")]
    pub(crate) catalogue: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct WheelArgs {
    #[command(flatten)]
    pub(crate) soil: SoilArgs,
    /// Wheel radius in m.
    #[arg(
        long = "radius_m",
        alias = "radius-m",
        value_name = "R",
        allow_negative_numbers = true
    )]
    pub(crate) radius: f64,
    /// Wheel width in m.
    #[arg(
        long = "width_m",
        alias = "width-m",
        value_name = "B",
        allow_negative_numbers = true
    )]
    pub(crate) width: f64,
    /// Normal load in N.
    #[arg(
        long = "load_N",
        alias = "load-N",
        alias = "load_n",
        value_name = "W",
        allow_negative_numbers = true
    )]
    pub(crate) load: f64,
    /// Slips A:B:STEP (B included), or one slip; braking is negative, in [-1, 1].
    #[arg(long, value_name = "A:B:STEP", allow_hyphen_values = true)]
    pub(crate) slip: String,
    /// Terrain model, or model+effect=magnitude+..., of effects that change the forces of one wheel; an effect's other form as
    /// effect/form=magnitude.
    #[arg(long, default_value = "wong-reece")]
    pub(crate) model: String,
    /// A parameter of the model in SI units, in place of the soil's or where the soil gives none; may be repeated.
    #[arg(long, visible_alias = "set", value_name = "NAME=VALUE")]
    pub(crate) value: Vec<String>,
    /// Also the named parts of the drawbar pull, as columns after status: shear of the rim, push of lugs, compaction,
    /// bulldozing, and what an effect adds under no other name.
    #[arg(long)]
    pub(crate) contributions: bool,
    /// Also what the lugs push during the passage of one at each slip (another table), for wheels whose lugs push: their
    /// ripple, lugs times ω/2π a second.
    #[arg(long)]
    pub(crate) lugs: bool,
    /// Also the stresses along the contact at each slip (a second table).
    #[arg(long)]
    pub(crate) stress: bool,
    /// File to write (standard output when absent); stresses go to FILE with .stress before its extension, lugs with .lugs.
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) report: ReportArgs,
}

/// The report that a command can write beside its result.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct ReportArgs {
    /// HTML report to write: one file, figures inside, nothing fetched.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Folder for each figure of that report as SVG, and its numbers as CSV.
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
}

impl ReportArgs {
    /// True when there is a report to write.
    pub(crate) fn asked(&self) -> bool {
        self.html.is_some() || self.figures.is_some()
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct BevameterArgs {
    /// Curves (CSV): test,plate_diameter_m,sinkage_m,pressure_Pa or
    /// test,normal_stress_Pa,shear_displacement_m,shear_stress_Pa; a column soil keeps soils apart.
    pub(crate) log: PathBuf,
    /// What was done to the ground.
    #[arg(long, value_enum)]
    pub(crate) kind: BevameterKind,
    /// Other column names, units, constants, and the range to fit (TOML).
    #[arg(long, value_name = "FILE")]
    pub(crate) columns: Option<PathBuf>,
    /// JSON to write.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) report: ReportArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum BevameterKind {
    /// A plate pressed in.
    Plate,
    /// Shear under a normal stress.
    Shear,
}

#[derive(Debug, clap::Args)]
pub(crate) struct IdentifyArgs {
    /// Drive or rig log (CSV).
    pub(crate) log: PathBuf,
    /// The vehicle or rig (TOML).
    #[arg(long)]
    pub(crate) rover: PathBuf,
    /// What is weighed: a catalogue set, a CSV of soils, or a TOML plan of sets (grid, latin_hypercube, perturb; several
    /// models) in place of the rover file's.
    #[arg(long, value_name = "SET|FILE")]
    pub(crate) hypotheses: Option<String>,
    /// Estimator: see `terra estimators` (default: side-sum for a drive, wheel for a rig).
    #[arg(long)]
    pub(crate) estimator: Option<String>,
    /// What happens to old evidence: none, floor:F, forgetting:L, or transition:FILE (rows of N numbers).
    #[arg(long, default_value = "none")]
    pub(crate) choice: String,
    /// Rows of a drive log to weigh, the first being 1; a log of more than 300 000 needs it.
    #[arg(long, value_name = "FIRST-LAST", value_parser = rows)]
    pub(crate) rows: Option<(usize, usize)>,
    /// One soil under both sides.
    #[arg(long)]
    pub(crate) join: bool,
    /// Keep the posterior after every sample.
    #[arg(long)]
    pub(crate) history: bool,
    /// Do not refine the winner's parameters.
    #[arg(long)]
    pub(crate) no_refine: bool,
    /// Filter of the forces: see `terra filters`.
    #[arg(long, default_value = "block")]
    pub(crate) filter: String,
    /// JSON to write (a summary goes to standard output).
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) report: ReportArgs,
}

fn rows(text: &str) -> Result<(usize, usize), String> {
    let ends = text.split_once('-');
    let ends = ends.and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    ends.filter(|(first, last)| (1..=*last).contains(first))
        .ok_or_else(|| "expected FIRST-LAST, as in 1-20000".to_owned())
}

#[derive(Debug, clap::Args)]
pub(crate) struct IdentifiabilityArgs {
    #[command(flatten)]
    pub(crate) soil: SoilArgs,
    /// Terrain model, or model+effect+... of effects that change the forces of one wheel.
    #[arg(long, default_value = "wong-reece")]
    pub(crate) model: String,
    /// A parameter of the model in SI units, in place of the soil's or where the soil gives none; may be repeated. It holds
    /// for the soil around which to ask and for each of --set.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) value: Vec<String>,
    /// Wheel radius in m.
    #[arg(long = "radius_m", alias = "radius-m", value_name = "R")]
    pub(crate) radius: f64,
    /// Wheel widths in m; every row is measured with each.
    #[arg(
        long = "width_m",
        alias = "width-m",
        value_name = "B,...",
        value_delimiter = ',',
        required = true
    )]
    pub(crate) widths: Vec<f64>,
    /// Normal loads in N.
    #[arg(
        long = "load_N",
        alias = "load-N",
        alias = "load_n",
        value_name = "W,...",
        value_delimiter = ',',
        required = true
    )]
    pub(crate) loads: Vec<f64>,
    /// Slips A:B:STEP (B included), or one slip.
    #[arg(long, value_name = "A:B:STEP", allow_hyphen_values = true)]
    pub(crate) slip: String,
    /// Measured channels and their sd: drawbar_pull_N, torque_N_m, sinkage_m; also of the inputs slip and normal_load_N.
    #[arg(
        long,
        value_name = "CHANNEL=SD,...",
        default_value = "drawbar_pull_N=0.5,torque_N_m=0.1"
    )]
    pub(crate) noise: String,
    /// Soils that should be told apart: a set of `terra terrains` or of --catalogue, or a CSV of soils.
    #[arg(long, value_name = "SET|FILE", default_value = "wong21")]
    pub(crate) set: String,
    /// Further rows to propose.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(0..=50))]
    pub(crate) add: u8,
    /// JSON to write (a summary goes to standard output).
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) report: ReportArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ClassArg {
    /// Clearpath Husky A200.
    Husky,
    /// Clearpath Jackal.
    Jackal,
    /// One wheel on a testbed.
    SingleWheelRig,
    /// The light robot of Ray 2008.
    PaperRobot,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ImportArg {
    /// Single-wheel trials of Carnegie Mellon University (smooth_straight.csv).
    CmuSingleWheel,
    /// Points digitised from published single-wheel tests (points.csv).
    PublishedSingleWheel,
    /// Skid-steer windows of a Husky A200 (husky_windows.parquet).
    NorlabDrive,
    /// Motor currents of a Husky A200 on three surfaces (wheel_service.parquet).
    Borealtc,
    /// Any flat Parquet file: its columns as they are.
    Parquet,
    /// A ROS 2 bag (MCAP), by a topic map.
    Mcap,
    /// The vectors of a MATLAB file (saved with -v6 or -v7).
    Mat,
    /// A terrain of Chrono's soil contact model.
    ScmJson,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum HoldOutArg {
    Segment,
    Trial,
    Condition,
    Slip,
}

/// What several logs share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum SoilArg {
    /// One soil for all logs.
    Shared,
    /// A soil of its own for each log, all with the same prior.
    Own,
}

#[derive(Debug, clap::Args)]
pub(crate) struct GapArgs {
    /// Drive or rig logs (CSV). Several are diagnosed as one: a log's name prefixes its manoeuvres or trials.
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// The nominal simulator: vehicle or rig, soil, noise (TOML).
    #[arg(long)]
    pub(crate) rover: PathBuf,
    /// Whether several logs were taken on one soil, or each on its own; sizes of effects are shared either way.
    #[arg(long, value_enum, default_value_t = SoilArg::Shared)]
    pub(crate) soil: SoilArg,
    /// Log of an outside simulator that drove or rolled the same: the nominal simulator is made like it first, and what is
    /// then missing on LOG is missing in that simulator too. By motion alone where one of the two holds no torques.
    #[arg(long, value_name = "SIM_LOG")]
    pub(crate) sim: Option<PathBuf>,
    /// The simulator was given the soil of LOG: other soil is no answer.
    #[arg(long, requires = "sim")]
    pub(crate) same_bed: bool,
    /// Diagnose a drive without torques by its motion alone, even where its accelerations tell of forces: on ground that no
    /// terrain model describes.
    #[arg(long)]
    pub(crate) motion_only: bool,
    /// Which groups are held out to measure how far the gap shrinks.
    #[arg(long, value_enum)]
    pub(crate) hold_out: Option<HoldOutArg>,
    /// Candidate effects: all, or names separated by commas.
    #[arg(long, default_value = "all")]
    pub(crate) effects: String,
    /// Most effects combined (1 or 2).
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub(crate) combine: u8,
    /// Most windows of a drive that are used. Where there are more, every kind of motion stays and frequent ones are thinned.
    #[arg(long, value_name = "N", default_value_t = terra_gap::Settings::WINDOWS as u32, value_parser = clap::value_parser!(u32).range(16..))]
    pub(crate) windows: u32,
    /// Mock cases of this log's own design, with known causes, from which probabilities and thresholds are learned; 0 takes
    /// those that ship. 100 is a good number, and costs a hundred diagnoses.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub(crate) calibrate: u32,
    /// Seed of the mock cases.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Watch one long drive instead: learn the soil from its beginning, then say when and where a gap opens.
    #[arg(long, conflicts_with_all = ["sim", "same_bed", "motion_only", "hold_out", "calibrate", "combine", "soil", "seed", "windows", "html", "figures"])]
    pub(crate) watch: bool,
    /// What the watch learns the soil from: so many seconds from the log's beginning, or a manoeuvre by its name.
    #[arg(
        long,
        value_name = "SECONDS|SEGMENT",
        default_value = "20",
        requires = "watch"
    )]
    pub(crate) baseline: String,
    /// Share of logs without a gap, of whatever length, in which the watch may raise an event.
    #[arg(long, value_name = "P", default_value_t = 0.05, requires = "watch")]
    pub(crate) false_alarms: f64,
    /// CSV to write: what every window of the watch shows.
    #[arg(long, value_name = "FILE", requires = "watch")]
    pub(crate) track: Option<PathBuf>,
    /// JSON to write.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) report: ReportArgs,
}

impl GapArgs {
    /// Candidates by name; none for all.
    pub(crate) fn effects(&self) -> Option<Vec<String>> {
        let names = || self.effects.split(',').map(|s| s.trim().to_owned());
        (self.effects != "all").then(|| names().collect())
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Challenge {
    /// Draws cases, simulates their logs, and commits to what is withheld.
    ///
    /// Everything is drawn from the seed: whoever knows it knows the answers.
    Make(ChallengeMake),
    /// Diagnoses every log of a challenge with its rover file; verdicts that are there already are kept.
    Run {
        /// Folder of the challenge.
        folder: PathBuf,
        /// Folder for the verdicts, case_001.json ...
        #[arg(long)]
        out: PathBuf,
    },
    /// Marks verdicts against the key, beside naive baselines.
    Score(ChallengeScore),
    /// Checks every commitment and prints the answers.
    Reveal {
        /// Key file.
        #[arg(long)]
        key: PathBuf,
        /// Folder of the challenge.
        folder: PathBuf,
    },
}

#[derive(Debug, clap::Args)]
pub(crate) struct ChallengeMake {
    /// ramp, steps, flat, rich, rig, or a scenario file.
    #[arg(long)]
    pub(crate) design: String,
    /// Number of cases.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) cases: u32,
    /// Seed of everything that is drawn; a secret.
    #[arg(long)]
    pub(crate) seed: u64,
    /// Folder for the logs, the rover file and the commitments.
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Key file to write, outside that folder.
    #[arg(long)]
    pub(crate) key: PathBuf,
    /// Shares of the kinds of cases: none=.2,single=.5,pair=.1,off-library=.1,form-variant=.1
    #[arg(long, value_name = "KIND=SHARE,...")]
    pub(crate) kinds: Option<String>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ChallengeScore {
    /// Folder with case_001.json ..., as `terra gap --json` writes them.
    #[arg(long)]
    pub(crate) verdicts: PathBuf,
    /// Key file.
    #[arg(long)]
    pub(crate) key: PathBuf,
    /// JSON to write.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Do not simulate the cases again to see how far the gap truly closed.
    #[arg(long)]
    pub(crate) skip_closing: bool,
}
