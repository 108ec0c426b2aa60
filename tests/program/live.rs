//! The live page: its engine gives the program's digests, its file holds all it needs, and what is too large is refused.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use serde_json::{Value, json};

use crate::needs::{has, has_program, truth};
use crate::plain_tiff::{Cells, PlainTiff};
use crate::program::Folder;
use crate::support::{Random, is_long};
use crate::texts::squares;

/// Placements over each scene.
const N_PLACES: usize = 20;

/// A tool beside the tests.
pub(crate) fn tool(name: &str) -> String {
    format!("{}/tests/tools/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// What the engine of a page says of its scene, and its answers to questions, in Node or, with what drives one, a browser.
pub(crate) fn ask(page: &str, driver: Option<&str>, questions: &[Value]) -> Vec<Value> {
    let mut node = Command::new("node");
    let script = if driver.is_some() { "live_chromium.mjs" } else { "live.mjs" };
    node.args(["--no-warnings", &tool(script), page]);
    node.env("NODE_PATH", format!("{}/node_modules", driver.unwrap_or_default()));
    let mut node = node.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let lines: String = questions.iter().map(|question| format!("{question}\n")).collect();
    node.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
    let answer = node.wait_with_output().unwrap();
    assert!(answer.status.success(), "{page}");
    let said = String::from_utf8(answer.stdout).unwrap();
    said.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// A question for the map of UAVs at x, y and a height above the ground.
pub(crate) fn map(uavs: &[(f64, f64, f64)]) -> Value {
    let uav = |(k, (x, y, m)): (usize, &(f64, f64, f64))| json!({"id": (k + 1).to_string(), "x": x, "y": y, "height": {"kind": "agl", "m": m}});
    let uavs: Vec<Value> = uavs.iter().enumerate().map(uav).collect();
    let sight = json!({"rx_height": 1.5, "receivers": "ground", "radius": null});
    json!({"do": "map", "uavs": uavs, "sight": sight, "shown": {"layer": "one", "which": 0}, "picture": false})
}

/// Holds the digests and counts of a page against those of maps of its scene.
///
/// In Node, and in a browser if one is given.
fn check_scene(scene: &str, seed: u64, driver: Option<&str>) {
    let folder = Folder::new();
    folder.type_in(&format!("live {scene} -o page.html -o page.json -q")).done();
    let extent: Vec<f64> = serde_json::from_value(folder.json("page.json")["scene"]["extent"].clone()).unwrap();
    let mut random = Random(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * random.below(100_000) as f64 / 100_000.0;
    let places: Vec<(f64, f64, f64)> = (0..N_PLACES)
        .map(|_| (between(extent[0], extent[2]), between(extent[1], extent[3]), between(60.0, 200.0)))
        .collect();
    let rows: String = places.iter().map(|(x, y, h)| format!("{x},{y},{h}\n")).collect();
    folder.write("uavs.csv", &format!("x,y,h\n{rows}"));
    folder.type_in(&format!("map {scene} --uavs uavs.csv -o m-{{site}}.json -q")).done();
    let wanted: Vec<Value> = (1..=N_PLACES).map(|k| folder.json(&format!("m-{k}.json"))).collect();

    let questions: Vec<Value> = places.iter().flat_map(|place| [map(&[*place]), json!({"do": "digest"})]).collect();
    for driver in [None, driver].into_iter().take(1 + usize::from(driver.is_some())) {
        let answers = ask(&folder.word("page.html"), driver, &questions);
        for (pair, wanted) in answers[1..].chunks(2).zip(&wanted) {
            let (seen, site) = (&pair[0]["uavs"][0], &wanted["sites"][0]);
            assert_eq!((&seen["receivers"], &seen["los"]), (&site["receivers"], &site["los"]), "{scene}: {seen}");
            assert_eq!(pair[1]["digest"], wanted["digest"], "{scene}: {site}");
        }
    }
}

#[test]
fn the_engine_of_a_page_gives_the_digests_of_the_program() {
    if !has_program("node") {
        return;
    }
    let driver = driver();
    let driver = driver.as_deref();
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    let map = |name: &str| maps.join(name).to_str().unwrap().to_string();
    check_scene(&map("munich.geojson"), 1, driver);
    let driver_of_all = driver.filter(|_| is_long());
    check_scene(&format!("{} --terrain {}", map("munich_dsm.tif"), map("munich_terrain.tif")), 2, driver_of_all);
    check_scene("itu:urban", 3, driver_of_all);
    check_scene("itu:high-rise --size 700", 4, driver_of_all);
    let roofs = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/lod2/delft.city.json");
    check_scene(&format!("{} --roofs lod2", roofs.display()), 8, driver_of_all);
    // A minute more.
    let Some(truth) = truth().filter(|_| is_long()) else { return };
    let delft = |name: &str| truth.join("lidar/delft").join(name).to_str().unwrap().to_string();
    check_scene(&format!("{} --terrain {}", delft("dsm_1m.tif"), delft("terrain_1m.tif")), 5, driver);
    check_scene(&format!("{} --terrain {}", delft("buildings.geojson"), delft("terrain_1m.tif")), 6, driver);
    check_scene(&delft("dsm_with_vegetation_1m.tif"), 7, driver);
}

/// Cells without data, roofs, ranges and zones are those of the program.
#[test]
fn masks_of_all_receivers_and_ranges_are_those_of_the_program() {
    if !has_program("node") {
        return;
    }
    let folder = Folder::new();
    let munich = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    let munich = munich.display();
    folder.type_in(&format!("live {munich} -o page.html -q")).done();
    let receivers = ["ground", "street", "crossroad", "courtyard", "roof", "all", "air"];
    let sights: Vec<(&str, f64, Option<f64>)> =
        receivers.iter().flat_map(|which| [(*which, 1.5, None), (*which, 20.0, Some(333.3))]).collect();
    let questions: Vec<Value> = sights
        .iter()
        .flat_map(|(receivers, rx_height_m, radius_m)| {
            // The second is near the border, where much of what is in range holds no data.
            let mut map = map(&[(691_549.7, 5_334_762.2, 60.0), (690_950.0, 5_334_900.0, 90.0)]);
            map["sight"] = json!({"rx_height": rx_height_m, "receivers": receivers, "radius": radius_m});
            [map, json!({"do": "digest"})]
        })
        .collect();
    let answers = ask(&folder.word("page.html"), None, &questions);
    for (pair, (receivers, rx_height_m, radius_m)) in answers[1..].chunks(2).zip(&sights) {
        let radius = radius_m.map_or(String::new(), |radius| format!("--radius {radius}"));
        let uavs = "--uav 691549.7,5334762.2,60 --uav 690950,5334900,90";
        let line = format!("map {munich} {uavs} --receivers {receivers} --rx-height {rx_height_m} {radius} --json -q");
        let wanted = folder.type_in(&line).done().json();
        assert_eq!(pair[1]["digest"], wanted["digest"], "{line}");
        let union = [&pair[0]["all"]["receivers"], &pair[0]["all"]["los"]];
        assert_eq!(union, [&wanted["union"]["receivers"], &wanted["union"]["los"]], "{line}");
    }
}

#[test]
fn several_uavs_zones_links_and_curves_are_those_of_the_program() {
    if !has_program("node") {
        return;
    }
    let folder = Folder::new();
    folder.type_in("live itu:urban --size 300 -o page.html -q").done();
    let places = [(150.0, 150.0, 100.0), (40.0, 220.0, 60.0), (30.0, 30.0, 1.0)];
    let mut radius = map(&places[..2]);
    radius["sight"] = json!({"rx_height": 2.0, "receivers": "street", "radius": 90.0});
    let mut antenna = map(&places[..2]);
    antenna["sight"] = json!({"min_radius": 7.0, "sector": [20.0, 200.0], "elevation": [-80.0, -20.0],
        "beam": 130.0, "slant_range": 190.0});
    let mut curved = map(&places[..2]);
    curved["sight"] = json!({"rx_height": 60.0, "receivers": "air", "earth_k": 0.0005});
    let mut off = map(&places[..2]);
    off["sight"] = json!({"height_error": 2.5});
    let questions = [
        map(&places[..2]),
        json!({"do": "digest"}),
        json!({"do": "link", "which": 0, "x": 20.5, "y": 12.5}),
        json!({"do": "cell", "which": 0, "x": 20.5, "y": 12.5}),
        json!({"do": "curve", "which": 0}),
        radius,
        json!({"do": "digest"}),
        map(&places),
        json!({"do": "digest"}),
        json!({"do": "best", "which": 0, "radius_m": 60.0}),
        json!({"do": "link", "which": 2, "x": 1.0, "y": 1.0}),
        antenna,
        json!({"do": "digest"}),
        json!({"do": "curve", "which": 0}),
        curved,
        json!({"do": "digest"}),
        json!({"do": "link", "which": 0, "x": 20.5, "y": 12.5}),
        json!({"do": "curve", "which": 0}),
        off,
        json!({"do": "digest"}),
    ];
    let answers = ask(&folder.word("page.html"), None, &questions);
    let said = |line: &str| folder.type_in(&format!("{line} --json -q")).done().json();

    let two = said("map itu:urban --size 300 --uav 150,150,100 --uav 40,220,60 --zones");
    assert_eq!(answers[2]["digest"], two["digest"]);

    // Heights that may be off change what is sure, and no mask.
    let bounded = "--height-error 2.5 --sigma 1 --layers los,sure -o sure.tif";
    let bounded = said(&format!("map itu:urban --size 300 --uav 150,150,100 --uav 40,220,60 {bounded}"));
    assert_eq!((&answers[20]["digest"], &bounded["digest"]), (&two["digest"], &two["digest"]));
    for (seen, site) in answers[19]["uavs"].as_array().unwrap().iter().zip(bounded["sites"].as_array().unwrap()) {
        let sure = &site["uncertain"]["sure"];
        assert_eq!(seen["sure"], json!([sure["surely"], sure["possibly"]]));
        assert!(sure["possibly"].as_u64() > Some(1000) && seen["los"] == site["los"]);
    }
    for (seen, site) in answers[1]["uavs"].as_array().unwrap().iter().zip(two["sites"].as_array().unwrap()) {
        for zone in ["street", "crossroad", "courtyard", "rooftop"] {
            let counts = |facts: &Value| [&facts["receivers"], &facts["los"]].map(|n| n.as_u64().unwrap_or(0));
            assert_eq!(counts(&seen["zones"][zone]), counts(&site["zones"][zone]), "{zone}");
        }
    }
    assert_eq!(
        (&answers[1]["all"]["los"], &answers[1]["all"]["receivers"]),
        (&two["union"]["los"], &two["union"]["receivers"])
    );

    let link = said("link itu:urban --size 300 --uav 150,150,100 --rx 20.5,12.5");
    assert_eq!((&answers[3]["los"], &answers[3]["margin_m"]), (&link["los"], &link["margin_m"]));
    for key in ["distance_m", "elevation_deg"] {
        // Roots and angles of libraries differ in the last bit.
        assert!((answers[3][key].as_f64().unwrap() - link[key].as_f64().unwrap()).abs() < 1e-9, "{key}");
    }
    assert_eq!(answers[3]["obstruction"]["x"], link["obstruction"]["x"]);
    assert_eq!((&answers[4]["sees"][0], &answers[4]["margin_m"]), (&link["los"], &link["margin_m"]));

    // The curve counts at its UAV's height what the map counts.
    let check_curve = |curve: &Value, map: &Value| {
        let (heights, los) = (curve["heights_m"].as_array().unwrap(), curve["los"].as_array().unwrap());
        let below = heights.iter().filter(|height| height.as_f64().unwrap() <= 100.0).count();
        assert_eq!(los[below - 1], map["sites"][0]["los"]);
        assert_eq!(curve["receivers"], map["sites"][0]["receivers"]);
        assert!(los.last().unwrap().as_u64() <= curve["receivers"].as_u64());
    };
    check_curve(&answers[5], &two);

    let near =
        said("map itu:urban --size 300 --uav 150,150,100 --uav 40,220,60 --receivers street --radius 90 --rx-height 2");
    assert_eq!(answers[7]["digest"], near["digest"]);
    let served = said(
        "map itu:urban --size 300 --uav 150,150,100 --uav 40,220,60 --sector 20,200 --elevation -80,-20 --beam 130 --min-radius 7 --slant-range 190",
    );
    assert_eq!(answers[13]["digest"], served["digest"]);
    assert!(answers[14].to_string().contains("no curve"), "{}", answers[14]);

    let in_air = "--uav 150,150,100 --uav 40,220,60 --receivers air --rx-height 60 --earth-k 0.0005";
    let curved = said(&format!("map itu:urban --size 300 {in_air}"));
    assert_eq!(answers[16]["digest"], curved["digest"]);
    check_curve(&answers[18], &curved);
    let link = said("link itu:urban --size 300 --uav 150,150,100 --rx 20.5,12.5,60 --earth-k 0.0005");
    assert_eq!((&answers[17]["los"], &answers[17]["margin_m"]), (&link["los"], &link["margin_m"]));

    // Inside a building nothing can hover: the others are mapped, and it says from where on it could.
    let refused = &answers[8]["uavs"][2];
    assert_eq!((&refused["ok"], &refused["code"]), (&json!(false), &json!("E201")));
    assert!(refused["lowest_amsl_m"].as_f64().unwrap() > 1.0 && answers[8]["uavs"][0]["ok"] == json!(true));
    assert_eq!(answers[9]["digest"], Value::Null);
    // The place where it is was tried first.
    let best = answers[10]["best"]["los"].as_u64().unwrap();
    assert!(best >= two["sites"][0]["los"].as_u64().unwrap() && answers[10]["tried"].as_u64().unwrap() > 300);
    assert_eq!(answers[11]["ok"], json!(false));
}

#[test]
fn a_page_is_one_small_file_and_says_what_it_begins_with() {
    let folder = Folder::new();
    let munich = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    let uavs = "--uav 691600,5334700,120 --uav 691549.7,5334762.2,60amsl --rx-height 2 --radius 400";
    folder.type_in(&format!("live {} {uavs} -o page.html -o page.json -q", munich.display())).done();
    assert!(folder.read("page.html").len() <= 1_000_000, "{}", folder.read("page.html").len());
    let document = folder.json("page.json");
    assert_eq!(document["schema"], "skyshed/live/1");
    assert_eq!((&document["uavs"][1]["id"], &document["uavs"][1]["height"]), (&json!("2"), &json!("60amsl")));
    assert_eq!((&document["rx_height_m"], &document["radius_m"]), (&json!(2.0), &json!(400.0)));
    // Nothing is fetched: no address of a host stands in it but those that are words.
    let page = folder.text("page.html");
    assert!(page.contains("default-src 'none'"));
    // An attribute stands behind a space, of which packed text has none.
    for tag in ["<link", "<img", "<iframe", " src=", "@import", "url(http"] {
        assert!(!page.contains(tag), "{tag}");
    }
    let Some(truth) = truth() else { return };
    let delft = truth.join("lidar/delft/dsm_1m.tif");
    folder.type_in(&format!("live {} -o delft.html -q", delft.display())).done();
    let most = std::fs::metadata(&delft).unwrap().len() * 3 / 2 + 740_000;
    assert!(folder.read("delft.html").len() as u64 <= most, "{} {most}", folder.read("delft.html").len());
}

#[test]
fn words_of_the_data_are_text() {
    let folder = Folder::new();
    let hostile = "</script><script>window.hacked=1</script><img src=x onerror=window.hacked=1>{{engine}}";
    let square = json!([[[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]]]);
    let features = json!([{"type": "Feature", "id": hostile, "properties": {"height": 9},
                           "geometry": {"type": "Polygon", "coordinates": square}}]);
    let city = json!({"type": "FeatureCollection", "attribution": hostile, "features": features});
    folder.write("city.geojson", &city.to_string());
    folder.run(&["live", "city.geojson", "--uav", "4,4,50", "--title", hostile, "-o", "page.html", "-q"]).done();
    let page = folder.text("page.html");
    assert!(!page.contains("<script>window") && !page.contains("<img"));
    // A mark in words stays a word: the engine stands there once.
    let engine = page.split_once("id=\"engine\">").unwrap().1;
    assert!(page.contains("{{engine}}") && page.matches(&engine[..200]).count() == 1);
}

#[test]
fn what_a_page_cannot_hold_is_refused_with_what_would_fit() {
    let folder = Folder::new();
    let hint = |line: &str, code: i32| {
        let answer = folder.type_in(&format!("live {line} -o none.html"));
        assert_eq!((answer.code(), answer.error()), (code, "E505"), "{answer:?}");
        answer.err.lines().find_map(|line| line.strip_prefix("hint: ").map(str::to_string)).unwrap_or_default()
    };
    // What is between backticks after a flag, as it may be typed.
    let flag = |hint: &str, name: &str| {
        let rest = hint.split_once(&format!("`{name} ")).unwrap_or_else(|| panic!("{hint}: no {name}")).1;
        format!("{name} {}", rest.split('`').next().unwrap())
    };
    let fits = |line: &str| {
        folder.type_in(&format!("live {line} -o page.html --overwrite -q")).done();
    };
    let generated = hint("itu:urban --size 5000", 5);
    fits(&format!("itu:urban --size 5000 {}", flag(&generated, "--cell")));
    fits(&format!("itu:urban {}", flag(&generated, "--size")));

    folder.write("house.geojson", &squares(&[[0.0, 0.0, 50.0, 9.0]]));
    let wide = "house.geojson --crs EPSG:25832 --extent 0,0,9000,3000";
    let footprints = hint(wide, 5);
    fits(&format!("{wide} {}", flag(&footprints, "--cell")));
    fits(&format!("house.geojson --crs EPSG:25832 {}", flag(&footprints, "--extent")));

    // A raster of 4500 × 4000 cells: of it a page takes what is in range of its UAVs, which is a map of that part.
    let values = (0..4500 * 4000).map(|k| f64::from(k / 700 % 7 * 3)).collect();
    let raster =
        PlainTiff { cells: Cells::Int16, rows_per_strip: 500, ..PlainTiff::floats((0.0, 4000.0), 1.0, 4500, values) };
    std::fs::write(folder.join("large.tif"), raster.bytes()).unwrap();
    let most: f64 = hint("large.tif", 5).rsplit_once(' ').unwrap().1.parse().unwrap();
    assert!((2000.0..2048.0).contains(&most), "{most}");
    fits(&format!("large.tif --uav 2100,2000,90 --radius {most}"));
    let uav = "large.tif --uav 700,900,90 --radius 150";
    fits(uav);
    assert!(folder.text("page.html").contains("\"is_part\":true"));
    folder.type_in(&format!("map {uav} -o m-{{site}}.json -q")).done();
    if has_program("node") {
        let mut part = map(&[(700.0, 900.0, 90.0)]);
        part["sight"]["radius"] = json!(150.0);
        let answers = ask(&folder.word("page.html"), None, &[part, json!({"do": "digest"})]);
        assert_eq!(answers[2]["digest"], folder.json("m-1.json")["digest"]);
    }
    let rows: String = (0..33).map(|k| format!("{k},5,90\n")).collect();
    folder.write("uavs.csv", &format!("x,y,h\n{rows}"));
    hint("itu:urban --size 100 --uavs uavs.csv", 5);
    if is_long() {
        let many = hint("itu:0.3,5000,15 --size 8000 --cell 4", 5);
        fits(&format!("itu:0.3,5000,15 --cell 4 {}", flag(&many, "--size")));
    }
    assert!(!folder.join("none.html").exists());
}

/// The demonstration in the manual is what the program writes.
#[test]
#[cfg(unix)]
fn the_page_in_docs_is_that_of_the_program() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = Folder::new();
    std::os::unix::fs::symlink(root.join("maps"), folder.join("maps")).unwrap();
    folder.type_in("live maps/munich.geojson --uav 691549.7,5334762.2,120 -o live.html -q").done();
    let (path, wanted) = (root.join("docs/live.html"), folder.read("live.html"));
    if std::env::var_os("SKYSHED_WRITE_DOCS").is_some() {
        std::fs::write(&path, &wanted).unwrap();
    }
    assert!(std::fs::read(&path).unwrap_or_default() == wanted, "docs/live.html: run with SKYSHED_WRITE_DOCS=1");
}

/// Scripts are checked by the types that stand in their comments.
#[test]
fn the_scripts_of_the_page_are_of_their_types() {
    if !has_program("npx") {
        return;
    }
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/render/src/live_page");
    let check = ["--yes", "-p", "typescript@5.9", "tsc", "-p"];
    let done = Command::new("npx").args(check).arg(page).output().unwrap();
    let said = String::from_utf8_lossy(&done.stdout);
    if !done.status.success() && !said.contains("error TS") {
        has("typescript", false);
        return;
    }
    assert!(done.status.success(), "{said}");
}

/// The folder of what drives a browser, from the registry; `None` (and a line that says so) without it or a browser.
pub(crate) fn driver() -> Option<String> {
    // Tests that run side by side install it once.
    static FOLDER: OnceLock<Option<String>> = OnceLock::new();
    FOLDER.get_or_init(installed_driver).clone()
}

fn installed_driver() -> Option<String> {
    if !has_program("chromium") || !has_program("npm") {
        return None;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("browser-driver");
    if !folder.join("node_modules/playwright-core").is_dir() {
        std::fs::create_dir_all(&folder).unwrap();
        let install = ["install", "--silent", "--no-save", "--prefix", ".", "playwright-core@1.65"];
        let done = Command::new("npm").args(install).current_dir(&folder).output();
        if !done.is_ok_and(|done| done.status.success()) {
            has("playwright", false);
            return None;
        }
    }
    folder.to_str().map(str::to_string)
}

#[test]
fn a_browser_drags_types_adds_clicks_keeps_exports_and_reloads() {
    let Some(driver) = driver() else { return };
    let folder = Folder::new();
    let munich = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    folder.type_in(&format!("live {} --uav 691549.7,5334762.2,120 -o page.html -q", munich.display())).done();
    let uavs = "--uav 691549.7,5334762.2,120 --uav 691600,5334700,80";
    folder.type_in(&format!("compare {} {uavs} -o compare.html -q", munich.display())).done();
    let pictures = std::env::var_os("SKYSHED_PICTURES").unwrap_or_else(|| folder.path().into());
    let done = Command::new("node")
        .args([&tool("live_browser.mjs"), &folder.word("page.html")])
        .arg(&pictures)
        .arg(folder.word("compare.html"))
        // The dark one has the size of the desk.
        .args(if is_long() || std::env::var_os("SKYSHED_PICTURES").is_some() { &[][..] } else { &["desk", "phone"] })
        .env("NODE_PATH", format!("{driver}/node_modules"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success(), "{said}\n{}", String::from_utf8_lossy(&done.stderr));
    // What the page exported is what the program reads, and its digest that of the program.
    let facts: Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
    let place = &facts["uav"];
    let uav = format!("{},{},{}", place["x"], place["y"], place["height"]["m"]);
    let map = folder.type_in(&format!("map {} --uav {uav} --json -q", munich.display())).done().json();
    assert_eq!(facts["digest"], map["digest"]);
    folder.write("kept.csv", facts["csv"].as_str().unwrap());
    folder.write("kept.geojson", facts["geojson"].as_str().unwrap());
    for table in ["kept.csv", "kept.geojson"] {
        let compared = folder.type_in(&format!("compare {} --uavs {table} --json -q", munich.display())).done().json();
        assert_eq!(compared["placements"].as_array().map(Vec::len), Some(2), "{table}");
    }
    // And so is the command line that gives the same.
    let words: Vec<&str> = facts["command"].as_str().unwrap().split_whitespace().skip(1).collect();
    assert_eq!(words[0], "map", "{words:?}");
}
