//! `info` of any file: what UAVs, tracks and outputs of this program hold, and what a stranger's file is.

use serde_json::{Value, json};

use crate::program::Folder;

fn info(folder: &Folder, line: &str) -> Value {
    folder.type_in(&format!("info {line} --json")).done().json()
}

#[test]
fn tables_of_uavs_are_told_with_their_heights_and_what_is_twice() {
    let folder = Folder::new();
    folder.write(
        "sites.csv",
        "# places\nid,x,y,h,h_above\na,5,8,60,ground\nb,35.5,30,90,amsl\na,12,12,20,ground\nc,5,8,60,\n",
    );
    let found = info(&folder, "sites.csv");
    assert_eq!((&found["kind"], &found["places"]), (&json!("uavs"), &json!(4)));
    assert_eq!(found["extent"], json!([5.0, 8.0, 35.5, 30.0]));
    assert_eq!(found["heights"]["ground"], json!({"places": 3, "range_m": [20.0, 60.0]}));
    assert_eq!(found["heights"]["datum"], json!({"places": 1, "range_m": [90.0, 90.0]}));
    let faults = found["faults"].as_array().unwrap();
    assert_eq!(faults.len(), 2, "{faults:?}");
    assert!(faults[0].as_str().unwrap().contains("id `a` is given twice"), "{faults:?}");
    assert!(faults[1].as_str().unwrap().contains("`c` is at the place"), "{faults:?}");
    let said = folder.type_in("info sites.csv").done().out;
    assert!(said.contains("4 places") && said.contains("--uavs sites.csv"), "{said}");
    // What cannot be read is refused with its line, as by a map.
    folder.write("bad.csv", "x,y,h\n1,2,tall\n");
    folder.refuses("info bad.csv", "E302", &["line 2", "`tall`"]);
    folder.write("names.csv", "what,ever\n1,2\n");
    folder.refuses("info names.csv", "E302", &["line 1", "`what,ever`"]);
    // A flag of scenes would be ignored.
    folder.refuses("info sites.csv --tile 5", "E116", &["`--tile`"]);
}

#[test]
fn points_and_lines_in_degrees_stay_in_degrees() {
    let folder = Folder::new();
    let feature = |geometry: &str, properties: &str| {
        format!(r#"{{"type": "Feature", "properties": {{{properties}}}, "geometry": {geometry}}}"#)
    };
    folder.write("point.geojson", &feature(r#"{"type": "Point", "coordinates": [11.5, 48.1]}"#, r#""h": "30roof""#));
    let found = info(&folder, "point.geojson");
    assert_eq!((&found["kind"], &found["crs"]), (&json!("uavs"), &json!("EPSG:4326")));
    assert_eq!(found["extent"], json!([11.5, 48.1, 11.5, 48.1]));
    assert_eq!(found["heights"]["roof"]["places"], 1);
    let line = r#"{"type": "LineString", "coordinates": [[11.5, 48.1], [11.6, 48.2], [11.6, 48.2]]}"#;
    folder.write("walk.geojson", &feature(line, ""));
    let found = info(&folder, "walk.geojson");
    // A place that repeats the one before is one place; degrees have no length.
    assert_eq!((&found["kind"], &found["places"], &found["length"]), (&json!("track"), &json!(2), &Value::Null));
    folder.write("walk.csv", "x,y\n0,0\n3,4\n3,10\n");
    let found = info(&folder, "walk.csv");
    assert_eq!((&found["kind"], &found["length"], &found["reason"]), (&json!("track"), &json!(11.0), &Value::Null));
}

#[test]
fn outputs_of_this_program_tell_what_made_them() {
    let folder = Folder::new();
    let outputs = "-o a.tif -o a.exr -o a.npz -o a.png -o a.json -o a.csv -o a.geojson -o b.asc";
    let line = format!("map itu:urban --size 60 --cell 2 --uav 5,5,80 {outputs} --json -q");
    let map = folder.type_in(&line).done().json();
    folder.type_in("map itu:urban --size 60 --cell 2 --uav 5,5,80 -o bare.png --bare -q").done();
    for file in ["a.tif", "a.exr", "a.npz", "a.png", "a.json", "a.csv", "a.geojson", "b.asc", "bare.png"] {
        let found = info(&folder, file);
        assert_eq!(found["kind"], "output", "{file}");
        assert_eq!(found["made_by"]["schema"], "skyshed/map/1", "{file}");
        assert_eq!(found["made_by"]["digest"], map["digest"], "{file}");
        let said = folder.type_in(&format!("info {file}")).done().out;
        assert!(said.contains("made by    skyshed map itu:urban --size 60"), "{file}: {said}");
    }
    // The cells of a mask by class are what the map counted, and give its digest.
    let found = info(&folder, "a.tif");
    let (site, classes) = (&map["sites"][0], &found["classes"]);
    assert_eq!(classes["los"], site["los"]);
    let n = |count: &Value| count.as_u64().unwrap();
    assert_eq!(n(&classes["los"]) + n(&classes["nlos"]), n(&site["receivers"]));
    assert_eq!(found["digest_agrees"], true);
    assert_eq!(found["bands"][0]["name"], "1.los");
}

#[test]
fn a_city_that_this_program_made_is_a_scene_and_a_mask_is_not() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 60 --cell 2 -o city.tif -o city.geojson -q").done();
    for (scene, kind) in [("city.tif --ground 0", "raster"), ("city.geojson", "footprints")] {
        assert_eq!(info(&folder, scene)["kind"], kind);
    }
    folder.type_in("map city.geojson --uav 5,5,80 -o mask.tif -q").done();
    let said = folder.type_in("info mask.tif").done().out;
    assert!(said.contains("a mask, not a scene"), "{said}");
    // A map of a mask is a mistake; a map of a city is none.
    let warned = folder.type_in("map mask.tif --uav 5,5,80amsl --json").done();
    assert!(warned.warnings().contains(&"W373"), "{}", warned.err);
    let fine = folder.type_in("map city.tif --uav 5,5,80amsl --json").done();
    assert!(!fine.warnings().contains(&"W373"), "{}", fine.err);
}

#[test]
fn a_strangers_file_is_refused_by_its_kind() {
    let folder = Folder::new();
    for (name, bytes, kind) in [
        ("a.pdf", &b"%PDF-1.7"[..], "a PDF document"),
        ("a.png", b"\x89PNG\r\n\x1a\n", "a PNG picture"),
        ("a.zip", b"PK\x03\x04....", "a ZIP archive"),
        ("a.txt", b"", "empty"),
        ("a.exr", b"v/1\x01abc", "an OpenEXR picture"),
        // Documents of others are no output of ours.
        ("a.json", br#"{"schema": "other/map/1"}"#, "an object without `type`"),
    ] {
        std::fs::write(folder.join(name), bytes).unwrap();
        folder.refuses(&format!("info {name}"), "E302", &[name, kind]);
    }
    folder.refuses("info nothing.csv", "E301", &["nothing.csv"]);
}
