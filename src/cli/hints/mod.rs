//! Remedies for errors and warnings, in the words of the command line.

mod caller;
mod core;
mod io;
mod own;
mod study;
mod warning;

pub(in crate::cli) use caller::hint_for_caller;
pub(in crate::cli) use warning::of_warning;

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
        Error::OfUnit { error, .. } => hint(error),
        Error::Check(error) => own::of_check(error),
        Error::Drawing(_) | Error::Fault(_) => None,
    }
}
