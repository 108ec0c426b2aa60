//! Times of a core that does nothing else.
//!
//! On rented machines a core is often one of two threads of a physical core, and the other belongs to somebody else. While
//! that one works, everything here takes 1.3 to 1.6 times as long, and the kernel does not know. A loop of additions
//! does: they fill the units of a core, so that they take longer whenever these are shared. It runs before and after each run
//! that is timed, and a run is *quiet* if it took as long as it ever takes both times. What is timed itself decides nothing. What
//! happens in between is not seen, so that of long runs a quiet one may have been disturbed.

use std::hint::black_box;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// How much longer than ever the loop may take in a quiet core.
const SLACK: f64 = 1.03;
/// Fewest quiet runs that are a figure; with less of them all runs are.
const ENOUGH: usize = 5;

/// One run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run {
    /// How long it took, less what the thread waited for a core \[s\].
    seconds: f64,
    before_ns: u64,
    after_ns: u64,
}

impl Run {
    /// A run of `share` times as much of the same.
    pub(crate) fn times(self, share: f64) -> Run {
        Run { seconds: self.seconds * share, ..self }
    }

    fn is_quiet(&self) -> bool {
        let most = SLACK * LEAST_NS.load(Ordering::Relaxed) as f64;
        self.before_ns.max(self.after_ns) as f64 <= most
    }
}

/// Finds how long the loop takes in a quiet core: the least of a second or so. Call it before anything is timed.
pub(crate) fn calibrate() {
    for _ in 0..30_000 {
        additions_ns();
    }
}

/// The least that the loop has ever taken.
static LEAST_NS: AtomicU64 = AtomicU64::new(u64::MAX);

/// Times a piece of work.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> Run {
    let before_ns = additions_ns();
    let (waited, begin) = (waited_seconds(), Instant::now());
    black_box(work());
    let wall = begin.elapsed().as_secs_f64();
    let seconds = (wall - (waited_seconds() - waited)).max(0.0);
    Run { seconds, before_ns, after_ns: additions_ns() }
}

/// How many of the runs were quiet.
pub(crate) fn n_quiet(runs: &[Run]) -> usize {
    runs.iter().filter(|run| run.is_quiet()).count()
}

/// Whether so many runs were quiet that they are a figure.
pub(crate) fn is_enough(runs: &[Run]) -> bool {
    n_quiet(runs) >= ENOUGH
}

/// The median of the quiet runs, or of all if few are quiet \[s\].
pub(crate) fn median(runs: &[Run]) -> f64 {
    let only_quiet = is_enough(runs);
    median_of(runs.iter().filter(|run| !only_quiet || run.is_quiet()))
}

/// The median of all runs \[s\].
pub(crate) fn median_of_all(runs: &[Run]) -> f64 {
    median_of(runs.iter())
}

fn median_of<'a>(runs: impl Iterator<Item = &'a Run>) -> f64 {
    let mut seconds: Vec<f64> = runs.map(|run| run.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// How long the loop takes now: 0.03 ms.
fn additions_ns() -> u64 {
    let begin = Instant::now();
    // Enough numbers that each addition can begin before the one before it on the same number has ended.
    let mut sums = black_box([0_u32; 64]);
    for i in 0..black_box(8000_u32) {
        for sum in &mut sums {
            *sum = (*sum ^ i).wrapping_add(i);
        }
    }
    black_box(sums);
    let ns = u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX);
    LEAST_NS.fetch_min(ns, Ordering::Relaxed);
    ns
}

/// How long this thread has been ready to run without a core to run on \[s\]; 0 where the kernel does not say.
fn waited_seconds() -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    told.split_whitespace().nth(1).and_then(|ns| ns.parse::<f64>().ok()).map_or(0.0, |ns| ns / 1e9)
}
