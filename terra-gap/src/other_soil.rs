//! Effects on other soil than the baseline's: two things may differ from a simulator at once.
//!
//! A simulator's wheel law is never the ground's own, so that what a baseline teaches is off on the real log beside whatever is
//! missing there. `soil-change`, with its soil and its error of the wheel law's form free, takes both; an effect by itself takes
//! neither. So where other soil says something, every effect is fitted on it too.

use std::sync::Arc;

use terra_model::order::descending;

use crate::cause::Cause;
use crate::dataset::DataSet;
use crate::evidence::log_sum_exp;
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::settings::LogKind;
use crate::setup::OTHER_SOIL;
use crate::signatures::Asked;
use crate::weigh::{Amplitudes, Weighed, contest, weigh};

/// Nats that other soil must say more than the baseline's for effects to be asked on it.
const SAYS: f64 = 3.0;
/// Nats by which an effect on other soil must beat both other soil alone and the effect alone.
const BOTH: f64 = 3.0;
/// Prior of an effect on other soil relative to either alone.
const BOTH_PRIOR: f64 = 0.1;

/// What is said of other soil and an effect together.
#[derive(Clone, Debug, Default)]
pub(crate) struct OtherSoil {
    /// Single effects on it, the one that says most first; of an effect's forms the best.
    pub effects: Vec<Weighed>,
}

/// Weighs every effect on other soil, where that says more than the baseline's by itself.
pub(crate) fn weigh_on_other_soil(
    data: &DataSet,
    predictor: &dyn Predictor,
    kind: LogKind,
    structures: &[(String, Weighed)],
    null: &Weighed,
    asked: &Asked,
    levels: &Amplitudes,
) -> OtherSoil {
    let other = structures.iter().find(|(name, _)| name == OTHER_SOIL);
    let Some((_, other)) = other.filter(|(_, w)| w.log_evidence > null.log_evidence + SAYS) else {
        return OtherSoil::default();
    };
    let each = for_each(asked.len(), |k| {
        let h = other.hypothesis.with(Arc::clone(&asked[k])).ok()?;
        let beside = |magnitude: f64| {
            let mut start = other.fit.x.as_slice().to_vec();
            start.resize(h.len(), magnitude);
            start
        };
        let starts = [0.0, 1.0, -1.0].map(beside);
        weigh(data, predictor, &h, levels, &starts, None, contest(kind)).ok()
    });
    let mut effects: Vec<Weighed> = each.into_iter().flatten().collect();
    descending(&mut effects, |w| w.log_evidence);
    let mut names: Vec<String> = vec![];
    effects.retain(|w| {
        let name = w.hypothesis.effect_name();
        let new = !names.contains(&name);
        names.push(name);
        new
    });
    OtherSoil { effects }
}

impl OtherSoil {
    /// Tells a cause on other soil where it says clearly more there than alone and than other soil alone. Evidences against
    /// that of the nominal law, `null`.
    pub(crate) fn tell(&self, causes: &mut [Cause], null: f64) {
        let other = causes.iter().find(|c| c.name == OTHER_SOIL);
        let Some(soil) = other.map(|c| c.log_evidence_gain) else {
            return;
        };
        for w in &self.effects {
            let name = w.hypothesis.effect_name();
            let both = w.log_evidence - null;
            let alone = causes.iter_mut().find(|c| c.name == name);
            if let Some(alone) = alone.filter(|c| both > soil.max(c.log_evidence_gain) + BOTH) {
                alone.log_evidence_gain =
                    log_sum_exp([alone.log_evidence_gain, both + BOTH_PRIOR.ln()]);
                alone.on_other_soil = true;
                w.hypothesis
                    .effects()
                    .first()
                    .map_or("", |e| e.form())
                    .clone_into(&mut alone.form);
                alone.weighed = w.clone();
            }
        }
    }

    /// The effect that says most on it.
    pub(crate) fn first(&self) -> Option<String> {
        self.effects.first().map(|w| w.hypothesis.effect_name())
    }
}
