//! How a run tells how far it is, and is told to stop.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::coverage::Control;

/// Watches a run, and can stop it from another thread.
///
/// ```
/// use std::sync::Arc;
///
/// use skyshed::ErrorClass;
/// use skyshed::prelude::*;
///
/// let city = Scene::options().size(100.0).open("itu:urban")?;
/// let progress = Arc::new(Progress::default());
/// // Another thread may ask for `share()`, or stop the run; here it is stopped before it begins.
/// progress.stop();
/// let stopped = city.coverage(Uav::new(50.0, 50.0, Height::agl(100.0))).progress(&progress).run();
/// assert_eq!(stopped.unwrap_err().class(), ErrorClass::Interrupted);
/// # Ok::<(), skyshed::Error>(())
/// ```
pub struct Progress {
    pub(crate) control: Control,
    pub(crate) total: AtomicU64,
    /// Whether any work was begun: until then files are read.
    pub(crate) has_begun: AtomicBool,
    pub(crate) note: fn(&str),
    /// Called before work in pieces is begun, which stops between two of them.
    pub(crate) begin_pieces: fn(),
    /// Called before the first file of a run is begun.
    pub(crate) begin_writing: fn(),
    /// Asked between two files, or two parts of one, whether to go on.
    pub(crate) check: fn() -> skyshed_core::Result<()>,
}

impl Default for Progress {
    /// Of a run that nobody watches.
    fn default() -> Self {
        Progress {
            control: Control::default(),
            total: AtomicU64::new(0),
            has_begun: AtomicBool::new(false),
            note: |_| {},
            begin_pieces: || {},
            begin_writing: || {},
            check: || Ok(()),
        }
    }
}

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Progress").field("share", &self.share()).finish_non_exhaustive()
    }
}

impl Progress {
    /// How much of the work at hand is done, 0 to 1; `None` before it has begun.
    pub fn share(&self) -> Option<f64> {
        let total = self.total.load(Ordering::Relaxed);
        #[expect(clippy::cast_precision_loss, reason = "a share for reading")]
        (total > 0).then(|| (self.done() as f64 / total as f64).min(1.0))
    }

    /// Asks the run to stop; it answers with an error of the class `Interrupted`.
    pub fn stop(&self) {
        self.control.stop.store(true, Ordering::Relaxed);
    }

    /// Whether no further piece of work is wanted.
    pub(crate) fn is_stopped(&self) -> bool {
        self.control.stop.load(Ordering::Relaxed) || (self.check)().is_err()
    }

    /// A piece of the work at hand is done.
    pub(crate) fn advance(&self) {
        self.control.done.fetch_add(1, Ordering::Relaxed);
    }

    /// What counts the work, for the engines.
    pub(crate) fn control(&self) -> &Control {
        &self.control
    }

    /// Begins work of so many pieces.
    pub(crate) fn begin(&self, total: u64) {
        self.has_begun.store(true, Ordering::Relaxed);
        self.control.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    /// The work at hand is done.
    pub(crate) fn end(&self) {
        self.total.store(0, Ordering::Relaxed);
    }

    /// Pieces of the work at hand that are done.
    pub(crate) fn done(&self) -> u64 {
        self.control.done.load(Ordering::Relaxed)
    }

    /// Pieces of the work at hand.
    pub(crate) fn total(&self) -> u64 {
        self.total.load(Ordering::Relaxed)
    }
}
