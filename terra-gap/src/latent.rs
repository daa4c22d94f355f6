//! Where the inputs truly were, as well as a fit can tell: errors in variables.
//!
//! Slip is measured with noise, and forces bend with slip. A fit that takes slips as they were read finds a ground that answers
//! slip too weakly, the more so the less slip there is beside its noise, and then effects that make up for it. Here every
//! observation is predicted where its raw quantities most probably were, and what lies between there and what was read
//! enters by its tangent, whose noise is the covariance already.
//!
//! # Equation
//! u = y - S D' C^-1 (g(u) + D (y - u)), r(x) = g(u, x) + D (y - u), with y what was read, S its variances, g the
//! residual, D its derivative at u, C = D S D' and the ground's roughness. Iterated with the fit this is the orthogonal distance
//! regression of the data.
//!
//! Roughness is no noise that happens to lie beside slip: a push of the ground changes how the vehicle runs within some
//! hundredths of a second, so that the window's own slip answers it. S D' gains their covariance P (`gives_way`): what is found
//! is where the inputs were without the push. A fit that took slip as independent of it would find the ground too weak.
//!
//! # Reference
//! P. T. Boggs, J. E. Rogers, Orthogonal distance regression, Contemporary Mathematics 112, 1990; W. A. Fuller, Measurement
//! Error Models, 1987.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::dataset::{DataSet, Observation, Shift};
use crate::error::GapError;
use crate::hypothesis::Hypothesis;
use crate::memory::Memory;
use crate::noise::NoiseModel;
use crate::parallel::for_each;
use crate::predictor::{AnyPredictor, Predictor, RawSlopes, Yielding, raw_slopes};

/// How far \[sd\] a raw quantity may be from what was read: beyond, it is the law that is wrong.
const FARTHEST: f64 = 3.0;

/// Inputs that were moved.
pub(crate) struct Moved {
    /// Predicts there.
    pub(crate) predictor: AnyPredictor,
    /// What the tangent adds to each observation, and its slip.
    shifts: Vec<Shift>,
    /// The slopes there, unless an observation has none and stays as it was measured.
    slopes: Option<Vec<RawSlopes>>,
}

impl Moved {
    /// Takes the data there; with the slopes there, where every observation has them.
    pub(crate) fn take(self, data: &mut DataSet) -> (AnyPredictor, Option<Vec<RawSlopes>>) {
        for (o, shift) in data.observations.iter_mut().zip(self.shifts) {
            o.shift = shift;
        }
        (self.predictor, self.slopes)
    }
}

/// Moves the inputs of all observations to where they most probably were under a fit, from what was `measured` and where they
/// are `now`. An observation that has no answer there stays as it was measured, and so does what was never read. `nearby`: slopes
/// of a fit next to this one, which are as good for a step that is taken again until the fit stands still.
///
/// # Errors
/// Where the model has no answer at what was measured.
pub(crate) fn recentre(
    data: &DataSet,
    (measured, now): (&dyn Predictor, &dyn Predictor),
    hypothesis: &Hypothesis,
    x: &[f64],
    noise: &NoiseModel,
    nearby: Option<Vec<RawSlopes>>,
) -> Result<Moved, GapError> {
    let p = hypothesis.parameters(x);
    let law = &hypothesis.law;
    let indices: Vec<usize> = data.observations.iter().map(|o| o.index).collect();
    let here = match nearby {
        Some(mut nearby) => {
            let residuals = now.residuals(law, &p, &indices, &Memory::none())?;
            for ((residual, _), own) in nearby.iter_mut().zip(residuals) {
                *residual = own;
            }
            nearby
        }
        None => raw_slopes(now, law, &p, &indices)?,
    };
    let taken: Vec<DVector<f64>> = indices.iter().map(|&i| measured.raw(i).into()).collect();
    let sought = |k: usize| {
        let (o, (g, d)) = (&data.observations[k], &here[k]);
        let raw = DVector::from_vec(now.raw(o.index));
        let mut left = DVector::from_column_slice(g) + d * (&taken[k] - raw);
        left.iter_mut().zip(&o.carried).for_each(|(l, c)| *l += c);
        let read = measured.read(o.index);
        let moves = |(k, sd): (usize, &f64)| if k < read { *sd } else { 0.0 };
        let sd = DVector::from_iterator(o.raw_sd.len(), o.raw_sd.iter().enumerate().map(moves));
        let (values, yielding) = (now.value_positions(o.index), now.yielding(o.index));
        let of_ground = noise.ground_under(o);
        let block = &noise.blocks[k];
        let gives_way = gives_way(d, &values, &yielding, &of_ground, block, noise.stated);
        Some(&taken[k] - step(d, &sd, gives_way, block, &left)?)
    };
    let sought: Vec<Option<DVector<f64>>> = for_each(indices.len(), sought);
    // Where one has no answer each is asked alone.
    let moved = moved_to(now, &indices, &taken, &sought);
    let there: Vec<Option<RawSlopes>> = match raw_slopes(&*moved, law, &p, &indices) {
        Ok(all) => all.into_iter().map(Some).collect(),
        Err(_) => for_each(indices.len(), |k| {
            let alone = raw_slopes(&*moved, law, &p, &indices[k..=k]).ok()?;
            alone.into_iter().next()
        }),
    };
    let shift = |(k, there): (usize, &Option<RawSlopes>)| {
        let shift = &there.as_ref()?.1 * (&taken[k] - sought[k].as_ref()?);
        shift.iter().all(|s| s.is_finite()).then_some(shift)
    };
    let shifts: Vec<Option<DVector<f64>>> = there.iter().enumerate().map(shift).collect();
    let all = shifts.iter().all(Option::is_some);
    let slopes = all.then(|| there.into_iter().flatten().collect());
    let kept = |(raw, shift): (Option<DVector<f64>>, &Option<_>)| raw.filter(|_| shift.is_some());
    let found: Vec<_> = sought.into_iter().zip(&shifts).map(kept).collect();
    let shift = |(k, shift): (usize, Option<DVector<f64>>)| {
        shift.map_or_else(Shift::default, |shift| Shift {
            values: shift.as_slice().to_vec(),
            slip: found[k]
                .as_ref()
                .and_then(|raw| now.slip(indices[k], raw.as_slice())),
        })
    };
    let shifts = shifts.into_iter().enumerate().map(shift).collect();
    Ok(Moved {
        predictor: moved_to(now, &indices, &taken, &found),
        shifts,
        slopes,
    })
}

