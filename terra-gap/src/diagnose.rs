//! The diagnosis from end to end: gate, null re-fit, screen, confirm, combine, unknown, hold out, decide.

use std::sync::Arc;

use crate::calibrate::calibrate;
use crate::calibration::{Calibration, Evidence};
use crate::candidates::{Candidates, gate};
use crate::cause::{Answers, Cause};
use crate::contrast::Baseline;
use crate::dataset::DataSet;
use crate::decide::decide;
use crate::error::GapError;
use crate::fit::{Fit, residual_at_end};
use crate::form_error::is_form_error;
use crate::holdout::{HeldOut, HoldOut, hold_out, noise_floor};
use crate::hypothesis::Hypothesis;
use crate::locate::{Place, places};
use crate::logs::JoinedLogs;
use crate::next::{Experiment, suggest};
use crate::predictor::Predictor;
use crate::rivals::weigh_rivals;
use crate::roomier::unknown_leads;
use crate::settings::{LogKind, Settings};
use crate::setup::{Screened, Setup};
use crate::shared::carry;
use crate::uneven::{Doubtful, Uneven};

/// Misfit per value at each step of the way.
#[derive(Clone, Debug, Default)]
pub struct Waterfall {
    /// Nominal simulator as given; none where it has no answer.
    pub as_given: Option<f64>,
    /// After the soil was re-fitted.
    pub refitted: Option<f64>,
    /// With the accepted effects.
    pub after: Option<f64>,
}

/// All that a diagnosis found.
pub struct Diagnosis {
    /// The data it used.
    pub data: DataSet,
    /// Kind of log.
    pub kind: LogKind,
    /// Name of the nominal law.
    pub model: String,
    /// Nominal law re-fitted, noise only.
    pub null: Option<(Hypothesis, Fit)>,
    /// Accepted law, noise only.
    pub accepted: Option<(Hypothesis, Fit)>,
    /// Rivals in order of probability.
    pub causes: Vec<Cause>,
    /// Probability that nothing is missing.
    pub probability_none: f64,
    /// Probability that something unknown is.
    pub probability_unknown: f64,
    /// Smallest set of answers with 90 % probability.
    pub set: Vec<String>,
    /// none, named, ambiguous, unknown, unidentifiable.
    pub verdict: &'static str,
    /// Why, where the verdict needs a reason.
    pub reason: Option<String>,
    /// The set that comes closest when no form fits well enough to be named.
    pub nearest: Vec<String>,
    /// Names of the accepted effects.
    pub accepted_names: Vec<String>,
    /// Screen of all candidates.
    pub screen: Vec<Screened>,
    /// Not asked, with the reason.
    pub not_asked: Vec<(String, String)>,
    /// Where the re-fitted nominal law differs from the data.
    pub places: Vec<Place>,
    /// What remains after the accepted effects.
    pub remainder: Vec<Place>,
    /// Misfit per value on the way.
    pub waterfall: Waterfall,
    /// Root mean square of the re-fitted residual per channel, in its unit.
    pub rms: Vec<(String, f64)>,
    /// Held-out shrinkage.
    pub held_out: Option<HeldOut>,
    /// Next experiments.
    pub next: Vec<Experiment>,
    /// Soil directions the data do not determine.
    pub undetermined: Vec<String>,
    /// What to look at before believing any of it.
    pub heed: Vec<String>,
    /// What turned evidence into probabilities.
    pub calibration: Option<Calibration>,
    /// All answers before calibration.
    pub evidence: Evidence,
    /// The outside simulator that it was compared with.
    pub baseline: Option<Baseline>,
    /// The logs and what they share, where there are several.
    pub logs: Option<JoinedLogs>,
    /// How uneven the ground is under single wheels, where what the re-fitted law leaves over shows it.
    pub(crate) uneven: Option<Arc<Uneven>>,
}

impl Diagnosis {
    /// Tells one more thing to heed.
    pub fn notice(&mut self, line: String) {
        self.data.notes.push(line.clone());
        self.heed.push(line);
    }

