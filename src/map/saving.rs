//! `save` of `Coverage` and `Coverages`: a file of the kind that its extension names.

use std::path::{Path, PathBuf};

use super::coverages::{Coverage, Coverages};
use super::files::Writer;
use super::save_checks::{check_formats, check_forms, look_of};
use crate::answer::{Spent, add_outputs};
use crate::error::Result;
use crate::export::{Batch, Format, OutputRules, check_layers, check_outputs};
use skyshed_request::SaveOptions;

impl Coverages {
    /// Writes a file; its extension names the kind:
    ///
    /// * a picture: .png, .svg, .pdf
    /// * a raster: .tif, .exr, .asc, .bil, .npz
    /// * a table: .csv
    /// * a document: .json
    /// * features: .geojson
    /// * an overlay for globes: .kmz
    /// * polygons: .fgb, with [`Coverages::save_with`] alone
    ///
    /// Files that belong beside it (`.prj`, `.json`) are written too.
    ///
    /// # Errors
    /// E104–E109 for a file that cannot be written in its format; E106 if it exists; E116 for .fgb
    /// without polygons; E401 if writing fails.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        self.save_with(path, &SaveOptions::default())
    }

    /// Writes a file in a form that `options` sets.
    ///
    /// # Errors
    /// As [`Coverages::save`].
    pub fn save_with(&self, path: impl AsRef<Path>, options: &SaveOptions) -> Result<()> {
        self.save_all(&[path.as_ref().into()], options)
    }

    /// Returns the picture that `save` writes to a .png file.
    ///
    /// # Errors
    /// E107 for layers that no picture shows; E403.
    pub fn png(&self, options: &SaveOptions) -> Result<Vec<u8>> {
        let path = Path::new("map.png");
        check_formats(options, &[(path.into(), Format::Png)])?;
        check_layers(&self.layers, self.sites.len(), path, Format::Png)?;
        Writer { of: self, options }.png(&look_of(options))
    }

    /// Writes several files, which appear together when all are complete.
    ///
    /// # Errors
    /// As [`Coverages::save`].
    pub fn save_all(&self, paths: &[PathBuf], options: &SaveOptions) -> Result<()> {
        let rules = OutputRules {
            allowed: &super::FORMATS,
            inputs: &[],
            overwrite: options.writing.overwrite,
            bare: options.forms.bare,
        };
        let outputs = check_outputs(paths, rules)?;
        check_formats(options, &outputs)?;
        check_forms(options, &self.scene, &outputs)?;
        for (path, format) in &outputs {
            check_layers(&self.layers, self.sites.len(), path, *format)?;
        }
        let mut batch = Batch::new(options.writing.overwrite);
        add_outputs(&Writer { of: self, options }, &mut batch, &outputs, (&look_of(options), Spent::default()))?;
        Ok(batch.commit().map(|_| ())?)
    }
}

impl Coverage {
    /// Writes a file; its extension names the kind, as for [`Coverages::save`].
    ///
    /// # Errors
    /// As [`Coverages::save`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        self.0.save(path)
    }

    /// Writes a file in a form that `options` sets.
    ///
    /// # Errors
    /// As [`Coverages::save`].
    pub fn save_with(&self, path: impl AsRef<Path>, options: &SaveOptions) -> Result<()> {
        self.0.save_with(path, options)
    }
}
