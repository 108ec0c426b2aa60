//! The program from outside: what it says where, its exit codes, and that every flag changes what it does.

use std::io::Read;
use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::figures::words;
use crate::program::{Folder, program, run_in, wait};
use crate::support::{Random, slow};

/// Three buildings without heights, with storeys, and with everything; tops measured from the datum too.
const FOOTPRINTS: &str = r#"{"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": {"height": 20, "tall": 35, "z_top": 18},
   "geometry": {"type": "Polygon", "coordinates": [[[20,20],[30,20],[30,30],[20,30],[20,20]]]}},
  {"type": "Feature", "properties": {"height": 12, "tall": 5, "z_top": 30},
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
    object.remove("timing_s");
    document
}

/// A refusal: a command line, its exit code and how its first line begins.
type Refusal = (&'static str, i32, &'static str);

#[test]
fn what_makes_no_sense_is_refused_with_its_own_exit_code_and_leaves_nothing() {
    let folder = scenes();
    let before = folder.files();
    let small = "map itu:urban --size 200 -o out.png";
    let refusals: Vec<Refusal> = vec![
        ("", 2, "error[E101]: no command, wanted one such as `map`, `link`, `info`, `plos` or `place`"),
        ("mapp", 2, "error[E101]: unrecognized subcommand 'mapp'"),
        ("map", 2, "error[E101]: the following required arguments were not provided: <SCENE>"),
        ("map itu:urban --no-such-flag", 2, "error[E101]: unexpected argument '--no-such-flag' found"),
        ("map itu:urban -o out.png", 2, "error[E108]: no UAV: wanted `--uav X,Y,H` or `--uavs FILE`"),
        // Numbers.
        ("SMALL --uav 10,10", 2, "error[E102]: cannot read `--uav 10,10`: found 2 values, wanted X,Y,H"),
        ("SMALL --uav 10,10,9,9", 2, "error[E102]: cannot read `--uav 10,10,9,9`: found 4 values, wanted X,Y,H"),
        ("SMALL --uav ,,", 2, "error[E102]: cannot read `--uav ,,`: x: found ``, which is not a number"),
        ("SMALL --uav nan,10,50", 2, "error[E102]: cannot read `--uav nan,10,50`: x: found `NaN`, which is not finite"),
        ("SMALL --uav 10,-inf,50", 2, "error[E102]: cannot read `--uav 10,-inf,50`: y: found `-inf`, which is not"),
        ("SMALL --uav 10,10,1e400", 2, "error[E102]: cannot read `--uav 10,10,1e400`: height `1e400`: found `inf`"),
        ("SMALL --uav 10,10,50yd", 2, "error[E102]: cannot read `--uav 10,10,50yd`: height `50yd`: found `50yd`"),
        ("SMALL --uav 10,10,50 --rx-height -1", 2, "error[E113]: the receivers' height is `-1`, wanted 0 m to 32768 m"),
        ("SMALL --uav 10,10,50 --rx-height nan", 2, "error[E101]: invalid value 'nan' for '--rx-height <M>'"),
        ("SMALL --uav 10,10,50 --radius 0", 2, "error[E113]: the radius is `0`, wanted above 0 m"),
        ("SMALL --uav 10,10,50 --radius -1", 2, "error[E113]: the radius is `-1`, wanted above 0 m"),
        ("SMALL --uav 10,10,50 --radius NaN", 2, "error[E101]: invalid value 'NaN' for '--radius <M>'"),
        (
            "SMALL --uav 10,10,50 --cell 0",
            2,
            "error[E112]: cannot generate a city: the cell size is `0`, wanted above 0 m",
        ),
        ("map city.geojson --uav 1,1,50 -o out.png --cell -2", 2, "error[E112]: `--cell` is `-2`, wanted above 0 m"),
        ("map itu:urban --uav 1,1,50 -o out.png --size NaN", 2, "error[E101]: invalid value 'NaN' for '--size <M>'"),
        ("map itu:urban --uav 1,1,50 -o out.png --size -9", 2, "error[E112]: cannot generate a city: the size is `-9`"),
        ("map itu:1.5,500,15 --uav 1,1,50 -o out.png", 2, "error[E110]: cannot generate a city: α (built-up ratio) is"),
        ("map itu:0.3,500 --uav 1,1,50 -o out.png", 2, "error[E111]: cannot read scene `itu:0.3,500`: found `0.3,500`"),
        ("map itu:0.3,500,nan --uav 1,1,50 -o out.png", 2, "error[E110]: cannot generate a city: γ (height scale) is"),
        ("map itu:ruburban --uav 1,1,50 -o out.png", 2, "error[E111]: cannot read scene `itu:ruburban`"),
        ("map city.geojson --uav 1,1,50 -o out.png --extent 1,2,3", 2, "error[E101]: invalid value '1,2,3' for"),
        ("map city.geojson --uav 1,1,50 -o out.png --extent 1,2,3,inf", 2, "error[E101]: invalid value '1,2,3,inf'"),
        (
            "map city.geojson --uav 1,1,50 -o out.png --extent 9,0,1,9",
            2,
            "error[E114]: `--extent` is `9,0,1,9`, wanted",
        ),
        (
            "map dsm.asc --ground 99999 --uav 1,1,50 -o out.png",
            2,
            "error[E113]: `--ground` is `99999`, wanted a height",
        ),
        ("map dsm.asc --ground 0 --building-threshold -1 --uav 1,1,50 -o out.png", 2, "error[E113]: `--building-thres"),
        ("map dsm.asc --crs EPSG:1 --uav 1,1,50 -o out.png", 2, "error[E115]: `--crs`: "),
        ("SMALL --uav 10,10,50 -j 0", 2, "error[E101]: invalid value '0' for '--threads <N>'"),
        ("SMALL --uav 10,10,50 --seed -1", 2, "error[E101]: "),
        ("SMALL --uav 10,10,50 --method guess", 2, "error[E101]: invalid value 'guess' for '--method <METHOD>'"),
        ("SMALL --uav 10,10,50 --layers los,shade", 2, "error[E101]: invalid value 'shade' for '--layers <LAYER,…>'"),
        ("SMALL --uav 10,10,50 --receivers sky", 2, "error[E101]: invalid value 'sky' for '--receivers <WHERE>'"),
        // Flags that the scene or the outputs cannot use.
        ("SMALL --uav 10,10,50 --terrain slope.asc", 2, "error[E116]: `--terrain` has no meaning for a generated city"),
        ("SMALL --uav 10,10,50 --missing fail", 2, "error[E116]: `--missing` has no meaning for a generated city"),
        ("map dsm.asc --uav 1,1,50 -o out.png --cell 2", 2, "error[E116]: `--cell` has no meaning for a raster"),
        (
            "map dsm.asc --uav 1,1,50 -o out.png --top-field z",
            2,
            "error[E116]: `--top-field` has no meaning for a raster",
        ),
        ("map dsm.asc --uav 1,1,50 -o out.png --building-threshold 1", 2, "error[E116]: `--building-threshold` has no"),
        ("map city.geojson --uav 1,1,50 -o out.png --size 9", 2, "error[E116]: `--size` has no meaning for footprints"),
        (
            "map city.geojson --uav 1,1,50 -o out.png --nodata-as block",
            2,
            "error[E116]: `--nodata-as` has no meaning for",
        ),
        ("map city.geojson --uav 1,1,50 -o out.png --top-field z --height-field h", 2, "error[E101]: the argument"),
        ("map dsm.asc --uav 1,1,50 -o out.png --ground 0 --terrain slope.asc", 2, "error[E101]: the argument"),
        ("map dsm.asc --uav 1,1,50 -o out.png --receivers roof", 2, "error[E117]: receivers `roof` with a surface"),
        ("map dsm.asc --uav 1,1,50 -o out.tif --bare", 2, "error[E116]: `--bare` has no meaning without a .png output"),
        ("SMALL --uav 10,10,50 --tif-layout plain", 2, "error[E116]: `--tif-layout` has no meaning without a .tif out"),
        ("SMALL --uav 10,10,50 --tif-layout strips", 2, "error[E101]: invalid value 'strips' for '--tif-layout"),
        // Outputs.
        ("map itu:urban --uav 10,10,50 -o out.xyz", 2, "error[E104]: cannot write out.xyz: unknown extension `.xyz`"),
        (
            "map itu:urban --uav 10,10,50 -o nowhere/out.png",
            3,
            "error[E401]: cannot write nowhere/out.png: folder nowhere",
        ),
        (
            "map itu:urban --uav 10,10,50 -o out.png -o out.png",
            2,
            "error[E105]: cannot write out.png: it is named twice",
        ),
        ("map dsm.asc --uav 1,1,50 -o dsm.asc --overwrite", 2, "error[E105]: cannot write dsm.asc: it is an input of"),
        (
            "map dsm.asc --uavs sites.csv -o sites.csv --overwrite",
            2,
            "error[E105]: cannot write sites.csv: it is an input",
        ),
        (
            "map dsm.asc --terrain slope.asc --uav 1,1,50 -o slope.asc --overwrite",
            2,
            "error[E105]: cannot write slope.asc",
        ),
        (
            "link itu:urban --uav 10,10,50 --rx 20,10 -o out.tif",
            2,
            "error[E105]: cannot write out.tif: this command does",
        ),
        ("city dsm.asc -o out.geojson", 2, "error[E109]: cannot write out.geojson: a raster scene has no footprints"),
        (
            "map itu:urban --uav 10,10,50 --uav 10,10,60 -o out.asc",
            2,
            "error[E107]: cannot write out.asc: an ASCII grid",
        ),
        // Input files.
        ("map nowhere.tif --uav 10,10,50 -o out.png", 3, "error[E301]: cannot read nowhere.tif: no such file"),
        ("map nowhere.geojson --uav 10,10,50 -o out.png", 3, "error[E301]: cannot read nowhere.geojson: "),
        ("map city.shp --uav 10,10,50 -o out.png", 3, "error[E301]: cannot read city.shp: "),
        ("SMALL --uavs nowhere.csv", 3, "error[E301]: cannot read nowhere.csv: "),
        // Sites.
        (
            "SMALL --uav 30,30,1",
            4,
            "error[E201]: cannot place UAV `1` at (30, 30) with height 1agl: 1 m above the datum is",
        ),
        (
            "SMALL --uav 10,10,-5",
            4,
            "error[E202]: cannot place UAV `1` at (10, 10) with height -5agl: -5 m above the datum",
        ),
        (
            "map dsm.asc --ground 5 --uav 1,1,4amsl -o out.png",
            4,
            "error[E202]: cannot place UAV `1` at (1, 1) with height",
        ),
        (
            "SMALL --uav 1e6,10,50",
            4,
            "error[E203]: cannot place UAV `1` at (1000000, 10) with height 50agl: with the cells",
        ),
        ("map dsm.asc --uav 11,12.5,9 -o out.png", 4, "error[E204]: cannot place UAV `1` at (11, 12.5) with"),
        (
            "SMALL --uav 10,10,30roof",
            4,
            "error[E204]: cannot place UAV `1` at (10, 10) with height 30roof: no building is",
        ),
        (
            "map dsm.asc --uav 25,25,9roof -o out.png",
            4,
            "error[E204]: cannot place UAV `1` at (25, 25) with height 9roof",
        ),
        ("SMALL --uav 10,10,40000", 4, "error[E205]: cannot place UAV `1` at (10, 10) with height 40000agl: 40000 m"),
        ("link itu:urban --uav 10,10,50 --rx 30,30,1", 4, "error[E201]: cannot place the receiver at (30, 30) with"),
        // Limits.
        ("map itu:urban --size 70000 --uav 10,10,50 -o out.png", 5, "error[E502]: cannot generate a city: the size is"),
        (
            "map itu:urban --cell 0.001 --uav 10,10,50 -o out.png",
            5,
            "error[E502]: cannot generate a city: 1000000 cells",
        ),
        ("map city.geojson --extent 0,0,1e6,1e6 --uav 1,1,50 -o out.png", 5, "error[E502]: cannot map city.geojson"),
        (
            "map city.geojson --extent 0,0,40000,40000 --uav 1,1,50 -o out.png",
            5,
            "error[E501]: cannot map city.geojson: 40000×",
        ),
    ];
    for (line, code, first) in refusals {
        // Only there has every run little memory.
        if first.starts_with("error[E501]") && !cfg!(target_os = "linux") {
            continue;
        }
        let line = line.replace("SMALL", small);
        let answer = folder.type_in(&line);
        let lines = answer.refused(code);
        assert!(lines[0].starts_with(first), "{line}: {lines:?}, wanted {first}");
        assert!(lines.iter().skip(1).all(|line| line.starts_with("hint: ")), "{line}: {lines:?}");
        assert_eq!(folder.files(), before, "{line}");
    }
}

