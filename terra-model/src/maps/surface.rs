//! Pull and torque of one soil and wheel as a polynomial in slip, load and at most one quantity more, with whatever derivatives its
//! numbers carry: a few dozen contacts stand for hundreds on the same side of zero slip, each at a tenth of a solve's cost.
//!
//! # Equation
//! D/W = Σ d_ijk T_i(s) T_j(x) T_k(y), T/W likewise, with Chebyshev's polynomials in slip, in x = ln W and in what is beside them,
//! each scaled to \[-1, 1\]. The coefficients are the discrete sums over Chebyshev's nodes, zeros in slip and load, extremes beside
//! them: two or three values of a quantity that has no more are met exactly.
//!
//! # Reference
//! L. N. Trefethen, *Approximation Theory and Approximation Practice*, SIAM 2013, chapters 2, 3, 4 and 8.

use crate::lanes::{Abreast, Lanes, Vector};
use crate::maps::MapRange;
use crate::maps::chebyshev::chebyshev;
use crate::real::{Real, Root, is_plain};

/// Most nodes in a direction.
const MOST: usize = 24;
/// A share of the load that is nothing.
const NOTHING: f64 = 1e-7;

/// A quantity that forces follow from beside slip and load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside {
    /// From where to where.
    pub range: (f64, f64),
    /// How many nodes, the first and the last at its ends (2 to 24).
    pub nodes: usize,
    /// Whether it has no other values than its nodes.
    pub discrete: bool,
}

impl Beside {
    /// Values at its nodes.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.nodes).map(|k| self.value(extreme(k, self.nodes - 1)))
    }

    /// Of a place on \[-1, 1\].
    fn value(&self, y: f64) -> f64 {
        let (low, high) = self.range;
        0.5 * (low + high) + 0.5 * y * (high - low)
    }
}

/// Where contacts are asked for that a surface goes through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceNodes {
    range: MapRange,
    slips: usize,
    loads: usize,
    beside: Option<Beside>,
}

/// Slips \[1\] and normal loads \[N\] of eight contacts, and what is beside them; 0 where nothing is.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceContacts {
    /// Slip.
    pub slip: Lanes,
    /// Normal load.
    pub load: Lanes,
    /// What is beside them.
    pub beside: Lanes,
}

/// Where eight contacts lie among the polynomials of a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePlace {
    slip: Lanes,
    load: Lanes,
    beside: Lanes,
}

impl SurfaceNodes {
    /// So many in slip and in load (2 to 24, their product a multiple of eight) over a range that is not empty; slips may be
    /// negative.
    pub fn new(range: MapRange, slips: usize, loads: usize) -> Self {
        SurfaceNodes {
            range,
            slips: slips.clamp(2, MOST),
            loads: loads.clamp(2, MOST),
            beside: None,
        }
    }

    /// The same at each node of something beside slip and load.
    #[must_use]
    pub fn beside(self, beside: Beside) -> Self {
        let nodes = beside.nodes.clamp(2, MOST);
        SurfaceNodes {
            beside: Some(Beside { nodes, ..beside }),
            ..self
        }
    }

    /// What it covers.
    pub fn range(&self) -> MapRange {
        self.range
    }

    /// And beside slip and load.
    pub fn range_beside(&self) -> Option<(f64, f64)> {
        self.beside.map(|beside| beside.range)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.layer() * self.layers()
    }

    /// Never.
    pub fn is_empty(&self) -> bool {
        false
    }

    fn layer(&self) -> usize {
        self.slips * self.loads
    }

    fn layers(&self) -> usize {
        self.beside.map_or(1, |b| b.nodes)
    }

    /// How many groups of eight.
    pub fn groups(&self) -> usize {
        self.layer().div_ceil(Lanes::WIDTH) * self.layers()
    }

    /// One group; lanes that are left over repeat the last node of its layer.
    pub fn group(&self, number: usize) -> SurfaceContacts {
        let of_layer = self.layer().div_ceil(Lanes::WIDTH);
        let (layer, number) = (number / of_layer, number % of_layer);
        let node = |lane: usize| (number * Lanes::WIDTH + lane).min(self.layer() - 1);
        self.contacts(
            |lane| chebyshev(node(lane) / self.loads, self.slips),
            |lane| chebyshev(node(lane) % self.loads, self.loads),
            |_| extreme(layer, self.layers() - 1),
        )
    }

