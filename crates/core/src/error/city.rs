//! Errors of generated cities.

use super::kind::ErrorKind;
use crate::quantity::MAX_EXTENT_UNITS;

/// The reason why no city can be generated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum CityError {
    /// A built-up parameter is out of range.
    #[error("cannot generate a city: {name} is `{found}`, wanted {wanted}")]
    Parameter { name: &'static str, found: f64, wanted: &'static str },
    /// The word of a scene names no city; `found` is the part that should.
    #[error("cannot read scene `{word}`: found `{found}`, wanted a named environment or `α,β,γ`")]
    Word { word: String, found: String },
    /// A length \[m\] is not above 0 m: the size or the cell size.
    #[error("cannot generate a city: the {length} is `{found}`, wanted above 0 m")]
    Length { length: &'static str, found: f64 },
    /// The ground \[m\] is beyond the heights of the lattice.
    #[error("cannot place the ground at `{found}` m: wanted within ±32768 m")]
    Ground { found: f64 },
    /// The city is larger than the lattice: its edge \[m\], without and with the margin.
    #[error(
        "cannot generate a city: the size is {size_m} m{}, wanted at most {MAX_EXTENT_UNITS} m",
        if whole_m > size_m { format!(", and {whole_m} m with what whole discs take") } else { String::new() }
    )]
    Size { size_m: f64, whole_m: f64 },
    /// More cells a side than the lattice has.
    #[error("cannot generate a city: {found} cells a side, wanted at most {MAX_EXTENT_UNITS}")]
    Cells { found: f64 },
    /// Too many buildings.
    #[error("cannot generate a city: about {found:.0} buildings, wanted at most {most}")]
    Buildings { found: f64, most: f64 },
}

impl CityError {
    pub(super) fn class_and_code(&self) -> (ErrorKind, u16) {
        match self {
            CityError::Parameter { .. } => (ErrorKind::Usage, 110),
            CityError::Word { .. } => (ErrorKind::Usage, 111),
            CityError::Length { .. } => (ErrorKind::Usage, 112),
            CityError::Ground { .. } => (ErrorKind::Usage, 113),
            CityError::Size { .. } | CityError::Cells { .. } | CityError::Buildings { .. } => (ErrorKind::Limit, 502),
        }
    }
}
