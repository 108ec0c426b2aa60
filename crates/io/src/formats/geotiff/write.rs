//! Writer of GeoTIFFs: tiled, deflated, with overviews, as cloud optimized files; or plain strips
//! for readers without codecs, and to compare the run time of programs without them.
//!
//! All blocks of tiled files are compressed in parallel and held in memory, so that every offset is
//! known before the first byte is written. The order is: header, directories (full resolution
//! first), blocks of the smallest overview, …, blocks of the full resolution. Plain files have
//! their directory behind their strips (`plain.rs`). The bytes depend on the input alone, not on
//! the number of threads or the time of day.
//!
//! The codecs and the byte layout of tags are those of `tiff-writer`. Tags for place and metadata
//! of the picture are in `geo_tags.rs`, GDAL's tag for nodata (42113) in `levels.rs`.
//!
//! # References
//! TIFF 6.0 (1992); OGC 21-026, Cloud Optimized GeoTIFF; the GDAL driver documentation.

use std::borrow::Cow;
use std::io::Write;

use rayon::prelude::*;
use tiff_core::{Compression, Predictor};
use tiff_writer::TiffWriteSample;
use tiff_writer::compress::{BlockEncodingOptions, compress_block};

use skyshed_request::TiffLayout;

use super::image::{Bands, GeoTiffImage};
use super::levels::{
    Level, TILE_ENCODING, Tile, compressed_tiles, level_tags, n_overviews, refused, rows_per_strip, write_levels,
};
use super::overview::{Overviews, first_of, most_frequent};
use super::plain::write_plain;
use crate::error::Result;

/// Returns the file as bytes.
///
/// # Errors
/// E402 if TIFF cannot hold the image.
///
/// # Panics
/// If a band does not hold one value per cell.
pub fn encode_geotiff(image: &GeoTiffImage<'_>) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_geotiff(&mut bytes, image)?;
    Ok(bytes)
}

/// Writes the file front to back; a BigTIFF above 4 GiB, or above 3 GiB if it is plain.
///
/// # Errors
/// E401 if `out` refuses the bytes, E402 if TIFF cannot hold the image.
///
/// # Panics
/// If a band does not hold one value per cell.
pub fn write_geotiff(out: &mut impl Write, image: &GeoTiffImage<'_>) -> Result<()> {
    write_as(out, image, false)
}

fn write_as(out: &mut impl Write, image: &GeoTiffImage<'_>, force_big: bool) -> Result<()> {
    let levels = match &image.bands {
        Bands::Byte(bands) => levels(image, bands, Predictor::None, most_frequent, Some)?,
        Bands::Float(bands) => levels(image, bands, Predictor::FloatingPoint, first_of, |_| None)?,
        Bands::UInt32(bands) => levels(image, bands, Predictor::None, first_of, |_| None)?,
    };
    match levels.as_slice() {
        [only] if image.layout == TiffLayout::Plain => write_plain(out, only, force_big),
        levels => write_levels(out, levels, force_big),
    }
}

