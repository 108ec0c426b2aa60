//! `skyshed link` against arithmetic by hand, `skyshed city` and back, `skyshed info`.

use serde_json::{Value, json};

use crate::program::Folder;

/// Five by five cells of 10 m on level ground, one of them 20 m high in the middle.
const WALL: &str = "ncols 5\nnrows 5\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n\
                    0 0 0 0 0\n0 0 0 0 0\n0 0 20 0 0\n0 0 0 0 0\n0 0 0 0 0\n";

/// Box `a` from x = 20 to 30 m, 20 m high, and behind it box `b` from x = 32 to 40 m.
fn boxes(height_of_b: f64) -> String {
    let square = |west: u32, east: u32| json!([[[west, 20], [east, 20], [east, 30], [west, 30], [west, 20]]]);
    let feature = |id: &str, west, east, height: f64| {
        json!({"type": "Feature", "id": id, "properties": {"height": height},
               "geometry": {"type": "Polygon", "coordinates": square(west, east)}})
    };
    json!({"type": "FeatureCollection", "features": [feature("a", 20, 30, 20.0), feature("b", 32, 40, height_of_b)]})
        .to_string()
}

fn link(folder: &Folder, line: &str) -> Value {
    folder.type_in(&format!("link {line} --json")).done().json()
}

fn assert_near(value: &Value, wanted: f64) {
    let found = value.as_f64().unwrap_or_else(|| panic!("{value}, wanted {wanted}"));
    assert!((found - wanted).abs() < 1e-9, "{found}, wanted {wanted}");
}

#[test]
fn a_link_over_a_wall_is_what_a_hand_computes() {
    let folder = Folder::new();
    folder.write("wall.asc", WALL);
    // From (5, 25) at 40 m down to (45, 25) at 2 m the ray falls by 38 m in 40 m. It leaves the wall, on the side of
    // the lower end, at x = 30 m with 40 − 25 · 0.95 = 16.25 m. Over that edge the plane of the UAV and the roof falls
    // by 20 m in 25 m and reaches x = 45 m at 8 m.
    let found = link(&folder, "wall.asc --ground 0 --uav 5,25,40 --rx 45,25,2");
    assert_eq!((&found["schema"], &found["los"]), (&json!("skyshed/link/1"), &json!(false)));
    assert_near(&found["margin_m"], 2.0 - 8.0);
    assert_near(&found["distance_m"], 40.0);
    assert_near(&found["elevation_deg"], 38.0_f64.atan2(40.0).to_degrees());
    let wanted =
        json!({"kind": "cell", "row": 2, "col": 2, "x": 30.0, "y": 25.0, "ray_height_m": 16.25, "roof_height_m": 20.0});
    assert_eq!(found["obstruction"], wanted);
    assert_eq!(found["uav"], json!({"x": 5.0, "y": 25.0, "height_amsl_m": 40.0}));
    assert_eq!(found["receiver"], json!({"x": 45.0, "y": 25.0, "height_amsl_m": 2.0}));

    // Grazing the edge is line of sight; a millimeter below it is not.
    for (height, los, margin) in [(8.0, true, 0.0), (9.5, true, 1.5), (7.999, false, 0.0)] {
        let found = link(&folder, &format!("wall.asc --ground 0 --uav 5,25,40 --rx 45,25,{height}"));
        assert_eq!(found["los"], json!(los), "{height}");
        if los {
            assert_near(&found["margin_m"], margin);
            assert_eq!(found["obstruction"], Value::Null);
        } else {
            assert_near(&found["margin_m"], -1.0 / 1024.0);
        }
    }

    // Looking up at a UAV below the roof: the near side decides. From (45, 25) at 2 m the ray to (5, 25) at 10 m meets
    // the wall at x = 30 m with 2 + 15 · 0.2 = 5 m, and nothing below the roof's own height would be seen there.
    let found = link(&folder, "wall.asc --ground 0 --uav 5,25,10 --rx 45,25,2");
    assert_eq!((&found["los"], &found["obstruction"]["x"]), (&json!(false), &json!(30.0)));
    assert_near(&found["obstruction"]["ray_height_m"], 5.0);
    // Beside the wall nothing is in the way, and the margin is the height above the ground.
    let found = link(&folder, "wall.asc --ground 0 --uav 5,45,40 --rx 45,45,2");
    assert_eq!((&found["los"], &found["obstruction"]), (&json!(true), &Value::Null));
    assert_near(&found["margin_m"], 2.0);
}

