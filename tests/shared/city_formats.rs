//! Writes the small city of `vector_files` as CityGML, as parts of a cadastre, and as GeoParquet.

#![allow(dead_code, reason = "each binary uses a part")]

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, FloatType};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde_json::json;

use crate::vector_files::{Building, METERS, multipolygon};

/// Numbers of a ring of `gml:posList` at some height.
fn positions(ring: &[[f64; 2]], z: f64) -> String {
    ring.iter().map(|[x, y]| format!("{x} {y} {z}")).collect::<Vec<_>>().join(" ")
}

fn polygon(rings: &[Vec<[f64; 2]>], z: f64) -> String {
    let ring = |k: usize, ring: &Vec<[f64; 2]>| {
        let side = if k == 0 { "exterior" } else { "interior" };
        format!(
            "<gml:{side}><gml:LinearRing><gml:posList>{}</gml:posList></gml:LinearRing></gml:{side}>",
            positions(ring, z)
        )
    };
    let rings: String = rings.iter().enumerate().map(|(k, r)| ring(k, r)).collect();
    format!("<gml:surfaceMember><gml:Polygon>{rings}</gml:Polygon></gml:surfaceMember>")
}

fn walls(ring: &[[f64; 2]], top: f64) -> String {
    let wall = |pair: &[[f64; 2]]| {
        let [[ax, ay], [bx, by]] = [pair[0], pair[1]];
        format!(
            "<gml:surfaceMember><gml:Polygon><gml:exterior><gml:LinearRing><gml:posList>{ax} {ay} 0 {bx} {by} 0 {bx} {by} {top} \
             {ax} {ay} {top} {ax} {ay} 0</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon></gml:surfaceMember>"
        )
    };
    ring.windows(2).map(wall).collect()
}

/// CityGML of version 1, 2 or 3 of the city on ground at 0 m, with marked surfaces of level of detail 2.
pub(crate) fn citygml(city: &[Building], version: u8) -> String {
    let space = match version {
        1 => "http://www.opengis.net/citygml/building/1.0",
        2 => "http://www.opengis.net/citygml/building/2.0",
        _ => "http://www.opengis.net/citygml/building/3.0",
    };
    let side = if version == 3 { "boundary" } else { "boundedBy" };
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<core:CityModel xmlns:core=\"{space}\" xmlns:bldg=\"{space}\" \
         xmlns:gml=\"http://www.opengis.net/gml\">\n"
    );
    let marked = |kind: &str, surfaces: &str| {
        format!(
            "<bldg:{side}><bldg:{kind}><bldg:lod2MultiSurface><gml:MultiSurface srsName=\"EPSG:25832\">{surfaces}\
             </gml:MultiSurface></bldg:lod2MultiSurface></bldg:{kind}></bldg:{side}>"
        )
    };
    for (k, (building, top)) in city.iter().zip(METERS).enumerate() {
        write!(text, "<core:cityObjectMember><bldg:Building gml:id=\"b{k}\">").unwrap();
        for rings in &building.polygons {
            let walls: String = rings.iter().map(|ring| walls(ring, top)).collect();
            for (kind, surfaces) in
                [("GroundSurface", polygon(rings, 0.0)), ("RoofSurface", polygon(rings, top)), ("WallSurface", walls)]
            {
                text += &marked(kind, &surfaces);
            }
        }
        text += "</bldg:Building></core:cityObjectMember>\n";
    }
    text + "</core:CityModel>\n"
}