    /// Contacts on the edges and in the midst, as far from the nodes as may be: eight, or as many times eight as slips go into tens.
    pub fn between(&self) -> impl ExactSizeIterator<Item = SurfaceContacts> + '_ {
        let groups = self.slips.div_ceil(10);
        let last = groups * Lanes::WIDTH - 1;
        let gaps = self.layers() - 1;
        let discrete = self.beside.is_some_and(|b| b.discrete);
        (0..groups).map(move |group| {
            let number = |lane: usize| group * Lanes::WIDTH + lane;
            let nearest = |lane| (2 * number(lane) * self.slips + last) / (2 * last);
            self.contacts(
                |lane| extreme(nearest(lane), self.slips),
                |lane| extreme(3 * number(lane) % (self.loads + 1), self.loads),
                |lane| match gaps {
                    0 => 0.0,
                    _ if discrete => extreme(5 * number(lane) % (gaps + 1), gaps),
                    _ => chebyshev(5 * number(lane) % gaps, gaps),
                },
            )
        })
    }

    /// Contacts at these places on \[-1, 1\].
    fn contacts(
        &self,
        slip: impl Fn(usize) -> f64,
        load: impl Fn(usize) -> f64,
        beside: impl Fn(usize) -> f64,
    ) -> SurfaceContacts {
        let (low, high) = self.log_load();
        let lanes = || 0..Lanes::WIDTH;
        SurfaceContacts {
            slip: Lanes::gather(lanes().map(|lane| self.range.slip_at(slip(lane)))),
            load: Lanes::gather(
                lanes().map(|lane| (low + 0.5 * (load(lane) + 1.0) * (high - low)).exp()),
            ),
            beside: Lanes::gather(
                lanes().map(|lane| self.beside.map_or(0.0, |b| b.value(beside(lane)))),
            ),
        }
    }

    fn log_load(&self) -> (f64, f64) {
        let (low, high) = self.range.normal_load;
        (low.ln(), high.ln())
    }

    /// How much a unit of slip is on \[-1, 1\], and one of the logarithm of load.
    fn scales(&self) -> [f64; 2] {
        let ((slips, loads), (low, high)) = ((self.range.slip, self.log_load()), (0.0, 2.0));
        [slips, loads].map(|(from, to)| (high - low) / (to - from))
    }

    /// Where contacts lie.
    pub fn place(&self, at: &SurfaceContacts) -> SurfacePlace {
        let [per_slip, per_log] = self.scales();
        let beside = self.beside.map_or(at.beside, |b| {
            let (low, high) = b.range;
            (at.beside * 2.0 - (low + high)) / (high - low)
        });
        SurfacePlace {
            slip: (at.slip - self.range.slip.0) * per_slip - 1.0,
            load: (at.load.ln() - self.log_load().0) * per_log - 1.0,
            beside,
        }
    }

    /// Products of the polynomials at a place times a factor, in the order of nodes, into as many numbers as there are nodes.
    pub fn products(&self, at: &SurfacePlace, factor: Lanes, out: &mut [Lanes]) {
        let of_load = values(at.load, self.loads);
        let layers = out.chunks_exact_mut(self.layer());
        for (layer, of_beside) in layers.zip(polynomials(at.beside, self.layers())) {
            let factor = of_beside * factor;
            let rows = layer.chunks_exact_mut(self.loads);
            for (row, of_slip) in rows.zip(polynomials(at.slip, self.slips)) {
                let factor = of_slip * factor;
                for (product, of_load) in row.iter_mut().zip(&of_load) {
                    *product = *of_load * factor;
                }
            }
        }
    }
}

/// Pull and torque over slip, load and what is beside them, eight contacts at a time.
#[derive(Clone, Debug)]
pub struct ForceSurface<T> {
    nodes: SurfaceNodes,
    terms: [Vec<Term<T>>; 2],
}

/// A product of polynomials, by its number, with its coefficient.
#[derive(Clone, Debug)]
struct Term<T> {
    number: usize,
    of: T,
}

impl<T: Abreast> ForceSurface<T> {
    /// Through D \[N\] and T \[N m\] of every group of nodes. Left out is what is nothing beside the load, or beside the load times
    /// `arm` \[m\].
    pub fn through(nodes: SurfaceNodes, forces: &[[T; 2]], arm: f64) -> Self {
        let over_load = |k: usize| -> Vec<T> {
            let each = forces.iter().enumerate();
            let inverse = |group| Lanes::one() / nodes.group(group).load;
            each.map(|(group, forces)| forces[k].scaled(inverse(group)))
                .collect()
        };
        ForceSurface {
            nodes,
            terms: [(0, 1.0), (1, arm)].map(|(k, arm)| terms(&nodes, &over_load(k), NOTHING * arm)),
        }
    }

