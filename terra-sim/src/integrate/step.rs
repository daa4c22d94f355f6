//! The solution inside a step of Dormand and Prince.
//!
//! # Equation
//! With θ = (t - t0)/h, d = y1 - y0, a = h k1 - d, b = d - h k7 - a, c = h Σ d_i k_i:
//! y(θ) = y0 + θ (d + (1 - θ) (a + θ (b + (1 - θ) c))), of order 4, meeting both ends with value and slope.
//!
//! # Reference
//! Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed., II.6 (the extension of their DOPRI5).

/// d_i of k1, k3, k4, k5, k6, k7.
const WEIGHTS: [f64; 6] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

/// A step that was taken.
#[derive(Clone, Debug)]
pub(crate) struct Step<const N: usize> {
    from: f64,
    length: f64,
    states: [[f64; N]; 2],
    /// k1, k3, k4, k5, k6, k7.
    rates: [[f64; N]; 6],
}

impl<const N: usize> Step<N> {
    /// From time and length, the states at its ends, and k1, k3, k4, k5, k6, k7.
    pub(super) fn new(
        from: f64,
        length: f64,
        states: [&[f64; N]; 2],
        rates: [&[f64; N]; 6],
    ) -> Self {
        Step {
            from,
            length,
            states: states.map(|y| *y),
            rates: rates.map(|k| *k),
        }
    }

    /// When it began.
    pub(crate) fn begin(&self) -> f64 {
        self.from
    }

    /// When it ended.
    pub(crate) fn end(&self) -> f64 {
        self.from + self.length
    }

    /// The state at its end.
    pub(crate) fn last(&self) -> &[f64; N] {
        &self.states[1]
    }

    /// The rate at its end.
    pub(super) fn last_rate(&self) -> &[f64; N] {
        &self.rates[5]
    }

    /// The state at a time inside.
    pub(crate) fn at(&self, time: f64) -> [f64; N] {
        let theta = (time - self.from) / self.length;
        let rest = 1.0 - theta;
        let [old, new] = &self.states;
        let h = self.length;
        std::array::from_fn(|i| {
            let k = self.rates.each_ref().map(|k| k[i]);
            let d = new[i] - old[i];
            let a = h * k[0] - d;
            let b = d - h * k[5] - a;
            let c = h * k.iter().zip(WEIGHTS).map(|(k, w)| k * w).sum::<f64>();
            old[i] + theta * (d + rest * (a + theta * (b + rest * c)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::DormandPrince;
    use super::super::dormand_prince::Pace;

    /// y' = y over one step of h: the error inside the step falls with the fifth power of h, and ends meet.
    #[test]
    fn inside_a_step_the_order_is_four() {
        let error = |h: f64| {
            let method = DormandPrince {
                relative: 1.0,
                absolute: 1.0,
                max_step: h,
            };
            let mut worst: f64 = 0.0;
            let mut y = [1.0];
            let mut steps = 0;
            method
                .through(
                    1,
                    &mut Pace::starting_with(h),
                    &mut |_, y: &[f64; 1]| Ok([y[0]]),
                    0.0,
                    h,
                    &mut y,
                    &mut |step| {
                        steps += 1;
                        assert!((step.at(0.0)[0] - 1.0).abs() < 1e-15);
                        assert!((step.at(h)[0] - step.last()[0]).abs() < 1e-15);
                        for k in 1..10 {
                            let t = h * f64::from(k) / 10.0;
                            worst = worst.max((step.at(t)[0] - t.exp()).abs());
                        }
                        Ok(false)
                    },
                )
                .unwrap();
            assert_eq!(steps, 1);
            worst
        };
        let order = (error(0.1) / error(0.05)).log2();
        assert!((order - 5.0).abs() < 0.3, "order {order}");
    }
}
