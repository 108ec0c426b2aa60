//! Flights: files of paths, heights of missions, exact stretches, many observers, links between lists.

use serde_json::{Value, json};

use crate::program::Folder;
use crate::refusals::check_refusals;

/// A wall of 20 m from x = 40 to 50, in ETRS89 / UTM zone 32N.
fn wall() -> String {
    let ring = json!([[[40, -50], [50, -50], [50, 50], [40, 50], [40, -50]]]);
    let building = json!({"type": "Feature", "properties": {"height": 20},
        "geometry": {"type": "Polygon", "coordinates": ring}});
    let crs = json!({"type": "name", "properties": {"name": "EPSG:25832"}});
    json!({"type": "FeatureCollection", "crs": crs, "features": [building]}).to_string()
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("wall.geojson", &wall());
    folder
}

const SCENE: &str = "wall.geojson --extent=-100,-100,300,100";

fn near(found: &Value, wanted: f64) {
    let found = found.as_f64().unwrap_or_else(|| panic!("{found}, wanted {wanted}"));
    assert!((found - wanted).abs() < 1e-9, "{found}, wanted {wanted}");
}

/// States and ends \[m\] of the stretches of a document.
pub(crate) fn stretches(of: &Value) -> Vec<(String, f64, f64)> {
    let number = |s: &Value, name: &str| s[name].as_f64().unwrap();
    let told = |s: &Value| (s["state"].as_str().unwrap().to_string(), number(s, "from_m"), number(s, "to_m"));
    of["stretches"].as_array().unwrap().iter().map(told).collect()
}

fn track(folder: &Folder, line: &str) -> Value {
    folder.type_in(&format!("track {SCENE} {line} --json -q")).done().json()
}

#[test]
fn a_flight_is_hidden_where_a_hand_computes_it() {
    let folder = folder();
    // The pilot stands at x = 0 at 0 m. Over the near edge of the wall, x = 40 at 20 m, rays rise by half: at x = 100
    // all below 50 m is hidden, and a climb from 10 to 90 m is hidden for the first half.
    folder.write("climb.csv", "x,y,h,t\n100,0,10,0\n100,0,90,40\n");
    let climb = track(&folder, "--uav 0,0,0 --track climb.csv");
    assert_eq!(stretches(&climb), [("nlos".into(), 0.0, 40.0), ("los".into(), 40.0, 80.0)]);
    assert_eq!((&climb["p_los"], &climb["p_los_by_time"]), (&json!(0.5), &json!(0.5)));
    assert_eq!((&climb["longest_without_m"], &climb["longest_without_s"]), (&json!(40.0), &json!(20.0)));
    assert_eq!(climb["stretches"][0]["obstacle"], "building");
    assert!(climb["length_m"]["inside"].as_f64().unwrap().is_sign_positive(), "{climb}");
    let told = folder.type_in(&format!("track {SCENE} --uav 0,0,0 --track climb.csv -q")).done().out;
    assert!(told.contains("line of sight is lost at 0 to 40 m (0 to 20 s)\n"), "{told}");
    assert_eq!((&climb["exact_stretches"], &climb["rx_height_m"]), (&json!(true), &Value::Null));
    // Through the wall at 10 m: inside from x = 40 to 50. Beyond, the wall hides it; before, nothing does.
    folder.write("through.csv", "x,y,h\n30,0,10\n60,0,10\n");
    let through = track(&folder, "--uav 0,0,0 --track through.csv");
    let wanted = [("los".into(), 0.0, 10.0), ("inside".into(), 10.0, 20.0), ("nlos".into(), 20.0, 30.0)];
    assert_eq!(stretches(&through), wanted);
    // Along the roof, on it: a touch, seen from above; and a hover, which has a time alone.
    folder.write("hover.csv", "x,y,h,t\n60,0,5,0\n60,0,5,30\n0,0,65,90\n");
    let hover = track(&folder, "--uav 0,0,0 --track hover.csv");
    assert_eq!(hover["observers"][0]["stretches"][0]["state"], "nlos");
    assert_eq!(hover["observers"][0]["stretches"][0]["from_s"], 0.0);
    // The hover, and the climb until it enters the wall, x = 50 at 15 m after a sixth of the way.
    near(&hover["longest_without_s"], 30.0 + 60.0 / 6.0);
    // It leaves the roof at 20 m, a quarter of the way, and the shadow where (60 − 60s)/2 = 5 + 60s, at s = 25/90.
    near(&hover["stretches"][2]["from_s"], 30.0 + 15.0);
    near(&hover["stretches"][2]["to_s"], 30.0 + 60.0 * 25.0 / 90.0);
}

