//! Writes a file in whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::DataError;
use crate::problem::Problem;

/// Writes a file through a temporary one in the same directory, synchronised and then renamed: readers see the old
/// content or the new, never a part. A link is followed; a device or a pipe, which has no old content, is written directly.
///
/// # Errors
/// [`DataError::Write`]: the system's refusal, or the error of `write`. The old file is then as it was.
pub fn atomic_write(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), DataError> {
    let path = path.as_ref();
    replace(path, write, true)
}

/// [`atomic_write`] that refuses to overwrite.
///
/// # Errors
/// As [`atomic_write`], and [`Problem::Exists`].
pub fn atomic_write_new(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), DataError> {
    let path = path.as_ref();
    if path.symlink_metadata().is_ok() {
        return Err(DataError::write(path, Problem::Exists));
    }
    replace(path, write, false)
}

/// Temporary files that are being written. Whoever holds it knows that none appears, and none becomes the file it is for.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(vec![]);

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the temporary files of writes that have not ended, and lets no write begin or end any more: for what ends the
/// process at once, as an interrupt does.
pub fn abandon_writes() {
    let unfinished = unfinished();
    for path in unfinished.iter() {
        // What cannot be removed stays; there is nobody left to be told.
        let _ = fs::remove_file(path);
    }
    std::mem::forget(unfinished);
}

/// A temporary file's entry in the list.
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

fn replace(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    overwrite: bool,
) -> Result<(), DataError> {
    let fail = |e: io::Error| {
        let reason = e.to_string();
        DataError::write(path, Problem::NotWritable { reason })
    };
    // A rename would replace a link by the file, and a device by a file.
    let target = match fs::canonicalize(path) {
        Ok(target) => target,
        Err(_) => path.to_owned(),
    };
    match fs::metadata(&target) {
        Ok(about) if about.is_dir() => {
            return Err(DataError::write(path, Problem::IsDirectory));
        }
        Ok(about) if !about.is_file() => return direct(&target, write).map_err(fail),
        _ => {}
    }
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    };
    let (mut temporary, listed) = {
        let mut unfinished = unfinished();
        let temporary = temporary_in(&folder).map_err(fail)?;
        unfinished.push(temporary.path().to_owned());
        let listed = Listed(temporary.path().to_owned());
        (temporary, listed)
    };
    {
        let mut out = BufWriter::new(temporary.as_file_mut());
        write(&mut out).and_then(|()| out.flush()).map_err(fail)?;
    }
    temporary.as_file().sync_all().map_err(fail)?;
    let kept = {
        let _no_interrupt = unfinished();
        if overwrite {
            temporary.persist(&target)
        } else {
            temporary.persist_noclobber(&target)
        }
    };
    drop(listed);
    kept.map_err(|e| match e.error.kind() {
        io::ErrorKind::AlreadyExists => DataError::write(path, Problem::Exists),
        _ => fail(e.error),
    })?;
    // The rename itself survives a power cut only once the directory is on disk; not every system can do that.
    if let Ok(folder) = File::open(&folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

fn temporary_in(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".terra-").suffix(".tmp");
    // Temporary files are private by default; a result should be as readable as any file its user makes.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

fn direct(target: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(OpenOptions::new().write(true).open(target)?);
    write(&mut out)?;
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    #[test]
    fn a_failing_writer_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        atomic_write(&path, |w| w.write_all(b"old")).unwrap();
        let result = atomic_write(&path, |w| {
            w.write_all(&[b'x'; 100_000])?;
            Err(io::Error::other("the disk is full"))
        });
        let error = result.unwrap_err();
        assert!(
            error.is_write() && error.to_string().contains("the disk is full"),
            "{error}"
        );
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["log.csv"]);
    }

    /// While a file is written its temporary one is on the list, by which an interrupt removes it; afterwards it is not, however
    /// the writing ended.
    #[test]
    fn what_is_being_written_is_known() {
        let folder = tempfile::tempdir().unwrap();
        let of_folder = || -> Vec<PathBuf> {
            let all = unfinished();
            let here = |p: &&PathBuf| p.starts_with(folder.path());
            all.iter().filter(here).cloned().collect()
        };
        let path = folder.path().join("log.csv");
        for fails in [false, true] {
            let result = atomic_write(&path, |w| {
                w.write_all(b"half")?;
                let known = of_folder();
                assert_eq!(known.len(), 1);
                assert!(known[0].exists());
                if fails {
                    Err(io::Error::other("no"))
                } else {
                    Ok(())
                }
            });
            assert_eq!(result.is_err(), fails);
            assert_eq!(of_folder(), Vec::<PathBuf>::new());
        }
    }

    #[test]
    fn only_asked_for_overwriting() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        atomic_write_new(&path, |w| w.write_all(b"first")).unwrap();
        let error = atomic_write_new(&path, |w| w.write_all(b"second")).unwrap_err();
        assert_eq!(error.problem(), &Problem::Exists);
        assert_eq!(fs::read(&path).unwrap(), b"first");
        atomic_write(&path, |w| w.write_all(b"third")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"third");
    }

    #[test]
    fn a_directory_and_a_missing_directory_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = atomic_write(folder.path(), |_| Ok(())).unwrap_err();
        assert_eq!(error.problem(), &Problem::IsDirectory);
        let error = atomic_write(folder.path().join("no/such"), |_| Ok(())).unwrap_err();
        assert!(
            matches!(error.problem(), Problem::NotWritable { .. }),
            "{error}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_and_a_device_stays_one() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        atomic_write(&link, |w| w.write_all(b"new")).unwrap();
        assert!(link.symlink_metadata().unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        // As readable as a file made in the plain way: both follow the umask.
        use std::os::unix::fs::PermissionsExt;
        let (written, plain) = (folder.path().join("written"), folder.path().join("plain"));
        atomic_write(&written, |w| w.write_all(b"1")).unwrap();
        fs::write(&plain, "1").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&written), mode(&plain));
        atomic_write("/dev/null", |w| w.write_all(b"gone")).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
