//! The program from outside: what it says where, its exit codes, and that every flag changes what it does.

use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::figures::words;
use crate::program::{Folder, interrupt, program, run_in, wait};
use crate::support::{Random, is_long};

/// Three buildings without heights, with storeys, and with everything; tops measured from the datum too.
const FOOTPRINTS: &str = r#"{"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": {"height": 20, "tall": 35, "z_top": 18, "z_ground": 0},
   "geometry": {"type": "Polygon", "coordinates": [[[20,20],[30,20],[30,30],[20,30],[20,20]]]}},
  {"type": "Feature", "properties": {"height": 12, "tall": 5, "z_top": 30, "z_ground": 0},
   "geometry": {"type": "Polygon", "coordinates": [[[5,5],[15,5],[15,12],[5,12],[5,5]]]}},
  {"type": "Feature", "properties": {"building:levels": 5},
   "geometry": {"type": "Polygon", "coordinates": [[[42.6,13],[44,13],[44,14],[42.6,14],[42.6,13]]]}}]}"#;

/// An ASCII grid of 50 × 50 cells of 1 m from (0, 0), with a height for each column and row from the north.
fn grid(height: impl Fn(usize, usize) -> String) -> String {
    let mut text = "ncols 50\nnrows 50\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n".to_string();
    for row in 0..50 {
        let line: Vec<String> = (0..50).map(|col| height(row, col)).collect();
        text += &line.join(" ");
        text += "\n";
    }
    text
}

/// A folder with a scene of each kind.
pub(crate) fn scenes() -> Folder {
    let folder = Folder::new();
    folder.write("city.geojson", FOOTPRINTS);
    let surface = |row: usize, col: usize| match (row, col) {
        (20..30, 20..30) => "20".to_string(),
        (10..15, 5..45) => "2.1".to_string(),
        (35..40, 10..12) => "-9999".to_string(),
        _ => "0".to_string(),
    };
    folder.write("dsm.asc", &grid(surface));
    folder.write("slope.asc", &grid(|_, col| format!("{}", col as f64 / 10.0)));
    folder.write("holes.asc", &grid(|_, col| if col == 19 { "-9999" } else { "1" }.to_string()));
    folder.write("sites.csv", "id,x,y,h\na,40,40,30\n");
    folder
}

/// What a run of `map` is, apart from its words and its times.
pub(crate) fn plan(folder: &Folder, line: &str) -> Value {
    let mut document = folder.type_in(&format!("map {line} --json")).done().json();
    let object = document.as_object_mut().expect("an object");
    object.remove("command");
    object.remove("request");
    object.remove("timing_s");
    document
}

