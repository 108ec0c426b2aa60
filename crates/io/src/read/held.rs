//! Scenes from data that the caller holds in memory: heights of cells, and buildings as polygons.
//!
//! They are read as files of the same content are, with the same checks, warnings and lattice.

use std::sync::{Arc, Mutex};

use rayon::prelude::*;

use super::footprint_options::{FootprintOptions, HEIGHT};
use super::footprints;
use super::heights::{Heights, check_grid};
use super::repairs::Listing;
use super::reprojected::Reprojection;
use super::surface::{Empty, SurfaceOptions, reprojection_of, scene_of, scene_over, warning_of_voids};
use super::terrain::{Placed, terrain_on_grid, way_to_terrain};
use super::vector::{CornerHeights, Feature, FeatureSet, Property, wkb};
use crate::city::City;
use crate::error::{Error, HeightOf, Oddity, Place, ReadFault, Result, Warning};
use crate::formats::{reserve_cells, with_true_lengths};
use crate::input::Input;
use crate::quantity::{VOID, height_steps};
use crate::raster::{GeoRef, LargeVec, Raster};

/// Heights of cells, on the lattice.
#[derive(Debug, Clone)]
pub struct HeldHeights {
    name: Input,
    raster: Raster<i32>,
    n_void: u64,
}

impl HeldHeights {
    /// Collects heights row by row. `put(row, heights)` fills in a row, from the north and from the
    /// west \[m\], NaN where there is none; it returns `false` to stop. Threads of the current pool
    /// request different rows. `name` appears in messages and titles.
    ///
    /// # Errors
    /// E305 without any height; E205 for one beyond the lattice; E501 if they do not fit in memory;
    /// `Interrupted` if `put` stops.
    pub fn new(name: &str, georef: GeoRef, put: impl Fn(usize, &mut [f64]) -> bool + Sync) -> Result<HeldHeights> {
        let name = Input::bytes(name, Vec::new());
        drop(reserve_cells::<i32>(&name, &georef)?);
        let mut cells = LargeVec::<i32>::zeroed(georef.n_cells());
        let n_cols = georef.n_cols();
        let out_of_range = Mutex::new(None);
        let of_row = |heights: &mut Vec<f64>, (row, cells): (usize, &mut [i32])| {
            heights.resize(n_cols, f64::NAN);
            if !put(row, heights) {
                return None;
            }
            let (mut n_void, mut bad) = (0, None);
            for (cell, height) in cells.iter_mut().zip(heights.iter()) {
                *cell = height_steps(*height).unwrap_or(VOID);
                if *cell == VOID {
                    n_void += 1;
                    bad = bad.or_else(|| Some(*height).filter(|height| !height.is_nan()));
                }
            }
            if let (Some(bad), Ok(mut first)) = (bad, out_of_range.lock()) {
                // The first in the order of cells counts, whichever thread comes first.
                if first.is_none_or(|(first_row, _)| row < first_row) {
                    *first = Some((row, bad));
                }
            }
            Some(n_void)
        };
        let rows = cells.par_chunks_mut(n_cols).enumerate().map_init(Vec::new, of_row);
        let n_void: Option<u64> = rows.sum();
        let n_void = n_void.ok_or(crate::error::Error::Core(skyshed_core::Error::Interrupted))?;
        if let Ok(Some((_, height))) = out_of_range.into_inner() {
            return Err(Error::read(&name, ReadFault::HeightRange(HeightOf::Cell, height)));
        }
        if n_void == georef.n_cells() as u64 {
            return Err(Error::read(&name, ReadFault::AllVoid(n_void, "holds".into())));
        }
        Ok(HeldHeights { name, raster: Raster::new(georef, cells), n_void })
    }

    /// Returns the grid of the cells.
    pub fn georef(&self) -> &GeoRef {
        self.raster.georef()
    }
}

/// Returns the scene of a surface model, and of the terrain below it if the caller holds one. Both
/// are reprojected as files are.
///
/// # Errors
/// Errors of [`super::read_surface`] about heights and reference systems.
pub fn surface_of(
    surface: HeldHeights,
    terrain: Option<HeldHeights>,
    options: &SurfaceOptions,
    warnings: &mut Vec<Warning>,
) -> Result<City> {
    let HeldHeights { name, mut raster, n_void } = surface;
    let mut odd = None;
    let grid = with_true_lengths(raster.georef().clone(), &mut |of_grid| odd = Some(of_grid));
    raster = Raster::new(grid, raster.into_cells());
    let reprojection = reprojection_of(&name, raster.georef(), options)?;
    if reprojection.is_none() {
        warnings.extend(odd.map(|odd| Oddity::new(&name, odd).into()));
    }
    let heights = Heights { raster, n_void, sources: Vec::new() };
    let Heights { raster, n_void, .. } = Reprojection::of_held(reprojection, (&name, heights), warnings)?;
    warnings.extend(warning_of_voids(&name, n_void, options.nodata_as));
    let Some(HeldHeights { name: terrain_name, raster: terrain, .. }) = terrain else {
        return scene_of(&name, (raster, Empty::Nodata), Vec::new(), options, warnings);
    };
    let way = way_to_terrain(raster.georef(), terrain.georef(), options.project.is_some())?;
    if way.is_none() {
        check_grid(&terrain_name, terrain.georef(), warnings)?;
    }
    let (above, below) = (Placed { input: &name, on: raster.georef() }, Placed { input: &terrain_name, on: terrain });
    let terrain = terrain_on_grid(above, below, way.as_ref(), warnings)?;
    let terrain = Some(Placed { input: &terrain_name, on: terrain });
    scene_over(&name, (raster, Empty::Nodata), terrain, Vec::new(), options, warnings)
}

/// A building that the caller holds.
#[derive(Debug, Clone)]
pub struct HeldBuilding<'a> {
    /// Name; without one, its number from 1.
    pub id: Option<String>,
    /// Polygons as well-known binary (OGC 06-103r4, section 8).
    pub wkb: &'a [u8],
    /// Height above the ground, or as the options define it; NaN without one.
    pub height: f64,
}

/// Returns the scene of some buildings.
///
/// # Errors
/// Errors of [`super::read_footprints`] about geometries, heights and reference systems.
pub fn footprints_of(
    name: &str,
    buildings: &[HeldBuilding<'_>],
    options: &FootprintOptions,
    warnings: &mut Vec<Warning>,
) -> Result<City> {
    let input = &Input::bytes(name, Vec::new());
    let property = options.top_field.as_deref().or(options.height_field.as_deref()).unwrap_or(HEIGHT);
    let property: Arc<str> = property.into();
    let feature = |(k, building): (usize, &HeldBuilding<'_>)| {
        let areas = wkb::areas_of(building.wkb)
            .map_err(|fault| Error::malformed(input, fault).at(Place::Feature(k as u64 + 1)))?;
        let height = if building.height.is_nan() { Property::Null } else { Property::Number(building.height) };
        let properties = vec![(Arc::clone(&property), height)];
        // Heights of buildings in memory are given beside their geometry.
        Ok(Feature { id: building.id.clone(), properties, z: CornerHeights::None, ..areas.into_feature() })
    };
    let features = buildings.par_iter().enumerate().map(feature).collect::<Result<Vec<_>>>()?;
    let set = FeatureSet { features, ..FeatureSet::default() };
    footprints::scene_of(input, (set, Vec::new()), options, Listing::CountsOnly, warnings).map(|(city, _)| city)
}
