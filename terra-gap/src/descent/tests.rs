//! Ways down whose ends are known in closed form.

use std::cell::Cell;

use super::*;

/// A long valley bent along a parabola, y = c x²: r = \[w (y - c x²), x - to\].
struct Valley {
    steep: f64,
    bend: f64,
    to: f64,
    values: Cell<usize>,
    slopes: Cell<usize>,
}

impl Valley {
    fn new(steep: f64, bend: f64, to: f64) -> Self {
        Valley {
            steep,
            bend,
            to,
            values: Cell::new(0),
            slopes: Cell::new(0),
        }
    }

    fn r(&self, x: &DVector<f64>) -> DVector<f64> {
        DVector::from_vec(vec![
            self.steep * (x[1] - self.bend * x[0] * x[0]),
            100.0 * (x[0] - self.to),
        ])
    }
}

impl Residuals for Valley {
    fn value(&self, x: &DVector<f64>) -> Result<DVector<f64>, GapError> {
        self.values.set(self.values.get() + 1);
        Ok(self.r(x))
    }

    fn slopes(&self, x: &DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), GapError> {
        self.slopes.set(self.slopes.get() + 1);
        let j = DMatrix::from_row_slice(
            2,
            2,
            &[
                2.0 * self.steep * self.bend * x[0],
                -self.steep,
                -100.0,
                0.0,
            ],
        );
        Ok((self.r(x), j))
    }
}

const WIDE: (&[f64], &[f64]) = (
    &[f64::NEG_INFINITY, f64::NEG_INFINITY],
    &[f64::INFINITY, f64::INFINITY],
);

/// The floor of the valley as a problem of one variable, found by bisection of its derivative.
fn on_the_floor(bend: f64, to: f64) -> f64 {
    // d/dx [100² (x - to)² + x² + c² x⁴] on y = c x².
    let slope = |x: f64| 2.0 * 1e4 * (x - to) + 2.0 * x + 4.0 * bend * bend * x.powi(3);
    let (mut low, mut high) = (0.0, to);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if slope(middle) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    low
}

#[test]
fn a_bent_valley_is_followed_to_its_end_in_few_steps() {
    for bend in [0.5, 1.0, 2.0] {
        let v = Valley::new(1e3, bend, 3.0);
        let end = descend(&v, WIDE, &[-3.0, 9.0 * bend], None, Effort::Certified).unwrap();
        assert!(end.converged, "{bend}");
        // So steep a valley has its end on its floor: the least cost there is the least cost.
        let x = on_the_floor(bend, 3.0);
        let least = 1e4 * (x - 3.0_f64).powi(2) + x * x + (bend * x * x).powi(2);
        // Leaving the floor gains no more than y² / steep².
        let beside = (bend * x * x / 1e3).powi(2);
        assert!(end.cost < least + 2e-4, "{} {least}", end.cost);
        assert!(
            end.cost > least - 2.0 * beside - 1e-6,
            "{} {least}",
            end.cost
        );
        assert!(
            v.slopes.get() < 60,
            "{bend}: {} {}",
            v.slopes.get(),
            v.values.get()
        );
    }
}

#[test]
fn a_linear_problem_takes_one_step_and_its_certificate() {
    let v = Valley::new(3.0, 0.0, 2.0);
    let end = descend(&v, WIDE, &[0.0, 1.0], None, Effort::Certified).unwrap();
    assert!(end.converged);
    // min 1e4 (x - 2)² + x² = 4 · 1e4 / (1e4 + 1), y = 0.
    assert!((end.cost - 4e4 / 10_001.0).abs() < 2e-4, "{}", end.cost);
    assert!(v.slopes.get() <= 4, "{}", v.slopes.get());
}

#[test]
fn the_end_on_a_bound_is_the_least_there() {
    let v = Valley::new(10.0, 1.0, 3.0);
    let bounds: (&[f64], &[f64]) = (&[-5.0, -5.0], &[1.0, 5.0]);
    let end = descend(&v, bounds, &[0.0, 0.0], None, Effort::Certified).unwrap();
    assert!(end.converged);
    assert_eq!(end.x[0], 1.0);
    // At x = 1: least of 100 (y - 1)² + y² is 100 / 101; beside it 1e4 (1 - 3)² + 1.
    assert!((end.cost - 40_001.0 - 100.0 / 101.0).abs() < 2e-4);
}

