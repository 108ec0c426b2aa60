//! No run that takes more memory than `--max-memory` succeeds: it stays within a tenth of it, or ends with exit code 5 and no file.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::json;

use crate::needs::has;
use crate::plain_tiff::PlainTiff;
use crate::program::{Folder, wait};
use crate::support::{Random, is_long};

/// What writing takes after the last look at the peak \[bytes\].
const SLACK: u64 = 8 << 20;

/// A city of 120 × 120 houses on one another by pairs, and a raster of 1500 × 1500 cells.
fn scenes() -> Folder {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 1500 -o city.tif -q").done();
    let house = |k: i32| {
        let (x, y) = (k % 120 * 5, k / 120 * 10);
        let corners = [[x, y], [x + 9, y], [x + 9, y + 9], [x, y + 9], [x, y]];
        json!({"type": "Feature", "properties": {"height": 12},
            "geometry": {"type": "Polygon", "coordinates": [corners]}})
    };
    let features: Vec<_> = (0..14_400).map(house).collect();
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}});
    folder.write("houses.geojson", &json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string());
    folder.write("walk.csv", "x,y\n10,10\n800,10\n800,700\n");
    folder
}

/// Removes what was not there before.
fn clear(folder: &Folder, before: &[String]) {
    let mut written = folder.files();
    written.retain(|file| !before.contains(file));
    folder.remove(&written);
}

/// Memory that a forecast adds for whatever work there is \[bytes\].
const ANY_WORK: u64 = 5 << 20;

/// Limits around what a run takes, of whose files none stays \[bytes\], and whether each is enough.
fn limits(folder: &Folder, line: &str) -> [(u64, bool); 3] {
    let before = folder.files();
    let (answer, needed) = folder.measured(line);
    answer.done();
    clear(folder, &before);
    [(needed / 4, false), (needed / 2, false), (2 * needed + ANY_WORK, true)]
}

#[test]
fn a_run_stays_within_its_memory_or_is_refused() {
    let folder = scenes();
    let lines = [
        "map city.tif --ground 0 --uav 10,10,90 -o a.tif --strips",
        "map city.tif --ground 0 --uav 10,10,90 -o a.tif",
        "map city.tif --ground 0 --uav 10,10,90 -o a.png -o a.npz -o a.exr",
        "map city.tif --ground 0 --uav 10,10,90 --uav 700,10,90 --layers los,margin,which --radius 50 -o a.tif",
        "map houses.geojson --uav 3,3,90 -o a.tif -o a.json",
        "link houses.geojson --uav 3,3,90 --rx 400,400 --json",
        "city houses.geojson -o a.xml -o a.tif",
        "info city.tif --ground 0 --tile 100 -o a.csv",
        "info houses.geojson --tile 20 -o a.tif",
        "zones houses.geojson -o a.geojson",
        "place houses.geojson --height 60 --step 40 -k 2 -o a.csv",
        "compare houses.geojson --uav 3,3,90 --uav 300,300,90 -o a.html -o a.tif",
        "plos houses.geojson --theta 30,60 -o a.csv",
        "stress houses.geojson --uav 3,3,90 -o a.csv",
        "stress --scenes 10 -o a.csv",
        "track city.tif --ground 0 --uav 10,10,90 --track walk.csv -o a.csv",
        "limits houses.geojson --uav 3,3,90 --json",
        "sample houses.geojson --height 60 --zones street:20 -o a.csv",
        "plos itu:urban --method city,product --cities 10 -o a.csv",
        "chart itu:urban --size 500 --uav 10,10,90 --time 0 -o a.csv",
        "chart itu:urban --plos --time 0 -o a.csv",
    ];
    for line in lines.into_iter().step_by(if is_long() { 1 } else { 4 }) {
        let before = folder.files();
        for (limit, is_enough) in limits(&folder, line) {
            let (answer, peak) = folder.measured(&format!("{line} --max-memory {limit}"));
            if answer.code() == 0 {
                assert!(peak <= limit + limit / 10 + SLACK, "{line}: {peak} of {limit} bytes");
                clear(&folder, &before);
                continue;
            }
            assert!(!is_enough && answer.error() == "E501", "{line}: of {limit} bytes: {answer:?}");
            // The program takes a few megabytes before it can say that it may not; a watch may wait for a processor, and so end a
            // run late. What is refused beforehand takes no more than it may.
            let is_late = ["cannot start", "cannot go on"].iter().any(|words| answer.err.contains(words));
            assert!(is_late || peak <= limit + limit / 10 + SLACK, "{line}: {peak} of {limit} bytes");
            assert_eq!(folder.files(), before, "{line}");
        }
    }
}