#[test]
fn what_makes_no_sense_is_refused_with_its_own_exit_code_and_leaves_nothing() {
    let folder = scenes();
    let before = folder.files();
    let short = [
        ("GENERATED", "map itu:urban --uav 10,10,50 -o out.png"),
        ("FOOTPRINTS", "map city.geojson --uav 1,1,50 -o out.png"),
        ("RASTER", "map dsm.asc --uav 1,1,50 -o out.png"),
        ("SMALL", "map itu:urban --size 200 -o out.png"),
    ];
    // A line, its code, and what was found or is at fault.
    for (line, code, found) in [
        ("", "E101", "no command"),
        ("mapp", "E101", "'mapp'"),
        ("map", "E101", "<SCENE>"),
        ("map itu:urban --no-such-flag", "E101", "'--no-such-flag'"),
        ("SMALL", "E108", "`--uav X,Y,H`"),
        // Numbers.
        ("SMALL --uav 10,10", "E102", "found 2 values"),
        ("SMALL --uav 10,10,9,9", "E102", "found 4 values"),
        ("SMALL --uav ,,", "E102", "`--uav ,,`: x: found ``"),
        ("SMALL --uav nan,10,50", "E102", "`--uav nan,10,50`: x: found `NaN`"),
        ("SMALL --uav 10,-inf,50", "E102", "y: found `-inf`"),
        ("SMALL --uav 10,10,1e400", "E102", "height `1e400`: found `inf`"),
        ("SMALL --uav 10,10,50yd", "E102", "height `50yd`: found `50yd`"),
        ("GENERATED --rx-height -1", "E113", "the receivers' height is `-1`"),
        ("GENERATED --rx-height nan", "E101", "'nan' for '--rx-height <M>'"),
        ("GENERATED --radius 0", "E113", "the radius is `0`"),
        ("GENERATED --radius NaN", "E101", "'NaN' for '--radius <M>'"),
        ("GENERATED --cell 0", "E112", "the cell size is `0`"),
        ("FOOTPRINTS --cell -2", "E112", "`--cell` is `-2`"),
        ("GENERATED --size NaN", "E101", "'NaN' for '--size <M>'"),
        ("GENERATED --size -9", "E112", "the size is `-9`"),
        ("map itu:1.5,500,15 --uav 1,1,50 -o out.png", "E110", "α (built-up ratio) is `1.5`"),
        ("map itu:0.3,500 --uav 1,1,50 -o out.png", "E111", "found `0.3,500`"),
        ("map itu:0.3,500,nan --uav 1,1,50 -o out.png", "E110", "γ (height scale) is `NaN`"),
        ("map itu:ruburban --uav 1,1,50 -o out.png", "E111", "`itu:ruburban`"),
        ("FOOTPRINTS --extent 1,2,3", "E101", "'1,2,3' for '--extent"),
        ("FOOTPRINTS --extent 1,2,3,inf", "E101", "'1,2,3,inf' for '--extent"),
        ("FOOTPRINTS --extent 9,0,1,9", "E114", "`--extent` is `9,0,1,9`"),
        ("RASTER --ground 99999", "E113", "`--ground` is `99999`"),
        ("RASTER --ground 0 --building-threshold -1", "E113", "`--building-threshold`"),
        ("RASTER --crs EPSG:1", "E115", "`--crs`"),
        ("GENERATED -j 0", "E101", "'0' for '--threads <N>'"),
        ("GENERATED --seed -1", "E101", "'-1'"),
        ("GENERATED --method guess", "E101", "'guess' for '--method <METHOD>'"),
        ("GENERATED --layers los,shade", "E101", "'shade' for '--layers <LAYER,…>'"),
        ("GENERATED --receivers sky", "E101", "'sky' for '--receivers <WHERE>'"),
        // Flags that the scene or the outputs cannot use.
        ("GENERATED --terrain slope.asc", "E116", "`--terrain`"),
        ("GENERATED --missing fail", "E116", "`--missing`"),
        ("RASTER --cell 2", "E116", "`--cell`"),
        ("RASTER --top-field z", "E116", "`--top-field`"),
        ("RASTER --building-threshold 1", "E116", "`--building-threshold`"),
        ("FOOTPRINTS --size 9", "E116", "`--size`"),
        ("FOOTPRINTS --nodata-as block", "E116", "`--nodata-as`"),
        ("FOOTPRINTS --band 1", "E116", "`--band`"),
        ("GENERATED --band 1", "E116", "`--band`"),
        ("RASTER --band 2", "E108", "no band `2`"),
        ("RASTER --band 0", "E101", "counted from 1"),
        ("FOOTPRINTS --top-field z --height-field h", "E101", "'--height-field"),
        ("RASTER --ground 0 --terrain slope.asc", "E101", "'--terrain"),
        ("RASTER --receivers roof", "E117", "`roof`"),
        ("map dsm.asc --uav 1,1,50 -o out.tif --bare", "E116", "`--bare`"),
        ("GENERATED --tif-layout plain", "E116", "`--tif-layout`"),
        ("GENERATED --tif-layout strips", "E101", "'strips' for '--tif-layout"),
        // Outputs.
        ("map itu:urban --uav 10,10,50 -o out.xyz", "E104", "out.xyz"),
        ("map itu:urban --uav 10,10,50 -o nowhere/out.png", "E401", "nowhere/out.png"),
        ("GENERATED -o out.png", "E105", "out.png: it is named twice"),
        ("map dsm.asc --uav 1,1,50 -o dsm.asc --overwrite", "E105", "dsm.asc: it is an input"),
        ("map dsm.asc --uavs sites.csv -o sites.csv --overwrite", "E105", "sites.csv: it is an input"),
        ("RASTER --terrain slope.asc -o slope.asc --overwrite", "E105", "slope.asc: it is an input"),
        ("link itu:urban --uav 10,10,50 --rx 20,10 -o out.tif", "E105", "out.tif: this command does"),
        ("city dsm.asc -o out.geojson", "E109", "out.geojson"),
        ("map itu:urban --uav 10,10,50 --uav 10,10,60 -o out.asc", "E107", "out.asc"),
        // Input files.
        ("map nowhere.tif --uav 10,10,50 -o out.png", "E301", "nowhere.tif"),
        ("map nowhere.geojson --uav 10,10,50 -o out.png", "E301", "nowhere.geojson"),
        ("map city.shp --uav 10,10,50 -o out.png", "E301", "city.shp"),
        ("SMALL --uavs nowhere.csv", "E301", "nowhere.csv"),
        // Sites.
        ("SMALL --uav 30,30,1", "E201", "UAV `1` at (30, 30) with height 1agl: 1 m above the datum"),
        ("SMALL --uav 10,10,-5", "E202", "UAV `1` at (10, 10) with height -5agl: -5 m above the datum"),
        ("map dsm.asc --ground 5 --uav 1,1,4amsl -o out.png", "E202", "UAV `1` at (1, 1) with height 4amsl"),
        ("SMALL --uav 1e6,10,50", "E203", "UAV `1` at (1000000, 10) with height 50agl"),
        ("map dsm.asc --uav 11,12.5,9 -o out.png", "E204", "UAV `1` at (11, 12.5)"),
        ("SMALL --uav 10,10,30roof", "E204", "UAV `1` at (10, 10) with height 30roof: no building"),
        ("map dsm.asc --uav 25,25,9roof -o out.png", "E204", "UAV `1` at (25, 25) with height 9roof"),
        ("SMALL --uav 10,10,40000", "E205", "UAV `1` at (10, 10) with height 40000agl"),
        ("link itu:urban --uav 10,10,50 --rx 30,30,1", "E201", "the receiver at (30, 30)"),
        // Limits.
        ("GENERATED --size 70000", "E502", "70000 m"),
        ("GENERATED --cell 0.001", "E502", "1000000 cells"),
        ("FOOTPRINTS --extent 0,0,1e6,1e6", "E502", "city.geojson"),
        ("FOOTPRINTS --extent 0,0,40000,40000", "E501", "40000×40000"),
    ] {
        // Only there has every run little memory.
        if code == "E501" && !cfg!(target_os = "linux") {
            continue;
        }
        let line = short.iter().fold(line.to_string(), |line, (word, words)| line.replace(word, words));
        folder.refuses(&line, code, &[found]);
        assert_eq!(folder.files(), before, "{line}");
    }
}

