//! Contacts side by side: a Newton step by two nodes, one by three, then one evaluation by eight (seven in single
//! precision) and a last step along the power laws that load, thrust and resistance nearly are.
//!
//! Where the shear stress is too steep for that many nodes, the contacts of the whole batch that have it are put side by
//! side again, under longer rules and from the angle found. A contact that no rule in one piece suits (braking, a layer
//! of shear thinner still, no equilibrium, an illegal value) is solved alone, where every case has its answer.

use super::WongReece;
use super::kernel::{Integrator, Stress};
use super::wheel::Wheel;
use crate::batch::{Batch, BatchForces, Precision, value};
use crate::guard::guard;
use crate::lanes::{Lanes, Lanes32, Vector};
use crate::model::TerrainModel;
use crate::models::bekker::Ground;
use crate::quadrature::moment;
use crate::real::Root;
use crate::root::MAX_ENTRY_ANGLE;

/// Most evaluations by the rule that counts.
const FINE_STEPS: usize = 3;

/// What a precision needs.
struct Tier {
    /// Last step in ln θ1 that leaves less than the tier's error.
    tolerance: f64,
    /// Largest error of a rule that a contact may be left with.
    error: f64,
}

/// Most lanes there are.
const WIDEST: usize = 16;

/// Solves a batch of checked lengths.
pub(super) fn solve_batch(batch: &Batch<'_>, precision: Precision, out: &mut BatchForces) {
    out.resize(batch.len());
    match precision {
        Precision::Double => {
            let (tolerance, error) = (3e-4, 3e-7);
            let mut pass = Pass::new(batch, Tier { tolerance, error }, out);
            let steep = pass.first::<Lanes, 8>();
            let steeper = pass.again::<Lanes, 12>(&steep);
            let steepest = pass.again::<Lanes, 24>(&steeper);
            pass.finish(&steepest);
        }
        Precision::Single => {
            let (tolerance, error) = (2e-3, 2e-6);
            let mut pass = Pass::new(batch, Tier { tolerance, error }, out);
            let steep = pass.first::<Lanes32, 7>();
            let steepest = pass.again::<Lanes32, 12>(&steep);
            pass.finish(&steepest);
        }
    }
}

/// A contact whose shear is too steep for the rule before, with the entry angle that one found.
type Steep = (usize, f64);

/// A batch on its way.
struct Pass<'a, 'b> {
    batch: &'a Batch<'b>,
    tier: Tier,
    out: &'a mut BatchForces,
    alone: Vec<usize>,
    ln_radius: f64,
}

impl<'a, 'b> Pass<'a, 'b> {
    fn new(batch: &'a Batch<'b>, tier: Tier, out: &'a mut BatchForces) -> Self {
        Pass {
            batch,
            tier,
            out,
            alone: vec![],
            ln_radius: batch.radius.ln(),
        }
    }

    /// All contacts in their order, from nothing.
    fn first<V: Vector + Root<Nodes = V>, const FINE: usize>(&mut self) -> Vec<Steep> {
        let (batch, mut steep) = (self.batch, vec![]);
        for first in (0..batch.len()).step_by(V::WIDTH) {
            let count = V::WIDTH.min(batch.len() - first);
            // The last item fills the lanes that are left over.
            let group = Group::read(batch, self.ln_radius, |values| {
                match values.get(first..first + V::WIDTH) {
                    Some(full) => V::gather(full.iter().copied()),
                    None => {
                        let item = |lane: usize| first + lane.min(count - 1);
                        V::gather((0..V::WIDTH).map(|lane| value(values, item(lane))))
                    }
                }
            });
            let found = group.solve::<FINE>(group.start(), &self.tier);
            self.write(&found, &mut steep, count, |lane| first + lane);
        }
        steep
    }

    /// Those too steep for the rule before, by a longer one.
    fn again<V: Vector + Root<Nodes = V>, const FINE: usize>(
        &mut self,
        items: &[Steep],
    ) -> Vec<Steep> {
        let (batch, mut steep) = (self.batch, vec![]);
        for together in items.chunks(V::WIDTH) {
            let of = |lane: usize| together[lane.min(together.len() - 1)];
            let items: [usize; WIDEST] = std::array::from_fn(|lane| of(lane).0);
            let group = Group::read(batch, self.ln_radius, |values| match values {
                [shared] => V::from(*shared),
                _ => V::gather(items.iter().map(|&item| value(values, item))),
            });
            let start = V::gather((0..V::WIDTH).map(|lane| of(lane).1));
            let found = group.solve::<FINE>(start, &self.tier);
            self.write(&found, &mut steep, together.len(), |lane| items[lane]);
        }
        steep
    }

