//! Where the simulator differs from the data once its soil is re-fitted.

use terra_gap::{Diagnosis, Place};

use super::super::block::{Section, Table};
use super::super::number::{number, share, signed};
use super::super::words::{capital, quantity, unit_after};
use super::verdict::range;

/// The place with the largest share, in words.
pub(super) fn strongest(d: &Diagnosis) -> String {
    let Some(place) = d.places.first() else {
        return "no range of slip, load, speed or path stands out, after correction for the number of ranges looked at".to_owned();
    };
    let q = quantity(&place.channel, &place.unit);
    let bias = place.bias * q.factor;
    format!(
        "{} at {}: measured {} {} than the re-fitted simulator says ({} standard deviations, {} of the whole misfit)",
        q.label,
        range(&place.factor, place.from, place.to),
        unit_after(&number(bias.abs(), 2), &q.unit),
        if bias < 0.0 { "less" } else { "more" },
        number(place.sigma, 2),
        share(place.share),
    )
}

pub(super) fn write(s: &mut Section, d: &Diagnosis) {
    if d.null.is_none() {
        return;
    }
    s.heading("Where");
    if d.places.is_empty() {
        s.text(format!("{}.", capital(&strongest(d))));
    } else {
        s.table(table(
            "Measured less simulated, soil re-fitted. Significance is corrected for the number of ranges looked at; shares are of the whole misfit, and ranges of different factors overlap.",
            &d.places,
        ));
    }
    if d.accepted.is_none() {
        return;
    }
    let cause = d.accepted_names.join(" + ");
    if d.remainder.is_empty() {
        s.text(format!("With {cause} added, nothing stands out any more."));
    } else {
        s.table(table(
            &format!("What remains with {cause} added."),
            &d.remainder,
        ));
    }
}

fn table(caption: &str, places: &[Place]) -> Table {
    let mut t = Table::new(
        caption,
        &[
            "Channel",
            "Range",
            "#Bias",
            "#Significance, σ",
            "#Share of misfit",
        ],
    );
    for p in places {
        let q = quantity(&p.channel, &p.unit);
        t.rows.push(vec![
            capital(&q.label).into(),
            range(&p.factor, p.from, p.to).into(),
            unit_after(&signed(p.bias * q.factor, 2), &q.unit).into(),
            number(p.sigma, 2).into(),
            share(p.share).into(),
        ]);
    }
    t
}
