//! Rig logs: one contact a row, drawbar pull, torque and sinkage against the model's, slip and load noisy inputs.

mod read;

pub(crate) use read::{from_log, from_logs, is_bare, median, on_one_soil, soils};

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use terra_data::{Measured, RigRow, WheelData};
use terra_model::{
    BodyLoads, Channel, Contact, LaneDual, Lanes, Law, Motion, Scalar, StressProfile, Touch,
    Vector, Vehicle, library_slip,
};

use crate::abreast::{self, WORTH, in_groups, side_by_side};
use crate::dataset::{ChannelInfo, DataSet};
use crate::error::GapError;
use crate::logs::of_log;
use crate::memory::Memory;
use crate::predictor::{Design, Predict, Sloped, varying};
use crate::sensor;

/// What a rig measures, in the order of the data set's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Output {
    DrawbarPull,
    Torque,
    Sinkage,
}

impl Output {
    const ALL: [Output; 3] = [Output::DrawbarPull, Output::Torque, Output::Sinkage];

    fn name(self) -> &'static str {
        match self {
            Output::DrawbarPull => "drawbar_pull_N",
            Output::Torque => "torque_N_m",
            Output::Sinkage => "sinkage_m",
        }
    }
    fn unit(self) -> &'static str {
        match self {
            Output::DrawbarPull => "N",
            Output::Torque => "N m",
            Output::Sinkage => "m",
        }
    }
    /// The ground's scatter from row to row, as a rover file may state it.
    fn roughness(self) -> Option<&'static str> {
        match self {
            Output::DrawbarPull => Some("roughness_N"),
            Output::Torque => Some("roughness_N_m"),
            Output::Sinkage => None,
        }
    }
    fn of(self, row: &RigRow) -> Option<Measured> {
        match self {
            Output::DrawbarPull => row.drawbar_pull,
            Output::Torque => row.torque,
            Output::Sinkage => row.sinkage,
        }
    }
}

/// What a row is measured at, in the scalar of its readings.
struct At<T> {
    slip: T,
    load: T,
    speed: T,
    wheel_speed: T,
    path: T,
    earlier_passes: T,
}

impl<T: Scalar> At<T> {
    fn of(row: &Row, slip: T, load: T) -> Self {
        At {
            slip,
            load,
            speed: T::from(row.speed),
            wheel_speed: T::from(row.wheel_speed),
            path: T::from(row.path),
            earlier_passes: T::from(row.earlier_passes),
        }
    }
}

/// One row, ready for prediction.
#[derive(Clone, Debug)]
struct Row {
    outputs: Vec<Output>,
    values: Vec<f64>,
    slip: f64,
    load: f64,
    wheel: WheelData,
    earlier_passes: f64,
    speed: f64,
    wheel_speed: f64,
    /// Path since its trial began \[m\]; 0 where the log tells none.
    path: f64,
    /// Number of its soil.
    soil: usize,
    /// Whether it is said to have no lugs.
    bare: bool,
}

/// Predicts rig rows.
#[derive(Clone, Debug)]
pub struct RigPredictor {
    rows: Vec<Row>,
    /// How many soils there are.
    soils: usize,
}

impl RigPredictor {
    /// The contact of a row as logged.
    pub fn contact(&self, index: usize) -> Contact<f64> {
        let row = &self.rows[index];
        let mut at = Contact::new(row.slip, row.load, row.wheel.radius, row.wheel.width);
        at.speed = row.speed;
        at.wheel_speed = row.wheel_speed;
        at.path = row.path;
        at.earlier_passes = row.earlier_passes;
        at
    }

