//! Input files with their fingerprints.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest, Sha256};
use terra_data::{
    DataError, DriveLog, DriveReader, LogKind, RigLog, Rover, log_kind, log_kind_from,
    read_drive_log, read_drive_log_from, read_rig_log, read_rig_log_from, read_rover_with,
};
use terra_model::Registry;

use crate::error::CliError;

/// Rows of a drive log read at a time.
pub(crate) const BLOCK: usize = 1024;

fn hexadecimal(digest: impl AsRef<[u8]>) -> String {
    digest.as_ref().iter().map(|b| format!("{b:02x}")).collect()
}

/// SHA-256 of bytes, in hexadecimal.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    hexadecimal(Sha256::digest(bytes))
}

/// SHA-256 of a file that was just read; empty when it can no longer be read.
fn sha256_of(path: &Path) -> String {
    // In pieces: a log may be larger than memory.
    let digest = || -> io::Result<String> {
        let mut file = File::open(path)?;
        let mut digest = Sha256::new();
        let mut piece = vec![0; 1 << 16];
        loop {
            match file.read(&mut piece)? {
                0 => return Ok(hexadecimal(digest.finalize())),
                n => digest.update(piece.get(..n).unwrap_or_default()),
            }
        }
    };
    digest().unwrap_or_default()
}

/// The whole of a file of measurements.
pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>, CliError> {
    std::fs::read(path).map_err(|e| CliError::BadData {
        message: format!("{}: cannot be read: {e}", path.display()),
        help: None,
    })
}

/// The rover file, with its fingerprint.
pub(crate) fn rover(path: &Path) -> Result<(Rover, String), CliError> {
    rover_with(path, &Registry::builtin())
}

/// [`rover`] with the caller's own models and effects.
pub(crate) fn rover_with(path: &Path, registry: &Registry) -> Result<(Rover, String), CliError> {
    let rover = read_rover_with(path, registry)?;
    Ok((rover, sha256_of(path)))
}

/// A log, which is read more than once: for its kind, its rows and its fingerprint.
pub(crate) struct LogFile<'a> {
    path: &'a Path,
    /// What came through a pipe, which gives it only once, or from memory.
    piped: Option<Vec<u8>>,
}

impl<'a> LogFile<'a> {
    /// Where it is, or what it is called.
    pub(crate) fn path(&self) -> &'a Path {
        self.path
    }

    pub(crate) fn open(path: &'a Path) -> Result<Self, CliError> {
        let piped = if is_pipe(path) {
            Some(bytes(path)?)
        } else {
            None
        };
        Ok(LogFile { path, piped })
    }

    /// A log that is in memory already.
    pub(crate) fn in_memory(name: &'a str, bytes: &[u8]) -> Self {
        LogFile {
            path: Path::new(name),
            piped: Some(bytes.to_vec()),
        }
    }

    fn name(&self) -> String {
        self.path.display().to_string()
    }

    pub(crate) fn kind(&self, rover: &Rover) -> Result<LogKind, DataError> {
        match &self.piped {
            Some(bytes) => log_kind_from(bytes.as_slice(), &self.name(), rover),
            None => log_kind(self.path, rover),
        }
    }

    pub(crate) fn drive(&self, rover: &Rover) -> Result<DriveLog, DataError> {
        match &self.piped {
            Some(bytes) => read_drive_log_from(bytes.as_slice(), &self.name(), rover),
            None => read_drive_log(self.path, rover),
        }
    }

    /// The rows of a drive log in blocks; each call begins at the first.
    pub(crate) fn drive_blocks(&self, rover: &Rover) -> Result<DriveReader<'_>, DataError> {
        match &self.piped {
            Some(bytes) => DriveReader::from_reader(bytes.as_slice(), &self.name(), rover),
            None => DriveReader::open(self.path, rover),
        }
    }

    pub(crate) fn rig(&self, rover: &Rover) -> Result<RigLog, DataError> {
        match &self.piped {
            Some(bytes) => read_rig_log_from(bytes.as_slice(), &self.name(), rover),
            None => read_rig_log(self.path, rover),
        }
    }

    /// SHA-256 in hexadecimal.
    pub(crate) fn sha256(&self) -> String {
        match &self.piped {
            Some(bytes) => sha256(bytes),
            None => sha256_of(self.path),
        }
    }
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|about| about.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}