    /// How far it is at most from D \[N\] and T \[N m\] at the contacts [`SurfaceNodes::between`] nodes, as a share of load and of
    /// load times `arm` \[m\].
    pub fn error(&self, forces: &[[Lanes; 2]], arm: f64) -> f64 {
        let mut products = vec![Lanes::zero(); self.nodes.len()];
        let mut worst: f64 = 0.0;
        for (at, [pull, torque]) in self.nodes.between().zip(forces) {
            let place = self.nodes.place(&at);
            self.nodes.products(&place, at.load, &mut products);
            for (found, force, arm) in [
                (self.pull(&products), pull, 1.0),
                (self.torque(&products), torque, arm),
            ] {
                let share = ((found.primal() - *force) / (at.load * arm)).abs();
                if !share.is_finite() {
                    return f64::INFINITY;
                }
                worst = worst.max(share.max_lane());
            }
        }
        worst
    }

    /// Its nodes.
    pub fn nodes(&self) -> SurfaceNodes {
        self.nodes
    }

    /// Sum of D \[N\] over contacts, out of their [products](SurfaceNodes::products) times load \[N\].
    pub fn pull(&self, products: &[Lanes]) -> T {
        let each = self.terms[0].iter();
        T::dot(each.map(|term| (&term.of, products[term.number])))
    }

    /// The same of T \[N m\].
    pub fn torque(&self, products: &[Lanes]) -> T {
        let each = self.terms[1].iter();
        T::dot(each.map(|term| (&term.of, products[term.number])))
    }

    /// D \[N\] and T \[N m\] at a slip \[1\] and a normal load \[N\] of a surface over these alone, with the slopes that coefficients,
    /// slip and load have. Only within the range of its nodes: beyond it the polynomial goes on, and means nothing.
    pub fn at(&self, slip: &T, load: &T) -> [T; 2] {
        let SurfaceNodes { slips, loads, .. } = self.nodes;
        let weight = load.primal();
        let place = self.nodes.place(&SurfaceContacts {
            slip: slip.primal(),
            load: weight,
            beside: Lanes::zero(),
        });
        let (of_slip, of_load) = (values(place.slip, slips), values(place.load, loads));
        let moves = |x: &T| !is_plain::<T>() && x.varies();
        let by = |term: &Term<T>| of_slip[term.number / loads] * of_load[term.number % loads];
        let mut sums =
            [0, 1].map(|k| T::dot(self.terms[k].iter().map(|term| (&term.of, by(term)))));
        let [per_slip, per_log] = self.nodes.scales();
        for (varies, x, of_slip, of_load, rate) in [
            (
                moves(slip),
                slip,
                slopes(place.slip, &of_slip[..slips]),
                of_load,
                Lanes::from(per_slip),
            ),
            (
                moves(load),
                load,
                of_slip,
                slopes(place.load, &of_load[..loads]),
                Lanes::from(per_log) / weight,
            ),
        ] {
            if !varies {
                continue;
            }
            let step = *x - T::from_primal(x.primal());
            for (sum, terms) in sums.iter_mut().zip(&self.terms) {
                let mut by = Lanes::zero();
                for Term { number, of } in terms {
                    let slope = of_slip[number / loads] * of_load[number % loads];
                    by = of.primal().mul_add(slope, by);
                }
                sum.add_scaled(&step, by * rate);
            }
        }
        sums.map(|sum| sum * *load)
    }
}

