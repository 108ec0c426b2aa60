//! α, β and γ by tile: counted by hand, over generated cities whose parameters are known, and as GDAL reads them.

use serde_json::Value;
use skyshed_io::formats::GeoTiff;

use crate::needs::has_program;
use crate::program::Folder;
use crate::refusals::check_refusals;
use crate::texts::squares;

/// A row of the table.
#[derive(Debug, Clone, PartialEq)]
struct Tile {
    at: [usize; 2],
    middle: [f64; 2],
    area: f64,
    buildings: u64,
    /// α, β, γ.
    values: [Option<f64>; 3],
    reason: String,
}

fn table(text: &str) -> Vec<Tile> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let names = "row,col,x,y,area_m2,buildings,alpha,beta_per_km2,gamma_m,reason";
    assert_eq!(reader.headers().unwrap().iter().collect::<Vec<_>>().join(","), names);
    let tile = |record: csv::StringRecord| Tile {
        at: [0, 1].map(|k| record[k].parse().unwrap()),
        middle: [2, 3].map(|k| record[k].parse().unwrap()),
        area: record[4].parse().unwrap(),
        buildings: record[5].parse().unwrap(),
        values: [6, 7, 8].map(|k| Some(&record[k]).filter(|v| !v.is_empty()).map(|v| v.parse().unwrap())),
        reason: record[9].to_string(),
    };
    reader.records().map(|record| tile(record.unwrap())).collect()
}

fn assert_close(found: Option<f64>, expected: Option<f64>, what: &str) {
    match (found, expected) {
        (Some(a), Some(b)) => assert!((a - b).abs() <= 1e-9 * b.abs().max(1.0), "{what}: {a}, expected {b}"),
        (a, b) => assert_eq!(a, b, "{what}"),
    }
}

#[test]
fn tiles_of_footprints_hold_what_a_hand_counts() {
    let folder = Folder::new();
    let city = [
        [4.0, 24.0, 10.0, 10.0], // within the first tile
        [15.0, 5.0, 10.0, 6.0],  // across two; its centroid lies on the border, so it counts in the eastern one
        [30.0, 2.0, 6.0, 8.0],   // overlaps the next by half
        [33.0, 2.0, 6.0, 8.0],
        [48.0, 30.0, 6.0, 9.0], // mostly beyond the extent, where its centroid lies
    ];
    folder.write("city.geojson", &squares(&city));
    let line = "info city.geojson --extent 0,0,50,40 --tile 20 -o tiles.csv -o tiles.tif --json -q";
    let info = folder.type_in(line).done().json();
    let tiles = table(&folder.text("tiles.csv"));
    // From the north-west: rows of 20 m, columns of 20, 20 and 10 m.
    let gamma = (164.0_f64 / 6.0).sqrt(); // 6² + 8² + 8² over twice three
    let none = "no γ of fewer than 2 buildings";
    let expected = [
        ([0, 0], [10.0, 30.0], 400.0, 1, [Some(0.25), Some(2500.0), None], none),
        ([0, 1], [30.0, 30.0], 400.0, 0, [Some(0.0), Some(0.0), None], none),
        ([0, 2], [50.0, 30.0], 200.0, 0, [Some(0.06), Some(0.0), None], none), // 2 × 6 of 10 × 20
        ([1, 0], [10.0, 10.0], 400.0, 0, [Some(0.125), Some(0.0), None], none), // 5 × 10
        // 5 × 10 and 9 × 6.
        ([1, 1], [30.0, 10.0], 400.0, 3, [Some(0.26), Some(7500.0), Some(gamma)], ""),
        ([1, 2], [50.0, 10.0], 200.0, 0, [Some(0.0), Some(0.0), None], none),
    ];
    assert_eq!(tiles.len(), expected.len());
    for (tile, (at, middle, area, buildings, values, reason)) in tiles.iter().zip(expected) {
        assert_eq!((tile.at, tile.middle, tile.buildings, tile.reason.as_str()), (at, middle, buildings, reason));
        assert_close(Some(tile.area), Some(area), "area");
        for (k, name) in ["alpha", "beta", "gamma"].iter().enumerate() {
            assert_close(tile.values[k], values[k], &format!("{name} of {at:?}"));
        }
    }
    // All together, and the buildings that no tile holds.
    let whole = &info["tiles"];
    assert_eq!(
        (&whole["buildings"], &whole["buildings_outside"], &info["buildings"]),
        (&4.into(), &1.into(), &5.into())
    );
    assert_close(whole["alpha"].as_f64(), Some((100.0 + 12.0 + 50.0 + 104.0) / 2000.0), "α of the whole");
    assert_close(whole["beta_per_km2"].as_f64(), Some(4.0 / 2e-3), "β of the whole");
    assert_close(whole["gamma_m"].as_f64(), Some((264.0_f64 / 8.0).sqrt()), "γ of the whole");
    raster_holds_the_table(&folder, &tiles);
    assert_eq!(folder.json("tiles.csv.json")["schema"], "skyshed/tiles/1");
}