/// Returns all resolutions, the full one first.
///
/// `as_bytes` returns the cells as they are stored without compression, if they need no encoding.
fn levels<'a, T: Tile>(
    image: &GeoTiffImage<'_>,
    bands: &[(String, &'a [T])],
    predictor: Predictor,
    overviews: Overviews<T>,
    as_bytes: fn(&'a [T]) -> Option<&'a [u8]>,
) -> Result<Vec<Level<'a>>> {
    let (n_rows, n_cols) = (image.georef.n_rows(), image.georef.n_cols());
    let names: Vec<&str> = bands.iter().map(|(name, _)| name.as_str()).collect();
    for (name, values) in bands {
        assert_eq!(values.len(), image.georef.n_cells(), "band `{name}` holds one value per cell");
    }
    if image.layout == TiffLayout::Plain {
        let tags = level_tags::<T>(image, ((n_rows, n_cols), 1), &names, predictor)?;
        return Ok(vec![Level { tags, blocks: plain_strips(bands, n_cols, as_bytes)? }]);
    }
    let n_overviews = n_overviews((n_rows, n_cols));
    let reduced: Vec<Vec<Vec<T>>> =
        bands.iter().map(|(_, values)| overviews(values, (n_rows, n_cols), n_overviews)).collect();
    let of_level = |level: usize| {
        let cells: Vec<&[T]> = match level.checked_sub(1) {
            None => bands.iter().map(|(_, values)| *values).collect(),
            Some(overview) => reduced.iter().map(|of_band| of_band[overview].as_slice()).collect(),
        };
        let shape = (n_rows.div_ceil(1 << level), n_cols.div_ceil(1 << level));
        let tags = level_tags::<T>(image, (shape, 1 << level), &names, predictor)?;
        let blocks = compressed_tiles(&cells, shape, predictor)?.into_iter().map(Cow::Owned).collect();
        Ok(Level { tags, blocks })
    };
    (0..=n_overviews).map(of_level).collect()
}

/// Returns the strips of all bands, band by band, from the north; the last one of a band holds the
/// remaining rows.
fn plain_strips<'a, T: TiffWriteSample + Send + Sync>(
    bands: &[(String, &'a [T])],
    n_cols: usize,
    as_bytes: fn(&'a [T]) -> Option<&'a [u8]>,
) -> Result<Vec<Cow<'a, [u8]>>> {
    let options = BlockEncodingOptions {
        compression: Compression::None,
        predictor: Predictor::None,
        deflate_level: None,
        row_width_pixels: n_cols,
        ..TILE_ENCODING
    };
    let strip = rows_per_strip::<T>(n_cols) * n_cols;
    let strips: Vec<&'a [T]> = bands.iter().flat_map(|(_, band)| band.chunks(strip)).collect();
    let encoded = |(index, cells): (usize, &&'a [T])| match as_bytes(cells) {
        Some(bytes) => Ok(Cow::Borrowed(bytes)),
        None => compress_block(cells, options, index).map(Cow::Owned).map_err(refused),
    };
    strips.par_iter().enumerate().map(encoded).collect()
}

#[cfg(test)]
mod tests {
    use super::super::class_pyramid::ClassPyramid;
    use super::super::image::{ClassColor, ClassImage};
    use super::super::plain::ClassStrips;
    use super::*;
    use crate::raster::GeoRef;

    #[test]
    fn classic_and_big_files_hold_the_same() {
        let crs = crate::crs::from_epsg(25832).unwrap();
        let georef = GeoRef::new((500_000.0, 5_400_000.0), (1.0, 1.0), (300, 700), Some(crs)).unwrap();
        let cells: Vec<f32> = (0..georef.n_cells()).map(|i| (i % 977) as f32 / 8.0).collect();
        let bands = Bands::Float(vec![("a".to_string(), &cells), ("b".to_string(), &cells)]);
        for (layout, n_overviews, force_big, magic) in [
            (TiffLayout::Cog, 2, false, 42),
            (TiffLayout::Cog, 2, true, 43),
            (TiffLayout::Plain, 0, false, 42),
            (TiffLayout::Plain, 0, true, 43),
        ] {
            let image = GeoTiffImage {
                georef: &georef,
                bands: bands.clone(),
                nodata: Some(-9999.0),
                palette: None,
                metadata: &[],
                layout,
            };
            let mut bytes = Vec::new();
            write_as(&mut bytes, &image, force_big).unwrap();
            assert_eq!(bytes[2], magic);
            let file = geotiff_reader::GeoTiffFile::from_bytes(bytes).unwrap();
            assert_eq!((file.width(), file.height(), file.band_count()), (700, 300, 2));
            assert_eq!(file.overview_count(), n_overviews);
            assert_eq!(file.read_band::<f32>(1).unwrap().iter().copied().collect::<Vec<_>>(), cells);
        }
    }

    /// Calls `check` for shapes of all kinds with rows of classes, their image, metadata, and the
    /// file that is made of them at once.
    fn for_files_of_classes(
        layout: TiffLayout,
        shapes: &[(usize, usize)],
        check: impl Fn((usize, usize, &[u8]), &ClassImage<'_>, &[(String, String)], &[u8]),
    ) {
        for &(n_rows, n_cols) in shapes {
            let georef = GeoRef::new((0.0, 0.0), (1.0, 1.0), (n_rows, n_cols), None).unwrap();
            let cells: Vec<u8> = (0..n_rows * n_cols).map(|k| [0, 1, 2, 255][k * k / 7 % 4]).collect();
            let palette = [ClassColor { value: 1, name: "a".into(), rgba: [1, 2, 3, 255] }];
            let class = ClassImage { georef: &georef, nodata: Some(255.0), palette: Some(&palette), name: "los" };
            let metadata = [("SKYSHED".to_string(), "{}".to_string())];
            let bands = Bands::Byte(vec![("los".to_string(), &cells)]);
            let mut file = Vec::new();
            write_geotiff(&mut file, &GeoTiffImage { bands, ..class.head(&metadata, layout) }).unwrap();
            check((n_rows, n_cols, &cells), &class, &metadata, &file);
        }
    }

    #[test]
    fn a_file_of_rows_is_the_file_of_the_raster() {
        let shapes = [(1, 1), (200, 300), (256, 256), (700, 1300), (1025, 40)];
        for_files_of_classes(TiffLayout::Cog, &shapes, |(n_rows, n_cols, cells), class, metadata, expected| {
            let mut pyramid = ClassPyramid::new((n_rows, n_cols));
            cells.chunks(n_cols * 100).for_each(|rows| pyramid.push(rows).unwrap());
            let mut found = Vec::new();
            pyramid.write(&mut found, class, metadata).unwrap();
            assert!(found == expected, "{n_rows}×{n_cols}");
        });
    }

    #[test]
    fn a_plain_file_of_rows_is_the_file_of_the_raster() {
        let shapes = [(1, 1), (3, 5), (200, 300), (9, 1025), (2, 9001)];
        for_files_of_classes(TiffLayout::Plain, &shapes, |(n_rows, n_cols, cells), class, metadata, expected| {
            assert_eq!(&expected[8..8 + cells.len()], cells);
            let mut strips = ClassStrips::new(Vec::new(), (n_rows, n_cols)).unwrap();
            cells.chunks(n_cols * 100).for_each(|rows| strips.push(rows).unwrap());
            assert!(strips.finish(class, metadata).unwrap() == expected, "{n_rows}×{n_cols}");
        });
    }
}
