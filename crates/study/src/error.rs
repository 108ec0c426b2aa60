//! Errors of this crate: one [`Error`] over one enum for each part, which holds the offending
//! values.
//!
//! Classes and codes are those of [`skyshed_core::error`].

use std::borrow::Cow;

use skyshed_core::ErrorKind;
use skyshed_core::error::one_line;

/// Error of every fallible function of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An engine or a scene failed.
    #[error("{0}")]
    Core(#[from] skyshed_core::Error),
    /// P_LoS cannot be computed for a request.
    #[error("{}", one_line(&.0.to_string()))]
    LosProbability(#[from] LosProbabilityError),
    /// Methods cannot be compared.
    #[error("{}", one_line(&.0.to_string()))]
    Chart(#[from] ChartError),
    /// A stress scene, or a method on it, is at fault.
    #[error("{}", one_line(&.0.to_string()))]
    Stress(#[from] StressError),
}

/// Result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Reason why P_LoS cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum LosProbabilityError {
    /// A number is out of range.
    #[error("cannot compute P_LoS: {what} is `{found}`, wanted {wanted}")]
    OutOfRange { what: &'static str, found: f64, wanted: &'static str },
    /// The UAV is not above the receivers \[m above the ground\].
    #[error("cannot compute P_LoS: the UAV's height is `{uav_height_m}`, wanted above the receivers, {rx_height_m} m")]
    BelowReceivers { uav_height_m: f64, rx_height_m: f64 },
    /// A cause puts users farther away \[m\] than half of the lattice.
    #[error("cannot compute P_LoS: {cause} puts users {distance_m:.0} m away, wanted at most {most_m} m")]
    TooFar { cause: String, distance_m: f64, most_m: f64 },
    /// Whole cities around the longest links \[m\] have too many buildings.
    #[error(
        "cannot simulate whole cities: links of {farthest_m:.0} m need cities of {buildings:.0} buildings, wanted at most \
         {most}"
    )]
    CityTooLarge { farthest_m: f64, buildings: f64, most: f64 },
}

/// Reason why methods cannot be compared on a scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum ChartError {
    /// The method does not fit the scene: what the scene lacks, and the name of a method that fits.
    #[error("the method that was asked for cannot decide this scene: {why}")]
    Method { why: &'static str, instead: Cow<'static, str> },
    /// Two exact engines differ: a fault of the program.
    #[error("cannot chart: `{method}` and `ray` differ for UAV `{uav}`")]
    EnginesDiffer { method: Cow<'static, str>, uav: String },
}

/// Fault of a stress scene, or of a method on it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum StressError {
    /// The answer of a receiver differs from the one known by construction.
    #[error(
        "the answer at row {row}, column {col} of the stress scene {scene} is {found:?}, known by construction is {known}"
    )]
    Truth { scene: String, row: usize, col: usize, found: Option<bool>, known: bool },
    /// An exact method decides receivers wrongly.
    #[error(
        "`{method}`, which is exact, decides {wrong} of {receivers} receivers of {family} wrongly, first row {row}, column \
         {col} of the scene {scene}; wanted 0"
    )]
    ExactIsWrong {
        method: String,
        wrong: u64,
        receivers: u64,
        family: &'static str,
        scene: String,
        row: usize,
        col: usize,
    },
    /// The scene is too large for the integers of the truth.
    #[error("the stress scene {scene} is too large to be decided")]
    TooLarge { scene: String },
    /// The scene cannot be built as drawn.
    #[error("the stress scene {scene} cannot be built: {why}")]
    Build { scene: String, why: String },
    /// A map of the scene has other receivers than the truth.
    #[error("the stress scene {scene} has other receivers as a map")]
    Receivers { scene: String },
}

impl Error {
    fn class_and_code(&self) -> (ErrorKind, u16) {
        use LosProbabilityError as P;
        match self {
            Error::Core(error) => (error.kind(), error.number()),
            Error::LosProbability(P::OutOfRange { .. } | P::BelowReceivers { .. }) => (ErrorKind::Usage, 120),
            Error::LosProbability(P::TooFar { .. } | P::CityTooLarge { .. }) => (ErrorKind::Limit, 502),
            Error::Chart(ChartError::Method { .. }) => (ErrorKind::Usage, 118),
            Error::Chart(ChartError::EnginesDiffer { .. }) => (ErrorKind::Check, 603),
            Error::Stress(StressError::Truth { .. }) => (ErrorKind::Check, 601),
            Error::Stress(StressError::ExactIsWrong { .. }) => (ErrorKind::Check, 602),
            Error::Stress(_) => (ErrorKind::Internal, 902),
        }
    }

    /// Returns the class.
    pub fn kind(&self) -> ErrorKind {
        self.class_and_code().0
    }

    /// Returns the stable code, for example `E120`.
    pub fn code(&self) -> String {
        format!("E{:03}", self.class_and_code().1)
    }
}
