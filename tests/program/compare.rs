//! `skyshed compare` from outside: counts by hand, saved masks, intervals, sheets, files, flags, and what it refuses.

use serde_json::Value;
use skyshed_io::formats::GeoTiff;
use skyshed_study::city_statistics::bootstrap::{Share, resampled_ratios};

use crate::program::{Folder, program, wait};
use crate::refusals::{check_flags_are_known, check_refusals};
use crate::support::{Random, is_long, read_png};
use crate::texts::{grid, table_rows};

/// Two masks of 4 × 4 cells in which every combination of classes that matters occurs.
const FIRST: [u8; 16] = [1, 1, 0, 0, 1, 2, 2, 0, 0, 2, 3, 1, 255, 0, 1, 1];
const SECOND: [u8; 16] = [1, 0, 0, 1, 1, 2, 1, 0, 1, 2, 0, 1, 0, 0, 255, 1];
/// Their difference: 0 neither, 1 only the first, 2 only the second, 3 both, 255 not a receiver of both.
const DIFFERENCE: [u8; 16] = [3, 1, 0, 2, 3, 255, 255, 0, 2, 255, 255, 3, 255, 0, 255, 3];
/// How many see a cell; 255 where it is a receiver of neither.
const COUNT: [u8; 16] = [2, 1, 0, 1, 2, 255, 1, 0, 1, 255, 0, 2, 0, 0, 1, 2];

/// A block and a tower, so that placements differ.
const CITY: &str = r#"{"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": {"height": 20, "tall": 25, "z_top": 18, "z_ground": 0},
   "geometry": {"type": "Polygon", "coordinates": [[[20,20],[60,20],[60,60],[20,60],[20,20]]]}},
  {"type": "Feature", "properties": {"height": 50, "tall": 60, "z_top": 50, "z_ground": 0},
   "geometry": {"type": "Polygon", "coordinates": [[[20,90],[60,90],[60,130],[20,130],[20,90]]]}},
  {"type": "Feature", "properties": {"building:levels": 5},
   "geometry": {"type": "Polygon", "coordinates": [[[123,123],[130,123],[130,130],[123,130],[123,123]]]}}]}"#;

/// A flat scene of 4 × 4 cells with the masks made by hand, and a city.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("flat.asc", &grid(&[0; 16], 4, -9999));
    folder.write("first.asc", &grid(&FIRST, 4, 255));
    folder.write("second.asc", &grid(&SECOND, 4, 255));
    folder.write("city.geojson", CITY);
    folder
}

const BY_HAND: &str = "flat.asc --ground 0 --mask first.asc --mask second.asc";

fn document(folder: &Folder, line: &str) -> Value {
    folder.type_in(&format!("compare {line} --json -q")).done().json()
}

fn counts(pair: &Value) -> Vec<u64> {
    let names = ["both", "only_first", "only_second", "neither", "receivers_of_first_only", "receivers_of_second_only"];
    names.iter().map(|name| pair[*name].as_u64().unwrap()).collect()
}

