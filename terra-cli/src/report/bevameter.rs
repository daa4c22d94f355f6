//! Curves of a bevameter with the laws through them.

use terra_model::bevameter::{Fits, Interval, LawFit};

use super::ReportError;
use super::block::{Cell, Figure, Item, Key, Section, Table};
use super::figure::{Layout, Plot};
use super::number::{number, share};
use super::paint::Paint;
use super::scale::Axis;
use super::words::{join_some, unit, unit_after};

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
                Cell::from(format!("{} to {}", number(p.low, 3), number(p.high, 3))),
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
    let panels = (0..fits.tests.len().min(PANELS))
        .map(|k| panel(view, k, first, best))
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
    let names: Vec<&str> = fits.tests.iter().map(|t| t.test.as_str()).collect();
    Ok(Figure {
        panels,
        legend,
        caption: format!(
            "Measured points (averages over equal steps) and laws fitted to all tests together: {}.",
            join_some(&names, PANELS)
        ),
    })
}

fn panel(
    view: &BevameterView,
    k: usize,
    first: Option<&LawFit>,
    best: Option<&LawFit>,
) -> Result<String, ReportError> {
    let Some(test) = view.fits.tests.get(k) else {
        return Ok(String::new());
    };
    let shown = |(x, stress): (f64, f64)| (1e3 * x, 1e-3 * stress);
    let points: Vec<(f64, f64)> = test.points.iter().map(|p| shown(*p)).collect();
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
    let (plain, better) = (line(first), line(best));
    let (x, y) = if view.shear {
        ("shear displacement, mm", "Shear stress, kPa")
    } else {
        ("sinkage, mm", "Pressure, kPa")
    };
    let all = || points.iter().chain(&plain).chain(&better);
    let plot = Plot {
        layout: Layout::PANEL,
        x: Axis::over(x, all().map(|p| p.0), 5),
        y: Axis::over(y, all().map(|p| p.1), 5),
        title: format!("Test {}", test.test),
        description: format!(
            "{} points, largest stress {} kPa at {} mm.",
            points.len(),
            number(1e-3 * test.peak.1, 3),
            number(1e3 * test.peak.0, 3)
        ),
    };
    plot.draw(|c| {
        for p in &points {
            c.dot(*p, 2, Paint::Ink)?;
        }
        c.line(&plain, Paint::Before, 2)?;
        c.line(&better, Paint::After, 2)
    })
}
