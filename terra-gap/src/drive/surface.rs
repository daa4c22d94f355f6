//! Forces of hundreds of contacts out of a few dozen: a law that follows from slip and load alone is asked at the nodes of a
//! polynomial on either side of zero slip, and the polynomial at the contacts.
//!
//! It stands for the law only where it is as good as that: where the law has an answer at all nodes, and between them the same one.

use std::ops::Range;

use terra_model::{
    Abreast, Contact, ForceSurface, Lanes, Law, MapRange, Real, Root, SurfaceNodes, Vector,
};

use super::abreast::{Group, Kind, Last};
use super::stance::{Stance, altered};
use super::{DrivePredictor, Entries, NODES, OnWheel};
use crate::abreast::in_groups;
use crate::error::GapError;

/// Nodes in slip and in load: of driven wheels, and of braked ones.
const SIZES: [(usize, usize); 2] = [(10, 4), (8, 4)];
/// Most nodes on a side, and eight contacts between them.
const MOST: usize = 48;
/// Contacts for each node from which a surface is worth its nodes.
const WORTH: usize = 2;
/// Largest error, as a share of the load and of load times radius, of driven wheels and of braked ones: a thirtieth at most of what
/// the torque of a usual window is known to, and about what the law that fits ask is off itself (1e-5 and 1e-4).
const WITHIN: [f64; 2] = [2e-5, 5e-5];
/// Least width of a surface in slip, and in the logarithm of load.
const NARROW: f64 = 1e-3;

/// Places in a memory: those of entry angles at nodes and of the four ends of what is covered, on both sides, behind those of the
/// contacts of so many windows.
pub(super) fn places(windows: usize) -> Range<usize> {
    let start = windows * NODES * 4;
    start..start + 2 * (MOST + 4)
}

/// Place of an entry angle at a node, and of the first end.
fn node(windows: usize, side: usize, number: usize) -> usize {
    places(windows).start + side * (MOST + 4) + number
}

/// Surfaces of driven and of braked wheels, where they are worth it.
pub(super) struct Surfaces<T> {
    sides: [Option<ForceSurface<T>>; 2],
    /// What they covered at the last evaluation.
    before: [Option<[f64; 4]>; 2],
}

impl<T> Surfaces<T> {
    /// Whether there is one.
    pub(super) fn any(&self) -> bool {
        self.sides.iter().any(Option::is_some)
    }

    /// Whether there was one at the last evaluation.
    pub(super) fn stood_before(&self) -> bool {
        self.before.iter().any(Option::is_some)
    }
}

/// A contact's slip and load, and its wheel's radius and width.
#[derive(Clone, Copy, Default)]
struct Place {
    slip: f64,
    load: f64,
    wheel: [f64; 2],
}

impl<T: Abreast> Surfaces<T> {
    /// Those that stand for the contacts of some windows.
    pub(super) fn of(
        predictor: &DrivePredictor,
        law: &Law,
        p: &[T],
        indices: &[usize],
        last: &Last<'_>,
    ) -> Self {
        let (memory, windows) = (last.memory, predictor.windows.len());
        let mut out = Surfaces {
            sides: [const { None }; 2],
            before: [0, 1].map(|side| {
                let end = |k| memory.get(node(windows, side, MOST + k));
                let ends = [end(0)?, end(1)?, end(2)?, end(3)?];
                (ends[3] > 0.0).then_some(ends)
            }),
        };
        // Each log may have a soil of its own.
        if law.is_by_slip_and_load()
            && predictor.soils < 2
            && let Ok(contacts) = contacts(predictor, law, p, indices)
        {
            out.find(predictor, law, p, indices, &contacts, last);
        }
        for (side, surface) in out.sides.iter().enumerate() {
            let covers = surface.as_ref().map(|s| ends(s.nodes().range()));
            for (k, end) in covers.unwrap_or_default().into_iter().enumerate() {
                memory.keep(node(windows, side, MOST + k), end);
            }
        }
        out
    }

