//! The entry angle that carries a load: one root for every wheel model, in `f64` or in lanes.

use crate::error::ModelError;
use crate::real::{Real, Root, is_plain};

/// Smallest entry angle considered \[rad\].
pub(crate) const MIN_ENTRY_ANGLE: f64 = 1e-9;
/// Largest: the wheel is buried to its axle \[rad\].
pub(crate) const MAX_ENTRY_ANGLE: f64 = std::f64::consts::FRAC_PI_2;
/// Up to here the load of a driven wheel rises whose stresses are linear from the bottom to θ1: beyond, the closed form may
/// carry less as it sinks \[rad\]. σm, τm, B and C rise everywhere, and A by the mean of θ cos θ over [θm, θ1] less that over
/// [0, θm], which is above zero up to 1.24 for any θm.
pub(crate) const LINEAR_RISES_TO: f64 = 1.2;
/// The same with an exit anywhere: θ cos θ itself rises up to here.
pub(crate) const LINEAR_WITH_EXIT_RISES_TO: f64 = 0.86;
/// θ2/-θ1 up to which the load of a driven rigid wheel rises at every angle; behind a longer rear contact the shear stress
/// may pull it in by more than it gains.
pub(crate) const RISING_EXIT: f64 = 0.5;
const MAX_STEPS: usize = 200;
/// Newton's steps alone may creep inside the bracket where a braked wheel's load has a bend; after this many, every other
/// step halves it, which bounds the count.
const PATIENCE: usize = 12;
/// Relative change of the entry angle at which the iteration stops. One implicit step follows, which squares the
/// remaining error, so this is below rounding in the end.
pub(crate) const TOLERANCE: f64 = 1e-8;
/// The same for a load whose slope changes within that: where a tyre begins to lie flat it grows with the root of the angle
/// past that place.
pub(crate) const FINE_TOLERANCE: f64 = 1e-12;

/// Solves `supported_load(θ1) = load` up to one last Newton step, which is below `tolerance` of the angle.
///
/// The load is nearly a power of the entry angle, so Newton's method runs on ln W(ln θ1), inside a bracket with
/// bisection where the step leaves it or the load is not positive (braking on snow). `supported_load` gets the angle
/// with derivative one in its logarithm.
///
/// Where the load rises with the angle, 90° carries most and the root is the only one. The load of a braked wheel may fall
/// again, where the shear stress pulls it in by more than the soil gains below it: an angle of balance may vanish in a fold
/// as slip or load change, and another lie far below it. The root is the one that a wheel reaches as it sinks from the
/// surface; where the soil gives way beneath it first there is none, so that forces have no jump from one angle of balance to
/// the other. What carries less than a hundredth of the most is passed over.
///
/// # Errors
/// [`ModelError::NoEquilibrium`] when the soil carries the load at no angle up to 90°, or gives way before;
/// [`ModelError::Contact`] for a load too small to sink the wheel by a measurable amount; [`ModelError::NotConverged`] when
/// the numbers overflow.
pub(crate) fn entry_angle<P: Root>(
    load: P,
    guess: P,
    slip: P,
    rises_to: P,
    tolerance: f64,
    supported_load: impl Fn(P::Tangent) -> P::Tangent,
) -> Result<Found<P>, ModelError> {
    let search = Search {
        load,
        slip,
        rises_to,
        tolerance,
        feasible: false,
        for_fits: false,
    };
    let carried = |angle: P| {
        // One in the logarithm is the angle itself.
        let seeded = P::Tangent::from_primal(angle) * (P::zero().seed() + 1.0);
        P::parts(supported_load(seeded))
    };
    search.root(guess.ln(), carried, carried)
}

