//! The error of the program and of its library: those of the crates below, and words of its own.

use std::fmt;

pub use skyshed_core::error::{ErrorClass, Warning};
pub(crate) use skyshed_core::error::{MOST_FOUND, escaped, io_words, is_text, shortened};

/// The error of every fallible function of this crate.
///
/// It has a class, which fixes the exit code of the command line, a stable code, and one line of text.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// Of scenes, engines, files and maps.
    Core(skyshed_core::Error),
    /// Of P_LoS, placement and comparisons.
    Study(skyshed_study::Error),
}

/// The result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An error with a stable code and one line of text.
    pub(crate) fn new(class: ErrorClass, code: u16, text: impl Into<String>) -> Self {
        Error::Core(skyshed_core::Error::new(class, code, text))
    }

    /// A usage error (E1xx).
    pub(crate) fn usage(code: u16, text: impl Into<String>) -> Self {
        Error::new(ErrorClass::Usage, code, text)
    }

    /// A bad site, zone or position (E2xx).
    pub(crate) fn site(code: u16, text: impl Into<String>) -> Self {
        Error::new(ErrorClass::Site, code, text)
    }

    /// A bad input file (E3xx), or an output file that cannot be written (E401).
    pub(crate) fn file(code: u16, text: impl Into<String>) -> Self {
        Error::new(ErrorClass::File, code, text)
    }

    /// A request over a limit (E5xx).
    pub(crate) fn limit(code: u16, text: impl Into<String>) -> Self {
        Error::new(ErrorClass::Limit, code, text)
    }

    /// A fault of the program (E402 and E403 for outputs, E9xx otherwise).
    pub(crate) fn internal(code: u16, text: impl Into<String>) -> Self {
        Error::new(ErrorClass::Internal, code, text)
    }

    /// The error as text, with a remedy.
    #[must_use]
    pub(crate) fn with_hint(self, hint: impl Into<String>) -> Self {
        match self {
            Error::Core(error) => Error::Core(error.with_hint(hint)),
            // Those have remedies of their own.
            Error::Study(_) => self,
        }
    }

    /// The cause.
    pub fn class(&self) -> ErrorClass {
        match self {
            Error::Core(error) => error.class(),
            Error::Study(error) => error.class(),
        }
    }

    /// The stable code, for example `E301`.
    pub fn code(&self) -> String {
        match self {
            Error::Core(error) => error.code(),
            Error::Study(error) => error.code(),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Core(error) => error.fmt(f),
            Error::Study(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for Error {}

impl From<skyshed_core::Error> for Error {
    fn from(error: skyshed_core::Error) -> Self {
        Error::Core(error)
    }
}

impl From<skyshed_study::Error> for Error {
    /// What a study only passes on is of the crate below it.
    fn from(error: skyshed_study::Error) -> Self {
        match error {
            skyshed_study::Error::Core(error) => Error::Core(error),
            error => Error::Study(error),
        }
    }
}