#[test]
fn an_inside_uav_is_told_what_to_ask_for_instead() {
    let folder = scenes();
    let answer = folder.type_in("map city.geojson --uav 25,25,5 -o out.png");
    assert_eq!(
        answer.refused(4),
        [
            "error[E201]: cannot place UAV `1` at (25, 25) with height 5agl: 5 m above the datum is inside a building \
             with its roof at 20 m",
            "hint: the lowest height in the clear is `20agl`; `5roof` hovers at 25 m, 5 m above the roof",
        ]
    );
    for height in ["20agl", "5roof", "20amsl", "0roof"] {
        folder.type_in(&format!("map city.geojson --uav 25,25,{height} --json")).done();
    }
    let below = folder.type_in("map city.geojson --uav 25,25,-5 --json");
    assert_eq!(below.refused(4)[1], "hint: the lowest height in the clear is `20agl`");
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
            let refused = folder.type_in(&format!("map {scene} --method {wrong} --json"));
            let lines = refused.refused(2);
            assert!(lines[0].starts_with("error[E118]") && lines[1].contains(auto), "{lines:?}");
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
    for (limit, words) in [
        ("300K", "cannot start: the program alone takes "),
        ("20M", "cannot map itu:urban: its buildings and cells need "),
    ] {
        let refused = folder.type_in(&format!("{} {limit}", line.replace("200", "3000")));
        let lines = refused.refused(5);
        assert!(lines[0].starts_with(&format!("error[E501]: {words}")), "{lines:?}");
        assert!(lines[0].contains("`--max-memory`") && lines[1].starts_with("hint: allow more"), "{lines:?}");
    }
    for nonsense in ["0", "-5", "much", "4Q", "G", "nan"] {
        assert!(folder.type_in(&format!("{line} {nonsense}")).refused(2)[0].contains("wanted a size"), "{nonsense}");
    }
    // Many UAVs whose masks nobody asked for are not held.
    let many = (0..50).map(|k| format!(" --uav {},7,50", 2 + 3 * k)).collect::<String>();
    folder.type_in(&format!("map itu:urban --size 1000{many} -o a.csv -j 1 --max-memory 60M")).done();
    folder.type_in(&format!("map itu:urban --size 1000{many} -o a.npz -j 1 --max-memory 60M")).refused(5);
}