/// θ1 in any scalar: [`entry_angle`] in the primal, from a guess, and its derivatives by one implicit step.
///
/// `tangent` gives the load of the primal wheel at an angle with one derivative, `load_at` that of the wheel itself.
///
/// # Errors
/// As [`entry_angle`].
pub(crate) fn balanced<T: Real>(
    load: T,
    guess: T::Primal,
    slip: T::Primal,
    rises_to: T::Primal,
    tolerance: f64,
    tangent: impl Fn(<T::Primal as Root>::Tangent) -> <T::Primal as Root>::Tangent,
    load_at: impl Fn(T) -> T,
) -> Result<T, ModelError> {
    let found = entry_angle(load.primal(), guess, slip, rises_to, tolerance, &tangent)?;
    Ok(found.with_derivatives(load, load_at))
}

/// The angle up to which the load of a wheel is known to rise with its sinkage: `driven` for a driven one, none for a
/// braked one.
pub(crate) fn rises_to<P: Root>(slip: P, driven: f64) -> P {
    slip.select_lt(P::zero(), P::zero(), P::from(driven))
}

/// What [`entry_angle`] does, for a load given with its slope in ln θ1.
pub(crate) struct Search<P> {
    pub(crate) load: P,
    pub(crate) slip: P,
    /// Up to here the load is known to rise with the angle: a root below is the only one.
    pub(crate) rises_to: P,
    /// Relative change of the entry angle at which the iteration stops.
    pub(crate) tolerance: f64,
    /// The start is known to lie near the root, so that no fold is looked for.
    pub(crate) feasible: bool,
    /// A fold of a few parts in a thousand may be passed over that a deep root has below it.
    pub(crate) for_fits: bool,
}

/// A root up to the Newton step that is left.
#[derive(Clone, Copy)]
pub(crate) struct Found<P> {
    pub(crate) ln_angle: P,
    /// What is carried there, and its slope in ln θ1.
    pub(crate) load: P,
    pub(crate) slope: P,
    /// The load was asked for there last, so that a caller can keep what it found on the way.
    pub(crate) last: bool,
}

impl<P: Root> Found<P> {
    /// θ1 in any scalar, by the step that is left: in the primal alone from what is known there.
    pub(crate) fn with_derivatives<T: Real<Primal = P>>(
        &self,
        load: T,
        load_at: impl Fn(T) -> T,
    ) -> T {
        let root = self.ln_angle.exp();
        let slope = T::from_primal(self.slope / root);
        let root = T::from_primal(root);
        let carried = if is_plain::<T>() {
            T::from_primal(self.load)
        } else {
            load_at(root)
        };
        root - (carried - load) / slope
    }

    /// True where the load grows by a power that is usual: far from a fold, and from a load that soil and shear stress nearly
    /// take from each other.
    pub(crate) fn is_usual(&self) -> bool {
        grows((self.load, self.slope)) && !(self.load * USUAL).any_lt(self.slope)
    }
}

impl<P: Root> Search<P> {
    /// ln θ1 from its guess.
    ///
    /// `quick` gives the load as `supported_load` does, but need not be exact: to a part in a hundred the root is as near, and
    /// a fold as plain to see.
    ///
    /// # Errors
    /// As [`entry_angle`].
    #[inline]
    pub(crate) fn root(
        &self,
        guess: P,
        supported_load: impl Fn(P) -> (P, P),
        quick: impl Fn(P) -> (P, P),
    ) -> Result<Found<P>, ModelError> {
        let top = P::from(MAX_ENTRY_ANGLE.ln());
        let found = self.between(guess, top, &quick);
        if self.feasible {
            return found;
        }
        match found {
            Ok(found) if !self.rises_to.any_lt(found.ln_angle.exp()) => Ok(found),
            Err(e) if !self.rises_to.any_lt(P::from(MAX_ENTRY_ANGLE)) => Err(e),
            Ok(found) if self.is_sound(&found, &quick) => Ok(Found {
                last: false,
                ..found
            }),
            _ => self.first_root(guess, &supported_load, &quick),
        }
    }