#[test]
fn shares_of_a_tile_are_of_its_ground_with_data() {
    let folder = Folder::new();
    // A building of 100 m² in each of two tiles of 20 m; the data end in the middle of the second.
    folder.write("city.geojson", &squares(&[[4.0, 4.0, 10.0, 10.0], [20.0, 4.0, 10.0, 12.0]]));
    folder.write("area.geojson", &squares(&[[0.0, -5.0, 30.0, 0.0]]));
    folder.type_in("info city.geojson --extent 0,0,40,20 --data-area area.geojson --tile 20 -o tiles.csv -q").done();
    let found: Vec<_> = table(&folder.text("tiles.csv")).iter().map(|tile| (tile.area, tile.values[0])).collect();
    assert_eq!(found, [(400.0, Some(0.25)), (200.0, Some(0.5))]);
}

/// β counts the buildings of the area that it is per, not of the whole file.
#[test]
fn estimates_are_over_the_buildings_of_the_extent() {
    let folder = Folder::new();
    let city: Vec<[f64; 4]> = (0..100).map(|k| [f64::from(k) * 20.0 + 5.0, 5.0, 10.0, 12.0]).collect();
    folder.write("city.geojson", &squares(&city));
    folder.write("area.geojson", &squares(&[[0.0, -90.0, 200.0, 0.0]]));
    // 10 buildings of 100 m² on 200 × 20 m, cut out or drawn.
    for part in ["--extent 0,0,200,20", "--extent 0,0,2000,20 --data-area area.geojson"] {
        let estimated = folder.type_in(&format!("info city.geojson {part} --json -q")).done().json();
        let estimated = &estimated["estimated_built_up"];
        assert_close(estimated["alpha"].as_f64(), Some(0.25), part);
        assert_close(estimated["beta_per_km2"].as_f64(), Some(2500.0), part);
    }
}

/// The bands of `tiles.tif` are the columns of the table, nodata where these are empty.
fn raster_holds_the_table(folder: &Folder, tiles: &[Tile]) {
    let tiff = GeoTiff::open(folder.join("tiles.tif"), &mut Vec::new()).unwrap();
    assert_eq!(tiff.band_names(), ["alpha", "beta_per_km2", "gamma_m", "buildings"].map(Some));
    for band in 0..4 {
        let read = tiff.read_band(band, tiff.georef().window(), &mut Vec::new(), |v| v);
        if band < 3 && tiles.iter().all(|tile| tile.values[band].is_none()) {
            assert_eq!(read.unwrap_err().code(), "E305", "a band of nodata alone");
            continue;
        }
        let read = read.unwrap();
        for (tile, found) in tiles.iter().zip(read.cells()) {
            let count = f64::from(u32::try_from(tile.buildings).unwrap());
            let expected = if band == 3 { Some(count) } else { tile.values[band] };
            #[expect(clippy::cast_possible_truncation, reason = "bands are f32")]
            let expected = expected.map_or(f64::NAN, |v| f64::from(v as f32));
            assert!(found.total_cmp(&expected).is_eq() || (found - expected).abs() < 1e-30, "{found} {expected}");
        }
    }
}

