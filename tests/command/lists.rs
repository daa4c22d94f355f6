//! What is registered, as text and as JSON; shell completions; help.

use std::fs;
use std::path::Path;

use terra::model::{Registry, catalogue};

use crate::support::{folder, list, terra, text};

fn names(command: &str, key: &str) -> Vec<String> {
    let folder = folder(&format!("list_{command}"));
    let plain = terra(&folder, command).ok().out;
    let json: serde_json::Value =
        serde_json::from_str(&terra(&folder, &format!("{command} --json")).ok().out).unwrap();
    let names: Vec<String> = list(&json)
        .iter()
        .map(|o| text(&o[key]).to_owned())
        .collect();
    for name in &names {
        assert!(
            plain.contains(name.as_str()),
            "{name} is missing in the text of terra {command}"
        );
    }
    for o in list(&json) {
        let source = if command == "terrains" {
            &o["source"]
        } else {
            &o["reference"]
        };
        assert!(!text(source).is_empty(), "{} has no source", o[key]);
    }
    names
}

#[test]
fn every_registered_name_is_listed() {
    let registry = Registry::builtin();
    let named = registry.named_models().iter();
    let models = registry.models().iter().chain(named);
    let models: Vec<_> = models.map(|m| m.name()).collect();
    assert!(models.contains(&"braked-two-zone"));
    assert_eq!(names("models", "name"), models);
    let all = Registry::builtin().with_forms();
    let effects: Vec<_> = all.effects().iter().map(|e| e.name()).collect();
    assert_eq!(names("effects", "name"), effects);
    let forms: Vec<_> = all.effects().iter().map(|e| e.form()).collect();
    assert_eq!(names("effects", "form"), forms);
    // A diagnosis tries what is registered by default, and no other form.
    let folder = folder("list_diagnosed");
    let json: serde_json::Value =
        serde_json::from_str(&terra(&folder, "effects --json").ok().out).unwrap();
    let tried = list(&json).iter().filter(|e| e["in_diagnosis"] == true);
    assert_eq!(tried.count(), registry.effects().len());
    let terrains: Vec<_> = catalogue::terrains()
        .iter()
        .map(|t| t.id.as_ref())
        .collect();
    assert_eq!(names("terrains", "id"), terrains);
    let filters: Vec<_> = terra::ekf::FILTERS.iter().map(|f| f.name).collect();
    assert_eq!(names("filters", "name"), filters);
    let estimators: Vec<_> = terra::mme::estimators().iter().map(|e| e.name).collect();
    assert_eq!(names("estimators", "name"), estimators);
}

/// Every filling of every slot can be found, as text and as JSON, and is a model that can be asked for.
#[test]
fn every_slot_is_listed() {
    let folder = folder("list_slots");
    let plain = terra(&folder, "models").ok().out;
    let json: serde_json::Value =
        serde_json::from_str(&terra(&folder, "models --json").ok().out).unwrap();
    let (mut wheels, mut combinations) = (0, 0);
    for model in list(&json) {
        let name = text(&model["name"]);
        assert_eq!(model["in_diagnosis"], name != "braked-two-zone");
        if model["slots"].is_null() {
            continue;
        }
        wheels += 1;
        for pressure in list(&model["slots"]["pressure"]) {
            for shear in list(&model["slots"]["shear"]) {
                let (pressure, shear) = (text(&pressure["name"]), text(&shear["name"]));
                assert!(plain.contains(&format!("pressure {pressure}: ")));
                assert!(plain.contains(&format!("shear {shear}: ")));
                let combination = format!("{name}:{pressure}:{shear}");
                assert!(Registry::builtin().model(&combination).is_ok());
                combinations += 1;
            }
        }
    }
    assert_eq!(wheels, 9);
    assert!(plain.contains(&format!("{combinations} combinations")));
}

/// The names others rely on.
#[test]
fn the_names_of_the_contract_are_there() {
    let effects = names("effects", "name");
    let promised = "slip-sinkage multipass grousers bulldozing rear-contact rate-stiffening shear-hump wheel-compliance \
        layered-soil interface-friction terrain-drift lateral-contrast lateral-bulldozing drivetrain-coulomb-friction \
        drivetrain-viscous-friction torque-scale torque-bias torque-droop wheel-radius-error track-width-error cg-offset \
        mass-error ground-speed-scale ground-speed-bias ground-speed-delay accel-bias slope tow-load aero-drag \
        skid-steer-lateral-slip load-error drawbar-gain drawbar-bias sinkage-bias";
    let missing: Vec<_> = promised
        .split_whitespace()
        .filter(|n| !effects.iter().any(|e| e == n))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
    let filters = names("filters", "name");
    for name in ["block", "kf", "ekf", "iekf", "ukf", "ckf"] {
        assert!(filters.iter().any(|f| f == name), "{name}");
    }
}

