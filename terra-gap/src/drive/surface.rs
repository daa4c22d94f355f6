//! Forces of hundreds of contacts out of a few dozen: a law that follows from slip, load and at most one quantity more is asked at
//! the nodes of a polynomial on either side of zero slip, and the polynomial at the contacts.
//!
//! It stands for the law only where it is as good as that: where the law has an answer at all nodes, and between them the same one.

use std::borrow::Cow;
use std::ops::Range;

use terra_model::{
    Abreast, Beside, Circumstance, Contact, ForceSurface, Lanes, Law, MapRange, Real, Root,
    SurfaceContacts, SurfaceNodes, Vector, Vehicle,
};

use super::abreast::{Group, Kind, Last};
use super::frame::Frame;
use super::stance::{Stance, altered};
use super::{DrivePredictor, Entries, Given, Ground, NODES, OnWheel};
use crate::abreast::in_groups;
use crate::error::GapError;

/// Nodes in slip of driven and of braked wheels: where so many are not enough, the next number. The force of a braked wheel has a
/// weak bend where all of its contact slides forwards.
const SLIPS: [&[usize]; 2] = [&[10, 16], &[8, 12, 16, 24]];
/// Nodes in load.
const LOADS: usize = 4;
/// Nodes in what is beside them, and most of them where it has no other values.
const BESIDE: (usize, usize) = (5, 3);
/// Most nodes on a side, and contacts between them.
const MOST: usize = 24 * (LOADS * BESIDE.0 + 1);
/// Contacts for each node from which a surface is worth its nodes.
const WORTH: usize = 2;
/// Largest error, as a share of the load and of load times radius, of driven wheels and of braked ones: a thirtieth at most of what
/// the torque of a usual window is known to, and about what the law that fits ask is off itself (1e-5 and 1e-4).
const WITHIN: [f64; 2] = [2e-5, 5e-5];
/// Least width of a surface in slip, in the logarithm of load, and in what is beside them.
const NARROW: f64 = 1e-3;

/// What tells nodes from others: from where to where they lie in slip, load and what is beside them, and how many there are; then
/// which of the numbers of nodes in slip was enough, or that none was: it is not tried again.
type Extent = [f64; 8];
const EXTENT: usize = 8;
/// Place of the last.
const RUNG: usize = EXTENT - 1;

/// Places in a memory: those of entry angles at nodes and of their extent, on both sides, behind those of the contacts of so many
/// windows.
pub(super) fn places(windows: usize) -> Range<usize> {
    let start = windows * NODES * 4;
    start..start + 2 * (MOST + EXTENT)
}

/// Place of an entry angle at a node, and behind these of the extent.
fn node(windows: usize, side: usize, number: usize) -> usize {
    places(windows).start + side * (MOST + EXTENT) + number
}

/// A contact's slip and load with what is beside them, and its wheel's radius and width.
#[derive(Clone, Copy, Default)]
pub(super) struct Place {
    slip: f64,
    load: f64,
    beside: f64,
    wheel: [f64; 2],
}

impl Place {
    /// Of the contact in a lane.
    pub(super) fn of(at: &Contact<Lanes>, beside: Option<Circumstance>, lane: usize) -> Self {
        Place {
            slip: at.slip.lane(lane),
            load: at.normal_load.lane(lane),
            beside: beside.map_or(0.0, |beside| beside.told_by(at).lane(lane)),
            wheel: [at.radius, at.width].map(|w| w.lane(lane)),
        }
    }
}

/// Contacts on one side of zero slip.
#[derive(Clone, Copy, Debug)]
struct Side {
    range: MapRange,
    beside: Option<Beside>,
    count: usize,
}

/// What surfaces have to stand for: all contacts of one wheel on either side of zero slip.
#[derive(Clone, Debug)]
pub(super) struct Covers {
    sides: [Option<Side>; 2],
    wheel: [f64; 2],
    beside: Option<Circumstance>,
}

