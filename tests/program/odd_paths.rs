//! Odd paths: a byte 0xFF in the names of inputs and outputs, links, two slashes at the beginning.

use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use crate::cli::scenes;
use crate::program::{Answer, Folder, program, wait};
use crate::vector_files::{
    city, write_cityjson, write_flatgeobuf, write_geojson, write_geopackage, write_obj, write_shapefile,
};

/// A name in which `?` stands for the byte 0xFF.
fn odd(name: &str) -> OsString {
    let bytes: Vec<u8> = name.bytes().map(|byte| if byte == b'?' { 0xFF } else { byte }).collect();
    OsStr::from_bytes(&bytes).to_os_string()
}

fn run(folder: &Folder, line: &str) -> Answer {
    wait(program(folder.path(), &[]).args(line.split_whitespace().map(odd)).spawn().expect("the program starts"))
}

fn path(folder: &Folder, name: &str) -> PathBuf {
    folder.path().join(Path::new(&odd(name)))
}

#[test]
fn inputs_may_have_names_that_are_no_unicode() {
    let folder = scenes();
    for name in ["dsm.asc", "slope.asc", "city.geojson", "sites.csv"] {
        std::fs::copy(folder.join(name), path(&folder, &format!("?{name}"))).expect("a copy");
    }
    folder.type_in("city dsm.asc -o dsm.tif -q").done();
    std::fs::rename(folder.join("dsm.tif"), path(&folder, "?dsm.tif")).expect("renamed");
    std::fs::write(path(&folder, "?walk.csv"), "x,y\n2,2\n2,48\n").expect("a track");
    std::fs::write(path(&folder, "?curve.csv"), "theta_deg,p_los\n0,0\n90,1\n").expect("a curve");
    let buildings = city();
    write_geojson(&path(&folder, "?v.geojson"), &buildings);
    write_shapefile(&path(&folder, "?v.shp"), &buildings);
    write_flatgeobuf(&path(&folder, "?v.fgb"), &buildings, true);
    write_cityjson(&path(&folder, "?v.city.json"), &buildings, "2.0");
    write_obj(&path(&folder, "?v.obj"));
    write_geopackage(&folder.join("v.gpkg"), &[("city", &buildings)]);
    std::fs::rename(folder.join("v.gpkg"), path(&folder, "?v.gpkg")).expect("renamed");
    for line in [
        "map ?dsm.asc --terrain ?slope.asc --uavs ?sites.csv",
        "map ?dsm.tif --ground 0 --uav 2,2,50",
        "map ?city.geojson --uavs ?sites.csv --terrain ?slope.asc",
        "map ?city.geojson --uavs ?sites.csv -o ?{site}.json",
        "track ?city.geojson --uav 2,2,50 --track ?walk.csv",
        "place ?city.geojson --data-area all --candidates ?sites.csv",
        "plos ?city.geojson --theta 45 --height 50 --positions 2 --method maps",
        "plos itu:urban --theta 45 --curve own=?curve.csv",
        "info ?sites.csv",
        "info ?v.geojson",
        "info ?v.shp",
        "info ?v.fgb",
        "info ?v.gpkg",
        "info ?v.city.json",
        "info ?v.obj",
    ] {
        run(&folder, line).done();
    }
    assert!(path(&folder, "?a.json").exists(), "{:?}", folder.files());
    // Messages and documents show such names as far as they can.
    let document = run(&folder, "map ?city.geojson --uav 2,2,50 --json").done().json();
    assert_eq!(document["scene"]["sources"][0]["path"], "\u{fffd}city.geojson");
    assert_eq!(document["command"][1], "\u{fffd}city.geojson");
    // The word for a generated city is Unicode.
    for scene in ["?none.tif", "itu:urban?"] {
        let answer = run(&folder, &format!("map {scene} --uav 2,2,50"));
        let told = answer.error() == "E301" && answer.err.contains(&scene.replace('?', "\u{fffd}"));
        assert!(told, "{scene}: {answer:?}");
    }
}

/// Another program could not find the files that a plan names.
#[test]
fn a_plan_holds_no_names_that_are_no_unicode() {
    let folder = scenes();
    let answer = run(&folder, "jobs plan map city.geojson --uavs sites.csv -o ?{site}.tif");
    assert!(answer.error() == "E105" && answer.err.contains("\u{fffd}{site}.tif"), "{answer:?}");
    run(&folder, "map city.geojson --uavs sites.csv -o ?{site}.tif").done();
    run(&folder, "jobs status map city.geojson --uavs sites.csv -o ?{site}.tif").done();
}

