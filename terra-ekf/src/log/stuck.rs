//! Sensors that repeat one reading to the last digit although they have always been noisy.
//!
//! # Equation
//! Of n pairs of consecutive readings e were equal: the chance of another equal pair is p = (e + 1)/(n + 2) (Laplace), so
//! that a run of k equal readings by chance has p^(k-1). The sensor is stuck when that falls below 1e-6 and k >= 4. Only a
//! sensor that has shown noise can be judged: at least 20 pairs, at most a fifth of them equal, and in at least .4 of them
//! a second difference beyond half the sensor's 1-sigma, of the other sign than the one before (.6 in white noise of that
//! size; none on a noise-free ramp, however steep).

/// Chance below which equal readings are no chance.
const CHANCE: f64 = 1e-6;
/// Fewest equal readings that count.
const SHORTEST: usize = 4;
/// Pairs after which old ones begin to count half: sensors change their behaviour slowly if at all.
const MEMORY: f64 = 400.0;

/// One channel.
#[derive(Clone, Copy, Debug, Default)]
struct Sensor {
    last: Option<f64>,
    /// 1-sigma of a reading.
    sd: f64,
    step: f64,
    bend: f64,
    pairs: f64,
    equal: f64,
    turns: f64,
    run: usize,
}

impl Sensor {
    fn noisy(&self) -> bool {
        self.pairs >= 20.0 && self.equal <= 0.2 * self.pairs && self.turns >= 0.4 * self.pairs
    }

    /// Equal readings that are no chance.
    fn limit(&self) -> usize {
        let p = (self.equal + 1.0) / (self.pairs + 2.0);
        SHORTEST.max(1 + (CHANCE.ln() / p.ln()).ceil() as usize)
    }

    fn observe(&mut self, value: f64, moving: bool) -> bool {
        let Some(last) = self.last.replace(value) else {
            self.run = 1;
            return false;
        };
        if value == last {
            self.run += 1;
            // Many sensors read exactly zero at rest, noisy as they are in motion.
            return self.noisy() && self.run >= self.limit() && (value != 0.0 || moving);
        }
        // A run that was judged says nothing about the sensor's ways.
        if self.run > 1 && !(self.noisy() && self.run >= self.limit()) {
            self.equal += (self.run - 1) as f64;
            self.pairs += (self.run - 1) as f64;
        }
        self.run = 1;
        self.pairs += 1.0;
        let step = value - last;
        let bend = step - self.step;
        if bend * self.bend < 0.0 && bend.abs() > 0.5 * self.sd {
            self.turns += 1.0;
        }
        (self.step, self.bend) = (step, bend);
        if self.pairs > MEMORY {
            self.pairs *= 0.5;
            self.equal *= 0.5;
            self.turns *= 0.5;
        }
        false
    }
}

/// All channels of a log, over all of its segments.
#[derive(Clone, Debug)]
pub(super) struct StuckWatch {
    sensors: Vec<Sensor>,
}

impl StuckWatch {
    /// Sensors with the given 1-sigma of a reading.
    pub(super) fn new(sd: impl Iterator<Item = f64>) -> Self {
        let sensor = |sd| Sensor {
            sd,
            ..Sensor::default()
        };
        StuckWatch {
            sensors: sd.map(sensor).collect(),
        }
    }

    /// Takes in the next reading of a channel; true while the sensor is stuck. `moving`: the filter says that the robot
    /// drives.
    pub(super) fn observe(&mut self, channel: usize, value: f64, moving: bool) -> bool {
        self.sensors
            .get_mut(channel)
            .is_some_and(|s| s.observe(value, moving))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(k: usize) -> f64 {
        // Golden-ratio sequence: no two alike, turns as often as noise does.
        (k as f64 * 0.618_033_988_749_894_9).fract() - 0.5
    }

    /// 100 unequal pairs: p = 1/102, p^3 < 1e-6 < p^2, so the fourth equal reading is no chance.
    #[test]
    fn a_noisy_sensor_is_judged_at_the_fourth_equal_reading() {
        let mut w = StuckWatch::new([0.3].into_iter());
        for k in 0..101 {
            assert!(!w.observe(0, noise(k), true));
        }
        let stuck: Vec<bool> = (0..10).map(|_| w.observe(0, noise(100), true)).collect();
        assert_eq!(stuck.iter().position(|s| *s), Some(2));
        assert!(stuck[2..].iter().all(|s| *s));
        assert!(!w.observe(0, noise(101), true));
    }

    /// What may repeat itself: a noise-free ramp that ends, a coarse encoder, zeros at rest.
    #[test]
    fn sensors_that_may_repeat_themselves_are_left_alone() {
        let mut w = StuckWatch::new([0.3; 3].into_iter());
        for k in 0..400 {
            let ramp = (1.7 * k as f64).min(340.0);
            let coarse = ((0.01 * k as f64 + 0.3 * noise(k)) / 2.0).round() * 2.0;
            let rest = if k < 200 { 1.0 + noise(k) } else { 0.0 };
            assert!(!w.observe(0, ramp, true), "{k}");
            assert!(!w.observe(1, coarse, true), "{k}");
            assert!(!w.observe(2, rest, k < 200), "{k}");
        }
    }
}
