//! Is the named soil the truth, or did it absorb an error of vehicle or sensors?
//!
//! Side sums can be fooled: a wrong torque constant hides in the forces a filter estimates, a stuck speed in the slip, and
//! some soil always comes near. The vehicle itself cannot: with the named soils under its wheels it must move as logged.
//! One vehicle filter is run over the log and its innovations are tested in every window of 50 samples; when they are too
//! large, systematic errors are weighed together with every soil and offered by name. In a long log they are weighed on the
//! stretch that the winners explain least: some two thousand vehicle filters are run for them.

use rayon::prelude::*;
use terra_mme::{
    AlarmRule, EstimatorError, Hypothesis, HypothesisSet, InnovationBank, MotionSample,
    OFFERED_GAIN, SYSTEMATIC, SoilMaps, SystematicCandidate, systematic,
};
use terra_model::Registry;

use super::Group;
use super::motion::Motion;
use crate::error::CliError;
use crate::output::short;

/// Tests the winners of all groups on the vehicle; rings and offers candidates in each group when they fail.
pub(super) fn raise(
    groups: &mut [Group],
    motion: &Motion,
    registry: &Registry,
    explain: bool,
) -> Result<(), CliError> {
    let index = |g: &Group| {
        let hypotheses = motion.maps.hypotheses().hypotheses();
        hypotheses
            .iter()
            .position(|h| Some(&h.id) == g.map.as_ref())
    };
    let named: Option<Vec<usize>> = groups.iter().map(index).collect();
    let (maps, named) = match named {
        Some(named) => (motion.maps.clone(), named),
        // Winners that a fit or a refinement made are not among the hypotheses given.
        None => {
            let winners = groups.iter().map(|g| Hypothesis {
                id: format!("{} {}", g.name, g.winner.id),
                ..g.winner.clone()
            });
            let set = HypothesisSet::new(winners.collect())?;
            let indices = (0..set.len()).collect();
            (SoilMaps::new(set, motion.plant.vehicle())?, indices)
        }
    };
    let soils = match named.as_slice() {
        [all] => [*all, *all],
        [left, right] => [*left, *right],
        _ => return Ok(()),
    };
    let rule = AlarmRule::innovations();
    let seen = InnovationBank::check(&maps, &motion.plant, soils, &motion.samples, rule)?;
    if seen.alarm {
        let why = seen.reason.unwrap_or_default();
        for g in groups.iter_mut() {
            g.consistency.alarm = true;
            g.consistency.reason = Some(match g.consistency.reason.take() {
                Some(own) => format!("{own}; on the vehicle: {why}"),
                None => format!("on the vehicle: {why}"),
            });
        }
    }
    if !explain || !groups.iter().any(|g| g.consistency.alarm) {
        return Ok(());
    }
    let stretch = least_explained(&maps, motion, soils, rule)?;
    let effects = SYSTEMATIC
        .iter()
        .map(|name| registry.effect(name))
        .collect::<Result<Vec<_>, _>>()?;
    let candidates: Vec<Vec<SystematicCandidate>> = effects
        .par_iter()
        .map(|effect| {
            let one = std::slice::from_ref(effect);
            systematic(&motion.maps, &motion.plant, one, stretch, rule)
        })
        .collect::<Result<_, EstimatorError>>()?;
    let mut offered: Vec<SystematicCandidate> = candidates
        .into_iter()
        .flatten()
        .filter(|c| c.log_evidence_gain > OFFERED_GAIN)
        .collect();
    offered.sort_by(|a, b| b.log_evidence_gain.total_cmp(&a.log_evidence_gain));
    for g in groups.iter_mut().filter(|g| g.consistency.alarm) {
        let reason = g.consistency.reason.take().unwrap_or_default();
        let told = sentence(&offered);
        g.consistency.reason = Some(match (stretch.first(), stretch.last()) {
            (Some(a), Some(b)) if stretch.len() < motion.samples.len() => {
                let (from, to) = (short(a.time), short(b.time));
                format!("{reason}; from {from} to {to} s: {told}")
            }
            _ => format!("{reason}; {told}"),
        });
        g.candidates.clone_from(&offered);
    }
    Ok(())
}

