//! What is behind a handle.

use std::ffi::CString;

use terra_model::{Contact, ForceLaw, Law, ModelError, Registry, WheelForces, catalogue};

use crate::status::{Failure, TerraStatus};

/// A terrain model with effects and the values of their parameters. Opaque.
pub struct TerraLaw {
    law: Law,
    values: Vec<f64>,
    names: Vec<CString>,
}

/// One wheel's contact. Fill it with zeros, then set what is known; slip, load, radius and width must be.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TerraContact {
    /// Slip in [-1, 1]: driving 1 - v/(R w), braking R w/v - 1.
    pub slip: f64,
    /// Normal load, N.
    pub normal_load: f64,
    /// Wheel radius, m.
    pub radius: f64,
    /// Wheel width, m.
    pub width: f64,
    /// Speed of the wheel centre, m/s; 0 when unknown.
    pub speed: f64,
    /// Slip angle, rad: the wheel moves to the left of where it points.
    pub slip_angle: f64,
    /// Earlier passes over this track; 0 on virgin soil.
    pub earlier_passes: f64,
}

/// What the ground gives the wheel. NaN for what the model does not have.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TerraForces {
    /// Net forward force, N.
    pub drawbar_pull: f64,
    /// Torque against the drive, N m.
    pub resistive_torque: f64,
    /// Sideways force, N, to the left.
    pub lateral_force: f64,
    /// Depth below the undisturbed surface, m.
    pub sinkage: f64,
    /// Entry angle, rad from the downward vertical.
    pub entry_angle: f64,
}

impl TerraForces {
    pub(crate) const NONE: TerraForces = TerraForces {
        drawbar_pull: f64::NAN,
        resistive_torque: f64::NAN,
        lateral_force: f64::NAN,
        sinkage: f64::NAN,
        entry_angle: f64::NAN,
    };
}

impl From<WheelForces<f64>> for TerraForces {
    fn from(f: WheelForces<f64>) -> Self {
        TerraForces {
            drawbar_pull: f.drawbar_pull,
            resistive_torque: f.resistive_torque,
            lateral_force: f.lateral_force,
            sinkage: f.sinkage.unwrap_or(f64::NAN),
            entry_angle: f.angles.map_or(f64::NAN, |a| a.entry),
        }
    }
}

impl From<&TerraContact> for Contact<f64> {
    fn from(c: &TerraContact) -> Self {
        Contact {
            speed: c.speed,
            slip_angle: c.slip_angle,
            earlier_passes: c.earlier_passes,
            ..Contact::new(c.slip, c.normal_load, c.radius, c.width)
        }
    }
}

impl TerraLaw {
    /// `model`, or `model+effect+effect`. Effects start at 0, the model's parameters at NaN: not set.
    pub(crate) fn new(name: &str) -> Result<Self, Failure> {
        let law = Registry::builtin().with_forms().law(name)?;
        let of_model = law.model().params().len();
        let mut values = vec![f64::NAN; of_model];
        values.resize(law.params().len(), 0.0);
        let names = law
            .params()
            .iter()
            .enumerate()
            .map(|(k, p)| CString::new(Self::name(&law, k, p.name)).unwrap_or_default())
            .collect();
        Ok(TerraLaw { law, values, names })
    }

    /// A parameter's name; that of an effect's has the effect before it, as two effects may both have a `magnitude`.
    fn name(law: &Law, index: usize, name: &str) -> String {
        let mut first = law.model().params().len();
        for effect in law.effects() {
            let end = first + effect.params().len();
            if (first..end).contains(&index) {
                return format!("{}.{name}", effect.name());
            }
            first = end;
        }
        name.to_owned()
    }

    pub(crate) fn names(&self) -> &[CString] {
        &self.names
    }

    /// The model's parameters from a soil of the catalogue.
    pub(crate) fn set_terrain(&mut self, id: &str) -> Result<(), Failure> {
        let values = catalogue::find(id)?.parameters(self.law.model())?;
        for (slot, value) in self.values.iter_mut().zip(values) {
            *slot = value;
        }
        Ok(())
    }

    fn place(&self, name: &str) -> Result<usize, Failure> {
        let names = || self.names.iter().filter_map(|n| n.to_str().ok());
        names().position(|n| n == name).ok_or_else(|| {
            ModelError::UnknownName {
                kind: "parameter",
                name: name.to_owned(),
                nearest: terra_model::nearest(name, names()).map(str::to_owned),
            }
            .into()
        })
    }

    pub(crate) fn set(&mut self, name: &str, value: f64) -> Result<(), Failure> {
        let place = self.place(name)?;
        if !value.is_finite() {
            let text = format!("{name} = {value}, expected a finite number");
            return Err(Failure(TerraStatus::OutOfRange, text));
        }
        if let Some(slot) = self.values.get_mut(place) {
            *slot = value;
        }
        Ok(())
    }

    pub(crate) fn get(&self, name: &str) -> Result<f64, Failure> {
        let place = self.place(name)?;
        Ok(self.values.get(place).copied().unwrap_or(f64::NAN))
    }

    pub(crate) fn forces(&self, at: &TerraContact) -> Result<TerraForces, ModelError> {
        Ok(self.law.forces(&self.values, &at.into())?.into())
    }

    /// Forces, and their slopes: drawbar pull, torque, sinkage, each by slip and by load.
    pub(crate) fn slopes(&self, at: &TerraContact) -> Result<(TerraForces, [f64; 6]), ModelError> {
        let (forces, jacobian) = self.law.jacobian(&self.values, &at.into())?;
        let n = self.values.len();
        let slope = |row: usize, column: usize| jacobian.get((row, n + column)).copied();
        let mut out = [f64::NAN; 6];
        for (k, slot) in out.iter_mut().enumerate() {
            *slot = slope(k / 2, k % 2).unwrap_or(f64::NAN);
        }
        if forces.sinkage.is_none() {
            out[4] = f64::NAN;
            out[5] = f64::NAN;
        }
        Ok((forces.into(), out))
    }
}