#[test]
fn a_carried_jacobian_ends_near_the_exact_end() {
    let v = Valley::new(30.0, 1.0, 3.0);
    let exact = descend(&v, WIDE, &[2.5, 6.0], None, Effort::Certified).unwrap();
    let near = exact.x.map(|x| x + 0.01);
    let asked = v.slopes.get();
    let j = v.slopes(&near).unwrap().1;
    let known = Some(Known::nearby(j.into(), &Remembered::default()));
    let carried = descend(&v, WIDE, near.as_slice(), known, Effort::Carried).unwrap();
    assert!(carried.cost - exact.cost < 0.02);
    assert_eq!(v.slopes.get(), asked + 1);
}

/// What another way's end knows is not asked again; where a bound moves the start it is of another place.
#[test]
fn what_is_known_of_a_start_is_not_asked_again() {
    let v = Valley::new(3.0, 0.0, 2.0);
    let start = DVector::from_vec(vec![0.5, 1.0]);
    let (residual, jacobian) = v.slopes(&start).unwrap();
    let known = Known {
        residual: Some(residual),
        jacobian: jacobian.into(),
        exact: true,
        near: Remembered::default(),
    };
    let asked = |bounds: (&[f64], &[f64]), known: Option<Known>| {
        let before = (v.values.get(), v.slopes.get());
        let end = descend(&v, bounds, start.as_slice(), known, Effort::Contest).unwrap();
        (
            end.cost,
            v.values.get() - before.0,
            v.slopes.get() - before.1,
        )
    };
    let (cost, values, slopes) = asked(WIDE, Some(known.clone()));
    let (anew, values_anew, slopes_anew) = asked(WIDE, None);
    assert!((cost - anew).abs() < 1e-9, "{cost} {anew}");
    assert_eq!((values, slopes + 1), (values_anew, slopes_anew));
    let within: (&[f64], &[f64]) = (&[-5.0, -5.0], &[5.0, 0.7]);
    assert_eq!(asked(within, Some(known)), asked(within, None));
}

/// A bent valley among so many values that say nothing that its start is near the data.
struct Among(Valley);

impl Among {
    const VALUES: usize = 80_000;
}

impl Residuals for Among {
    fn value(&self, x: &DVector<f64>) -> Result<DVector<f64>, GapError> {
        Ok(self.0.value(x)?.resize_vertically(Self::VALUES, 0.0))
    }

    fn slopes(&self, x: &DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), GapError> {
        let (r, j) = self.0.slopes(x)?;
        Ok((
            r.resize_vertically(Self::VALUES, 0.0),
            j.resize_vertically(Self::VALUES, 0.0),
        ))
    }
}

/// Along such a bend Broyden's update leads nowhere: after a few exact Jacobians each step has its own, and bends.
#[test]
fn a_carried_jacobian_does_not_creep_along_a_bend() {
    let v = Among(Valley::new(1e3, 6.0, 3.0));
    let end = descend(&v, WIDE, &[0.0, 0.0], None, Effort::Again).unwrap();
    let x = on_the_floor(6.0, 3.0);
    let least = 1e4 * (x - 3.0_f64).powi(2) + x * x + (6.0 * x * x).powi(2);
    let (values, slopes) = (v.0.values.get(), v.0.slopes.get());
    assert!(end.cost < least + 0.1, "{} {least}", end.cost);
    assert!(values < 150 && slopes < 30, "{values} {slopes}");
}

/// Two variables of which the data know the sum well and the difference hardly, among many values that say nothing.
struct Narrow(Cell<usize>);

impl Narrow {
    const VALUES: usize = 20;
}

impl Residuals for Narrow {
    fn value(&self, x: &DVector<f64>) -> Result<DVector<f64>, GapError> {
        let mut r = DVector::zeros(Self::VALUES);
        (r[0], r[1]) = (1e3 * (x[0] + x[1]), 3.0 * (x[0] - x[1] - 1.0));
        Ok(r)
    }

