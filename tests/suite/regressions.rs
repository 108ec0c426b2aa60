//! One test per bug, named after it, with the reduced input and a sentence of cause.

use serde_json::Value;
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

/// The integers of a link wrapped, and a walk over 10^12 m never ended.
#[test]
fn a_link_over_more_than_the_lattice_is_refused() {
    let folder = Folder::new();
    for receiver in ["70000,500", "1e9,500", "1e12,1e12", "-1e11,3e11"] {
        let answer = folder.type_in(&format!("link itu:urban --uav 500,500,100 --rx={receiver}"));
        assert!(answer.refused(4)[0].starts_with("error[E203]: cannot decide the link"), "{receiver}");
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
    let over = folder.type_in(&format!("map {scene} --uav 3.5,2.5,5amsl -o o.png"));
    assert!(over.refused(4)[0].contains("nodata cell, which blocks everything"));

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
        assert!(folder.type_in(city).refused(5)[0].starts_with("error[E502]"), "{city}");
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
    let hint = |uav: &str| folder.type_in(&format!("map town.geojson --uav {uav} -o o.png")).refused(4)[1].to_string();
    assert!(hint("5334765,691615,50").starts_with("hint: x and y are swapped"));
    assert!(hint("11.57,48.13,50").starts_with("hint: this looks like longitude and latitude"));
}

/// `link --radius`, `link --method`, `city --method`, `info -j` were refused, although every command takes them.
#[test]
fn every_command_takes_the_common_flags() {
    let folder = Folder::new();
    folder.type_in("link itu:urban --uav 10,10,50 --rx 10,60 --radius 100 -j 2 -q").done();
    folder.type_in("city itu:urban --size 100 -j 2 -q -o c.json").done();
    folder.type_in("info itu:urban --size 100 -j 2 --overwrite").done();
    let far = folder.type_in("link itu:urban --uav 10,10,50 --rx 10,60 --radius 20");
    assert!(far.refused(4)[0].starts_with("error[E208]"));
}

/// A title without a picture was lost in silence.
#[test]
fn words_for_a_picture_that_is_not_made_are_refused() {
    let folder = small();
    for line in [
        "map small.asc --ground 0 --uav 0.5,0.5,9 -o o.tif --title Title",
        "city small.asc --ground 0 -o o.tif --attribution Somebody",
    ] {
        assert!(
            folder.type_in(line).refused(2)[0].contains("has no meaning without a .png, .svg or .pdf output"),
            "{line}"
        );
    }
}

/// What a raster format cannot hold was refused after the rays had run, and in two places.
#[test]
fn layers_that_a_format_cannot_hold_are_refused() {
    let folder = small();
    let two = folder.type_in("map small.asc --ground 0 --uav 0.5,0.5,9 --uav 4.5,0.5,9 -o o.asc");
    assert_eq!(
        two.refused(2)[0],
        "error[E107]: cannot write o.asc: an ASCII grid holds one layer of one site, found 2"
    );
    folder.type_in("map small.asc --ground 0 --uav 0.5,0.5,9 --uav 4.5,0.5,9 --layers count -o o.asc").done();
}

/// Two joined houses shared two edges of one wall; one of them was dropped, the other hid an inner corner, and the five
/// houses cast one shadow that was not convex: the engine `shadow` let links through them.
#[test]
fn houses_of_equal_height_around_an_inner_corner_cast_their_whole_shadow() {
    let folder = Folder::new();
    let house = |[x0, y0, x1, y1]: [f64; 4]| {
        format!(
            r#"{{"type":"Feature","properties":{{"height":4}},"geometry":{{"type":"Polygon",
            "coordinates":[[[{x0},{y0}],[{x1},{y0}],[{x1},{y1}],[{x0},{y1}],[{x0},{y0}]]]}}}}"#
        )
    };
    let houses = [[4, 4, 5, 6], [4, 6, 5, 7], [5, 4, 6, 6], [5, 6, 6, 7], [6, 4, 8, 6]];
    let houses: Vec<String> = houses.iter().map(|h| house(h.map(f64::from))).collect();
    let collection = format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, houses.join(","));
    folder.write("houses.geojson", &collection);
    for uav in ["10.5,0.5,6", "1.5,0.5,5", "11.5,5.5,9", "7.25,8.5,3"] {
        let digest = |method: &str| {
            let line =
                format!("map houses.geojson --extent 0,0,12,12 --cell 0.25 --uav {uav} --method {method} --json");
            folder.type_in(&line).done().json()["digest"].clone()
        };
        assert_eq!(digest("shadow"), digest("ray"), "{uav}");
    }
}

/// Found by fuzzing: a file of 200 bytes that holds no block made 15 GiB of nodata before it was refused.
#[test]
fn a_tiff_without_any_block_takes_no_memory() {
    let folder = Folder::new();
    // Width, height, bits, compression, photometric, strip offset, samples, rows per strip, strip length, format.
    let tags: [(u16, u32); 10] = [
        (256, 268_435_471),
        (257, 15),
        (258, 32),
        (259, 1),
        (262, 1),
        (273, 0),
        (277, 1),
        (278, 15),
        (279, 0),
        (339, 3),
    ];
    let mut bytes = b"II*\0\x08\0\0\0\x0a\0".to_vec();
    for (tag, value) in tags {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(4_u16.to_le_bytes());
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    std::fs::write(folder.join("sparse.tif"), bytes).unwrap();
    let answer = folder.type_in("map sparse.tif --uav 1,1,50amsl --json");
    assert!(answer.refused(3)[0].starts_with("error[E305]"), "{}", answer.err);
}

/// The engine of a city on terrain is that of its own cells: coarser receivers stand on other cells than the terrain's, so that
/// the sweep which decides the fine ones has no answer for them. It panicked.
#[test]
fn coarser_receivers_over_a_terrain_are_decided_by_an_engine_of_their_own() {
    let folder = Folder::new();
    let rows: Vec<String> = (0..200)
        .map(|row| (0..200).map(|col| ((row * 7 + col * 3) % 40 / 2).to_string()).collect::<Vec<_>>().join(" "))
        .collect();
    let head = "ncols 200\nnrows 200\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n";
    folder.write("terrain.asc", &format!("{head}{}\n", rows.join("\n")));
    let house = |k: i32| {
        let (w, s) = (20 + 45 * (k % 4), 20 + 45 * (k / 4));
        let (e, n) = (w + 20, s + 20);
        format!(
            r#"{{"type":"Feature","properties":{{"height":{}}},"geometry":{{"type":"Polygon","coordinates":[[[{w},{s}],[{e},{s}],[{e},{n}],[{w},{n}],[{w},{s}]]]}}}}"#,
            15 + 3 * (k % 4)
        )
    };
    let houses = (0..16).map(house).collect::<Vec<_>>().join(",");
    folder.write("houses.geojson", &format!(r#"{{"type":"FeatureCollection","features":[{houses}]}}"#));
    let line = "plos houses.geojson --terrain terrain.asc --extent 0,0,200,200 --cell 1 --height 60 --positions 9 --theta 40:60:20 \
                --method maps --json";
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
