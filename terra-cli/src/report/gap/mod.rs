//! A diagnosis, told: the verdict, how far the misfit shrinks, where it was, what could cause it, what to do next.

mod causes;
mod curves;
mod data;
mod misfit;
mod place;
mod soil;
mod stress;
mod verdict;
mod waterfall;

use std::sync::Arc;

use terra_gap::{Cause, CauseKind, Diagnosis, OTHER_SOIL};
use terra_model::{AnyEffect, Registry};

use super::block::Section;

pub(crate) use causes::magnitudes;
pub use curves::{Curve, GapCurves, Panel, Point};
pub use stress::Stresses;

/// The sim-to-real diagnosis as a section: verdict, waterfall, curves, where, causes, soil, look-alikes and next
/// experiments, data.
///
/// Curves exist for rig logs ([`GapCurves::of_rig`]); without them that figure is left out.
pub fn gap_section(d: &Diagnosis, curves: Option<&GapCurves>) -> Section {
    let title = match d.kind {
        terra_gap::LogKind::Rig => "The gap between simulator and wheel rig",
        terra_gap::LogKind::Kinematic => "The gap between simulator and vehicle, by its motion",
        terra_gap::LogKind::Drive => "The gap between simulator and vehicle",
    };
    let mut s = Section::new(title);
    verdict::write(&mut s, d);
    waterfall::write(&mut s, d);
    curves::write(&mut s, d, curves);
    place::write(&mut s, d);
    if curves.is_none() {
        misfit::write(&mut s, d);
    }
    causes::write(&mut s, d);
    soil::write(&mut s, d);
    causes::write_look_alikes(&mut s, d);
    causes::write_next(&mut s, d);
    data::write(&mut s, d);
    s
}

/// An effect by name: the one that was fitted, so that a user's own is found too, else the built-in one.
fn effect(d: &Diagnosis, name: &str) -> Option<Arc<dyn AnyEffect>> {
    d.causes
        .iter()
        .flat_map(|c| c.weighed.hypothesis.effects())
        .find(|e| e.name() == name)
        .cloned()
        .or_else(|| Registry::builtin().effect(name).ok())
}

/// What a cause is, in words.
fn summary(d: &Diagnosis, cause: &Cause) -> String {
    let effects = cause.weighed.hypothesis.effects();
    match cause.kind {
        CauseKind::Structure if cause.name == OTHER_SOIL => {
            "another soil than the simulator's".to_owned()
        }
        CauseKind::Structure => format!(
            "the terrain model {} in place of {}",
            cause.weighed.hypothesis.law.model().name(),
            d.model
        ),
        CauseKind::Effect => effects.first().map_or("", |e| e.summary()).to_owned(),
        CauseKind::Combination => effects
            .iter()
            .map(|e| e.summary())
            .collect::<Vec<_>>()
            .join("; and "),
    }
}

/// The accepted cause as it stands in the ranking.
fn accepted(d: &Diagnosis) -> Option<&Cause> {
    if d.accepted_names.is_empty() {
        return None;
    }
    let name = d.accepted_names.join("+");
    d.causes.iter().find(|c| c.name == name)
}
