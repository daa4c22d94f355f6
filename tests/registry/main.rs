//! Any with any: what is registered works with everything else that is registered, and so does what a user adds.

// A failed expectation should stop the test, and skips belong in its output.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod dependencies;
mod filters;
mod models;
mod own;
mod support;
