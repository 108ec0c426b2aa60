//! Error and warning of the program and its library. Both wrap those of the crates below and add
//! their own, by subject.

mod check;
mod input;
mod limit;
mod places;
mod request;
mod warning;

pub use check::{CheckError, Restart};
pub use input::InputError;
pub use limit::{FitsPage, LimitError};
pub use places::PlacesError;
pub use request::{OfGenerated, RequestError};
pub use skyshed_core::error::ErrorClass;
pub(crate) use skyshed_core::error::{MOST_FOUND, escaped, io_words, is_text, one_line, shortened};
pub(crate) use warning::warned;
pub use warning::{Caution, OddRun, Warning};

use skyshed_core::coverage::NumberFault;
use skyshed_core::quantity::OutOfRange;
use skyshed_request::Fault;

/// The error of every fallible function of this crate.
///
/// It has a class, which fixes the exit code of the command line, a stable code, and one line of
/// text. `docs/codes.md` in the repository explains each code.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An error of scenes, UAVs and engines.
    #[error(transparent)]
    Core(skyshed_core::Error),
    /// An error of P_LoS, placement and comparisons.
    #[error(transparent)]
    Study(skyshed_study::Error),
    /// An error of files.
    #[error(transparent)]
    Io(skyshed_io::Error),
    /// A request that makes no sense.
    #[error("{}", one_line(&.0.to_string()))]
    Request(#[from] RequestError),
    /// A fault of places.
    #[error("{}", one_line(&.0.to_string()))]
    Places(#[from] PlacesError),
    /// An input file that does not fit its purpose.
    #[error("{}", one_line(&.0.to_string()))]
    Input(#[from] InputError),
    /// A request that is too large.
    #[error("{}", one_line(&.0.to_string()))]
    Limit(#[from] LimitError),
    /// A check that failed.
    #[error("{}", one_line(&.0.to_string()))]
    Check(#[from] CheckError),
    /// The error of a unit of work, with the name of the unit.
    #[error("{name}: {error}")]
    #[expect(missing_docs, reason = "the variant says what its fields are")]
    OfUnit { name: String, error: Box<Error> },
    /// E403: a picture could not be drawn; a fault of the program.
    #[error("{}", one_line(&format!("cannot draw the picture: {_0}")))]
    Drawing(String),
    /// E902: a broken invariant; a fault of the program.
    #[error("{0}")]
    Fault(&'static str),
}

/// The result of every fallible function of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Returns E113: a number out of range.
    pub(crate) fn number(what: &'static str, found: f64, wanted: impl Into<String>) -> Self {
        RequestError::Number { what, found, wanted: wanted.into() }.into()
    }

    /// Returns E116: an option that changes nothing.
    pub(crate) fn idle(option: impl Into<std::borrow::Cow<'static, str>>, why: impl Into<String>) -> Self {
        RequestError::Idle { option: option.into(), why: why.into() }.into()
    }

    /// Returns E106: an output file that exists already.
    pub(crate) fn exists(path: &std::path::Path) -> Self {
        let fault = skyshed_io::error::WriteFault::Exists;
        Error::Io(skyshed_io::Error::Write(path.display().to_string(), fault))
    }

    /// Adds the name of a unit of work, unless the error's text already contains it.
    pub(crate) fn of_unit(self, name: &str) -> Self {
        if self.to_string().contains(name) { self } else { Error::OfUnit { name: name.into(), error: Box::new(self) } }
    }

    /// Returns the class of the error.
    pub fn class(&self) -> ErrorClass {
        match self {
            Error::Core(error) => error.class(),
            Error::Study(error) => error.class(),
            Error::Io(error) => error.class(),
            Error::Request(_) => ErrorClass::Usage,
            Error::Places(_) => ErrorClass::Site,
            Error::Input(_) => ErrorClass::File,
            Error::Limit(_) => ErrorClass::Limit,
            Error::Check(_) => ErrorClass::Check,
            Error::OfUnit { error, .. } => error.class(),
            Error::Drawing(_) | Error::Fault(_) => ErrorClass::Internal,
        }
    }

    /// Returns the stable code, for example `E301`.
    pub fn code(&self) -> String {
        let number = match self {
            Error::Core(error) => return error.code(),
            Error::Study(error) => return error.code(),
            Error::Io(error) => return error.code(),
            Error::Request(error) => error.code(),
            Error::Places(error) => error.code(),
            Error::Input(error) => error.code(),
            Error::Limit(error) => error.code(),
            Error::Check(error) => error.code(),
            Error::OfUnit { error, .. } => return error.code(),
            Error::Drawing(_) => 403,
            Error::Fault(_) => 902,
        };
        format!("E{number}")
    }
}

impl From<Fault> for Error {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Number(number) => number.into(),
            Fault::Antenna(antenna) => RequestError::Antenna(antenna).into(),
            Fault::Idle { option, why } => Error::idle(option, why),
            Fault::ShareWanted(goal) => RequestError::ShareWanted(goal).into(),
            Fault::MinimizeWanted(goal) => RequestError::MinimizeWanted(goal).into(),
            Fault::MixedHeights => RequestError::MixedHeights.into(),
            _ => Error::Fault("a request has a fault of an unknown kind"),
        }
    }
}

impl From<OutOfRange> for Error {
    fn from(OutOfRange { what, found, wanted }: OutOfRange) -> Self {
        Error::number(what, found, wanted)
    }
}

impl From<NumberFault> for Error {
    fn from(fault: NumberFault) -> Self {
        match fault {
            NumberFault::Range(number) => number.into(),
            NumberFault::Antenna(fault) => RequestError::Antenna(fault).into(),
        }
    }
}

impl From<skyshed_core::Error> for Error {
    /// Unwraps an error that passed through the core, so that it belongs to its own crate.
    fn from(error: skyshed_core::Error) -> Self {
        skyshed_io::Error::from(error).into()
    }
}

impl From<skyshed_study::Error> for Error {
    /// Unwraps an error of the core that a study passed on.
    fn from(error: skyshed_study::Error) -> Self {
        match error {
            skyshed_study::Error::Core(error) => error.into(),
            error => Error::Study(error),
        }
    }
}

impl From<skyshed_io::Error> for Error {
    /// Unwraps an error of the core that a reader passed on.
    fn from(error: skyshed_io::Error) -> Self {
        match error {
            skyshed_io::Error::Core(error) => Error::Core(error),
            error => Error::Io(error),
        }
    }
}