impl Covers {
    /// Those of windows under a law; none where it follows from more, or they stand in no frame and it follows from anything beside
    /// slip and load.
    fn under<'f, T: Abreast>(
        predictor: &DrivePredictor,
        law: &Law,
        p: &[T],
        indices: &[usize],
        frame: Option<&'f Frame>,
    ) -> Option<Cow<'f, Covers>> {
        let beside = law.beside_slip_and_load()?;
        // Each log may have a soil of its own.
        if beside.len() > 1 || predictor.soils > 1 {
            return None;
        }
        let beside = beside.first().copied();
        match frame {
            Some(frame) => frame.covers(beside).map(Cow::Borrowed),
            None if beside.is_some() => None,
            None => {
                let contacts = contacts(predictor, law, p, indices).ok()?;
                Covers::of(&contacts, None).map(Cow::Owned)
            }
        }
    }

    /// Nodes on a side, few and then more, as long as they are fewer than its contacts by far.
    fn nodes(&self, side: usize) -> impl Iterator<Item = (usize, SurfaceNodes)> {
        let covered = self.sides[side];
        let of = move |&slips: &usize| {
            let Side {
                range,
                beside,
                count,
            } = covered?;
            let nodes = SurfaceNodes::new(range, slips, LOADS);
            let nodes = beside.map_or(nodes, |beside| nodes.beside(beside));
            (count >= WORTH * nodes.len()).then_some(nodes)
        };
        SLIPS[side].iter().map_while(of).enumerate()
    }

    /// None where wheels differ, or a contact has no numbers.
    pub(super) fn of(contacts: &[Place], beside: Option<Circumstance>) -> Option<Self> {
        let wheel = contacts.first()?.wheel;
        let alike = |c: &Place| {
            c.wheel == wheel && c.slip.is_finite() && c.load > 0.0 && c.beside.is_finite()
        };
        let side = |side: usize| {
            let here = |c: &&Place| (c.slip < 0.0) == (side == 1);
            let here: Vec<&Place> = contacts.iter().filter(here).collect();
            if here.is_empty() {
                return None;
            }
            let beside = match beside {
                Some(circumstance) => Some(beside_them(&here, circumstance)?),
                None => None,
            };
            Some(Side {
                range: covering(&here),
                beside,
                count: here.len(),
            })
        };
        contacts.iter().all(alike).then(|| Covers {
            sides: [side(0), side(1)],
            wheel,
            beside,
        })
    }
}

/// Surfaces of driven and of braked wheels, where they are worth it.
pub(super) struct Surfaces<T> {
    sides: [Option<ForceSurface<T>>; 2],
    beside: Option<Circumstance>,
    /// What they covered at the last evaluation.
    before: [Extent; 2],
}

impl<T> Surfaces<T> {
    /// Whether there is one.
    pub(super) fn any(&self) -> bool {
        self.sides.iter().any(Option::is_some)
    }

    /// Whether there was one at the last evaluation.
    pub(super) fn stood_before(&self) -> bool {
        self.before.iter().any(|before| before[3] > 0.0)
    }
}

impl<T: Abreast> Surfaces<T> {
    /// Those that stand for the contacts of some windows, which stand as in a frame where there is one.
    pub(super) fn of(
        predictor: &DrivePredictor,
        law: &Law,
        p: &[T],
        indices: &[usize],
        frame: Option<&Frame>,
        last: &Last<'_>,
    ) -> Self {
        let (memory, windows) = (last.memory, predictor.windows.len());
        let before = [0, 1].map(|side| {
            let end = |k| memory.get(node(windows, side, MOST + k));
            std::array::from_fn(|k| end(k).unwrap_or_default())
        });
        let mut out = Surfaces {
            sides: [const { None }; 2],
            beside: None,
            before,
        };
        let Some(&first) = indices.first() else {
            return out;
        };
        let covers = Covers::under(predictor, law, p, indices, frame);
        let pitch = predictor.windows[first].pitch;
        let vehicle = altered(&predictor.vehicle, law, p, T::from(pitch));
        for (side, before) in before.into_iter().enumerate() {
            let mut extent = [0.0; EXTENT];
            extent[RUNG] = before[RUNG];
            if let Some(covers) = covers.as_deref() {
                out.beside = covers.beside;
                for (rung, nodes) in covers.nodes(side).skip(before[RUNG] as usize) {
                    extent[RUNG] = rung as f64;
                    let here = extent_of(&nodes, rung);
                    let sought = Sought {
                        windows,
                        law,
                        p,
                        vehicle: &vehicle,
                        covers,
                        last,
                        known: last.here && before == here,
                        side,
                        nodes,
                    };
                    // Where the law has no answer, more nodes have none either.
                    let Some((surface, error)) = sought.surface() else {
                        break;
                    };
                    if error <= WITHIN[side] {
                        out.sides[side] = Some(surface);
                        extent = here;
                        break;
                    }
                    extent[RUNG] += 1.0;
                }
            }
            for (k, end) in extent.into_iter().enumerate() {
                memory.keep(node(windows, side, MOST + k), end);
            }
        }
        out
    }

