//! A bounded choice of a log's windows: every kind of motion stays, what is frequent is thinned.
//!
//! Windows are sorted by how the vehicle moved (slip, turning, direction, speed, slope, payload, pass). When there are more
//! than are wanted, the kind that has most gives up every second one of its own, from the first to the last of the log.
//! Rare motion is kept whole that way, time and path are covered evenly, and nothing but the motion decides: what was
//! measured does not. Memory is that of the windows kept, whatever the log's length.

use std::collections::BTreeMap;

use super::window::Taken;

/// Why a window is left out that others stand for.
pub(crate) const ALIKE: &str =
    "others of the same motion stand for it (as many windows as asked for)";

/// Width of a kind of motion in slip.
const SLIP: f64 = 0.1;
/// Speed of one side against the vehicle's from which it turns, as a share of the vehicle's speed.
const TURN: f64 = 0.1;
/// Width in pitch \[rad\].
const PITCH: f64 = 0.05;

/// A kind of motion, in whole steps of each of its quantities.
type Kind = [i64; 7];

fn kind(taken: &Taken, track: f64) -> Kind {
    let factor = |name: &str| {
        let f = taken.observation.factors.get(name);
        f.copied().unwrap_or_default()
    };
    let speed = factor("speed");
    let side = 0.5 * track * factor("yaw_rate") / speed;
    let turn = if side.abs() < TURN {
        0.0
    } else {
        side.signum()
    };
    let whole = |x: f64| x.round() as i64;
    [
        whole(factor("slip") / SLIP),
        whole(turn),
        whole(speed.signum()),
        whole(speed.abs().log2()),
        whole(taken.window.pitch / PITCH),
        i64::from(taken.window.payload > 0.0),
        whole(taken.window.earlier_passes),
    ]
}

#[derive(Clone, Debug)]
struct Stratum {
    /// One window in so many is kept.
    stride: usize,
    seen: usize,
    /// With their place among all windows offered.
    kept: Vec<(usize, Taken)>,
}

/// Windows, at most so many of them.
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    most: usize,
    track: f64,
    strata: BTreeMap<Kind, Stratum>,
    kept: usize,
    offered: usize,
}

impl Choice {
    /// At most `most` windows (at least one) of a vehicle with this track \[m\].
    pub(crate) fn new(most: usize, track: f64) -> Self {
        Choice {
            most: most.max(1),
            track,
            strata: BTreeMap::new(),
            kept: 0,
            offered: 0,
        }
    }

    /// The next window of the log.
    pub(crate) fn offer(&mut self, taken: Taken) {
        let stratum = self
            .strata
            .entry(kind(&taken, self.track))
            .or_insert(Stratum {
                stride: 1,
                seen: 0,
                kept: vec![],
            });
        if stratum.seen.is_multiple_of(stratum.stride) {
            stratum.kept.push((self.offered, taken));
            self.kept += 1;
        }
        stratum.seen += 1;
        self.offered += 1;
        while self.kept > self.most {
            self.thin();
        }
    }

    /// The largest kind, the first of equals, gives up every second window; where each has one, the last kind its own.
    fn thin(&mut self) {
        let largest = self.strata.values().map(|s| s.kept.len()).max();
        let mut strata = self.strata.values_mut();
        let thinned = match largest {
            Some(n) if n > 1 => strata.find(|s| s.kept.len() == n),
            _ => strata.rfind(|s| !s.kept.is_empty()),
        };
        let Some(stratum) = thinned else { return };
        let before = stratum.kept.len();
        if before > 1 {
            let mut number = 0;
            stratum.kept.retain(|_| {
                number += 1;
                number % 2 == 1
            });
        } else {
            stratum.kept.clear();
        }
        stratum.stride *= 2;
        self.kept -= before - stratum.kept.len();
    }

    pub(crate) fn len(&self) -> usize {
        self.kept
    }

    /// How many windows were offered and are not kept.
    pub(crate) fn left_out(&self) -> usize {
        self.offered - self.kept
    }