/// A raster of 2000 × 2000 heights at random up to 20 m.
fn noise() -> PlainTiff {
    let mut random = Random(11);
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    let heights = (0..2000 * 2000).map(|_| random.below(20_000) as f64 / 1000.0).collect();
    PlainTiff::floats((500_000.0, 5_400_000.0), 1.0, 2000, heights)
}

/// Questions over a city of blocks, noise and Munich.
fn questions(folder: &Folder) -> Vec<String> {
    folder.type_in("city itu:urban --size 2000 -o city.tif -q").done();
    std::fs::write(folder.join("noise.tif"), noise().bytes()).unwrap();
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson"), folder.join("munich.geojson"))
        .unwrap();
    let places = |corner: [f64; 2], size: f64, n: usize| {
        let mut random = Random(5);
        #[expect(clippy::cast_precision_loss, reason = "small numbers")]
        let mut within = |from: f64| from + size * random.below(1000) as f64 / 1000.0;
        let row = |k| format!("{},{},{}\n", within(corner[0]), within(corner[1]), 100 + k);
        format!("x,y,h\n{}", (0..n).map(row).collect::<String>())
    };
    let scenes = [
        ("city.tif --ground 0", [10.0, 10.0], 1900.0),
        ("noise.tif --ground 0", [500_010.0, 5_398_010.0], 1900.0),
        ("munich.geojson", [690_950.0, 5_334_300.0], 700.0),
    ];
    let questions = [
        "map S U -o a.tif",
        "map S U -o a.png",
        "map S U -o a.npz -o a.exr",
        "map S U --layers los,margin,ceiling -o a.tif",
        "map S --uavs many.csv -o a.csv",
        "map S --uavs many.csv --layers count -o a.tif",
        "map S --uavs two.csv -o a.tif",
        "zones S -o a.geojson",
        "zones S -o a.tif",
        "compare S --uavs two.csv -o a.tif",
        "limits S U --json",
        "stress S U -o a.csv",
        "live S -o a.html",
        "city S -o a.tif",
    ];
    let mut lines = Vec::new();
    for (k, (scene, corner, size)) in scenes.into_iter().enumerate() {
        folder.write(&format!("many{k}.csv"), &places(corner, size, 40));
        folder.write(&format!("two{k}.csv"), &places(corner, size, 2));
        let uav = format!("--uav {},{},130", corner[0] + size / 2.0, corner[1] + size / 2.0);
        lines.extend(questions.map(|question| {
            let files = question.replace("many", &format!("many{k}")).replace("two", &format!("two{k}"));
            format!("{} -j 1", files.replace('S', scene).replace('U', &uav))
        }));
    }
    lines
}

/// What a run takes is known before its work: a fifth less is refused then, or made strip by strip, and a quarter more is enough.
#[test]
fn forecasts_are_near_what_runs_take() {
    let folder = Folder::new();
    let lines = questions(&folder);
    let before = folder.files();
    for line in lines.iter().step_by(if is_long() { 1 } else { 5 }) {
        let (answer, peak) = folder.measured(line);
        answer.done();
        clear(&folder, &before);
        let within = |share: u64| {
            let answer = folder.type_in(&format!("{line} --max-memory {}", peak / 20 * share));
            clear(&folder, &before);
            answer
        };
        let enough = within(25);
        assert_eq!(enough.code(), 0, "{line}: a peak of {peak} bytes: {enough:?}");
        let little = within(16);
        let words = if little.code() == 0 { "strip by strip" } else { " need " };
        let is_known = little.err.contains(words) && !little.err.contains("cannot go on");
        assert!(is_known, "{line}: a peak of {peak} bytes: {little:?}");
    }
}

