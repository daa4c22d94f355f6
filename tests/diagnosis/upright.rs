//! Logs of a simulator whose vehicle stays upright in turns, where a real one leans on its outer wheels.

use terra::gap::Diagnosis;
use terra::sim::EffectSetting;

use crate::turning::diagnosed;
use crate::vehicle::effect;

/// The example's drive and two turns with these effects, by a vehicle that leans or not.
fn diagnosis(upright: bool, effects: Vec<EffectSetting>) -> Diagnosis {
    diagnosed([(3.2, 5.2), (5.6, 3.6)], effects, |scenario| {
        scenario.world.upright = upright;
    })
}

fn said(d: &Diagnosis) -> bool {
    d.heed.iter().any(|h| h.contains("stays upright"))
}

/// Where nothing else is missing nothing is named, and what was taken for granted is said only of the vehicle that stays upright.
#[test]
fn an_upright_vehicle_is_no_missing_effect() {
    for upright in [true, false] {
        let d = diagnosis(upright, vec![]);
        assert_eq!(d.verdict, "none", "{:?} {:?}", d.set, d.heed);
        assert_eq!(said(&d), upright, "{:?}", d.heed);
        let left = d.waterfall.refitted.unwrap();
        assert!((0.85..1.15).contains(&left), "{left}");
    }
}

/// An effect that shows in turns comes first on either vehicle, with its size.
#[test]
fn an_effect_in_turns_comes_first_on_either() {
    for upright in [true, false] {
        let d = diagnosis(upright, vec![effect(("track-width-error", 0.06))]);
        assert_eq!(d.causes[0].name, "track-width-error", "{:?}", d.set);
        assert_eq!(said(&d), upright, "{:?}", d.heed);
        let first = &d.causes[0].weighed;
        let fit = &first.fit.x;
        let sd = first.hypothesis.effects()[0].params()[0].prior_sd;
        let found = sd * fit[first.hypothesis.soil_len()];
        assert!((found - 0.06).abs() < 0.02, "{found}");
    }
}