#[test]
fn several_observers_see_what_one_of_them_sees() {
    let folder = folder();
    folder.write("walk.csv", "x,y,h\n-20,0,2\n120,0,2\n");
    folder.write("pilots.csv", "id,x,y,h\nwest,0,0,2\neast,100,0,2\n");
    let both = track(&folder, "--uavs pilots.csv --track walk.csv");
    let [west, east] = [0, 1].map(|k| &both["observers"][k]);
    assert_eq!((&west["id"], &east["id"], &both["uav"]), (&json!("west"), &json!("east"), &Value::Null));
    assert_eq!(
        stretches(west),
        [("los".into(), 0.0, 60.0), ("inside".into(), 60.0, 70.0), ("nlos".into(), 70.0, 140.0)]
    );
    assert_eq!(
        stretches(east),
        [("nlos".into(), 0.0, 60.0), ("inside".into(), 60.0, 70.0), ("los".into(), 70.0, 140.0)]
    );
    assert_eq!(
        stretches(&both),
        [("los".into(), 0.0, 60.0), ("inside".into(), 60.0, 70.0), ("los".into(), 70.0, 140.0)]
    );
    assert_eq!((&both["p_los"], &both["length_m"]["no_receiver"]), (&json!(1.0), &json!(10.0)));
    let line = format!("track {SCENE} --uavs pilots.csv --track walk.csv");
    folder.type_in(&format!("{line} --stretches s.csv --stretches s.geojson -o f.svg -o p.csv -q")).done();
    let table = folder.text("s.csv");
    assert!(table.starts_with("path,path_name,uav,leg,state,from_m,to_m,length_m"), "{table}");
    // Three stretches each, and three together.
    assert_eq!((table.lines().count(), folder.json("s.geojson")["features"].as_array().unwrap().len()), (10, 9));
    assert!(folder.text("f.svg").contains("Height above the datum [m]"));
    assert!(folder.text("p.csv").lines().nth(1).unwrap().contains(",west,1,"));
}