    /// Predicted readings of the channels of a row at a contact.
    ///
    /// # Errors
    /// Where the model has no answer.
    fn readings<T: Scalar>(
        law: &Law,
        p: &[T],
        row: &Row,
        given: &At<T>,
    ) -> Result<Vec<T>, GapError> {
        let p = &*without_lugs(law, p, row);
        let (zero, slip) = (T::zero(), given.slip);
        // Rim speed over travel speed is what a speed error changes.
        let braking = slip.select_lt(zero, T::one(), zero);
        let (mut rim, mut travel) = (
            T::one() + slip * braking,
            T::one() - slip * (T::one() - braking),
        );
        let truth = |reported| sensor::truth(law, p, Channel::GroundSpeed, reported);
        if row.speed > 0.0 {
            (rim, travel) = (rim * given.speed / travel, truth(given.speed));
        } else {
            // Neither is known, and one of them is 1: an offset in m/s says nothing of these.
            travel = truth(travel) - truth(zero);
        }
        let mut at = Contact::new(
            library_slip(rim, travel),
            given.load,
            T::from(row.wheel.radius),
            T::from(row.wheel.width),
        );
        at.speed = given.speed;
        at.wheel_speed = given.wheel_speed;
        at.path = given.path;
        at.earlier_passes = given.earlier_passes;
        let forces = law.forces_at(p, &at)?;

        let mut torque = forces.resistive_torque + at.wheel_speed * row.wheel.damping;
        if row.wheel_speed != 0.0 {
            let motion = Motion {
                speed: at.speed,
                acceleration: zero,
                yaw_rate: zero,
                wheel_speed: [at.wheel_speed; 4],
                wheel_torque: [torque; 4],
                path: zero,
                time: zero,
            };
            let vehicle = wheel_only(row, at.radius);
            let loads = law
                .acting(p, Touch::Loads)
                .fold(BodyLoads::none(), |loads, (effect, e)| {
                    T::of_effect(&**effect).loads_at(e, &vehicle, &motion, loads)
                });
            torque += loads.wheel_torque[0];
        }
        Ok(row
            .outputs
            .iter()
            .map(|o| match o {
                Output::DrawbarPull => {
                    sensor::report(law, p, Channel::DrawbarPull, forces.drawbar_pull, zero)
                }
                Output::Torque => sensor::report(law, p, Channel::WheelTorque, torque, zero),
                Output::Sinkage => sensor::report(
                    law,
                    p,
                    Channel::Sinkage,
                    forces.sinkage.unwrap_or(zero),
                    zero,
                ),
            })
            .collect())
    }

    /// Predicted readings (drawbar pull, torque, sinkage as far as the row has them) at another slip and load.
    ///
    /// # Errors
    /// Where the model has no answer.
    pub fn curve(
        &self,
        law: &Law,
        p: &[f64],
        index: usize,
        slip: f64,
        load: f64,
    ) -> Result<Vec<f64>, GapError> {
        let row = &self.rows[index];
        let p = of_log(law, p, self.soils, row.soil);
        Self::readings(law, &p, row, &At::of(row, slip, load))
    }

    /// Stresses along the contact of a row's wheel at another slip and load, under the law's effects; `None` for a law
    /// without stresses.
    ///
    /// # Errors
    /// Where the model has no answer.
    pub fn stresses(
        &self,
        law: &Law,
        p: &[f64],
        index: usize,
        [slip, load]: [f64; 2],
        points: usize,
    ) -> Result<Option<StressProfile>, GapError> {
        let row = &self.rows[index];
        let mut at = Contact::new(slip, load, row.wheel.radius, row.wheel.width);
        at.speed = row.speed;
        at.wheel_speed = row.wheel_speed;
        at.path = row.path;
        at.earlier_passes = row.earlier_passes;
        let p = of_log(law, p, self.soils, row.soil);
        Ok(law.stresses(&without_lugs(law, &p, row), &at, points)?)
    }
}

/// The effect of lugs.
const LUGS: &str = "grousers";

/// The parameters without lugs, where the row's wheel has none.
fn without_lugs<'p, T: Scalar>(law: &Law, p: &'p [T], row: &Row) -> Cow<'p, [T]> {
    let mut p = Cow::Borrowed(p);
    let mut first = law.model().params().len();
    for effect in law.effects() {
        let next = first + effect.params().len();
        if row.bare && effect.name() == LUGS {
            let own = p.to_mut().iter_mut().take(next).skip(first);
            own.for_each(|e| *e = T::zero());
        }
        first = next;
    }
    p
}

