//! Tiles as an item of a SpatioTemporal Asset Catalog, version 1.1.0, with the projection extension
//! 2.0.0.

use std::path::Path;

use chrono::{DateTime, SecondsFormat};
use serde_json::{Map, Value, json};

use skyshed_request::Layer;

use crate::crs::{Transformation, from_epsg};
use crate::error::{RequestError, Result};
use crate::export::{MosaicTile, Near};
use crate::raster::{Crs, GeoRef};

/// Returns the item at `path` over the tiles of a grid. The last file was written at `seconds`
/// since 1970; `document` describes the whole.
///
/// # Errors
/// E109 without a reference system; E310 if no transformation leads from it to degrees.
pub(super) fn item(
    path: &Path,
    grid: &GeoRef,
    (tiles, layers, is_cog): (&[MosaicTile], &[Layer], bool),
    seconds: u64,
    document: &Value,
) -> Result<Value> {
    let no_crs = || RequestError::NoCrs(path.display().to_string());
    let crs = grid.crs().ok_or_else(no_crs)?;
    let [west, south, east, north] = [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()];
    let degrees = Transformation::new(crs, &from_epsg(4326)?, ((west + east) / 2.0, (south + north) / 2.0))?;
    let corners = [(west, south), (east, south), (east, north), (west, north), (west, south)];
    let ring = corners.into_iter().map(|corner| Ok(degrees.apply(corner)?)).collect::<Result<Vec<(f64, f64)>>>()?;
    let most = |of: fn(&(f64, f64)) -> f64, pick: fn(f64, f64) -> f64| ring.iter().map(of).reduce(pick);
    let bbox = [most(|p| p.0, f64::min), most(|p| p.1, f64::min), most(|p| p.0, f64::max), most(|p| p.1, f64::max)];
    let near = Near::of(path);
    let asset = |(tile, window): &MosaicTile| {
        let name = near.name_of(tile).0.to_string_lossy().into_owned();
        let part = grid.part(*window);
        let bands: Vec<Value> = layers.iter().map(|layer| json!({"name": layer.name()})).collect();
        let asset = json!({
            "href": encoded(&name),
            "type": if is_cog { "image/tiff; application=geotiff; profile=cloud-optimized" } else { "image/tiff; application=geotiff" },
            "roles": ["data"],
            "bands": bands,
            "proj:shape": [part.n_rows(), part.n_cols()],
            "proj:transform": transform(&part),
        });
        (name, asset)
    };
    let assets: Map<String, Value> = tiles.iter().map(asset).collect();
    Ok(json!({
        "type": "Feature",
        "stac_version": "1.1.0",
        "stac_extensions": ["https://stac-extensions.github.io/projection/v2.0.0/schema.json"],
        "id": path.file_stem().map(|stem| stem.to_string_lossy().into_owned()),
        "geometry": {"type": "Polygon", "coordinates": [ring]},
        "bbox": bbox,
        "properties": {
            "datetime": time_words(seconds),
            "proj:code": code_of(crs),
            "proj:bbox": [west, south, east, north],
            "proj:shape": [grid.n_rows(), grid.n_cols()],
            "proj:transform": transform(grid),
            "skyshed": document,
        },
        "links": [],
        "assets": assets,
    }))
}

/// Returns a path as part of an address, percent-encoded.
fn encoded(path: &str) -> String {
    let is_plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"-._~/!$&'()*+,;=:@".contains(byte);
    let one = |byte: u8| if is_plain(&byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    path.bytes().map(one).collect()
}

/// Returns the affine matrix from columns and rows to the plane, row by row.
fn transform(grid: &GeoRef) -> [f64; 9] {
    [grid.cell_width(), 0.0, grid.x_min(), 0.0, -grid.cell_height(), grid.y_max(), 0.0, 0.0, 1.0]
}

/// Returns the code of a system of a registry, such as `EPSG:25832`; `None` without one.
fn code_of(crs: &Crs) -> Option<String> {
    let label = crs.label();
    let code = label.split(|c: char| c == ',' || c.is_whitespace()).next()?;
    code.starts_with("EPSG:").then(|| code.to_string())
}

/// Returns a time in UTC as RFC 3339 writes it; `None` beyond the end of the calendar.
fn time_words(seconds: u64) -> Option<String> {
    let time = DateTime::from_timestamp(i64::try_from(seconds).ok()?, 0)?;
    Some(time.to_rfc3339_opts(SecondsFormat::Secs, true))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_addresses() {
        assert_eq!(encoded("../a b/1#2%41?-ü.tif"), "../a%20b/1%232%2541%3F-%C3%BC.tif");
    }

    #[test]
    fn times_are_those_of_the_calendar() {
        // `date -u -d @SECONDS +%FT%TZ`
        for (seconds, wanted) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_251_199, "2024-02-29T23:59:59Z"),
            (1_795_867_200, "2026-11-28T12:00:00Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(time_words(seconds).as_deref(), Some(wanted));
        }
    }
}
