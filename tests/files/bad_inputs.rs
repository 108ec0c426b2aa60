//! Every bad or odd file of the shared list gets its documented answer from the program, as a surface model or as
//! footprints: a refusal that names the file and leaves nothing behind, or a map, with a warning where one is due.
//!
//! Each run has less than 1 GB of address space and five seconds (see [`crate::program`]).

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::Value;

use crate::needs::truth;
use crate::program::{Answer, Folder, run_in};

fn bad() -> Option<PathBuf> {
    truth().map(|folder| folder.join("bad").canonicalize().expect("the folder of bad files"))
}

/// An entry of the list.
struct Entry {
    file: String,
    is_raster: bool,
    expect: String,
    same_as_good: bool,
}

fn list(folder: &Path) -> Vec<Entry> {
    let text = std::fs::read_to_string(folder.join("index.json")).expect("the list of bad files");
    let list: Value = serde_json::from_str(&text).expect("a list in JSON");
    let entry = |entry: &Value| {
        let field = |name: &str| entry[name].as_str().unwrap_or_default().to_string();
        Entry {
            file: field("file"),
            is_raster: field("kind") == "raster",
            expect: field("expect"),
            same_as_good: field("good_answer").contains("same result as good/dsm.tif"),
        }
    };
    list.as_array().expect("an array").iter().map(entry).collect()
}

/// How a file is put to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Way {
    /// `skyshed info`.
    Info,
    /// As the surface model over the good terrain, or as footprints on it.
    OnTerrain,
    /// As the good surface's terrain.
    AsTerrain,
    /// As the surface model over flat ground.
    OnGround,
    /// As footprints and nothing else.
    Alone,
}

fn ways(entry: &Entry) -> &'static [Way] {
    if entry.file.ends_with("terrain_above_dsm.tif") {
        &[Way::Info, Way::AsTerrain, Way::OnGround]
    } else if entry.is_raster {
        &[Way::Info, Way::OnTerrain, Way::OnGround]
    } else {
        &[Way::Info, Way::OnTerrain, Way::Alone]
    }
}

/// What the list leaves open, and what this program does: file, ways, and the code of the refusal.
const REFUSED: [(&str, &[Way], &str); 14] = [
    // Nothing but the terrain could say where these lie.
    ("geojson/empty_featurecollection.geojson", &[Way::Alone, Way::Info], "E308"),
    // Degrees: the distances of a map would be wrong.
    ("raster_upstream/gdal_float32_minwhite.tif", &[Way::Info, Way::OnTerrain, Way::OnGround], "E310"),
    // Made elsewhere: another reference system than the good terrain, or another place.
    ("raster/epsg3857_webmercator.tif", &[Way::OnTerrain], "E311"),
    ("raster_upstream/gdal_nan32_nodata.tif", &[Way::OnTerrain], "E311"),
    ("raster_upstream/gdal_float16.tif", &[Way::OnTerrain], "E311"),
    ("raster_upstream/gdal_6band_wrong_number_extrasamples.tif", &[Way::OnTerrain], "E311"),
    ("raster_upstream/gdal_nan32.tif", &[Way::OnTerrain], "E312"),
    ("raster_upstream/gdal_stats_nodata_neginf.tif", &[Way::OnTerrain], "E312"),
    ("raster_upstream/rasterio_float_nan.tif", &[Way::OnTerrain], "E312"),
    // Heights that overflow and text that is not UTF-8: the list takes a refusal or a warning.
    ("geojson/height_1e400.geojson", &[Way::OnTerrain, Way::Alone, Way::Info], "E302"),
    ("geojson/invalid_utf8.geojson", &[Way::OnTerrain, Way::Alone, Way::Info], "E302"),
    // More than 2 % of the footprint area without a height: a map would show ground where houses stand. `info` warns.
    ("geojson/null_properties.geojson", &[Way::OnTerrain, Way::Alone], "E309"),
    ("geojson/height_null.geojson", &[Way::OnTerrain, Way::Alone], "E309"),
    ("geojson/height_bool_object.geojson", &[Way::OnTerrain, Way::Alone], "E309"),
];

/// One answer with what it left behind.
struct Outcome {
    answer: Answer,
    /// The file written by `-o map.json`, where there is one.
    document: Option<Value>,
    files: Vec<String>,
}

