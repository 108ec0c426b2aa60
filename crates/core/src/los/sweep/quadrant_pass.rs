//! One quadrant of a streamed sweep: its strips outward, and then inward for the receivers that wait.

use std::ops::Range;
use std::sync::atomic::Ordering;

use crate::dispatch;
use rayon::prelude::*;

use super::columns_reader::{StreamedHeights, StreamedScene};
use super::line_order::turn;
use super::line_walk::{LineCells, LinkLength, LinkOverLines};
use super::quadrants::{CELL, Quadrant, as_i64, parts};
use super::receivers::{Decided, LineReceivers};
use super::shared_bits::{SharedBits, transpose};
use super::suspects::Suspects;
use super::wedge::{Ahead, Line, Verdicts, Wedge, WedgeFrame};
use crate::error::Result;
use crate::height_field::TILE;
use crate::raster::{BitGrid, CellWindow, set_bits};

/// Receivers of a queue that are walked together.
const WALKED_AT_ONCE: usize = 1 << 20;

/// A quadrant with its lines numbered outward from the UAV.
pub(super) struct QuadrantPass<'a> {
    scene: &'a StreamedScene<'a>,
    quadrant: Quadrant,
    /// Rows or columns of the window that are passed, in the order of the raster.
    lines: Range<usize>,
    /// Lateral position of the UAV \[lattice steps\].
    uav_lateral: i64,
    n_lateral: usize,
    frame: WedgeFrame,
    /// Distance of the farther edge of line 0 \[lattice steps\].
    far_of_line_0: i64,
}

/// The lines of one strip in memory, each a row of `width` cells.
struct StripLines {
    /// Numbers of the lines, counted outward.
    numbers: Range<usize>,
    /// Lateral index of the first cell of each.
    first: usize,
    width: usize,
    tops: Vec<i32>,
    /// What receivers stand on, where that is not the top.
    bases: Option<Vec<i32>>,
    /// Whether the first line in memory is the outermost.
    is_inward: bool,
}

impl StripLines {
    /// Where a line begins in memory, wrapped around for lines of other strips.
    fn start(&self, number: usize) -> usize {
        let offset = as_i64(number) - as_i64(self.numbers.start);
        let index = if self.is_inward { as_i64(self.numbers.len()) - 1 - offset } else { offset };
        usize::try_from(index).map_or_else(
            |_| (self.width * usize::try_from(-index).unwrap_or(0)).wrapping_neg(),
            |index| index * self.width,
        )
    }
}

/// A receiver that waits for the lines that may hide it, numbered outward from the UAV.
#[derive(Debug, Clone, Copy)]
struct Waiting {
    line: u16,
    /// Its lateral cell, counted from the first of the window: a raster may be far wider than any range.
    lateral: u16,
    /// The lines from `first` to `last` may hide it.
    first: u16,
    last: u16,
    /// Its height \[1/1024 m\].
    z: i32,
}

/// What one wedge leaves behind of a strip.
#[derive(Default)]
struct Left {
    waiting: Vec<Waiting>,
    undecided: u64,
}

impl<'a> QuadrantPass<'a> {
    /// The pass over a quadrant; `None` if no line of the window lies in it.
    pub(super) fn new(scene: &'a StreamedScene<'a>, quadrant: Quadrant) -> Option<Self> {
        let (n_rows, n_cols) = scene.columns.shape();
        let (window, uav) = (scene.window, scene.uav);
        let (rows, cols) = (window.row..window.row + window.n_rows, window.col..window.col + window.n_cols);
        let is_rows = matches!(quadrant, Quadrant::North | Quadrant::South);
        let (across, along, n_lateral) = if is_rows { (rows, cols, n_cols) } else { (cols, rows, n_rows) };
        // Lateral positions run east, or south as rows do.
        let uav_lateral = if is_rows { uav.x } else { as_i64(n_rows) * CELL - uav.y };
        let mut pass = QuadrantPass {
            scene,
            quadrant,
            lines: across,
            uav_lateral,
            n_lateral,
            frame: WedgeFrame {
                uav_z: i32::try_from(uav.z).unwrap_or(i32::MAX),
                is_below_uav: i64::from(scene.max_top) <= uav.z,
                uav_lateral,
                window: (as_i64(along.start), as_i64(along.end)),
                n_lateral: as_i64(n_lateral),
                lowest_receiver: scene.receivers.range().0 - uav.z,
                highest_receiver: scene.receivers.range().1 - uav.z,
                last_center: 0,
            },
            far_of_line_0: 0,
        };
        // Lines behind the UAV are another quadrant's.
        let is_ahead = |line: usize| pass.far(line) > 0;
        let lines = pass.lines.clone();
        pass.lines = if pass.counts_up() {
            lines.clone().find(|line| is_ahead(*line))?..lines.end
        } else {
            lines.start..lines.clone().rev().find(|line| is_ahead(*line))? + 1
        };
        pass.far_of_line_0 = pass.far(pass.raster_line(0));
        pass.frame.last_center = pass.far(pass.raster_line(pass.lines.len() - 1)) - CELL / 2;
        Some(pass)
    }

