//! Cross-structure trials: the ground follows one wheel law, the simulator that is diagnosed another.
//!
//! The honest stand-in for an outside simulator or a real rig. Each case is a rig's programme on a soil of structure A, once
//! as the outside simulator made it and once with something more; structure B diagnoses the second log, with the first as a
//! baseline and without, and structure A diagnoses it too, to show what sharing the law is worth.

mod draw;
mod figures;

pub(crate) use draw::{Case, Programme};
pub(crate) use figures::{Answer, Marked, figures};

use serde::{Deserialize, Serialize};

/// What the ground has beside the outside simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Truth {
    /// Nothing.
    None,
    /// Something is wrong with an instrument or a measure of the rig.
    Instrument,
    /// The soil is another.
    Soil,
    /// A physical effect in the form that the diagnosis knows.
    Physical,
    /// A physical effect in a form that the diagnosis does not know.
    OtherForm,
}

/// Structures that can be the truth and the nominal simulator.
pub(crate) const STRUCTURES: [&str; 3] = ["wong-reece", "linear-stress", "scm-column"];
