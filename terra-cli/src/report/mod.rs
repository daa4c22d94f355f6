//! The report a person reads: one HTML file with its figures inside, nothing fetched, fit for paper.
//!
//! A [`Page`] is a list of [`Section`]s; [`gap_section`] tells a diagnosis, [`identify_section`] which soil it is.
//! Figures take their colours from the page's style sheet, so that they follow light, dark and print, and tell series
//! apart by marker and dash as well as by colour. A small script in the page reads figures out, zooms and saves them;
//! without it nothing is missing but that.

mod bevameter;
mod block;
mod data;
mod estimate;
mod force_slip;
mod gap;
mod graph;
mod identify;
mod lines;
mod number;
mod page;
mod paint;
mod plot;
mod profiles;
mod scale;
mod standalone;
mod stress;
mod svg;
mod wheel;
mod words;

#[cfg(test)]
mod tests;

pub use bevameter::{BevameterView, bevameter_section};
pub use block::Section;
pub use estimate::{Channel, EstimateView, estimate_section};
pub use force_slip::{ForceSlip, MeasuredForces, Value};
pub(crate) use gap::magnitudes;
pub use gap::{Curve, GapCurves, Panel, Point, Stresses, gap_section};
pub use graph::{Graph, GraphAxis, GraphLook, GraphSeries};
pub use identify::{GroupView, IdentifyView, ParameterPath, identify_section};
pub use page::Page;
pub use profiles::{ProfilesView, profiles_section};
pub use standalone::FigureFiles;
pub use wheel::{WheelRow, WheelView, wheel_section};

/// Why a report could not be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReportError {
    /// The page template could not be filled.
    #[error("page template: {0}")]
    Template(String),
}
