//! The free soil parameters of a diagnosis: those of one soil, or of one for each log, all with the same prior.

use nalgebra::DMatrix;
use terra_mme::FitSpace;
use terra_model::Real;

/// The map from the soil part of a fit vector to parameters, once for each soil.
#[derive(Clone, Debug)]
pub struct SoilSpace {
    each: FitSpace,
    /// Whose soil it is; empty where one soil is shared.
    labels: Vec<String>,
}

impl SoilSpace {
    /// One soil for all, or one for each label.
    pub fn new(each: FitSpace, labels: &[String]) -> Self {
        SoilSpace {
            each,
            labels: labels.to_vec(),
        }
    }

    fn soils(&self) -> usize {
        self.labels.len().max(1)
    }

    /// Number of free parameters.
    pub fn dim(&self) -> usize {
        self.soils() * self.each.dim()
    }

    /// Their names; `day1.csv/cohesion` where each log has its own soil.
    pub fn names(&self) -> Vec<String> {
        let names = self.each.names();
        if self.labels.is_empty() {
            return names.into_iter().map(str::to_owned).collect();
        }
        let mut out = vec![];
        for label in &self.labels {
            out.extend(names.iter().map(|name| format!("{label}/{name}")));
        }
        out
    }

    /// Units of the physical values.
    pub fn units(&self) -> Vec<&'static str> {
        self.each.units().repeat(self.soils())
    }

    /// Smallest legal value of each component of the fit vector.
    pub fn lower_bounds(&self) -> Vec<f64> {
        self.each.lower_bounds().repeat(self.soils())
    }

    /// True when k_c and k_phi are one component.
    pub fn merges_stiffness(&self) -> bool {
        self.each.merges_stiffness()
    }

    /// The nominal law's parameters, soil after soil. Components beyond the length of `q` stay at their start.
    pub fn parameters_t<T: Real>(&self, q: &[T]) -> Vec<T> {
        self.parts(q)
            .flat_map(|q| self.each.parameters_t(q))
            .collect()
    }

    /// The value of each component in its unit.
    pub fn physical(&self, q: &[f64]) -> Vec<f64> {
        self.parts(q).flat_map(|q| self.each.physical(q)).collect()
    }

    /// sd of each physical value, to first order, for a covariance (dim x dim) of `q`.
    pub fn physical_sd(&self, q: &[f64], covariance: &DMatrix<f64>) -> Vec<f64> {
        let d = self.each.dim();
        let of = |(k, q): (usize, &[f64])| {
            let block = covariance.view((k * d, k * d), (q.len(), q.len()));
            self.each.physical_sd(q, &block.into_owned())
        };
        self.parts(q).enumerate().flat_map(of).collect()
    }

    fn parts<'q, T>(&self, q: &'q [T]) -> impl Iterator<Item = &'q [T]> + use<'q, T> {
        let d = self.each.dim();
        (0..self.soils()).map(move |k| {
            let from = (k * d).min(q.len());
            let to = (from + d).min(q.len());
            q.get(from..to).unwrap_or_default()
        })
    }
}
