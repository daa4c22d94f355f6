//! Which effects a design can carry: those that change its log by more than its noise.

use rayon::prelude::*;
use terra_data::{DriveLog, RigRow, Rover, Series};
use terra_sim::{EffectSetting, Scenario};

use super::design::{AnyLog, Design, simulate};
use super::library::{Known, Library, Size};

/// A measured value of a row of a rig log.
type ReadRow = fn(&RigRow) -> Option<f64>;

/// Whitened squared change of the whole log at one prior standard deviation (3 sigma) that an effect must reach.
const VISIBLE: f64 = 9.0;

/// Effects of a list that the design can carry, in the list's order.
///
/// `without` is the log of the quiet design. An effect is tried without noise at its prior standard deviation, or in the middle of its range where the truth
/// simulation lists one, and at .3 of that where the vehicle does not get through. What the design's model or kind of
/// log has no place for cannot be simulated, what differs only by a number that the soil's stiffness is, or what the design excludes by its own words,
/// is not carried either.
pub(crate) fn carried(
    design: &Design,
    library: &Library,
    without: &AnyLog,
    list: &[Known],
) -> Vec<Known> {
    let quiet = quiet(&design.scenario);
    let registry = library.registry();
    let kept: Vec<bool> = list
        .par_iter()
        .map(|known| {
            let sizes = library.sizes(known);
            if sizes.is_empty() || excluded(design, known) {
                return false;
            }
            [1.0, 0.3].into_iter().any(|share| {
                let mut scenario = quiet.clone();
                let magnitude = sizes
                    .iter()
                    .map(|size| match size {
                        Size::Prior(p) => (share * p.prior_sd).clamp(p.min, p.max),
                        Size::Between(low, high) => share * (low * high).sqrt(),
                    })
                    .collect();
                scenario.effects.push(EffectSetting {
                    name: known.name.clone(),
                    magnitude,
                    form: Some(known.form.clone()),
                });
                simulate(&scenario, &design.rover, registry)
                    .is_ok_and(|with| change(without, &with, &design.rover) > VISIBLE)
            })
        })
        .collect();
    list.iter()
        .zip(kept)
        .filter(|(_, kept)| *kept)
        .map(|(known, _)| known.clone())
        .collect()
}

/// A scenario without noise.
pub(crate) fn quiet(scenario: &Scenario) -> Scenario {
    Scenario {
        noise_scale: 0.0,
        ..scenario.clone()
    }
}

fn excluded(design: &Design, known: &Known) -> bool {
    let Scenario { trials, .. } = &design.scenario;
    if trials.is_empty() {
        return false;
    }
    match known.name.as_str() {
        "grousers" => {
            trials.iter().all(|t| t.condition.contains("smooth"))
                && design.rover.wheel.grouser_height == 0.0
        }
        // One speed: the stiffness itself.
        "rate-stiffening" => trials
            .windows(2)
            .all(|t| t[0].travel_speed == t[1].travel_speed),
        _ => false,
    }
}

/// Σ ((b - a)/sd)² over all channels whose noise is known.
fn change(a: &AnyLog, b: &AnyLog, rover: &Rover) -> f64 {
    match (a, b) {
        (AnyLog::Drive(a), AnyLog::Drive(b)) => drive(a, b, rover),
        (AnyLog::Rig(a), AnyLog::Rig(b)) => {
            let value: [(&str, ReadRow); 6] = [
                ("slip", |r| Some(r.slip.value)),
                ("travel_speed_m_s", |r| r.travel_speed),
                ("normal_load_N", |r| Some(r.normal_load.value)),
                ("drawbar_pull_N", |r| r.drawbar_pull.map(|m| m.value)),
                ("torque_N_m", |r| r.torque.map(|m| m.value)),
                ("sinkage_m", |r| r.sinkage.map(|m| m.value)),
            ];
            value
                .iter()
                .filter_map(|(key, of)| {
                    let sd = rover.noise.get(key).filter(|sd| *sd > 0.0)?;
                    let pairs = a.rows.iter().zip(&b.rows);
                    Some(
                        pairs
                            .filter_map(|(x, y)| Some((of(x)?, of(y)?)))
                            .map(|(x, y)| ((y - x) / sd).powi(2))
                            .sum::<f64>(),
                    )
                })
                .sum()
        }
        _ => 0.0,
    }
}

fn drive(a: &DriveLog, b: &DriveLog, rover: &Rover) -> f64 {
    let squares = |key: &str, x: &Series, y: &Series| -> f64 {
        let Some(sd) = rover.noise.get(key).filter(|sd| *sd > 0.0) else {
            return 0.0;
        };
        x.iter()
            .zip(y.iter())
            .filter_map(|(x, y)| Some((x?, y?)))
            .map(|(x, y)| ((y - x) / sd).powi(2))
            .sum()
    };
    let mut sum = 0.0;
    for (key, x, y) in [
        (
            "wheel_speed_rad_s",
            Some(&a.wheel_speed),
            Some(&b.wheel_speed),
        ),
        (
            "wheel_torque_N_m",
            a.wheel_torque.as_ref(),
            b.wheel_torque.as_ref(),
        ),
        ("sinkage_m", a.sinkage.as_ref(), b.sinkage.as_ref()),
    ] {
        if let (Some(x), Some(y)) = (x, y) {
            sum += x
                .iter()
                .zip(y)
                .map(|(x, y)| squares(key, x, y))
                .sum::<f64>();
        }
    }
    for (key, x, y) in [
        ("ground_speed_m_s", &a.ground_speed, &b.ground_speed),
        ("yaw_rate_rad_s", &a.yaw_rate, &b.yaw_rate),
        ("accel_x_m_s2", &a.accel_x, &b.accel_x),
    ] {
        if let (Some(x), Some(y)) = (x, y) {
            sum += squares(key, x, y);
        }
    }
    sum
}