    pub(crate) fn unidentifiable(
        data: DataSet,
        setup: &Setup<'_>,
        candidates: Candidates,
        reason: String,
    ) -> Self {
        Diagnosis {
            data,
            kind: setup.kind,
            model: terra_model::ForceLaw::name(&setup.law),
            null: None,
            accepted: None,
            causes: vec![],
            probability_none: 0.0,
            probability_unknown: 0.0,
            set: vec![],
            verdict: "unidentifiable",
            reason: Some(reason),
            nearest: vec![],
            accepted_names: vec![],
            screen: vec![],
            not_asked: candidates.not_asked,
            places: vec![],
            remainder: vec![],
            waterfall: Waterfall::default(),
            rms: vec![],
            held_out: None,
            next: vec![],
            undetermined: vec![],
            heed: vec![],
            calibration: None,
            evidence: Evidence::default(),
            baseline: None,
            logs: None,
            uneven: None,
        }
    }
}

/// Share of the held-out gap that two causes must close to be named by themselves: among thirty effects some two imitate most
/// of what is in no library, but only where they were fitted. Of a rig one alone must too: of 42 rigs' logs of another generator and 64 sealed
/// ones (121314) with one name the right ones closed .57 at least, and what stood for a patch of softer soil .14.
const HALF: f64 = 0.5;
/// The same on a drive, whose manoeuvres differ enough to show it: of 1 040 sealed drives (seeds 509 and 262626) 71 of the 79 in
/// which two causes are named rightly close as much, and of 520 with their cause taken out of the library 8 of the 35 in which
/// two others are named.
const NEARLY_ALL: f64 = 0.95;
/// Share of the probability of two causes that close less which something unknown has: a choice, as with a free formula.
const STANDS_FOR_ONE: f64 = 0.4;

/// Misfit that a cause must take away for the data to speak for it. What speaks for one that takes less is that the soil may then
/// be nearer to the rover file's start. Of 250 sealed rigs' logs with one name (81001, 91001, and another generator's) eight took
/// less, and three of these were wrong; of 252 drives' (515151, and another generator's) five, and all were right: there it is
/// said, and no more.
const TAKES: f64 = 8.0;
/// Share of the probability of such a cause of a rig that nothing missing has, on another soil, and of one that gains no more than the
/// waves of uneven ground: a choice, as with two causes.
const ANOTHER_SOIL: f64 = 0.4;

/// Why nothing can be said where the nominal law's own fit says nothing.
const NO_NUMBERS: &str = "the re-fit of the nominal model ended where its evidence is no number: units, signs or sides in the log are likelier wrong than the ground (terra inspect LOG)";

/// Why one cause, and why two, are not the only answer on ground that is uneven under single wheels.
const WAVES: &str = "the ground is uneven under single wheels, and what speaks for the cause is no more than its waves may come to";
const ONE_WHEEL: &str = "the ground is uneven under single wheels, and one wheel that is not as the others looks like two causes there, one of an axle and one of a side";

