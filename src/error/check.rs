//! Failed checks.

/// A check that failed (E6xx).
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum CheckError {
    /// E603: units of work that are not done; their number, the number of all units, one name, its
    /// fault, and the run that would do them.
    #[error("{n_open} of {n_units} units are not done: {name}: {why}")]
    OpenUnits { n_open: usize, n_units: usize, name: String, why: String, by: Restart },
    /// E603: units of work without a file that describes its contents.
    #[error("no file of {0} tells what it holds, wanted a .tif, .exr, .npz, .png or .json among them")]
    NoDocument(String),
}

impl CheckError {
    pub(super) fn code(&self) -> u16 {
        603
    }
}

/// Run that completes units of work that are not done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub(crate) enum Restart {
    /// A run that resumes.
    Resumes,
    /// A run that resumes and may replace files of another run or program.
    Replaces,
    /// No run: a folder has the name of a file.
    Blocked,
}