#[test]
fn masks_made_by_hand_have_the_counts_of_a_hand() {
    let folder = folder();
    let document = document(&folder, BY_HAND);
    assert_eq!(document["schema"], "skyshed/compare/1");
    assert_eq!(document["method"], "none");
    let [first, second] = [&document["placements"][0], &document["placements"][1]];
    assert_eq!((&first["id"], &second["id"]), (&"first".into(), &"second".into()));
    assert_eq!((first["receivers"].as_u64(), first["los"].as_u64()), (Some(11), Some(6)));
    assert_eq!((second["receivers"].as_u64(), second["los"].as_u64()), (Some(13), Some(7)));
    assert_eq!((&first["margins"], first["margins_reason"].is_string()), (&Value::Null, true));
    // Nobody knows how these maps were made, and there is no interval to speak of.
    assert!(!document["intervals"]["meaning"].as_str().unwrap().contains("exact"));
    folder.type_in(&format!("compare {BY_HAND} -o hand.svg -q")).done();
    let svg = folder.text("hand.svg");
    let (_, drawn) = svg.split_once("</metadata>").unwrap();
    assert!(!drawn.contains("resamplings") && !drawn.contains("maps are exact"), "{drawn}");
    let pair = &document["pairs"][0];
    assert_eq!(counts(pair), [4, 1, 2, 3, 1, 3]);
    assert_eq!((pair["compared"].as_u64(), pair["difference"].as_f64()), (Some(10), Some(0.1)));
    // One block of 50 m tells nothing about its spread.
    assert_eq!((&pair["ci_low"], &pair["exceeds"]), (&Value::Null, &Value::Null));
    assert_eq!(pair["reason"], "1 block with receivers, wanted at least 10");
    // 6 of 11 are more than 7 of 13, but of the ten that both have the second sees one more.
    assert_eq!(
        document["verdict"],
        "first is best: P_LoS 0.5455, 0.5385 for second, over the receivers of both −0.1000; whether the difference is clear \
         is not known: 1 block with receivers, wanted at least 10."
    );
    assert_eq!(document["seen_by"], serde_json::json!([5, 5, 4]));
    let sets: Vec<u64> =
        document["sets"].as_array().unwrap().iter().map(|s| s["receivers"].as_u64().unwrap()).collect();
    assert_eq!(sets, [5, 2, 3, 4]);
    assert_eq!((document["union"]["receivers"].as_u64(), document["union"]["los"].as_u64()), (Some(14), Some(9)));
}

#[test]
fn a_difference_turned_round_changes_its_sign_alone() {
    let folder = folder();
    let blocks = "--block 1";
    let there = document(&folder, &format!("{BY_HAND} {blocks}"));
    let back = document(&folder, &format!("flat.asc --ground 0 --mask second.asc --mask first.asc {blocks}"));
    let (there, back) = (&there["pairs"][0], &back["pairs"][0]);
    let [both, first, second, neither, of_first, of_second] = counts(there)[..] else { panic!("six counts") };
    assert_eq!(counts(back), [both, second, first, neither, of_second, of_first]);
    assert_eq!(there["difference"].as_f64().map(|d| -d), back["difference"].as_f64());
    // Blocks of one cell: 16 of them, of which 10 are compared, and the same drawings in both runs.
    assert_eq!((there["blocks"].as_u64(), back["blocks"].as_u64()), (Some(10), Some(10)));
    let number = |value: &Value, name: &str| value[name].as_f64().unwrap();
    assert!((number(there, "ci_low") + number(back, "ci_high")).abs() < 1e-9);
    assert!((number(there, "ci_high") + number(back, "ci_low")).abs() < 1e-9);
}

#[test]
fn bands_hold_masks_differences_and_the_count() {
    let folder = folder();
    folder.type_in(&format!("compare {BY_HAND} -o out.tif")).done();
    let tiff = GeoTiff::open(folder.join("out.tif"), &mut Vec::new()).unwrap();
    let names = ["first.los", "second.los", "first-second.difference", "count"].map(Some);
    assert_eq!(tiff.band_names(), names);
    for (band, wanted) in [FIRST, SECOND, DIFFERENCE, COUNT].iter().enumerate() {
        let window = tiff.georef().window();
        let values = tiff.read_band(band, window, &mut Vec::new(), |v| if v.is_nan() { 255.0 } else { v }).unwrap();
        let wanted: Vec<f64> = wanted.iter().map(|v| f64::from(*v)).collect();
        assert_eq!(values.cells(), wanted, "{band}");
    }
    assert!(folder.read("out.tif").windows(17).any(|w| w == b"skyshed/compare/1"), "provenance");
}

/// The text of the cells of a table's rows, by their first ones.
fn rows<'a>(page: &'a str, section: &str) -> Vec<(&'a str, Vec<&'a str>)> {
    let (_, table) = page.split_once(section).unwrap();
    let table = table.split("</table>").next().unwrap();
    let row = |row: &'a str| {
        let (head, cells) = row.split_once("</th>").unwrap();
        (head, cells.split("<td>").skip(1).map(|cell| cell.split("</td>").next().unwrap()).collect())
    };
    table.split("<th scope=\"row\">").skip(1).map(row).collect()
}

