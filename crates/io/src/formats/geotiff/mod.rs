//! GeoTIFF: heights in strips or tiles, with the place and the coordinate reference system in tags.
//!
//! What is read: TIFF and BigTIFF in both byte orders; strips and tiles, bands interleaved or apart; integers of 8 to 64
//! bits and floats of 16 to 64 bits; no compression, LZW, deflate, PackBits, Zstandard, LERC (plain, with deflate or
//! Zstandard) and single-band JPEG; predictors 2 and 3; the first image of a file with overviews; GDAL's nodata value,
//! scale and offset, internal masks, bands of opacity (0 is nothing) and missing (sparse) blocks. `MinIsWhite` changes no
//! height. What is not: other compressions and depths, LERC in big-endian files, color JPEG, ground control points and rotation, which are refused
//! by name; a `.msk` file beside the raster, which is reported; a `.aux.xml` file, which is not looked at.
//!
//! The first image directory is parsed ([`tags`]) and checked against the length of the file ([`header`]) before a decoder
//! sees a byte, since a header may promise what no file can hold.
//!
//! Codes of errors: E301 cannot be opened or read; E302 not a TIFF, or a header that makes no sense; E303 cut short, or
//! a header that points beyond the file, or a block that does not decode; E304 an encoding that is not read; E305 no
//! height at all; E306 rotated; E307 no regular grid; E501 more cells than fit in memory. Of warnings: W320 NaN or
//! infinite cells, W321 missing blocks, W322 unreadable nodata value, W323 several bands, W324 a mask that is not used,
//! W325 no CRS, W326 a CRS that is not known, W327 no place, W328 heights that look like nodata, W329 a later image
//! that cannot be read, W330 rows turned over, W331 web Mercator, W332 heights not in meters, W333 scaled heights, W334
//! lossy compression.

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
mod stored;
mod tags;
#[cfg(test)]
mod tests;
mod write;

pub use class_pyramid::ClassPyramid;
pub use geo_tags::{pam_sidecar, xml_text};
pub use geo_tiff::GeoTiff;
pub use image::{Bands, ClassColor, ClassImage, GeoTiffImage, TiffLayout};
pub(super) use placement::meters_per_named_unit;
pub use plain::ClassStrips;
pub use write::{encode_geotiff, write_geotiff};