/// Coefficients out of values at every group of nodes; left out are those below `nothing`.
fn terms<T: Abreast>(nodes: &SurfaceNodes, values: &[T], nothing: f64) -> Vec<Term<T>> {
    let SurfaceNodes { slips, loads, .. } = *nodes;
    let (layer, layers) = (nodes.layer(), nodes.layers());
    let groups = nodes.groups() / layers;
    let (by_slip, by_load, by_layer) = (at_zeros(slips), at_zeros(loads), at_extremes(layers));
    let mut terms = vec![];
    let mut combined: Vec<T> = values.to_vec();
    if layers > 1 {
        for (degree, by_layer) in by_layer.iter().enumerate() {
            for group in 0..groups {
                let each = by_layer.iter().enumerate();
                let each = each.map(|(k, &by)| (&values[k * groups + group], Lanes::from(by)));
                combined[degree * groups + group] = T::dot(each);
            }
        }
    }
    for number in 0..layer * layers {
        let (degree, in_layer) = (number / layer, number % layer);
        let (by_slip, by_load) = (&by_slip[in_layer / loads], &by_load[in_layer % loads]);
        let weight = |node: usize| {
            let slip = by_slip.get(node / loads).copied().unwrap_or(0.0);
            slip * by_load[node % loads]
        };
        let each = (0..groups).map(|group| {
            let lanes = (0..Lanes::WIDTH).map(|lane| weight(group * Lanes::WIDTH + lane));
            (&combined[degree * groups + group], Lanes::gather(lanes))
        });
        let of = T::dot(each).total_of_lanes();
        let size = of.primal().abs().max_lane();
        if size >= nothing || size.is_nan() {
            terms.push(Term { number, of });
        }
    }
    terms
}

/// Place k of n + 1 on \[-1, 1\] where a polynomial of degree n has its extremes.
fn extreme(k: usize, n: usize) -> f64 {
    if n == 0 {
        return 0.0;
    }
    -(std::f64::consts::PI * k as f64 / n as f64).cos()
}

/// Weight of the value at each zero in each coefficient.
fn at_zeros(n: usize) -> Vec<Vec<f64>> {
    let at: Vec<Vec<f64>> = (0..n)
        .map(|k| polynomials(chebyshev(k, n), n).collect())
        .collect();
    let weight = |degree: usize| if degree == 0 { 1.0 } else { 2.0 } / n as f64;
    let of = |degree: usize| at.iter().map(|t| t[degree] * weight(degree)).collect();
    (0..n).map(of).collect()
}

/// The same at extremes, the ends at half weight.
fn at_extremes(nodes: usize) -> Vec<Vec<f64>> {
    let n = nodes - 1;
    if n == 0 {
        return vec![vec![1.0]];
    }
    let half = |k: usize| if k == 0 || k == n { 0.5 } else { 1.0 };
    let of = |degree: usize| {
        let at = (0..nodes)
            .map(|k| (degree as f64 * extreme(k, n).clamp(-1.0, 1.0).acos()).cos() * half(k));
        at.map(|t| t * 2.0 * half(degree) / n as f64).collect()
    };
    (0..nodes).map(of).collect()
}

/// T_0(x), T_1(x), ... so many.
fn polynomials<V: Real>(x: V, count: usize) -> impl Iterator<Item = V> {
    let start = (x, V::one());
    let next = move |(before, now): &mut (V, V)| {
        let value = *now;
        (*before, *now) = (value, x * value * 2.0 - *before);
        Some(value)
    };
    (0..count).scan(start, move |state, _| next(state))
}

/// The same in a row.
fn values(x: Lanes, count: usize) -> [Lanes; MOST] {
    let mut out = [Lanes::one(); MOST];
    for (value, of) in out.iter_mut().zip(polynomials(x, count)) {
        *value = of;
    }
    out
}

