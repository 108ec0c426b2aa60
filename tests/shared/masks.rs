//! A small town that is mapped, and masks read back from files.

#![allow(dead_code, reason = "each binary uses a part")]

use std::io::{Cursor, Read};

use geotiff_reader::GeoTiffFile;

use crate::program::Folder;

/// Two buildings in Munich, in ETRS89 / UTM zone 32N; 60 × 40 cells around them.
pub(crate) const TOWN: &str = r#"{"type": "FeatureCollection",
  "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}, "features": [
  {"type": "Feature", "properties": {"height": 20}, "geometry": {"type": "Polygon",
   "coordinates": [[[691610,5334760],[691620,5334760],[691620,5334775],[691610,5334775],[691610,5334760]]]}},
  {"type": "Feature", "properties": {"height": 9.5}, "geometry": {"type": "Polygon",
   "coordinates": [[[691630,5334755],[691645,5334762],[691640,5334770],[691630,5334755]]]}}]}"#;

/// The town's grid, seen from one UAV.
pub(crate) const MAP: &str = "map town.geojson --extent 691600,5334750,691660,5334790 --uav 691605,5334755,40";

/// A folder with the town as `town.geojson`.
pub(crate) fn town() -> Folder {
    let folder = Folder::new();
    folder.write("town.geojson", TOWN);
    folder
}

/// A GeoTIFF of a folder, read by another crate than ours.
pub(crate) fn tif(folder: &Folder, name: &str) -> GeoTiffFile {
    GeoTiffFile::from_bytes(folder.read(name)).unwrap()
}

/// The classes of the one mask of a GeoTIFF.
pub(crate) fn mask_of(folder: &Folder, name: &str) -> Vec<u8> {
    tif(folder, name).read_raster::<u8>().unwrap().into_iter().collect()
}

/// The array of an `.npz` file: its header and its bytes.
pub(crate) fn npy(folder: &Folder, file: &str, name: &str) -> (String, Vec<u8>) {
    let mut archive = zip::ZipArchive::new(Cursor::new(folder.read(file))).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    (String::from_utf8(bytes[10..start].to_vec()).unwrap(), bytes[start..].to_vec())
}
