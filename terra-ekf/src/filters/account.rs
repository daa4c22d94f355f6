//! An update of all groups side by side, and what it says of the filter.
//!
//! # Equation
//! e = ν/√s of every channel; whitened by L of S = L Lᵀ, group by group; ln N(ν; 0, S) = -(NIS + ln Π L_ii² + m ln 2π)/2:
//! one logarithm of a product for all channels.
//!
//! What is rare (a reset, a dropped reading, an error) is left to the groups.

use super::lane::{Lane, WIDTH, at};
use super::lanes::Lanes;
use super::moments::{M, Pivots, Seen};
use crate::config::{FilterConfig, RobustLaw};
use crate::measurement::Innovation;
use crate::robust::Watch;

/// |e| beyond which a plain filter leaves a reading to the groups, which refuse it.
const ABSURD: f64 = 1e100;

/// How likely a sample was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// νᵀ S⁻¹ ν.
    pub nis: f64,
    /// Channels used.
    pub dof: usize,
    /// ln N(ν; 0, S).
    pub log_likelihood: f64,
}

/// The sums behind a [`Score`], place by place.
#[derive(Clone, Copy)]
struct Sums {
    nis: Lane,
    product: Lane,
    dof: u32,
}

impl Sums {
    fn new() -> Self {
        Sums {
            nis: Lane::ZERO,
            product: Lane::ONE,
            dof: 0,
        }
    }

    #[inline(always)]
    fn add(&mut self, seen: &Seen, pivots: &Pivots, second: bool) {
        let one = Lane::ONE;
        let nu = seen.nu[0];
        self.nis = (nu * nu).mul_add(pivots.inverse[0], self.nis);
        self.product *= seen.there[0].bitselect(seen.s[0], one);
        self.dof += seen.there[0].to_bitmask().count_ones();
        if second {
            let rest = pivots.rest(seen);
            self.nis = (rest * rest).mul_add(pivots.inverse[1], self.nis);
            self.product *= seen.there[1].bitselect(pivots.left, one);
            self.dof += seen.there[1].to_bitmask().count_ones();
        }
    }

    /// `None` where the product leaves the range of numbers.
    #[inline]
    fn score(&self) -> Option<Score> {
        let (nis, product) = (self.nis.reduce_add(), self.product.reduce_mul());
        let constant = f64::from(self.dof) * std::f64::consts::TAU.ln();
        product.is_normal().then(|| Score {
            nis,
            dof: self.dof as usize,
            log_likelihood: -0.5 * (nis + product.ln() + constant),
        })
    }
}

/// The same with a logarithm for every channel.
fn long_score(all: &[(Seen, Pivots)], lanes: &Lanes) -> Score {
    let mut score = Score::default();
    for (k, (seen, pivots)) in all.iter().enumerate() {
        for j in 0..1 + usize::from(lanes.second(k)) {
            let s = if j == 0 { seen.s[0] } else { pivots.left };
            let rest = if j == 0 {
                seen.nu[0]
            } else {
                pivots.rest(seen)
            };
            let square = rest * rest * pivots.inverse[j];
            for place in 0..WIDTH {
                if seen.there[j].to_bitmask() >> place & 1 == 1 {
                    let (square, s) = (at(&square, place), at(&s, place));
                    score.nis += square;
                    score.dof += 1;
                    score.log_likelihood -= 0.5 * (square + s.ln() + std::f64::consts::TAU.ln());
                }
            }
        }
    }
    score
}

/// What a bare update runs into.
pub(super) enum Refusal {
    /// A channel's S has no inverse.
    Singular { channel: usize },
    /// The belief would not be finite.
    NotFinite,
}

/// The update alone; with `SCORE` how likely the sample was.
#[inline]
pub(super) fn take<const SCORE: bool>(lanes: &mut Lanes, z: &[f64]) -> Result<Score, Refusal> {
    lanes.read(z);
    let (mut blemish, mut sound) = (Lane::ZERO, Lane::ZERO.simd_eq(Lane::ZERO));
    let mut sums = Sums::new();
    for k in 0..lanes.vectors() {
        let (seen, second) = (lanes.see(k), lanes.second(k));
        let pivots = seen.pivots(&seen.s, second);
        sound &= seen.sound(&pivots, second);
        if SCORE {
            sums.add(&seen, &pivots, second);
        }
        blemish += lanes.learn(k, &seen, &pivots);
    }
    if !sound.all() {
        return Err(Refusal::Singular {
            channel: unsound(lanes),
        });
    }
    if !blemish.simd_eq(Lane::ZERO).all() {
        return Err(Refusal::NotFinite);
    }
    let score = match SCORE {
        true => sums.score().unwrap_or_else(|| {
            let all: Vec<(Seen, Pivots)> = (0..lanes.vectors())
                .map(|k| {
                    let seen = lanes.see(k);
                    (seen, seen.pivots(&seen.s, lanes.second(k)))
                })
                .collect();
            long_score(&all, lanes)
        }),
        false => Score::default(),
    };
    lanes.accept();
    Ok(score)
}

/// The first channel whose S has no inverse.
fn unsound(lanes: &Lanes) -> usize {
    let bad = |place: &usize| {
        let (row, place) = (place / WIDTH, place % WIDTH);
        let seen = lanes.see(row / M);
        let sound = seen.sound(&seen.pivots(&seen.s, true), !row.is_multiple_of(M));
        sound.to_bitmask() >> place & 1 == 0
    };
    lanes.place().iter().position(bad).unwrap_or(0)
}

