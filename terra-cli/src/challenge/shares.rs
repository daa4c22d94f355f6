//! What kinds of cases a challenge holds, and in which shares.

use std::fmt;

use crate::error::CliError;

/// What is withheld in a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Nothing but noise and another soil.
    None,
    /// One effect that a diagnosis knows.
    Single,
    /// Two of them.
    Pair,
    /// Something no diagnosis knows.
    OffLibrary,
    /// A known effect by another formula.
    FormVariant,
}

impl Kind {
    /// All of them, in the order of reports.
    pub const ALL: [Kind; 5] = [
        Kind::None,
        Kind::Single,
        Kind::Pair,
        Kind::OffLibrary,
        Kind::FormVariant,
    ];

    /// The name in a key file.
    pub fn name(self) -> &'static str {
        match self {
            Kind::None => "none",
            Kind::Single => "single",
            Kind::Pair => "pair",
            Kind::OffLibrary => "off-library",
            Kind::FormVariant => "form-variant",
        }
    }

    /// The kind of that name.
    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|k| k.name() == name)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The shares that are drawn when none are asked for; a kind with nothing to draw from is then left out.
const DEFAULT: [(Kind, f64); 5] = [
    (Kind::None, 0.2),
    (Kind::Single, 0.5),
    (Kind::Pair, 0.1),
    (Kind::OffLibrary, 0.1),
    (Kind::FormVariant, 0.1),
];

/// Kinds with their weights, each above 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    weights: Vec<(Kind, f64)>,
    asked: bool,
}

impl Default for Shares {
    fn default() -> Self {
        Shares {
            weights: DEFAULT.to_vec(),
            asked: false,
        }
    }
}

impl Shares {
    /// Reads `none=.2,single=.5`; a kind that is not named has no cases.
    ///
    /// # Errors
    /// An unknown kind, a weight that is no number from 0, nothing above 0.
    pub fn parse(text: &str) -> Result<Self, CliError> {
        let help = "--kinds none=.2,single=.5,pair=.1,off-library=.1,form-variant=.1";
        let mut weights: Vec<(Kind, f64)> = vec![];
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let bad = |why: String| CliError::usage(format!("--kinds: {why}"), help);
            let (name, weight) = part
                .split_once('=')
                .ok_or_else(|| bad(format!("'{part}' is not kind=share")))?;
            let name = name.trim();
            let kind = Kind::named(name).ok_or_else(|| {
                let known: Vec<&str> = Kind::ALL.iter().map(|k| k.name()).collect();
                bad(format!(
                    "unknown kind '{name}', expected one of {}",
                    known.join(", ")
                ))
            })?;
            let weight: f64 = weight
                .trim()
                .parse()
                .ok()
                .filter(|w: &f64| w.is_finite() && *w >= 0.0)
                .ok_or_else(|| {
                    bad(format!(
                        "the share of {name} is '{weight}', expected a number from 0"
                    ))
                })?;
            if weights.iter().any(|(k, _)| *k == kind) {
                return Err(bad(format!("{name} is given twice")));
            }
            weights.push((kind, weight));
        }
        weights.retain(|(_, w)| *w > 0.0);
        if weights.is_empty() {
            return Err(CliError::usage(
                "--kinds: no kind has a share above 0",
                help,
            ));
        }
        weights.sort_by_key(|(k, _)| *k);
        Ok(Shares {
            weights,
            asked: true,
        })
    }

    /// True when this kind has a share that a person asked for.
    pub(crate) fn asks_for(&self, kind: Kind) -> bool {
        self.asked && self.weights.iter().any(|(k, _)| *k == kind)
    }

    /// Without a kind.
    pub(crate) fn without(mut self, kind: Kind) -> Self {
        self.weights.retain(|(k, _)| *k != kind);
        self
    }

    /// True with this kind.
    pub(crate) fn holds(&self, kind: Kind) -> bool {
        self.weights.iter().any(|(k, _)| *k == kind)
    }

    /// `n` cases split by largest remainder: no split of whole cases is nearer to the shares.
    pub(crate) fn split(&self, n: usize) -> Vec<(Kind, usize)> {
        let total: f64 = self.weights.iter().map(|(_, w)| w).sum();
        let ideal: Vec<f64> = self
            .weights
            .iter()
            .map(|(_, w)| w / total * n as f64)
            .collect();
        let mut counts: Vec<usize> = ideal.iter().map(|x| x.floor() as usize).collect();
        let mut order: Vec<usize> = (0..ideal.len()).collect();
        order.sort_by(|a, b| {
            let rest = |k: usize| ideal[k] - ideal[k].floor();
            rest(*b).total_cmp(&rest(*a)).then(a.cmp(b))
        });
        let missing = n.saturating_sub(counts.iter().sum());
        for k in order.into_iter().cycle().take(missing) {
            counts[k] += 1;
        }
        self.weights.iter().map(|(k, _)| *k).zip(counts).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2:5:1:1:1 of 23: ideal 4.6, 11.5, 2.3, 2.3, 2.3; the two left go to the largest remainders.
    #[test]
    fn cases_are_split_by_largest_remainder() {
        let counts: Vec<usize> = Shares::default().split(23).iter().map(|c| c.1).collect();
        assert_eq!(counts, [5, 12, 2, 2, 2]);
        let only = Shares::parse("none=1").unwrap();
        assert_eq!(only.split(7), [(Kind::None, 7)]);
    }

    #[test]
    fn bad_shares_are_named() {
        for (text, word) in [
            ("nothing=1", "nothing"),
            ("none", "none"),
            ("none=-1", "-1"),
            ("none=1,none=2", "twice"),
            ("none=0", "above 0"),
            ("single=nan", "nan"),
        ] {
            let e = Shares::parse(text).unwrap_err();
            assert!(e.to_string().contains(word), "{text}: {e}");
            assert_eq!(e.exit_code(), 2);
        }
    }
}