/// Runs the program on `file` in one way, with a UAV at `uav`.
fn run(folder: &Path, file: &str, way: Way, uav: &str) -> Outcome {
    let out = Folder::new();
    let (png, tif, json) = (out.word("map.png"), out.word("map.tif"), out.word("map.json"));
    let outputs = ["--uav", uav, "-o", &png, "-o", &tif, "-o", &json];
    let mut words: Vec<&str> = match way {
        Way::Info => vec!["info", file, "--json"],
        Way::OnTerrain => vec!["map", file, "--terrain", "good/terrain.tif"],
        Way::AsTerrain => vec!["map", "good/dsm.tif", "--terrain", file],
        Way::OnGround => vec!["map", file, "--ground", "10"],
        Way::Alone => vec!["map", file],
    };
    if way != Way::Info {
        words.extend(outputs);
    }
    let answer = run_in(folder, &words);
    let files = out.files();
    let document = files.iter().any(|f| f == "map.json").then(|| out.json("map.json"));
    Outcome { answer, document, files }
}

/// Checks what holds of every run, and returns the code of the error if it was refused.
fn refusal(file: &str, way: Way, outcome: &Outcome) -> Option<String> {
    let (answer, files) = (&outcome.answer, &outcome.files);
    let code = answer.code();
    assert!(matches!(code, 0 | 3 | 4 | 5), "{file} {way:?}: {answer:?}");
    if code == 0 {
        if way == Way::Info {
            assert!(answer.json().is_object(), "{file}: {answer:?}");
        } else {
            assert_eq!(answer.out, "", "{file} {way:?}");
            assert_eq!(files, &["map.json", "map.png", "map.tif", "map.tif.aux.xml"], "{file} {way:?}");
            let document = outcome.document.as_ref().expect("map.json");
            let site = &document["sites"][0];
            assert!(site["p_los"].is_number() || site["reason"].is_string(), "{file} {way:?}: {site}");
        }
        return None;
    }
    let lines = answer.refused(code);
    assert!(lines[0].contains(file), "{file} {way:?}: the error does not name the file: {lines:?}");
    assert!(lines.len() <= 2, "{file} {way:?}: one line and a hint: {lines:?}");
    assert!(lines.get(1).is_none_or(|hint| hint.starts_with("hint: ")), "{file} {way:?}: {lines:?}");
    assert!(files.is_empty(), "{file} {way:?}: left behind {files:?}");
    Some(answer.error().to_string())
}

/// The UAV of the good scene; where that is not over what `info` found, one well above the middle of it.
fn uav_for(info: &Outcome) -> String {
    let good = "500032,5000032,60".to_string();
    if info.answer.code() != 0 {
        return good;
    }
    let document = info.answer.json();
    let extent: Vec<f64> = document["extent"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    if (extent[0]..extent[2]).contains(&500_032.0) && (extent[1]..extent[3]).contains(&5_000_032.0) {
        return good;
    }
    let top = document["surface_m"][1].as_f64().unwrap_or(0.0).max(10.0);
    format!("{},{},{}amsl", (extent[0] + extent[2]) / 2.0, (extent[1] + extent[3]) / 2.0, top + 60.0)
}

/// Runs one file in all its ways and checks each answer against the list.
fn check(folder: &Path, entry: &Entry, good: &HashMap<Way, Value>) {
    let file = entry.file.as_str();
    let info = run(folder, file, Way::Info, "");
    let uav = uav_for(&info);
    for &way in ways(entry) {
        let outcome = run(folder, file, way, &uav);
        let code = refusal(file, way, &outcome);
        let chosen =
            REFUSED.iter().find(|(name, ways, _)| *name == file && ways.contains(&way)).map(|(_, _, code)| *code);
        if let Some(chosen) = chosen {
            assert_eq!(code.as_deref(), Some(chosen), "{file} {way:?}: {:?}", outcome.answer);
            continue;
        }
        let (expect, err) = (entry.expect.as_str(), &outcome.answer.err);
        match &code {
            Some(_) => assert!(expect.contains("reject") || expect == "no-crash", "{file} {way:?}, {expect}: {err}"),
            None => {
                let accepted = expect.contains("accept") || expect == "no-crash";
                // What is odd only beside a surface, or only on a map, needs no warning elsewhere.
                let of_maps = way == Way::Info || file.ends_with("terrain_above_dsm.tif") && way != Way::AsTerrain;
                let warned = expect.contains("warn") && (of_maps || !outcome.answer.warnings().is_empty());
                assert!(accepted || warned, "{file} {way:?}, wanted {expect}: {err}");
            }
        }
        if entry.same_as_good && way != Way::Info {
            let document = outcome.document.expect("a map");
            assert_eq!(document["digest"], good[&way]["digest"], "{file} {way:?}");
            assert_eq!(document["sites"], good[&way]["sites"], "{file} {way:?}");
        }
    }
}

#[test]
fn every_file_of_the_list_gets_its_documented_answer() {
    let Some(folder) = bad() else { return };
    let entries = list(&folder);
    let good = [Way::OnTerrain, Way::OnGround].map(|way| {
        let outcome = run(&folder, "good/dsm.tif", way, "500032,5000032,60");
        assert_eq!(outcome.answer.done().warnings(), [""; 0], "{way:?}");
        (way, outcome.document.expect("a map of the good surface"))
    });
    let good = HashMap::from(good);
    let next = AtomicUsize::new(0);
    let failures: Mutex<Vec<String>> = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(entry) = entries.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let checked =
                        std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| check(&folder, entry, &good)));
                    if checked.is_err() {
                        failures.lock().unwrap().push(entry.file.clone());
                    }
                }
            });
        }
    });
    assert_eq!(failures.into_inner().unwrap(), [""; 0], "files with another answer than documented");
    assert_eq!(entries.len(), 102);
    assert_eq!(entries.iter().filter(|e| e.same_as_good).count(), 6);
}

