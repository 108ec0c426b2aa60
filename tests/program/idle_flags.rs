//! No flag of any command is taken in silence: with it a run answers something else, or refuses it by name.
//! A new flag is among them as soon as help tells it; what a flag changes is shown in `cli_flags` and where it belongs.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::cli::scenes;
use crate::program::Folder;

/// A line of each command, which its flags are added to.
const BASES: &[&str] = &[
    "map city.geojson --uav 2,2,50 --json -o t.csv",
    "link city.geojson --uav 2,2,50amsl --rx 40,40 --json",
    "track city.geojson --uav 2,2,50 --track walk.csv --json -o t.csv",
    "city city.geojson --json -o c.geojson",
    "info city.geojson --json",
    "zones city.geojson --top-field z_top --ground 10 --json",
    "limits city.geojson --data-area all --uav 2,2,50amsl --json",
    "plos itu:urban --height 100 --distance 50 --method product --json",
    "place city.geojson --height 40,60 --step 20 --json",
    "sample itu:urban --size 200 --zones street:4 --height 60 --json",
    "compare city.geojson --uav 2,2,50 --uav 45,45,30 --json",
    "chart city.geojson --uav 2,2,50 --time 0 --json",
    "stress --scenes 1 --families cell-grazing --json",
    // Flags stand before the map.
    "jobs merge @ map city.geojson --uavs sites.csv --radius 25 -o unit-{site}.csv",
    "completions bash",
];

/// A value of each flag that takes one.
const VALUES: &str = "\
    --terrain slope.asc --ground 5 --building-threshold 4 --height-field tall --top-field z_top --height-unit ft \
    --levels-field tall --base-field tall --parts join --height-error-field tall --roofs lod2 --layer a --missing levels --base highest --data-area all --extent 0,0,48,48 --cell 0.5 \
    --crs EPSG:25832 --project EPSG:25832 --size 210 --seed 5 --nodata-as block --band 2 --repairs mended.csv --tile 20 \
    --uav 30,5,45 --uavs sites.csv --bad-uavs skip --rx 41,40 --rxs sites.csv --stretches parts.csv --track other.csv --every 3 --rx-height 9 --receivers all \
    --radius 25 --earth-k 0.01 --curvature-coefficient 99 --min-radius 15 --sector 20,110 --elevation -80,-50 --beam 50 --slant-range 60 --method ray --tolerance 0.2 --layers los,margin --height-curve curve.csv --curve-heights 10:50:10 --over-time times.csv \
    --output more.json --csv more.csv --threads 1 --max-memory 1G --tif-layout plain --polygons los --simplify 2 \
    --scratch . --title Another_title --attribution Somebody --width 900 --dpi 150 --uav-error 2 --height-error 3 --height-bias 2 --sigma 1 \
    --cities 3 --curve mine=curve_of_mine.csv --theta 30 --distance 60 --phi 10 --height 70 --alpha 0.4 --beta 400 \
    --gamma 12 --users street --placement street --until 0.2 --ci 0.8 --users-per-city 3 --links 300 \
    --positions 20 --theta-band 2 --block 30 --plot heat --step 15 --over street --within part.geojson \
    --keep-out part.geojson --candidates sites.csv --clearance 45 --goal margin --area part.geojson \
    --weights slope.asc --minimize height --count 2 --map best.tif --top 1 --zones crossroad:4 --mask mask.asc \
    --time 0.01 --families cell-slits --scenes 2 --shard 1/2 --tile-size 16";

/// Other values of flags that mean something else to a command.
const OWN_VALUES: &[(&str, &str)] = &[
    ("map", "--tile 0,0 --tile-size 16"),
    ("plos", "--method 3gpp-tr36777-umi"),
    ("stress", "--method xdraw"),
    ("city", "--data-area part.geojson"),
    ("chart", "--theta 40 --height 70"),
];

/// Flags that by their nature change no answer of these runs; other tests show what they do.
const QUIET: &[(&str, &str)] = &[
    ("--threads", "threads_do_not_change_results"),
    ("--max-memory", "no run takes more than was allowed: memory_limits"),
    ("--bad-uavs", "bad_uavs_are_named_left_out_or_lifted"),
    ("--stretches", "several_observers_see_what_one_of_them_sees"),
    ("--overwrite", "an_existing_file_is_replaced_only_with_leave"),
    ("--hash", "a_large_input_is_hashed_on_request"),
    ("--skip-bad", "bad_rows_are_told_together_and_left_out_on_request"),
    ("--csv-text", "names_that_mean_something_to_a_program_reach_none"),
    ("--strips", "maps_strip_by_strip_are_those_in_memory"),
    ("--method", "exact engines agree: engines, agreement"),
    ("--parts", "of a file without any: building_meaning"),
    ("--resume", "what_is_there_is_left_alone"),
    ("--json", "of a run that is asked for it already"),
];

