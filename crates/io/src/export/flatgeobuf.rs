//! Coverage polygons as FlatGeobuf, which GIS read through its spatial index.

use std::path::Path;

use flatgeobuf::geozero::{ColumnValue, GeomProcessor, GeozeroGeometry, PropertyProcessor};
use flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType};

use super::Batch;
use crate::coverage::CoveragePolygon;
use crate::crs::wkt_of;
use crate::error::{Error, Result};
use crate::raster::{Crs, GeoRef};

/// Polygons ready for a file.
#[derive(Debug, Clone, Copy)]
pub struct PolygonFile<'a> {
    /// Grid of the polygons, for its CRS.
    pub georef: &'a GeoRef,
    /// The polygons.
    pub polygons: &'a [CoveragePolygon],
    /// Title of the layer.
    pub title: &'a str,
    /// Provenance as one JSON text.
    pub provenance: &'a str,
}

/// Adds a FlatGeobuf file to a batch. Its columns are `site`, `class`, `cells` and `area_m2`. The
/// CRS is stored by its EPSG code and as WKT, the provenance as the metadata of the file.
///
/// # Errors
/// Errors of [`Batch::add`]; E402 if the polygons cannot be encoded.
pub fn add_flatgeobuf(batch: &mut Batch, file: &PolygonFile<'_>, path: &Path) -> Result<()> {
    let bytes = encode(file).map_err(|cause| Error::encode(path.display(), cause))?;
    batch.add(path, &bytes)
}

fn encode(file: &PolygonFile<'_>) -> std::result::Result<Vec<u8>, Box<dyn std::error::Error>> {
    let crs = file.georef.crs();
    let (name, wkt) = (crs.map(Crs::name), crs.and_then(wkt_of));
    let options = FgbWriterOptions {
        detect_type: false,
        promote_to_multi: false,
        crs: FgbCrs {
            org: crs.and_then(Crs::epsg).map(|_| "EPSG"),
            code: crs.and_then(Crs::epsg).and_then(|code| i32::try_from(code).ok()).unwrap_or(0),
            name: name.as_deref(),
            wkt: wkt.as_deref(),
            ..FgbCrs::default()
        },
        title: Some(file.title),
        metadata: Some(file.provenance),
        ..FgbWriterOptions::default()
    };
    let mut writer = FgbWriter::create_with_options("coverage", GeometryType::Polygon, options)?;
    // The types of the same columns in GeoJSON: GIS read an unsigned column of 64 bits as real
    // numbers.
    let columns = [
        ("site", ColumnType::String),
        ("class", ColumnType::String),
        ("cells", ColumnType::Long),
        ("area_m2", ColumnType::Double),
    ];
    columns.into_iter().for_each(|(name, kind)| writer.add_column(name, kind, |_, column| column.nullable = false));
    for polygon in file.polygons {
        let values = [
            ColumnValue::String(&polygon.site),
            ColumnValue::String(polygon.class_name()),
            ColumnValue::Long(i64::try_from(polygon.n_cells).unwrap_or(i64::MAX)),
            ColumnValue::Double(polygon.area_m2),
        ];
        let mut failed = None;
        writer.add_feature_geom(Rings(&polygon.rings), |feature| {
            for (k, value) in values.iter().enumerate() {
                failed = feature.property(k, columns[k].0, value).err().or(failed.take());
            }
        })?;
        if let Some(cause) = failed {
            return Err(cause.into());
        }
    }
    let mut bytes = Vec::new();
    writer.write(&mut bytes)?;
    Ok(bytes)
}

/// Rings of a polygon; the processor receives them closed.
struct Rings<'a>(&'a [Vec<[f64; 2]>]);

impl GeozeroGeometry for Rings<'_> {
    fn process_geom<P: GeomProcessor>(&self, processor: &mut P) -> flatgeobuf::geozero::error::Result<()> {
        processor.polygon_begin(true, self.0.len(), 0)?;
        for (k, ring) in self.0.iter().enumerate() {
            processor.linestring_begin(false, ring.len() + 1, k)?;
            for (at, [x, y]) in ring.iter().chain(ring.first()).enumerate() {
                processor.xy(*x, *y, at)?;
            }
            processor.linestring_end(false, k)?;
        }
        processor.polygon_end(true, 0)
    }
}
