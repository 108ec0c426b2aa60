//! Scenes from building footprints with heights, on flat ground or terrain.
//!
//! Positions are rounded to the lattice. Then each polygon is repaired there by the even-odd rule
//! (i_overlay, integers throughout), so that later triangulation uses exactly the polygons that are
//! tested. Everything that is repaired or left out is counted in [`crate::city::FootprintFaults`]
//! and reported. Formats end where features begin (`vector/`); `building.rs` reads a feature's
//! properties as a building.

use super::area::read_area;
use super::building::{Buildings, take_surfaces};
use super::file_heights::FileHeights;
use super::footprint_options::FootprintOptions;
use super::ground_of_bases::terrain_through;
use super::heights::{HeightFile, Heights, warn_of_units};
use super::lattice_footprints::Making;
use super::parts::Grouping;
use super::projection::Projection;
use super::receivers_grid::{GridRequest, receivers_grid};
use super::repairs::{FaultLog, Listing, Repair};
use super::reprojected::Reprojection;
use super::scene_files::SceneFiles;
use super::solid::Face;
use super::source::{name_of, source_of};
use super::surface::ground_steps;
use super::systems::{refuse_degrees, refuse_two_crs, refuse_web_mercator};
use super::vector::{FeatureSet, Selection, Within, bounds, read_features};
use crate::city::{City, DataArea, Footprint, Ground, NodataAs, Solids, Source};
use crate::crs;
use crate::crs::{Transformation, Turn};
use crate::error::{Error, HeightOf, InputKind, Namer, OddFile, Pair, ReadFault, Result, Wanted, Warning};
use crate::formats::reserve_cells;
use crate::input::Input;
use crate::quantity::{BLOCKS_ALL, Frame, MAX_EXTENT_UNITS, VOID, height_steps, meters};
use crate::raster::{Crs, GeoRef, Raster};
use skyshed_request::{DataAreaChoice, GroundChoice};

/// Reads footprints from GeoJSON, CityJSON, CityGML, a shapefile, FlatGeobuf or a GeoPackage, chosen
/// by the first bytes. The input may be one file, a folder of tiles, an archive of them, or several
/// files as `A+B`.
///
/// # Errors
/// File errors for malformed files (with line or feature), degrees, or a CRS that differs from the
/// terrain's; usage errors for bad numbers and layers; limit errors for huge grids.
pub fn read_footprints(
    input: impl Into<Input>,
    options: &FootprintOptions,
    warnings: &mut Vec<Warning>,
) -> Result<City> {
    read(&input.into(), options, Listing::CountsOnly, warnings).map(|(scene, _)| scene)
}

/// Reads footprints as [`read_footprints`] does, and lists everything that was repaired or left
/// out, in the order of the file.
///
/// # Errors
/// Errors of [`read_footprints`].
pub fn read_footprints_and_repairs(
    input: impl Into<Input>,
    options: &FootprintOptions,
    warnings: &mut Vec<Warning>,
) -> Result<(City, Vec<Repair>)> {
    read(&input.into(), options, Listing::EachOne, warnings)
}

fn read(
    input: &Input,
    options: &FootprintOptions,
    listing: Listing,
    warnings: &mut Vec<Warning>,
) -> Result<(City, Vec<Repair>)> {
    let selection =
        Selection { layer: options.layer.as_deref(), within: within_reach(options), swap_axes: options.swap_axes };
    let files = SceneFiles::of(input)?;
    let set = read_features(input, &files, selection, warnings)?;
    let sources = files.sources(options.always_hash)?;
    scene_of(input, (set, sources), options, listing, warnings)
}

/// Returns the box in which features of a file can matter, with all parts of those that meet it.
/// There is none for a zone that the middle of all data chooses.
fn within_reach(options: &FootprintOptions) -> Option<Within<'_>> {
    /// Largest length of a building \[CRS units\].
    const LONGEST: f64 = 5000.0;
    let of_scene = match &options.project {
        Some(Projection::Auto) => return None,
        Some(Projection::To(crs)) => Some(crs),
        None => None,
    };
    let [west, south, east, north] = near(options).unwrap_or(grown(options.extent?, MAX_EXTENT_UNITS));
    let bounds = grown([west, south, east, north], LONGEST);
    Some(Within { bounds, of_scene, of_files: options.crs.as_ref() })
}

