//! The frame of all filters that keep one full covariance: rows, weights, resets, whitening. What differs is the
//! [`Method`]: how a belief moves, and how a measurement looks from it.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::Model;
use crate::config::{FilterConfig, UpdateForm};
use crate::error::FilterError;
use crate::filter::Filter;
use crate::gaussian::{Gaussian, symmetrise};
use crate::measurement::{Innovation, Measurement};
use crate::robust::{NO_SAY, Watch, describe, drop_absurd, others, reset_group};
use crate::state_space::AnyStateSpace;
use crate::structure::Structure;
use crate::update::{joseph, sequential, whiten};

/// What a measurement looks like from a belief: z = predicted + c (x - mean) + noise of covariance R + extra.
pub struct View {
    pub(crate) predicted: DVector<f64>,
    pub(crate) c: DMatrix<f64>,
    /// What a linear view leaves out (sigma-point filters); `None` means zero.
    pub(crate) extra: Option<DMatrix<f64>>,
    /// When given, `c` acts on ξ in x = mean + root ξ with ξ ~ N(0, I), not on x.
    pub(crate) root: Option<DMatrix<f64>>,
}

/// C and residual of a refined view.
pub(crate) type Refined = (DMatrix<f64>, DVector<f64>);

/// The part that differs between filters.
pub trait Method: Clone + Send + 'static {
    /// Name in the registry.
    fn name(&self) -> &'static str;
    /// The filter goes on from this belief, which the method did not make: a start, a reset, added noise.
    ///
    /// # Errors
    /// [`FilterError::NotACovariance`] for a belief that has no factor.
    fn begin(&mut self, _belief: &Gaussian) -> Result<(), FilterError> {
        Ok(())
    }
    /// The belief a step later, and cov(x now, x then).
    ///
    /// # Errors
    /// Whatever the state space raises.
    fn predict(
        &mut self,
        model: &mut Model,
        belief: &Gaussian,
        u: &[f64],
        dt: f64,
    ) -> Result<(Gaussian, DMatrix<f64>), FilterError>;
    /// The measurement as seen from a belief.
    ///
    /// # Errors
    /// Whatever the state space raises.
    fn observe(&self, model: &Model, belief: &Gaussian) -> Result<View, FilterError>;
    /// A better (c, residual) for the rows `rows` than that of [`observe`](Self::observe), by iteration; `None` keeps it.
    ///
    /// # Errors
    /// [`FilterError::NotConverged`], or whatever the state space raises.
    fn refine(
        &self,
        _model: &Model,
        _belief: &Gaussian,
        _rows: &[usize],
        _z: &DVector<f64>,
        _r: &DMatrix<f64>,
    ) -> Result<Option<Refined>, FilterError> {
        Ok(None)
    }
    /// The belief after an update, for a method that carries more than the belief; `None` leaves it to the frame.
    /// `Err(row)` names a row in which S has no inverse.
    fn commit(&mut self, _at: &Update<'_>) -> Option<Result<Gaussian, usize>> {
        None
    }
}

/// What an update takes in: the channels `rows`, and what the frame made of them.
pub struct Update<'a> {
    pub(crate) model: &'a Model,
    pub(crate) belief: &'a Gaussian,
    pub(crate) rows: &'a [usize],
    /// z of the rows.
    pub(crate) values: &'a DVector<f64>,
    /// Variance that a robust update adds to each.
    pub(crate) inflation: &'a [f64],
    pub(crate) c: &'a DMatrix<f64>,
    /// R + extra + inflation.
    pub(crate) r: &'a DMatrix<f64>,
    pub(crate) residual: &'a DVector<f64>,
}

/// A filter with one full covariance.
#[derive(Clone)]
pub struct DenseFilter<M> {
    method: M,
    model: Model,
    structure: Structure,
    belief: Gaussian,
    predicted: Gaussian,
    cross: DMatrix<f64>,
    watch: Watch,
    time: f64,
}

impl<M: Method> DenseFilter<M> {
    /// A filter that starts from the state space's prior.
    ///
    /// # Errors
    /// A configuration, noise or prior that is none.
    pub fn new(
        method: M,
        space: Arc<dyn AnyStateSpace>,
        config: FilterConfig,
    ) -> Result<Self, FilterError> {
        let model = Model::new(space, config)?;
        let (structure, _) = Structure::of(&*model.space, &model.prior.covariance)?;
        let belief = model.prior.clone();
        let n = belief.dim();
        let watch = Watch::new(model.space.dims().measurement);
        Ok(DenseFilter {
            method,
            model,
            structure,
            predicted: belief.clone(),
            belief,
            cross: DMatrix::zeros(n, n),
            watch,
            time: 0.0,
        })
    }