/// Starts along the first quantity that the ground moves, in its sd.
const STARTS: [f64; 5] = [0.0, -1.0, 1.0, -2.0, 2.0];

/// Each observation where its tangent says most of what was read, of a few places along the quantity that the law bends with: from
/// there a search ends on the same side of a bend as the truth more often than from what was read. None where no quantity moves.
///
/// # Errors
/// Where the model has no answer at what was measured.
pub(crate) fn scanned(
    data: &DataSet,
    measured: &dyn Predictor,
    hypothesis: &Hypothesis,
    x: &[f64],
    noise: &NoiseModel,
) -> Result<Option<AnyPredictor>, GapError> {
    let p = hypothesis.parameters(x);
    let all = &data.observations;
    let indices: Vec<usize> = all.iter().map(|o| o.index).collect();
    let taken: Vec<DVector<f64>> = indices.iter().map(|&i| measured.raw(i).into()).collect();
    let moves = |o: &Observation| measured.yielding(o.index).first().map(|y| y.raw);
    if all.iter().any(|o| moves(o).is_none()) {
        return Ok(None);
    }
    let mut best: Vec<(f64, Option<DVector<f64>>)> = vec![(f64::INFINITY, None); all.len()];
    for start in STARTS {
        let at = |(o, taken): (&Observation, &DVector<f64>)| {
            let mut at = taken.clone();
            let raw = moves(o)?;
            at[raw] += start * o.raw_sd[raw];
            Some(at)
        };
        let places: Vec<Option<DVector<f64>>> = all.iter().zip(&taken).map(at).collect();
        let there = moved_to(measured, &indices, &taken, &places);
        let found = match raw_slopes(&*there, &hypothesis.law, &p, &indices) {
            Ok(found) => found,
            Err(e) if start == 0.0 => return Err(e),
            Err(_) => continue,
        };
        let blocks = &NoiseModel::through(data, &found).blocks;
        for (k, (g, d)) in found.iter().enumerate() {
            let Some(place) = &places[k] else { continue };
            let mut left = DVector::from_column_slice(g) + d * (&taken[k] - place);
            left.iter_mut()
                .zip(&all[k].carried)
                .for_each(|(l, c)| *l += c);
            let block = &blocks[k] + noise.ground_under(&all[k]);
            let misfit = Cholesky::new(block).map(|c| left.dot(&c.solve(&left)));
            if let Some(misfit) = misfit.filter(|m| *m < best[k].0) {
                best[k] = (misfit, Some(place.clone()));
            }
        }
    }
    let places: Vec<Option<DVector<f64>>> = best.into_iter().map(|(_, place)| place).collect();
    Ok(Some(moved_to(measured, &indices, &taken, &places)))
}

/// Observations at other raw quantities, or where there are none at those that were taken.
fn moved_to(
    predictor: &dyn Predictor,
    indices: &[usize],
    taken: &[DVector<f64>],
    raws: &[Option<DVector<f64>>],
) -> AnyPredictor {
    let rows = indices.iter().zip(taken.iter().zip(raws));
    let row = |(&index, (taken, raw)): (&usize, (&DVector<f64>, &Option<DVector<f64>>))| {
        let raw = raw.as_ref().unwrap_or(taken);
        (index, raw.as_slice().to_vec())
    };
    predictor.with_raw(&rows.map(row).collect::<Vec<_>>())
}

