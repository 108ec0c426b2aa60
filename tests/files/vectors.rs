//! Vector data in: one city in every format is one scene, policies of heights, what is refused and how.

use std::path::Path;

use parquet::basic::{Compression, ZstdLevel};
use rusqlite::Connection;
use serde_json::{Value, json};
use skyshed_core::city::Solids;
use skyshed_core::quantity::height_steps;
use skyshed_io::read::{MeshOptions, read_mesh};

use crate::city_formats::{citygml, write_geoparquet};
use crate::mosaic::gdal;
use crate::needs::has_program;
use crate::program::Folder;
use crate::vector_files::{
    Building, EAST, NORTH, city, mesh_height, write_cityjson, write_flatgeobuf, write_geojson, write_geopackage,
    write_obj, write_ply, write_shapefile,
};

/// A map of a scene in the city's place.
fn map(folder: &Folder, scene: &str) -> Value {
    let uav = format!("{},{},45", EAST + 44.0, NORTH + 30.0);
    folder.type_in(&format!("map {scene} --uav {uav} --json -q")).done().json()
}

fn info(folder: &Folder, scene: &str) -> Value {
    folder.type_in(&format!("info {scene} --json -q")).done().json()
}

#[test]
fn one_city_in_every_format_is_one_scene() {
    let (folder, city) = (Folder::new(), city());
    write_geojson(&folder.join("a.geojson"), &city);
    write_shapefile(&folder.join("b.shp"), &city);
    write_flatgeobuf(&folder.join("c.fgb"), &city, true);
    write_flatgeobuf(&folder.join("d.fgb"), &city, false);
    write_geopackage(&folder.join("e.gpkg"), &[("buildings", &city)]);
    write_cityjson(&folder.join("f.city.json"), &city, "2.0");
    write_cityjson(&folder.join("g.json"), &city, "1.0");
    let of_geojson = map(&folder, "a.geojson");
    // The courtyard is open ground: 8 × 8 cells less those whose centers are on its edges, of which there is none.
    let cells = &info(&folder, "a.geojson")["cells"];
    assert_eq!(cells["building"], 26 * 26 - 8 * 8 + 9 * 9 + 6 * 6 + (24 * 8 + 10 * 24));
    for version in [1, 2, 3] {
        folder.write(&format!("h{version}.gml"), &citygml(&city, version));
    }
    write_geoparquet(&folder.join("i.parquet"), &city, Compression::SNAPPY, 2);
    write_geoparquet(&folder.join("j.parquet"), &city, Compression::ZSTD(ZstdLevel::default()), 1000);
    let surfaces = ["f.city.json", "g.json", "h1.gml", "h2.gml", "h3.gml"];
    for file in ["b.shp", "c.fgb", "d.fgb", "e.gpkg", "i.parquet", "j.parquet"].into_iter().chain(surfaces) {
        let of_file = map(&folder, file);
        assert_eq!(of_file["digest"], of_geojson["digest"], "{file}");
        assert_eq!(of_file["scene"]["crs"], "EPSG:25832", "{file}");
        assert_eq!(of_file["scene"]["sources"][0]["path"], file);
        let info = info(&folder, file);
        let found = [&info["buildings"], &info["faults"]["missing_height"], &info["faults"]["repaired"]];
        assert_eq!(found, [3, 0, 0], "{file}: {info}");
    }
    // The program leaves nothing beside a database.
    assert!(!folder.files().iter().any(|f| f.contains("-wal") || f.contains("-shm") || f.contains("-journal")));
}

#[test]
fn files_that_gdal_writes_are_the_scene_that_they_were_made_from() {
    if !has_program("ogr2ogr") {
        return;
    }
    let folder = Folder::new();
    let munich = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    std::fs::copy(munich, folder.join("munich.geojson")).unwrap();
    let map = |scene: &str| {
        let line = format!("map {scene} --uav 691549.7,5334762.2,120 --cell 4 --json -q");
        folder.type_in(&line).done().json()
    };
    let of_geojson = map("munich.geojson");
    for file in ["munich.shp", "munich.fgb", "munich.gpkg"] {
        gdal(&folder, &format!("ogr2ogr {file} munich.geojson"));
        let of_file = map(file);
        assert_eq!(of_file["scene"]["crs"], of_geojson["scene"]["crs"], "{file}");
        for key in ["digest", "sites"] {
            assert_eq!(of_file[key], of_geojson[key], "{file}");
        }
    }
}

