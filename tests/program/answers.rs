//! What a run says, whatever the command: its answer, the files that it wrote, one form for what is wrong.

use std::collections::BTreeSet;

use crate::cli::scenes;
use crate::program::{Answer, Folder};

/// A short run of every command, without `-o`.
const COMMANDS: [&str; 12] = [
    "map city.geojson --uav 2,2,50",
    "map dsm.asc --ground 0 --uavs sites.csv",
    "link city.geojson --uav 2,2,50 --rx 40,40",
    "track city.geojson --uav 2,2,50 --track walk.csv",
    "city city.geojson",
    "info city.geojson",
    "plos itu:urban --theta 30,60",
    "compare city.geojson --uav 2,2,50 --uav 40,40,50",
    "place city.geojson --height 40,60 --step 10 --top 3",
    "sample itu:urban --size 200 --height 60 --radius 50 --zones street:2",
    "stress --scenes 1 --families cell-slits",
    "chart itu:urban --size 60 --uav 30,30,100 --time 0",
];

pub(crate) fn folder() -> Folder {
    let folder = scenes();
    folder.write("walk.csv", "x,y\n2,2\n2,48\n48,48\n");
    folder
}

/// The files that a run says it wrote, in its order.
fn named(answer: &Answer) -> Vec<String> {
    let lines = answer.err.lines().filter_map(|line| line.strip_prefix("wrote "));
    lines.flat_map(|files| files.split(", ")).map(str::to_string).collect()
}

#[test]
fn a_run_without_files_prints_its_answer() {
    let folder = folder();
    for line in COMMANDS {
        let before = folder.files();
        let answer = folder.type_in(line).done();
        assert!(!answer.out.trim().is_empty() && named(&answer).is_empty(), "{line}: {answer:?}");
        assert!(!answer.out.contains("warning[") && !answer.out.contains("method "), "{line}: {answer:?}");
        // With less said the answer is the same, but for times.
        let quiet = folder.type_in(&format!("{line} -q")).done();
        assert!(quiet.err.is_empty() && quiet.out.lines().count() == answer.out.lines().count(), "{line}: {quiet:?}");
        assert_eq!(folder.files(), before, "{line}");
    }
    // Where there is a table, the answer is that table.
    let has_table = |line: &&str| ["map", "plos", "compare"].contains(&line.split(' ').next().unwrap());
    // A raster that does not fit in memory is no exception.
    let strips = "map dsm.asc --ground 0 --uav 2,2,50 --strips";
    for line in COMMANDS.into_iter().filter(has_table).chain([strips]) {
        folder.type_in(&format!("{line} -o table.csv --overwrite -q")).done();
        assert_eq!(folder.type_in(line).out, folder.text("table.csv"), "{line}");
    }
    // Of many candidates the best are printed.
    let line = "place city.geojson --height 40 --step 5 --top 3 -k 2";
    folder.type_in(&format!("{line} -o table.csv --overwrite -q")).done();
    let (printed, table) = (folder.type_in(line).out, folder.text("table.csv"));
    let ranks = |text: &str| text.lines().filter(|row| row.starts_with("candidate,")).count();
    assert!(ranks(&printed) == 3 && ranks(&table) > 3 && printed.contains("\nchosen,"), "{printed}");
    let mut rows = table.lines();
    assert!(printed.lines().all(|row| rows.any(|other| other == row)), "{printed}");
}

#[test]
fn every_file_written_is_named_once() {
    let folder = folder();
    for line in [
        "map city.geojson --uav 2,2,50 --uav 40,40,50 --crs EPSG:25832 --bare -o a.png -o a.csv -o a.npz",
        "map city.geojson --uav 2,2,50 -o b.tif -o b.asc -o b.bil -o b.json --height-curve b_curve.csv",
        "map city.geojson --uav 2,2,50 --uav 40,40,50 -o c{site}.csv -o c{site}.tif",
        "map dsm.asc --ground 0 --uav 2,2,50 --strips -o s.tif -o s.csv",
        "map dsm.asc --ground 0 --uav 2,2,50 --tif-layout plain -o p.tif",
        "link city.geojson --uav 2,2,50 --rx 40,40 -o l.png -o l.json",
        "track city.geojson --uav 2,2,50 --track walk.csv -o t.csv -o t.svg",
        "city city.geojson -o d.xml -o d.csv -o d.tif",
        "zones city.geojson -o z.png -o z.json --repairs r.csv",
        "info dsm.asc --ground 0 --tile 25 -o tiles.csv",
        "info sites.csv -o sites.json",
        "plos itu:urban --theta 30 -o q.csv -o q.png --csv q2.csv",
        "compare city.geojson --uav 2,2,50 --uav 40,40,50 -o e.html -o e.tif -o e.csv",
        "place city.geojson --height 40 --step 10 -o f.csv -o f.geojson --map f_map.png",
        "sample itu:urban --size 200 --height 60 --radius 50 --zones street:2 -o g.csv",
        "stress --scenes 1 --families cell-slits -o h.csv -o h.svg",
        "stress city.geojson --uav 2,2,50 -o i.csv",
        "chart itu:urban --size 60 --uav 30,30,100 --time 0 -o j.csv -o j.svg",
        "chart itu:urban --plos --time 0 -o k.csv",
    ] {
        let before: BTreeSet<String> = folder.files().into_iter().collect();
        let answer = folder.type_in(line).done();
        let written: Vec<String> = folder.files().into_iter().filter(|file| !before.contains(file)).collect();
        let mut named = named(&answer);
        named.sort();
        assert_eq!(named, written, "{line}: {answer:?}");
        assert!(written.len() > 1 || line.contains("plain") || line.contains("info sites"), "{line}: {written:?}");
    }
}

