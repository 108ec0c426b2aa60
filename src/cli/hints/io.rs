//! Remedies for files that cannot be read, combined or written.

use std::path::{Path, PathBuf};

use skyshed_io::Error;
use skyshed_io::crs::utm_for;
use skyshed_io::error::{
    Cause, CombineError, CrsError, HeightOf, HeightsMissing, InputKind, Namer, Pair, PlacesIn, ReadError, ReadFault,
    Wanted, WriteFault,
};
use skyshed_io::export::Format;
use skyshed_io::read::METERS_PER_LEVEL;
use skyshed_io::{Conversion, is_remote};

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

fn of_cause(ReadError { name, cause, fault, .. }: &ReadError) -> Option<String> {
    let made = |command: &str, end: &str| format!("{command} {} {}", shell_word(name), shell_word(&beside(name, end)));
    Some(match cause {
        Cause::CutShort => "the file is cut short or damaged: fetch it again".into(),
        Cause::DamagedHeader => "the header is damaged: fetch the file again".into(),
        Cause::DamagedBlock => "the file is damaged: fetch it again".into(),
        Cause::MixedFiles => "copy its files again, all from one place".into(),
        Cause::TooFewCells => "the file is cut short, or `ncols` and `nrows` are wrong".into(),
        Cause::TooManyCells => "`ncols` and `nrows` may be wrong".into(),
        Cause::DecimalCommas => "replace the decimal commas by points".into(),
        Cause::Foreign(conversion) => return of_foreign(name, *conversion),
        Cause::StaleVrt => format!(
            "make it again from the files as they are: `gdalbuildvrt -overwrite -vrtnodata -9999 {} FILE …`",
            shell_word(name)
        ),
        Cause::ForGdal => format!("let GDAL make one raster of it: `{}`", made("gdal_translate", "_whole.tif")),
        Cause::SampleType => format!("rewrite it with `{}`", made("gdal_translate -ot Float32", "_float32.tif")),
        Cause::OneBit => format!("rewrite it with `{}`", made("gdal_translate -ot Byte", "_byte.tif")),
        Cause::Compression => {
            format!("rewrite it with `{}`", made("gdal_translate -co COMPRESS=DEFLATE", "_deflate.tif"))
        }
        Cause::LargeBlock => format!(
            "rewrite it with `{}`",
            made("gdal_translate -co TILED=YES -co COMPRESS=DEFLATE -co BIGTIFF=IF_SAFER", "_tiled.tif")
        ),
        Cause::ColorJpeg => {
            format!("extract the band with `{}`", made("gdal_translate -b 1 -co COMPRESS=DEFLATE", "_band1.tif"))
        }
        Cause::NoPlace => format!(
            "set its place: `{}`, the corners in the reference system",
            made("gdal_translate -a_ullr ULX ULY LRX LRY", "_placed.tif")
        ),
        Cause::ControlPoints => format!("resample it with `{}`", made(WARP, "_north_up.tif")),
        Cause::OtherGrid => {
            let (vrt, tif) = (shell_word(&beside(name, ".vrt")), shell_word(&beside(name, ".tif")));
            format!(
                "bring them onto one grid: `gdalbuildvrt -vrtnodata -9999 {vrt} FILE …`, then `gdal_translate {vrt} {tif}`"
            )
        }
        Cause::FarTile => "is there a tile of another place in the folder?".into(),
        Cause::Nodata => format!(
            "all cells hold the number that it declares as nodata; if they are heights, say so with `{}`",
            made("gdal_translate -a_nodata none", "_heights.tif")
        ),
        Cause::LargeCells => "give a smaller `--cell`".into(),
        Cause::LargeRaster => of_large_raster(name),
        Cause::PointCloud => "a cloud of points is read as LAS or LAZ; of other points make a raster first".into(),
        Cause::OpenDatabase => "close the program that has it open".into(),
        Cause::BesideScene => return of_other_file(name, fault),
        Cause::NotBuilt | Cause::GeneratedColumn => {
            let converted = shell_word(&beside(name, ".fgb"));
            format!("convert it, for example with `ogr2ogr {converted} {}`", shell_word(name))
        }
        _ => return None,
    })
}

