//! A terrain model whose forces a Python method gives.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use terra_model::{
    AnyModel, Batch, BatchForces, Contact, Contributions, Dual8, Flags, ForceSlopes, Hook,
    LaneDual, Lanes, ModelAt, ModelError, Param, Precision, Soil, StressField, WheelForces,
};

use super::Trouble;
use super::describe;
use super::numbers::{self, Through, numbers};

/// What the method returns, in this order; NaN for what it leaves out.
const FORCES: [&str; 6] = [
    "drawbar_pull",
    "resistive_torque",
    "sinkage",
    "lateral_force",
    "thrust",
    "compaction_resistance",
];

/// A Python object with `name`, `parameters` and `wheel_forces(p, contact)`.
pub(super) struct PythonModel {
    object: Py<PyAny>,
    name: &'static str,
    summary: &'static str,
    reference: &'static str,
    params: &'static [Param],
    hooks: &'static [Hook],
    typical: Vec<Vec<f64>>,
    trouble: Trouble,
}

impl PythonModel {
    pub(super) fn new(object: &Bound<'_, PyAny>, trouble: Trouble) -> PyResult<Self> {
        let params = describe::parameters(object)?;
        Ok(PythonModel {
            name: describe::text(object, "name")?,
            summary: describe::text_or(object, "summary", "a model of one's own")?,
            reference: describe::text_or(object, "reference", "unpublished")?,
            params,
            typical: describe::typical(object, params)?,
            hooks: describe::hooks(object, "hooks")?,
            object: object.clone().unbind(),
            trouble,
        })
    }

    /// Parameters, then contact, in; [`FORCES`] out.
    fn call(&self, x: &[f64]) -> Result<Vec<f64>, ModelError> {
        let gone = || ModelError::Combination {
            name: self.name.to_owned(),
            reason: "the Python interpreter is gone".to_owned(),
        };
        Python::try_attach(|py| {
            self.ask(py, x)
                .map_err(|e| self.trouble.keep(py, self.name, e))
        })
        .unwrap_or_else(|| Err(gone()))
    }

    fn ask(&self, py: Python<'_>, x: &[f64]) -> PyResult<Vec<f64>> {
        let (p, at) = x.split_at(self.params.len());
        let values = PyDict::new(py);
        for (param, value) in self.params.iter().zip(p) {
            values.set_item(param.name, value)?;
        }
        let mut contact = [0.0; 25];
        contact.copy_from_slice(at);
        let answer = self
            .object
            .bind(py)
            .call_method1("wheel_forces", (values, numbers::Contact(contact)))?;
        let answer = answer.cast::<PyDict>()?;
        for key in answer.keys() {
            let key: String = key.extract()?;
            if !FORCES.contains(&key.as_str()) {
                return Err(pyo3::exceptions::PyKeyError::new_err(format!(
                    "wheel_forces returned '{key}', expected some of {}",
                    FORCES.join(", ")
                )));
            }
        }
        FORCES
            .iter()
            .enumerate()
            .map(|(k, name)| match answer.get_item(name)? {
                Some(value) => value.extract(),
                None if k < 2 => Err(pyo3::exceptions::PyKeyError::new_err(format!(
                    "wheel_forces returned no '{name}'"
                ))),
                None => Ok(f64::NAN),
            })
            .collect()
    }

    fn forces<T: Through>(&self, p: &[T], at: &Contact<T>) -> Result<WheelForces<T>, ModelError> {
        let inputs: Vec<T> = p.iter().copied().chain(numbers(at)).collect();
        // Which values there are is asked once, of plain numbers: NaN has no derivative to look at.
        let given = std::cell::RefCell::new(Vec::new());
        let out = T::through(&inputs, &|x| {
            let row = self.call(x)?;
            *given.borrow_mut() = row.iter().map(|v| !v.is_nan()).collect();
            Ok(row)
        })?;
        let given = given.into_inner();
        let value = |k: usize| {
            out.get(k)
                .copied()
                .filter(|_| given.get(k).copied().unwrap_or(false))
        };
        let or_zero = |k: usize| value(k).unwrap_or_else(T::zero);
        let pull = or_zero(0);
        let compaction = or_zero(5);
        Ok(WheelForces {
            drawbar_pull: pull,
            resistive_torque: or_zero(1),
            sinkage: value(2),
            lateral_force: or_zero(3),
            angles: None,
            parts: Contributions {
                thrust: value(4).unwrap_or(pull + compaction),
                lug_thrust: T::zero(),
                compaction_resistance: compaction,
                bulldozing_resistance: T::zero(),
                other: T::zero(),
            },
            flags: Flags::default(),
        })
    }
}

macro_rules! at_scalars {
    ($($scalar:ty),*) => {$(
        impl ModelAt<$scalar> for PythonModel {
            fn wheel_forces_at(
                &self,
                p: &[$scalar],
                at: &Contact<$scalar>,
            ) -> Result<WheelForces<$scalar>, ModelError> {
                self.forces(p, at)
            }
            fn soil_at(&self, _: &[$scalar], _: &Contact<$scalar>) -> Soil<$scalar> {
                Soil::unknown()
            }
        }
    )*};
}
at_scalars!(f64, Dual8, Lanes, LaneDual);

impl AnyModel for PythonModel {
    fn name(&self) -> &'static str {
        self.name
    }
    fn summary(&self) -> &'static str {
        self.summary
    }
    fn params(&self) -> &'static [Param] {
        self.params
    }
    fn equation(&self) -> &'static str {
        ""
    }
    fn reference(&self) -> &'static str {
        self.reference
    }
    fn hooks(&self) -> &'static [Hook] {
        self.hooks
    }
    fn force_slopes(&self, _: &[f64], _: &Contact<f64>) -> Result<Option<ForceSlopes>, ModelError> {
        Ok(None)
    }
    fn batch(
        &self,
        batch: &Batch<'_>,
        _: Precision,
        out: &mut BatchForces,
    ) -> Result<(), ModelError> {
        *out = BatchForces::default();
        for (item, (slip, load)) in batch.slip.iter().zip(batch.normal_load).enumerate() {
            let at = Contact::new(*slip, *load, batch.radius, batch.width);
            let of = |column: &&[f64]| match column {
                [shared] => *shared,
                many => many.get(item).copied().unwrap_or(f64::NAN),
            };
            let p: Vec<f64> = batch.parameters.iter().map(of).collect();
            let found = self.forces(&p, &at);
            let value = |get: fn(&WheelForces<f64>) -> Option<f64>| {
                found.as_ref().ok().and_then(get).unwrap_or(f64::NAN)
            };
            out.entry_angle.push(f64::NAN);
            out.drawbar_pull.push(value(|f| Some(f.drawbar_pull)));
            out.resistive_torque
                .push(value(|f| Some(f.resistive_torque)));
            out.sinkage.push(value(|f| f.sinkage));
            out.status.push(found.map(|f| f.flags));
        }
        Ok(())
    }
    fn typical_parameters(&self) -> Vec<Vec<f64>> {
        self.typical.clone()
    }
    fn stress_field(&self, _: &[f64], _: &Contact<f64>) -> Result<Option<StressField>, ModelError> {
        Ok(None)
    }
}
