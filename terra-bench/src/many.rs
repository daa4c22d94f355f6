//! The same rows as a batch, and a force map of one soil.

use terra_model::{
    Batch, BatchForces, ForceMap, Law, MapRange, ModelError, Precision, Registry, catalogue,
};

use crate::error::BenchError;
use crate::wheel::{Case, DRIVING, RADIUS, WIDTH, cases};

/// How often the rows are repeated, so that a batch fills its lanes, those of its second pass included.
const REPEATS: usize = 16;

/// Columns of a batch.
pub struct Columns {
    cases: Vec<Case>,
    parameters: Vec<Vec<f64>>,
    slip: Vec<f64>,
    normal_load: Vec<f64>,
    law: Law,
    out: BatchForces,
}

impl Columns {
    /// The driving rows, `REPEATS` times over.
    ///
    /// # Errors
    /// [`BenchError::Model`].
    pub fn new() -> Result<Self, BenchError> {
        let cases = cases(DRIVING)?;
        let mut columns = Columns {
            parameters: vec![vec![]; 8],
            slip: vec![],
            normal_load: vec![],
            law: Registry::builtin().law("wong-reece")?,
            out: BatchForces::default(),
            cases,
        };
        for case in (0..REPEATS).flat_map(|_| &columns.cases) {
            let (p, slip, load) = case.inputs();
            for (column, &value) in columns.parameters.iter_mut().zip(p) {
                column.push(value);
            }
            columns.slip.push(slip);
            columns.normal_load.push(load);
        }
        Ok(columns)
    }

    /// Number of contacts.
    pub fn items(&self) -> usize {
        self.slip.len()
    }

    /// Solves all.
    ///
    /// # Errors
    /// [`BenchError::Model`].
    pub fn solve(&mut self, precision: Precision) -> Result<&BatchForces, BenchError> {
        let parameters: Vec<&[f64]> = self.parameters.iter().map(Vec::as_slice).collect();
        let batch = Batch {
            parameters: &parameters,
            slip: &self.slip,
            normal_load: &self.normal_load,
            radius: RADIUS,
            width: WIDTH,
        };
        self.law.solve_batch(&batch, precision, &mut self.out)?;
        Ok(&self.out)
    }

    /// Solves all and compares each with its reference: 1e-7 in double precision, 1e-5 in single.
    ///
    /// # Errors
    /// [`BenchError::Wrong`]; [`BenchError::Model`] of an item.
    pub fn check(&mut self, precision: Precision) -> Result<(), BenchError> {
        let allowed = match precision {
            Precision::Double => 1e-7,
            Precision::Single => 1e-5,
        };
        self.solve(precision)?;
        let out = &self.out;
        for (item, case) in self.cases.iter().cycle().take(self.slip.len()).enumerate() {
            out.status[item].clone()?;
            let found = (
                Some(out.entry_angle[item]),
                out.drawbar_pull[item],
                out.resistive_torque[item],
            );
            case.check_values(found, allowed)?;
        }
        Ok(())
    }
}

/// A map of dry sand, and the rows it answers.
pub struct Lookup {
    map: ForceMap,
    cases: Vec<Case>,
}

impl Lookup {
    /// Slips .02 to 1, 60 to 600 N, right to 1e-4.
    ///
    /// # Errors
    /// [`BenchError::Model`].
    pub fn new() -> Result<Self, BenchError> {
        let law = Registry::builtin().law("wong-reece")?;
        let p = catalogue::find("dry_sand")?.parameters(law.model())?;
        let range = MapRange {
            slip: (0.02, 1.0),
            normal_load: (60.0, 600.0),
        };
        let map = ForceMap::within(&law, &p, range, RADIUS, WIDTH, 1e-4)?;
        let rows: Vec<_> = DRIVING
            .iter()
            .filter(|row| row.soil == "dry_sand" && row.normal_load < 600.0)
            .copied()
            .collect();
        Ok(Lookup {
            map,
            cases: cases(&rows)?,
        })
    }

    /// Queries a round.
    pub fn queries(&self) -> usize {
        self.cases.len()
    }

    /// Looks up every row; the sum of pull and torque.
    ///
    /// # Errors
    /// [`BenchError::Model`].
    pub fn round(&self) -> Result<[f64; 2], ModelError> {
        let mut sum = [0.0; 2];
        for case in &self.cases {
            let (_, slip, load) = case.inputs();
            let [pull, torque] = self.map.forces(slip, load)?;
            sum = [sum[0] + pull, sum[1] + torque];
        }
        Ok(sum)
    }

    /// Compares every row with its reference.
    ///
    /// # Errors
    /// [`BenchError::Wrong`], [`BenchError::Model`].
    pub fn check(&self) -> Result<(), BenchError> {
        for case in &self.cases {
            let (_, slip, load) = case.inputs();
            let [pull, torque] = self.map.forces(slip, load)?;
            case.check_values((None, pull, torque), 1e-4)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_and_maps_agree_with_their_references() {
        let mut columns = Columns::new().unwrap();
        columns.check(Precision::Double).unwrap();
        columns.check(Precision::Single).unwrap();
        Lookup::new().unwrap().check().unwrap();
    }
}