/// Returns the box outside of which no building matters. Of a terrain through all buildings each one
/// does.
fn near(options: &FootprintOptions) -> Option<[f64; 4]> {
    options.within.filter(|_| options.ground != Some(GroundChoice::Buildings))
}

/// Reads the terrain below footprints, if one was given, and adds its files to the sources.
fn terrain_below(
    input: &Input,
    file_crs: Option<&Crs>,
    options: &FootprintOptions,
    (sources, warnings): (&mut Vec<Source>, &mut Vec<Warning>),
) -> Result<Option<Raster<i32>>> {
    let Some(path) = &options.terrain else { return Ok(None) };
    let mut heights = terrain_heights(path, file_crs, options, warnings)?;
    let found = (path, heights.raster.georef().crs());
    refuse_two_crs((input, file_crs), found, Pair::FootprintsTerrain)?;
    sources.append(&mut heights.sources);
    Ok(Some(heights.raster))
}

/// Returns the ground of footprints: a terrain, a plane, or a terrain through the bases of buildings,
/// which `through` makes.
fn ground_below(
    input: &Input,
    (terrain, choice): (Option<Raster<i32>>, Option<GroundChoice>),
    heights: &FileHeights,
    through: impl FnOnce() -> Result<Raster<i32>>,
) -> Result<Ground> {
    Ok(match (terrain, choice, heights.bases) {
        (Some(terrain), ..) => Ground::Terrain(terrain),
        (None, Some(GroundChoice::Flat(m)), _) => Ground::Flat(ground_steps(m)?),
        (None, Some(GroundChoice::Buildings), Some(_)) => Ground::Terrain(through()?),
        (None, None, Some(bases)) if heights.has_tops => {
            let beyond = ReadFault::HeightRange(HeightOf::Vertex, bases.middle);
            Ground::Flat(height_steps(bases.middle).ok_or_else(|| Error::read(input, beyond))?)
        }
        (None, ..) => Ground::Flat(ground_steps(0.0)?),
    })
}

/// Returns the scene of features, and everything that was repaired or left out.
pub(super) fn scene_of(
    input: &Input,
    (mut set, mut sources): (FeatureSet, Vec<Source>),
    options: &FootprintOptions,
    listing: Listing,
    warnings: &mut Vec<Warning>,
) -> Result<(City, Vec<Repair>)> {
    let file_crs = match &options.crs {
        Some(crs) => Some(crs.clone()),
        None => std::mem::replace(&mut set.crs, Ok(None))?,
    };
    let (attribution, name) = (set.attribution.take(), set.name.take());
    let mut log = FaultLog::new(listing);
    take_surfaces(&mut set, options);
    warn_of_flat_roofs(input, &set, options, warnings);
    let mut raw = Buildings::of(input, set, options, &mut log)?;
    let file_crs = in_one_system(input, &mut raw, (file_crs, options), &mut log, warnings)?;
    let bounds = raw.bounds();
    check_degrees(input, file_crs.as_ref(), bounds)?;
    refuse_web_mercator(input, file_crs.as_ref(), Namer::Footprints)?;

    let terrain = terrain_below(input, file_crs.as_ref(), options, (&mut sources, warnings))?;
    let crs = file_crs.or_else(|| terrain.as_ref().and_then(|t| t.georef().crs().cloned()));
    refuse_web_mercator(input, crs.as_ref(), Namer::Terrain)?;
    if crs.is_none() {
        warnings.push(Warning::of(input, OddFile::NoCrs));
    }
    if let Some(crs) = &crs {
        warn_of_units(input, crs, warnings);
    }
    if raw.footprints.is_empty() && raw.not_there_share > 0.0 && options.extent.is_none() && terrain.is_none() {
        return Err(Error::read(input, ReadFault::Nothing(Wanted::Building)));
    }
    let request = GridRequest { extent: options.extent, cell_m: options.cell_m };
    let grid = receivers_grid(input, request, terrain.as_ref(), bounds, crs.as_ref())?.with_crs(crs);
    let frame = Frame { x_origin: grid.x_min().floor(), y_origin: grid.y_min().floor(), unit_x: 1.0, unit_y: 1.0 };
    let data_area = data_area(options, &grid, warnings)?;
    if let DataAreaChoice::Within(input) = &options.data_area {
        sources.push(source_of(&**input, options.always_hash)?);
    }
    if let (Some(extent), Some(_)) = (options.extent, &options.project) {
        raw.footprints.iter_mut().for_each(|footprint| footprint.is_asked = footprint.meets(extent));
    }
    let grouping = Grouping::of(&raw.footprints, options.parts, frame)
        .map_err(|(k, tangle)| Error::tangled(input, &raw.footprints[k].id, tangle))?;
    let heights = FileHeights::of(&raw.footprints, &grouping, &options.missing);
    let near = near(options);
    let through = || terrain_through(input, raw.footprints.iter(), &grid);
    let mut ground = ground_below(input, (terrain, options.ground), &heights, through)?;
    warn_of_the_ground(input, &heights, (options, &ground), warnings);
    let making = Making {
        input,
        options,
        ground: &ground,
        frame,
        meters_per_unit: grid.meters_per_unit(),
        heights: &heights,
        grouping: &grouping,
    };
    let footprints = making.prisms(raw, near, &mut log, warnings)?;
    if let (Ground::Terrain(terrain), NodataAs::Block) = (&ground, options.nodata_as) {
        ground = Ground::Terrain(blocking_where_unknown(input, terrain, &grid)?);
    }
    warn_if_nothing_meets_the_grid(input, &footprints, &grid, frame, warnings);
    let faults = log.counts;
    let scene = City {
        name: name.unwrap_or_else(|| name_of("footprints", input)),
        grid,
        solids: Solids::Vector { footprints, frame, ground, faults, data_area },
        built_up: None,
        sources,
        attribution,
        heights: Some(heights.sources),
    };
    Ok((scene, log.into_list()))
}

