//! Point clouds, in builds without a reader of them.

use super::surface::SurfaceOptions;
use crate::city::City;
use crate::crs::VerticalCrs;
use crate::error::{Error, Result, Warning};
use crate::input::Input;

/// Options for reading a point cloud.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointCloudOptions {
    /// Options of any surface model.
    pub surface: SurfaceOptions,
    /// Extent of the grid: west, south, east, north \[CRS units\].
    pub extent: Option<[f64; 4]>,
    /// Cell size \[m\].
    pub cell_m: Option<f64>,
}

/// Refuses a point cloud.
///
/// # Errors
/// E304.
pub fn read_point_cloud(input: impl Into<Input>, _: &PointCloudOptions, _: &mut Vec<Warning>) -> Result<City> {
    Err(Error::unsupported(input.into(), "this build reads no point clouds"))
}

/// Returns no vertical system.
pub(super) fn vertical_of(_: &Input) -> Option<VerticalCrs> {
    None
}
