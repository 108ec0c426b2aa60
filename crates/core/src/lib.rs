//! The exact engines of skyshed: what stands in the way, who sees whom, which cells are streets, and maps of it.
//!
//! Nothing here reads a file, a clock or the environment. Data flows one way: a [`city`] becomes a [`height_field`], what a
//! ray can hit, on an integer lattice; [`los`] decides who sees whom, exactly; [`zones`] tells streets, crossroads,
//! courtyards and rooftops apart; [`coverage`] makes maps. What line of sight means is written once, in [`los`].

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
pub mod city;
pub mod zones;

pub use error::{Error, ErrorClass, Result, Warning};
