//! An effect whose formula is only roughly the library's: the same place, the same sign, the same cause, another curve.
//!
//! # Equation
//! e(state) = e exp(Σ a_m φ_m(state)), φ_m smooth and of order 1 over the log (slip, load, speed, path, ...);
//! soil factors share the action: ln h_j = ln h_j(effect) + b_j D, D = Σ_j ln h_j(effect);
//! forces: ΔT e^c, ΔF_y e^d. Every a, b, c, d is small by its prior; all zero is exactly the library's own formula.
//!
//! # Reference
//! M. C. Kennedy, A. O'Hagan, J. Royal Stat. Soc. B 63(3):425-464, 2001 (discrepancy of a model's form), here inside the
//! effect, where it can only reshape what the effect does.

use std::sync::Arc;

use terra_model::{
    AnyEffect, BodyLoads, Channel, Circumstance, Contact, Dual8, EffectAt, Hook, LaneDual, Lanes,
    Late, Motion, Param, Real, Scope, Soil, Touch, Vehicle, WheelForces,
};

use super::term::{Regime, Term};

/// Name of this form in reports.
pub(crate) const FREE: &str = "free";

/// An effect with terms.
pub(crate) struct FreeForm {
    inner: Arc<dyn AnyEffect>,
    regime: Regime,
    terms: Vec<Term>,
    /// The effect's own, then one a term.
    params: Vec<Param>,
}

impl FreeForm {
    pub(crate) fn new(inner: Arc<dyn AnyEffect>, regime: Regime, terms: Vec<Term>) -> Self {
        let mut params = inner.params().to_vec();
        params.extend(terms.iter().map(|t| t.param()));
        FreeForm {
            inner,
            regime,
            terms,
            params,
        }
    }

    /// The effect's own magnitudes, and each term with its parameter.
    fn split<'e, T: Copy>(&self, e: &'e [T]) -> (&'e [T], impl Iterator<Item = (Term, T)>) {
        let (own, more) = e.split_at(self.inner.params().len().min(e.len()));
        let terms = self.terms.iter().copied().zip(more.iter().copied());
        (own, terms)
    }

    /// Magnitudes at a contact.
    fn at_contact<T: Real>(&self, e: &[T], at: &Contact<T>) -> Vec<T> {
        let (own, terms) = self.split(e);
        let regime = &self.regime;
        let mut growth = T::zero();
        for (term, a) in terms {
            let slip = || Regime::slip(at.slip);
            let speed = || Regime::share(at.speed, regime.speed);
            let path = || regime.path(at.path);
            growth += a * match term {
                Term::Slip => slip(),
                Term::SlipBend => Regime::bend(slip()),
                Term::SlipNear => Regime::near_no_slip(at.slip),
                Term::Load => regime.load(at.normal_load),
                Term::Speed => speed(),
                Term::SpeedBend => Regime::bend(speed()),
                Term::Path => path(),
                Term::PathBend => Regime::bend(path()),
                Term::PathTwist => Regime::twist(path()),
                Term::Aside => at.slip_angle.abs() * 4.0 - 1.0,
                Term::Passes => at.earlier_passes - 1.0,
                _ => continue,
            };
        }
        grown(own, growth)
    }
}

/// The first magnitude is the effect's size.
fn grown<T: Real>(own: &[T], growth: T) -> Vec<T> {
    let mut out = own.to_vec();
    if let Some(first) = out.first_mut() {
        *first *= growth.exp();
    }
    out
}

impl FreeForm {
    fn before<T: Real>(
        &self,
        inner: &dyn EffectAt<T>,
        e: &[T],
        soil: &Soil<T>,
        at: &mut Contact<T>,
    ) {
        let before = at.hooks;
        let own = self.at_contact(e, at);
        inner.alter_contact(&own, soil, at);
        let hooks = &mut at.hooks;
        let action = [
            hooks.stiffness / before.stiffness,
            hooks.cohesion / before.cohesion,
            hooks.friction / before.friction,
            hooks.shear_modulus / before.shear_modulus,
            hooks.contact_radius / before.contact_radius,
        ]
        .into_iter()
        .fold(T::zero(), |sum, factor| sum + factor.ln());
        for (term, b) in self.split(e).1 {
            let factor = || (b * action).exp();
            match term {
                Term::Stiffness => hooks.stiffness *= factor(),
                Term::Cohesion => hooks.cohesion *= factor(),
                Term::Friction => hooks.friction *= factor(),
                Term::ShearModulus => hooks.shear_modulus *= factor(),
                _ => {}
            }
        }
    }

