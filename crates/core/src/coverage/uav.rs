//! A UAV placed in a scene: a checked position with its height above the datum and above the ground.

use crate::city::{Site, WindowedSolids};
use crate::error::{Error, Result};
use crate::height_field::{HeightField, Place, Station, cell_frame};
use crate::quantity::{BLOCKS_ALL, Frame, Height, MAX_EXTENT_UNITS, STEPS_PER_UNIT, VOID, height_steps, meters, tidy};
use crate::raster::{CellWindow, GeoRef};

/// A UAV that hovers in the clear: not inside a building, not below the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Uav {
    /// Name of its site.
    pub id: String,
    /// Where it is.
    pub station: Station,
    /// Height above the ground below it \[m\], if a ground is known there.
    pub height_agl_m: Option<f64>,
    /// What it hovers over.
    pub placement: Placement,
}

/// What lies below a UAV.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Placement {
    /// Open ground, or nothing known.
    Ground,
    /// A building.
    Rooftop,
}

impl Placement {
    /// The word for it in tables.
    pub fn name(self) -> &'static str {
        match self {
            Placement::Ground => "ground",
            Placement::Rooftop => "rooftop",
        }
    }
}

impl Uav {
    /// Places a site in a scene.
    ///
    /// `radius` is the range in CRS units, if it is limited: with the cells in range it bounds the box that must fit
    /// the lattice.
    ///
    /// # Errors
    /// Site errors: inside a building (E201), below the ground (E202), outside the lattice (E203), a height above a
    /// ground or roof that is not there (E204), a height beyond ±32 768 m (E205).
    pub fn place(site: &Site, field: &HeightField, radius: Option<f64>) -> Result<Uav> {
        let units = [field.prisms_frame(), field.columns_frame()];
        check_extent(&in_words(site), site, (field.grid(), &units), radius)?;
        Uav::over(site, field, field.place(site.x, site.y))
    }

    /// Places a site in a scene that is read window by window, as [`Uav::place`] does in one that is in memory.
    ///
    /// # Errors
    /// As [`Uav::place`], and those of the scene.
    pub fn place_streamed(site: &Site, scene: &impl WindowedSolids, radius: Option<f64>) -> Result<Uav> {
        let grid = scene.grid();
        let frame = cell_frame(grid);
        check_extent(&in_words(site), site, (grid, &[Some(frame), None]), radius)?;
        // What is below it is decided by the cells that it touches, and where it is by the lattice of the whole grid.
        let (x, y) = frame.lattice_from_world(site.x, site.y);
        let steps = i64::from(STEPS_PER_UNIT);
        let around = |cell: i64, n: usize| {
            let clip = |v: i64| usize::try_from(v.max(0)).unwrap_or(0).min(n - 1);
            (clip(cell - 2), clip(cell + 2))
        };
        let from_north = i64::try_from(grid.n_rows()).unwrap_or(i64::MAX) - 1 - y.div_euclid(steps);
        let (rows, cols) = (around(from_north, grid.n_rows()), around(x.div_euclid(steps), grid.n_cols()));
        let window = CellWindow { row: rows.0, col: cols.0, n_rows: rows.1 - rows.0 + 1, n_cols: cols.1 - cols.0 + 1 };
        let field = HeightField::build(&grid.part(window), scene.solids(window)?, &mut Vec::new());
        #[expect(clippy::cast_precision_loss, reason = "lattice positions in reach are below 2^53")]
        let (x, y) = frame.world_from_lattice(x as f64, y as f64);
        let mut uav = Uav::over(site, &field, field.place(x, y))?;
        uav.station.place = Place::on_cells(grid, site.x, site.y);
        Ok(uav)
    }

    /// A site over a place of a scene.
    fn over(site: &Site, field: &HeightField, place: Place) -> Result<Uav> {
        let what = in_words(site);
        let ground = field.ground_at(&place);
        let roof = field.roof_at(&place);

        let above = |base: i32| meters(base) + site.height.value();
        let absolute = match site.height {
            Height::AboveDatum(z) => z,
            Height::AboveGround(_) if ground == VOID => {
                return Err(Error::site(204, format!("{what}: no ground is known there"))
                    .with_hint(format!("give the height above the datum: `{}amsl`", site.height.value())));
            }
            Height::AboveGround(_) => above(ground),
            Height::AboveRoof(_) if field.is_surface_only() => {
                return Err(Error::site(204, format!("{what}: with a surface model alone no roof is known"))
                    .with_hint("give `--terrain FILE` or `--ground Z`, or a height above the surface (`agl`)"));
            }
            Height::AboveRoof(_) => match roof {
                Some(roof) => above(roof),
                None => {
                    return Err(Error::site(204, format!("{what}: no building is there, wanted a roof"))
                        .with_hint(format!("above the ground it is `{}agl`", site.height.value())));
                }
            },
        };
        let z = height_steps(absolute)
            .ok_or_else(|| Error::site(205, format!("{what}: {absolute} m above the datum, wanted within ±32768 m")))?;
        // The very number asked for above a base on the lattice may round differently from its sum.
        let z = match (site.height, roof) {
            (Height::AboveGround(h), _) => height_steps(h).map_or(z, |h| ground + h),
            (Height::AboveRoof(h), Some(roof)) => height_steps(h).map_or(z, |h| roof + h),
            _ => z,
        };
        Uav::hovering(&what, site, field, (place, z))
    }

