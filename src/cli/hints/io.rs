//! What to do about files that cannot be read, combined or written.

use std::path::{Path, PathBuf};

use skyshed_io::Error;
use skyshed_io::crs::utm_for;
use skyshed_io::error::{
    Cause, CombineError, CrsError, HeightOf, HeightsMissing, InputKind, Pair, PlacesIn, ReadError, ReadFault, Wanted,
    WriteFault,
};
use skyshed_io::export::Format;
use skyshed_io::read::METERS_PER_LEVEL;

use crate::quantity::tidy;

/// The remedy for an error about files, where one is known.
pub(super) fn hint(error: &Error) -> Option<String> {
    match error {
        Error::Core(error) => super::core::hint(error),
        Error::Within(error, _) => hint(error),
        Error::Read(error) => of_cause(error).or_else(|| of_fault(error)),
        Error::Combine(error) => Some(of_two(error)),
        Error::Crs(error) => of_crs(error),
        Error::Write(_, fault) => of_output(fault),
        _ => None,
    }
}

fn of_cause(ReadError { name, cause, .. }: &ReadError) -> Option<String> {
    let words = match cause {
        Cause::CutShort => "the file is cut short or damaged: fetch it again",
        Cause::DamagedHeader => "the header is damaged: fetch the file again",
        Cause::DamagedBlock => {
            "the file is damaged: fetch it again, or see what GDAL makes of it with `gdalinfo -checksum`"
        }
        Cause::MixedFiles => "copy its files again, all from one place",
        Cause::TooFewCells => "the file is cut short, or `ncols` and `nrows` are wrong",
        Cause::TooManyCells => "`ncols` and `nrows` may be wrong",
        Cause::DecimalCommas => "replace the decimal commas by points",
        Cause::OtherRaster => "convert a raster of another format with `gdal_translate IN OUT.tif`",
        Cause::FeatureALine => "for one feature a line, convert first: `ogr2ogr collection.geojson features.geojsonl`",
        Cause::StaleVrt => "make it again from the files as they are: `gdalbuildvrt`",
        Cause::ForGdal => {
            return Some(format!("let GDAL make one raster of it: `gdal_translate {name} OUT.tif`"));
        }
        Cause::SampleType => "rewrite it with `gdal_translate -ot Float32 IN OUT`",
        Cause::OneBit => "rewrite it with `gdal_translate -ot Byte IN OUT`",
        Cause::Compression => "rewrite it with `gdal_translate -co COMPRESS=DEFLATE IN OUT`",
        Cause::LargeBlock => "rewrite it with `gdal_translate -co TILED=YES -co COMPRESS=DEFLATE IN OUT`",
        Cause::ColorJpeg => "extract the band with `gdal_translate -b 1 -co COMPRESS=DEFLATE IN OUT`",
        Cause::NoPlace => "set its place with `gdal_edit.py -a_ullr ULX ULY LRX LRY FILE`",
        Cause::ControlPoints => "resample it with `gdalwarp IN OUT`",
        Cause::OtherGrid => {
            "`gdalbuildvrt ALL.vrt FILE …`, then `gdal_translate ALL.vrt ALL.tif`, brings them onto one grid"
        }
        Cause::FarTile => "is there a tile of another place in the folder?",
        Cause::Nodata => "look at the nodata value and the band with `gdalinfo -stats`",
        Cause::LargeCells => "give a smaller `--cell`",
        Cause::LargeRaster => {
            "read the part in range with `--radius M`, or cut one out with `gdal_translate -projwin \
             ULX ULY LRX LRY IN OUT`"
        }
        Cause::Multipatch => "give the buildings as CityJSON, or as a mesh in .obj or .ply",
        Cause::OpenDatabase => "close the program that has it open",
        Cause::NotBuilt => "convert it, for example with `ogr2ogr city.fgb city.gpkg`",
        _ => return None,
    };
    Some(words.to_string())
}