    fn after<T: Real>(
        &self,
        inner: &dyn EffectAt<T>,
        e: &[T],
        soil: &Soil<T>,
        at: &Contact<T>,
        forces: &mut WheelForces<T>,
    ) {
        let (torque, side_force) = (forces.resistive_torque, forces.lateral_force);
        inner.alter_forces(&self.at_contact(e, at), soil, at, forces);
        for (term, c) in self.split(e).1 {
            match term {
                Term::Torque => {
                    let action = forces.resistive_torque - torque;
                    forces.resistive_torque += action * c.exp_m1();
                }
                Term::SideForce => {
                    let action = forces.lateral_force - side_force;
                    forces.lateral_force += action * c.exp_m1();
                }
                _ => {}
            }
        }
    }

    fn loads<T: Real>(
        &self,
        inner: &dyn EffectAt<T>,
        e: &[T],
        vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        loads: BodyLoads<T>,
    ) -> BodyLoads<T> {
        let regime = &self.regime;
        let (own, terms) = self.split(e);
        let mut growth = T::zero();
        let mut each = [T::zero(); 4];
        let mut offset = None;
        for (term, a) in terms {
            let speed = || Regime::share(motion.speed, regime.speed);
            let path = || regime.path(motion.path);
            match term {
                Term::Speed => growth += a * speed(),
                Term::SpeedBend => growth += a * Regime::bend(speed()),
                Term::Path => growth += a * path(),
                Term::PathBend => growth += a * Regime::bend(path()),
                Term::PathTwist => growth += a * Regime::twist(path()),
                Term::Offset => offset = Some(a),
                Term::WheelTorque => {
                    for (sum, v) in each.iter_mut().zip(motion.wheel_torque) {
                        *sum += a * Regime::share(v, regime.torque);
                    }
                }
                Term::WheelSpeed => {
                    for (sum, v) in each.iter_mut().zip(motion.wheel_speed) {
                        *sum += a * Regime::share(v, regime.wheel_speed);
                    }
                }
                _ => {}
            }
        }
        let mut out = inner.loads_at(&grown(own, growth), vehicle, motion, loads);
        for (q, more) in each.into_iter().enumerate() {
            let action = out.wheel_torque[q] - loads.wheel_torque[q];
            out.wheel_torque[q] += action * more.exp_m1();
        }
        if let Some(a) = offset {
            // What the effect does in the middle of the log's speeds, straight ahead.
            let speed = T::from(0.5 * regime.speed);
            let middle = Motion {
                speed,
                acceleration: T::zero(),
                yaw_rate: T::zero(),
                wheel_speed: [speed / vehicle.wheel_radius; 4],
                wheel_torque: [T::zero(); 4],
                path: T::from(regime.path),
                time: motion.time,
            };
            let there = inner.loads_at(own, vehicle, &middle, BodyLoads::none());
            out.force_x += a * there.force_x;
            out.yaw_moment += a * there.yaw_moment;
            for q in 0..4 {
                out.wheel_torque[q] += a * there.wheel_torque[q];
            }
        }
        out
    }
}

impl FreeForm {
    fn report<T: Real>(
        &self,
        inner: &dyn EffectAt<T>,
        e: &[T],
        channel: Channel,
        truth: T,
        rate: T,
    ) -> T {
        let (own, terms) = self.split(e);
        let mut growth = T::zero();
        for (term, a) in terms {
            let share = || Regime::share(truth, self.regime.torque);
            match (term, channel) {
                (Term::WheelTorque, Channel::WheelTorque) => growth += a * share(),
                (Term::WheelTorqueBend, Channel::WheelTorque) => {
                    growth += a * Regime::bend(share());
                }
                _ => {}
            }
        }
        inner.report_at(&grown(own, growth), channel, truth, rate)
    }
}

