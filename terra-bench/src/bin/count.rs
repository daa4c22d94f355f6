//! Runs one kernel a given number of times, to be counted from outside: `count KERNEL REPETITIONS`.
//!
//! Prints the number of operations done. Set-up and checks do not depend on the repetitions, so the difference of two
//! runs is the kernel alone; `cargo xtask bench` forms it.
// The number of operations is the output of this program.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::hint::black_box;

use terra_bench::drive::Ramp;
use terra_bench::filter::{Log, SAMPLES, check_belief};
use terra_bench::fused::{BLOCK, Fused, Wheels};
use terra_bench::hand::Hand;
use terra_bench::hypotheses::{Hypotheses, check_one_step};
use terra_bench::many::{Columns, Lookup};
use terra_bench::wheel::{BRAKING, DRIVING, Row, cases};
use terra_model::Precision;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [kernel, repetitions] = arguments.as_slice() else {
        return Err("usage: count KERNEL REPETITIONS".into());
    };
    let repetitions: usize = repetitions.parse()?;
    let operations = match kernel.split_once(':') {
        Some(("hypothesis-update", n)) => hypothesis_update(n.parse()?, repetitions)?,
        Some(("fused-wheel", n)) => fused(n.parse()?, Wheels::One, false, repetitions)?,
        Some(("fused-held", n)) => held(n.parse()?, false, repetitions)?,
        Some(("fused-held-mean", n)) => held(n.parse()?, true, repetitions)?,
        Some(("fused-moving", n)) => fused(n.parse()?, Wheels::Moving, false, repetitions)?,
        Some(("fused", n)) => fused(n.parse()?, Wheels::Side, false, repetitions)?,
        Some(("fused-block", n)) => fused(n.parse()?, Wheels::Side, true, repetitions)?,
        Some(("hand-wheel", n)) => hand(n.parse()?, false, repetitions)?,
        Some(("hand-wheel-mean", n)) => hand(n.parse()?, true, repetitions)?,
        _ => match kernel.as_str() {
            "forward-solve" => forward_solve(DRIVING, repetitions)?,
            "forward-solve-braking" => forward_solve(BRAKING, repetitions)?,
            "forward-solve-warm" => warm_solve(repetitions)?,
            "batch-f64" => batch(Precision::Double, repetitions)?,
            "batch-f32" => batch(Precision::Single, repetitions)?,
            "map" => map(repetitions)?,
            "jacobian" => jacobian(repetitions)?,
            "drive" => drive(&Ramp::plain()?, repetitions)?,
            "drive-log" => drive(&Ramp::full()?, repetitions)?,
            "filter-lanes" => lanes(Told::Nothing, repetitions)?,
            "filter-lanes-scored" => lanes(Told::Score, repetitions)?,
            "filter-lanes-belief" => lanes(Told::Belief, repetitions)?,
            "filter-block" => filter_step("block", false, repetitions)?,
            "filter-block-robust" => filter_step("block", true, repetitions)?,
            "filter-kf" => filter_step("kf", false, repetitions)?,
            "filter-ekf" => filter_step("ekf", false, repetitions)?,
            _ => return Err(format!("no kernel '{kernel}'").into()),
        },
    };
    println!("{operations}");
    Ok(())
}

fn forward_solve(rows: &[Row], repetitions: usize) -> Result<usize, Box<dyn Error>> {
    let cases = cases(rows)?;
    for case in &cases {
        case.check_forces(&case.forces()?)?;
    }
    for _ in 0..repetitions {
        for case in &cases {
            black_box(black_box(case).forces()?);
        }
    }
    Ok(repetitions * cases.len())
}

fn warm_solve(repetitions: usize) -> Result<usize, Box<dyn Error>> {
    let cases = cases(DRIVING)?;
    for case in &cases {
        case.check_forces(&case.warm_forces()?)?;
    }
    for _ in 0..repetitions {
        for case in &cases {
            black_box(black_box(case).warm_forces()?);
        }
    }
    Ok(repetitions * cases.len())
}

fn batch(precision: Precision, repetitions: usize) -> Result<usize, Box<dyn Error>> {
    let mut columns = Columns::new()?;
    columns.check(precision)?;
    for _ in 0..repetitions {
        black_box(black_box(&mut columns).solve(precision)?);
    }
    Ok(repetitions * columns.items())
}

