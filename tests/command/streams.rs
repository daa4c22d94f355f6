//! Pipes, full disks, odd names: what the world around the command does to it.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::Stdio;

use crate::support::{contents, finish, folder, logs, run, terra, terra_in};

/// A reader that has seen enough goes away in the middle of a long table: no error, no words.
#[test]
fn a_broken_pipe_is_no_error() {
    let wheel = "wheel --terrain dry_sand --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.05:0.95:0.0005";
    for line in [
        wheel,
        "terrains",
        "effects --json",
        "completions bash",
        "--help",
    ] {
        let mut child = terra_in(logs())
            .args(line.split_whitespace())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut first = String::new();
        BufReader::with_capacity(16, child.stdout.take().unwrap())
            .read_line(&mut first)
            .unwrap();
        assert!(!first.is_empty(), "{line}");
        let mut said = String::new();
        child
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut said)
            .unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0), "{line}: {said}");
        assert_eq!(said, "", "{line}");
    }
}

/// A full disk is an error of writing, for a file and for standard output.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_of_writing() {
    let wheel = "wheel --terrain dry_sand --radius_m 0.254 --width_m 0.15 --load_N 245.25 --slip 0.05:0.95:0.05";
    for line in [
        "simulate ramp.toml --out /dev/full",
        "estimate drive.csv --rover rover.toml --out /dev/full",
        "identify rig.csv --rover rig.toml --json /dev/full",
        "identify rig.csv --rover rig.toml --html /dev/full",
        &format!("{wheel} --csv /dev/full"),
    ] {
        let done = terra(logs(), line);
        assert_eq!(done.code, 4, "{line}: {}", done.err);
        assert!(
            done.err.contains("/dev/full") && done.err.contains("No space left"),
            "{line}: {}",
            done.err
        );
    }
    for line in [
        wheel,
        "terrains",
        "models --json",
        "estimate drive.csv --rover rover.toml",
        "completions zsh",
    ] {
        let full = fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let done = finish(terra_in(logs()).args(line.split_whitespace()).stdout(full));
        assert_eq!(done.code, 4, "{line}: {}", done.err);
        assert!(done.err.contains("standard output"), "{line}: {}", done.err);
    }
}

/// Names that are no text work as names of files, and are refused politely as names of anything else.
#[cfg(unix)]
#[test]
fn names_that_are_no_text() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = folder("odd_names");
    let odd = |name: &'static [u8]| OsStr::from_bytes(name);
    for (from, to) in [
        ("drive.csv", odd(b"dr\xffive.csv")),
        ("rover.toml", odd(b"\xfe.toml")),
    ] {
        if let Err(e) = fs::copy(logs().join(from), folder.join(to)) {
            println!("SKIPPED: this file system has no such names: {e}");
            return;
        }
    }
    let (log, rover, out) = (
        odd(b"dr\xffive.csv"),
        odd(b"\xfe.toml"),
        odd(b"out\xff.csv"),
    );
    let word = OsStr::new;
    run(
        &folder,
        [
            word("estimate"),
            log,
            word("--rover"),
            rover,
            word("--out"),
            out,
        ],
    )
    .ok();
    assert_eq!(
        fs::read(folder.join(out))
            .unwrap()
            .iter()
            .filter(|b| **b == b'\n')
            .count(),
        201
    );
    let done = run(
        &folder,
        [word("estimate"), odd(b"no\xff.csv"), word("--rover"), rover],
    );
    assert_eq!(done.code, 3, "{}", done.err);
    assert!(done.err.contains("no such file"), "{}", done.err);
    let done = run(
        &folder,
        [
            word("estimate"),
            log,
            word("--rover"),
            rover,
            word("--filter"),
            odd(b"ek\xff"),
        ],
    );
    assert_eq!(done.code, 2, "{}", done.err);
    assert_eq!(run(&folder, [odd(b"\xff\xff")]).code, 2);
}

/// What may not be read or written says so. Nothing is forbidden to root, so there is nothing to see then.
#[cfg(unix)]
#[test]
fn forbidden_files_and_folders() {
    use std::os::unix::fs::PermissionsExt;
    let forbid = |path: &Path, mode: u32| {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap()
    };
    let folder = folder("forbidden");
    for name in ["drive.csv", "rover.toml"] {
        fs::copy(logs().join(name), folder.join(name)).unwrap();
    }
    fs::create_dir(folder.join("locked")).unwrap();
    fs::copy(logs().join("drive.csv"), folder.join("secret.csv")).unwrap();
    forbid(&folder.join("secret.csv"), 0o000);
    forbid(&folder.join("locked"), 0o500);
    if fs::File::open(folder.join("secret.csv")).is_ok() {
        println!("SKIPPED: nothing is forbidden to this user");
    } else {
        let done = terra(&folder, "estimate secret.csv --rover rover.toml");
        assert_eq!(done.code, 3, "{}", done.err);
        assert!(
            done.err.contains("secret.csv") && done.err.contains("ermission"),
            "{}",
            done.err
        );
        let done = terra(
            &folder,
            "estimate drive.csv --rover rover.toml --out locked/out.csv",
        );
        assert_eq!(done.code, 4, "{}", done.err);
        assert!(contents(&folder.join("locked")).is_empty());
    }
    forbid(&folder.join("locked"), 0o700);
    forbid(&folder.join("secret.csv"), 0o600);
}

/// A log may come through a pipe, as `zcat log.csv.gz | terra estimate /dev/stdin` sends it.
#[cfg(target_os = "linux")]
#[test]
fn a_log_through_a_pipe() {
    let expected = terra(logs(), "estimate drive.csv --rover rover.toml")
        .ok()
        .out;
    let mut cat = std::process::Command::new("cat")
        .arg(logs().join("drive.csv"))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let line = ["estimate", "/dev/stdin", "--rover", "rover.toml"];
    let done = finish(
        terra_in(logs())
            .args(line)
            .stdin(cat.stdout.take().unwrap()),
    );
    cat.wait().unwrap();
    assert_eq!(done.ok().out, expected);
}
