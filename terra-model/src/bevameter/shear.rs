//! Shear stress against displacement.
//!
//! # Equation
//! τ = (c + σ tan φ) E(j/K), E of the shear slot: `janosi-hanamoto` 1 - e^(-y), `wong-hump` K_r {1 + \[1/(K_r (1 - 1/e)) - 1\]
//! e^(1 - y)} (1 - e^(-y)), `muskeg` y e^(1 - y). One normal stress gives the strength c + σ tan φ alone.

use std::f64::consts::E;

use super::curve::{Curve, Prepared};
use super::fit::{Form, Free, Way, different, moves, not_fitted, prepare, rank, report};
use super::report::Fits;
use crate::error::ModelError;
use crate::real::Real;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    JanosiHanamoto,
    WongHump,
    Muskeg,
}

struct Shear {
    kind: Kind,
    several: bool,
    free: Vec<Free>,
}

const fn free(name: &'static str, unit: &'static str, way: Way) -> Free {
    Free { name, unit, way }
}

impl Shear {
    fn new(kind: Kind, several: bool) -> Self {
        let mut list = if several {
            // The second number is tan φ until it is shown.
            vec![
                free("cohesion", "Pa", Way::Linear),
                free("friction_angle", "rad", Way::Log),
            ]
        } else {
            vec![free("shear_strength", "Pa", Way::Log)]
        };
        list.push(free("shear_modulus", "m", Way::Log));
        if kind == Kind::WongHump {
            list.push(free("residual_ratio", "1", Way::Share));
        }
        Shear {
            kind,
            several,
            free: list,
        }
    }
}

impl Form for Shear {
    fn law(&self) -> &'static str {
        match self.kind {
            Kind::JanosiHanamoto => "janosi-hanamoto",
            Kind::WongHump => "wong-hump",
            Kind::Muskeg => "muskeg",
        }
    }

    fn free(&self) -> &[Free] {
        &self.free
    }

    fn stress<T: Real>(&self, p: &[T], normal: f64, j: f64) -> T {
        let (strength, rest) = match (self.several, p) {
            (true, [c, tan, rest @ ..]) => (*c + *tan * normal, rest),
            (false, [strength, rest @ ..]) => (*strength, rest),
            _ => return T::from(f64::NAN),
        };
        match (self.kind, rest) {
            (Kind::JanosiHanamoto, [modulus]) => strength * -(-(T::from(j) / *modulus)).exp_m1(),
            (Kind::WongHump, [modulus, residual]) => {
                let y = T::from(j) / *modulus;
                let rise = -(-y).exp_m1();
                let lift = (T::from(1.0 / (1.0 - 1.0 / E)) - *residual) * E;
                strength * rise * (*residual + lift * (T::one() - rise))
            }
            (Kind::Muskeg, [modulus]) => {
                let y = T::from(j) / *modulus;
                strength * y * (-y + 1.0).exp()
            }
            _ => T::from(f64::NAN),
        }
    }

    fn starts(&self, tests: &[Prepared]) -> Vec<Vec<f64>> {
        let count = tests.len().max(1) as f64;
        let mean = |value: fn(&Prepared) -> f64| tests.iter().map(value).sum::<f64>() / count;
        let (peak, normal) = (mean(|t| t.peak.1), mean(|t| t.given));
        let strength = if self.several {
            vec![0.1 * peak, 0.9 * peak / normal]
        } else {
            vec![peak]
        };
        // Where half the peak is reached: y = ln 2 for the rising law.
        let half = mean(|t| {
            t.points
                .iter()
                .find(|p| p.1 >= 0.5 * t.peak.1)
                .map_or(0.01, |p| p.0)
        });
        [0.5, 1.5, 5.0]
            .iter()
            .map(|factor| {
                let modulus = factor * half / 2.0f64.ln();
                let mut start = [strength.clone(), vec![modulus]].concat();
                if self.kind == Kind::WongHump {
                    start.push(0.7);
                }
                start
            })
            .collect()
    }

    fn givens(&self) -> usize {
        if self.several { 2 } else { 1 }
    }

    fn shown(&self, name: &str, value: f64) -> f64 {
        if name == "friction_angle" {
            value.atan()
        } else {
            value
        }
    }
}

/// Fits every shear law to shear tests, with displacements between `from` and `to` \[m\].
///
/// # Errors
/// [`ModelError::Curve`]: no test, a test with too few points, or tests that no law fits.
pub fn fit_shear(curves: &[Curve], from: f64, to: f64) -> Result<Fits, ModelError> {
    let tests = prepare(curves, from, to)?;
    let several = different(&tests) > 1;
    let forms: Vec<Shear> = [Kind::JanosiHanamoto, Kind::WongHump, Kind::Muskeg]
        .iter()
        .map(|k| Shear::new(*k, several))
        .collect();
    let laws = rank(forms.iter().filter_map(|f| report(f, &tests)).collect());
    let janosi = forms.first().zip(laws.first());
    let Some((form, law)) = janosi.filter(|(_, l)| l.law == "janosi-hanamoto") else {
        return Err(not_fitted(&tests));
    };
    let mut undetermined = vec![];
    let mut null = vec![];
    if several {
        if law
            .get("cohesion")
            .is_some_and(|e| e.low < 0.0 && e.high > 0.0)
        {
            undetermined.push("cohesion: not told from 0 by these normal stresses".to_owned());
        }
    } else {
        let normal = tests.first().map_or(0.0, |t| t.given);
        undetermined.push(format!(
            "cohesion, friction_angle only through cohesion + {normal:.0} Pa tan(friction_angle): one normal stress"
        ));
        null = vec![("cohesion", normal), ("tan(friction_angle)", -1.0)];
    }
    let modulus = law.get("shear_modulus").map_or(f64::NAN, |e| e.value);
    for t in &tests {
        let way = t.points.last().map_or(0.0, |p| p.0);
        if way < 2.0 * modulus {
            undetermined.push(format!(
                "shear_modulus: test {} ends at {way:.3} m, before twice K = {modulus:.3} m; its plateau is extrapolated",
                t.test
            ));
        }
    }
    undetermined.extend(moves(form, &tests, law, "shear_modulus", "displacement"));
    Ok(Fits {
        tests,
        laws,
        null,
        undetermined,
    })
}
