//! Raster files, good and bad: what each is read as, or the error that it must give.

use std::fmt::Write as _;

use serde_json::Value;
use skyshed_core::quantity::{VOID, height_steps};
use skyshed_core::raster::{CellWindow, GeoRef};
use skyshed_io::Error;
use skyshed_io::error::Cause;
use skyshed_io::formats::{AsciiGrid, Bands, GeoTiff, GeoTiffImage, encode_geotiff, write_ascii_grid};
use skyshed_request::TiffLayout;

use crate::mosaic::{codes, read, same};
use crate::needs::truth;
use crate::plain_tiff::PlainTiff;
use crate::program::Folder;

// What becomes of each file of the list is tested by `bad_inputs`.
#[test]
fn odd_rasters_are_read_as_what_they_mean() {
    let Some(folder) = truth().map(|folder| folder.join("bad")) else { return };
    let (good, warnings) = read(&folder.join("good/dsm.tif")).expect("the good surface");
    assert_eq!(codes(&warnings), [""; 0]);
    // (file, void cells, warnings)
    let cases: [(&str, usize, &[&str]); 15] = [
        ("int16.tif", 0, &[]),
        ("uint8.tif", 0, &[]),
        ("float64.tif", 0, &[]),
        ("enc_lzw_pred2_int16.tif", 0, &[]),
        ("enc_packbits.tif", 0, &[]),
        ("enc_bigtiff.tif", 0, &[]),
        ("enc_lerc.tif", 0, &[]),
        ("nan_patch.tif", 16, &["W320"]),
        ("nodata_tag_nan.tif", 16, &[]),
        ("nodata_-3.4e38.tif", 16, &[]),
        ("internal_mask.tif", 16, &[]),
        ("nodata_tag_garbage.tif", 0, &["W322"]),
        ("no_crs.tif", 0, &["W325"]),
        ("ifd_loop.tif", 0, &["W329"]),
        ("epsg3857_webmercator.tif", 0, &["W331"]),
    ];
    for (name, n_void, expected) in cases {
        let (heights, warnings) = read(&folder.join("raster").join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(heights.iter().filter(|h| h.is_nan()).count(), n_void, "{name}");
        assert_eq!(codes(&warnings), expected, "{name}: {warnings:?}");
        let differ = |(a, b): &(&f64, &f64)| !a.is_nan() && a.to_bits() != b.to_bits();
        let n_differing = heights.iter().zip(&good).filter(differ).count();
        assert_eq!((heights.len(), n_differing), (good.len(), 0), "{name}: what is not void is good/dsm.tif");
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

const HEADER: &str = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 2\nNODATA_value -9999\n";

#[test]
fn an_ascii_grid_is_read_in_all_its_spellings() {
    let folder = Folder::new();
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
        folder.write("grid.asc", text);
        let mut warnings = Vec::new();
        let grid = AsciiGrid::open(folder.join("grid.asc"), &mut warnings).unwrap_or_else(|e| panic!("{text}: {e}"));
        let georef = grid.georef();
        assert_eq!((georef.x_min(), georef.y_min()), (100.0, 200.0), "{text}");
        assert_eq!((georef.cell_width(), georef.cell_height()), (2.0, 2.0), "{text}");
        let raster = grid.read(georef.window(), &mut warnings, |h| h).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert!(same(raster.cells(), &expected), "{text}: {:?}", raster.cells());
        assert_eq!(codes(&warnings), ["W325"], "{text}");
        let window = CellWindow { row: 1, col: 2, n_rows: 1, n_cols: 1 };
        let part = grid.read(window, &mut warnings, |h| h).unwrap();
        assert!(same(part.cells(), &[6.0]), "{text}");
        assert_eq!((part.georef().x_min(), part.georef().y_max()), (104.0, 202.0), "{text}");
    }
}

#[test]
fn an_ascii_grid_takes_its_crs_from_the_file_beside_it() {
    let folder = Folder::new();
    folder.write("grid.asc", &format!("{HEADER}1 2 3 4 5 6"));
    for (text, epsg, expected) in [("EPSG:25832", Some(25832), &[][..]), ("no such thing", None, &["W326", "W325"])] {
        folder.write("grid.prj", text);
        let mut warnings = Vec::new();
        let grid = AsciiGrid::open(folder.join("grid.asc"), &mut warnings).unwrap();
        assert_eq!(grid.georef().crs().and_then(|crs| crs.epsg()), epsg);
        assert_eq!(codes(&warnings), expected);
    }
}

#[test]
fn each_bad_ascii_grid_is_refused_with_its_line() {
    let folder = Folder::new();
    let with = |from: &str, to: &str| format!("{}1 2 3\n4 5 6\n", HEADER.replace(from, to));
    let cells = |cells: &str| format!("{HEADER}{cells}");
    // (text, code, where and what)
    let cases: [(String, &str, &str); 20] = [
        (with("cellsize 2", "cellsize -2"), "E302", "line 5: `cellsize` is `-2`"),
        (with("cellsize 2", "cellsize 0,5"), "E302", "line 5: `cellsize` is `0,5`"),
        (with("cellsize 2", "cellsize inf"), "E302", "line 5: `cellsize` is `inf`"),
        (with("cellsize 2\n", ""), "E302", "without `cellsize`, or `dx` and `dy`"),
        (with("cellsize 2", "dx 2"), "E302", "without `cellsize`, or `dx` and `dy`"),
        (with("ncols 3", "ncols 3.5"), "E302", "line 1: `ncols` is `3.5`"),
        (with("ncols 3", "ncols 0"), "E302", "line 1: `ncols` is `0`"),
        (with("ncols 3", "ncols -3"), "E302", "line 1: `ncols` is `-3`"),
        (with("nrows 2", "nrows 2\nnrows 2"), "E302", "line 3: `nrows`"),
        (with("nrows 2", "rows 2"), "E302", "line 2: `rows`"),
        (with("xllcorner 100", "xllcorner nan"), "E302", "line 3: `xllcorner` is `nan`"),
        (with("xllcorner 100", "xllcorner 100\nxllcenter 101"), "E302", "`xllcorner` and `xllcenter`"),
        (with("ncols 3", "ncols 2000000000"), "E303", "12 bytes"),
        (with("ncols 3", "ncols 99999999999999999999"), "E302", "line 1"),
        (cells("1 2 3\n4 5\n         "), "E303", "line 8: the file ends after 5 values"),
        (cells("1 2 3\n4 5 6\n7\n"), "E302", "line 9: `7`"),
        (cells("1 2 3\n4 5,5 6\n"), "E302", "line 8: `5,5`"),
        (cells("1 2 3\n4 oops 6\n"), "E302", "line 8: `oops`"),
        (cells("nan -9999 inf\n-9999 -9999 -9999\n"), "E305", "none of the 6 cells"),
        ("ncols 3\nnrows".to_owned(), "E303", "`nrows`"),
    ];
    for (text, code, part) in cases {
        folder.write("bad.asc", &text);
        let error = read(&folder.join("bad.asc")).err().unwrap_or_else(|| panic!("this was read:\n{text}"));
        assert_eq!(error.code(), code, "{error}");
        let said = error.to_string();
        assert!(said.contains(part) && said.contains(&folder.word("bad.asc")), "wanted `{part}`, found `{said}`");
        if part.contains("`5,5`") {
            let Error::Read(error) = error else { panic!("{error}") };
            assert_eq!(error.cause, Cause::DecimalCommas);
        }
    }
}

#[test]
fn odd_cells_of_an_ascii_grid_are_void_with_a_warning() {
    let folder = Folder::new();
    folder.write("grid.asc", &format!("{HEADER}NaN 2 inf\n-Infinity 5 -32768\n"));
    let (heights, warnings) = read(&folder.join("grid.asc")).unwrap();
    assert!(same(&heights, &[f64::NAN, 2.0, f64::NAN, f64::NAN, 5.0, -32768.0]), "{heights:?}");
    assert_eq!(codes(&warnings), ["W325", "W320", "W320", "W328"]);
    let text = warnings[2].to_string();
    assert!(text.contains("2 cells") && text.contains("(rows 0 to 1, columns 0 to 2)"), "{text}");
}

#[test]
fn a_written_ascii_grid_reads_back_bit_for_bit() {
    let folder = Folder::new();
    let path = folder.join("grid.asc");
    folder.write("grid.asc", &format!("{}0 0 0 0 0 0", HEADER.replace("cellsize 2", "dx 2\ndy 0.1")));
    let georef = || AsciiGrid::open(&path, &mut Vec::new()).unwrap().georef().clone();
    let before = georef();
    let heights = [0.1, -2.5e-300, f64::NAN, 8848.86, f64::from(0.1f32), 1.0 / 3.0];
    let mut out = Vec::new();
    write_ascii_grid(&mut out, &before, -9999.0, heights.into_iter(), None).unwrap();
    std::fs::write(&path, out).unwrap();
    let found = read(&path).unwrap().0;
    assert!(same(&found, &heights), "{found:?}");
    assert!(georef().same_grid(&before));
}

/// Strips that follow each other are read together; those that lie anywhere else, one by one.
#[test]
fn plain_strips_are_read_wherever_they_lie() {
    let folder = Folder::new();
    let values: Vec<f64> = (0..40 * 11).map(|k| f64::from(k * 37 % 1000) / 8.0).collect();
    let tiff = PlainTiff::floats((691_000.0, 5_334_000.0), 1.0, 11, values.clone());
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
        let (raster, n_void) =
            file.read_plain_heights(file.georef().window(), &mut Vec::new()).expect("heights").expect("stored plainly");
        let found: Vec<f64> = raster.cells().iter().map(|steps| f64::from(*steps) / 1024.0).collect();
        assert!(same(&found, &values) && n_void == 0, "{swaps:?}");
    }
}

/// Tiles are decoded in parallel straight onto the lattice: the heights of any part are those that are read one by one.
#[test]
fn heights_of_tiles_are_those_that_are_read_one_by_one() {
    let folder = Folder::new();
    let (n_rows, n_cols) = (600, 700);
    let georef = GeoRef::new((691_000.0, 5_334_000.0), (1.0, 1.0), (n_rows, n_cols), None).unwrap();
    let floats: Vec<f32> =
        (0..n_rows * n_cols).map(|k| if k % 97 < 3 { -9999.0 } else { (k % 4001) as f32 * 0.037 - 40.0 }).collect();
    let bytes: Vec<u8> = (0..n_rows * n_cols).map(|k| u8::try_from(k * 7 % 251).unwrap()).collect();
    let write = |name: &str, bands: Bands<'_>, nodata: f64, layout: TiffLayout| {
        let nodata = Some(nodata);
        let image = GeoTiffImage { georef: &georef, bands, nodata, palette: None, metadata: &[], layout };
        std::fs::write(folder.join(name), encode_geotiff(&image).unwrap()).unwrap();
    };
    write("floats.tif", Bands::Float(vec![("h".into(), &floats)]), -9999.0, TiffLayout::Cog);
    write("strips.tif", Bands::Float(vec![("h".into(), &floats)]), -9999.0, TiffLayout::Plain);
    write("bytes.tif", Bands::Byte(vec![("h".into(), &bytes)]), 5.0, TiffLayout::Cog);
    for name in ["floats.tif", "strips.tif", "bytes.tif"] {
        let file = GeoTiff::open(folder.join(name), &mut Vec::new()).expect("a GeoTIFF");
        for (row, col, n_rows, n_cols) in
            [(0, 0, 600, 700), (0, 5, 1, 1), (255, 250, 3, 13), (300, 512, 300, 188), (599, 0, 1, 700)]
        {
            let window = CellWindow { row, col, n_rows, n_cols };
            let (found, n_void) =
                file.read_plain_heights(window, &mut Vec::new()).expect("heights").expect("stored plainly");
            let on_lattice = |height: f64| height_steps(height).unwrap_or(i32::MIN);
            let read = file.read(window, &mut Vec::new(), on_lattice).expect("heights");
            assert_eq!(found.georef(), read.georef());
            let is_void = |steps: &i32| *steps == i32::MIN;
            assert_eq!(n_void, read.cells().iter().filter(|steps| is_void(steps)).count() as u64, "{name} {window:?}");
            for (found, wanted) in found.cells().iter().zip(read.cells()) {
                assert!(found == wanted || is_void(wanted) && *found == VOID, "{name} {window:?}: {found} {wanted}");
            }
        }
    }
}

