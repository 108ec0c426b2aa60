//! Surfaces of buildings in formats that hold polygons with heights: each gives the maps of the same city as CityJSON.

use std::fs;

use serde_json::json;

use crate::needs::truth;
use crate::program::Folder;
use crate::solid_writers::{
    solids, write_cityjson, write_flatgeobuf, write_geojson, write_geopackage, write_multipatches, write_polygons,
};
use crate::vector_files::{EAST, NORTH};

fn digests(folder: &Folder, scene: &str) -> Vec<String> {
    let digest = |(x, y, h): (f64, f64, f64)| {
        let (x, y) = (EAST + x, NORTH + y);
        let document = folder.type_in(&format!("map {scene} --uav {x},{y},{h} --json")).done().json();
        document["digest"].as_str().unwrap_or_else(|| panic!("{document}")).to_string()
    };
    [(33.0, 12.0, 8.5), (18.0, 30.0, 12.0), (46.0, 50.0, 20.0)].map(digest).to_vec()
}

/// A folder with the city in each format, and the names of the files.
fn city() -> (Folder, Vec<&'static str>) {
    let (folder, solids) = (Folder::new(), solids());
    write_cityjson(&folder.join("city.city.json"), &solids);
    write_geojson(&folder.join("z.geojson"), &solids, &json!({"name": "a"}));
    write_geopackage(&folder.join("multi.gpkg"), &solids, 1006);
    write_geopackage(&folder.join("polyhedral.gpkg"), &solids, 1015);
    write_geopackage(&folder.join("tin.gpkg"), &solids, 1016);
    write_flatgeobuf(&folder.join("z.fgb"), &solids);
    write_polygons(&folder.join("polygons.shp"), &solids);
    write_multipatches(&folder.join("patches.shp"), &solids);
    let names = vec!["z.geojson", "multi.gpkg", "polyhedral.gpkg", "tin.gpkg", "z.fgb", "polygons.shp", "patches.shp"];
    (folder, names)
}

#[test]
fn surfaces_are_the_city_of_cityjson() {
    let (folder, names) = city();
    let extent = format!("--extent {EAST},{NORTH},{},{}", EAST + 60.0, NORTH + 55.0);
    let mut all = Vec::new();
    for options in ["--roofs lod2", "--roofs flat", "", "--roofs lod2 --ground 499"] {
        let scene = |name: &str| format!("{name} {options} {extent}");
        let wanted = digests(&folder, &scene("city.city.json"));
        for name in &names {
            assert_eq!(digests(&folder, &scene(name)), wanted, "{name} {options}");
        }
        all.push(wanted);
    }
    assert!(all[0] != all[1] && all[1] == all[2] && all[0] != all[3], "{all:?}");
    // Their own bases are the ground, and their ridge the height of a flat roof.
    let document = folder.type_in(&format!("info z.fgb {extent} --json")).done();
    assert!(document.err.contains("W366"), "{document:?}");
}

#[test]
fn a_property_counts_before_surfaces_unless_roofs_are_asked_for() {
    let (folder, _) = city();
    write_geojson(&folder.join("both.geojson"), &solids(), &json!({"height": 9.0}));
    write_geojson(&folder.join("null.geojson"), &solids(), &json!({"height": null}));
    let extent = format!("--extent {EAST},{NORTH},{},{}", EAST + 60.0, NORTH + 55.0);
    let of = |scene: &str| digests(&folder, &format!("{scene} {extent}"));
    assert_eq!(of("both.geojson"), of("z.geojson --missing 9 --height-field height"));
    assert_ne!(of("both.geojson"), of("z.geojson"));
    assert_eq!(of("null.geojson"), of("z.geojson"));
    assert_eq!(of("both.geojson --roofs lod2"), of("z.geojson --roofs lod2"));
}

/// A footprint that is drawn at one height, or without walls, does not tell what stands below.
#[test]
fn heights_of_nothing_known_are_not_guessed() {
    let (folder, _) = city();
    let square = |z: f64| vec![[0.0, 0.0, z], [9.0, 0.0, z], [9.0, 9.0, z], [0.0, 9.0, z]];
    write_geojson(&folder.join("level.geojson"), &[vec![square(507.0)]], &json!({"name": "a"}));
    folder.refuses("info level.geojson", "E365", &["the `z` of its areas", "`--missing 9`"]);
    folder.refuses("info level.geojson --roofs lod2", "E308", &["polygons with heights"]);
    folder.type_in("info level.geojson --missing 9").done();
    write_geojson(&folder.join("zero.geojson"), &[vec![square(0.0)]], &json!({"name": "a"}));
    let answer = folder.type_in("info zero.geojson");
    assert!(answer.error() == "E365" && !answer.err.contains("the `z`"), "{answer:?}");
    // A lone roof has no ground unless one is given.
    let roof = vec![vec![vec![[0.0, 0.0, 506.0], [9.0, 0.0, 506.0], [9.0, 9.0, 509.0], [0.0, 9.0, 509.0]]]];
    write_geojson(&folder.join("roof.geojson"), &roof, &json!({"name": "a"}));
    folder.refuses("info roof.geojson", "E365", &["the `z` of its areas"]);
    folder.refuses("info roof.geojson --roofs lod2", "E365", &["`z`", "`--ground Z`"]);
    folder.type_in("info roof.geojson --roofs lod2 --ground 500").done();
}

#[test]
fn samples_are_scenes() {
    let Some(data) = truth() else { return };
    let folder = Folder::new();
    for name in ["mp.shp", "mp.shx", "mp.dbf", "mp.prj", "zonly.geojson"] {
        fs::copy(data.join("formats/meaning").join(name), folder.join(name)).unwrap();
    }
    for line in ["info mp.shp --roofs lod2 --ground 500", "info zonly.geojson --roofs lod2", "info zonly.geojson"] {
        folder.type_in(&format!("{line} --json")).done();
    }
}

#[test]
fn counts_of_patches_that_lie_are_refused() {
    let folder = Folder::new();
    for at in [44, 48] {
        write_multipatches(&folder.join("m.shp"), &solids());
        let mut bytes = folder.read("m.shp");
        bytes[100 + at..100 + at + 4].copy_from_slice(&i32::MAX.to_le_bytes());
        fs::write(folder.join("m.shp"), bytes).unwrap();
        folder.refuses("info m.shp", "E302", &["feature 1", "2147483647"]);
    }
}
