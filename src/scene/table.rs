//! Lines of tables, for messages.

/// The line of a record: the reader gives the end of the record before it, ahead of comments and empty lines.
pub(crate) fn line_of(text: &str, start: &csv::Position) -> u64 {
    let rest = usize::try_from(start.byte()).ok().and_then(|byte| text.get(byte..)).unwrap_or_default();
    let skipped = rest.lines().take_while(|line| line.is_empty() || line.starts_with('#'));
    start.line() + skipped.count() as u64
}
