//! Memory limit of a run: the typed limit, or the available memory. Work above the limit is refused
//! before it begins where its size is known. Otherwise a watch ends the process, and so does memory
//! that the system refuses. `needs` holds the sizes of questions, as they were measured.

mod needs;

use std::cell::Cell;
use std::fmt;
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Duration;

use crate::error::{Error, ErrorKind, LimitError, Result};
use crate::raster::GeoRef;
pub(crate) use needs::{Needs, picture_bytes_per_cell};

/// Limit of the process \[bytes\]; `u64::MAX` if it is unknown.
static LIMIT: AtomicU64 = AtomicU64::new(u64::MAX);
/// Typed limit \[bytes\]; 0 without one.
static TYPED: AtomicU64 = AtomicU64::new(0);

/// Function that ends the program with an error.
static END: OnceLock<fn(&Error) -> !> = OnceLock::new();

/// Memory that is freed when the system refuses more, for the message of the error.
static RESERVE: Mutex<Vec<u8>> = Mutex::new(Vec::new());
/// `true` while a thread watches.
static IS_WATCHED: AtomicBool = AtomicBool::new(false);
/// `true` once memory was refused.
static IS_REFUSED: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// `true` in the thread that watches.
    static IS_WATCHER: Cell<bool> = const { Cell::new(false) };
    /// `true` in a thread that ends the program for want of memory.
    static IS_ENDING: Cell<bool> = const { Cell::new(false) };
}

/// Memory of a height field and of pictures made of it \[bytes per cell\].
pub(crate) const FIELD_BYTES_PER_CELL: f64 = 8.0;

/// Memory of any work beside its cells, for stacks and file compression \[bytes\].
pub(crate) const ANY_WORK: u64 = 5 << 20;

/// Sets the function that ends the program when memory is short.
pub(crate) fn on_refusal(end: fn(&Error) -> !) {
    /// Memory that the message of an error takes \[bytes\].
    const MESSAGE_BYTES: usize = 16 << 10;
    if END.set(end).is_ok() {
        let kept = Vec::with_capacity(MESSAGE_BYTES);
        *RESERVE.lock().unwrap_or_else(PoisonError::into_inner) = kept;
    }
}

/// Ends the program with E501 because the system refused a block of memory.
///
/// Returns, so that the caller meets the refusal, in two cases: no command line runs, or the block is
/// larger than the whole limit. Only a false length in a file asks for as much, and the reader of the
/// file can say more.
///
/// The watching thread ends the program, because this thread may hold a lock that ending needs. If
/// the watching thread waits for such a lock, this one ends the program after two seconds, without a
/// message.
#[cold]
pub(crate) fn refused(bytes: usize) {
    let Some(end) = END.get().filter(|_| bytes as u64 <= LIMIT.load(Ordering::Acquire)) else { return };
    if let Ok(mut kept) = RESERVE.try_lock() {
        drop(std::mem::take(&mut *kept));
    }
    if IS_ENDING.replace(true) {
        let _ = std::io::stderr().write_all(b"error[E501]: cannot go on: there is no more memory\n");
    } else if IS_WATCHED.load(Ordering::Acquire) && !IS_WATCHER.get() {
        IS_REFUSED.store(true, Ordering::Release);
        std::thread::sleep(Duration::from_secs(2));
    } else {
        end(&LimitError::Exceeded(limit_words()).into());
    }
    std::process::exit(i32::from(ErrorKind::Limit.exit_code()));
}

/// Sets the limit of this process, and watches it from now on.
///
/// # Errors
/// E501 if the program alone exceeds the limit.
pub(crate) fn limit(typed: Option<u64>) -> Result<()> {
    let Some(resident) = resident() else {
        LIMIT.store(typed.unwrap_or(u64::MAX), Ordering::Release);
        return Ok(());
    };
    let limit = typed.or_else(|| Some(resident.saturating_add(available()?))).unwrap_or(u64::MAX);
    let is_first = LIMIT.swap(limit, Ordering::AcqRel) == u64::MAX;
    TYPED.store(typed.unwrap_or(0), Ordering::Release);
    if resident > limit {
        return Err(LimitError::Program { resident: memory_words(resident), limit: limit_words() }.into());
    }
    if let (true, Some(end)) = (is_first && limit != u64::MAX, END.get()) {
        // Without a watching thread, work is still refused beforehand, and ended before it writes.
        let _ = std::thread::Builder::new().name("memory".into()).spawn(|| watch(*end));
    }
    Ok(())
}

/// Ends the program if it ever exceeded a typed limit.
///
/// The watch normally ends it earlier, but may wait for a processor on a busy machine. This check
/// runs before files get their names, so that no run above its limit ends in success.
pub(crate) fn end_if_exceeded() {
    let typed = TYPED.load(Ordering::Acquire);
    let (Some(end), true) = (END.get(), typed > 0) else { return };
    if status("VmHWM:").is_some_and(|peak| peak > typed) {
        end(&LimitError::Exceeded(limit_words()).into());
    }
}

