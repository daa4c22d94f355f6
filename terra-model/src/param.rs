//! The description of one number that a model, an effect or a fit is free to choose.

/// How a parameter is varied when it is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// As it is.
    Linear,
    /// By its logarithm (it is positive).
    Log,
}

/// Range of a magnitude that may have either sign.
pub(crate) const EITHER_SIGN: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// One parameter of a model or an effect: what it is called, its unit, where it may lie, how uncertain it is a priori.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Param {
    /// Name on every outside: snake case, the field's word (`friction_angle`).
    pub name: &'static str,
    /// Symbol in formulas (`φ`).
    pub symbol: &'static str,
    /// SI unit (`rad`; `1` when dimensionless).
    pub unit: &'static str,
    /// Smallest legal value; for an effect's magnitude 0 here means one-sided.
    pub min: f64,
    /// Largest legal value.
    pub max: f64,
    /// How it is fitted.
    pub scale: Scale,
    /// Prior standard deviation: of ln(value) on the log scale, of the value on the linear scale.
    pub prior_sd: f64,
    /// One line of meaning.
    pub doc: &'static str,
}

impl Param {
    /// The magnitude of an effect: e on the linear scale, 0 = nominal; one-sided where the range begins at 0.
    pub const fn magnitude(
        unit: &'static str,
        [min, max]: [f64; 2],
        prior_sd: f64,
        doc: &'static str,
    ) -> Self {
        Param {
            name: "magnitude",
            symbol: "e",
            unit,
            min,
            max,
            scale: Scale::Linear,
            prior_sd,
            doc,
        }
    }

    /// True when only values on one side of 0 make sense.
    pub fn one_sided(&self) -> bool {
        self.min >= 0.0
    }
}

/// How large a magnitude of this unit is on a wheel of this load \[N\] and radius \[m\]: what it carries (N), that times the radius
/// (N m), the same at a rim that runs 1 m/s (N m s, N m s^(2/3)), the load over (1 m/s)² (N s²/m²), the radius (m). None for other
/// units, whose priors are the same for all wheels.
pub fn natural_size(unit: &str, load: f64, radius: f64) -> Option<f64> {
    let (by_load, power, _) = natural(unit)?;
    Some(if by_load { load } else { 1.0 } * radius.powf(power))
}

/// That size in the field's symbols.
pub fn natural_symbol(unit: &str) -> Option<&'static str> {
    natural(unit).map(|(.., symbol)| symbol)
}

/// Whether it grows with the load, with which power of the radius, and its symbol.
fn natural(unit: &str) -> Option<(bool, f64, &'static str)> {
    Some(match unit {
        "N" | "N s²/m²" => (true, 0.0, "W"),
        "N m" => (true, 1.0, "W R"),
        "N m s" => (true, 2.0, "W R²"),
        "N m s^(2/3)" => (true, 5.0 / 3.0, "W R^(5/3)"),
        "m" => (false, 1.0, "R"),
        _ => return None,
    })
}
