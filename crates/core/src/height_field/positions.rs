//! Positions of a scene on the lattices of its solids.

use crate::quantity::{Frame, LatticePoint, STEPS_PER_UNIT};
use crate::raster::{CellLattice, GeoRef};

/// A position in the plane on the lattices of both solids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// World x \[CRS units\].
    pub x: f64,
    /// World y \[CRS units\].
    pub y: f64,
    pub(super) on_prisms: (i64, i64),
    pub(super) on_columns: (i64, i64),
}

impl Place {
    /// This lattice position, told by the world position that it was rounded from.
    pub(crate) fn told_as(self, x: f64, y: f64) -> Self {
        Place { x, y, ..self }
    }

    /// Returns a world position on the lattice of the cells of a grid, in a scene without prisms.
    pub(crate) fn on_cells(grid: &GeoRef, x: f64, y: f64) -> Self {
        Place { x, y, on_prisms: (0, 0), on_columns: cell_frame(grid).lattice_from_world(x, y) }
    }
}

/// An end of a link: a place and a height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Place in the plane.
    pub place: Place,
    /// Height \[1/1024 m above the datum\].
    pub z: i64,
}

impl Station {
    /// Returns the end on the lattice of the prisms.
    #[inline]
    pub fn on_prisms(&self) -> LatticePoint {
        LatticePoint { x: self.place.on_prisms.0, y: self.place.on_prisms.1, z: self.z }
    }

    /// Returns the end on the lattice of the columns.
    #[inline]
    pub fn on_columns(&self) -> LatticePoint {
        LatticePoint { x: self.place.on_columns.0, y: self.place.on_columns.1, z: self.z }
    }
}

/// The lattice on which distances are told: whole steps to a cell of the receivers, so that cells
/// at equal distances on all sides stay so, whatever their size is. In a raster scene it is that of
/// the columns, in a vector scene no coarser than that of the prisms. It begins at the corner of
/// the whole grid, so that all parts of a grid tell the same distances.
#[derive(Debug, Clone, Copy)]
pub(super) struct RangeLattice {
    frame: Frame,
    steps_per_cell: f64,
}

impl RangeLattice {
    pub(super) fn of(receivers: &GeoRef, has_prisms: bool) -> Self {
        let (x_origin, y_origin) = receivers.corner_of_whole();
        let frame = Frame { x_origin, y_origin, ..cell_frame(receivers) };
        let cells = if has_prisms { frame.unit_x.max(frame.unit_y).ceil().max(1.0) } else { 1.0 };
        RangeLattice { frame, steps_per_cell: cells * f64::from(STEPS_PER_UNIT) }
    }

    /// Returns the length of a step along x and y \[CRS units\].
    #[inline]
    fn step_lengths(&self) -> (f64, f64) {
        (self.frame.unit_x / self.steps_per_cell, self.frame.unit_y / self.steps_per_cell)
    }

    /// Returns the lattice position nearest to world `(x, y)`; halves go north-east.
    fn at(&self, x: f64, y: f64) -> (i64, i64) {
        #[expect(clippy::cast_possible_truncation, reason = "far outside it saturates, which is out of any range")]
        let round = |cells: f64| (cells * self.steps_per_cell + 0.5).floor() as i64;
        (round((x - self.frame.x_origin) / self.frame.unit_x), round((y - self.frame.y_origin) / self.frame.unit_y))
    }
}

/// A coordinate of a cell center: of the world, on the lattices of prisms and columns, and of
/// distances.
type Center = (f64, i64, i64, i64);

/// Lattice positions of the cell centers of a grid.
#[derive(Debug, Clone)]
pub struct GridPositions {
    xs: Vec<Center>,
    ys: Vec<Center>,
    range: RangeLattice,
}

impl GridPositions {
    /// Returns the positions of the cells of a grid in a scene without prisms.
    pub(crate) fn on_cells(grid: &GeoRef) -> Self {
        GridPositions::new(grid, RangeLattice::of(grid, false), |x, y| Place::on_cells(grid, x, y))
    }

    pub(super) fn new(grid: &GeoRef, range: RangeLattice, place: impl Fn(f64, f64) -> Place) -> Self {
        let xs = (0..grid.n_cols()).map(|col| {
            let place = place(grid.world_from_cell(0, col).0, grid.y_min());
            (place.x, place.on_prisms.0, place.on_columns.0, range.at(place.x, place.y).0)
        });
        let ys = (0..grid.n_rows()).map(|row| {
            let place = place(grid.x_min(), grid.world_from_cell(row, 0).1);
            (place.y, place.on_prisms.1, place.on_columns.1, range.at(place.x, place.y).1)
        });
        GridPositions { xs: xs.collect(), ys: ys.collect(), range }
    }

    /// Returns the number of rows and of columns.
    pub fn shape(&self) -> (usize, usize) {
        (self.ys.len(), self.xs.len())
    }

    /// Returns the length of a step of distances along x and y \[CRS units\].
    #[inline]
    pub fn step_lengths(&self) -> (f64, f64) {
        self.range.step_lengths()
    }

    /// Returns a place on the lattice of distances.
    #[inline]
    pub fn on_range(&self, place: &Place) -> (i64, i64) {
        self.range.at(place.x, place.y)
    }

    /// Steps of distances to the east and north, from a place on their lattice to the center of the
    /// cell in a row and column.
    #[inline]
    pub fn steps(&self, (x, y): (i64, i64), (row, col): (usize, usize)) -> (i64, i64) {
        (self.xs[col].3 - x, self.ys[row].3 - y)
    }

    /// Returns positions on the columns' lattice: of the columns of cells, west to east, and of
    /// their rows, north to south.
    pub fn on_columns(&self) -> (Vec<i64>, Vec<i64>) {
        (self.xs.iter().map(|x| x.2).collect(), self.ys.iter().map(|y| y.2).collect())
    }

    /// Returns positions on the prisms' lattice: of the columns of cells, west to east, and of
    /// their rows, north to south.
    pub fn on_prisms(&self) -> (Vec<i64>, Vec<i64>) {
        (self.xs.iter().map(|x| x.1).collect(), self.ys.iter().map(|y| y.1).collect())
    }

    /// Returns the center of a cell.
    #[inline]
    pub fn center(&self, row: usize, col: usize) -> Place {
        let ((x, prisms_x, columns_x, _), (y, prisms_y, columns_y, _)) = (self.xs[col], self.ys[row]);
        Place { x, y, on_prisms: (prisms_x, prisms_y), on_columns: (columns_x, columns_y) }
    }
}

/// Returns the lattice of the columns over the cells of a grid, in a raster scene.
pub(crate) fn cell_frame(georef: &GeoRef) -> Frame {
    CellLattice::of_cells(georef).frame
}
