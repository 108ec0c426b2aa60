//! Placements that were compared.

use super::report::CompareReport;
use crate::city::Site;
use crate::coverage::Overlay;
use crate::raster::LargeVec;
use crate::scene::Scene;

/// Placements side by side.
#[derive(Debug)]
pub(crate) struct Comparison {
    pub(super) scene: Scene,
    /// In the order of the report's placements.
    pub(super) masks: Vec<LargeVec<u8>>,
    /// All masks together.
    pub(super) overlay: Overlay,
    pub(super) report: CompareReport,
    /// UAVs as they were asked for: those of the first placements; all later ones are saved masks.
    pub(super) uavs: Vec<Site>,
    /// Words of the scene and how it is read.
    pub(super) scene_words: Vec<String>,
}
