//! Position of the cells of a raster in the plane of a coordinate reference system.

use super::Crs;

/// A north-up grid of equal rectangular cells.
///
/// Cell `(row, col)` covers `x_min + col·cell_width ≤ x < x_min + (col+1)·cell_width` and
/// `y_max − (row+1)·cell_height ≤ y < y_max − row·cell_height`. It is half-open towards the
/// north-east, so that a point on an edge belongs to the cell north or east of it.
///
/// A part of a grid remembers the corner of the whole grid, so that the centers of its cells are
/// exactly the same numbers.
#[derive(Debug, Clone)]
pub struct GeoRef {
    /// North-west corner of the whole grid that this is a part of.
    corner: (f64, f64),
    /// First row and column of this part in the whole grid.
    first: (usize, usize),
    cell_width: f64,
    cell_height: f64,
    n_cols: usize,
    n_rows: usize,
    crs: Option<Crs>,
}

impl PartialEq for GeoRef {
    /// Returns `true` if two grids have the same cells, regardless of the grids that they were cut
    /// from.
    fn eq(&self, other: &GeoRef) -> bool {
        let numbers = |grid: &GeoRef| [grid.x_min(), grid.y_max(), grid.cell_width, grid.cell_height];
        let shape = |grid: &GeoRef| (grid.n_rows, grid.n_cols);
        numbers(self) == numbers(other) && shape(self) == shape(other) && self.crs == other.crs
    }
}

/// A rectangle of cells: rows `row..row + n_rows`, columns `col..col + n_cols`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellWindow {
    /// First (northernmost) row.
    pub row: usize,
    /// First (westernmost) column.
    pub col: usize,
    /// Number of rows.
    pub n_rows: usize,
    /// Number of columns.
    pub n_cols: usize,
}

impl GeoRef {
    /// Makes a grid from its north-west corner `(x_min, y_max)`, its cell size and its shape, all
    /// lengths in units of the CRS.
    ///
    /// Returns `None` unless all of these hold:
    ///
    /// * All numbers are finite.
    /// * A cell is 10^-9 to 10^12 units wide and high, and does not vanish in the rounding of the
    ///   coordinates.
    /// * There is at least one cell, and the number of cells fits in `usize`.
    pub fn new(
        (x_min, y_max): (f64, f64),
        (cell_width, cell_height): (f64, f64),
        (n_rows, n_cols): (usize, usize),
        crs: Option<Crs>,
    ) -> Option<Self> {
        let finite = [x_min, y_max, cell_width, cell_height].iter().all(|v| v.is_finite());
        let sensible = [cell_width, cell_height].iter().all(|side| (1e-9..=1e12).contains(side));
        let countable = n_rows.checked_mul(n_cols).is_some_and(|n| n > 0);
        // A thousandth of a cell must exceed the rounding of coordinates at either end.
        let told_apart = |from: f64, cell: f64, n: usize| {
            let to = from + cell * n as f64;
            from.abs().max(to.abs()) * f64::EPSILON < 1e-3 * cell.abs()
        };
        let told_apart = told_apart(x_min, cell_width, n_cols) && told_apart(y_max, -cell_height, n_rows);
        (finite && sensible && countable && told_apart).then_some(GeoRef {
            corner: (x_min, y_max),
            first: (0, 0),
            cell_width,
            cell_height,
            n_cols,
            n_rows,
            crs,
        })
    }

    /// Returns the west edge \[CRS units\].
    #[inline]
    pub fn x_min(&self) -> f64 {
        self.x_of(0.0)
    }

    /// Returns the east edge \[CRS units\].
    pub fn x_max(&self) -> f64 {
        self.x_of(self.n_cols as f64)
    }

    /// Returns the south edge \[CRS units\].
    pub fn y_min(&self) -> f64 {
        self.y_of(self.n_rows as f64)
    }

    /// Returns the north edge \[CRS units\].
    #[inline]
    pub fn y_max(&self) -> f64 {
        self.y_of(0.0)
    }

    /// Returns world x of a position in columns from the west edge.
    #[inline]
    fn x_of(&self, col: f64) -> f64 {
        self.corner.0 + (self.first.1 as f64 + col) * self.cell_width
    }

