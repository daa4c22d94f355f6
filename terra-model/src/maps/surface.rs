//! Pull and torque of one soil and wheel as a polynomial in slip and load, with whatever derivatives its numbers carry: a few
//! dozen contacts stand for hundreds on the same side of zero slip, each at a tenth of a solve's cost.
//!
//! # Equation
//! D/W = Σ d_ij T_i(s) T_j(x), T/W likewise, with Chebyshev's polynomials in slip and in x = ln W, each scaled to \[-1, 1\]. The
//! coefficients are the discrete sums over Chebyshev's nodes.
//!
//! # Reference
//! L. N. Trefethen, *Approximation Theory and Approximation Practice*, SIAM 2013, chapters 3, 4 and 8.

use crate::lanes::{Abreast, Lanes, Vector};
use crate::maps::MapRange;
use crate::maps::chebyshev::chebyshev;
use crate::real::{Real, Root, is_plain};

/// Most nodes in a direction.
const MOST: usize = 12;
/// A share of the load that is nothing.
const NOTHING: f64 = 1e-7;

/// Where contacts are asked for that a surface goes through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceNodes {
    range: MapRange,
    slips: usize,
    loads: usize,
}

impl SurfaceNodes {
    /// So many in slip and in load (2 to 12) over a range that is not empty; slips may be negative.
    pub fn new(range: MapRange, slips: usize, loads: usize) -> Self {
        SurfaceNodes {
            range,
            slips: slips.clamp(2, MOST),
            loads: loads.clamp(2, MOST),
        }
    }

    /// What it covers.
    pub fn range(&self) -> MapRange {
        self.range
    }

    /// How many groups of eight.
    pub fn groups(&self) -> usize {
        (self.slips * self.loads).div_ceil(Lanes::WIDTH)
    }

    /// Slips and normal loads \[N\] of one group; lanes that are left over repeat the last node.
    pub fn group(&self, number: usize) -> (Lanes, Lanes) {
        let last = self.slips * self.loads - 1;
        let node = |lane: usize| (number * Lanes::WIDTH + lane).min(last);
        let (low, high) = self.log_load();
        let slip = |lane| {
            self.range
                .slip_at(chebyshev(node(lane) / self.loads, self.slips))
        };
        let load = |lane| {
            let x = chebyshev(node(lane) % self.loads, self.loads);
            (low + 0.5 * (x + 1.0) * (high - low)).exp()
        };
        let lanes = 0..Lanes::WIDTH;
        (
            Lanes::gather(lanes.clone().map(slip)),
            Lanes::gather(lanes.map(load)),
        )
    }

    /// Slips and normal loads \[N\] of eight contacts on the edges and in the midst, as far from the nodes as may be.
    pub fn between(&self) -> (Lanes, Lanes) {
        let extreme = |k: usize, n: usize| -(std::f64::consts::PI * k as f64 / n as f64).cos();
        let (low, high) = self.log_load();
        let slip = |lane: usize| {
            let k = (2 * lane * self.slips + Lanes::WIDTH - 1) / (2 * (Lanes::WIDTH - 1));
            self.range.slip_at(extreme(k, self.slips))
        };
        let load = |lane: usize| {
            let x = extreme(3 * lane % (self.loads + 1), self.loads);
            (low + 0.5 * (x + 1.0) * (high - low)).exp()
        };
        let lanes = 0..Lanes::WIDTH;
        (
            Lanes::gather(lanes.clone().map(slip)),
            Lanes::gather(lanes.map(load)),
        )
    }

    fn log_load(&self) -> (f64, f64) {
        let (low, high) = self.range.normal_load;
        (low.ln(), high.ln())
    }
}

/// Pull and torque over slip and load, eight contacts at a time.
#[derive(Clone, Debug)]
pub struct ForceSurface<T> {
    nodes: SurfaceNodes,
    terms: Vec<Term<T>>,
}

/// A product of two polynomials with its coefficients.
#[derive(Clone, Debug)]
struct Term<T> {
    slip: usize,
    load: usize,
    of: [T; 2],
}

