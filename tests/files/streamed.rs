//! Rasters that do not fit in memory: the same numbers and the same cells as in memory, within the memory that is allowed.

use std::io::Write;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use serde_json::Value;
use skyshed_core::raster::{CellWindow, GeoRef};
use skyshed_io::formats::{Bands, GeoTiff, GeoTiffImage, encode_geotiff};
use skyshed_request::TiffLayout;

use crate::needs::has_program;
use crate::program::Folder;
use crate::support::{Random, is_long};

/// Writes a city with relief, houses and holes, and the terrain below it on the same grid and on a coarser one.
fn write_city(folder: &Folder, (n_rows, n_cols): (usize, usize)) {
    #[expect(clippy::cast_possible_truncation, reason = "heights of a test scene")]
    let ground = |row: usize, col: usize| (60.0 + row as f64 / 9.0 + 7.0 * (col as f64 / 50.0).sin()) as f32;
    let mut random = Random(7);
    let roofs: Vec<f32> = (0..4000).map(|_| random.within(0, 40) as f32).collect();
    let surface = |row: usize, col: usize| {
        let is_house = row % 20 < 12 && col % 24 < 14;
        let roof = roofs[(row / 20 * 61 + col / 24) % roofs.len()];
        match (row / 50 * 7 + col / 50) % 41 {
            0 => -9999.0,
            _ if is_house && roof > 8.0 => ground(row, col) + roof,
            _ => ground(row, col),
        }
    };
    let write = |name: &str, (n_rows, n_cols): (usize, usize), cell: f64, value: &dyn Fn(usize, usize) -> f32| {
        let georef = &GeoRef::new((500.0, 9000.0), (cell, cell), (n_rows, n_cols), None).unwrap();
        let cells: Vec<f32> = (0..n_rows).flat_map(|r| (0..n_cols).map(move |c| value(r, c))).collect();
        let bands = Bands::Float(vec![("height".into(), &cells)]);
        let (nodata, layout) = (Some(-9999.0), TiffLayout::Cog);
        let image = GeoTiffImage { georef, bands, nodata, palette: None, metadata: &[], layout };
        std::fs::write(folder.join(name), encode_geotiff(&image).unwrap()).unwrap();
    };
    write("dsm.tif", (n_rows, n_cols), 2.0, &surface);
    write("dtm.tif", (n_rows, n_cols), 2.0, &ground);
    write("coarse.tif", (n_rows / 3, n_cols / 3), 6.3, &|row, col| ground(3 * row, 3 * col));
}

/// What a document says of a map, but for its times, its command, and what kind of run it was.
fn facts(mut document: Value) -> Value {
    let object = document.as_object_mut().expect("an object");
    ["command", "timing_s", "unit"].iter().for_each(|key| drop(object.remove(*key)));
    document
}

/// All cells of the first band of a GeoTIFF, as the bits of a double.
fn cells(path: &Path) -> Vec<u64> {
    let file = GeoTiff::open(path, &mut Vec::new()).expect("a GeoTIFF");
    let raster = file.read(file.georef().window(), &mut Vec::new(), f64::to_bits);
    raster.expect("its cells").into_cells().into_vec()
}

