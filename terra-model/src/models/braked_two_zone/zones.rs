//! Where the two zones of a braked wheel meet, and how far each shears the soil: for any law of pressure and shear.

use crate::quadrature::t_minus_sin;
use crate::real::{Real, Root};

/// Skid below which the driven wheel takes over.
pub(in crate::models) const JOIN: f64 = 0.05;
/// Largest share of the contact behind the point where the zones meet.
const LARGEST: f64 = 0.98;
/// Share of the contact below which a zone behind is none to the quadrature.
pub(in crate::models) const SMALLEST: f64 = 1e-3;
/// Of the way between two angles: E has a bend only in its second derivative where j changes its sign.
const HALVINGS: usize = 30;

/// Everything about the zones but the entry angle.
#[derive(Clone, Copy)]
pub(in crate::models) struct Zones<T> {
    /// Kinematic slip.
    pub(in crate::models) slip: T,
    /// θm/θ1 of the driven wheel.
    apex_ratio: T,
    /// θ0, not held inside the contact.
    pub(in crate::models) meeting: T,
    /// Weight of the driven wheel.
    driven: T,
}

/// Where stresses change their form: θ0, θm, both inside the contact.
#[derive(Clone, Copy)]
pub(in crate::models) struct Places<T> {
    pub(in crate::models) entry: T,
    pub(in crate::models) meeting: T,
    pub(in crate::models) apex: T,
    /// θ - sin θ at θ1 and θ0, and its slope from one to the other.
    defects: [T; 2],
    chord: T,
}

impl<T: Real> Zones<T> {
    /// By tan φ of the soil, the library's and the kinematic slip.
    pub(in crate::models) fn new(tan_friction: T, slip: T, kinematic: T, apex_ratio: T) -> Self {
        let (zero, one) = (T::zero(), T::one());
        // cos(θ0 + χ) = (1 + s) cos χ, χ = 45° - φ/2; by tan²(x/2) = (1 - cos x)/(1 + cos x).
        let chi = T::from(std::f64::consts::FRAC_PI_4) - tan_friction.atan() * 0.5;
        let (_, cos_chi) = chi.sin_cos();
        let skid = slip.select_lt(zero, slip, zero);
        let cos = (skid + 1.0) * cos_chi;
        let meeting = ((one - cos) / (cos + 1.0)).sqrt().atan() * 2.0 - chi;
        let share = (skid / JOIN + 1.0).max_of(zero);
        Zones {
            slip: kinematic,
            apex_ratio,
            meeting: meeting.max_of(zero),
            driven: share.squared(),
        }
    }

    pub(in crate::models) fn map<S>(&self, f: impl Fn(T) -> S + Copy) -> Zones<S> {
        Zones {
            slip: f(self.slip),
            apex_ratio: f(self.apex_ratio),
            meeting: f(self.meeting),
            driven: f(self.driven),
        }
    }

    pub(in crate::models) fn places(&self, entry: T) -> Places<T> {
        let held = self.meeting.min_of(entry * LARGEST);
        let own = self.apex_ratio * entry;
        // The contact ends at the bottom; σ behind it needs some of it left.
        let apex = (own * self.driven + held * (T::one() - self.driven)).max_of(entry * 1e-3);
        let defects = [t_minus_sin(entry), t_minus_sin(held)];
        Places {
            entry,
            meeting: held,
            apex,
            defects,
            chord: (defects[0] - defects[1]) / (entry - held),
        }
    }

    /// True where θ0 lies ahead of a contact and is held inside it.
    pub(in crate::models) fn held(&self, entry: T) -> bool {
        (entry * LARGEST).primal().any_lt(self.meeting.primal())
    }

    /// j/R at an angle; what a driven wheel has, what each zone has, weighed.
    pub(in crate::models) fn displacement(&self, at: &Places<T>, angle: T) -> T {
        let i = self.slip;
        let one = T::one();
        let ([x_entry, x_meeting], x) = (at.defects, t_minus_sin(angle));
        let driven = i * (at.entry - angle) + (one - i) * (x_entry - x);
        let ahead = (one - i) * ((x_entry - x) - (at.entry - angle) * at.chord);
        let behind = i * (at.meeting - angle) + (one - i) * (x_meeting - x);
        let two = angle.select_lt(at.meeting, behind, ahead);
        // A wheel that is not braked has one zone, whatever a locked one would have.
        let rest = one - self.driven;
        driven * self.driven + two * rest
    }

    /// -dj/dθ/R at an angle, in the zone ahead of θ0 and in the one behind.
    pub(in crate::models) fn growths(&self, at: &Places<T>, angle: T) -> [T; 2] {
        let (sin_half, _) = (angle * 0.5).sin_cos();
        let versine = sin_half.squared() * 2.0;
        let past = T::one() - self.slip;
        let one_zone = self.slip + past * versine;
        let ahead = past * (versine - at.chord);
        [
            one_zone * self.driven + ahead * (T::one() - self.driven),
            one_zone,
        ]
    }

    /// Whether a wheel is between driven and locked.
    pub(in crate::models) fn joins(&self) -> bool {
        let driven = self.driven.primal();
        T::Primal::zero().any_lt(driven.min_of(T::Primal::one() - driven))
    }

    /// Where j = 0 between driven and locked. None where no wheel is between.
    pub(in crate::models) fn turn(&self, at: &Places<T>) -> Option<T::Primal> {
        let zero = T::Primal::zero();
        if !self.joins() {
            return None;
        }
        let zones = self.map(T::primal);
        let at = at.map(T::primal);
        // j has one sign from the entry to its change, which lies on that side of θ0 where its sign there says.
        let there = zones.displacement(&at, at.meeting);
        let mut low = there.select_lt(zero, at.meeting, zero);
        let mut high = there.select_lt(zero, at.entry, at.meeting);
        for _ in 0..HALVINGS {
            let middle = (low + high) * 0.5;
            let j = zones.displacement(&at, middle);
            low = j.select_lt(zero, middle, low);
            high = j.select_lt(zero, high, middle);
        }
        Some((low + high) * 0.5)
    }
}

impl<T: Real> Places<T> {
    pub(in crate::models) fn map<S>(&self, f: impl Fn(T) -> S + Copy) -> Places<S> {
        Places {
            entry: f(self.entry),
            meeting: f(self.meeting),
            apex: f(self.apex),
            defects: self.defects.map(f),
            chord: f(self.chord),
        }
    }
}
