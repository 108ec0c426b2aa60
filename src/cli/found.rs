//! Answer that is kept for another program.

use std::path::PathBuf;

use serde_json::Value;

use crate::answer::{Answer, Rows, Spent};
use crate::error::Warning;

/// Answer in the forms that need no file, and the files that were written.
#[derive(Debug, Clone)]
pub struct Found {
    /// The document, as of `--json`.
    pub document: Value,
    /// The table, its header first; empty where there is none.
    pub table: Rows,
    /// Warnings.
    pub warnings: Vec<Warning>,
    /// Files that were written.
    pub files: Vec<PathBuf>,
}

impl Found {
    /// Of an answer that was written to some files.
    pub(super) fn of(answer: &dyn Answer, spent: Spent, files: Vec<PathBuf>) -> Found {
        Found {
            document: answer.document(Some(spent)),
            table: answer.table(),
            warnings: answer.warnings().to_vec(),
            files,
        }
    }
}
