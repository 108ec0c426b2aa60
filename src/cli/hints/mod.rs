//! Remedies for errors and warnings, in the words of the command line.

mod caller;
mod core;
mod io;
mod own;
mod study;
mod warning;

pub(in crate::cli) use caller::hint_for_caller;
pub(in crate::cli) use warning::of_warning;

use crate::error::{Error, ErrorRepr};

/// The remedy for an error, where one is known.
pub(in crate::cli) fn hint(error: &Error) -> Option<String> {
    match error.repr() {
        ErrorRepr::Core(error) => core::hint(error),
        ErrorRepr::Study(error) => study::hint(error),
        ErrorRepr::Io(error) => io::hint(error),
        ErrorRepr::Request(error) => own::of_request(error),
        ErrorRepr::Places(error) => own::of_places(error),
        ErrorRepr::Input(error) => own::of_input(error),
        ErrorRepr::Limit(error) => own::of_limit(error),
        ErrorRepr::OfUnit { error, .. } => hint(error),
        ErrorRepr::Check(error) => own::of_check(error),
        ErrorRepr::Drawing(_) | ErrorRepr::Fault(_) => None,
    }
}