#[test]
fn the_matrix_of_the_page_is_row_less_column() {
    let folder = folder();
    // A third map that sees everything: 5 of the 11 receivers of the first more than that, 6 of the 13 of the second.
    folder.write("third.asc", &grid(&[1; 16], 4, 255));
    folder.type_in(&format!("compare {BY_HAND} --mask third.asc -o c.html -q")).done();
    let page = folder.text("c.html");
    let wanted = [
        ("first", vec!["–", "−0.1000", "−0.4545"]),
        ("second", vec!["+0.1000", "–", "−0.4615"]),
        ("third", vec!["+0.4545", "+0.4615", "–"]),
    ];
    assert_eq!(rows(&page, "<section aria-label=\"Differences of any two\">"), wanted);
}

#[test]
fn two_uavs_at_one_place_have_a_mark_each_there() {
    let folder = folder();
    folder.type_in("compare itu:urban --size 200 --uav 50,60,40 --uav 50,60,90 --uav 150,20,90 -o c.html -q").done();
    let page = folder.text("c.html");
    let places: Vec<[&str; 2]> =
        rows(&page, "<caption>Placements</caption>").iter().map(|(_, cells)| [cells[0], cells[1]]).collect();
    assert_eq!(places, [["50", "60"], ["50", "60"], ["150", "20"]]);
    // A quarter of 200 m from the left, 140 m from the top; the second at a place is numbered, so that its label stands apart.
    let marks: Vec<&str> = page
        .split("<div class=\"mark")
        .skip(1)
        .map(|mark| mark.split("style=\"").nth(1).unwrap().split('"').next().unwrap())
        .collect();
    let wanted = [
        "left:25.0000%;top:70.0000%;--nth:0",
        "left:25.0000%;top:70.0000%;--nth:1",
        "left:75.0000%;top:90.0000%;--nth:0",
    ];
    assert_eq!(marks, wanted);
}

#[test]
fn saved_maps_compare_like_their_uavs() {
    let folder = folder();
    let (a, b) = ("--uav 10,10,40", "--uav 75,75,60");
    for scene in ["city.geojson", "city.geojson --receivers street --radius 70"] {
        folder.type_in(&format!("map {scene} {a} -o a.tif --overwrite")).done();
        folder.type_in(&format!("map {scene} {b} -o b.tif --overwrite")).done();
        folder.type_in(&format!("map {scene} {a} {b} --layers los,margin -o both.tif --overwrite")).done();
        let direct = document(&folder, &format!("{scene} {a} {b}"));
        for masks in ["--mask a.tif --mask b.tif", "--mask both.tif"] {
            let saved = document(&folder, &format!("{scene} {masks}"));
            assert_eq!(saved["digest"], direct["digest"], "{masks}");
            for key in ["ci_low", "ci_high", "zones", "difference", "compared", "exceeds"] {
                assert_eq!(saved["pairs"][0][key], direct["pairs"][0][key], "{masks} {key}");
            }
            assert_eq!(counts(&saved["pairs"][0]), counts(&direct["pairs"][0]));
            assert_eq!(saved["placements"][1]["zones"], direct["placements"][1]["zones"]);
        }
        let place = |document: &Value| {
            [0, 1].map(|k| (document["placements"][k]["x"].clone(), document["placements"][k]["y"].clone()))
        };
        assert_eq!(place(&document(&folder, &format!("{scene} --mask both.tif"))), place(&direct));
        let mixed = document(&folder, &format!("{scene} {a} --mask b.tif"));
        assert_eq!(mixed["digest"], direct["digest"]);
        assert_eq!(mixed["placements"][1]["id"], "b");
        assert_eq!(mixed["scene"]["sources"].as_array().map(Vec::len), Some(2));
    }
    let both = document(&folder, "city.geojson --mask both.tif");
    assert_eq!((&both["placements"][0]["id"], &both["placements"][1]["id"]), (&"both.1".into(), &"both.2".into()));
    // A map for other receivers is compared, but not in silence.
    let answer = folder.type_in("compare city.geojson --rx-height 3 --mask a.tif --mask b.tif --json").done();
    assert_eq!(answer.warnings().iter().filter(|code| **code == "W215").count(), 2 * 3, "{}", answer.err);
    // Each compared cell is counted once, and those of one alone apart.
    for pair in document(
        &folder,
        "city.geojson --receivers all --radius 60 --uav 10,10,40 --uav 75,75,60 --uav 140,10,30",
    )["pairs"]
        .as_array()
        .unwrap()
    {
        assert_eq!(counts(pair)[..4].iter().sum::<u64>(), pair["compared"].as_u64().unwrap());
        assert!(pair["receivers_of_first_only"].as_u64() > Some(0));
    }
}

