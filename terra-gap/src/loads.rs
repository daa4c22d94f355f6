//! Whether load goes to the outer wheels in turns. On the ground it does; many a simulator's vehicle stays upright, and without this
//! its logs read as drag in the drivetrain or a wrong track.
//!
//! A log is taken for that of a vehicle that leans, and for the other where that explains it far better: by the nominal law, whose two
//! fits are compared before anything else, or by one of the explanations that come of it. What is missing may act in turns too and
//! look like the other vehicle: where neither the nominal law nor a single effect explains the log by that one, both are heard.

use terra_model::order::descending;

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::evidence::posterior;
use crate::fit::{Effort, Fit, fit_near, residual};
use crate::hypothesis::Hypothesis;
use crate::null::Refit;
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::round::Round;
use crate::weigh::{Weighed, weigh};

/// Where it may turn out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Doubt {
    /// At the fit of the nominal law.
    Nominal,
    /// At the best explanations.
    Best,
}

/// Nats by which the other vehicle must explain more.
const FAR_BETTER: f64 = 5.0;
/// And a second cause, which may stand for the load: what the calibration of rich drives asks of one, here before any calibration is known.
const SECOND: f64 = 7.0;
/// Nats by which a fit may end better than its tangent promises.
const BENT: f64 = 50.0;
/// How many of the best single effects are asked, and of the best pairs.
const ASKED: usize = 4;

/// Whether the nominal law explains the data far better by the other vehicle.
///
/// # Errors
/// A covariance that is not positive definite.
pub(crate) fn better_at_the_null(
    data: &DataSet,
    null: &Hypothesis,
    found: &Refit,
) -> Result<bool, GapError> {
    let Some(other) = found.predictor.otherwise_loaded() else {
        return Ok(false);
    };
    let whitener = found.noise.whitener(data)?;
    let fitted = &found.fitted;
    let (start, effort) = (fitted.x.as_slice(), Effort::Again);
    // Soil that carries the one may not carry the other.
    let Ok(there) = fit_near(data, &*other, null, &whitener, start, None, effort) else {
        return Ok(false);
    };
    let evidence = |fit| posterior(null, fit).log_evidence;
    // Far from the data a nat is less: noise as large as the misfit would make it so.
    let misfit = (there.chi2() / data.len() as f64).max(1.0);
    Ok(evidence(&there) > evidence(fitted) + FAR_BETTER * misfit)
}

/// Whether one of the best explanations explains them far better by the other vehicle than any does by this one.
pub(crate) fn better_at_the_best(data: &DataSet, now: &dyn Predictor, round: &Round) -> bool {
    let Some(other) = now.otherwise_loaded() else {
        return false;
    };
    // A single effect may be behind because of what another one mends with it that is the load's.
    let mut asked = best_of(round.singles.iter().flat_map(|(_, w)| w));
    asked.extend(best_of(&round.pairs));
    asked.push(&round.null_weighed);
    let most = |all: Vec<f64>| all.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let by_this = round.all().chain([&round.null_weighed]).map(says);
    let bar = most(by_this.collect()) + FAR_BETTER;
    asked.retain(|w| promised(data, &*other, round, w) + BENT > bar);
    let by_other = |k: usize| {
        let Weighed {
            hypothesis, plain, ..
        } = asked[k];
        let start = [plain.x.as_slice().to_vec()];
        let effort = Effort::Again;
        let there = weigh(
            data,
            &*other,
            hypothesis,
            &round.levels,
            &start,
            None,
            effort,
        );
        there.map_or(f64::NEG_INFINITY, |w| says(&w))
    };
    most(for_each(asked.len(), by_other)) > bar
}

/// What an explanation would [say](says) by another vehicle if all went on as straight as it ended.
fn promised(data: &DataSet, other: &dyn Predictor, round: &Round, rival: &Weighed) -> f64 {
    let Weighed {
        hypothesis, plain, ..
    } = rival;
    let Ok(raw) = residual(data, other, hypothesis, plain.x.as_slice()) else {
        return f64::NEG_INFINITY;
    };
    let residual = round.plain.apply_vector(&raw);
    let cost = residual.norm_squared() + plain.x.norm_squared();
    let there = Fit {
        residual,
        cost,
        ..plain.clone()
    };
    says(rival) + 0.5 * (plain.cost - (cost - there.promise()))
}

/// ln Z, less what a second cause must gain.
pub(crate) fn says(rival: &Weighed) -> f64 {
    let causes = rival.hypothesis.effects().len();
    rival.log_evidence - SECOND * causes.saturating_sub(1) as f64
}

fn best_of<'a>(rivals: impl IntoIterator<Item = &'a Weighed>) -> Vec<&'a Weighed> {
    let mut all: Vec<&Weighed> = rivals.into_iter().filter(|w| w.fitted).collect();
    descending(&mut all, |w| w.log_evidence);
    all.truncate(ASKED);
    all
}
