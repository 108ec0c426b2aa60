//! A scene made ready for rays: its obstacles, and the ground and roofs at every cell and every
//! point.

use std::sync::Arc;

use rayon::prelude::*;

use super::columns::Columns;
use super::plateaus::Plateaus;
use super::positions::{GridPositions, Place, RangeLattice, Station, cell_frame};
use super::prisms::Prisms;
use super::solid::{BentTerrain, RasterSolid, Solid, VectorGround};
use crate::city::Ground;
use crate::quantity::{BLOCKS_ALL, Frame, LatticePoint, STEPS_PER_UNIT, VOID, meters};
use crate::raster::{BitGrid, CellLattice, GeoRef};

/// The obstacles of a scene and what receivers stand on.
///
/// Prisms and columns are two solids: a wall that they happen to share is not joined.
#[derive(Debug, Clone)]
pub struct HeightField {
    pub(super) grid: GeoRef,
    pub(super) solid: Solid,
    /// Cells of the receivers' grid without data though a ground is known there, if there are any.
    ///
    /// They lie outside of the known ground, or a surface model has no height there.
    pub(super) without_data: Option<Arc<BitGrid>>,
    pub(super) cells: Arc<CellSets>,
    /// The terrain below footprints as a UAV sees it over a curved earth, where that is not as it
    /// is.
    pub(super) bent_terrain: Option<Arc<BentTerrain>>,
}

/// Heights at the place of a UAV \[1/1024 m above the datum\]; [`VOID`] where none is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BelowUav {
    /// Ground.
    pub ground: i32,
    /// Ground, roof or surface, whichever is highest: the UAV must not be below.
    pub surface: i32,
}

/// Kind of a cell of the receivers' grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellKind {
    /// Open ground at this height \[1/1024 m above the datum\].
    Open(i32),
    /// A building with its roof at this height.
    Building(i32),
    /// Nodata: no receiver.
    Void,
}

/// The cells of open ground and those of buildings; all others are void.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellSets {
    /// Open ground.
    pub open: BitGrid,
    /// Buildings.
    pub building: BitGrid,
}

impl HeightField {
    /// Returns the cells of open ground and those of buildings.
    #[inline]
    pub fn cells(&self) -> &CellSets {
        &self.cells
    }

    /// Returns whether the cells of the columns are those of the receivers' grid.
    pub(crate) fn columns_are_on_grid(&self) -> bool {
        self.solid.columns().is_some_and(|(columns, frame)| {
            let shape = (columns.n_rows(), columns.n_cols());
            let of_grid = match self.prisms_frame() {
                Some(scene) => CellLattice::under(&scene, &self.grid).frame,
                None => cell_frame(&self.grid),
            };
            shape == (self.grid.n_rows(), self.grid.n_cols()) && frame == of_grid
        })
    }

    /// Returns whether the engine for whole rasters can decide over the columns: receivers stand at
    /// the centers of their cells, which have as many lattice steps as it reckons with.
    pub(crate) fn columns_can_be_swept(&self) -> bool {
        let Some(columns) = self.columns().filter(|_| self.columns_are_on_grid()) else { return false };
        let (xs, ys) = self.positions().on_columns();
        columns.has_unit_cells()
            && xs.into_iter().eq((0..columns.n_cols()).map(|col| columns.center(0, col).0))
            && ys.into_iter().eq((0..columns.n_rows()).map(|row| columns.center(row, 0).1))
    }

    /// Returns the surface of a raster scene as few rectangles of one height, if it is that and the
    /// ground below it is flat or not known.
    pub fn plateaus(&self) -> Option<&Plateaus> {
        let raster = self.solid.raster().filter(|raster| !matches!(*raster.ground, Ground::Terrain(_)))?;
        Some(&raster.columns).filter(|_| self.columns_are_on_grid())?.plateaus()
    }

    /// Returns the receivers' grid.
    #[inline]
    pub fn grid(&self) -> &GeoRef {
        &self.grid
    }

    /// Returns the highest top of each building of a vector scene, by its number \[1/1024 m above
    /// the datum\]; [`VOID`] of one without an area.
    pub fn building_tops(&self) -> Vec<i32> {
        let mut tops = vec![VOID; self.n_buildings()];
        for piece in self.prisms().map_or(&[][..], Prisms::pieces) {
            let top = &mut tops[piece.building as usize];
            *top = piece.top.max(*top);
        }
        tops
    }

