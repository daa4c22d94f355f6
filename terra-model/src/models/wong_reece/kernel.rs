//! The stress integrals for a given entry angle, with their slopes in its logarithm.
//!
//! Both branches have the same normal stress at equal u, so a node is a pair of angles with one power. Nodes lie side by
//! side for a single contact, contacts side by side for a batch: one source for both.
//!
//! # Equation
//! With a = θm/θ1, d = 1 - a, e = -θ2/θ1, θF = θ1(1 - d u), θB = θ1((a + e) u - e), h = cos θF - cos θ1 and
//! m = c + σ tan φ, per R b:
//! - σ = k R^n h^n = k R^n (h/u)^n u^n, where u^n is in the weight;
//! - W = θ1 ∫ σ (d cos θF + (a+e) cos θB) + m (d E_F sin θF + (a+e) E_B sin θB) du, and so on for the others;
//! - d ln h/d ln θ1 = (θ1 sin θ1 - θF sin θF)/h, dj/d ln θ1 = R (D(θ1) - D(θ)), D(t) = t (1 - (1 - i) cos t).
//!
//! Weights depend on n alone and are made once a solve.

use super::pieces::Pieces;
use super::wheel::{Integrals, Wheel};
use crate::lanes::Vector;
use crate::quadrature::{power_weights, rule};
use crate::real::{Real, Root};

/// The numbers an integrand needs, the same for every node.
#[derive(Clone, Copy)]
pub(super) struct Stress<V> {
    /// k R^n.
    pub(super) scale: V,
    pub(super) exponent: V,
    pub(super) cohesion: V,
    pub(super) tan_friction: V,
    /// Radius of the lugs' tips over K.
    pub(super) per_modulus: V,
    pub(super) slip: V,
    /// a.
    pub(super) apex: V,
    /// e.
    pub(super) exit: V,
    pub(super) hump: V,
    /// Sideways displacement over K per angle behind the entry: (1 - i) |tan β| over K per radius of the lugs' tips.
    pub(super) side: V,
    pub(super) braking: bool,
    pub(super) humped: bool,
    pub(super) sideways: bool,
}

/// One node of both branches.
#[derive(Clone, Copy)]
pub(super) struct Node<V> {
    pub(super) u: V,
    pub(super) inverse: V,
    /// Weight for u^n.
    pub(super) power: V,
    /// Plain weight.
    pub(super) plain: V,
}

/// What is common to all nodes at one entry angle.
#[derive(Clone, Copy)]
pub(super) struct Angle<V> {
    pub(super) entry: V,
    /// sin θ1, θ1 - sin θ1, 1 - cos θ1.
    pub(super) sin: V,
    pub(super) defect: V,
    pub(super) versine: V,
    /// D(θ1).
    pub(super) growth: V,
    /// d and a + e.
    pub(super) front: V,
    pub(super) rear: V,
}

/// One angle of the contact.
#[derive(Clone, Copy)]
pub(super) struct Point<V> {
    pub(super) angle: V,
    pub(super) sin: V,
    pub(super) cos: V,
    pub(super) versine: V,
    /// E and its slope in j/K; j/K itself, as a magnitude; the hump without its height.
    pub(super) mobilised: V,
    pub(super) slope: V,
    pub(super) shear: V,
    pub(super) bulge: V,
    /// dE/d ln θ1 by the displacement across the wheel.
    pub(super) drift: V,
}

/// The strength of a displacement of some length B, over the most there is.
pub(super) struct Strength<V> {
    /// B/K.
    pub(super) both: V,
    pub(super) mobilised: V,
    /// Its slope in B/K, and what it is over B/K.
    pub(super) slope: V,
    pub(super) even: V,
    /// The hump without its height.
    pub(super) bulge: V,
}

impl<V: Vector> Stress<V> {
    #[inline(always)]
    pub(super) fn at(&self, entry: V) -> Angle<V> {
        let (defect, versine) = entry.sine_defects();
        Angle {
            entry,
            sin: entry - defect,
            defect,
            versine,
            growth: self.growth(entry, versine),
            front: V::one() - self.apex,
            rear: self.apex + self.exit,
        }
    }

    /// D(t) = t (i + (1 - i)(1 - cos t)).
    #[inline(always)]
    pub(super) fn growth(&self, angle: V, versine: V) -> V {
        versine.mul_add(V::one() - self.slip, self.slip) * angle
    }

