//! What a simulator's motion differs by from an ideal drive's: smooth in how sharply the wheels turn, and in how fast.
//!
//! Soil lets the wheels of a turn slip otherwise than on a straight run, and every simulator of a skid-steered vehicle turns by less than
//! its wheel speeds say. Against such a simulator that is no gap: it is learned from its log and frozen.
//!
//! # Equation
//! r -> r exp(Σ a_k h_k(τ) + (a_v + a'_v τ) ln(V/V0) + (a_b + a'_b τ) [backwards]),
//! v -> v exp(Σ b_k h_k(τ) + b_v τ ln(V/V0) + b_b τ [backwards]), with τ = |V_r - V_l|/(|V_r| + |V_l|) by the wheel speeds, 0 straight on
//! and 1 on the spot, V their mean without sign, V0 = .5 m/s, and h_k the hat over the k-th of eight turnings. Straight on v has its
//! slip, and nothing of these.

use std::ops::Range;

use terra_model::{Effect, Param, Scalar, Scale, Touch};

use super::read::turning;

/// Turnings at which the error is anchored.
const AT: [f64; 8] = [0.0, 0.05, 0.12, 0.25, 0.4, 0.6, 0.8, 1.0];
/// Coefficients of the yaw rate; the rest are the ground speed's.
const OF_YAW: usize = AT.len() + 4;
/// Speed at which speed adds nothing \[m/s\].
const USUAL: f64 = 0.5;
/// Speed below which there is no slower \[m/s\].
const SLOW: f64 = 0.05;

const fn coefficient(name: &'static str, prior_sd: f64) -> Param {
    Param {
        name,
        symbol: "c",
        unit: "1",
        min: -4.0,
        max: 4.0,
        scale: Scale::Linear,
        prior_sd,
        doc: "logarithm of what the simulator moves by over what an ideal drive would",
    }
}

/// Prior sd of the logarithms: a skid-steered vehicle turns by a half to all of what its wheel speeds say (Mandow et al. 2007), and
/// the sharper it turns the more of its speed goes with it.
const LEVEL: f64 = 0.5;
/// The same over a factor of e in speed, and backwards.
const CHANGE: f64 = 0.2;

/// The error of an ideal drive's motion.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MotionError;

impl MotionError {
    /// What it is off in, and which coefficients say by how much.
    pub(crate) const PARTS: &'static [(&'static str, Range<usize>)] = &[
        ("ln yaw rate", 0..OF_YAW),
        ("ln ground speed", OF_YAW..Self::PARAMS.len()),
    ];
}

impl Effect for MotionError {
    const NAME: &'static str = "motion-error";
    const SUMMARY: &'static str = "smooth error of an ideal drive's motion over how it turns";
    const PARAMS: &'static [Param] = &[
        coefficient("yaw_0", LEVEL),
        coefficient("yaw_0.05", LEVEL),
        coefficient("yaw_0.12", LEVEL),
        coefficient("yaw_0.25", LEVEL),
        coefficient("yaw_0.4", LEVEL),
        coefficient("yaw_0.6", LEVEL),
        coefficient("yaw_0.8", LEVEL),
        coefficient("yaw_1", LEVEL),
        coefficient("yaw_by_speed", CHANGE),
        coefficient("yaw_by_speed_and_turning", CHANGE),
        coefficient("yaw_backwards", CHANGE),
        coefficient("yaw_backwards_by_turning", CHANGE),
        coefficient("speed_0.05", LEVEL),
        coefficient("speed_0.12", LEVEL),
        coefficient("speed_0.25", LEVEL),
        coefficient("speed_0.4", LEVEL),
        coefficient("speed_0.6", LEVEL),
        coefficient("speed_0.8", LEVEL),
        coefficient("speed_1", LEVEL),
        coefficient("speed_by_speed_and_turning", CHANGE),
        coefficient("speed_backwards_by_turning", CHANGE),
    ];
    const REFERENCE: &'static str =
        "difference in differences with a frozen discrepancy; chosen anchors and spreads";
    const TOUCHES: &'static [Touch] = &[Touch::Vehicle];
    const REGIME: &'static str = "all turns";
    const ISOLATED_BY: &'static str = "the simulator's own log";
}

