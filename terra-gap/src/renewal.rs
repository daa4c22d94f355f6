//! What a round found under one noise, for the round under the next: starts, and who is out of the contest.

use terra_model::AnyEffect;

use crate::fit::Fit;
use crate::hypothesis::Hypothesis;
use crate::round::Round;
use crate::setup::Screened;
use crate::weigh::Weighed;

/// A rival whose misfit beyond the noise is so many times the best one's, and so much more, is out: another noise or another
/// start would have to change the misfit by as much.
const OUT: (f64, f64) = (3.0, 100.0);
/// The same where the best one is itself far from the data, so that another may still come nearer.
const HOPELESS: (f64, f64) = (10.0, 1000.0);

/// The round before.
#[derive(Clone, Copy)]
pub(crate) struct Before<'a>(pub(crate) &'a Round);

impl<'a> Before<'a> {
    /// What it found for one effect that it fitted.
    pub(crate) fn single(self, effect: &dyn AnyEffect) -> Option<&'a Weighed> {
        let same = |s: &Screened| s.name == effect.name() && s.form == effect.form();
        let mut singles = self.0.singles.iter();
        let (_, found) = singles.find(|(k, _)| same(&self.0.screen[*k]))?;
        found.first().filter(|w| w.fitted)
    }

    /// What it found for two effects in these forms, in whatever order.
    pub(crate) fn pair(self, of: &Hypothesis) -> Option<&'a Weighed> {
        let of = of.effect_forms();
        let mut pairs = self.0.pairs.iter();
        pairs.find(|w| w.hypothesis.effect_forms() == of)
    }

    /// True where it is too far from the data for another noise to bring it back.
    pub(crate) fn out(self, rival: &Weighed) -> bool {
        out(rival, self.0.all())
    }
}

/// True where a rival is out of the contest with these.
pub(crate) fn out<'a>(rival: &Weighed, others: impl Iterator<Item = &'a Weighed>) -> bool {
    let least = others.map(|w| beyond(&w.plain));
    behind(&rival.plain, least.fold(f64::INFINITY, f64::min), OUT)
}

/// True where a fit is so far behind another that it need not be looked at again, wherever the other stands.
pub(crate) fn hopeless(rival: &Fit, best: &Fit) -> bool {
    behind(rival, beyond(best), HOPELESS)
}

/// Misfit per value from which others are hopelessly behind this one.
pub(crate) fn hopeless_from(best: &Fit) -> f64 {
    let (times, more) = HOPELESS;
    1.0 + (times * beyond(best) + more) / best.residual.len().max(1) as f64
}

fn behind(rival: &Fit, least: f64, (times, more): (f64, f64)) -> bool {
    beyond(rival) > times * least + more
}

/// Misfit beyond the noise.
fn beyond(fit: &Fit) -> f64 {
    (fit.cost - fit.residual.len() as f64).max(0.0)
}