    #[inline(always)]
    pub(super) fn point<const SIDEWAYS: bool>(
        &self,
        at: &Angle<V>,
        angle: V,
        ahead: V,
    ) -> Point<V> {
        let (defect, versine) = angle.sine_defects();
        // j/R = i (θ1 - θ) + (1 - i)((θ1 - sin θ1) - (θ - sin θ))
        let j = (at.defect - defect).mul_add(V::one() - self.slip, self.slip * ahead);
        let y = j * self.per_modulus;
        if SIDEWAYS {
            return self.sideways_point(angle, [defect, versine], y, self.side * ahead);
        }
        let shear = if self.braking { y.abs() } else { y };
        let rest = (-shear).exp_m1_fast();
        let (rise, left) = (-rest, rest + 1.0);
        let (mut mobilised, mut slope, mut bulge) = (rise, left, V::zero());
        if self.humped {
            // E (1 + hump y e^(1 - y))
            bulge = shear * left * std::f64::consts::E;
            let height = self.hump * bulge + 1.0;
            slope =
                left * height + rise * self.hump * left * (V::one() - shear) * std::f64::consts::E;
            mobilised = rise * height;
            bulge = rise * bulge;
        }
        if self.braking {
            let zero = V::zero();
            mobilised = y.select_lt(zero, -mobilised, mobilised);
            bulge = y.select_lt(zero, -bulge, bulge);
        }
        Point {
            angle,
            sin: angle - defect,
            cos: V::one() - versine,
            versine,
            mobilised,
            slope,
            shear: y,
            bulge,
            drift: V::zero(),
        }
    }

    /// F of a displacement that is y along the wheel and `across` it, each over K.
    #[inline(always)]
    pub(super) fn strength(&self, y: V, across: V) -> Strength<V> {
        let square = y.squared() + across.squared() + f64::MIN_POSITIVE;
        let both = square.sqrt();
        let rest = (-both).exp_m1_fast();
        let (rise, left) = (-rest, rest + 1.0);
        let hump = both * left * std::f64::consts::E;
        let height = self.hump * hump + 1.0;
        let mobilised = rise * height;
        let slope =
            left * height + rise * self.hump * left * (V::one() - both) * std::f64::consts::E;
        Strength {
            both,
            mobilised,
            slope,
            even: mobilised / both,
            bulge: rise * hump,
        }
    }

    /// The strength points along (j_x, j_y) of a length j: E(j) j_x/j along the wheel, where j_y grows with θ1 as it is.
    #[inline(never)]
    fn sideways_point(&self, angle: V, [defect, versine]: [V; 2], y: V, across: V) -> Point<V> {
        let Strength {
            both,
            mobilised,
            slope,
            even,
            bulge,
        } = self.strength(y, across);
        let way = y / both;
        let share = (across / both).squared();
        Point {
            angle,
            sin: angle - defect,
            cos: V::one() - versine,
            versine,
            mobilised: mobilised * way,
            slope: slope * way.squared() + even * share,
            shear: y,
            bulge: bulge * way,
            drift: y * share * (slope - even),
        }
    }

    #[inline(always)]
    pub(super) fn pair<const SIDEWAYS: bool>(&self, at: &Angle<V>, u: V) -> (Point<V>, Point<V>) {
        let ahead = at.entry * at.front * u;
        let front = self.point::<SIDEWAYS>(at, at.entry - ahead, ahead);
        let angle = at.entry * at.rear.mul_add(u, -self.exit);
        let rear = self.point::<SIDEWAYS>(at, angle, at.entry - angle);
        (front, rear)
    }
}

impl<V: Vector> Angle<V> {
    /// dh/d ln θ1 at an angle of the front branch.
    #[inline(always)]
    pub(super) fn deepening(&self, front: &Point<V>) -> V {
        self.entry * self.sin - front.angle * front.sin
    }
}

/// A stiffer layer below the surface.
#[derive(Clone, Copy)]
pub(super) struct Layer<V> {
    pub(super) depth: V,
    pub(super) stiffness: V,
    pub(super) radius: V,
}

/// Sums over nodes: load, thrust, compaction resistance, shear, and their slopes.
pub(super) struct Sums<V> {
    value: [V; 4],
    slope: [V; 4],
}

impl<V: Vector> Sums<V> {
    pub(super) fn new() -> Self {
        Sums {
            value: [V::zero(); 4],
            slope: [V::zero(); 4],
        }
    }

