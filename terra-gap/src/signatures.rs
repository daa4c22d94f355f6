//! The signature of every candidate at a fit: its exact column, screened.

use std::sync::Arc;

use nalgebra::DMatrix;
use terra_model::AnyEffect;

use crate::dataset::DataSet;
use crate::fit::{Fit, evaluate, evaluate_from};
use crate::hypothesis::Hypothesis;
use crate::memory::Memory;
use crate::noise::Whitener;
use crate::predictor::Predictor;
use crate::screen::Tangent;
use crate::setup::Screened;

/// Effects that stand in one law: as many as one pass carries derivatives.
pub(crate) const TOGETHER: usize = 8;

pub(crate) type Asked = Vec<Arc<dyn AnyEffect>>;

/// Screens every candidate at a fit; effects without a trace are set aside with that reason.
///
/// Candidates stand in one law at magnitude zero, where each leaves the others alone, so one exact Jacobian holds the
/// signatures of several.
pub(crate) fn screen_all(
    data: &DataSet,
    predictor: &dyn Predictor,
    base: &Hypothesis,
    fit: &Fit,
    effects: &[Arc<dyn AnyEffect>],
    whitener: &Whitener,
    not_asked: &mut Vec<(String, String)>,
) -> (Vec<Screened>, Asked) {
    let x = fit.x.as_slice();
    let Ok(here) = evaluate(data, predictor, base, x) else {
        return (vec![], vec![]);
    };
    let tangent = Tangent::of(&Fit {
        residual: whitener.apply_vector(&here.residual),
        jacobian: whitener.apply(&here.jacobian),
        ..fit.clone()
    });
    let of = |effects: &[Arc<dyn AnyEffect>]| columns(data, predictor, base, x, effects, whitener);
    let (mut screen, mut asked) = (vec![], vec![]);
    for some in effects.chunks(TOGETHER) {
        // One effect without an answer or a slope here spoils all: then each is asked by itself.
        let together = of(some)
            .ok()
            .filter(|all| all.iter().all(|v| v.is_finite()));
        for (k, effect) in some.iter().enumerate() {
            let column = match &together {
                Some(all) => Ok(all.column(k).into_owned()),
                None => of(std::slice::from_ref(effect)).map(|one| one.column(0).into_owned()),
            };
            let reason = match column {
                Err(reason) => reason,
                Ok(column) if !column.iter().all(|v| v.is_finite()) => {
                    "its signature is not finite on this data".to_owned()
                }
                Ok(column) if column.norm_squared() < 1e-8 => {
                    "leaves no trace in these channels".to_owned()
                }
                Ok(column) => {
                    let one_sided = effect.params().first().is_some_and(|p| p.one_sided());
                    screen.push(Screened {
                        name: effect.name().to_owned(),
                        form: effect.form().to_owned(),
                        score: tangent.score(column, one_sided),
                    });
                    asked.push(Arc::clone(effect));
                    continue;
                }
            };
            not_asked.push((effect.name().to_owned(), reason));
        }
    }
    (screen, asked)
}

/// Whitened -dr/ds of the first magnitude of each effect; the reason where one cannot stand in the law or has no answer.
pub(crate) fn columns(
    data: &DataSet,
    predictor: &dyn Predictor,
    base: &Hypothesis,
    x: &[f64],
    effects: &[Arc<dyn AnyEffect>],
    whitener: &Whitener,
) -> Result<DMatrix<f64>, String> {
    let mut together = base.clone();
    let mut firsts = vec![];
    for effect in effects {
        firsts.push(together.len() - base.len());
        together = together
            .with(Arc::clone(effect))
            .map_err(|e| e.to_string())?;
    }
    let mut at = x.to_vec();
    at.resize(together.len(), 0.0);
    let all = evaluate_from(data, predictor, &together, &at, base.len(), &Memory::none())
        .map_err(|e| e.to_string())?;
    Ok(whitener.apply(&all.jacobian.select_columns(&firsts)))
}
