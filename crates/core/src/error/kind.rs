//! Kind of an error, which fixes the exit code of the command line.

/// The cause of an [`super::Error`], one per exit code of the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A fault of the program: exit code 1.
    Internal,
    /// The request itself makes no sense: exit code 2.
    Usage,
    /// An input file is bad, or an output file cannot be written: exit code 3.
    File,
    /// A site, zone or position is bad: exit code 4.
    Site,
    /// The request is over a limit of memory, cells or time: exit code 5.
    Limit,
    /// A check failed: exit code 6.
    Check,
    /// The user interrupted the work: exit code 130.
    Interrupted,
}

impl ErrorKind {
    /// Returns the process exit code for this kind.
    pub fn exit_code(self) -> u8 {
        match self {
            ErrorKind::Internal => 1,
            ErrorKind::Usage => 2,
            ErrorKind::File => 3,
            ErrorKind::Site => 4,
            ErrorKind::Limit => 5,
            ErrorKind::Check => 6,
            ErrorKind::Interrupted => 130,
        }
    }
}
