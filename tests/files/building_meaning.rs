//! What files of buildings mean: missing heights, parts, what is not there, heights above the datum. Against answers that were found by hand or by
//! another program, and a reference in Python that reads the definitions alone.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};
use skyshed_core::raster::GeoRef;
use skyshed_io::formats::RasterFile;

use crate::needs::{has_program, python_with, truth};
use crate::program::{Answer, Folder};
use crate::support::{Random, is_long};

/// A feature over a rectangle: west, south, east, north.
pub(crate) fn rectangle(id: &str, [west, south, east, north]: [f64; 4], properties: &Value) -> Value {
    let ring = [[west, south], [east, south], [east, north], [west, north], [west, south]];
    json!({"type": "Feature", "id": id, "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}})
}

pub(crate) fn collection(features: &[Value]) -> String {
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}});
    json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string()
}

/// Heights of cells, row by row from the north.
pub(crate) fn cells(folder: &Folder, line: &str) -> Vec<f64> {
    folder.type_in(&format!("city {line} -o cells.asc --overwrite -q")).done();
    let text = folder.text("cells.asc");
    let rows = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit() || c == '-'));
    rows.flat_map(|row| row.split_whitespace().map(|word| word.parse().unwrap()).collect::<Vec<f64>>()).collect()
}

pub(crate) fn n_of(cells: &[f64], height: f64) -> usize {
    cells.iter().filter(|z| (**z - height).abs() < 1e-3).count()
}

fn p_los(answer: &Answer) -> f64 {
    answer.json()["union"]["p_los"].as_f64().unwrap()
}

/// A tower of 20 m on a podium of 60 m, as OpenStreetMap has them: the outline is as high as the tower.
#[test]
fn parts_stand_in_place_of_their_outline() {
    let folder = Folder::new();
    let (whole, tower) = ([0.0, 0.0, 60.0, 60.0], [20.0, 20.0, 40.0, 40.0]);
    let outline = |height: f64| rectangle("way/1", whole, &json!({"building": "yes", "height": height}));
    let part =
        |id: &str, at: [f64; 4], height: f64| rectangle(id, at, &json!({"building:part": "yes", "height": height}));
    let extent = "--extent 0,0,60,60 --data-area all";
    folder.write("a.geojson", &collection(&[outline(100.0), part("2", whole, 20.0), part("3", tower, 100.0)]));
    let found = cells(&folder, &format!("a.geojson {extent}"));
    assert_eq!((n_of(&found, 20.0), n_of(&found, 100.0)), (3200, 400));
    let joined = cells(&folder, &format!("a.geojson {extent} --parts join"));
    assert_eq!(n_of(&joined, 100.0), 3600);
    // One building, as high as its parts in the mean: (3600 · 20 + 400 · 100)/4000.
    let info = folder.type_in(&format!("info a.geojson {extent} --json -q")).done().json();
    assert_eq!((&info["faults"]["parts"], &info["height_sources"][0]["footprints"]), (&json!(1), &json!(2)));
    let gamma = info["estimated_built_up"]["gamma_m"].as_f64();
    assert!(gamma.is_none() || (gamma.unwrap() - 28.0 / 2.0_f64.sqrt()).abs() < 1e-9, "{info}");
    // A tower alone is drawn: the rest is as high as the lowest part, or as the outline where that is lower.
    folder.write("a.geojson", &collection(&[outline(100.0), part("3", tower, 100.0)]));
    assert_eq!(n_of(&cells(&folder, &format!("a.geojson {extent}")), 100.0), 3600);
    folder.write("a.geojson", &collection(&[outline(30.0), part("3", tower, 100.0)]));
    let found = cells(&folder, &format!("a.geojson {extent}"));
    assert_eq!((n_of(&found, 30.0), n_of(&found, 100.0)), (3200, 400));
    let answer = folder.type_in(&format!("info a.geojson {extent}")).done();
    assert_eq!(answer.warnings(), ["W363"], "{answer:?}");
    // Parts without heights have their storeys, or those of the outline; an outline that they replace misses nothing.
    let levels = |n: u32| json!({"building": "yes", "building:levels": n});
    folder.write(
        "a.geojson",
        &collection(&[
            rectangle("way/1", whole, &levels(4)),
            rectangle("2", [0.0, 0.0, 30.0, 60.0], &json!({"building:part": "yes", "building:levels": 9})),
            rectangle("3", [30.0, 0.0, 60.0, 60.0], &json!({"building:part": "yes"})),
        ]),
    );
    let found = cells(&folder, &format!("a.geojson {extent} --missing levels"));
    assert_eq!((n_of(&found, 27.0), n_of(&found, 12.0)), (1800, 1800));
}

