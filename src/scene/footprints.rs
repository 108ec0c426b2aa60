//! Scenes from building footprints with heights, on flat ground or terrain.
//!
//! Order of events: positions are rounded to the lattice, then each polygon is repaired there by the even-odd rule
//! (i_overlay, integers throughout), so that what is triangulated later is exactly what is tested. Every mended or
//! left-out thing is counted in [`FootprintFaults`] and reported. Formats end where features begin (`vector/`); what a
//! feature says of a building is read in `building.rs`.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::building::{Buildings, FoundHeight, HeightUnit, METERS_PER_LEVEL};
use super::faults::{FootprintFaults, HeightWords};
use super::heights::{HeightFile, Heights, warn_of_units};
use super::outline::{Shaped, polygon_area, shape};
use super::projection::{Projection, project};
use super::receivers_grid::{GridRequest, receivers_grid};
use super::reprojected::Reprojection;
use super::surface::ground_steps;
use super::vector::{Selection, read_features};
use super::{Ground, NodataAs, Scene, Solids, Source, name_of, refuse_degrees, refuse_two_crs};
use crate::error::{Error, Result, Warning};
use crate::quantity::{Frame, MAX_EXTENT_UNITS, height_steps, meters, tidy};
use crate::raster::{Crs, GeoRef, InputKind};

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
    /// Three meters for each storey of [`FootprintOptions::levels_field`] and of `roof:levels`; left out where the former
    /// is missing too.
    Levels,
    /// The median of the known heights.
    Median,
}

/// How footprints are read.
#[derive(Debug, Clone, PartialEq)]
pub struct FootprintOptions {
    /// Property that holds the height above ground; `None` is `height`, or of solids their own top.
    pub height_field: Option<String>,
    /// Property that holds the absolute height of the top above the datum, instead.
    pub top_field: Option<String>,
    /// Unit of heights that name none.
    pub height_unit: HeightUnit,
    /// Property that holds the number of storeys, for [`MissingHeight::Levels`].
    pub levels_field: String,
    /// Policy for missing heights.
    pub missing: MissingHeight,
    /// Table of a GeoPackage; needed where it has several.
    pub layer: Option<String>,
    /// Terrain model, in the same CRS unless `project` is given.
    pub terrain: Option<PathBuf>,
    /// Height of flat ground \[m above the datum\], 0 by default.
    pub ground_m: Option<f64>,
    /// Extent of the receivers' grid: west, south, east, north \[CRS units\].
    pub extent: Option<[f64; 4]>,
    /// Cell size of the receivers' grid \[m\]; by default the terrain's, else 1.
    pub cell_m: Option<f64>,
    /// The CRS to assume.
    pub crs: Option<Crs>,
    /// Another CRS for the scene than that of the file.
    pub project: Option<Projection>,
    /// What nodata cells of the terrain do.
    pub nodata_as: NodataAs,
    /// Whether to hash inputs of any size.
    pub always_hash: bool,
}

impl Default for FootprintOptions {
    /// Heights in meters in the property `height`, on flat ground at 0 m, on a grid of 1 m over the footprints.
    fn default() -> Self {
        FootprintOptions {
            height_field: None,
            top_field: None,
            height_unit: HeightUnit::default(),
            levels_field: "building:levels".into(),
            missing: MissingHeight::default(),
            layer: None,
            terrain: None,
            ground_m: None,
            extent: None,
            cell_m: None,
            crs: None,
            project: None,
            nodata_as: NodataAs::default(),
            always_hash: false,
        }
    }
}

