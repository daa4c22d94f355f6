//! Which data the diagnosis rests on, and what was not asked of them.

use std::collections::BTreeMap;

use terra_gap::{Diagnosis, LogKind};

use super::super::block::{Item, Section, Table};
use super::super::number::{count, number, shortened};
use super::super::words::{capital, quantity, unit_after};
use super::causes::not_asked;

pub(super) fn write(s: &mut Section, d: &Diagnosis) {
    s.heading("Data");
    let rows = match d.kind {
        LogKind::Rig => "row",
        LogKind::Drive | LogKind::Kinematic => "window",
    };
    let groups = d.data.groups().len();
    s.text(format!(
        "{} in {}, {}; nominal terrain model {}.",
        count(d.data.len(), "measured value"),
        count(d.data.observations.len(), rows),
        count(groups, "group"),
        d.model
    ));
    if !d.data.channels.is_empty() {
        s.table(channels(d));
    }
    if d.data.dropped.is_empty() {
        s.text(format!("No {rows} was left out."));
    } else {
        let mut t = Table::new("Left out.", &["Reason", &format!("#{}s", capital(rows))]);
        for (reason, n) in &d.data.dropped {
            t.rows.push(vec![
                capital(&shortened(reason)).into(),
                n.to_string().into(),
            ]);
        }
        s.table(t);
    }
    let items = not_asked(d);
    if !items.is_empty() {
        s.heading("Not asked of this log");
        s.list(items);
    }
    s.heading("Notes");
    let mut notes: Vec<Item> = d.data.notes.iter().map(|n| note(n)).collect();
    notes.push(note(&calibration(d)));
    notes.push(note(
        "The soil is re-fitted before anything is blamed: what other soil could explain is not counted as a gap.",
    ));
    s.list(notes);
}

fn note(text: &str) -> Item {
    Item {
        name: String::new(),
        text: shortened(text),
    }
}

/// Values, noise and misfit of each channel.
fn channels(d: &Diagnosis) -> Table {
    let mut t = Table::new(
        "Channels. Misfit: root mean square of measured less simulated, soil re-fitted.",
        &["Channel", "#Values", "#Sensor noise, 1 sd", "#Misfit, rms"],
    );
    let rms: BTreeMap<&str, f64> = d.rms.iter().map(|(n, v)| (n.as_str(), *v)).collect();
    for (c, info) in d.data.channels.iter().enumerate() {
        let mut sds: Vec<f64> = vec![];
        for o in &d.data.observations {
            for (k, channel) in o.channels.iter().enumerate() {
                if *channel == c {
                    // A rig's raw quantities begin with the values it has, a vehicle's with those of all channels.
                    let place = if d.kind == LogKind::Rig { k } else { c };
                    sds.extend(o.raw_sd.get(place));
                }
            }
        }
        if sds.is_empty() {
            continue;
        }
        sds.sort_by(f64::total_cmp);
        let q = quantity(&info.name, info.unit);
        let shown = |v: Option<f64>| match v {
            Some(v) => unit_after(&number(v * q.factor, 2), &q.unit),
            None => String::new(),
        };
        let noise = match (sds.first(), sds.last()) {
            (Some(a), Some(b)) if (b - a).abs() > 1e-9 * b.abs() => {
                format!("{} to {}", number(a * q.factor, 2), shown(Some(*b)))
            }
            (a, _) => shown(a.copied()),
        };
        t.rows.push(vec![
            capital(&q.label).into(),
            sds.len().to_string().into(),
            noise.into(),
            shown(rms.get(info.name.as_str()).copied()).into(),
        ]);
    }
    t
}

/// What turned evidence into probabilities, in a sentence.
fn calibration(d: &Diagnosis) -> String {
    match &d.calibration {
        Some(c) if c.cases > 0 => {
            let unseen = match c.unseen_second {
                0.0 => String::new(),
                share => format!(", and may stand unseen beside a first with {share:.2} of its probability"),
            };
            format!(
                "Probabilities are calibrated: {} (temperature {:.2}, floor {:.3}; a name needs {:.1} nats; a second cause needs {:.1}{unseen}).",
                c.source, c.temperature, c.floor, c.null_gain, c.second_gain
            )
        }
        _ => "Probabilities follow from the evidences as they stand; they are not calibrated on cases of this design. `--calibrate 100` does that."
            .to_owned(),
    }
}
