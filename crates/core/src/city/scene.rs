//! A scene as it was given: its grid of receivers, and what stands on which ground.

use std::collections::HashSet;

use super::{Area, BuildingHeight, BuiltUp, Footprint, FootprintFaults, HeightSources};
use crate::quantity::Frame;
use crate::raster::{BitGrid, GeoRef, Raster};

/// A city and the grid of receivers over it.
#[derive(Debug, Clone)]
pub struct City {
    /// What the scene is called in captions: the file name or the generator's parameters.
    pub name: String,
    /// The grid of receivers.
    pub grid: GeoRef,
    /// What stands in the way.
    pub solids: Solids,
    /// The built-up parameters of a generated city.
    pub built_up: Option<BuiltUp>,
    /// The files that the scene was read from.
    pub sources: Vec<Source>,
    /// Whom pictures must credit, where the data say so.
    pub attribution: Option<String>,
    /// Where the heights of footprints come from, of a file of these.
    pub heights: Option<HeightSources>,
}

/// A file that a scene was read from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// As the user gave it.
    pub path: String,
    /// SHA-256 of its bytes in hexadecimal, if it was computed.
    pub sha256: Option<String>,
}

/// The solids of a scene.
#[derive(Debug, Clone)]
pub enum Solids {
    /// Columns over the cells of the grid.
    Raster {
        /// Surface heights \[1/1024 m above the datum\], [`crate::quantity::VOID`] where there is none.
        surface: Raster<i32>,
        /// What receivers stand on.
        ground: Ground,
        /// A cell whose surface is more than this above the ground is a building \[1/1024 m\].
        building_threshold: i32,
        /// The cells whose surface is that of the terrain, because the surface model has none there: what stands on them is
        /// not known, so they hold no receiver.
        voids: Option<BitGrid>,
    },
    /// Prisms over footprints.
    Vector {
        /// The footprints, on the lattice of `frame`.
        footprints: Vec<Footprint>,
        /// The lattice of the footprints: unit 1 m, origin at the grid's south-west corner floored to a whole meter.
        frame: Frame,
        /// What receivers and buildings stand on.
        ground: Ground,
        /// What was mended or left out.
        faults: FootprintFaults,
        /// Where anything is known of the ground.
        data_area: DataArea,
    },
}

impl Solids {
    /// The heights of the buildings of a vector scene and where they stand, of those that have both; none of a raster. Parts of one building are
    /// one, as high as they are in the mean over their areas.
    pub fn building_heights(&self) -> Vec<BuildingHeight> {
        let Solids::Vector { footprints, frame, .. } = self else { return Vec::new() };
        Footprint::building_heights(footprints, *frame)
    }

    /// Number of buildings of a vector scene, where the parts of one are one; 0 of a raster.
    pub fn n_buildings(&self) -> usize {
        let Solids::Vector { footprints, .. } = self else { return 0 };
        let groups: HashSet<u32> = footprints.iter().filter_map(|footprint| footprint.part_of).collect();
        groups.len() + footprints.iter().filter(|footprint| footprint.part_of.is_none()).count()
    }
}

/// Where a vector scene knows the ground. Cells elsewhere hold no data: no receiver, no zone, no candidate.
#[derive(Debug, Clone, Default)]
pub enum DataArea {
    /// Everywhere.
    #[default]
    All,
    /// What is between the footprints: their closing by a disc of 100 m, holes filled. Everywhere, where less than a tenth
    /// of that is open ground.
    NearFootprints,
    /// An area that the user drew.
    Within(Area),
}

/// What stands below the buildings.
#[derive(Debug, Clone)]
pub enum Ground {
    /// Nothing but the surface model is known: receivers stand on the surface.
    Surface,
    /// A horizontal plane \[1/1024 m above the datum\].
    Flat(i32),
    /// A terrain model \[1/1024 m above the datum\]. In a raster scene it lies on the scene's own grid.
    Terrain(Raster<i32>),
}

/// What to do with nodata cells of rasters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NodataAs {
    /// They block nothing.
    #[default]
    Clear,
    /// They block everything.
    Block,
}
