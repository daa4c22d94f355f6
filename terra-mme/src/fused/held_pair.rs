//! A held sample as users have it most: one wheel, two rows, each one force ([`Pair`]), and the load of the sample before. It is
//! made straight from slip and forces, without a copy; whatever is not so usual is `None` here and goes the way of any sample,
//! which also says what is wrong.
//!
//! # Equation
//! g_k,a = s_k W^p_k l_a(slip), p_k = 1 of drawbar pull and torque; y_k times the diagonal of the whitening.

use super::grid::GridTable;
use super::held::{BEYOND, Term, Whiten};
use super::kernel::Group;
use super::pair::Pair;
use super::slice::Slices;

/// What is held of such a sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeldPair {
    /// The force of each row.
    terms: [Term; 2],
    /// The diagonal of the whitening.
    own: [f64; 2],
    /// What the second row takes of the first.
    cross: f32,
}

impl HeldPair {
    /// Of a map with these numbers of rows and wheels.
    pub(super) fn of(terms: &[Term], whiten: &Whiten, sizes: (usize, usize)) -> Option<Self> {
        let ((2, 1), [a, b]) = (sizes, terms) else {
            return None;
        };
        let terms = match (a.row, b.row) {
            (0, 1) => [*a, *b],
            (1, 0) => [*b, *a],
            _ => return None,
        };
        Some(HeldPair {
            terms,
            own: [whiten.own[0], whiten.own[1]],
            cross: whiten.above[1][0],
        })
    }

    /// What hypotheses share at a sample.
    #[inline]
    pub(super) fn at(
        &self,
        slips_and_loads: &[(f64, f64)],
        forces: &[f64],
        table: &GridTable,
        slices: &Slices,
    ) -> Option<Pair> {
        let (&[(slip, load)], &[y, z]) = (slips_and_loads, forces) else {
            return None;
        };
        let slice = slices.same(load)?;
        let (first, along) = table.slip_weights(slip)?;
        let group = |term: &Term| {
            let block = slices.at_hand(slice, table, first, term.output)?;
            Some(Group::sliced(slice, block, &along, term.share_at(load)))
        };
        let [a, b] = &self.terms;
        let pair = Pair {
            groups: [group(a)?, group(b)?],
            observed: [(y * self.own[0]) as f32, (z * self.own[1]) as f32],
            cross: self.cross,
        };
        let told = |y: f32| y.abs() < BEYOND as f32;
        pair.observed.into_iter().all(told).then_some(pair)
    }
}
