//! Remedies for errors, in the words of the command line.

pub(in crate::cli) mod core;
mod io;
mod own;
mod study;

use crate::error::Error;

/// The remedy for an error, where one is known.
pub(in crate::cli) fn hint(error: &Error) -> Option<String> {
    match error {
        Error::Core(error) => core::hint(error),
        Error::Study(error) => study::hint(error),
        Error::Io(error) => io::hint(error),
        Error::Request(error) => own::of_request(error),
        Error::Places(error) => own::of_places(error),
        Error::Input(error) => own::of_input(error),
        Error::Limit(error) => own::of_limit(error),
        Error::Drawing(_) | Error::Fault(_) => None,
    }
}