#[test]
fn each_format_holds_the_same_flight() {
    let folder = Folder::new();
    let places = [(11.5754, 48.1371, 70.0), (11.5764, 48.1381, 30.0), (11.5744, 48.1379, 50.0)];
    let tuple = places.map(|(lon, lat, z)| format!("{lon},{lat},{z}"));
    folder.write("a.csv", &format!("lon,lat,h,h_above\n{}\n", tuple.clone().map(|t| t + ",amsl").join("\n")));
    folder.write("b.geojson", &json!({"type": "LineString", "coordinates": places}).to_string());
    let trkpt =
        places.map(|(lon, lat, z)| format!("<trkpt lat=\"{lat}\" lon=\"{lon}\"><ele>{z}</ele></trkpt>")).concat();
    folder.write(
        "c.gpx",
        &format!("<gpx xmlns=\"http://www.topografix.com/GPX/1/1\"><trk><trkseg>{trkpt}</trkseg></trk></gpx>"),
    );
    let line = |mode: &str| {
        format!(
            "<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Placemark><LineString><altitudeMode>{mode}</altitudeMode>\
             <coordinates>{}</coordinates></LineString></Placemark></kml>",
            tuple.join(" ")
        )
    };
    folder.write("d.kml", &line("absolute"));
    folder.write("walk.kml", &line("clampToGround"));
    let item = |(lon, lat, z): &(f64, f64, f64)| {
        json!({"type": "SimpleItem", "command": 16, "frame": 0, "AltitudeMode": 2, "Altitude": z,
            "params": [0, 0, 0, null, lat, lon, z]})
    };
    let mission =
        json!({"items": places.iter().map(item).collect::<Vec<_>>(), "plannedHomePosition": [48.137, 11.575, 3]});
    folder.write("e.plan", &json!({"fileType": "Plan", "mission": mission}).to_string());
    let rows = places
        .iter()
        .enumerate()
        .map(|(k, (lon, lat, z))| format!("{}\t0\t0\t16\t0\t0\t0\t0\t{lat}\t{lon}\t{z}\t1\n", k + 1));
    let rows: String = rows.collect();
    folder.write("f.waypoints", &format!("QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t48.137\t11.575\t3\t1\n{rows}"));
    let munich = concat!(env!("CARGO_MANIFEST_DIR"), "/maps/munich.geojson");
    let of = |file: &str| {
        let line = format!("track {munich} --uav 691549.7,5334762.2,30 --track {file} --json -q --every 50");
        let mut document = folder.type_in(&line).done().json();
        for name in ["command", "request", "inputs", "warnings"] {
            document.as_object_mut().unwrap().remove(name);
        }
        document["scene"].as_object_mut().unwrap().remove("sources");
        document
    };
    let wanted = of("a.csv");
    assert!(wanted["stretches"].as_array().unwrap().len() > 2, "{wanted}");
    for file in ["b.geojson", "c.gpx", "d.kml", "e.plan", "f.waypoints"] {
        assert_eq!(of(file), wanted, "{file}");
    }
    // What lies on the ground has no heights of its own.
    assert_eq!(of("walk.kml")["rx_height_m"], 1.5);
    folder.write(
        "zero.geojson",
        &json!({"type": "LineString", "coordinates": places.map(|(x, y, _)| (x, y, 0))}).to_string(),
    );
    let line = format!("track {munich} --uav 691549.7,5334762.2,30 --track zero.geojson");
    let answer = folder.type_in(&line).done();
    assert!(answer.warnings().contains(&"W386"), "{}", answer.err);
    // Their stretches come back from what is written in degrees.
    folder.type_in(&line.replace("zero.geojson", "a.csv --stretches s.gpx --stretches s.kml -q")).done();
    for file in ["s.gpx", "s.kml"] {
        let again = of(file);
        let total = again["length_m"]["total"].as_f64().unwrap();
        assert!((total - wanted["length_m"]["total"].as_f64().unwrap()).abs() < 1e-3, "{file}: {total}");
    }
}

/// Ground of 3 m more in each column of 50 m.
const EAST: i32 = 150;

fn hills(folder: &Folder, corner: (i32, i32)) {
    let row: Vec<String> = (0..EAST).map(|col| (3 * col).to_string()).collect();
    let rows = vec![row.join(" "); 120].join("\n");
    let head = format!("ncols {EAST}\nnrows 120\nxllcorner {}\nyllcorner {}\ncellsize 50\n", corner.0, corner.1);
    folder.write("hills.asc", &(head + &rows + "\n"));
}

