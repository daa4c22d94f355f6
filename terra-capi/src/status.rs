//! How a call ended, and its message.

use std::cell::RefCell;
use std::ffi::{CStr, CString};
use std::panic::{AssertUnwindSafe, catch_unwind};

use terra_model::ModelError;

/// How a call ended.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TerraStatus {
    /// Done.
    Ok = 0,
    /// The soil cannot carry the load; the forces are NaN.
    NoEquilibrium = 1,
    /// A parameter or a quantity of the contact is out of range.
    OutOfRange = 2,
    /// No model, effect, terrain or parameter has that name.
    UnknownName = 3,
    /// Model and effects do not go together, or the terrain lacks a value that the model needs.
    NotApplicable = 4,
    /// The iteration for the sinkage did not settle.
    NotConverged = 5,
    /// A null pointer, or text that is not UTF-8.
    BadPointer = 6,
    /// A fault of terra itself.
    Internal = 7,
}

/// A status with its message.
pub(crate) struct Failure(pub(crate) TerraStatus, pub(crate) String);

impl From<ModelError> for Failure {
    fn from(e: ModelError) -> Self {
        Failure(status(&e), e.to_string())
    }
}

/// The status of a model's error.
pub(crate) fn status(e: &ModelError) -> TerraStatus {
    match e {
        ModelError::NoEquilibrium { .. } => TerraStatus::NoEquilibrium,
        ModelError::Parameter { .. }
        | ModelError::Contact { .. }
        | ModelError::OutsideMap { .. }
        | ModelError::ParameterCount { .. } => TerraStatus::OutOfRange,
        ModelError::UnknownName { .. } => TerraStatus::UnknownName,
        ModelError::EffectNotApplicable { .. }
        | ModelError::SoilUnknown { .. }
        | ModelError::EffectTwice { .. }
        | ModelError::Combination { .. }
        | ModelError::MissingValue { .. } => TerraStatus::NotApplicable,
        ModelError::NotConverged { .. } => TerraStatus::NotConverged,
        _ => TerraStatus::Internal,
    }
}

thread_local! {
    static MESSAGE: RefCell<CString> = RefCell::new(CString::default());
}

/// Runs a call: its status, and its message kept for this thread. A panic becomes a status.
pub(crate) fn guarded(call: impl FnOnce() -> Result<(), Failure>) -> TerraStatus {
    // A panic leaves behind a law with one parameter set or not, and places for answers: nothing that could break.
    let (status, message) = match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(())) => (TerraStatus::Ok, String::new()),
        Ok(Err(Failure(status, message))) => (status, message),
        Err(_) => (TerraStatus::Internal, "a fault of terra itself".to_owned()),
    };
    // Names come from C, so they hold no NUL; a message that did would be kept as an empty one.
    MESSAGE.with(|m| *m.borrow_mut() = CString::new(message).unwrap_or_default());
    status
}

/// Uses the message of the last call on this thread.
pub(crate) fn last_message<T>(with: impl FnOnce(&CStr) -> T) -> T {
    MESSAGE.with(|m| with(&m.borrow()))
}
