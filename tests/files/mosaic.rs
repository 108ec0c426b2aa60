//! Rasters made of many: folders of tiles and virtual rasters are the one raster that a brush, or GDAL, makes of them.

use std::path::Path;
use std::process::Command;

use skyshed_core::raster::CellWindow;
use skyshed_io::formats::RasterFile;
use skyshed_io::{Result, Warning};

use crate::masks::mask_of;
use crate::needs::has_program;
use crate::plain_tiff::{Cells, PlainTiff};
use crate::program::Folder;
use crate::support::{Random, is_long};

/// North-west corner of all mosaics.
pub(crate) const CORNER: (f64, f64) = (500_000.0, 5_400_000.0);
/// What has no height in tiles.
const NODATA: i32 = -9999;

/// A tile, and the row and column at which it begins in its mosaic.
struct Tile {
    name: String,
    row: i64,
    col: i64,
    tiff: PlainTiff,
}

/// The heights of a raster, NaN where it has none, and what was odd about it.
pub(crate) fn read(path: &Path) -> Result<(Vec<f64>, Vec<Warning>)> {
    let mut warnings = Vec::new();
    let file = RasterFile::open(path, &mut warnings)?;
    let raster = file.read(file.georef().window(), &mut warnings, |height| height)?;
    Ok((raster.into_cells().into_vec(), warnings))
}

pub(crate) fn codes(warnings: &[Warning]) -> Vec<String> {
    warnings.iter().map(Warning::code).collect()
}

/// Equal to the last bit, NaN to NaN.
pub(crate) fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()))
}

fn offset(cells: i64) -> f64 {
    f64::from(i32::try_from(cells).unwrap())
}

/// Heights of blocks of a city, with nodata cells and, where the type allows, fractions.
fn tile(random: &mut Random, k: usize, (row, col): (i64, i64), (n_rows, n_cols): (usize, usize)) -> Tile {
    let cells = random.choose(&[Cells::Int16, Cells::Float32]);
    let value = |random: &mut Random| {
        if random.chance(10) {
            return f64::from(NODATA);
        }
        let height = offset(random.within(-3, 40));
        if cells == Cells::Float32 { height + random.choose(&[0.0, 0.5, 0.25]) } else { height }
    };
    let values = (0..n_rows * n_cols).map(|_| value(random)).collect();
    let extension = random.choose(&["tif", "TIFF", "asc"]);
    let tiff = PlainTiff {
        corner: (CORNER.0 + 2.0 * offset(col), CORNER.1 - 2.0 * offset(row)),
        cell: 2.0,
        n_cols,
        n_rows,
        cells,
        values,
        nodata: random.choose(&[Some(NODATA), Some(NODATA), None]),
        rows_per_strip: random.index(1, n_rows),
        epsg: 25832,
    };
    Tile { name: format!("tile_{k:02}.{extension}"), row, col, tiff }
}

fn write(folder: &Folder, tile: &Tile) {
    let bytes = if tile.name.ends_with("asc") { tile.tiff.text().into_bytes() } else { tile.tiff.bytes() };
    std::fs::create_dir_all(folder.join(&tile.name).parent().unwrap()).unwrap();
    std::fs::write(folder.join(&tile.name), bytes).unwrap();
}

/// The cells of a mosaic: each tile paints those for which `paint` gives a number, in turn.
fn painted(
    (n_rows, n_cols): (usize, usize),
    ground: f64,
    tiles: &[Tile],
    paint: impl Fn(usize, &Tile, f64) -> Option<f64>,
) -> Vec<f64> {
    let mut canvas = vec![ground; n_rows * n_cols];
    for (k, tile) in tiles.iter().enumerate() {
        for (cell, value) in tile.tiff.values.iter().enumerate() {
            let row = tile.row + i64::try_from(cell / tile.tiff.n_cols).unwrap();
            let col = tile.col + i64::try_from(cell % tile.tiff.n_cols).unwrap();
            let (Ok(row), Ok(col)) = (usize::try_from(row), usize::try_from(col)) else { continue };
            if row < n_rows
                && col < n_cols
                && let Some(number) = paint(k, tile, *value)
            {
                canvas[row * n_cols + col] = number;
            }
        }
    }
    canvas
}

