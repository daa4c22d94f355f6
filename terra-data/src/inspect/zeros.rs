//! Zeros that stand for samples which are missing.

use super::Suspicion;

/// Share of a channel's root mean square from which no sample falls to exactly nothing, and comes back, by itself.
const FAR: f64 = 0.5;
/// Rows that a hole has at most: what is longer may be a stop.
const LONGEST: usize = 25;
/// Holes, and share of the rows in them, from which it is asked.
const ENOUGH: (usize, f64) = (5, 0.005);

/// What a channel's samples show of it, one after the other.
#[derive(Default)]
pub(super) struct Zeros {
    /// Of samples that are something.
    squares: f64,
    samples: usize,
    last: f64,
    /// Zeros in a row, where they began far from nothing.
    open: usize,
    holes: usize,
    rows: usize,
}

impl Zeros {
    /// A segment begins.
    pub(super) fn begin(&mut self) {
        (self.last, self.open) = (0.0, 0);
    }

    /// Takes a sample in; a missing one is none.
    pub(super) fn see(&mut self, value: Option<f64>) {
        let Some(x) = value else { return };
        let far = |x: f64| {
            let mean_square = self.squares / self.samples.max(1) as f64;
            x * x > FAR * FAR * mean_square
        };
        if x == 0.0 {
            let begins = self.last != 0.0 && far(self.last);
            self.open += usize::from(self.open > 0 || begins);
        } else {
            if self.open > 0 && self.open <= LONGEST && far(x) {
                self.holes += 1;
                self.rows += self.open;
            }
            self.open = 0;
            self.squares += x * x;
            self.samples += 1;
        }
        self.last = x;
    }

    pub(super) fn suspicion(&self, name: &str, rows: usize) -> Option<Suspicion> {
        let (holes, share) = ENOUGH;
        (self.holes >= holes && self.rows as f64 > share * rows as f64).then(|| Suspicion {
            code: "zeros",
            message: format!(
                "{name} falls to exactly 0 and back {} times, in {} rows: zeros written for missing samples? Leave such cells empty",
                self.holes, self.rows
            ),
        })
    }
}