/// Brings positions together over 180 degrees, and into the projection of the options. Returns the
/// reference system that they are in then.
///
/// # Errors
/// Of the reference system of the file or of the projection.
fn in_one_system(
    input: &Input,
    raw: &mut Buildings,
    (file_crs, options): (Option<Crs>, &FootprintOptions),
    log: &mut FaultLog,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Crs>> {
    // Local coordinates have no place on earth.
    if file_crs.is_some() || options.project.is_some() {
        let crs = said_or_degrees(file_crs.as_ref(), raw.bounds())?;
        crs.into_iter().for_each(|crs| bring_together(raw, &crs));
    }
    let Some(projection) = &options.project else { return Ok(file_crs) };
    let (from, bounds) = (file_crs.clone(), raw.bounds());
    let to = project(input, raw, file_crs, projection, warnings)?;
    move_listed(log, from, to.as_ref(), bounds)?;
    Ok(to)
}

/// Moves positions on both sides of 180 degrees side by side, so that their middle lies between
/// them.
fn bring_together(raw: &mut Buildings, crs: &Crs) {
    let Some(length) = Turn::length_in(crs) else { return };
    let mut eastings = Vec::new();
    for_each_position(raw, |x, _| eastings.push(*x));
    if let Some(turn) = Turn::over(&eastings, length) {
        for_each_position(raw, |x, _| *x = turn.apply(*x));
    }
}

/// Visits x and y of all positions of footprints, also those of their roofs.
fn for_each_position(raw: &mut Buildings, mut visit: impl FnMut(&mut f64, &mut f64)) {
    for footprint in &mut raw.footprints {
        for [x, y] in footprint.polygons.iter_mut().chain(&mut footprint.ground).flatten().flatten() {
            visit(x, y);
        }
        for [x, y, _] in footprint.roof.iter_mut().flatten().flatten() {
            visit(x, y);
        }
    }
}

/// Warns of sloped roofs that are taken flat by default.
fn warn_of_flat_roofs(input: &Input, set: &FeatureSet, options: &FootprintOptions, warnings: &mut Vec<Warning>) {
    /// Largest difference between the corners of a flat surface \[m\].
    const FLAT_M: f64 = 0.1;
    if options.roofs.is_some() || options.height_field.is_some() || options.top_field.is_some() {
        return;
    }
    let slopes = |face: &Face| {
        let heights = || face.iter().flatten().map(|[.., z]| *z);
        heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min) > FLAT_M
    };
    let n = set.features.iter().filter(|feature| feature.roof.iter().any(slopes)).count();
    if n > 0 {
        warnings.push(Warning::of(input, OddFile::FlatRoofs { n }));
    }
}

