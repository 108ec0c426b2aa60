//! What is learned with the engines: how likely line of sight is, where to hover, what a method costs and errs.

pub mod accuracy;
pub mod city_statistics;
pub mod error;
pub mod los_probability;
pub mod placement;

pub use error::{Error, Result};

use skyshed_core::{city, coverage, height_field, los, outlines, overlay, quadrature, quantity, raster, zones};
