//! The derivatives of the stress integrals in everything they depend on, at a known entry angle: by formula and in the
//! primal, so that a scalar with many derivatives is carried through sums only once.

use super::kernel::{Integrator, Node, Point, Stress};
use super::wheel::{Integrals, Wheel};
use crate::lanes::Vector;
use crate::quadrature::{power_weight_slopes, rule};
use crate::real::{Real, Root};

/// What the integrals depend on beside the entry angle, in this order.
pub(super) const VARIABLES: usize = 12;
pub(super) const SCALE: usize = 0;
pub(super) const EXPONENT: usize = 1;
pub(super) const COHESION: usize = 2;
pub(super) const FRICTION: usize = 3;
pub(super) const PER_MODULUS: usize = 4;
pub(super) const SLIP: usize = 5;
pub(super) const APEX: usize = 6;
const EXIT: usize = 7;
const HUMP: usize = 8;
const LAYER_DEPTH: usize = 9;
const LAYER_STIFFNESS: usize = 10;
const RADIUS: usize = 11;
/// The entry angle itself.
const ENTRY: usize = 12;

/// Integrals (load, thrust, compaction, shear; per R b) and their partial derivatives, the last in ln θ1.
pub(super) struct Partials<P> {
    value: [P; 4],
    by: [[P; 4]; VARIABLES + 1],
}

/// A change of one node: of the normal stress, of m, and for each branch of E, θ and its length.
struct Change<V> {
    sigma: V,
    m: V,
    branch: [[V; 3]; 2],
}