fn map(repetitions: usize) -> Result<usize, Box<dyn Error>> {
    let lookup = Lookup::new()?;
    lookup.check()?;
    for _ in 0..repetitions {
        black_box(black_box(&lookup).round()?);
    }
    Ok(repetitions * lookup.queries())
}

fn jacobian(repetitions: usize) -> Result<usize, Box<dyn Error>> {
    let cases = cases(DRIVING)?;
    for case in &cases {
        let (forces, jacobian) = case.jacobian()?;
        case.check_jacobian(&forces, &jacobian)?;
    }
    for _ in 0..repetitions {
        for case in &cases {
            black_box(black_box(case).jacobian()?);
        }
    }
    Ok(repetitions * cases.len())
}

fn drive(ramp: &Ramp, repetitions: usize) -> Result<usize, Box<dyn Error>> {
    ramp.check()?;
    for _ in 0..repetitions {
        black_box(black_box(ramp).run()?);
    }
    Ok(repetitions)
}

fn filter_step(name: &str, robust: bool, repetitions: usize) -> Result<usize, Box<dyn Error>> {
    let log = Log::new()?;
    let mut plain = log.filter(name, false)?;
    for k in 0..SAMPLES {
        log.step(&mut *plain, k)?;
    }
    check_belief(name, plain.belief(), &log.reference(SAMPLES)?)?;
    let mut filter = log.filter(name, robust)?;
    for k in 0..repetitions {
        log.step(black_box(&mut *filter), k)?;
    }
    black_box(filter.belief());
    Ok(repetitions)
}

/// What is asked of the bare filter at every step, besides the belief in its own places.
#[derive(Clone, Copy, PartialEq)]
enum Told {
    Nothing,
    /// NIS and likelihood of the sample.
    Score,
    /// Mean and covariance of all states in one matrix.
    Belief,
}

fn lanes(told: Told, repetitions: usize) -> Result<usize, Box<dyn Error>> {
    let log = Log::new()?;
    let mut plain = log.lanes()?;
    for k in 0..SAMPLES {
        log.step_lanes(&mut plain, k, told == Told::Score)?;
    }
    let mut belief = plain.belief();
    check_belief("lanes", &belief, &log.reference(SAMPLES)?)?;
    let mut filter = log.lanes()?;
    for k in 0..repetitions {
        black_box(log.step_lanes(black_box(&mut filter), k, told == Told::Score)?);
        if told == Told::Belief {
            filter.belief_into(black_box(&mut belief))?;
        }
    }
    black_box(filter.belief());
    Ok(repetitions)
}

fn hypothesis_update(n: usize, repetitions: usize) -> Result<usize, Box<dyn Error>> {
    check_one_step(n)?;
    let mut hypotheses = Hypotheses::new(n);
    for _ in 0..repetitions {
        black_box(black_box(&mut hypotheses).step()?);
    }
    hypotheses.check()?;
    Ok(repetitions)
}

/// Operations are samples: of a block each counts.
fn fused(
    n: usize,
    wheels: Wheels,
    blocks: bool,
    repetitions: usize,
) -> Result<usize, Box<dyn Error>> {
    Fused::check(n.min(21), wheels)?;
    let mut set = Fused::new(n, wheels)?;
    for _ in 0..repetitions {
        if blocks {
            black_box(&mut set).block()?;
        } else {
            black_box(&mut set).step()?;
        }
    }
    Ok(repetitions * if blocks { BLOCK } else { 1 })
}

fn hand(n: usize, mean: bool, repetitions: usize) -> Result<usize, Box<dyn Error>> {
    Hand::check(n.min(1000))?;
    let mut set = Hand::new(n)?;
    for _ in 0..repetitions {
        if mean {
            black_box(&mut set).step_with_mean();
        } else {
            black_box(&mut set).step();
        }
    }
    black_box(set.log_evidence());
    Ok(repetitions)
}

fn held(n: usize, mean: bool, repetitions: usize) -> Result<usize, Box<dyn Error>> {
    Fused::check(n.min(21), Wheels::One)?;
    let mut set = Fused::new(n, Wheels::One)?;
    let covariance = set.hold()?;
    for _ in 0..repetitions {
        if mean {
            black_box(&mut set).step_held_with_mean(black_box(&covariance))?;
        } else {
            black_box(&mut set).step_held(black_box(&covariance))?;
        }
    }
    Ok(repetitions)
}
