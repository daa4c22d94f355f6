//! The stress that the simulator puts on the rim, before and after the cause was added.

use terra_gap::{Diagnosis, Hypothesis, RigPredictor};

use super::super::block::{Figure, Section};
use super::super::number::plain;
use super::super::paint::Paint;
use super::super::stress::{Profile, panels};
use super::curves::median;

/// Points of a profile.
const POINTS: usize = 61;

/// Angle \[rad\], normal and shear stress \[Pa\] along the contact, at the median slip and load of a group of rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stresses {
    /// Library slip.
    pub slip: f64,
    /// \[N\]
    pub load: f64,
    /// Nominal law, soil re-fitted; empty for a law without stresses.
    pub before: Vec<[f64; 3]>,
    /// Accepted law; empty when nothing was accepted.
    pub after: Vec<[f64; 3]>,
}

impl Stresses {
    pub(super) fn of_rig(d: &Diagnosis, predictor: &RigPredictor, rows: &[usize]) -> Self {
        let rows = || rows.iter().filter_map(|&i| d.data.observations.get(i));
        let factor = |name| {
            let values = rows().filter_map(|o| o.factors.get(name).copied());
            median(values.collect())
        };
        let (slip, load) = (factor("slip"), factor("load"));
        let profile = |law: Option<(&Hypothesis, &[f64])>| -> Vec<[f64; 3]> {
            let found = law.zip(rows().next()).and_then(|((h, x), row)| {
                let p = h.parameters(x);
                let at = [slip, load];
                predictor.stresses(&h.law, &p, row.index, at, POINTS).ok()?
            });
            let points = found.iter().flat_map(|s| &s.points);
            points
                .map(|p| [p.angle, p.normal_stress, p.shear_stress])
                .collect()
        };
        Stresses {
            slip,
            load,
            before: profile(d.null.as_ref().map(|l| (&l.0, l.1.x.as_slice()))),
            after: profile(d.accepted.as_ref().map(|l| (&l.0, l.1.x.as_slice()))),
        }
    }
}

pub(super) fn write(s: &mut Section, d: &Diagnosis, stresses: &Stresses) {
    if stresses.before.len() < 2 {
        return;
    }
    let mut profiles = vec![Profile {
        name: "simulator, soil re-fitted".to_owned(),
        paint: Paint::Before,
        points: &stresses.before,
    }];
    if stresses.after.len() > 1 {
        profiles.push(Profile {
            name: format!("the same with {}", d.accepted_names.join(" and ")),
            paint: Paint::After,
            points: &stresses.after,
        });
    }
    s.figure(Figure::new(
        panels(&profiles),
        format!(
            "Stress on the rim as the simulator has it at the median slip {} and load {}\u{a0}N, by angle from straight below the axle; the wheel enters the soil at the right.",
            plain(stresses.slip),
            plain(stresses.load)
        ),
    ));
}