macro_rules! at_scalars {
    ($($scalar:ty),*) => {$(
        impl EffectAt<$scalar> for FreeForm {
            fn alter_contact(
                &self,
                e: &[$scalar],
                soil: &Soil<$scalar>,
                at: &mut Contact<$scalar>,
            ) {
                self.before::<$scalar>(&*self.inner, e, soil, at);
            }
            fn alter_forces(
                &self,
                e: &[$scalar],
                soil: &Soil<$scalar>,
                at: &Contact<$scalar>,
                forces: &mut WheelForces<$scalar>,
            ) {
                self.after::<$scalar>(&*self.inner, e, soil, at, forces);
            }
            fn vehicle_at(&self, e: &[$scalar], vehicle: Vehicle<$scalar>) -> Vehicle<$scalar> {
                self.inner.vehicle_at(self.split(e).0, vehicle)
            }
            fn loads_at(
                &self,
                e: &[$scalar],
                vehicle: &Vehicle<$scalar>,
                motion: &Motion<$scalar>,
                loads: BodyLoads<$scalar>,
            ) -> BodyLoads<$scalar> {
                self.loads(&*self.inner, e, vehicle, motion, loads)
            }
            fn report_at(
                &self,
                e: &[$scalar],
                channel: Channel,
                truth: $scalar,
                rate: $scalar,
            ) -> $scalar {
                self.report(&*self.inner, e, channel, truth, rate)
            }
        }
    )*};
}
at_scalars!(f64, Dual8, Lanes, LaneDual);