    /// The windows kept, in their order.
    pub(crate) fn into_windows(self) -> impl Iterator<Item = Taken> {
        let strata = self.strata.into_values();
        let mut all: Vec<(usize, Taken)> = strata.flat_map(|s| s.kept).collect();
        all.sort_by_key(|(order, _)| *order);
        all.into_iter().map(|(_, taken)| taken)
    }
}

#[cfg(test)]
mod tests {
    use crate::drive::{DriveWindows, ROVER};
    use terra_data::{DriveLog, Segment, Series, parse_rover};

    /// A log of windows of twenty rows that drive at a slip each, straight, at .4 m/s.
    fn log(slips: &[f64]) -> DriveLog {
        let mut log = DriveLog::default();
        let (mut wheel, mut same, mut torque) =
            (Series::default(), Series::default(), Series::default());
        for (k, slip) in slips.iter().enumerate() {
            for j in 0..20 {
                log.time.push(0.01 * (20 * k + j) as f64);
                // Readings that scatter alike in every window: none counts as bent.
                let noise = if j % 2 == 0 { 1e-3 } else { -1e-3 };
                wheel.push(Some(0.4 / (1.0 - slip) / 0.25 + noise));
                same.push(Some(0.4 + noise));
                torque.push(Some(5.0 + noise));
            }
        }
        log.segments = vec![Segment {
            name: "all".to_owned(),
            rows: 0..log.time.len(),
        }];
        log.wheel_speed = std::array::from_fn(|_| wheel.clone());
        log.wheel_torque = Some(std::array::from_fn(|_| torque.clone()));
        log.ground_speed = Some(same);
        log
    }

    fn times(slips: &[f64], most: usize) -> Vec<(f64, f64)> {
        let rover = parse_rover(ROVER, "rover.toml").unwrap();
        let windows = DriveWindows::of(&log(slips), &rover, most).unwrap();
        let logs = crate::logs::Logs::one(&windows);
        let (data, _) = crate::drive::from_logs(&logs, &rover, most).unwrap();
        assert!(data.observations.len() <= most);
        let used: usize = data.dropped.values().sum();
        assert_eq!(data.observations.len() + used, slips.len());
        let factor = |o: &crate::dataset::Observation| (o.factors["time"], o.factors["slip"]);
        data.observations.iter().map(factor).collect()
    }

    /// Four windows of high slip among a thousand of low slip, of which fifty are wanted: the four stay, and the others are
    /// taken evenly from the whole log. A manoeuvre's first window is never used.
    #[test]
    fn rare_motion_stays_and_frequent_motion_is_thinned_evenly() {
        let rare = [100, 101, 700, 999];
        let slips: Vec<f64> = (0..1000)
            .map(|k| if rare.contains(&k) { 0.6 } else { 0.1 })
            .collect();
        let kept = times(&slips, 50);
        let high: Vec<f64> = kept.iter().filter(|k| k.1 > 0.5).map(|k| k.0).collect();
        let expected = rare.map(|k| 0.2 * f64::from(k) + 0.1);
        assert_eq!(high.len(), 4);
        assert!(high.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9));
        let low: Vec<f64> = kept.iter().filter(|k| k.1 < 0.5).map(|k| k.0).collect();
        // Every 32nd of 995 is 32 of them: every 16th would be 63.
        assert_eq!(low.len(), 32);
        let steps = low.windows(2).map(|w| w[1] - w[0]);
        for step in steps {
            assert!((step - 6.4).abs() < 0.41, "{step}");
        }
        assert!(low[0] < 6.5 && low[31] > 200.0 - 6.5 - 0.4);
    }

    #[test]
    fn what_is_not_more_than_wanted_is_kept_whole() {
        let slips: Vec<f64> = (0..60).map(|k| 0.01 * f64::from(k)).collect();
        assert_eq!(times(&slips, 59).len(), 59);
        assert_eq!(times(&slips, 1000), times(&slips, 59));
    }

    /// More kinds of motion than windows: the number holds all the same.
    #[test]
    fn no_log_holds_more_than_the_number_asked_for() {
        let slips: Vec<f64> = (0..60).map(|k| 0.1 * f64::from(k % 8)).collect();
        assert_eq!(times(&slips, 5).len(), 5);
    }
}