    /// Keeps what the lanes hold, and says what becomes of those that are not good: their values are written over later.
    fn write<V: Vector>(
        &mut self,
        found: &Found<V>,
        steep: &mut Vec<Steep>,
        count: usize,
        item: impl Fn(usize) -> usize,
    ) {
        let standing: [f64; WIDEST] = found.standing.lanes();
        let values = found.values.map(|v| v.lanes::<WIDEST>());
        let [entry, _, _, sinkage] = &values;
        for lane in 0..count.min(WIDEST) {
            let item = item(lane);
            if standing[lane] > 1.5 {
                steep.push((item, entry[lane]));
            } else if standing[lane] > 0.5 {
                let deep_sinkage = sinkage[lane] > 0.5 * self.batch.radius;
                self.out.set_good(item, deep_sinkage);
            } else {
                self.alone.push(item);
            }
        }
        let columns = self.out.columns().into_iter().zip(&values);
        for (column, values) in columns {
            // Side by side in the column as well, or one by one.
            match column.get_mut(item(0)..=item(count - 1)) {
                Some(run) if run.len() == count => run.copy_from_slice(&values[..count]),
                _ => {
                    for (lane, &value) in values.iter().enumerate().take(count) {
                        if let Some(slot) = column.get_mut(item(lane)) {
                            *slot = value;
                        }
                    }
                }
            }
        }
    }

    /// What no group could do, one by one.
    fn finish(self, steepest: &[Steep]) {
        let mut parameters = vec![];
        let steepest = steepest.iter().map(|&(item, _)| item);
        for item in self.alone.into_iter().chain(steepest) {
            self.batch.item_parameters(item, &mut parameters);
            let at = self.batch.contact(item);
            let forces = guard(WongReece::NAME, WongReece::PARAMS, &parameters, &at)
                .and_then(|()| WongReece.wheel_forces(&parameters, &at));
            self.out.set(item, forces);
        }
    }
}

/// Contacts side by side, ready to be solved.
struct Group<V> {
    wheel: Wheel<V>,
    stress: Stress<V>,
    /// W/(R b).
    load: V,
    radius: f64,
    ln_radius: f64,
    width: f64,
    /// 1 where all values are legal and the wheel is driven.
    legal: V,
}

/// What a group of lanes gave: entry angle, pull, torque, sinkage; 1 where they are good, 2 where only steepness is in
/// the way.
struct Found<V> {
    values: [V; 4],
    standing: V,
}

impl<V: Vector + Root<Nodes = V>> Group<V> {
    /// The contacts that `pick` takes from a column.
    #[inline]
    fn read(batch: &Batch<'_>, ln_radius: f64, pick: impl Fn(&[f64]) -> V) -> Self {
        let (zero, one) = (V::zero(), V::one());
        let parameter = |k: usize| batch.parameters.get(k).map_or(zero, |p| pick(p));
        let (slip, load) = (pick(batch.slip), pick(batch.normal_load));
        let friction = parameter(4);
        let (defect, versine) = friction.sine_defects();
        let ground = Ground {
            stiffness: parameter(0) * (1.0 / batch.width) + parameter(1),
            exponent: parameter(2),
            cohesion: parameter(3),
            tan_friction: (friction - defect) / (one - versine),
            shear_modulus: parameter(5),
            slip,
            apex_ratio: parameter(6) + parameter(7) * slip,
            apex_limited: false,
        };
        let wheel = Wheel::plain(ground, V::from(batch.radius), V::from(batch.width));
        let mut legal = one;
        let mut require = |below: V, above: V| legal = below.select_lt(above, legal, zero);
        // An illegal value, NaN included, is told by the single call.
        require(zero, ground.stiffness);
        require(zero, ground.exponent);
        require(ground.exponent, V::from(4.0));
        require(V::from(-f64::MIN_POSITIVE), ground.cohesion);
        require(V::from(-f64::MIN_POSITIVE), friction);
        require(friction, V::from(1.57));
        require(zero, ground.shear_modulus);
        require(zero, ground.apex_ratio);
        require(ground.apex_ratio, one);
        require(-V::from(f64::from(f32::MIN_POSITIVE)), slip);
        require(slip, V::from(1.0 + 1e-9));
        require(zero, load);
        let scale = ground.stiffness * (ground.exponent * ln_radius).exp_fast();
        Group {
            wheel,
            stress: wheel.stress_of(scale),
            load: load * (1.0 / (batch.radius * batch.width)),
            radius: batch.radius,
            ln_radius,
            width: batch.width,
            legal,
        }
    }

