//! Every command of the book and of the README, word for word, in a folder that holds the files they name; what a page
//! shows of an answer is what the command says. A block that stands nowhere below fails the test of its page, so no new
//! one goes untried.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::support::{Csv, Done, example, finish, folder, json, list, logs, number, terra, text};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A fenced block of a page: its language and its lines.
struct Block {
    language: String,
    text: String,
}

/// The blocks of a page of the book, or of another file from the root.
fn blocks(page: &str) -> Vec<Block> {
    let source = fs::read_to_string(root().join(page)).unwrap();
    let mut blocks: Vec<Block> = vec![];
    let mut open = false;
    for line in source.lines() {
        match line.strip_prefix("```") {
            Some(_) if open => open = false,
            Some(language) => {
                open = true;
                blocks.push(Block {
                    language: language.to_owned(),
                    text: String::new(),
                });
            }
            None if open => {
                assert!(
                    !line.contains("```"),
                    "{page}: a fence within the line {line}"
                );
                let text = &mut blocks.last_mut().unwrap().text;
                text.push_str(line);
                text.push('\n');
            }
            None => {}
        }
    }
    assert!(!open, "{page}: a block has no end");
    blocks
}

/// The only block of that language, or the one at that place among them.
fn block(page: &str, language: &str, k: usize) -> String {
    let all: Vec<_> = blocks(page)
        .into_iter()
        .filter(|b| b.language == language)
        .collect();
    all[k].text.clone()
}

/// The command lines of a page, continued ones joined, comments between them left out.
fn commands(page: &str) -> Vec<String> {
    let of = blocks(page).into_iter().filter(|b| b.language == "sh");
    let text: String = of.map(|b| b.text).collect();
    text.replace("\\\n", " ")
        .lines()
        .map(str::trim)
        .filter(|l| !l.is_empty() && !l.starts_with('#'))
        .map(str::to_owned)
        .collect()
}

/// Where a folder has the examples and a home.
fn place(name: &str) -> PathBuf {
    let at = folder(&format!("book_{name}"));
    symlink(root().join("examples"), at.join("examples")).unwrap();
    fs::create_dir_all(at.join("home/secret")).unwrap();
    at
}

/// A line by a shell, as a reader would type it, with `terra` and what lies in `bin` on the path.
fn shell(at: &Path, line: &str) -> Done {
    let terra = Path::new(env!("CARGO_BIN_EXE_terra")).parent().unwrap();
    let usual = std::env::var_os("PATH").unwrap();
    let first = [at.join("bin"), terra.to_owned()];
    let path = std::env::join_paths(first.into_iter().chain(std::env::split_paths(&usual)));
    finish(
        Command::new("sh")
            .args(["-euc", line])
            .current_dir(at)
            .env("PATH", path.unwrap())
            .env("HOME", at.join("home"))
            .env("RUST_BACKTRACE", "1")
            .stdin(Stdio::null()),
    )
}

/// Runs all command lines of a page: all that begin with `terra`, of which some take fewer cases than a reader has time
/// for. `elsewhere` are those that other tests run.
fn follow(page: &str, at: &Path, fewer: &[(&str, &str)], elsewhere: &[&str]) -> Vec<Done> {
    let mut left: Vec<_> = elsewhere.to_vec();
    let mut used = vec![false; fewer.len()];
    let mut done = vec![];
    for line in commands(page) {
        if let Some(k) = left.iter().position(|l| line.starts_with(l)) {
            left.remove(k);
            continue;
        }
        assert!(
            line.starts_with("terra ") || line.starts_with("sbatch "),
            "{page}: nothing runs `{line}`"
        );
        let mut run = line.clone();
        for ((from, to), used) in fewer.iter().zip(&mut used) {
            if run.contains(from) {
                run = run.replace(from, to);
                *used = true;
            }
        }
        let end = shell(at, &run);
        assert_eq!((end.code, &*end.err), (0, ""), "{page}: `{run}`");
        done.push(end);
    }
    assert!(left.is_empty(), "{page} has no line {left:?}");
    assert!(used.iter().all(|u| *u), "{page} has none of {fewer:?}");
    done
}

