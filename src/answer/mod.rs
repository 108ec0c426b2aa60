//! What a question comes to, in every form in which it can be written.
//!
//! Each question of the library has a type that holds what was found and implements [`Answer`]. [`add_outputs`] is the one
//! way from there to files. Documents and rows of tables are types of serde: one definition gives the document, its JSON
//! Schema, the table and the dictionary of its columns.

mod document;
mod features;
mod position;
mod table;

use std::path::{Path, PathBuf};

use serde_json::Value;

pub(crate) use document::{
    Head, Provenance, RunFacts, Share, SourceFacts, Spent, Timing, WarningFacts, digest_words, document_of, warnings_of,
};
pub(crate) use features::{closed_rings, feature, feature_collection};
pub(crate) use position::{Position, PositionFields};
pub(crate) use table::{Rows, columns_of, encoded, rows};

use crate::error::{Result, Warning};
use crate::export::{Batch, Format, with_suffix};
use crate::picture::Look;
use crate::words::pretty;

/// A file to write and its format, checked before any work.
pub(crate) type Output = (PathBuf, Format);

/// What was found, ready to be told and written.
pub(crate) trait Answer {
    /// The document. Without `spent` it holds no times, so that equal runs give equal documents.
    fn document(&self, spent: Option<Spent>) -> Value;

    /// What is stored in pictures and rasters and beside tables: the document, or as much of it as says where it is from.
    fn provenance(&self) -> Value {
        self.document(None)
    }

    /// The table, its header first; empty where there is none.
    fn table(&self) -> Rows {
        Rows::new()
    }

    /// Adds the table, and beside it where it is from.
    ///
    /// # Errors
    /// If the file cannot be made or written.
    fn add_table(&self, batch: &mut Batch, path: &Path, look: &Look) -> Result<()> {
        batch.add(path, &encoded(&self.table(), look.csv_text)?)?;
        Ok(batch.add(&with_suffix(path, ".json"), pretty(&self.provenance()).as_bytes())?)
    }

    /// Adds the files of any other format: pictures, rasters, features.
    ///
    /// # Errors
    /// If the file cannot be made or written.
    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()>;

    /// What was odd.
    fn warnings(&self) -> &[Warning] {
        &[]
    }

    /// What there is, if the user interrupted the work before all was found.
    fn interrupted(&self) -> Option<&'static str> {
        None
    }

    /// What was found, line by line, for standard error.
    fn notes(&self, _spent: Spent) -> Vec<String> {
        Vec::new()
    }

    /// Whether [`Answer::text`] is a few words, which are said beside files, too.
    fn is_in_words(&self) -> bool {
        false
    }

    /// What stands on standard output where no file was asked for.
    ///
    /// # Errors
    /// If a table cannot be encoded.
    fn text(&self, look: &Look) -> Result<String> {
        Ok(String::from_utf8_lossy(&encoded(&self.table(), look.csv_text)?).into_owned())
    }
}

/// Adds all outputs of an answer to a batch.
///
/// # Errors
/// If a file cannot be made or written.
pub(crate) fn add_outputs(
    answer: &dyn Answer,
    batch: &mut Batch,
    outputs: &[Output],
    (look, spent): (&Look, Spent),
) -> Result<()> {
    for (path, format) in outputs {
        match format {
            Format::Stdout => {}
            Format::Json => batch.add(path, pretty(&answer.document(Some(spent))).as_bytes())?,
            Format::Csv => answer.add_table(batch, path, look)?,
            _ => answer.add(batch, path, *format, look)?,
        }
    }
    Ok(())
}