#[test]
fn margins_are_those_of_the_layer() {
    let folder = folder();
    let line = "city.geojson --uav 10,10,40 --uav 75,75,60";
    let document = document(&folder, line);
    folder.type_in(&format!("map {line} --layers margin -o margin.tif")).done();
    let tiff = GeoTiff::open(folder.join("margin.tif"), &mut Vec::new()).unwrap();
    for band in 0..2 {
        let layer = tiff.read_band(band, tiff.georef().window(), &mut Vec::new(), |v| v).unwrap();
        let mut margins: Vec<f64> = layer.cells().iter().copied().filter(|m| !m.is_nan()).collect();
        margins.sort_by(f64::total_cmp);
        let told = &document["placements"][band]["margins"];
        assert_eq!((told["every"].as_u64(), told["receivers"].as_u64()), (Some(1), Some(margins.len() as u64)));
        for (name, percent) in [("q05_m", 5), ("median_m", 50), ("q95_m", 95)] {
            let value = told[name].as_f64().unwrap();
            // So many percent, and no fewer, do not exceed it.
            let below = margins.iter().filter(|m| **m < value).count();
            let up_to = margins.iter().filter(|m| **m <= value).count();
            assert!(100 * below < percent * margins.len() && 100 * up_to >= percent * margins.len(), "{name} {value}");
        }
        let grazing = margins.iter().filter(|m| m.abs() <= 1.0).count();
        assert_eq!(told["grazing"].as_u64(), Some(grazing as u64));
        let los = margins.iter().filter(|m| **m >= 0.0).count();
        assert_eq!(document["placements"][band]["los"].as_u64(), Some(los as u64));
    }
}

#[test]
fn equal_placements_do_not_differ_and_unlike_ones_do() {
    let folder = folder();
    let document = document(&folder, "itu:urban --size 700 --uav 300,300,80 --uav 300,300,80 --uav 300,300,250");
    let verdict = document["verdict"].as_str().unwrap();
    assert!(
        verdict.starts_with("3 is best: P_LoS 0.") && verdict.contains(" more than 1; the difference is clear: its")
    );
    let [same, other] = [&document["pairs"][0], &document["pairs"][1]];
    for of_zone in [same, &same["zones"]["street"], &same["zones"]["crossroad"]] {
        assert_eq!((of_zone["difference"].as_f64(), &of_zone["exceeds"]), (Some(0.0), &false.into()));
        assert_eq!((of_zone["ci_low"].as_f64(), of_zone["ci_high"].as_f64()), (Some(0.0), Some(0.0)));
    }
    let number = |name: &str| other[name].as_f64().unwrap();
    assert_eq!(other["exceeds"], true);
    assert!(
        0.0 < number("ci_low") && number("ci_low") < number("difference") && number("difference") < number("ci_high")
    );
    let twins = "itu:urban --size 300 --uav 100,100,60 --uav 100,100,60";
    let said = folder.type_in(&format!("compare {twins} --json")).done().err;
    assert!(said.starts_with("1, 2 are equally good: P_LoS 0."), "the first thing that is said: {said}");
    // What a placement sees from higher up it never loses.
    assert_eq!(other["only_first"], 0);
    // A difference over all receivers is that of the two shares, and its interval is narrower than theirs together.
    let share = |k: usize, name: &str| document["placements"][k][name].as_f64().unwrap();
    assert!((number("difference") - (share(2, "p_los") - share(0, "p_los"))).abs() < 1e-12);
    let width = |k: usize| share(k, "ci_high") - share(k, "ci_low");
    assert!(number("ci_high") - number("ci_low") < width(0) + width(2));
}

