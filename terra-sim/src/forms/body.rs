//! Forms that act on drivetrain, body or instruments.

use terra_model::{
    BodyLoads, Channel, Effect, Motion, Param, Real, Registry, Scope, Touch, Vehicle,
};

use super::soil::{REFERENCE, magnitude};

/// A form that acts through loads on body or drivetrain.
macro_rules! load_form {
    ($type:ident, $name:literal, $form:literal, $summary:literal, ($unit:literal, $max:expr), $scope:expr,
     |$e:ident, $motion:ident, $loads:ident| $body:block) => {
        #[doc = $summary]
        #[derive(Clone, Copy, Debug, Default)]
        pub(super) struct $type;

        impl Effect for $type {
            const NAME: &'static str = $name;
            const FORM: &'static str = $form;
            const SUMMARY: &'static str = $summary;
            const PARAMS: &'static [Param] = &[magnitude($unit, 0.0, $max)];
            const REFERENCE: &'static str = REFERENCE;
            const TOUCHES: &'static [Touch] = &[Touch::Loads];
            const SCOPE: Scope = $scope;
            const REGIME: &'static str = "as the library's form";
            const ISOLATED_BY: &'static str = "as the library's form";

            fn loads<T: Real>(
                &self,
                e: &[T],
                _vehicle: &Vehicle<T>,
                $motion: &Motion<T>,
                mut $loads: BodyLoads<T>,
            ) -> BodyLoads<T> {
                let $e = e[0];
                $body
                $loads
            }
        }
    };
}

load_form!(
    LoadedCoulomb,
    "drivetrain-coulomb-friction",
    "loaded-gears",
    "friction of loaded gears: e (.5 + .5 min(|T|/20 N m, 2)) tanh(w/.1)",
    ("N m", 50.0),
    Scope::Any,
    |e, motion, loads| {
        for (q, torque) in loads.wheel_torque.iter_mut().enumerate() {
            let share = (motion.wheel_torque[q].abs() / 20.0).min_of(T::from(2.0));
            *torque += e * (share * 0.5 + 0.5) * (motion.wheel_speed[q] * 10.0).tanh();
        }
    }
);

load_form!(
    RootViscous,
    "drivetrain-viscous-friction",
    "square-root",
    "shear-thinning grease: e w/sqrt(1 + |w|/(1 rad/s))",
    ("N m s", 50.0),
    Scope::Any,
    |e, motion, loads| {
        for (torque, w) in loads.wheel_torque.iter_mut().zip(motion.wheel_speed) {
            *torque += e * w / (w.abs() + 1.0).sqrt();
        }
    }
);

load_form!(
    FallingTow,
    "tow-load",
    "falling-with-speed",
    "a dragged load that planes up: ΣF - e tanh(v/.05)/(1 + |v|/(1 m/s))",
    ("N", 2000.0),
    Scope::Drive,
    |e, motion, loads| {
        let v = motion.speed;
        loads.force_x -= e * (v / 0.05).tanh() / (v.abs() + 1.0);
    }
);

load_form!(
    Headwind,
    "aero-drag",
    "headwind",
    "drag in a wind of .5 m/s from ahead: ΣF - e (v + .5)|v + .5|",
    ("N/(m/s)^2", 500.0),
    Scope::Drive,
    |e, motion, loads| {
        let air = motion.speed + 0.5;
        loads.force_x -= e * air * air.abs();
    }
);

/// The logged torque is too large in proportion to itself: T_rep = T (1 + e |T|/60 N m).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LinearDroop;

impl Effect for LinearDroop {
    const NAME: &'static str = "torque-droop";
    const FORM: &'static str = "linear";
    const SUMMARY: &'static str = "T_rep = T (1 + e |T|/60 N m)";
    const PARAMS: &'static [Param] = &[magnitude("1", 0.0, 10.0)];
    const REFERENCE: &'static str = REFERENCE;
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const REGIME: &'static str = "as the library's form";
    const ISOLATED_BY: &'static str = "as the library's form";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::WheelTorque {
            truth * (e[0] * (truth.abs() / 60.0) + 1.0)
        } else {
            truth
        }
    }
}

pub(super) fn register(registry: Registry) -> Registry {
    registry
        .with_effect::<LoadedCoulomb>()
        .with_effect::<RootViscous>()
        .with_effect::<LinearDroop>()
        .with_effect::<FallingTow>()
        .with_effect::<Headwind>()
}