/// Sets the limit of this process without a watch.
pub(crate) fn refuse_above(bytes: u64) {
    LIMIT.store(bytes, Ordering::Release);
    TYPED.store(bytes, Ordering::Release);
}

/// Ends the program when it exceeds the limit.
fn watch(end: fn(&Error) -> !) {
    /// Upper bound on the rate at which a program fills memory \[bytes/s\].
    const FASTEST: u64 = 20_000_000_000;
    IS_WATCHER.set(true);
    IS_WATCHED.store(true, Ordering::Release);
    while let Some(resident) = resident() {
        let limit = LIMIT.load(Ordering::Acquire);
        if resident > limit || IS_REFUSED.load(Ordering::Acquire) {
            end(&LimitError::Exceeded(limit_words()).into());
        }
        let nanoseconds = (limit - resident).saturating_mul(1_000_000_000) / FASTEST;
        std::thread::sleep(Duration::from_nanos(nanoseconds.clamp(300_000, 50_000_000)));
    }
    IS_WATCHED.store(false, Ordering::Release);
}

/// Returns the limit in words that follow "more than".
fn limit_words() -> String {
    match TYPED.load(Ordering::Acquire) {
        0 => "there is".into(),
        typed => format!("the {} that `--max-memory` allows", memory_words(typed)),
    }
}

/// Returns `None` if the process may take `more` bytes. Otherwise returns the bytes that it would
/// hold, and the limit in words.
pub(crate) fn lacking(more: u64) -> Option<(u64, String)> {
    let needed = resident().unwrap_or(0).saturating_add(more);
    if needed > LIMIT.load(Ordering::Acquire) {
        return Some((needed, limit_words()));
    }
    // Stacks and heaps of threads take address space that is never resident.
    (address_space()? < more).then(|| (more, "there is".into()))
}

/// Refuses work on a grid that does not fit in memory, before it allocates anything of that size.
///
/// # Errors
/// E501 if `more` bytes per cell are too much.
pub(crate) fn check_memory(name: &impl fmt::Display, grid: &GeoRef, more: f64) -> Result<()> {
    check_bytes(name, &cells_of(grid), bytes_of_cells(grid, more))
}

/// Returns the bytes of all cells of a grid.
pub(crate) fn bytes_of_cells(grid: &GeoRef, per_cell: f64) -> u64 {
    #[expect(clippy::cast_precision_loss, reason = "an estimate")]
    let n_cells = grid.n_cells() as f64;
    whole_bytes(n_cells * per_cell)
}

/// Returns an estimate in whole bytes.
pub(crate) fn whole_bytes(bytes: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an estimate above 0")]
    let bytes = bytes as u64;
    bytes
}

/// Returns the cells of a grid in words, for [`check_bytes`].
pub(crate) fn cells_of(grid: &GeoRef) -> String {
    format!("{}×{} cells", grid.n_cols(), grid.n_rows())
}

/// Refuses work above the limit: `what` of `name` would need `more` bytes beside the present ones.
///
/// # Errors
/// E501 if that is too much.
pub(crate) fn check_bytes(name: &impl fmt::Display, what: &str, more: u64) -> Result<()> {
    let Some((needed, limit)) = lacking(more) else { return Ok(()) };
    let (name, what) = (name.to_string(), what.to_string());
    let is_typed = TYPED.load(Ordering::Acquire) > 0;
    Err(LimitError::Memory { name, what, needed: memory_words(needed), limit, is_typed }.into())
}

/// Returns a number of bytes in words.
pub(crate) fn memory_words(bytes: u64) -> String {
    #[expect(clippy::cast_precision_loss, reason = "told to one decimal")]
    let mebibytes = bytes as f64 / f64::powi(2.0, 20);
    match mebibytes {
        ..1.0 => format!("{:.0} KiB", mebibytes * 1024.0),
        1000.0.. => format!("{:.1} GiB", mebibytes / 1024.0),
        _ => format!("{mebibytes:.0} MiB"),
    }
}

/// Returns the memory that the process takes \[bytes\], where the system reports it.
fn resident() -> Option<u64> {
    status("VmRSS:")
}

/// Returns a line of the system's status of this process \[bytes\]. Allocates nothing, because the
/// watch calls it often.
fn status(name: &str) -> Option<u64> {
    let mut text = [0; 8192];
    let length = File::open("/proc/self/status").ok()?.read(&mut text).ok()?;
    let mut lines = text[..length].split(|&byte| byte == b'\n');
    lines.find_map(|line| kibibytes_of(std::str::from_utf8(line).ok()?, name))
}

