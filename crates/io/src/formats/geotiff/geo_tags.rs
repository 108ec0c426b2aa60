//! Tags for place and content of a picture: GeoKeys, GDAL's metadata, and the names of classes in
//! the sidecar.
//!
//! # References
//! OGC 19-008r4, GeoTIFF 1.1; the GDAL driver documentation: tag 42112, and the PAM sidecar.

use geotiff_core::geokeys::{self, GeoKeyDirectory, GeoKeyValue};
use tiff_core::{Tag, TagValue};

use super::image::{ClassColor, GeoTiffImage};
use crate::crs::wkt_of;
use crate::error::{Error, Result, is_text};
use crate::raster::{Crs, CrsKind};

/// Tag of GDAL's metadata, an XML text.
const GDAL_METADATA: u16 = 42112;
/// GeoKey value: defined by the other keys, not by a code.
const USER_DEFINED: u16 = 32767;
/// GeoKey 3077: length of a user-defined unit \[m\].
const PROJ_LINEAR_UNIT_SIZE: u16 = 3077;

/// Longest citation taken as a definition \[bytes\]; GDAL reads up to 2400.
const LONGEST_DEFINITION: usize = 2300;

/// Returns the tags for place and metadata of the picture, which are in the first directory only.
pub(super) fn place_tags(image: &GeoTiffImage<'_>, names: &[&str]) -> Result<Vec<Tag>> {
    let georef = image.georef;
    let scale = vec![georef.cell_width(), georef.cell_height(), 0.0];
    let corner = vec![0.0, 0.0, 0.0, georef.x_min(), georef.y_max(), 0.0];
    let mut tags = vec![
        Tag::new(geotiff_core::tags::TAG_MODEL_PIXEL_SCALE, TagValue::Double(scale)),
        Tag::new(geotiff_core::tags::TAG_MODEL_TIEPOINT, TagValue::Double(corner)),
    ];
    // Without a reference system there are no keys at all: with any key GDAL makes up a local
    // system.
    if let Some(crs) = georef.crs() {
        let (keys, doubles, text) =
            geo_keys(crs).serialize().map_err(|cause| Error::encode("the GeoKeys of a GeoTIFF", cause))?;
        tags.push(Tag::new(geotiff_core::tags::TAG_GEO_KEY_DIRECTORY, TagValue::Short(keys)));
        if !doubles.is_empty() {
            tags.push(Tag::new(geotiff_core::tags::TAG_GEO_DOUBLE_PARAMS, TagValue::Double(doubles)));
        }
        tags.push(Tag::new(geotiff_core::tags::TAG_GEO_ASCII_PARAMS, TagValue::Ascii(text)));
    }
    tags.push(Tag::new(GDAL_METADATA, TagValue::Ascii(gdal_metadata(image.metadata, names))));
    Ok(tags)
}

