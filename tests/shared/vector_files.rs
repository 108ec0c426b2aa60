//! Writes one small city in every format of vector data that is read.

#![allow(dead_code, reason = "each binary uses a part")]

use std::fmt::Write as _;
use std::path::Path;

use flatgeobuf::geozero::error::Result as GeozeroResult;
use flatgeobuf::geozero::{ColumnValue, GeomProcessor, GeozeroGeometry, PropertyProcessor};
use flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType};
use rusqlite::Connection;
use serde_json::{Value, json};
use shapefile::dbase::{FieldName, FieldValue, Record, TableWriterBuilder};
use shapefile::{Point, PolygonRing};

/// Rings of points, each closed, the shell first and counterclockwise.
pub(crate) type Rings = Vec<Vec<[f64; 2]>>;

/// A building: its properties as text, and its polygons.
#[derive(Debug, Clone)]
pub(crate) struct Building {
    pub(crate) height: &'static str,
    pub(crate) polygons: Vec<Rings>,
}

/// Where the city stands [m], in EPSG:25832.
pub(crate) const EAST: f64 = 691_000.0;
pub(crate) const NORTH: f64 = 5_334_000.0;

fn ring(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    points.iter().chain(points.first()).map(|[x, y]| [EAST + x, NORTH + y]).collect()
}

/// A block with a courtyard, two houses that are one feature, and an L, with heights in three spellings.
pub(crate) fn city() -> Vec<Building> {
    let square = |x: f64, y: f64, s: f64| [[x, y], [x + s, y], [x + s, y + s], [x, y + s]];
    let mut court = ring(&square(17.0, 17.0, 8.0));
    court.reverse();
    let ell = [[50.25, 8.0], [74.0, 8.0], [74.0, 16.5], [60.0, 16.5], [60.0, 40.0], [50.25, 40.0]];
    vec![
        Building { height: "12.5 m", polygons: vec![vec![ring(&square(8.0, 8.0, 26.0)), court]] },
        Building {
            height: "40 ft",
            polygons: vec![vec![ring(&square(8.0, 50.0, 9.0))], vec![ring(&square(30.0, 52.0, 6.5))]],
        },
        Building { height: "9", polygons: vec![vec![ring(&ell)]] },
    ]
}

/// The heights of [`city`] in meters: 40 feet of 0.3048 m.
pub(crate) const METERS: [f64; 3] = [12.5, 12.192, 9.0];

pub(crate) fn write_geojson(path: &Path, city: &[Building]) {
    let feature = |b: &Building| {
        json!({"type": "Feature", "properties": {"height": b.height},
            "geometry": {"type": "MultiPolygon", "coordinates": b.polygons}})
    };
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}});
    let features: Vec<Value> = city.iter().map(feature).collect();
    let document = json!({"type": "FeatureCollection", "crs": crs, "features": features});
    std::fs::write(path, document.to_string()).unwrap();
}

/// The projection of the city, as Esri writes it.
pub(crate) const UTM32: &str = r#"PROJCS["ETRS_1989_UTM_Zone_32N",GEOGCS["GCS_ETRS_1989",DATUM["D_ETRS_1989",
SPHEROID["GRS_1980",6378137.0,298.257222101]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],
PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],
PARAMETER["Central_Meridian",9.0],PARAMETER["Scale_Factor",0.9996],PARAMETER["Latitude_Of_Origin",0.0],
UNIT["Meter",1.0]]"#;

/// A shapefile; in its rings shells run clockwise.
pub(crate) fn write_shapefile(path: &Path, city: &[Building]) {
    let name = |text: &str| FieldName::try_from(text).unwrap();
    let table = TableWriterBuilder::new().add_character_field(name("height"), 12).add_numeric_field(name("n"), 9, 2);
    {
        let mut writer = shapefile::Writer::from_path(path, table).unwrap();
        for (k, building) in city.iter().enumerate() {
            let points = |ring: &Vec<[f64; 2]>| ring.iter().map(|p| Point::new(p[0], p[1])).collect::<Vec<_>>();
            let kinds = building.polygons.iter().flat_map(|rings| rings.iter().enumerate());
            let rings = kinds.map(|(at, ring)| match at {
                0 => PolygonRing::Outer(points(ring)),
                _ => PolygonRing::Inner(points(ring)),
            });
            let shape = shapefile::Polygon::with_rings(rings.collect());
            let mut row = Record::default();
            row.insert("height".into(), FieldValue::Character(Some(building.height.into())));
            row.insert("n".into(), FieldValue::Numeric(Some(k as f64)));
            writer.write_shape_and_record(&shape, &row).unwrap();
        }
    }
    std::fs::write(path.with_extension("prj"), UTM32).unwrap();
    std::fs::write(path.with_extension("cpg"), "UTF-8").unwrap();
}

