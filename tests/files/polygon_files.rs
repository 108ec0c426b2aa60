//! Coverage polygons: every cell center is inside exactly the polygons of its class, areas are those of cells, holes stay.

use std::collections::BTreeMap;
use std::process::Command;

use flatgeobuf::{ColumnType, FallibleStreamingIterator, FeatureProperties, FgbReader};
use serde_json::Value;

use crate::masks::tif;
use crate::mosaic::gdal;
use crate::needs::{has_program, python_with};
use crate::program::Folder;
use crate::rings::{Ring, area, rings};

/// A block with a yard, so that polygons have holes and parts within holes.
const YARD: &str = r#"{"type": "FeatureCollection",
  "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}, "features": [
  {"type": "Feature", "properties": {"height": 20}, "geometry": {"type": "Polygon",
   "coordinates": [[[691610,5334760],[691630,5334760],[691630,5334780],[691610,5334780],[691610,5334760]],
                   [[691616,5334766],[691624,5334766],[691624,5334774],[691616,5334774],[691616,5334766]]]}},
  {"type": "Feature", "properties": {"height": 9.5}, "geometry": {"type": "Polygon",
   "coordinates": [[[691638,5334755],[691651,5334762],[691648,5334770],[691638,5334755]]]}}]}"#;
const MAP: &str = "map yard.geojson --extent 691600,5334750,691660,5334790 --uav 691605,5334755,40";
const SHAPE: [usize; 2] = [40, 60];

fn yard() -> Folder {
    let folder = Folder::new();
    folder.write("yard.geojson", YARD);
    folder
}

fn masks(folder: &Folder, name: &str, n: usize) -> Vec<Vec<u8>> {
    let file = tif(folder, name);
    (0..n).map(|k| file.read_band::<u8>(k).unwrap().into_iter().collect()).collect()
}

fn features_of(document: &Value) -> &[Value] {
    document["features"].as_array().unwrap()
}

/// Whether a point is inside by the even-odd rule over all rings.
fn is_inside(rings: &[Ring], [x, y]: [f64; 2]) -> bool {
    let crosses = |e: &[[f64; 2]]| {
        (e[0][1] > y) != (e[1][1] > y) && x < e[0][0] + (y - e[0][1]) / (e[1][1] - e[0][1]) * (e[1][0] - e[0][0])
    };
    rings.iter().flat_map(|ring| ring.windows(2)).filter(|e| crosses(e)).count() % 2 == 1
}

#[test]
fn a_cell_is_inside_one_polygon_of_its_class_and_of_no_other() {
    let folder = yard();
    let two = format!("{MAP} --uav 691650,5334780,60");
    folder.type_in(&format!("{two} -o all.geojson --polygons all -o mask.tif -q")).done();
    let document = folder.json("all.geojson");
    assert_eq!(document["crs"]["properties"]["name"], "urn:ogc:def:crs:EPSG::25832");
    assert_eq!(document["skyshed"]["schema"], "skyshed/map/1");
    let features = features_of(&document);
    let masks = masks(&folder, "mask.tif", 2);
    for (site, mask) in ["1", "2"].iter().zip(&masks) {
        for (class, name) in [(0, "NLoS"), (1, "LoS")] {
            let is_meant = |f: &&Value| f["properties"]["site"] == *site && f["properties"]["class"] == name;
            let of_class: Vec<&Value> = features.iter().filter(is_meant).collect();
            for (cell, found) in mask.iter().enumerate() {
                let (row, col) = (cell / SHAPE[1], cell % SHAPE[1]);
                let center = [691_600.5 + col as f64, 5_334_789.5 - row as f64];
                let n_around = of_class.iter().filter(|f| is_inside(&rings(f), center)).count();
                assert_eq!(n_around, usize::from(*found == class), "site {site}, {name}, row {row}, column {col}");
            }
            for feature in of_class {
                let rings = rings(feature);
                let areas: Vec<f64> = rings.iter().map(area).collect();
                assert!(areas[0] > 0.0 && areas[1..].iter().all(|hole| *hole < 0.0), "{areas:?}");
                let told = ["cells", "area_m2"].map(|name| feature["properties"][name].as_f64());
                assert_eq!(told, [Some(areas.iter().sum::<f64>()); 2]);
            }
        }
    }
    // A small building with its shadow is a hole of what the second one sees.
    assert!(features.iter().any(|f| rings(f).len() > 1));
    // One class alone is that class.
    folder.type_in(&format!("{two} -o los.geojson --polygons los -q")).done();
    let los: Vec<Value> = features.iter().filter(|f| f["properties"]["class"] == "LoS").cloned().collect();
    assert_eq!(features_of(&folder.json("los.geojson")), los);
    folder.type_in(&format!("{two} -o nlos.geojson --polygons nlos -q")).done();
    assert_eq!(features_of(&folder.json("nlos.geojson")).len(), features.len() - los.len());
}