/// How raw quantities give way to pushes of the ground of these variances: covariance of each with the values, and its own variance.
///
/// A push ε on the values is balanced where D δ = ε, less what inertia takes: δ = K ε, K = (D'W D + Λ)^-1 D'W by least squares
/// weighed by the noise, Λ the weight of inertia. Pushes that are stated answer `all_of_it`; where they are only what the log leaves
/// over, they may be something else, and the torques as they were read hold back.
fn gives_way(
    d: &DMatrix<f64>,
    values: &[usize],
    yielding: &[Yielding],
    of_ground: &DMatrix<f64>,
    block: &DMatrix<f64>,
    all_of_it: bool,
) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let mut raws: Vec<usize> = yielding.iter().map(|y| y.raw).collect();
    raws.sort_unstable();
    raws.dedup();
    if raws.is_empty() || of_ground.amax() == 0.0 {
        return None;
    }
    // A motor that holds its wheel's speed lets the torque answer: what is read of it is balanced as before.
    let balanced =
        |row: usize| !all_of_it || yielding.iter().any(|y| values.get(row) == Some(&y.value));
    let weights = DVector::from_fn(d.nrows(), |row, _| {
        if balanced(row) {
            block[(row, row)].recip()
        } else {
            0.0
        }
    });
    let slopes = d.select_columns(&raws);
    let weighed = DMatrix::from_diagonal(&weights) * &slopes;
    let mut normal = slopes.tr_mul(&weighed);
    for y in yielding {
        let row = values.iter().position(|&v| v == y.value);
        let place = raws.iter().position(|&raw| raw == y.raw);
        if let (Some(row), Some(place)) = (row, place) {
            normal[(place, place)] += weights[row] * y.inertia * y.inertia;
        }
    }
    let found = Cholesky::new(normal)?.solve(&weighed.transpose());
    let own = &found * of_ground * found.transpose();
    let mut with_values = DMatrix::zeros(d.ncols(), d.nrows());
    let mut variance = DVector::zeros(d.ncols());
    for (place, &raw) in raws.iter().enumerate() {
        with_values.set_row(raw, &(found.row(place) * of_ground));
        variance[raw] = own[(place, place)];
    }
    Some((with_values, variance))
}

