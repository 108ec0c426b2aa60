//! Faults of a request: values that are wrong by themselves, and options that change nothing.

use std::borrow::Cow;

use skyshed_core::city::AntennaFault;
use skyshed_core::quantity::OutOfRange;

/// A fault of a request. Options go by the names of their fields.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Fault {
    /// E113: a number out of range.
    Number(OutOfRange),
    /// E113: an antenna that cannot be.
    Antenna(AntennaFault),
    /// E116: an option that changes nothing.
    Idle {
        /// Name of the option.
        option: Cow<'static, str>,
        /// Reason, as the end of a sentence: "without a raster".
        why: String,
    },
    /// E101: a goal without the share that the least height is to reach.
    ShareWanted(String),
    /// E101: a goal with a share, and nothing to make small.
    MinimizeWanted(String),
    /// E113: heights with several references where the least is wanted.
    MixedHeights,
}

/// The result of a check.
pub type Result<T, E = Fault> = std::result::Result<T, E>;

impl Fault {
    /// Returns the fault of an option that changes nothing.
    pub fn idle(option: impl Into<Cow<'static, str>>, why: impl Into<String>) -> Fault {
        Fault::Idle { option: option.into(), why: why.into() }
    }
}
