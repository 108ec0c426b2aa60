//! Cells in range of a place, mostly that of a UAV, row by row: a disc, or the part of it that an
//! antenna serves.
//!
//! Distances are whole lattice steps, and a direction is rounded once ([`super::bearings`]), so all
//! comparisons after that are of integers: a scene and its mirror image agree. A receiver at just
//! the radius, the least radius or the end of the elevations is in range.

use rayon::prelude::*;

use super::bearings::{Sector, Steps};
use super::height_limits::HeightLimits;
use super::{MapOptions, Uav};
use crate::city::Antenna;
use crate::height_field::{GridPositions, Place, Station};
use crate::los::GridReceivers;
use crate::quantity::whole;
use crate::raster::{BitGrid, CellWindow, bits_between, set_bits};

/// The first of some columns and the one after the last.
pub(super) type Span = (usize, usize);

/// Cells in range of a place.
#[derive(Debug)]
pub(super) struct Range<'a> {
    around: Around<'a>,
    limits: Limits,
    /// Cells that distance and azimuth leave in range, and where all receivers stand on flat ground
    /// their heights too; `None` if all are.
    cells: Option<Spans>,
    /// Limits that depend on heights, if there are any.
    by_height: Option<ByHeight>,
}

/// Cells that heights leave in range.
#[derive(Debug)]
struct ByHeight {
    limits: HeightLimits,
    /// The height of the place \[1/1024 m\].
    from: i64,
    /// The cells where some receiver may be in range.
    cells: Option<Spans>,
}

/// The cells of a grid around a place.
#[derive(Debug, Clone, Copy)]
struct Around<'a> {
    positions: &'a GridPositions,
    /// The place on the lattice of distances.
    at: Steps,
    /// The length of a step along y, of those along x.
    ratio: f64,
    /// The row and the column that are nearest.
    nearest: (usize, usize),
}

/// Limits of distance and azimuth; distances in steps along x.
#[derive(Debug, Clone, Copy, Default)]
struct Limits {
    radius: Option<f64>,
    min_radius: Option<f64>,
    sector: Option<Sector>,
}

/// Columns of each row, in order and apart from each other.
#[derive(Debug, Clone)]
struct Spans {
    first_row: usize,
    all: Vec<Span>,
    /// Ends of the columns of each row.
    ends: Vec<usize>,
}

/// Heights of receivers \[1/1024 m above the datum\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Heights {
    pub(super) lowest: i64,
    pub(super) highest: i64,
    /// All of them stand on flat ground, as any would in a cell that holds none.
    pub(super) are_flat: bool,
}

impl Heights {
    /// Returns the heights of receivers of several kinds.
    pub(super) fn of_all(kinds: impl Iterator<Item = Heights>) -> Heights {
        let both = |a: Heights, b: Heights| Heights {
            lowest: a.lowest.min(b.lowest),
            highest: a.highest.max(b.highest),
            are_flat: a.are_flat && b.are_flat,
        };
        kinds.reduce(both).unwrap_or(Heights { lowest: 0, highest: 0, are_flat: false })
    }
}

impl<'a> Range<'a> {
    /// Returns the cells whose centers are at most `radius` \[CRS units\] from a place.
    pub(super) fn disc(positions: &'a GridPositions, place: &Place, radius: f64) -> Self {
        let limits = Limits { radius: Some(in_steps(positions, radius)), ..Limits::default() };
        Range::new(positions, place, limits, None)
    }

    /// Returns the cells in range of a UAV: in the radius, and where its antenna, or else that of
    /// the run, serves.
    pub(super) fn of(positions: &'a GridPositions, uav: &Uav, options: &MapOptions, heights: Heights) -> Self {
        let (limits, of_heights) = asked(positions, uav.antenna.or(options.antenna), options);
        let of_heights = of_heights.map(|limits| (limits, uav.station.z, heights));
        Range::new(positions, &uav.station.place, limits, of_heights)
    }

    /// Returns the places of UAVs at height `z` \[1/1024 m\] that have a receiver in range, with
    /// the antenna of the run.
    pub(super) fn of_uavs(positions: &'a GridPositions, receiver: &Station, z: i64, options: &MapOptions) -> Self {
        let (mut limits, of_heights) = asked(positions, options.antenna, options);
        // As seen from there the azimuths are turned around.
        limits.sector = limits.sector.map(Sector::reversed);
        let around = Around::new(positions, &receiver.place);
        let rise = receiver.z - z;
        let cells = limits.cells(&around, of_heights.as_ref().map(|of_heights| (of_heights, (rise, rise))));
        Range { around, limits, cells, by_height: None }
    }