    /// The entry angle by the short rules.
    #[inline]
    fn start(&self) -> V {
        let (ground, radius) = (&self.wheel.ground, self.radius);
        // W = b k sqrt(2R) z^(n + 1/2) (3 - n)/3, z = R θ1²/2
        let n = ground.exponent;
        let shape = (V::from(3.0) - n).max_of(V::from(0.5)) * ((2.0 / radius).sqrt() / 3.0);
        let ln_z = (self.load / (ground.stiffness * shape)).ln_fast() / (n + 0.5);
        let guess = ((ln_z + (std::f64::consts::LN_2 - self.ln_radius)) * 0.5).exp_fast();
        let first = Integrator::<V, 2>::new(&self.wheel, self.stress);
        let second = Integrator::<V, 3>::new(&self.wheel, self.stress);
        let entry = guess.min_of(Self::top());
        let (carried, slope) = first.whole_at::<false>(entry).load(entry);
        let entry = self.newton(entry, carried, slope);
        let (carried, slope) = second.whole_at::<false>(entry).load(entry);
        self.newton(entry, carried, slope)
    }

    fn top() -> V {
        V::from(MAX_ENTRY_ANGLE)
    }

    /// ln(load/carried) / (d ln W/d ln θ1).
    #[inline]
    fn step(&self, carried: V, slope: V) -> V {
        (self.load / carried).ln_fast() * carried / slope
    }

    #[inline]
    fn newton(&self, entry: V, carried: V, slope: V) -> V {
        let step = self.step(carried, slope);
        let held = step.max_of(V::from(-2.0)).min_of(V::from(1.0));
        (entry * held.exp_fast()).min_of(Self::top())
    }

    /// The forces, from an entry angle close to the one that carries the load.
    #[inline]
    fn solve<const FINE: usize>(&self, start: V, tier: &Tier) -> Found<V> {
        let (zero, one) = (V::zero(), V::one());
        let fine = Integrator::<V, FINE>::new(&self.wheel, self.stress);
        let mut entry = start;
        let mut good = self.legal;
        let mut done = (zero, [zero; 2]);
        for evaluation in 1..=FINE_STEPS {
            let (value, slopes) = fine.whole_at::<false>(entry).integrals(entry);
            let step = self.step(value.load, slopes.load);
            // Along the power law through value and slope, to second order; nothing here is negative.
            let tiny = V::from(f64::from(f32::MIN_POSITIVE));
            let along = |value: V, slope: V| {
                let bend = slope / value.max_of(tiny) * step * 0.5;
                (slope * step).mul_add(bend + 1.0, value)
            };
            let pull =
                along(value.thrust, slopes.thrust) - along(value.compaction, slopes.compaction);
            done = (
                along(entry, entry),
                [pull, along(value.shear, slopes.shear)],
            );
            let size = step.abs();
            let tolerance = V::from(tier.tolerance);
            let open = good * tolerance.select_lt(size, one, zero);
            if evaluation == FINE_STEPS || !zero.any_lt(open) {
                good = size.select_lt(tolerance, good, zero);
                break;
            }
            entry = self.newton(entry, value.load, slopes.load);
        }
        let (entry, [pull, shear]) = done;
        // Short of 90° by more than the last step can be wrong, and no layer too steep.
        good = entry.select_lt(V::from(MAX_ENTRY_ANGLE - 1e-3), good, zero);
        let left_out = self.left_out::<FINE>(fine.steepness(entry));
        let standing = left_out.select_lt(V::from(tier.error), good, good * 2.0);
        let (defect, _) = (entry * 0.5).sine_defects();
        let sin_half = entry * 0.5 - defect;
        let area = self.radius * self.width;
        Found {
            values: [
                entry,
                pull * area,
                shear * (area * self.radius),
                sin_half * sin_half * (2.0 * self.radius),
            ],
            standing,
        }
    }
    /// About the relative error that the steepness of the shear stress leaves in forces by a rule in one piece.
    ///
    /// With S the steepness of j/K, e^(-S u) has the Legendre coefficient of order N near (S/N)^N e^(-S/2), and the rule
    /// leaves it out against u^n: times M_N(n), which is 0 for whole n below N. Beyond S = 1.5 N the layer falls between
    /// the nodes, and there is no bound.
    #[inline]
    fn left_out<const ORDER: usize>(&self, steepness: V) -> V {
        let order = ORDER as f64;
        let share = (steepness * (1.0 / order)).max_of(V::from(1e-3));
        let coefficient = (share.ln_fast() * order - steepness * 0.5).exp_fast();
        let moment = moment::<V, ORDER>(self.wheel.ground.exponent).abs();
        let no_bound = V::from(f64::INFINITY);
        share.select_lt(V::from(1.5), coefficient * moment, no_bound)
    }
}
