//! Which single effects are fitted, in which order, and where those begin that were found from elsewhere.

use terra_model::order::descending;

use crate::dataset::DataSet;
use crate::hypothesis::Hypothesis;
use crate::predictor::Predictor;
use crate::renewal::Before;
use crate::scout::scout;
use crate::settings::LogKind;
use crate::setup::Screened;
use crate::signatures::Asked;
use crate::weigh::{Amplitudes, NEAR, Weighed};

/// Nats from the best within which a screened effect is confirmed.
const WITHIN: f64 = 10.0;
/// Effects confirmed at least.
const AT_LEAST: usize = 5;
/// The same, once the noise is renewed, where the best gains more than this: the tangent then ranks poorly.
const AT_LEAST_LARGE: (usize, f64) = (9, 50.0);
/// Effects of a drive that are confirmed where the nominal law is far from the data: so many that come near from elsewhere,
/// and so many by the tangent.
const SCOUTED: usize = 5;
const BY_SCREEN: usize = 2;

/// Effects of a drive that are confirmed before the others where the nominal law is near the data: they tell which others
/// cannot win any more.
const FIRST: usize = 3;

/// Windows of a drive up to which all its effects are fitted: on so few the soil follows what is missing nearly by itself, so far
/// away that the tangent there may even promise the wrong sign.
const FEW: usize = 40;

/// Who is fitted.
pub(crate) struct Contenders {
    /// Rows of the screen, the most promising first.
    pub order: Vec<usize>,
    /// How many of them are fitted before the others.
    pub first: usize,
    /// Whether the others are fitted only if none of these explains the data.
    pub only_if_unexplained: bool,
    /// Rank from which a drive's effect that the screen does not ask for is weighed by the screen alone.
    pub sure: usize,
    /// Whether the tangent at the nominal fit can be relied on.
    pub near: bool,
    /// Whether the log is so short that every effect is fitted, and from the prior centre too.
    pub all: bool,
    /// Where effects were found from the prior centre.
    found: Vec<(usize, Vec<f64>)>,
}

impl Contenders {
    /// Chooses them by the screen, by who was there before, and far from the data by a look around.
    pub(crate) fn choose(
        data: &DataSet,
        predictor: &dyn Predictor,
        kind: LogKind,
        null: &Hypothesis,
        null_weighed: &Weighed,
        levels: &Amplitudes,
        screen: &[Screened],
        asked: &Asked,
        previous: Option<Before<'_>>,
    ) -> Self {
        let gain = |k: usize| screen[k].score.log_bayes_factor;
        let mut order: Vec<usize> = (0..asked.len()).collect();
        descending(&mut order, |&k| gain(k));
        let best = order.first().map_or(0.0, |&k| gain(k));
        let (large, from) = AT_LEAST_LARGE;
        let sure = if previous.is_some() && best > from {
            large
        } else {
            AT_LEAST
        };
        let near = kind != LogKind::Drive || null_weighed.chi2_per_value() < NEAR;
        let few = kind == LogKind::Drive && data.observations.len() <= FEW;
        let sure = if few { asked.len() } else { sure };
        let known = |k: usize| previous.is_some_and(|p| p.single(&*asked[k]).is_some());
        // Far from the data the tangent says little: who comes near from elsewhere is confirmed, and stays in the contest.
        let mut found = vec![];
        if let (Some(windows), false, None) = (&levels.thin, near, &previous) {
            found = scout(predictor, null, windows, asked, SCOUTED);
        }
        let ranked = order.iter().copied().enumerate();
        let (order, first, only_if_unexplained) = if !found.is_empty() {
            let by_screen = order.iter().take(BY_SCREEN).copied();
            let by_screen = by_screen.filter(|k| found.iter().all(|(f, _)| f != k));
            let chosen = found.iter().map(|(k, _)| *k).chain(by_screen);
            (chosen.collect(), 1, false)
        } else if previous.is_some() && !near {
            // Who else could, the tangent says as badly as ever, but as long as nobody explains the data it is asked.
            let explained = previous.is_some_and(|p| p.0.all().any(|w| w.chi2_per_value() < NEAR));
            let more = if explained { 0 } else { sure };
            let chosen = ranked.filter(|&(rank, k)| known(k) || rank < more);
            let (mut chosen, others): (Vec<usize>, Vec<usize>) =
                chosen.map(|(_, k)| k).partition(|&k| known(k));
            let first = chosen.len();
            chosen.extend(others);
            (chosen, first, true)
        } else {
            // Contrasts on rigs are large and the linear screen may only order work there, never exclude.
            let all = kind == LogKind::Rig || few;
            let chosen = ranked
                .filter(|&(rank, k)| all || rank < sure || known(k) || gain(k) > best - WITHIN);
            let chosen: Vec<usize> = chosen.map(|(_, k)| k).collect();
            let first = if kind == LogKind::Drive && near && !few {
                FIRST
            } else {
                chosen.len()
            };
            (chosen, first, false)
        };
        Contenders {
            order,
            first,
            only_if_unexplained,
            sure,
            near,
            all: few,
            found,
        }
    }

    /// Where an effect was found from the prior centre.
    pub(crate) fn found(&self, row: usize) -> Option<&[f64]> {
        let mut found = self.found.iter();
        found.find(|(k, _)| *k == row).map(|(_, x)| x.as_slice())
    }
}
