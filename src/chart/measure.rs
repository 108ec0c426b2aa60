//! Cost of a piece of work on this machine: CPU time, wall time, memory.
//!
//! CPU time is user time of the whole process, over all threads. A warm-up run comes first, whose
//! answer is kept. Peak memory is the largest resident set of the process during the first run, as
//! the kernel counts it. It includes the scene, the program, and memory that the allocator kept
//! from an earlier contestant. Only Linux lets a process reset that count.

use std::hint::black_box;
use std::time::{Duration, Instant};

use super::report::Cost;
use crate::progress::Progress;

/// Work above this is timed in one group of runs \[s\].
const ONE_RUN_S: f64 = 0.5;
/// Work above this is not repeated: the first run is timed \[s\].
const FIRST_RUN_S: f64 = 2.0;
/// Shortest group of runs \[s\]: clocks of CPU time count microseconds.
const SHORTEST_GROUP_S: f64 = 2e-3;
/// Shortest group whose user time of 0 is accepted \[s\].
const LONGEST_GROUP_S: f64 = 0.1;
/// Groups of runs, whose median is taken.
const GROUPS: usize = 3;
/// Most runs of one group.
const MOST_RUNS: f64 = 1e6;

/// Runs `work` once for its answer, and then often enough to time it, for at least `least_s` in
/// all.
///
/// An interrupt ends the timing. The runs that are done count.
pub(super) fn measured<T>(least_s: f64, progress: &Progress, mut work: impl FnMut() -> T) -> (T, Cost) {
    let counts_memory = reset_peak();
    let (answer, first) = timed(1, progress, &mut work);
    let peak_mb = peak_mb().filter(|_| counts_memory);
    let cost = |cpu_s, wall_s, runs| Cost { cpu_s, wall_s, peak_mb, runs };
    if first.wall > FIRST_RUN_S {
        return (answer, cost(first.cpu, first.wall, 1));
    }
    let group_s = (least_s / GROUPS as f64).max(SHORTEST_GROUP_S);
    let per_group = (group_s / first.wall.max(1e-9)).ceil().clamp(1.0, MOST_RUNS);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 1 to 10^6")]
    let mut per_group = per_group as u32;
    let n_groups = if first.wall > ONE_RUN_S { 1 } else { GROUPS };
    let mut groups: Vec<Spent> = Vec::new();
    while groups.len() < n_groups && !progress.is_stopped() {
        let spent = timed(per_group, progress, &mut work).1;
        // Some kernels split a process's time between user and system by samples. A short group may
        // fall between the samples.
        if spent.cpu == Some(0.0) && spent.wall * f64::from(spent.runs) < LONGEST_GROUP_S {
            per_group = per_group.saturating_mul(4);
            groups.clear();
            continue;
        }
        groups.push(spent);
    }
    if groups.is_empty() {
        return (answer, cost(first.cpu, first.wall, 1));
    }
    let runs = groups.iter().map(|group| group.runs).sum();
    let cpu = groups.iter().map(|group| group.cpu).collect::<Option<Vec<f64>>>().map(median);
    let wall = median(groups.iter().map(|group| group.wall).collect());
    (answer, cost(cpu, wall, runs))
}

/// Longest requested timing of the memory floor \[s\].
const FLOOR_S: f64 = 0.2;

/// Measures the cost of the memory accesses that any map needs: every height is read once as f32,
/// and every cell of a mask is written once.
pub(super) fn memory_floor(n_cells: usize, least_s: f64, progress: &Progress) -> Cost {
    let heights = vec![1.0_f32; n_cells];
    let mut mask = vec![0_u8; n_cells];
    measured(least_s.min(FLOOR_S), progress, || {
        let heights = black_box(heights.as_slice());
        mask.iter_mut().zip(heights).for_each(|(class, height)| *class = u8::from(*height > 0.5));
        black_box(mask.as_slice());
    })
    .1
}

/// Mean times of one run in a group \[s\].
#[derive(Debug, Clone, Copy)]
struct Spent {
    cpu: Option<f64>,
    wall: f64,
    runs: u32,
}

/// Runs `work` `most` times, or fewer after an interrupt. Returns the last answer and the mean
/// times of a run.
fn timed<T>(most: u32, progress: &Progress, work: &mut impl FnMut() -> T) -> (T, Spent) {
    let (before, start) = (user_time(), Instant::now());
    let mut runs = 1;
    while runs < most && !progress.is_stopped() {
        black_box(work());
        runs += 1;
    }
    let answer = work();
    let wall = start.elapsed().as_secs_f64() / f64::from(runs);
    let cpu = before.zip(user_time()).map(|(before, after)| (after - before).as_secs_f64() / f64::from(runs));
    (answer, Spent { cpu, wall, runs })
}

/// Returns the middle one of some numbers, at least one.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Returns the user CPU time of this process; `None` where the system does not report it.
fn user_time() -> Option<Duration> {
    usage(false)
}

/// Returns the user CPU time of all child processes that have ended.
pub(super) fn user_time_of_children() -> Option<Duration> {
    usage(true)
}

#[cfg(unix)]
fn usage(of_children: bool) -> Option<Duration> {
    use nix::sys::resource::{UsageWho, getrusage};
    let who = if of_children { UsageWho::RUSAGE_CHILDREN } else { UsageWho::RUSAGE_SELF };
    let time = getrusage(who).ok()?.user_time();
    let micros = u64::try_from(time.tv_sec()).ok()? * 1_000_000 + u64::try_from(time.tv_usec()).ok()?;
    Some(Duration::from_micros(micros))
}

#[cfg(not(unix))]
fn usage(_: bool) -> Option<Duration> {
    None
}

/// Resets the kernel's peak of resident memory. Returns `true` on success.
fn reset_peak() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}

fn peak_mb() -> Option<f64> {
    peak_mb_of("self")
}

/// Returns the peak of resident memory of a process by its number, or of `self` \[MB\]. `None`
/// where the system does not report it.
pub(super) fn peak_mb_of(process: &str) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024.0 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_work_is_done_at_least_three_times_and_slow_work_once_more() {
        let mut n = 0_u32;
        let (answer, cost) = measured(0.0, &Progress::default(), || {
            n += 1;
            n
        });
        // Three groups follow the first run. A group that the clock missed is repeated with more
        // runs.
        assert_eq!((answer, cost.runs % 3), (1, 0));
        assert!(cost.runs > 3 && n > cost.runs);
        let mut n = 0_u32;
        let (_, cost) = measured(0.0, &Progress::default(), || {
            n += 1;
            std::thread::sleep(Duration::from_millis(520));
        });
        assert_eq!((cost.runs, n), (1, 2));
        assert!(cost.wall_s >= 0.52);
        if cfg!(target_os = "linux") {
            // Other tests spend time in the same process, so the test only checks that values
            // exist.
            assert!(cost.cpu_s.is_some_and(|cpu| cpu >= 0.0) && cost.peak_mb.is_some_and(|mb| mb > 0.5));
        }
    }

    #[test]
    fn the_median_is_the_middle() {
        let medians = [median(vec![3.0, 1.0, 2.0]), median(vec![7.0])];
        assert_eq!(medians.map(f64::to_bits), [2.0_f64, 7.0].map(f64::to_bits));
    }
}
