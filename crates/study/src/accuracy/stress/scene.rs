//! Stress scene: a board of cells or some footprints, one UAV, receivers in cells, on the lattice.

pub(super) use super::served::CELL;
use super::served::Served;
use crate::city::{DataArea, Footprint, FootprintFaults, Ground, RoofTriangle, Site, Solids};
use crate::coverage::{MapOptions, MovedRoofs, Receivers, Uav};
use crate::error::{Result, StressError};
use crate::height_field::{Built, CellKind, Curvature, EARTH_RADIUS_M, HeightField, Station};
use crate::overlay::even_odd;
use crate::quantity::{Frame, Height, LatticePoint, STEPS_PER_UNIT, VOID, meters};
use crate::raster::{GeoRef, Raster};

/// Columns over the cells of a board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Board {
    /// Rows, north to south.
    pub n_rows: usize,
    /// Cells in a row, west to east.
    pub n_cols: usize,
    /// Tops \[1/1024 m above the datum\], row by row from the north-west; [`VOID`], nodata, blocks
    /// nothing.
    pub tops: Vec<i32>,
}

impl Board {
    /// Makes a board from its tops, one for each cell.
    pub fn new(n_rows: usize, n_cols: usize, tops: Vec<i32>) -> Self {
        debug_assert_eq!(tops.len(), n_rows * n_cols, "one top per cell");
        Board { n_rows, n_cols, tops }
    }

    /// Makes a square board of flat ground at 0 m.
    pub(super) fn flat(n: usize) -> Self {
        Board::new(n, n, vec![0; n * n])
    }

    /// Returns the top of the cell `east` cells from the west and `north` cells from the south
    /// edge; [`VOID`] outside.
    pub fn top(&self, east: i64, north: i64) -> i32 {
        self.index(east, north).map_or(VOID, |cell| self.tops[cell])
    }

    /// Sets the top of a cell; does nothing outside of the board.
    pub(super) fn set(&mut self, (east, north): (i64, i64), top: i64) {
        if let Some(cell) = self.index(east, north) {
            self.tops[cell] = narrow(top);
        }
    }

    fn index(&self, east: i64, north: i64) -> Option<usize> {
        let (row, col) = row_and_col((east, north), (self.n_rows, self.n_cols))?;
        Some(row * self.n_cols + col)
    }
}

/// Returns row and column of a cell counted from the south-west one; `None` outside.
fn row_and_col((east, north): (i64, i64), (n_rows, n_cols): (usize, usize)) -> Option<(usize, usize)> {
    let col = usize::try_from(east).ok().filter(|col| *col < n_cols)?;
    let from_south = usize::try_from(north).ok().filter(|row| *row < n_rows)?;
    Some((n_rows - 1 - from_south, col))
}

/// Prism over the even-odd interior of some rings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StressPrism {
    /// Rings, not closed, of either winding \[1/1024 m\].
    pub rings: Vec<Vec<[i32; 2]>>,
    /// Top \[1/1024 m above the datum\].
    pub top: i32,
}

/// Solid of a scene, which blocks rays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StressSolid {
    /// Columns; receivers stand on the ground of open cells and on the roofs of buildings.
    Columns {
        /// The columns.
        board: Board,
        /// Flat ground below them \[1/1024 m above the datum\]; `None`: receivers on every column.
        ground: Option<i32>,
    },
    /// Prisms on flat ground at 0 m; receivers stand on the ground and on the roofs.
    Prisms(Vec<StressPrism>),
    /// Buildings on flat ground at 0 m with roofs of triangles; receivers stand on the ground.
    Roofs(Vec<Vec<RoofTriangle>>),
}

/// Receiver whose answer is known by construction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Known {
    /// Row of its cell.
    pub row: usize,
    /// Column of its cell.
    pub col: usize,
    /// `true` if it is LoS.
    pub is_los: bool,
}

/// Small scene on which methods fail.
#[derive(Debug, Clone, PartialEq)]
pub struct StressScene {
    /// Family and number, such as `cell-slits 3`.
    pub name: String,
    /// Solid that blocks rays.
    pub solid: StressSolid,
    /// Position of the lattice in the world.
    pub world: Frame,
    /// Size of a cell of receivers \[CRS units\]; over columns the unit of the lattice.
    pub cell: (f64, f64),
    /// Rows of receivers.
    pub n_rows: usize,
    /// Receivers in a row.
    pub n_cols: usize,
    /// The UAV.
    pub uav: LatticePoint,
    /// Height of the receivers above what they stand on \[1/1024 m\].
    pub rx_height: i32,
    /// Odd number p: at a distance of d steps the earth falls away by d²/p. As p is odd, no drop is
    /// halfway between two steps. `None` for a flat earth.
    pub earth: Option<i64>,
    /// Change of each building's height after it was built \[1/1024 m\]; empty if none changes.
    pub moved: Vec<i32>,
    /// Receivers that the UAV serves, and no others; `None` if it serves all.
    pub served: Option<Served>,
    /// Receivers whose answer is known without any computation.
    pub known: Vec<Known>,
}

