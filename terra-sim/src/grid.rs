//! Four smooth functions of slip and load, as polynomials between nodes.
//!
//! Nodes are evenly spaced in slip and in ln W. Between them stands the tensor product of Lagrange polynomials of degree 5.
//! Slip below and above 0 never share a polynomial, because braking and driving meet there with a kink. Nodes of one load
//! lie in a row of their own that is made when first needed, so that a look-up reads six short contiguous pieces and hashes
//! nothing.

/// How far apart nodes are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spacing {
    /// Cells of slip on each side of 0.
    pub(crate) slip_cells: usize,
    /// Step of ln W.
    pub(crate) load_step: f64,
}

/// ln W of the first row, and the span from there: from e^-9 N to e^18 N, beyond any wheel.
const LOWEST: f64 = -9.0;
const SPAN: f64 = 27.0;
/// Nodes of a polynomial.
const POINTS: usize = 6;
/// Nodes before the cell's own.
const REACH: usize = POINTS / 2 - 1;

impl Spacing {
    fn load_cells(&self) -> usize {
        (SPAN / self.load_step) as usize
    }

    fn slip_step(&self) -> f64 {
        1.0 / self.slip_cells as f64
    }

    /// The first slip node of a cell's stencil.
    fn first(&self, slip_cell: usize) -> usize {
        slip_cell
            .saturating_sub(REACH)
            .min(self.slip_cells + 1 - POINTS)
    }

    /// The cell of |slip| <= 1 and ln W.
    #[inline]
    pub(crate) fn cell(&self, slip: f64, ln_load: f64) -> Cell {
        let x = slip.abs() * self.slip_cells as f64;
        let slip_cell = (x as usize).min(self.slip_cells - 1);
        let y = (ln_load - LOWEST) / self.load_step;
        let inside = y >= REACH as f64 && y < (self.load_cells() - POINTS) as f64;
        Cell {
            spacing: *self,
            braking: slip < 0.0,
            slip_cell,
            load_cell: inside.then_some(y as usize),
            at: (x, y),
        }
    }
}

/// Values at one node.
pub(crate) type Node = [f64; 4];

/// A node that nobody asked for yet: not finite, so that no sum over it is.
const UNKNOWN: Node = [f64::INFINITY; 4];
/// A node without values.
const NOTHING: Node = [f64::NAN; 4];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trust {
    Unknown,
    Yes,
    No,
}

/// The nodes of one load, and the cells above them.
#[derive(Clone, Debug)]
struct Row {
    /// Of driving, then of braking.
    nodes: Vec<Node>,
    trust: Vec<Trust>,
}

impl Row {
    fn new(slip_cells: usize) -> Self {
        Row {
            nodes: vec![UNKNOWN; 2 * (slip_cells + 1)],
            trust: vec![Trust::Unknown; 2 * slip_cells],
        }
    }
}

/// Where a contact lies: its cell, and its place in units of the spacing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    spacing: Spacing,
    braking: bool,
    slip_cell: usize,
    load_cell: Option<usize>,
    at: (f64, f64),
}

impl Cell {
    /// Slip and load in the middle.
    pub(crate) fn middle(&self) -> (f64, f64) {
        let slip = (self.slip_cell as f64 + 0.5) * self.spacing.slip_step();
        let ln_load = (self.load_cell.unwrap_or(0) as f64 + 0.5) * self.spacing.load_step + LOWEST;
        (if self.braking { -slip } else { slip }, ln_load.exp())
    }

    /// Index of the first node in its row.
    fn node(&self) -> usize {
        self.spacing.first(self.slip_cell)
            + usize::from(self.braking) * (self.spacing.slip_cells + 1)
    }

    fn trust(&self) -> usize {
        self.slip_cell + usize::from(self.braking) * self.spacing.slip_cells
    }
}

/// The table.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    spacing: Spacing,
    rows: Vec<Option<Box<Row>>>,
}

impl Grid {
    /// Without nodes.
    pub(crate) fn new(spacing: Spacing) -> Self {
        Grid {
            spacing,
            rows: Vec::new(),
        }
    }

    /// The cell of |slip| <= 1 and ln W.
    pub(crate) fn cell(&self, slip: f64, ln_load: f64) -> Cell {
        self.spacing.cell(slip, ln_load)
    }

    /// What was decided about a cell; none before [`Grid::trust`].
    #[inline]
    pub(crate) fn trusted(&self, cell: &Cell) -> Option<bool> {
        let row = self.rows.get(cell.load_cell?)?.as_ref()?;
        match row.trust.get(cell.trust())? {
            Trust::Unknown => None,
            Trust::Yes => Some(true),
            Trust::No => Some(false),
        }
    }

    /// Decides about a cell.
    pub(crate) fn trust(&mut self, cell: &Cell, trusted: bool) {
        if let Some(load_cell) = cell.load_cell
            && let Some(row) = self.row(load_cell)
            && let Some(slot) = row.trust.get_mut(cell.trust())
        {
            *slot = if trusted { Trust::Yes } else { Trust::No };
        }
    }

    fn row(&mut self, load_cell: usize) -> Option<&mut Row> {
        if self.rows.is_empty() {
            self.rows
                .resize_with(self.spacing.load_cells() + 1, || None);
        }
        let row = self.rows.get_mut(load_cell)?;
        let slip_cells = self.spacing.slip_cells;
        Some(row.get_or_insert_with(|| Box::new(Row::new(slip_cells))))
    }

