//! A scene with one thing changed: its receivers, its buildings, or the heights of its roofs.

use std::sync::Arc;

use super::solid::{RasterSolid, Solid, VectorSolid};
use super::{CellSets, HeightField, Piece, Prisms, Ring, Top};
use crate::quantity::{MAX_HEIGHT_M, VOID, height_steps};
use crate::raster::{BitGrid, GeoRef};

impl HeightField {
    /// The solids of the scene under receivers on another grid.
    pub(super) fn with_receivers_on(&self, grid: &GeoRef) -> HeightField {
        let mut field = HeightField { grid: grid.clone(), ..self.clone() };
        field.find_roofs();
        field.find_cells_without_data();
        field.cells = Arc::new(CellSets::of(&field));
        field
    }

    /// The ground of the scene without a building.
    pub(super) fn without_prisms(&self) -> HeightField {
        let mut field = self.clone();
        if let Solid::Vector(vector) = &mut field.solid {
            vector.prisms = Prisms::new(Vec::<(Ring, i32, u32)>::new());
            vector.building_ids = [].into();
            vector.building_errors = None;
            vector.roofs = Arc::new(vec![VOID; self.grid.n_cells()]);
        }
        field.cells = Arc::new(CellSets::of(&field));
        field
    }

    /// The scene with every roof higher by `steps` \[1/1024 m\]: the tops of all prisms, or those of the columns that
    /// are buildings; of a surface model alone, where buildings are not known, those of all columns. What is open ground
    /// and what is a building stays, so rays are what the result is for. `None` if a roof would leave the proven range.
    ///
    /// Cost: that of a copy; prisms are sorted into buckets again.
    pub fn with_roofs_raised(&self, steps: i32) -> Option<HeightField> {
        self.with_roofs_raised_by(|_| steps)
    }

    /// Like [`HeightField::with_roofs_raised`] by what a function gives for the number of a building; it is asked once, for 0, where
    /// buildings have none.
    pub fn with_roofs_raised_by(&self, steps: impl Fn(u32) -> i32) -> Option<HeightField> {
        let mut field = self.clone();
        match &mut field.solid {
            Solid::Vector(VectorSolid { prisms, .. }) => {
                let piece = |p: &Piece| {
                    let steps = steps(p.building);
                    let top = match prisms.heights(p) {
                        None => Top::Flat(raised(p.top, steps)?),
                        Some(of) => Top::Sloped(of.iter().map(|top| raised(*top, steps)).collect::<Option<_>>()?),
                    };
                    Some((prisms.ring(p), top, p.building))
                };
                let pieces = prisms.pieces().iter().map(piece).collect::<Option<Vec<_>>>()?;
                *prisms = Prisms::with_tops(pieces).on_earth(prisms.earth());
            }
            Solid::Raster(_) => return self.with_cells_raised_by(|_| steps(0)),
        }
        Some(field)
    }

    /// The scene with a flat roof on every building, as high as its own is highest; `None` where all are that. What is a building stays.
    pub fn with_flat_roofs(&self) -> Option<HeightField> {
        if self.n_buildings_with_shaped_roofs() == 0 {
            return None;
        }
        let tops = self.building_tops();
        let mut field = self.clone();
        let Solid::Vector(vector) = &mut field.solid else { return None };
        let prisms = &vector.prisms;
        let flat = prisms.pieces().iter().map(|p| (prisms.ring(p), tops[p.building as usize], p.building));
        vector.prisms = Prisms::new(flat).on_earth(prisms.earth());
        field.find_roofs();
        field.cells = Arc::new(CellSets::of(&field));
        Some(field)
    }

    /// How many buildings have a roof that is not flat.
    pub fn n_buildings_with_shaped_roofs(&self) -> usize {
        let tops = self.building_tops();
        let Some(prisms) = self.prisms() else { return 0 };
        let mut is_shaped = vec![false; tops.len()];
        for piece in prisms.pieces() {
            let building = piece.building as usize;
            is_shaped[building] |= prisms.heights(piece).is_some() || piece.top != tops[building];
        }
        is_shaped.into_iter().filter(|is_shaped| *is_shaped).count()
    }

    /// A raster scene with the columns that are buildings higher by what a function gives for the index of a cell \[1/1024 m\]; `None` of a vector
    /// scene, and if a roof would leave the proven range.
    pub(crate) fn with_cells_raised_by(&self, steps: impl Fn(usize) -> i32) -> Option<HeightField> {
        let mut field = self.clone();
        let Solid::Raster(RasterSolid { columns, .. }) = &mut field.solid else { return None };
        let n_cols = columns.n_cols();
        let mut tops = columns.flat_tops().to_vec();
        for (row, col) in self.cells_of_buildings().cells() {
            let cell = row * n_cols + col;
            tops[cell] = raised(tops[cell], steps(cell))?;
        }
        *columns = columns.with_flat_tops(tops);
        Some(field)
    }

    /// The cells of a raster that are buildings; all of a surface model alone, where buildings are not known.
    pub(crate) fn cells_of_buildings(&self) -> &BitGrid {
        if self.is_surface_only() { &self.cells.open } else { &self.cells.building }
    }
}

/// A top higher by some steps, if that is within the proven range.
fn raised(top: i32, steps: i32) -> Option<i32> {
    let limit = height_steps(MAX_HEIGHT_M)?;
    top.checked_add(steps).filter(|top| top.abs() <= limit)
}
