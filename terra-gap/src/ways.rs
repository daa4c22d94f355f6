//! The way that a ground changes along, where a log does not tell the path: an odometer counts on, a position goes back, and who sets a
//! vehicle down elsewhere begins anew. And how often wheels rolled over it: an earlier pass of the vehicle is one, or one of each axle.
//!
//! The first way is that of the vehicle's position ([`Reader`](crate::drive)), with a pass of the vehicle as one. Another one is taken
//! where an effect that acts by path or passes explains the data far better along it than anything along the first.

use std::sync::Arc;

use terra_model::Circumstance;

use crate::dataset::DataSet;
use crate::predictor::{Counts, OtherWay, Predictor};
use crate::round::{Common, Round};
use crate::signatures::Asked;

/// Nats by which it must explain more: there are five other ways, and each has a chance.
const FAR_BETTER: f64 = 5.0;

/// The other way along which an effect explains far more than anything does along the first, by its place among those that the
/// predictor has.
pub(crate) fn better(
    data: &DataSet,
    common: &Common<'_, '_>,
    now: &dyn Predictor,
    round: &Round,
) -> Option<usize> {
    if round.explains_a_gap() {
        return None;
    }
    let bar = round.most() + FAR_BETTER;
    let along = |(k, way): (usize, &OtherWay)| {
        let reads = way.counts.reads();
        let effects = round.candidates.effects.iter();
        let effects = effects.filter(|e| e.reads().contains(&reads));
        let effects: Asked = effects.map(Arc::clone).collect();
        if effects.is_empty() {
            return None;
        }
        let common = common.by(&*way.predictor);
        Some((k, round.gained_by(data, &common, &effects, bar)?))
    };
    let ways = now.other_ways();
    let of = |counts: fn(&Counts) -> bool| {
        let ways = ways.iter().enumerate().filter(move |w| counts(&w.1.counts));
        ways.filter_map(along)
    };
    let mut found: Vec<(usize, f64)> = of(|c| matches!(c, Counts::Odometer(_))).collect();
    // A position goes back in few manoeuvres: where an odometer's way says nothing, no position's does.
    if !found.is_empty() {
        found.extend(of(|c| matches!(c, Counts::Position(_))));
    }
    found.extend(of(|c| matches!(c, Counts::Passes)));
    let best = found.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(k, _)| k)
}

impl Counts {
    /// What an effect acts by to which it matters.
    fn reads(&self) -> Circumstance {
        match self {
            Counts::Odometer(_) | Counts::Position(_) => Circumstance::Path,
            Counts::Passes => Circumstance::EarlierPasses,
        }
    }
}

impl OtherWay {
    /// Takes the data along it, as they were before anything was fitted to them.
    pub(crate) fn take(&self, data: &mut DataSet) {
        if let Counts::Odometer(path) | Counts::Position(path) = &self.counts {
            for o in &mut data.observations {
                o.factors.insert("path", path[o.index]);
            }
        }
    }

    /// What to look at where it was taken.
    pub(crate) fn heed(&self) -> String {
        let told = self.told;
        match self.counts {
            Counts::Odometer(_) | Counts::Position(_) => format!(
                "the log has no distance_m, and is explained best if the path counts {told}: log it, or check that it does"
            ),
            Counts::Passes => {
                format!("explained best if an earlier pass counts {told}: check what pass says")
            }
        }
    }
}