/// By what factors ground speed and yaw rate are off with these rim speeds left and right, by the error's coefficients.
pub(super) fn factors<T: Scalar>(e: &[T], [left, right]: [f64; 2]) -> (T, T) {
    let turning = turning([left, right]).abs();
    let fast = ((0.5 * (left.abs() + right.abs())).max(SLOW) / USUAL).ln();
    let back = if left + right < 0.0 { 1.0 } else { 0.0 };
    let anchors = hats(turning);
    let yaw = [fast, fast * turning, back, back * turning];
    let speed = [fast * turning, back * turning];
    let sum = |e: &[T], by: &mut dyn Iterator<Item = &f64>| {
        let each = e.iter().zip(by);
        each.fold(T::zero(), |sum, (e, by)| sum + *e * *by).exp()
    };
    let (of_yaw, of_speed) = e.split_at(OF_YAW.min(e.len()));
    // The ground speed's first anchor has no coefficient.
    (
        sum(of_speed, &mut anchors.iter().skip(1).chain(&speed)),
        sum(of_yaw, &mut anchors.iter().chain(&yaw)),
    )
}

/// How much each anchor counts at a turning.
fn hats(turning: f64) -> [f64; AT.len()] {
    let mut out = [0.0; AT.len()];
    for (k, ends) in AT.windows(2).enumerate() {
        if let [low, high] = *ends
            && (low..=high).contains(&turning)
        {
            let part = (turning - low) / (high - low);
            (out[k], out[k + 1]) = (1.0 - part, part);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the equation: a coefficient alone at its own turning, half of it half way to the next, to either side alike; straight on the
    /// speed of an ideal drive; and what speed and going backwards add, nothing at .5 m/s forwards.
    #[test]
    fn a_coefficient_acts_where_its_name_says() {
        let named = |name: &str| {
            let names = MotionError::PARAMS
                .iter()
                .map(|p| f64::from(p.name == name));
            names.collect::<Vec<f64>>()
        };
        assert!(MotionError::PARAMS[OF_YAW].name.starts_with("speed_"));
        let near = |name: &str, sides: [f64; 2], speed: f64, yaw: f64| {
            let found = factors(&named(name), sides);
            let off = (found.0.ln() - speed).abs() + (found.1.ln() - yaw).abs();
            assert!(off < 1e-12, "{name} {sides:?} {found:?}");
        };
        let (quarter, other) = ([0.375, 0.625], [0.625, 0.375]);
        near("yaw_0.25", quarter, 0.0, 1.0);
        near("yaw_0.25", other, 0.0, 1.0);
        near("yaw_0.25", [0.3375, 0.6625], 0.0, 0.5);
        near("yaw_0.4", quarter, 0.0, 0.0);
        near("yaw_0", [0.5, 0.5], 0.0, 1.0);
        near("yaw_1", [-0.5, 0.5], 0.0, 1.0);
        near("speed_0.25", quarter, 1.0, 0.0);
        near("speed_0.25", [0.5, 0.5], 0.0, 0.0);
        let e = std::f64::consts::E;
        near("yaw_by_speed", quarter, 0.0, 0.0);
        near("yaw_by_speed", quarter.map(|v| e * v), 0.0, 1.0);
        near(
            "yaw_by_speed_and_turning",
            quarter.map(|v| e * v),
            0.0,
            0.25,
        );
        near("yaw_backwards", quarter.map(|v| -v), 0.0, 1.0);
        near("yaw_backwards_by_turning", quarter.map(|v| -v), 0.0, 0.25);
        near(
            "speed_by_speed_and_turning",
            quarter.map(|v| e * v),
            0.25,
            0.0,
        );
        near("speed_backwards_by_turning", quarter.map(|v| -v), 0.25, 0.0);
    }
}
