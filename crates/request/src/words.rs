//! Flags of a command line: readers of their values.

use clap::Command;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParserFactory};
use serde_json::{Map, Value};
use skyshed_core::quantity::read_numbers;
pub use skyshed_core::quantity::{read_angles as pair, read_number as number};
use skyshed_core::words::Word;

use crate::{FilePath, Source};

/// Takes one of some words; old spellings are hidden.
pub fn one_of<T: Word + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let possible = T::WORDS.iter().map(|(word, meaning, _)| match meaning.is_empty() {
        true => PossibleValue::new(*word).hide(true),
        false => PossibleValue::new(*word).help(*meaning),
    });
    // Every other word was refused.
    PossibleValuesParser::new(possible).map(|word| T::of_word(&word).unwrap_or(T::WORDS[0].2))
}

impl ValueParserFactory for FilePath {
    type Parser = clap::builder::MapValueParser<clap::builder::PathBufValueParser, fn(std::path::PathBuf) -> FilePath>;

    fn value_parser() -> Self::Parser {
        clap::builder::PathBufValueParser::new().map(FilePath)
    }
}

impl ValueParserFactory for Source {
    type Parser = clap::builder::MapValueParser<clap::builder::PathBufValueParser, fn(std::path::PathBuf) -> Source>;

    fn value_parser() -> Self::Parser {
        clap::builder::PathBufValueParser::new().map(Source::from)
    }
}

/// Reads an extent: west, south, east, north.
///
/// # Errors
/// The text that was found, and the one that was wanted.
pub fn extent(text: &str) -> Result<[f64; 4], String> {
    read_numbers(text, ',', "W,S,E,N")
}

/// Reads the cells along a side of a tile, at least those of a block of a GeoTIFF.
///
/// # Errors
/// The text that was found, and the one that was wanted.
pub fn cells_per_side(text: &str) -> Result<usize, String> {
    const BLOCK: usize = 16;
    let is_wanted = |n: &usize| *n >= BLOCK && n.is_multiple_of(BLOCK);
    let wrong = || format!("found `{text}`, wanted a multiple of {BLOCK}");
    text.trim().parse().ok().filter(is_wanted).ok_or_else(wrong)
}

/// Reads the half-width of an interval: `±0.005`, above 0 and below 0.5.
///
/// # Errors
/// The text that was found, and the one that was wanted.
pub fn plus_minus(text: &str) -> Result<f64, String> {
    let digits = text.trim().trim_start_matches('±').trim_start_matches("+-").trim_start_matches("+/-");
    match number(digits) {
        Ok(p) if p > 0.0 && p < 0.5 => Ok(p),
        Ok(p) => Err(format!("found `{p}`, wanted above 0 and below 0.5")),
        Err(found) => Err(found),
    }
}

/// Reads a number of bytes: `800M`, `4G`, `1.5GiB`, or bytes alone.
///
/// # Errors
/// The text that was found, and the one that was wanted.
pub fn memory_size(text: &str) -> Result<u64, String> {
    let wrong = || format!("found `{text}`, wanted a size such as 800M or 4G");
    let upper = text.trim().to_ascii_uppercase();
    let digits = upper.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &upper[digits.len()..] {
        "" | "B" => 1.0,
        "K" | "KB" | "KIB" => 1024.0,
        "M" | "MB" | "MIB" => 1_048_576.0,
        "G" | "GB" | "GIB" => 1_073_741_824.0,
        "T" | "TB" | "TIB" => 1_099_511_627_776.0,
        _ => return Err(wrong()),
    };
    let number = number(digits).map_err(|_| wrong())?;
    if number <= 0.0 {
        return Err(wrong());
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive; saturates")]
    let bytes = (number * unit) as u64;
    Ok(bytes)
}

/// Adds the defaults of a table to the help of flags.
pub fn with_defaults(command: Command, defaults: &Map<String, Value>) -> Command {
    defaults.iter().fold(command, |command, (name, value)| {
        let is_wanted = |flag: &clap::Arg| flag.get_id() == name && flag.get_default_values().is_empty();
        if !command.get_arguments().any(is_wanted) {
            return command;
        }
        let default = crate::json::text(value);
        command.mut_arg(name, |flag| {
            let with = |text: Option<&clap::builder::StyledStr>| {
                let text = text.map(ToString::to_string).unwrap_or_default();
                format!("{text} [default: {}]", default)
            };
            let (short, long) = (with(flag.get_help()), flag.get_long_help().map(|text| with(Some(text))));
            let flag = flag.help(short);
            match long {
                Some(long) => flag.long_help(long),
                None => flag,
            }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_widths_may_have_their_sign() {
        assert_eq!((plus_minus("±0.005"), plus_minus("+-0.01")), (Ok(0.005), Ok(0.01)));
        assert!(plus_minus("0").is_err() && plus_minus("nan").is_err());
    }
}
