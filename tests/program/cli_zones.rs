//! Zones from outside: `skyshed zones`, P_LoS by zone of a map, receivers of one zone.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use geotiff_reader::GeoTiffFile;
use serde_json::{Value, json};

use crate::program::Folder;

/// Cells along a side of the city; 1 m each.
const SIZE: usize = 300;
const CITY: &str = "itu:0.3,500,15 --size 300";

/// The zone of a cell by the definition of a generated city: streets are {x mod T ≤ s} and {y mod T ≤ s}.
fn zone_of(row: usize, col: usize) -> &'static str {
    let period = 1000.0 / 500.0_f64.sqrt();
    let street = period - 1000.0 * (0.3_f64 / 500.0).sqrt();
    let is_street = |k: usize| (k as f64 + 0.5) % period <= street;
    match (is_street(col), is_street(SIZE - 1 - row)) {
        (true, true) => "crossroad",
        (false, false) => "rooftop",
        _ => "street",
    }
}

fn bytes_of(folder: &Folder, name: &str) -> Vec<u8> {
    GeoTiffFile::from_bytes(folder.read(name)).unwrap().read_raster::<u8>().unwrap().into_iter().collect()
}

/// Cells of a zone for which something holds.
fn count(zone: &str, holds: impl Fn(usize) -> bool) -> u64 {
    (0..SIZE * SIZE).filter(|cell| zone_of(cell / SIZE, cell % SIZE) == zone && holds(*cell)).count() as u64
}

#[test]
fn a_map_counts_receivers_by_zone() {
    let folder = Folder::new();
    let base = format!("map {CITY} --uav 150,150,60 --radius 140");
    let document = folder.type_in(&format!("{base} -o los.tif -o los.csv --zones --json")).done().json();
    let mask = bytes_of(&folder, "los.tif");
    let table = folder.text("los.csv");
    let zones = &document["sites"][0]["zones"];
    for zone in ["street", "crossroad"] {
        let (receivers, los) = (count(zone, |cell| mask[cell] < 2), count(zone, |cell| mask[cell] == 1));
        assert!(receivers > 5000 && los > 100 && los < receivers);
        let p_los = los as f64 / receivers as f64;
        assert_eq!(zones[zone], json!({"receivers": receivers, "los": los, "p_los": p_los}));
        assert!(table.contains(&format!(",{zone},{receivers},{los},{p_los},")), "{zone} in {table}");
    }
    assert_eq!(zones["courtyard"]["reason"], "the scene has no courtyard cell");
    assert_eq!(zones["rooftop"]["reason"], "no rooftop cell in range holds a receiver");
    assert_eq!((&zones["rooftop"]["p_los"], &zones["rooftop"]["receivers"]), (&Value::Null, &json!(0)));
    assert_eq!(document["union"]["zones"], *zones);
    assert_eq!(table.lines().count(), 6);

    // Zones are found where they are asked for, and a flag that changes nothing is refused.
    let without = folder.type_in(&format!("{base} -o without.csv --json")).done().json();
    assert_eq!((&without["sites"][0]["zones"], &without["sites"][0]["placement"]), (&Value::Null, &json!("ground")));
    assert_eq!((&without["digest"], folder.text("without.csv").lines().count()), (&document["digest"], 2));
    folder.refuses(&format!("{base} --zones -o a.tif"), "E116", &["`--zones`"]);

    // The same numbers with receivers in one zone alone, all other cells being none.
    let alone = folder.type_in(&format!("{base} --receivers crossroad -o crossroads.tif --json")).done().json();
    assert_eq!(alone["sites"][0]["p_los"], zones["crossroad"]["p_los"]);
    assert_eq!(alone["receivers"], "crossroad");
    let crossroads = bytes_of(&folder, "crossroads.tif");
    for (cell, (of_zone, of_all)) in crossroads.iter().zip(&mask).enumerate() {
        let is_crossroad = zone_of(cell / SIZE, cell % SIZE) == "crossroad";
        assert_eq!(*of_zone, if is_crossroad || *of_all > 1 { *of_all } else { 2 });
    }
    // A small radius leaves no crossroad in range.
    let near = folder.type_in(&format!("map {CITY} --uav 124,10,60 --radius 5 --zones --json")).done().json();
    assert_eq!(near["sites"][0]["zones"]["crossroad"]["reason"], "no crossroad cell in range");
}

