//! `cargo xtask check`: the steps of CI, one after the other.
//!
//! All steps build with one profile and the same flags, so that each dependency is checked once and built once.

use std::collections::BTreeSet;
use std::time::Instant;

use crate::python;
use crate::shell::{cargo, installed, output, run as run_command};

/// One step: its name, what a failure means, and how it is run.
struct Step {
    name: &'static str,
    claim: &'static str,
    run: fn() -> Result<Outcome, String>,
}

pub(crate) enum Outcome {
    Passed,
    Skipped(&'static str),
}

/// In order of cost, so that the cheap ones fail first.
const STEPS: &[Step] = &[
    Step {
        name: "dependency-rule",
        claim: "the diagnosis cannot know what the simulator withheld",
        run: dependency_rule,
    },
    Step {
        name: "one-nalgebra",
        claim: "matrices of one crate fit the next",
        run: one_nalgebra,
    },
    Step {
        name: "fmt",
        claim: "the code is formatted",
        run: || {
            passes(&["fmt", "--all", "--check"])?;
            // A workspace of its own, which only a nightly compiler builds.
            passes(&["fmt", "--manifest-path", "fuzz/Cargo.toml", "--check"])
        },
    },
    Step {
        name: "clippy",
        claim: "no lint fires",
        run: || {
            passes(&[
                "clippy",
                "--workspace",
                "--exclude",
                "terra-py",
                "--all-targets",
                "--",
                "-D",
                "warnings",
            ])
        },
    },
    Step {
        name: "tests",
        claim: "every test passes",
        run: || passes(&["test", "--workspace"]),
    },
    Step {
        name: "benches",
        claim: "each bench runs once and its answers are right",
        // The test profile on purpose: the bench profile would build everything a second time.
        run: || passes(&["test", "--workspace", "--bench", "*"]),
    },
    Step {
        name: "docs",
        claim: "the documentation builds without a warning",
        run: docs,
    },
    Step {
        name: "readers",
        claim: "every optional reader gives the log that was written",
        run: readers,
    },
    Step {
        name: "python",
        claim: "the Python package builds, lints, documents and gives the command's numbers",
        run: python::check,
    },
    Step {
        name: "deny",
        claim: "licences and duplicates are as deny.toml says",
        run: deny,
    },
];

/// Runs the steps that the arguments leave, up to the first failure.
pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    for step in select(arguments)? {
        println!("== {}: {}", step.name, step.claim);
        let start = Instant::now();
        let outcome = (step.run)().map_err(|e| format!("{e}\n== {}: FAILED", step.name))?;
        let seconds = start.elapsed().as_secs_f64();
        match outcome {
            Outcome::Passed => println!("== {}: passed in {seconds:.0} s", step.name),
            Outcome::Skipped(why) => println!("== {}: skipped, {why}", step.name),
        }
    }
    Ok(())
}

/// `--only STEP` keeps the named steps, `--except STEP` drops them.
fn select(arguments: &[String]) -> Result<Vec<&'static Step>, String> {
    let mut only = vec![];
    let mut except = vec![];
    let mut words = arguments.iter();
    while let Some(flag) = words.next() {
        let list = match flag.as_str() {
            "--only" => &mut only,
            "--except" => &mut except,
            _ => return Err(format!("unknown argument '{flag}'; steps: {}", names())),
        };
        let name = words
            .next()
            .ok_or_else(|| format!("{flag} needs a step; steps: {}", names()))?;
        if STEPS.iter().all(|s| s.name != name) {
            return Err(format!("no step '{name}'; steps: {}", names()));
        }
        list.push(name.as_str());
    }
    Ok(STEPS
        .iter()
        .filter(|s| only.is_empty() || only.contains(&s.name))
        .filter(|s| !except.contains(&s.name))
        .collect())
}

fn names() -> String {
    STEPS.iter().map(|s| s.name).collect::<Vec<_>>().join(", ")
}

fn passes(arguments: &[&str]) -> Result<Outcome, String> {
    run_command(&mut cargo(arguments))?;
    Ok(Outcome::Passed)
}

fn docs() -> Result<Outcome, String> {
    let arguments = ["doc", "--workspace", "--exclude", "terra-py", "--no-deps"];
    run_command(cargo(&arguments).env("RUSTDOCFLAGS", "-D warnings"))?;
    Ok(Outcome::Passed)
}