/// What a run left, without what differs between any two runs: words, times, memory.
fn seen(folder: &Folder, line: &str) -> (i32, String, String, BTreeMap<String, Vec<u8>>) {
    let before = folder.files();
    let answer = folder.type_in(line);
    let out = match serde_json::from_str::<Value>(&answer.out) {
        Ok(mut value) => {
            forget(&mut value);
            value.to_string()
        }
        Err(_) => answer.out.clone(),
    };
    let mut written = folder.files();
    written.retain(|name| !before.contains(name));
    let held = |name: &String| {
        let bytes = match name.rsplit('.').next() {
            Some("png") => pixels(&folder.read(name)),
            Some("json" | "geojson") => {
                let mut value = folder.json(name);
                forget(&mut value);
                value.to_string().into_bytes()
            }
            Some("csv") => folder.read(name),
            // Rasters hold the words of their run.
            _ => Vec::new(),
        };
        (name.clone(), bytes)
    };
    let files = written.iter().map(held).collect();
    folder.remove(&written);
    let is_quiet = answer.err.is_empty().to_string();
    (answer.code(), if answer.code() == 0 { out } else { answer.err.clone() }, is_quiet, files)
}

/// What is seen of a PNG, and how large: not the words of its run.
fn pixels(file: &[u8]) -> Vec<u8> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("it fits in memory")];
    reader.next_frame(&mut pixels).expect("a whole PNG");
    let head = format!("{:?} {:?}", reader.info().size(), reader.info().pixel_dims);
    [head.into_bytes(), pixels].concat()
}

fn forget(value: &mut Value) {
    match value {
        Value::Object(object) => {
            object.retain(|name, _| name != "command" && !name.ends_with("_s") && !name.ends_with("_mb"));
            object.values_mut().for_each(forget);
        }
        Value::Array(values) => values.iter_mut().for_each(forget),
        _ => {}
    }
}

#[test]
fn no_flag_of_any_command_is_taken_in_silence() {
    let folder = scenes();
    folder.write("walk.csv", "x,y\n2,40\n40,40\n48,5\n");
    folder.write("other.csv", "x,y\n2,30\n45,35\n");
    folder.write("curve_of_mine.csv", "distance_m,p_los\n0,1\n500,0.1\n");
    folder.write("part.geojson", r#"{"type": "Polygon", "coordinates": [[[0,0],[25,0],[25,50],[0,50],[0,0]]]}"#);
    let mask = "1 ".repeat(20 * 50) + &"0 ".repeat(30 * 50);
    folder.write("mask.asc", &format!("ncols 50\nnrows 50\nxllcorner 0\nyllcorner 0\ncellsize 1\n{mask}\n"));
    folder.type_in("map city.geojson --uavs sites.csv --radius 25 -o unit-{site}.csv -q").done();
    let value_of = |command: &str, flag: &str| {
        let own = OWN_VALUES.iter().filter(|(name, _)| *name == command).map(|(_, words)| *words);
        let mut words = own.chain([VALUES]).flat_map(str::split_whitespace);
        words.find(|word| *word == flag).and_then(|_| words.next())
    };
    let mut silent = Vec::new();
    for &base in BASES {
        let command = base.split(' ').next().expect("a word");
        let draws = ["--title", "--attribution", "--width", "--dpi", "--plot"];
        let flags: Vec<String> = match command {
            "completions" => vec!["--output".into()],
            _ => folder.flags(command),
        };
        let help = folder.type_in(&format!("{command} --help")).out;
        let with = |words: &str| match base.split_once(" @") {
            Some((head, map)) => format!("{head} {words}{map}"),
            None => format!("{base} {words}"),
        };
        let plain = seen(&folder, &with(""));
        assert_eq!(plain.0, 0, "{base}: {}", plain.1);
        let mut drawn = None;
        for flag in flags.iter().filter(|flag| !["--help", "--version"].contains(&flag.as_str())) {
            // A city in vectors has no ground that could be without data.
            let is_drawn = draws.contains(&flag.as_str()) || (command, flag.as_str()) == ("city", "--data-area");
            let value = value_of(command, flag);
            assert!(value.is_some() || !help.contains(&format!("{flag} <")), "{command} {flag}: give it a value above");
            let line = format!("{flag} {}", value.unwrap_or_default());
            let without = if is_drawn {
                drawn.get_or_insert_with(|| seen(&folder, &with("-o drawn.png"))).clone()
            } else {
                plain.clone()
            };
            let drawing = if is_drawn { "-o drawn.png " } else { "" };
            let line = format!("{drawing}{line}");
            let found = seen(&folder, &with(&line));
            let is_refused = found.0 != 0 && found.0 != 1;
            let is_quiet = QUIET.iter().any(|(name, _)| name == flag);
            if !is_refused && found == without && !is_quiet {
                silent.push(with(&line));
            }
            if is_refused {
                assert!(found.1.starts_with("error[E"), "{base} {line}: {}", found.1);
            }
        }
    }
    assert!(silent.is_empty(), "flags that changed nothing:\n{}", silent.join("\n"));
}
