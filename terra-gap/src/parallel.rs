//! Work on many things at once; what hands it out is compiled once, not for every kind of work.

use std::sync::OnceLock;

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

fn hand_out(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(work);
}
