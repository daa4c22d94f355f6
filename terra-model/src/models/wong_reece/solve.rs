//! The entry angle that carries the load, and the integrals there with all their derivatives.
//!
//! The angle is iterated in the primal by a short rule, then by the rule whose result counts: one evaluation mostly. One
//! implicit step restores derivatives, and carries the integrals along by their slopes.

use std::cell::Cell;

use super::gradient::{Partials, SIDEWAYS, STRAIGHT, VARIABLES};
use super::kernel::{Integrator, Sums};
use super::wheel::{Integrals, Wheel};
use crate::contact::Contact;
use crate::error::ModelError;
use crate::real::{Real, Root, is_plain};
use crate::root::{Search, rises_to};

/// Relative step of the entry angle at which the short rule has done its part: the next one is of the size of its error.
const HANDOVER: f64 = 1e-3;
/// The same for a driven wheel where eight nodes count: Newton's next step leaves less than three nodes are off by.
const HANDOVER_QUICKLY: f64 = 2e-2;
/// The same for the rule that counts. The step that follows squares it.
const DRIVING: f64 = 3e-7;
/// The same where eight nodes count, which are right to 4e-8 themselves.
const DRIVING_QUICKLY: f64 = 1e-4;
/// A braked wheel's load has bends: where they show, what the last step squares is multiplied by more.
const BRAKING: f64 = 1e-8;
/// Largest difference of ln θ1 between two rules that mean the same root.
const SAME_ROOT: f64 = 0.02;
/// Step in ln θ1 that may be left at a place where a contact is said to balance in fits: one step leaves its square.
const AT_ONCE: f64 = 1e-4;
/// Nodes up to which a rule is of the default tier.
const QUICK: usize = 8;

/// The load carried at an entry angle \[N\].
pub(super) fn load<P: Root, const ORDER: usize>(wheel: &Wheel<P>, entry: P) -> P {
    let carried = if wheel.lateral.is_some() {
        wheel.integrals(entry).load
    } else {
        let integrator = Integrator::<P, ORDER>::new(wheel, wheel.stress());
        integrator.at(entry).load(entry).0
    };
    carried * wheel.radius * wheel.width
}

/// Where a search for ln θ1 begins.
#[derive(Clone, Copy)]
pub(super) enum Start<P> {
    /// At what the soil without shear stress would carry.
    Guess,
    /// At that of a nearby contact.
    From(P),
    /// At that of this very contact a little elsewhere, where it was the first that balances.
    Near(P),
    /// At that of this very contact.
    Here(P),
}

impl<P: Root> Start<P> {
    /// Near what a contact remembers.
    pub(super) fn of<T: Real<Primal = P>>(at: &Contact<T>) -> Self {
        let ln_entry = at.near.map(|entry| entry.primal().ln());
        match ln_entry {
            Some(ln_entry) if at.near_is_here => Start::Here(ln_entry),
            Some(ln_entry) => Start::Near(ln_entry),
            None => Start::Guess,
        }
    }
}

/// An entry angle and the sums there.
type Evaluated<P> = (P, Sums<<P as Root>::Nodes>);

