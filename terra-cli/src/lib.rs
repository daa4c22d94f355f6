//! The command behind the binary `terra`, as a library: commands, error display, progress, the HTML report.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::panic))]

mod args;
mod bevameter;
pub mod campaign;
pub mod challenge;
mod commands;
mod error;
mod identify;
mod input;
mod output;
mod progress;
pub mod report;
mod robot;
mod soils;
mod start;
mod sweep;
pub mod tasks;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser;

pub use error::CliError;
pub use identify::{
    Group, Identification, IdentifyOptions, identify_drive, identify_drive_among, identify_rig,
    identify_rig_among,
};

/// Runs the command line of this process and says how it ended: 0 done, 2 usage or configuration, 3 data, 4 cannot
/// write, 130 interrupted.
pub fn run() -> ExitCode {
    ExitCode::from(run_with(std::env::args_os()))
}

/// Runs a command line, its first word the program's name, and gives the exit status. Answers interrupts from then on.
pub fn run_with(args: impl IntoIterator<Item = OsString>) -> u8 {
    // Results are written whole or not at all, so that an interrupt may end the process at any moment.
    // A second handler cannot be installed in this process; without one, the signal's default ends it just as well.
    let _ = ctrlc::set_handler(|| {
        terra_data::abandon_writes();
        std::process::exit(130)
    });
    let args = match args::Args::try_parse_from(args) {
        Ok(args) => args,
        Err(e) => {
            let help = matches!(
                e.kind(),
                clap::error::ErrorKind::DisplayHelp | clap::error::ErrorKind::DisplayVersion
            );
            // Nothing better can be done when the terminal itself is gone.
            let _ = e.print();
            return if help { 0 } else { 2 };
        }
    };
    match commands::dispatch(args) {
        Ok(()) | Err(CliError::PipeClosed) => 0,
        Err(e) => {
            error::show(&e);
            e.exit_code()
        }
    }
}
