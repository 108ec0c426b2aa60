//! One test per bug, named after it, with the reduced input and a sentence of cause.

use serde_json::{Value, json};
use skyshed_io::formats::GeoTiff;

use crate::program::Folder;

/// A roof of 3 m and a nodata cell on a plane of 5 × 5 cells.
fn small() -> Folder {
    let folder = Folder::new();
    folder.write(
        "small.asc",
        "ncols 5\nnrows 5\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n\
         0 0 0 0 0\n0 0 0 0 0\n0 3 0 -9999 0\n0 0 0 0 0\n0 0 0 0 0\n",
    );
    folder
}

/// Boxes from west, south to east, north \[m\], each with its height \[m\], as a collection.
fn collection(boxes: impl IntoIterator<Item = ([i32; 4], i32)>) -> String {
    let feature = |([w, s, e, n], height): ([i32; 4], i32)| {
        let ring = [[w, s], [e, s], [e, n], [w, n], [w, s]];
        json!({"type": "Feature", "properties": {"height": height},
               "geometry": {"type": "Polygon", "coordinates": [ring]}})
    };
    json!({"type": "FeatureCollection", "features": boxes.into_iter().map(feature).collect::<Vec<_>>()}).to_string()
}

/// The integers of a link wrapped, and a walk over 10^12 m never ended.
#[test]
fn a_link_over_more_than_the_lattice_is_refused() {
    let folder = Folder::new();
    for receiver in ["70000,500", "1e9,500", "1e12,1e12", "-1e11,3e11"] {
        folder.refuses(&format!("link itu:urban --uav 500,500,100 --rx={receiver}"), "E203", &[]);
    }
    folder.type_in("link itu:urban --uav 500,500,100 --rx=60000,500").done();
}

/// `--ground 500` over a city of 100 m made every receiver LoS without a word.
#[test]
fn ground_above_the_surface_is_reported() {
    let folder = small();
    let buried = folder.type_in("map small.asc --ground 2 --uav 0.5,0.5,9 --json").done();
    assert!(buried.warnings().contains(&"W341"), "{buried:?}");
    let level = folder.type_in("map small.asc --ground 0 --uav 0.5,0.5,9 --json").done();
    assert!(!level.warnings().contains(&"W341"), "{level:?}");
}

/// The map's margin counts from the roof that a receiver stands on; the link's counted from the ground.
#[test]
fn link_and_map_agree_on_the_margin_of_a_receiver_on_a_roof() {
    let folder = small();
    let map = "map small.asc --ground 0 --uav 4.5,2.5,40 --layers margin --rx-height 5 --receivers all -o m.tif";
    folder.type_in(map).done();
    let mut warnings = Vec::new();
    let file = GeoTiff::open(folder.join("m.tif"), &mut warnings).unwrap();
    let margins = file.read(file.georef().window(), &mut warnings, |v| v).unwrap();
    for (x, y, height) in [(1.5, 2.5, "5roof"), (0.5, 2.5, "5"), (2.5, 4.5, "5")] {
        let link = folder.type_in(&format!("link small.asc --ground 0 --uav 4.5,2.5,40 --rx {x},{y},{height} --json"));
        let margin = link.done().json()["margin_m"].as_f64().unwrap();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "cells of a grid of 5 × 5")]
        let on_map = margins.row(4 - y as usize)[x as usize];
        assert!((margin - on_map).abs() < 1e-3, "({x}, {y}): link {margin}, map {on_map}");
    }
}

