//! Forms that change the soil a wheel meets.

use terra_model::{
    Circumstance, Contact, Effect, Hook, Param, Real, Registry, Scale, Scope, Soil, Touch,
};

/// The magnitude of a form.
pub(super) const fn magnitude(unit: &'static str, min: f64, max: f64) -> Param {
    Param {
        name: "magnitude",
        symbol: "e",
        unit,
        min,
        max,
        scale: Scale::Linear,
        prior_sd: 1.0,
        doc: "size of the effect",
    }
}

pub(super) const REFERENCE: &str = "chosen form, different from the library's on purpose";

/// A form that acts on the contact: its constants and one function.
macro_rules! contact_form {
    ($type:ident, $name:literal, $form:literal, $summary:literal, ($unit:literal, $min:expr, $max:expr), $needs:expr, $scope:expr,
     $(reads $reads:ident,)? |$e:ident, $soil:ident, $at:ident| $body:block) => {
        #[doc = $summary]
        #[derive(Clone, Copy, Debug, Default)]
        pub(super) struct $type;

        impl Effect for $type {
            const NAME: &'static str = $name;
            const FORM: &'static str = $form;
            const SUMMARY: &'static str = $summary;
            const PARAMS: &'static [Param] = &[magnitude($unit, $min, $max)];
            const REFERENCE: &'static str = REFERENCE;
            const NEEDS: &'static [Hook] = $needs;
            const TOUCHES: &'static [Touch] = &[Touch::Contact];
            const READS: &'static [Circumstance] = &[$(Circumstance::$reads)?];
            const SCOPE: Scope = $scope;
            const REGIME: &'static str = "as the library's form";
            const ISOLATED_BY: &'static str = "as the library's form";

            fn before<T: Real>(&self, e: &[T], $soil: &Soil<T>, $at: &mut Contact<T>) {
                let $e = e[0];
                $body
            }
        }
    };
}

contact_form!(
    SinkageFactor,
    "slip-sinkage",
    "sinkage-factor",
    "sinkage grows by ((1+|s|)/(1-.5|s|))^e: k falls by that factor to the power n + 1/2",
    ("1", 0.0, 6.0),
    &[Hook::Stiffness],
    Scope::Any,
    |e, soil, at| {
        let s = at.slip.abs();
        let factor = (s + 1.0) / (-s * 0.5 + 1.0);
        let n = soil.sinkage_exponent.unwrap_or_else(T::one);
        at.hooks.stiffness *= (-(e * (n + 0.5) * factor.ln())).exp();
    }
);

contact_form!(
    RationalSoftening,
    "slip-sinkage",
    "rational-softening",
    "k / (1 + 3 e s^2 + e |s|)",
    ("1", 0.0, 6.0),
    &[Hook::Stiffness],
    Scope::Any,
    |e, _soil, at| {
        let s = at.slip.abs();
        at.hooks.stiffness = at.hooks.stiffness / (e * (s.squared() * 3.0 + s) + 1.0);
    }
);

contact_form!(
    LinearPasses,
    "multipass",
    "linear-passes",
    "M = e min(passes, 3)/3: k (1 + 1.5 M), tan φ (1 + .2 M)",
    ("1", 0.0, 10.0),
    &[Hook::Stiffness, Hook::Friction],
    Scope::Any,
    reads EarlierPasses,
    |e, _soil, at| {
        let passes = at.earlier_passes.min_of(T::from(3.0)).max_of(T::zero());
        let gain = e * passes / 3.0;
        at.hooks.stiffness *= gain * 1.5 + 1.0;
        at.hooks.friction *= gain * 0.2 + 1.0;
    }
);

contact_form!(
    ReleasedBySlip,
    "rear-contact",
    "released-by-slip",
    "θ2 = -e (1 - |s|) θ1: the rebound is sheared off by slip",
    ("1", 0.0, 0.95),
    &[Hook::ExitRatio],
    Scope::Any,
    |e, _soil, at| {
        at.hooks.exit_ratio += e * (-at.slip.abs() + 1.0);
    }
);

