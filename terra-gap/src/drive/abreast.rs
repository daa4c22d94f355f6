//! Windows side by side: those whose wheels turn and slip the same way, so that no lane waits for another's braked wheel.

use std::borrow::Borrow;
use std::ops::Range;

use terra_model::{Abreast, LaneDual, Lanes, Law, Touch, Vector};

use super::stance::{Factor, Stance};
use super::surface::Surfaces;
use super::{DrivePredictor, Entries, Given, NODES, RAW, SPEED, VALUES, WHEEL, Window, YAW_RATE};
use crate::abreast::{self, WORTH, in_groups, side_by_side};
use crate::error::GapError;
use crate::logs::of_log;
use crate::memory::Memory;
use crate::predictor::{Predictor, Sloped, varying};

/// What windows of one group have in common.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Kind {
    log: usize,
    nodes: usize,
    forwards: bool,
    braked: [bool; 4],
}

impl Kind {
    pub(super) fn of(predictor: &DrivePredictor, window: &Window) -> Self {
        let (track, radius) = (predictor.vehicle.track, predictor.vehicle.wheel_radius);
        let braked = |q: usize| {
            let arm = track * if q.is_multiple_of(2) { -0.5 } else { 0.5 };
            let travel = window.raw[SPEED] + window.raw[YAW_RATE] * arm;
            (window.raw[WHEEL + q] * radius).abs() < travel.abs()
        };
        Kind {
            log: window.log,
            nodes: window.nodes.len(),
            forwards: window.forwards(),
            braked: std::array::from_fn(braked),
        }
    }
}

/// Residuals of windows, in their order.
///
/// # Errors
/// Where the model has no answer for one of them.
pub(super) fn residuals(
    predictor: &DrivePredictor,
    law: &Law,
    p: &[f64],
    indices: &[usize],
    memory: &Memory,
) -> Result<Vec<Vec<f64>>, GapError> {
    let in_lanes: Vec<Lanes> = p.iter().map(|&v| Lanes::from(v)).collect();
    let asked = Asked {
        predictor,
        law,
        p: &in_lanes,
        varied: &(0..0),
        indices,
        memory,
    };
    let of_lane = |residual: &Lanes, lane| residual.lane(lane);
    let raw = |_, x| x;
    let alone = |i| predictor.residual(law, p, i, &predictor.raw(i));
    asked.answered(
        of_lane,
        raw,
        |surfaces| if surfaces { 1 } else { WORTH },
        Some(alone),
    )
}

/// The same with their slopes.
///
/// # Errors
/// As [`residuals`].
pub(super) fn slopes(
    predictor: &DrivePredictor,
    law: &Law,
    p: &[LaneDual],
    varied: &Range<usize>,
    indices: &[usize],
    memory: &Memory,
) -> Result<Vec<Vec<Sloped>>, GapError> {
    let asked = Asked {
        predictor,
        law,
        p,
        varied,
        indices,
        memory,
    };
    let raw = |k, x| varying(k, x, varied);
    let alone: Option<fn(usize) -> _> = None;
    asked.answered(Sloped::of_lane, raw, |_| 1, alone)
}

/// Windows that are asked at once.
struct Asked<'a, T> {
    predictor: &'a DrivePredictor,
    law: &'a Law,
    p: &'a [T],
    /// Raw quantities that vary.
    varied: &'a Range<usize>,
    indices: &'a [usize],
    memory: &'a Memory,
}

impl<T: Abreast> Asked<'_, T> {
    /// Whether the vehicle may stand otherwise elsewhere.
    fn may_vary(&self, p: &[T]) -> bool {
        let moves = |touch| {
            let mut acting = self.law.acting(p, touch);
            acting.any(|(_, e)| e.iter().any(T::varies))
        };
        !self.varied.is_empty() || moves(Touch::Vehicle) || moves(Touch::Sensor)
    }
}