    /// Forgets what is known of the states behind a channel, in belief and cross covariance.
    fn reset(
        &self,
        prior: &mut Gaussian,
        cross: &mut DMatrix<f64>,
        channel: usize,
    ) -> Result<(), FilterError> {
        let (_, c) = self.model.space.measure_jacobian(prior.mean.as_slice())?;
        let s = &self.structure;
        let group = &s.groups[s.group_of_channel(&c, channel)];
        let mut p = &s.basis * &prior.covariance * s.basis.transpose();
        let start = &s.basis * &self.model.prior.covariance * s.basis.transpose();
        reset_group(&mut p, &start, group);
        prior.covariance = &s.inverse * p * s.inverse.transpose();
        symmetrise(&mut prior.covariance);
        let mut y = &*cross * s.basis.transpose();
        for &i in group {
            y.column_mut(i).fill(0.0);
        }
        *cross = y * s.inverse.transpose();
        Ok(())
    }
}

/// Rows of a measurement seen from a belief: residual, C, R + extra, and S.
struct Rows {
    c: DMatrix<f64>,
    r: DMatrix<f64>,
    residual: DVector<f64>,
    s: DMatrix<f64>,
}

fn rows_of(
    view: &View,
    model: &Model,
    belief: &Gaussian,
    rows: &[usize],
    z: &DVector<f64>,
) -> Rows {
    let c = view.c.select_rows(rows);
    let mut r = model.r.select_rows(rows).select_columns(rows);
    if let Some(extra) = &view.extra {
        r += extra.select_rows(rows).select_columns(rows);
    }
    let residual = z - view.predicted.select_rows(rows);
    let mut s = match view.root {
        Some(_) => &c * c.transpose() + &r,
        None => &c * &belief.covariance * c.transpose() + &r,
    };
    symmetrise(&mut s);
    Rows { c, r, residual, s }
}

/// Applies an update in the coordinates of the view.
fn apply(
    belief: &Gaussian,
    root: Option<&DMatrix<f64>>,
    c: &DMatrix<f64>,
    r: &DMatrix<f64>,
    residual: &DVector<f64>,
    form: UpdateForm,
) -> Result<Gaussian, usize> {
    let (mut mean, mut p) = match root {
        Some(root) => (
            DVector::zeros(root.nrows()),
            DMatrix::identity(root.nrows(), root.nrows()),
        ),
        None => (belief.mean.clone(), belief.covariance.clone()),
    };
    match form {
        UpdateForm::Joseph => joseph(&mut mean, &mut p, c, r, residual)?,
        UpdateForm::Sequential => {
            sequential(&mut mean, &mut p, c, r.diagonal().as_slice(), residual)?
        }
    }
    if let Some(root) = root {
        mean = &belief.mean + root * mean;
        p = root * p * root.transpose();
        symmetrise(&mut p);
    }
    Ok(Gaussian {
        mean,
        covariance: p,
    })
}

