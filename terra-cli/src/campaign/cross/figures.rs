//! What the answers are worth, beside what is asked of them.

use serde::{Deserialize, Serialize};
use terra_gap::Evidence;

use super::Truth;
use crate::campaign::targets::Target;
use crate::challenge::Metric;

/// Probability from which a wrong name is a sure one.
const SURE: f64 = 0.9;

/// What a diagnosis said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Answer {
    pub(crate) verdict: String,
    /// The set and, where the form is unknown, the nearest: all names given.
    pub(crate) names: Vec<String>,
    /// Name and probability of the most probable answers but unknown.
    pub(crate) ranked: Vec<(String, f64)>,
    pub(crate) probability_unknown: f64,
    /// Why there is no answer: the diagnosis ended with this error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) refused: Option<String>,
}

impl Answer {
    /// None, for this reason.
    pub(crate) fn refused(why: String) -> Self {
        Answer {
            verdict: "refused".to_owned(),
            names: vec![],
            ranked: vec![],
            probability_unknown: 0.0,
            refused: Some(why),
        }
    }

    fn first(&self) -> Option<&(String, f64)> {
        self.ranked.first()
    }

    /// What comes first of the causes, if anything is missing at all: `top-1` of sealed cases.
    fn first_cause(&self) -> Option<&str> {
        let mut causes = self.ranked.iter().filter(|r| r.0 != "none");
        causes.next().map(|r| r.0.as_str())
    }

    /// The one name that it gives.
    fn single(&self) -> Option<&str> {
        (self.verdict == "named").then(|| self.first().map(|f| f.0.as_str()))?
    }
}

/// One case with its answers.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Marked {
    pub(crate) truth: Truth,
    pub(crate) name: String,
    pub(crate) ground: String,
    pub(crate) nominal: String,
    pub(crate) form: Option<String>,
    pub(crate) magnitude: Vec<f64>,
    /// By another structure, with the outside simulator's log.
    pub(crate) with_baseline: Answer,
    /// What it weighed, before calibration.
    #[serde(default)]
    pub(crate) evidence: Evidence,
    /// By another structure, without.
    pub(crate) without: Answer,
    /// By the ground's own structure, with that log.
    pub(crate) shared_law: Answer,
}

/// The table: with a baseline, beside the same by the ground's own law, then without a baseline.
pub(crate) fn figures(cases: &[Marked]) -> Vec<Target> {
    let with: fn(&Marked) -> &Answer = |c| &c.with_baseline;
    let shared: fn(&Marked) -> &Answer = |c| &c.shared_law;
    let mut rows = vec![];
    for (what, of, asked) in [
        ("baseline", with, true),
        ("baseline, own law", shared, false),
    ] {
        let mut row = |figure: &str, m: Metric, must: &'static str, ambitious: &'static str| {
            rows.push(target(
                format!("{what}: {figure}"),
                &m,
                if asked { must } else { "-" },
                if asked { ambitious } else { "-" },
            ));
        };
        let right = |c: &Marked| of(c).names.contains(&c.name);
        row("truth among the names", rate(cases, right), ">= .80", "-");
        // A diagnosis that ended with an error gave no names, which is no short answer.
        let ended = cases.iter().filter(|c| of(c).refused.is_none());
        let sizes: Vec<f64> = ended.map(|c| of(c).names.len() as f64).collect();
        row("names given, mean", mean(&sizes), "<= 3", "-");
        let wrong = |c: &Marked| of(c).single().is_some_and(|name| name != c.name);
        row(
            "one name, and a wrong one",
            rate(cases, wrong),
            "<= .06",
            "-",
        );
        let nulls = kind(cases, &[Truth::None]);
        let clean = |c: &Marked| of(c).single().is_none() && right(c);
        row("nulls without a name", rate(&nulls, clean), ">= .87", "-");
        let first = |c: &Marked| of(c).first_cause() == Some(&c.name);
        let answered = |c: &Marked| of(c).first().is_some_and(|f| f.0 == c.name);
        let exact = kind(cases, &[Truth::Instrument, Truth::Soil]);
        let physical = kind(cases, &[Truth::Physical, Truth::OtherForm]);
        let other = kind(cases, &[Truth::OtherForm]);
        for (what, of, must, ambitious) in [
            ("instruments and soil", &exact, ">= .85", "-"),
            ("physical effects", &physical, ">= .33", ">= .67"),
            ("of them in a form not known", &other, "-", "-"),
        ] {
            row(&format!("{what}, top-1"), rate(of, first), must, ambitious);
            row(
                &format!("{what}, before none too"),
                rate(of, answered),
                "-",
                "-",
            );
        }
    }
    let sure = |c: &Marked| {
        let first = c.without.first();
        first.is_some_and(|(name, p)| {
            *p > SURE && *name != c.name && name != "none" && !name.starts_with("structure:")
        })
    };
    rows.push(target(
        "no baseline: a wrong effect at P > .9".to_owned(),
        &rate(cases, sure),
        "<= .11",
        "-",
    ));
    let structure = |c: &Marked| {
        let right = format!("structure:{}", c.ground);
        c.without.first().is_some_and(|f| f.0 == right)
    };
    rows.push(target(
        "no baseline: the ground's structure first".to_owned(),
        &rate(cases, structure),
        "-",
        "-",
    ));
    let refused = |c: &Marked| {
        let mut all = [&c.with_baseline, &c.without, &c.shared_law].into_iter();
        all.any(|a| a.refused.is_some())
    };
    rows.push(target(
        "a diagnosis ends with an error".to_owned(),
        &rate(cases, refused),
        "<= 0",
        "-",
    ));
    rows
}