    /// ln θ1 near the root of a moment ago, when slip, load or soil were a little different. None where another root may have come
    /// before it since: then it takes [`root`](Self::root).
    #[inline]
    pub(crate) fn root_near(&self, last: P, load_at: impl Fn(P) -> (P, P)) -> Option<Found<P>> {
        let top = P::from(MAX_ENTRY_ANGLE.ln());
        let found = self.between(last, top, &load_at).ok()?;
        let only_one = !self.rises_to.any_lt(found.ln_angle.exp());
        (only_one || self.is_sound(&found, &load_at)).then_some(found)
    }

    /// True where the load grows well at a root and wherever it is glanced at below.
    fn is_sound(&self, root: &Found<P>, load_at: impl Fn(P) -> (P, P)) -> bool {
        let angle = root.ln_angle.exp();
        // The iteration may end on its bracket instead, where no angle carries the load.
        let left = (root.load - self.load).abs();
        let balances = !(root.slope * (2.0 * self.tolerance)).any_lt(left);
        let deep = P::from(DEEP).any_lt(angle);
        if (deep && !self.for_fits) || !balances || !grows((root.load, root.slope)) {
            return false;
        }
        let glances = if deep { &DEEP_GLANCES[..] } else { &GLANCES };
        let mut below = (root.load, root.slope);
        let mut share_below = 1.0;
        glances.iter().all(|&share| {
            let here = load_at(angle * share);
            let sound = grows(here) && is_steady(here, below, share_below / share);
            (below, share_below) = (here, share);
            sound
        })
    }

    /// The root that a sinking wheel reaches first, where the load may fall again as it sinks.
    fn first_root(
        &self,
        guess: P,
        supported_load: &impl Fn(P) -> (P, P),
        quick: &impl Fn(P) -> (P, P),
    ) -> Result<Found<P>, ModelError> {
        let (load, mut high) = (self.load, P::from(MAX_ENTRY_ANGLE.ln()));
        let (most, _) = supported_load(high.exp());
        if !most.is_finite() {
            return Err(self.not_converged(0));
        }
        if most.any_lt(load) {
            // A nearly locked wheel can be carried best before it is buried: the shear stress lifts it less and less.
            high = self.reachable(deepest(supported_load), supported_load)?;
        }
        let root = self.between(guess, high, supported_load)?;
        let angle = root.ln_angle.exp();
        let (first, foothold) = (angle * FIRST_LOOK, load * FOOTHOLD);
        if !rises_clearly(angle, first, foothold, quick)
            && fold_below(angle, first, foothold, supported_load).any_lt(angle)
        {
            let limit = deepest(supported_load);
            if limit.any_lt(angle) {
                high = self.reachable(limit, supported_load)?;
                return self.between(guess, high, supported_load);
            }
        }
        Ok(Found {
            last: false,
            ..root
        })
    }

    /// ln of an angle that carries the load.
    ///
    /// # Errors
    /// [`ModelError::NoEquilibrium`] where it does not.
    fn reachable(&self, limit: P, supported_load: &impl Fn(P) -> (P, P)) -> Result<P, ModelError> {
        // Nothing at no sinkage, at the least.
        let most = supported_load(limit).0.max_of(P::zero());
        if most.any_lt(self.load) {
            return Err(ModelError::NoEquilibrium {
                load: self.load.max_lane(),
                max_load: most.min_lane(),
            });
        }
        Ok(limit.ln())
    }

