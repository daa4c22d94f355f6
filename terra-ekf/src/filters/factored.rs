//! `srkf` and `ud`: filters that never form their covariance, but carry a factor of it.
//!
//! # Equation
//! Square root, P = S Sᵀ: prediction by an orthogonal triangularisation of \[a S, q^(1/2)\]; update channel by channel
//! (Potter) with φ = Sᵀ c, s = φᵀφ + r, k = S φ/s, S ← S - k φᵀ/(1 + √(r/s)). UD, P = U D Uᵀ with U unit upper triangular
//! and D diagonal: prediction by Thornton's weighted Gram-Schmidt, update by Bierman's recursion, neither with a square
//! root. A factor has twice the digits of its covariance, and U D Uᵀ is positive semi-definite whatever rounding does.
//!
//! # Reference
//! G. J. Bierman, *Factorization Methods for Discrete Sequential Estimation*, Academic Press (1977), sections II.7
//! (Potter), V.3 (UD update), VI.4 (Thornton).

use nalgebra::{DMatrix, DVector};

use super::Model;
use super::dense::{Method, Update, View};
use super::ekf::Extended;
use super::kf::drive;
use crate::discretise::propagate;
use crate::error::FilterError;
use crate::gaussian::{Gaussian, square_root, symmetrise};

/// A factor of a covariance.
pub trait Factor: Clone + Send + 'static {
    /// Name of the filter that carries it.
    const NAME: &'static str;
    /// The factor of a covariance.
    ///
    /// # Errors
    /// [`FilterError::NotACovariance`].
    fn of(p: &DMatrix<f64>) -> Result<Self, FilterError>;
    /// P ← a P aᵀ + w wᵀ.
    fn propagate(&mut self, a: &DMatrix<f64>, w: &DMatrix<f64>);
    /// Takes in one scalar channel of row `c` and variance `r`; gives the gain and the innovation variance.
    fn update(&mut self, c: &DVector<f64>, r: f64) -> (DVector<f64>, f64);
    /// P.
    fn covariance(&self) -> DMatrix<f64>;
}

/// P = S Sᵀ.
#[derive(Clone, Debug)]
pub struct SquareRoot {
    s: DMatrix<f64>,
}

impl Factor for SquareRoot {
    const NAME: &'static str = "srkf";

    fn of(p: &DMatrix<f64>) -> Result<Self, FilterError> {
        Ok(SquareRoot {
            s: square_root("covariance", p)?,
        })
    }

    fn propagate(&mut self, a: &DMatrix<f64>, w: &DMatrix<f64>) {
        let n = a.nrows();
        let mut stack = DMatrix::zeros(n + w.ncols(), n);
        stack.rows_mut(0, n).copy_from(&(a * &self.s).transpose());
        stack.rows_mut(n, w.ncols()).copy_from(&w.transpose());
        self.s = stack.qr().r().transpose();
    }

    fn update(&mut self, c: &DVector<f64>, r: f64) -> (DVector<f64>, f64) {
        let phi = self.s.tr_mul(c);
        let s = phi.norm_squared() + r;
        let gain = &self.s * &phi / s;
        let alpha = 1.0 / (1.0 + (r / s).sqrt());
        self.s.ger(-alpha, &gain, &phi, 1.0);
        (gain, s)
    }

    fn covariance(&self) -> DMatrix<f64> {
        &self.s * self.s.transpose()
    }
}

/// P = U D Uᵀ.
#[derive(Clone, Debug)]
pub struct UnitDiagonal {
    u: DMatrix<f64>,
    d: DVector<f64>,
}

impl Factor for UnitDiagonal {
    const NAME: &'static str = "ud";

    fn of(p: &DMatrix<f64>) -> Result<Self, FilterError> {
        // The reversed matrix has the lower factor L; reversed back, L is upper triangular, and its columns are U √D.
        let n = p.nrows();
        let reversed = DMatrix::from_fn(n, n, |i, j| p[(n - 1 - i, n - 1 - j)]);
        let l = square_root("covariance", &reversed)?;
        let mut u = DMatrix::identity(n, n);
        let mut d = DVector::zeros(n);
        for j in 0..n {
            let pivot = l[(n - 1 - j, n - 1 - j)];
            d[j] = pivot * pivot;
            if pivot > 0.0 {
                for i in 0..j {
                    u[(i, j)] = l[(n - 1 - i, n - 1 - j)] / pivot;
                }
            }
        }
        Ok(UnitDiagonal { u, d })
    }