/// The sentinel height of nodata that blocks everything, 65536 m, showed up in layers and words.
#[test]
fn nodata_that_blocks_everything_has_no_height() {
    let folder = small();
    let scene = "small.asc --ground 0 --nodata-as block";
    let link = folder.type_in(&format!("link {scene} --uav 4.5,2.5,20 --rx 2.5,2.5 --json")).done().json();
    assert_eq!((&link["los"], &link["margin_m"]), (&Value::Bool(false), &Value::Null));
    assert_eq!(link["obstruction"]["kind"], "nodata");
    assert_eq!(link["obstruction"]["roof_height_m"], Value::Null);
    folder.refuses(&format!("map {scene} --uav 3.5,2.5,5amsl -o o.png"), "E204", &["nodata"]);
    folder.type_in(&format!("map {scene} --uav 4.5,2.5,20 --layers ceiling,margin -o c.tif")).done();
    let mut warnings = Vec::new();
    let file = GeoTiff::open(folder.join("c.tif"), &mut warnings).unwrap();
    for band in 0..2 {
        let values = file.read_band(band, file.georef().window(), &mut warnings, |v| v).unwrap();
        let finite: Vec<f64> = values.cells().iter().copied().filter(|v| !v.is_nan()).collect();
        // Behind the nodata cell no height is enough: ±32768 m, the end of the range.
        assert!(finite.iter().any(|v| (v.abs() - 32_768.0).abs() < 1e-3), "band {band}: {finite:?}");
        assert!(finite.iter().all(|v| v.abs() <= 32_768.0), "band {band}: {finite:?}");
    }
}

/// A city of 10^9 buildings was asked of the allocator.
#[test]
fn a_city_of_too_many_buildings_is_refused_before_it_is_made() {
    let folder = Folder::new();
    for city in ["info itu:0.3,1000000,15 --size 30000 --cell 100", "info itu:0.3,1e9,15 --size 65536 --cell 64"] {
        folder.refuses(city, "E502", &[]);
    }
}

/// Sites of a file without ids were numbered from 1, as typed ones are.
#[test]
fn typed_sites_and_sites_of_a_file_are_numbered_on() {
    let folder = small();
    folder.write("sites.csv", "x,y,h\n1.5,0.5,9\n2.5,0.5,9\n");
    let map = folder.type_in("map small.asc --ground 0 --uav 0.5,0.5,9 --uavs sites.csv --json").done().json();
    let ids: Vec<&str> = map["sites"].as_array().unwrap().iter().map(|s| s["id"].as_str().unwrap()).collect();
    assert_eq!(ids, ["1", "2", "3"]);
}

/// What `map` writes as GeoJSON could not be read back as sites.
#[test]
fn sites_written_by_a_map_are_read_back() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 100 -o city.geojson").done();
    let map = "map city.geojson --crs EPSG:25832 --extent 0,0,100,100";
    let first = folder.type_in(&format!("{map} --uav 10,10,50 -o sites.geojson --json")).done().json();
    let again = folder.type_in(&format!("{map} --uavs sites.geojson --json")).done().json();
    assert_eq!(first["digest"], again["digest"]);
}

/// x and y exchanged, and degrees, were answered with advice about the radius.
#[test]
fn a_position_that_is_swapped_or_in_degrees_is_recognized() {
    let folder = Folder::new();
    folder.write(
        "town.geojson",
        r#"{"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "EPSG:25832"}}, "features": [
        {"type": "Feature", "properties": {"height": 9}, "geometry": {"type": "Polygon",
        "coordinates": [[[691610,5334760],[691620,5334760],[691620,5334775],[691610,5334760]]]}}]}"#,
    );
    for (uav, hint) in [("5334765,691615,50", "x and y are swapped"), ("11.57,48.13,50", "longitude and latitude")] {
        folder.refuses(&format!("map town.geojson --uav {uav} -o o.png"), "E203", &[hint]);
    }
}

/// `link --radius`, `link --method`, `city --method`, `info -j` were refused, although every command takes them.
#[test]
fn every_command_takes_the_common_flags() {
    let folder = Folder::new();
    folder.type_in("link itu:urban --uav 10,10,50 --rx 10,60 --radius 100 -j 2 -q").done();
    folder.type_in("city itu:urban --size 100 -j 2 -q -o c.json").done();
    folder.type_in("info itu:urban --size 100 -j 2 --overwrite").done();
    folder.refuses("link itu:urban --uav 10,10,50 --rx 10,60 --radius 20", "E208", &[]);
}