    /// Whether rows or columns have rising indices on the way out.
    fn counts_up(&self) -> bool {
        matches!(self.quadrant, Quadrant::South | Quadrant::East)
    }

    fn is_rows(&self) -> bool {
        matches!(self.quadrant, Quadrant::North | Quadrant::South)
    }

    /// Distance of the farther edge of a row or column from the UAV \[lattice steps\].
    fn far(&self, line: usize) -> i64 {
        let uav = self.scene.uav;
        let n_rows = self.scene.columns.shape().0;
        match self.quadrant {
            Quadrant::North => (as_i64(n_rows) - as_i64(line)) * CELL - uav.y,
            Quadrant::South => uav.y - (as_i64(n_rows) - 1 - as_i64(line)) * CELL,
            Quadrant::East => (as_i64(line) + 1) * CELL - uav.x,
            Quadrant::West => uav.x - as_i64(line) * CELL,
        }
    }

    /// The row or column that is line `number` on the way out.
    fn raster_line(&self, number: usize) -> usize {
        if self.counts_up() { self.lines.start + number } else { self.lines.end - 1 - number }
    }

    /// Distance of the farther edge of line `number` \[lattice steps\].
    fn far_of(&self, number: usize) -> i64 {
        self.far_of_line_0 + as_i64(number) * CELL
    }

    /// The numbers of the lines of each strip, outward.
    fn strips(&self) -> Vec<Range<usize>> {
        let thickness = self.scene.limits.lines.max(1);
        let mut strips = Vec::new();
        let mut number = 0;
        while number < self.lines.len() {
            let line = self.raster_line(number);
            let in_strip = if self.counts_up() { thickness - line % thickness } else { line % thickness + 1 };
            let end = (number + in_strip).min(self.lines.len());
            strips.push(number..end);
            number = end;
        }
        strips
    }

    /// Reads the cells of some lines between two lateral indices.
    fn read(&self, numbers: Range<usize>, lateral: Range<usize>) -> Result<StripLines> {
        let ends = (self.raster_line(numbers.start), self.raster_line(numbers.end - 1));
        let lines = ends.0.min(ends.1)..ends.0.max(ends.1) + 1;
        let columns = self.scene.columns;
        let window = match self.is_rows() {
            true => CellWindow { row: lines.start, col: lateral.start, n_rows: lines.len(), n_cols: lateral.len() },
            false => CellWindow { row: lateral.start, col: lines.start, n_rows: lateral.len(), n_cols: lines.len() },
        };
        let as_lines = |cells: Vec<i32>| match self.is_rows() {
            true => cells,
            false => {
                let mut turned = Vec::new();
                let (cols, rows) = (0..window.n_cols, 0..window.n_rows);
                dispatch!(self.scene.level, simd => turn(simd, &cells, window.n_cols, &cols, &rows, &mut turned));
                turned
            }
        };
        let (mut tops, mut bases) = (Vec::new(), Vec::new());
        let is_empty = lateral.is_empty();
        if !is_empty {
            columns.read_tops(window, &mut tops)?;
        }
        let has_bases = matches!(self.scene.receivers, StreamedHeights::Over { is_top: false, .. });
        if has_bases && !is_empty {
            columns.read_bases(window, &mut bases)?;
        }
        Ok(StripLines {
            numbers,
            first: lateral.start,
            width: lateral.len(),
            tops: as_lines(tops),
            bases: has_bases.then(|| as_lines(bases)),
            is_inward: !self.counts_up(),
        })
    }

