//! What to do about what is odd: the words that follow a warning in parentheses.

use skyshed_core::Warning as OddScene;
use skyshed_io::Warning as OddFiles;
use skyshed_io::error::{OddFile, OddRaster};

use crate::error::{OddRun, Warning};
use crate::quantity::tidy;

/// The flag that a warning is about, or a remedy, where one is known.
pub(in crate::cli) fn of_warning(warning: &Warning) -> Option<String> {
    let hint = match warning {
        Warning::Core(OddScene::UnknownGround { .. }) => "`--nodata-as`",
        Warning::Core(OddScene::LittleOpenGround) => "`--data-area auto|all|FILE`",
        Warning::Io(OddFiles::WholeExtent) => "`--extent` was given, and no `--data-area auto|all|FILE`",
        Warning::Io(OddFiles::Raster(oddity)) => return of_raster(&oddity.odd).map(str::to_string),
        Warning::Io(OddFiles::File(_, odd)) => return of_file(odd),
        Warning::Run(OddRun::FlatEarth { .. }) => "over rasters `--earth-k 4/3` for radio, `7/6` for light",
        Warning::Run(OddRun::Results { .. }) => "`skyshed info` tells what it is",
        _ => return None,
    };
    Some(hint.to_string())
}

fn of_raster(odd: &OddRaster) -> Option<&'static str> {
    match odd {
        OddRaster::WebMercator => Some("resample it with `gdalwarp -t_srs EPSG:326NN`"),
        OddRaster::Unlikely(_) => Some("declare nodata with `gdal_edit.py -a_nodata VALUE` if they are none"),
        OddRaster::Gaps { .. } => Some("give it one with `gdalbuildvrt -vrtnodata -9999`"),
        _ => None,
    }
}

fn of_file(odd: &OddFile) -> Option<String> {
    let hint = match odd {
        OddFile::NoCrs => "`--crs EPSG:n`",
        OddFile::Voids { .. } => "`--nodata-as`",
        OddFile::SurfaceAlone => "give `--terrain FILE` or `--ground Z` to put them on the ground",
        OddFile::NotInMeters(_) => "`--radius` and `--cell` too",
        OddFile::ManyCells => "give `--radius` so that one map fits",
        OddFile::MissingHeights { left_out: Some(_), .. } => "`--missing levels|median|fail`",
        OddFile::OtherGround { median_m, .. } => {
            return Some(format!("`--terrain FILE`, or `--ground {}`, the median", tidy(*median_m)));
        }
        OddFile::FlatRoofs { .. } => "`--roofs lod2` takes them as they are, `--roofs flat` as now",
        OddFile::NoFace { is_known: false, .. } => "`--ground Z` or `--terrain FILE` fills them",
        _ => return None,
    };
    Some(hint.to_string())
}
