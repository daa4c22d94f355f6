//! Which soil it is: the posterior over time, its end, and the force it predicts.

use super::ReportError;
use super::block::{Cell, Figure, Key, Section, Table};
use super::figure::{Anchor, Layout, Plot};
use super::lines::{LABEL_PITCH, apart, thin};
use super::number::{number, percent};
use super::paint::{Paint, SERIES};
use super::scale::Axis;
use super::words::join_some;

/// Probability a hypothesis must once have had to get a line.
const SEEN: f64 = 0.02;
/// Rows of the table of the posterior.
const ROWS: usize = 12;
/// Probability from which a hypothesis has a row of its own, and how many have one whatever theirs.
const TOLD: f64 = 1e-3;
const LEAST_ROWS: usize = 4;
/// Room for a letter of a label \[px\].
const LETTER: i32 = 8;

/// Drawbar pull and torque against slip, at one load, with 1-sigma. All of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForceSlip {
    /// Library slip.
    pub slip: Vec<f64>,
    /// \[N\]
    pub drawbar_mean: Vec<f64>,
    /// \[N\]
    pub drawbar_sd: Vec<f64>,
    /// \[N m\]
    pub torque_mean: Vec<f64>,
    /// \[N m\]
    pub torque_sd: Vec<f64>,
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
            s.heading(super::words::capital(&g.name));
        }
        if let Some(why) = &g.alarm {
            s.text(format!("Alarm: do not trust this soil; {why}."));
        }
        if g.probability.len() > 1 {
            s.figure(history(g));
        }
        s.table(posterior(g));
        if let Some(f) = g.force_slip.as_ref().filter(|f| f.slip.len() > 1) {
            s.figure(forces(g, f));
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
                format!("{}: ", super::words::capital(&g.name))
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
        .map(|p| super::words::capital(p))
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

fn history(g: &GroupView) -> Result<Figure, ReportError> {
    let (seen, more) = shown(g);
    let timed = g.time.len() == g.probability.len();
    let times: Vec<f64> = if timed {
        g.time.clone()
    } else {
        (1..=g.probability.len()).map(|k| k as f64).collect()
    };
    let (first, last) = (
        times.first().copied().unwrap_or(0.0),
        times.last().copied().unwrap_or(1.0),
    );
    let lines: Vec<Vec<(f64, f64)>> = seen
        .iter()
        .map(|&k| {
            let points = times
                .iter()
                .zip(&g.probability)
                .filter_map(|(t, row)| Some((*t, *row.get(k)?)))
                .filter(|p| p.0.is_finite() && p.1.is_finite())
                .collect();
            thin(points)
        })
        .collect();
    let name = |k: usize| g.ids.get(k).map_or("", String::as_str);
    let labels: Vec<String> = seen
        .iter()
        .zip(&lines)
        .map(|(&k, line)| format!("{} {}", name(k), percent(line.last().map_or(0.0, |p| p.1))))
        .collect();
    let longest = labels
        .iter()
        .map(|l| l.chars().count() as i32)
        .fold(8, i32::max)
        .min(40);
    let plot = Plot {
        layout: Layout {
            width: 640,
            height: 320,
            left: 46,
            right: 34 + LETTER * longest,
            top: 34,
            bottom: 48,
        },
        x: Axis::linear(
            if timed { "time, s" } else { "weighed sample" },
            (first, last.max(first + 1e-9)),
            6,
        ),
        y: Axis::linear("Probability", (0.0, 1.0), 5),
        title: format!("Posterior over time, {}", g.name),
        description: format!("At the end: {}.", join_some(&labels, SERIES)),
    };
    let svg = plot.draw(|c| {
        for (series, line) in lines.iter().enumerate() {
            c.line(line, Paint::Series(series), 2)?;
        }
        // Labels stand beside the line ends, moved apart where ends meet, each tied to its end.
        let ends: Vec<i32> = lines
            .iter()
            .map(|l| l.last().map_or(0, |p| c.height_of(p.1)))
            .collect();
        let low = c.height_of(1.0);
        let high = c.height_of(0.0) + LABEL_PITCH;
        for (series, (line, at)) in lines.iter().zip(apart(&ends, low, high)).enumerate() {
            let (Some(&end), Some(text)) = (line.last(), labels.get(series)) else {
                continue;
            };
            let dy = at - c.height_of(end.1);
            c.stroke_px(end, (3, 0), (20, dy), Paint::Rule)?;
            c.dot(end, 3, Paint::Series(series))?;
            c.text(end, (25, dy), text, Paint::Series(series), Anchor::Left)?;
        }
        Ok(())
    })?;
    let mut caption = format!(
        "Posterior probability, {}. Lines for hypotheses that ever had more than 2\u{a0}%.",
        g.name
    );
    if more > 0 {
        caption.push_str(&format!(" {more} more not drawn."));
    }
    Ok(Figure {
        panels: vec![svg],
        legend: vec![],
        caption,
    })
}

fn forces(g: &GroupView, f: &ForceSlip) -> Result<Figure, ReportError> {
    let panels = [
        ("Drawbar pull, N", &f.drawbar_mean, &f.drawbar_sd),
        ("Wheel torque, N\u{a0}m", &f.torque_mean, &f.torque_sd),
    ]
    .into_iter()
    .filter(|(_, mean, _)| mean.iter().filter(|v| v.is_finite()).count() > 1)
    .map(|(title, mean, sd)| band(g, title, &f.slip, mean, sd))
    .collect::<Result<Vec<_>, _>>()?;
    Ok(Figure {
        panels,
        legend: vec![Key {
            sample: "after",
            text: "predicted mean, band ± 1 sd".to_owned(),
        }],
        caption: format!(
            "Force that the weighed soils predict for a wheel, {}.",
            g.name
        ),
    })
}

fn band(
    g: &GroupView,
    title: &str,
    slip: &[f64],
    mean: &[f64],
    sd: &[f64],
) -> Result<String, ReportError> {
    let rows: Vec<(f64, f64, f64)> = slip
        .iter()
        .zip(mean)
        .zip(sd)
        .map(|((s, m), d)| (*s, *m, if d.is_finite() { *d } else { 0.0 }))
        .filter(|r| r.0.is_finite() && r.1.is_finite())
        .collect();
    let line =
        |k: f64| -> Vec<(f64, f64)> { rows.iter().map(|(s, m, d)| (*s, m + k * d)).collect() };
    let (low, middle, high) = (line(-1.0), line(0.0), line(1.0));
    let said: Vec<String> = [rows.first(), rows.last()]
        .into_iter()
        .flatten()
        .map(|(s, m, d)| {
            format!(
                "{} ± {} at slip {}",
                number(*m, 3),
                number(*d, 2),
                number(*s, 2)
            )
        })
        .collect();
    let plot = Plot {
        layout: Layout::PANEL,
        x: Axis::over("slip", rows.iter().map(|r| r.0), 5),
        y: Axis::over(title, low.iter().chain(&high).map(|p| p.1), 5),
        title: format!("{title} against slip, {}", g.name),
        description: format!("From {}.", said.join(" to ")),
    };
    plot.draw(|c| {
        c.band(&low, &high, Paint::After)?;
        c.line(&middle, Paint::After, 2)
    })
}
