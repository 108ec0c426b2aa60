//! City files as people have them: packed, in lines, in tiles, as CityGML. Each gives the city that it gives as one GeoJSON or CityJSON.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Command;

use parquet::basic::Compression;
use serde_json::{Value, json};

use crate::city_formats::{cadastre, citygml, write_geoparquet};
use crate::needs::truth;
use crate::program::Folder;
use crate::vector_files::{
    Building, EAST, NORTH, city, write_cityjson, write_flatgeobuf, write_geojson, write_shapefile,
};

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
        // The reader does not say that its parts are one building, whose base is that of the lowest.
        ("val3dity_dh_1", "--ground 5.9"),
        ("b1_lod2_s", "--crs EPSG:25832"),
        ("FZK_LoD0", ""),
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
            let uavs = [(0.4, 160.0), (0.55, 190.0), (0.8, 300.0)].map(|(share, h)| {
                let (x, y) = at(share);
                format!("{x:.2},{y:.2},{h}agl")
            });
            let uavs = [uavs[0].as_str(), &uavs[1], &uavs[2]];
            assert_eq!(digests(&folder, &scene(&gml), &uavs), digests(&folder, &scene(&json), &uavs), "{name} {roofs}");
        }
    }
}

/// Samples in lines, packed and in columns against the same city in one document.
#[test]
fn samples_are_the_city_of_their_plain_form() {
    let Some(data) = truth() else { return };
    let folder = Folder::new();
    let formats = data.join("formats");
    for name in [
        "cityjson/3dbag_b2.city.json",
        "cityjson/3dbag_b2.city.jsonl",
        "cityjson/3dbag_as_delivered.city.json",
        "packed/ms_120223332.csv.gz",
        "meaning/munich_ms_minus1.geojson",
    ] {
        fs::copy(formats.join(name), folder.join(name.rsplit_once('/').unwrap().1)).unwrap();
    }
    // As 3DBAG delivers it.
    let delivered = folder.read("3dbag_as_delivered.city.json");
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packed.write_all(&delivered).unwrap();
    fs::write(folder.join("8-760-72.city.json.gz"), packed.finish().unwrap()).unwrap();
    // Lines without an extension that tells anything.
    let mut lines = Vec::new();
    std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(&folder.read("ms_120223332.csv.gz")[..]), &mut lines)
        .unwrap();
    let features: Vec<Value> =
        String::from_utf8(lines).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    folder.write("ms.geojson", &json!({"type": "FeatureCollection", "features": features}).to_string());
    for (one, other, options) in [
        ("3dbag_b2.city.jsonl", "3dbag_b2.city.json", "--roofs lod2"),
        ("8-760-72.city.json.gz", "3dbag_as_delivered.city.json", "--roofs lod2"),
        ("ms_120223332.csv.gz", "ms.geojson", "--project auto --missing median"),
    ] {
        let (one, other) = (format!("{one} {options}"), format!("{other} {options}"));
        let uavs = above(&folder, &other);
        let uavs = [&*uavs[0], &*uavs[1], &*uavs[2]];
        assert_eq!(digests(&folder, &one, &uavs), digests(&folder, &other, &uavs), "{one}");
    }
}

/// Three UAVs over a scene.
fn above(folder: &Folder, scene: &str) -> [String; 3] {
    let document = folder.type_in(&format!("info {scene} --json -q")).done().json();
    let extent: Vec<f64> = serde_json::from_value(document["extent"].clone()).unwrap();
    let at = |share: f64, k: usize| extent[k] + share * (extent[k + 2] - extent[k]);
    [(0.4, 60.0), (0.55, 90.0), (0.8, 200.0)]
        .map(|(share, h)| format!("{:.2},{:.2},{h}agl", at(share, 0), at(share, 1)))
}

#[test]
fn the_first_bytes_tell_the_format_whatever_the_name_says() {
    let (folder, city) = (Folder::new(), city());
    write_geojson(&folder.join("a.geojson"), &city);
    write_flatgeobuf(&folder.join("c.fgb"), &city, true);
    write_cityjson(&folder.join("f.city.json"), &city, "2.0");
    folder.write("g.gml", &citygml(&city, 2));
    write_geoparquet(&folder.join("p.parquet"), &city, Compression::SNAPPY, 2);
    folder.type_in("city itu:urban --size 60 -o h.tif -o h.asc").done();
    let facts = |name: &str| {
        let document = folder.type_in(&format!("info {name} --json -q")).done().json();
        (
            document["format"].as_str().unwrap().to_string(),
            document["extent"].to_string(),
            document["cells"].to_string(),
        )
    };
    for (name, other, format) in [
        ("a.geojson", "a.tif", "GeoJSON"),
        ("c.fgb", "c", "FlatGeobuf"),
        ("f.city.json", "f.xml", "CityJSON"),
        ("g.gml", "g.geojson", "CityGML"),
        ("p.parquet", "p.asc", "GeoParquet"),
        ("h.tif", "h.geojson", "GeoTIFF"),
        ("h.asc", "h.gpkg", "Esri ASCII grid"),
    ] {
        let of_name = facts(name);
        fs::copy(folder.join(name), folder.join(other)).unwrap();
        assert_eq!((&*of_name.0, facts(other)), (format, of_name.clone()), "{name}");
    }
}

