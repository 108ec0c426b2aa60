//! `skyshed chart` from outside: the picture from its table, interrupts, peers, P_LoS, flags, and what it refuses.

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read};
use std::process::Command;

use serde_json::Value;

use crate::chart::{BY_HAND, classes, document, folder, grid, rough, row, without_times};
use crate::needs::has_program;
use crate::program::{program, send};

/// The rows of a table as maps from column to cell.
fn table(text: &str) -> Vec<HashMap<String, String>> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().map(Result::unwrap).collect()
}

#[test]
fn the_picture_shows_its_table() {
    let folder = folder();
    let scene = "rough.asc --ground 0 --uav 20.3,17.8,35 --time 0.02";
    folder.type_in(&format!("chart {scene} -o c.svg -o c.json --csv c.csv -o c.png -q")).done();
    let (svg, text, document) = (folder.text("c.svg"), folder.text("c.csv"), folder.json("c.json"));
    let columns = "method,parameters,cpu_s,wall_s,peak_mb,wrong_cells,receivers,false_los,false_nlos,p_los,p_los_error";
    assert!(text.starts_with(&format!("{columns},")), "{text}");
    let rows = table(&text);
    assert_eq!(rows.len(), document["contestants"].as_array().unwrap().len());
    let number = |row: &HashMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
    let place = |row| {
        let all = number(row, "receivers") + number(row, "unanswered");
        (1e9 * number(row, "cpu_s") / all, number(row, "wrong_cells") / number(row, "receivers"))
    };
    let places: Vec<(f64, f64)> = rows.iter().map(place).collect();
    // Axes reach a factor of 1.6 beyond the costs and of 2 beyond the errors, over two powers of ten at least.
    let floor =
        1e9 * document["memory_floor"]["cpu_s"].as_f64().unwrap() / document["exact"]["receivers"].as_f64().unwrap();
    let ends = |values: &mut dyn Iterator<Item = f64>, factor: f64| {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = (low / factor, high * factor);
        let wider = (100.0 * low / high).max(1.0).sqrt();
        (low / wider, high * wider)
    };
    let placed = || places.iter().filter(|p| p.1.is_finite());
    let costs = ends(&mut placed().map(|p| p.0).chain([floor]), 1.6);
    let errors = ends(&mut placed().map(|p| p.1).filter(|e| *e > 0.0), 2.0);
    let share = |v: f64, (low, high): (f64, f64)| (v / low).ln() / (high / low).ln();
    let marks: Vec<(f64, f64)> = svg.lines().filter_map(mark_center).collect();
    // Cells eight times as large leave no receiver here, and have no place.
    let drawn = || rows.iter().zip(&places).filter(|(row, _)| row["receivers"] != "0");
    assert!(drawn().count() > 10);
    for (row, (cost, error)) in drawn() {
        let x = 980.0 * share(*cost, costs);
        let y = if *error > 0.0 { 696.0 * (1.0 - share(*error, errors)) } else { 748.0 };
        let is_drawn = marks.iter().any(|(mx, my)| (mx - x).abs() < 0.02 && (my - y).abs() < 0.02);
        assert!(is_drawn, "{row:?} at ({x}, {y}): {marks:?}");
    }
    for words in ["0: none wrong", "memory floor", "CPU time per receiver [ns]", "Wrong receivers [share of all]"] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(svg.contains("skyshed/chart/1") && folder.text("c.csv.json").contains("\"digest\""), "provenance");
}

/// The center of a mark: of a circle, or of a polygon whose shape is a mark's, from its corners.
fn mark_center(line: &str) -> Option<(f64, f64)> {
    let value = |key: &str| line.split(&format!(" {key}=\"")).nth(1)?.split('"').next();
    if line.starts_with("<circle") {
        return Some((value("cx")?.parse().ok()?, value("cy")?.parse().ok()?));
    }
    let corners: Vec<(f64, f64)> = value("points")
        .filter(|_| line.starts_with("<polygon"))?
        .split(' ')
        .filter_map(|pair| pair.split_once(','))
        .filter_map(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)))
        .collect();
    let (x, y) = *corners.first()?;
    Some(match corners.len() {
        // A square and a diamond differ in whether the first corner is over the middle.
        4 if (corners[1].1 - y).abs() < 0.01 => (x + 7.2, y + 7.2),
        4 => (x, y + 10.4),
        3 => (x, y + 10.8),
        _ => return None,
    })
}