    /// The root below a ln θ1: Newton's steps inside the bracket.
    #[inline]
    fn between(
        &self,
        guess: P,
        mut high: P,
        supported_load: &impl Fn(P) -> (P, P),
    ) -> Result<Found<P>, ModelError> {
        let (load, tolerance) = (self.load, self.tolerance);
        let (zero, one) = (P::zero(), P::one());
        let bottom = P::from(MIN_ENTRY_ANGLE.ln());
        let mut low = bottom;
        let top = P::from(MAX_ENTRY_ANGLE.ln());
        let mut x = guess;
        x = x.select_lt(low, low, x);
        x = high.select_lt(x, high, x);
        for step in 0..MAX_STEPS {
            let (w, slope) = supported_load(x.exp());
            if !w.is_finite() {
                return Err(self.not_converged(step));
            }
            // Short of the load at 90°: no angle carries it.
            let buried = x.select_lt(top, zero, w.select_lt(load, one, zero));
            if zero.any_lt(buried) {
                let carried = zero.select_lt(buried, w, P::from(f64::INFINITY));
                return Err(ModelError::NoEquilibrium {
                    load: load.max_lane(),
                    max_load: carried.min_lane(),
                });
            }
            low = w.select_lt(load, x, low);
            high = w.select_lt(load, high, x);
            let middle = (low + high) * 0.5;
            // A step past 90° asks there, where the answer may be that no angle carries the load.
            let beyond = high.select_lt(top, middle, top);
            // ln(W/load) / (d ln W / d ln θ1); where W or its slope is not positive the bracket decides.
            let safe_w = zero.select_lt(w, w, one);
            let safe_slope = zero.select_lt(slope, slope, one);
            let newton = x - (safe_w / load).ln() * safe_w / safe_slope;
            let inside = if step > PATIENCE && step % 2 == 1 {
                middle
            } else {
                newton.select_lt(low, middle, high.select_lt(newton, beyond, newton))
            };
            let next = zero.select_lt(w, zero.select_lt(slope, inside, middle), middle);
            let change = (next - x).abs();
            let open = P::from(tolerance).select_lt(change, high - low, zero);
            if !P::from(tolerance).any_lt(open) {
                if x.any_lt(bottom + 1e-6) {
                    let expected = "a load that sinks the wheel: an entry angle above 1e-9 rad";
                    return Err(ModelError::Contact {
                        quantity: "normal_load",
                        value: load.min_lane(),
                        expected,
                    });
                }
                return Ok(Found {
                    ln_angle: x,
                    load: w,
                    slope,
                    last: true,
                });
            }
            x = next;
        }
        Err(self.not_converged(MAX_STEPS))
    }

    fn not_converged(&self, iterations: usize) -> ModelError {
        ModelError::NotConverged {
            iterations,
            load: self.load.max_lane(),
            slip: self.slip.max_lane(),
        }
    }
}

/// Step between the angles at which the load is asked for in search of a fold \[rad\]: loads change over tens of degrees, with
/// a shear law that peaks over a few. A fold that is much narrower than this step may be passed over.
/// Those of high lugs do over a few, so that smaller angles are doubled up to this one.
const LOOK: f64 = std::f64::consts::FRAC_PI_2 / 36.0;
/// The first of them, as a share of the root below which a fold is looked for: less than a hundredth is carried there, where
/// the load grows by more than the angle does.
const FIRST_LOOK: f64 = 1.0 / 64.0;
/// The same where there is no root \[rad\]: a soil may carry a few grams before it gives way.
const SMALLEST_LOOK: f64 = 1e-6;
/// A place that carries less than this share of what lies deeper does not hold a wheel up.
const FOOTHOLD: f64 = 0.01;
/// d ln W / d ln θ1 below which a fold may hide between two of those: sound loads grow by a power above a half.
const FLAT: f64 = 0.25;

/// Shares of the root at which a wheel that is far from any fold shows it, beside the root itself.
const GLANCES: [f64; 3] = [0.8, 0.5, 0.2];
/// The same of a deep one in a fit, whose data know loads to a hundredth: of a million braked wheels on random soils one has an
/// angle of balance by these that a search finds a fold below.
const DEEP_GLANCES: [f64; 7] = [0.9, 0.8, 0.7, 0.6, 0.5, 0.35, 0.2];
/// d ln W / d ln θ1 from which it is: on its way to a fold the load grows more and more slowly over tens of degrees.
const SOUND: f64 = 0.8;

/// Roots beyond are searched below: a wheel that is sunk so deep turns its rim through much of the shear law, and folds
/// there may be narrow \[rad\].
const DEEP: f64 = 0.7;
/// How far d ln W / d ln θ1 at either end of an interval may exceed its mean there. Behind a fold the load has grown by less
/// than its slopes say. A cubic through both ends rises in between up to three times the mean (F. N. Fritsch, R. E. Carlson,
/// SIAM J. Numer. Anal. 17(2), 1980); two is on the safe side of it.
const STEADY: f64 = 2.0;