    #[inline(always)]
    pub(super) fn add<const SIDEWAYS: bool>(
        &mut self,
        s: &Stress<V>,
        at: &Angle<V>,
        node: &Node<V>,
    ) {
        let (f, b) = s.pair::<SIDEWAYS>(at, node.u);
        // h by the difference of 1 - cos: it loses what the first node is close to the entry, a factor of a hundred.
        let depth = at.versine - f.versine;
        let sigma =
            ((depth * node.inverse).ln_fast() * s.exponent).exp_fast() * s.scale * node.power;
        let sigma_slope = sigma * s.exponent * at.deepening(&f) / depth;
        self.add_stress::<SIDEWAYS>(s, at, [&f, &b], [sigma, sigma_slope, node.plain]);
    }

    /// A node of the layer below the surface: σ grows linearly from its top. Its cohesion is in the main integral.
    #[inline]
    fn add_layer<const SIDEWAYS: bool>(
        &mut self,
        s: &Stress<V>,
        at: &Angle<V>,
        layer: &Layer<V>,
        u: V,
        plain: V,
    ) {
        let (f, b) = s.pair::<SIDEWAYS>(at, u);
        let scale = layer.stiffness * plain;
        let depth = (at.versine - f.versine).mul_add(layer.radius, -layer.depth);
        let slope = scale * layer.radius * at.deepening(&f);
        self.add_stress::<SIDEWAYS>(s, at, [&f, &b], [scale * depth, slope, V::zero()]);
    }

    /// Adds σ with its slope at one node, and the shear stress that goes with it.
    #[inline(always)]
    fn add_stress<const SIDEWAYS: bool>(
        &mut self,
        s: &Stress<V>,
        at: &Angle<V>,
        [f, b]: [&Point<V>; 2],
        [sigma, sigma_slope, plain]: [V; 3],
    ) {
        let m = sigma.mul_add(s.tan_friction, s.cohesion * plain);
        let m_slope = sigma_slope * s.tan_friction;

        let (cos_f, cos_b) = (at.front * f.cos, at.rear * b.cos);
        let (sin_f, sin_b) = (at.front * f.sin, at.rear * b.sin);
        let (e_f, e_b) = (f.mobilised, b.mobilised);
        let grow = |p: &Point<V>| {
            let along = (at.growth - s.growth(p.angle, p.versine)) * s.per_modulus * p.slope;
            if SIDEWAYS { along + p.drift } else { along }
        };
        let (de_f, de_b) = (grow(f), grow(b));

        // ∫ over both branches of cos, sin; of E cos, E sin, E; and the slopes of each.
        let cos = cos_f + cos_b;
        let sin = sin_f + sin_b;
        let turn = sin_f.mul_add(f.angle, sin_b * b.angle);
        let lift = cos_f.mul_add(f.angle, cos_b * b.angle);
        let along = e_f.mul_add(cos_f, e_b * cos_b);
        let up = e_f.mul_add(sin_f, e_b * sin_b);
        let all = e_f.mul_add(at.front, e_b * at.rear);
        let along_slope =
            de_f * cos_f + de_b * cos_b - (e_f * sin_f).mul_add(f.angle, e_b * sin_b * b.angle);
        let up_slope =
            de_f * sin_f + de_b * sin_b + (e_f * cos_f).mul_add(f.angle, e_b * cos_b * b.angle);
        let all_slope = de_f.mul_add(at.front, de_b * at.rear);

        let [load, thrust, compaction, shear] = &mut self.value;
        *load += sigma.mul_add(cos, m * up);
        *thrust = m.mul_add(along, *thrust);
        *compaction = sigma.mul_add(sin, *compaction);
        *shear = m.mul_add(all, *shear);
        let [load, thrust, compaction, shear] = &mut self.slope;
        *load += sigma_slope.mul_add(cos, m_slope * up) + m.mul_add(up_slope, -(sigma * turn));
        *thrust += m_slope.mul_add(along, m * along_slope);
        *compaction += sigma_slope.mul_add(sin, sigma * lift);
        *shear += m_slope.mul_add(all, m * all_slope);
    }

    /// Load per R b, and its slope.
    #[inline]
    pub(super) fn load<P: Root<Nodes = V>>(&self, entry: P) -> (P, P) {
        let value = P::total(self.value[0]) * entry;
        (value, value + P::total(self.slope[0]) * entry)
    }

    /// All integrals per R b, and their slopes in ln θ1.
    pub(super) fn integrals<P: Root<Nodes = V>>(&self, entry: P) -> (Integrals<P>, Integrals<P>) {
        let value = self.value.map(|x| P::total(x) * entry);
        let slope = self.slope.map(|x| P::total(x) * entry);
        let named = |[load, thrust, compaction, shear]: [P; 4]| Integrals {
            load,
            thrust,
            compaction,
            shear,
            lateral: P::zero(),
        };
        let all: [P; 4] = std::array::from_fn(|q| value[q] + slope[q]);
        (named(value), named(all))
    }
}