    /// Returns the building of a vector scene whose roof is at a place, the highest of several.
    pub(crate) fn building_at(&self, place: &Place) -> Option<u32> {
        self.prisms()?.roof_at(place.on_prisms.0, place.on_prisms.1).map(|(_, building)| building)
    }

    /// Returns the prisms, in a vector scene.
    pub fn prisms(&self) -> Option<&Prisms> {
        self.solid.vector().map(|vector| &vector.prisms)
    }

    /// Returns the columns that stand in the way: the surface of a raster scene, or the terrain of
    /// a vector scene.
    pub fn columns(&self) -> Option<&Columns> {
        match &self.bent_terrain {
            Some(bent) => Some(&bent.columns),
            None => self.solid.columns().map(|(columns, _)| columns),
        }
    }

    /// Returns the terrain below footprints as a UAV sees it over a curved earth, where that is not
    /// as it is.
    pub(crate) fn bent_terrain(&self) -> Option<&BentTerrain> {
        self.bent_terrain.as_deref()
    }

    /// Returns a receiver on the lattice of the columns, as high as it is against them.
    #[inline]
    pub(crate) fn seen_on_columns(&self, receiver: &Station) -> LatticePoint {
        let on_columns = receiver.on_columns();
        match &self.bent_terrain {
            None => on_columns,
            Some(bent) => {
                LatticePoint { z: on_columns.z - bent.receiver_drop(&self.grid, &receiver.place), ..on_columns }
            }
        }
    }

    /// Returns the frame of the prisms' lattice.
    pub fn prisms_frame(&self) -> Option<Frame> {
        self.solid.vector().map(|vector| vector.frame)
    }

    /// Returns the frame of the columns' lattice.
    pub fn columns_frame(&self) -> Option<Frame> {
        self.solid.columns().map(|(_, frame)| frame)
    }

    /// Returns the longer side of the box around two positions, in lattice units of the scene.
    pub fn span_units(&self, from: (f64, f64), to: (f64, f64)) -> f64 {
        let span = |frame: Frame| ((to.0 - from.0) / frame.unit_x).abs().max(((to.1 - from.1) / frame.unit_y).abs());
        [self.prisms_frame(), self.columns_frame()].into_iter().flatten().map(span).fold(0.0, f64::max)
    }

    /// Returns the id of a building of the prisms.
    pub fn building_id(&self, building: u32) -> &str {
        self.solid.vector().map_or("", |vector| &vector.building_ids[building as usize])
    }

    /// Returns standard deviations of the errors of heights of buildings, by their numbers \[1/1024
    /// m\], where any is told.
    pub fn building_errors(&self) -> Option<&[Option<i32>]> {
        self.solid.vector().and_then(|vector| vector.building_errors.as_deref())
    }

    /// Returns the number of buildings, in a vector scene.
    pub fn n_buildings(&self) -> usize {
        self.solid.vector().map_or(0, |vector| vector.building_ids.len())
    }

    /// Returns whether receivers stand on a surface model because nothing below it is known.
    pub fn is_surface_only(&self) -> bool {
        self.solid.raster().is_some_and(|raster| matches!(*raster.ground, Ground::Surface))
    }

    /// Returns the kind of a cell; `place` is its center.
    #[inline]
    pub fn cell_kind(&self, index: usize, place: &Place) -> CellKind {
        let n_cols = self.grid.n_cols();
        if self.without_data.as_ref().is_some_and(|cells| cells.contains(index / n_cols, index % n_cols)) {
            return CellKind::Void;
        }
        match &self.solid {
            Solid::Raster(raster) => raster.kind_of(raster.columns.top_at(index), index),
            Solid::Vector(vector) => match (self.ground_at(place), vector.roofs[index]) {
                (VOID, VOID) => CellKind::Void,
                (ground, VOID) => CellKind::Open(ground),
                (_, roof) => CellKind::Building(roof),
            },
        }
    }