/// Their slopes.
fn slopes(x: Lanes, polynomials: &[Lanes]) -> [Lanes; MOST] {
    let mut out = [Lanes::zero(); MOST];
    let (mut before, mut now) = (Lanes::one(), Lanes::zero());
    for (slope, value) in out.iter_mut().zip(polynomials) {
        *slope = now;
        (before, now) = (now, (*value + x * now) * 2.0 - before);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Circumstance, Contact, ForceLaw, LaneDual, Law, Registry, catalogue};

    const RANGE: MapRange = MapRange {
        slip: (0.0, 0.8),
        normal_load: (180.0, 350.0),
    };
    const BRAKED: MapRange = MapRange {
        slip: (-0.06, 0.0),
        normal_load: (180.0, 350.0),
    };

    const DEEPER: MapRange = MapRange {
        slip: (-0.15, 0.0),
        normal_load: (180.0, 350.0),
    };

    const DEEPEST: MapRange = MapRange {
        slip: (-0.2, 0.0),
        normal_load: (180.0, 350.0),
    };

    /// Pull and torque of a function at groups of nodes.
    fn at_groups<T: Abreast>(nodes: &SurfaceNodes, of: impl Fn(T, T, T) -> [T; 2]) -> Vec<[T; 2]> {
        let group = |k| {
            let SurfaceContacts { slip, load, beside } = nodes.group(k);
            of(
                T::from_primal(slip),
                T::from_primal(load),
                T::from_primal(beside),
            )
        };
        (0..nodes.groups()).map(group).collect()
    }

    /// Eight contacts inside a range.
    fn inside(range: MapRange, k: u32) -> (Lanes, Lanes) {
        let spread = |(low, high): (f64, f64), step: f64| {
            let at = move |lane: u32| (f64::from(8 * k + lane) * step).fract();
            Lanes::gather((0..8).map(move |lane| low + (high - low) * at(lane)))
        };
        (
            spread(range.slip, 0.618_034),
            spread(range.normal_load, 0.754_878),
        )
    }

    /// Polynomials whose degrees it holds are reproduced, with their slopes in slip, load and a coefficient.
    #[test]
    fn polynomials_are_reproduced_with_their_slopes() {
        let of = |a: LaneDual, slip: LaneDual, load: LaneDual| {
            let x = load.ln();
            let d = a * slip * slip * slip + a * a * slip * x - x * x * 0.1;
            let t = slip * slip * x * 0.3 - a * slip + 1.0;
            [d * load, t * load]
        };
        let a = LaneDual::variable(Lanes::from(0.7), 0);
        let nodes = SurfaceNodes::new(RANGE, 10, 4);
        assert_eq!(nodes.groups(), 5);
        let values = at_groups(&nodes, |slip, load, _| of(a, slip, load));
        let surface = ForceSurface::through(nodes, &values, 0.25);
        for k in 0..4 {
            let (slip, load) = inside(RANGE, k);
            let (slip, load) = (LaneDual::variable(slip, 1), LaneDual::variable(load, 2));
            let (found, truth) = (surface.at(&slip, &load), of(a, slip, load));
            for (found, truth) in found.iter().zip(&truth) {
                for lane in 0..8 {
                    let (value, exact) = (found.primal().lane(lane), truth.primal().lane(lane));
                    assert!(
                        (value - exact).abs() < 1e-6 * (1.0 + exact.abs()),
                        "{value} {exact}"
                    );
                    for variable in 0..3 {
                        let (slope, exact) =
                            (found.slope(variable, lane), truth.slope(variable, lane));
                        let size = 1.0 + exact.abs();
                        assert!(
                            (slope - exact).abs() < 1e-4 * size,
                            "{variable}: {slope} {exact}"
                        );
                    }
                }
            }
        }
    }

    /// What it gives at contacts.
    fn given(surface: &ForceSurface<Lanes>, at: &SurfaceContacts) -> [Lanes; 2] {
        let nodes = surface.nodes();
        let mut products = vec![Lanes::zero(); nodes.len()];
        nodes.products(&nodes.place(at), at.load, &mut products);
        [surface.pull(&products), surface.torque(&products)]
    }

    /// What a law follows from beside slip and load, over a usual log; none where that is more than one quantity.
    fn beside(law: &Law) -> Option<Option<(Circumstance, Beside)>> {
        let values = |from: f64, to: f64, nodes, discrete| Beside {
            range: (from, to),
            nodes,
            discrete,
        };
        match law.beside_slip_and_load()?[..] {
            [] => Some(None),
            [one] => {
                let over = match one {
                    Circumstance::SlipAngle => values(-0.2, 0.2, 5, false),
                    Circumstance::Path => values(0.0, 20.0, 5, false),
                    Circumstance::EarlierPasses => values(0.0, 2.0, 3, true),
                    Circumstance::Side => values(-1.0, 1.0, 2, true),
                    Circumstance::Speed => values(0.3, 0.8, 5, false),
                };
                Some(Some((one, over)))
            }
            _ => None,
        }
    }

    /// How wrong a surface of a law with these parameters is, as it says and at most, as a share of load and of load times radius.
    fn error_of(law: &Law, p: &[f64], range: MapRange, size: (usize, usize)) -> (f64, f64) {
        const RADIUS: f64 = 0.254;
        let beside = beside(law).unwrap();
        let nodes = SurfaceNodes::new(range, size.0, size.1);
        let nodes = beside.map_or(nodes, |(_, beside)| nodes.beside(beside));
        let of = |slip: f64, load: f64, value: f64| {
            let mut at = Contact::new(slip, load, RADIUS, 0.15);
            if let Some((circumstance, _)) = beside {
                circumstance.tell(&mut at, value);
            }
            let f = law.forces(p, &at).unwrap();
            [f.drawbar_pull, f.resistive_torque]
        };
        let eight = |slip: Lanes, load: Lanes, beside: Lanes| -> [Lanes; 2] {
            let each = (0..8).map(|k| of(slip.lane(k), load.lane(k), beside.lane(k)));
            let each: Vec<[f64; 2]> = each.collect();
            [0, 1].map(|k| Lanes::gather(each.iter().map(|f| f[k])))
        };
        let all = |at: &SurfaceContacts| eight(at.slip, at.load, at.beside);
        let surface = ForceSurface::through(nodes, &at_groups(&nodes, eight), RADIUS);
        let between: Vec<[Lanes; 2]> = nodes.between().map(|at| all(&at)).collect();
        let estimate = surface.error(&between, RADIUS);
        let mut worst: f64 = 0.0;
        for k in 0..12 {
            let (slip, load) = inside(range, k);
            let value = |lane: usize| match beside {
                Some((_, b)) if b.discrete => b.values().nth(lane % b.nodes).unwrap(),
                Some((_, b)) => b.range.0 + (b.range.1 - b.range.0) * (lane as f64 * 0.57).fract(),
                None => 0.0,
            };
            let beside = Lanes::gather((0..8).map(value));
            let at = SurfaceContacts { slip, load, beside };
            let (found, truth) = (given(&surface, &at), all(&at));
            for (k, arm) in [(0, 1.0), (1, RADIUS)] {
                let share = (found[k] - truth[k]) / (load * arm);
                worst = worst.max(share.max_lane()).max(-share.min_lane());
            }
        }
        (estimate, worst)
    }

    /// A law by slip and load, with each effect that is so too, at half a prior sd: where it says that it is within 5e-5 it is
    /// within 1e-4, and it says so of the law and of most effects on it.
    #[test]
    fn what_it_says_of_its_error_holds() {
        let registry = Registry::builtin().with_forms();
        let plain = registry.law("wong-reece").unwrap();
        let soils = ["dry_sand", "upland_sandy_loam", "lean_clay_22"];
        let cases = [
            (RANGE, (10, 4)),
            (BRAKED, (8, 4)),
            (DEEPER, (16, 4)),
            (DEEPEST, (24, 4)),
        ];
        for (range, size) in cases {
            let (mut all, mut within) = (0, 0);
            for id in soils {
                let soil = catalogue::find(id)
                    .unwrap()
                    .parameters(plain.model())
                    .unwrap();
                let mut laws = vec![(plain.clone(), soil.clone())];
                for effect in registry.effects() {
                    let e = effect
                        .params()
                        .iter()
                        .map(|p| (0.5 * p.prior_sd).clamp(p.min, p.max));
                    let p: Vec<f64> = soil.iter().copied().chain(e).collect();
                    if let Ok(law) = plain.with_effects([std::sync::Arc::clone(effect)])
                        && beside(&law).is_some()
                    {
                        laws.push((law, p));
                    }
                }
                for (law, p) in &laws {
                    let (estimate, worst) = error_of(law, p, range, size);
                    all += 1;
                    if estimate <= 5e-5 {
                        within += 1;
                        assert!(worst <= 1e-4, "{id} {law:?}: {worst} for {estimate}");
                    }
                }
                let (estimate, _) = error_of(&laws[0].0, &laws[0].1, range, size);
                assert!(estimate <= 5e-5, "{id}: {estimate}");
            }
            assert!(all > 30 && 4 * within > 3 * all, "{within} of {all}");
        }
    }

    /// A bend inside the range is told.
    #[test]
    fn a_bend_is_no_polynomial() {
        for bend_in_slip in [true, false] {
            let of = |slip: Lanes, load: Lanes, _: Lanes| {
                let bent = if bend_in_slip {
                    (slip - 0.3).abs()
                } else {
                    (load / 250.0 - 1.0).abs()
                };
                [bent * load * 0.01, load * 0.05]
            };
            let nodes = SurfaceNodes::new(RANGE, 10, 4);
            let surface = ForceSurface::through(nodes, &at_groups(&nodes, of), 0.25);
            let between = nodes.between().map(|at| of(at.slip, at.load, at.beside));
            let error = surface.error(&between.collect::<Vec<_>>(), 0.25);
            assert!(error > 2e-5, "{bend_in_slip} {error}");
        }
    }
}
