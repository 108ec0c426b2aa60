//! A scene made ready for rays: its obstacles, and the ground and roofs at every cell and every point.

use rayon::prelude::*;

use super::cell_sets::{RasterCells, RasterGround};
use super::known_ground::KnownGround;
use super::solid::{Below, RasterSolid, Solid, VectorGround, VectorSolid};
use super::{CellSets, Columns, ConvexPieces, Place, Plateaus, Prisms, Ring, cell_frame, convex_pieces};
use crate::city::{DataArea, Footprint, Ground, Solids};
use crate::error::Warning;
use crate::quantity::{BLOCKS_ALL, Frame, VOID, counted, meters};
use crate::raster::{BitGrid, CellLattice, GeoRef};

/// The obstacles of a scene and what receivers stand on.
///
/// Prisms and columns are two solids: a wall that they happen to share is not joined.
#[derive(Debug, Clone)]
pub struct HeightField {
    pub(super) grid: GeoRef,
    pub(super) solid: Solid,
    /// The cells of the receivers' grid without data though a ground is known there, if there are any: those outside of the
    /// known ground, and those where a surface model has no height.
    pub(super) without_data: Option<BitGrid>,
    pub(super) cells: CellSets,
}

/// What a cell of the receivers' grid is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellKind {
    /// Open ground at this height \[1/1024 m above the datum\].
    Open(i32),
    /// A building with its roof at this height.
    Building(i32),
    /// Nodata: no receiver.
    Void,
}

impl HeightField {
    /// Builds the obstacles of a scene: triangulates footprints, rounds nothing more.
    ///
    /// Cost: the triangulation, in parallel over footprints, and one test per cell near each piece.
    pub fn build(grid: &GeoRef, solids: Solids, warnings: &mut Vec<Warning>) -> Self {
        let nothing = BitGrid::new(0, 0);
        let no_cells = CellSets { open: nothing.clone(), building: nothing };
        let mut field = match solids {
            Solids::Raster { surface, ground, building_threshold, voids } => {
                let georef = surface.georef().clone();
                let below = match ground {
                    Ground::Surface => Below::Surface,
                    Ground::Flat(z) => Below::Flat { z, building_threshold },
                    Ground::Terrain(terrain) => Below::Terrain { tops: terrain.into_cells(), building_threshold },
                };
                let columns = Columns::new(georef.n_rows(), georef.n_cols(), surface.into_cells());
                let solid = Solid::Raster(RasterSolid { columns, frame: cell_frame(&georef), below });
                HeightField { grid: grid.clone(), solid, without_data: voids, cells: no_cells }
            }
            Solids::Vector { footprints, frame, ground, data_area, .. } => {
                let prisms = prisms_of(&footprints, warnings);
                let is_auto = matches!(data_area, DataArea::NearFootprints);
                let known_ground = match data_area {
                    DataArea::All => None,
                    DataArea::NearFootprints => KnownGround::near(&footprints, &frame, grid),
                    DataArea::Within(area) => Some(KnownGround::Area(area)),
                };
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
                let solid = VectorSolid { prisms, frame, ground, roofs: Vec::new(), known_ground, building_ids };
                let solid = Solid::Vector(solid);
                let mut field = HeightField { grid: grid.clone(), solid, without_data: None, cells: no_cells };
                field.find_roofs();
                field.find_cells_without_data();
                if is_auto {
                    field.know_all_if_little_is_open(warnings);
                }
                field
            }
        };
        field.cells = CellSets::of(&field);
        field.warn_of_unknown_ground(warnings);
        field
    }