#[test]
fn a_link_over_two_boxes_names_the_one_that_sets_the_ceiling() {
    let folder = Folder::new();
    // Over `a` the ceiling at the receiver is 8 m as above; over the far edge of `b`, 10 m high at x = 40 m, it is
    // 40 − 40 · 30 / 35 = 5.71 m.
    folder.write("two.geojson", &boxes(10.0));
    let found = link(&folder, "two.geojson --uav 5,25,40 --rx 45,25,2");
    assert_near(&found["margin_m"], -6.0);
    let wanted =
        json!({"kind": "building", "id": "a", "x": 30.0, "y": 25.0, "ray_height_m": 16.25, "roof_height_m": 20.0});
    assert_eq!(found["obstruction"], wanted);
    // At 12 m `b` touches the same plane: on a tie the nearer to the receiver is named.
    folder.write("tie.geojson", &boxes(12.0));
    let found = link(&folder, "tie.geojson --uav 5,25,40 --rx 45,25,2");
    assert_near(&found["margin_m"], -6.0);
    let wanted =
        json!({"kind": "building", "id": "b", "x": 40.0, "y": 25.0, "ray_height_m": 6.75, "roof_height_m": 12.0});
    assert_eq!(found["obstruction"], wanted);
    assert_eq!(link(&folder, "tie.geojson --uav 5,25,40 --rx 45,25,8")["los"], json!(true));
}

#[test]
fn a_link_is_said_in_words_and_drawn() {
    let folder = Folder::new();
    folder.write("two.geojson", &boxes(10.0));
    let answer = folder.type_in("link two.geojson --uav 5,25,40 --rx 45,25,2 -q").done();
    assert_eq!(
        answer.out,
        "NLoS: UAV at (5, 25), 40 m to receiver at (45, 25), 2 m above the datum\n\
         distance 40 m, elevation angle 43.53°, margin -6.000 m\n\
         obstructed by building `a`: obstructing point (30, 25), ray height 16.250 m, roof height 20.000 m\n"
    );
    folder.type_in("link two.geojson --uav 5,25,40 --rx 45,25,2 -o side.png -o side.svg -o side.json").done();
    assert!(folder.read("side.png").starts_with(b"\x89PNG"));
    assert!(folder.text("side.svg").contains("no line of sight"));
    assert_eq!(folder.json("side.json")["obstruction"]["id"], "a");
    // The receiver stands 1.5 m above the ground without a height, and may be asked for above a roof or the datum.
    for (receiver, z) in [("45,25", 1.5), ("25,25,2roof", 22.0), ("45,25,7amsl", 7.0)] {
        let found = link(&folder, &format!("two.geojson --ground 3 --uav 5,25,40 --rx {receiver}"));
        let above = if receiver.ends_with("amsl") { 0.0 } else { 3.0 };
        assert_near(&found["receiver"]["height_amsl_m"], z + above);
    }
    // Straight up is line of sight, however near the walls are.
    let found = link(&folder, "two.geojson --uav 31,25,40 --rx 31,25");
    assert_eq!((&found["los"], &found["distance_m"]), (&json!(true), &json!(0.0)));
    assert_near(&found["elevation_deg"], 90.0);
}

#[test]
fn a_generated_city_written_and_read_back_gives_the_same_map() {
    let folder = Folder::new();
    let made =
        folder.type_in("city itu:urban --size 200 --seed 7 -o c.png -o c.svg -o c.tif -o c.asc -o c.geojson -o c.json");
    assert_eq!(made.done().out, "");
    assert_eq!(folder.files().join(" "), "c.asc c.asc.json c.geojson c.json c.png c.svg c.tif");
    let digest = |line: &str| {
        let document = folder.type_in(&format!("map {line} --uav 90,110,55 --uav 10,10,120 --json -q")).done().json();
        document["digest"].as_str().expect("a digest").to_string()
    };
    let generated = digest("itu:urban --size 200 --seed 7");
    assert_eq!(digest("c.geojson --top-field z_top --extent 0,0,200,200"), generated);
    assert_eq!(digest("c.geojson --extent 0,0,200,200"), generated);
    assert_ne!(digest("itu:urban --size 200 --seed 8"), generated);
    // A copy may begin its rings elsewhere; a copy of the copy is the copy.
    folder.type_in("city c.geojson --extent 0,0,200,200 -o d.geojson -o d.tif").done();
    folder.type_in("city d.geojson --extent 0,0,200,200 -o e.geojson").done();
    assert_eq!(folder.json("e.geojson")["features"], folder.json("d.geojson")["features"]);
    // Heights in meters, the same in both rasters, and those of the footprints.
    let info = |name: &str| folder.type_in(&format!("info {name} --json -q")).done().json();
    let (tif, asc, vector) = (info("c.tif"), info("c.asc"), info("c.geojson"));
    assert_eq!(tif["surface_m"], asc["surface_m"]);
    assert_eq!(tif["surface_m"][1], vector["surface_m"][1]);
    assert_eq!(digest("c.tif --ground 0"), digest("c.asc --ground 0"));
    assert_eq!(digest("c.tif --ground 0"), digest("d.tif --ground 0"));
    let document = folder.json("c.json");
    assert_eq!((&document["schema"], &document["scene"]["seed"]), (&json!("skyshed/city/1"), &json!(7)));
}

