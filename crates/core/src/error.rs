//! What can go wrong, said so that the reader can act.
//!
//! One [`Error`] for the whole crate: a class (which fixes the exit code of the command line), a stable code, one line
//! of text (what was attempted, where, what was found, what was wanted) and, where a remedy is known, a hint. What is
//! odd but not fatal is a [`Warning`]: it says what was done instead.
//!
//! Codes are grouped by class and never change their meaning: E1xx usage, E2xx site or zone, E3xx input file, E4xx
//! output file, E5xx a limit, E6xx a failed check, E9xx a fault of the program; W-codes follow the same hundreds.
//!
//! | codes | about |
//! |---|---|
//! | E101–E109 | words of the command line, sites and receivers as typed, outputs that cannot be written as asked |
//! | E110–E119 | generated cities, numbers out of range, flags without meaning for the scene |
//! | E120–E124 | P_LoS: a parameter out of range, methods, models, curves, plots |
//! | E201–E207 | inside a building, below the ground, outside the lattice, no ground or roof there, height out of range, position in another CRS, an id twice |
//! | E208–E209 | an area outside the scene, no candidate left |
//! | E301–E307 | rasters: cannot be opened, malformed, truncated, unsupported, all void, rotated, irregular |
//! | E308–E312 | nothing in the file, heights missing, CRS, CRS of two files, no overlap |
//! | E313 | a curve of P_LoS given as a table |
//! | E365 | a property of heights that no feature has |
//! | E401–E403 | an output cannot be written (a bad file), encoded, drawn (faults of the program) |
//! | E501–E504 | memory, extent, threads, edges of a footprint that cross too often |
//! | E601–E602 | a stress scene: its truth is not what is known of it, an exact method is wrong |
//! | E603 | a chart: two exact engines differ |
//! | W201–W204 | flat earth, no receiver, heights at which a UAV cannot be, UAVs outside the grid |
//! | W210–W214 | P_LoS: a model left out, without values, used with caution; intervals missing, or wider than asked for |
//! | W320–W334 | rasters, listed at the module of GeoTIFF |
//! | W335, W339 | footprints and rasters brought into another CRS |
//! | W336–W338 | mosaics: tiles that differ where they overlap, cells in no source, too many tiles to name |
//! | W340–W346 | scenes from rasters, triangulation, resampled terrain |
//! | W350–W366 | footprints: what was mended or left out, heights, the ground below solids |
//! | W367 | meshes: cells without a face |
//! | W368 | holes that cover what is outside of their shell |
//! | W370–W372 | vertical systems: one of two files names none, datums that differ, units that contradict each other |
//! | W373 | results of this program given as a scene |
//! | W378–W379 | the data area: not looked for where the extent was typed, or given up where it holds little open ground |
//! | W380 | rows of a table that were left out |

use std::borrow::Cow;
use std::fmt;

/// The cause of an [`Error`], one per exit code of the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorClass {
    /// A fault of the program: exit code 1.
    Internal,
    /// The request itself does not make sense: exit code 2.
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

impl ErrorClass {
    /// The process exit code for this class.
    pub fn exit_code(self) -> u8 {
        match self {
            ErrorClass::Internal => 1,
            ErrorClass::Usage => 2,
            ErrorClass::File => 3,
            ErrorClass::Site => 4,
            ErrorClass::Limit => 5,
            ErrorClass::Check => 6,
            ErrorClass::Interrupted => 130,
        }
    }
}

/// The error of every fallible function of this crate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    class: ErrorClass,
    code: u16,
    text: String,
    hint: Option<String>,
}

/// The result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An error of the given class with a stable code and one line of text.
    ///
    /// Control characters in `text` (which may quote a file) are escaped, so that an error is always one line, and
    /// passages in backticks are cut to 400 characters.
    pub fn new(class: ErrorClass, code: u16, text: impl Into<String>) -> Self {
        Error { class, code, text: one_line(&text.into()), hint: None }
    }

    /// A usage error (E1xx).
    pub fn usage(code: u16, text: impl Into<String>) -> Self {
        Error::new(ErrorClass::Usage, code, text)
    }

    /// A bad site, zone or position (E2xx).
    pub fn site(code: u16, text: impl Into<String>) -> Self {
        Error::new(ErrorClass::Site, code, text)
    }

    /// A bad input file (E3xx), or an output file that cannot be written (E401).
    pub fn file(code: u16, text: impl Into<String>) -> Self {
        Error::new(ErrorClass::File, code, text)
    }

    /// A request over a limit (E5xx).
    pub fn limit(code: u16, text: impl Into<String>) -> Self {
        Error::new(ErrorClass::Limit, code, text)
    }

    /// A fault of the program (E402 and E403 for outputs, E9xx otherwise).
    pub fn internal(code: u16, text: impl Into<String>) -> Self {
        Error::new(ErrorClass::Internal, code, text)
    }

    /// The same error with a remedy.
    #[must_use]
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(one_line(&hint.into()));
        self
    }

    /// The same error with more at the end of its text, in parentheses: the larger thing that it happened in.
    #[must_use]
    pub fn within(mut self, more: impl fmt::Display) -> Self {
        self.text = one_line(&format!("{} ({more})", self.text));
        self
    }

    /// The cause.
    pub fn class(&self) -> ErrorClass {
        self.class
    }

    /// The stable code, for example `E301`.
    pub fn code(&self) -> String {
        format!("E{:03}", self.code)
    }

    /// The remedy, where one is known.
    pub fn hint(&self) -> Option<&str> {
        self.hint.as_deref()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl std::error::Error for Error {}

/// Something odd that did not stop the work: what was found and what was done instead.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    code: u16,
    text: String,
}

