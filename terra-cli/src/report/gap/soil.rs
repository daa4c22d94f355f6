//! How the soil moved: a missing effect often shows as soil that nobody would believe.

use terra_gap::{Diagnosis, Hypothesis, is_form_error};

use super::super::block::{Cell, Section, Table};
use super::super::number::{number, plain, with_sd};
use super::super::words::{join, unit, unit_after};

/// Prior sd from which a parameter counts as implausible.
const IMPLAUSIBLE: f64 = 2.0;

/// One soil parameter of a fit.
struct Moved {
    name: String,
    unit: String,
    before: f64,
    after: f64,
    sd: f64,
    /// In prior sd.
    by: f64,
    at_bound: bool,
}

pub(super) fn write(s: &mut Section, d: &Diagnosis) {
    let mut told = [&d.null, &d.accepted].into_iter().map(|law| {
        let (h, fit) = law.as_ref()?;
        // Laplace: the covariance of the fit vector is (I + J'J)^-1.
        let mut information = fit.jacobian.tr_mul(&fit.jacobian);
        for k in 0..information.nrows() {
            information[(k, k)] += 1.0;
        }
        let sd: Option<Vec<f64>> = information
            .cholesky()
            .map(|c| c.inverse().diagonal().iter().map(|v| v.sqrt()).collect());
        let rows = moved(h, fit.x.as_slice(), &fit.at_bound, sd.as_deref());
        (!rows.is_empty()).then(|| (h.law.model().name(), rows))
    });
    let Some((model, null)) = told.next().flatten() else {
        return;
    };
    let with = told.next().flatten();
    s.heading("How the soil moved");
    let cause = d.accepted_names.join(" + ");
    match with {
        Some((other, after)) if other == model && after.len() == null.len() => {
            let after_title = format!("#With {cause}");
            let titles = [
                "Parameter",
                "#As given",
                "#Soil re-fitted",
                "#Moved, prior sd",
                after_title.as_str(),
                "#Moved, prior sd",
            ];
            let mut t = Table::new(&caption(model), &titles);
            for (a, b) in null.iter().zip(&after) {
                let mut row = cells(a);
                row.push(with_sd(b.after, b.sd).into());
                row.push(shift(b));
                t.rows.push(row);
            }
            s.table(t);
        }
        other => {
            s.table(single(&caption(model), &null));
            if let Some((name, after)) = other.filter(|o| !o.1.is_empty()) {
                s.table(single(&format!("Soil of {name}, accepted."), &after));
            }
        }
    }
    if let Some(form) = d
        .accepted
        .as_ref()
        .and_then(|(h, fit)| another_form(h, fit.x.as_slice()))
    {
        s.text(form);
    }
    let strange: Vec<String> = null
        .iter()
        .filter(|m| m.by.abs() > IMPLAUSIBLE)
        .map(|m| format!("{} by {}", m.name, number(m.by.abs(), 2)))
        .collect();
    if !strange.is_empty() {
        s.text(format!(
            "Without a cause, the re-fit had to move {} prior standard deviations: soil that hard to believe is often the trace of something missing.",
            join(&strange, "and")
        ));
    }
    if !d.undetermined.is_empty() {
        s.text(format!(
            "Not determined by this log: {}.",
            d.undetermined.join("; ")
        ));
    }
}

fn caption(model: &str) -> String {
    format!("Soil of {model}, mean ± sd; prior sd are those of the rover file.")
}

fn single(caption: &str, rows: &[Moved]) -> Table {
    let mut t = Table::new(
        caption,
        &["Parameter", "#As given", "#Re-fitted", "#Moved, prior sd"],
    );
    t.rows = rows.iter().map(cells).collect();
    t
}

fn cells(m: &Moved) -> Vec<Cell> {
    vec![
        unit_after(&m.name, &bracketed(&m.unit)).into(),
        plain(m.before).into(),
        with_sd(m.after, m.sd).into(),
        shift(m),
    ]
}

fn bracketed(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!("({unit})")
    }
}

fn shift(m: &Moved) -> Cell {
    let cell = Cell::from(if m.by.abs() < 0.005 {
        "0.00".to_owned()
    } else {
        format!("{:+.2}", m.by).replace('-', "\u{2212}")
    });
    if m.at_bound {
        cell.with_note("at its bound")
    } else {
        cell
    }
}

/// What a fit says of the error of the wheel law's form, where that is free: its many coefficients are in the verdict.
fn another_form(h: &Hypothesis, x: &[f64]) -> Option<String> {
    let names = h.soil.names();
    let of_the_form = || names.iter().zip(x).filter(|(name, _)| is_form_error(name));
    let (name, by) = of_the_form().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    Some(format!(
        "Here the form may be off by another error than on the simulator's log: of its {} coefficients {name} moved most, by {} prior standard deviations (all are in the JSON verdict).",
        of_the_form().count(),
        number(by.abs(), 2)
    ))
}

/// What a fit says of its soil parameters, those of the wheel law's form left out; `sd` are those of its fit vector.
fn moved(h: &Hypothesis, x: &[f64], at_bound: &[bool], sd: Option<&[f64]>) -> Vec<Moved> {
    let n = h.soil_len();
    let q: Vec<f64> = x.iter().take(n).copied().collect();
    let before = h.soil.physical(&vec![0.0; n]);
    let after = h.soil.physical(&q);
    let names = h.soil.names();
    (0..n)
        .filter(|k| names.get(*k).is_some_and(|name| !is_form_error(name)))
        .filter_map(|k| {
            let sd = sd.and_then(|sd| sd.get(k)).copied();
            // First order, by the slope of the map at the fit.
            let slope = {
                let step = 1e-4;
                let mut up = q.clone();
                *up.get_mut(k)? += step;
                (h.soil.physical(&up).get(k)? - after.get(k)?) / step
            };
            Some(Moved {
                name: (*names.get(k)?).to_string(),
                unit: unit(h.soil.units().get(k)?),
                before: *before.get(k)?,
                after: *after.get(k)?,
                sd: sd.map_or(f64::NAN, |sd| sd * slope.abs()),
                by: *q.get(k)?,
                at_bound: at_bound.get(k).copied().unwrap_or(false),
            })
        })
        .collect()
}