pub(crate) struct Shape<'a>(pub(crate) &'a Building);

impl GeozeroGeometry for Shape<'_> {
    fn process_geom<P: GeomProcessor>(&self, to: &mut P) -> GeozeroResult<()> {
        to.multipolygon_begin(self.0.polygons.len(), 0)?;
        for (k, rings) in self.0.polygons.iter().enumerate() {
            to.polygon_begin(false, rings.len(), k)?;
            for (i, ring) in rings.iter().enumerate() {
                to.linestring_begin(false, ring.len(), i)?;
                for (j, [x, y]) in ring.iter().enumerate() {
                    to.xy(*x, *y, j)?;
                }
                to.linestring_end(false, i)?;
            }
            to.polygon_end(false, k)?;
        }
        to.multipolygon_end(0)
    }
}

pub(crate) fn write_flatgeobuf(path: &Path, city: &[Building], write_index: bool) {
    let crs = FgbCrs { code: 25832, ..FgbCrs::default() };
    let options = FgbWriterOptions { write_index, crs, ..FgbWriterOptions::default() };
    let mut writer = FgbWriter::create_with_options("city", GeometryType::MultiPolygon, options).unwrap();
    writer.add_column("n", ColumnType::Int, |_, _| {});
    writer.add_column("height", ColumnType::String, |_, _| {});
    for building in city {
        writer
            .add_feature_geom(Shape(building), |feature| {
                feature.property(0, "n", &ColumnValue::Int(7)).unwrap();
                feature.property(1, "height", &ColumnValue::String(building.height)).unwrap();
            })
            .unwrap();
    }
    writer.write(std::fs::File::create(path).unwrap()).unwrap();
}

/// A GeoPackage with a table of buildings for each name, in the order given.
pub(crate) fn write_geopackage(path: &Path, layers: &[(&str, &[Building])]) {
    let database = Connection::open(path).unwrap();
    database
        .execute_batch(
            "PRAGMA application_id = 0x47504B47;
             CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT, srs_id INTEGER PRIMARY KEY, organization TEXT,
                organization_coordsys_id INTEGER, definition TEXT);
             INSERT INTO gpkg_spatial_ref_sys VALUES ('ETRS89 / UTM zone 32N', 25832, 'EPSG', 25832, 'undefined');
             CREATE TABLE gpkg_contents (table_name TEXT PRIMARY KEY, data_type TEXT, srs_id INTEGER);
             CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, srs_id INTEGER);",
        )
        .unwrap();
    for (layer, city) in layers {
        database
            .execute_batch(&format!(
                "CREATE TABLE \"{layer}\" (fid INTEGER PRIMARY KEY, geom BLOB, height TEXT);
                 INSERT INTO gpkg_contents VALUES ('{layer}', 'features', 25832);
                 INSERT INTO gpkg_geometry_columns VALUES ('{layer}', 'geom', 25832);"
            ))
            .unwrap();
        let insert = format!("INSERT INTO \"{layer}\" (geom, height) VALUES (?1, ?2)");
        for building in *city {
            let geometry =
                [b"GP\0\x01".as_slice(), &25832_i32.to_le_bytes(), &multipolygon(&building.polygons)].concat();
            database.execute(&insert, rusqlite::params![geometry, building.height]).unwrap();
        }
    }
    database.close().unwrap();
}

/// Well-known binary, little endian.
pub(crate) fn multipolygon(polygons: &[Rings]) -> Vec<u8> {
    let int = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
    let mut bytes = [[1].as_slice(), &int(6), &int(polygons.len())].concat();
    for rings in polygons {
        bytes.extend([[1].as_slice(), &int(3), &int(rings.len())].concat());
        for ring in rings {
            bytes.extend(int(ring.len()));
            ring.iter().flatten().for_each(|c| bytes.extend(c.to_le_bytes()));
        }
    }
    bytes
}

