//! Logs that are said to share a soil, and do not.

use std::sync::Arc;

use terra_data::Rover;
use terra_model::Registry;

use crate::dataset::DataSet;
use crate::diagnose::Diagnosis;
use crate::drive::DrivePredictor;
use crate::error::GapError;
use crate::evidence::posterior;
use crate::fit::Fit;
use crate::hypothesis::Hypothesis;
use crate::null::{drop_unanswered, refit_to_the_end};
use crate::parallel::among_them;
use crate::run::setup;
use crate::settings::LogKind;

/// Nats by which the nominal law with a soil of its own for each log must be likelier than all there is on one soil.
const APART: f64 = 5.0;
/// Share of the misfit on one soil below which that is told too where nothing explains the logs.
const HALF: f64 = 0.5;

/// What to heed where logs of one soil, as was said, are explained better by one each and nothing else, or less badly by far.
///
/// # Errors
/// A configuration that makes no sense.
pub(crate) fn better_apart(
    together: &Diagnosis,
    (mut data, predictor): (DataSet, DrivePredictor),
    labels: &[String],
    rover: &Rover,
    registry: &Registry,
) -> Result<Option<String>, GapError> {
    // What the data say of a fit: that the same sensors' noise comes to more through other slopes makes no difference.
    let says = |h: &Hypothesis, fit: &Fit| posterior(h, fit).log_evidence + 0.5 * fit.log_det;
    let causes = together.causes.iter().map(|c| &c.weighed);
    let causes = causes.map(|w| says(&w.hypothesis, &w.plain));
    let null = together.null.as_ref().map(|(h, fit)| says(h, fit));
    let Some(best) = causes.chain(null).max_by(f64::total_cmp) else {
        return Ok(None);
    };
    among_them(|| {
        let setup = setup(registry, rover, LogKind::Drive, labels)?;
        let apart = Hypothesis::null(setup.law.clone(), Arc::clone(&setup.soil));
        drop_unanswered(&mut data, &predictor, &apart, &vec![0.0; apart.len()]);
        let Ok(Some(found)) = refit_to_the_end(&mut data, &predictor, &setup, &apart) else {
            return Ok(None);
        };
        let gain = says(&apart, &found.fitted) - best;
        let misfit = found.fitted.chi2() / data.len() as f64;
        let one = together
            .null
            .as_ref()
            .map_or(0.0, |(_, fit)| fit.chi2() / data.len() as f64);
        let open = together.set.iter().any(|answer| answer == "unknown");
        let beside = if gain > APART {
            format!("and is {gain:.0} nats likelier than the best answer on one soil")
        } else if open && misfit < HALF * one {
            format!("where one soil leaves {one:.3}")
        } else {
            return Ok(None);
        };
        Ok(Some(format!(
            "with a soil of its own for each log (--soil own) the nominal law alone leaves a misfit of {misfit:.3} {beside}"
        )))
    })
}