#[test]
fn missing_heights_are_told_and_a_list_gives_them() {
    let folder = Folder::new();
    let house = |k: usize, properties: Value| {
        let (x, y) = (f64::from(u32::try_from(k % 6).unwrap()) * 20.0, f64::from(u32::try_from(k / 6).unwrap()) * 20.0);
        rectangle(&format!("h{k}"), [x, y, x + 10.0, y + 10.0], &properties)
    };
    // None of these is a height: they are no holes in the city.
    for none in [json!(-1), json!(-9999.0), json!(""), json!("unknown"), Value::Null, json!("-1")] {
        let houses: Vec<Value> =
            (0..12).map(|k| house(k, json!({"height": if k % 2 == 0 { json!(12) } else { none.clone() }}))).collect();
        folder.write("a.geojson", &collection(&houses));
        let line = "map a.geojson --uav 50,50,60 --json -q";
        folder.refuses(line, "E309", &["6 of 12"]);
        folder.refuses(&format!("{line} --missing fail"), "E309", &["h1"]);
        let found = cells(&folder, "a.geojson --missing median");
        assert_eq!(n_of(&found, 12.0), 1200, "{none}");
        let answer = folder.type_in("map a.geojson --uav 50,50,60 --json --missing drop").done();
        assert!(answer.warnings().contains(&"W354"), "{answer:?}");
    }
    // Storeys, then the median of heights that were read, the lower of two in the middle: 10 of 10 and 30.
    let heights = [
        json!({"height": 10}),
        json!({"height": 30}),
        json!({"building:levels": 2}),
        json!({"num_floors": "5"}),
        json!({}),
    ];
    let houses: Vec<Value> = heights.iter().enumerate().map(|(k, of)| house(k, of.clone())).collect();
    folder.write("b.geojson", &collection(&houses));
    for (list, wanted) in [
        ("levels,median", [10.0, 30.0, 6.0, 15.0, 10.0]),
        ("median", [10.0, 30.0, 10.0, 10.0, 10.0]),
        ("levels,9", [10.0, 30.0, 6.0, 15.0, 9.0]),
        ("7.5", [10.0, 30.0, 7.5, 7.5, 7.5]),
        ("levels,drop", [10.0, 30.0, 6.0, 15.0, 0.0]),
    ] {
        let found = cells(&folder, &format!("b.geojson --missing {list} --extent 0,0,100,10 --data-area all"));
        let at = |k: usize| found[20 * k + 5];
        assert_eq!([0, 1, 2, 3, 4].map(|k| at(k).to_bits()), wanted.map(f64::to_bits), "{list}");
    }
    folder.refuses("info b.geojson --missing 9,median", "E101", &["after a number"]);
    folder.refuses("info b.geojson --missing drop,levels", "E101", &["as the last"]);
    // A list that leaves a fifth without a height obeys the guard; a property that no feature has is needed where the list may give none.
    folder.refuses("map b.geojson --missing levels --uav 50,50,60 -o a.png", "E309", &["1 of 5"]);
    folder.refuses("info b.geojson --missing levels,median --height-field tall", "E365", &["`tall`"]);
    folder.type_in("info b.geojson --missing 9 --height-field tall").done();
    let info = folder.type_in("info b.geojson --missing levels,median --json -q").done().json();
    let sources: Vec<(&str, u64)> = info["height_sources"]
        .as_array()
        .unwrap()
        .iter()
        .map(|of| (of["source"].as_str().unwrap(), of["footprints"].as_u64().unwrap()))
        .collect();
    assert_eq!(sources, [("file", 2), ("storeys", 2), ("median", 1)]);
}