/// Diagnoses a data set.
///
/// # Errors
/// An option or a configuration that makes no sense. What the data cannot tell is a verdict.
pub(crate) fn diagnose(
    mut data: DataSet,
    measured: &dyn Predictor,
    setup: &Setup<'_>,
    settings: &Settings,
) -> Result<Diagnosis, GapError> {
    if let Some(inherited) = &setup.inherited {
        carry(&mut data, measured, &inherited.hypothesis, &inherited.x);
    }
    let candidates = gate(
        setup.registry,
        &setup.law,
        &data,
        setup.rover,
        setup.kind,
        settings,
        setup.inherited.as_ref().map(|i| &i.ranges),
    )?;
    if settings.effects.as_ref().is_some_and(|e| !e.is_empty()) && candidates.effects.is_empty() {
        let why: Vec<String> = candidates
            .not_asked
            .iter()
            .map(|(name, why)| format!("{name} ({why})"))
            .collect();
        let reason = format!(
            "none of the effects that were asked for can show in this log: {}; leave --effects out to ask all that can",
            why.join(", ")
        );
        return Ok(Diagnosis::unidentifiable(data, setup, candidates, reason));
    }
    let found = weigh_rivals(&mut data, measured, setup, settings, &candidates)?;
    let (rivals, predictor) = match found {
        Ok(found) => found,
        Err(reason) => return Ok(Diagnosis::unidentifiable(data, setup, candidates, reason)),
    };
    if !rivals.null_weighed.log_evidence.is_finite() {
        return Ok(Diagnosis::unidentifiable(
            data,
            setup,
            candidates,
            NO_NUMBERS.to_owned(),
        ));
    }
    let predictor = &*predictor;
    let measured = rivals.measured.as_deref().unwrap_or(measured);
    let (calibration, not_calibrated) =
        calibrate(&data, predictor, setup, settings, &candidates, &rivals)?;
    let n = data.len() as f64;
    let (null, fitted) = (&rivals.null, &rivals.fitted);
    let answers = Answers::new(&rivals, settings, setup);
    let evidence = answers.evidence();
    let mut ranking = answers.rank(&calibration);
    let mut decision = decide(&ranking, &rivals.null_weighed, setup.kind, &calibration);

    let what = "rms and places of the gap";
    let raw_null = residual_at_end(&mut data, predictor, null, fitted.x.as_slice(), what)?;
    let rms = channel_rms(&data, raw_null.as_slice());
    let places_of_gap = places(&data, fitted, raw_null.as_slice());
    let (mut held, mut remainder, mut after, mut doubt) = (None, vec![], None, None);
    if let Some((h, f)) = &decision.accepted {
        let by = settings
            .hold_out
            .unwrap_or_else(|| default_hold_out(&data, setup.kind));
        let (noise, null) = (&rivals.noise, (null, fitted));
        let by = (setup.kind, by);
        let found = hold_out(&data, predictor, noise, null, (h, f), by, noise_floor(f))?;
        let asked = match setup.kind {
            LogKind::Drive => NEARLY_ALL,
            LogKind::Rig | LogKind::Kinematic => HALF,
        };
        let closed = found.closed.filter(|c| c.mean < asked);
        let nothing = ranking.set.iter().any(|answer| answer == "none")
            || rivals.null_weighed.plain.chi2() - f.chi2() < TAKES;
        doubt = closed.filter(|_| match h.effects().len() {
            0 => false,
            // Where nothing missing is an answer too, or will be, there may be no gap to close.
            1 => setup.kind == LogKind::Rig && !nothing,
            _ => true,
        });
        held = Some(found);
        let what = "places of what remains";
        let raw = residual_at_end(&mut data, predictor, h, f.x.as_slice(), what)?;
        remainder = places(&data, f, raw.as_slice());
        after = Some(f.chi2() / n);
    }
    if let Some(closed) = doubt {
        ranking.doubt_leading(STANDS_FOR_ONE);
        let share = if closed.tells() {
            format!("{:.0} % of the gap", 100.0 * closed.mean)
        } else {
            "no share of the gap that stands out of the noise".to_owned()
        };
        decision.doubt(format!(
            "what is named closes {share} where it was not fitted: what is missing may be something else"
        ));
    }
    let doubted = doubt.is_some() || ranking.set.iter().any(|answer| answer == "unknown");
    if !doubted
        && let Some((h, f)) = &decision.accepted
        && let Some((name, size)) = unlikely(h, f)
    {
        ranking.doubt_leading(STANDS_FOR_ONE);
        decision.doubt(format!(
            "{name} would be of {size:.1} times its usual size: it may stand for something else"
        ));
    }
    let accepts = decision.accepted.is_some() && decision.verdict != "unknown";
    match data
        .uneven
        .as_ref()
        .filter(|_| accepts)
        .and_then(|u| u.doubts(&ranking))
    {
        Some(Doubtful::OneWheel) => {
            ranking.doubt_leading(STANDS_FOR_ONE);
            decision.doubt(ONE_WHEEL.to_owned());
        }
        Some(Doubtful::Nothing) => {
            ranking.doubt_start(ANOTHER_SOIL);
            decision.doubt(WAVES.to_owned());
        }
        None => {}
    }
    // Against another simulator the soil starts from that one's, and other soil is an answer of its own.
    let own_start = setup.inherited.is_none();
    let taken = decision.accepted.as_ref().filter(|_| own_start);
    let taken = taken.map(|(_, f)| rivals.null_weighed.plain.chi2() - f.chi2());
    let by_start = taken.filter(|taken| *taken < TAKES && decision.is_an_effect());
    let by_start = by_start.map(|taken| {
        format!(
            "a soil farther from the rover file's explains the log about as well without a cause (chi2 of {n:.0} values falls by {:.1} with it): what speaks for one is that start alone",
            taken.max(0.0),
        )
    });
    if let Some(why) = by_start.clone().filter(|_| setup.kind == LogKind::Rig) {
        ranking.doubt_start(ANOTHER_SOIL);
        decision.doubt(why);
    }
    let next = suggest(&data, predictor, &rivals.null_weighed, &ranking);
    ranking.tell_unseen();
    let undetermined = undetermined(null, fitted);
    let best = decision.accepted.as_ref();
    let (h, f) = best.map_or((null, fitted), |(h, f)| (h, f));
    let mut heed = heed(rivals.given / n, own_start.then_some((h, f)));
    heed.extend(rivals.heed);
    heed.extend(not_calibrated);
    heed.extend(by_start.filter(|_| setup.kind == LogKind::Drive));
    // Where nothing explains the data, a way that explains them a little better is no hint.
    let explains = decision.verdict != "unknown";
    heed.extend(measured.assumes().filter(|_| explains).map(str::to_owned));
    heed.extend(
        (decision.verdict == "unknown")
            .then(|| understated(&data, f))
            .flatten(),
    );
    data.notes.extend(heed.iter().cloned());
    let mut found = Diagnosis {
        kind: setup.kind,
        model: terra_model::ForceLaw::name(&setup.law),
        waterfall: Waterfall {
            as_given: Some(rivals.given / n),
            refitted: Some(fitted.chi2() / n),
            after,
        },
        null: Some((rivals.null, rivals.fitted)),
        accepted: decision.accepted,
        accepted_names: decision.accepted_names,
        causes: ranking.causes,
        probability_none: ranking.probability_none,
        probability_unknown: ranking.probability_unknown,
        set: ranking.set,
        verdict: decision.verdict,
        reason: decision.reason,
        nearest: decision.nearest,
        screen: rivals.screen,
        not_asked: rivals.not_asked,
        places: places_of_gap,
        remainder,
        rms,
        held_out: held,
        next,
        undetermined,
        heed,
        calibration: Some(calibration),
        evidence,
        baseline: None,
        logs: None,
        uneven: None,
        data,
    };
    if unknown_leads(&found)
        && let Some((null, fitted)) = &found.null
    {
        let by = (null, fitted);
        let shown = Uneven::shown(&found.data, predictor, by, &rivals.noise, &raw_null);
        found.uneven = shown.map(Arc::new);
    }
    Ok(found)
}

