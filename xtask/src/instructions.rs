//! `cargo xtask bench`: instructions per operation, counted by callgrind, against the committed counts.
//!
//! Wall-clock time of a shared machine says little and is never a gate; an instruction count is the same on every run.
//! Each kernel runs twice with different repetitions and the counts are subtracted, so start-up and checks cancel.

use std::fs;
use std::path::{Path, PathBuf};

use crate::counts::{Standing, compare, read};
use crate::fit::{Line, line};
use crate::shell::{cargo, command, installed, output, root, run as run_command};

/// A kernel of `terra-bench/src/bin/count.rs`, with the repetitions of the short and the long run.
struct Kernel {
    name: &'static str,
    short: usize,
    long: usize,
    what: &'static str,
}

const fn kernel(name: &'static str, short: usize, long: usize, what: &'static str) -> Kernel {
    Kernel {
        name,
        short,
        long,
        what,
    }
}

const KERNELS: &[Kernel] = &[
    kernel("forward-solve", 10, 30, "cold forward solve, driving"),
    kernel(
        "forward-solve-braking",
        10,
        30,
        "cold forward solve, braking",
    ),
    kernel("forward-solve-warm", 10, 30, "forward solve from 1 % off"),
    kernel("batch-f64", 4, 12, "forward solve in a batch, 1e-7"),
    kernel("batch-f32", 4, 12, "forward solve in a batch, 1e-5"),
    kernel("map", 400, 1200, "look-up of pull and torque, 1e-4"),
    kernel("jacobian", 2, 6, "forces with 10 derivatives"),
    kernel("drive", 1, 3, "2 s of four wheels, 1e-6"),
    kernel("drive-log", 1, 3, "the same with load transfer and sensors"),
    kernel("filter-lanes", 200, 600, "filter step, mean and covariance"),
    kernel(
        "filter-lanes-scored",
        200,
        600,
        "filter step, with NIS and likelihood",
    ),
    kernel(
        "filter-lanes-belief",
        200,
        600,
        "filter step, in one matrix",
    ),
    kernel("filter-block", 200, 600, "filter step, block"),
    kernel(
        "filter-block-robust",
        200,
        600,
        "filter step, block with robust update",
    ),
    kernel("filter-kf", 200, 600, "filter step, dense"),
    kernel("filter-ekf", 200, 400, "filter step, extended"),
    kernel("hypothesis-update:21", 1000, 3000, "Bayes step, N = 21"),
    kernel("hypothesis-update:1000", 100, 300, "Bayes step, N = 1 000"),
    kernel("hypothesis-update:10000", 10, 30, "Bayes step, N = 10 000"),
    kernel("hypothesis-update:100000", 2, 6, "Bayes step, N = 100 000"),
    // Whole rounds of the log, so that what a first round tabulates is in neither run alone.
    kernel("fused-wheel:21", 64, 192, "fused pass on a wheel, N = 21"),
    kernel(
        "fused-wheel:1000",
        64,
        192,
        "fused pass on a wheel, N = 1 000",
    ),
    kernel(
        "fused-wheel:4000",
        64,
        192,
        "fused pass on a wheel, N = 4 000",
    ),
    kernel("fused-held:21", 64, 192, "the same, S held, N = 21"),
    kernel("fused-held:1000", 64, 192, "the same, S held, N = 1 000"),
    kernel("fused-held:4000", 64, 192, "the same, S held, N = 4 000"),
    kernel("fused-held:1024", 64, 192, "the same, S held, N = 1 024"),
    kernel("fused-held:2048", 64, 192, "the same, S held, N = 2 048"),
    kernel("fused-held:4096", 64, 192, "the same, S held, N = 4 096"),
    kernel(
        "fused-held-mean:21",
        64,
        192,
        "the same, mean of 8 parameters, N = 21",
    ),
    kernel(
        "fused-held-mean:1000",
        64,
        192,
        "the same, mean of 8 parameters, N = 1 000",
    ),
    kernel(
        "fused-held-mean:4000",
        64,
        192,
        "the same, mean of 8 parameters, N = 4 000",
    ),
    kernel("hand-wheel:21", 64, 192, "the same by hand, N = 21"),
    kernel("hand-wheel:1000", 64, 192, "the same by hand, N = 1 000"),
    kernel("hand-wheel:4000", 64, 192, "the same by hand, N = 4 000"),
    kernel(
        "hand-wheel-mean:21",
        64,
        192,
        "by hand, mean of 8 parameters, N = 21",
    ),
    kernel(
        "hand-wheel-mean:1000",
        64,
        192,
        "by hand, mean of 8 parameters, N = 1 000",
    ),
    kernel(
        "hand-wheel-mean:4000",
        64,
        192,
        "by hand, mean of 8 parameters, N = 4 000",
    ),
    kernel(
        "fused-moving:4000",
        64,
        192,
        "the same under a load that changes, N = 4 000",
    ),
    kernel("fused:21", 64, 192, "fused pass on a side, N = 21"),
    kernel("fused:1000", 64, 192, "fused pass on a side, N = 1 000"),
    kernel("fused:4000", 64, 192, "fused pass on a side, N = 4 000"),
    kernel(
        "fused-block:4000",
        4,
        12,
        "fused pass of 16 samples, a sample, N = 4 000",
    ),
];

