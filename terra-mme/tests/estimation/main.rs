//! Claims about weighing hypotheses, tested from their statement: theorems, published figures, stored counterexamples.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod adapting;
mod banks;
mod batch;
mod common;
mod drives;
mod fit;
mod fused;
mod made;
mod mixtures;
mod propositions;
mod refining;
mod rivals;
mod sums;
mod switching;
mod weighing;
