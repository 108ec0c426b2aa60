//! Refusals of the command line's parser, in the words of all other errors.

use clap::error::{ContextKind, ContextValue, ErrorKind};

use super::failure::{Failure, Result, refusal, refusal_with};
use super::say;
use crate::error::{MOST_FOUND, shortened};

/// Prints help and version on standard output; returns any other refusal as an error.
///
/// # Errors
/// E101; E401 if standard output cannot be written.
pub(super) fn answer(refusal: &clap::Error) -> Result<()> {
    let mut text = refusal.to_string();
    for kind in [ContextKind::InvalidValue, ContextKind::InvalidArg, ContextKind::InvalidSubcommand] {
        if let Some(ContextValue::String(found)) = refusal.get(kind) {
            text = text.replace(found.as_str(), &shortened(found, MOST_FOUND));
        }
    }
    match refusal.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            let has_colors = say::has_colors(&std::io::stdout());
            say::plain_answer(if has_colors { refusal.render().ansi().to_string() } else { text }.as_bytes())
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let text = "no command, wanted one such as `map`, `link`, `info`, `plos` or `place`";
            Err(refusal_with(101, text, "`skyshed --help` lists all"))
        }
        _ => Err(in_words(text.strip_prefix("error: ").unwrap_or(&text))),
    }
}

/// Returns the parser's text as a failure.
///
/// E101: words of the command line that make no sense.
pub(super) fn in_words(text: &str) -> Failure {
    let (first, rest) = text.split_once("\n\n").unwrap_or((text, ""));
    // Missing arguments are listed on lines of their own; an error is one line.
    let first = first.split('\n').map(str::trim).collect::<Vec<_>>().join(" ");
    // Only the tips with a similar word are kept; the usage line names the command.
    let similar = rest.lines().map(str::trim).find(|l| l.starts_with("tip: a similar"));
    let command = rest.lines().find_map(|l| l.trim().strip_prefix("Usage: "));
    let help = command.map(|usage| {
        let words: Vec<&str> = usage.split(' ').take_while(|w| !w.starts_with(['[', '<', '-'])).collect();
        format!("`{} --help` lists what there is", words.join(" "))
    });
    let hints: Vec<String> = [similar.map(|tip| tip.replace("tip: ", "")), help].into_iter().flatten().collect();
    if hints.is_empty() { refusal(101, first) } else { refusal_with(101, first, hints.join("; ")) }
}
