//! How much memory there is, and the refusal of what does not fit in it.

use std::fmt;
use std::path::Path;

use crate::error::{Error, Result};
use crate::raster::GeoRef;

/// Refuses work that does not fit in memory, before anything of its size is made: `more` bytes per cell beside the `held`
/// ones, all together within `most`.
pub(super) fn check_memory(
    name: &impl fmt::Display,
    grid: &GeoRef,
    (held, more): (usize, usize),
    most: Option<u64>,
) -> Result<()> {
    let mut probe: Vec<u8> = Vec::new();
    let more = grid.n_cells().saturating_mul(more);
    let bytes = grid.n_cells().saturating_mul(held).saturating_add(more);
    let refuse = |limit: String| {
        let text = format!(
            "cannot map {name}: {}×{} cells need at least {} of memory, {limit}",
            grid.n_cols(),
            grid.n_rows(),
            memory_words(bytes as u64)
        );
        Err(Error::limit(501, text).with_hint("choose larger cells, a smaller extent, or fewer sites and layers"))
    };
    match most {
        Some(most) if bytes as u64 > most => {
            return refuse(format!("more than the {} that `--max-memory` allows", memory_words(most)));
        }
        _ => {}
    }
    let too_much = available_memory().is_some_and(|available| more as u64 > available);
    if too_much || probe.try_reserve_exact(more).is_err() {
        return refuse("more than there is".into());
    }
    // What is looked at cannot be optimized away.
    std::hint::black_box(&mut probe);
    Ok(())
}

/// A number of bytes for reading.
pub(super) fn memory_words(bytes: u64) -> String {
    #[expect(clippy::cast_precision_loss, reason = "told to one decimal")]
    let mebibytes = bytes as f64 / f64::powi(2.0, 20);
    if mebibytes < 1000.0 { format!("{mebibytes:.0} MiB") } else { format!("{:.1} GiB", mebibytes / 1024.0) }
}

/// Memory that the process can still take \[bytes\], where the system says so: the least of what the machine has left, what the
/// control groups that it is in leave it (containers, `systemd-run`), and what its limit of address space does.
pub(super) fn available_memory() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let groups = read("/proc/self/cgroup");
    let limits = [
        of_machine(&read("/proc/meminfo")),
        of_groups(&groups, Path::new("/sys/fs/cgroup")),
        of_address_space(&read("/proc/self/limits"), &read("/proc/self/statm")),
    ];
    limits.into_iter().flatten().min()
}

/// From `/proc/meminfo`: an allocator may promise more than there is.
fn of_machine(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// From the groups in `/proc/self/cgroup` and those around them, of version 2 or 1. In a container the names may be those
/// outside of it, where only the outermost folder is known.
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
            // Files that the system keeps in memory count as used, but make room for who needs it.
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

/// From `/proc/self/limits` and `/proc/self/statm` (`ulimit -v`).
fn of_address_space(limits: &str, statm: &str) -> Option<u64> {
    const PAGE: u64 = 4096;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    let pages: u64 = statm.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(pages * PAGE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_the_least_of_all_limits() {
        assert_eq!(of_machine("MemTotal: 9 kB\nMemAvailable:    2048 kB\n"), Some(2 << 20));
        assert_eq!(of_machine(""), None);
        let limits = "Limit  Soft Limit  Hard Limit  Units\nMax address space     1048576   unlimited   bytes\n";
        assert_eq!(of_address_space(limits, "16 3 2 1 0 4 0"), Some((1 << 20) - 16 * 4096));
        assert_eq!(of_address_space(&limits.replace("1048576", "unlimited"), "16 3"), None);
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
        // Two files that were read, which is 250 bytes that anyone may have.
        write("a/memory.stat", "anon 50\nfile 270\ninactive_file 200\nactive_file 50\ninactive_anon 9\n");
        assert_eq!(of_groups("0::/a/b\n", root.path()), Some(950));
        // In a container the group has the name that it has outside.
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
