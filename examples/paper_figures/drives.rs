//! The torque ramp of the light robot, and what side sums make of it.

use std::sync::Arc;

use terra::data::DriveLog;
use terra::ekf::spaces::longitudinal_robot::{
    LongitudinalRobot, PriorSpread, ProcessNoise, SensorNoise,
};
use terra::ekf::{Flag, ForceConfig, RobotLog, Side, SideForces, estimate_forces, side_forces};
use terra::mme::{Hypothesis, HypothesisSet};
use terra::model::{Law, Registry};
use terra::sim::{DriveTruth, paper, simulate_drive};
use terra_cli::{Group, IdentifyOptions, identify_drive_among};

/// The paper's dry sand, sandy loam and lean clay.
pub(crate) const SOILS: [&str; 3] = ["dry_sand", "upland_sandy_loam", "lean_clay_22"];

/// Spread of perturbed parameters.
const OFF: f64 = 0.1;

/// The law and the 21 soils of the paper.
pub(crate) struct Soils {
    pub(crate) registry: Registry,
    pub(crate) law: Arc<Law>,
    pub(crate) set: HypothesisSet,
}

impl Soils {
    pub(crate) fn of_the_paper() -> Self {
        let registry = Registry::builtin();
        let law = Arc::new(registry.law("wong-reece").unwrap());
        let set = HypothesisSet::from_catalogue(&law, "wong21").unwrap();
        Soils { registry, law, set }
    }

    pub(crate) fn parameters(&self, soil: &str) -> Vec<f64> {
        let hypotheses = self.set.hypotheses();
        let h = hypotheses.iter().find(|h| h.id == soil).unwrap();
        h.parameters.clone()
    }
}

/// One ramp on one soil, and the posterior of its left side.
pub(crate) struct Drive {
    pub(crate) soil: &'static str,
    pub(crate) truth: DriveTruth,
    /// Forces of the left side from the 20th sample on, with the row each belongs to.
    pub(crate) forces: Vec<(usize, SideForces)>,
    /// Soils that were weighed; each keeps the catalogue's name.
    pub(crate) set: Vec<Hypothesis>,
    pub(crate) left: Group,
}

impl Drive {
    /// Whether the soil's own name is the most probable after `samples` of them.
    pub(crate) fn named(&self, samples: usize) -> bool {
        let row = &self.history().probability[samples - 1];
        self.best(row) == self.soil
    }

    pub(crate) fn named_at_end(&self) -> bool {
        self.best(self.history().probability.last().unwrap()) == self.soil
    }

    pub(crate) fn winner(&self) -> &str {
        self.left.map.as_deref().unwrap()
    }

    /// Probability of a soil after each sample.
    pub(crate) fn probability(&self, soil: &str) -> Vec<f64> {
        let column = self.history().ids.iter().position(|id| id == soil).unwrap();
        let rows = &self.history().probability;
        rows.iter().map(|row| row[column]).collect()
    }

    /// Mean of a function of the parameters over the posterior, after each sample (eq. 24).
    pub(crate) fn mean(&self, what: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        let value: Vec<f64> = self.set.iter().map(|h| what(&h.parameters)).collect();
        let rows = &self.history().probability;
        let mean = |row: &Vec<f64>| row.iter().zip(&value).map(|(p, v)| p * v).sum();
        rows.iter().map(mean).collect()
    }

    pub(crate) fn time(&self) -> &[f64] {
        &self.history().time
    }

    fn history(&self) -> &terra::mme::History {
        self.left.history.as_ref().unwrap()
    }

    fn best(&self, row: &[f64]) -> &str {
        let best = (0..row.len()).fold(0, |b, j| if row[j] > row[b] { j } else { b });
        &self.history().ids[best]
    }
}

/// The soil itself is in the set.
pub(crate) fn exact(soils: &Soils, soil: &'static str, seed: u64, run: u64) -> Drive {
    drive(soils, soil, seed, run, soils.set.clone())
}

/// Every soil of the set is 10 % off in every parameter, each draw in its own way; the soil itself is not in the set.
pub(crate) fn perturbed(soils: &Soils, soil: &'static str, seed: u64, run: u64) -> Drive {
    let copies = soils.set.perturbed(1, OFF, seed + run).unwrap();
    let named = copies.hypotheses().iter().map(|h| Hypothesis {
        id: h.id.trim_end_matches("~1").to_owned(),
        ..h.clone()
    });
    let set = HypothesisSet::new(named.collect()).unwrap();
    drive(soils, soil, seed, run, set)
}

fn drive(soils: &Soils, soil: &'static str, seed: u64, run: u64, set: HypothesisSet) -> Drive {
    let rover = paper::light_rover();
    let mut scenario = paper::torque_ramp(soil, seed).unwrap();
    scenario.run = run;
    let driven = simulate_drive(&scenario, &rover, &soils.registry).unwrap();
    let options = IdentifyOptions {
        history: true,
        refine: false,
        check: false,
        ..IdentifyOptions::default()
    };
    let told = identify_drive_among(&driven.log, &rover, &soils.registry, &set, &options).unwrap();
    Drive {
        soil,
        forces: left_side(&driven.log),
        truth: driven.truth,
        set: set.hypotheses().to_vec(),
        left: told.groups.into_iter().next().unwrap(),
    }
}

/// The force filter over a log: it knows no soil.
fn left_side(log: &DriveLog) -> Vec<(usize, SideForces)> {
    let rover = paper::light_rover();
    let sd = |channel| rover.noise.get(channel).unwrap();
    let sensors = SensorNoise {
        accel_x: sd("accel_x_m_s2"),
        wheel_speed: sd("wheel_speed_rad_s"),
        ground_speed: sd("ground_speed_m_s"),
        yaw_rate: sd("yaw_rate_rad_s"),
    };
    let space = LongitudinalRobot::new(
        rover.nominal_vehicle().unwrap(),
        sensors,
        ProcessNoise::default(),
        PriorSpread::default(),
    )
    .unwrap();
    let column = |s: &terra::data::Series| s.iter().collect::<Vec<Option<f64>>>();
    let torque = log.wheel_torque.as_ref().unwrap().each_ref().map(column);
    let [fl, fr, rl, rr] = log.wheel_speed.each_ref().map(column);
    let channels = [
        column(log.accel_x.as_ref().unwrap()),
        fl,
        fr,
        rl,
        rr,
        column(log.ground_speed.as_ref().unwrap()),
        column(log.yaw_rate.as_ref().unwrap()),
    ];
    let robot = RobotLog {
        time: &log.time,
        segments: std::slice::from_ref(&log.segments[0].rows),
        torque: torque.each_ref().map(Vec::as_slice),
        channels: channels.each_ref().map(Vec::as_slice),
        pitch: &[],
        payload: &[],
    };
    let steps = estimate_forces(&robot, &ForceConfig::new(space)).unwrap();
    let settled = steps.iter().filter(|s| s.flag != Flag::Starting);
    settled
        .map(|s| {
            (
                s.row,
                side_forces(&s.belief, &s.vehicle, Side::Left).unwrap(),
            )
        })
        .collect()
}