    /// Warns of cells of a vector scene below which no terrain is known.
    fn warn_of_unknown_ground(&self, warnings: &mut Vec<Warning>) {
        let is_on_terrain = self.prisms().is_some() && self.columns().is_some();
        let of_data = self.grid.n_cells() as u64 - self.without_data.as_ref().map_or(0, BitGrid::count);
        let n_unknown = of_data - self.cells.open.count() - self.cells.building.count();
        if is_on_terrain && n_unknown > 0 {
            let does = match self.max_top() {
                BLOCKS_ALL => "it blocks everything",
                _ => "it blocks nothing",
            };
            let cells = counted(n_unknown, "cell has", "cells have");
            let text = format!(
                "{cells} no ground: the terrain is void there, or ends before; {does} and holds no receiver (`--nodata-as`)"
            );
            warnings.push(Warning::new(340, text));
        }
    }

    /// Cells without data though a ground is known there, if there are any.
    pub(super) fn without_data(&self) -> Option<&BitGrid> {
        self.without_data.as_ref()
    }

    /// Which cells are open ground and which are buildings.
    #[inline]
    pub fn cells(&self) -> &CellSets {
        &self.cells
    }

    /// The cells of a raster scene.
    pub(super) fn raster_cells(&self) -> Option<RasterCells<'_>> {
        let RasterSolid { columns, below, .. } = self.solid.raster()?;
        let ground = match below {
            Below::Surface => RasterGround::Surface,
            Below::Flat { z, building_threshold } => {
                RasterGround::Flat { z: *z, building_threshold: *building_threshold }
            }
            Below::Terrain { tops, building_threshold } => {
                RasterGround::Terrain { tops, building_threshold: *building_threshold }
            }
        };
        Some(RasterCells { tops: columns.tops(), ground })
    }

    /// The one height of the ground under all open cells, if it is flat.
    pub(super) fn flat_ground(&self) -> Option<i32> {
        match &self.solid {
            Solid::Raster(RasterSolid { below: Below::Flat { z, .. }, .. }) => Some(*z),
            Solid::Vector(VectorSolid { ground: VectorGround::Flat(z), .. }) => Some(*z),
            Solid::Raster(_) | Solid::Vector(_) => None,
        }
    }

    /// The ground of each open cell where it is stored cell by cell on the receivers' grid.
    pub(super) fn ground_on_grid(&self) -> Option<&[i32]> {
        match &self.solid {
            Solid::Raster(RasterSolid { below: Below::Terrain { tops, .. }, .. }) => Some(tops),
            Solid::Raster(RasterSolid { below: Below::Surface, columns, .. }) => Some(columns.tops()),
            Solid::Raster(RasterSolid { below: Below::Flat { .. }, .. }) => None,
            Solid::Vector(_) => self.columns().filter(|_| self.columns_are_on_grid()).map(Columns::tops),
        }
    }

    /// The roof of each building cell.
    pub(super) fn roofs_on_grid(&self) -> &[i32] {
        match &self.solid {
            Solid::Raster(raster) => raster.columns.tops(),
            Solid::Vector(vector) => &vector.roofs,
        }
    }

    /// Whether the cells of the columns are those of the receivers' grid.
    pub fn columns_are_on_grid(&self) -> bool {
        self.solid.columns().is_some_and(|(columns, frame)| {
            let shape = (columns.n_rows(), columns.n_cols());
            let of_grid = match self.prisms_frame() {
                Some(scene) => CellLattice::under(&scene, &self.grid).frame,
                None => cell_frame(&self.grid),
            };
            shape == (self.grid.n_rows(), self.grid.n_cols()) && frame == of_grid
        })
    }

    /// Whether the engine for whole rasters can decide over the columns: receivers stand at the centers of their cells, which
    /// have as many lattice steps as it reckons with.
    pub fn columns_can_be_swept(&self) -> bool {
        let Some(columns) = self.columns().filter(|_| self.columns_are_on_grid()) else { return false };
        let positions = self.positions();
        let mut centers = (0..columns.n_cols()).map(|col| columns.center(0, col).0);
        let mut middles = (0..columns.n_rows()).map(|row| columns.center(row, 0).1);
        columns.has_unit_cells()
            && positions.columns_xs().all(|x| centers.next() == Some(x))
            && positions.columns_ys().all(|y| middles.next() == Some(y))
    }

    /// The surface of a raster scene as few rectangles of one height, if it is that and the ground below it is flat or not
    /// known.
    pub fn plateaus(&self) -> Option<&Plateaus> {
        let raster = self.solid.raster().filter(|raster| !matches!(raster.below, Below::Terrain { .. }))?;
        Some(&raster.columns).filter(|_| self.columns_are_on_grid())?.plateaus()
    }

    /// The receivers' grid.
    #[inline]
    pub fn grid(&self) -> &GeoRef {
        &self.grid
    }

    /// The prisms, in a vector scene.
    pub fn prisms(&self) -> Option<&Prisms> {
        self.solid.vector().map(|vector| &vector.prisms)
    }

    /// The columns: the surface of a raster scene, or the terrain of a vector scene.
    pub fn columns(&self) -> Option<&Columns> {
        self.solid.columns().map(|(columns, _)| columns)
    }

    /// The frame of the prisms' lattice.
    pub fn prisms_frame(&self) -> Option<Frame> {
        self.solid.vector().map(|vector| vector.frame)
    }

    /// The frame of the columns' lattice.
    pub fn columns_frame(&self) -> Option<Frame> {
        self.solid.columns().map(|(_, frame)| frame)
    }

    /// The id of a building of the prisms.
    pub fn building_id(&self, building: u32) -> &str {
        self.solid.vector().map_or("", |vector| &vector.building_ids[building as usize])
    }

    /// Number of buildings, in a vector scene.
    pub fn n_buildings(&self) -> usize {
        self.solid.vector().map_or(0, |vector| vector.building_ids.len())
    }

    /// Whether receivers stand on a surface model because nothing below it is known.
    pub fn is_surface_only(&self) -> bool {
        self.solid.raster().is_some_and(|raster| matches!(raster.below, Below::Surface))
    }

    /// What a cell is; `place` is its center.
    #[inline]
    pub fn cell_kind(&self, index: usize, place: &Place) -> CellKind {
        let n_cols = self.grid.n_cols();
        if self.without_data.as_ref().is_some_and(|cells| cells.contains(index / n_cols, index % n_cols)) {
            return CellKind::Void;
        }
        match &self.solid {
            Solid::Raster(raster) => raster.kind_of(raster.columns.tops()[index], index),
            Solid::Vector(vector) => match (self.ground_at(place), vector.roofs[index]) {
                (VOID, VOID) => CellKind::Void,
                (ground, VOID) => CellKind::Open(ground),
                (_, roof) => CellKind::Building(roof),
            },
        }
    }

    /// The ground and, if it is a building, the roof of a cell of the columns; both `None` where it is void. A surface
    /// model alone is all ground.
    pub fn column_parts(&self, cell: usize) -> (Option<i32>, Option<i32>) {
        let Some((columns, _)) = self.solid.columns() else { return (None, None) };
        let n_cols = columns.n_cols();
        let is_void = |cells: &BitGrid| self.prisms().is_none() && cells.contains(cell / n_cols, cell % n_cols);
        let top = columns.tops()[cell];
        if top == VOID || top == BLOCKS_ALL || self.without_data.as_ref().is_some_and(is_void) {
            return (None, None);
        }
        let parts = |ground: i32, threshold: i32| {
            let is_building = ground != VOID && i64::from(top) - i64::from(ground) > i64::from(threshold);
            (Some(if is_building { ground } else { top }), is_building.then_some(top))
        };
        match &self.solid {
            // Under footprints the columns are the terrain.
            Solid::Vector(_) => (Some(top), None),
            Solid::Raster(raster) => match &raster.below {
                Below::Surface => (Some(top), None),
                Below::Flat { z, building_threshold } => parts(*z, *building_threshold),
                Below::Terrain { tops, building_threshold } => parts(tops[cell], *building_threshold),
            },
        }
    }

    /// Height of the ground at a place, of the cell to its north-east on an edge; [`VOID`] where none is known.
    pub fn ground_at(&self, place: &Place) -> i32 {
        let cell_of = |columns: &Columns| columns.cell_at(place.on_columns.0, place.on_columns.1);
        let top_of = |columns: &Columns| match cell_of(columns).map(|cell| columns.top_at(cell)) {
            Some(top) if top != BLOCKS_ALL => top,
            _ => VOID,
        };
        match &self.solid {
            Solid::Raster(raster) => match &raster.below {
                Below::Surface => top_of(&raster.columns),
                // Ground that was typed has no end.
                Below::Flat { z, .. } => *z,
                Below::Terrain { tops, .. } => cell_of(&raster.columns).map_or(VOID, |cell| tops[cell]),
            },
            Solid::Vector(vector) => match &vector.ground {
                VectorGround::Flat(z) => *z,
                VectorGround::Terrain { columns, .. } => top_of(columns),
            },
        }
    }

    /// Height of the roof at a place, if a building is there (the one to its north-east on an edge).
    pub fn roof_at(&self, place: &Place) -> Option<i32> {
        let raster = match &self.solid {
            Solid::Raster(raster) => raster,
            Solid::Vector(vector) => {
                return vector.prisms.roof_at(place.on_prisms.0, place.on_prisms.1).map(|(top, _)| top);
            }
        };
        let cell = raster.columns.cell_at(place.on_columns.0, place.on_columns.1)?;
        let n_cols = raster.columns.n_cols();
        let is_void = |cells: &BitGrid| cells.contains(cell / n_cols, cell % n_cols);
        if self.without_data.as_ref().is_some_and(is_void) {
            return None;
        }
        match raster.kind_of(raster.columns.top_at(cell), cell) {
            CellKind::Building(roof) => Some(roof),
            CellKind::Open(_) | CellKind::Void => None,
        }
    }

    /// The height below which the vertical line at a place is inside the prisms; [`VOID`] if it is not.
    pub fn inside_prisms_below(&self, place: &Place) -> i32 {
        self.prisms().map_or(VOID, |p| p.solid_below(place.on_prisms.0, place.on_prisms.1))
    }

    /// The height below which the vertical line at a place is inside the columns; [`VOID`] if it is not.
    pub fn inside_columns_below(&self, place: &Place) -> i32 {
        self.columns().map_or(VOID, |c| c.solid_below(place.on_columns.0, place.on_columns.1))
    }

    /// The highest obstacle \[1/1024 m\], [`VOID`] if there is none.
    pub fn max_top(&self) -> i32 {
        let prisms = self.prisms().map_or(VOID, Prisms::max_top);
        prisms.max(self.columns().map_or(VOID, Columns::max_top))
    }

    /// The surface seen from above at each cell \[m above the datum\], NaN where void.
    pub fn surface_m(&self) -> Vec<f32> {
        self.each_cell(|kind, _| match kind {
            CellKind::Open(z) | CellKind::Building(z) => meters(z),
            CellKind::Void => f64::NAN,
        })
    }

    /// The surface above the ground at each cell \[m\], NaN where void: for shading, which should show buildings, not
    /// hills. With a surface model alone that is the surface itself.
    pub fn above_ground_m(&self) -> Vec<f32> {
        let surface_only = self.is_surface_only();
        self.each_cell(|kind, place| match kind {
            CellKind::Open(z) if surface_only => meters(z),
            CellKind::Open(_) => 0.0,
            CellKind::Building(z) => match self.ground_at(place) {
                VOID => 0.0,
                ground => meters(z) - meters(ground),
            },
            CellKind::Void => f64::NAN,
        })
    }

    /// A value for each cell, row by row from the north-west, in parallel.
    fn each_cell(&self, value: impl Fn(CellKind, &Place) -> f64 + Sync) -> Vec<f32> {
        let positions = self.positions();
        let n_cols = self.grid.n_cols();
        let mut cells = vec![f32::NAN; self.grid.n_cells()];
        cells.par_chunks_mut(n_cols).enumerate().for_each(|(row, cells)| {
            for (col, cell) in cells.iter_mut().enumerate() {
                let place = positions.center(row, col);
                let found = value(self.cell_kind(row * n_cols + col, &place), &place);
                #[expect(clippy::cast_possible_truncation, reason = "files and pictures of heights hold f32")]
                let found = found as f32;
                *cell = found;
            }
        });
        cells
    }
}