    /// Returns world y of a position in rows from the north edge.
    #[inline]
    fn y_of(&self, row: f64) -> f64 {
        self.corner.1 - (self.first.0 as f64 + row) * self.cell_height
    }

    /// Returns this grid's first row and column in the grid that it was cut from.
    pub(crate) fn first_of_whole(&self) -> (usize, usize) {
        self.first
    }

    /// Returns the north-west corner of the grid that this one was cut from \[CRS units\]. All its
    /// parts share it.
    pub(crate) fn corner_of_whole(&self) -> (f64, f64) {
        self.corner
    }

    /// Returns the length of a CRS unit \[m\]; 1 for local coordinates.
    pub fn meters_per_unit(&self) -> f64 {
        self.crs.as_ref().map_or(1.0, Crs::meters_per_unit)
    }

    /// Returns the width of a cell, west to east \[CRS units\].
    #[inline]
    pub fn cell_width(&self) -> f64 {
        self.cell_width
    }

    /// Returns the height of a cell, north to south \[CRS units\].
    #[inline]
    pub fn cell_height(&self) -> f64 {
        self.cell_height
    }

    /// Returns the number of columns.
    #[inline]
    pub fn n_cols(&self) -> usize {
        self.n_cols
    }

    /// Returns the number of rows.
    #[inline]
    pub fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// Returns the number of cells.
    #[inline]
    pub fn n_cells(&self) -> usize {
        self.n_cols * self.n_rows
    }

    /// Returns the coordinate reference system; `None` if local.
    pub fn crs(&self) -> Option<&Crs> {
        self.crs.as_ref()
    }

    /// Gives the grid another coordinate reference system, or none.
    #[must_use]
    pub fn with_crs(mut self, crs: Option<Crs>) -> Self {
        self.crs = crs;
        self
    }

    /// Returns the whole grid as a window.
    pub fn window(&self) -> CellWindow {
        CellWindow { row: 0, col: 0, n_rows: self.n_rows, n_cols: self.n_cols }
    }

    /// Returns the part of the grid that `window` covers.
    #[must_use]
    pub fn part(&self, window: CellWindow) -> GeoRef {
        assert!(window.n_rows > 0 && window.n_cols > 0, "a window holds at least one cell");
        assert!(window.row + window.n_rows <= self.n_rows && window.col + window.n_cols <= self.n_cols);
        GeoRef {
            first: (self.first.0 + window.row, self.first.1 + window.col),
            n_cols: window.n_cols,
            n_rows: window.n_rows,
            ..self.clone()
        }
    }