    /// Returns the ground and, if it is a building, the roof of a cell of the columns; both `None`
    /// where it is void. A surface model alone is all ground.
    pub fn column_parts(&self, cell: usize) -> (Option<i32>, Option<i32>) {
        let Some((columns, _)) = self.solid.columns() else { return (None, None) };
        let n_cols = columns.n_cols();
        let is_void = |cells: &BitGrid| self.prisms().is_none() && cells.contains(cell / n_cols, cell % n_cols);
        let top = columns.top_at(cell);
        if top == VOID || top == BLOCKS_ALL || self.without_data.as_deref().is_some_and(is_void) {
            return (None, None);
        }
        match &self.solid {
            Solid::Raster(raster) if matches!(raster.kind_of(top, cell), CellKind::Building(_)) => {
                (raster.ground_of(cell), Some(top))
            }
            // Under footprints the columns are the terrain.
            _ => (Some(top), None),
        }
    }

    /// Returns the height of the ground at a place, of the cell to its north-east on an edge;
    /// [`VOID`] where none is known.
    pub fn ground_at(&self, place: &Place) -> i32 {
        // Flat ground has no end.
        if let Some(ground) = self.flat_ground() {
            return ground;
        }
        let (x, y) = place.on_columns;
        let cell = self.solid.columns().and_then(|(columns, _)| columns.cell_at(x, y));
        cell.map_or(VOID, |cell| self.ground_of_cell(cell))
    }

    /// Returns the height of the ground of a cell of the columns; [`VOID`] where none is known.
    pub(crate) fn ground_of_cell(&self, cell: usize) -> i32 {
        let top_of = |columns: &Columns| match columns.top_at(cell) {
            BLOCKS_ALL => VOID,
            top => top,
        };
        match &self.solid {
            Solid::Raster(raster) => match &*raster.ground {
                Ground::Surface => top_of(&raster.columns),
                _ => raster.ground_of(cell).unwrap_or(VOID),
            },
            Solid::Vector(vector) => match &*vector.ground {
                VectorGround::Flat(z) => *z,
                VectorGround::Terrain { columns, .. } => top_of(columns),
            },
        }
    }