/// The same two of a load that is known to a part in a hundred.
const CLEARLY: (f64, f64) = (0.5, 1.5);

/// d ln W / d ln θ1 above any that a soil without shear stress has: 1 + 2 n.
const USUAL: f64 = 8.0;

/// True where a load, given with its slope in ln θ1, is above zero and grows well.
fn grows<P: Root>((w, slope): (P, P)) -> bool {
    !slope.any_lt(w * SOUND) && !w.any_lt(P::zero())
}

/// True where a load grows between two angles, the deeper `ratio` times the other, as its slopes at both say.
fn is_steady<P: Root>(above: (P, P), below: (P, P), ratio: f64) -> bool {
    let mean = (below.0 / above.0).ln() * (STEADY / ratio.ln());
    !mean.any_lt((above.1 / above.0).max_of(below.1 / below.0))
}

/// The largest angle that a sinking wheel reaches at rest: where the soil gives way, or 90°.
fn deepest<P: Root>(supported_load: &impl Fn(P) -> (P, P)) -> P {
    let (buried, first) = (P::from(MAX_ENTRY_ANGLE), P::from(SMALLEST_LOOK));
    let mut most = P::zero();
    looks(buried, first, |angle, _| {
        most = most.max_of(supported_load(angle).0);
        true
    });
    fold_below(buried, first, most * FOOTHOLD, supported_load)
}

/// The angle at which the soil gives way: the first below `upto` where a load above zero stops to rise; `upto` without one.
///
/// A load that falls below zero from the start (braking on snow) has not carried the wheel yet, and is no fold.
///
/// The search begins at the angle `first`. Where less than `foothold` is carried the wheel sinks on.
fn fold_below<P: Root>(upto: P, first: P, foothold: P, supported_load: &impl Fn(P) -> (P, P)) -> P {
    let (zero, one) = (P::zero(), P::one());
    let none = P::from(f64::NEG_INFINITY);
    let growth = |(w, slope): (P, P)| foothold.select_lt(w, slope / w, one);
    // One where the load falls: its slope does, or it is less than further up.
    let falls = |(w, slope): (P, P), above: P| {
        let down = growth((w, slope)).select_lt(zero, one, zero);
        w.select_lt(above, one, down)
    };
    let (mut low, mut high, mut above) = (upto, upto, none);
    let mut unbroken = one;
    let (mut flattest, mut from, mut to) = (P::from(FLAT), upto, upto);
    let (mut last, mut carried) = (P::from(MIN_ENTRY_ANGLE), none);
    // The interval in which the load grows least for what its slopes say, and by what factor.
    let (mut restless, mut before, mut after) = (P::from(STEADY), upto, upto);
    let mut grew = one;
    looks(upto, first, |angle, next| {
        let found = supported_load(angle);
        let breaks = unbroken * falls(found, carried);
        let broken = |yes: P, no: P| zero.select_lt(breaks, yes, no);
        (low, high, above) = (
            broken(last, low),
            broken(angle, high),
            broken(carried, above),
        );
        unbroken -= breaks;
        let growth = zero.select_lt(unbroken, growth(found), one);
        let held = foothold.select_lt(carried, carried, found.0);
        let mean = (found.0 / held).ln() / (angle / last).ln();
        let rises = zero.select_lt(mean, growth.max_of(grew) / mean, zero);
        before = restless.select_lt(rises, last, before);
        after = restless.select_lt(rises, angle, after);
        restless = zero.select_lt(unbroken, restless.max_of(rises), restless);
        grew = growth;
        from = growth.select_lt(flattest, last, from);
        to = growth.select_lt(flattest, next, to);
        flattest = flattest.min_of(growth);
        (last, carried) = (angle, foothold.select_lt(found.0, found.0, none));
        zero.any_lt(unbroken)
    });
    if flattest.any_lt(P::from(FLAT)) {
        let flattest = least(from, to, |angle| growth(supported_load(angle)));
        let hidden = growth(supported_load(flattest));
        low = hidden.select_lt(zero, from, low);
        high = hidden.select_lt(zero, flattest, high);
        above = hidden.select_lt(zero, none, above);
    }
    if !low.any_lt(high) && before.any_lt(after) {
        let flattest = least(before, after, |angle| growth(supported_load(angle)));
        let hidden = growth(supported_load(flattest));
        low = hidden.select_lt(zero, before, low);
        high = hidden.select_lt(zero, flattest, high);
    }
    if !low.any_lt(high) {
        return upto;
    }
    for _ in 0..50 {
        let middle = (low + high) * 0.5;
        let down = falls(supported_load(middle), above);
        low = zero.select_lt(down, low, middle);
        high = zero.select_lt(down, middle, high);
    }
    high
}

