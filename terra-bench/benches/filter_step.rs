//! One prediction and one update of the 18-state robot with seven channels.
#![allow(missing_docs)] // the macros of criterion make items of their own
#![allow(clippy::unwrap_used)] // a wrong answer ends the bench

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use terra_bench::filter::{Log, SAMPLES, check_belief};

fn filter_step(c: &mut Criterion) {
    let log = Log::new().unwrap();
    let reference = log.reference(SAMPLES).unwrap();
    let mut group = c.benchmark_group("filter_step");
    group.throughput(Throughput::Elements(1));
    for name in ["block", "kf", "ekf"] {
        let mut filter = log.filter(name, false).unwrap();
        for k in 0..SAMPLES {
            log.step(&mut *filter, k).unwrap();
        }
        check_belief(name, filter.belief(), &reference).unwrap();
        let mut k = SAMPLES;
        group.bench_function(name, |b| {
            b.iter(|| {
                log.step(black_box(&mut *filter), k).unwrap();
                k += 1;
            });
        });
        // The timed steps themselves, as far as the reference filter is worth its time.
        if k <= 20_000 {
            check_belief(name, filter.belief(), &log.reference(k).unwrap()).unwrap();
        }
    }
    let mut lanes = log.lanes().unwrap();
    let mut k = 0;
    group.bench_function("lanes", |b| {
        b.iter(|| {
            log.step_lanes(black_box(&mut lanes), k, false).unwrap();
            k += 1;
        });
    });
    if k <= 20_000 {
        check_belief("lanes", &lanes.belief(), &log.reference(k).unwrap()).unwrap();
    }
    // The robust update weighs samples down, so only the plain filters have a closed reference.
    let mut robust = log.filter("block", true).unwrap();
    let mut k = 0;
    group.bench_function("block, robust", |b| {
        b.iter(|| {
            log.step(black_box(&mut *robust), k).unwrap();
            k += 1;
        });
    });
    group.finish();
}

criterion_group!(benches, filter_step);
criterion_main!(benches);