/// Kernels `NAME:N` whose line in N is printed, what they are, and, where it must be straight, the step of the N that count: a
/// fused pass goes over whole runs of 1 024 hypotheses, and what is left of one costs more a hypothesis.
const LINEAR: [(&str, &str, Option<u32>); 7] = [
    ("hypothesis-update", "Bayes step", Some(1)),
    ("fused-wheel", "fused pass on a wheel", None),
    ("fused-held", "fused pass on a wheel, S held", Some(1024)),
    (
        "fused-held-mean",
        "fused pass on a wheel, S held, with mean",
        None,
    ),
    ("hand-wheel", "the same by hand", None),
    ("hand-wheel-mean", "the same by hand, with mean", None),
    ("fused", "fused pass on a side", None),
];

/// Least R² at which a kernel counts as O(N).
const STRAIGHT: f64 = 0.999_999;

/// Fixed target CPUs, the default first: `native` would differ from machine to machine, and valgrind knows no AVX-512.
/// The default is what a plain release build gives.
const CPUS: [&str; 2] = ["x86-64-v3", "x86-64"];

pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    let cpu = match arguments {
        [] => CPUS[0],
        [flag, cpu] if flag == "--cpu" => CPUS
            .into_iter()
            .find(|known| known == cpu)
            .ok_or_else(|| format!("no target CPU '{cpu}'; known: {}", CPUS.join(", ")))?,
        _ => return Err("usage: cargo xtask bench [--cpu x86-64|x86-64-v3]".to_owned()),
    };
    if !installed("valgrind") {
        println!("skipped: valgrind is not installed");
        return Ok(());
    }
    if cfg!(not(target_arch = "x86_64")) {
        println!("skipped: counts are committed for x86-64 only");
        return Ok(());
    }
    let binary = build(cpu)?;
    let file = root().join("terra-bench/counts.toml");
    let text = fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
    let committed = read(&text, cpu)?;
    let bounds = read(&text, &format!("{cpu} at most"))?;
    if let Some(unknown) = bounds.keys().find(|&b| KERNELS.iter().all(|k| k.name != b)) {
        return Err(format!(
            "counts.toml bounds `{unknown}`, which is no kernel"
        ));
    }

    println!(
        "instructions per operation, release, target-cpu {cpu}, {}",
        versions()
    );
    println!(
        "{:<26} {:>12} {:>12} {:>8} {:>9}",
        "kernel", "found", "committed", "change", "at most"
    );
    let mut failed = vec![];
    let mut beyond = vec![];
    let mut fresh = vec![];
    let mut points = LINEAR.map(|_| vec![]);
    for kernel in KERNELS {
        let found = count(&binary, kernel)?;
        let before = committed.get(kernel.name).copied();
        let change = before.map_or_else(String::new, |c| {
            format!("{:+.2} %", 100.0 * (found / c - 1.0))
        });
        let shown = before.map_or_else(|| "none".to_owned(), |c| format!("{c:.1}"));
        let bound = bounds.get(kernel.name).copied();
        let most = bound.map_or_else(String::new, |b| format!("{b:.0}"));
        println!(
            "{:<26} {found:>12.1} {shown:>12} {change:>8} {most:>9}  {}",
            kernel.name, kernel.what
        );
        if bound.is_some_and(|most| found > most) {
            beyond.push(kernel.name);
        }
        let standing = compare(found, before);
        if standing == Standing::More {
            failed.push(kernel.name);
        }
        if standing != Standing::Same {
            fresh.push(format!("\"{}\" = {found:.1}", kernel.name));
        }
        for ((name, ..), points) in LINEAR.iter().zip(&mut points) {
            points.extend(size(name, kernel.name).map(|n| (n, found)));
        }
    }
    let mut bent = vec![];
    for ((_, what, step), points) in LINEAR.iter().zip(&mut points) {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        linear(what, points);
        if let Some(step) = step {
            points.retain(|(n, _)| n % f64::from(*step) == 0.0);
            bent.extend(straight(what, points, *step).err());
        }
    }
    if !bent.is_empty() {
        return Err(bent.join("\n"));
    }
    if !fresh.is_empty() {
        println!(
            "\nlines for [\"{cpu}\"] of terra-bench/counts.toml:\n{}",
            fresh.join("\n")
        );
    }
    verdict(&failed, &beyond)
}

