//! `peers`: one table of all filters, timed in turns in one run. `peers NAME STEPS` runs one of them, to be counted from
//! outside.

use std::hint::black_box;
use std::time::Instant;

use terra_bench::filter::SAMPLES;
use terra_peers::{Failure, check, peers};

/// Turns, and steps of each filter in a turn.
const TURNS: usize = 41;
const STEPS: usize = 1000;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut all = peers()?;
    if let [name, steps] = arguments.as_slice() {
        let peer = all.iter_mut().find(|p| p.name().starts_with(name.as_str()));
        let peer = peer.ok_or("no such filter")?;
        for k in 0..steps.parse()? {
            black_box(&mut *peer).step(k)?;
        }
        return Ok(());
    }
    for peer in &mut all {
        check(&mut **peer)?;
    }
    let mut times = vec![Vec::with_capacity(TURNS); all.len()];
    for _ in 0..TURNS {
        for (peer, times) in all.iter_mut().zip(&mut times) {
            let start = Instant::now();
            for k in 0..STEPS {
                black_box(&mut **peer).step(SAMPLES + k)?;
            }
            times.push(start.elapsed().as_secs_f64() / STEPS as f64);
        }
    }
    let quantile = |times: &mut Vec<f64>, q: f64| {
        times.sort_by(f64::total_cmp);
        times[(q * (TURNS - 1) as f64) as usize]
    };
    let best = quantile(&mut times[0], 0.5);
    println!(
        "{:<34} {:>10} {:>22} {:>8}",
        "filter", "median ns", "quartiles ns", "ratio"
    );
    for (peer, times) in all.iter().zip(&mut times) {
        let [low, middle, high] = [0.25, 0.5, 0.75].map(|q| quantile(times, q));
        println!(
            "{:<34} {:>10.0} {:>10.0} .. {:>8.0} {:>8.1}",
            peer.name(),
            1e9 * middle,
            1e9 * low,
            1e9 * high,
            middle / best
        );
    }
    Ok(())
}
