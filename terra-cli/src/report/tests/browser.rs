//! Pages in a real browser, where there is one: nothing on its console, nothing asked of a network, and figures that
//! answer. `CHROMIUM` names the program; without any the tests say so and pass.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::{every_section, page};

const LIMIT: Duration = Duration::from_secs(120);

fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("CHROMIUM") {
        return Some(named.into());
    }
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    std::env::split_paths(&path)
        .flat_map(|folder| names.map(|n| folder.join(n)))
        .find(|file| file.is_file())
}

#[allow(clippy::print_stderr)] // Somebody who runs the tests must see what was not tested.
fn skipped() {
    eprintln!("skipped: no Chromium in PATH, and CHROMIUM is not set");
}

/// What the page is after its script ran, and what the browser logged.
fn rendered(program: &Path, folder: &Path, html: &str) -> (String, String) {
    let file = folder.join("page.html");
    std::fs::write(&file, html).unwrap();
    // To files: a full pipe would stop the browser.
    let (dom, log) = (folder.join("dom"), folder.join("log"));
    let mut child = Command::new(program)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--disable-background-networking",
            "--host-resolver-rules=MAP * ~NOTFOUND",
            "--enable-logging=stderr",
            "--dump-dom",
        ])
        .arg(format!("--user-data-dir={}", folder.join("user").display()))
        .arg(format!("file://{}", file.display()))
        .stdin(Stdio::null())
        .stdout(std::fs::File::create(&dom).unwrap())
        .stderr(std::fs::File::create(&log).unwrap())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > LIMIT {
            let _ = child.kill();
            panic!("{} does not end", program.display());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let read = |p: &Path| String::from_utf8_lossy(&std::fs::read(p).unwrap()).into_owned();
    (read(&dom), read(&log))
}

#[test]
fn every_kind_of_section_runs_without_a_word_on_the_console() {
    let Some(program) = browser() else {
        return skipped();
    };
    let folder = tempfile::tempdir().unwrap();
    let html = page(every_section());
    let (dom, log) = rendered(&program, folder.path(), &html);
    let console: Vec<&str> = log.lines().filter(|l| l.contains("CONSOLE")).collect();
    assert!(console.is_empty(), "{console:?}");
    // The content policy let the script run: each panel has its buttons.
    let panels = html.matches("class=\"numbers\"").count();
    assert_eq!(dom.matches("class=\"tools\"").count(), panels);
    assert!(panels > 10);
}

#[test]
fn a_figure_answers_keys_pointer_and_buttons() {
    let Some(program) = browser() else {
        return skipped();
    };
    let folder = tempfile::tempdir().unwrap();
    let mut view = super::tests::identification();
    // Its forces come first: points with error bars over a line with a band.
    view.groups[0].probability.clear();
    view.groups[0].parameters.clear();
    let html = page(vec![super::identify_section(&view)]);
    // The page's own policy lets no second script run, so it is taken out for the one that drives.
    let policy = html
        .find("<meta http-equiv=\"Content-Security-Policy\"")
        .unwrap();
    let end = policy + html[policy..].find('>').unwrap() + 1;
    let driven = format!("{}{}", &html[..policy], &html[end..]).replace(
        "</body>",
        &format!("<script>{}</script></body>", include_str!("browser.js")),
    );
    let (dom, log) = rendered(&program, folder.path(), &driven);
    assert!(!log.contains("CONSOLE"), "{log}");
    let (_, seen) = dom.split_once("<pre id=\"seen\">").unwrap();
    let seen = seen.split("</pre>").next().unwrap();
    let seen = seen
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&nbsp;", "\u{a0}")
        .replace("&amp;", "&");
    let seen: serde_json::Value = serde_json::from_str(&seen).unwrap();
    assert_eq!(seen["errors"].as_array().unwrap().len(), 0, "{seen}");
    // Values in order of slip, with sd and unit, and the name of the row.
    assert_eq!(
        seen["first"],
        "slip 0.1; predicted ± 1 sd: 1.00 ± 0.10\u{a0}N"
    );
    let second = seen["second"].as_str().unwrap();
    assert!(second.starts_with("slip 0.2"), "{second}");
    assert!(seen["name"].as_str().unwrap().contains("zoom"));
    assert!(seen["hover"].as_str().unwrap().contains("±"), "{seen}");
    for moved in ["zoomed", "panned", "boxed", "pinched"] {
        assert!(seen[moved].as_f64().unwrap() > 5.0, "{moved}");
    }
    assert_ne!(seen["zoomed"], seen["panned"]);
    assert_ne!(seen["pinched"], seen["pinchMoved"]);
    for yes in [
        "zoomedTicks",
        "back",
        "backAgain",
        "pinchKept",
        "pinchTicks",
        "oneScrolls",
    ] {
        assert_eq!(seen[yes], true, "{yes}");
    }
    assert_eq!(seen["hidden"].as_array().unwrap().len(), 1);
    let files = super::Page {
        sections: vec![super::identify_section(&view)],
        ..super::Page::default()
    }
    .figures();
    // The buttons save, to the byte, what `--figures` writes; a picture of pixels beside it.
    let first = &files[0];
    let saved = |ending: &str| seen["saved"][format!("{}.{ending}", first.name)].clone();
    assert_eq!(saved("csv"), first.csv);
    assert_eq!(saved("png"), "PNG of true");
    let svg = saved("svg");
    let document = roxmltree::Document::parse(svg.as_str().unwrap()).unwrap();
    let ours = roxmltree::Document::parse(&first.svg).unwrap();
    assert_eq!(document.descendants().count(), ours.descendants().count());
    for (theirs, own) in document.descendants().zip(ours.descendants()) {
        assert_eq!(theirs.tag_name(), own.tag_name());
        for a in own.attributes() {
            assert_eq!(theirs.attribute(a.name()), Some(a.value()), "{}", a.name());
        }
    }
}