#[test]
fn folders_that_cannot_be_written_are_found_before_the_work() {
    let folder = folder();
    let before = folder.files();
    // The scene does not exist, which would be found by the work.
    for (command, extension) in [
        ("map nowhere.tif --uav 2,2,50", "png"),
        ("map nowhere.tif --uav 2,2,50 --height-curve", "csv"),
        ("map nowhere.tif --uav 2,2,50", "{site}.png"),
        ("link nowhere.tif --uav 2,2,50 --rx 3,3", "json"),
        ("city nowhere.tif", "png"),
        ("info nowhere.geojson --repairs", "csv"),
        ("plos nowhere.tif --csv", "csv"),
        ("compare nowhere.tif --uav 2,2,50 --uav 3,3,50", "html"),
        ("place nowhere.tif --height 50 --map", "png"),
        ("stress nowhere.tif --uav 2,2,50", "csv"),
        ("chart nowhere.tif --uav 2,2,50", "svg"),
    ] {
        let flag = if command.split(' ').next_back().is_some_and(|word| word.starts_with("--")) { "" } else { "-o" };
        for (place, why) in [("none", "does not exist"), ("sites.csv", "is a file"), ("/proc", "cannot be written: ")] {
            if place == "/proc" && !cfg!(target_os = "linux") {
                continue;
            }
            let line = format!("{command} {flag} {place}/out.{extension}");
            folder.refuses(&line, "E401", &[&format!("{place}/out."), &format!("folder {place} {why}")]);
        }
    }
    assert_eq!(folder.files(), before);
}

#[test]
#[cfg(target_os = "linux")]
fn a_disk_that_refuses_bytes_is_told_as_such() {
    let folder = folder();
    let before = folder.files();
    for file in ["out.png", "out.tif", "out.json", "out.npz"] {
        // No file may grow beyond a block of 512 bytes.
        let words = ["map", "city.geojson", "--uav", "2,2,50", "-o", file];
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_skyshed")]).args(words);
        let output = shell.current_dir(folder.path()).output().expect("a shell");
        let err = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(3) && err.contains("error[E401]"), "{file}: {err}");
        assert_eq!(folder.files(), before, "{file}");
    }
}

#[test]
fn what_was_found_is_quoted_within_bounds() {
    let folder = folder();
    let positions: Vec<String> = (0..50_000).map(|k| format!("[{k},1]")).collect();
    folder.write("city.txt", &format!("ncols{{\"type\":\"MultiPoint\",\"coordinates\":[{}]}}", positions.join(",")));
    folder.write("points.txt", &format!("{{\"type\":\"MultiPoint\",\"coordinates\":[{}]}}", positions.join(",")));
    folder.write("word.asc", &format!("ncols {}", "9".repeat(100_000)));
    folder.write("s.csv", &format!("x,y,h\n1,\x1b[31m{},3\n", "y".repeat(100_000)));
    let far = format!("map city.geojson --uav {},2,3", "1".repeat(1000) + "x");
    let receivers = format!("map city.geojson --uav 2,2,50 --receivers {}", "r".repeat(1000));
    for line in [
        "map city.txt --uav 2,2,50",
        "info city.txt",
        "map points.txt --uav 2,2,50",
        "map city.geojson --uavs points.txt",
        "track city.geojson --uav 2,2,50 --track points.txt",
        "plos itu:urban --curve c=points.txt",
        "map word.asc --uav 2,2,50",
        "map city.geojson --uavs s.csv",
        &far,
        &receivers,
    ] {
        let answer = folder.type_in(line);
        assert!(answer.code() == 2 || answer.code() == 3, "{line}: {answer:?}");
        assert!(answer.err.chars().count() < 1200 && !answer.err.contains('\x1b'), "{line}: {}", answer.err.len());
    }
    folder.refuses(&receivers, "E101", &[" … (1000 characters) … "]);
    folder.refuses("map city.geojson --uavs s.csv", "E302", &[r"`\u{1b}[31myyy", " … (100005 characters) … "]);
}

