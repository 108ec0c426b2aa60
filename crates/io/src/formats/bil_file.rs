//! Raw numbers with a text header (`.bil` and `.hdr`), which radio planners read: band interleaved by line, one band.
//!
//! # References
//! The header's keywords: Esri, "BIL, BIP, and BSQ raster files"; GDAL's driver `EHdr`.

use std::fmt::Write;

use crate::raster::GeoRef;

/// The type of the numbers, all little endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BilValues {
    /// Bytes.
    Byte,
    /// Unsigned integers of 32 bits.
    UInt32,
    /// Floating point numbers of 32 bits.
    Float,
}

/// The header of a file that holds one number per cell, row by row from the north-west.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_describes_rows_of_numbers_from_the_center_of_the_first_cell() {
        let georef = GeoRef::new((500_000.0, 5_400_000.0), (0.5, 0.25), (3, 7), None).unwrap();
        let header = bil_header(&georef, BilValues::Float, Some(-9999.0));
        let wanted = ["NROWS 3", "NCOLS 7", "NBITS 32", "PIXELTYPE FLOAT", "BANDROWBYTES 28", "ULXMAP 500000.25"];
        for line in wanted.iter().chain(&["ULYMAP 5399999.875", "XDIM 0.5", "YDIM 0.25", "NODATA -9999"]) {
            assert!(header.lines().any(|l| l == *line), "{line}: {header}");
        }
        assert!(!bil_header(&georef, BilValues::Byte, None).contains("NODATA"));
    }
}