/// The way from a format that is not read to one that is.
fn of_foreign(name: &str, conversion: Conversion) -> Option<String> {
    let file = shell_word(name);
    let made = |end: &str| shell_word(&beside(name, end));
    Some(match conversion {
        Conversion::None => return None,
        Conversion::GdalTranslate => {
            format!("if it holds heights, convert it with `gdal_translate {file} {}`", made("_geotiff.tif"))
        }
        Conversion::Ogr2Ogr => format!("convert it with `ogr2ogr {} {file}`", made(".fgb")),
        Conversion::Unpack(command) => format!("unpack it with `{command} {file}`"),
        Conversion::Fcb => format!("convert it with `fcb deser -i {file} -o {}`", made(".city.jsonl")),
        Conversion::Mesh => "export it as a mesh in .obj or .ply from the program that made it".into(),
        Conversion::Sibling(extension) => format!("name the file beside it that ends in .{extension}"),
        Conversion::Download => "fetch the file again: this is what a server said instead".into(),
    })
}

/// The remedy for a file of places or of an area, of which the options of a scene say nothing.
fn of_other_file(name: &str, fault: &ReadFault) -> Option<String> {
    let file = shell_word(name);
    match fault {
        ReadFault::Layers(layers) => {
            let (made, layer) = (shell_word(&beside(name, "_layer.geojson")), shell_word(layers.first()?));
            Some(format!("take one of them: `ogr2ogr {made} {file} {layer}`"))
        }
        ReadFault::Crs(..) | ReadFault::CrsMember(_) | ReadFault::CrsNotUnderstood(_) => {
            let made = shell_word(&beside(name, "_crs.geojson"));
            Some(format!("say which it is: `ogr2ogr -a_srs EPSG:n {made} {file}`"))
        }
        _ => None,
    }
}

/// Resamples a raster so that what it does not reach is no height of 0 m.
const WARP: &str = "gdalwarp -ot Float32 -dstnodata -9999";

/// Ways to read less of a raster that is too large.
pub(super) fn of_large_raster(name: &str) -> String {
    format!("{}; `map --radius M` reads the part in range alone", part_of_raster(name))
}

/// The command that makes a smaller raster of one that is too large.
pub(super) fn part_of_raster(name: &str) -> String {
    if Path::new(name).is_dir() {
        return "name a folder of fewer tiles".into();
    }
    let (whole, part) = (shell_word(name), shell_word(&beside(name, "_part.tif")));
    format!("cut a part out with `gdal_translate -projwin ULX ULY LRX LRY {whole} {part}`")
}

