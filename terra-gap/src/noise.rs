//! The noise of the data: sensors, propagated input noise, and a smooth discrepancy of the model's form.
//!
//! # Equation
//! Per observation C = D S D' with D the derivative of the residual in all raw measurements (values and inputs, slip
//! included) and S their variances; block diagonal over observations. A discrepancy adds
//! a² diag(s) K diag(s), K = exp(-(Δ slip)²/(2 ℓ²)) inside each channel, ℓ = .25. What is only known from another log
//! (see [`Inherited`]) adds G P G'.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

use crate::dataset::{DataSet, Observation, Ranges};
use crate::error::GapError;
use crate::fit::evaluate;
use crate::hypothesis::Hypothesis;
use crate::memory::Remembered;
use crate::predictor::{Predictor, RawSlopes, raw_slopes};
use crate::uneven::Uneven;

/// Length of the discrepancy in slip.
pub(crate) const DISCREPANCY_LENGTH: f64 = 0.25;

/// Covariance of the stacked values, block diagonal by observation, with extra variance per channel.
#[derive(Clone, Debug)]
pub(crate) struct NoiseModel {
    /// Blocks in the order of the observations.
    pub blocks: Vec<DMatrix<f64>>,
    /// G P^(1/2) of what another log taught: rows as the stacked values.
    common: Option<DMatrix<f64>>,
    /// Variance that was added to each channel, of the ground and of no sensor; empty where none was.
    added: Vec<f64>,
    /// Channels that the ground shakes together, and the covariance of every two.
    together: (Vec<usize>, f64),
    /// Whether the rover file states how rough the ground is.
    pub(crate) stated: bool,
}

/// What another log taught the nominal model, and how well: its error is one and the same on every value of this log.
pub(crate) struct Inherited {
    /// The law as it was fitted there, with all that was free.
    pub(crate) hypothesis: Hypothesis,
    /// Its fit.
    pub(crate) x: Vec<f64>,
    /// Square root of the covariance of that fit.
    pub(crate) root: DMatrix<f64>,
    /// How many times the stated variance the other log misfits by.
    pub(crate) excess: f64,
    /// What it went through.
    pub(crate) ranges: Ranges,
}

impl NoiseModel {
    /// Propagates sensor and input noise at a fit vector.
    ///
    /// # Errors
    /// Where the model has no answer.
    pub(crate) fn propagate(
        data: &DataSet,
        predictor: &dyn Predictor,
        hypothesis: &Hypothesis,
        x: &[f64],
    ) -> Result<Self, GapError> {
        let p = hypothesis.parameters(x);
        let indices: Vec<usize> = data.observations.iter().map(|o| o.index).collect();
        let slopes = raw_slopes(predictor, &hypothesis.law, &p, &indices)?;
        Ok(NoiseModel::through(data, &slopes))
    }

    /// Sensor and input noise through these slopes.
    pub(crate) fn through(data: &DataSet, slopes: &[RawSlopes]) -> Self {
        let block = |((_, d), o): (&(_, DMatrix<f64>), &Observation)| {
            let variances = DVector::from_iterator(d.ncols(), o.raw_sd.iter().map(|sd| sd * sd));
            d * DMatrix::from_diagonal(&variances) * d.transpose()
        };
        let blocks = slopes.iter().zip(&data.observations).map(block).collect();
        NoiseModel {
            blocks,
            common: None,
            added: vec![],
            together: Default::default(),
            stated: false,
        }
    }

    /// The same, and what is uncertain about the nominal law itself; its scatter beyond the stated noise is every value's own.
    ///
    /// # Errors
    /// Where the model has no answer.
    pub(crate) fn with(
        mut self,
        data: &DataSet,
        predictor: &dyn Predictor,
        inherited: Option<&Inherited>,
    ) -> Result<Self, GapError> {
        if let Some(i) = inherited {
            let slopes =
                evaluate(data, predictor, &i.hypothesis, &i.x, &Remembered::default())?.jacobian;
            self.common = Some(slopes * &i.root);
            for block in &mut self.blocks {
                *block *= i.excess;
            }
        }
        Ok(self)
    }

