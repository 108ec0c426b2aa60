//! Zones of a city: street, crossroad, courtyard and rooftop.
//!
//! In a generated city the zones are known by construction. Streets are {x mod T ≤ s} and {y mod T
//! ≤ s}; a crossroad is the intersection of both.
//!
//! In any other scene the zones follow from its open ground, by the rules below. The rules were
//! compared with the construction (`tests/engines/zones.rs`):
//!
//! | generated city | open cells with the same zone |
//! |---|---|
//! | along the axes | 99.9 % or more; all that are a period or more from the edge |
//! | turned, as footprints | 99.9 % |
//! | turned, as a raster of 1 m cells | 90 % or more |
//!
//! ```text
//!  ######################################   #  block, two corners of which are A and B
//!  ###ooooo##############################   o  courtyard
//!  ###ooooo###########...################   .  street; above, a recess that is part of it
//!  ###################...################
//!  ..............A'------B'..............   A', B' feet of A and B on the wall opposite
//!  ..............|xxxxxxx|...............   x  crossroad: the mesh cell AA'B'B
//!  ..............|xxxxxxx|...............      between the mouths AA', BB' and AB
//!  ##############A-------B###############
//!  ##############|.......|###############
//! ```
//!
//! 1. **Rooftop** is every building cell. Footprints that touch or overlap are one *block*.
//!    Building cells of a raster are outlined along their edges, and the outlines simplified to one
//!    cell. Free-standing blocks below 25 m² (kiosks, sheds) keep their cells, but divide no
//!    street.
//! 2. The ground between blocks, as far as the *frame* (the extent of the scene), is cut into *mesh
//!    cells*. They are the triangles of the constrained Delaunay triangulation of the corners and
//!    of their feet on the walls opposite. Triangles that share a side and lie on one circle are
//!    one mesh cell. A side between two mesh cells, 1 m or longer, is a *gate*.
//! 3. **Courtyard** is a part of the ground from which no way through gates leads to the frame. A
//!    slit below 25 m² that opens to other ground without a gate has that ground's zone.
//! 4. A mesh cell with three gates or more is a *junction*. So is one with two gates that holds a
//!    corner of the frame, as if a street left it there. A *branch* is ground that one gate of a
//!    junction separates and that holds no cycle. It is cut off if it reaches less far from its
//!    gate than the gate is wide, and has the zone of its junction. All such branches are cut off
//!    at once. A branch that ends at the frame is kept, because a street continues beyond it.
//! 5. Between the remaining junctions, mesh cells with two gates form streets. The search for a
//!    street's *mouth* starts at each gate of a junction. It moves onward as long as each gate is
//!    narrower than the one before. It then continues to any gate that is still narrower, within
//!    0.35 times its width. Narrower means by 3 % or more. A crossing is the junction and the
//!    ground as far as its mouths. Crossings whose mouths are less than a quarter of their width
//!    apart are one crossing.
//! 6. **Crossroad** is a crossing where three streets meet, the third at least 0.3 times as wide as
//!    the second. So an alley off an avenue makes no crossroad.
//! 7. **Street** is all other open ground: streets, alleys, dead ends, bends, yards with a way in.
//!
//! **Squares and parks.** A square where streets meet is a crossroad as a whole, if it is no larger
//! than 30 squares of its widest street's width. A crossroad is worth hovering over for the sight
//! into several streets, and that holds all over such a square. Larger open ground (parks, rivers,
//! fields) is street, the default zone of open ground. A mouth wider than four typical streets (the
//! upper quartile of all mouths) is no street either.
//!
//! **The frame** is no wall of a building. It bounds the mesh cells of the streets along it, which
//! need another side. So the edge street of a generated city crosses other streets as usual. A
//! crossing may cover mesh cells at the frame up to two squares of its widest street's width. A
//! larger part is taken for the outskirts, with all ground attached to it, and is street.
//!
//! **Symmetry.** A city that is mirrored, or turned by a quarter, has the same zones, mirrored or
//! turned, cell by cell. So a center on a side of two mesh cells is in a crossroad if either cell
//! is in one. Only a center on a wall can differ: its side of the wall decides whether it is on the
//! building.
//!
//! A surface model alone does not show buildings, so none of its cells has a zone.
//!
//! # References
//! Prasad 1997 (chordal axis: triangles by their free sides, and cutting off short branches).
//! Saboor et al. 2023 (the generated grid).