#[test]
fn an_inside_uav_is_told_what_to_ask_for_instead() {
    let folder = scenes();
    let told = ["roof at 20 m", "`20agl`", "`5roof` hovers at 25 m"];
    folder.refuses("map city.geojson --uav 25,25,5 -o out.png", "E201", &told);
    for height in ["20agl", "5roof", "20amsl", "0roof"] {
        folder.type_in(&format!("map city.geojson --uav 25,25,{height} --json")).done();
    }
    folder.refuses("map city.geojson --uav 25,25,-5 --json", "E201", &["`20agl`"]);
}

#[test]
fn a_large_input_is_hashed_on_request() {
    let folder = scenes();
    // 65 MiB of blanks behind the end are valid JSON.
    let blanks = " ".repeat(65 << 20);
    folder.write("large.geojson", &format!("{FOOTPRINTS}{blanks}"));
    let hash = |flag: &str| {
        let document = folder.type_in(&format!("info large.geojson --json {flag}")).done().json();
        document["sources"][0]["sha256"].clone()
    };
    assert_eq!(hash(""), Value::Null);
    assert_eq!(hash("--hash").as_str().map(str::len), Some(64));
    // A generated city is read from no file.
    for line in ["map itu:urban --size 50 --uav 9,9,50 --hash", "place itu:urban --size 50 --height 50 --hash"] {
        folder.refuses(line, "E116", &["`--hash`"]);
    }
}

#[test]
fn title_and_attribution_are_drawn() {
    let folder = scenes();
    let base = "map city.geojson --uav 2,2,50 -q -o";
    folder.type_in(&format!("{base} plain.svg")).done();
    folder.type_in(&format!("{base} title.svg --title Downtown")).done();
    folder.type_in(&format!("{base} credit.svg --attribution Surveyors")).done();
    let (plain, title, credit) = (folder.text("plain.svg"), folder.text("title.svg"), folder.text("credit.svg"));
    let by_itself = "What a UAV sees of the footprints in city.geojson";
    assert!(words(&plain).contains(by_itself) && !words(&title).contains(by_itself), "{plain}");
    assert!(title.contains("Downtown</text>") || title.contains(">Downtown<"), "no title");
    assert!(credit.contains(">Surveyors<"), "no attribution");
}