/// The integrals of one wheel by a rule of `ORDER` nodes a piece.
pub(super) struct Integrator<'w, P: Root, const ORDER: usize> {
    pub(super) wheel: &'w Wheel<P>,
    pub(super) stress: Stress<P::Nodes>,
    pub(super) weights: [P::Nodes; ORDER],
}

/// How a weight grows with n, as a share of it, and in the first piece through the rule's own weight: which, times what.
type PowerSlope<V> = (V, Option<(usize, V)>);

/// Steepness of j/K above which the branches are tried for pieces.
const STEEP: f64 = 6.0;

impl<'w, P: Root, const ORDER: usize> Integrator<'w, P, ORDER> {
    #[inline]
    pub(super) fn new(wheel: &'w Wheel<P>, stress: Stress<P::Nodes>) -> Self {
        Integrator {
            wheel,
            stress,
            weights: power_weights::<P, ORDER>(wheel.ground.exponent),
        }
    }

    /// Whether each branch is one piece, without asking where it would be cut.
    pub(super) fn whole(&self, entry: P) -> bool {
        !self.stress.braking && !P::from(STEEP).any_lt(self.steepness(entry))
    }

    /// How much j/K changes along the longer branch at most: |dj/dθ| <= R (i + (1 - i) θ1²/2) for i >= 0.
    pub(super) fn steepness(&self, entry: P) -> P {
        let g = &self.wheel.ground;
        let slope = g.slip + (P::one() - g.slip) * entry * entry * 0.5;
        let longest = (P::one() - g.apex_ratio).max_of(g.apex_ratio + self.wheel.exit_ratio);
        slope * entry * longest * self.wheel.shear_radius / g.shear_modulus
    }

    #[inline]
    pub(super) fn at(&self, entry: P) -> Sums<P::Nodes> {
        if self.whole(entry) && self.wheel.layer.is_none() {
            self.in_one(entry)
        } else {
            self.cut(entry)
        }
    }

    #[inline]
    fn in_one(&self, entry: P) -> Sums<P::Nodes> {
        if self.stress.sideways {
            self.whole_at::<true>(entry)
        } else {
            self.whole_at::<false>(entry)
        }
    }

    fn cut(&self, entry: P) -> Sums<P::Nodes> {
        if self.stress.sideways {
            self.cut_at::<true>(entry)
        } else {
            self.cut_at::<false>(entry)
        }
    }

    /// To a part in a hundred: each branch in one piece wherever the shear stress is not too steep for that.
    #[inline]
    pub(super) fn roughly_at(&self, entry: P) -> Sums<P::Nodes> {
        if !self.stress.braking {
            return self.at(entry);
        }
        let g = &self.wheel.ground;
        let slope = g.slip.abs() + (P::one() - g.slip) * entry * entry * 0.5;
        let steepness = slope * entry * self.wheel.shear_radius / g.shear_modulus;
        if P::from(ORDER as f64).any_lt(steepness) {
            return self.cut(entry);
        }
        let mut sums = self.in_one(entry);
        self.add_layer(entry, &mut sums);
        sums
    }

    /// Each branch in one piece, and no layer.
    #[inline]
    pub(super) fn whole_at<const SIDEWAYS: bool>(&self, entry: P) -> Sums<P::Nodes> {
        let at = self.stress.at(entry.spread());
        let mut sums = Sums::new();
        let rule = rule::<ORDER>();
        for (chunk, &power) in self.weights.iter().enumerate() {
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
            sums.add::<SIDEWAYS>(&self.stress, &at, &node);
        }
        sums
    }

    fn cut_at<const SIDEWAYS: bool>(&self, entry: P) -> Sums<P::Nodes> {
        let mut sums = Sums::new();
        if self.whole(entry) {
            sums = self.whole_at::<SIDEWAYS>(entry);
        } else {
            let at = self.stress.at(entry.spread());
            self.each_node(entry, |node, _| {
                sums.add::<SIDEWAYS>(&self.stress, &at, &node)
            });
        }
        self.add_layer(entry, &mut sums);
        sums
    }

    /// Adds the layer below the surface, if there is one.
    #[inline]
    fn add_layer(&self, entry: P, sums: &mut Sums<P::Nodes>) {
        if self.wheel.layer.is_none() {
            return;
        }
        let at = self.stress.at(entry.spread());
        self.each_layer_node(entry, |layer, u, plain| {
            if self.stress.sideways {
                sums.add_layer::<true>(&self.stress, &at, layer, u, plain);
            } else {
                sums.add_layer::<false>(&self.stress, &at, layer, u, plain);
            }
        });
    }

