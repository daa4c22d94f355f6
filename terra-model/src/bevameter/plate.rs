//! Pressure against sinkage.
//!
//! # Equation
//! The laws of the pressure slot, with b the radius of a round plate:
//! `bekker` p = (k_c/b + k_φ) z^n; `reece` p = (c k_c' + γ b k_φ')(z/b)^n, of which tests give c k_c' and γ k_φ';
//! `exponential-snow` p = p_w (1 - e^(-z/z_w)); `peat` p = k_p z + 4 m_m z²/D_h, D_h = 2 b;
//! `layered` p = k z^n + k_h (z - z_h) below z_h.

use super::curve::{Curve, Prepared};
use super::fit::{Form, Free, Way, different, moves, not_fitted, prepare, rank, report};
use super::report::Fits;
use crate::error::ModelError;
use crate::real::Real;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Bekker,
    Reece,
    Snow,
    Peat,
    Layered,
}

/// One law for plates of one radius or of several.
struct Plate {
    kind: Kind,
    several: bool,
    free: Vec<Free>,
}

const fn free(name: &'static str, unit: &'static str, way: Way) -> Free {
    Free { name, unit, way }
}

const K_EQ: Free = free("k_eq", "N/m^(n+2)", Way::Log);
const EXPONENT: Free = free("sinkage_exponent", "1", Way::Log);

impl Plate {
    fn new(kind: Kind, several: bool) -> Self {
        let stiffness = if several {
            vec![
                free("k_c", "N/m^(n+1)", Way::Linear),
                free("k_phi", "N/m^(n+2)", Way::Linear),
            ]
        } else {
            vec![K_EQ]
        };
        let free = match kind {
            Kind::Bekker => [stiffness, vec![EXPONENT]].concat(),
            Kind::Layered => [
                stiffness,
                vec![
                    EXPONENT,
                    free("layer_stiffness", "N/m^3", Way::Linear),
                    free("layer_depth", "m", Way::Log),
                ],
            ]
            .concat(),
            Kind::Reece => vec![
                free("cohesion_k_c_prime", "Pa", Way::Linear),
                free("unit_weight_k_phi_prime", "N/m^3", Way::Linear),
                EXPONENT,
            ],
            Kind::Snow => vec![
                free("snow_pressure", "Pa", Way::Log),
                free("snow_depth", "m", Way::Log),
            ],
            Kind::Peat => vec![
                free("peat_stiffness", "N/m^3", Way::Linear),
                free("mat_stiffness", "N/m^3", Way::Linear),
            ],
        };
        Plate {
            kind,
            several,
            free,
        }
    }

    /// k of the power law, and where its other parameters begin.
    fn stiffness<T: Real>(&self, p: &[T], radius: f64) -> (T, usize) {
        match (self.several, p) {
            (true, [k_c, k_phi, ..]) => (*k_c / radius + *k_phi, 2),
            (false, [k, ..]) => (*k, 1),
            _ => (T::zero(), 0),
        }
    }
}

impl Form for Plate {
    fn law(&self) -> &'static str {
        match self.kind {
            Kind::Bekker => "bekker",
            Kind::Reece => "reece",
            Kind::Snow => "exponential-snow",
            Kind::Peat => "peat",
            Kind::Layered => "layered",
        }
    }

    fn free(&self) -> &[Free] {
        &self.free
    }

    fn stress<T: Real>(&self, p: &[T], radius: f64, z: f64) -> T {
        let depth = T::from(z);
        match (self.kind, p) {
            (Kind::Bekker | Kind::Layered, _) => {
                let (k, at) = self.stiffness(p, radius);
                let rest = p.get(at..).unwrap_or_default();
                match rest {
                    [n] => k * depth.pow_pos(*n),
                    [n, layer, top] => {
                        let below = depth - *top;
                        let below = below.select_lt(T::zero(), T::zero(), below);
                        k * depth.pow_pos(*n) + *layer * below
                    }
                    _ => T::from(f64::NAN),
                }
            }
            (Kind::Reece, [cohesive, frictional, n]) => {
                (*cohesive + *frictional * radius) * T::from(z / radius).pow_pos(*n)
            }
            (Kind::Snow, [pressure, scale]) => *pressure * -(-(depth / *scale)).exp_m1(),
            (Kind::Peat, [stiffness, mat]) => {
                *stiffness * z + *mat * (4.0 * z * z / (2.0 * radius))
            }
            _ => T::from(f64::NAN),
        }
    }

    fn starts(&self, tests: &[Prepared]) -> Vec<Vec<f64>> {
        let (k, n) = power_law(tests);
        let deepest = tests
            .iter()
            .filter_map(|t| t.points.last())
            .map(|p| p.0)
            .fold(0.0, f64::max);
        let largest = tests.iter().map(|t| t.peak.1).fold(0.0, f64::max);
        let radius = tests.iter().map(|t| t.given).sum::<f64>() / tests.len().max(1) as f64;
        let stiffness = |k: f64| {
            if self.several {
                vec![0.5 * k * radius, 0.5 * k]
            } else {
                vec![k]
            }
        };
        match self.kind {
            Kind::Bekker => vec![[stiffness(k), vec![n]].concat()],
            Kind::Layered => [0.25, 0.5, 0.75]
                .iter()
                .map(|share| {
                    let layer = [n, 0.5 * largest / deepest, share * deepest];
                    [stiffness(k), layer.to_vec()].concat()
                })
                .collect(),
            Kind::Reece => {
                let sum = k * radius.powf(n);
                vec![vec![0.5 * sum, 0.5 * sum / radius, n]]
            }
            Kind::Snow => [0.3, 1.0]
                .iter()
                .map(|share| vec![largest, share * deepest])
                .collect(),
            Kind::Peat => vec![vec![largest / deepest, 0.1 * largest / deepest]],
        }
    }

    fn givens(&self) -> usize {
        if self.several { 2 } else { 1 }
    }
}

