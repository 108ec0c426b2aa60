//! Requests that exceed a limit.

use crate::quantity::MAX_EXTENT_UNITS;

/// A limit that a request exceeds (E5xx).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum LimitError {
    /// E501: a program that alone takes more memory than allowed; both amounts in words.
    #[error("cannot start: the program alone takes {resident} of memory, more than {limit}")]
    Program { resident: String, limit: String },
    /// E501: a run that took more memory than allowed; the limit in words.
    #[error("cannot go on: the run takes more memory than {0}")]
    Exceeded(String),
    /// E501: a scene that needs more memory than allowed; both amounts in words, and `true` if the
    /// user set the limit.
    #[error("cannot map {name}: {what} need {needed} of memory, more than {limit}")]
    Memory { name: String, what: String, needed: String, limit: String, is_typed: bool },
    /// E501: a scene that cannot be mapped strip by strip; the reason, and `true` if the user
    /// requested strips.
    #[error("cannot map {word} strip by strip: {what}")]
    Strips { word: String, what: String, are_asked: bool },
    /// E501: a raster that fits neither memory nor the lattice.
    #[error(
        "cannot map {word}: {n_cols}×{n_rows} cells are neither few enough for memory nor at most {MAX_EXTENT_UNITS} a side"
    )]
    LargeRaster { word: String, n_cols: usize, n_rows: usize },
    /// E501: several UAVs over a raster that is mapped strip by strip.
    #[error("cannot map {word}: strip by strip one UAV is mapped at a time, found {n}")]
    StripsOfMany { word: String, n: usize },
    /// E502: too many candidates.
    #[error("cannot search {n} candidates, wanted at most {most}")]
    Candidates { n: usize, most: usize },
    /// E502: too many placements to compare.
    #[error("cannot compare {n} placements, wanted at most {most}")]
    Placements { n: usize, most: usize },
    /// E502: too many blocks to resample.
    #[error("cannot resample {n} blocks of {edge_m} m, wanted at most {most}")]
    Blocks { n: usize, edge_m: f64, most: usize },
    /// E502: too many combinations in a sweep.
    #[error("cannot compute P_LoS for {n} combinations of what was swept, wanted at most {most}")]
    Combinations { n: usize, most: usize },
    /// E502: too many steps along a track.
    #[error("cannot walk {length} m of track in steps of {every_m} m")]
    Track { length: String, every_m: f64 },
    /// E502: too many links between lists.
    #[error("cannot link {n_uavs} UAVs with {n_receivers} receivers: more than {most} links")]
    Links { n_uavs: usize, n_receivers: usize, most: usize },
    /// E502: too many tiles.
    #[error("cannot cut {word} into tiles of {edge_m} m: more than {most}")]
    Tiles { word: String, edge_m: f64, most: f64 },
    /// E502: a city wider than the lattice \[units\].
    #[error("cannot map {word}: it spans {span:.0} units, wanted at most {MAX_EXTENT_UNITS}")]
    Extent { word: String, span: f64 },
    /// E505: more cells or footprints than a live page holds; how many of which, and what would
    /// fit.
    #[error("cannot make a page of {name}: {n} {what}, wanted at most {most}")]
    PageCity { name: String, n: usize, what: &'static str, most: usize, fits: FitsPage },
    /// E505: a live page that is too long \[MB\].
    #[error("cannot make a page of {name}: it would have {mb} MB, wanted at most {most_mb}")]
    PageBytes { name: String, mb: usize, most_mb: usize },
    /// E505: more UAVs than a live page holds.
    #[error("cannot make a page with {n} UAVs, wanted at most {most}")]
    PageUavs { n: usize, most: usize },
    /// E503: threads that the system refuses to start.
    #[error("cannot start {n} threads: {why}")]
    Threads { n: usize, why: String },
}

/// Part or form of a large city that fits a live page. `cell_m` is the size of cells \[m\] if
/// larger cells would help.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub(crate) enum FitsPage {
    /// Extent of a part of footprints or of a mesh: west, south, east, north \[CRS units\].
    Extent { extent: [f64; 4], cell_m: Option<f64> },
    /// Edge of a smaller generated city \[m\].
    Size { size_m: f64, cell_m: Option<f64> },
    /// Distance from a UAV within which the cells of a raster fit \[m\].
    Range { radius_m: f64 },
    /// Size of larger cells for a raster that is brought into another reference system \[m\].
    Cells { cell_m: f64 },
}

impl LimitError {
    pub(super) fn code(&self) -> u16 {
        use LimitError as L;
        match self {
            L::Program { .. }
            | L::Exceeded(_)
            | L::Memory { .. }
            | L::Strips { .. }
            | L::LargeRaster { .. }
            | L::StripsOfMany { .. } => 501,
            L::Candidates { .. }
            | L::Placements { .. }
            | L::Blocks { .. }
            | L::Combinations { .. }
            | L::Track { .. }
            | L::Links { .. }
            | L::Tiles { .. }
            | L::Extent { .. } => 502,
            L::Threads { .. } => 503,
            L::PageCity { .. } | L::PageBytes { .. } | L::PageUavs { .. } => 505,
        }
    }
}
