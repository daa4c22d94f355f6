//! `terra init`: files that the other commands take, and none that is overwritten unasked.

use std::fs;

use crate::support::{folder, logs, terra};

#[test]
fn every_class_is_written_and_taken() {
    let to = folder("init");
    for class in ["husky", "jackal", "paper-robot", "single-wheel-rig"] {
        terra(&to, &format!("init {class} --out {class}.toml")).ok();
        terra(&to, &format!("cite {class}.toml")).ok();
        let log = if class.ends_with("rig") {
            "rig.csv"
        } else {
            "drive.csv"
        };
        let log = logs().join(log);
        let done = terra(
            &to,
            &format!("inspect {} --rover {class}.toml", log.display()),
        );
        assert_eq!(done.code, 0, "{class}: {}", done.err);
    }
    let done = terra(&to, "init husky").ok();
    assert!(done.out.starts_with("rover.toml: "), "{}", done.out);
    assert!(done.out.contains("estimate"), "{}", done.out);
}

#[test]
fn nothing_is_overwritten_unasked() {
    let to = folder("init_again");
    fs::write(to.join("rover.toml"), "mine").unwrap();
    let done = terra(&to, "init jackal");
    assert_eq!(done.code, 4);
    assert!(
        done.err.contains("rover.toml") && done.err.contains("--force"),
        "{}",
        done.err
    );
    assert_eq!(fs::read_to_string(to.join("rover.toml")).unwrap(), "mine");
    terra(&to, "init jackal --force").ok();
    assert!(
        fs::read_to_string(to.join("rover.toml"))
            .unwrap()
            .contains("[vehicle]")
    );
    assert_eq!(terra(&to, "init jackal --out no_such/rover.toml").code, 4);
    assert_eq!(terra(&to, "init tricycle").code, 2);
}
