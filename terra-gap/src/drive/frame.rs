//! Windows as they stand under every law that leaves vehicle, ground speed and yaw rate as the log gives them: found once, eight side by side,
//! for all the evaluations of many fits.
//!
//! Readings are then sums over the coefficients of a force surface, with weights that no law changes.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use terra_model::{Abreast, Circumstance, Contact, Lanes, Law, Real, Root, Vector};

use super::abreast::{Group, Kind, Last, readings};
use super::stance::{Factor, Stance, is_left};
use super::surface::{Covers, Place, Surfaces};
use super::{DrivePredictor, Given, VALUES};
use crate::error::GapError;
use crate::parallel::for_each;

/// Packs that are kept at most: a quarter of an hour's windows, several times over.
const KEPT: usize = 4096;

/// Up to eight windows that have as many times each.
struct Pack {
    /// Their places among the windows that were asked for, and which they are.
    places: Vec<usize>,
    windows: Vec<usize>,
    given: Given<Lanes>,
    measured: [Lanes; VALUES],
    stances: Vec<Stance<Lanes>>,
    /// Whether any wheel is driven, and braked.
    sides: [bool; 2],
}

/// All windows of an evaluation.
pub(super) struct Frame {
    packs: Vec<Pack>,
    /// What surfaces have to cover, by what is beside slip and load.
    covers: [OnceLock<Option<Covers>>; 1 + Circumstance::ALL.len()],
}

impl Frame {
    /// None where a wheel turns against its motion.
    fn of(predictor: &DrivePredictor, indices: &[usize]) -> Option<Self> {
        let mut sorted: Vec<(Kind, usize)> = (indices.iter().enumerate())
            .map(|(place, &i)| (Kind::of(predictor, &predictor.windows[i]), place))
            .collect();
        sorted.sort_by_key(|(kind, place)| (kind.side_by_side(), kind.order(), *place));
        let mut packs = vec![];
        for alike in sorted.chunk_by(|a, b| a.0.side_by_side() == b.0.side_by_side()) {
            for members in alike.chunks(Lanes::WIDTH) {
                let places: Vec<usize> = members.iter().map(|(_, place)| *place).collect();
                let windows: Vec<usize> = places.iter().map(|&place| indices[place]).collect();
                let group = Group::of(predictor, &windows);
                let stances = (0..group.times()).map(|time| group.left(predictor, time));
                let stances: Vec<_> = stances.collect();
                let turns = |s: &Stance<_>| s.turns_with_its_motion().is_ok();
                if !stances.iter().all(turns) {
                    return None;
                }
                let slips = || stances.iter().flat_map(|s| &s.slip);
                let zero = Lanes::zero();
                packs.push(Pack {
                    measured: std::array::from_fn(|k| group.raw[k]),
                    sides: [
                        slips().any(|slip| slip.max_lane() >= 0.0),
                        slips().any(|slip| slip.any_lt(zero)),
                    ],
                    given: group.given,
                    places,
                    stances,
                    windows,
                });
            }
        }
        Some(Frame {
            packs,
            covers: Default::default(),
        })
    }

    /// What surfaces have to cover whose law follows from so much beside slip and load; none where they cannot.
    pub(super) fn covers(&self, beside: Option<Circumstance>) -> Option<&Covers> {
        let number = |c| Circumstance::ALL.iter().position(|one| *one == c);
        let place = beside.and_then(number).map_or(0, |k| k + 1);
        let covers = self.covers.get(place)?;
        let found = || Covers::of(&self.contacts(beside), beside);
        covers.get_or_init(found).as_ref()
    }

    fn contacts(&self, beside: Option<Circumstance>) -> Vec<Place> {
        let mut out = vec![];
        for pack in &self.packs {
            for stance in &pack.stances {
                for q in 0..4 {
                    let at: Contact<Lanes> = stance.contact(q, &pack.given);
                    let lanes = 0..pack.places.len();
                    out.extend(lanes.map(|lane| Place::of(&at, beside, lane)));
                }
            }
        }
        out
    }

