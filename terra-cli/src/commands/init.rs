//! `terra init`: a rover file to start from.

use std::io::Write;
use std::path::Path;

use terra_data::{DataError, Problem, atomic_write, atomic_write_new};

use crate::args::ClassArg;
use crate::error::CliError;
use crate::output;

pub(crate) fn run(class: ClassArg, out: &Path, force: bool) -> Result<(), CliError> {
    let text = write(class, out, force)?;
    let guesses = text.matches("estimate: ").count();
    let open = match guesses {
        0 => String::new(),
        n => format!(", {n} marked 'estimate: ...': replace those by what you measure"),
    };
    output::stdout(&format!(
        "{}: {} lines{open}\n",
        out.display(),
        text.lines().count()
    ))
}

/// Writes the file of a class; returns what it holds.
pub(crate) fn write(class: ClassArg, out: &Path, force: bool) -> Result<&'static str, CliError> {
    output::claim(&[Some(out)], &[])?;
    let text = file_of(class);
    let write = |w: &mut dyn Write| w.write_all(text.as_bytes());
    let written = if force {
        atomic_write(out, write)
    } else {
        atomic_write_new(out, write)
    };
    written.map_err(|e| exists(e, out))?;
    Ok(text)
}

/// Says how to overwrite on purpose.
fn exists(e: DataError, out: &Path) -> CliError {
    if matches!(e.problem(), Problem::Exists) {
        return CliError::Write {
            target: out.display().to_string(),
            reason: std::io::Error::new(
                std::io::ErrorKind::AlreadyExists,
                "the file exists; --force overwrites it, --out names another",
            ),
        };
    }
    e.into()
}

/// The commented rover file of a class.
pub(crate) fn file_of(class: ClassArg) -> &'static str {
    match class {
        ClassArg::Husky => include_str!("../init/husky.toml"),
        ClassArg::Jackal => include_str!("../init/jackal.toml"),
        ClassArg::SingleWheelRig => include_str!("../init/single_wheel_rig.toml"),
        ClassArg::PaperRobot => include_str!("../init/paper_robot.toml"),
    }
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;
    use terra_data::parse_rover;

    use super::*;

    #[test]
    fn every_class_parses_and_says_what_it_is() {
        for class in ClassArg::value_variants() {
            let rover = parse_rover(file_of(*class), "rover.toml");
            let rig = matches!(class, ClassArg::SingleWheelRig);
            assert_eq!(rover.map(|r| r.is_rig()).ok(), Some(rig), "{class:?}");
        }
    }

    #[test]
    fn the_papers_robot_is_the_simulators() {
        let written = parse_rover(file_of(ClassArg::PaperRobot), "rover.toml").ok();
        assert_eq!(written, Some(terra_sim::paper::light_rover()));
    }
}
