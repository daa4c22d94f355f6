//! The binary `terra`.

use std::process::ExitCode;

fn main() -> ExitCode {
    terra_cli::run()
}
