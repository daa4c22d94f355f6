//! A soil as a slip compliance: the one number that rigid-body simulators (Gazebo's WheelSlip, ODE's `slip1`) take for a
//! wheel on soft ground, with the slips up to which it holds.

use std::io::{self, Write};

use terra_model::{Contact, ForceLaw, Law, ModelError};

/// Slips the law is asked at: 1 % apart.
const STEPS: usize = 100;

/// The linear law of one load.
///
/// # Equation
/// D(s) ≈ W (s/C - ρ) for 0 <= s <= s_max; ρ = -D(0)/W, and 1/C is the least-squares slope of (D(s) - D(0))/W through the
/// origin over that range. s_max is the largest slip up to which, for it and every smaller one, the line stays within
/// `tolerance` of the largest gross traction on its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipCompliance {
    /// W \[N\].
    pub normal_load: f64,
    /// C \[1\]: slip by tangential over normal force.
    pub compliance: f64,
    /// ρ \[1\]: motion resistance over normal force, to be given as rolling resistance.
    pub rolling_resistance: f64,
    /// s_max \[1\].
    pub slip_to: f64,
    /// Largest distance between line and law on the range, as a share of the load \[1\].
    pub worst_error: f64,
}

/// Fits the compliance of a wheel at each load; a load that the soil cannot carry, or whose traction never grows with
/// slip, has none.
///
/// # Errors
/// Parameters or a contact out of range.
pub fn slip_compliance(
    law: &Law,
    parameters: &[f64],
    radius: f64,
    width: f64,
    loads: &[f64],
    tolerance: f64,
) -> Result<Vec<(f64, Option<SlipCompliance>)>, ModelError> {
    loads
        .iter()
        .map(|&load| {
            let pull = |slip: f64| {
                let forces = law.forces(parameters, &Contact::new(slip, load, radius, width))?;
                Ok(forces.drawbar_pull)
            };
            let curve: Result<Vec<f64>, ModelError> =
                (0..=STEPS).map(|k| pull(k as f64 / STEPS as f64)).collect();
            match curve {
                Ok(curve) => Ok((load, fit(load, &curve, tolerance))),
                Err(ModelError::NoEquilibrium { .. }) => Ok((load, None)),
                Err(e) => Err(e),
            }
        })
        .collect()
}

/// The longest line from the origin that holds.
fn fit(load: f64, curve: &[f64], tolerance: f64) -> Option<SlipCompliance> {
    let rest = curve.first()?;
    let (mut gs, mut ss, mut largest) = (0.0, 0.0, 0.0_f64);
    let mut best = None;
    for (k, pull) in curve.iter().enumerate().skip(1) {
        let (s, g) = (k as f64 / STEPS as f64, (pull - rest) / load);
        gs += g * s;
        ss += s * s;
        largest = largest.max(g);
        let slope = gs / ss;
        let off =
            |(j, d): (usize, &f64)| ((d - rest) / load - slope * j as f64 / STEPS as f64).abs();
        let worst = curve
            .iter()
            .take(k + 1)
            .enumerate()
            .map(off)
            .fold(0.0, f64::max);
        if slope <= 0.0 || worst > tolerance * largest {
            break;
        }
        best = Some(SlipCompliance {
            normal_load: load,
            compliance: 1.0 / slope,
            rolling_resistance: -rest / load,
            slip_to: s,
            worst_error: worst,
        });
    }
    best
}

/// Writes a table of compliances as CSV; a load without one has empty cells.
///
/// # Errors
/// Those of the stream.
pub fn write_slip_compliance(
    mut out: impl Write,
    table: &[(f64, Option<SlipCompliance>)],
) -> io::Result<()> {
    writeln!(
        out,
        "normal_load_N,slip_compliance,rolling_resistance,slip_from,slip_to,worst_error,status"
    )?;
    for (load, found) in table {
        match found {
            Some(c) => writeln!(
                out,
                "{load},{},{},0,{},{},ok",
                c.compliance, c.rolling_resistance, c.slip_to, c.worst_error
            )?,
            None => writeln!(out, "{load},,,,,,no-compliance")?,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// D = W (μ s/(s + κ) - ρ): near the origin 1/C is μ/κ, and the line leaves the curve where its bend is worth the
    /// tolerance.
    #[test]
    fn of_a_curve_known_in_closed_form() {
        let (load, mu, kappa, rho) = (200.0, 0.6, 0.3, 0.08);
        let pull = |s: f64| load * (mu * s / (s + kappa) - rho);
        let curve: Vec<f64> = (0..=STEPS).map(|k| pull(k as f64 / STEPS as f64)).collect();
        let tight = fit(load, &curve, 0.02).unwrap();
        let loose = fit(load, &curve, 0.10).unwrap();
        assert!((tight.rolling_resistance - rho).abs() < 1e-12);
        assert!(tight.slip_to < loose.slip_to && loose.slip_to < 1.0);
        // A chord is flatter than the tangent, and flatter the longer it is.
        assert!(kappa / mu < tight.compliance && tight.compliance < loose.compliance);
        for c in [tight, loose] {
            let steps = (c.slip_to * STEPS as f64).round() as usize;
            let off = |k: usize| {
                let s = k as f64 / STEPS as f64;
                (pull(s) / load - (s / c.compliance - c.rolling_resistance)).abs()
            };
            let worst = (0..=steps).map(off).fold(0.0, f64::max);
            assert!((worst - c.worst_error).abs() < 1e-12);
        }
    }

    /// A straight line is its own fit all the way.
    #[test]
    fn of_a_line() {
        let curve: Vec<f64> = (0..=STEPS)
            .map(|k| 100.0 * (0.5 * k as f64 / 100.0 - 0.1))
            .collect();
        let c = fit(100.0, &curve, 1e-9).unwrap();
        assert!((c.compliance - 2.0).abs() < 1e-12 && c.slip_to == 1.0);
    }

    #[test]
    fn traction_that_falls_has_none() {
        let curve: Vec<f64> = (0..=STEPS).map(|k| -(k as f64)).collect();
        assert_eq!(fit(100.0, &curve, 0.1), None);
    }
}
