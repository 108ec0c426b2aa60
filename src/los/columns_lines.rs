//! A part of a ray over columns, line by line: how the sweep asks about the few lines that may decide a receiver.
//!
//! Across the lines the ray moves faster than along them, so in each line it is in one cell or in two neighbors. Where it
//! is over the higher of the two at its lowest point in the line, the line is clear; only else are the cells looked at one
//! by one, as `ray` does. The cell is carried from line to line by adding to a remainder.

use crate::height_field::{Columns, TILE_BITS};
use crate::quantity::{LatticePoint, STEPS_PER_UNIT};

const CELL: i64 = STEPS_PER_UNIT as i64;

/// Lines of a tile.
const LINES: i64 = 1 << TILE_BITS;

/// Which way a line of cells lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Across {
    /// A row of cells, met by going north or south.
    Row,
    /// A column of cells, met by going east or west.
    Column,
}

/// The distances between which some lines lie \[lattice steps from the UAV\].
type Distances = (i64, i64);

/// Whether a link is clear, given that only some lines of cells can block it: a few of `groups`, each within a tile, and
/// those of `others`, which may be many.
///
/// The receiver is the center of cell `own` of the raster, in none of these lines, and not farther from the UAV along the
/// lines than across them. Cost: one comparison per line, or per eight of the others that lie in tiles below the link.
pub(super) fn columns_los_over_lines(
    columns: &Columns,
    uav: LatticePoint,
    (own, receiver): (usize, LatticePoint),
    across: Across,
    (groups, others): ([Option<Distances>; 3], Option<Distances>),
) -> bool {
    let (dx, dy) = (uav.x - receiver.x, uav.y - receiver.y);
    #[expect(clippy::cast_possible_wrap, reason = "a raster in memory has far fewer than 2^63 cells")]
    let row = columns.n_cols() as isize;
    let (east, north) = (receiver.x.div_euclid(CELL), receiver.y.div_euclid(CELL));
    // Rows are counted from the north.
    let (stride_x, stride_y) = (if dx < 0 { -1 } else { 1 }, if dy < 0 { row } else { -row });
    let cells_left = |d: i64, at: i64, n: usize| if d < 0 { at } else { as_i64(n) - 1 - at };
    let (length, along, stride, sideways, most) = match across {
        Across::Row => (dy.abs(), dx.abs(), stride_y, stride_x, cells_left(dx, east, columns.n_cols())),
        Across::Column => (dx.abs(), dy.abs(), stride_x, stride_y, cells_left(dy, north, columns.n_rows())),
    };
    let link = LinkOverLines { length, along, z: receiver.z, climb: uav.z - receiver.z, most };
    let (step_x, step_y) = (if dx < 0 { -1 } else { 1 }, if dy < 0 { 1 } else { -1 });
    let from_north = as_i64(columns.n_rows()) - 1 - north;
    let tiles = || {
        let per_row = as_isize(columns.tiles().per_row());
        let ((line, lateral), steps, strides) = match across {
            Across::Row => ((from_north, east), (step_y, step_x), (per_row, 1)),
            Across::Column => ((east, from_north), (step_x, step_y), (1, per_row)),
        };
        LineTiles { columns, line, lateral, steps, strides }
    };
    let cells = LineCells { tops: columns.tops(), own, stride, sideways, tiles: None };
    groups.iter().flatten().all(|lines| link.is_clear(&cells, *lines))
        && others.is_none_or(|lines| link.is_clear(&LineCells { tiles: Some(tiles()), ..cells }, lines))
}

/// A link as lines of cells see it, from the receiver to the UAV.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkOverLines {
    /// How far it goes across the lines \[lattice steps\], and along them, which is no farther.
    pub(super) length: i64,
    pub(super) along: i64,
    /// Height of the receiver, and of the UAV above it \[1/1024 m\].
    pub(super) z: i64,
    pub(super) climb: i64,
    /// Cells of the raster beside the receiver's, on the side of the UAV.
    pub(super) most: i64,
}

/// Where the cells of some lines are found.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineCells<'a> {
    /// Tops of the cells, line by line.
    pub(super) tops: &'a [i32],
    /// Index of the receiver's cell; where its line is not among `tops`, what it would be, wrapped around.
    pub(super) own: usize,
    /// Steps to the same cell of the next line towards the UAV, and to the next cell of a line.
    pub(super) stride: isize,
    pub(super) sideways: isize,
    /// The highest tops of tiles of these cells, if they are known.
    pub(super) tiles: Option<LineTiles<'a>>,
}

