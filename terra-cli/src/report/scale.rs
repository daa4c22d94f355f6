//! Axes: ranges and round ticks.

use super::number::number;
use super::words::unit_suffix;

/// One axis of a figure.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// Quantity and unit.
    pub(super) title: String,
    /// First and last value shown.
    pub(super) range: (f64, f64),
    /// Where ticks stand, and what they say.
    pub(super) ticks: Vec<(f64, String)>,
    /// Name of the quantity in SI, as a column of a log has it.
    name: String,
    /// Unit it is shown in.
    pub(super) unit: String,
    /// Shown value of one SI unit.
    pub(super) factor: f64,
    /// Whether the axis shows log10 of the shown value.
    pub(super) log: bool,
}

impl Axis {
    /// A linear axis over the finite values, a little wider than they are, with about `count` ticks.
    pub(super) fn over(
        title: impl Into<String>,
        values: impl IntoIterator<Item = f64>,
        count: usize,
    ) -> Self {
        let (low, high) = extent(values);
        let pad = 0.06 * (high - low);
        Axis::linear(title, (low - pad, high + pad), count)
    }

    /// A linear axis from `range.0` to `range.1`.
    pub(super) fn linear(title: impl Into<String>, range: (f64, f64), count: usize) -> Self {
        let step = round_step((range.1 - range.0) / count.max(1) as f64);
        let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        let (first, last) = (
            (range.0 / step - 1e-9).ceil() as i64,
            (range.1 / step + 1e-9).floor() as i64,
        );
        let ticks = (first..=last)
            .map(|k| {
                let value = k as f64 * step;
                let text = if step >= 1e5 {
                    number(value, 3)
                } else {
                    format!("{value:.decimals$}").replace('-', "\u{2212}")
                };
                (value, text)
            })
            .collect();
        Axis {
            title: title.into(),
            range,
            ticks,
            name: String::new(),
            unit: String::new(),
            factor: 1.0,
            log: false,
        }
    }

    /// Rows from the top down, the first at 0, without ticks: each says itself what it is.
    pub(super) fn rows(count: f64) -> Self {
        Axis {
            ticks: vec![],
            ..Axis::linear("", (count - 0.5, -0.5), 1)
        }
    }

    /// What is drawn along it: a column name in SI (`sinkage_m`), the unit shown, and the shown value of one SI unit.
    pub(super) fn named(self, name: &str, unit: &str, factor: f64) -> Self {
        Axis {
            name: name.to_owned(),
            unit: unit.to_owned(),
            factor,
            ..self
        }
    }

    /// Where an SI value stands, in the coordinate of `range`.
    pub(super) fn place(&self, si: f64) -> f64 {
        let shown = si * self.factor;
        if self.log { shown.log10() } else { shown }
    }

    /// Its column of a table.
    pub(super) fn column(&self) -> String {
        self.name.clone()
    }

    /// The column of its 1-sigma: `drawbar_pull_sd_N`.
    pub(super) fn sd_column(&self) -> String {
        let (stem, unit) = unit_suffix(&self.name);
        format!("{stem}_sd{unit}")
    }

    /// An axis of log10(value), from `low` to `high`, labelled with the values.
    pub(super) fn logarithmic(title: impl Into<String>, low: f64, high: f64) -> Self {
        let (low, high) = (low.log10(), high.log10());
        let steps: &[f64] = match high - low {
            d if d < 1.2 => &[1.0, 2.0, 5.0],
            d if d < 2.6 => &[1.0, 3.0],
            _ => &[1.0],
        };
        let every = (((high - low) / 6.0).ceil() as i32).max(1);
        let ticks = (low.floor() as i32..=high.ceil() as i32)
            .filter(|decade| decade.rem_euclid(every) == 0)
            .flat_map(|decade| steps.iter().map(move |s| s * 10f64.powi(decade)))
            .map(|v| (v.log10(), number(v, 1)))
            .filter(|(at, _)| (low - 1e-9..=high + 1e-9).contains(at))
            .collect();
        Axis {
            title: title.into(),
            range: (low, high),
            ticks,
            name: String::new(),
            unit: String::new(),
            factor: 1.0,
            log: true,
        }
    }
}

/// Smallest and largest finite value; something to stand on where there is none, or only one.
fn extent(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .into_iter()
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(v), b.max(v))
        });
    if low > high {
        return (0.0, 1.0);
    }
    let least = 1e-9 + 1e-6 * low.abs().max(high.abs());
    if high - low < least {
        let half = 0.5 * low.abs().max(1e-6);
        return (low - half, high + half);
    }
    (low, high)
}

/// The one of 1, 2 or 5 times a power of ten whose ratio to `raw` is nearest to one.
fn round_step(raw: f64) -> f64 {
    if !(raw.is_finite() && raw > 0.0) {
        return 1.0;
    }
    let power = 10f64.powf(raw.log10().floor());
    let lead = raw / power;
    power
        * match lead {
            l if l < 2f64.sqrt() => 1.0,
            l if l < 10f64.sqrt() => 2.0,
            l if l < 50f64.sqrt() => 5.0,
            _ => 10.0,
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|t| t.1.as_str()).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(
            texts(&Axis::linear("", (0.0, 0.6), 4)),
            ["0.0", "0.2", "0.4", "0.6"]
        );
        assert_eq!(
            texts(&Axis::linear("", (-7.0, 16.0), 5)),
            ["\u{2212}5", "0", "5", "10", "15"]
        );
        assert_eq!(
            texts(&Axis::logarithmic("", 0.5, 200.0)),
            ["1", "10", "100"]
        );
    }

    #[test]
    fn degenerate_values_still_make_an_axis() {
        for values in [vec![], vec![3.0], vec![f64::NAN], vec![0.0, 0.0]] {
            let axis = Axis::over("", values, 4);
            assert!(axis.range.0 < axis.range.1 && axis.ticks.len() > 1);
        }
    }
}
