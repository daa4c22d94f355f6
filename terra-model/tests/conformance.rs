//! Everything registered conforms, and what does not conform is found out.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::sync::Arc;

use terra_model::conformance::{
    check_effect, check_effect_dyn, check_model, check_model_dyn, check_model_with, check_pair,
};
use terra_model::models::Slots;
use terra_model::{
    AnyEffect, AnyModel, Channel, Circumstance, Contact, Effect, ForceLaw, Hook, Law, ModelError,
    Param, Real, Registry, Scale, Soil, TerrainModel, Touch, WheelForces,
};

#[test]
fn every_model_conforms() {
    let registry = Registry::builtin();
    assert!(registry.models().len() >= 2);
    for model in registry.models().iter().chain(registry.named_models()) {
        let checked = check_model_dyn(&**model).unwrap_or_else(|e| panic!("{e}"));
        // A model that the catalogue knows no soils for is examined on its own few.
        let known = terra_model::catalogue::find("dry_sand")
            .unwrap()
            .parameters(&**model)
            .is_ok();
        let enough = if known { 1000 } else { 100 };
        assert!(checked.derivatives > enough, "{checked:?}");
    }
}

#[test]
fn every_effect_conforms() {
    let registry = Registry::builtin().with_forms();
    assert!(registry.effects().len() >= 34);
    for effect in registry.effects() {
        let checked = check_effect_dyn(&**effect).unwrap_or_else(|e| panic!("{e}"));
        assert!(checked.derivatives > 20, "{checked:?}");
    }
}

#[test]
fn every_pair_conforms() {
    let registry = Registry::builtin().with_forms();
    let (mut carried, mut other_forms) = (0, 0);
    for model in registry.models().iter().chain(registry.named_models()) {
        for effect in registry.effects() {
            let checked = check_pair(model, effect).unwrap_or_else(|e| panic!("{e}"));
            let on_the_wheel = effect
                .touches()
                .iter()
                .any(|t| matches!(t, Touch::Contact | Touch::Forces));
            if on_the_wheel && Law::new(model.clone(), vec![effect.clone()]).is_ok() {
                assert!(checked.derivatives > 0, "{checked:?}");
                if effect.form() == "default" {
                    carried += 1;
                } else {
                    other_forms += usize::from(model.name() == "wong-reece");
                }
            }
        }
    }
    // All 16 that act on the wheel go with the full wheel; the linear closed forms and Bekker's lack five hooks, columns
    // the exit and the sideways slip, Ding's form layer, hump and sideways slip; the wheel under a slip angle has a side force of its own. Two concern the rig and the radius alone,
    // and go with the models that know no soil. The braked wheel and the tyre have the hooks of the closed forms, grains
    // those of stiffness and radius: rate, contrast, compliance and those two.
    assert_eq!(
        carried,
        16 + 11 + 11 + 14 + 13 + 16 + 15 + 11 + 2 + 2 + (11 + 11 + 5)
    );
    // The full wheel carries every other form but those of a sensor and of the drivetrain.
    assert_eq!(other_forms, 25);
}

/// Every `nth` pair of a combination of slots and an effect on the wheel; how many of them go together.
fn pairs_of_slots(nth: usize) -> (usize, usize) {
    let registry = Registry::builtin().with_forms();
    let acts = |touch: &Touch| matches!(touch, Touch::Contact | Touch::Forces);
    let effects: Vec<_> = registry
        .effects()
        .iter()
        .filter(|e| e.touches().iter().any(acts))
        .collect();
    let models = Slots::combinations().map(|name| registry.model(name).unwrap());
    let pairs = models.flat_map(|m| effects.iter().map(move |e| (m.clone(), (*e).clone())));
    let (mut asked, mut carried) = (0, 0);
    for (model, effect) in pairs.step_by(nth) {
        let checked = check_pair(&model, &effect).unwrap_or_else(|e| panic!("{e}"));
        asked += 1;
        if Law::new(model, vec![effect]).is_ok() {
            // A wheel that does not sink to the layer feels nothing of it.
            let may_be_blind = checked.subject.ends_with("+layered-soil");
            assert!(may_be_blind || checked.derivatives > 0, "{checked:?}");
            carried += 1;
        }
    }
    (asked, carried)
}

