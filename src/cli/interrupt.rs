//! Ctrl-C (and a polite `kill`): the program ends at once while nothing is written, and else between two files or two parts
//! of a mask, or where that takes long soon after. A second one ends it at once. Temporary files are removed either way. Work
//! in pieces stops between two of them, and what is done by then is written.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use super::say;
use crate::cli::failure::{Failure, refusal};
use crate::error::{Error, Result};
use crate::export::abandon_files;
use crate::memory;
use crate::progress::Progress;
use crate::quantity::counted;

/// What an interrupt does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// It ends the program.
    Working,
    /// It is noted, and the work stops after the piece at hand; a second one ends the program, and so does a piece that takes
    /// longer than [`GRACE`].
    InPieces,
    /// It is noted, and ends the program between two files or parts of one, or after [`GRACE`]; a second one ends it at once.
    Writing,
}

/// How long a file that is being written, or a piece of work, may take to its end.
const GRACE: Duration = Duration::from_millis(400);

/// What is being done.
static PHASE: Mutex<Phase> = Mutex::new(Phase::Working);
/// Whether the user wants to stop.
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

/// Some files of a run may have their names already.
fn while_writing() -> Failure {
    refusal(130, "interrupted; what was written is whole, the rest is not there")
}

fn enter(phase: Phase) {
    *PHASE.lock().unwrap_or_else(PoisonError::into_inner) = phase;
}

/// Starts to listen. A process may run several commands, and each begins without writing.
pub(super) fn listen() {
    enter(Phase::Working);
    WRITTEN.store(0, Ordering::Release);
    let handler = || {
        // Held while the program ends, so that no file is begun meanwhile.
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
    // A second handler cannot be set in one process; the first one keeps working, so that is no failure.
    let _ = ctrlc::set_handler(handler);
}

/// Does something after [`GRACE`], in a thread of its own, so that the one that hears signals hears the next.
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

/// Ends the program without a temporary file.
fn end(failure: &Failure) -> ! {
    abandon_files();
    say::failure(failure);
    std::process::exit(i32::from(failure.class().exit_code()));
}

/// From here on [`wants_to_stop`] says when to begin no further piece.
pub(super) fn begin_pieces() {
    enter(Phase::InPieces);
}

/// Whether the user wants no further piece of work.
pub(super) fn wants_to_stop() -> bool {
    STOP.load(Ordering::Acquire)
}

/// The files of one more UAV are written: from here on an interrupt ends the program again.
///
/// # Errors
/// If the user interrupted the writing.
pub(super) fn end_writing() -> Result<()> {
    WRITTEN.fetch_add(1, Ordering::AcqRel);
    give_up_writing()
}

/// The files of a UAV will not be written: from here on an interrupt ends the program again.
///
/// # Errors
/// If the user interrupted the writing.
pub(super) fn give_up_writing() -> Result<()> {
    enter(Phase::Working);
    Ok(check()?)
}

/// From here on [`check`] says when to stop. A run that took too much memory writes nothing.
pub(super) fn begin_writing() {
    memory::end_if_exceeded();
    enter(Phase::Writing);
}

/// Whether files are being written.
pub(super) fn is_writing() -> bool {
    *PHASE.lock().unwrap_or_else(PoisonError::into_inner) == Phase::Writing
}

/// Whether writing may go on.
///
/// # Errors
/// If the user interrupted it.
pub(super) fn check() -> skyshed_core::Result<()> {
    memory::end_if_exceeded();
    if wants_to_stop() { Err(skyshed_core::Error::Interrupted) } else { Ok(()) }
}

/// A failure in the words of the run: an interrupt says what was written.
pub(super) fn in_words(failure: Failure) -> Failure {
    match failure {
        Failure::Library(Error::Core(skyshed_core::Error::Interrupted)) => interrupted(),
        failure => failure,
    }
}

/// A run that tells what it does, and is asked whether to go on.
pub(super) fn progress(quiet: bool) -> Progress {
    let note: fn(&str) = if quiet { |_| {} } else { say::note };
    Progress { note, begin_pieces, begin_writing, check, ..Progress::default() }
}