/// (S D' + P) C^-1 r with P the covariance of what `gives_way`, no component beyond [`FARTHEST`].
fn step(
    d: &DMatrix<f64>,
    sd: &DVector<f64>,
    gives_way: Option<(DMatrix<f64>, DVector<f64>)>,
    block: &DMatrix<f64>,
    left: &DVector<f64>,
) -> Option<DVector<f64>> {
    let pull = Cholesky::new(block.clone())?.solve(left);
    let mut variance = sd.map(|sd| sd * sd);
    let mut step = d.tr_mul(&pull).component_mul(&variance);
    if let Some((with_values, own)) = gives_way {
        step += with_values * pull;
        variance += own;
    }
    let farthest = step
        .iter()
        .zip(&variance)
        .filter(|(_, variance)| **variance > 0.0)
        .map(|(step, variance)| (step / variance.sqrt()).abs())
        .fold(0.0, f64::max);
    Some(step * (FARTHEST / farthest.max(FARTHEST)))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::sync::Arc;

    use terra_mme::{Centre, FitSpace, Priors};
    use terra_model::{Law, Param, Scalar, TerrainModel};

    use super::*;
    use crate::dataset::{ChannelInfo, Factors, Observation};
    use crate::fit::evaluate;
    use crate::kinematic::UniformSlip;
    use crate::memory::Remembered;
    use crate::predictor::{Design, Predict};
    use crate::soil_space::SoilSpace;

    /// A value of slope -2 in a quantity that no sensor is wrong about: a push of the ground moved it by all of what is left, or where
    /// inertia takes as much as the ground gives by half. Without a push it stays. A torque that answers the quantity, well known as
    /// it may be, keeps it from nothing.
    #[test]
    fn what_the_ground_pushes_gives_way() {
        let d = DMatrix::from_row_slice(2, 2, &[1.0, -2.0, 0.0, 7.0]);
        let exact = DVector::zeros(2);
        let block = DMatrix::from_diagonal(&DVector::from_vec(vec![0.04, 1e-4]));
        let moved = |variance: f64, inertia: f64| {
            let yielding = [Yielding {
                raw: 1,
                value: 0,
                inertia,
            }];
            let of_ground = DMatrix::from_diagonal(&DVector::from_vec(vec![variance, 0.0]));
            let gives_way = gives_way(&d, &[0, 3], &yielding, &of_ground, &block, true);
            let left = DVector::from_vec(vec![0.3, 0.0]);
            step(&d, &exact, gives_way, &block, &left).unwrap()
        };
        for (inertia, expected) in [(0.0, -0.15), (2.0, -0.075)] {
            let moved = moved(0.04, inertia);
            assert!((moved[1] - expected).abs() < 1e-12 && moved[0] == 0.0);
        }
        assert_eq!(moved(0.0, 0.0), exact);
    }

    /// y = p_0 x through the origin, both read with noise.
    #[derive(Clone)]
    struct Line(Vec<[f64; 2]>);

    impl Predict for Line {
        fn raw(&self, index: usize) -> Vec<f64> {
            self.0[index].to_vec()
        }
        fn residual<T: Scalar>(
            &self,
            _law: &Law,
            p: &[T],
            _index: usize,
            raw: &[T],
        ) -> Result<Vec<T>, GapError> {
            Ok(vec![raw[0] - p[0] * raw[1]])
        }
        fn value_positions(&self, _index: usize) -> Vec<usize> {
            vec![0]
        }
        fn with_raw(&self, replaced: &[(usize, Vec<f64>)]) -> Self {
            let mut out = self.clone();
            for (k, raw) in replaced {
                out.0[*k].copy_from_slice(raw);
            }
            out
        }
        fn designs(&self, _data: &DataSet) -> Vec<Design> {
            vec![]
        }
    }

    /// The slope found is Deming's, the root of a quadratic in the sums of squares (W. E. Deming, Statistical Adjustment of
    /// Data, 1943); the one of inputs taken as read is a tenth less.
    #[test]
    fn a_line_through_noisy_points_is_deming_s() {
        let (sd_y, sd_x) = (0.02, 0.05);
        let read: Vec<[f64; 2]> = (0..40)
            .map(|k| {
                let k = f64::from(k);
                let x = 0.005 * k;
                [
                    0.6 * x + sd_y * (1.3 * k).sin(),
                    x + sd_x * (2.7 * k + 1.0).sin(),
                ]
            })
            .collect();
        let sum = |of: &dyn Fn(&[f64; 2]) -> f64| read.iter().map(of).sum::<f64>();
        let (yy, xy, xx) = (
            sum(&|r| r[0] * r[0]),
            sum(&|r| r[0] * r[1]),
            sum(&|r| r[1] * r[1]),
        );
        let ratio = (sd_y / sd_x) * (sd_y / sd_x);
        let left = yy - ratio * xx;
        let deming = (left + (left * left + 4.0 * ratio * xy * xy).sqrt()) / (2.0 * xy);
        assert!(xy / xx < 0.92 * deming, "{} {deming}", xy / xx);

        let law = Law::new(Arc::new(UniformSlip), vec![]).unwrap();
        let zero = |p: &Param| (p.name.to_owned(), 0.0);
        let start: BTreeMap<String, f64> = UniformSlip::PARAMS.iter().map(zero).collect();
        let space = FitSpace::new(&law, Centre::Values(&start), &[0.1], &Priors::default());
        let soil = Arc::new(SoilSpace::new(space.unwrap(), &[]));
        let hypothesis = Hypothesis::null(law, soil);
        let observation = |index| Observation {
            index,
            group: String::new(),
            condition: String::new(),
            place: String::new(),
            channels: vec![0],
            values: vec![read[index][0]],
            raw_sd: vec![sd_y, sd_x],
            shift: Shift::default(),
            carried: vec![],
            factors: Factors::new(),
        };
        let mut data = DataSet {
            channels: vec![ChannelInfo {
                name: "y".to_owned(),
                unit: "1",
                scale: 1.0,
            }],
            observations: (0..read.len()).map(observation).collect(),
            dropped: BTreeMap::new(),
            notes: vec![],
            short_scatter: vec![],
            uneven: None,
        };
        let measured = Line(read.clone());
        let mut now = Predictor::with_raw(&measured, &[]);
        let mut x = vec![0.0; hypothesis.len()];
        let mut nearby = None;
        for _ in 0..30 {
            let noise = NoiseModel::propagate(&data, &*now, &hypothesis, &x).unwrap();
            let whitener = noise.whitener(&data).unwrap();
            let here = evaluate(&data, &*now, &hypothesis, &x, &Remembered::default()).unwrap();
            let r = whitener.apply_vector(&here.residual);
            let slope = whitener.apply(&here.jacobian).column(0).into_owned();
            x[0] += slope.dot(&r) / slope.norm_squared();
            let moved = recentre(&data, (&measured, &*now), &hypothesis, &x, &noise, nearby);
            (now, nearby) = moved.unwrap().take(&mut data);
        }
        let found = hypothesis.parameters(&x)[0];
        assert!((found - deming).abs() < 1e-6, "{found} {deming}");
    }
}
