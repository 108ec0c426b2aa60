//! What is said on standard error: errors, warnings, hints, progress.

use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::coverage::Control;
use crate::error::{Error, Result, Warning};

/// A line on standard error; a closed pipe there is nobody's concern.
fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Prints an error and its hint.
pub(super) fn error(error: &Error) {
    say(&format!("error[{}]: {error}", error.code()));
    if let Some(hint) = error.hint() {
        say(&format!("hint: {hint}"));
    }
}

/// Prints warnings, one line each.
pub(super) fn warnings(warnings: &[Warning]) {
    for warning in warnings {
        say(&format!("warning[{}]: {}", warning.code(), warning.text()));
    }
}

/// Prints what was done.
pub(super) fn note(text: &str) {
    say(text);
}

/// Prints a result on standard output. A closed pipe means that the reader has seen enough: that is success.
///
/// # Errors
/// Internal error (E401) if it cannot be written for another reason, such as a full disk.
pub(super) fn answer(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Error::internal(401, format!("cannot write to standard output: {e}")))
        }
        _ => Ok(()),
    }
}

/// How long work may take before a bar is worth showing.
const SHOW_AFTER: Duration = Duration::from_secs(1);

/// Runs `work`, which counts up to `total` of something, under a progress bar on standard error: shown when it takes longer than a second, on a terminal only.
pub(super) fn with_progress<T>(
    control: &Control,
    (total, what): (u64, &str),
    quiet: bool,
    work: impl FnOnce() -> T,
) -> T {
    if quiet || !std::io::stderr().is_terminal() {
        return work();
    }
    let finished = AtomicBool::new(false);
    let style = ProgressStyle::with_template(&format!("{{bar:40}} {{percent}}% of {what}, {{eta}} left"))
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let start = Instant::now();
            let mut bar: Option<ProgressBar> = None;
            while !finished.load(Ordering::Acquire) {
                std::thread::park_timeout(Duration::from_millis(100));
                if start.elapsed() >= SHOW_AFTER {
                    let bar = bar.get_or_insert_with(|| ProgressBar::new(total).with_style(style.clone()));
                    bar.set_position(control.done.load(Ordering::Relaxed));
                }
            }
            if let Some(bar) = bar {
                bar.finish_and_clear();
            }
        });
        let result = work();
        finished.store(true, Ordering::Release);
        result
    })
}
