//! A straight line through counts: the claim O(N) as numbers.
//!
//! # Equation
//! Least squares of y = a + b x; R² = 1 - Σ(y - a - b x)² / Σ(y - mean y)².

/// y = a + b x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    /// a.
    pub(crate) intercept: f64,
    /// b.
    pub(crate) slope: f64,
    /// R².
    pub(crate) determination: f64,
}

/// The line through two points or more with distinct x.
pub(crate) fn line(points: &[(f64, f64)]) -> Line {
    let n = points.len() as f64;
    let mean_x = points.iter().map(|p| p.0).sum::<f64>() / n;
    let mean_y = points.iter().map(|p| p.1).sum::<f64>() / n;
    let sum = |f: &dyn Fn(f64, f64) -> f64| {
        points
            .iter()
            .map(|&(x, y)| f(x - mean_x, y - mean_y))
            .sum::<f64>()
    };
    let slope = sum(&|x, y| x * y) / sum(&|x, _| x * x);
    let left = sum(&|x, y| (y - slope * x).powi(2));
    Line {
        intercept: mean_y - slope * mean_x,
        slope,
        determination: 1.0 - left / sum(&|_, y| y * y),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_again_and_a_parabola_is_not_a_line() {
        let xs = [21.0, 1e3, 1e4, 1e5];
        let exact = line(&xs.map(|x| (x, 310.0 + 9.5 * x)));
        assert!((exact.intercept - 310.0).abs() < 1e-6 && (exact.slope - 9.5).abs() < 1e-12);
        assert!(exact.determination > 1.0 - 1e-12);
        assert!(line(&xs.map(|x| (x, x * x))).determination < 0.9999);
        assert!(line(&xs.map(|x| (x, x * x.ln()))).determination < 0.9999);
    }
}
