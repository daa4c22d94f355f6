//! An effect of one's own: the drawbar load cell sticks a little and reads closer to zero than the truth.

// An example may print, and may stop where it is wrong.
#![allow(clippy::print_stdout)]

use terra::model::{Channel, Effect, ForceLaw, Param, Real, Registry, Scope, Touch};

/// D_reported = D - e tanh(D / 1 N).
#[derive(Default)]
struct StickyLoadCell;

impl Effect for StickyLoadCell {
    const NAME: &'static str = "sticky-load-cell";
    const SUMMARY: &'static str = "the load cell sticks and reads closer to zero";
    const PARAMS: &'static [Param] = &[Param::magnitude(
        "N",
        [0.0, 100.0],
        1.0,
        "force swallowed by friction",
    )];
    const REFERENCE: &'static str = "example";
    const TOUCHES: &'static [Touch] = &[Touch::Sensor];
    const SCOPE: Scope = Scope::Rig;
    const REGIME: &'static str = "pull only, towards zero in both directions";
    const ISOLATED_BY: &'static str = "load and unload the cell with a known weight";

    fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
        if channel == Channel::DrawbarPull {
            truth - e[0] * truth.tanh()
        } else {
            truth
        }
    }
}

fn main() {
    let registry = Registry::builtin().with_effect::<StickyLoadCell>();
    let law = registry
        .law("wong-reece+sticky-load-cell")
        .expect("registered above");
    println!("{} has {} parameters", law.name(), law.params().len());
}

#[test]
fn it_conforms() {
    terra::model::conformance::check_effect::<StickyLoadCell>().expect("conforms");
}
