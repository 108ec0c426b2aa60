//! Files of units that a disk or a copy cut short are told as such, whatever their format is, and made again.

use crate::program::Folder;

/// What a map of one UAV may be written as, and what may stand beside it.
const FORMATS: [&str; 12] = ["tif", "png", "svg", "pdf", "exr", "asc", "bil", "npz", "kmz", "csv", "json", "geojson"];

/// Two UAVs over a small wall, and the line that maps each of them into files of all formats.
fn scene() -> (Folder, String) {
    let folder = Folder::new();
    let row = "0 0 0 0 0 0 0 0 0 0 9 0 0 0 0 0 0 0 0 0\n";
    let head = "ncols 20\nnrows 20\nxllcorner 691000\nyllcorner 5334000\ncellsize 1\n";
    folder.write("wall.asc", &(head.to_string() + &row.repeat(20)));
    folder.write("sites.csv", "id,x,y,h\na,691005,5334005,30\nb,691015,5334010,20\n");
    let outputs: String = FORMATS.iter().map(|format| format!(" -o {{site}}.{format}")).collect();
    let line = format!(
        "map wall.asc --crs EPSG:25832 --ground 0 --uavs sites.csv{outputs} -o {{site}}.fgb --polygons los --width 300"
    );
    folder.type_in(&format!("{line} -q")).done();
    (folder, line)
}

/// All files of a unit that say what they are: also the documents beside those that hold none.
fn files() -> Vec<String> {
    let of_formats = FORMATS.iter().chain(&["fgb"]).map(|format| format!("a.{format}"));
    of_formats.chain(["asc", "bil", "csv"].map(|format| format!("a.{format}.json"))).collect()
}

#[test]
fn a_file_that_is_cut_short_is_told_and_made_again() {
    let (folder, line) = scene();
    let whole: Vec<(String, Vec<u8>)> = files().into_iter().map(|name| (name.clone(), folder.read(&name))).collect();
    let status = || folder.type_in(&format!("jobs status {line}"));
    assert!(status().done().out.starts_with("2 units: 2 done"));
    for (name, bytes) in &whole {
        for n_left in [5, bytes.len() / 2, bytes.len() - 3] {
            std::fs::write(folder.join(name), &bytes[..n_left]).expect("it is cut");
            let answer = status();
            let broken = format!("1 done, 0 missing, 1 broken\nbroken a: {name} is cut short or damaged\n");
            assert!(answer.out.ends_with(&broken), "{n_left} of {} bytes: {answer:?}", bytes.len());
            assert!(answer.err.ends_with("hint: run the map again with `--resume`: what is done is left alone\n"));
        }
        assert_eq!(folder.type_in(&format!("jobs merge -o all.csv {line}")).error(), "E603");
        let made = folder.type_in(&format!("{line} --resume")).done();
        assert!(made.err.contains("1 UAV mapped, 1 there already"), "{name}: {made:?}");
        assert!(&folder.read(name) == bytes, "{name} is not what it was");
    }
    folder.type_in(&format!("jobs merge -o all.csv {line}")).done();
}

/// A disk or a copy may turn over a byte and leave the length.
#[test]
fn a_raster_with_another_byte_within_is_told_and_made_again() {
    let (folder, line) = scene();
    for name in ["a.tif", "a.exr", "a.png", "a.npz"] {
        let whole = folder.read(name);
        let mut places = vec![whole.len() / 3, whole.len() / 2, whole.len() * 9 / 10];
        if name == "a.npz" {
            // Around the members of an archive stand their times, which mean nothing.
            let bytes_of = |at: usize| usize::from(u16::from_le_bytes([whole[at], whole[at + 1]]));
            places = vec![30 + bytes_of(26) + bytes_of(28) + 5];
        }
        for at in places {
            let mut other = whole.clone();
            other[at] ^= 4;
            std::fs::write(folder.join(name), &other).expect("another byte");
            let status = folder.type_in(&format!("jobs status {line}"));
            assert!(status.out.contains("1 done, 0 missing, 1 broken\nbroken a: "), "{name} at {at}: {status:?}");
        }
        folder.type_in(&format!("{line} --resume --overwrite")).done();
        assert!(folder.read(name) == whole, "{name}");
    }
}