/// Both checks at once, so that one run says all there is to mend.
fn verdict(failed: &[&str], beyond: &[&str]) -> Result<(), String> {
    let mut said = vec![];
    if !failed.is_empty() {
        said.push(format!(
            "more than 2 % above the committed count: {}\nmake it cheaper, or commit the new count with the reason beside it",
            failed.join(", ")
        ));
    }
    if !beyond.is_empty() {
        said.push(format!(
            "above its bound, which no new count moves: {}",
            beyond.join(", ")
        ));
    }
    if said.is_empty() {
        Ok(())
    } else {
        Err(said.join("\n"))
    }
}

/// Prints a kernel per hypothesis and its line.
fn linear(what: &str, points: &[(f64, f64)]) {
    let fit = line(points);
    println!("\n{what}, instructions = a + b N");
    for &(n, found) in points {
        let fitted = fit.intercept + fit.slope * n;
        println!(
            "  N = {n:>6}: {:>8.2} a hypothesis; line {fitted:>11.1}, found {found:>11.1}",
            found / n
        );
    }
    print_line(&fit);
}

fn print_line(fit: &Line) {
    println!(
        "  a = {:.1}, b = {:.4}, R² = {:.9}",
        fit.intercept, fit.slope, fit.determination
    );
}

/// Prints the line through the sizes that are multiples of `step`; an error where it is not straight.
fn straight(what: &str, points: &[(f64, f64)], step: u32) -> Result<(), String> {
    let fit = line(points);
    if step > 1 {
        println!("  of {} sizes in whole steps of {step}:", points.len());
        print_line(&fit);
    }
    if points.len() > 2 && fit.determination > STRAIGHT {
        return Ok(());
    }
    Err(format!(
        "the {what} is not linear in N: R² = {} over {} sizes",
        fit.determination,
        points.len()
    ))
}

/// N of `NAME:N`.
fn size(name: &str, kernel: &str) -> Option<f64> {
    let (own, n) = kernel.split_once(':')?;
    (own == name).then(|| n.parse().ok())?
}

/// Builds `count` into a target folder of its own: other flags than the rest of the work.
fn build(cpu: &str) -> Result<PathBuf, String> {
    let target = root().join("target").join("count").join(cpu);
    let mut build = cargo(&["build", "--release", "-p", "terra-bench", "--bin", "count"]);
    build.env("CARGO_TARGET_DIR", &target);
    build.env("RUSTFLAGS", format!("-C target-cpu={cpu}"));
    run_command(&mut build)?;
    Ok(target.join("release").join("count"))
}