/// Returns a line of `/proc/self/status` or `/proc/meminfo` \[bytes\].
fn kibibytes_of(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Returns the memory that the process can still take \[bytes\], where the system reports it.
///
/// This is the least of three amounts: the free memory of the machine, of its control groups
/// (containers, `systemd-run`), and of its address space limit.
fn available() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let groups = read("/proc/self/cgroup");
    let limits = [
        // An allocator may promise more memory than exists.
        kibibytes_of(&read("/proc/meminfo"), "MemAvailable:"),
        of_groups(&groups, Path::new("/sys/fs/cgroup")),
        address_space(),
    ];
    limits.into_iter().flatten().min()
}

/// Returns the free memory of the groups in `/proc/self/cgroup` and of those around them, of
/// version 2 or 1. In a container their names may be those outside of it, where only the outermost
/// folder is known.
fn of_groups(groups: &str, root: &Path) -> Option<u64> {
    let left = |line: &str| {
        let mut parts = line.splitn(3, ':');
        let (_, controllers, group) = (parts.next()?, parts.next()?, parts.next()?.trim_start_matches('/'));
        let (root, names, files) = match controllers {
            "" => (root.to_path_buf(), ["memory.max", "memory.current"], ["inactive_file", "active_file"]),
            _ if controllers.split(',').any(|name| name == "memory") => (
                root.join("memory"),
                ["memory.limit_in_bytes", "memory.usage_in_bytes"],
                ["total_inactive_file", "total_active_file"],
            ),
            _ => return None,
        };
        let text = |folder: &Path, name: &str| std::fs::read_to_string(folder.join(name)).unwrap_or_default();
        let of_folder = |folder: &Path| {
            let [limit, used] = names.map(|name| text(folder, name).trim().parse::<u64>().ok());
            // Files that the system caches count as used, but make room when needed.
            let of_files = |line: &str| {
                let (name, bytes) = line.split_once(' ')?;
                files.contains(&name).then(|| bytes.trim().parse::<u64>().ok())?
            };
            let kept: u64 = text(folder, "memory.stat").lines().filter_map(of_files).sum();
            Some(limit?.saturating_sub(used.unwrap_or(0).saturating_sub(kept)))
        };
        let folder = root.join(group);
        folder.ancestors().take_while(|folder| folder.starts_with(&root)).filter_map(of_folder).min()
    };
    groups.lines().filter_map(left).min()
}

/// Returns the address space that the process can still take \[bytes\], where it is limited.
pub(crate) fn address_space() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    of_address_space(&read("/proc/self/limits"), &read("/proc/self/status"))
}

/// Returns the free address space by `/proc/self/limits` and `/proc/self/status` (`ulimit -v`).
fn of_address_space(limits: &str, status: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(kibibytes_of(status, "VmSize:")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_the_least_of_all_limits() {
        let available = |text: &str| kibibytes_of(text, "MemAvailable:");
        assert_eq!(available("MemTotal: 9 kB\nMemAvailable:    2048 kB\n"), Some(2 << 20));
        assert_eq!(available(""), None);
        let limits = "Limit  Soft Limit  Hard Limit  Units\nMax address space     1048576   unlimited   bytes\n";
        assert_eq!(of_address_space(limits, "VmSize:\t      64 kB\n"), Some((1 << 20) - 64 * 1024));
        assert_eq!(of_address_space(&limits.replace("1048576", "unlimited"), "VmSize: 64 kB"), None);
    }

    #[test]
    fn groups_around_a_group_limit_it_too() {
        let root = tempfile::tempdir().expect("a folder");
        let write = |path: &str, text: &str| {
            let path = root.path().join(path);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, text).expect("a file");
        };
        write("a/b/memory.max", "max\n");
        write("a/b/memory.current", "70\n");
        write("a/memory.max", "1000\n");
        write("a/memory.current", "300\n");
        assert_eq!(of_groups("0::/a/b\n", root.path()), Some(700));
        // Two cached files of 250 bytes together, which any process may have.
        write("a/memory.stat", "anon 50\nfile 270\ninactive_file 200\nactive_file 50\ninactive_anon 9\n");
        assert_eq!(of_groups("0::/a/b\n", root.path()), Some(950));
        // In a container the group has its name outside.
        write("memory.max", "500\n");
        write("memory.current", "100\n");
        assert_eq!(of_groups("0::/elsewhere/c\n", root.path()), Some(400));
        // Version 1, beside an empty group of version 2.
        write("memory/d/memory.limit_in_bytes", "900\n");
        write("memory/d/memory.usage_in_bytes", "11\n");
        write("memory/d/memory.stat", "inactive_file 1\ntotal_inactive_file 6\ntotal_active_file 4\n");
        assert_eq!(of_groups("12:cpu,cpuacct:/d\n5:memory:/d\n", root.path()), Some(899));
        assert_eq!(of_groups("", root.path()), None);
    }
}
