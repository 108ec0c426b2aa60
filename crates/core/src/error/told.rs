//! Errors that are text alone.

use super::class::ErrorClass;

/// An error that is text alone: class, code, one line, and a remedy where one is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Told {
    pub(super) class: ErrorClass,
    pub(super) code: u16,
    pub(super) text: String,
    pub(super) hint: Option<String>,
}
