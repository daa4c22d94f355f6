//! Ground that is uneven under single wheels: what a simulator on level ground does not know of any real drive.
//!
//! Four wheels on a rigid body share their load by two moments and the weight: one load is left that only the ground's shape decides,
//! which swings between the two diagonals. It shows in torques, of a wheel and of the one across against the other two, as no cause
//! of all wheels, of an axle or of a side does. What one wheel does alone shows there too, as the re-fitted soil takes what it has in
//! common with all: what tells it apart is that loads that swing do not explain it. The same waves push at the rims, which moves the body.
//!
//! # Equation
//! Loads N ± ε W/4, + on one diagonal, with N what weight and moments give a wheel and W the weight: ε ~ N(0, θ) window by window, by
//! Σ ln N(z; 0, 1 + θ i) of the re-fitted nominal law, with g = -dr/dε of the torques, i = g' C^-1 g, z = g' C^-1 r/√i, C what sensors
//! leave. It is the ground's where that is certain and the diagonals misfit by far more than one of the other three ways to give signs
//! to four wheels. Residuals are then taken at the likeliest ε (by Gauss and Newton), r(ε) + g ε, of covariance C + θ g g'. The body's
//! accelerations are rougher by what they are off the re-fitted law, and not by the fast part of it alone. Waves last longer than a
//! window: of a correlation ρ from one to the next, n windows tell of a constant what n (1 - ρ)/(1 + ρ) do that do not follow each
//! other, and variances are so much larger.
//!
//! A cause must then gain what waves come to by themselves, which grows with their height, to be the only answer. Two never are: one
//! wheel that is not as the others looks like one cause of its axle and one of its side.
//!
//! Why the diagonals: loads (1, -1, -1, 1) ε on fl, fr, rl, rr have no sum, no moment about an axle's line (each axle's have no sum),
//! and with equal tracks none about the way; three equations leave four loads no other.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::cause::Ranking;
use crate::dataset::{DataSet, Observation};
use crate::diagnose::Diagnosis;
use crate::fit::{Fit, residual};
use crate::forms::is_made;
use crate::hypothesis::Hypothesis;
use crate::noise::NoiseModel;
use crate::parallel::for_each;
use crate::predictor::{Predict, Predictor};

/// What the ground's waves under single wheels come to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Uneven {
    /// Standard deviation of the share of a quarter of the weight by which a wheel's load swings.
    share: f64,
    /// The same for what follows from window to window, of which fewer tell.
    lasting: f64,
    /// Variance of the body's forward acceleration.
    pub(crate) forward: f64,
    /// Variance of its turning.
    pub(crate) turning: f64,
    /// By the number of an observation.
    each: Vec<Swing>,
}

/// What a cause on uneven ground may be instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Doubtful {
    /// Nothing: waves come to what it gains.
    Nothing,
    /// One wheel that is not as the others, which two causes imitate: one of an axle and one of a side.
    OneWheel,
}

/// What one observation has of it.
#[derive(Clone, Debug, Default, PartialEq)]
struct Swing {
    /// Where it most probably is.
    at: f64,
    /// Slopes of the residuals in it there.
    slopes: DVector<f64>,
}

/// Names of the channels of torque, in the order of the signs.
const TORQUES: [&str; 4] = [
    "wheel_torque_fl_N_m",
    "wheel_torque_fr_N_m",
    "wheel_torque_rl_N_m",
    "wheel_torque_rr_N_m",
];
/// The diagonals, and the other ways to tell four wheels apart: all alike, front from rear, left from right.
const WAYS: [[f64; 4]; 4] = [
    [1.0, -1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0, -1.0],
    [1.0, -1.0, 1.0, -1.0],
];
/// Windows from which it is asked.
const ENOUGH: usize = 16;
/// Log-likelihood that it must gain \[nats\].
const CERTAIN: f64 = 15.0;
/// How many times the least misfit of the other ways the diagonals' must be.
const BY_FAR: f64 = 2.0;
/// Most of a load that swings.
const NEARLY_ALL: f64 = 0.8;
/// A step in the share, for slopes.
const STEP: f64 = 0.01;
/// Steps towards where each swing most probably is, and how often one without an answer is halved before it is none.
const STEPS: usize = 3;
const HALVINGS: usize = 4;
/// What waves come to by themselves, for the whole of a load that swings \[nats\]: in five of another generator's 51 drives on such
/// ground with nothing missing a cause gained 5 to 30 by loads that swing by a quarter to a third, and of 72 with one effect nine that
/// were right gained no more than that. A second cause must gain it beside the first, as seven of eight pairs do. Chosen on these.
const NATS_PER_SHARE: f64 = 120.0;
/// Largest correlation from window to window that is reckoned with.
const MOST_ALIKE: f64 = 0.8;

