//! Result of a comparison.

use super::report::CompareReport;
use crate::city::Site;
use crate::coverage::Overlay;
use crate::raster::LargeVec;
use crate::scene::Scene;

/// Comparison of placements.
#[derive(Debug)]
pub(crate) struct Comparison {
    pub(super) scene: Scene,
    /// Masks, in the order of the report's placements.
    pub(super) masks: Vec<LargeVec<u8>>,
    /// Overlay of all masks.
    pub(super) overlay: Overlay,
    pub(super) report: CompareReport,
    /// UAVs as requested. They are the first placements; the later ones are saved masks.
    pub(super) uavs: Vec<Site>,
    /// Words of the scene and of its options.
    pub(super) scene_words: Vec<String>,
}
