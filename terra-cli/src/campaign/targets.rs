//! What a diagnosis must reach on sealed cases, beside what it reached.

use std::path::Path;

use serde::Serialize;

use crate::challenge::{KeyFile, Score, held_back};
use crate::error::CliError;

/// One figure with its interval and what is asked of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Target {
    /// What it is.
    pub(crate) figure: String,
    /// Cases behind it.
    pub(crate) n: usize,
    /// Found.
    pub(crate) value: Option<f64>,
    /// Lower end of its 95 % interval.
    pub(crate) lo: Option<f64>,
    /// Upper end.
    pub(crate) hi: Option<f64>,
    /// What an earlier prototype reached.
    pub(crate) prototype: &'static str,
    /// What must hold.
    pub(crate) must: &'static str,
    /// What is aimed at.
    pub(crate) ambitious: &'static str,
}

type Row = (
    &'static str,
    &'static str,
    &'static str,
    &'static str,
    &'static str,
);

/// Figure of a score, its name, prototype, must, ambitious: on rich drives.
const RICH: [Row; 2] = [
    ("top1", "top-1, one effect", ".94", ">= .90", ">= .95"),
    ("top3", "top-3, one effect", ".98", ">= .97", ">= .99"),
];
const RAMP: [Row; 2] = [
    ("top1", "top-1, one effect", ".62", ">= .55", ">= .65"),
    ("top3", "top-3, one effect", ".77", ">= .75", ">= .82"),
];
const EVERYWHERE: [Row; 7] = [
    (
        "false_alarm",
        "false alarms on nulls",
        ".05",
        "<= .08",
        "<= .05",
    ),
    ("power", "effects that raise an alarm", "-", "-", ">= .93"),
    (
        "false_notice",
        "nulls whose verdict is not `none`",
        ".05",
        "<= .08",
        "<= .05",
    ),
    (
        "noticed",
        "effects whose verdict is not `none`",
        "-",
        "-",
        ">= .93",
    ),
    (
        "ece",
        "calibration error of probabilities",
        ".05-.09",
        "<= .10",
        "<= .05",
    ),
    (
        "closed_error",
        "gap closed: median error",
        ".03",
        "<= .06",
        "<= .03",
    ),
    (
        "closed_coverage",
        "gap closed: cover of its 95 % interval",
        ".84",
        ">= .85",
        ".88-.92",
    ),
];
const RICH_TOO: [Row; 5] = [
    (
        "set_coverage",
        "90 % set: coverage",
        ".91-.97",
        ">= .88",
        ">= .90",
    ),
    ("set_size", "90 % set: mean size", "1-1.5", "<= 2", "<= 1.4"),
    (
        "top1_form_variant",
        "right physics, other formula: top-1",
        ".81",
        ">= .75",
        ">= .90",
    ),
    (
        "pair_first",
        "two effects: first in pair",
        ".94",
        ">= .90",
        ">= .95",
    ),
    (
        "pair_both_in_three",
        "two effects: both in three",
        ".89",
        ">= .80",
        ">= .92",
    ),
];

/// The figures of a design that something is asked of.
pub(crate) fn targets(design: &str, score: &Score) -> Vec<Target> {
    let rows: Vec<&Row> = match design {
        "rich" => RICH.iter().chain(&EVERYWHERE).chain(&RICH_TOO).collect(),
        "ramp" => RAMP.iter().chain(&EVERYWHERE).collect(),
        _ => EVERYWHERE.iter().collect(),
    };
    rows.into_iter()
        .filter_map(|(name, figure, prototype, must, ambitious)| {
            let m = score.metric(name)?;
            Some(Target {
                figure: (*figure).to_owned(),
                n: m.n,
                value: m.value,
                lo: m.lo,
                hi: m.hi,
                prototype,
                must,
                ambitious,
            })
        })
        .collect()
}

/// The figures of a library without the true effect: does "unknown" rise, is another name given?
///
/// # Errors
/// A file that is no verdict.
pub(crate) fn left_out(
    key: &KeyFile,
    whole: &Path,
    without: &Path,
) -> Result<Vec<Target>, CliError> {
    let found = held_back(key, whole, without)?;
    let row = |m: &crate::challenge::Metric, figure: &str, prototype, must, ambitious| Target {
        figure: figure.to_owned(),
        n: m.n,
        value: m.value,
        lo: m.lo,
        hi: m.hi,
        prototype,
        must,
        ambitious,
    };
    Ok(vec![
        row(
            &found.unknown,
            "true effect not in the library: AUROC of unknown",
            ".84",
            ">= .80",
            ">= .88",
        ),
        row(
            &found.wrong_name,
            "the same: a wrong name from outside the look-alike group",
            ".18",
            "<= .20",
            "<= .10",
        ),
    ])
}
