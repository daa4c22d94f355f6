//! What a set of slips and loads could tell, before anything is measured, and which further rows would tell more.
//!
//! # Equation
//! A row measures y = f(s, W; p) + noise of the channels, slip and load themselves being noisy:
//! S = diag(sd²) + G diag(sd_s², sd_W²) Gᵀ, S = L Lᵀ, and J = L⁻¹ ∂f/∂q. Fisher information Σ JᵀJ, with the prior I + Σ JᵀJ.
//! A further row is worth ln det(I + J C Jᵀ)/2 nats, C = (I + Σ JᵀJ)⁻¹. Two soils a, b are told apart by
//! Σ |L⁻¹(f_a - f_b)|²/2 nats, the mean of both directions.
//!
//! # Reference
//! V. V. Fedorov, *Theory of Optimal Experiments*, Academic Press 1972 (D-optimal designs, one row at a time).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use terra_model::{Contact, ForceLaw, Law, ModelError};

use crate::error::EstimatorError;
use crate::fit_space::FitSpace;

/// Nats by which a row tells two soils apart of which only one can carry its load.
const ONE_CANNOT: f64 = 10.0;

/// Which channels are measured, and how well (1-sigma).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DesignNoise {
    /// \[N\]; none: not measured.
    pub drawbar_pull: Option<f64>,
    /// \[N m\].
    pub torque: Option<f64>,
    /// \[m\].
    pub sinkage: Option<f64>,
    /// Of the slip itself.
    pub slip: f64,
    /// Of the load itself \[N\].
    pub normal_load: f64,
}

impl DesignNoise {
    /// Rows of a law's Jacobian that are measured, with their sd.
    fn channels(&self) -> Vec<(usize, f64)> {
        [self.drawbar_pull, self.torque, self.sinkage]
            .into_iter()
            .enumerate()
            .filter_map(|(row, sd)| Some((row, sd?)))
            .collect()
    }

    fn check(&self) -> Result<(), EstimatorError> {
        if self.channels().is_empty() {
            return Err(EstimatorError::Size {
                what: "measured channels",
                found: 0,
                expected: 1,
            });
        }
        let inputs = [self.slip, self.normal_load];
        let bad = |v: &f64| !(v.is_finite() && *v >= 0.0);
        let channel = self.channels().into_iter().map(|c| c.1);
        if let Some(value) = channel
            .clone()
            .find(|v| bad(v) || *v == 0.0)
            .or_else(|| inputs.into_iter().find(bad))
        {
            return Err(EstimatorError::Value {
                what: "noise".to_owned(),
                value,
                expected: "a finite sd above 0, of slip and load at least 0",
            });
        }
        Ok(())
    }
}

/// One law around one soil, measured in some channels.
#[derive(Clone, Debug)]
pub struct Design<'a> {
    law: &'a Law,
    space: &'a FitSpace,
    noise: DesignNoise,
}

/// A further row and what it is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FurtherRow {
    /// Its place among the candidates.
    pub candidate: usize,
    /// Nats it adds, after those chosen before it.
    pub nats: f64,
}

/// Measured forces at one contact, with slopes in q and in slip and load.
pub(crate) struct Local {
    pub(crate) forces: DVector<f64>,
    pub(crate) jacobian: DMatrix<f64>,
    inputs: DMatrix<f64>,
}

impl<'a> Design<'a> {
    /// A design on a law, with parameters in the coordinates of a space.
    ///
    /// # Errors
    /// [`EstimatorError::Size`] without a channel, [`EstimatorError::Value`] for noise that is none.
    pub fn new(
        law: &'a Law,
        space: &'a FitSpace,
        noise: DesignNoise,
    ) -> Result<Self, EstimatorError> {
        noise.check()?;
        Ok(Design { law, space, noise })
    }

    pub(crate) fn space(&self) -> &FitSpace {
        self.space
    }