#[test]
fn tiles_of_a_raster_add_up_to_the_whole() {
    let folder = Folder::new();
    // Two buildings touch at a corner only and are two; the third reaches over a border. Two cells are nodata.
    folder.write(
        "dsm.asc",
        "ncols 7\nnrows 5\nxllcorner 0\nyllcorner 0\ncellsize 2\nNODATA_value -9999\n\
         0 5 0 0 0 0 -9999\n0 0 8 8 0 0 -9999\n0 0 0 0 0 0 0\n0 0 0 0 3 6 0\n0 0 0 0 0 0 0\n",
    );
    let info = folder.type_in("info dsm.asc --ground 0 --tile 6 -o tiles.csv -o tiles.tif --json -q").done().json();
    let tiles = table(&folder.text("tiles.csv"));
    // Tiles of 3 × 3 cells of 4 m²: columns of 3, 3 and 1 cells, rows of 3 and 2.
    let values: Vec<(f64, u64, f64)> = tiles.iter().map(|t| (t.area, t.buildings, t.values[0].unwrap())).collect();
    let expected = [
        (36.0, 1, 2.0 / 9.0), // 5 alone: the centroid of the two cells of 8 is on the border, which is the eastern tile's
        (36.0, 1, 1.0 / 9.0),
        (4.0, 0, 0.0), // one known cell of three
        (24.0, 0, 0.0),
        (24.0, 1, 2.0 / 6.0),
        (8.0, 0, 0.0),
    ];
    assert_eq!(values, expected);
    // α weighted by area is that of the whole, exactly: all are counts of cells of 4 m².
    let cells = |name: &str| info["cells"][name].as_f64().unwrap();
    let built: f64 = tiles.iter().map(|t| (t.values[0].unwrap() * t.area / 4.0).round()).sum();
    let known: f64 = tiles.iter().map(|t| t.area / 4.0).sum();
    assert_close(Some(built), Some(cells("building")), "cells of buildings");
    assert_close(Some(known), Some(cells("building") + cells("open")), "known cells");
    assert_close(info["tiles"]["alpha"].as_f64(), Some(built / known), "α");
    // Heights are means over cells: 5, 8 and 4.5 m.
    let gamma = ((25.0 + 64.0 + 20.25) / 6.0_f64).sqrt();
    assert_close(info["tiles"]["gamma_m"].as_f64(), Some(gamma), "γ");
    assert_eq!(info["tiles"]["buildings"], 3);
    raster_holds_the_table(&folder, &tiles);
}

#[test]
fn tiles_of_whole_blocks_have_the_parameters_of_the_city() {
    let folder = Folder::new();
    // β = 400/km² is a period of 50 m, α = 0.36 a building of 30 × 30 m: all on the lattice.
    folder.type_in("city itu:0.36,400,12 --size 200 -o city.geojson -o city.tif -q").done();
    let heights: Vec<([f64; 2], f64)> = folder.json("city.geojson")["features"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| {
            let corner = |k: usize| f["geometry"]["coordinates"][0][0][k].as_f64().unwrap();
            ([corner(0), corner(1)], f["properties"]["height"].as_f64().unwrap())
        })
        .collect();
    let from = |line: &str| {
        folder.type_in(&format!("info {line} --tile 100 -o tiles.csv --overwrite -q")).done();
        table(&folder.text("tiles.csv"))
    };
    // The city itself, its footprints, and its surface: at 1 m, where cells on walls are open, 29 × 29 cells a building.
    let of_cells = 29.0 * 29.0 / 2500.0;
    let lines = [
        ("itu:0.36,400,12 --size 200", 0.36),
        ("city.geojson --extent 0,0,200,200", 0.36),
        ("city.tif --ground 0", of_cells),
    ];
    for (line, alpha) in lines {
        for tile in from(line) {
            assert_eq!(tile.buildings, 4, "{line}");
            assert!((tile.values[0].unwrap() - alpha).abs() < 0.025, "{line}: {tile:?}");
            if alpha > 0.35 {
                assert_close(tile.values[0], Some(alpha), line);
            }
            assert_close(tile.values[1], Some(400.0), line);
            // γ from the heights in the file of the city, by its corners.
            let [x, y] = tile.middle;
            let here = heights.iter().filter(|([e, n], _)| (e - x).abs() < 50.0 && (n - y).abs() < 50.0);
            let squares: Vec<f64> = here.map(|(_, h)| h * h).collect();
            assert_eq!(squares.len(), 4);
            let gamma = (squares.iter().sum::<f64>() / 8.0).sqrt();
            assert!((tile.values[2].unwrap() - gamma).abs() < 1e-4, "{line}: {tile:?}, {gamma}");
        }
    }
}