/// The later of two units would replace the file of the earlier.
#[test]
fn units_whose_files_are_one_through_a_link_are_refused() {
    let (folder, line) = scene();
    let before = folder.read("a.tif");
    std::fs::remove_file(folder.join("b.tif")).expect("a file");
    std::os::unix::fs::symlink("a.tif", folder.join("b.tif")).expect("a link");
    for more in ["", " --overwrite", " --resume", " --resume --overwrite"] {
        let words = ["`a` and `b` would share", "b.tif"];
        folder.refuses(&format!("{line}{more}"), "E207", &words);
    }
    assert!(folder.read("a.tif") == before);
    // So are two outputs of one run.
    folder.refuses("map wall.asc --ground 0 --uav 691005,5334005,30 -o a.tif -o b.tif --overwrite", "E105", &["b.tif"]);
    assert!(folder.read("a.tif") == before);
}

#[test]
fn what_is_left_of_another_run_is_not_replaced() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 100 --seed 3 -o dsm.tif -q").done();
    let asked = |ground: u32, more: &str| {
        let tiles = "--layers count --tile-size 64 -o {row}-{col}.tif";
        format!("map dsm.tif --ground {ground} --uav 20,20,100 {tiles} {more} -q")
    };
    folder.type_in(&asked(0, "")).done();
    let bytes = folder.read("0-1.tif");
    let cut = |n: usize| std::fs::write(folder.join("0-1.tif"), &bytes[..n]).expect("it is cut");
    // Wherever it ends, a tile is either known to be of another run or of none; only that is made again.
    let unit = b"&quot;unit&quot;:&quot;";
    let named_at = bytes.windows(unit.len()).position(|window| window == unit).expect("a unit") + unit.len();
    for n in [1, 8, named_at - 4, named_at, named_at + 3, named_at + 20, bytes.len() - 3] {
        cut(n);
        let own = folder.type_in(&format!("jobs status {}", asked(0, "")));
        assert!(own.out.ends_with("broken tile 0,1: 0-1.tif is cut short or damaged\n"), "{n}: {own:?}");
        let other = folder.type_in(&format!("jobs status {}", asked(1, "")));
        // Names of all units begin alike.
        let is_of_another = n > named_at + "sha256:".len();
        let wanted = if is_of_another { "made by another run" } else { "0-1.tif is cut short or damaged" };
        let said = other.out.lines().find(|line| line.starts_with("broken tile 0,1: ")).expect("a broken tile");
        assert!(said.contains(wanted), "{n}: {said}");
    }
    // So is one whose beginning is damaged, as long as it says whose it is.
    std::fs::write(folder.join("0-1.tif"), [vec![0; 64], bytes[64..].to_vec()].concat()).expect("a file");
    let damaged = folder.type_in(&format!("jobs status {}", asked(0, "")));
    assert!(damaged.out.ends_with("0-1.tif is cut short or damaged\n"), "{damaged:?}");
    assert_eq!(folder.type_in(&asked(1, "--resume")).error(), "E106");
    folder.type_in(&asked(0, "--resume")).done();
    assert!(folder.read("0-1.tif") == bytes);
    // A file in which nothing says what it is stays, unless it may be replaced.
    folder.write("0-1.tif", "a table of mine");
    let status = folder.type_in(&format!("jobs status {}", asked(0, "")));
    assert!(status.out.contains("nothing in it says which run made it: it is damaged, or of"), "{status:?}");
    assert!(status.err.contains("hint: run the map again with `--resume --overwrite`"), "{status:?}");
    folder.refuses(
        &asked(0, "--resume"),
        "E106",
        &["it is damaged, or of another program", "`--overwrite` replaces it"],
    );
    assert_eq!(folder.text("0-1.tif"), "a table of mine");
    folder.type_in(&asked(0, "--resume --overwrite")).done();
    assert!(folder.read("0-1.tif") == bytes);
}