#[test]
fn what_is_not_there_is_left_out_and_counted() {
    let folder = Folder::new();
    let on = |k: u32, properties: Value| {
        rectangle(&k.to_string(), [f64::from(20 * k), 0.0, f64::from(20 * k + 10), 10.0], &properties)
    };
    let features = [
        on(0, json!({"building": "yes", "height": 15})),
        on(1, json!({"building": "apartments", "height": 15})),
        on(2, json!({"leisure": "park"})),
        on(3, json!({"barrier": "wall", "height": 2})),
        on(4, json!({"demolished:building": "yes", "height": 20})),
        on(5, json!({"building": "no", "height": 9})),
        on(6, json!({"building": "garage", "location": "underground", "height": 8})),
        on(7, json!({"is_underground": true, "height": 8})),
        on(8, json!({"amenity": "parking"})),
        on(9, json!({"amenity": "school", "height": 11})),
        on(10, json!({"building": "yes", "height": 0})),
    ];
    folder.write("a.geojson", &collection(&features));
    let found = cells(&folder, "a.geojson --missing median --extent 0,0,220,10 --data-area all");
    assert_eq!((n_of(&found, 15.0), n_of(&found, 11.0), n_of(&found, 0.0)), (200, 100, 1900));
    let answer = folder.type_in("info a.geojson --missing median --json").done();
    assert_eq!(answer.json()["faults"]["not_buildings"], 8);
    assert_eq!(answer.warnings().iter().filter(|code| **code == "W361").count(), 1, "{answer:?}");
    // Names in a column `building` are no tags.
    let cadastre = [
        on(0, json!({"building": "Villa Rosa", "height": 15})),
        on(1, json!({"building": null, "height": 15, "landuse": "residential"})),
        on(2, json!({"height": 15, "natural": "none"})),
    ];
    folder.write("b.geojson", &collection(&cadastre));
    assert_eq!(n_of(&cells(&folder, "b.geojson"), 15.0), 300);
}

#[test]
fn tops_above_the_datum_stand_on_the_ground_of_their_file() {
    let folder = Folder::new();
    let on = |k: u32, properties: Value| {
        rectangle(&k.to_string(), [f64::from(40 * k), 0.0, f64::from(40 * k + 20), 20.0], &properties)
    };
    let features = [
        on(0, json!({"top": -2.0, "b3_h_maaiveld": -6.5})),
        on(1, json!({"top": 3.1, "b3_h_maaiveld": -6.4})),
        on(2, json!({"top": 1.5, "b3_h_maaiveld": -6.0})),
        on(3, json!({"top": -7.0, "b3_h_maaiveld": -9.0})),
    ];
    folder.write("a.geojson", &collection(&features));
    let extent = "--extent 0,0,160,20 --data-area all";
    // The lower middle of four: -6.5. One top is below.
    let answer = folder.type_in(&format!("info a.geojson --top-field top {extent} --json")).done();
    let info = answer.json();
    assert_eq!((&info["ground_m"], &info["faults"]["below_ground"]), (&json!([-6.5, -6.5]), &json!(1)));
    assert_eq!(answer.warnings(), ["W366", "W382"], "{answer:?}");
    let found = cells(&folder, &format!("a.geojson --top-field top {extent}"));
    assert_eq!(found.iter().filter(|z| **z > -6.4).count(), 1200);
    // Through all grounds each stands on its own, and the ground goes on beyond them.
    let info =
        folder.type_in(&format!("info a.geojson --top-field top --ground buildings {extent} --json -q")).done().json();
    assert_eq!((&info["ground_m"], &info["faults"]["below_ground"]), (&json!([-9.0, -6.0]), &json!(0)));
    // Between the first and the second it rises by 0.1 m over 20 m.
    let found = cells(&folder, &format!("a.geojson --top-field top --ground buildings {extent}"));
    assert!((found[10 * 160 + 29] - (-6.5 + 0.1 * 9.5 / 20.0)).abs() < 2e-3, "{}", found[10 * 160 + 29]);
    let other = [on(0, json!({"top": 9.0, "foot": 2.0})), on(1, json!({"top": 12.0, "foot": 4.0}))];
    folder.write("b.geojson", &collection(&other));
    folder.refuses("info b.geojson --top-field top", "E365", &["`top`"]);
    folder.refuses("info b.geojson --top-field top --base-field base", "E365", &["`base`"]);
    let info = folder.type_in("info b.geojson --top-field top --base-field foot --json -q").done().json();
    assert_eq!(info["ground_m"], json!([2.0, 2.0]));
    folder.refuses("info b.geojson --height-field top --base-field foot", "E116", &["`--base-field`"]);
    let info = folder.type_in("info b.geojson --top-field top --ground 1 --json -q").done().json();
    assert_eq!(info["ground_m"], json!([1.0, 1.0]));
}

