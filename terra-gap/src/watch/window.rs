//! What one window says: its share in every score.
//!
//! # Equation
//! With the baseline's soil x0 and information H0, whitened residual r and soil tangent J of the window, and a score's whitened
//! column j: A = J'J, b = J'r, u = J'j, v = j'j, w = j'r. Sums of these over a span give
//! z = (w - u'M b)/(v - u'M u)^½, M = (H0 + A)^-1,
//! which is j'C^-1 r/(j'C^-1 j)^½ with C = I + J H0^-1 J': what the soil's posterior leaves open is projected out.
//!
//! So for effects, whose signatures say how all channels move together. A channel is asked by itself, whatever the others do: with
//! its own residual y, tangent row J_c and variance σ², u = J_c'/σ², v = 1/σ², w = y/σ², z = w/(v + u'H0^-1 u)^½.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use terra_model::{AnyEffect, Vehicle};

use crate::dataset::{ChannelInfo, DataSet, Factors};
use crate::drive::{DrivePredictor, Taken};
use crate::error::GapError;
use crate::fit::evaluate_from;
use crate::hypothesis::Hypothesis;
use crate::latent::recentre;
use crate::memory::Memory;
use crate::noise::NoiseModel;
use crate::predictor::{AnyPredictor, Predictor, RawSlopes, raw_slopes};
use crate::signatures::{Place, columns};

/// Share of a signature that must be left after the soil is projected out; a score of less would be about rounding and the
/// model's curvature.
const LEFT: f64 = 0.01;
/// How often inputs are moved.
const ROUNDS: usize = 3;

/// The nominal simulator as the baseline left it.
pub(crate) struct Nominal {
    pub(crate) null: Hypothesis,
    /// Its soil.
    pub(crate) x: Vec<f64>,
    /// I + J'J of the baseline.
    pub(crate) information: DMatrix<f64>,
    /// Variance of each channel beyond its sensors'.
    pub(crate) roughness: Vec<f64>,
    pub(crate) channels: Vec<ChannelInfo>,
    pub(crate) effects: Vec<Arc<dyn AnyEffect>>,
    pub(crate) vehicle: Vehicle<f64>,
}

/// Where a window lies.
#[derive(Clone, Debug)]
pub(crate) struct Spot {
    pub(crate) number: usize,
    pub(crate) segment: String,
    pub(crate) factors: Factors,
}

/// One score's part of a window.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    u: DVector<f64>,
    v: f64,
    w: f64,
}

/// A window's parts of all scores: channels first, then effects.
#[derive(Clone, Debug)]
pub(crate) struct Contribution {
    pub(crate) spot: Spot,
    a: DMatrix<f64>,
    b: DVector<f64>,
    pub(crate) parts: Vec<Part>,
    /// Measured less predicted, in each channel's unit, and its 1-sigma; none where it was not measured.
    pub(crate) off: Vec<Option<(f64, f64)>>,
}

/// One score of a span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    pub(crate) z: f64,
    /// Best size, in the column's unit: z over the root of the information.
    pub(crate) size: f64,
    /// What is left of the column's information.
    pub(crate) information: f64,
}

impl Nominal {
    /// # Errors
    /// Where the nominal law has no answer.
    pub(crate) fn contribution(
        &self,
        taken: &Taken,
        number: usize,
        segment: &str,
    ) -> Result<Contribution, GapError> {
        let mut data = DataSet {
            channels: self.channels.clone(),
            observations: vec![taken.observation.clone()],
            dropped: std::collections::BTreeMap::new(),
            notes: vec![],
            short_scatter: vec![],
            uneven: None,
        };
        let predictor = DrivePredictor::new(self.vehicle, vec![taken.window.clone()], 1);
        let (predictor, noise) = self.centred(&mut data, predictor)?;
        let whitener = noise.whitener(&data)?;
        let memory = Memory::of(predictor.contacts());
        let here = evaluate_from(&data, &*predictor, &self.null, &self.x, 0, &memory)?;
        let near = memory.remembered();
        let r = whitener.apply_vector(&here.residual);
        let j = whitener.apply(&here.jacobian);
        let measured = &taken.observation.channels;
        let sd = |k: usize| {
            let block = noise.blocks.first();
            block.map_or(f64::NAN, |b| b[(k, k)].sqrt())
        };
        let part = |column: &DVector<f64>| Part {
            u: j.tr_mul(column),
            v: column.norm_squared(),
            w: column.dot(&r),
        };
        let alone = |k: usize| {
            let weight = 1.0 / sd(k).powi(2);
            Part {
                u: here.jacobian.row(k).transpose() * weight,
                v: weight,
                w: here.residual[k] * weight,
            }
        };
        let silent = Part {
            u: DVector::zeros(j.ncols()),
            v: 0.0,
            w: 0.0,
        };
        let at = |c: usize| measured.iter().position(|&m| m == c);
        let mut parts: Vec<Part> = (0..self.channels.len())
            .map(|c| match at(c) {
                Some(k) => alone(k),
                None => silent.clone(),
            })
            .collect();
        let (predictor, effects) = (&*predictor, &self.effects);
        let place = Place {
            x: &self.x,
            near: &near,
            residual: &r,
        };
        let found = columns(&data, predictor, &self.null, &place, effects, &whitener);
        parts.extend(found.into_iter().map(|column| {
            let column = column.ok().filter(|c| c.iter().all(|v| v.is_finite()));
            column.map_or_else(|| silent.clone(), |c| part(&c))
        }));
        Ok(Contribution {
            spot: Spot {
                number,
                segment: segment.to_owned(),
                factors: taken.observation.factors.clone(),
            },
            a: j.tr_mul(&j),
            b: j.tr_mul(&r),
            parts,
            off: (0..self.channels.len())
                .map(|c| at(c).map(|k| (here.residual[k], sd(k))))
                .collect(),
        })
    }
}

