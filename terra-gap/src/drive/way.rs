//! How far a vehicle is along its way, where its log does not say: by every convention that the ground may know it by.

/// How many ways there are beside the one that is taken first.
pub(super) const OTHERS: usize = 4;
/// What these are.
pub(super) const TOLD: [&str; OTHERS] = [
    "on over all segments, forwards and back alike",
    "from the beginning of each segment, forwards and back alike",
    "on over all segments, back where the vehicle drives back",
    "from the beginning of each segment, back where the vehicle drives back",
];
/// How many of them, the first, are an odometer's.
pub(super) const ODOMETERS: usize = 2;

/// Axles that roll over a track in one pass of the vehicle, where each is counted.
pub(super) const AXLES: f64 = 2.0;
/// What is said then.
pub(super) const BY_AXLES: &str = "once for each axle that rolled over the track";

/// Metres by which two ways may differ that are one, but for where they begin: the ground starts from any soil.
const ONE: f64 = 0.1;

/// Whether two ways of the same windows are one.
pub(super) fn are_one(a: &[f64], b: &[f64]) -> bool {
    let apart = a.iter().zip(b).map(|(a, b)| a - b);
    let (low, high) = apart.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), by| {
        (low.min(by), high.max(by))
    });
    high - low < ONE
}

/// Where a window lies \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Along {
    /// By the way that is taken first: back where the vehicle drives back, and from where it was set down last.
    pub(super) run: f64,
    /// By [`TOLD`].
    pub(super) others: [f64; OTHERS],
}

impl Along {
    /// As a log tells it.
    pub(super) fn told(path: f64) -> Self {
        Along {
            run: path,
            others: [path; OTHERS],
        }
    }
}

/// The way so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Way {
    run: f64,
    others: [f64; OTHERS],
}

impl Way {
    /// A segment begins; `set_down`: elsewhere.
    pub(super) fn begin_segment(&mut self, set_down: bool) {
        if set_down {
            self.run = 0.0;
        }
        (self.others[1], self.others[3]) = (0.0, 0.0);
    }

    /// Goes on by so much, and gives the middle of that.
    pub(super) fn drive(&mut self, by: f64) -> Along {
        let middle = |sum: &mut f64, by: f64| {
            let middle = *sum + 0.5 * by;
            *sum += by;
            middle
        };
        let steps = [by.abs(), by.abs(), by, by];
        let run = middle(&mut self.run, by);
        let mut others = steps;
        for (sum, step) in self.others.iter_mut().zip(&mut others) {
            *step = middle(sum, *step);
        }
        Along { run, others }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Another beginning is no other way; another turn is.
    #[test]
    fn ways_are_one_that_only_begin_elsewhere() {
        assert!(are_one(&[0.0, 1.0, 3.0], &[5.0, 6.0, 8.05]));
        assert!(!are_one(&[0.0, 1.0, 3.0], &[0.0, 1.0, -3.0]));
    }

    /// 2 m ahead, a segment 1 m back that goes on from there, and one of 3 m ahead from elsewhere.
    #[test]
    fn each_way_begins_and_turns_as_it_says() {
        let mut way = Way::default();
        way.begin_segment(true);
        assert_eq!(way.drive(2.0), Along::told(1.0));
        way.begin_segment(false);
        let back = way.drive(-1.0);
        assert_eq!(back.run, 1.5);
        assert_eq!(back.others, [2.5, 0.5, 1.5, -0.5]);
        way.begin_segment(true);
        let elsewhere = way.drive(3.0);
        assert_eq!(elsewhere.run, 1.5);
        assert_eq!(elsewhere.others, [4.5, 1.5, 2.5, 1.5]);
    }
}
