//! Errors and warnings, worded so that the reader can act.
//!
//! The crate has one [`Error`], over one enum for each stage. The variants hold the values found.
//! An error has a class (which fixes the exit code of the command line), a stable code and one line
//! of text. The text states what was attempted, what was found and what was wanted. Something odd
//! that is not fatal is a [`Warning`]; its text states what was done instead.
//!
//! Codes are grouped by class and never change their meaning. E1xx is usage, E2xx site or zone,
//! E3xx input file, E4xx output file, E5xx a limit. E6xx is a failed check, E9xx a fault of the
//! program. W-codes follow the same hundreds.
//!
//! | codes | about |
//! |---|---|
//! | E101–E109 | words of the command line, sites and receivers as typed, outputs that cannot be written as asked |
//! | E110–E119 | generated cities, numbers out of range, flags without meaning for the scene |
//! | E120–E124 | P_LoS: a parameter out of range, methods, models, curves, plots |
//! | E201–E207 | inside a building, below the ground, outside the lattice, no ground or roof there, height out of range, position in another CRS, an id twice |
//! | E208–E209 | an area outside the scene, no candidate left |
//! | E301–E307 | rasters: cannot be opened, malformed, truncated, unsupported, all void, rotated, irregular |
//! | E308–E312 | nothing in the file, heights missing, CRS, CRS of two files, no overlap |
//! | E313 | a curve of P_LoS given as a table |
//! | E365 | a property of heights that no feature has |
//! | E401–E403 | an output cannot be written (a bad file), encoded, drawn (faults of the program) |
//! | E501–E504 | memory, extent, threads, edges of footprints that cross too often |
//! | E601–E602 | a stress scene: its truth is not what is known of it, an exact method is wrong |
//! | E603 | a chart: two exact engines differ |
//! | W201–W204 | flat earth, no receiver, heights at which a UAV cannot be, UAVs outside the grid |
//! | W210–W214 | P_LoS: a model left out, without values, used with caution; intervals missing, or wider than asked for |
//! | W320–W334 | rasters: `OddRaster` of the crate of files |
//! | W335, W339 | footprints and rasters brought into another CRS |
//! | W336–W338 | mosaics: tiles that differ where they overlap, cells in no source, too many tiles to name |
//! | W340–W346 | scenes from rasters, triangulation, resampled terrain |
//! | W350–W366 | footprints: what was mended or left out, heights, the ground below solids |
//! | W367 | meshes: cells without a face |
//! | W368 | holes that cover what is outside of their shell |
//! | W370–W372 | vertical systems: one of two files names none, datums that differ, units that contradict each other |
//! | W373 | results of this program given as a scene |
//! | W378–W379 | the data area: not looked for where the extent was typed, or given up where it holds little open ground |
//! | W380 | rows of a table that were left out |

mod city;
mod kind;
mod map;
mod uav;
mod warning;
mod words;

use std::fmt;
use std::sync::Arc;

pub use city::CityError;
pub use kind::ErrorKind;
pub use map::MapError;
pub use uav::{UavAttempt, UavError};
pub use warning::Warning;
pub use words::{MOST_FOUND, escaped, io_words, is_text, one_line, shortened};

/// The error of every fallible function of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum Error {
    /// No city can be generated.
    #[error("{}", one_line(&.0.to_string()))]
    City(#[from] CityError),
    /// A UAV cannot be at the requested place.
    #[error("{}", one_line(&format!("cannot {attempt}: {why}")))]
    Uav { attempt: UavAttempt, why: UavError },
    /// The requested map cannot be made.
    #[error("{}", one_line(&.0.to_string()))]
    Map(#[from] MapError),
    /// The caller stopped the work.
    #[error("interrupted; nothing was written")]
    Interrupted,
    /// A fault of the program: the invariant that failed.
    #[error("{0}")]
    Fault(Fault),
    /// An error, and the larger operation in which it happened.
    #[error("{}", one_line(&format!("{error} ({context})")))]
    Within { error: Box<Error>, context: String },
    /// An error of the code that supplies a scene window by window, or takes its map.
    #[error(transparent)]
    Passed(PassedError),
}

/// An error of a crate above this one, passed through unchanged: one line of text, the class, and
/// the number in the code.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{error}")]
#[expect(missing_docs, reason = "the docs of the type say what its fields are")]
pub struct PassedError {
    pub class: ErrorKind,
    pub number: u16,
    pub error: Arc<dyn std::error::Error + Send + Sync>,
}

impl PartialEq for PassedError {
    fn eq(&self, other: &Self) -> bool {
        (self.class, self.number) == (other.class, other.number) && self.to_string() == other.to_string()
    }
}

/// An invariant that should hold for every request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The grid of a city was refused although the parameters were checked.
    #[error("a checked city has a valid grid")]
    CityGrid,
    /// Solids that are read window by window are no raster.
    #[error("windows of a raster were asked for")]
    NoRaster,
}

/// The result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Returns the error within a larger operation, which its text names at the end, in
    /// parentheses.
    #[must_use]
    pub fn within(self, context: impl fmt::Display) -> Self {
        Error::Within { error: Box::new(self), context: context.to_string() }
    }

    /// Returns the cause without the larger operations in which it happened.
    pub fn innermost(&self) -> &Error {
        match self {
            Error::Within { error, .. } => error.innermost(),
            _ => self,
        }
    }

    fn class_and_code(&self) -> (ErrorKind, u16) {
        match self.innermost() {
            Error::City(error) => error.class_and_code(),
            Error::Uav { why, .. } => (ErrorKind::Site, why.code()),
            Error::Map(error) => error.class_and_code(),
            Error::Interrupted | Error::Within { .. } => (ErrorKind::Interrupted, 130),
            Error::Fault(Fault::CityGrid) => (ErrorKind::Internal, 901),
            Error::Fault(Fault::NoRaster) => (ErrorKind::Internal, 902),
            Error::Passed(error) => (error.class, error.number),
        }
    }

    /// Returns the class of the cause.
    pub fn kind(&self) -> ErrorKind {
        self.class_and_code().0
    }

    /// Returns the stable code, for example `E301`.
    pub fn code(&self) -> String {
        format!("E{:03}", self.number())
    }

    /// Returns the number in the code, for example 301.
    pub fn number(&self) -> u16 {
        self.class_and_code().1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_in_a_larger_thing_keeps_its_class_and_its_code() {
        let error = Error::from(CityError::Word { word: "a\nb".into(), found: "a".into() }).within("in t.vrt\n");
        let text = "cannot read scene `a\\nb`: found `a`, wanted a named environment or `α,β,γ` (in t.vrt\\n)";
        assert_eq!(error.to_string(), text);
        assert_eq!((error.code().as_str(), error.kind().exit_code()), ("E111", 2));
    }
}
