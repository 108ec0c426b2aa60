//! Text that is one line, whatever it quotes.

use std::borrow::Cow;

/// Most characters of what was found that a message quotes.
pub const MOST_FOUND: usize = 400;

const MOST_CHARACTERS: usize = 4000;

/// Text without control characters, in which passages in backticks are no longer than [`MOST_FOUND`]: what all messages are.
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
        assert_eq!(one_line(&format!("found `{short}`")), format!("found `{short}`"));
        let text = one_line(&format!("found `{long}`, wanted `3`"));
        assert!(text.contains(" … (401 characters) … ") && text.ends_with("éx`, wanted `3`"), "{text}");
        assert_eq!(text.chars().count(), "found ``, wanted `3`".len() + 400);
        // What is escaped becomes longer; the number is that of what was found.
        let bells = one_line(&format!("found `{}`", "\u{7}".repeat(300)));
        assert!(bells.contains("(300 characters)") && bells.chars().count() == 408, "{bells}");
        // Backticks in what was found do not let it through.
        assert!(one_line(&"`a".repeat(100_000)).chars().count() <= 4000);
        assert_eq!(one_line("cannot read `a\nb`"), "cannot read `a\\nb`");
    }

    #[test]
    fn operating_systems_are_quoted_in_one_form() {
        use std::io::{Error as Io, ErrorKind};
        assert_eq!(io_words(&Io::from(ErrorKind::NotFound)), "no such file");
        assert_eq!(io_words(&Io::from(ErrorKind::PermissionDenied)), "permission denied");
        assert_eq!(io_words(&Io::other("Bad things (os error 5)")), "bad things");
    }
}
