//! What an effect says of itself is what its documentation says.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use terra_model::Registry;

/// What stands under `# Equation` in every file of a folder, up to the next heading, each as one line.
fn documented(folder: &Path, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            documented(&path, found);
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let comment = |line: &str| {
            let line = line.trim_start();
            let text = line.strip_prefix("//!").or(line.strip_prefix("///"))?;
            Some(text.trim().to_owned())
        };
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            if comment(line).as_deref() == Some("# Equation") {
                let paragraph: Vec<String> = lines
                    .by_ref()
                    .map_while(|l| comment(l).filter(|t| !t.starts_with("# ")))
                    .filter(|t| !t.is_empty())
                    .collect();
                found.push(paragraph.join(" ").replace("\\[", "[").replace("\\]", "]"));
            }
        }
    }
}

/// As documented, however it is broken into lines.
fn in_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn every_model_gives_the_equations_of_its_documentation() {
    let mut found = vec![];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/models");
    documented(&folder, &mut found);
    let registry = Registry::builtin();
    for model in registry.models().iter().chain(registry.named_models()) {
        for paragraph in model.equation().split("\n\n") {
            // A list is several lines of one paragraph.
            let said = in_one_line(paragraph);
            assert!(
                !said.is_empty() && found.iter().any(|f| in_one_line(f).contains(&said)),
                "{}: '{said}' is no documented equation",
                model.name()
            );
        }
    }
}

#[test]
fn every_form_of_every_effect_gives_the_equation_of_its_documentation() {
    let mut found = vec![];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/effects");
    documented(&folder, &mut found);
    let registry = Registry::builtin().with_forms();
    assert!(registry.effects().len() > 50);
    for effect in registry.effects() {
        let said = effect.equation();
        assert!(
            !said.is_empty() && found.iter().any(|f| f == said),
            "{}/{}: '{said}' is no documented equation",
            effect.name(),
            effect.form()
        );
    }
}
