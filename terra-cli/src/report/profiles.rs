//! Profile likelihoods: how far each parameter can move when all others follow.

use terra_mme::Profile;

use super::block::{Figure, Item, Section};
use super::data::{Datum, Look, Series};
use super::number::number;
use super::paint::Paint;
use super::plot::{Layout, Panel, Plot};
use super::scale::Axis;
use super::words::{parameter, parameter_unit, unit_after};

/// Δ of the 95 % interval.
const LEVEL: f64 = 3.84;
/// Largest Δ drawn.
const TOP: f64 = 8.0;
/// Ratio of ends from which an axis is logarithmic.
const WIDE: f64 = 30.0;

/// A design, ready to be told.
#[derive(Clone, Debug)]
pub struct ProfilesView {
    /// Heading.
    pub title: String,
    /// The sentence the section is for.
    pub lead: String,
    /// What the design cannot tell, in words.
    pub undetermined: Vec<String>,
    /// One panel each, with the SI unit of its parameter.
    pub profiles: Vec<(Profile, String)>,
}

/// The profiles as a section.
pub fn profiles_section(view: &ProfilesView) -> Section {
    let mut s = Section::new(view.title.clone());
    s.lead(view.lead.clone());
    if !view.undetermined.is_empty() {
        s.heading("What this design cannot tell");
        let items = view.undetermined.iter().map(|u| Item {
            name: String::new(),
            text: u.clone(),
        });
        s.list(items.collect());
    }
    s.figure(figure(view));
    s
}

fn figure(view: &ProfilesView) -> Figure {
    let profiles = view.profiles.iter().filter(|p| p.0.points.len() > 1);
    Figure::labelled(
        profiles.map(|(p, si)| panel(p, si)).collect(),
        "Misfit Δ of the expected data when one parameter is moved and all others follow; the grey line is the 95\u{a0}% level 3.84. A curve that stays below it has no end within six prior sd.",
    )
}

fn panel(p: &Profile, si: &str) -> Panel {
    let shown: Vec<Datum> = p
        .points
        .iter()
        .filter(|point| point.1 <= TOP)
        .map(|point| Datum::at(point.0, point.1))
        .collect();
    let values = || shown.iter().map(|d| d.x);
    let (unit, factor) = parameter_unit(si, values());
    let words = parameter(p.name);
    let title = match unit.as_str() {
        "" => words.clone(),
        unit => format!("{words}, {unit}"),
    };
    let low = factor * values().fold(f64::INFINITY, f64::min);
    let high = factor * values().fold(f64::NEG_INFINITY, f64::max);
    let x = if low > 0.0 && high > WIDE * low {
        Axis::logarithmic(title, low / 1.2, high * 1.2)
    } else {
        Axis::over(title, [low, high], 4)
    };
    let end = |e: Option<f64>| e.map_or("no end".to_owned(), |v| number(v * factor, 3));
    let plot = Plot {
        layout: Layout::PANEL,
        x: x.named(p.name, &unit, factor),
        y: Axis::linear("Misfit Δ", (0.0, TOP), 4).named("misfit", "", 1.0),
        title: format!("Profile of {words}"),
        description: format!(
            "95\u{a0}% from {} to {}.",
            end(p.low),
            unit_after(&end(p.high), &unit)
        ),
        series: vec![Series::new("misfit Δ", Look::Line(Paint::After), shown)],
    };
    let (first, last) = plot.x.range;
    plot.draw_with(|c| {
        let level = [c.place(first, LEVEL), c.place(last, LEVEL)];
        c.svg.line(&level, Paint::Muted, 1.0);
    })
}
