//! Scenes from building footprints with heights, on flat ground or terrain.
//!
//! Order of events: positions are rounded to the lattice, then each polygon is repaired there by the even-odd rule
//! (i_overlay, integers throughout), so that what is triangulated later is exactly what is tested. Every mended or
//! left-out thing is counted in [`FootprintFaults`] and reported.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::geojson_file::{FoundHeight, RawFootprints, read_raw_footprints};
use super::outline::{Shaped, polygon_area, shape};
use super::surface::{SurfaceOptions, ground_steps, read_heights, warn_of_units};
use super::{Ground, NodataAs, Scene, Solids, Source, name_of, refuse_degrees, refuse_two_crs};
use crate::error::{Error, Result, Warning};
use crate::quantity::{Frame, MAX_EXTENT_UNITS, counted, height_steps, meters};
use crate::raster::{Crs, CrsKind, GeoRef, InputKind, Raster};

/// A building: polygons on the lattice and a flat top; solid from below the ground.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Footprint {
    /// The feature's id, or its number in the file.
    pub id: String,
    /// Polygons of rings (not closed) of lattice points; inside by the even-odd rule, edges do not cross.
    pub polygons: Vec<Vec<Vec<[i32; 2]>>>,
    /// Top \[1/1024 m above the datum\].
    pub top: i32,
    /// The ground that the height was measured from \[1/1024 m above the datum\].
    pub base: i32,
}

impl Footprint {
    /// Whether the outline is one rectangle: four corners, each within a degree of a right angle; vertices on its sides
    /// count for nothing.
    pub fn is_rectangle(&self) -> bool {
        let [polygon] = self.polygons.as_slice() else { return false };
        let [ring] = polygon.as_slice() else { return false };
        let edge = |a: [i32; 2], b: [i32; 2]| [0, 1].map(|k| f64::from(b[k]) - f64::from(a[k]));
        let n = ring.len();
        // The turn at each vertex: its sine and cosine.
        let turns = (0..n).map(|k| {
            let (a, b) = (edge(ring[(k + n - 1) % n], ring[k]), edge(ring[k], ring[(k + 1) % n]));
            let lengths = a[0].hypot(a[1]) * b[0].hypot(b[1]);
            ((a[0] * b[1] - a[1] * b[0]) / lengths, (a[0] * b[0] + a[1] * b[1]) / lengths)
        });
        const DEGREE: f64 = 0.017_452_406;
        let corners: Vec<(f64, f64)> = turns.filter(|(sin, cos)| sin.abs() > DEGREE || *cos < 0.0).collect();
        let turns_alike = corners.iter().all(|c| c.0 > 0.0) || corners.iter().all(|c| c.0 < 0.0);
        corners.len() == 4 && turns_alike && corners.iter().all(|c| c.1.abs() <= DEGREE)
    }
}

/// What to do with footprints whose height is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MissingHeight {
    /// Refuse the file.
    Fail,
    /// Leave the footprint out, and say so.
    #[default]
    Drop,
    /// Three meters for each of `building:levels`; left out where that is missing too.
    Levels,
    /// The median of the known heights.
    Median,
}

/// How footprints are read.
#[derive(Debug, Clone, PartialEq)]
pub struct FootprintOptions {
    /// Property that holds the height above ground \[m\].
    pub height_field: String,
    /// Property that holds the absolute height of the top \[m above the datum\], instead.
    pub top_field: Option<String>,
    /// Policy for missing heights.
    pub missing: MissingHeight,
    /// Terrain model, in the same CRS.
    pub terrain: Option<PathBuf>,
    /// Height of flat ground \[m above the datum\], 0 by default.
    pub ground_m: Option<f64>,
    /// Extent of the receivers' grid: west, south, east, north \[CRS units\].
    pub extent: Option<[f64; 4]>,
    /// Cell size of the receivers' grid \[m\]; by default the terrain's, else 1.
    pub cell_m: Option<f64>,
    /// The CRS to assume.
    pub crs: Option<Crs>,
    /// What nodata cells of the terrain do.
    pub nodata_as: NodataAs,
    /// Whether to hash inputs of any size.
    pub always_hash: bool,
}

impl Default for FootprintOptions {
    /// Heights in the property `height`, on flat ground at 0 m, on a grid of 1 m over the footprints.
    fn default() -> Self {
        FootprintOptions {
            height_field: "height".into(),
            top_field: None,
            missing: MissingHeight::default(),
            terrain: None,
            ground_m: None,
            extent: None,
            cell_m: None,
            crs: None,
            nodata_as: NodataAs::default(),
            always_hash: false,
        }
    }
}

