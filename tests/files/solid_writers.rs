//! Writes two buildings as surfaces in every format that holds heights of corners.

use std::path::Path;

use flatgeobuf::geozero::error::Result as GeozeroResult;
use flatgeobuf::geozero::{ColumnValue, GeomProcessor, GeozeroGeometry, PropertyProcessor};
use flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType};
use rusqlite::Connection;
use serde_json::{Value, json};
use shapefile::dbase::{FieldName, FieldValue, Record, TableWriterBuilder};
use shapefile::{Multipatch, NO_DATA, Patch, PointZ, PolygonRing};

use crate::vector_files::{EAST, NORTH, UTM32};

/// Corners of a surface, the first not repeated [m from the corner of the city, m above the datum].
pub(crate) type Surface = Vec<[f64; 3]>;

/// A house with a gable roof and a box, both on the ground at 500 m.
pub(crate) fn solids() -> Vec<Vec<Surface>> {
    let (w, e, s, n) = (8.0, 28.0, 10.0, 22.0);
    let (ground, eaves, ridge, middle) = (500.0, 506.0, 511.0, 16.0);
    let house = vec![
        vec![[w, s, ground], [w, n, ground], [e, n, ground], [e, s, ground]],
        vec![[w, s, eaves], [e, s, eaves], [e, middle, ridge], [w, middle, ridge]],
        vec![[w, middle, ridge], [e, middle, ridge], [e, n, eaves], [w, n, eaves]],
        vec![[w, s, ground], [e, s, ground], [e, s, eaves], [w, s, eaves]],
        vec![[e, n, ground], [w, n, ground], [w, n, eaves], [e, n, eaves]],
        vec![[e, s, ground], [e, n, ground], [e, n, eaves], [e, middle, ridge], [e, s, eaves]],
        vec![[w, n, ground], [w, s, ground], [w, s, eaves], [w, middle, ridge], [w, n, eaves]],
    ];
    let square = [[40.0, 30.0], [52.5, 30.0], [52.5, 41.0], [40.0, 41.0]];
    let level = |z: f64| square.map(|[x, y]| [x, y, z]).to_vec();
    let mut cuboid = vec![level(515.0), level(500.0).into_iter().rev().collect()];
    for k in 0..4 {
        let ([ax, ay], [bx, by]) = (square[k], square[(k + 1) % 4]);
        cuboid.push(vec![[ax, ay, 500.0], [bx, by, 500.0], [bx, by, 515.0], [ax, ay, 515.0]]);
    }
    vec![house, cuboid]
}

/// Corners on the map, the first repeated at the end.
fn closed(surface: &Surface) -> Vec<[f64; 3]> {
    surface.iter().chain(surface.first()).map(|[x, y, z]| [EAST + x, NORTH + y, *z]).collect()
}

pub(crate) fn write_cityjson(path: &Path, solids: &[Vec<Surface>]) {
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    let mut objects = serde_json::Map::new();
    for (k, solid) in solids.iter().enumerate() {
        let mut surface = |of: &Surface| {
            let from = vertices.len();
            vertices.extend(of.iter().map(|[x, y, z]| [x * 1000.0, y * 1000.0, z * 1000.0].map(f64::round)));
            vec![(from..vertices.len()).collect::<Vec<_>>()]
        };
        let surfaces: Vec<_> = solid.iter().map(&mut surface).collect();
        let geometry = json!({"type": "MultiSurface", "lod": "2", "boundaries": surfaces});
        objects.insert(format!("b{k}"), json!({"type": "Building", "geometry": [geometry]}));
    }
    let document = json!({"type": "CityJSON", "version": "2.0", "CityObjects": objects, "vertices": vertices,
        "transform": {"scale": [0.001, 0.001, 0.001], "translate": [EAST, NORTH, 0.0]},
        "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/25832"}});
    std::fs::write(path, document.to_string()).unwrap();
}

/// GeoJSON of the solids with some properties.
pub(crate) fn write_geojson(path: &Path, solids: &[Vec<Surface>], properties: &Value) {
    let feature = |solid: &Vec<Surface>| {
        let polygons: Vec<Value> = solid.iter().map(|surface| json!([closed(surface)])).collect();
        json!({"type": "Feature", "properties": properties,
            "geometry": {"type": "MultiPolygon", "coordinates": polygons}})
    };
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}});
    let features: Vec<Value> = solids.iter().map(feature).collect();
    let document = json!({"type": "FeatureCollection", "crs": crs, "features": features});
    std::fs::write(path, document.to_string()).unwrap();
}

