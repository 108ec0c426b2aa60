//! Choice of the band of a raster that holds the heights.

use crate::error::{Error, ReadFault, Result};
use crate::input::Input;

/// Band of a raster to read.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Band {
    /// The first, by default.
    #[default]
    First,
    /// A band by its number, counted from 1.
    Number(usize),
    /// A band by its name.
    Name(String),
}

impl Band {
    /// Parses a number counted from 1, or a name.
    ///
    /// ```
    /// use skyshed_io::formats::Band;
    ///
    /// assert_eq!(Band::parse("2"), Some(Band::Number(2)));
    /// assert_eq!(Band::parse("building_height"), Some(Band::Name("building_height".into())));
    /// assert_eq!(Band::parse("0"), None);
    /// ```
    pub fn parse(text: &str) -> Option<Band> {
        let text = text.trim();
        if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
            return (!text.is_empty()).then(|| Band::Name(text.into()));
        }
        text.parse().ok().filter(|number| *number > 0).map(Band::Number)
    }

    /// Returns `true` when a band was named, even if it is the first.
    pub(super) fn is_named(&self) -> bool {
        *self != Band::First
    }

    /// Returns the index of the band among those of a file, counted from 0.
    ///
    /// # Errors
    /// E108 if the file has no such band.
    pub(super) fn index(&self, input: &Input, names: &[Option<&str>]) -> Result<usize> {
        let found = match self {
            Band::First => Some(0),
            Band::Number(number) => number.checked_sub(1).filter(|band| *band < names.len()),
            Band::Name(name) => names.iter().position(|other| *other == Some(name.as_str())),
        };
        let wanted = match self {
            Band::First => "1".into(),
            Band::Number(number) => number.to_string(),
            Band::Name(name) => name.clone(),
        };
        found.ok_or_else(|| Error::read(input, ReadFault::NoBand { wanted, bands: bands_in_words(names) }))
    }
}

/// Returns the bands of a file in words: number, and name where there is one.
pub(super) fn bands_in_words(names: &[Option<&str>]) -> Vec<String> {
    let word = |(band, name): (usize, &Option<&str>)| match name {
        Some(name) => format!("{} `{name}`", band + 1),
        None => (band + 1).to_string(),
    };
    names.iter().enumerate().map(word).collect()
}