/// Parts of a cadastre with their storeys, each of a building in a file of its own.
pub(crate) fn cadastre(city: &[Building], storeys: &[u32]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n<gml:FeatureCollection xmlns:gml=\"http://www.opengis.net/gml/3.2\" \
         xmlns:bu-ext2d=\"http://inspire.jrc.ec.europa.eu/schemas/bu-ext2d/2.0\" \
         xmlns:bu-core2d=\"http://inspire.jrc.ec.europa.eu/schemas/bu-core2d/2.0\">\n",
    );
    let mut n = 0;
    for (building, storeys) in city.iter().zip(storeys) {
        for rings in &building.polygons {
            n += 1;
            let ring = |k: usize, ring: &Vec<[f64; 2]>| {
                let side = if k == 0 { "exterior" } else { "interior" };
                let numbers: Vec<String> = ring.iter().map(|[x, y]| format!("{x} {y}")).collect();
                format!(
                    "<gml:{side}><gml:LinearRing><gml:posList srsDimension=\"2\">{}</gml:posList></gml:LinearRing></gml:{side}>",
                    numbers.join(" ")
                )
            };
            let rings: String = rings.iter().enumerate().map(|(k, r)| ring(k, r)).collect();
            writeln!(
                text,
                "<gml:featureMember><bu-ext2d:BuildingPart gml:id=\"ES.SDGC.BU.{n}_part1\"><bu-ext2d:geometry>\
                 <bu-core2d:BuildingGeometry><bu-core2d:geometry><gml:Surface srsName=\"urn:ogc:def:crs:EPSG::25832\"><gml:patches>\
                 <gml:PolygonPatch>{rings}</gml:PolygonPatch></gml:patches></gml:Surface></bu-core2d:geometry>\
                 </bu-core2d:BuildingGeometry></bu-ext2d:geometry><bu-ext2d:numberOfFloorsAboveGround>{storeys}\
                 </bu-ext2d:numberOfFloorsAboveGround></bu-ext2d:BuildingPart></gml:featureMember>"
            )
            .unwrap();
        }
    }
    text + "</gml:FeatureCollection>\n"
}

/// Writes GeoParquet with the boxes of its features, `rows` rows in a group.
pub(crate) fn write_geoparquet(path: &Path, city: &[Building], compression: Compression, rows: usize) {
    let text = |name: &str| {
        let of = Type::primitive_type_builder(name, Physical::BYTE_ARRAY);
        of.with_converted_type(ConvertedType::UTF8).with_repetition(Repetition::OPTIONAL).build().unwrap()
    };
    let bytes = Type::primitive_type_builder("geometry", Physical::BYTE_ARRAY).with_repetition(Repetition::REQUIRED);
    let side = |name| {
        let of = Type::primitive_type_builder(name, Physical::FLOAT);
        Arc::new(of.with_repetition(Repetition::REQUIRED).build().unwrap())
    };
    let boxes = Type::group_type_builder("bbox").with_repetition(Repetition::REQUIRED);
    let boxes = boxes.with_fields(["xmin", "ymin", "xmax", "ymax"].map(side).to_vec()).build().unwrap();
    let fields = [text("id"), bytes.build().unwrap(), boxes, text("height")].map(Arc::new);
    let schema = Type::group_type_builder("schema").with_fields(fields.to_vec()).build().unwrap();
    let geo = json!({"version": "1.1.0", "primary_column": "geometry", "columns": {"geometry": {"encoding": "WKB",
        "geometry_types": ["MultiPolygon"], "crs": "EPSG:25832"}}});
    let metadata = vec![KeyValue::new("geo".to_string(), geo.to_string())];
    let properties = WriterProperties::builder().set_compression(compression).set_key_value_metadata(Some(metadata));
    let file = std::fs::File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties.build())).unwrap();
    for (k, group) in city.chunks(rows).enumerate() {
        let ids: Vec<ByteArray> = (0..group.len()).map(|i| format!("b{}", k * rows + i).as_bytes().into()).collect();
        let shapes: Vec<ByteArray> = group.iter().map(|b| multipolygon(&b.polygons).into()).collect();
        let heights: Vec<ByteArray> = group.iter().map(|b| b.height.as_bytes().into()).collect();
        let all_there = vec![1; group.len()];
        let mut columns = writer.next_row_group().unwrap();
        for at in 0..7 {
            let mut column = columns.next_column().unwrap().unwrap();
            match at {
                0 => column.typed::<ByteArrayType>().write_batch(&ids, Some(&all_there), None),
                1 => column.typed::<ByteArrayType>().write_batch(&shapes, None, None),
                6 => column.typed::<ByteArrayType>().write_batch(&heights, Some(&all_there), None),
                side => column.typed::<FloatType>().write_batch(&sides(group, side - 2), None, None),
            }
            .unwrap();
            column.close().unwrap();
        }
        columns.close().unwrap();
    }
    writer.close().unwrap();
}

/// The west, south, east or north side of each building, rounded outward.
fn sides(city: &[Building], side: usize) -> Vec<f32> {
    let of = |building: &Building| {
        let values = building.polygons.iter().flatten().flatten().map(|p| p[side % 2]);
        #[expect(clippy::cast_possible_truncation, reason = "rounded on purpose")]
        if side < 2 {
            (values.fold(f64::INFINITY, f64::min) as f32).next_down()
        } else {
            (values.fold(f64::NEG_INFINITY, f64::max) as f32).next_up()
        }
    };
    city.iter().map(of).collect()
}