/// Returns the area in which the ground is known.
fn data_area(options: &FootprintOptions, grid: &GeoRef, warnings: &mut Vec<Warning>) -> Result<DataArea> {
    match (&options.data_area, options.extent) {
        (DataAreaChoice::All, _) => Ok(DataArea::All),
        (DataAreaChoice::Within(input), _) => read_area(Input::path(&**input), grid).map(DataArea::Within),
        (DataAreaChoice::Auto, None) => Ok(DataArea::NearFootprints),
        (DataAreaChoice::Auto, Some(_)) => {
            warnings.push(Warning::WholeExtent);
            Ok(DataArea::All)
        }
    }
}

/// Returns a terrain whose voids block everything, with such cells around it as far as the grid of
/// receivers reaches.
fn blocking_where_unknown(input: &Input, terrain: &Raster<i32>, grid: &GeoRef) -> Result<Raster<i32>> {
    let from = terrain.georef();
    let beyond = |length: f64, cell: f64| (length / cell - 1e-6).ceil().max(0.0);
    let [west, east] = [from.x_min() - grid.x_min(), grid.x_max() - from.x_max()].map(|l| beyond(l, from.cell_width()));
    let [south, north] =
        [from.y_min() - grid.y_min(), grid.y_max() - from.y_max()].map(|l| beyond(l, from.cell_height()));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most the cells of the receivers' grid"
    )]
    let [west_n, east_n, south_n, north_n] = [west, east, south, north].map(|n| n as usize);
    let (n_rows, n_cols) = (from.n_rows() + south_n + north_n, from.n_cols() + west_n + east_n);
    let corner = (from.x_min() - west * from.cell_width(), from.y_max() + north * from.cell_height());
    let georef = GeoRef::new(corner, (from.cell_width(), from.cell_height()), (n_rows, n_cols), from.crs().cloned());
    let Some(georef) = georef else { return Ok(terrain.clone()) };
    let mut cells = reserve_cells(input, &georef)?;
    cells.resize(georef.n_cells(), BLOCKS_ALL);
    for row in 0..from.n_rows() {
        let to = &mut cells[(row + north_n) * n_cols + west_n..][..from.n_cols()];
        to.iter_mut().zip(terrain.row(row)).filter(|(_, z)| **z != VOID).for_each(|(to, z)| *to = *z);
    }
    Ok(Raster::new(georef, cells))
}

/// Transforms the places that are listed so far into the system of the scene. Positions of the file
/// lie within `bounds`.
fn move_listed(log: &mut FaultLog, from: Option<Crs>, to: Option<&Crs>, bounds: Option<[f64; 4]>) -> Result<()> {
    let (Some(to), Some([west, south, east, north]), true) = (to, bounds, log.has_listed()) else { return Ok(()) };
    // Positions without a system were taken for degrees.
    let from = from.map_or_else(|| crs::from_epsg(4326), Ok)?;
    if from != *to {
        let way = Transformation::new(&from, to, ((west + east) / 2.0, (south + north) / 2.0))?;
        log.move_places(|place| way.apply(place).ok());
    }
    Ok(())
}

/// Returns the system of a file; without one, longitude and latitude if its positions can be
/// degrees.
fn said_or_degrees(said: Option<&Crs>, bounds: Option<[f64; 4]>) -> Result<Option<Crs>> {
    match (said, bounds) {
        (Some(crs), _) => Ok(Some(crs.clone())),
        (None, Some(bounds)) if may_be_degrees(bounds) => crs::from_epsg(4326).map(Some),
        (None, _) => Ok(None),
    }
}

/// Returns `true` when positions can be longitude and latitude. Writers continue past 180 degrees
/// rather than cut a polygon there.
fn may_be_degrees([west, south, east, north]: [f64; 4]) -> bool {
    west >= -360.0 && east <= 360.0 && south >= -90.0 && north <= 90.0
}

