//! One wheel on a known soil: forces, what they are worth, and the stresses under the rim.

use super::block::{Figure, Section};
use super::force_slip::{ForceSlip, forces, tractive_efficiency};
use super::number::{number, share};
use super::paint::Paint;
use super::stress::{Profile, panels};

/// Slips whose stresses are drawn.
const PROFILES: usize = 4;

/// Forces at one slip; NaN where the model gives none.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelRow {
    /// Library slip.
    pub slip: f64,
    /// \[N\]
    pub drawbar: f64,
    /// \[N m\]
    pub torque: f64,
    /// \[m\]
    pub sinkage: f64,
    /// Angle \[rad\], normal and shear stress \[Pa\] along the contact; empty for a model without stresses.
    pub stresses: Vec<[f64; 3]>,
}

impl WheelRow {
    /// No equilibrium: the soil does not carry the wheel.
    pub const NONE: WheelRow = WheelRow {
        slip: f64::NAN,
        drawbar: f64::NAN,
        torque: f64::NAN,
        sinkage: f64::NAN,
        stresses: vec![],
    };
}

/// A wheel, ready to be told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WheelView {
    /// Heading.
    pub title: String,
    /// Normal load \[N\].
    pub load: f64,
    /// Wheel radius \[m\].
    pub radius: f64,
    /// One a slip.
    pub rows: Vec<WheelRow>,
}

/// The wheel as a section.
pub fn wheel_section(view: &WheelView) -> Section {
    let mut s = Section::new(view.title.clone());
    s.lead(lead(view));
    let column = |of: fn(&WheelRow) -> f64| view.rows.iter().map(|r| (of(r), f64::NAN)).collect();
    s.figure(forces(
        "",
        &ForceSlip {
            load: view.load,
            radius: view.radius,
            slip: view.rows.iter().map(|r| r.slip).collect(),
            drawbar: column(|r| r.drawbar),
            torque: column(|r| r.torque),
            sinkage: column(|r| r.sinkage),
            measured: vec![],
        },
    ));
    let profiles = chosen(view);
    if !profiles.is_empty() {
        s.heading("Stress along the contact");
        s.figure(stress_figure(&profiles));
    }
    s
}

fn lead(view: &WheelView) -> String {
    let carried: Vec<&WheelRow> = view.rows.iter().filter(|r| r.drawbar.is_finite()).collect();
    let Some(most) = carried
        .iter()
        .max_by(|a, b| a.drawbar.total_cmp(&b.drawbar))
    else {
        return "This soil does not carry the wheel at any of these slips.".to_owned();
    };
    let mut text = format!(
        "The wheel pulls most at slip {}: {}\u{a0}N, {} of its load",
        number(most.slip, 2),
        number(most.drawbar, 3),
        share(most.drawbar / view.load)
    );
    let efficiency = |r: &WheelRow| tractive_efficiency(r.drawbar, r.torque, r.slip, view.radius);
    let best = carried
        .iter()
        .map(|r| (r.slip, efficiency(r)))
        .filter(|e| e.1.is_finite())
        .max_by(|a, b| a.1.total_cmp(&b.1));
    match best {
        Some((slip, eta)) => text.push_str(&format!(
            "; it pulls most efficiently at slip {}, with {} of its power.",
            number(slip, 2),
            share(eta)
        )),
        None => text.push('.'),
    }
    if carried.len() < view.rows.len() {
        let lost = view.rows.len() - carried.len();
        text.push_str(&format!(
            " At {lost} of {} slips the soil does not carry it.",
            view.rows.len()
        ));
    }
    text
}

/// A few rows with stresses, spread over the slips.
fn chosen(view: &WheelView) -> Vec<&WheelRow> {
    let known: Vec<&WheelRow> = view.rows.iter().filter(|r| r.stresses.len() > 1).collect();
    let n = known.len().min(PROFILES);
    let last = known.len().saturating_sub(1);
    (0..n)
        .filter_map(|k| {
            known
                .get(if n > 1 { k * last / (n - 1) } else { 0 })
                .copied()
        })
        .collect()
}

fn stress_figure(rows: &[&WheelRow]) -> Figure {
    let profiles: Vec<Profile<'_>> = rows
        .iter()
        .enumerate()
        .map(|(k, r)| Profile {
            name: format!("slip {}", number(r.slip, 2)),
            paint: Paint::Series(k),
            points: &r.stresses,
        })
        .collect();
    Figure::new(
        panels(&profiles),
        "Stress of the ground on the rim, by angle from straight below the axle; the wheel enters the soil at the right.",
    )
}
