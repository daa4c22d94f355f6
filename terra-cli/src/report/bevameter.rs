//! Curves of a bevameter with the laws through them.

use terra_model::bevameter::{Fits, Interval, LawFit};

use super::block::{Cell, Figure, Item, Section, Table};
use super::data::{Datum, Look, Series};
use super::number::{number, share};
use super::paint::Paint;
use super::plot::{self, Layout, Plot};
use super::scale::Axis;
use super::words::{unit, unit_after};

/// Panels of one soil, a test each.
const PANELS: usize = 9;

/// One soil, ready to be told.
#[derive(Clone, Debug)]
pub struct BevameterView {
    /// Heading of the section.
    pub title: String,
    /// Shear tests; plates otherwise.
    pub shear: bool,
    /// What the fits found.
    pub fits: Fits,
}

/// The soil as a section: what it is, how each law does, what cannot be known, and every test with the laws through it.
pub fn bevameter_section(view: &BevameterView) -> Section {
    let mut s = Section::new(view.title.clone());
    let fits = &view.fits;
    if let Some(best) = fits.best() {
        s.lead(format!(
            "Of {} laws {} describes the tests best, with a misfit of {} of the stress.",
            fits.laws.len(),
            best.law,
            share(best.rms_share)
        ));
    }
    let mut table = Table::new(
        "Least squares of the stress over all tests, each with the same weight.",
        &[
            "law",
            "parameter",
            "#value",
            "#95 % interval",
            "#misfit",
            "#BIC above the best",
        ],
    );
    for law in &fits.laws {
        for (k, p) in law.parameters.iter().enumerate() {
            let first = |text: String| if k == 0 { text } else { String::new() };
            table.rows.push(vec![
                Cell::from(first(law.law.to_owned())),
                Cell::from(p.name),
                Cell::from(unit_after(&number(p.value, 3), &unit(p.unit))),
                Cell::from(if p.low.is_finite() && p.high.is_finite() {
                    format!("{} to {}", number(p.low, 3), number(p.high, 3))
                } else {
                    "not known".to_owned()
                }),
                Cell::from(first(share(law.rms_share))),
                Cell::from(first(number(law.delta_bic, 2))),
            ]);
        }
    }
    s.table(table);
    s.text(match fits.laws.first().map(|l| l.interval) {
        Some(Interval::BetweenTests) => {
            "Intervals come from how the tests differ, one left out at a time."
        }
        Some(Interval::NotKnown) => {
            "No intervals: what the laws leave over in this one test is misfit, not chance."
        }
        _ => {
            "Intervals come from the correlated residuals within the tests: they say how well the curve is drawn, not how much the ground varies."
        }
    });
    if !fits.undetermined.is_empty() {
        s.heading("What these tests cannot tell");
        s.list(
            fits.undetermined
                .iter()
                .map(|u| {
                    let (name, text) = u.split_once(": ").unwrap_or(("", u));
                    Item {
                        name: name.to_owned(),
                        text: text.to_owned(),
                    }
                })
                .collect(),
        );
    }
    s.figure(figure(view));
    s
}

fn figure(view: &BevameterView) -> Figure {
    let fits = &view.fits;
    let first = fits.laws.first();
    let best = fits
        .best()
        .filter(|b| first.is_some_and(|f| f.law != b.law));
    let shown = fits.tests.len().min(PANELS);
    let panels: Vec<Panel> = (0..shown)
        .filter_map(|k| Panel::new(view, k, first, best))
        .collect();
    // The same axes for all, from zero: how far tests of one soil differ is what a reader looks for.
    let all = || {
        panels
            .iter()
            .flat_map(|p| &p.series)
            .flat_map(Series::extent)
    };
    let x = || std::iter::once(0.0).chain(all().map(|p| 1e3 * p.0));
    let y = || std::iter::once(0.0).chain(all().map(|p| 1e-3 * p.1));
    let drawn = panels
        .iter()
        .map(|panel| panel.draw(view.shear, shown == 1, x(), y()));
    Figure::new(
        drawn.collect(),
        match fits.tests.len().saturating_sub(PANELS) {
            0 => CAPTION.to_owned(),
            more => format!("{CAPTION} {more} more not drawn."),
        },
    )
}

const CAPTION: &str = "Measured points (averages over equal steps) and laws fitted to all tests of the soil together.";

/// One test and what the laws say of it.
struct Panel {
    test: String,
    /// Plate diameter in mm, or normal stress in kPa.
    given: String,
    series: Vec<Series>,
    points: usize,
    peak: (f64, f64),
}

impl Panel {
    fn new(
        view: &BevameterView,
        k: usize,
        first: Option<&LawFit>,
        best: Option<&LawFit>,
    ) -> Option<Self> {
        let test = view.fits.tests.get(k)?;
        let points = test.points.iter().map(|p| Datum::at(p.0, p.1));
        let mut series = vec![Series::new("measured", Look::Dots, points.collect())];
        for (law, paint, what) in [
            (first, Paint::Before, ""),
            (best, Paint::After, ", the best"),
        ] {
            let Some((law, fitted)) = law.and_then(|l| Some((l, l.fitted.get(k)?))) else {
                continue;
            };
            let line = test.points.iter().zip(fitted);
            series.push(Series::new(
                format!("{}{what}", law.law),
                Look::Line(paint),
                line.map(|(p, y)| Datum::at(p.0, *y)).collect(),
            ));
        }
        Some(Panel {
            test: test.test.clone(),
            given: if view.shear {
                format!("{}\u{a0}kPa", number(1e-3 * test.given, 3))
            } else {
                format!("{}\u{a0}mm plate", number(2e3 * test.given, 3))
            },
            series,
            points: test.points.len(),
            peak: (1e3 * test.peak.0, 1e-3 * test.peak.1),
        })
    }

    fn draw(
        &self,
        shear: bool,
        alone: bool,
        x: impl Iterator<Item = f64>,
        y: impl Iterator<Item = f64>,
    ) -> plot::Panel {
        let ((across, across_si), (upright, upright_si)) = if shear {
            (
                ("shear displacement, mm", "shear_displacement_m"),
                ("shear stress, kPa", "shear_stress_Pa"),
            )
        } else {
            (
                ("sinkage, mm", "sinkage_m"),
                ("pressure, kPa", "pressure_Pa"),
            )
        };
        let name = format!("Test {}, {}", self.test, self.given);
        let plot = Plot {
            layout: if alone { Layout::ALONE } else { Layout::PANEL },
            x: Axis::over(across, x, 5).named(across_si, "mm", 1e3),
            y: Axis::over(format!("{name}: {upright}"), y, 5).named(upright_si, "kPa", 1e-3),
            title: name,
            description: format!(
                "{} points, largest stress {} kPa at {} mm.",
                self.points,
                number(self.peak.1, 3),
                number(self.peak.0, 3)
            ),
            series: self.series.clone(),
        };
        plot.draw()
    }
}
