//! Filters and state spaces by name.

use std::sync::Arc;

use terra_model::nearest;

use crate::config::FilterConfig;
use crate::error::FilterError;
use crate::filter::Filter;
use crate::filters::{
    BlockFilter, DenseFilter, Extended, Factored, Iterated, Linear, Particle, SigmaPoint,
    SquareRoot, UnitDiagonal,
};
use crate::spaces::{LongitudinalRobot, PlanarRobot, SingleWheelRig};
use crate::state_space::AnyStateSpace;

/// Makes a filter for a state space.
pub type BuildFilter =
    fn(Arc<dyn AnyStateSpace>, FilterConfig) -> Result<Box<dyn Filter>, FilterError>;
/// Makes a state space with its default numbers.
pub type BuildSpace = fn() -> Result<Arc<dyn AnyStateSpace>, FilterError>;

/// A filter as the registry knows it.
#[derive(Clone, Copy, Debug)]
pub struct FilterEntry {
    /// Kebab-case name.
    pub name: &'static str,
    /// One line: what it does.
    pub summary: &'static str,
    /// Where it comes from.
    pub reference: &'static str,
    /// True when it takes linear state spaces only.
    pub linear_only: bool,
    /// Makes one.
    pub build: BuildFilter,
}

/// A state space as the registry knows it.
#[derive(Clone, Copy, Debug)]
pub struct SpaceEntry {
    /// Kebab-case name.
    pub name: &'static str,
    /// Makes one with its default numbers.
    pub build: BuildSpace,
}

/// The filters terra ships.
pub const FILTERS: &[FilterEntry] = &[
    FilterEntry {
        name: "block",
        summary: "Kalman filter on independent groups of states; the default for robots",
        reference: "G. J. Bierman, Factorization Methods for Discrete Sequential Estimation (1977), ch. V",
        linear_only: true,
        build: |space, config| Ok(Box::new(BlockFilter::new(space, config)?)),
    },
    FilterEntry {
        name: "kf",
        summary: "Kalman filter of a linear time-invariant state space",
        reference: "R. E. Kalman, J. Basic Engineering 82 (1960)",
        linear_only: true,
        build: |space, config| {
            Ok(Box::new(DenseFilter::new(
                Linear::new(&*space)?,
                space,
                config,
            )?))
        },
    },
    FilterEntry {
        name: "ekf",
        summary: "extended Kalman filter, continuous-discrete, exact Jacobians",
        reference: "A. H. Jazwinski, Stochastic Processes and Filtering Theory (1970)",
        linear_only: false,
        build: |space, config| Ok(Box::new(DenseFilter::new(Extended, space, config)?)),
    },
    FilterEntry {
        name: "iekf",
        summary: "extended Kalman filter with the update iterated to the mode",
        reference: "B. M. Bell and F. W. Cathey, IEEE Trans. Automatic Control 38 (1993)",
        linear_only: false,
        build: |space, config| Ok(Box::new(DenseFilter::new(Iterated, space, config)?)),
    },
    FilterEntry {
        name: "srkf",
        summary: "extended Kalman filter that carries a square root of its covariance",
        reference: "G. J. Bierman, Factorization Methods for Discrete Sequential Estimation (1977), sec. II.7",
        linear_only: false,
        build: |space, config| {
            let method = Factored::<SquareRoot>::new(&space.prior())?;
            Ok(Box::new(DenseFilter::new(method, space, config)?))
        },
    },
    FilterEntry {
        name: "ud",
        summary: "extended Kalman filter that carries U D U' for its covariance",
        reference: "G. J. Bierman, Factorization Methods for Discrete Sequential Estimation (1977), secs. V.3, VI.4",
        linear_only: false,
        build: |space, config| {
            let method = Factored::<UnitDiagonal>::new(&space.prior())?;
            Ok(Box::new(DenseFilter::new(method, space, config)?))
        },
    },
    FilterEntry {
        name: "ukf",
        summary: "unscented Kalman filter, 2n + 1 points",
        reference: "S. J. Julier and J. K. Uhlmann, Proc. IEEE 92 (2004)",
        linear_only: false,
        build: |space, config| {
            let method = SigmaPoint::unscented(space.dims().state, config.unscented)?;
            Ok(Box::new(DenseFilter::new(method, space, config)?))
        },
    },
    FilterEntry {
        name: "ckf",
        summary: "cubature Kalman filter, 2n points",
        reference: "I. Arasaratnam and S. Haykin, IEEE Trans. Automatic Control 54 (2009)",
        linear_only: false,
        build: |space, config| {
            let method = SigmaPoint::cubature(space.dims().state);
            Ok(Box::new(DenseFilter::new(method, space, config)?))
        },
    },
    FilterEntry {
        name: "particle",
        summary: "weighted samples of what is nonlinear, the rest marginalised; on a linear space the Kalman filter",
        reference: "A. Doucet, N. de Freitas, K. Murphy and S. Russell, Proc. UAI (2000)",
        linear_only: false,
        build: |space, config| {
            let method = Particle::new(&*space, config.particles)?;
            Ok(Box::new(DenseFilter::new(method, space, config)?))
        },
    },
];

