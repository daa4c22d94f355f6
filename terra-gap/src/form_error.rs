//! What the nominal law's form is off by against a simulator: smooth in slip, and in the load. By motion alone it is another
//! ([`MotionError`]).
//!
//! # Equation
//! D + W d_D, T + W R d_T, z exp(d_z), d(s, W) = Σ_k (c_k + l_k ln(W/(b R p0))) exp(-(w - w_k)²/(2 ℓ²))/√2 over the slip as
//! w = ±ln(1 + |s|/s0), ℓ = .6 and w_k in steps of .6; p0 = 5 kPa, each coefficient with prior sd .03.
//!
//! Wheel laws bend most near zero slip, and differ most there. A rig holds a few slips: s0 = .1, and eight anchors from slip -.5
//! to 1. A drive goes through all of them, and stays long where a law turns from driving to braking: s0 = .03, and twelve
//! anchors from -.57 to 1.07. (With a rig's anchors the re-fitted `wong-reece` swung about a `scm-column` drive at slips below .1, by
//! three standard deviations of a window and chi2/n 2.05; with a drive's own it follows it, .96.)

use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

use terra_model::{AnyEffect, Contact, Effect, Param, Real, Scale, Soil, Touch, WheelForces};

use crate::dataset::DataSet;
use crate::kinematic::MotionError;
use crate::settings::LogKind;

/// Length of the error in w, and distance of the anchors.
const LENGTH: f64 = 0.6;
/// Prior sd of the error, in loads, and of its change over a factor of e in load.
const SPREAD: f64 = 0.03;
/// Mean pressure under a wheel at which the load changes nothing \[Pa\].
const PRESSURE: f64 = 5e3;

/// Where a kind of log anchors the error.
trait Anchors: Default + Send + Sync + 'static {
    /// Slip over which wheel laws bend near zero.
    const BEND: f64;
    /// In w.
    const AT: &'static [f64];
    /// Of each channel the coefficients at every anchor, then what a load e times as large adds there.
    const PARAMS: &'static [Param];
    /// Of each channel the coefficients at a mean pressure of 5 kPa.
    const PARTS: &'static [Part] = &[
        ("pull", 0..Self::AT.len()),
        ("torque", 2 * Self::AT.len()..3 * Self::AT.len()),
        ("ln sinkage", 4 * Self::AT.len()..5 * Self::AT.len()),
    ];
}

const fn coefficient(name: &'static str) -> Param {
    Param {
        name,
        symbol: "c",
        unit: "1",
        min: -1.0,
        max: 1.0,
        scale: Scale::Linear,
        prior_sd: SPREAD,
        doc: "error of the wheel law's form around one slip, in loads",
    }
}

/// A channel's coefficients: at every anchor, then what a load e times as large adds there.
macro_rules! channel {
    ($name:literal: $($anchor:literal)+) => {
        [
            [$(coefficient(concat!($name, "_", $anchor)),)+],
            [$(coefficient(concat!($name, "_", $anchor, "_by_load")),)+],
        ]
    };
}

/// All channels' coefficients.
macro_rules! channels {
    ($($anchor:literal)+) => {
        [
            channel!("pull": $($anchor)+),
            channel!("torque": $($anchor)+),
            channel!("sinkage": $($anchor)+),
        ]
    };
}

/// Channels of a drive without sinkage: pull and torque.
const FORCES: usize = 2;

const HELD: [[[Param; 8]; 2]; 3] = channels!("-0.50" "-0.23" "-0.08" "0" "0.08" "0.23" "0.50" "1");
const SWEPT: [[[Param; 12]; 2]; 3] =
    channels!("-0.57" "-0.30" "-0.15" "-0.07" "-0.02" "0" "0.02" "0.07" "0.15" "0.30" "0.57" "1");

/// A rig's slips.
#[derive(Default)]
struct Held;

impl Anchors for Held {
    const BEND: f64 = 0.1;
    const AT: &'static [f64] = &[-1.8, -1.2, -0.6, 0.0, 0.6, 1.2, 1.8, 2.4];
    const PARAMS: &'static [Param] = HELD.as_flattened().as_flattened();
}

/// A drive's.
#[derive(Default)]
struct Swept;