#[test]
fn what_is_no_scene_is_counted_and_two_formats_are_refused() {
    let (folder, city) = (Folder::new(), city());
    fs::create_dir(folder.join("tiles")).unwrap();
    write_geojson(&folder.join("tiles/a.geojson"), &city[..2]);
    write_geojson(&folder.join("tiles/b.geojson"), &city[2..]);
    folder.write("tiles/c.bin", "\u{1}\u{2}\u{3}");
    let info = folder.type_in("info tiles");
    assert!(info.err.contains("warning[W383]: tiles: a scene of 2 files; 1 others left out"), "{}", info.err);
    assert!(info.out.contains("format     GeoJSON, 2 files"), "{}", info.out);
    write_flatgeobuf(&folder.join("tiles/d.fgb"), &city, true);
    folder.refuses("info tiles", "E302", &["FlatGeobuf", "GeoJSON", "wanted files of one format"]);
    // A name with a plus is one file, if there is one.
    write_geojson(&folder.join("a+b.geojson"), &city);
    let buildings = |scene: &str| folder.type_in(&format!("info {scene} --json -q")).done().json()["buildings"].clone();
    assert_eq!(buildings("a+b.geojson"), 3);
    // What is alike in all it has counts once.
    assert_eq!(buildings("tiles/a.geojson+a+b.geojson"), 3);
    folder.refuses("info tiles/a.geojson+x.geojson", "E301", &["x.geojson"]);
    // No output may replace a part.
    folder.refuses(
        "map tiles/a.geojson+tiles/b.geojson --uav 691044,5334030,45 -o tiles/b.geojson --overwrite",
        "E105",
        &["tiles/b.geojson"],
    );
}

#[test]
fn tiles_beyond_the_extent_are_left_unread() {
    let (folder, city) = (Folder::new(), city());
    let far: Vec<Building> = city.iter().map(|b| moved(b, 900_000.0)).collect();
    let envelope = |x: f64| {
        format!(
            "<gml:boundedBy><gml:Envelope srsName=\"EPSG:25832\"><gml:lowerCorner>{} {NORTH} 0</gml:lowerCorner>\
             <gml:upperCorner>{} {} 30</gml:upperCorner></gml:Envelope></gml:boundedBy>",
            EAST + x,
            EAST + x + 100.0,
            NORTH + 100.0
        )
    };
    let with = |text: String, x: f64| text.replacen('\n', "", 1).replacen("\n", &format!("{}\n", envelope(x)), 1);
    // All that follows the envelope may be broken, since it is not read.
    folder.write("near.gml", &with(citygml(&city, 2), 0.0));
    let broken = with(citygml(&far, 2), 900_000.0).replace("</core:CityModel>", "<");
    folder.write("far.gml", &broken);
    write_shapefile(&folder.join("near.shp"), &city);
    write_shapefile(&folder.join("far.shp"), &far);
    fs::write(folder.join("far.dbf"), "").unwrap();
    let extent = format!("--extent {EAST},{NORTH},{},{}", EAST + 80.0, NORTH + 80.0);
    let uav = format!("--uav {},{},45", EAST + 44.0, NORTH + 30.0);
    for kind in ["gml", "shp"] {
        let alone = folder.type_in(&format!("map near.{kind} {extent} {uav} --json -q")).done().json();
        let both = folder.type_in(&format!("map near.{kind}+far.{kind} {extent} {uav} --json")).done();
        assert_eq!(both.json()["digest"], alone["digest"]);
        assert!(
            both.err.contains("[W383]") && both.err.contains("1 outside of the extent left unread"),
            "{}",
            both.err
        );
        assert_eq!(folder.type_in(&format!("info near.{kind}+far.{kind}")).code(), 3);
    }
}

#[test]
fn an_extent_prunes_a_projected_scene_and_changes_nothing() {
    let (folder, city) = (Folder::new(), city());
    let far: Vec<Building> = city.iter().map(|b| moved(b, 200_000.0)).collect();
    let all = [city, far].concat();
    write_flatgeobuf(&folder.join("a.fgb"), &all, true);
    write_flatgeobuf(&folder.join("b.fgb"), &all, false);
    write_geojson(&folder.join("c.geojson"), &all);
    write_geoparquet(&folder.join("d.parquet"), &all, Compression::SNAPPY, 3);
    let to = "--project EPSG:25833";
    let whole = folder.type_in(&format!("info c.geojson {to} --cell 100 --json -q")).done().json();
    let (x, y) = (whole["extent"][0].as_f64().unwrap(), whole["extent"][1].as_f64().unwrap());
    let scene = |name: &str| format!("{name} {to} --extent {:.0},{:.0},{:.0},{:.0}", x, y, x + 4000.0, y + 4000.0);
    let uavs = [(500.0, 500.0, 90.0), (1500.0, 2500.0, 60.0), (3000.0, 3900.0, 250.0)];
    let uavs = uavs.map(|(dx, dy, h)| format!("{:.0},{:.0},{h}", x + dx, y + dy));
    let uavs = [&*uavs[0], &*uavs[1], &*uavs[2]];
    let wanted = digests(&folder, &scene("c.geojson"), &uavs);
    for name in ["a.fgb", "b.fgb", "d.parquet"] {
        assert_eq!(digests(&folder, &scene(name), &uavs), wanted, "{name}");
    }
}