#[test]
fn an_interrupt_writes_what_is_done_and_says_so() {
    let folder = folder();
    let words = "chart itu:urban --size 150 --uav 75,75,100 --time 3 -o c.png -o c.svg -o c.csv -o c.json";
    // Each of 13 contestants is timed for three seconds; on a busy machine the first may have begun late.
    let is_written = [1, 4, 16, 64, 256].into_iter().any(|seconds| {
        let words: Vec<&str> = words.split(' ').collect();
        let mut child = program(folder.path(), &words).spawn().expect("the program starts");
        let mut err = BufReader::new(child.stderr.take().expect("piped"));
        let mut first = String::new();
        err.read_line(&mut first).expect("text");
        assert!(first.contains("to come"), "{first}");
        std::thread::sleep(std::time::Duration::from_secs(seconds));
        send("-INT", &child);
        let mut rest = String::new();
        err.read_to_string(&mut rest).expect("text");
        assert_eq!(child.wait().expect("it ends").code(), Some(130), "{rest}");
        let is_written = rest.ends_with("error[E130]: interrupted; the contestants that had their turn were written\n");
        let has_any = || folder.json("c.json")["contestants"].as_array().is_some_and(|n| !n.is_empty());
        let is_told = is_written && has_any();
        if is_written && !is_told {
            folder
                .files()
                .iter()
                .filter(|file| file.starts_with("c."))
                .for_each(|file| std::fs::remove_file(folder.join(file)).unwrap());
        }
        is_told
    });
    assert!(is_written);
    let document = folder.json("c.json");
    assert_eq!(document["interrupted"], true);
    let n = document["contestants"].as_array().unwrap().len();
    assert!((1..13).contains(&n), "{n} had their turn");
    assert_eq!(table(&folder.text("c.csv")).len(), n);
    assert!(folder.text("c.svg").contains("(interrupted)") && folder.read("c.png").starts_with(b"\x89PNG"));
    assert!(folder.text("c.csv.json").contains("\"interrupted\": true"));
    assert!(!folder.files().iter().any(|file| file.ends_with(".part")));
    let whole = self::document(&folder, BY_HAND);
    assert_eq!(whole["interrupted"], false);
}

#[test]
fn gdal_viewshed_competes_where_it_is_installed() {
    let folder = folder();
    let document = document(&folder, "rough.asc --ground 0 --uav 20.3,17.8,35 --peers");
    let rows = document["contestants"].as_array().unwrap();
    let peer = rows.iter().find(|row| row["method"] == "gdal_viewshed").unwrap();
    if !has_program("gdal_viewshed") {
        assert_eq!(peer["reason"], "gdal_viewshed is not found on the PATH");
        return;
    }
    assert!(peer["parameters"].as_str().unwrap().starts_with("GDAL "), "{peer}");
    // The same program on the file itself, by hand: its masks hold the same LoS receivers. The UAV is over open ground.
    let by_hand = "-q -f GTiff -md 0 -cc 0 -oz 35 -tz 1.5 -ox 20.3 -oy 17.8 -vv 1 -iv 0 -ov 0 rough.asc mask.tif";
    let run = Command::new("gdal_viewshed").args(by_hand.split(' ')).current_dir(folder.path()).status();
    assert!(run.unwrap().success());
    assert_eq!(rough()[22 * 48 + 20], 0, "the UAV's cell is open ground");
    let mask = classes(&folder, "mask.tif");
    let open: Vec<bool> = rough().iter().map(|z| *z == 0).collect();
    let los = mask.iter().zip(&open).filter(|(class, open)| **class == 1 && **open).count() as u64;
    assert_eq!(peer["own_los"].as_u64(), Some(los), "{peer}");
    assert_eq!(peer["own_receivers"].as_u64(), Some(open.iter().filter(|open| **open).count() as u64));
    assert!(peer["wrong_cells"].as_u64() > Some(0) && peer["cpu_s"].is_number(), "{peer}");
    // A UAV outside the raster is no failure of the whole.
    let outside = self::document(&folder, "rough.asc --ground 0 --uav=-20,17.8,60amsl --peers");
    let peer = row(&outside, "gdal_viewshed", "");
    assert!(peer["reason"].as_str().unwrap().contains("outside"), "{peer}");
}

