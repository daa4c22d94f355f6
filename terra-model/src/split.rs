//! From pull, torque and load to the one resultant with the same effect: thrust and resistance without a soil model.
//!
//! # Equation
//! The stresses on the rim are replaced by one tangential force F_t and one radial force F_r at one angle θ_f from the
//! downward vertical, forward positive:
//!
//! - F_t = T/R,   D = F_t cos θ_f - F_r sin θ_f,   W = F_t sin θ_f + F_r cos θ_f
//! - F_r = sqrt(D² + W² - F_t²) >= 0,   θ_f = atan2(F_t, F_r) - atan2(D, W)
//! - thrust = F_t cos θ_f,   resistance = F_r sin θ_f,   thrust - resistance = D
//!
//! The split is a function of (D, T, W) and holds no more information than they do. Against the integrals of the
//! Wong-Reece wheel thrust is off by .1 % of W in the median, and by up to 16 % for a wheel deep in snow.
//!
//! # Reference
//! L. E. Ray, "Autonomous terrain parameter estimation for wheeled vehicles", Proc. SPIE, 2008, eqs 8-12. Eq 12 is
//! printed with cos θ_f in the resistance; that would be a vertical force.

use crate::error::ModelError;
use crate::real::Real;

/// One radial and one tangential force at one angle, with thrust and resistance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resultant<T> {
    /// F_t \[N\], positive where the torque resists the drive.
    pub tangential_force: T,
    /// F_r \[N\], never negative.
    pub radial_force: T,
    /// θ_f \[rad\], from the downward vertical, forward positive.
    pub resultant_angle: T,
    /// F_t cos θ_f \[N\].
    pub thrust: T,
    /// F_r sin θ_f \[N\].
    pub resistance: T,
}

/// Splits drawbar pull D \[N\], resistive torque T \[N m\] and normal load W \[N\] on a wheel of radius R \[m\].
///
/// Any scalar, so that a covariance can be carried along; the derivatives grow without bound where F_r reaches zero.
///
/// # Errors
/// [`ModelError::NotAResultant`] when |T| > R hypot(D, W): no single contact point has these forces.
/// [`ModelError::Contact`] when R is not above zero, when a value is not finite, or when all three forces are zero
/// (then there is no angle).
///
/// # Reference
/// Ray 2008, eqs 9-12.
pub fn split<T: Real>(
    drawbar_pull: T,
    resistive_torque: T,
    normal_load: T,
    radius: T,
) -> Result<Resultant<T>, ModelError> {
    use crate::real::Root;
    let inputs = [
        ("drawbar_pull", drawbar_pull),
        ("resistive_torque", resistive_torque),
        ("normal_load", normal_load),
        ("radius", radius),
    ];
    for (quantity, value) in inputs {
        if !value.primal().is_finite() {
            let value = value.primal().min_lane();
            return Err(ModelError::Contact {
                quantity,
                value,
                expected: "a finite value",
            });
        }
    }
    if radius.primal().min_lane() <= 0.0 {
        let value = radius.primal().min_lane();
        return Err(ModelError::Contact {
            quantity: "radius",
            value,
            expected: "a radius above 0 m",
        });
    }
    let tangential_force = resistive_torque / radius;
    let total = drawbar_pull.squared() + normal_load.squared();
    let rest = total - tangential_force.squared();
    if rest.primal().any_lt(T::Primal::zero()) {
        return Err(ModelError::NotAResultant {
            torque: resistive_torque.primal().max_lane(),
            limit: (radius * total.sqrt()).primal().min_lane(),
        });
    }
    if total.primal().min_lane() <= 0.0 {
        return Err(ModelError::Contact {
            quantity: "normal_load",
            value: 0.0,
            expected: "a force to split",
        });
    }
    let radial_force = rest.sqrt();
    // cos θ_f and sin θ_f are the solution of the two linear equations for D and W; no angle is needed for the forces.
    let cos = (tangential_force * drawbar_pull + radial_force * normal_load) / total;
    let sin = (tangential_force * normal_load - radial_force * drawbar_pull) / total;
    Ok(Resultant {
        tangential_force,
        radial_force,
        resultant_angle: angle(sin, cos),
        thrust: tangential_force * cos,
        resistance: radial_force * sin,
    })
}

