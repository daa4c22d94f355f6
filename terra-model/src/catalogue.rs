//! Soil of the literature: Bekker, Mohr-Coulomb and Janosi values, each with its source and how far to trust it.
//!
//! `wong21` are the 21 rows of the classic table (J. Y. Wong, *Theory of Ground Vehicles*, table 2.3), the hypotheses
//! of Ray 2008; their K, c1 and c2 follow the rule of that paper: sand .025 m/.38/.41, sandy loam .01/.43/.32, clay
//! .006/.43/.32, snow .05/.38/.41. A value the source does not give is missing here, never guessed.

use std::borrow::Cow;

use crate::error::ModelError;
use crate::model::AnyModel;
use crate::names::nearest;

/// How far to trust a row's digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confidence {
    /// Several public copies agree.
    Agreed,
    /// One public copy.
    Single,
    /// Recalled; check before use.
    Recalled,
    /// A user's own row.
    Own,
}

impl Confidence {
    /// The mark A, B, C, or `user`.
    pub fn mark(self) -> &'static str {
        match self {
            Confidence::Agreed => "A",
            Confidence::Single => "B",
            Confidence::Recalled => "C",
            Confidence::Own => "user",
        }
    }

    /// The confidence of a mark; none for a text that is no mark.
    pub fn of_mark(mark: &str) -> Option<Self> {
        let all = [
            Confidence::Agreed,
            Confidence::Single,
            Confidence::Recalled,
            Confidence::Own,
        ];
        all.into_iter().find(|c| c.mark() == mark)
    }
}

/// One soil, in SI units and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    /// Identifier (`dry_sand`).
    pub id: Cow<'static, str>,
    /// The set it belongs to (`wong21`).
    pub set: Cow<'static, str>,
    /// Name in words.
    pub name: Cow<'static, str>,
    /// Moisture content \[%\].
    pub moisture: Option<f64>,
    /// n \[1\].
    pub sinkage_exponent: f64,
    /// k_c \[N/m^(n+1)\].
    pub k_c: f64,
    /// k_φ \[N/m^(n+2)\].
    pub k_phi: f64,
    /// c \[Pa\].
    pub cohesion: f64,
    /// φ \[rad\].
    pub friction_angle: f64,
    /// K \[m\].
    pub shear_modulus: Option<f64>,
    /// c1 \[1\]; a missing c1, c2 means the apex at half the entry angle (.5, 0).
    pub c1: Option<f64>,
    /// c2 \[1\].
    pub c2: Option<f64>,
    /// sandy, sandy_loam, clayey, snow, ...
    pub class: Cow<'static, str>,
    /// Trust.
    pub confidence: Confidence,
    /// Where the values come from.
    pub source: Cow<'static, str>,
}

impl Terrain {
    /// k_eq = k_c/b + k_φ for a wheel of the given width \[N/m^(n+2)\].
    pub fn k_eq(&self, width: f64) -> f64 {
        self.k_c / width + self.k_phi
    }

    /// The value of a parameter of that name in SI units, where the row gives it; a missing c1, c2 is .5, 0.
    pub fn value(&self, parameter: &str) -> Option<f64> {
        match parameter {
            "k_c" => Some(self.k_c),
            "k_phi" => Some(self.k_phi),
            "sinkage_exponent" => Some(self.sinkage_exponent),
            "cohesion" => Some(self.cohesion),
            "friction_angle" => Some(self.friction_angle),
            "shear_modulus" => self.shear_modulus,
            "c1" => Some(self.c1.unwrap_or(0.5)),
            "c2" => Some(self.c2.unwrap_or(0.0)),
            _ => None,
        }
    }

    /// This soil as the parameter vector of a model, matched by parameter name.
    ///
    /// # Errors
    /// [`ModelError::MissingValue`] for a parameter the row does not give.
    pub fn parameters(&self, model: &dyn AnyModel) -> Result<Vec<f64>, ModelError> {
        self.parameters_with(model, &[])
    }

