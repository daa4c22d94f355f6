//! The figures of L. E. Ray, "Autonomous terrain parameter estimation for wheeled vehicles", Proc. SPIE 2008, drawn anew:
//! forces estimated against slip, parameters and probabilities as they settle, stresses under the wheel.
//!
//! ```sh
//! cargo run --release --example paper_figures -- FOLDER
//! ```
//!
//! writes an SVG and a CSV a figure. What differs from the paper, and why, is in the book ("The paper's figures").

// An example may print, and may stop where it is wrong.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod drives;
mod figures;

#[cfg(test)]
mod tests;

use drives::{Drive, SOILS, Soils, exact, perturbed};

/// Draws of noise, and of perturbed soils, behind a figure.
const DRAWS: u64 = 20;
const SEED: u64 = 1;

fn main() {
    let folder = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "paper-figures".to_owned());
    std::fs::create_dir_all(&folder).expect("a folder that can be written");
    let soils = Soils::of_the_paper();
    for soil in SOILS {
        let exact = drives(soil, |run| exact(&soils, soil, SEED, run));
        let near = drives(soil, |run| perturbed(&soils, soil, SEED, run));
        println!(
            "{soil}: in the set, named after 2 samples {} of {DRAWS}; 10 % off, own copy at the end {} of {DRAWS}",
            exact.iter().filter(|d| d.named(2)).count(),
            near.iter().filter(|d| d.named_at_end()).count(),
        );
        for files in figures::of_soil(&soils, &exact, &near) {
            let path = std::path::Path::new(&folder).join(&files.name);
            std::fs::write(path.with_extension("svg"), &files.svg).expect("written");
            std::fs::write(path.with_extension("csv"), &files.csv).expect("written");
        }
    }
    println!("written to {folder}");
}

/// All draws on one soil.
fn drives(soil: &str, one: impl Fn(u64) -> Drive) -> Vec<Drive> {
    let drives: Vec<Drive> = (0..DRAWS).map(one).collect();
    assert!(
        drives.iter().all(|d| d.soil == soil),
        "every draw drove on {soil}"
    );
    drives
}