#[test]
fn completions_and_help() {
    let folder = folder("help");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = terra(&folder, &format!("completions {shell}")).ok().out;
        assert!(
            script.contains("terra") && script.contains("identify"),
            "{shell}"
        );
    }
    let version = terra(&folder, "--version").ok().out;
    assert_eq!(
        version.trim(),
        format!("terra {}", env!("CARGO_PKG_VERSION"))
    );
    let help = terra(&folder, "--help").ok().out;
    for command in [
        "demo",
        "models",
        "wheel",
        "simulate",
        "estimate",
        "identify",
        "gap",
        "completions",
    ] {
        assert!(help.contains(command), "{command}");
        assert!(
            !terra(&folder, &format!("{command} --help"))
                .ok()
                .out
                .is_empty()
        );
    }
}

/// The book's pages of models and effects are those of the registry, and each stands in its contents.
#[test]
fn the_books_pages_are_those_of_the_registry() {
    let folder = folder("pages");
    terra(&folder, "pages --out made").ok();
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("book/src");
    let contents = fs::read_to_string(book.join("SUMMARY.md")).unwrap();
    let mut made = 0;
    for part in ["", "models", "effects"] {
        for entry in fs::read_dir(folder.join("made").join(part)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                continue;
            }
            let file = Path::new(part).join(path.file_name().unwrap());
            let name = file.to_str().unwrap();
            let here = fs::read_to_string(book.join(&file)).unwrap_or_default();
            let found = fs::read_to_string(&path).unwrap();
            assert!(found == here, "{name}: run `terra pages --out book/src`");
            assert!(
                contents.contains(&format!("({name})")),
                "{name} is not in SUMMARY.md"
            );
            made += 1;
        }
    }
    let registry = Registry::builtin();
    let models = registry.models().len() + registry.named_models().len();
    assert!(made >= 2 + models + 34, "{made}");
    let stale = ["models", "effects"].map(|part| fs::read_dir(book.join(part)).unwrap().count());
    assert_eq!(
        stale.iter().sum::<usize>() + 2,
        made,
        "a page of something that is gone"
    );
}

/// A value that a source does not give is a dash in the table and null in JSON, never blank and never a number.
#[test]
fn missing_values_of_soils_are_missing() {
    let folder = folder("list_missing");
    let plain = terra(&folder, "terrains").ok().out;
    let json: serde_json::Value =
        serde_json::from_str(&terra(&folder, "terrains --json").ok().out).unwrap();
    let header: Vec<&str> = plain
        .lines()
        .next()
        .unwrap()
        .split("  ")
        .map(str::trim)
        .collect();
    let header: Vec<&str> = header.into_iter().filter(|c| !c.is_empty()).collect();
    let place = |name: &str| header.iter().position(|c| *c == name).unwrap();
    let mut missing = 0;
    for soil in list(&json) {
        let id = text(&soil["id"]);
        let row = plain
            .lines()
            .find(|l| l.split_whitespace().next() == Some(id));
        let cells: Vec<&str> = row.unwrap().split("  ").map(str::trim).collect();
        let cells: Vec<&str> = cells.into_iter().filter(|c| !c.is_empty()).collect();
        assert_eq!(cells.len(), header.len(), "{id}");
        for (key, column) in [("shear_modulus", "K m"), ("c1", "c1"), ("c2", "c2")] {
            let known = catalogue::find(id).unwrap();
            let given = match key {
                "shear_modulus" => known.shear_modulus,
                "c1" => known.c1,
                _ => known.c2,
            };
            assert_eq!(soil[key].as_f64(), given, "{id} {key}");
            assert_eq!(cells[place(column)] == "-", given.is_none(), "{id} {key}");
            missing += usize::from(given.is_none());
        }
    }
    assert!(missing > 20, "{missing}");
    assert!(plain.contains("'-': the source gives no value"), "{plain}");
}
