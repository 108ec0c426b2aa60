//! GeoTIFF: heights in strips or tiles, with the place and the coordinate reference system in tags.
//!
//! Supported:
//!
//! * TIFF and BigTIFF in both byte orders; strips and tiles, bands interleaved or apart.
//! * Integers of 8 to 64 bits and floats of 16 to 64 bits; predictors 2 and 3.
//! * No compression, LZW, deflate, PackBits, Zstandard, LERC (plain, with deflate or Zstandard) and
//!   single-band JPEG.
//! * The first image of a file with overviews.
//! * GDAL's nodata value, scale and offset, internal masks, bands of opacity (0 is nothing), and
//!   missing (sparse) blocks.
//! * `MinIsWhite`, which changes no height.
//! * The entries of a `.aux.xml` file that GDAL uses ([`sidecar`]).
//!
//! Refused by name: other compressions and depths, LERC in big-endian files, color JPEG, ground
//! control points, and rotation. A `.msk` file beside the raster is not read, but reported.
//!
//! The first image directory is parsed ([`tags`]) and checked against the length of the file
//! ([`header`]) before a decoder receives a byte. A header may promise more than any file can hold.
//!
//! [`crate::error::OddRaster`] lists the oddities of such files.

mod class_pyramid;
mod geo_tags;
mod geo_tiff;
mod header;
mod heights;
mod image;
mod lerc;
mod levels;
mod metadata;
mod overview;
mod placement;
mod plain;
mod read;
mod sidecar;
mod stored;
mod tags;
#[cfg(test)]
mod tests;
mod write;

pub use class_pyramid::ClassPyramid;
pub use geo_tags::{class_table, pam_sidecar, xml_text};
pub use geo_tiff::GeoTiff;
pub use image::{Bands, ClassColor, ClassImage, GeoTiffImage};
pub(super) use placement::meters_per_named_unit;
#[cfg(feature = "point-clouds")]
pub(crate) use placement::{GeoKeySystems, systems_of_geo_keys};
pub use plain::ClassStrips;
pub use write::{encode_geotiff, write_geotiff};