/// Each line that a page shows of an answer stands in it, in this order, however the page breaks it; `...` stands for
/// anything, and lines may be left out.
fn shows(page: &str, shown: &str, said: &str) {
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let all = words(said);
    let mut rest = all.as_str();
    for part in shown.lines().flat_map(|l| l.split("...")).map(words) {
        let Some((_, behind)) = rest.split_once(&part) else {
            panic!("{page} shows\n{part}\nand the command says\n{said}");
        };
        rest = behind;
    }
}

fn copy(from: &Path, to: &Path) {
    fs::copy(from, to).unwrap();
}

/// A measured file, or a clear word that it is absent.
fn measured(file: &str) -> Option<PathBuf> {
    let folder =
        std::env::var_os("TERRA_DATA").map_or_else(|| root().join("../shared/data"), PathBuf::from);
    let path = folder.join(file);
    if path.exists() {
        return Some(path);
    }
    println!("SKIPPED: {} is not there; set TERRA_DATA", path.display());
    None
}

/// No page has a block that no test below reads.
#[test]
fn every_page_with_a_block_is_followed() {
    let followed = [
        "bevameter",
        "campaigns",
        "drive-log",
        "embedding",
        "estimators",
        "formats",
        "gap",
        "identifiability",
        "new-effect",
        "new-filter",
        "new-model",
        "paper",
        "python",
        "reports",
        "rig-log",
        "watch",
        "wheel",
    ];
    let mut found = vec![];
    for part in ["", "models", "effects"] {
        for entry in fs::read_dir(root().join("book/src").join(part)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|e| e != "md") {
                continue;
            }
            let page = path.strip_prefix(root()).unwrap().to_str().unwrap();
            let languages: Vec<_> = blocks(page).into_iter().map(|b| b.language).collect();
            if part.is_empty() && !languages.is_empty() {
                found.push(path.file_stem().unwrap().to_str().unwrap().to_owned());
            }
            // Pages made from the registry hold equations, nothing to run.
            let equations = languages.iter().all(|l| l == "text");
            assert!(part.is_empty() || equations, "{page}: {languages:?}");
        }
    }
    found.sort();
    assert_eq!(found, followed);
}

#[test]
fn readme() {
    let at = place("readme");
    copy(&logs().join("drive.csv"), &at.join("drive.csv"));
    let first = ["cargo run --release -- demo", "cargo test --workspace"];
    follow("README.md", &at, &[], &first);
    let demo = terra(&at, "demo --figures figures").ok().out;
    shows("README.md", &block("README.md", "text", 0), &demo);
    let table = fs::read_to_string(root().join("README.md")).unwrap();
    let row = format!("{}, from 6 published points", closing(&demo));
    assert!(table.contains(&row), "README.md has no `{row}`");
}

#[test]
fn bevameter() {
    let at = place("bevameter");
    let mut plates = "test,plate_diameter_m,sinkage_m,pressure_Pa\n".to_owned();
    for diameter in [0.06, 0.10] {
        for mm in 1..=40 {
            let z = f64::from(mm) * 1e-3;
            let p = (30e3 / (0.5 * diameter) + 1.2e6) * z.powf(0.9);
            plates += &format!("d{diameter},{diameter},{z},{p}\n");
        }
    }
    fs::write(at.join("plates.csv"), plates).unwrap();
    let mut shear = "test,normal_stress_Pa,shear_displacement_m,shear_stress_Pa\n".to_owned();
    for normal in [5e3f64, 10e3, 20e3] {
        for mm in 1..=40 {
            let j = f64::from(mm) * 1e-3;
            let t = (1e3 + normal * 0.55f64.tan()) * -(-j / 0.01).exp_m1();
            shear += &format!("n{normal},{normal},{j},{t}\n");
        }
    }
    fs::write(at.join("shear.csv"), shear).unwrap();
    let done = follow("book/src/bevameter.md", &at, &[], &[]);
    assert!(done[0].out.contains("bekker") && done[1].out.contains("janosi-hanamoto"));
    assert!(at.join("soil.json").exists() && at.join("soil.html").exists());
}