/// Files that others were read wrongly from, with the answers that their folders tell.
#[test]
fn files_that_were_read_wrongly_give_the_right_answer() {
    let Some(data) = truth() else { return };
    let folder = Folder::new();
    let file = |name: &str| data.join(name).display().to_string();
    let cases = |name: &str| file(&format!("cases/{name}"));
    let extent = "--extent 500000,5000000,500150,5000100";
    for name in ["osm", "overture"] {
        let line = format!(
            "link {} {extent} --uav 500045,5000090,40 --rx 500045,5000005,1.5 --json -q",
            cases(&format!("02-outline-over-parts/{name}.geojson"))
        );
        let link = folder.type_in(&line).json();
        assert!((link["margin_m"].as_f64().unwrap() + 14.2).abs() < 0.05, "{name}: {link}");
    }
    let minus = cases("03-height-minus-one/minus1.geojson");
    folder.refuses(&format!("map {minus} --uav 500130,5000130,60"), "E309", &[]);
    let as_text = cases("03-height-minus-one/minus1txt.geojson");
    folder.refuses(&format!("map {as_text} --uav 500130,5000130,60"), "E309", &[]);
    // As where nothing stands for them.
    let shares = [minus, cases("03-height-minus-one/null.geojson")].map(|file| {
        p_los(&folder.type_in(&format!("map {file} --uav 500130,5000130,60 --missing median --json -q")).done())
    });
    assert!((shares[0] - 0.7059).abs() < 5e-5 && (shares[0] - shares[1]).abs() < 1e-12, "{shares:?}");
    let polder = format!("{} --top-field b3_h_dak_max", cases("11-polder/polder.geojson"));
    let info = folder.type_in(&format!("info {polder} --json -q")).done().json();
    assert_eq!(info["cells"]["building"], 400);
    let link = folder.type_in(&format!("link {polder} --uav 100000,445000,10 --rx 100060,445000,1.5 --json -q"));
    assert_eq!(link.json()["los"], false);
    for name in ["osm_underground", "overture_underground"] {
        let line = format!(
            "link {} {extent} --uav 500045,5000090,40 --rx 500045,5000005,1.5 --json -q",
            cases(&format!("12-underground/{name}.geojson"))
        );
        assert_eq!(folder.type_in(&line).json()["los"], true, "{name}");
    }
    let mixed = cases("22-mixed-osm/a.geojson");
    let info = folder.type_in(&format!("info {mixed} --missing median --json -q")).done().json();
    // Six houses, one that is built, and a part without an outline.
    assert_eq!(info["buildings"], 8, "{info}");
    let line = format!("link {mixed} --missing median --uav 500095,5000032,40 --rx 500095,5000080,1.5 --json -q");
    folder.type_in(&line).json();
    let nested = folder.type_in(&format!("info {} --json -q", cases("09-nested-tags/a.geojson"))).done().json();
    assert_eq!((&nested["buildings"], &nested["surface_m"]), (&json!(1), &json!([12.0, 12.0])), "{nested}");

    let meaning = |name: &str| file(&format!("formats/meaning/{name}"));
    let uav = "--uav 691549.7,5334762.2,60 --json -q";
    folder.refuses(&format!("map {} {uav}", meaning("munich_ms_minus1.geojson")), "E309", &[]);
    folder.refuses(&format!("map {} {uav} --missing fail", meaning("munich_ms_minus1.geojson")), "E309", &[]);
    // The same receivers have the same share, whatever is read around them.
    let near =
        "--extent 691450,5334700,691550,5334800 --uav 691500,5334750,120 --data-area all --missing median --json -q";
    let shares = ["75", "300"].map(|r| {
        let rows = folder
            .type_in(&format!(
                "map {} {near} --radius {r} --layers los -o a.csv --overwrite",
                meaning("munich_osm_like.geojson")
            ))
            .done();
        rows.json()["sites"][0]["los"].as_u64()
    });
    assert!(shares[0].is_some() && shares[0] == shares[1], "{shares:?}");
    let heights = ["75", "300"].map(|r| {
        let line = format!("map {} {near} --radius {r} -o a.tif --overwrite", meaning("munich_osm_like.geojson"));
        folder.type_in(&line).done().json()["warnings"].clone()
    });
    assert_eq!(heights[0], heights[1]);
    let podium = |name: &str| cells(&folder, &format!("{} --extent 0,0,60,60 --data-area all", meaning(name)));
    assert_eq!(podium("podium.geojson"), podium("podium_parts_only.geojson"));
    let overture = format!("{} --project auto --data-area all", meaning("ov_parts.geojson"));
    let found = cells(&folder, &overture);
    // A podium of some 74 × 67 m, and a tower of 15 × 22 m on it; what is underground is not there.
    let (podium, tower) = (n_of(&found, 20.0), n_of(&found, 100.0));
    assert!((4500..4800).contains(&podium) && (310..350).contains(&tower), "{podium} and {tower}");
    let underground = |name: &str| cells(&folder, &format!("{} --extent 0,0,100,60 --data-area all", meaning(name)));
    assert_eq!(underground("underground.geojson"), underground("underground_none.geojson"));
}

