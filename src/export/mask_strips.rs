//! The mask of one UAV as a plain GeoTIFF that is written while the mask is made.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use super::Batch;
use super::files::complete;
use super::map::{MaskValues, add_described};
use crate::error::Result;
use crate::raster::{ClassStrips, GeoRef};

/// A file of a batch to which the rows of a mask are written one after another: what [`super::add_map`] writes of the same
/// mask in memory.
#[derive(Debug)]
pub struct MaskStrips {
    path: PathBuf,
    values: MaskValues,
    strips: ClassStrips<BufWriter<File>>,
}

impl MaskStrips {
    /// Begins the file under its temporary name.
    ///
    /// # Errors
    /// As [`Batch::add`].
    pub fn begin(batch: &mut Batch, path: &Path, georef: &GeoRef, values: MaskValues) -> Result<Self> {
        let strips = ClassStrips::new(batch.begin(path)?, (georef.n_rows(), georef.n_cols()))?;
        Ok(MaskStrips { path: path.to_path_buf(), values, strips })
    }

    /// Writes whole rows of the mask, from the north.
    ///
    /// # Errors
    /// E401 if writing fails.
    pub fn push(&mut self, mask: &[u8]) -> Result<()> {
        self.strips.push(&self.values.of(mask))
    }

    /// Completes the file, once all rows are written, and adds the one with the names of its classes.
    ///
    /// # Errors
    /// As [`Batch::add`]; internal errors from the encoder.
    pub fn finish(self, batch: &mut Batch, described: (&GeoRef, &str, &str)) -> Result<()> {
        let MaskStrips { path, values, strips } = self;
        add_described(batch, &path, described, values, |_, image, metadata| {
            complete(&path, strips.finish(image, metadata)?)
        })
    }
}
