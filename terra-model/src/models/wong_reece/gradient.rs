//! The derivatives of the stress integrals in everything they depend on, at a known entry angle: by formula and in the
//! primal, so that a scalar with many derivatives is carried through sums only once.

use super::kernel::{Integrator, Node, Point, Stress};
use super::wheel::{Integrals, Wheel};
use crate::lanes::Vector;
use crate::quadrature::{power_weight_slopes, rule};
use crate::real::{Real, Root};

/// What the integrals depend on beside the entry angle, in this order.
pub(super) const VARIABLES: usize = 13;
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
/// tan β.
const LATERAL: usize = 12;
/// The entry angle itself.
const ENTRY: usize = 13;

/// Number of integrals of a wheel that goes straight, and of one that slides sideways, whose last is the side force.
pub(super) const STRAIGHT: usize = 4;
pub(super) const SIDEWAYS: usize = 5;
/// Place of the side force.
const SIDE: usize = 4;

/// Integrals (load, thrust, compaction, shear, and the side force where there is one; per R b) and their partial derivatives, the
/// last in ln θ1.
pub(super) struct Partials<P, const SUMS: usize> {
    value: [P; SUMS],
    by: [[P; SUMS]; VARIABLES + 1],
}

/// A change of one node: of the normal stress, of m, and for each branch of E, θ, its length and A.
struct Change<V> {
    sigma: V,
    m: V,
    branch: [[V; 4]; 2],
}

/// What the strength across the wheel adds to a point of a contact: A, the share of the strength across it, displaced by a/K there.
#[derive(Clone, Copy)]
struct Aside<V> {
    across: V,
    mobilised: V,
    /// dE/da = dA/dy, dA/da, and the hump without its height in A.
    both: V,
    own: V,
    bulge: V,
}

impl<P: Root, const ORDER: usize> Integrator<'_, P, ORDER> {
    /// Value and derivatives at an entry angle, by the variables that are asked for and the angle itself.
    pub(super) fn partials<const SUMS: usize>(
        &self,
        entry: P,
        asked: &[bool; VARIABLES],
    ) -> Partials<P, SUMS> {
        let sideways = const { SUMS > SIDE };
        // A hump of no height still has a derivative.
        let s = &Stress {
            humped: self.stress.humped || asked[HUMP],
            ..self.stress
        };
        let at = s.at(entry.spread());
        let zero = P::Nodes::zero();
        let mut value = [zero; SUMS];
        let mut by = [[zero; SUMS]; VARIABLES + 1];
        // a = R_s/K (1 - i)(θ1 - θ) tan β, with its sign.
        let tan = self.wheel.lateral.unwrap_or_else(P::zero).spread();
        let by_tan = s.per_modulus * (P::Nodes::one() - s.slip);
        let pair = |u: P::Nodes| {
            if sideways {
                s.pair::<true>(&at, u)
            } else {
                s.pair::<false>(&at, u)
            }
        };
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
            let asides = points.map(|p| {
                if sideways {
                    s.aside(&p, by_tan * (at.entry - p.angle) * tan)
                } else {
                    Aside::none()
                }
            });
            let side = asides[0]
                .mobilised
                .mul_add(lengths[0], asides[1].mobilised * lengths[1]);
            value[0] += sigma.mul_add(cos, m * up);
            value[1] += m * along;
            value[2] += sigma * sin;
            value[3] += m * all;
            if sideways {
                value[SIDE] += m * side;
            }

            // Through m alone.
            for (k, dm) in [(COHESION, plain), (FRICTION, sigma)] {
                if !asked[k] {
                    continue;
                }
                by[k][0] += dm * up;
                by[k][1] += dm * along;
                by[k][3] += dm * all;
                if sideways {
                    by[k][SIDE] += dm * side;
                }
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
                if sideways {
                    by[k][SIDE] += dm * side;
                }
            }
            // Through E and A alone: by a change of y and one of a.
            let shears = |k: usize, p: &Point<P::Nodes>, aside: &Aside<P::Nodes>| {
                let (by_y, by_a) = match k {
                    PER_MODULUS => (p.shear / s.per_modulus, aside.across / s.per_modulus),
                    SLIP => (
                        s.per_modulus * (at.sin - p.sin),
                        -(s.per_modulus * (at.entry - p.angle) * tan),
                    ),
                    HUMP => return (p.bulge, aside.bulge),
                    _ => (zero, by_tan * (at.entry - p.angle)),
                };
                if sideways {
                    aside.follow(p, by_y, by_a)
                } else {
                    (p.slope * by_y, zero)
                }
            };
            for k in [PER_MODULUS, SLIP, HUMP, LATERAL] {
                if !asked[k] {
                    continue;
                }
                let [(e_f, a_f), (e_b, a_b)] = [0, 1].map(|q| shears(k, &points[q], &asides[q]));
                let (de_f, de_b) = (m * lengths[0] * e_f, m * lengths[1] * e_b);
                by[k][0] += de_f.mul_add(f.sin, de_b * b.sin);
                by[k][1] += de_f.mul_add(f.cos, de_b * b.cos);
                by[k][3] += de_f + de_b;
                if sideways {
                    by[k][SIDE] += m * a_f.mul_add(lengths[0], a_b * lengths[1]);
                }
            }
            // Through the angles.
            let mut moves = |k: usize, change: Change<P::Nodes>| {
                let (ds, dm) = (change.sigma, change.m);
                by[k][0] += ds.mul_add(cos, dm * up);
                by[k][1] += dm * along;
                by[k][2] += ds * sin;
                by[k][3] += dm * all;
                if sideways {
                    by[k][SIDE] += dm * side;
                }
                for (q, p) in points.iter().enumerate() {
                    let [de, angle, length, da] = change.branch[q];
                    let (l, e) = (lengths[q], p.mobilised);
                    let strain = length.mul_add(e, l * de);
                    by[k][0] += sigma * (length * p.cos - l * p.sin * angle)
                        + m * (strain * p.sin + l * e * p.cos * angle);
                    by[k][1] += m * (strain * p.cos - l * e * p.sin * angle);
                    by[k][2] += sigma * (length * p.sin + l * p.cos * angle);
                    by[k][3] += m * strain;
                    if sideways {
                        by[k][SIDE] += m * length.mul_add(asides[q].mobilised, l * da);
                    }
                }
            };
            // dE/dθ and dA/dθ: -dj/dθ /R along, and what grows with θ1 - θ across.
            let fall = |p: &Point<P::Nodes>, aside: &Aside<P::Nodes>| {
                let along = -s.per_modulus * p.versine.mul_add(P::Nodes::one() - s.slip, s.slip);
                if sideways {
                    aside.follow(p, along, -(by_tan * tan))
                } else {
                    (p.slope * along, zero)
                }
            };
            let [(fall_f, down_f), (fall_b, down_b)] = [0, 1].map(|q| fall(&points[q], &asides[q]));
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
                        branch: [
                            [fall_f * shift, shift, -one, down_f * shift],
                            [fall_b * shift, shift, one, down_b * shift],
                        ],
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
                        branch: [[zero; 4], [fall_b * back, back, one, down_b * back]],
                    },
                );
            }
            let sigma_entry = per_depth * at.deepening(&f);
            let grow = |p: &Point<P::Nodes>, aside: &Aside<P::Nodes>| {
                let along = (at.growth - s.growth(p.angle, p.versine)) * s.per_modulus;
                if sideways {
                    aside.follow(p, along, aside.across)
                } else {
                    (along * p.slope, zero)
                }
            };
            let [(grow_f, up_f), (grow_b, up_b)] = [0, 1].map(|q| grow(&points[q], &asides[q]));
            moves(
                ENTRY,
                Change {
                    sigma: sigma_entry,
                    m: sigma_entry * s.tan_friction,
                    branch: [[grow_f, f.angle, zero, up_f], [grow_b, b.angle, zero, up_b]],
                },
            );
        };
        let mut soil = |node: Node<P::Nodes>, power_slope: P::Nodes| {
            let (f, b) = pair(node.u);
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
            let (f, b) = pair(u);
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
        let total = |sums: [P::Nodes; SUMS]| sums.map(|x| P::total(x) * entry);
        let value = total(value);
        let mut by = by.map(total);
        for (slope, value) in by[ENTRY].iter_mut().zip(value) {
            *slope += value;
        }
        Partials { value, by }
    }
}

