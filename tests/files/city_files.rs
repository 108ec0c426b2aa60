//! City files as people have them: packed, in lines, in tiles, as CityGML. Each gives the city that it gives as one GeoJSON or CityJSON.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use crate::needs::truth;
use crate::program::Folder;

/// Digests of three maps of a scene.
fn digests(folder: &Folder, scene: &str, uavs: &[&str; 3]) -> Vec<String> {
    let digest = |uav: &&str| {
        let document = folder.type_in(&format!("map {scene} --uav {uav} --json")).done().json();
        document["digest"].as_str().unwrap_or_else(|| panic!("{document}")).to_string()
    };
    uavs.iter().map(digest).collect()
}

/// UAVs over the south-west of the middle of Munich.
const MUNICH: [&str; 3] = ["691600,5334700,60", "691700,5334600,35roof", "691650,5334650,120"];

#[test]
fn packed_and_lined_files_are_the_city_inside() {
    let Some(data) = truth() else { return };
    let folder = Folder::new();
    for name in ["m300.geojson", "m300.geojson.gz", "m300.geojsonl", "m300.zip", "m300_rs.geojsons", "z_shp.zip"] {
        fs::copy(data.join("formats/packed").join(name), folder.join(name)).unwrap();
    }
    // What no name tells, the first bytes do.
    fs::copy(folder.join("m300.zip"), folder.join("city.bin")).unwrap();
    fs::copy(folder.join("m300.geojsonl"), folder.join("lines")).unwrap();
    let options = "--crs EPSG:25832";
    let wanted = digests(&folder, &format!("m300.geojson {options}"), &MUNICH);
    assert!(wanted[0] != wanted[1] && wanted[1] != wanted[2]);
    for name in ["m300.geojson.gz", "m300.geojsonl", "m300.zip", "m300_rs.geojsons", "city.bin", "lines"] {
        assert_eq!(digests(&folder, &format!("{name} {options}"), &MUNICH), wanted, "{name}");
    }
}

/// Munich in four tiles, with a building that stands in two of them.
#[test]
fn tiles_are_one_city() {
    let folder = Folder::new();
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson")).unwrap();
    let whole: Value = serde_json::from_str(&text).unwrap();
    let features = whole["features"].as_array().unwrap();
    fs::create_dir(folder.join("tiles")).unwrap();
    let tile = |of: &[Value]| {
        let mut document = whole.clone();
        document["features"] = json!(of);
        document.to_string()
    };
    let n = features.len().div_ceil(4);
    let mut zip = zip::ZipWriter::new(fs::File::create(folder.join("tiles.zip")).unwrap());
    let mut names = Vec::new();
    for (k, of) in features.chunks(n).enumerate() {
        // The first of the next tile stands in this one, too.
        let mut of = of.to_vec();
        of.extend(features.get((k + 1) * n).cloned());
        let name = format!("tiles/t{k}.geojson");
        folder.write(&name, &tile(&of));
        zip.start_file(format!("deep/t{k}.geojson"), zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(tile(&of).as_bytes()).unwrap();
        names.push(name);
    }
    zip.finish().unwrap();
    folder.write("tiles/readme.txt", "tiles of Munich");
    folder.write("whole.geojson", &text);
    let uavs = ["691549.7,5334762.2,120", "691400,5334600,60", "691900,5334900,200"];
    let counts = |scene: &str| folder.type_in(&format!("info {scene} --json")).done().json()["buildings"].clone();
    let (wanted, of_whole) = (digests(&folder, "whole.geojson", &uavs), counts("whole.geojson"));
    for scene in ["tiles", "tiles.zip", &names.join("+")] {
        assert_eq!(digests(&folder, scene, &uavs), wanted, "{scene}");
        assert_eq!(counts(scene), of_whole, "{scene}");
    }
}

/// CityGML against what the reference reader makes of it as CityJSON.
#[test]
fn citygml_is_the_city_that_another_reader_finds() {
    let Some(data) = truth() else { return };
    let reader = data.join("../reference/citygml.py");
    if !crate::needs::has("truth", reader.is_file()) {
        return;
    }
    let folder = Folder::new();
    fs::create_dir(folder.join("out")).unwrap();
    for (name, options) in [
        ("nrw_LoD2_32_404_5746_one", ""),
        ("plateau_64413325_bldg_6697_op", "--project auto --missing median"),
        ("citygml4j_lod2_v3", ""),
        ("val3dity_dh_1", ""),
    ] {
        fs::copy(data.join(format!("formats/citygml/{name}.gml")), folder.join(&format!("{name}.gml"))).unwrap();
        let made = Command::new("python3").arg(&reader).arg(format!("{name}.gml")).current_dir(folder.path()).output();
        assert!(made.unwrap().status.success(), "{name}");
        for roofs in ["flat", "lod2"] {
            let scene = |file: &str| format!("{file} --roofs {roofs} {options}");
            let (gml, json) = (format!("{name}.gml"), format!("out/{name}.city.json"));
            let document = folder.type_in(&format!("info {} --json", scene(&json))).done().json();
            let extent: Vec<f64> = serde_json::from_value(document["extent"].clone()).unwrap();
            let at = |share: f64| {
                let of = |k: usize| extent[k] + share * (extent[k + 2] - extent[k]);
                (of(0), of(1))
            };
            let uavs = [(0.4, 40.0), (0.55, 90.0), (0.8, 200.0)].map(|(share, h)| {
                let (x, y) = at(share);
                format!("{x:.2},{y:.2},{h}agl")
            });
            let uavs = [uavs[0].as_str(), &uavs[1], &uavs[2]];
            assert_eq!(digests(&folder, &scene(&gml), &uavs), digests(&folder, &scene(&json), &uavs), "{name} {roofs}");
        }
    }
}
