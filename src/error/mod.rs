//! The error of the program and of its library: those of the crates below, and its own by what they are about.

mod input;
mod limit;
mod places;
mod request;

use std::fmt;

pub use input::InputError;
pub use limit::LimitError;
pub use places::PlacesError;
pub use request::{OfGenerated, RequestError};
pub use skyshed_core::error::{ErrorClass, Warning};
pub(crate) use skyshed_core::error::{MOST_FOUND, escaped, io_words, is_text, one_line, shortened};

/// The error of every fallible function of this crate.
///
/// It has a class, which fixes the exit code of the command line, a stable code, and one line of text.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// Of scenes, UAVs and engines.
    Core(skyshed_core::Error),
    /// Of P_LoS, placement and comparisons.
    Study(skyshed_study::Error),
    /// Of files.
    Io(skyshed_io::Error),
    /// A request that makes no sense.
    Request(RequestError),
    /// Places that are not there.
    Places(PlacesError),
    /// A file that is not what it was given as.
    Input(InputError),
    /// A request that is too large.
    Limit(LimitError),
    /// E403: a picture could not be drawn; a fault of the program.
    Drawing(String),
    /// E902: what should have held whatever was asked.
    Fault(&'static str),
    /// What the command line says of its own words.
    #[doc(hidden)]
    CommandLine { class: ErrorClass, code: u16, text: String, hint: Option<String> },
}

/// The result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// E113: a number out of range.
    pub(crate) fn number(what: &'static str, found: f64, wanted: impl Into<String>) -> Self {
        RequestError::Number { what, found, wanted: wanted.into() }.into()
    }

    /// E116: an option that changes nothing.
    pub(crate) fn idle(option: &'static str, why: impl Into<String>) -> Self {
        RequestError::Idle { option, why: why.into() }.into()
    }

    /// E106: an output that is there.
    pub(crate) fn exists(path: &std::path::Path) -> Self {
        let fault = skyshed_io::error::WriteFault::Exists;
        Error::Io(skyshed_io::Error::Write(path.display().to_string(), fault))
    }

    /// The cause.
    pub fn class(&self) -> ErrorClass {
        match self {
            Error::Core(error) => error.class(),
            Error::Study(error) => error.class(),
            Error::Io(error) => error.class(),
            Error::Request(_) => ErrorClass::Usage,
            Error::Places(_) => ErrorClass::Site,
            Error::Input(_) => ErrorClass::File,
            Error::Limit(_) => ErrorClass::Limit,
            Error::Drawing(_) | Error::Fault(_) => ErrorClass::Internal,
            Error::CommandLine { class, .. } => *class,
        }
    }

    /// The stable code, for example `E301`.
    pub fn code(&self) -> String {
        let number = match self {
            Error::Core(error) => return error.code(),
            Error::Study(error) => return error.code(),
            Error::Io(error) => return error.code(),
            Error::Request(error) => error.code(),
            Error::Places(error) => error.code(),
            Error::Input(error) => error.code(),
            Error::Limit(error) => error.code(),
            Error::Drawing(_) => 403,
            Error::Fault(_) => 902,
            Error::CommandLine { code, .. } => *code,
        };
        format!("E{number}")
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Error::Core(error) => return error.fmt(f),
            Error::Study(error) => return error.fmt(f),
            Error::Io(error) => return error.fmt(f),
            Error::Request(error) => error.to_string(),
            Error::Places(error) => error.to_string(),
            Error::Input(error) => error.to_string(),
            Error::Limit(error) => error.to_string(),
            Error::Drawing(why) => format!("cannot draw the picture: {why}"),
            Error::Fault(what) => (*what).to_string(),
            Error::CommandLine { text, .. } => text.clone(),
        };
        f.write_str(&one_line(&text))
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

impl From<skyshed_io::Error> for Error {
    /// What a reader only passes on is of the crate below it.
    fn from(error: skyshed_io::Error) -> Self {
        match error {
            skyshed_io::Error::Core(error) => Error::Core(error),
            error => Error::Io(error),
        }
    }
}

impl From<RequestError> for Error {
    fn from(error: RequestError) -> Self {
        Error::Request(error)
    }
}

impl From<PlacesError> for Error {
    fn from(error: PlacesError) -> Self {
        Error::Places(error)
    }
}

impl From<InputError> for Error {
    fn from(error: InputError) -> Self {
        Error::Input(error)
    }
}

impl From<LimitError> for Error {
    fn from(error: LimitError) -> Self {
        Error::Limit(error)
    }
}