impl AnyEffect for FreeForm {
    fn name(&self) -> &'static str {
        self.inner.name()
    }
    fn form(&self) -> &'static str {
        FREE
    }
    fn summary(&self) -> &'static str {
        self.inner.summary()
    }
    fn params(&self) -> &[Param] {
        &self.params
    }
    fn equation(&self) -> &'static str {
        ""
    }
    fn reference(&self) -> &'static str {
        self.inner.reference()
    }
    fn needs(&self) -> &'static [Hook] {
        self.inner.needs()
    }
    fn needs_soil(&self) -> &'static [&'static str] {
        self.inner.needs_soil()
    }
    fn touches(&self) -> &'static [Touch] {
        self.inner.touches()
    }
    fn channels(&self) -> &'static [Channel] {
        self.inner.channels()
    }
    fn late(&self) -> Late {
        self.inner.late()
    }
    fn is_flat(&self) -> bool {
        self.inner.is_flat()
    }
    fn reads(&self) -> &'static [Circumstance] {
        self.inner.reads()
    }
    fn beside_slip_and_load(&self) -> Option<Vec<Circumstance>> {
        let mut beside = self.inner.beside_slip_and_load()?;
        beside.extend(self.terms.iter().filter_map(|term| match term {
            Term::Speed | Term::SpeedBend => Some(Circumstance::Speed),
            Term::Path | Term::PathBend | Term::PathTwist => Some(Circumstance::Path),
            Term::Aside => Some(Circumstance::SlipAngle),
            Term::Passes => Some(Circumstance::EarlierPasses),
            _ => None,
        }));
        Some(beside)
    }
    fn scope(&self) -> Scope {
        self.inner.scope()
    }
    fn regime(&self) -> &'static str {
        self.inner.regime()
    }
    fn isolated_by(&self) -> &'static str {
        self.inner.isolated_by()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terra_model::{Law, ModelError, Registry};

    const REGIME: Regime = Regime {
        load: 250.0,
        speed: 1.2,
        path: 20.0,
        torque: 40.0,
        wheel_speed: 5.0,
    };

    const NO_SOIL: Soil<f64> = Soil {
        cohesion: None,
        friction_angle: None,
        stiffness: None,
        sinkage_exponent: None,
        shear_modulus: None,
    };

    fn contact() -> Contact<f64> {
        let mut at = Contact::new(0.25, 230.0, 0.25, 0.15);
        (at.speed, at.wheel_speed, at.slip_angle) = (0.6, 3.2, 0.2);
        (at.path, at.side, at.wheelbase, at.earlier_passes) = (7.0, 1.0, 0.6, 1.0);
        at
    }

    fn sand(law: &Law) -> Result<Vec<f64>, ModelError> {
        terra_model::catalogue::find("dry_sand")?.parameters(law.model())
    }

    /// The library's own formula is exactly the free one with every term at zero, wherever the effect acts.
    #[test]
    fn no_terms_change_nothing() {
        let registry = Registry::builtin().with_forms();
        let base = registry.law("wong-reece").unwrap();
        let hooks = base.model().hooks();
        let soil = sand(&base).unwrap();
        let mut tried = 0;
        for effect in registry.effects() {
            let terms = Term::of(&**effect, hooks);
            let Ok(law) = base.with_effects([Arc::clone(effect)]) else {
                continue;
            };
            let free = FreeForm::new(Arc::clone(effect), REGIME, terms.clone());
            let reshaped = base
                .with_effects([Arc::new(free) as Arc<dyn AnyEffect>])
                .unwrap();
            let mut p = soil.clone();
            p.extend(effect.params().iter().map(|p| p.prior_sd.min(p.max)));
            let plain = law.forces_at(&p, &contact());
            p.extend(terms.iter().map(|_| 0.0));
            let same = reshaped.forces_at(&p, &contact());
            let numbers = |f: Result<WheelForces<f64>, ModelError>| {
                f.ok().map(|f| {
                    let pull = (f.drawbar_pull, f.resistive_torque, f.lateral_force);
                    (pull, f.sinkage)
                })
            };
            let name = (effect.name(), effect.form());
            assert_eq!(numbers(plain), numbers(same), "{name:?}");
            tried += usize::from(!terms.is_empty());
        }
        assert!(tried > 25, "{tried}");
    }

    /// By hand: k |v|^m with m = e exp(a φ), φ = 2 v/v_max - 1.
    #[test]
    fn a_term_grows_the_magnitude() {
        let registry = Registry::builtin();
        let rate = registry.effect("rate-stiffening").unwrap();
        let free = FreeForm::new(rate, REGIME, vec![Term::Speed, Term::Cohesion]);
        let e = [0.3, 0.7, 0.2];
        let at = EffectAt::<f64>::before_at(&free, &e, &NO_SOIL, contact());
        let m = 0.3 * (0.7 * (2.0 * 0.6 / 1.2 - 1.0f64)).exp();
        let stiffness = 0.6f64.powf(m);
        assert!((at.hooks.stiffness - stiffness).abs() < 1e-14);
        assert!((at.hooks.cohesion - stiffness.powf(0.2)).abs() < 1e-14);
    }

    /// A straight line has one formula: scales, offsets and measures have no terms, a bent instrument has one.
    #[test]
    fn instruments_and_measures_have_no_other_formula() {
        let registry = Registry::builtin();
        let hooks = registry.law("wong-reece").unwrap().model().hooks().to_vec();
        let terms = |name: &str| Term::of(&*registry.effect(name).unwrap(), &hooks);
        for exact in [
            "torque-scale",
            "torque-bias",
            "ground-speed-scale",
            "wheel-radius-error",
            "track-width-error",
            "mass-error",
            "cg-offset",
            "slope",
            "accel-bias",
            "load-error",
        ] {
            assert!(terms(exact).is_empty(), "{exact} {:?}", terms(exact));
        }
        assert_eq!(
            terms("torque-droop"),
            [Term::WheelTorque, Term::WheelTorqueBend]
        );
        assert!(terms("slip-sinkage").contains(&Term::Slip));
        assert!(terms("tow-load").contains(&Term::Offset));
    }

    /// What grows with passes, path, slip angle or speed is another cause by another name, unless that is what the effect acts
    /// by: bulldozed soil that appears on the second pass only is `multipass`.
    #[test]
    fn an_effect_varies_with_what_it_acts_by() {
        let registry = Registry::builtin().with_forms();
        let hooks = registry.law("wong-reece").unwrap().model().hooks().to_vec();
        let may = |term: Term| {
            let all = registry.effects().iter();
            let of_ground = all.filter(|e| {
                let touches = e.touches();
                touches.contains(&Touch::Contact) || touches.contains(&Touch::Forces)
            });
            let mut names: Vec<&str> = of_ground
                .filter(|e| Term::of(&***e, &hooks).contains(&term))
                .map(|e| e.name())
                .collect();
            names.sort_unstable();
            names.dedup();
            names
        };
        assert_eq!(may(Term::Passes), ["multipass"]);
        assert_eq!(may(Term::Path), ["terrain-drift"]);
        assert_eq!(may(Term::Speed), ["rate-stiffening"]);
        assert_eq!(
            may(Term::Aside),
            ["lateral-bulldozing", "skid-steer-lateral-slip"]
        );
        assert!(may(Term::Slip).len() > 10 && may(Term::Load).len() > 10);
    }
}
