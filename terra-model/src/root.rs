//! The entry angle that carries a load: one root for every wheel model, in `f64` or in lanes.

use crate::error::ModelError;
use crate::real::{Real, Root};

/// Smallest entry angle considered \[rad\].
pub(crate) const MIN_ENTRY_ANGLE: f64 = 1e-9;
/// Largest: the wheel is buried to its axle \[rad\].
pub(crate) const MAX_ENTRY_ANGLE: f64 = std::f64::consts::FRAC_PI_2;
const MAX_STEPS: usize = 200;
/// Newton's steps alone may creep inside the bracket where a braked wheel's load has a bend; after this many, every other
/// step halves it, which bounds the count.
const PATIENCE: usize = 12;
/// Relative change of the entry angle at which the iteration stops. One implicit step follows, which squares the
/// remaining error, so this is below rounding in the end.
const TOLERANCE: f64 = 1e-8;

/// Solves `supported_load(θ1) = load` up to one last Newton step: ln θ1 returned is the last one that was evaluated,
/// so that a caller can keep what it found there, and the step that is left is below 1e-8.
///
/// The load is nearly a power of the entry angle, so Newton's method runs on ln W(ln θ1), inside a bracket with
/// bisection where the step leaves it or the load is not positive (braking on snow). `supported_load` gets the angle
/// with derivative one in its logarithm.
///
/// For non-negative slip the load rises with the angle, so 90° carries most and the root is the only one. A braked wheel
/// may be carried best at a smaller angle, and the root is one where the load rises.
///
/// # Errors
/// [`ModelError::NoEquilibrium`] when the soil carries the load at no angle up to 90°; [`ModelError::Contact`] for a load too
/// small to sink the wheel by a measurable amount; [`ModelError::NotConverged`] when the numbers overflow.
pub(crate) fn entry_angle<P: Root>(
    load: P,
    guess: P,
    slip: P,
    supported_load: impl Fn(P::Tangent) -> P::Tangent,
) -> Result<P, ModelError> {
    let search = Search {
        load,
        slip,
        tolerance: TOLERANCE,
        feasible: false,
    };
    search.root(guess.ln(), |angle| {
        // One in the logarithm is the angle itself.
        let seeded = P::Tangent::from_primal(angle) * (P::zero().seed() + 1.0);
        P::parts(supported_load(seeded))
    })
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
    tangent: impl Fn(<T::Primal as Root>::Tangent) -> <T::Primal as Root>::Tangent,
    load_at: impl Fn(T) -> T,
) -> Result<T, ModelError> {
    let root = entry_angle(load.primal(), guess, slip, &tangent)?.exp();
    let (_, slope) = T::Primal::parts(tangent(root.seed()));
    let root = T::from_primal(root);
    Ok(root - (load_at(root) - load) / T::from_primal(slope))
}

/// What [`entry_angle`] does, for a load given with its slope in ln θ1.
pub(crate) struct Search<P> {
    pub(crate) load: P,
    pub(crate) slip: P,
    /// Relative change of the entry angle at which the iteration stops.
    pub(crate) tolerance: f64,
    /// The start is known to lie near a root, so that a braked wheel is not tried at 90° first.
    pub(crate) feasible: bool,
}

impl<P: Root> Search<P> {
    /// ln θ1 from its guess.
    ///
    /// # Errors
    /// As [`entry_angle`].
    #[inline]
    pub(crate) fn root(
        &self,
        guess: P,
        supported_load: impl Fn(P) -> (P, P),
    ) -> Result<P, ModelError> {
        let &Search {
            load,
            slip,
            tolerance,
            feasible,
        } = self;
        let at = |ln_angle: P| supported_load(ln_angle.exp());
        let (zero, one) = (P::zero(), P::one());
        let not_converged = |iterations| ModelError::NotConverged {
            iterations,
            load: load.max_lane(),
            slip: slip.max_lane(),
        };

        let bottom = P::from(MIN_ENTRY_ANGLE.ln());
        let top = P::from(MAX_ENTRY_ANGLE.ln());
        let (mut low, mut high) = (bottom, top);
        if !feasible && slip.any_lt(zero) {
            let (mut most, _) = at(high);
            if !most.is_finite() {
                return Err(not_converged(0));
            }
            if most.any_lt(load) {
                // A nearly locked wheel can be carried best before it is buried: the shear stress lifts it less and less.
                let peak = best_angle(|angle| supported_load(angle).0);
                let (carried, _) = at(peak.ln());
                high = most.select_lt(carried, peak.ln(), high);
                most = most.max_of(carried);
            }
            if most.any_lt(load) {
                return Err(ModelError::NoEquilibrium {
                    load: load.max_lane(),
                    max_load: most.min_lane(),
                });
            }
        }

        let mut x = guess;
        x = x.select_lt(low, low, x);
        x = high.select_lt(x, high, x);
        for step in 0..MAX_STEPS {
            let (w, slope) = at(x);
            if !w.is_finite() {
                return Err(not_converged(step));
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
                return Ok(x);
            }
            x = next;
        }
        Err(not_converged(MAX_STEPS))
    }
}

/// The angle that carries most: a scan, then a golden section search around the best.
fn best_angle<P: Root>(load: impl Fn(P) -> P) -> P {
    const SCAN: usize = 64;
    let step = MAX_ENTRY_ANGLE / SCAN as f64;
    let (mut best, mut most) = (P::from(MAX_ENTRY_ANGLE), load(P::from(MAX_ENTRY_ANGLE)));
    for q in 1..SCAN {
        let angle = P::from(step * q as f64);
        let carried = load(angle);
        best = most.select_lt(carried, angle, best);
        most = most.max_of(carried);
    }
    let (mut low, mut high) = (best - step, (best + step).min_of(P::from(MAX_ENTRY_ANGLE)));
    for _ in 0..40 {
        let (a, b) = (
            low + (high - low) * 0.381_966,
            low + (high - low) * 0.618_034,
        );
        let (at_a, at_b) = (load(a), load(b));
        low = at_a.select_lt(at_b, a, low);
        high = at_a.select_lt(at_b, high, b);
    }
    ((low + high) * 0.5).max_of(P::from(MIN_ENTRY_ANGLE))
}