impl<P: Root, const ORDER: usize> Integrator<'_, P, ORDER> {
    /// Value and derivatives at an entry angle, by the variables that are asked for and the angle itself.
    pub(super) fn partials(&self, entry: P, asked: &[bool; VARIABLES]) -> Partials<P> {
        // A hump of no height still has a derivative.
        let s = &Stress {
            humped: self.stress.humped || asked[HUMP],
            ..self.stress
        };
        let at = s.at(entry.spread());
        let zero = P::Nodes::zero();
        let mut value = [zero; 4];
        let mut by = [[zero; 4]; VARIABLES + 1];
        let lengths = [at.front, at.rear];
        let slopes = power_weight_slopes::<P, ORDER>(self.wheel.ground.exponent);

        let mut add = |u: P::Nodes,
                       points: [Point<P::Nodes>; 2],
                       sigma: P::Nodes,
                       plain: P::Nodes,
                       through_sigma: &[(usize, P::Nodes)],
                       per_depth: P::Nodes| {
            let [f, b] = points;
            let m = sigma.mul_add(s.tan_friction, s.cohesion * plain);

            // Sums over the branches of (cos, sin) and of E (cos, sin, 1).
            let (cos_f, cos_b) = (lengths[0] * f.cos, lengths[1] * b.cos);
            let (sin_f, sin_b) = (lengths[0] * f.sin, lengths[1] * b.sin);
            let (e_f, e_b) = (f.mobilised, b.mobilised);
            let cos = cos_f + cos_b;
            let sin = sin_f + sin_b;
            let up = e_f.mul_add(sin_f, e_b * sin_b);
            let along = e_f.mul_add(cos_f, e_b * cos_b);
            let all = e_f.mul_add(lengths[0], e_b * lengths[1]);
            value[0] += sigma.mul_add(cos, m * up);
            value[1] += m * along;
            value[2] += sigma * sin;
            value[3] += m * all;

            // Through m alone.
            for (k, dm) in [(COHESION, plain), (FRICTION, sigma)] {
                if !asked[k] {
                    continue;
                }
                by[k][0] += dm * up;
                by[k][1] += dm * along;
                by[k][3] += dm * all;
            }
            // Through the normal stress alone.
            for &(k, ds) in through_sigma {
                if !asked[k] {
                    continue;
                }
                let dm = ds * s.tan_friction;
                by[k][0] += ds.mul_add(cos, dm * up);
                by[k][1] += dm * along;
                by[k][2] += ds * sin;
                by[k][3] += dm * all;
            }
            // Through E alone.
            let shears: [[P::Nodes; 3]; 2] = std::array::from_fn(|k| {
                let p = &points[k];
                [
                    p.slope * p.shear / s.per_modulus,
                    p.slope * s.per_modulus * (at.sin - p.sin),
                    p.bulge,
                ]
            });
            for (q, k) in [PER_MODULUS, SLIP, HUMP].into_iter().enumerate() {
                if !asked[k] {
                    continue;
                }
                let (de_f, de_b) = (m * lengths[0] * shears[0][q], m * lengths[1] * shears[1][q]);
                by[k][0] += de_f.mul_add(f.sin, de_b * b.sin);
                by[k][1] += de_f.mul_add(f.cos, de_b * b.cos);
                by[k][3] += de_f + de_b;
            }
            // Through the angles.
            let mut moves = |k: usize, change: Change<P::Nodes>| {
                let (ds, dm) = (change.sigma, change.m);
                by[k][0] += ds.mul_add(cos, dm * up);
                by[k][1] += dm * along;
                by[k][2] += ds * sin;
                by[k][3] += dm * all;
                for (q, p) in points.iter().enumerate() {
                    let [de, angle, length] = change.branch[q];
                    let (l, e) = (lengths[q], p.mobilised);
                    let strain = length.mul_add(e, l * de);
                    by[k][0] += sigma * (length * p.cos - l * p.sin * angle)
                        + m * (strain * p.sin + l * e * p.cos * angle);
                    by[k][1] += m * (strain * p.cos - l * e * p.sin * angle);
                    by[k][2] += sigma * (length * p.sin + l * p.cos * angle);
                    by[k][3] += m * strain;
                }
            };
            // -dj/dθ /R
            let fall = |p: &Point<P::Nodes>| {
                -(p.slope * s.per_modulus) * p.versine.mul_add(P::Nodes::one() - s.slip, s.slip)
            };
            let (fall_f, fall_b) = (fall(&f), fall(&b));
            // θF = θ1 (1 - u + a u): both angles move by θ1 u.
            let one = P::Nodes::one();
            if asked[APEX] {
                let shift = at.entry * u;
                let sigma = -(per_depth * f.sin * shift);
                moves(
                    APEX,
                    Change {
                        sigma,
                        m: sigma * s.tan_friction,
                        branch: [[fall_f * shift, shift, -one], [fall_b * shift, shift, one]],
                    },
                );
            }
            if asked[EXIT] {
                let back = at.entry * (u - 1.0);
                moves(
                    EXIT,
                    Change {
                        sigma: zero,
                        m: zero,
                        branch: [[zero; 3], [fall_b * back, back, one]],
                    },
                );
            }
            let sigma_entry = per_depth * at.deepening(&f);
            let grow = |p: &Point<P::Nodes>| {
                (at.growth - s.growth(p.angle, p.versine)) * s.per_modulus * p.slope
            };
            moves(
                ENTRY,
                Change {
                    sigma: sigma_entry,
                    m: sigma_entry * s.tan_friction,
                    branch: [[grow(&f), f.angle, zero], [grow(&b), b.angle, zero]],
                },
            );
        };
        let mut soil = |node: Node<P::Nodes>, power_slope: P::Nodes| {
            let (f, b) = s.pair::<false>(&at, node.u);
            let depth = at.versine - f.versine;
            let ln_base = (depth * node.inverse).ln_fast();
            let bare = (ln_base * s.exponent).exp_fast();
            let unit = bare * node.power;
            let sigma = unit * s.scale;
            let exponent = sigma * ln_base + bare * power_slope * s.scale;
            let through = [(SCALE, unit), (EXPONENT, exponent)];
            let per_depth = sigma * s.exponent / depth;
            add(node.u, [f, b], sigma, node.plain, &through, per_depth);
        };
        if self.whole(entry) {
            let rule = rule::<ORDER>();
            for (chunk, (&power, &slope)) in self.weights.iter().zip(&slopes).enumerate() {
                let q = chunk * P::NODES_AT_ONCE;
                if q >= ORDER {
                    break;
                }
                let node = Node {
                    u: P::table(&rule.nodes[q..]),
                    inverse: P::table(&rule.inverse[q..]),
                    power,
                    plain: P::table(&rule.weights[q..]),
                };
                soil(node, slope);
            }
        } else {
            self.each_node(entry, |node, (ln_u, chunk)| {
                let own = chunk.map_or(zero, |(chunk, factor)| slopes[chunk] * factor);
                soil(node, node.power * ln_u + own);
            });
        }
        self.each_layer_node(entry, |layer, u, plain| {
            let (f, b) = s.pair::<false>(&at, u);
            let height = at.versine - f.versine;
            let extra = height.mul_add(layer.radius, -layer.depth) * plain;
            let scale = layer.stiffness * plain;
            let through = [
                (LAYER_DEPTH, -scale),
                (LAYER_STIFFNESS, extra),
                (RADIUS, scale * height),
            ];
            let (sigma, per_depth) = (layer.stiffness * extra, scale * layer.radius);
            add(u, [f, b], sigma, zero, &through, per_depth);
        });
        let total = |sums: [P::Nodes; 4]| sums.map(|x| P::total(x) * entry);
        let value = total(value);
        let mut by = by.map(total);
        for (slope, value) in by[ENTRY].iter_mut().zip(value) {
            *slope += value;
        }
        Partials { value, by }
    }
}