#[test]
fn an_extent_reads_only_what_can_cast_a_shadow_into_it() {
    let folder = Folder::new();
    let moved = |by: f64| {
        let city = city().into_iter().map(|b| {
            let shift = |ring: &Vec<[f64; 2]>| ring.iter().map(|[x, y]| [x + by, *y]).collect();
            let polygons = b.polygons.iter().map(|rings| rings.iter().map(shift).collect()).collect();
            Building { polygons, ..b }
        });
        city.collect::<Vec<_>>()
    };
    let all = [city(), moved(60_000.0), moved(200_000.0)].concat();
    write_flatgeobuf(&folder.join("indexed.fgb"), &all, true);
    write_flatgeobuf(&folder.join("plain.fgb"), &all, false);
    let extent = format!("--extent {EAST},{NORTH},{},{}", EAST + 80.0, NORTH + 80.0);
    let (indexed, plain) = (format!("indexed.fgb {extent}"), format!("plain.fgb {extent}"));
    assert_eq!(map(&folder, &indexed)["digest"], map(&folder, &plain)["digest"]);
    // The nine features lie in three places; those beyond the extent are no part of the scene.
    let counts = |scene: &str| {
        let info = info(&folder, scene);
        (info["buildings"].clone(), info["faults"]["too_far"].clone())
    };
    assert_eq!(counts(&indexed), (json!(3), json!(0)));
    assert_eq!(counts(&plain), (json!(3), json!(0)));
}

#[test]
fn one_table_of_several_is_read_when_it_is_named() {
    let (folder, city) = (Folder::new(), city());
    write_geopackage(&folder.join("two.gpkg"), &[("old town", &city[..1]), ("new", &city)]);
    folder.refuses("info two.gpkg", "E108", &["`old town`, `new`", "hint: `--layer NAME`"]);
    let buildings = |layer: &str| {
        folder.run(&["info", "two.gpkg", "--layer", layer, "--json", "-q"]).done().json()["buildings"].clone()
    };
    assert_eq!((buildings("old town"), buildings("new")), (json!(1), json!(3)));
    folder.refuses("info two.gpkg --layer streets", "E108", &["`streets`", "`old town`, `new`"]);
    write_geojson(&folder.join("a.geojson"), &city);
    folder.refuses("info a.geojson --layer new", "E116", &["`--layer`"]);
}

/// A square of 8 m with these properties, the `k`th of a row.
fn feature(k: usize, properties: Value) -> Value {
    let (west, east) = (10.0 * k as f64, 10.0 * k as f64 + 8.0);
    let square = json!([[[west, 0.0], [east, 0.0], [east, 8.0], [west, 8.0], [west, 0.0]]]);
    json!({"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": square}})
}