/// What a count depends on besides the code.
fn versions() -> String {
    let of = |program: &str| output(&mut command(program, &["--version"])).unwrap_or_default();
    let cpuinfo = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpuinfo.lines().find(|l| l.starts_with("model name"));
    let processor = model
        .and_then(|l| l.split(':').nth(1))
        .unwrap_or("unknown processor");
    format!(
        "{}, {}, {}",
        of("rustc").trim(),
        of("valgrind").trim(),
        processor.trim()
    )
}

/// Instructions per operation of a kernel.
fn count(binary: &Path, kernel: &Kernel) -> Result<f64, String> {
    let (short, short_operations) = callgrind(binary, kernel.name, kernel.short)?;
    let (long, long_operations) = callgrind(binary, kernel.name, kernel.long)?;
    Ok((long - short) / (long_operations - short_operations))
}

/// Instructions and operations of one run.
fn callgrind(binary: &Path, kernel: &str, repetitions: usize) -> Result<(f64, f64), String> {
    let out = binary.with_file_name(format!("callgrind.{}", std::process::id()));
    let mut valgrind = command(
        "valgrind",
        &[
            "--tool=callgrind",
            &format!("--callgrind-out-file={}", out.display()),
        ],
    );
    valgrind
        .arg(binary)
        .args([kernel, &repetitions.to_string()]);
    let printed = output(&mut valgrind).map_err(|e| match e.contains("nrecognised instruction") {
        true => format!("{e}\nthis valgrind does not know an instruction of the target CPU: take a newer one, or --cpu {}", CPUS[1]),
        false => e,
    })?;
    let report = fs::read_to_string(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    // Left in the target folder where it cannot be removed; nothing depends on it.
    let _ = fs::remove_file(&out);
    let operations = printed
        .trim()
        .parse()
        .map_err(|_| format!("{kernel} printed `{printed}`"))?;
    let total = total(&report).ok_or_else(|| format!("callgrind gave no total for {kernel}"))?;
    Ok((total, operations))
}

/// The line `totals: N` of a callgrind file.
fn total(report: &str) -> Option<f64> {
    report
        .lines()
        .find_map(|l| l.strip_prefix("totals:"))?
        .trim()
        .parse()
        .ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_of_a_callgrind_file_is_read() {
        let report = "version: 1\nevents: Ir\n\nfn=(1) main\n5 100\n\ntotals: 123456\n";
        assert_eq!(total(report), Some(123_456.0));
        assert_eq!(total("events: Ir\n"), None);
    }

    #[test]
    fn a_bound_fails_beside_a_committed_count() {
        assert_eq!(verdict(&[], &[]), Ok(()));
        let said = verdict(&["map"], &["batch-f64"]).expect_err("both failed");
        assert!(
            said.contains("2 % above the committed count: map"),
            "{said}"
        );
        assert!(
            said.contains("above its bound, which no new count moves: batch-f64"),
            "{said}"
        );
        assert!(verdict(&[], &["batch-f32"]).is_err());
    }

    /// The committed file itself: each bound is of a kernel, and its committed count keeps it.
    #[test]
    fn committed_counts_keep_their_bounds() {
        let text =
            fs::read_to_string(root().join("terra-bench/counts.toml")).expect("the committed file");
        let (counts, bounds) = (
            read(&text, "x86-64-v3").expect("counts"),
            read(&text, "x86-64-v3 at most").expect("bounds"),
        );
        assert!(!bounds.is_empty());
        for (kernel, most) in bounds {
            assert!(
                counts[&kernel] <= most,
                "{kernel}: {} > {most}",
                counts[&kernel]
            );
        }
    }

    #[test]
    fn every_size_of_the_line_is_a_kernel() {
        let sizes =
            |name| -> Vec<f64> { KERNELS.iter().filter_map(|k| size(name, k.name)).collect() };
        assert_eq!(sizes("hypothesis-update"), [21.0, 1e3, 1e4, 1e5]);
        for fused in ["fused-wheel", "fused"] {
            assert_eq!(sizes(fused), [21.0, 1e3, 4e3]);
        }
        for (name, ..) in LINEAR {
            assert!(
                sizes(name).len() >= 3,
                "{name}: a line through fewer says nothing"
            );
        }
        assert!(KERNELS.iter().all(|k| k.short < k.long));
    }
}
