//! Some values that stand for all of a long log.

use super::KEPT;

/// Up to [`KEPT`] values: all, then every second, every fourth and so on of those there were.
pub(super) struct Thinned<T> {
    pub(super) values: Vec<T>,
    every: usize,
    seen: usize,
}

impl<T> Default for Thinned<T> {
    fn default() -> Self {
        Thinned {
            values: Vec::new(),
            every: 1,
            seen: 0,
        }
    }
}

impl<T> Thinned<T> {
    pub(super) fn see(&mut self, value: T) {
        if self.values.len() == KEPT {
            let mut even = false;
            self.values.retain(|_| {
                even = !even;
                even
            });
            self.every *= 2;
        }
        if self.seen.is_multiple_of(self.every) {
            self.values.push(value);
        }
        self.seen += 1;
    }
}
