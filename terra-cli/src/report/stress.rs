//! Stress along the contact: the ground's normal and shear stress on the rim against the angle.

use super::data::{Datum, Look, Series};
use super::number::number;
use super::paint::Paint;
use super::plot::{Layout, Panel, Plot};
use super::scale::Axis;

const DEGREE: f64 = 180.0 / std::f64::consts::PI;

/// One contact.
pub(super) struct Profile<'a> {
    pub(super) name: String,
    pub(super) paint: Paint,
    /// Angle \[rad\], normal and shear stress \[Pa\].
    pub(super) points: &'a [[f64; 3]],
}

/// Normal and shear stress, a panel each.
pub(super) fn panels(profiles: &[Profile<'_>]) -> Vec<Panel> {
    vec![
        panel(profiles, "Normal stress", "normal_stress_Pa", |p| p[1]),
        panel(profiles, "Shear stress", "shear_stress_Pa", |p| p[2]),
    ]
}

fn panel(profiles: &[Profile<'_>], title: &str, name: &str, stress: fn(&[f64; 3]) -> f64) -> Panel {
    let series: Vec<Series> = profiles
        .iter()
        .map(|profile| {
            let points = profile.points.iter().map(|p| Datum::at(p[0], stress(p)));
            let look = Look::Line(profile.paint);
            Series::new(profile.name.as_str(), look, points.collect())
        })
        .collect();
    let said: Vec<String> = series
        .iter()
        .filter_map(|s| {
            let most = s
                .data
                .iter()
                .max_by(|a, b| a.y.abs().total_cmp(&b.y.abs()))?;
            Some(format!(
                "{}: {} kPa at {} deg",
                s.name,
                number(1e-3 * most.y, 3),
                number(DEGREE * most.x, 3)
            ))
        })
        .collect();
    let all = || series.iter().flat_map(Series::extent);
    let y = all().map(|p| 1e-3 * p.1).chain([0.0]);
    let plot = Plot {
        layout: Layout::PANEL,
        x: Axis::over("angle, deg", all().map(|p| DEGREE * p.0), 5).named(
            "angle_rad",
            "deg",
            DEGREE,
        ),
        y: Axis::over(format!("{title}, kPa"), y, 5).named(name, "kPa", 1e-3),
        title: format!("{title} along the contact"),
        description: format!("Largest: {}.", said.join("; ")),
        series,
    };
    plot.draw()
}
