//! The files of a comparison.

use std::path::Path;

use super::CompareArgs;
use super::show::Show;
use crate::cli::interrupt;
use crate::coverage::Overlay;
use crate::error::Result;
use crate::export::{Batch, Comparison, Format, add_comparison, with_suffix};
use crate::picture::undrawable;
use crate::render;
use crate::report::{CompareReport, Timing};
use crate::scene::Scene;
use crate::words::pretty;

/// Everything that outputs are made from.
pub(super) struct Writer<'a> {
    pub(super) args: &'a CompareArgs,
    pub(super) scene: &'a Scene,
    /// In the order of the report's placements.
    pub(super) masks: &'a [&'a [u8]],
    /// All masks together.
    pub(super) overlay: &'a Overlay,
    pub(super) report: &'a CompareReport,
    pub(super) timing: Timing,
}

impl Writer<'_> {
    /// Adds the files of one output to a batch.
    pub(super) fn add(&self, batch: &mut Batch, path: &Path, format: Format) -> Result<()> {
        interrupt::check()?;
        let provenance = || self.report.document(None);
        match format {
            Format::GeoTiff => {
                let provenance = provenance().to_string();
                let ids: Vec<&str> = self.report.placements.iter().map(|p| p.id.as_str()).collect();
                let pairs: Vec<(usize, usize)> = self.report.pairs.iter().map(|p| (p.first, p.second)).collect();
                let comparison = Comparison {
                    georef: self.scene.field.grid(),
                    ids: &ids,
                    masks: self.masks,
                    pairs: &pairs,
                    overlay: self.overlay,
                    provenance: &provenance,
                };
                Ok(add_comparison(batch, &comparison, path)?)
            }
            Format::Csv => {
                batch.add(path, &self.args.out.table(&self.report.table())?)?;
                Ok(batch.add(&with_suffix(path, ".json"), pretty(&provenance()).as_bytes())?)
            }
            Format::Png | Format::Svg | Format::Pdf => {
                let show = Show::of(self);
                let software = ("Software".to_string(), format!("skyshed {}", env!("CARGO_PKG_VERSION")));
                let provenance = [software, ("skyshed".to_string(), provenance().to_string())];
                let form = self.args.words.size.form(format);
                let file = show.with_sheet(|sheet| render::draw_compare_sheet(sheet, &form, &provenance));
                Ok(batch.add(path, &file.map_err(undrawable)?)?)
            }
            Format::Html => {
                let page = Show::of(self).page(&provenance()).map_err(undrawable)?;
                Ok(batch.add(path, page.as_bytes())?)
            }
            // The time of writing is not known before the file is written.
            Format::Json => Ok(batch.add(path, pretty(&self.report.document(Some(self.timing))).as_bytes())?),
            _ => Ok(()),
        }
    }
}
