//! Lines on standard error (errors, warnings, hints), and answers on standard output.

use std::borrow::Cow;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::PathBuf;

use super::hints;
use crate::cli::failure::{Failure, Result, refusal};
use crate::error::{Warning, escaped, io_words, is_text};

/// Prints a line on standard error; a closed pipe there is ignored.
fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", escaped(text));
}

/// Returns `true` if a stream is a terminal whose user wants colors (<https://no-color.org>).
pub(super) fn has_colors(stream: &impl IsTerminal) -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    stream.is_terminal() && !is_set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Prints a line that begins with a label, which has a color on a terminal.
fn say_labelled(label: &str, color: u8, text: &str) {
    let text = escaped(text);
    let line = match has_colors(&std::io::stderr()) {
        true => format!("\u{1b}[1;{color}m{label}\u{1b}[0m: {text}"),
        false => format!("{label}: {text}"),
    };
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Prints a failure and its remedy.
pub(super) fn failure(failure: &Failure) {
    const RED: u8 = 31;
    say_labelled(&format!("error[{}]", failure.code()), RED, &failure.to_string());
    if let Some(hint) = failure.remedy() {
        say(&format!("hint: {hint}"));
    }
}

/// Prints warnings, one line each.
pub(super) fn warnings(warnings: &[Warning]) {
    warnings.iter().for_each(|warning| say_warning(warning, ""));
}

/// Prints a warning with its remedy and its context.
fn say_warning(warning: &Warning, context: &str) {
    const YELLOW: u8 = 33;
    let hint = hints::of_warning(warning).map_or_else(String::new, |hint| format!(" ({hint})"));
    say_labelled(&format!("warning[{}]", warning.code()), YELLOW, &format!("{warning}{hint}{context}"));
}

/// Warnings of the runs of a batch, each to be printed once.
#[derive(Debug, Default)]
pub(super) struct WarningsOfRuns {
    /// Each warning with the UAVs or tiles whose runs gave it.
    groups: Vec<(Warning, Vec<String>)>,
}

impl WarningsOfRuns {
    /// Adds the warnings of one run. Warnings that differ in numbers alone count as the same.
    pub(super) fn add(&mut self, uav: &str, warnings: &[Warning]) {
        let words = |warning: &Warning| {
            let words: String = warning.to_string().chars().filter(|c| !c.is_ascii_digit() && *c != '.').collect();
            (warning.code(), words)
        };
        for warning in warnings {
            let is_of_other_run = |uavs: &[String]| uavs.last().is_none_or(|last| last != uav);
            let known =
                self.groups.iter_mut().find(|(other, uavs)| is_of_other_run(uavs) && words(other) == words(warning));
            match known {
                Some((_, uavs)) => uavs.push(uav.to_string()),
                None => self.groups.push((warning.clone(), vec![uav.to_string()])),
            }
        }
    }

    /// Returns each warning as it was given first, with words that name its UAVs or tiles.
    fn told(&self, many: &'static str) -> impl Iterator<Item = (&Warning, String)> {
        /// Largest number of UAVs or tiles that are named.
        const MOST_NAMED: usize = 5;
        self.groups.iter().map(move |(warning, uavs)| {
            if uavs.len() == 1 {
                return (warning, String::new());
            }
            let more = if uavs.len() > MOST_NAMED { " …" } else { "" };
            let named = uavs.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join(", ");
            (warning, format!(" (for {} {many}: {named}{more})", uavs.len()))
        })
    }

    /// Prints the warnings.
    pub(super) fn say(&self, many: &'static str) {
        self.told(many).for_each(|(warning, uavs)| say_warning(warning, &uavs));
    }
}

/// Prints the names of the files that were written.
pub(super) fn wrote(files: &[PathBuf], quiet: bool) {
    if !(quiet || files.is_empty()) {
        let names: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
        note(&format!("wrote {}", names.join(", ")));
    }
}

/// Prints a note.
pub(super) fn note(text: &str) {
    say(text);
}

/// Prints a result on standard output. Control characters in names from files are escaped as in
/// JSON, so that no terminal obeys them. A closed pipe counts as success: the reader has seen
/// enough.
///
/// # Errors
/// E401 if it cannot be written for another reason, such as a full disk.
pub(super) fn answer(text: &str) -> Result<()> {
    let escape = |c: char| if c == '\n' || is_text(c) { c.to_string() } else { format!("\\u{:04x}", u32::from(c)) };
    let text: Cow<'_, str> = match text.chars().all(|c| c == '\n' || is_text(c)) {
        true => text.into(),
        false => text.chars().map(escape).collect::<String>().into(),
    };
    plain_answer(text.as_bytes())
}

/// Prints a text for a program on standard output, as it is.
///
/// # Errors
/// E401 if it cannot be written.
pub(super) fn plain_answer(text: &[u8]) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(refusal(401, format!("cannot write to standard output: {}", io_words(&e))))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::OddRun;

    #[test]
    fn warnings_of_a_batch_are_said_once_and_those_of_one_run_stay_apart() {
        let mut batch = WarningsOfRuns::default();
        let flat = |m: u32| {
            let (farthest_m, drop_m) = (m.into(), f64::from(m / 1000) + 0.5);
            OddRun::FlatEarth { farthest_m, drop_m, is_choice: true }.into()
        };
        for k in 1..=7 {
            let results = |year: u32| OddRun::Results { path: format!("{year}.tif"), schema: "map".into() }.into();
            batch.add(&k.to_string(), &[flat(10_000 + k), results(2019), results(2020)]);
        }
        batch.add("8", &[OddRun::NoReceivers.into()]);
        let told: Vec<String> = batch.told("UAVs").map(|(warning, uavs)| format!("{warning}{uavs}")).collect();
        let of_all = " (for 7 UAVs: 1, 2, 3, 4, 5 …)";
        let wanted = [("at 10001 m", of_all), ("2019.tif", of_all), ("2020.tif", of_all), ("no UAV", "undefined")];
        assert_eq!(told.len(), wanted.len(), "{told:?}");
        for (told, (part, end)) in told.iter().zip(wanted) {
            assert!(told.contains(part) && told.ends_with(end), "{told}");
        }
    }
}