/// Misfit per value from which units or signs are likelier wrong than the ground.
const ABSURD: f64 = 1e4;
/// Prior sd by which a fitted soil is another than the one that the rover file starts from.
const FAR: f64 = 3.0;

/// Prior sd from which a cause is larger than it usually is: sealed cases have two at most.
const UNLIKELY: f64 = 4.0;

/// The cause of an explanation that is larger than causes are, and by how many of its prior sd.
fn unlikely(h: &Hypothesis, fit: &Fit) -> Option<(String, f64)> {
    let mut left = fit.x.iter().skip(h.soil_len());
    let mut each = h.effects().iter().map(|e| {
        let own = left.by_ref().take(e.params().len());
        (
            e.name().to_owned(),
            own.fold(0.0, |most: f64, x| most.max(x.abs())),
        )
    });
    each.find(|(_, size)| *size > UNLIKELY)
}

/// What to look at before believing a verdict.
fn heed(given: f64, fitted: Option<(&Hypothesis, &Fit)>) -> Vec<String> {
    let mut out = vec![];
    if given > ABSURD {
        out.push(format!(
            "a misfit of {given:.1e} per value is rarely the ground: look for wrong units and signs first (terra inspect LOG)"
        ));
    }
    let Some((h, fit)) = fitted else {
        return out;
    };
    let names = h.soil.names();
    let soil = fit.x.iter().take(h.soil_len()).enumerate();
    let far: Vec<String> = soil
        .filter(|(_, x)| x.abs() > FAR)
        .map(|(k, x)| {
            let side = if *x > 0.0 { "above" } else { "below" };
            format!("{} {:.1} prior sd {side}", names[k], x.abs())
        })
        .collect();
    if !far.is_empty() {
        out.push(format!(
            "the fitted soil is far from the rover file's: {}; start from another soil, or something is missing that this soil stands for",
            far.join(", ")
        ));
    }
    out
}

/// Misfit per value up to which it may be noise that is stated too small, and by how much channels may then differ: twice the
/// standard error of one with as many values, and this share.
const UNDERSTATED: (f64, f64) = (3.0, 0.15);

/// Factor of a standard deviation up to which no one states it better.
const WORTH_SAYING: f64 = 1.1;

