//! The one error of this crate: that of the stage in which it happened.

use std::fmt;

pub use skyshed_core::error::{ErrorClass, Warning};
pub(crate) use skyshed_core::error::{MOST_FOUND, escaped, io_words, is_text, shortened};

/// What can go wrong, by the crate that says so.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// The engines, or a request that makes no sense.
    Core(skyshed_core::Error),
    /// A file.
    Io(skyshed_io::Error),
}

/// The result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An error of the given class with a stable code and one line of text.
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

    /// The error with a remedy.
    #[must_use]
    pub(crate) fn with_hint(self, hint: impl Into<String>) -> Self {
        Error::Core(skyshed_core::Error::from(self).with_hint(hint))
    }

    /// The cause, which fixes the exit code of the command line.
    pub fn class(&self) -> ErrorClass {
        match self {
            Error::Core(error) => error.class(),
            Error::Io(error) => error.class(),
        }
    }

    /// The stable code, for example `E301`.
    pub fn code(&self) -> String {
        match self {
            Error::Core(error) => error.code(),
            Error::Io(error) => error.code(),
        }
    }

    /// The remedy, where one is known that is no matter of how it was asked for.
    pub fn hint(&self) -> Option<&str> {
        match self {
            Error::Core(error) => error.hint(),
            Error::Io(_) => None,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Core(error) => error.fmt(f),
            Error::Io(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for Error {}

impl From<skyshed_core::Error> for Error {
    fn from(error: skyshed_core::Error) -> Error {
        Error::Core(error)
    }
}

impl From<skyshed_io::Error> for Error {
    fn from(error: skyshed_io::Error) -> Error {
        match error {
            skyshed_io::Error::Core(error) => Error::Core(error),
            error => Error::Io(error),
        }
    }
}

/// For traits of the core, and closures that it calls.
impl From<Error> for skyshed_core::Error {
    fn from(error: Error) -> skyshed_core::Error {
        match error {
            Error::Core(error) => error,
            Error::Io(error) => error.into(),
        }
    }
}
