//! Zones: which part of the city a place is in: street, crossroad, courtyard or rooftop.
//!
//! In a generated city the zones are known by construction: streets are {x mod T ≤ s} and {y mod T ≤ s}, and a crossroad
//! is where both hold. Any other scene is read from its open ground, by the rules below; on generated cities they give
//! back the construction for 99.9 % or more of the open cells, and for all that are a period or more from the edge; turned
//! against the axes for 99.9 % as footprints, and for 90 % or more as a raster of 1 m cells (`tests/suite/zones.rs`).
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
//! 1. **Rooftop** is every building cell. Footprints that touch or overlap are one *block*; building cells of a raster
//!    are outlined along their edges, and the outlines simplified to one cell. Free-standing blocks below 25 m² (kiosks,
//!    sheds) keep their cells, but divide no street.
//! 2. The ground between blocks, as far as the *frame* (the extent of the scene), is cut into *mesh cells*: the triangles
//!    of the constrained Delaunay triangulation of the corners and of their feet on the walls opposite. Triangles that share
//!    a side and lie on one circle are one mesh cell. A side between two mesh cells, 1 m or longer, is a *gate*.
//! 3. **Courtyard** is a part of the ground from which no way through gates leads to the frame. A slit below 25 m² that
//!    opens to other ground, but by no gate, is what it opens to.
//! 4. A mesh cell with three gates or more is a *junction*. So is one with two gates that holds a corner of the frame, as
//!    if a street left it there. A *branch* is ground that one gate of a junction separates and that holds no cycle. It is
//!    cut off if it reaches less far from its gate than the gate is wide, and has the zone of its junction. All such
//!    branches are cut off at once. A branch that ends at the frame is kept, because a street goes on beyond it.
//! 5. Between the junctions that are left, mesh cells with two gates form streets. From each gate of a junction the street's
//!    *mouth* is looked for: onward as long as each gate is narrower than the one before, and then to any that is narrower
//!    yet within 0.35 times its width. Narrower means by 3 % or more. The junction and the ground as far as its mouths is a
//!    crossing, and crossings whose mouths are less than a quarter of their width apart are one.
//! 6. **Crossroad** is a crossing where three streets meet, the third at least 0.3 times as wide as the second: an alley
//!    off an avenue makes none.
//! 7. **Street** is all other open ground: streets, alleys, dead ends, bends, yards with a way in.
//!
//! **Squares and parks.** A square where streets meet is a crossroad as a whole, as long as it is no larger than 30
//! squares of its widest street's width: what makes a crossroad worth hovering over, sight into several streets, holds all
//! over it. Larger open ground (parks, rivers, fields) is street, the zone of open ground without other claims. So is a
//! mouth wider than four typical streets (the upper quartile of all mouths) no street.
//!
//! **The frame** is no wall of a building, but streets along it need another side, so it bounds their mesh cells; the edge
//! street of a generated city crosses the others as anywhere. What a crossing covers of mesh cells at the frame may be two
//! squares of its widest street's width; what is more, and what hangs on it, is taken for the outskirts, and is street.
//!
//! **Symmetry.** A city that is mirrored, or turned by a quarter, has the same zones, mirrored or turned, cell by cell. So
//! a center on a side of two mesh cells is in a crossroad if either is one. Only a center on a wall can differ: whether it is
//! on the building depends on which side of it that is.
//!
//! A surface model alone does not say what is a building: no cell of it has a zone.
//!
//! # References
//! Prasad 1997 (chordal axis: triangles by their free sides, and cutting off short branches). Saboor et al. 2023 (the
//! generated grid).

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
use crate::height_field::HeightField;
use crate::outlines::{CellPart, cell_parts, n_cell_parts};
use crate::raster::{BitGrid, GeoRef};

/// How the zones of a scene were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ZoneBasis {
    /// By construction: the streets of a generated city.
    StreetGrid,
    /// From the triangulation of the open ground.
    OpenGround,
    /// Not at all: a surface model alone does not say what is a building, so no cell has a zone.
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
    /// How it is said in documents.
    pub fn name(self) -> &'static str {
        match self {
            ZoneBasis::StreetGrid => "street grid",
            ZoneBasis::OpenGround => "open ground",
            ZoneBasis::Unknown => "unknown",
        }
    }
}

