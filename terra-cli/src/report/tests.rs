//! The report as a whole: a diagnosis of a small synthetic rig log, an identification, the rules every page keeps.

mod browser;

use std::collections::BTreeMap;

use terra_data::{
    FilterSettings, GapSettings, Measured, Noise, RigLog, RigRow, Rover, Start, TerrainSettings,
    WheelData,
};
use terra_gap::{Diagnosis, RigPredictor, Settings, diagnose_rig};
use terra_model::bevameter::{Curve, fit_plates};
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

pub(super) fn identification() -> IdentifyView {
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
            parameters: vec![ParameterPath {
                name: "friction_angle".to_owned(),
                unit: "rad".to_owned(),
                mean: (0..rows).map(|k| 0.5 + 0.1 * fall(k)).collect(),
                sd: (0..rows).map(fall).collect(),
                refined: Some((0.5, 0.01)),
            }],
            force_slip: Some(ForceSlip {
                load: 80.0,
                radius: 0.2,
                slip: vec![0.1, 0.2, 0.3],
                drawbar: vec![(1.0, 0.1), (2.0, f64::NAN), (f64::NAN, 0.1)],
                torque: vec![(3.0, 0.1), (4.0, 0.1), (5.0, 0.1)],
                sinkage: vec![],
                measured: vec![MeasuredForces {
                    trial: "<a>, b".to_owned(),
                    slip: (0.2, 0.01),
                    drawbar: (2.1, 0.1),
                    torque: (4.2, 0.1),
                    sinkage: (f64::NAN, f64::NAN),
                }],
            }),
            truth: Some("dry_sand".to_owned()),
            alarm: None,
            undetermined: vec![],
        }],
    }
}

fn wheel() -> WheelView {
    let row = |slip: f64| WheelRow {
        slip,
        drawbar: 100.0 * (slip - 0.1),
        torque: 20.0 * slip,
        sinkage: 0.01 + 0.01 * slip,
        stresses: (0..5).map(|k| [0.1 * f64::from(k), 1e3, -1e2]).collect(),
    };
    WheelView {
        title: "Forces".to_owned(),
        load: 80.0,
        radius: 0.2,
        rows: vec![row(0.05), row(0.2), row(0.4)],
    }
}

fn estimate() -> EstimateView {
    let rows = 1000;
    let sd = |k: usize| if k == 0 { 1e6 } else { 1.0 };
    let channel = |name: &str| Channel {
        name: name.to_owned(),
        unit: "N".to_owned(),
        value: (0..rows).map(|k| (k as f64 * 0.02).sin() * 10.0).collect(),
        sd: (0..rows).map(sd).collect(),
    };
    EstimateView {
        title: "Forces".to_owned(),
        time: (0..rows).map(|k| k as f64 * 0.01).collect(),
        segments: vec![("a".to_owned(), 0), ("b".to_owned(), 400)],
        flags: vec![("starting".to_owned(), 100), ("ok".to_owned(), 900)],
        figures: vec![(
            "Sides".to_owned(),
            "Sum.".to_owned(),
            vec![channel("side_force_left_N"), channel("side_force_right_N")],
        )],
    }
}

/// One of each kind.
pub(super) fn every_section() -> Vec<Section> {
    let (d, predictor) = diagnosis(&SLIPS, 0.5);
    // Bekker's law with n = 1: p = 2 MPa/m z.
    let curve = Curve {
        test: "<plate>".to_owned(),
        given: 0.05,
        points: (1..40)
            .map(|k| (1e-3 * f64::from(k), 2e3 * f64::from(k)))
            .collect(),
    };
    let plates = BevameterView {
        title: "Soil".to_owned(),
        shear: false,
        fits: fit_plates(&[curve], 0.0, 1.0).unwrap(),
    };
    let profiles = ProfilesView {
        title: "Identifiability".to_owned(),
        lead: "Lead.".to_owned(),
        undetermined: vec![],
        profiles: vec![(
            terra_mme::Profile {
                name: "cohesion",
                points: (-3..=3)
                    .map(|k| (10.0 + f64::from(k), f64::from(k * k)))
                    .collect(),
                low: Some(8.0),
                high: None,
            },
            "Pa".to_owned(),
        )],
    };
    vec![
        identify_section(&identification()),
        gap_section(&d, Some(&GapCurves::of_rig(&d, &predictor))),
        wheel_section(&wheel()),
        estimate_section(&estimate()),
        bevameter_section(&plates),
        profiles_section(&profiles),
    ]
}

