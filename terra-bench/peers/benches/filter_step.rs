//! All filters in one criterion run, each checked first.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use terra_bench::filter::SAMPLES;
use terra_peers::{check, peers};

fn filter_step(c: &mut Criterion) {
    let mut group = c.benchmark_group("filter_step");
    for mut peer in peers().unwrap() {
        check(&mut *peer).unwrap();
        let mut k = SAMPLES;
        group.bench_function(peer.name(), |b| {
            b.iter(|| {
                black_box(&mut *peer).step(k).unwrap();
                k += 1;
            });
        });
    }
    group.finish();
}

criterion_group!(benches, filter_step);
criterion_main!(benches);