/// What a value is off by a quantity of unknown variance: by how much in units of its noise, the information on that, and whether the
/// one before is of the window before.
struct Shown {
    off: f64,
    information: f64,
    follows: bool,
}

impl Uneven {
    /// What the residuals of a re-fitted law show; none where they show none, or something else beside.
    pub(crate) fn shown(
        data: &DataSet,
        predictor: &dyn Predictor,
        (null, fitted): (&Hypothesis, &Fit),
        noise: &NoiseModel,
        raw: &DVector<f64>,
    ) -> Option<Self> {
        if data.uneven.is_some() || data.observations.len() < ENOUGH {
            return None;
        }
        torques(data, data.observations.first()?)?;
        let numbers = data.observations.iter().map(|o| o.index + 1).max()?;
        let swung = |swings: &[f64]| {
            let predictor = predictor.swung(swings)?;
            residual(data, &*predictor, null, fitted.x.as_slice()).ok()
        };
        let from = |raw: &DVector<f64>, swings: &[f64]| {
            Some((swung(&a_step_further(swings))? - raw) / STEP)
        };
        let slopes = from(raw, &vec![0.0; numbers])?;
        let (mut by_signs, mut forward, mut turning) = ([const { vec![] }; 4], vec![], vec![]);
        let mut asked = vec![];
        let mut before: Option<&Observation> = None;
        for ((o, block), first) in data
            .observations
            .iter()
            .zip(&noise.blocks)
            .zip(firsts(data))
        {
            let (here, along) = (
                raw.rows(first, o.values.len()),
                slopes.rows(first, o.values.len()),
            );
            let follows = before.is_some_and(|b| b.group == o.group && b.channels == o.channels);
            before = Some(o);
            let sensors = block - noise.ground_under(o);
            for (k, &channel) in o.channels.iter().enumerate() {
                let name = data.channels[channel].name.as_str();
                let sd = sensors[(k, k)].sqrt();
                let shown = Shown {
                    off: here[k] / sd,
                    information: sd.powi(-2),
                    follows,
                };
                match name {
                    "yaw_acceleration_rad_s2" => turning.push(shown),
                    "accel_x_m_s2" => forward.push(shown),
                    _ => {}
                }
            }
            let Some(places) = torques(data, o) else {
                continue;
            };
            let c = DMatrix::from_fn(4, 4, |a, b| sensors[(places[a], places[b])]);
            let Some(root) = c.cholesky() else { continue };
            let r = DVector::from_fn(4, |q, _| here[places[q]]);
            for (out, signs) in by_signs.iter_mut().zip(WAYS) {
                // Slopes of the residuals have the signs of the diagonals.
                let g = DVector::from_fn(4, |q, _| -signs[q] * WAYS[0][q] * along[places[q]]);
                let weighed = root.solve(&g);
                let information = weighed.dot(&g);
                if information <= 0.0 {
                    continue;
                }
                let off = weighed.dot(&r) / information.sqrt();
                out.push(Shown {
                    off,
                    information,
                    follows,
                });
            }
            asked.push(Loaded {
                index: o.index,
                torques: places.map(|place| first + place),
                sensors: root,
            });
        }
        let [diagonals, others @ ..] = &by_signs;
        // A cause of all wheels, of an axle or of a side may show beside the diagonals, each in a way of its own.
        let least = others
            .iter()
            .map(|s| beyond(s))
            .fold(f64::INFINITY, f64::min);
        let variance = likeliest(diagonals);
        let certain = gained(diagonals, variance) > CERTAIN && diagonals.len() >= ENOUGH;
        if !certain || beyond(diagonals) <= BY_FAR * least {
            return None;
        }
        let (mut at, mut there, mut slopes) = (vec![0.0; numbers], raw.clone(), slopes);
        for _ in 0..STEPS {
            for window in &asked {
                window.step(&mut at[window.index], &there, &slopes, variance);
            }
            // Soil that only just carries a wheel may not carry it there.
            let law = (null, fitted.x.as_slice());
            halve_unanswered(data, predictor, law, &mut at)?;
            there = swung(&at)?;
            slopes = from(&there, &at)?;
        }
        let mut each = vec![Swing::default(); numbers];
        for (o, first) in data.observations.iter().zip(firsts(data)) {
            each[o.index] = Swing {
                at: at[o.index],
                slopes: slopes.rows(first, o.values.len()).into_owned(),
            };
        }
        let of_body = |shown: &[Shown]| {
            let variance = likeliest(shown);
            variance * lasting(shown, variance)
        };
        Some(Uneven {
            share: variance.sqrt(),
            lasting: (variance * lasting(diagonals, variance)).sqrt(),
            forward: of_body(&forward),
            turning: of_body(&turning),
            each,
        })
    }

