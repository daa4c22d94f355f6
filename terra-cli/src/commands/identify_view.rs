//! What the report shows of an identification.

use terra_data::{Measured, RigLog, Rover};
use terra_mme::{
    ForcePrediction, History, HypothesisSet, ParameterBelief, Spread, StructureBelief,
};

use crate::identify::{Group, Identification};
use crate::report::{ForceSlip, GroupView, IdentifyView, MeasuredForces, ParameterPath};

/// Relative difference of load within which a measured row belongs to the curves.
const SAME_LOAD: f64 = 0.05;

/// What an identification rests on.
pub(crate) struct Context<'a> {
    pub(crate) title: &'a str,
    /// The true soil, where a simulation knows it.
    pub(crate) truth: Option<&'a str>,
    /// What was weighed.
    pub(crate) set: &'a HypothesisSet,
    pub(crate) rover: &'a Rover,
    /// The log of a rig.
    pub(crate) measured: Option<&'a RigLog>,
}

/// What the report shows of an identification.
pub(crate) fn view(id: &Identification, context: &Context<'_>) -> IdentifyView {
    IdentifyView {
        title: context.title.to_owned(),
        groups: id
            .groups
            .iter()
            .map(|g| group(g, id.groups.len() == 1, context))
            .collect(),
    }
}

fn group(g: &Group, only: bool, context: &Context<'_>) -> GroupView {
    let history = g.history.as_ref();
    GroupView {
        name: g.name.clone(),
        time: history.map(|h| h.time.clone()).unwrap_or_default(),
        ids: history.map(|h| h.ids.clone()).unwrap_or_default(),
        probability: history.map(|h| h.probability.clone()).unwrap_or_default(),
        posterior: g
            .posterior
            .iter()
            .map(|p| (p.id.clone(), p.probability))
            .collect(),
        parameters: history
            .map(|h| paths(g, h, context.set))
            .unwrap_or_default(),
        force_slip: force_slip(g, only, context),
        truth: context.truth.map(str::to_owned),
        undetermined: g
            .refined
            .as_ref()
            .map(|r| r.fit.identifiability.undetermined.clone())
            .unwrap_or_default(),
        alarm: g
            .consistency
            .alarm
            .then(|| g.consistency.reason.clone().unwrap_or_default()),
    }
}

/// Mean and spread of each parameter after each step, where all soils obey one law.
fn paths(g: &Group, history: &History, set: &HypothesisSet) -> Vec<ParameterPath> {
    if set.structures().len() != 1 {
        return vec![];
    }
    // The columns of the history, in the order of the set.
    let columns: Vec<Option<usize>> = set
        .hypotheses()
        .iter()
        .map(|h| history.ids.iter().position(|id| *id == h.id))
        .collect();
    let mut paths: Vec<ParameterPath> = vec![];
    for row in &history.probability {
        let weights: Vec<f64> = columns
            .iter()
            .map(|c| c.and_then(|c| row.get(c)).copied().unwrap_or(0.0))
            .collect();
        let ParameterBelief::Shared(belief) = ParameterBelief::of(set, &weights) else {
            return vec![];
        };
        if paths.is_empty() {
            paths = names(&belief);
        }
        for (path, (mean, sd)) in paths.iter_mut().zip(values(&belief)) {
            path.mean.push(mean);
            path.sd.push(sd);
        }
    }
    if let Ok(refined) = &g.refined {
        for p in refined.fit.fitted() {
            if let Some(path) = paths.iter_mut().find(|path| path.name == p.name) {
                path.refined = Some((p.value, p.sd));
            }
        }
    }
    // What no soil of the set differs in has nothing to settle.
    paths.retain(|p| p.sd.iter().any(|sd| *sd > 0.0));
    paths
}

fn names(belief: &StructureBelief) -> Vec<ParameterPath> {
    let named = belief.names.iter().zip(&belief.units);
    named
        .map(|(name, unit)| ParameterPath {
            name: (*name).to_owned(),
            unit: (*unit).to_owned(),
            ..ParameterPath::default()
        })
        .collect()
}

fn values(belief: &StructureBelief) -> impl Iterator<Item = (f64, f64)> + '_ {
    let means = belief.mean.iter().enumerate();
    means.map(|(k, mean)| (*mean, belief.sd(k).unwrap_or(f64::NAN)))
}

/// The prediction at the middle one of its loads, and what was measured there.
fn force_slip(g: &Group, only: bool, context: &Context<'_>) -> Option<ForceSlip> {
    let middle = g.force_prediction.get(g.force_prediction.len() / 2)?;
    let load = middle.normal_load;
    let at_load: Vec<&ForcePrediction> = g
        .force_prediction
        .iter()
        .filter(|p| (p.normal_load - load).abs() < 1e-9)
        .filter(|p| p.drawbar_pull.is_some() && p.torque.is_some())
        .collect();
    let column = |of: fn(&ForcePrediction) -> Option<Spread>| {
        let value = |s: Option<Spread>| s.map_or((f64::NAN, f64::NAN), |s| (s.mean, s.sd));
        at_load.iter().map(|p| value(of(p))).collect()
    };
    let wheel = match context.rover.conditions.get(&g.name) {
        Some(condition) => condition.wheel,
        None => context.rover.wheel,
    };
    (!at_load.is_empty()).then(|| ForceSlip {
        load,
        radius: wheel.radius,
        slip: at_load.iter().map(|p| p.slip).collect(),
        drawbar: column(|p| p.drawbar_pull),
        torque: column(|p| p.torque),
        sinkage: column(|p| p.sinkage),
        measured: context
            .measured
            .map(|log| measured(log, &g.name, only, load, context.rover))
            .unwrap_or_default(),
    })
}

/// Rows of the group at about that load, with the sd of the row or of the rover file.
fn measured(
    log: &RigLog,
    group: &str,
    only: bool,
    load: f64,
    rover: &Rover,
) -> Vec<MeasuredForces> {
    let sd = |m: &Measured, channel: &str| {
        m.sd.or_else(|| rover.noise.get(channel))
            .unwrap_or(f64::NAN)
    };
    let value = |m: &Option<Measured>, channel: &str| match m {
        Some(m) => (m.value, sd(m, channel)),
        None => (f64::NAN, f64::NAN),
    };
    log.rows
        .iter()
        .filter(|r| only || r.condition == group)
        .filter(|r| (r.normal_load.value / load - 1.0).abs() < SAME_LOAD)
        .map(|r| MeasuredForces {
            trial: r.trial.clone(),
            slip: (r.slip.value, sd(&r.slip, "slip")),
            drawbar: value(&r.drawbar_pull, "drawbar_pull_N"),
            torque: value(&r.torque, "torque_N_m"),
            sinkage: value(&r.sinkage, "sinkage_m"),
        })
        .collect()
}
