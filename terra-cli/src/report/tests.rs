//! The report as a whole: a diagnosis of a small synthetic rig log, an identification, the rules every page keeps.

use std::collections::BTreeMap;

use terra_data::{
    FilterSettings, GapSettings, Measured, Noise, RigLog, RigRow, Rover, Start, TerrainSettings,
    WheelData,
};
use terra_gap::{Diagnosis, RigPredictor, Settings, diagnose_rig};
use terra_model::{Contact, ForceLaw, Registry, catalogue};

use super::*;

fn rover() -> Rover {
    let noise = [
        ("drawbar_pull_N", 1.0),
        ("torque_N_m", 0.2),
        ("sinkage_m", 0.0005),
        ("slip", 0.005),
        ("normal_load_N", 0.8),
    ];
    Rover {
        vehicle: None,
        wheel: WheelData {
            radius: 0.254,
            width: 0.15,
            inertia: 0.0,
            damping: 0.0,
            grouser_height: 0.0,
            grouser_count: 0,
        },
        drivetrain: None,
        terrain: TerrainSettings {
            model: "wong-reece".to_owned(),
            hypotheses: "wong21".to_owned(),
            start: Some(Start::Id("dry_sand".to_owned())),
            prior_sd: BTreeMap::new(),
            prior_abs_sd: BTreeMap::new(),
        },
        conditions: BTreeMap::new(),
        filter: FilterSettings::default(),
        gap: GapSettings::default(),
        noise: Noise(noise.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect()),
        columns: BTreeMap::new(),
    }
}

/// The nominal law with slip-sinkage of magnitude `e`, read without noise at the given slips.
fn diagnosis(slips: &[f64], e: f64) -> (Diagnosis, RigPredictor) {
    let registry = Registry::builtin();
    let law = registry.law("wong-reece+slip-sinkage").unwrap();
    let mut p = catalogue::find("dry_sand")
        .unwrap()
        .parameters(law.model())
        .unwrap();
    p.push(e);
    let measured = |value| Measured { value, sd: None };
    let rows = slips
        .iter()
        .enumerate()
        .map(|(k, &slip)| {
            let f = law
                .forces(&p, &Contact::new(slip, 245.25, 0.254, 0.15))
                .unwrap();
            RigRow {
                line: k as u64 + 2,
                trial: format!("<trial {k}>"),
                condition: "smooth".to_owned(),
                pass: 1,
                time: None,
                slip: measured(slip),
                normal_load: measured(245.25),
                drawbar_pull: Some(measured(f.drawbar_pull)),
                torque: Some(measured(f.resistive_torque)),
                sinkage: Some(measured(f.sinkage.unwrap())),
                side_force: None,
                slip_angle: None,
                travel_speed: None,
                wheel_speed: None,
            }
        })
        .collect();
    let log = RigLog {
        rows,
        dropped: vec![],
        warnings: vec!["a <note>".to_owned()],
        notes: Default::default(),
    };
    let rover = rover();
    let mut settings = Settings::of(&rover);
    settings.effects = Some(
        [
            "slip-sinkage",
            "drawbar-bias",
            "sinkage-bias",
            "torque-scale",
        ]
        .map(str::to_owned)
        .to_vec(),
    );
    settings.combine = 1;
    diagnose_rig(&log, &rover, &registry, &settings).unwrap()
}

const SLIPS: [f64; 7] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6];

fn identification() -> IdentifyView {
    let rows = 50;
    let fall = |k: usize| 0.5 * (-(k as f64) / 20.0).exp();
    IdentifyView {
        title: "Which soil".to_owned(),
        groups: vec![GroupView {
            name: "left".to_owned(),
            time: (0..rows).map(|k| k as f64 * 0.01).collect(),
            ids: vec!["dry_sand".to_owned(), "a&b".to_owned()],
            probability: (0..rows).map(|k| vec![1.0 - fall(k), fall(k)]).collect(),
            posterior: vec![("a&b".to_owned(), 0.04), ("dry_sand".to_owned(), 0.96)],
            force_slip: Some(ForceSlip {
                slip: vec![0.1, 0.2, 0.3],
                drawbar_mean: vec![1.0, 2.0, f64::NAN],
                drawbar_sd: vec![0.1, f64::NAN, 0.1],
                torque_mean: vec![3.0, 4.0, 5.0],
                torque_sd: vec![0.1; 3],
            }),
            truth: Some("dry_sand".to_owned()),
            alarm: None,
            undetermined: vec![],
        }],
    }
}

fn page(sections: Vec<Section>) -> String {
    Page {
        title: "A report".to_owned(),
        subtitle: "of a test".to_owned(),
        sections,
        provenance: vec![("terra".to_owned(), "0.1.0".to_owned())],
    }
    .render()
    .unwrap()
}

fn figures(html: &str) -> Vec<&str> {
    html.match_indices("<svg ")
        .map(|(at, _)| {
            let end = html[at..].find("</svg>").unwrap();
            &html[at..at + end + "</svg>".len()]
        })
        .filter(|svg| !svg.contains("aria-hidden"))
        .collect()
}