/// Wong's closed form: the p²-weighted straight line of ln p against ln z.
fn power_law(tests: &[Prepared]) -> (f64, f64) {
    let (mut w, mut x, mut y, mut xx, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (z, p) in tests.iter().flat_map(|t| &t.points) {
        let (lz, lp, weight) = (z.ln(), p.ln(), p * p);
        w += weight;
        x += weight * lz;
        y += weight * lp;
        xx += weight * lz * lz;
        xy += weight * lz * lp;
    }
    let n = (w * xy - x * y) / (w * xx - x * x);
    let n = if n.is_finite() {
        n.clamp(0.05, 5.0)
    } else {
        1.0
    };
    (((y - n * x) / w).exp(), n)
}

/// Fits every pressure-sinkage law to plate tests, with sinkages between `from` and `to` \[m\].
///
/// # Errors
/// [`ModelError::Curve`]: no test, a test with too few points, or tests that no law fits.
pub fn fit_plates(curves: &[Curve], from: f64, to: f64) -> Result<Fits, ModelError> {
    let tests = prepare(curves, from, to)?;
    let several = different(&tests) > 1;
    let mut kinds = vec![Kind::Bekker, Kind::Snow, Kind::Peat, Kind::Layered];
    if several {
        kinds.insert(1, Kind::Reece);
    }
    let forms: Vec<Plate> = kinds.iter().map(|k| Plate::new(*k, several)).collect();
    let laws = rank(forms.iter().filter_map(|f| report(f, &tests)).collect());
    let bekker = forms.first().zip(laws.first());
    let Some((form, law)) = bekker.filter(|(_, l)| l.law == "bekker") else {
        return Err(not_fitted(&tests));
    };
    let mut undetermined = vec![];
    let mut null = vec![];
    if several {
        for name in ["k_c", "k_phi"] {
            if law.get(name).is_some_and(|e| e.low < 0.0 && e.high > 0.0) {
                undetermined.push(format!("{name}: not told from 0 by these plates"));
            }
        }
    } else {
        let radius = tests.first().map_or(0.0, |t| t.given);
        undetermined.push(format!(
            "k_c, k_phi only through k_c/b + k_phi: one plate, b = {radius:.4} m"
        ));
        undetermined
            .push("reece: the same curve as bekker on one plate, over no other width".to_owned());
        null = vec![("k_c", radius), ("k_phi", -1.0)];
    }
    let deepest = tests
        .iter()
        .filter_map(|t| t.points.last())
        .map(|p| p.0)
        .fold(0.0, f64::max);
    for law in &laws {
        if law
            .get("snow_depth")
            .is_some_and(|d| d.value > 10.0 * deepest)
        {
            undetermined.push(
                "snow_pressure, snow_depth only through their ratio: these curves do not level off"
                    .to_owned(),
            );
        }
    }
    undetermined.extend(moves(form, &tests, law, "sinkage_exponent", "depth"));
    Ok(Fits {
        tests,
        laws,
        null,
        undetermined,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::jacobian;

    /// With one radius the three-parameter law has an exact null direction: J (b, -1, 0) = 0 to rounding.
    #[test]
    fn one_plate_has_an_exact_null_direction() {
        let law = Plate::new(Kind::Bekker, true);
        let radius = 0.075;
        let p = [2e4, 1.5e6, 0.9];
        let (value, jac) = jacobian::<std::convert::Infallible>(&p, |p| {
            Ok((1..=20)
                .map(|k| law.stress(p, radius, 0.002 * f64::from(k)))
                .collect())
        })
        .unwrap();
        for row in 0..20 {
            let change = jac[(row, 0)] * radius - jac[(row, 1)];
            assert!(change.abs() < 1e-15 * value[row].max(1.0), "{change}");
        }
    }

    /// The laws are those of the wheel's slots: the same pressure at the same depth and width.
    #[test]
    fn bekker_and_snow_by_hand() {
        let law = Plate::new(Kind::Bekker, true);
        // (1000/.1 + 90000) .01^1 = 1000 Pa
        assert!((law.stress(&[1000.0, 9e4, 1.0], 0.1, 0.01) - 1000.0).abs() < 1e-9);
        let law = Plate::new(Kind::Snow, false);
        // 50 kPa (1 - 1/e)
        assert!((law.stress(&[5e4, 0.02], 0.1, 0.02) - 31_606.027_941).abs() < 1e-5);
        let law = Plate::new(Kind::Peat, false);
        // 3e5 .02 + 4 5e4 .0004/.2
        assert!((law.stress(&[3e5, 5e4], 0.1, 0.02) - 6400.0).abs() < 1e-9);
        let law = Plate::new(Kind::Reece, true);
        // (500 + 2e5 .1)(.05/.1)^1
        assert!((law.stress(&[500.0, 2e5, 1.0], 0.1, 0.05) - 10_250.0).abs() < 1e-9);
    }
}