#[test]
fn threads_do_not_change_results() {
    let folder = Folder::new();
    let run = |threads: &str| plan(&folder, &format!("itu:high-rise --size 300 --uav 150,150,200 -j {threads}"));
    let one = run("1");
    assert_eq!(one, run("2"));
    assert_eq!(one, run("7"));
}

#[test]
fn the_method_changes_no_result_and_is_chosen_by_the_scene() {
    let folder = scenes();
    // Scene, what auto takes, what can be asked for, what cannot.
    let scenes = [
        ("city.geojson --uav 2,2,50", "shadow", "shadow", Some("sweep")),
        ("city.geojson --terrain slope.asc --uav 2,2,90", "shadow+sweep", "shadow", Some("sweep")),
        ("city.geojson --terrain slope.asc --cell 0.5 --uav 2,2,90", "shadow+ray", "shadow", None),
        ("dsm.asc --ground 0 --uav 2,2,50 --receivers all", "sweep", "sweep", Some("shadow")),
        ("dsm.asc --uav 2,2,50", "sweep", "sweep", Some("shadow")),
        ("itu:urban --size 200 --uav 2,2,50 --receivers roof", "shadow", "shadow", Some("sweep")),
    ];
    for (scene, auto, other, wrong) in scenes {
        let by_auto = plan(&folder, scene);
        assert_eq!(by_auto["method"], auto, "{scene}");
        for method in ["ray", other] {
            let mut by_method = plan(&folder, &format!("{scene} --method {method}"));
            by_method["method"] = by_auto["method"].clone();
            assert_eq!(by_auto, by_method, "{scene} --method {method}");
        }
        if let Some(wrong) = wrong {
            folder.refuses(&format!("map {scene} --method {wrong} --json"), "E118", &[auto]);
        }
    }
    let said = folder.type_in("map dsm.asc --uav 2,2,50 --json").done().err;
    assert!(said.contains("method sweep (exact; a raster: one sweep over its cells)"), "{said}");
}

#[test]
fn a_run_that_needs_more_memory_than_allowed_is_refused_before_it_starts() {
    let folder = scenes();
    let line = "map itu:urban --size 200 --uav 2,2,50 --json --max-memory";
    for enough in ["100M", "104857600", "0.5GiB", "2g", "1t"] {
        folder.type_in(&format!("{line} {enough}")).done();
    }
    // What the program alone takes, and less than its cells do.
    for (limit, needs) in [("300K", "the program alone takes "), ("20M", "its buildings and cells need ")] {
        let line = format!("{} {limit}", line.replace("200", "3000"));
        folder.refuses(&line, "E501", &[needs, "`--max-memory`", "hint: "]);
    }
    for nonsense in ["0", "-5", "much", "4Q", "G", "nan"] {
        folder.refuses(&format!("{line} {nonsense}"), "E101", &[]);
    }
    // Many UAVs whose masks nobody asked for are not held.
    let many = (0..50).map(|k| format!(" --uav {},7,50", 2 + 3 * k)).collect::<String>();
    folder.type_in(&format!("map itu:urban --size 1000{many} -o a.csv -j 1 --max-memory 60M")).done();
    folder.refuses(&format!("map itu:urban --size 1000{many} -o a.npz -j 1 --max-memory 60M"), "E501", &[]);
}

#[test]
fn quiet_says_nothing_but_errors() {
    let folder = scenes();
    let loud = folder.type_in("map dsm.asc --uav 2,2,50 -o a.tif").done();
    assert!(loud.warnings().contains(&"W342"), "{loud:?}");
    assert!(loud.err.contains("UAV 1: P_LoS") && loud.err.contains("method sweep"), "{loud:?}");
    let quiet = folder.type_in("map dsm.asc --uav 2,2,50 -o b.tif -q").done();
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""));
    assert_eq!(folder.type_in("link dsm.asc --uav 2,2,50 --rx 40,40 -q").done().err, "");
    folder.refuses("map dsm.asc -q --uav 2,2 -o c.tif", "E102", &[]);
}

