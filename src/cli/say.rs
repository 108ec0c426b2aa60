//! Lines on standard error (errors, warnings, hints, progress), and answers on standard output.

use std::borrow::Cow;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::{hints, interrupt};
use crate::cli::failure::{Failure, Result, refusal};
use crate::error::{Warning, escaped, io_words, is_text};
use crate::expected::seconds_to_read;
use crate::progress::Progress;

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

/// Time before a run prints its progress.
const SILENT_FOR: Duration = Duration::from_secs(2);
/// Time between two lines of progress without a terminal.
const SILENT_BETWEEN: Duration = Duration::from_secs(10);

/// Stage of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    Reading,
    /// Work that is counted.
    Counting,
    /// Work after the counted work.
    Finishing,
    Writing,
}

impl Stage {
    fn of(progress: &Progress) -> Self {
        match progress.total() {
            _ if interrupt::is_writing() => Stage::Writing,
            0 if progress.has_begun.load(Ordering::Relaxed) => Stage::Finishing,
            0 => Stage::Reading,
            _ => Stage::Counting,
        }
    }

    /// Returns the progress in words. `since` is the time in this stage; `reading_s` is the
    /// expected time of reading.
    fn in_words(self, progress: &Progress, since: Duration, reading_s: f64) -> String {
        let so_far = |what: &str| format!("{what}, {} s so far", since.as_secs());
        match (self, progress.share()) {
            (Stage::Counting, Some(share)) if share > 0.0 => {
                let left = since.as_secs_f64() * (1.0 - share) / share;
                format!("{:.0} % done, about {left:.0} s left", 100.0 * share)
            }
            (Stage::Counting, _) => so_far("working"),
            (Stage::Reading, _) if reading_s > since.as_secs_f64() => {
                format!("reading and preparing, about {:.0} s left", (reading_s - since.as_secs_f64()).ceil())
            }
            (Stage::Reading, _) => so_far("reading and preparing"),
            (Stage::Finishing, _) => so_far("finishing"),
            (Stage::Writing, _) => so_far("writing"),
        }
    }
}

/// Runs `work` and prints its progress on standard error if it takes longer than two seconds. On a
/// terminal one line changes; otherwise a line is printed now and then. `files` are read first.
pub(super) fn with_progress<T>(progress: &Progress, quiet: bool, files: &[PathBuf], work: impl FnOnce() -> T) -> T {
    if quiet {
        return work();
    }
    let (finished, reading_s) = (AtomicBool::new(false), seconds_to_read(files));
    std::thread::scope(|scope| {
        let watcher = scope.spawn(|| watch(progress, reading_s, &finished));
        let result = work();
        finished.store(true, Ordering::Release);
        watcher.thread().unpark();
        result
    })
}

/// Prints the progress of a run until it is finished.
fn watch(progress: &Progress, reading_s: f64, finished: &AtomicBool) {
    let is_terminal = std::io::stderr().is_terminal();
    let start = Instant::now();
    let mut bar: Option<ProgressBar> = None;
    let (mut stage, mut since) = (Stage::Reading, start);
    let mut next_line = start + SILENT_FOR;
    while !finished.load(Ordering::Acquire) {
        std::thread::park_timeout(Duration::from_millis(100));
        let (now, found) = (Instant::now(), Stage::of(progress));
        if found != stage {
            (stage, since) = (found, now);
        }
        let words = || stage.in_words(progress, now - since, reading_s);
        if finished.load(Ordering::Acquire) || now - start < SILENT_FOR {
            continue;
        }
        if is_terminal {
            let style =
                || ProgressStyle::with_template("{spinner} {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = bar.get_or_insert_with(|| ProgressBar::new_spinner().with_style(style()));
            bar.set_message(words());
            bar.tick();
        } else if now >= next_line {
            note(&words());
            next_line = now + SILENT_BETWEEN;
        }
    }
    bar.iter().for_each(ProgressBar::finish_and_clear);
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
