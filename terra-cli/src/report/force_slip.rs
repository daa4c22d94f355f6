//! Forces against slip, as terramechanics draws them: drawbar pull, torque and sinkage, and what they are worth, traction
//! coefficient and tractive efficiency.

use super::block::Figure;
use super::data::{Datum, Look, Series};
use super::number::number;
use super::paint::Paint;
use super::plot::{Layout, Panel, Plot};
use super::scale::Axis;
use super::words::{capital, quantity};

/// A mean with its 1-sigma, NaN where it is not known.
pub type Value = (f64, f64);

/// Forces of one wheel against slip, at one load. Vectors are as long as `slip`, or empty where a quantity is not known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForceSlip {
    /// Normal load \[N\].
    pub load: f64,
    /// Wheel radius \[m\].
    pub radius: f64,
    /// Library slip.
    pub slip: Vec<f64>,
    /// \[N\]
    pub drawbar: Vec<Value>,
    /// \[N m\]
    pub torque: Vec<Value>,
    /// \[m\]
    pub sinkage: Vec<Value>,
    /// What was measured at about that load, where the log says.
    pub measured: Vec<MeasuredForces>,
}

/// One row of a rig log.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredForces {
    /// What it is called.
    pub trial: String,
    /// Library slip.
    pub slip: Value,
    /// \[N\]
    pub drawbar: Value,
    /// \[N m\]
    pub torque: Value,
    /// \[m\]
    pub sinkage: Value,
}

/// D/W: the pull a wheel gives for the load it carries.
pub(super) fn traction_coefficient(drawbar: Value, load: f64) -> Value {
    (drawbar.0 / load, drawbar.1 / load)
}

/// D v / (T ω) = (D r / T)(1 - s) of a wheel that pulls: the share of its power that moves something. NaN for one that
/// does not pull, or whose slip is negative.
pub(super) fn tractive_efficiency(drawbar: f64, torque: f64, slip: f64, radius: f64) -> f64 {
    if drawbar > 0.0 && torque > 0.0 && (0.0..=1.0).contains(&slip) {
        drawbar * radius / torque * (1.0 - slip)
    } else {
        f64::NAN
    }
}

/// The five panels of a wheel.
pub(super) fn forces(group: &str, f: &ForceSlip) -> Figure {
    let drawbar_of = |k: usize| f.drawbar.get(k).copied().unwrap_or((f64::NAN, f64::NAN));
    let torque_of = |k: usize| f.torque.get(k).map_or(f64::NAN, |t| t.0);
    let traction = (0..f.slip.len()).map(|k| traction_coefficient(drawbar_of(k), f.load));
    let efficiency = f.slip.iter().enumerate().map(|(k, slip)| {
        let eta = tractive_efficiency(drawbar_of(k).0, torque_of(k), *slip, f.radius);
        (eta, f64::NAN)
    });
    let measured = |of: &dyn Fn(&MeasuredForces) -> Value| -> Vec<Datum> {
        let rows = f.measured.iter().map(|m| {
            let (value, sd) = of(m);
            let at = Datum::at(m.slip.0, value).sd(m.slip.1, sd);
            at.labelled(m.trial.as_str())
        });
        rows.filter(Datum::is_finite).collect()
    };
    let eta = |m: &MeasuredForces| {
        let eta = tractive_efficiency(m.drawbar.0, m.torque.0, m.slip.0, f.radius);
        (eta, f64::NAN)
    };
    let panels = [
        (
            "drawbar_pull_N",
            "N",
            f.drawbar.clone(),
            measured(&|m| m.drawbar),
        ),
        (
            "torque_N_m",
            "N m",
            f.torque.clone(),
            measured(&|m| m.torque),
        ),
        (
            "sinkage_m",
            "m",
            f.sinkage.clone(),
            measured(&|m| m.sinkage),
        ),
        (
            "traction_coefficient",
            "1",
            traction.collect(),
            measured(&|m| traction_coefficient(m.drawbar, f.load)),
        ),
        (
            "tractive_efficiency",
            "1",
            efficiency.collect(),
            measured(&eta),
        ),
    ];
    let panels = panels
        .into_iter()
        .filter_map(|(name, si, values, points)| panel(group, f, name, si, &values, points));
    let load = number(f.load, 3);
    let what = match group {
        "" => String::new(),
        name => format!(", {name}: what the weighed soils predict, bands ± 1 sd"),
    };
    let caption = format!(
        "One wheel under {load}\u{a0}N{what}. Traction coefficient: pull over load. Tractive efficiency: share of the wheel's power that pulls."
    );
    // One curve needs no legend.
    if group.is_empty() {
        Figure::labelled(panels.collect(), caption)
    } else {
        Figure::new(panels.collect(), caption)
    }
}

fn panel(
    group: &str,
    f: &ForceSlip,
    name: &str,
    si: &str,
    values: &[Value],
    points: Vec<Datum>,
) -> Option<Panel> {
    let rows = f.slip.iter().zip(values);
    let line: Vec<Datum> = rows
        .map(|(slip, (mean, sd))| Datum::at(*slip, *mean).sd(f64::NAN, *sd))
        .collect();
    let mut known = line.iter().filter(|d| d.is_finite());
    let (first, last) = (known.next()?.clone(), known.next_back()?.clone());
    let q = quantity(name, si);
    let said = |d: &Datum| {
        let spread = if d.y_sd.is_finite() {
            format!(" ± {}", number(d.y_sd * q.factor, 2))
        } else {
            String::new()
        };
        let mean = number(d.y * q.factor, 3);
        format!("{mean}{spread} at slip {}", number(d.x, 2))
    };
    let line_name = if group.is_empty() {
        "model"
    } else {
        "predicted ± 1 sd"
    };
    let series = vec![
        Series::new(line_name, Look::Line(Paint::After), line),
        Series::new("measured ± 1 sd", Look::Points { hollow: false }, points),
    ];
    let all = || series.iter().flat_map(Series::extent);
    let among = match group {
        "" => String::new(),
        name => format!(", {name}"),
    };
    let plot = Plot {
        layout: Layout::PANEL,
        x: Axis::over("slip", all().map(|p| p.0), 5).named("slip", "", 1.0),
        y: Axis::over(q.axis(), all().map(|p| p.1 * q.factor), 5).named(name, &q.unit, q.factor),
        title: format!("{} against slip{among}", capital(&q.label)),
        description: format!("From {} to {}.", said(&first), said(&last)),
        series,
    };
    Some(plot.draw())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wheel that neither slips nor sinks and whose torque all becomes pull loses nothing; slip takes its share.
    #[test]
    fn efficiency_of_a_wheel_without_losses() {
        assert_eq!(tractive_efficiency(40.0, 10.0, 0.0, 0.25), 1.0);
        assert_eq!(tractive_efficiency(40.0, 10.0, 0.25, 0.25), 0.75);
        for (pull, torque, slip) in [(-1.0, 10.0, 0.1), (1.0, -1.0, 0.1), (1.0, 1.0, -0.1)] {
            assert!(tractive_efficiency(pull, torque, slip, 0.25).is_nan());
        }
        assert_eq!(traction_coefficient((20.0, 2.0), 80.0), (0.25, 0.025));
    }
}