#[test]
fn standard_output_holds_one_document_and_nothing_else() {
    let folder = scenes();
    for (line, schema) in [
        ("map city.geojson --uav 2,2,50 --json", "skyshed/map/1"),
        ("map city.geojson --uav 2,2,50 -o -", "skyshed/map/1"),
        ("map city.geojson --uav 2,2,50 -o - --json -o a.tif", "skyshed/map/1"),
        ("link city.geojson --uav 2,2,50 --rx 40,40 --json", "skyshed/link/1"),
        ("link city.geojson --uav 2,2,50 --rx 40,40 -o -", "skyshed/link/1"),
        ("city city.geojson -o - ", "skyshed/city/1"),
        ("city city.geojson -o b.png --json", "skyshed/city/1"),
        ("info city.geojson --json", "skyshed/info/1"),
    ] {
        assert_eq!(folder.type_in(line).done().json()["schema"], schema, "{line}");
    }
    // The same run writes the same document to a file, but for its own words and times.
    let mut printed = folder.type_in("map city.geojson --uav 2,2,50 -o m.json --json").done().json();
    let mut written = folder.json("m.json");
    for document in [&mut printed, &mut written] {
        let timing = document.as_object_mut().expect("an object").remove("timing_s");
        assert!(timing.is_some_and(|t| t["total"].as_f64().unwrap_or(-1.0) >= 0.0));
    }
    assert_eq!(written, printed);
}

#[test]
fn a_closed_pipe_is_success_and_a_full_disk_is_not() {
    let folder = scenes();
    for words in [&["map", "--help"][..], &["map", "city.geojson", "--uav", "2,2,50", "--json"]] {
        let mut child = program(folder.path(), words).spawn().expect("the program starts");
        drop(child.stdout.take());
        wait(child).done();
    }
    if let Ok(full) = std::fs::File::options().write(true).open("/dev/full") {
        let mut command = program(folder.path(), &["info", "city.geojson"]);
        let answer = wait(command.stdout(full).spawn().expect("the program starts"));
        assert_eq!((answer.code(), answer.error()), (3, "E401"));
    }
}

#[test]
fn an_existing_file_is_replaced_only_with_leave() {
    let folder = scenes();
    for (command, file) in [
        ("map city.geojson --uav 2,2,50", "out.png"),
        ("link city.geojson --uav 2,2,50 --rx 40,40", "link.svg"),
        ("city city.geojson", "copy.geojson"),
    ] {
        folder.write(file, "mine");
        folder.refuses(&format!("{command} -o {file}"), "E106", &[file, "`--overwrite`"]);
        assert_eq!(folder.text(file), "mine");
        folder.type_in(&format!("{command} -o {file} --overwrite")).done();
        assert_ne!(folder.read(file), b"mine");
    }
    // A sidecar is protected like the file it belongs to, and nothing else is written then.
    folder.write("table.csv.json", "mine");
    let before = folder.files();
    folder.refuses("map city.geojson --uav 2,2,50 -o new.tif -o table.csv", "E106", &["table.csv.json"]);
    assert_eq!((folder.files(), folder.text("table.csv.json")), (before, "mine".into()));
}

/// Interrupts a run after a pause: its exit code, what it said, and the processor time that it took to end \[s\].
fn interrupted(folder: &Folder, words: &[&str], pause: Duration) -> (Option<i32>, String, f64) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_skyshed"));
    command.args(words).current_dir(folder.path()).env("RAYON_NUM_THREADS", "1");
    let child = command.stderr(std::process::Stdio::piped()).spawn().expect("the program starts");
    std::thread::sleep(pause);
    let (answer, after) = interrupt("-INT", child);
    (answer.status.code(), answer.err, after)
}

#[test]
fn an_interrupt_ends_with_130_and_leaves_nothing() {
    let folder = Folder::new();
    // Long enough that it cannot be done before the signal.
    let words = ["map", "itu:suburban", "--size", "12000", "--uav", "4500,4500,10", "-o", "out.tif", "-o", "out.png"];
    for pause in [Duration::from_millis(30), Duration::from_millis(700)] {
        let (code, err, until_end) = interrupted(&folder, &words, pause);
        assert!(until_end < 1.0, "{until_end} s");
        // In its first moments, before it listens, the signal itself ends it.
        if code.is_some() || pause > Duration::from_millis(500) {
            assert_eq!(code, Some(130), "after {pause:?}: {err}");
            assert!(err.ends_with("error[E130]: interrupted; nothing was written\n"), "{err}");
        }
        assert_eq!(folder.files(), [""; 0]);
    }
}

