//! Elevation angles of the UAV as receivers see it, in bands of ten degrees.
//!
//! A receiver is in a band if the tangent of its angle is. Both sides of that comparison are
//! squared, so that no root is taken: `rise² ≥ tan² · distance²`. 64 cells are compared at a time,
//! from the flattest angle up, until none is as steep.

use fearless_simd::Level;
use fearless_simd::prelude::*;

use crate::dispatch;

use crate::los::GridReceivers;
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::GeoRef;

/// Bands from −90° to 90°.
pub(super) const N_BANDS: usize = 18;

/// tan² of 10°, 20° … 80°.
const SQUARED_TANGENTS: [f64; 8] = [
    0.031_091_204_125_763_38,
    0.132_474_331_431_794_24,
    1.0 / 3.0,
    0.704_088_191_041_847_3,
    1.420_276_625_461_206,
    3.0,
    7.548_632_170_413_03,
    32.163_437_477_526_36,
];

/// Receivers of a row, and the UAV that they see.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowElevations<'a> {
    /// World x of the columns, ascending, whole words of them \[CRS units\].
    pub(super) xs: &'a [f64],
    /// Number of columns.
    pub(super) n_cols: usize,
    /// Position of the UAV \[CRS units\] and its height \[1/1024 m\].
    pub(super) uav: (f64, f64, i64),
    /// World y of the row \[CRS units\].
    pub(super) y: f64,
    /// Length of a CRS unit \[m\].
    pub(super) meters_per_unit: f64,
    /// The receivers, and the index of the row's first cell among them.
    pub(super) receivers: &'a GridReceivers<'a>,
    pub(super) first_cell: usize,
}

/// Returns the world x of the columns of a grid, padded to whole words of them \[CRS units\].
pub(super) fn padded_xs(grid: &GeoRef) -> Vec<f64> {
    let n_cols = grid.n_cols();
    let mut xs: Vec<f64> = (0..n_cols).map(|col| grid.world_from_cell(0, col).0).collect();
    xs.resize(n_cols.div_ceil(64) * 64, 0.0);
    xs
}