#[test]
fn maps_strip_by_strip_are_those_in_memory() {
    let folder = Folder::new();
    write_city(&folder, (600, 700));
    let over = "--uav 1200,8400,160amsl";
    for line in [
        format!("--terrain dtm.tif {over}"),
        format!("--terrain dtm.tif {over} --receivers all"),
        format!("--terrain dtm.tif {over} --receivers roof --rx-height 0"),
        format!("--terrain coarse.tif {over}"),
        format!("--terrain dtm.tif {over} --radius 300"),
        format!("--terrain dtm.tif {over} --sector 340,80 --elevation -40,-9 --receivers all"),
        format!("--terrain dtm.tif {over} --earth-k 0.001 --receivers all"),
        format!("--ground 70 {over} --curvature-coefficient 3000"),
        format!("--terrain coarse.tif {over} --earth-k 0.0005 --sector 340,80 --elevation -40,-9 --radius 500"),
        format!("{over} --earth-k 0.001"),
        format!("--terrain coarse.tif {over} --receivers all --beam 120 --min-radius 40 --slant-range 160"),
        format!("--terrain dtm.tif {over} --nodata-as block"),
        format!("--ground 70 {over}"),
        over.to_string(),
        "--uav 300,9500,400amsl".to_string(),
        "--terrain dtm.tif --uav 1800,8000,30agl".to_string(),
        "--uav 1899,7801,3agl".to_string(),
    ] {
        let run = |to: &str| folder.type_in(&format!("map dsm.tif {line} -o {to} --overwrite --json -q")).done().json();
        let (mut a, mut b) = (facts(run("a.tif")), facts(run("b.tif --strips")));
        assert!(b["sites"][0]["receivers"].as_u64() > Some(1000), "{line}");
        // Zones need the whole scene at once; without them what is below the UAV is ground or a roof.
        for document in [&mut a, &mut b] {
            for part in ["/sites/0/zones", "/union/zones", "/sites/0/placement"] {
                *document.pointer_mut(part).expect(part) = Value::Null;
            }
        }
        assert_eq!(a, b, "{line}");
        assert!(cells(&folder.join("a.tif")) == cells(&folder.join("b.tif")), "{line}");
        let layers = ["ceiling,los,margin", "margin", "ceiling"];
        for layers in &layers[..if is_long() { 3 } else { 1 }] {
            for to in ["a.tif", "b.tif --strips"] {
                folder.type_in(&format!("map dsm.tif {line} -o {to} --layers {layers} --overwrite -q")).done();
            }
            let heights = ["a.tif", "b.tif"].map(|file| cells(&folder.join(file)));
            assert!(heights[0] == heights[1], "{line} {layers}");
            assert!(
                heights[0].iter().filter(|bits| !f64::from_bits(**bits).is_nan()).count() > 1000,
                "{line} {layers}"
            );
        }
    }
}

#[test]
fn strips_need_memory_and_a_lattice_too() {
    let folder = Folder::new();
    write_city(&folder, (1500, 3000));
    let answer = folder.type_in("map dsm.tif --max-memory 32M --uav 800,7000,300amsl -o a.tif");
    assert!(answer.refused(5)[0].contains("even strip by strip"), "{answer:?}");
    if has_program("gdal_create") {
        let words = "-q -of GTiff -outsize 70000 10 -ot Float32 -burn 5 -a_ullr 0 10 70000 0 long.tif";
        let made = Command::new("gdal_create").args(words.split_whitespace()).current_dir(folder.path()).status();
        assert!(made.expect("it runs").success());
        let answer = folder.type_in("map long.tif --strips --uav 800,5,300amsl -o a.tif");
        assert!(answer.refused(5)[1].contains("--radius"), "{answer:?}");
        // What is in range of a UAV fits.
        folder.type_in("map long.tif --uav 800,5,300amsl --radius 900 -o part.tif").done();
    }
}

#[test]
fn a_picture_shows_a_smaller_map_and_says_so() {
    let folder = Folder::new();
    write_city(&folder, (2100, 300));
    let line = "map dsm.tif --terrain dtm.tif --uav 800,7000,60agl --strips -o a.svg -o a.json -q";
    folder.type_in(line).done();
    let picture = folder.text("a.svg");
    let p_los = folder.json("a.json")["sites"][0]["p_los"].as_f64().expect("a share");
    for words in ["one of 2 × 2 cells", "Cells of 2 m", &format!("{p_los:.4}")] {
        assert!(picture.contains(words), "{words}");
    }
}

