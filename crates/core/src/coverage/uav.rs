//! A UAV placed in a scene: a checked position with its height above the datum and above the
//! ground.

use crate::city::{Antenna, Site, UpTime, WindowedSolids};
use crate::error::{Error, UavAttempt, UavError};
use crate::height_field::{HeightField, Place, Station, cell_frame};
use crate::quantity::{BLOCKS_ALL, Frame, Height, MAX_EXTENT_UNITS, STEPS_PER_UNIT, VOID, height_steps, meters};
use crate::raster::{CellWindow, GeoRef};

/// A UAV that hovers in the clear: not inside a building, not below the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Uav {
    /// Name of its site.
    pub id: String,
    /// Place and height.
    pub station: Station,
    /// Height above the ground below it \[m\], if a ground is known there.
    pub height_agl_m: Option<f64>,
    /// Surface that it hovers over.
    pub placement: HoversOver,
    /// Its own antenna.
    pub antenna: Antenna,
    /// Time in which it is up; `None` for always.
    pub up: Option<UpTime>,
}

/// Surface below a UAV.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HoversOver {
    /// Open ground, or what is outside the grid of a raster.
    Ground,
    /// A building.
    Rooftop,
    /// A cell without data, or what is outside the data area of a scene of footprints. What stands
    /// around such a UAV is not known, so it has no P_LoS.
    Nodata,
}

impl HoversOver {
    /// Returns the word for it in tables.
    pub fn name(self) -> &'static str {
        match self {
            HoversOver::Ground => "ground",
            HoversOver::Rooftop => "rooftop",
            HoversOver::Nodata => "nodata",
        }
    }
}

impl Uav {
    /// Places a site in a scene.
    ///
    /// `radius` is the range in CRS units, if it is limited: with the cells in range it bounds the
    /// box that must fit the lattice.
    ///
    /// # Errors
    /// Site errors: inside a building (E201), below the ground (E202), outside the lattice (E203),
    /// above a ground or roof that is not there (E204), beyond ±32 768 m (E205).
    pub fn place(site: &Site, field: &HeightField, radius: Option<f64>) -> Result<Uav, Error> {
        let units = [field.prisms_frame(), field.columns_frame()];
        check_extent((site.x, site.y), (field.grid(), &units), radius).map_err(|why| refused(site, why))?;
        Uav::over(site, (field, field.grid()), field.place(site.x, site.y))
    }

    /// Places a site in a part of a raster scene just where it is in the whole, whose lattice
    /// rounds it; in other scenes as [`Uav::place`] does.
    ///
    /// # Errors
    /// As [`Uav::place`].
    pub fn place_in_part(site: &Site, field: &HeightField, whole: &GeoRef, radius: Option<f64>) -> Result<Uav, Error> {
        if field.prisms_frame().is_some() {
            return Uav::place(site, field, radius);
        }
        let frame = cell_frame(whole);
        check_extent((site.x, site.y), (field.grid(), &[Some(frame), None]), radius)
            .map_err(|why| refused(site, why))?;
        let (x, y) = frame.lattice_from_world(site.x, site.y);
        #[expect(clippy::cast_precision_loss, reason = "lattice positions in reach are below 2^53")]
        let (x, y) = frame.world_from_lattice(x as f64, y as f64);
        Uav::over(site, (field, whole), field.place(x, y).told_as(site.x, site.y))
    }

    /// Places a site in a scene that is read window by window, as [`Uav::place`] does in one that
    /// is in memory.
    ///
    /// # Errors
    /// As [`Uav::place`], and those of the scene.
    pub fn place_streamed(site: &Site, scene: &impl WindowedSolids, radius: Option<f64>) -> Result<Uav, Error> {
        let grid = scene.grid();
        let frame = cell_frame(grid);
        check_extent((site.x, site.y), (grid, &[Some(frame), None]), radius).map_err(|why| refused(site, why))?;
        // What is below it is decided by the cells that it touches, and where it is by the lattice
        // of the whole grid.
        let (x, y) = frame.lattice_from_world(site.x, site.y);
        let steps = i64::from(STEPS_PER_UNIT);
        let around = |cell: i64, n: usize| {
            let clip = |v: i64| usize::try_from(v.max(0)).unwrap_or(0).min(n - 1);
            (clip(cell - 2), clip(cell + 2))
        };
        let from_north = i64::try_from(grid.n_rows()).unwrap_or(i64::MAX) - 1 - y.div_euclid(steps);
        let (rows, cols) = (around(from_north, grid.n_rows()), around(x.div_euclid(steps), grid.n_cols()));
        let window = CellWindow { row: rows.0, col: cols.0, n_rows: rows.1 - rows.0 + 1, n_cols: cols.1 - cols.0 + 1 };
        let field = HeightField::build(&grid.part(window), scene.solids(window)?).field;
        #[expect(clippy::cast_precision_loss, reason = "lattice positions in reach are below 2^53")]
        let (x, y) = frame.world_from_lattice(x as f64, y as f64);
        let mut uav = Uav::over(site, (&field, grid), field.place(x, y))?;
        uav.station.place = Place::on_cells(grid, site.x, site.y);
        Ok(uav)
    }

    /// Returns a site over a place of a scene, or of a part of one with the grid of the whole.
    fn over(site: &Site, (field, whole): (&HeightField, &GeoRef), place: Place) -> Result<Uav, Error> {
        height_over(field, &place, site.height)
            .and_then(|z| Uav::hovering((&site.id, site.antenna, site.up), (field, whole), (place, z)))
            .map_err(|why| refused(site, why))
    }

