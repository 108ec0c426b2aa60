//! Interrupted at any moment, writing included, every command is gone within a second, leaves nothing under a final name that is
//! not whole, and nothing hidden after the next run there.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::program::{Folder, interrupt, program};
use crate::support::{Random, is_long};

/// Files and folders, hidden ones too, with what they hold; of those that hold times, such as documents and pages, whether they
/// are whole.
fn contents(folder: &Folder, line: &str) -> BTreeMap<String, Vec<u8>> {
    let holds_times = line.starts_with("chart");
    let entries = std::fs::read_dir(folder.path()).expect("a folder").map(|entry| entry.expect("an entry"));
    let held = |name: &str, bytes: Vec<u8>| match name.rsplit('.').next() {
        Some("json" | "geojson") => vec![u8::from(serde_json::from_slice::<Value>(&bytes).is_ok())],
        Some("csv") if holds_times => vec![u8::from(bytes.ends_with(b"\n"))],
        Some("png") if holds_times => vec![u8::from(bytes.ends_with(b"IEND\xAE\x42\x60\x82"))],
        Some("html") => vec![u8::from(bytes.trim_ascii_end().ends_with(b"</html>"))],
        _ => bytes,
    };
    entries
        .filter_map(|entry| {
            let name = entry.file_name().to_string_lossy().into_owned();
            // A temporary file may go away meanwhile.
            std::fs::read(entry.path()).ok().map(|bytes| (name.clone(), held(&name, bytes)))
        })
        .collect()
}

#[test]
fn an_interrupt_at_any_moment_ends_a_run_and_leaves_whole_files() {
    let n_moments = if is_long() { 400 } else { 2 };
    let mut random = Random(11);
    for line in [
        "map city.tif --ground 0 --uav 10,10,90 -o a.tif -o a.png -o a.npz -o a.exr -o a.csv",
        "map city.tif --ground 0 --uav 10,10,90 -o a.tif -o a.json --strips",
        "map city.geojson --uavs sites.csv -o a-{site}.tif -o a-{site}.csv",
        "link city.geojson --uav 10,10,90 --rx 277,277 -o a.png -o a.json",
        "track city.geojson --uav 10,10,90 --track walk.csv -o a.csv -o a.svg",
        "city itu:urban --size 500 -o a.xml -o a.tif -o a.png -o a.csv",
        "zones city.geojson -o a.png -o a.tif -o a.json",
        "plos itu:urban --method product,city --cities 40 -o a.csv -o a.png",
        "place city.geojson --height 40 --step 50 -k 2 -o a.csv -o a.png -o a.tif",
        "compare city.geojson --uav 10,10,90 --uav 200,200,90 -o a.html -o a.png -o a.tif -o a.csv",
        "chart city.tif --ground 0 --uav 10,10,90 --time 0 -o a.csv -o a.png",
        "stress --scenes 20 -o a.csv -o a.png",
    ] {
        let folder = Folder::new();
        folder.type_in("city itu:urban --size 300 -o city.geojson -o city.tif -q").done();
        folder.write("sites.csv", "id,x,y,h\na,10,10,90\nb,200,10,90\nc,10,200,90\n");
        folder.write("walk.csv", "x,y\n10,10\n277,10\n277,277\n");
        let start = Instant::now();
        folder.type_in(&format!("{line} -q --overwrite")).done();
        let mut whole_run = start.elapsed();
        let whole = contents(&folder, line);
        let written: Vec<String> = whole.keys().filter(|name| name.starts_with('a')).cloned().collect();
        let words: Vec<&str> = line.split(' ').chain(["-q", "--overwrite"]).collect();
        let (mut n_ended, mut slowest) = (0, 0.0_f64);
        let mut k = 0;
        // A run may be over before its moment comes, because the first one was slower: then moments come earlier.
        while k < n_moments || n_ended == 0 && k < 30 {
            // Sometimes over files that are there, sometimes not.
            if random.chance(50) {
                folder.remove(&written);
            }
            let child = program(folder.path(), &words).spawn().expect("the program starts");
            let moment = random.within(0, i64::try_from(whole_run.as_micros()).expect("short"));
            std::thread::sleep(Duration::from_micros(u64::try_from(moment).expect("not negative")));
            let (answer, after) = interrupt(["-INT", "-TERM"][k % 2], child);
            k += 1;
            slowest = slowest.max(after);
            // In its first moments, before it listens, the signal itself ends it.
            let code = answer.status.code().unwrap_or(130);
            assert!(code == 130 || code == 0, "{line}: {answer:?}");
            n_ended += u32::from(code == 130);
            if code == 0 {
                whole_run = whole_run.mul_f64(0.8);
            }
            for (name, bytes) in contents(&folder, line).iter().filter(|(name, _)| !name.starts_with('.')) {
                assert!(whole.get(name) == Some(bytes), "{line}: {name} is not whole");
            }
        }
        // Processor time of two threads.
        assert!(slowest < 2.0, "{line}: {slowest} s after a signal");
        assert!(n_ended > 0, "{line}: no run was interrupted");
        folder.type_in(&format!("{line} -q --overwrite")).done();
        assert!(contents(&folder, line) == whole, "{line}: {:?} are left", folder.files());
    }
}
