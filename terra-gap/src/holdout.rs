//! How far the gap shrinks on data the fit never saw.
//!
//! # Equation
//! closed = Σ_g a_g / Σ_g b_g, a_g = SSE0_g - SSEk_g, b_g = SSE0_g - φ n_g: each group g is predicted by fits without it; SSE
//! whitened by the stated noise, of which this log holds φ a value. Interval: studentised over the G groups, each deviation
//! a_g - closed b_g divided by 1 - b_g/Σ b: often one manoeuvre holds most of the gap, and the ratio follows it so closely
//! that its own deviation tells nothing. Variance (G-1)/G Σ_g ((a_g - closed b_g)/(1 - b_g/Σ b))²/(Σ b)², which is the
//! jackknife's around the whole.
//!
//! # Source
//! MacKinnon, Nielsen & Webb 2023, "Cluster-robust inference: a guide to empirical practice", Journal of Econometrics 232
//! (CV3: few groups of unequal weight).

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};
use terra_model::order::ascending;

use crate::dataset::DataSet;
use crate::error::GapError;
use crate::fit::{Effort, Fit, fit_from, residual};
use crate::hypothesis::Hypothesis;
use crate::noise::NoiseModel;
use crate::parallel::for_each;
use crate::predictor::Predictor;
use crate::settings::LogKind;
use crate::unknown::along;

/// Slips that differ by less are repeats of one.
const ALIKE: f64 = 0.02;

/// What one group is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldOut {
    /// Trials of a rig.
    Trial,
    /// Segments of a drive.
    Segment,
    /// Conditions of a rig.
    Condition,
    /// Five ranges of slip; by motion alone, of how sharply the wheels turn.
    Slip,
}

impl HoldOut {
    /// Name as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            HoldOut::Trial => "trial",
            HoldOut::Segment => "segment",
            HoldOut::Condition => "condition",
            HoldOut::Slip => "slip",
        }
    }
}

/// A share with its 95 % interval.
#[derive(Clone, Copy, Debug, Serialize, PartialEq)]
pub struct Interval {
    /// Estimate.
    pub mean: f64,
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
}

impl Interval {
    /// False where it is wider than twice the whole: too little was left to be closed to say how much of it is.
    pub fn tells(&self) -> bool {
        self.hi - self.lo <= 2.0
    }
}

/// Result of holding out.
#[derive(Clone, Debug)]
pub struct HeldOut {
    /// How groups were made.
    pub by: HoldOut,
    /// Share of the explainable misfit that goes away; none when nothing was explainable.
    pub closed: Option<Interval>,
    /// The same per channel, without interval; none where the misfit there is no more than noise leaves by chance.
    pub closed_by_channel: Vec<(String, Option<f64>)>,
    /// Whitened misfit per value without the effect.
    pub chi2_before: f64,
    /// With it.
    pub chi2_after: f64,
    /// Number of groups predicted.
    pub groups: usize,
    /// Groups that a fit without them could not predict, with the reason.
    pub failed: Vec<String>,
}

impl HeldOut {
    /// Why no share of the gap that closes is given, where none is.
    pub fn why_open(&self) -> String {
        match (self.failed.first(), self.groups) {
            (Some(first), 0 | 1) => format!(
                "{} of {} held-out groups could not be predicted by fits to the others ({first})",
                self.failed.len(),
                self.failed.len() + self.groups
            ),
            (None, 0 | 1) => "a single group was held out".to_owned(),
            _ => "the re-fitted model already predicts the held-out data to the noise".to_owned(),
        }
    }
}

/// Groups of observation numbers.
pub(crate) fn groups(data: &DataSet, by: HoldOut) -> Vec<(String, Vec<usize>)> {
    let mut out: Vec<(String, Vec<usize>)> = vec![];
    if by == HoldOut::Slip {
        let mut order: Vec<(f64, usize)> = data
            .observations
            .iter()
            .enumerate()
            .map(|(i, o)| (along(o).unwrap_or(0.0), i))
            .collect();
        ascending(&mut order, |o| o.0);
        // Repeats of one slip stay together: a range that holds a repeat would see its own answer. A ramp's slips are no repeats.
        let mut distinct: Vec<Vec<(f64, usize)>> = vec![];
        for point in order {
            match distinct.last_mut() {
                Some(last) if last.first().is_some_and(|p| point.0 - p.0 < ALIKE) => {
                    last.push(point)
                }
                _ => distinct.push(vec![point]),
            }
        }
        let ranges = distinct.len().min(5);
        for r in 0..ranges {
            let part = &distinct[r * distinct.len() / ranges..(r + 1) * distinct.len() / ranges];
            let points: Vec<(f64, usize)> = part.iter().flatten().copied().collect();
            if let (Some(a), Some(b)) = (points.first(), points.last()) {
                out.push((
                    format!("slip {:.2} to {:.2}", a.0, b.0),
                    points.iter().map(|p| p.1).collect(),
                ));
            }
        }
        return out;
    }
    for (i, o) in data.observations.iter().enumerate() {
        let name = if by == HoldOut::Condition {
            &o.condition
        } else {
            &o.group
        };
        match out.iter_mut().find(|(n, _)| n == name) {
            Some((_, members)) => members.push(i),
            None => out.push((name.clone(), vec![i])),
        }
    }
    if by == HoldOut::Segment {
        out = together(out);
    }
    out
}