#[test]
fn flatgeobuf_holds_the_same_polygons() {
    let folder = yard();
    folder.type_in(&format!("{MAP} -o all.geojson -o all.fgb --polygons all -q")).done();
    let document = folder.json("all.geojson");
    let of_feature =
        |f: &Value| (f["properties"]["class"].as_str().unwrap().to_string(), f["properties"]["cells"].to_string());
    let mut wanted: Vec<(String, String)> = features_of(&document).iter().map(of_feature).collect();
    let bytes = folder.read("all.fgb");
    let reader = FgbReader::open(bytes.as_slice()).unwrap();
    assert_eq!(reader.header().crs().map(|crs| crs.code()), Some(25832));
    let metadata: Value = serde_json::from_str(reader.header().metadata().unwrap()).unwrap();
    assert_eq!(metadata["digest"], document["skyshed"]["digest"]);
    // The same columns, of the same types: numbers with decimals, whole ones, words.
    let columns = reader.header().columns().unwrap();
    let kinds = columns.iter().map(|column| (column.name().to_string(), column.type_()));
    let of_json = document["features"][0]["properties"].as_object().unwrap().iter().map(|(name, value)| {
        let kind = match value {
            Value::String(_) => ColumnType::String,
            Value::Number(n) if n.is_u64() => ColumnType::Long,
            _ => ColumnType::Double,
        };
        (name.clone(), kind)
    });
    assert_eq!(kinds.collect::<BTreeMap<_, _>>(), of_json.collect::<BTreeMap<_, _>>());
    let mut features = reader.select_all_seq().unwrap();
    let mut found = Vec::new();
    while let Some(feature) = features.next().unwrap() {
        let class = feature.property::<String>("class").unwrap();
        let cells = feature.property::<i64>("cells").unwrap();
        assert!((feature.property::<f64>("area_m2").unwrap() - cells as f64).abs() < 1e-9);
        found.push((class, cells.to_string()));
    }
    // The index orders them by place.
    found.sort();
    wanted.sort();
    assert_eq!(found, wanted);
    if has_program("ogrinfo") {
        for name in ["all.fgb", "all.geojson"] {
            let said = gdal(&folder, &format!("ogrinfo -so -al {name}"));
            assert!(said.contains(&format!("Feature Count: {}", wanted.len())), "{name}: {said}");
            assert!(said.contains("Geometry: Polygon") && said.contains("25832"), "{name}: {said}");
        }
    }
}

#[test]
fn simpler_outlines_stay_near_and_keep_parts_and_holes() {
    let folder = yard();
    let two = format!("{MAP} --uav 691650,5334780,60");
    folder.type_in(&format!("{two} -o exact.geojson --polygons all -q")).done();
    folder.type_in(&format!("{two} -o few.geojson --polygons all --simplify 1.5 -q")).done();
    let (exact, few) = (folder.json("exact.geojson"), folder.json("few.geojson"));
    let (exact, few) = (features_of(&exact), features_of(&few));
    let n = |features: &[Value]| features.iter().flat_map(rings).map(|ring| ring.len()).sum::<usize>();
    assert!(exact.iter().any(|f| rings(f).len() > 1), "there is a hole to keep");
    assert!(2 * n(few) < n(exact), "{} of {} positions", n(few), n(exact));
    assert_eq!(few.len(), exact.len());
    for (few, exact) in few.iter().zip(exact) {
        assert_eq!(few["properties"]["cells"], exact["properties"]["cells"]);
        let (few_rings, rings) = (rings(few), rings(exact));
        assert_eq!(few_rings.len(), rings.len());
        let areas: f64 = few_rings.iter().map(area).sum();
        assert!((few["properties"]["area_m2"].as_f64().unwrap() - areas).abs() < 1e-6);
        for (few, ring) in few_rings.iter().zip(&rings) {
            assert!(few.iter().all(|corner| ring.contains(corner)), "corners are kept, not made");
            for corner in ring {
                let near = few.windows(2).map(|e| distance(*corner, e[0], e[1])).fold(f64::INFINITY, f64::min);
                assert!(near <= 1.5 + 1e-9, "{near} m");
            }
        }
    }
}

fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let along = ((ab[0] * ap[0] + ab[1] * ap[1]) / (ab[0] * ab[0] + ab[1] * ab[1])).clamp(0.0, 1.0);
    (ap[0] - along * ab[0]).hypot(ap[1] - along * ab[1])
}

#[test]
fn geos_finds_every_polygon_valid() {
    if !python_with("shapely") {
        return;
    }
    // Some 700 polygons in real streets, up to a tolerance wider than those.
    let folder = Folder::new();
    let munich = concat!(env!("CARGO_MANIFEST_DIR"), "/maps/munich.geojson");
    let city = format!("map {munich} --top-field z_top --uav 691549.7,5334762.2,60");
    for simplify in ["", "--simplify 0.4", "--simplify 3", "--simplify 40"] {
        folder.type_in(&format!("{city} -o p.geojson --polygons all {simplify} -q --overwrite")).done();
        let code = "import json, sys; from shapely.geometry import shape; \
                    shapes = [shape(f['geometry']) for f in json.load(open(sys.argv[1]))['features']]; \
                    print(len(shapes), sum(not s.is_valid for s in shapes))";
        let output = Command::new("python3").args(["-c", code, &folder.word("p.geojson")]).output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        let counts: Vec<usize> = said.split_whitespace().map(|n| n.parse().unwrap()).collect();
        assert!(counts[0] > 100 && counts[1] == 0, "{simplify}: {said}");
    }
}

#[test]
fn polygons_without_a_file_for_them_are_refused() {
    let folder = yard();
    for (line, code, part) in [
        ("-o a.fgb", "E116", "a.fgb"),
        ("-o a.png --polygons los", "E116", "`--polygons`"),
        ("-o a.geojson --polygons los --simplify 0", "E113", "`0`"),
        ("-o a.geojson --simplify 2", "E101", "--polygons"),
        ("-o a.fgb --polygons los --layers margin", "E107", "a.fgb"),
    ] {
        folder.refuses(&format!("{MAP} {line}"), code, &[part]);
    }
    assert_eq!(folder.files(), ["yard.geojson"]);
}