/// What was mended or left out while reading footprints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FootprintFaults {
    /// Features that are not areas (points, lines, no geometry): left out.
    pub not_areas: usize,
    /// Polygons whose rings crossed or touched themselves: repaired by the even-odd rule.
    pub repaired: usize,
    /// Rings whose last point was not the first: closed.
    pub unclosed: usize,
    /// Polygons without area: left out.
    pub degenerate: usize,
    /// Footprints without a usable height: treated by the [`MissingHeight`] policy.
    pub missing_height: usize,
    /// Footprints with a negative height: left out.
    pub negative_height: usize,
    /// Heights written with a decimal comma: read as such.
    pub decimal_comma: usize,
    /// Footprints over terrain cells that are all nodata: left out.
    pub no_ground: usize,
    /// Footprints farther than 65 536 m from the grid's corner: left out.
    pub too_far: usize,
}

impl FootprintFaults {
    fn warn(&self, path: &Path, missing: MissingHeight, missing_area_share: f64, warnings: &mut Vec<Warning>) {
        let treated = match missing {
            MissingHeight::Fail => "refused".to_string(),
            MissingHeight::Drop => {
                format!(
                    "left out, {:.1} % of the footprint area (`--missing levels|median|fail`)",
                    missing_area_share * 100.0
                )
            }
            MissingHeight::Levels => "3 m for each of `building:levels`, left out without that".to_string(),
            MissingHeight::Median => "given the median height".to_string(),
        };
        let found = [
            (350, self.not_areas, ["feature that is no polygon", "features that are no polygons"], "left out"),
            (
                351,
                self.repaired,
                ["polygon with crossing or touching rings", "polygons with crossing or touching rings"],
                "repaired by the even-odd rule",
            ),
            (
                352,
                self.unclosed,
                ["ring that does not end where it begins", "rings that do not end where they begin"],
                "closed",
            ),
            (353, self.degenerate, ["polygon without area", "polygons without area"], "left out"),
            (
                354,
                self.missing_height,
                ["footprint without a usable height", "footprints without a usable height"],
                treated.as_str(),
            ),
            (
                355,
                self.negative_height,
                ["footprint with a negative height", "footprints with a negative height"],
                "left out",
            ),
            (
                356,
                self.decimal_comma,
                ["height with a decimal comma", "heights with a decimal comma"],
                "the comma is read as a point",
            ),
            (357, self.no_ground, ["footprint over nodata terrain", "footprints over nodata terrain"], "left out"),
            (
                358,
                self.too_far,
                ["footprint farther than 65536 m from the grid", "footprints farther than 65536 m from the grid"],
                "left out",
            ),
        ];
        for (code, count, [one, many], done) in found {
            if count > 0 {
                let what = counted(count as u64, one, many);
                warnings.push(Warning::new(code, format!("{}: {what}: {done}", path.display())));
            }
        }
    }
}

/// Reads footprints from GeoJSON.
///
/// # Errors
/// File errors for malformed GeoJSON (with line or feature), degrees, or a CRS that differs from the terrain's; usage
/// errors for bad numbers; limit errors for huge grids.
pub fn read_footprints(path: &Path, options: &FootprintOptions, warnings: &mut Vec<Warning>) -> Result<Scene> {
    let raw = read_raw_footprints(path, &options.height_field, options.top_field.as_deref())?;
    let mut sources = vec![Source::of(path, options.always_hash)?];
    let bounds = raw.bounds();
    let file_crs = options.crs.clone().or_else(|| raw.crs.clone());
    check_degrees(path, &raw, file_crs.as_ref(), bounds)?;

    let terrain = match &options.terrain {
        None => None,
        Some(terrain_path) => {
            let surface_options = SurfaceOptions {
                terrain: None,
                ground_m: None,
                building_threshold_m: 0.0,
                nodata_as: options.nodata_as,
                crs: options.crs.clone(),
                always_hash: options.always_hash,
            };
            let (terrain, _) = read_heights(terrain_path, &surface_options, warnings)?;
            refuse_two_crs((path, file_crs.as_ref()), (terrain_path, terrain.georef().crs()), |_, wanted| {
                format!("ogr2ogr -t_srs {} reprojected.geojson {}", wanted.label(), path.display())
            })?;
            sources.push(Source::of(terrain_path, options.always_hash)?);
            Some(terrain)
        }
    };
    let crs = file_crs.or_else(|| terrain.as_ref().and_then(|t| t.georef().crs().cloned()));
    if crs.is_none() {
        warnings.push(Warning::new(
            325,
            format!("{}: no coordinate reference system; local meters are assumed (`--crs EPSG:n`)", path.display()),
        ));
    }
    if let Some(crs) = &crs {
        warn_of_units(path, crs, warnings);
    }
    let grid = receivers_grid(path, options, terrain.as_ref(), bounds, crs.as_ref())?.with_crs(crs);
    let frame = Frame { x_origin: grid.x_min().floor(), y_origin: grid.y_min().floor(), unit_x: 1.0, unit_y: 1.0 };
    let ground = match terrain {
        Some(terrain) => Ground::Terrain(terrain),
        None => Ground::Flat(ground_steps(options.ground_m.unwrap_or(0.0))?),
    };
    let attribution = raw.attribution.clone();
    let (footprints, faults) = build(path, raw, options, &ground, frame, warnings)?;
    warn_if_nothing_meets_the_grid(path, &footprints, &grid, frame, warnings);
    Ok(Scene {
        name: name_of(path),
        grid,
        solids: Solids::Vector { footprints, frame, ground, faults },
        built_up: None,
        sources,
        attribution,
    })
}

