//! A walk along a part of a ray, row by row, for the few rows in memory that may hide a receiver in
//! step 5.
//!
//! Across the rows the ray moves faster than along them, so in each row it is in one cell or in two
//! neighbors. If its lowest point in the row is above the higher of the two, the row is clear.
//! Otherwise the cells are looked at one by one, as `ray` does. The cell is carried from row to row
//! by adding to a remainder.

use crate::height_field::{Columns, Drops, TILE_BITS, TileMaxima};
use crate::quantity::{STEPS_PER_UNIT, VOID};

const CELL: i64 = STEPS_PER_UNIT as i64;

const LINES: i64 = 1 << TILE_BITS;

/// Length of links across lines of cells; it is the same for all receivers of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkLength {
    steps: i64,
    per_whole: f64,
}

impl LinkLength {
    /// Makes a length in lattice steps, at most 2^26.
    #[expect(clippy::cast_precision_loss, reason = "at most 2^36")]
    pub(super) fn new(steps: i64) -> Self {
        LinkLength { steps, per_whole: 1.0 / (CELL * steps) as f64 }
    }

    /// Returns the length in lattice steps.
    #[inline(always)]
    pub(super) fn steps(self) -> i64 {
        self.steps
    }

    /// Divides a number from 0 to 2^53 by a cell times the length. Returns the quotient, which is
    /// below 2^17, and the remainder.
    #[inline(always)]
    fn divide(self, number: i64) -> (i64, i64) {
        let whole = CELL * self.steps;
        debug_assert!((0..1 << 53).contains(&number) && number >> 17 < whole);
        // PERF: a division of 64-bit integers takes ten times as long. EXACT: the quotient is below
        // 2^17, so the guess, which is rounded twice and truncated, is off by one at most.
        #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "a guess, put right below")]
        let guess = (number as f64 * self.per_whole) as i64;
        let rest = number - guess * whole;
        let off = i64::from(rest >= whole) - i64::from(rest < 0);
        (guess + off, rest - off * whole)
    }
}

/// A link over lines of cells, from the receiver to the UAV. The receiver is over the center of a
/// cell, and no farther from the UAV along the lines than across them.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkOverRows {
    length: LinkLength,
    /// Length along the lines \[lattice steps\].
    along: i64,
    /// Direction along the lines: 1 if lateral cells have rising numbers on the way to the UAV,
    /// else −1.
    sideways: i64,
    /// Height of the receiver, and of the UAV above it \[1/1024 m\].
    z: i64,
    climb: i64,
    /// Cells of the raster beside the receiver's, on the side of the UAV.
    most: i64,
}

impl LinkOverRows {
    /// Makes a link from lateral cell `lateral` of `n_lateral`, at height `z`, to a UAV `climb`
    /// above it. The UAV's lateral position is `uav_lateral` \[lattice steps; heights 1/1024 m\].
    #[inline(always)]
    pub(super) fn new(
        length: LinkLength,
        (lateral, n_lateral): (i64, i64),
        uav_lateral: i64,
        (z, climb): (i64, i64),
    ) -> Self {
        let side = uav_lateral - (lateral * CELL + CELL / 2);
        let (sideways, most) = if side < 0 { (-1, lateral) } else { (1, n_lateral - 1 - lateral) };
        LinkOverRows { length, along: side.abs(), sideways, z, climb, most }
    }
}

/// Positions of the cells of some lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowCells<'a> {
    pub(super) seen: SeenTops<'a>,
    /// The line of the receiver's cell, and its place in the line, as numbers of rows and columns
    /// of the raster.
    pub(super) at: (i64, i64),
    /// Change of the line's number on the way to the UAV, by 1.
    pub(super) step: i64,
    /// Index of the receiver's cell. If its line is not among `tops`, it is the index that it would
    /// have, wrapped around.
    pub(super) own: usize,
    /// Strides to the same cell of the next line towards the UAV, and to the next cell of a line,
    /// as lateral numbers rise.
    pub(super) strides: (i64, i64),
    /// The highest tops of tiles of these cells, if known.
    pub(super) tiles: Option<RowTiles<'a>>,
}

/// The tops of the cells of a raster as the UAV sees them, over lines that are rows or columns of
/// it.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenTops<'a> {
    /// Tops over a flat earth, row by row.
    tops: &'a [i32],
    drops: Option<&'a Drops>,
    are_rows: bool,
}

impl<'a> SeenTops<'a> {
    /// Returns the tops of columns.
    pub(super) fn of(columns: &'a Columns, are_rows: bool) -> Self {
        SeenTops { tops: columns.flat_tops(), drops: columns.drops(), are_rows }
    }

    /// Returns the top of a cell, from its index, its line and its place in the line.
    #[inline(always)]
    pub(super) fn top(&self, index: usize, place: (i64, i64)) -> i32 {
        let top = self.tops[index];
        let Some(drops) = self.drops else { return top };
        let (line, lateral) = (usize::try_from(place.0).unwrap_or(0), usize::try_from(place.1).unwrap_or(0));
        drops.lowered(top, if self.are_rows { (line, lateral) } else { (lateral, line) })
    }
}