/// Combinations of slots with effects on them: nothing at zero magnitude, right derivatives, or a typed refusal.
#[test]
fn some_combinations_conform_with_effects() {
    let (asked, carried) = pairs_of_slots(41);
    assert!(asked > 100 && carried > asked / 2, "{carried} of {asked}");
}

#[test]
#[ignore = "minutes"]
fn every_combination_conforms_with_every_effect() {
    let (asked, carried) = pairs_of_slots(1);
    println!("{carried} of {asked} pairs go together");
    assert!(carried > asked / 2, "{carried} of {asked}");
}

#[test]
fn every_effect_of_the_contract_is_registered() {
    let registry = Registry::builtin();
    for name in "slip-sinkage multipass grousers bulldozing rear-contact rate-stiffening shear-hump wheel-compliance \
        layered-soil interface-friction terrain-drift lateral-contrast lateral-bulldozing drivetrain-coulomb-friction \
        drivetrain-viscous-friction torque-scale torque-bias torque-droop wheel-radius-error track-width-error cg-offset \
        mass-error ground-speed-scale ground-speed-bias ground-speed-delay accel-bias slope tow-load aero-drag \
        skid-steer-lateral-slip load-error drawbar-gain drawbar-bias sinkage-bias"
        .split_whitespace()
    {
        registry.effect(name).unwrap();
    }
}

const STIFFNESS: Param = Param {
    name: "firmness",
    symbol: "q",
    unit: "N/m",
    min: 1.0,
    max: 1e6,
    scale: Scale::Log,
    prior_sd: 0.5,
    doc: "load a metre of sinkage",
};

/// A user's model in a few lines; `FAULT` plants one mistake.
#[derive(Default)]
struct Spring<const FAULT: u8>;

impl<const FAULT: u8> TerrainModel for Spring<FAULT> {
    const NAME: &'static str = "spring";
    const SUMMARY: &'static str = "a spring with Coulomb friction that saturates with slip";
    const PARAMS: &'static [Param] = &[STIFFNESS];
    const REFERENCE: &'static str = "this test";

    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        let load = at.normal_load;
        let mut thrust = load * 0.6 * (at.slip * 3.0).tanh();
        match FAULT {
            1 => thrust = at.slip.select_lt(T::zero(), thrust - load * 0.01, thrust),
            2 => thrust += T::from(5.0),
            3 => thrust = T::from_primal(thrust.primal()),
            4 => thrust += load * (at.slip - 0.7).sqrt() * 0.0,
            _ => {}
        }
        let resistance = load * load / p[0] / at.radius * 0.0 + load * 0.05;
        Ok(WheelForces::from_thrust(
            thrust,
            resistance,
            thrust * at.radius,
        ))
    }
}

#[test]
fn a_sound_model_of_a_user_passes() {
    let checked = check_model::<Spring<0>>().unwrap_or_else(|e| panic!("{e}"));
    assert!(
        checked.comparisons > 500 && checked.derivatives > 100,
        "{checked:?}"
    );
    check_model_with(&Spring::<0>, &[vec![2e3], vec![5e3], vec![2e4]]).unwrap();
}

#[test]
fn planted_mistakes_of_a_model_are_found() {
    let findings = |r: Result<_, terra_model::conformance::Failures>| r.unwrap_err().to_string();
    assert!(findings(check_model::<Spring<1>>()).contains("jump"));
    assert!(findings(check_model::<Spring<2>>()).contains("scaling"));
    assert!(findings(check_model::<Spring<3>>()).contains("derivative"));
    assert!(findings(check_model::<Spring<4>>()).contains("finite"));
}

/// A user's effect; `FAULT` plants one mistake.
#[derive(Default)]
struct Softer<const FAULT: u8>;

