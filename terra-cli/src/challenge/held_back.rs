//! Leave one effect out: the single cases diagnosed with a library that lacks their cause.

use std::path::Path;

use super::answer::Verdict;
use super::key::KeyFile;
use super::statistics::{Metric, area};
use crate::error::CliError;

/// What a diagnosis says where the truth is no name it knows.
#[derive(Clone, Debug)]
pub struct HeldBack {
    /// Area under the curve of P(unknown): cases without their cause in the library against the same cases with it, and
    /// against those without any cause.
    pub unknown: Metric,
    /// How often one name is given that the whole library does not hold for a look-alike of the truth.
    pub wrong_name: Metric,
}

/// Compares the verdicts of the whole library with those without the truth.
///
/// # Errors
/// A file that is no verdict.
pub fn held_back(key: &KeyFile, whole: &Path, without: &Path) -> Result<HeldBack, CliError> {
    let (mut scored, mut wrong) = (vec![], vec![]);
    for case in &key.cases {
        let sealed = case.read()?;
        let full = Verdict::open(whole, &case.case)?;
        match sealed.kind.as_str() {
            "none" => scored.extend(full.map(|v| (v.probability_unknown, false))),
            "single" => {
                let alike: Vec<String> = full
                    .iter()
                    .flat_map(|v| &v.causes)
                    .filter(|c| c.effect == sealed.truth())
                    .flat_map(|c| c.indistinguishable_from.clone())
                    .collect();
                scored.extend(full.map(|v| (v.probability_unknown, false)));
                if let Some(v) = Verdict::open(without, &case.case)? {
                    scored.push((v.probability_unknown, true));
                    let outside = v.causes.first().is_some_and(|c| !alike.contains(&c.effect));
                    wrong.push(v.verdict == "named" && outside);
                }
            }
            _ => {}
        }
    }
    Ok(HeldBack {
        unknown: Metric::resampled(
            &scored,
            "cases with their cause taken out beside others",
            area,
        ),
        wrong_name: Metric::rate(&wrong, "cases with their cause taken out"),
    })
}
