//! Curves of a bevameter with the laws through them.

use terra_model::bevameter::{Fits, Interval, LawFit};

use super::ReportError;
use super::block::{Cell, Figure, Item, Key, Section, Table};
use super::figure::{Layout, Plot};
use super::number::{number, share};
use super::paint::Paint;
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

fn figure(view: &BevameterView) -> Result<Figure, ReportError> {
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
    let all = || panels.iter().flat_map(Panel::all);
    let x = || std::iter::once(0.0).chain(all().map(|p| p.0));
    let y = || std::iter::once(0.0).chain(all().map(|p| p.1));
    let panels = panels
        .iter()
        .map(|panel| panel.draw(view.shear, shown == 1, x(), y()))
        .collect::<Result<Vec<_>, _>>()?;
    let mut legend = vec![];
    if let Some(law) = first {
        legend.push(Key {
            sample: "before",
            text: law.law.to_owned(),
        });
    }
    if let Some(law) = best {
        legend.push(Key {
            sample: "after",
            text: format!("{}, the best", law.law),
        });
    }
    Ok(Figure {
        panels,
        legend,
        caption: match fits.tests.len().saturating_sub(PANELS) {
            0 => CAPTION.to_owned(),
            more => format!("{CAPTION} {more} more not drawn."),
        },
    })
}

const CAPTION: &str = "Measured points (averages over equal steps) and laws fitted to all tests of the soil together.";

/// One test and what the laws say of it, in mm and kPa.
struct Panel {
    test: String,
    /// Plate diameter in mm, or normal stress in kPa.
    given: String,
    points: Vec<(f64, f64)>,
    plain: Vec<(f64, f64)>,
    better: Vec<(f64, f64)>,
    peak: (f64, f64),
}

fn shown((x, stress): (f64, f64)) -> (f64, f64) {
    (1e3 * x, 1e-3 * stress)
}

impl Panel {
    fn new(
        view: &BevameterView,
        k: usize,
        first: Option<&LawFit>,
        best: Option<&LawFit>,
    ) -> Option<Self> {
        let test = view.fits.tests.get(k)?;
        let line = |law: Option<&LawFit>| -> Vec<(f64, f64)> {
            let fitted = law.and_then(|l| l.fitted.get(k));
            fitted.map_or(vec![], |f| {
                test.points
                    .iter()
                    .zip(f)
                    .map(|(p, y)| shown((p.0, *y)))
                    .collect()
            })
        };
        Some(Panel {
            test: test.test.clone(),
            given: if view.shear {
                format!("{}\u{a0}kPa", number(1e-3 * test.given, 3))
            } else {
                format!("{}\u{a0}mm plate", number(2e3 * test.given, 3))
            },
            points: test.points.iter().map(|p| shown(*p)).collect(),
            plain: line(first),
            better: line(best),
            peak: shown(test.peak),
        })
    }

    fn all(&self) -> impl Iterator<Item = &(f64, f64)> {
        self.points.iter().chain(&self.plain).chain(&self.better)
    }

    fn draw(
        &self,
        shear: bool,
        alone: bool,
        x: impl Iterator<Item = f64>,
        y: impl Iterator<Item = f64>,
    ) -> Result<String, ReportError> {
        let (across, upright) = if shear {
            ("shear displacement, mm", "shear stress, kPa")
        } else {
            ("sinkage, mm", "pressure, kPa")
        };
        let plot = Plot {
            layout: if alone { Layout::ALONE } else { Layout::PANEL },
            x: Axis::over(across, x, 5),
            y: Axis::over(
                format!("Test {}, {}: {upright}", self.test, self.given),
                y,
                5,
            ),
            title: format!("Test {}, {}", self.test, self.given),
            description: format!(
                "{} points, largest stress {} kPa at {} mm.",
                self.points.len(),
                number(self.peak.1, 3),
                number(self.peak.0, 3)
            ),
        };
        plot.draw(|c| {
            for p in &self.points {
                c.dot(*p, 2, Paint::Ink)?;
            }
            c.line(&self.plain, Paint::Before, 2)?;
            c.line(&self.better, Paint::After, 2)
        })
    }
}