impl<const FAULT: u8> Effect for Softer<FAULT> {
    const NAME: &'static str = if FAULT == 4 { "Softer Soil" } else { "softer" };
    const SUMMARY: &'static str = "the soil is softer";
    const PARAMS: &'static [Param] = &[Param {
        name: "magnitude",
        symbol: "e",
        unit: "1",
        min: 0.0,
        max: 5.0,
        scale: Scale::Linear,
        prior_sd: 0.5,
        doc: "relative loss",
    }];
    const REFERENCE: &'static str = "this test";
    const NEEDS: &'static [Hook] = if FAULT == 1 { &[] } else { &[Hook::Stiffness] };
    const TOUCHES: &'static [Touch] = if FAULT == 2 {
        &[Touch::Contact, Touch::Forces]
    } else {
        &[Touch::Contact]
    };
    const REGIME: &'static str = "everywhere";
    const ISOLATED_BY: &'static str = "a plate test";
    const FLAT: bool = FAULT == 6 || FAULT == 7;

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        let nominal = if FAULT == 3 { 1.001 } else { 1.0 };
        let size = if FAULT == 5 || FAULT == 6 {
            e[0].squared()
        } else {
            e[0]
        };
        at.hooks.stiffness = at.hooks.stiffness / (size + nominal);
    }
}

/// An effect by the square of its magnitude that does not say that it is flat at zero is found, and so is one that says it and is
/// not: a screen by slopes would not see the first, and one by secants would ask the second for nothing.
#[test]
fn an_effect_without_a_slope_at_zero_says_so() {
    let model = Registry::builtin().model("wong-reece").unwrap();
    fn pair<const FAULT: u8>(model: &Arc<dyn AnyModel>) -> Result<(), String> {
        let effect: Arc<dyn AnyEffect> = Arc::new(Softer::<FAULT>);
        check_pair(model, &effect)
            .map(drop)
            .map_err(|e| e.to_string())
    }
    assert_eq!(pair::<0>(&model), Ok(()));
    assert!(pair::<5>(&model).unwrap_err().contains("flat"));
    assert_eq!(pair::<6>(&model), Ok(()));
    assert!(pair::<7>(&model).unwrap_err().contains("flat"));
}

#[test]
fn a_sound_effect_of_a_user_passes_and_planted_mistakes_are_found() {
    let checked = check_effect::<Softer<0>>().unwrap_or_else(|e| panic!("{e}"));
    assert!(checked.derivatives > 100, "{checked:?}");
    let findings = |r: Result<_, terra_model::conformance::Failures>| r.unwrap_err().to_string();
    assert!(findings(check_effect::<Softer<1>>()).contains("needs"));
    assert!(findings(check_effect::<Softer<2>>()).contains("touches"));
    assert!(findings(check_effect::<Softer<3>>()).contains("zero"));
    assert!(findings(check_effect::<Softer<4>>()).contains("kebab"));
}

/// Pull that falls with the path; `FAULT` plants one mistake.
#[derive(Default)]
struct Wears<const FAULT: u8>;

impl<const FAULT: u8> Effect for Wears<FAULT> {
    const NAME: &'static str = "wears";
    const SUMMARY: &'static str = "the treads wear";
    const PARAMS: &'static [Param] = &[Param {
        name: "magnitude",
        symbol: "e",
        unit: if FAULT == 1 { "furlong" } else { "1/m" },
        min: 0.0,
        max: if FAULT == 2 { 1.0 } else { 0.1 },
        scale: Scale::Linear,
        prior_sd: 0.05,
        doc: "share of the thrust lost on a metre",
    }];
    const REFERENCE: &'static str = "this test";
    const TOUCHES: &'static [Touch] = &[Touch::Forces];
    const READS: &'static [Circumstance] = match FAULT {
        3 => &[],
        4 => &[Circumstance::Path, Circumstance::Side],
        _ => &[Circumstance::Path],
    };
    const SHARE: f64 = if FAULT == 5 { 0.1 } else { 0.0 };
    const REGIME: &'static str = "late";
    const ISOLATED_BY: &'static str = "new treads";

    fn after<T: Real>(&self, e: &[T], _: &Soil<T>, at: &Contact<T>, f: &mut WheelForces<T>) {
        let worn = match FAULT {
            2 => e[0] / (T::one() - e[0]) * at.path,
            6 => e[0] * at.path * T::from_primal(at.slip.primal()),
            _ => e[0] * at.path,
        };
        let lost = f.parts.thrust * worn;
        f.parts.thrust -= lost;
        f.drawbar_pull -= lost;
    }
}

