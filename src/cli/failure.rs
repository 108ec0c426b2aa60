//! Failure of a command: an error of the library, or a fault in the words of the command line.

use std::fmt;

use super::hints;
use crate::error::{Error, ErrorKind, ErrorRepr, RequestError};

/// Failure of a command.
#[derive(Debug)]
pub(super) enum Failure {
    /// The library could not answer.
    Library(Error),
    /// The words make no sense: a stable code, the fault, and a remedy.
    Words { code: u16, text: String, remedy: Option<String> },
}

/// Result of everything that a command does.
pub(super) type Result<T, E = Failure> = std::result::Result<T, E>;

/// Returns the failure of words that make no sense, under a stable code.
pub(super) fn refusal(code: u16, text: impl Into<String>) -> Failure {
    Failure::Words { code, text: text.into(), remedy: None }
}

/// Returns the failure of words that make no sense, with a remedy.
pub(super) fn refusal_with(code: u16, text: impl Into<String>, remedy: impl Into<String>) -> Failure {
    Failure::Words { code, text: text.into(), remedy: Some(remedy.into()) }
}

impl Failure {
    /// Returns the stable code, for example `E301`.
    pub(super) fn code(&self) -> String {
        match self {
            Failure::Library(error) => error.code(),
            Failure::Words { code, .. } => format!("E{code}"),
        }
    }

    /// Returns the class, which sets the exit code of the program.
    pub(super) fn kind(&self) -> ErrorKind {
        match self {
            Failure::Library(error) => error.kind(),
            Failure::Words { code, .. } => match code {
                130 => ErrorKind::Interrupted,
                402 => ErrorKind::Internal,
                200..300 => ErrorKind::Site,
                300..500 => ErrorKind::File,
                _ => ErrorKind::Usage,
            },
        }
    }

    /// Returns the remedy, where one is known.
    pub(super) fn remedy(&self) -> Option<String> {
        match self {
            Failure::Library(error) => hints::hint(error),
            Failure::Words { remedy, .. } => remedy.clone(),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Library(error) if names_option(error) => f.write_str(&with_flags(error)),
            Failure::Library(error) => error.fmt(f),
            Failure::Words { text, .. } => f.write_str(&crate::error::one_line(text)),
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        Failure::Library(error)
    }
}

impl From<skyshed_io::Error> for Failure {
    fn from(error: skyshed_io::Error) -> Failure {
        Failure::Library(error.into())
    }
}

/// Returns `true` if the text of an error names an option of the library.
fn names_option(error: &Error) -> bool {
    use RequestError as R;
    match error.repr() {
        ErrorRepr::Request(error) => {
            matches!(
                error,
                R::Uav { .. }
                    | R::NoUav
                    | R::Idle { .. }
                    | R::NoSystem { .. }
                    | R::NothingToResume
                    | R::HeightOfSample(_)
                    | R::Number { .. }
                    | R::GdalValues { .. }
                    | R::GoalNeeds { .. }
            )
        }
        ErrorRepr::Io(error) => matches!(error, skyshed_io::Error::Option(_)),
        _ => false,
    }
}

/// Returns the text of an error, with the options in it as they are typed.
fn with_flags(error: &Error) -> String {
    let text = error.to_string();
    let is_flag = |name: &str| skyshed_request::is_option(&name.replace('-', "_"));
    // Every other part is between two marks.
    let parts = text.split('`').enumerate().map(|(k, part)| {
        let name = part.split(' ').next().unwrap_or_default();
        if k % 2 == 1 && is_flag(name) {
            format!("--{}{}", name.replace('_', "-"), &part[name.len()..])
        } else {
            part.into()
        }
    });
    parts.collect::<Vec<String>>().join("`")
}
