//! Physics against numbers that do not come from this code.

// A failed expectation should stop the test, and figures and skips belong in its output.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod common;
mod facts;
mod reference_wheel;
mod second_method;
mod terrains;
