//! Where the measured data lies.

use std::path::PathBuf;

/// The data folder `TERRA_DATA` (default `../shared/data` from the workspace root), or a clear word that it is absent.
pub(crate) fn data(file: &str) -> Option<PathBuf> {
    let root = std::env::var_os("TERRA_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data"),
        PathBuf::from,
    );
    let path = root.join(file);
    if path.exists() {
        Some(path)
    } else {
        println!(
            "SKIPPED: {} is not there; set TERRA_DATA to the folder that holds it",
            path.display()
        );
        None
    }
}