/// Scene prepared for methods.
#[derive(Debug)]
pub struct Ready {
    /// Solid that rays can hit.
    pub field: HeightField,
    /// The UAV.
    pub uav: Uav,
    /// Cells, row by row, each with its receiver.
    pub receivers: Vec<(usize, LatticePoint)>,
}

impl StressScene {
    /// Makes a scene of columns on flat ground at 0 m, receivers 1.5 m above it, cells of 1 m.
    pub(super) fn of_board(board: Board, uav: LatticePoint) -> Self {
        let (n_rows, n_cols) = (board.n_rows, board.n_cols);
        StressScene::new(StressSolid::Columns { board, ground: Some(0) }, (n_rows, n_cols), uav)
    }

    /// Makes a scene of prisms under `n` by `n` cells of 1 m.
    pub(super) fn of_prisms(prisms: Vec<StressPrism>, n: usize, uav: LatticePoint) -> Self {
        StressScene::new(StressSolid::Prisms(prisms), (n, n), uav)
    }

    /// Makes a scene of buildings with roofs of triangles under `n` by `n` cells of 1 m.
    pub(super) fn of_roofs(roofs: Vec<Vec<RoofTriangle>>, n: usize, uav: LatticePoint) -> Self {
        StressScene::new(StressSolid::Roofs(roofs), (n, n), uav)
    }

    /// Returns the change of a building's height after it was built \[1/1024 m\].
    pub fn moved_by(&self, building: usize) -> i32 {
        self.moved.get(building).copied().unwrap_or(0)
    }