#[test]
fn intervals_over_independent_blocks_cover_as_often_as_they_say() {
    // A block gains 25 on average of 100 receivers, each number drawn by itself; so the truth is 0.05.
    let (repetitions, wanted) = if is_long() { (2000, 92.5..=96.5) } else { (400, 90.5..=97.5) };
    let mut random = Random(7);
    let mut covered = 0;
    for seed in 0..repetitions {
        let share = |_| Share { part: random.within(-20, 30), whole: u64::try_from(random.within(50, 150)).unwrap() };
        let blocks: Vec<Share> = (0..60).map(share).collect();
        let (low, high) = resampled_ratios(&[blocks], 0.95, seed)[0].interval.unwrap();
        covered += u32::from(low <= 0.05 && 0.05 <= high);
    }
    let percent = 100.0 * f64::from(covered) / repetitions as f64;
    assert!(wanted.contains(&percent), "{percent} %");
}

#[test]
fn table_and_document_agree() {
    let folder = folder();
    let line = "itu:urban --size 500 --uav 100,100,60 --uav 300,300,120 --uav 200,400,90";
    folder.type_in(&format!("compare {line} --csv a.csv -o b.json -q")).done();
    let document = folder.json("b.json");
    assert_eq!(document["digest"], folder.json("a.csv.json")["digest"]);
    let rows = table_rows(&folder.text("a.csv"));
    assert_eq!(rows.len(), (3 + 3) * 5);
    for row in &rows {
        let (list, key) = if row["row"] == "placement" { ("placements", "p_los") } else { ("pairs", "difference") };
        let is_it = |o: &&Value| match list {
            "pairs" => o["first"] == row["first"].as_str() && o["second"] == row["second"].as_str(),
            _ => o["id"] == row["first"].as_str(),
        };
        let object = document[list].as_array().unwrap().iter().find(is_it).unwrap();
        let object = if row["zone"] == "all" { object } else { &object["zones"][row["zone"].as_str()] };
        for column in [key, "ci_low", "ci_high", "blocks"] {
            // The parser of JSON may be off by a last digit.
            let (in_table, in_document) = (row[column].parse::<f64>().ok(), object[column].as_f64());
            assert_eq!(in_table.is_some(), in_document.is_some(), "{row:?} {column}");
            let off = in_table.unwrap_or(0.0) - in_document.unwrap_or(0.0);
            assert!(off.abs() < 1e-14 * in_table.unwrap_or(0.0).abs().max(1.0), "{row:?} {column} {in_document:?}");
        }
    }
    // Without an output the table is the answer.
    let answer = folder.type_in(&format!("compare {line} -q")).done();
    assert_eq!(answer.out, folder.text("a.csv"));
}

#[test]
fn a_sheet_names_what_it_shows() {
    let folder = folder();
    let line = "city.geojson --uav 10,10,40 --uav 75,75,60 --uav 140,10,30 -q";
    folder.type_in(&format!("compare {line} -o s.svg -o s.png --title Mine --attribution Surveyors")).done();
    let svg = folder.text("s.svg").replace('\u{a0}', " ");
    for words in ["Mine", "1 · 40 m above ground", "2 → 3", "Gained: only the second", "By all 3 UAVs", "Surveyors"]
    {
        assert!(svg.contains(words), "{words}");
    }
    assert_eq!(svg.matches("<image ").count(), 3 + 3 + 1);
    let image = read_png(&folder.read("s.png"));
    assert!(image.width() > 1000 && image.height() > 800);
    // Seven placements show their differences to the first alone.
    let seven: String = (0..7).map(|k| format!(" --uav {},{},60", 10 + 15 * k, 10)).collect();
    folder.type_in(&format!("compare city.geojson{seven} -q -o seven.svg")).done();
    let svg = folder.text("seven.svg");
    assert_eq!(svg.matches("<image ").count(), 7 + 6 + 1);
    assert!(svg.contains("Differences are drawn from 1 to each other placement."));
}

