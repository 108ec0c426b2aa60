//! Scenes: what the user gave, read and checked once: a surface model, footprints with heights, or a generated city.
//!
//! A [`Scene`] holds plain data on a georeferenced grid of receivers; positions of footprints and all heights are
//! already on the lattice ([`crate::quantity`]). What a ray can hit is built from it in [`crate::height_field`].

mod area;
mod building;
mod built_up;
mod faults;
mod footprint;
mod footprints;
mod geojson_file;
mod heights;
mod mesh;
mod outline;
mod projection;
mod receivers_grid;
mod repairs;
mod reprojected;
mod sites;
mod streamed;
mod source;
mod surface;
mod table;
mod terrain;
mod track;
mod vector;
mod vertical;

pub use area::{Area, read_area};
pub use building::HeightUnit;
pub use built_up::{BuildingHeights, BuiltUp, BuiltUpCity};
pub use faults::{Fault, FootprintFaults};
pub use footprint::{BuildingHeight, Footprint};
pub use footprints::{
    BaseRule, DataAreaChoice, FootprintOptions, HeightGap, MissingHeight, read_footprints, read_footprints_and_repairs,
};
pub use mesh::{MeshOptions, read_mesh};
pub use outline::{Region, region_of};
pub use projection::Projection;
pub use repairs::Repair;
pub use sites::{GivenSite, Site, read_sites};
pub use source::Source;
pub(crate) use source::read_text;
pub use streamed::{StreamedSurface, WindowedBase, WindowedSolids, row_bands};
pub use surface::{SurfaceOptions, read_surface, surface_grid};
pub use table::BadRows;
pub(crate) use table::{RowFault, Table, readable};
pub use track::read_track;
pub use vector::VectorFormat;
pub use vertical::{SystemSaid, compare_vertical, vertical_of};

use std::path::Path;

use crate::error::{Error, Result};
use crate::quantity::Frame;
use crate::raster::{BitGrid, Crs, CrsKind, GeoRef, InputKind, Raster, degrees_refusal};

/// A city and the grid of receivers over it.
#[derive(Debug, Clone)]
pub struct Scene {
    /// What the scene is called in captions: the file name or the generator's parameters.
    pub name: String,
    /// The grid of receivers.
    pub grid: GeoRef,
    /// What stands in the way.
    pub solids: Solids,
    /// The built-up parameters of a generated city.
    pub built_up: Option<BuiltUp>,
    /// The files that the scene was read from.
    pub sources: Vec<Source>,
    /// Whom pictures must credit, where the data say so.
    pub attribution: Option<String>,
    /// Footprints without heights, where there are any.
    pub height_gap: Option<HeightGap>,
}

/// What a file is called in captions: its stem, spelled as words.
pub(crate) fn name_of(path: &Path) -> String {
    let stem = path.file_stem().map_or_else(|| "scene".into(), |s| s.to_string_lossy().replace('_', " "));
    let mut letters = stem.chars();
    letters.next().map_or(stem.clone(), |first| first.to_uppercase().chain(letters).collect())
}

/// The solids of a scene.
#[derive(Debug, Clone)]
pub enum Solids {
    /// Columns over the cells of the grid.
    Raster {
        /// Surface heights \[1/1024 m above the datum\], [`crate::quantity::VOID`] where there is none.
        surface: Raster<i32>,
        /// What receivers stand on.
        ground: Ground,
        /// A cell whose surface is more than this above the ground is a building \[1/1024 m\].
        building_threshold: i32,
        /// The cells whose surface is that of the terrain, because the surface model has none there: what stands on them is
        /// not known, so they hold no receiver.
        voids: Option<BitGrid>,
    },
    /// Prisms over footprints.
    Vector {
        /// The footprints, on the lattice of `frame`.
        footprints: Vec<Footprint>,
        /// The lattice of the footprints: unit 1 m, origin at the grid's south-west corner floored to a whole meter.
        frame: Frame,
        /// What receivers and buildings stand on.
        ground: Ground,
        /// What was mended or left out.
        faults: FootprintFaults,
        /// Where anything is known of the ground.
        data_area: DataArea,
    },
}

impl Solids {
    /// The heights of the buildings of a vector scene and where they stand, of those that have both; none of a raster.
    pub fn building_heights(&self) -> Vec<BuildingHeight> {
        let Solids::Vector { footprints, frame, .. } = self else { return Vec::new() };
        footprints.iter().filter_map(|footprint| footprint.building_height(*frame)).collect()
    }
}

/// Where a vector scene knows the ground. Cells elsewhere hold no data: no receiver, no zone, no candidate.
#[derive(Debug, Clone, Default)]
pub enum DataArea {
    /// Everywhere.
    #[default]
    All,
    /// What is between the footprints: their closing by a disc of 100 m, holes filled. Everywhere, where less than a tenth
    /// of that is open ground.
    NearFootprints,
    /// An area that the user drew.
    Within(Area),
}

/// What stands below the buildings.
#[derive(Debug, Clone)]
pub enum Ground {
    /// Nothing but the surface model is known: receivers stand on the surface.
    Surface,
    /// A horizontal plane \[1/1024 m above the datum\].
    Flat(i32),
    /// A terrain model \[1/1024 m above the datum\]. In a raster scene it lies on the scene's own grid.
    Terrain(Raster<i32>),
}

/// What to do with nodata cells of rasters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NodataAs {
    /// They block nothing.
    #[default]
    Clear,
    /// They block everything.
    Block,
}

/// Refuses to combine files in different CRSs, told apart by EPSG code, or by definition where neither has one; `remedy`
/// is the command that reprojects one of them. A CRS that is not known is taken for the other's.
pub(crate) fn refuse_two_crs(
    (a_path, a): (&Path, Option<&Crs>),
    (b_path, b): (&Path, Option<&Crs>),
    remedy: impl Fn(&Crs, &Crs) -> String,
) -> Result<()> {
    let (Some(a), Some(b)) = (a, b) else { return Ok(()) };
    if a.same_as(b) {
        return Ok(());
    }
    let (a_path, b_path, a_label, b_label) = (a_path.display(), b_path.display(), a.label(), b.label());
    let text = format!("cannot combine {a_path} in {a_label} with {b_path} in {b_label}: wanted one CRS");
    Err(Error::file(311, text).with_hint(remedy(a, b)))
}

/// Refuses a CRS in degrees, with the command that fixes it; `bounds` is `[west, south, east, north]`.
pub(crate) fn refuse_degrees(what: &Path, crs: &Crs, bounds: [f64; 4], kind: InputKind) -> Result<()> {
    match crs.kind() {
        CrsKind::Geographic => {
            let center = ((bounds[0] + bounds[2]) / 2.0, (bounds[1] + bounds[3]) / 2.0);
            Err(degrees_refusal(&what.display().to_string(), crs, kind, center))
        }
        CrsKind::Projected { .. } | CrsKind::Other => Ok(()),
    }
}
