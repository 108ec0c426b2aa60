//! Errors and warnings about files, as values. An [`Error`] is sorted by what it stopped, with the
//! cause inside; a [`Warning`] by what is odd.
//!
//! Codes and classes are those of [`skyshed_core::error`]. Every text is one line without control
//! characters, and long passages in backticks are shortened. No text names a flag: only the caller
//! knows how an option was given, so the caller adds the remedy.

mod read;
mod warning;
mod write;

use std::fmt::Display;
use std::sync::Arc;

pub use read::{Cause, HeightOf, HeightsMissing, InputKind, Namer, Place, PlacesIn, ReadError, ReadFault, Wanted};

pub use skyshed_core::error::{ErrorKind, MOST_FOUND, io_words, is_text, shortened};
use skyshed_core::error::{PassedError, one_line};
use thiserror::Error as Words;
pub use warning::{CellsFound, OddFile, OddPair, OddRaster, Oddity, Warning};
pub use write::WriteFault;

use crate::overlay::Tangle;
use crate::raster::Crs;

/// The result of every fallible function of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// The error of every fallible function of this crate.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
pub enum Error {
    /// An error of a stage below this crate.
    #[error(transparent)]
    Core(skyshed_core::Error),
    /// A file that cannot be read, or not used in its role.
    #[error("{}", one_line(&.0.to_string()))]
    Read(Box<ReadError>),
    /// Two files that do not belong together.
    #[error("{}", one_line(&.0.to_string()))]
    Combine(#[from] CombineError),
    /// A reference system that is unknown, or that no transformation reaches.
    #[error("{}", one_line(&.0.to_string()))]
    Crs(#[from] CrsError),
    /// An option that makes no sense.
    #[error("{}", one_line(&.0.to_string()))]
    Option(#[from] OptionError),
    /// A file that cannot be written: its path or its kind, and the reason.
    #[error("{}", one_line(&format!("cannot {} {_0}: {_1}", _1.verb())))]
    Write(String, WriteFault),
    /// An error, and the larger thing that it occurred in.
    #[error("{}", one_line(&format!("{_0} ({_1})")))]
    Within(Box<Error>, String),
    /// A fault of the program: a broken invariant.
    #[error(transparent)]
    Fault(#[from] Fault),
}

/// Broken invariant, which should hold for any input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Words)]
#[non_exhaustive]
pub enum Fault {
    /// E902: several bands for a file of one.
    #[error("a file of one band passed its check with several")]
    SeveralBands,
    /// E902: a map for a format that holds no raster.
    #[error("a raster format was asked for")]
    NoRasterFormat,
    /// E903: a grid in degrees without extent.
    #[error("a grid in degrees has no extent")]
    NoExtent,
}

/// Two files that do not belong together.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum CombineError {
    /// E311: two files in different reference systems; the files, their systems, and their roles.
    #[error("cannot combine {} in {} with {} in {}: wanted one CRS", .names[0], .crs[0], .names[1], .crs[1])]
    TwoCrs { names: [String; 2], crs: [String; 2], pair: Pair },
    /// E311: heights above an ellipsoid beside heights above a datum.
    #[error("cannot combine {0}: they are tens of meters apart, wanted one datum")]
    TwoDatums(String),
    /// E312: a surface, and a terrain that does not lie below it; both with their grids.
    #[error("cannot combine {0} with {1}: wanted a terrain below the surface, found none at any cell")]
    NoTerrainBelow(String, String),
}

/// Roles of two files that are combined. Tiles belong to one raster, or are a virtual raster and
/// one of its sources; a map comes from an earlier run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the names of the variants say it")]
pub enum Pair {
    FootprintsTerrain,
    SurfaceTerrain,
    Tiles,
    SceneMap,
    WeightsScene,
}

/// A reference system that is unknown, or that no transformation reaches.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum CrsError {
    /// E310: the registry has no such code.
    #[error("unknown coordinate reference system: no EPSG code `{0}` in the registry")]
    UnknownCode(u32),
    /// E310: a text that defines no reference system; its beginning, and the fault.
    #[error("cannot read the coordinate reference system `{0}`: {1}")]
    Unreadable(String, String),
    /// E310: no transformation from one system to another, or none for these coordinates.
    #[error("cannot transform {what} from `{from}` to `{to}`: {why}")]
    NoWay { what: String, from: String, to: String, why: String },
    /// E502: a grid of more cells than 32 bits count.
    #[error("cannot reproject {0} cells: wanted below 2^32")]
    TooManyCells(usize),
}

/// An option that makes no sense.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
pub enum OptionError {
    /// E112: a size of cells that is not above 0.
    #[error("`cell` is `{0}`, wanted above 0 m")]
    Cell(f64),
    /// E113: a number out of range; its option, and what is wanted.
    #[error("`{0}` is `{1}`, wanted {2}")]
    Number(&'static str, f64, &'static str),
    /// E114: an extent without area.
    #[error("`extent` is `{},{},{},{}`, wanted west < east and south < north", .0[0], .0[1], .0[2], .0[3])]
    Extent([f64; 4]),
    /// E116: a size of cells for a file that keeps its own.
    #[error("`cell` has no meaning for {0}: it is in the wanted system and stays")]
    CellKept(String),
}

/// Returns E311 for two files in different reference systems.
pub(crate) fn two_crs((a, a_crs): (impl Display, &Crs), (b, b_crs): (impl Display, &Crs), pair: Pair) -> Error {
    let (names, crs) = ([a.to_string(), b.to_string()], [a_crs.label(), b_crs.label()]);
    CombineError::TwoCrs { names, crs, pair }.into()
}

impl Error {
    /// Returns the error of a file that cannot be read or used.
    pub(crate) fn read(name: impl Display, fault: ReadFault) -> Error {
        Error::Read(Box::new(ReadError { name: name.to_string(), place: None, fault, cause: Cause::AsSaid }))
    }

    /// Returns the error of a feature whose edges cross too often.
    pub(crate) fn tangled(name: impl Display, id: &str, tangle: Tangle) -> Error {
        Error::read(name, ReadFault::Tangle(id.to_string(), tangle.to_string()))
    }

    pub(crate) fn malformed(name: impl Display, what: impl Into<String>) -> Error {
        Error::read(name, ReadFault::Malformed(what.into()))
    }

    pub(crate) fn truncated(name: impl Display, what: impl Into<String>) -> Error {
        Error::read(name, ReadFault::Truncated(what.into()))
    }

    pub(crate) fn unsupported(name: impl Display, what: impl Into<String>) -> Error {
        Error::read(name, ReadFault::Unsupported(what.into()))
    }

    /// Returns the error of a file that cannot be written.
    pub(crate) fn write(name: impl Display, fault: WriteFault) -> Error {
        Error::Write(name.to_string(), fault)
    }

    pub(crate) fn encode(name: impl Display, why: impl Display) -> Error {
        Error::write(name, WriteFault::Encode(why.to_string()))
    }

    pub(crate) fn refused(name: impl Display, cause: &std::io::Error) -> Error {
        Error::write(name, WriteFault::Refused(io_words(cause)))
    }

    /// Adds the place in the file.
    pub(crate) fn at(mut self, place: Place) -> Error {
        if let Error::Read(read) = &mut self {
            read.place = Some(place);
        }
        self
    }

    /// Adds the known cause.
    pub(crate) fn because(mut self, cause: Cause) -> Error {
        if let Error::Read(read) = &mut self {
            read.cause = cause;
        }
        self
    }

    /// Returns `true` for a file in which nothing was found, and nothing is wrong.
    pub(crate) fn is_of_nothing(&self) -> bool {
        matches!(self, Error::Read(read) if matches!(read.fault, ReadFault::Nothing(Wanted::Building | Wanted::CityObjects)))
    }

    /// Adds that the file lies beside the scene, unless another cause is known.
    pub(crate) fn beside_scene(mut self) -> Error {
        if let Error::Read(read) = &mut self
            && read.cause == Cause::AsSaid
        {
            read.cause = Cause::BesideScene;
        }
        self
    }

    /// Adds the larger thing that the error occurred in at the end of its text, in parentheses.
    #[must_use]
    pub fn within(self, more: impl Display) -> Error {
        Error::Within(Box::new(self), more.to_string())
    }

    /// Returns the class, which fixes the exit code of the command line.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Error::Core(error) => error.kind(),
            Error::Within(error, _) => error.kind(),
            Error::Write(_, WriteFault::Encode(_)) => ErrorKind::Internal,
            _ => match self.number() / 100 {
                1 => ErrorKind::Usage,
                2 => ErrorKind::Site,
                5 => ErrorKind::Limit,
                9 => ErrorKind::Internal,
                _ => ErrorKind::File,
            },
        }
    }