    /// None where the soil cannot carry the load.
    pub(crate) fn local(
        &self,
        q: &[f64],
        at: &Contact<f64>,
    ) -> Result<Option<Local>, EstimatorError> {
        let p = self.space.parameters(q);
        let Some((forces, jac, inputs)) = measured(self.law, &self.noise, &p, at)? else {
            return Ok(None);
        };
        Ok(Some(Local {
            forces,
            jacobian: jac * self.space.jacobian(q),
            inputs,
        }))
    }

    pub(crate) fn factor(&self, local: &Local) -> Result<Cholesky<f64, Dyn>, EstimatorError> {
        factor(&self.noise, &local.inputs)
    }

    /// Whitened Jacobian (rows x dim of the space) of contacts at q, for [`identifiability`](crate::identifiability), and
    /// the number of contacts that the soil cannot carry.
    ///
    /// # Errors
    /// [`EstimatorError::Model`] for contacts out of range; [`EstimatorError::NoSinkage`].
    pub fn jacobian(
        &self,
        q: &[f64],
        contacts: &[Contact<f64>],
    ) -> Result<(DMatrix<f64>, usize), EstimatorError> {
        let mut blocks = vec![];
        let mut infeasible = 0;
        for at in contacts {
            match self.block(q, at)? {
                Some(block) => blocks.push(block),
                None => infeasible += 1,
            }
        }
        Ok((stacked(&blocks, self.space.dim()), infeasible))
    }

    fn block(&self, q: &[f64], at: &Contact<f64>) -> Result<Option<DMatrix<f64>>, EstimatorError> {
        let Some(local) = self.local(q, at)? else {
            return Ok(None);
        };
        let factor = self.factor(&local)?;
        Ok(factor.l().solve_lower_triangular(&local.jacobian))
    }

    /// The `count` candidates that together determine the parameters best, chosen one after the other.
    ///
    /// # Errors
    /// As [`jacobian`](Self::jacobian).
    pub fn more_rows(
        &self,
        q: &[f64],
        contacts: &[Contact<f64>],
        candidates: &[Contact<f64>],
        count: usize,
    ) -> Result<Vec<FurtherRow>, EstimatorError> {
        let n = self.space.dim();
        let (jac, _) = self.jacobian(q, contacts)?;
        let mut information = DMatrix::identity(n, n) + jac.transpose() * jac;
        let blocks = candidates
            .iter()
            .map(|at| self.block(q, at))
            .collect::<Result<Vec<_>, _>>()?;
        let mut chosen = vec![];
        for _ in 0..count {
            let Some(covariance) = Cholesky::new(information.clone()).map(|c| c.inverse()) else {
                break;
            };
            let gain = |b: &DMatrix<f64>| {
                let rows = b.nrows();
                let inner = DMatrix::identity(rows, rows) + b * &covariance * b.transpose();
                Cholesky::new(inner).map_or(0.0, |c| {
                    c.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>()
                })
            };
            let best = blocks
                .iter()
                .enumerate()
                .filter_map(|(k, b)| Some((k, b.as_ref()?)))
                .map(|(k, b)| (k, gain(b), b))
                .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
            let Some((candidate, nats, block)) = best else {
                break;
            };
            information += block.transpose() * block;
            chosen.push(FurtherRow { candidate, nats });
        }
        Ok(chosen)
    }
}

/// Nats by which one contact tells two soils of one law apart.
///
/// # Errors
/// As [`Design::jacobian`].
pub fn separation(
    law: &Law,
    noise: &DesignNoise,
    [a, b]: [&[f64]; 2],
    at: &Contact<f64>,
) -> Result<f64, EstimatorError> {
    noise.check()?;
    match (measured(law, noise, a, at)?, measured(law, noise, b, at)?) {
        (Some(a), Some(b)) => {
            let apart = &a.0 - &b.0;
            let mut nats = 0.0;
            for inputs in [&a.2, &b.2] {
                let white = factor(noise, inputs)?.l().solve_lower_triangular(&apart);
                nats += 0.25 * white.map_or(0.0, |w| w.norm_squared());
            }
            Ok(nats)
        }
        (None, None) => Ok(0.0),
        _ => Ok(ONE_CANNOT),
    }
}

