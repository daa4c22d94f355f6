//! A sign of life on a terminal, nothing anywhere else; and what ends long work early.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::error::CliError;

/// Ends work that is done piece by piece, after the pieces at hand. Clones are the same one.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Asks for the end.
    pub fn stop(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// # Errors
    /// [`CliError::Stopped`], once the end was asked for.
    pub(crate) fn go_on(&self) -> Result<(), CliError> {
        if self.0.load(Ordering::Relaxed) {
            return Err(CliError::Stopped);
        }
        Ok(())
    }
}

/// Who looks at long work: a person at a terminal, or a program that may end it.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    quiet: bool,
    stop: Stop,
}

impl Watch {
    /// Shown, unless quiet.
    pub(crate) fn shown(quiet: bool) -> Self {
        let stop = Stop::default();
        Watch { quiet, stop }
    }

    /// Never shown, and ended by `stop`.
    pub(crate) fn silent(stop: &Stop) -> Self {
        let stop = stop.clone();
        Watch { quiet: true, stop }
    }

    /// A bar over so many pieces.
    pub(crate) fn bar(&self, total: usize, message: impl Into<String>) -> Bar {
        Bar::start(self.quiet, total, message)
    }

    /// # Errors
    /// [`CliError::Stopped`], once the end was asked for.
    pub(crate) fn go_on(&self) -> Result<(), CliError> {
        self.stop.go_on()
    }
}

/// A spinner with a message on standard error, only on a terminal and unless quiet. Gone when dropped.
pub(crate) struct Spinner(Option<ProgressBar>);

impl Spinner {
    pub(crate) fn start(quiet: bool, message: impl Into<String>) -> Self {
        if quiet || !std::io::stderr().is_terminal() {
            return Spinner(None);
        }
        let bar = ProgressBar::new_spinner().with_message(message.into());
        bar.set_style(
            ProgressStyle::with_template("{spinner} {msg} ({elapsed})")
                .unwrap_or_else(|_| ProgressStyle::default_spinner()),
        );
        bar.enable_steady_tick(Duration::from_millis(120));
        Spinner(Some(bar))
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

/// A bar that counts, on standard error, only on a terminal and unless quiet. Gone when dropped.
pub(crate) struct Bar(Option<ProgressBar>);

impl Bar {
    fn start(quiet: bool, total: usize, message: impl Into<String>) -> Self {
        if quiet || !std::io::stderr().is_terminal() {
            return Bar(None);
        }
        let bar = ProgressBar::new(total as u64).with_message(message.into());
        bar.set_style(
            ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} ({eta} left)")
                .unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        bar.enable_steady_tick(Duration::from_millis(200));
        Bar(Some(bar))
    }

    /// One more is done.
    pub(crate) fn step(&self) {
        if let Some(bar) = &self.0 {
            bar.inc(1);
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}