pub(super) fn page(sections: Vec<Section>) -> String {
    Page {
        title: "A report".to_owned(),
        subtitle: "of a test".to_owned(),
        sections,
        provenance: vec![("terra".to_owned(), "0.1.0".to_owned())],
    }
    .render()
    .unwrap()
}

/// The panels of a page.
fn figures(html: &str) -> Vec<&str> {
    html.match_indices("<svg xmlns=\"http")
        .map(|(at, _)| {
            let end = html[at..].find("</svg><pre").unwrap();
            &html[at..at + end + "</svg>".len()]
        })
        .collect()
}

/// Rules of every page: nothing fetched, no script but the page's own, no NaN, well-formed figures with a text
/// alternative and their numbers.
fn assert_sound(html: &str) {
    let (before, rest) = html.split_once("<script>").unwrap();
    let (script, after) = rest.split_once("</script>").unwrap();
    assert_eq!(script, include_str!("page.js"));
    let own = format!("{before}{after}");
    let without_namespace = own.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for fetched in [
        "http://", "https://", "<script", "<link", "<img", "@import", "url(", "src=",
    ] {
        assert!(!without_namespace.contains(fetched), "{fetched}");
    }
    for fetching in [
        "fetch(",
        "XMLHttpRequest",
        "import(",
        "WebSocket",
        "sendBeacon",
        "eval(",
    ] {
        assert!(!script.contains(fetching), "{fetching}");
    }
    for bad in ["NaN", "inf ", "#0102"] {
        assert!(!own.contains(bad), "{bad}");
    }
    let panels = figures(html);
    for svg in &panels {
        let document = roxmltree::Document::parse(svg).unwrap();
        let root = document.root_element();
        assert_eq!(root.attribute("role"), Some("img"));
        assert!(root.attribute("aria-label").unwrap().len() > 20);
        assert!(root.attribute("width").is_none());
        let title = root.children().find(|n| n.has_tag_name("title")).unwrap();
        assert!(!title.text().unwrap().is_empty());
        for axis in ["data-x", "data-y"] {
            let axis: serde_json::Value =
                serde_json::from_str(root.attribute(axis).unwrap()).unwrap();
            assert_ne!(axis["name"], "", "an axis without a column");
        }
    }
    assert_eq!(
        html.matches("<pre class=\"numbers\" hidden>series").count(),
        panels.len()
    );
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
    assert!(html.contains("a &lt;note&gt;"));
    let calibration = d.calibration.as_ref().unwrap();
    assert!(calibration.cases > 0 && html.contains(&calibration.source));
    // The waterfall, three channels and two stresses, the before curve dashed and the after curve not.
    let figures = figures(&html);
    assert_eq!(figures.len(), 6);
    for svg in &figures[1..] {
        assert!(svg.contains("stroke=\"var(--before)\" stroke-dasharray="));
        assert!(svg.contains("stroke=\"var(--after)\" stroke-width"));
    }
}

