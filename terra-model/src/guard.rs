//! What is checked before a model is called.

use crate::contact::Contact;
use crate::error::ModelError;
use crate::param::Param;

/// What no author has to check: as many parameters as declared, every number finite, a load above zero on a wheel with a
/// radius and a width, and slip in \[-1, 1\].
pub(crate) fn guard(
    model: &'static str,
    params: &[Param],
    p: &[f64],
    at: &Contact<f64>,
) -> Result<(), ModelError> {
    if params.len() != p.len() {
        return Err(ModelError::ParameterCount {
            model: model.to_owned(),
            expected: params.len(),
            found: p.len(),
        });
    }
    if let Some((param, &value)) = params.iter().zip(p).find(|(_, value)| !value.is_finite()) {
        return Err(ModelError::Parameter {
            model,
            parameter: param.name,
            value,
            expected: "a finite value",
        });
    }
    let contact = [
        ("slip", at.slip),
        ("normal_load", at.normal_load),
        ("radius", at.radius),
        ("width", at.width),
        ("speed", at.speed),
        ("wheel_speed", at.wheel_speed),
        ("slip_angle", at.slip_angle),
        ("yaw_rate", at.yaw_rate),
        ("path", at.path),
        ("earlier_passes", at.earlier_passes),
        ("side", at.side),
        ("ahead", at.ahead),
        ("wheelbase", at.wheelbase),
        ("time", at.time),
    ];
    match contact.into_iter().find(|(_, value)| !value.is_finite()) {
        Some((quantity, value)) => Err(ModelError::Contact {
            quantity,
            value,
            expected: "a finite value",
        }),
        None => Ok(()),
    }
}

/// A vector of the declared length, at any scalar.
pub(crate) fn count(model: &str, expected: usize, found: usize) -> Result<(), ModelError> {
    if expected == found {
        Ok(())
    } else {
        Err(ModelError::ParameterCount {
            model: model.to_owned(),
            expected,
            found,
        })
    }
}
