//! Which soil it is: the posterior over time, its end, and the force it predicts.

use super::block::{Cell, Figure, Section, Table};
use super::data::{Datum, Look, Series};
use super::force_slip::{ForceSlip, forces};
use super::lines::{LABEL_PITCH, apart, thin, thin_to};
use super::number::{percent, with_sd};
use super::paint::{Paint, SERIES};
use super::plot::{Layout, Panel, Plot};
use super::scale::Axis;
use super::svg::{Anchor, Px};
use super::words::{capital, join_some, parameter, parameter_unit, unit_after};

/// Probability a hypothesis must once have had to get a line.
const SEEN: f64 = 0.02;
/// Rows of the table of the posterior.
const ROWS: usize = 12;
/// Probability from which a hypothesis has a row of its own, and how many have one whatever theirs.
const TOLD: f64 = 1e-3;
const LEAST_ROWS: usize = 4;
/// Room for a letter of a label \[px\].
const LETTER: f64 = 8.0;
/// Buckets of a parameter's path.
const PATH: usize = 80;
/// Spread over mean of a parameter that needs no figure to tell how it settled.
const SETTLED: f64 = 0.01;

/// How a soil parameter settles: mean and 1-sigma of the weighed soils after each step, SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterPath {
    /// Its name (`friction_angle`).
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// One value a step.
    pub mean: Vec<f64>,
    /// One value a step.
    pub sd: Vec<f64>,
    /// Mean and 1-sigma of the refined winner.
    pub refined: Option<(f64, f64)>,
}

/// What is known about one side, condition, or the whole log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupView {
    /// `left`, `right`, `all`, a condition.
    pub name: String,
    /// Time of each step \[s\]; steps are numbered where it is empty.
    pub time: Vec<f64>,
    /// Hypotheses, the columns of `probability`.
    pub ids: Vec<String>,
    /// Posterior of each step; no rows without history.
    pub probability: Vec<Vec<f64>>,
    /// Final posterior: hypothesis and probability.
    pub posterior: Vec<(String, f64)>,
    /// Mean of the soil parameters after each step; empty without history, or where soils obey several laws.
    pub parameters: Vec<ParameterPath>,
    /// Predicted forces.
    pub force_slip: Option<ForceSlip>,
    /// The true terrain, where a simulation knows it.
    pub truth: Option<String>,
    /// What the log does not determine, in words.
    pub undetermined: Vec<String>,
    /// Why the winner must not be trusted, and what else would explain the log.
    pub alarm: Option<String>,
}

/// An identification, ready to be told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IdentifyView {
    /// Heading of the section.
    pub title: String,
    /// Its groups, in order.
    pub groups: Vec<GroupView>,
}

/// The identification as a section: for each group the posterior over time, at the end, and the predicted forces.
pub fn identify_section(view: &IdentifyView) -> Section {
    let mut s = Section::new(view.title.clone());
    s.lead(sentence(view));
    for g in &view.groups {
        if view.groups.len() > 1 {
            s.heading(capital(&g.name));
        }
        if let Some(why) = &g.alarm {
            s.text(format!("Alarm: do not trust this soil; {why}."));
        }
        if g.probability.len() > 1 {
            s.figure(history(g));
        }
        s.table(posterior(g));
        settling(&mut s, g);
        if let Some(f) = g.force_slip.as_ref().filter(|f| f.slip.len() > 1) {
            s.figure(forces(&g.name, f));
        }
        if !g.undetermined.is_empty() {
            s.text(format!(
                "Not determined by this log: {}.",
                g.undetermined.join("; ")
            ));
        }
    }
    s
}

fn ranked(g: &GroupView) -> Vec<&(String, f64)> {
    let mut order: Vec<&(String, f64)> = g.posterior.iter().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    order
}

fn sentence(view: &IdentifyView) -> String {
    let parts: Vec<String> = view
        .groups
        .iter()
        .filter_map(|g| {
            let best = ranked(g).into_iter().next()?;
            let on = if view.groups.len() > 1 {
                format!("{}: ", capital(&g.name))
            } else {
                String::new()
            };
            let truth = match &g.truth {
                Some(t) if *t == best.0 => ", which is the truth".to_owned(),
                Some(t) => format!("; the truth is {t}"),
                None => String::new(),
            };
            Some(format!(
                "{on}the most probable soil is {} ({}){truth}.",
                best.0,
                percent(best.1)
            ))
        })
        .collect();
    if parts.is_empty() {
        return "No soil was weighed.".to_owned();
    }
    parts
        .iter()
        .map(|p| capital(p))
        .collect::<Vec<_>>()
        .join(" ")
}

