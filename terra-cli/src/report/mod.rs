//! The report a person reads: one HTML file with its figures inside, no script, nothing fetched, fit for paper.
//!
//! A [`Page`] is a list of [`Section`]s; [`gap_section`] tells a diagnosis, [`identify_section`] which soil it is.
//! Figures take their colours from the page's style sheet, so that they follow light, dark and print, and tell series
//! apart by marker and dash as well as by colour.

mod bevameter;
mod block;
mod figure;
mod gap;
mod identify;
mod lines;
mod number;
mod page;
mod paint;
mod profiles;
mod scale;
mod words;

#[cfg(test)]
mod tests;

pub use bevameter::{BevameterView, bevameter_section};
pub use block::Section;
pub use gap::{Curve, GapCurves, Panel, Point, gap_section};
pub use identify::{ForceSlip, GroupView, IdentifyView, identify_section};
pub use page::Page;
pub use profiles::{ProfilesView, profiles_section};

/// Why a report could not be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReportError {
    /// A figure could not be drawn.
    #[error("figure '{title}': {reason}")]
    Figure {
        /// Which one.
        title: String,
        /// What went wrong.
        reason: String,
    },
    /// The page template could not be filled.
    #[error("page template: {0}")]
    Template(String),
}
