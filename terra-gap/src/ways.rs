//! The way that a ground changes along, where a log does not tell the path: an odometer counts on, a position goes back, and who sets a
//! vehicle down elsewhere begins anew.
//!
//! The first way is that of the vehicle's position ([`Reader`](crate::drive)). Another one is taken where an effect that acts by the
//! path explains the data far better along it than anything along the first.

use std::sync::Arc;

use terra_model::{AnyEffect, Circumstance};

use crate::dataset::DataSet;
use crate::predictor::{OtherWay, Predictor};
use crate::round::{Common, Round};
use crate::signatures::Asked;

/// Nats by which it must explain more: there are four other ways, and each has a chance.
const FAR_BETTER: f64 = 5.0;

/// The other way along which an effect explains far more than anything does along the first, by its place among those that the
/// predictor has.
pub(crate) fn better(
    data: &DataSet,
    common: &Common<'_, '_>,
    now: &dyn Predictor,
    round: &Round,
) -> Option<usize> {
    let by_path = |e: &&Arc<dyn AnyEffect>| e.reads().contains(&Circumstance::Path);
    let effects = round.candidates.effects.iter().filter(by_path);
    let effects: Asked = effects.map(Arc::clone).collect();
    if effects.is_empty() || round.explains_a_gap() {
        return None;
    }
    let bar = round.most() + FAR_BETTER;
    let along = |(k, way): &(usize, OtherWay)| {
        let common = common.by(&*way.predictor);
        Some((*k, round.gained_by(data, &common, &effects, bar)?))
    };
    let ways = now.other_ways().into_iter().enumerate();
    let (odometers, positions): (Vec<_>, Vec<_>) = ways.partition(|(_, way)| way.odometer);
    let mut found: Vec<(usize, f64)> = odometers.iter().filter_map(along).collect();
    // A position goes back in few manoeuvres: where an odometer's way says nothing, no position's does.
    if !found.is_empty() {
        found.extend(positions.iter().filter_map(along));
    }
    let best = found.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(k, _)| k)
}

impl OtherWay {
    /// Takes the data along it, as they were before anything was fitted to them.
    pub(crate) fn take(&self, data: &mut DataSet) {
        for o in &mut data.observations {
            o.factors.insert("path", self.path[o.index]);
        }
    }

    /// What to look at where it was taken.
    pub(crate) fn heed(&self) -> String {
        format!(
            "the log has no distance_m, and is explained best if the path counts {}: log it, or check that it does",
            self.told
        )
    }
}