/// A title without a picture was lost in silence.
#[test]
fn words_for_a_picture_that_is_not_made_are_refused() {
    let folder = small();
    folder.refuses("map small.asc --ground 0 --uav 0.5,0.5,9 -o o.tif --title Title", "E116", &["`--title`"]);
    folder.refuses("city small.asc --ground 0 -o o.tif --attribution Somebody", "E116", &["`--attribution`"]);
}

/// Two joined houses shared two edges of one wall; one of them was dropped, the other hid an inner corner, and the five
/// houses cast one shadow that was not convex: the engine `shadow` let links through them.
#[test]
fn houses_of_equal_height_around_an_inner_corner_cast_their_whole_shadow() {
    let folder = Folder::new();
    let houses = [[4, 4, 5, 6], [4, 6, 5, 7], [5, 4, 6, 6], [5, 6, 6, 7], [6, 4, 8, 6]];
    folder.write("houses.geojson", &collection(houses.map(|corners| (corners, 4))));
    for uav in ["10.5,0.5,6", "1.5,0.5,5", "11.5,5.5,9", "7.25,8.5,3"] {
        let digest = |method: &str| {
            let line = format!("map houses.geojson --extent 0,0,12,12 --cell 0.25 --uav {uav} --method {method}");
            folder.type_in(&format!("{line} --json")).done().json()["digest"].clone()
        };
        assert_eq!(digest("shadow"), digest("ray"), "{uav}");
    }
}

/// Found by fuzzing: a file of 200 bytes that holds no block made 15 GiB of nodata before it was refused.
#[test]
fn a_tiff_without_any_block_takes_no_memory() {
    let folder = Folder::new();
    // Width, height, bits, compression, photometric, strip offset, samples, rows per strip, strip length, format.
    let names: [u16; 10] = [256, 257, 258, 259, 262, 273, 277, 278, 279, 339];
    let values: [u32; 10] = [268_435_471, 15, 32, 1, 1, 0, 1, 15, 0, 3];
    let mut bytes = b"II*\0\x08\0\0\0\x0a\0".to_vec();
    for (tag, value) in names.into_iter().zip(values) {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(4_u16.to_le_bytes());
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    std::fs::write(folder.join("sparse.tif"), bytes).unwrap();
    folder.refuses("map sparse.tif --uav 1,1,50amsl --json", "E305", &[]);
}

/// The engine of a city on terrain is that of its own cells: coarser receivers stand on other cells than the terrain's, so that
/// the sweep which decides the fine ones has no answer for them. It panicked.
#[test]
fn coarser_receivers_over_a_terrain_are_decided_by_an_engine_of_their_own() {
    let folder = Folder::new();
    let ground = |cell: usize| (cell / 200 * 7 + cell % 200 * 3) % 40 / 2;
    let heights: Vec<String> = (0..200 * 200).map(|cell| ground(cell).to_string()).collect();
    let head = "ncols 200\nnrows 200\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n";
    folder.write("terrain.asc", &format!("{head}{}\n", heights.join(" ")));
    let house = |k: i32| {
        let (west, south) = (20 + 45 * (k % 4), 20 + 45 * (k / 4));
        ([west, south, west + 20, south + 20], 15 + 3 * (k % 4))
    };
    folder.write("houses.geojson", &collection((0..16).map(house)));
    let line = "plos houses.geojson --terrain terrain.asc --extent 0,0,200,200 --cell 1 --height 60 --positions 9 \
                --theta 40:60:20 --method maps --json";
    let p_los = |document: &Value| -> Vec<f64> {
        let rows = document["rows"].as_array().unwrap();
        rows.iter().map(|row| row["p_los"].as_f64().unwrap()).collect()
    };
    let exact = folder.type_in(line).done().json();
    assert_eq!(exact["real_cities"][0]["engine"], "shadow+sweep", "{exact}");
    let coarse = folder.type_in(&format!("{line} --tolerance 0.1")).done().json();
    assert_eq!(coarse["real_cities"][0]["engine"], "shadow+ray", "{coarse}");
    let (exact, coarse) = (p_los(&exact), p_los(&coarse));
    assert!(exact != coarse && exact.iter().zip(&coarse).all(|(a, b)| (a - b).abs() <= 0.1), "{exact:?} {coarse:?}");
}