#[test]
fn gdal_reads_bands_names_nodata_and_place() {
    if !has_program("gdalinfo") || !has_program("gdallocationinfo") {
        return;
    }
    let folder = Folder::new();
    folder.write("city.geojson", &squares(&[[4.0, 24.0, 10.0, 10.0], [15.0, 5.0, 10.0, 6.0], [21.0, 12.0, 4.0, 8.0]]));
    folder.type_in("info city.geojson --extent 0,0,50,40 --tile 20 -o tiles.tif -q").done();
    let run = |program: &str, words: &[&str]| {
        let output = std::process::Command::new(program).args(words).current_dir(folder.path()).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let info: Value = serde_json::from_str(&run("gdalinfo", &["-json", "tiles.tif"])).unwrap();
    assert_eq!(info["size"], serde_json::json!([3, 2]));
    assert_eq!(info["geoTransform"], serde_json::json!([0.0, 20.0, 0.0, 40.0, 0.0, -20.0]));
    assert!(info["coordinateSystem"]["wkt"].as_str().unwrap().contains("25832"));
    let bands = info["bands"].as_array().unwrap();
    let names: Vec<&str> = bands.iter().map(|b| b["description"].as_str().unwrap()).collect();
    assert_eq!(names, ["alpha", "beta_per_km2", "gamma_m", "buildings"]);
    assert!(bands.iter().all(|b| b["noDataValue"].as_f64() == Some(-9999.0)), "{bands:?}");
    let origin: Value = serde_json::from_str(info["metadata"][""]["SKYSHED"].as_str().unwrap()).unwrap();
    assert_eq!(origin["schema"], "skyshed/tiles/1");
    // The second row, second column: two buildings; the first tile: one, so no γ.
    let values = |col: &str, row: &str| -> Vec<f64> {
        run("gdallocationinfo", &["-valonly", "tiles.tif", col, row]).lines().map(|v| v.parse().unwrap()).collect()
    };
    assert_eq!(values("0", "0"), [0.25, 2500.0, -9999.0, 1.0]);
    let found = values("1", "1");
    // 5 × 10 and 4 × 4, which overlap by 4 × 3: 54 of 400; γ² = (6² + 8²)/4.
    let expected = [0.135, 5000.0, 5.0, 2.0];
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
}

#[test]
fn tiles_that_make_no_sense_are_refused() {
    let folder = Folder::new();
    folder.write("city.geojson", &squares(&[[0.0, 0.0, 10.0, 10.0]]));
    folder.write("dsm.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n");
    let cases = [
        ("city.geojson --tile 0", "E113", "`0`"),
        ("city.geojson --tile=-5", "E113", "`-5`"),
        ("city.geojson --tile 0.5", "E113", "`0.5`"),
        ("city.geojson --tile nan", "E101", "'nan'"),
        ("city.geojson --tile 1 --extent 0,0,30000,30000 --cell 1", "E502", ""),
        ("city.geojson --tile 5 -o tiles.geojson", "E105", "tiles.geojson"),
        ("city.geojson --tile 5 --zones", "E101", "'--zones'"),
        ("dsm.asc --tile 2", "E117", ""),
    ];
    check_refusals(&folder, "info", &cases);
}
