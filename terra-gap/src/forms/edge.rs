//! Ground that becomes another one at a place: the soil changes along the path at once, and in all that a soil is.
//!
//! # Equation
//! u = (1 + tanh(2 (x + d - x0)/l))/2, d: how far the wheel is ahead of the vehicle's centre; k e^(a u), c e^(b u), tan φ e^(d u), K e^(g u), n + m u
//!
//! # Source
//! Chosen form; a change of soil type over a few metres as a boundary between deposits. Smooth formulas along the path
//! ([`super::free`]) cannot follow it, nor can one factor on stiffness and cohesion make clay of sand.

use std::sync::Arc;

use terra_model::order::ascending;
use terra_model::{
    AnyEffect, BodyLoads, Channel, Circumstance, Contact, Dual8, EffectAt, Hook, LaneDual, Lanes,
    Motion, Param, Real, Scale, Scope, Soil, Touch, Vehicle, WheelForces,
};

use crate::dataset::DataSet;
use crate::parallel::for_each;
use crate::weigh::{Weighed, contest, weigh};

use super::Ground;

/// Name of this form in reports.
pub(crate) const EDGE: &str = "edge";
/// The effect whose form it is.
pub(super) const OF: &str = "terrain-drift";

/// Places that are looked at first, and those of them from which a way to all windows is gone.
const PLACES: (usize, usize) = (9, 2);
/// Changes of the cohesion \[prior sd\] from which the best of these are gone on with too.
const OTHERWISE: [f64; 2] = [-2.0, 2.0];
/// Smallest length of the change \[m\]: about that of a wheel's contact, and of a window. Where it is less, a place hardly shows
/// which way is the better one.
const SHORTEST: f64 = 0.3;
/// Prior sd of that length \[m\].
const LENGTH: f64 = 2.0;

/// What of the soil changes: the hook, its name, the prior sd of the change (of its logarithm, but for the exponent, where it is the
/// change itself), and what it is. Prior sds are about those between the soils of Wong's table.
const CHANGES: [(Hook, &str, f64, &str); 5] = [
    (
        Hook::Stiffness,
        "magnitude",
        1.0,
        "ln growth of the stiffness",
    ),
    (Hook::Cohesion, "cohesion", 2.0, "ln growth of the cohesion"),
    (Hook::Friction, "friction", 0.3, "ln growth of tan φ"),
    (
        Hook::ShearModulus,
        "shear_modulus",
        1.0,
        "ln growth of the shear modulus",
    ),
    (
        Hook::SinkageExponent,
        "sinkage_exponent",
        0.4,
        "growth of the sinkage exponent",
    ),
];

/// Another soil from one place on.
pub(super) struct Edge {
    inner: Arc<dyn AnyEffect>,
    hooks: Vec<Hook>,
    /// One a hook, then the place and the length of the change.
    params: Vec<Param>,
}

impl Edge {
    /// As far as a model of these hooks can tell soils apart, on a way of this extent \[m\].
    fn new(inner: Arc<dyn AnyEffect>, model: &[Hook], [first, last]: [f64; 2]) -> Self {
        let known = CHANGES.iter().filter(|(hook, ..)| model.contains(hook));
        let param = |name, unit, [min, max]: [f64; 2], prior_sd, doc| Param {
            name,
            symbol: "a",
            unit,
            min,
            max,
            scale: Scale::Linear,
            prior_sd,
            doc,
        };
        let mut params: Vec<Param> = known
            .clone()
            .map(|(_, name, sd, doc)| param(name, "1", [-6.0 * sd, 6.0 * sd], *sd, doc))
            .collect();
        let far = first.abs().max(last.abs());
        params.push(param(
            "place",
            "m",
            [first, last],
            far,
            "where the soil changes",
        ));
        let longest = last - first;
        params.push(param(
            "length",
            "m",
            [SHORTEST, longest],
            LENGTH,
            "along which way it does",
        ));
        Edge {
            inner,
            hooks: known.map(|(hook, ..)| *hook).collect(),
            params,
        }
    }

    fn before<T: Real>(&self, e: &[T], at: &mut Contact<T>) {
        let (changes, shape) = e.split_at(self.hooks.len().min(e.len()));
        let [place, length] = shape else {
            return;
        };
        let there = (((at.path + at.ahead - *place) * 2.0 / *length).tanh() + 1.0) * 0.5;
        for (hook, change) in self.hooks.iter().zip(changes) {
            let change = there * *change;
            let hooks = &mut at.hooks;
            match hook {
                Hook::Stiffness => hooks.stiffness *= change.exp(),
                Hook::Cohesion => hooks.cohesion *= change.exp(),
                Hook::Friction => hooks.friction *= change.exp(),
                Hook::ShearModulus => hooks.shear_modulus *= change.exp(),
                Hook::SinkageExponent => hooks.sinkage_exponent += change,
                _ => {}
            }
        }
    }
}

/// From the first place of the windows to the last; none where a log tells no way.
fn extent(data: &DataSet) -> Option<(Vec<f64>, [f64; 2])> {
    let paths = data.observations.iter().map(|o| o.factors.get("path"));
    let mut paths: Vec<f64> = paths.flatten().copied().collect();
    ascending(&mut paths, |path| *path);
    let ends = [*paths.first()?, *paths.last()?];
    (ends[1] - ends[0] > SHORTEST).then_some((paths, ends))
}

