//! Reads a user's own catalogue of terrains.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::io::Read;
use std::path::Path;

use terra_model::catalogue::{self, Confidence, Terrain};

use crate::columns::Bound;
use crate::error::{DataError, Origin};
use crate::names::short;
use crate::problem::Problem;
use crate::rover::TerrainSettings;
use crate::source::open;
use crate::table::{Row, Table};

/// Column of the trust in a row.
pub(crate) const CONFIDENCE: &str = "conf";
/// Column of where a row comes from.
pub(crate) const SOURCE: &str = "source_note";
/// The marks of [`Confidence`].
pub(crate) const MARKS: &str = "A, B, C or user";

/// Reads a catalogue of terrains: CSV with the columns
/// `id,set,name,n,kc_kN_m_n1,kphi_kN_m_n2,c_kPa,phi_deg,K_m,c1,c2` in any order; others are ignored and lines that begin
/// with `#` skipped. The result is in SI and radians. `NA` in `K_m`, `c1`, `c2` leaves the value out.
///
/// Two further columns may be there: `conf`, how far to trust the row (`A`, `B`, `C` or `user`, [`Confidence`]), and
/// `source_note`, where it comes from. Without them, or where they are empty or `NA`, it is `user` and the file's name.
///
/// # Errors
/// [`DataError::Configuration`] with file, line and column.
pub fn read_terrains(path: impl AsRef<Path>) -> Result<Vec<Terrain>, DataError> {
    let path = path.as_ref();
    let origin = Origin::configuration(&path.display().to_string());
    let file = open(path, &origin)?;
    read_terrains_from(file, &origin.file)
}

/// [`read_terrains`] from a stream; `name` stands for the file in errors.
///
/// # Errors
/// As [`read_terrains`].
pub fn read_terrains_from(reader: impl Read, name: &str) -> Result<Vec<Terrain>, DataError> {
    read(Box::new(reader), name)
}

fn read(reader: Box<dyn Read + '_>, name: &str) -> Result<Vec<Terrain>, DataError> {
    let origin = Origin::configuration(name);
    let mut table = Table::open(reader, origin, Some(b'#'), "a terrain catalogue")?;
    let text = ["id", "set", "name"];
    let numbers = [
        "n",
        "kc_kN_m_n1",
        "kphi_kN_m_n2",
        "c_kPa",
        "phi_deg",
        "K_m",
        "c1",
        "c2",
    ];
    let text = find(&table, text)?;
    let origin = [optional(&table, CONFIDENCE)?, optional(&table, SOURCE)?];
    let mut numbers = find(&table, numbers)?;
    let mut terrains: Vec<Terrain> = Vec::new();
    let mut lines: BTreeMap<String, u64> = BTreeMap::new();
    while let Some(row) = table.next()? {
        let terrain = terrain(&row, &text, &mut numbers, &origin, name)?;
        if let Some(first) = lines.insert(terrain.id.to_string(), row.line) {
            let id = terrain.id.to_string();
            let [id_column, ..] = &text;
            return Err(row.fail(id_column, Problem::DuplicateTerrain { id, first }));
        }
        terrains.push(terrain);
    }
    Ok(terrains)
}

/// The terrains that `[terrain] hypotheses` names: a set of the built-in catalogue, or a file, relative to `folder` (the
/// rover file's).
///
/// # Errors
/// [`DataError::Configuration`]: no such set, or what [`read_terrains`] says about the file.
pub fn hypothesis_terrains(
    settings: &TerrainSettings,
    folder: &Path,
) -> Result<Vec<Terrain>, DataError> {
    if names_a_file(&settings.hypotheses) {
        return read_terrains(folder.join(&settings.hypotheses));
    }
    catalogue::set(&settings.hypotheses).map_err(|e| {
        Origin::configuration("[terrain] hypotheses").fail_file(Problem::from_model(
            e,
            "a set of the catalogue or a .csv file",
        ))
    })
}

/// True where a user names a file of soils rather than a set of the catalogue: for `mine.csv` and `soils/mine`, not for
/// `wong21`.
pub fn names_a_file(hypotheses: &str) -> bool {
    hypotheses.contains(['/', '\\', '.'])
}