/// Positions of the tiles that lines of cells pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowTiles<'a> {
    pub(super) tiles: &'a TileMaxima,
    /// Strides to the tile of the next lines, and to the next tile of the same lines, as numbers
    /// rise.
    pub(super) strides: (i64, i64),
}

impl RowTiles<'_> {
    /// Returns the highest top in the tile of line `line` at `lateral`.
    #[inline(always)]
    fn maximum(&self, line: i64, lateral: i64) -> i32 {
        let (across, along) = self.strides;
        #[expect(clippy::cast_sign_loss, clippy::cast_possible_truncation, reason = "a tile of the raster")]
        let tile = ((line >> TILE_BITS) * across + (lateral >> TILE_BITS) * along) as usize;
        self.tiles.maxima()[tile]
    }
}

impl LinkOverRows {
    /// Returns `true` if no line from `near` to `far` \[lattice steps from the UAV\] blocks the
    /// link. The receiver's own line is not among them.
    pub(super) fn is_clear(&self, cells: &RowCells<'_>, edges: (i64, i64)) -> bool {
        // PERF: a walk for each, not a choice for every cell.
        match cells.seen.drops {
            None => self.is_clear_of(cells, edges, |cell, _, _| cells.seen.tops[cell]),
            Some(_) => self.is_clear_of(cells, edges, |cell, line, passed| {
                cells.seen.top(cell, (cells.at.0 + line * cells.step, cells.at.1 + passed * self.sideways))
            }),
        }
    }

    /// Decides [`LinkOverRows::is_clear`]. Gets the top of a cell from `top_of`, by its index and
    /// its numbers of lines and lateral cells from the receiver.
    #[inline(always)]
    fn is_clear_of(
        &self,
        cells: &RowCells<'_>,
        (near, far): (i64, i64),
        top_of: impl Fn(usize, i64, i64) -> i32,
    ) -> bool {
        let LinkOverRows { along, z, climb, most, .. } = *self;
        debug_assert!(far + CELL / 2 <= self.length.steps && along <= self.length.steps);
        let RowCells { own, strides, tiles, at: (own_line, lateral), step, .. } = *cells;
        #[expect(clippy::cast_possible_truncation, reason = "an array has far fewer than 2^63 cells")]
        let (stride, sideways) = (strides.0 as isize, (strides.1 * self.sideways) as isize);
        // EXACT: lengths are at most 2^26 and so is `along`, so all products are below 2^64 / 4.
        let length = self.length.steps;
        let whole = CELL * length;
        let (first_n, stop) = (length - far, length - near);
        let (passed, rest) = self.length.divide(CELL / 2 * length + first_n * along);
        let lines = (first_n - CELL / 2) / CELL + 1;
        let n_lines = (stop - first_n + CELL - 1).div_euclid(CELL);
        let mut at = Entry {
            cell: own.wrapping_add_signed(shift(lines, stride)).wrapping_add_signed(shift(passed, sideways)),
            rest,
            beside: most - passed,
            clear_below: z * length + if climb >= 0 { first_n } else { first_n + CELL } * climb,
        };
        let steps = Steps { whole, growth: CELL * along, rise: CELL * climb, stride, sideways };
        let mut lines_left = n_lines;
        let mut line = own_line + lines * step;
        let tiles = tiles.map(|tiles| (tiles, Passed::of(LINES, along, length)));
        while lines_left > 0 {
            // Lines to be looked at, unless a tile allows skipping them.
            let mut n = lines_left;
            if let Some((tiles, over_tile)) = &tiles {
                let within = line & (LINES - 1);
                n = lines_left.min(if step > 0 { LINES - within } else { within + 1 });
                line += n * step;
                // Cells that the ray can pass meanwhile: nine in a row, or fewer, lie in the tiles
                // of the first and the last.
                let reach = n.min(over_tile.borders + 1);
                if at.beside >= reach {
                    let from = lateral + self.sideways * (most - at.beside);
                    let last = line - step;
                    let highest = tiles.maximum(last, from).max(tiles.maximum(last, from + self.sideways * reach));
                    if i64::from(highest) * length <= at.clear_below + ((n - 1) * CELL * climb).min(0) {
                        lines_left -= n;
                        let over = if n == LINES { *over_tile } else { Passed::of(n, along, length) };
                        at = steps.over_lines(at, n, over);
                        continue;
                    }
                }
            }
            for _ in 0..n {
                if at.beside < 0 {
                    // Beside the raster nothing blocks.
                    return true;
                }
                // The ray enters the line in `cell`, and leaves it there or in the next one.
                let (first, second, after) = steps.over_one(at);
                let steps_over = after.beside != at.beside;
                let (passed_lines, passed) = (n_lines - lines_left, most - at.beside);
                let top = |cell: usize, passed: i64| top_of(cell, lines + passed_lines, passed);
                let is_beside = steps_over && at.beside == 0;
                let second = if is_beside { VOID } else { top(second, passed + i64::from(steps_over)) };
                let first = top(first, passed);
                if i64::from(first.max(second)) * length > at.clear_below {
                    let n = first_n + passed_lines * CELL;
                    let met = RowMet { n, passed, rest: after.rest, steps_over };
                    if self.is_blocked(met, (first, second)) {
                        return false;
                    }
                }
                at = after;
                lines_left -= 1;
            }
        }
        true
    }