/// Iterates in the primal with a rule of `FINE` nodes after one of `COARSE`.
///
/// `then` gets the entry angle, the integrals there, and the rule that gave them, which is too large to be handed on.
fn iterate<P: Root, const COARSE: usize, const FINE: usize, R>(
    primal: &Wheel<P>,
    load: P,
    slip: P,
    from: Start<P>,
    then: impl FnOnce(P, Integrals<P>, &Integrator<'_, P, FINE>) -> R,
) -> Result<R, ModelError> {
    let area = primal.radius * primal.width;
    let stress = primal.stress();
    let (handover, driving) = if const { FINE <= QUICK } {
        (HANDOVER_QUICKLY, DRIVING_QUICKLY)
    } else {
        (HANDOVER, DRIVING)
    };
    let mut search = Search {
        load,
        slip,
        rises_to: rises_to(slip, primal.rises_to()),
        tolerance: if primal.braking { HANDOVER } else { handover },
        feasible: false,
        for_fits: const { FINE < QUICK },
    };
    let guess = || {
        let ground = &primal.ground;
        ground
            .compaction_guess(load, primal.radius, primal.width)
            .ln()
    };
    let coarse = Integrator::<P, COARSE>::new(primal, stress);
    let times_area = |(w, slope): (P, P)| (w * area, slope * area);
    let roughly = |entry| times_area(coarse.roughly_at(entry).load(entry));
    let anew = |start| {
        let carried = |entry| times_area(coarse.at(entry).load(entry));
        (start, search.root(start, carried, roughly))
    };
    let (mut start, near) = match from {
        Start::Guess => anew(guess()),
        Start::From(ln_entry) => anew(ln_entry),
        Start::Near(last) | Start::Here(last) => match search.root_near(last, roughly) {
            Some(near) => (last, Ok(near)),
            None => anew(guess()),
        },
    };
    search.tolerance = if primal.braking { BRAKING } else { driving };
    // Whether there is an equilibrium is the longer rule's to say.
    if let Ok(near) = near {
        start = near.ln_angle + (load - near.load) / near.slope;
        search.feasible = true;
        if near.is_usual() {
            search.tolerance = driving;
        }
    }
    let fine = Integrator::<P, FINE>::new(primal, stress);
    let last: Cell<Option<Evaluated<P>>> = Cell::new(None);
    let carried = |entry| {
        let sums = fine.at(entry);
        let found = times_area(sums.load(entry));
        last.set(Some((entry, sums)));
        found
    };
    let mut found = search.root(start, carried, carried);
    // Where the soil is about to give way under a braked wheel, the rules may differ about whether it does.
    if let (true, Ok(near)) = (primal.braking, near) {
        let far = |found: P| P::from(SAME_ROOT).any_lt((found - near.ln_angle).abs());
        if found.as_ref().map_or(true, |found| far(found.ln_angle)) {
            search.feasible = false;
            search.tolerance = BRAKING;
            found = search.root(start, carried, carried);
        }
    }
    let found = found?;
    let (root, sums) = match last.take() {
        Some(last) if found.last => last,
        _ => {
            let root = found.ln_angle.exp();
            (root, fine.at(root))
        }
    };
    let (value, slopes) = sums.integrals(root);
    let step = (load / area - value.load) / slopes.load;
    let (root, integrals) = (root + root * step, value.moved(&slopes, step));
    Ok(then(root, integrals, &fine))
}

/// Solves in any scalar: one pass in the primal, and the partial derivatives there. `SUMS`: [`STRAIGHT`], or of a wheel that slides
/// [`SIDEWAYS`].
pub(super) fn balance<T: Real, const COARSE: usize, const FINE: usize, const SUMS: usize>(
    wheel: &Wheel<T>,
    at: &Contact<T>,
    from: Start<T::Primal>,
) -> Result<(T, Integrals<T>), ModelError> {
    let primal = wheel.map(T::primal);
    let (load, slip) = (at.normal_load.primal(), at.slip.primal());
    let carried = at.normal_load / (wheel.radius * wheel.width);
    let asked = wheel.asks();
    let plain = const { SUMS < SIDEWAYS }
        && (is_plain::<T>() || !(carried.varies() || asked.contains(&true)));
    if let (true, Start::Here(last)) = (const { FINE < QUICK }, from) {
        let (entry, load) = (last.exp(), carried.primal());
        let fine = Integrator::<T::Primal, FINE>::new(&primal, primal.stress());
        if plain {
            let (value, slopes) = fine.at(entry).integrals(entry);
            let step = (load - value.load) / slopes.load;
            if is_small(step) {
                let integrals = value.moved(&slopes, step);
                let root = entry + entry * step;
                return Ok((T::from_primal(root), integrals.map(T::from_primal)));
            }
        } else {
            let partials = fine.partials::<SUMS>(entry, &asked);
            if is_small(partials.step(load)) {
                return Ok(partials.balanced(wheel, entry, carried));
            }
        }
    }
    iterate::<T::Primal, COARSE, FINE, _>(&primal, load, slip, from, |entry, integrals, fine| {
        if plain {
            return (T::from_primal(entry), integrals.map(T::from_primal));
        }
        let partials = fine.partials::<SUMS>(entry, &asked);
        partials.balanced(wheel, entry, carried)
    })
}

/// Whether no lane has more than [`AT_ONCE`] to go.
fn is_small<P: Root>(step: P) -> bool {
    step.is_finite() && !P::from(AT_ONCE).any_lt(step.abs())
}

/// The entry angle, the integrals there and their partial derivatives by the variables that are asked for.
pub(super) fn partials<const COARSE: usize, const FINE: usize>(
    wheel: &Wheel<f64>,
    at: &Contact<f64>,
    asked: &[bool; VARIABLES],
) -> Result<(f64, Integrals<f64>, Partials<f64, STRAIGHT>), ModelError> {
    let (load, slip) = (at.normal_load, at.slip);
    iterate::<f64, COARSE, FINE, _>(wheel, load, slip, Start::Guess, |entry, integrals, fine| {
        (entry, integrals, fine.partials(entry, asked))
    })
}

/// The angle as everywhere, and the integrals there node by node in the scalar itself: sideways slip.
pub(super) fn rare<T: Real, const COARSE: usize, const FINE: usize>(
    wheel: &Wheel<T>,
    at: &Contact<T>,
) -> Result<(T, Integrals<T>), ModelError> {
    type Tangent<T> = <<T as Real>::Primal as Root>::Tangent;
    let primal = wheel.map(T::primal);
    let (load, slip) = (at.normal_load.primal(), at.slip.primal());
    let from = Start::of(at);
    let entry =
        iterate::<T::Primal, COARSE, FINE, _>(&primal, load, slip, from, |entry, _, _| entry)?;
    let tangent: Wheel<Tangent<T>> = primal.map(Tangent::<T>::from_primal);
    // One in the logarithm is the angle itself.
    let seeded = Tangent::<T>::from_primal(entry) * (T::Primal::zero().seed() + 1.0);
    let last = tangent.integrals(seeded);
    let slopes = last.map(|x| T::from_primal(T::Primal::parts(x).1));
    let root = T::from_primal(entry);
    let there = if is_plain::<T>() {
        last.map(|x| T::from_primal(T::Primal::parts(x).0))
    } else {
        wheel.integrals(root)
    };
    let step = (at.normal_load / (wheel.radius * wheel.width) - there.load) / slopes.load;
    Ok((root + root * step, there.moved(&slopes, step)))
}
