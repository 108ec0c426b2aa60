//! Bad input as it is seen in the wild, row by row: what other tools do wrong with it, and the answer that is given here.
//!
//! Row numbers are those of a survey of what users of neighboring programs report. Where an answer has a suite of its own, the
//! row only shows that it is reached from the command line.

use serde_json::Value;

use crate::program::{Answer, Folder};

/// An Esri ASCII grid of 20 × 20 cells.
fn grid(height: impl Fn(usize, usize) -> &'static str) -> String {
    let row = |r: usize| (0..20).map(|c| height(r, c)).collect::<Vec<_>>().join(" ");
    let rows: Vec<String> = (0..20).map(row).collect();
    format!("ncols 20\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 1\n{}\n", rows.join("\n"))
}

/// Footprints in EPSG:25832, or another system or none.
fn footprints(crs: &str, features: &str) -> String {
    let crs = match crs {
        "" => String::new(),
        code => format!(r#""crs": {{"type": "name", "properties": {{"name": "{code}"}}}}, "#),
    };
    format!(r#"{{"type": "FeatureCollection", {crs}"features": [{features}]}}"#)
}

fn building(properties: &str, rings: &str) -> String {
    let polygon = format!(r#"{{"type": "Polygon", "coordinates": [{rings}]}}"#);
    format!(r#"{{"type": "Feature", "properties": {{{properties}}}, "geometry": {polygon}}}"#)
}

const SQUARE: &str = "[[10, 10], [14, 10], [14, 14], [10, 14], [10, 10]]";

/// A folder with a flat terrain, a surface with a wall of 10 m at column 10, and one building.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("flat.asc", &grid(|_, _| "0"));
    folder.write("wall.asc", &grid(|_, c| if c == 10 { "10" } else { "0" }));
    folder.write("city.geojson", &footprints("EPSG:25832", &building(r#""height": 10"#, SQUARE)));
    folder
}

fn mapped(folder: &Folder, line: &str) -> (Value, Answer) {
    let answer = folder.type_in(&format!("map {line} --json")).done();
    (answer.json(), answer)
}

fn count(document: &Value, pointer: &str) -> u64 {
    document.pointer(pointer).and_then(Value::as_u64).unwrap_or_else(|| panic!("{pointer}: {document}"))
}

#[test]
fn rows_1_to_5_of_rasters_with_holes_and_odd_sizes() {
    let folder = folder();
    // 1: NaN cells hold no receiver, are counted with their place, and never become LoS or NLoS.
    folder.write("nan.asc", &grid(|_, c| if c == 10 { "nan" } else { "0" }));
    let (map, answer) = mapped(&folder, "nan.asc --ground 0 --uav 0.5,0.5,30");
    assert_eq!((count(&map, "/sites/0/receivers"), answer.warnings().contains(&"W320")), (380, true));
    assert!(answer.err.contains("20 cells with NaN (rows 0 to 19, columns 10 to 10)"), "{}", answer.err);
    // 2: what looks like nodata and is not declared is kept, and told; the usual -9999 of ASCII grids is nodata.
    folder.write("odd.asc", &grid(|_, c| if c == 10 { "32767" } else { "0" }));
    assert!(mapped(&folder, "odd.asc --ground 0 --uav 0.5,0.5,30").1.warnings().contains(&"W328"));
    // 3: nodata between UAV and user blocks nothing, or everything.
    let clear = mapped(&folder, "nan.asc --ground 0 --uav 0.5,0.5,30").0;
    let block = mapped(&folder, "nan.asc --ground 0 --uav 0.5,0.5,30 --nodata-as block").0;
    assert_eq!((count(&clear, "/sites/0/los"), count(&block, "/sites/0/los")), (380, 200));
    // 4: infinite heights are void; a raster of nothing else is refused; one cell, and one row, work.
    folder.write("inf.asc", &grid(|_, c| if c == 10 { "-inf" } else { "0" }));
    assert!(mapped(&folder, "inf.asc --ground 0 --uav 0.5,0.5,30").1.warnings().contains(&"W320"));
    folder.write("void.asc", &grid(|_, _| "nan"));
    folder.refuses("map void.asc --ground 0 --uav 0.5,0.5,30 --json", "E305", &[]);
    folder.write("one.asc", "ncols 1\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n0\n");
    folder.write("row.asc", "ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n0 5 0\n");
    assert_eq!(count(&mapped(&folder, "one.asc --ground 0 --uav 0.5,0.5,3").0, "/sites/0/los"), 1);
    assert_eq!(count(&mapped(&folder, "row.asc --ground 0 --uav 0.5,0.5,3").0, "/sites/0/los"), 1);
    // 5: what does not fit in memory is in `cli` and `memory_limits`.
}

#[test]
fn rows_6_to_9_of_reference_systems() {
    let folder = folder();
    // 6: degrees are refused with the command that helps, or brought to UTM. 0.0001° of latitude are 11.1 m.
    let square = "[[11.5, 48.1], [11.5002, 48.1], [11.5002, 48.1001], [11.5, 48.1001], [11.5, 48.1]]";
    folder.write("degrees.geojson", &footprints("", &building(r#""height": 10"#, square)));
    folder.refuses("info degrees.geojson", "E310", &["--project auto", "-t_srs EPSG:32632"]);
    let projected = folder.type_in("info degrees.geojson --project auto --cell 0.1 --json").done().json();
    assert_eq!(projected["crs"], "EPSG:32632");
    // PROJ puts the corners at x 686 121.39 to 686 136.64 and y 5 330 438.13 to 5 330 449.73; the grid is in cells of 0.1 m.
    let extent: Vec<f64> = (0..4).map(|k| projected["extent"][k].as_f64().unwrap()).collect();
    for (found, corner) in extent.iter().zip([686_121.39, 5_330_438.13, 686_136.64, 5_330_449.73]) {
        assert!((found - corner).abs() < 0.21, "{projected}");
    }
    let west = extent[0];
    folder.refuses("info city.geojson --project EPSG:999999", "E115", &["`--project`"]);
    // What names no system cannot be brought into another one.
    folder.refuses("map wall.asc --ground 0 --project auto --uav 1,1,30 --json", "E310", &[]);
    // 7: without a reference system meters are assumed, and that is said.
    assert!(mapped(&folder, "wall.asc --ground 0 --uav 0.5,0.5,30").1.warnings().contains(&"W325"));
    // 8: sites in degrees are brought into the scene's system; where it has none that is said.
    folder.write("sites.csv", "lon,lat,h\n11.5001,48.10005,30\n");
    let (map, _) = mapped(&folder, "degrees.geojson --project auto --uavs sites.csv");
    let x = map["sites"][0]["x"].as_f64().unwrap();
    assert!(x > west && x < west + 17.0, "{x}");
    folder.refuses("map wall.asc --ground 0 --uavs sites.csv --json", "E206", &[]);
    // 9: longitude and latitude exchanged.
    folder.write("swapped.csv", "lon,lat,h\n48.10005,11.5001,30\n");
    folder.refuses(
        "map degrees.geojson --project auto --uavs swapped.csv --json",
        "E206",
        &["exchanged, they lie in it"],
    );
}

#[test]
fn rows_10_to_13_of_heights() {
    let folder = folder();
    let top =
        |line: &str| folder.type_in(&format!("info {line} --json")).done().json()["surface_m"][1].as_f64().unwrap();
    // 10: feet, by the number or for all.
    folder.write("feet.geojson", &footprints("EPSG:25832", &building(r#""height": "40 ft""#, SQUARE)));
    assert!((top("feet.geojson") - 12.192).abs() < 1.0 / 1024.0);
    assert!((top("city.geojson --height-unit ft") - 3.048).abs() < 1.0 / 1024.0);
    // 11: what a height is above is said by its suffix.
    let of = |height: &str| mapped(&folder, &format!("wall.asc --ground 0 --uav 10.5,5.5,{height}")).0;
    for (height, z) in [("30", 30.0), ("30roof", 40.0), ("30amsl", 30.0)] {
        let found = of(height)["sites"][0]["height_amsl_m"].as_f64().unwrap();
        assert!((found - z).abs() < 1e-9, "{height}: {found}");
    }
    // 12, 13: a height below 0 is none; those that are missing are left out, counted; or refused, or guessed, as asked.
    let bad = [building(r#""height": -3"#, SQUARE), building(r#""building:levels": 2"#, SQUARE)].join(",");
    folder.write("bad.geojson", &footprints("EPSG:25832", &[bad, building(r#""height": 10"#, SQUARE)].join(",")));
    let faults = folder.type_in("info bad.geojson --json").done().json()["faults"].clone();
    assert_eq!((&faults["negative_height"], &faults["missing_height"]), (&Value::from(0), &Value::from(2)));
    folder.refuses("info bad.geojson --missing fail", "E309", &[]);
}

#[test]
fn rows_14_to_19_of_shapes() {
    let folder = folder();
    let info = |name: &str, features: &str| {
        folder.write(name, &footprints("EPSG:25832", features));
        folder.type_in(&format!("info {name} --extent 0,0,40,40 --cell 1 --json")).done().json()
    };
    // 14: a bow tie is two triangles. 15: points twice. 16: a hole is open ground, however it is wound.
    let tie = building(r#""height": 5"#, "[[0, 0], [20, 20], [20, 0], [0, 20], [0, 0]]");
    let found = info("tie.geojson", &tie);
    assert_eq!(found["faults"]["repaired"], 1);
    // Two triangles of base 20 and height 10: the cells whose centers are inside, without those on the diagonals.
    assert_eq!(found["cells"]["building"], 180);
    let twice = building(r#""height": 5"#, "[[0, 0], [10, 0], [10, 0], [10, 10], [0, 10], [0, 0], [0, 0]]");
    assert_eq!(info("twice.geojson", &twice)["cells"]["building"], 100);
    for hole in ["[[2, 2], [2, 8], [8, 8], [8, 2], [2, 2]]", "[[2, 2], [8, 2], [8, 8], [2, 8], [2, 2]]"] {
        let court = building(r#""height": 5"#, &format!("[[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]], {hole}"));
        assert_eq!(info("court.geojson", &court)["cells"]["building"], 100 - 36);
    }
    // 17: where footprints overlap the higher counts. 18: crossing and nearly equal edges are no failure.
    let over = [building(r#""height": 5"#, SQUARE), building(r#""height": 9"#, SQUARE)].join(",");
    assert_eq!(info("over.geojson", &over)["surface_m"][1], 9.0);
    let sliver = building(r#""height": 5"#, "[[0, 0], [20, 0.0004], [20, 0.0011], [0, 0.0001], [5, 12], [0, 0]]");
    info("sliver.geojson", &sliver);
    // 19: the same city far from the origin has the same mask.
    let at = |x: f64, y: f64| {
        let ring = |w: f64, s: f64| {
            format!("[[{w}, {s}], [{}, {s}], [{}, {}], [{w}, {}], [{w}, {s}]]", w + 4.25, w + 4.25, s + 4.5, s + 4.5)
        };
        let both = [
            building(r#""height": 10"#, &ring(x + 10.0, y + 10.0)),
            building(r#""height": 7"#, &ring(x + 20.0, y + 12.0)),
        ];
        folder.write("far.geojson", &footprints("EPSG:25832", &both.join(",")));
        let (e, n) = (x + 40.0, y + 40.0);
        let line = format!("far.geojson --extent {x},{y},{e},{n} --uav {},{},25", x + 5.0, y + 5.0);
        mapped(&folder, &line).0["digest"].clone()
    };
    assert_eq!(at(0.0, 0.0), at(691_000.0, 5_334_000.0));
}

#[test]
fn rows_20_to_25_of_uavs_and_receivers() {
    let folder = folder();
    // 20: outside the raster nothing is known and nothing lies: only a height above the datum places a UAV there, unless the
    // ground was typed, which holds everywhere.
    folder.refuses("map wall.asc --uav 50,10,30 --json", "E204", &["30amsl"]);
    mapped(&folder, "wall.asc --uav 50,10,30amsl");
    mapped(&folder, "wall.asc --ground 0 --uav 50,10,30");
    folder.refuses(
        "map wall.asc --ground 4 --uav 50,10,3amsl --json",
        "E202",
        &["the lowest height in the clear is `0agl`"],
    );
    // 21: inside a building, with what to ask instead: of footprints in `cli`, of a raster here.
    folder.refuses("map wall.asc --ground 0 --uav 10.5,10.5,5 --json", "E201", &["roof at 10 m", "`5roof`"]);
    // 22: a cell under a building is no receiver.
    let (map, _) = mapped(&folder, "wall.asc --ground 0 --uav 1.5,10.5,30");
    assert_eq!(count(&map, "/sites/0/receivers"), 380);
    // 23: a UAV on the edges and corners of cells, and exactly as high as a roof, has an answer; two that touch agree with
    // rays (the suites `adversarial` and `stress` hold the rest).
    for place in ["10,10", "11,10", "0,0", "20,20"] {
        for height in ["10", "10.0009765625", "30"] {
            let of = |method: &str| {
                let line = format!("wall.asc --ground 0 --uav {place},{height}amsl --method {method}");
                mapped(&folder, &line).0["digest"].clone()
            };
            assert_eq!(of("sweep"), of("ray"), "{place} {height}");
        }
    }
    // 24: straight above a receiver is LoS; below the ground is refused, in `cli`.
    let link = folder.type_in("link wall.asc --ground 0 --uav 5.5,5.5,30 --rx 5.5,5.5,1.5 --json").done().json();
    assert_eq!(link["los"], true);
    // 25: numbers that are none are in `cli`, but for infinities.
    folder.refuses("map wall.asc --ground 0 --uav 5.5,5.5,30 --json --radius inf", "E101", &["'inf' for '--radius"]);
}

#[test]
fn rows_26_to_32_of_grids_limits_and_results() {
    let folder = folder();
    // 26: cells that are not square keep their shape; 27: rotated rasters and rasters south-up are in `bad_inputs`.
    folder.write("wide.asc", "ncols 4\nnrows 2\nxllcorner 0\nyllcorner 0\ndx 2\ndy 5\n0 0 9 0\n0 0 9 0\n");
    let wide = folder.type_in("info wide.asc --ground 0 --json").done().json();
    assert_eq!(wide["cell_m"], serde_json::json!([2.0, 5.0]));
    // 28: heights beyond what is proven are refused, in `cli`; those within see what they must.
    let los = |height: &str| {
        count(&mapped(&folder, &format!("wall.asc --ground 0 --uav 5.5,5.5,{height}")).0, "/sites/0/los")
    };
    assert!(los("30") <= los("300") && los("300") <= los("30000") && los("30000") == 380);
    // 29: that an existing file stays is in `cli`. 30: interrupts are in `cli`, `cli_chart` and `signals`.
    // 31: zones without a cell are in `cli_zones`. 32: too few clusters for an interval are in `cli_plos`.
}
