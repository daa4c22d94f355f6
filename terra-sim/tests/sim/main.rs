//! The simulator against closed forms, conservation laws and published statements.

#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod closed_forms;
mod conservation;
mod cost;
mod drive_signatures;
mod effects;
mod manoeuvres;
mod motors;
mod noise;
mod paper;
mod planar;
mod rig;
mod scenario;
mod signatures;
mod steps;
mod support;
mod traces;
mod world;