/// What the channels tell, in the places of their readings, NaN where there is none; kept from step to step for its room.
#[derive(Clone, Default)]
pub(super) struct Account {
    seen: Vec<(Seen, Pivots)>,
    residual: Vec<f64>,
    sd: Vec<f64>,
    ratio: Vec<f64>,
    whitened: Vec<f64>,
    inflation: Vec<f64>,
}

/// Puts a lane into row `row` of a column.
#[inline(always)]
fn note(column: &mut [f64], row: usize, lane: Lane) {
    if let Some(to) = column.as_chunks_mut::<WIDTH>().0.get_mut(row) {
        *to = lane.to_array();
    }
}

impl Account {
    /// Takes a sample in with all that an innovation says. `false`: something rare is up, nothing was changed, and the
    /// groups must see to it.
    pub(super) fn take(
        &mut self,
        lanes: &mut Lanes,
        z: &[f64],
        config: &FilterConfig,
        watch: &mut Watch,
        innovation: &mut Innovation,
    ) -> bool {
        let robust = config.robust.is_some();
        if robust && watch.rejects_any() {
            return false;
        }
        lanes.read(z);
        let Some(score) = self.look(lanes, config) else {
            return false;
        };
        let mut astray = Lane::ZERO;
        for (k, (seen, pivots)) in self.seen.iter().enumerate() {
            astray += if robust {
                let second = lanes.second(k);
                let factors = self.inflation.as_chunks::<WIDTH>().0;
                let mut s = seen.s;
                for (s, factor) in s.iter_mut().zip(factors.iter().skip(M * k)) {
                    *s *= Lane::new(*factor);
                }
                lanes.learn(k, seen, &seen.pivots(&s, second))
            } else {
                lanes.learn(k, seen, pivots)
            };
        }
        if !astray.simd_eq(Lane::ZERO).all() {
            return false;
        }
        lanes.accept();
        let columns = [
            (&mut innovation.residual, &self.residual),
            (&mut innovation.sd, &self.sd),
            (&mut innovation.ratio, &self.ratio),
            (&mut innovation.whitened, &self.whitened),
            (&mut innovation.inflation, &self.inflation),
        ];
        for (to, from) in columns {
            to.pick(from, lanes.place());
        }
        innovation.nis = score.nis;
        innovation.dof = score.dof;
        innovation.log_likelihood = score.log_likelihood;
        if robust {
            let seen = innovation
                .residual
                .as_slice()
                .iter()
                .zip(innovation.sd.as_slice());
            for (channel, (nu, sd)) in seen.enumerate().filter(|(_, (nu, _))| !nu.is_nan()) {
                watch.accept(channel, nu / sd);
            }
        }
        true
    }

    /// Fills the columns. `None` where a reading is singular, absurd or outside a robust filter's gate.
    #[inline(always)]
    fn look(&mut self, lanes: &Lanes, config: &FilterConfig) -> Option<Score> {
        let places = lanes.vectors() * M * WIDTH;
        for column in [
            &mut self.residual,
            &mut self.sd,
            &mut self.ratio,
            &mut self.whitened,
            &mut self.inflation,
        ] {
            column.resize(places, f64::NAN);
        }
        self.seen.clear();
        let limit = Lane::splat(config.robust.map_or(ABSURD, |_| config.gate));
        let per_gate = Lane::splat(1.0 / config.gate);
        let mut usual = Lane::ZERO.simd_eq(Lane::ZERO);
        let mut sums = Sums::new();
        for k in 0..lanes.vectors() {
            let (seen, second) = (lanes.see(k), lanes.second(k));
            let pivots = seen.pivots(&seen.s, second);
            usual &= seen.sound(&pivots, second);
            sums.add(&seen, &pivots, second);
            for j in 0..1 + usize::from(second) {
                let (row, nu, gone) = (M * k + j, seen.nu[j], !seen.there[j]);
                let sd = seen.s[j].sqrt();
                let e = nu / sd;
                usual &= e.abs().simd_le(limit) | gone;
                let whitened = if j == 0 {
                    e
                } else {
                    pivots.rest(&seen) / pivots.left.sqrt()
                };
                note(&mut self.residual, row, nu | gone);
                note(&mut self.sd, row, sd | gone);
                note(&mut self.ratio, row, (e.abs() * per_gate) | gone);
                note(&mut self.whitened, row, whitened | gone);
                note(&mut self.inflation, row, inflation(config, e) | gone);
            }
            self.seen.push((seen, pivots));
        }
        let score = || {
            sums.score()
                .unwrap_or_else(|| long_score(&self.seen, lanes))
        };
        usual.all().then(score)
    }
}

/// Factor on S_ii for innovations of `e` standard deviations.
#[inline(always)]
fn inflation(config: &FilterConfig, e: Lane) -> Lane {
    let factor = match config.robust.map(|robust| robust.law) {
        None => return Lane::ONE,
        Some(RobustLaw::Huber { threshold }) => e.abs() / threshold,
        Some(RobustLaw::StudentT { dof }) => (e * e + dof) / (dof + 1.0),
    };
    factor.fast_max(Lane::ONE)
}