/// True where a load that is known to a part in a hundred rises so well at all angles looked at that an exact one has no fold.
fn rises_clearly<P: Root>(upto: P, first: P, foothold: P, load_at: &impl Fn(P) -> (P, P)) -> bool {
    let (mut last, mut carried, mut grew) = (P::zero(), P::zero(), P::one());
    let mut clear = true;
    looks(upto, first, |angle, _| {
        let (w, slope) = load_at(angle);
        let growth = foothold.select_lt(w, slope / w, P::one());
        // Where nothing was carried before there is no mean to compare with.
        let held = foothold.select_lt(carried, carried, w);
        let between = (w / held).ln() / (angle / last).ln();
        let mean = foothold.select_lt(carried, between, growth.max_of(grew));
        let restless = mean * CLEARLY.1;
        // Below zero there is no logarithm to tell that the load fell.
        let fell = foothold.select_lt(carried, w, carried).any_lt(carried);
        let slow = growth.any_lt(P::from(CLEARLY.0)) || restless.any_lt(growth.max_of(grew));
        clear = !(fell || slow);
        (last, carried, grew) = (angle, w, growth);
        clear
    });
    clear
}

/// Visits angles up to the last, each with the next one, until `visit` says no.
fn looks<P: Root>(upto: P, first: P, mut visit: impl FnMut(P, P) -> bool) {
    let (step, mut next) = (P::from(LOOK), first);
    loop {
        let angle = next.min_of(upto);
        let farther = angle.select_lt(step, step, angle + step);
        next = angle.select_lt(step * 0.51, angle * 2.0, farther);
        if !visit(angle, next.min_of(upto)) || !angle.any_lt(upto) {
            return;
        }
    }
}

/// Where a function is least between two angles: a golden section search, to a ten-thousandth of what is between them.
fn least<P: Root>(mut low: P, mut high: P, f: impl Fn(P) -> P) -> P {
    const SHORTER: f64 = 0.618_033_988_749_895;
    let place = |low: P, high: P, share: f64| low + (high - low) * share;
    let (mut a, mut b) = (place(low, high, 1.0 - SHORTER), place(low, high, SHORTER));
    let (mut at_a, mut at_b) = (f(a), f(b));
    for _ in 0..20 {
        low = at_b.select_lt(at_a, a, low);
        high = at_b.select_lt(at_a, high, b);
        // One of the two places serves again.
        let kept = at_b.select_lt(at_a, b, a);
        let at_kept = at_b.select_lt(at_a, at_b, at_a);
        let (left, right) = (place(low, high, 1.0 - SHORTER), place(low, high, SHORTER));
        let new = at_b.select_lt(at_a, right, left);
        let at_new = f(new);
        (a, b) = (
            at_b.select_lt(at_a, kept, new),
            at_b.select_lt(at_a, new, kept),
        );
        (at_a, at_b) = (
            at_b.select_lt(at_a, at_kept, at_new),
            at_b.select_lt(at_a, at_new, at_kept),
        );
    }
    (low + high) * 0.5
}
