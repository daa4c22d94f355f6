//! Where a solver ended, contact by contact, for the next time a fit asks for the same contact a little elsewhere.
//!
//! What is kept only tells where a search begins: answers do not depend on it but for less than the solver's tolerance.

use std::sync::atomic::{AtomicU64, Ordering};

/// A number for every contact, none to begin with. A fit owns one, so that nothing depends on what else is fitted meanwhile.
///
/// What is kept during an evaluation is remembered only once all of it has an answer: which contacts are asked behind a failure
/// depends on the threads.
pub(crate) struct Memory {
    remembered: Vec<AtomicU64>,
    kept: Vec<AtomicU64>,
}

/// The bits of no number.
const NOTHING: u64 = f64::NAN.to_bits();

impl Memory {
    /// One that keeps nothing.
    pub(crate) const fn none() -> Self {
        Memory {
            remembered: vec![],
            kept: vec![],
        }
    }

    /// One of so many contacts.
    pub(crate) fn of(contacts: usize) -> Self {
        let nothing = || (0..contacts).map(|_| AtomicU64::new(NOTHING)).collect();
        Memory {
            remembered: nothing(),
            kept: nothing(),
        }
    }

    /// What is remembered; none where nothing is.
    pub(crate) fn get(&self, contact: usize) -> Option<f64> {
        let kept = f64::from_bits(self.remembered.get(contact)?.load(Ordering::Relaxed));
        (!kept.is_nan()).then_some(kept)
    }

    /// Keeps a number, to be remembered when the evaluation has ended.
    pub(crate) fn keep(&self, contact: usize, number: f64) {
        if let Some(place) = self.kept.get(contact) {
            place.store(number.to_bits(), Ordering::Relaxed);
        }
    }

    /// Ends an evaluation: what was kept is remembered where it has an answer, else forgotten.
    pub(crate) fn end<A, E>(&self, evaluated: Result<A, E>) -> Result<A, E> {
        let (from, to) = match &evaluated {
            Ok(_) => (&self.kept, &self.remembered),
            Err(_) => (&self.remembered, &self.kept),
        };
        for (from, to) in from.iter().zip(to) {
            to.store(from.load(Ordering::Relaxed), Ordering::Relaxed);
        }
        evaluated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An evaluation that fails leaves what the one before it knew, whatever it came to first.
    #[test]
    fn a_failed_evaluation_leaves_no_trace() {
        let memory = Memory::of(2);
        let all = || [memory.get(0), memory.get(1)];
        memory.keep(0, 1.0);
        assert_eq!(all(), [None, None]);
        assert_eq!(memory.end(Ok::<_, ()>(7)), Ok(7));
        assert_eq!(all(), [Some(1.0), None]);
        memory.keep(0, 2.0);
        memory.keep(1, 3.0);
        assert_eq!(memory.end(Err::<(), _>("no answer")), Err("no answer"));
        assert_eq!(all(), [Some(1.0), None]);
        assert_eq!(memory.end(Ok::<_, ()>(())), Ok(()));
        assert_eq!(all(), [Some(1.0), None]);
    }
}
