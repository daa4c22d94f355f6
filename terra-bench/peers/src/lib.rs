//! One problem, many filters: the 18-state robot with seven channels, 100 samples a second, no input (not every filter
//! knows one). Every filter must end where the textbook ends before it is timed.

use std::error::Error;

use adskalman::{
    KalmanFilterNoControl, ObservationModel, StateAndCovariance, TransitionModelLinearNoControl,
};
use kfilter::kalman::{Kalman1M, KalmanFilter as _, KalmanPredict as _};
use kfilter::measurement::LinearMeasurement;
use kfilter::system::LinearNoInputSystem;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use terra_bench::filter::{Log, SAMPLES, Textbook, check_belief};
use terra_ekf::{Filter, Gaussian, LaneFilter};

/// States.
pub const N: usize = 18;
/// Channels.
pub const M: usize = 7;

/// What goes wrong.
pub type Failure = Box<dyn Error>;

/// A filter under the clock.
pub trait Peer {
    /// Name and version.
    fn name(&self) -> &'static str;

    /// Predicts and takes sample `k` of the log in, which wraps around.
    ///
    /// # Errors
    /// What the filter refuses.
    fn step(&mut self, k: usize) -> Result<(), Failure>;

    /// Mean and covariance.
    fn belief(&self) -> Gaussian;
}

fn square<const R: usize, const C: usize>(m: &DMatrix<f64>) -> SMatrix<f64, R, C> {
    SMatrix::from_fn(|i, j| m[(i, j)])
}

fn rows(m: &DMatrix<f64>) -> Vec<f64> {
    m.transpose().as_slice().to_vec()
}

/// A filter of terra by name.
struct Terra {
    label: &'static str,
    log: Log,
    filter: Box<dyn Filter>,
}

impl Peer for Terra {
    fn name(&self) -> &'static str {
        self.label
    }

    fn step(&mut self, k: usize) -> Result<(), Failure> {
        Ok(self.log.step(&mut *self.filter, k)?)
    }

    fn belief(&self) -> Gaussian {
        self.filter.belief().clone()
    }
}

/// The filter of terra that gives what the others give: mean and covariance.
struct Lanes {
    log: Log,
    filter: LaneFilter,
}

impl Peer for Lanes {
    fn name(&self) -> &'static str {
        "terra, lanes"
    }

    fn step(&mut self, k: usize) -> Result<(), Failure> {
        self.log.step_lanes(&mut self.filter, k, false)?;
        Ok(())
    }

    fn belief(&self) -> Gaussian {
        self.filter.belief()
    }
}

/// What one writes first with nalgebra: fixed sizes, inverse of S, Joseph's form.
struct Joseph {
    a: SMatrix<f64, N, N>,
    q: SMatrix<f64, N, N>,
    c: SMatrix<f64, M, N>,
    r: SMatrix<f64, M, M>,
    x: SVector<f64, N>,
    p: SMatrix<f64, N, N>,
    samples: Vec<SVector<f64, M>>,
}

impl Peer for Joseph {
    fn name(&self) -> &'static str {
        "nalgebra 0.35, textbook, Joseph"
    }

    fn step(&mut self, k: usize) -> Result<(), Failure> {
        self.x = self.a * self.x;
        self.p = self.a * self.p * self.a.transpose() + self.q;
        let pct = self.p * self.c.transpose();
        let s = self.c * pct + self.r;
        let gain = pct * s.try_inverse().ok_or("singular")?;
        let nu = self.samples[k % self.samples.len()] - self.c * self.x;
        self.x += gain * nu;
        let keep = SMatrix::<f64, N, N>::identity() - gain * self.c;
        self.p = keep * self.p * keep.transpose() + gain * self.r * gain.transpose();
        Ok(())
    }

    fn belief(&self) -> Gaussian {
        Gaussian {
            mean: DVector::from_column_slice(self.x.as_slice()),
            covariance: DMatrix::from_column_slice(N, N, self.p.as_slice()),
        }
    }
}

/// The matrices as `adskalman` asks for them.
struct Matrices {
    a: SMatrix<f64, N, N>,
    at: SMatrix<f64, N, N>,
    q: SMatrix<f64, N, N>,
    c: SMatrix<f64, M, N>,
    ct: SMatrix<f64, N, M>,
    r: SMatrix<f64, M, M>,
}

#[allow(non_snake_case)]
impl TransitionModelLinearNoControl<f64, nalgebra::Const<N>> for Matrices {
    fn F(&self) -> &SMatrix<f64, N, N> {
        &self.a
    }
    fn FT(&self) -> &SMatrix<f64, N, N> {
        &self.at
    }
    fn Q(&self) -> &SMatrix<f64, N, N> {
        &self.q
    }
}

#[allow(non_snake_case)]
impl ObservationModel<f64, nalgebra::Const<N>, nalgebra::Const<M>> for Matrices {
    fn H(&self) -> &SMatrix<f64, M, N> {
        &self.c
    }
    fn HT(&self) -> &SMatrix<f64, N, M> {
        &self.ct
    }
    fn R(&self) -> &SMatrix<f64, M, M> {
        &self.r
    }
}

struct Adskalman {
    matrices: Matrices,
    state: StateAndCovariance<f64, nalgebra::Const<N>>,
    samples: Vec<SVector<f64, M>>,
}