#[test]
fn properties_of_openstreetmap_are_read_and_counted() {
    let folder = Folder::new();
    let properties = vec![
        json!({"building": "yes", "building:levels": "4", "roof:levels": "1"}), // 15 m by levels
        json!({"building": "yes", "height": "39'4\""}),                         // 11.9888 m
        json!({"building": "no", "height": 99}),
        json!({"building": "demolished", "height": 99}),
        json!({"building:part": "yes", "height": "20 m", "min_height": 15}),
        json!({"building": "yes", "height": "7,5"}),
        json!({"building": "yes", "name": "unknown"}),
        json!({"building": "yes", "height": 100, "storeys": 2}),
    ];
    let features: Vec<Value> = properties.into_iter().enumerate().map(|(k, p)| feature(k, p)).collect();
    let document = json!({"type": "FeatureCollection", "features": features});
    folder.write("osm.geojson", &document.to_string());
    let counts = &info(&folder, "osm.geojson --missing levels")["faults"];
    for (name, wanted) in [
        ("missing_height", 2),
        ("from_levels", 1),
        ("not_buildings", 2),
        ("floating", 1),
        ("parts", 0),
        ("decimal_comma", 1),
        ("negative_height", 0),
    ] {
        assert_eq!(counts[name], wanted, "{name}: {counts}");
    }
    // Tops as `city` writes them: 4 + 1 storeys, 472 inches rounded to 1/1024 m, and so on.
    let tops = |flags: &str| -> Vec<f64> {
        folder.type_in(&format!("city osm.geojson {flags} -o tops.geojson -q --overwrite")).done();
        let top = |f: &Value| f["properties"]["height"].as_f64().unwrap();
        folder.json("tops.geojson")["features"].as_array().unwrap().iter().map(top).collect()
    };
    let inches = (472.0 * 0.0254_f64 * 1024.0).round() / 1024.0;
    assert_eq!(tops("--missing levels,drop"), [15.0, inches, 20.0, 7.5, 100.0]);
    let feet = |v: f64| (v * 0.3048 * 1024.0 + 0.5).floor() / 1024.0;
    assert_eq!(tops("--height-unit ft --missing drop"), [inches, 20.0, feet(7.5), feet(100.0)]);
    assert_eq!(tops("--missing levels,drop --levels-field storeys"), [inches, 20.0, 7.5, 100.0]);
    // A name that no feature has is always an error.
    for line in
        ["info osm.geojson --height-field tall", "city osm.geojson --top-field tall --missing levels -o a.geojson"]
    {
        folder.refuses(line, "E365", &["osm.geojson", "`tall`", "`height`, ", "`--height-field NAME`"]);
    }
    let answer = folder.type_in("info osm.geojson").done();
    assert!(["W361", "W362"].iter().all(|code| answer.warnings().contains(code)), "{}", answer.err);
}

#[test]
fn storeys_are_offered_as_storeys_and_not_as_heights() {
    let folder = Folder::new();
    folder.write("osm.geojson", &feature(0, json!({"building:levels": 4})).to_string());
    let answer = folder.type_in("info osm.geojson --crs EPSG:25832");
    assert_eq!(answer.error(), "E365");
    assert!(answer.err.contains("`--missing levels"), "{answer:?}");
    assert!(!answer.err.contains("--height-field"), "4 storeys are not 4 m: {answer:?}");
}

#[test]
fn a_name_that_a_shapefile_cuts_is_found() {
    let folder = Folder::new();
    if !has_program("ogr2ogr") {
        return;
    }
    folder.write("a.geojson", &feature(0, json!({"building:levels": 4, "roof:levels": 2})).to_string());
    gdal(&folder, "ogr2ogr -a_srs EPSG:25832 a.shp a.geojson");
    let info = info(&folder, "a.shp --missing levels");
    assert_eq!(info["faults"]["from_levels"], 1);
    assert_eq!(info["surface_m"], json!([18.0, 18.0]));
}

#[test]
fn a_mesh_is_a_surface_as_high_as_its_highest_face() {
    let folder = Folder::new();
    write_obj(&folder.join("a.obj"));
    for (name, format) in [("b.ply", "ascii"), ("c.ply", "binary_little_endian"), ("d.ply", "binary_big_endian")] {
        write_ply(&folder.join(name), format);
    }
    for name in ["a.obj", "b.ply", "c.ply", "d.ply"] {
        let mut options = MeshOptions::default();
        options.surface.ground_m = Some(2.0);
        let scene = read_mesh(folder.join(name), &options, &mut Vec::new()).unwrap();
        assert_eq!((scene.grid.n_cols(), scene.grid.n_rows(), scene.grid.crs()), (20, 10, None));
        let Solids::Raster { surface, .. } = &scene.solids else { panic!("{name} is no surface") };
        for (k, z) in surface.cells().iter().enumerate() {
            let (x, y) = (k % 20, 9 - k / 20);
            assert_eq!(*z, height_steps(mesh_height(x, y)).unwrap(), "{name} at ({x}, {y})");
        }
    }
    let finer = info(&folder, "a.obj --ground 2 --cell 0.5 --crs EPSG:25832");
    assert_eq!([&finer["cols"], &finer["crs"]], [&json!(40), &json!("EPSG:25832")]);
    assert_eq!(finer["cells"], json!({"open": 800 - 144 - 64, "building": 144 + 64, "nodata": 0}));
    // Beyond the faces there is nothing, or the ground where it is known.
    let wider = "a.obj --extent -5,0,20,10";
    assert_eq!(info(&folder, wider)["cells"]["nodata"], 50);
    assert_eq!(info(&folder, &format!("{wider} --ground 2"))["cells"]["nodata"], 0);
    assert!(folder.type_in(&format!("info {wider}")).done().err.contains("warning[W367]: a.obj: 50 cells"));
}