impl<T: Abreast> Asked<'_, T>
where
    Lanes: Factor<T>,
{
    /// What `of_lane` makes of the residuals of each. `raw`: a raw quantity by its place. `worth`: from how many windows on a group
    /// is cheaper than each of them `alone`, where surfaces stand and where not.
    fn answered<A: Clone + Default + Send + Sync>(
        &self,
        of_lane: impl Fn(&T, usize) -> A + Sync,
        raw: impl Fn(usize, Lanes) -> T + Sync,
        worth: impl Fn(bool) -> usize,
        alone: Option<impl Fn(usize) -> Result<Vec<A>, GapError> + Sync>,
    ) -> Result<Vec<Vec<A>>, GapError> {
        let Asked {
            predictor,
            law,
            p,
            indices,
            memory,
            ..
        } = *self;
        let at = || p.iter().map(|p| p.primal().lane(0));
        let last = Last::of(memory, at());
        let frame = predictor
            .frame(law, indices)
            .filter(|_| self.varied.is_empty());
        let surfaces = Surfaces::of(predictor, law, p, indices, frame.as_deref(), &last);
        let last = last.beside(&surfaces);
        let mut out = vec![vec![]; indices.len()];
        if let Some(frame) = frame {
            for (place, residual) in frame.residuals(predictor, law, p, &surfaces, &last, &of_lane)
            {
                out[place] = residual;
            }
        }
        let left: Vec<usize> = (0..indices.len())
            .filter(|&place| out[place].is_empty())
            .collect();
        let windows: Vec<usize> = left.iter().map(|&place| indices[place]).collect();
        let together = |windows: &[usize]| {
            let group = Group::of(predictor, windows);
            together(self, &group, &raw, &of_lane, &last, &surfaces)
        };
        let found = in_groups(
            &windows,
            |i| Kind::of(predictor, &predictor.windows[i]),
            worth(surfaces.any()),
            together,
            |i| match &alone {
                Some(alone) => alone(i),
                None => Ok(together(&[i])?.concat()),
            },
        );
        for (place, found) in left.into_iter().zip(memory.end(found, at())?) {
            out[place] = found;
        }
        Ok(out)
    }
}

/// What a braked wheel costs, a driven one being 1: its stresses are integrated in pieces.
const BRAKED: f64 = 3.0;

impl Kind {
    /// What windows must have in common to lie side by side at all.
    pub(super) fn side_by_side(&self) -> (usize, bool) {
        (self.nodes, self.forwards)
    }

    /// Puts those beside each other whose wheels slip the same way.
    pub(super) fn order(&self) -> [bool; 4] {
        self.braked
    }
}

impl abreast::Kind for Kind {
    fn cost(&self) -> f64 {
        let wheel = |braked: &bool| if *braked { BRAKED } else { 1.0 };
        self.nodes as f64 * self.braked.iter().map(wheel).sum::<f64>()
    }

    /// A lane waits for another's braked wheel.
    fn with(&self, other: &Self) -> Option<Self> {
        let braked = std::array::from_fn(|q| self.braked[q] || other.braked[q]);
        let both = Kind { braked, ..*self };
        let alike = Kind { braked, ..*other };
        (both == alike).then_some(both)
    }
}

/// What the last evaluation left.
pub(super) struct Last<'m> {
    pub(super) memory: &'m Memory,
    /// Whether it was at the parameters that are asked for now.
    pub(super) here: bool,
}

impl<'m> Last<'m> {
    fn of(memory: &'m Memory, p: impl Iterator<Item = f64>) -> Self {
        Last {
            memory,
            here: memory.is_at(p),
        }
    }

    /// The same for contacts that are asked themselves: where surfaces stood for them their entry angles are from elsewhere.
    fn beside<T>(self, surfaces: &Surfaces<T>) -> Self {
        Last {
            here: self.here && !surfaces.stood_before(),
            ..self
        }
    }
}

/// Up to eight windows of one kind.
pub(super) struct Group<'a> {
    indices: &'a [usize],
    windows: Vec<&'a Window>,
    pub(super) given: Given<Lanes>,
    pub(super) raw: [Lanes; RAW],
    offsets: Vec<Lanes>,
}

