//! Tracks on the live page: its stretches are those of `track`, the side view follows who is dragged, and what cannot be is refused.

use serde_json::{Value, json};

use crate::live::{ask, driver, map};
use crate::live_claims::{DESK, steps};
use crate::needs::has_program;
use crate::program::Folder;
use crate::support::Random;
use crate::texts::squares;

/// The tracks that a page holds.
fn tracks_of(page: &str) -> Value {
    let (_, rest) = page.split_once(r#"id="facts">"#).unwrap();
    let (facts, _) = rest.split_once("</script>").unwrap();
    serde_json::from_str::<Value>(facts).unwrap()["tracks"].clone()
}

/// States and ends of stretches, along all paths one after the other.
fn stretches_of(document: &Value, starts: &[f64]) -> Vec<(String, f64, f64)> {
    let told = |of: &Value| {
        let start = starts[usize::try_from(of["path"].as_u64().unwrap()).unwrap() - 1];
        let along = |name: &str| start + of[name].as_f64().unwrap();
        (of["state"].as_str().unwrap().to_string(), along("from_m"), along("to_m"))
    };
    document["stretches"].as_array().unwrap().iter().map(told).collect()
}

fn assert_stretches(answer: &Value, document: &Value, starts: &[f64]) {
    let wanted = stretches_of(document, starts);
    let found = answer["stretches"].as_array().unwrap();
    assert_eq!(found.len(), wanted.len(), "{answer}\n{document}");
    for (found, (state, from_m, to_m)) in found.iter().zip(wanted) {
        assert_eq!(found["state"], json!(state));
        for (end, wanted) in found["along_m"].as_array().unwrap().iter().zip([from_m, to_m]) {
            // Roots of libraries differ in the last bit.
            assert!((end.as_f64().unwrap() - wanted).abs() < 1e-9 * wanted.max(1.0), "{found} {wanted}");
        }
    }
    let lengths = &document["length_m"];
    for (found, name) in answer["lengths_m"].as_array().unwrap().iter().zip(["los", "nlos", "inside", "nodata"]) {
        assert!((found.as_f64().unwrap() - lengths[name].as_f64().unwrap()).abs() < 1e-6, "{name}: {answer}");
    }
}

/// A flight of some legs through a town of 300 m, and a walk there.
fn write_tracks(folder: &Folder) {
    let mut random = Random(60);
    let mut between = |low: usize, high: usize| low + random.below(high - low);
    let rows: Vec<String> =
        (0..9).map(|k| format!("{},{},{},{}\n", between(2, 298), between(2, 298), between(5, 70), 20 * k)).collect();
    folder.write("flight.csv", &format!("x,y,h,t\n{}", rows.concat()));
    folder.write("walk.csv", "x,y\n3,3\n280.5,40\n150,297\n");
}

#[test]
fn stretches_of_a_page_are_those_of_the_program() {
    if !has_program("node") {
        return;
    }
    let folder = Folder::new();
    write_tracks(&folder);
    folder.type_in("city itu:urban --size 300 --seed 5 -o dsm.tif -q").done();
    let uavs = [(150.0, 150.0, 70.0), (40.0, 220.0, 40.0)];
    let [one, two] = ["--uav 150,150,70", "--uav 150,150,70 --uav 40,220,40"];
    let asked = |which: Value| json!({"do": "stretches", "which": which, "every_m": 1.0});
    for scene in ["itu:urban --size 300 --seed 5", "dsm.tif --ground 0"] {
        for (track, height, options) in [("flight.csv", 1.5, ""), ("walk.csv", 2.0, " --rx-height 2")] {
            folder.type_in(&format!("live {scene} --track {track} -o page.html -q --overwrite")).done();
            let tracks = tracks_of(&folder.text("page.html"));
            let mut seen = map(&uavs);
            seen["sight"]["rx_height"] = json!(height);
            let mut curved = seen.clone();
            curved["sight"]["earth_k"] = json!(0.001);
            let questions = [
                json!({"do": "tracks", "tracks": tracks}),
                seen,
                asked(json!(0)),
                asked(Value::Null),
                json!({"do": "track_heights"}),
                curved,
                asked(json!(0)),
            ];
            let answers = ask(&folder.word("page.html"), None, &questions);
            let said = |options: &str| {
                folder.type_in(&format!("track {scene} --track {track} {options} --json -q")).done().json()
            };
            let of_one = said(&format!("{one}{options}"));
            assert_stretches(&answers[3], &of_one, &[0.0]);
            assert_stretches(&answers[4], &said(&format!("{two}{options}")), &[0.0]);
            assert!(answers[3]["stretches"].as_array().unwrap().len() > 4, "{}", answers[3]);
            assert_stretches(&answers[7], &said(&format!("{one}{options} --earth-k 0.001")), &[0.0]);
            assert_eq!((answers[3]["every_m"].as_f64(), answers[7]["every_m"].as_f64()), (None, Some(1.0)));

            // Heights are those of the decided places.
            let places = answers[5]["places"].as_array().unwrap();
            let (first, last) = (&of_one["points"][0], of_one["points"].as_array().unwrap().last().unwrap());
            for (place, point) in [(&places[0], first), (places.last().unwrap(), last)] {
                for (name, of_point) in [("x", "x"), ("user_m", "height_amsl_m"), ("time_s", "time_s")] {
                    // A walk has no height inside of a building.
                    let Some(wanted) = point[of_point].as_f64() else { continue };
                    assert_eq!(place[name].as_f64(), Some(wanted), "{name}: {place} {point}");
                }
            }
        }
    }
}

/// Paths follow each other; a UAV that cannot hover sees no stretch.
#[test]
fn several_paths_follow_each_other() {
    if !has_program("node") {
        return;
    }
    let folder = Folder::new();
    folder.write("city.geojson", &squares(&[[20.0, 20.0, 10.0, 10.0]]));
    let line = |y: f64| json!([[0.5, y, 5.0], [49.5, y, 5.0]]);
    let crs = json!({"type": "name", "properties": {"name": "EPSG:25832"}});
    let geometry = json!({"type": "MultiLineString", "coordinates": [line(25.0), line(40.0)]});
    let feature = json!({"type": "Feature", "properties": {}, "geometry": geometry});
    let lines = json!({"type": "FeatureCollection", "crs": crs, "features": [feature]});
    folder.write("two.geojson", &lines.to_string());
    let scene = "city.geojson --extent 0,0,50,50";
    folder.type_in(&format!("live {scene} --track two.geojson --uav 5,25,5 -o page.html -q")).done();
    let tracks = tracks_of(&folder.text("page.html"));
    let asked = json!({"do": "stretches", "which": 0, "every_m": 1.0});
    let questions = [
        json!({"do": "tracks", "tracks": tracks}),
        map(&[(5.0, 25.0, 5.0)]),
        asked.clone(),
        map(&[(25.0, 25.0, 5.0)]),
        asked,
    ];
    let answers = ask(&folder.word("page.html"), None, &questions);
    let wanted = folder.type_in(&format!("track {scene} --track two.geojson --uav 5,25,5 --json -q")).done().json();
    assert_stretches(&answers[3], &wanted, &[0.0, 49.0]);
    let states: Vec<&Value> = answers[3]["stretches"].as_array().unwrap().iter().map(|of| &of["state"]).collect();
    // The first path goes through the square; the shadow of its corner meets the second one beyond its end, at x = 50.
    assert_eq!(states, ["los", "inside", "nlos", "los"], "{}", answers[3]);
    assert_eq!(answers[3]["stretches"][2]["obstacle"]["name"], "1");
    assert_eq!(answers[5]["stretches"], json!([]));
}

#[test]
fn the_side_view_of_a_track_follows_its_observer() {
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    write_tracks(&folder);
    let scene = "itu:urban --size 300 --seed 5";
    folder.type_in(&format!("live {scene} --track flight.csv --uav 150,150,70 -o page.html -q")).done();
    let share = |at: &str| {
        let document = folder.type_in(&format!("track {scene} --track flight.csv --uav {at} --json -q")).done().json();
        let p_los = document["p_los"].as_f64().unwrap();
        format!("{:.1}", (1000.0 * p_los).round() / 10.0)
    };
    let verdict = json!({"ask": "document.getElementById('track-verdict').textContent"});
    let is_open = json!({"ask": "!document.getElementById('track-drawer').hidden"});
    let answers = steps(
        &driver,
        &folder.word("page.html"),
        DESK,
        &[
            json!({"open": ""}),
            is_open.clone(),
            verdict.clone(),
            json!({"ask": "moveUav(0, 40, 220)"}),
            verdict,
            json!({"ask": "[...document.querySelectorAll('#lines .track path')].map((path) => path.getAttribute('class'))"}),
            json!({"ask": "pointAlong(700), document.querySelectorAll('#track-chart .pointed .label').length"}),
            json!({"ask": "openLink(100, 100)"}),
            is_open.clone(),
            json!({"click": "#link-close"}),
            is_open.clone(),
            json!({"click": "#track-close"}),
            is_open.clone(),
            json!({"click": "#track-open"}),
            is_open,
        ],
    );
    let said = |answer: &Value, share: String| assert!(answer.as_str().unwrap().contains(&share), "{answer}: {share}");
    assert_eq!(answers[0], json!(true));
    said(&answers[1], share("150,150,70"));
    said(&answers[3], share("40,220,70"));
    let kinds: Vec<&str> = answers[4].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(kinds[0] == "track-casing" && kinds.contains(&"track-los") && kinds.contains(&"track-nlos"), "{kinds:?}");
    assert_eq!(answers[5], json!(2));
    assert_eq!(
        [&answers[7], &answers[8], &answers[9], &answers[10]],
        [false, true, false, true].map(|is| json!(is)).each_ref()
    );
}

#[test]
fn tracks_that_cannot_be_on_a_page_are_refused() {
    let folder = Folder::new();
    write_tracks(&folder);
    let live = |options: &str| folder.type_in(&format!("live itu:urban --size 300 {options} -o page.html"));
    let away = "x,y,h\n3,3,5\n9e6,3,5\n";
    folder.write("away.csv", away);
    for (options, code, error) in [
        ("--every 3", 2, "E116"),
        ("--follow-ground", 2, "E116"),
        ("--track walk.csv --follow-ground", 2, "E116"),
        ("--track none.csv", 3, "E301"),
        ("--track away.csv", 5, "E502"),
        ("--track away.csv --every 100", 4, "E203"),
    ] {
        let answer = live(options);
        assert_eq!((answer.code(), answer.error()), (code, error), "{options}: {answer:?}");
    }
    assert_eq!(folder.files(), ["away.csv", "flight.csv", "walk.csv"]);
}
