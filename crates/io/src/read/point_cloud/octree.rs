//! Octree of COPC: the chunks of points that meet a box.
//!
//! # References
//! COPC specification 1.0, the hierarchy: entries of 32 bytes (level, x, y, z, offset, length,
//! number of points, or −1 for a page of further entries).

use std::collections::HashSet;
use std::io::{Read, Seek, SeekFrom};

use super::file::{CloudFile, OctreeInfo, cut_short};
use super::points::{Chunk, CloudReader};
use crate::error::{Cause, Error, Result};

/// Length of an entry \[bytes\].
const ENTRY: usize = 32;
/// Deepest level of nodes.
const DEEPEST: i32 = 30;

/// Returns the chunks of all nodes that meet a box, in the order of the file: west, south, east,
/// north \[CRS units\].
///
/// # Errors
/// E302 for a hierarchy that is damaged; E303 for one that is cut off.
pub(super) fn chunks_within(
    file: &CloudFile<'_>,
    reader: &mut CloudReader,
    info: OctreeInfo,
    within: [f64; 4],
) -> Result<Vec<Chunk>> {
    let (input, length) = (file.input, file.length);
    let bad = |what: String| Error::malformed(input, what).because(Cause::CutShort);
    let mut pages = vec![info.root_page];
    // Pages that name one another are read once, and all together are no longer than the file.
    let (mut seen, mut n_read) = (HashSet::new(), 0_u64);
    let (mut chunks, mut n_points) = (Vec::new(), 0_u64);
    while let Some((at, n_bytes)) = pages.pop() {
        if !seen.insert(at) {
            continue;
        }
        n_read = n_read.saturating_add(n_bytes);
        if at.checked_add(n_bytes).is_none_or(|end| end > length) || n_read > length {
            return Err(bad(format!("a page of its octree has {n_bytes} bytes at byte {at} of {length}")));
        }
        let mut page = Vec::new();
        reader.seek(SeekFrom::Start(at)).map_err(|e| cut_short(input, &e))?;
        reader.take(n_bytes).read_to_end(&mut page).map_err(|e| cut_short(input, &e))?;
        for entry in page.chunks_exact(ENTRY).map(Entry::of) {
            if !(0..=DEEPEST).contains(&entry.level) || !entry.meets(info, within) {
                continue;
            }
            match (entry.n_points, u64::try_from(entry.n_bytes)) {
                (-1, Ok(n_bytes)) => pages.push((entry.at, n_bytes)),
                (1.., Ok(_)) => {
                    n_points += u64::from(entry.n_points.unsigned_abs());
                    chunks.push(Chunk { at: entry.at, n_points: u64::from(entry.n_points.unsigned_abs()) });
                }
                (0, _) => {}
                _ => return Err(bad(format!("a node of its octree has {} points", entry.n_points))),
            }
        }
    }
    if n_points > file.n_points {
        return Err(bad(format!("its octree has {n_points} points, its header {}", file.n_points)));
    }
    if let Some(chunk) = chunks.iter().find(|chunk| chunk.at >= length) {
        return Err(bad(format!("a node of its octree begins at byte {} of {length}", chunk.at)));
    }
    chunks.sort_unstable_by_key(|chunk| chunk.at);
    Ok(chunks)
}

/// Entry of a page: a node, or a further page.
struct Entry {
    level: i32,
    column: i32,
    row: i32,
    at: u64,
    n_bytes: i32,
    n_points: i32,
}

impl Entry {
    fn of(bytes: &[u8]) -> Entry {
        let word = |at: usize| i32::from_le_bytes(std::array::from_fn(|k| bytes[at + k]));
        Entry {
            level: word(0),
            column: word(4),
            row: word(8),
            at: u64::from_le_bytes(std::array::from_fn(|k| bytes[16 + k])),
            n_bytes: word(24),
            n_points: word(28),
        }
    }

    /// Returns `true` if the square of the node meets a box, or all but touches it.
    fn meets(&self, info: OctreeInfo, [west, south, east, north]: [f64; 4]) -> bool {
        let edge = 2.0 * info.half / f64::from(1_u32 << self.level);
        let slack = edge * 1e-3;
        let span = |center: f64, index: i32| {
            let low = center - info.half + edge * f64::from(index);
            (low - slack, low + edge + slack)
        };
        let (x, y) = (span(info.center[0], self.column), span(info.center[1], self.row));
        x.0 <= east && x.1 >= west && y.0 <= north && y.1 >= south
    }
}
