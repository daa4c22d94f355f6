//! The command as its users meet it: what it writes, what it says, how it ends.

// A failed expectation should stop the test, and skips belong in its output.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod bad_input;
mod bevameter;
#[cfg(unix)]
mod book;
mod cases;
mod challenge;
mod cite;
mod corpus;
mod demo;
mod drive;
mod export;
mod gap;
mod identifiability;
mod init;
mod inspect;
mod lists;
mod missing;
mod own_soils;
mod reverse;
mod rig;
mod rig_mistakes;
mod same_bytes;
mod streams;
mod support;
mod sweep;
mod wheel;
