//! Tables of UAVs, tracks and curves: rows that are wrong, feet, decimal commas, standard input, names that mean something.

use std::io::Write;
use std::process::Stdio;

use sha2::{Digest, Sha256};

use crate::answers::folder;
use crate::program::{Answer, Folder, program, wait};

/// Runs a command line with a text on standard input.
fn with_input(folder: &Folder, line: &str, input: &str) -> Answer {
    let words: Vec<&str> = line.split_whitespace().collect();
    let mut child = program(folder.path(), &words).stdin(Stdio::piped()).spawn().expect("the program starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    // A program that does not read closes the pipe.
    let _ = stdin.write_all(input.as_bytes());
    drop(stdin);
    wait(child)
}

#[test]
fn bad_rows_are_told_together_and_left_out_on_request() {
    let folder = folder();
    let rows = |n: usize| (0..n).map(|k| format!("u{k},{k},bad{k},30\n")).collect::<String>();
    folder.write("s.csv", &format!("id,x,y,h\n{}ok,40,20,30\nh,41,20,high\n", rows(2)));
    let map = "map city.geojson --uavs s.csv";
    let told = [
        "3 of 4 rows",
        "line 2: `y`: found `bad0`",
        "line 3: `y`: found `bad1`",
        "line 5: height `high`",
        "--skip-bad",
    ];
    folder.refuses(map, "E302", &told);
    let answer = folder.type_in(&format!("{map} --skip-bad --json")).done();
    assert_eq!(answer.warnings().iter().filter(|code| **code == "W380").count(), 1, "{answer:?}");
    assert!(answer.err.contains("3 of 4 rows"), "{answer:?}");
    let document = answer.json();
    assert_eq!(document["sites"].as_array().map(Vec::len), Some(1));
    assert_eq!(document["sites"][0]["id"], "ok");
    assert!(document["warnings"].as_array().is_some_and(|all| all.iter().any(|w| w["code"] == "W380")), "{document}");
    // Many are counted; all of them are an error still.
    folder.write("s.csv", &format!("id,x,y,h\n{}ok,40,40,30\n", rows(30)));
    folder.refuses(map, "E302", &["30 of 31 rows", "`bad19`", "; and 10 more\n"]);
    folder.write("s.csv", &format!("id,x,y,h\n{}", rows(2)));
    folder.refuses(&format!("{map} --skip-bad"), "E302", &["2 of 2 rows"]);
    // Numbers are those of rows, whichever are left out.
    folder.write("s.csv", "x,y,h\n1,1,x\n40,40,30\n");
    assert_eq!(folder.type_in(&format!("{map} --skip-bad --json")).done().json()["sites"][0]["id"], "2");
    folder.refuses("map city.geojson --uav 2,2,50 --skip-bad", "E116", &["a table of UAVs"]);
}

#[test]
fn bad_rows_of_other_tables_are_told_alike() {
    let folder = folder();
    let point = |x: &str, h: &str| {
        format!(r#"{{"type":"Feature","properties":{{"h":{h}}},"geometry":{{"type":"Point","coordinates":[{x}]}}}}"#)
    };
    let points = [point("1", "30"), point("4000,4000", "30"), point("4000,4001", "\"up\"")].join(",");
    folder.write("s.geojson", &format!(r#"{{"type":"FeatureCollection","features":[{points}]}}"#));
    folder.write("t.csv", "x,y\n2,2\n2,\n2,48\n4 8,48\n");
    folder.write("c.csv", "theta_deg,p_los\n10,0.5\n20,2\n30,0.75\n95,1\n");
    for (line, code, first, second) in [
        ("map city.geojson --uavs s.geojson", "E302", "2 of 3 rows are bad: feature 1: ", "feature 3: height `up`"),
        ("compare city.geojson --uav 2,2,50 --uavs s.geojson", "E302", "feature 1: ", "feature 3: "),
        ("chart city.geojson --time 0 --uavs s.geojson", "E302", "feature 1: ", "feature 3: "),
        ("place city.geojson --candidates s.geojson", "E302", "feature 1: ", "feature 3: "),
        ("track city.geojson --uav 2,2,50 --track t.csv", "E302", "line 3: `y`: ", "line 5: `x`: found `4 8`"),
        ("plos itu:urban --theta 20 --curve c=c.csv", "E313", "line 3: `p_los` is `2`, ", "; line 5: "),
    ] {
        folder.refuses(line, code, &[first, second]);
        // Places far away are no candidates: what is left may be refused, but not for its rows.
        let answer = folder.type_in(&format!("{line} --skip-bad"));
        assert!(answer.code() == 0 || line.starts_with("place"), "{line}: {answer:?}");
        assert!(answer.code() != 0 || answer.warnings().contains(&"W380"), "{line}: {answer:?}");
    }
}

#[test]
fn heights_may_be_typed_in_feet() {
    let folder = folder();
    folder.write("ft.csv", "id,x,y,h,h_above\na,40,40,200ft,\nb,40,40,100ft,amsl\nc,25,25,100 ft roof,\n");
    let document =
        folder.type_in("map city.geojson --uav 2,2,200ft --uavs ft.csv --rx-height 5ft --json").done().json();
    let height = |k: usize| document["sites"][k]["height_amsl_m"].as_f64().expect("a height");
    // On the lattice of 1/1024 m; the roof is 20 m high.
    for (k, wanted) in [60.96, 60.96, 30.48, 50.48].into_iter().enumerate() {
        assert!((height(k) - wanted).abs() <= 0.5 / 1024.0, "{k}: {document}");
    }
    let same = folder.type_in("map city.geojson --uav 2,2,200ft --rx-height 5ft").done();
    assert_eq!(same.out, folder.type_in("map city.geojson --uav 2,2,60.96m --rx-height 1.524").done().out);
    let link = |words: &str| folder.type_in(&format!("link city.geojson --uav 2,2,50 --rx {words}")).done().out;
    assert_eq!(link("40,40,10ft amsl".replace(' ', "").as_str()), link("40,40,3.048amsl"));
    let heights = |line: &str| folder.type_in(&format!("{line} --json")).done().json();
    let place = heights("place city.geojson --step 20 --height 100ft:200ft:50ft");
    assert_eq!(place["candidates"]["heights"], serde_json::json!(["30.48agl", "45.72agl", "60.96agl"]), "{place}");
    let plos = heights("plos itu:urban --theta 45 --height 200ft,100");
    assert!(plos.to_string().contains("60.96"), "{plos}");
    folder.refuses("place city.geojson --height 100:400ft:50", "E101", &[]);
}

#[test]
fn tables_may_have_semicolons_or_tabs_and_decimal_commas() {
    let folder = folder();
    let answer = |text: &str| {
        folder.write("s.csv", text);
        folder.type_in("map city.geojson --uavs s.csv")
    };
    let refused = |text: &str, code: &str, words: &[&str]| {
        folder.write("s.csv", text);
        folder.refuses("map city.geojson --uavs s.csv", code, words);
    };
    refused("id,x,y,h\n1,40.5,40.25,30.5\n2,2,2.5,50roof\n3,2,3,9\n", "E204", &["UAV `2`"]);
    let commas = "id,x,y,h\n1,40.5,40.25,30.5\n2,25.5,25,20,5roof\n";
    refused(commas, "E302", &["found 5 fields, wanted 4", "decimal commas need semicolons"]);
    let wanted = answer("id,x,y,h\n1,40.5,40.25,30.5\n2,25.5,25,20.5roof\n").done().out;
    for text in [
        "id;x;y;h\n1;40,5;40,25;30,5\n2;25,5;25;20,5roof\n",
        "id;x;y;h\r\n1;40.5;40.25;30.5\r\n2;25.5;25;20.5roof\r\n",
        "id\tx\ty\th\n1\t40,5\t40,25\t30,5\n2\t25,5\t25\t20,5roof\n",
        "# from a spreadsheet, in Munich\n\nid;x;y;h;\"note, if any\"\n1;40,5;40,25;30,5;a\n2;25,5;25;20,5roof;\n",
    ] {
        assert_eq!(answer(text).done().out, wanted, "{text}");
        assert!(folder.type_in("info s.csv").done().out.contains("places     2 places"), "{text}");
    }
    for (text, found) in [
        ("id;x,y;h\n1;2,3;4\n", "line 1: found commas and semicolons"),
        ("id;x;y;h\n1;40,5;40,25;30\n2;25.5;25;30\n", "on line 2 the decimal mark is `,`"),
        ("id;x;y;h\n1;1.040,5;40;30\n", "found `1.040,5`"),
    ] {
        refused(text, "E302", &[found]);
    }
    // A track would take its decimals for the next column.
    folder.write("t.csv", "x,y\n1,5,2,5\n3,5,4,5\n");
    folder.refuses("track city.geojson --uav 2,2,50 --track t.csv", "E302", &["found 4 fields, wanted 2"]);
}

#[test]
fn tables_may_come_from_standard_input() {
    let folder = folder();
    let sites = folder.text("sites.csv");
    let walk =
        r#"{"type":"Feature","properties":{},"geometry":{"type":"LineString","coordinates":[[1000,1],[1000,9]]}}"#;
    for (line, input) in [
        ("map city.geojson --uavs -", sites.as_str()),
        ("compare city.geojson --uav 2,2,50 --uavs -", &sites),
        ("chart city.geojson --time 0 --uavs -", &sites),
        ("place city.geojson --data-area all --candidates -", &sites),
        ("track city.geojson --uav 2,2,50 --track -", "x;y\n2,5;2\n2;48\n"),
        ("track city.geojson --uav 2,2,50 --track -", &format!("\n {walk}")),
        ("plos itu:urban --theta 45 --curve own=-", "theta_deg,p_los\n0,0\n90,1\n"),
    ] {
        let document = with_input(&folder, &format!("{line} --json"), input).done().json();
        let digest: String = Sha256::digest(input.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
        let source = serde_json::json!({"path": "standard input", "sha256": digest});
        assert!(document.to_string().contains(&source.to_string()), "{line}: {document}");
    }
    let from_file = folder.type_in("map city.geojson --uavs sites.csv").done().out;
    assert_eq!(with_input(&folder, "map city.geojson --uavs -", &sites).done().out, from_file);
    // A run for each UAV, done again after others were asked for.
    let each = "map city.geojson --uavs - -o {site}.json --resume";
    with_input(&folder, each, &sites).done();
    let answer = with_input(&folder, each, &(sites.clone() + "b,41,41,30\n")).done();
    assert!(answer.err.contains("1 UAV mapped, 1 there already"), "{answer:?}");
    // All together the table is a part of what the run is.
    let all = "map city.geojson --uavs - -o all.json --resume";
    with_input(&folder, all, &sites).done();
    assert!(with_input(&folder, all, &sites).done().err.contains("nothing to do"));
    assert_eq!(with_input(&folder, all, &(sites.clone() + "b,41,41,30\n")).error(), "E106");
    let bad = with_input(&folder, "map city.geojson --uavs -", "x,y,h\n1,2,3\n4,five,6\n");
    assert!(bad.error() == "E302" && bad.err.contains("standard input: line 3: `y`"), "{bad:?}");
    let twice = with_input(&folder, "plos itu:urban --curve a=- --curve b=-", "theta_deg,p_los\n0,0\n90,1\n");
    assert!(twice.error() == "E101" && twice.err.contains("`-` is given for two tables"), "{twice:?}");
}

#[test]
fn names_that_mean_something_to_a_program_reach_none() {
    let folder = folder();
    // An escape sequence of a terminal in its two forms, a formula, and what XML cannot hold.
    let ids = ["a\x1b[31m", "b\u{9b}2J\u{7f}", "=1+2", "@x", "-5", "-5 m", "c\u{FFFE}d"];
    let rows = |k: usize| format!("\"{}\",{},20,50\n", ids[k], 2 + 5 * k);
    folder.write("odd.csv", &format!("id,x,y,h\n{}", (0..ids.len()).map(rows).collect::<String>()));
    let is_odd = |c: char| (c.is_control() && c != '\n') || c == '\u{FFFE}';
    let map = "map city.geojson --crs EPSG:25832 --uavs odd.csv";
    for line in [format!("{map} --json"), map.to_string(), "info odd.csv".into(), "info odd.csv --json".into()] {
        let answer = folder.type_in(&line).done();
        assert!(!answer.out.contains(is_odd) && !answer.err.contains(is_odd), "{line}: {answer:?}");
    }
    // As JSON they are what they were.
    let document = folder.type_in(&format!("{map} --json -q")).done().json();
    let told: Vec<&str> = document["sites"].as_array().unwrap().iter().map(|s| s["id"].as_str().unwrap()).collect();
    assert_eq!(told, ids);
    let outputs = "-o m.svg -o m.csv -o m.kmz -o m.tif --height-curve h.svg --height-curve h.csv";
    folder.type_in(&format!("{map} {outputs} -q")).done();
    let mut zip = zip::ZipArchive::new(std::fs::File::open(folder.join("m.kmz")).unwrap()).unwrap();
    let kml = std::io::read_to_string(zip.by_name("doc.kml").unwrap()).unwrap();
    for xml in [folder.text("m.svg"), folder.text("h.svg"), kml] {
        assert!(!xml.contains(is_odd), "{xml:.300}");
        roxmltree::Document::parse(&xml).unwrap();
    }
    // Tables hold them as they were, or as text.
    let ids_in = |name: &str| -> Vec<String> {
        let mut reader = csv::Reader::from_path(folder.join(name)).unwrap();
        let at = reader.headers().unwrap().iter().position(|name| name == "id" || name == "site").unwrap();
        let mut ids: Vec<String> = reader.records().map(|row| row.unwrap()[at].to_string()).collect();
        ids.dedup();
        ids
    };
    assert_eq!(&ids_in("m.csv")[..ids.len()], ids);
    folder.type_in(&format!("{map} {outputs} -q --overwrite --csv-text")).done();
    for name in ["m.csv", "h.csv"] {
        assert_eq!(&ids_in(name)[2..6], ["'=1+2", "'@x", "-5", "'-5 m"], "{name}");
    }
}

#[test]
fn a_row_has_one_position_and_a_table_each_column_once() {
    let folder = folder();
    let munich = concat!(env!("CARGO_MANIFEST_DIR"), "/maps/munich_dsm.tif");
    // The position in degrees is that of gdaltransform; with four decimals it is 4 m away.
    for (row, is_right) in [
        ("691549.7,5334762.2,11.5747759,48.1372558,60", true),
        ("691549.7,5334762.2,11.5748,48.1373,60", true),
        ("691549.7,5334762.2,,,60", true),
        ("691549.7,5334762.2,11.5757759,48.1372558,60", false),
        ("691549.7,5334762.2,48.1372558,11.5747759,60", false),
    ] {
        folder.write("both.csv", &format!("x,y,lon,lat,h\n{row}\n"));
        folder.write("track.csv", &format!("x,y,lon,lat\n691500,5334700,,\n{}\n", row.trim_end_matches(",60")));
        for line in [
            format!("map {munich} --radius 50 --uavs both.csv"),
            format!("track {munich} --uav 691549.7,5334762.2,60 --track track.csv"),
        ] {
            if is_right {
                folder.type_in(&line).done();
            } else {
                folder.refuses(&line, "E302", &["its position in the scene and its degrees are "]);
            }
        }
    }
    for header in ["x,y,h,X", "x,y,h,h"] {
        folder.write("twice.csv", &format!("{header}\n40,20,30,41\n"));
        folder.refuses("map city.geojson --uavs twice.csv", "E302", &["line 1: found the column `", "` twice"]);
    }
}