/// What rows have in common that are predicted at once.
type Kind<'a> = (usize, &'a [Output], WheelData, [bool; 4]);

impl abreast::Kind for Kind<'_> {}

impl Row {
    fn kind(&self) -> Kind<'_> {
        let moves = [self.wheel_speed != 0.0, self.speed > 0.0];
        let way = [self.slip < 0.0, moves[0], moves[1], self.bare];
        (self.soil, &self.outputs, self.wheel, way)
    }
}

impl RigPredictor {
    /// Up to eight rows of one kind at once. `raw`: a raw quantity by its place; `of_lane`: what is wanted of a residual.
    fn together<T: Scalar<Primal = Lanes>, A>(
        &self,
        law: &Law,
        p: &[T],
        rows: &[usize],
        raw: impl Fn(usize, Lanes) -> T,
        of_lane: impl Fn(&T, usize) -> A,
    ) -> Result<Vec<Vec<A>>, GapError> {
        let rows: Vec<&Row> = rows.iter().map(|&i| &self.rows[i]).collect();
        let Some(first) = rows.first() else {
            return Ok(vec![]);
        };
        let n = first.values.len();
        let lift = |of: &dyn Fn(&Row) -> f64| T::from_primal(side_by_side(&rows, |r| of(r)));
        let given = At {
            slip: raw(n, side_by_side(&rows, |r| r.slip)),
            load: raw(n + 1, side_by_side(&rows, |r| r.load)),
            speed: lift(&|r| r.speed),
            wheel_speed: lift(&|r| r.wheel_speed),
            path: lift(&|r| r.path),
            earlier_passes: lift(&|r| r.earlier_passes),
        };
        let p = of_log(law, p, self.soils, first.soil);
        let predicted = Self::readings(law, &p, first, &given)?;
        let residual = |(k, f): (usize, &T)| raw(k, side_by_side(&rows, |r| r.values[k])) - *f;
        let residual: Vec<T> = predicted.iter().enumerate().map(residual).collect();
        let of_row = |lane| residual.iter().map(|r| of_lane(r, lane)).collect();
        Ok((0..rows.len()).map(of_row).collect())
    }
}

/// A "vehicle" that is one wheel: only the wheel's numbers mean anything on a rig.
fn wheel_only<T: Scalar>(row: &Row, radius: T) -> Vehicle<T> {
    let zero = T::zero();
    Vehicle {
        mass: zero,
        yaw_inertia: zero,
        track: zero,
        wheelbase: zero,
        cg_to_front_axle: zero,
        cg_height: zero,
        yaw_damping: zero,
        wheel_radius: radius,
        wheel_width: T::from(row.wheel.width),
        wheel_inertia: T::from(row.wheel.inertia),
        wheel_damping: T::from(row.wheel.damping),
        pitch: zero,
    }
}

impl Predict for RigPredictor {
    fn raw(&self, index: usize) -> Vec<f64> {
        let row = &self.rows[index];
        let mut raw = row.values.clone();
        raw.extend([row.slip, row.load]);
        raw
    }

    fn residual<T: Scalar>(
        &self,
        law: &Law,
        p: &[T],
        index: usize,
        raw: &[T],
    ) -> Result<Vec<T>, GapError> {
        let row = &self.rows[index];
        let n = row.values.len();
        let p = of_log(law, p, self.soils, row.soil);
        let predicted = Self::readings(law, &p, row, &At::of(row, raw[n], raw[n + 1]))?;
        Ok(raw.iter().zip(predicted).map(|(y, f)| *y - f).collect())
    }

