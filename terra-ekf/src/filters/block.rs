//! `block`: a Kalman filter that works on independent groups of states, exactly.
//!
//! # Equation
//! In y = M x the state space falls into groups that share neither dynamics, noise, prior nor channels; each group is a
//! Kalman filter of its own and the belief is x = M⁻¹ y. For the 18-state robot: four (w, T, T'), one (v, F_s, F_s')
//! and one (r, F_d, F_d') with F_s = F_L + F_R, F_d = F_R - F_L. Exact when both sides have equal q and equal,
//! uncorrelated prior and R is diagonal. Groups that turn out to be coupled are joined, with a typed reason. Where the
//! groups are few and small they are worked on side by side; the whole belief is put together when it is asked for.
//!
//! # Reference
//! The split is that of the system matrices; the update is the scalar-sequential one of G. J. Bierman,
//! *Factorization Methods for Discrete Sequential Estimation*, Academic Press (1977), chapter V.

use std::cell::OnceCell;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::account::Account;
use super::group::{Belief, Group, add_block, spread, update_group};
use super::kf::drive;
use super::lanes::Lanes;
use super::{Linear, Model};
use crate::config::FilterConfig;
use crate::discretise::Steps;
use crate::error::FilterError;
use crate::filter::Filter;
use crate::gaussian::{Gaussian, symmetrise};
use crate::measurement::{Innovation, Measurement};
use crate::robust::Watch;
use crate::state_space::AnyStateSpace;
use crate::structure::{Coupling, Structure};

/// The filter `block`.
#[derive(Clone)]
pub struct BlockFilter {
    pub(super) model: Model,
    structure: Structure,
    couplings: Vec<Coupling>,
    offset: DVector<f64>,
    pub(super) groups: Vec<Group>,
    /// The groups side by side, where they fit: then these hold the beliefs.
    pub(super) lanes: Option<Lanes>,
    account: Account,
    belief: OnceCell<Gaussian>,
    predicted: OnceCell<Gaussian>,
    cross: OnceCell<DMatrix<f64>>,
    watch: Watch,
    time: f64,
}

impl BlockFilter {
    /// A filter that starts from the state space's prior.
    ///
    /// # Errors
    /// [`FilterError::NotLinear`], or a configuration, noise or prior that is none.
    pub fn new(space: Arc<dyn AnyStateSpace>, config: FilterConfig) -> Result<Self, FilterError> {
        if !space.is_linear() {
            return Err(FilterError::NotLinear {
                filter: "block",
                space: space.name(),
            });
        }
        Linear::new(&*space)?;
        let model = Model::new(space, config)?;
        let origin = vec![0.0; model.prior.dim()];
        let offset = model.space.measure_value(&origin)?;
        let watch = Watch::new(offset.len());
        let (structure, couplings) = Structure::of(&*model.space, &model.prior.covariance)?;
        let belief = model.prior.clone();
        let mut filter = BlockFilter {
            model,
            structure,
            couplings,
            offset: DVector::from_vec(offset),
            groups: Vec::new(),
            lanes: None,
            account: Account::default(),
            belief: OnceCell::new(),
            predicted: OnceCell::new(),
            cross: OnceCell::new(),
            watch,
            time: 0.0,
        };
        filter.split(&belief)?;
        Ok(filter)
    }