    /// Adds variance to every value of a channel.
    pub(crate) fn add_channel_variance(&mut self, data: &DataSet, channel: usize, variance: f64) {
        self.added.resize(data.channels.len(), 0.0);
        self.added[channel] += variance;
        for (block, o) in self.blocks.iter_mut().zip(&data.observations) {
            for (k, &c) in o.channels.iter().enumerate() {
                if c == channel {
                    block[(k, k)] += variance;
                }
            }
        }
    }

    /// Adds what loads that swing under single wheels do to the torques of every observation.
    pub(crate) fn add_uneven(&mut self, data: &DataSet, uneven: &Uneven) {
        for (block, o) in self.blocks.iter_mut().zip(&data.observations) {
            if let Some(more) = uneven.under(o) {
                *block += more;
            }
        }
    }

    /// Adds covariance between every two of these channels, which the ground shakes together.
    pub(crate) fn add_together(&mut self, data: &DataSet, channels: Vec<usize>, covariance: f64) {
        for (block, o) in self.blocks.iter_mut().zip(&data.observations) {
            for (k, a) in o.channels.iter().enumerate() {
                for (l, b) in o.channels.iter().enumerate() {
                    if k != l && channels.contains(a) && channels.contains(b) {
                        block[(k, l)] += covariance;
                    }
                }
            }
        }
        self.together = (channels, covariance);
    }

    /// The same for every channel in turn.
    pub(crate) fn add_channel_variances(&mut self, data: &DataSet, variances: &[f64]) {
        for (channel, variance) in variances.iter().enumerate() {
            self.add_channel_variance(data, channel, *variance);
        }
    }

    /// What it costs \[nats\] that more variance was added to the channels than to those of another noise: half of what ln det grows
    /// by. What sensors' noise comes to through other slopes costs nothing: it is the same noise of the same sensors.
    ///
    /// # Errors
    /// [`GapError::NotPositiveDefinite`].
    pub(crate) fn price_over(&self, other: &NoiseModel, data: &DataSet) -> Result<f64, GapError> {
        let mut without = self.clone();
        for channel in 0..data.channels.len() {
            let more = other.of_ground(channel) - self.of_ground(channel);
            without.add_channel_variance(data, channel, more);
        }
        Ok(0.5 * (self.whitener(data)?.log_det - without.whitener(data)?.log_det))
    }

    /// The whitener of the noise alone.
    ///
    /// # Errors
    /// [`GapError::NotPositiveDefinite`].
    pub(crate) fn whitener(&self, data: &DataSet) -> Result<Whitener, GapError> {
        self.whitener_beside(data, self.common.as_ref())
    }

    /// The whitener of noise plus a discrepancy of relative amplitude `a` (for rig logs).
    ///
    /// # Errors
    /// [`GapError::NotPositiveDefinite`].
    pub(crate) fn whitener_with_discrepancy(
        &self,
        data: &DataSet,
        a: f64,
    ) -> Result<Whitener, GapError> {
        if a == 0.0 {
            return self.whitener(data);
        }
        let smooth = discrepancy(data) * a;
        let all = match &self.common {
            Some(common) => stacked_columns(common, &smooth),
            None => smooth,
        };
        self.whitener_beside(data, Some(&all))
    }

    /// The whitener of every observation's own noise and directions that all share.
    fn whitener_beside(
        &self,
        data: &DataSet,
        common: Option<&DMatrix<f64>>,
    ) -> Result<Whitener, GapError> {
        let mut log_det = 0.0;
        let blocks = self
            .blocks
            .iter()
            .zip(&data.observations)
            .map(|(b, o)| {
                let c = Cholesky::new(b.clone()).ok_or_else(|| GapError::NotPositiveDefinite {
                    what: o.place.clone(),
                })?;
                log_det += log_determinant(&c);
                Ok(c)
            })
            .collect::<Result<Vec<_>, GapError>>()?;
        let shared = common.map(|common| {
            let (shared, more) = shared(by_blocks(&blocks, common));
            log_det += more;
            shared
        });
        Ok(Whitener {
            blocks,
            shared,
            log_det,
        })
    }

