//! What was mended or left out while reading footprints: a row for each thing, as many as warnings and documents count.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::program::Folder;

/// Squares and other shapes, each with one fault or more, and one without any.
const CITY: &str = r#"{"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "EPSG:25832"}},
"features": [
 {"type": "Feature", "id": "whole", "properties": {"height": 9}, "geometry": {"type": "Polygon", "coordinates":
  [[[0, 0], [5, 0], [5, 5], [0, 5], [0, 0]]]}},
 {"type": "Feature", "id": "tie", "properties": {"height": 5}, "geometry": {"type": "MultiPolygon", "coordinates":
  [[[[10, 0], [15, 0], [15, 5], [10, 0]]], [[[20, 0], [40, 20], [40, 0], [20, 20], [20, 0]]]]}},
 {"type": "Feature", "id": "bench", "properties": {}, "geometry": {"type": "Point", "coordinates": [3, 3]}},
 {"type": "Feature", "properties": {"height": "4,5", "building:part": "yes"}, "geometry": {"type": "Polygon",
  "coordinates": [[[50, 0], [55, 0], [55, 5], [50, 5]]]}},
 {"type": "Feature", "id": "line", "properties": {"height": 5}, "geometry": {"type": "Polygon", "coordinates":
  [[[0, 30], [5, 30], [9, 30], [0, 30]]]}},
 {"type": "Feature", "id": "low", "properties": {"height": -2}, "geometry": {"type": "Polygon", "coordinates":
  [[[10, 30], [15, 30], [15, 35], [10, 35], [10, 30]]]}},
 {"type": "Feature", "id": "guess", "properties": {"building:levels": "2"}, "geometry": {"type": "Polygon",
  "coordinates": [[[20, 30], [25, 30], [25, 35], [20, 35], [20, 30]]]}},
 {"type": "Feature", "id": "blank", "properties": {"height": "tall"}, "geometry": {"type": "Polygon", "coordinates":
  [[[30, 30], [35, 30], [35, 35], [30, 35], [30, 30]]]}},
 {"type": "Feature", "id": "gone", "properties": {"height": 5, "building": "demolished"}, "geometry": {"type":
  "Polygon", "coordinates": [[[40, 30], [45, 30], [45, 35], [40, 35], [40, 30]]]}},
 {"type": "Feature", "id": "bridge", "properties": {"height": 5, "min_height": 3}, "geometry": {"type": "Polygon",
  "coordinates": [[[50, 30], [55, 30], [55, 35], [50, 35], [50, 30]]]}}
]}"#;

/// Feature, id, fault, code, what was done, x and y: by hand from the file above, with `--missing levels`.
const ROWS: [[&str; 7]; 11] = [
    ["2", "tie", "self-intersection", "W351", "repaired by the even-odd rule", "20", "0"],
    ["3", "bench", "not-an-area", "W350", "left out", "", ""],
    ["4", "4", "unclosed-ring", "W352", "closed", "50", "0"],
    ["4", "4", "decimal-comma", "W356", "the comma is read as a point", "50", "0"],
    ["5", "line", "too-small", "W353", "left out", "0", "30"],
    ["6", "low", "missing-height", "W354", "left out", "10", "30"],
    ["7", "guess", "missing-height", "W354", "given a height by storeys", "20", "30"],
    ["7", "guess", "height-from-levels", "W364", "3 m for each", "20", "30"],
    ["8", "blank", "missing-height", "W354", "left out", "30", "30"],
    ["9", "gone", "not-a-building", "W361", "left out", "40", "30"],
    ["10", "bridge", "floating", "W362", "taken as solid from the ground up", "50", "30"],
];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("city.geojson", CITY);
    folder
}

/// The rows of a table, without the layer, which must be the file's name.
fn rows(table: &str) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let names: Vec<&str> = vec!["feature", "id", "layer", "fault", "code", "done", "x", "y"];
    assert_eq!(reader.headers().unwrap().iter().collect::<Vec<_>>(), names);
    let row = |record: csv::StringRecord| {
        assert_eq!(&record[2], "city");
        record.iter().enumerate().filter(|(k, _)| *k != 2).map(|(_, field)| field.to_string()).collect()
    };
    reader.records().map(|record| row(record.unwrap())).collect()
}

/// The number at the beginning of what a warning counts, by its code.
fn told(document: &Value) -> BTreeMap<String, usize> {
    let count = |warning: &Value| {
        let text = warning["text"].as_str()?.strip_prefix("city.geojson: ")?;
        let n = text.split(' ').next()?.parse().ok()?;
        Some((warning["code"].as_str()?.to_string(), n))
    };
    document["warnings"].as_array().unwrap().iter().filter_map(count).collect()
}

