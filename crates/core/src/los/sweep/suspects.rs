//! The lines that may hide a receiver which the bounds leave undecided.

use super::bins::Bins;
use super::kernels::PAD;
use super::quadrants::{CELL, as_i64};
use super::receivers::ReceiverMap;
use crate::height_field::TILE;

/// What the bins of a wedge suspect of hiding the receivers of one line. Lines are counted back from that line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Suspects<'a> {
    pub(super) bins: &'a Bins,
    /// The first bin, and the last one that a receiver may be given.
    pub(super) first_bin: i64,
    pub(super) last_bin: i64,
    pub(super) map: ReceiverMap,
    /// One over the distance of the receivers.
    pub(super) per_distance: f32,
    /// The numbers of the receivers' line and of the first line of the present group.
    pub(super) number: i32,
    pub(super) group_start: i32,
    /// The words of the first and of the last receiver of the wedge in the line.
    pub(super) ends: (i64, i64),
}

/// Some lines, from the farthest back to the nearest.
pub(super) type Lines = (i64, i64);

/// What is known of a receiver.
#[derive(Debug, Clone, Copy)]
pub(super) struct Suspected<'a> {
    suspects: &'a Suspects<'a>,
    /// Its azimuth \[2^-36\], where the values of its bin are, and its slope.
    azimuth: i64,
    bin: usize,
    slope: f32,
}

impl<'a> Suspects<'a> {
    /// Whether a word of 64 receivers may hold some of another wedge.
    #[inline(always)]
    pub(super) fn is_shared(&self, word: usize) -> bool {
        as_i64(word) <= self.ends.0 || as_i64(word) >= self.ends.1
    }

    /// What is known of the receiver of lateral cell `c`, which is `z` above the UAV \[1/1024 m\].
    #[inline(always)]
    pub(super) fn of(&'a self, c: i64, z: i64) -> Suspected<'a> {
        let bin = self.map.bin(c).min(self.last_bin) - self.first_bin;
        #[expect(clippy::cast_precision_loss, reason = "rounded as where it was compared with the bounds")]
        let slope = z as f32 * self.per_distance;
        Suspected { suspects: self, azimuth: self.map.azimuth(c), bin: usize::try_from(bin).unwrap_or(0) + PAD, slope }
    }

    /// A line by its number.
    #[inline(always)]
    fn back(&self, number: i32) -> i64 {
        i64::from(self.number) - i64::from(number)
    }

    /// The lines of some groups, given the numbers of the first lines of the first and of the last one.
    #[inline(always)]
    fn groups(&self, first: i32, last: i32) -> Lines {
        // A group has no more lines than a tile, all of them before the receivers' own.
        (self.back(first), (self.back(last) - as_i64(TILE) + 1).max(1))
    }
}

impl Suspected<'_> {
    /// The azimuth of its ray \[2^-36\], off by less than a lattice step at its distance.
    #[inline(always)]
    pub(super) fn azimuth(&self) -> i64 {
        self.azimuth
    }

    /// The steepest line.
    #[inline(always)]
    pub(super) fn steepest_line(&self) -> i64 {
        self.suspects.back(self.suspects.bins.steepest_line[self.bin])
    }

    /// Whether no other line can hide the receiver.
    #[inline(always)]
    pub(super) fn is_steepest_alone(&self) -> bool {
        self.slope > self.suspects.bins.second[self.bin]
    }

    /// All lines that may hide the receiver: those of the present group and of the two steepest ones before it, the steepest of
    /// the three foremost, and those of other groups with all between.
    #[inline(always)]
    pub(super) fn lines(&self) -> ([Option<Lines>; 3], Option<Lines>) {
        let (Suspects { bins, .. }, i) = (self.suspects, self.bin);
        let group = |steepest: f32, start: i32| (steepest >= self.slope).then(|| self.suspects.groups(start, start));
        let present = group(bins.present[i], self.suspects.group_start);
        let before = group(bins.steepest[i], bins.steepest_start[i]);
        let next = group(bins.next_steepest[i], bins.next_start[i]);
        let groups = if bins.present[i] > bins.steepest[i] { [present, before, next] } else { [before, present, next] };
        let is_suspect = bins.others[i] >= self.slope;
        (groups, is_suspect.then(|| self.suspects.groups(bins.first_other[i], bins.last_other[i])))
    }

    /// From the first to the last of all lines that may hide the receiver.
    pub(super) fn range(&self) -> Option<Lines> {
        let (groups, others) = self.lines();
        groups.into_iter().chain([others]).flatten().reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))
    }
}

/// How far some lines are, counted back from the one whose farther edge is at `far` \[lattice steps from the UAV\].
#[inline(always)]
pub(super) fn edges_of(far: i64, (first, last): Lines) -> (i64, i64) {
    ((far - (first + 1) * CELL).max(0), far - last * CELL)
}
