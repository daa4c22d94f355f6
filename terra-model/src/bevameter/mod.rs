//! Soil from a bevameter: plates pressed into the ground, and rings or blocks sheared on it.
//!
//! A [`Curve`] is one test; [`fit_plates`] finds every pressure-sinkage law from plate tests, [`fit_shear`] every shear law
//! from shear tests. A [`Fits`] says how well each law does, how sure each parameter is, and by name what the tests cannot
//! tell: one plate gives k_c and k_φ only through k_c/b + k_φ, one normal stress gives c and φ only through c + σ tan φ.
//!
//! # Equation
//! Least squares of the stress itself, min Σ (p - f(x))², each test with the same weight: to first order the p²-weighted
//! fit of ln p that Wong recommends. Plates: x is the sinkage z, b the radius of a round plate.
//!
//! Points of one test are anything but independent. With two tests or more an interval is that of the tests: the jackknife
//! that leaves one test out, with Student's t. One test alone has only its residuals, whose correlation from point to point
//! leaves n (1 - ρ)/(1 + ρ) of its n points.
//!
//! # Reference
//! J. Y. Wong, "Data processing methodology in the characterization of the mechanical properties of terrain",
//! J. Terramechanics 17(1):13-41, 1980; B. Efron, *The Jackknife, the Bootstrap and Other Resampling Plans*, SIAM 1982.

mod curve;
mod fit;
mod interval;
mod plate;
mod report;
mod shear;

pub use curve::{Curve, Prepared};
pub use plate::fit_plates;
pub use report::{Estimate, Fits, Interval, LawFit};
pub use shear::fit_shear;
