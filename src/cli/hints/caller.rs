//! Remedies for callers of the library, where those of the command line are of no use. A caller reads
//! a scene once, whole and into memory, writes no standard output, and limits no memory or threads.

use skyshed_core::error::{Error as Core, UavAttempt, UavError};
use skyshed_io::Error as Io;
use skyshed_io::error::{Cause, CombineError, WriteFault};

use super::io::part_of_raster;
use crate::error::{Error, ErrorRepr, FitsPage, LimitError};
use crate::scene::is_raster_scene;

/// The remedy for an error, where one is known.
pub(in crate::cli) fn hint_for_caller(error: &Error) -> Option<String> {
    match error.repr() {
        ErrorRepr::Core(error) => match error.innermost() {
            Core::Uav { attempt: UavAttempt::Place { x, y, .. }, why: UavError::TooFar { has_crs: true, .. } }
                if x.abs() <= 180.0 && y.abs() <= 90.0 =>
            {
                Some("this looks like longitude and latitude: give UAVs as a GeoDataFrame that names its `crs`".into())
            }
            _ => super::core::hint(error),
        },
        ErrorRepr::Io(error) => of_files(error),
        ErrorRepr::Limit(error) => of_limit(error),
        ErrorRepr::OfUnit { error, .. } => hint_for_caller(error),
        _ => super::hint(error),
    }
}

fn of_files(error: &Io) -> Option<String> {
    match error {
        Io::Within(error, _) => of_files(error),
        Io::Read(read) if read.cause == Cause::LargeRaster => Some(part_of_raster(&read.name)),
        Io::Combine(CombineError::NoTerrainBelow(..)) => {
            Some("compare the extents and coordinate reference systems of both".into())
        }
        Io::Write(_, WriteFault::NoFile) => None,
        error => super::io::hint(error),
    }
}

fn of_limit(error: &LimitError) -> Option<String> {
    use LimitError as L;
    match error {
        L::Program { .. } | L::Exceeded(_) => Some("allow more memory".into()),
        L::Memory { name, .. } | L::Extent { word: name, .. } | L::LargeRaster { word: name, .. }
            if is_raster_scene(name.as_ref()) =>
        {
            Some(part_of_raster(name))
        }
        L::Memory { name, .. } => Some(super::own::less_memory(name, false)),
        L::PageCity { fits: FitsPage::Cells { cell_m }, .. } => Some(format!("cells of {cell_m} m or more would fit")),
        L::PageUavs { .. } => Some("`Scene.maps` takes any number".into()),
        L::Threads { .. } => Some("fewer with `RAYON_NUM_THREADS`".into()),
        error => super::own::of_limit(error),
    }
}