#[test]
fn missions_fly_where_their_ground_station_shows_them() {
    let folder = Folder::new();
    let corner = (566_000, 5_271_000);
    hills(&folder, corner);
    let simple = |command: u32, mode: Option<u32>, frame: u32, place: [f64; 2], z: Option<f64>| {
        json!({"type": "SimpleItem", "command": command, "frame": frame, "AltitudeMode": mode, "Altitude": z,
            "params": [0, 0, 0, null, place[0], place[1], z]})
    };
    let home = [47.630, -122.086];
    let at = [[47.633, -122.085], [47.636, -122.080], [47.640, -122.070], [47.628, -122.060]];
    let survey = json!({"type": "ComplexItem", "complexItemType": "survey",
        "TransectStyleComplexItem": {"Items": [simple(16, None, 3, at[0], Some(33.0)), simple(206, None, 2, [0.0, 0.0], None)]}});
    let items = json!([
        simple(22, Some(1), 3, [0.0, 0.0], Some(30.0)),
        simple(16, Some(1), 3, at[0], Some(60.0)),
        simple(178, None, 2, [0.0, 0.0], None),
        simple(16, Some(2), 0, at[1], Some(459.5)),
        simple(16, Some(3), 0, at[2], Some(80.0)),
        simple(16, None, 10, at[3], Some(50.0)),
        survey,
        simple(20, None, 2, [0.0, 0.0], None),
    ]);
    let plan = |items: &Value, home: &Value| {
        json!({"fileType": "Plan", "mission": {"items": items, "plannedHomePosition": home}}).to_string()
    };
    folder.write("m.plan", &plan(&items, &json!([home[0], home[1], 9.26])));
    let line = "track hills.asc --crs EPSG:32610 --uav 568000,5275000,30 --every 100000 --track";
    let document = folder.type_in(&format!("{line} m.plan --json -q")).done().json();
    let vertices: Vec<&Value> = document["points"].as_array().unwrap().iter().filter(|p| p["vertex"] == true).collect();
    let ground = |point: &Value| {
        let col = ((point["x"].as_f64().unwrap() - f64::from(corner.0)) / 50.0).floor();
        3.0 * col
    };
    let of_home = ground(vertices[0]);
    // From home on the ground up, over the waypoints, and back to the ground at home.
    let wanted: [&dyn Fn(&Value) -> f64; 8] = [
        &|_| of_home,
        &|_| of_home + 30.0,
        &|_| of_home + 60.0,
        &|_| 459.5,
        &|p| ground(p) + 80.0,
        &|p| ground(p) + 50.0,
        &|_| of_home + 33.0,
        &|_| of_home,
    ];
    let heights: Vec<f64> = vertices.iter().filter_map(|p| p["height_amsl_m"].as_f64()).collect();
    let hand: Vec<f64> = vertices.iter().zip(wanted).map(|(p, height)| height(p)).collect();
    assert_eq!(heights, hand);
    // The same vertices as UAVs.
    let map = folder.type_in("map hills.asc --crs EPSG:32610 --uavs m.plan --json -q").done().json();
    let of_sites = map["sites"].as_array().unwrap().iter().map(|site| site["height_amsl_m"].as_f64().unwrap());
    assert_eq!(of_sites.collect::<Vec<_>>(), hand);
    folder.refuses(
        "map hills.asc --crs EPSG:32610 --uavs m.plan -o {site}.json",
        "E116",
        &["`--uavs`", "above its home"],
    );
    let refused = [
        (
            "r.plan",
            "fixed wing",
            json!([{"type": "ComplexItem", "complexItemType": "fwLandingPattern"}]),
            "`fwLandingPattern`",
        ),
        ("s.plan", "frame", json!([simple(16, None, 1, at[0], Some(5.0))]), "found the frame 1"),
    ];
    for (file, _, items, words) in refused {
        folder.write(file, &plan(&items, &json!([home[0], home[1], 9.26])));
        folder.refuses(&format!("{line} {file}"), "E302", &[words]);
    }
    folder.write(
        "no_home.plan",
        &plan(
            &json!([simple(16, Some(1), 3, at[0], Some(5.0)), simple(16, Some(1), 3, at[1], Some(5.0))]),
            &Value::Null,
        ),
    );
    folder.refuses(&format!("{line} no_home.plan"), "E302", &["no planned home position"]);
}

#[test]
fn straight_legs_over_hills_are_told_and_can_follow_them() {
    let folder = Folder::new();
    hills(&folder, (0, 0));
    // Up and down: the ground rises by 3 m in 50 m, so the middle of 2 km to a place of the same ground is far below.
    folder.write("f.csv", "x,y,h\n25,25,20\n1025,25,20\n25,75,20\n");
    let line = "track hills.asc --uav 500,2000,200 --track f.csv --every 10";
    let straight = folder.type_in(&format!("{line} --json")).done();
    assert!(!straight.warnings().contains(&"W217"), "even slopes keep the height");
    let rows: Vec<String> =
        (0..EAST).map(|col| if (10..12).contains(&col) { "90".into() } else { "0".to_string() }).collect();
    let head = format!("ncols {EAST}\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 50\n");
    folder.write("ridge.asc", &(head + &vec![rows.join(" "); 20].join("\n") + "\n"));
    let line = "track ridge.asc --uav 100,500,200 --track f.csv --every 10";
    let straight = folder.type_in(&format!("{line} --json")).done();
    assert!(straight.warnings().contains(&"W217") && straight.err.contains("90 m off"), "{}", straight.err);
    near(&straight.json()["length_m"]["inside"], 100.0 + 100.0 * f64::hypot(1000.0, 50.0) / 1000.0);
    let follows = folder.type_in(&format!("{line} --follow-ground --json")).done();
    assert!(!follows.warnings().contains(&"W217"));
    // It climbs the cliffs in one step, from inside the first 25 m up.
    near(&follows.json()["length_m"]["nodata"], 0.0);
    assert!(follows.json()["length_m"]["inside"].as_f64().unwrap() < 110.0);
}

