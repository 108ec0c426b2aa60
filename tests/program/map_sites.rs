//! Files of their own for each UAV: those of single runs, left alone when they are there, whole at any moment.

use std::time::Duration;

use serde_json::Value;
use skyshed_io::formats::GeoTiff;

use crate::needs::has_program;
use crate::program::{Folder, program, send, wait};
use crate::support::{Random, class_of, is_long};

/// A raster and UAVs over it.
fn write_scene(folder: &Folder, n_sites: usize) {
    folder.type_in("city itu:urban --size 700 --seed 3 -o dsm.tif -q").done();
    let mut random = Random(5);
    let mut row = |k: usize| {
        let [x, y, h] = [(20, 680), (20, 680), (80, 140)].map(|(low, high)| random.within(low, high));
        format!("site {k},{x},{y},{h}\n")
    };
    folder.write("sites.csv", &format!("id,x,y,h\n{}", (0..n_sites).map(&mut row).collect::<String>()));
}

fn digest(folder: &Folder, name: &str) -> String {
    let file = GeoTiff::open(folder.join(name), &mut Vec::new()).unwrap_or_else(|e| panic!("{name}: {e}"));
    // Every cell is read, so that a file cut short would be found.
    file.read(file.georef().window(), &mut Vec::new(), |_| ()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let provenance: Value = serde_json::from_str(file.provenance().expect("provenance")).expect("JSON");
    provenance["digest"].as_str().expect("a digest").to_string()
}

#[test]
fn each_uav_gets_the_files_of_a_run_of_its_own() {
    let folder = Folder::new();
    write_scene(&folder, 3);
    let line = "map dsm.tif --ground 0 --uavs sites.csv -o {site}.tif -o {site}.csv";
    let answer = folder.type_in(line).done();
    assert!(answer.err.contains("3 UAVs mapped"), "{answer:?}");
    let table = folder.text("sites.csv");
    for (k, row) in table.lines().skip(1).enumerate() {
        let (_, place) = row.split_once(',').expect("an id");
        folder.type_in(&format!("map dsm.tif --ground 0 --uav {place} -o alone.tif --overwrite -q")).done();
        assert_eq!(digest(&folder, &format!("site_{k}.tif")), digest(&folder, "alone.tif"));
        assert!(folder.text(&format!("site_{k}.csv")).contains(&format!("site {k},")));
    }
    // Footprints and generated cities as well.
    folder.type_in("map itu:urban --size 300 --uav 150,150,90 --uav 100,100,90 -o c{site}.csv -q").done();
    assert!(folder.files().contains(&"c2.csv".to_string()));
}

#[test]
fn the_command_of_a_unit_has_texts_as_they_were_typed() {
    let folder = Folder::new();
    let text = r#"{"type": "Feature", "properties": {"007": 9}, "geometry": {"type": "Polygon",
        "coordinates": [[[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]]]}}"#;
    folder.write("city.geojson", text);
    for (title, credit) in [("007", "1e3"), ("true", "0x10"), ("1.50", "+5")] {
        let line = "map city.geojson --height-field 007 --uav 20,5,60 --data-area all --extent 0,0,30,9";
        let line =
            format!("{line} -o u{{site}}.json -o u{{site}}.svg --title {title} --attribution {credit} --radius 1e2");
        folder.type_in(&format!("{line} --overwrite -q")).done();
        let command: Vec<String> = serde_json::from_value(folder.json("u1.json")["command"].clone()).expect("words");
        let after = |flag: &str| command.iter().skip_while(|word| *word != flag).nth(1).cloned().unwrap_or_default();
        let told = ["--title", "--attribution", "--height-field", "--radius"].map(after);
        assert_eq!(told, [title, credit, "007", "100"], "{command:?}");
    }
}