impl Warning {
    /// A warning with a stable code and one line of text.
    pub fn new(code: u16, text: impl Into<String>) -> Self {
        Warning { code, text: one_line(&text.into()) }
    }

    /// The same warning with more at the end of its text, in parentheses.
    #[must_use]
    pub fn within(mut self, more: impl fmt::Display) -> Self {
        self.text = one_line(&format!("{} ({more})", self.text));
        self
    }

    /// The stable code, for example `W320`.
    pub fn code(&self) -> String {
        format!("W{:03}", self.code)
    }

    /// One line: what was found, what was done instead.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// Most characters of what was found that a message quotes.
pub const MOST_FOUND: usize = 400;

/// Most characters of a message.
const MOST_CHARACTERS: usize = 4000;

/// Text without control characters, in which passages in backticks are no longer than [`MOST_FOUND`].
pub fn one_line(text: &str) -> String {
    let cut = |(k, part)| if k % 2 == 1 { shortened(part, MOST_FOUND) } else { escaped(part) };
    let parts: Vec<Cow<'_, str>> = text.split('`').enumerate().map(cut).collect();
    shortened(&parts.join("`"), MOST_CHARACTERS).into_owned()
}

/// Whether a character is one of text: not for controlling a terminal, and not one of those that XML cannot hold.
pub fn is_text(c: char) -> bool {
    !c.is_control() && !matches!(c, '\u{FFFE}' | '\u{FFFF}')
}

/// Text whose characters that are none of text ([`is_text`]) are escaped.
pub fn escaped(text: &str) -> Cow<'_, str> {
    if text.chars().all(is_text) {
        return Cow::Borrowed(text);
    }
    let escape = |c: char| if is_text(c) { c.to_string() } else { c.escape_default().to_string() };
    Cow::Owned(text.chars().map(escape).collect())
}

/// Text of at most so many characters: of a longer one the beginning, how long it is, and the end.
pub fn shortened(text: &str, most: usize) -> Cow<'_, str> {
    let whole = escaped(text);
    let n = whole.chars().count();
    if n <= most {
        return whole;
    }
    let gap = format!(" … ({} characters) … ", text.chars().count());
    let kept = most.saturating_sub(gap.chars().count());
    let head: String = whole.chars().take(kept - kept / 4).collect();
    let tail: String = whole.chars().skip(n - kept / 4).collect();
    Cow::Owned(head + &gap + &tail)
}

/// What an operating system says, in the words of all messages: lower case, without its number.
pub fn io_words(cause: &std::io::Error) -> String {
    use std::io::ErrorKind;
    match cause.kind() {
        ErrorKind::NotFound => return "no such file".into(),
        ErrorKind::IsADirectory => return "it is a folder, wanted a file".into(),
        ErrorKind::StorageFull => return "no space is left on the disk".into(),
        _ => {}
    }
    let text = cause.to_string();
    let text = text.split(" (os error").next().unwrap_or_default();
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_found_is_quoted_up_to_a_length() {
        let (short, long) = ("é".repeat(400), "é".repeat(400) + "x");
        assert_eq!(Error::file(302, format!("found `{short}`")).to_string(), format!("found `{short}`"));
        let text = Error::file(302, format!("found `{long}`, wanted `3`")).to_string();
        assert!(text.contains(" … (401 characters) … ") && text.ends_with("éx`, wanted `3`"), "{text}");
        assert_eq!(text.chars().count(), "found ``, wanted `3`".len() + 400);
        // What is escaped becomes longer; the number is that of what was found.
        let bells = Warning::new(320, format!("found `{}`", "\u{7}".repeat(300)));
        assert!(bells.text().contains("(300 characters)") && bells.text().chars().count() == 408, "{bells:?}");
        // Backticks in what was found do not let it through.
        assert!(Error::file(302, "`a".repeat(100_000)).to_string().chars().count() <= 4000);
    }

    #[test]
    fn operating_systems_are_quoted_in_one_form() {
        use std::io::{Error as Io, ErrorKind};
        assert_eq!(io_words(&Io::from(ErrorKind::NotFound)), "no such file");
        assert_eq!(io_words(&Io::from(ErrorKind::PermissionDenied)), "permission denied");
        assert_eq!(io_words(&Io::other("Bad things (os error 5)")), "bad things");
    }

    #[test]
    fn an_error_is_one_line_whatever_it_quotes() {
        let error = Error::file(301, "cannot read `a\nb`").with_hint("rename it");
        assert_eq!(error.to_string(), "cannot read `a\\nb`");
        assert_eq!(error.code(), "E301");
        assert_eq!(error.class().exit_code(), 3);
        assert_eq!(error.hint(), Some("rename it"));
    }
}