/// Whatever the limit, a run keeps it or is refused, and what succeeds does so with more.
#[test]
fn random_limits_are_kept_and_more_memory_never_makes_a_run_fail() {
    let folder = Folder::new();
    let mut lines = questions(&folder);
    lines.extend(
        [
            "info city.tif --ground 0 --tile 100 -o a.csv -j 1",
            "place munich.geojson --height 60 --step 40 -k 3 -o a.csv -j 1",
            "place noise.tif --ground 0 --height 60 --step 300 -k 3 -o a.csv -j 1",
            "sample munich.geojson --height 60 --zones street:20 -o a.csv -j 1",
            "plos itu:urban --method city,product --cities 3 -o a.csv -j 1",
            "map city.tif --ground 0 --uav 900,900,90 --strips -o a.tif -j 1",
            "map munich.geojson --uavs two2.csv --height-error 0.5 --layers p-los -o a.tif -j 1",
            "map noise.tif --ground 0 --uavs two1.csv --receivers roof --earth-k 4/3 -o a.tif -j 1",
        ]
        .map(String::from),
    );
    let before = folder.files();
    let reading = |line: &str| {
        let scene = line.split(' ').nth(1).unwrap();
        let (answer, peak) = folder.measured(&format!("info {scene} -j 1"));
        answer.done();
        peak + peak / 10
    };
    let mut random = Random(58);
    let n_lines = if is_long() { lines.len() } else { 3 };
    let (mut n_kept, mut n_refused) = (0, 0);
    for _ in 0..n_lines {
        let line = lines.swap_remove(random.below(lines.len()));
        let (answer, peak) = folder.measured(&line);
        answer.done();
        clear(&folder, &before);
        // From a quarter of what it takes to four times as much.
        #[expect(
            clippy::cast_precision_loss,
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "bytes"
        )]
        let limit = |random: &mut Random| (peak as f64 * 2.0_f64.powf(random.below(4000) as f64 / 1000.0 - 2.0)) as u64;
        let mut limits: Vec<u64> = (0..8).map(|_| limit(&mut random)).collect();
        limits.sort_unstable();
        let mut is_enough = false;
        for limit in limits {
            let (answer, peak_within) = folder.measured(&format!("{line} --max-memory {limit}"));
            if answer.code() == 0 {
                assert!(peak_within <= limit + limit / 10, "{line}: {peak_within} of {limit} bytes");
                (is_enough, n_kept) = (true, n_kept + 1);
                clear(&folder, &before);
            } else {
                assert!(answer.code() == 5 && !is_enough, "{line}: of {limit} bytes, {peak} without: {answer:?}");
                assert_eq!(folder.files(), before, "{line}: of {limit} bytes");
                // Before its work, but for a file that cannot even be read and for almost enough.
                let is_late = answer.err.contains("cannot go on") && limit < peak / 4 * 3;
                assert!(!is_late || limit < reading(&line), "{line}: of {limit} bytes, {peak} without: {answer:?}");
                n_refused += 1;
            }
        }
    }
    assert!(n_kept > n_refused / 4 && n_refused > n_kept / 4, "{n_kept} kept, {n_refused} refused");
}

/// What writes nothing beyond its limit must not compute to its end either. Processor time tells: a busy machine lets the watch wait, and the work
/// as well.
#[test]
fn a_watch_ends_a_run_that_takes_too_much_long_before_it_is_done() {
    let folder = scenes();
    let line = "place houses.geojson --height 60 --step 4 -j 1 -o a.csv --overwrite";
    let whole = folder.type_in(line).done();
    // Less than the city alone takes, which is there before the first place is mapped.
    let ended = folder.type_in(&format!("{line} --max-memory 20M"));
    assert!(ended.error() == "E501" && ended.err.contains("cannot go on"), "{ended:?}");
    assert!(whole.cpu_s > 1.0 && ended.cpu_s < 0.5 * whole.cpu_s, "{} of {} s", ended.cpu_s, whole.cpu_s);
}