/// The one raster that a mosaic must equal; NaN is nodata, of another number, because tiles that declare none hold -9999.
fn whole(heights: &[f64], n_cols: usize) -> PlainTiff {
    const NONE: i32 = -32_000;
    let values = heights.iter().map(|h| if h.is_nan() { f64::from(NONE) } else { *h }).collect();
    PlainTiff { nodata: Some(NONE), ..PlainTiff::floats(CORNER, 2.0, n_cols, values) }
}

/// The mask of a map and its digest; `None` if the UAV is inside of something.
fn mapped(folder: &Folder, scene: &str, name: &str) -> Option<(Vec<u8>, serde_json::Value)> {
    // In the middle of 31 × 27 cells of 2 m, and off their centers.
    let line = format!("map {scene} --ground 0 --receivers all --uav 500031.3,5399972.9,60amsl -o {name}.tif --json");
    let answer = folder.type_in(&line);
    if answer.status.code() == Some(4) {
        return None;
    }
    let document = answer.done().json();
    Some((mask_of(folder, &format!("{name}.tif")), document["digest"].clone()))
}

/// What a program of GDAL says, run in a folder by a line without quotes.
pub(crate) fn gdal(folder: &Folder, line: &str) -> String {
    let mut words = line.split_whitespace();
    let mut program = Command::new(words.next().unwrap());
    let done = program.args(words).current_dir(folder.path()).output().unwrap();
    assert!(done.status.success(), "{line}: {done:?}");
    String::from_utf8_lossy(&done.stdout).into_owned()
}

#[test]
fn a_folder_of_tiles_is_one_raster() {
    let (n_rows, n_cols) = (27, 31);
    let mut n_differing_seen = 0;
    for seed in 0..if is_long() { 400 } else { 20 } {
        let mut random = Random(seed);
        let folder = Folder::new();
        // The first two hold opposite corners, so that the mosaic always has the same size.
        let mut tiles = vec![tile(&mut random, 0, (0, 0), (12, 14)), tile(&mut random, 1, (20, 22), (7, 9))];
        for k in 2..random.index(2, 6) {
            let at = (random.within(0, 17), random.within(0, 20));
            let shape = (random.index(1, 10), random.index(1, 11));
            tiles.push(tile(&mut random, k, at, shape));
        }
        tiles.iter_mut().for_each(|tile| tile.name = format!("city/{}", tile.name));
        tiles.iter().for_each(|tile| write(&folder, tile));
        folder.write("city/tile_00.txt", "no tile");
        folder.write("city/.hidden.tif", "no tile");
        std::fs::create_dir(folder.join("city/more.tif")).unwrap();
        let holds = |tile: &Tile, value: f64| {
            // An ASCII grid that declares nothing has -9999 all the same, a GeoTIFF has it for a height.
            let declares = tile.tiff.nodata.is_some() || tile.name.ends_with("asc");
            !(declares && value.to_bits() == f64::from(NODATA).to_bits())
        };
        let wanted = painted((n_rows, n_cols), f64::NAN, &tiles, |_, tile, v| holds(tile, v).then_some(v));
        let (heights, warnings) = read(&folder.join("city")).unwrap();
        assert!(same(&heights, &wanted), "seed {seed}: {:?}", tiles.iter().map(|t| &t.name).collect::<Vec<_>>());
        // Differences: each height laid over another one.
        let mut n_differing = 0;
        for k in 1..tiles.len() {
            let below = painted((n_rows, n_cols), f64::NAN, &tiles[..k], |_, t, v| holds(t, v).then_some(v));
            let above = painted((n_rows, n_cols), f64::NAN, &tiles[k..=k], |_, t, v| holds(t, v).then_some(v));
            let differ = |(a, b): (&f64, &f64)| !a.is_nan() && !b.is_nan() && a.to_bits() != b.to_bits();
            n_differing += below.iter().zip(&above).filter(|pair| differ(*pair)).count();
        }
        let told = warnings.iter().find(|w| w.code() == "W336").map(ToString::to_string);
        assert_eq!(told.is_some(), n_differing > 0, "seed {seed}");
        n_differing_seen += n_differing;
        assert!(told.is_none_or(|text| text.contains(&format!("differ: {n_differing} height"))), "seed {seed}");
        if seed % 10 == 0 {
            std::fs::write(folder.join("one.tif"), whole(&wanted, n_cols).bytes()).unwrap();
            let (found, wanted) = (mapped(&folder, "city", "a"), mapped(&folder, "one.tif", "b"));
            assert_eq!(found, wanted, "seed {seed}");
            let (mask, _) = found.unwrap();
            assert!(mask.contains(&0) && mask.contains(&1), "seed {seed}: {mask:?}");
        }
    }
    assert!(n_differing_seen > 100);
}