    fn new(
        positions: &'a GridPositions,
        place: &Place,
        limits: Limits,
        of_heights: Option<(HeightLimits, i64, Heights)>,
    ) -> Self {
        let around = Around::new(positions, place);
        let Some((of_heights, from, Heights { lowest, highest, are_flat })) = of_heights else {
            return Range { around, limits, cells: limits.cells(&around, None), by_height: None };
        };
        let of_any = limits.cells(&around, Some((&of_heights, (lowest - from, highest - from))));
        let cells = if are_flat { of_any.clone() } else { limits.cells(&around, None) };
        Range { around, limits, cells, by_height: Some(ByHeight { limits: of_heights, from, cells: of_any }) }
    }

    /// Returns whether no cell is out of range.
    pub(super) fn is_everywhere(&self) -> bool {
        self.cells.is_none() && self.by_height.is_none()
    }

    /// Returns whether receivers may be out of range for their height.
    pub(super) fn limits_heights(&self) -> bool {
        self.by_height.is_some()
    }

    /// Returns the columns of a row that hold the cells in range, but that heights of receivers not on flat
    /// ground may leave them out.
    pub(super) fn cols(&self, row: usize) -> impl Iterator<Item = Span> + Clone + use<'_> {
        let whole = (0, self.around.positions.shape().1);
        let (one, several) = match &self.cells {
            None => (Some(whole), &[][..]),
            Some(cells) => (None, cells.of_row(row)),
        };
        one.into_iter().chain(several.iter().copied())
    }

    /// Returns whether the receiver of a cell is in range.
    pub(super) fn contains(&self, receivers: &GridReceivers<'_>, (row, col): (usize, usize)) -> bool {
        let z = || receivers.height(row * receivers.cells.n_cols() + col);
        self.cols(row).any(|(first, end)| (first..end).contains(&col))
            && self.by_height.as_ref().is_none_or(|ByHeight { limits, from, .. }| {
                limits.holds(z() - from, self.around.whole_squared(row, col))
            })
    }

    /// Returns a window that holds all cells in range, and all cells between them and the place.
    pub(super) fn window(&self) -> CellWindow {
        let (n_rows, n_cols) = self.around.positions.shape();
        let cells = self.by_height.as_ref().map_or(&self.cells, |by_height| &by_height.cells);
        let Some(cells) = cells else { return CellWindow { row: 0, col: 0, n_rows, n_cols } };
        let (west, east) = (cells.all.iter().map(|s| s.0).min(), cells.all.iter().map(|s| s.1).max());
        let (Some(mut west), Some(mut east)) = (west, east) else {
            return CellWindow { row: 0, col: 0, n_rows: 0, n_cols: 0 };
        };
        let (mut north, mut south) = (cells.first_row, cells.first_row + cells.ends.len());
        let is_disc = self.by_height.is_none() && self.limits.sector.is_none() && self.limits.min_radius.is_none();
        if !is_disc {
            let (row, col) = self.around.nearest;
            (north, south, west, east) = (north.min(row), south.max(row + 1), west.min(col), east.max(col + 1));
        }
        CellWindow { row: north, col: west, n_rows: south - north, n_cols: east - west }
    }

    /// Returns the smallest window that holds those of two ranges.
    pub(super) fn window_with(&self, other: &Range<'_>) -> CellWindow {
        let (a, b) = (self.window(), other.window());
        let (row, col) = (a.row.min(b.row), a.col.min(b.col));
        let (end_row, end_col) = ((a.row + a.n_rows).max(b.row + b.n_rows), (a.col + a.n_cols).max(b.col + b.n_cols));
        CellWindow { row, col, n_rows: end_row - row, n_cols: end_col - col }
    }

    /// Returns the cells of a set that are in range, but that heights of receivers not on flat ground may
    /// leave them out.
    pub(super) fn cut(&self, cells: &BitGrid) -> BitGrid {
        match &self.cells {
            None => cells.clone(),
            Some(spans) => {
                let mut kept = BitGrid::new(cells.n_rows(), cells.n_cols());
                spans.keep(cells, &mut kept);
                kept
            }
        }
    }

    /// Returns the cells of receivers that are in range.
    pub(super) fn cut_receivers(&self, receivers: &GridReceivers<'_>) -> BitGrid {
        let mut kept = self.cut_between(&receivers.cells, receivers.heights_range());
        if receivers.level().is_none() {
            self.drop_beyond(receivers, 0, &mut kept);
        }
        kept
    }

    /// Returns the cells of a set where a receiver between two heights \[1/1024 m above the datum\]
    /// may be in range.
    pub(super) fn cut_between(&self, cells: &BitGrid, (lowest, highest): (i64, i64)) -> BitGrid {
        let Some(ByHeight { limits, from, .. }) = &self.by_height else { return self.cut(cells) };
        let mut kept = BitGrid::new(cells.n_rows(), cells.n_cols());
        if let Some(spans) = self.limits.cells(&self.around, Some((limits, (lowest - from, highest - from)))) {
            spans.keep(cells, &mut kept);
        }
        kept
    }

    /// Drops cells from a set whose receivers heights leave out of range.
    /// `receivers` are those of the rows from `first_row` on.
    pub(super) fn drop_beyond(&self, receivers: &GridReceivers<'_>, first_row: usize, cells: &mut BitGrid) {
        let Some(ByHeight { limits, from, .. }) = &self.by_height else { return };
        let (per_row, n_cols) = (cells.words_per_row(), cells.n_cols());
        let n_rows = receivers.cells.n_rows();
        let words = &mut cells.words_mut()[first_row * per_row..(first_row + n_rows) * per_row];
        words.par_chunks_mut(per_row).enumerate().for_each(|(own_row, words)| {
            let row = first_row + own_row;
            for (k, word) in words.iter_mut().enumerate() {
                for bit in set_bits(&[*word]) {
                    let col = 64 * k + bit;
                    let rise = receivers.height(own_row * n_cols + col) - from;
                    if !limits.holds(rise, self.around.whole_squared(row, col)) {
                        *word &= !(1 << bit);
                    }
                }
            }
        });
    }
}