    /// The same with values of one's own by parameter name, in SI units: what belongs to the wheel and not to the soil
    /// (`tyre_pressure`, `lug_height`), what the row does not give, or what should differ from it.
    ///
    /// # Errors
    /// [`ModelError::MissingValue`] for a parameter that neither gives; [`ModelError::UnknownName`] for a value that is none
    /// of the model's.
    pub fn parameters_with(
        &self,
        model: &dyn AnyModel,
        given: &[(&str, f64)],
    ) -> Result<Vec<f64>, ModelError> {
        let names = || model.params().iter().map(|p| p.name);
        if let Some((stray, _)) = given.iter().find(|(name, _)| names().all(|n| n != *name)) {
            return Err(ModelError::UnknownName {
                kind: "parameter",
                name: (*stray).to_owned(),
                nearest: nearest(stray, names()).map(str::to_owned),
            });
        }
        model
            .params()
            .iter()
            .map(|p| {
                let own = given.iter().find(|(name, _)| *name == p.name);
                let value = own.map(|&(_, value)| value).or_else(|| self.value(p.name));
                value.ok_or_else(|| ModelError::MissingValue {
                    terrain: self.id.to_string(),
                    parameter: p.name,
                    model: model.name(),
                    reason: Missing::of(p.name),
                })
            })
            .collect()
    }
}

/// Why a soil has no value for a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// A row may give it, and the source of this one does not.
    NoSource,
    /// It belongs to the wheel, not to the soil.
    OfTheWheel,
    /// It depends on what was done to the ground before, not on the soil alone.
    OfThePast,
    /// No row of a catalogue holds it.
    NoColumn,
    /// A table of values that does not name it.
    NotNamed,
}

impl Missing {
    /// Why a catalogue row has no such parameter.
    pub fn of(parameter: &str) -> Self {
        match parameter {
            "shear_modulus" => Missing::NoSource,
            "tyre_pressure" | "deflection_ratio" | "lug_reach" | "lug_height" | "lug_count" => {
                Missing::OfTheWheel
            }
            "past_sinkage" => Missing::OfThePast,
            _ => Missing::NoColumn,
        }
    }
}

impl std::fmt::Display for Missing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Missing::NoSource => "its source gives none",
            Missing::OfTheWheel => "it belongs to the wheel, not to the soil",
            Missing::OfThePast => "it belongs to what the ground went through, not to the soil",
            Missing::NoColumn => {
                "rows of a catalogue hold k_c, k_phi, n, c, phi, K, c1, c2 and no more"
            }
            Missing::NotNamed => "a table of values names every parameter",
        })
    }
}

/// All rows, sets in order.
pub fn terrains() -> &'static [Terrain] {
    TERRAINS
}

/// The rows of one set.
///
/// # Errors
/// [`ModelError::UnknownName`].
pub fn set(name: &str) -> Result<Vec<Terrain>, ModelError> {
    let rows: Vec<Terrain> = TERRAINS.iter().filter(|t| t.set == name).cloned().collect();
    if rows.is_empty() {
        let mut sets: Vec<&str> = TERRAINS.iter().map(|t| t.set.as_ref()).collect();
        sets.dedup();
        return Err(ModelError::UnknownName {
            kind: "terrain set",
            name: name.to_owned(),
            nearest: nearest(name, sets).map(str::to_owned),
        });
    }
    Ok(rows)
}

/// The row of that id.
///
/// # Errors
/// [`ModelError::UnknownName`] with the nearest id.
pub fn find(id: &str) -> Result<&'static Terrain, ModelError> {
    TERRAINS
        .iter()
        .find(|t| t.id == id)
        .ok_or_else(|| ModelError::UnknownName {
            kind: "terrain",
            name: id.to_owned(),
            nearest: nearest(id, TERRAINS.iter().map(|t| t.id.as_ref())).map(str::to_owned),
        })
}