#[test]
fn hints_list_what_the_command_writes_and_nothing_else() {
    let folder = folder();
    for line in COMMANDS {
        let answer = folder.type_in(&format!("{line} -o out.xyz"));
        let lines = answer.refused(2);
        assert_eq!(answer.error(), "E104", "{lines:?}");
        let listed = lines[1].strip_prefix("hint: wanted ").expect("a hint that lists them");
        let (files, stream) = listed.split_once(", and ").expect("files, and a stream");
        assert_eq!(stream, "`-` for standard output");
        for extension in files.split(' ') {
            let answer = folder.type_in(&format!("{line} -o listed{extension} --overwrite"));
            // Some need another flag, which they name.
            let needs = ["hint: `--", "E109", "it holds polygons"];
            let is_made = answer.code() == 0 || needs.iter().any(|words| answer.err.contains(words));
            assert!(is_made && !answer.err.contains("E104"), "{line} {extension}: {answer:?}");
        }
        for other in [".png", ".kmz", ".npz", ".html", ".xml", ".exr", ".fgb", ".csv", ".geojson"] {
            if !files.split(' ').any(|extension| extension == other) {
                let answer = folder.type_in(&format!("{line} -o other{other}"));
                assert_eq!(answer.refused(2)[1], lines[1], "{line} {other}");
            }
        }
    }
    folder.refuses("map city.geojson --uav 2,2,50 --resume", "E116", &["`--resume`"]);
    for (line, code, wanted) in [
        ("map city.geojson --uav 2,2,50 --height-curve c.tif", "E105", "wanted .png .svg .pdf .csv .json\n"),
        ("place city.geojson --height 50 --map m.xyz", "E105", "wanted .png, .svg, .pdf or .tif\n"),
        ("info city.geojson --repairs r.xyz", "E104", "wanted .csv .geojson\n"),
    ] {
        folder.refuses(line, code, &[wanted]);
    }
}

#[test]
fn a_scene_that_is_no_file_may_be_a_built_up_one() {
    let folder = folder();
    for word in ["urban", "suburban", "dense-urban", "high-rise", "ghent", "0.3,500,15"] {
        for line in
            [format!("map {word} --uav 2,2,50 -o a.png"), format!("info {word}"), format!("plos itu:urban {word}")]
        {
            folder.refuses(&line, "E301", &[word, &format!("hint: `itu:{word}`")]);
        }
    }
    for (line, near) in [
        ("map cyti.geojson --uav 2,2,50", "city.geojson"),
        ("map City.GeoJSON --uav 2,2,50", "city.geojson"),
        ("info dem.asc", "dsm.asc"),
        ("map city.geojson --terrain slop.asc --uav 2,2,50", "slope.asc"),
        ("map city.geojson --uavs sites.txt", "sites.csv"),
        ("track city.geojson --uav 2,2,50 --track ./walks.csv", "./walk.csv"),
    ] {
        // Where names are the same in either case, the file is there.
        if !folder.join("CITY.geojson").exists() || !line.contains("City") {
            folder.refuses(line, "E301", &[&format!("hint: did you mean {near}?")]);
        }
    }
    assert_eq!(folder.type_in("info elsewhere.tif").refused(3).len(), 1);
}

#[test]
fn missing_files_are_told_in_one_form() {
    let folder = folder();
    for (line, file) in [
        ("map {} --uav 2,2,50", "n.tif"),
        ("map {} --uav 2,2,50", "n.asc"),
        ("map {} --uav 2,2,50", "n.vrt"),
        ("map {} --uav 2,2,50", "n.geojson"),
        ("map {} --uav 2,2,50", "n.shp"),
        ("map {} --uav 2,2,50", "n.fgb"),
        ("map {} --uav 2,2,50", "n.gpkg"),
        ("map {} --uav 2,2,50", "n.city.json"),
        ("map {} --uav 2,2,50", "n.obj"),
        ("map {} --uav 2,2,50", "n.ply"),
        ("map {} --uav 2,2,50 -o {site}.tif", "n.tif"),
        ("map city.geojson --uav 2,2,50 --terrain {}", "n.asc"),
        ("map city.geojson --uavs {}", "n.csv"),
        ("map city.geojson --uavs {}", "n.json"),
        ("compare city.geojson --mask {} --mask {}", "n.tif"),
        ("track city.geojson --uav 2,2,50 --track {}", "n.csv"),
        ("place city.geojson --candidates {}", "n.csv"),
        ("place city.geojson --height 50 --within {}", "n.geojson"),
        ("place city.geojson --height 50 --goal p_los(weights) --weights {}", "n.tif"),
        ("plos itu:urban --theta 45 --curve n={}", "n.csv"),
        ("info {}", "n.csv"),
        ("stress {} --uav 2,2,50", "n.tif"),
        ("chart {} --uav 2,2,50", "n.tif"),
        ("city {}", "n.geojson"),
    ] {
        for (path, cause) in
            [(file.to_string(), "no such file"), (format!("sites.csv/{file}"), "not a directory"), (".".into(), "")]
        {
            if path == "." && (line.starts_with("info") || !line.contains("geojson") || line.contains("--terrain")) {
                continue;
            }
            let line = line.replace("{}", &path);
            let answer = folder.type_in(&line);
            assert!(!answer.refused(3)[0].contains("os error"), "{line}: {answer:?}");
            if path != "." {
                folder.refuses(&line, "E301", &[&format!("{path}: {cause}")]);
            }
        }
    }
}