#[test]
fn quiet_says_nothing_but_errors() {
    let folder = scenes();
    let loud = folder.type_in("map dsm.asc --uav 2,2,50 -o a.tif").done();
    assert!(
        loud.err.contains("warning[W342]") && loud.err.contains("UAV 1: P_LoS") && loud.err.contains("method sweep")
    );
    let quiet = folder.type_in("map dsm.asc --uav 2,2,50 -o b.tif -q").done();
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""));
    assert_eq!(folder.type_in("link dsm.asc --uav 2,2,50 --rx 40,40 -q").done().err, "");
    assert!(!folder.type_in("map dsm.asc -q --uav 2,2 -o c.tif").refused(2).is_empty());
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
    let mut command = program(folder.path(), &["map", "--help"]);
    let mut child = command.spawn().expect("the program starts");
    drop(child.stdout.take());
    assert_eq!(wait(child).code(), 0);
    let mut child =
        program(folder.path(), &["map", "city.geojson", "--uav", "2,2,50", "--json"]).spawn().expect("starts");
    drop(child.stdout.take());
    assert_eq!(wait(child).code(), 0);
    if let Ok(full) = std::fs::File::options().write(true).open("/dev/full") {
        let mut command = program(folder.path(), &["info", "city.geojson"]);
        let answer = wait(command.stdout(full).spawn().expect("the program starts"));
        assert_eq!(answer.code(), 3);
        assert!(
            answer.err.lines().last().is_some_and(|l| l.starts_with("error[E401]: cannot write to standard")),
            "{answer:?}"
        );
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
        let answer = folder.type_in(&format!("{command} -o {file}"));
        let wanted = [format!("error[E106]: cannot write {file}: it exists"), "hint: `--overwrite` replaces it".into()];
        assert_eq!(answer.refused(2), wanted);
        assert_eq!(folder.text(file), "mine");
        folder.type_in(&format!("{command} -o {file} --overwrite")).done();
        assert_ne!(folder.read(file), b"mine");
    }
    // A sidecar is protected like the file it belongs to, and nothing else is written then.
    folder.write("table.csv.json", "mine");
    folder.type_in("map city.geojson --uav 2,2,50 -o new.tif -o table.csv").refused(2);
    assert!(!folder.files().iter().any(|f| f.starts_with("new") || f == "table.csv" || f.ends_with(".part")));
    assert_eq!(folder.text("table.csv.json"), "mine");
}

