//! Priors of magnitudes with a unit, on another wheel than they were chosen for.
//!
//! An offset of 2 N is much for the load cell of a small rig, and nothing for one that carries 2000 N. An effect may say what
//! [share](terra_model::AnyEffect::share) of a wheel's own size its prior sd is.
//!
//! # Equation
//! With g = share x natural size / the library's sd, that sd is multiplied by g on a larger wheel, g > 1, and by sqrt(g) on a smaller
//! one: the sensors and gears of small wheels are relatively worse.

use std::sync::Arc;

use terra_data::Rover;
use terra_model::{
    AnyEffect, BodyLoads, Channel, Circumstance, Contact, EffectAt, Hook, Late, Motion, Param,
    Real, Scope, Soil, Touch, Vehicle, WheelForces, natural_size, order::ascending,
};

use crate::dataset::DataSet;
use crate::settings::LogKind;

/// Share by which a wheel's prior may differ from the library's and still be that.
const ALIKE: f64 = 0.02;

/// The wheel of a log.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WheelSize {
    /// What it carries \[N\]: the median of a log.
    load: f64,
    /// Its radius \[m\].
    radius: f64,
}

impl WheelSize {
    /// That of a log; 0 where it has no loads.
    pub(crate) fn of(data: &DataSet, rover: &Rover, kind: LogKind) -> Self {
        let each = data.observations.iter();
        let mut loads: Vec<f64> = each
            .filter_map(|o| o.factors.get("load").copied())
            .collect();
        ascending(&mut loads, |w| *w);
        let median = loads.get(loads.len() / 2).copied().unwrap_or(0.0);
        let wheels = match kind {
            LogKind::Rig => 1.0,
            LogKind::Drive | LogKind::Kinematic => 4.0,
        };
        WheelSize {
            load: median / wheels,
            radius: rover.wheel.radius,
        }
    }

    /// The effect with the prior that it has on this wheel.
    pub(crate) fn suits(self, effect: Arc<dyn AnyEffect>) -> Arc<dyn AnyEffect> {
        let sd = |p: &Param| {
            let natural = natural_size(p.unit, self.load, self.radius)?;
            let times = effect.share() * natural / p.prior_sd;
            let other = times > 0.0 && (times - 1.0).abs() > ALIKE;
            other.then(|| p.prior_sd * if times > 1.0 { times } else { times.sqrt() })
        };
        match effect.params().split_first() {
            Some((first, rest)) => match sd(first) {
                Some(prior_sd) => {
                    let mut params = vec![Param { prior_sd, ..*first }];
                    params.extend_from_slice(rest);
                    Arc::new(Suited { effect, params })
                }
                None => effect,
            },
            None => effect,
        }
    }
}

/// An effect with another prior.
struct Suited {
    effect: Arc<dyn AnyEffect>,
    params: Vec<Param>,
}

impl<T: Real> EffectAt<T> for Suited
where
    dyn AnyEffect: EffectAt<T>,
{
    fn alter_contact(&self, e: &[T], soil: &Soil<T>, at: &mut Contact<T>) {
        self.effect.alter_contact(e, soil, at);
    }
    fn alter_forces(&self, e: &[T], soil: &Soil<T>, at: &Contact<T>, forces: &mut WheelForces<T>) {
        self.effect.alter_forces(e, soil, at, forces);
    }
    fn vehicle_at(&self, e: &[T], vehicle: Vehicle<T>) -> Vehicle<T> {
        self.effect.vehicle_at(e, vehicle)
    }
    fn loads_at(
        &self,
        e: &[T],
        vehicle: &Vehicle<T>,
        motion: &Motion<T>,
        loads: BodyLoads<T>,
    ) -> BodyLoads<T> {
        self.effect.loads_at(e, vehicle, motion, loads)
    }
    fn report_at(&self, e: &[T], channel: Channel, truth: T, rate: T) -> T {
        self.effect.report_at(e, channel, truth, rate)
    }
}

impl AnyEffect for Suited {
    fn name(&self) -> &'static str {
        self.effect.name()
    }
    fn form(&self) -> &'static str {
        self.effect.form()
    }
    fn summary(&self) -> &'static str {
        self.effect.summary()
    }
    fn params(&self) -> &[Param] {
        &self.params
    }
    fn equation(&self) -> &'static str {
        self.effect.equation()
    }
    fn reference(&self) -> &'static str {
        self.effect.reference()
    }
    fn needs(&self) -> &'static [Hook] {
        self.effect.needs()
    }
    fn needs_soil(&self) -> &'static [&'static str] {
        self.effect.needs_soil()
    }
    fn touches(&self) -> &'static [Touch] {
        self.effect.touches()
    }
    fn reads(&self) -> &'static [Circumstance] {
        self.effect.reads()
    }
    fn beside_slip_and_load(&self) -> Option<Vec<Circumstance>> {
        self.effect.beside_slip_and_load()
    }
    fn channels(&self) -> &'static [Channel] {
        self.effect.channels()
    }
    fn late(&self) -> Late {
        self.effect.late()
    }
    fn is_flat(&self) -> bool {
        self.effect.is_flat()
    }
    fn share(&self) -> f64 {
        self.effect.share()
    }
    fn scope(&self) -> Scope {
        self.effect.scope()
    }
    fn regime(&self) -> &'static str {
        self.effect.regime()
    }
    fn isolated_by(&self) -> &'static str {
        self.effect.isolated_by()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terra_model::Registry;

    fn sd(effect: &Arc<dyn AnyEffect>) -> f64 {
        effect.params()[0].prior_sd
    }

    /// On the wheel that the priors were chosen for all are the library's but for the load cell's. On one that is twice as large and
    /// carries eight times as much those with a unit of force, torque or length are larger, as that unit is; on one smaller by so
    /// much they are smaller by its root; others are the same.
    #[test]
    fn priors_suit_the_wheel() {
        let library = Registry::builtin().with_forms();
        let chosen_for = WheelSize {
            load: 245.25,
            radius: 0.254,
        };
        let small = WheelSize {
            load: 245.25 / 8.0,
            radius: 0.127,
        };
        let large = WheelSize {
            load: 8.0 * 245.25,
            radius: 2.0 * 0.254,
        };
        let mut followed = 0;
        for effect in library.effects() {
            let own = sd(effect);
            let on = |size: WheelSize| sd(&size.suits(Arc::clone(effect)));
            if effect.name() == "drawbar-bias" {
                assert!((on(chosen_for) - 0.02 * 245.25).abs() < 1e-12);
                continue;
            }
            assert_eq!(on(chosen_for), own, "{}", effect.name());
            let times = match effect.params()[0].unit {
                "N" | "N s²/m²" => 8.0,
                "N m" => 16.0,
                "N m s" => 32.0,
                "N m s^(2/3)" => 8.0 * 2f64.powf(5.0 / 3.0),
                "m" => 2.0,
                _ => 1.0,
            };
            followed += usize::from(times > 1.0);
            let (more, less) = (on(large) / own / times, own / on(small) / times.sqrt());
            for found in [more, less] {
                let form = effect.form();
                assert!(
                    (found - 1.0).abs() < 0.02,
                    "{} {form} {found}",
                    effect.name()
                );
            }
        }
        assert!(followed >= 10, "{followed}");
    }
}
