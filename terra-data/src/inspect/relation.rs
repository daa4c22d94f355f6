//! How quantities of a log go together.

/// Fewest rows that say anything.
pub(super) const FEW: usize = 20;
/// The same of means over pieces of a log, whose noise is small.
const FEW_PIECES: usize = 8;
/// A correlation beyond this is a relation.
pub(super) const RELATED: f64 = 0.5;
/// Standard errors by which one of few pieces must differ from none.
const SURE: f64 = 4.0;

/// Sums of two quantities that come row by row.
#[derive(Clone, Copy, Default)]
pub(super) struct Relation {
    pub(super) rows: usize,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Relation {
    pub(super) fn see(&mut self, x: f64, y: f64) {
        self.rows += 1;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    /// Correlation about zero, as of quantities that vanish together, and the slope of y by x; none where one never moves.
    pub(super) fn through_zero(&self) -> Option<(f64, f64)> {
        let &Relation {
            rows, xx, xy, yy, ..
        } = self;
        (rows >= FEW && xx > 0.0 && yy > 0.0).then(|| (xy / (xx * yy).sqrt(), xy / xx))
    }

    /// Root mean square of the second.
    pub(super) fn size(&self) -> f64 {
        (self.yy / self.rows.max(1) as f64).sqrt()
    }

    /// Covariance of the two.
    fn together(&self) -> f64 {
        let n = self.rows as f64;
        self.xy / n - self.x / n * (self.y / n)
    }
}

/// Sums of three quantities that come row by row.
#[derive(Clone, Copy, Default)]
pub(super) struct Three {
    pairs: [Relation; 3],
    squares: [Relation; 3],
}

/// What two quantities have to do with each other once the third is accounted for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Partial {
    pub(super) correlation: f64,
    /// Of the second by the first.
    pub(super) slope: f64,
    sure: bool,
}

impl Partial {
    /// They go together, beyond chance.
    pub(super) fn together(&self) -> bool {
        self.sure && self.correlation > RELATED
    }

    /// One falls as the other rises, beyond chance.
    pub(super) fn against(&self) -> bool {
        self.sure && self.correlation < -RELATED
    }
}

impl Three {
    pub(super) fn see(&mut self, values: [f64; 3]) {
        for k in 0..3 {
            self.squares[k].see(values[k], values[k]);
            // Pair k is of the two others.
            self.pairs[k].see(values[(k + 1) % 3], values[(k + 2) % 3]);
        }
    }

    pub(super) fn rows(&self) -> usize {
        self.squares[0].rows
    }

    /// Quantities `first` and `second`, the one that is left accounted for; none of few rows or of one that never moves.
    pub(super) fn partial(&self, first: usize, second: usize) -> Option<Partial> {
        let rest = 3 - first - second;
        let of = |a: usize, b: usize| match a == b {
            true => self.squares[a].together(),
            false => self.pairs[3 - a - b].together(),
        };
        let fixed = of(rest, rest);
        let given = |a: usize, b: usize| match fixed > 0.0 {
            true => of(a, b) - of(a, rest) * of(b, rest) / fixed,
            false => of(a, b),
        };
        let (xx, xy, yy) = (
            given(first, first),
            given(first, second),
            given(second, second),
        );
        // What is left of a quantity that follows the third exactly is rounding.
        let moves = |left: f64, whole: f64| left > 1e-9 * whole && whole > 0.0;
        let n = self.rows();
        if n < FEW_PIECES || !moves(xx, of(first, first)) || !moves(yy, of(second, second)) {
            return None;
        }
        let correlation = xy / (xx * yy).sqrt();
        let noise = (1.0 - correlation * correlation).max(0.0) / (n as f64 - 3.0);
        Some(Partial {
            correlation,
            slope: xy / xx,
            sure: correlation.abs() > SURE * noise.sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = 2 x - 3 z: each is seen once the other is accounted for.
    #[test]
    fn what_the_third_does_is_accounted_for() {
        let mut seen = Three::default();
        for k in 0..200 {
            let t = f64::from(k);
            let (x, z) = ((0.7 * t).sin(), (0.3 * t).cos());
            let noise = 0.01 * (1.9 * t).sin();
            seen.see([x, 2.0 * x - 3.0 * z + noise, z]);
        }
        let by_x = seen.partial(0, 1).unwrap();
        assert!(
            (by_x.slope - 2.0).abs() < 0.01 && by_x.together(),
            "{by_x:?}"
        );
        let by_z = seen.partial(2, 1).unwrap();
        assert!(
            (by_z.slope + 3.0).abs() < 0.01 && by_z.against(),
            "{by_z:?}"
        );
        let mut alone = Three::default();
        (0..200).for_each(|k| alone.see([f64::from(k), 5.0 - 2.0 * f64::from(k), 1.0]));
        let plain = alone.partial(0, 1).unwrap();
        assert!(
            (plain.slope + 2.0).abs() < 1e-9 && plain.against(),
            "{plain:?}"
        );
        assert!(alone.partial(0, 2).is_none());
    }
}