/// GeoJSON without a CRS is longitude and latitude (RFC 7946); files that break the rule are local or projected.
fn check_degrees(path: &Path, raw: &RawFootprints, crs: Option<&Crs>, bounds: Option<[f64; 4]>) -> Result<()> {
    let Some(bounds) = bounds else { return Ok(()) };
    if let Some(crs) = crs {
        return refuse_degrees(path, crs, bounds, InputKind::Vector);
    }
    // A city in degrees spans less than a degree; local coordinates in meters of so small a scene would not.
    let [west, south, east, north] = bounds;
    let on_earth = west >= -180.0 && east <= 180.0 && south >= -90.0 && north <= 90.0;
    if on_earth && east - west < 1.0 && north - south < 1.0 && !raw.footprints.is_empty() {
        return refuse_degrees(path, &Crs::from_epsg(4326)?, bounds, InputKind::Vector);
    }
    Ok(())
}

fn receivers_grid(
    path: &Path,
    options: &FootprintOptions,
    terrain: Option<&Raster<i32>>,
    bounds: Option<[f64; 4]>,
    crs: Option<&Crs>,
) -> Result<GeoRef> {
    if let Some(cell) = options.cell_m
        && !(cell > 0.0 && cell.is_finite())
    {
        return Err(Error::usage(112, format!("`--cell` is `{cell}`, wanted above 0 m")));
    }
    let meters_per_unit = match crs.map(Crs::kind) {
        Some(CrsKind::Projected { meters_per_unit }) => meters_per_unit,
        _ => 1.0,
    };
    let cell = options.cell_m.unwrap_or(1.0) / meters_per_unit;
    let [west, south, east, north] = match (options.extent, terrain, bounds) {
        (Some(extent), _, _) => {
            let [west, south, east, north] = extent;
            if !(extent.iter().all(|v| v.is_finite()) && west < east && south < north) {
                return Err(Error::usage(
                    114,
                    format!("`--extent` is `{west},{south},{east},{north}`, wanted west < east and south < north"),
                ));
            }
            extent
        }
        (None, Some(terrain), _) if options.cell_m.is_none() => return Ok(terrain.georef().clone()),
        (None, Some(terrain), _) => {
            let g = terrain.georef();
            [g.x_min(), g.y_min(), g.x_max(), g.y_max()]
        }
        (None, None, Some([west, south, east, north])) => [
            (west / cell).floor() * cell,
            (south / cell).floor() * cell,
            (east / cell).ceil() * cell,
            (north / cell).ceil() * cell,
        ],
        (None, None, None) => {
            return Err(Error::file(
                308,
                format!("cannot map {}: it holds no polygon, so the grid's extent is unknown", path.display()),
            )
            .with_hint("give `--extent W,S,E,N` or `--terrain FILE`"));
        }
    };
    let cells = |length: f64| (length / cell - 1e-9).ceil().max(1.0);
    let (n_cols, n_rows) = (cells(east - west), cells(north - south));
    if n_cols.max(n_rows) > MAX_EXTENT_UNITS {
        return Err(Error::limit(
            502,
            format!(
                "cannot map {}: the grid would have {n_cols}×{n_rows} cells, wanted at most 65536 a side",
                path.display()
            ),
        )
        .with_hint("give `--extent W,S,E,N`, or a larger `--cell`"));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 ≤ n ≤ 65536 by the checks above")]
    let (n_cols, n_rows) = (n_cols as usize, n_rows as usize);
    GeoRef::new((west, south + cell * n_rows as f64), (cell, cell), (n_rows, n_cols), None)
        .ok_or_else(|| Error::usage(114, format!("no grid fits extent {west},{south},{east},{north}")))
}

/// Positions to the lattice, repair, heights.
fn build(
    path: &Path,
    raw: RawFootprints,
    options: &FootprintOptions,
    ground: &Ground,
    frame: Frame,
    warnings: &mut Vec<Warning>,
) -> Result<(Vec<Footprint>, FootprintFaults)> {
    let mut faults = FootprintFaults { not_areas: raw.not_areas, ..FootprintFaults::default() };
    let shaped: Vec<Shaped> = raw.footprints.into_par_iter().map(|f| shape(f, ground, frame)).collect();

    let area = |s: &Shaped| s.polygons.iter().map(|p| polygon_area(p)).sum::<f64>();
    let known: Vec<f64> = shaped
        .iter()
        .filter_map(|s| match s.raw.height {
            FoundHeight::Meters(m) | FoundHeight::DecimalComma(m) if m >= 0.0 || options.top_field.is_some() => Some(m),
            _ => None,
        })
        .collect();
    let median = median(known);
    let (mut missing_area, mut total_area) = (0.0, 0.0);
    let mut footprints = Vec::with_capacity(shaped.len());
    for shaped in shaped {
        faults.repaired += shaped.repaired;
        faults.unclosed += shaped.raw.unclosed;
        faults.degenerate += shaped.degenerate;
        total_area += area(&shaped);
        if shaped.too_far {
            faults.too_far += 1;
            continue;
        }
        if shaped.polygons.is_empty() {
            continue;
        }
        faults.decimal_comma += usize::from(matches!(shaped.raw.height, FoundHeight::DecimalComma(_)));
        // Storeys are counted from the ground, whatever the property would have been measured from.
        let mut above_datum = options.top_field.is_some();
        let height = match shaped.raw.height {
            FoundHeight::Meters(m) | FoundHeight::DecimalComma(m) => Some(m),
            FoundHeight::Missing => {
                faults.missing_height += 1;
                missing_area += area(&shaped);
                match options.missing {
                    MissingHeight::Fail => {
                        return Err(Error::file(
                            309,
                            format!(
                                "cannot use {}: feature `{}` has no usable `{}`",
                                path.display(),
                                shaped.raw.id,
                                options.top_field.as_ref().unwrap_or(&options.height_field)
                            ),
                        )
                        .with_hint("`--missing drop|levels|median`, or name the property with `--height-field`"));
                    }
                    MissingHeight::Drop => None,
                    MissingHeight::Levels => {
                        above_datum = false;
                        shaped.raw.levels.map(|levels| levels * METERS_PER_LEVEL)
                    }
                    MissingHeight::Median => median,
                }
            }
        };
        let Some(height) = height else { continue };
        if !above_datum && height < 0.0 {
            faults.negative_height += 1;
            continue;
        }
        let Some(base) = shaped.base else {
            faults.no_ground += 1;
            continue;
        };
        let top = height_steps(height)
            .and_then(|steps| if above_datum { Some(steps) } else { base.checked_add(steps) })
            .filter(|top| height_steps(meters(*top)).is_some())
            .ok_or_else(|| {
                Error::site(
                    205,
                    format!(
                        "cannot use {}: feature `{}` has height `{height}` m, wanted within ±32768 m of the datum",
                        path.display(),
                        shaped.raw.id
                    ),
                )
            })?;
        footprints.push(Footprint { id: shaped.raw.id, polygons: shaped.polygons, top, base });
    }
    let share = if total_area > 0.0 { missing_area / total_area } else { 0.0 };
    faults.warn(path, options.missing, share, warnings);
    Ok((footprints, faults))
}

/// Meters that stand for one storey where only `building:levels` is known (the default of OpenStreetMap renderers).
const METERS_PER_LEVEL: f64 = 3.0;

fn median(mut values: Vec<f64>) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    let (_, m, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*m)
}