/// A random file of houses, some of parts, tagged by people.
fn random_file(random: &mut Random) -> String {
    let mut features = Vec::new();
    let meters =
        |random: &mut Random, most: usize| f64::from(u32::try_from(random.below(most * 10)).unwrap()) / 10.0 + 0.03;
    for k in 0..5 + random.below(12) {
        let (x, y) = (meters(random, 50), meters(random, 50));
        let (w, h) = (2.0 + meters(random, 14), 2.0 + meters(random, 14));
        let mut tags = serde_json::Map::new();
        let height = |random: &mut Random| {
            let heights = [
                json!(7),
                json!("12 m"),
                json!("40 ft"),
                json!(-1),
                Value::Null,
                json!(""),
                json!("tall"),
                json!(21.5),
                json!(4),
                json!(0),
            ];
            heights[random.below(heights.len())].clone()
        };
        let say = |tags: &mut serde_json::Map<String, Value>, random: &mut Random| {
            if random.below(4) > 0 {
                tags.insert("height".into(), height(random));
            }
            if random.below(3) == 0 {
                let name = random.choose(&[
                    "building:levels",
                    "num_floors",
                    "storeysAboveGround",
                    "numberOfFloorsAboveGround",
                ]);
                tags.insert(name.into(), json!(1 + random.below(9)));
            }
            if random.below(9) == 0 {
                tags.insert("roof:levels".into(), json!(1));
            }
        };
        say(&mut tags, random);
        match random.below(12) {
            0 => drop(tags.insert("leisure".into(), json!("park"))),
            1 => drop(tags.insert("demolished:building".into(), json!("yes"))),
            2 => {
                tags.insert("building".into(), json!("garage"));
                tags.insert("location".into(), json!("underground"));
            }
            3 => drop(tags.insert("amenity".into(), json!("parking"))),
            4 => {}
            _ => drop(
                tags.insert("building".into(), json!(random.choose(&["yes", "house", "apartments", "retail", "no"]))),
            ),
        }
        let id = format!("f{k}");
        features.push(rectangle(&id, [x, y, x + w, y + h], &Value::Object(tags)));
        for part in 0..random.below(4).saturating_sub(1) {
            let (dx, dy) = (meters(random, 100) / 100.0 * w * 0.6, meters(random, 100) / 100.0 * h * 0.6);
            let mut tags = serde_json::Map::new();
            say(&mut tags, random);
            match random.below(3) {
                0 => drop(tags.insert("building_id".into(), json!(id))),
                _ => drop(tags.insert("building:part".into(), json!("yes"))),
            }
            let round = |v: f64| (v * 10.0).round() / 10.0 + 0.03;
            let at = [x + dx, y + dy, x + dx + 0.7 * w, y + dy + 0.7 * h].map(round);
            features.push(rectangle(&format!("f{k}p{part}"), at, &Value::Object(tags)));
        }
    }
    collection(&features)
}

