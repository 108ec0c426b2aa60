//! α, β and γ of a city tile by tile: where it is dense, fine-grained or tall.
//!
//! Tiles are squares counted from the north-west corner of the extent. Those in the last row and
//! column are cut off at the extent, and their values are of the part inside. A building belongs to
//! the tile that holds its centroid; a centroid on an edge belongs to the tile north or east of it.
//! For footprints that is decided in integers, and α is the share of the tile that their union
//! covers. For a raster, α is the share of the tile's known cells that are buildings. There a
//! building is a set of such cells connected by cell sides, with their mean height.

use crate::city::Footprint;
use crate::error::Result;
use crate::height_field::HeightField;
use crate::outlines::{covered_shares, labelled_parts};
use crate::overlay::{Ring, intersection, union, wound};
use crate::quantity::{Frame, STEPS_PER_UNIT};
use crate::raster::{BitGrid, CellLattice, GeoRef};
use skyshed_core::error::MapError;

/// Fewest buildings whose heights give a γ.
pub const FEWEST_BUILDINGS: u64 = 2;

/// Built-up parameters of a tile, or of several.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BuiltUpTile {
    /// Ground, in half lattice squares or in cells.
    ground: u64,
    /// Part of the ground that buildings cover.
    built: u64,
    buildings: u64,
    /// Sum of the squared heights \[m²\].
    squares: f64,
    /// Buildings whose heights are known.
    heights: u64,
}

impl BuiltUpTile {
    /// Returns the number of buildings.
    pub fn buildings(&self) -> u64 {
        self.buildings
    }

    /// Returns α, the share of known ground that buildings cover, 0 to 1; `None` without such
    /// ground.
    pub fn built_up_ratio(&self) -> Option<f64> {
        (self.ground > 0).then(|| self.built as f64 / self.ground as f64)
    }

    /// Returns γ \[m\], the maximum-likelihood scale of a Rayleigh distribution of the heights,
    /// γ² = ΣH²/(2n). `None` for fewer than [`FEWEST_BUILDINGS`] buildings, or if none is higher
    /// than 0.
    pub fn height_scale(&self) -> Option<f64> {
        let is_known = self.heights >= FEWEST_BUILDINGS && self.squares > 0.0;
        is_known.then(|| (self.squares / (2.0 * self.heights as f64)).sqrt())
    }

    fn add(&mut self, other: &BuiltUpTile) {
        self.ground += other.ground;
        self.built += other.built;
        self.buildings += other.buildings;
        self.heights += other.heights;
        self.squares += other.squares;
    }
}

/// A city cut into tiles.
#[derive(Debug, Clone, PartialEq)]
pub struct BuiltUpTiles {
    georef: GeoRef,
    tiles: Vec<BuiltUpTile>,
    /// Area of a unit of ground \[m²\].
    unit_m2: f64,
    buildings_outside: u64,
}

/// Size of the tiles of a city.
#[derive(Debug, Clone, Copy)]
pub struct TileSize {
    /// Edge of a tile \[CRS units\], above 0.
    pub edge: f64,
    /// Length of a CRS unit \[m\].
    pub meters_per_unit: f64,
}

/// Most tiles of a city.
pub const MOST_TILES: f64 = 16_777_216.0;

impl TileSize {
    /// Returns the rows and columns of tiles over a grid; `None` for more than [`MOST_TILES`], or
    /// an edge that is not above 0.
    pub fn shape(&self, grid: &GeoRef) -> Option<(usize, usize)> {
        let count = |length: f64| (length / self.edge - 1e-9).ceil().max(1.0);
        let (rows, cols) = (count(grid.y_max() - grid.y_min()), count(grid.x_max() - grid.x_min()));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most MOST_TILES")]
        let shape = (rows as usize, cols as usize);
        (self.edge > 0.0 && rows * cols <= MOST_TILES).then_some(shape)
    }

    fn georef(&self, grid: &GeoRef) -> Option<GeoRef> {
        GeoRef::new((grid.x_min(), grid.y_max()), (self.edge, self.edge), self.shape(grid)?, grid.crs().cloned())
    }
}

