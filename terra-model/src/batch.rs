//! Many contacts at once, as structure of arrays: one status an item, and nobody pays for a neighbour's fault.

use crate::contact::Contact;
use crate::error::ModelError;
use crate::forces::{Flags, WheelForces};
use crate::lanes::{Lanes, Vector};

/// How a batch is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Double precision: the model's default tier.
    #[default]
    Double,
    /// Single precision where the model has it (`wong-reece` without effects): two fifths of the cost, 1e-5.
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

    /// Items that brake, and items that do not, eight at a time in lanes; alone what is illegal, what has a neighbour without
    /// an answer, and what has to be told of itself (a wheel sunk deep). `slip_stays` where no effect may make a wheel brake.
    pub(crate) fn side_by_side(
        &self,
        out: &mut BatchForces,
        slip_stays: bool,
        legal: impl Fn(&[f64], &Contact<f64>) -> Result<(), ModelError>,
        alone: impl Fn(&[f64], &Contact<f64>) -> Result<WheelForces<f64>, ModelError>,
        together: impl Fn(&[Lanes], &Contact<Lanes>) -> Result<WheelForces<Lanes>, ModelError>,
    ) {
        out.resize(self.len());
        let mut p = Vec::with_capacity(self.parameters.len());
        let mut kinds = [vec![], vec![]];
        for item in 0..self.len() {
            self.item_parameters(item, &mut p);
            let at = self.contact(item);
            match legal(&p, &at) {
                Ok(()) => kinds[usize::from(at.slip < 0.0)].push(item),
                Err(e) => out.set(item, Err(e)),
            }
        }
        for items in kinds.iter().flat_map(|items| items.chunks(Lanes::WIDTH)) {
            let found = if items.len() < WORTH {
                None
            } else {
                let p: Vec<Lanes> = self.parameters.iter().map(|p| gathered(p, items)).collect();
                let (slip, load) = (
                    gathered(self.slip, items),
                    gathered(self.normal_load, items),
                );
                let (radius, width) = (Lanes::from(self.radius), Lanes::from(self.width));
                together(&p, &Contact::new(slip, load, radius, width)).ok()
            };
            let usual = |f: &WheelForces<Lanes>| {
                let braking = f.flags.braking && slip_stays;
                f.flags
                    == Flags {
                        braking,
                        ..Flags::default()
                    }
            };
            match found.filter(usual) {
                Some(forces) => {
                    for (lane, &item) in items.iter().enumerate() {
                        let of = |v: Lanes| v.lane(lane);
                        let nan = f64::NAN;
                        let values = [
                            forces.angles.map_or(nan, |a| of(a.entry)),
                            of(forces.drawbar_pull),
                            of(forces.resistive_torque),
                            forces.sinkage.map_or(nan, of),
                        ];
                        out.set_values(item, values);
                        out.set_status(item, Ok(forces.flags));
                    }
                }
                None => {
                    for &item in items {
                        self.item_parameters(item, &mut p);
                        out.set(item, alone(&p, &self.contact(item)));
                    }
                }
            }
        }
    }
}

/// Items from which lanes are cheaper than one after the other.
const WORTH: usize = 3;

/// Values of items side by side; the last fills the lanes that are left over.
fn gathered(values: &[f64], items: &[usize]) -> Lanes {
    let last = items.len().saturating_sub(1);
    let lanes = (0..Lanes::WIDTH).filter_map(|lane| items.get(lane.min(last)));
    Lanes::gather(lanes.map(|&item| value(values, item)))
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
        self.set_status(item, status);
    }

    fn set_status(&mut self, item: usize, status: Result<Flags, ModelError>) {
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
