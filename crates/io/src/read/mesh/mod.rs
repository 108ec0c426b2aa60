//! Scenes from meshes: the top surface of triangles and other faces, cell by cell, or buildings.
//!
//! By default a mesh becomes a surface model: each cell is as high as the highest face over its
//! center. Faces are surfaces, not solids, and nothing below the highest one is kept: a bridge or a
//! balcony blocks down to the ground. Where no face is, the surface is the ground if that is known,
//! else nodata. Meshes name no CRS: their coordinates are local meters with z up unless another CRS
//! is given.
//!
//! As buildings, faces that are connected by their corners are one, closed or a roof over the
//! ground ([`super::solid`]).

mod connected;
mod faces;
mod obj;
#[cfg(feature = "meshes")]
mod ply;
mod top_surface;

use self::faces::Mesh;
use super::footprint_options::FootprintOptions;
use super::footprints;
use super::heights::warn_of_units;
use super::receivers_grid::{GridRequest, receivers_grid};
use super::repairs::Listing;
use super::solid::{Face, FaceKind, Solid};
use super::source::source_of;
use super::surface::{Empty, SurfaceOptions, scene_of};
use super::systems::refuse_degrees;
use super::vector::{Feature, FeatureSet};
use crate::city::City;
use crate::crs::Stretch;
use crate::error::{Error, InputKind, OddFile, Oddity, ReadFault, Result, Wanted, Warning};
use crate::input::Input;
use crate::quantity::VOID;

/// Options for reading a mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshOptions {
    /// Options of any surface model, such as the ground below it.
    pub surface: SurfaceOptions,
    /// Extent of the grid: west, south, east, north \[CRS units\]; by default that of the faces.
    pub extent: Option<[f64; 4]>,
    /// Cell size \[m\], 1 by default.
    pub cell_m: Option<f64>,
}

/// Reads a mesh from Wavefront OBJ or PLY, chosen by the extension.
///
/// # Errors
/// File errors for malformed files (with line or vertex) and meshes without faces; site errors for
/// heights out of range; usage errors for bad numbers; limit errors for huge grids.
pub fn read_mesh(input: impl Into<Input>, options: &MeshOptions, warnings: &mut Vec<Warning>) -> Result<City> {
    let input = &input.into();
    let mesh = mesh_of(input)?;
    let Some(bounds) = mesh.bounds() else {
        return Err(Error::read(input, ReadFault::Nothing(Wanted::Faces)));
    };
    let stretch = options.surface.crs.as_ref().and_then(|crs| Stretch::of(crs, bounds));
    warnings.extend(stretch.map(|stretch| Oddity::new(input, stretch.into()).into()));
    let crs = options.surface.crs.clone().map(|crs| stretch.map_or(crs.clone(), |stretch| stretch.apply(crs)));
    let crs = crs.as_ref();
    match crs {
        Some(crs) => {
            refuse_degrees(input, crs, bounds, InputKind::Vector)?;
            warn_of_units(input, crs, warnings);
        }
        None => warnings.push(Warning::of(input, OddFile::NoCrs)),
    }
    let request = GridRequest { extent: options.extent, cell_m: options.cell_m };
    let grid = receivers_grid(input, request, None, Some(bounds), crs)?.with_crs(crs.cloned());
    let surface = top_surface::top_surface(input, &mesh, &grid)?;
    let n_empty = surface.cells().iter().filter(|z| **z == VOID).count();
    if n_empty == surface.cells().len() {
        return Err(Error::read(input, ReadFault::NoFaceInGrid(grid.description())));
    }
    if n_empty > 0 {
        let is_known = options.surface.terrain.is_some() || options.surface.ground_m.is_some();
        warnings.push(Warning::of(input, OddFile::NoFace { n: n_empty as u64, is_known }));
    }
    let sources = vec![source_of(input, options.surface.always_hash)?];
    scene_of(input, (surface, Empty::Ground), sources, &options.surface, warnings)
}

/// Reads a mesh from Wavefront OBJ or PLY as buildings: closed ones, or roofs over the ground.
/// Their names are numbers from 1, in the order of their first faces.
///
/// # Errors
/// Errors of [`super::read_footprints`].
pub fn read_mesh_buildings(
    input: impl Into<Input>,
    options: &FootprintOptions,
    warnings: &mut Vec<Warning>,
) -> Result<City> {
    let input = &input.into();
    let mesh = mesh_of(input)?;
    if mesh.bounds().is_none() {
        return Err(Error::read(input, ReadFault::Nothing(Wanted::Faces)));
    }
    let feature = |faces: Vec<Face>| {
        Feature::of_solid(Solid::of(faces.into_iter().map(|face| (face, FaceKind::Unknown)).collect()))
    };
    let features = connected::buildings(&mesh).into_iter().map(feature).collect();
    let set = FeatureSet { features, ..FeatureSet::default() };
    let source = source_of(input, options.always_hash)?;
    footprints::scene_of(input, (set, vec![source]), options, Listing::CountsOnly, warnings).map(|(city, _)| city)
}

#[cfg(feature = "meshes")]
use ply::read as read_ply;

#[cfg(not(feature = "meshes"))]
fn read_ply(input: &Input) -> Result<Mesh> {
    Err(Error::unsupported(input, "this build reads no PLY").because(crate::error::Cause::NotBuilt))
}

/// Reads the mesh of a file, whose vertices must be finite.
fn mesh_of(input: &Input) -> Result<Mesh> {
    let mesh = if input.extension() == "ply" { read_ply(input)? } else { obj::read(input)? };
    match mesh.vertices.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
        None => Ok(mesh),
        Some(k) => {
            let what = format!("vertex number {k}, counted from 0, is not three finite numbers");
            Err(Error::malformed(input, what))
        }
    }
}
