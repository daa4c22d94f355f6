//! One case marked: what was true, what was answered, which of it was right.

use super::answer::Verdict;
use super::shares::Kind;

/// A case with its truth and its answer.
#[derive(Clone, Debug)]
pub(crate) struct Marked {
    pub(crate) case: String,
    pub(crate) kind: Kind,
    /// `none`, a name, names joined by `+`, or `unknown`.
    pub(crate) truth: String,
    /// Names in the truth.
    pub(crate) effects: Vec<String>,
    /// None when there is no verdict: wrong in every figure.
    pub(crate) verdict: Option<Verdict>,
}

impl Marked {
    /// The truth is among the first `k` causes.
    pub(crate) fn in_first(&self, k: usize) -> bool {
        self.verdict
            .as_ref()
            .is_some_and(|v| v.causes.iter().take(k).any(|c| c.effect == self.truth))
    }

    /// The first cause is the truth, or one that the verdict says cannot be told from it on this log.
    pub(crate) fn first_in_group(&self) -> bool {
        let Some(v) = &self.verdict else { return false };
        let Some(first) = v.causes.first() else {
            return false;
        };
        first.effect == self.truth
            || first.indistinguishable_from.contains(&self.truth)
            || v.causes
                .iter()
                .find(|c| c.effect == self.truth)
                .is_some_and(|c| c.indistinguishable_from.contains(&first.effect))
    }

    /// Every name of the first cause is in the truth.
    pub(crate) fn first_in_truth(&self) -> bool {
        let first = self.verdict.as_ref().and_then(|v| v.causes.first());
        first.is_some_and(|c| {
            c.effect
                .split('+')
                .all(|name| self.effects.iter().any(|e| e == name))
        })
    }

    /// Every name of the truth is in one of the first three causes.
    pub(crate) fn all_in_three(&self) -> bool {
        let Some(v) = &self.verdict else { return false };
        self.effects.iter().all(|e| {
            v.causes
                .iter()
                .take(3)
                .any(|c| c.effect.split('+').any(|name| name == e))
        })
    }

    /// The most probable answer and its probability; none without probabilities.
    pub(crate) fn first(&self) -> Option<(&str, f64)> {
        let ranked = self.verdict.as_ref()?.ranked();
        ranked.first().copied().filter(|(_, p)| *p > 0.0)
    }

    /// The most probable answer, `none` and `unknown` among them, is the truth.
    pub(crate) fn answered(&self) -> bool {
        self.first().is_some_and(|(a, _)| a == self.truth)
    }

    /// Confidence of the answer and whether it is right. A missing verdict is sure and wrong; one without probabilities
    /// claims nothing.
    pub(crate) fn confidence(&self) -> Option<(f64, bool)> {
        match &self.verdict {
            None => Some((1.0, false)),
            Some(_) => self.first().map(|(a, p)| (p, a == self.truth)),
        }
    }

    /// The truth is in the set.
    pub(crate) fn covered(&self) -> bool {
        self.verdict
            .as_ref()
            .is_some_and(|v| v.set.contains(&self.truth))
    }

    /// Something is claimed to be missing; a missing verdict is on the wrong side.
    pub(crate) fn alarmed(&self) -> bool {
        match &self.verdict {
            Some(v) => v.alarms(),
            None => self.kind == Kind::None,
        }
    }

    /// The verdict is another one than that nothing is missing; a missing one is on the wrong side.
    pub(crate) fn noticed(&self) -> bool {
        match &self.verdict {
            Some(v) => v.notices(),
            None => self.kind == Kind::None,
        }
    }

    /// Probability of `unknown`; a missing verdict is on the wrong side.
    pub(crate) fn unknown(&self) -> f64 {
        match &self.verdict {
            Some(v) => v.probability_unknown,
            None => f64::from(u8::from(self.kind != Kind::OffLibrary)),
        }
    }

    /// Right as this kind of case asks: `none` without an alarm, the first cause for one effect, the most probable
    /// answer otherwise.
    pub(crate) fn right(&self) -> bool {
        match self.kind {
            Kind::None => self.verdict.is_some() && !self.alarmed(),
            Kind::Single | Kind::FormVariant => self.in_first(1),
            Kind::Pair | Kind::OffLibrary => self.answered(),
        }
    }
}
