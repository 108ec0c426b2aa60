//! Content of a GeoTIFF: bands, names and colors of classes, metadata, and the arrangement of the
//! cells.

use skyshed_request::TiffLayout;

use crate::raster::GeoRef;

/// Bands of an image: name and values row by row from the north-west cell, all of one type.
#[derive(Debug, Clone)]
pub enum Bands<'a> {
    /// Classes; overviews show the most frequent one, the smaller on a tie.
    Byte(Vec<(String, &'a [u8])>),
    /// Measures; overviews show one of the cells.
    Float(Vec<(String, &'a [f32])>),
    /// Counts or sets of bits; overviews show one of the cells.
    UInt32(Vec<(String, &'a [u32])>),
}

/// Name and color of a class.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClassColor {
    /// The cell value.
    pub value: u8,
    /// The name shown in a legend.
    pub name: String,
    /// Red, green, blue, opacity.
    pub rgba: [u8; 4],
}

/// Content of a GeoTIFF file.
#[derive(Debug, Clone)]
pub struct GeoTiffImage<'a> {
    /// Grid of the cells.
    pub georef: &'a GeoRef,
    /// Names and values of the bands.
    pub bands: Bands<'a>,
    /// Nodata value of all bands.
    pub nodata: Option<f64>,
    /// Colors of a single byte band. TIFF has no opacity: the renderer applies it.
    pub palette: Option<&'a [ClassColor]>,
    /// Items of GDAL's metadata: key and value.
    pub metadata: &'a [(String, String)],
    /// Arrangement of the cells.
    pub layout: TiffLayout,
}

/// Content of a file of classes, without its cells.
#[derive(Debug, Clone, Copy)]
pub struct ClassImage<'a> {
    /// Grid of the cells.
    pub georef: &'a GeoRef,
    /// Nodata value.
    pub nodata: Option<f64>,
    /// Colors of the classes.
    pub palette: Option<&'a [ClassColor]>,
    /// Name of the band.
    pub name: &'a str,
}

impl<'a> ClassImage<'a> {
    /// Returns the image of the classes without its cells.
    pub(super) fn head(&self, metadata: &'a [(String, String)], layout: TiffLayout) -> GeoTiffImage<'a> {
        GeoTiffImage {
            georef: self.georef,
            bands: Bands::Byte(vec![(self.name.to_string(), &[])]),
            nodata: self.nodata,
            palette: self.palette,
            metadata,
            layout,
        }
    }
}