/// atan2 for a point on the unit circle, by the half angle that stays away from its pole: θ = 2 atan(s/(1 + c)) for
/// c >= 0, and π (with the sign of s) less that of the opposite point elsewhere.
fn angle<T: Real>(sin: T, cos: T) -> T {
    let front = (sin / (cos.abs() + 1.0)).atan() * 2.0;
    let half_turn = sin.select_lt(
        T::zero(),
        T::from(-std::f64::consts::PI),
        T::from(std::f64::consts::PI),
    );
    cos.select_lt(T::zero(), half_turn - front, front)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::Dual8;
    use approx::assert_relative_eq;

    /// F_t = 30 N, F_r = 40 N at the angle whose sine is 3/5: D = 30·.8 - 40·.6 = 0, W = 30·.6 + 40·.8 = 50.
    #[test]
    fn a_triangle_by_hand() {
        let r = split(0.0, 3.0, 50.0, 0.1).unwrap();
        assert_relative_eq!(r.tangential_force, 30.0, max_relative = 1e-15);
        assert_relative_eq!(r.radial_force, 40.0, max_relative = 1e-15);
        assert_relative_eq!(r.resultant_angle, 0.6_f64.asin(), max_relative = 1e-15);
        assert_relative_eq!(r.thrust, 24.0, max_relative = 1e-15);
        assert_relative_eq!(r.resistance, 24.0, max_relative = 1e-15);
    }

    #[test]
    fn forces_without_a_resultant_are_an_error_with_the_limit() {
        let Err(ModelError::NotAResultant { torque, limit }) = split(3.0, 0.6, 4.0, 0.1) else {
            panic!("expected no resultant");
        };
        assert_eq!(torque, 0.6);
        assert_relative_eq!(limit, 0.5, max_relative = 1e-15);
        assert!(split(3.0, 0.4999, 4.0, 0.1).is_ok());
        assert!(split(f64::NAN, 0.1, 4.0, 0.1).is_err());
        assert!(split(0.0, 0.0, 0.0, 0.1).is_err());
        assert!(split(1.0, 0.0, 1.0, 0.0).is_err());
    }

    /// The angle formula of the source, atan2(F_t, F_r) - atan2(D, W), in all quadrants of (D, W).
    #[test]
    fn the_angle_is_that_of_the_source() {
        for (d, w) in [
            (-2.0, 5.0),
            (6.0, 1.0),
            (-9.0, 1.0),
            (3.0, -1.0),
            (-3.0, -0.2),
        ] {
            for torque in [-0.1, 0.0, 0.3] {
                let r = split::<f64>(d, torque, w, 0.2).unwrap();
                let source = r.tangential_force.atan2(r.radial_force) - d.atan2(w);
                let turn = (r.resultant_angle - source) / (2.0 * std::f64::consts::PI);
                assert!(
                    (turn - turn.round()).abs() < 1e-15,
                    "{d} {w} {torque}: {} {source}",
                    r.resultant_angle
                );
            }
        }
    }

    /// dF_r = (D dD + W dW - F_t dF_t)/F_r, from the definition.
    #[test]
    fn derivatives_follow() {
        let seed = |x: f64, k: usize| Dual8::from_re(x).derivative(k);
        let r = split(
            seed(30.0, 0),
            seed(12.0, 1),
            seed(200.0, 2),
            Dual8::from_re(0.25),
        )
        .unwrap();
        let eps = r
            .radial_force
            .eps
            .unwrap_generic(nalgebra::Const::<8>, nalgebra::U1);
        let radial = r.radial_force.re;
        assert_relative_eq!(eps[0], 30.0 / radial, max_relative = 1e-14);
        assert_relative_eq!(eps[1], -48.0 / 0.25 / radial, max_relative = 1e-14);
        assert_relative_eq!(eps[2], 200.0 / radial, max_relative = 1e-14);
    }
}