impl<M: Method> Filter for DenseFilter<M> {
    fn name(&self) -> &'static str {
        self.method.name()
    }

    fn space(&self) -> &dyn AnyStateSpace {
        &*self.model.space
    }

    fn predict(&mut self, u: &[f64], dt: f64) -> Result<(), FilterError> {
        self.model.check_step(u, dt, self.time)?;
        let mut method = self.method.clone();
        let (next, cross) = method.predict(&mut self.model, &self.belief, u, dt)?;
        next.check_finite()?;
        self.method = method;
        self.belief = next;
        self.predicted = self.belief.clone();
        self.cross = cross;
        self.time += dt;
        self.watch.elapse(dt);
        Ok(())
    }

    fn update(&mut self, z: &Measurement) -> Result<Innovation, FilterError> {
        let channels = self.model.space.dims().measurement;
        if z.len() != channels {
            return Err(FilterError::Size {
                what: "measurement",
                expected: channels,
                found: z.len(),
            });
        }
        let mut innovation = Innovation::empty(channels);
        let mut rows = z.present();
        if rows.is_empty() {
            self.predicted = self.belief.clone();
            return Ok(innovation);
        }
        let samples = |rows: &[usize]| {
            DVector::from_iterator(rows.len(), rows.iter().filter_map(|&i| z.get(i)))
        };
        let mut values = samples(&rows);
        let config = self.model.config;
        let mut view = self.method.observe(&self.model, &self.belief)?;
        let mut seen = rows_of(&view, &self.model, &self.belief, &rows, &values);
        let absurd = drop_absurd(
            &mut innovation,
            &mut rows,
            seen.residual.as_slice(),
            seen.s.diagonal().as_slice(),
            &config,
        );
        if absurd.map_err(|(row, e)| self.model.implausible(row, z, e))? {
            if rows.is_empty() {
                self.predicted = self.belief.clone();
                return Ok(innovation);
            }
            values = samples(&rows);
            seen = rows_of(&view, &self.model, &self.belief, &rows, &values);
        }
        let singular = |row: usize| FilterError::SingularInnovation {
            channel: self.model.channel(rows.get(row).copied().unwrap_or(row)),
        };
        let mut prior = self.belief.clone();
        let mut cross = self.cross.clone();
        let mut watch = self.watch.clone();

        let nominal = whiten(&seen.s, &seen.residual).map_err(singular)?;
        let normal = describe(
            &mut innovation,
            &rows,
            seen.residual.as_slice(),
            seen.s.diagonal().as_slice(),
            config.gate,
        );
        for (k, &row) in rows.iter().enumerate() {
            innovation.whitened.set(row, nominal.values[k]);
            let e = normal[k];
            if watch.changed(row, &others(&rows, k, &normal, &seen.s), e, &config) {
                watch.reset(row, e);
                innovation.resets.push(row);
            } else if watch.timed_out(row, e, &config) {
                innovation.resets.push(row);
            }
        }
        innovation.nis = nominal.values.iter().map(|w| w * w).sum();
        innovation.dof = rows.len();
        innovation.log_likelihood = nominal.log_likelihood;

        let mut normal = normal;
        let mut method = self.method.clone();
        if !innovation.resets.is_empty() {
            for &channel in &innovation.resets {
                self.reset(&mut prior, &mut cross, channel)?;
            }
            method.begin(&prior)?;
            view = self.method.observe(&self.model, &prior)?;
            seen = rows_of(&view, &self.model, &prior, &rows, &values);
            for (k, e) in normal.iter_mut().enumerate() {
                *e = seen.residual[k] / seen.s[(k, k)].sqrt();
            }
        }
        let mut inflate = vec![0.0; rows.len()];
        if let Some(robust) = config.robust {
            for (k, &row) in rows.iter().enumerate() {
                if innovation.resets.contains(&row) {
                    continue;
                }
                let factor = if watch.distrusts(row) {
                    NO_SAY
                } else {
                    robust.inflation(normal[k])
                };
                inflate[k] = seen.s[(k, k)] * (factor - 1.0);
                innovation.inflation.set(row, factor);
                seen.r[(k, k)] += inflate[k];
            }
        }

        let next = if view.root.is_some() && config.form == UpdateForm::Sequential {
            // Sigma points are drawn afresh for each channel, so that no correlation between channels is left out.
            let mut belief = prior.clone();
            for (k, &row) in rows.iter().enumerate() {
                let view = self.method.observe(&self.model, &belief)?;
                let z = DVector::from_element(1, values[k]);
                let mut one = rows_of(&view, &self.model, &belief, &[row], &z);
                one.r[(0, 0)] += inflate[k];
                belief = apply(
                    &belief,
                    view.root.as_ref(),
                    &one.c,
                    &one.r,
                    &one.residual,
                    UpdateForm::Joseph,
                )
                .map_err(|_| singular(k))?;
            }
            belief
        } else {
            if let Some((c, residual)) =
                self.method
                    .refine(&self.model, &prior, &rows, &values, &seen.r)?
            {
                seen.c = c;
                seen.residual = residual;
            }
            let committed = method.commit(&Update {
                model: &self.model,
                belief: &prior,
                rows: &rows,
                values: &values,
                inflation: &inflate,
                c: &seen.c,
                r: &seen.r,
                residual: &seen.residual,
            });
            committed
                .unwrap_or_else(|| {
                    apply(
                        &prior,
                        view.root.as_ref(),
                        &seen.c,
                        &seen.r,
                        &seen.residual,
                        config.form,
                    )
                })
                .map_err(singular)?
        };
        next.check_finite()?;
        self.method = method;
        self.belief = next;
        self.predicted = prior;
        self.cross = cross;
        self.watch = watch;
        Ok(innovation)
    }

    fn widen(&mut self, variance: &[f64]) -> Result<(), FilterError> {
        self.model.check_widening(variance)?;
        for (i, v) in variance.iter().enumerate() {
            self.belief.covariance[(i, i)] += v;
        }
        self.method.begin(&self.belief)?;
        self.predicted = self.belief.clone();
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn Filter> {
        Box::new(self.clone())
    }

    fn belief(&self) -> &Gaussian {
        &self.belief
    }

    fn predicted(&self) -> &Gaussian {
        &self.predicted
    }

    fn cross_covariance(&self) -> &DMatrix<f64> {
        &self.cross
    }

    fn restart(&mut self, belief: Gaussian) -> Result<(), FilterError> {
        let n = self.model.space.dims().state;
        if belief.dim() != n {
            return Err(FilterError::Size {
                what: "belief",
                expected: n,
                found: belief.dim(),
            });
        }
        let belief = Gaussian::new(belief.mean, belief.covariance)?;
        self.structure = Structure::of(&*self.model.space, &belief.covariance)?.0;
        self.method.begin(&belief)?;
        self.predicted = belief.clone();
        self.belief = belief;
        self.cross.fill(0.0);
        self.watch.restart();
        self.time = 0.0;
        Ok(())
    }

    fn resets(&self) -> &[usize] {
        &self.watch.resets
    }
}