fn of_fault(ReadError { name, fault, .. }: &ReadError) -> Option<String> {
    let words = match fault {
        ReadFault::Missing => {
            return near_name(Path::new(name)).map(|near| format!("did you mean {}?", near.display()));
        }
        ReadFault::NoFile => "save it as a file first",
        ReadFault::NoSidecar(path, _) if path.to_lowercase().ends_with(".shx") => {
            let remedy = format!("`ogrinfo --config SHAPE_RESTORE_SHX YES {name}`");
            return Some(format!("copy it too, or make it anew: {remedy}"));
        }
        ReadFault::NoSidecar(..) => "a shapefile is .shp, .shx, .dbf and .prj together",
        ReadFault::Rows { of, some_are_good, .. } => return Some(with_skipping(of_places(*of), *some_are_good)),
        ReadFault::NoTable(layer) => {
            return Some(format!("write a view as a table: `ogr2ogr table.gpkg {name} {layer}`"));
        }
        ReadFault::Rotated(_) => "resample it with `gdalwarp IN OUT`, which makes it north-up",
        ReadFault::Nothing(Wanted::Extent) => "give `--extent W,S,E,N` or `--terrain FILE`",
        ReadFault::Nothing(Wanted::Tiles) => "folders in it are not looked into: name the one that holds the tiles",
        ReadFault::Nothing(Wanted::CityObjects) => {
            "a file of one object a line holds them further down: `cjseq collect`"
        }
        ReadFault::Nothing(Wanted::Faces) => "of a cloud of points make a raster first",
        ReadFault::HeightMissing(..) => "`--missing drop|levels|median`, or name the property with `--height-field`",
        ReadFault::HeightsMissing(missing) => return Some(of_missing(missing)),
        ReadFault::Crs(..) | ReadFault::CrsNotUnderstood(_) => "override it with `--crs EPSG:n`",
        ReadFault::CrsMember(_) => "say it with `--crs EPSG:n`",
        ReadFault::NoCrs => "say which it is: `--crs EPSG:n`",
        ReadFault::Degrees { kind, center, .. } => return Some(of_degrees(name, *kind, *center)),
        ReadFault::NoFaceInGrid(_) => "check `--extent`; a mesh with y up has to be turned first",
        ReadFault::NoHeightProperty { like_heights, like_storeys, others, .. } => {
            return Some(match (quoted(like_heights), quoted(like_storeys), quoted(others)) {
                (Some(found), ..) => {
                    format!("{found} may hold heights: `--height-field NAME`, or `--top-field NAME` above the datum")
                }
                (None, Some(found), _) => format!(
                    "{found} may count storeys: `--missing levels --levels-field NAME` takes {METERS_PER_LEVEL} m for each"
                ),
                (None, None, Some(others)) => format!("no property looks like a height; there are {others}"),
                (None, None, None) => {
                    "no feature has any property; heights come as a property of each footprint".into()
                }
            });
        }
        ReadFault::Layers(_) => "`--layer NAME` says which",
        ReadFault::HeightRange(HeightOf::Cell, _) => {
            "if it stands for nodata, declare it: `gdal_translate -a_nodata VALUE in.tif out.tif`"
        }
        ReadFault::NoSceneCrs(_) => {
            "give the scene's CRS with `--crs EPSG:n`, or sites as `x,y` in the scene's own coordinates"
        }
        ReadFault::Misplaced { is_degrees: true, some_are_good, .. } => {
            let words = "longitude comes first in GeoJSON, and the columns are `lon,lat`";
            return Some(with_skipping(words, *some_are_good));
        }
        ReadFault::OutsideScene(_) => "a file in projected coordinates names its CRS in a `crs` member",
        ReadFault::GridTooLarge(..) => "give `--extent W,S,E,N`, or a larger `--cell`",
        ReadFault::Tangle(..) => "mend or leave out the feature; is it one building?",
        _ => return None,
    };
    Some(words.to_string())
}

