//! A cloud optimized GeoTIFF of classes whose rows come one after another, from the north: the file that
//! [`super::write_geotiff`] writes of the same cells in memory.

use std::borrow::Cow;
use std::io::Write;

use tiff_core::Predictor;

use super::overview::{most_frequent, overview};
use super::write::{Level, TILE, compressed_tiles, is_last_level, level_tags, write_levels};
use super::{Bands, ClassColor, GeoTiffImage, TiffLayout};
use crate::error::Result;
use crate::raster::GeoRef;

/// What a file of classes is, without its cells.
#[derive(Debug, Clone, Copy)]
pub struct ClassImage<'a> {
    /// Where the cells lie.
    pub georef: &'a GeoRef,
    /// The value that means no data.
    pub nodata: Option<f64>,
    /// Colors of the classes.
    pub palette: Option<&'a [ClassColor]>,
    /// What the band is called.
    pub name: &'a str,
}

impl<'a> ClassImage<'a> {
    /// The same as an image, but for its cells.
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

/// The compressed tiles of all rows so far, at every resolution. Memory is theirs and that of a few hundred rows.
#[derive(Debug, Default)]
pub struct ClassPyramid {
    n_rows: usize,
    n_cols: usize,
    n_pushed: usize,
    /// Rows that are not yet a row of tiles.
    band: Vec<u8>,
    levels: Vec<PyramidLevel>,
}

#[derive(Debug)]
struct PyramidLevel {
    reduction: usize,
    n_cols: usize,
    /// Rows that are not yet a row of tiles.
    band: Vec<u8>,
    blocks: Vec<Vec<u8>>,
}

impl ClassPyramid {
    /// A pyramid of a shape without rows.
    pub fn new((n_rows, n_cols): (usize, usize)) -> Self {
        let mut levels = Vec::new();
        let mut reduction = 1;
        loop {
            let shape = (n_rows.div_ceil(reduction), n_cols.div_ceil(reduction));
            levels.push(PyramidLevel { reduction, n_cols: shape.1, band: Vec::new(), blocks: Vec::new() });
            if is_last_level(shape, reduction) {
                break;
            }
            reduction *= 2;
        }
        ClassPyramid { n_rows, n_cols, n_pushed: 0, band: Vec::new(), levels }
    }

    /// Adds whole rows.
    ///
    /// # Errors
    /// E402 if a tile cannot be encoded.
    ///
    /// # Panics
    /// If `cells` are no whole rows, or more than there are.
    pub fn push(&mut self, cells: &[u8]) -> Result<()> {
        assert!(cells.len().is_multiple_of(self.n_cols), "whole rows");
        for row in cells.chunks(self.n_cols) {
            self.band.extend_from_slice(row);
            self.n_pushed += 1;
            assert!(self.n_pushed <= self.n_rows, "no more rows than there are");
            if self.n_pushed.is_multiple_of(TILE) || self.n_pushed == self.n_rows {
                self.flush()?;
            }
        }
        Ok(())
    }

    /// Hands a row of tiles to all levels. A row of tiles is a multiple of the largest reduction.
    fn flush(&mut self) -> Result<()> {
        let n_rows = self.band.len() / self.n_cols;
        let is_end = self.n_pushed == self.n_rows;
        for level in &mut self.levels {
            match level.reduction {
                1 => level.band.extend_from_slice(&self.band),
                reduction => {
                    level.band.extend(overview(&self.band, (n_rows, self.n_cols), reduction, most_frequent));
                }
            }
            let n_held = level.band.len() / level.n_cols;
            if n_held >= TILE || is_end {
                level.blocks.extend(compressed_tiles(&[&level.band], (n_held, level.n_cols), Predictor::None)?);
                level.band.clear();
            }
        }
        self.band.clear();
        Ok(())
    }

    /// Writes the file front to back, with items of GDAL's metadata; a BigTIFF if it is above 4 GiB.
    ///
    /// # Errors
    /// E401 if `out` refuses the bytes, E402 if TIFF cannot hold the image.
    ///
    /// # Panics
    /// If rows are missing.
    pub fn write(&self, out: &mut impl Write, image: &ClassImage<'_>, metadata: &[(String, String)]) -> Result<()> {
        assert_eq!(self.n_pushed, self.n_rows, "all rows were pushed");
        let head = image.head(metadata, TiffLayout::Cog);
        let levels = self.levels.iter().map(|level| {
            let shape = (self.n_rows.div_ceil(level.reduction), level.n_cols);
            Ok(Level {
                tags: level_tags::<u8>(&head, (shape, level.reduction), &[image.name], Predictor::None)?,
                blocks: level.blocks.iter().map(|block| Cow::Borrowed(block.as_slice())).collect(),
            })
        });
        write_levels(out, &levels.collect::<Result<Vec<_>>>()?, false)
    }
}

/// Calls `check` with rows of classes, what they are, metadata, and the file that is made of them at once, for shapes of all
/// kinds.
#[cfg(test)]
pub(super) fn for_files_of_classes(
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
        super::write_geotiff(&mut file, &GeoTiffImage { bands, ..class.head(&metadata, layout) }).unwrap();
        check((n_rows, n_cols, &cells), &class, &metadata, &file);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