/// What to look at where every channel misfits alike: hardly any cause does that.
fn understated(data: &DataSet, fit: &Fit) -> Option<String> {
    let mut each = vec![(0.0, 0.0); data.channels.len()];
    for ((_, c), r) in data.stacked().zip(fit.residual.iter()) {
        each[c].0 += 1.0;
        each[c].1 += r * r;
    }
    each.retain(|c| c.0 > 0.0);
    let all = fit.chi2() / fit.residual.len().max(1) as f64;
    let (most, share) = UNDERSTATED;
    let alike =
        |&(n, sum): &(f64, f64)| (sum / n / all - 1.0).abs() < share + 2.0 * (2.0 / n).sqrt();
    let stated = |how: &str, by: f64| {
        format!(
            "every channel misfits alike, {all:.2} per value: [noise] may be stated too {how}, by a factor of {by:.2}"
        )
    };
    let by = all.sqrt().max(all.sqrt().recip());
    (all < most && by > WORTH_SAYING && each.iter().all(alike)).then(|| match all > 1.0 {
        true => stated("small", by),
        false => stated("large", by),
    })
}

fn default_hold_out(data: &DataSet, kind: LogKind) -> HoldOut {
    match (data.groups().len(), kind) {
        (0 | 1, _) => HoldOut::Slip,
        (_, LogKind::Rig) => HoldOut::Trial,
        (_, LogKind::Drive | LogKind::Kinematic) => HoldOut::Segment,
    }
}

fn channel_rms(data: &DataSet, raw: &[f64]) -> Vec<(String, f64)> {
    data.channels
        .iter()
        .enumerate()
        .map(|(c, info)| {
            let squares: Vec<f64> = data
                .stacked()
                .zip(raw)
                .filter(|((_, k), _)| *k == c)
                .map(|(_, r)| r * r)
                .collect();
            (
                info.name.clone(),
                (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt(),
            )
        })
        .collect()
}

/// Soil parameters whose posterior is hardly narrower than their prior, by name.
fn undetermined(null: &Hypothesis, fit: &Fit) -> Vec<String> {
    let d = fit.x.len();
    let h = fit.jacobian.tr_mul(&fit.jacobian) + nalgebra::DMatrix::identity(d, d);
    let mut out = vec![];
    if null.soil.merges_stiffness() {
        out.push("k_c, k_phi only through k_c/b + k_phi".to_owned());
    }
    if let Some(c) = h.cholesky() {
        let covariance = c.inverse();
        let names = null.soil.names();
        let weak: Vec<String> = (0..null.soil_len())
            // How another simulator's form is off is no ground.
            .filter(|&k| covariance[(k, k)].sqrt() > 0.8 && !is_form_error(&names[k]))
            .map(|k| names[k].clone())
            .collect();
        if !weak.is_empty() {
            out.push(format!(
                "{}: no better known than before this log",
                weak.join(", ")
            ));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use nalgebra::DVector;

    use super::*;
    use crate::dataset::{ChannelInfo, Factors, Observation};

    /// Two channels that misfit by 1.44 each are noise stated too small by 1.2; where one has all of the misfit something is missing.
    #[test]
    fn channels_that_misfit_alike_are_noise_stated_too_small() {
        let channel = |name: &str| ChannelInfo {
            name: name.to_owned(),
            unit: "N",
            scale: 1.0,
        };
        let observation = |index| Observation {
            index,
            group: String::new(),
            condition: String::new(),
            place: String::new(),
            channels: vec![0, 1],
            values: vec![0.0; 2],
            raw_sd: vec![],
            shift: Default::default(),
            carried: vec![],
            factors: Factors::new(),
        };
        let data = DataSet {
            channels: vec![channel("a"), channel("b")],
            observations: (0..200).map(observation).collect(),
            dropped: BTreeMap::new(),
            notes: vec![],
            short_scatter: vec![],
            uneven: None,
        };
        let told = |a: f64, b: f64| {
            let residual = DVector::from_fn(400, |row, _| if row % 2 == 0 { a } else { b });
            understated(&data, &Fit::of_residual(residual))
        };
        assert!(told(1.2, 1.2).unwrap().contains("by a factor of 1.20"));
        assert_eq!(told(1.0, 1.7), None);
        assert_eq!(told(2.0, 2.0), None);
    }
}