    /// What the ground gives eight wheels, where surfaces over slip and load stand for all of them.
    pub(super) fn forces(&self, slip: &T, load: &T) -> Option<OnWheel<T>> {
        let zero = Lanes::zero();
        if self.beside.is_some() {
            return None;
        }
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

    /// Whether they stand for wheels on these sides of zero slip.
    pub(super) fn stand_for(&self, sides: [bool; 2]) -> bool {
        let mut both = sides.into_iter().zip(&self.sides);
        both.all(|(asked, surface)| !asked || surface.is_some())
    }

    /// What the ground gives eight vehicles, where surfaces stand for all of their wheels.
    pub(super) fn ground(&self, stance: &Stance<Lanes>, given: &Given<Lanes>) -> Option<Ground<T>> {
        let (zero, one) = (Lanes::zero(), Lanes::one());
        let half_track = stance.vehicle.track * 0.5;
        let mut ground = Ground::none();
        for (side, surface) in self.sides.iter().enumerate() {
            let here = stance.slip.map(|slip| match side {
                0 => slip.select_lt(zero, zero, one),
                _ => slip.select_lt(zero, one, zero),
            });
            if !here.iter().any(|here| here.max_lane() > 0.0) {
                continue;
            }
            let surface = surface.as_ref()?;
            let nodes = surface.nodes();
            let inside = Lanes::from(nodes.range().slip.0);
            // Sums over wheels of what each coefficient weighs.
            let none = || vec![zero; nodes.len()];
            let (mut along, mut turning, mut one_wheel) = (none(), none(), none());
            for (q, here) in here.into_iter().enumerate() {
                if here.max_lane() == 0.0 {
                    continue;
                }
                let factor = stance.direction[q] * here * stance.load[q];
                let arm = if q.is_multiple_of(2) {
                    -half_track
                } else {
                    half_track
                };
                let beside = self.beside.map_or(zero, |beside| {
                    beside.told_by(&stance.contact::<Lanes>(q, given))
                });
                let place = nodes.place(&SurfaceContacts {
                    slip: (-here).select_lt(zero, stance.slip[q], inside),
                    load: stance.load[q],
                    beside,
                });
                nodes.products(&place, factor, &mut one_wheel);
                for (sum, product) in along.iter_mut().zip(&one_wheel) {
                    *sum += *product;
                }
                for (sum, product) in turning.iter_mut().zip(&one_wheel) {
                    *sum = product.mul_add(arm, *sum);
                }
                ground.torque[q] += surface.torque(&one_wheel);
            }
            ground.force += surface.pull(&along);
            ground.moment += surface.pull(&turning);
        }
        Some(ground)
    }
}

/// A surface that is looked for.
struct Sought<'a, T> {
    windows: usize,
    law: &'a Law,
    p: &'a [T],
    vehicle: &'a Vehicle<T>,
    covers: &'a Covers,
    last: &'a Last<'a>,
    /// Whether the same nodes were asked at these very parameters.
    known: bool,
    side: usize,
    nodes: SurfaceNodes,
}

