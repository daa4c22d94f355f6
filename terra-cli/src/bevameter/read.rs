//! A bevameter log: rows to tests, tests to soils.

use std::path::Path;

use terra_model::bevameter::Curve;
use terra_model::nearest;

use super::Kind;
use super::columns::{Column, Columns, factor};
use crate::error::CliError;
use crate::input::sha256;

/// The tests of a file, soil by soil in the order they first occur.
pub(crate) struct Tests {
    pub(crate) file: String,
    pub(crate) sha256: String,
    pub(crate) soils: Vec<(String, Vec<Curve>)>,
    pub(crate) rows: usize,
    /// Rows with a missing cell.
    pub(crate) missing: usize,
    /// Rows whose text stands for no plate or stress.
    pub(crate) left_out: usize,
}

/// A column of the file, ready to be read.
enum Found {
    Cell {
        name: String,
        index: usize,
        factor: f64,
        values: Option<std::collections::BTreeMap<String, f64>>,
    },
    Constant(f64),
}

/// One cell: a number, none, or a text that stands for none.
enum Cell {
    Number(f64),
    Missing,
    LeftOut,
}

/// Reads the bytes of a file of tests; `name` is the file's in messages.
///
/// # Errors
/// Data errors with file, line and column.
pub(crate) fn read(
    name: &Path,
    bytes: &[u8],
    kind: Kind,
    columns: &Columns,
) -> Result<Tests, CliError> {
    let file = name.display().to_string();
    let fail = |place: String, message: String| CliError::BadData {
        message: format!("{file}:{place}: {message}"),
        help: None,
    };
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let header: Vec<String> = reader
        .headers()
        .map_err(|e| fail("1".to_owned(), e.to_string()))?
        .iter()
        .map(|h| h.trim_start_matches('\u{feff}').to_owned())
        .collect();
    let find = |name: &str| {
        bind(&header, name, &columns.get(name)).map_err(|m| {
            CliError::data(
                format!("{file}:1: {m}"),
                "--columns FILE maps other names and units",
            )
        })
    };
    let [given, x, stress] = match kind {
        Kind::Plate => ["plate_diameter_m", "sinkage_m", "pressure_Pa"],
        Kind::Shear => [
            "normal_stress_Pa",
            "shear_displacement_m",
            "shear_stress_Pa",
        ],
    };
    let (given, x, stress) = (find(given)?, find(x)?, find(stress)?);
    let test = find("test")?;
    let soil = if columns.names("soil") || header.iter().any(|h| h == "soil") {
        Some(find("soil")?)
    } else {
        None
    };
    let mut out = Tests {
        sha256: sha256(bytes),
        file: file.clone(),
        soils: vec![],
        rows: 0,
        missing: 0,
        left_out: 0,
    };
    for record in reader.records() {
        let record = record.map_err(|e| {
            let line = e.position().map_or(0, csv::Position::line);
            fail(line.to_string(), e.to_string())
        })?;
        let line = record.position().map_or(0, csv::Position::line);
        out.rows += 1;
        let mut numbers = [0.0; 3];
        let mut usable = true;
        for (number, column) in numbers.iter_mut().zip([&given, &x, &stress]) {
            match column.number(&record) {
                Ok(Cell::Number(v)) => *number = v,
                Ok(Cell::Missing) => {
                    out.missing += 1;
                    usable = false;
                    break;
                }
                Ok(Cell::LeftOut) => {
                    out.left_out += 1;
                    usable = false;
                    break;
                }
                Err((index, message)) => {
                    return Err(fail(format!("{line}:{}", index + 1), message));
                }
            }
        }
        if !usable {
            continue;
        }
        let [given, x, stress] = numbers;
        let given = match kind {
            Kind::Plate => 0.5 * given,
            Kind::Shear => given,
        };
        let soil = soil.as_ref().map_or(String::new(), |s| s.text(&record));
        let name = test.text(&record);
        out.add(soil, &name, given, (x, stress))
            .map_err(|before| {
                fail(
                    line.to_string(),
                    format!("test '{name}' has {given} here and {before} before, where a test has one plate or normal stress"),
                )
            })?;
    }
    if out.soils.is_empty() {
        return Err(CliError::data(
            format!("{file}: no row that can be used of {}", out.rows),
            "a row needs test, plate diameter or normal stress, way and stress",
        ));
    }
    Ok(out)
}

impl Tests {
    /// Adds a point; the value its test had before where it is another.
    fn add(&mut self, soil: String, test: &str, given: f64, point: (f64, f64)) -> Result<(), f64> {
        let place = self
            .soils
            .iter()
            .position(|s| s.0 == soil)
            .unwrap_or_else(|| {
                self.soils.push((soil, vec![]));
                self.soils.len() - 1
            });
        let Some((_, curves)) = self.soils.get_mut(place) else {
            return Ok(());
        };
        match curves.iter_mut().find(|c| c.test == test) {
            Some(curve) if (curve.given - given).abs() > 1e-9 * given.abs() => Err(curve.given),
            Some(curve) => {
                curve.points.push(point);
                Ok(())
            }
            None => {
                curves.push(Curve {
                    test: test.to_owned(),
                    given,
                    points: vec![point],
                });
                Ok(())
            }
        }
    }
}

fn bind(header: &[String], name: &str, column: &Column) -> Result<Found, String> {
    let factor = column
        .unit
        .as_deref()
        .map_or(Some(1.0), |unit| factor(name, unit))
        .unwrap_or(1.0);
    if let Some(value) = column.value {
        return Ok(Found::Constant(value * factor));
    }
    let wanted = column.from.as_deref().unwrap_or(name);
    let index = header.iter().position(|h| h == wanted).ok_or_else(|| {
        let near = nearest(wanted, header.iter().map(String::as_str));
        let near = near.map_or(String::new(), |n| format!(", nearest is '{n}'"));
        format!("no column '{wanted}'{near}")
    })?;
    Ok(Found::Cell {
        name: wanted.to_owned(),
        index,
        factor,
        values: column.values.clone(),
    })
}

impl Found {
    fn number(&self, record: &csv::StringRecord) -> Result<Cell, (usize, String)> {
        let (name, index, factor, values) = match self {
            Found::Constant(value) => return Ok(Cell::Number(*value)),
            Found::Cell {
                name,
                index,
                factor,
                values,
            } => (name, *index, *factor, values),
        };
        let text = record.get(index).unwrap_or_default();
        if let Some(values) = values {
            return Ok(values
                .get(text)
                .map_or(Cell::LeftOut, |v| Cell::Number(v * factor)));
        }
        if text.is_empty() || text.eq_ignore_ascii_case("nan") || text.eq_ignore_ascii_case("na") {
            return Ok(Cell::Missing);
        }
        match text.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(Cell::Number(v * factor)),
            Ok(_) => Ok(Cell::Missing),
            Err(_) => Err((
                index,
                format!("column '{name}': found '{text}', expected a number"),
            )),
        }
    }

    fn text(&self, record: &csv::StringRecord) -> String {
        match self {
            Found::Constant(value) => value.to_string(),
            Found::Cell { index, .. } => record.get(*index).unwrap_or_default().to_owned(),
        }
    }
}