    fn find(
        &mut self,
        predictor: &DrivePredictor,
        law: &Law,
        p: &[T],
        indices: &[usize],
        contacts: &[Place],
        last: &Last<'_>,
    ) {
        let Some(wheel) = contacts.first().map(|c| c.wheel) else {
            return;
        };
        let alike = |c: &Place| c.wheel == wheel && c.slip.is_finite() && c.load > 0.0;
        if !contacts.iter().all(alike) {
            return;
        }
        let windows = predictor.windows.len();
        let still: Vec<Lanes> = p.iter().map(|p| p.primal()).collect();
        let first = Group::of(predictor, &indices[..1], |_, x| T::from_primal(x));
        let vehicle = altered(&predictor.vehicle, law, p, first.given.pitch);
        for (side, (slips, loads)) in SIZES.into_iter().enumerate() {
            let here = |c: &&Place| (c.slip < 0.0) == (side == 1);
            let here: Vec<&Place> = contacts.iter().filter(here).collect();
            if here.len() < WORTH * slips * loads {
                continue;
            }
            let nodes = SurfaceNodes::new(covering(&here), slips, loads);
            let known = last.here && self.before[side] == Some(ends(nodes.range()));
            let place =
                |group: usize, lane: usize| node(windows, side, group * Lanes::WIDTH + lane);
            let near = |group| {
                let lanes = (0..Lanes::WIDTH).map(|lane| last.memory.get(place(group, lane)));
                Entries {
                    of: [lanes
                        .collect::<Option<Vec<f64>>>()
                        .map(|e| Lanes::gather(e.into_iter()))],
                    here: known,
                }
            };
            let keep = |group, entries: &Entries<Lanes, 1>| {
                for lane in 0..Lanes::WIDTH {
                    if let [Some(entry)] = entries.of {
                        last.memory.keep(place(group, lane), entry.lane(lane));
                    }
                }
            };
            let forces = (0..nodes.groups()).map(|group| {
                let (slip, load) = nodes.group(group);
                let mut near = near(group);
                let at = Contact::new(
                    T::from_primal(slip),
                    T::from_primal(load),
                    vehicle.wheel_radius,
                    vehicle.wheel_width,
                );
                let forces = near.forces(law, p, 0, at)?;
                keep(group, &near);
                Ok([forces.pull, forces.torque])
            });
            let between = || {
                let (slip, load) = nodes.between();
                let mut near = near(nodes.groups());
                let wheel = [vehicle.wheel_radius, vehicle.wheel_width].map(|w| w.primal());
                let at = Contact::new(slip, load, wheel[0], wheel[1]);
                let forces = near.forces(law, &still, 0, at)?;
                keep(nodes.groups(), &near);
                Ok::<_, GapError>([forces.pull, forces.torque])
            };
            let (Ok(forces), Ok(between)) =
                (forces.collect::<Result<Vec<_>, GapError>>(), between())
            else {
                continue;
            };
            let surface = ForceSurface::through(nodes, &forces, wheel[0]);
            if surface.error(&between, wheel[0]) <= WITHIN[side] {
                self.sides[side] = Some(surface);
            }
        }
    }

    /// What the ground gives eight wheels, where surfaces stand for all of them.
    pub(super) fn forces(&self, slip: &T, load: &T) -> Option<OnWheel<T>> {
        let zero = Lanes::zero();
        let of = |side: usize| self.sides[side].as_ref().map(|s| s.at(slip, load));
        let [pull, torque] = if !slip.primal().any_lt(zero) {
            of(0)?
        } else if (-slip.primal()).min_lane() > 0.0 {
            of(1)?
        } else {
            let (driven, braked) = (of(0)?, of(1)?);
            std::array::from_fn(|k| slip.select_lt(T::zero(), braked[k], driven[k]))
        };
        Some(OnWheel {
            pull,
            torque,
            aside: None,
        })
    }
}

/// All contacts of some windows.
fn contacts<T: Abreast>(
    predictor: &DrivePredictor,
    law: &Law,
    p: &[T],
    indices: &[usize],
) -> Result<Vec<Place>, GapError> {
    let p: Vec<Lanes> = p.iter().map(|p| p.primal()).collect();
    let kind = |i| Kind::of(predictor, &predictor.windows[i]);
    let together = |windows: &[usize]| {
        let group = Group::of(predictor, windows, |_, x| x);
        let mut places = vec![vec![]; group.len()];
        for stance in group.stances(predictor, law, &p) {
            let Stance {
                vehicle,
                slip,
                load,
                ..
            } = stance?;
            let wheel = [vehicle.wheel_radius, vehicle.wheel_width];
            for (lane, places) in places.iter_mut().enumerate() {
                places.extend((0..4).map(|q| Place {
                    slip: slip[q].lane(lane),
                    load: load[q].lane(lane),
                    wheel: wheel.map(|w| w.lane(lane)),
                }));
            }
        }
        Ok(places)
    };
    let alone = |i| Ok(together(&[i])?.concat());
    Ok(in_groups(indices, kind, 1, together, alone)?.concat())
}

/// What a surface has to cover.
fn covering(contacts: &[&Place]) -> MapRange {
    let over = |of: &dyn Fn(&Place) -> f64| {
        let values = || contacts.iter().map(|c| of(c));
        (
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
        )
    };
    let (low, high) = over(&|c| c.slip);
    // Wider away from zero slip.
    let slip = if high - low >= NARROW {
        (low, high)
    } else if low < 0.0 {
        (high - NARROW, high)
    } else {
        (low, low + NARROW)
    };
    let (low, high) = over(&|c| c.load);
    MapRange {
        slip,
        normal_load: (low, high.max(low * (1.0 + NARROW))),
    }
}

fn ends(range: MapRange) -> [f64; 4] {
    let MapRange { slip, normal_load } = range;
    [slip.0, slip.1, normal_load.0, normal_load.1]
}