impl<T: Abreast> Sought<'_, T> {
    /// Together with how far it is from the law between the nodes; none where that has no answer somewhere.
    fn surface(&self) -> Option<(ForceSurface<T>, f64)> {
        let Sought { nodes, covers, .. } = *self;
        let wheel = [self.vehicle.wheel_radius, self.vehicle.wheel_width];
        let of_group = |group| self.forces(self.p, wheel, group, &nodes.group(group));
        let forces: Option<Vec<[T; 2]>> = (0..nodes.groups()).map(of_group).collect();
        let surface = ForceSurface::through(nodes, &forces?, covers.wheel[0]);
        let still: Vec<Lanes> = self.p.iter().map(|p| p.primal()).collect();
        let wheel = covers.wheel.map(Lanes::from);
        let between = nodes.between().enumerate();
        let between = between.map(|(k, at)| self.forces(&still, wheel, nodes.groups() + k, &at));
        let between: Vec<[Lanes; 2]> = between.collect::<Option<_>>()?;
        let error = surface.error(&between, covers.wheel[0]);
        Some((surface, error))
    }

    /// Pull and torque of eight contacts, found from their entry angles a little elsewhere.
    fn forces<U: Abreast>(
        &self,
        p: &[U],
        wheel: [U; 2],
        group: usize,
        at: &SurfaceContacts,
    ) -> Option<[U; 2]> {
        let memory = self.last.memory;
        let place = |lane: usize| node(self.windows, self.side, group * Lanes::WIDTH + lane);
        let known: Option<Vec<f64>> = (0..Lanes::WIDTH)
            .map(|lane| memory.get(place(lane)))
            .collect();
        let mut near = Entries {
            of: [known.map(|entries| Lanes::gather(entries.into_iter()))],
            here: self.known,
        };
        let [radius, width] = wheel;
        let (slip, load) = (U::from_primal(at.slip), U::from_primal(at.load));
        let mut contact = Contact::new(slip, load, radius, width);
        if let Some(beside) = self.covers.beside {
            beside.tell(&mut contact, U::from_primal(at.beside));
        }
        let forces = near.forces(self.law, p, 0, contact).ok()?;
        if let [Some(entries)] = near.of {
            for lane in 0..Lanes::WIDTH {
                memory.keep(place(lane), entries.lane(lane));
            }
        }
        Some([forces.pull, forces.torque])
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
        let group = Group::of(predictor, windows);
        let mut places = vec![vec![]; group.len()];
        for time in 0..group.times() {
            let stance = group.stance(predictor, law, &p, time);
            stance.turns_with_its_motion()?;
            for q in 0..4 {
                let at: Contact<Lanes> = stance.contact(q, &group.given);
                for (lane, places) in places.iter_mut().enumerate() {
                    places.push(Place::of(&at, None, lane));
                }
            }
        }
        Ok(places)
    };
    let alone = |i| Ok(together(&[i])?.concat());
    Ok(in_groups(indices, kind, 1, together, alone)?.concat())
}

/// What a surface has to cover.
fn covering(contacts: &[&Place]) -> MapRange {
    let (low, high) = ends_of(contacts, |c| c.slip);
    // Wider away from zero slip.
    let slip = if high - low >= NARROW {
        (low, high)
    } else if low < 0.0 {
        (high - NARROW, high)
    } else {
        (low, low + NARROW)
    };
    let (low, high) = ends_of(contacts, |c| c.load);
    MapRange {
        slip,
        normal_load: (low, high.max(low * (1.0 + NARROW))),
    }
}

/// And beside slip and load; none where so few nodes do not meet a quantity that counts or tells left from right.
fn beside_them(contacts: &[&Place], circumstance: Circumstance) -> Option<Beside> {
    let range = ends_of(contacts, |c| c.beside);
    match circumstance {
        // A force sideways comes of it.
        Circumstance::SlipAngle => None,
        Circumstance::Path | Circumstance::Speed => {
            let (low, high) = range;
            Some(Beside {
                range: (low, high.max(low + NARROW)),
                nodes: BESIDE.0,
                discrete: false,
            })
        }
        Circumstance::EarlierPasses | Circumstance::Side => (2..=BESIDE.1).find_map(|nodes| {
            let (low, high) = range;
            let beside = Beside {
                range: if low < high { range } else { (low, low + 1.0) },
                nodes,
                discrete: true,
            };
            let met = |c: &&Place| beside.values().any(|v| (v - c.beside).abs() < 1e-9);
            contacts.iter().all(met).then_some(beside)
        }),
    }
}

fn ends_of(contacts: &[&Place], of: impl Fn(&Place) -> f64) -> (f64, f64) {
    let values = || contacts.iter().map(|c| of(c));
    (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    )
}

fn extent_of(nodes: &SurfaceNodes, rung: usize) -> Extent {
    let MapRange { slip, normal_load } = nodes.range();
    let (low, high) = nodes.range_beside().unwrap_or_default();
    let (count, rung) = (nodes.len() as f64, rung as f64);
    let (from, to) = normal_load;
    [slip.0, slip.1, from, to, low, high, count, rung]
}
