//! The cells of a raster that a ray crosses from a receiver inside it, one by one or past whole
//! tiles.
//!
//! **Tiles.** The highest tops of tiles of 8 × 8 and of 64 × 64 cells are known. If a tile's
//! highest top cannot matter, the walk continues beyond the tile. The two lines across which the
//! ray may leave it are at known distances, and the ray leaves across the nearer one. One division
//! gives the number of lines of the other axis crossed by then. So a link past a city costs its
//! first cells and some tiles.

use std::ops::ControlFlow;

use super::cell_walk::Crossing;
use crate::height_field::{Columns, TILE_BITS};
use crate::quantity::{LatticePoint, STEPS_PER_UNIT};

/// Edge length of a cell on the lattice of a raster scene.
const CELL: i64 = STEPS_PER_UNIT as i64;

/// Returns the cell that holds a position along an axis, on an edge the farther one.
///
/// PERF: cells of raster scenes have 1024 steps, which needs no division.
#[inline(always)]
pub(super) fn cell_of(v: i64, cell: i64) -> i64 {
    if cell == CELL { v.div_euclid(CELL) } else { v.div_euclid(cell) }
}

/// Returns the offset of a position within its cell.
#[inline(always)]
pub(super) fn into_cell(v: i64, cell: i64) -> i64 {
    if cell == CELL { v.rem_euclid(CELL) } else { v.rem_euclid(cell) }
}

impl Columns {
    /// Returns the index of the first cell of a ray that leaves `from` in direction `(dx, dy)`, if
    /// it lies in the raster.
    pub(super) fn cell_towards(&self, from: LatticePoint, dx: i64, dy: i64) -> Option<usize> {
        let [width, height] = self.steps();
        let first = |v: i64, d: i64, cell: i64| cell_of(if d < 0 { v - 1 } else { v }, cell);
        self.index(first(from.x, dx, width), first(from.y, dy, height))
    }
}

/// A walk over the cells of a raster, from a receiver inside it, along a ray that is on no grid
/// line.
///
/// INVARIANT: `index` is the current cell. `next` are the distances \[lattice steps\] along x and y
/// from the receiver to the grid lines that the ray may cross next. The lower one of
/// `order = (next.0·|dy|, next.1·|dx|)` is crossed first. For a ray along an axis, the order of the
/// other axis is `i64::MAX`.
///
/// PERF: the same cells as [`CellWalk`](super::cell_walk::CellWalk) at a third of its cost, because
/// nothing is multiplied or range checked per step.
pub(super) struct InnerWalk {
    pub(super) index: usize,
    next: (i64, i64),
    order: (i64, i64),
    growth: (i64, i64),
    pub(super) length: (i64, i64),
    /// Distance along each axis up to which a crossing counts: short of the UAV, and inside the
    /// raster.
    pub(super) reach: (i64, i64),
    stride: (isize, isize),
    /// Width and height of a cell.
    cell: [i64; 2],
}

impl InnerWalk {
    /// Starts a walk in cell `own`, the receiver's.
    pub(super) fn new(columns: &Columns, own: usize, uav: LatticePoint, receiver: LatticePoint) -> Self {
        let (dx, dy) = (uav.x - receiver.x, uav.y - receiver.y);
        let length = (dx.abs(), dy.abs());
        let cell = columns.steps();
        let (width, height) = (extent(columns.n_cols(), cell[0]), extent(columns.n_rows(), cell[1]));
        let to_border = |v: i64, d: i64, size: i64| if d < 0 { v } else { size - v };
        // Farther than any line of the proven range.
        const FAR: i64 = 1 << 32;
        let to_line = |v: i64, d: i64, cell: i64| match d.signum() {
            1 => cell - into_cell(v, cell),
            -1 => into_cell(v - 1, cell) + 1,
            _ => FAR,
        };
        let next = (to_line(receiver.x, dx, cell[0]), to_line(receiver.y, dy, cell[1]));
        // A ray along an axis never meets the lines of the other axis.
        let (order, growth) = match length {
            (0, _) => ((i64::MAX, next.1), (0, cell[1])),
            (_, 0) => ((next.0, i64::MAX), (cell[0], 0)),
            _ => ((next.0 * length.1, next.1 * length.0), (cell[0] * length.1, cell[1] * length.0)),
        };
        #[expect(clippy::cast_possible_wrap, reason = "a raster in memory has far fewer than 2^63 cells")]
        let row = columns.n_cols() as isize;
        InnerWalk {
            index: own,
            next,
            order,
            growth,
            length,
            reach: (length.0.min(to_border(receiver.x, dx, width)), length.1.min(to_border(receiver.y, dy, height))),
            stride: (if dx < 0 { -1 } else { 1 }, if dy < 0 { row } else { -row }),
            cell,
        }
    }