/// Transforms all positions into the wanted system, and warns of that; returns the system that they
/// are in afterwards.
///
/// Positions without a system that can be degrees are taken for longitude and latitude.
fn project(
    input: &Input,
    raw: &mut Buildings,
    from: Option<Crs>,
    projection: &Projection,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Crs>> {
    let Some([west, south, east, north]) = raw.bounds() else { return Ok(from) };
    let bounds_of_file = [west, south, east, north];
    let from = said_or_degrees(from.as_ref(), Some(bounds_of_file))?;
    let from = from.ok_or_else(|| Error::read(input, ReadFault::NoCrs))?;
    let middle = ((west + east) / 2.0, (south + north) / 2.0);
    let to = projection.target(&from, middle)?;
    if from == to {
        return Ok(Some(to));
    }
    let way = Transformation::new(&from, &to, middle)?;
    let mut failed = None;
    for_each_position(raw, |x, y| match way.apply((*x, *y)) {
        Ok(moved) => (*x, *y) = moved,
        Err(error) => failed = failed.take().or(Some(error)),
    });
    if let Some(error) = failed {
        return Err(error);
    }
    if bounds(raw.footprints.iter().flat_map(|f| &f.polygons)).is_some() {
        let (from, to, name) = (from.label(), to.label(), to.name().to_string());
        warnings.push(Warning::of(input, OddFile::Projected { from, to, name }));
    }
    Ok(Some(to))
}

/// Reads the heights of the terrain, reprojected to the system of the footprints if these are
/// reprojected too.
fn terrain_heights(
    input: &Input,
    scene_crs: Option<&Crs>,
    options: &FootprintOptions,
    warnings: &mut Vec<Warning>,
) -> Result<Heights> {
    let file = HeightFile::open_terrain(input, options.crs.as_ref(), warnings)?;
    let wanted = scene_crs.filter(|_| options.project.is_some() && file.georef().crs().is_some());
    let reprojection = match wanted {
        None => None,
        Some(crs) => Reprojection::plan(input, file.georef(), &Projection::To(crs.clone()), None)?,
    };
    Reprojection::read(reprojection, file, options.always_hash, warnings)
}

/// Grows a box on all sides.
fn grown([west, south, east, north]: [f64; 4], by: f64) -> [f64; 4] {
    [west - by, south - by, east + by, north + by]
}

/// Warns where solids stand on another height than the flat ground of the scene, and names the
/// ground that was taken for them.
fn warn_of_the_ground(
    input: &Input,
    heights: &FileHeights,
    (options, ground): (&FootprintOptions, &Ground),
    warnings: &mut Vec<Warning>,
) {
    let (Ground::Flat(z), Some(bases), true) = (ground, heights.bases, heights.has_tops) else { return };
    let (ground_m, range_m) = (meters(*z), (bases.lowest, bases.highest));
    let odd = match options.ground {
        None => OddFile::GroundOfBases { ground_m, range_m },
        _ if (bases.lowest..=bases.highest).contains(&ground_m) => return,
        _ => OddFile::OtherGround { ground_m, range_m, median_m: bases.middle },
    };
    warnings.push(Warning::of(input, odd));
}

/// Refuses degrees. GeoJSON without a CRS is longitude and latitude (RFC 7946); files that break
/// the rule are local or projected.
fn check_degrees(input: &Input, crs: Option<&Crs>, bounds: Option<[f64; 4]>) -> Result<()> {
    let Some(bounds) = bounds else { return Ok(()) };
    // A city in degrees spans less than a degree; one in meters does not lie within a meter.
    let [west, south, east, north] = bounds;
    let is_like_degrees = may_be_degrees(bounds) && east - west < 1.0 && north - south < 1.0;
    match crs {
        None if is_like_degrees => refuse_degrees(input, &crs::from_epsg(4326)?, bounds, InputKind::Vector),
        None => Ok(()),
        Some(crs) => {
            refuse_degrees(input, crs, bounds, InputKind::Vector)?;
            if is_like_degrees { Err(Error::read(input, ReadFault::LikeDegrees(crs.label()))) } else { Ok(()) }
        }
    }
}

fn warn_if_nothing_meets_the_grid(
    input: &Input,
    footprints: &[Footprint],
    grid: &GeoRef,
    frame: Frame,
    warnings: &mut Vec<Warning>,
) {
    if footprints.is_empty() {
        warnings.push(Warning::of(input, OddFile::NoBuilding));
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
        let grid = [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()];
        warnings.push(Warning::of(input, OddFile::NoneMeets { n: footprints.len(), grid }));
    }
}
