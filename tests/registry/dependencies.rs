//! Who may use whom. Above all: a diagnosis that cannot see the simulator cannot know what it withheld.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// The crates of this workspace that a package is built with, tests and benches left out; none without cargo's help.
fn uses(package: &str) -> Option<BTreeSet<String>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let asked = Command::new(cargo)
        .args([
            "tree",
            "--offline",
            "--edges",
            "normal,build",
            "--prefix",
            "none",
            "--format",
            "{p}",
        ])
        .args(["--all-features", "--package", package, "--manifest-path"])
        .arg(&manifest)
        .output();
    let output = match asked {
        Ok(output) if output.status.success() => output,
        Ok(output) => {
            let why = String::from_utf8_lossy(&output.stderr).into_owned();
            println!("SKIPPED: cargo tree cannot answer here: {}", why.trim());
            return None;
        }
        Err(e) => {
            println!("SKIPPED: cargo is not here: {e}");
            return None;
        }
    };
    let tree = String::from_utf8(output.stdout).unwrap();
    let names = tree.lines().filter_map(|l| l.split_whitespace().next());
    Some(
        names
            .filter(|n| n.starts_with("terra") && *n != package)
            .map(str::to_owned)
            .collect(),
    )
}

#[test]
fn each_crate_knows_only_what_stands_below_it() {
    let table: [(&str, &[&str]); 6] = [
        ("terra-model", &[]),
        ("terra-ekf", &["terra-model"]),
        ("terra-data", &["terra-model"]),
        ("terra-mme", &["terra-model", "terra-ekf"]),
        ("terra-sim", &["terra-model", "terra-data"]),
        (
            "terra-gap",
            &["terra-model", "terra-ekf", "terra-mme", "terra-data"],
        ),
    ];
    for (package, allowed) in table {
        let Some(found) = uses(package) else { return };
        for name in &found {
            assert!(
                allowed.contains(&name.as_str()),
                "{package} is built with {name}"
            );
        }
        // Every crate but the lowest stands on the models: an empty answer would mean a question not understood.
        assert_eq!(
            found.contains("terra-model"),
            package != "terra-model",
            "{package}: {found:?}"
        );
    }
}