#[test]
fn a_refusal_says_what_where_and_what_to_do() {
    let Some(folder) = bad() else { return };
    for (words, code, found, hint) in [
        ("raster/truncated_half.tif", "E303", "strip 0 (8192 bytes at byte 368)", "fetch it again"),
        ("raster/header_only_6b.tif", "E303", "has 6 bytes", ""),
        ("raster/text.tif", "E302", "line 3: `this`", ""),
        (
            "raster/compression_unknown_999.tif",
            "E304",
            "compression `999`",
            "the header is damaged: fetch the file again",
        ),
        ("raster/complex64.tif", "E304", "64-bit complex samples", "gdal_translate -ot Float32"),
        (
            "raster/all_nodata.tif",
            "E305",
            "none of the 4096 cells",
            "gdal_translate -a_nodata none raster/all_nodata.tif",
        ),
        (
            "raster/rotated.tif",
            "E306",
            "-15.0 degrees off east",
            "-9999 raster/rotated.tif raster/rotated_north_up.tif`",
        ),
        (
            "raster/epsg3857_webmercator.tif --terrain good/terrain.tif",
            "E311",
            "in EPSG:3857 with good/terrain.tif in EPSG:32632",
            "`--project auto` takes both",
        ),
        (
            "raster_upstream/rasterio_float_nan.tif --terrain good/terrain.tif",
            "E312",
            "(3×2 cells of 100×100 from (0, 200)) with good/terrain.tif (64×64 cells of 1×1 from (500000, 5000064))",
            "`skyshed info`",
        ),
        ("geojson/height_NaN_literal.geojson", "E302", "line 1 column 169", ""),
        ("geojson/coord_1number.geojson", "E302", "feature 1: found a position with one number", ""),
        ("geojson/trailing_garbage.geojson", "E302", "line 1 column 335", ""),
        ("geojson/array_top_level.geojson", "E302", "found an array", ""),
        (
            "geojson/latlon_wgs84.geojson",
            "E310",
            "in degrees (EPSG:4326)",
            "`--project auto`, or `ogr2ogr -s_srs EPSG:4326 -t_srs EPSG:32632 geojson/latlon_wgs84_32632.geojson",
        ),
        (
            "geojson/empty_featurecollection.geojson",
            "E308",
            "",
            "`--extent W,S,E,N`, or a terrain with `--terrain FILE`",
        ),
        ("raster/sparse_200000x200000.tif", "E501", "200000 columns x 200000 rows need 149.0 GiB", "--radius"),
    ] {
        let answer = typed(&folder, &format!("info {words}"));
        assert_eq!(answer.error(), code, "{words}: {answer:?}");
        let file = words.split(' ').next().unwrap();
        let told = [file, found, hint].iter().all(|words| answer.err.contains(words));
        assert!(told && answer.err.contains("\nhint: ") != hint.is_empty(), "{words}: {answer:?}");
    }
}

/// What a line without quotes leaves.
fn typed(folder: &Path, line: &str) -> Answer {
    run_in(folder, &line.split_whitespace().collect::<Vec<_>>())
}

/// The map of a scene given by `words`, as its JSON document, with what else was said.
fn map(folder: &Path, words: &str) -> (Value, Answer) {
    let answer = typed(folder, &format!("map --json {words}")).done();
    (answer.json(), answer)
}

