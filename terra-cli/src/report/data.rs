//! What a figure shows, as numbers: the same ones are drawn, read out and written as CSV.

use crate::output::{csv_number, csv_text};

use super::paint::Paint;
use super::scale::Axis;

/// One value of a series, in SI units; NaN where there is none. A datum without `y` breaks a line.
#[derive(Clone, Debug)]
pub(super) struct Datum {
    pub(super) x: f64,
    pub(super) x_sd: f64,
    pub(super) y: f64,
    pub(super) y_sd: f64,
    /// Trial, load, step: what it is, beyond its numbers.
    pub(super) label: String,
}

impl Datum {
    pub(super) fn at(x: f64, y: f64) -> Self {
        Datum {
            x,
            x_sd: f64::NAN,
            y,
            y_sd: f64::NAN,
            label: String::new(),
        }
    }

    pub(super) fn sd(self, x_sd: f64, y_sd: f64) -> Self {
        Datum { x_sd, y_sd, ..self }
    }

    pub(super) fn labelled(self, label: impl Into<String>) -> Self {
        Datum {
            label: label.into(),
            ..self
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Look {
    /// A line, broken where there is no value; values with sd get a band of one sd each way.
    Line(Paint),
    /// Points, filled or hollow, with a bar of one sd each way where it is known.
    Points { hollow: bool },
    /// Many small points.
    Dots,
    /// Bars along x from `from`, thick as the px of [`super::plot::BAR`].
    Bars { from: f64, last: Paint },
}

impl Look {
    /// Class of its sample in a legend, which also ties the legend to the marks.
    pub(super) fn key(self) -> String {
        match self {
            Look::Line(paint) => paint.name(),
            Look::Points { hollow: false } => "measured".to_owned(),
            Look::Points { hollow: true } => "elsewhere".to_owned(),
            Look::Dots => "dots".to_owned(),
            Look::Bars { .. } => "bars".to_owned(),
        }
    }
}

/// Values that belong together.
#[derive(Clone, Debug)]
pub(super) struct Series {
    pub(super) name: String,
    pub(super) look: Look,
    pub(super) data: Vec<Datum>,
}

impl Series {
    pub(super) fn new(name: impl Into<String>, look: Look, data: Vec<Datum>) -> Self {
        Series {
            name: name.into(),
            look,
            data,
        }
    }

    /// Its values of x and y with their sd to both sides.
    pub(super) fn extent(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.data.iter().flat_map(|d| {
            let sd = |sd: f64| if sd.is_finite() { sd } else { 0.0 };
            let (dx, dy) = (sd(d.x_sd), sd(d.y_sd));
            [(d.x - dx, d.y - dy), (d.x + dx, d.y + dy)]
        })
    }
}

/// What a column says of a datum.
type Cell = fn(&Datum) -> String;

/// The series as CSV: `series,label,x,x_sd,y,y_sd` under the names and units of the axes. Columns that nothing fills
/// are left out; numbers are exact.
pub(super) fn csv(x: &Axis, y: &Axis, series: &[Series]) -> String {
    let rows = || {
        series
            .iter()
            .flat_map(|s| s.data.iter().filter(|d| d.is_finite()).map(move |d| (s, d)))
    };
    let all: [(String, Cell); 5] = [
        ("label".to_owned(), |d| csv_text(&d.label)),
        (x.column(), |d| csv_number(d.x)),
        (x.sd_column(), |d| csv_number(d.x_sd)),
        (y.column(), |d| csv_number(d.y)),
        (y.sd_column(), |d| csv_number(d.y_sd)),
    ];
    let columns: Vec<_> = all
        .iter()
        .filter(|(_, cell)| rows().any(|(_, d)| !cell(d).is_empty()))
        .collect();
    let mut out = "series".to_owned();
    for (name, _) in &columns {
        out.push(',');
        out.push_str(name);
    }
    out.push('\n');
    for (s, d) in rows() {
        out.push_str(&csv_text(&s.name));
        for (_, cell) in &columns {
            out.push(',');
            out.push_str(&cell(d));
        }
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers come back bit for bit, in SI units whatever the figure shows; the sd column takes its name from the
    /// quantity, before the unit, as in the tables of `terra estimate`.
    #[test]
    fn the_numbers_are_exact_and_named() {
        let x = Axis::over("slip", [0.0, 1.0], 4).named("slip", "", 1.0);
        let y = Axis::over("sinkage, mm", [0.0, 30.0], 4).named("sinkage_m", "mm", 1e3);
        let z = 0.1 + 0.2;
        let points = vec![
            Datum::at(0.1, z).sd(f64::NAN, 0.0005).labelled("a, \"b\""),
            Datum::at(0.2, f64::NAN),
        ];
        let text = csv(
            &x,
            &y,
            &[
                Series::new("measured", Look::Points { hollow: false }, points),
                Series::new(
                    "model",
                    Look::Line(Paint::After),
                    vec![Datum::at(0.3, 1e-7)],
                ),
            ],
        );
        let mut reader = csv_rows(&text);
        assert_eq!(
            reader.remove(0),
            ["series", "label", "slip", "sinkage_m", "sinkage_sd_m"]
        );
        assert_eq!(reader.len(), 2);
        assert_eq!(reader[0][..2], ["measured", "a, \"b\""]);
        assert_eq!(reader[0][3].parse::<f64>(), Ok(z));
        assert_eq!(reader[1][3].parse::<f64>(), Ok(1e-7));
        assert_eq!(reader[1][4], "");
    }

    fn csv_rows(text: &str) -> Vec<Vec<String>> {
        ::csv::ReaderBuilder::new()
            .has_headers(false)
            .from_reader(text.as_bytes())
            .records()
            .map(|r| r.unwrap().iter().map(str::to_owned).collect())
            .collect()
    }
}