    fn residuals(
        &self,
        law: &Law,
        p: &[f64],
        indices: &[usize],
        _memory: &Memory,
    ) -> Result<Vec<Vec<f64>>, GapError> {
        let in_lanes: Vec<Lanes> = p.iter().map(|&v| Lanes::from(v)).collect();
        in_groups(
            indices,
            |i| self.rows[i].kind(),
            WORTH,
            |rows| self.together(law, &in_lanes, rows, |_, x| x, |r: &Lanes, k| r.lane(k)),
            |i| self.residual(law, p, i, &self.raw(i)),
        )
    }

    fn slopes(
        &self,
        law: &Law,
        p: &[LaneDual],
        varied: &Range<usize>,
        indices: &[usize],
        _memory: &Memory,
    ) -> Result<Vec<Vec<Sloped>>, GapError> {
        let together = |rows: &[usize]| {
            self.together(law, p, rows, |k, x| varying(k, x, varied), Sloped::of_lane)
        };
        let kind = |i: usize| self.rows[i].kind();
        in_groups(indices, kind, 1, together, |i| Ok(together(&[i])?.concat()))
    }

    fn value_positions(&self, index: usize) -> Vec<usize> {
        (0..self.rows[index].values.len()).collect()
    }

    fn slip(&self, index: usize, raw: &[f64]) -> Option<f64> {
        raw.get(self.rows[index].values.len()).copied()
    }

    fn with_raw(&self, replaced: &[(usize, Vec<f64>)]) -> Self {
        let mut out = self.clone();
        for (index, raw) in replaced {
            let row = &mut out.rows[*index];
            let n = row.values.len();
            row.values.copy_from_slice(&raw[..n]);
            (row.slip, row.load) = (raw[n], raw[n + 1]);
        }
        out
    }

    fn designs(&self, data: &DataSet) -> Vec<Design> {
        let mut designs = vec![];
        let mut vary = |manoeuvre: &str, change: &dyn Fn(&mut Row)| {
            let mut predictor = self.clone();
            predictor.rows.iter_mut().for_each(change);
            designs.push(Design {
                manoeuvre: manoeuvre.to_owned(),
                data: data.clone(),
                predictor: Arc::new(predictor),
            });
        };
        vary("the same slips at twice the load", &|row| row.load *= 2.0);
        vary("the same slips at half the load", &|row| row.load *= 0.5);
        vary("a second pass in the same rut", &|row| {
            row.earlier_passes += 1.0
        });
        if self.rows.iter().all(|row| row.slip >= 0.0) {
            vary("the same slips braking instead of driving", &|row| {
                row.slip = -row.slip
            });
        }
        if self.rows.iter().all(|row| row.speed > 0.0) {
            vary("the same slips at three times the travel speed", &|row| {
                row.speed *= 3.0;
                row.wheel_speed *= 3.0;
            });
        }
        vary("every trial once more, as it was", &|_| {});
        // A channel the log lacks, with the accuracy such a sensor usually has.
        for (output, sd, manoeuvre) in [
            (
                Output::Sinkage,
                0.001,
                "the same trials with a sinkage sensor (1 mm)",
            ),
            (
                Output::Torque,
                0.1,
                "the same trials with the wheel torque logged (0.1 N m)",
            ),
            (
                Output::DrawbarPull,
                0.5,
                "the same trials with a drawbar load cell (0.5 N)",
            ),
        ] {
            if self.rows.iter().any(|row| row.outputs.contains(&output)) {
                continue;
            }
            let (mut data, mut predictor) = (data.clone(), self.clone());
            data.channels.push(ChannelInfo {
                name: output.name().to_owned(),
                unit: output.unit(),
                scale: 1.0,
            });
            for o in &mut data.observations {
                let at = o.values.len();
                o.channels.push(data.channels.len() - 1);
                o.values.push(0.0);
                o.raw_sd.insert(at, sd);
                let row = &mut predictor.rows[o.index];
                row.outputs.push(output);
                row.values.push(0.0);
            }
            designs.push(Design {
                manoeuvre: manoeuvre.to_owned(),
                data,
                predictor: Arc::new(predictor),
            });
        }
        designs
    }
}
