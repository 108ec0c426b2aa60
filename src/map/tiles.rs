//! Tiles of the ground: maps with `{row}` and `{col}` in the names of their files, for sums over
//! many UAVs.
//!
//! The grid of the scene is cut into squares of cells, from its north-west corner. Each square is a
//! unit of work. It takes the UAVs that have one of its cells in range, reads the ground between
//! itself and them, and writes files of its own. No files are added up afterwards. A cell counts
//! the same as in a map of the whole.

use std::collections::{HashMap, HashSet};

use serde::Serialize;

use skyshed_request::{Shard, TileIndex};

use crate::city::GivenSite;
use crate::error::{Error, Result};
use crate::raster::{CellWindow, GeoRef};
use crate::sight::SightPlan;
use crate::uav::UavsFound;

/// Placeholders for the row and the column of a tile in the name of a file.
pub(crate) const ROW_AND_COL: [&str; 2] = ["{row}", "{col}"];

/// Cells along a side of a tile by default: four by four blocks of a cloud-optimized GeoTIFF.
const CELLS_PER_SIDE: usize = 2048;

/// Requested tiles.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct TilesAsked {
    /// Cells along a side; `None` for the default.
    pub(crate) cells_per_side: Option<usize>,
    /// Tiles to map: row from the north, column from the west, from 0. Empty for all tiles.
    pub(crate) only: Vec<(usize, usize)>,
}

/// Square of cells of the whole grid, with the UAVs that have one of them in range.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Tile {
    /// Row from the north, from 0.
    pub(crate) row: usize,
    /// Column from the west, from 0.
    pub(crate) col: usize,
    /// Cells along a side of a whole tile.
    pub(crate) cells_per_side: usize,
    /// Its cells.
    pub(crate) window: CellWindow,
    /// Its UAVs, by their indices in the list of all.
    pub(crate) uavs: Vec<usize>,
}

/// A tile, in documents.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub(crate) struct TileFacts {
    /// Row of the tile from the north, from 0.
    pub(crate) row: usize,
    /// Column of the tile from the west, from 0.
    pub(crate) col: usize,
    /// Cells along a side of a whole tile.
    pub(crate) cells_per_side: usize,
    /// Number of each site in the list of all UAVs, from 1, if a layer holds such numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) numbers: Option<Vec<usize>>,
}

impl TilesAsked {
    /// Returns a request of all tiles, or of some. A tile that was typed twice counts once.
    pub(crate) fn of(cells_per_side: Option<usize>, only: &[TileIndex]) -> Self {
        let mut seen = HashSet::new();
        let only = only.iter().map(|tile| (tile.row, tile.col)).filter(|tile| seen.insert(*tile)).collect();
        TilesAsked { cells_per_side, only }
    }

    /// Returns the requested tiles of a grid with the UAVs of each: row by row from the north-west,
    /// or in the order in which they were named. A shard selects some of them.
    ///
    /// Cost: one step for each tile, and one for each pair of a UAV and a tile in its range. Tiles
    /// of other shards cost nothing.
    ///
    /// # Errors
    /// E113 for a tile that the grid does not have.
    pub(crate) fn tiles(
        &self,
        (grid, shard): (&GeoRef, Option<Shard>),
        sites: &[GivenSite],
        sight: &SightPlan,
    ) -> Result<Vec<Tile>> {
        let side = self.cells_per_side.unwrap_or(CELLS_PER_SIDE);
        let (n_rows, n_cols) = (grid.n_rows().div_ceil(side), grid.n_cols().div_ceil(side));
        for (row, col) in &self.only {
            check("the row of the tile", *row, n_rows)?;
            check("the column of the tile", *col, n_cols)?;
        }
        let n_tiles = if self.only.is_empty() { n_rows * n_cols } else { self.only.len() };
        let asked = shard.map_or(0..n_tiles, |shard| shard.range(n_tiles));
        let at = |k: usize| if self.only.is_empty() { (k / n_cols, k % n_cols) } else { self.only[k] };
        let tile = |(row, col): (usize, usize)| Tile {
            row,
            col,
            cells_per_side: side,
            window: CellWindow {
                row: row * side,
                col: col * side,
                n_rows: side.min(grid.n_rows() - row * side),
                n_cols: side.min(grid.n_cols() - col * side),
            },
            uavs: Vec::new(),
        };
        let mut tiles: Vec<Tile> = asked.map(|k| tile(at(k))).collect();
        let place_of: HashMap<(usize, usize), usize> =
            tiles.iter().enumerate().map(|(k, tile)| ((tile.row, tile.col), k)).collect();
        for (k, site) in sites.iter().enumerate() {
            let window = match sight.box_in_range(std::slice::from_ref(site), grid) {
                Some(around) if !meets(grid, around) => continue,
                Some(around) => grid.window_within(around),
                None => grid.window(),
            };
            let rows = window.row / side..=(window.row + window.n_rows - 1) / side;
            let cols = window.col / side..=(window.col + window.n_cols - 1) / side;
            if rows.clone().count() * cols.clone().count() > tiles.len() {
                let in_range = tiles.iter_mut().filter(|tile| rows.contains(&tile.row) && cols.contains(&tile.col));
                in_range.for_each(|tile| tile.uavs.push(k));
                continue;
            }
            for place in rows.flat_map(|row| cols.clone().map(move |col| (row, col))) {
                if let Some(tile) = place_of.get(&place) {
                    tiles[*tile].uavs.push(k);
                }
            }
        }
        Ok(tiles)
    }
}

