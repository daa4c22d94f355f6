//! One event: when and where a gap opened, and what it looks like.

use serde::Serialize;
use terra_model::order::{ascending, descending};

use super::baseline::Learned;
use super::window::{Contribution, Span, Spot, Standing, soil_change};

/// A factor orders the readings when its trend is this clear.
const TREND: f64 = 3.0;
/// Hints of an event.
const HINTS: usize = 3;
/// Factors that readings may follow.
const FACTORS: [&str; 5] = ["slip", "speed", "yaw_rate", "load", "pass"];

/// A place in the log.
#[derive(Clone, Debug, Default, Serialize, PartialEq)]
pub struct Instant {
    /// Middle of the window, in the log's time \[s\].
    pub time_s: f64,
    /// Path since the run began, or as logged \[m\].
    pub path_m: f64,
    /// Manoeuvre.
    pub segment: String,
    /// Number of the window in the log, from 0.
    pub window: usize,
}

/// An effect whose signature the readings have moved along.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Hint {
    /// Effect, or `soil-change`: soil other than the baseline's.
    pub effect: String,
    /// Its score, in standard deviations.
    pub sigma: f64,
    /// Its size.
    pub magnitude: f64,
    /// Unit of the size.
    pub unit: String,
}

/// A gap that opened. Channel, bias, factor and hints are those of the clearest look until it closed.
#[derive(Clone, Debug, Default, Serialize, PartialEq)]
pub struct WatchEvent {
    /// When it was flagged.
    pub flagged: Instant,
    /// The most likely beginning, at most 80 windows back.
    pub onset: Instant,
    /// From that beginning to the flag \[s\].
    pub delay_s: f64,
    /// When it was over; none when the log ended first.
    pub closed: Option<Instant>,
    /// The score that flagged it, the furthest beyond its threshold then: a channel or an effect.
    pub score: String,
    /// That score, in standard deviations.
    pub sigma: f64,
    /// Its threshold there.
    pub threshold: f64,
    /// The span that it was summed over \[s\].
    pub span_s: f64,
    /// The channel that moved most.
    pub channel: String,
    /// Mean of measured less predicted since the beginning, in the channel's unit.
    pub bias: f64,
    /// Unit of the bias.
    pub unit: String,
    /// What the channel's readings follow: slip, speed, yaw_rate, load, pass, or time where it is nothing else.
    pub factor: String,
    /// Range of the factor in which they are furthest off.
    pub from: f64,
    /// Its end.
    pub to: f64,
    /// Effects that look most like it: a hint, never a verdict.
    pub nearest: Vec<Hint>,
}

impl Instant {
    pub(crate) fn of(spot: &Spot) -> Self {
        let factor = |name: &str| spot.factors.get(name).copied().unwrap_or_default();
        Instant {
            time_s: factor("time"),
            path_m: factor("path"),
            segment: spot.segment.clone(),
            window: spot.number,
        }
    }
}

/// Where and what, over the windows since the beginning (the latest first).
pub(crate) fn describe(
    since: &[&Contribution],
    span: &Span,
    scores: &[Option<Standing>],
    learned: &Learned,
) -> Option<WatchEvent> {
    let channels = &learned.nominal.channels;
    let z = |k: usize| scores.get(k).copied().flatten().map_or(0.0, |s| s.z.abs());
    let c = (0..channels.len()).max_by(|a, b| z(*a).total_cmp(&z(*b)))?;
    let channel = channels.get(c)?;
    let off: Vec<(&Contribution, f64, f64)> = since
        .iter()
        .filter_map(|w| {
            let (off, sd) = w.off.get(c).copied().flatten()?;
            Some((*w, off, off / sd))
        })
        .collect();
    let bias = off.iter().map(|o| o.1).sum::<f64>() / off.len().max(1) as f64;
    let (factor, from, to) = follows(&off);
    let mut nearest: Vec<Hint> = learned
        .nominal
        .effects
        .iter()
        .enumerate()
        .filter_map(|(k, effect)| {
            let row = channels.len() + k;
            let standing = scores.get(row).copied().flatten()?;
            let one_sided = learned.one_sided.get(row).copied().unwrap_or(false);
            let param = effect.params().first()?;
            (!one_sided || standing.z > 0.0).then(|| Hint {
                effect: effect.name().to_owned(),
                sigma: standing.z.abs(),
                magnitude: standing.size * param.prior_sd,
                unit: param.unit.to_owned(),
            })
        })
        .collect();
    if let Some((sigma, moved)) = soil_change(span, &learned.nominal.information) {
        nearest.push(Hint {
            effect: "soil-change".to_owned(),
            sigma,
            magnitude: moved,
            unit: "prior sd".to_owned(),
        });
    }
    descending(&mut nearest, |n| n.sigma);
    let mut seen: Vec<String> = vec![];
    nearest.retain(|h| {
        let new = !seen.contains(&h.effect);
        seen.push(h.effect.clone());
        new
    });
    nearest.truncate(HINTS);
    Some(WatchEvent {
        channel: channel.name.clone(),
        unit: channel.unit.to_owned(),
        bias,
        factor,
        from,
        to,
        nearest,
        ..WatchEvent::default()
    })
}

/// The factor that a channel's readings follow most clearly, and the half of its range where they are furthest off.
fn follows(off: &[(&Contribution, f64, f64)]) -> (String, f64, f64) {
    let points = |name: &str| -> Vec<(f64, f64)> {
        off.iter()
            .filter_map(|(w, _, z)| Some((*w.spot.factors.get(name)?, *z)))
            .collect()
    };
    let trend = |points: &[(f64, f64)]| {
        let n = points.len().max(1) as f64;
        let (x, z) = points
            .iter()
            .fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
        let along: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - z)).sum();
        let spread: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
        if spread > 1e-9 * n * x * x {
            along.abs() / spread.sqrt()
        } else {
            0.0
        }
    };
    let best = FACTORS
        .into_iter()
        .map(|name| (name, points(name)))
        .map(|(name, p)| (trend(&p), name, p))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(trend, ..)| *trend > TREND);
    let (name, mut points) = match best {
        Some((_, name, points)) => (name, points),
        None => ("time", points("time")),
    };
    ascending(&mut points, |p| p.0);
    let range = |p: &[(f64, f64)]| {
        let ends = p.first().zip(p.last());
        ends.map_or((0.0, 0.0), |(a, b)| (a.0, b.0))
    };
    if name == "time" {
        let (from, to) = range(&points);
        return (name.to_owned(), from, to);
    }
    let (low, high) = points.split_at(points.len() / 2);
    let mean =
        |p: &[(f64, f64)]| (p.iter().map(|p| p.1).sum::<f64>() / p.len().max(1) as f64).abs();
    let (from, to) = range(if mean(low) > mean(high) { low } else { high });
    (name.to_owned(), from, to)
}
