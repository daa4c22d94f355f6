//! Where a solver ended, contact by contact, for the next time a fit asks for the same contact a little elsewhere.
//!
//! What is kept only tells where a search begins: answers do not depend on it but for less than the solver's tolerance.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// A number for every contact, none to begin with. A fit owns one, so that nothing depends on what else is fitted meanwhile.
///
/// What is kept during an evaluation is remembered only once all of it has an answer: which contacts are asked behind a failure
/// depends on the threads.
pub(crate) struct Memory {
    remembered: Vec<AtomicU64>,
    kept: Vec<AtomicU64>,
    /// The law's parameters when the last evaluation ended.
    at: Mutex<Vec<f64>>,
}

/// What a memory held when a fit ended, for others that begin there.
#[derive(Clone, Debug, Default)]
pub(crate) struct Remembered(Option<Arc<(Vec<u64>, Vec<f64>)>>);

/// The bits of no number.
const NOTHING: u64 = f64::NAN.to_bits();

impl Memory {
    /// One that keeps nothing.
    pub(crate) const fn none() -> Self {
        Memory {
            remembered: vec![],
            kept: vec![],
            at: Mutex::new(vec![]),
        }
    }

    /// One of so many contacts.
    pub(crate) fn of(contacts: usize) -> Self {
        Memory::with(vec![NOTHING; contacts], vec![])
    }

    /// One of so many contacts that goes on where another ended.
    pub(crate) fn after(before: &Remembered, contacts: usize) -> Self {
        match before.0.as_deref() {
            Some((numbers, at)) if numbers.len() == contacts => {
                Memory::with(numbers.clone(), at.clone())
            }
            _ => Memory::of(contacts),
        }
    }

    fn with(numbers: Vec<u64>, at: Vec<f64>) -> Self {
        let all = || numbers.iter().map(|n| AtomicU64::new(*n)).collect();
        Memory {
            remembered: all(),
            kept: all(),
            at: Mutex::new(at),
        }
    }

    /// What is remembered now.
    pub(crate) fn remembered(&self) -> Remembered {
        let numbers: Vec<u64> = self.remembered.iter().map(of).collect();
        Remembered((!numbers.is_empty()).then(|| Arc::new((numbers, self.last()))))
    }

    fn last(&self) -> Vec<f64> {
        self.at.lock().map_or_else(|_| vec![], |at| at.clone())
    }

    /// Whether the last evaluation was at these parameters of the law, those of effects that one of both lacks at zero.
    pub(crate) fn is_at(&self, p: impl Iterator<Item = f64>) -> bool {
        let last = self.last();
        let mut both = 0;
        let rest = p.enumerate().all(|(k, p)| {
            both = k + 1;
            last.get(k).map_or(p == 0.0, |last| p == *last)
        });
        !last.is_empty() && rest && last.iter().skip(both).all(|last| *last == 0.0)
    }

    /// What is remembered; none where nothing is.
    pub(crate) fn get(&self, contact: usize) -> Option<f64> {
        let kept = f64::from_bits(of(self.remembered.get(contact)?));
        (!kept.is_nan()).then_some(kept)
    }

    /// Keeps a number, to be remembered when the evaluation has ended.
    pub(crate) fn keep(&self, contact: usize, number: f64) {
        if let Some(place) = self.kept.get(contact) {
            place.store(number.to_bits(), Ordering::Relaxed);
        }
    }

    /// Ends an evaluation at some parameters of the law: what was kept is remembered where it has an answer, else forgotten.
    pub(crate) fn end<A, E>(
        &self,
        evaluated: Result<A, E>,
        p: impl Iterator<Item = f64>,
    ) -> Result<A, E> {
        let (from, to) = match &evaluated {
            Ok(_) => (&self.kept, &self.remembered),
            Err(_) => (&self.remembered, &self.kept),
        };
        for (from, to) in from.iter().zip(to) {
            to.store(of(from), Ordering::Relaxed);
        }
        if evaluated.is_ok()
            && !self.remembered.is_empty()
            && let Ok(mut at) = self.at.lock()
        {
            *at = p.collect();
        }
        evaluated
    }
}

fn of(place: &AtomicU64) -> u64 {
    place.load(Ordering::Relaxed)
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
        let at = |p: f64| [p, 0.5].into_iter();
        assert_eq!(memory.end(Ok::<_, ()>(7), at(1.0)), Ok(7));
        assert_eq!(all(), [Some(1.0), None]);
        memory.keep(0, 2.0);
        memory.keep(1, 3.0);
        assert_eq!(
            memory.end(Err::<(), _>("no answer"), at(2.0)),
            Err("no answer")
        );
        assert!(memory.is_at(at(1.0)) && !memory.is_at(at(2.0)));
        assert_eq!(all(), [Some(1.0), None]);
        assert_eq!(memory.end(Ok::<_, ()>(()), at(3.0)), Ok(()));
        assert_eq!(all(), [Some(1.0), None]);
    }

    /// One that goes on where another ended knows what that knew, and where it was: with more effects at zero, or fewer, still
    /// there. Another number of contacts is another log.
    #[test]
    fn what_a_fit_knew_is_known_where_it_ended() {
        let memory = Memory::of(2);
        assert!(!memory.is_at([1.0, 0.0].into_iter()));
        memory.keep(1, 0.7);
        assert!(memory.end(Ok::<_, ()>(()), [1.0, 0.0].into_iter()).is_ok());
        let after = Memory::after(&memory.remembered(), 2);
        assert_eq!([after.get(0), after.get(1)], [None, Some(0.7)]);
        for there in [&[1.0][..], &[1.0, 0.0], &[1.0, 0.0, 0.0]] {
            assert!(after.is_at(there.iter().copied()), "{there:?}");
        }
        for elsewhere in [&[][..], &[1.1, 0.0], &[1.0, 0.2], &[1.0, 0.0, 0.3]] {
            assert!(!after.is_at(elsewhere.iter().copied()), "{elsewhere:?}");
        }
        let other = Memory::after(&memory.remembered(), 3);
        assert_eq!(other.get(1), None);
    }
}