impl Anchors for Swept {
    const BEND: f64 = 0.03;
    const AT: &'static [f64] = &[
        -3.0, -2.4, -1.8, -1.2, -0.6, 0.0, 0.6, 1.2, 1.8, 2.4, 3.0, 3.6,
    ];
    const PARAMS: &'static [Param] = SWEPT.as_flattened().as_flattened();
}

/// A drive's whose sinkage is not measured.
#[derive(Default)]
struct SweptUnseen;

impl Anchors for SweptUnseen {
    const BEND: f64 = Swept::BEND;
    const AT: &'static [f64] = Swept::AT;
    const PARAMS: &'static [Param] = {
        let (forces, _) = SWEPT.as_flattened().split_at(2 * FORCES);
        forces.as_flattened()
    };
}

#[derive(Default)]
struct FormError<A>(PhantomData<A>);

impl<A: Anchors> Effect for FormError<A> {
    const NAME: &'static str = "form-error";
    const SUMMARY: &'static str = "smooth error of the wheel law's form over slip";
    const PARAMS: &'static [Param] = A::PARAMS;
    const REFERENCE: &'static str =
        "difference in differences with a frozen discrepancy; chosen length and spread";
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const REGIME: &'static str = "all slips";
    const ISOLATED_BY: &'static str = "the simulator's own log";

    fn after<T: Real>(
        &self,
        e: &[T],
        _soil: &Soil<T>,
        at: &Contact<T>,
        forces: &mut WheelForces<T>,
    ) {
        let load = (at.normal_load / (at.width * at.radius * PRESSURE)).ln();
        let zero = T::zero();
        let size = (at.slip.select_lt(zero, -at.slip, at.slip) * (1.0 / A::BEND) + 1.0).ln();
        let w = at.slip.select_lt(zero, -size, size);
        let mut error = [zero; 3];
        for (k, anchor) in A::AT.iter().enumerate() {
            let d = (w - *anchor) * (1.0 / LENGTH);
            // About two anchors overlap any slip: the sum keeps the spread of one coefficient.
            let share = (-(d * d) * 0.5).exp() * std::f64::consts::FRAC_1_SQRT_2;
            for (channel, e) in error.iter_mut().zip(e.chunks_exact(2 * A::AT.len())) {
                let (level, by_load) = (e[k], e[k + A::AT.len()]);
                *channel += (level + by_load * load) * share;
            }
        }
        let [pull, torque, sinkage] = error;
        forces.drawbar_pull += pull * at.normal_load;
        forces.parts.other += pull * at.normal_load;
        forces.resistive_torque += torque * at.normal_load * at.radius;
        forces.sinkage = forces.sinkage.map(|z| z * sinkage.exp());
    }
}

/// The error's form for a log.
pub(crate) struct Form {
    effect: Arc<dyn AnyEffect>,
    parts: &'static [Part],
}