/// Returns the limits of an antenna and of the radius of some options, on the lattice of some
/// positions.
fn asked(positions: &GridPositions, antenna: Antenna, options: &MapOptions) -> (Limits, Option<HeightLimits>) {
    let step_lengths = positions.step_lengths();
    let limits = Limits {
        radius: options.radius.map(|r| in_steps(positions, r)),
        min_radius: antenna.min_radius_m.map(|r| in_steps(positions, r / options.meters_per_unit)),
        sector: antenna.sector_deg.and_then(|sector| Sector::new(sector, step_lengths)),
    };
    (limits, HeightLimits::of(antenna, step_lengths.0 * options.meters_per_unit))
}

/// Returns a length in CRS units in steps along x: whole where it is a whole number of them but for
/// rounding.
fn in_steps(positions: &GridPositions, length: f64) -> f64 {
    whole(length / positions.step_lengths().0)
}

impl<'a> Around<'a> {
    fn new(positions: &'a GridPositions, place: &Place) -> Self {
        let (step_x, step_y) = positions.step_lengths();
        let at = positions.on_range(place);
        let mut around = Around { positions, at, ratio: step_y / step_x, nearest: (0, 0) };
        let (n_rows, n_cols) = positions.shape();
        let nearest = |n: usize, squared: &dyn Fn(usize) -> f64| {
            (0..n).min_by(|a, b| squared(*a).total_cmp(&squared(*b))).unwrap_or(0)
        };
        let col = nearest(n_cols, &|col| around.squared(0, col));
        around.nearest = (nearest(n_rows, &|row| around.squared(row, col)), col);
        around
    }

    /// Steps east and north to a cell.
    fn steps(&self, row: usize, col: usize) -> Steps {
        self.positions.steps(self.at, (row, col))
    }

    /// Returns the squared distance of a cell, in steps along x.
    fn squared(&self, row: usize, col: usize) -> f64 {
        let (dx, dy) = self.steps(row, col);
        let (dx, dy) = (dx as f64, dy as f64 * self.ratio);
        dx * dx + dy * dy
    }

    /// Returns the squared distance of a cell as a whole number: exact where steps along both axes
    /// are equally long.
    fn whole_squared(&self, row: usize, col: usize) -> i128 {
        #[expect(clippy::cast_possible_truncation, reason = "at most 2^56")]
        let squared = self.squared(row, col).round() as i64;
        i128::from(squared)
    }
}

