//! Profile likelihoods: how far each parameter can move when all others follow.

use terra_mme::Profile;

use super::ReportError;
use super::block::{Figure, Item, Section};
use super::figure::{Layout, Plot};
use super::number::number;
use super::paint::Paint;
use super::scale::Axis;

/// Δ of the 95 % interval.
const LEVEL: f64 = 3.84;
/// Largest Δ drawn.
const TOP: f64 = 8.0;

/// A design, ready to be told.
#[derive(Clone, Debug)]
pub struct ProfilesView {
    /// Heading.
    pub title: String,
    /// The sentence the section is for.
    pub lead: String,
    /// What the design cannot tell, in words.
    pub undetermined: Vec<String>,
    /// One panel each.
    pub profiles: Vec<Profile>,
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

fn figure(view: &ProfilesView) -> Result<Figure, ReportError> {
    let panels = view
        .profiles
        .iter()
        .filter(|p| p.points.len() > 1)
        .map(panel)
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Figure {
        panels,
        legend: vec![],
        caption: "Misfit Δ of the expected data when one parameter is moved and all others follow; the grey line is the 95 % level 3.84. A curve that stays below it has no end within six prior sd.".to_owned(),
    })
}

fn panel(p: &Profile) -> Result<String, ReportError> {
    let shown: Vec<(f64, f64)> = p
        .points
        .iter()
        .copied()
        .filter(|point| point.1 <= TOP)
        .collect();
    let end = |e: Option<f64>| e.map_or("no end".to_owned(), |v| number(v, 3));
    let plot = Plot {
        layout: Layout::PANEL,
        x: Axis::over(p.name.replace('_', " "), shown.iter().map(|v| v.0), 4),
        y: Axis::linear("Misfit Δ", (0.0, TOP), 4),
        title: format!("Profile of {}", p.name.replace('_', " ")),
        description: format!("95 % from {} to {}.", end(p.low), end(p.high)),
    };
    let (first, last) = (plot.x.range.0, plot.x.range.1);
    plot.draw(|c| {
        c.line(&[(first, LEVEL), (last, LEVEL)], Paint::Rule, 1)?;
        c.line(&shown, Paint::After, 2)
    })
}
