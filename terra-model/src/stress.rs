//! Stresses between wheel and soil: at any angle of a contact, and as a profile with its peaks.

/// Stresses on the rim at one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressPoint {
    /// θ \[rad\].
    pub angle: f64,
    /// σ \[Pa\].
    pub normal_stress: f64,
    /// τ \[Pa\]; where lugs push soil, with their push spread over the rim, as the mean over their places has it.
    pub shear_stress: f64,
    /// How far from the axle τ acts \[m\]: at the rim, or farther out where lugs carry a part of it. The torque is
    /// R b ∫ τ `shear_arm` dθ.
    pub shear_arm: f64,
}

/// The stresses of one contact, from exit to entry, with their peaks.
#[derive(Clone, Debug, PartialEq)]
pub struct StressProfile {
    /// Along the rim.
    pub points: Vec<StressPoint>,
    /// Where σ is largest, with both stresses there.
    pub max_normal: StressPoint,
    /// Where τ is largest (signed), with both stresses there.
    pub max_shear: StressPoint,
    /// Half the angle \[rad\] under which a tyre lies flat: points within it lie on the chord, where stresses push upwards
    /// and along it. None where the contact is round all along.
    pub flat: Option<f64>,
}

/// The stresses of one contact at any angle between exit and entry: what load, pull and torque are integrals of.
///
/// W = R b ∫ (σ cos θ + τ sin θ) dθ,  D = R b ∫ (τ cos θ - σ sin θ) dθ,  T = R b ∫ τ `shear_arm` dθ; under the flat of a tyre
/// of half angle θf, where stresses push upwards and along it, dx = R cos θf dθ / cos² θ stands for R dθ.
pub struct StressField {
    /// Where the contact ends \[rad\].
    pub exit: f64,
    /// Where branches meet, or near which σ peaks \[rad\].
    pub apex: f64,
    /// Where the contact begins \[rad\].
    pub entry: f64,
    /// Half the angle \[rad\] under which a tyre lies flat. None where the contact is round all along.
    pub flat: Option<f64>,
    stress: Box<dyn Fn(f64) -> StressPoint + Send + Sync>,
}

impl StressField {
    /// A round contact from `exit` over `apex` to `entry`.
    pub fn new(
        exit: f64,
        apex: f64,
        entry: f64,
        stress: impl Fn(f64) -> StressPoint + Send + Sync + 'static,
    ) -> Self {
        StressField {
            exit,
            apex,
            entry,
            flat: None,
            stress: Box::new(stress),
        }
    }

    /// Stresses at an angle \[rad\] between exit and entry.
    pub fn at(&self, angle: f64) -> StressPoint {
        (self.stress)(angle)
    }

    /// `points` stresses from exit to entry (at least two), with the peaks of σ and τ refined.
    pub fn profile(&self, points: usize) -> StressProfile {
        let (exit, apex, entry) = (self.exit, self.apex, self.entry);
        let stress = |angle: f64| self.at(angle);
        let points = points.max(2);
        // Rounding must not step over the entry, where there is no contact.
        let at =
            |i: usize, n: usize| (exit + (entry - exit) * i as f64 / (n - 1) as f64).min(entry);
        let profile: Vec<StressPoint> = (0..points).map(|i| stress(at(i, points))).collect();
        // No sample may be above the peak.
        let scan = points.max(201);
        let place = |i: usize| at(i, scan);
        // A peak on an end or on the apex is a corner that the search only approaches: braking wheels have it at
        // the entry, where the shear stress is exactly zero.
        let corners = [stress(apex), stress(exit), stress(entry)];
        let peak = |of: &dyn Fn(&StressPoint) -> f64| {
            let scanned: Vec<f64> = (0..scan).map(|i| of(&stress(place(i)))).collect();
            let best = (0..scan).max_by(|&a, &b| scanned[a].total_cmp(&scanned[b]));
            let best = best.unwrap_or(0);
            let (mut low, mut high) = (
                place(best.saturating_sub(1)),
                place((best + 1).min(scan - 1)),
            );
            for _ in 0..80 {
                let (a, b) = (
                    low + 0.381_966 * (high - low),
                    low + 0.618_034 * (high - low),
                );
                if of(&stress(a)) < of(&stress(b)) {
                    low = a
                } else {
                    high = b
                }
            }
            let found = stress(0.5 * (low + high));
            let highest = corners
                .into_iter()
                .reduce(|a, b| if of(&b) > of(&a) { b } else { a });
            // Beside a corner the search is no higher than by rounding.
            highest
                .filter(|corner| of(&found) <= of(corner) + 1e-13 * of(corner).abs())
                .unwrap_or(found)
        };
        let max_normal = peak(&|q| q.normal_stress);
        let max_shear = peak(&|q| q.shear_stress);
        StressProfile {
            points: profile,
            max_normal,
            max_shear,
            flat: self.flat,
        }
    }
}