    /// The same UAV some lattice steps east, north and up: those of [`HeightField::neighbor`], and 1/1024 m.
    ///
    /// # Errors
    /// As [`Uav::place`].
    pub fn moved(&self, field: &HeightField, [east, north, up]: [i64; 3], radius: Option<f64>) -> Result<Uav> {
        let place = field.neighbor(&self.station.place, (east, north));
        let what = format!("cannot move UAV `{}` by {east}, {north} and {up} steps east, north and up", self.id);
        let z = i32::try_from(self.station.z + up).ok().filter(|z| height_steps(meters(*z)).is_some());
        let z = z.ok_or_else(|| Error::site(205, format!("{what}: wanted within ±32768 m of the datum")))?;
        let site = Site { id: self.id.clone(), x: place.x, y: place.y, height: Height::AboveDatum(meters(z)) };
        let units = [field.prisms_frame(), field.columns_frame()];
        check_extent(&what, &site, (field.grid(), &units), radius)?;
        Uav::hovering(&what, &site, field, (place, z))
    }

    /// A UAV at a place and a height, if it is in the clear there.
    fn hovering(what: &str, site: &Site, field: &HeightField, (place, z): (Place, i32)) -> Result<Uav> {
        let (ground, roof) = (field.ground_at(&place), field.roof_at(&place));
        check_clear(what, site, field, &place, z, roof)?;
        Ok(Uav {
            id: site.id.clone(),
            station: Station { place, z: i64::from(z) },
            height_agl_m: (ground != VOID).then(|| meters(z) - meters(ground)),
            placement: if roof.is_some() { Placement::Rooftop } else { Placement::Ground },
        })
    }

    /// Height above the datum \[m\].
    pub fn height_amsl_m(&self) -> f64 {
        i32::try_from(self.station.z).map_or(f64::NAN, meters)
    }
}

/// What is attempted, for errors.
fn in_words(site: &Site) -> String {
    format!("cannot place UAV `{}` at ({}, {}) with height {}", site.id, site.x, site.y, site.height)
}

/// A height to ask for instead, above the ground where that is known: rounded up to a centimeter, so that it is in the clear.
fn lowest_in_words(lowest: i32, ground: i32) -> String {
    let centimeters = |m: f64| (m * 100.0).ceil() / 100.0;
    match ground {
        VOID => format!("`{}amsl`", centimeters(meters(lowest))),
        ground => format!("`{}agl`", centimeters(meters(lowest) - meters(ground))),
    }
}

fn check_clear(what: &str, site: &Site, field: &HeightField, place: &Place, z: i32, roof: Option<i32>) -> Result<()> {
    let ground = field.ground_at(place);
    let in_columns = field.inside_columns_below(place);
    let inside = field.inside_prisms_below(place).max(if roof.is_some() { in_columns } else { VOID });
    if z < inside {
        let (roof_m, asked) = (meters(inside), site.height.value());
        let mut hint = format!("the lowest height in the clear is {}", lowest_in_words(inside, ground));
        if asked > 0.0 {
            hint += &format!("; `{asked}roof` hovers at {} m, {asked} m above the roof", tidy(roof_m + asked));
        }
        return Err(Error::site(
            201,
            format!(
                "{what}: {} m above the datum is inside a building with its roof at {} m",
                tidy(meters(z)),
                tidy(roof_m)
            ),
        )
        .with_hint(hint));
    }
    if in_columns == BLOCKS_ALL {
        return Err(Error::site(204, format!("{what}: it is over a nodata cell, which blocks everything"))
            .with_hint("`--nodata-as clear` lets nodata cells block nothing"));
    }
    let floor = if roof.is_some() { ground } else { ground.max(in_columns) };
    if z < floor {
        return Err(Error::site(
            202,
            format!("{what}: {} m above the datum is below the ground at {} m", tidy(meters(z)), tidy(meters(floor))),
        )
        .with_hint(format!(
            "the lowest height in the clear is {}; heights are above ground unless written `150amsl` or `30roof`",
            lowest_in_words(floor, ground)
        )));
    }
    Ok(())
}

/// What a position far from the grid probably is.
fn hint_for_far(site: &Site, grid: &GeoRef) -> String {
    let in_grid = |x: f64, y: f64| x >= grid.x_min() && x <= grid.x_max() && y >= grid.y_min() && y <= grid.y_max();
    if in_grid(site.y, site.x) {
        "x and y are swapped: exchanged, the position lies in the grid".into()
    } else if site.x.abs() <= 180.0 && site.y.abs() <= 90.0 && grid.crs().is_some() {
        "this looks like longitude and latitude: give it as a table with the columns `lon,lat,h` to `--uavs`".into()
    } else {
        "check the coordinate reference system of the site, or limit the range with `--radius M`".into()
    }
}

/// The box of the UAV and the cells in its range must fit the lattice.
fn check_extent(
    what: &str,
    site: &Site,
    (grid, units): (&GeoRef, &[Option<Frame>; 2]),
    radius: Option<f64>,
) -> Result<()> {
    let reach = radius.unwrap_or(f64::INFINITY);
    let span = |at: f64, low: f64, high: f64| {
        let (low, high) = (low.max(at - reach), high.min(at + reach));
        high.max(at) - low.min(at)
    };
    let (width, height) = (span(site.x, grid.x_min(), grid.x_max()), span(site.y, grid.y_min(), grid.y_max()));
    for frame in units.iter().flatten() {
        let extent = (width / frame.unit_x).max(height / frame.unit_y);
        if extent > MAX_EXTENT_UNITS {
            return Err(Error::site(
                203,
                format!(
                    "{what}: with the cells in range it spans {extent:.0} units, wanted at most {MAX_EXTENT_UNITS}; the \
                     grid reaches over x {}…{}, y {}…{}",
                    grid.x_min(),
                    grid.x_max(),
                    grid.y_min(),
                    grid.y_max()
                ),
            )
            .with_hint(hint_for_far(site, grid)));
        }
    }
    Ok(())
}
