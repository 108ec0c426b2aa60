//! Structs of options, each option defined once.

use std::path::{Path, PathBuf};

use skyshed_core::quantity::Height;

use crate::{EarthFactor, FilePath, GroundChoice, Heights, Meters, Source};

/// A field that may be unset.
pub trait Field {
    /// The type of a set value.
    type Value;

    /// Sets the field.
    fn set(&mut self, value: Self::Value);

    /// Returns `true` if nobody set the field.
    fn is_unset(&self) -> bool;
}

impl<T> Field for Option<T> {
    type Value = T;

    fn set(&mut self, value: T) {
        *self = Some(value);
    }

    fn is_unset(&self) -> bool {
        self.is_none()
    }
}

impl<T> Field for Vec<T> {
    type Value = Vec<T>;

    fn set(&mut self, value: Vec<T>) {
        *self = value;
    }

    fn is_unset(&self) -> bool {
        self.is_empty()
    }
}

impl Field for bool {
    type Value = bool;

    fn set(&mut self, value: bool) {
        *self = value;
    }

    fn is_unset(&self) -> bool {
        !*self
    }
}

/// A value that a setter takes for a `T`.
///
/// Unlike `Into`, one type alone takes whole numbers, so that `seed(7)` needs no suffix.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no value of this option",
    note = "the option takes a value of `{T}`; lists are arrays, as in `.height([100.0])`"
)]
pub trait IntoValue<T> {
    /// Converts the value.
    fn into_value(self) -> T;
}

impl<T> IntoValue<T> for T {
    fn into_value(self) -> T {
        self
    }
}

impl<T, U: IntoValue<T>, const N: usize> IntoValue<Vec<T>> for [U; N] {
    fn into_value(self) -> Vec<T> {
        self.into_iter().map(IntoValue::into_value).collect()
    }
}

impl<const N: usize> IntoValue<Heights> for [Height; N] {
    fn into_value(self) -> Heights {
        Heights(self.into())
    }
}

/// Lets setters take some types for another.
macro_rules! takes {
    ($($Target:ty: $($Source:ty),+;)+) => {
        $($(impl IntoValue<$Target> for $Source {
            fn into_value(self) -> $Target {
                self.into()
            }
        })+)+
    };
}

takes! {
    f64: i32;
    String: &str;
    Meters: f64;
    EarthFactor: f64;
    GroundChoice: f64;
    Heights: Height, Vec<Height>;
    FilePath: &str, String, &String, PathBuf, &PathBuf, &Path;
    Source: &str, String, &String, PathBuf, &PathBuf, &Path;
}

/// Returns the value that was set, or the default of the table.
pub fn filled<T: Default>(given: Option<T>, default: Option<T>) -> T {
    given.or(default).unwrap_or_default()
}

/// The type of a set value of a field: signatures of setters show it as it is.
macro_rules! value {
    (Option<$Value:ty>) => { $Value };
    (Vec<$Value:ty>) => { Vec<$Value> };
    (bool) => { bool };
}

/// Defines a part of a question: a struct whose fields are options.
///
/// A field has its documentation, which is the help of its flag and the description in JSON Schema, and
/// the form of its flag. Its type is an `Option`, a `Vec` or a `bool`. The macro adds
///
/// * serialization, with unset fields as `null`, `[]` and `false`;
/// * the flags of a command line, behind the feature `words`;
/// * a trait of setters, for the part and for everything that holds it (`AsMut` of the part).
macro_rules! part {
    (
        $(#[$attribute:meta])*
        pub struct $Name:ident, $Setters:ident {
            $($(#[doc = $doc:literal])* $(#[arg($($arg:tt)*)])? $field:ident: $Kind:ident $(<$Inner:ty>)?),* $(,)?
        }
    ) => {
        #[derive(Debug, Clone, Default, PartialEq, ::serde::Serialize, ::serde::Deserialize, ::schemars::JsonSchema)]
        #[cfg_attr(feature = "words", derive(clap::Args))]
        #[cfg_attr(feature = "words", group(skip))]
        #[serde(default)]
        $(#[$attribute])*
        pub struct $Name {
            $($(#[doc = $doc])* $(#[cfg_attr(feature = "words", arg($($arg)*))])? pub $field: $Kind $(<$Inner>)?),*
        }

        impl AsMut<$Name> for $Name {
            fn as_mut(&mut self) -> &mut $Name {
                self
            }
        }

        #[doc = concat!("Setters of [`", stringify!($Name), "`] and of everything that holds one.")]
        pub trait $Setters: AsMut<$Name> + Sized {
            $($(#[doc = $doc])*
            #[must_use]
            fn $field(mut self, value: impl $crate::IntoValue<$crate::part::value!($Kind $(<$Inner>)?)>) -> Self {
                $crate::Field::set(&mut AsMut::<$Name>::as_mut(&mut self).$field, value.into_value());
                self
            })*
        }

        impl<T: AsMut<$Name>> $Setters for T {}
    };
}

/// Lets the setters of parts set the fields of a struct that holds the parts.
///
/// ```
/// # use skyshed_request::{Range, SetRange, Sight};
/// struct Question {
///     sight: Sight,
/// }
///
/// skyshed_request::holds!(Question: sight.range Range);
///
/// let question = Question { sight: Sight::default() }.radius(300.0);
/// assert_eq!(question.sight.range.radius, Some(300.0));
/// ```
#[macro_export]
macro_rules! holds {
    ($Name:ty $(where $G:ident)? : $($($path:ident).+ $Part:ty),+ $(,)?) => {
        $crate::holds!(@each [$(<$G>)?] [$Name] $([$($path).+] [$Part])+);
    };
    (@each $generics:tt $Name:tt $($path:tt $Part:tt)+) => {
        $($crate::holds!(@one $generics $Name $path $Part);)+
    };
    (@one [$(<$G:ident>)?] [$Name:ty] [$($path:ident).+] [$Part:ty]) => {
        impl$(<$G>)? AsMut<$Part> for $Name {
            fn as_mut(&mut self) -> &mut $Part {
                &mut self.$($path).+
            }
        }
    };
}

/// Defines a question or a request: a struct of parts. In JSON and on a command line it has the fields of
/// its parts.
///
/// `#[heading]` puts the flags of a part under another heading of the help.
macro_rules! group {
    (
        $(#[doc = $doc:literal])*
        $(#[command($($command:tt)*)])?
        pub struct $Name:ident {
            $($(#[doc = $part_doc:literal])* $(#[heading = $heading:literal])? $part:ident: $Part:ty),* $(,)?
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, Default, PartialEq, ::serde::Serialize, ::serde::Deserialize, ::schemars::JsonSchema)]
        #[cfg_attr(feature = "words", derive(clap::Args))]
        #[cfg_attr(feature = "words", group(skip))]
        #[serde(default)]
        $(#[cfg_attr(feature = "words", command($($command)*))])?
        pub struct $Name {
            $($(#[doc = $part_doc])*
            #[serde(flatten)]
            #[cfg_attr(feature = "words", command(flatten $(, next_help_heading = $heading)?))]
            pub $part: $Part),*
        }
    };
}

pub(crate) use {group, part, value};