#[test]
fn odd_paths_are_refused() {
    let folder = folder();
    folder.write("back.csv", "x,y,h,t\n1,2,5,10\n9,2,5,4\n");
    folder.write("half.csv", "x,y,h,t\n1,2,5,10\n9,2,5,\n");
    folder.write("clocks.csv", "x,y,h,t\n1,2,5,10\n9,2,5,2026-05-01T10:00:00Z\n");
    folder.write("some.geojson", &json!({"type": "LineString", "coordinates": [[1, 2, 3], [4, 5]]}).to_string());
    folder.write("x.xml", "<?xml version=\"1.0\"?><a/>");
    folder.write("bomb.gpx", "<!DOCTYPE gpx [<!ENTITY a \"b\">]><gpx><trk>&a;</trk></gpx>");
    folder.write("mode.kml", "<kml><Placemark><LineString><altitudeMode>up</altitudeMode><coordinates>1,2,3 4,5,6</coordinates></LineString></Placemark></kml>");
    folder.write("short.waypoints", "QGC WPL 110\n0\t1\t0\n");
    folder.write("empty.gpx", "<gpx/>");
    let line = format!("track {SCENE} --uav 0,0,60 --track ");
    check_refusals(
        &folder,
        &line,
        &[
            ("back.csv", "E302", "found a time before"),
            ("half.csv", "E302", "found no time"),
            ("clocks.csv", "E302", "found a time with its zone"),
            ("some.geojson", "E302", "found no height"),
            ("x.xml", "E302", "found XML of `a`"),
            ("bomb.gpx", "E302", "GPX or KML"),
            ("mode.kml", "E302", "altitudeMode `up`"),
            ("short.waypoints", "E302", "found 3 fields"),
            ("empty.gpx", "E308", "found 0 different places"),
        ],
    );
}

#[test]
fn points_in_space_are_uavs_above_the_datum() {
    let folder = Folder::new();
    hills(&folder, (566_000, 5_271_000));
    let line = "map hills.asc --crs EPSG:32610 --json -q --uavs";
    let point = |z: f64| json!({"type": "Point", "coordinates": [-122.07, 47.63, z]});
    folder.write("p.geojson", &point(700.0).to_string());
    folder.write("p.gpx", "<gpx><wpt lat=\"47.63\" lon=\"-122.07\"><ele>700</ele><name>a</name></wpt></gpx>");
    folder.write(
        "p.kml",
        "<kml><Placemark><name>a</name><Point><altitudeMode>absolute</altitudeMode>\
        <coordinates>-122.07,47.63,700</coordinates></Point></Placemark></kml>",
    );
    let counts = ["p.geojson", "p.gpx", "p.kml"].map(|file| {
        let site = folder.type_in(&format!("{line} {file}")).done().json()["sites"][0].clone();
        near(&site["height_amsl_m"], 700.0);
        (site["los"].clone(), site["receivers"].clone())
    });
    assert!(counts[0] == counts[1] && counts[1] == counts[2], "{counts:?}");
    // A third coordinate of 0 is no height.
    folder.write("p.geojson", &point(0.0).to_string());
    folder.refuses(&format!("{line} p.geojson"), "E302", &["found no height `h`"]);
    folder.write("p.gpx", "<gpx><wpt lat=\"47.63\" lon=\"-122.07\"/></gpx>");
    folder.refuses(&format!("{line} p.gpx"), "E204", &["has no height"]);
}

