//! How the misfit shrinks: as given, soil re-fitted, cause added; the noise is the floor.

use terra_gap::Diagnosis;

use super::super::ReportError;
use super::super::block::{Figure, Section};
use super::super::figure::{Anchor, Layout, Plot};
use super::super::number::number;
use super::super::paint::Paint;
use super::super::scale::Axis;

/// Room for a letter of a label, a tenth of a pixel.
const LETTER: i32 = 73;

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
fn figure(d: &Diagnosis) -> Result<Figure, ReportError> {
    let steps = steps(d);
    let values: Vec<f64> = steps
        .iter()
        .filter_map(|s| s.1)
        .filter(|v| v.is_finite() && *v > 0.0)
        .collect();
    let high = values.iter().fold(2.0, |a: f64, v| a.max(*v)) * 1.3;
    let low = values.iter().fold(0.8, |a: f64, v| a.min(*v * 0.8));
    let rows = steps.len() as i32;
    let described: Vec<String> = steps
        .iter()
        .map(|(name, v)| match v {
            Some(v) => format!("{name} {}", number(*v, 3)),
            None => format!("{name}: the model has no answer"),
        })
        .collect();
    let longest = steps.iter().map(|s| s.0.chars().count()).max().unwrap_or(0);
    let left = 172.max(LETTER * longest as i32 / 10 + 18);
    let plot = Plot {
        layout: Layout {
            width: 640,
            height: 34 * rows + 78,
            left,
            right: 60,
            top: 30,
            bottom: 48,
        },
        x: Axis::logarithmic("misfit χ² per measured value", low, high),
        y: Axis {
            title: String::new(),
            range: (f64::from(rows) - 0.5, -0.5),
            ticks: vec![],
        },
        title: "Misfit at each step".to_owned(),
        description: format!("{}; pure noise gives 1.", described.join(", ")),
    };
    let svg = plot.draw(|c| {
        for (row, (name, value)) in steps.iter().enumerate() {
            let y = row as f64;
            let paint = if row == 2 { Paint::After } else { Paint::Bar };
            c.text((low.log10(), y), (-14, 0), name, Paint::Ink, Anchor::Right)?;
            match value.filter(|v| v.is_finite() && *v > 0.0) {
                Some(v) => {
                    c.bar(y, 0.0, v.log10(), 16, paint)?;
                    let end = v.log10().max(0.0);
                    c.text((end, y), (8, 0), &number(v, 3), Paint::Ink, Anchor::Left)?;
                }
                None => c.text(
                    (0.0, y),
                    (8, 0),
                    "the model has no answer",
                    Paint::Muted,
                    Anchor::Left,
                )?,
            }
        }
        let (top, bottom) = (-0.5, f64::from(rows) - 0.5);
        c.line(&[(0.0, top), (0.0, bottom)], Paint::Ink, 1)?;
        c.text(
            (0.0, top),
            (0, -12),
            "noise floor",
            Paint::Muted,
            Anchor::Middle,
        )
    })?;
    let added = if d.accepted_names.is_empty() {
        String::new()
    } else {
        format!(" The last bar adds {}.", d.accepted_names.join(" and "))
    };
    Ok(Figure {
        panels: vec![svg],
        legend: vec![],
        caption: format!(
            "Squared misfit over its variance, per measured value; 1 is what the noise of the sensors alone gives. Bars start there, on a logarithmic axis.{added}"
        ),
    })
}