fn find<const N: usize>(table: &Table<'_>, names: [&str; N]) -> Result<[Bound; N], DataError> {
    let mut bound = Vec::with_capacity(N);
    for name in names {
        bound.push(Bound::plain(table, name, "it in a terrain catalogue")?);
    }
    bound.try_into().map_err(|_| {
        table.origin.fail_file(Problem::Empty {
            expected: "columns",
        })
    })
}

fn optional(table: &Table<'_>, name: &str) -> Result<Option<Bound>, DataError> {
    match table.position(name)? {
        Some(_) => Bound::plain(table, name, "it in a terrain catalogue").map(Some),
        None => Ok(None),
    }
}

fn terrain(
    row: &Row<'_>,
    [id, set, name]: &[Bound; 3],
    [n, k_c, k_phi, c, phi, k, c1, c2]: &mut [Bound; 8],
    [confidence, source]: &[Option<Bound>; 2],
    file: &str,
) -> Result<Terrain, DataError> {
    let text = |column: &Bound| printable(row, column).map(str::to_owned);
    let id_text = text(id)?;
    if id_text.is_empty() {
        return Err(row.fail(id, Problem::MissingValue { column: id.shown() }));
    }
    let stiffness = needed(row, k_c, |_| true, "a number")?;
    let k_phi = needed(row, k_phi, |v| v >= 0.0, "a number of at least 0")?;
    let degrees = needed(row, phi, |v| (0.0..90.0).contains(&v), "0 to 90 degrees")?;
    Ok(Terrain {
        id: id_text.into(),
        set: text(set)?.into(),
        name: text(name)?.into(),
        moisture: None,
        sinkage_exponent: needed(row, n, |v| v > 0.0, "a number above 0")?,
        k_c: stiffness * 1e3,
        k_phi: k_phi * 1e3,
        cohesion: needed(row, c, |v| v >= 0.0, "a number of at least 0")? * 1e3,
        friction_angle: degrees * PI / 180.0,
        shear_modulus: given(row, k, |v| v > 0.0, "a number above 0")?,
        c1: given(row, c1, |_| true, "a number")?,
        c2: given(row, c2, |_| true, "a number")?,
        class: "".into(),
        confidence: trust(row, confidence.as_ref())?,
        source: written(row, source.as_ref())?
            .unwrap_or_else(|| file.to_owned())
            .into(),
    })
}

/// A text that can be shown and written: files full of control characters are taken for binary.
fn printable<'a>(row: &'a Row<'_>, column: &Bound) -> Result<&'a str, DataError> {
    let text = row.text(column.index)?.trim();
    if text
        .chars()
        .any(|c| c.is_control() && !"\t\n\r".contains(c))
    {
        let problem = Problem::UnknownMark {
            column: column.shown(),
            found: short(&text.escape_debug().to_string()),
            expected: "text without control characters",
        };
        return Err(row.fail(column, problem));
    }
    Ok(text)
}

/// A text that may be missing.
fn written(row: &Row<'_>, column: Option<&Bound>) -> Result<Option<String>, DataError> {
    let Some(column) = column else {
        return Ok(None);
    };
    let text = printable(row, column)?;
    let missing = text.is_empty() || text.eq_ignore_ascii_case("na");
    Ok((!missing).then(|| text.to_owned()))
}

fn trust(row: &Row<'_>, column: Option<&Bound>) -> Result<Confidence, DataError> {
    let (Some(column), Some(mark)) = (column, written(row, column)?) else {
        return Ok(Confidence::Own);
    };
    Confidence::of_mark(&mark).ok_or_else(|| {
        let problem = Problem::UnknownMark {
            column: column.shown(),
            found: short(&mark),
            expected: MARKS,
        };
        row.fail(column, problem)
    })
}

/// A number that may be `NA`.
fn given(
    row: &Row<'_>,
    column: &mut Bound,
    legal: impl Fn(f64) -> bool,
    expected: &'static str,
) -> Result<Option<f64>, DataError> {
    match row.number(column)? {
        Some(v) if !legal(v) => Err(row.bad_value(column, v, expected)),
        value => Ok(value),
    }
}

/// A number that must be there.
fn needed(
    row: &Row<'_>,
    column: &mut Bound,
    legal: impl Fn(f64) -> bool,
    expected: &'static str,
) -> Result<f64, DataError> {
    match given(row, column, legal, expected)? {
        Some(v) => Ok(v),
        None => Err(row.fail(
            column,
            Problem::MissingValue {
                column: column.shown(),
            },
        )),
    }
}