/// The best such change of soil, looked for at places all along the way: on few windows first, as nothing follows the drive yet.
pub(super) fn look(
    ground: &Ground<'_, '_>,
    effect: &Arc<dyn AnyEffect>,
    nominal: &Weighed,
) -> Option<Weighed> {
    let (paths, ends) = extent(ground.data)?;
    let edge = Edge::new(Arc::clone(effect), ground.null.law.model().hooks(), ends);
    let (changes, sds) = (edge.hooks.len(), edge.params.clone());
    let cohesion = edge.hooks.iter().position(|h| *h == Hook::Cohesion)?;
    let h = ground.null.with(Arc::new(edge)).ok()?;
    let few = ground.levels.thin.as_ref()?;
    let from = |number: usize| {
        let place = paths[(number + 1) * paths.len() / (PLACES.0 + 1)];
        let length = (ends[1] - ends[0]) / (PLACES.0 + 1) as f64;
        let mut start = nominal.plain.x.as_slice().to_vec();
        start.resize(start.len() + changes, 0.0);
        start.push(place / sds[changes].prior_sd);
        start.push(length / sds[changes + 1].prior_sd);
        few.end(ground.predictor, &h, &[start], None).ok()
    };
    let mut roughly: Vec<_> = for_each(PLACES.0, from).into_iter().flatten().collect();
    ascending(&mut roughly, |end| end.cost);
    roughly.truncate(PLACES.1);
    // A soil that holds by friction may do in these windows what one does that holds by cohesion.
    let soil = ground.null.len();
    let otherwise = |n: usize| {
        let (end, sd) = (
            &roughly[n / OTHERWISE.len()],
            OTHERWISE[n % OTHERWISE.len()],
        );
        let mut start = end.x.as_slice().to_vec();
        start[soil + cohesion] = sd;
        few.end(ground.predictor, &h, &[start], None).ok()
    };
    let more: Vec<_> = for_each(OTHERWISE.len() * roughly.len(), otherwise);
    roughly.extend(more.into_iter().flatten());
    ascending(&mut roughly, |end| end.cost);
    roughly.truncate(PLACES.1);
    let (data, predictor, levels) = (ground.data, ground.predictor, ground.levels);
    let on_all = |n: usize| {
        let start = roughly[n].x.as_slice().to_vec();
        let contest = contest(ground.setup.kind);
        weigh(data, predictor, &h, levels, &[start], None, contest).ok()
    };
    let found = for_each(roughly.len(), on_all).into_iter().flatten();
    found.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
}

macro_rules! at_scalars {
    ($($scalar:ty),*) => {$(
        impl EffectAt<$scalar> for Edge {
            fn alter_contact(
                &self,
                e: &[$scalar],
                _soil: &Soil<$scalar>,
                at: &mut Contact<$scalar>,
            ) {
                self.before::<$scalar>(e, at);
            }
            fn alter_forces(
                &self,
                _e: &[$scalar],
                _soil: &Soil<$scalar>,
                _at: &Contact<$scalar>,
                _forces: &mut WheelForces<$scalar>,
            ) {
            }
            fn vehicle_at(&self, _e: &[$scalar], vehicle: Vehicle<$scalar>) -> Vehicle<$scalar> {
                vehicle
            }
            fn loads_at(
                &self,
                _e: &[$scalar],
                _vehicle: &Vehicle<$scalar>,
                _motion: &Motion<$scalar>,
                loads: BodyLoads<$scalar>,
            ) -> BodyLoads<$scalar> {
                loads
            }
            fn report_at(
                &self,
                _e: &[$scalar],
                _channel: Channel,
                truth: $scalar,
                _rate: $scalar,
            ) -> $scalar {
                truth
            }
        }
    )*};
}
at_scalars!(f64, Dual8, Lanes, LaneDual);

impl AnyEffect for Edge {
    fn name(&self) -> &'static str {
        self.inner.name()
    }
    fn form(&self) -> &'static str {
        EDGE
    }
    fn summary(&self) -> &'static str {
        "the soil becomes another one at a place"
    }
    fn params(&self) -> &[Param] {
        &self.params
    }
    fn equation(&self) -> &'static str {
        "u = (1 + tanh(2 (x + d - x0)/l))/2; k e^(a u), c e^(b u), tan φ e^(d u), K e^(g u), n + m u"
    }
    fn reference(&self) -> &'static str {
        "chosen form"
    }
    fn needs(&self) -> &'static [Hook] {
        self.inner.needs()
    }
    fn needs_soil(&self) -> &'static [&'static str] {
        self.inner.needs_soil()
    }
    fn touches(&self) -> &'static [Touch] {
        self.inner.touches()
    }
    fn reads(&self) -> &'static [Circumstance] {
        self.inner.reads()
    }
    fn scope(&self) -> Scope {
        self.inner.scope()
    }
    fn regime(&self) -> &'static str {
        self.inner.regime()
    }
    fn isolated_by(&self) -> &'static str {
        self.inner.isolated_by()
    }
}