#[test]
fn files_do_not_depend_on_the_number_of_threads() {
    let files = "-o c.html -o c.png -o c.tif -o c.svg --csv c.csv";
    let line = format!("compare itu:urban --size 400 --uav 100,100,60 --uav 300,300,120 -q {files}");
    let words: Vec<&str> = line.split_whitespace().collect();
    let runs = ["1", "2"].map(|threads| {
        let folder = folder();
        wait(program(folder.path(), &words).env("RAYON_NUM_THREADS", threads).spawn().unwrap()).done();
        folder
    });
    for name in ["c.html", "c.png", "c.tif", "c.svg", "c.csv", "c.csv.json"] {
        assert!(runs[0].read(name) == runs[1].read(name), "{name}");
    }
}

#[test]
fn what_makes_no_sense_is_refused_and_leaves_nothing() {
    let folder = folder();
    folder.write("wide.asc", &grid(&[1; 20], 5, 255));
    folder.write("odd.asc", &grid(&[[1; 7].as_slice(), &[7], &[0; 8]].concat(), 4, 255));
    std::fs::create_dir(folder.join("other")).unwrap();
    std::fs::copy(folder.join("first.asc"), folder.join("other/first.asc")).unwrap();
    folder.type_in("map city.geojson --uav 10,10,40 --uav 75,75,60 --layers margin -o margins.tif").done();
    folder.type_in("map city.geojson --crs EPSG:25832 --uav 10,10,40 -o utm.tif").done();
    let mask = folder.read("utm.tif");
    let many: String = (0..17).map(|k| format!(" --uav {k},1,60")).collect();
    let (flat, utm) = ("flat.asc --ground 0 --uav 1,1,50", "city.geojson --crs EPSG:25832 --uav 1,1,50 --mask utm.tif");
    check_refusals(
        &folder,
        "compare",
        &[
            ("city.geojson", "E108", "found 0 "),
            ("city.geojson --uav 1,1,50", "E108", "found 1 "),
            ("flat.asc --ground 0 --mask first.asc", "E108", "found 1 "),
            ("city.geojson --uav 1,1,50 --uav 2,2 -o c.png", "E102", "`--uav 2,2`"),
            ("city.geojson --uav 1,1,50 --uav 2,2,9 --block 0", "E113", "`0`"),
            ("city.geojson --uav 1,1,50 --uav 2,2,9 -o c.exr", "E105", "c.exr"),
            ("city.geojson --uav 1,1,50 --uav 2,2,9 --csv c.txt", "E105", "c.txt"),
            ("city.geojson --uav 1,1,50 --uav 2,2,9 --title T", "E116", "`--title`"),
            ("flat.asc --uav 1,1,50 --uav 2,2,9 --receivers street", "E117", "`street`"),
            (&format!("{flat} --mask wide.asc"), "E312", "wide.asc (5×4"),
            (&format!("{flat} --mask odd.asc"), "E302", "odd.asc as a mask: row 1"),
            (&format!("{flat} --mask none.tif"), "E301", "none.tif"),
            ("city.geojson --uav 1,1,50 --mask margins.tif", "E302", "margins.tif as a mask"),
            ("city.geojson --crs EPSG:25833 --uav 1,1,50 --mask utm.tif", "E311", ""),
            ("city.geojson --uav 1,1,50 --uav 30,30,5", "E201", "`2`"),
            ("flat.asc --ground 0 --mask first.asc --mask other/first.asc", "E207", "`first`"),
            (&format!("city.geojson{many}"), "E502", "17 placements"),
            ("itu:urban --uav 1,1,50 --uav 2,2,9 --block 1", "E502", "1000000 blocks"),
            ("itu:urban --uav 1,1,50 --uav 2,2,9 --max-memory 1M", "E501", ""),
            (&format!("{utm} -o margins.tif"), "E106", "margins.tif"),
            // A mask is an input like any other.
            (&format!("{utm} -o utm.tif --overwrite"), "E105", "utm.tif: it is an input"),
        ],
    );
    assert!(folder.read("utm.tif") == mask);
}

