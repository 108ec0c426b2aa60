//! Raster files, good and bad: what each is read as, or the error that it must give.

use std::path::{Path, PathBuf};
use std::time::Instant;

use skyshed_core::ErrorClass;
use skyshed_core::raster::CellWindow;
use skyshed_io::formats::{AsciiGrid, GeoTiff, RasterFile, write_ascii_grid};
use skyshed_io::{Error, Warning};

use crate::plain_tiff::{Cells, PlainTiff};
use crate::program::Folder;
use crate::support::truth;

/// What a file is read as: its heights (NaN: void), and what was odd.
struct Read {
    heights: Vec<f64>,
    warnings: Vec<Warning>,
}

fn read(path: &Path) -> Result<Read, Error> {
    let mut warnings = Vec::new();
    let file = RasterFile::open(path, &mut warnings)?;
    let raster = file.read(file.georef().window(), &mut warnings, |height| height)?;
    Ok(Read { heights: raster.into_cells().into_vec(), warnings })
}

fn codes(warnings: &[Warning]) -> Vec<String> {
    warnings.iter().map(Warning::code).collect()
}

fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()))
}

#[test]
fn each_bad_raster_gets_the_answer_of_its_list() {
    let Some(folder) = truth().map(|folder| folder.join("bad")) else { return };
    let index = std::fs::read_to_string(folder.join("index.json")).expect("the list of bad files");
    let index: serde_json::Value = serde_json::from_str(&index).expect("a list in JSON");
    let good = read(&folder.join("good/dsm.tif")).expect("the good surface");
    assert!(good.warnings.is_empty(), "{:?}", good.warnings);
    let (mut n_files, mut n_same) = (0, 0);
    for entry in index.as_array().expect("a list") {
        let field = |name: &str| entry[name].as_str().unwrap_or_default();
        if field("kind") != "raster" {
            continue;
        }
        let (name, expect) = (field("file"), field("expect"));
        let path = folder.join(name);
        let start = Instant::now();
        let answer = read(&path);
        assert!(start.elapsed().as_secs_f64() < 5.0, "{name} took {:?}", start.elapsed());
        n_files += 1;
        // Compared with a surface only in a scene.
        if name.ends_with("terrain_above_dsm.tif") {
            assert!(answer.is_ok(), "{name}: {:?}", answer.err());
            continue;
        }
        match &answer {
            Ok(read) => {
                let may = expect.contains("accept") || expect == "no-crash";
                let warned = expect.contains("warn") && !read.warnings.is_empty();
                assert!(may || warned, "{name} was read with {:?}, wanted {expect}", read.warnings);
                if field("good_answer").contains("same result as good/dsm.tif") {
                    assert!(same(&read.heights, &good.heights), "{name} differs from good/dsm.tif");
                    n_same += 1;
                }
            }
            Err(error) => {
                let may = expect.contains("reject") || expect == "no-crash";
                assert!(may, "{name} was refused, wanted {expect}: {error}");
                assert!(matches!(error.class(), ErrorClass::File | ErrorClass::Limit), "{name}: {error}");
                let (text, file) = (error.to_string(), path.display().to_string());
                assert!(text.contains(&file), "{name}: the error names no path: {text}");
            }
        }
    }
    assert!(n_files >= 60, "{n_files} files");
    assert_eq!(n_same, 6, "files equal to good/dsm.tif");
}