    /// What predicts the same windows with their loads where they most probably are, for data that know of it.
    pub(crate) fn met<P: Predict>(
        self: &Arc<Self>,
        data: &mut DataSet,
        predictor: &P,
    ) -> Option<P> {
        let swings: Vec<f64> = self.each.iter().map(|swing| swing.at).collect();
        let predictor = predictor.swung(&swings)?;
        for o in &mut data.observations {
            // A window without an answer in the first look has no swing in the second.
            let Some(Swing { at, slopes }) = self.each.get(o.index) else {
                continue;
            };
            o.carried = slopes.iter().map(|slope| -slope * at).collect();
        }
        data.uneven = Some(Arc::clone(self));
        Some(predictor)
    }

    /// What a swing of the loads by it adds to the covariance of an observation; none where a torque is missing.
    pub(crate) fn under(&self, o: &Observation) -> Option<DMatrix<f64>> {
        let slopes = &self.each.get(o.index)?.slopes;
        (slopes.len() == o.values.len())
            .then(|| slopes * slopes.transpose() * (self.lasting * self.lasting))
    }

    /// What waves come to by themselves \[nats\], which a cause must gain, and a second one beside it.
    pub(crate) fn comes_to(&self) -> f64 {
        NATS_PER_SHARE * self.share
    }

    /// What speaks against an answer that is an effect of the library, or several, if something does: other answers that stand beside it.
    pub(crate) fn doubts(&self, ranking: &Ranking) -> Option<Doubtful> {
        let leading = ranking.causes.first()?;
        let effects = leading.weighed.hypothesis.effects().len();
        let weak = leading.log_evidence_gain < self.comes_to();
        match effects {
            0 | 1 => weak.then_some(Doubtful::Nothing),
            _ => Some(Doubtful::OneWheel),
        }
    }

    /// The second diagnosis, which knows of it; the first where something unknown is all that is left in both, or where a formula left
    /// free would be named, as it follows waves as well.
    pub(crate) fn taken(&self, second: Diagnosis, mut first: Diagnosis) -> Diagnosis {
        let best = second.causes.first();
        let follows = best.is_some_and(|cause| {
            is_made(&cause.form) && cause.probability > second.probability_none
        });
        let percent = 100.0 * self.share;
        if follows || second.verdict == "unknown" {
            first.notice(format!(
                "what is left over of the torques swings between the two diagonals of wheels, as where ground that is uneven under \
                 single wheels loads two of them by {percent:.0} % more than the other two, or where one wheel is not as the others; \
                 taken for uneven ground, no cause of the library is clear of something unknown"
            ));
            return first;
        }
        let mut taken = second;
        taken.notice(format!(
            "the ground is uneven under single wheels: two wheels across from each other are loaded by {percent:.0} % (one standard \
             deviation) more, and then less, than the other two, as the torques show; the verdict takes that, and the pushes that go \
             with it, for the ground's and for no cause"
        ));
        taken
    }
}

/// A window in which all four torques tell of its loads.
struct Loaded {
    index: usize,
    /// Rows of its torques.
    torques: [usize; 4],
    /// Covariance of what sensors leave of them.
    sensors: Cholesky<f64, Dyn>,
}

impl Loaded {
    /// Moves a swing to where it most probably is by what is left over at it, and the slopes of that.
    fn step(&self, at: &mut f64, left: &DVector<f64>, slopes: &DVector<f64>, variance: f64) {
        let of = |all: &DVector<f64>| DVector::from_fn(4, |q, _| all[self.torques[q]]);
        let (r, g) = (of(left), -of(slopes));
        let weighed = self.sensors.solve(&g);
        let told = weighed.dot(&r) + weighed.dot(&g) * *at;
        *at = (told / (variance.recip() + weighed.dot(&g))).clamp(-NEARLY_ALL, NEARLY_ALL);
    }
}

fn a_step_further(swings: &[f64]) -> Vec<f64> {
    swings.iter().map(|swing| swing + STEP).collect()
}

/// Halves the swings at which a law has no answer, or none a step further; none where it has none without them.
fn halve_unanswered(
    data: &DataSet,
    predictor: &dyn Predictor,
    (law, x): (&Hypothesis, &[f64]),
    at: &mut [f64],
) -> Option<()> {
    let p = law.parameters(x);
    for halving in 0..=HALVINGS {
        let mut all = true;
        for swings in [at.to_vec(), a_step_further(at)] {
            let predictor = predictor.swung(&swings)?;
            if residual(data, &*predictor, law, x).is_ok() {
                continue;
            }
            all = false;
            let answers = for_each(data.observations.len(), |k| {
                let index = data.observations[k].index;
                let raw = predictor.raw(index);
                predictor.residual(&law.law, &p, index, &raw).is_ok()
            });
            for (o, answered) in data.observations.iter().zip(answers) {
                if !answered {
                    at[o.index] *= if halving + 1 < HALVINGS { 0.5 } else { 0.0 };
                }
            }
        }
        if all {
            return Some(());
        }
    }
    None
}