impl BuiltUpTiles {
    /// Computes the tiles of the footprints of a vector scene, on the lattice of `frame`; `None` as
    /// [`TileSize::shape`]. The ground of a tile that reaches beyond the data area is reduced to
    /// the share of its cells inside.
    ///
    /// Cost: the union of the footprints, and the tiles that it covers.
    ///
    /// # Errors
    /// E504 for outlines that cross one another too often.
    pub fn of_footprints(
        footprints: &[Footprint],
        frame: Frame,
        field: &HeightField,
        size: TileSize,
    ) -> Result<Option<Self>> {
        let grid = field.grid();
        let Some(georef) = size.georef(grid) else { return Ok(None) };
        let edges = Edges::on_lattice(&georef, grid, frame);
        let n_cols = georef.n_cols();
        let mut tiles = vec![BuiltUpTile::default(); georef.n_cells()];
        let mut buildings_outside = 0;
        for footprint in footprints {
            match footprint.centroid().and_then(|centroid| edges.tile_of(centroid)) {
                Some((row, col)) => {
                    let tile = &mut tiles[row * n_cols + col];
                    tile.buildings += 1;
                    if let Some(height) = footprint.height_m() {
                        tile.heights += 1;
                        tile.squares += height * height;
                    }
                }
                None => buildings_outside += 1,
            }
        }
        let lattice = CellLattice::under(&frame, &georef);
        let steps = f64::from(STEPS_PER_UNIT);
        let doubled_tile = 2.0 * (size.edge / frame.unit_x * steps) * (size.edge / frame.unit_y * steps);
        for (at, tile) in tiles.iter_mut().enumerate() {
            tile.ground = edges.doubled_area(at / n_cols, at % n_cols);
        }
        let on_tiles = |ring: &Ring| ring.iter().map(|p| lattice.position(&frame, *p)).collect::<Vec<_>>();
        let tangled = |tangle| {
            skyshed_core::Error::from(MapError::Tangled { attempt: "measure the built-up area of tiles", tangle })
        };
        let buildings =
            union(footprints.iter().flat_map(|f| f.polygons.iter().map(wound)).collect()).map_err(tangled)?;
        let built = intersection(&buildings.concat(), &[edges.outline()]).map_err(tangled)?;
        let built: Vec<Vec<Vec<[i64; 2]>>> = built.iter().map(|rings| rings.iter().map(on_tiles).collect()).collect();
        covered_shares(&built, lattice.steps, (georef.n_rows(), n_cols), |row, col, share| {
            let tile = &mut tiles[row * n_cols + col];
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of the tile's area")]
            let doubled = (share * doubled_tile).round() as u64;
            tile.built = doubled.min(tile.ground);
        });
        if let Some(outside) = field.outside_data() {
            take_away(&mut tiles, outside, &CellTiles::new(grid, &georef));
        }
        let step_m = size.meters_per_unit / f64::from(STEPS_PER_UNIT);
        Ok(Some(BuiltUpTiles { georef, tiles, unit_m2: step_m * step_m / 2.0, buildings_outside }))
    }

    /// Computes the tiles of a raster scene; `None` as [`TileSize::shape`]. A cell belongs to the
    /// tile that holds its center.
    pub fn of_cells(field: &HeightField, size: TileSize) -> Option<Self> {
        let grid = field.grid();
        let georef = size.georef(grid)?;
        let tiles_of = CellTiles::new(grid, &georef);
        let mut tiles = vec![BuiltUpTile::default(); georef.n_cells()];
        let sets = field.cells();
        for (row, col, tile) in tiles_of.cells() {
            let is_building = sets.building.contains(row, col);
            tiles[tile].built += u64::from(is_building);
            tiles[tile].ground += u64::from(is_building || sets.open.contains(row, col));
        }
        for part in parts(field) {
            let [x, y] = [part.x, part.y].map(|sum| sum / part.n_cells);
            let tile = tiles_of.at(x, y);
            let height = part.height / part.n_cells;
            tiles[tile].buildings += 1;
            tiles[tile].heights += 1;
            tiles[tile].squares += height * height;
        }
        let unit_m2 = grid.cell_width() * grid.cell_height() * size.meters_per_unit * size.meters_per_unit;
        Some(BuiltUpTiles { georef, tiles, unit_m2, buildings_outside: 0 })
    }

    /// Returns the grid with a cell for each tile. Its last row and column may exceed the city.
    pub fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// Returns the tiles, row by row from the north-west.
    pub fn tiles(&self) -> &[BuiltUpTile] {
        &self.tiles
    }

    /// Returns the sum of all tiles.
    pub fn whole(&self) -> BuiltUpTile {
        self.tiles.iter().fold(BuiltUpTile::default(), |mut sum, tile| {
            sum.add(tile);
            sum
        })
    }

    /// Returns the area of the known ground of a tile \[m²\].
    pub fn area_m2(&self, tile: &BuiltUpTile) -> f64 {
        tile.ground as f64 * self.unit_m2
    }

    /// Returns β, buildings per area \[1/km²\]; `None` without known ground.
    pub fn buildings_per_km2(&self, tile: &BuiltUpTile) -> Option<f64> {
        (tile.ground > 0).then(|| tile.buildings as f64 / (self.area_m2(tile) / 1e6))
    }

    /// Returns the number of buildings in no tile: their centroid is beyond the extent.
    pub fn buildings_outside(&self) -> u64 {
        self.buildings_outside
    }
}

/// Map of places on a grid, counted in cells, to tiles.
#[derive(Debug)]
struct CellTiles {
    /// Rows and columns of the grid.
    n_cells: [usize; 2],
    /// Rows and columns of tiles.
    n_tiles: [usize; 2],
    /// Cells of the grid along a side of a tile, southward and eastward.
    cells_per_tile: [f64; 2],
}

impl CellTiles {
    fn new(grid: &GeoRef, tiles: &GeoRef) -> CellTiles {
        CellTiles {
            n_cells: [grid.n_rows(), grid.n_cols()],
            n_tiles: [tiles.n_rows(), tiles.n_cols()],
            cells_per_tile: [tiles.cell_height() / grid.cell_height(), tiles.cell_width() / grid.cell_width()],
        }
    }