    /// What `of_lane` makes of the residuals of windows, each at its place; none of those beside one that has no answer.
    pub(super) fn residuals<T: Abreast, A: Send + Sync>(
        &self,
        predictor: &DrivePredictor,
        law: &Law,
        p: &[T],
        surfaces: &Surfaces<T>,
        last: &Last<'_>,
        of_lane: impl Fn(&T, usize) -> A + Sync,
    ) -> Vec<(usize, Vec<A>)>
    where
        Lanes: Factor<T>,
    {
        let of_pack = |k: usize| {
            let pack = &self.packs[k];
            let Ok(predicted) = pack.readings(law, p, surfaces, last) else {
                return vec![];
            };
            let residual: [T; VALUES] = std::array::from_fn(|k| {
                let measured = T::from_primal(pack.measured[k]);
                measured - predicted[k]
            });
            let each = pack.places.iter().zip(&pack.windows).enumerate();
            let each = each.map(|(lane, (&place, &window))| {
                let measured = predictor.windows[window].measured.iter();
                let told = measured.map(|&k| of_lane(&residual[k], lane));
                (place, told.collect())
            });
            each.collect()
        };
        let found = for_each(self.packs.len(), of_pack);
        found.into_iter().flatten().collect()
    }
}

impl Pack {
    /// # Errors
    /// Where one of its windows has no answer.
    fn readings<T: Abreast>(
        &self,
        law: &Law,
        p: &[T],
        surfaces: &Surfaces<T>,
        last: &Last<'_>,
    ) -> Result<[T; VALUES], GapError>
    where
        Lanes: Factor<T>,
    {
        if let Some(found) = self.by_surfaces(law, p, surfaces) {
            return Ok(found);
        }
        let stance = |time: usize| &self.stances[time];
        let times = self.stances.len();
        readings(
            (law, p),
            &self.given,
            times,
            stance,
            &self.windows,
            last,
            surfaces,
        )
    }

    /// Where surfaces stand for all of their wheels.
    fn by_surfaces<T: Abreast>(
        &self,
        law: &Law,
        p: &[T],
        surfaces: &Surfaces<T>,
    ) -> Option<[T; VALUES]>
    where
        Lanes: Factor<T>,
    {
        if !surfaces.stand_for(self.sides) {
            return None;
        }
        let mut mean = [T::zero(); VALUES];
        let share = Lanes::from(1.0 / self.stances.len() as f64);
        for stance in &self.stances {
            let ground = surfaces.ground(stance, &self.given)?;
            DrivePredictor::add_told(&mut mean, share, (law, p), &self.given, stance, ground);
        }
        Some(mean)
    }
}

/// Frames of the sets of windows that were asked for. A copy may be of other windows: it begins with none.
#[derive(Debug, Default)]
pub(super) struct Frames(Mutex<Vec<Kept>>);

/// One of them, with the windows it is of.
type Kept = (Vec<usize>, Option<Arc<Frame>>);

impl Clone for Frames {
    fn clone(&self) -> Self {
        Frames::default()
    }
}

impl std::fmt::Debug for Frame {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Frame")
            .field("packs", &self.packs.len())
            .finish()
    }
}

impl DrivePredictor {
    /// How some windows stand under a law; none where it moves them.
    pub(super) fn frame(&self, law: &Law, indices: &[usize]) -> Option<Arc<Frame>> {
        // Each log may have a soil of its own.
        if self.soils > 1 || !is_left(law) {
            return None;
        }
        let frames = || self.frames.0.lock().unwrap_or_else(PoisonError::into_inner);
        let of = |kept: &Kept| kept.0 == indices;
        if let Some((_, frame)) = frames().iter().find(|kept| of(kept)) {
            return frame.clone();
        }
        let frame = Frame::of(self, indices).map(Arc::new);
        let mut frames = frames();
        let packs = |frame: &Option<Arc<Frame>>| frame.as_ref().map_or(1, |f| f.packs.len());
        let held: usize = frames.iter().map(|(_, frame)| packs(frame)).sum();
        if held + packs(&frame) <= KEPT && !frames.iter().any(of) {
            frames.push((indices.to_vec(), frame.clone()));
        }
        frame
    }
}
