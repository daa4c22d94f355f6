//! One group of `block`: a small Kalman filter of its own.

use nalgebra::{DMatrix, DVector};

use super::Model;
use crate::discretise::Steps;
use crate::error::FilterError;
use crate::gaussian::{Gaussian, symmetrise};
use crate::measurement::{Innovation, Measurement};
use crate::robust::{NO_SAY, Watch, describe, drop_absurd, others};
use crate::update::{joseph, sequential, whiten};

/// One independent group of states.
#[derive(Clone)]
pub(super) struct Group {
    /// Indices in y.
    pub(super) states: Vec<usize>,
    /// Channels that see this group, ascending.
    pub(super) channels: Vec<usize>,
    /// Rows of C (channels x states).
    pub(super) c: DMatrix<f64>,
    /// R of these channels.
    pub(super) r: DMatrix<f64>,
    /// True when R is diagonal.
    pub(super) independent: bool,
    /// The part of M⁻¹ that leads to x: (row of x, state of this group, coefficient), zeros left out.
    pub(super) out: Vec<(usize, usize, f64)>,
    pub(super) steps: Steps,
    pub(super) prior: DMatrix<f64>,
    pub(super) now: Belief,
}

/// Moments of one group.
#[derive(Clone)]
pub(super) struct Belief {
    pub(super) mean: DVector<f64>,
    pub(super) p: DMatrix<f64>,
    pub(super) predicted: (DVector<f64>, DMatrix<f64>),
    pub(super) cross: DMatrix<f64>,
}

/// Adds one group's moments to those of the whole.
pub(super) fn spread(whole: &mut Gaussian, g: &Group, mean: &DVector<f64>, p: &DMatrix<f64>) {
    for &(row, state, weight) in &g.out {
        whole.mean[row] += weight * mean[state];
    }
    add_block(&mut whole.covariance, g, p);
}

/// Adds one group's second moments to those of the whole.
pub(super) fn add_block(whole: &mut DMatrix<f64>, g: &Group, p: &DMatrix<f64>) {
    for &(i, a, left) in &g.out {
        for &(j, b, right) in &g.out {
            whole[(i, j)] += left * right * p[(a, b)];
        }
    }
}

/// The update of one group.
///
/// # Errors
/// [`FilterError::SingularInnovation`], [`FilterError::Implausible`].
pub(super) fn update_group(
    g: &Group,
    z: &Measurement,
    offset: &DVector<f64>,
    model: &Model,
    watch: &mut Watch,
    innovation: &mut Innovation,
) -> Result<Belief, FilterError> {
    let config = &model.config;
    let mut now = g.now.clone();
    let mut rows: Vec<usize> = g.channels.clone();
    rows.retain(|&i| z.get(i).is_some());
    now.predicted = (now.mean.clone(), now.p.clone());
    let see = |rows: &[usize]| {
        let at: Vec<usize> = (0..g.channels.len())
            .filter(|&k| rows.contains(&g.channels[k]))
            .collect();
        let c = g.c.select_rows(&at);
        let r = g.r.select_rows(&at).select_columns(&at);
        let values = DVector::from_iterator(
            rows.len(),
            rows.iter().filter_map(|&i| z.get(i).map(|v| v - offset[i])),
        );
        let residual = values - &c * &now.mean;
        let mut s = &c * &now.p * c.transpose() + &r;
        symmetrise(&mut s);
        (c, r, residual, s)
    };
    let (mut c, mut r, mut residual, mut s) = see(&rows);
    let absurd = drop_absurd(
        innovation,
        &mut rows,
        residual.as_slice(),
        s.diagonal().as_slice(),
        config,
    );
    if absurd.map_err(|(row, e)| model.implausible(row, z, e))? {
        (c, r, residual, s) = see(&rows);
    }
    if rows.is_empty() {
        return Ok(now);
    }
    let singular = |k: usize| FilterError::SingularInnovation {
        channel: model.channel(rows.get(k).copied().unwrap_or(k)),
    };
    let nominal = whiten(&s, &residual).map_err(singular)?;
    let mut normal = describe(
        innovation,
        &rows,
        residual.as_slice(),
        s.diagonal().as_slice(),
        config.gate,
    );
    let mut reset = Vec::new();
    for (k, &row) in rows.iter().enumerate() {
        innovation.whitened.set(row, nominal.values[k]);
        innovation.nis += nominal.values[k] * nominal.values[k];
        let e = normal[k];
        if watch.changed(row, &others(&rows, k, &normal, &s), e, config) {
            watch.reset(row, e);
            reset.push(row);
        } else if watch.timed_out(row, e, config) {
            reset.push(row);
        }
    }
    innovation.dof += rows.len();
    innovation.log_likelihood += nominal.log_likelihood;
    if !reset.is_empty() {
        now.p.copy_from(&g.prior);
        now.predicted.1.copy_from(&g.prior);
        now.cross.fill(0.0);
        s = &c * &now.p * c.transpose() + &r;
        for (k, e) in normal.iter_mut().enumerate() {
            *e = residual[k] / s[(k, k)].sqrt();
        }
    }
    if let Some(robust) = config.robust {
        for (k, &row) in rows.iter().enumerate() {
            if !reset.contains(&row) {
                let factor = if watch.distrusts(row) {
                    NO_SAY
                } else {
                    robust.inflation(normal[k])
                };
                innovation.inflation.set(row, factor);
                r[(k, k)] += s[(k, k)] * (factor - 1.0);
            }
        }
    }
    innovation.resets.extend(&reset);
    if g.independent {
        sequential(
            &mut now.mean,
            &mut now.p,
            &c,
            r.diagonal().as_slice(),
            &residual,
        )
    } else {
        joseph(&mut now.mean, &mut now.p, &c, &r, &residual)
    }
    .map_err(singular)?;
    Ok(now)
}