/// The source of a virtual raster: how it is told, and what it paints.
#[derive(Clone, Copy)]
enum Source {
    Simple,
    Complex { nodata: Option<i32>, ratio: f64, offset: f64 },
}

fn vrt_of(tiles: &[Tile], sources: &[Source], (n_rows, n_cols): (usize, usize), band: (&str, Option<i32>)) -> String {
    let (data_type, nodata) = band;
    let mut text = format!(
        "<VRTDataset rasterXSize=\"{n_cols}\" rasterYSize=\"{n_rows}\">\n<SRS>EPSG:25832</SRS>\n\
         <GeoTransform>{}, 2.0, 0.0, {}, 0.0, -2.0</GeoTransform>\n<VRTRasterBand dataType=\"{data_type}\" band=\"1\">\n",
        CORNER.0, CORNER.1
    );
    if let Some(nodata) = nodata {
        text += &format!("<NoDataValue>{nodata}</NoDataValue>\n");
    }
    for (tile, source) in tiles.iter().zip(sources) {
        let (cols, rows) = (tile.tiff.n_cols, tile.tiff.n_rows);
        let element = if matches!(source, Source::Simple) { "SimpleSource" } else { "ComplexSource" };
        text += &format!(
            "<{element}><SourceFilename relativeToVRT=\"1\">{}</SourceFilename><SourceBand>1</SourceBand>\n\
             <SrcRect xOff=\"0\" yOff=\"0\" xSize=\"{cols}\" ySize=\"{rows}\"/>\
             <DstRect xOff=\"{}\" yOff=\"{}\" xSize=\"{cols}\" ySize=\"{rows}\"/>",
            tile.name, tile.col, tile.row
        );
        if let Source::Complex { nodata, ratio, offset } = source {
            if let Some(nodata) = nodata {
                text += &format!("<NODATA>{nodata}</NODATA>");
            }
            text += &format!("<ScaleOffset>{offset}</ScaleOffset><ScaleRatio>{ratio}</ScaleRatio>");
        }
        text += &format!("</{element}>\n");
    }
    text + "</VRTRasterBand>\n</VRTDataset>\n"
}

/// A number as a band of 16-bit integers holds it.
fn int16(number: f64) -> f64 {
    let away = if number < 0.0 { (number - 0.5).ceil() } else { (number + 0.5).floor() };
    // A sum of -0 and 0 is 0: integers have one zero.
    away.clamp(-32768.0, 32767.0) + 0.0
}