#[test]
fn a_terrain_on_another_grid_is_brought_to_that_of_the_surface_with_a_warning() {
    let Some(folder) = bad() else { return };
    // The good terrain is flat at 10 m, so wherever it reaches, the map is that over `--ground 10`.
    for (name, uav, grid) in [
        ("col_Nx1.tif", "500000.5,5000032,60", "(1×64 cells of 1×1 from (500000, 5000064))"),
        ("cog_overviews.tif", "500032,5000032,60", ""),
        ("one_cell.tif", "500000.5,5000063.5,60", ""),
    ] {
        let (on_terrain, answer) = map(&folder, &format!("raster/{name} --terrain good/terrain.tif --uav {uav}"));
        let (on_ground, _) = map(&folder, &format!("raster/{name} --ground 10 --uav {uav}"));
        assert_eq!(answer.warnings(), ["W346"], "{name}");
        let of_terrain = "good/terrain.tif (64×64 cells of 1×1 from (500000, 5000064))";
        assert!(answer.err.contains(of_terrain) && answer.err.contains(grid), "{answer:?}");
        assert_eq!(on_terrain["digest"], on_ground["digest"], "{name}");
    }
    // A surface that reaches beyond its terrain has nodata there: 256 m of surface, 64 m of terrain in its north-west.
    let (beyond, answer) =
        map(&folder, "raster/enc_jpeg_uint8.tif --terrain good/terrain.tif --uav 500032,5000032,100");
    assert!(answer.warnings().contains(&"W346"), "{answer:?}");
    let receivers = beyond["sites"][0]["receivers"].as_u64().unwrap();
    assert!((1..=64 * 64).contains(&receivers), "{receivers}");
}

#[test]
fn odd_footprints_are_what_they_mean() {
    let Some(folder) = bad() else { return };
    let on = |name: &str, rest: &str| {
        let place = "--terrain good/terrain.tif --data-area all --uav 500032,5000032,60";
        map(&folder, &format!("{name}.geojson {place} {rest}"))
    };
    let cells = |name: &str| {
        let answer = typed(&folder, &format!("info geojson/{name}.geojson --terrain good/terrain.tif --json -q"));
        answer.done().json()["cells"]["building"].as_u64().unwrap()
    };
    // Edges through cell centers: a center on an edge is open ground, so 9 × 9 of 11 × 11 centers are inside.
    assert_eq!(cells("edges_on_cell_centres"), 81);
    // A bow tie by the even-odd rule: two triangles of 100 m² each, less the centers on their edges.
    assert_eq!(cells("bowtie"), 180);
    // No ground: P_LoS is null with its reason, and a warning says so.
    let (covered, answer) = on("geojson/polygon_covers_all", "");
    assert_eq!(answer.warnings(), ["W202"]);
    let site = &covered["sites"][0];
    assert_eq!((&site["receivers"], &site["p_los"]), (&0.into(), &Value::Null), "{site}");
    assert!(site["reason"].is_string(), "{site}");
    assert_eq!(covered["union"]["p_los"], Value::Null);
    // No buildings: everything is seen.
    let (empty, answer) = on("geojson/empty_featurecollection", "");
    assert_eq!(answer.warnings(), ["W359"]);
    assert_eq!(empty["sites"][0]["p_los"], 1.0);
    let good = on("good/buildings", "").0;
    assert_eq!(good["sites"][0]["receivers"], 64 * 64 - 140 - 144);
    // What was mended or left out is counted.
    for (name, rest, told) in [
        ("geojson/bowtie.geojson", "--data-area all", &[("W351", "1 polygon ")][..]),
        ("geojson/empty_coordinates.geojson", "--data-area all", &[("W353", "2 polygons ")]),
        ("geojson/height_comma.geojson", "--data-area all", &[("W356", "1 height ")]),
        (
            "raster/nan_patch.tif",
            "",
            &[("W320", "16 cells with NaN (rows 5 to 8, columns 5 to 8)"), ("W340", "16 cells ")],
        ),
    ] {
        let answer = typed(&folder, &format!("info {name} --terrain good/terrain.tif --json {rest}")).done();
        let lines: Vec<&str> = answer.err.lines().collect();
        assert_eq!(lines.len(), told.len(), "{name}: {lines:?}");
        for (line, (code, count)) in lines.iter().zip(told) {
            assert!(line.starts_with(&format!("warning[{code}]")) && line.contains(count), "{name}: {line}");
        }
    }
    // Without a height a footprint is left out where that is asked for, with a warning; `--missing fail` refuses it.
    let (dropped, answer) = on("geojson/null_properties", "--missing drop");
    assert_eq!((answer.warnings(), &dropped["sites"][0]["receivers"]), (vec!["W354"], &(64 * 64 - 140).into()));
    let answer = typed(&folder, "map geojson/null_properties.geojson --missing fail --uav 500032,5000032,60 --json");
    assert!(answer.error() == "E309" && answer.err.contains("feature `1` has no usable `height`"), "{answer:?}");
}

#[test]
fn a_minimum_is_white_raster_keeps_its_heights() {
    let Some(folder) = bad() else { return };
    let file = "raster_upstream/gdal_float32_minwhite.tif";
    let document = typed(&folder, &format!("info {file} --crs EPSG:32631 --json")).done().json();
    // 0.576 358 m on the lattice of 1/1024 m.
    assert_eq!(document["surface_m"], serde_json::json!([590.0 / 1024.0, 590.0 / 1024.0]));
}
