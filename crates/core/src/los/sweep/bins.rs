//! What the bins of a wedge know of the lines that passed over them.

use std::ops::Range;

use super::kernels::{GroupRows, NOTHING, PAD, SlopeRows};

/// Values of bins, of bin `i` at `i + PAD`.
///
/// Lines come in *groups*: those between two looks ahead, no more than a tile has. Of the lines that may hide a receiver each
/// bin knows the steepest, how steep the second is, and the groups that hold the others.
#[derive(Debug)]
pub(super) struct Bins {
    len: usize,
    /// No ray of the bin is obstructed above this slope, by any line that may hide a receiver.
    pub(super) upper: Vec<f32>,
    /// Every ray of the bin is obstructed up to this slope.
    pub(super) lower: Vec<f32>,
    /// The number of the line that `upper` is of, and the same bound by all other lines.
    pub(super) steepest_line: Vec<i32>,
    pub(super) second: Vec<f32>,
    /// No ray of the bin is obstructed above this slope by a line of the present group.
    pub(super) present: Vec<f32>,
    /// The bound by the lines of the steepest group before the present one, and the number of its first line.
    pub(super) steepest: Vec<f32>,
    pub(super) steepest_start: Vec<i32>,
    /// The bound by the lines of the steepest group of the rest, and the number of its first line.
    pub(super) next_steepest: Vec<f32>,
    pub(super) next_start: Vec<i32>,
    /// The bound by the lines of all other groups, and the first lines of the first and of the last of these that may hide a
    /// receiver from here on.
    pub(super) others: Vec<f32>,
    pub(super) first_other: Vec<i32>,
    pub(super) last_other: Vec<i32>,
}

impl Bins {
    /// Bins over which nothing passed yet.
    pub(super) fn new(len: usize) -> Self {
        let slopes = || vec![NOTHING; len + 2 * PAD];
        let numbers = || vec![0; len + 2 * PAD];
        Bins {
            len,
            upper: slopes(),
            lower: slopes(),
            second: slopes(),
            steepest_line: numbers(),
            present: slopes(),
            steepest: slopes(),
            steepest_start: numbers(),
            next_steepest: slopes(),
            next_start: numbers(),
            others: slopes(),
            first_other: numbers(),
            last_other: numbers(),
        }
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Makes two bins of each, which both know what it knew.
    pub(super) fn split(&mut self) {
        let Bins { len, .. } = *self;
        for slopes in [
            &mut self.upper,
            &mut self.lower,
            &mut self.second,
            &mut self.present,
            &mut self.steepest,
            &mut self.next_steepest,
            &mut self.others,
        ] {
            split(slopes, len, NOTHING);
        }
        for numbers in [
            &mut self.steepest_line,
            &mut self.steepest_start,
            &mut self.next_start,
            &mut self.first_other,
            &mut self.last_other,
        ] {
            split(numbers, len, 0);
        }
        self.len *= 2;
    }

    /// Gives the place after the last bin its bounds, for receivers on its farther edge.
    pub(super) fn repeat_last(&mut self) {
        let end = PAD + self.len;
        for bounds in [&mut self.upper, &mut self.lower] {
            bounds[end] = bounds[end - 1];
        }
    }

    /// The values of some bins that a line changes.
    #[inline(always)]
    pub(super) fn slopes_of(&mut self, bins: Range<usize>) -> SlopeRows<'_> {
        let at = bins.start + PAD..bins.end + PAD;
        SlopeRows {
            upper: &mut self.upper[at.clone()],
            lower: &mut self.lower[at.clone()],
            second: &mut self.second[at.clone()],
            steepest_line: &mut self.steepest_line[at.clone()],
            present: &mut self.present[at],
        }
    }

    /// The values of some bins, and of a vector of bins after them, that the end of a group changes.
    #[inline(always)]
    pub(super) fn groups_of(&mut self, bins: Range<usize>) -> GroupRows<'_> {
        // Vectors run over the end.
        let at = bins.start + PAD..bins.end + 2 * PAD;
        GroupRows {
            n_bins: bins.len(),
            lower: &self.lower[at.clone()],
            present: &mut self.present[at.clone()],
            steepest: &mut self.steepest[at.clone()],
            steepest_start: &mut self.steepest_start[at.clone()],
            next_steepest: &mut self.next_steepest[at.clone()],
            next_start: &mut self.next_start[at.clone()],
            others: &mut self.others[at.clone()],
            first_other: &mut self.first_other[at.clone()],
            last_other: &mut self.last_other[at],
        }
    }
}

/// Values of bins for bins of half their width.
fn split<T: Copy>(values: &mut Vec<T>, len: usize, padding: T) {
    values.resize(2 * len + 2 * PAD, padding);
    for i in (0..len).rev() {
        let value = values[PAD + i];
        values[PAD + 2 * i] = value;
        values[PAD + 2 * i + 1] = value;
    }
    values[PAD + 2 * len..].fill(padding);
}