impl RasterSolid {
    /// What a cell is, given the top of its column.
    #[inline]
    fn kind_of(&self, top: i32, cell: usize) -> CellKind {
        if top == VOID || top == BLOCKS_ALL {
            return CellKind::Void;
        }
        let above = |ground: i32, threshold: i32| {
            if ground == VOID {
                CellKind::Void
            } else if i64::from(top) - i64::from(ground) > i64::from(threshold) {
                CellKind::Building(top)
            } else {
                CellKind::Open(ground)
            }
        };
        match &self.below {
            Below::Surface => CellKind::Open(top),
            Below::Flat { z, building_threshold } => above(*z, *building_threshold),
            Below::Terrain { tops, building_threshold } => above(tops[cell], *building_threshold),
        }
    }
}

/// Convex pieces of all footprints, in the order of the footprints.
fn prisms_of(footprints: &[Footprint], warnings: &mut Vec<Warning>) -> Prisms {
    let cut: Vec<(Vec<Ring>, bool)> = footprints
        .par_iter()
        .map(|footprint| {
            let mut pieces = Vec::new();
            let mut fell_back = false;
            for polygon in &footprint.polygons {
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
        warnings.push(Warning::new(
            345,
            format!("footprint `{}` could not be triangulated; its convex hull is used instead", footprint.id),
        ));
    }
    let pieces = footprints.iter().zip(cut).enumerate().flat_map(|(building, (footprint, (rings, _)))| {
        let building = u32::try_from(building).unwrap_or(u32::MAX);
        rings.into_iter().map(move |ring| (ring, footprint.top, building))
    });
    Prisms::new(pieces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::city::FootprintFaults;

    fn square_scene() -> HeightField {
        // A 4 m square building whose edges pass through cell centers, 10 m high, on ground at 2 m.
        let grid = GeoRef::new((0.0, 8.0), (1.0, 1.0), (8, 8), None).expect("a valid grid");
        let (low, high) = (1536, 1536 + 4096);
        let footprint = Footprint {
            id: "a".into(),
            polygons: vec![vec![vec![[low, low], [high, low], [high, high], [low, high]]]],
            top: 12 * 1024,
            base: Some(2 * 1024),
        };
        let frame = Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 };
        let solids = Solids::Vector {
            footprints: vec![footprint],
            frame,
            ground: Ground::Flat(2 * 1024),
            faults: FootprintFaults::default(),
            data_area: DataArea::All,
        };
        HeightField::build(&grid, solids, &mut Vec::new())
    }

    #[test]
    fn a_cell_whose_center_is_on_a_free_wall_is_open_ground() {
        let field = square_scene();
        let positions = field.positions();
        let n_buildings = (0..64)
            .filter(|i| matches!(field.cell_kind(*i, &positions.center(i / 8, i % 8)), CellKind::Building(_)))
            .count();
        // Centers at 1.5, 2.5 … 5.5 along each axis touch the square; three of the five are strictly inside.
        assert_eq!(n_buildings, 9);
    }

    #[test]
    fn the_roof_and_the_ground_are_told_at_any_point() {
        let field = square_scene();
        assert_eq!(field.roof_at(&field.place(3.0, 3.0)), Some(12 * 1024));
        assert_eq!(field.roof_at(&field.place(0.5, 3.0)), None);
        assert_eq!(field.ground_at(&field.place(100.0, -3.0)), 2048);
        assert_eq!(field.inside_prisms_below(&field.place(1.5, 3.0)), VOID);
    }
}