fn posterior(g: &GroupView) -> Table {
    let mut t = Table::new(
        "Posterior at the end of the log.",
        &["Hypothesis", "#Probability"],
    );
    let order = ranked(g);
    // A long list of zeros says no more than their sum; the runners-up stay for comparison.
    let told = order.iter().filter(|o| o.1 >= TOLD).count();
    let rows = told.clamp(LEAST_ROWS, ROWS).min(order.len());
    for (id, p) in order.iter().take(rows) {
        let name = Cell::from(id.clone());
        let name = if g.truth.as_ref() == Some(id) {
            name.with_note("the truth of this simulation")
        } else {
            name
        };
        t.rows.push(vec![name, percent(*p).into()]);
    }
    if order.len() > rows {
        let rest: f64 = order.iter().skip(rows).map(|o| o.1).sum();
        t.rows.push(vec![
            format!("{} more together", order.len() - rows).into(),
            percent(rest).into(),
        ]);
    }
    t
}

/// Hypotheses that get a line: those that were ever seen, most probable at any time first.
fn shown(g: &GroupView) -> (Vec<usize>, usize) {
    let peak = |k: usize| {
        g.probability
            .iter()
            .filter_map(|row| row.get(k))
            .fold(0.0f64, |a, p| a.max(*p))
    };
    let last = |k: usize| {
        g.probability
            .last()
            .and_then(|row| row.get(k))
            .copied()
            .unwrap_or(0.0)
    };
    let mut seen: Vec<usize> = (0..g.ids.len()).filter(|&k| peak(k) > SEEN).collect();
    seen.sort_by(|&a, &b| {
        last(b)
            .total_cmp(&last(a))
            .then(peak(b).total_cmp(&peak(a)))
    });
    let more = seen.len().saturating_sub(SERIES);
    seen.truncate(SERIES);
    (seen, more)
}

/// Times of the steps, or their numbers, with the axis' title and column.
fn steps(g: &GroupView) -> (Vec<f64>, &'static str, &'static str) {
    if g.time.len() == g.probability.len() {
        (g.time.clone(), "time, s", "time_s")
    } else {
        let numbers = (1..=g.probability.len()).map(|k| k as f64);
        (numbers.collect(), "weighed sample", "sample")
    }
}

fn step_axis(g: &GroupView, ticks: usize) -> Axis {
    let (steps, title, name) = steps(g);
    let first = steps.first().copied().unwrap_or(0.0);
    let last = steps.last().copied().unwrap_or(1.0);
    let unit = if name == "time_s" { "s" } else { "" };
    Axis::linear(title, (first, last.max(first + 1e-9)), ticks).named(name, unit, 1.0)
}