/// Stress falls to nothing where the rim leaves and enters the soil; slip-sinkage puts more of the rim into it.
#[test]
fn stresses_are_those_of_both_laws() {
    let (d, predictor) = diagnosis(&SLIPS, 0.5);
    let stresses = GapCurves::of_rig(&d, &predictor).stresses;
    assert_eq!((stresses.slip, stresses.load), (0.3, 245.25));
    for profile in [&stresses.before, &stresses.after] {
        let most = profile.iter().map(|p| p[1]).fold(0.0, f64::max);
        assert!(most > 1e3);
        for end in [profile.first(), profile.last()] {
            assert!(end.unwrap()[1].abs() < 1e-3 * most);
        }
    }
    assert_eq!(d.accepted_names, ["slip-sinkage"]);
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
    // History, one parameter; pull, torque, traction coefficient, efficiency, but no sinkage.
    assert_eq!(figures(&html).len(), 6);
    assert!(html.contains("dry_sand (96\u{a0}%), which is the truth"));
    assert!(html.contains("a&amp;b"));
    // Without history, forces and truth there is still a table.
    let mut view = identification();
    view.groups[0].probability.clear();
    view.groups[0].force_slip = None;
    view.groups[0].truth = None;
    view.groups[0].parameters.clear();
    let html = page(vec![identify_section(&view)]);
    assert_sound(&html);
    assert_eq!(figures(&html).len(), 0);
    assert!(html.contains("<td>") || html.contains("<td class"));
}

/// A pulling wheel and its stresses; a soil that does not carry it says so.
#[test]
fn a_wheel_is_told_with_stresses_and_worth() {
    let mut view = wheel();
    let html = page(vec![wheel_section(&view)]);
    assert_sound(&html);
    assert_eq!(figures(&html).len(), 7);
    // D r (1 - s) / T: 10 x .2 x .8 / 4 = .4 at slip .2, 30 x .2 x .6 / 8 = .45 at slip .4; the pull there is 30 N of 80.
    assert!(html.contains("pulls most at slip 0.40: 30.0\u{a0}N, 38\u{a0}% of its load"));
    assert!(html.contains("most efficiently at slip 0.40, with 45\u{a0}% of its power"));
    view.rows = vec![WheelRow {
        slip: 0.1,
        ..WheelRow::NONE
    }];
    let html = page(vec![wheel_section(&view)]);
    assert_sound(&html);
    assert!(html.contains("does not carry the wheel at any"));
}

/// The axis is that of the settled estimate: a start that knows nothing must not flatten what follows.
#[test]
fn an_estimate_is_told_over_time() {
    let view = estimate();
    let html = page(vec![estimate_section(&view)]);
    assert_sound(&html);
    let panels = figures(&html);
    assert_eq!(panels.len(), 2);
    assert!(html.contains("1000 rows in 2 segments: 90\u{a0}% of them"));
    for svg in panels {
        let document = roxmltree::Document::parse(svg).unwrap();
        let y: serde_json::Value =
            serde_json::from_str(document.root_element().attribute("data-y").unwrap()).unwrap();
        assert!(y["range"][0].as_f64().unwrap() > -20.0 && y["range"][1].as_f64().unwrap() < 20.0);
        // Two segments are two lines.
        let lines = document
            .descendants()
            .filter(|n| n.attribute("stroke-width") == Some("2"));
        assert!(lines.filter(|n| n.has_tag_name("polyline")).count() >= 2);
    }
}

/// Files have names of their own even where titles are the same, and hold what the page holds.
#[test]
fn figures_are_files() {
    let sections = vec![
        identify_section(&identification()),
        identify_section(&identification()),
    ];
    let page = Page {
        sections,
        ..Page::default()
    };
    let files = page.figures();
    let names: std::collections::BTreeSet<&str> = files.iter().map(|f| f.name.as_str()).collect();
    assert_eq!((files.len(), names.len()), (12, 12));
    let html = page.render().unwrap();
    for file in &files {
        assert!(html.contains(&format!("data-file=\"{}\"", file.name)));
        roxmltree::Document::parse(&file.svg).unwrap();
    }
    let pull = files
        .iter()
        .find(|f| f.name == "drawbar-pull-against-slip-left")
        .unwrap();
    assert_eq!(
        pull.csv,
        "series,label,slip,slip_sd,drawbar_pull_N,drawbar_pull_sd_N\n\
         predicted ± 1 sd,,0.1,,1,0.1\npredicted ± 1 sd,,0.2,,2,\n\
         measured ± 1 sd,\"<a>, b\",0.2,0.01,2.1,0.1\n"
    );
}