#[test]
fn what_needs_all_cells_at_once_is_refused_with_a_way_out() {
    let folder = Folder::new();
    write_city(&folder, (300, 300));
    let refused = |line: &str| {
        let answer = folder.type_in(&format!("map dsm.tif --strips {line}"));
        assert_eq!(answer.error(), "E501", "{line}");
        assert!(answer.refused(5)[1].starts_with("hint: "), "{line}: {answer:?}");
    };
    let over = "--uav 700,8700,160amsl";
    refused(&format!("{over} -o a.npz"));
    refused(&format!("{over} -o a.tif --layers least-height"));
    refused(&format!("{over} -o a.tif --layers stability"));
    refused(&format!("{over} -o a.svg --layers margin"));
    refused(&format!("{over} --uav 800,8700,160amsl -o a.csv -q"));
    refused(&format!("{over} -o a.tif --tif-layout plain"));
    assert_eq!(folder.files(), ["coarse.tif", "dsm.tif", "dtm.tif"]);
    // The same as in memory.
    folder.type_in("map dsm.tif --strips --uav 700,8700,1agl -o a.tif").done();
    let errors = [("--uav 700,8700,-30agl", 4), ("--uav 700,8700,30roof", 4), (&*format!("{over} --method ray"), 2)];
    for (line, code) in errors {
        let small = folder.type_in(&format!("map dsm.tif {line} --json -q")).code();
        folder.type_in(&format!("map dsm.tif --strips {line} --json -q")).refused(code);
        assert!(small == code || line.contains("ray"), "{line}");
    }
    let answer = folder.type_in(&format!("map dsm.tif --strips {over} -o b.tif --scratch nowhere"));
    assert!(answer.refused(2)[0].contains("nowhere"), "{answer:?}");
}

/// A surface model written by the example `large_dsm`, which is built with the tests.
fn large_dsm(cells: usize, path: &Path) {
    let program = Path::new(env!("CARGO_BIN_EXE_skyshed")).with_file_name("examples").join("large_dsm");
    let words = [cells.to_string(), path.display().to_string()];
    assert!(Command::new(program).args(words).status().expect("the example runs").success());
}

/// 10 GB of heights: takes a quarter of an hour and as much of the disk, so it has a variable of its own.
#[test]
fn fifty_thousand_cells_a_side_take_two_gigabytes() {
    if std::env::var_os("SKYSHED_LARGE").is_none() {
        let _ = writeln!(std::io::stderr(), "SKIPPED: 50 000 × 50 000 cells are mapped with SKYSHED_LARGE=1");
        return;
    }
    let folder = Folder::new();
    large_dsm(16_384, &folder.join("part.tif"));
    large_dsm(50_000, &folder.join("all.tif"));
    // Both UAVs stand over the middle.
    let measured = |line: &str| {
        let start = Instant::now();
        let (answer, peak) = folder.measured(line);
        answer.done();
        (start.elapsed().as_secs_f64(), peak)
    };
    let in_memory = measured("map part.tif --uav 408000,5392000,300 -o part-los.tif -q");
    let streamed = measured("map all.tif --uav 425000,5375000,300 -o all-los.tif -q --max-memory 2G");
    let per_cell = |seconds: f64, cells: f64| seconds / (cells * cells) * 1e9;
    let (small, large) = (per_cell(in_memory.0, 16_384.0), per_cell(streamed.0, 50_000.0));
    let gigabytes = streamed.1 as f64 / 1e9;
    let said = format!("in memory {small:.1} ns a cell, strip by strip {large:.1}; peak {gigabytes:.2} GB");
    let _ = writeln!(std::io::stderr(), "{said}");
    assert!(streamed.1 <= 2_000_000_000, "peak {}", streamed.1);
    assert!(large <= 3.0 * small, "{large} ns a cell, in memory {small}");
    // The part is the north-west corner of all: what a UAV there sees of it is the same.
    let near = "--uav 404000,5396000,300 --radius 3900 -q";
    measured(&format!("map part.tif {near} -o a.tif"));
    measured(&format!("map all.tif {near} -o b.tif --max-memory 2G"));
    let part = cells(&folder.join("a.tif"));
    let all = GeoTiff::open(folder.join("b.tif"), &mut Vec::new()).expect("a GeoTIFF");
    let window = CellWindow { row: 0, col: 0, n_rows: 16_384, n_cols: 16_384 };
    let all = all.read(window, &mut Vec::new(), f64::to_bits).expect("its cells");
    assert!(part == all.cells());
    assert!(part.iter().filter(|class| **class == 1).count() > 1_000_000);
}