fn of_fault(ReadError { name, fault, .. }: &ReadError) -> Option<String> {
    Some(match fault {
        ReadFault::Missing => near_name(Path::new(name)).map(|near| format!("did you mean {}?", near.display()))?,
        ReadFault::NoFile => "save it as a file first".into(),
        ReadFault::NoSidecar(path, _) if path.to_lowercase().ends_with(".shx") => {
            let anew = format!("ogrinfo --config SHAPE_RESTORE_SHX YES {}", shell_word(name));
            format!("copy it too, or make it anew: `{anew}`")
        }
        ReadFault::NoSidecar(..) => "a shapefile is .shp, .shx, .dbf and .prj together".into(),
        ReadFault::Rows { of, some_are_good, .. } => with_skipping(of_places(*of), *some_are_good),
        ReadFault::NoTable(layer) => {
            let table = shell_word(&beside(name, "_table.gpkg"));
            format!("write a view as a table: `ogr2ogr {table} {} {}`", shell_word(name), shell_word(layer))
        }
        ReadFault::Rotated(_) => {
            let north_up = shell_word(&beside(name, "_north_up.tif"));
            format!("resample it with `{WARP} {} {north_up}`, which makes it north-up", shell_word(name))
        }
        ReadFault::Nothing(Wanted::Extent | Wanted::Building) => {
            "give `--extent W,S,E,N`, or a terrain with `--terrain FILE`".into()
        }
        ReadFault::Nothing(Wanted::Tiles) => {
            "folders in it are not looked into: name the one that holds the tiles".into()
        }
        ReadFault::Nothing(Wanted::CityObjects) => format!(
            "a file of one object a line holds them further down: `cjseq collect < {} > {}`",
            shell_word(name),
            shell_word(&beside(name, "_collected.city.json"))
        ),
        ReadFault::Nothing(Wanted::Faces) => "a cloud of points is read from .las or .laz".into(),
        ReadFault::Nothing(Wanted::Ground) => {
            "give it: `--ground Z`, or `--terrain FILE`; the highest last returns are then the surface".into()
        }
        ReadFault::Nothing(Wanted::PointsInExtent) => "check `--extent`: it has the units of the coordinates".into(),
        ReadFault::NoBaseProperty(_) => {
            "name the property with `--base-field NAME`, or give a ground by `--ground Z` or by `--terrain FILE`".into()
        }
        ReadFault::NoBases(_) => {
            "`--base-field NAME` names the property that holds it; `--ground Z` or `--terrain FILE` gives it".into()
        }
        ReadFault::HeightMissing(..) if is_held(name) => "`--missing drop`, or `--missing median`".into(),
        ReadFault::HeightMissing(..) => {
            "`--missing drop`, `--missing levels,median`, or name the property with `--height-field NAME`".into()
        }
        ReadFault::HeightsMissing(missing) => of_missing(name, missing),
        ReadFault::Crs(..) | ReadFault::CrsNotUnderstood(_) => "override it with `--crs EPSG:n`".into(),
        ReadFault::CrsMember(_) => "say it with `--crs EPSG:n`".into(),
        ReadFault::NoCrs => "say which it is: `--crs EPSG:n`".into(),
        ReadFault::Degrees { crs, kind, center } => of_degrees((name, crs), *kind, *center),
        ReadFault::LikeDegrees(_) => "`--crs EPSG:4326 --project auto` takes them for degrees".into(),
        ReadFault::WebMercator { named_by: Namer::Footprints, .. } => "`--project auto` brings it into UTM".into(),
        ReadFault::WebMercator { crs, named_by: Namer::Terrain } => {
            format!("`--crs {crs} --project auto` brings both into UTM")
        }
        ReadFault::NoFaceInGrid(_) => "check `--extent`; a mesh with y up has to be turned first".into(),
        ReadFault::NoHeightProperty { like_heights, like_storeys, others, has_bases, .. } => {
            of_properties([like_heights, like_storeys, others], *has_bases)
        }
        ReadFault::Layers(_) => "`--layer NAME` says which".into(),
        ReadFault::HeightRange(HeightOf::Cell, _) => format!(
            "if it stands for nodata, declare it: `gdal_translate -a_nodata VALUE {} {}`",
            shell_word(name),
            shell_word(&beside(name, "_nodata.tif"))
        ),
        ReadFault::NoSceneCrs(_) => {
            "give the scene's CRS with `--crs EPSG:n`, or sites as `x,y` in the scene's own coordinates".into()
        }
        ReadFault::Misplaced { is_degrees: true, some_are_good, .. } => {
            with_skipping("longitude comes first in GeoJSON, and the columns are `lon,lat`", *some_are_good)
        }
        ReadFault::OutsideScene(_) => "a file in projected coordinates names its CRS in a `crs` member".into(),
        ReadFault::GridTooLarge(..) => "give `--extent W,S,E,N`, or a larger `--cell`".into(),
        ReadFault::Tangle(..) => "mend or leave out the feature; is it one building?".into(),
        _ => return None,
    })
}

/// The remedy where no property is known to hold heights: properties like heights, like storeys, and others.
fn of_properties([like_heights, like_storeys, others]: [&[String]; 3], has_bases: bool) -> String {
    match (quoted(like_heights), quoted(like_storeys), quoted(others)) {
        (Some(found), ..) if has_bases => format!(
            "{found} may hold heights: `--top-field NAME` if above the datum, or `--height-field NAME` above the ground"
        ),
        (Some(found), ..) => {
            format!("{found} may hold heights: `--height-field NAME`, or `--top-field NAME` above the datum")
        }
        (None, Some(found), _) => format!(
            "{found} may count storeys: `--missing levels,9 --levels-field NAME` takes {METERS_PER_LEVEL} m for each, and 9 m where there are none"
        ),
        (None, None, Some(others)) => {
            format!("no property looks like a height; there are {others}; `--missing 9` gives each one 9 m")
        }
        (None, None, None) => {
            "no feature has any property; heights come as one of each footprint, or `--missing 9` gives each one 9 m"
                .into()
        }
    }
}