#[test]
fn a_virtual_raster_is_what_its_sources_paint_and_what_gdal_makes_of_it() {
    let (n_rows, n_cols) = (27, 31);
    let with_gdal = has_program("gdal_translate");
    let mut n_mapped = 0;
    for seed in 0..if is_long() { 400 } else { 20 } {
        let mut random = Random(seed);
        let folder = Folder::new();
        let mut tiles = Vec::new();
        for k in 0..random.index(1, 7) {
            // Some reach beyond the raster on any side, or lie outside of it.
            let at = (random.within(-6, 28), random.within(-6, 32));
            let shape = (random.index(1, 14), random.index(1, 14));
            tiles.push(tile(&mut random, k, at, shape));
        }
        tiles.push(tile(&mut random, 9, (10, 11), (5, 6)));
        tiles.iter_mut().for_each(|tile| tile.name = format!("tiles/{}", tile.name));
        tiles.iter().for_each(|tile| write(&folder, tile));
        let source = |random: &mut Random| match random.below(3) {
            0 => Source::Simple,
            _ => Source::Complex {
                nodata: random.choose(&[Some(NODATA), Some(NODATA), Some(7), None]),
                ratio: random.choose(&[1.0, 1.0, 0.5, -2.0]),
                offset: random.choose(&[0.0, 0.0, 100.25]),
            },
        };
        let sources: Vec<Source> = tiles.iter().map(|_| source(&mut random)).collect();
        let data_type = random.choose(&["Float32", "Int16"]);
        let nodata = random.choose(&[Some(NODATA), Some(NODATA), None]);
        folder.write("city.vrt", &vrt_of(&tiles, &sources, (n_rows, n_cols), (data_type, nodata)));
        let of_band = |number: f64| if data_type == "Int16" { int16(number) } else { number };
        let paint = |k: usize, _: &Tile, value: f64| match sources[k] {
            Source::Simple => Some(of_band(value)),
            Source::Complex { nodata: Some(nodata), .. } if value.to_bits() == f64::from(nodata).to_bits() => None,
            // Halves and quarters: exact in 32 bits.
            Source::Complex { ratio, offset, .. } => Some(of_band(value * ratio + offset)),
        };
        let ground = nodata.map_or(0.0, f64::from);
        let mut wanted = painted((n_rows, n_cols), ground, &tiles, paint);
        if nodata.is_some() {
            wanted.iter_mut().filter(|v| v.to_bits() == f64::from(NODATA).to_bits()).for_each(|v| *v = f64::NAN);
        }
        if wanted.iter().all(|v| v.is_nan()) {
            continue;
        }
        let (heights, warnings) = read(&folder.join("city.vrt")).unwrap();
        assert!(same(&heights, &wanted), "seed {seed}: {}", folder.text("city.vrt"));
        let covered = painted((n_rows, n_cols), f64::NAN, &tiles, |_, _, _| Some(0.0));
        let n_gaps = covered.iter().filter(|v| v.is_nan()).count();
        assert_eq!(codes(&warnings).contains(&"W337".into()), nodata.is_none() && n_gaps > 0, "seed {seed}");
        let file = RasterFile::open(folder.join("city.vrt"), &mut Vec::new()).unwrap();
        let said = file.description();
        assert_eq!(said.contains("in no tile"), n_gaps > 0, "{said}");
        assert!(n_gaps == 0 || said.contains(&format!("{n_gaps} cell")), "{said}, wanted {n_gaps}");
        if with_gdal {
            gdal(&folder, "gdal_translate -q city.vrt one.tif");
            let of_gdal = read(&folder.join("one.tif")).unwrap().0;
            assert!(same(&of_gdal, &heights), "seed {seed}: GDAL makes another raster");
            if seed % 4 == 0 {
                let found = mapped(&folder, "city.vrt", "a");
                assert_eq!(found, mapped(&folder, "one.tif", "b"), "seed {seed}");
                n_mapped += usize::from(found.is_some());
            }
        }
    }
    assert!(n_mapped > 2 || !with_gdal, "{n_mapped} masks compared");
}

#[test]
fn what_gdalbuildvrt_makes_of_any_tiles_is_read_as_gdal_does() {
    if !has_program("gdalbuildvrt") {
        return;
    }
    for seed in 0..12 {
        let mut random = Random(900 + seed);
        let folder = Folder::new();
        let cells = random.choose(&["Int16", "Float32"]);
        for k in 0..5 {
            // The first one holds the window that is cut out below.
            let (at, shape) = match k {
                0 => ((0, 0), (12, 14)),
                _ => ((random.within(0, 15), random.within(0, 17)), (random.index(3, 12), random.index(3, 14))),
            };
            let mut made = tile(&mut random, k, at, shape);
            made.name = format!("plain_{k}.tif");
            made.tiff.nodata = Some(NODATA);
            write(&folder, &made);
            let options = random.choose(&[
                "-co COMPRESS=DEFLATE -co TILED=YES -co BLOCKXSIZE=16 -co BLOCKYSIZE=16",
                "-co COMPRESS=LZW -co PREDICTOR=2",
                "-co COMPRESS=ZSTD -co SPARSE_OK=TRUE",
                "",
            ]);
            gdal(&folder, &format!("gdal_translate -q -ot {cells} {options} plain_{k}.tif tile_{k}.tif"));
        }
        gdal(&folder, "gdalbuildvrt -q all.vrt tile_0.tif tile_1.tif tile_2.tif tile_3.tif tile_4.tif");
        // A virtual raster of a part of it, which cuts sources on all sides, and one in that.
        gdal(&folder, "gdal_translate -q -of VRT -srcwin 2 3 9 8 all.vrt part.vrt");
        gdal(&folder, "gdalbuildvrt -q inner.vrt part.vrt");
        for name in ["all.vrt", "part.vrt", "inner.vrt"] {
            gdal(&folder, &format!("gdal_translate -q {name} one.tif"));
            let (heights, warnings) = read(&folder.join(name)).unwrap();
            assert!(same(&heights, &read(&folder.join("one.tif")).unwrap().0), "seed {seed}, {name}");
            assert_eq!(codes(&warnings), [""; 0], "{name}");
            let georef = |name: &str| RasterFile::open(folder.join(name), &mut Vec::new()).unwrap().georef().clone();
            assert_eq!(georef(name), georef("one.tif"), "seed {seed}, {name}");
        }
    }
}

