//! The Python package. Its crate needs a Python to build against, so it is left out of all other steps.

use std::fs;
use std::path::PathBuf;

use crate::check::Outcome;
use crate::shell::{cargo, command, output, root, run, target};

/// What the step needs beside a Python: the first of each is its name on the package index, the second as it is imported.
const NEEDED: [(&str, &str); 4] = [
    ("maturin>=1.7,<2", "maturin"),
    ("numpy>=1.24", "numpy"),
    ("pytest", "pytest"),
    ("dask[distributed]", "dask.distributed"),
];

/// A Python with all that is needed: the one at hand, or an environment of its own beside the build.
fn interpreter() -> Result<String, &'static str> {
    let imports = NEEDED.map(|(_, module)| module).join(", ");
    let complete = |python: &str| {
        let imports = format!("import pip, {imports}");
        output(&mut command(python, &["-c", &imports])).is_ok()
    };
    let usual = "python3".to_owned();
    if complete(&usual) {
        return Ok(usual);
    }
    let folder = root().join("target/python/venv");
    let own = folder.join("bin/python").to_string_lossy().into_owned();
    if complete(&own) {
        return Ok(own);
    }
    let folder = folder.to_string_lossy();
    output(&mut command(&usual, &["-m", "venv", &folder]))
        .map_err(|_| "there is no python3 that makes environments")?;
    let mut install = vec!["-m", "pip", "install", "--quiet"];
    install.extend(NEEDED.map(|(package, _)| package));
    output(&mut command(&own, &install))
        .map_err(|_| "maturin, numpy, pytest and dask are neither here nor to be had by pip")?;
    Ok(own)
}

/// Lints and documents the crate, builds a wheel with the flags of all other steps, and runs its tests on that wheel.
pub(crate) fn check() -> Result<Outcome, String> {
    let python = match interpreter() {
        Ok(python) => python,
        Err(why) => return Ok(Outcome::Skipped(why)),
    };
    run(cargo(&[
        "clippy",
        "--package",
        "terra-py",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ])
    .env("PYO3_PYTHON", &python))?;
    let doc = ["doc", "--package", "terra-py", "--no-deps"];
    run(cargo(&doc)
        .env("RUSTDOCFLAGS", "-D warnings")
        .env("PYO3_PYTHON", &python))?;
    // The command that its answers are compared with, as the tests build it: alone it would come with other features of what it
    // depends on, and all be built once more.
    let command_of_tests = ["test", "--workspace", "--no-run", "--test", "command"];
    run(&mut cargo(&command_of_tests))?;
    let wheel = wheel(&python)?;
    let site = root().join("target/python/site");
    let site = site.to_string_lossy();
    run(&mut command(
        &python,
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
    run(command(&python, &["-m", "pytest", "--quiet", "-rs"])
        .env("PYTHONPATH", site.as_ref())
        .env("TERRA_COMMAND", target().join("debug/terra"))
        .env("PYTHONDONTWRITEBYTECODE", "1"))?;
    Ok(Outcome::Passed)
}

/// Builds the wheel and gives its path.
fn wheel(python: &str) -> Result<String, String> {
    let folder: PathBuf = root().join("target/python/wheels");
    // One wheel only, so that it is known which is new.
    let _ = fs::remove_dir_all(&folder);
    let to = folder.to_string_lossy();
    run(&mut command(
        python,
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