impl<V: Vector> Aside<V> {
    fn none() -> Self {
        let zero = V::zero();
        Aside {
            across: zero,
            mobilised: zero,
            both: zero,
            own: zero,
            bulge: zero,
        }
    }

    /// Changes of E and A with one of y and one of a.
    fn follow(&self, p: &Point<V>, by_y: V, by_a: V) -> (V, V) {
        (
            p.slope.mul_add(by_y, self.both * by_a),
            self.both.mul_add(by_y, self.own * by_a),
        )
    }
}

impl<V: Vector> Stress<V> {
    /// With F the strength of a displacement of the length B = √(y² + a²): A = F a/B.
    fn aside(&self, p: &Point<V>, across: V) -> Aside<V> {
        let strength = self.strength(p.shear, across);
        let (along, aside) = (p.shear / strength.both, across / strength.both);
        Aside {
            across,
            mobilised: strength.mobilised * aside,
            both: along * aside * (strength.slope - strength.even),
            own: strength.slope * aside.squared() + strength.even * along.squared(),
            bulge: strength.bulge * aside,
        }
    }
}

impl Partials<f64, STRAIGHT> {
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

impl<P: Root, const SUMS: usize> Partials<P, SUMS> {
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
        let rates: [P; SUMS] = std::array::from_fn(|q| {
            let by_entry = if q == 0 { P::one() } else { self.by[ENTRY][q] };
            by_entry / carried
        });
        let residual = load - T::from_primal(self.value[0]);
        let mut sums: [T; SUMS] = std::array::from_fn(|q| {
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
        let entry = T::from_primal(entry);
        (
            entry + entry * sums[0],
            Integrals {
                load,
                thrust: sums[1],
                compaction: sums[2],
                shear: sums[3],
                lateral: sums.get(SIDE).copied().unwrap_or_else(T::zero),
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
        asks[LATERAL] = self.lateral.is_some_and(|tan| tan.varies());
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
            LATERAL => self.lateral.unwrap_or_else(T::zero),
            _ => self.radius,
        }
    }
}
