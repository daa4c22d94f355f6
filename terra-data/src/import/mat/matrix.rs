//! One variable: numbers, text, a cell array of texts, or a structure of these.

use super::element::{Bytes, MATRIX};

/// A variable or a field.
#[derive(Debug)]
pub(super) struct Array {
    pub(super) name: String,
    pub(super) content: Content,
}

/// What it holds.
#[derive(Debug)]
pub(super) enum Content {
    /// Column by column.
    Numbers {
        rows: usize,
        columns: usize,
        values: Vec<f64>,
    },
    /// Column by column.
    Texts {
        rows: usize,
        columns: usize,
        texts: Vec<String>,
    },
    Fields(Vec<Array>),
    /// In words.
    Other(&'static str),
}

/// Deepest structure inside a structure.
const DEEPEST: usize = 16;

/// The content of a matrix element; none for an empty cell.
pub(super) fn matrix(bytes: &mut Bytes<'_>, depth: usize) -> Result<Option<Array>, String> {
    if bytes.is_empty() {
        return Ok(None);
    }
    if depth > DEEPEST {
        return Err("structures nested too deep".to_owned());
    }
    let (_, mut flags) = bytes.element()?;
    let class = flags.u32()? & 0xff;
    let size: Vec<usize> = signed(bytes)?
        .into_iter()
        .map(|n| usize::try_from(n).map_err(|_| format!("an array of {n} rows or columns")))
        .collect::<Result<_, _>>()?;
    let (_, name) = bytes.element()?;
    let name = text(name)?;
    let content = match (class, size.as_slice()) {
        (1, &[rows, columns]) => cells(bytes, rows, columns, depth)?,
        (2, &[1, 1]) => fields(bytes, depth)?,
        (2, _) => Content::Other("an array of structures"),
        (4, &[rows, columns]) => lines(bytes, rows, columns, &name)?,
        (6..=15, &[rows, columns]) => {
            let (kind, data) = bytes.element()?;
            let values = data.numbers(kind)?;
            expect(&name, rows, columns, values.len())?;
            Content::Numbers {
                rows,
                columns,
                values,
            }
        }
        (1 | 4 | 6..=15, _) => Content::Other("an array of more than two dimensions"),
        (5, _) => Content::Other("a sparse matrix"),
        _ => Content::Other("an object"),
    };
    Ok(Some(Array { name, content }))
}

fn expect(name: &str, rows: usize, columns: usize, found: usize) -> Result<(), String> {
    match rows.checked_mul(columns) {
        Some(n) if n == found => Ok(()),
        _ => Err(format!("{name}: {found} values in {rows} x {columns}")),
    }
}

fn signed(bytes: &mut Bytes<'_>) -> Result<Vec<i64>, String> {
    let (kind, data) = bytes.element()?;
    Ok(data.numbers(kind)?.into_iter().map(|v| v as i64).collect())
}

fn text(bytes: Bytes<'_>) -> Result<String, String> {
    let codes = bytes.numbers(2)?;
    let bytes: Vec<u8> = codes.into_iter().map(|v| v as u8).collect();
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// A character array: one text a row, filled up with blanks.
fn lines(
    bytes: &mut Bytes<'_>,
    rows: usize,
    columns: usize,
    name: &str,
) -> Result<Content, String> {
    let (kind, data) = bytes.element()?;
    let codes = data.numbers(kind)?;
    expect(name, rows, columns, codes.len())?;
    // Rows without a character take no bytes, so their number is not to be believed.
    let rows = if codes.is_empty() { 0 } else { rows };
    let character = |v: f64| char::from_u32(v as u32).unwrap_or(char::REPLACEMENT_CHARACTER);
    let texts = (0..rows)
        .map(|r| {
            let line = codes.iter().skip(r).step_by(rows);
            let line: String = line.map(|v| character(*v)).collect();
            line.trim_end().to_owned()
        })
        .collect();
    Ok(Content::Texts {
        rows,
        columns: 1,
        texts,
    })
}

/// A cell array; only texts become a column.
fn cells(
    bytes: &mut Bytes<'_>,
    rows: usize,
    columns: usize,
    depth: usize,
) -> Result<Content, String> {
    let mut texts = vec![];
    let mut others = false;
    while !bytes.is_empty() {
        let (kind, mut inner) = bytes.element()?;
        if kind != MATRIX {
            return Err(format!("a cell of kind {kind}"));
        }
        match matrix(&mut inner, depth + 1)?.map(|a| a.content) {
            None => texts.push(String::new()),
            Some(Content::Texts { texts: t, .. }) if t.len() <= 1 => {
                texts.push(t.into_iter().next().unwrap_or_default());
            }
            Some(_) => others = true,
        }
    }
    if others {
        return Ok(Content::Other("a cell array of other things than texts"));
    }
    expect("a cell array", rows, columns, texts.len())?;
    Ok(Content::Texts {
        rows,
        columns,
        texts,
    })
}

/// A single structure: its fields in order, each under its own name.
fn fields(bytes: &mut Bytes<'_>, depth: usize) -> Result<Content, String> {
    let width = match signed(bytes)?.as_slice() {
        [n] if (1..=256).contains(n) => *n as usize,
        other => return Err(format!("field names of length {other:?}")),
    };
    let (_, names) = bytes.element()?;
    let names = names.numbers(2)?;
    let mut out = vec![];
    for name in names.chunks(width) {
        let name: Vec<u8> = name
            .iter()
            .map(|v| *v as u8)
            .take_while(|b| *b != 0)
            .collect();
        let (kind, mut inner) = bytes.element()?;
        if kind != MATRIX {
            return Err(format!("a field of kind {kind}"));
        }
        if let Some(array) = matrix(&mut inner, depth + 1)? {
            out.push(Array {
                name: String::from_utf8_lossy(&name).into_owned(),
                ..array
            });
        }
    }
    Ok(Content::Fields(out))
}