#[test]
fn the_placement_of_a_uav_is_the_zone_below_it() {
    let folder = Folder::new();
    // Streets are 20.2 m wide, buildings 24.5 m. The last two are 0.1 m to either side of a wall at 20.2265 m.
    let places = [
        ("10,10", "crossroad"),
        ("10,30", "street"),
        ("30,30", "rooftop"),
        ("20.3265,30", "rooftop"),
        ("20.1265,30", "street"),
    ];
    let uavs: Vec<String> = places.iter().map(|(place, _)| format!("--uav {place},150")).collect();
    // The same city as footprints, of which nobody knows that they were generated.
    folder.type_in(&format!("city {CITY} -o city.geojson")).done();
    for city in [CITY.to_string(), format!("city.geojson --extent 0,0,{SIZE},{SIZE}")] {
        let document = folder.type_in(&format!("map {city} {} --zones --json", uavs.join(" "))).done().json();
        for (k, (place, zone)) in places.iter().enumerate() {
            assert_eq!(document["sites"][k]["placement"], *zone, "{city}: {place}");
        }
    }
}

/// Twice the area inside a closed ring of positions.
fn doubled_area(ring: &Value) -> f64 {
    let points: Vec<[f64; 2]> = serde_json::from_value(ring.clone()).unwrap();
    points.windows(2).map(|e| e[0][0] * e[1][1] - e[1][0] * e[0][1]).sum()
}

#[test]
fn info_counts_draws_and_outlines_zones() {
    let folder = Folder::new();
    let outputs = "-o z.tif -o z.geojson -o z.png -o z.svg -o z.json";
    let found = folder.type_in(&format!("zones {CITY} {outputs} --json")).done().json();
    let codes = bytes_of(&folder, "z.tif");
    let named = ["", "street", "crossroad", "courtyard", "rooftop"];
    assert!((0..SIZE * SIZE).all(|cell| named[usize::from(codes[cell])] == zone_of(cell / SIZE, cell % SIZE)));
    assert_eq!(found["basis"], "street grid");
    let polygons = folder.json("z.geojson");
    for zone in ["street", "crossroad", "courtyard", "rooftop"] {
        let cells = count(zone, |_| true);
        assert_eq!(found[zone]["cells"], cells, "{zone}");
        let features = polygons["features"].as_array().unwrap().iter().filter(|f| f["properties"]["zone"] == zone);
        let (mut n, mut area) = (0, 0.0);
        for feature in features {
            let rings = feature["geometry"]["coordinates"].as_array().unwrap();
            assert!(doubled_area(&rings[0]) > 0.0 && rings[1..].iter().all(|hole| doubled_area(hole) < 0.0));
            let of_feature: f64 = rings.iter().map(|ring| doubled_area(ring) / 2.0).sum();
            assert_eq!(feature["properties"]["cells"].as_f64(), Some(of_feature));
            (n, area) = (n + 1, area + of_feature);
        }
        assert_eq!((found[zone]["parts"].as_u64(), area), (Some(n), cells as f64), "{zone}");
    }
    // 300 m are 6.7 periods of 44.7 m: seven streets and seven rows of buildings each way, the last of them cut.
    assert_eq!((&found["crossroad"]["parts"], &found["rooftop"]["parts"]), (&json!(49), &json!(49)));
    let words = folder.type_in(&format!("zones {CITY}")).done().out;
    assert!(words.contains("crossroad  ") && words.contains(" in 49 parts"), "{words}");
    assert!(folder.text("z.tif.aux.xml").contains("crossroad"));
    let svg = folder.text("z.svg");
    assert!(svg.contains("Crossroad") && svg.contains("% of open ground · 49 parts"));
    assert_eq!(folder.type_in(&format!("info {CITY} --json")).done().json()["zones"], Value::Null);
}

#[test]
fn a_surface_model_alone_has_no_zones() {
    let folder = Folder::new();
    let flat = "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n0 0 0\n0 9 0\n0 0 0\n";
    folder.write("dsm.asc", flat);
    let document = folder.type_in("map dsm.asc --uav 5,5,50 --zones --json").done().json();
    assert_eq!((&document["sites"][0]["zones"], &document["sites"][0]["placement"]), (&Value::Null, &json!("ground")));
    for (line, code) in [
        ("map dsm.asc --uav 5,5,50 --receivers street --json", "E117"),
        ("zones dsm.asc", "E117"),
        ("info dsm.asc --ground 0 -o zones.png", "E105"),
        ("zones dsm.asc --ground 0 -o zones.exr", "E105"),
    ] {
        folder.refuses(line, code, &[]);
    }
    let known = folder.type_in("map dsm.asc --ground 0 --uav 5,5,50 --zones --json").done().json();
    assert_eq!(known["sites"][0]["zones"]["street"]["receivers"], 8);
}
