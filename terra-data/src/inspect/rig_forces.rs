//! A testbed's forces against its loads, before any soil is asked.
//!
//! Thrust and torque of a wheel come from shear under its load, so D/W and T/(R W) of a wheel that slips are of order one tenth
//! to one; a unit or a sign that is not what it is said to be leaves that range by far.

use super::{Suspicion, digits, quantile};
use crate::rig::{Measured, RigLog, RigRow};
use crate::rover::Rover;

/// Fewest rows that say anything of a sign or a unit.
const FEW: usize = 5;
/// Slip from which a wheel shears the ground in earnest.
const SHEARS: f64 = 0.2;
/// Share of rows above which a sign is doubted.
const AGAINST: f64 = 0.8;
/// In one row a wheel pulls at most about its load: friction angles stay below 45 deg, and light wheels on cohesive soil rarely
/// double it.
const PULL_OVER_LOAD: f64 = 3.0;
/// The same of the median of D/W and T/(R W) of rows that slip.
const USUAL: f64 = 1.2;
/// A median of |D|/W beyond which a wheel pulls as few do.
const STRONG: f64 = 0.7;
/// What a median of T/(R W), and of |D|/W, hardly falls below: a wheel that shears the ground takes torque, but may pull nothing.
const LEAST: (f64, f64) = (0.01, 0.002);
/// Share of rows that are another row again, and how many, from which they are copies.
const COPIES: (f64, usize) = (0.2, 3);

/// What in a log's forces and sinkages is probably not in its unit or of its sign.
pub(super) fn forces(log: &RigLog, rover: Option<&Rover>) -> Vec<Suspicion> {
    let mut found = vec![];
    match beyond_one_row(log) {
        Some(row) => found.push(row),
        None => found.extend(units(log, rover)),
    }
    found.extend(pull_sign(log));
    found.extend(torque_sign(log));
    found.extend(sinkage_sign(log));
    found.extend(copies(log));
    found
}

fn value(measured: Option<Measured>) -> Option<f64> {
    measured.map(|m| m.value)
}

/// Rows in which the wheel drives and slips by more than this.
fn slipping(log: &RigLog, from: f64) -> impl Iterator<Item = &RigRow> {
    log.rows.iter().filter(move |r| r.slip.value > from)
}

fn beyond_one_row(log: &RigLog) -> Option<Suspicion> {
    let beyond = |r: &&RigRow| {
        value(r.drawbar_pull).is_some_and(|d| d.abs() > PULL_OVER_LOAD * r.normal_load.value)
    };
    let row = log.rows.iter().find(beyond)?;
    Some(Suspicion {
        code: "load-unit",
        message: format!(
            "line {}: drawbar pull {} N on a load of {} N: load in kg or kN, or pull in another unit?",
            row.line,
            value(row.drawbar_pull).unwrap_or(0.0),
            row.normal_load.value
        ),
    })
}

fn median_of(mut each: Vec<f64>) -> Option<f64> {
    (each.len() >= FEW)
        .then(|| quantile(&mut each, 0.5))
        .flatten()
}

fn units(log: &RigLog, rover: Option<&Rover>) -> Option<Suspicion> {
    let rows = || slipping(log, SHEARS);
    let pull = rows().filter_map(|r| Some(value(r.drawbar_pull)?.abs() / r.normal_load.value));
    let pull = median_of(pull.collect());
    let torque = rover.and_then(|rover| {
        let of = |r: &RigRow| {
            let arm = rover.wheel_of(&r.condition).radius;
            Some(value(r.torque)?.abs() / (arm * r.normal_load.value))
        };
        median_of(rows().filter_map(of).collect())
    });
    let (least_torque, least_pull) = LEAST;
    let much_torque = torque.is_some_and(|t| t > USUAL);
    let pulls = |more: f64| pull.is_some_and(|p| p > more);
    let little_torque = torque.is_some_and(|t| t < least_torque);
    let little_pull = pull.is_some_and(|p| p < least_pull);
    let question = if pulls(USUAL) && torque.is_none() || pulls(STRONG) && much_torque {
        ("load-unit", "load in kg or kN?")
    } else if much_torque {
        let what =
            "torque in N mm or N cm, drawbar pull in the torque's column, or radius_m too small?";
        ("torque-unit", what)
    } else if pulls(USUAL) {
        ("pull-unit", "drawbar pull in mN or g?")
    } else if little_torque && !pulls(least_torque) {
        ("load-unit", "load in g or mN, or forces in kN?")
    } else if little_torque {
        (
            "torque-unit",
            "torque in kN m, or radius_m in another unit?",
        )
    } else if little_pull {
        let what = "drawbar pull in kN, or a load cell that is not connected?";
        ("pull-unit", what)
    } else {
        return None;
    };
    let said = |what: &str, of: Option<f64>| of.map(|x| format!("{what} is {}", digits(x)));
    let medians = [said("|D|/W", pull), said("|T|/(R W)", torque)];
    let medians: Vec<String> = medians.into_iter().flatten().collect();
    Some(Suspicion {
        code: question.0,
        message: format!(
            "in rows that slip by more than {SHEARS} the median {}; where a wheel shears the ground they are of order .1 to 1: {}",
            medians.join(" and "),
            question.1
        ),
    })
}