impl ZoneMap {
    /// The zones of a scene: by construction for a generated city, whose parameters are `built_up`, from the open
    /// ground for any other.
    ///
    /// Cost: a triangulation of all corners, and a few operations per cell; 0.1 s for 1000 buildings and 10^6 cells.
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
    /// let zones = ZoneMap::of(&field, scene.built_up.as_ref());
    /// assert_eq!(zones.at(10.0, 10.0), Some(Zone::Crossroad));
    /// assert_eq!(zones.at(10.0, 30.0), Some(Zone::Street));
    /// assert_eq!(zones.at(30.0, 30.0), Some(Zone::Rooftop));
    /// assert_eq!(zones.count(Zone::Courtyard), 0);
    /// # Ok::<(), skyshed_core::Error>(())
    /// ```
    pub fn of(field: &HeightField, built_up: Option<&BuiltUp>) -> Self {
        match built_up.filter(|_| field.prisms().is_some()) {
            Some(built_up) => ZoneMap::new(field, grid::codes(field, built_up), ZoneBasis::StreetGrid),
            None => ZoneMap::of_open_ground(field),
        }
    }

    /// The zones of a scene, without any work where no cell has one: `None` of a surface model alone.
    pub fn if_known(field: &HeightField, built_up: Option<&BuiltUp>) -> Option<Self> {
        (!field.is_surface_only()).then(|| ZoneMap::of(field, built_up))
    }

    /// The zones of a scene from its open ground, whatever is known of how it was made.
    pub fn of_open_ground(field: &HeightField) -> Self {
        if field.is_surface_only() {
            return ZoneMap::new(field, vec![NONE; field.grid().n_cells()], ZoneBasis::Unknown);
        }
        ZoneMap::new(field, open_space::codes(field), ZoneBasis::OpenGround)
    }

    /// Zones that were found before: the code of every cell of a scene, as [`ZoneMap::codes`] gives them. `None` if they are
    /// of another number of cells, or no codes.
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

    /// The receivers' grid.
    pub fn grid(&self) -> &GeoRef {
        &self.grid
    }

    /// How the zones were found.
    pub fn basis(&self) -> ZoneBasis {
        self.basis
    }

    /// [`Zone::code`] of every cell or [`NONE`], shape `[n_rows, n_cols]`, row 0 north, columns running fastest.
    pub fn codes(&self) -> &[u8] {
        &self.codes
    }

    /// The zone of a cell.
    pub fn of_cell(&self, row: usize, col: usize) -> Option<Zone> {
        assert!(col < self.grid.n_cols(), "a column of the grid");
        Zone::of_code(self.codes[row * self.grid.n_cols() + col])
    }

    /// The zone at a world position \[CRS units\]: that of the cell that holds it, the one to its north-east on an edge;
    /// `None` outside the grid.
    pub fn at(&self, x: f64, y: f64) -> Option<Zone> {
        self.grid.cell_at(x, y).and_then(|(row, col)| self.of_cell(row, col))
    }

    /// The zone of a place of which it is known whether it is over a building: a cell whose center is on the other side of
    /// a wall does not count, but the nearest of its neighbors on this side.
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
                // Distance of the neighbor's center.
                let (east, north) = self.grid.cells_from_world(near_x, near_y);
                let center = |cells: f64| cells.floor() + 0.5;
                let (own_east, own_north) = self.grid.cells_from_world(x, y);
                let distance = ((center(east) - own_east) * width).hypot((center(north) - own_north) * height);
                open.push((distance, zone));
            }
        }
        open.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(Some(Zone::Street), |nearest| Some(nearest.1))
    }

    /// The cells of a zone.
    pub fn cells(&self, zone: Zone) -> BitGrid {
        let mut cells = BitGrid::new(self.grid.n_rows(), self.grid.n_cols());
        let n_cols = self.grid.n_cols();
        let of_zone = self.codes.iter().enumerate().filter(|(_, code)| **code == zone.code());
        of_zone.for_each(|(cell, _)| cells.insert(cell / n_cols, cell % n_cols));
        cells
    }

    /// The connected parts of a zone, each with its outline, those that begin farther south first.
    pub fn parts(&self, zone: Zone) -> Vec<CellPart> {
        cell_parts(&self.cells(zone))
    }

    /// Number of connected parts of a zone.
    pub fn n_parts(&self, zone: Zone) -> usize {
        n_cell_parts(&self.cells(zone))
    }

    /// Number of cells in a zone.
    pub fn count(&self, zone: Zone) -> u64 {
        self.counts[usize::from(zone.code()) - 1]
    }
}