/// Interrupts a run after a pause: its exit code, what it said, and how long it took to end.
fn interrupted(folder: &Folder, words: &[&str], pause: Duration) -> (Option<i32>, String, Duration) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_skyshed"));
    command.args(words).current_dir(folder.path()).env("RAYON_NUM_THREADS", "1");
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().expect("the program starts");
    std::thread::sleep(pause);
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("`kill` runs");
    assert!(kill.success());
    let start = Instant::now();
    let mut err = String::new();
    child.stderr.take().expect("piped").read_to_string(&mut err).expect("text");
    (child.wait().expect("it ends").code(), err, start.elapsed())
}

#[test]
fn an_interrupt_ends_with_130_and_leaves_nothing() {
    let folder = Folder::new();
    // Long enough that it cannot be done before the signal.
    let words = ["map", "itu:suburban", "--size", "12000", "--uav", "4500,4500,10", "-o", "out.tif", "-o", "out.png"];
    for pause in [Duration::from_millis(30), Duration::from_millis(700)] {
        let (code, err, until_end) = interrupted(&folder, &words, pause);
        assert!(until_end < Duration::from_secs(2), "{until_end:?}");
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
    let whole = start.elapsed();
    let expected: Vec<(String, Vec<u8>)> = folder.files().into_iter().map(|f| (f.clone(), folder.read(&f))).collect();
    let mut random = Random(5);
    let (n_runs, mut n_stopped) = (if slow() { 100 } else { 8 }, 0);
    for _ in 0..n_runs {
        folder.files().iter().for_each(|file| std::fs::remove_file(folder.join(file)).expect("it is there"));
        let share = random.within(0, 1000) as f64 / 1000.0;
        let (code, err, until_end) = interrupted(&folder, &words, whole.mul_f64(share));
        n_stopped += usize::from(code == Some(130));
        assert!(matches!(code, Some(0 | 130)) && until_end < Duration::from_millis(1500), "{until_end:?}: {err}");
        for file in folder.files() {
            let known = expected.iter().find(|(name, _)| *name == file);
            assert!(known.is_some_and(|(_, bytes)| *bytes == folder.read(&file)), "{file} after {share} of a run");
        }
    }
    assert!(n_stopped > n_runs / 4, "only {n_stopped} runs were stopped");
}

#[test]
fn an_interrupt_of_a_mask_that_is_written_while_it_is_made_leaves_all_or_nothing() {
    let folder = Folder::new();
    let words =
        ["map", "itu:urban", "--size", "4000", "--uav", "2010,2010,60", "-q", "--tif-layout", "plain", "-o", "out.tif"];
    let empty = || folder.files().iter().for_each(|file| std::fs::remove_file(folder.join(file)).expect("it is there"));
    // The first run may wait for the program to be read, or for other tests.
    let run = |()| {
        empty();
        let start = Instant::now();
        let mut command = Command::new(env!("CARGO_BIN_EXE_skyshed"));
        let status = command.args(words).current_dir(folder.path()).env("RAYON_NUM_THREADS", "1").status();
        assert!(status.expect("the program starts").success());
        start.elapsed()
    };
    let whole = [(); 3].map(run).into_iter().min().expect("three runs");
    let expected = (folder.files(), folder.read("out.tif"));
    let mut n_stopped = 0;
    // The file is open in the second half of a run.
    for k in 8..24 {
        empty();
        let (code, err, _) = interrupted(&folder, &words, whole * k / 20);
        match code {
            Some(130) => {
                assert_eq!(folder.files(), [""; 0], "after {k} twentieths: {err}");
                n_stopped += 1;
            }
            _ => {
                assert_eq!(code, Some(0), "after {k} twentieths: {err}");
                assert!((folder.files(), folder.read("out.tif")) == expected, "after {k} twentieths");
            }
        }
    }
    assert!(n_stopped > 3, "only {n_stopped} runs were stopped");
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