/// With features that the default build leaves out; their C parts need a compiler.
fn readers() -> Result<Outcome, String> {
    if !installed("cc") {
        return Ok(Outcome::Skipped("there is no C compiler"));
    }
    passes(&[
        "clippy",
        "--package",
        "terra-data",
        "--all-features",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ])?;
    passes(&["test", "--package", "terra-data", "--all-features"])?;
    // The measured vehicle comes as Parquet. Both ask for the whole workspace, which takes its dependencies as they are already
    // built for the tests, and each other's.
    let parquet = ["test", "--workspace", "--features", "terra/parquet"];
    passes(&[&parquet[..], &["--test", "kinematic"]].concat())?;
    passes(&[&parquet[..], &["--test", "command", "the_measured_husky"]].concat())
}

fn dependency_rule() -> Result<Outcome, String> {
    let tree = [
        "tree",
        "-p",
        "terra-gap",
        "-e",
        "normal,build",
        "--prefix",
        "none",
    ];
    let tree = output(&mut cargo(&tree))?;
    if !has_package(&tree, "terra-model") {
        return Err(format!("the tree of terra-gap cannot be read:\n{tree}"));
    }
    if has_package(&tree, "terra-sim") {
        return Err("terra-gap depends on terra-sim".to_owned());
    }
    Ok(Outcome::Passed)
}

fn one_nalgebra() -> Result<Outcome, String> {
    let tree = output(&mut cargo(&["tree", "--workspace", "--prefix", "none"]))?;
    let versions = versions(&tree, "nalgebra");
    if versions.len() == 1 {
        Ok(Outcome::Passed)
    } else {
        Err(format!("expected one nalgebra, found {versions:?}"))
    }
}

/// The versions of a package in the output of `cargo tree --prefix none`.
fn versions(tree: &str, package: &str) -> BTreeSet<String> {
    let words = tree.lines().map(|line| line.split_whitespace());
    let rows = words.filter_map(|mut w| Some((w.next()?, w.next()?)));
    rows.filter(|(name, _)| *name == package)
        .map(|(_, version)| version.to_owned())
        .collect()
}

/// Whether a line of `cargo tree --prefix none` is that package.
fn has_package(tree: &str, package: &str) -> bool {
    tree.lines()
        .any(|line| line.split_whitespace().next() == Some(package))
}

fn deny() -> Result<Outcome, String> {
    if !installed("cargo-deny") {
        return Ok(Outcome::Skipped("cargo-deny is not installed"));
    }
    passes(&["deny", "check"])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn selected(arguments: &[&str]) -> Result<Vec<&'static str>, String> {
        let owned: Vec<String> = arguments.iter().map(|a| (*a).to_owned()).collect();
        select(&owned).map(|steps| steps.iter().map(|s| s.name).collect())
    }

    #[test]
    fn steps_are_selected_by_name() {
        assert_eq!(selected(&[]).map(|s| s.len()), Ok(STEPS.len()));
        assert_eq!(selected(&["--only", "docs"]), Ok(vec!["docs"]));
        let rest = selected(&["--except", "tests"]);
        assert!(rest.is_ok_and(|r| r.len() == STEPS.len() - 1 && !r.contains(&"tests")));
    }

    #[test]
    fn an_unknown_step_is_refused_with_the_known_ones() {
        for arguments in [&["--only", "test"][..], &["--only"], &["tests"]] {
            let error = selected(arguments);
            assert!(error.is_err_and(|e| e.contains("dependency-rule, one-nalgebra")));
        }
    }

    #[test]
    fn a_package_is_a_whole_first_word() {
        let tree =
            "terra-gap v0.1.0 (/src/terra-sim/x)\nterra-simple v1.0.0\nterra-model v0.1.0 (*)\n";
        assert!(!has_package(tree, "terra-sim"));
        assert!(has_package(tree, "terra-model"));
    }

    #[test]
    fn two_versions_are_two() {
        let tree =
            "nalgebra v0.35.0\nnalgebra-macros v0.3.0\nnalgebra v0.35.0 (*)\n\nnalgebra v0.33.1\n";
        assert_eq!(versions(tree, "nalgebra").len(), 2);
        assert_eq!(versions(tree, "nalgebra-macros").len(), 1);
    }
}
