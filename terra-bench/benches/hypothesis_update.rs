//! One Bayes step over N hypotheses, grouped by the cache its arrays live in.
//!
//! A rate is only comparable inside one cache: the same N falls into another group on another machine.
#![allow(missing_docs)] // the macros of criterion make items of their own
#![allow(clippy::unwrap_used)] // a wrong answer ends the bench

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use terra_bench::caches::{caches, regime};
use terra_bench::hypotheses::{BYTES_PER_HYPOTHESIS, Hypotheses, check_one_step};

const SIZES: [usize; 6] = [10, 100, 1_000, 10_000, 100_000, 1_000_000];

fn hypothesis_update(c: &mut Criterion) {
    let caches = caches();
    let mut sizes = SIZES.to_vec();
    // Where the caches are large, one size more, so that memory itself is seen.
    if let Some(last) = caches.last()
        && SIZES.iter().all(|n| n * BYTES_PER_HYPOTHESIS <= last.bytes)
    {
        sizes.push((4 * last.bytes / BYTES_PER_HYPOTHESIS).next_multiple_of(1_000_000));
    }
    for n in sizes {
        let bytes = n * BYTES_PER_HYPOTHESIS;
        check_one_step(n).unwrap();
        let mut hypotheses = Hypotheses::new(n);
        let mut group = c.benchmark_group(format!("hypothesis_update/{}", regime(bytes, &caches)));
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(BenchmarkId::new(format!("{bytes} B"), n), |b| {
            b.iter(|| black_box(&mut hypotheses).step().unwrap());
        });
        group.finish();
        hypotheses.check().unwrap();
    }
}

criterion_group!(benches, hypothesis_update);
criterion_main!(benches);
