//! Many contacts at once, as structure of arrays: one status an item, and nobody pays for a neighbour's fault.

use crate::contact::Contact;
use crate::error::ModelError;
use crate::forces::{Flags, WheelForces};

/// How a batch is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Double precision: the model's default tier.
    #[default]
    Double,
    /// Single precision where the model has it: two fifths of the cost, 1e-5.
    Single,
}

/// Contacts on virgin soil, item by item at the same index of every slice.
///
/// # Units
/// SI, slip in \[-1, 1\].
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// One slice a parameter of the model: a value an item, or a single one for all.
    pub parameters: &'a [&'a [f64]],
    /// Library slip \[1\].
    pub slip: &'a [f64],
    /// Normal load \[N\].
    pub normal_load: &'a [f64],
    /// Wheel radius \[m\].
    pub radius: f64,
    /// Wheel width \[m\].
    pub width: f64,
}

/// The forces of a batch. An item without forces holds NaN, and why in its status.
#[derive(Clone, Debug, Default)]
pub struct BatchForces {
    /// θ1 \[rad\]; NaN for models without one.
    pub entry_angle: Vec<f64>,
    /// D \[N\].
    pub drawbar_pull: Vec<f64>,
    /// T \[N m\].
    pub resistive_torque: Vec<f64>,
    /// z \[m\]; NaN for models without one.
    pub sinkage: Vec<f64>,
    /// The flags of an item's forces, or what a single call for it would have answered.
    pub status: Vec<Result<Flags, ModelError>>,
}

impl<'a> Batch<'a> {
    /// Number of items.
    pub fn len(&self) -> usize {
        self.slip.len()
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.slip.is_empty()
    }

    /// As many loads as slips, as many parameters as the model takes, each shared or one an item.
    ///
    /// # Errors
    /// [`ModelError::ParameterCount`], [`ModelError::BatchLength`].
    pub(crate) fn check(&self, model: &str, parameters: usize) -> Result<(), ModelError> {
        if self.parameters.len() != parameters {
            return Err(ModelError::ParameterCount {
                model: model.to_owned(),
                expected: parameters,
                found: self.parameters.len(),
            });
        }
        let items = self.len();
        let wrong = std::iter::once(self.normal_load.len())
            .filter(|&n| n != items)
            .chain(
                self.parameters
                    .iter()
                    .map(|p| p.len())
                    .filter(|&n| n != items && n != 1),
            )
            .next();
        match wrong {
            Some(found) => Err(ModelError::BatchLength {
                expected: items,
                found,
            }),
            None => Ok(()),
        }
    }

    /// The contact of an item; NaN beyond the last.
    pub(crate) fn contact(&self, item: usize) -> Contact<f64> {
        let of = |values: &[f64]| values.get(item).copied().unwrap_or(f64::NAN);
        Contact::new(of(self.slip), of(self.normal_load), self.radius, self.width)
    }

    /// The parameters of an item, into a buffer.
    pub(crate) fn item_parameters(&self, item: usize, into: &mut Vec<f64>) {
        into.clear();
        into.extend(self.parameters.iter().map(|p| value(p, item)));
    }

    /// Each item alone.
    pub(crate) fn one_by_one(
        &self,
        out: &mut BatchForces,
        forces: impl Fn(&[f64], &Contact<f64>) -> Result<WheelForces<f64>, ModelError>,
    ) {
        out.resize(self.len());
        let mut p = Vec::with_capacity(self.parameters.len());
        for item in 0..self.len() {
            self.item_parameters(item, &mut p);
            out.set(item, forces(&p, &self.contact(item)));
        }
    }
}

/// Value of an item in a slice that may be shared.
pub(crate) fn value(values: &[f64], item: usize) -> f64 {
    match values {
        [shared] => *shared,
        _ => values.get(item).copied().unwrap_or(f64::NAN),
    }
}

impl BatchForces {
    /// Makes room for `items`, all NaN until set; what was allocated is kept.
    pub(crate) fn resize(&mut self, items: usize) {
        for column in self.columns() {
            column.resize(items, f64::NAN);
        }
        self.status.resize(items, Ok(Flags::default()));
    }

    /// Sets an item.
    pub(crate) fn set(&mut self, item: usize, forces: Result<WheelForces<f64>, ModelError>) {
        let nan = f64::NAN;
        let (values, status) = match forces {
            Ok(f) => (
                [
                    f.angles.map_or(nan, |a| a.entry),
                    f.drawbar_pull,
                    f.resistive_torque,
                    f.sinkage.unwrap_or(nan),
                ],
                Ok(f.flags),
            ),
            Err(e) => ([nan; 4], Err(e)),
        };
        self.set_values(item, values);
        if let Some(slot) = self.status.get_mut(item) {
            *slot = status;
        }
    }

    /// Says of an item that its forces stand, with no flag but this.
    #[inline]
    pub(crate) fn set_good(&mut self, item: usize, deep_sinkage: bool) {
        if let Some(slot) = self.status.get_mut(item) {
            let flags = Flags {
                deep_sinkage,
                ..Flags::default()
            };
            match slot {
                // In place: nothing to drop.
                Ok(old) => *old = flags,
                Err(_) => *slot = Ok(flags),
            }
        }
    }

    /// Entry angles, pulls, torques and sinkages.
    pub(crate) fn columns(&mut self) -> [&mut Vec<f64>; 4] {
        [
            &mut self.entry_angle,
            &mut self.drawbar_pull,
            &mut self.resistive_torque,
            &mut self.sinkage,
        ]
    }

    /// Sets entry angle, pull, torque and sinkage of an item.
    fn set_values(&mut self, item: usize, values: [f64; 4]) {
        for (column, value) in self.columns().into_iter().zip(values) {
            if let Some(slot) = column.get_mut(item) {
                *slot = value;
            }
        }
    }
}
