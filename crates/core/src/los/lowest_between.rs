//! Rays over a curved earth whose lowest point is between their ends.

use rayon::prelude::*;

use super::{GridReceivers, ShadowScene};
use crate::height_field::CurvedGround;
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, set_bits};

/// Returns the wanted cells whose rays over a curved earth have their lowest point between the
/// ends; `None` if there are none. Other rays fall or rise all the way.
pub(super) fn with_lowest_place_between(
    scene: &ShadowScene<'_>,
    earth: CurvedGround,
    uav: LatticePoint,
    receivers: &GridReceivers<'_>,
) -> Option<BitGrid> {
    // The square of the distance up to which no ray is such, narrowed by more than it can err.
    let reach = |z: i64| {
        #[expect(clippy::cast_precision_loss, reason = "a difference of heights, at most 2^28")]
        let apart = (uav.z - z) as f64;
        apart.abs() / earth.bulge.coefficient() * (1.0 - 1e-9)
    };
    #[expect(clippy::cast_precision_loss, reason = "squares of lengths are below 2^56")]
    let squares = |of: &[i64], at: i64| of.iter().map(|v| ((v - at) * (v - at)) as f64).collect::<Vec<f64>>();
    let (east, north) = (squares(&scene.grid.xs, uav.x), squares(&scene.grid.ys, uav.y));
    let most = |of: &[f64]| of.iter().fold(0.0_f64, |most, square| most.max(*square));
    let (lowest, highest) = receivers.heights_range();
    let farthest = most(&east) + most(&north);
    if (highest < uav.z && farthest < reach(highest)) || (lowest > uav.z && farthest < reach(lowest)) {
        return None;
    }
    let n_cols = east.len();
    let mut between = BitGrid::new(north.len(), n_cols);
    let per_row = between.words_per_row();
    between.words_mut().par_chunks_mut(per_row.max(1)).enumerate().for_each(|(row, words)| {
        for col in set_bits(scene.wanted.row(row)) {
            let is_between = east[col] + north[row] >= reach(receivers.height(row * n_cols + col));
            words[col / 64] |= u64::from(is_between) << (col % 64);
        }
    });
    (between.count() > 0).then_some(between)
}