/// A mosaic of 3 × 3 tiles of 4 × 5 cells, each cell holding its number, as a folder and as a virtual raster.
pub(crate) fn nine_tiles() -> Folder {
    let folder = Folder::new();
    let mut tiles = Vec::new();
    for k in 0..9_u32 {
        let (row, col) = (4 * i64::from(k / 3), 5 * i64::from(k % 3));
        let value = |cell: usize| {
            offset((row + i64::try_from(cell / 5).unwrap()) * 15 + col) + offset(i64::try_from(cell % 5).unwrap())
        };
        let corner = (CORNER.0 + 2.0 * offset(col), CORNER.1 - 2.0 * offset(row));
        let tiff = PlainTiff::floats(corner, 2.0, 5, (0..20).map(value).collect());
        tiles.push(Tile { name: format!("nine/t{k}.tif"), row, col, tiff });
    }
    tiles.iter().for_each(|tile| write(&folder, tile));
    folder.write("nine.vrt", &vrt_of(&tiles, &[Source::Simple; 9], (12, 15), ("Float32", None)));
    folder
}

#[test]
fn a_window_costs_the_tiles_that_it_touches_in_any_number_of_threads() {
    let folder = nine_tiles();
    for name in ["nine", "nine.vrt"] {
        let file = RasterFile::open(folder.join(name), &mut Vec::new()).unwrap();
        std::thread::scope(|scope| {
            for seed in 0..4 {
                let file = &file;
                scope.spawn(move || {
                    let mut random = Random(seed);
                    for _ in 0..50 {
                        let (row, col) = (random.below(12), random.below(15));
                        let window = CellWindow {
                            row,
                            col,
                            n_rows: random.index(1, 12 - row),
                            n_cols: random.index(1, 15 - col),
                        };
                        let part = file.read(window, &mut Vec::new(), |v| v).unwrap();
                        assert_eq!(part.georef(), &file.georef().part(window));
                        for (k, v) in part.cells().iter().enumerate() {
                            let (row, col) = (window.row + k / window.n_cols, window.col + k % window.n_cols);
                            assert_eq!(v.to_bits(), f64::from(u32::try_from(row * 15 + col).unwrap()).to_bits());
                        }
                    }
                });
            }
        });
        // A tile that is gone matters only to windows that touch it: the middle one, rows 4 to 7, columns 5 to 9.
        std::fs::rename(folder.join("nine/t4.tif"), folder.join("gone")).unwrap();
        let left = CellWindow { row: 0, col: 0, n_rows: 12, n_cols: 5 };
        assert!(file.read(left, &mut Vec::new(), |v| v).is_ok());
        let error = file.read(CellWindow { n_cols: 6, ..left }, &mut Vec::new(), |v| v).unwrap_err();
        let text = error.to_string();
        assert_eq!(error.code(), "E301");
        assert!(text.contains("t4.tif") && text.contains(&format!("{name}`)")), "{text}");
        std::fs::rename(folder.join("gone"), folder.join("nine/t4.tif")).unwrap();
    }
}

#[test]
fn documents_name_the_mosaic_and_its_tiles() {
    let folder = nine_tiles();
    for (name, is_hashed) in [("nine", false), ("nine.vrt", true)] {
        let line = format!("map {name} --terrain {name} --uav 500011,5399989,500amsl --json");
        let sources = folder.type_in(&line).done().json()["scene"]["sources"].as_array().unwrap().clone();
        // The surface and its tiles, then the terrain and its tiles.
        assert_eq!(sources.len(), 20);
        assert_eq!((&sources[0]["path"], sources[0]["sha256"].is_string()), (&name.into(), is_hashed));
        assert_eq!(sources[5]["path"], "nine/t4.tif");
        let hash: String = {
            use sha2::Digest;
            sha2::Sha256::digest(folder.read("nine/t4.tif")).iter().map(|b| format!("{b:02x}")).collect()
        };
        assert_eq!(sources[5]["sha256"], hash.as_str());
    }
    // What would be a tile of the next run is not written.
    folder.refuses("map nine --uav 500011,5399989,500amsl -o nine/mask.tif", "E105", &["it would be a tile"]);
    folder.type_in("map nine --uav 500011,5399989,500amsl -o nine/mask.json -q").done();
}
