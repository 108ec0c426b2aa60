//! The casters of a scene that cast shadows for a UAV, the begin of their shadows, and their order.

use std::ops::Range;

use super::geometry::{FULL_TURN, as_f64, bearing, distance_squared};
use super::horizon::sort_by_horizon;
use super::plane::Plane;
use crate::height_field::{Caster, CasterBlock, Casters};
use crate::quantity::LatticePoint;

/// Sectors around the UAV that are processed one after the other.
const SECTORS: f64 = 64.0;

/// Average length of shadows \[rows\] from which on the horizon takes less time than it saves.
const LONG: f64 = 200.0;

/// The casters that may hide some receivers, in the order in which they are cast: blocks by their
/// distance from the UAV, one sector after the other.
///
/// PERF: shadows of one sector lie together, so that their bits stay in the cache.
pub(super) struct Cast<'a> {
    all: &'a Casters,
    blocks: Vec<CastBlock>,
    /// Block by block, highest first: the number of a caster, and the begin of its shadow.
    begun: Vec<(u32, f64)>,
}

/// Neighboring casters.
pub(super) struct CastBlock {
    begun: Range<usize>,
    /// Bounding box of them all \[lattice steps\]: west, south, east, north.
    pub(super) bounds: [i32; 4],
    /// The highest top \[1/1024 m above the datum\].
    pub(super) max_top: i32,
    /// The least begin of their shadows.
    pub(super) begin: f64,
}

impl<'a> Cast<'a> {
    /// Selects from `all` the casters that may hide wanted receivers between two heights from the
    /// UAV of a plane. If these receivers are all below it, casters that the horizon hides are left
    /// out.
    pub(super) fn new(all: &'a Casters, plane: &Plane, (lowest, highest): (i64, i64)) -> Self {
        let uav = plane.uav;
        // A caster that hides a receiver has a shadow there, so blocks without a shadow on
        // receivers hide none of the other blocks either.
        let is_in_view =
            |block: &&CasterBlock| plane.meets(block.bounds, plane.reach(block.bounds, block.max_top, lowest));
        let mut in_view: Vec<&CasterBlock> = all.blocks().iter().filter(is_in_view).collect();
        in_view.sort_by_cached_key(|block| outward(block, uav));
        let numbers: Vec<u32> = in_view.iter().flat_map(|block| block.numbers()).collect();
        let caster = |k: u32| &all.all()[k as usize];
        let begins = if highest < uav.z && are_long(&in_view, plane, lowest) {
            let prisms = numbers.iter().map(|k| (all.ring(caster(*k)), all.range(caster(*k))));
            sort_by_horizon((uav, plane.curve), highest, prisms, std::iter::empty::<([[i32; 2]; 0], i64)>()).prisms
        } else {
            vec![Some(1.0); numbers.len()]
        };
        let mut begun = numbers.into_iter().zip(begins);
        let mut cast = Cast { all, blocks: Vec::with_capacity(in_view.len()), begun: Vec::new() };
        for block in in_view {
            let first = cast.begun.len();
            let mut bounds = [i32::MAX, i32::MAX, i32::MIN, i32::MIN];
            let (mut max_top, mut least) = (i32::MIN, f64::INFINITY);
            for (k, begin) in begun.by_ref().take(block.numbers().len()) {
                let Some(begin) = begin else { continue };
                let Caster { top, bounds: [w, s, e, n], .. } = *caster(k);
                bounds = [bounds[0].min(w), bounds[1].min(s), bounds[2].max(e), bounds[3].max(n)];
                (max_top, least) = (max_top.max(top), least.min(begin));
                cast.begun.push((k, begin));
            }
            if cast.begun.len() > first {
                cast.blocks.push(CastBlock { begun: first..cast.begun.len(), bounds, max_top, begin: least });
            }
        }
        cast
    }

    pub(super) fn blocks(&self) -> &[CastBlock] {
        &self.blocks
    }

