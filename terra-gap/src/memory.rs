//! Where a solver ended, contact by contact, for the next time a fit asks for the same contact a little elsewhere.
//!
//! What is kept only tells where a search begins: answers do not depend on it but for less than the solver's tolerance.

use std::sync::atomic::{AtomicU64, Ordering};

/// A number for every contact, none to begin with. A fit owns one, so that nothing depends on what else is fitted meanwhile.
pub(crate) struct Memory(Vec<AtomicU64>);

/// The bits of no number.
const NOTHING: u64 = f64::NAN.to_bits();

impl Memory {
    /// One that keeps nothing.
    pub(crate) const fn none() -> Self {
        Memory(vec![])
    }

    /// One of so many contacts.
    pub(crate) fn of(contacts: usize) -> Self {
        Memory((0..contacts).map(|_| AtomicU64::new(NOTHING)).collect())
    }

    /// What was kept last; none where nothing was.
    pub(crate) fn get(&self, contact: usize) -> Option<f64> {
        let kept = f64::from_bits(self.0.get(contact)?.load(Ordering::Relaxed));
        (!kept.is_nan()).then_some(kept)
    }

    /// Keeps a number.
    pub(crate) fn keep(&self, contact: usize, number: f64) {
        if let Some(place) = self.0.get(contact) {
            place.store(number.to_bits(), Ordering::Relaxed);
        }
    }
}
