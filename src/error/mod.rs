//! Error and warning of the program and its library. Both wrap those of the crates below and add
//! their own, by subject.

mod check;
mod input;
mod limit;
mod places;
mod request;
mod warning;

pub(crate) use check::{CheckError, Restart};
pub(crate) use input::InputError;
pub(crate) use limit::{FitsPage, LimitError};
pub(crate) use places::{PlacesError, told_faults};
pub(crate) use request::{OfGenerated, RequestError};
pub use skyshed_core::error::ErrorKind;
pub(crate) use skyshed_core::error::{Error as CoreError, UavError};
pub(crate) use skyshed_core::error::{MOST_FOUND, escaped, io_words, is_text, one_line, shortened};
pub use warning::Warning;
pub(crate) use warning::warned;
pub(crate) use warning::{Caution, OddRun, WarningRepr};

use skyshed_core::coverage::NumberFault;
use skyshed_core::quantity::OutOfRange;
use skyshed_request::Fault;

/// The error of every fallible function of this crate.
///
/// It has a kind, which sets the exit code of the program, a stable code such as `E301`, and one line
/// of text. The text says what is wrong and what was wanted. `docs/codes.md` in the repository
/// explains each code.
///
/// ```
/// use skyshed::{ErrorKind, Scene};
///
/// let error = Scene::open("no/such/city.tif").expect_err("no such file");
/// assert_eq!((error.kind(), error.code().as_str()), (ErrorKind::File, "E301"));
/// ```
#[derive(Clone, PartialEq, thiserror::Error)]
#[error(transparent)]
pub struct Error(Box<ErrorRepr>);

impl std::fmt::Debug for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {self}", self.code())
    }
}

/// ErrorRepr of an error, by the crate or the question that it is about.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum ErrorRepr {
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
    OfUnit { name: String, error: Error },
    /// E403: a picture could not be drawn; a fault of the program.
    #[error("{}", one_line(&format!("cannot draw the picture: {_0}")))]
    Drawing(String),
    /// E902: a broken invariant; a fault of the program.
    #[error("{0}")]
    Fault(&'static str),
}

/// The result of every fallible function of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl<T: Into<ErrorRepr>> From<T> for Error {
    fn from(cause: T) -> Self {
        Error(Box::new(cause.into()))
    }
}

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
        skyshed_io::Error::Write(path.display().to_string(), fault).into()
    }

    /// Adds the name of a unit of work, unless the error's text already contains it.
    pub(crate) fn of_unit(self, name: &str) -> Self {
        if self.to_string().contains(name) { self } else { ErrorRepr::OfUnit { name: name.into(), error: self }.into() }
    }

    /// Returns E902: a broken invariant; a fault of the program.
    pub(crate) fn fault(what: &'static str) -> Self {
        ErrorRepr::Fault(what).into()
    }

    /// Returns the cause.
    pub(crate) fn repr(&self) -> &ErrorRepr {
        &self.0
    }

    /// Returns the kind of the error, which sets the exit code of the program.
    pub fn kind(&self) -> ErrorKind {
        match self.repr() {
            ErrorRepr::Core(error) => error.kind(),
            ErrorRepr::Study(error) => error.kind(),
            ErrorRepr::Io(error) => error.kind(),
            ErrorRepr::Request(_) => ErrorKind::Usage,
            ErrorRepr::Places(_) => ErrorKind::Site,
            ErrorRepr::Input(_) => ErrorKind::File,
            ErrorRepr::Limit(_) => ErrorKind::Limit,
            ErrorRepr::Check(_) => ErrorKind::Check,
            ErrorRepr::OfUnit { error, .. } => error.kind(),
            ErrorRepr::Drawing(_) | ErrorRepr::Fault(_) => ErrorKind::Internal,
        }
    }

    /// Returns the stable code, for example `E301`.
    pub fn code(&self) -> String {
        let number = match self.repr() {
            ErrorRepr::Core(error) => return error.code(),
            ErrorRepr::Study(error) => return error.code(),
            ErrorRepr::Io(error) => return error.code(),
            ErrorRepr::Request(error) => error.code(),
            ErrorRepr::Places(error) => error.code(),
            ErrorRepr::Input(error) => error.code(),
            ErrorRepr::Limit(error) => error.code(),
            ErrorRepr::Check(error) => error.code(),
            ErrorRepr::OfUnit { error, .. } => return error.code(),
            ErrorRepr::Drawing(_) => 403,
            ErrorRepr::Fault(_) => 902,
        };
        format!("E{number}")
    }
}

impl From<Fault> for ErrorRepr {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Number(number) => number.into(),
            Fault::Antenna(antenna) => RequestError::Antenna(antenna).into(),
            Fault::Idle { option, why } => RequestError::Idle { option, why }.into(),
            Fault::ShareWanted(goal) => RequestError::ShareWanted(goal).into(),
            Fault::MinimizeWanted(goal) => RequestError::MinimizeWanted(goal).into(),
            Fault::MixedHeights => RequestError::MixedHeights.into(),
            _ => ErrorRepr::Fault("a request has a fault of an unknown kind"),
        }
    }
}

impl From<OutOfRange> for ErrorRepr {
    fn from(OutOfRange { what, found, wanted }: OutOfRange) -> Self {
        RequestError::Number { what, found, wanted: wanted.into() }.into()
    }
}

impl From<NumberFault> for ErrorRepr {
    fn from(fault: NumberFault) -> Self {
        match fault {
            NumberFault::Range(number) => number.into(),
            NumberFault::Antenna(fault) => RequestError::Antenna(fault).into(),
        }
    }
}

impl From<skyshed_core::Error> for ErrorRepr {
    /// Unwraps an error that passed through the core, so that it belongs to its own crate.
    fn from(error: skyshed_core::Error) -> Self {
        skyshed_io::Error::from(error).into()
    }
}

impl From<skyshed_study::Error> for ErrorRepr {
    /// Unwraps an error of the core that a study passed on.
    fn from(error: skyshed_study::Error) -> Self {
        match error {
            skyshed_study::Error::Core(error) => error.into(),
            error => ErrorRepr::Study(error),
        }
    }
}

impl From<skyshed_io::Error> for ErrorRepr {
    /// Unwraps an error of the core that a reader passed on.
    fn from(error: skyshed_io::Error) -> Self {
        match error {
            skyshed_io::Error::Core(error) => ErrorRepr::Core(error),
            error => ErrorRepr::Io(error),
        }
    }
}
