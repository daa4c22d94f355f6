//! The Wong-Reece wheel over soils x slips x loads, with reference values of its forces.
//!
//! # Units
//! SI: N, N m, rad; wheel of radius .254 m and width .15 m.
//!
//! # Reference
//! Adaptive quadrature after an end-point map, bracketed root in ln(entry angle), then loads and torque once more with
//! 30-digit tanh-sinh quadrature: both agree to 2e-14. Equations: J. Y. Wong and A. R. Reece, J. Terramechanics 4 (1967)
//! 1:81-98 and 2:7-25; soils: J. Y. Wong, *Theory of Ground Vehicles*, table 2.3.

use nalgebra::DMatrix;
use terra_model::models::WongReece;
use terra_model::{Contact, ForceLaw, Law, Registry, WheelForces, catalogue};

use crate::error::{BenchError, check};

/// R \[m\].
pub const RADIUS: f64 = 0.254;
/// b \[m\].
pub const WIDTH: f64 = 0.15;

/// Largest e = max(|dtheta1|/theta1, |dT|/|T|, |dD|/(|D| + |T|/R)) of the forces.
const FORCES_ALLOWED: f64 = 1e-9;
/// Largest difference of a derivative from the central difference of checked forces, as a share of force/variable.
const SLOPES_ALLOWED: f64 = 1e-6;

/// One contact and what it should give.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Soil of the catalogue.
    pub soil: &'static str,
    /// Library slip \[1\].
    pub slip: f64,
    /// W \[N\].
    pub normal_load: f64,
    /// theta1 \[rad\], D \[N\], T \[N m\].
    reference: [f64; 3],
}

const fn row(soil: &'static str, slip: f64, normal_load: f64, reference: [f64; 3]) -> Row {
    Row {
        soil,
        slip,
        normal_load,
        reference,
    }
}

/// Driving: four soils, three slips, two loads.
#[rustfmt::skip]
pub const DRIVING: &[Row] = &[
    row("dry_sand", 0.1, 245.25, [0.47813335708455695, -8.923733110584394, 11.880369782163143]),
    row("dry_sand", 0.4, 245.25, [0.5045481436024151, 28.238982578749116, 23.04844686792234]),
    row("dry_sand", 0.8, 245.25, [0.5717058206375017, 36.93727130794951, 29.07451162107377]),
    row("dry_sand", 0.1, 2452.5, [0.9985850865619509, -139.68246982500722, 257.7151601458701]),
    row("dry_sand", 0.4, 2452.5, [1.068358830554582, -198.09762016253356, 289.16456199519314]),
    row("dry_sand", 0.8, 2452.5, [1.2629593167803972, -583.6419034515292, 311.4350860220782]),
    row("sandy_loam_15", 0.1, 245.25, [0.23918637875237325, 14.433126356075316, 10.959312904806573]),
    row("sandy_loam_15", 0.4, 245.25, [0.24797605192490035, 66.79746246870911, 24.78313862256924]),
    row("sandy_loam_15", 0.8, 245.25, [0.26817863989019336, 87.13408284163621, 31.03485487424252]),
    row("sandy_loam_15", 0.1, 2452.5, [0.619067786080745, 248.76070978278108, 249.065731059626]),
    row("sandy_loam_15", 0.4, 2452.5, [0.6404765894803264, 393.0795299238651, 298.81780435005857]),
    row("sandy_loam_15", 0.8, 2452.5, [0.6964079810325724, 315.705915709433, 309.4929455547701]),
    row("lean_clay_22", 0.1, 245.25, [0.027327848478939647, 5.686867556379167, 2.290293788596755]),
    row("lean_clay_22", 0.4, 245.25, [0.027960582982098005, 29.552223092841253, 8.385017050133957]),
    row("lean_clay_22", 0.8, 245.25, [0.02916594274545272, 56.13531600984835, 15.194568787376376]),
    row("lean_clay_22", 0.1, 2452.5, [0.14124250793627213, 154.54127584572197, 82.90116997438086]),
    row("lean_clay_22", 0.4, 2452.5, [0.14339818253624975, 617.4239110457962, 201.61226508525397]),
    row("lean_clay_22", 0.8, 2452.5, [0.14882524660657503, 833.4760677301686, 259.05808263041075]),
    row("lete_sand", 0.1, 245.25, [0.16999166684938077, -5.8867564989221135, 3.5926915551325864]),
    row("lete_sand", 0.4, 245.25, [0.17962007406352068, 23.25154375314904, 11.604067920895426]),
    row("lete_sand", 0.8, 245.25, [0.20123421163810867, 48.08270817094971, 19.11013956121882]),
    row("lete_sand", 0.1, 2452.5, [0.4167592474614365, -101.12152625829025, 99.06541890702393]),
    row("lete_sand", 0.4, 2452.5, [0.4364661395539226, 288.05994832665755, 210.1912661050511]),
    row("lete_sand", 0.8, 2452.5, [0.4866799256385627, 422.47566163358294, 271.50208188603375]),
];