/// Samples that systematic errors are weighed on.
const STRETCH: usize = 400;

/// The piece of the log in which the soils under left and right wheels leave a window the least explained; a short log whole.
fn least_explained<'m>(
    maps: &SoilMaps,
    motion: &'m Motion,
    soils: [usize; 2],
    rule: AlarmRule,
) -> Result<&'m [MotionSample], CliError> {
    // Pieces of about equal length, so that none is too short to tell.
    let n = motion.samples.len();
    let pieces = n.div_ceil(STRETCH).max(1);
    let worst = motion
        .samples
        .par_chunks(n.div_ceil(pieces).max(1))
        .map(|piece| {
            let seen = InnovationBank::check(maps, &motion.plant, soils, piece, rule)?;
            Ok((seen.worst_nis_per_dof.unwrap_or(0.0), piece))
        })
        .collect::<Result<Vec<_>, EstimatorError>>()?
        .into_iter()
        .reduce(|a, b| if b.0 > a.0 { b } else { a });
    Ok(worst.map_or(&[], |(_, piece)| piece))
}

/// The candidates in words.
fn sentence(offered: &[SystematicCandidate]) -> String {
    let one = |c: &SystematicCandidate| {
        let whole = if c.explains {
            "explains the log"
        } else {
            "comes nearer, but does not explain the log"
        };
        format!(
            "{} {} ± {} {} on {} {whole} (gain {} nats)",
            c.effect,
            short(c.magnitude),
            short(c.sd),
            c.unit,
            c.map,
            c.log_evidence_gain.round()
        )
    };
    if offered.is_empty() {
        return format!(
            "none of {} brings a soil nearer: look for a faulty sensor or ground outside the set",
            SYSTEMATIC.join(", ")
        );
    }
    let list: Vec<String> = offered.iter().take(3).map(one).collect();
    list.join("; ")
}

#[cfg(test)]
mod tests {
    use terra_model::catalogue;
    use terra_sim::{EffectSetting, paper, simulate_drive};

    use super::super::{IdentifyOptions, identify_drive};
    use super::*;

    /// Each systematic error put into a drive makes the alarm ring, and stands first among the causes offered, with the
    /// right soil under it and a magnitude within three of its own sd.
    #[test]
    fn each_systematic_error_is_named() {
        let registry = Registry::builtin();
        let rover = paper::light_rover();
        let soils = catalogue::set("wong21").unwrap();
        let options = IdentifyOptions {
            refine: false,
            ..IdentifyOptions::default()
        };
        for (name, magnitude) in [
            ("slope", 0.05),
            ("accel-bias", 0.15),
            ("ground-speed-scale", -0.05),
            ("torque-scale", 0.1),
            ("mass-error", 0.1),
        ] {
            assert!(SYSTEMATIC.contains(&name));
            let mut scenario = paper::torque_ramp("upland_sandy_loam", 1).unwrap();
            scenario.effects = vec![EffectSetting::new(name, magnitude)];
            let log = simulate_drive(&scenario, &rover, &registry).unwrap().log;
            let told = identify_drive(&log, &rover, &registry, &soils, &options).unwrap();
            for g in &told.groups {
                assert!(g.consistency.alarm, "{name}: {:?}", g.consistency);
                let offered: Vec<_> = g
                    .candidates
                    .iter()
                    .map(|c| (c.effect, c.magnitude, c.sd, c.log_evidence_gain, &*c.map))
                    .collect();
                let first = &g.candidates[0];
                assert_eq!(first.effect, name, "{offered:?}");
                assert_eq!(first.map, "upland_sandy_loam", "{name}: {offered:?}");
                assert!(
                    (first.magnitude - magnitude).abs() < 3.0 * first.sd,
                    "{name}: {offered:?}"
                );
            }
        }
    }
}
