//! The exact Jacobian by the chain rule: one forward solve, the partial derivatives of its integrals, one implicit step.

use nalgebra::DMatrix;

use super::gradient::{APEX, COHESION, EXPONENT, FRICTION, PER_MODULUS, SCALE, SLIP, VARIABLES};
use super::{COARSE, FINE, WongReece, solve};
use crate::contact::Contact;
use crate::error::ModelError;
use crate::model::ForceSlopes;

/// Forces, and their derivatives in the eight parameters, slip and load; none where the contact has a sideways slip.
pub(super) fn slopes(p: &[f64], at: &Contact<f64>) -> Result<Option<ForceSlopes>, ModelError> {
    let wheel = WongReece::wheel(p, at)?;
    let &[_, _, _, _, friction, modulus, c1, c2] = p else {
        return Ok(None);
    };
    if wheel.lateral.is_some() {
        return Ok(None);
    }
    let mut asked = [false; VARIABLES];
    for k in [SCALE, EXPONENT, COHESION, FRICTION, PER_MODULUS, SLIP, APEX] {
        asked[k] = true;
    }
    let (entry, integrals, partials) = solve::partials::<COARSE, FINE>(&wheel, at, &asked)?;
    let (hooks, g) = (&at.hooks, &wheel.ground);
    let area = wheel.radius * wheel.width;

    let power = wheel.radius.powf(g.exponent);
    let scale = g.stiffness * power;
    let stiffness = power * hooks.stiffness;
    // d tan φ/dφ = 1 + tan² φ
    let tan = friction.tan();
    // θm/θ1 does not move where it is held, but with a c1 that holds it; i = s driving, s/(1 + s) braking.
    let free = if g.apex_limited { 0.0 } else { 1.0 };
    let by_c1 = if g.apex_ratio == c1 { 1.0 } else { free };
    let i_by_slip = if wheel.braking {
        (1.0 - g.slip) * (1.0 - g.slip)
    } else {
        1.0
    };
    let columns = [
        partials.follow(0.0, &[(SCALE, stiffness / at.width)]),
        partials.follow(0.0, &[(SCALE, stiffness)]),
        partials.follow(0.0, &[(SCALE, scale * wheel.radius.ln()), (EXPONENT, 1.0)]),
        partials.follow(0.0, &[(COHESION, hooks.cohesion)]),
        partials.follow(0.0, &[(FRICTION, (1.0 + tan * tan) * hooks.friction)]),
        partials.follow(
            0.0,
            &[(
                PER_MODULUS,
                -wheel.shear_radius / (g.shear_modulus * modulus),
            )],
        ),
        partials.follow(0.0, &[(APEX, by_c1)]),
        partials.follow(0.0, &[(APEX, free * g.slip)]),
        partials.follow(0.0, &[(SLIP, i_by_slip), (APEX, free * c2 * i_by_slip)]),
        partials.follow(1.0 / area, &[]),
    ];
    let arm = area * (at.radius + hooks.lug_height);
    let mut jacobian = DMatrix::zeros(4, columns.len());
    for (column, [step, _, thrust, compaction, shear]) in columns.into_iter().enumerate() {
        jacobian[(0, column)] = (thrust - compaction) * area;
        jacobian[(1, column)] = shear * arm;
        // z = R (1 - cos θ1)
        jacobian[(2, column)] = wheel.radius * entry.sin() * entry * step;
    }
    let forces = WongReece::named(&wheel, at, entry, integrals);
    Ok(Some((forces, jacobian)))
}