#[test]
fn every_thing_mended_or_left_out_is_listed_once() {
    let folder = folder();
    let info = folder.type_in("info city.geojson --missing levels --repairs mended.csv --json -q").done().json();
    let found = rows(&folder.text("mended.csv"));
    assert_eq!(found, ROWS);

    // As many rows of each code as the warning of that code counts, and as many in all as the document counts.
    let mut by_code = BTreeMap::new();
    found.iter().for_each(|row| *by_code.entry(row[3].clone()).or_insert(0) += 1);
    assert_eq!(by_code, told(&info));
    let faults: u64 = info["faults"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum();
    assert_eq!(faults, found.len() as u64);

    // The table says where it comes from.
    let beside = folder.json("mended.csv.json");
    assert_eq!(beside["schema"], "skyshed/repairs/1");
    assert_eq!(beside["scene"]["sources"], info["sources"]);
    assert_eq!(beside["repairs"], 11);
    assert_eq!(beside["command"], info["command"]);
}

#[test]
fn points_of_repairs_hold_what_the_table_holds() {
    let folder = folder();
    folder.type_in("info city.geojson --repairs mended.csv -q").done();
    folder.type_in("info city.geojson --repairs mended.geojson -q -j 1").done();
    let points = folder.json("mended.geojson");
    assert_eq!(points["crs"]["properties"]["name"], "urn:ogc:def:crs:EPSG::25832");
    assert_eq!(points["skyshed"]["schema"], "skyshed/repairs/1");
    let of_points: Vec<Vec<String>> = points["features"].as_array().unwrap().iter().map(row_of).collect();
    assert_eq!(of_points, rows(&folder.text("mended.csv")));
    // A point without an area has no place: null, and nothing that looks like one.
    assert_eq!(points["features"][1]["geometry"], Value::Null);
}

fn row_of(feature: &Value) -> Vec<String> {
    let property = |name: &str| feature["properties"][name].as_str().unwrap().to_string();
    let at = |k: usize| feature["geometry"]["coordinates"][k].as_f64().map_or(String::new(), |v| v.to_string());
    let number = feature["properties"]["feature"].as_u64().unwrap().to_string();
    vec![number, property("id"), property("fault"), property("code"), property("done"), at(0), at(1)]
}

#[test]
fn places_of_repairs_are_in_the_system_of_the_scene() {
    let folder = Folder::new();
    // One bow tie in degrees, of houses and of what is none.
    let tie = json!([[[11.58, 48.14], [11.581, 48.141], [11.581, 48.14], [11.58, 48.141], [11.58, 48.14]]]);
    let features = [json!({"height": 5}), json!({"building": "no"}), json!({"height": 7})].map(|properties| {
        json!({"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": tie}})
    });
    folder.write("city.geojson", &json!({"type": "FeatureCollection", "features": features}).to_string());
    folder.type_in("info city.geojson --project EPSG:25832 --repairs mended.csv -q").done();
    let found = rows(&folder.text("mended.csv"));
    let words: Vec<&str> = found.iter().map(|row| row[2].as_str()).collect();
    assert_eq!(words, ["self-intersection", "not-a-building", "self-intersection"]);
    // What is left out is brought over as what is not.
    assert_eq!(found[0][5..], found[1][5..]);
    // Zone 32 of UTM has its central meridian at 9° and false easting 500 km: 2.58° east of it is 192 km at this
    // latitude (cos 48.14° · 111.3 km per degree · 0.9996, to a few hundred meters).
    let x: f64 = found[0][5].parse().unwrap();
    assert!((x - 692_000.0).abs() < 1000.0, "{x}");
}

#[test]
fn every_command_that_reads_footprints_lists_repairs() {
    let folder = folder();
    let lines = [
        "map city.geojson --uav 8,20,50 -o map.json",
        "link city.geojson --uav 8,20,50 --rx 9,9",
        "city city.geojson -o again.geojson",
        "info city.geojson",
        "stress city.geojson --uav 8,20,50",
        "place city.geojson --height 50 --step 30",
        "compare city.geojson --uav 8,20,50 --uav 9,20,50",
        "plos city.geojson --method maps --theta 45 --height 50 --positions 2",
    ];
    folder.type_in("info city.geojson --missing drop --repairs expected.csv -q").done();
    let expected = folder.text("expected.csv");
    for (k, line) in lines.iter().enumerate() {
        let file = format!("mended_{k}.csv");
        let said = folder.type_in(&format!("{line} --missing drop --repairs {file}")).done().err;
        assert_eq!(folder.text(&file), expected, "{line}");
        assert!(said.contains("10 things") && said.contains(&format!("{file}, {file}.json")), "{line}: {said}");
    }
}

#[test]
fn a_list_of_repairs_is_refused_where_there_is_none() {
    let folder = folder();
    folder.write("wall.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n");
    folder.write("kept.csv", "mine");
    let before = folder.files();
    for (line, code) in [
        ("info wall.asc --repairs a.csv", "E116"),
        ("info itu:urban --repairs a.csv", "E116"),
        ("plos itu:urban --theta 45 --repairs a.csv", "E116"),
        ("stress --scenes 1 --repairs a.csv", "E116"),
        ("info city.geojson --repairs a.json", "E105"),
        ("info city.geojson --repairs city.geojson --overwrite", "E105"),
        ("info city.geojson --repairs kept.csv", "E106"),
        // Two outputs of one name, before any work.
        ("map city.geojson --uav 8,20,50 -o same.csv --repairs ./same.csv --overwrite", "E105"),
        // A run that fails leaves no list.
        ("map city.geojson --missing drop --uav 2,2,5 -o a.png --repairs a.csv", "E201"),
    ] {
        folder.refuses(line, code, &[]);
        assert_eq!(folder.files(), before, "{line}");
    }
    folder.type_in("info city.geojson --repairs kept.csv --overwrite -q").done();
    assert!(folder.text("kept.csv").starts_with("feature,id,layer"));
}