contact_form!(
    LogarithmicRate,
    "rate-stiffening",
    "logarithmic",
    "k (1 + e ln((|v| + .05 m/s)/(1.05 m/s))), not below a tenth",
    ("1", -2.0, 2.0),
    &[Hook::Stiffness],
    Scope::Any,
    |e, _soil, at| {
        let gain = e * ((at.speed.abs() + 0.05) / 1.05).ln() + 1.0;
        at.hooks.stiffness *= gain.max_of(T::from(0.1));
    }
);

contact_form!(
    SofteningStrength,
    "shear-hump",
    "softening-strength",
    "c and tan φ (1 + e (|s|/.15) exp(1 - |s|/.15))",
    ("1", 0.0, 5.0),
    &[Hook::Cohesion, Hook::Friction],
    Scope::Any,
    |e, _soil, at| {
        let x = at.slip.abs() / 0.15;
        let gain = e * x * (-x + 1.0).exp() + 1.0;
        at.hooks.cohesion *= gain;
        at.hooks.friction *= gain;
    }
);

contact_form!(
    LoadHardening,
    "layered-soil",
    "load-hardening",
    "a hard pan felt by heavy wheels: k (1 + e W^2/(W^2 + (500 N)^2))",
    ("1", 0.0, 20.0),
    &[Hook::Stiffness],
    Scope::Any,
    |e, _soil, at| {
        let w = at.normal_load.squared();
        at.hooks.stiffness *= e * (w / (w + 250_000.0)) + 1.0;
    }
);

contact_form!(
    PartialRim,
    "interface-friction",
    "adhesion-first",
    "a rim that slides before the soil shears: c (1 - e), tan φ (1 - e/2), K/(1 + e)",
    ("1", 0.0, 0.99),
    &[Hook::Cohesion, Hook::Friction, Hook::ShearModulus],
    Scope::Any,
    |e, _soil, at| {
        at.hooks.cohesion *= -e + 1.0;
        at.hooks.friction *= -e * 0.5 + 1.0;
        at.hooks.shear_modulus = at.hooks.shear_modulus / (e + 1.0);
    }
);

contact_form!(
    LogisticFront,
    "terrain-drift",
    "logistic-front",
    "a front at 4 m: k exp(e g), c exp(e g/2), g = tanh((x - 4 m)/1.5 m) + tanh(4/1.5)",
    ("1", -3.0, 3.0),
    &[Hook::Stiffness, Hook::Cohesion],
    Scope::Any,
    reads Path,
    |e, _soil, at| {
        let front = ((at.path - 4.0) / 1.5).tanh() + (4.0f64 / 1.5).tanh();
        let gain = e * front;
        at.hooks.stiffness *= gain.exp();
        at.hooks.cohesion *= (gain * 0.5).exp();
    }
);

contact_form!(
    StrengthContrast,
    "lateral-contrast",
    "strength-contrast",
    "right + and left -: c exp(±e/2), tan φ exp(±e/6)",
    ("1", -5.0, 5.0),
    &[Hook::Cohesion, Hook::Friction],
    Scope::Drive,
    reads Side,
    |e, _soil, at| {
        let gain = e * at.side;
        at.hooks.cohesion *= (gain * 0.5).exp();
        at.hooks.friction *= (gain / 6.0).exp();
    }
);

pub(super) fn register(registry: Registry) -> Registry {
    registry
        .with_effect::<SinkageFactor>()
        .with_effect::<RationalSoftening>()
        .with_effect::<LinearPasses>()
        .with_effect::<ReleasedBySlip>()
        .with_effect::<LogarithmicRate>()
        .with_effect::<SofteningStrength>()
        .with_effect::<LoadHardening>()
        .with_effect::<PartialRim>()
        .with_effect::<LogisticFront>()
        .with_effect::<StrengthContrast>()
}