#[test]
fn a_generated_city_says_why_it_has_as_many_buildings() {
    let folder = Folder::new();
    for (city, n, rows) in [
        ("itu:dense-urban", 324, "18 rows of 18, one each 57.7 m as 300/km² asks; the edge cuts the last"),
        ("itu:urban", 484, "22 rows of 22, one each 44.7 m as 500/km² asks\n"),
    ] {
        let said = folder.type_in(&format!("city {city}")).done().out;
        assert!(said.contains(&format!("{n} buildings on 1000 × 1000 m: {rows}")), "{said}");
    }
}

#[test]
fn a_city_on_a_slope_keeps_tops_and_grounds() {
    let folder = Folder::new();
    let slope: Vec<String> =
        (0..5).map(|_| (0..5).map(|col| (col * 2).to_string()).collect::<Vec<_>>().join(" ")).collect();
    let head = "ncols 5\nnrows 5\nxllcorner 0\nyllcorner 0\ncellsize 10\n";
    folder.write("slope.asc", &format!("{head}{}\n", slope.join("\n")));
    folder.write("two.geojson", &boxes(10.0));
    folder.type_in("city two.geojson --terrain slope.asc -o out.geojson").done();
    let features = folder.json("out.geojson")["features"].clone();
    // Measured from the lowest ground below: 4 m under `a`, which stands on column 2 and touches column 3, and 6 m
    // under `b`, which stands on column 3.
    for (k, ground, top) in [(0, 4.0, 24.0), (1, 6.0, 16.0)] {
        assert_near(&features[k]["properties"]["ground"], ground);
        assert_near(&features[k]["properties"]["z_top"], top);
    }
    // Storeys count from the ground also where tops are measured from the datum.
    let storeys = json!({"type": "Feature", "properties": {"building:levels": 4}, "geometry": {"type": "Polygon",
        "coordinates": [[[20, 20], [30, 20], [30, 30], [20, 30], [20, 20]]]}});
    let known = json!({"type": "Feature", "properties": {"z": 9}, "geometry": {"type": "Polygon",
        "coordinates": [[[40, 40], [42, 40], [42, 42], [40, 42], [40, 40]]]}});
    let storeys = json!({"type": "FeatureCollection", "features": [storeys, known]});
    folder.write("storeys.geojson", &storeys.to_string());
    folder.type_in("city storeys.geojson --terrain slope.asc --top-field z --missing levels -o s.geojson").done();
    assert_near(&folder.json("s.geojson")["features"][0]["properties"]["z_top"], 4.0 + 12.0);
}

#[test]
fn info_describes_each_kind_of_scene() {
    let folder = Folder::new();
    folder.write("wall.asc", WALL);
    folder.write("two.geojson", &boxes(10.0));
    let document = folder.type_in("info wall.asc --ground 0 --json").done().json();
    assert_eq!(document["schema"], "skyshed/info/1");
    assert_eq!((&document["kind"], &document["crs"]), (&json!("raster"), &Value::Null));
    assert_eq!((&document["cols"], &document["rows"]), (&json!(5), &json!(5)));
    assert_eq!(document["cells"], json!({"open": 24, "building": 1, "nodata": 0}));
    assert_eq!((&document["ground_m"], &document["surface_m"]), (&json!([0.0, 0.0]), &json!([0.0, 20.0])));
    assert_eq!(document["extent"], json!([0.0, 0.0, 50.0, 50.0]));
    let document = folder.type_in("info two.geojson --json").done().json();
    assert_eq!((&document["kind"], &document["buildings"]), (&json!("footprints"), &json!(2)));
    assert_eq!(document["cells"], json!({"open": 20, "building": 180, "nodata": 0}));
    let document = folder.type_in("info itu:urban --size 100 --json").done().json();
    assert_eq!(document["built_up"]["beta_per_km2"], 500.0);
    let answer = folder.type_in("info wall.asc --ground 0").done();
    assert!(answer.out.contains("grid       5 × 5 cells of 10 × 10 m, 50 × 50 m"), "{}", answer.out);
    assert!(
        answer.out.contains("24 open ground (96.0\u{202f}%), 1 building (4.0\u{202f}%), 0 nodata"),
        "{}",
        answer.out
    );
    assert_eq!(answer.warnings().len(), 1, "local coordinates: {}", answer.err);
}
