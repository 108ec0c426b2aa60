//! `skyshed place` from outside: what it answers, writes and refuses.

use serde_json::Value;

use crate::masks::mask_of;
use crate::program::Folder;
use crate::refusals::{check_flags_are_known, check_refusals};

/// A block of 20 m over x 20…30, y 20…30 among 50 × 50 cells, and a lower one.
const CITY: &str = r#"{"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": {"height": 20},
   "geometry": {"type": "Polygon", "coordinates": [[[20,20],[30,20],[30,30],[20,30],[20,20]]]}},
  {"type": "Feature", "properties": {"height": 5},
   "geometry": {"type": "Polygon", "coordinates": [[[5,5],[15,5],[15,12],[5,12],[5,5]]]}}]}"#;
const PLACE: &str = "place city.geojson --extent 0,0,50,50 --step 10";

fn polygon(ring: &str) -> String {
    format!(r#"{{"type": "Polygon", "coordinates": [[{ring}]]}}"#)
}

fn city() -> Folder {
    let folder = Folder::new();
    folder.write("city.geojson", CITY);
    folder.write("west.geojson", &polygon("[0,0],[20,0],[20,50],[0,50],[0,0]"));
    folder.write("far.geojson", &polygon("[900,900],[920,900],[920,950],[900,900]"));
    folder.write("own.csv", "x,y,h\n2,2,30\n25,25,5\n40,40,10\n");
    folder.write("people.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 25\nNODATA_value -9999\n0 3\n");
    folder.write("debt.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 25\n-1 3\n");
    folder
}

fn document(folder: &Folder, line: &str) -> Value {
    let mut document = folder.type_in(&format!("{PLACE} {line} --json -q")).done().json();
    let object = document.as_object_mut().unwrap();
    object.remove("timing_s");
    object.remove("command");
    document
}

#[test]
fn candidates_left_out_are_counted_by_hand() {
    let folder = city();
    // Places are at 5, 15, … 45 along both axes. (25, 25) is in the middle of the block of 20 m; (5, 5) is on the corner of
    // the low one, over its roof as what is north-east of it, but not inside: touching is not blocked.
    for (line, key, skipped, tried) in [
        ("--height 10", "inside", 1, 24),
        ("--height 3,30", "inside", 1, 49),
        ("--height 22 --clearance 5", "clearance", 1, 24),
        ("--height 30 --clearance 10", "clearance", 0, 25),
        ("--height 30 --keep-out west.geojson", "keep_out", 10, 15),
        ("--height 30 --within west.geojson", "outside", 15, 10),
        ("--height 30 --over rooftop", "other_zone", 23, 2),
        ("--height 5roof", "no_base", 23, 2),
    ] {
        let found = document(&folder, line);
        let candidates = &found["candidates"];
        assert_eq!(
            (&candidates["skipped"][key], &candidates["tried"]),
            (&skipped.into(), &tried.into()),
            "{line}: {candidates}"
        );
    }
}

#[test]
fn the_winner_is_what_a_map_from_there_counts() {
    let folder = city();
    for (line, map) in [
        ("--height 10,15", ""),
        ("--height 10,15 --radius 20", "--radius 20"),
        ("--height 10,15 --sector 30,200 --beam 140", "--sector 30,200 --beam 140"),
        ("--height 15 --goal p_los(street)", "--receivers street"),
        ("--height 15 --goal p_los(rooftop)", "--receivers roof"),
    ] {
        let found = document(&folder, line);
        for place in [&found["winner"], &found["refined"]] {
            let at = ["x", "y", "height_agl_m"].map(|key| place[key].to_string()).join(",");
            let line = format!("map city.geojson --extent 0,0,50,50 --uav {at} {map} --json -q");
            let site = folder.type_in(&line).done().json()["sites"][0].clone();
            assert_eq!(site["los"], place["los"], "{line}");
            // Within a range, too, the share is of all receivers, which the map without one counts.
            let of_all = line.replace("--radius 20", "").replace("--sector 30,200 --beam 140", "");
            let all = folder.type_in(&of_all).done().json()["sites"][0].clone();
            assert_eq!(all["receivers"], place["receivers"], "{line}");
        }
        let ranked: Vec<f64> =
            found["ranked"].as_array().unwrap().iter().map(|p| p["p_los"].as_f64().unwrap()).collect();
        assert!(ranked.len() == 10 && ranked.windows(2).all(|w| w[0] >= w[1]), "{ranked:?}");
    }
}

#[test]
fn every_output_of_a_search_holds_the_same_winner_and_threads_change_nothing() {
    let folder = city();
    let files = "-o p.csv -o p.json -o p.geojson -o p.png -o p.svg -o p.tif";
    let line = "--height 10,15 -k 3";
    let said = folder.type_in(&format!("{PLACE} {line} {files}")).done().err;
    assert!(said.contains("best of 48 candidates") && said.contains("3 UAVs see together"), "{said}");
    assert!(said.contains("of all ground receivers; no 3 of these"), "{said}");
    let found = document(&folder, line);
    let text = folder.text("p.csv");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let winner = &found["winner"];
    // The choice of three comes first, then the ranks.
    let kinds: Vec<[&str; 2]> = rows[1..5].iter().map(|row| [row[0], row[1]]).collect();
    assert_eq!(kinds, [["chosen", "1"], ["chosen", "2"], ["chosen", "3"], ["candidate", "1"]]);
    assert_eq!(rows[4][9], winner["p_los"].as_f64().unwrap().to_string());
    assert_eq!(text.lines().count(), 1 + 48 + 1 + found["several"]["chosen"].as_array().unwrap().len());
    assert_eq!(folder.json("p.json")["winner"], *winner);
    assert_eq!(folder.json("p.geojson")["features"][0]["properties"]["p_los"], winner["p_los"]);
    let svg = folder.text("p.svg");
    assert!(svg.contains("at the best height") && svg.contains("UAV 1") && svg.contains("No candidate"), "{svg}");
    let (covered, bound) = (&found["several"]["p_los"], &found["several"]["bound"]);
    assert!(covered.as_f64().unwrap() <= bound.as_f64().unwrap() && bound.as_f64().unwrap() <= 1.0);
    for line in [line, "--height 10 --goal margin", "--height 5:30:5 --goal p_los>=0.9 --minimize height"] {
        let one = document(&folder, &format!("{line} -j 1"));
        for threads in [2, 5] {
            assert_eq!(document(&folder, &format!("{line} -j {threads}")), one, "{line}");
        }
    }
}

#[test]
fn goals_without_an_answer_say_why() {
    let folder = city();
    let none = document(&folder, "--height 15 --goal p_los(courtyard)");
    assert_eq!((&none["winner"], &none["reason"]), (&Value::Null, &"no wanted receiver".into()));
    let never = document(&folder, "--height 1,2 --goal p_los>=1 --minimize height");
    assert!(never["winner"].is_null() && never["reason"].as_str().unwrap().starts_with("no candidate reaches 1"));
    let least = document(&folder, "--height 5:60:5 --goal p_los>=0.9 --minimize height");
    assert!(least["winner"]["p_los"].as_f64().unwrap() >= 0.9);
    // All the weight is in the south-east.
    let people = document(&folder, "--height 10 --goal p_los(weights) --weights people.asc");
    assert!(people["winner"]["x"].as_f64().unwrap() >= 25.0 && people["winner"]["y"].as_f64().unwrap() <= 25.0);
    let line = "place city.geojson --extent 0,0,50,50 --candidates own.csv --json -q";
    let own = folder.type_in(line).done().json();
    assert_eq!((&own["candidates"]["skipped"]["inside"], &own["candidates"]["tried"]), (&1.into(), &2.into()));
}

#[test]
fn the_least_height_is_found_where_an_antenna_makes_shares_fall_with_height() {
    let folder = city();
    let mut n_falls = 0;
    for antenna in ["--elevation -60,-20", "--elevation -30,0", "--beam 120", "--min-radius 5 --elevation -50,-10"] {
        let share_at = |height: u32| {
            let best = document(&folder, &format!("--height {height} {antenna}"));
            best["winner"]["p_los"].as_f64().expect("a share")
        };
        let shares: Vec<(u32, f64)> = (5..=60).step_by(5).map(|height| (height, share_at(height))).collect();
        n_falls += shares.windows(2).filter(|pair| pair[1].1 < pair[0].1).count();
        for wanted in [0.1, 0.3, 0.5] {
            let line = format!("--height 5:60:5 --goal p_los>={wanted} --minimize height {antenna}");
            let found = document(&folder, &line)["winner"]["height_agl_m"].as_f64();
            let least = shares.iter().find(|(_, share)| *share >= wanted).map(|(height, _)| f64::from(*height));
            assert_eq!(found, least, "{line}: {shares:?}");
        }
    }
    assert!(n_falls > 5, "{n_falls}");
}

#[test]
fn what_makes_no_sense_of_a_search_is_refused() {
    let folder = city();
    check_refusals(
        &folder,
        PLACE,
        &[
            ("", "E101", "--height"),
            ("--height x", "E101", "`x`"),
            ("--height 9:1:1", "E101", "`9:1:1`"),
            ("--height nan", "E101", "`nan`"),
            ("--height 9 --clearance -1", "E113", "`-1`"),
            ("--height 9 --goal sight", "E101", "found `sight`"),
            ("--height 9 --goal p_los(park)", "E101", "found `(park)`"),
            ("--height 9 --goal p_los(area)", "E108", "`--area`"),
            ("--height 9 --goal p_los(weights)", "E108", "`--weights`"),
            ("--height 9 --area west.geojson", "E116", "`--area`"),
            ("--height 9 --goal p_los(street) --receivers all", "E116", "`--receivers`"),
            ("--height 9 --goal p_los>=0.5", "E101", "`p_los>=0.5`"),
            ("--height 9 --minimize height", "E101", "`p_los`"),
            ("--height 9 --goal margin -k 2", "E116", "`--count`"),
            ("--height 9 -k 0", "E101", "'--count <N>'"),
            ("--height 9 --title T", "E116", "`--title`"),
            ("--height 9 -o a.exr", "E105", "a.exr"),
            ("--height 9 -o city.geojson --overwrite", "E105", "city.geojson: it is an input"),
            ("--height 9 --map best.csv", "E105", "best.csv: `--map`"),
            ("--height 9 --csv table.txt", "E105", "table.txt: `--csv`"),
            ("--height 9 --goal p_los(courtyard) --map none.png", "E209", "none.png"),
            ("--height 9 --goal p_los(weights) --weights debt.asc", "E302", "debt.asc"),
            ("--height 9 --within own.csv", "E302", "own.csv"),
            ("--height 9 --within far.geojson", "E208", "far.geojson"),
            ("--height 9 --keep-out far.geojson", "E208", "far.geojson"),
            ("--height 9 --goal p_los(area) --area far.geojson", "E208", "far.geojson"),
            ("--height 9 --clearance 99", "E209", "25: 1 inside a building"),
            ("--height 9 -k 2 --max-memory 20K", "E501", ""),
        ],
    );
    check_refusals(
        &folder,
        "place city.geojson",
        &[
            ("--height 9 --step 0", "E113", "`0`"),
            ("--height 9 --extent 0,0,50,50 --step 0.001", "E502", "2500000000 candidates"),
            ("--candidates own.csv -o a.png", "E109", ""),
        ],
    );
}

/// Flags that change what is found: a line without, and the flag.
const FLAGS: [(&str, &str); 35] = [
    ("--candidates own.csv", "--height 40"),
    ("--height 10", "--step 10"),
    ("--height 10", "--shard 2/2"),
    ("--height 10", "--over street"),
    ("--height 10", "--within west.geojson"),
    ("--height 10", "--keep-out west.geojson"),
    ("--height 10", "--candidates own.csv"),
    ("--height 10,15", "--clearance 7"),
    ("--height 15", "--goal p_los(rooftop)"),
    ("--height 15 --goal p_los(area) --area west.geojson", "--rx-height 9"),
    ("--height 10", "--goal p_los(area) --area west.geojson"),
    ("--height 10", "--goal p_los(weights) --weights people.asc"),
    ("--height 10", "--weights people.asc --goal p_los(weights)"),
    ("--height 10", "--area west.geojson --goal p_los(area)"),
    ("--height 10", "--goal p_los>=0.9 --minimize height"),
    ("--height 10", "--minimize height --goal p_los>=0.9"),
    ("--height 10", "--count 2"),
    ("--height 10", "--top 3"),
    ("--height 10", "--rx-height 5"),
    ("--height 10", "--receivers roof"),
    ("--height 10", "--radius 15"),
    ("--height 10", "--min-radius 15"),
    ("--height 10", "--sector 90,200"),
    ("--height 10", "--elevation -50,-20"),
    ("--height 10", "--beam 90"),
    ("--height 10", "--slant-range 17"),
    ("--height 10", "--missing levels"),
    ("--height 30", "--height-unit ft"),
    ("--height 10", "--height-field tall"),
    ("--height 10", "--top-field z_top"),
    ("--height 10 --top-field z_top", "--ground 3"),
    ("--height 10", "--cell 5"),
    ("--height 10", "--height-error 2"),
    ("--height 10", "--height-bias 2"),
    ("--height 10", "--height-error-field tall"),
];

/// Flags that change where things are written or how they are decided, or that other tests show at work; those of the scene.
const OTHER: &str = "--roofs --swap-axes --width --dpi --project --skip-bad --repairs --levels-field --base-field --parts --layer --output --csv --map --title \
    --attribution --json --overwrite --threads --quiet --max-memory --csv-text --method --hash --crs --help --version \
    --earth-k --curvature-coefficient --terrain --base --data-area --building-threshold --extent --size --seed --nodata-as --band";

#[test]
fn every_flag_changes_what_is_found() {
    let folder = city();
    folder.write(
        "tall.geojson",
        r#"{"type": "FeatureCollection", "features": [
          {"type": "Feature", "properties": {"height": 8, "tall": 12, "z_top": 9, "z_ground": 0}, "geometry": {"type": "Polygon",
           "coordinates": [[[10,10],[20,10],[20,40],[10,40],[10,10]]]}},
          {"type": "Feature", "properties": {"building:levels": "3", "tall": 5, "z_top": 6, "z_ground": 0}, "geometry": {"type": "Polygon",
           "coordinates": [[[38,28],[40,28],[40,30],[38,30],[38,28]]]}}]}"#,
    );
    let west = [[0, 0], [22, 0], [22, 50], [0, 50], [0, 0]];
    let west = serde_json::json!({"type": "Feature", "properties": {},
                                  "geometry": {"type": "Polygon", "coordinates": [west]}});
    folder.write("west.geojson", &west.to_string());
    let found = |line: &str| {
        let line = format!("place tall.geojson --extent 0,0,50,50 {line} --json -q");
        let document = folder.type_in(&line).done().json();
        ["digest", "winner", "ranked", "several"].map(|key| document[key].clone())
    };
    for (line, flag) in FLAGS {
        assert_ne!(found(line), found(&format!("{line} {flag}")), "{line} {flag}");
    }
    check_flags_are_known(&folder, "place", &[&FLAGS.map(|(_, flag)| flag)[..], &[OTHER]].concat());
}

