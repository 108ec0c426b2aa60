//! Line of sight along a user's track: against hand-computed stretches, against links, and from outside.

use serde_json::{Value, json};

use crate::program::Folder;
use crate::refusals::check_refusals;

/// A wall of 20 m from x = 40 to 50, and a courtyard wall beside the track.
const WALL: &str = r#"{"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": {"height": 20},
   "geometry": {"type": "Polygon", "coordinates": [[[40,-50],[50,-50],[50,50],[40,50],[40,-50]]]}}]}"#;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("wall.geojson", WALL);
    folder.write("walk.csv", "x,y,note\n100,0,start\n60,0,near\n5,0,end\n");
    folder
}

/// Lines of GeoJSON in ETRS89 / UTM zone 32N with these coordinates.
fn lines(coordinates: &[Value]) -> String {
    let geometry = |at: &Value| json!({"type": "LineString", "coordinates": at});
    let feature = |at: &Value| json!({"type": "Feature", "properties": {}, "geometry": geometry(at)});
    let features: Vec<Value> = coordinates.iter().map(feature).collect();
    let crs = json!({"type": "name", "properties": {"name": "EPSG:25832"}});
    json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string()
}

const LINE: &str = "track wall.geojson --extent=-100,-100,300,100 --uav 0,0,60 --rx-height 0 --track walk.csv";

fn document(folder: &Folder, line: &str) -> Value {
    folder.type_in(&format!("{line} --json")).done().json()
}

#[test]
fn stretches_end_where_a_hand_computes_them() {
    // Seen from 60 m over x = 0 the far edge of the wall, x = 50 at 20 m, hides the ground up to x = 50·60/40 = 75.
    let folder = folder();
    for every in ["1", "7.3", "100"] {
        let document = document(&folder, &format!("{LINE} --every {every}"));
        let stretches: Vec<(String, f64, f64)> = document["stretches"]
            .as_array()
            .unwrap()
            .iter()
            .map(|s| (s["state"].as_str().unwrap().into(), s["from_m"].as_f64().unwrap(), s["to_m"].as_f64().unwrap()))
            .collect();
        let wanted = [("los", 0.0, 25.0), ("nlos", 25.0, 50.0), ("inside", 50.0, 60.0), ("los", 60.0, 95.0)];
        assert_eq!(stretches.len(), 4, "{stretches:?}");
        for ((state, from, to), (name, a, b)) in stretches.iter().zip(wanted) {
            assert!(state == name && (from - a).abs() < 1e-9 && (to - b).abs() < 1e-9, "{every}: {stretches:?}");
        }
        let share = document["p_los"].as_f64().unwrap();
        assert!((share - 60.0 / 85.0).abs() < 1e-9, "{share}");
        assert!((document["longest_without_m"].as_f64().unwrap() - 25.0).abs() < 1e-9);
        let vertices = document["points"].as_array().unwrap().iter().filter(|p| p["vertex"] == true).count();
        assert_eq!(vertices, 3);
    }
}

#[test]
fn every_place_says_what_its_link_says() {
    let folder = folder();
    let document = document(&folder, &format!("{LINE} --every 9"));
    for point in document["points"].as_array().unwrap() {
        let rx = format!("{},{}", point["x"], point["y"]);
        let answer = folder.type_in(&format!(
            "link wall.geojson --extent=-100,-100,300,100 --uav 0,0,60 --rx-height 0 --rx {rx} --json"
        ));
        if point["state"] == "inside" {
            assert_eq!(answer.error(), "E201", "{point}");
            assert!(point["margin_m"].is_null() && point["distance_m"].is_null());
        } else {
            let link = answer.done().json();
            assert_eq!(link["los"], point["state"] == "los", "{point}");
            for key in ["margin_m", "distance_m"] {
                let (a, b) = (link[key].as_f64().unwrap(), point[key].as_f64().unwrap());
                assert!((a - b).abs() < 1e-9, "{key}: {link} {point}");
            }
            assert_eq!(point["margin_m"].as_f64().unwrap() >= 0.0, point["state"] == "los");
        }
    }
}

#[test]
fn tables_pictures_and_words_agree() {
    let folder = folder();
    let answer = folder.type_in(&format!("{LINE} -o t.csv -o t.json -o t.png -o t.svg")).done();
    let told = "10 m inside buildings or below the ground: 50 to 60 m\nP_LoS along the track 0.7059: 60 m with line of sight, 25 m without in 1 stretch";
    assert!(answer.out.starts_with(told), "{}", answer.out);
    assert!(answer.warnings().contains(&"W202"));
    let table = folder.text("t.csv");
    assert!(table.starts_with("along_m,x,y,vertex,height_amsl_m,state,margin_m,distance_m,elevation_deg"));
    assert_eq!(table.lines().count() - 1, folder.json("t.json")["points"].as_array().unwrap().len());
    let svg = folder.text("t.svg");
    for words in
        ["No line of sight", "Distance along the track [m]", "Least height in line of sight", ">UAV<", "<image "]
    {
        assert!(svg.contains(words), "{words}");
    }
    // A line of GeoJSON is the same track.
    folder.write("walk.geojson", &lines(&[json!([[100, 0], [60, 0], [60, 0], [5, 0]])]));
    let same = folder.type_in(&format!("{} --crs EPSG:25832 -q", LINE.replace("walk.csv", "walk.geojson"))).done();
    assert_eq!(same.out, answer.out);
}

#[test]
fn bad_tracks_are_refused() {
    let folder = folder();
    folder.write("one.csv", "x,y\n1,2\n1,2\n");
    folder.write("bad.csv", "x,y\n# a comment\n\n1,2\n3,far\n");
    folder.write("cols.csv", "a,b\n1,2\n");
    folder.write("far.csv", "x,y\n1,2\n1e9,2\n");
    folder.write("z.csv", "x,y,z\n1,2,105\n9,2,105\n");
    folder.write("flight.csv", "x,y,h\n1,2,105\n9,2,105\n");
    folder.write("flight.geojson", &lines(&[json!([[0, 0, 105], [1, 1, 105]])]));
    folder.write("two.geojson", &lines(&[json!([[0, 0], [1, 1]]), json!([[0, 0], [1, 1]])]));
    // The reader of sites counted from the record before the comments.
    folder.write("sites.csv", "x,y,h\n# two\n\n1,2,high\n");
    let tracks = [
        ("one.csv", "E308", "found 1 different places"),
        ("bad.csv", "E302", "line 5: `y`: found `far`"),
        ("cols.csv", "E302", "`a,b`"),
        ("none.csv", "E301", "none.csv"),
        ("two.geojson", "E206", "EPSG:25832"),
        ("far.csv", "E502", "999999999 m"),
        ("flight.csv", "E116", "`--rx-height`"),
        ("flight.geojson --crs EPSG:25832", "E116", "`--rx-height`"),
        ("z.csv", "E302", "found heights in column `z`"),
        ("walk.csv --every 0", "E113", "`0`"),
        ("walk.csv --radius 5", "E101", "'--radius'"),
        ("walk.csv --rx 1,1", "E101", "'--rx'"),
    ];
    check_refusals(&folder, &LINE.replace("walk.csv", ""), &tracks);
    let others = [
        ("link wall.geojson --uav 0,0,60", "E101", "--rx"),
        ("map wall.geojson --uavs sites.csv -o a.png", "E302", "line 4: "),
    ];
    check_refusals(&folder, "", &others);
}
