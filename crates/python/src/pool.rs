//! Work beside the interpreter: it runs in threads of our own while the caller waits, hears Ctrl-C and tells how far it is.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::Watched;
use crate::errors::Failure;

/// Time between two looks at a run.
const GLANCE: Duration = Duration::from_millis(50);

/// The threads that work, of the process that made them: one that was forked has none of its parent's.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The threads that work; as many as `RAYON_NUM_THREADS` says, else one for each core.
pub(crate) fn pool() -> Result<Arc<ThreadPool>, Failure> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((of, pool)) = &*pool
        && *of == process
    {
        return Ok(Arc::clone(pool));
    }
    let made = rayon::ThreadPoolBuilder::new().thread_name(|k| format!("skyshed-{k}")).build();
    let made = Arc::new(made.map_err(|e| Failure::Fault(format!("the system gives no threads: {e}")))?);
    // A parent's threads cannot be joined here.
    std::mem::forget(pool.replace((process, Arc::clone(&made))));
    Ok(made)
}

/// Runs work that is stopped by Ctrl-C; `watch` is told its share of the whole now and then.
pub(crate) fn watched<T: Send + 'static>(
    py: Python<'_>,
    watch: Option<Py<PyAny>>,
    work: impl FnOnce(&Watched) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let progress = Watched::default();
    let (send, receive) = mpsc::sync_channel(1);
    let of_work = Arc::clone(&progress);
    py.detach(pool)?.spawn(move || {
        let done = catch_unwind(AssertUnwindSafe(|| work(&of_work)));
        let _ = send.send(done.unwrap_or_else(|_| Err(Failure::Fault("a thread panicked".into()))));
    });
    let receive = Mutex::new(receive);
    let wait = || {
        let receive = receive.lock().unwrap_or_else(PoisonError::into_inner);
        receive.recv_timeout(GLANCE)
    };
    loop {
        match py.detach(wait) {
            Ok(done) => {
                if let (Some(watch), Ok(_)) = (&watch, &done) {
                    watch.call1(py, (1.0,))?;
                }
                return done.map_err(PyErr::from);
            }
            Err(mpsc::RecvTimeoutError::Disconnected) => {
                return Err(Failure::Fault("a thread was lost".into()).into());
            }
            Err(mpsc::RecvTimeoutError::Timeout) => {}
        }
        let heard = py.check_signals().and_then(|()| match (&watch, progress.share()) {
            (Some(watch), Some(share)) => watch.call1(py, (share,)).map(|_| ()),
            _ => Ok(()),
        });
        if let Err(error) = heard {
            // Work that cannot stop at once, such as reading a file, ends by itself, and its answer is dropped.
            progress.stop();
            return Err(error);
        }
    }
}

/// Runs work on what the caller lends; once Ctrl-C was pressed `stop` tells it to end soon.
pub(crate) fn lent<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let pool = py.detach(pool)?;
    let is_done = AtomicBool::new(false);
    py.detach(|| {
        let waiting = std::thread::current();
        std::thread::scope(|scope| {
            let working = scope.spawn(|| {
                let done = pool.install(work);
                is_done.store(true, Ordering::Release);
                waiting.unpark();
                done
            });
            while !is_done.load(Ordering::Acquire) && !working.is_finished() {
                std::thread::park_timeout(GLANCE);
                if !is_done.load(Ordering::Acquire)
                    && let Err(error) = Python::attach(|py| py.check_signals())
                {
                    stop.store(true, Ordering::Relaxed);
                    let _ = working.join();
                    return Err(error.into());
                }
            }
            working.join().unwrap_or_else(|_| Err(Failure::Fault("a thread panicked".into())))
        })
    })
    .map_err(PyErr::from)
}
