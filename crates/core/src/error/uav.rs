//! Errors of UAV positions.

use std::fmt;

use crate::quantity::{Height, MAX_EXTENT_UNITS, tidy};

/// The requested place of a UAV.
#[derive(Debug, Clone, PartialEq)]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum UavAttempt {
    /// A site: a position \[CRS units\] and a height.
    Place { id: String, x: f64, y: f64, height: Height },
    /// A displacement by lattice steps east, north and up.
    Move { id: String, steps: [i64; 3] },
}

impl fmt::Display for UavAttempt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UavAttempt::Place { id, x, y, height } => write!(f, "place UAV `{id}` at ({x}, {y}) with height {height}"),
            UavAttempt::Move { id, steps: [east, north, up] } => {
                write!(f, "move UAV `{id}` by {east}, {north} and {up} steps east, north and up")
            }
        }
    }
}

/// The reason why a UAV cannot be at a place.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum UavError {
    /// The UAV would be inside a building: its height, the roof and, if known, the ground \[m above
    /// the datum\].
    #[error("{} m above the datum is inside a building with its roof at {} m", tidy(*amsl_m), tidy(*roof_m))]
    InsideBuilding { amsl_m: f64, roof_m: f64, ground_m: Option<f64> },
    /// The UAV would be below the ground or the surface: its height, the surface and, if known, the
    /// ground \[m above the datum\].
    #[error("{} m above the datum is below the ground at {} m", tidy(*amsl_m), tidy(*surface_m))]
    BelowGround { amsl_m: f64, surface_m: f64, ground_m: Option<f64> },
    /// The UAV and the cells in its range would span more than the lattice \[units\]. The ranges
    /// are those of the grid \[CRS units\]; `has_crs` is `true` if its CRS is known.
    #[error(
        "with the cells in range it spans {span:.0} units, wanted at most {MAX_EXTENT_UNITS}; the grid reaches over x \
         {}…{}, y {}…{}",
        x_range.0, x_range.1, y_range.0, y_range.1
    )]
    TooFar { span: f64, x_range: (f64, f64), y_range: (f64, f64), has_crs: bool },
    /// The height is above the ground, which is not known there.
    #[error("no ground is known there")]
    NoGround,
    /// The height is above a roof, and the scene knows no buildings.
    #[error("with a surface model alone no roof is known")]
    NoRoofKnown,
    /// The height is above a roof, and no building is there.
    #[error("no building is there, wanted a roof")]
    NoBuilding,
    /// The UAV would be over a nodata cell that blocks everything.
    #[error("it is over a nodata cell, which blocks everything")]
    OverNodata,
    /// The height \[m above the datum\] is beyond the lattice.
    #[error("{amsl_m} m above the datum, wanted within ±32768 m")]
    Height { amsl_m: f64 },
}

impl UavError {
    /// Returns the number of the code.
    pub fn code(&self) -> u16 {
        match self {
            UavError::InsideBuilding { .. } => 201,
            UavError::BelowGround { .. } => 202,
            UavError::TooFar { .. } => 203,
            UavError::NoGround | UavError::NoRoofKnown | UavError::NoBuilding | UavError::OverNodata => 204,
            UavError::Height { .. } => 205,
        }
    }
}