#[test]
fn outputs_may_have_names_that_are_no_unicode() {
    let folder = scenes();
    let two = "--uav 2,2,50 --uav 40,40,50";
    for (line, files) in [
        (
            format!("map city.geojson {two} --crs EPSG:25832 --bare -o ?a.png"),
            "?a.png ?a.pgw ?a.prj ?a.png.json ?a.1.png ?a.1.pgw ?a.1.prj ?a.1.png.json ?a.2.png",
        ),
        (
            "map city.geojson --uav 2,2,50 -o ?b.tif -o ?b.asc -o ?b.csv -o ?b.exr -o ?b.npz -o ?b.bil".into(),
            "?b.tif ?b.tif.aux.xml ?b.asc ?b.asc.json ?b.csv ?b.csv.json ?b.exr ?b.npz ?b.bil ?b.hdr",
        ),
        (format!("map city.geojson {two} -o ?c-{{site}}.tif -o ?c-{{site}}?.csv"), "?c-1.tif ?c-2.tif ?c-1?.csv"),
        ("city city.geojson -o ?d.png -o ?d.geojson".into(), "?d.png ?d.geojson"),
        ("plos itu:urban --theta 45 -o ?e.svg --csv ?e.csv".into(), "?e.svg ?e.csv ?e.csv.json"),
        ("info city.geojson --repairs ?f.csv -o ?f.json".into(), "?f.csv ?f.csv.json ?f.json"),
    ] {
        let answer = run(&folder, &line).done();
        for file in files.split(' ') {
            assert!(path(&folder, file).exists(), "{line}: {file} is not among {:?}", folder.files());
            assert!(answer.err.contains(&file.replace('?', "\u{fffd}")), "{line}: {file}: {answer:?}");
        }
    }
    let again = run(&folder, &format!("map city.geojson {two} -o ?c-{{site}}.tif -o ?c-{{site}}?.csv"));
    assert_eq!(again.error(), "E106");
}

/// A link is followed, whether what it points to is there or not; the link stays one.
#[test]
fn an_output_goes_to_what_a_link_points_to() {
    let folder = scenes();
    std::fs::create_dir(folder.join("there")).expect("a folder");
    for (target, is_there) in [("there/old.csv", true), ("there/new.csv", false)] {
        if is_there {
            folder.write(target, "old");
        }
        let _ = std::fs::remove_file(folder.join("link.csv"));
        std::os::unix::fs::symlink(target, folder.join("link.csv")).expect("a link");
        let line = "map dsm.asc --ground 0 --uav 2,2,50 -q -o link.csv";
        if is_there {
            folder.refuses(line, "E106", &["link.csv"]);
            assert_eq!(folder.text(target), "old");
        }
        folder.type_in(&format!("{line} --overwrite")).done();
        assert!(folder.join("link.csv").is_symlink() && folder.text(target).starts_with("site,"), "{target}");
    }
    assert_eq!(std::fs::read_dir(folder.join("there")).expect("a folder").count(), 2, "nothing else is there");
}

#[test]
fn two_slashes_at_the_beginning_of_a_path_are_one() {
    let folder = Folder::new();
    write_geopackage(&folder.join("v.gpkg"), &[("city", &city())]);
    folder.type_in(&format!("info /{} --json", folder.word("v.gpkg"))).done();
}

/// What a killed run left beside an output is gone after the next run that writes there; what a living one writes stays.
#[test]
fn what_a_killed_run_left_is_removed_by_the_next() {
    let folder = scenes();
    let left = [".old.tif.0123456789abcdef.part", ".skyshed.0123456789abcdef.part", ".map.png.00000000000000aa.part"];
    left.iter().for_each(|name| folder.write(name, "half"));
    let alive = [".other.tif.fedcba9876543210.part", ".skyshed.fedcba9876543210.part"];
    alive.iter().for_each(|name| folder.write(name, "half"));
    let lock = std::fs::File::open(folder.join(alive[1])).expect("a file");
    lock.try_lock().expect("a lock");
    folder.type_in("map dsm.asc --ground 0 --uav 2,2,50 -q -o a.csv").done();
    let hidden: Vec<String> = folder.files().into_iter().filter(|name| name.starts_with('.')).collect();
    assert_eq!(hidden, alive);
}
