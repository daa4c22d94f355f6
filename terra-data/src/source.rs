//! Opening files, and telling text from what is no text.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::error::{DataError, Origin};
use crate::problem::Problem;

/// Bytes looked at before a file is taken for text.
const PREFIX: usize = 4096;

/// Opens a file for reading; a directory and a circle of links are errors of their own.
pub(crate) fn open(path: &Path, origin: &Origin) -> Result<File, DataError> {
    let file = File::open(path).map_err(|e| unreadable(origin, &e))?;
    let about = file.metadata().map_err(|e| unreadable(origin, &e))?;
    if about.is_dir() {
        return Err(origin.fail_file(Problem::IsDirectory));
    }
    Ok(file)
}

/// Largest configuration; a real one has a few kilobytes.
const LARGEST: u64 = 1 << 20;

/// The whole text of a small file, without a byte order mark.
pub(crate) fn read_text(
    path: &Path,
    origin: &Origin,
    expected: &'static str,
) -> Result<String, DataError> {
    let mut file = open(path, origin)?;
    // The beginning is looked at first: a device may never end.
    let mut bytes = text_prefix(&mut file, origin, expected)?;
    file.take(LARGEST)
        .read_to_end(&mut bytes)
        .map_err(|e| unreadable(origin, &e))?;
    if bytes.len() as u64 >= LARGEST {
        return Err(origin.fail_file(Problem::TooLarge { limit: LARGEST }));
    }
    match std::str::from_utf8(&bytes) {
        Ok(text) => Ok(text.to_owned()),
        Err(e) => {
            let good = std::str::from_utf8(bytes.get(..e.valid_up_to()).unwrap_or_default())
                .unwrap_or_default();
            let (line, column) = position(good, good.len());
            let byte = bytes.get(e.valid_up_to()).copied().unwrap_or_default();
            Err(origin.fail(line, column, Problem::NotUtf8 { byte }))
        }
    }
}

/// Line and column (characters), both from 1, of a byte offset in a text.
pub(crate) fn position(text: &str, offset: usize) -> (u64, u64) {
    let before = text
        .char_indices()
        .take_while(|(at, _)| *at < offset)
        .map(|(_, c)| c);
    before.fold((1, 1), |(line, column), c| {
        if c == '\n' {
            (line + 1, 1)
        } else {
            (line, column + 1)
        }
    })
}

/// The first bytes of a stream, checked to be text, without a byte order mark; the stream goes on after them.
pub(crate) fn text_prefix(
    reader: &mut impl Read,
    origin: &Origin,
    expected: &'static str,
) -> Result<Vec<u8>, DataError> {
    let mut prefix = Vec::with_capacity(PREFIX);
    reader
        .by_ref()
        .take(PREFIX as u64)
        .read_to_end(&mut prefix)
        .map_err(|e| unreadable(origin, &e))?;
    check_text(&prefix, origin)?;
    let text = without_mark(&prefix);
    if prefix.len() < PREFIX && text.iter().all(u8::is_ascii_whitespace) {
        return Err(origin.fail_file(Problem::Empty { expected }));
    }
    Ok(text.to_vec())
}

/// The operating system's refusal as a typed error.
pub(crate) fn unreadable(origin: &Origin, error: &io::Error) -> DataError {
    // `ErrorKind::FilesystemLoop` is not stable; these are ELOOP of Linux and of macOS.
    let is_loop = if cfg!(target_os = "linux") {
        error.raw_os_error() == Some(40)
    } else {
        cfg!(unix) && error.raw_os_error() == Some(62)
    };
    origin.fail_file(match error.kind() {
        _ if is_loop => Problem::SymlinkLoop,
        io::ErrorKind::NotFound => Problem::NotFound,
        io::ErrorKind::IsADirectory => Problem::IsDirectory,
        _ => Problem::Unreadable {
            reason: error.to_string(),
        },
    })
}

fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Formats that people hand over by mistake, by their first bytes.
const MAGIC: [(&[u8], bool, &str); 11] = [
    (b"\x1f\x8b", true, "gzip"),
    (b"\x28\xb5\x2f\xfd", true, "zstd"),
    (b"BZh", true, "bzip2"),
    (b"\xfd7zXZ\0", true, "xz"),
    (b"PK\x03\x04", true, "zip, or a spreadsheet"),
    (b"PAR1", false, "Parquet"),
    (b"\x89MCAP", false, "MCAP"),
    (b"\x89HDF", false, "HDF5, or a MATLAB file"),
    (b"MATLAB 5.0 MAT-file", false, "MATLAB file"),
    (b"#ROSBAG", false, "ROS bag"),
    (b"SQLite format 3\0", false, "SQLite, or a ROS 2 bag"),
];

fn check_text(prefix: &[u8], origin: &Origin) -> Result<(), DataError> {
    let prefix = prefix.get(..PREFIX).unwrap_or(prefix);
    if let Some((_, compressed, format)) =
        MAGIC.iter().find(|(magic, _, _)| prefix.starts_with(magic))
    {
        return Err(origin.fail_file(if *compressed {
            Problem::Compressed { format }
        } else {
            Problem::Binary { format }
        }));
    }
    // Without its mark, UTF-16 of Latin letters has a NUL in every second byte.
    let nul_at = |parity: usize| {
        prefix
            .iter()
            .skip(parity)
            .step_by(2)
            .filter(|b| **b == 0)
            .count()
    };
    let half = prefix.len() / 2;
    let marked = prefix.starts_with(b"\xff\xfe") || prefix.starts_with(b"\xfe\xff");
    if marked || (half >= 4 && (nul_at(0) * 4 > half * 3) != (nul_at(1) * 4 > half * 3)) {
        return Err(origin.fail_file(Problem::Utf16));
    }
    let control = |b: &&u8| (**b < 0x20 && !b"\t\n\r\x0c".contains(b)) || **b == 0x7f;
    if prefix.iter().filter(control).count() * 10 > prefix.len() {
        return Err(origin.fail_file(Problem::Binary {
            format: "unknown format",
        }));
    }
    Ok(())
}