#[test]
fn shards_of_the_candidates_are_ranked_as_all_are() {
    let folder = city();
    let rows = |line: &str| {
        folder.type_in(&format!("{PLACE} --height 10,15 --radius 20 {line} --csv t.csv -q --overwrite")).done();
        let table = folder.text("t.csv");
        let candidates = table.lines().filter(|row| row.starts_with("candidate,"));
        // Without the rank: kind and rank stand first.
        candidates.map(|row| row.splitn(3, ',').nth(2).expect("a place").to_string()).collect::<Vec<_>>()
    };
    let all = rows("");
    let of_shards: Vec<Vec<String>> = (1..=5).map(|k| rows(&format!("--shard {k}/5"))).collect();
    assert!(of_shards.iter().all(|rows| !rows.is_empty()));
    let mut joined = of_shards.concat();
    assert_eq!(joined.len(), all.len());
    let header = folder.text("t.csv");
    let column =
        header.lines().next().expect("a header").split(',').position(|name| name == "p_los").expect("a share") - 2;
    let share = |row: &String| row.split(',').nth(column).and_then(|p| p.parse::<f64>().ok()).unwrap_or(-1.0);
    joined.sort_by(|a, b| share(b).total_cmp(&share(a)));
    assert_eq!(joined, all);
    for flag in ["--count 2", "--map m.tif", "--goal p_los>=0.1 --minimize height"] {
        assert_eq!(folder.type_in(&format!("{PLACE} --height 10,15 --shard 1/2 {flag}")).error(), "E116");
    }
}