/// Refuses a row or a column of tiles that the grid does not have.
fn check(what: &'static str, found: usize, n: usize) -> Result<()> {
    #[expect(clippy::cast_precision_loss, reason = "shown to a user")]
    if found < n { Ok(()) } else { Err(Error::number(what, found as f64, format!("0 to {}", n - 1))) }
}

/// Returns `true` if a box (west, south, east, north) may hold a cell of a grid.
fn meets(grid: &GeoRef, [west, south, east, north]: [f64; 4]) -> bool {
    let (width, height) = (grid.cell_width(), grid.cell_height());
    west <= grid.x_max() + width
        && east >= grid.x_min() - width
        && south <= grid.y_max() + height
        && north >= grid.y_min() - height
}

impl Tile {
    /// Returns its UAVs, out of the list of all. Their table is left out: the files do not depend
    /// on it.
    pub(crate) fn own(&self, all: &UavsFound) -> UavsFound {
        let sites = self.uavs.iter().map(|k| all.sites[*k].clone()).collect();
        UavsFound { sites, bad: all.bad, ..UavsFound::default() }
    }

    /// Returns the box around the tile and its UAVs: west, south, east, north \[CRS units\]. It
    /// holds every link between them.
    pub(crate) fn box_with(&self, own: &UavsFound, whole: &GeoRef) -> [f64; 4] {
        let cells = whole.part(self.window);
        let of_cells = [cells.x_min(), cells.y_min(), cells.x_max(), cells.y_max()];
        own.sites.iter().fold(of_cells, |[west, south, east, north], site| {
            [west.min(site.x), south.min(site.y), east.max(site.x), north.max(site.y)]
        })
    }

    /// Returns the tile for documents.
    pub(super) fn facts(&self, tells_numbers: bool) -> TileFacts {
        let numbers = tells_numbers.then(|| self.uavs.iter().map(|k| k + 1).collect());
        TileFacts { row: self.row, col: self.col, cells_per_side: self.cells_per_side, numbers }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::city::Site;
    use crate::quantity::Height;
    use skyshed_request::{SetRange, Sight};

    #[test]
    fn tiles_cover_the_grid_once_and_take_the_uavs_in_range() {
        let grid = GeoRef::new((0.0, 50.0), (1.0, 1.0), (50, 70), None).expect("a valid grid");
        let sight = SightPlan::of(&Sight::default().radius(6.0)).expect("a radius");
        let site = |x: f64, y: f64| -> GivenSite { Site::new(format!("{x} {y}"), (x, y), Height::agl(9.0)).into() };
        let sites = [site(10.0, 40.0), site(32.0, 18.0), site(200.0, 18.0)];
        let asked = TilesAsked { cells_per_side: Some(32), only: Vec::new() };
        let tiles = asked.tiles((&grid, None), &sites, &sight).expect("tiles");
        let n_cells: usize = tiles.iter().map(|tile| tile.window.n_rows * tile.window.n_cols).sum();
        assert_eq!((tiles.len(), n_cells), (6, 50 * 70));
        // The second UAV hovers where four tiles meet.
        let uavs: Vec<&[usize]> = tiles.iter().map(|tile| tile.uavs.as_slice()).collect();
        assert_eq!(uavs[..3], [&[0, 1][..], &[1], &[]]);
        assert_eq!(uavs[3..5], [&[1][..], &[1]]);
        let only = |only| TilesAsked { only, ..asked.clone() }.tiles((&grid, None), &sites, &sight);
        assert_eq!(only(vec![(1, 0), (0, 1)]).expect("two tiles"), [tiles[3].clone(), tiles[1].clone()]);
        assert!(only(vec![(2, 0)]).is_err());
        let shard = |k| asked.tiles((&grid, Some(Shard { k, of: 4 })), &sites, &sight).expect("some tiles");
        assert_eq!((1..=4).flat_map(shard).collect::<Vec<_>>(), tiles);
        // Without a radius, every tile has all UAVs.
        let everywhere = SightPlan::of(&Sight::default()).expect("no radius");
        let all = asked.tiles((&grid, None), &sites, &everywhere).expect("tiles");
        assert!(all.iter().all(|tile| tile.uavs == [0, 1, 2]));
    }
}