/// Braking, kinematic slip 1 - v/(R w) = -.1: the shear displacement changes its sign inside the contact.
#[rustfmt::skip]
pub const BRAKING: &[Row] = &[
    row("dry_sand", -0.09090909090909091, 245.25, [0.4681984356012052, -67.1655371232044, -3.657387609676655]),
    row("dry_sand", -0.09090909090909091, 2452.5, [0.9752368250586089, -338.35601249130895, 189.9622768025475]),
    row("sandy_loam_15", -0.09090909090909091, 245.25, [0.23592697106440672, -62.505568436613544, -8.79582990045664]),
    row("sandy_loam_15", -0.09090909090909091, 2452.5, [0.6262645140681146, -647.80935903599, 25.885907709170745]),
    row("lean_clay_22", -0.09090909090909091, 245.25, [0.02698881510192658, -12.136303171476785, -2.255499140122969]),
    row("lean_clay_22", -0.09090909090909091, 2452.5, [0.1407179402548014, -473.29944056748036, -76.90398275037812]),
    row("lete_sand", -0.09090909090909091, 245.25, [0.16529156921052346, -31.19887748322654, -3.1633448497667067]),
    row("lete_sand", -0.09090909090909091, 2452.5, [0.4094344831398718, -641.023696143548, -43.330978702464655]),
];

/// A law with the parameters and contact of one row, ready to be solved.
#[derive(Clone, Debug)]
pub struct Case {
    law: Law,
    parameters: Vec<f64>,
    contact: Contact<f64>,
    row: Row,
}

/// The cases of some rows under `wong-reece`.
///
/// # Errors
/// [`BenchError::Model`] for a soil that is not in the catalogue.
pub fn cases(rows: &[Row]) -> Result<Vec<Case>, BenchError> {
    let law = Registry::builtin().law("wong-reece")?;
    rows.iter()
        .map(|&row| {
            Ok(Case {
                parameters: catalogue::find(row.soil)?.parameters(law.model())?,
                contact: Contact::new(row.slip, row.normal_load, RADIUS, WIDTH),
                law: law.clone(),
                row,
            })
        })
        .collect()
}

impl Case {
    /// A cold forward solve: nothing is kept from call to call.
    ///
    /// # Errors
    /// [`BenchError::Model`].
    pub fn forces(&self) -> Result<WheelForces<f64>, BenchError> {
        Ok(self.law.forces(&self.parameters, &self.contact)?)
    }

    /// A forward solve from the entry angle of a contact nearby, as of the last sample of a log: 1 % off.
    ///
    /// # Errors
    /// [`BenchError::Model`].
    pub fn warm_forces(&self) -> Result<WheelForces<f64>, BenchError> {
        let start = 1.01 * self.row.reference[0];
        Ok(WongReece.forces_from(&self.parameters, &self.contact, start)?)
    }

    /// Forces with derivatives: rows D, T, z, F_y, columns eight parameters, slip, load.
    ///
    /// # Errors
    /// [`BenchError::Model`].
    pub fn jacobian(&self) -> Result<(WheelForces<f64>, DMatrix<f64>), BenchError> {
        Ok(self.law.jacobian(&self.parameters, &self.contact)?)
    }

    /// Soil, slip and load, for names and messages.
    pub fn label(&self) -> String {
        format!(
            "{}, slip {:.2}, {} N",
            self.row.soil, self.row.slip, self.row.normal_load
        )
    }