impl Limits {
    /// Returns the cells of a grid within the limits; `None` where nothing is limited. With limits of
    /// heights, cells where some receiver may be in range that is between two heights above the place
    /// \[1/1024 m\].
    fn cells(&self, around: &Around<'_>, of_heights: Option<(&HeightLimits, (i64, i64))>) -> Option<Spans> {
        let Limits { radius, min_radius, sector } = *self;
        if radius.is_none() && min_radius.is_none() && sector.is_none() && of_heights.is_none() {
            return None;
        }
        let is_beyond = |row: usize, col: usize, far: bool| {
            of_heights.is_some_and(|(limits, rises)| limits.excludes(rises, around.whole_squared(row, col), far))
        };
        let is_too_far = |row: usize, col: usize| {
            radius.is_some_and(|r| around.squared(row, col) > r * r) || is_beyond(row, col, true)
        };
        let is_too_near = |row: usize, col: usize| {
            min_radius.is_some_and(|r| around.squared(row, col) < r * r) || is_beyond(row, col, false)
        };
        let (n_rows, n_cols) = around.positions.shape();
        let (nearest_row, nearest) = around.nearest;
        // Away from the nearest column, or row, distances only grow both ways.
        let cols = |holds: &dyn Fn(usize) -> bool| match holds(nearest) {
            true => (partition(0..nearest, |col| !holds(col)), partition(nearest..n_cols, holds)),
            false => (0, 0),
        };
        let mut spans = Spans { first_row: 0, all: Vec::new(), ends: Vec::new() };
        if is_too_far(nearest_row, nearest) {
            return Some(spans);
        }
        spans.first_row = partition(0..nearest_row, |row| is_too_far(row, nearest));
        let end_row = partition(nearest_row..n_rows, |row| !is_too_far(row, nearest));
        let (ends, begins) = (radius.is_some() || of_heights.is_some(), min_radius.is_some() || of_heights.is_some());
        let mut of_row = Vec::new();
        for row in spans.first_row..end_row {
            of_row.clear();
            of_row.push(if ends { cols(&|col| !is_too_far(row, col)) } else { (0, n_cols) });
            if begins {
                remove(&mut of_row, cols(&|col| is_too_near(row, col)));
            }
            if let Some(sector) = &sector {
                sector.keep(&mut of_row, n_cols, |col| around.steps(row, col));
            }
            // Rows without any at the beginning are left out.
            if of_row.is_empty() && spans.all.is_empty() {
                spans.first_row += 1;
                continue;
            }
            spans.all.extend(&of_row);
            spans.ends.push(spans.all.len());
        }
        // And those at the end.
        let n_used = spans.ends.partition_point(|end| *end < spans.all.len()) + 1;
        spans.ends.truncate(n_used);
        Some(spans)
    }
}

impl Sector {
    /// Keeps the columns of a row that are in the sector, given the steps to each of `n_cols`.
    fn keep(&self, spans: &mut Vec<Span>, n_cols: usize, steps: impl Fn(usize) -> Steps) {
        // Each half turn holds the columns to one side of a place in the row.
        let half = |start: Steps| {
            let holds = |col: usize| self.is_in_half_turn(start, steps(col));
            match (holds(0), holds(n_cols - 1)) {
                (true, true) => (0, n_cols),
                (true, false) => (0, partition(0..n_cols, holds)),
                (false, true) => (partition(0..n_cols, |col| !holds(col)), n_cols),
                (false, false) => (0, 0),
            }
        };
        let (from, to) = (half(self.from), half(self.to));
        if self.is_narrow {
            remove(spans, (0, from.0));
            remove(spans, (from.1, n_cols));
            remove(spans, to);
        } else {
            let mut rest = vec![to];
            remove(&mut rest, from);
            rest.into_iter().for_each(|of_rest| remove(spans, of_rest));
        }
    }
}

impl Spans {
    fn of_row(&self, row: usize) -> &[Span] {
        let Some(k) = row.checked_sub(self.first_row).filter(|k| *k < self.ends.len()) else { return &[] };
        &self.all[if k == 0 { 0 } else { self.ends[k - 1] }..self.ends[k]]
    }

    /// Adds the cells of a set that they hold to another set.
    fn keep(&self, cells: &BitGrid, kept: &mut BitGrid) {
        let per_row = kept.words_per_row();
        for row in self.first_row..self.first_row + self.ends.len() {
            for (from, to) in self.of_row(row) {
                for word in from / 64..to.div_ceil(64) {
                    kept.words_mut()[row * per_row + word] |= cells.row(row)[word] & bits_between(*from, *to, word);
                }
            }
        }
    }
}

/// Removes some columns from others.
fn remove(spans: &mut Vec<Span>, (from, to): Span) {
    if from < to {
        let apart = spans.iter().flat_map(|(first, end)| [(*first, from.min(*end)), (to.max(*first), *end)]);
        *spans = apart.filter(|(first, end)| first < end).collect();
    }
    spans.retain(|(first, end)| first < end);
}

/// Returns whether a set holds a cell whose center is at most `radius` \[CRS units\] from a place.
pub fn any_in_range(positions: &GridPositions, place: &Place, radius: f64, cells: &BitGrid) -> bool {
    let range = Range::disc(positions, place, radius);
    let CellWindow { row, n_rows, .. } = range.window();
    (row..row + n_rows).any(|row| {
        range.cols(row).any(|(from, to)| {
            (from / 64..to.div_ceil(64)).any(|word| cells.row(row)[word] & bits_between(from, to, word) != 0)
        })
    })
}

/// Returns the first index of a range for which `holds` is false; it holds for all before and for
/// none after.
fn partition(range: std::ops::Range<usize>, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (range.start, range.end);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}
