//! Work on many things at once; what hands it out is compiled once, not for every kind of work.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

/// What comes of the numbers below `count`, in their order.
pub(crate) fn for_each<R: Send + Sync>(count: usize, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let results: Vec<OnceLock<R>> = (0..count).map(|_| OnceLock::new()).collect();
    hand_out(count, &|k| {
        results[k].get_or_init(|| work(k));
    });
    results
        .into_iter()
        .filter_map(OnceLock::into_inner)
        .collect()
}

/// The same of work that may fail: nothing is begun behind a failure.
///
/// # Errors
/// That of the least number that fails, whoever is first.
pub(crate) fn try_for_each<R: Send + Sync, E: Send + Sync>(
    count: usize,
    work: impl Fn(usize) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let failed = AtomicUsize::new(count);
    let done = for_each(count, |k| {
        if k > failed.load(Ordering::Relaxed) {
            return None;
        }
        let result = work(k);
        if result.is_err() {
            failed.fetch_min(k, Ordering::Relaxed);
        }
        Some(result)
    });
    // What was left undone stands behind a failure.
    done.into_iter().flatten().collect()
}

/// Work that hands out work many times over, among the threads it is handed out to: to wait for them from outside is dear.
pub(crate) fn among_them<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    if rayon::current_num_threads() == 1 {
        return work();
    }
    rayon::scope(|_| work())
}

fn hand_out(count: usize, work: &(dyn Fn(usize) + Sync)) {
    // To wake one other thread, and to wait for it, costs more than many a piece of this work.
    if count < 2 || rayon::current_num_threads() == 1 {
        (0..count).for_each(work);
    } else {
        (0..count).into_par_iter().for_each(work);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers in their order; of several failures the first by number, and nothing is begun behind it by one thread.
    #[test]
    fn the_first_failure_by_number_is_told() {
        let square = |k: usize| Ok::<_, usize>(k * k);
        assert_eq!(try_for_each(4, square), Ok(vec![0, 1, 4, 9]));
        let begun = AtomicUsize::new(0);
        let fails = |k: usize| {
            begun.fetch_add(1, Ordering::Relaxed);
            if k % 40 == 39 { Err(k) } else { Ok(k) }
        };
        assert_eq!(try_for_each(1000, fails), Err(39));
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        begun.store(0, Ordering::Relaxed);
        let found = one.unwrap().install(|| try_for_each(1000, fails));
        assert_eq!(found, Err(39));
        assert_eq!(begun.into_inner(), 40);
    }
}