#[test]
fn with_a_radius_only_what_is_in_range_is_read() {
    let folder = Folder::new();
    write_scene(&folder, 4);
    let whole = "map dsm.tif --ground 0 --uavs sites.csv --radius 90";
    folder.type_in(&format!("{whole} -o all.json -o all.tif -q")).done();
    folder.type_in(&format!("{whole} -o {{site}}.json -o {{site}}.tif -q")).done();
    let all = folder.json("all.json");
    for k in 0..4 {
        let own = folder.json(&format!("site_{k}.json"));
        // Not the placement: zones depend on what lies beyond the range.
        for key in ["receivers", "los", "p_los", "x", "y", "height_amsl_m", "elevation_bands"] {
            assert_eq!(own["sites"][0][key], all["sites"][k][key], "{k} {key}");
        }
        assert!(own["scene"]["cols"].as_u64() < Some(200), "{}", own["scene"]);
        // The cells in range are those of the whole map.
        let read = |name: &str| {
            let file = GeoTiff::open(folder.join(name), &mut Vec::new()).expect("a GeoTIFF");
            let band = if name == "all.tif" { k } else { 0 };
            let window = file.georef().window();
            file.read_band(band, window, &mut Vec::new(), class_of).expect("cells")
        };
        let (part, whole) = (read(&format!("site_{k}.tif")), read("all.tif"));
        let window = whole.georef().window_of(part.georef()).expect("the same cells");
        for row in 0..window.n_rows {
            let expected = &whole.row(window.row + row)[window.col..window.col + window.n_cols];
            assert_eq!(part.row(row), expected, "{k}, row {row}");
        }
    }
    // Rows that can only be read whole are copied first, where they do not fit.
    if has_program("gdal_translate") {
        let words = ["-q", "-co", "COMPRESS=DEFLATE", "-co", "BLOCKYSIZE=1", "dsm.tif", "rows.tif"];
        let status = std::process::Command::new("gdal_translate").args(words).current_dir(folder.path()).status();
        assert!(status.expect("it runs").success());
        let answer = folder.type_in("map rows.tif --ground 0 --uavs sites.csv --radius 90 -o r-{site}.tif");
        assert!(answer.done().err.contains("tiles"));
        for k in 0..4 {
            assert_eq!(digest(&folder, &format!("r-site_{k}.tif")), digest(&folder, &format!("site_{k}.tif")));
        }
    }
}

#[test]
fn what_is_there_is_left_alone() {
    let folder = Folder::new();
    write_scene(&folder, 3);
    let outputs = "-o {site}.tif -o {site}.png -o {site}.json -o {site}.csv -o {site}.exr -o {site}.asc -o {site}.bil \
                   -o {site}.npz -o {site}.geojson -o {site}.svg";
    let line = format!("map dsm.tif --ground 0 --uavs sites.csv --radius 60 {outputs} --resume");
    let run = |line: &str| folder.type_in(line).done().err;
    assert!(run(&line).contains("3 UAVs mapped\n"), "nothing was there");
    let written = || std::fs::metadata(folder.join("site_0.tif")).and_then(|m| m.modified()).expect("a file");
    let before = written();
    // Threads, words and names of other files change nothing.
    assert!(run(&format!("{line} -j 1")).contains("0 UAVs mapped, 3 there already"));
    std::fs::remove_file(folder.join("site_1.exr")).expect("a file");
    assert!(run(&line).contains("1 UAV mapped, 2 there already"));
    assert!(folder.files().contains(&"site_1.exr".to_string()));
    assert_eq!(written(), before);
    // What is left of a run that was killed beside files that are not there is replaced.
    folder.remove(&["tif", "csv", "asc", "bil"].map(|extension| format!("site_2.{extension}")));
    assert!(run(&line).contains("1 UAV mapped, 2 there already"));
    // Where files are called is nobody's business, nor where scratch goes, nor how the UAV was given.
    let place = folder.text("sites.csv").lines().nth(1).map(|row| row.replacen("site 0,", "", 1)).expect("a row");
    folder.write("one.csv", &format!("id,x,y,h\n1,{place}\n"));
    run("map dsm.tif --ground 0 --uavs one.csv --radius 60 -o u-{site}.csv --resume");
    let again = "map dsm.tif --ground 0 --radius 60 --scratch . -o ./u-{site}.csv --resume";
    assert!(run(&format!("{again} --uav {place}")).contains("0 UAVs mapped, 1 there already"));
    assert!(run(&format!("{again} --uav {place} -o ./u-{{site}}.json")).contains("1 UAV mapped"));
    // Another question has another answer.
    let is_other = |line: &str| {
        let answer = folder.type_in(line);
        assert!(answer.error() == "E106" && answer.err.contains("made by another run"), "{line}: {answer:?}");
    };
    is_other(&format!("{line} --rx-height 2"));
    assert!(run(&format!("{line} --rx-height 2 --overwrite")).contains("3 UAVs mapped\n"));
    // So has a changed input.
    folder.type_in("city itu:urban --size 700 --seed 4 -o dsm.tif --overwrite -q").done();
    is_other(&line);
    // A run of all UAVs together can be asked for again, too.
    let line = "map dsm.tif --ground 0 --uavs sites.csv --radius 60 -o all.tif -o all.kmz --crs EPSG:25832 --resume";
    run(line);
    assert!(run(line).contains("nothing to do"));
}

