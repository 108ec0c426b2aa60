//! Raw numbers with a text header (`.bil` and `.hdr`), which radio planners read: band interleaved
//! by line, one band.
//!
//! # References
//! The header's keywords: Esri, "BIL, BIP, and BSQ raster files"; GDAL's driver `EHdr`.

use std::fmt::Write;

use crate::raster::GeoRef;

/// Type of the numbers, all little endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BilValues {
    /// Bytes.
    Byte,
    /// Unsigned integers of 32 bits.
    UInt32,
    /// Floating point numbers of 32 bits.
    Float,
}

/// Returns the header of a file that holds one number per cell, row by row from the north-west.
///
/// Like a world file it places the *center* of the north-west cell.
pub fn bil_header(georef: &GeoRef, values: BilValues, nodata: Option<f64>) -> String {
    let (bits, kind) = match values {
        BilValues::Byte => (8, "UNSIGNEDINT"),
        BilValues::UInt32 => (32, "UNSIGNEDINT"),
        BilValues::Float => (32, "FLOAT"),
    };
    let row_bytes = georef.n_cols() * bits / 8;
    let (x, y) = georef.world_from_cell(0, 0);
    let mut text = format!(
        "BYTEORDER I\nLAYOUT BIL\nNROWS {}\nNCOLS {}\nNBANDS 1\nNBITS {bits}\nPIXELTYPE {kind}\n\
         BANDROWBYTES {row_bytes}\nTOTALROWBYTES {row_bytes}\nULXMAP {x}\nULYMAP {y}\nXDIM {}\nYDIM {}\n",
        georef.n_rows(),
        georef.n_cols(),
        georef.cell_width(),
        georef.cell_height()
    );
    if let Some(nodata) = nodata {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "NODATA {nodata}");
    }
    text
}
