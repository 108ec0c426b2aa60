//! Constructors of views: a scene with its heights lowered by a curved earth, or with its roofs
//! moved.
//!
//! A ray that is straight over a curved earth stays a straight line when heights count from the
//! plane that touches the earth below the UAV. There a point at distance d is lower by d²/2KR: K
//! times the radius R of the earth stands for refraction, which bends rays (ITU-R P.834: K = 4/3
//! for radio in a standard atmosphere). Columns are lowered as a whole, by the drops of their
//! centers, rounded to the lattice, so every engine decides over a curved earth as over a flat one.
//! Prisms are not lowered: engines reckon with the curve of their roofs.

use std::sync::Arc;

use super::columns::Columns;
use super::curvature::{Bulge, Curvature};
use super::field::HeightField;
use super::positions::Place;
use super::prisms::{CurvedGround, Piece, Prisms, Top};
use super::seen_heights::Drops;
use super::solid::{BentTerrain, RasterSolid, Solid, VectorGround, VectorSolid};
use crate::quantity::{Frame, MAX_HEIGHT_M, STEPS_PER_UNIT, height_steps};
use crate::raster::CellWindow;

impl HeightField {
    /// Returns the scene over a curved earth as it is seen from a place, with the drops of its
    /// cells.
    ///
    /// All heights of a raster are lowered; only those within `window` matter. Open ground and
    /// buildings stay what they are. A vector scene keeps its heights above the datum: its prisms
    /// know the earth ([`Prisms::earth`]). Its terrain is lowered, for receivers that are lowered
    /// as well ([`HeightField::seen_on_columns`]).
    pub(crate) fn bent(
        &self,
        place: &Place,
        curvature: Curvature,
        drops: &Arc<Drops>,
        window: CellWindow,
    ) -> HeightField {
        let (solid, bent_terrain) = match &self.solid {
            Solid::Raster(raster) => {
                let RasterSolid { frame, building_threshold, ref ground, .. } = *raster;
                let columns = raster.columns.lowered(Arc::clone(drops), window);
                let (ground, drops) = (Arc::clone(ground), Some(Arc::clone(drops)));
                (Solid::Raster(RasterSolid { columns, frame, ground, drops, building_threshold }), None)
            }
            Solid::Vector(vector) => {
                let meters_per_unit = self.grid.meters_per_unit();
                let earth = Bulge::new(curvature, vector.frame.unit_x * meters_per_unit);
                let earth = earth.map(|bulge| CurvedGround { bulge, ground: self.flat_ground() });
                let terrain = match &*vector.ground {
                    VectorGround::Flat(_) => None,
                    VectorGround::Terrain { columns, frame } => {
                        let of_cells = Arc::new(drops_of(columns, *frame, place, curvature, meters_per_unit));
                        let columns = columns.lowered(Arc::clone(&of_cells), columns.window());
                        Some(Arc::new(BentTerrain { columns, drops: of_cells, receiver_drops: Arc::clone(drops) }))
                    }
                };
                let prisms = vector.prisms.on_earth(earth);
                (Solid::Vector(VectorSolid { prisms, ..vector.clone() }), terrain)
            }
        };
        let (without_data, cells) = (self.without_data.clone(), self.cells.clone());
        HeightField { grid: self.grid.clone(), solid, without_data, cells, bent_terrain }
    }

    /// Returns the scene with roofs higher by `steps(building)` \[1/1024 m\]; `None` if a roof
    /// would leave the proven range.
    ///
    /// Moves the tops of prisms, or of the columns that are buildings; of a surface model alone,
    /// all columns. A raster does not tell buildings apart: `steps` is called once there, for 0.
    /// Open ground and buildings stay what they are, so rays are what the result is for.
    ///
    /// Cost: that of a copy; prisms are sorted into buckets again.
    pub(crate) fn with_roofs_raised_by(&self, steps: impl Fn(u32) -> i32) -> Option<HeightField> {
        let Solid::Vector(VectorSolid { prisms, .. }) = &self.solid else {
            let steps = steps(0);
            return self.with_cells_raised_by(|_| steps);
        };
        let piece = |p: &Piece| {
            let steps = steps(p.building);
            let top = match prisms.heights(p) {
                None => Top::Flat(raised(p.top, steps)?),
                Some(of) => Top::Sloped(of.iter().map(|top| raised(*top, steps)).collect::<Option<_>>()?),
            };
            Some((prisms.ring(p), top, p.building))
        };
        let pieces = prisms.pieces().iter().map(piece).collect::<Option<Vec<_>>>()?;
        Some(self.with_prisms(Prisms::with_tops(pieces)))
    }

    /// Returns a raster scene with the columns that are buildings higher by `steps(cell)` \[1/1024
    /// m\]; `None` of a vector scene, and if a roof would leave the proven range.
    pub(crate) fn with_cells_raised_by(&self, steps: impl Fn(usize) -> i32) -> Option<HeightField> {
        let mut field = self.clone();
        let Solid::Raster(RasterSolid { columns, .. }) = &mut field.solid else { return None };
        let (n_rows, n_cols) = (columns.n_rows(), columns.n_cols());
        let mut tops = columns.tops().to_vec();
        for (row, col) in self.cells_of_buildings().cells() {
            let cell = row * n_cols + col;
            tops[cell] = raised(tops[cell], steps(cell))?;
        }
        *columns = Columns::new(n_rows, n_cols, tops);
        Some(field)
    }

    /// Returns a vector scene with other prisms on the same ground; a raster scene as it is.
    pub(super) fn with_prisms(&self, prisms: Prisms) -> HeightField {
        let mut field = self.clone();
        if let Solid::Vector(vector) = &mut field.solid {
            vector.prisms = prisms;
        }
        field
    }
}

/// Returns the drops of the cells of a terrain below prisms.
fn drops_of(columns: &Columns, frame: Frame, place: &Place, curvature: Curvature, meters_per_unit: f64) -> Drops {
    let (x, y) = place.on_columns;
    let along = |steps: i64, unit: f64| {
        #[expect(clippy::cast_precision_loss, reason = "steps in reach are below 2^53")]
        let units = steps as f64 / f64::from(STEPS_PER_UNIT) * unit;
        units * meters_per_unit
    };
    Drops::at_distances(
        curvature,
        (0..columns.n_cols()).map(|col| along(columns.center(0, col).0 - x, frame.unit_x)),
        (0..columns.n_rows()).map(|row| along(columns.center(row, 0).1 - y, frame.unit_y)),
    )
}

/// Returns a top higher by some steps, if that is within the proven range.
fn raised(top: i32, steps: i32) -> Option<i32> {
    let limit = height_steps(MAX_HEIGHT_M)?;
    top.checked_add(steps).filter(|top| top.abs() <= limit)
}