/// Pictures and arrays of millions of cells take longer than a second to write.
#[test]
fn an_interrupt_while_files_are_written_is_heard_within_a_second() {
    let folder = Folder::new();
    let words = "map itu:urban --size 3500 --uav 1700,1700,100 -q -o a.npz -o a.png -o a.exr -o a.asc";
    let words: Vec<&str> = words.split_whitespace().collect();
    let start = Instant::now();
    folder.run(&words).done();
    let mut whole = start.elapsed();
    let expected: Vec<(String, Vec<u8>)> = folder.files().into_iter().map(|f| (f.clone(), folder.read(&f))).collect();
    let mut random = Random(5);
    let (mut n_runs, mut n_stopped) = (0, 0);
    // A run that is over before its moment was faster than the first: then moments come earlier.
    while n_runs < if is_long() { 100 } else { 5 } || n_stopped <= n_runs / 4 && n_runs < 200 {
        n_runs += 1;
        folder.remove(&folder.files());
        let share = random.within(0, 1000) as f64 / 1000.0;
        let (code, err, until_end) = interrupted(&folder, &words, whole.mul_f64(share));
        n_stopped += usize::from(code == Some(130));
        if code == Some(0) {
            whole = whole.mul_f64(0.8);
        }
        // In its first moments, before it listens, the signal itself ends it.
        assert!(matches!(code, None | Some(0 | 130)) && until_end < 1.5, "{until_end} s: {err}");
        for file in folder.files() {
            let known = expected.iter().find(|(name, _)| *name == file);
            assert!(known.is_some_and(|(_, bytes)| *bytes == folder.read(&file)), "{file} after {share} of a run");
        }
    }
    assert!(n_stopped > n_runs / 4, "only {n_stopped} of {n_runs} runs were stopped");
}

#[test]
fn an_interrupt_of_a_mask_that_is_written_while_it_is_made_leaves_all_or_nothing() {
    let folder = Folder::new();
    let words =
        ["map", "itu:urban", "--size", "4000", "--uav", "2010,2010,60", "-q", "--tif-layout", "plain", "-o", "out.tif"];
    // The first run may wait for the program to be read, or for other tests.
    let run = |()| {
        folder.remove(&folder.files());
        let start = Instant::now();
        let mut command = Command::new(env!("CARGO_BIN_EXE_skyshed"));
        let status = command.args(words).current_dir(folder.path()).env("RAYON_NUM_THREADS", "1").status();
        assert!(status.expect("the program starts").success());
        start.elapsed()
    };
    let mut whole = [(); 3].map(run).into_iter().min().expect("three runs");
    let expected = (folder.files(), folder.read("out.tif"));
    let (mut n_stopped, mut n_runs) = (0, 0);
    // The file is open in the second half of a run; one that is over before its moment was faster than those before.
    while n_runs < 16 || n_stopped < 4 && n_runs < 100 {
        let k = 8 + n_runs % 16;
        n_runs += 1;
        folder.remove(&folder.files());
        let (code, err, _) = interrupted(&folder, &words, whole * k / 20);
        match code {
            Some(130) => {
                assert_eq!(folder.files(), [""; 0], "after {k} twentieths: {err}");
                n_stopped += 1;
            }
            _ => {
                assert_eq!(code, Some(0), "after {k} twentieths: {err}");
                assert!((folder.files(), folder.read("out.tif")) == expected, "after {k} twentieths");
                if k < 20 {
                    whole = whole.mul_f64(0.8);
                }
            }
        }
    }
    assert!(n_stopped > 3, "only {n_stopped} of {n_runs} runs were stopped");
}

#[test]
fn paths_with_blanks_and_odd_letters_are_kept() {
    let folder = Folder::new();
    folder.write("über see.geojson", FOOTPRINTS);
    let words = ["map", "über see.geojson", "--uav", "2,2,50", "-o", "the map é.tif", "--json"];
    let document = run_in(folder.path(), &words).done().json();
    assert_eq!(document["scene"]["sources"][0]["path"], "über see.geojson");
    assert_eq!(document["command"], json!(words));
    assert!(folder.join("the map é.tif").is_file());
}