/// Reads footprints from GeoJSON, CityJSON, a shapefile, FlatGeobuf or a GeoPackage, told apart by their extension.
///
/// # Errors
/// File errors for malformed files (with line or feature), degrees, or a CRS that differs from the terrain's; usage
/// errors for bad numbers and layers; limit errors for huge grids.
pub fn read_footprints(path: &Path, options: &FootprintOptions, warnings: &mut Vec<Warning>) -> Result<Scene> {
    // The extent is in the scene's CRS: of a file in another one all must be read.
    let bounds = options.extent.filter(|_| options.project.is_none()).map(grown);
    let selection = Selection { layer: options.layer.as_deref(), bounds };
    let mut set = read_features(path, selection)?;
    let mut sources = vec![Source::of(path, options.always_hash)?];
    let file_crs = match &options.crs {
        Some(crs) => Some(crs.clone()),
        None => std::mem::replace(&mut set.crs, Ok(None))?,
    };
    let attribution = set.attribution.take();
    let mut raw = Buildings::of(path, set, options)?;
    let file_crs = match &options.project {
        Some(projection) => project(path, &mut raw, file_crs, projection, warnings)?,
        None => file_crs,
    };
    let bounds = raw.bounds();
    check_degrees(path, file_crs.as_ref(), bounds)?;

    let terrain = match &options.terrain {
        None => None,
        Some(terrain_path) => {
            let mut heights = terrain_heights(terrain_path, file_crs.as_ref(), options, warnings)?;
            let terrain = heights.raster;
            refuse_two_crs((path, file_crs.as_ref()), (terrain_path, terrain.georef().crs()), |_, wanted| {
                format!("ogr2ogr -t_srs {} reprojected.geojson {}", wanted.label(), path.display())
            })?;
            sources.append(&mut heights.sources);
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
    let request = GridRequest { extent: options.extent, cell_m: options.cell_m };
    let grid = receivers_grid(path, request, terrain.as_ref(), bounds, crs.as_ref())?.with_crs(crs);
    let frame = Frame { x_origin: grid.x_min().floor(), y_origin: grid.y_min().floor(), unit_x: 1.0, unit_y: 1.0 };
    let ground = match terrain {
        Some(terrain) => Ground::Terrain(terrain),
        None => Ground::Flat(ground_steps(options.ground_m.unwrap_or(0.0))?),
    };
    warn_of_the_ground(path, &raw, &ground, warnings);
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

/// The heights of the terrain, brought into the system of the footprints if these are brought into another one too.
fn terrain_heights(
    path: &Path,
    scene_crs: Option<&Crs>,
    options: &FootprintOptions,
    warnings: &mut Vec<Warning>,
) -> Result<Heights> {
    let file = HeightFile::open(path, options.crs.as_ref(), warnings)?;
    let wanted = scene_crs.filter(|_| options.project.is_some() && file.georef().crs().is_some());
    let reprojection = match wanted {
        None => None,
        Some(crs) => Reprojection::plan(path, file.georef(), &Projection::To(crs.clone()), None)?,
    };
    Reprojection::read(reprojection, file, options.always_hash, warnings)
}

/// An extent with all that can cast a shadow into it: a UAV is at most [`MAX_EXTENT_UNITS`] from any cell that it sees.
fn grown([west, south, east, north]: [f64; 4]) -> [f64; 4] {
    [west - MAX_EXTENT_UNITS, south - MAX_EXTENT_UNITS, east + MAX_EXTENT_UNITS, north + MAX_EXTENT_UNITS]
}

/// Warns where solids stand on another height than the flat ground of the scene.
fn warn_of_the_ground(path: &Path, raw: &Buildings, ground: &Ground, warnings: &mut Vec<Warning>) {
    let Ground::Flat(z) = ground else { return };
    let lowest: Vec<f64> = raw.footprints.iter().filter_map(|f| f.lowest).collect();
    let range = lowest.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |r, z| (r.0.min(*z), r.1.max(*z)));
    let Some(middle) = median(lowest) else { return };
    if (range.0..=range.1).contains(&meters(*z)) {
        return;
    }
    let text = format!(
        "{}: the ground is at {} m, but the buildings begin at {} to {} m above the datum (`--terrain FILE`, or `--ground \
         {}`, the median)",
        path.display(),
        tidy(meters(*z)),
        tidy(range.0),
        tidy(range.1),
        tidy(middle)
    );
    warnings.push(Warning::new(366, text));
}

/// GeoJSON without a CRS is longitude and latitude (RFC 7946); files that break the rule are local or projected.
fn check_degrees(path: &Path, crs: Option<&Crs>, bounds: Option<[f64; 4]>) -> Result<()> {
    let Some(bounds) = bounds else { return Ok(()) };
    if let Some(crs) = crs {
        return refuse_degrees(path, crs, bounds, InputKind::Vector);
    }
    // A city in degrees spans less than a degree; local coordinates in meters of so small a scene would not.
    let [west, south, east, north] = bounds;
    let on_earth = west >= -180.0 && east <= 180.0 && south >= -90.0 && north <= 90.0;
    if on_earth && east - west < 1.0 && north - south < 1.0 {
        return refuse_degrees(path, &Crs::from_epsg(4326)?, bounds, InputKind::Vector);
    }
    Ok(())
}

/// Positions to the lattice, repair, heights.
fn build(
    path: &Path,
    raw: Buildings,
    options: &FootprintOptions,
    ground: &Ground,
    frame: Frame,
    warnings: &mut Vec<Warning>,
) -> Result<(Vec<Footprint>, FootprintFaults)> {
    let mut faults = FootprintFaults {
        not_areas: raw.not_areas,
        not_buildings: raw.not_buildings,
        parts: raw.parts,
        ..FootprintFaults::default()
    };
    let shaped: Vec<Shaped> = raw.footprints.into_par_iter().map(|f| shape(f, ground, frame)).collect();

    let area = |s: &Shaped| s.polygons.iter().map(|p| polygon_area(p)).sum::<f64>();
    let known: Vec<f64> = shaped
        .iter()
        .filter_map(|s| match s.raw.height {
            FoundHeight::Meters(m) | FoundHeight::DecimalComma(m) if m >= 0.0 || s.raw.above_datum => Some(m),
            _ => None,
        })
        .collect();
    let median = median(known);
    let height_words = HeightWords::of(options, raw.other_names);
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
        faults.floating += usize::from(shaped.raw.floats);
        faults.decimal_comma += usize::from(matches!(shaped.raw.height, FoundHeight::DecimalComma(_)));
        // Storeys are counted from the ground, whatever the property would have been measured from.
        let mut above_datum = shaped.raw.above_datum;
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
                                height_words.property
                            ),
                        )
                        .with_hint("`--missing drop|levels|median`, or name the property with `--height-field`"));
                    }
                    MissingHeight::Drop => None,
                    MissingHeight::Levels => {
                        above_datum = false;
                        faults.from_levels += usize::from(shaped.raw.levels.is_some());
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
    faults.warn(path, &height_words, share, warnings);
    Ok((footprints, faults))
}

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
