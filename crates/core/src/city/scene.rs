//! A scene: the grid of receivers, the solids and the ground.

use std::collections::HashSet;

use super::{Area, BuildingHeight, BuiltUp, Footprint, FootprintFaults, HeightSources};
use crate::quantity::Frame;
use crate::raster::{BitGrid, GeoRef, Raster};

/// A city and the grid of receivers over it.
#[derive(Debug, Clone)]
pub struct City {
    /// Name of the scene in captions: the file name or the generator's parameters.
    pub name: String,
    /// The grid of receivers.
    pub grid: GeoRef,
    /// The solids that block links.
    pub solids: Solids,
    /// The built-up parameters of a generated city.
    pub built_up: Option<BuiltUp>,
    /// The files that the scene was read from.
    pub sources: Vec<Source>,
    /// Credit that pictures must show, if the data demand one.
    pub attribution: Option<String>,
    /// The sources of the heights of footprints, if the scene comes from a file of footprints.
    pub heights: Option<HeightSources>,
}

/// A file that a scene was read from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The path as the user gave it.
    pub path: String,
    /// SHA-256 of its bytes in hexadecimal, if it was computed.
    pub sha256: Option<String>,
}

/// The solids of a scene.
#[derive(Debug, Clone)]
pub enum Solids {
    /// Columns over the cells of the grid.
    Raster {
        /// Surface heights \[1/1024 m above the datum\], [`crate::quantity::VOID`] where there is
        /// none.
        surface: Raster<i32>,
        /// The ground of the receivers.
        ground: Ground,
        /// A cell whose surface is more than this above the ground is a building \[1/1024 m\].
        building_threshold: i32,
        /// The cells that hold the height of the terrain because the surface model has none there.
        /// Objects on them are unknown, so they hold no receiver.
        voids: Option<BitGrid>,
    },
    /// Prisms over footprints.
    Vector {
        /// The footprints, on the lattice of `frame`.
        footprints: Vec<Footprint>,
        /// The lattice of the footprints: unit 1 m, origin at the grid's south-west corner floored
        /// to a whole meter.
        frame: Frame,
        /// The ground of receivers and buildings.
        ground: Ground,
        /// The footprints that were mended or left out.
        faults: FootprintFaults,
        /// The area in which the ground is known.
        data_area: DataArea,
    },
}

impl Solids {
    /// Returns heights and positions of the buildings of a vector scene that have both; none for a
    /// raster. Parts of one building count as one building, with the mean of their heights weighted
    /// by area.
    pub fn building_heights(&self) -> Vec<BuildingHeight> {
        let Solids::Vector { footprints, frame, .. } = self else { return Vec::new() };
        Footprint::building_heights(footprints, *frame)
    }

    /// Returns the number of buildings of a vector scene; 0 for a raster. Parts of one building
    /// count as one building.
    pub fn n_buildings(&self) -> usize {
        let Solids::Vector { footprints, .. } = self else { return 0 };
        let groups: HashSet<u32> = footprints.iter().filter_map(|footprint| footprint.part_of).collect();
        groups.len() + footprints.iter().filter(|footprint| footprint.part_of.is_none()).count()
    }
}

/// The area in which a vector scene knows the ground. Cells elsewhere hold no data: no receiver, no
/// zone, no candidate.
#[derive(Debug, Clone, Default)]
pub enum DataArea {
    /// The whole plane.
    #[default]
    All,
    /// The closing of the footprints by a disc of 100 m, with holes filled. Everything counts as
    /// known if less than a tenth of it is open ground.
    NearFootprints,
    /// An area that the user drew.
    Within(Area),
}

/// The ground below the buildings.
#[derive(Debug, Clone)]
pub enum Ground {
    /// Unknown; the surface model is all there is, and receivers stand on the surface.
    Surface,
    /// A horizontal plane \[1/1024 m above the datum\].
    Flat(i32),
    /// A terrain model \[1/1024 m above the datum\]. In a raster scene it lies on the scene's own
    /// grid.
    Terrain(Raster<i32>),
}

crate::words! {
    /// Effect of nodata cells on links.
    pub enum NodataAs {
        /// Nodata cells block everything
        Block = "block",
        /// Nodata cells block nothing
        Clear = "clear",
    }
    default Clear
}
