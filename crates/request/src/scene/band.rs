//! Band of a raster.

use std::fmt;
use std::str::FromStr;

/// Band of a raster that holds its heights.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Band {
    /// The first, because nobody named another.
    #[default]
    First,
    /// A band by its number, counted from 1.
    Number(usize),
    /// A band by its name.
    Name(String),
}

impl Band {
    /// Returns `true` if a band is named, be it the first.
    pub fn is_named(&self) -> bool {
        *self != Band::First
    }
}

/// Reads a number counted from 1, or a name.
///
/// ```
/// use skyshed_request::Band;
///
/// assert_eq!("2".parse(), Ok(Band::Number(2)));
/// assert_eq!("building_height".parse(), Ok(Band::Name("building_height".into())));
/// assert!("0".parse::<Band>().is_err());
/// ```
impl FromStr for Band {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let wrong = || "wanted the number of a band, counted from 1, or its name".to_string();
        if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
            return if text.is_empty() { Err(wrong()) } else { Ok(Band::Name(text.into())) };
        }
        text.parse().ok().filter(|number| *number > 0).map(Band::Number).ok_or_else(wrong)
    }
}

impl fmt::Display for Band {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Band::First => f.write_str("1"),
            Band::Number(number) => number.fmt(f),
            Band::Name(name) => f.write_str(name),
        }
    }
}

skyshed_core::text!(Band);
