//! The claims of terra-ekf, each from its theorem, reference value or measured figure.

#![allow(clippy::unwrap_used, clippy::panic)]

mod changes;
mod common;
mod consistency;
mod driving;
mod equivalence;
mod faults;
mod lanes;
mod logs;
mod nonlinear;
mod observability;
mod particle;
mod passes;
mod planar;
mod propositions;
mod random;
