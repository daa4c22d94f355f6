//! A terrain model of one's own: firm ground with Coulomb friction that builds up with slip.

// An example may print, and may stop where it is wrong.
#![allow(clippy::print_stdout)]

use terra::model::{
    Contact, ForceLaw, ModelError, Param, Real, Registry, Scale, TerrainModel, WheelForces,
};

/// Firm ground: D = μ W (1 - e^(-s/s0)) - f W.
#[derive(Default)]
struct FirmGround;

const fn positive(name: &'static str, symbol: &'static str, doc: &'static str) -> Param {
    Param {
        name,
        symbol,
        unit: "1",
        min: 1e-3,
        max: 2.0,
        scale: Scale::Log,
        prior_sd: 0.3,
        doc,
    }
}

impl TerrainModel for FirmGround {
    const NAME: &'static str = "firm-ground";
    const SUMMARY: &'static str =
        "Coulomb friction that builds up with slip, and rolling resistance";
    const PARAMS: &'static [Param] = &[
        positive("friction", "μ", "friction coefficient"),
        positive(
            "slip_scale",
            "s0",
            "slip at which friction has built up by 63 %",
        ),
        positive("rolling_resistance", "f", "rolling resistance coefficient"),
    ];
    const REFERENCE: &'static str = "example";

    /// Dry, wet and loose: where a diagnosis starts, as no catalogue of soils knows these parameters.
    fn typical() -> Vec<Vec<f64>> {
        vec![
            vec![0.7, 0.05, 0.03],
            vec![0.4, 0.1, 0.03],
            vec![0.5, 0.2, 0.08],
        ]
    }

    fn wheel_forces<T: Real>(
        &self,
        p: &[T],
        at: &Contact<T>,
    ) -> Result<WheelForces<T>, ModelError> {
        let (friction, slip_scale, rolling) = (p[0], p[1], p[2]);
        // Odd in slip, so that braking pulls back.
        let built_up = -(-(at.slip.abs() / slip_scale)).exp_m1();
        let signed = at.slip.select_lt(T::zero(), -built_up, built_up);
        let thrust = friction * at.normal_load * signed;
        let resistance = rolling * at.normal_load;
        Ok(WheelForces::from_thrust(
            thrust,
            resistance,
            thrust * at.radius,
        ))
    }
}

fn main() {
    let registry = Registry::builtin().with_model::<FirmGround>();
    let law = registry.law("firm-ground").expect("registered above");
    let at = Contact::new(0.1, 200.0, 0.25, 0.15);
    let (forces, jacobian) = law.jacobian(&[0.7, 0.05, 0.03], &at).expect("legal values");
    println!("pull {:.1} N", forces.drawbar_pull);
    println!("d pull / d friction {:.1} N", jacobian[(0, 0)]);
}

#[test]
fn it_conforms() {
    terra::model::conformance::check_model::<FirmGround>().expect("conforms");
}

#[test]
fn its_derivative_is_exact() {
    let at = Contact::new(0.1, 200.0, 0.25, 0.15);
    let (_, jacobian) = FirmGround
        .jacobian(&[0.7, 0.05, 0.03], &at)
        .expect("legal values");
    // By hand: dD/dμ = W (1 - e^(-s/s0)).
    assert!((jacobian[(0, 0)] - 200.0 * (1.0 - (-2.0_f64).exp())).abs() < 1e-12);
}
