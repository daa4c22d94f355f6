//! What forces does a wheel get from the ground?
//!
//! A [`TerrainModel`] answers that for one wheel: slip, load and geometry in (a [`Contact`]), drawbar pull,
//! resistive torque and sinkage out ([`WheelForces`]). An [`Effect`] is one thing the model leaves out (a rut,
//! a grouser, a scale error of a sensor). A [`Law`] is a model with any effects on top, and [`ForceLaw`] is what
//! every solver of terra sees of it, exact derivatives included.
//!
//! Authors write one generic function over [`Real`]; the [`Registry`] finds their work by name, and [`conformance`]
//! tells them whether it keeps what solvers rely on. [`catalogue`] holds the soils of the literature, [`split`] turns
//! measured forces into thrust and resistance without any soil model. This crate has no file access, no randomness and
//! no threads.
//!
//! # Units and signs
//! SI and radians throughout. Drawbar pull is positive forward, torque positive where it resists the drive, side force
//! and slip angle positive to the left, sinkage positive down. Slip is in \[-1, 1\]: driving 1 - v/(R ω), braking
//! R ω/v - 1.
//!
//! # Errors
//! A result is a finite number or a [`ModelError`] with the numbers inside. A load that the soil cannot carry is
//! [`ModelError::NoEquilibrium`] with the largest it can; nothing is clamped. What is a number but should be read with
//! care (braking, sinkage beyond half the radius) carries [`Flags`].
//!
//! # Accuracy
//! The Wong-Reece wheel agrees with a 30-digit computation to 1e-11 in entry angle, pull and torque, and with adaptive
//! quadrature to 2e-8 with effects inside the integral, locked wheels and a shear modulus of .2 mm included. Alone it is
//! solved by sixteen nodes a branch ([`models::Accuracy::Fine`], 1e-12 driving), in a [`Batch`] by eight (1e-7) or in single
//! precision (1e-5); a [`ForceMap`] carries the error it was found to have.
//!
//! ```
//! use terra_model::{Contact, ForceLaw, Registry, catalogue};
//! let law = Registry::builtin().law("wong-reece+slip-sinkage")?;
//! let mut p = catalogue::find("dry_sand")?.parameters(law.model())?;
//! p.push(0.0); // the magnitude of slip-sinkage
//! let f = law.forces(&p, &Contact::new(0.2, 245.25, 0.254, 0.15))?;
//! assert!((f.drawbar_pull - 8.3).abs() < 0.05);
//! # Ok::<(), terra_model::ModelError>(())
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::panic))]

mod batch;
pub mod bevameter;
pub mod catalogue;
pub mod conformance;
mod contact;
mod dual;
mod effect;
pub mod effects;
mod error;
mod forces;
mod guard;
mod lanes;
mod law;
mod lugs;
mod maps;
mod model;
pub mod models;
mod names;
pub mod order;
mod param;
mod quadrature;
mod real;
mod registry;
mod root;
mod scalar;
mod slip;
pub mod split;
mod stress;
mod vehicle;

pub use batch::{Batch, BatchForces, Precision};
pub use contact::{Contact, Hook, Hooks};
pub use dual::{Dual8, jacobian};
pub use effect::{AnyEffect, Channel, Circumstance, Effect, EffectAt, Late, Scope, Touch};
pub use error::ModelError;
pub use forces::{Angles, Contributions, Flags, WheelForces};
pub use lanes::{Abreast, LaneDual, Lanes, Lanes32, Vector};
pub use law::{ForceLaw, Law};
pub use lugs::LugPhase;
pub use maps::{
    Beside, BicubicMap, ForceMap, ForceSurface, MapError, MapRange, MapSlopes, SurfaceContacts,
    SurfaceNodes, SurfacePlace,
};
pub use model::{AnyModel, ForceSlopes, ModelAt, Soil, TerrainModel};
pub use names::nearest;
pub use param::{Param, Scale, natural_size, natural_symbol};
pub use real::{Real, Root};
pub use registry::Registry;
pub use scalar::Scalar;
pub use slip::{STANDSTILL_SPEED, SlipConvention, library_slip, slip_from_speeds};
pub use stress::{StressField, StressPoint, StressProfile};
pub use vehicle::{BodyLoads, Motion, Vehicle};
