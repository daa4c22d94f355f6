//! One sample under the fused pass: look-up of N soils' forces, likelihood, evidence, weights.
//!
//! For one wheel the same job written by hand runs beside it: ratios belong to one run.
#![allow(missing_docs)] // the macros of criterion make items of their own
#![allow(clippy::unwrap_used)] // a wrong answer ends the bench

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use terra_bench::fused::{BLOCK, Fused, Wheels};
use terra_bench::hand::Hand;

const SIZES: [usize; 3] = [21, 1_000, 10_000];
/// Up to here each answer is held against Bayes' rule by one hypothesis after the other.
const CHECKED: usize = 1_000;

fn fused_pass(c: &mut Criterion) {
    for (name, wheels) in [("wheel", Wheels::One), ("side", Wheels::Side)] {
        let mut group = c.benchmark_group(format!("fused_pass/{name}"));
        for n in SIZES {
            if n <= CHECKED {
                Fused::check(n, wheels).unwrap();
            }
            let mut set = Fused::new(n, wheels).unwrap();
            group.throughput(Throughput::Elements(n as u64));
            group.bench_function(BenchmarkId::new("sample", n), |b| {
                b.iter(|| black_box(&mut set).step().unwrap());
            });
            if wheels == Wheels::One {
                let covariance = set.hold().unwrap();
                group.bench_function(BenchmarkId::new("held", n), |b| {
                    b.iter(|| black_box(&mut set).step_held(&covariance).unwrap());
                });
                group.bench_function(BenchmarkId::new("held_with_mean", n), |b| {
                    b.iter(|| {
                        black_box(&mut set)
                            .step_held_with_mean(&covariance)
                            .unwrap()
                    });
                });
                if n <= CHECKED {
                    Hand::check(n).unwrap();
                }
                let mut hand = Hand::new(n).unwrap();
                group.bench_function(BenchmarkId::new("by_hand", n), |b| {
                    b.iter(|| black_box(&mut hand).step());
                });
                group.bench_function(BenchmarkId::new("by_hand_with_mean", n), |b| {
                    b.iter(|| black_box(&mut hand).step_with_mean());
                });
            }
            // Blocks begin where the log does: a set that has seen single samples stands elsewhere in it.
            let mut blocks = Fused::new(n, wheels).unwrap();
            group.throughput(Throughput::Elements((n * BLOCK) as u64));
            group.bench_function(BenchmarkId::new("block", n), |b| {
                b.iter(|| black_box(&mut blocks).block().unwrap());
            });
        }
        group.finish();
    }
}

criterion_group!(benches, fused_pass);
criterion_main!(benches);