#[test]
fn the_map_of_the_winner_and_a_table_by_name_are_written() {
    let folder = city();
    folder.type_in(&format!("{PLACE} --height 15 --csv t.csv --map best.tif --radius 20")).done();
    let found = document(&folder, "--height 15 --radius 20");
    let mask = mask_of(&folder, "best.tif");
    let count = |class: u8| mask.iter().filter(|c| **c == class).count() as u64;
    // Those out of range are among the receivers that the share is of.
    assert!(found["winner"]["receivers"].as_u64() > Some(count(0) + count(1)));
    assert_eq!(found["winner"]["los"].as_u64(), Some(count(1)));
    assert!(folder.text("t.csv").starts_with("kind,rank,x,y,"));
    folder.type_in(&format!("{PLACE} --height 15 -k 2 --map both.svg")).done();
    let svg = folder.text("both.svg");
    assert!(
        svg.contains("What the chosen UAVs see of") && svg.contains("UAV 2") && svg.contains("Seen by at least one")
    );
}

#[test]
fn the_worst_margin_is_refined_and_is_that_of_a_map() {
    let folder = city();
    let found = document(&folder, "--height 15 --goal margin");
    let margin = |key: &str| found[key]["margin_m"].as_f64().unwrap();
    assert!(margin("refined") >= margin("winner"), "{found}");
    for key in ["winner", "refined"] {
        let at = ["x", "y", "height_agl_m"].map(|part| found[key][part].to_string()).join(",");
        let line = format!("map city.geojson --extent 0,0,50,50 --uav {at} --layers margin -o m.asc --overwrite -q");
        folder.type_in(&line).done();
        let values = folder.text("m.asc");
        let least = values.lines().skip(6).flat_map(str::split_whitespace).map(|v| v.parse::<f64>().unwrap());
        let least = least.filter(|v| *v > -9999.0).fold(f64::INFINITY, f64::min);
        assert!((least - margin(key)).abs() < 1e-3, "{key}: {least}, {found}");
    }
}
