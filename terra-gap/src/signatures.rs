//! The signature of every candidate at a fit: its exact column, screened; a secant where an effect has no slope at zero.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra_model::{AnyEffect, Hook, LaneDual};

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::fit::{Fit, evaluate, evaluate_from, residual};
use crate::hypothesis::Hypothesis;
use crate::memory::{Memory, Remembered};
use crate::noise::Whitener;
use crate::predictor::Predictor;
use crate::screen::Tangent;
use crate::setup::Screened;

pub(crate) type Asked = Vec<Arc<dyn AnyEffect>>;

/// A fit with residual and slopes by the law itself, whitened by this: as it is, where it ended with these.
///
/// # Errors
/// Where the law has no answer there.
pub(crate) fn by_the_law(
    data: &DataSet,
    predictor: &dyn Predictor,
    hypothesis: &Hypothesis,
    fit: &Fit,
    whitener: &Whitener,
) -> Result<Fit, GapError> {
    if fit.exact && fit.is_whitened_by(whitener) {
        return Ok(fit.clone());
    }
    let here = evaluate(data, predictor, hypothesis, fit.x.as_slice(), &fit.near)?;
    Ok(Fit {
        residual: whitener.apply_vector(&here.residual),
        jacobian: whitener.apply(&here.jacobian).into(),
        exact: true,
        tangent: false,
        log_det: whitener.log_det,
        ..fit.clone()
    })
}

/// Screens every candidate at a fit by the law itself, whitened by this; effects without a trace are set aside with that reason.
pub(crate) fn screen_all(
    data: &DataSet,
    predictor: &dyn Predictor,
    base: &Hypothesis,
    here: &Fit,
    effects: &[Arc<dyn AnyEffect>],
    whitener: &Whitener,
    not_asked: &mut Vec<(String, String)>,
) -> (Vec<Screened>, Asked) {
    let tangent = Tangent::of(here);
    let (mut screen, mut asked) = (vec![], vec![]);
    let found = columns(data, predictor, base, &Place::of(here), effects, whitener);
    for (effect, column) in effects.iter().zip(found) {
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
    (screen, asked)
}

/// Where signatures are taken: parameters, what is known of the contacts there, and the whitened residual.
pub(crate) struct Place<'a> {
    pub x: &'a [f64],
    pub near: &'a Remembered,
    pub residual: &'a DVector<f64>,
}

impl<'a> Place<'a> {
    /// Where a fit ended.
    pub(crate) fn of(fit: &'a Fit) -> Self {
        Place {
            x: fit.x.as_slice(),
            near: &fit.near,
            residual: &fit.residual,
        }
    }
}

/// Whitened -dr/ds of the first magnitude of each effect; the reason where one cannot stand in the law or has no answer.
///
/// Effects stand in one law at magnitude zero, where each leaves the others alone, so one exact Jacobian holds the signatures of
/// several. One without a slope at zero has the secant from there to one prior sd.
pub(crate) fn columns(
    data: &DataSet,
    predictor: &dyn Predictor,
    base: &Hypothesis,
    here: &Place<'_>,
    effects: &[Arc<dyn AnyEffect>],
    whitener: &Whitener,
) -> Vec<Result<DVector<f64>, String>> {
    // All of them ask for the same contacts.
    let memory = Memory::after(here.near, predictor.contacts());
    let x = here.x;
    let of = |pack: &[usize]| -> Result<DMatrix<f64>, String> {
        let mut together = base.clone();
        let mut firsts = vec![];
        for &k in pack {
            firsts.push(together.len() - base.len());
            together = together
                .with(Arc::clone(&effects[k]))
                .map_err(|e| e.to_string())?;
        }
        let mut at = x.to_vec();
        at.resize(together.len(), 0.0);
        let all = evaluate_from(data, predictor, &together, &at, base.len(), &memory)
            .map_err(|e| e.to_string())?;
        Ok(whitener.apply(&all.jacobian.select_columns(&firsts)))
    };
    let secant = |effect: &Arc<dyn AnyEffect>| -> Result<DVector<f64>, String> {
        let with = base.with(Arc::clone(effect)).map_err(|e| e.to_string())?;
        let mut at = x.to_vec();
        at.resize(with.len(), 0.0);
        at[base.len()] = 1.0;
        let there = residual(data, predictor, &with, &at).map_err(|e| e.to_string())?;
        Ok(here.residual - whitener.apply_vector(&there))
    };
    let (flat, sloped): (Vec<usize>, Vec<usize>) =
        (0..effects.len()).partition(|&k| effects[k].is_flat());
    let mut found: Vec<(usize, Result<DVector<f64>, String>)> =
        flat.iter().map(|&k| (k, secant(&effects[k]))).collect();
    for pack in packs(effects, &sloped) {
        // One effect without an answer or a slope here spoils all: then each is asked by itself.
        let finite = |all: &DMatrix<f64>| all.iter().all(|v| v.is_finite());
        let together = of(&pack).ok().filter(finite);
        for (column, &k) in pack.iter().enumerate() {
            let own = match &together {
                Some(all) => Ok(all.column(column).into_owned()),
                None => of(&[k]).map(|one| one.column(0).into_owned()),
            };
            found.push((k, own));
        }
    }
    found.sort_by_key(|(k, _)| *k);
    found.into_iter().map(|(_, own)| own).collect()
}