#[test]
fn a_uav_that_cannot_be_mapped_does_not_stop_the_others() {
    let folder = Folder::new();
    write_scene(&folder, 2);
    let table = folder.text("sites.csv").replace("site 1", "low") + "below,300,300,-5\n";
    folder.write("sites.csv", &table);
    let answer = folder.type_in("map dsm.tif --ground 0 --uavs sites.csv -o {site}.csv");
    assert_eq!(answer.code(), 4, "{answer:?}");
    assert!(answer.err.contains("UAV `below`") && answer.err.contains("2 UAVs mapped, 1 not"), "{answer:?}");
    assert!(folder.files().contains(&"low.csv".to_string()));
    folder.refuses("map dsm.tif --uav 1,1,90 -o {site}.csv -o all.tif", "E105", &["{site}"]);
    folder.write("twins.csv", "id,x,y,h\na b,9,9,90\na/b,99,99,90\n");
    folder.refuses("map dsm.tif --uavs twins.csv -o {site}.csv", "E207", &["share the files"]);
}

#[test]
fn an_interrupt_ends_the_run_and_says_what_is_written() {
    let folder = Folder::new();
    write_scene(&folder, 300);
    let line = "map dsm.tif --ground 0 --uavs sites.csv -o {site}.csv";
    let child = program(folder.path(), &line.split_whitespace().collect::<Vec<_>>()).spawn().expect("it starts");
    let is_begun = || folder.files().iter().filter(|name| name.ends_with(".csv")).count() > 3;
    while !is_begun() {
        std::thread::sleep(Duration::from_millis(1));
    }
    send("-INT", &child);
    let answer = wait(child);
    assert_eq!(answer.code(), 130, "{answer:?}");
    assert!(answer.err.contains("interrupted; the files of "), "{answer:?}");
    assert!(!folder.files().iter().any(|name| name.ends_with(".part")), "{:?}", folder.files());
}

#[test]
fn a_hole_in_range_is_no_fault_of_the_file() {
    let folder = Folder::new();
    let row = format!("{}\n", vec!["-9999"; 60].join(" "));
    let high = format!("{}\n", vec!["5"; 60].join(" "));
    let rows = row.repeat(30) + &high.repeat(30);
    let header = "ncols 60\nnrows 60\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n";
    folder.write("half.asc", &(header.to_string() + &rows));
    let over = "--uav 30,50,30amsl --radius 6";
    folder.type_in(&format!("map half.asc {over} -o whole.json -q")).done();
    folder.type_in(&format!("map half.asc {over} -o part-{{site}}.json -q")).done();
    std::fs::create_dir(folder.join("tiles")).expect("a folder");
    std::fs::copy(folder.join("half.asc"), folder.join("tiles/half.asc")).expect("a copy");
    folder.type_in(&format!("map tiles {over} -o tile-{{site}}.json -q")).done();
    for name in ["whole.json", "part-1.json", "tile-1.json"] {
        assert_eq!(folder.json(name)["sites"][0]["p_los"], Value::Null, "{name}");
    }
    assert_eq!(folder.json("part-1.json")["scene"]["extent"], folder.json("tile-1.json")["scene"]["extent"]);
}