/// Of a wheel that digs in the pull is negative too, but it does not fall further the more torque the wheel takes.
fn pull_sign(log: &RigLog) -> Option<Suspicion> {
    let pulls = slipping(log, SHEARS).filter_map(|r| value(r.drawbar_pull));
    let (negative, of) = mostly_negative(pulls)?;
    let against = |r: &RigRow| {
        let (d, t) = (value(r.drawbar_pull)?, value(r.torque)?);
        Some((d / r.normal_load.value, t.abs() / r.normal_load.value))
    };
    let both: Vec<(f64, f64)> = log.rows.iter().filter_map(against).collect();
    let falls = both.len() < FEW || slope_sign(&both) < 0.0;
    let beside = if both.len() < FEW {
        ""
    } else {
        ", and falls as torque rises"
    };
    falls.then(|| Suspicion {
        code: "pull-sign",
        message: format!(
            "drawbar_pull_N is negative in {negative} of {of} rows that slip by more than {SHEARS}{beside}: sign flipped? A wheel \
             that pulls its carriage along has a positive one"
        ),
    })
}

/// Sum of products about the means, y and x: its sign is the slope's.
fn slope_sign(both: &[(f64, f64)]) -> f64 {
    let n = both.len() as f64;
    let (my, mx) = (
        both.iter().map(|b| b.0).sum::<f64>() / n,
        both.iter().map(|b| b.1).sum::<f64>() / n,
    );
    both.iter().map(|(y, x)| (y - my) * (x - mx)).sum()
}

fn torque_sign(log: &RigLog) -> Option<Suspicion> {
    let driving = slipping(log, 0.05).filter_map(|r| value(r.torque));
    let (negative, of) = mostly_negative(driving)?;
    Some(Suspicion {
        code: "torque-sign",
        message: format!(
            "torque_N_m is negative in {negative} of {of} rows with a driving slip: sign flipped? A torque that drives forward is positive"
        ),
    })
}

fn sinkage_sign(log: &RigLog) -> Option<Suspicion> {
    let (negative, of) = mostly_negative(log.rows.iter().filter_map(|r| value(r.sinkage)))?;
    Some(Suspicion {
        code: "sinkage-sign",
        message: format!(
            "sinkage_m is negative in {negative} of {of} rows: sign flipped? Down into the ground is positive"
        ),
    })
}

/// How many of these are negative, and of how many, where nearly all are.
fn mostly_negative(each: impl Iterator<Item = f64>) -> Option<(usize, usize)> {
    let (mut negative, mut of) = (0, 0);
    for x in each {
        of += 1;
        negative += usize::from(x < 0.0);
    }
    (of >= FEW && negative as f64 > AGAINST * of as f64).then_some((negative, of))
}

/// Repeats that are one row written several times: their scatter would say that there is no noise.
fn copies(log: &RigLog) -> Option<Suspicion> {
    let bits = |r: &RigRow| -> Option<Vec<u64>> {
        let measured = [r.drawbar_pull, r.torque, r.sinkage];
        let each: Vec<f64> = measured.into_iter().filter_map(value).collect();
        let all = each.into_iter().chain([r.slip.value, r.normal_load.value]);
        let all: Vec<u64> = all.map(f64::to_bits).collect();
        (all.len() >= 4).then_some(all)
    };
    let mut rows: Vec<Vec<u64>> = log.rows.iter().filter_map(bits).collect();
    let of = rows.len();
    rows.sort_unstable();
    rows.dedup();
    let again = of - rows.len();
    let (share, few) = COPIES;
    (again >= few && again as f64 > share * of as f64).then(|| Suspicion {
        code: "copies",
        message: format!(
            "{again} of {of} rows are another row again, to the last digit of every channel: copies are no repeats, and say nothing of noise"
        ),
    })
}
