//! What the ground did to a vehicle, over time: forces of the sides, torque, slip and load of each wheel, with bands.

use super::block::{Figure, Section};
use super::data::{Datum, Look, Series};
use super::lines::thin_to;
use super::number::{count, number, share};
use super::paint::Paint;
use super::plot::{Layout, Panel, Plot};
use super::scale::Axis;
use super::words::{capital, quantity};

/// Buckets of a panel's line.
const BUCKETS: usize = 120;

/// One estimated quantity over time, in SI units, one value a row of the log; NaN where there is none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channel {
    /// Column name (`resistive_torque_fl_N_m`).
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Estimates.
    pub value: Vec<f64>,
    /// Their 1-sigma.
    pub sd: Vec<f64>,
}

/// An estimate, ready to be told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EstimateView {
    /// Heading.
    pub title: String,
    /// Time of each row \[s\].
    pub time: Vec<f64>,
    /// Name and first row of each segment.
    pub segments: Vec<(String, usize)>,
    /// How many rows carry each flag.
    pub flags: Vec<(String, usize)>,
    /// Figures: heading, caption, and channels that share an axis.
    pub figures: Vec<(String, String, Vec<Channel>)>,
}

/// The estimate as a section: how far to trust it, then its figures.
pub fn estimate_section(view: &EstimateView) -> Section {
    let mut s = Section::new(view.title.clone());
    s.lead(lead(view));
    if view.flags.iter().any(|f| f.0 != "ok") {
        let rows = view.flags.iter().map(|(name, n)| {
            (
                name.clone(),
                vec![format!(
                    "{n} rows, {}",
                    share(*n as f64 / view.time.len() as f64)
                )],
            )
        });
        s.facts(rows.collect());
    }
    for (heading, caption, channels) in &view.figures {
        let figure = figure(view, caption, channels);
        if !figure.panels.is_empty() {
            s.heading(heading.clone());
            s.figure(figure);
        }
    }
    s
}

fn lead(view: &EstimateView) -> String {
    let good = view.flags.iter().find(|f| f.0 == "ok").map_or(0, |f| f.1);
    let rows = view.time.len();
    format!(
        "{} in {}: {} of them without reserve.",
        count(rows, "row"),
        count(view.segments.len(), "segment"),
        share(good as f64 / rows.max(1) as f64)
    )
}

fn figure(view: &EstimateView, caption: &str, channels: &[Channel]) -> Figure {
    let lines: Vec<(&Channel, Series)> = channels
        .iter()
        .map(|c| (c, series(view, c)))
        .filter(|(_, s)| s.data.iter().filter(|d| d.is_finite()).count() > 1)
        .collect();
    // Wheels are compared with each other: the same axis for all of one quantity.
    let panels = lines.iter().map(|(channel, series)| {
        let alike = lines.iter().filter(|(c, _)| kind(c) == kind(channel));
        let extent: Vec<(f64, f64)> = alike.flat_map(|(_, s)| typical(s)).collect();
        panel(view, channel, series.clone(), &extent)
    });
    let thinned = if view.time.len() > 2 * BUCKETS {
        " Long lines keep the extremes of each stretch; the table has every row."
    } else {
        ""
    };
    Figure::new(panels.collect(), format!("{caption}{thinned}"))
}

/// What a channel is, whatever the wheel: channels of one kind share their axis.
fn kind(c: &Channel) -> String {
    let label = quantity(&c.name, &c.unit).label;
    let stem = label.split(" (").next().unwrap_or(&label);
    stem.trim_end_matches(" left")
        .trim_end_matches(" right")
        .to_owned()
}

/// Where the values are known, and not only known to be unknown: the sd of a start is no reason to shrink what follows.
fn typical(s: &Series) -> Vec<(f64, f64)> {
    let finite = || s.data.iter().filter(|d| d.is_finite());
    let most = 3.0 * median(finite().map(|d| d.y_sd)).unwrap_or(0.0);
    finite()
        .flat_map(|d| {
            let sd = if d.y_sd.is_finite() {
                d.y_sd.min(most)
            } else {
                0.0
            };
            [(d.x, d.y - sd), (d.x, d.y + sd)]
        })
        .collect()
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut finite: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    finite.sort_by(f64::total_cmp);
    finite.get(finite.len() / 2).copied()
}

fn series(view: &EstimateView, c: &Channel) -> Series {
    let mut data = vec![];
    for (row, t) in view.time.iter().enumerate() {
        if row > 0 && view.segments.iter().any(|s| s.1 == row) {
            data.push(Datum::at(f64::NAN, f64::NAN));
        }
        let at = |v: &[f64]| v.get(row).copied().unwrap_or(f64::NAN);
        data.push(Datum::at(*t, at(&c.value)).sd(f64::NAN, at(&c.sd)));
    }
    Series::new(
        "estimate ± 1 sd",
        Look::Line(Paint::After),
        thin_to(data, BUCKETS),
    )
}

fn panel(view: &EstimateView, c: &Channel, series: Series, extent: &[(f64, f64)]) -> Panel {
    let q = quantity(&c.name, &c.unit);
    let finite: Vec<f64> = c.value.iter().copied().filter(|v| v.is_finite()).collect();
    let low = finite.iter().copied().fold(f64::INFINITY, f64::min);
    let high = finite.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let sd = median(c.sd.iter().copied()).unwrap_or(f64::NAN);
    let times = || view.time.iter().copied();
    let (first, last) = (
        times().fold(f64::INFINITY, f64::min),
        times().fold(f64::NEG_INFINITY, f64::max),
    );
    let plot = Plot {
        layout: Layout::PANEL,
        x: Axis::linear("time, s", (first, last.max(first + 1e-9)), 5).named("time_s", "s", 1.0),
        y: Axis::over(q.axis(), extent.iter().map(|p| p.1 * q.factor), 5)
            .named(&c.name, &q.unit, q.factor),
        title: format!("{} over time", capital(&q.label)),
        description: format!(
            "Between {} and {}{}, sd {} in the middle.",
            number(low * q.factor, 3),
            number(high * q.factor, 3),
            if q.unit.is_empty() {
                String::new()
            } else {
                format!(" {}", q.unit)
            },
            number(sd * q.factor, 2)
        ),
        series: vec![series],
    };
    plot.draw()
}