/// Rules of every page: nothing fetched, no script, no NaN, well-formed figures with a text alternative.
fn assert_sound(html: &str) {
    let without_namespace = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for fetched in [
        "http://", "https://", "<script", "<link", "<img", "@import", "url(", "src=",
    ] {
        assert!(!without_namespace.contains(fetched), "{fetched}");
    }
    for bad in ["NaN", "inf ", "#0102"] {
        assert!(!html.contains(bad), "{bad}");
    }
    for svg in figures(html) {
        let document = roxmltree::Document::parse(svg).unwrap();
        let root = document.root_element();
        assert_eq!(root.attribute("role"), Some("img"));
        assert!(root.attribute("aria-label").unwrap().len() > 20);
        assert!(root.attribute("width").is_none());
        let title = root.children().find(|n| n.has_tag_name("title")).unwrap();
        assert!(!title.text().unwrap().is_empty());
    }
}

#[test]
fn a_found_effect_is_told_in_all_sections() {
    let (d, predictor) = diagnosis(&SLIPS, 0.5);
    let curves = GapCurves::of_rig(&d, &predictor);
    let html = page(vec![gap_section(&d, Some(&curves))]);
    assert_sound(&html);
    assert_eq!(d.set, ["slip-sinkage"]);
    for heading in [
        "How far the gap shrinks",
        "Measured and simulated",
        "Where",
        "Causes",
        "How the soil moved",
        "How to confirm it",
        "Next experiments",
        "Data",
        "Notes",
    ] {
        assert!(html.contains(&format!("<h3>{heading}</h3>")), "{heading}");
    }
    assert!(html.contains("One known effect explains the gap: slip-sinkage"));
    assert!(html.contains("a &lt;note&gt;") && html.contains("not calibrated"));
    // The waterfall and three channels, the before curve dashed and the after curve not.
    let figures = figures(&html);
    assert_eq!(figures.len(), 4);
    for svg in &figures[1..] {
        assert!(svg.contains("stroke=\"var(--before)\" stroke-dasharray="));
        assert!(svg.contains("stroke=\"var(--after)\" stroke-width"));
    }
}

/// The law that made the readings runs through them: magnitude and soil were recovered to within the noise.
#[test]
fn the_curve_after_runs_through_the_points() {
    let (d, predictor) = diagnosis(&SLIPS, 0.5);
    let curves = GapCurves::of_rig(&d, &predictor);
    assert_eq!(curves.panels.len(), 3);
    for panel in &curves.panels {
        assert_eq!(panel.measured.len(), SLIPS.len());
        for (point, end) in [
            (
                panel.measured.first(),
                panel.after.first().and_then(|s| s.first()),
            ),
            (
                panel.measured.last(),
                panel.after.last().and_then(|s| s.last()),
            ),
        ] {
            let (point, end) = (point.unwrap(), end.unwrap());
            assert!((point.slip - end.0).abs() < 1e-9);
            assert!(
                (point.value - end.1).abs() < 2.0 * point.sd,
                "{}",
                panel.channel
            );
        }
    }
}

#[test]
fn without_an_effect_nothing_is_named() {
    let (d, predictor) = diagnosis(&SLIPS, 0.0);
    let curves = GapCurves::of_rig(&d, &predictor);
    let html = page(vec![gap_section(&d, Some(&curves))]);
    assert_sound(&html);
    assert!(!html.contains("explains the gap"), "{}", d.verdict);
    assert!(
        curves
            .panels
            .iter()
            .all(|p| p.after.is_empty() || d.accepted.is_some())
    );
}

#[test]
fn too_few_values_are_told_with_the_reason() {
    let (d, predictor) = diagnosis(&SLIPS[..2], 0.3);
    assert_eq!(d.verdict, "unidentifiable");
    let curves = GapCurves::of_rig(&d, &predictor);
    let html = page(vec![gap_section(&d, Some(&curves))]);
    assert_sound(&html);
    assert!(html.contains("This log cannot show whether anything is missing: 6 usable values"));
    assert!(!html.contains("Probability</dt>"));
}

/// Every verdict has its own sentence, and one that hedges never claims a cause.
#[test]
fn each_verdict_has_its_sentence() {
    let (mut d, _) = diagnosis(&SLIPS, 0.5);
    let mut seen = vec![];
    for (verdict, set) in [
        ("none", vec!["none"]),
        ("named", vec!["slip-sinkage"]),
        ("ambiguous", vec!["slip-sinkage", "torque-scale"]),
        ("ambiguous", vec!["none", "torque-scale"]),
        ("unknown", vec!["unknown"]),
        ("unidentifiable", vec![]),
    ] {
        d.verdict = verdict;
        d.set = set.into_iter().map(str::to_owned).collect();
        let html = page(vec![gap_section(&d, None)]);
        assert_sound(&html);
        let lead = html.split("<p class=\"lead\">").nth(1).unwrap();
        let lead = lead.split("</p>").next().unwrap().to_owned();
        assert_eq!(
            lead.contains("explains the gap:"),
            verdict == "named",
            "{lead}"
        );
        assert!(lead.ends_with('.') && !seen.contains(&lead), "{lead}");
        seen.push(lead);
    }
}

#[test]
fn an_identification_is_told_with_its_figures() {
    let html = page(vec![identify_section(&identification())]);
    assert_sound(&html);
    assert_eq!(figures(&html).len(), 3);
    assert!(html.contains("dry_sand (96\u{a0}%), which is the truth"));
    assert!(html.contains("a&amp;b"));
    // Without history, forces and truth there is still a table.
    let mut view = identification();
    view.groups[0].probability.clear();
    view.groups[0].force_slip = None;
    view.groups[0].truth = None;
    let html = page(vec![identify_section(&view)]);
    assert_sound(&html);
    assert_eq!(figures(&html).len(), 0);
    assert!(html.contains("<td>") || html.contains("<td class"));
}