/// Most groups of a drive that are left out one by one: each costs two fits of all the others.
const FOLDS: usize = 24;

/// Manoeuvres that follow each other together, where there are many.
fn together(groups: Vec<(String, Vec<usize>)>) -> Vec<(String, Vec<usize>)> {
    let folds = groups.len().min(FOLDS);
    let fold = |f: usize| {
        let part = &groups[f * groups.len() / folds..(f + 1) * groups.len() / folds];
        let name = match part {
            [] => None,
            [one] => Some(one.0.clone()),
            [first, .., last] => Some(format!("{} to {}", first.0, last.0)),
        };
        let members = part.iter().flat_map(|(_, members)| members).copied();
        name.map(|name| (name, members.collect()))
    };
    (0..folds).filter_map(fold).collect()
}

/// Squares of one held-out group, by channel, before and after.
struct GroupSquares {
    before: Vec<f64>,
    after: Vec<f64>,
    count: Vec<f64>,
}

/// How far the noise of one log may lie from its stated size by chance, in sd of χ²/n.
const CHANCE: f64 = 3.0;

/// The noise of this very log per value, in units of the stated variance: what the accepted law leaves, (χ² + d)/n, where
/// chance can have made it so; 1 where the law leaves more, which is no noise. It is in both misfits that are held out, so less
/// of it stays in their ratio than if the stated noise were taken off: on 196 torque ramps the median error of the closing
/// fell from .052 to .040.
pub(crate) fn noise_floor(accepted: &Fit) -> f64 {
    let n = accepted.residual.len().max(1) as f64;
    let chance = CHANCE * (2.0 / n).sqrt();
    let left = (accepted.chi2() + accepted.x.len() as f64) / n;
    if left > 1.0 + chance {
        1.0
    } else {
        left.max(1.0 - chance).max(0.0)
    }
}

/// Predicts every group from fits of the others, with and without the effects. `floor`: noise per value, in units of the
/// stated variance.
///
/// # Errors
/// A covariance that is not positive definite.
pub(crate) fn hold_out(
    data: &DataSet,
    predictor: &dyn Predictor,
    noise: &NoiseModel,
    null: (&Hypothesis, &Fit),
    better: (&Hypothesis, &Fit),
    (kind, by): (LogKind, HoldOut),
    floor: f64,
) -> Result<HeldOut, GapError> {
    let groups = groups(data, by);
    // Where the noise is block diagonal, rows of a whitened Jacobian keep their meaning.
    let rows: Vec<usize> = data.stacked().map(|(i, _)| i).collect();
    let results: Vec<Result<Result<GroupSquares, String>, GapError>> =
        for_each(groups.len(), |k| {
            let (name, members) = &groups[k];
            let rest: Vec<usize> = (0..data.observations.len())
                .filter(|i| !members.contains(i))
                .collect();
            let (train, test) = (data.subset(&rest), data.subset(members));
            if train.is_empty() {
                return Ok(Err(format!("{name}: nothing else to fit")));
            }
            let train_whitener = noise.subset(&rest).whitener(&train)?;
            let test_whitener = noise.subset(members).whitener(&test)?;
            let squares = |(h, whole): (&Hypothesis, &Fit)| -> Result<Vec<f64>, GapError> {
                let kept: Vec<usize> = (0..rows.len())
                    .filter(|&k| !members.contains(&rows[k]))
                    .collect();
                // On a rig fits are cheap and far from linear: they are certified. A drive of one manoeuvre is held out by slip.
                let quick = kind != LogKind::Rig
                    && noise.is_separate()
                    && whole.jacobian.nrows() == rows.len();
                let effort = if quick {
                    Effort::Carried
                } else {
                    Effort::Certified
                };
                let known = quick.then(|| whole.known(whole.jacobian.clone()).of_rows(&kept));
                let starts = [whole.x.as_slice().to_vec()];
                let whitener = &train_whitener;
                let fitted = fit_from(&train, predictor, h, whitener, &starts, known, effort)?;
                let r = test_whitener.apply_vector(&residual(
                    &test,
                    predictor,
                    h,
                    fitted.x.as_slice(),
                )?);
                let mut by_channel = vec![0.0; data.channels.len()];
                for ((_, c), r) in test.stacked().zip(r.iter()) {
                    by_channel[c] += r * r;
                }
                Ok(by_channel)
            };
            let mut count = vec![0.0; data.channels.len()];
            for (_, c) in test.stacked() {
                count[c] += 1.0;
            }
            Ok(match (squares(null), squares(better)) {
                (Ok(before), Ok(after)) => Ok(GroupSquares {
                    before,
                    after,
                    count,
                }),
                (Err(e), _) | (_, Err(e)) => Err(format!("{name}: {e}")),
            })
        });
    let mut squares = vec![];
    let mut failed = vec![];
    for r in results {
        match r? {
            Ok(s) => squares.push(s),
            Err(reason) => failed.push(reason),
        }
    }
    let total = |f: fn(&GroupSquares) -> &Vec<f64>| squares.iter().flat_map(f).sum::<f64>();
    let (before, after, n) = (
        total(|s| &s.before),
        total(|s| &s.after),
        total(|s| &s.count),
    );
    let per_group: Vec<(f64, f64)> = squares
        .iter()
        .map(|s| {
            let (b, a, n): (f64, f64, f64) = (
                s.before.iter().sum(),
                s.after.iter().sum(),
                s.count.iter().sum(),
            );
            (b - a, b - floor * n)
        })
        .collect();
    let closed_by_channel = data
        .channels
        .iter()
        .enumerate()
        .map(|(c, info)| {
            let sum =
                |f: fn(&GroupSquares) -> &Vec<f64>| squares.iter().map(|s| f(s)[c]).sum::<f64>();
            let (b, a, n) = (sum(|s| &s.before), sum(|s| &s.after), sum(|s| &s.count));
            (info.name.clone(), share_closed(b, a, n, floor))
        })
        .collect();
    Ok(HeldOut {
        by,
        closed: (before > floor * n)
            .then(|| ratio_interval(&per_group))
            .flatten(),
        closed_by_channel,
        chi2_before: if n > 0.0 { before / n } else { 0.0 },
        chi2_after: if n > 0.0 { after / n } else { 0.0 },
        groups: squares.len(),
        failed,
    })
}

