//! Files of a run as they are checked, and their look.

use std::path::PathBuf;

use skyshed_request::OutputOptions;

use crate::answer::Output;
use crate::cli::failure::{Result, refusal_with};
use crate::export::{Format, OutputRules, check_outputs};
use crate::picture::Look;

/// Returns the files of `-o` with their formats, then the table of `--csv FILE`. All are checked
/// together before any work.
///
/// # Errors
/// E104–E106.
pub(crate) fn checked_files(
    out: &OutputOptions,
    csv: Option<&PathBuf>,
    rules: (&[Format], &[PathBuf]),
) -> Result<Vec<Output>> {
    if let Some(path) = csv.filter(|path| !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"))) {
        let text = format!("cannot write {}: `--csv` writes a table", path.display());
        return Err(refusal_with(105, text, "give it a name that ends in .csv: `--csv NAME.csv`"));
    }
    let all: Vec<PathBuf> = out.files.output.iter().map(|path| &path.0).chain(csv).cloned().collect();
    let (allowed, inputs) = rules;
    Ok(check_outputs(&all, OutputRules { allowed, inputs, overwrite: out.writing.overwrite, bare: false })?)
}

/// Returns the look of files without pictures.
pub(crate) fn plain_look(out: &OutputOptions) -> Look {
    Look { csv_text: out.writing.csv_text, ..Look::default() }
}

/// Returns `true` if a document goes to standard output.
pub(crate) fn is_told(out: &OutputOptions) -> bool {
    out.files.json || out.files.output.iter().any(|path| path.as_os_str() == "-")
}
