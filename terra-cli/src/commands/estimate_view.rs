//! What the report shows of an estimate: the columns of its table, as figures.

use terra_data::DriveLog;

use crate::report::{Channel, EstimateView};

/// Heading, caption, and columns before and after the name of a wheel; without one where the second is absent.
const FIGURES: [(&str, &str, &[Column]); 5] = [
    (
        "Force of the ground on each side",
        "Sum over the wheels of a side, forward.",
        &[Column::side("side_force", "_N", "N")],
    ),
    (
        "Resistive torque of each wheel",
        "What the ground turns against the wheel.",
        &[Column::wheel("resistive_torque", "_N_m", "N m")],
    ),
    (
        "Slip of each wheel",
        "1 is a wheel that spins on the spot, 0 one that rolls.",
        &[Column::wheel("slip", "", "1")],
    ),
    (
        "Normal load of each wheel",
        "From mass, geometry and the measured acceleration.",
        &[Column::wheel("normal_load", "_N", "N")],
    ),
    (
        "Motion",
        "",
        &[
            Column::body("ground_speed", "_m_s", "m/s"),
            Column::body("yaw_rate", "_rad_s", "rad/s"),
        ],
    ),
];

/// A quantity of the table.
struct Column {
    stem: &'static str,
    of: &'static [&'static str],
    suffix: &'static str,
    unit: &'static str,
}

impl Column {
    const fn wheel(stem: &'static str, suffix: &'static str, unit: &'static str) -> Self {
        Column {
            stem,
            of: &["_fl", "_fr", "_rl", "_rr"],
            suffix,
            unit,
        }
    }
    const fn side(stem: &'static str, suffix: &'static str, unit: &'static str) -> Self {
        Column {
            stem,
            of: &["_left", "_right"],
            suffix,
            unit,
        }
    }
    const fn body(stem: &'static str, suffix: &'static str, unit: &'static str) -> Self {
        Column {
            stem,
            of: &[""],
            suffix,
            unit,
        }
    }
}

/// The table of `terra estimate` as figures.
pub(crate) fn view(log: &DriveLog, table: &str) -> EstimateView {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let head: Vec<String> = reader
        .headers()
        .map(|h| h.iter().map(str::to_owned).collect())
        .unwrap_or_default();
    let mut columns: Vec<Vec<f64>> = vec![vec![]; head.len()];
    let mut flags: Vec<(String, usize)> = vec![];
    for row in reader.records().flatten() {
        for ((name, column), cell) in head.iter().zip(&mut columns).zip(&row) {
            if name == "flag" {
                match flags.iter_mut().find(|f| f.0 == cell) {
                    Some(flag) => flag.1 += 1,
                    None => flags.push((cell.to_owned(), 1)),
                }
            }
            column.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    let column = |name: &str| {
        let found = head.iter().position(|h| h == name);
        let found = found.and_then(|k| columns.get(k));
        found.cloned().unwrap_or_default()
    };
    let channels = |of: &[Column]| -> Vec<Channel> {
        let all = of
            .iter()
            .flat_map(|c| c.of.iter().map(move |which| (c, which)));
        all.map(|(c, which)| Channel {
            name: format!("{}{which}{}", c.stem, c.suffix),
            unit: c.unit.to_owned(),
            value: column(&format!("{}{which}{}", c.stem, c.suffix)),
            sd: column(&format!("{}{which}_sd{}", c.stem, c.suffix)),
        })
        .collect()
    };
    EstimateView {
        title: "Forces, torques and slip over time".to_owned(),
        time: log.time.clone(),
        segments: log
            .segments
            .iter()
            .map(|s| (s.name.clone(), s.rows.start))
            .collect(),
        flags,
        figures: FIGURES
            .iter()
            .map(|(heading, caption, of)| {
                ((*heading).to_owned(), (*caption).to_owned(), channels(of))
            })
            .collect(),
    }
}