    /// Number of independent groups in use.
    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// Builds the groups from the structure and a belief.
    fn split(&mut self, belief: &Gaussian) -> Result<(), FilterError> {
        let s = &self.structure;
        let (a, c) = self.model.space.system_matrices()?;
        let a = &s.basis * a * &s.inverse;
        let q = &s.basis * &self.model.q * s.basis.transpose();
        let start = &s.basis * &self.model.prior.covariance * s.basis.transpose();
        let p = &s.basis * &belief.covariance * s.basis.transpose();
        let y = &s.basis * &belief.mean;
        let owner: Vec<usize> = (0..c.nrows())
            .map(|row| s.group_of_channel(&c, row))
            .collect();
        let c = c * &s.inverse;
        self.groups = s
            .groups
            .iter()
            .enumerate()
            .map(|(g, states)| {
                let square = |m: &DMatrix<f64>| {
                    let mut m = m.select_rows(states).select_columns(states);
                    symmetrise(&mut m);
                    m
                };
                let channels: Vec<usize> = (0..owner.len()).filter(|&i| owner[i] == g).collect();
                let r = self
                    .model
                    .r
                    .select_rows(&channels)
                    .select_columns(&channels);
                let columns = s.inverse.select_columns(states);
                let mut out = Vec::new();
                for (i, row) in columns.row_iter().enumerate() {
                    out.extend(
                        (0..row.len())
                            .filter(|&k| row[k] != 0.0)
                            .map(|k| (i, k, row[k])),
                    );
                }
                let (mean, p) = (y.select_rows(states), square(&p));
                Group {
                    c: c.select_rows(&channels).select_columns(states),
                    independent: (0..r.nrows()).all(|i| (0..i).all(|j| r[(i, j)] == 0.0)),
                    r,
                    out,
                    steps: Steps::new(a.select_rows(states).select_columns(states), square(&q)),
                    prior: square(&start),
                    now: Belief {
                        predicted: (mean.clone(), p.clone()),
                        cross: DMatrix::zeros(p.nrows(), p.nrows()),
                        mean,
                        p,
                    },
                    states: states.clone(),
                    channels,
                }
            })
            .collect();
        let space = &*self.model.space;
        self.lanes = Lanes::of(&self.groups, &self.structure, &self.offset, space)?;
        self.forget();
        Ok(())
    }

    /// What was put together is no longer true.
    fn forget(&mut self) {
        self.belief.take();
        self.predicted.take();
        self.cross.take();
    }

    /// The beliefs go back to the groups, for what the lanes cannot do.
    fn sync_groups(&mut self) {
        if let Some(lanes) = &self.lanes {
            lanes.store(&mut self.groups);
        }
    }

    /// And to the lanes again.
    fn sync_lanes(&mut self) {
        if let Some(lanes) = &mut self.lanes {
            lanes.load(&self.groups);
        }
        self.forget();
    }

    /// x = M⁻¹ y of all groups, now or before the last update.
    fn whole(&self, predicted: bool) -> Gaussian {
        let n = self.structure.basis.nrows();
        let mut whole = Gaussian {
            mean: DVector::zeros(n),
            covariance: DMatrix::zeros(n, n),
        };
        for (lane, g) in self.groups.iter().enumerate() {
            let held;
            let (mean, p) = match &self.lanes {
                Some(lanes) => {
                    held = if predicted {
                        lanes.predicted(lane, g.states.len())
                    } else {
                        lanes.belief(lane, g.states.len())
                    };
                    (&held.0, &held.1)
                }
                None if predicted => (&g.now.predicted.0, &g.now.predicted.1),
                None => (&g.now.mean, &g.now.p),
            };
            spread(&mut whole, g, mean, p);
        }
        whole
    }

    /// The same of the cross covariance.
    fn whole_cross(&self) -> DMatrix<f64> {
        let n = self.structure.basis.nrows();
        let mut whole = DMatrix::zeros(n, n);
        for (lane, g) in self.groups.iter().enumerate() {
            match &self.lanes {
                Some(lanes) => add_block(&mut whole, g, &lanes.cross(lane, g.states.len())),
                None => add_block(&mut whole, g, &g.now.cross),
            }
        }
        whole
    }

    /// The update group by group: any structure, resets, dropped readings, errors.
    fn update_groups(&mut self, z: &Measurement) -> Result<Innovation, FilterError> {
        let mut innovation = Innovation::empty(self.offset.len());
        let mut watch = self.watch.clone();
        let mut next = Vec::with_capacity(self.groups.len());
        for g in &self.groups {
            let now = update_group(g, z, &self.offset, &self.model, &mut watch, &mut innovation)?;
            crate::gaussian::check_finite("mean", now.mean.as_slice())?;
            next.push(now);
        }
        for (g, now) in self.groups.iter_mut().zip(next) {
            g.now = now;
        }
        innovation.resets.sort_unstable();
        innovation.dropped.sort_unstable();
        self.watch = watch;
        Ok(innovation)
    }
}

