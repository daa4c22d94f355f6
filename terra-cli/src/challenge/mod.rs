//! Sealed blind cases: logs whose cause is withheld, the commitment to it, and the marking of the answers.
//!
//! What is withheld is drawn from one seed, so the seed is a secret until the answers are in. The logs hold what the
//! instruments of any run would: nothing in their names, columns, lengths, order or times tells one kind of case from
//! another.

mod answer;
mod baselines;
pub(crate) mod carry;
mod closing;
pub(crate) mod design;
pub(crate) mod draw;
mod held_back;
mod key;
mod library;
mod make;
mod marks;
mod metrics;
pub(crate) mod moving;
pub(crate) mod random;
mod reveal;
mod score;
mod shares;
mod statistics;

pub use design::{DESIGNS, Design};
pub use held_back::{HeldBack, held_back};
pub(crate) use key::read_json;
pub use key::{CaseKey, Gate, KeyCase, KeyFile, SealedDesign, SealedEffect, canonical, digest};
pub use library::{Known, Library};
pub use make::{Challenge, MadeCase, make};
pub use reveal::{Answer as Revealed, reveal};
pub use score::{Options as ScoreOptions, Score, score};
pub use shares::{Kind, Shares};
pub use statistics::Metric;