/// CityJSON of the city as solids on the ground at 0 m, in millimeters.
pub(crate) fn write_cityjson(path: &Path, city: &[Building], version: &str) {
    let mut vertices: Vec<[i64; 3]> = Vec::new();
    #[expect(clippy::cast_possible_truncation, reason = "millimeters of a small city")]
    let mut vertex = |[x, y]: [f64; 2], z: f64| {
        vertices.push([x - EAST, y - NORTH, z].map(|c| (c * 1000.0).round() as i64));
        vertices.len() - 1
    };
    let mut objects = serde_json::Map::new();
    for (k, (building, top)) in city.iter().zip(METERS).enumerate() {
        let (mut solids, mut kinds) = (Vec::new(), Vec::new());
        for rings in &building.polygons {
            let open = |ring: &Vec<[f64; 2]>| ring[1..].to_vec();
            let mut level = |z: f64| -> Vec<Vec<usize>> {
                rings.iter().map(|ring| open(ring).into_iter().map(|p| vertex(p, z)).collect()).collect()
            };
            let (below, above) = (level(0.0), level(top));
            let mut surfaces = vec![json!(below), json!(above)];
            for (low, high) in below.iter().zip(&above) {
                let n = low.len();
                surfaces.extend((0..n).map(|i| json!([[low[i], low[(i + 1) % n], high[(i + 1) % n], high[i]]])));
            }
            let walls = vec![1; surfaces.len() - 2];
            let values = [vec![0, 2], walls].concat();
            kinds.push(json!([values]));
            solids.push(json!([surfaces]));
        }
        let types = ["GroundSurface", "WallSurface", "RoofSurface"].map(|kind| json!({"type": kind}));
        let geometry = json!({"type": "MultiSolid", "lod": "1.2", "boundaries": solids,
            "semantics": {"surfaces": types, "values": kinds}});
        objects.insert(format!("b{k}"), json!({"type": "Building", "geometry": [geometry]}));
    }
    let document = json!({"type": "CityJSON", "version": version, "CityObjects": objects, "vertices": vertices,
        "transform": {"scale": [0.001, 0.001, 0.001], "translate": [EAST, NORTH, 0.0]},
        "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/25832"}});
    std::fs::write(path, document.to_string()).unwrap();
}

/// A mesh of two houses over flat ground at 2 m, 20 × 10 m: (2..8) × (2..8) up to 9 m, and a roof that rises from 4 m at
/// x = 12 to 8 m at x = 16 over y = 2..6.
const VERTICES: [[f64; 3]; 16] = [
    [0.0, 0.0, 2.0],
    [20.0, 0.0, 2.0],
    [20.0, 10.0, 2.0],
    [0.0, 10.0, 2.0],
    [2.0, 2.0, 9.0],
    [8.0, 2.0, 9.0],
    [8.0, 8.0, 9.0],
    [2.0, 8.0, 9.0],
    [12.0, 2.0, 4.0],
    [16.0, 2.0, 8.0],
    [16.0, 6.0, 8.0],
    [12.0, 6.0, 4.0],
    [2.0, 2.0, 2.0],
    [8.0, 2.0, 2.0],
    [8.0, 8.0, 2.0],
    [2.0, 8.0, 2.0],
];

/// Two triangles of ground, a square roof, two triangles of a slope, and walls.
const FACES: [&[u32]; 7] =
    [&[0, 1, 2], &[0, 2, 3], &[4, 5, 6, 7], &[8, 9, 10], &[8, 10, 11], &[12, 13, 5, 4], &[14, 6, 7, 15]];

/// The height of that mesh over the center of column `x` and row `y` from the south [m].
pub(crate) fn mesh_height(x: usize, y: usize) -> f64 {
    match (x, y) {
        (2..8, 2..8) => 9.0,
        (12..16, 2..6) => 4.0 + (x - 12) as f64 + 0.5,
        _ => 2.0,
    }
}

pub(crate) fn write_obj(path: &Path) {
    let mut text = String::from("# two houses\no city\n");
    VERTICES.iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
    for face in FACES {
        let corners: Vec<String> = face.iter().map(|k| format!("{}", k + 1)).collect();
        writeln!(text, "f {}", corners.join(" ")).unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// Writes the mesh as PLY, `format` being one of the three that the format knows.
pub(crate) fn write_ply(path: &Path, format: &str) {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\ncomment two houses\nelement vertex {}\nproperty double x\nproperty float y\nproperty \
         double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        VERTICES.len(),
        FACES.len()
    )
    .into_bytes();
    let is_little = format == "binary_little_endian";
    #[expect(clippy::cast_possible_truncation, reason = "small whole numbers")]
    for [x, y, z] in VERTICES {
        let y = y as f32;
        match format {
            "ascii" => bytes.extend(format!("{x} {y} {z}\n").bytes()),
            _ if is_little => bytes.extend([x.to_le_bytes().as_slice(), &y.to_le_bytes(), &z.to_le_bytes()].concat()),
            _ => bytes.extend([x.to_be_bytes().as_slice(), &y.to_be_bytes(), &z.to_be_bytes()].concat()),
        }
    }
    for face in FACES {
        if format == "ascii" {
            let words: Vec<String> = face.iter().map(u32::to_string).collect();
            bytes.extend(format!("{} {}\n", face.len(), words.join(" ")).bytes());
            continue;
        }
        bytes.push(u8::try_from(face.len()).unwrap());
        face.iter().for_each(|k| bytes.extend(if is_little { k.to_le_bytes() } else { k.to_be_bytes() }));
    }
    std::fs::write(path, bytes).unwrap();
}