    fn propagate(&mut self, a: &DMatrix<f64>, w: &DMatrix<f64>) {
        let n = a.nrows();
        let m = n + w.ncols();
        let mut rows = DMatrix::zeros(m, n);
        rows.rows_mut(0, n).copy_from(&(a * &self.u).transpose());
        rows.rows_mut(n, w.ncols()).copy_from(&w.transpose());
        let weight = DVector::from_fn(m, |k, _| if k < n { self.d[k] } else { 1.0 });
        self.u.fill_with_identity();
        for j in (0..n).rev() {
            let column = rows.column(j).into_owned();
            let weighted = column.component_mul(&weight);
            let d = column.dot(&weighted);
            self.d[j] = d;
            if d > 0.0 {
                for i in 0..j {
                    let u = rows.column(i).dot(&weighted) / d;
                    self.u[(i, j)] = u;
                    rows.column_mut(i).axpy(-u, &column, 1.0);
                }
            }
        }
    }

    fn update(&mut self, c: &DVector<f64>, r: f64) -> (DVector<f64>, f64) {
        let n = c.len();
        let f = self.u.tr_mul(c);
        let mut gain = DVector::zeros(n);
        let mut alpha = r;
        for j in 0..n {
            let v = self.d[j] * f[j];
            let next = alpha + f[j] * v;
            // Nothing seen so far and no noise: the states before say nothing, and there is nothing to correct.
            let back = if alpha > 0.0 { -f[j] / alpha } else { 0.0 };
            if next > 0.0 {
                self.d[j] *= alpha / next;
            }
            for i in 0..j {
                let u = self.u[(i, j)];
                self.u[(i, j)] = u + gain[i] * back;
                gain[i] += u * v;
            }
            gain[j] = v;
            alpha = next;
        }
        (gain / alpha, alpha)
    }

    fn covariance(&self) -> DMatrix<f64> {
        &self.u * DMatrix::from_diagonal(&self.d) * self.u.transpose()
    }
}

/// Method of `srkf` and `ud`.
#[derive(Clone)]
pub struct Factored<F> {
    factor: F,
}

impl<F: Factor> Factored<F> {
    /// The method for a belief.
    ///
    /// # Errors
    /// [`FilterError::NotACovariance`].
    pub fn new(belief: &Gaussian) -> Result<Self, FilterError> {
        Ok(Factored {
            factor: F::of(&belief.covariance)?,
        })
    }

    fn covariance(&self) -> DMatrix<f64> {
        let mut p = self.factor.covariance();
        symmetrise(&mut p);
        p
    }
}