fn of_places(of: PlacesIn) -> &'static str {
    match of {
        PlacesIn::SiteTable => {
            "a table of sites has the columns `x,y,h` or `lon,lat,h`, and optionally `id`, `h_above`, separated by commas, \
             semicolons or tabs"
        }
        PlacesIn::SiteFeatures => "a site is a Point with the property `h`, and optionally `id`, `h_above`",
        PlacesIn::TrackTable => {
            "a track is a table with the columns `x,y` or `lon,lat`, separated by commas, semicolons or tabs"
        }
        PlacesIn::TrackHeights => "`track` walks at the height of `--rx-height` alone: leave heights out",
        PlacesIn::TrackFeatures => "a track is one LineString, or Points in their order",
    }
}

/// A remedy for bad rows, and the one that is left where others are good.
pub(super) fn with_skipping(hint: &str, some_are_good: bool) -> String {
    if some_are_good { format!("{hint}; a run with `--skip-bad` goes on without bad rows") } else { hint.to_string() }
}

/// What each policy would do about missing heights.
fn of_missing(missing: &HeightsMissing) -> String {
    let of_median = missing.median_m.map_or("has none to take".into(), |m| format!("gives them {} m", tidy(m)));
    format!(
        "`--missing drop` leaves them out, as if nothing stood there; `levels` gives {} of them 3 m a storey of `{}` and \
         leaves {} out; `median` {of_median}; or name another property with `--height-field`",
        missing.n_storeys,
        missing.levels_field,
        missing.n_missing - missing.n_storeys
    )
}

/// The command that brings a file out of degrees.
fn of_degrees(name: &str, kind: InputKind, (lon, lat): (f64, f64)) -> String {
    if !((-180.0..=360.0).contains(&lon) && (-90.0..=90.0).contains(&lat)) {
        return format!(
            "its middle, longitude {lon} and latitude {lat}, is not on Earth: is the coordinate system right?"
        );
    }
    let epsg = utm_for(lon, lat);
    let stem = Path::new(name).with_extension("").display().to_string();
    let name = shell_word(name);
    let command = match kind {
        InputKind::Raster => {
            format!("gdalwarp -t_srs EPSG:{epsg} -r near {name} {}", shell_word(&format!("{stem}_{epsg}.tif")))
        }
        InputKind::Vector => {
            format!("ogr2ogr -t_srs EPSG:{epsg} {} {name}", shell_word(&format!("{stem}_{epsg}.geojson")))
        }
    };
    format!("`--project auto`, or {command}")
}

fn of_two(error: &CombineError) -> String {
    match error {
        CombineError::TwoCrs { names: [a, b], crs: [a_crs, b_crs], pair } => match pair {
            Pair::FootprintsTerrain => format!("ogr2ogr -t_srs {b_crs} reprojected.geojson {a}"),
            Pair::SurfaceTerrain => format!("gdalwarp -t_srs {a_crs} {b} terrain_reprojected.tif"),
            Pair::Tiles => format!("gdalwarp -t_srs {a_crs} {b} tile_reprojected.tif"),
            Pair::WeightsScene => format!("gdalwarp -s_srs {a_crs} -t_srs {b_crs} {a} weights.tif"),
            _ => format!("make the map again from a scene in {a_crs}"),
        },
        CombineError::TwoDatums(_) => "bring one of them over with `gdalwarp -t_srs EPSG:HORIZONTAL+VERTICAL`; `--crs \
                                       EPSG:n` says that both are in one system, whatever they name"
            .to_string(),
        _ => "compare the extents and coordinate reference systems that `skyshed info` gives for both".to_string(),
    }
}