impl Nominal {
    /// A window with its inputs where they most probably were under the nominal law, and the noise there. As they were read, their
    /// noise would be in the residual and in every signature that follows them: what the two have in common adds up.
    fn centred(
        &self,
        data: &mut DataSet,
        read: DrivePredictor,
    ) -> Result<(AnyPredictor, NoiseModel), GapError> {
        let p = self.null.parameters(&self.x);
        let indices: Vec<usize> = data.observations.iter().map(|o| o.index).collect();
        let noise = |data: &DataSet, slopes: &[RawSlopes]| {
            let mut noise = NoiseModel::through(data, slopes);
            noise.add_channel_variances(data, &self.roughness);
            noise
        };
        let mut now = Predictor::with_raw(&read, &[]);
        let mut slopes = raw_slopes(&*now, &self.null.law, &p, &indices)?;
        let mut own = noise(data, &slopes);
        for _ in 0..ROUNDS {
            let places: (&dyn Predictor, &dyn Predictor) = (&read, &*now);
            let moved = recentre(data, places, &self.null, &self.x, &own, Some(slopes))?;
            let (there, found) = moved.take(data);
            // Without slopes there a window stays as it was read.
            (now, slopes) = match found {
                Some(found) => (there, found),
                None => {
                    let slopes = raw_slopes(&*there, &self.null.law, &p, &indices)?;
                    own = noise(data, &slopes);
                    return Ok((there, own));
                }
            };
            own = noise(data, &slopes);
        }
        Ok((now, own))
    }
}

/// Sums over a span.
#[derive(Clone, Debug)]
pub(crate) struct Span {
    a: DMatrix<f64>,
    b: DVector<f64>,
    parts: Vec<Part>,
    pub(crate) windows: usize,
}

impl Span {
    pub(crate) fn empty(free: usize, scores: usize) -> Self {
        let part = Part {
            u: DVector::zeros(free),
            v: 0.0,
            w: 0.0,
        };
        Span {
            a: DMatrix::zeros(free, free),
            b: DVector::zeros(free),
            parts: vec![part; scores],
            windows: 0,
        }
    }

    pub(crate) fn add(&mut self, c: &Contribution) {
        self.a += &c.a;
        self.b += &c.b;
        for (sum, part) in self.parts.iter_mut().zip(&c.parts) {
            sum.u += &part.u;
            sum.v += part.v;
            sum.w += part.w;
        }
        self.windows += 1;
    }

    /// The same span so many times as long.
    pub(crate) fn stretched(&self, factor: f64) -> Self {
        let stretch = |p: &Part| Part {
            u: &p.u * factor,
            v: p.v * factor,
            w: p.w * factor,
        };
        Span {
            a: &self.a * factor,
            b: &self.b * factor,
            parts: self.parts.iter().map(stretch).collect(),
            windows: self.windows,
        }
    }

    /// All scores with nothing left open: w/v^½.
    pub(crate) fn raw(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        self.parts
            .iter()
            .map(|p| (p.v > 0.0).then(|| p.w / p.v.sqrt()))
    }

    fn open(&self, information: &DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
        Cholesky::new(information + &self.a)
    }

