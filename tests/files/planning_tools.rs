//! What planning tools and simulators take: raw grids, overlays for globes, meshes for ray tracers, boxes.

use std::io::{Cursor, Read};
use std::process::Command;

use serde_json::{Value, json};
use zip::ZipArchive;

use crate::masks::{MAP, mask_of, npy, tif, town};
use crate::mosaic::gdal;
use crate::needs::{has_program, python_with};
use crate::program::Folder;
use crate::support::read_png;

const SHAPE: [usize; 2] = [40, 60];

#[test]
fn a_bil_file_holds_the_numbers_of_the_geotiff_and_its_header_their_place() {
    let folder = town();
    folder.type_in(&format!("{MAP} -o m.bil -o m.tif -q")).done();
    assert_eq!(folder.files(), ["m.bil", "m.bil.json", "m.hdr", "m.prj", "m.tif", "m.tif.aux.xml", "town.geojson"]);
    assert_eq!(folder.read("m.bil"), mask_of(&folder, "m.tif"));
    let header = folder.text("m.hdr");
    for line in ["NROWS 40", "NCOLS 60", "NBITS 8", "ULXMAP 691600.5", "ULYMAP 5334789.5", "XDIM 1", "NODATA 255"] {
        assert!(header.lines().any(|l| l == line), "{line}: {header}");
    }
    assert!(folder.text("m.prj").contains("ETRS89"));
    assert_eq!(folder.json("m.bil.json")["schema"], "skyshed/map/1");
    folder.type_in(&format!("{MAP} --layers margin -o f.bil -o f.tif -q")).done();
    let floats: Vec<u8> =
        tif(&folder, "f.tif").read_raster::<f32>().unwrap().iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(folder.read("f.bil"), floats);
    folder.type_in(&format!("{MAP} --layers count -o c.bil -q")).done();
    assert_eq!(folder.read("c.bil").len(), 4 * SHAPE[0] * SHAPE[1]);
    if has_program("gdalinfo") {
        let told = |name: &str| -> Vec<String> {
            let is_told = |l: &&str| ["Checksum", "Origin", "Pixel Size", "NoData"].iter().any(|w| l.contains(w));
            let said = gdal(&folder, &format!("gdalinfo -checksum {name}"));
            said.lines().filter(is_told).map(|l| l.trim().to_string()).collect()
        };
        assert_eq!(told("m.bil").len(), 4);
        assert_eq!(told("m.bil"), told("m.tif"));
    }
    folder.refuses(&format!("{MAP} --layers los,margin -o two.bil"), "E107", &["two.bil"]);
}

#[test]
fn values_of_gdal_are_255_where_the_class_is_line_of_sight_and_0_elsewhere() {
    let folder = town();
    let near = format!("{MAP} --radius 30");
    folder.type_in(&format!("{near} -o classes.tif -q")).done();
    folder.type_in(&format!("{near} --gdal-values -o gdal.tif -o gdal.bil -q")).done();
    let classes = mask_of(&folder, "classes.tif");
    assert!([0, 1, 2, 3].iter().all(|class| classes.contains(class)));
    let wanted: Vec<u8> = classes.iter().map(|class| if *class == 1 { 255 } else { 0 }).collect();
    assert_eq!(mask_of(&folder, "gdal.tif"), wanted);
    assert_eq!(folder.read("gdal.bil"), wanted);
    let file = tif(&folder, "gdal.tif");
    assert_eq!((file.nodata(), file.band_count(), file.epsg()), (None, 1, Some(25832)));
    assert!(file.tiff().ifd(0).unwrap().tag(320).is_none(), "no color table");
    assert!(!folder.files().contains(&"gdal.tif.aux.xml".to_string()), "no names of classes");
    assert!(!folder.text("gdal.hdr").contains("NODATA"));
    for (words, code) in
        [("-o a.png", "E116"), ("--layers margin -o a.tif", "E107"), ("--uav 691650,5334780,60 -o a.tif", "E107")]
    {
        folder.refuses(&format!("{MAP} --gdal-values {words}"), code, &["`--gdal-values`"]);
    }
}