#[test]
fn another_data_area_in_the_same_file_is_another_run() {
    let folder = Folder::new();
    let square = |side: f64| format!("[[[0, 0], [{side}, 0], [{side}, {side}], [0, {side}], [0, 0]]]");
    let write = |name: &str, side: f64| {
        let crs = r#""crs": {"type": "name", "properties": {"name": "EPSG:25832"}}, "properties": {"height": 9}"#;
        let geometry = format!(r#"{{"type": "Polygon", "coordinates": {}}}"#, square(side));
        folder.write(name, &format!(r#"{{"type": "Feature", {crs}, "geometry": {geometry}}}"#));
    };
    write("city.geojson", 9.0);
    let resumed = |side: f64| {
        write("area.geojson", side);
        let line = "map city.geojson --extent 0,0,40,40 --data-area area.geojson --uav 20,20,30";
        folder.type_in(&format!("{line} -o u-{{site}}.json --resume -q"))
    };
    resumed(20.0).done();
    assert_eq!(folder.json("u-1.json")["sites"][0]["receivers"], 400 - 81);
    let answer = resumed(30.0);
    assert!(answer.error() == "E106" && answer.err.contains("made by another run"), "{answer:?}");
}

#[test]
fn killed_at_any_moment_it_leaves_whole_files_and_goes_on() {
    let folder = Folder::new();
    write_scene(&folder, 6);
    let line = "map dsm.tif --ground 0 --uavs sites.csv -o {site}.tif -o {site}.json --resume -q";
    let words: Vec<&str> = line.split_whitespace().collect();
    let run = || program(folder.path(), &words).spawn().expect("the program starts");
    wait(run()).done();
    let names: Vec<String> = (0..6).map(|k| format!("site_{k}.tif")).collect();
    let expected: Vec<String> = names.iter().map(|name| digest(&folder, name)).collect();
    let finals = || folder.files().into_iter().filter(|name| name.starts_with("site_")).collect::<Vec<_>>();
    let n_files = finals().len();
    let mut random = Random(11);
    let (mut n_partial, n_kills) = (0, if is_long() { 200 } else { 20 });
    for _ in 0..n_kills {
        folder.remove(&finals());
        // Once it has some of its files, at any moment of the work on the next one; and then what is left of it alike.
        for _ in 0..2 {
            let mut child = run();
            let n_wanted = random.index(finals().len().min(n_files - 1), n_files - 1);
            while finals().len() < n_wanted && child.try_wait().expect("a child").is_none() {
                std::thread::sleep(Duration::from_micros(100));
            }
            std::thread::sleep(Duration::from_micros(random.next() % 3000));
            let _ = child.kill();
            child.wait().expect("a killed program ends");
            n_partial += usize::from(!finals().is_empty() && finals().len() < n_files);
            for name in finals() {
                match names.iter().position(|n| *n == name) {
                    Some(k) => assert_eq!(digest(&folder, &name), expected[k], "{name} is whole"),
                    None if name.ends_with(".json") => drop(folder.json(&name)),
                    None => {}
                }
            }
        }
        wait(run()).done();
        let found: Vec<String> = names.iter().map(|name| digest(&folder, name)).collect();
        assert_eq!(found, expected);
    }
    assert!(n_partial > n_kills, "{n_partial} of {} were killed with work done and work left", 2 * n_kills);
}

#[test]
fn equal_units_are_equal_bytes_however_they_were_batched() {
    let folder = Folder::new();
    write_scene(&folder, 7);
    let outputs = ["tif", "json", "csv", "npz", "png", "geojson"];
    let words = |name: &str| outputs.map(|extension| format!("-o {name}-{{site}}.{extension}")).join(" ");
    let line = "map dsm.tif --ground 0 --radius 90 --rx-height 2 -q";
    folder.type_in(&format!("{line} --uavs sites.csv {}", words("all"))).done();
    for k in 1..=3 {
        folder.type_in(&format!("{line} --uavs sites.csv --shard {k}/3 -j 1 --resume {}", words("part"))).done();
    }
    // One by one, from a table of another name, in another order of words.
    let table = folder.text("sites.csv");
    for row in table.lines().skip(1) {
        folder.write("one.csv", &format!("id,x,y,h\n{row}\n"));
        folder
            .type_in(&format!("map --uavs one.csv dsm.tif {} --rx-height 2 --ground 0 -q --radius 90", words("one")))
            .done();
    }
    for k in 0..7 {
        for extension in outputs {
            let read =
                |name: &str| std::fs::read(folder.join(&format!("{name}-site_{k}.{extension}"))).expect("a file");
            assert!(read("part") == read("all"), "site {k}, {extension}, by shards");
            assert!(read("one") == read("all"), "site {k}, {extension}, one by one");
        }
        let document = folder.json(&format!("all-site_{k}.json"));
        assert!(document["timing_s"].is_null() && !document.to_string().contains("sites.csv"), "{document}");
    }
    let refused = |words: &str| folder.type_in(&format!("{line} {words} -o x-{{site}}.tif")).error().to_string();
    for bad in ["0/3", "4/3", "1", "a/b", "1/0"] {
        assert_eq!(refused(&format!("--uavs sites.csv --shard {bad}")), "E101", "{bad}");
    }
    // More parts than UAVs: some have nothing to do.
    let empty = folder.type_in(&format!("{} --uavs sites.csv --shard 1/9 -o e-{{site}}.tif", line.replace(" -q", "")));
    assert!(empty.done().err.contains("0 UAVs mapped"));
}