#[test]
fn warnings_of_a_batch_are_said_once() {
    let folder = folder();
    // Each run warns that receivers stand on the surface, and of the void cells.
    let line = "map dsm.asc --uav 2,2,50 --uav 40,40,50 --uav 45,2,50 -o {site}.json";
    let answer = folder.type_in(line).done();
    let codes = answer.warnings();
    let distinct: BTreeSet<&str> = codes.iter().copied().collect();
    assert!(!codes.is_empty() && codes.len() == distinct.len(), "{answer:?}");
    let mut warnings = answer.err.lines().filter(|line| line.starts_with("warning["));
    assert!(warnings.all(|line| line.ends_with("(for 3 UAVs: 1, 2, 3)")), "{answer:?}");
    // Every file has its own.
    let n_own = |k: usize| folder.json(&format!("{k}.json"))["warnings"].as_array().map(Vec::len);
    assert!((1..=3).all(|k| n_own(k) == Some(codes.len())), "{answer:?}");
}

#[test]
fn a_uav_outside_the_grid_is_told_with_its_distance() {
    let folder = folder();
    let warned = |line: &str| {
        let err = folder.type_in(line).done().err;
        err.lines().filter(|line| line.starts_with("warning[W204]")).map(str::to_string).collect::<Vec<_>>()
    };
    for (command, rest) in [
        ("map", "--uav 25,25,50"),
        ("map", "-o {site}.json"),
        ("map", "--radius 20 -o r{site}.json"),
        ("map", "--strips"),
        ("link", "--rx 2,2"),
        ("track", "--track walk.csv"),
        ("stress", ""),
        ("chart", "--time 0"),
        ("limits", ""),
    ] {
        let lines = warned(&format!("{command} dsm.asc --ground 0 --uav 53,54,9amsl {rest}"));
        assert_eq!(lines, ["warning[W204]: UAV `1` is 5 m north-east of the grid"], "{command} {rest}");
    }
    let far = warned("map city.geojson --extent 0,0,50,50 --uav 25,-3000,50");
    assert!(far.len() == 1 && far[0].contains("3000 m south"), "{far:?}");
    let two = warned("compare dsm.asc --ground 0 --uav 53,54,9amsl --uav -1.5,5,9amsl");
    assert!(two.len() == 1 && two[0].ends_with("`1` 5 m north-east, `2` 1.5 m west"), "{two:?}");
    // Where it cannot be, too.
    folder.refuses("map dsm.asc --uav 25,-3000,50", "E204", &["3000 m south of the grid"]);
    // Its edges belong to the grid.
    let answer = folder.type_in("map dsm.asc --ground 0 --uav 50,50,50amsl --uav 0,25,50").done();
    assert!(!answer.warnings().contains(&"W204"), "{answer:?}");
}

#[test]
fn a_run_of_more_than_two_seconds_says_how_far_it_is() {
    let folder = Folder::new();
    // 36 million rays on one thread.
    let line = "map itu:urban --size 6000 --uav 3000,3000,60 --method ray -j 1 --json";
    let answer = folder.type_in(line).done();
    let seconds = |answer: &Answer| answer.json()["timing_s"]["total"].as_f64().expect("a time");
    let (took, told) = (seconds(&answer), answer.progress.len());
    // On a busy machine the thread that tells it may be late.
    assert!(took < 2.5 || told > 0 && told as f64 <= 1.0 + took / 10.0, "{took} s: {answer:?}");
    let short = folder.type_in("map itu:urban --uav 500,500,60 --json").done();
    assert!(short.progress.is_empty() || seconds(&short) > 2.0, "{short:?}");
}
