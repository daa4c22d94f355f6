//! The header is what the sources say, and C gets the numbers that Rust gets.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stderr)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use terra_model::{Contact, ForceLaw, Registry, catalogue};

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// `TERRA_BLESS=1` writes the header.
#[test]
fn the_header_is_what_the_sources_say() {
    let mut made = vec![];
    cbindgen::Builder::new()
        .with_src(here("src/status.rs"))
        .with_src(here("src/law.rs"))
        .with_src(here("src/pointer.rs"))
        .with_config(cbindgen::Config::from_file(here("cbindgen.toml")).unwrap())
        .generate()
        .unwrap()
        .write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let header = here("include/terra.h");
    if std::env::var_os("TERRA_BLESS").is_some() {
        fs::write(&header, &made).unwrap();
    }
    let committed = fs::read_to_string(&header).unwrap();
    assert!(
        committed.replace("\r\n", "\n") == made,
        "include/terra.h is not what the sources say: run this test with TERRA_BLESS=1"
    );
}

/// Where cargo puts the shared library that the tests are built beside.
fn libraries() -> PathBuf {
    std::env::current_exe()
        .unwrap()
        .parent()
        .unwrap()
        .to_owned()
}

#[test]
#[cfg(unix)]
fn the_example_in_c_gets_the_numbers_of_rust() {
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    if Command::new(&compiler).arg("--version").output().is_err() {
        eprintln!("SKIPPED: no C compiler ({compiler})");
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (program, libraries) = (folder.join("wheel"), libraries());
    let built = Command::new(&compiler)
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"])
        .arg(here("examples/wheel.c"))
        .arg("-I")
        .arg(here("include"))
        .arg("-L")
        .arg(&libraries)
        .arg(format!("-Wl,-rpath,{}", libraries.display()))
        .args(["-lterra_capi", "-o"])
        .arg(&program)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.success(), "{said}");
    assert_eq!(said, "");

    let ran = Command::new(&program).output().unwrap();
    let said = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.success(), "{said}");
    assert!(
        said.contains("'wong-rece'") && said.contains("'wong-reece'"),
        "{said}"
    );

    let law = Registry::builtin().law("wong-reece+slip-sinkage").unwrap();
    let mut p = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    p.push(0.3);
    let out = String::from_utf8(ran.stdout).unwrap();
    let mut lines = out.lines();
    assert_eq!(
        lines.next(),
        Some("slip,drawbar_pull_N,torque_N_m,sinkage_m")
    );
    let mut rows = 0;
    for line in lines {
        let row: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        let f = law
            .forces(&p, &Contact::new(row[0], 245.25, 0.254, 0.15))
            .unwrap();
        // Seventeen digits read back to the same bits.
        assert_eq!(
            row[1..],
            [f.drawbar_pull, f.resistive_torque, f.sinkage.unwrap()]
        );
        rows += 1;
    }
    assert_eq!(rows, 9);
}