impl Partials<f64> {
    /// How ln θ1 and each integral follow a change of the load (per R b) and of some variables.
    pub(super) fn follow(&self, load: f64, changes: &[(usize, f64)]) -> [f64; 5] {
        let [carried, thrust, compaction, shear] = self.by[ENTRY];
        let mut sums = [0.0; 4];
        for &(k, change) in changes {
            for (sum, by) in sums.iter_mut().zip(self.by[k]) {
                *sum += by * change;
            }
        }
        let step = (load - sums[0]) / carried;
        [
            step,
            load,
            sums[1] + thrust * step,
            sums[2] + compaction * step,
            sums[3] + shear * step,
        ]
    }
}

impl<P: Root> Partials<P> {
    /// The step in ln θ1 to where a load (per R b) is carried.
    pub(super) fn step(&self, load: P) -> P {
        (load - self.value[0]) / self.by[ENTRY][0]
    }

    /// The entry angle and the integrals that carry `load` (per R b), with all derivatives of the wheel's scalar:
    /// dθ1 follows from the load, the integrals follow with it.
    pub(super) fn balanced<T: Real<Primal = P>>(
        &self,
        wheel: &Wheel<T>,
        entry: P,
        load: T,
    ) -> (T, Integrals<T>) {
        let carried = self.by[ENTRY][0];
        // d ln θ1 and the integrals, each as value + Σ coefficient * change; the step comes from nothing but the load's.
        let rates: [P; 4] = std::array::from_fn(|q| {
            let by_entry = if q == 0 { P::one() } else { self.by[ENTRY][q] };
            by_entry / carried
        });
        let residual = load - T::from_primal(self.value[0]);
        let mut sums: [T; 4] = std::array::from_fn(|q| {
            let value = if q == 0 { P::zero() } else { self.value[q] };
            residual.scaled(rates[q]) + T::from_primal(value)
        });
        let asked = wheel.asks().into_iter().enumerate();
        for (k, _) in asked.filter(|(_, asked)| *asked) {
            let variable = wheel.variable(k);
            let change = variable - T::from_primal(variable.primal());
            for (q, sum) in sums.iter_mut().enumerate() {
                let by = if q == 0 { P::zero() } else { self.by[k][q] };
                sum.add_scaled(&change, by - rates[q] * self.by[k][0]);
            }
        }
        let [step, thrust, compaction, shear] = sums;
        let entry = T::from_primal(entry);
        (
            entry + entry * step,
            Integrals {
                load,
                thrust,
                compaction,
                shear,
                lateral: T::zero(),
            },
        )
    }
}

impl<T: Real> Wheel<T> {
    /// What varies of the integrals' variables.
    pub(super) fn asks(&self) -> [bool; VARIABLES] {
        let g = &self.ground;
        let mut asks = [false; VARIABLES];
        asks[SCALE] = g.stiffness.varies() || self.radius.varies() || g.exponent.varies();
        asks[EXPONENT] = g.exponent.varies();
        asks[COHESION] = g.cohesion.varies();
        asks[FRICTION] = g.tan_friction.varies();
        asks[PER_MODULUS] = self.shear_radius.varies() || g.shear_modulus.varies();
        asks[SLIP] = g.slip.varies();
        asks[APEX] = g.apex_ratio.varies();
        asks[EXIT] = self.exit_ratio.varies();
        asks[HUMP] = self.hump.varies();
        if let Some((depth, stiffness)) = &self.layer {
            asks[LAYER_DEPTH] = depth.varies();
            asks[LAYER_STIFFNESS] = stiffness.varies();
            asks[RADIUS] = self.radius.varies();
        }
        asks
    }

    /// One of the integrals' variables.
    fn variable(&self, k: usize) -> T {
        let g = &self.ground;
        match k {
            SCALE => g.stiffness * self.radius.pow_pos(g.exponent),
            EXPONENT => g.exponent,
            COHESION => g.cohesion,
            FRICTION => g.tan_friction,
            PER_MODULUS => self.shear_radius / g.shear_modulus,
            SLIP => g.slip,
            APEX => g.apex_ratio,
            EXIT => self.exit_ratio,
            HUMP => self.hump,
            LAYER_DEPTH => self.layer.map_or_else(T::zero, |layer| layer.0),
            LAYER_STIFFNESS => self.layer.map_or_else(T::zero, |layer| layer.1),
            _ => self.radius,
        }
    }
}
