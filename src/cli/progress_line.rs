//! Progress of a run on standard error.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::{interrupt, say};
use crate::expected::seconds_to_read;
use crate::progress::Progress;

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
            say::note(&words());
            next_line = now + SILENT_BETWEEN;
        }
    }
    bar.iter().for_each(ProgressBar::finish_and_clear);
}