#[test]
fn odd_rasters_are_read_as_what_they_mean() {
    let Some(folder) = truth().map(|folder| folder.join("bad")) else { return };
    let good = read(&folder.join("good/dsm.tif")).expect("the good surface").heights;
    let odd = |name: &str| read(&folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let voids = |heights: &[f64]| heights.iter().filter(|h| h.is_nan()).count();
    // (file, void cells, warnings)
    let cases: [(&str, usize, &[&str]); 9] = [
        ("raster/nan_patch.tif", 16, &["W320"]),
        ("raster/nodata_tag_nan.tif", 16, &[]),
        ("raster/nodata_-3.4e38.tif", 16, &[]),
        ("raster/internal_mask.tif", 16, &[]),
        ("raster/nodata_tag_garbage.tif", 0, &["W322"]),
        ("raster/no_crs.tif", 0, &["W325"]),
        ("raster/ifd_loop.tif", 0, &["W329"]),
        ("raster/enc_lerc.tif", 0, &[]),
        ("raster/epsg3857_webmercator.tif", 0, &["W331"]),
    ];
    for (name, n_voids, expected) in cases {
        let read = odd(name);
        assert_eq!(voids(&read.heights), n_voids, "{name}");
        assert_eq!(codes(&read.warnings), expected, "{name}: {:?}", read.warnings);
        let differ = read.heights.iter().zip(&good).filter(|(a, b)| !a.is_nan() && a.to_bits() != b.to_bits()).count();
        assert_eq!(differ, 0, "{name}: cells that are not void are those of good/dsm.tif");
    }
    let minwhite = odd("raster_upstream/gdal_float32_minwhite.tif").heights;
    assert!(same(&minwhite, &[0.576_358_497_142_791_7]), "MinIsWhite turns no height over: {minwhite:?}");
    // (file, code, part of the text)
    let cases = [
        ("raster/text.tif", "E302", "line 3: `this` is no key of the header"),
        ("raster/header_only_6b.tif", "E303", "6 bytes"),
        ("raster/zero_width.tif", "E302", "width `0`"),
        ("raster/huge_dims_2e31.tif", "E303", "2147483647 columns x 65535 rows need 2048 strips"),
        ("raster/truncated_half.tif", "E303", "ends beyond the file of 8376 bytes"),
        ("raster/strip_offsets_past_eof.tif", "E303", "ends beyond the file"),
        ("raster/strip_offsets_zero.tif", "E305", "none of the 4096 cells"),
        ("raster/bits_per_sample_17.tif", "E304", "17-bit floating-point"),
        ("raster/compression_unknown_999.tif", "E304", "unsupported compression `999`"),
        ("raster/complex64.tif", "E304", "64-bit complex"),
        ("raster/all_nodata.tif", "E305", "none of the 4096 cells"),
        ("raster/rotated.tif", "E306", "-15.0 degrees off east"),
        ("raster/sparse_200000x200000.tif", "E501", "need 298.0 GiB of memory"),
        ("raster_upstream/gdal_oddsize1bit.tif", "E304", "1-bit"),
        ("raster_upstream/gdal_byte_truncated.tif", "E303", "ends beyond the file"),
    ];
    for (name, code, part) in cases {
        let error = read(&folder.join(name)).err().unwrap_or_else(|| panic!("{name} was read"));
        assert_eq!(error.code(), code, "{name}: {error}");
        assert!(error.to_string().contains(part), "{name}: {error}");
    }
}

#[test]
fn a_window_of_a_raster_is_the_same_as_the_part_of_the_whole() {
    let Some(folder) = truth().map(|folder| folder.join("bad/raster")) else { return };
    for name in ["enc_lzw_pred2_int16.tif", "cog_overviews.tif", "internal_mask.tif", "enc_bigtiff.tif"] {
        let mut warnings = Vec::new();
        let file = GeoTiff::open(folder.join(name), &mut warnings).expect(name);
        let whole = file.read(file.georef().window(), &mut warnings, |h| h).expect(name);
        for window in [
            CellWindow { row: 0, col: 0, n_rows: 1, n_cols: 1 },
            CellWindow { row: 29, col: 5, n_rows: 7, n_cols: 50 },
            CellWindow { row: 63, col: 63, n_rows: 1, n_cols: 1 },
        ] {
            let part = file.read(window, &mut warnings, |h| h).expect(name);
            assert_eq!(part.georef(), &file.georef().part(window));
            for row in 0..window.n_rows {
                let expected = &whole.row(window.row + row)[window.col..window.col + window.n_cols];
                assert!(same(part.row(row), expected), "{name}, {window:?}, row {row}");
            }
        }
    }
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = read(Path::new("no/such/file.tif")).err().expect("there is no such file");
    assert_eq!(error.to_string(), "cannot read no/such/file.tif: no such file");
    assert_eq!(error.code(), "E301");
    let error = read(Path::new(env!("CARGO_MANIFEST_DIR"))).err().expect("it holds no raster");
    assert!(error.to_string().ends_with("a folder without .tif, .tiff or .asc files, wanted tiles"), "{error}");
}

/// A file in a folder of its own, gone when dropped.
struct Scratch {
    folder: PathBuf,
}

impl Scratch {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("skyshed-formats-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a scratch folder");
        Scratch { folder }
    }

    fn file(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.folder.join(name);
        std::fs::write(&path, text).expect("a scratch file");
        path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

const HEADER: &str = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 2\nNODATA_value -9999\n";

#[test]
fn an_ascii_grid_is_read_in_all_its_spellings() {
    let scratch = Scratch::new("good-asc");
    let cells = "1 2 3\n4 -9999 6\n";
    let expected = [1.0, 2.0, 3.0, 4.0, f64::NAN, 6.0];
    let spellings = [
        format!("{HEADER}{cells}"),
        format!("{}{cells}", HEADER.to_uppercase().replace('\n', "\r\n")),
        format!("\u{feff}\n\n  {HEADER}{cells}"),
        format!("cellsize 2\nnodata_value -9999.0\nNROWS 2\nNCols 3\nyllcenter 201\nXLLCENTER 101\n{cells}"),
        format!("{HEADER}1 2\n3 4 -9999\n\t6"),
        format!("{}{cells}", HEADER.replace("cellsize 2", "dx 2\ndy 2")),
        format!("{}{cells}", HEADER.replace("NODATA_value -9999\n", "")),
        format!("{}1 2 3 4 -3.402823e+38 6", HEADER.replace("-9999", "-3.4028230e38")),
        format!("{HEADER}1.0 2e0 +3 0.4e1 -9999.000 6."),
    ];
    for text in &spellings {
        let path = scratch.file("grid.asc", text);
        let mut warnings = Vec::new();
        let grid = AsciiGrid::open(&path, &mut warnings).unwrap_or_else(|e| panic!("{text}: {e}"));
        let georef = grid.georef();
        assert_eq!((georef.x_min(), georef.y_min()), (100.0, 200.0), "{text}");
        assert_eq!((georef.cell_width(), georef.cell_height()), (2.0, 2.0), "{text}");
        let raster = grid.read(georef.window(), &mut warnings, |h| h).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert!(same(raster.cells(), &expected), "{text}: {:?}", raster.cells());
        assert_eq!(codes(&warnings), ["W325"], "{text}");
        let window = CellWindow { row: 1, col: 2, n_rows: 1, n_cols: 1 };
        let part = grid.read(window, &mut warnings, |h| h).expect("a part of the grid");
        assert!(same(part.cells(), &[6.0]), "{text}");
        assert_eq!((part.georef().x_min(), part.georef().y_max()), (104.0, 202.0), "{text}");
    }
}

#[test]
fn an_ascii_grid_takes_its_crs_from_the_file_beside_it() {
    let scratch = Scratch::new("prj");
    let path = scratch.file("grid.asc", format!("{HEADER}1 2 3 4 5 6"));
    scratch.file("grid.prj", "EPSG:25832");
    let mut warnings = Vec::new();
    let grid = AsciiGrid::open(&path, &mut warnings).expect("a good grid");
    assert_eq!(grid.georef().crs().and_then(|crs| crs.epsg()), Some(25832));
    assert!(warnings.is_empty(), "{warnings:?}");
    scratch.file("grid.prj", "no such thing");
    let grid = AsciiGrid::open(&path, &mut warnings).expect("a grid without a CRS");
    assert!(grid.georef().crs().is_none());
    assert_eq!(codes(&warnings), ["W326", "W325"]);
}

#[test]
fn each_bad_ascii_grid_is_refused_with_its_line() {
    let scratch = Scratch::new("bad-asc");
    let cells = "1 2 3\n4 5 6\n";
    let with = |from: &str, to: &str| format!("{}{cells}", HEADER.replace(from, to));
    let cases: [(String, &str, &str); 20] = [
        (with("cellsize 2", "cellsize -2"), "E302", "line 5: `cellsize` is `-2`, must be above 0"),
        (
            with("cellsize 2", "cellsize 0,5"),
            "E302",
            "line 5: `cellsize` is `0,5`, wanted a number with a decimal point",
        ),
        (with("cellsize 2", "cellsize inf"), "E302", "line 5: `cellsize` is `inf`, must be above 0"),
        (with("cellsize 2\n", ""), "E302", "the header ends without `cellsize`, or `dx` and `dy`"),
        (with("cellsize 2", "dx 2"), "E302", "the header ends without `cellsize`, or `dx` and `dy`"),
        (with("ncols 3", "ncols 3.5"), "E302", "line 1: `ncols` is `3.5`, wanted a whole number above 0"),
        (with("ncols 3", "ncols 0"), "E302", "line 1: `ncols` is `0`, wanted a whole number above 0"),
        (with("ncols 3", "ncols -3"), "E302", "line 1: `ncols` is `-3`, wanted a whole number above 0"),
        (with("nrows 2", "nrows 2\nnrows 2"), "E302", "line 3: `nrows` is given twice"),
        (with("nrows 2", "rows 2"), "E302", "line 2: `rows` is no key of the header"),
        (with("xllcorner 100", "xllcorner nan"), "E302", "line 3: `xllcorner` is `nan`, wanted a finite number"),
        (with("xllcorner 100", "xllcorner 100\nxllcenter 101"), "E302", "both `xllcorner` and `xllcenter`"),
        (
            with("ncols 3", "ncols 2000000000"),
            "E303",
            "12 bytes follow its header, too few for 2000000000 columns x 2 rows",
        ),
        (with("ncols 3", "ncols 99999999999999999999"), "E302", "wanted a whole number above 0"),
        (format!("{HEADER}1 2 3\n4 5\n         "), "E303", "line 8: the file ends after 5 values, wanted 6"),
        (format!("{HEADER}1 2 3\n4 5 6\n7\n"), "E302", "line 9: `7` follows the last of 6 values"),
        (format!("{HEADER}1 2 3\n4 5,5 6\n"), "E302", "line 8: `5,5` is no number"),
        (format!("{HEADER}1 2 3\n4 oops 6\n"), "E302", "line 8: `oops` is no number"),
        (format!("{HEADER}nan -9999 inf\n-9999 -9999 -9999\n"), "E305", "none of the 6 cells read holds a height"),
        ("ncols 3\nnrows".to_owned(), "E303", "the file ends after `nrows`, wanted its value"),
    ];
    for (text, code, part) in cases {
        let path = scratch.file("bad.asc", &text);
        let error = read(&path).err().unwrap_or_else(|| panic!("this was read:\n{text}"));
        assert_eq!(error.code(), code, "{error}");
        assert!(error.to_string().contains(part), "wanted `{part}`, found `{error}`");
        assert!(error.to_string().contains(&path.display().to_string()), "{error}");
    }
    let commas = scratch.file("commas.asc", format!("{HEADER}1 2 3\n4 5,5 6\n"));
    let error = read(&commas).err().expect("decimal commas are refused");
    let Error::Read(error) = error else { panic!("{error}") };
    assert_eq!(error.cause, skyshed_io::error::Cause::DecimalCommas);
}

#[test]
fn odd_cells_of_an_ascii_grid_are_void_with_a_warning() {
    let scratch = Scratch::new("odd-asc");
    let read =
        read(&scratch.file("grid.asc", format!("{HEADER}NaN 2 inf\n-Infinity 5 -32768\n"))).expect("some heights");
    assert!(same(&read.heights, &[f64::NAN, 2.0, f64::NAN, f64::NAN, 5.0, -32768.0]), "{:?}", read.heights);
    assert_eq!(codes(&read.warnings), ["W325", "W320", "W320", "W328"]);
    let text = read.warnings[2].to_string();
    assert!(text.contains("2 cells with an infinite height (rows 0 to 1, columns 0 to 2)"), "{text}");
}

#[test]
fn a_written_ascii_grid_reads_back_bit_for_bit() {
    let scratch = Scratch::new("round-trip");
    let path = scratch.file("grid.asc", format!("{}0 0 0 0 0 0", HEADER.replace("cellsize 2", "dx 2\ndy 0.1")));
    let georef = AsciiGrid::open(&path, &mut Vec::new()).expect("a good grid").georef().clone();
    let heights = [0.1, -2.5e-300, f64::NAN, 8848.86, f64::from(0.1f32), 1.0 / 3.0];
    let mut out = Vec::new();
    write_ascii_grid(&mut out, &georef, -9999.0, heights.into_iter(), None).expect("memory");
    let read = read(&scratch.file("grid.asc", out)).expect("what was written");
    assert!(same(&read.heights, &heights), "{:?}", read.heights);
    let georef_again = AsciiGrid::open(&path, &mut Vec::new()).expect("what was written").georef().clone();
    assert!(georef_again.same_grid(&georef));
}

/// Strips that follow each other are read together; those that lie anywhere else, one by one.
#[test]
fn plain_strips_are_read_wherever_they_lie() {
    let folder = Folder::new();
    let values: Vec<f64> = (0..40 * 11).map(|k| f64::from(k * 37 % 1000) / 8.0).collect();
    let (n_cols, n_rows) = (11, 40);
    let tiff = PlainTiff {
        corner: (691_000.0, 5_334_000.0),
        cell: 1.0,
        n_cols,
        n_rows,
        cells: Cells::Float32,
        values: values.clone(),
        nodata: None,
        rows_per_strip: 3,
        epsg: 25832,
    };
    let (in_order, strip) = (tiff.bytes(), 3 * 11 * 4);
    let offsets: Vec<u8> = (0..14_u32).flat_map(|k| (8 + k * 132).to_le_bytes()).collect();
    let table = in_order.windows(offsets.len()).position(|bytes| bytes == offsets).expect("the offsets of strips");
    // Whole strips change places: neighbors, and some that lie far apart.
    for swaps in [&[][..], &[(0, 1)], &[(2, 9), (3, 4)], &[(0, 12), (1, 11), (2, 10), (5, 6)]] {
        let mut bytes = in_order.clone();
        for (a, b) in swaps {
            for k in 0..strip {
                bytes.swap(8 + a * strip + k, 8 + b * strip + k);
            }
            for k in 0..4 {
                bytes.swap(table + 4 * a + k, table + 4 * b + k);
            }
        }
        let path = folder.join("strips.tif");
        std::fs::write(&path, bytes).unwrap();
        let file = GeoTiff::open(&path, &mut Vec::new()).expect("a GeoTIFF");
        let (raster, n_void) = file.read_plain_heights(&mut Vec::new()).expect("heights").expect("stored plainly");
        let found: Vec<f64> = raster.cells().iter().map(|steps| f64::from(*steps) / 1024.0).collect();
        assert!(same(&found, &values) && n_void == 0, "{swaps:?}");
    }
}