    /// What the ground adds to the covariance of an observation.
    pub(crate) fn ground_under(&self, o: &Observation) -> DMatrix<f64> {
        let (together, covariance) = &self.together;
        DMatrix::from_fn(o.channels.len(), o.channels.len(), |k, l| {
            let (a, b) = (o.channels[k], o.channels[l]);
            if k == l {
                self.of_ground(a)
            } else if together.contains(&a) && together.contains(&b) {
                *covariance
            } else {
                0.0
            }
        })
    }

    /// What of a channel's variance is the ground's.
    pub(crate) fn of_ground(&self, channel: usize) -> f64 {
        self.added.get(channel).copied().unwrap_or(0.0)
    }

    /// True where every observation has a noise of its own, so that rows of whitened values keep their meaning.
    pub(crate) fn is_separate(&self) -> bool {
        self.common.is_none()
    }

    /// Noise so many times larger.
    pub(crate) fn times(&self, factor: f64) -> Self {
        NoiseModel {
            blocks: self.blocks.iter().map(|b| b * (factor * factor)).collect(),
            common: self.common.as_ref().map(|c| c * factor),
            added: self.added.iter().map(|v| v * factor * factor).collect(),
            together: (self.together.0.clone(), self.together.1 * factor * factor),
            stated: self.stated,
        }
    }

    /// Only the blocks of some observations.
    pub(crate) fn subset(&self, keep: &[usize]) -> Self {
        let mut firsts = vec![0];
        firsts.extend(self.blocks.iter().scan(0, |at, b| {
            *at += b.nrows();
            Some(*at)
        }));
        let rows: Vec<usize> = keep
            .iter()
            .flat_map(|&i| firsts[i]..firsts[i + 1])
            .collect();
        NoiseModel {
            blocks: keep.iter().map(|&i| self.blocks[i].clone()).collect(),
            common: self.common.as_ref().map(|c| c.select_rows(&rows)),
            added: self.added.clone(),
            together: self.together.clone(),
            stated: self.stated,
        }
    }
}

fn log_determinant(c: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * c.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>()
}

/// L^-1 m of the blocks' roots.
fn by_blocks(blocks: &[Cholesky<f64, Dyn>], m: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = m.clone();
    let mut at = 0;
    for c in blocks {
        let k = c.l_dirty().nrows();
        let mut rows = out.rows_mut(at, k);
        c.l_dirty().solve_lower_triangular_mut(&mut rows);
        at += k;
    }
    out
}

/// A (n x r) with I - A A' = (I + U U')^(-1/2), and ln det (I + U U'), for U (n x r) of few columns.
///
/// With U'U = Q Λ Q' and s² = 1 + λ: A = U Q diag(1/(s (s + 1)))^(1/2).
fn shared(u: DMatrix<f64>) -> (DMatrix<f64>, f64) {
    let SymmetricEigen {
        eigenvectors,
        eigenvalues,
    } = u.tr_mul(&u).symmetric_eigen();
    let s = eigenvalues.map(|l| (1.0 + l.max(0.0)).sqrt());
    let mut a = u * eigenvectors;
    for (mut column, s) in a.column_iter_mut().zip(s.iter()) {
        column /= (s * (s + 1.0)).sqrt();
    }
    (a, 2.0 * s.iter().map(|s| s.ln()).sum::<f64>())
}

/// Variance of a discrepancy that is left out of its columns, by that of a channel's scale.
const LEFT_OUT: f64 = 1e-13;