/// Where the tiles are found that lines of cells pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineTiles<'a> {
    columns: &'a Columns,
    /// The receiver's cell: its line, and its place in the line, as numbers of rows and columns of the raster.
    line: i64,
    lateral: i64,
    /// How both change on the way to the UAV, by 1.
    steps: (i64, i64),
    /// Steps to the tile of the next lines, and to the next tile of the same lines, as numbers rise.
    strides: (isize, isize),
}

impl LineTiles<'_> {
    /// The highest top in the tile of line `line` at `lateral`.
    #[inline(always)]
    fn maximum(&self, line: i64, lateral: i64) -> i32 {
        let (across, along) = self.strides;
        #[expect(clippy::cast_sign_loss, reason = "a tile of the raster")]
        let tile = ((line >> TILE_BITS) as isize * across + (lateral >> TILE_BITS) as isize * along) as usize;
        self.columns.tiles().maxima()[tile]
    }
}

impl LinkOverLines {
    /// Whether none of the lines from `near` to `far` \[lattice steps from the UAV\] blocks the link.
    pub(super) fn is_clear(&self, cells: &LineCells<'_>, (near, far): (i64, i64)) -> bool {
        let LinkOverLines { length, along, z, climb, most } = *self;
        let LineCells { tops, own, stride, sideways, tiles } = *cells;
        // EXACT: lengths are at most 2^26 and so is `along`, so all products are below 2^64 / 4.
        let whole = CELL * length;
        let (first_n, stop) = (length - far, length - near);
        let (passed, rest) = quotient(CELL / 2 * length + first_n * along, whole);
        let lines = (first_n - CELL / 2) / CELL + 1;
        let shift = |steps: i64, stride: isize| isize::try_from(steps).unwrap_or(0) * stride;
        let n_lines = (stop - first_n + CELL - 1).div_euclid(CELL);
        let mut at = Entry {
            cell: own.wrapping_add_signed(shift(lines, stride)).wrapping_add_signed(shift(passed, sideways)),
            rest,
            beside: most - passed,
            clear_below: z * length + if climb >= 0 { first_n } else { first_n + CELL } * climb,
        };
        let steps = Steps { tops, whole, growth: CELL * along, length, rise: CELL * climb, stride, sideways };
        let mut lines_left = n_lines;
        let mut line = tiles.map_or(0, |tiles| tiles.line + lines * tiles.steps.0);
        let tiles = tiles.map(|tiles| (tiles, Passed::of(LINES, along, length)));
        while lines_left > 0 {
            // Lines to be looked at, before a tile may spare some of them.
            let mut n = lines_left.min(LINES);
            if let Some((tiles, over_tile)) = &tiles {
                let (step, sidestep) = tiles.steps;
                let within = line & (LINES - 1);
                n = lines_left.min(if step > 0 { LINES - within } else { within + 1 });
                line += n * step;
                // Cells that the ray can pass meanwhile: nine in a row, or fewer, lie in the tiles of the first and the last.
                let reach = n.min(over_tile.borders + 1);
                if at.beside >= reach {
                    let from = tiles.lateral + sidestep * (most - at.beside);
                    let last = line - step;
                    let highest = tiles.maximum(last, from).max(tiles.maximum(last, from + sidestep * reach));
                    if i64::from(highest) * length <= at.clear_below + ((n - 1) * CELL * climb).min(0) {
                        lines_left -= n;
                        let over = if n == LINES { *over_tile } else { Passed::of(n, along, length) };
                        at.rest += CELL * over.rest;
                        let carries = at.rest >= whole;
                        at.rest -= if carries { whole } else { 0 };
                        let borders = over.borders + i64::from(carries);
                        at.beside -= borders;
                        at.cell =
                            at.cell.wrapping_add_signed(shift(n, stride)).wrapping_add_signed(shift(borders, sideways));
                        at.clear_below += n * CELL * climb;
                        continue;
                    }
                }
            }
            if at.beside >= n {
                let (after, may_block) = steps.over(at, n);
                if !may_block {
                    at = after;
                    lines_left -= n;
                    continue;
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
                let second = if steps_over && at.beside == 0 { i32::MIN } else { tops[second] };
                if i64::from(tops[first].max(second)) * length > at.clear_below {
                    let n = first_n + (n_lines - lines_left) * CELL;
                    let met = LineMet { n, passed: most - at.beside, rest: after.rest, steps_over };
                    if self.is_blocked(met, (tops[first], second)) {
                        return false;
                    }
                }
                at = after;
                lines_left -= 1;
            }
        }
        true
    }

    /// Whether one line blocks, given the tops of the cells in which the ray enters and leaves it.
    #[inline(never)]
    fn is_blocked(&self, at: LineMet, (first, second): (i32, i32)) -> bool {
        let LinkOverLines { length, along, z, climb, .. } = *self;
        let LineMet { n, passed, rest, steps_over } = at;
        let (first, second) = (i64::from(first) - z, i64::from(second) - z);
        let end = (n + CELL).min(length);
        // Where the ray steps over, if that is short of the UAV and not at a corner, where both indices step at once.
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

/// Where a ray enters a line of cells.
#[derive(Debug, Clone, Copy)]
struct Entry {
    /// The cell.
    cell: usize,
    /// How far it is past the cell's near border, in cells times the length of the link.
    rest: i64,
    /// Cells beside it that the raster still has.
    beside: i64,
    /// A line whose cells are no higher than this, times `length`, is below all of the ray that is over it.
    clear_below: i64,
}

/// How a ray goes from line to line.
#[derive(Debug, Clone, Copy)]
struct Steps<'a> {
    tops: &'a [i32],
    whole: i64,
    growth: i64,
    length: i64,
    rise: i64,
    stride: isize,
    sideways: isize,
}

impl Steps<'_> {
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

    /// Where the ray is after `n` lines, all of whose cells are in the raster, and whether one of them may block it.
    #[inline(always)]
    fn over(&self, mut at: Entry, n: i64) -> (Entry, bool) {
        let mut may_block = false;
        for _ in 0..n {
            let (first, second, after) = self.over_one(at);
            let highest = self.tops[first].max(self.tops[second]);
            may_block |= i64::from(highest) * self.length > at.clear_below;
            at = after;
        }
        (at, may_block)
    }
}

/// Quotient, rounded down, and remainder of a number within ±2^53 by a positive one.
#[inline(always)]
fn quotient(number: i64, by: i64) -> (i64, i64) {
    debug_assert!(number.unsigned_abs() <= 1 << 53 && (1..=1 << 53).contains(&by));
    // PERF: integers of 64 bits are divided in three times the time. EXACT: both are doubles as they are, and so are multiples
    // of `by` up to the number, which a rounded quotient is on the right side of: the guess is off by one at most.
    #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "a guess, put right below")]
    let guess = (number as f64 / by as f64) as i64;
    let rest = number - guess * by;
    let off = i64::from(rest >= by) - i64::from(rest < 0);
    (guess + off, rest - off * by)
}

/// What a ray passes sideways on its way over some lines.
#[derive(Debug, Clone, Copy)]
struct Passed {
    /// Whole cells.
    borders: i64,
    /// What is left over, in cells times the length of the link.
    rest: i64,
}

impl Passed {
    /// Over `n` lines, at most a tile of them.
    fn of(n: i64, along: i64, length: i64) -> Self {
        // EXACT: both are at most 2^26, so that 32 bits do, which are divided in half the time.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 2^29")]
        let (passed, length) = ((n * along) as u32, length as u32);
        Passed { borders: i64::from(passed / length), rest: i64::from(passed % length) }
    }
}

/// A line of cells that a ray meets.
#[derive(Debug, Clone, Copy)]
struct LineMet {
    /// Where the ray enters it, from the receiver \[lattice steps across the lines\].
    n: i64,
    /// Borders between cells passed before, and what is left over after the line.
    passed: i64,
    rest: i64,
    /// Whether it leaves the line in the next cell.
    steps_over: bool,
}

fn as_isize(n: usize) -> isize {
    isize::try_from(n).unwrap_or(isize::MAX)
}

fn as_i64(n: usize) -> i64 {
    i64::try_from(n).unwrap_or(i64::MAX)
}
