//! An effect whose change of the contact or of the forces a Python method gives.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use terra_model::{
    AnyEffect, BodyLoads, Channel, Contact, Dual8, EffectAt, Hook, LaneDual, Lanes, ModelError,
    Motion, Param, Scope, Soil, Touch, Vehicle, WheelForces,
};

use super::Trouble;
use super::describe;
use super::numbers::{self, CONTACT, Through, contact, numbers};
use crate::error::ConfigurationError;

/// What `after` may change, in this order.
const FORCES: [&str; 4] = [
    "drawbar_pull",
    "resistive_torque",
    "sinkage",
    "lateral_force",
];

/// A Python object with `name`, `parameters` and `before(e, contact)` or `after(e, contact, forces)` or both; each
/// returns a dict of what it changes.
pub(super) struct PythonEffect {
    object: Py<PyAny>,
    name: &'static str,
    summary: &'static str,
    reference: &'static str,
    regime: &'static str,
    isolated_by: &'static str,
    params: &'static [Param],
    needs: &'static [Hook],
    touches: &'static [Touch],
    scope: Scope,
    flat: bool,
    trouble: Trouble,
}

impl PythonEffect {
    pub(super) fn new(object: &Bound<'_, PyAny>, trouble: Trouble) -> PyResult<Self> {
        let touches: &'static [Touch] = match (object.hasattr("before")?, object.hasattr("after")?)
        {
            (true, true) => &[Touch::Contact, Touch::Forces],
            (true, false) => &[Touch::Contact],
            (false, true) => &[Touch::Forces],
            (false, false) => {
                return Err(ConfigurationError::new_err(
                    "an effect needs a method before(e, contact) or after(e, contact, forces)",
                ));
            }
        };
        let scope = match describe::text_or(object, "scope", "any")? {
            "any" => Scope::Any,
            "drive" => Scope::Drive,
            "rig" => Scope::Rig,
            other => {
                return Err(ConfigurationError::new_err(format!(
                    "scope = '{other}', expected 'any', 'drive' or 'rig'"
                )));
            }
        };
        Ok(PythonEffect {
            name: describe::text(object, "name")?,
            summary: describe::text_or(object, "summary", "an effect of one's own")?,
            reference: describe::text_or(object, "reference", "unpublished")?,
            regime: describe::text_or(object, "regime", "")?,
            isolated_by: describe::text_or(object, "isolated_by", "")?,
            params: describe::parameters(object)?,
            needs: describe::hooks(object, "needs")?,
            touches,
            scope,
            flat: match object.getattr_opt("flat")? {
                Some(flat) => flat.extract()?,
                None => false,
            },
            object: object.clone().unbind(),
            trouble,
        })
    }

