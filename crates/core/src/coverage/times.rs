//! Coverage over time: UAVs that come and go over one scene.

use rayon::prelude::*;

use super::{Uav, class};

/// Span of time that a map tells about \[s\], and what it tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeSpan {
    /// First and last moment.
    pub ends_s: [f64; 2],
    /// `true` if receivers are counted between the moments at which UAVs come or go.
    pub counts: bool,
}

/// Receivers between two moments at which UAVs come or go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeCount {
    /// First moment, included \[s\].
    pub from_s: f64,
    /// Last moment, excluded \[s\].
    pub to_s: f64,
    /// Receivers in range of a UAV that is up.
    pub receivers: u64,
    /// Receivers in line of sight of one.
    pub los: u64,
}

/// Masks of UAVs that are up for a while, laid over each other: for each cell the stretches of time in which
/// some UAV sees it.
#[derive(Debug, Clone)]
pub struct Times {
    /// Moments at which a UAV comes or goes, in order, with both ends of the span \[s\].
    moments_s: Vec<f64>,
    /// Stretches in which cells are seen: layers of one number a cell, whose bits are 32 stretches each.
    seen: Vec<Vec<u32>>,
    /// Stretches in which cells are receivers in range, alike, if these are counted.
    received: Vec<Vec<u32>>,
}

impl Times {
    /// Returns the times of some UAVs over so many cells, which nobody sees so far.
    pub(super) fn of(span: TimeSpan, uavs: &[Uav], n_cells: usize) -> Times {
        let [first, last] = span.ends_s;
        let moments = uavs.iter().filter_map(|uav| uav.up).flat_map(|up| [up.from_s, up.to_s]);
        let mut moments_s: Vec<f64> = moments.chain([first, last]).map(|s| s.clamp(first, last)).collect();
        moments_s.sort_by(f64::total_cmp);
        moments_s.dedup();
        let n_words = (moments_s.len() - 1).div_ceil(32);
        let none = |is_wanted: bool| vec![vec![0; n_cells]; if is_wanted { n_words } else { 0 }];
        Times { moments_s, seen: none(true), received: none(span.counts) }
    }

    /// Adds the mask of one UAV.
    pub(super) fn add(&mut self, uav: &Uav, mask: &[u8]) {
        let moments = &self.moments_s;
        let before = |s: f64| moments.partition_point(|moment| *moment < s);
        let last = moments.len() - 1;
        let stretches = uav.up.map_or((0, last), |up| (before(up.from_s).min(last), before(up.to_s).min(last)));
        let words = self.seen.iter_mut().enumerate();
        words.for_each(|(k, word)| set_bits_where(word, bits_of_word(stretches, k), mask, |c| c == class::LOS));
        let words = self.received.iter_mut().enumerate();
        let is_receiver = |c| matches!(c, class::LOS | class::NLOS);
        words.for_each(|(k, word)| set_bits_where(word, bits_of_word(stretches, k), mask, is_receiver));
    }

    /// Returns the share of the span in which each cell is seen, 0 to 1.
    pub(super) fn uptime(&self) -> Vec<f32> {
        let whole = self.length_s(0, self.moments_s.len() - 1);
        #[expect(clippy::cast_possible_truncation, reason = "a layer of f32")]
        self.of_cells(|cell| {
            let seen = (0..self.moments_s.len() - 1).filter(|k| self.sees(cell, *k));
            (seen.fold(0.0, |sum, k| sum + self.length_s(k, k + 1)) / whole) as f32
        })
    }

    /// Returns the longest time in which each cell is not seen \[min\].
    pub(super) fn gap(&self) -> Vec<f32> {
        let last = self.moments_s.len() - 1;
        #[expect(clippy::cast_possible_truncation, reason = "a layer of f32")]
        self.of_cells(|cell| {
            let (mut longest_s, mut begin) = (0.0_f64, 0);
            for k in 0..=last {
                if k == last || self.sees(cell, k) {
                    longest_s = longest_s.max(self.length_s(begin, k));
                    begin = k + 1;
                }
            }
            (longest_s / 60.0) as f32
        })
    }

    /// Returns the counts of receivers between moments, in order; none if they are not wanted.
    pub fn counts(&self) -> Vec<TimeCount> {
        let count = |words: &[Vec<u32>], k: usize| {
            words[k / 32].par_iter().filter(|word| **word >> (k % 32) & 1 == 1).count() as u64
        };
        let n = if self.received.is_empty() { 0 } else { self.moments_s.len() - 1 };
        let between = |k: usize| TimeCount {
            from_s: self.moments_s[k],
            to_s: self.moments_s[k + 1],
            receivers: count(&self.received, k),
            los: count(&self.seen, k),
        };
        (0..n).map(between).collect()
    }

    /// Returns whether a cell is seen between one moment and the next.
    fn sees(&self, cell: usize, k: usize) -> bool {
        self.seen[k / 32][cell] >> (k % 32) & 1 == 1
    }

    /// Returns the time from one moment to another, 0 where it is before it.
    fn length_s(&self, from: usize, to: usize) -> f64 {
        if from < to { self.moments_s[to] - self.moments_s[from] } else { 0.0 }
    }

    fn of_cells(&self, of: impl Fn(usize) -> f32 + Sync + Send) -> Vec<f32> {
        (0..self.seen[0].len()).into_par_iter().map(of).collect()
    }
}

/// Returns the bits of some stretches, from the first to before the last, in the `k`-th number of 32.
fn bits_of_word((from, to): (usize, usize), k: usize) -> u32 {
    let bits_below = |n: usize| match n.saturating_sub(32 * k) {
        0..32 => (1_u32 << n.saturating_sub(32 * k)) - 1,
        _ => u32::MAX,
    };
    bits_below(to) & !bits_below(from)
}

/// Sets bits in the numbers of cells of some classes.
fn set_bits_where(words: &mut [u32], bits: u32, mask: &[u8], is_one: impl Fn(u8) -> bool + Sync) {
    if bits != 0 {
        let cells = words.par_iter_mut().zip(mask).filter(|(_, class)| is_one(**class));
        cells.for_each(|(word, _)| *word |= bits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_those_of_stretches() {
        for (from, to) in [(0, 0), (0, 1), (3, 7), (0, 32), (31, 33), (32, 64), (5, 90), (64, 65)] {
            let bits: Vec<u32> = (0..3).map(|k| bits_of_word((from, to), k)).collect();
            for n in 0..96 {
                assert_eq!(bits[n / 32] >> (n % 32) & 1 == 1, (from..to).contains(&n), "{from} {to} {n}");
            }
        }
    }
}
