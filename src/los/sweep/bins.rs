//! What the bins of a wedge know of the lines that passed over them.

use std::ops::Range;

use super::kernels::{GroupRows, NOTHING, PAD, SlopeRows};

/// Values of bins, of bin `i` at `i + PAD`.
///
/// Lines count in *groups*: those between two looks ahead, at most a tile of them. For each bin the steepest line is known
/// of the present group, of the steepest group before it, and of all other groups; and, instead of the lines that may hide
/// a receiver, the groups that hold them.
#[derive(Debug)]
pub(super) struct Bins {
    len: usize,
    /// No ray of the bin is obstructed above this slope, by any line.
    pub(super) upper: Vec<f32>,
    /// Every ray of the bin is obstructed up to this slope.
    pub(super) lower: Vec<f32>,
    /// As `upper`, by all lines but that one.
    pub(super) second: Vec<f32>,
    /// The number of the line that `upper` is of.
    pub(super) steepest_line: Vec<i32>,
    /// As `upper`, by the lines of the present group alone.
    pub(super) present: Vec<f32>,
    /// As `upper`, by the lines of the steepest group before the present one, and the number of its first line.
    pub(super) steepest: Vec<f32>,
    pub(super) steepest_start: Vec<i32>,
    /// As `upper`, by the lines of all other groups.
    pub(super) others: Vec<f32>,
    /// Of those among the others that may hide a receiver from here on, the first lines of the first and of the last one.
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
        let Bins { len, upper, second, lower, steepest_line, present, steepest, steepest_start, others, first_other, last_other } =
            self;
        for slopes in [upper, second, lower, present, steepest, others] {
            *slopes = split(slopes, *len, NOTHING);
        }
        for numbers in [steepest_line, steepest_start, first_other, last_other] {
            *numbers = split(numbers, *len, 0);
        }
        *len *= 2;
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
            others: &mut self.others[at.clone()],
            first_other: &mut self.first_other[at.clone()],
            last_other: &mut self.last_other[at],
        }
    }
}

/// Values of bins for bins of half their width.
fn split<T: Copy>(values: &[T], len: usize, padding: T) -> Vec<T> {
    let mut finer = vec![padding; 2 * len + 2 * PAD];
    for (i, value) in values[PAD..PAD + len].iter().enumerate() {
        finer[PAD + 2 * i] = *value;
        finer[PAD + 2 * i + 1] = *value;
    }
    finer
}