/// Columns F of a discrepancy of amplitude 1, F F' = diag(s) K diag(s): a smooth function of slip has few, however many values.
///
/// Cholesky's, with the value next that is known least, until all are known.
fn discrepancy(data: &DataSet) -> DMatrix<f64> {
    let places: Vec<(usize, usize)> = data.stacked().collect();
    let slip = |row: usize| {
        let o = &data.observations[places[row].0];
        let read = || o.factors.get("slip").copied();
        // Where it was read goes with the residual, which would seem smaller than it is.
        o.shift.slip.or_else(read).unwrap_or(0.0)
    };
    let mut columns: Vec<DVector<f64>> = vec![];
    for (channel, info) in data.channels.iter().enumerate() {
        let rows: Vec<usize> = (0..places.len())
            .filter(|&row| places[row].1 == channel)
            .collect();
        let first = columns.len();
        let mut left: Vec<f64> = vec![1.0; rows.len()];
        while let Some((pivot, &most)) = left.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))
            && most > LEFT_OUT
        {
            let root = most.sqrt();
            let mut column = DVector::zeros(places.len());
            for (k, &row) in rows.iter().enumerate() {
                let d = (slip(row) - slip(rows[pivot])) / DISCREPANCY_LENGTH;
                let known: f64 = columns[first..]
                    .iter()
                    .map(|c| c[row] * c[rows[pivot]])
                    .sum();
                let value = ((-0.5 * d * d).exp() - known) / root;
                column[row] = value;
                left[k] -= value * value;
            }
            // What is known of itself is known.
            left[pivot] = 0.0;
            columns.push(column);
        }
        for column in &mut columns[first..] {
            *column *= info.scale;
        }
    }
    match columns.is_empty() {
        true => DMatrix::zeros(places.len(), 0),
        false => DMatrix::from_columns(&columns),
    }
}

/// Columns of one and then of the other.
fn stacked_columns(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.nrows(), a.ncols() + b.ncols());
    out.columns_mut(0, a.ncols()).copy_from(a);
    out.columns_mut(a.ncols(), b.ncols()).copy_from(b);
    out
}

/// W with W' W = covariance^-1.
#[derive(Clone, Debug)]
pub(crate) struct Whitener {
    /// Of every observation its own.
    blocks: Vec<Cholesky<f64, Dyn>>,
    /// A few directions that all share, as [`shared`].
    shared: Option<DMatrix<f64>>,
    /// ln det of the covariance.
    pub log_det: f64,
}

impl Whitener {
    /// W m for stacked rows.
    pub(crate) fn apply(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = by_blocks(&self.blocks, m);
        if let Some(shared) = &self.shared {
            let along = shared.tr_mul(&out);
            out.gemm(-1.0, shared, &along, 1.0);
        }
        out
    }

