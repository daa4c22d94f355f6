//! Wong-Reece forces and their exact derivatives over soils x slips x loads.
#![allow(missing_docs)] // the macros of criterion make items of their own
#![allow(clippy::unwrap_used)] // a wrong answer ends the bench

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use terra_bench::many::{Columns, Lookup};
use terra_bench::wheel::{BRAKING, Case, DRIVING, RADIUS, WIDTH, cases};
use terra_model::{Contact, ForceLaw, Law, Precision, Registry, catalogue};

fn all_forces(cases: &[Case]) {
    for case in cases {
        black_box(black_box(case).forces().unwrap());
    }
}

fn all_jacobians(cases: &[Case]) {
    for case in cases {
        black_box(black_box(case).jacobian().unwrap());
    }
}

/// A figure is the time of all rows; the throughput counts solves.
fn forward_solve(c: &mut Criterion) {
    let mut group = c.benchmark_group("forward_solve");
    for (name, rows) in [("driving", DRIVING), ("braking", BRAKING)] {
        let cases = cases(rows).unwrap();
        for case in &cases {
            case.check_forces(&case.forces().unwrap()).unwrap();
            let (forces, jacobian) = case.jacobian().unwrap();
            case.check_jacobian(&forces, &jacobian).unwrap();
        }
        group.throughput(Throughput::Elements(cases.len() as u64));
        group.bench_function(format!("forces/{name}"), |b| b.iter(|| all_forces(&cases)));
        group.bench_function(format!("jacobian/{name}"), |b| {
            b.iter(|| all_jacobians(&cases))
        });
    }
    group.finish();
}

/// Warm starts, batches and look-ups; the throughput counts contacts.
fn in_bulk(c: &mut Criterion) {
    let mut group = c.benchmark_group("forward_solve/bulk");
    let cases = cases(DRIVING).unwrap();
    for case in &cases {
        case.check_forces(&case.warm_forces().unwrap()).unwrap();
    }
    group.throughput(Throughput::Elements(cases.len() as u64));
    group.bench_function("warm", |b| {
        b.iter(|| {
            for case in &cases {
                black_box(black_box(case).warm_forces().unwrap());
            }
        })
    });
    let mut columns = Columns::new().unwrap();
    group.throughput(Throughput::Elements(columns.items() as u64));
    for (name, precision) in [("f64", Precision::Double), ("f32", Precision::Single)] {
        columns.check(precision).unwrap();
        group.bench_function(format!("batch/{name}"), |b| {
            b.iter(|| {
                black_box(columns.solve(precision).unwrap());
            })
        });
    }
    let lookup = Lookup::new().unwrap();
    lookup.check().unwrap();
    group.throughput(Throughput::Elements(lookup.queries() as u64));
    group.bench_function("map", |b| b.iter(|| black_box(&lookup).round().unwrap()));
    group.finish();
}

/// The spread over soils, slips and loads, one figure each.
fn by_contact(c: &mut Criterion) {
    let mut group = c.benchmark_group("forward_solve/by_contact");
    for case in cases(DRIVING).unwrap() {
        case.check_forces(&case.forces().unwrap()).unwrap();
        group.bench_function(case.label(), |b| {
            b.iter(|| black_box(&case).forces().unwrap())
        });
    }
    group.finish();
}

/// Every model on sand or else a soil of its own, driven and braked.
fn by_model(c: &mut Criterion) {
    let mut group = c.benchmark_group("forward_solve/by_model");
    let registry = Registry::builtin();
    let sand = catalogue::find("dry_sand").unwrap();
    for model in registry.models().iter().chain(registry.named_models()) {
        let law = Law::new(model.clone(), vec![]).unwrap();
        let of_its_own = || model.typical_parameters().into_iter().next();
        let p = sand.parameters(&**model).ok().or_else(of_its_own).unwrap();
        for (name, slip) in [("driving", 0.2), ("braking", -0.2)] {
            let at = Contact::new(slip, 100.0, RADIUS, WIDTH);
            // Brixius' equations are for driven wheels.
            if law.forces(&p, &at).is_err() {
                continue;
            }
            group.bench_function(format!("{}/{name}", model.name()), |b| {
                b.iter(|| {
                    black_box(&law)
                        .forces(black_box(&p), black_box(&at))
                        .unwrap()
                })
            });
        }
    }
    group.finish();
}

criterion_group!(benches, forward_solve, in_bulk, by_contact, by_model);
criterion_main!(benches);