/// Well-known binary of surfaces, little endian: a MultiPolygon Z (1006), PolyhedralSurface Z (1015) or TIN Z (1016).
pub(crate) fn wkb(code: u32, surfaces: &[Surface]) -> Vec<u8> {
    let int = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
    let of_part: u32 = if code == 1016 { 1017 } else { 1003 };
    let mut bytes = [[1].as_slice(), &code.to_le_bytes(), &int(surfaces.len())].concat();
    for surface in surfaces {
        let ring = closed(surface);
        bytes.extend([[1].as_slice(), &of_part.to_le_bytes(), &int(1), &int(ring.len())].concat());
        ring.iter().flatten().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    bytes
}

pub(crate) fn write_geopackage(path: &Path, solids: &[Vec<Surface>], code: u32) {
    let database = Connection::open(path).unwrap();
    database
        .execute_batch(
            "PRAGMA application_id = 0x47504B47;
             CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT, srs_id INTEGER PRIMARY KEY, organization TEXT,
                organization_coordsys_id INTEGER, definition TEXT);
             INSERT INTO gpkg_spatial_ref_sys VALUES ('ETRS89 / UTM zone 32N', 25832, 'EPSG', 25832, 'undefined');
             CREATE TABLE gpkg_contents (table_name TEXT PRIMARY KEY, data_type TEXT, srs_id INTEGER);
             CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, srs_id INTEGER);
             CREATE TABLE city (fid INTEGER PRIMARY KEY, geom BLOB);
             INSERT INTO gpkg_contents VALUES ('city', 'features', 25832);
             INSERT INTO gpkg_geometry_columns VALUES ('city', 'geom', 25832);",
        )
        .unwrap();
    for solid in solids {
        let geometry = [b"GP\0\x01".as_slice(), &25832_i32.to_le_bytes(), &wkb(code, solid)].concat();
        database.execute("INSERT INTO city (geom) VALUES (?1)", [geometry]).unwrap();
    }
    database.close().unwrap();
}

struct Shape<'a>(&'a [Surface]);

impl GeozeroGeometry for Shape<'_> {
    fn process_geom<P: GeomProcessor>(&self, to: &mut P) -> GeozeroResult<()> {
        to.multipolygon_begin(self.0.len(), 0)?;
        for (k, surface) in self.0.iter().enumerate() {
            let ring = closed(surface);
            to.polygon_begin(false, 1, k)?;
            to.linestring_begin(false, ring.len(), 0)?;
            for (j, [x, y, z]) in ring.into_iter().enumerate() {
                to.coordinate(x, y, Some(z), None, None, None, j)?;
            }
            to.linestring_end(false, 0)?;
            to.polygon_end(false, k)?;
        }
        to.multipolygon_end(0)
    }
}

pub(crate) fn write_flatgeobuf(path: &Path, solids: &[Vec<Surface>]) {
    let crs = FgbCrs { code: 25832, ..FgbCrs::default() };
    let options = FgbWriterOptions { crs, has_z: true, ..FgbWriterOptions::default() };
    let mut writer = FgbWriter::create_with_options("city", GeometryType::MultiPolygon, options).unwrap();
    writer.add_column("n", ColumnType::Int, |_, _| {});
    for solid in solids {
        writer
            .add_feature_geom(Shape(solid), |feature| {
                feature.property(0, "n", &ColumnValue::Int(7)).unwrap();
            })
            .unwrap();
    }
    writer.write(std::fs::File::create(path).unwrap()).unwrap();
}

fn points(surface: &Surface) -> Vec<PointZ> {
    closed(surface).into_iter().map(|[x, y, z]| PointZ::new(x, y, z, NO_DATA)).collect()
}

fn table() -> TableWriterBuilder {
    TableWriterBuilder::new().add_numeric_field(FieldName::try_from("n").unwrap(), 9, 2)
}

fn row() -> Record {
    let mut row = Record::default();
    row.insert("n".into(), FieldValue::Numeric(Some(1.0)));
    row
}

/// A shapefile of polygons with heights: each surface is a ring.
pub(crate) fn write_polygons(path: &Path, solids: &[Vec<Surface>]) {
    {
        let mut writer = shapefile::Writer::from_path(path, table()).unwrap();
        for solid in solids {
            let rings = solid.iter().map(|surface| PolygonRing::Outer(points(surface))).collect();
            writer.write_shape_and_record(&shapefile::PolygonZ::with_rings(rings), &row()).unwrap();
        }
    }
    std::fs::write(path.with_extension("prj"), UTM32).unwrap();
}

/// A shapefile of multipatches: surfaces as rings, fans and strips in turn.
pub(crate) fn write_multipatches(path: &Path, solids: &[Vec<Surface>]) {
    let patch = |(k, surface): (usize, &Surface)| {
        let mut points = points(surface);
        match k % 4 {
            0 => Patch::OuterRing(points),
            1 if surface.len() == 4 => {
                points.pop();
                points.swap(2, 3);
                Patch::TriangleStrip(points)
            }
            2 => {
                points.pop();
                Patch::TriangleFan(points)
            }
            _ => Patch::FirstRing(points),
        }
    };
    {
        let mut writer = shapefile::Writer::from_path(path, table()).unwrap();
        for solid in solids {
            let patches = solid.iter().enumerate().map(patch).collect();
            writer.write_shape_and_record(&Multipatch::with_parts(patches), &row()).unwrap();
        }
    }
    std::fs::write(path.with_extension("prj"), UTM32).unwrap();
}