    fn new(solid: StressSolid, (n_rows, n_cols): (usize, usize), uav: LatticePoint) -> Self {
        StressScene {
            name: String::new(),
            solid,
            world: Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 },
            cell: (1.0, 1.0),
            n_rows,
            n_cols,
            uav,
            rx_height: narrow(3 * CELL / 2),
            earth: None,
            moved: Vec::new(),
            served: None,
            known: Vec::new(),
        }
    }

    /// Records whether the receiver `east` cells from the west and `north` cells from the south is
    /// LoS. Does nothing outside of the scene.
    pub(super) fn know(&mut self, (east, north): (i64, i64), is_los: bool) {
        let place = row_and_col((east, north), (self.n_rows, self.n_cols));
        self.known.extend(place.map(|(row, col)| Known { row, col, is_los }));
    }

    /// Returns `true` if the solid is columns.
    pub(crate) fn is_board(&self) -> bool {
        matches!(self.solid, StressSolid::Columns { .. })
    }

    /// Returns the largest distance of anything from the origin, along an axis \[lattice steps\].
    pub(super) fn reach(&self) -> i64 {
        let corners: i64 = match &self.solid {
            StressSolid::Columns { board, .. } => {
                i64::try_from(board.n_rows.max(board.n_cols)).unwrap_or(i64::MAX).saturating_mul(CELL)
            }
            StressSolid::Prisms(prisms) => {
                let all = prisms.iter().flat_map(|p| p.rings.iter().flatten().flatten());
                all.map(|v| i64::from(*v).abs()).max().unwrap_or(0)
            }
            StressSolid::Roofs(roofs) => {
                let all = roofs.iter().flatten().flatten().flat_map(|[x, y, _]| [*x, *y]);
                all.map(|v| i64::from(v).abs()).max().unwrap_or(0)
            }
        };
        corners.max(self.uav.x.abs()).max(self.uav.y.abs())
    }

    /// Returns `true` if the UAV serves a receiver.
    pub fn serves(&self, receiver: LatticePoint) -> bool {
        self.served.is_none_or(|served| served.holds(self.uav, receiver))
    }

    /// Returns the options of maps of the scene, by any method.
    pub fn options(&self) -> MapOptions {
        // d² in steps over p is 1024 d²/2KR in meters.
        #[expect(clippy::cast_precision_loss, reason = "a small number")]
        let earth_k = |p: i64| p as f64 / (2.0 * f64::from(STEPS_PER_UNIT) * EARTH_RADIUS_M);
        let curvature = self.earth.map(earth_k).and_then(Curvature::of_earth_k);
        let antenna = self.served.map(Served::antenna).unwrap_or_default();
        let receivers = if matches!(self.solid, StressSolid::Roofs(_)) { Receivers::Ground } else { Receivers::All };
        MapOptions { rx_height: self.rx_height, receivers, curvature, antenna, ..MapOptions::default() }
    }

    /// Prepares the scene for methods, with world coordinates rounded to the lattice as in any
    /// scene.
    ///
    /// # Errors
    /// E902 if it does not come out as it was built: a fault of its family.
    pub fn ready(&self) -> Result<Ready> {
        let fault = |why: &str| StressError::Build { scene: self.name.clone(), why: why.to_string() };
        let rows = f64::from(u32::try_from(self.n_rows).unwrap_or(u32::MAX));
        let corner = (self.world.x_origin, self.world.y_origin + rows * self.cell.1);
        let grid = GeoRef::new(corner, self.cell, (self.n_rows, self.n_cols), None).ok_or_else(|| fault("no grid"))?;
        let solids = match &self.solid {
            StressSolid::Columns { board, ground } => Solids::Raster {
                surface: Raster::new(grid.clone(), board.tops.clone()),
                ground: ground.map_or(Ground::Surface, Ground::Flat),
                building_threshold: narrow(CELL / 4),
                voids: None,
            },
            StressSolid::Prisms(prisms) => self.vector(prisms.iter().enumerate().map(footprint).collect()),
            StressSolid::Roofs(roofs) => self.vector(roofs.iter().enumerate().map(building).collect()),
        };
        let Built { mut field, warnings } = HeightField::build(&grid, solids);
        if let Some(warning) = warnings.first() {
            return Err(fault(&warning.to_string()).into());
        }
        if !self.moved.is_empty() {
            let moved = MovedRoofs::by_building(&field, |building| self.moved_by(building as usize));
            field = moved.ok_or_else(|| fault("a roof is out of range"))?.field;
        }
        #[expect(clippy::cast_precision_loss, reason = "lattice positions of small scenes")]
        let (x, y) = self.world.world_from_lattice(self.uav.x as f64, self.uav.y as f64);
        let height = Height::AboveDatum(meters(narrow(self.uav.z)));
        let uav = Uav::place(&Site::new(self.name.clone(), (x, y), height), &field, None)?;
        if self.on_lattice(&uav.station) != self.uav {
            return Err(fault("the UAV is elsewhere on the lattice").into());
        }
        let positions = field.positions();
        let receiver = |cell: usize| {
            let place = positions.center(cell / self.n_cols, cell % self.n_cols);
            let base = match (field.cell_kind(cell, &place), &self.solid) {
                (CellKind::Building(_), StressSolid::Roofs(_)) | (CellKind::Void, _) => return None,
                (CellKind::Open(base) | CellKind::Building(base), _) => base,
            };
            let station = Station { place, z: i64::from(base) + i64::from(self.rx_height) };
            Some((cell, self.on_lattice(&station)))
        };
        let receivers = (0..self.n_rows * self.n_cols).filter_map(receiver).collect();
        Ok(Ready { field, uav, receivers })
    }

    /// Returns footprints on flat ground.
    fn vector(&self, footprints: Vec<Footprint>) -> Solids {
        let (ground, data_area) = (Ground::Flat(0), DataArea::All);
        Solids::Vector { footprints, frame: self.world, ground, faults: FootprintFaults::default(), data_area }
    }

    fn on_lattice(&self, station: &Station) -> LatticePoint {
        match self.solid {
            StressSolid::Columns { .. } => station.on_columns(),
            StressSolid::Prisms(_) | StressSolid::Roofs(_) => station.on_prisms(),
        }
    }
}

/// Returns a footprint as files have it: repaired by the even-odd rule.
fn footprint((k, prism): (usize, &StressPrism)) -> Footprint {
    Footprint::on_zero(k.to_string(), even_odd(&prism.rings), prism.top)
}

/// Returns a building with a roof of triangles.
fn building((k, roof): (usize, &Vec<RoofTriangle>)) -> Footprint {
    let polygons = roof.iter().map(|corners| vec![corners.map(|[x, y, _]| [x, y]).to_vec()]).collect();
    let top = roof.iter().flatten().map(|[.., z]| *z).max().unwrap_or(0);
    Footprint { roof: roof.clone(), ..Footprint::on_zero(k.to_string(), polygons, top) }
}

/// Narrows a number of lattice steps that is known to be small.
pub(super) fn narrow(steps: i64) -> i32 {
    i32::try_from(steps).unwrap_or(i32::MAX)
}