/// Row of each observation's first value.
fn firsts(data: &DataSet) -> impl Iterator<Item = usize> + '_ {
    let mut next = 0;
    data.observations.iter().map(move |o| {
        next += o.values.len();
        next - o.values.len()
    })
}

/// Mean square of what is off, beyond noise.
fn beyond(shown: &[Shown]) -> f64 {
    let all: f64 = shown.iter().map(|s| s.off * s.off - 1.0).sum();
    all / shown.len().max(1) as f64
}

/// How much larger this variance of values that follow each other is for what is constant.
fn lasting(shown: &[Shown], variance: f64) -> f64 {
    let pairs = shown.windows(2).filter(|pair| pair[1].follows);
    let (mut both, mut all) = (0.0, 0.0);
    for pair in pairs {
        both += pair[0].off * pair[1].off;
        all += variance * (pair[0].information * pair[1].information).sqrt();
    }
    if all <= 0.0 {
        return 1.0;
    }
    let alike = (both / all).clamp(0.0, MOST_ALIKE);
    (1.0 + alike) / (1.0 - alike)
}

/// Places of the four torques among the values of an observation.
fn torques(data: &DataSet, o: &Observation) -> Option<[usize; 4]> {
    let place = |name: &str| {
        let mut channels = o.channels.iter();
        channels.position(|&c| data.channels[c].name == name)
    };
    let all = TORQUES.map(place);
    all.iter()
        .all(Option::is_some)
        .then(|| all.map(Option::unwrap_or_default))
}

/// The variance under which these are likeliest, by halving: what speaks for more of it falls as it grows past that.
fn likeliest(shown: &[Shown]) -> f64 {
    let slope = |variance: f64| -> f64 {
        let each = shown.iter().map(|s| {
            let all = 1.0 + variance * s.information;
            s.information * (s.off * s.off / all - 1.0) / all
        });
        each.sum()
    };
    if slope(0.0) <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    // Squares are finite: some variance is too large for them.
    while slope(high) > 0.0 {
        high *= 2.0;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if slope(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Log-likelihood gained by a variance.
fn gained(shown: &[Shown], variance: f64) -> f64 {
    let each = shown.iter().map(|s| {
        let more = variance * s.information;
        0.5 * (s.off * s.off * more / (1.0 + more) - more.ln_1p())
    });
    each.sum()
}

#[cfg(test)]
mod tests {
    use chacha20::ChaCha8Rng;
    use chacha20::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// 20 000 values of variance 1 + θ i, with i = 9 and 36 in turn, whose θ follows itself by ρ.
    fn drawn(variance: f64, alike: f64) -> Vec<Shown> {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut wave = draw();
        let of = |k: usize| {
            wave = alike * wave + (1.0 - alike * alike).sqrt() * draw();
            let information = if k.is_multiple_of(2) { 9.0 } else { 36.0 };
            Shown {
                off: draw() + (variance * information).sqrt() * wave,
                information,
                follows: k > 0,
            }
        };
        (0..20_000).map(of).collect()
    }

    /// The likeliest variance is the one that values were drawn with, to five hundredths; of none it is next to none.
    #[test]
    fn the_likeliest_variance_is_the_one_drawn() {
        for variance in [0.04, 0.09, 0.25] {
            let found = likeliest(&drawn(variance, 0.0));
            assert!((found / variance - 1.0).abs() < 0.05, "{found}");
        }
        let none = likeliest(&drawn(0.0, 0.0));
        assert!(none < 1e-3, "{none}");
        assert!(gained(&drawn(0.0, 0.0), none) < CERTAIN);
        assert!(gained(&drawn(0.01, 0.0), 0.01) > CERTAIN);
    }

    /// A mean of values that follow each other by ρ has (1 + ρ)/(1 - ρ) times the variance of others (3 at a half, 1 at nothing).
    #[test]
    fn what_follows_itself_tells_less() {
        let half = lasting(&drawn(0.25, 0.5), 0.25);
        assert!((half - 3.0).abs() < 0.3, "{half}");
        let none = lasting(&drawn(0.25, 0.0), 0.25);
        assert!((none - 1.0).abs() < 0.1, "{none}");
        assert_eq!(lasting(&drawn(0.25, 0.9)[..1], 0.25), 1.0);
    }
}