/// The `count` rows of a table (pair x candidate, nats) that lift the pair told apart least from where it `stands`, one
/// after the other; the nats are those of the worst pair after each.
pub fn separating_rows(stands: &[f64], table: &DMatrix<f64>, count: usize) -> Vec<FurtherRow> {
    let mut stands = stands.to_vec();
    let mut chosen = vec![];
    for _ in 0..count {
        let worst = |candidate: usize| {
            let after = stands.iter().enumerate();
            after
                .map(|(pair, s)| s + table.get((pair, candidate)).copied().unwrap_or(0.0))
                .fold(f64::INFINITY, f64::min)
        };
        let best = (0..table.ncols())
            .map(|k| (k, worst(k)))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        let Some((candidate, nats)) = best else {
            break;
        };
        for (pair, s) in stands.iter_mut().enumerate() {
            *s += table.get((pair, candidate)).copied().unwrap_or(0.0);
        }
        chosen.push(FurtherRow { candidate, nats });
    }
    chosen
}

type Measured = (DVector<f64>, DMatrix<f64>, DMatrix<f64>);

/// Forces in the measured channels, slopes in the parameters, slopes in slip and load.
fn measured(
    law: &Law,
    noise: &DesignNoise,
    p: &[f64],
    at: &Contact<f64>,
) -> Result<Option<Measured>, EstimatorError> {
    let (f, jac) = match law.jacobian(p, at) {
        Ok(found) => found,
        Err(ModelError::NoEquilibrium { .. }) => return Ok(None),
        Err(e) => return Err(e.into()),
    };
    if noise.sinkage.is_some() && f.sinkage.is_none() {
        return Err(EstimatorError::NoSinkage {
            hypothesis: "design".to_owned(),
            model: law.model().name().to_owned(),
        });
    }
    let values = [
        f.drawbar_pull,
        f.resistive_torque,
        f.sinkage.unwrap_or_default(),
    ];
    let rows: Vec<usize> = noise.channels().into_iter().map(|c| c.0).collect();
    let forces = rows.iter().filter_map(|r| values.get(*r).copied());
    let all = jac.select_rows(&rows);
    let n = p.len();
    Ok(Some((
        DVector::from_vec(forces.collect()),
        all.columns(0, n).into_owned(),
        all.columns(n, 2).into_owned(),
    )))
}

fn factor(
    noise: &DesignNoise,
    inputs: &DMatrix<f64>,
) -> Result<Cholesky<f64, Dyn>, EstimatorError> {
    let channels = noise.channels();
    let variance = DVector::from_vec(channels.iter().map(|c| c.1 * c.1).collect());
    let spread = DVector::from_vec(vec![noise.slip.powi(2), noise.normal_load.powi(2)]);
    let s = DMatrix::from_diagonal(&variance)
        + inputs * DMatrix::from_diagonal(&spread) * inputs.transpose();
    Cholesky::new(s).ok_or(EstimatorError::Decomposition {
        what: "covariance of a design row",
    })
}

fn stacked(blocks: &[DMatrix<f64>], columns: usize) -> DMatrix<f64> {
    let rows = blocks.iter().map(DMatrix::nrows).sum();
    let mut all = DMatrix::zeros(rows, columns);
    let mut at = 0;
    for block in blocks {
        all.rows_mut(at, block.nrows()).copy_from(block);
        at += block.nrows();
    }
    all
}

#[cfg(test)]
mod tests {
    use terra_model::{Registry, catalogue};

    use super::*;
    use crate::identifiability::identifiability;
    use crate::prior::{Centre, Priors};
    use crate::profile::profiles;

    fn law() -> Law {
        Registry::builtin().law("wong-reece").unwrap()
    }

    fn space(law: &Law, id: &str, widths: &[f64]) -> FitSpace {
        let terrain = catalogue::find(id).unwrap();
        FitSpace::new(law, Centre::Terrain(terrain), widths, &Priors::default()).unwrap()
    }

