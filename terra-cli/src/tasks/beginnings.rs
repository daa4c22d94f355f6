//! What one begins with: a rover file, and the demonstration.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde_json::Value;

use crate::args::ClassArg;
use crate::commands::{demo as showing, init as starting};
use crate::error::CliError;

/// The commented rover file of a robot or rig, as `terra init` writes it.
///
/// # Errors
/// An unknown robot.
pub fn init(robot: &str) -> Result<&'static str, CliError> {
    Ok(starting::file_of(class(robot)?))
}

/// `terra init --out`: that file written; one that exists is replaced only with `force`.
///
/// # Errors
/// As the command.
pub fn init_into(robot: &str, out: &Path, force: bool) -> Result<&'static str, CliError> {
    starting::write(class(robot)?, out, force)
}

fn class(robot: &str) -> Result<ClassArg, CliError> {
    ClassArg::from_str(robot, false).map_err(|_| {
        let known = ClassArg::value_variants().iter();
        let known: Vec<String> = known
            .filter_map(|c| Some(c.to_possible_value()?.get_name().to_owned()))
            .collect();
        CliError::usage(
            format!("robot = '{robot}'"),
            format!("expected one of {}", known.join(", ")),
        )
    })
}

/// What [`demo`] gave.
#[derive(Clone, Debug)]
pub struct Demonstration {
    /// `identify.json`.
    pub identify: Value,
    /// `verdict.json`.
    pub verdict: Value,
}

/// `terra demo`: `report.html`, `identify.json` and `verdict.json` in a folder, and figures in another.
///
/// # Errors
/// As the command.
pub fn demo(out: &Path, figures: Option<PathBuf>) -> Result<Demonstration, CliError> {
    let made = showing::make(out, figures, true)?;
    Ok(Demonstration {
        identify: made.identify,
        verdict: made.verdict,
    })
}