impl Filter for BlockFilter {
    fn name(&self) -> &'static str {
        "block"
    }

    fn space(&self) -> &dyn AnyStateSpace {
        &*self.model.space
    }

    fn predict(&mut self, u: &[f64], dt: f64) -> Result<(), FilterError> {
        if let Some(lanes) = &mut self.lanes {
            lanes.predict::<true>(&self.model, &mut self.groups, u, dt, self.time)?;
        } else {
            self.model.check_step(u, dt, self.time)?;
            let drive = &self.structure.basis * drive(&self.model, u)?;
            let mut next = Vec::with_capacity(self.groups.len());
            for g in &mut self.groups {
                let step = g.steps.get(dt)?;
                let mean = &step.a * &g.now.mean + &step.gamma * drive.select_rows(&g.states);
                let cross = &g.now.p * step.a.transpose();
                let mut p = &step.a * &cross + &step.q;
                symmetrise(&mut p);
                crate::gaussian::check_finite("mean", mean.as_slice())?;
                crate::gaussian::check_finite("covariance", p.as_slice())?;
                next.push(Belief {
                    predicted: (mean.clone(), p.clone()),
                    mean,
                    p,
                    cross,
                });
            }
            for (g, now) in self.groups.iter_mut().zip(next) {
                g.now = now;
            }
        }
        self.forget();
        self.time += dt;
        if self.model.config.robust.is_some() {
            self.watch.elapse(dt);
        }
        Ok(())
    }

    fn update(&mut self, z: &Measurement) -> Result<Innovation, FilterError> {
        let channels = self.offset.len();
        if z.len() != channels {
            return Err(FilterError::Size {
                what: "measurement",
                expected: channels,
                found: z.len(),
            });
        }
        if let Some(lanes) = &mut self.lanes {
            let mut innovation = Innovation::empty(channels);
            let (config, watch) = (&self.model.config, &mut self.watch);
            let account = &mut self.account;
            if account.take(lanes, z.as_slice(), config, watch, &mut innovation) {
                self.forget();
                return Ok(innovation);
            }
        }
        self.sync_groups();
        let innovation = self.update_groups(z);
        self.sync_lanes();
        innovation
    }

    fn widen(&mut self, variance: &[f64]) -> Result<(), FilterError> {
        self.model.check_widening(variance)?;
        self.sync_groups();
        let s = &self.structure;
        let added = DMatrix::from_diagonal(&DVector::from_column_slice(variance));
        let added = &s.basis * added * s.basis.transpose();
        let mut inside = DMatrix::zeros(added.nrows(), added.ncols());
        for g in &self.groups {
            for &i in &g.states {
                for &j in &g.states {
                    inside[(i, j)] = added[(i, j)];
                }
            }
        }
        if (&added - inside).amax() > 0.0 {
            // Noise that couples groups: they become one. What the smoother knows of the step before stays as it is.
            let mut whole = self.whole(false);
            for (i, v) in variance.iter().enumerate() {
                whole.covariance[(i, i)] += v;
            }
            let cross = self.whole_cross();
            (self.structure, self.couplings) =
                Structure::of(&*self.model.space, &whole.covariance)?;
            self.split(&whole)?;
            let s = &self.structure;
            let cross = &s.basis * &cross * s.basis.transpose();
            for g in &mut self.groups {
                g.now.cross = cross.select_rows(&g.states).select_columns(&g.states);
            }
            self.sync_lanes();
            return Ok(());
        }
        for g in &mut self.groups {
            g.now.p += added.select_rows(&g.states).select_columns(&g.states);
            g.now.predicted = (g.now.mean.clone(), g.now.p.clone());
        }
        self.sync_lanes();
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn Filter> {
        Box::new(self.clone())
    }

    fn belief(&self) -> &Gaussian {
        self.belief.get_or_init(|| self.whole(false))
    }

    fn predicted(&self) -> &Gaussian {
        self.predicted.get_or_init(|| self.whole(true))
    }

    fn cross_covariance(&self) -> &DMatrix<f64> {
        self.cross.get_or_init(|| self.whole_cross())
    }

    fn restart(&mut self, belief: Gaussian) -> Result<(), FilterError> {
        let n = self.structure.basis.nrows();
        if belief.dim() != n {
            return Err(FilterError::Size {
                what: "belief",
                expected: n,
                found: belief.dim(),
            });
        }
        let belief = Gaussian::new(belief.mean, belief.covariance)?;
        // Another belief may couple what the prior did not.
        (self.structure, self.couplings) = Structure::of(&*self.model.space, &belief.covariance)?;
        self.split(&belief)?;
        self.watch.restart();
        self.time = 0.0;
        Ok(())
    }

    fn resets(&self) -> &[usize] {
        &self.watch.resets
    }

    fn couplings(&self) -> &[Coupling] {
        &self.couplings
    }
}
