//! From a scene to its height field: footprints become prisms, and each cell of the receivers' grid
//! ground, roof or nothing.

use std::sync::Arc;

use rayon::prelude::*;

use super::known_ground::KnownGround;
use super::solid::{RasterSolid, Solid, VectorGround, VectorSolid};
use super::{CellSets, Columns, ConvexPieces, HeightField, Prisms, Top, cell_frame, convex_pieces};
use crate::city::{DataArea, Footprint, Ground, Solids};
use crate::error::Warning;
use crate::overlay::Ring;
use crate::quantity::BLOCKS_ALL;
use crate::raster::{BitGrid, CellLattice, GeoRef};

/// A height field, and what was odd about its scene.
#[derive(Debug, Clone)]
pub struct Built {
    /// The obstacles and what receivers stand on.
    pub field: HeightField,
    /// Oddities of the scene.
    pub warnings: Vec<Warning>,
}

impl HeightField {
    /// Builds the obstacles of a scene: triangulates footprints, rounds nothing more.
    ///
    /// Cost: the triangulation, in parallel over footprints, and one test per cell near each piece.
    pub fn build(grid: &GeoRef, solids: Solids) -> Built {
        let mut warnings = Vec::new();
        let nothing = BitGrid::new(0, 0);
        let no_cells = Arc::new(CellSets { open: nothing.clone(), building: nothing });
        let mut field = match solids {
            Solids::Raster { surface, ground, building_threshold, voids } => {
                let georef = surface.georef().clone();
                let columns = Columns::new(georef.n_rows(), georef.n_cols(), surface.into_cells());
                let solid = Solid::Raster(RasterSolid::new(columns, cell_frame(&georef), ground, building_threshold));
                HeightField {
                    grid: grid.clone(),
                    solid,
                    without_data: voids.map(Arc::new),
                    cells: no_cells,
                    bent_terrain: None,
                }
            }
            Solids::Vector { footprints, frame, ground, data_area, .. } => {
                let prisms = prisms_of(&footprints, &mut warnings);
                let is_auto = matches!(data_area, DataArea::NearFootprints);
                let known_ground = match data_area {
                    DataArea::All => None,
                    DataArea::NearFootprints => KnownGround::near(&footprints, &frame, grid.meters_per_unit()),
                    DataArea::Within(area) => Some(KnownGround::Area(area)),
                };
                let has_errors = footprints.iter().any(|f| f.height_error.is_some());
                let building_errors = has_errors.then(|| footprints.iter().map(|f| f.height_error).collect());
                let building_ids = footprints.into_iter().map(|f| f.id).collect();
                let ground = match ground {
                    Ground::Terrain(terrain) => {
                        let georef = terrain.georef().clone();
                        let lattice = CellLattice::under(&frame, &georef);
                        let columns = Columns::new(georef.n_rows(), georef.n_cols(), terrain.into_cells());
                        // PERF: the ground is asked for cell by cell.
                        columns.tops();
                        VectorGround::Terrain { columns: columns.with_cells_of(lattice.steps), frame: lattice.frame }
                    }
                    Ground::Flat(z) => VectorGround::Flat(z),
                    Ground::Surface => VectorGround::Flat(0),
                };
                let (ground, known_ground) = (Arc::new(ground), known_ground.map(Arc::new));
                let solid = VectorSolid {
                    prisms,
                    frame,
                    ground,
                    roofs: Arc::default(),
                    known_ground,
                    building_ids,
                    building_errors,
                };
                let solid = Solid::Vector(solid);
                let mut field =
                    HeightField { grid: grid.clone(), solid, without_data: None, cells: no_cells, bent_terrain: None };
                field.find_roofs();
                field.find_cells_without_data();
                if is_auto && field.knows_all_as_little_is_open() {
                    warnings.push(Warning::LittleOpenGround);
                }
                field
            }
        };
        field.cells = Arc::new(CellSets::of(&field));
        warnings.extend(field.unknown_ground());
        Built { field, warnings }
    }

    /// Warns of cells of a vector scene below which no terrain is known, if there are any.
    fn unknown_ground(&self) -> Option<Warning> {
        let is_on_terrain = self.prisms().is_some() && self.columns().is_some();
        let of_data = self.grid.n_cells() as u64 - self.without_data.as_deref().map_or(0, BitGrid::count);
        let cells = of_data - self.cells.open.count() - self.cells.building.count();
        let block = self.max_top() == BLOCKS_ALL;
        (is_on_terrain && cells > 0).then_some(Warning::UnknownGround { cells, block })
    }
}

/// Returns convex pieces of all footprints, in the order of the footprints: the triangles of roofs
/// as they are, and polygons cut up below flat ones.
fn prisms_of(footprints: &[Footprint], warnings: &mut Vec<Warning>) -> Prisms {
    let cut: Vec<(Vec<Ring>, bool)> = footprints
        .par_iter()
        .map(|footprint| {
            let mut pieces = Vec::new();
            let mut fell_back = false;
            let flat = if footprint.roof.is_empty() { &footprint.polygons[..] } else { &[] };
            for polygon in flat {
                match convex_pieces(polygon) {
                    ConvexPieces::Exact(rings) => pieces.extend(rings),
                    ConvexPieces::Hull(ring) => {
                        fell_back = true;
                        pieces.extend((ring.len() >= 3).then_some(ring));
                    }
                }
            }
            (pieces, fell_back)
        })
        .collect();
    for (footprint, _) in footprints.iter().zip(&cut).filter(|(_, (_, fell_back))| *fell_back) {
        warnings.push(Warning::Hull { footprint: footprint.id.clone() });
    }
    let pieces = footprints.iter().zip(cut).enumerate().flat_map(|(building, (footprint, (rings, _)))| {
        let building = u32::try_from(building).unwrap_or(u32::MAX);
        let sloped = footprint.roof.iter().map(|corners| {
            let ring = corners.map(|[x, y, _]| [x, y]).to_vec();
            (ring, Top::Sloped(corners.map(|[.., z]| z).to_vec()))
        });
        let flat = rings.into_iter().map(|ring| (ring, Top::Flat(footprint.top)));
        sloped.chain(flat).map(move |(ring, top)| (ring, top, building))
    });
    Prisms::with_tops(pieces)
}
