//! Words of the command line with a meaning of their own: scenes, and lengths with a unit.

use std::ffi::{OsStr, OsString};
use std::fmt;

use clap::builder::{OsStringValueParser, TypedValueParser};

use crate::city::{BuiltUp, BuiltUpCity};
use crate::error::Result;

/// A scene as typed: the path of a file, which need not be Unicode, or the word for a generated city.
#[derive(Debug, Clone)]
pub(super) struct SceneWord(OsString);

impl SceneWord {
    /// The parameters of a generated city; `None` of a file.
    pub(super) fn built_up(&self) -> Option<Result<BuiltUp>> {
        Some(BuiltUpCity::parse_built_up(self.0.to_str()?)?.map_err(Into::into))
    }

    /// Whether no scene was typed, where none is needed.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl AsRef<OsStr> for SceneWord {
    fn as_ref(&self) -> &OsStr {
        &self.0
    }
}

impl fmt::Display for SceneWord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.display().fmt(f)
    }
}

/// Takes a scene as it is typed.
pub(super) fn scene_word() -> impl TypedValueParser<Value = SceneWord> {
    OsStringValueParser::new().map(SceneWord)
}

/// A length in meters, or in feet with `ft`.
pub(super) fn length(text: &str) -> std::result::Result<f64, String> {
    crate::quantity::parse_meters(text).map_err(|found| format!("{found}, wanted meters, or feet such as 5ft"))
}

/// Refuses a range of which some numbers are in feet and others are not.
pub(super) fn one_unit(range: &str) -> std::result::Result<(), String> {
    let parts: Vec<&str> = range.split(':').collect();
    match parts.iter().filter(|part| part.contains("ft")).count() {
        0 => Ok(()),
        n if n == parts.len() => Ok(()),
        _ => Err("found feet and bare numbers, wanted one unit, such as 100ft:400ft:50ft".into()),
    }
}