/// A gyroscope whose error grows with the square of its magnitude.
#[derive(Default)]
struct Bent<const FLAT: bool>;

impl<const FLAT: bool> Effect for Bent<FLAT> {
    const NAME: &'static str = "bent";
    const SUMMARY: &'static str = "the gyroscope is bent";
    const PARAMS: &'static [Param] = Softer::<0>::PARAMS;
    const REFERENCE: &'static str = "this test";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const CHANNELS: &'static [Channel] = &[Channel::YawRate];
    const FLAT: bool = FLAT;
    const REGIME: &'static str = "turning";
    const ISOLATED_BY: &'static str = "a turntable";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _: T) -> T {
        match channel {
            Channel::YawRate => truth * (T::one() + e[0].squared()),
            _ => truth,
        }
    }
}

/// What an effect says of itself is held against what it does.
#[test]
fn promises_that_are_not_kept_are_found() {
    fn told<E: Effect>() -> String {
        check_effect::<E>().map_or_else(|e| e.to_string(), |_| String::new())
    }
    assert_eq!(told::<Wears<0>>(), "");
    assert!(told::<Wears<1>>().contains("'furlong'"));
    assert!(told::<Wears<2>>().contains("an end of its range"));
    assert!(told::<Wears<3>>().contains("READS must have it"));
    assert!(told::<Wears<4>>().contains("READS has the side"));
    assert!(told::<Wears<5>>().contains("SHARE"));
    assert!(told::<Wears<6>>().contains("by slip"));
    assert_eq!(told::<Bent<true>>(), "");
    assert!(told::<Bent<false>>().contains("FLAT = true"));
}

/// Nothing illegal reaches a model: the law refuses it by name.
#[test]
fn a_law_refuses_what_is_out_of_range() {
    let law = Registry::builtin().law("wong-reece").unwrap();
    let p = terra_model::catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    let good = Contact::new(0.2, 245.25, 0.254, 0.15);
    law.forces(&p, &good).unwrap();
    for (name, bad) in [
        ("slip", Contact { slip: 1.01, ..good }),
        (
            "slip",
            Contact {
                slip: f64::NAN,
                ..good
            },
        ),
        (
            "normal_load",
            Contact {
                normal_load: 0.0,
                ..good
            },
        ),
        (
            "normal_load",
            Contact {
                normal_load: f64::INFINITY,
                ..good
            },
        ),
        (
            "radius",
            Contact {
                radius: -0.1,
                ..good
            },
        ),
        ("width", Contact { width: 0.0, ..good }),
        (
            "speed",
            Contact {
                speed: f64::NAN,
                ..good
            },
        ),
    ] {
        let Err(ModelError::Contact { quantity, .. }) = law.forces(&p, &bad) else {
            panic!("{name} accepted")
        };
        assert_eq!(quantity, name);
        assert!(law.jacobian(&p, &bad).is_err());
    }
    assert!(matches!(
        law.forces(&p[..7], &good),
        Err(ModelError::ParameterCount {
            expected: 8,
            found: 7,
            ..
        })
    ));
    let mut q = p.clone();
    q[3] = f64::NAN;
    assert!(matches!(
        law.forces(&q, &good),
        Err(ModelError::Parameter {
            parameter: "cohesion",
            ..
        })
    ));
}
