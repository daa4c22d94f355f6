//! The figures of one soil.

use terra::model::{Contact, StressProfile};
use terra_cli::report::{FigureFiles, Graph, GraphAxis, GraphSeries};

use crate::drives::{Drive, Soils};

/// Every so many rows a point.
const EVERY: usize = 4;
/// Samples after the filter's wait in which soils are told apart \[s\].
const SETTLING: (f64, f64) = (0.2, 1.2);
/// Where stresses are compared: slip, and load of a wheel at rest \[N\].
pub(crate) const STRESS_AT: (f64, f64) = (0.2, 245.25);

const RADIUS: f64 = 0.254;
const WIDTH: f64 = 0.15;

/// Name, its value from parameters in the law's order (c, φ, k_c, k_φ, n, K, c1, c2).
type Parameter = (&'static str, fn(&[f64]) -> f64);
const PARAMETERS: [Parameter; 4] = [
    ("cohesion", |p| p[0]),
    ("friction angle", |p| p[1]),
    ("stiffness", |p| p[2] / WIDTH + p[3]),
    ("shear modulus", |p| p[5]),
];

/// Forces, parameters, probabilities and stresses, in the paper's order.
pub(crate) fn of_soil(soils: &Soils, exact: &[Drive], near: &[Drive]) -> Vec<FigureFiles> {
    let mut out = forces(&exact[0]);
    out.push(parameters(soils, exact, near));
    out.push(probabilities(exact, near));
    out.push(stresses(soils, near));
    out
}

fn words(soil: &str) -> String {
    soil.trim_end_matches("_22").replace('_', " ")
}

/// Pull of the left side and torque of its front wheel against slip, estimated and true.
fn forces(drive: &Drive) -> Vec<FigureFiles> {
    let slip = |d: &[f64; 7]| 0.5 * (d[3] + d[5]);
    let rows = || drive.forces.iter().step_by(EVERY);
    let estimate = |at: fn(&[f64; 7]) -> f64, k: usize| {
        let one = |(_, s): &(usize, terra::ekf::SideForces)| {
            [at(&s.vector), s.vector[k], s.covariance[(k, k)].sqrt()]
        };
        rows().map(one).collect::<Vec<_>>()
    };
    let t = &drive.truth;
    let truth = |x: &dyn Fn(usize) -> f64, y: &dyn Fn(usize) -> f64| {
        rows()
            .map(|(row, _)| [x(*row), y(*row), f64::NAN])
            .collect()
    };
    let x = || GraphAxis::new("slip", "slip", "");
    let graph = |title: String, y: GraphAxis, estimate: Vec<[f64; 3]>, truth: Vec<[f64; 3]>| {
        Graph {
            title,
            description: "The estimate with one sd each way, and the truth, as the torque falls."
                .to_owned(),
            x: x(),
            y,
            series: vec![
                GraphSeries::line("force filter, 1 sd each way", 0, estimate),
                GraphSeries::dots("truth", truth),
            ],
        }
        .files()
    };
    let soil = words(drive.soil);
    vec![
        graph(
            format!("Pull of the left side, {soil}"),
            GraphAxis::new("drawbar pull of two wheels, N", "drawbar_pull_N", "N"),
            estimate(slip, 0),
            truth(&|k| 0.5 * (t.slip[0][k] + t.slip[2][k]), &|k| {
                t.drawbar_pull[0][k] + t.drawbar_pull[2][k]
            }),
        ),
        graph(
            format!("Torque of the front wheel, {soil}"),
            GraphAxis::new("resistive torque, N m", "resistive_torque_N_m", "N m"),
            estimate(|d| d[3], 1),
            truth(&|k| t.slip[0][k], &|k| t.resistive_torque[0][k]),
        ),
    ]
}

/// How far the posterior mean of a parameter is from the truth: median of all draws, each parameter when the set is 10 %
/// off, the worst of them when the soil itself is in the set.
fn parameters(soils: &Soils, exact: &[Drive], near: &[Drive]) -> FigureFiles {
    let own = soils.parameters(near[0].soil);
    let off = |drives: &[Drive], what: fn(&[f64]) -> f64| -> Vec<[f64; 3]> {
        let runs: Vec<Vec<f64>> = drives.iter().map(|d| d.mean(what)).collect();
        let at = |row: usize| {
            let mut off: Vec<f64> = runs
                .iter()
                .map(|r| (r[row] / what(&own) - 1.0).abs())
                .collect();
            off.sort_by(f64::total_cmp);
            off[off.len() / 2]
        };
        let rows = settling(&drives[0]);
        rows.map(|(row, t)| [t, at(row), f64::NAN]).collect()
    };
    let mut series: Vec<GraphSeries> = PARAMETERS
        .iter()
        .enumerate()
        .map(|(k, (name, what))| GraphSeries::line(name, k + 1, off(near, *what)))
        .collect();
    let mut worst = off(exact, PARAMETERS[0].1);
    for (_, what) in &PARAMETERS[1..] {
        for (point, other) in worst.iter_mut().zip(off(exact, *what)) {
            point[1] = point[1].max(other[1]);
        }
    }
    series.insert(0, GraphSeries::line("worst, itself in the set", 0, worst));
    Graph {
        title: format!("Parameters, {}", words(near[0].soil)),
        description: "Error of the posterior mean, median over draws.".to_owned(),
        x: GraphAxis::new("time, s", "time_s", "s").between(SETTLING.0, SETTLING.1),
        y: GraphAxis::new("error of the posterior mean, %", "relative_error", "")
            .shown_in("%", 100.0),
        series,
    }
    .files()
}

/// Probability of the soil's own name, mean of all draws, and of the soil that most draws took instead.
fn probabilities(exact: &[Drive], near: &[Drive]) -> FigureFiles {
    let mean = |drives: &[Drive], soil: &str| -> Vec<[f64; 3]> {
        let runs: Vec<Vec<f64>> = drives.iter().map(|d| d.probability(soil)).collect();
        let at = |row: usize| runs.iter().map(|r| r[row]).sum::<f64>() / runs.len() as f64;
        let rows = settling(&drives[0]);
        rows.map(|(row, t)| [t, at(row), f64::NAN]).collect()
    };
    let soil = near[0].soil;
    let mut series = vec![
        GraphSeries::line("itself in the set", 0, mean(exact, soil)),
        GraphSeries::line("its copy, 10 % off", 1, mean(near, soil)),
    ];
    if let Some(rival) = rival(near) {
        let name = format!("{} copy, 10 % off", rival.replace('_', " "));
        series.push(GraphSeries::line(&name, 2, mean(near, &rival)));
    }
    Graph {
        title: format!("Probability, {}", words(soil)),
        description: "Mean over draws.".to_owned(),
        x: GraphAxis::new("time, s", "time_s", "s").between(SETTLING.0, SETTLING.1),
        y: GraphAxis::new("probability, mean of draws", "probability", "").between(0.0, 1.0),
        series,
    }
    .files()
}

/// The soil that is named most often instead of the right one.
pub(crate) fn rival(near: &[Drive]) -> Option<String> {
    let mut count = std::collections::BTreeMap::new();
    for d in near.iter().filter(|d| d.winner() != d.soil) {
        *count.entry(d.winner().to_owned()).or_insert(0) += 1;
    }
    count.into_iter().max_by_key(|(_, n)| *n).map(|(id, _)| id)
}

/// Stress along the contact under the truth and under the winner of each draw.
fn stresses(soils: &Soils, near: &[Drive]) -> FigureFiles {
    let mut series = Vec::new();
    for drive in near {
        let Some(found) = profile(soils, &winner(drive)) else {
            continue;
        };
        for (k, (name, line)) in lines(&found).into_iter().enumerate() {
            series.push(GraphSeries::line(&format!("{name}, winner"), k, line));
        }
    }
    if let Some(own) = profile(soils, &soils.parameters(near[0].soil)) {
        for (name, line) in lines(&own) {
            let dots = line.into_iter().step_by(2).collect();
            series.push(GraphSeries::dots(&format!("truth ({name})"), dots));
        }
    }
    Graph {
        title: format!("Stress, {}", words(near[0].soil)),
        description: "Normal and shear stress of each draw's winner around the true ones."
            .to_owned(),
        x: GraphAxis::new("angle from below the axle, deg", "angle_rad", "rad")
            .shown_in("deg", 180.0 / std::f64::consts::PI),
        y: GraphAxis::new("stress, kPa", "stress_Pa", "Pa").shown_in("kPa", 1e-3),
        series,
    }
    .files()
}

/// Parameters of the most probable hypothesis.
pub(crate) fn winner(drive: &Drive) -> Vec<f64> {
    let h = drive.set.iter().find(|h| h.id == drive.winner()).unwrap();
    h.parameters.clone()
}

/// Stresses at [`STRESS_AT`]; none for a soil that does not carry the wheel there.
pub(crate) fn profile(soils: &Soils, parameters: &[f64]) -> Option<StressProfile> {
    let at = Contact::new(STRESS_AT.0, STRESS_AT.1, RADIUS, WIDTH);
    let model = soils.law.model();
    let field = model.stress_field(parameters, &at).ok().flatten();
    field.map(|field| field.profile(41))
}

fn lines(profile: &StressProfile) -> [(&'static str, Vec<[f64; 3]>); 2] {
    let line = |stress: fn(&terra::model::StressPoint) -> f64| {
        let points = profile.points.iter();
        points.map(|p| [p.angle, stress(p), f64::NAN]).collect()
    };
    [
        ("normal", line(|p| p.normal_stress)),
        ("shear", line(|p| p.shear_stress)),
    ]
}

/// Rows of the history that are drawn, with their time: each of the first twenty, then every fourth.
fn settling(drive: &Drive) -> impl Iterator<Item = (usize, f64)> + '_ {
    let rows = drive.time().iter().copied().enumerate();
    rows.filter(|(k, t)| *t <= SETTLING.1 && (*k < 20 || k % EVERY == 0))
}
