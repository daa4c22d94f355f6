//! The filter `block` for a caller who wants mean and covariance alone: no innovations by channel, no robust update, no
//! smoother, and a third of the work.

use std::sync::Arc;

use super::Model;
use super::account::{Refusal, Score, take};
use super::block::BlockFilter;
use super::group::Group;
use super::lane::WIDTH;
use super::lanes::Lanes;
use super::moments::Moments;
use crate::config::FilterConfig;
use crate::error::FilterError;
use crate::gaussian::Gaussian;
use crate::measurement::Measurement;
use crate::state_space::AnyStateSpace;

/// A Kalman filter over independent groups of at most three states and two channels, several groups in each vector of the
/// processor; the same belief as [`BlockFilter`]'s.
///
/// ```
/// use std::sync::Arc;
/// use terra_ekf::spaces::LongitudinalRobot;
/// use terra_ekf::{LaneFilter, Measurement};
///
/// let mut filter = LaneFilter::new(Arc::new(LongitudinalRobot::light()?))?;
/// let at_rest = Measurement::full(&[0.0; 7]);
/// for _ in 0..100 {
///     filter.predict(&[0.0; 4], 0.01)?;
///     filter.update(&at_rest)?;
/// }
/// let belief = filter.belief();
/// assert!(belief.mean.amax() < 1e-9 && belief.covariance[(0, 0)] < 0.01 * 0.01);
/// # Ok::<(), terra_ekf::FilterError>(())
/// ```
#[derive(Clone)]
pub struct LaneFilter {
    model: Model,
    groups: Vec<Group>,
    lanes: Lanes,
    channels: usize,
    shares: Vec<Shares>,
    time: f64,
}

/// What the moments of one vector's groups add to those of all states.
#[derive(Clone, Default)]
struct Shares {
    mean: Vec<Share>,
    covariance: Vec<Share>,
}

/// A number of the moments, the place it goes to (of a matrix by columns), and how much of it.
#[derive(Clone, Copy)]
struct Share {
    from: usize,
    to: usize,
    weight: f64,
}

/// x = M⁻¹ y and P = M⁻¹ P_y M⁻ᵀ, number by number.
fn shares(groups: &[Group], n: usize) -> Vec<Shares> {
    let mut all = vec![Shares::default(); groups.len().div_ceil(WIDTH)];
    for (k, g) in groups.iter().enumerate() {
        let (vector, place) = (&mut all[k / WIDTH], k % WIDTH);
        for &(i, a, left) in &g.out {
            vector.mean.push(Share {
                from: Moments::mean_place(a) * WIDTH + place,
                to: i,
                weight: left,
            });
            vector
                .covariance
                .extend(g.out.iter().map(|&(j, b, right)| Share {
                    from: Moments::covariance_place(a, b) * WIDTH + place,
                    to: i + n * j,
                    weight: left * right,
                }));
        }
    }
    all
}

impl LaneFilter {
    /// A filter that starts from the state space's prior.
    ///
    /// # Errors
    /// As [`BlockFilter::new`]; [`FilterError::NoLanes`] where a group is too large.
    pub fn new(space: Arc<dyn AnyStateSpace>) -> Result<Self, FilterError> {
        let block = BlockFilter::new(space, FilterConfig::default())?;
        Self::of(block)
    }

    /// A filter that starts from another belief.
    ///
    /// # Errors
    /// As [`new`](Self::new), or a belief that is none.
    pub fn from_belief(
        space: Arc<dyn AnyStateSpace>,
        belief: Gaussian,
    ) -> Result<Self, FilterError> {
        use crate::filter::Filter as _;
        let mut block = BlockFilter::new(space, FilterConfig::default())?;
        block.restart(belief)?;
        Self::of(block)
    }