#[test]
fn the_ways_to_p_los_are_charted_too() {
    let folder = folder();
    folder.type_in("chart itu:urban --plos --time 0 -o p.png -o p.svg -o p.json --csv p.csv -q").done();
    let document = folder.json("p.json");
    assert_eq!((&document["kind"], &document["theta_deg"]), (&"p_los".into(), &45.0.into()));
    let reference = document["reference"]["p_los"].as_f64().unwrap();
    let error = |row: &Value, name: &str| row[name].as_f64().unwrap();
    let mut n_estimates = 0;
    for row in document["contestants"].as_array().unwrap().iter().filter(|row| row["p_los"].is_number()) {
        let bias = error(row, "p_los") - reference;
        assert!((bias - error(row, "p_los_error")).abs() < 1e-12);
        if row["std_error"].is_number() {
            n_estimates += 1;
            assert!(bias.abs() < 5.0 * error(row, "std_error") + 1e-4, "{row}");
        }
    }
    assert_eq!(n_estimates, 14);
    // The product's standard error falls faster than that of dice: 128 times the points, less than 1/√128 of it.
    let of = |parameters: &str| error(row(&document, "product", parameters), "std_error");
    assert!(of("32 shifts of 16384 points") < of("32 shifts of 128 points") / 11.4);
    // An independent run of the command for curves says the same of the models.
    let table = folder.type_in("plos itu:urban --theta 45 --method itu,holis2008 --json -q").done().json();
    for (k, model) in ["itu", "holis2008"].into_iter().enumerate() {
        let [here, there] =
            [&row(&document, model, "")["p_los"], &table["rows"][k]["p_los"]].map(|p| p.as_f64().unwrap());
        assert!((here - there).abs() < 1e-11, "{model}: {here} and {there}");
    }
    let header = folder.text("p.csv");
    assert!(header.starts_with("method,parameters,cpu_s,wall_s,peak_mb,std_error,p_los,p_los_error,"), "{header}");
    assert!(folder.text("p.svg").contains("Published models"));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let folder = folder();
    let before = folder.files();
    for (line, code, told) in [
        ("wall.asc --ground 0 -o c.png", "E108", ""),
        ("wall.asc --ground 0 --uav 1,1 -o c.png", "E102", ""),
        ("itu:urban --plos --uav 1,1,50 -o c.png", "E116", "`--uav`"),
        ("itu:urban --plos --peers -o c.png", "E116", "`--peers`"),
        ("itu:urban --plos --theta 95 -o c.png", "E120", ""),
        ("wall.asc --ground 0 --plos -o c.png", "E116", "`--plos`"),
        ("UAV --theta 45 -o c.png", "E101", "--plos"),
        ("UAV --height 45 -o c.png", "E101", "--plos"),
        ("UAV --receivers street -o c.png", "E116", "`street`"),
        ("UAV --method shadow -o c.png", "E118", ""),
        ("UAV --time -1 -o c.png", "E113", "`-1`"),
        ("UAV -o c.tif", "E105", ""),
        ("UAV --csv c.txt", "E105", ""),
        ("UAV --title T -o c.csv", "E116", "`--title`"),
        ("wall.asc --ground 0 --uav 3.5,1.5,2 --json", "E201", ""),
    ] {
        let line = line.replace("UAV", "wall.asc --ground 0 --uav 1,1,50");
        folder.refuses(&format!("chart {line}"), code, &[told]);
        assert_eq!(folder.files(), before, "{line}");
    }
    // Nobody in range is no failure, and no number.
    let exact = document(&folder, &format!("{BY_HAND} --receivers roof --radius 1"))["exact"].clone();
    assert_eq!((&exact["p_los"], &exact["reason"]), (&Value::Null, &"no receiver in range".into()));
    folder.type_in(&format!("chart {BY_HAND} --receivers roof --radius 1 --time 0 -o n.png")).done();
}

/// Charts, and flags that each change their documents.
const FLAGS: [(&str, &str); 9] = [
    ("CITY", "--ground 5; --height-field tall; --top-field z_top; --missing levels; --extent 0,0,50,50; --cell 2"),
    ("CITY", "--crs EPSG:25832; --terrain slope.asc; --data-area all; --uav 40,30,50; --uavs sites.csv; --rx-height 9"),
    ("CITY", "--receivers all; --radius 20; --method step:3; --peers"),
    ("CITY --terrain slope.asc", "--base highest"),
    ("wall.asc --ground 0 --uav 0.5,1.5,11.5", "--building-threshold 6"),
    ("holes.asc --ground 0 --uav 0.5,0.5,5", "--nodata-as block"),
    ("itu:urban --size 40 --uav 2,2,50", "--seed 2"),
    ("itu:urban --uav 2,2,50 --cell 10", "--size 300"),
    ("itu:urban --plos", "--theta 60; --height 50"),
];

#[test]
fn every_flag_changes_the_document() {
    let folder = folder();
    folder.write("holes.asc", &grid(&[0, 0, 0, 0, 0, -9999, -9999, 0, 0, 0, 0, 0, 1, 1, 1, 1], 4));
    folder.write("slope.asc", &grid(&(0..50 * 50).map(|k| k % 50 / 4).collect::<Vec<_>>(), 50));
    folder.write("sites.csv", "id,x,y,h\na,40,30,50\n");
    let plan = |line: &str| without_times(document(&folder, line));
    for (line, flags) in FLAGS {
        let line = line.replace("CITY", "city.geojson --uav 2,2,50");
        let without = plan(&line);
        for flag in flags.split("; ") {
            assert_ne!(without, plan(&format!("{line} {flag}")), "{line} {flag}");
        }
    }
}

#[test]
fn words_and_files_go_where_they_should() {
    let folder = folder();
    let loud = folder.type_in(&format!("chart {BY_HAND} --time 0")).done();
    assert!(loud.out.starts_with("method,parameters,cpu_s"), "{}", loud.out);
    assert!(loud.err.contains("18 receivers decided exactly by ray") && loud.err.contains("step:4:"), "{}", loud.err);
    folder.type_in(&format!("chart {BY_HAND} --time 0 -o t.svg --title Downtown --attribution Surveyors -q")).done();
    let svg = folder.text("t.svg");
    assert!(svg.contains(">Downtown<") && svg.contains(">Surveyors<"));
    folder.refuses(&format!("chart {BY_HAND} -o t.svg"), "E106", &["t.svg"]);
    folder.type_in(&format!("chart {BY_HAND} --time 0 -o t.svg --overwrite -q")).done();
}