    /// Returns the tile of a place \[cells east and south of the north-west corner\]. A place on an
    /// edge belongs to the tile east or north of it.
    fn at(&self, x: f64, y: f64) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the grid of tiles")]
        let (row, col) = ((y / self.cells_per_tile[0]).ceil() as usize, (x / self.cells_per_tile[1]).floor() as usize);
        (row.clamp(1, self.n_tiles[0]) - 1) * self.n_tiles[1] + col.min(self.n_tiles[1] - 1)
    }

    /// Iterates over row, column and tile of each cell; its center decides the tile.
    fn cells(&self) -> impl Iterator<Item = (usize, usize, usize)> {
        let [n_rows, n_cols] = self.n_cells;
        let tile = move |row: usize, col: usize| (row, col, self.at(col as f64 + 0.5, row as f64 + 0.5));
        (0..n_rows).flat_map(move |row| (0..n_cols).map(move |col| tile(row, col)))
    }
}

/// Removes ground outside of the data area, by the share of each tile's cells, but no built ground.
fn take_away(tiles: &mut [BuiltUpTile], outside: &BitGrid, tiles_of: &CellTiles) {
    let mut cells = vec![[0_u64; 2]; tiles.len()];
    for (row, col, tile) in tiles_of.cells() {
        cells[tile][0] += 1;
        cells[tile][1] += u64::from(outside.contains(row, col));
    }
    for (tile, [all, outside]) in tiles.iter_mut().zip(cells).filter(|(_, [_, outside])| *outside > 0) {
        let ground = u128::from(tile.ground) * u128::from(all - outside) / u128::from(all);
        tile.ground = u64::try_from(ground).unwrap_or(tile.ground).max(tile.built);
    }
}

/// Borders of tiles on the lattice: of columns from the west, of rows from the north.
#[derive(Debug)]
struct Edges {
    xs: Vec<i64>,
    ys: Vec<i64>,
}

impl Edges {
    fn on_lattice(georef: &GeoRef, grid: &GeoRef, frame: Frame) -> Edges {
        let x = |col: usize| (georef.x_min() + col as f64 * georef.cell_width()).min(grid.x_max());
        let y = |row: usize| (georef.y_max() - row as f64 * georef.cell_height()).max(grid.y_min());
        Edges {
            xs: (0..=georef.n_cols()).map(|col| frame.lattice_from_world(x(col), grid.y_min()).0).collect(),
            ys: (0..=georef.n_rows()).map(|row| frame.lattice_from_world(grid.x_min(), y(row)).1).collect(),
        }
    }

    /// Returns the tile that holds a point, numerators over one denominator; `None` off the extent.
    fn tile_of(&self, ([x, y], denominator): ([i128; 2], i128)) -> Option<(usize, usize)> {
        let col = self.xs.partition_point(|edge| i128::from(*edge) * denominator <= x);
        // From the north: an edge belongs to the tile above it.
        let row = self.ys.partition_point(|edge| i128::from(*edge) * denominator > y);
        let is_inside = (1..self.xs.len()).contains(&col) && (1..self.ys.len()).contains(&row);
        is_inside.then(|| (row - 1, col - 1))
    }

    /// Returns twice the area of a tile \[steps²\].
    fn doubled_area(&self, row: usize, col: usize) -> u64 {
        2 * ((self.xs[col + 1] - self.xs[col]) * (self.ys[row] - self.ys[row + 1])).unsigned_abs()
    }

    /// Returns the rectangle that all tiles fill; the lattice of a scene is within ±2^26.
    fn outline(&self) -> Ring {
        let narrow = |v: i64| i32::try_from(v).unwrap_or(if v < 0 { i32::MIN } else { i32::MAX });
        let [west, east] = [self.xs[0], self.xs[self.xs.len() - 1]].map(narrow);
        let [north, south] = [self.ys[0], self.ys[self.ys.len() - 1]].map(narrow);
        vec![[west, south], [east, south], [east, north], [west, north]]
    }
}

/// Building of a raster: sums over its cells.
#[derive(Debug, Clone, Copy, Default)]
struct Part {
    n_cells: f64,
    /// Positions of the centers of its cells, east and south of the north-west corner \[cells\].
    x: f64,
    y: f64,
    /// Heights above the ground \[m\].
    height: f64,
}

/// Returns the buildings of a raster scene.
fn parts(field: &HeightField) -> Vec<Part> {
    let (labels, sizes) = labelled_parts(&field.cells().building);
    let heights = field.above_ground_m();
    let n_cols = field.grid().n_cols();
    let mut parts = vec![Part::default(); sizes.len()];
    for (cell, label) in labels.iter().enumerate().filter(|(_, label)| **label != u32::MAX) {
        let part = &mut parts[*label as usize];
        part.n_cells += 1.0;
        part.x += (cell % n_cols) as f64 + 0.5;
        part.y += (cell / n_cols) as f64 + 0.5;
        part.height += f64::from(heights[cell]);
    }
    parts
}