/// A scheduler of one machine: each task of the array after the other.
const SBATCH: &str = r#"#!/bin/sh
set -eu
range=${1#--array=}
shift
export SLURM_ARRAY_TASK_MIN=${range%-*} SLURM_ARRAY_TASK_MAX=${range#*-} SLURM_CPUS_PER_TASK=1
export SLURM_ARRAY_TASK_COUNT=$((SLURM_ARRAY_TASK_MAX - SLURM_ARRAY_TASK_MIN + 1))
for k in $(seq "$SLURM_ARRAY_TASK_MIN" "$SLURM_ARRAY_TASK_MAX"); do
    SLURM_ARRAY_TASK_ID=$k bash "$@"
done
"#;

/// Blind cases, a sweep and the same sweep as a Slurm array, whose bytes are those of the unsharded run.
#[test]
fn campaigns() {
    let page = "book/src/campaigns.md";
    let at = place("campaigns");
    // The plan names its scenario relative to itself.
    let work = at.join("work");
    for part in ["rig", "work/home/secret", "work/bin"] {
        fs::create_dir_all(at.join(part)).unwrap();
    }
    for file in ["rig/slip_sinkage.toml", "rig/rig.toml"] {
        copy(&example(file), &at.join(file));
    }
    copy(&example("sweep/sweep.sbatch"), &work.join("sweep.sbatch"));
    fs::write(work.join("bin/sbatch"), SBATCH).unwrap();
    fs::set_permissions(work.join("bin/sbatch"), fs::Permissions::from_mode(0o755)).unwrap();
    let plan = block(page, "toml", 0);
    let shipped = fs::read_to_string(example("sweep/plan.toml")).unwrap();
    let shipped: toml::Table = shipped.parse().unwrap();
    assert_eq!(plan.parse::<toml::Table>().unwrap(), shipped);
    fs::write(
        work.join("plan.toml"),
        plan.replace("runs = 20", "runs = 1"),
    )
    .unwrap();
    // The answers that the second line needs are what the block behind it writes.
    let line = |start: &str| commands(page).into_iter().find(|l| l.starts_with(start));
    let score = line("terra challenge score").unwrap();
    let reveal = line("terra challenge reveal").unwrap();
    let later = [
        &*score,
        &*reveal,
        "pip install \"dask[distributed]\"",
        "python examples/python/dask_sweep.py plan.toml --shards 8",
    ];
    follow(page, &work, &[("--cases 200", "--cases 1")], &later);
    for line in [score, reveal] {
        let end = shell(&work, &line);
        assert_eq!((end.code, &*end.err), (0, ""), "`{line}`");
    }
    assert_eq!(number(&json(&work.join("score.json"))["cases"]), 1.0);
    let whole = fs::read(work.join("all.jsonl")).unwrap();
    assert_eq!(fs::read(work.join("results/all.jsonl")).unwrap(), whole);
    assert_eq!(whole.iter().filter(|b| **b == b'\n').count(), 6);
}

#[test]
fn drive_log() {
    let at = place("drive_log");
    let norlab = ["terra import norlab-drive", "terra gap husky.csv"];
    let done = follow("book/src/drive-log.md", &at, &[], &norlab);
    assert!(
        done[1].out.starts_with("verdict: named {torque-scale}\n"),
        "{}",
        done[1].out
    );
}

/// The measured Husky, by a build that reads its file.
#[cfg(feature = "parquet")]
#[test]
fn the_measured_husky() {
    let Some(file) = measured("norlab_drive/husky_windows.parquet") else {
        return;
    };
    let at = place("husky");
    symlink(file, at.join("husky_windows.parquet")).unwrap();
    let made = ["terra simulate examples/drive/rich", "terra gap drive.csv"];
    let done = follow("book/src/drive-log.md", &at, &[], &made);
    assert!(
        done[1].out.contains("skid-steer-lateral-slip"),
        "{}",
        done[1].out
    );
}

/// The build and the C are the tests of `terra-capi`.
#[test]
fn embedding() {
    let at = place("embedding");
    let rover = example("paper/rover.toml");
    let log = logs().join("drive.csv");
    let line = format!(
        "identify {} --rover {} --json identify.json",
        log.display(),
        rover.display()
    );
    terra(&at, &line).ok();
    let elsewhere = [
        "cargo build --release -p terra-capi",
        "cc terra-capi",
        "./wheel",
    ];
    let done = follow("book/src/embedding.md", &at, &[], &elsewhere);
    assert_eq!(Csv::parse(&done[0].out).rows.len(), 3);
    assert_eq!(Csv::parse(&done[1].out).rows.len(), 1);
    assert!(at.join("soil.json").exists());
}

/// The plan of hypotheses: 105 perturbed soils with the 21 they stand beside, 8 clays, 200 sands.
#[test]
fn estimators() {
    let at = place("estimators");
    let plan = block("book/src/estimators.md", "toml", 0);
    fs::write(at.join("plan.toml"), plan).unwrap();
    copy(&logs().join("drive.csv"), &at.join("drive.csv"));
    copy(&example("paper/rover.toml"), &at.join("rover.toml"));
    let line = "identify drive.csv --rover rover.toml --hypotheses plan.toml --json out.json";
    assert_eq!(terra(&at, line).code, 0);
    let out = json(&at.join("out.json"));
    let soils = list(&list(&out["groups"])[0]["posterior"]).len();
    assert!(soils >= 21 + 8 + 200, "{soils}");
}

/// Readers of other formats are features of the build, and the tests of `terra-data` make a file of each; a build without
/// says how to get them.
#[test]
fn formats() {
    let page = "book/src/formats.md";
    let at = place("formats");
    let topics = block(page, "toml", 0);
    fs::write(at.join("topics.toml"), &topics).unwrap();
    let map: toml::Table = topics.parse().unwrap();
    assert!(map["columns"].as_table().unwrap().len() > 5);
    for line in commands(page) {
        if line.starts_with("cargo install") {
            continue;
        }
        let kind = line.split_whitespace().nth(2).unwrap().to_owned();
        let (built, name, first_bytes): (bool, &str, &[u8]) = match kind.as_str() {
            "mcap" => (cfg!(feature = "mcap"), "run.mcap", b"\x89MCAP0\r\n"),
            "mat" => (cfg!(feature = "mat"), "log.mat", b"MATLAB 5.0 MAT-file"),
            "parquet" => (cfg!(feature = "parquet"), "log.parquet", b"PAR1"),
            _ => panic!("{page}: nothing runs `{line}`"),
        };
        if !built {
            fs::write(at.join(name), first_bytes).unwrap();
            let end = shell(&at, &line);
            let how = format!("--features {kind}");
            assert!(end.code != 0 && end.err.contains(&how), "{}", end.err);
        }
    }
}

#[test]
fn gap() {
    let page = "book/src/gap.md";
    let at = place("gap");
    // One log of the rig in two, at a trial's end.
    let whole = fs::read_to_string(logs().join("rig.csv")).unwrap();
    let (head, rows) = whole.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    let trial = |k: usize| rows[k].split(',').next().unwrap();
    let cut = (rows.len() / 2..rows.len())
        .find(|k| trial(*k) != trial(k - 1))
        .unwrap();
    for (name, part) in [("a.csv", &rows[..cut]), ("b.csv", &rows[cut..])] {
        fs::write(at.join(name), format!("{head}\n{}\n", part.join("\n"))).unwrap();
    }
    copy(&example("rig/rig.toml"), &at.join("rig.toml"));
    copy(&example("paper/rover.toml"), &at.join("rover.toml"));
    for name in ["sim_log.csv", "real_log.csv"] {
        copy(&logs().join("drive.csv"), &at.join(name));
    }
    let smaller = [("--cases 100", "--cases 1"), ("--nulls 100", "--nulls 1")];
    let done = follow(page, &at, &smaller, &[]);
    shows(page, &block(page, "text", 0), &done[0].out);
    assert!(
        done[1].out.contains("a soil of its own for each"),
        "{}",
        done[1].out
    );
    // The simulator's own log has no gap to it; a short drive against another law leaves room for others behind `none`.
    assert!(
        done[2].out.contains("\nverdict: none {none"),
        "{}",
        done[2].out
    );
    assert!(at.join("calibration/calibration.toml").exists());
}

#[test]
fn identifiability() {
    let at = place("identifiability");
    let done = follow("book/src/identifiability.md", &at, &[], &[]);
    assert!(done[1].out.contains("lug_height"), "{}", done[1].out);
}

/// The figures are tested by the example that draws them.
#[test]
fn paper() {
    let elsewhere = ["cargo run --release --example paper_figures"];
    let at = place("paper");
    assert!(follow("book/src/paper.md", &at, &[], &elsewhere).is_empty());
}

/// Blocks of Python are run by the tests of the package; here stands that it is all the page has.
#[test]
fn python() {
    let page = "book/src/python.md";
    assert!(follow(page, &place("python"), &[], &["pip install ."]).is_empty());
    let python = blocks(page)
        .iter()
        .filter(|b| b.language == "python")
        .count();
    assert_eq!(python + 1, blocks(page).len());
}

/// The three chapters of one's own show the examples themselves, which are compiled and run with the tests.
#[test]
fn chapters_of_ones_own_include_their_examples() {
    for name in ["model", "effect", "filter"] {
        let page = format!("book/src/new-{name}.md");
        let all = blocks(&page);
        let include = format!("{{{{#include ../../examples/new_{name}.rs}}}}\n");
        assert_eq!(all.len(), 1, "{page}");
        assert_eq!(
            (&*all[0].language, &*all[0].text),
            ("rust,ignore", &*include)
        );
        let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
        assert!(manifest.contains(&format!("name = \"new_{name}\"\ntest = true")));
    }
}

#[test]
fn reports() {
    let page = "book/src/reports.md";
    let at = place("reports");
    copy(&logs().join("drive.csv"), &at.join("drive.csv"));
    copy(&example("paper/rover.toml"), &at.join("rover.toml"));
    follow(page, &at, &[], &[]);
    for name in ["wheel.csv", "wheel.html", "forces.csv", "forces.html"] {
        assert!(at.join(name).exists(), "{name}");
    }
    // The numbers of a figure, as the page shows them: those of the demo.
    terra(&at, "demo --figures demo").ok();
    let shown = block(page, "text", 0);
    let figure = fs::read_to_string(at.join("demo/drawbar-pull-n.csv")).unwrap();
    assert_eq!(shown.lines().next(), figure.lines().next());
}

#[test]
fn rig_log() {
    let Some(file) = measured("cmu_single_wheel/smooth_straight.csv") else {
        return;
    };
    let page = "book/src/rig-log.md";
    let at = place("rig_log");
    symlink(file, at.join("smooth_straight.csv")).unwrap();
    let done = follow(page, &at, &[], &[]);
    shows(page, &block(page, "text", 0), &done[0].out);
    // The figure of the README's table.
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let held = closing(&done[0].out);
    assert!(readme.contains(&held), "README.md has no `{held}`");
}

/// "65 % [62, 68]" of "held out by slip: 65 % of the gap closes (95 %: 62 to 68 %)".
fn closing(said: &str) -> String {
    let held = said.lines().find(|l| l.starts_with("held out")).unwrap();
    let numbers: Vec<&str> = held
        .split(|c: char| !c.is_ascii_digit())
        .filter(|n| !n.is_empty())
        .collect();
    let [closes, _, lo, hi] = numbers[..] else {
        panic!("{held}");
    };
    format!("{closes} % [{lo}, {hi}]")
}

#[test]
fn watch() {
    let page = "book/src/watch.md";
    let at = place("watch");
    for name in ["patrol.toml", "rover.toml"] {
        copy(&example(&format!("drive/{name}")), &at.join(name));
    }
    let done = follow(page, &at, &[], &[]);
    shows(page, &block(page, "text", 0), &done[1].out);
    assert_eq!(text(&json(&at.join("watch.json"))["verdict"]), "gap");
    assert!(!Csv::read(&at.join("track.csv")).rows.is_empty());
    // The loop in a program, which is the documentation of the type.
    assert_eq!(blocks(page).len(), 3);
}

/// The curve, and a soil of one's own by the row that the page shows.
#[test]
fn wheel() {
    let page = "book/src/wheel.md";
    let at = place("wheel");
    let done = follow(page, &at, &[], &[]);
    assert!(done.iter().all(|d| !Csv::parse(&d.out).rows.is_empty()));
    fs::write(at.join("own.csv"), block(page, "csv", 0)).unwrap();
    let line = "wheel --terrain bench --catalogue own.csv --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.4";
    assert_eq!(Csv::parse(&terra(&at, line).ok().out).rows.len(), 1);
}
