//! Remedies for warnings: the words that follow a warning in parentheses.

use std::path::Path;

use skyshed_core::Warning as OddScene;
use skyshed_io::Warning as OddFiles;
use skyshed_io::error::{OddFile, OddRaster, Oddity};

use super::io::{beside, is_held, shell_word};
use crate::error::{OddRun, Warning, WarningRepr};
use crate::quantity::tidy;

/// The flag that a warning is about, or a remedy, where one is known.
pub(in crate::cli) fn of_warning(warning: &Warning) -> Option<String> {
    let hint = match warning.repr() {
        WarningRepr::Core(OddScene::UnknownGround { .. }) => "`--nodata-as block|clear`",
        WarningRepr::Core(OddScene::LittleOpenGround) | WarningRepr::Io(OddFiles::WholeExtent) => {
            "`--data-area all` says so, `--data-area FILE` limits it"
        }
        WarningRepr::Io(OddFiles::Raster(oddity)) => return of_raster(oddity),
        WarningRepr::Io(OddFiles::File(name, odd)) => return of_file(name, odd),
        WarningRepr::Run(OddRun::FlatEarth { is_choice: true, .. }) => {
            "`--earth-k 4/3` for radio, `--earth-k 7/6` for light"
        }
        WarningRepr::Run(OddRun::Results { .. }) => "`skyshed info` tells what it is",
        _ => return None,
    };
    Some(hint.to_string())
}

fn of_raster(Oddity { name, odd, .. }: &Oddity) -> Option<String> {
    match odd {
        // A mesh stays where it is.
        OddRaster::WebMercator { .. } if is_mesh(name) => None,
        OddRaster::WebMercator { utm_epsg, .. } => Some(format!("`--project EPSG:{utm_epsg}` brings it into UTM")),
        OddRaster::Bands { can_choose: true, .. }
        | OddRaster::Colors { can_choose: true, .. }
        | OddRaster::TileBands { can_choose: true, .. } => {
            Some("`--band N|NAME` reads another, `--band 1` says that it is the first".into())
        }
        OddRaster::Unlikely(_) => {
            let (file, made) = (shell_word(name), shell_word(&beside(name, "_nodata.tif")));
            Some(format!("if they are none, declare it: `gdal_translate -a_nodata VALUE {file} {made}`"))
        }
        OddRaster::Gaps { .. } => {
            Some(format!("give it one: `gdalbuildvrt -overwrite -vrtnodata -9999 {} FILE …`", shell_word(name)))
        }
        _ => None,
    }
}

fn is_mesh(name: &str) -> bool {
    let extension = Path::new(name).extension().unwrap_or_default().to_string_lossy().to_lowercase();
    ["obj", "ply"].contains(&extension.as_str())
}

fn of_file(name: &str, odd: &OddFile) -> Option<String> {
    let hint = match odd {
        OddFile::NoCrs => "`--crs EPSG:n`",
        OddFile::Voids { .. } => "`--nodata-as block|clear`",
        OddFile::SurfaceAlone => "give `--terrain FILE` or `--ground Z` to put them on the ground",
        OddFile::NotInMeters(_) => "`--radius` and `--cell` too",
        OddFile::ManyCells => "give `--radius` so that one map fits",
        OddFile::MissingHeights { asks_nothing: true, .. } if is_held(name) => "`--missing median`",
        OddFile::MissingHeights { asks_nothing: true, .. } => "`--missing levels,median`",
        OddFile::GroundOfBases { .. } => "`--ground Z` or `--terrain FILE` is another, `--ground buildings` a terrain",
        OddFile::Rests { .. } => "`--parts join` takes outlines as high as they are",
        OddFile::OtherGround { median_m, .. } => {
            return Some(format!("`--terrain FILE`, or `--ground {}`, the median", tidy(*median_m)));
        }
        OddFile::NorthFirst { .. } => "`--swap-axes` takes them in the other order",
        OddFile::FlatRoofs { .. } => "`--roofs lod2` takes them as they are, `--roofs flat` as now",
        OddFile::LargerCells { .. } => "`--cell 1` keeps them",
        OddFile::NoFace { is_known: false, .. } => "`--ground Z` or `--terrain FILE` fills them",
        _ => return None,
    };
    Some(hint.to_string())
}
