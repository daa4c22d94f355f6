//! What a challenge is driven with: manoeuvres or rig trials, and the nominal simulator.

use std::path::Path;

use terra_data::{
    DriveLog, RigLog, Rover, parse_rover, read_rover, write_drive_log_to, write_rig_log_to,
};
use terra_model::Registry;
use terra_sim::integrate::DormandPrince;
use terra_sim::{Integrator, Scenario, simulate_drive_with, simulate_rig};

use super::key::SealedDesign;
use crate::error::CliError;

const ROVER: &str = include_str!("designs/rover.toml");
const RIG_ROVER: &str = include_str!("designs/rig_rover.toml");

/// Designs by name: what each is, rover file, scenario.
const BUILTIN: [(&str, &str, &str); 5] = [
    ("ramp", ROVER, include_str!("designs/ramp.toml")),
    ("steps", ROVER, include_str!("designs/steps.toml")),
    ("flat", ROVER, include_str!("designs/flat.toml")),
    ("rich", ROVER, include_str!("designs/rich.toml")),
    ("rig", RIG_ROVER, include_str!("designs/rig.toml")),
];

/// Names of the designs that ship.
pub const DESIGNS: [&str; 5] = ["ramp", "steps", "flat", "rich", "rig"];

/// A log of either kind.
#[derive(Clone, Debug)]
pub(crate) enum AnyLog {
    Drive(Box<DriveLog>),
    Rig(RigLog),
}

impl AnyLog {
    /// The file it becomes.
    pub(crate) fn bytes(&self) -> Result<Vec<u8>, CliError> {
        let mut out = Vec::new();
        match self {
            AnyLog::Drive(log) => write_drive_log_to(&mut out, log),
            AnyLog::Rig(log) => write_rig_log_to(&mut out, log),
        }
        .map_err(|reason| CliError::Write {
            target: "a log in memory".to_owned(),
            reason,
        })?;
        Ok(out)
    }
}

/// How cases are integrated: errors of a step a hundred thousand times below the instruments' noise.
const TRUTH: Integrator = Integrator::DormandPrince(DormandPrince {
    relative: 1e-7,
    absolute: 1e-8,
    max_step: 0.1,
});

/// Simulates a scenario of either kind.
pub(crate) fn simulate(
    scenario: &Scenario,
    rover: &Rover,
    registry: &Registry,
) -> Result<AnyLog, CliError> {
    Ok(if scenario.trials.is_empty() {
        AnyLog::Drive(Box::new(
            simulate_drive_with(scenario, rover, registry, TRUTH)?.log,
        ))
    } else {
        AnyLog::Rig(simulate_rig(scenario, rover, registry)?.log)
    })
}

/// Manoeuvres and nominal simulator.
#[derive(Clone, Debug)]
pub struct Design {
    /// As text, for the key.
    pub sealed: SealedDesign,
    /// The nominal simulator.
    pub rover: Rover,
    /// What is driven; soil, effects and seed are a case's.
    pub scenario: Scenario,
}

impl Design {
    /// A design that ships, or a scenario file with its rover file.
    ///
    /// # Errors
    /// A name that is neither; a file that cannot be read; a scenario that already holds effects.
    pub fn named(name: &str) -> Result<Self, CliError> {
        if let Some((name, rover, scenario)) = BUILTIN.iter().find(|(n, ..)| *n == name) {
            return Design::of(&SealedDesign {
                name: (*name).to_owned(),
                rover: (*rover).to_owned(),
                scenario: (*scenario).to_owned(),
            });
        }
        let path = Path::new(name);
        if !path.exists() && path.extension().is_none() {
            return Err(CliError::usage(
                format!("no design '{name}'"),
                format!("one of {}, or a scenario file", DESIGNS.join(", ")),
            ));
        }
        let scenario = Scenario::read(path)?;
        let rover_path = scenario.rover_path(path);
        let rover = read_rover(&rover_path)?;
        let text = |path: &Path| {
            std::fs::read_to_string(path).map_err(|e| CliError::BadData {
                message: format!("{}: cannot be read: {e}", path.display()),
                help: None,
            })
        };
        let sealed = SealedDesign {
            name: "own".to_owned(),
            rover: text(&rover_path)?,
            scenario: text(path)?,
        };
        let design = Design {
            sealed,
            rover,
            scenario,
        };
        design.check().map_err(|e| e.within(path))?;
        Ok(design)
    }

    /// The design of a key.
    ///
    /// # Errors
    /// Texts that are no rover file or no scenario.
    pub fn of(sealed: &SealedDesign) -> Result<Self, CliError> {
        let file = |what: &str| format!("{} of design {}", what, sealed.name);
        let design = Design {
            sealed: sealed.clone(),
            rover: parse_rover(&sealed.rover, &file("rover"))?,
            scenario: Scenario::parse(&sealed.scenario, &file("scenario"))?,
        };
        design.check()?;
        Ok(design)
    }

    fn check(&self) -> Result<(), CliError> {
        if let Some(effect) = self.scenario.effects.first() {
            return Err(CliError::usage(
                format!(
                    "the scenario already holds the effect {}, and a challenge draws its own",
                    effect.name
                ),
                "leave [[effect]] out",
            ));
        }
        Ok(())
    }
}