    /// Passes all strips, and adds what is in line of sight; returns the number of receivers left to walks.
    pub(super) fn run(&self, los: &mut BitGrid, passed: &(dyn Fn(u64) -> bool + Sync)) -> Result<u64> {
        let parts = parts(self.n_lateral.max(self.lines.len()));
        let mut wedges: Vec<Wedge> = (-parts..parts).map(|part| Wedge::new(part, parts)).collect();
        let strips = self.strips();
        let mut queues: Vec<Vec<Waiting>> = vec![Vec::new(); strips.len()];
        let (mut n_waiting, mut undecided) = (0, 0);
        for (k, strip) in strips.iter().enumerate() {
            let (near, far) = (self.far_of(strip.start) - CELL, self.far_of(strip.end - 1));
            if wedges.iter().all(Wedge::is_done) {
                break;
            }
            let reach = wedges
                .iter()
                .map(|wedge| wedge.reach(&self.frame, near.max(0), far))
                .filter(|(low, high)| low < high)
                .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
            // Nothing where the bins pass beside the raster. A walk looks at the cell beside the one that it is in.
            let lateral = reach.map_or(0..0, |(low, high)| {
                let low = usize::try_from(low).unwrap_or(0);
                low.saturating_sub(1)..(usize::try_from(high).unwrap_or(0) + 1).min(self.n_lateral)
            });
            let lines = self.read(strip.clone(), lateral.clone())?;
            let seen = SharedBits::new(strip.len(), self.n_lateral);
            let left: Vec<Left> = wedges
                .par_iter_mut()
                .map(|wedge| {
                    let mut left = Left::default();
                    dispatch!(self.scene.level, simd => self.pass(simd, wedge, &lines, &seen, &mut left));
                    left
                })
                .collect();
            for wedge in left {
                undecided += wedge.undecided;
                n_waiting += wedge.waiting.len();
                for waiting in wedge.waiting {
                    queues[strip_of(&strips, usize::from(waiting.last))].push(waiting);
                }
            }
            self.add(&seen, strip, los);
            if n_waiting > self.scene.limits.waiting {
                self.resolve(&strips[..=k], &mut queues, los)?;
                n_waiting = 0;
            }
            if !passed((strip.len() * lateral.len()) as u64) {
                return Ok(undecided);
            }
        }
        self.resolve(&strips, &mut queues, los).map(|()| undecided)
    }

    /// Passes the lines of a strip with one wedge.
    fn pass<S: fearless_simd::Simd>(
        &self,
        simd: S,
        wedge: &mut Wedge,
        lines: &StripLines,
        seen: &SharedBits,
        left: &mut Left,
    ) {
        for number in lines.numbers.clone() {
            if wedge.is_done() {
                return;
            }
            let far = self.far_of(number);
            if number % TILE == 0 {
                let last = self.far_of(number + TILE - 1);
                let ahead = Ahead { near: (far - CELL).max(0), center: far - CELL / 2, far: last, tiles: None };
                wedge.look_ahead(simd, &self.frame, &ahead);
            }
            let cells = lines.start(number)..lines.start(number) + lines.width;
            let first = as_i64(lines.first);
            let line = Line {
                tops: &lines.tops[cells.clone()],
                first,
                near: (far - CELL).max(0),
                center: far - CELL / 2,
                far,
                next: [&[]; 2],
            };
            let receivers = match self.scene.receivers {
                StreamedHeights::Flat(z) => LineReceivers::Flat(z.wrapping_sub(self.frame.uav_z)),
                StreamedHeights::Over { above, .. } => {
                    let base = &lines.bases.as_ref().unwrap_or(&lines.tops)[cells.clone()];
                    LineReceivers::Over { base, first, above: above.wrapping_sub(self.frame.uav_z) }
                }
            };
            let mut verdicts = StripVerdicts { pass: self, lines, number, receivers: &receivers, seen, left };
            wedge.pass(simd, &self.frame, &line, &receivers, &mut verdicts);
        }
    }

