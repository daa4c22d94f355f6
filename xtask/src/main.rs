//! Tasks of the repository: `cargo xtask check` is what CI runs, `cargo xtask bench` counts instructions.
// A command talks to people.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod check;
mod counts;
mod fit;
mod instructions;
mod python;
mod shell;

use std::process::ExitCode;

const USAGE: &str = "\
cargo xtask check [--only STEP]... [--except STEP]...   everything CI checks; stops at the first failure
cargo xtask bench [--cpu x86-64|x86-64-v3]              instructions per operation against terra-bench/counts.toml";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let outcome = match arguments.split_first() {
        Some((task, rest)) if task == "check" => check::run(rest),
        Some((task, rest)) if task == "bench" => instructions::run(rest),
        Some((task, _)) if task == "--help" || task == "-h" => {
            println!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        _ => Err(USAGE.to_owned()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}