fn of_places(of: PlacesIn) -> &'static str {
    match of {
        PlacesIn::SiteTable => {
            "a table of sites has the columns `x,y,h` or `lon,lat,h`, and optionally `id`, `h_above`, separated by commas, \
             semicolons or tabs"
        }
        PlacesIn::SiteFeatures => "a site is a Point with the property `h`; it may have `id` and `h_above`, too",
        PlacesIn::TrackTable => {
            "a track is a table with the columns `x,y` or `lon,lat`, separated by commas, semicolons or tabs; a flight has \
             `x,y,h` or `x,y,h,t`"
        }
        PlacesIn::PathHeights => {
            "a flight has the columns `x,y,h`: heights such as 120 above the ground, 150amsl, 30roof"
        }
        PlacesIn::TrackFeatures => "a track is made of LineStrings, or of Points in their order",
        PlacesIn::Path => "a flight is a .csv, .geojson, .gpx, .kml, .plan or .waypoints file",
    }
}

/// A remedy for bad rows, and the one that is left where others are good.
pub(super) fn with_skipping(hint: &str, some_are_good: bool) -> String {
    if some_are_good { format!("{hint}; a run with `--skip-bad` goes on without bad rows") } else { hint.to_string() }
}

/// Returns the effect of each policy for missing heights.
fn of_missing(name: &str, missing: &HeightsMissing) -> String {
    let HeightsMissing { n_missing, n_storeys, median_m, rules, is_top, .. } = missing;
    let before = if rules.is_empty() { String::new() } else { format!("{rules},") };
    let mut ways = vec![format!("`--missing {before}drop` leaves them out, as if nothing stood there")];
    if *n_storeys > 0 {
        let rest = if median_m.is_some() { "median" } else { "drop" };
        ways.push(format!(
            "`--missing levels,{rest}` gives {n_storeys} of the {n_missing} {METERS_PER_LEVEL} m for each storey"
        ));
    }
    ways.push(match median_m {
        Some(m) => format!("`--missing {before}median` gives them {} m", tidy(*m)),
        None => format!("`--missing {before}9` gives them 9 m"),
    });
    match is_top {
        true => ways.push("or name another property with `--top-field NAME`".into()),
        false if is_held(name) => {}
        false => ways.push("or name another property with `--height-field NAME`".into()),
    }
    ways.join("; ")
}

/// Returns `true` for the name of buildings in memory, which have one property alone.
pub(super) fn is_held(name: &str) -> bool {
    !Path::new(name).exists() && !is_remote(Path::new(name))
}

/// The ways to bring a file out of degrees; what is held in memory no other program converts.
fn of_degrees((name, crs): (&str, &str), kind: InputKind, (lon, lat): (f64, f64)) -> String {
    if !((-360.0..=360.0).contains(&lon) && (-90.0..=90.0).contains(&lat)) {
        return format!(
            "its middle, longitude {} and latitude {}, is not on Earth: is the coordinate system right?",
            tidy(lon),
            tidy(lat)
        );
    }
    let extension = Path::new(name).extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if ["obj", "ply"].contains(&extension.as_str()) {
        return "a mesh has its coordinates in meters: name their system with `--crs EPSG:n`".into();
    }
    if kind == InputKind::PointCloud {
        return points_in_meters(name, utm_for(lon, lat));
    }
    // GDAL takes neither folders of tiles nor CityJSON.
    if !Path::new(name).is_file() || extension == "json" {
        return "`--project auto`".into();
    }
    let epsg = utm_for(lon, lat);
    // The file itself may name another system, or none.
    let from = if crs.starts_with("EPSG:") { format!("-s_srs {crs} ") } else { String::new() };
    let way = format!("{from}-t_srs EPSG:{epsg}");
    let command = match kind {
        InputKind::Raster => {
            let made = shell_word(&beside(name, &format!("_{epsg}.tif")));
            format!("{WARP} -r near {way} {} {made}", shell_word(name))
        }
        InputKind::Vector | InputKind::PointCloud => {
            // Tables of a GeoPackage stay several.
            let extension = if extension == "gpkg" { "gpkg" } else { "geojson" };
            let made = shell_word(&beside(name, &format!("_{epsg}.{extension}")));
            format!("ogr2ogr {way} {made} {}", shell_word(name))
        }
    };
    format!("`--project auto`, or `{command}`")
}