    /// Asks `value` for the nodes of a cell's stencil that nobody asked for yet.
    pub(crate) fn fill(&mut self, cell: &Cell, mut value: impl FnMut(f64, f64) -> Option<Node>) {
        let Some(load_cell) = cell.load_cell else {
            return;
        };
        let sign = if cell.braking { -1.0 } else { 1.0 };
        let Spacing { load_step, .. } = self.spacing;
        let slip_step = self.spacing.slip_step();
        let (node, from) = (cell.node(), self.spacing.first(cell.slip_cell));
        for j in load_cell - REACH..load_cell - REACH + POINTS {
            let load = (j as f64 * load_step + LOWEST).exp();
            let Some(nodes) = self
                .row(j)
                .and_then(|r| r.nodes.get_mut(node..node + POINTS))
            else {
                return;
            };
            for (i, slot) in (from..).zip(nodes) {
                if *slot == UNKNOWN {
                    *slot = value(sign * i as f64 * slip_step, load).unwrap_or(NOTHING);
                }
            }
        }
    }

    /// The polynomial; none unless all its nodes have values.
    #[inline]
    pub(crate) fn value(&self, cell: &Cell) -> Option<Node> {
        let (node, load_cell) = (cell.node(), cell.load_cell?);
        let (x, y) = cell.at;
        let over_slip = lagrange(x - self.spacing.first(cell.slip_cell) as f64);
        let over_load = lagrange(y - (load_cell - REACH) as f64);
        let rows = self
            .rows
            .get(load_cell - REACH..load_cell - REACH + POINTS)?;
        let mut sum = [0.0; 4];
        for (row, along_load) in rows.iter().zip(over_load) {
            let nodes = row.as_ref()?.nodes.get(node..node + POINTS)?;
            let mut line = [0.0; 4];
            for (value, weight) in nodes.iter().zip(over_slip) {
                for (l, v) in line.iter_mut().zip(value) {
                    *l += weight * v;
                }
            }
            for (s, l) in sum.iter_mut().zip(line) {
                *s += along_load * l;
            }
        }
        sum[0].is_finite().then_some(sum)
    }
}

/// Weights of nodes 0, 1, ..., 5 at x: products of what lies left and right of each, over k! (5 - k)! with its sign.
#[inline]
fn lagrange(x: f64) -> [f64; POINTS] {
    const OVER: [f64; POINTS] = [
        -1.0 / 120.0,
        1.0 / 24.0,
        -1.0 / 12.0,
        1.0 / 12.0,
        -1.0 / 24.0,
        1.0 / 120.0,
    ];
    let d: [f64; POINTS] = std::array::from_fn(|k| x - k as f64);
    let mut weights = OVER;
    let (mut left, mut right) = (1.0, 1.0);
    for k in 0..POINTS {
        weights[k] *= left;
        left *= d[k];
        weights[POINTS - 1 - k] *= right;
        right *= d[POINTS - 1 - k];
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    const FINE: Spacing = Spacing {
        slip_cells: 64,
        load_step: 0.05,
    };

    /// A polynomial of degree 5 in slip and ln W is met exactly, on both sides of a kink at slip 0.
    #[test]
    fn polynomials_of_its_degree_are_exact() {
        let f = |slip: f64, load: f64| {
            let (s, y) = (slip, load.ln() - 5.5);
            let bend = if s < 0.0 { 3.0 } else { 1.0 };
            [
                (1.0 + bend * s - 2.0 * s.powi(5)) * (1.0 + y.powi(5)),
                s * y,
                1.0 - y * y * s.powi(3),
                bend * s,
            ]
        };
        let mut grid = Grid::new(FINE);
        for (slip, load) in [
            (0.0, 245.0),
            (0.003, 187.3),
            (0.5, 251.0),
            (0.999, 310.0),
            (1.0, 245.25),
            (-0.003, 187.3),
            (-1.0, 401.0),
        ] {
            let cell = FINE.cell(slip, f64::ln(load));
            assert_eq!(grid.trusted(&cell), None);
            grid.fill(&cell, |slip, load| Some(f(slip, load)));
            grid.trust(&cell, true);
            assert_eq!(grid.trusted(&cell), Some(true));
            let (near, exact) = (grid.value(&cell).unwrap(), f(slip, load));
            for (a, b) in near.iter().zip(exact) {
                assert!(
                    (a - b).abs() < 1e-12 * (1.0 + b.abs()),
                    "{slip} {load}: {a} {b}"
                );
            }
        }
    }

    #[test]
    fn a_missing_node_silences_its_cells_alone() {
        let mut grid = Grid::new(FINE);
        let hole = |slip: f64, _: f64| (slip < 0.5).then_some([slip; 4]);
        for (slip, answers) in [(0.2, true), (0.495, false), (0.6, false)] {
            let cell = FINE.cell(slip, 245f64.ln());
            grid.fill(&cell, hole);
            assert_eq!(grid.value(&cell).is_some(), answers, "{slip}");
        }
    }

    /// Loads that no wheel carries have no cell.
    #[test]
    fn beyond_the_table_there_is_no_answer() {
        for load in [1e-5, 1e9] {
            let cell = FINE.cell(0.2, f64::ln(load));
            let mut grid = Grid::new(FINE);
            grid.fill(&cell, |_, _| Some([1.0; 4]));
            assert!(grid.value(&cell).is_none() && grid.trusted(&cell).is_none());
        }
    }
}
