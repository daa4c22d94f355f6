//! Forms that change the wheel or its forces.

use terra_model::{
    Circumstance, Contact, Effect, Hook, Param, Real, Registry, Scope, Soil, Touch, WheelForces,
};

use super::soil::{REFERENCE, magnitude};

/// γ \[N/m³\].
const UNIT_WEIGHT: f64 = 15_000.0;

/// The contact area flattens under load: contact radius R (1 + e W/250 N).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LoadFlattening;

impl Effect for LoadFlattening {
    const NAME: &'static str = "wheel-compliance";
    const FORM: &'static str = "load-flattening";
    const SUMMARY: &'static str =
        "the contact flattens under load: contact radius R (1 + e W/250 N)";
    const PARAMS: &'static [Param] = &[magnitude("1", 0.0, 2.0)];
    const REFERENCE: &'static str = REFERENCE;
    const NEEDS: &'static [Hook] = &[Hook::ContactRadius];
    const TOUCHES: &'static [Touch] = &[Touch::Contact];
    const REGIME: &'static str = "as the library's form";
    const ISOLATED_BY: &'static str = "as the library's form";

    fn before<T: Real>(&self, e: &[T], _soil: &Soil<T>, at: &mut Contact<T>) {
        at.hooks.contact_radius *= e[0] * at.normal_load / 250.0 + 1.0;
    }
}

/// A form that acts on the forces and needs c and φ.
macro_rules! force_form {
    ($type:ident, $name:literal, $form:literal, $summary:literal, ($unit:literal, $max:expr), $scope:expr,
     $(reads $reads:ident,)? |$e:ident, $soil:ident, $at:ident, $forces:ident| $body:block) => {
        #[doc = $summary]
        #[derive(Clone, Copy, Debug, Default)]
        pub(super) struct $type;

        impl Effect for $type {
            const NAME: &'static str = $name;
            const FORM: &'static str = $form;
            const SUMMARY: &'static str = $summary;
            const PARAMS: &'static [Param] = &[magnitude($unit, 0.0, $max)];
            const REFERENCE: &'static str = REFERENCE;
            const NEEDS_SOIL: &'static [&'static str] = &["cohesion", "friction_angle"];
            const TOUCHES: &'static [Touch] = &[Touch::Forces];
            const READS: &'static [Circumstance] = &[$(Circumstance::$reads)?];
            const SCOPE: Scope = $scope;
            const REGIME: &'static str = "as the library's form";
            const ISOLATED_BY: &'static str = "as the library's form";

            fn after<T: Real>(
                &self,
                e: &[T],
                $soil: &Soil<T>,
                $at: &Contact<T>,
                $forces: &mut WheelForces<T>,
            ) {
                let $e = e[0];
                $body
            }
        }
    };
}

/// Force a width of the wedge that a plate of depth z pushes up at X = 45° - φ/2:
/// D1 (c z + γ z²/2), D1 = cot X + tan(X + φ) \[N/m\].
fn wedge<T: Real>(soil: &Soil<T>, forces: &WheelForces<T>) -> Option<T> {
    let (c, phi, z) = (soil.cohesion?, soil.friction_angle?, forces.sinkage?);
    let x = -phi * 0.5 + std::f64::consts::FRAC_PI_4;
    let d1 = T::one() / x.tan() + (x + phi).tan();
    Some(d1 * (c * z + z.squared() * (0.5 * UNIT_WEIGHT)))
}

force_form!(
    PassiveLug,
    "grousers",
    "passive-lug",
    "one lug of height e at a time pushes a Rankine wedge: H = b (γ e^2 Np/2 + 2 c e sqrt(Np)), D + H, T + H (R + e/2)",
    ("m", 0.1),
    Scope::Any,
    |e, soil, at, forces| {
        if let (Some(c), Some(phi)) = (soil.cohesion, soil.friction_angle) {
            let root = (phi * 0.5 + std::f64::consts::FRAC_PI_4).tan();
            let push = at.width
                * (root.squared() * e.squared() * (0.5 * UNIT_WEIGHT) + c * e * root * 2.0);
            // A lug that does not slip does not push.
            let push = push * (at.slip * 10.0).tanh();
            forces.drawbar_pull += push;
            forces.parts.lug_thrust += push;
            forces.resistive_torque += push * (at.radius + e * 0.5);
        }
    }
);

force_form!(
    WedgeAhead,
    "bulldozing",
    "wedge",
    "D - e b D1 (c z + γ z^2/2) (1 + |s|), D1 = cot X + tan(X + φ), X = 45° - φ/2",
    ("1", 20.0),
    Scope::Any,
    |e, soil, at, forces| {
        if let Some(push) = wedge(soil, forces) {
            let force = e * at.width * push * (at.slip.abs() + 1.0) * 0.5;
            forces.drawbar_pull -= force;
            forces.parts.bulldozing_resistance += force;
        }
    }
);

force_form!(
    WedgeAside,
    "lateral-bulldozing",
    "wedge",
    "side force .08 e L D1 (c z + γ z^2/2) tanh(tan β/.3)",
    ("1", 20.0),
    Scope::Drive,
    reads SlipAngle,
    |e, soil, at, forces| {
        if let Some(push) = wedge(soil, forces) {
            let share = (at.slip_angle.tan() / 0.3).tanh();
            forces.lateral_force -= e * 0.08 * at.wheelbase * push * share;
        }
    }
);

force_form!(
    FrictionEllipse,
    "skid-steer-lateral-slip",
    "friction-ellipse",
    "thrust and torque times cos ψ, side force - thrust sin ψ, tan ψ = e (1 - |s|) tan β/(|s| + .05)",
    ("1", 5.0),
    Scope::Any,
    reads SlipAngle,
    |e, _soil, at, forces| {
        let s = at.slip.abs();
        let tan = e * (-s + 1.0) * at.slip_angle.tan() / (s + 0.05);
        let cos = T::one() / (tan.squared() + 1.0).sqrt();
        let thrust = forces.parts.total_thrust();
        forces.drawbar_pull -= thrust * (-cos + 1.0);
        forces.parts.thrust *= cos;
        forces.parts.lug_thrust *= cos;
        forces.resistive_torque *= cos;
        forces.lateral_force -= thrust.abs() * cos * tan;
    }
);

pub(super) fn register(registry: Registry) -> Registry {
    registry
        .with_effect::<LoadFlattening>()
        .with_effect::<PassiveLug>()
        .with_effect::<WedgeAhead>()
        .with_effect::<WedgeAside>()
        .with_effect::<FrictionEllipse>()
}