impl<T: Abreast> ForceSurface<T> {
    /// Through D \[N\] and T \[N m\] of every group of nodes. Left out is what is nothing beside the load, or beside the load times
    /// `arm` \[m\].
    pub fn through(nodes: SurfaceNodes, forces: &[[T; 2]], arm: f64) -> Self {
        let SurfaceNodes { slips, loads, .. } = nodes;
        let over_load: Vec<[T; 2]> = forces
            .iter()
            .enumerate()
            .map(|(group, forces)| {
                let inverse = Lanes::one() / nodes.group(group).1;
                forces.map(|force| force.scaled(inverse))
            })
            .collect();
        let (by_slip, by_load) = (at_nodes(slips), at_nodes(loads));
        let mut terms = vec![];
        for (slip, by_slip) in by_slip.iter().enumerate() {
            for (load, by_load) in by_load.iter().enumerate() {
                let weight = |node: usize| {
                    let slip = by_slip.get(node / loads).copied().unwrap_or(0.0);
                    slip * by_load[node % loads]
                };
                let mut of = [T::zero(); 2];
                for (group, values) in over_load.iter().enumerate() {
                    let lanes = (0..Lanes::WIDTH).map(|lane| weight(group * Lanes::WIDTH + lane));
                    let weights = Lanes::gather(lanes);
                    for (sum, value) in of.iter_mut().zip(values) {
                        sum.add_scaled(value, weights);
                    }
                }
                let of = of.map(T::total_of_lanes);
                let [pull, torque] = of.map(|c| c.primal().lane(0).abs());
                // What is no number is kept.
                let size = pull.max(torque / arm);
                if size >= NOTHING || !size.is_finite() {
                    terms.push(Term { slip, load, of });
                }
            }
        }
        ForceSurface { nodes, terms }
    }

    /// How far it is at most from D \[N\] and T \[N m\] at the contacts [`SurfaceNodes::between`] nodes, as a share of load and of
    /// load times `arm` \[m\].
    pub fn error(&self, forces: &[Lanes; 2], arm: f64) -> f64 {
        let (slip, load) = self.nodes.between();
        let found = self.at(&T::from_primal(slip), &T::from_primal(load));
        let share = |k: usize, arm: f64| ((found[k].primal() - forces[k]) / (load * arm)).abs();
        let (pull, torque) = (share(0, 1.0), share(1, arm));
        if pull.is_finite() && torque.is_finite() {
            pull.max_lane().max(torque.max_lane())
        } else {
            f64::INFINITY
        }
    }

    /// Its nodes.
    pub fn nodes(&self) -> SurfaceNodes {
        self.nodes
    }

    /// D \[N\] and T \[N m\] at a slip \[1\] and a normal load \[N\], with the slopes that coefficients, slip and load have. Only
    /// within the range of its nodes: beyond it the polynomial goes on, and means nothing.
    pub fn at(&self, slip: &T, load: &T) -> [T; 2] {
        let nodes = &self.nodes;
        let (here, weight) = (slip.primal(), load.primal());
        let (low, high) = nodes.range.slip;
        let per_slip = 2.0 / (high - low);
        let s = (here - low) * per_slip - 1.0;
        let (low, high) = nodes.log_load();
        let per_log = 2.0 / (high - low);
        let x = (weight.ln() - low) * per_log - 1.0;
        let (of_slip, of_load) = (polynomials(s), polynomials(x));
        let moves = |x: &T| !is_plain::<T>() && x.varies();
        let mut sums = [T::zero(); 2];
        for term in &self.terms {
            let by = of_slip[term.slip] * of_load[term.load];
            for (sum, c) in sums.iter_mut().zip(&term.of) {
                sum.add_scaled(c, by);
            }
        }
        for (varies, x, of_slip, of_load, rate) in [
            (
                moves(slip),
                slip,
                slopes(s, &of_slip),
                of_load,
                Lanes::from(per_slip),
            ),
            (
                moves(load),
                load,
                of_slip,
                slopes(x, &of_load),
                Lanes::from(per_log) / weight,
            ),
        ] {
            if !varies {
                continue;
            }
            let mut by = [Lanes::zero(); 2];
            for term in &self.terms {
                let slope = of_slip[term.slip] * of_load[term.load] * rate;
                for (sum, c) in by.iter_mut().zip(&term.of) {
                    *sum = c.primal().mul_add(slope, *sum);
                }
            }
            let step = *x - T::from_primal(x.primal());
            for (sum, by) in sums.iter_mut().zip(by) {
                sum.add_scaled(&step, by);
            }
        }
        sums.map(|sum| sum * *load)
    }
}