fn kind(cases: &[Marked], kinds: &[Truth]) -> Vec<Marked> {
    let of = |c: &&Marked| kinds.contains(&c.truth);
    cases.iter().filter(of).cloned().collect()
}

fn rate(cases: &[Marked], hit: impl Fn(&Marked) -> bool) -> Metric {
    let hits: Vec<bool> = cases.iter().map(hit).collect();
    Metric::rate(&hits, "such cases")
}

fn mean(values: &[f64]) -> Metric {
    Metric::resampled(values, "cases", |v| {
        (!v.is_empty()).then(|| v.iter().sum::<f64>() / v.len() as f64)
    })
}

fn target(figure: String, m: &Metric, must: &'static str, ambitious: &'static str) -> Target {
    Target {
        figure,
        n: m.n,
        value: m.value,
        lo: m.lo,
        hi: m.hi,
        prototype: "-",
        must,
        ambitious,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn says(verdict: &str, ranked: &[(&str, f64)]) -> Answer {
        Answer {
            verdict: verdict.to_owned(),
            names: ranked.iter().map(|r| r.0.to_owned()).collect(),
            ranked: ranked.iter().map(|r| (r.0.to_owned(), r.1)).collect(),
            probability_unknown: 0.0,
            refused: None,
        }
    }

    /// By hand: of four cases one null is clean, one instrument is the first cause but behind `none`, one effect is a
    /// wrong single name and its truth is not given, one other form is second of two. A fifth, a null that ends with an error, is
    /// no clean null, and its names are not counted.
    #[test]
    fn figures_count_what_they_say() {
        let case = |truth, name: &str, answer: Answer| Marked {
            truth,
            name: name.to_owned(),
            ground: "wong-reece".to_owned(),
            nominal: "scm-column".to_owned(),
            form: None,
            magnitude: vec![],
            with_baseline: answer.clone(),
            evidence: Evidence::default(),
            without: answer.clone(),
            shared_law: answer,
        };
        let cases = [
            case(Truth::None, "none", says("none", &[("none", 0.8)])),
            case(
                Truth::Instrument,
                "drawbar-gain",
                says("none", &[("none", 0.6), ("drawbar-gain", 0.35)]),
            ),
            case(
                Truth::Physical,
                "grousers",
                says("named", &[("bulldozing", 0.95)]),
            ),
            case(
                Truth::OtherForm,
                "bulldozing",
                says("ambiguous", &[("grousers", 0.6), ("bulldozing", 0.3)]),
            ),
            case(
                Truth::None,
                "none",
                Answer::refused("no end of a fit".to_owned()),
            ),
        ];
        let rows = figures(&cases);
        let value = |figure: &str| {
            let row = rows.iter().find(|r| r.figure == figure).unwrap();
            (row.value.unwrap(), row.n)
        };
        assert_eq!(value("baseline: truth among the names"), (0.6, 5));
        assert_eq!(value("baseline: names given, mean"), (1.5, 4));
        assert_eq!(value("baseline: one name, and a wrong one"), (0.2, 5));
        assert_eq!(value("baseline: nulls without a name"), (0.5, 2));
        assert_eq!(value("baseline: instruments and soil, top-1"), (1.0, 1));
        let before_none = "baseline: instruments and soil, before none too";
        assert_eq!(value(before_none), (0.0, 1));
        assert_eq!(value("baseline: physical effects, top-1"), (0.0, 2));
        assert_eq!(value("no baseline: a wrong effect at P > .9"), (0.2, 5));
        assert_eq!(value("a diagnosis ends with an error"), (0.2, 5));
    }
}
