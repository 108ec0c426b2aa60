//! Errors of maps.

use std::borrow::Cow;

use super::kind::ErrorKind;
use crate::overlay::Tangle;
use crate::quantity::MAX_EXTENT_UNITS;

/// The reason why the requested map cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum MapError {
    /// The method cannot decide this scene: the property that the scene lacks, and a method that
    /// decides it.
    #[error("the method that was asked for cannot decide this scene: {why}")]
    Method { why: &'static str, instead: Cow<'static, str> },
    /// Layers of heights, which are exact, requested with an approximate method.
    #[error("layers of heights with `{method}`, which is approximate: they are exact, and would not agree")]
    ApproximateLayers { method: Cow<'static, str> },
    /// Probabilities of line of sight requested for a scene that does not separate buildings.
    #[error("probabilities of line of sight of a raster, whose buildings are not told apart")]
    RasterProbabilities,
    /// Errors of heights that are no lengths, are not one per building, or move a roof beyond ±32
    /// 768 m.
    #[error(
        "errors of heights that cannot be: wanted lengths of 0 m or more, one for each building, that leave all roofs within ±32768 m"
    )]
    HeightErrors,
    /// Roofs that slope over a curved earth.
    #[error("roofs that slope over a curved earth, wanted flat ones there")]
    CurvedSlopes,
    /// A curvature so strong that heights would leave the lattice: the drop of the earth within
    /// range \[m\].
    #[error(
        "within range the earth would fall away by {0:.0} m, wanted at most what leaves all heights within ±32768 m"
    )]
    TooCurved(f64),
    /// The method needs the whole scene in memory.
    #[error("the method that was asked for cannot decide this scene, which does not fit in memory")]
    StreamedMethod,
    /// Least UAV heights, stability and zones need the whole scene in memory.
    #[error("least UAV heights, stability and zones need the whole scene in memory, in which it does not fit")]
    StreamedLayers,
    /// More cells a side than the lattice has.
    #[error("cannot map {n_cols} × {n_rows} cells strip by strip: wanted at most {MAX_EXTENT_UNITS} a side")]
    StreamedCells { n_cols: usize, n_rows: usize },
    /// Outlines of buildings that cross one another too often to be joined: the reason to join them.
    #[error("cannot {attempt}: the buildings have {tangle}")]
    Tangled { attempt: &'static str, tangle: Tangle },
}

impl MapError {
    pub(super) fn class_and_code(&self) -> (ErrorKind, u16) {
        match self {
            MapError::StreamedCells { .. } => (ErrorKind::Limit, 502),
            MapError::Tangled { .. } => (ErrorKind::Limit, 504),
            _ => (ErrorKind::Usage, 118),
        }
    }
}
