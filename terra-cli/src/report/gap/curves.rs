//! Measured points with error bars over the model's curves, before and after the cause was added.

use terra_gap::{Diagnosis, Hypothesis, RigPredictor};

use super::super::block::{Figure, Section};
use super::super::data::{Datum, Look, Series};
use super::super::number::{count, number, plain};
use super::super::paint::Paint;
use super::super::plot::{self, Layout, Plot};
use super::super::scale::Axis;
use super::super::words::{quantity, unit_after};
use super::stress::{self, Stresses};

/// Steps of slip of a curve.
const STEPS: usize = 80;
/// Groups of rows (condition, pass) that get panels.
const GROUPS: usize = 4;
/// Relative difference of load from which a point does not belong to the curve's load.
const OTHER_LOAD: f64 = 0.05;

/// A model curve: stretches of (slip, value), broken where the model has no answer.
pub type Curve = Vec<Vec<(f64, f64)>>;

/// One measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Library slip.
    pub slip: f64,
    /// Its 1-sigma.
    pub slip_sd: f64,
    /// Measured value, in the channel's unit.
    pub value: f64,
    /// Its 1-sigma.
    pub sd: f64,
    /// Normal load \[N\].
    pub load: f64,
}

/// One channel of one condition against slip.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Contract name (`drawbar_pull_N`).
    pub channel: String,
    /// SI unit.
    pub unit: String,
    /// Condition and pass; empty when the log has only one.
    pub group: String,
    /// Load of the curves \[N\]: the median of the group.
    pub load: f64,
    /// What was measured.
    pub measured: Vec<Point>,
    /// Nominal law, soil re-fitted.
    pub before: Curve,
    /// Accepted law; empty when nothing was accepted.
    pub after: Curve,
}

/// Measured points and model curves of a rig log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GapCurves {
    /// One panel a channel and group.
    pub panels: Vec<Panel>,
    /// Groups beyond the largest ones, which have no panels.
    pub left_out: usize,
    /// Stress along the contact in the largest group.
    pub stresses: Stresses,
}

impl GapCurves {
    /// The curves of a rig diagnosis, at each group's median load, over the log's range of slip.
    ///
    /// Slips for which a law has no answer break its curve. A diagnosis without a fit has points only.
    pub fn of_rig(d: &Diagnosis, predictor: &RigPredictor) -> Self {
        let mut groups: Vec<(String, Vec<usize>)> = vec![];
        for (i, o) in d.data.observations.iter().enumerate() {
            let pass = o.factors.get("pass").copied().unwrap_or(1.0);
            let name = match pass {
                p if p > 1.0 => format!("{}, pass {p}", o.condition),
                _ => o.condition.clone(),
            };
            match groups.iter_mut().find(|g| g.0 == name) {
                Some(group) => group.1.push(i),
                None => groups.push((name, vec![i])),
            }
        }
        let single = groups.len() == 1;
        groups.sort_by_key(|g| std::cmp::Reverse(g.1.len()));
        let left_out = groups.len().saturating_sub(GROUPS);
        groups.truncate(GROUPS);
        let panels = groups
            .iter()
            .flat_map(|(name, rows)| {
                let name = if single { "" } else { name };
                (0..d.data.channels.len()).filter_map(|c| panel(d, predictor, name, rows, c))
            })
            .collect();
        let largest = groups.first().map_or(&[][..], |g| g.1.as_slice());
        GapCurves {
            stresses: Stresses::of_rig(d, predictor, largest),
            panels,
            left_out,
        }
    }
}

fn panel(
    d: &Diagnosis,
    predictor: &RigPredictor,
    group: &str,
    rows: &[usize],
    channel: usize,
) -> Option<Panel> {
    let info = d.data.channels.get(channel)?;
    let mut measured = vec![];
    let mut representative = None;
    for o in rows.iter().filter_map(|&i| d.data.observations.get(i)) {
        let Some(k) = o.channels.iter().position(|&c| c == channel) else {
            continue;
        };
        representative.get_or_insert((o.index, k));
        let factor = |name| o.factors.get(name).copied().unwrap_or(f64::NAN);
        measured.push(Point {
            slip: factor("slip"),
            slip_sd: o.raw_sd.get(o.values.len()).copied().unwrap_or(f64::NAN),
            value: o.values.get(k).copied().unwrap_or(f64::NAN),
            sd: o.raw_sd.get(k).copied().unwrap_or(f64::NAN),
            load: factor("load"),
        });
    }
    let (index, k) = representative?;
    let load = median(measured.iter().map(|p| p.load).collect());
    let slips: Vec<f64> = measured.iter().map(|p| p.slip).collect();
    let low = slips.iter().copied().fold(f64::INFINITY, f64::min);
    let high = slips.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let curve = |law: &(Hypothesis, _), x: &[f64]| -> Curve {
        let p = law.0.parameters(x);
        let mut stretches: Curve = vec![vec![]];
        for step in 0..=STEPS {
            let slip = low + (high - low) * step as f64 / STEPS as f64;
            let value = predictor
                .curve(&law.0.law, &p, index, slip, load)
                .ok()
                .and_then(|r| r.get(k).copied())
                .filter(|v| v.is_finite());
            match (value, stretches.last_mut()) {
                (Some(v), Some(last)) => last.push((slip, v)),
                (None, Some(last)) if !last.is_empty() => stretches.push(vec![]),
                _ => {}
            }
        }
        stretches.retain(|s| s.len() > 1);
        stretches
    };
    Some(Panel {
        channel: info.name.clone(),
        unit: info.unit.to_owned(),
        group: group.to_owned(),
        load,
        before: d
            .null
            .as_ref()
            .map_or(vec![], |n| curve(n, n.1.x.as_slice())),
        after: d
            .accepted
            .as_ref()
            .map_or(vec![], |a| curve(a, a.1.x.as_slice())),
        measured,
    })
}

pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

pub(super) fn write(s: &mut Section, d: &Diagnosis, curves: Option<&GapCurves>) {
    let Some(curves) = curves.filter(|c| !c.panels.is_empty()) else {
        return;
    };
    s.heading("Measured and simulated");
    s.figure(figure(d, curves));
    stress::write(s, d, &curves.stresses);
}

fn elsewhere(panel: &Panel, point: &Point) -> bool {
    (point.load / panel.load - 1.0).abs() > OTHER_LOAD
}

fn figure(d: &Diagnosis, curves: &GapCurves) -> Figure {
    let mut loads: Vec<String> = vec![];
    for p in &curves.panels {
        let load = unit_after(&plain(p.load), "N");
        let text = if p.group.is_empty() {
            load
        } else {
            format!("{load} ({})", p.group)
        };
        if !loads.contains(&text) {
            loads.push(text);
        }
    }
    let mut caption = if curves.panels.iter().all(|p| p.before.is_empty()) {
        "Error bars are those of the sensors.".to_owned()
    } else {
        format!(
            "Curves at the median normal load, {}. Error bars are those of the sensors; an error of slip or load also moves the curves.",
            loads.join(", ")
        )
    };
    if curves.left_out > 0 {
        caption.push_str(&format!(
            " {} with fewer rows not shown.",
            count(curves.left_out, "group")
        ));
    }
    Figure::new(curves.panels.iter().map(|p| draw(d, p)).collect(), caption)
}

/// The stretches of a curve as one line with breaks.
fn line(curve: &Curve) -> Vec<Datum> {
    let mut out = vec![];
    for stretch in curve {
        if !out.is_empty() {
            out.push(Datum::at(f64::NAN, f64::NAN));
        }
        out.extend(stretch.iter().map(|(x, y)| Datum::at(*x, *y)));
    }
    out
}

fn series(d: &Diagnosis, panel: &Panel) -> Vec<Series> {
    let measured = |hollow: bool| -> Vec<Datum> {
        let points = panel
            .measured
            .iter()
            .filter(|p| elsewhere(panel, p) == hollow);
        points
            .map(|p| {
                Datum::at(p.slip, p.value)
                    .sd(p.slip_sd, p.sd)
                    .labelled(unit_after(&plain(p.load), "N"))
            })
            .collect()
    };
    let added = d.accepted_names.join(" and ");
    vec![
        Series::new(
            "simulator, soil re-fitted",
            Look::Line(Paint::Before),
            line(&panel.before),
        ),
        Series::new(
            format!("the same with {added}"),
            Look::Line(Paint::After),
            line(&panel.after),
        ),
        Series::new(
            "measured at another load",
            Look::Points { hollow: true },
            measured(true),
        ),
        Series::new(
            "measured ± 1 sd",
            Look::Points { hollow: false },
            measured(false),
        ),
    ]
}

fn draw(d: &Diagnosis, panel: &Panel) -> plot::Panel {
    let q = quantity(&panel.channel, &panel.unit);
    let title = if panel.group.is_empty() {
        q.axis()
    } else {
        format!("{} ({})", q.axis(), panel.group)
    };
    let far = |name: &str, curve: &Curve| -> Option<String> {
        let ys: Vec<f64> = curve.iter().flatten().map(|p| p.1 * q.factor).collect();
        let (first, last) = (ys.first()?, ys.last()?);
        Some(format!(
            "{name} runs from {} to {}",
            number(*first, 3),
            number(*last, 3)
        ))
    };
    let mut said = vec![format!(
        "{} against slip at {} N",
        count(panel.measured.len(), "measured point"),
        plain(panel.load)
    )];
    said.extend(far(
        "the simulator with re-fitted soil (dashed)",
        &panel.before,
    ));
    said.extend(far(
        &format!("with {} (solid)", d.accepted_names.join(" and ")),
        &panel.after,
    ));
    let series = series(d, panel);
    let all = || series.iter().flat_map(Series::extent);
    let plot = Plot {
        layout: Layout::PANEL,
        x: Axis::over("slip", all().map(|p| p.0), 5).named("slip", "", 1.0),
        y: Axis::over(title.clone(), all().map(|p| p.1 * q.factor), 5).named(
            &panel.channel,
            &q.unit,
            q.factor,
        ),
        title,
        description: format!("{}.", said.join("; ")),
        series,
    };
    plot.draw()
}