fn of_crs(error: &CrsError) -> Option<String> {
    let words = match error {
        CrsError::UnknownCode(_) => "give another EPSG code, or the definition as WKT or PROJ string",
        CrsError::Unreadable(..) => "wanted for example `EPSG:25832`, a WKT or a PROJ string",
        CrsError::NoWay { .. } => {
            "bring the files into one coordinate reference system, for example with gdalwarp or ogr2ogr"
        }
        _ => return None,
    };
    Some(words.to_string())
}

fn of_output(fault: &WriteFault) -> Option<String> {
    let words = match fault {
        WriteFault::NoExtension(allowed) | WriteFault::Extension(_, allowed) | WriteFault::NotThisFormat(allowed) => {
            return (!allowed.is_empty()).then(|| listed(allowed));
        }
        WriteFault::Needed => "give them different names",
        WriteFault::NoFile => "where a command offers `-o -`, that writes to standard output",
        WriteFault::Exists | WriteFault::ExistsMeanwhile => "`--overwrite` replaces it",
        WriteFault::OneLayer(..) => "choose one site and one layer, or write .tif",
        WriteFault::Without(_) => "add `los` to `--layers`, or write .tif",
        WriteFault::SetsBesideMeasures => "write `which` to a .tif of its own, or to .exr",
        WriteFault::SetsBesideCounts => "write each to a .tif of its own, or both to .exr",
        WriteFault::NoBoxes(..) => "write .geojson, or .xml for Mitsuba and Sionna RT",
        WriteFault::Scratch(_) => "choose a folder with more room: `--scratch FOLDER`",
        WriteFault::Corners => "choose larger cells or a smaller extent",
        _ => return None,
    };
    Some(words.to_string())
}

/// What may be written.
fn listed(allowed: &[Format]) -> String {
    let files: Vec<String> = allowed.iter().filter_map(|f| f.extension()).map(|e| format!(".{e}")).collect();
    let stream = if allowed.contains(&Format::Stdout) { ", and `-` for standard output" } else { "" };
    format!("wanted {}{stream}", files.join(" "))
}

/// Names in backticks, if there are any.
fn quoted(names: &[String]) -> Option<String> {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    (!names.is_empty()).then(|| quoted.join(", "))
}

/// A word that a POSIX shell reads back as `text`.
fn shell_word(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "/._-+:@%,=".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_string()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

/// The file whose name is most like that of a missing one in the same folder: few letters differ, or only the extension.
fn near_name(path: &Path) -> Option<PathBuf> {
    const MOST_FILES: usize = 10_000;
    const MOST_EDITS: usize = 2;
    let lower = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let wanted = lower(path);
    let edits = |other: &Path| match other.file_stem() == path.file_stem() {
        true => 1,
        false => edits_between(&wanted, &lower(other)),
    };
    let files =
        std::fs::read_dir(folder).ok()?.take(MOST_FILES).flatten().map(|entry| path.with_file_name(entry.file_name()));
    let near =
        files.map(|file| (edits(&file), file)).filter(|(n, _)| *n <= MOST_EDITS && 2 * n < wanted.chars().count());
    near.min().map(|(_, file)| file)
}

/// How many letters must be put in, left out or changed to make one word of another (Levenshtein).
fn edits_between(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (k, letter) in from.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = k + 1;
        for (j, other) in to.iter().enumerate() {
            let changed = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[to.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_counted() {
        for (from, to, n) in
            [("", "", 0), ("dsm.tif", "dsm.tif", 0), ("dem.tif", "dsm.tif", 1), ("ab", "ba", 2), ("abc", "", 3)]
        {
            assert_eq!((edits_between(from, to), edits_between(to, from)), (n, n), "{from} {to}");
        }
    }

    #[test]
    fn degrees_are_answered_with_the_command_that_helps() {
        assert_eq!(
            of_degrees("maps/old town.tif", InputKind::Raster, (9.18, 48.78)),
            "`--project auto`, or gdalwarp -t_srs EPSG:32632 -r near 'maps/old town.tif' 'maps/old town_32632.tif'"
        );
    }
}
