//! Heights of two files together: the vertical system of each, and their difference.

use std::fmt::Display;

use super::point_cloud;
use crate::crs::{VerticalCrs, VerticalDifference};
use crate::error::{CombineError, OddPair, Result, Warning};
use crate::format::FileFormat;
use crate::formats::RasterFile;
use crate::input::Input;

/// Returns the vertical system that a raster file or a point cloud names; `None` if it names none,
/// or is neither.
pub fn vertical_of(input: impl Into<Input>) -> Option<VerticalCrs> {
    let input = input.into();
    if FileFormat::of(&input).ok()? == FileFormat::PointCloud {
        return point_cloud::vertical_of(&input);
    }
    RasterFile::open(input, &mut Vec::new()).ok()?.vertical().cloned()
}

/// Origin of the reference system of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SystemSaid {
    /// The files alone.
    ByFiles,
    /// The user, who overrides the files.
    ByUser,
}

/// Compares the vertical systems of a surface and a terrain.
///
/// A warning reports that only one of them names its system, or that their datums differ (W370,
/// W371).
///
/// # Errors
/// E311 if one is above an ellipsoid and the other above a datum, which are tens of meters apart,
/// unless the user has named the system of the files.
pub fn compare_vertical(
    (a_path, a): (impl Display, Option<&VerticalCrs>),
    (b_path, b): (impl Display, Option<&VerticalCrs>),
    said: SystemSaid,
    warnings: &mut Vec<Warning>,
) -> Result<()> {
    let mut unnamed = |without: &dyn Display, with: &dyn Display, known: &VerticalCrs| {
        let [without, with] = [without, with].map(ToString::to_string);
        warnings.push(OddPair::NoVertical { without, with, taken: known.in_words().to_string() }.into());
        Ok(())
    };
    let (a, b) = match (a, b) {
        (Some(a), Some(b)) => (a, b),
        (None, None) => return Ok(()),
        (Some(known), None) => return unnamed(&b_path, &a_path, known),
        (None, Some(known)) => return unnamed(&a_path, &b_path, known),
    };
    let both = format!("{a_path} with heights above {} and {b_path} with heights above {}", a.in_words(), b.in_words());
    match (a.difference(b), said) {
        (VerticalDifference::None, _) => Ok(()),
        (VerticalDifference::Ellipsoid, SystemSaid::ByFiles) => Err(CombineError::TwoDatums(both).into()),
        (VerticalDifference::Datum | VerticalDifference::Ellipsoid, _) => {
            warnings.push(OddPair::TwoDatums(both).into());
            Ok(())
        }
    }
}
