//! Text of messages: always one line, whatever it quotes.

use std::borrow::Cow;

/// The most characters that a message quotes from one value.
pub const MOST_FOUND: usize = 400;

const MOST_CHARACTERS: usize = 4000;

/// Makes the text of a message: no control characters, and passages in backticks shortened to
/// [`MOST_FOUND`] characters.
pub fn one_line(text: &str) -> String {
    let cut = |(k, part)| if k % 2 == 1 { shortened(part, MOST_FOUND) } else { escaped(part) };
    let parts: Vec<Cow<'_, str>> = text.split('`').enumerate().map(cut).collect();
    shortened(&parts.join("`"), MOST_CHARACTERS).into_owned()
}

/// Returns `true` for a character of text: no control character, none that ends a line or changes
/// the direction of what follows, and none that XML cannot hold.
pub fn is_text(c: char) -> bool {
    let is_of_direction = matches!(c, '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}');
    !c.is_control() && !is_of_direction && !matches!(c, '\u{2028}' | '\u{2029}' | '\u{FFFE}' | '\u{FFFF}')
}

/// Escapes the characters that are not text ([`is_text`]).
pub fn escaped(text: &str) -> Cow<'_, str> {
    if text.chars().all(is_text) {
        return Cow::Borrowed(text);
    }
    let escape = |c: char| if is_text(c) { c.to_string() } else { c.escape_default().to_string() };
    Cow::Owned(text.chars().map(escape).collect())
}

/// Shortens text to at most `most` characters. Longer text keeps its beginning and its end, with
/// its length between them.
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

/// Returns an operating system's message in the style of all messages: lower case, without its
/// number.
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
        // Escaping makes text longer; the message states the original length.
        let bells = one_line(&format!("found `{}`", "\u{7}".repeat(300)));
        assert!(bells.contains("(300 characters)") && bells.chars().count() == 408, "{bells}");
        // Backticks in the quoted text do not defeat the limit.
        assert!(one_line(&"`a".repeat(100_000)).chars().count() <= 4000);
        assert_eq!(one_line("cannot read `a\nb`"), "cannot read `a\\nb`");
        assert_eq!(one_line("`a\u{202E}gnp.exe`"), "`a\\u{202e}gnp.exe`");
    }

    #[test]
    fn operating_systems_are_quoted_in_one_form() {
        use std::io::{Error as Io, ErrorKind};
        assert_eq!(io_words(&Io::from(ErrorKind::NotFound)), "no such file");
        assert_eq!(io_words(&Io::from(ErrorKind::PermissionDenied)), "permission denied");
        assert_eq!(io_words(&Io::other("Bad things (os error 5)")), "bad things");
    }
}