/// Returns the reference system as GeoKeys.
///
/// A system without an EPSG code is written as a definition in the citation, in Esri's form, which
/// GDAL, QGIS and ArcGIS read. A system known only by name becomes a local system of that name in
/// GDAL.
fn geo_keys(crs: &Crs) -> GeoKeyDirectory {
    let ascii = |text: &str| {
        let plain = text.chars().map(|c| if c.is_ascii_graphic() && c != '|' { c } else { ' ' });
        GeoKeyValue::Ascii(plain.collect())
    };
    let code = crs.epsg().and_then(|code| u16::try_from(code).ok()).filter(|&code| code < USER_DEFINED);
    let definition = match code {
        Some(_) => None,
        None => {
            wkt_of(crs).map(|wkt| format!("ESRI PE String = {}", wkt.split_whitespace().collect::<Vec<_>>().join(" ")))
        }
    };
    let definition = definition.filter(|text| text.len() <= LONGEST_DEFINITION);
    let (model, code_key, citation_key) = match crs.kind() {
        _ if definition.is_some() => (USER_DEFINED, None, geokeys::PROJ_CITATION),
        CrsKind::Projected { .. } => (1, Some(geokeys::PROJECTED_CRS_TYPE), geokeys::PROJ_CITATION),
        CrsKind::Geographic => (2, Some(geokeys::GEODETIC_CRS_TYPE), geokeys::GEODETIC_CITATION),
        CrsKind::Other => (USER_DEFINED, None, geokeys::PROJ_CITATION),
    };
    let mut keys = GeoKeyDirectory::new();
    keys.set(geokeys::GT_MODEL_TYPE, GeoKeyValue::Short(model));
    // Cells are areas.
    keys.set(geokeys::GT_RASTER_TYPE, GeoKeyValue::Short(1));
    keys.set(geokeys::GT_CITATION, ascii(&crs.name()));
    if let Some(key) = code_key {
        keys.set(key, GeoKeyValue::Short(code.unwrap_or(USER_DEFINED)));
    }
    if code.is_none() {
        keys.set(citation_key, ascii(&definition.unwrap_or_else(|| crs.name())));
    }
    match crs.kind() {
        CrsKind::Geographic => keys.set(geokeys::GEOG_ANGULAR_UNITS, GeoKeyValue::Short(9102)),
        CrsKind::Projected { meters_per_unit } => {
            // EPSG codes of the meter, the international foot and the US survey foot.
            const UNITS: [(f64, u16); 3] = [(1.0, 9001), (0.3048, 9002), (1200.0 / 3937.0, 9003)];
            let unit = UNITS.iter().find(|(meters, _)| (meters - meters_per_unit).abs() < 1e-12).map(|unit| unit.1);
            keys.set(geokeys::PROJ_LINEAR_UNITS, GeoKeyValue::Short(unit.unwrap_or(USER_DEFINED)));
            if unit.is_none() {
                keys.set(PROJ_LINEAR_UNIT_SIZE, GeoKeyValue::Double(vec![meters_per_unit]));
            }
        }
        CrsKind::Other => {}
    }
    keys
}

/// Returns items of the dataset and names of the bands as GDAL writes them: values are escaped
/// twice.
fn gdal_metadata(items: &[(String, String)], names: &[&str]) -> String {
    let mut text = String::from("<GDALMetadata>\n");
    for (key, value) in items {
        text.push_str(&format!("  <Item name=\"{}\">{}</Item>\n", xml_text(key), xml_text(&xml_value(value))));
    }
    for (sample, name) in names.iter().enumerate() {
        let name = xml_text(&xml_value(name));
        text.push_str(&format!(
            "  <Item name=\"DESCRIPTION\" sample=\"{sample}\" role=\"description\">{name}</Item>\n"
        ));
    }
    text.push_str("</GDALMetadata>\n");
    text
}

/// Returns the sidecar `FILE.tif.aux.xml` with names and colors of the classes of the first
/// `n_bands` bands.
///
/// GDAL reads category names of a GeoTIFF from nowhere else. The color table of a TIFF always has
/// 256 entries. The table of the sidecar has those of the classes; GDAL and QGIS prefer it.
pub fn pam_sidecar(palette: &[ClassColor], n_bands: usize) -> String {
    let table = class_table(palette);
    let band = |band| format!("  <PAMRasterBand band=\"{band}\">\n{table}  </PAMRasterBand>\n");
    format!("<PAMDataset>\n{}</PAMDataset>\n", (1..=n_bands).map(band).collect::<String>())
}

/// Returns names and colors of classes, from 0 to the last, as virtual rasters and sidecars of GDAL
/// have them within a band.
pub fn class_table(palette: &[ClassColor]) -> String {
    let last = palette.iter().map(|class| class.value).max().unwrap_or(0);
    let of = |value: u8| palette.iter().find(|class| class.value == value);
    let (mut names, mut colors) = (String::new(), String::new());
    for value in 0..=last {
        let (name, [r, g, b, a]) = of(value).map_or(("", [0; 4]), |class| (class.name.as_str(), class.rgba));
        names.push_str(&format!("      <Category>{}</Category>\n", xml_text(name)));
        colors.push_str(&format!("      <Entry c1=\"{r}\" c2=\"{g}\" c3=\"{b}\" c4=\"{a}\"/>\n"));
    }
    format!("    <CategoryNames>\n{names}    </CategoryNames>\n    <ColorTable>\n{colors}    </ColorTable>\n")
}

/// Escapes a value as GDAL does before it writes XML; quotation marks stay, so that JSON remains
/// readable.
fn xml_value(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Escapes text for XML; characters that XML 1.0 cannot hold become a space.
pub fn xml_text(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' | '\t' => escaped.push(c),
            c if is_text(c) => escaped.push(c),
            _ => escaped.push(' '),
        }
    }
    escaped
}