/// A building that stands farther east.
fn moved(building: &Building, by: f64) -> Building {
    let shift = |ring: &Vec<[f64; 2]>| ring.iter().map(|[x, y]| [x + by, *y]).collect();
    let polygons = building.polygons.iter().map(|rings| rings.iter().map(shift).collect()).collect();
    Building { polygons, ..building.clone() }
}

#[test]
fn storeys_of_a_cadastre_and_texts_in_latin_1_are_read() {
    let (folder, city) = (Folder::new(), city());
    fs::write(folder.join("parts.gml"), cadastre(&city, &[4, 2, 3])).unwrap();
    let document = folder.type_in("info parts.gml --missing levels --json -q").done().json();
    assert_eq!((&document["buildings"], &document["surface_m"]), (&json!(4), &json!([0.0, 12.0])), "{document}");
    // An attribute in an encoding of one byte for each character.
    let text = citygml(&city, 2).replace("UTF-8", "ISO-8859-1");
    let named = text.replace("gml:id=\"b0\">", "gml:id=\"b0\"><gml:name>Caf\u{e9}</gml:name>");
    let bytes: Vec<u8> = named.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    folder.write("plain.gml", &citygml(&city, 2));
    fs::write(folder.join("latin.gml"), bytes).unwrap();
    let uavs = above(&folder, "plain.gml");
    let uavs = [&*uavs[0], &*uavs[1], &*uavs[2]];
    assert_eq!(digests(&folder, "latin.gml", &uavs), digests(&folder, "plain.gml", &uavs));
}

/// Numbers of positions in the order that a name of a reference system promises.
#[test]
fn axes_follow_the_name_of_the_system_and_can_be_exchanged() {
    let (folder, city) = (Folder::new(), city());
    let plain = citygml(&city, 2);
    let named = |name: &str| plain.replace("EPSG:25832", name);
    let exchanged = |text: &str| {
        let mut parts = text.split("<gml:posList>");
        let mut made = parts.next().unwrap().to_string();
        for part in parts {
            let (numbers, rest) = part.split_once('<').unwrap();
            let numbers: Vec<&str> = numbers.split(' ').collect();
            let moved: Vec<String> = numbers.chunks(3).map(|p| format!("{} {} {}", p[1], p[0], p[2])).collect();
            made += &format!("<gml:posList>{}<{rest}", moved.join(" "));
        }
        made
    };
    // The zone of Gauß and Krüger whose authority puts the northing first.
    let eastings = plain.replace("EPSG:25832", "EPSG:31468");
    let shifted = |text: &str| text.replace(" 5334", " 5333").replace(">691", ">4469").replace(" 691", " 4469");
    let eastings = shifted(&eastings);
    folder.write("plain.gml", &eastings);
    let extent = |name: &str| folder.type_in(&format!("info {name} --json -q")).done().json()["extent"].clone();
    let wanted = extent("plain.gml");
    let formal = exchanged(&eastings).replace("EPSG:31468", "urn:ogc:def:crs:EPSG::31468");
    folder.write("formal.gml", &formal);
    assert_eq!(extent("formal.gml"), wanted);
    let said = folder.type_in("info formal.gml").done().err;
    assert!(said.contains("[W384]") && said.contains("northing, easting") && said.contains("--swap-axes"), "{said}");
    // What writes the easting first in spite of its name lies nowhere else.
    let helsinki = eastings.replace(" 5333", " 6672").replace("4469", "25496").replace("EPSG:31468", "EPSG:3879");
    folder.write("helsinki.gml", &helsinki);
    folder.write("wrong.gml", &helsinki.replace("EPSG:3879", "http://www.opengis.net/def/crs/EPSG/0/3879"));
    assert_eq!(extent("wrong.gml"), extent("helsinki.gml"));
    folder.write("compound.gml", &named("urn:ogc:def:crs,crs:EPSG:6.12:25832,crs:EPSG:6.12:5783"));
    folder.write("adv.gml", &named("urn:adv:crs:ETRS89_UTM32*DE_DHHN2016_NH"));
    folder.write("utm.gml", &plain);
    assert_eq!(extent("compound.gml"), extent("utm.gml"));
    assert_eq!(extent("adv.gml"), extent("utm.gml"));
    folder.write("swapped.gml", &exchanged(&plain));
    assert_eq!(extent("swapped.gml --swap-axes"), extent("utm.gml"));
}
