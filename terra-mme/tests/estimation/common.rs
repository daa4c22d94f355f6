//! Forces straight from a law with Gaussian noise on forces, slips and loads, correlated in time when asked.

use std::sync::Arc;

use chacha20::ChaCha8Rng;
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use terra_mme::{ForceObservation, HypothesisSet};
use terra_model::{
    Contact, ForceLaw, Law, ModelError, Param, Real, Registry, Scale, TerrainModel, WheelForces,
    catalogue,
};

pub(crate) const RADIUS: f64 = 0.254;
pub(crate) const WIDTH: f64 = 0.15;
/// Load of one wheel of the 100 kg vehicle [N].
pub(crate) const LOAD: f64 = 245.25;
/// 1-sigma of side force, torque, slip and load of a force filter.
pub(crate) const SD: [f64; 4] = [2.3, 0.66, 0.004, 1.0];

pub(crate) fn law() -> Arc<Law> {
    Arc::new(Registry::builtin().law("wong-reece").unwrap())
}

pub(crate) fn wong21() -> HypothesisSet {
    HypothesisSet::from_catalogue(&law(), "wong21").unwrap()
}

pub(crate) fn soil(id: &str) -> Vec<f64> {
    catalogue::find(id)
        .unwrap()
        .parameters(law().model())
        .unwrap()
}

/// The rows of `wong21` that carry the light vehicle at every slip.
pub(crate) fn firm() -> Vec<&'static str> {
    catalogue::terrains()
        .iter()
        .filter(|t| t.set == "wong21" && t.class != "snow")
        .map(|t| t.id.as_ref())
        .collect()
}

pub(crate) fn rng(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

pub(crate) fn contact(slip: f64, load: f64) -> Contact<f64> {
    Contact::new(slip, load, RADIUS, WIDTH)
}

/// From 1 down towards 0: a vehicle that starts at rest under a falling torque.
pub(crate) fn sweep(n: usize, from: f64, to: f64) -> Vec<f64> {
    (0..n)
        .map(|k| from + (to - from) * k as f64 / (n - 1).max(1) as f64)
        .collect()
}

/// Side sum and both torques of a front and a rear wheel, 10 ms apart; noise of lag-1 correlation `rho` (stationary).
pub(crate) fn side(
    p: &[f64],
    slips: &[f64],
    loads: [f64; 2],
    rho: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<ForceObservation> {
    let law = law();
    let map = ForceObservation::side_map(2);
    let sd = [SD[0], SD[1], SD[1], SD[2], SD[3], SD[2], SD[3]];
    let mut noise: Vec<f64> = sd.iter().map(|s| s * normal(rng)).collect();
    let mut out = Vec::new();
    for (k, &slip) in slips.iter().enumerate() {
        if k > 0 {
            for (e, s) in noise.iter_mut().zip(&sd) {
                *e = rho * *e + (1.0 - rho * rho).sqrt() * s * normal(rng);
            }
        }
        let mut forces = DVector::zeros(6);
        for (wheel, load) in loads.iter().enumerate() {
            let f = law.forces(p, &contact(slip, *load)).unwrap();
            forces[3 * wheel] = f.drawbar_pull;
            forces[3 * wheel + 1] = f.resistive_torque;
        }
        let y = &map * forces + DVector::from_column_slice(&noise[..3]);
        let seen = |wheel: usize| {
            let slip = (slip + noise[3 + 2 * wheel]).clamp(-1.0, 1.0);
            contact(slip, loads[wheel] + noise[4 + 2 * wheel])
        };
        out.push(ForceObservation {
            time: 0.01 * k as f64,
            group: 0,
            forces: y,
            map: map.clone(),
            contacts: vec![seen(0), seen(1)],
            covariance: DMatrix::from_diagonal(&DVector::from_column_slice(&sd).map(|s| s * s)),
        });
    }
    out
}

/// A world without slip and load: pull and torque are the parameters themselves.
#[derive(Default)]
pub(crate) struct Constant;

const fn plain(name: &'static str, unit: &'static str) -> Param {
    Param {
        name,
        symbol: name,
        unit,
        min: -1e6,
        max: 1e6,
        scale: Scale::Linear,
        prior_sd: 1.0,
        doc: "itself",
    }
}

impl TerrainModel for Constant {
    const NAME: &'static str = "constant";
    const SUMMARY: &'static str = "forces that are parameters";
    const PARAMS: &'static [Param] = &[plain("pull", "N"), plain("torque", "N m")];
    const REFERENCE: &'static str = "none";
    fn wheel_forces<T: Real>(&self, p: &[T], _: &Contact<T>) -> Result<WheelForces<T>, ModelError> {
        Ok(WheelForces::from_thrust(p[0], T::zero(), p[1]))
    }
}

pub(crate) fn constants(vectors: &[[f64; 2]]) -> HypothesisSet {
    let law = Arc::new(
        Registry::empty()
            .with_model::<Constant>()
            .law("constant")
            .unwrap(),
    );
    HypothesisSet::from_vectors(&law, "c", vectors.iter().map(|v| v.to_vec())).unwrap()
}

/// Pull and torque of one wheel with a given covariance of both; slip and load known.
pub(crate) fn pair(time: f64, group: usize, y: [f64; 2], s: &DMatrix<f64>) -> ForceObservation {
    let mut covariance = DMatrix::zeros(4, 4);
    covariance.view_mut((0, 0), (2, 2)).copy_from(s);
    ForceObservation {
        time,
        group,
        forces: DVector::from_column_slice(&y),
        map: DMatrix::from_row_slice(2, 3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        contacts: vec![contact(0.2, LOAD)],
        covariance,
    }
}