#[test]
fn links_of_lists_are_single_links() {
    let folder = folder();
    folder.write("uavs.csv", "id,x,y,h\na,0,0,60\nb,45,0,5\nc,120,20,25\n");
    folder.write("users.csv", "id,x,y,h\nu,70,0,\nv,90,5,3\nw,45,0,1\n");
    folder.write("bare.csv", "id,x,y\nu,70,0\nv,90,5\nw,45,0\n");
    let line = format!("link {SCENE} --uavs uavs.csv --rxs bare.csv");
    let document = folder.type_in(&format!("{line} --json -q")).done().json();
    let rows = document["links"].as_array().unwrap();
    assert_eq!(rows.len(), 9);
    for row in rows {
        let places =
            [("a", "0,0,60"), ("b", "45,0,5"), ("c", "120,20,25"), ("u", "70,0"), ("v", "90,5"), ("w", "45,0")];
        let place = |id: &Value| places.iter().find(|(name, _)| id == name).unwrap().1;
        let single = format!("link {SCENE} --uav {} --rx {} --json -q", place(&row["uav"]), place(&row["rx"]));
        let answer = folder.type_in(&single);
        if row["uav"] == "b" || row["rx"] == "w" {
            assert_eq!((answer.error(), &row["los"]), ("E201", &Value::Null), "{row}");
            assert!(row["reason"].as_str().unwrap().contains("inside a building"), "{row}");
            continue;
        }
        let link = answer.done().json();
        for name in ["los", "margin_m", "distance_m", "elevation_deg"] {
            assert_eq!(row.get(name).unwrap_or(&Value::Null), &link[name], "{name} of {row}");
        }
        let kind = row.get("obstacle").cloned().unwrap_or(Value::Null);
        assert_eq!(kind, link["obstruction"].get("kind").cloned().unwrap_or(Value::Null), "{row}");
    }
    // The UAV at (0, 0) is due west of the user at (70, 0).
    near(&rows[0]["azimuth_deg"], 270.0);
    near(&rows[0]["slant_m"], 70.0_f64.hypot(58.5));
    let alone = folder.type_in(&format!("{line} --los-only --json -q")).done().json();
    let los = |document: &Value| -> Vec<Value> {
        document["links"].as_array().unwrap().iter().map(|row| row["los"].clone()).collect()
    };
    assert_eq!(los(&alone), los(&document));
    let pairs = folder.type_in(&format!("{line} --pairs --json -q")).done().json();
    assert_eq!(los(&pairs), [&rows[0], &rows[4], &rows[8]].map(|row| row["los"].clone()));
    folder.type_in(&format!("{line} -o l.csv -o l.geojson -o l.npz -o l.json -q")).done();
    assert_eq!(folder.text("l.csv").lines().count(), 10);
    assert_eq!(folder.json("l.geojson")["features"].as_array().unwrap().len(), 9);
    assert_eq!(folder.json("l.json")["schema"], "skyshed/links/1");
    // Several receivers of one flag are told one by one; a file of receivers is one that is read.
    let typed = folder.type_in("link itu:urban --size 200 --uav 50,50,60 --rx 70,0 --rx 90,5 --json -q").done().json();
    let words: Vec<&str> = typed["command"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(words.join(" ").ends_with("--rx 70,0 --rx 90,5 --json -q"), "{words:?}");
    assert_eq!(typed["request"]["rx"], json!(["70,0", "90,5"]));
    folder.type_in("link itu:urban --size 200 --uav 50,50,60 --rxs bare.csv --hash -q").done();
    let refused = [
        ("--uavs uavs.csv --rx 70,0 --rx 90,5 --pairs", "E116", "3 UAVs and 2 receivers"),
        ("--uav 0,0,60 --rx 70,0 --pairs", "E116", "for a single link"),
        ("--uavs uavs.csv --rxs users.csv", "E302", "line 2"),
        ("--uavs uavs.csv", "E101", "--rx"),
        ("--rxs bare.csv", "E108", "UAV"),
    ];
    check_refusals(&folder, &format!("link {SCENE} "), &refused);
}

#[test]
fn bad_uavs_are_named_left_out_or_lifted() {
    let folder = folder();
    folder.write("uavs.csv", "id,x,y,h\na,0,0,60\nb,45,0,5\nc,120,20,25\nd,44,10,19\ne,0,50,-3amsl\n");
    let map = |rule: &str| format!("map {SCENE} --data-area all --uavs uavs.csv {rule}");
    folder.refuses(&map("--json"), "E201", &["3 of 5 UAVs", "`b`", "`d`", "`e`"]);
    let skipped = folder.type_in(&map("--bad-uavs skip --json")).done();
    assert!(skipped.warnings().contains(&"W218") && skipped.err.contains("3 UAVs are left out"), "{}", skipped.err);
    let ids = |document: &Value| -> Vec<String> {
        document["sites"].as_array().unwrap().iter().map(|site| site["id"].as_str().unwrap().to_string()).collect()
    };
    assert_eq!(ids(&skipped.json()), ["a", "c"]);
    let lifted = folder.type_in(&map("--bad-uavs lift --json")).done().json();
    assert_eq!(ids(&lifted), ["a", "b", "c", "d", "e"]);
    let heights: Vec<f64> =
        lifted["sites"].as_array().unwrap().iter().map(|site| site["height_amsl_m"].as_f64().unwrap()).collect();
    assert_eq!(heights, [60.0, 20.0, 25.0, 20.0, 0.0]);
    // Alone the two that are left see just the same.
    folder.write("good.csv", "id,x,y,h\na,0,0,60\nc,120,20,25\n");
    let good = folder.type_in(&format!("map {SCENE} --data-area all --uavs good.csv --json")).done().json();
    assert_eq!(good["sites"], skipped.json()["sites"]);
    folder.write("bad.csv", "id,x,y,h\nb,45,0,5\nd,44,10,19\n");
    folder.refuses(
        &format!("map {SCENE} --data-area all --uavs bad.csv --bad-uavs skip --json"),
        "E201",
        &["2 of 2 UAVs"],
    );
    for line in [
        format!("compare {SCENE} --data-area all --uavs uavs.csv --bad-uavs skip --json -q"),
        format!("limits {SCENE} --data-area all --uavs uavs.csv --bad-uavs lift --json -q"),
        format!("chart {SCENE} --data-area all --uavs uavs.csv --bad-uavs skip --time 0 --json -q"),
        format!("track {SCENE} --uavs uavs.csv --bad-uavs skip --track good.csv --json -q"),
    ] {
        folder.type_in(&line).done();
    }
}

#[test]
fn what_every_uav_sees_is_the_least_of_their_masks() {
    let folder = folder();
    folder.write("uavs.csv", "id,x,y,h\na,0,0,60\nb,20,30,25\nc,120,20,25\n");
    let line = format!("map {SCENE} --data-area all --cell 10 --uavs uavs.csv --radius 150");
    folder.type_in(&format!("{line} --layers all -o all.asc -q")).done();
    let cells = |file: &str| -> Vec<i32> {
        folder.text(file).lines().skip(6).flat_map(str::split_whitespace).map(|v| v.parse().unwrap()).collect()
    };
    let all = cells("all.asc");
    let each: Vec<Vec<i32>> = ["0,0,60", "20,30,25", "120,20,25"]
        .into_iter()
        .map(|uav| {
            let single =
                format!("map {SCENE} --data-area all --cell 10 --uav {uav} --radius 150 -o one.asc -q --overwrite");
            folder.type_in(&single).done();
            cells("one.asc")
        })
        .collect();
    for (k, found) in all.iter().enumerate() {
        let own: Vec<i32> = each.iter().map(|mask| mask[k]).collect();
        let wanted = match &own[..] {
            own if own.contains(&255) => 255,
            own if own.contains(&3) => 3,
            own if own.contains(&2) => 2,
            own if own.contains(&0) => 0,
            _ => 1,
        };
        assert_eq!(*found, wanted, "cell {k}: {own:?}");
    }
    assert!(all.contains(&1) && all.contains(&0) && all.contains(&3));
    let answer = folder.type_in(&format!("{line} --layers all -o all.svg")).done();
    assert!(folder.text("all.svg").contains("What every UAV sees of"), "{}", answer.err);
}