impl<'a> Group<'a> {
    pub(super) fn of(predictor: &'a DrivePredictor, indices: &'a [usize]) -> Self {
        let windows: Vec<&Window> = indices.iter().map(|&i| &predictor.windows[i]).collect();
        let first = windows[0];
        // The last one fills the lanes that are left over.
        let all: [&Window; Lanes::WIDTH] =
            std::array::from_fn(|lane| windows[lane.min(windows.len() - 1)]);
        let gather = |of: &dyn Fn(&Window) -> f64| Lanes::gather(all.iter().map(|w| of(w)));
        Group {
            given: Given {
                pitch: gather(&|w| w.pitch),
                sin_roll: gather(&|w| w.roll.sin()),
                cos_roll: gather(&|w| w.roll.cos()),
                payload: gather(&|w| w.payload),
                earlier_passes: gather(&|w| w.earlier_passes),
                path: gather(&|w| w.path),
                time: gather(&|w| w.time),
                around: std::array::from_fn(|k| gather(&|w| w.around[k])),
                leaning: gather(&|w| w.leaning),
                swing: gather(&|w| w.swing),
                yaw_read: gather(&|w| w.yaw_read()),
                forwards: first.forwards(),
            },
            raw: std::array::from_fn(|k| gather(&|w| w.raw[k])),
            offsets: (0..first.nodes.len())
                .map(|k| gather(&|w| w.nodes[k]))
                .collect(),
            indices,
            windows,
        }
    }

    /// At how many times of a window forces are evaluated.
    pub(super) fn times(&self) -> usize {
        self.offsets.len()
    }

    /// How the vehicle stands at one of these.
    pub(super) fn stance(
        &self,
        predictor: &DrivePredictor,
        law: &Law,
        p: &[Lanes],
        time: usize,
    ) -> Stance<Lanes> {
        let (given, offset) = (&self.given, self.offsets[time]);
        Stance::of(&predictor.vehicle, law, p, given, &self.raw, offset)
    }

    /// The same under a law that leaves it as it is.
    pub(super) fn left(&self, predictor: &DrivePredictor, time: usize) -> Stance<Lanes> {
        let offset = self.offsets[time];
        Stance::left(&predictor.vehicle, &self.given, &self.raw, offset)
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.windows.len()
    }
}

/// Mean readings of windows side by side, where the vehicle stands as it does. `stance`: at each of so many times.
///
/// # Errors
/// Where one of them has no answer.
pub(super) fn readings<T: Abreast, S: Factor<T>, B: Borrow<Stance<S>>>(
    (law, p): (&Law, &[T]),
    given: &Given<S>,
    times: usize,
    stance: impl Fn(usize) -> B,
    windows: &[usize],
    last: &Last<'_>,
    surfaces: &Surfaces<T>,
) -> Result<[T; VALUES], GapError> {
    let mut near = remembered(windows, last);
    let on_wheel = |time: usize, q: usize, stance: &Stance<S>| {
        let (slip, load) = (stance.slip[q].lifted(), stance.load[q].lifted());
        if let Some(forces) = surfaces.forces(&slip, &load) {
            return Ok(forces);
        }
        near[time].forces(law, p, q, stance.contact(q, given))
    };
    let found = DrivePredictor::mean_readings(law, p, given, times, stance, on_wheel)?;
    remember(windows, &near, last.memory);
    Ok(found)
}

/// What is wanted of the residuals of a group's windows.
fn together<T: Abreast, A>(
    asked: &Asked<'_, T>,
    group: &Group<'_>,
    raw: impl Fn(usize, Lanes) -> T,
    of_lane: impl Fn(&T, usize) -> A,
    last: &Last<'_>,
    surfaces: &Surfaces<T>,
) -> Result<Vec<Vec<A>>, GapError>
where
    Lanes: Factor<T>,
{
    let Asked { predictor, law, .. } = *asked;
    let p = &*of_log(law, asked.p, predictor.soils, group.windows[0].log);
    let times = group.times();
    let predicted = if asked.may_vary(p) {
        let given = group.given.map(T::from_primal);
        let raw: [T; RAW] = std::array::from_fn(|k| raw(k, group.raw[k]));
        let stance = |time: usize| {
            let offset = T::from_primal(group.offsets[time]);
            Stance::of(&predictor.vehicle, law, p, &given, &raw, offset)
        };
        readings(
            (law, p),
            &given,
            times,
            stance,
            group.indices,
            last,
            surfaces,
        )?
    } else {
        // Numbers whose derivatives are zero are long to copy.
        let constant: Vec<Lanes> = p.iter().map(|p| p.primal()).collect();
        let stance = |time| group.stance(predictor, law, &constant, time);
        readings(
            (law, p),
            &group.given,
            times,
            stance,
            group.indices,
            last,
            surfaces,
        )?
    };
    let residual: [T; VALUES] = std::array::from_fn(|k| raw(k, group.raw[k]) - predicted[k]);
    let of_window = |(lane, window): (usize, &&Window)| {
        let each = window.measured.iter();
        each.map(|&k| of_lane(&residual[k], lane)).collect()
    };
    Ok(group.windows.iter().enumerate().map(of_window).collect())
}

