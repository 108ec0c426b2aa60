//! Scenes and what belongs to them, read from files and checked once.

mod area;
mod building;
mod faults;
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

pub use area::read_area;
pub use building::HeightUnit;
pub use footprints::{
    BaseRule, DataAreaChoice, FootprintOptions, MissingHeight, read_footprints, read_footprints_and_repairs,
};
pub use mesh::{MeshOptions, read_mesh};
pub use outline::{Region, region_of};
pub use projection::Projection;
pub use repairs::Repair;
pub use sites::read_sites;
pub use source::{read_text, source_of};
pub use streamed::StreamedSurface;
pub use surface::{SurfaceOptions, read_surface, surface_grid};
pub use table::{BadRows, Row, RowFault, Table, readable};
pub use track::read_track;
pub use vector::VectorFormat;
pub use vertical::{SystemSaid, compare_vertical, vertical_of};

use std::path::Path;

use crate::crs::{InputKind, degrees_refusal};
use crate::error::{Error, Result};
use crate::raster::{Crs, CrsKind};

/// What a file is called in captions: its stem, spelled as words.
pub(crate) fn name_of(path: &Path) -> String {
    let stem = path.file_stem().map_or_else(|| "scene".into(), |s| s.to_string_lossy().replace('_', " "));
    let mut letters = stem.chars();
    letters.next().map_or(stem.clone(), |first| first.to_uppercase().chain(letters).collect())
}

/// Refuses to combine files in different CRSs, told apart by EPSG code, or by definition where neither has one; `remedy`
/// is the command that reprojects one of them. A CRS that is not known is taken for the other's.
pub fn refuse_two_crs(
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
