//! Values with a spelling of their own: numbers, or texts that hold them.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use skyshed_core::quantity::{read_fraction, read_length, read_numbers};

/// A number, or a text to read one from.
#[derive(Deserialize)]
#[serde(untagged)]
pub(crate) enum NumberOrText {
    Number(f64),
    Text(String),
}

/// A length. Texts hold meters, or feet: `1.5`, `5ft`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default, Serialize)]
#[serde(transparent)]
pub struct Meters(pub f64);

/// Factor K by which the radius of the earth is multiplied. Texts hold a number, a fraction or `inf`:
/// `1.333`, `4/3`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EarthFactor(pub f64);

impl Serialize for EarthFactor {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() { serializer.serialize_f64(self.0) } else { serializer.serialize_str("inf") }
    }
}

/// Implements reading for a number with a spelling of its own.
macro_rules! number {
    ($Name:ident, $read:path) => {
        impl From<f64> for $Name {
            fn from(value: f64) -> Self {
                $Name(value)
            }
        }

        impl std::str::FromStr for $Name {
            type Err = String;

            fn from_str(text: &str) -> Result<Self, String> {
                $read(text).map($Name)
            }
        }

        impl<'de> Deserialize<'de> for $Name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                match NumberOrText::deserialize(deserializer)? {
                    NumberOrText::Number(number) => Ok($Name(number)),
                    NumberOrText::Text(text) => text.parse().map_err(serde::de::Error::custom),
                }
            }
        }

        impl schemars::JsonSchema for $Name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($Name).into()
            }

            fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
                schemars::json_schema!({"type": ["number", "string"]})
            }
        }
    };
}

number!(Meters, read_length);
number!(EarthFactor, read_fraction);

/// Heights of a table and a plot: from, to, step \[m\], both ends included. Texts hold `30:120:10`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightRange(pub [f64; 3]);

impl std::str::FromStr for HeightRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        read_numbers(text, ':', "A:B:S").map(HeightRange)
    }
}

impl std::fmt::Display for HeightRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [from, to, step] = self.0;
        write!(f, "{from}:{to}:{step}")
    }
}

skyshed_core::text!(HeightRange);

/// Path of a file, or an address.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize, schemars::JsonSchema)]
#[serde(transparent)]
pub struct FilePath(pub PathBuf);

impl Serialize for FilePath {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0.to_string_lossy())
    }
}

/// Implements conversions of all that is a path.
macro_rules! paths {
    ($($Path:ty),+) => {
        $(impl From<$Path> for FilePath {
            fn from(path: $Path) -> Self {
                FilePath(path.into())
            }
        })+
    };
}

paths!(&str, String, &String, PathBuf, &PathBuf, &Path);

impl From<FilePath> for PathBuf {
    fn from(path: FilePath) -> PathBuf {
        path.0
    }
}

impl std::ops::Deref for FilePath {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_numbers_or_texts() {
        let read = |text: &str| serde_json::from_str::<Meters>(text).map_err(|e| e.to_string());
        assert_eq!(read("2"), Ok(Meters(2.0)));
        assert_eq!(read("\"10ft\""), Ok(Meters(3.048)));
        assert!(read("\"x\"").is_err_and(|e| e.contains("wanted meters")));
        assert_eq!(serde_json::to_string(&EarthFactor(f64::INFINITY)).expect("a text"), "\"inf\"");
    }
}
