//! Ctrl-C (and a polite `kill`): the program ends at once while nothing is written, and else between two files, so that
//! no temporary file is left.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::messages;
use crate::error::{Error, ErrorClass, Result};

/// Whether files are being written.
static WRITING: Mutex<bool> = Mutex::new(false);
/// Whether the user wants to stop while they are.
static STOP: AtomicBool = AtomicBool::new(false);

fn interrupted() -> Error {
    Error::new(ErrorClass::Interrupted, 130, "interrupted; nothing was written")
}

/// Starts to listen. A process may run several commands, and each begins without writing.
pub(super) fn listen() {
    *WRITING.lock().unwrap_or_else(PoisonError::into_inner) = false;
    let handler = || {
        // Held while the program ends, so that no file is begun meanwhile.
        let writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
        if *writing {
            STOP.store(true, Ordering::Release);
        } else {
            messages::error(&interrupted());
            std::process::exit(i32::from(ErrorClass::Interrupted.exit_code()));
        }
    };
    // A second handler cannot be set in one process; the first one keeps working, so that is no failure.
    let _ = ctrlc::set_handler(handler);
}

/// From here on [`check`] says when to stop.
pub(super) fn begin_writing() {
    *WRITING.lock().unwrap_or_else(PoisonError::into_inner) = true;
}

/// Whether writing may go on.
///
/// # Errors
/// If the user interrupted it.
pub(super) fn check() -> Result<()> {
    if STOP.load(Ordering::Acquire) { Err(interrupted()) } else { Ok(()) }
}