/// Standard deviations of chi2 by which a channel's misfit must exceed its noise for a share of it to mean something.
const BEYOND_CHANCE: f64 = 3.0;

/// Share of a channel's explainable misfit that goes away, given its squares before and after, its values and the floor of each.
fn share_closed(before: f64, after: f64, values: f64, floor: f64) -> Option<f64> {
    let gap = before - floor * values;
    (gap > BEYOND_CHANCE * floor * (2.0 * values).sqrt()).then(|| (before - after) / gap)
}

/// Σ numerators / Σ denominators with its studentised 95 % interval over groups; none where one group is the whole.
fn ratio_interval(groups: &[(f64, f64)]) -> Option<Interval> {
    let g = groups.len() as f64;
    let (a, b): (f64, f64) = groups
        .iter()
        .fold((0.0, 0.0), |s, x| (s.0 + x.0, s.1 + x.1));
    let mean = a / b;
    if groups.len() < 2 || !mean.is_finite() {
        return None;
    }
    let deviation = |(a_g, b_g): &(f64, f64)| (a_g - mean * b_g) / (1.0 - b_g / b);
    let squares: f64 = groups.iter().map(|x| deviation(x).powi(2)).sum();
    let se = (squares * (g - 1.0) / g).sqrt() / b.abs();
    let t = StudentsT::new(0.0, 1.0, g - 1.0).ok()?.inverse_cdf(0.975);
    (t * se).is_finite().then_some(Interval {
        mean,
        lo: mean - t * se,
        hi: mean + t * se,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{Factors, Observation};

    /// Without a share the reason is the one that holds.
    #[test]
    fn an_open_share_says_why() {
        let held = |groups: usize, failed: &[&str]| HeldOut {
            by: HoldOut::Segment,
            closed: None,
            closed_by_channel: vec![],
            chi2_before: 1.0,
            chi2_after: 1.0,
            groups,
            failed: failed.iter().map(|f| (*f).to_owned()).collect(),
        };
        let failed = held(1, &["up: no equilibrium", "down: no equilibrium"]).why_open();
        assert!(failed.starts_with("2 of 3 held-out groups") && failed.contains("(up: no"));
        assert!(held(1, &[]).why_open().contains("single group"));
        assert!(held(9, &["up: no"]).why_open().contains("to the noise"));
    }

    /// Of 200 values chi2 scatters by 20: 30 above the noise is chance, and one of which 100 of 100 go is closed.
    #[test]
    fn a_channel_without_a_gap_has_no_share() {
        assert_eq!(share_closed(230.0, 200.0, 200.0, 1.0), None);
        assert_eq!(share_closed(300.0, 200.0, 200.0, 1.0), Some(1.0));
        assert_eq!(share_closed(300.0, 250.0, 200.0, 1.0), Some(0.5));
        assert_eq!(share_closed(0.0, 0.0, 0.0, 1.0), None);
    }

    /// A ramp of 400 slips has five ranges, as has a list of a few slips, whose repeats stay together.
    #[test]
    fn a_ramp_of_slips_has_five_ranges() {
        let ranges = |slips: Vec<f64>| {
            let at = |slip: f64| Observation {
                factors: Factors::from([("slip", slip)]),
                ..Observation::default()
            };
            let data = DataSet {
                observations: slips.into_iter().map(at).collect(),
                ..DataSet::default()
            };
            let all = groups(&data, HoldOut::Slip).into_iter();
            all.map(|(_, members)| members.len()).collect::<Vec<_>>()
        };
        let ramp = ranges((0..400).map(|k| 0.02 + 0.001_875 * f64::from(k)).collect());
        assert_eq!(ramp.len(), 5, "{ramp:?}");
        assert!(ramp.iter().all(|n| (60..=100).contains(n)), "{ramp:?}");
        let around = [0.1, 0.2, 0.3, 0.4, 0.5].map(|s| [s - 0.004, s, s + 0.004]);
        assert_eq!(ranges(around.concat()), [3; 5]);
    }

    /// Two groups, by hand: ratio .75, deviations ±.5 around it, each twice as large without its own half of the weight;
    /// se = sqrt(2/2)/4, t_1 = 12.706.
    #[test]
    fn ratio_interval_by_hand() {
        let i = ratio_interval(&[(2.0, 2.0), (1.0, 2.0)]).unwrap();
        assert!((i.mean - 0.75).abs() < 1e-12);
        assert!((i.hi - 0.75 - 0.25 * 12.7062).abs() < 1e-3);
    }

    /// (G-1)/G Σ (closed without g - closed)², by leaving groups out.
    #[test]
    fn the_variance_is_the_jackknife_s() {
        let groups = [(90.0, 100.0), (3.0, 2.0), (-1.0, 1.0), (4.0, 5.0)];
        let ratio = |left_out: usize| {
            let rest = groups.iter().enumerate().filter(|(k, _)| *k != left_out);
            let (a, b) = rest.fold((0.0, 0.0), |s, (_, x)| (s.0 + x.0, s.1 + x.1));
            a / b
        };
        let i = ratio_interval(&groups).unwrap();
        let spread: f64 = (0..4).map(|k| (ratio(k) - i.mean).powi(2)).sum();
        let se = (spread * 0.75).sqrt();
        assert!(((i.hi - i.lo) / 2.0 / se - 3.18245).abs() < 1e-4);
    }

    /// 200 values and two unknowns: by chance χ²/n scatters by .1. Noise that a right law leaves a little smaller or larger
    /// is the log's own; a misfit of 4 is no noise.
    #[test]
    fn the_noise_of_a_log_is_its_own_within_chance() {
        let fit = |chi2: f64| Fit {
            x: nalgebra::DVector::zeros(2),
            residual: nalgebra::DVector::from_element(200, (chi2 / 200.0_f64).sqrt()),
            jacobian: nalgebra::DMatrix::zeros(200, 2).into(),
            exact: true,
            tangent: false,
            cost: chi2,
            converged: true,
            given_up: false,
            log_det: 0.0,
            at_bound: vec![false; 2],
            near: crate::memory::Remembered::default(),
        };
        let cases = [
            (98.0, 0.7),
            (178.0, 0.9),
            (198.0, 1.0),
            (218.0, 1.1),
            (800.0, 1.0),
        ];
        for (chi2, floor) in cases {
            assert!((noise_floor(&fit(chi2)) - floor).abs() < 1e-9, "{chi2}");
        }
    }

    /// 50 manoeuvres are left out in 24 groups of two or three neighbours, each once; 9 one by one.
    #[test]
    fn many_manoeuvres_are_left_out_together() {
        let one = |k: usize| (format!("m{k}"), vec![2 * k, 2 * k + 1]);
        let folds = together((0..50).map(one).collect());
        assert_eq!(folds.len(), 24);
        let members: Vec<usize> = folds.iter().flat_map(|f| f.1.clone()).collect();
        assert_eq!(members, (0..100).collect::<Vec<usize>>());
        assert!(folds.iter().all(|f| (4..=6).contains(&f.1.len())));
        assert_eq!(folds[0].0, "m0 to m1");
        let few: Vec<_> = (0..9).map(one).collect();
        assert_eq!(together(few.clone()), few);
    }

    /// A gap that one group holds alone has no spread to be told from.
    #[test]
    fn one_group_that_is_the_whole_gives_no_interval() {
        assert!(ratio_interval(&[(90.0, 100.0), (1.0, 0.0)]).is_none());
    }
}