    fn magnitudes<'py>(&self, py: Python<'py>, e: &[f64]) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for (param, value) in self.params.iter().zip(e) {
            out.set_item(param.name, value)?;
        }
        Ok(out)
    }

    /// Numbers changed by a method; NaN out of a method that raised, which the settling of the task reports.
    fn changed(
        &self,
        method: &str,
        x: &[f64],
        names: &[&str],
        ask: &dyn Fn(Python<'_>) -> PyResult<Py<PyAny>>,
        old: &[f64],
    ) -> Result<Vec<f64>, ModelError> {
        debug_assert!(!x.is_empty());
        let done = Python::try_attach(|py| -> PyResult<Vec<f64>> {
            let answer = ask(py)?;
            let answer = answer.bind(py).cast::<PyDict>()?;
            let mut row = old.to_vec();
            for (key, value) in answer {
                let key: String = key.extract()?;
                let at = names.iter().position(|n| *n == key).ok_or_else(|| {
                    pyo3::exceptions::PyKeyError::new_err(format!(
                        "{method} changed '{key}', expected some of {}",
                        names.join(", ")
                    ))
                })?;
                row[at] = value.extract()?;
            }
            Ok(row)
        });
        match done {
            Some(Ok(row)) => Ok(row),
            Some(Err(e)) => {
                Python::try_attach(|py| self.trouble.keep(py, self.name, e));
                Ok(vec![f64::NAN; old.len()])
            }
            None => Ok(vec![f64::NAN; old.len()]),
        }
    }

    fn before<T: Through>(&self, e: &[T], at: &mut Contact<T>) {
        if !self.touches.contains(&Touch::Contact) {
            return;
        }
        let n = e.len();
        let inputs: Vec<T> = e.iter().copied().chain(numbers(at)).collect();
        let out = T::through(&inputs, &|x| {
            let mut c = [0.0; 25];
            c.copy_from_slice(&x[n..]);
            let ask = |py: Python<'_>| {
                let e = self.magnitudes(py, &x[..n])?;
                self.object
                    .call_method1(py, "before", (e, numbers::Contact(c)))
            };
            self.changed("before", x, &CONTACT, &ask, &c)
        });
        if let Some(row) = out.ok().and_then(|row| <[T; 25]>::try_from(row).ok()) {
            *at = contact(row, &at.hooks);
        }
    }

    fn after<T: Through>(&self, e: &[T], at: &Contact<T>, forces: &mut WheelForces<T>) {
        if !self.touches.contains(&Touch::Forces) {
            return;
        }
        let n = e.len();
        let old = [
            forces.drawbar_pull,
            forces.resistive_torque,
            forces.sinkage.unwrap_or_else(T::zero),
            forces.lateral_force,
        ];
        let inputs: Vec<T> = e.iter().copied().chain(numbers(at)).chain(old).collect();
        let has_sinkage = forces.sinkage.is_some();
        let out = T::through(&inputs, &|x| {
            let mut c = [0.0; 25];
            c.copy_from_slice(&x[n..n + 25]);
            let f = &x[n + 25..];
            let ask = |py: Python<'_>| {
                let e = self.magnitudes(py, &x[..n])?;
                let given = PyDict::new(py);
                for (k, (name, value)) in FORCES.iter().zip(f).enumerate() {
                    if k != 2 || has_sinkage {
                        given.set_item(name, value)?;
                    }
                }
                self.object
                    .call_method1(py, "after", (e, numbers::Contact(c), given))
            };
            self.changed("after", x, &FORCES, &ask, f)
        });
        if let Ok([pull, torque, sinkage, lateral]) = out.as_deref() {
            forces.parts.other += *pull - forces.drawbar_pull;
            forces.drawbar_pull = *pull;
            forces.resistive_torque = *torque;
            forces.sinkage = forces.sinkage.map(|_| *sinkage);
            forces.lateral_force = *lateral;
        }
    }
}

macro_rules! at_scalars {
    ($($scalar:ty),*) => {$(
        impl EffectAt<$scalar> for PythonEffect {
            fn alter_contact(
                &self,
                e: &[$scalar],
                _: &Soil<$scalar>,
                at: &mut Contact<$scalar>,
            ) {
                self.before(e, at);
            }
            fn alter_forces(
                &self,
                e: &[$scalar],
                _: &Soil<$scalar>,
                at: &Contact<$scalar>,
                forces: &mut WheelForces<$scalar>,
            ) {
                self.after(e, at, forces);
            }
            fn vehicle_at(&self, _: &[$scalar], vehicle: Vehicle<$scalar>) -> Vehicle<$scalar> {
                vehicle
            }
            fn loads_at(
                &self,
                _: &[$scalar],
                _: &Vehicle<$scalar>,
                _: &Motion<$scalar>,
                loads: BodyLoads<$scalar>,
            ) -> BodyLoads<$scalar> {
                loads
            }
            fn report_at(&self, _: &[$scalar], _: Channel, truth: $scalar, _: $scalar) -> $scalar {
                truth
            }
        }
    )*};
}
at_scalars!(f64, Dual8, Lanes, LaneDual);

impl AnyEffect for PythonEffect {
    fn name(&self) -> &'static str {
        self.name
    }
    fn form(&self) -> &'static str {
        "default"
    }
    fn summary(&self) -> &'static str {
        self.summary
    }
    fn params(&self) -> &[Param] {
        self.params
    }
    fn equation(&self) -> &'static str {
        ""
    }
    fn reference(&self) -> &'static str {
        self.reference
    }
    fn needs(&self) -> &'static [Hook] {
        self.needs
    }
    fn needs_soil(&self) -> &'static [&'static str] {
        &[]
    }
    fn touches(&self) -> &'static [Touch] {
        self.touches
    }
    fn scope(&self) -> Scope {
        self.scope
    }
    fn is_flat(&self) -> bool {
        self.flat
    }
    fn regime(&self) -> &'static str {
        self.regime
    }
    fn isolated_by(&self) -> &'static str {
        self.isolated_by
    }
}