    /// Nodes and weights of a layer below the surface, where the contact reaches it.
    pub(super) fn each_layer_node(
        &self,
        entry: P,
        mut visit: impl FnMut(&Layer<P::Nodes>, P::Nodes, P::Nodes),
    ) {
        let Some((depth, stiffness)) = self.wheel.layer else {
            return;
        };
        let (begins, one) = (self.wheel.layer_begins(entry, depth), P::one());
        if !begins.any_lt(one) {
            return;
        }
        let layer = Layer {
            depth: depth.spread(),
            stiffness: stiffness.spread(),
            radius: self.wheel.radius.spread(),
        };
        let (ends, pieces) = Pieces::united(self.wheel.pieces(entry));
        let rule = rule::<ORDER>();
        for k in 0..=ends.len() {
            let start = if k == 0 {
                begins
            } else {
                ends[k - 1].max_of(begins)
            };
            let high = ends.get(k).copied().unwrap_or(one);
            pieces.each_part(start, high, |start, length| {
                for q in (0..ORDER).step_by(P::NODES_AT_ONCE) {
                    let u = P::table(&rule.nodes[q..]).mul_add(length.spread(), start.spread());
                    visit(&layer, u, P::table(&rule.weights[q..]) * length.spread());
                }
            });
        }
    }

    /// The nodes of all pieces, and how each one's weight for u^n grows with n.
    pub(super) fn each_node(
        &self,
        entry: P,
        mut visit: impl FnMut(Node<P::Nodes>, PowerSlope<P::Nodes>),
    ) {
        let rule = rule::<ORDER>();
        let (ends, pieces) = Pieces::united(self.wheel.pieces(entry));
        let first = ends[0];
        let (length, ln_first) = (first.spread(), first.ln());
        let factor = ((self.wheel.ground.exponent + 1.0) * ln_first)
            .exp()
            .spread();
        for (chunk, &power) in self.weights.iter().enumerate() {
            let q = chunk * P::NODES_AT_ONCE;
            if q >= ORDER {
                break;
            }
            let node = Node {
                u: P::table(&rule.nodes[q..]) * length,
                inverse: P::table(&rule.inverse[q..]) / length,
                power: power * factor,
                plain: P::table(&rule.weights[q..]) * length,
            };
            visit(node, (ln_first.spread(), Some((chunk, factor))));
        }
        let one = P::one();
        for k in 0..ends.len() {
            let high = ends.get(k + 1).copied().unwrap_or(one);
            pieces.each_part(ends[k], high, |start, length| {
                for q in (0..ORDER).step_by(P::NODES_AT_ONCE) {
                    let u = P::table(&rule.nodes[q..]).mul_add(length.spread(), start.spread());
                    let plain = P::table(&rule.weights[q..]) * length.spread();
                    let ln_u = u.ln_fast();
                    let node = Node {
                        u,
                        inverse: P::Nodes::one() / u,
                        power: (ln_u * self.stress.exponent).exp_fast() * plain,
                        plain,
                    };
                    visit(node, (ln_u, None));
                }
            });
        }
    }
}

impl<P: Root> Wheel<P> {
    /// What the integrand needs, for every node.
    pub(super) fn stress(&self) -> Stress<P::Nodes> {
        let g = &self.ground;
        self.stress_of(g.stiffness * self.radius.pow_pos(g.exponent))
    }

    /// The same with k R^n known.
    #[inline]
    pub(super) fn stress_of(&self, scale: P) -> Stress<P::Nodes> {
        let g = &self.ground;
        let humped = P::zero().any_lt(self.hump);
        let per_modulus = self.shear_radius / g.shear_modulus;
        let side = self.lateral.map_or(P::zero(), |tan| {
            per_modulus * (P::one() - g.slip) * tan.abs()
        });
        Stress {
            scale: scale.spread(),
            exponent: g.exponent.spread(),
            cohesion: g.cohesion.spread(),
            tan_friction: g.tan_friction.spread(),
            per_modulus: per_modulus.spread(),
            slip: g.slip.spread(),
            apex: g.apex_ratio.spread(),
            exit: self.exit_ratio.spread(),
            hump: self.hump.spread(),
            side: side.spread(),
            braking: self.braking,
            humped,
            sideways: self.lateral.is_some(),
        }
    }
}