/// Weight of each node's value in each coefficient.
fn at_nodes(n: usize) -> Vec<Vec<f64>> {
    let weight = |degree: usize| if degree == 0 { 1.0 } else { 2.0 } / n as f64;
    let of = |degree: usize| {
        let at = (0..n).map(|k| (degree as f64 * chebyshev(k, n).acos()).cos());
        at.map(|t| t * weight(degree)).collect()
    };
    (0..n).map(of).collect()
}

/// T_0(x), T_1(x), ...
fn polynomials(x: Lanes) -> [Lanes; MOST] {
    let mut out = [Lanes::one(); MOST];
    let (mut before, mut now) = (x, Lanes::one());
    for value in &mut out {
        *value = now;
        (before, now) = (now, x * now * 2.0 - before);
    }
    out
}

/// Their slopes.
fn slopes(x: Lanes, polynomials: &[Lanes; MOST]) -> [Lanes; MOST] {
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
    use crate::{Contact, ForceLaw, LaneDual, Law, Registry, catalogue};

    const RANGE: MapRange = MapRange {
        slip: (0.0, 0.8),
        normal_load: (180.0, 350.0),
    };
    const BRAKED: MapRange = MapRange {
        slip: (-0.06, 0.0),
        normal_load: (180.0, 350.0),
    };

    /// Pull and torque of a function at groups of nodes.
    fn at_groups<T: Abreast>(nodes: &SurfaceNodes, of: impl Fn(T, T) -> [T; 2]) -> Vec<[T; 2]> {
        let group = |k| {
            let (slip, load) = nodes.group(k);
            of(T::from_primal(slip), T::from_primal(load))
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
        let values = at_groups(&nodes, |slip, load| of(a, slip, load));
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

    /// Forces of a law with these parameters, and how wrong a surface of them is as a share of load and of load times radius.
    fn error_of(law: &Law, p: &[f64], range: MapRange, size: (usize, usize)) -> (f64, f64) {
        const RADIUS: f64 = 0.254;
        let nodes = SurfaceNodes::new(range, size.0, size.1);
        let of = |slip: f64, load: f64| {
            let f = law
                .forces(p, &Contact::new(slip, load, RADIUS, 0.15))
                .unwrap();
            [f.drawbar_pull, f.resistive_torque]
        };
        let eight = |slip: Lanes, load: Lanes| -> [Lanes; 2] {
            let each: Vec<[f64; 2]> = (0..8).map(|k| of(slip.lane(k), load.lane(k))).collect();
            [0, 1].map(|k| Lanes::gather(each.iter().map(|f| f[k])))
        };
        let surface = ForceSurface::through(nodes, &at_groups(&nodes, eight), RADIUS);
        let (slip, load) = nodes.between();
        let estimate = surface.error(&eight(slip, load), RADIUS);
        let mut worst: f64 = 0.0;
        for k in 0..12 {
            let (slip, load) = inside(range, k);
            let (found, truth) = (surface.at(&slip, &load), eight(slip, load));
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
        for (range, size) in [(RANGE, (10, 4)), (BRAKED, (8, 4))] {
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
                        && law.is_by_slip_and_load()
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
            let of = |slip: Lanes, load: Lanes| {
                let bent = if bend_in_slip {
                    (slip - 0.3).abs()
                } else {
                    (load / 250.0 - 1.0).abs()
                };
                [bent * load * 0.01, load * 0.05]
            };
            let nodes = SurfaceNodes::new(RANGE, 10, 4);
            let surface = ForceSurface::through(nodes, &at_groups(&nodes, of), 0.25);
            let (slip, load) = nodes.between();
            let error = surface.error(&of(slip, load), 0.25);
            assert!(error > 2e-5, "{bend_in_slip} {error}");
        }
    }
}
