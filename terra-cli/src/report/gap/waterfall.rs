//! How the misfit shrinks: as given, soil re-fitted, cause added; the noise is the floor.

use terra_gap::Diagnosis;

use super::super::block::{Figure, Section};
use super::super::data::{Datum, Look, Series};
use super::super::number::number;
use super::super::paint::Paint;
use super::super::plot::{Layout, Plot};
use super::super::scale::Axis;
use super::super::svg::Anchor;

/// Room for a letter of a label \[px\].
const LETTER: f64 = 7.3;

pub(super) fn write(s: &mut Section, d: &Diagnosis) {
    if d.waterfall.refitted.is_none() {
        return;
    }
    s.heading("How far the gap shrinks");
    s.figure(figure(d));
}

fn steps(d: &Diagnosis) -> Vec<(String, Option<f64>)> {
    let mut steps = vec![
        ("simulator as given".to_owned(), d.waterfall.as_given),
        ("soil re-fitted".to_owned(), d.waterfall.refitted),
    ];
    if !d.accepted_names.is_empty() {
        // Two names would run out of the margin.
        let text = match d.accepted_names.as_slice() {
            [one] => format!("with {one}"),
            several => format!("with {} effects", several.len()),
        };
        steps.push((text, d.waterfall.after));
    }
    steps
}

/// Bars from the noise floor: on a logarithmic axis their length is the factor by which the misfit exceeds the noise.
fn figure(d: &Diagnosis) -> Figure {
    let steps = steps(d);
    let known = |v: Option<f64>| v.filter(|v| v.is_finite() && *v > 0.0);
    let values: Vec<f64> = steps.iter().filter_map(|s| known(s.1)).collect();
    let high = values.iter().fold(2.0, |a: f64, v| a.max(*v)) * 1.3;
    let low = values.iter().fold(0.8, |a: f64, v| a.min(*v * 0.8));
    let rows = steps.len() as f64;
    let described: Vec<String> = steps
        .iter()
        .map(|(name, v)| match v {
            Some(v) => format!("{name} {}", number(*v, 3)),
            None => format!("{name}: the model has no answer"),
        })
        .collect();
    let longest = steps.iter().map(|s| s.0.chars().count()).max().unwrap_or(0);
    let bars = steps.iter().enumerate().map(|(row, (name, value))| {
        Datum::at(known(*value).unwrap_or(f64::NAN), row as f64).labelled(name.as_str())
    });
    let plot = Plot {
        layout: Layout {
            width: 640.0,
            height: 34.0 * rows + 78.0,
            left: (LETTER * longest as f64 + 18.0).max(172.0),
            right: 60.0,
            top: 30.0,
            bottom: 48.0,
        },
        x: Axis::logarithmic("misfit χ² per measured value", low, high).named(
            "chi2_per_value",
            "",
            1.0,
        ),
        y: Axis::rows(rows).named("step", "", 1.0),
        title: "Misfit at each step".to_owned(),
        description: format!("{}; pure noise gives 1.", described.join(", ")),
        series: vec![Series::new(
            "misfit per value",
            Look::Bars {
                from: 1.0,
                last: if d.accepted_names.is_empty() {
                    Paint::Bar
                } else {
                    Paint::After
                },
            },
            bars.collect(),
        )],
    };
    let panel = plot.draw_with(|c| {
        for (row, (name, value)) in steps.iter().enumerate() {
            let row = row as f64;
            let (x, y) = c.at(low, row);
            c.svg.text((x - 14.0, y), name, Paint::Ink, Anchor::Right);
            let (text, paint, end) = match known(*value) {
                Some(v) => (number(v, 3), Paint::Ink, v.max(1.0)),
                None => ("the model has no answer".to_owned(), Paint::Muted, 1.0),
            };
            let (x, y) = c.at(end, row);
            c.svg.text((x + 8.0, y), &text, paint, Anchor::Left);
        }
        let (top, bottom) = (c.at(1.0, -0.5), c.at(1.0, rows - 0.5));
        c.svg.line(&[top, bottom], Paint::Ink, 1.0);
        let above = (top.0, top.1 - 12.0);
        c.svg
            .text(above, "noise floor", Paint::Muted, Anchor::Middle);
    });
    let added = if d.accepted_names.is_empty() {
        String::new()
    } else {
        format!(" The last bar adds {}.", d.accepted_names.join(" and "))
    };
    Figure::labelled(
        vec![panel],
        format!(
            "Squared misfit over its variance, per measured value; 1 is what the noise of the sensors alone gives. Bars start there, on a logarithmic axis.{added}"
        ),
    )
}