    fn sweep(loads: &[f64], width: f64) -> Vec<Contact<f64>> {
        let slips = [0.05, 0.2, 0.35, 0.5, 0.65, 0.8];
        loads
            .iter()
            .flat_map(|w| slips.map(|s| Contact::new(s, *w, 0.254, width)))
            .collect()
    }

    const NOISE: DesignNoise = DesignNoise {
        drawbar_pull: Some(0.5),
        torque: Some(0.1),
        sinkage: None,
        slip: 0.0,
        normal_load: 0.0,
    };

    /// J has no column that two widths would need: one width knows the sum alone, two know both, and a second load adds
    /// what one load cannot tell.
    #[test]
    fn widths_and_loads_lift_the_rank() {
        let law = law();
        let rank = |loads: &[f64], widths: &[f64]| {
            let space = space(&law, "dry_sand", widths);
            let design = Design::new(&law, &space, NOISE).unwrap();
            let rows: Vec<_> = widths.iter().flat_map(|b| sweep(loads, *b)).collect();
            let q = vec![0.0; space.dim()];
            let (jac, infeasible) = design.jacobian(&q, &rows).unwrap();
            assert_eq!((jac.nrows(), infeasible), (2 * rows.len(), 0));
            identifiability(&space, &q, &jac).unwrap()
        };
        let one = rank(&[245.25], &[0.15]);
        let loads = rank(&[150.0, 450.0], &[0.15]);
        let widths = rank(&[150.0, 450.0], &[0.1, 0.2]);
        assert_eq!(one.rank, 5, "{:?}", one.undetermined);
        assert!(loads.rank > one.rank);
        let sum = "k_c, k_phi only through k_c/b + k_phi";
        assert!(one.undetermined.iter().any(|u| u == sum));
        assert!(widths.undetermined.iter().all(|u| u != sum));
        let names = ["cohesion", "friction_angle"];
        let trade = one
            .undetermined
            .iter()
            .any(|u| names.iter().all(|n| u.contains(n)));
        assert!(
            trade,
            "c and φ trade off at one load: {:?}",
            one.undetermined
        );
    }

    /// With one channel and exact inputs: (D_a - D_b)²/(2 sd²).
    #[test]
    fn separation_is_half_the_squared_distance() {
        let law = law();
        let of = |id: &str| {
            catalogue::find(id)
                .unwrap()
                .parameters(law.model())
                .unwrap()
        };
        let at = Contact::new(0.3, 245.25, 0.254, 0.15);
        let noise = DesignNoise {
            torque: None,
            ..NOISE
        };
        let (a, b) = (of("dry_sand"), of("lean_clay_22"));
        let apart =
            law.forces(&a, &at).unwrap().drawbar_pull - law.forces(&b, &at).unwrap().drawbar_pull;
        let nats = separation(&law, &noise, [&a, &b], &at).unwrap();
        assert!((nats / (0.5 * (apart / 0.5).powi(2)) - 1.0).abs() < 1e-12);
        // Slip that is only known to .02 tells less.
        let blurred = DesignNoise {
            slip: 0.02,
            ..noise
        };
        assert!(separation(&law, &blurred, [&a, &b], &at).unwrap() < nats);
        // Snow at a load it cannot carry at high slip, which sand can.
        let at = Contact::new(0.9, 245.25, 0.254, 0.15);
        let snow = of("snow_us_harrison_1");
        assert_eq!(
            separation(&law, &noise, [&a, &snow], &at).unwrap(),
            ONE_CANNOT
        );
    }

    /// The chosen row is the one with the largest determinant of all, by brute force.
    #[test]
    fn the_first_further_row_has_the_largest_determinant() {
        let law = law();
        let space = space(&law, "upland_sandy_loam", &[0.15]);
        let design = Design::new(&law, &space, NOISE).unwrap();
        let q = vec![0.0; space.dim()];
        let rows = sweep(&[245.25], 0.15);
        let candidates = sweep(&[120.0, 500.0], 0.15);
        let ln_det = |rows: &[Contact<f64>]| {
            let (j, _) = design.jacobian(&q, rows).unwrap();
            let n = space.dim();
            (DMatrix::identity(n, n) + j.transpose() * j)
                .determinant()
                .ln()
        };
        let gains: Vec<f64> = candidates
            .iter()
            .map(|c| 0.5 * (ln_det(&[rows.clone(), vec![*c]].concat()) - ln_det(&rows)))
            .collect();
        let chosen = design.more_rows(&q, &rows, &candidates, 2).unwrap();
        let best = gains.iter().copied().fold(0.0, f64::max);
        assert!((chosen[0].nats - best).abs() < 1e-6 * best);
        assert!((gains[chosen[0].candidate] - best).abs() < 1e-12);
        assert!(chosen[1].nats <= chosen[0].nats);
    }