/// The state spaces terra ships.
pub const STATE_SPACES: &[SpaceEntry] = &[
    SpaceEntry {
        name: "longitudinal-robot",
        build: || Ok(Arc::new(LongitudinalRobot::light()?)),
    },
    SpaceEntry {
        name: "planar-robot",
        build: || Ok(Arc::new(PlanarRobot::light()?)),
    },
    SpaceEntry {
        name: "single-wheel-rig",
        build: || Ok(Arc::new(SingleWheelRig::default().checked()?)),
    },
];

/// All filters and state spaces that can be asked for by name; a user's own join with one line.
#[derive(Clone, Debug)]
pub struct Registry {
    filters: Vec<FilterEntry>,
    spaces: Vec<SpaceEntry>,
}

impl Registry {
    /// Everything terra ships.
    pub fn builtin() -> Self {
        Registry {
            filters: FILTERS.to_vec(),
            spaces: STATE_SPACES.to_vec(),
        }
    }

    /// Adds a filter.
    #[must_use]
    pub fn with_filter(mut self, entry: FilterEntry) -> Self {
        self.filters.push(entry);
        self
    }

    /// Adds a state space.
    #[must_use]
    pub fn with_state_space(mut self, entry: SpaceEntry) -> Self {
        self.spaces.push(entry);
        self
    }

    /// The filters.
    pub fn filters(&self) -> &[FilterEntry] {
        &self.filters
    }

    /// The state spaces.
    pub fn state_spaces(&self) -> &[SpaceEntry] {
        &self.spaces
    }

    /// A filter of that name over a state space, from its prior.
    ///
    /// # Errors
    /// [`FilterError::UnknownName`] with the nearest known name, or what the filter's own construction raises.
    pub fn filter(
        &self,
        name: &str,
        space: Arc<dyn AnyStateSpace>,
        config: FilterConfig,
    ) -> Result<Box<dyn Filter>, FilterError> {
        match self.filters.iter().find(|f| f.name == name) {
            Some(entry) => (entry.build)(space, config),
            None => Err(unknown("filter", name, self.filters.iter().map(|f| f.name))),
        }
    }

    /// A state space of that name with its default numbers.
    ///
    /// # Errors
    /// [`FilterError::UnknownName`] with the nearest known name.
    pub fn state_space(&self, name: &str) -> Result<Arc<dyn AnyStateSpace>, FilterError> {
        match self.spaces.iter().find(|s| s.name == name) {
            Some(entry) => (entry.build)(),
            None => Err(unknown(
                "state space",
                name,
                self.spaces.iter().map(|s| s.name),
            )),
        }
    }
}

fn unknown<'a>(
    kind: &'static str,
    name: &str,
    known: impl Iterator<Item = &'a str>,
) -> FilterError {
    FilterError::UnknownName {
        kind,
        name: name.to_owned(),
        nearest: nearest(name, known).map(str::to_owned),
    }
}
