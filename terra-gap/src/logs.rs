//! Several logs of one vehicle or rig, diagnosed as one.

use std::borrow::Cow;

use serde::Serialize;
use terra_data::SoilSharing;
use terra_model::{ForceLaw, Law, Scalar};

use crate::error::GapError;

/// A log with the name that prefixes its groups.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a, L> {
    /// As in `day1.csv`: groups are then called `day1.csv/ramp`.
    pub name: &'a str,
    /// The log.
    pub log: &'a L,
}

/// Which logs were joined, and what they share.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct JoinedLogs {
    /// Names in alphabetical order, the order of everything that is listed by log.
    pub names: Vec<String>,
    /// `shared`: one soil for all; `own`: each log has its own, all with the same prior. Magnitudes of effects are shared.
    #[serde(serialize_with = "sharing")]
    pub soil: SoilSharing,
}

fn sharing<S: serde::Serializer>(soil: &SoilSharing, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(match soil {
        SoilSharing::Shared => "shared",
        SoilSharing::Own => "own",
    })
}

/// Logs in the order of their names, so that no order in which they are given can matter.
pub(crate) struct Logs<'a, L> {
    /// Prefix of its groups, and the log.
    each: Vec<(String, &'a L)>,
    joined: Option<JoinedLogs>,
}

impl<'a, L> Logs<'a, L> {
    /// A log by itself: its groups keep their names.
    pub(crate) fn one(log: &'a L) -> Self {
        Logs {
            each: vec![(String::new(), log)],
            joined: None,
        }
    }

    /// # Errors
    /// No log at all; two of one name.
    pub(crate) fn new(logs: &[Named<'a, L>], soil: SoilSharing) -> Result<Self, GapError> {
        if let [one] = logs {
            return Ok(Self::one(one.log));
        }
        if logs.is_empty() {
            return Err(GapError::Mismatch("no log was given".to_owned()));
        }
        let mut each: Vec<(String, &L)> = logs.iter().map(|l| (l.name.to_owned(), l.log)).collect();
        each.sort_by(|a, b| a.0.cmp(&b.0));
        if let Some(twice) = each.windows(2).find(|w| w[0].0 == w[1].0) {
            return Err(GapError::Mismatch(format!(
                "two logs are called '{}': groups of several logs are told apart by the log's name",
                twice[0].0
            )));
        }
        let names = each.iter().map(|(name, _)| name.clone()).collect();
        for (name, _) in &mut each {
            name.push('/');
        }
        Ok(Logs {
            each,
            joined: Some(JoinedLogs { names, soil }),
        })
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, &'a L)> + '_ {
        self.each
            .iter()
            .map(|(prefix, log)| (prefix.as_str(), *log))
    }

    /// The same logs in another shape, given in the order of [`iter`](Self::iter).
    pub(crate) fn replaced_by<'b, M>(&self, each: &'b [M]) -> Logs<'b, M> {
        let names = self.each.iter().map(|(prefix, _)| prefix.clone());
        Logs {
            each: names.zip(each).collect(),
            joined: self.joined.clone(),
        }
    }

    /// The same logs with a soil of their own each, where they share one.
    pub(crate) fn with_own_soils(&self) -> Option<Self> {
        let joined = self.joined.as_ref()?;
        (joined.soil == SoilSharing::Shared).then(|| Logs {
            each: self.each.clone(),
            joined: Some(JoinedLogs {
                soil: SoilSharing::Own,
                ..joined.clone()
            }),
        })
    }

    /// What is said of them; none of one log.
    pub(crate) fn joined(&self) -> Option<JoinedLogs> {
        self.joined.clone()
    }

    /// How many soils are free.
    pub(crate) fn soils(&self) -> usize {
        self.labels().len().max(1)
    }

    /// One name for each soil where every log has its own, else none.
    pub(crate) fn labels(&self) -> &[String] {
        match &self.joined {
            Some(j) if j.soil == SoilSharing::Own => &j.names,
            _ => &[],
        }
    }
}

/// The law's parameters for one log, out of a vector that holds the nominal law's parameters once for each soil and then the
/// magnitudes of the candidate effects.
pub(crate) fn of_log<'p, T: Scalar>(
    law: &Law,
    p: &'p [T],
    soils: usize,
    log: usize,
) -> Cow<'p, [T]> {
    if soils < 2 {
        return Cow::Borrowed(p);
    }
    // n = soils m + k and |law| = m + k.
    let m = p.len().saturating_sub(law.params().len()) / (soils - 1);
    let own = p.iter().skip(log * m).take(m);
    Cow::Owned(own.chain(p.iter().skip(soils * m)).copied().collect())
}