#[test]
fn random_files_mean_what_a_reference_in_python_reads() {
    if !python_with("shapely") {
        return;
    }
    let (folder, mut random) = (Folder::new(), Random(56));
    let tool = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tools/building_heights.py");
    for round in 0..if is_long() { 200 } else { 25 } {
        folder.write("a.geojson", &random_file(&mut random));
        let list = random.choose(&["levels,median,drop", "median,drop", "levels,drop", "levels,9", "drop"]);
        let parts = random.choose(&["replace", "replace", "join"]);
        let found =
            cells(&folder, &format!("a.geojson --missing {list} --parts {parts} --extent 0,0,70,70 --data-area all"));
        let python = Command::new("python3")
            .arg(&tool)
            .arg(folder.word("a.geojson"))
            .args(["70", "1", list, parts])
            .output()
            .unwrap();
        assert!(python.status.success(), "{}", String::from_utf8_lossy(&python.stderr));
        let rows: Vec<Vec<f64>> = serde_json::from_slice(&python.stdout).unwrap();
        let differ = rows.concat().iter().zip(&found).filter(|(a, b)| (**a - **b).abs() > 2e-3).count();
        if differ > 0 {
            std::fs::copy(folder.word("a.geojson"), std::env::temp_dir().join("building_meaning.geojson")).unwrap();
        }
        assert_eq!((found.len(), differ), (4900, 0), "round {round}: --missing {list} --parts {parts}");
    }
}

/// The cells of a raster, and where they lie.
fn raster(folder: &Folder, name: &str) -> (GeoRef, Vec<f64>) {
    let file = RasterFile::open(folder.join(name), &mut Vec::new()).expect("a raster");
    let cells = file.read(file.georef().window(), &mut Vec::new(), |v| v).expect("its cells").into_cells().to_vec();
    (file.georef().clone(), cells)
}

/// Asserts that a part of a map says of each cell what the whole does, and returns how many cells that are; -1 is said of none.
fn assert_part(
    (place, cells): &(GeoRef, Vec<f64>),
    whole: &(GeoRef, Vec<f64>),
    is_asked: impl Fn(f64) -> bool,
    what: &str,
) -> usize {
    let n_cols = place.n_cols();
    let asked = cells.iter().enumerate().filter(|(_, value)| is_asked(**value));
    asked
        .map(|(k, value)| {
            let (x, y) = place.world_from_cell(k / n_cols, k % n_cols);
            let (row, col) = whole.0.cell_at(x, y).expect("a cell of the whole");
            assert_eq!(value.to_bits(), whole.1[row * whole.0.n_cols() + col].to_bits(), "{what}: at {x}, {y}");
        })
        .count()
}