    fn of(block: BlockFilter) -> Result<Self, FilterError> {
        let BlockFilter {
            model,
            groups,
            lanes,
            ..
        } = block;
        let most = |size: fn(&Group) -> usize| groups.iter().map(size).max().unwrap_or(0);
        let lanes = lanes.ok_or_else(|| FilterError::NoLanes {
            space: model.space.name(),
            states: most(|g| g.states.len()),
            channels: most(|g| g.channels.len()),
        })?;
        Ok(LaneFilter {
            shares: shares(&groups, model.prior.dim()),
            channels: model.space.dims().measurement,
            model,
            groups,
            lanes,
            time: 0.0,
        })
    }

    /// The state space.
    pub fn space(&self) -> &dyn AnyStateSpace {
        &*self.model.space
    }

    /// Moves the belief `dt` \[s\] ahead under the input `u`, held over the step. Nothing is changed when it fails.
    ///
    /// # Errors
    /// [`FilterError::TimeStep`], [`FilterError::Size`], [`FilterError::NotFinite`], or whatever the state space raises.
    pub fn predict(&mut self, u: &[f64], dt: f64) -> Result<(), FilterError> {
        let (model, groups) = (&self.model, &mut self.groups);
        self.lanes
            .predict::<false>(model, groups, u, dt, self.time)?;
        self.time += dt;
        Ok(())
    }

    /// Takes one sample in; missing channels are dropped rows. Nothing is changed when it fails.
    ///
    /// # Errors
    /// [`FilterError::Size`], [`FilterError::SingularInnovation`], [`FilterError::NotFinite`].
    pub fn update(&mut self, z: &Measurement) -> Result<(), FilterError> {
        self.take::<false>(z).map(|_| ())
    }

    /// The same, and how likely the sample was before it.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    pub fn update_scored(&mut self, z: &Measurement) -> Result<Score, FilterError> {
        self.take::<true>(z)
    }

    #[inline]
    fn take<const SCORE: bool>(&mut self, z: &Measurement) -> Result<Score, FilterError> {
        if z.len() != self.channels {
            return Err(FilterError::Size {
                what: "measurement",
                expected: self.channels,
                found: z.len(),
            });
        }
        take::<SCORE>(&mut self.lanes, z.as_slice()).map_err(|refusal| match refusal {
            Refusal::Singular { channel } => FilterError::SingularInnovation {
                channel: self.model.channel(channel),
            },
            Refusal::NotFinite => FilterError::NotFinite {
                what: "mean or covariance",
                index: 0,
            },
        })
    }

    /// Mean and covariance now.
    pub fn belief(&self) -> Gaussian {
        let n = self.model.prior.dim();
        let mut belief = Gaussian {
            mean: nalgebra::DVector::zeros(n),
            covariance: nalgebra::DMatrix::zeros(n, n),
        };
        self.add_to(&mut belief);
        belief
    }

    /// The same in the room of an old one.
    ///
    /// # Errors
    /// [`FilterError::Size`].
    pub fn belief_into(&self, belief: &mut Gaussian) -> Result<(), FilterError> {
        let n = self.model.prior.dim();
        for found in [
            belief.mean.len(),
            belief.covariance.nrows(),
            belief.covariance.ncols(),
        ] {
            if found != n {
                return Err(FilterError::Size {
                    what: "belief",
                    expected: n,
                    found,
                });
            }
        }
        belief.mean.as_mut_slice().fill(0.0);
        belief.covariance.as_mut_slice().fill(0.0);
        self.add_to(belief);
        Ok(())
    }

    fn add_to(&self, belief: &mut Gaussian) {
        let mean = belief.mean.as_mut_slice();
        let covariance = belief.covariance.as_mut_slice();
        for (k, shares) in self.shares.iter().enumerate() {
            let rows = self.lanes.moments(k).rows();
            let numbers = rows.as_flattened();
            for (to, shares) in [
                (&mut *mean, &shares.mean),
                (&mut *covariance, &shares.covariance),
            ] {
                for share in shares {
                    if let (Some(to), Some(x)) = (to.get_mut(share.to), numbers.get(share.from)) {
                        *to += share.weight * x;
                    }
                }
            }
        }
    }
}
