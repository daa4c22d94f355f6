//! The Python package. Its crate needs a Python to build against, so it is left out of all other steps.

use std::fs;
use std::path::PathBuf;

use crate::check::Outcome;
use crate::shell::{cargo, command, output, root, run};

/// Lints and documents the crate, builds a wheel with the flags of all other steps, and runs its tests on that wheel.
pub(crate) fn check() -> Result<Outcome, String> {
    let modules = ["-c", "import maturin, numpy, pip, pytest"];
    if output(&mut command("python3", &modules)).is_err() {
        return Ok(Outcome::Skipped(
            "python3 with maturin, numpy, pip and pytest is not here",
        ));
    }
    run(&mut cargo(&[
        "clippy",
        "--package",
        "terra-py",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ]))?;
    let doc = ["doc", "--package", "terra-py", "--no-deps"];
    run(cargo(&doc).env("RUSTDOCFLAGS", "-D warnings"))?;
    // What its answers are compared with.
    run(&mut cargo(&["build", "--package", "terra"]))?;
    let wheel = wheel()?;
    let site = root().join("target/python/site");
    let site = site.to_string_lossy();
    run(&mut command(
        "python3",
        &[
            "-m",
            "pip",
            "install",
            "--quiet",
            "--no-deps",
            "--no-index",
            "--upgrade",
            "--target",
            &site,
            &wheel,
        ],
    ))?;
    run(command("python3", &["-m", "pytest", "--quiet", "-rs"])
        .env("PYTHONPATH", site.as_ref())
        .env("PYTHONDONTWRITEBYTECODE", "1"))?;
    Ok(Outcome::Passed)
}

/// Builds the wheel and gives its path.
fn wheel() -> Result<String, String> {
    let folder: PathBuf = root().join("target/python/wheels");
    // One wheel only, so that it is known which is new.
    let _ = fs::remove_dir_all(&folder);
    let to = folder.to_string_lossy();
    run(&mut command(
        "python3",
        &[
            "-m",
            "maturin",
            "build",
            "--locked",
            "--profile",
            "dev",
            // In place of the readers that pyproject.toml asks for: they would build everything a second time, and have a
            // step of their own.
            "--features",
            "pyo3/extension-module",
            // Stripping is part of the profile: with it all dependencies would be built a second time.
            "--strip",
            "false",
            "--out",
            &to,
        ],
    ))?;
    let failed = |e: std::io::Error| format!("{to}: {e}");
    for entry in fs::read_dir(&folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.extension().is_some_and(|e| e == "whl") {
            return Ok(path.to_string_lossy().into_owned());
        }
    }
    Err(format!("{to}: no wheel"))
}