    /// Returns the smallest window of this grid that holds every cell under another grid, and a
    /// cell around it. Returns `None` if the grids do not touch.
    pub fn window_over(&self, other: &GeoRef) -> Option<CellWindow> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
        let clip = |low: f64, high: f64, n: usize| {
            let (low, high) = ((low - 1.0).floor().max(0.0), (high + 1.0).ceil().min(n as f64));
            (low < high).then_some((low as usize, high as usize))
        };
        let of_x = |x: f64| (x - self.x_min()) / self.cell_width;
        let of_y = |y: f64| (self.y_max() - y) / self.cell_height;
        let (west, east) = clip(of_x(other.x_min()), of_x(other.x_max()), self.n_cols)?;
        let (north, south) = clip(of_y(other.y_max()), of_y(other.y_min()), self.n_rows)?;
        Some(CellWindow { row: north, col: west, n_rows: south - north, n_cols: east - west })
    }

    /// Returns the window whose cells are those of another grid, to within a millionth of a cell;
    /// `None` if there is none.
    pub fn window_of(&self, other: &GeoRef) -> Option<CellWindow> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to lie within the grid")]
        let offset = |cells: f64, n: usize, n_other: usize| {
            let is_whole = (cells - cells.round()).abs() <= 1e-6;
            (is_whole && cells.round() >= 0.0 && cells.round() + n_other as f64 <= n as f64)
                .then_some(cells.round() as usize)
        };
        let col = offset((other.x_min() - self.x_min()) / self.cell_width, self.n_cols, other.n_cols)?;
        let row = offset((self.y_max() - other.y_max()) / self.cell_height, self.n_rows, other.n_rows)?;
        let window = CellWindow { row, col, n_rows: other.n_rows, n_cols: other.n_cols };
        self.part(window).same_grid(other).then_some(window)
    }

    /// Returns a window that holds every cell that touches a box, west, south, east, north \[CRS
    /// units\]. It may hold one more cell on each side. If no cell touches the box, it holds the
    /// nearest one.
    pub fn window_within(&self, [west, south, east, north]: [f64; 4]) -> CellWindow {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
        let clip = |low: f64, high: f64, n: usize| {
            let low = (low.floor() - 1.0).clamp(0.0, n as f64 - 1.0) as usize;
            (low, ((high.ceil() + 1.0).clamp(0.0, n as f64) as usize).max(low + 1))
        };
        let (col, end_col) =
            clip((west - self.x_min()) / self.cell_width, (east - self.x_min()) / self.cell_width, self.n_cols);
        let (row, end_row) =
            clip((self.y_max() - north) / self.cell_height, (self.y_max() - south) / self.cell_height, self.n_rows);
        CellWindow { row, col, n_rows: end_row - row, n_cols: end_col - col }
    }

    /// Returns a grid over this extent, grown to whole cells, from the same north-west corner. Its
    /// cells are `factor` times as wide and high.
    pub fn coarser(&self, factor: usize) -> GeoRef {
        GeoRef {
            corner: (self.x_min(), self.y_max()),
            first: (0, 0),
            cell_width: self.cell_width * factor as f64,
            cell_height: self.cell_height * factor as f64,
            n_cols: self.n_cols.div_ceil(factor),
            n_rows: self.n_rows.div_ceil(factor),
            ..self.clone()
        }
    }

    /// Returns the center of a cell in the plane \[CRS units\].
    #[inline]
    pub fn world_from_cell(&self, row: usize, col: usize) -> (f64, f64) {
        (self.x_of(col as f64 + 0.5), self.y_of(row as f64 + 0.5))
    }

    /// Returns a corner of cells in the plane \[CRS units\], from its columns east and rows north
    /// of the south-west corner.
    pub fn world_from_corner(&self, [x, y]: [usize; 2]) -> [f64; 2] {
        [self.x_min() + x as f64 * self.cell_width, self.y_min() + y as f64 * self.cell_height]
    }

    /// Converts a world position to cells east and north of the south-west corner.
    pub fn cells_from_world(&self, x: f64, y: f64) -> (f64, f64) {
        ((x - self.x_min()) / self.cell_width, (y - self.y_max()) / self.cell_height + self.n_rows as f64)
    }

    /// Returns row and column of the cell that holds a position \[CRS units\]; `None` outside. A
    /// position on an edge belongs to the cell north-east of it.
    pub fn cell_at(&self, x: f64, y: f64) -> Option<(usize, usize)> {
        let (east, north) = self.cells_from_world(x, y);
        let is_inside = east >= 0.0 && north >= 0.0 && east < self.n_cols as f64 && north < self.n_rows as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the grid")]
        let cell = || (self.n_rows - 1 - north as usize, east as usize);
        is_inside.then(cell)
    }

    /// Describes shape, cell size and north-west corner, for messages about grids that differ.
    pub fn description(&self) -> String {
        let (width, height) = (self.cell_width, self.cell_height);
        format!("{}×{} cells of {width}×{height} from ({}, {})", self.n_cols, self.n_rows, self.x_min(), self.y_max())
    }

    /// Returns `true` if two grids are the same to within a millionth of a cell. The CRS is
    /// ignored.
    pub fn same_grid(&self, other: &GeoRef) -> bool {
        let close = |a: f64, b: f64, unit: f64| (a - b).abs() <= 1e-6 * unit;
        self.n_cols == other.n_cols
            && self.n_rows == other.n_rows
            && close(self.x_min(), other.x_min(), self.cell_width)
            && close(self.y_max(), other.y_max(), self.cell_height)
            && close(self.x_max(), other.x_max(), self.cell_width)
            && close(self.y_min(), other.y_min(), self.cell_height)
    }
}