    /// Walks a receiver over those of its suspected lines that are in memory.
    fn walk(&self, lines: &StripLines, ((line, lateral), z): ((usize, usize), i32), suspected: Range<usize>) -> Walked {
        let here = suspected.start.max(lines.numbers.start)..suspected.end.min(lines.numbers.end);
        if !here.is_empty() {
            let link = LinkOverLines::new(
                LinkLength::new(self.far_of(line) - CELL / 2),
                (as_i64(lateral), as_i64(self.n_lateral)),
                self.uav_lateral,
                (i64::from(z), self.scene.uav.z - i64::from(z)),
            );
            let width = as_i64(lines.width);
            let cells = LineCells {
                tops: &lines.tops,
                own: lines.start(line).wrapping_add(lateral).wrapping_sub(lines.first),
                strides: (if lines.is_inward { width } else { -width }, 1),
                tiles: None,
            };
            let near = (self.far_of(here.start) - CELL).max(0);
            if !link.is_clear(&cells, (near, self.far_of(here.end - 1))) {
                return Walked::Hidden;
            }
        }
        if suspected.start >= suspected.end.min(lines.numbers.start) {
            return Walked::Seen;
        }
        // EXACT: a UAV and the cells in its range span at most 2^16 lines.
        let number = |n: usize| u16::try_from(n).unwrap_or(u16::MAX);
        Walked::Waits(Waiting {
            line: number(line),
            lateral: number(lateral - self.first_lateral()),
            first: number(suspected.start),
            last: number(suspected.end.min(lines.numbers.start) - 1),
            z,
        })
    }

    /// Decides all that wait for some strips, from the outermost strip inward.
    fn resolve(&self, strips: &[Range<usize>], queues: &mut [Vec<Waiting>], los: &mut BitGrid) -> Result<()> {
        for (k, strip) in strips.iter().enumerate().rev() {
            let queue = std::mem::take(&mut queues[k]);
            if queue.is_empty() {
                continue;
            }
            let lines = self.read(strip.clone(), self.reach_of(&queue, strip))?;
            for part in queue.chunks(WALKED_AT_ONCE) {
                let walked: Vec<(Waiting, Walked)> = part
                    .par_iter()
                    .map(|waiting| {
                        let receiver = self.place_of(waiting);
                        let suspected = usize::from(waiting.first)..usize::from(waiting.last) + 1;
                        (*waiting, self.walk(&lines, (receiver, waiting.z), suspected))
                    })
                    .filter(|(_, walked)| !matches!(walked, Walked::Hidden))
                    .collect();
                for (receiver, walked) in walked {
                    match walked {
                        Walked::Hidden => {}
                        Walked::Seen => {
                            let (row, col) = self.cell(self.place_of(&receiver));
                            los.insert(row, col);
                        }
                        Walked::Waits(waiting) => queues[strip_of(strips, usize::from(waiting.last))].push(waiting),
                    }
                }
            }
        }
        Ok(())
    }

    /// The lateral cells of a strip that the links of some receivers can touch.
    fn reach_of(&self, queue: &[Waiting], strip: &Range<usize>) -> Range<usize> {
        let (near, far) = ((self.far_of(strip.start) - CELL).max(0), self.far_of(strip.end - 1));
        let mut reach = (i64::MAX, i64::MIN);
        for waiting in queue {
            let (line, lateral) = self.place_of(waiting);
            let length = self.far_of(line) - CELL / 2;
            let side = as_i64(lateral) * CELL + CELL / 2 - self.uav_lateral;
            for distance in [near, far.min(length)] {
                // EXACT: both factors are at most 2^26.
                let cell = (self.uav_lateral + (side * distance).div_euclid(length)).div_euclid(CELL);
                reach = (reach.0.min(cell), reach.1.max(cell));
            }
        }
        let clip = |cell: i64| usize::try_from(cell.max(0)).unwrap_or(0).min(self.n_lateral);
        let low = clip(reach.0 - 1).min(self.n_lateral - 1);
        low..clip(reach.1 + 2).max(low + 1)
    }

    /// The first lateral cell of the window.
    fn first_lateral(&self) -> usize {
        usize::try_from(self.frame.window.0).unwrap_or(0)
    }

    /// The line and the lateral cell of a receiver.
    fn place_of(&self, waiting: &Waiting) -> (usize, usize) {
        (usize::from(waiting.line), self.first_lateral() + usize::from(waiting.lateral))
    }

