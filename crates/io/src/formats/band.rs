//! Bands of rasters.

use skyshed_request::Band;

use crate::error::{Error, ReadFault, Result};
use crate::input::Input;

/// Returns the index of the band among those of a file, counted from 0.
///
/// # Errors
/// E108 if the file has no such band.
pub(super) fn index_of_band(band: &Band, input: &Input, names: &[Option<&str>]) -> Result<usize> {
    let found = match band {
        Band::First => Some(0),
        Band::Number(number) => number.checked_sub(1).filter(|band| *band < names.len()),
        Band::Name(name) => names.iter().position(|other| *other == Some(name.as_str())),
    };
    let wanted = match band {
        Band::First => "1".into(),
        Band::Number(number) => number.to_string(),
        Band::Name(name) => name.clone(),
    };
    found.ok_or_else(|| Error::read(input, ReadFault::NoBand { wanted, bands: bands_in_words(names) }))
}

/// Returns the bands of a file in words: number, and name where there is one.
pub(super) fn bands_in_words(names: &[Option<&str>]) -> Vec<String> {
    let word = |(band, name): (usize, &Option<&str>)| match name {
        Some(name) => format!("{} `{name}`", band + 1),
        None => (band + 1).to_string(),
    };
    names.iter().enumerate().map(word).collect()
}