/// Where the system refuses memory, Rust aborts; the program says so and ends with the exit code of a limit. More address space
/// never makes a run fail.
#[test]
fn a_run_in_little_address_space_is_refused_and_never_aborts() {
    let folder = scenes();
    let before = folder.files();
    for line in [
        "map city.tif --ground 0 --uav 10,10,90 -o a.tif -o a.png -o a.npz",
        "map houses.geojson --uav 3,3,90 -o a.tif -o a.json",
        "zones houses.geojson -o a.geojson",
        "place houses.geojson --height 60 --step 40 -k 2 -o a.csv",
        "compare houses.geojson --uav 3,3,90 --uav 300,300,90 -o a.html -o a.tif",
        "live city.tif --ground 0 -o a.html",
    ] {
        let mut is_enough = false;
        // Up to what every run of these has enough of [KiB].
        for limit in [80, 120, 160, 200, 240, 300, 360, 500, 700, 1000, 4000].map(|mib| mib << 10) {
            let mut command = Command::new("sh");
            command.args(["-c", "ulimit -v \"$1\"; shift; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_skyshed")]);
            command.arg(limit.to_string()).args(line.split(' ')).current_dir(folder.path());
            let answer = wait(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("a shell"));
            match answer.code() {
                0 => (is_enough, _) = (true, clear(&folder, &before)),
                _ => {
                    let is_limit = ["E501", "E503"].contains(&answer.error());
                    assert!(is_limit && answer.code() == 5 && !is_enough, "{line}: in {limit} KiB: {answer:?}");
                    assert_eq!(folder.files(), before, "{line}: in {limit} KiB");
                }
            }
        }
        assert!(is_enough, "{line}");
    }
}

/// A control group with a limit of memory, removed when dropped.
struct Group(PathBuf);

impl Group {
    /// A group below the root of version 1 or 2; `None` where this process may not make one.
    fn new(limit: u64) -> Option<Group> {
        let name = format!("skyshed-{}-{limit}", std::process::id());
        let roots = [("/sys/fs/cgroup/memory", "memory.limit_in_bytes"), ("/sys/fs/cgroup", "memory.max")];
        roots.into_iter().find_map(|(root, file)| {
            let folder = Path::new(root).join(&name);
            std::fs::create_dir(&folder).ok()?;
            let group = Group(folder);
            // Never a new file: a folder that is no group holds none.
            let mut file = std::fs::OpenOptions::new().write(true).open(group.0.join(file)).ok()?;
            file.write_all(limit.to_string().as_bytes()).ok()?;
            Some(group)
        })
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir(&self.0);
    }
}

/// Without `--max-memory` the bound is that of the group; what exceeds it is ended by the kernel with a signal, which is a failure.
#[test]
fn a_run_in_a_group_with_little_memory_is_refused_and_not_killed() {
    let folder = scenes();
    for line in [
        "map city.tif --ground 0 --uav 10,10,90 -o a.tif -o a.png -o a.npz",
        "map houses.geojson --uav 3,3,90 -o a.tif -o a.json",
        "info houses.geojson --tile 20 -o a.tif",
        "compare houses.geojson --uav 3,3,90 --uav 300,300,90 -o a.html -o a.tif",
    ] {
        let before = folder.files();
        for (limit, is_enough) in limits(&folder, line) {
            let group = Group::new(limit);
            if !has("cgroup", group.is_some()) {
                return;
            }
            let Some(group) = group else { return };
            let mut command = Command::new("sh");
            command.args([
                "-c",
                "echo $$ > \"$1/cgroup.procs\" || exit 99; shift; exec \"$0\" \"$@\"",
                env!("CARGO_BIN_EXE_skyshed"),
            ]);
            command.arg(&group.0).args(line.split(' ')).current_dir(folder.path());
            let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
            let answer = wait(child);
            match answer.code() {
                0 => {
                    clear(&folder, &before);
                    continue;
                }
                99 => {
                    has("cgroup", false);
                    return;
                }
                _ => {}
            }
            assert!(!is_enough && answer.error() == "E501", "{line}: of {limit} bytes: {answer:?}");
            assert_eq!(folder.files(), before, "{line}");
        }
    }
}