    /// W v.
    pub(crate) fn apply_vector(&self, v: &DVector<f64>) -> DVector<f64> {
        let m = self.apply(&DMatrix::from_column_slice(v.len(), 1, v.as_slice()));
        DVector::from_column_slice(m.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::dataset::{ChannelInfo, Factors, Observation};

    fn data() -> DataSet {
        let observation = |index, channels: &[usize]| Observation {
            index,
            group: String::new(),
            condition: String::new(),
            place: String::new(),
            channels: channels.to_vec(),
            values: vec![0.0; channels.len()],
            raw_sd: vec![],
            shift: Default::default(),
            carried: vec![],
            factors: Factors::new(),
        };
        let channel = |name: &str| ChannelInfo {
            name: name.to_owned(),
            unit: "N",
            scale: 1.0,
        };
        DataSet {
            channels: vec![channel("a"), channel("b")],
            observations: vec![
                observation(0, &[0, 1]),
                observation(1, &[1]),
                observation(2, &[0, 1]),
            ],
            dropped: BTreeMap::new(),
            notes: vec![],
            short_scatter: vec![],
            uneven: None,
        }
    }

    /// A discrepancy is a covariance a² s² exp(-(Δ slip)²/(2 ℓ²)) inside each channel on top of the blocks, with what values share
    /// already: |W v|² and ln det of all that, assembled, although it is far larger than the noise and two slips are the same.
    #[test]
    fn a_discrepancy_is_a_covariance_of_few_columns() {
        let mut data = data();
        for (k, o) in data.observations.iter_mut().enumerate() {
            o.factors.insert("slip", [0.1, 0.7, 0.1][k]);
        }
        (data.channels[0].scale, data.channels[1].scale) = (3.0, 20.0);
        let block = |&m: &usize| DMatrix::from_fn(m, m, |r, c| if r == c { 1.0 } else { 0.3 });
        let blocks: Vec<DMatrix<f64>> = [2, 1, 2].iter().map(block).collect();
        let slips = [0.1, 0.1, 0.7, 0.1, 0.1];
        let channels = [0, 1, 1, 0, 1];
        for common in [
            None,
            Some(DMatrix::from_fn(5, 2, |r, c| ((2 * r + c) as f64).cos())),
        ] {
            let a = 0.3;
            let mut whole = DMatrix::from_fn(5, 5, |r, c| {
                if channels[r] != channels[c] {
                    return 0.0;
                }
                let s = a * data.channels[channels[r]].scale;
                let d: f64 = (slips[r] - slips[c]) / DISCREPANCY_LENGTH;
                s * s * (-0.5 * d * d).exp()
            });
            let mut at = 0;
            for b in &blocks {
                let mut view = whole.view_mut((at, at), (b.nrows(), b.nrows()));
                view += b;
                at += b.nrows();
            }
            if let Some(g) = &common {
                whole += g * g.transpose();
            }
            let noise = NoiseModel {
                blocks: blocks.clone(),
                common,
                added: vec![],
                together: Default::default(),
                stated: false,
            };
            let whitener = noise.whitener_with_discrepancy(&data, a).unwrap();
            let v = DVector::from_fn(5, |r, _| 1.0 - 0.7 * r as f64);
            let direct = v.dot(&whole.clone().lu().solve(&v).unwrap());
            let whitened = whitener.apply_vector(&v).norm_squared();
            assert!(
                (whitened - direct).abs() < 1e-11 * direct,
                "{whitened} {direct}"
            );
            assert!((whitener.log_det - whole.determinant().ln()).abs() < 1e-11);
        }
    }

    /// Of a thousand slips from braking to spinning a smooth function has some thirty columns, and they are the whole of it.
    #[test]
    fn a_smooth_function_of_slip_has_few_columns() {
        let mut data = data();
        let one = data.observations[1].clone();
        let slip = |k: usize| -1.0 + 2.0 * k as f64 / 999.0;
        data.observations = (0..1000).map(|_| one.clone()).collect();
        for (k, o) in data.observations.iter_mut().enumerate() {
            o.factors.insert("slip", slip(k));
        }
        let f = discrepancy(&data);
        assert!((15..=40).contains(&f.ncols()), "{}", f.ncols());
        for (i, j) in [(0, 0), (3, 400), (500, 550), (999, 998)] {
            let d: f64 = (slip(i) - slip(j)) / DISCREPANCY_LENGTH;
            let found = f.row(i).dot(&f.row(j));
            assert!((found - (-0.5 * d * d).exp()).abs() < 1e-12, "{i} {j}");
        }
    }

    /// What values share is a covariance G G' on top of the blocks: |W v|² = v' (B + G G')^-1 v and ln det, for all rows and
    /// for those of a part.
    #[test]
    fn shared_noise_is_one_covariance() {
        let blocks: Vec<DMatrix<f64>> = [2, 1, 2]
            .iter()
            .map(|&m| DMatrix::from_fn(m, m, |r, c| if r == c { 2.0 + r as f64 } else { 0.5 }))
            .collect();
        let g = DMatrix::from_fn(5, 3, |r, c| ((3 * r + c) as f64).sin());
        let noise = NoiseModel {
            blocks: blocks.clone(),
            common: Some(g.clone()),
            added: vec![],
            together: Default::default(),
            stated: false,
        };
        assert!(!noise.is_separate());
        let data = data();
        for (keep, rows) in [
            (vec![0, 1, 2], vec![0, 1, 2, 3, 4]),
            (vec![0, 2], vec![0, 1, 3, 4]),
        ] {
            let part = noise.subset(&keep).times(2.0);
            let whitener = part.whitener(&data.subset(&keep)).unwrap();
            let own = g.select_rows(&rows);
            let mut whole = &own * own.transpose();
            let mut at = 0;
            for &i in &keep {
                let m = blocks[i].nrows();
                let mut view = whole.view_mut((at, at), (m, m));
                view += &blocks[i];
                at += m;
            }
            whole *= 4.0;
            let v = DVector::from_fn(rows.len(), |r, _| 1.0 + r as f64);
            let direct = v.dot(&whole.clone().lu().solve(&v).unwrap());
            let whitened = whitener.apply_vector(&v).norm_squared();
            assert!((whitened - direct).abs() < 1e-12 * direct, "{keep:?}");
            let log_det = whole.determinant().ln();
            assert!((whitener.log_det - log_det).abs() < 1e-12, "{keep:?}");
        }
    }
}