    /// Returns the stable code, for example `E301`.
    pub fn code(&self) -> String {
        format!("E{:03}", self.number())
    }

    /// Returns the number of the code.
    fn number(&self) -> u16 {
        match self {
            Error::Core(error) => error.number(),
            Error::Within(error, _) => error.number(),
            Error::Read(error) => error.fault.number(),
            Error::Combine(CombineError::TwoCrs { .. } | CombineError::TwoDatums(_)) => 311,
            Error::Combine(CombineError::NoTerrainBelow(..)) => 312,
            Error::Crs(CrsError::TooManyCells(_)) => 502,
            Error::Crs(_) => 310,
            Error::Option(OptionError::Cell(_)) => 112,
            Error::Option(OptionError::Number(..)) => 113,
            Error::Option(OptionError::Extent(_)) => 114,
            Error::Option(OptionError::CellKept(_)) => 116,
            Error::Write(_, fault) => fault.number(),
            Error::Fault(Fault::SeveralBands | Fault::NoRasterFormat) => 902,
            Error::Fault(Fault::NoExtent) => 903,
        }
    }
}

/// Conversion for traits of the core, through which the core requests windows of a scene.
impl From<Error> for skyshed_core::Error {
    fn from(error: Error) -> skyshed_core::Error {
        match error {
            Error::Core(error) => error,
            error => {
                let (class, number) = (error.kind(), error.number());
                skyshed_core::Error::Passed(PassedError { class, number, error: Arc::new(error) })
            }
        }
    }
}

impl From<skyshed_core::Error> for Error {
    /// Recovers an error of this crate that passed through the core.
    fn from(error: skyshed_core::Error) -> Error {
        let passed = match &error {
            skyshed_core::Error::Passed(passed) => passed.error.downcast_ref::<Error>().cloned(),
            _ => None,
        };
        passed.unwrap_or(Error::Core(error))
    }
}
