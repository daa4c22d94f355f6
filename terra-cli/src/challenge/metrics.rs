//! The figures of a set of marked cases.

use super::marks::Marked;
use super::shares::Kind;
use super::statistics::{Metric, area, calibration_error, mean, median};

/// Name and figure, in the order of reports.
pub(crate) type Metrics = Vec<(&'static str, Metric)>;

/// Kinds of cases in which something is missing.
const EFFECTS: [Kind; 4] = [
    Kind::Single,
    Kind::Pair,
    Kind::OffLibrary,
    Kind::FormVariant,
];

/// Held-out closing as claimed and as it truly was.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closing {
    pub(crate) claimed: f64,
    pub(crate) lo: f64,
    pub(crate) hi: f64,
    pub(crate) truth: f64,
}

/// All figures; those of the closing are null with this reason when there is none.
pub(crate) fn metrics(cases: &[Marked], closings: Result<&[Closing], &str>) -> Metrics {
    let of = |kinds: &[Kind]| -> Vec<&Marked> {
        cases.iter().filter(|c| kinds.contains(&c.kind)).collect()
    };
    let rate = |kinds: &[Kind], what: &str, hit: fn(&Marked) -> bool| {
        let hits: Vec<bool> = of(kinds).into_iter().map(hit).collect();
        Metric::rate(&hits, what)
    };
    let claims: Vec<(f64, bool)> = cases.iter().filter_map(Marked::confidence).collect();
    let sizes: Vec<f64> = cases
        .iter()
        .filter_map(|c| c.verdict.as_ref())
        .map(|v| v.set.len() as f64)
        .collect();
    let unknown: Vec<(f64, bool)> = cases
        .iter()
        .map(|c| (c.unknown(), c.kind == Kind::OffLibrary))
        .collect();
    let mut out: Metrics = vec![
        (
            "top1",
            rate(&[Kind::Single], "single cases", |c| c.in_first(1)),
        ),
        (
            "top3",
            rate(&[Kind::Single], "single cases", |c| c.in_first(3)),
        ),
        (
            "top1_group",
            rate(&[Kind::Single], "single cases", Marked::first_in_group),
        ),
        ("top1_answer", rate(&Kind::ALL, "cases", Marked::answered)),
        (
            "top1_form_variant",
            rate(&[Kind::FormVariant], "form-variant cases", |c| {
                c.in_first(1)
            }),
        ),
        (
            "top3_form_variant",
            rate(&[Kind::FormVariant], "form-variant cases", |c| {
                c.in_first(3)
            }),
        ),
        (
            "pair_first",
            rate(&[Kind::Pair], "pair cases", Marked::first_in_truth),
        ),
        (
            "pair_both_in_three",
            rate(&[Kind::Pair], "pair cases", Marked::all_in_three),
        ),
        (
            "false_alarm",
            rate(&[Kind::None], "none cases", Marked::alarmed),
        ),
        (
            "power",
            rate(&EFFECTS, "cases with an effect", Marked::alarmed),
        ),
        (
            "false_notice",
            rate(&[Kind::None], "none cases", Marked::noticed),
        ),
        (
            "noticed",
            rate(&EFFECTS, "cases with an effect", Marked::noticed),
        ),
        (
            "ece",
            Metric::resampled(&claims, "probabilities", calibration_error),
        ),
        ("set_coverage", rate(&Kind::ALL, "cases", Marked::covered)),
        ("set_size", Metric::resampled(&sizes, "verdicts", mean)),
        (
            "unknown_auroc",
            Metric::resampled(&unknown, "off-library cases beside others", area),
        ),
        (
            "wrong_name_off_library",
            rate(&[Kind::OffLibrary], "off-library cases", |c| {
                c.verdict.as_ref().is_none_or(|v| v.verdict == "named")
            }),
        ),
    ];
    match closings {
        Err(reason) => {
            for name in ["closed_error", "closed_coverage"] {
                out.push((name, Metric::missing(reason)));
            }
        }
        Ok(closings) => {
            let errors: Vec<f64> = closings
                .iter()
                .map(|c| (c.claimed - c.truth).abs())
                .collect();
            let inside: Vec<bool> = closings
                .iter()
                .map(|c| (c.lo..=c.hi).contains(&c.truth))
                .collect();
            let what = "verdicts with a held-out closing that the truth shares";
            out.push(("closed_error", Metric::resampled(&errors, what, median)));
            out.push(("closed_coverage", Metric::rate(&inside, what)));
        }
    }
    out
}
