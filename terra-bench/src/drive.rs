//! The torque ramp of the reference paper's light robot: 2 s of four wheels by Dormand-Prince steps.

use terra_data::Rover;
use terra_model::Registry;
use terra_sim::integrate::{DormandPrince, Rk4};
use terra_sim::{DriveRun, Integrator, Scenario, paper, simulate_drive_with};

use crate::error::{BenchError, check};

/// Relative and absolute tolerance of a step.
pub const TOLERANCE: f64 = 1e-6;

/// A drive and the vehicle that does it.
pub struct Ramp {
    scenario: Scenario,
    rover: Rover,
    registry: Registry,
}

impl Ramp {
    /// The ramp on dry sand with all that a log needs: load transfer, 200 rows, noise of every sensor.
    ///
    /// # Errors
    /// [`BenchError::Sim`].
    pub fn full() -> Result<Self, BenchError> {
        Ok(Ramp {
            scenario: paper::torque_ramp("dry_sand", 1)?,
            rover: paper::light_rover(),
            registry: Registry::builtin(),
        })
    }

    /// The same as a problem of mechanics alone: a centre of mass in the ground's plane shifts no load, and nothing is
    /// noisy. Its 200 rows are still recorded.
    ///
    /// # Errors
    /// [`BenchError::Sim`].
    pub fn plain() -> Result<Self, BenchError> {
        let mut ramp = Self::full()?;
        ramp.scenario.noise_scale = 0.0;
        if let Some(vehicle) = &mut ramp.rover.vehicle {
            vehicle.cg_height = 0.0;
        }
        Ok(ramp)
    }

    /// Drives it.
    ///
    /// # Errors
    /// [`BenchError::Sim`].
    pub fn run(&self) -> Result<DriveRun, BenchError> {
        self.by(Integrator::DormandPrince(DormandPrince {
            relative: TOLERANCE,
            absolute: TOLERANCE,
            ..DormandPrince::default()
        }))
    }

    fn by(&self, integrator: Integrator) -> Result<DriveRun, BenchError> {
        Ok(simulate_drive_with(
            &self.scenario,
            &self.rover,
            &self.registry,
            integrator,
        )?)
    }

    /// Compares every row's speeds with those of fixed steps of half a millisecond: ten tolerances.
    ///
    /// # Errors
    /// [`BenchError::Wrong`], [`BenchError::Sim`].
    pub fn check(&self) -> Result<(), BenchError> {
        let found = self.run()?.truth;
        let reference = self.by(Integrator::Rk4(Rk4 { step: 5e-4 }))?.truth;
        let columns = [
            ("ground speed", &found.ground_speed, &reference.ground_speed),
            (
                "front wheel",
                &found.wheel_speed[0],
                &reference.wheel_speed[0],
            ),
            (
                "rear wheel",
                &found.wheel_speed[3],
                &reference.wheel_speed[3],
            ),
        ];
        for (what, found, reference) in columns {
            for (row, (found, reference)) in found.iter().zip(reference).enumerate() {
                let what = format!("{what} in row {row}");
                check(
                    &what,
                    *found,
                    *reference,
                    1.0 + reference.abs(),
                    10.0 * TOLERANCE,
                )?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_agree_with_fixed_steps() {
        Ramp::full().unwrap().check().unwrap();
        Ramp::plain().unwrap().check().unwrap();
    }
}
