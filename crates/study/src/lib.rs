//! Studies that use the engines: the probability of line of sight, the placement of UAVs, and the
//! cost and error of methods.

pub mod accuracy;
pub mod city_statistics;
pub mod error;
pub mod los_probability;
pub mod placement;

pub use error::{Error, Result};

use skyshed_core::{city, coverage, height_field, los, outlines, overlay, quadrature, quantity, raster, zones};