/// Whatever is read of a file, each building is as high: near one UAV, near several, tile by tile.
#[test]
fn heights_do_not_hang_on_what_is_read_around_them() {
    let (folder, mut random) = (Folder::new(), Random(57));
    for round in 0..if is_long() { 60 } else { 4 } {
        folder.write("a.geojson", &random_file(&mut random));
        let list = random.choose(&["levels,median,drop", "median,drop", "levels,9"]);
        let sites: Vec<String> =
            (0..2).map(|_| format!("{},{},45amsl", 12 + random.below(36), 12 + random.below(36))).collect();
        folder.write("sites.csv", &format!("id,x,y,h\n1,{}\n2,{}\n", sites[0], sites[1]));
        // A file with an index gives what lies near alone.
        let mut files = vec!["a.geojson"];
        if has_program("ogr2ogr") {
            folder.remove(&["a.fgb".to_string()]);
            let made = Command::new("ogr2ogr").arg(folder.word("a.fgb")).arg(folder.word("a.geojson")).status();
            assert!(made.is_ok_and(|status| status.success()));
            files.push("a.fgb");
        }
        for file in files {
            let what = format!("round {round}: {file} --missing {list}");
            let scene = format!(
                "map {file} --missing {list} --extent 8,8,56,56 --data-area all --receivers all --overwrite -q"
            );
            for site in &sites {
                let line = format!("{scene} --layers los --uav {site}");
                folder.type_in(&format!("{line} -o whole.tif")).done();
                folder.type_in(&format!("{line} --radius 48 -o near.tif")).done();
                let (whole, near) = (raster(&folder, "whole.tif"), raster(&folder, "near.tif"));
                let n = assert_part(&near, &whole, |class| class < 2.0, &what);
                assert!(n > 100, "{what}: {n} cells in range");
            }
            let line = format!("{scene} --layers count --uavs sites.csv --radius 48");
            folder.type_in(&format!("{line} -o whole.tif")).done();
            folder.type_in(&format!("{line} --tile-size 16 -o t{{row}}-{{col}}.tif")).done();
            let whole = raster(&folder, "whole.tif");
            let tiles = folder.files().into_iter().filter(|name| name.starts_with('t') && name.ends_with(".tif"));
            let n: usize = tiles.map(|name| assert_part(&raster(&folder, &name), &whole, |_| true, &what)).sum();
            assert!(n >= 16 * 16, "{what}: {n} cells of tiles");
        }
    }
}

/// One reader would take the first value, another the last.
#[test]
fn a_member_that_is_given_twice_is_refused() {
    let folder = Folder::new();
    let square = "[[[691000,5334000],[691020,5334000],[691020,5334020],[691000,5334020],[691000,5334000]]]";
    let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::25832"}}"#;
    let city = |members: &str, properties: &str| {
        format!(
            r#"{{"type":"FeatureCollection",{members},"features":[{{"type":"Feature","properties":{{{properties}}},"geometry":{{"type":"Polygon","coordinates":{square}}}}}]}}"#
        )
    };
    folder.write("once.geojson", &city(crs, r#""height":9,"name":"a""#));
    folder.type_in("info once.geojson").done();
    for (text, name) in [
        (city(crs, r#""height":9,"name":"a","height":90"#), "height"),
        (city(&format!("{crs},{crs}"), r#""height":9"#), "crs"),
        (city(crs, r#""height":9,"tags":{"levels":"3","levels":"4"}"#), "levels"),
    ] {
        folder.write("twice.geojson", &text);
        folder.refuses("info twice.geojson", "E302", &[&format!("`{name}` is given twice at line 1 column")]);
    }
    let site =
        r#"{"type":"Feature","properties":{"h":50,"h":60},"geometry":{"type":"Point","coordinates":[691005,5334050]}}"#;
    folder.write("sites.geojson", &format!(r#"{{"type":"FeatureCollection",{crs},"features":[{site}]}}"#));
    folder.refuses("map once.geojson --uavs sites.geojson", "E302", &["`h` is given twice"]);
}
