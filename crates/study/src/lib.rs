//! What is learned with the engines: how likely line of sight is, where to hover, what a method costs and errs.

pub mod accuracy;
pub mod los_probability;
pub mod placement;

use skyshed_core::{city, coverage, error, height_field, los, outlines, overlay, quantity, raster, zones};