/// What a form's error is off in: a name, and which coefficients say by how much.
type Part = (&'static str, Range<usize>);

impl Form {
    /// That for a kind of log and its channels.
    pub(crate) fn of(data: &DataSet, kind: LogKind) -> Self {
        fn with<A: Anchors>() -> Form {
            Form {
                effect: Arc::new(FormError::<A>::default()),
                parts: A::PARTS,
            }
        }
        let sinkage = || data.channels.iter().any(|c| c.name.starts_with("sinkage"));
        match kind {
            LogKind::Rig => with::<Held>(),
            LogKind::Drive if sinkage() => with::<Swept>(),
            LogKind::Drive => with::<SweptUnseen>(),
            LogKind::Kinematic => Form {
                effect: Arc::new(MotionError),
                parts: MotionError::PARTS,
            },
        }
    }

    /// The effect.
    pub(crate) fn effect(&self) -> Arc<dyn AnyEffect> {
        Arc::clone(&self.effect)
    }

    /// Root mean square of each part's coefficients; 0 for a part that the log's form has not.
    pub(crate) fn sizes(&self, coefficients: &[f64]) -> (Vec<&'static str>, Vec<f64>) {
        let size = |(of, range): &Part| {
            let c = coefficients.get(range.clone()).unwrap_or(&[]);
            let rms = (c.iter().map(|c| c * c).sum::<f64>() / c.len().max(1) as f64).sqrt();
            (*of, rms)
        };
        self.parts.iter().map(size).unzip()
    }
}

/// Whether a parameter of a fit, by its name with or without a structure before it, is a coefficient of the error of the wheel
/// law's form that a contrast against an outside simulator has, and none of the soil's.
pub fn is_form_error(parameter: &str) -> bool {
    let own = parameter.rsplit('/').next().unwrap_or(parameter);
    let forces = Held::PARAMS.iter().chain(Swept::PARAMS);
    let mut all = forces.chain(MotionError::PARAMS);
    all.any(|p| p.name == own)
}

#[cfg(test)]
mod tests {
    use terra_model::{ForceLaw, ModelError, Registry, catalogue};

    use super::*;

    /// Forces of a law with one coefficient of the error at 1, less those without, in loads: pull, torque over radius.
    fn added<A: Anchors>(name: &str, slip: f64, load: f64) -> Result<[f64; 2], ModelError> {
        let law = Registry::builtin().law("wong-reece")?;
        let soil = catalogue::find("dry_sand")?.parameters(law.model())?;
        let effect: Arc<dyn AnyEffect> = Arc::new(FormError::<A>::default());
        let bent = law.clone().with_effects([effect])?;
        let mut p = soil.clone();
        p.extend(A::PARAMS.iter().map(|c| f64::from(c.name == name)));
        let at = Contact::new(slip, load, 0.1, 0.1);
        let (plain, bent) = (law.forces(&soil, &at)?, bent.forces(&p, &at)?);
        Ok([
            (bent.drawbar_pull - plain.drawbar_pull) / load,
            (bent.resistive_torque - plain.resistive_torque) / (load * at.radius),
        ])
    }

    /// By the equation: 1/√2 at a coefficient's own slip, e^(-1/2) of that at the next anchor on either side, nothing in the other
    /// channel; what a load adds is nothing at 5 kPa and as much as the level at e times that.
    #[test]
    fn a_coefficient_acts_around_its_own_slip() {
        let top = std::f64::consts::FRAC_1_SQRT_2;
        let slip = |w: f64, bend: f64| w.signum() * (w.abs().exp() - 1.0) * bend;
        let even = 5e3 * 0.01;
        let near = |found: Result<[f64; 2], ModelError>, wanted: [f64; 2]| {
            let found = found.unwrap();
            let mut each = found.iter().zip(&wanted);
            assert!(
                each.all(|(f, w)| (f - w).abs() < 1e-9),
                "{found:?} {wanted:?}"
            );
        };
        let next = top * (-0.5f64).exp();
        near(
            added::<Swept>("pull_0.02", slip(0.6, 0.03), even),
            [top, 0.0],
        );
        near(added::<Swept>("pull_0.02", 0.0, even), [next, 0.0]);
        near(
            added::<Swept>("torque_-0.07", slip(-1.2, 0.03), even),
            [0.0, top],
        );
        near(
            added::<SweptUnseen>("torque_0.07", slip(0.6, 0.03), even),
            [0.0, next],
        );
        near(added::<Held>("pull_0.23", slip(1.2, 0.1), even), [top, 0.0]);
        let by_load = |load| added::<Held>("pull_0.23_by_load", slip(1.2, 0.1), load);
        near(by_load(even), [0.0, 0.0]);
        near(by_load(even * std::f64::consts::E), [top, 0.0]);
    }

    /// Anchors stand one length apart, their names but the last, about 1, tell their slips to half a hundredth, and every channel has two
    /// coefficients at each.
    #[test]
    fn anchors_are_named_after_their_slips() {
        fn each<A: Anchors>(channels: usize) {
            assert_eq!(A::PARAMS.len(), 2 * channels * A::AT.len());
            for (pair, params) in A::AT.windows(2).zip(A::PARAMS) {
                assert!((pair[1] - pair[0] - LENGTH).abs() < 1e-12);
                let named = params.name.trim_start_matches("pull_");
                let slip: f64 = named.parse().unwrap();
                let own = pair[0].signum() * (pair[0].abs().exp() - 1.0) * A::BEND;
                assert!((slip - own).abs() < 0.005, "{named} {own}");
                assert!(is_form_error(params.name), "{named}");
            }
        }
        each::<Held>(3);
        each::<Swept>(3);
        each::<SweptUnseen>(2);
        assert!(is_form_error("log/torque_0.15_by_load") && !is_form_error("cohesion"));
    }
}