    /// Returns the height of the roof at a place, if a building is there (the one to its north-east
    /// on an edge).
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
        if self.without_data.as_deref().is_some_and(is_void) {
            return None;
        }
        match raster.kind_of(raster.columns.top_at(cell), cell) {
            CellKind::Building(roof) => Some(roof),
            CellKind::Open(_) | CellKind::Void => None,
        }
    }

    /// Returns the height below which a receiver over a cell of the columns is in a building or
    /// below the ground; [`VOID`] where neither is known.
    pub(crate) fn indoors_below_at(&self, cell: usize) -> i32 {
        let Some((columns, _)) = self.solid.columns() else { return VOID };
        let top = Some(columns.top_at(cell)).filter(|top| *top != BLOCKS_ALL).unwrap_or(VOID);
        let Solid::Raster(raster) = &self.solid else { return top };
        let is_void = self.without_data.as_deref().is_some_and(|cells| {
            let n_cols = columns.n_cols();
            cells.contains(cell / n_cols, cell % n_cols)
        });
        match raster.kind_of(top, cell) {
            CellKind::Building(roof) if !is_void => roof,
            _ => raster.ground().map_or(top, |ground| ground.at(cell)),
        }
    }

    /// Returns the heights below a UAV at a place.
    pub fn below_uav(&self, place: &Place) -> BelowUav {
        let ground = self.ground_at(place);
        let surface = ground.max(self.inside_prisms_below(place)).max(self.inside_columns_below(place));
        BelowUav { ground, surface }
    }

    /// Returns the height below which the vertical line at a place is inside the prisms; [`VOID`]
    /// if it is not.
    pub fn inside_prisms_below(&self, place: &Place) -> i32 {
        self.prisms().map_or(VOID, |p| p.solid_below(place.on_prisms.0, place.on_prisms.1))
    }

    /// Returns the height below which the vertical line at a place is inside the columns; [`VOID`]
    /// if it is not.
    pub fn inside_columns_below(&self, place: &Place) -> i32 {
        self.solid.columns().map_or(VOID, |(c, _)| c.solid_below(place.on_columns.0, place.on_columns.1))
    }

    /// Returns the highest obstacle \[1/1024 m\], [`VOID`] if there is none.
    pub fn max_top(&self) -> i32 {
        let prisms = self.prisms().map_or(VOID, Prisms::max_top);
        prisms.max(self.columns().map_or(VOID, Columns::max_top))
    }

    /// Returns the lowest known top of a raster \[1/1024 m\], if it has any.
    pub fn lowest_known(&self) -> Option<i32> {
        self.columns().and_then(Columns::lowest_known)
    }

    /// Returns the surface seen from above at each cell \[m above the datum\], NaN where void.
    pub fn surface_m(&self) -> Vec<f32> {
        self.each_cell(|kind, _| match kind {
            CellKind::Open(z) | CellKind::Building(z) => meters(z),
            CellKind::Void => f64::NAN,
        })
    }

    /// Returns the surface above the ground at each cell \[m\], NaN where void: for shading, which
    /// should show buildings, not hills. With a surface model alone that is the surface itself.
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

    /// Returns a value for each cell, row by row from the north-west, in parallel.
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

    /// Returns a world position on the lattices: rounded to that of the prisms, if there are any,
    /// and from there to that of the columns.
    pub fn place(&self, x: f64, y: f64) -> Place {
        let on_prisms = self.prisms_frame().map(|frame| frame.lattice_from_world(x, y));
        let on_columns = match on_prisms {
            Some(position) => self.on_columns(position),
            None => self.columns_frame().map_or((0, 0), |frame| frame.lattice_from_world(x, y)),
        };
        Place { x, y, on_prisms: on_prisms.unwrap_or((0, 0)), on_columns }
    }

    /// Returns a position of the prisms' lattice on that of the columns.
    fn on_columns(&self, (x, y): (i64, i64)) -> (i64, i64) {
        let (Some(prisms), Some(columns)) = (self.prisms_frame(), self.columns_frame()) else { return (0, 0) };
        #[expect(clippy::cast_precision_loss, reason = "lattice positions in reach are below 2^53")]
        let (x, y) = prisms.world_from_lattice(x as f64, y as f64);
        columns.lattice_from_world(x, y)
    }

    /// Returns the place some steps east and north of another on the lattice of the solids that
    /// make the scene: the prisms where there are any, else the columns.
    pub fn neighbor(&self, place: &Place, (east, north): (i64, i64)) -> Place {
        let Some(frame) = self.prisms_frame().or(self.columns_frame()) else { return *place };
        let steps = f64::from(STEPS_PER_UNIT);
        #[expect(clippy::cast_precision_loss, reason = "a few steps")]
        let (dx, dy) = (east as f64 / steps * frame.unit_x, north as f64 / steps * frame.unit_y);
        let mut moved = self.place(place.x + dx, place.y + dy);
        // Rounding the sum could make no step of one, or two.
        let by = |(x, y): (i64, i64)| (x + east, y + north);
        match self.prisms() {
            Some(_) => {
                moved.on_prisms = by(place.on_prisms);
                moved.on_columns = self.on_columns(moved.on_prisms);
            }
            None => moved.on_columns = by(place.on_columns),
        }
        moved
    }

    /// Returns the cell centers of the receivers' grid on the lattices.
    pub fn positions(&self) -> GridPositions {
        self.positions_on(&self.grid)
    }

    /// Returns the cell centers of any grid on the lattices.
    pub(crate) fn positions_on(&self, grid: &GeoRef) -> GridPositions {
        GridPositions::new(grid, RangeLattice::of(&self.grid, self.prisms().is_some()), |x, y| self.place(x, y))
    }
}

impl RasterSolid {
    /// Returns the ground below a cell, if it is known apart from the surface.
    fn ground_of(&self, cell: usize) -> Option<i32> {
        self.ground().map(|ground| ground.at(cell))
    }

    /// Returns the kind of a cell, given the top of its column.
    #[inline]
    pub(super) fn kind_of(&self, top: i32, cell: usize) -> CellKind {
        if top == VOID || top == BLOCKS_ALL {
            return CellKind::Void;
        }
        match self.ground_of(cell) {
            None => CellKind::Open(top),
            Some(VOID) => CellKind::Void,
            Some(ground) if i64::from(top) - i64::from(ground) > i64::from(self.building_threshold) => {
                CellKind::Building(top)
            }
            Some(ground) => CellKind::Open(ground),
        }
    }
}
