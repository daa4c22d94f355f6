//! The readers against files as users make them: the good, the bad and the measured.
#![allow(clippy::unwrap_used, clippy::panic)]

mod bad_catalogues;
mod bad_logs;
mod bad_rovers;
#[cfg(feature = "mcap")]
mod bags;
mod blocks;
mod cmu;
mod columns;
mod formats;
mod good_rovers;
mod import;
mod rig;
mod robust;
mod round_trip;
mod support;