#[test]
fn an_npz_names_its_sites_and_its_reference_system() {
    let folder = town();
    folder.type_in(&format!("{MAP} --uav 691650,5334780,60 -o m.npz -q")).done();
    let strings = |name: &str| {
        let (header, text) = npy(&folder, "m.npz", name);
        let letters = text.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        (header, letters.filter_map(char::from_u32).collect::<String>())
    };
    let (header, ids) = strings("site_ids");
    assert!(header.contains("'<U1'") && header.contains("(2,)") && ids == "12", "{header} {ids}");
    let (header, crs) = strings("crs");
    assert!(header.contains("'shape': ()") && crs.contains("ETRS89 / UTM zone 32N"), "{header} {crs}");
    assert_eq!(serde_json::from_str::<Value>(&strings("meta").1).unwrap()["schema"], "skyshed/map/1");
}

fn n_elements(xml: &str, name: &str) -> usize {
    let document = roxmltree::Document::parse(xml).unwrap();
    document.descendants().filter(|node| node.tag_name().name() == name).count()
}

fn kmz(folder: &Folder, name: &str) -> ZipArchive<Cursor<Vec<u8>>> {
    ZipArchive::new(Cursor::new(folder.read(name))).unwrap()
}

fn file_of(folder: &Folder, archive: &str, name: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    kmz(folder, archive).by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

fn document(folder: &Folder, archive: &str) -> String {
    String::from_utf8(file_of(folder, archive, "doc.kml")).unwrap()
}

fn number(kml: &str, element: &str) -> f64 {
    let (_, rest) = kml.split_once(&format!("<{element}>")).unwrap();
    rest.split_once('<').unwrap().0.parse().unwrap()
}

/// Places of the town and their longitude and latitude, by PROJ 9:
/// `Transformer.from_crs(25832, 4326, always_xy=True).transform(x, y)` of pyproj 3.7.2.
const CORNERS: [[f64; 2]; 4] = [
    [11.575445778753924, 48.13713100010407],
    [11.576251440283942, 48.13711293224713],
    [11.576269438605852, 48.13747244687511],
    [11.57546377146246, 48.13749051495865],
];
/// Row and column of a cell, and its center likewise.
const CENTERS: [([usize; 2], [f64; 2]); 6] = [
    ([4, 5], [11.575535600061759, 48.13744841353514]),
    ([4, 25], [11.575804155629605, 48.137442391303644]),
    ([22, 15], [11.575661780459528, 48.137283620841565]),
    ([26, 37], [11.575955390986916, 48.137241044573415]),
    ([9, 55], [11.576204739064224, 48.137388417451426]),
    ([32, 23], [11.575764703632554, 48.13719133321965]),
];

#[test]
fn an_overlay_lies_where_proj_says() {
    let folder = town();
    folder.type_in(&format!("{MAP} -o m.kmz -o m.tif -q")).done();
    let names: Vec<String> = kmz(&folder, "m.kmz").file_names().map(|n| n.unwrap().into_owned()).collect();
    assert_eq!(names, ["doc.kml", "overlay-1.png", "legend.png"]);
    let kml = document(&folder, "m.kmz");
    for element in ["GroundOverlay", "ScreenOverlay", "Placemark", "Data"] {
        assert_eq!(n_elements(&kml, element), 1, "{element}");
    }
    assert!(kml.contains("<altitudeMode>relativeToGround</altitudeMode>") && kml.contains("UAV 1"));
    // The legend has its own size, and the colors of the overlay beside words.
    assert!(kml.contains("<Icon><href>legend.png</href></Icon>") && kml.contains("<size x=\"-1\" y=\"-1\""));
    let legend = read_png(&file_of(&folder, "m.kmz", "legend.png")).to_rgb8();
    for color in [[0x00, 0x72, 0xB2], [0xE6, 0x9F, 0x00]] {
        assert!(legend.pixels().any(|pixel| pixel.0 == color), "{color:?}");
    }

    let overlay = read_png(&file_of(&folder, "m.kmz", "overlay-1.png")).to_rgba8();
    let [width, height] = [overlay.width(), overlay.height()].map(f64::from);
    let [west, south, east, north] = ["west", "south", "east", "north"].map(|e| number(&kml, e));
    let pixel = [(east - west) / width, (north - south) / height];
    // A pixel is about as large as a cell of 1 m: a degree of latitude has 111.2 km.
    assert!((pixel[1] * 111_200.0 - 1.0).abs() < 0.05, "{pixel:?}");
    let extreme = |k: usize, most: fn(f64, f64) -> f64| CORNERS.iter().map(|c| c[k]).reduce(most).unwrap();
    for (found, wanted, k) in [
        (west, extreme(0, f64::min), 0),
        (south, extreme(1, f64::min), 1),
        (east, extreme(0, f64::max), 0),
        (north, extreme(1, f64::max), 1),
    ] {
        assert!((found - wanted).abs() < pixel[k] / 2.0, "{found} for {wanted}");
    }
    // The pixel at a cell's center has the color of the cell or of a neighbor; the places are amid cells of one class.
    let mask = mask_of(&folder, "m.tif");
    let mut colors = Vec::new();
    for ([row, col], [lon, lat]) in CENTERS {
        let class = mask[row * SHAPE[1] + col];
        for neighbor in [row - 1, row + 1].map(|r| r * SHAPE[1] + col).into_iter().chain([row * SHAPE[1] + col - 1]) {
            assert_eq!(mask[neighbor], class, "row {row}, column {col}");
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the picture")]
        let rgba = overlay.get_pixel(((lon - west) / pixel[0]) as u32, ((north - lat) / pixel[1]) as u32).0;
        match class {
            0 => assert_eq!(rgba, [0xE6, 0x9F, 0x00, 255]),
            1 => assert_eq!(rgba, [0x00, 0x72, 0xB2, 255]),
            _ => assert_eq!(rgba[3], 0),
        }
        colors.push(class);
    }
    assert!([0, 1, 2].iter().all(|class| colors.contains(class)), "{colors:?}");
    if has_program("gdalinfo") {
        let said = gdal(&folder, "gdalinfo m.kmz");
        assert!(said.contains("WGS 84") && said.contains(&format!("Size is {width}, {height}")), "{said}");
    }
}

#[test]
fn several_uavs_are_an_overlay_each_below_one_of_all() {
    let folder = town();
    folder.type_in(&format!("{MAP} --uav 691650,5334780,60 -o m.kmz -q")).done();
    let kml = document(&folder, "m.kmz");
    assert_eq!(n_elements(&kml, "GroundOverlay"), 3);
    let visible: Vec<&str> = kml.split("<visibility>").skip(1).map(|rest| &rest[..1]).collect();
    assert_eq!(visible, ["1", "0", "0"]);
    assert!(kml.contains("Seen by at least one UAV: P_LoS ") && kml.contains("Seen by UAV 2: P_LoS "));
    assert_eq!(kmz(&folder, "m.kmz").len(), 5);
    let local = "map itu:urban --size 100 --uav 5,5,50 -o m.kmz --overwrite";
    folder.refuses(local, "E109", &["m.kmz", "--crs EPSG:N"]);
    folder.refuses(&format!("{MAP} --layers margin -o n.kmz"), "E107", &["n.kmz"]);
}

/// Corners and triangles of a PLY file.
fn ply(bytes: &[u8]) -> (Vec<[f32; 3]>, Vec<[usize; 3]>) {
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
    let n = |element: &str| -> usize {
        let line = header.lines().find_map(|l| l.strip_prefix(&format!("element {element} "))).unwrap();
        line.parse().unwrap()
    };
    let four = |b: &[u8]| -> [u8; 4] { b.try_into().unwrap() };
    let (corners, faces) = bytes[end..].split_at(12 * n("vertex"));
    assert_eq!(faces.len(), 13 * n("face"));
    let corner = |b: &[u8]| [0, 4, 8].map(|k| f32::from_le_bytes(four(&b[k..k + 4])));
    let face = |b: &[u8]| {
        assert_eq!(b[0], 3);
        [1, 5, 9].map(|k| usize::try_from(i32::from_le_bytes(four(&b[k..k + 4]))).unwrap())
    };
    (corners.chunks_exact(12).map(corner).collect(), faces.chunks_exact(13).map(face).collect())
}

#[test]
fn a_mitsuba_scene_is_local_and_says_where_it_lies() {
    let folder = town();
    let town = "city town.geojson --extent 691600,5334750,691660,5334790";
    folder.type_in(&format!("{town} -o s.xml -q")).done();
    assert_eq!(folder.files(), ["s.xml", "s.xml.json", "s_buildings.ply", "s_ground.ply", "town.geojson"]);
    let xml = folder.text("s.xml");
    assert_eq!(n_elements(&xml, "shape"), 2);
    assert!(xml.contains("value=\"s_ground.ply\"") && xml.contains("id=\"mat-itu_concrete\""), "{xml}");
    assert!(xml.contains("the origin is (691600, 5334750) in EPSG:25832"), "{xml}");
    assert_eq!(folder.json("s.xml.json")["mesh"]["origin"], json!([691_600.0, 5_334_750.0]));
    let (corners, faces) = ply(&folder.read("s_ground.ply"));
    assert_eq!((corners, faces.len()), (vec![[0.0; 3], [60.0, 0.0, 0.0], [60.0, 40.0, 0.0], [0.0, 40.0, 0.0]], 2));
    let (corners, faces) = ply(&folder.read("s_buildings.ply"));
    // Two triangles per wall, and roofs of two and of one.
    assert_eq!(faces.len(), 2 * 4 + 2 + 2 * 3 + 1);
    for corner in [[10.0, 10.0, 20.0], [20.0, 25.0, 0.0], [45.0, 12.0, 9.5], [40.0, 20.0, 0.0]] {
        assert!(corners.contains(&corner), "{corner:?}");
    }
    assert!(faces.iter().flatten().all(|k| *k < corners.len()));
    // Upward faces are the roofs: as large as the footprints, 150 m² and half of 5 · 22 … by its cross product.
    let area = |face: &[usize; 3]| {
        let [a, b, c] = face.map(|k| corners[k]);
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
    };
    let roofs: f32 = faces.iter().map(area).sum();
    assert!((roofs - (150.0 + (15.0 * 15.0 - 7.0 * 10.0) / 2.0)).abs() < 1e-3, "{roofs}");
    folder.type_in(&format!("{town} -o t.tif -q")).done();
    folder.refuses("city t.tif --ground 0 -o t.xml", "E109", &["t.xml"]);
}

#[test]
fn a_ray_tracer_sees_the_same_receivers_through_the_meshes() {
    if !python_with("mitsuba") {
        return;
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/tools/mitsuba_agreement.py");
    let folder = Folder::new();
    for (city, uav) in [("itu:urban --size 500", "237,254,90"), ("itu:high-rise --size 400 --seed 3", "203,187,60agl")]
    {
        folder.type_in(&format!("city {city} -o c.xml -q --overwrite")).done();
        folder.type_in(&format!("map {city} --uav {uav} -o c.npz -q --overwrite")).done();
        let files = [script.to_string(), folder.word("c.xml"), folder.word("c.npz")];
        let output = Command::new("python3").args(files).output().unwrap();
        let found: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {output:?}"));
        assert!(found["receivers"].as_u64() > Some(50_000), "{found}");
        assert!(found["share"].as_f64() >= Some(0.9999), "{found}");
    }
}

#[test]
fn boxes_are_the_footprints_of_a_generated_city() {
    let folder = town();
    folder.type_in("city itu:urban --size 300 -o b.csv -o b.geojson -q").done();
    assert!(folder.files().contains(&"b.csv.json".to_string()));
    let text = folder.text("b.csv");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("xMin,xMax,yMin,yMax,zMin,zMax"));
    let document = folder.json("b.geojson");
    let features = document["features"].as_array().unwrap();
    assert_eq!(lines.clone().count(), features.len());
    for (line, feature) in lines.zip(features) {
        let found: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        let corners: Vec<[f64; 2]> = serde_json::from_value(feature["geometry"]["coordinates"][0].clone()).unwrap();
        let end = |k: usize, most: fn(f64, f64) -> f64| corners.iter().map(|c| c[k]).reduce(most).unwrap();
        let properties = &feature["properties"];
        let [ground, top] = ["ground", "z_top"].map(|name| properties[name].as_f64().unwrap());
        let wanted = [end(0, f64::min), end(0, f64::max), end(1, f64::min), end(1, f64::max), ground, top];
        // GeoJSON is written to a tenth of a millimeter.
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?} {wanted:?}");
    }
    folder.refuses("city town.geojson -o b2.csv", "E109", &["b2.csv", "1 of 2"]);
}
