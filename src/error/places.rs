//! Faults of places: missing, unusable, or not distinguishable.

use skyshed_core::error::UavError;

use crate::quantity::{Height, MAX_EXTENT_UNITS};

/// Fault of a place (E2xx).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum PlacesError {
    /// E201, E202, E204, E205: a receiver cannot be at a position \[CRS units\] and a height.
    #[error("cannot place the receiver at ({}, {}) with height {height}: {why}", .at.0, .at.1)]
    Receiver { at: (f64, f64), height: Height, why: UavError },
    /// E201–E205: several UAVs cannot be at their place; the number of all, the ids and faults of the bad
    /// ones, and the code of the first.
    #[error("cannot place {} of {of} UAVs: {}", faults.len(), told_faults(faults))]
    BadUavs { of: usize, faults: Vec<(String, String)>, code: u16 },
    /// E204: a UAV of a path without a height; the file and the id.
    #[error("cannot place UAV `{id}` of {file}: it has no height there")]
    NoHeight { file: String, id: String },
    /// E203: the ends of a link \[CRS units\] are farther apart than the lattice reaches \[units\].
    #[error(
        "cannot decide the link from ({}, {}) to ({}, {}): it spans {span:.0} units, wanted at most {MAX_EXTENT_UNITS}",
        .from.0, .from.1, .to.0, .to.1
    )]
    LongLink { from: (f64, f64), to: (f64, f64), span: f64 },
    /// E204: users in a zone that the scene does not have.
    #[error("cannot place users on a {zone} of {word}: it has no {zone} cell")]
    NoUsers { zone: &'static str, word: String },
    /// E204: UAVs over places that the scene does not have.
    #[error("cannot place UAVs over {0}: there is no such place")]
    NoPlace(String),
    /// E207: two sites of one name.
    #[error("two {what} are named `{id}`, wanted different ids")]
    Twice { what: &'static str, id: String },
    /// E207: two sites or tiles whose files would be one.
    #[error("`{a}` and `{b}` would share {file}")]
    SharedFile { a: String, b: String, file: String },
    /// E210: times of two UAVs on different clocks; their ids and clocks.
    #[error("UAV `{}` is up at {}, UAV `{}` at {}, wanted one clock for all", .0[0].0, .0[0].1, .0[1].0, .0[1].1)]
    Clocks([(String, &'static str); 2]),
    /// E208: weights without a value above 0 in the scene.
    #[error("cannot use {0} as weights: it holds none above 0 in the scene")]
    NoWeights(String),
    /// E209: every candidate was left out; their number and the reasons.
    #[error("no candidate is left of {total}: {reasons}")]
    NoCandidate { total: u64, reasons: String },
    /// E209: a map of winners without a winner.
    #[error("cannot write {0}: there is no winner to map")]
    NoWinner(String),
    /// E216: a sample of whole discs, of which none lies in the data.
    #[error(
        "cannot sample {word}: of no placement tried lies the whole disc of {radius_m} m in the data, wanted P_LoS over whole \
         discs"
    )]
    NoSampledDisc { word: String, radius_m: String },
    /// E216: places over a real city, none of whose discs lies in the data.
    #[error("cannot place UAVs over {0}: no disc of the largest radius lies in its data")]
    NoDisc(String),
}

/// Most UAVs whose faults are told; of others the ids.
const MOST_FAULTS: usize = 5;

/// Returns words about UAVs that cannot be at their place: each with its fault, of many the others by
/// their ids.
pub(crate) fn told_faults(faults: &[(String, String)]) -> String {
    let told: Vec<&str> = faults.iter().take(MOST_FAULTS).map(|(_, fault)| fault.as_str()).collect();
    let others: Vec<String> = faults.iter().skip(MOST_FAULTS).map(|(id, _)| format!("`{id}`")).collect();
    let others = if others.is_empty() { String::new() } else { format!("; also {}", others.join(", ")) };
    format!("{}{others}", told.join("; "))
}

impl PlacesError {
    pub(super) fn code(&self) -> u16 {
        use PlacesError as P;
        match self {
            P::Receiver { why, .. } => why.code(),
            P::BadUavs { code, .. } => *code,
            P::LongLink { .. } => 203,
            P::NoHeight { .. } | P::NoUsers { .. } | P::NoPlace(_) => 204,
            P::Twice { .. } | P::SharedFile { .. } => 207,
            P::NoWeights(_) => 208,
            P::Clocks(_) => 210,
            P::NoCandidate { .. } | P::NoWinner(_) => 209,
            P::NoSampledDisc { .. } | P::NoDisc(_) => 216,
        }
    }
}