    /// Row and column of a lateral cell of a line.
    fn cell(&self, (number, lateral): (usize, usize)) -> (usize, usize) {
        let line = self.raster_line(number);
        if self.is_rows() { (line, lateral) } else { (lateral, line) }
    }

    /// Adds what a strip found, cut to what is wanted.
    fn add(&self, seen: &SharedBits, strip: &Range<usize>, los: &mut BitGrid) {
        let per_row = los.words_per_row();
        let wanted = self.scene.wanted;
        if self.is_rows() {
            for number in strip.clone() {
                let row = self.raster_line(number);
                let words = seen.line(number - strip.start);
                let out = &mut los.words_mut()[row * per_row..(row + 1) * per_row];
                for ((out, seen), wanted) in out.iter_mut().zip(words).zip(wanted.row(row)) {
                    *out |= seen.load(Ordering::Relaxed) & wanted;
                }
            }
            return;
        }
        let ends = (self.raster_line(strip.start), self.raster_line(strip.end - 1));
        let cols = ends.0.min(ends.1)..ends.0.max(ends.1) + 1;
        let number_of = |col: usize| if self.counts_up() { col - cols.start } else { cols.end - 1 - col };
        los.words_mut().par_chunks_mut(64 * per_row).enumerate().for_each(|(band, out)| {
            for word in cols.start / 64..cols.end.div_ceil(64) {
                let mut block = [0_u64; 64];
                let mut any = 0;
                for (bit, bits) in block.iter_mut().enumerate() {
                    let col = 64 * word + bit;
                    if cols.contains(&col) {
                        *bits = seen.line(number_of(col))[band].load(Ordering::Relaxed);
                        any |= *bits;
                    }
                }
                if any == 0 {
                    continue;
                }
                transpose(&mut block);
                for (k, row) in out.chunks_mut(per_row).enumerate() {
                    row[word] |= block[k] & wanted.row(64 * band + k)[word];
                }
            }
        });
    }
}

/// The receivers of one line of a strip.
struct StripVerdicts<'a, 'p> {
    pass: &'a QuadrantPass<'p>,
    lines: &'a StripLines,
    number: usize,
    receivers: &'a LineReceivers<'a>,
    seen: &'a SharedBits,
    left: &'a mut Left,
}

impl Verdicts for StripVerdicts<'_, '_> {
    #[inline(always)]
    fn decided(&mut self, word: usize, decided: Decided, is_shared: bool) -> u64 {
        self.seen.add(self.number - self.lines.numbers.start, word, decided.los, is_shared);
        let is_wanted = |bit: &usize| {
            let (row, col) = self.pass.cell((self.number, 64 * word + bit));
            self.pass.scene.wanted.contains(row, col)
        };
        set_bits(&[decided.undecided]).filter(is_wanted).fold(0, |bits, bit| bits | 1 << bit)
    }

    fn ask(&mut self, cells: &mut Vec<u32>, suspects: &Suspects<'_>) {
        self.left.undecided += cells.len() as u64;
        for cell in cells.iter() {
            let (lateral, word) = (*cell as usize, *cell as usize / 64);
            let above_uav = self.receivers.height(lateral);
            let z = i32::try_from(self.pass.scene.uav.z + above_uav).unwrap_or(i32::MAX);
            // All bins passed over every line from number 0 on.
            let number = |back: i64| usize::try_from(as_i64(self.number) - back).unwrap_or(0);
            let range = suspects.of(i64::from(*cell), above_uav).range();
            let suspected = range.map_or(0..0, |(first, last)| number(first)..number(last) + 1);
            match self.pass.walk(self.lines, ((self.number, lateral), z), suspected) {
                Walked::Seen => {
                    let row = self.number - self.lines.numbers.start;
                    self.seen.add(row, word, 1 << (cell % 64), suspects.is_shared(word));
                }
                Walked::Hidden => {}
                Walked::Waits(waiting) => self.left.waiting.push(waiting),
            }
        }
    }
}

/// What a walk over the lines of a strip says of a receiver.
enum Walked {
    Seen,
    Hidden,
    Waits(Waiting),
}

/// The strip that holds a line.
fn strip_of(strips: &[Range<usize>], number: usize) -> usize {
    strips.partition_point(|strip| strip.end <= number)
}