    /// Steps into the next cell and returns the crossing of its border; `None` once no crossing
    /// counts any more.
    #[inline(always)]
    pub(super) fn step(&mut self) -> Option<Crossing> {
        let by_x = self.order.0 <= self.order.1;
        let at_corner = self.order.0 == self.order.1;
        let (n, d) = if by_x { (self.next.0, self.length.0) } else { (self.next.1, self.length.1) };
        if by_x {
            if self.next.0 >= self.reach.0 {
                return None;
            }
            self.index = self.index.wrapping_add_signed(self.stride.0);
            self.next.0 += self.cell[0];
            self.order.0 += self.growth.0;
        }
        // At a corner both indices step at once.
        if !by_x || at_corner {
            if self.next.1 >= self.reach.1 {
                return None;
            }
            self.index = self.index.wrapping_add_signed(self.stride.1);
            self.next.1 += self.cell[1];
            self.order.1 += self.growth.1;
        }
        Some(Crossing { n, d })
    }

    /// Returns the crossing at which the ray leaves the current cell, or the ray's end.
    #[inline(always)]
    pub(super) fn exit(&self) -> Crossing {
        let by_x = self.order.0 <= self.order.1;
        let (n, d) = if by_x { (self.next.0, self.length.0) } else { (self.next.1, self.length.1) };
        if n < d { Crossing { n, d } } else { Crossing { n: 1, d: 1 } }
    }
}

/// The exit of a ray from a tile around the current cell.
#[derive(Clone, Copy)]
struct Leaving {
    /// The highest top of the tile.
    highest: i32,
    /// Number of lines of constant x, and of constant y, that the ray crosses up to the tile's
    /// border on that axis, border included.
    lines: (i64, i64),
    /// `true` if it leaves across a line of constant x.
    by_x: bool,
    /// The order of that line, as in [`InnerWalk::order`].
    order: i64,
    /// The crossing of that line.
    crossing: Crossing,
}

impl InnerWalk {
    /// Returns the ray's exit from the tile of 8 × 8 cells around the current one, or of 64 × 64.
    #[inline(always)]
    fn leaving(&self, columns: &Columns, tiles_of_tiles: bool) -> Leaving {
        let (bits, tiles) =
            if tiles_of_tiles { (2 * TILE_BITS, columns.tiles_of_tiles()) } else { (TILE_BITS, columns.tiles()) };
        let (row, col) = (self.index / columns.n_cols(), self.index % columns.n_cols());
        let size = 1_usize << bits;
        let lines = |forward: bool, at: usize| {
            let before = at & (size - 1);
            if forward { size - before } else { before + 1 }
        };
        #[expect(clippy::cast_possible_wrap, reason = "at most 64")]
        let lines = (lines(self.stride.0 > 0, col) as i64, lines(self.stride.1 > 0, row) as i64);
        let order = (self.order.0 + (lines.0 - 1) * self.growth.0, self.order.1 + (lines.1 - 1) * self.growth.1);
        let by_x = order.0 <= order.1;
        let (n, d) = if by_x {
            (self.next.0 + (lines.0 - 1) * self.cell[0], self.length.0)
        } else {
            (self.next.1 + (lines.1 - 1) * self.cell[1], self.length.1)
        };
        let highest = tiles.maxima()[(row >> bits) * tiles.per_row() + (col >> bits)];
        Leaving { highest, lines, by_x, order: if by_x { order.0 } else { order.1 }, crossing: Crossing { n, d } }
    }

