//! Number of threads of a run.

use crate::error::{LimitError, Result};

/// Most useful threads for each core.
const MOST_PER_CORE: usize = 4;

/// Runs `work` on the given number of threads, but on no more than are useful. Without a number,
/// `RAYON_NUM_THREADS` sets it. Otherwise there is one thread for each core.
///
/// # Errors
/// E503 if the system gives no thread.
pub(crate) fn in_pool<T: Send>(threads: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let of_environment = || std::env::var("RAYON_NUM_THREADS").ok()?.parse().ok().filter(|n| *n > 0);
    let wanted = threads.map(usize::from).or_else(of_environment).unwrap_or(cores);
    let n_threads = wanted.min(MOST_PER_CORE * cores);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(n_threads)
        .build()
        .map_err(|e| LimitError::Threads { n: n_threads, why: e.to_string() })?;
    Ok(pool.install(work))
}
