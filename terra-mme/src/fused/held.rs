//! What a caller may keep from sample to sample: with the covariance and the map fixed, a sample is slips, loads and forces.

use std::f64::consts::LOG2_E;

use super::grid::{ALONG, GridTable, LANES, OUTPUTS};
use super::held_pair::HeldPair;
use super::kernel::{Group, ROWS, Sample};
use super::shared::Columns;
use super::slice::Slices;
use crate::error::EstimatorError;

/// S of one observation, factored, and its map: see [`FusedModel::hold`](super::FusedModel::hold).
#[derive(Clone, Debug)]
pub struct HeldCovariance {
    pub(super) wheels: usize,
    pub(super) rows: usize,
    /// ln N(0; 0, S).
    pub(super) constant: f64,
    whiten: Whiten,
    terms: Vec<Term>,
    /// The same where it is one wheel's two forces.
    pub(super) pair: Option<HeldPair>,
}

/// A force that a row looks at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Term {
    pub(super) row: usize,
    wheel: usize,
    pub(super) output: usize,
    /// What the row takes of the tabulated number, times its load where it grows with that.
    share: f64,
    grows: bool,
}

impl Term {
    /// What the row takes of the tabulated number under a load \[N\].
    #[inline]
    pub(super) fn share_at(&self, load: f64) -> f64 {
        self.share * if self.grows { load } else { 1.0 }
    }
}

/// Standard deviations from which single precision tells nothing apart, and its squares soon overflow.
pub(super) const BEYOND: f64 = 1e6;

/// A force that single precision can weigh, given the diagonal of the whitening at its row.
///
/// # Errors
/// [`EstimatorError::Value`].
#[inline]
pub(super) fn bounded(force: f64, own: f64) -> Result<(), EstimatorError> {
    if (force * own).abs() < BEYOND {
        return Ok(());
    }
    Err(EstimatorError::Value {
        what: "force".to_owned(),
        value: force,
        expected: "a finite number within a million standard deviations",
    })
}

/// L⁻¹ to base 2, as rows of a sample take it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whiten {
    /// L⁻¹ sqrt(log2(e)/2), its diagonal.
    pub(super) own: [f64; ROWS],
    /// What a row takes of those above it, each times its own.
    pub(super) above: [[f32; LANES]; ROWS],
}

impl Whiten {
    /// Of L⁻¹, row by row, the first m.
    pub(super) fn new(inverse: &Columns, m: usize) -> Self {
        let to_base_2 = (0.5 * LOG2_E).sqrt();
        let (mut own, mut above) = ([0.0; ROWS], [[0.0; LANES]; ROWS]);
        for k in 0..m {
            own[k] = inverse[k][k] * to_base_2;
            for j in 0..k {
                above[k][j] = (inverse[k][j] / inverse[j][j]) as f32;
            }
        }
        Whiten { own, above }
    }
}

impl HeldCovariance {
    /// `columns`: of the map, wheel by wheel, D, T and z.
    pub(super) fn new<'a>(
        inverse: &Columns,
        (rows, wheels): (usize, usize),
        constant: f64,
        radius: f64,
        columns: impl Iterator<Item = &'a [f64]>,
    ) -> Self {
        let whiten = Whiten::new(inverse, rows);
        let mut terms = vec![];
        for (column, a) in columns.enumerate() {
            let (wheel, output) = (column / OUTPUTS, column % OUTPUTS);
            let scale = if output == 0 { 1.0 } else { radius };
            for (row, a) in a.iter().enumerate() {
                if *a != 0.0 {
                    terms.push(Term {
                        row,
                        wheel,
                        output,
                        share: a * scale * whiten.own[row],
                        grows: output < 2,
                    });
                }
            }
        }
        HeldCovariance {
            wheels,
            rows,
            constant,
            pair: HeldPair::of(&terms, &whiten, (rows, wheels)),
            whiten,
            terms,
        }
    }

    /// Sizes agree and forces can be weighed; slips and loads are asked about by the table.
    #[inline]
    pub(super) fn check(&self, at: &[(f64, f64)], forces: &[f64]) -> Result<(), EstimatorError> {
        for (what, found, expected) in [
            ("slips and loads", at.len(), self.wheels),
            ("forces", forces.len(), self.rows),
        ] {
            if found != expected {
                return Err(EstimatorError::Size {
                    what,
                    found,
                    expected,
                });
            }
        }
        let mut each = forces.iter().zip(&self.whiten.own);
        each.try_for_each(|(y, own)| bounded(*y, *own))
    }

    /// What all hypotheses share at a sample of these slips and loads \[N\].
    pub(super) fn fill(
        &self,
        at: &[(f64, f64)],
        forces: &[f64],
        table: &GridTable,
        slices: &mut Slices,
        out: &mut Sample,
    ) -> Result<(), EstimatorError> {
        (out.rows, out.rho) = (self.rows, 0.0);
        let whiten = self.whiten.own.iter().zip(&self.whiten.above);
        for ((row, y), (own, above)) in out.row.iter_mut().zip(forces).zip(whiten) {
            row.groups.clear();
            row.observed = (y * own) as f32;
            row.scale = *own as f32;
            row.whiten = *above;
        }
        for (wheel, (slip, load)) in at.iter().enumerate() {
            let slice = slices.find(*load);
            // A slice holds the interpolation along its load.
            let (first, along, stencil) = match slice {
                Some(_) => {
                    let (first, weight, _) = table.along_slip(*slip)?;
                    (first, weight, None)
                }
                None => (0, [0.0; ALONG], Some(table.at(*slip, *load)?)),
            };
            for term in self.terms.iter().filter(|t| t.wheel == wheel) {
                let share = term.share_at(*load);
                let groups = &mut out.row[term.row].groups;
                if let Some(stencil) = &stencil {
                    stencil.groups(term.output, share, groups);
                } else if let Some(k) = slice {
                    let block = slices.ready(k, table, first, term.output);
                    groups.push(Group::sliced(k, block, &along, share));
                }
            }
        }
        Ok(())
    }
}
