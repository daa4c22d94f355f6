//! Contacts side by side: two Newton steps by three nodes, then eight (five in single precision), and one linear step.
//!
//! A lane that this schedule does not suit (braking, a steep layer of shear, no equilibrium, an illegal value) is solved
//! once more alone, where every case has its answer.

use super::WongReece;
use super::kernel::Integrator;
use super::wheel::Wheel;
use crate::batch::{Batch, BatchForces, Precision, value};
use crate::forces::Flags;
use crate::lanes::{Lanes, Lanes32, Vector};
use crate::law::guard;
use crate::model::TerrainModel;
use crate::models::bekker::Ground;
use crate::real::Root;
use crate::root::MAX_ENTRY_ANGLE;

/// Steps by the short rule.
const COARSE_STEPS: usize = 2;
/// Most steps by the rule that counts.
const FINE_STEPS: usize = 3;
/// Steepness of j/K along a branch that eight nodes still resolve to 1e-7, and five to 1e-5.
const STEEP: f64 = 9.0;

/// Solves a batch of checked lengths.
pub(super) fn solve_batch(batch: &Batch<'_>, precision: Precision, out: &mut BatchForces) {
    out.resize(batch.len());
    match precision {
        // A last step below 1e-4 leaves 1e-8.
        Precision::Double => groups::<Lanes, 3, 8>(batch, 1e-4, out),
        Precision::Single => groups::<Lanes32, 3, 5>(batch, 1e-3, out),
    }
}

fn groups<V: Vector + Root<Nodes = V>, const COARSE: usize, const FINE: usize>(
    batch: &Batch<'_>,
    tolerance: f64,
    out: &mut BatchForces,
) {
    let mut alone = Vec::with_capacity(batch.parameters.len());
    for first in (0..batch.len()).step_by(V::WIDTH) {
        let count = V::WIDTH.min(batch.len() - first);
        let found = group::<V, COARSE, FINE>(batch, first, count, tolerance);
        for lane in 0..count {
            let item = first + lane;
            if found.good.lane(lane) > 0.0 {
                out.set_values(item, found.values.map(|v| v.lane(lane)));
                if let Some(status) = out.status.get_mut(item) {
                    let deep_sinkage = found.values[3].lane(lane) > 0.5 * batch.radius;
                    *status = Ok(Flags {
                        deep_sinkage,
                        ..Flags::default()
                    });
                }
            } else {
                batch.item_parameters(item, &mut alone);
                let at = batch.contact(item);
                let forces = guard(WongReece::NAME, WongReece::PARAMS, &alone, &at)
                    .and_then(|()| WongReece.wheel_forces(&alone, &at));
                out.set(item, forces);
            }
        }
    }
}

/// What a group of lanes gave: entry angle, pull, torque, sinkage, and 1 where they may be used.
struct Found<V> {
    values: [V; 4],
    good: V,
}

#[inline]
fn group<V: Vector + Root<Nodes = V>, const COARSE: usize, const FINE: usize>(
    batch: &Batch<'_>,
    first: usize,
    count: usize,
    tolerance: f64,
) -> Found<V> {
    // The last item fills the lanes that are left over.
    let load = |values: &[f64]| match values.get(first..first + V::WIDTH) {
        Some(full) => V::gather(full.iter().copied()),
        None => V::gather((0..V::WIDTH).map(|lane| value(values, first + lane.min(count - 1)))),
    };
    let (zero, one) = (V::zero(), V::one());
    let parameter = |k: usize| batch.parameters.get(k).map_or(zero, |p| load(p));
    let (slip, normal_load) = (load(batch.slip), load(batch.normal_load));
    let (friction, width, radius) = (parameter(4), batch.width, batch.radius);
    let (defect, versine) = friction.sine_defects();
    let ground = Ground {
        stiffness: parameter(0) * (1.0 / width) + parameter(1),
        exponent: parameter(2),
        cohesion: parameter(3),
        tan_friction: (friction - defect) / (one - versine),
        shear_modulus: parameter(5),
        slip,
        apex_ratio: parameter(6) + parameter(7) * slip,
        apex_limited: false,
    };
    let wheel = Wheel::plain(ground, V::from(radius), V::from(width));
    let mut good = one;
    let mut require = |below: V, above: V| good = below.select_lt(above, good, zero);
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
    require(zero, normal_load);

    // W = b k sqrt(2R) z^(n + 1/2) (3 - n)/3, z = R θ1²/2
    let n = ground.exponent;
    let shape = (V::from(3.0) - n).max_of(V::from(0.5)) * (width * (2.0 * radius).sqrt() / 3.0);
    let ln_z = (normal_load / (ground.stiffness * shape)).ln_fast() / (n + 0.5);
    let mut entry = ((ln_z + (2.0 / radius).ln()) * 0.5).exp_fast();
    let top = V::from(MAX_ENTRY_ANGLE);
    entry = entry.min_of(top);

    let scale = ground.stiffness * (n * radius.ln()).exp_fast();
    let stress = wheel.stress_of(scale);
    let target = normal_load * (1.0 / (radius * width));
    let newton = |entry: V, (w, slope): (V, V)| {
        let step = (target / w).ln_fast() * w / slope;
        let held = step.max_of(V::from(-2.0)).min_of(V::from(1.0));
        (entry * held.exp_fast()).min_of(top)
    };
    let coarse = Integrator::<V, COARSE>::new(&wheel, stress);
    for _ in 0..COARSE_STEPS {
        entry = newton(entry, coarse.whole_at(entry).load(entry));
    }
    let fine = Integrator::<V, FINE>::new(&wheel, stress);
    let mut done = (zero, [zero; 2]);
    for step in 0..FINE_STEPS {
        let sums = fine.whole_at(entry);
        let (value, slopes) = sums.integrals(entry);
        let move_by = (target - value.load) / slopes.load;
        let moved = value.moved(&slopes, move_by);
        done = (
            entry + entry * move_by,
            [moved.thrust - moved.compaction, moved.shear],
        );
        let size = move_by.abs();
        let open = good * V::from(tolerance).select_lt(size, one, zero);
        if step + 1 == FINE_STEPS || !zero.any_lt(open) {
            good = size.select_lt(V::from(tolerance), good, zero);
            break;
        }
        entry = newton(entry, (value.load, slopes.load));
    }
    let (entry, [pull, shear]) = done;
    // Short of 90° by more than the last step can be wrong, and no steep layer.
    good = entry.select_lt(V::from(MAX_ENTRY_ANGLE - 1e-3), good, zero);
    good = fine.steepness(entry).select_lt(V::from(STEEP), good, zero);
    let (sin_half, _) = (entry * 0.5).sine_defects();
    let sin_half = entry * 0.5 - sin_half;
    let area = radius * width;
    Found {
        values: [
            entry,
            pull * area,
            shear * (area * radius),
            sin_half * sin_half * (2.0 * radius),
        ],
        good,
    }
}
