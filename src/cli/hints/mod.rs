//! Remedies for errors, in the words of the command line.

mod io;

pub(in crate::cli) use io::with_skipping;

use crate::error::Error;

/// The remedy for an error, where one is known.
pub(in crate::cli) fn hint(error: &Error) -> Option<String> {
    match error {
        Error::Core(error) => error.hint().map(str::to_string),
        Error::Io(error) => io::hint(error),
    }
}