impl Peer for Adskalman {
    fn name(&self) -> &'static str {
        "adskalman 0.18, Joseph"
    }

    fn step(&mut self, k: usize) -> Result<(), Failure> {
        let filter = KalmanFilterNoControl::new(&self.matrices, &self.matrices);
        let z = &self.samples[k % self.samples.len()];
        self.state = filter.step(&self.state, z).map_err(|e| format!("{e:?}"))?;
        Ok(())
    }

    fn belief(&self) -> Gaussian {
        Gaussian {
            mean: DVector::from_column_slice(self.state.state().as_slice()),
            covariance: DMatrix::from_column_slice(N, N, self.state.covariance().as_slice()),
        }
    }
}

type Single = Kalman1M<f64, N, 0, M, LinearNoInputSystem<f64, N>, LinearMeasurement<f64, N, M>>;

struct Kfilter {
    filter: Single,
    samples: Vec<nalgebra34::SVector<f64, M>>,
}

impl Peer for Kfilter {
    fn name(&self) -> &'static str {
        "kfilter 0.5"
    }

    fn step(&mut self, k: usize) -> Result<(), Failure> {
        self.filter.predict().map_err(|_| "no prediction")?;
        let z = self.samples[k % self.samples.len()];
        self.filter.update(z).map_err(|_| "singular")?;
        Ok(())
    }

    fn belief(&self) -> Gaussian {
        Gaussian {
            mean: DVector::from_column_slice(self.filter.state().as_slice()),
            covariance: DMatrix::from_column_slice(N, N, self.filter.covariance().as_slice()),
        }
    }
}

struct KalmanFilters {
    filter: kalman_filters::KalmanFilter<f64>,
    samples: Vec<Vec<f64>>,
}

impl Peer for KalmanFilters {
    fn name(&self) -> &'static str {
        "kalman_filters 1.0"
    }

    fn step(&mut self, k: usize) -> Result<(), Failure> {
        self.filter.predict();
        let z = &self.samples[k % self.samples.len()];
        self.filter.update(z).map_err(|e| format!("{e:?}"))?;
        Ok(())
    }

    fn belief(&self) -> Gaussian {
        Gaussian {
            mean: DVector::from_column_slice(self.filter.state()),
            covariance: DMatrix::from_row_slice(N, N, self.filter.covariance()),
        }
    }
}

/// All filters at the prior, terra's first.
///
/// # Errors
/// What a filter refuses.
pub fn peers() -> Result<Vec<Box<dyn Peer>>, Failure> {
    let log = Log::without_inputs()?;
    let Textbook {
        a,
        q,
        c,
        r,
        prior,
        samples,
    } = log.textbook()?;
    let terra = |label, name| -> Result<Box<dyn Peer>, Failure> {
        Ok(Box::new(Terra {
            label,
            filter: log.filter(name, false)?,
            log: log.clone(),
        }))
    };
    let fixed: Vec<SVector<f64, M>> = samples
        .iter()
        .map(|z| SVector::from_column_slice(z.as_slice()))
        .collect();
    let old = |m: &DMatrix<f64>| nalgebra34::SMatrix::<f64, N, N>::from_fn(|i, j| m[(i, j)]);
    let system = LinearNoInputSystem::new(
        old(&a),
        old(&q),
        nalgebra34::SVector::from_column_slice(prior.mean.as_slice()),
    );
    let measurement = LinearMeasurement::new(
        nalgebra34::SMatrix::from_fn(|i, j| c[(i, j)]),
        nalgebra34::SMatrix::from_fn(|i, j| r[(i, j)]),
        nalgebra34::SVector::zeros(),
    );
    let initialised = kalman_filters::KalmanFilter::initialize(
        N,
        M,
        prior.mean.as_slice().to_vec(),
        rows(&prior.covariance),
        rows(&a),
        rows(&q),
        rows(&c),
        rows(&r),
    );
    let lanes = Lanes {
        filter: log.lanes()?,
        log: log.clone(),
    };
    Ok(vec![
        Box::new(lanes),
        terra("terra, block", "block")?,
        terra("terra, kf (dense, Joseph)", "kf")?,
        Box::new(Joseph {
            a: square(&a),
            q: square(&q),
            c: square(&c),
            r: square(&r),
            x: SVector::from_column_slice(prior.mean.as_slice()),
            p: square(&prior.covariance),
            samples: fixed.clone(),
        }),
        Box::new(Adskalman {
            matrices: Matrices {
                a: square(&a),
                at: square(&a.transpose()),
                q: square(&q),
                c: square(&c),
                ct: square(&c.transpose()),
                r: square(&r),
            },
            state: StateAndCovariance::new(
                SVector::from_column_slice(prior.mean.as_slice()),
                square(&prior.covariance),
            ),
            samples: fixed,
        }),
        Box::new(Kfilter {
            filter: Kalman1M::new_custom(system, old(&prior.covariance), measurement),
            samples: samples
                .iter()
                .map(|z| nalgebra34::SVector::from_column_slice(z.as_slice()))
                .collect(),
        }),
        Box::new(KalmanFilters {
            filter: initialised.map_err(|e| format!("{e:?}"))?,
            samples: samples.iter().map(|z| z.as_slice().to_vec()).collect(),
        }),
    ])
}

/// Runs a filter from the prior over the log and holds its belief against the textbook's in dynamic sizes.
///
/// # Errors
/// A filter that ends elsewhere.
pub fn check(peer: &mut dyn Peer) -> Result<(), Failure> {
    for k in 0..SAMPLES {
        peer.step(k)?;
    }
    let reference = Log::without_inputs()?.reference(SAMPLES)?;
    Ok(check_belief(peer.name(), &peer.belief(), &reference)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_filter_ends_where_the_textbook_ends() {
        for mut peer in peers().unwrap() {
            check(&mut *peer).unwrap();
        }
    }
}
