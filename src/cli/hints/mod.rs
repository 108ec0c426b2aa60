//! Remedies for errors, in the words of the command line.

pub(in crate::cli) mod core;
mod study;

use crate::error::Error;

/// The remedy for an error, where one is known.
pub(in crate::cli) fn hint(error: &Error) -> Option<String> {
    match error {
        Error::Core(error) => core::hint(error),
        Error::Study(error) => study::hint(error),
    }
}
