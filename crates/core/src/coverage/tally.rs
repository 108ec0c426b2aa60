//! Counts over a mask: receivers, those in line of sight, and the same by elevation angle.

use super::cell_classes::RowSets;
use super::class;
use super::elevation::{N_BANDS, RowElevations};
use super::uav::{HoversOver, Uav};
use crate::quantity::share;

/// Width of an elevation band \[deg\].
pub const BAND_DEGREES: i32 = 10;

/// Receivers whose elevation angle to the UAV lies in `from_deg ≤ θ < to_deg` (90° in the last
/// band).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ElevationBand {
    /// Lower end \[deg\].
    pub from_deg: i32,
    /// Upper end \[deg\].
    pub to_deg: i32,
    /// Receivers in the band.
    pub receivers: u64,
    /// Of these, in line of sight.
    pub los: u64,
}

/// Counts of one map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Receivers in range: classes 0 and 1.
    pub receivers: u64,
    /// Receivers in line of sight: class 1.
    pub los: u64,
    /// Cells of class 2.
    pub not_receivers: u64,
    /// Cells of class 3.
    pub out_of_range: u64,
    /// Cells of class 255.
    pub nodata: u64,
    /// A UAV is over no data, so that there is no P_LoS.
    pub is_over_nodata: bool,
    bands: [(u64, u64); N_BANDS],
}

impl Tally {
    /// Counts the cells of a row that hold no receiver in range.
    pub(super) fn add_others(&mut self, row: &RowSets<'_>, n_cols: usize) {
        let mut known = 0;
        for word in row.words() {
            let count = |set: u64| u64::from(set.count_ones());
            self.not_receivers += count(word.not_receivers);
            self.out_of_range += count(word.out_of_range);
            known += count(word.not_receivers | word.out_of_range | word.receivers);
        }
        self.nodata += n_cols as u64 - known;
    }

    /// Counts receivers of a row, and those of them in line of sight, by elevation band.
    pub(super) fn add_receivers(&mut self, elevations: &RowElevations<'_>, receivers: &[u64], los: &[u64]) {
        let sum = |words: &[u64]| words.iter().map(|w| u64::from(w.count_ones())).sum::<u64>();
        let (n_receivers, n_los) = (sum(receivers), sum(los));
        if n_receivers == 0 {
            return;
        }
        self.receivers += n_receivers;
        self.los += n_los;
        elevations.count(receivers, los, &mut |band, receivers, los| {
            self.bands[band].0 += receivers;
            self.bands[band].1 += los;
        });
    }

    /// Counts of receivers alone.
    pub fn of_receivers(receivers: u64, los: u64) -> Self {
        Tally { receivers, los, ..Tally::default() }
    }

    /// Returns these counts, of a UAV that may be over no data.
    #[must_use]
    pub fn of_uav(self, uav: &Uav) -> Self {
        Tally { is_over_nodata: self.is_over_nodata || uav.placement == HoversOver::Nodata, ..self }
    }

    /// Counts a mask, without elevation bands.
    pub fn of_mask(mask: &[u8]) -> Self {
        let mut counts = [0_u64; 256];
        mask.iter().for_each(|class| counts[usize::from(*class)] += 1);
        Tally::of_counts(&counts)
    }

    /// Returns these receivers, with the other cells of a mask.
    pub(super) fn with_others_of(self, mask: &[u8]) -> Self {
        let Tally { receivers, los, bands, is_over_nodata, .. } = self;
        Tally { receivers, los, bands, is_over_nodata, ..Tally::of_mask(mask) }
    }

    fn of_counts(counts: &[u64; 256]) -> Self {
        let of = |class: u8| counts[usize::from(class)];
        Tally {
            receivers: of(class::NLOS) + of(class::LOS),
            los: of(class::LOS),
            not_receivers: of(class::NOT_A_RECEIVER),
            out_of_range: of(class::OUT_OF_RANGE),
            nodata: of(class::NODATA),
            ..Tally::default()
        }
    }

    /// Counts a mask by group: the cells whose entry in `groups` is k count in tally k. Without
    /// elevation bands.
    pub fn by_group<const N: usize>(mask: &[u8], groups: &[u8]) -> [Tally; N] {
        let mut counts = [[0_u64; 256]; N];
        mask.iter().zip(groups).for_each(|(class, group)| counts[usize::from(*group)][usize::from(*class)] += 1);
        counts.map(|counts| Tally::of_counts(&counts))
    }

    /// Returns the sum of two tallies of disjoint cells.
    #[must_use]
    pub fn plus(mut self, other: &Tally) -> Self {
        self.receivers += other.receivers;
        self.los += other.los;
        self.not_receivers += other.not_receivers;
        self.out_of_range += other.out_of_range;
        self.nodata += other.nodata;
        self.is_over_nodata |= other.is_over_nodata;
        for (a, b) in self.bands.iter_mut().zip(&other.bands) {
            a.0 += b.0;
            a.1 += b.1;
        }
        self
    }

    /// Returns P_LoS: the share of receivers in line of sight, `None` without a receiver and of a
    /// UAV over no data.
    pub fn p_los(&self) -> Option<f64> {
        share(self.los, self.receivers).filter(|_| !self.is_over_nodata)
    }

    /// Returns why there is no P_LoS.
    pub fn reason(&self) -> &'static str {
        if self.receivers > 0 {
            "the UAV is over no data"
        } else if self.out_of_range > 0 && self.not_receivers == 0 && self.nodata == 0 {
            "no receiver in range"
        } else if self.not_receivers > 0 {
            "every cell in range is a building or outside the chosen receivers"
        } else {
            "no cell with known heights in range"
        }
    }

    /// Returns the bands from the lowest that holds a receiver, or from 0° where that is lower, up
    /// to 90°; empty ones too.
    pub fn elevation_bands(&self) -> Vec<ElevationBand> {
        let horizon = N_BANDS / 2;
        let lowest = self.bands.iter().position(|(receivers, _)| *receivers > 0).unwrap_or(horizon);
        (lowest.min(horizon)..N_BANDS)
            .filter_map(|k| {
                let from_deg = i32::try_from(k).ok()? * BAND_DEGREES - 90;
                let (receivers, los) = self.bands[k];
                Some(ElevationBand { from_deg, to_deg: from_deg + BAND_DEGREES, receivers, los })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_have_no_gap_from_the_lowest_with_a_receiver_up() {
        let from = |tally: &Tally| tally.elevation_bands().iter().map(|b| b.from_deg).collect::<Vec<_>>();
        let mut tally = Tally::default();
        assert_eq!(from(&tally), [0, 10, 20, 30, 40, 50, 60, 70, 80]);
        // A receiver 35° below the horizon of the UAV and one 15°: nobody between them.
        (tally.bands[5], tally.bands[7]) = ((3, 1), (1, 1));
        assert_eq!(from(&tally), [-40, -30, -20, -10, 0, 10, 20, 30, 40, 50, 60, 70, 80]);
        let empty = tally.elevation_bands()[1];
        assert_eq!((empty.to_deg, empty.receivers, empty.los), (-20, 0, 0));
    }
}
