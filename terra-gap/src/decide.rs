//! From probabilities to words.

use crate::calibration::Calibration;
use crate::cause::{Cause, CauseKind, Ranking};
use crate::fit::Fit;
use crate::hypothesis::Hypothesis;
use crate::settings::LogKind;
use crate::setup::ADEQUATE;
use crate::weigh::Weighed;

/// Nats within which explanations are equally near.
const NEAREST: f64 = 5.0;

/// What the diagnosis says.
pub(crate) struct Decision {
    pub(crate) verdict: &'static str,
    pub(crate) reason: Option<String>,
    pub(crate) nearest: Vec<String>,
    pub(crate) accepted: Option<(Hypothesis, Fit)>,
    pub(crate) accepted_names: Vec<String>,
}

impl Decision {
    /// Whether effects of the library are the answer, or one of them.
    pub(crate) fn is_an_effect(&self) -> bool {
        let effect = |(h, _): &(Hypothesis, Fit)| !h.effects().is_empty();
        ["named", "ambiguous"].contains(&self.verdict) && self.accepted.as_ref().is_some_and(effect)
    }

    /// A name is no longer the only answer, or there is one more reason why it is not.
    pub(crate) fn doubt(&mut self, reason: String) {
        if self.verdict == "named" {
            self.verdict = "ambiguous";
        }
        if self.verdict == "ambiguous" {
            self.reason.get_or_insert(reason);
        }
    }
}

/// From probabilities to words. A failed gate turns a name into `unknown`, never the reverse.
pub(crate) fn decide(
    ranking: &Ranking,
    null: &Weighed,
    kind: LogKind,
    calibration: &Calibration,
) -> Decision {
    let mut out = Decision {
        verdict: "none",
        reason: None,
        nearest: vec![],
        accepted: None,
        accepted_names: vec![],
    };
    let causes = &ranking.causes;
    let gated = kind != LogKind::Drive;
    let null_chi2 = null.chi2_per_value();
    let named: Vec<&Cause> = causes
        .iter()
        .filter(|c| ranking.set.contains(&c.name))
        .collect();
    let alone = named.first().map_or(0.0, |c| c.probability);
    let best = ranking.stand_in.map_or(alone, |(both, _)| both.max(alone));
    let (none, unknown) = (ranking.probability_none, ranking.probability_unknown);
    let gain = ranking.heard;

    let leading = causes.first().filter(|_| ranking.misfits);
    if let Some(top) = leading {
        out.verdict = "unknown";
        out.nearest = named.iter().map(|c| c.name.clone()).collect();
        out.reason = Some(format!(
            "form unknown: the best known explanation still misfits by chi2/n = {:.1} (adequate is up to {ADEQUATE}; the re-fitted nominal model has {null_chi2:.1})",
            top.weighed.chi2_per_value()
        ));
        accept(&mut out, top);
    } else if gated && null_chi2 > ADEQUATE && unknown > best {
        // A smooth error of the wheel law's form would do as well as any name, but noise alone does not explain the
        // misfit: say which known effects come closest to explaining it within the noise.
        let closest = nearest(causes);
        out.verdict = "unknown";
        out.reason = Some(format!(
            "form unknown: after re-fitting the soil the misfit is chi2/n = {null_chi2:.1} (adequate is up to {ADEQUATE}), but a smooth error of the wheel law's form explains it about as well as any known effect"
        ));
        out.nearest = closest.iter().map(|c| c.name.clone()).collect();
        if let Some(c) = closest.first() {
            accept(&mut out, c);
        }
    } else if (none >= best && none >= unknown)
        || (best >= unknown && gain < calibration.null_gain && !(gated && null_chi2 > ADEQUATE))
    {
        // An effect that gains no more than the best of thirty does on logs without any is not there.
        let first = ranking.set.first().is_none_or(|a| a == "none");
        let unheard = gain < calibration.null_gain;
        out.verdict = if ranking.set.len() == 1 || (unheard && first) {
            "none"
        } else {
            "ambiguous"
        };
        let bar = calibration.null_gain;
        out.reason = (ranking.set.len() > 1).then(|| {
            if unheard {
                format!(
                    "no cause gains more ({gain:.1} nats) than the best of all does by chance where nothing is missing ({bar:.1}); the others of the set are weak enough to hide behind that"
                )
            } else {
                format!(
                    "nothing missing is the likeliest, but a cause gains {gain:.1} nats, more than the best of all does by chance where nothing is missing ({bar:.1})"
                )
            }
        });
    } else if unknown >= best {
        out.verdict = if ranking.set.len() == 1 {
            "unknown"
        } else {
            "ambiguous"
        };
        out.nearest = causes.iter().take(3).map(|c| c.name.clone()).collect();
        out.reason = Some(if gated && null.usual < 0.5 {
            format!(
                "form unknown: a smooth error of the wheel law's form of about {:.0} % of the load explains the gap as well as any known effect",
                100.0 * null.amplitude
            )
        } else {
            "no known effect explains the gap".to_owned()
        });
    } else if let Some(top) = named.first() {
        out.verdict = if ranking.set.len() == 1 {
            "named"
        } else {
            "ambiguous"
        };
        let nearly = ranking.nearly.as_ref().map(|name| {
            format!(
                "{name} explains nearly all, but not within the noise: its formula may be another here, or something unknown does much the same"
            )
        });
        out.reason = nearly.or_else(|| ranking.stand_in.map(|(_, why)| why.to_owned()));
        accept(&mut out, top);
    }
    out
}

/// Causes within [`NEAREST`] nats of the best against the noise alone, at most five, best first.
fn nearest(causes: &[Cause]) -> Vec<&Cause> {
    let mut order: Vec<&Cause> = causes.iter().collect();
    order.sort_by(|a, b| {
        b.weighed
            .plain_log_evidence
            .total_cmp(&a.weighed.plain_log_evidence)
    });
    let best = order.first().map_or(0.0, |c| c.weighed.plain_log_evidence);
    order.retain(|c| c.weighed.plain_log_evidence > best - NEAREST);
    order.truncate(5);
    order
}

fn accept(out: &mut Decision, cause: &Cause) {
    let h = &cause.weighed.hypothesis;
    out.accepted_names = match cause.kind {
        CauseKind::Structure => vec![cause.name.clone()],
        _ => h.effects().iter().map(|e| e.name().to_owned()).collect(),
    };
    out.accepted_names.sort_unstable();
    out.accepted = Some((h.clone(), cause.weighed.plain.clone()));
}
