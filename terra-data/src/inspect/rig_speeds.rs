//! A testbed's slip against its own speeds.
//!
//! A row that logs slip, wheel speed and travel speed says one thing twice. Single rows differ by noise; where all differ by
//! one rule, a sign, a convention or a unit is not what the log or the rover file says, and forces would be laid to wrong slips
//! or to a wheel of another size.

use super::{Suspicion, digits, quantile};
use crate::rig::RigLog;
use crate::rover::Rover;

/// Fewest rows that show a rule.
const FEW: usize = 5;
/// Least slip, and distance from 1, at which sign and convention show.
const SLIPS: f64 = 0.02;
/// ln of travel reductions up to which rows follow a rule, as a median.
const FOLLOWS: f64 = 0.05;
/// Times that the rule must fit better than what is declared.
const BETTER: f64 = 4.0;
/// Factor between them from which a unit, a radius or a diameter is meant, and no rolling radius that is measured otherwise (over
/// lugs, in the rut).
const FACTOR: f64 = 1.5;
/// What is often mistaken for another, by the factor of v/(R ω) that it leads to.
const MISTAKES: [(f64, &str); 5] = [
    (0.5, "radius_m may be the diameter"),
    (0.001, "radius_m may be in millimetres"),
    (
        1000.0,
        "the travel speed may be in mm/s: in [columns] unit = \"mm/s\"",
    ),
    (
        std::f64::consts::PI / 30.0,
        "the wheel speed may be in rpm: in [columns] unit = \"rpm\"",
    ),
    (
        std::f64::consts::PI / 180.0,
        "the wheel speed may be in deg/s: in [columns] unit = \"deg/s\"",
    ),
];
/// ln of factors up to which one of these is meant.
const MEANT: f64 = 0.1;

/// One row: slip as logged, and v/(R ω) of its speeds.
struct Twice {
    slip: f64,
    travel: f64,
}

/// v/(R ω) at a library slip; none where the wheel is locked or does not move.
fn travel_at(slip: f64) -> Option<f64> {
    let travel = if slip < 0.0 {
        (1.0 + slip).recip()
    } else {
        1.0 - slip
    };
    (travel > 0.0 && travel.is_finite()).then_some(travel)
}

/// How all rows' slip contradicts their speeds, where they do by one rule.
///
/// # Equation
/// With u = v/(R ω) from the speeds and i the slip as read: sign, u(-i); convention, i = 1/u - 1; scale, u = q (1 - i) with one
/// q in all rows.
pub fn slip_against_speeds(log: &RigLog, rover: &Rover) -> Option<Suspicion> {
    let rows: Vec<Twice> = log
        .rows
        .iter()
        .filter_map(|row| {
            let rim = row.wheel_speed? * rover.wheel_of(&row.condition).radius;
            let travel = row.travel_speed? / rim;
            (travel > 0.0 && travel.is_finite()).then_some(Twice {
                slip: row.slip.value,
                travel,
            })
        })
        .collect();
    let shows = |row: &&Twice| row.slip.abs() > SLIPS && (1.0 - row.slip.abs()) > SLIPS;
    // Of one rule: the median of how far rows are from it, ln.
    let misses = |rule: &dyn Fn(&Twice) -> Option<f64>| {
        let mut far: Vec<f64> = rows
            .iter()
            .filter(shows)
            .filter_map(|row| Some((row.travel / rule(row)?).ln().abs()))
            .collect();
        (far.len() >= FEW)
            .then(|| quantile(&mut far, 0.5))
            .flatten()
    };
    let declared = misses(&|row| travel_at(row.slip))?;
    let follows = |rule: &dyn Fn(&Twice) -> Option<f64>| {
        misses(rule).is_some_and(|far| far < FOLLOWS && BETTER * far < declared)
    };
    let n = rows.iter().filter(shows).count();
    let told = |code, message| Some(Suspicion { code, message });
    if follows(&|row| travel_at(-row.slip)) {
        return told(
            "slip-sign",
            format!(
                "slip has the other sign than the speeds of its own {n} rows give: here a driving slip, R w > v, is positive"
            ),
        );
    }
    if follows(&|row| (row.slip > -1.0).then(|| (1.0 + row.slip).recip())) {
        return told(
            "slip-convention",
            format!(
                "slip of {n} rows is (R w - v)/v by their own speeds: in [columns] slip: convention = \"unbounded\""
            ),
        );
    }
    let mut factors: Vec<f64> = rows
        .iter()
        .filter(shows)
        .filter_map(|row| Some((row.travel / travel_at(row.slip)?).ln()))
        .collect();
    let q = quantile(&mut factors, 0.5)?;
    let mut spread: Vec<f64> = factors.iter().map(|f| (f - q).abs()).collect();
    let one_factor = quantile(&mut spread, 0.5).is_some_and(|s| s < FOLLOWS);
    (one_factor && q.abs() > FACTOR.ln()).then(|| {
        let mistakes = MISTAKES.iter().map(|&(f, text)| ((f.ln() - q).abs(), text));
        let nearest = mistakes.min_by(|a, b| a.0.total_cmp(&b.0));
        let hint = nearest
            .filter(|(far, _)| *far < MEANT)
            .map_or(String::new(), |(_, text)| format!(": {text}"));
        Suspicion {
            code: "slip-scale",
            message: format!(
                "the speeds of {n} rows give v/(R w) {} times what their own slip gives{hint}",
                digits(q.exp())
            ),
        }
    })
}