mod grid;
mod cell_outline;
mod outline;
mod circle;
mod mesh;
mod gates;
mod courtyards;
mod branches;
mod crossings;
mod open_space;
mod zone;

pub use zone::{N_CODES, NONE, Zone};

use crate::city::BuiltUp;
use crate::error::{MapError, Result};
use crate::height_field::HeightField;
use crate::outlines::{CellPart, cell_parts, n_cell_parts};
use crate::raster::{BitGrid, GeoRef};

/// The method that found the zones of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ZoneBasis {
    /// Construction: the streets of a generated city.
    StreetGrid,
    /// Triangulation of the open ground.
    OpenGround,
    /// None: a surface model alone does not show buildings, so no cell has a zone.
    Unknown,
}

/// The zone of every cell of the receivers' grid.
#[derive(Debug, Clone, PartialEq)]
pub struct ZoneMap {
    grid: GeoRef,
    codes: Vec<u8>,
    basis: ZoneBasis,
    counts: [u64; 4],
}

impl ZoneBasis {
    /// Returns the method's name in documents.
    pub fn name(self) -> &'static str {
        match self {
            ZoneBasis::StreetGrid => "street grid",
            ZoneBasis::OpenGround => "open ground",
            ZoneBasis::Unknown => "unknown",
        }
    }
}

impl ZoneMap {
    /// Finds the zones of a scene: by construction for a generated city with parameters `built_up`,
    /// else from the open ground.
    ///
    /// Cost: a triangulation of all corners, and a few operations per cell; 0.1 s for 1000
    /// buildings and 10^6 cells.
    ///
    /// # Errors
    /// E504 for outlines that cross one another too often.
    ///
    /// # Examples
    ///
    /// ```
    /// use skyshed_core::height_field::HeightField;
    /// use skyshed_core::city::{BuiltUp, BuiltUpCity};
    /// use skyshed_core::zones::{Zone, ZoneMap};
    ///
    /// let built_up = BuiltUp::new(0.3, 500.0, 15.0)?;
    /// let scene = BuiltUpCity { built_up, size_m: 300.0, margin_m: 0.0, cell_m: 1.0, seed: 1, ground_m: 0.0 }.city()?;
    /// let field = HeightField::build(&scene.grid, scene.solids).field;
    /// let zones = ZoneMap::of(&field, scene.built_up.as_ref())?;
    /// assert_eq!(zones.at(10.0, 10.0), Some(Zone::Crossroad));
    /// assert_eq!(zones.at(10.0, 30.0), Some(Zone::Street));
    /// assert_eq!(zones.at(30.0, 30.0), Some(Zone::Rooftop));
    /// assert_eq!(zones.count(Zone::Courtyard), 0);
    /// # Ok::<(), skyshed_core::Error>(())
    /// ```
    pub fn of(field: &HeightField, built_up: Option<&BuiltUp>) -> Result<Self> {
        match built_up.filter(|_| field.prisms().is_some()) {
            Some(built_up) => Ok(ZoneMap::new(field, grid::codes(field, built_up), ZoneBasis::StreetGrid)),
            None => ZoneMap::of_open_ground(field),
        }
    }

    /// Finds the zones of a scene. For a surface model alone, returns `None` without any work.
    ///
    /// # Errors
    /// E504, as [`ZoneMap::of`].
    pub fn if_known(field: &HeightField, built_up: Option<&BuiltUp>) -> Result<Option<Self>> {
        (!field.is_surface_only()).then(|| ZoneMap::of(field, built_up)).transpose()
    }

    /// Finds the zones of a scene from its open ground, even for a generated city.
    ///
    /// # Errors
    /// E504, as [`ZoneMap::of`].
    pub fn of_open_ground(field: &HeightField) -> Result<Self> {
        if field.is_surface_only() {
            return Ok(ZoneMap::new(field, vec![NONE; field.grid().n_cells()], ZoneBasis::Unknown));
        }
        let codes = open_space::codes(field)
            .map_err(|tangle| MapError::Tangled { attempt: "find streets and crossroads", tangle })?;
        Ok(ZoneMap::new(field, codes, ZoneBasis::OpenGround))
    }

