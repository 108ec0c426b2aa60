//! Values that are written as words: on a command line, in a document, in a table, as a keyword.

use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

use serde::de::{Error, SeqAccess, Visitor};

/// A value that has a word.
pub trait Word: Copy + PartialEq + 'static {
    /// Every word with its meaning and its value, in the order of help texts. Words without a meaning
    /// are old spellings: they are read, and never written.
    const WORDS: &'static [(&'static str, &'static str, Self)];

    /// Returns the word of this value.
    fn word(self) -> &'static str {
        // Every value has a word: the macro below lists both together.
        Self::WORDS.iter().find(|(_, _, value)| *value == self).map_or("", |(word, ..)| word)
    }

    /// Returns the value of a word, or what was found and wanted instead.
    ///
    /// # Errors
    /// A text for the end of a message: "found `rof`, wanted ground, street or roof".
    fn of_word(text: &str) -> Result<Self, String> {
        let value = Self::WORDS.iter().find(|(word, ..)| *word == text).map(|(.., value)| *value);
        value.ok_or_else(|| format!("found `{text}`, wanted {}", Self::wanted()))
    }

    /// Returns the words that may be written: "ground, street or roof".
    fn wanted() -> String {
        let known = Self::WORDS.iter().filter(|(_, meaning, _)| !meaning.is_empty());
        let words: Vec<&str> = known.map(|(word, ..)| *word).collect();
        match words.split_last() {
            Some((last, [_, ..])) => format!("{} or {last}", words[..words.len() - 1].join(", ")),
            _ => words.concat(),
        }
    }
}

/// Reads a value from its text. Numbers count as their text, and lists as their members between commas:
/// `60`, `[60, "30roof"]`.
#[derive(Debug)]
pub struct TextVisitor<T>(pub PhantomData<T>);

impl<'de, T: FromStr<Err = String>> Visitor<'de> for TextVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a text, a number or a list of these")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<T, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<T, E> {
        self.visit_str(&number.to_string())
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<T, E> {
        self.visit_str(&number.to_string())
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<T, E> {
        self.visit_str(&number.to_string())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut members: A) -> Result<T, A::Error> {
        let mut texts: Vec<String> = Vec::new();
        while let Some(Member(text)) = members.next_element()? {
            texts.push(text);
        }
        self.visit_str(&texts.join(","))
    }
}

/// A member of a list, as text.
struct Member(String);

impl FromStr for Member {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(Member(text.to_string()))
    }
}

impl<'de> serde::Deserialize<'de> for Member {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TextVisitor(PhantomData))
    }
}

/// Serializes a type with `Display` and `FromStr` as its text.
#[macro_export]
macro_rules! text {
    ($Name:ty) => {
        impl ::serde::Serialize for $Name {
            fn serialize<S: ::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> ::serde::Deserialize<'de> for $Name {
            fn deserialize<D: ::serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_any($crate::words::TextVisitor(::std::marker::PhantomData))
            }
        }

        impl ::schemars::JsonSchema for $Name {
            fn schema_name() -> ::std::borrow::Cow<'static, str> {
                stringify!($Name).into()
            }

            fn json_schema(_: &mut ::schemars::SchemaGenerator) -> ::schemars::Schema {
                ::schemars::json_schema!({"type": ["string", "number", "array"]})
            }
        }
    };
}

/// Defines an enum whose values are words. The doc comment of a value is its meaning in help texts and
/// in JSON Schema. `= old "x"` adds a spelling that is read, and never written.
///
/// ```
/// skyshed_core::words! {
///     /// A shape of roofs.
///     pub enum Shape {
///         /// As high as the building is highest
///         Flat = "flat" old "level",
///         /// As the file has them
///         Lod2 = "lod2",
///     }
///     default Flat
/// }
///
/// assert_eq!("level".parse(), Ok(Shape::Flat));
/// assert_eq!(Shape::Lod2.to_string(), "lod2");
/// assert_eq!("x".parse::<Shape>(), Err("found `x`, wanted flat or lod2".to_string()));
/// ```
#[macro_export]
macro_rules! words {
    (
        $(#[$attribute:meta])*
        $visibility:vis enum $Name:ident {
            $(#[doc = $first_meaning:literal] $(#[doc = $meaning:literal])*
              $Value:ident = $word:literal $(old $old:literal)*),+ $(,)?
        }
        $(default $Default:ident)?
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        $visibility enum $Name {
            $(#[doc = $first_meaning] $(#[doc = $meaning])* $Value),+
        }

        impl $Name {
            /// All values, in the order of their words.
            pub const ALL: [$Name; [$(stringify!($Value)),+].len()] = [$($Name::$Value),+];

            /// Returns the word of this value in documents, tables and on the command line.
            pub const fn name(self) -> &'static str {
                match self { $($Name::$Value => $word),+ }
            }
        }

        impl $crate::words::Word for $Name {
            const WORDS: &'static [(&'static str, &'static str, Self)] = &[
                $(($word, $crate::words::trimmed(concat!($first_meaning $(, $meaning)*)), $Name::$Value),
                  $(($old, "", $Name::$Value),)*)+
            ];
        }

        $(impl Default for $Name {
            fn default() -> Self {
                $Name::$Default
            }
        })?

        impl ::std::fmt::Display for $Name {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.write_str(self.name())
            }
        }

        impl ::std::str::FromStr for $Name {
            type Err = String;

            fn from_str(text: &str) -> Result<Self, String> {
                $crate::words::Word::of_word(text)
            }
        }

        impl ::serde::Serialize for $Name {
            fn serialize<S: ::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> ::serde::Deserialize<'de> for $Name {
            fn deserialize<D: ::serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_str($crate::words::TextVisitor(::std::marker::PhantomData))
            }
        }

        impl ::schemars::JsonSchema for $Name {
            fn schema_name() -> ::std::borrow::Cow<'static, str> {
                stringify!($Name).into()
            }

            fn json_schema(_: &mut ::schemars::SchemaGenerator) -> ::schemars::Schema {
                ::schemars::json_schema!({"type": "string", "enum": [$($word),+]})
            }
        }
    };
}

/// Returns a doc comment without the blank that follows its slashes.
#[doc(hidden)]
pub const fn trimmed(text: &'static str) -> &'static str {
    match text.as_bytes().split_first() {
        Some((b' ', rest)) => match std::str::from_utf8(rest) {
            Ok(text) => text,
            Err(_) => text,
        },
        _ => text,
    }
}