fn history(g: &GroupView) -> Figure {
    let (seen, more) = shown(g);
    let times = steps(g).0;
    let name = |k: usize| g.ids.get(k).map_or("", String::as_str);
    let series: Vec<Series> = seen
        .iter()
        .enumerate()
        .map(|(line, &k)| {
            let points = times
                .iter()
                .zip(&g.probability)
                .filter_map(|(t, row)| Some(Datum::at(*t, *row.get(k)?)))
                .filter(Datum::is_finite)
                .collect();
            Series::new(name(k), Look::Line(Paint::Series(line)), thin(points))
        })
        .collect();
    let labels: Vec<String> = series
        .iter()
        .map(|s| {
            let last = s.data.last().map_or(0.0, |d| d.y);
            format!("{} {}", s.name, percent(last))
        })
        .collect();
    let longest = labels.iter().map(|l| l.chars().count()).max().unwrap_or(0);
    let plot = Plot {
        layout: Layout {
            width: 640.0,
            height: 320.0,
            left: 46.0,
            right: 34.0 + LETTER * longest.clamp(8, 40) as f64,
            top: 34.0,
            bottom: 48.0,
        },
        x: step_axis(g, 6),
        y: Axis::linear("Probability", (0.0, 1.0), 5).named("probability", "", 1.0),
        title: format!("Posterior over time, {}", g.name),
        description: format!("At the end: {}.", join_some(&labels, SERIES)),
        series,
    };
    let panel = plot.draw_with(|c| {
        // Labels stand beside the line ends, moved apart where ends meet, each tied to its end.
        let ends: Vec<Px> = plot
            .series
            .iter()
            .map(|s| s.data.last().map_or((0.0, 0.0), |d| c.at(d.x, d.y)))
            .collect();
        let heights: Vec<f64> = ends.iter().map(|e| e.1).collect();
        let (_, top) = c.place(0.0, 1.0);
        let bottom = c.place(0.0, 0.0).1 + LABEL_PITCH;
        for (k, (end, at)) in ends.iter().zip(apart(&heights, top, bottom)).enumerate() {
            let paint = Paint::Series(k);
            let tie = [(end.0 + 3.0, end.1), (end.0 + 20.0, at)];
            c.svg.open("class=\"tie\"");
            c.svg.line(&tie, Paint::Rule, 1.0);
            c.svg.dot(*end, 3.0, paint);
            c.svg.close();
            c.svg
                .open(&format!("class=\"entry\" data-key=\"{}\"", paint.name()));
            let label = labels.get(k).map_or("", String::as_str);
            c.svg.text((end.0 + 25.0, at), label, paint, Anchor::Left);
            c.svg.close();
        }
    });
    let mut caption = format!(
        "Posterior probability, {}. Lines for hypotheses that ever had more than 2\u{a0}%.",
        g.name
    );
    if more > 0 {
        caption.push_str(&format!(" {more} more not drawn."));
    }
    Figure::labelled(vec![panel], caption)
}

/// How the soil's parameters settle while the posterior does.
fn settling(s: &mut Section, g: &GroupView) {
    if g.probability.len() < 2 || g.parameters.is_empty() {
        return;
    }
    let unsettled = |p: &ParameterPath| {
        let spread = p.mean.iter().zip(&p.sd);
        spread
            .into_iter()
            .any(|(mean, sd)| *sd > SETTLED * mean.abs())
    };
    if g.parameters.iter().any(unsettled) {
        s.figure(parameters(g));
    } else {
        s.text(
            "The first weighed sample already left one soil: its parameters had nothing to settle.",
        );
    }
}

fn parameters(g: &GroupView) -> Figure {
    let panels = g.parameters.iter().map(|p| path(g, p)).collect();
    Figure::new(
        panels,
        format!(
            "Soil parameters as the soils are weighed, {}: mean of all hypotheses, band ± 1 sd of their spread; the point at the end is the refined winner.",
            g.name
        ),
    )
}

fn path(g: &GroupView, p: &ParameterPath) -> Panel {
    let times = steps(g).0;
    let end = times.last().copied().unwrap_or(0.0);
    let values = times.iter().zip(&p.mean).zip(&p.sd);
    let weighed = values.map(|((t, mean), sd)| Datum::at(*t, *mean).sd(f64::NAN, *sd));
    let refined = p
        .refined
        .map(|(mean, sd)| Datum::at(end, mean).sd(f64::NAN, sd));
    let series = vec![
        Series::new(
            "weighed ± 1 sd",
            Look::Line(Paint::After),
            thin_to(weighed.collect(), PATH),
        ),
        Series::new(
            "refined ± 1 sd",
            Look::Points { hollow: false },
            refined.into_iter().collect(),
        ),
    ];
    let words = parameter(&p.name);
    let (unit, factor) = parameter_unit(&p.unit, p.mean.iter().copied());
    let title = match unit.as_str() {
        "" => words.clone(),
        unit => format!("{words}, {unit}"),
    };
    let ys = || series.iter().flat_map(Series::extent).map(|e| e.1 * factor);
    let said = |v: Option<(f64, f64)>| {
        let (mean, sd) = v.unwrap_or((f64::NAN, f64::NAN));
        unit_after(&with_sd(mean * factor, sd * factor), &unit)
    };
    let last = p.mean.last().copied().zip(p.sd.last().copied());
    let plot = Plot {
        layout: Layout::PANEL,
        x: step_axis(g, 4),
        y: Axis::over(title.clone(), ys(), 5).named(&p.name, &unit, factor),
        title: format!("{words}, {}", g.name),
        description: format!(
            "{} at the end; refined {}.",
            said(last),
            p.refined.map_or("not".to_owned(), |r| said(Some(r)))
        ),
        series,
    };
    plot.draw()
}