#[test]
fn what_cannot_be_a_scene_is_refused_in_words() {
    let (folder, city) = (Folder::new(), city());
    write_shapefile(&folder.join("a.shp"), &city);
    write_geopackage(&folder.join("g.gpkg"), &[("buildings", &city)]);
    let as_view = "ALTER TABLE buildings RENAME TO hidden; CREATE VIEW buildings AS SELECT * FROM hidden;
        UPDATE gpkg_contents SET table_name = 'buildings'";
    Connection::open(folder.join("g.gpkg")).unwrap().execute_batch(as_view).unwrap();
    for (from, to) in
        [("a.shp", "no_dbf.shp"), ("a.shx", "no_dbf.shx"), ("a.shp", "no_shx.shp"), ("a.dbf", "no_shx.dbf")]
    {
        std::fs::copy(folder.join(from), folder.join(to)).unwrap();
    }
    // Long enough to look for a header of a hundred bytes.
    let text = "not what the name says ".repeat(5);
    for (name, text) in [
        ("text.fgb", text.as_str()),
        ("text.gpkg", &text),
        ("text.shp", &text),
        ("text.ply", &text),
        ("text.shx", "x"),
        ("text.dbf", "x"),
        ("old.city.json", r#"{"type": "CityJSON", "version": "0.9"}"#),
        ("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
        ("face.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n"),
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("wall.obj", "v 0 0 0\nv 4 4 0\nv 4 4 9\nf 1 2 3\n"),
    ] {
        folder.write(name, text);
    }
    let mut degrees = city.clone();
    degrees.iter_mut().flat_map(|b| b.polygons.iter_mut().flatten().flatten()).for_each(|p| {
        *p = [11.5 + (p[0] - EAST) * 1e-5, 48.1 + (p[1] - NORTH) * 1e-5];
    });
    write_shapefile(&folder.join("degrees.shp"), &degrees);
    folder.write("degrees.prj", "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]]");
    for (file, code, part) in [
        ("no_dbf.shp", "E301", "no_dbf.dbf"),
        ("no_shx.shp", "E301", "no_shx.shx"),
        ("g.gpkg", "E304", "`buildings`"),
        ("text.fgb", "E302", "text.fgb"),
        ("text.gpkg", "E302", "text.gpkg"),
        ("text.shp", "E302", "text.shp"),
        ("text.ply", "E302", "text.ply"),
        ("old.city.json", "E302", "`0.9`"),
        ("points.obj", "E308", "face"),
        ("face.obj", "E302", "line 3: a face whose corner is `3`, of 2 vertices"),
        ("nan.obj", "E302", "vertex number 0"),
        ("wall.obj", "E312", "wall.obj"),
        ("degrees.shp", "E310", "(EPSG:4326)"),
        ("a.shp --crs EPSG:4326", "E310", "`a.shp`"),
        ("nowhere.gpkg", "E301", "nowhere.gpkg"),
        ("points.obj --missing fail", "E116", "`--missing`"),
        ("a.shp --levels-field n", "E116", "`--levels-field`"),
        ("a.shp --missing fail --height-field tall", "E365", "`tall`"),
    ] {
        folder.refuses(&format!("info {file}"), code, &[part]);
    }
}
