//! Long work beside the interpreter: other Python threads go on, and Ctrl-C is answered at once.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use terra_cli::tasks::Stop;

/// How long Ctrl-C may go unnoticed.
const GLANCE: Duration = Duration::from_millis(50);

/// Runs `work` on a thread of its own, without the interpreter's lock. A signal's exception (`KeyboardInterrupt`) is
/// raised at once; the work then ends unheard.
///
/// # Errors
/// The exception of a signal handler, or work that ended without an answer.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    run_until(py, move |_| work())
}

/// As [`run`], for work that is done piece by piece: what raises the exception also asks for an end, so that nothing is computed or
/// written any more once the pieces at hand are done.
///
/// # Errors
/// As [`run`].
pub(crate) fn run_until<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Stop) -> T + Send + 'static,
) -> PyResult<T> {
    let stop = Stop::default();
    let told = stop.clone();
    let (tell, mut hear) = channel();
    let worker = thread::Builder::new()
        .name("terra".to_owned())
        .spawn(move || {
            // Nobody listens any more after an interrupt.
            let _ = tell.send(work(&told));
        })
        .map_err(|e| PyRuntimeError::new_err(format!("no thread for the work: {e}")))?;
    loop {
        // The receiver cannot be shared, so it is handed in and out.
        let (heard, back) = py.detach(move || (hear.recv_timeout(GLANCE), hear));
        hear = back;
        match heard {
            Ok(answer) => return Ok(answer),
            Err(RecvTimeoutError::Timeout) => py.check_signals().inspect_err(|_| stop.stop())?,
            Err(RecvTimeoutError::Disconnected) => {
                let why = match worker.join() {
                    Err(e) => e
                        .downcast_ref::<&str>()
                        .map(|s| (*s).to_owned())
                        .or_else(|| e.downcast_ref::<String>().cloned()),
                    Ok(()) => None,
                };
                return Err(PyRuntimeError::new_err(
                    why.unwrap_or_else(|| "the work ended without an answer".to_owned()),
                ));
            }
        }
    }
}
