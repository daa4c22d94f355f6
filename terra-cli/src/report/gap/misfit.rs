//! What a drive's channels say against the simulator, before and after the cause was added: points about zero.

use std::collections::BTreeMap;

use terra_gap::Diagnosis;

use super::super::block::{Figure, Section};
use super::super::data::{Datum, Look, Series};
use super::super::number::number;
use super::super::plot::{Layout, Panel, Plot};
use super::super::scale::Axis;
use super::super::words::{capital, factor, quantity, unit_suffix};

/// Channels that get a panel, those that fit worst first.
const PANELS: usize = 6;

/// One channel: its whitened residuals before and after.
struct Channel {
    index: usize,
    before: Vec<Datum>,
    after: Vec<Datum>,
}

impl Channel {
    fn mean_square(&self) -> f64 {
        let sum: f64 = self.before.iter().map(|d| d.y * d.y).sum();
        sum / self.before.len() as f64
    }
}

pub(super) fn write(s: &mut Section, d: &Diagnosis) {
    let Some((_, null)) = &d.null else {
        return;
    };
    // The factor that shows the misfit best; slip where none stands out.
    let along = d.places.first().map_or("slip", |p| p.factor.as_str());
    let mut channels = channels(d, null.residual.as_slice(), along);
    channels.retain(|c| c.before.iter().filter(|d| d.is_finite()).count() > 1);
    channels.sort_by(|a, b| b.mean_square().total_cmp(&a.mean_square()));
    channels.truncate(PANELS);
    let panels = channels.iter().map(|c| panel(d, c, along)).collect();
    s.figure(Figure::new(
        panels,
        format!(
            "Measured less simulated of each window, in standard deviations of its noise (noise that channels share is taken apart), against {}: a simulator that lacks nothing scatters about zero by one. Channels that fit worst first.",
            factor(along).0
        ),
    ));
}

fn channels(d: &Diagnosis, null: &[f64], along: &str) -> Vec<Channel> {
    let accepted = d.accepted.as_ref().map(|a| a.1.residual.as_slice());
    let mut found: BTreeMap<usize, Channel> = BTreeMap::new();
    let rows = d.data.observations.iter().flat_map(|o| {
        let channels = o.channels.iter();
        channels.map(move |channel| (o, *channel))
    });
    for (row, (o, index)) in rows.enumerate() {
        let x = o.factors.get(along).copied().unwrap_or(f64::NAN);
        let at = |residual: &[f64]| {
            let y = residual.get(row).copied().unwrap_or(f64::NAN);
            Datum::at(x, y).labelled(format!("{}, {}", o.group, o.place))
        };
        let channel = found.entry(index).or_insert_with(|| Channel {
            index,
            before: vec![],
            after: vec![],
        });
        channel.before.push(at(null));
        channel.after.extend(accepted.map(at));
    }
    found.into_values().collect()
}

fn panel(d: &Diagnosis, c: &Channel, along: &str) -> Panel {
    let info = d.data.channels.get(c.index);
    let name = info.map_or("", |i| i.name.as_str());
    let label = capital(&quantity(name, "").label);
    let series = vec![
        Series::new(
            "simulator, soil re-fitted",
            Look::Points {
                hollow: !c.after.is_empty(),
            },
            c.before.clone(),
        ),
        Series::new(
            format!("the same with {}", d.accepted_names.join(" and ")),
            Look::Points { hollow: false },
            c.after.clone(),
        ),
    ];
    let rms = |data: &[Datum]| {
        let sum: f64 = data.iter().map(|d| d.y * d.y).sum();
        number((sum / data.len() as f64).sqrt(), 2)
    };
    let after = if c.after.is_empty() {
        String::new()
    } else {
        format!(
            ", {} with {}",
            rms(&c.after),
            d.accepted_names.join(" and ")
        )
    };
    let (words, unit) = factor(along);
    let (x_title, column) = match unit {
        "" => (words, along.to_owned()),
        unit => (
            format!("{words}, {unit}"),
            format!("{along}_{}", unit.replace('/', "_")),
        ),
    };
    let all = || series.iter().flat_map(Series::extent);
    let plot = Plot {
        layout: Layout::PANEL,
        x: Axis::over(x_title, all().map(|p| p.0), 4).named(&column, unit, 1.0),
        y: Axis::over(format!("{label}, sd"), all().map(|p| p.1), 5).named(
            &format!("{}_misfit", unit_suffix(name).0),
            "sd",
            1.0,
        ),
        title: format!("Misfit of {}", quantity(name, "").label),
        description: format!(
            "Root mean square {} with the soil re-fitted{after}.",
            rms(&c.before)
        ),
        series,
    };
    plot.draw()
}