/// Flags that change the document: a line without it, and the flag.
const FLAGS: [(&str, &str); 33] = [
    ("CITY", "--ground 5"),
    ("CITY", "--height-field tall"),
    ("CITY", "--top-field z_top"),
    ("CITY", "--missing levels"),
    ("CITY", "--height-unit ft"),
    ("CITY", "--extent 0,0,150,150"),
    ("CITY", "--cell 5"),
    ("CITY", "--crs EPSG:25832"),
    ("CITY", "--terrain slope.asc"),
    ("CITY --terrain slope.asc", "--base highest"),
    ("CITY", "--data-area all"),
    ("CITY", "--uav 5,70,50"),
    ("CITY", "--uavs sites.csv"),
    ("CITY", "--mask saved.tif"),
    ("CITY", "--rx-height 9"),
    ("CITY", "--receivers all"),
    ("CITY", "--radius 50"),
    ("CITY", "--min-radius 20"),
    ("CITY", "--sector 10,200"),
    ("CITY", "--elevation -60,-20"),
    ("CITY", "--beam 60"),
    ("CITY", "--slant-range 60"),
    ("CITY", "--height-error 2"),
    ("CITY", "--height-bias 2"),
    ("CITY", "--height-error-field tall"),
    ("CITY", "--block 10"),
    ("CITY --block 20", "--seed 2"),
    ("CITY", "--method ray"),
    ("flat.asc --ground 0 --uav 1,1,50 --uav 2,2,9", "--building-threshold 3"),
    ("flat.asc --ground 0 --uav 1,1,50 --uav 2,2,9", "--earth-k 4/3"),
    ("flat.asc --ground 0 --uav 1,1,50 --uav 2,2,9", "--curvature-coefficient 0.75"),
    ("holes.asc --ground 0 --uav 0.5,0.5,5 --uav 3.5,3.5,5", "--nodata-as block"),
    ("itu:urban --uav 2,2,50 --uav 9,9,50", "--size 300"),
];

/// Flags that change what is written or said.
const OTHER: &str = "--roofs --swap-axes --band --width --dpi --project --skip-bad --bad-uavs --repairs --levels-field --base-field --parts --layer --output --csv --title \
    --attribution --json --overwrite --threads --quiet --max-memory --csv-text --hash --help --version";

#[test]
fn every_flag_changes_the_document() {
    let folder = folder();
    folder.write("flat.asc", &grid(&[0, 0, 0, 0, 0, 2, 2, 0, 0, 2, 2, 0, 0, 0, 0, 0], 4, -9999));
    folder.write("holes.asc", &grid(&[0, 0, 0, 0, 0, -9999, -9999, 0, 0, 0, 0, 0, 1, 1, 1, 1], 4, -9999));
    folder.write("slope.asc", &grid(&(0..130 * 130).map(|k| k % 130 / 10).collect::<Vec<_>>(), 130, -9999));
    folder.write("sites.csv", "id,x,y,h\na,40,75,30\n");
    let city = "city.geojson --uav 70,25,40 --uav 75,75,60";
    folder.type_in("map city.geojson --uav 70,40,60 -o saved.tif").done();
    let plan = |line: &str| {
        let mut document = document(&folder, &line.replace("CITY", city));
        let object = document.as_object_mut().unwrap();
        object.remove("command");
        object.remove("timing_s");
        document
    };
    for (line, flag) in FLAGS {
        assert_ne!(plan(line), plan(&format!("{line} {flag}")), "{line} {flag}");
    }
    check_flags_are_known(&folder, "compare", &[&FLAGS.map(|(_, flag)| flag)[..], &[OTHER]].concat());
}