impl RowElevations<'_> {
    /// Calls `add(band, receivers, los)` with counts of each band that holds a receiver.
    pub(super) fn count(&self, receivers: &[u64], los: &[u64], add: &mut impl FnMut(usize, u64, u64)) {
        dispatch!(Level::new(), simd => self.count_with(simd, receivers, los, add));
    }

    /// Returns the square of the distance of a column \[m²\].
    #[inline(always)]
    fn squared_distance(&self, x: f64) -> f64 {
        let (dx, dy) = (self.uav.0 - x, self.uav.1 - self.y);
        (dx * dx + dy * dy) * (self.meters_per_unit * self.meters_per_unit)
    }

    /// Returns the least squared distance of columns `first..end` \[m²\].
    fn nearest_distance(&self, first: usize, end: usize) -> f64 {
        self.squared_distance(self.uav.0.clamp(self.xs[first], self.xs[end - 1]))
    }

    /// Returns the number of tangents that the columns `first..end` are as steep as, for receivers of
    /// one squared rise \[m²\]. There is none if the nearest column is as steep as more than the
    /// farthest is.
    fn band_of_all(&self, first: usize, end: usize, squared: f64, is_below: bool) -> Option<usize> {
        let steps = |distance: f64| {
            let is_steep = |limit: f64| if is_below { squared > limit } else { squared >= limit };
            SQUARED_TANGENTS.iter().take_while(|tangent| is_steep(**tangent * distance)).count()
        };
        let [from, to] = [first, end - 1].map(|col| self.squared_distance(self.xs[col]));
        let of_all = steps(from.max(to));
        (of_all == steps(self.nearest_distance(first, end))).then_some(of_all)
    }

    #[inline(always)]
    fn count_with<S: Simd>(&self, simd: S, receivers: &[u64], los: &[u64], add: &mut impl FnMut(usize, u64, u64)) {
        let n = S::f64s::LEN;
        let (uav_x, uav_dy) = (S::f64s::splat(simd, self.uav.0), self.uav.1 - self.y);
        let squared_dy = S::f64s::splat(simd, uav_dy * uav_dy);
        let unit = S::f64s::splat(simd, self.meters_per_unit * self.meters_per_unit);
        let mut counts = [(0_u64, 0_u64); N_BANDS];
        let ((lowest, highest), above) = self.receivers.range();
        let uav_above = i32::try_from(self.uav.2 - i64::from(above)).unwrap_or(i32::MAX);
        let rise_over = |base: i32| in_meters(i64::from(uav_above) - i64::from(base));
        let (least, most) = (rise_over(highest), rise_over(lowest));
        let none_above_uav = least >= 0.0;
        // PERF: far from the UAV all receivers, whatever their heights, see it less than 10° above
        // or below the horizon. Each operation here rounds as below, and none of them turns an
        // order around.
        let steepest = (least * least).max(most * most);
        let is_flat = |first: usize, end: usize| steepest < SQUARED_TANGENTS[0] * self.nearest_distance(first, end);
        let is_row_flat = is_flat(0, self.n_cols);
        if is_row_flat && none_above_uav {
            let sum = |words: &[u64]| words.iter().map(|word| u64::from(word.count_ones())).sum();
            add(band(false, 0), sum(receivers), sum(los));
            return;
        }
        let uav_above_of_lanes = S::i32s::splat(simd, uav_above);
        // PERF: receivers at one height, as over flat ground, have one rise.
        let are_level = lowest == highest;
        let mut below = if none_above_uav { 0 } else { !0 };
        let mut squared = [least * least; 64];
        for (k, (receivers, los)) in receivers.iter().zip(los).enumerate().filter(|(_, (r, _))| **r != 0) {
            let mut count = |is_below: bool, steps: usize, set: u64| {
                let count = &mut counts[band(is_below, steps)];
                count.0 += u64::from((receivers & set).count_ones());
                count.1 += u64::from((los & set).count_ones());
            };
            let (first, n_here) = (self.first_cell + 64 * k, (self.n_cols - 64 * k).min(64));
            let is_flat = is_row_flat || is_flat(64 * k, 64 * k + n_here);
            if is_flat && none_above_uav {
                count(false, 0, !0);
                continue;
            }
            let one_band = || self.band_of_all(64 * k, 64 * k + n_here, steepest, !none_above_uav);
            if let Some(steps) = are_level.then(one_band).flatten() {
                count(!none_above_uav, steps, !0);
                continue;
            }
            // How far the UAV is above the receivers \[1/1024 m\]; cells without a receiver may
            // hold anything.
            let mut rises = [0; 64];
            if !are_level {
                self.receivers.copy_bases(first, &mut rises[..n_here]);
                below = 0;
                for i in (0..64).step_by(S::i32s::LEN) {
                    let rise = uav_above_of_lanes - S::i32s::from_slice(simd, &rises[i..i + S::i32s::LEN]);
                    rise.store_slice(&mut rises[i..i + S::i32s::LEN]);
                    below |= rise.simd_lt(0).to_bitmask() << i;
                }
            }
            if is_flat {
                count(false, 0, !below);
                count(true, 0, below);
                continue;
            }
            if !are_level {
                for (squared, rise) in squared.iter_mut().zip(&rises) {
                    let rise = f64::from(*rise) / f64::from(STEPS_PER_UNIT);
                    *squared = rise * rise;
                }
            }
            let mut distances = [0.0; 64];
            let xs = &self.xs[64 * k..64 * k + 64];
            for i in (0..64).step_by(n) {
                let dx = uav_x - S::f64s::from_slice(simd, &xs[i..i + n]);
                ((dx * dx + squared_dy) * unit).store_slice(&mut distances[i..i + n]);
            }
            for (is_below, side) in [(false, receivers & !below), (true, receivers & below)] {
                count_steps(simd, (&squared, &distances), (is_below, side), |steps, set| count(is_below, steps, set));
            }
        }
        for (band, (receivers, los)) in counts.into_iter().enumerate().filter(|(_, c)| c.0 > 0) {
            add(band, receivers, los);
        }
    }
}

/// Calls `count(steps, cells)` with the cells of a word that are at least as steep as so many
/// tangents and less steep than the next, by squared rises and distances \[m²\].
#[inline(always)]
fn count_steps<S: Simd>(
    simd: S,
    (squared, distances): (&[f64; 64], &[f64; 64]),
    (is_below, cells): (bool, u64),
    mut count: impl FnMut(usize, u64),
) {
    let mut outer = cells;
    for (steps, tangent) in SQUARED_TANGENTS.iter().enumerate() {
        if outer == 0 {
            return;
        }
        let tangent = S::f64s::splat(simd, *tangent);
        let mut steep = 0_u64;
        for i in (0..64).step_by(S::f64s::LEN) {
            let squared = S::f64s::from_slice(simd, &squared[i..i + S::f64s::LEN]);
            let limit = tangent * S::f64s::from_slice(simd, &distances[i..i + S::f64s::LEN]);
            let is_steep = if is_below { squared.simd_gt(limit) } else { squared.simd_ge(limit) };
            steep |= is_steep.to_bitmask() << i;
        }
        count(steps, outer & !steep);
        outer &= steep;
    }
    count(SQUARED_TANGENTS.len(), outer);
}

#[inline(always)]
fn in_meters(steps: i64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "heights differ by at most 2^28 steps")]
    let meters = steps as f64 / f64::from(STEPS_PER_UNIT);
    meters
}

