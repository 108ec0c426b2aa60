//! Answer to a question, in every form in which it can be written.
//!
//! Each question of the library has a type that holds its results and implements [`Answer`].
//! [`add_outputs`] is the only way from an answer to files. Documents and rows of tables are types
//! of serde. One definition gives the document, its JSON Schema, the table and the dictionary of
//! its columns.

mod command;
mod document;
mod features;
mod position;
mod table;

use std::path::Path;

use serde_json::Value;
use skyshed_request::{SaveOptions, json};

pub(crate) use command::CommandFacts;
pub(crate) use document::{
    Head, Provenance, RunFacts, Share, SourceFacts, Spent, Timing, WarningFacts, digest_words, document_of, warnings_of,
};
pub(crate) use features::{closed_rings, feature, feature_collection};
pub(crate) use position::{Position, PositionFields};
pub(crate) use table::{Rows, columns_of, encoded, rows};

use crate::error::{Result, Warning};
use crate::export::{Batch, Format, OutputRules, check_outputs, with_suffix};
use crate::picture::Look;
use crate::words::pretty;

pub(crate) use crate::picture::Output;

/// Results of a question, ready to be printed and written.
pub(crate) trait Answer {
    /// Returns the document. Without `spent` it holds no times, so that equal runs give equal
    /// documents.
    fn document(&self, spent: Option<Spent>) -> Value;

    /// Returns the document that pictures and rasters store and that stands beside tables. It may
    /// leave out results.
    fn provenance(&self) -> Value {
        self.document(None)
    }

    /// Returns the table, its header first; empty if the answer has no table.
    fn table(&self) -> Rows {
        Rows::new()
    }

    /// Adds the table, and its provenance in a file beside it.
    ///
    /// # Errors
    /// If the file cannot be made or written.
    fn add_table(&self, batch: &mut Batch, path: &Path, look: &Look) -> Result<()> {
        add_rows(batch, path, (&self.table(), &self.provenance()), look)
    }

    /// Adds the file of any other format: a picture, a raster, features.
    ///
    /// # Errors
    /// If the file cannot be made or written.
    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()>;

    /// Returns the warnings.
    fn warnings(&self) -> &[Warning] {
        &[]
    }

    /// Returns what the answer holds if the user interrupted the work; `None` for a complete
    /// answer.
    fn interrupted(&self) -> Option<&'static str> {
        None
    }

    /// Returns the results line by line, for standard error.
    fn notes(&self, _spent: Spent) -> Vec<String> {
        Vec::new()
    }

    /// Returns `true` if [`Answer::text`] is a few words, which are also printed when files are
    /// written.
    fn is_in_words(&self) -> bool {
        false
    }

    /// Returns the text for standard output where no file was requested.
    ///
    /// # Errors
    /// If a table cannot be encoded.
    fn text(&self, look: &Look) -> Result<String> {
        Ok(String::from_utf8_lossy(&encoded(&self.table(), look.csv_text)?).into_owned())
    }
}

/// Adds a table, and its provenance in a file beside it.
///
/// # Errors
/// If the file cannot be made or written.
pub(crate) fn add_rows(batch: &mut Batch, path: &Path, (rows, provenance): (&Rows, &Value), look: &Look) -> Result<()> {
    batch.add(path, &encoded(rows, look.csv_text)?)?;
    Ok(batch.add(&with_suffix(path, ".json"), pretty(provenance).as_bytes())?)
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

/// Writes an answer to a file in the format of its extension.
///
/// # Errors
/// E104–E109 for a file that cannot be written so; E106 if it exists; E116 for looks without a picture,
/// and for forms of a map; E401 if writing fails.
pub(crate) fn saved(answer: &dyn Answer, formats: &[Format], path: &Path, options: &SaveOptions) -> Result<()> {
    let SaveOptions { forms, picture, writing } = options;
    json::refuse_others(&json::set_members(forms), &[], "but for files of a map")?;
    let rules = OutputRules { allowed: formats, inputs: &[], overwrite: writing.overwrite, bare: false };
    let outputs: Vec<Output> = check_outputs(&[path.to_path_buf()], rules)?;
    let look = Look::checked(picture, writing, &outputs)?;
    let mut batch = Batch::new(writing.overwrite);
    add_outputs(answer, &mut batch, &outputs, (&look, Spent::default()))?;
    Ok(batch.commit().map(|_| ())?)
}