/// A row in the units of the table: kN, m, kPa, degrees. Arguments in its column order.
#[allow(clippy::type_complexity)]
const fn row(
    (id, set, name): (&'static str, &'static str, &'static str),
    moisture: Option<f64>,
    [n, k_c, k_phi, c, phi]: [f64; 5],
    [shear_modulus, c1, c2]: [Option<f64>; 3],
    class: &'static str,
    confidence: Confidence,
    source: &'static str,
) -> Terrain {
    Terrain {
        id: Cow::Borrowed(id),
        set: Cow::Borrowed(set),
        name: Cow::Borrowed(name),
        moisture,
        sinkage_exponent: n,
        k_c: k_c * 1e3,
        k_phi: k_phi * 1e3,
        cohesion: c * 1e3,
        friction_angle: phi * std::f64::consts::PI / 180.0,
        shear_modulus,
        c1,
        c2,
        class: Cow::Borrowed(class),
        confidence,
        source: Cow::Borrowed(source),
    }
}

#[rustfmt::skip]
static TERRAINS: &[Terrain] = &[
    row(("dry_sand", "wong21", "Dry sand (LLL)"), Some(0.0), [1.1, 0.99, 1528.43, 1.04, 28.0], [Some(0.025), Some(0.38), Some(0.41)], "sandy", Confidence::Agreed, "Wong T2.3; Ray 2008 Table 1 dry sand"),
    row(("sandy_loam_15", "wong21", "Sandy loam (LLL)"), Some(15.0), [0.7, 5.27, 1515.04, 1.72, 29.0], [Some(0.01), Some(0.43), Some(0.32)], "sandy_loam", Confidence::Agreed, "Wong T2.3"),
    row(("sandy_loam_22", "wong21", "Sandy loam (LLL)"), Some(22.0), [0.2, 2.56, 43.12, 1.38, 38.0], [Some(0.01), Some(0.43), Some(0.32)], "sandy_loam", Confidence::Agreed, "Wong T2.3"),
    row(("sandy_loam_mich_11", "wong21", "Sandy loam Michigan (Strong & Buchele)"), Some(11.0), [0.9, 52.53, 1127.97, 4.83, 20.0], [Some(0.01), Some(0.43), Some(0.32)], "sandy_loam", Confidence::Agreed, "Wong T2.3"),
    row(("sandy_loam_mich_23", "wong21", "Sandy loam Michigan (Strong & Buchele)"), Some(23.0), [0.4, 11.42, 808.96, 9.65, 35.0], [Some(0.01), Some(0.43), Some(0.32)], "sandy_loam", Confidence::Agreed, "Wong T2.3"),
    row(("sandy_loam_han_26", "wong21", "Sandy loam (Hanamoto)"), Some(26.0), [0.3, 2.79, 141.11, 13.79, 22.0], [Some(0.01), Some(0.43), Some(0.32)], "sandy_loam", Confidence::Agreed, "Wong T2.3"),
    row(("sandy_loam_han_32", "wong21", "Sandy loam (Hanamoto)"), Some(32.0), [0.5, 0.77, 51.91, 5.17, 11.0], [Some(0.01), Some(0.43), Some(0.32)], "sandy_loam", Confidence::Agreed, "Wong T2.3"),
    row(("clayey_38", "wong21", "Clayey soil (Thailand)"), Some(38.0), [0.5, 13.19, 692.15, 4.14, 13.0], [Some(0.006), Some(0.43), Some(0.32)], "clayey", Confidence::Agreed, "Wong T2.3"),
    row(("clayey_55", "wong21", "Clayey soil (Thailand)"), Some(55.0), [0.7, 16.03, 1262.53, 2.07, 10.0], [Some(0.006), Some(0.43), Some(0.32)], "clayey", Confidence::Agreed, "Wong T2.3"),
    row(("heavy_clay_25", "wong21", "Heavy clay (WES)"), Some(25.0), [0.13, 12.7, 1555.95, 68.95, 34.0], [Some(0.006), Some(0.43), Some(0.32)], "clayey", Confidence::Agreed, "Wong T2.3; the rival that Ray 2008 reports for lean clay"),
    row(("heavy_clay_40", "wong21", "Heavy clay (WES)"), Some(40.0), [0.11, 1.84, 103.27, 20.69, 6.0], [Some(0.006), Some(0.43), Some(0.32)], "clayey", Confidence::Agreed, "Wong T2.3"),
    row(("lean_clay_22", "wong21", "Lean clay (WES)"), Some(22.0), [0.2, 16.43, 1724.69, 68.95, 20.0], [Some(0.006), Some(0.43), Some(0.32)], "clayey", Confidence::Agreed, "Wong T2.3; Ray 2008 Table 1 lean clay"),
    row(("lean_clay_32", "wong21", "Lean clay (WES)"), Some(32.0), [0.15, 1.52, 119.61, 13.79, 11.0], [Some(0.006), Some(0.43), Some(0.32)], "clayey", Confidence::Agreed, "Wong T2.3"),
    row(("lete_sand", "wong21", "LETE sand (Wong)"), None, [0.79, 102.0, 5301.0, 1.3, 31.1], [Some(0.025), Some(0.38), Some(0.41)], "sandy", Confidence::Agreed, "Wong T2.3; Chrono SCM 'hard' preset uses n=.793 K=.012"),
    row(("upland_sandy_loam", "wong21", "Upland sandy loam (Wong)"), Some(51.0), [1.1, 74.6, 2080.0, 3.3, 33.7], [Some(0.01), Some(0.43), Some(0.32)], "sandy_loam", Confidence::Agreed, "Wong T2.3; inferred to be the Ray 2008 Table 1 sandy loam"),
    row(("rubicon_sandy_loam", "wong21", "Rubicon sandy loam (Wong)"), Some(43.0), [0.66, 6.9, 752.0, 3.7, 29.8], [Some(0.01), Some(0.43), Some(0.32)], "sandy_loam", Confidence::Single, "Wong T2.3; phi: one public copy 29.8 - another 30.2"),
    row(("north_gower", "wong21", "North Gower clayey loam (Wong)"), Some(46.0), [0.73, 41.6, 2471.0, 6.1, 26.6], [Some(0.006), Some(0.43), Some(0.32)], "clayey", Confidence::Single, "Wong T2.3; class (clayey vs loam) for K rule is a choice"),
    row(("grenville", "wong21", "Grenville loam (Wong)"), Some(24.0), [1.01, 0.06, 5880.0, 3.1, 29.8], [Some(0.01), Some(0.43), Some(0.32)], "sandy_loam", Confidence::Agreed, "Wong T2.3; class (loam) for K rule is a choice"),
    row(("snow_us_harrison_1", "wong21", "Snow U.S. (Harrison)"), None, [1.6, 4.37, 196.72, 1.03, 19.7], [Some(0.05), Some(0.38), Some(0.41)], "snow", Confidence::Agreed, "Wong T2.3"),
    row(("snow_us_harrison_2", "wong21", "Snow U.S. (Harrison)"), None, [1.6, 2.49, 245.9, 0.62, 23.2], [Some(0.05), Some(0.38), Some(0.41)], "snow", Confidence::Agreed, "Wong T2.3"),
    row(("snow_sweden", "wong21", "Snow Sweden"), None, [1.44, 10.55, 66.08, 6.0, 20.7], [Some(0.05), Some(0.38), Some(0.41)], "snow", Confidence::Agreed, "Wong T2.3"),
    row(("iag_dry_sand", "iagnemma", "Dry sand (Iagnemma/Shibly set)"), None, [1.1, 0.9, 1523.4, 1.0, 30.0], [Some(0.025), None, None], "sandy", Confidence::Recalled, "rounded Wong values + K; recalled from the Iagnemma 2004 / Shibly 2005 tables; theta_m = theta1/2 there"),
    row(("iag_sandy_loam", "iagnemma", "Sandy loam (Iagnemma/Shibly set)"), None, [0.7, 5.3, 1515.0, 1.7, 29.0], [Some(0.025), None, None], "sandy_loam", Confidence::Recalled, "recalled"),
    row(("iag_clayey", "iagnemma", "Clayey soil (Iagnemma/Shibly set)"), None, [0.5, 13.2, 692.2, 4.14, 13.0], [Some(0.01), None, None], "clayey", Confidence::Recalled, "recalled"),
    row(("iag_snow", "iagnemma", "Snow (Iagnemma/Shibly set)"), None, [1.6, 4.4, 196.7, 1.0, 19.7], [Some(0.04), None, None], "snow", Confidence::Recalled, "recalled; a public preset set also uses K=.04 for this snow"),
    row(("lunar_nominal", "planetary", "Lunar nominal regolith"), None, [1.0, 1.4, 820.0, 0.17, 35.0], [Some(0.018), None, None], "lunar", Confidence::Agreed, "several public copies incl. a Gazebo plugin citing Ding 2015 Table I; one copy has K=.01 and one kphi=830; ranges there c .1-2.7 phi 25-50"),
    row(("lunar_simulant_ishigami", "planetary", "Lunar regolith simulant (Ishigami/Yoshida)"), None, [1.0, 1.37, 814.0, 0.8, 37.2], [Some(0.036), Some(0.4), Some(0.15)], "lunar", Confidence::Agreed, "two public Python copies; kx=.043*beta+.036 ky=.020*beta+.013 (beta slip angle rad) rho=1600 sinkage ratio lambda=.9 Xc=26.4deg"),
    row(("hit_lss1", "planetary", "HIT-LSS1 simulant (Ding)"), None, [1.1, 15.6, 2407.4, 0.25, 31.9], [Some(0.01), None, None], "lunar", Confidence::Single, "Gazebo plugin citing Ding 2015 Table I; K range 9.7-13.1 mm"),
    row(("marssim_sand", "planetary", "Sand of MarsSim (Zhou 2023)"), None, [0.92, 13.6, 2259.1, 0.4623, 35.0], [Some(0.015), None, None], "mars", Confidence::Single, "same plugin; used with n = n0 + n1*s: n0=.92 n1=.5 ; n above is n0"),
    row(("dlr_mars", "planetary", "DLR Mars simulant"), None, [0.8, 5.79, 180.0, 0.3, 17.8], [Some(0.01), None, None], "mars", Confidence::Single, "one public preset list; looks like a mix of MER slope soil and DLR-B numbers; treat with care"),
    row(("mer_b_sandy_loam", "planetary", "MER-B sandy loam"), None, [1.0, 28.0, 7600.0, 4.8, 20.0], [None, None, None], "mars", Confidence::Recalled, "recalled (RCET/ExoMars tables); no public copy found"),
    row(("mer_b_slope_soil", "planetary", "MER-B slope soil"), None, [0.8, 6.8, 210.0, 0.5, 20.0], [None, None, None], "mars", Confidence::Recalled, "recalled"),
    row(("dlr_a", "planetary", "DLR soil simulant A"), None, [0.63, 2.37, 60.3, 0.188, 24.8], [None, None, None], "mars", Confidence::Recalled, "recalled"),
    row(("dlr_b", "planetary", "DLR soil simulant B"), None, [1.1, 18.773, 763.6, 0.441, 17.8], [None, None, None], "mars", Confidence::Recalled, "recalled"),
    row(("chrono_default", "chrono", "Chrono SCMTerrain constructor default"), None, [1.1, 0.0, 2000.0, 0.05, 20.0], [Some(0.01), None, None], "sim", Confidence::Agreed, "projectchrono/chrono src/chrono_vehicle/terrain/SCMTerrain.cpp; elastic 5e7 Pa/m damping 0"),
    row(("chrono_soft", "chrono", "Chrono SCM soft preset"), None, [1.1, 0.0, 200.0, 0.0, 30.0], [Some(0.01), None, None], "sim", Confidence::Agreed, "InitializeParametersAsSoft; elastic 4e7 damping 3e4"),
    row(("chrono_mid", "chrono", "Chrono SCM mid preset"), None, [1.1, 0.0, 2000.0, 0.0, 30.0], [Some(0.01), None, None], "sim", Confidence::Agreed, "InitializeParametersAsMid; elastic 2e8 damping 3e4"),
    row(("chrono_hard", "chrono", "Chrono SCM hard preset (LETE sand)"), None, [0.793, 102.0, 5301.0, 1.3, 31.1], [Some(0.012), None, None], "sim", Confidence::Agreed, "InitializeParametersAsHard; elastic 4e8 damping 3e4"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::Registry;

    #[test]
    fn a_mark_names_its_confidence_and_no_other_text_does() {
        for (mark, confidence) in [
            ("A", Confidence::Agreed),
            ("B", Confidence::Single),
            ("C", Confidence::Recalled),
            ("user", Confidence::Own),
        ] {
            assert_eq!(Confidence::of_mark(mark), Some(confidence));
            assert_eq!(confidence.mark(), mark);
        }
        for other in ["", "a", "D", "User", "A "] {
            assert_eq!(Confidence::of_mark(other), None, "{other}");
        }
    }

    /// The source of the MER rows gives no K; no row can give a tyre's pressure or a cone index, for different reasons.
    #[test]
    fn a_missing_value_says_why() {
        let registry = Registry::builtin();
        for (soil, model, parameter, expected) in [
            (
                "mer_b_slope_soil",
                "wong-reece",
                "shear_modulus",
                Missing::NoSource,
            ),
            (
                "dry_sand",
                "compliant-tyre",
                "tyre_pressure",
                Missing::OfTheWheel,
            ),
            ("dry_sand", "wes-brixius", "cone_index", Missing::NoColumn),
            (
                "dry_sand",
                "wong-reece:peat",
                "peat_stiffness",
                Missing::NoColumn,
            ),
        ] {
            let model = registry.model(model).unwrap();
            let error = find(soil).unwrap().parameters(&*model).unwrap_err();
            let ModelError::MissingValue {
                parameter: found,
                reason,
                ..
            } = &error
            else {
                panic!("{error}");
            };
            assert_eq!((*found, *reason), (parameter, expected));
            assert!(error.to_string().contains(&expected.to_string()), "{error}");
        }
    }
}
