//! Which states are independent of each other, possibly after a change of basis.

use nalgebra::DMatrix;

use crate::error::FilterError;
use crate::state_space::AnyStateSpace;

/// Block structure that a state space declares.
#[derive(Clone, Debug, PartialEq)]
pub enum Blocks {
    /// None: every state may be coupled with every other.
    Dense,
    /// In the coordinates y = M x the states fall into groups without coupling.
    ///
    /// The declaration is checked against the numbers: groups that turn out to be coupled are joined, with a reason.
    Groups {
        /// M (n x n), invertible.
        basis: DMatrix<f64>,
        /// Indices of y in each group.
        groups: Vec<Vec<usize>>,
    },
}

/// Why declared groups had to be joined.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Coupling {
    /// The state space declares no groups.
    NotDeclared,
    /// The dynamics couple them.
    Dynamics(usize, usize),
    /// The process noise couples them (for the robot: different q_F on the two sides).
    ProcessNoise(usize, usize),
    /// The prior couples them.
    Prior(usize, usize),
    /// One channel sees both.
    Channel(usize, usize, usize),
    /// The noise of two channels is correlated.
    MeasurementNoise(usize, usize),
}

impl std::fmt::Display for Coupling {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Coupling::NotDeclared => write!(f, "the state space declares no groups"),
            Coupling::Dynamics(a, b) => write!(f, "the dynamics couple groups {a} and {b}"),
            Coupling::ProcessNoise(a, b) => {
                write!(f, "the process noise couples groups {a} and {b}")
            }
            Coupling::Prior(a, b) => write!(f, "the prior couples groups {a} and {b}"),
            Coupling::Channel(c, a, b) => write!(f, "channel {c} sees groups {a} and {b}"),
            Coupling::MeasurementNoise(a, b) => {
                write!(f, "the noise of channels {a} and {b} is correlated")
            }
        }
    }
}

/// Basis, its inverse and the groups.
#[derive(Clone, Debug)]
pub(crate) struct Structure {
    pub(crate) basis: DMatrix<f64>,
    pub(crate) inverse: DMatrix<f64>,
    pub(crate) groups: Vec<Vec<usize>>,
}

impl Structure {
    pub(crate) fn new(blocks: Blocks, n: usize) -> Result<Self, FilterError> {
        let Blocks::Groups { basis, groups } = blocks else {
            let one = DMatrix::identity(n, n);
            return Ok(Structure {
                basis: one.clone(),
                inverse: one,
                groups: vec![(0..n).collect()],
            });
        };
        let mut seen: Vec<usize> = groups.iter().flatten().copied().collect();
        seen.sort_unstable();
        if basis.shape() != (n, n) || seen != (0..n).collect::<Vec<_>>() {
            return Err(FilterError::Size {
                what: "declared block structure",
                expected: n,
                found: seen.len(),
            });
        }
        let inverse = basis
            .clone()
            .try_inverse()
            .ok_or(FilterError::NotACovariance {
                what: "basis of the block structure",
                reason: "singular",
                value: 0.0,
            })?;
        Ok(Structure {
            basis,
            inverse,
            groups,
        })
    }

    /// The groups that really are independent under `prior`, and what joined declared ones.
    pub(crate) fn of(
        space: &dyn AnyStateSpace,
        prior: &DMatrix<f64>,
    ) -> Result<(Self, Vec<Coupling>), FilterError> {
        let blocks = space.blocks();
        let declared = blocks != Blocks::Dense;
        let mut structure = Structure::new(blocks, space.dims().state)?;
        if !declared {
            return Ok((structure, vec![Coupling::NotDeclared]));
        }
        let (a, c) = space.system_matrices()?;
        let reasons = structure.uncouple(
            &a,
            &space.process_noise(),
            prior,
            &c,
            &space.measurement_noise(),
        );
        Ok((structure, reasons))
    }

    /// The group that a row of C (in the coordinates of x) sees; the first one it touches.
    pub(crate) fn group_of_channel(&self, c: &DMatrix<f64>, channel: usize) -> usize {
        let in_basis = c.row(channel) * &self.inverse;
        let touches = |g: &Vec<usize>| {
            g.iter()
                .any(|&i| in_basis[i].abs() > 1e-12 * in_basis.amax())
        };
        self.groups.iter().position(touches).unwrap_or(0)
    }

    /// Joins groups until none is coupled; says what joined them.
    pub(crate) fn uncouple(
        &mut self,
        a: &DMatrix<f64>,
        q: &DMatrix<f64>,
        prior: &DMatrix<f64>,
        c: &DMatrix<f64>,
        r: &DMatrix<f64>,
    ) -> Vec<Coupling> {
        let mut reasons = Vec::new();
        let a = &self.basis * a * &self.inverse;
        let q = &self.basis * q * self.basis.transpose();
        let p = &self.basis * prior * self.basis.transpose();
        let c = c * &self.inverse;
        let mut label = vec![0; a.nrows()];
        for (g, group) in self.groups.iter().enumerate() {
            for &i in group {
                label[i] = g;
            }
        }
        let join = |label: &mut Vec<usize>, x: usize, y: usize| {
            let (keep, drop) = (label[x].min(label[y]), label[x].max(label[y]));
            for l in label.iter_mut().filter(|l| **l == drop) {
                *l = keep;
            }
        };
        // Exact zeros survive the change of basis only to rounding.
        let n = a.nrows();
        for i in 0..n {
            for j in 0..n {
                if label[i] == label[j] {
                    continue;
                }
                let pair = (label[i], label[j]);
                let correlated =
                    |m: &DMatrix<f64>| m[(i, j)].abs() > 1e-13 * (m[(i, i)] * m[(j, j)]).sqrt();
                let reason = if a[(i, j)].abs() > 1e-13 * a.amax() {
                    Coupling::Dynamics(pair.0, pair.1)
                } else if correlated(&q) {
                    Coupling::ProcessNoise(pair.0, pair.1)
                } else if correlated(&p) {
                    Coupling::Prior(pair.0, pair.1)
                } else {
                    continue;
                };
                reasons.push(reason);
                join(&mut label, i, j);
            }
        }
        let sees = |row: usize| -> Vec<usize> {
            let big = 1e-13 * c.row(row).amax();
            (0..n).filter(|&i| c[(row, i)].abs() > big).collect()
        };
        for row in 0..c.nrows() {
            let seen = sees(row);
            for pair in seen.windows(2) {
                if label[pair[0]] != label[pair[1]] {
                    reasons.push(Coupling::Channel(row, label[pair[0]], label[pair[1]]));
                    join(&mut label, pair[0], pair[1]);
                }
            }
            for other in 0..row {
                let (Some(&x), Some(&y)) = (seen.first(), sees(other).first()) else {
                    continue;
                };
                // Correlated channels of one group would spoil the scalar updates as well.
                if r[(row, other)] != 0.0 {
                    reasons.push(Coupling::MeasurementNoise(other, row));
                    join(&mut label, x, y);
                }
            }
        }
        let mut names: Vec<usize> = label.clone();
        names.sort_unstable();
        names.dedup();
        self.groups = names
            .iter()
            .map(|&g| (0..n).filter(|&i| label[i] == g).collect())
            .collect();
        reasons
    }
}