/// Place of a wheel's contact in a memory.
fn contact(window: usize, node: usize, wheel: usize) -> usize {
    (window * NODES + node) * 4 + wheel
}

/// The entry angles of windows side by side, where all of them are known.
fn remembered(windows: &[usize], last: &Last<'_>) -> [Entries<Lanes>; NODES] {
    let known = |node: usize, wheel: usize| {
        let of = |&window: &usize| last.memory.get(contact(window, node, wheel));
        let all: Option<Vec<f64>> = windows.iter().map(of).collect();
        all.map(|all| side_by_side(&all, |entry| *entry))
    };
    std::array::from_fn(|node| Entries {
        of: std::array::from_fn(|wheel| known(node, wheel)),
        here: last.here,
    })
}

/// Keeps them.
fn remember(windows: &[usize], found: &[Entries<Lanes>; NODES], memory: &Memory) {
    for (node, wheels) in found.iter().enumerate() {
        for (wheel, entries) in wheels.of.iter().enumerate() {
            for (lane, &window) in windows.iter().enumerate() {
                if let Some(entries) = entries {
                    memory.keep(contact(window, node, wheel), entries.lane(lane));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use terra_data::{DriveLog, Segment, Series, parse_rover};
    use terra_model::Registry;

    use super::*;
    use crate::drive::{ROVER, all_windows};

    /// Sixteen seconds of a turn in which the front wheels go from braking to driving and the rear ones the other way, on
    /// several models and with effects at wheel, body and sensor: eight at once give what each gives alone.
    #[test]
    fn windows_abreast_are_windows_alone() {
        let series = |f: &dyn Fn(f64) -> f64| -> Series {
            (0..1600).map(|k| Some(f(0.01 * f64::from(k)))).collect()
        };
        let log = DriveLog {
            time: (0..1600).map(|k| 0.01 * f64::from(k)).collect(),
            ground_speed: Some(series(&|t| 0.8 + 0.01 * t)),
            yaw_rate: Some(series(&|t| 0.2 - 0.02 * t)),
            wheel_torque: Some(std::array::from_fn(|_| series(&|t| 5.0 + t))),
            wheel_speed: std::array::from_fn(|q| {
                let slope = if q < 2 { 0.15 } else { -0.1 };
                series(&|t| 3.2 + slope * (t - 6.0))
            }),
            segments: vec![Segment {
                name: "turn".to_owned(),
                rows: 0..1600,
            }],
            ..DriveLog::default()
        };
        let rover = parse_rover(ROVER, "rover.toml").unwrap();
        let (data, predictor) = all_windows(&log, &rover).unwrap();
        let indices: Vec<usize> = data.observations.iter().map(|o| o.index).collect();
        assert!(indices.len() > 40, "{:?}", data.dropped);
        // Surfaces over three quantities are worth their nodes in a longer log.
        let indices = indices.repeat(6);
        let registry = Registry::builtin();
        let soil = [0.99e3, 1.528e6, 1.1, 1040.0, 0.49, 0.025, 0.18, 0.32];
        let sideways = [
            "skid-steer-lateral-slip",
            "multipass",
            "aero-drag",
            "torque-droop",
        ];
        let smooth = ["slip-sinkage", "mass-error", "torque-droop"];
        for (model, effects, magnitudes) in [
            ("wong-reece", &sideways[..0], vec![]),
            ("wong-reece", &smooth[..], vec![0.2, 0.1, 0.1]),
            ("wong-reece", &["multipass"], vec![0.8]),
            ("wong-reece", &["lateral-contrast"], vec![0.5]),
            (
                "wong-reece",
                &["terrain-drift", "accel-bias"],
                vec![0.4, 0.1],
            ),
            ("wong-reece", &sideways[..], vec![0.5, 0.8, 3.0, 0.1]),
            ("linear-stress", &sideways[1..], vec![0.8, 3.0, 0.1]),
        ] {
            let law = registry.law(model).unwrap();
            let effects = effects.iter().map(|n| registry.effect(n).unwrap());
            let law = law.with_effects(effects).unwrap();
            let p = [&soil[..], &magnitudes].concat();
            let abreast = predictor
                .residuals(&law, &p, &indices, &Memory::none())
                .unwrap();
            // What a fit remembers from nearby changes nothing but the last digits, and which surface was good enough there: each is
            // as near to the law as the other.
            let beside = law.beside_slip_and_load();
            let on_surface = beside.is_some_and(|beside| beside.len() < 2);
            let (same, alike) = if on_surface {
                (3e-4, 1e-3)
            } else {
                (1e-6, 1e-5)
            };
            let memory = Memory::of(predictor.contacts());
            let nearby: Vec<f64> = p.iter().map(|v| 1.02 * v).collect();
            for at in [&nearby, &p, &p] {
                let again = predictor.residuals(&law, at, &indices, &memory).unwrap();
                let anew = predictor.residuals(&law, at, &indices, &Memory::none());
                let both = again.concat().into_iter().zip(anew.unwrap().concat());
                for (a, b) in both {
                    assert!((a - b).abs() < same * (1.0 + b.abs()), "{model}: {a} {b}");
                }
            }
            // Nor does it to slopes, at these very parameters and a little elsewhere.
            for at in [&p, &nearby] {
                let seeded = at.iter().enumerate();
                let seeded: Vec<LaneDual> = seeded
                    .map(|(k, &v)| varying(k, v.into(), &(0..8)))
                    .collect();
                let slopes = |memory: &Memory| {
                    let found = predictor.slopes(&law, &seeded, &(0..0), &indices, memory);
                    found.unwrap().concat()
                };
                let (near, anew) = (slopes(&memory), slopes(&Memory::none()));
                let largest = |k: usize| anew.iter().map(|s| s.slopes[k].abs()).fold(0.0, f64::max);
                let largest: Vec<f64> = (0..8).map(largest).collect();
                for (a, b) in near.iter().zip(&anew) {
                    let value = (a.value - b.value).abs();
                    assert!(value < same * (1.0 + b.value.abs()), "{model}");
                    for (k, largest) in largest.iter().enumerate() {
                        let (a, b) = (a.slopes[k], b.slopes[k]);
                        assert!((a - b).abs() < alike * largest, "{model} {k}: {a} {b}");
                    }
                }
            }
            // Where a surface stands for the wheels, what it says is theirs: 5e-5 of the load at four wheels is at most .0015 of a
            // yaw acceleration, which is known to .03.
            let none = Memory::none();
            let last = Last::of(&none, p.iter().copied());
            let lanes: Vec<Lanes> = p.iter().map(|&v| Lanes::from(v)).collect();
            let frame = predictor.frame(&law, &indices);
            let surfaces =
                Surfaces::of(&predictor, &law, &lanes, &indices, frame.as_deref(), &last);
            assert_eq!(surfaces.any(), on_surface, "{law:?}");
            let within = if surfaces.any() { 3e-4 } else { 1e-7 };
            for (&i, found) in indices.iter().zip(&abreast) {
                let alone = predictor.residual(&law, &p, i, &predictor.raw(i)).unwrap();
                for (a, b) in found.iter().zip(&alone) {
                    assert!(
                        (a - b).abs() < within * (1.0 + b.abs()),
                        "{model} {i}: {a} {b}"
                    );
                }
            }
            // Windows asked by themselves are too few for a surface.
            let seeded = p.iter().enumerate();
            let seeded: Vec<LaneDual> = seeded
                .map(|(k, &v)| varying(k, v.into(), &(2..12)))
                .collect();
            let slopes = |indices: &[usize]| {
                let found = predictor.slopes(&law, &seeded, &(0..0), indices, &Memory::none());
                found.unwrap()
            };
            let all = slopes(&indices);
            let largest = |k: usize| {
                all.concat()
                    .iter()
                    .map(|s| s.slopes[k].abs())
                    .fold(0.0, f64::max)
            };
            let largest: Vec<f64> = (0..LaneDual::SLOPES).map(largest).collect();
            for (&i, all) in indices.iter().zip(&all).step_by(5) {
                for (a, b) in all.iter().zip(&slopes(&[i])[0]) {
                    for (k, largest) in largest.iter().enumerate() {
                        let (a, b) = (a.slopes[k], b.slopes[k]);
                        assert!((a - b).abs() <= 1e-3 * largest, "{model} {i} {k}: {a} {b}");
                    }
                }
            }
        }
    }
}