    /// Continues beyond a tile; returns `false` once no crossing counts any more.
    #[inline(always)]
    fn leave(&mut self, leaving: &Leaving) -> bool {
        // Lines crossed no later than the one across which it leaves; at a corner both are crossed
        // at once.
        let up_to =
            |order: i64, growth: i64| if order <= leaving.order { (leaving.order - order) / growth + 1 } else { 0 };
        let passed = if leaving.by_x {
            (leaving.lines.0, up_to(self.order.1, self.growth.1))
        } else {
            (up_to(self.order.0, self.growth.0), leaving.lines.1)
        };
        self.next.0 += passed.0 * self.cell[0];
        self.next.1 += passed.1 * self.cell[1];
        let is_beyond = |next: i64, cell: i64, n: i64, reach: i64| n > 0 && next - cell >= reach;
        if is_beyond(self.next.0, self.cell[0], passed.0, self.reach.0)
            || is_beyond(self.next.1, self.cell[1], passed.1, self.reach.1)
        {
            return false;
        }
        self.order.0 += passed.0 * self.growth.0;
        self.order.1 += passed.1 * self.growth.1;
        #[expect(clippy::cast_possible_truncation, reason = "at most 64 lines")]
        let (by_cols, by_rows) = (passed.0 as isize * self.stride.0, passed.1 as isize * self.stride.1);
        self.index = self.index.wrapping_add_signed(by_cols + by_rows);
        true
    }

    /// Visits the cells after the receiver's own, each with the ray's entry and exit. Tiles that do
    /// not matter are skipped.
    ///
    /// `matters` gets the highest top of a tile and the ray's entry and exit there. It must return
    /// `true` if it would for any cell within.
    #[inline(always)]
    pub(super) fn visit(
        mut self,
        columns: &Columns,
        matters: impl Fn(i32, Crossing, Crossing) -> bool,
        mut visit: impl FnMut(usize, Crossing, Crossing) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let clipped = |crossing: Crossing| if crossing.n < crossing.d { crossing } else { Crossing { n: 1, d: 1 } };
        let (mut tile, mut large) = (self.leaving(columns, false), self.leaving(columns, true));
        loop {
            // The rest of a tile cell by cell.
            let mut near;
            let mut passed;
            loop {
                passed = self.order.0.min(self.order.1);
                let Some(entered) = self.step() else { return ControlFlow::Continue(()) };
                near = entered;
                if passed >= tile.order {
                    break;
                }
                visit(self.index, near, self.exit())?;
            }
            // Past tiles; a larger one is tested once, where the ray enters it.
            loop {
                let is_new = passed >= large.order;
                if is_new {
                    if !matters(columns.max_top(), near, Crossing { n: 1, d: 1 }) {
                        return ControlFlow::Continue(());
                    }
                    large = self.leaving(columns, true);
                }
                let next = if is_new && !matters(large.highest, near, clipped(large.crossing)) {
                    &large
                } else {
                    tile = self.leaving(columns, false);
                    if matters(tile.highest, near, clipped(tile.crossing)) {
                        break;
                    }
                    &tile
                };
                (near, passed) = (next.crossing, next.order);
                if !self.leave(next) {
                    return ControlFlow::Continue(());
                }
            }
            visit(self.index, near, self.exit())?;
        }
    }
}

fn extent(cells: usize, cell: i64) -> i64 {
    i64::try_from(cells).unwrap_or(i64::MAX / cell) * cell
}
