//! Ctrl-C, and a polite `kill`.
//!
//! While nothing is written, an interrupt ends the program at once. While files are written, it
//! ends the program between two files or two parts of a mask, or after [`GRACE`]. Work in pieces
//! stops between two pieces, and the finished pieces are written. A second interrupt ends the
//! program at once. Temporary files are removed in all cases.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use super::say;
use crate::cli::failure::{Failure, refusal};
use crate::error::{Error, ErrorKind, Result};
use crate::export::abandon_files;
use crate::memory;
use crate::progress::Progress;
use crate::quantity::counted;

/// Effect of an interrupt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// An interrupt ends the program.
    Working,
    /// The first interrupt stops the work after the current piece. A second one ends the program,
    /// and so does a piece that takes longer than [`GRACE`].
    InPieces,
    /// The first interrupt ends the program between two files or parts of one, or after [`GRACE`].
    /// A second one ends it at once.
    Writing,
}

/// Longest time that a file or a piece of work may take to its end after an interrupt.
const GRACE: Duration = Duration::from_millis(400);

/// Current phase.
static PHASE: Mutex<Phase> = Mutex::new(Phase::Working);
/// `true` once the user wants to stop.
static STOP: AtomicBool = AtomicBool::new(false);

/// UAVs whose files are complete, in a run that writes them one by one.
static WRITTEN: AtomicU64 = AtomicU64::new(0);

fn interrupted() -> Failure {
    let text = match WRITTEN.load(Ordering::Acquire) {
        0 => "interrupted; nothing was written".to_string(),
        n => format!("interrupted; the files of {} are written", counted(n, "UAV", "UAVs")),
    };
    refusal(130, text)
}

/// Returns the failure of an interrupted writing: some files may have their names already.
fn while_writing() -> Failure {
    refusal(130, "interrupted; what was written is whole, the rest is not there")
}

fn enter(phase: Phase) {
    *PHASE.lock().unwrap_or_else(PoisonError::into_inner) = phase;
}

/// Starts to listen for interrupts. A process may run several commands, and each begins without
/// writing.
pub(super) fn listen() {
    enter(Phase::Working);
    WRITTEN.store(0, Ordering::Release);
    let handler = || {
        // The lock is held while the program ends, so that no file is begun meanwhile.
        let phase = PHASE.lock().unwrap_or_else(PoisonError::into_inner);
        let is_first = !STOP.swap(true, Ordering::AcqRel);
        match *phase {
            Phase::InPieces if is_first => {
                say::note("interrupted: what is done will be written if the piece at hand ends soon; again: nothing");
                after_grace(|| {
                    let phase = PHASE.lock().unwrap_or_else(PoisonError::into_inner);
                    if *phase == Phase::InPieces {
                        end(&interrupted());
                    }
                });
            }
            Phase::Writing if is_first => after_grace(|| end(&while_writing())),
            Phase::Writing => end(&while_writing()),
            Phase::Working | Phase::InPieces => end(&interrupted()),
        }
    };
    // A process can set one handler only. The first one keeps working, so a failure here is
    // ignored.
    let _ = ctrlc::set_handler(handler);
}

/// Runs `work` after [`GRACE`] in a thread of its own, so that the handler can receive the next
/// signal.
fn after_grace(work: impl FnOnce() + Send + 'static) {
    std::thread::spawn(|| {
        std::thread::sleep(GRACE);
        work();
    });
}

/// Ends the program with an error, from any thread.
pub(super) fn give_up(error: &Error) -> ! {
    let _no_file_is_begun = PHASE.lock().unwrap_or_else(PoisonError::into_inner);
    end(&Failure::Library(error.clone()))
}

/// Ends the program and removes its temporary files.
fn end(failure: &Failure) -> ! {
    abandon_files();
    say::failure(failure);
    std::process::exit(i32::from(failure.kind().exit_code()));
}

/// Begins work in pieces: from here on [`wants_to_stop`] decides if a further piece begins.
pub(super) fn begin_pieces() {
    enter(Phase::InPieces);
}

/// Returns `true` if the user wants no further piece of work.
pub(super) fn wants_to_stop() -> bool {
    STOP.load(Ordering::Acquire)
}

/// Counts the files of one more UAV as written. From here on an interrupt ends the program again.
///
/// # Errors
/// An interrupt by the user while they were written.
pub(super) fn end_writing() -> Result<()> {
    WRITTEN.fetch_add(1, Ordering::AcqRel);
    give_up_writing()
}

/// Gives up the files of a UAV. From here on an interrupt ends the program again.
///
/// # Errors
/// An interrupt by the user while they were written.
pub(super) fn give_up_writing() -> Result<()> {
    enter(Phase::Working);
    Ok(check()?)
}

/// Begins writing: from here on [`check`] decides if it goes on. A run that took too much memory
/// writes nothing.
pub(super) fn begin_writing() {
    memory::end_if_exceeded();
    enter(Phase::Writing);
}

/// Returns `true` while files are written.
pub(super) fn is_writing() -> bool {
    *PHASE.lock().unwrap_or_else(PoisonError::into_inner) == Phase::Writing
}

/// Checks that writing may go on.
///
/// # Errors
/// An interrupt by the user.
pub(super) fn check() -> skyshed_core::Result<()> {
    memory::end_if_exceeded();
    if wants_to_stop() { Err(skyshed_core::Error::Interrupted) } else { Ok(()) }
}

/// Returns a failure in the words of the run: an interrupt names the files that were written.
pub(super) fn in_words(failure: Failure) -> Failure {
    match failure {
        Failure::Library(error) if error.kind() == ErrorKind::Interrupted => interrupted(),
        failure => failure,
    }
}

/// Returns the progress of a run, which prints notes and checks for interrupts.
pub(super) fn progress(quiet: bool) -> Progress {
    let note: fn(&str) = if quiet { |_| {} } else { say::note };
    Progress { note, begin_pieces, begin_writing, check, ..Progress::default() }
}
