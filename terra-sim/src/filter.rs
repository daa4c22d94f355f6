//! A filter of first order.
//!
//! # Equation
//! c u' = v - u; where v = a + b t between two times, u(t) - v(t) + b c decays by exp(-t/c)

/// Longest time \[s\] over which the input is taken as straight.
const SPACING: f64 = 1e-3;

/// Follows an input with a time constant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Filter {
    constant: f64,
    /// When the run began, where the filter is in it, and what it says there.
    now: Option<[f64; 3]>,
}

impl Filter {
    /// With a constant of 0 it says what it is told.
    pub(crate) fn new(constant: f64) -> Self {
        Filter {
            constant,
            now: None,
        }
    }

    /// What it says at `time`, not before the last one asked for, in the run that `began` then with the filter settled.
    pub(crate) fn follow(&mut self, time: f64, began: f64, input: impl Fn(f64) -> f64) -> f64 {
        if self.constant <= 0.0 {
            return input(time);
        }
        let before = self.now.filter(|[run, ..]| *run == began);
        let [_, from, mut said] = before.unwrap_or_else(|| [began, began, input(began)]);
        let steps = ((time - from) / SPACING).ceil();
        let length = (time - from) / steps;
        let decay = (-length / self.constant).exp();
        let (mut step, mut last) = (1.0, input(from));
        while step <= steps {
            let next = input(from + length * step);
            let lead = (next - last) / length * self.constant;
            said = next - lead + (said - last + lead) * decay;
            last = next;
            step += 1.0;
        }
        self.now = Some([began, time, said]);
        said
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Behind a ramp it comes to lag by its constant, u = b (t - c (1 - exp(-t/c))), and with the next run it begins anew.
    #[test]
    fn a_ramp_is_followed_at_a_distance() {
        let (slope, constant) = (2.0, 0.1);
        let mut filter = Filter::new(constant);
        for began in [0.0, 7.0] {
            for t in [0.0, 0.01, 0.05, 0.3] {
                let said = filter.follow(began + t, began, |time| slope * (time - began));
                let expected = slope * (t - constant * (1.0 - f64::exp(-t / constant)));
                assert!((said - expected).abs() < 1e-12, "{t} {said} {expected}");
            }
        }
        assert_eq!(Filter::new(0.0).follow(3.0, 0.0, |t| t), 3.0);
    }
}