/// Rows of these effects, by those that stand in one law: no more than one pass carries derivatives for, no two where there is
/// room for one, and those under which wheels slide sideways, whose integrals cost many times as much, by themselves.
fn packs(effects: &[Arc<dyn AnyEffect>], among: &[usize]) -> Vec<Vec<usize>> {
    let needs = |k: usize| effects[k].needs();
    let (sideways, others): (Vec<usize>, Vec<usize>) = among
        .iter()
        .partition(|&&k| needs(k).contains(&Hook::LateralSlip));
    let magnitudes = |pack: &[usize]| -> usize {
        let each = pack.iter().map(|&k| effects[k].params().len());
        each.sum()
    };
    let mut out: Vec<Vec<usize>> = vec![];
    for kind in [others, sideways] {
        let from = out.len();
        for k in kind {
            let taken = |&j: &usize| {
                let mut places = needs(j).iter();
                places.any(|h| h.holds_one() && needs(k).contains(h))
            };
            let room = LaneDual::SLOPES.saturating_sub(effects[k].params().len());
            let mut open = out[from..].iter_mut();
            match open.find(|pack| magnitudes(pack) <= room && !pack.iter().any(taken)) {
                Some(pack) => pack.push(k),
                None => out.push(vec![k]),
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use terra_model::Registry;

    use super::*;

    /// The whole library with its forms, each effect once and in one pack of ten magnitudes at most; none beside one that lets
    /// wheels slide, and of layers below the surface one in a pack: a law has room for one.
    #[test]
    fn a_pack_fits_one_pass_and_sliding_wheels_stand_apart() {
        let registry = Registry::builtin().with_forms();
        let effects: Asked = registry.effects().to_vec();
        let everyone: Vec<usize> = (0..effects.len()).collect();
        let packs = packs(&effects, &everyone);
        let mut all: Vec<usize> = packs.concat();
        all.sort_unstable();
        assert_eq!(all, everyone);
        let slides = |k: &usize| effects[*k].needs().contains(&Hook::LateralSlip);
        for pack in &packs {
            let magnitudes: usize = pack.iter().map(|&k| effects[k].params().len()).sum();
            assert!(magnitudes <= LaneDual::SLOPES, "{magnitudes}");
            assert!(pack.iter().all(slides) || !pack.iter().any(slides));
            let layers = pack
                .iter()
                .filter(|&&k| effects[k].needs().contains(&Hook::Layer));
            assert!(layers.count() <= 1);
            let law = registry.law("wong-reece").unwrap();
            law.with_effects(pack.iter().map(|&k| Arc::clone(&effects[k])))
                .unwrap();
        }
        assert!(
            packs.len() <= 1 + effects.len().div_ceil(8),
            "{}",
            packs.len()
        );
    }
}