    fn slopes(&self, x: &DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), GapError> {
        self.0.set(self.0.get() + 1);
        let mut j = DMatrix::zeros(Self::VALUES, 2);
        j.set_row(0, &nalgebra::RowDVector::from_vec(vec![-1e3, -1e3]));
        j.set_row(1, &nalgebra::RowDVector::from_vec(vec![-3.0, 3.0]));
        Ok((self.value(x)?, j))
    }
}

/// At its start the damping of a fit from far away would be five hundred times what the data know of the difference.
#[test]
fn near_the_data_a_narrow_valley_is_gone_down_at_once() {
    let narrow = Narrow(Cell::new(0));
    let end = descend(&narrow, WIDE, &[0.0, 0.0], None, Effort::Contest).unwrap();
    // min 9 (d - 1)² + d²/2 over the difference d.
    assert!(
        end.converged && (end.cost - 9.0 / 19.0).abs() < 2e-3,
        "{}",
        end.cost
    );
    assert!(narrow.0.get() <= 3, "{}", narrow.0.get());
}

/// A hundred values a thousand times farther than what is near: 76 steps twice as fast as one percent each come a factor of five
/// nearer, as fast as five percent each one of two thousand.
#[test]
fn a_way_too_slow_to_arrive_is_not_gone() {
    let after = |share: f64| -> Vec<f64> {
        (0..5)
            .map(|k| 100.0 + 30_000.0 * (1.0 - share).powi(k - 4))
            .collect()
    };
    assert!(!arrives(&after(0.01), 100));
    assert!(arrives(&after(0.05), 100));
    // Before there are four steps to judge by, and near the data.
    assert!(arrives(&after(0.01)[1..], 100));
    let near: Vec<f64> = after(0.01)
        .iter()
        .map(|c| 100.0 + (c - 100.0) / 900.0)
        .collect();
    assert!(arrives(&near, 100));
}

/// A valley beyond whose edge there are values but no slopes, as where two rules of integration differ about what the soil carries.
struct Edge(Valley, f64);

impl Residuals for Edge {
    fn value(&self, x: &DVector<f64>) -> Result<DVector<f64>, GapError> {
        self.0.value(x)
    }

    fn slopes(&self, x: &DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), GapError> {
        if x[0] > self.1 {
            return Err(GapError::Log("beyond the edge".to_owned()));
        }
        self.0.slopes(x)
    }
}

#[test]
fn a_way_ends_before_an_edge_beyond_which_there_are_no_slopes() {
    for effort in [Effort::Certified, Effort::Contest] {
        let v = Edge(Valley::new(1e3, 1.0, 3.0), 2.0);
        let end = descend(&v, WIDE, &[0.0, 0.0], None, effort).unwrap();
        assert!(end.x[0] <= 2.0 && end.exact, "{:?}", end.x);
        assert!(!end.converged && end.cost < 9e4, "{}", end.cost);
    }
    // A carried Jacobian has gone beyond before it asks.
    let v = Edge(Valley::new(1e3, 1.0, 3.0), 2.0);
    let end = descend(&v, WIDE, &[0.0, 0.0], None, Effort::Again).unwrap();
    assert!(!end.converged, "{:?} {}", end.x, end.cost);
}

/// A tenth of a unit from its end a straight valley needs no Jacobian but the one it began with; where it bends so that the step does
/// not keep what was promised, others are asked for.
#[test]
fn a_last_step_that_keeps_its_promise_is_the_last() {
    let asked = |bend: f64| {
        let v = Among(Valley::new(1e3, bend, 0.1));
        let x = on_the_floor(bend, 0.1) - 0.1_f64.sqrt() / 100.0;
        let start = DVector::from_vec(vec![x, bend * x * x]);
        let (residual, jacobian) = v.slopes(&start).unwrap();
        let known = Known {
            residual: Some(residual),
            jacobian: jacobian.into(),
            exact: true,
            near: Remembered::default(),
        };
        let before = v.0.slopes.get();
        let end = descend(&v, WIDE, start.as_slice(), Some(known), Effort::Contest).unwrap();
        assert!(end.converged, "{bend}");
        (v.0.slopes.get() - before, end.exact)
    };
    assert_eq!(asked(0.0), (0, false));
    let (others, exact) = asked(100.0);
    assert!(others > 0 && exact);
}
