//! Progress of a run, and its interruption.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::coverage::Control;

/// Token that reports the progress of a run, and can stop it from another thread.
///
/// ```
/// use std::sync::Arc;
///
/// use skyshed::ErrorKind;
/// use skyshed::prelude::*;
///
/// let city = Scene::options().size(100.0).open("itu:urban")?;
/// let progress = Arc::new(Progress::default());
/// let request = city.coverage(Uav::new(50.0, 50.0, Height::agl(100.0))).progress(&progress);
/// std::thread::scope(|scope| {
///     let run = scope.spawn(|| request.clone().run());
///     while !run.is_finished() {
///         println!("{:.0} %", 100.0 * progress.share().unwrap_or(0.0));
///         std::thread::sleep(std::time::Duration::from_millis(20));
///     }
/// });
/// // Any thread may stop the run; here it is stopped before it begins.
/// progress.stop();
/// assert_eq!(request.run().unwrap_err().kind(), ErrorKind::Interrupted);
/// # Ok::<(), skyshed::Error>(())
/// ```
pub struct Progress {
    pub(crate) control: Control,
    pub(crate) total: AtomicU64,
    /// `true` once any work has begun. Before that, files are read.
    pub(crate) has_begun: AtomicBool,
    pub(crate) note: fn(&str),
    /// Called before work in pieces, which can stop between two pieces.
    pub(crate) begin_pieces: fn(),
    /// Called before the first file of a run is written.
    pub(crate) begin_writing: fn(),
    /// Called between two files, or two parts of one. An error stops the run.
    pub(crate) check: fn() -> skyshed_core::Result<()>,
}

impl Default for Progress {
    /// Returns the progress of a run that nobody watches.
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
    /// Returns the share of the current work that is done, 0 to 1; `None` while no work is under
    /// way. Preparation before the first cell, such as bending a scene, counts as no work.
    pub fn share(&self) -> Option<f64> {
        let total = self.total.load(Ordering::Relaxed);
        #[expect(clippy::cast_precision_loss, reason = "a share for reading")]
        (total > 0).then(|| (self.done() as f64 / total as f64).min(1.0))
    }

    /// Stops the run, which then returns an error of the kind `Interrupted`.
    pub fn stop(&self) {
        self.control.stop.store(true, Ordering::Relaxed);
    }

    /// Returns `true` if the run has to stop.
    pub(crate) fn is_stopped(&self) -> bool {
        self.control.stop.load(Ordering::Relaxed) || (self.check)().is_err()
    }

    /// Counts a piece of the current work as done.
    pub(crate) fn advance(&self) {
        self.control.done.fetch_add(1, Ordering::Relaxed);
    }

    /// Returns the counter of the work, for the engines.
    pub(crate) fn control(&self) -> &Control {
        &self.control
    }

    /// Begins work of `total` pieces.
    pub(crate) fn begin(&self, total: u64) {
        self.has_begun.store(true, Ordering::Relaxed);
        self.control.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    /// Ends the current work.
    pub(crate) fn end(&self) {
        self.total.store(0, Ordering::Relaxed);
    }

    /// Returns the number of pieces of the current work that are done.
    pub(crate) fn done(&self) -> u64 {
        self.control.done.load(Ordering::Relaxed)
    }

    /// Returns the number of pieces of the current work.
    pub(crate) fn total(&self) -> u64 {
        self.total.load(Ordering::Relaxed)
    }
}
