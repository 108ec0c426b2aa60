//! Solids of a scene, and what receivers stand on: columns alone, or prisms with the ground below
//! them.

use std::sync::Arc;

use super::columns::Columns;
use super::known_ground::KnownGround;
use super::positions::Place;
use super::prisms::Prisms;
use super::seen_heights::{Drops, HeightsOf, SeenHeights};
use crate::city::Ground;
use crate::quantity::Frame;
use crate::raster::GeoRef;

/// The solids of a scene, of one kind or the other.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "a scene has one of them")]
pub(super) enum Solid {
    Raster(RasterSolid),
    Vector(VectorSolid),
}

/// A raster scene: columns over the cells of the receivers' grid.
#[derive(Debug, Clone)]
pub(super) struct RasterSolid {
    pub(super) columns: Columns,
    pub(super) frame: Frame,
    /// Ground below the surface over a flat earth; a terrain is on the same grid.
    pub(super) ground: Arc<Ground>,
    /// Drops of the ground over a curved earth, the same as of the columns.
    pub(super) drops: Option<Arc<Drops>>,
    /// A cell more than this above the ground is a building \[1/1024 m\].
    pub(super) building_threshold: i32,
}

/// A vector scene: prisms on the ground. A wall that they happen to share with the terrain is not
/// joined. Parts of a scene share all but what is told cell by cell.
#[derive(Debug, Clone)]
pub(super) struct VectorSolid {
    pub(super) prisms: Prisms,
    pub(super) frame: Frame,
    pub(super) ground: Arc<VectorGround>,
    /// Roof of each cell whose center is inside a building, [`crate::quantity::VOID`] elsewhere.
    pub(super) roofs: Arc<Vec<i32>>,
    /// Ground that is known, if not all of it.
    pub(super) known_ground: Option<Arc<KnownGround>>,
    pub(super) building_ids: Arc<[String]>,
    /// Standard deviations of the errors of their heights \[1/1024 m\], where any is told.
    pub(super) building_errors: Option<Arc<[Option<i32>]>>,
}

/// Ground that prisms stand on.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "a scene has one of them")]
pub(super) enum VectorGround {
    /// A plane.
    Flat(i32),
    /// A terrain on a grid of its own.
    Terrain { columns: Columns, frame: Frame },
}

/// The terrain below footprints as a UAV sees it over a curved earth.
#[derive(Debug)]
pub(crate) struct BentTerrain {
    pub(super) columns: Columns,
    /// Drops of its cells.
    pub(super) drops: Arc<Drops>,
    /// Drops of receivers on the cells of the grid, against the terrain.
    pub(crate) receiver_drops: Arc<Drops>,
}

impl BentTerrain {
    /// Returns how much lower against the terrain a receiver at a place is \[1/1024 m\].
    pub(crate) fn receiver_drop(&self, grid: &GeoRef, place: &Place) -> i64 {
        i64::from(self.receiver_drops.at_place(grid, place))
    }

    /// Returns how much lower a cell of it is \[1/1024 m\].
    pub(crate) fn drop_of(&self, (row, col): (usize, usize)) -> i32 {
        self.drops.at(row, col)
    }
}

impl RasterSolid {
    /// Returns a scene over a flat earth.
    pub(super) fn new(columns: Columns, frame: Frame, ground: Ground, building_threshold: i32) -> Self {
        RasterSolid { columns, frame, ground: Arc::new(ground), drops: None, building_threshold }
    }

    /// Returns the ground of each cell, if it is known apart from the surface.
    pub(super) fn ground(&self) -> Option<SeenHeights<'_>> {
        let heights = match &*self.ground {
            Ground::Surface => return None,
            Ground::Flat(z) => HeightsOf::One(*z),
            Ground::Terrain(terrain) => HeightsOf::Cells(terrain.cells()),
        };
        Some(SeenHeights { heights, n_cols: self.columns.n_cols(), drops: self.drops.as_deref() })
    }
}

impl Solid {
    /// Returns the columns with the frame of their lattice: the surface of a raster scene, or the
    /// terrain of a vector scene.
    pub(super) fn columns(&self) -> Option<(&Columns, Frame)> {
        match self {
            Solid::Raster(raster) => Some((&raster.columns, raster.frame)),
            Solid::Vector(vector) => match &*vector.ground {
                VectorGround::Flat(_) => None,
                VectorGround::Terrain { columns, frame } => Some((columns, *frame)),
            },
        }
    }

    /// Returns the solids of a vector scene.
    pub(super) fn vector(&self) -> Option<&VectorSolid> {
        match self {
            Solid::Raster(_) => None,
            Solid::Vector(vector) => Some(vector),
        }
    }

    /// Returns the solid of a raster scene.
    pub(super) fn raster(&self) -> Option<&RasterSolid> {
        match self {
            Solid::Raster(raster) => Some(raster),
            Solid::Vector(_) => None,
        }
    }
}
