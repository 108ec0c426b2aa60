//! Errors that only the command line can make: words that cannot be read, flags that exclude each other.

use crate::error::{Error, ErrorClass};

/// What the command line says of its own words, under a stable code.
pub(super) fn refusal(code: u16, text: impl Into<String>) -> Error {
    let class = match code {
        130 => ErrorClass::Interrupted,
        402 => ErrorClass::Internal,
        200..300 => ErrorClass::Site,
        300..500 => ErrorClass::File,
        _ => ErrorClass::Usage,
    };
    Error::CommandLine { class, code, text: text.into(), hint: None }
}

/// The same with a remedy.
pub(super) fn refusal_with(code: u16, text: impl Into<String>, remedy: impl Into<String>) -> Error {
    match refusal(code, text) {
        Error::CommandLine { class, code, text, .. } => {
            Error::CommandLine { class, code, text, hint: Some(remedy.into()) }
        }
        error => error,
    }
}