    /// Returns the UAV moved by some lattice steps east, north and up: those of
    /// [`HeightField::neighbor`], and 1/1024 m.
    pub fn moved(&self, field: &HeightField, [east, north, up]: [i64; 3], radius: Option<f64>) -> Result<Uav, Error> {
        let place = field.neighbor(&self.station.place, (east, north));
        let z = i32::try_from(self.station.z + up).ok().filter(|z| height_steps(meters(*z)).is_some());
        let units = [field.prisms_frame(), field.columns_frame()];
        let amsl_m = self.height_amsl_m() + meters(i32::try_from(up).unwrap_or(i32::MAX));
        z.ok_or(UavError::Height { amsl_m })
            .and_then(|z| {
                check_extent((place.x, place.y), (field.grid(), &units), radius)?;
                Uav::hovering((&self.id, self.antenna, self.up), (field, field.grid()), (place, z))
            })
            .map_err(|why| Error::Uav {
                attempt: UavAttempt::Move { id: self.id.clone(), steps: [east, north, up] },
                why,
            })
    }

    /// Returns a UAV at a place and a height, if it is in the clear there.
    fn hovering(
        (id, antenna, up): (&str, Antenna, Option<UpTime>),
        (field, whole): (&HeightField, &GeoRef),
        (place, z): (Place, i32),
    ) -> Result<Uav, UavError> {
        let (ground, roof) = (field.ground_at(&place), field.roof_at(&place));
        let ground_m = (ground != VOID).then(|| meters(ground));
        let in_columns = field.inside_columns_below(&place);
        let inside = field.inside_prisms_below(&place).max(if roof.is_some() { in_columns } else { VOID });
        let floor = if roof.is_some() { ground } else { ground.max(in_columns) };
        let amsl_m = meters(z);
        if z < inside {
            return Err(UavError::InsideBuilding { amsl_m, roof_m: meters(inside), ground_m });
        }
        if in_columns == BLOCKS_ALL {
            return Err(UavError::OverNodata);
        }
        if z < floor {
            return Err(UavError::BelowGround { amsl_m, surface_m: meters(floor), ground_m });
        }
        let placement = if is_nodata_below(&place, field, whole) {
            HoversOver::Nodata
        } else if roof.is_some() {
            HoversOver::Rooftop
        } else {
            HoversOver::Ground
        };
        Ok(Uav {
            id: id.to_string(),
            station: Station { place, z: i64::from(z) },
            height_agl_m: ground_m.map(|ground_m| amsl_m - ground_m),
            placement,
            antenna,
            up,
        })
    }

    /// Returns the height above the datum \[m\].
    pub fn height_amsl_m(&self) -> f64 {
        i32::try_from(self.station.z).map_or(f64::NAN, meters)
    }
}

/// Returns whether a place of a scene, or of a part of one with the grid of the whole, is over no
/// data.
///
/// That is outside of the data area of footprints, or over a cell without a height, but not outside
/// of the grid of a raster.
pub fn is_nodata_below(place: &Place, field: &HeightField, whole: &GeoRef) -> bool {
    let is_void = || {
        field.roof_at(place).is_none() && field.ground_at(place) == VOID && field.inside_columns_below(place) == VOID
    };
    !field.is_known_at(place.x, place.y) || (whole.cell_at(place.x, place.y).is_some() && is_void())
}

/// Returns the height of an end of a link over a place, above the datum \[1/1024 m\].
///
/// # Errors
/// If the ground or roof that it is above is not there, or it is beyond ±32 768 m.
pub fn height_over(field: &HeightField, place: &Place, height: Height) -> Result<i32, UavError> {
    let base = match (height, field.ground_at(place), field.roof_at(place)) {
        (Height::AboveDatum(_), ..) => 0,
        (Height::AboveGround(_), VOID, _) => return Err(UavError::NoGround),
        (Height::AboveGround(_), ground, _) => ground,
        (Height::AboveRoof(_), ..) if field.is_surface_only() => return Err(UavError::NoRoofKnown),
        (Height::AboveRoof(_), _, roof) => roof.ok_or(UavError::NoBuilding)?,
    };
    let amsl_m = meters(base) + height.value();
    let z = height_steps(amsl_m).ok_or(UavError::Height { amsl_m })?;
    // The very number asked for above a base on the lattice may round differently from the sum.
    Ok(height_steps(height.value()).map_or(z, |h| base + h))
}

fn refused(site: &Site, why: UavError) -> Error {
    let Site { id, x, y, height, .. } = site.clone();
    Error::Uav { attempt: UavAttempt::Place { id, x, y, height }, why }
}

/// Checks that the box of the UAV and the cells in its range fits the lattice.
fn check_extent(
    (x, y): (f64, f64),
    (grid, units): (&GeoRef, &[Option<Frame>; 2]),
    radius: Option<f64>,
) -> Result<(), UavError> {
    let reach = radius.unwrap_or(f64::INFINITY);
    let span = |at: f64, (low, high): (f64, f64)| {
        let (low, high) = (low.max(at - reach), high.min(at + reach));
        high.max(at) - low.min(at)
    };
    let (x_range, y_range) = ((grid.x_min(), grid.x_max()), (grid.y_min(), grid.y_max()));
    let (width, height) = (span(x, x_range), span(y, y_range));
    for frame in units.iter().flatten() {
        let span = (width / frame.unit_x).max(height / frame.unit_y);
        if span > MAX_EXTENT_UNITS {
            return Err(UavError::TooFar { span, x_range, y_range, has_crs: grid.crs().is_some() });
        }
    }
    Ok(())
}