impl<F: Factor> Method for Factored<F> {
    fn name(&self) -> &'static str {
        F::NAME
    }

    fn begin(&mut self, belief: &Gaussian) -> Result<(), FilterError> {
        self.factor = F::of(&belief.covariance)?;
        Ok(())
    }

    fn predict(
        &mut self,
        model: &mut Model,
        belief: &Gaussian,
        u: &[f64],
        dt: f64,
    ) -> Result<(Gaussian, DMatrix<f64>), FilterError> {
        let (mean, a, q) = if model.steps.is_some() {
            let drive = drive(model, u)?;
            let Some(steps) = model.steps.as_mut() else {
                return Err(FilterError::NotLinear {
                    filter: F::NAME,
                    space: model.space.name(),
                });
            };
            let step = steps.get(dt)?;
            let mean = &step.a * &belief.mean + &step.gamma * drive;
            (mean, step.a.clone(), step.q.clone())
        } else {
            let space = &*model.space;
            propagate(space, &model.q, &belief.mean, u, dt, model.config.max_step)?
        };
        let cross = &belief.covariance * a.transpose();
        self.factor
            .propagate(&a, &square_root("process noise", &q)?);
        let covariance = self.covariance();
        Ok((Gaussian { mean, covariance }, cross))
    }

    fn observe(&self, model: &Model, belief: &Gaussian) -> Result<View, FilterError> {
        Extended.observe(model, belief)
    }

    fn commit(&mut self, at: &Update<'_>) -> Option<Result<Gaussian, usize>> {
        let (belief, c, r, residual) = (at.belief, at.c, at.r, at.residual);
        // Correlated noise is made independent first: L⁻¹ z has the noise I.
        let diagonal = (0..r.nrows()).all(|i| (0..i).all(|j| r[(i, j)] == 0.0));
        let (c, noise, residual) = if diagonal {
            (c.clone(), r.diagonal(), residual.clone())
        } else {
            let Some(cholesky) = r.clone().cholesky() else {
                return Some(Err(0));
            };
            let l = cholesky.l();
            let (Some(c), Some(residual)) = (
                l.solve_lower_triangular(c),
                l.solve_lower_triangular(residual),
            ) else {
                return Some(Err(0));
            };
            let one = DVector::from_element(residual.len(), 1.0);
            (c, one, residual)
        };
        let mut moved = DVector::zeros(belief.dim());
        for i in 0..residual.len() {
            let row = c.row(i).transpose();
            let rest = residual[i] - row.dot(&moved);
            let (gain, s) = self.factor.update(&row, noise[i]);
            if !(s > 0.0 && s.is_finite()) {
                return Some(Err(i));
            }
            moved.axpy(rest, &gain, 1.0);
        }
        Some(Ok(Gaussian {
            mean: &belief.mean + moved,
            covariance: self.covariance(),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P = [4 2; 2 2] = U D Uᵀ with u = 1, D = (2, 2); a semi-definite one has a zero in D.
    #[test]
    fn factors_by_hand() {
        let p = DMatrix::from_row_slice(2, 2, &[4.0, 2.0, 2.0, 2.0]);
        let ud = UnitDiagonal::of(&p).unwrap();
        assert!((ud.u[(0, 1)] - 1.0).abs() < 1e-15);
        assert!((ud.d[0] - 2.0).abs() < 1e-15 && (ud.d[1] - 2.0).abs() < 1e-15);
        let flat = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        assert!(UnitDiagonal::of(&flat).unwrap().d[0].abs() < 1e-15);
    }

    /// Bierman's ill-conditioned example: P0 = I, c1 = \[1, e\], c2 = \[1, 1\], r = e², e = 1e-9. With 1 + e² = 1 in f64 the
    /// short form loses everything, the factors keep the answer of exact arithmetic.
    #[test]
    fn ill_conditioned_example_of_bierman() {
        let e = 1e-9;
        let (c1, c2) = (
            DVector::from_row_slice(&[1.0, e]),
            DVector::from_row_slice(&[1.0, 1.0]),
        );
        // Exact: P = (I + (c1 c1ᵀ + c2 c2ᵀ)/e²)⁻¹ = e²/det [e² + e² + 1, -(e + 1); -(e + 1), e² + 2], and
        // det = (e² + 2)(2e² + 1) - (1 + e)² = 1 - 2e + 4e² + 2e⁴ after the cancellation is done by hand.
        let det = 1.0 - 2.0 * e + 4.0 * e * e;
        let exact = DMatrix::from_row_slice(
            2,
            2,
            &[2.0 * e * e + 1.0, -(1.0 + e), -(1.0 + e), e * e + 2.0],
        ) * (e * e / det);
        fn run<F: Factor>(c1: &DVector<f64>, c2: &DVector<f64>, r: f64) -> DMatrix<f64> {
            let mut f = F::of(&DMatrix::identity(2, 2)).unwrap();
            f.update(c1, r);
            f.update(c2, r);
            f.covariance()
        }
        for p in [
            run::<SquareRoot>(&c1, &c2, e * e),
            run::<UnitDiagonal>(&c1, &c2, e * e),
        ] {
            assert!((&p - &exact).amax() < 1e-6 * exact.amax(), "{p} {exact}");
        }
        // Expected failure: the short form P - k kᵀ s has lost everything.
        let mut p = DMatrix::<f64>::identity(2, 2);
        for c in [&c1, &c2] {
            let pc = &p * c;
            let s = c.dot(&pc) + e * e;
            p -= &pc * pc.transpose() / s;
        }
        assert!((&p - &exact).amax() > 0.1 * exact.amax());
    }
}