    /// Returns zones found earlier, from the code of every cell of a scene, as in
    /// [`ZoneMap::codes`]. Returns `None` for another number of cells, or for invalid codes.
    pub fn of_codes(field: &HeightField, codes: Vec<u8>, basis: ZoneBasis) -> Option<Self> {
        let are_codes = codes.len() == field.grid().n_cells() && codes.iter().all(|code| usize::from(*code) < N_CODES);
        are_codes.then(|| ZoneMap::new(field, codes, basis))
    }

    fn new(field: &HeightField, codes: Vec<u8>, basis: ZoneBasis) -> Self {
        let mut histogram = [0_u64; N_CODES];
        codes.iter().for_each(|code| histogram[usize::from(*code)] += 1);
        let [_, counts @ ..] = histogram;
        ZoneMap { grid: field.grid().clone(), codes, basis, counts }
    }

    /// Returns the receivers' grid.
    pub fn grid(&self) -> &GeoRef {
        &self.grid
    }

    /// Returns the method that found the zones.
    pub fn basis(&self) -> ZoneBasis {
        self.basis
    }

    /// Returns [`Zone::code`] of every cell or [`NONE`], shape `[n_rows, n_cols]`, row 0 north,
    /// columns running fastest.
    pub fn codes(&self) -> &[u8] {
        &self.codes
    }

    /// Returns the zone of a cell.
    pub fn of_cell(&self, row: usize, col: usize) -> Option<Zone> {
        assert!(col < self.grid.n_cols(), "a column of the grid");
        Zone::of_code(self.codes[row * self.grid.n_cols() + col])
    }

    /// Returns the zone of the cell that holds a world position \[CRS units\]; `None` outside the
    /// grid. A position on an edge belongs to the cell north-east of it.
    pub fn at(&self, x: f64, y: f64) -> Option<Zone> {
        self.grid.cell_at(x, y).and_then(|(row, col)| self.of_cell(row, col))
    }

    /// Returns the zone of a position \[CRS units\] that is known to be over a building or not.
    ///
    /// The center of its cell may lie on the other side of a wall. Then the nearest neighbor on
    /// this side gives the zone.
    pub fn over(&self, x: f64, y: f64, is_building: bool) -> Option<Zone> {
        let own = self.at(x, y)?;
        if is_building || own != Zone::Rooftop {
            return Some(if is_building { Zone::Rooftop } else { own });
        }
        let (width, height) = (self.grid.cell_width(), self.grid.cell_height());
        let mut open: Vec<(f64, Zone)> = Vec::new();
        for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (f64::from(dx), f64::from(dy)))) {
            let (near_x, near_y) = (x + dx * width, y + dy * height);
            if let Some(zone) = self.at(near_x, near_y).filter(|zone| *zone != Zone::Rooftop) {
                // Distance to the neighbor's center.
                let (east, north) = self.grid.cells_from_world(near_x, near_y);
                let center = |cells: f64| cells.floor() + 0.5;
                let (own_east, own_north) = self.grid.cells_from_world(x, y);
                let distance = ((center(east) - own_east) * width).hypot((center(north) - own_north) * height);
                open.push((distance, zone));
            }
        }
        open.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(Some(Zone::Street), |nearest| Some(nearest.1))
    }

    /// Returns the cells of a zone.
    pub fn cells(&self, zone: Zone) -> BitGrid {
        let mut cells = BitGrid::new(self.grid.n_rows(), self.grid.n_cols());
        let n_cols = self.grid.n_cols();
        let of_zone = self.codes.iter().enumerate().filter(|(_, code)| **code == zone.code());
        of_zone.for_each(|(cell, _)| cells.insert(cell / n_cols, cell % n_cols));
        cells
    }

    /// Returns the connected parts of a zone with their outlines, ordered by their first cells from
    /// the south.
    pub fn parts(&self, zone: Zone) -> Vec<CellPart> {
        cell_parts(&self.cells(zone))
    }

    /// Returns the number of connected parts of a zone.
    pub fn n_parts(&self, zone: Zone) -> usize {
        n_cell_parts(&self.cells(zone))
    }

    /// Returns the number of cells in a zone.
    pub fn count(&self, zone: Zone) -> u64 {
        self.counts[usize::from(zone.code()) - 1]
    }
}