/// Blocks in strips are held as runs of equal heights, those of a text grid cell by cell: the same above, on and below flat ground.
#[test]
fn flat_ground_below_runs_of_heights_is_that_below_single_cells() {
    let (n_rows, n_cols) = (520, 530);
    let mut heights = vec![2.0; n_rows * n_cols];
    for k in 0..50 {
        let (row, col, height) = (k * 37 % 480, k * 101 % 470, [0.5, 2.25, 9.0, 31.5][k % 4]);
        let rows = heights.chunks_mut(n_cols).skip(row).take(4 + k % 31);
        rows.for_each(|cells| cells[col..col + 5 + k].fill(height));
    }
    let folder = Folder::new();
    let tiff = PlainTiff::floats((500_000.0, 5_400_000.0), 1.0, n_cols, heights.clone());
    std::fs::write(folder.join("blocks.tif"), tiff.bytes()).unwrap();
    let mut text = format!("ncols {n_cols}\nnrows {n_rows}\nxllcorner 500000\nyllcorner 5399480\ncellsize 1\n");
    for row in heights.chunks(n_cols) {
        writeln!(text, "{}", row.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")).unwrap();
    }
    folder.write("blocks.asc", &text);
    for ground in ["2", "0", "5"] {
        let [runs, cells] = ["blocks.tif", "blocks.asc"].map(|name| {
            let line = format!("map {name} --ground {ground} --crs EPSG:25832 --uav 500300,5399740,70 --receivers all");
            folder.type_in(&format!("{line} --json -q")).done().json()
        });
        assert_eq!(runs["digest"], cells["digest"], "ground at {ground} m");
        let told = |document: &Value| document["warnings"].to_string().replace("blocks.tif", "blocks.asc");
        assert_eq!(told(&runs), told(&cells), "ground at {ground} m");
        assert_eq!(runs["warnings"].to_string().contains("W341"), ground != "0", "{runs}");
    }
}
