//! The exact engines of skyshed: obstacles, line of sight, zones of a city, and coverage maps.
//!
//! Nothing here reads a file, a clock or the environment. Data flows one way:
//!
//! 1. A [`city`] becomes a [`height_field`]: everything a ray can hit, on an integer lattice.
//! 2. [`los`] decides line of sight exactly. It holds the only definition of line of sight.
//! 3. [`zones`] separates streets, crossroads, courtyards and rooftops.
//! 4. [`coverage`] makes maps.

pub mod coverage;
pub mod disjoint_sets;
pub mod error;
pub mod height_field;
pub mod los;
pub mod outlines;
pub mod overlay;
pub mod quadrature;
pub mod quantity;
pub mod raster;
pub mod simd;
pub mod words;
pub mod city;
pub mod zones;

pub use error::{Error, ErrorKind, Result, Warning};
