//! Parts of a leg that columns hide.
//!
//! A cell whose closed square holds the receiver is exempt. So what a column hides is its interval
//! less the part of the leg over its square, which can leave two parts.
//!
//! The cells below a triangle of links are searched from tiles of 64 × 64 cells over tiles of 8 × 8
//! down to cells. A tile is left out if its highest top is below the links over it, or if it can
//! only hide what is hidden already.

use super::half_space::{HalfSpace, walls_of_cell};
use super::hidden::{HiddenParts, LegObstacle};
use super::links::{Links, Shape};
use super::plan::{Plan, Span};
use super::region::{HalfPlane, Region};
use super::upright::{CellAlong, cells_along};
use crate::height_field::{Columns, TILE_BITS, TileMaxima};
use crate::quantity::VOID;

/// Adds the parts of a leg that columns hide.
pub(super) fn hide_by_columns(columns: &Columns, links: &Links, hidden: &mut HiddenParts) {
    if i64::from(columns.max_top()) <= links.lowest() {
        return;
    }
    match links.shape() {
        // A vertical link is in line of sight over columns.
        Shape::Plumb => {}
        Shape::Upright => {
            let mut cut = Cut::of(columns, links);
            cells_along(columns, links.ends_in_plane(), links.lowest(), |cell| cut.hide_by(cell, true, hidden));
        }
        Shape::Spread => Search { columns, plan: Plan::new(links), cut: Cut::of(columns, links), hidden }.run(),
    }
}

/// Links that are cut to the region inside a column.
pub(super) struct Cut<'a> {
    columns: &'a Columns,
    links: &'a Links,
    triangle: [HalfPlane; 3],
    region: Region,
}

impl<'a> Cut<'a> {
    pub(super) fn of(columns: &'a Columns, links: &'a Links) -> Cut<'a> {
        Cut { columns, links, triangle: links.triangle(), region: Region::default() }
    }

    /// Adds what a column hides.
    pub(super) fn hide_by(&mut self, cell: &CellAlong, may_hold_receivers: bool, hidden: &mut HiddenParts) {
        let walls = walls_of_cell(self.columns, cell.at);
        self.region.restart(&self.triangle);
        let mut keep = |space: &HalfSpace| {
            let line = self.links.half_plane(space);
            // A grid line in the plane of the links does not bound the cell.
            line.is_zero() || self.region.keep(&line)
        };
        if !walls.iter().all(&mut keep) || !self.region.keep(&self.links.half_plane(&HalfSpace::below(cell.top))) {
            return;
        }
        let Some(part) = self.region.part() else { return };
        let obstacle = LegObstacle::Cell(cell.index);
        match if may_hold_receivers { self.links.part_inside(walls) } else { None } {
            None => hidden.add(part, obstacle),
            Some(own) => part.without(&own).for_each(|part| hidden.add(part, obstacle)),
        }
    }
}

/// A search for the cells that hide parts of a leg.
struct Search<'a, 'b> {
    columns: &'a Columns,
    plan: Plan,
    cut: Cut<'a>,
    hidden: &'b mut HiddenParts,
}

/// A square tile of cells, by rows from the north and columns of cells.
#[derive(Clone, Copy)]
struct Tile {
    bits: u32,
    row: usize,
    col: usize,
}

impl Search<'_, '_> {
    fn run(mut self) {
        let [width, height] = self.columns.steps();
        let (n_rows, n_cols) = (self.columns.n_rows(), self.columns.n_cols());
        let bits = 2 * TILE_BITS;
        let [south, north] = self.plan.y_range();
        // Rows count from the north.
        let rows = [-north, -south].map(|y| tile_of(y + extent(n_rows, height), height, n_rows, bits));
        for row in rows[0]..=rows[1] {
            let [south, north] = self.rows(Tile { bits, row, col: 0 });
            #[expect(clippy::cast_precision_loss, reason = "positions have a margin of a step")]
            let Some(range) = self.plan.x_range(south as f64, north as f64) else { continue };
            if range[1] < 0.0 || range[0] > extent(n_cols, width) {
                continue;
            }
            let cols = range.map(|x| tile_of(x, width, n_cols, bits));
            for col in cols[0]..=cols[1] {
                self.visit(Tile { bits, row, col });
            }
        }
    }

    /// Searches a tile, or decides a cell.
    fn visit(&mut self, tile: Tile) {
        let top = self.highest(tile);
        let Some(span) = self.span(tile).filter(|span| top > VOID && f64::from(top) > span.lowest) else { return };
        #[expect(clippy::cast_precision_loss, reason = "the size of a cell")]
        let size = self.columns.steps().map(|steps| steps as f64);
        let each = (span.to - span.from).min(self.plan.longest_of_cell(&span, size));
        if self.hidden.are_hidden(span.from, span.to, each) {
            return;
        }
        if tile.bits > 0 {
            let bits = tile.bits - TILE_BITS;
            let until = |last: usize, n: usize| ((last + 1) << TILE_BITS).min(n.div_ceil(1 << bits));
            for row in tile.row << TILE_BITS..until(tile.row, self.columns.n_rows()) {
                for col in tile.col << TILE_BITS..until(tile.col, self.columns.n_cols()) {
                    self.visit(Tile { bits, row, col });
                }
            }
            return;
        }
        let index = tile.row * self.columns.n_cols() + tile.col;
        let at = (signed(tile.col), signed(self.columns.n_rows() - 1 - tile.row));
        self.cut.hide_by(&CellAlong { at, index, top }, span.holds_receivers, self.hidden);
    }

    /// Returns the highest top of a tile.
    fn highest(&self, tile: Tile) -> i32 {
        let of = |tiles: &TileMaxima| tiles.maxima()[tile.row * tiles.per_row() + tile.col];
        match tile.bits {
            0 => self.columns.top_at(tile.row * self.columns.n_cols() + tile.col),
            TILE_BITS => of(self.columns.tiles()),
            _ => of(self.columns.tiles_of_tiles()),
        }
    }

    /// Returns the range of y of the rows of a tile.
    fn rows(&self, tile: Tile) -> [i64; 2] {
        let (n_rows, height) = (signed(self.columns.n_rows()), self.columns.steps()[1]);
        let [north, south] = [tile.row, tile.row + 1].map(|row| signed(row << tile.bits));
        [(n_rows - south).max(0) * height, (n_rows - north) * height]
    }

    fn span(&self, tile: Tile) -> Option<Span> {
        let (n_cols, width) = (signed(self.columns.n_cols()), self.columns.steps()[0]);
        let [west, east] = [tile.col, tile.col + 1].map(|col| signed(col << tile.bits).min(n_cols) * width);
        let [south, north] = self.rows(tile);
        self.plan.span([[west, south], [east, south], [east, north], [west, north]].into_iter())
    }
}

#[expect(clippy::cast_possible_wrap, reason = "a raster in memory has far fewer than 2^63 cells")]
fn signed(n: usize) -> i64 {
    n as i64
}

/// Returns the extent of some cells.
#[expect(clippy::cast_precision_loss, reason = "positions have a margin of a step")]
fn extent(cells: usize, size: i64) -> f64 {
    (signed(cells) * size) as f64
}

/// Returns the tile that holds a position, the nearest one outside of the raster.
fn tile_of(v: f64, size: i64, cells: usize, bits: u32) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "saturates, and is clamped to the raster"
    )]
    let cell = (v / size as f64).floor() as usize;
    cell.min(cells - 1) >> bits
}