fn warn_if_nothing_meets_the_grid(
    path: &Path,
    footprints: &[Footprint],
    grid: &GeoRef,
    frame: Frame,
    warnings: &mut Vec<Warning>,
) {
    if footprints.is_empty() {
        warnings
            .push(Warning::new(359, format!("{}: no building is left; every link is unobstructed", path.display())));
        return;
    }
    let (x0, y0) = frame.lattice_from_world(grid.x_min(), grid.y_min());
    let (x1, y1) = frame.lattice_from_world(grid.x_max(), grid.y_max());
    let inside = |p: &[i32; 2]| (x0..=x1).contains(&i64::from(p[0])) && (y0..=y1).contains(&i64::from(p[1]));
    let encloses = |f: &Footprint| {
        let points = || f.polygons.iter().flatten().flatten();
        let west = points().any(|p| i64::from(p[0]) <= x0) && points().any(|p| i64::from(p[0]) >= x1);
        let south = points().any(|p| i64::from(p[1]) <= y0) && points().any(|p| i64::from(p[1]) >= y1);
        west || south
    };
    let meets = |f: &Footprint| f.polygons.iter().flatten().flatten().any(inside) || encloses(f);
    if !footprints.iter().any(meets) {
        warnings.push(Warning::new(
            360,
            format!(
                "{}: none of {} footprints meets the grid, x {}…{}, y {}…{}; check the coordinate reference systems",
                path.display(),
                footprints.len(),
                grid.x_min(),
                grid.x_max(),
                grid.y_min(),
                grid.y_max()
            ),
        ));
    }
}