    /// Compares forces with the reference.
    ///
    /// # Errors
    /// [`BenchError::Wrong`].
    pub fn check_forces(&self, forces: &WheelForces<f64>) -> Result<(), BenchError> {
        let [entry, pull, torque] = self.row.reference;
        let found = forces.angles.map_or(f64::NAN, |a| a.entry);
        let allowed = FORCES_ALLOWED;
        let name = |what: &str| format!("{what} of {}", self.label());
        check(&name("entry angle"), found, entry, entry, allowed)?;
        let (found, scale) = (forces.drawbar_pull, pull.abs() + torque.abs() / RADIUS);
        check(&name("drawbar pull"), found, pull, scale, allowed)?;
        let found = forces.resistive_torque;
        check(&name("torque"), found, torque, torque.abs(), allowed)
    }

    /// Compares derivatives of pull and torque with differences of forces at shifted inputs, and the forces among the
    /// result with the reference.
    ///
    /// # Errors
    /// [`BenchError::Wrong`]; [`BenchError::Model`] at a shifted input.
    pub fn check_jacobian(
        &self,
        forces: &WheelForces<f64>,
        jacobian: &DMatrix<f64>,
    ) -> Result<(), BenchError> {
        self.check_forces(forces)?;
        let [_, pull, torque] = self.row.reference;
        let scale = [pull.abs() + torque.abs() / RADIUS, torque.abs()];
        let parameters = self.parameters.len();
        for column in 0..parameters + 2 {
            let x = match column.checked_sub(parameters) {
                None => self.parameters[column],
                Some(0) => self.contact.slip,
                Some(_) => self.contact.normal_load,
            };
            // Fourth order: the error of the step and the rounding of the solve are both near 1e-10.
            let h = 1e-3 * x.abs();
            let mut slope = [0.0; 2];
            for (shift, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
                let f = self.shifted(column, x + shift * h).forces()?;
                slope[0] += weight * f.drawbar_pull / (12.0 * h);
                slope[1] += weight * f.resistive_torque / (12.0 * h);
            }
            for (force, (slope, scale)) in ["pull", "torque"].iter().zip(slope.iter().zip(scale)) {
                let row = usize::from(*force == "torque");
                let what = format!("slope of {force} in variable {column} of {}", self.label());
                let found = jacobian[(row, column)];
                check(&what, found, *slope, scale / x.abs(), SLOPES_ALLOWED)?;
            }
        }
        Ok(())
    }

    /// Compares a table's or a batch's entry angle (where there is one), pull and torque with the reference.
    ///
    /// # Errors
    /// [`BenchError::Wrong`].
    pub fn check_values(
        &self,
        found: (Option<f64>, f64, f64),
        allowed: f64,
    ) -> Result<(), BenchError> {
        let [entry, pull, torque] = self.row.reference;
        let name = |what: &str| format!("{what} of {}", self.label());
        if let Some(angle) = found.0 {
            check(&name("entry angle"), angle, entry, entry, allowed)?;
        }
        let scale = pull.abs() + torque.abs() / RADIUS;
        check(&name("drawbar pull"), found.1, pull, scale, allowed)?;
        check(&name("torque"), found.2, torque, torque.abs(), allowed)
    }

    /// Parameters, slip and load.
    pub fn inputs(&self) -> (&[f64], f64, f64) {
        (&self.parameters, self.row.slip, self.row.normal_load)
    }

    fn shifted(&self, column: usize, value: f64) -> Case {
        let mut case = self.clone();
        match column.checked_sub(self.parameters.len()) {
            None => case.parameters[column] = value,
            Some(0) => case.contact.slip = value,
            Some(_) => case.contact.normal_load = value,
        }
        case
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_agrees_with_its_reference() {
        for case in cases(DRIVING)
            .unwrap()
            .iter()
            .chain(&cases(BRAKING).unwrap())
        {
            case.check_forces(&case.forces().unwrap()).unwrap();
            let (forces, jacobian) = case.jacobian().unwrap();
            case.check_jacobian(&forces, &jacobian).unwrap();
        }
    }

    #[test]
    fn a_wrong_answer_is_noticed() {
        let case = &cases(DRIVING).unwrap()[0];
        let (mut forces, mut jacobian) = case.jacobian().unwrap();
        jacobian[(1, 3)] *= 1.0 + 1e-3;
        assert!(case.check_jacobian(&forces, &jacobian).is_err());
        forces.resistive_torque *= 1.0 + 1e-8;
        assert!(case.check_forces(&forces).is_err());
        forces.resistive_torque = f64::NAN;
        assert!(case.check_forces(&forces).is_err());
    }
}