/// Returns the band of an angle that is at least as steep as so many of the tangents. Below the
/// horizon a band's lower end is included: −10° belongs to −10…0.
#[inline(always)]
fn band(is_below: bool, steps: usize) -> usize {
    if is_below { 8 - steps } else { 9 + steps }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_field::StandsOn;
    use crate::raster::BitGrid;

    #[test]
    fn squared_tangents_are_those_of_the_band_edges() {
        for (k, t) in SQUARED_TANGENTS.iter().enumerate() {
            let tangent = (10.0 * (k as f64 + 1.0)).to_radians().tan();
            assert!((t / (tangent * tangent) - 1.0).abs() < 1e-14, "{k}: {t}");
        }
    }

    /// Counts by band of one row, by a division and an arc tangent for each cell.
    fn by_angles(row: &RowElevations<'_>, receivers: &BitGrid, los: &BitGrid) -> [(u64, u64); N_BANDS] {
        let mut counts = [(0, 0); N_BANDS];
        for col in (0..row.n_cols).filter(|col| receivers.contains(0, *col)) {
            let rise = in_meters(row.uav.2 - row.receivers.height(col));
            let angle = rise.atan2(row.squared_distance(row.xs[col]).sqrt()).to_degrees();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small whole number")]
            let band = (9.0 + (angle / 10.0).floor()).clamp(0.0, 17.0) as usize;
            counts[band].0 += 1;
            counts[band].1 += u64::from(los.contains(0, col));
        }
        counts
    }

    fn counted(row: &RowElevations<'_>, receivers: &BitGrid, los: &BitGrid) -> [(u64, u64); N_BANDS] {
        let mut found = [(0, 0); N_BANDS];
        row.count(receivers.row(0), los.row(0), &mut |band, receivers, los| {
            found[band].0 += receivers;
            found[band].1 += los;
        });
        found
    }

    #[test]
    fn ninety_degrees_are_in_the_last_band_and_the_horizon_in_the_first_above_it() {
        let one = BitGrid::full(1, 1);
        let receivers = GridReceivers::new(&one, StandsOn::Flat(0), 0);
        for (x, z, band) in [(0.0, 1024, 17), (0.0, -1024, 0), (1.0, 0, 9), (1.0, 1024, 13), (1.0, -1, 8)] {
            let (uav, xs) = ((x, 0.0, z), &[0.0; 64]);
            let row = RowElevations {
                xs,
                n_cols: 1,
                uav,
                y: 0.0,
                meters_per_unit: 1.0,
                receivers: &receivers,
                first_cell: 0,
            };
            assert_eq!(counted(&row, &one, &one)[band], (1, 1), "{x}, {z}");
        }
    }

    #[test]
    fn rows_are_counted_as_by_angles_one_by_one() {
        let n_cols = 333;
        let (mut receivers, mut los) = (BitGrid::new(1, n_cols), BitGrid::new(1, n_cols));
        for col in 0..n_cols {
            if col % 7 != 3 {
                receivers.insert(0, col);
                if col % 3 == 1 {
                    los.insert(0, col);
                }
            }
        }
        let relief: Vec<i32> = (0..333).map(|col| (col * 7919 % 977) * 150).collect();
        let all = [
            GridReceivers::new(receivers.clone(), StandsOn::Flat(0), 1536),
            GridReceivers::new(receivers.clone(), StandsOn::Cells(relief.into()), 1536),
        ];
        let mut xs: Vec<f64> = (0..n_cols).map(|col| 1000.25 + 0.7 * col as f64).collect();
        xs.resize(n_cols.div_ceil(64) * 64, 0.0);
        let mut n = 0;
        for receivers_on in &all {
            for z in [-60 * 1024, 2 * 1024, 30 * 1024, 70 * 1024, 100 * 1024, 150 * 1024, 3000 * 1024_i64] {
                let near = [(1100.3, 7.1), (1000.0, 140.0), (900.0, 0.33), (1117.07, 5.0)];
                // From the first two some words of receivers are less than 10° from the horizon,
                // with all of them below a UAV at 150 m, and on both sides of one at 70 m; from the
                // last whole rows are.
                let far = [(150.0, 5.0), (650.0, 5.0), (-900.0, 5.0)];
                for (x, y) in near.into_iter().chain(far) {
                    let row = RowElevations {
                        xs: &xs,
                        n_cols,
                        uav: (x, y, z),
                        y: 5.017,
                        meters_per_unit: 0.9,
                        receivers: receivers_on,
                        first_cell: 0,
                    };
                    assert_eq!(
                        counted(&row, &receivers, &los),
                        by_angles(&row, &receivers, &los),
                        "UAV at {x}, {y}, {z}"
                    );
                    n += 1;
                }
            }
        }
        assert_eq!(n, 98);
    }
}