/// The command that brings a point cloud into meters.
fn points_in_meters(name: &str, epsg: u32) -> String {
    let (file, made) = (shell_word(name), shell_word(&beside(name, &format!("_{epsg}.laz"))));
    format!("`pdal translate {file} {made} -f reprojection --filters.reprojection.out_srs=EPSG:{epsg}`")
}

fn of_two(error: &CombineError) -> String {
    match error {
        CombineError::TwoCrs { names: [a, _], crs: [a_crs, b_crs], pair } => match pair {
            Pair::FootprintsTerrain | Pair::SurfaceTerrain => "`--project auto` takes both".into(),
            Pair::Tiles => {
                let folder = Path::new(a).parent().unwrap_or(Path::new("")).display().to_string();
                let made = shell_word(&(folder + "_one.tif"));
                format!("make one raster of all tiles: `{WARP} -t_srs {} FILE … {made}`", shell_word(a_crs))
            }
            Pair::WeightsScene => {
                let (from, to) = (shell_word(a_crs), shell_word(b_crs));
                let made = shell_word(&beside(a, "_reprojected.tif"));
                format!("`{WARP} -s_srs {from} -t_srs {to} {} {made}`", shell_word(a))
            }
            _ => format!("make the map again from a scene in {a_crs}"),
        },
        CombineError::TwoDatums(_) => "bring one of them over with `gdalwarp -t_srs EPSG:HORIZONTAL+VERTICAL IN OUT`; \
                                       `--crs EPSG:n` says that both are in one system, whatever they name"
            .to_string(),
        _ => "compare the extents and coordinate reference systems that `skyshed info` gives for both".to_string(),
    }
}

fn of_crs(error: &CrsError) -> Option<String> {
    let words = match error {
        CrsError::UnknownCode(_) => "give another EPSG code, or the definition as WKT or PROJ string",
        CrsError::Unreadable(..) => "wanted for example `EPSG:25832`, a WKT or a PROJ string",
        CrsError::NoWay { .. } => {
            "bring the files into one coordinate reference system, for example with `gdalwarp -t_srs EPSG:n IN OUT` or \
             `ogr2ogr -t_srs EPSG:n OUT IN`"
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
        WriteFault::Without(_) => "`--layers los` with the others behind it, or write .tif",
        WriteFault::SetsBesideMeasures => "write `which` to a .tif of its own, or to .exr",
        WriteFault::SetsBesideCounts => "write each to a .tif of its own, or both to .exr",
        WriteFault::NoBoxes(..) => "write .geojson, or .xml for Mitsuba and Sionna RT",
        WriteFault::Scratch(_) => "choose a folder with more room: `--scratch FOLDER`",
        WriteFault::Corners => "choose larger cells or a smaller extent",
        _ => return None,
    };
    Some(words.to_string())
}

/// Returns the formats that can be written.
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

/// A file beside another one: its name with another end.
pub(super) fn beside(name: &str, end: &str) -> String {
    Path::new(name).with_extension("").display().to_string() + end
}

/// A word that a POSIX shell reads back as `text`.
pub(super) fn shell_word(text: &str) -> String {
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

/// Returns the edit distance of two words (Levenshtein).
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
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("old town.tif");
        let name = file.display().to_string();
        let hint = || of_degrees((&name, "EPSG:4326"), InputKind::Raster, (9.18, 48.78));
        // Nothing can be done with a file that is held in memory alone.
        assert_eq!(hint(), "`--project auto`");
        std::fs::write(&file, "heights").expect("a file");
        let made = name.replace(".tif", "_32632.tif");
        let way = "-r near -s_srs EPSG:4326 -t_srs EPSG:32632";
        assert_eq!(hint(), format!("`--project auto`, or `{WARP} {way} '{name}' '{made}'`"));
    }
}