    /// Pairs at 0 and 1 nat: the row worth (2, 0) lifts the worst to 1, the row worth (1, 1) as well but no further, and then
    /// the other follows.
    #[test]
    fn separating_rows_lift_the_worst_pair() {
        let table = DMatrix::from_row_slice(2, 3, &[2.0, 1.0, 0.0, 0.0, 1.5, 9.0]);
        let chosen = separating_rows(&[0.0, 1.0], &table, 2);
        assert_eq!((chosen[0].candidate, chosen[0].nats), (0, 1.0));
        assert_eq!((chosen[1].candidate, chosen[1].nats), (1, 2.5));
    }

    /// Nearly linear in a narrow interval: the profile's ends are ± 1.96 sqrt((JᵀJ)⁻¹_kk).
    #[test]
    fn profiles_are_those_of_the_information_where_it_is_whole() {
        let law = law();
        let space = space(&law, "dry_sand", &[0.15]);
        let noise = DesignNoise {
            drawbar_pull: Some(5e-3),
            torque: Some(1e-3),
            sinkage: Some(1e-5),
            ..NOISE
        };
        let design = Design::new(&law, &space, noise).unwrap();
        let q = vec![0.0; space.dim()];
        let rows = sweep(&[150.0, 450.0], 0.15);
        let (jac, _) = design.jacobian(&q, &rows).unwrap();
        let covariance = (jac.transpose() * &jac).try_inverse().unwrap();
        let truth = space.physical(&q);
        for (k, profile) in profiles(&design, &q, &rows).unwrap().iter().enumerate() {
            let mut end = q.clone();
            end[k] = 1.959_964 * covariance[(k, k)].sqrt();
            let expected = space.physical(&end)[k] - truth[k];
            for found in [
                profile.high.unwrap() - truth[k],
                truth[k] - profile.low.unwrap(),
            ] {
                assert!(
                    (found / expected - 1.0).abs() < 0.03,
                    "{}: {found} {expected}",
                    profile.name
                );
            }
            assert!(profile.points.windows(2).all(|w| w[0].0 < w[1].0));
        }
        // One slip at one load sees two numbers of seven: no parameter has both ends.
        let open = profiles(&design, &q, &rows[..1]).unwrap();
        assert!(open.iter().all(|p| p.low.is_none() || p.high.is_none()));
    }

    #[test]
    fn noise_that_is_none_is_refused() {
        let law = law();
        let space = space(&law, "dry_sand", &[0.15]);
        for noise in [
            DesignNoise::default(),
            DesignNoise {
                drawbar_pull: Some(0.0),
                ..NOISE
            },
            DesignNoise {
                slip: f64::NAN,
                ..NOISE
            },
        ] {
            assert!(Design::new(&law, &space, noise).is_err(), "{noise:?}");
        }
        let hard = Registry::builtin().law("hard-ground").unwrap();
        let p = hard.model().typical_parameters().remove(0);
        let centre = Centre::Parameters(&p);
        let space = FitSpace::new(&hard, centre, &[0.15], &Priors::default()).unwrap();
        let noise = DesignNoise {
            sinkage: Some(1e-3),
            ..NOISE
        };
        let design = Design::new(&hard, &space, noise).unwrap();
        let q = vec![0.0; space.dim()];
        let refused = design.jacobian(&q, &sweep(&[245.25], 0.15));
        assert!(matches!(refused, Err(EstimatorError::NoSinkage { .. })));
    }
}