    /// All scores, the first of them `channels`; none where the soil absorbs nearly all of a signature.
    pub(crate) fn standings(
        &self,
        information: &DMatrix<f64>,
        channels: usize,
    ) -> Vec<Option<Standing>> {
        let both = self
            .open(information)
            .zip(Cholesky::new(information.clone()));
        let Some((open, before)) = both else {
            return vec![None; self.parts.len()];
        };
        let b = open.solve(&self.b);
        self.parts
            .iter()
            .enumerate()
            .map(|(k, p)| {
                if k < channels {
                    let spread = p.v + p.u.dot(&before.solve(&p.u));
                    return (p.v > 0.0).then(|| Standing {
                        z: p.w / spread.sqrt(),
                        size: p.w / p.v,
                        information: p.v * p.v / spread,
                    });
                }
                let h = p.v - p.u.dot(&open.solve(&p.u));
                let g = p.w - p.u.dot(&b);
                (h > LEFT * p.v && g.is_finite()).then(|| Standing {
                    z: g / h.sqrt(),
                    size: g / h,
                    information: h,
                })
            })
            .collect()
    }
}

/// What another soil would explain: the root of twice its gain over the baseline's, and how far it would have moved in prior sd.
pub(crate) fn soil_change(span: &Span, information: &DMatrix<f64>) -> Option<(f64, f64)> {
    let d = information.nrows();
    let free = span.open(&DMatrix::identity(d, d))?.solve(&span.b);
    let held = span.open(information)?.solve(&span.b);
    let gain = span.b.dot(&free) - span.b.dot(&held);
    Some((gain.max(0.0).sqrt(), free.norm()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Second method: z from the full covariance C = I + J H0^-1 J' of ten stacked values, against the sums.
    #[test]
    fn sums_give_the_score_of_the_full_covariance() {
        let (n, d) = (10, 2);
        let value = |k: usize| ((k * 7919 % 101) as f64 / 50.0) - 1.0;
        let j = DMatrix::from_fn(n, d, |r, c| value(r * d + c + 1));
        let r = DVector::from_fn(n, |k, _| value(k + 40));
        let column = DVector::from_fn(n, |k, _| value(k + 71));
        let h0 = DMatrix::from_row_slice(2, 2, &[3.0, 0.4, 0.4, 1.5]);
        let c = DMatrix::identity(n, n) + &j * h0.clone().try_inverse().unwrap() * j.transpose();
        let solved = c.try_inverse().unwrap() * &column;
        let z = solved.dot(&r) / solved.dot(&column).sqrt();
        let mut span = Span::empty(d, 1);
        for rows in [0..4, 4..10] {
            let (from, m) = (rows.start, rows.len());
            let (j, r) = (j.rows(from, m), r.rows(from, m));
            let column = column.rows(from, m);
            span.add(&Contribution {
                spot: Spot {
                    number: 0,
                    segment: String::new(),
                    factors: Factors::new(),
                },
                a: j.tr_mul(&j),
                b: j.tr_mul(&r),
                parts: vec![Part {
                    u: j.tr_mul(&column),
                    v: column.norm_squared(),
                    w: column.dot(&r),
                }],
                off: vec![],
            });
        }
        let found = span.standings(&h0, 0)[0].unwrap();
        assert!((found.z - z).abs() < 1e-12, "{} and {z}", found.z);
    }

    /// Closed form: residuals y of one channel with sd σ, all at one slope J, soil known to 1/H0: Σ y/σ² is normal with variance
    /// n/σ² + n² J²/(σ⁴ H0).
    #[test]
    fn a_channel_is_scored_by_itself() {
        let (n, sd, slope, h0, y) = (7.0, 0.5, 2.0, 9.0, 0.3);
        let weight = 1.0 / (sd * sd);
        let mut span = Span::empty(1, 1);
        for _ in 0..7 {
            span.add(&Contribution {
                spot: Spot {
                    number: 0,
                    segment: String::new(),
                    factors: Factors::new(),
                },
                a: DMatrix::from_element(1, 1, slope * slope * weight),
                b: DVector::from_element(1, slope * y * weight),
                parts: vec![Part {
                    u: DVector::from_element(1, slope * weight),
                    v: weight,
                    w: y * weight,
                }],
                off: vec![],
            });
        }
        let z = (n * y / sd) / (n + n * n * slope * slope * weight / h0).sqrt();
        let found = span.standings(&DMatrix::from_element(1, 1, h0), 1)[0].unwrap();
        assert!((found.z - z).abs() < 1e-12, "{} and {z}", found.z);
        assert!((found.size - y).abs() < 1e-12);
    }
}
