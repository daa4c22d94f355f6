//! Force observations straight from a law, and the soils it can be asked about.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use terra::mme::{ForceObservation, Hypothesis, HypothesisSet};
use terra::model::{Contact, ForceLaw, Law, catalogue};

pub(crate) const RADIUS: f64 = 0.254;
pub(crate) const WIDTH: f64 = 0.15;
/// Loads of a front and a rear wheel \[N\].
pub(crate) const LOADS: [f64; 2] = [230.0, 260.0];

pub(crate) fn contact(slip: f64, load: f64) -> Contact<f64> {
    Contact::new(slip, load, RADIUS, WIDTH)
}

/// Three soils that carry a 100 kg robot and pull differently.
pub(crate) fn soils(law: &Arc<Law>) -> HypothesisSet {
    let own = law.model().typical_parameters();
    let ids = ["dry_sand", "lean_clay_22", "upland_sandy_loam"];
    let mut place = 0;
    let hypotheses = ids.map(|id| {
        // A model that the catalogue knows no soils for has typical ones of its own.
        let mut parameters = catalogue::find(id)
            .unwrap()
            .parameters(law.model())
            .unwrap_or_else(|_| own[place].clone());
        place += 1;
        parameters.resize(law.params().len(), 0.0);
        Hypothesis {
            id: id.to_owned(),
            law: Arc::clone(law),
            parameters,
        }
    });
    HypothesisSet::new(hypotheses.to_vec()).unwrap()
}

/// Noise-free forces of `truth` over driving slips: a side's pull and two torques, or one wheel's pull and torque.
pub(crate) fn observations(truth: &Hypothesis, wheels: usize) -> Vec<ForceObservation> {
    let map = ForceObservation::side_map(wheels);
    (0..12)
        .map(|k| {
            let contacts: Vec<_> = LOADS[..wheels]
                .iter()
                .map(|w| contact(0.06 + 0.07 * k as f64, *w))
                .collect();
            let mut forces = DVector::zeros(3 * wheels);
            for (wheel, at) in contacts.iter().enumerate() {
                let f = truth.law.forces(&truth.parameters, at).unwrap();
                forces[3 * wheel] = f.drawbar_pull;
                forces[3 * wheel + 1] = f.resistive_torque;
            }
            // Pull 2 N, torques .5 N m, slips .002, loads 1 N.
            let sd = [vec![2.0], vec![0.5; wheels], [0.002, 1.0].repeat(wheels)].concat();
            ForceObservation {
                time: 0.01 * k as f64,
                group: 0,
                forces: &map * forces,
                map: map.clone(),
                contacts,
                covariance: DMatrix::from_diagonal(&DVector::from_vec(sd).map(|s| s * s)),
            }
        })
        .collect()
}