    /// Returns all casters, of which some are cast.
    pub(super) fn all(&self) -> &'a Casters {
        self.all
    }

    /// Returns the casters of a block, highest first, each with the begin of its shadow. Another
    /// caster hides nearer receivers anyway. The begin is a factor of the distance of the near
    /// edges from the UAV.
    #[inline(always)]
    pub(super) fn of_block(&self, block: &CastBlock) -> impl Iterator<Item = (&'a Caster, f64)> {
        self.begun[block.begun.clone()].iter().map(|(k, begin)| (&self.all.all()[*k as usize], *begin))
    }
}

/// Returns `true` if the shadows of blocks on receivers at a height are long.
fn are_long(blocks: &[&CasterBlock], plane: &Plane, z: i64) -> bool {
    let uav = plane.uav;
    let most = as_f64(plane.rows.1 - plane.rows.0);
    let rows_and_casters = blocks.iter().map(|block| {
        let distance = as_f64(distance_squared(block.bounds, (uav.x, uav.y))).sqrt();
        let rows = plane
            .reach(block.bounds, block.max_top, z)
            .map_or(0.0, |reach| reach.behind(distance) * plane.rows_per_step);
        let n_casters = as_f64(block.numbers().len());
        (rows.min(most) * n_casters, n_casters)
    });
    let (rows, casters) = rows_and_casters.fold((0.0, 0.0), |sum, of| (sum.0 + of.0, sum.1 + of.1));
    rows >= LONG * casters
}

/// Returns the sector of a block, and its distance from the UAV.
fn outward(block: &CasterBlock, uav: LatticePoint) -> (u32, u64) {
    let [west, south, east, north] = block.bounds.map(i64::from);
    let turn = bearing(west + east - 2 * uav.x, south + north - 2 * uav.y) / FULL_TURN;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 for no number")]
    let sector = (turn * SECTORS) as u32;
    (sector, distance_squared(block.bounds, (uav.x, uav.y)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_field::Prisms;
    use fearless_simd::Level;

    use crate::los::{ShadowGrid, ShadowScene};
    use crate::raster::BitGrid;

    const M: i64 = 1024;

    /// Scene: a town of 2 km with 2500 blocks, on a lattice whose lines the receivers and the UAV
    /// lie beside or on.
    #[test]
    fn over_a_town_most_casters_are_left_out_or_begin_late() {
        let corner = |k: i32| k * 40 * 1024;
        let prisms = Prisms::new((0..2500).map(|k| {
            let (west, south, size) = (corner(k % 50), corner(k / 50), 1024 * (12 + k * k % 17));
            let ring = [[west, south], [west + size, south], [west + size, south + size], [west, south + size]];
            (ring, 1024 * (5 + k * 7919 % 31), 0)
        }));
        let casters = prisms.casters();
        // On flat ground, and on hills with roofs.
        for ((x, y, z), offset, range) in [
            ((999, 1003, 50), M / 2, (1536, 1536)),
            ((37, 0, 45), 0, (1536, 1536)),
            ((1010, 990, 50), M / 2, (0, 23 * M)),
        ] {
            let places = || (0..2000).map(|k| k * M + offset);
            let grid = ShadowGrid::new(places().collect(), places().rev().collect());
            let uav = LatticePoint { x: x * M, y: y * M, z: z * M };
            let (wanted, level) = (BitGrid::full(2000, 2000), Level::new());
            let scene = ShadowScene { prisms: &prisms, casters, grid: &grid, wanted: &wanted, level, n_bands: 1 };
            let plane = scene.plane(&wanted, uav).expect("wanted");
            let cast = Cast::new(casters, &plane, range);
            let late = cast.begun.iter().filter(|(_, begin)| *begin > 1.01).count();
            assert!(cast.begun.len() < 2200 && late > cast.begun.len() / 20, "{} {late}", cast.begun.len());
            let order: Vec<_> = cast.blocks.iter().map(|block| cast.begun[block.begun.start].0).collect();
            assert!(order.windows(2).any(|pair| pair[0] > pair[1]), "not as they are stored");
            // Nothing is known of receivers above the UAV.
            assert_eq!(Cast::new(casters, &plane, (range.0, uav.z)).begun.len(), casters.all().len());
        }
    }
}