    /// Returns `true` if one line blocks, from the tops of the cells in which the ray enters and
    /// leaves it.
    #[inline(never)]
    fn is_blocked(&self, at: RowMet, (first, second): (i32, i32)) -> bool {
        let LinkOverRows { along, z, climb, .. } = *self;
        let length = self.length.steps;
        let RowMet { n, passed, rest, steps_over } = at;
        let (first, second) = (i64::from(first) - z, i64::from(second) - z);
        let end = (n + CELL).min(length);
        // The ray steps over if that is short of the UAV and not at a corner, where both indices
        // step at once.
        let border = CELL / 2 + passed * CELL;
        let crosses = steps_over && rest > 0 && border < along;
        if climb >= 0 {
            first * length > n * climb || (crosses && second * along > border * climb)
        } else if crosses {
            first * along > border * climb || second * length > end * climb
        } else {
            first * length > end * climb
        }
    }
}

/// The point at which a ray enters a line of cells.
#[derive(Debug, Clone, Copy)]
struct Entry {
    cell: usize,
    /// Distance past the cell's near border, in cells times the length of the link.
    rest: i64,
    /// Remaining cells of the raster beside it.
    beside: i64,
    /// Bound on heights, times `length`: the ray over a line is above all cells that are no higher.
    clear_below: i64,
}

/// Changes of a ray from line to line.
#[derive(Debug, Clone, Copy)]
struct Steps {
    whole: i64,
    growth: i64,
    rise: i64,
    stride: isize,
    sideways: isize,
}

/// Cells to an index so many steps farther.
#[inline(always)]
fn shift(steps: i64, stride: isize) -> isize {
    isize::try_from(steps).unwrap_or(0) * stride
}

impl Steps {
    /// Returns where the ray enters the line after `n` others, over which it passes so much sideways.
    #[inline(always)]
    fn over_lines(&self, at: Entry, n: i64, over: Passed) -> Entry {
        let rest = at.rest + CELL * over.rest;
        let carries = rest >= self.whole;
        let borders = over.borders + i64::from(carries);
        Entry {
            cell: at.cell.wrapping_add_signed(shift(n, self.stride)).wrapping_add_signed(shift(borders, self.sideways)),
            rest: rest - if carries { self.whole } else { 0 },
            beside: at.beside - borders,
            clear_below: at.clear_below + n * self.rise,
        }
    }

    /// The cells in which the ray enters and leaves a line, and where it enters the next one.
    #[inline(always)]
    fn over_one(&self, at: Entry) -> (usize, usize, Entry) {
        let rest = at.rest + self.growth;
        let over = rest >= self.whole;
        let rest = rest - (self.whole & -i64::from(over));
        let next = at.cell.wrapping_add_signed(self.sideways & -isize::from(over));
        (
            at.cell,
            next,
            Entry {
                cell: next.wrapping_add_signed(self.stride),
                rest,
                beside: at.beside - i64::from(over),
                clear_below: at.clear_below + self.rise,
            },
        )
    }
}

/// The cells that a ray passes sideways on its way over some lines.
#[derive(Debug, Clone, Copy)]
struct Passed {
    /// Number of whole cells.
    borders: i64,
    /// The remainder, in cells times the length of the link.
    rest: i64,
}

impl Passed {
    /// Computes it for `n` lines, at most a tile of them.
    fn of(n: i64, along: i64, length: i64) -> Self {
        // EXACT: both are at most 2^26, so 32 bits are enough, which are divided in half the time.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 2^29")]
        let (passed, length) = ((n * along) as u32, length as u32);
        Passed { borders: i64::from(passed / length), rest: i64::from(passed % length) }
    }
}

/// A line of cells that a ray meets.
#[derive(Debug, Clone, Copy)]
struct RowMet {
    /// Distance of the ray's entry from the receiver \[lattice steps across the lines\].
    n: i64,
    /// Borders between cells passed before, and the remainder after the line.
    passed: i64,
    rest: i64,
    /// `true` if it leaves the line in the next cell.
    steps_over: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_divided_as_integers_are() {
        // Over 25 088 the guess for many multiples is one too low.
        for steps in [512, 513, 25_088, 1024 * 77 + 512, (1 << 26) - 1, 1 << 26] {
            let length = LinkLength::new(steps);
            let whole = CELL * steps;
            for quotient in [0, 1, 2, 1000, 65_535] {
                for rest in [0, 1, whole / 3, whole - 2, whole - 1] {
                    assert_eq!(length.divide(quotient * whole + rest), (quotient, rest), "{steps} {quotient} {rest}");
                }
            }
        }
    }
}
